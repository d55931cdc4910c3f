/* simulate.c - see simulate.h. */
#include "base/simulate.h"
#if defined(MPM_SIMULATE)
#include <smpi/smpi.h>

/* The time of `amount` units of work passes. What a unit costs, in ns, stands in the environment:
   PEBBLE_COSTS="P2G=8.3,SORT=1.1,..."; a name that is not there costs nothing, and without the variable the simulator
   times the program itself. Not collective. */
void MPMSimulateWork(const char name[], PetscReal amount)
{
  const char  *costs = getenv("PEBBLE_COSTS");
  const size_t len   = strlen(name);

  for (const char *c = costs; c && *c; c = strchr(c, ',') ? strchr(c, ',') + 1 : NULL)
    if (!strncmp(c, name, len) && c[len] == '=') {
      const double seconds = 1e-9 * (double)amount * strtod(c + len + 1, NULL);

      if (seconds > 0) smpi_execute(seconds);
    }
}
#else
typedef int MPMSimulateNothing; /* a file must not be empty */
#endif
