/* study.c - which study a scene asks for. The studies are in study_<type>.c; what they share is in study.h. */
#include "run/study_work.h"

/* Runs the study of a scene whose options are read; the scene itself is not set up. *status is that of the program.
   Collective on core.comm. */
PetscErrorCode MPMStudyRun(MPM mpm, int *status)
{
  PetscFunctionBeginUser;
  *status = MPM_EXIT_OK;
  if (!strcmp(mpm->study.type, "workprecision"))
    PetscCall(MPMStudyWorkPrecision(mpm, status));
  else if (!strcmp(mpm->study.type, "stability"))
    PetscCall(MPMStudyStability(mpm, status));
  else
    PetscCall(MPMStudyConvergence(mpm, status));
  PetscFunctionReturn(PETSC_SUCCESS);
}
