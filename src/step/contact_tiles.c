/* contact_tiles.c - which tiles have particles of which copy of the nodes, found after each step in which particles changed
   their cell. By it copies get their places in the grid: those that are far from each other share one, so that a scene
   whose bodies are apart costs what it costs with one velocity at a node, and all bits are the same.

   Copies that share a place have an empty tile between them or more: then they have no node and no box of F-bar in common, and
   an empty node between theirs, so that what looks beyond the nodes of a particle does not reach the other one: light nodes
   have carriers with mass step by step, and walls on arrival look for ends of matter at nodes without mass alone. */
#include "step/contact_search.h"

/* Tiles: bodies may touch that have particles in tiles as near as this or nearer, and their copies must be at different places;
   copies that are farther than the second number are put at the same one: later than they may be, so that they do not change
   often. How much farther they are is found up to the third one. */
enum { TOUCH = 1, MERGE = 2, FARTHEST = 8 };

/* For each copy the other ones (bits) that have a tile as near as this to one of its own. */
typedef uint32_t Others[MPM_MAX_COPIES];
_Static_assert(MPM_MAX_COPIES <= 32, "copies are the bits of a number of 32");

void MPMContactTilePlace(const MPMCore *core, PetscInt tile, PetscInt at[])
{
  const MPMPatch *patch = &core->exchange.patch;
  const MPMGrid  *grid  = patch->grid;
  const MPMTiles *t     = &patch->tiles;
  const PetscInt  edge  = MPMTileEdge(patch->basis),
                 own[3] = {tile % t->n[0], tile / t->n[0] % t->n[1], tile / (t->n[0] * t->n[1])};

  for (PetscInt d = 0; d < 3; d++) {
    at[d] = (patch->own_lo[d] + grid->layers[d]) / edge + own[d] - t->below[d];
    if (d == grid->stack && grid->places > 1) at[d] %= grid->stride / edge;
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

/* Finds the tiles here that have particles of each copy, and the boxes around those of all processes. Collective on
   exchange.data. */
static PetscErrorCode FindTiles(MPMCore *core)
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

/* Returns whether the boxes around the tiles of two copies are as near as `by` tiles. */
static PetscBool BoxesMeet(const MPMCore *core, PetscInt one, PetscInt other, PetscInt by)
{
  const PetscInt *a = core->contacts->tiles.box[one], *b = core->contacts->tiles.box[other];

  for (PetscInt d = 0; d < 3; d++) {
    if (a[3 + d] < 0 || b[3 + d] < 0) return PETSC_FALSE; /* no particles */
    if (!core->grid.periodic[d] && (a[3 + d] + by < -b[d] || b[3 + d] + by < -a[d])) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

PetscBool MPMContactIsNear(const MPMCore *core, PetscInt copy, const PetscInt at[], PetscInt by)
{
  const MPMGrid         *grid = &core->grid;
  const MPMContactTiles *t    = &core->contacts->tiles;
  PetscInt               lo[3], hi[3], i[3];

  for (PetscInt d = 0; d < 3; d++) {
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

/* Returns how near tiles have to be for copies to be at different places. The nodes beside a piston of cubic splines are a column of
   four, which reaches across one empty node: matter behind a piston and before it. */
static PetscInt PartsAt(const MPMCore *core)
{
  return core->pistons && MPMBasisNodes(core->basis) > 3 ? TOUCH + 1 : TOUCH;
}

/* Returns whether two copies have tiles as near as `by` tiles. */
static PetscBool AreNear(const MPMCore *core, PetscInt a, PetscInt b, PetscInt by)
{
  const MPMContactTiles *t   = &core->contacts->tiles;
  const PetscInt         all = t->n[0] * t->n[1] * t->n[2];

  if (!BoxesMeet(core, a, b, by)) return PETSC_FALSE;
  for (PetscInt bit = 0; bit < all; bit++) {
    const uint64_t word  = t->bits[a * t->words + bit / 64];
    const PetscInt at[3] = {bit % t->n[0], bit / t->n[0] % t->n[1], bit / (t->n[0] * t->n[1])};

    if (!word)
      bit |= 63;
    else if (word >> bit % 64 & 1 && MPMContactIsNear(core, b, at, by))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Sets which copies are as near each other as `by` tiles; returns whether any are. */
static PetscBool SetOthers(const MPMCore *core, PetscInt by, Others near)
{
  PetscBool any = PETSC_FALSE;

  for (PetscInt a = 0; a < core->grid.copies; a++) near[a] = 0;
  for (PetscInt a = 0; a < core->grid.copies; a++)
    for (PetscInt b = a + 1; b < core->grid.copies; b++)
      if (AreNear(core, a, b, by)) {
        near[a] |= (uint32_t)1 << b;
        near[b] |= (uint32_t)1 << a;
        any = PETSC_TRUE;
      }
  return any;
}

/* Gives each copy the first place that no copy before it has that is near; returns how many places there are. */
static PetscInt SetPlaces(PetscInt copies, Others near, PetscInt place[])
{
  PetscInt n = 1;

  for (PetscInt a = 0; a < copies; a++) {
    uint32_t taken = 0;

    for (PetscInt b = 0; b < a; b++)
      if (near[a] >> b & 1) taken |= (uint32_t)1 << place[b];
    for (place[a] = 0; taken >> place[a] & 1;) place[a]++;
    n = PetscMax(n, place[a] + 1);
  }
  return n;
}

/* Collects the tiles of all processes. Collective on exchange.data. */
static PetscErrorCode CollectTiles(MPMCore *core)
{
  PetscMPIInt count;

  PetscFunctionBeginUser;
  PetscCall(PetscMPIIntCast(core->grid.copies * core->contacts->tiles.words, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, core->contacts->tiles.bits, count, MPI_UINT64_T, MPI_BOR,
                             core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the boxes around the tiles of any two copies are as near as `by` tiles. */
static PetscBool AnyBoxesMeet(const MPMCore *core, PetscInt by)
{
  for (PetscInt a = 0; a < core->grid.copies; a++)
    for (PetscInt b = a + 1; b < core->grid.copies; b++)
      if (BoxesMeet(core, a, b, by)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Sets by how many cells copies may approach each other before any are as near as MERGE tiles. all: the tiles of all processes
   are known, else their boxes alone. */
static void SetClear(MPMCore *core, PetscBool all)
{
  MPMContacts *c  = core->contacts;
  PetscInt     by = MERGE;
  Others       near;

  while (by < FARTHEST && !(all ? SetOthers(core, by, near) : AnyBoxesMeet(core, by))) by++;
  c->clear   = (by - 1 - MERGE) * MPMTileEdge(core->basis);
  c->waiting = core->particles.waiting;
}

/* Returns whether all copies are at one place and still too far from each other for anything else: in a step a particle passes
   as many cells as it may have moved, or one. */
static PetscBool AreClear(MPMCore *core)
{
  MPMContacts    *c   = core->contacts;
  const PetscReal way = 2 * core->params.dt * PetscSqrtReal(core->status.v2) / MPMGridSmallestH(&core->grid);

  if (!(way < FARTHEST)) return PETSC_FALSE;
  c->clear -= 2 * PetscMax(1, (PetscInt)PetscCeilReal(way));
  return c->clear >= 0 && core->grid.places < 2 && c->waiting == core->particles.waiting
             ? PETSC_TRUE
             : PETSC_FALSE;
}

PetscErrorCode MPMContactsSettle(MPMCore *core)
{
  MPMGrid  *grid = &core->grid;
  PetscInt  place[MPM_MAX_COPIES], places;
  PetscBool meet, parts = PETSC_FALSE;
  Others    near;

  PetscFunctionBeginUser;
  if (!core->contacts || grid->copies < 2 || AreClear(core)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindTiles(core));
  core->contacts->near = PETSC_FALSE;
  meet                 = AnyBoxesMeet(core, MERGE);
  if (meet) PetscCall(CollectTiles(core));
  SetClear(core, meet);
  if (!meet && grid->places < 2) PetscFunctionReturn(PETSC_SUCCESS);
  core->contacts->near = SetOthers(core, TOUCH, near);
  (void)SetOthers(core, PartsAt(core), near);
  for (PetscInt a = 0; a < grid->copies; a++)
    for (PetscInt b = 0; b < a; b++)
      if (near[a] >> b & 1 && grid->place[a] == grid->place[b]) parts = PETSC_TRUE;
  (void)SetOthers(core, MERGE, near);
  places = SetPlaces(grid->copies, near, place);
  if (!parts && places >= PetscMax(1, grid->places)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArraycpy(grid->place, place, grid->copies));
  grid->places = places;
  MPMGridSetNodes(grid, core->basis);
  PetscCall(core->exchange.type->renew(core));
  PetscCall(core->exchange.type->settle(core, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}
