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

/* Returns how many numbers a line of the sums of a tile is, and how many all of them are. */
MPM_INLINE size_t MPMTileLine(int dim, MPMBasis basis)
{
  return MPMTileNodes(dim, basis) * MPM_NODE_NC;
}

MPM_INLINE size_t MPMTileSize(int dim, const MPMPatch *patch)
{
  return MPMTileLine(dim, patch->basis) * (size_t)(MPM_NODE_LINES > 1 ? patch->tiles.lines : 1);
}

/* Returns whether these parts sum numbers of a line of the record. */
MPM_INLINE PetscBool MPMHasLine(PetscInt parts, PetscInt line)
{
  return parts & (line ? MPMNodeParts(line) : MPM_P2G_CORE) ? PETSC_TRUE : PETSC_FALSE;
}

/* Repeats a statement for each line that the parts sum. */
#define MPM_FOR_LINES(line, parts)                                                                                     \
  for (PetscInt line = 0; line < MPM_NODE_LINES; line++)                                                               \
    if (MPMHasLine(parts, line))

/* Zeroes the kept sums of a pass; those of early tiles come before those of late ones. */
MPM_INLINE void MPMOpenKept(int dim, const MPMPatch *patch, PetscInt parts, MPMPass pass)
{
  const MPMTiles *t    = &patch->tiles;
  const size_t    size = MPMTileSize(dim, patch), line = MPMTileLine(dim, patch->basis);
  const PetscInt  from = pass == MPM_PASS_LATE ? t->n_early : 0, to = pass == MPM_PASS_LATE ? t->n_own : t->n_early;

  for (PetscInt k = from; k < to; k++)
    MPM_FOR_LINES(q, parts) memset(t->sum + (size_t)k * size + (size_t)q * line, 0, line * sizeof *t->sum);
}

/* Zeroes the sums of a row of tiles that are in scratch. */
MPM_INLINE void MPMOpenRow(int dim, const MPMPatch *patch, PetscInt parts, PetscInt row)
{
  const MPMTiles *t    = &patch->tiles;
  const size_t    size = MPMTileSize(dim, patch), line = MPMTileLine(dim, patch->basis);

  for (PetscInt i = t->used[row][0]; i < t->used[row][1]; i++)
    if (t->slot[row * t->n[0] + i] == MPM_TILE_SCRATCH)
      MPM_FOR_LINES(q, parts) memset(t->scratch + (size_t)i * size + (size_t)q * line, 0, line * sizeof *t->scratch);
}

/* Returns line `line` of the sums of a row of the patch's nodes. */
MPM_INLINE PetscReal *MPMLineOfRow(const MPMPatch *patch, PetscInt line, PetscInt row)
{
  const size_t plane = (size_t)patch->n[0] * (size_t)patch->n[1] * (size_t)patch->n[2];

  return (PetscReal *)patch->node + MPM_NODE_NC * ((size_t)line * plane + (size_t)row * (size_t)patch->n[0]);
}

/* Zeroes the sums that the parts make of a row of nodes. Those of the first line that follow each other are zeroed
   together, which is faster. */
MPM_INLINE void MPMZeroRow(int dim, MPMPatch *patch, PetscInt parts, PetscInt row)
{
  MPMSpan       *span  = patch->span + row;
  const PetscInt n     = span->last - span->first;
  const PetscInt lower = MPM_P2G_MASS | MPM_P2G_MOMENTUM, upper = MPM_P2G_FORCE;
  PetscReal     *sum = MPMLineOfRow(patch, 0, row) + MPM_NODE_NC * span->first;
  PetscInt       which[MPM_NODE_NUMBERS], rest = parts & ~(lower | upper | MPM_P2G_ROUND | MPM_P2G_WHOLE);

  span->fresh = PETSC_FALSE;
  if ((parts & lower) == lower && parts & upper)
    memset(sum, 0, (size_t)PetscMax(0, n) * MPM_NODE_NC * sizeof *sum);
  else if ((parts & lower) == lower)
    for (PetscInt i = 0; i < n; i++)
      memset(sum + MPM_NODE_NC * i, 0, (size_t)(parts & MPM_P2G_ROUND ? 4 : 1 + dim) * sizeof *sum);
  else if (!(parts & lower) && parts & upper)
    for (PetscInt i = 0; i < n; i++) memset(sum + MPM_NODE_NC * i + MPM_NODE_force, 0, (size_t)dim * sizeof *sum);
  else
    rest = parts & ~MPM_P2G_WHOLE;
  if (!(rest & MPM_P2G_CORE) && MPM_NODE_LINES == 1) return;
  for (PetscInt w = MPMNodeSums(dim, parts & ~MPM_P2G_WHOLE, which) - 1; w >= 0; w--) {
    const PetscInt line = which[w] / MPM_NODE_NC;

    if (line == 0 && !(rest & MPM_P2G_CORE)) continue;
    sum = MPMLineOfRow(patch, line, row) + MPM_NODE_NC * span->first + which[w] % MPM_NODE_NC;
    for (PetscInt i = 0; i < n; i++) sum[MPM_NODE_NC * i] = 0;
  }
}

/* Adds the sums of a row of tiles to those of the patch's nodes, from the lowest tile to the highest. */
MPM_INLINE void MPMCloseRow(int dim, MPMPatch *patch, PetscInt parts, PetscInt row)
{
  const MPMTiles   *t    = &patch->tiles;
  const PetscInt    side = MPMTileSide(patch->basis), *slot = t->slot + row * t->n[0];
  const size_t      size = MPMTileSize(dim, patch);
  const MPMTileBox *y = &t->box[1][row % t->n[1]], *z = &t->box[2][row / t->n[1]];
  const PetscInt    first = t->used[row][0], last = t->used[row][1];

  if (first >= last) return;
  for (PetscInt k = z->from; k < z->to; k++)
    for (PetscInt j = y->from; j < y->to; j++) { /* row j, k of the tiles' nodes, `at` of the arrays */
      const PetscInt at = (k + z->at) * patch->n[1] + j + y->at;

      if (patch->span[at].fresh) MPMZeroRow(dim, patch, parts, at);
      MPM_FOR_LINES(line, parts)
      {
        PetscReal   *nodes = MPMLineOfRow(patch, line, at);
        const size_t row0  = (size_t)line * MPMTileLine(dim, patch->basis) +
                            (size_t)(MPM_NODE_NC * (k * side + j) * side);

        for (PetscInt i = first; i < last; i++) {
          const MPMTileBox *x    = &t->box[0][i];
          const PetscReal  *from = slot[i] >= 0 ? t->sum + (size_t)slot[i] * size : t->scratch + (size_t)i * size;
          PetscReal        *to   = nodes + MPM_NODE_NC * x->at;

          from += row0;
          if (slot[i] == MPM_TILE_EMPTY) continue;
          for (PetscInt c = MPM_NODE_NC * x->from; c < MPM_NODE_NC * x->to; c += MPM_WIDTH)
            MPMWrite(to + c, MPMRead(to + c) + MPMRead(from + c));
        }
      }
    }
}

#endif
