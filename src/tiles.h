/* tiles.h - the arithmetic of tiles (mpm.h): their nodes, and the numbers of their cells. */
#ifndef MPM_TILES_H
#define MPM_TILES_H

#include "mpm.h"

/* Nodes that the points of a tile touch, on an axis. */
MPM_INLINE PetscInt MPMTileSide(MPMBasis basis)
{
  return MPM_TILE + MPMBasisNodes(basis) - 1;
}

MPM_INLINE size_t MPMTileNodes(PetscInt dim, MPMBasis basis)
{
  const size_t side = (size_t)MPMTileSide(basis);

  return side * (dim > 1 ? side : 1) * (dim > 2 ? side : 1);
}

/* The edge of a patch of the pool: whole tiles. */
MPM_INLINE PetscInt MPMPoolEdge(PetscInt cells)
{
  return (cells + MPM_TILE - 1) / MPM_TILE * MPM_TILE;
}

/* The number of the first cell of the table in row `in` of cells (x fastest) of a row of tiles. */
MPM_INLINE PetscInt MPMTileRowCell(int dim, const MPMTiles *t, PetscInt row, PetscInt in)
{
  return ((row << 2 * (dim - 1)) + in) * MPM_TILE * t->n[0];
}

/* The number of the cell at place `at` [dim] from the patch's first own node. */
MPM_INLINE PetscInt MPMTileCell(int dim, const MPMTiles *t, const PetscInt at[])
{
  PetscInt row = 0, in = 0;

  for (int d = dim - 1; d >= 1; d--) {
    row = row * t->n[d] + t->below[d] + at[d] / MPM_TILE;
    in  = in * MPM_TILE + at[d] % MPM_TILE;
  }
  return MPMTileRowCell(dim, t, row, in) + MPM_TILE * t->below[0] + at[0];
}

/* The tile of a cell, and its place in there: at [3]. */
MPM_INLINE PetscInt MPMTileOf(int dim, const MPMTiles *t, PetscInt cell, PetscInt at[])
{
  const PetscInt x = cell % (MPM_TILE * t->n[0]), row = cell / (MPM_TILE * t->n[0]), bits = 2 * (dim - 1);

  at[0] = x % MPM_TILE;
  at[1] = (row & ((1 << bits) - 1)) % MPM_TILE;
  at[2] = (row & ((1 << bits) - 1)) / MPM_TILE;
  return (row >> bits) * t->n[0] + x / MPM_TILE;
}

#endif
