/* resume.c - goes on with the snapshots of an earlier run, after a restart. */
#include "results/hdf5.h"
#include "results/output.h"
#if defined(PETSC_HAVE_HDF5)

/* Returns the number of particles of a snapshot, or -1 if its file is not there, cannot be read, or has another state. */
static PetscInt ParticlesIn(const char path[], PetscInt step, PetscInt64 digest)
{
  const hid_t file = MPMHDF5Open(path);
  char        name[MPM_NAME_LEN], right[MPM_NAME_LEN], *has = NULL;
  hid_t       group;
  hsize_t     n    = 0;
  PetscBool   good = PETSC_FALSE;

  if (file < 0) return -1;
  (void)snprintf(name, sizeof name, "step_%06" PetscInt_FMT "/particles/id", step);
  H5E_BEGIN_TRY
  {
    (void)snprintf(right, sizeof right, "/step_%06" PetscInt_FMT, step);
    group = H5Gopen2(file, right, H5P_DEFAULT);
    if (group < 0 || MPMHDF5ReadText(group, "digest", &has)) has = NULL;
    (void)H5Gclose(group);
    (void)snprintf(right, sizeof right, "%016llx", (unsigned long long)digest);
  }
  H5E_END_TRY
  H5E_BEGIN_TRY
  {
    const hid_t set = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(set);

    if (H5Sget_simple_extent_ndims(space) == 1 && H5Sget_simple_extent_dims(space, &n, NULL) >= 0) good = PETSC_TRUE;
    (void)H5Sclose(space);
    (void)H5Dclose(set);
    (void)H5Fclose(file);
  }
  H5E_END_TRY
  if (!has || strcmp(has, right)) good = PETSC_FALSE;
  (void)PetscFree(has);
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
  PetscCall(PetscRealloc((size_t)(out->count / 64 + 1) * 64 * sizeof *out->digests, &out->digests));
  PetscCall(PetscRealloc((size_t)(out->count / 64 + 1) * 64 * sizeof *out->steps, &out->steps));
  PetscCall(PetscRealloc((size_t)(out->count / 64 + 1) * 64 * sizeof *out->times, &out->times));
  if (!rank) {
    MPMOutputClear(out, scene, PETSC_TRUE);
    for (PetscInt k = 0; k < out->count; k++) {
      MPMSnapshotPath(out, scene, out->steps[k], PETSC_FALSE, path);
      out->n[k] = ParticlesIn(path, out->steps[k], out->digests[k]);
      if (out->n[k] < 0 && !lost++) (void)snprintf(missing, sizeof missing, "%s", path);
    }
  }
  PetscCallMPI(MPI_Bcast(out->n, (PetscMPIInt)out->count, MPIU_INT, 0, core->exchange.data));
  for (PetscInt k = 0; k < out->count; k++) {
    if (out->n[k] < 0) continue;
    out->digests[here] = out->digests[k];
    out->steps[here]   = out->steps[k];
    out->times[here]   = out->times[k];
    out->n[here++]     = out->n[k];
  }
  out->count = here;
  if (lost)
    PetscCall(MPMWarn(
        &core->print,
        "%" PetscInt_FMT
        " earlier snapshots are missing, cannot be read or are of another run, the first is %s: the results go on "
        "without them",
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
