/* stages_read.c - reads what belongs to the stages of a run, before its first step, and refuses what may not change in one. */
#include <strings.h>
#include "restart/restart.h"

PetscErrorCode MPMStagesSetFromOptions(const MPMScene *scene, MPMOptions o)
{
  PetscBool   given;
  char       *text, name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN];
  const char *why;

  PetscFunctionBeginUser;
  if (!scene->nstages) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt s = 0; s < scene->nstages; s++) {
    PetscReal time;

    PetscCall(MPMOptionsReal(o, "stage_<s>_time", scene->stages[s], &time, NULL));
  }
  PetscCall(MPMOptionsText(&text));
  given = MPMOptionsFindIn(text, "-time_end", value);
  if (given) MPMOptionsFail(o, "-time_end does not apply with -stages: each lasts -stage_<s>_time");
  for (const char *at = text; MPMOptionsNext(&at, name, value) && !MPMOptionsError(o);) {
    const char         *option;
    const PetscInt      k   = MPMStageOf(scene->nstages, scene->stages, name + 1, &option);
    const MPMOptionRow *row = k < 0 ? NULL : MPMOptionsRow(o, option);

    if (!row || !strcasecmp(option, "time")) continue;
    if (!strcasecmp(option, "time_end"))
      MPMOptionsFail(o, "%s does not apply: a stage lasts -stage_%s_time", name, scene->stages[k]);
    if (!strcasecmp(option, "remove") && !k)
      MPMOptionsFail(o, "%s does not apply: nothing can leave before the first stage; leave the body out of -bodies", name);
    why = MPMRestartNotInStage(row->name);
    if (why) MPMOptionsFail(o, "%s: -%s may not change in a stage%s; give -%s", name, option, why, option);
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}
