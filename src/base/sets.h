/* sets.h - sets of the particles of a block, at most 64: a bit for each. */
#ifndef MPM_SETS_H
#define MPM_SETS_H

#include "base/lanes.h"

/* Returns the set of the particles in whose lanes m is true, where the vector of m begins at particle l. */
MPM_INLINE uint64_t MPMSet(MPMMask m, PetscInt l)
{
  return l < 64 ? (uint64_t)MPMLaneBits(m) << l : 0;
}

/* Lists the particles of a set that are below n > 0, ascending; returns how many there are. */
MPM_INLINE PetscInt MPMList(uint64_t set, PetscInt n, PetscInt *list)
{
  PetscInt k = 0;

  for (set &= ~(uint64_t)0 >> (64 - n); set; set &= set - 1) list[k++] = __builtin_ctzll(set);
  return k;
}

#endif
