/* index.c - the file <name>.h5, by which all snapshots of a run are read as one: it has the provenance of the run and a
   link /step_000123 to the group of this name in each file of a snapshot. It is written anew for new snapshots. */
#include "results/hdf5.h"
#include "results/output.h"
#include "results/provenance.h"
#if defined(PETSC_HAVE_HDF5)

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
  PetscCall(MPMFileCreate(&file, PETSC_COMM_SELF, path, 0, 4096));
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

#else
typedef int MPMIndexNothing; /* a file must not be empty */
#endif
