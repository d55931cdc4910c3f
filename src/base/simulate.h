/* simulate.h - for the simulator only (docs/simulate.md): work that is not timed but declared where it is done, so that
   a run whose processes take turns on one core tells the time of one whose processes each have their own. Elsewhere
   this does nothing. */
#ifndef MPM_SIMULATE_H
#define MPM_SIMULATE_H

#include "base/base.h"

#if defined(MPM_SIMULATE)
void MPMSimulateWork(const char name[], PetscReal amount);
#else
MPM_INLINE void MPMSimulateWork(const char name[], PetscReal amount)
{
  (void)name;
  (void)amount;
}
#endif

#endif
