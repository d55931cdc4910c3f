/* tiles.c - the tiles of a patch: which nodes each of them touches, which have particles, and whose sums are kept for
   other processes. Geometry depends on the grid alone, so processes need no messages about their neighbours' tiles. */
#include "kernels/tile_index.h"
#include "particles/box.h"
#include "particles/poison.h"

/* Late tiles are added until their sums have this many bytes more than 1.5 times those that came from other processes:
   their work then covers the time of the messages. More would be slower, since sums in scratch stay in the cache and
   kept ones mostly do not. Whole rows of tiles are late, so in 1-D all tiles are. */
#define LATE_BYTES 262144

/* Returns the nodes (or cells) of tile `tile` of axis d of the grid; on a periodic axis negative tiles continue at the
   other end. *start is its first node, counted from the grid's first. */
static PetscInt Width(const MPMPatch *patch, PetscInt d, PetscInt tile, PetscInt *start)
{
  const PetscInt edge = MPMTileEdge(patch->basis), nodes = patch->grid->nodes[d], n = (nodes + edge - 1) / edge;
  const PetscInt round = tile < 0 ? -((-tile + n - 1) / n) : 0, at = tile - round * n;

  *start = round * nodes + at * edge;
  return PetscMin(edge, nodes - at * edge);
}

/* Returns how many nodes the stencil has beyond a particle's base node. */
static PetscInt Reach(const MPMPatch *patch, PetscInt d)
{
  return d < patch->grid->dim ? MPMBasisNodes(patch->basis) - 1 : 0;
}

/* Returns the number, counted over the grid, of the tile on axis d at place k of the table. */
static PetscInt TileAt(const MPMPatch *patch, PetscInt d, PetscInt k)
{
  return (patch->own_lo[d] + patch->grid->layers[d]) / MPMTileEdge(patch->basis) + k - patch->tiles.below[d];
}

/* Returns how many tiles of axis d, from `tile` on downwards, touch nodes from `node` of the grid on. */
static PetscInt CountBelow(const MPMPatch *patch, PetscInt d, PetscInt tile, PetscInt node)
{
  PetscInt n = 0, start;

  if (Reach(patch, d) == 0) return 0;
  while (Width(patch, d, tile - n, &start) + start + Reach(patch, d) > node) n++;
  return n;
}

/* Sets up the tiles of a patch whose box is set. alone: the patch also makes sums of the nodes above, and gets none
   from below (for -parallel_sums roundoff). Not collective. */
PetscErrorCode MPMTilesSetUp(MPMPatch *patch, PetscBool alone)
{
  const MPMGrid *grid = patch->grid;
  const PetscInt edge = MPMTileEdge(patch->basis);
  MPMTiles      *t    = &patch->tiles;
  const size_t   size = MPMTileNodes(grid->dim, patch->basis) * (size_t)(t->lines * MPM_NODE_NC) * sizeof(PetscReal);
  PetscInt       rows;

  PetscFunctionBeginUser;
  t->bits = MPM_TILE_BITS(MPMBasisNodes(patch->basis));
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt  own = (patch->own_n[d] + edge - 1) / edge, lo = patch->own_lo[d] + grid->layers[d];
    const PetscBool whole = patch->own_n[d] == grid->nodes[d];

    t->wraps[d] = whole && grid->periodic[d];
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

/* Frees the tiles of a patch. Not collective. */
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

/* Returns how many numbers of cells there are: all cells of the tiles of the table. */
PetscInt MPMTilesCells(const MPMPatch *patch)
{
  const MPMTiles *t = &patch->tiles;

  return t->n[0] * t->n[1] * t->n[2] << t->bits * patch->grid->dim;
}

/* Adds entries first .. last-1 of the order to the ranges of a pass; they may continue the range before. */
static void AddRun(MPMTiles *t, MPMPass pass, PetscInt row, PetscInt first, PetscInt last)
{
  MPMRange *before = t->runs[pass] + t->nruns[pass] - 1;

  if (first == last) return;
  if (t->nruns[pass] && before->row == row && before->last == first)
    before->last = last;
  else
    t->runs[pass][t->nruns[pass]++] = (MPMRange){first, last, row};
}

/* Notes which tiles of a row have particles; those from `cut` on are early and get a place for their sums. Adds the
   particles to the ranges of the early pass, or those of the other tiles to `pass`. Returns how many other tiles have
   particles. */
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
    MPMTileUse(t, row * n0 + i);
    if (i < cut)
      others++;
    else
      slot[i] = t->n_early++;
  }
  return others;
}

/* Notes which tiles have particles (start [cells+1] of the order), and gives places to the sums that are kept and
   memory to those that may come from others. keep: all tiles are early, as in the pool. Not collective. */
PetscErrorCode MPMTilesAssign(MPMPatch *patch, PetscBool keep, const PetscInt start[])
{
  MPMTiles      *t     = &patch->tiles;
  const size_t   line  = MPMTileNodes(patch->grid->dim, patch->basis) * MPM_NODE_NC * sizeof(PetscReal);
  const size_t   size  = line * (size_t)t->lines;
  const PetscInt tiles = t->n[0] * t->n[1] * t->n[2];
  const PetscInt came  = t->nslots - t->n_own; /* tiles whose sums came in the last exchange */
  PetscInt       late = 0, rows = 0;           /* late tiles; they are in the first rows */
  size_t         need;

  PetscFunctionBeginUser;
  t->start   = start;
  t->n_early = 0;
  for (int k = 0; k < MPM_NUM_PASSES; k++) t->nruns[k] = 0;
  for (PetscInt row = 0; row < t->n[1] * t->n[2]; row++) {
    const PetscInt  j = row % t->n[1], k = row / t->n[1];
    const PetscBool early  = keep || k >= t->n[2] - t->keep[2] || j >= t->n[1] - t->keep[1];
    const PetscBool waits  = t->waits && (size_t)PetscMax(0, late - came - came / 2) * size < LATE_BYTES;
    const PetscInt  others = AssignRow(patch, row, early ? 0 : t->n[0] - t->keep[0],
                                      waits ? MPM_PASS_LATE : MPM_PASS_MAIN, start);

    if (waits) late += others, rows = row + 1;
  }
  t->n_own = t->n_early;
  for (PetscInt k = 0; k < rows * t->n[0]; k++)
    if (t->slot[k] == MPM_TILE_SCRATCH) t->slot[k] = t->n_own++;
  for (int k = 0; k < MPM_NUM_PASSES && keep; k++) t->nruns[k] = 0; /* workers of the pool do the work */
  t->nslots = t->n_own;
  need      = (size_t)(t->n_own + tiles - (t->n[0] - t->below[0]) * (t->n[1] - t->below[1]) * (t->n[2] - t->below[2]));
  if (need > t->room) {
    t->room = need + need / 8;
    PetscCall(PetscFree(t->memory));
    PetscCall(PetscMalloc((t->room + (size_t)t->n[0]) * size + MPM_LINE, &t->memory));
    t->scratch = (PetscReal *)MPMAlign(t->memory);
    t->sum     = (PetscReal *)((char *)t->scratch + (size_t)t->n[0] * size);
  }
  MPMPoison(t->scratch, (t->room + (size_t)t->n[0]) * size);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the tiles below are the uppermost ones across a periodic face, gives them the same sums, once those are made.
   Not collective. */
void MPMTilesWrap(MPMPatch *patch)
{
  MPMTiles *t = &patch->tiles;

  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt tile = 0; tile < t->n[0] * t->n[1] * t->n[2] && t->wraps[d]; tile++) {
      const PetscInt at[3] = {tile % t->n[0], tile / t->n[0] % t->n[1], tile / (t->n[0] * t->n[1])};
      const PetscInt own = t->n[d] - t->below[d], stride = d == 0 ? 1 : d == 1 ? t->n[0] : t->n[0] * t->n[1];

      if (at[d] >= t->below[d]) continue;
      t->slot[tile] = t->slot[tile + (t->below[d] - at[d] + own - 1) / own * own * stride];
      if (t->slot[tile] != MPM_TILE_EMPTY) MPMTileUse(t, tile);
    }
}

/* Makes phases visit the nodes of the box [lo, hi) of the arrays too. */
static void Extend(MPMPatch *patch, const PetscInt lo[3], const PetscInt hi[3])
{
  for (PetscInt k = lo[2]; k < hi[2]; k++)
    for (PetscInt j = lo[1]; j < hi[1]; j++) {
      MPMSpan *span = &patch->span[k * patch->n[1] + j];

      span->first = PetscMin(span->first, lo[0]);
      span->last  = PetscMax(span->last, hi[0]);
    }
}

/* Adds the nodes that the particles of a row of cells touch to the spans. */
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

/* Finds the part of each row of nodes that particles touch: for own particles by their cells, for those of others by
   tiles. Not collective. */
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
      tile += t->n[0] - at[0] - 1; /* the rest of the row is own ones */
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
