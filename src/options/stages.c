/* stages.c - options of a stage of a run, -stage_<s>_<option>: which stage and which option a name is of. */
#include <strings.h>
#include "options/reader.h"

PetscInt MPMStageOf(PetscInt n, char (*names)[MPM_NAME_LEN], const char given[], const char **option)
{
  PetscInt stage = -1;

  *option = NULL;
  for (PetscInt k = 0; k < n && !strncasecmp(given, "stage_", 6); k++) {
    const size_t length = strlen(names[k]);

    if (strncasecmp(given + 6, names[k], length) || given[6 + length] != '_') continue;
    if (*option && given + 7 + length < *option) continue; /* the longest name counts */
    *option = given + 7 + length;
    stage   = k;
  }
  return stage;
}

void MPMOptionsDeclareStages(MPMOptions o, PetscInt ns, char (*stages)[MPM_NAME_LEN])
{
  o->ns     = ns;
  o->stages = stages;
}

const char *MPMOptionsOfStage(MPMOptions o, const char given[])
{
  const char *option;

  (void)MPMStageOf(o->ns, o->stages, given, &option);
  return option;
}

PetscBool MPMOptionsRefuseOfStage(MPMOptions o, const char given[], const char nearest[])
{
  const char *of   = MPMOptionsOfStage(o, given);
  const int   head = of ? (int)(of - given) : 0;

  if (of && nearest[0])
    MPMOptionsFail(o, "-%.*s is not an option of this scene; did you mean -%.*s%s ?", MPM_FULL_LEN, given, head, given,
                   nearest);
  else if (of)
    MPMOptionsFail(o,
                   "-%.*s is not an option of this scene; a stage takes options that may change, such as -%.*sgravity",
                   MPM_FULL_LEN, given, head, given);
  else if (o->nb && !strncasecmp(given, "stage_", 6))
    MPMOptionsFail(o, "-%.*s is not an option of this scene: -stages declares the names of stages%s", MPM_FULL_LEN,
                   given, o->ns ? ", and this one is not among them" : "");
  return of || (o->nb && !strncasecmp(given, "stage_", 6));
}
