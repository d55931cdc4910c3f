/* state.c - the variables of a run, as state.def lists them. */
#include <stddef.h>
#include "run/mpm.h"
#include "step/static.h"

_Static_assert(offsetof(MPMReactions, work) - offsetof(MPMReactions, impulse) == 18 * sizeof(MPMSum),
               "the impulses and the work of walls are 24 sums in sequence");

_Static_assert(offsetof(struct MPMStatic, failed) - offsetof(struct MPMStatic, newton) == 3 * sizeof(PetscInt),
               "the counts of static steps are 4 numbers in sequence");

_Static_assert(sizeof(MPMChanges) == 8 * sizeof(PetscReal), "what changes gave are 8 numbers");

void MPMStateList(void *run, MPMVariables *v)
{
  MPM         mpm   = run;
  MPMCore    *core  = &mpm->core;
  MPMScene   *scene = &mpm->scene;
  MPMMonitor *mon   = &mpm->monitor;
  MPMOutput  *out   = &mpm->output;
  MPMWatch   *watch = &mpm->watch;
#define MPM_VARIABLE(name, type, n, at, uses) {#name, MPM_VARIABLE_##type, (PetscInt)(n), at, uses},
  const MPMVariable table[] = {
#include "run/state.def"
  };

  _Static_assert(sizeof table / sizeof table[0] <= MPM_MOST_VARIABLES, "MPM_MOST_VARIABLES is too small");
  v->n = (PetscInt)(sizeof table / sizeof table[0]);
  for (PetscInt k = 0; k < v->n; k++) v->row[k] = table[k];
}
