/* simulate.h - work for the simulator of clusters (docs/cluster.md). There the processes take turns on one core, so
   measured times would be wrong: instead the program declares how much work it does, where it does it. In a normal
   build the function does nothing. */
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
