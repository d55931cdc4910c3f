/* simulate.c - for the simulator only (docs/simulate.md): work that is not timed but declared, so that a run whose
   processes take turns on one core tells the time of one whose processes each have their own. */
#include "mpm.h"
#if defined(MPM_SIMULATE)
#include <smpi/smpi.h>

/* Lets simulated time pass on this process. Not collective. */
void MPMSimulateExecute(PetscReal seconds)
{
  if (seconds > 0) smpi_execute((double)seconds);
}

/* Declares work where it is done: the time of `amount` units passes. What a unit costs, ns, stands in the environment:
   PEBBLE_COSTS="P2G=8.3,SORT=1.1,..."; a name that is not there costs nothing, and without the variable the simulator
   times the program itself. Not collective. */
void MPMSimulateWork(const char name[], PetscReal amount)
{
  const char  *costs = getenv("PEBBLE_COSTS");
  const size_t len   = strlen(name);

  for (const char *c = costs; c && *c; c = strchr(c, ',') ? strchr(c, ',') + 1 : NULL)
    if (!strncmp(c, name, len) && c[len] == '=') MPMSimulateExecute(1e-9 * amount * strtod(c + len + 1, NULL));
}
#endif
