/* contact_tiles.c - which tiles have particles of which copy of the nodes, found after each step in which particles changed
   their cell and may have come near those of another one. */
#include "step/contact_search.h"

void MPMContactTilePlace(const MPMCore *core, PetscInt tile, PetscInt at[])
{
  const MPMPatch *patch = &core->exchange.patch;
  const MPMGrid  *grid  = patch->grid;
  const MPMTiles *t     = &patch->tiles;
  const PetscInt  edge  = MPMTileEdge(patch->basis),
                 own[3] = {tile % t->n[0], tile / t->n[0] % t->n[1], tile / (t->n[0] * t->n[1])};

  for (PetscInt d = 0; d < 3; d++) {
    at[d] = (patch->own_lo[d] + grid->layers[d]) / edge + own[d] - t->below[d];
    if (d == grid->stack) at[d] -= MPMGridFirstOf(grid, d, MPMGridPlace(grid, at[d] * edge - grid->layers[d])) / edge;
  }
}

PetscInt MPMContactNextTile(const MPMTiles *t, PetscInt tile)
{
  PetscInt row = tile < 0 ? 0 : tile / t->n[0], i = tile < 0 ? t->below[0] : tile % t->n[0] + 1;

  for (; row < t->n[1] * t->n[2]; row++, i = t->below[0]) {
    if (row % t->n[1] < t->below[1] || row / t->n[1] < t->below[2]) continue;
    for (i = PetscMax(i, t->used[row][0]); i < t->used[row][1]; i++)
      if (t->slot[row * t->n[0] + i] != MPM_TILE_EMPTY) return row * t->n[0] + i;
  }
  return -1;
}

/* Returns the copies (bits) of the particles of cells first .. last-1. In a cell they are by id, and so by body: if the first
   and the last one are of the same body, all are. */
static uint32_t CopiesOf(const MPMCore *core, const MPMView *view, const PetscInt *first, const PetscInt *last)
{
  uint32_t copies = 0;

  for (; first < last; first++) {
    PetscInt q = first[0], end = first[1] - 1, copy[2];

    if (q > end) continue;
    copy[0] = MPMKindOf(core->params.kinds, view, core->particles.order[q])->copy;
    copy[1] = MPMKindOf(core->params.kinds, view, core->particles.order[end])->copy;
    copies |= (uint32_t)1 << copy[0] | (uint32_t)1 << copy[1];
    if (copy[0] == copy[1] && copy[0] != core->contacts->shared) continue;
    for (q++; q < end; q++)
      copies |= (uint32_t)1 << MPMKindOf(core->params.kinds, view, core->particles.order[q])->copy;
  }
  return copies;
}

/* Returns those of an own tile. */
static uint32_t CopiesOfTile(const MPMCore *core, const MPMView *view, PetscInt tile)
{
  const MPMTiles *t    = &core->exchange.patch.tiles;
  const int       dim  = (int)core->grid.dim;
  const PetscInt  rows = 1 << t->bits * (dim - 1), edge = 1 << t->bits;
  uint32_t        copies = 0;

  for (PetscInt in = 0; in < rows; in++) {
    const PetscInt *cell = TileRow(dim, t, tile, in);

    if (cell[0] < cell[edge]) copies |= CopiesOf(core, view, cell, cell + edge);
  }
  return copies;
}

PetscErrorCode MPMContactFindTiles(MPMCore *core)
{
  const MPMGrid   *grid = &core->grid;
  const MPMTiles  *own  = &core->exchange.patch.tiles;
  MPMContactTiles *t    = &core->contacts->tiles;
  const PetscInt   edge = MPMTileEdge(core->basis);
  PetscMPIInt      count;
  MPMView          view;

  PetscFunctionBeginUser;
  if (!t->bits) {
    for (PetscInt d = 0; d < 3; d++) t->n[d] = ((d == grid->stack ? grid->stride : grid->nodes[d]) + edge - 1) / edge;
    t->words = (t->n[0] * t->n[1] * t->n[2] + 63) / 64;
    PetscCall(PetscMalloc1(grid->copies * t->words, &t->bits));
    PetscCall(PetscMalloc1(grid->copies, &t->box));
  }
  PetscCall(PetscArrayzero(t->bits, grid->copies * t->words));
  for (PetscInt c = 0; c < grid->copies; c++)
    for (PetscInt d = 0; d < 6; d++) t->box[c][d] = PETSC_MIN_INT;
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(kind), &view));
  for (PetscInt tile = MPMContactNextTile(own, -1); tile >= 0; tile = MPMContactNextTile(own, tile)) {
    const uint32_t copies = CopiesOfTile(core, &view, tile);
    PetscInt       at[3], bit;

    MPMContactTilePlace(core, tile, at);
    bit = (at[2] * t->n[1] + at[1]) * t->n[0] + at[0];
    for (PetscInt c = 0; c < grid->copies; c++) {
      if (!(copies >> c & 1)) continue;
      t->bits[c * t->words + bit / 64] |= (uint64_t)1 << bit % 64;
      for (PetscInt d = 0; d < 3; d++) {
        t->box[c][d]     = PetscMax(t->box[c][d], -at[d]);
        t->box[c][3 + d] = PetscMax(t->box[c][3 + d], at[d]);
      }
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(kind), &view));
  PetscCall(PetscMPIIntCast(6 * grid->copies, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, t->box, count, MPIU_INT, MPI_MAX, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MPMContactIsNear(const MPMCore *core, PetscInt copy, const PetscInt at[], PetscInt by)
{
  const MPMGrid         *grid = &core->grid;
  const MPMContactTiles *t    = &core->contacts->tiles;
  PetscInt               lo[3], hi[3], i[3];

  for (PetscInt d = 0; d < 3; d++) {
    if (!grid->periodic[d] && (at[d] - by > t->box[copy][3 + d] || at[d] + by < -t->box[copy][d])) return PETSC_FALSE;
    lo[d] = grid->periodic[d] ? at[d] - by : PetscMax(0, at[d] - by);
    hi[d] = grid->periodic[d] ? at[d] + by : PetscMin(t->n[d] - 1, at[d] + by);
  }
  for (i[2] = lo[2]; i[2] <= hi[2]; i[2]++)
    for (i[1] = lo[1]; i[1] <= hi[1]; i[1]++)
      for (i[0] = lo[0]; i[0] <= hi[0]; i[0]++) {
        PetscInt bit = 0;

        for (PetscInt d = 2; d >= 0; d--) bit = bit * t->n[d] + (i[d] + by * t->n[d]) % t->n[d];
        if (t->bits[copy * t->words + bit / 64] >> bit % 64 & 1) return PETSC_TRUE;
      }
  return PETSC_FALSE;
}

PetscErrorCode MPMContactCollectTiles(MPMCore *core)
{
  PetscMPIInt count;

  PetscFunctionBeginUser;
  PetscCall(PetscMPIIntCast(core->grid.copies * core->contacts->tiles.words, &count));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, core->contacts->tiles.bits, count, MPI_UINT64_T, MPI_BOR, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMContactTileCopy(const MPMCore *core, const MPMView *view, PetscInt tile, PetscInt at[])
{
  const MPMTiles *t   = &core->exchange.patch.tiles;
  const int       dim = (int)core->grid.dim;
  PetscInt        in  = 0;

  MPMContactTilePlace(core, tile, at);
  if (core->grid.copies < 2) return 0;
  for (;; in++) {
    const PetscInt *cell = TileRow(dim, t, tile, in);

    if (cell[0] < cell[1 << t->bits]) return MPMKindOf(core->params.kinds, view, core->particles.order[cell[0]])->copy;
  }
}

PetscErrorCode MPMContactListTiles(MPMCore *core)
{
  const MPMTiles  *own = &core->exchange.patch.tiles;
  MPMContactTiles *t   = &core->contacts->tiles;
  MPMView          view;

  PetscFunctionBeginUser;
  t->nbeside = 0;
  if (!core->contacts->near) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(kind), &view));
  for (PetscInt tile = MPMContactNextTile(own, -1); tile >= 0; tile = MPMContactNextTile(own, tile)) {
    MPMContactTile here = {.tile = tile};
    PetscBool      near = PETSC_FALSE;

    here.copy = MPMContactTileCopy(core, &view, tile, here.at);
    for (PetscInt c = 0; c < core->grid.copies && !near; c++)
      near = c != here.copy && MPMContactIsNear(core, c, here.at, 1);
    if (!near) continue;
    if (t->nbeside == t->room) {
      t->room = 2 * t->room + 64;
      PetscCall(PetscRealloc((size_t)t->room * sizeof *t->beside, &t->beside));
    }
    t->beside[t->nbeside++] = here;
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(kind), &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}
