/* tile_messages.c - messages of sums of tiles. A message is for the neighbour at a side of a patch, which `toward` [3]
   names by 1 or 0 on each axis. Of the tiles there it has the nodes that the neighbour owns: first a byte for each
   tile, which says whether it has particles, padded to whole numbers of 8 bytes; then the sums of those that have. */
#include "kernels/tile_index.h"
#include "kernels/transfer.h"
#include "particles/box.h"

/* Finds tiles [lo, hi) of the table that a side has on axis d. above: own ones, for the process above; else those that
   the process below sends. */
static void SideRange(const MPMPatch *patch, PetscInt d, int toward, PetscBool above, PetscInt *lo, PetscInt *hi)
{
  const MPMTiles *t = &patch->tiles;

  *lo = !toward ? t->below[d] : above ? t->n[d] - t->keep[d] : 0;
  *hi = toward && !above ? t->below[d] : t->n[d];
}

/* Finds nodes [from, to) of tile k of the table that the receiver owns: those beyond the own ones of the sender, or
   else those among them, with those across a periodic face. */
static void Cut(const MPMPatch *patch, PetscInt d, int toward, PetscBool above, PetscInt k, PetscInt *from,
                PetscInt *to)
{
  const MPMTileBox *box = &patch->tiles.box[d][k];

  *from = toward && above ? box->to : box->from;
  *to   = (toward && above) || patch->tiles.wraps[d] ? box->end : box->to;
}

/* Visits the tiles of a side one after the other: `at` is the place of the next one in the table, [from, to) the box of
   its nodes in the message. */
typedef struct {
  PetscInt lo[3], hi[3], at[3], from[3], to[3];
} SideIterator;

/* Starts at the first tile of the side. */
static void SideBegin(const MPMPatch *patch, const int toward[3], PetscBool above, SideIterator *w)
{
  for (PetscInt d = 0; d < 3; d++) {
    SideRange(patch, d, toward[d], above, &w->lo[d], &w->hi[d]);
    w->at[d] = w->lo[d];
  }
}

/* Sets *tile and the box of its nodes, and moves on; returns false after the last tile. */
static PetscBool SideNext(const MPMPatch *patch, const int toward[3], PetscBool above, SideIterator *w, PetscInt *tile)
{
  const MPMTiles *t = &patch->tiles;

  if (w->at[2] >= w->hi[2] || w->lo[0] >= w->hi[0] || w->lo[1] >= w->hi[1]) return PETSC_FALSE;
  *tile = (w->at[2] * t->n[1] + w->at[1]) * t->n[0] + w->at[0];
  for (PetscInt d = 0; d < 3; d++) Cut(patch, d, toward[d], above, w->at[d], &w->from[d], &w->to[d]);
  for (PetscInt d = 0; d < 3; d++) {
    if (++w->at[d] < w->hi[d] || d == 2) break;
    w->at[d] = w->lo[d];
  }
  return PETSC_TRUE;
}

/* Returns the number of tiles of the side. */
static PetscInt SideTiles(const SideIterator *w)
{
  return (w->hi[0] - w->lo[0]) * (w->hi[1] - w->lo[1]) * (w->hi[2] - w->lo[2]);
}

/* Copies the sums of a tile's box to a message, or from it (then the sums that the parts do not make are zeroed);
   returns how many bytes. */
static size_t CopyBox(const MPMPatch *patch, const SideIterator *w, PetscInt slot, PetscInt parts, PetscBool pack,
                      char *message)
{
  const PetscInt dim = patch->grid->dim, side = MPMTileSide(patch->basis);
  const size_t   line = MPMTileNodes(dim, patch->basis) * MPM_NODE_NC; /* numbers of a tile's line */
  PetscReal     *at   = (PetscReal *)message;
  PetscInt       which[MPM_NODE_NUMBERS];
  const PetscInt n = MPMNodeSums(dim, parts, which), lines = MPMNodeLines(parts);

  for (PetscInt c = 0; c < n; c++) which[c] += which[c] / MPM_NODE_NC * (PetscInt)(line - MPM_NODE_NC);

  for (PetscInt k = w->from[2]; k < w->to[2]; k++)
    for (PetscInt j = w->from[1]; j < w->to[1]; j++) {
      PetscReal *sum = patch->tiles.sum + (size_t)(slot * patch->tiles.lines) * line +
                       MPM_NODE_NC * (size_t)((k * side + j) * side + w->from[0]);

      for (PetscInt i = w->from[0]; i < w->to[0]; i++, sum += MPM_NODE_NC)
        if (pack)
          for (PetscInt c = 0; c < n; c++) *at++ = sum[which[c]];
        else {
          for (PetscInt q = 0; q < lines; q++) memset(sum + (size_t)q * line, 0, MPM_NODE_NC * sizeof *sum);
          for (PetscInt c = 0; c < n; c++) sum[which[c]] = *at++;
        }
    }
  return (size_t)((char *)at - message);
}

/* Returns the most bytes that a message for this side can have. Not collective. */
size_t MPMTilesBytes(const MPMPatch *patch, const int toward[3], PetscInt parts, PetscBool above)
{
  size_t       nodes = 1, tiles = 1;
  PetscInt     which[MPM_NODE_NUMBERS];
  SideIterator w;

  SideBegin(patch, toward, above, &w);
  for (PetscInt d = 0; d < 3; d++) {
    size_t sum = 0;

    for (PetscInt k = w.lo[d]; k < w.hi[d]; k++) {
      Cut(patch, d, toward[d], above, k, &w.from[d], &w.to[d]);
      sum += (size_t)(w.to[d] - w.from[d]);
    }
    nodes *= sum;
    tiles *= (size_t)(w.hi[d] - w.lo[d]);
  }
  return (tiles + 7) / 8 * 8 + nodes * (size_t)MPMNodeSums(patch->grid->dim, parts, which) * sizeof(PetscReal);
}

/* Returns how many sums of nodes go to the process above on the side with the present particles; a node counts once for
   each tile that has sums of it. Not collective. */
PetscInt MPMTilesSent(const MPMPatch *patch, const int toward[3])
{
  PetscInt     tile, nodes = 0;
  SideIterator w;

  SideBegin(patch, toward, PETSC_TRUE, &w);
  while (SideNext(patch, toward, PETSC_TRUE, &w, &tile))
    if (patch->tiles.slot[tile] != MPM_TILE_EMPTY)
      nodes += (w.to[0] - w.from[0]) * (w.to[1] - w.from[1]) * (w.to[2] - w.from[2]);
  return nodes;
}

/* Packs the message for the process above on the side; returns its length in bytes. Not collective. */
size_t MPMTilesPack(const MPMPatch *patch, const int toward[3], PetscInt parts, char *message)
{
  PetscInt     tile, q = 0;
  size_t       at;
  SideIterator w;

  SideBegin(patch, toward, PETSC_TRUE, &w);
  at = (size_t)((SideTiles(&w) + 7) / 8 * 8);
  for (; SideNext(patch, toward, PETSC_TRUE, &w, &tile); q++) {
    message[q] = patch->tiles.slot[tile] != MPM_TILE_EMPTY;
    if (message[q]) at += CopyBox(patch, &w, patch->tiles.slot[tile], parts, PETSC_TRUE, message + at);
  }
  return at;
}

/* Unpacks the message of the process below; the sums of its tiles get the next places in t->sum. Not collective. */
void MPMTilesUnpack(MPMPatch *patch, const int toward[3], PetscInt parts, const char *message)
{
  PetscInt     tile, q = 0;
  size_t       at;
  SideIterator w;

  SideBegin(patch, toward, PETSC_FALSE, &w);
  at = (size_t)((SideTiles(&w) + 7) / 8 * 8);
  for (; SideNext(patch, toward, PETSC_FALSE, &w, &tile); q++) {
    patch->tiles.slot[tile] = message[q] ? patch->tiles.nslots++ : MPM_TILE_EMPTY;
    if (message[q]) MPMTileUse(&patch->tiles, tile);
    if (message[q]) at += CopyBox(patch, &w, patch->tiles.slot[tile], parts, PETSC_FALSE, (char *)message + at);
  }
}

/* Copies the sums that the parts make of all nodes of a tile to a message or from it; returns how many bytes. The pool
   uses it. Not collective. */
size_t MPMTilesCopy(const MPMPatch *patch, PetscInt slot, PetscInt parts, PetscBool pack, char *message)
{
  const PetscInt     side = MPMTileSide(patch->basis), dim = patch->grid->dim;
  const SideIterator w = {.to = {side, dim > 1 ? side : 1, dim > 2 ? side : 1}};

  return CopyBox(patch, &w, slot, parts, pack, message);
}
