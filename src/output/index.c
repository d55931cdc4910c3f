/* index.c - the file <name>.h5, by which all snapshots of a run are read as one: it has the provenance of the run and a
   link /step_000123 to the group of this name in each file of a snapshot. It is written anew for new snapshots. */
#include "output/hdf5.h"
#include "output/output.h"
#include "output/provenance.h"
#if defined(PETSC_HAVE_HDF5)

PetscErrorCode MPMProvenanceWrite(const MPMCore *core, const MPMScene *scene, hid_t file, size_t *room)
{
  char        text[MPM_TEXT_LEN], *options;
  unsigned    major, minor, release;
  int         length = 0;
  PetscMPIInt size;
  char        mpi[MPI_MAX_LIBRARY_VERSION_STRING];
  long long   cells[3];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsText(&options));
  if (room) *room = 8192 + strlen(options) + strlen(MPMVersionFlags) + strlen(MPMVersionCompiler);
  if (file < 0) {
    PetscCall(PetscFree(options));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
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

PetscErrorCode MPMIndexWrite(const MPMOutput *out, const MPMCore *core, const MPMScene *scene, char fault[MPM_TEXT_LEN])
{
  char        path[2 * MPM_TEXT_LEN], name[MPM_NAME_LEN];
  PetscMPIInt rank;
  MPMFile     file;

  PetscFunctionBeginUser;
  fault[0] = 0;
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(path, sizeof path, "%s/%s.h5", out->dir, scene->name);
  PetscCall(MPMFileCreate(&file, PETSC_COMM_SELF, path, 4096));
  PetscCall(MPMProvenanceWrite(core, scene, file.file, NULL));
  for (PetscInt k = 0; k < out->count; k++) {
    (void)snprintf(name, sizeof name, "/step_%06" PetscInt_FMT, out->steps[k]);
    MPMSnapshotPath(out, scene, out->steps[k], PETSC_TRUE, path);
    H5(H5Lcreate_external(path, name, file.file, name, H5P_DEFAULT, H5P_DEFAULT));
  }
  PetscCall(MPMFileLay(&file));
  PetscCall(MPMFileClose(&file, PETSC_FALSE, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number of particles of a snapshot, or -1 if its file is not there or cannot be read. */
static PetscInt ParticlesIn(const char path[], PetscInt step)
{
  const hid_t file = MPMHDF5Open(path);
  char        name[MPM_NAME_LEN];
  hsize_t     n    = 0;
  PetscBool   good = PETSC_FALSE;

  if (file < 0) return -1;
  (void)snprintf(name, sizeof name, "step_%06" PetscInt_FMT "/particles/id", step);
  H5E_BEGIN_TRY
  {
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(set);

    if (H5Sget_simple_extent_ndims(space) == 1 && H5Sget_simple_extent_dims(space, &n, NULL) >= 0) good = PETSC_TRUE;
    (void)H5Sclose(space);
    (void)H5Dclose(set);
    (void)H5Fclose(file);
  }
  H5E_END_TRY
  return good ? (PetscInt)n : -1;
}

PetscErrorCode MPMOutputResume(MPMOutput *out, MPMCore *core, const MPMScene *scene)
{
  char        path[2 * MPM_TEXT_LEN], missing[2 * MPM_TEXT_LEN] = "";
  PetscInt    lost = 0, here = 0;
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  out->begun = PETSC_TRUE;
  if (!out->enabled) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  PetscCall(PetscRealloc((size_t)(out->count / 64 + 1) * 64 * sizeof *out->n, &out->n)); /* as MPMOutputStep has it */
  PetscCall(PetscRealloc((size_t)(out->count / 64 + 1) * 64 * sizeof *out->steps, &out->steps));
  PetscCall(PetscRealloc((size_t)(out->count / 64 + 1) * 64 * sizeof *out->times, &out->times));
  if (!rank) {
    MPMOutputClear(out, scene, PETSC_TRUE);
    for (PetscInt k = 0; k < out->count; k++) {
      MPMSnapshotPath(out, scene, out->steps[k], PETSC_FALSE, path);
      out->n[k] = ParticlesIn(path, out->steps[k]);
      if (out->n[k] < 0 && !lost++) (void)snprintf(missing, sizeof missing, "%s", path);
    }
  }
  PetscCallMPI(MPI_Bcast(out->n, (PetscMPIInt)out->count, MPIU_INT, 0, core->exchange.data));
  for (PetscInt k = 0; k < out->count; k++) {
    if (out->n[k] < 0) continue;
    out->steps[here] = out->steps[k];
    out->times[here] = out->times[k];
    out->n[here++]   = out->n[k];
  }
  out->count = here;
  if (lost)
    PetscCall(MPMPrint(&core->print,
                       "warning    %" PetscInt_FMT " earlier snapshots are missing or cannot be read, the first is %s: "
                       "the results go on without them\n",
                       lost, missing));
  out->joined = -1;
  PetscCall(MPMOutputFinish(out, core, scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else

PetscErrorCode MPMOutputResume(MPMOutput *out, MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  (void)core;
  (void)scene;
  out->begun = PETSC_TRUE; /* without HDF5 there are no snapshots */
  PetscFunctionReturn(PETSC_SUCCESS);
}

#endif
