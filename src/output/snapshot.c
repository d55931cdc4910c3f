/* snapshot.c - snapshots, which are written between steps: a run has one HDF5 file, with a group for each snapshot.

   /                      attributes: provenance and the grid
   /step_000123           attributes time, step, dt, digest
     particles/id x ...   [N] or [N][nc], one row per particle, sorted by id on every number of processes
     grid/mass v          [nz][ny][nx] and [nz][ny][nx][3], nodes sorted by coordinates
   Vectors have 3 components in every dimension. The file is flushed after each snapshot, and xdmf.c writes the text by
   which ParaView opens it. With a PETSc that has no HDF5, options that ask for snapshots are refused. */
#include <errno.h>
#include <petscsf.h>
#include <sys/stat.h>
#include "output/hdf5.h"
#include "output/output.h"
#include "parallel/exchange.h"
#include "step/step.h"

/* Makes the folder and those that contain it; returns 0 or errno. */
static int MakeFolder(const char dir[])
{
  char        path[MPM_TEXT_LEN];
  struct stat s;

  (void)snprintf(path, sizeof path, "%s", dir);
  for (char *c = path + 1; *c; c++)
    if (*c == '/') {
      *c = 0;
      if (mkdir(path, 0777) && errno != EEXIST) return errno;
      *c = '/';
    }
  if (mkdir(path, 0777) && errno != EEXIST) return errno;
  return !stat(path, &s) && S_ISDIR(s.st_mode) ? 0 : ENOTDIR;
}

/* Lists the words of -output_fields. */
static void ListWords(char text[MPM_TEXT_LEN])
{
  text[0] = 0;
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++)
    if (MPMDiagnostics[f].word[0])
      (void)snprintf(text + strlen(text), MPM_TEXT_LEN - strlen(text), "%s,", MPMDiagnostics[f].word);
  (void)snprintf(text + strlen(text), MPM_TEXT_LEN - strlen(text), "grid");
}

/* Reads -output_fields a,b,...: words of diagnostics.def, and grid. *set says whether it was given. */
static PetscErrorCode ReadFields(MPMOutput *out, const MPMScene *scene, MPMOptions o, PetscBool *set)
{
  char      text[MPM_TEXT_LEN] = "", list[MPM_TEXT_LEN], *save = NULL;
  PetscInt  has = 0; /* fields that a material of the scene carries */
  PetscBool all;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nmaterials; k++) has |= scene->materials[k].state;
  PetscCall(MPMOptionsString(o, "output_fields", NULL, text, set));
  all         = !*set || !strcmp(text, "all") ? PETSC_TRUE : PETSC_FALSE;
  out->fields = all ? MPM_OUTPUT_GRID : 0;
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++)
    if (MPMDiagnosticIsField(f, has) &&
        (!MPMDiagnostics[f].word[0] || (all && !(MPMDiagnostics[f].uses & MPM_SHOW_ASKED))))
      out->fields |= (PetscInt64)1 << f;
  if (all) PetscFunctionReturn(PETSC_SUCCESS);
  for (char *w = strtok_r(text, ", ", &save); w; w = strtok_r(NULL, ", ", &save)) {
    PetscInt f = 0;

    while (f < MPM_NUM_DIAGNOSTICS && strcmp(MPMDiagnostics[f].word, w)) f++;
    ListWords(list);
    if (f == MPM_NUM_DIAGNOSTICS && strcmp(w, "grid"))
      MPMOptionsFail(o, "-output_fields %s: choose among all, or a list of %s", w, list);
    if (f < MPM_NUM_DIAGNOSTICS && !MPMDiagnosticIsField(f, has))
      MPMOptionsFail(o, "-output_fields %s: no material of this scene has it", w);
    out->fields |= f < MPM_NUM_DIAGNOSTICS ? (PetscInt64)1 << f : MPM_OUTPUT_GRID;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the options of snapshots; the first fault is left in o. Not collective. */
PetscErrorCode MPMOutputSetFromOptions(MPMOutput *out, const MPMScene *scene, PetscReal time_end, MPMOptions o)
{
  char      format[MPM_NAME_LEN];
  PetscBool set;

  PetscFunctionBeginUser;
  out->last  = -1;
  out->every = time_end / 20;
  PetscCall(MPMOptionsString(o, "output_dir", NULL, out->dir, NULL));
  PetscCall(MPMOptionsEnum(o, "output_format", NULL, format, NULL));
  PetscCall(MPMOptionsReal(o, "output_every", NULL, &out->every, &set));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  out->enabled = !strcmp(format, "hdf5") ? PETSC_TRUE : PETSC_FALSE;
#if !defined(PETSC_HAVE_HDF5)
  if (out->enabled)
    MPMOptionsFail(o, "-output_format hdf5, the default, needs a PETSc with HDF5, and this one has none; choose none");
#endif
  if (!out->enabled && set && !MPMOptionsOverridden("output_every", "output_format"))
    MPMOptionsFail(o, "-output_every does not apply: -output_format none writes no snapshots");
  PetscCall(ReadFields(out, scene, o, &set));
  if (!out->enabled && set && !MPMOptionsOverridden("output_fields", "output_format"))
    MPMOptionsFail(o, "-output_fields does not apply: -output_format none writes no snapshots");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the folder of the results, and refuses names of files that must not be overwritten. It is called after all
   other checks, so that a refused run leaves no folder. Every process tries. Not collective. */
PetscErrorCode MPMOutputMakeFolder(MPMOutput *out, const MPMScene *scene, MPMOptions o)
{
  static const char *const ends[] = {".csv", "_study.csv", ".h5", ".xdmf"};
  const int                fault  = scene->dry_run ? 0 : MakeFolder(out->dir);

  PetscFunctionBeginUser;
  if (fault) MPMOptionsFail(o, "-output_dir %s: %s", out->dir, strerror(fault));
  for (int k = 0; k < (out->enabled ? 4 : 2); k++) {
    char        path[2 * MPM_TEXT_LEN];
    struct stat s;

    (void)snprintf(path, sizeof path, "%s/%s%s", out->dir, scene->name, ends[k]);
    if (MPMOptionsAreIn(path))
      MPMOptionsFail(o,
                     "-output_name: the results would overwrite the options file %s; give another name or folder "
                     "(-output_dir)",
                     path);
    if (scene->dry_run || stat(path, &s)) continue;
    if (!S_ISREG(s.st_mode)) MPMOptionsFail(o, "-output_name: %s is there and is not a file", path);
    if (k != 1) out->replaced = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- HDF5 ------------------------------------------------------------------------------------------------------ */

#if defined(PETSC_HAVE_HDF5)

/* Replaces each id in row [n] by the number of smaller ids that are there, where particles have been removed. Each
   process counts those of an equal part of all ids that there ever were. Collective on exchange.data. */
static PetscErrorCode NumberRows(MPMCore *core, PetscInt n, PetscInt row[])
{
  const MPI_Comm comm = core->exchange.data;
  PetscInt       first, end, *there, *one, before = 0, count = 0;
  PetscLayout    ids;
  PetscSF        sf;

  PetscFunctionBeginUser;
  PetscCall(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, (PetscInt)core->particles.born, 1, &ids));
  PetscCall(PetscLayoutGetRange(ids, &first, &end));
  PetscCall(PetscSFCreate(comm, &sf));
  PetscCall(PetscSFSetGraphLayout(sf, ids, n, NULL, PETSC_COPY_VALUES, row));
  PetscCall(PetscCalloc1(end - first, &there));
  PetscCall(PetscMalloc1(n, &one));
  for (PetscInt p = 0; p < n; p++) one[p] = 1;
  PetscCall(PetscSFReduceBegin(sf, MPIU_INT, one, there, MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(sf, MPIU_INT, one, there, MPI_REPLACE));
  for (PetscInt k = 0; k < end - first; k++) count += there[k];
  PetscCallMPI(MPI_Scan(&count, &before, 1, MPIU_INT, MPI_SUM, comm));
  before -= count;
  for (PetscInt k = 0; k < end - first; k++) {
    const PetscInt is = there[k];

    there[k] = before;
    before += is;
  }
  PetscCall(PetscSFBcastBegin(sf, MPIU_INT, there, row, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(sf, MPIU_INT, there, row, MPI_REPLACE));
  PetscCall(PetscFree(one));
  PetscCall(PetscFree(there));
  PetscCall(PetscSFDestroy(&sf));
  PetscCall(PetscLayoutDestroy(&ids));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the PetscSF that sends each particle to its row: rows are sorted by id, and each process gets an equal part of
   them. *first, *rows: the first row here, and how many there are. Collective on exchange.data. */
static PetscErrorCode CreateRows(MPMCore *core, PetscSF *sf, PetscInt *first, PetscInt *rows)
{
  const MPI_Comm comm = core->exchange.data;
  PetscLayout    layout;
  PetscInt      *row;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, (PetscInt)core->particles.total, 1, &layout));
  PetscCall(PetscLayoutGetRange(layout, first, rows));
  *rows -= *first;
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(id), &view));
  PetscCall(PetscMalloc1(view.n, &row));
  for (PetscInt p = 0; p < view.n; p++) row[p] = (PetscInt)view.id[p];
  if (core->particles.total < core->particles.born) PetscCall(NumberRows(core, view.n, row));
  PetscCall(PetscSFCreate(comm, sf));
  PetscCall(PetscSFSetGraphLayout(*sf, layout, view.n, NULL, PETSC_COPY_VALUES, row));
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(id), &view));
  PetscCall(PetscFree(row));
  PetscCall(PetscLayoutDestroy(&layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteParticles(MPMOutput *out, MPMCore *core, const MPMScene *scene, hid_t group)
{
  const PetscInt n         = core->particles.n;
  MPMShown       shown     = {core, scene, NULL, NULL, NULL};
  float         *indicator = NULL;
  MPMIndicator   ignored;
  PetscInt       first, rows;
  PetscSF        sf;
  MPMView        view;
  PetscReal     *here, *sorted;

  PetscFunctionBeginUser;
  if (out->fields >> MPM_SHOWS_error_indicator & 1) {
    PetscCall(PetscMalloc1(n, &indicator));
    PetscCall(MPMIndicatorCompute(scene, core, indicator, &ignored));
    shown.indicator = indicator;
  }
  PetscCall(CreateRows(core, &sf, &first, &rows));
  PetscCall(PetscMalloc2(n * MPM_MAX_COMPONENTS, &here, rows * MPM_MAX_COMPONENTS, &sorted));
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++) {
    const MPMDiagnostic *field     = &MPMDiagnostics[f];
    const PetscInt       nc        = field->nc;
    const hsize_t        size[2]   = {(hsize_t)core->particles.total, (hsize_t)nc};
    const hsize_t        offset[2] = {(hsize_t)first, 0}, count[2] = {(hsize_t)rows, (hsize_t)nc};
    MPI_Datatype         unit;

    if (!(out->fields >> f & 1)) continue;
    PetscCall(MPMParticlesGetView(&core->particles, -1, &view));
    for (PetscInt p = 0; p < n; p++) field->fill(&shown, &view, p, here + p * nc);
    PetscCall(MPMParticlesRestoreView(&core->particles, -1, &view));
    PetscCallMPI(MPI_Type_contiguous((PetscMPIInt)nc, MPIU_REAL, &unit));
    PetscCallMPI(MPI_Type_commit(&unit));
    PetscCall(PetscSFReduceBegin(sf, unit, here, sorted, MPI_REPLACE));
    PetscCall(PetscSFReduceEnd(sf, unit, here, sorted, MPI_REPLACE));
    PetscCallMPI(MPI_Type_free(&unit));
    PetscCall(MPMHDF5Dataset(group, field->name, field->unit, field->components, field->whole, nc == 1 ? 1 : 2, size,
                             offset, count, sorted));
  }
  PetscCall(PetscFree2(here, sorted));
  PetscCall(PetscFree(indicator));
  PetscCall(PetscSFDestroy(&sf));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes mass and velocity of the nodes between the walls, for the present state. Collective on the exchange. */
static PetscErrorCode WriteGrid(MPMCore *core, hid_t group)
{
  const MPMGrid  *grid  = &core->grid;
  const MPMPatch *patch = &core->exchange.patch;
  const PetscInt  dim   = grid->dim;
  PetscInt        lo[3], n[3], at = 0;
  hsize_t         size[4], offset[4], count[4];
  PetscReal      *mass, *velocity;

  PetscFunctionBeginUser;
  PetscCall(MPMStepNodes(core));
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt last = d < dim ? grid->cells[d] - grid->periodic[d] : 0,
                   hi   = PetscMin(patch->own_lo[d] + patch->own_n[d], last + 1);

    lo[d]         = PetscMax(patch->own_lo[d], 0);
    n[d]          = PetscMax(0, hi - lo[d]);
    size[2 - d]   = (hsize_t)last + 1;
    offset[2 - d] = (hsize_t)lo[d];
    count[2 - d]  = (hsize_t)n[d];
  }
  size[3] = count[3] = 3;
  offset[3]          = 0;
  PetscCall(PetscCalloc2(n[0] * n[1] * n[2], &mass, 3 * n[0] * n[1] * n[2], &velocity));
  PetscCall(MPMExchangeOpenNodes(core));
  for (PetscInt k = lo[2]; k < lo[2] + n[2]; k++)
    for (PetscInt j = lo[1]; j < lo[1] + n[1]; j++)
      for (PetscInt i = lo[0]; i < lo[0] + n[0]; i++, at++) {
        const PetscInt row  = (k - patch->lo[2]) * patch->n[1] + j - patch->lo[1],
                       node = row * patch->n[0] + i - patch->lo[0];

        if (i - patch->lo[0] < patch->span[row].first || i - patch->lo[0] >= patch->span[row].last) continue;
        mass[at] = patch->node[node].m;
        for (PetscInt d = 0; d < dim; d++) velocity[3 * at + d] = patch->motion[node * MPM_MOTION_NC(dim) + d];
      }
  PetscCall(MPMExchangeCloseNodes(core));
  PetscCall(MPMHDF5Dataset(group, "mass", "kg", "", PETSC_FALSE, 3, size, offset, count, mass));
  PetscCall(MPMHDF5Dataset(group, "v", "m/s", "x y z", PETSC_FALSE, 4, size, offset, count, velocity));
  PetscCall(PetscFree2(mass, velocity));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes what made this file: scene, version, libraries, machine, options, grid. */
static PetscErrorCode WriteProvenance(const MPMCore *core, const MPMScene *scene, hid_t file)
{
  char        text[MPM_TEXT_LEN], *options;
  unsigned    major, minor, release;
  int         length = 0;
  PetscMPIInt size;
  char        mpi[MPI_MAX_LIBRARY_VERSION_STRING];
  long long   cells[3];

  PetscFunctionBeginUser;
  PetscCall(MPMHDF5Text(file, "title", scene->title));
  PetscCall(MPMHDF5Text(file, "scene", scene->name));
  PetscCall(MPMHDF5Int(file, "dim", core->grid.dim));
  PetscCall(MPMHDF5Text(file, "version", "pebble " MPM_VERSION));
  PetscCall(MPMHDF5Text(file, "git", MPMVersionGit));
  PetscCall(MPMHDF5Text(file, "compiler", MPMVersionCompiler));
  PetscCall(MPMHDF5Text(file, "flags", MPMVersionFlags));
  PetscCall(PetscGetVersion(text, sizeof text));
  PetscCall(MPMHDF5Text(file, "petsc_version", text));
  H5(H5get_libversion(&major, &minor, &release));
  (void)snprintf(text, sizeof text, "%u.%u.%u", major, minor, release);
  PetscCall(MPMHDF5Text(file, "hdf5_version", text));
  PetscCallMPI(MPI_Get_library_version(mpi, &length));
  PetscCall(MPMHDF5Text(file, "mpi", mpi));
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCall(MPMHDF5Int(file, "ranks", size));
  PetscCall(PetscGetHostName(text, sizeof text));
  PetscCall(MPMHDF5Text(file, "host", text));
  PetscCall(PetscGetDate(text, sizeof text));
  PetscCall(MPMHDF5Text(file, "date", text));
  PetscCall(MPMOptionsText(&options));
  if (strlen(options) < 60000)
    PetscCall(MPMHDF5Text(file, "options", options)); /* an attribute of HDF5 has 64 KiB at most */
  else
    PetscCall(MPMHDF5LongText(file, "options", options));
  PetscCall(PetscFree(options));
  for (PetscInt d = 0; d < 3; d++) cells[d] = core->grid.cells[d];
  PetscCall(MPMHDF5Attribute(file, "grid_lower", H5T_NATIVE_DOUBLE, 3, core->grid.lower));
  PetscCall(MPMHDF5Attribute(file, "grid_upper", H5T_NATIVE_DOUBLE, 3, core->grid.upper));
  PetscCall(MPMHDF5Attribute(file, "grid_cells", H5T_NATIVE_LLONG, 3, cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode OpenFile(MPMOutput *out, MPMCore *core, const MPMScene *scene)
{
  char  path[2 * MPM_TEXT_LEN];
  hid_t file;

  PetscFunctionBeginUser;
  (void)snprintf(path, sizeof path, "%s/%s.h5", out->dir, scene->name);
  PetscCall(PetscViewerHDF5Open(core->exchange.data, path, FILE_MODE_WRITE, &out->viewer));
  PetscCall(PetscViewerHDF5GetFileId(out->viewer, &file));
  PetscCall(WriteProvenance(core, scene, file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteSnapshot(MPMOutput *out, MPMCore *core, const MPMScene *scene)
{
  char       name[MPM_NAME_LEN];
  PetscInt64 digest;
  hid_t      file, step, group;

  PetscFunctionBeginUser;
  if (!out->viewer) PetscCall(OpenFile(out, core, scene));
  PetscCall(PetscViewerHDF5GetFileId(out->viewer, &file));
  (void)snprintf(name, sizeof name, "step_%06" PetscInt_FMT, core->step);
  H5(step = H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  PetscCall(MPMHDF5Real(step, "time", core->t));
  PetscCall(MPMHDF5Int(step, "step", core->step));
  PetscCall(MPMHDF5Real(step, "dt", core->step ? core->params.dt : 0));
  PetscCall(MPMParticlesDigest(&core->particles, core->exchange.data, &digest));
  (void)snprintf(name, sizeof name, "%016llx", (unsigned long long)digest);
  PetscCall(MPMHDF5Text(step, "digest", name));
  PetscCall(MPMHDF5Text(step, "units", "time and dt in s"));
  H5(group = H5Gcreate2(step, "particles", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  PetscCall(WriteParticles(out, core, scene, group));
  H5(H5Gclose(group));
  if (out->fields & MPM_OUTPUT_GRID) {
    H5(group = H5Gcreate2(step, "grid", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    PetscCall(WriteGrid(core, group));
    H5(H5Gclose(group));
  }
  H5(H5Gclose(step));
  H5(H5Fflush(file, H5F_SCOPE_GLOBAL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else

static PetscErrorCode WriteSnapshot(MPMOutput *out, MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  SETERRQ(core->comm, PETSC_ERR_SUP, "snapshots need a PETSc with HDF5");
}

#endif

/* Writes a snapshot, if one is due or `force` is set. Collective on the exchange. */
PetscErrorCode MPMOutputStep(MPMOutput *out, MPMCore *core, const MPMScene *scene, PetscBool force)
{

  PetscFunctionBeginUser;
  if (!out->enabled || out->last == core->step || !(force || core->t >= out->next)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WriteSnapshot(out, core, scene));
  if (out->count % 64 == 0) {
    PetscCall(PetscRealloc((out->count + 64) * sizeof *out->steps, &out->steps));
    PetscCall(PetscRealloc((out->count + 64) * sizeof *out->times, &out->times));
    PetscCall(PetscRealloc((out->count + 64) * sizeof *out->particles, &out->particles));
  }
  out->particles[out->count] = core->particles.total;
  out->steps[out->count]     = core->step;
  out->times[out->count++]   = core->t;
  if (force || out->count % (1 + out->count / 100) == 0)
    PetscCall(MPMXdmfWrite(out, core, scene)); /* it writes the whole file, so not each time */
  out->last = core->step;
  out->next = MPMNextTime(core->t, out->every);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Closes the file and frees the lists. Collective on the exchange. */
PetscErrorCode MPMOutputDestroy(MPMOutput *out)
{
  PetscFunctionBeginUser;
  PetscCall(PetscViewerDestroy(&out->viewer));
  PetscCall(PetscFree(out->steps));
  PetscCall(PetscFree(out->times));
  PetscCall(PetscFree(out->particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}
