/* stages_read.c - reads what belongs to the stages of a run, before its first step, and refuses what may not change in one. */
#include <strings.h>
#include "restart/restart.h"

/* Writes why an option of a stage, given by `name`, may not change there; or "". */
static void Forbidden(MPMOptions o, const char name[], const char option[], char why[MPM_TEXT_LEN])
{
  const MPMOptionRow *row   = MPMOptionsRow(o, option);
  const char         *shall = row ? MPMRestartNotInStage(row->name) : NULL;

  why[0] = 0;
  if (shall)
    (void)snprintf(why, MPM_TEXT_LEN, "%.400s: -%.400s may not change in a stage%s; give -%.400s", name, option, shall,
                   option);
}

PetscErrorCode MPMStagesForbidden(const char text[], const char list[], PetscInt stage, MPMOptions o,
                                  char why[MPM_TEXT_LEN])
{
  char(*names)[MPM_NAME_LEN], all[MPM_TEXT_LEN], *save = NULL, name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN];
  const char *option;
  PetscInt    n = 0;

  PetscFunctionBeginUser;
  why[0] = 0;
  (void)snprintf(all, sizeof all, "%s", list);
  PetscCall(PetscMalloc1(strlen(all) / 2 + 1, &names));
  for (char *s = strtok_r(all, ", ", &save); s; s = strtok_r(NULL, ", ", &save))
    (void)snprintf(names[n++], MPM_NAME_LEN, "%s", s);
  for (const char *at = text; !why[0] && MPMOptionsNext(&at, name, value);)
    if (MPMStageOf(n, names, name + 1, &option) == stage - 1) Forbidden(o, name, option, why);
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStagesSetFromOptions(const MPMScene *scene, MPMOptions o)
{
  PetscBool given;
  char     *text, name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN], why[MPM_TEXT_LEN];

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
      MPMOptionsFail(o, "%s does not apply: nothing can leave before the first stage; leave the body out of -bodies",
                     name);
    Forbidden(o, name, option, why);
    if (why[0]) MPMOptionsFail(o, "%s", why);
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}
