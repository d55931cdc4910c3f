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

/* The same graph with nodes for units where `from` numbers the unknowns of a node, `unit` each. */
static PetscErrorCode NumberNodes(PetscInt unit, PetscSF from, PetscSF *sf)
{
  PetscInt           nroots, nleaves, *leaf;
  const PetscInt    *ilocal;
  const PetscSFNode *iremote;
  PetscSFNode       *root;

  PetscFunctionBeginUser;
  PetscCall(PetscSFGetGraph(from, &nroots, &nleaves, &ilocal, &iremote));
  PetscCall(PetscMalloc1(nleaves, &leaf));
  PetscCall(PetscMalloc1(nleaves, &root));
  for (PetscInt q = 0; q < nleaves; q++) {
    leaf[q]       = (ilocal ? ilocal[q] : q) / unit;
    root[q].rank  = iremote[q].rank;
    root[q].index = iremote[q].index / unit;
  }
  PetscCall(PetscSFCreate(PetscObjectComm((PetscObject)from), sf));
  PetscCall(
      PetscSFSetGraph(*sf, (nroots + unit - 1) / unit, nleaves, leaf, PETSC_OWN_POINTER, root, PETSC_OWN_POINTER));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The ghost update of node values: the DMDA's scatter from the global vector to local ones, restricted to the nodes
   above a patch, which alone its particles read; and where it would read the global vector, it reads the owner's local
   one, by that part of the scatter that is about own nodes, turned round. DMLocalToLocal would do the same and copy
   every own node onto itself: 3 % of a step. */
static PetscErrorCode CreateGhosts(MPMCore *core, MPMSpatial *s)
{
  const MPMPatch *patch = &core->exchange.patch;
  VecScatter      scatter;
  PetscSF         own, above, global, update;
  PetscInt        nroots, nleaves, nown = 0, nabove = 0, unit, *list[2];
  const PetscInt *ilocal;

  PetscFunctionBeginUser;
  PetscCall(DMDAGetScatter(core->exchange.da, &scatter, NULL));
  PetscCall(PetscSFGetGraph(scatter, &nroots, &nleaves, &ilocal, NULL));
  unit = nroots / (patch->own_n[0] * patch->own_n[1] * patch->own_n[2]); /* 1: it numbers nodes; else unknowns */
  PetscCall(PetscMalloc2(nleaves, &list[0], nleaves, &list[1]));
  for (PetscInt q = 0; q < nleaves; q++) {
    const PetscInt leaf = ilocal ? ilocal[q] : q;
    const int      side = MPMPatchSide(patch, leaf / unit);

    if (leaf % unit || side < 0) continue;
    if (side)
      list[1][nabove++] = q;
    else
      list[0][nown++] = q;
  }
  PetscCall(PetscSFCreateEmbeddedLeafSF(scatter, nown, list[0], &own));
  PetscCall(PetscSFCreateEmbeddedLeafSF(scatter, nabove, list[1], &above));
  PetscCall(PetscSFCreateInverseSF(own, &global)); /* from a local vector to the global one */
  PetscCall(PetscSFCompose(global, above, &update));
  PetscCall(NumberNodes(unit, update, &s->ghosts));
  PetscCall(PetscSFSetUp(s->ghosts));
  PetscCall(PetscSFDestroy(&update));
  PetscCall(PetscSFDestroy(&global));
  PetscCall(PetscSFDestroy(&above));
  PetscCall(PetscSFDestroy(&own));
  PetscCall(PetscFree2(list[0], list[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* DMs, patch, neighbours and ghost update for the partition that is set. Collective. */
PetscErrorCode MPMSpatialLayout(MPMCore *core)
{
  MPMExchange        *ex   = &core->exchange;
  MPMSpatial         *s    = (MPMSpatial *)ex->ctx;
  const MPMPartition *part = &ex->partition;

  PetscFunctionBeginUser;
  PetscCall(MPMExchangeCreateGrid(core, part->p, part->l));
  PetscCall(MPMTilesSetUp(&ex->patch, ex->roundoff));
  for (PetscInt d = 0; d < 3; d++) {
    s->p[d] = part->p[d];
    PetscCall(PetscMalloc1(s->p[d], &s->first[d]));
    for (PetscInt r = 0, at = -core->grid.layers[d]; r < s->p[d]; at += part->l[d][r++]) s->first[d][r] = at;
  }
  s->nto = s->nfrom = 0;
  PetscCall(FindNeighbours(core, s));
  PetscCall(CreateGhosts(core, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Undoes it. */
PetscErrorCode MPMSpatialTearDown(MPMCore *core)
{
  MPMSpatial *s = (MPMSpatial *)core->exchange.ctx;

  PetscFunctionBeginUser;
  PetscCall(MPMExchangeDestroyGrid(core));
  PetscCall(PetscSFDestroy(&s->ghosts));
  for (PetscInt d = 0; d < 3; d++) PetscCall(PetscFree(s->first[d]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
