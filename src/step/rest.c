/* rest.c - whether the bodies are at rest: the largest force out of balance on a node, as a part of the largest force
   that acts, after each step of a run that asks for it (-history_rest, -time_rest). With the kinetic energy over the
   strain energy it says since when the bodies are at rest. It changes no state, and all its results are maxima, which
   have the same bits on any number of processes. */
#include "parallel/exchange.h"
#include "step/static.h"
#include "step/step.h"

PetscErrorCode MPMRestSetFromOptions(MPMCore *core, MPMOptions o)
{
  MPMRest  *r = &core->rest;
  PetscBool hold;

  PetscFunctionBeginUser;
  r->since = -1;
  if (core->implicit) {
    const PetscBool moves = core->implicit->inertia;
    const char     *by    = moves ? "-method_time euler or newmark" : "-method_time static";
    const char     *why   = moves ? "rest is looked for in explicit steps; static finds it" : "each step ends at rest";

    if (moves) PetscCall(MPMOptionsRefuse(o, "history_rest", "false", by, why));
    PetscCall(MPMOptionsRefuse(o, "time_rest", "0", by, why));
  }
  PetscCall(MPMOptionsBool(o, "history_rest", NULL, core->implicit ? &r->aside : &r->shown));
  PetscCall(MPMOptionsReal(o, "time_rest", NULL, &r->limit, NULL));
  PetscCall(MPMOptionsReal(o, "time_rest_hold", NULL, &r->hold, &hold));
  if (hold && !(r->limit > 0) && !MPMOptionsOverridden("time_rest_hold", "time_rest"))
    MPMOptionsFail(o, "-time_rest_hold does not apply: -time_rest is not given");
  r->on = r->shown || r->limit > 0;
  if (r->on) r->unbalanced = NAN; /* until the first step */
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MPMRestHold(const MPMCore *core)
{
  PetscReal longest = 0;

  for (PetscInt d = 0; d < core->grid.dim; d++) longest = PetscMax(longest, core->grid.upper[d] - core->grid.lower[d]);
  return core->rest.hold > 0 ? core->rest.hold : 2 * longest / PetscSqrtReal(core->status.c2);
}

/* Raises largest [2] to the size of the force out of balance on node n, number i on x, and of the forces that act on
   it: those of the stress and loads, which at a wall are what the wall bears, and its weight. */
static void AddNode(const MPMCore *core, const MPMNode *n, PetscInt i, const PetscReal motion[], PetscReal largest[])
{
  const PetscInt   dim     = core->grid.dim;
  const PetscReal *g       = core->params.gravity;
  PetscReal        size[3] = {0};

  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal m = MPMNodeMass(&core->grid, n, i, d);

    size[0] += PetscSqr(core->grid.total ? n->f[d] + m * g[d] + n->p[d] : m * motion[dim + d]);
    size[1] += PetscSqr(n->f[d]);
    size[2] += PetscSqr(m * g[d]);
  }
  largest[0] = PetscMax(largest[0], size[0]);
  largest[1] = PetscMax(largest[1], PetscMax(size[1], size[2]));
}

/* Raises *largest to the squared force of body forces and loads on a cell full of the matter of any particle: where
   loads are in balance with each other, the sum of all forces on a node is 0. */
static PetscErrorCode AddLoads(MPMCore *core, PetscReal *largest)
{
  const PetscInt dim = core->grid.dim, fields = MPM_BIT(kind) | MPM_BIT(b) | MPM_BIT(S);
  PetscReal      cell = 1;
  MPMView        view;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) cell *= core->grid.h[d];
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMKind  *kind  = MPMKindOf(core->params.kinds, &view, p);
    const PetscReal share = core->grid.round ? kind->V0 : cell, density = kind->m / kind->V0; /* V0 is of a full turn */
    PetscReal       body = 0, surface = 0;

    for (PetscInt d = 0; d < dim && view.b; d++) body += PetscSqr(share * density * view.b[p * dim + d]);
    for (PetscInt k = 0; k < dim * dim && view.S; k++)
      surface += PetscSqr(share / MPMGridSmallestH(&core->grid) * view.S[p * dim * dim + k]);
    *largest = PetscMax(*largest, PetscMax(body, surface));
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRestStep(MPMCore *core)
{
  const MPMPatch *patch      = &core->exchange.patch;
  const PetscInt  nc         = MPM_MOTION_NC(core->grid.dim);
  PetscReal       largest[2] = {0};

  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, MPM_TIMER_FORCES));
  MPMWorkBegin(&core->timers);
  PetscCall(MPMExchangeOpenNodes(core));
  MPM_FOR_OWN_ROWS(patch, r)
  for (PetscInt i = r.first; i < r.last; i++)
    if (r.sum[i].m > 0) AddNode(core, r.sum + i, r.ijk[0] + i, r.motion + i * nc, largest);
  PetscCall(MPMExchangeCloseNodes(core));
  if (core->needs.forced) PetscCall(AddLoads(core, &largest[1]));
  MPMWorkEnd(&core->timers, MPM_TIMER_FORCES, NULL, 0);
  PetscCall(MPMTimersEnd(&core->timers, MPM_TIMER_FORCES));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPIU_REAL, MPI_MAX, core->exchange.data));
  core->rest.unbalanced = largest[1] > 0 ? PetscSqrtReal(largest[0] / largest[1]) : largest[0] > 0 ? PETSC_INFINITY : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMRestNote(MPMCore *core, PetscReal share)
{
  MPMRest *r = &core->rest;

  if (!(r->unbalanced <= r->limit && share <= r->limit))
    r->since = -1;
  else if (r->since < 0)
    r->since = core->t;
  r->reached = r->since >= 0 && core->t >= r->since + MPMRestHold(core);
}
