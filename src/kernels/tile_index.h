/* tile_index.h - the arithmetic of tiles (patch.h): how many nodes they have, and how their cells are numbered. */
#ifndef MPM_TILE_INDEX_H
#define MPM_TILE_INDEX_H

#include "kernels/patch.h"

/* Returns the cells of a tile on an axis. */
MPM_INLINE PetscInt MPMTileEdge(MPMBasis basis)
{
  return 1 << MPM_TILE_BITS(MPMBasisNodes(basis));
}

/* Returns the nodes on an axis that the particles of a tile touch. */
MPM_INLINE PetscInt MPMTileSide(MPMBasis basis)
{
  return MPMTileEdge(basis) + MPMBasisNodes(basis) - 1;
}

/* Returns the nodes that the particles of a tile touch. */
MPM_INLINE size_t MPMTileNodes(PetscInt dim, MPMBasis basis)
{
  const size_t side = (size_t)MPMTileSide(basis);

  return side * (dim > 1 ? side : 1) * (dim > 2 ? side : 1);
}

/* Returns how many tiles have sums of a node beyond a cut, on average. */
MPM_INLINE PetscReal MPMTilesPerGhost(PetscInt dim, MPMBasis basis)
{
  return PetscPowReal((PetscReal)MPMTileSide(basis) / (PetscReal)MPMTileEdge(basis), (PetscReal)dim - 1);
}

/* Returns the cells of an edge of a patch of the pool: `cells` rounded up to whole tiles. */
MPM_INLINE PetscInt MPMPoolEdge(MPMBasis basis, PetscInt cells)
{
  const PetscInt edge = MPMTileEdge(basis);

  return (cells + edge - 1) / edge * edge;
}

/* Returns the number of the first cell in row `in` of cells (along x) of a row of tiles. */
MPM_INLINE PetscInt MPMTileRowCell(int dim, const MPMTiles *t, PetscInt row, PetscInt in)
{
  return ((row << t->bits * (dim - 1)) + in) * (t->n[0] << t->bits);
}

/* Returns the number of the cell at place `at` [dim], counted from the patch's first own node. */
MPM_INLINE PetscInt MPMTileCell(int dim, const MPMTiles *t, const PetscInt at[])
{
  PetscInt row = 0, in = 0;

  for (int d = dim - 1; d >= 1; d--) {
    row = row * t->n[d] + t->below[d] + (at[d] >> t->bits);
    in  = (in << t->bits) + (at[d] & ((1 << t->bits) - 1));
  }
  return MPMTileRowCell(dim, t, row, in) + (t->below[0] << t->bits) + at[0];
}

/* Returns the tile of a cell; at [3] is the place of the cell in the tile. */
MPM_INLINE PetscInt MPMTileOf(int dim, const MPMTiles *t, PetscInt cell, PetscInt at[])
{
  const PetscInt len = t->n[0] << t->bits, edge = 1 << t->bits, x = cell % len, row = cell / len;
  const PetscInt in = row & ((1 << t->bits * (dim - 1)) - 1);

  at[0] = x % edge;
  at[1] = in % edge;
  at[2] = in / edge;
  return (row >> t->bits * (dim - 1)) * t->n[0] + x / edge;
}

/* Notes that the tile has sums (MPMTiles.used). */
MPM_INLINE void MPMTileUse(MPMTiles *t, PetscInt tile)
{
  PetscInt *used = t->used[tile / t->n[0]], at = tile % t->n[0];

  used[0] = used[0] < used[1] ? PetscMin(used[0], at) : at;
  used[1] = PetscMax(used[1], at + 1);
}

#endif
