/* main.c - the program: it reads the options, sets up a run or a study, and runs it. Its exit status says how it
   ended. */
#include <signal.h>
#include "run/mpm.h"

static PetscErrorCode Run(int *status)
{
  MPM        mpm;
  MPMOptions options;

  PetscFunctionBeginUser;
  PetscCall(MPMCreate(PETSC_COMM_WORLD, &mpm));
  PetscCall(MPMOptionsCreate(&MPMOptionTable, &options));
  PetscCall(MPMSetFromOptions(mpm, options));
  if (!MPMOptionsError(options)) PetscCall(MPMNotes(mpm));
  if (MPMOptionsError(options)) {
    PetscCall(PetscFPrintf(mpm->core.comm, stderr, "%s\n", MPMOptionsError(options)));
    *status = MPM_EXIT_INPUT;
  } else if (mpm->study.type[0]) {
    PetscCall(MPMStudyRun(mpm, status));
  } else {
    PetscCall(MPMSetUp(mpm));
    PetscCall(MPMRun(mpm));
    *status = mpm->core.stop[0] ? MPM_EXIT_STOPPED : MPM_EXIT_OK;
  }
  PetscCall(MPMOptionsDestroy(&options));
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  int       status;
  PetscBool help;

  if (MPMOptionsStart(&MPMOptionTable, argc, argv, &status)) return status;
  PetscCall(PetscPushErrorHandler(MPMOptionsStartFault, NULL));
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  MPMOptionsStarted();
  (void)signal(SIGPIPE, SIG_DFL); /* so that `pebble ... | head` prints no error */
  PetscCall(PetscOptionsHasHelp(NULL, &help));
  if (!help) PetscCall(Run(&status));
  PetscCall(PetscFinalize());
  return status;
}
