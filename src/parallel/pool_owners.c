/* pool_owners.c - which worker keeps the particles of a tile (-pool_particles workers). The master chooses the owners when
   it hands out all particles, and anew when their numbers have become unequal; pool_keep.c has the overview. */
#include "kernels/tile_index.h"
#include "parallel/pool_keep.h"

/* The sequence is cut anew when imbalance has cost a pass over this share of all particles. Moving a particle costs the
   master about as much as a few passes over it, and only a part of them moves. */
#define MPM_RECUT 0.5

/* Lists the patch's own tiles: patches of so many cells an edge one after the other, back and forth along each axis, and
   in a patch its tiles, x fastest. */
PetscErrorCode MPMKeepSequence(MPMCore *core, MPMKeep *keep)
{
  const MPMTiles *t    = &core->exchange.patch.tiles;
  const PetscInt  edge = core->exchange.pool_cells / MPMTileEdge(core->basis);
  PetscInt        n[3], lo[3], own[3], total = 1;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) {
    own[d] = t->n[d] - t->below[d];
    n[d]   = (own[d] + edge - 1) / edge;
    total *= n[d];
  }
  keep->nsequence = 0;
  PetscCall(PetscMalloc1(own[0] * own[1] * own[2], &keep->sequence));
  for (PetscInt q = 0; q < total; q++) {
    const PetscInt k = q / (n[0] * n[1]), j = q / n[0] % n[1], i = q % n[0];
    const PetscInt at[3] = {(j + k * n[1]) % 2 ? n[0] - 1 - i : i, k % 2 ? n[1] - 1 - j : j, k};
    PetscInt       hi[3];

    for (PetscInt d = 0; d < 3; d++) {
      lo[d] = t->below[d] + at[d] * edge;
      hi[d] = PetscMin(lo[d] + edge, t->n[d]);
    }
    for (PetscInt z = lo[2]; z < hi[2]; z++)
      for (PetscInt y = lo[1]; y < hi[1]; y++)
        for (PetscInt x = lo[0]; x < hi[0]; x++) keep->sequence[keep->nsequence++] = (z * t->n[1] + y) * t->n[0] + x;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cuts the sequence by the numbers of particles: sets owner [ntiles], and returns the largest number of a worker over
   the mean. */
static PetscReal Cut(const MPMCore *core, const MPMKeep *keep, PetscInt owner[])
{
  const PetscInt64 workers = keep->base.size - 1, total = PetscMax(1, core->particles.n);
  PetscInt64       before = 0, most = 0, mine = 0;
  PetscInt         now = 1;

  for (PetscInt k = 0; k < keep->base.ntiles; k++) owner[k] = 1;
  for (PetscInt k = 0; k < keep->nsequence; k++) {
    const PetscInt64 n  = keep->count[keep->sequence[k]];
    const PetscInt   to = 1 + (PetscInt)PetscMin(workers - 1, (before + n / 2) * workers / total);

    if (to != now) mine = 0;
    now = owner[keep->sequence[k]] = to;
    mine += n;
    most = PetscMax(most, mine);
    before += n;
  }
  return (PetscReal)most * (PetscReal)workers / (PetscReal)total;
}

/* Where tile `tile` of the table is a copy of an uppermost one across periodic faces, returns that one. */
static PetscInt Original(const MPMTiles *t, PetscInt tile)
{
  PetscInt at[3] = {tile % t->n[0], tile / t->n[0] % t->n[1], tile / (t->n[0] * t->n[1])};

  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt own = t->n[d] - t->below[d];

    if (at[d] < t->below[d]) at[d] += (t->below[d] - at[d] + own - 1) / own * own;
  }
  return (at[2] * t->n[1] + at[1]) * t->n[0] + at[0];
}

/* Notes at the nodes of a tile that its owner has it (note), or else returns whether some have several owners. */
static PetscBool VisitNodes(const MPMPatch *patch, PetscInt tile, PetscBool note, PetscInt owner, PetscInt *whose)
{
  const MPMTiles   *t = &patch->tiles;
  const MPMTileBox *x = &t->box[0][tile % t->n[0]], *y = &t->box[1][tile / t->n[0] % t->n[1]],
                   *z = &t->box[2][tile / (t->n[0] * t->n[1])];
  PetscBool several   = PETSC_FALSE;

  for (PetscInt k = z->from; k < z->to; k++)
    for (PetscInt j = y->from; j < y->to; j++) {
      PetscInt *node = whose + ((k + z->at) * patch->n[1] + j + y->at) * patch->n[0] + x->at;

      for (PetscInt i = x->from; i < x->to; i++) {
        if (note) node[i] = node[i] < 0 || node[i] == owner ? owner : 0;
        if (!node[i]) several = PETSC_TRUE;
      }
    }
  return several;
}

/* Every tile counts, with particles or not, so all processes find the same. The sums of copies are added by the
   master. */
void MPMKeepFindBorders(MPMCore *core, MPMKeepBase *base)
{
  const MPMPatch *patch = &core->exchange.patch;
  const MPMTiles *t     = &patch->tiles;

  for (PetscInt i = 0; i < MPMPatchNodes(patch); i++) base->whose[i] = -1;
  for (PetscInt tile = 0; tile < base->ntiles; tile++)
    (void)VisitNodes(patch, tile, PETSC_TRUE, Original(t, tile) == tile ? base->owner[tile] : 0, base->whose);
  for (PetscInt tile = 0; tile < base->ntiles; tile++)
    base->border[tile] = VisitNodes(patch, tile, PETSC_FALSE, 0, base->whose);
  for (PetscInt tile = 0; tile < base->ntiles; tile++)
    if (Original(t, tile) != tile) base->border[Original(t, tile)] = 1;
}

/* Finds the nodes that the particles of each worker read, and how many particles it has. */
PetscErrorCode MPMKeepFindSpans(MPMCore *core, MPMKeep *keep)
{
  const MPMPatch *patch = &core->exchange.patch;
  const MPMTiles *t     = &patch->tiles;
  const PetscInt  rows  = patch->n[1] * patch->n[2];

  PetscFunctionBeginUser;
  for (PetscMPIInt w = 1; w < keep->base.size; w++) {
    for (PetscInt r = 0; r < rows; r++) {
      keep->worker[w].span[2 * r]     = patch->n[0];
      keep->worker[w].span[2 * r + 1] = 0;
    }
    keep->worker[w].particles = 0;
  }
  for (PetscInt tile = 0; tile < keep->base.ntiles; tile++) {
    MPMKeepWorker    *w      = &keep->worker[keep->base.owner[tile]];
    const MPMTileBox *box[3] = {&t->box[0][tile % t->n[0]], &t->box[1][tile / t->n[0] % t->n[1]],
                                &t->box[2][tile / (t->n[0] * t->n[1])]};
    PetscInt          lo[3], hi[3];

    if (!keep->count[tile]) continue;
    w->particles += keep->count[tile];
    for (PetscInt d = 0; d < 3; d++) {
      lo[d] = box[d]->at;
      hi[d] = PetscMin(box[d]->at + box[d]->end, patch->n[d]);
    }
    for (PetscInt k = lo[2]; k < hi[2]; k++)
      for (PetscInt j = lo[1]; j < hi[1]; j++) {
        PetscInt *span = w->span + 2 * (k * patch->n[1] + j);

        span[0] = PetscMin(span[0], lo[0]);
        span[1] = PetscMax(span[1], hi[0]);
      }
  }
  keep->most = 0;
  for (PetscMPIInt w = 1; w < keep->base.size; w++) keep->most = PetscMax(keep->most, keep->worker[w].particles);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes that a worker is to get the particle in a row here. */
PetscErrorCode MPMKeepGives(MPMKeepWorker *w, PetscInt row)
{
  PetscFunctionBeginUser;
  if (w->n == w->capacity) {
    w->capacity = 2 * w->capacity + 64;
    PetscCall(PetscRealloc((size_t)w->capacity * sizeof *w->list, &w->list));
  }
  w->list[w->n++] = row;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the largest number of particles of a worker over the mean, with the owners that there are. */
static PetscReal Imbalance(const MPMCore *core, MPMKeep *keep)
{
  PetscInt most = 0;

  for (PetscMPIInt w = 1; w < keep->base.size; w++) keep->worker[w].particles = 0;
  for (PetscInt tile = 0; tile < keep->base.ntiles; tile++)
    keep->worker[keep->base.owner[tile]].particles += keep->count[tile];
  for (PetscMPIInt w = 1; w < keep->base.size; w++) most = PetscMax(most, keep->worker[w].particles);
  return (PetscReal)most * (PetscReal)(keep->base.size - 1) / (PetscReal)PetscMax(1, core->particles.n);
}

/* Gives every particle to the owner of its tile; the owners are chosen anew, unless those that there are divide the
   particles nearly as well. The next job hands them out. */
PetscErrorCode MPMKeepHandOut(MPMCore *core, MPMKeep *keep, PetscBool *anew)
{
  const MPMTiles *t         = &core->exchange.patch.tiles;
  const int       dim       = (int)core->grid.dim;
  MPMParticles   *particles = &core->particles;
  PetscInt        at[3], *owner;
  PetscReal       best;
  MPMView         view;

  PetscFunctionBeginUser;
  if (!keep->row) PetscCall(PetscMalloc1(particles->born, &keep->row));
  for (PetscInt64 id = 0; id < particles->born; id++) keep->row[id] = -1;
  PetscCall(PetscArrayzero(keep->count, keep->base.ntiles));
  PetscCall(MPMParticlesFingerprint(particles, &keep->ids));
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(id) | MPM_BIT(cell), &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscCheck(view.cell[p] >= 0 && view.id[p] >= 0 && view.id[p] < particles->born, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "particle %" PetscInt64_FMT " of cell %" PetscInt_FMT " cannot be handed out", view.id[p], view.cell[p]);
    keep->count[MPMTileOf(dim, t, view.cell[p], at)]++;
    keep->row[view.id[p]] = p;
  }
  PetscCall(PetscMalloc1(keep->base.ntiles, &owner));
  best            = Cut(core, keep, owner);
  keep->imbalance = keep->base.owner[0] ? Imbalance(core, keep) : PETSC_MAX_REAL;
  keep->lost      = 0;
  *anew           = keep->imbalance > 1.05 * best ? PETSC_TRUE : PETSC_FALSE;
  if (*anew) {
    keep->imbalance = best;
    PetscCall(PetscArraycpy(keep->base.owner, owner, keep->base.ntiles));
    MPMKeepFindBorders(core, &keep->base);
  }
  PetscCall(PetscFree(owner));
  for (PetscInt p = 0; p < view.n; p++)
    PetscCall(MPMKeepGives(&keep->worker[keep->base.owner[MPMTileOf(dim, t, view.cell[p], at)]], p));
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(id) | MPM_BIT(cell), &view));
  PetscCall(MPMKeepFindSpans(core, keep));
  keep->settle       = PETSC_TRUE;
  particles->current = ~0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Before the positions change: returns whether the owners have been chosen anew, since imbalance has cost too much. */
PetscErrorCode MPMKeepRecut(MPMCore *core, MPMKeep *keep, PetscBool *anew)
{
  const PetscReal mean = (PetscReal)core->particles.n / (PetscReal)(keep->base.size - 1), most = (PetscReal)keep->most;
  PetscReal       best;
  PetscInt       *owner;

  PetscFunctionBeginUser;
  *anew = PETSC_FALSE;
  keep->lost += PetscMax(0, most - mean * keep->imbalance);
  if (keep->lost < MPM_RECUT * (PetscReal)core->particles.n || !core->particles.n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(keep->base.ntiles, &owner));
  best            = Cut(core, keep, owner);
  *anew           = best < 0.97 * most / mean ? PETSC_TRUE : PETSC_FALSE;
  keep->lost      = 0;
  keep->imbalance = *anew ? best : most / mean;
  if (*anew) {
    PetscCall(PetscArraycpy(keep->base.owner, owner, keep->base.ntiles));
    MPMKeepFindBorders(core, &keep->base);
    core->exchange.recuts++;
  }
  PetscCall(PetscFree(owner));
  PetscFunctionReturn(PETSC_SUCCESS);
}
