/* simulate.c - how work is declared to the simulator of clusters; simulate.h says why. */
#include "base/simulate.h"
#if defined(MPM_SIMULATE)
#include <smpi/smpi.h>

/* Lets the simulated time of `amount` units of work pass. The environment variable PEBBLE_COSTS says what a unit of
   each name costs in ns: "P2G=8.3,SORT=1.1,...". A name that is not in it costs nothing, and without the variable the
   simulator measures the time of the program itself. Not collective. */
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
typedef int MPMSimulateNothing; /* C does not allow an empty file */
#endif
