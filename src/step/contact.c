/* contact.c - what bodies that meet do to each other's nodes. The nodes that have matter of both are put together in columns:
   those that follow each other along the axis that the normal is nearest to (contact_find.c). If the matter of both sides
   of a column would come nearer to each other than its gap allows, it gets an impulse at the surface, and the opposite one
   on the other side: along the mean normal of the column, and by friction against the velocity along the surface.

   The surface of side s has for node k the weight N_sk = - sum_p V_p n_s . d phi_kp/dx, n_s into its matter: by it the
   matter ends with the velocity w_s = sum_k N_sk v_sk, where sum_k N_sk = 1, and an impulse p there is the part N_sk p of
   node k, as a uniform stress has it. The relative velocity changes by p sum_sk N_sk^2/m_sk. A node alone would also hold
   the matter behind the surface, over the reach of a stencil.

   Of the sums over processes all terms but one are 0: so all have the same bits in every sequence. Every process knows all
   columns. docs/method.md has the formulas (Contact). */
#include "parallel/exchange.h"
#include "physics/wall.h"
#include "step/step.h"

PetscErrorCode MPMContactsDestroy(MPMCore *core)
{
  MPMContacts *c = core->contacts;

  PetscFunctionBeginUser;
  if (!c) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(c->pair));
  PetscCall(PetscFree(c->node));
  PetscCall(PetscFree(c->column));
  PetscCall(PetscFree(c->sum));
  PetscCall(PetscFree(core->contacts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number in the patch of a node of a copy if this process owns it, else -1. */
static PetscInt Own(const MPMPatch *patch, PetscInt copy, const PetscInt ijk[])
{
  PetscInt at = 0;

  for (PetscInt d = 2; d >= 0; d--) {
    const PetscInt i = ijk[d] + MPMGridFirst(patch->grid, d, copy);

    if (i < patch->own_lo[d] || i >= patch->own_lo[d] + patch->own_n[d]) return -1;
    at = at * patch->n[d] + i - patch->lo[d];
  }
  return at;
}

/* Collects mass and velocity [2][4] of the nodes of columns first .. last-1. Collective on exchange.data. */
static PetscErrorCode Motion(MPMCore *core, PetscInt first, PetscInt last)
{
  const MPMPatch *patch = &core->exchange.patch;
  MPMContacts    *c     = core->contacts;
  const PetscInt  dim = core->grid.dim, from = c->column[first].first, to = c->column[last - 1].last;
  PetscMPIInt     count;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(c->sum + 8 * from, 8 * (to - from)));
  for (PetscInt k = from; k < to; k++)
    for (int side = 0; side < 2; side++) {
      const MPMPair *pair = &c->pair[c->node[k].pair];
      const PetscInt at   = Own(patch, side ? pair->b : pair->a, c->node[k].ijk);
      PetscReal     *sum  = c->sum + 8 * k + 4 * side;

      if (at < 0 || !(patch->node[at].m > 0)) continue;
      sum[0] = patch->node[at].m;
      for (PetscInt d = 0; d < dim; d++) sum[1 + d] = patch->motion[at * MPM_MOTION_NC(dim) + d];
    }
  PetscCall(PetscMPIIntCast(8 * (to - from), &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, c->sum + 8 * from, count, MPIU_REAL, MPI_SUM, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the impulse J [3] of column c on b, N s, and whether there is one; sets the shares of its nodes. */
static PetscBool Impulse(MPMCore *core, const MPMPhase *phase, MPMContactColumn *to, PetscReal J[])
{
  const PetscInt  dim     = core->grid.dim;
  const PetscBool advance = phase->nodes == MPMNodesAdvance ? PETSC_TRUE : PETSC_FALSE;
  MPMContacts    *c       = core->contacts;
  const MPMPair  *pair    = &c->pair[c->node[to->first].pair];
  PetscReal       all[2] = {0}, n[3] = {0}, v[3] = {0}, size = 0, w = 0, inverse = 0, slide = 0, press, stop;

  for (PetscInt k = to->first; k < to->last; k++)
    for (int side = 0; side < 2; side++) {
      c->node[k].share[side] = c->sum[8 * k + 4 * side] > 0 ? (PetscReal)PetscMax(0, c->node[k].weight[side]) : 0;
      all[side] += c->node[k].share[side];
    }
  if (!(all[0] > 0 && all[1] > 0)) return PETSC_FALSE;
  for (PetscInt k = to->first; k < to->last; k++)
    for (int side = 0; side < 2; side++) {
      PetscReal *share = &c->node[k].share[side];

      *share /= all[side];
      if (!(*share > 0)) continue;
      for (PetscInt d = 0; d < dim; d++) {
        n[d] += *share * c->node[k].n[d];
        v[d] += (side ? 1 : -1) * *share * c->sum[8 * k + 4 * side + 1 + d];
      }
      inverse += *share * *share / c->sum[8 * k + 4 * side];
    }
  for (PetscInt d = 0; d < dim; d++) size += n[d] * n[d];
  if (!(size > 0)) return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) {
    n[d] /= PetscSqrtReal(size);
    w += n[d] * v[d];
  }
  if (advance || phase->nodes == MPMNodesVelocity) {
    if (advance) to->held = w < to->least ? PETSC_TRUE : PETSC_FALSE;
    if (!(w < to->least)) return PETSC_FALSE;
    press = (to->least - w) / inverse;
    if (advance) to->to = to->least;
  } else {
    if (!to->held || phase->nodes == MPMNodesResidual) return PETSC_FALSE;
    press = (to->to - w) / inverse;
  }
  for (PetscInt d = 0; d < dim; d++) {
    v[d] -= w * n[d];
    slide += v[d] * v[d];
  }
  slide = PetscSqrtReal(slide);
  stop  = advance && slide > 0 ? PetscMin(pair->mu * press, slide / inverse) / slide : 0;
  for (PetscInt d = 0; d < dim; d++) J[d] = press * n[d] - stop * v[d];
  return PETSC_TRUE;
}

/* Adds to the velocity of node `at` of the patch what an impulse by its mass does, and to its acceleration in the advance;
   walls hold it all the same. */
static void Push(MPMCore *core, const MPMPhase *phase, PetscInt copy, const PetscInt ijk[], PetscInt at,
                 const PetscReal by[])
{
  const MPMPatch *patch = &core->exchange.patch;
  const MPMGrid  *grid  = &core->grid;
  const PetscInt  dim   = grid->dim;
  PetscReal      *v = patch->motion + at * MPM_MOTION_NC(dim), before[3];
  PetscInt        of[3] = {0};

  for (PetscInt d = 0; d < dim; d++) {
    of[d]     = ijk[d] + MPMGridFirst(grid, d, copy);
    before[d] = v[d];
    v[d] += by[d];
  }
  (void)MPMWallsApply(core->params.walls->given, grid, of, 0, v);
  for (PetscInt d = 0; d < dim && phase->nodes == MPMNodesAdvance; d++) v[dim + d] += (v[d] - before[d]) / core->params.kick;
}

/* Gives own nodes of a column their parts of its impulse. */
static void Give(MPMCore *core, const MPMPhase *phase, const MPMContactColumn *to, const PetscReal J[])
{
  const MPMContacts *c = core->contacts;

  for (PetscInt k = to->first; k < to->last; k++)
    for (int side = 0; side < 2; side++) {
      const MPMContactNode *q    = &c->node[k];
      const PetscInt        copy = side ? c->pair[q->pair].b : c->pair[q->pair].a;
      const PetscInt        at   = Own(&core->exchange.patch, copy, q->ijk);
      PetscReal             by[3];

      if (at < 0 || !(q->share[side] > 0)) continue;
      for (PetscInt d = 0; d < core->grid.dim; d++) by[d] = (side ? 1 : -1) * q->share[side] * J[d] / c->sum[8 * k + 4 * side];
      Push(core, phase, copy, q->ijk, at, by);
    }
}

/* Gives the nodes of bodies that move as one the same velocity. */
static void Glue(MPMCore *core, const MPMPhase *phase, const MPMContactColumn *to)
{
  const MPMContacts *c = core->contacts;

  for (PetscInt k = to->first; k < to->last; k++)
    for (int side = 0; side < 2; side++) {
      const MPMContactNode *q    = &c->node[k];
      const PetscReal      *own = c->sum + 8 * k + 4 * side, *other = c->sum + 8 * k + 4 * !side;
      const PetscInt        copy = side ? c->pair[q->pair].b : c->pair[q->pair].a;
      const PetscInt        at   = Own(&core->exchange.patch, copy, q->ijk);
      PetscReal             by[3];

      if (at < 0 || !(own[0] > 0 && other[0] > 0)) continue;
      for (PetscInt d = 0; d < core->grid.dim; d++) by[d] = other[0] / (own[0] + other[0]) * (other[1 + d] - own[1 + d]);
      Push(core, phase, copy, q->ijk, at, by);
    }
}

PetscErrorCode MPMContactsAfter(MPMCore *core, const MPMPhase *phase)
{
  MPMContacts *c = core->contacts;

  PetscFunctionBeginUser;
  for (PetscInt first = 0, last; first < c->ncolumns; first = last) { /* the columns of a pair */
    const PetscInt pair = c->node[c->column[first].first].pair;

    for (last = first + 1; last < c->ncolumns && c->node[c->column[last].first].pair == pair;) last++;
    PetscCall(Motion(core, first, last)); /* as the pair before has left it */
    for (PetscInt k = first; k < last; k++) {
      PetscReal J[3] = {0};

      if (c->pair[pair].glued)
        Glue(core, phase, &c->column[k]);
      else if (Impulse(core, phase, &c->column[k], J))
        Give(core, phase, &c->column[k], J);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
