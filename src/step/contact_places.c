/* contact_places.c - the places of copies in the grid, by the tiles that have their particles. Copies that are far from each
   other share one, so that a scene whose bodies are apart costs what it costs with one velocity at a node, and all bits are
   the same.

   Copies that share a place have an empty tile between them or more: then they have no node and no box of F-bar in common, and
   an empty node between theirs, so that what looks beyond the nodes of a particle does not reach the other one: light nodes
   have carriers with mass step by step, and walls on arrival look for ends of matter at nodes without mass alone. */
#include "step/contact_search.h"

/* Tiles: bodies may touch that have particles in tiles as near as this or nearer, and their copies must be at different places;
   copies that are farther than the second number are put at the same one: later than they may be, so that they do not change
   often. How much farther they are is found up to the third one. */
enum { TOUCH = 1, MERGE = 2, FARTHEST = 8 };

/* Tiles around those of its copies that a place has at least, so that no particle leaves it in a step unless it is faster (then
   MPMContactsFollow notices it); and, with half as many as those, when it is made. */
enum { LEAST = 1, AROUND = 2 };

#define FASTER 2 /* than the fastest one at the end of a step particles may have moved in it; nodes are, but hardly */

/* For each copy the other ones (bits) that have a tile as near as this to one of its own. */
typedef uint32_t Others[MPM_MAX_COPIES];
_Static_assert(MPM_MAX_COPIES <= 32, "copies are the bits of a number of 32");

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

/* Sets the tiles on the stacked axis among which the copies of each place have their matter, first .. last-1, with some
   around them: roomy: so many that bodies can move for long; else as many as they may need in the next step. Matter that is
   still to flow in may be anywhere. */
static void SetRange(const MPMCore *core, PetscInt places, const PetscInt place[], PetscBool roomy, PetscInt first[],
                     PetscInt last[])
{
  const MPMContactTiles *t    = &core->contacts->tiles;
  const PetscInt         axis = core->grid.stack, n = t->n[axis];

  for (PetscInt p = 0; p < places; p++) first[p] = n, last[p] = 0;
  for (PetscInt c = 0; c < core->grid.copies; c++) {
    if (t->box[c][3 + axis] < 0) continue; /* no particles */
    first[place[c]] = PetscMin(first[place[c]], -t->box[c][axis]);
    last[place[c]]  = PetscMax(last[place[c]], t->box[c][3 + axis] + 1);
  }
  for (PetscInt p = 0; p < places; p++) {
    const PetscInt by = core->particles.waiting ? n : roomy ? AROUND + PetscMax(0, last[p] - first[p]) / 2 : LEAST;

    first[p] = PetscMin(PetscMax(0, first[p] - by), n - 1);
    last[p]  = PetscMin(n, PetscMax(first[p] + 1, last[p] + by));
  }
}

/* Returns how many nodes the grid has on the stacked axis from node 0 on. */
static PetscInt Nodes(const MPMGrid *grid)
{
  return grid->cells[grid->stack] + grid->layers[grid->stack] + 1;
}

/* Returns whether the places have the nodes that their copies may need in the next step, and not far more. */
static PetscBool AreFit(const MPMCore *core)
{
  const MPMGrid *grid = &core->grid;
  const PetscInt edge = MPMTileEdge(core->basis);
  PetscInt       first[MPM_MAX_COPIES], last[MPM_MAX_COPIES];

  SetRange(core, grid->places, grid->place, PETSC_FALSE, first, last);
  for (PetscInt p = 1; p < grid->places; p++) {
    const PetscInt needs = edge * (last[p] - first[p]);

    if (grid->low[p] > edge * first[p] || grid->high[p] < PetscMin(Nodes(grid), edge * last[p])) return PETSC_FALSE;
    if (grid->high[p] - grid->low[p] > 3 * needs + 4 * AROUND * edge) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Gives the grid these places, each with nodes around its copies, or, if anywhere, with all nodes; and the particles their
   cells there. Collective on exchange.data. */
static PetscErrorCode TakePlaces(MPMCore *core, PetscInt places, const PetscInt place[], PetscBool anywhere)
{
  MPMGrid       *grid = &core->grid;
  const PetscInt edge = MPMTileEdge(core->basis);
  PetscInt       first[MPM_MAX_COPIES], last[MPM_MAX_COPIES];

  PetscFunctionBeginUser;
  SetRange(core, places, place, PETSC_TRUE, first, last);
  for (PetscInt p = 1; p < places; p++) {
    grid->low[p]  = anywhere ? 0 : edge * first[p] / MPM_GRID_APART * MPM_GRID_APART;
    grid->high[p] = anywhere ? Nodes(grid) : PetscMin(Nodes(grid), edge * last[p]);
  }
  PetscCall(PetscArraymove(grid->place, place, grid->copies));
  grid->places = places;
  MPMGridSetNodes(grid, core->basis);
  PetscCall(core->exchange.type->renew(core));
  PetscCall(core->exchange.type->settle(core, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a particle here has left the nodes that its place has. */
static PetscBool AnyBeyond(const MPMCore *core, const MPMView *view)
{
  const MPMGrid      *grid = &core->grid;
  const MPMParticles *p    = &core->particles;
  const PetscInt      all = p->nmovers < 0 ? p->n : p->nmovers, reach = MPMBasisNodes(core->basis);
  PetscReal           xi[3];
  PetscInt            base[3] = {0};

  for (PetscInt m = 0; m < all; m++) {
    const PetscInt q     = p->nmovers < 0 ? m : p->movers[m] < 0 ? MPM_FLAGGED(p->movers[m]) : p->movers[m];
    const PetscInt at    = p->nmovers < 0 ? m : p->order[q];
    const MPMKind *kind  = MPMKindOf(core->params.kinds, view, at);
    const PetscInt place = grid->place[kind->copy], low = grid->low[place];

    if (!place || !MPMLocate((int)grid->dim, core->basis, grid, kind->copy, MPMPlaces(grid, view) + at * grid->dim,
                             MPMHalfWidths((int)grid->dim, core->params.kinds, view, at), xi, base))
      continue;
    base[grid->stack] -= grid->first[place];
    if ((low && base[grid->stack] < low) ||
        (grid->high[place] < Nodes(grid) && base[grid->stack] + reach > grid->high[place]))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscErrorCode MPMContactsFollow(MPMCore *core, PetscBool *settled)
{
  const PetscInt fields = MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(kind) | MPM_BIT(l);
  PetscInt64     ids;
  MPMView        view;

  PetscFunctionBeginUser;
  core->contacts->moved += FASTER * core->params.dt * PetscSqrtReal(core->status.v2) / MPMGridSmallestH(&core->grid);
  *settled = PETSC_FALSE;
  if (core->grid.places < 2 || !core->status.moved) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  *settled = AnyBeyond(core, &view);
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, settled, 1, MPM_MPI_BOOL, MPI_LOR, core->exchange.data));
  if (!*settled) PetscFunctionReturn(PETSC_SUCCESS);
  if (core->status.bad == MPM_GONE) PetscCall(MPMExchangeRemove(core, &ids));
  PetscCall(TakePlaces(core, core->grid.places, core->grid.place, PETSC_TRUE));
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

/* Sets by fewer than how many cells copies have to approach each other to have tiles that are too near for one place. Of tiles
   that are `by` or more from each other two may come next to each other by two cells, and so for each tile less by all of its
   cells. all: the tiles of all processes are known, else their boxes alone. */
static void SetClear(MPMCore *core, PetscBool all)
{
  MPMContacts *c  = core->contacts;
  PetscInt     by = MERGE;
  Others       near;

  while (by < FARTHEST && !(all ? SetOthers(core, by, near) : AnyBoxesMeet(core, by))) by++;
  c->clear   = PetscMax(0, (by - PartsAt(core) - 2) * MPMTileEdge(core->basis) + 2);
  c->moved   = 0;
  c->waiting = core->particles.waiting;
}

/* Returns whether all copies are at one place and still too far from each other for anything else. A particle has passed the
   ends of at most as many cells as it may have moved, rounded up. */
static PetscBool AreClear(const MPMCore *core)
{
  const MPMContacts *c = core->contacts;

  return c->moved < FARTHEST && 2 * (PetscInt)PetscCeilReal(c->moved) < c->clear && core->grid.places < 2 &&
         c->waiting == core->particles.waiting;
}

PetscErrorCode MPMContactsSettle(MPMCore *core)
{
  MPMGrid  *grid = &core->grid;
  PetscInt  place[MPM_MAX_COPIES], places;
  PetscBool meet, parts = PETSC_FALSE;
  Others    near;

  PetscFunctionBeginUser;
  if (!core->contacts || grid->copies < 2 || AreClear(core)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMContactFindTiles(core));
  core->contacts->near = PETSC_FALSE;
  meet                 = AnyBoxesMeet(core, MERGE);
  if (meet) PetscCall(MPMContactCollectTiles(core));
  SetClear(core, meet);
  if (!meet && grid->places < 2) PetscFunctionReturn(PETSC_SUCCESS);
  core->contacts->near = SetOthers(core, TOUCH, near);
  (void)SetOthers(core, PartsAt(core), near);
  for (PetscInt a = 0; a < grid->copies; a++)
    for (PetscInt b = 0; b < a; b++)
      if (near[a] >> b & 1 && grid->place[a] == grid->place[b]) parts = PETSC_TRUE;
  (void)SetOthers(core, MERGE, near);
  places = SetPlaces(grid->copies, near, place);
  if (parts || places < PetscMax(1, grid->places) || !AreFit(core))
    PetscCall(TakePlaces(core, places, place, PETSC_FALSE));
  PetscCall(MPMContactListTiles(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}
