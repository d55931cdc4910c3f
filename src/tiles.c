/* tiles.c - the tiles of a patch: which of them touch which nodes, whose sums they have, and how those that others
   need travel. Geometry comes from the grid alone, so neighbours know each other's. */
#include "tiles.h"

/* So many bytes of sums of late tiles, besides half as many tiles again as came from others: enough to hide their
   sums and their messages. Not many more, since open tiles are summed in scratch, late ones mostly beyond the cache;
   but whole rows of tiles, so in 1-D all. */
#define LATE_BYTES 262144

/* Nodes, or cells, of tile `tile` of axis d of the grid; on a periodic axis tiles go on beyond the first. *start: its
   first node, counted from the grid's first. */
static PetscInt Width(const MPMPatch *patch, PetscInt d, PetscInt tile, PetscInt *start)
{
  const PetscInt edge = MPMTileEdge(patch->basis), nodes = patch->grid->nodes[d], n = (nodes + edge - 1) / edge;
  const PetscInt round = tile < 0 ? -((-tile + n - 1) / n) : 0, at = tile - round * n;

  *start = round * nodes + at * edge;
  return PetscMin(edge, nodes - at * edge);
}

/* The stencil's reach beyond a particle's base node. */
static PetscInt Reach(const MPMPatch *patch, PetscInt d)
{
  return d < patch->grid->dim ? MPMBasisNodes(patch->basis) - 1 : 0;
}

/* The tile on axis d that stands at place k of the table, numbered over the grid. */
static PetscInt TileAt(const MPMPatch *patch, PetscInt d, PetscInt k)
{
  return (patch->own_lo[d] + patch->grid->layers[d]) / MPMTileEdge(patch->basis) + k - patch->tiles.below[d];
}

/* How many tiles of axis d from `tile` on downwards touch nodes beyond it, which begin at `node` of the grid. */
static PetscInt CountBelow(const MPMPatch *patch, PetscInt d, PetscInt tile, PetscInt node)
{
  PetscInt n = 0, start;

  if (Reach(patch, d) == 0) return 0;
  while (Width(patch, d, tile - n, &start) + start + Reach(patch, d) > node) n++;
  return n;
}

/* The tiles of a patch whose box is set. alone: sums of the nodes above are wanted too, and none come from below (for
   -parallel_sums roundoff). Not collective. */
PetscErrorCode MPMTilesSetUp(MPMPatch *patch, PetscBool alone)
{
  const MPMGrid *grid = patch->grid;
  const PetscInt edge = MPMTileEdge(patch->basis);
  MPMTiles      *t    = &patch->tiles;
  const size_t   size = MPMTileNodes(grid->dim, patch->basis) * MPM_SUM_NC(grid->dim) * sizeof(PetscReal);
  PetscInt       rows;

  PetscFunctionBeginUser;
  t->bits = MPM_TILE_BITS(MPMBasisNodes(patch->basis));
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt  own = (patch->own_n[d] + edge - 1) / edge, lo = patch->own_lo[d] + grid->layers[d];
    const PetscBool whole = patch->own_n[d] == grid->nodes[d] ? PETSC_TRUE : PETSC_FALSE;

    t->wraps[d] = whole && grid->periodic[d] ? PETSC_TRUE : PETSC_FALSE;
    t->below[d] = t->keep[d] = 0;
    if (t->wraps[d] || (!alone && !whole && (lo > 0 || grid->periodic[d])))
      t->below[d] = CountBelow(patch, d, lo / edge - 1, lo);
    if (t->wraps[d] || (!alone && !whole && (lo + patch->own_n[d] < grid->nodes[d] || grid->periodic[d])))
      t->keep[d] = PetscMin(own, CountBelow(patch, d, lo / edge + own - 1, lo + patch->own_n[d]));
    t->n[d] = own + t->below[d];
    PetscCall(PetscMalloc1(t->n[d], &t->box[d]));
    for (PetscInt k = 0; k < t->n[d]; k++) {
      MPMTileBox    *box  = &t->box[d][k];
      const PetscInt last = alone && !t->wraps[d] ? patch->lo[d] + patch->n[d] : patch->own_lo[d] + patch->own_n[d];
      PetscInt       start, width = Width(patch, d, TileAt(patch, d, k), &start);

      start -= grid->layers[d];
      box->at   = start - patch->lo[d];
      box->from = PetscMax(0, patch->own_lo[d] - start);
      box->end  = width + Reach(patch, d);
      box->to   = PetscMin(box->end, last - start);
    }
  }
  rows       = t->n[1] * t->n[2];
  t->n_early = t->n_own = t->nslots = 0;
  PetscCall(PetscMalloc1(t->n[0] * rows, &t->slot));
  for (PetscInt k = 0; k < t->n[0] * rows; k++) t->slot[k] = MPM_TILE_EMPTY;
  PetscCall(PetscCalloc1(rows, &t->used));
  t->waits = PETSC_FALSE;
  for (PetscInt d = 0; d < 3; d++)
    if (t->below[d] && !t->wraps[d]) t->waits = PETSC_TRUE;
  for (int k = 0; k < MPM_NUM_PASSES; k++) PetscCall(PetscMalloc1(rows << t->bits * (grid->dim - 1), &t->runs[k]));
  t->room = 0;
  PetscCall(PetscMalloc((size_t)t->n[0] * size + MPM_LINE, &t->memory));
  t->scratch = (PetscReal *)MPMAlign(t->memory);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTilesDestroy(MPMPatch *patch)
{
  MPMTiles *t = &patch->tiles;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) PetscCall(PetscFree(t->box[d]));
  for (int k = 0; k < MPM_NUM_PASSES; k++) PetscCall(PetscFree(t->runs[k]));
  PetscCall(PetscFree(t->slot));
  PetscCall(PetscFree(t->used));
  PetscCall(PetscFree(t->memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers of cells: those of the tiles of the table. */
PetscInt MPMTilesCells(const MPMPatch *patch)
{
  const MPMTiles *t = &patch->tiles;

  return t->n[0] * t->n[1] * t->n[2] << t->bits * patch->grid->dim;
}

/* Adds a part of the order, which may go on from the one before. */
static void AddRun(MPMTiles *t, MPMPass pass, PetscInt row, PetscInt first, PetscInt last)
{
  MPMRange *before = t->runs[pass] + t->nruns[pass] - 1;

  if (first == last) return;
  if (t->nruns[pass] && before->row == row && before->last == first)
    before->last = last;
  else
    t->runs[pass][t->nruns[pass]++] = (MPMRange){first, last, row};
}

/* Notes that the tile has sums. */
static void Use(MPMTiles *t, PetscInt tile)
{
  PetscInt *used = t->used[tile / t->n[0]], at = tile % t->n[0];

  used[0] = used[0] < used[1] ? PetscMin(used[0], at) : at;
  used[1] = PetscMax(used[1], at + 1);
}

/* Notes which tiles of a row have particles and gives those from `cut` on, which are early, a place for their sums.
   Returns how many others have particles; pass: theirs. */
static PetscInt AssignRow(MPMPatch *patch, PetscInt row, PetscInt cut, MPMPass pass, const PetscInt start[])
{
  MPMTiles      *t   = &patch->tiles;
  const int      dim = (int)patch->grid->dim;
  const PetscInt n0 = t->n[0], rows = 1 << t->bits * (dim - 1), edge = 1 << t->bits;
  PetscInt      *slot = t->slot + row * n0, *used = t->used[row], others = 0;

  for (PetscInt i = used[0]; i < used[1]; i++) slot[i] = MPM_TILE_EMPTY;
  used[0] = used[1] = 0;
  if (start[MPMTileRowCell(dim, t, row, 0)] == start[MPMTileRowCell(dim, t, row, rows)]) return 0;
  for (PetscInt in = 0; in < rows; in++) {
    const PetscInt *cell = start + MPMTileRowCell(dim, t, row, in);

    if (cell[0] == cell[edge * n0]) continue;
    for (PetscInt i = 0; i < n0; i++)
      if (cell[edge * i] < cell[edge * (i + 1)]) slot[i] = MPM_TILE_SCRATCH;
    AddRun(t, pass, row, cell[0], cell[edge * cut]);
    AddRun(t, MPM_PASS_EARLY, row, cell[edge * cut], cell[edge * n0]);
  }
  for (PetscInt i = 0; i < n0; i++) {
    if (slot[i] == MPM_TILE_EMPTY) continue;
    Use(t, row * n0 + i);
    if (i < cut)
      others++;
    else
      slot[i] = t->n_early++;
  }
  return others;
}

/* Notes which tiles have particles and gives those that are kept a place for their sums, and room to those that may
   come. keep: all are early. Not collective. */
PetscErrorCode MPMTilesAssign(MPMPatch *patch, PetscBool keep, const PetscInt start[])
{
  MPMTiles      *t    = &patch->tiles;
  const size_t   size = MPMTileNodes(patch->grid->dim, patch->basis) * MPM_SUM_NC(patch->grid->dim) * sizeof(PetscReal);
  const PetscInt tiles = t->n[0] * t->n[1] * t->n[2];
  const PetscInt came  = t->nslots - t->n_own; /* when sums were exchanged last */
  PetscInt       late = 0, rows = 0;           /* late tiles, in the first rows */
  size_t         need;

  PetscFunctionBeginUser;
  t->start   = start;
  t->n_early = 0;
  for (int k = 0; k < MPM_NUM_PASSES; k++) t->nruns[k] = 0;
  for (PetscInt row = 0; row < t->n[1] * t->n[2]; row++) {
    const PetscInt  j = row % t->n[1], k = row / t->n[1];
    const PetscBool early  = keep || k >= t->n[2] - t->keep[2] || j >= t->n[1] - t->keep[1] ? PETSC_TRUE : PETSC_FALSE;
    const PetscBool waits  = t->waits && (size_t)PetscMax(0, late - came - came / 2) * size < LATE_BYTES ? PETSC_TRUE
                                                                                                         : PETSC_FALSE;
    const PetscInt  others = AssignRow(patch, row, early ? 0 : t->n[0] - t->keep[0],
                                      waits ? MPM_PASS_LATE : MPM_PASS_MAIN, start);

    if (waits) late += others, rows = row + 1;
  }
  t->n_own = t->n_early;
  for (PetscInt k = 0; k < rows * t->n[0]; k++)
    if (t->slot[k] == MPM_TILE_SCRATCH) t->slot[k] = t->n_own++;
  for (int k = 0; k < MPM_NUM_PASSES && keep; k++) t->nruns[k] = 0; /* others do the work */
  t->nslots = t->n_own;
  need      = (size_t)(t->n_own + tiles - (t->n[0] - t->below[0]) * (t->n[1] - t->below[1]) * (t->n[2] - t->below[2]));
  if (need > t->room) {
    t->room = need + need / 8;
    PetscCall(PetscFree(t->memory));
    PetscCall(PetscMalloc((t->room + (size_t)t->n[0]) * size + MPM_LINE, &t->memory));
    t->scratch = (PetscReal *)MPMAlign(t->memory);
    t->sum     = (PetscReal *)((char *)t->scratch + (size_t)t->n[0] * size);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills in the tiles below on the axes where they are the uppermost ones again, once those have their sums. */
void MPMTilesWrap(MPMPatch *patch)
{
  MPMTiles *t = &patch->tiles;

  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt tile = 0; tile < t->n[0] * t->n[1] * t->n[2] && t->wraps[d]; tile++) {
      const PetscInt at[3] = {tile % t->n[0], tile / t->n[0] % t->n[1], tile / (t->n[0] * t->n[1])};
      const PetscInt own = t->n[d] - t->below[d], stride = d == 0 ? 1 : d == 1 ? t->n[0] : t->n[0] * t->n[1];

      if (at[d] >= t->below[d]) continue;
      t->slot[tile] = t->slot[tile + (t->below[d] - at[d] + own - 1) / own * own * stride];
      if (t->slot[tile] != MPM_TILE_EMPTY) Use(t, tile);
    }
}

/* Lets `first` to `last` - 1 of the rows [lo, hi) of nodes be visited. */
static void Extend(MPMPatch *patch, const PetscInt lo[3], const PetscInt hi[3])
{
  for (PetscInt k = lo[2]; k < hi[2]; k++)
    for (PetscInt j = lo[1]; j < hi[1]; j++) {
      MPMSpan *span = &patch->span[k * patch->n[1] + j];

      span->first = PetscMin(span->first, lo[0]);
      span->last  = PetscMax(span->last, hi[0]);
    }
}

/* The part of each row of nodes that the particles of a row of cells touch. */
static void SpanCells(MPMPatch *patch, PetscInt row, PetscInt in)
{
  const MPMTiles *t    = &patch->tiles;
  const PetscInt *cell = t->start + MPMTileRowCell((int)patch->grid->dim, t, row, in), edge = 1 << t->bits,
                 end   = edge * t->used[row][1];
  const PetscInt at[3] = {0, in % edge, in / edge}, tile[3] = {0, row % t->n[1], row / t->n[1]};
  PetscInt       lo[3], hi[3], first = edge * t->used[row][0], last = end;

  if (cell[first] == cell[end]) return;
  while (cell[first + 1] == cell[first]) first++;
  while (cell[last - 1] == cell[end]) last--;
  for (PetscInt d = 0; d < 3; d++) {
    lo[d] = d ? t->box[d][tile[d]].at + at[d] : t->box[0][t->below[0]].at + first - edge * t->below[0];
    hi[d] = PetscMin(lo[d] + (d ? 1 : last - first) + Reach(patch, d),
                     patch->own_lo[d] + patch->own_n[d] - patch->lo[d]);
  }
  Extend(patch, lo, hi);
}

/* Finds the part of each row of nodes that particles touch: for own particles by cells, for those below by tiles. */
void MPMTilesFindSpans(MPMPatch *patch)
{
  const MPMTiles *t = &patch->tiles;

  for (PetscInt r = 0; r < patch->n[1] * patch->n[2]; r++) patch->span[r] = (MPMSpan){patch->n[0], 0, PETSC_TRUE};
  for (PetscInt row = 0; row < t->n[1] * t->n[2]; row++)
    for (PetscInt in = 0; in < 1 << t->bits * (patch->grid->dim - 1); in++) SpanCells(patch, row, in);
  for (PetscInt tile = 0; tile < t->n[0] * t->n[1] * t->n[2]; tile++) {
    const PetscInt at[3] = {tile % t->n[0], tile / t->n[0] % t->n[1], tile / (t->n[0] * t->n[1])};
    PetscInt       lo[3], hi[3];

    if (at[0] >= t->below[0] && at[1] >= t->below[1] && at[2] >= t->below[2]) {
      tile += t->n[0] - at[0] - 1; /* the rest of the row is own */
      continue;
    }
    if (t->slot[tile] == MPM_TILE_EMPTY) continue;
    for (PetscInt d = 0; d < 3; d++) {
      lo[d] = t->box[d][at[d]].at + t->box[d][at[d]].from;
      hi[d] = t->box[d][at[d]].at + t->box[d][at[d]].to;
    }
    Extend(patch, lo, hi);
  }
}

/* --- Messages: of the tiles at a side of a patch, `toward` [3] 1 or 0 on each axis, the nodes that the process there
   owns. First a byte for each tile of the side, whether it has particles; then the sums of those that have. ----------
 */

/* Axis d of the side: tiles [lo, hi) of the table. above: mine, for the process above; else those of the one below, for
   me. */
static void Side(const MPMPatch *patch, PetscInt d, int toward, PetscBool above, PetscInt *lo, PetscInt *hi)
{
  const MPMTiles *t = &patch->tiles;

  *lo = !toward ? t->below[d] : above ? t->n[d] - t->keep[d] : 0;
  *hi = toward && !above ? t->below[d] : t->n[d];
}

/* Nodes [from, to) of tile k of the table that the receiver owns: beyond my own ones, or else among them, where nodes
   across a periodic face are too. */
static void Cut(const MPMPatch *patch, PetscInt d, int toward, PetscBool above, PetscInt k, PetscInt *from,
                PetscInt *to)
{
  const MPMTileBox *box = &patch->tiles.box[d][k];

  *from = toward && above ? box->to : box->from;
  *to   = (toward && above) || patch->tiles.wraps[d] ? box->end : box->to;
}

/* Goes from tile to tile of the side: its place in the table and its nodes' box. */
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

/* Copies the sums of a tile's box to a message, or from it, and zeroes the others; returns how many bytes. */
static size_t CopyBox(const MPMPatch *patch, const Walk *w, PetscInt slot, PetscInt parts, PetscBool pack,
                      char *message)
{
  const PetscInt dim = patch->grid->dim, side = MPMTileSide(patch->basis);
  const PetscInt c0 = MPM_SUM_FIRST(dim, parts), c1 = MPM_SUM_LAST(dim, parts);
  PetscReal     *at = (PetscReal *)message;

  for (PetscInt k = w->from[2]; k < w->to[2]; k++)
    for (PetscInt j = w->from[1]; j < w->to[1]; j++) {
      PetscReal *sum = patch->tiles.sum + MPM_SUM_NC(dim) * ((size_t)slot * MPMTileNodes(dim, patch->basis) +
                                                             (size_t)((k * side + j) * side + w->from[0]));

      for (PetscInt i = w->from[0]; i < w->to[0]; i++, sum += MPM_SUM_NC(dim))
        if (pack)
          for (PetscInt c = c0; c < c1; c++) *at++ = sum[c];
        else
          for (PetscInt c = 0; c < MPM_SUM_NC(dim); c++) sum[c] = c < c0 || c >= c1 ? 0 : *at++;
    }
  return (size_t)((char *)at - message);
}

/* The most bytes that such a message can have. */
size_t MPMTilesBytes(const MPMPatch *patch, const int toward[3], PetscInt parts, PetscBool above)
{
  const PetscInt dim   = patch->grid->dim;
  size_t         nodes = 1, tiles = 1;
  Walk           w;

  WalkBegin(patch, toward, above, &w);
  for (PetscInt d = 0; d < 3; d++) {
    size_t sum = 0;

    for (PetscInt k = w.lo[d]; k < w.hi[d]; k++) {
      Cut(patch, d, toward[d], above, k, &w.from[d], &w.to[d]);
      sum += (size_t)(w.to[d] - w.from[d]);
    }
    nodes *= sum;
    tiles *= (size_t)(w.hi[d] - w.lo[d]);
  }
  return (tiles + 7) / 8 * 8 +
         nodes * (size_t)(MPM_SUM_LAST(dim, parts) - MPM_SUM_FIRST(dim, parts)) * sizeof(PetscReal);
}

/* Nodes whose sums go to the process above on the side as particles lie now, once for each tile that has some. */
PetscInt MPMTilesSent(const MPMPatch *patch, const int toward[3])
{
  PetscInt tile, nodes = 0;
  Walk     w;

  WalkBegin(patch, toward, PETSC_TRUE, &w);
  while (WalkNext(patch, toward, PETSC_TRUE, &w, &tile))
    if (patch->tiles.slot[tile] != MPM_TILE_EMPTY)
      nodes += (w.to[0] - w.from[0]) * (w.to[1] - w.from[1]) * (w.to[2] - w.from[2]);
  return nodes;
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
    message[q] = patch->tiles.slot[tile] != MPM_TILE_EMPTY;
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
    patch->tiles.slot[tile] = message[q] ? patch->tiles.nslots++ : MPM_TILE_EMPTY;
    if (message[q]) Use(&patch->tiles, tile);
    if (message[q]) at += CopyBox(patch, &w, patch->tiles.slot[tile], parts, PETSC_FALSE, (char *)message + at);
  }
}

/* Copies the sums that the parts make of all nodes of a tile to or from a message; returns how many bytes. */
size_t MPMTilesCopy(const MPMPatch *patch, PetscInt slot, PetscInt parts, PetscBool pack, char *message)
{
  const PetscInt side = MPMTileSide(patch->basis), dim = patch->grid->dim;
  const Walk     w = {.to = {side, dim > 1 ? side : 1, dim > 2 ? side : 1}};

  return CopyBox(patch, &w, slot, parts, pack, message);
}
