/* checkpoint.c - the file of a checkpoint. It is an HDF5 file,

   /run         datasets and texts: what the run keeps beside its particles (MPMKept)
   /particles   a dataset [N] or [N][components] for each field of the state, in double or as 64-bit integers, in any
                sequence of particles

   with 512 bytes before it (a "user block", which HDF5 skips) that say how long the file is and give its checksum. The
   first process makes the HDF5 file, with room for the particles; each process then writes its rows into that room, by
   plain writes. The file is written under a temporary name, and renamed when all of it is on the disk: at every moment
   there is a whole checkpoint, whatever is killed. No function of HDF5 sees a file whose checksum is wrong. */
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <sys/stat.h>
#include <unistd.h>
#include "base/checksum.h"
#include "base/fault.h"
#include "output/checkpoint.h"
#include "output/hdf5.h"

#define HEAD   512                     /* bytes of the user block */
#define FORMAT "pebble checkpoint 1\n" /* its first line; a program that reads other files has another number */

PetscBool MPMCheckpointHasField(PetscInt field)
{
  return MPMFields[field].home != MPM_SCRATCH && field != MPM_FIELD_INDEX_cell ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the numbers of 8 bytes that a row of a field has in the file. Not collective. */
PetscInt MPMCheckpointNumbers(const MPMParticles *particles, PetscInt field)
{
  return MPMFields[field].type == PETSC_INT ? particles->bytes[field] / (PetscInt)sizeof(PetscInt)
                                            : particles->bytes[field] / 8;
}

/* Writes all bytes at an offset; returns 0 or errno. */
static int WriteAll(int file, const void *data, size_t bytes, size_t offset)
{
  const char *from = (const char *)data;

  while (bytes) {
    const ssize_t n = pwrite(file, from, PetscMin(bytes, (size_t)1 << 28), (off_t)offset);

    if (n < 0 && errno != EINTR) return errno;
    if (n < 0) continue;
    from += n;
    offset += (size_t)n;
    bytes -= (size_t)n;
  }
  return 0;
}

/* Reads all bytes at an offset; returns 0 or errno. */
static int ReadAll(int file, void *data, size_t bytes, size_t offset)
{
  char *to = (char *)data;

  while (bytes) {
    const ssize_t n = pread(file, to, PetscMin(bytes, (size_t)1 << 28), (off_t)offset);

    if (n < 0 && errno != EINTR) return errno;
    if (n == 0) return EIO; /* shorter than it was */
    if (n < 0) continue;
    to += n;
    offset += (size_t)n;
    bytes -= (size_t)n;
  }
  return 0;
}

/* Adds the checksum of a part of a file; returns 0 or errno. */
static int SumPart(int file, size_t from, size_t to, uint64_t *sum)
{
  const size_t most = 1 << 20;
  char        *part = malloc(most);
  int          code = part ? 0 : ENOMEM;

  for (size_t n; from < to && !code; from += n) {
    n    = PetscMin(most, to - from);
    code = ReadAll(file, part, n, from);
    if (!code) *sum += MPMChecksum(part, n, from);
  }
  free(part);
  return code;
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
  else if (s.st_size < HEAD || ReadAll(file, head, HEAD, 0) || strncmp(head, "pebble checkpoint ", 18))
    MPMFault(fault, "cannot go on from", path, "it is not a checkpoint, or its start is damaged");
  else if (strncmp(head, FORMAT, strlen(FORMAT)))
    MPMFault(fault, "cannot go on from", path, "it is a checkpoint of another version of pebble");
  PetscCall(MPMFaultAgree(comm, fault));
  if (!fault[0]) {
    const size_t words = ((size_t)s.st_size - HEAD + 7) / 8, share = (words + (size_t)size - 1) / (size_t)size,
                 from = PetscMin((size_t)s.st_size, HEAD + 8 * share * (size_t)rank),
                 to   = PetscMin((size_t)s.st_size, from + 8 * share);

    code = SumPart(file, from, to, &sum);
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

/* Where the rows of a field lie in the file. */
typedef struct {
  size_t   offset, bytes; /* of all rows */
  PetscInt nc;            /* numbers of a row */
} Room;

/* Writes what the run keeps beside the particles; returns whether HDF5 could. */
static PetscBool WriteKept(hid_t group, PetscInt nkept, const MPMKept kept[])
{
  for (PetscInt k = 0; k < nkept; k++) {
    const hsize_t n     = kept[k].type == MPM_KEPT_TEXT ? 1 : (hsize_t)kept[k].n;
    const hid_t   type  = kept[k].type == MPM_KEPT_TEXT   ? H5Tcopy(H5T_C_S1)
                          : kept[k].type == MPM_KEPT_REAL ? H5Tcopy(H5T_IEEE_F64LE)
                                                          : H5Tcopy(H5T_STD_I64LE);
    int64_t      *whole = NULL;
    void         *from  = kept[k].at;
    hid_t         space, set;
    PetscBool     good;

    if (!n) {
      (void)H5Tclose(type);
      continue;
    }
    if (kept[k].type == MPM_KEPT_TEXT) (void)H5Tset_size(type, strlen(kept[k].at) + 1);
    if (kept[k].type == MPM_KEPT_INT || kept[k].type == MPM_KEPT_BOOL) {
      from = whole = malloc(n * sizeof *whole);
      for (hsize_t q = 0; whole && q < n; q++)
        whole[q] = kept[k].type == MPM_KEPT_INT ? (int64_t)((PetscInt *)kept[k].at)[q]
                                                : (int64_t)((PetscBool *)kept[k].at)[q];
    }
    space = H5Screate_simple(1, &n, NULL);
    set   = from ? H5Dcreate2(group, kept[k].name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT) : -1;
    good  = set >= 0 && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, from) >= 0 ? PETSC_TRUE : PETSC_FALSE;
    if (set >= 0 && H5Dclose(set) < 0) good = PETSC_FALSE;
    (void)H5Sclose(space);
    (void)H5Tclose(type);
    free(whole);
    if (!good) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Makes the room for the rows of each field; returns whether HDF5 could. */
static PetscBool MakeRooms(hid_t group, const MPMParticles *particles, Room room[])
{
  const hid_t create = H5Pcreate(H5P_DATASET_CREATE);
  PetscBool   good   = PETSC_TRUE;

  (void)H5Pset_alloc_time(create, H5D_ALLOC_TIME_EARLY);
  (void)H5Pset_fill_time(create, H5D_FILL_TIME_NEVER);
  for (PetscInt f = 0; f < MPM_NUM_FIELDS && good; f++) {
    hsize_t n[2];
    hid_t   space, set;

    room[f].nc = 0;
    if (!particles->present[f] || !MPMCheckpointHasField(f)) continue;
    room[f].nc = MPMCheckpointNumbers(particles, f);
    n[0]       = (hsize_t)particles->total;
    n[1]       = (hsize_t)room[f].nc;
    space      = H5Screate_simple(n[1] > 1 ? 2 : 1, n, NULL);
    set  = H5Dcreate2(group, MPMFields[f].name, MPMFields[f].type == PETSC_REAL ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64,
                      space, H5P_DEFAULT, create, H5P_DEFAULT);
    good = set >= 0 && H5Dget_offset(set) != HADDR_UNDEF ? PETSC_TRUE : PETSC_FALSE;
    room[f].offset = good ? (size_t)H5Dget_offset(set) : 0;
    room[f].bytes  = (size_t)n[0] * (size_t)n[1] * 8;
    if (set >= 0) (void)H5Dclose(set);
    (void)H5Sclose(space);
  }
  (void)H5Pclose(create);
  return good;
}

/* Makes the HDF5 file with all but the rows of particles. Only the first process calls it. */
static void MakeFile(const char path[], const MPMParticles *particles, PetscInt nkept, const MPMKept kept[],
                     Room room[], char fault[MPM_TEXT_LEN])
{
  hid_t     create, access, file, group;
  PetscBool good;

  /* HDF5 says nothing of the reason if the disk is full; a plain file says it. */
  const int plain = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);

  if (plain < 0 || close(plain)) {
    MPMFault(fault, "cannot write", path, strerror(errno));
    return;
  }
  create = H5Pcreate(H5P_FILE_CREATE);
  access = H5Pcreate(H5P_FILE_ACCESS);
  (void)H5Pset_userblock(create, HEAD);
  (void)H5Pset_alignment(access, 1, 8); /* so that words of the checksum are numbers */
  errno = 0;
  file  = H5Fcreate(path, H5F_ACC_TRUNC, create, access);
  good  = file >= 0 ? PETSC_TRUE : PETSC_FALSE;
  if (good) {
    group = H5Gcreate2(file, "run", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    good  = group >= 0 ? WriteKept(group, nkept, kept) : PETSC_FALSE;
    (void)H5Gclose(group);
    group = H5Gcreate2(file, "particles", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    good  = group >= 0 && good ? MakeRooms(group, particles, room) : PETSC_FALSE;
    (void)H5Gclose(group);
    if (H5Fclose(file) < 0) good = PETSC_FALSE;
  }
  (void)H5Pclose(access);
  (void)H5Pclose(create);
  if (!good) MPMFault(fault, "cannot write", path, errno ? strerror(errno) : "HDF5 failed");
}

/* Writes the rows of this process and adds their checksum; returns 0 or errno. */
static PetscErrorCode WriteRows(int file, MPMParticles *particles, PetscInt64 first, const Room room[], uint64_t *sum,
                                int *code)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS && !*code; f++) {
    const size_t bytes  = (size_t)particles->n * (size_t)room[f].nc * 8,
                 offset = room[f].offset + (size_t)first * (size_t)room[f].nc * 8;
    int64_t *whole      = NULL;
    void    *rows;

    if (!room[f].nc || !particles->n) continue;
    PetscCall(MPMParticlesGetField(particles, f, &rows));
    if (MPMFields[f].type == PETSC_INT) {
      const PetscInt *from = (const PetscInt *)rows;

      PetscCall(PetscMalloc1(bytes / 8, &whole));
      for (size_t k = 0; k < bytes / 8; k++) whole[k] = from[k];
    }
    *code = WriteAll(file, whole ? (void *)whole : rows, bytes, offset);
    *sum += MPMChecksum(whole ? (void *)whole : rows, bytes, offset);
    PetscCall(PetscFree(whole));
    PetscCall(MPMParticlesRestoreField(particles, f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the checksum of what lies between the rows of particles, from byte HEAD to the file's end; sets *bytes to its
   length. Returns 0 or errno. */
static int SumRest(int file, const Room room[], size_t *bytes, uint64_t *sum)
{
  struct stat s;
  size_t      at   = HEAD;
  int         code = fstat(file, &s) ? errno : 0;

  *bytes = code ? 0 : (size_t)s.st_size;
  while (!code && at < *bytes) {
    PetscInt next = -1;

    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
      if (room[f].nc && room[f].offset >= at && (next < 0 || room[f].offset < room[next].offset)) next = f;
    code = SumPart(file, at, next < 0 ? *bytes : room[next].offset, sum);
    at   = next < 0 ? *bytes : room[next].offset + room[next].bytes;
  }
  return code;
}

/* Renames a file that is on the disk, and puts its new name there. Returns 0 or errno. */
static int Rename(const char from[], const char to[])
{
  char copy[2 * MPM_TEXT_LEN];
  int  folder, code;

  (void)snprintf(copy, sizeof copy, "%s", to);
  if (rename(from, to)) return errno;
  folder = open(dirname(copy), O_RDONLY);
  code   = folder < 0 || fsync(folder) ? errno : 0;
  if (folder >= 0) (void)close(folder);
  return code == EINVAL ? 0 : code; /* some file systems have no fsync of folders */
}

/* Writes a checkpoint of the present state, and sets *bytes to its length. If it cannot be written, fault says why, and
   no file is changed or left. kept is that of the first process. Collective on exchange.data. */
PetscErrorCode MPMCheckpointWrite(const char path[], MPMCore *core, PetscInt nkept, const MPMKept kept[],
                                  PetscReal *bytes, char fault[MPM_TEXT_LEN])
{
  const MPI_Comm comm      = core->exchange.data;
  MPMParticles  *particles = &core->particles;
  char           temporary[2 * MPM_TEXT_LEN], head[HEAD];
  Room           room[MPM_NUM_FIELDS] = {{0, 0, 0}};
  PetscMPIInt    rank;
  PetscInt64     first = 0, n = particles->n;
  uint64_t       sum  = 0;
  size_t         size = 0;
  int            file = -1, code = 0;

  PetscFunctionBeginUser;
  fault[0] = 0;
  *bytes   = 0;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Exscan(&n, &first, 1, MPIU_INT64, MPI_SUM, comm));
  if (!rank) first = 0;
  (void)snprintf(temporary, sizeof temporary, "%s.new", path);
  if (!rank) MakeFile(temporary, particles, nkept, kept, room, fault);
  PetscCall(MPMFaultAgree(comm, fault));
  if (!fault[0]) {
    PetscCallMPI(MPI_Bcast(room, (PetscMPIInt)sizeof room, MPI_BYTE, 0, comm));
    file = open(temporary, rank ? O_WRONLY : O_RDWR);
    if (file < 0) code = errno;
    if (!code) PetscCall(WriteRows(file, particles, first, room, &sum, &code));
    if (!code && !rank) code = SumRest(file, room, &size, &sum);
    if (code) MPMFault(fault, "cannot write", path, strerror(code));
    PetscCall(MPMFaultAgree(comm, fault));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm));
  }
  if (!fault[0]) {
    MakeHead(head, size, sum);
    if (!rank) code = WriteAll(file, head, HEAD, 0);
    if (!code && fsync(file)) code = errno;
    if (code) MPMFault(fault, "cannot write", path, strerror(code));
  }
  if (file >= 0 && close(file)) MPMFault(fault, "cannot write", path, strerror(errno));
  PetscCall(MPMFaultAgree(comm, fault));
  if (!rank && !fault[0]) code = Rename(temporary, path);
  if (!rank && code) MPMFault(fault, "cannot write", path, strerror(code));
  if (!rank && fault[0]) (void)unlink(temporary);
  PetscCall(MPMFaultAgree(comm, fault));
  *bytes = (PetscReal)size;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else

PetscErrorCode MPMCheckpointWrite(const char path[], MPMCore *core, PetscInt nkept, const MPMKept kept[],
                                  PetscReal *bytes, char fault[MPM_TEXT_LEN])
{
  PetscFunctionBeginUser;
  *bytes = 0;
  MPMFault(fault, "cannot write", path, "checkpoints need a PETSc with HDF5");
  PetscFunctionReturn(PETSC_SUCCESS);
}

#endif
