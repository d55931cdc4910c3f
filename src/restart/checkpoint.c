/* checkpoint.c - the file of a checkpoint. It is an HDF5 file,

   /run         datasets and texts: what the run keeps beside its particles (MPMVariable)
   /nodes       in the total frame: state [z][y][x][2 dim], displacements and velocities of the nodes
   /particles   a dataset [N] or [N][components] for each field of the state, in double or as 64-bit integers, in any
                sequence of particles

   with 512 bytes before it (a "user block", which HDF5 skips) that say how long the file is and give its checksum. It gets
   its name when all of it is on the disk (hdf5.h): at every moment there is a whole checkpoint, whatever is killed. No
   function of HDF5 sees a file whose checksum is wrong. */
#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include "base/fault.h"
#include "restart/checkpoint.h"
#include "results/hdf5.h"
#include "results/provenance.h"
#include "results/rows.h"

#define HEAD   512                     /* bytes of the user block */
#define FORMAT "pebble checkpoint 1\n" /* its first line; a program that reads other files has another number */

PetscBool MPMCheckpointHasField(PetscInt field)
{
  return MPMFields[field].home != MPM_SCRATCH && field != MPM_FIELD_INDEX_cell;
}

PetscBool MPMCheckpointIs(const char path[])
{
  static const char start[] = "pebble checkpoint ";
  char              head[sizeof start - 1];
  const int         file = open(path, O_RDONLY);
  PetscBool         is;

  if (file < 0) return PETSC_FALSE;
  is = pread(file, head, sizeof head, 0) == (ssize_t)sizeof head && !memcmp(head, start, sizeof head);
  (void)close(file);
  return is;
}

/* Returns the numbers of 8 bytes that a row of a field has in the file. Not collective. */
PetscInt MPMCheckpointNumbers(const MPMParticles *particles, PetscInt field)
{
  return MPMFields[field].type == PETSC_INT ? particles->bytes[field] / (PetscInt)sizeof(PetscInt)
                                            : particles->bytes[field] / 8;
}

/* --- Checking ----------------------------------------------------------------------------------------------------- */

/* Sets head [HEAD] to what the user block of a whole file is. */
static void MakeHead(char head[HEAD], size_t bytes, uint64_t sum)
{
  memset(head, 0, HEAD);
  (void)snprintf(head, HEAD, FORMAT "bytes %020zu\nchecksum %016llx\n", bytes, (unsigned long long)sum);
}

/* Sets fault to why a file cannot be read as a checkpoint, or to "" if it is a whole one. Each process reads a part of
   it. Collective on comm. */
PetscErrorCode MPMCheckpointCheck(const char path[], MPI_Comm comm, char fault[MPM_TEXT_LEN])
{
  PetscMPIInt rank, size;
  struct stat s;
  char        head[HEAD], right[HEAD];
  uint64_t    sum  = 0;
  int         file = -1, code;

  PetscFunctionBeginUser;
  fault[0] = 0;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (stat(path, &s))
    MPMFault(fault, "cannot read", path, strerror(errno));
  else if (!S_ISREG(s.st_mode))
    MPMFault(fault, "cannot read", path, "it is not a file");
  else if ((file = open(path, O_RDONLY)) < 0)
    MPMFault(fault, "cannot read", path, strerror(errno));
  else if (s.st_size < HEAD || pread(file, head, HEAD, 0) != HEAD || strncmp(head, "pebble checkpoint ", 18))
    MPMFault(fault, "cannot go on from", path, "it is not a checkpoint, or its start is damaged");
  else if (strncmp(head, FORMAT, strlen(FORMAT)))
    MPMFault(fault, "cannot go on from", path, "it is a checkpoint of another version of pebble");
  PetscCall(MPMFaultAgree(comm, fault));
  if (!fault[0]) {
    const size_t words = ((size_t)s.st_size - HEAD + 7) / 8, share = (words + (size_t)size - 1) / (size_t)size,
                 from = PetscMin((size_t)s.st_size, HEAD + 8 * share * (size_t)rank),
                 to   = PetscMin((size_t)s.st_size, from + 8 * share);

    code = MPMChecksumFile(file, from, to, &sum);
    if (code) MPMFault(fault, "cannot read", path, strerror(code));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm));
  if (!fault[0]) {
    MakeHead(right, (size_t)s.st_size, sum);
    if (memcmp(head, right, HEAD))
      MPMFault(fault, "cannot go on from", path, "it is damaged or cut off: its checksum is wrong");
  }
  if (file >= 0) (void)close(file);
  PetscCall(MPMFaultAgree(comm, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#if defined(PETSC_HAVE_HDF5)

/* --- Writing ------------------------------------------------------------------------------------------------------ */

static PetscBool IsKept(const MPMVariable *v)
{
  return v->uses & MPM_KEPT && v->n && v->at;
}

/* Sets *words to the numbers of exact sums, reduced, which the caller frees. Collective on comm. */
static PetscErrorCode SumWords(const MPMVariable *v, MPI_Comm comm, PetscInt64 **words)
{
  MPMSum *sum;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(v->n, &sum));
  PetscCall(PetscArraycpy(sum, (MPMSum *)v->at, v->n));
  PetscCall(MPMSumReduce(sum, v->n, comm));
  PetscCall(PetscMalloc1(v->n * MPM_SUM_WORDS, words));
  for (PetscInt k = 0; k < v->n; k++) PetscCall(PetscArraycpy(*words + k * MPM_SUM_WORDS, sum[k].word, MPM_SUM_WORDS));
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a variable; words: of exact sums. Returns whether HDF5 could. */
static PetscBool WriteOne(hid_t group, const MPMVariable *v, PetscInt64 *words)
{
  const hsize_t n     = v->type == MPM_VARIABLE_TEXT ? 1 : (hsize_t)v->n * (words ? MPM_SUM_WORDS : 1);
  const hid_t   type  = v->type == MPM_VARIABLE_TEXT   ? H5Tcopy(H5T_C_S1)
                        : v->type == MPM_VARIABLE_REAL ? H5Tcopy(H5T_IEEE_F64LE)
                                                       : H5Tcopy(H5T_STD_I64LE);
  int64_t      *whole = NULL;
  void         *from  = words ? words : v->at;
  hid_t         space, set;
  PetscBool     good;

  if (v->type == MPM_VARIABLE_TEXT) (void)H5Tset_size(type, strlen(v->at) + 1);
  if (v->type == MPM_VARIABLE_INT || v->type == MPM_VARIABLE_BOOL) {
    from = whole = malloc(n * sizeof *whole);
    for (hsize_t q = 0; whole && q < n; q++)
      whole[q] = v->type == MPM_VARIABLE_INT ? (int64_t)((PetscInt *)v->at)[q] : (int64_t)((PetscBool *)v->at)[q];
  }
  space = H5Screate_simple(1, &n, NULL);
  set   = from ? H5Dcreate2(group, v->name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT) : -1;
  good  = set >= 0 && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, from) >= 0;
  if (set >= 0 && H5Dclose(set) < 0) good = PETSC_FALSE;
  (void)H5Sclose(space);
  (void)H5Tclose(type);
  free(whole);
  return good;
}

/* Writes what the run keeps beside the particles. Collective on comm. */
static PetscErrorCode WriteKept(MPMFile *file, const MPMVariables *kept, MPI_Comm comm)
{
  hid_t group = -1;

  PetscFunctionBeginUser;
  if (file->file >= 0) H5(group = H5Gcreate2(file->file, "run", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  for (PetscInt k = 0; k < kept->n; k++) {
    const MPMVariable *v     = &kept->row[k];
    PetscInt64        *words = NULL;

    if (!IsKept(v)) continue;
    if (v->type == MPM_VARIABLE_SUM) PetscCall(SumWords(v, comm, &words));
    PetscCheck(group < 0 || WriteOne(group, v, words), PETSC_COMM_SELF, PETSC_ERR_LIB, "HDF5 failed to write %s",
               v->name);
    PetscCall(PetscFree(words));
  }
  if (group >= 0) H5(H5Gclose(group));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a dataset for each field of the particles. */
static PetscErrorCode MakeFields(MPMFile *file, const MPMParticles *particles)
{
  hid_t group = -1;

  PetscFunctionBeginUser;
  if (file->file >= 0) H5(group = H5Gcreate2(file->file, "particles", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const PetscInt nc      = MPMCheckpointNumbers(particles, f);
    const hsize_t  size[2] = {(hsize_t)particles->total, (hsize_t)nc};

    if (!particles->present[f] || !MPMCheckpointHasField(f)) continue;
    PetscCall(MPMFileDataset(file, group, MPMFields[f].name, MPMFields[f].unit, NULL,
                             !(MPMFields[f].type == PETSC_REAL), nc > 1 ? 2 : 1, size));
  }
  if (group >= 0) H5(H5Gclose(group));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a dataset for the state of the nodes in the total frame: all that are stored, layers beyond walls too. */
static PetscErrorCode MakeNodes(MPMFile *file, const MPMGrid *grid)
{
  const hsize_t size[4] = {(hsize_t)grid->nodes[2], (hsize_t)grid->nodes[1], (hsize_t)grid->nodes[0],
                           (hsize_t)MPM_MOTION_NC(grid->dim)};
  hid_t         group   = -1;

  PetscFunctionBeginUser;
  if (file->file >= 0) H5(group = H5Gcreate2(file->file, "nodes", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  PetscCall(MPMFileDataset(file, group, "state", "m m/s", NULL, PETSC_FALSE, 4, size));
  if (group >= 0) H5(H5Gclose(group));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes it to dataset `set`. Collective on exchange.data. */
static PetscErrorCode WriteNodes(MPMFile *file, const MPMCore *core, PetscInt set)
{
  const MPMGrid  *grid  = &core->grid;
  const MPMPatch *patch = &core->exchange.patch;
  const PetscInt  nc    = MPM_MOTION_NC(grid->dim);
  PetscInt       *row, at = 0;
  PetscReal      *here, *sorted;
  MPMRows         rows;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(patch->own_n[0] * patch->own_n[1] * patch->own_n[2], &row));
  PetscCall(PetscMalloc1(patch->own_n[0] * patch->own_n[1] * patch->own_n[2] * nc, &here));
  MPM_FOR_OWN_ROWS(patch, r)
  for (PetscInt i = patch->own_lo[0] - patch->lo[0], n = 0; n < patch->own_n[0]; n++, at++) {
    row[at] = ((r.ijk[2] + grid->layers[2]) * grid->nodes[1] + r.ijk[1] + grid->layers[1]) * grid->nodes[0] + r.ijk[0] +
              grid->layers[0] + i + n;
    PetscCall(PetscArraycpy(here + at * nc, r.state + (i + n) * nc, nc));
  }
  PetscCall(MPMRowsCreate(core->exchange.data, grid->nodes[0] * grid->nodes[1] * grid->nodes[2], at, row, &rows));
  PetscCall(PetscCalloc1(PetscMax(1, rows.n * nc), &sorted));
  PetscCall(MPMRowsSend(&rows, nc, here, sorted));
  PetscCall(MPMFileWriteWords(file, set, (PetscInt64)rows.first * nc, (PetscInt64)rows.n * nc, sorted));
  PetscCall(PetscSFDestroy(&rows.sf));
  PetscCall(PetscFree(row));
  PetscCall(PetscFree(here));
  PetscCall(PetscFree(sorted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the rows of the particles here, which begin with row `first`, and sets *number to that of the next dataset. */
static PetscErrorCode WriteRows(MPMFile *file, MPMParticles *particles, PetscInt64 first, PetscInt *number)
{
  PetscInt set = 0;

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const PetscInt nc = MPMCheckpointNumbers(particles, f), n = particles->n * nc;
    int64_t       *whole = NULL;
    void          *rows;

    if (!particles->present[f] || !MPMCheckpointHasField(f)) continue;
    PetscCall(MPMParticlesGetField(particles, f, &rows));
    if (MPMFields[f].type == PETSC_INT) {
      PetscCall(PetscMalloc1(n, &whole));
      for (PetscInt k = 0; k < n; k++) whole[k] = ((PetscInt *)rows)[k];
    }
    PetscCall(MPMFileWriteWords(file, set++, first * nc, n, whole ? (void *)whole : rows));
    PetscCall(PetscFree(whole));
    PetscCall(MPMParticlesRestoreField(particles, f));
  }
  *number = set;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a checkpoint of the present state, and sets *bytes to its length. If it cannot be written, fault says why on
   all processes, and no other file is changed. Numbers are those of the first process. Collective on exchange.data. */
PetscErrorCode MPMCheckpointWrite(const char path[], MPMCore *core, const MPMScene *scene, const MPMVariables *kept,
                                  PetscReal *bytes, char fault[MPM_TEXT_LEN])
{
  char       head[HEAD];
  PetscInt64 first, n = core->particles.n;
  PetscInt   rows = 0, set = 0;
  uint64_t   sum;
  size_t     room;
  MPMFile    file;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Scan(&n, &first, 1, MPIU_INT64, MPI_SUM, core->exchange.data));
  for (PetscInt k = 0; k < kept->n; k++) rows += IsKept(&kept->row[k]);
  PetscCall(MPMProvenanceWrite(core, scene, -1, &room));
  PetscCall(MPMFileCreate(&file, core->exchange.data, path, HEAD, room + 640 * (size_t)(rows + MPM_NUM_FIELDS)));
  PetscCall(MPMProvenanceWrite(core, scene, file.file, NULL));
  PetscCall(WriteKept(&file, kept, core->exchange.data));
  PetscCall(MakeFields(&file, &core->particles));
  if (core->grid.total) PetscCall(MakeNodes(&file, &core->grid));
  PetscCall(MPMFileLay(&file));
  PetscCall(WriteRows(&file, &core->particles, first - n, &set));
  if (core->grid.total) PetscCall(WriteNodes(&file, core, set));
  PetscCall(MPMFileSum(&file, HEAD, &sum));
  MakeHead(head, (size_t)file.length, sum);
  *bytes = (PetscReal)file.length;
  if (!file.rank) PetscCall(MPMFileHead(&file, head, HEAD));
  PetscCall(MPMFileClose(&file, PETSC_TRUE, fault));
  PetscCall(MPMFaultAgree(core->exchange.data, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else

PetscErrorCode MPMCheckpointWrite(const char path[], MPMCore *core, const MPMScene *scene, const MPMVariables *kept,
                                  PetscReal *bytes, char fault[MPM_TEXT_LEN])
{
  PetscFunctionBeginUser;
  *bytes = 0;
  MPMFault(fault, "cannot write", path, "checkpoints need a PETSc with HDF5");
  PetscFunctionReturn(PETSC_SUCCESS);
}

#endif
