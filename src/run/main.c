/* main.c - pebble: it reads the options, sets up a run, and runs it. Its exit status says how it ended. */
#include "run/mpm.h"

static PetscErrorCode Read(MPM mpm, MPMOptions options)
{
  PetscFunctionBeginUser;
  PetscCall(MPMSetFromOptions(mpm, options));
  if (!MPMOptionsError(options) && !mpm->checkpoint.other)
    PetscCall(MPMNotes(&mpm->core, &mpm->scene, &mpm->monitor, &mpm->output, &mpm->report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(MPM mpm, int *status)
{
  PetscFunctionBeginUser;
  PetscCall(MPMSetUp(mpm));
  if (mpm->core.stop[0])
    PetscCall(PetscFPrintf(mpm->core.comm, stderr, "%s\n", mpm->core.stop));
  else
    PetscCall(MPMRun(mpm));
  *status = mpm->core.stop[0] ? (mpm->watch.refused ? MPM_EXIT_INPUT : MPM_EXIT_STOPPED) : MPM_EXIT_OK;
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  return MPMProgram(argc, argv, Read, Run);
}
