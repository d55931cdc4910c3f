/* masks.h - what is done with masks of lanes (lanes.h), and sets of the particles of a block made of them. */
#ifndef MPM_MASKS_H
#define MPM_MASKS_H

#include "base/lanes.h"

/* Negates a mask. */
MPM_INLINE MPMMask MPMNot(MPMMask m)
{
#if MPM_WIDTH == 1
  return !m;
#else
  return ~m;
#endif
}

/* Returns a bit for each lane, the lowest for the first one: 1 where m is true. */
MPM_INLINE unsigned MPMLaneBits(MPMMask m)
{
#if MPM_WIDTH == 8
  return (unsigned)_mm512_movepi64_mask((__m512i)m);
#elif MPM_WIDTH == 4
  return (unsigned)_mm256_movemask_pd((__m256d)m);
#elif MPM_WIDTH == 2
  return (m[0] ? 1u : 0u) | (m[1] ? 2u : 0u);
#else
  return m ? 1 : 0;
#endif
}

/* Tells whether a mask is true in any lane. */
MPM_INLINE PetscBool MPMAny(MPMMask m)
{
  return MPMLaneBits(m) ? PETSC_TRUE : PETSC_FALSE;
}

/* Tells which lanes of a vector that begins at particle l belong to particles first .. last-1. */
MPM_INLINE MPMMask MPMBetween(PetscInt l, PetscInt first, PetscInt last)
{
#if MPM_WIDTH == 1
  return first <= l && l < last;
#else
  MPMReal lane = MPMAll(0);

  if (first <= l && l + MPM_WIDTH <= last) return lane == lane; /* the usual case */
  for (int k = 0; k < MPM_WIDTH; k++) lane[k] = k;
  return (lane >= MPMAll((PetscReal)(first - l))) & (lane < MPMAll((PetscReal)(last - l)));
#endif
}

/* Returns the set of the particles, below 64, in whose lanes m is true, a bit for each; the vector of m begins at
   particle l. */
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
