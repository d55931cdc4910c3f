/* stages.c - the options of a stage of a run: what the text of all options (options/saved.c) says for it. A stage has
   the options of the one before, with those that -stage_<s>_<option> changes. */
#include <strings.h>
#include "restart/restart.h"

#define OFF "default" /* the value that takes an option away */

typedef struct {
  PetscInt n, room;
  char (*name)[4 * MPM_NAME_LEN], (*value)[MPM_TEXT_LEN];
} List;

/* Returns the number of an option in a list, which is made, with an empty value, if `make` is set and it is not there;
   else -1. */
static PetscErrorCode Find(List *l, const char name[], PetscBool make, PetscInt *k)
{
  PetscFunctionBeginUser;
  for (*k = 0; *k < l->n; ++*k)
    if (!strcasecmp(l->name[*k], name)) PetscFunctionReturn(PETSC_SUCCESS);
  *k = -1;
  if (!make) PetscFunctionReturn(PETSC_SUCCESS);
  if (l->n == l->room) {
    l->room = 2 * l->room + 64;
    PetscCall(PetscRealloc((size_t)l->room * sizeof *l->name, &l->name));
    PetscCall(PetscRealloc((size_t)l->room * sizeof *l->value, &l->value));
  }
  *k = l->n++;
  (void)snprintf(l->name[*k], sizeof l->name[*k], "%s", name);
  l->value[*k][0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Changes the list as a stage says; last: it is the stage that is asked for. option: without its dash. */
static PetscErrorCode Change(List *l, const char option[], const char value[], PetscBool last)
{
  const PetscBool removes = !strcasecmp(option, "remove");
  char            name[4 * MPM_NAME_LEN];
  PetscInt        k;

  PetscFunctionBeginUser;
  if (!strcasecmp(option, "time") || (!last && !strncasecmp(option, "time_", 5))) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(name, sizeof name, "-%s", option);
  PetscCall(Find(l, name, !strcasecmp(value, OFF) ? PETSC_FALSE : PETSC_TRUE, &k));
  if (k < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (!strcasecmp(value, OFF))
    l->name[k][0] = 0;
  else if (removes && l->value[k][0])
    MPMAppend(l->value[k], MPM_TEXT_LEN, ",%s", value);
  else
    (void)snprintf(l->value[k], MPM_TEXT_LEN, "%s", value);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStagesOptions(const char text[], PetscInt stage, char **options)
{
  char list_of[MPM_TEXT_LEN] = "", *save = NULL, name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN];
  char(*names)[MPM_NAME_LEN], *told      = NULL;
  const char *option;
  List        list   = {0};
  size_t      length = 0;
  PetscInt    n      = 0;
  FILE       *out;

  PetscFunctionBeginUser;
  for (const char *at = text; MPMOptionsNext(&at, name, value);) {
    PetscInt k;

    if (!strcasecmp(name, "-stages") || !strncasecmp(name, "-stage_", 7)) continue;
    PetscCall(Find(&list, name, PETSC_TRUE, &k));
    (void)snprintf(list.value[k], MPM_TEXT_LEN, "%s", value);
  }
  (void)MPMOptionsFindIn(text, "-stages", list_of);
  PetscCall(PetscMalloc1(strlen(list_of) / 2 + 1, &names));
  for (char *s = strtok_r(list_of, ", ", &save); s; s = strtok_r(NULL, ", ", &save))
    (void)snprintf(names[n++], MPM_NAME_LEN, "%s", s);
  for (PetscInt s = 0; s < PetscMin(n, stage); s++)
    for (const char *at = text; MPMOptionsNext(&at, name, value);)
      if (MPMStageOf(n, names, name + 1, &option) == s) PetscCall(Change(&list, option, value, s == stage - 1));
  PetscCall(PetscFree(names));
  out = open_memstream(&told, &length);
  PetscCheck(out, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options of a stage");
  for (PetscInt k = 0; k < list.n; k++)
    if (list.name[k][0])
      (void)fprintf(out,
                    strchr(list.value[k], ' ') ? "%s \"%s\"\n"
                    : list.value[k][0]         ? "%s %s\n"
                                               : "%s%s\n",
                    list.name[k], list.value[k]);
  (void)fclose(out);
  PetscCall(PetscStrallocpy(told, options));
  free(told);
  PetscCall(PetscFree(list.name));
  PetscCall(PetscFree(list.value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStagesOverlay(const char text[], const char options[])
{
  char name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN], other[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  for (const char *at = options; MPMOptionsNext(&at, name, value);)
    if (!MPMOptionsFindIn(text, name, other) || strcmp(value, other)) PetscCall(MPMOptionsOverlay(name, value));
  for (const char *at = text; MPMOptionsNext(&at, name, value);)
    if (strcasecmp(name, "-stages") && strncasecmp(name, "-stage_", 7) && !MPMOptionsFindIn(options, name, other))
      PetscCall(MPMOptionsOverlay(name, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}
