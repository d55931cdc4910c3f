/* layout.c - where the processes of the spatial decomposition lie: owners of cells, neighbours, ghosts of nodes. It is
   made once for each partition of the grid, without messages about what other processes have. */
#include "parallel/spatial.h"

/* Returns the process that owns the cell whose lowest node is `base` [dim]. hops[axis] gets how many boxes away it is:
   positive above, negative below, by the shorter way around if the axis is periodic. hops may be NULL. Not
   collective. */
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

/* Finds the processes beside this box on each axis, to which leavers go, and the neighbours of the exchange of sums in
   the directions o of {0,1}^dim other than 0: the process at +o gets the sums of the tiles here at that side, and the
   one at -o sends the sums of its own. An axis that is not cut has no neighbours. */
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

/* Makes a graph with other numbers from the graph `from` of the unknowns of nodes: a node, which has `unit` numbers
   there, has `now` here, and the first of them is sent. */
static PetscErrorCode Renumber(PetscInt unit, PetscInt now, PetscSF from, PetscSF *sf)
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
    leaf[q]       = (ilocal ? ilocal[q] : q) / unit * now;
    root[q].rank  = iremote[q].rank;
    root[q].index = iremote[q].index / unit * now;
  }
  PetscCall(PetscSFCreate(PetscObjectComm((PetscObject)from), sf));
  PetscCall(PetscSFSetGraph(*sf, (nroots + unit - 1) / unit * now, nleaves, leaf, PETSC_OWN_POINTER, root,
                            PETSC_OWN_POINTER));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes from the DMDA's scatter, of which `leaves` [n] are chosen, the graph of an update that reads the owner's local
   vector: global is the way from there to the global one. A node has `unit` unknowns in the scatter, and `now` numbers
   in the graph. */
static PetscErrorCode CreateUpdate(VecScatter scatter, PetscInt n, PetscInt *leaves, PetscSF global, PetscInt unit,
                                   PetscInt now, PetscSF *sf)
{
  PetscSF some, update;

  PetscFunctionBeginUser;
  PetscCall(PetscSFCreateEmbeddedLeafSF(scatter, n, leaves, &some));
  PetscCall(PetscSFCompose(global, some, &update));
  PetscCall(Renumber(unit, now, update, sf));
  PetscCall(PetscSFSetUp(*sf));
  PetscCall(PetscSFDestroy(&update));
  PetscCall(PetscSFDestroy(&some));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the update of ghosts. It is the DMDA's scatter from the global vector to local ones, with two changes: it
   reaches only the ghosts above a patch, since its particles read no others; and it reads the owner's local vector
   instead of the global one, by the inverse of the scatter's part for own nodes. DMLocalToLocal would do the same, but
   would also copy every own node onto itself, which takes 3 % of a step. What light nodes need reaches all ghosts.
   Collective. */
static PetscErrorCode CreateGhosts(MPMCore *core, MPMSpatial *s)
{
  const MPMPatch *patch = &core->exchange.patch;
  VecScatter      scatter;
  PetscSF         own, global;
  PetscInt        nroots, nleaves, n[3] = {0}, unit, *list[3]; /* own nodes; ghosts above; all ghosts */
  const PetscInt *ilocal;

  PetscFunctionBeginUser;
  PetscCall(DMDAGetScatter(core->exchange.da, &scatter, NULL));
  PetscCall(PetscSFGetGraph(scatter, &nroots, &nleaves, &ilocal, NULL));
  unit = nroots / (patch->own_n[0] * patch->own_n[1] * patch->own_n[2]); /* 1: it numbers nodes, else unknowns */
  PetscCall(PetscMalloc3(nleaves, &list[0], nleaves, &list[1], nleaves, &list[2]));
  for (PetscInt q = 0; q < nleaves; q++) {
    const PetscInt leaf = ilocal ? ilocal[q] : q;
    const int      side = MPMPatchSide(patch, leaf / unit);

    if (leaf % unit) continue;
    if (side >= 0) list[side][n[side]++] = q;
    if (side) list[2][n[2]++] = q;
  }
  PetscCall(PetscSFCreateEmbeddedLeafSF(scatter, n[0], list[0], &own));
  PetscCall(PetscSFCreateInverseSF(own, &global)); /* from a local vector to the global one */
  for (int k = 0; k < 2; k++) PetscCall(CreateUpdate(scatter, n[1], list[1], global, unit, 2 - k, &s->ghosts[k]));
  if (core->params.light > 0) PetscCall(CreateUpdate(scatter, n[2], list[2], global, unit, 1, &core->exchange.around));
  PetscCall(PetscSFDestroy(&global));
  PetscCall(PetscSFDestroy(&own));
  PetscCall(PetscFree3(list[0], list[1], list[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes DMs, patch, neighbours and the update of ghosts for the partition that is set. Collective on exchange.data. */
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

/* Destroys what MPMSpatialLayout made. Collective on exchange.data. */
PetscErrorCode MPMSpatialTearDown(MPMCore *core)
{
  MPMSpatial *s = (MPMSpatial *)core->exchange.ctx;

  PetscFunctionBeginUser;
  PetscCall(MPMExchangeDestroyGrid(core));
  for (int k = 0; k < 2; k++) PetscCall(PetscSFDestroy(&s->ghosts[k]));
  PetscCall(PetscSFDestroy(&core->exchange.around));
  for (PetscInt d = 0; d < 3; d++) PetscCall(PetscFree(s->first[d]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
