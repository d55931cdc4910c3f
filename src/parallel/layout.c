/* layout.c - who is where in the spatial decomposition: owners of cells, neighbours, ghost nodes. Made once for
   a partition of the grid, from its numbers alone. */
#include "parallel/spatial.h"

/* The process that owns cell `base` (a node of the grid), and how many boxes away it is on each axis, above, or below
   if negative, the shorter way around where the axis is periodic; hops may be NULL. */
PetscMPIInt MPMSpatialOwner(const MPMSpatial *s, const MPMGrid *grid, const PetscInt base[], int hops[3])
{
  PetscInt rank = 0;

  for (PetscInt d = grid->dim - 1; d >= 0; d--) {
    PetscInt lo = 0, hi = s->p[d];

    while (hi - lo > 1) {
      const PetscInt mid = (lo + hi) / 2;
      if (s->first[d][mid] <= base[d])
        lo = mid;
      else
        hi = mid;
    }
    rank = rank * s->p[d] + lo;
    if (!hops) continue;
    hops[d] = (int)(lo - s->me[d]);
    if (grid->periodic[d] && 2 * hops[d] > s->p[d]) hops[d] -= (int)s->p[d];
    if (grid->periodic[d] && 2 * hops[d] < -s->p[d]) hops[d] += (int)s->p[d];
  }
  return (PetscMPIInt)rank;
}

/* Who is beside this box on each axis, for particles on their way; and neighbours: o in {0,1}^dim, not 0. The process
   at +o gets sums of my tiles at that side; the one at -o sends me those of its own. On an axis that is not cut there
   is none. */
static PetscErrorCode FindNeighbours(MPMCore *core, MPMSpatial *s)
{
  const PetscInt dim = core->grid.dim;
  PetscInt      *me = s->me, rest, along = 1;
  PetscMPIInt    rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(s->comm, &rank));
  rest = rank;
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt p = s->p[d], around = core->grid.periodic[d] && p > 1;

    me[d] = rest % p;
    rest /= p;
    for (int up = 0; up < 2; up++) {
      const PetscInt at = me[d] + (up ? 1 : -1);

      s->beside[d][up] = around || (at >= 0 && at < p) ? (PetscMPIInt)(rank + along * ((at + p) % p - me[d]))
                                                       : MPI_PROC_NULL;
    }
    along *= p;
  }
  for (int o = 1; o < 1 << dim; o++) {
    MPMNeighbour *to = &s->to[s->nto], *from = &s->from[s->nfrom];
    PetscBool     up = PETSC_TRUE, down = PETSC_TRUE;
    PetscInt      above = 0, below = 0, stride = 1;

    for (PetscInt d = 0; d < 3; d++) {
      const PetscInt off = o >> d & 1, last = s->p[d] - 1;

      to->toward[d] = from->toward[d] = (int)off;
      if (off && (last == 0 || (me[d] == last && !core->grid.periodic[d]))) up = PETSC_FALSE;
      if (off && (last == 0 || (me[d] == 0 && !core->grid.periodic[d]))) down = PETSC_FALSE;
      above += stride * ((me[d] + off) % s->p[d]);
      below += stride * ((me[d] + last * off) % s->p[d]);
      stride *= s->p[d];
    }
    to->rank   = (PetscMPIInt)above;
    from->rank = (PetscMPIInt)below;
    to->tag = from->tag = MPM_TAG_TILES + o;
    s->nto += up;
    s->nfrom += down;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* First node and number of nodes of the box of process c on axis d, ghosts included, as DMDA lays it out. */
static void GhostRange(MPMCore *core, const MPMSpatial *s, PetscInt d, PetscInt c, PetscInt *lo, PetscInt *n)
{
  const MPMGrid *g     = &core->grid;
  const PetscInt reach = d < g->dim ? MPMBasisNodes(core->basis) - 1 : 0, first = -g->layers[d],
                 last = first + g->nodes[d];
  const PetscInt end  = s->first[d][c] + core->exchange.partition.l[d][c];

  *lo = g->periodic[d] ? s->first[d][c] - reach : PetscMax(first, s->first[d][c] - reach);
  *n  = (g->periodic[d] ? end + reach : PetscMin(last, end + reach)) - *lo;
}

/* The ghost update of node values: a broadcast from the owners to the nodes above a patch, which alone its particles
   read. DMLocalToLocal would do the same and copy every own node onto itself: 3 % of a step. */
static PetscErrorCode CreateGhosts(MPMCore *core, MPMSpatial *s)
{
  const MPMPatch *patch = &core->exchange.patch;
  PetscInt        n     = 0, *leaf;
  PetscSFNode    *root;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(MPMPatchNodes(patch), &leaf));
  PetscCall(PetscMalloc1(MPMPatchNodes(patch), &root));
  for (PetscInt i = 0; i < MPMPatchNodes(patch); i++) {
    const PetscInt ijk[3] = {i % patch->n[0] + patch->lo[0], i / patch->n[0] % patch->n[1] + patch->lo[1],
                             i / (patch->n[0] * patch->n[1]) + patch->lo[2]};
    PetscInt       at[3], node = 0;
    PetscBool      above = PETSC_FALSE, below = PETSC_FALSE;

    for (PetscInt d = 0; d < 3; d++) {
      if (ijk[d] < patch->own_lo[d]) below = PETSC_TRUE;
      if (ijk[d] >= patch->own_lo[d] + patch->own_n[d]) above = PETSC_TRUE;
      at[d] = core->grid.periodic[d] && ijk[d] >= core->grid.nodes[d] ? ijk[d] - core->grid.nodes[d] : ijk[d];
    }
    if (below || !above) continue;
    root[n].rank = MPMSpatialOwner(s, &core->grid, at, NULL);
    for (PetscInt d = 2; d >= 0; d--) {
      PetscInt c = root[n].rank, lo, len;

      for (PetscInt e = 0; e < d; e++) c /= s->p[e];
      GhostRange(core, s, d, c % s->p[d], &lo, &len);
      node = node * len + at[d] - lo;
    }
    root[n].index = node;
    leaf[n++]     = i;
  }
  PetscCall(PetscSFCreate(s->comm, &s->ghosts));
  PetscCall(PetscSFSetGraph(s->ghosts, MPMPatchNodes(patch), n, leaf, PETSC_OWN_POINTER, root, PETSC_OWN_POINTER));
  PetscCall(PetscSFSetUp(s->ghosts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* DMDA, patch, neighbours and ghost update for the partition that is set. Collective. */
PetscErrorCode MPMSpatialLayout(MPMCore *core)
{
  MPMExchange        *ex   = &core->exchange;
  MPMSpatial         *s    = (MPMSpatial *)ex->ctx;
  const MPMPartition *part = &ex->partition;

  PetscFunctionBeginUser;
  PetscCall(MPMGridCreateDM(&core->grid, ex->data, MPMBasisNodes(core->basis) - 1, part->p, part->l, &ex->da));
  PetscCall(DMCreateLocalVector(ex->da, &ex->motion));
  PetscCall(MPMPatchSetBox(&ex->patch, &core->grid, core->basis, ex->da));
  PetscCall(MPMTilesSetUp(&ex->patch, ex->roundoff));
  for (PetscInt d = 0; d < 3; d++) {
    s->p[d] = part->p[d];
    PetscCall(PetscMalloc1(s->p[d], &s->first[d]));
    for (PetscInt r = 0, at = -core->grid.layers[d]; r < s->p[d]; at += part->l[d][r++]) s->first[d][r] = at;
  }
  s->nto = s->nfrom = 0;
  PetscCall(FindNeighbours(core, s));
  PetscCall(CreateGhosts(core, s));
  if (ex->roundoff) PetscCall(DMDACreateCompatibleDMDA(ex->da, MPM_NODE_NC, &s->sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Undoes it. */
PetscErrorCode MPMSpatialTearDown(MPMCore *core)
{
  MPMExchange *ex = &core->exchange;
  MPMSpatial  *s  = (MPMSpatial *)ex->ctx;

  PetscFunctionBeginUser;
  PetscCall(MPMPatchDestroy(&ex->patch));
  PetscCall(VecDestroy(&ex->motion));
  PetscCall(DMDestroy(&ex->da));
  PetscCall(DMDestroy(&s->sums));
  PetscCall(PetscSFDestroy(&s->ghosts));
  for (PetscInt d = 0; d < 3; d++) PetscCall(PetscFree(s->first[d]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
