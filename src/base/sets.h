/* sets.h - sets of the particles of a block: masks of several vectors (lanes.h), collected as bits. */
#ifndef MPM_SETS_H
#define MPM_SETS_H

#include "base/lanes.h"

/* Adds particles to a set of particles 0 .. 63, which has a bit for each; the set is the union of its lanes. The vector
   of m begins at particle l, and the particles of the lanes in which m is true are added. */
MPM_INLINE MPMBits MPMCollect(MPMMask m, PetscInt l, MPMBits set)
{
#if MPM_WIDTH == 1
  return m && l < 64 ? set | (uint64_t)1 << l : set;
#elif MPM_WIDTH == 8
  return set | ((MPMBits)m & ((MPMBits){1, 2, 4, 8, 16, 32, 64, 128} << l));
#elif MPM_WIDTH == 4
  return set | ((MPMBits)m & ((MPMBits){1, 2, 4, 8} << l));
#else
  return set | ((MPMBits)m & ((MPMBits){1, 2} << l));
#endif
}

/* Lists the particles of a set that are below n > 0, ascending; returns how many there are. */
MPM_INLINE PetscInt MPMList(MPMBits set, PetscInt n, PetscInt *list)
{
  uint64_t bits = 0;
  PetscInt k    = 0;

#if MPM_WIDTH == 1
  bits = set;
#else
  for (int l = 0; l < MPM_WIDTH; l++) bits |= set[l];
#endif
  for (bits &= ~(uint64_t)0 >> (64 - n); bits; bits &= bits - 1) list[k++] = __builtin_ctzll(bits);
  return k;
}

#endif
