/* pool.c - measures how long the pool's master is busy with a job, and with a byte of it. */
#include "calibrate.h"

/* Times a step of the pool with patches of `cells` cells along each axis. Collective on scene->core.comm. */
PetscErrorCode TimePool(MPM scene, PetscInt cells, MasterTimes *master)
{
  MPM mpm;

  PetscFunctionBeginUser;
  PetscCall(SetRun(scene, "pool",
                   PetscPowReal((PetscReal)scene->core.particles.total / 2e4, 1 / (PetscReal)scene->core.grid.dim),
                   20));
  PetscCall(SetNumber("-pool_cells", "%.0f", (double)cells));
  PetscCall(MakeRun(scene->core.comm, &mpm));
  if (!mpm) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMRun(mpm));
  if (mpm->core.step) {
    Least(&master->busy, mpm->core.exchange.busy / (PetscReal)mpm->core.step);
    master->jobs  = mpm->core.exchange.jobs / (PetscReal)mpm->core.step;
    master->bytes = mpm->core.exchange.bytes / (PetscReal)mpm->core.step;
  }
  PetscCall(MPMDestroy(&mpm));
  PetscCallMPI(MPI_Bcast(master, sizeof *master / sizeof(PetscReal), MPIU_REAL, 0, scene->core.comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the constants of the pool by the times with two sizes of patches. */
void FitPool(const MasterTimes *a, const MasterTimes *b, MPMModel *m)
{
  const PetscReal det = a->jobs * b->bytes - b->jobs * a->bytes;

  if (det == 0) return;
  m->job  = Difference("job", (a->busy * b->bytes - b->busy * a->bytes) / det);
  m->pool = Difference("pool", (a->jobs * b->busy - b->jobs * a->busy) / det);
}
