/* basis.h - the 1-D basis functions; transfer.h forms their tensor products, once, for all of them.

   xi = (x - lower)/h is the coordinate in cells, by a division, the same expression on every rank and in every phase.
   A basis gives the first node of a point's stencil (the base, which also names the point's "cell") and the values w
   and gradients g (per cell, so divide by h) of its nodes base, base+1, ... */
#ifndef MPM_BASIS_H
#define MPM_BASIS_H

#include "tensor.h"

typedef enum {
#define MPM_BASIS(name, nodes, layers, what) MPM_BASIS_##name,
#include "basis.def"
#undef MPM_BASIS
  MPM_NUM_BASES
} MPMBasis;

#define MPM_MAX_STENCIL 2 /* nodes per axis of the widest basis */

/* Largest integer <= xi without a library call; xi is far inside the range of PetscInt. */
MPM_INLINE PetscInt MPMFloor(PetscReal xi)
{
  const PetscInt i = (PetscInt)xi;

  return i - (xi < (PetscReal)i);
}

/* A point on the upper wall belongs to the last cell (decided once, here). xi may lie beyond the grid for images of
   points across a periodic face.                                                                                     */
MPM_INLINE PetscInt MPMBasisBase_linear(PetscReal xi, PetscInt cells)
{
  const PetscInt i = MPMFloor(xi);

  return i < cells ? i : cells - 1;
}

MPM_INLINE void MPMBasisWeights_linear(PetscReal xi, PetscInt base, PetscInt cells, PetscReal w[], PetscReal g[])
{
  const PetscReal s = xi - (PetscReal)base;

  (void)cells;
  w[0] = 1 - s;
  w[1] = s;
  g[0] = -1;
  g[1] = 1;
}

/* Nodes per axis. */
MPM_INLINE int MPMBasisNodes(MPMBasis basis)
{
#define MPM_BASIS(name, nodes, layers, what)                                                                           \
  if (basis == MPM_BASIS_##name) return nodes;
#include "basis.def"
#undef MPM_BASIS
  return 0;
}

/* Node layers needed beyond each wall. */
MPM_INLINE int MPMBasisLayers(MPMBasis basis)
{
#define MPM_BASIS(name, nodes, layers, what)                                                                           \
  if (basis == MPM_BASIS_##name) return layers;
#include "basis.def"
#undef MPM_BASIS
  return 0;
}

MPM_INLINE PetscInt MPMBasisBase(MPMBasis basis, PetscReal xi, PetscInt cells)
{
#define MPM_BASIS(name, nodes, layers, what)                                                                           \
  if (basis == MPM_BASIS_##name) return MPMBasisBase_##name(xi, cells);
#include "basis.def"
#undef MPM_BASIS
  return 0;
}

MPM_INLINE void MPMBasisWeights(MPMBasis basis, PetscReal xi, PetscInt base, PetscInt cells, PetscReal w[],
                                PetscReal g[])
{
#define MPM_BASIS(name, nodes, layers, what)                                                                           \
  if (basis == MPM_BASIS_##name) MPMBasisWeights_##name(xi, base, cells, w, g);
#include "basis.def"
#undef MPM_BASIS
}

#endif
