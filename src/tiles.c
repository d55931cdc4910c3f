/* tiles.c - the tiles of a patch: which of them touch which nodes, whose sums they have, and how those that others
   need travel. Geometry comes from the grid alone, so neighbours know each other's. */
#include "mpm.h"

/* Nodes, or cells, of tile `tile` of axis d of the grid; on a periodic axis tiles go on beyond the first. *start: its
   first node, counted from the grid's first. */
static PetscInt Width(const MPMGrid *grid, PetscInt d, PetscInt tile, PetscInt *start)
{
  const PetscInt n     = (grid->nodes[d] + MPM_TILE - 1) / MPM_TILE;
  const PetscInt round = tile < 0 ? -((-tile + n - 1) / n) : 0, at = tile - round * n;

  *start = round * grid->nodes[d] + at * MPM_TILE;
  return PetscMin(MPM_TILE, grid->nodes[d] - at * MPM_TILE);
}

/* Finds the tiles whose points touch nodes [first, last) of axis d, from the highest, at which the nodes end, to the
   lowest, but stores them the other way round. */
static PetscErrorCode FindReach(const MPMPatch *patch, PetscInt d, PetscInt first, PetscInt last, MPMTilePart *part)
{
  const MPMGrid *grid  = patch->grid;
  const PetscInt reach = d < grid->dim ? MPMBasisNodes(patch->basis) - 1 : 0;
  const PetscInt from = patch->own_lo[d] + grid->layers[d], own = (patch->own_n[d] + MPM_TILE - 1) / MPM_TILE;
  const PetscInt lowest = grid->periodic[d] ? PETSC_MIN_INT : 0;

  PetscFunctionBeginUser;
  part->first = first;
  part->last  = last;
  part->n     = 0;
  for (PetscInt tile = PetscMin(first / MPM_TILE, own - 1) + from / MPM_TILE; tile >= lowest; tile--) {
    PetscInt       start, end = Width(grid, d, tile, &start), at = tile - from / MPM_TILE;
    const MPMReach none = {0};

    end += start + reach - from; /* both from the patch's first own node */
    start -= from;
    if (end <= first) break;
    PetscCheck(part->n < MPM_MAX_REACH, PETSC_COMM_SELF, PETSC_ERR_PLIB, "too many tiles touch a node");
    while (at < 0 && patch->own_n[d] == grid->nodes[d]) at += own; /* its own neighbour */
    for (PetscInt k = part->n++; k > 0; k--) part->reach[k] = part->reach[k - 1];
    part->reach[0]       = none;
    part->reach[0].tile  = at;
    part->reach[0].first = PetscMax(first, start);
    part->reach[0].last  = PetscMin(last, end);
    part->reach[0].shift = -start;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The tiles of a patch whose box is set. alone: sums of the nodes above are wanted too, and none come from below (for
   -parallel_sums roundoff). Not collective. */
PetscErrorCode MPMTilesSetUp(MPMPatch *patch, PetscBool alone)
{
  MPMTiles *t = &patch->tiles;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt own   = (patch->own_n[d] + MPM_TILE - 1) / MPM_TILE, reach = MPMTileSide(patch->basis) - MPM_TILE;
    const PetscInt above = alone && d < patch->grid->dim && patch->own_n[d] < patch->grid->nodes[d]
                               ? PetscMin(reach, patch->lo[d] + patch->n[d] - patch->own_lo[d] - patch->own_n[d])
                               : 0;

    t->nparts[d] = own + (above > 0);
    t->below[d]  = 0;
    PetscCall(PetscMalloc1(t->nparts[d], &t->part[d]));
    for (PetscInt k = 0; k < t->nparts[d]; k++) {
      const PetscInt first = k < own ? k * MPM_TILE : patch->own_n[d];

      PetscCall(FindReach(patch, d, first, k < own ? PetscMin(first + MPM_TILE, patch->own_n[d]) : first + above,
                          &t->part[d][k]));
      t->below[d] = PetscMax(t->below[d], -t->part[d][k].reach[0].tile);
    }
    for (PetscInt k = 0; k < t->nparts[d]; k++)
      for (PetscInt q = 0; q < t->part[d][k].n; q++) t->part[d][k].reach[q].tile += t->below[d];
    t->n[d] = own + t->below[d];
  }
  PetscCall(PetscMalloc1(t->n[0] * t->n[1] * t->n[2], &t->slot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTilesDestroy(MPMPatch *patch)
{
  MPMTiles *t = &patch->tiles;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) PetscCall(PetscFree(t->part[d]));
  PetscCall(PetscFree(t->slot));
  PetscCall(PetscFree(t->memory));
  t->room = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers of cells: those of the tiles of the table. */
PetscInt MPMTilesCells(const MPMPatch *patch)
{
  const MPMTiles *t = &patch->tiles;

  return t->n[0] * t->n[1] * t->n[2] << 2 * patch->grid->dim;
}

/* Gives the tiles with points a place for their sums, in order, and makes room for those that may come. Not collective.
 */
PetscErrorCode MPMTilesMark(MPMPatch *patch, const PetscInt start[])
{
  MPMTiles      *t     = &patch->tiles;
  const PetscInt tiles = t->n[0] * t->n[1] * t->n[2], bits = 2 * patch->grid->dim;
  const size_t   size  = MPMTileNodes(patch->grid->dim, patch->basis) * MPM_SUM_NC(patch->grid->dim) * sizeof(PetscReal);
  size_t         need;

  PetscFunctionBeginUser;
  t->nown = 0;
  for (PetscInt k = 0; k < tiles; k++) t->slot[k] = start[k << bits] < start[(k + 1) << bits] ? t->nown++ : -1;
  t->nslots = t->nown;
  need      = (size_t)(t->nown + tiles - (t->n[0] - t->below[0]) * (t->n[1] - t->below[1]) * (t->n[2] - t->below[2]));
  if (need > t->room || !t->memory) {
    t->room = need + need / 8;
    PetscCall(PetscFree(t->memory));
    PetscCall(PetscMalloc(t->room * size + MPM_LINE, &t->memory));
    t->sum = (PetscReal *)MPMAlign(t->memory);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Messages: of the tiles at a side of a patch, `toward` [3] 1 or 0 on each axis, the nodes that the process there
   owns. First a byte for each tile of the side, whether it has points; then the sums of those that have. ---------- */

/* Axis d of the side: tiles [lo, hi) of the table, and nodes [from, to) of each of them. above: mine, for the process
   above; else that of the one below, for me. */
static void Side(const MPMPatch *patch, PetscInt d, int toward, PetscBool above, PetscInt *lo, PetscInt *hi)
{
  const MPMTiles *t = &patch->tiles;
  PetscInt        last = 0, reach = d < patch->grid->dim ? MPMTileSide(patch->basis) - MPM_TILE : 0;

  *lo = t->below[d];
  *hi = t->n[d];
  if (!toward) return;
  if (above) {
    last = patch->own_n[d] - (*hi - *lo - 1) * MPM_TILE;
    *lo  = *hi - 1 - (reach > last);
  } else {
    *lo = 0;
    *hi = t->below[d];
  }
}

/* Nodes [from, to) of tile k of the table that lie in the box of whom the message is for. */
static void Cut(const MPMPatch *patch, PetscInt d, int toward, PetscBool above, PetscInt k, PetscInt *from,
                PetscInt *to)
{
  const PetscInt reach = d < patch->grid->dim ? MPMTileSide(patch->basis) - MPM_TILE : 0;
  const PetscInt tile  = (patch->own_lo[d] + patch->grid->layers[d]) / MPM_TILE + k - patch->tiles.below[d];
  PetscInt       start, width = Width(patch->grid, d, tile, &start), edge;

  start -= patch->own_lo[d] + patch->grid->layers[d];
  edge  = (toward && !above ? 0 : patch->own_n[d]) - start; /* the box's face, from the tile's first node */
  *from = toward ? PetscMax(0, edge) : 0;
  *to   = toward || patch->own_n[d] == patch->grid->nodes[d] ? width + reach : PetscMin(width + reach, edge);
}

/* Calls for each tile of the side in turn: its place in the table and its nodes' box. */
typedef struct {
  PetscInt lo[3], hi[3], at[3], from[3], to[3];
} Walk;

static void WalkBegin(const MPMPatch *patch, const int toward[3], PetscBool above, Walk *w)
{
  for (PetscInt d = 0; d < 3; d++) {
    Side(patch, d, toward[d], above, &w->lo[d], &w->hi[d]);
    w->at[d] = w->lo[d];
  }
}

static PetscBool WalkNext(const MPMPatch *patch, const int toward[3], PetscBool above, Walk *w, PetscInt *tile)
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

static PetscInt WalkTiles(const Walk *w)
{
  return (w->hi[0] - w->lo[0]) * (w->hi[1] - w->lo[1]) * (w->hi[2] - w->lo[2]);
}

/* Copies the sums of a tile's box to or from a message; returns how many bytes. */
static size_t CopyBox(const MPMPatch *patch, const Walk *w, PetscInt slot, PetscInt parts, PetscBool pack, char *message)
{
  const PetscInt dim = patch->grid->dim, side = MPMTileSide(patch->basis);
  const PetscInt c0 = MPM_SUM_FIRST(dim, parts), n = MPM_SUM_LAST(dim, parts) - c0;
  size_t         at = 0;

  for (PetscInt k = w->from[2]; k < w->to[2]; k++)
    for (PetscInt j = w->from[1]; j < w->to[1]; j++) {
      PetscReal *sum = patch->tiles.sum + MPM_SUM_NC(dim) * ((size_t)slot * MPMTileNodes(patch->grid->dim, patch->basis) +
                                                            (size_t)((k * side + j) * side + w->from[0])) + c0;

      for (PetscInt i = w->from[0]; i < w->to[0]; i++, sum += MPM_SUM_NC(dim), at += (size_t)n * sizeof *sum)
        memcpy(pack ? message + at : (char *)sum, pack ? (char *)sum : message + at, (size_t)n * sizeof *sum);
    }
  return at;
}

/* The most bytes that such a message can have. */
size_t MPMTilesBytes(const MPMPatch *patch, const int toward[3], PetscInt parts, PetscBool above)
{
  const PetscInt dim = patch->grid->dim;
  PetscInt       tile;
  size_t         nodes = 0, tiles = 0;
  Walk           w;

  WalkBegin(patch, toward, above, &w);
  for (; WalkNext(patch, toward, above, &w, &tile); tiles++) {
    size_t box = 1;

    for (PetscInt d = 0; d < 3; d++) box *= (size_t)PetscMax(0, w.to[d] - w.from[d]);
    nodes += box;
  }
  return (tiles + 7) / 8 * 8 + nodes * (size_t)(MPM_SUM_LAST(dim, parts) - MPM_SUM_FIRST(dim, parts)) * sizeof(PetscReal);
}

/* Packs the message for the process above on the side; its length in bytes. */
size_t MPMTilesPack(const MPMPatch *patch, const int toward[3], PetscInt parts, char *message)
{
  PetscInt tile, q = 0;
  size_t   at;
  Walk     w;

  WalkBegin(patch, toward, PETSC_TRUE, &w);
  at = (size_t)((WalkTiles(&w) + 7) / 8 * 8);
  for (; WalkNext(patch, toward, PETSC_TRUE, &w, &tile); q++) {
    message[q] = patch->tiles.slot[tile] >= 0;
    if (message[q]) at += CopyBox(patch, &w, patch->tiles.slot[tile], parts, PETSC_TRUE, message + at);
  }
  return at;
}

/* Takes the message of the process below: its tiles get the next places. */
void MPMTilesUnpack(MPMPatch *patch, const int toward[3], PetscInt parts, const char *message)
{
  PetscInt tile, q = 0;
  size_t   at;
  Walk     w;

  WalkBegin(patch, toward, PETSC_FALSE, &w);
  at = (size_t)((WalkTiles(&w) + 7) / 8 * 8);
  for (; WalkNext(patch, toward, PETSC_FALSE, &w, &tile); q++) {
    patch->tiles.slot[tile] = message[q] ? patch->tiles.nslots++ : -1;
    if (message[q]) at += CopyBox(patch, &w, patch->tiles.slot[tile], parts, PETSC_FALSE, (char *)message + at);
  }
}

/* Copies the sums that the parts make of all nodes of a tile to or from a message; returns how many bytes. */
size_t MPMTilesCopy(const MPMPatch *patch, PetscInt slot, PetscInt parts, PetscBool pack, char *message)
{
  const PetscInt side = MPMTileSide(patch->basis), dim = patch->grid->dim;
  const Walk     w    = {.to = {side, dim > 1 ? side : 1, dim > 2 ? side : 1}};

  return CopyBox(patch, &w, slot, parts, pack, message);
}
