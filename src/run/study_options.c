/* study_options.c - reads the options of a study, with those of its scene. */
#include "run/study.h"

/* Reads -study_*; the first fault is left in o. */
PetscErrorCode MPMStudySetFromOptions(MPM mpm, MPMOptions o)
{
  MPMStudy *study = &mpm->study;
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "study_type", NULL, study->type, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!strcmp(study->type, "none")) {
    study->type[0] = 0;
    if (mpm->scene.finest)
      MPMOptionsFail(o, "-reference_type finest does not apply: it is the last run of a -study_type");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!strcmp(study->type, "stability")) {
    PetscCall(MPMStabilitySetFromOptions(mpm, o));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  study->order_min = PETSC_MIN_REAL;
  PetscCall(MPMOptionsInt(o, "study_levels", NULL, &study->levels, NULL));
  PetscCall(MPMOptionsEnum(o, "study_vary", NULL, study->vary, NULL));
  PetscCall(MPMOptionsReal(o, "study_order_min", NULL, &study->order_min, &set));
  if (!mpm->scene.known && !mpm->scene.finest)
    MPMOptionsFail(
        o, "-study_type %s needs a solution to compare with: -mms_type, or -reference_type (finest: the last run)",
        study->type);
  if (mpm->time.max_steps != PETSC_MAX_INT)
    MPMOptionsFail(o, "-time_max_steps does not apply: the runs of a study end at the same time, -time_end");
  if (mpm->scene.finest && set && study->levels < 3)
    MPMOptionsFail(o,
                   "-study_levels %" PetscInt_FMT " leaves no order for -study_order_min where the finest run is the "
                   "reference; it needs 3",
                   study->levels);
  if (mpm->scene.finest && !strcmp(study->vary, "ppc"))
    MPMOptionsFail(o, "-study_vary ppc does not apply: -reference_type finest compares grids and time steps");
  PetscFunctionReturn(PETSC_SUCCESS);
}
