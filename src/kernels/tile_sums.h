/* tile_sums.h - the sums of tiles, and how P2G adds those of a row of tiles to the patch's nodes. No function here
   reads particles; p2g.h finds the places of their cells. The drawing shows a row of the table of tiles along x, of
   tiles of 4 cells and a stencil of 3 nodes, so 6 nodes a tile (its side), on a patch that owns nodes 2 to 9 of its
   arrays (o):

     node of the arrays   -2 -1  0  1  2  3  4  5  6  7  8  9 10 11    box: at  from  to  end
     tile 0, of `below`    .  .  .  .  o  o                                 -2     4   6    6
     tile 1                            o  o  o  o  o  o                      2     0   6    6
     tile 2                                        o  o  o  o  .  .          6     0   4    6

   slot says where a tile's sums are. If it is >= 0 they are kept in t->sum[slot]: those of tile 0 came from the process
   below, and tile 2 is early, since its last nodes belong to the process above. MPM_TILE_SCRATCH: they are in the
   scratch, at the tile's place in the row. MPM_TILE_EMPTY: the tile has no particles. */
#ifndef MPM_TILE_SUMS_H
#define MPM_TILE_SUMS_H

#include "kernels/tile_index.h"
#include "kernels/transfer.h"

/* Returns how many numbers the sums of a tile are. */
MPM_INLINE size_t MPMTileSize(int dim, MPMBasis basis)
{
  return MPMTileNodes(dim, basis) * MPM_NODE_NC;
}

/* Zeroes the kept sums of a pass; those of early tiles come before those of late ones. */
MPM_INLINE void MPMOpenKept(int dim, const MPMPatch *patch, MPMPass pass)
{
  const MPMTiles *t    = &patch->tiles;
  const size_t    size = MPMTileSize(dim, patch->basis);
  const PetscInt  from = pass == MPM_PASS_LATE ? t->n_early : 0, to = pass == MPM_PASS_LATE ? t->n_own : t->n_early;

  if (from < to) memset(t->sum + (size_t)from * size, 0, (size_t)(to - from) * size * sizeof *t->sum);
}

/* Zeroes the sums of a row of tiles that are in scratch. */
MPM_INLINE void MPMOpenRow(int dim, const MPMPatch *patch, PetscInt row)
{
  const MPMTiles *t    = &patch->tiles;
  const size_t    size = MPMTileSize(dim, patch->basis);

  for (PetscInt i = t->used[row][0]; i < t->used[row][1]; i++)
    if (t->slot[row * t->n[0] + i] == MPM_TILE_SCRATCH)
      memset(t->scratch + (size_t)i * size, 0, size * sizeof *t->scratch);
}

/* Zeroes the sums that the parts make of a row of nodes, if that has not been done in this phase. */
MPM_INLINE void MPMZeroRow(int dim, MPMPatch *patch, PetscInt parts, PetscInt row)
{
  MPMSpan       *span = patch->span + row;
  const PetscInt c0 = MPM_NODE_FIRST(parts), c1 = MPM_NODE_LAST(dim, parts), n = span->last - span->first;
  PetscReal *sum = (PetscReal *)patch->node + MPM_NODE_NC * ((size_t)row * (size_t)patch->n[0] + (size_t)span->first);

  if (!span->fresh) return;
  span->fresh = PETSC_FALSE;
  if (n > 0 && (parts & MPM_P2G_MASS) && (parts & MPM_P2G_FORCE))
    memset(sum, 0, (size_t)(n * MPM_NODE_NC) * sizeof *sum);
  else
    for (PetscInt i = 0; i < n; i++)
      for (PetscInt c = c0; c < c1; c++) sum[i * MPM_NODE_NC + c] = 0;
}

/* Adds the sums of a row of tiles to those of the patch's nodes, from the lowest tile to the highest. */
MPM_INLINE void MPMCloseRow(int dim, MPMPatch *patch, PetscInt parts, PetscInt row)
{
  const MPMTiles   *t    = &patch->tiles;
  const PetscInt    side = MPMTileSide(patch->basis), *slot = t->slot + row * t->n[0];
  const size_t      size = MPMTileSize(dim, patch->basis);
  const MPMTileBox *y = &t->box[1][row % t->n[1]], *z = &t->box[2][row / t->n[1]];
  const PetscInt    first = t->used[row][0], last = t->used[row][1];

  if (first >= last) return;
  for (PetscInt k = z->from; k < z->to; k++)
    for (PetscInt j = y->from; j < y->to; j++) { /* row j, k of the tiles' nodes, `at` of the arrays */
      const PetscInt at    = (k + z->at) * patch->n[1] + j + y->at;
      PetscReal     *nodes = (PetscReal *)patch->node + MPM_NODE_NC * (size_t)at * (size_t)patch->n[0];

      MPMZeroRow(dim, patch, parts, at);
      for (PetscInt i = first; i < last; i++) {
        const MPMTileBox *x    = &t->box[0][i];
        const PetscReal  *from = slot[i] >= 0 ? t->sum + (size_t)slot[i] * size : t->scratch + (size_t)i * size;
        PetscReal        *to   = nodes + MPM_NODE_NC * x->at;

        from += MPM_NODE_NC * (k * side + j) * side;
        if (slot[i] == MPM_TILE_EMPTY) continue;
        for (PetscInt c = MPM_NODE_NC * x->from; c < MPM_NODE_NC * x->to; c += MPM_WIDTH)
          MPMWrite(to + c, MPMRead(to + c) + MPMRead(from + c));
      }
    }
}

#endif
