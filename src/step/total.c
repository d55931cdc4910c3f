/* total.c - the total frame: the state of a run is on the nodes. Each has a displacement u [dim], m, and a velocity v [dim],
   m/s, in patch->state; weights are those of the reference positions, which never change. A step is one of leapfrog: forces
   make accelerations, with the mass matrix to the order that is asked for, these make v, and v makes u. Particles get
   x, v and F from the nodes. The kernels below follow a transfer to the nodes; equation numbers are those of
   docs/method.md (The total frame). */
#include "parallel/exchange.h"
#include "physics/wall.h"
#include "step/step.h"

#define START_ROUNDS 40 /* corrections of the first velocities; they cost 40 steps at most, once */

/* Returns whether a wall along y or z reaches a whole row. */
static PetscBool RowWalled(const MPMParams *par, const MPMGrid *grid, const MPMNodes *r)
{
  for (PetscInt d = 1; d < grid->dim; d++)
    if (MPMWallsReach(par->walls->given, grid, d, r->ijk[d])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Lets the walls hold velocity v [dim] of node i of a row. walled: one reaches the whole row. */
MPM_INLINE void Hold(const MPMParams *par, const MPMGrid *grid, const MPMNodes *r, PetscBool walled, PetscInt i,
                     PetscReal v[])
{
  const PetscInt ijk[3] = {r->ijk[0] + i, r->ijk[1], r->ijk[2]};

  if (walled || MPMWallsReach(par->walls->given, grid, 0, ijk[0]))
    (void)MPMWallsApply(par->walls->given, grid, ijk, par->kick, v);
}

/* Sets the acceleration a [dim] of node i, m/s^2: f/m + g, or `again` corrects it by (f - p)/m + g, where p are the sums of
   what the particles read of a, so that each correction brings it nearer to the solution of M a = f + M g with the full
   mass matrix M. Walls hold it: with what force, N, `wall` [dim] gets if it is not NULL. The sum of these over the nodes
   of all walls is the force on the body, since sum p = sum m a before the correction. */
MPM_INLINE void Acceleration(int dim, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r, PetscBool walled,
                             int again, PetscInt i, PetscReal a[], PetscReal wall[])
{
  const MPMNode   *n = r->sum + i;
  const PetscReal *v = r->state + i * MPM_MOTION_NC(dim) + dim;
  PetscReal        now[3], trial[3];

  for (int d = 0; d < dim; d++) {
    const PetscReal more = n->m > 0 ? (again ? n->f[d] - n->p[d] : n->f[d]) / n->m + par->gravity[d] : 0;

    a[d]   = again ? a[d] + more : more;
    now[d] = trial[d] = v[d] + par->kick * a[d];
  }
  Hold(par, grid, r, walled, i, now);
  for (int d = 0; d < dim; d++) {
    if (wall) wall[d] = now[d] != trial[d] ? n->m * (now[d] - trial[d]) / par->kick : 0;
    if (now[d] != trial[d]) a[d] = (now[d] - v[d]) / par->kick;
  }
}

/* Sets the acceleration of all nodes of a row, in the first numbers of the motion. */
MPM_INLINE void AccelerateRow(int dim, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r, int again)
{
  const PetscBool walled = RowWalled(par, grid, r);

  for (PetscInt i = r->first; i < r->last; i++)
    Acceleration(dim, par, grid, r, walled, again, i, r->motion + i * MPM_MOTION_NC(dim), NULL);
}

/* Does so, and moves the nodes: v <- v + kick a and u <- u + dt v. The motion becomes u and v, which particles read, and p
   the forces of walls, for the history. */
MPM_INLINE void KickRow(int dim, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r, int again)
{
  const PetscBool walled = RowWalled(par, grid, r);

  for (PetscInt i = r->first; i < r->last; i++) {
    PetscReal *motion = r->motion + i * MPM_MOTION_NC(dim), *u = r->state + i * MPM_MOTION_NC(dim), *v = u + dim, a[3];

    for (int d = 0; d < dim; d++) a[d] = again ? motion[d] : 0;
    Acceleration(dim, par, grid, r, walled, again, i, a, r->sum[i].p);
    for (int d = 0; d < dim; d++) v[d] += par->kick * a[d];
    Hold(par, grid, r, walled, i, v); /* once more, without rounding */
    for (int d = 0; d < dim; d++) {
      u[d] += par->dt * v[d];
      motion[d]       = u[d];
      motion[dim + d] = v[d];
    }
  }
}

/* Sets the first velocity p/m, where p are the sums of the particles' momentum, which are kept as f; `again` corrects it by
   (f - p)/m, as accelerations are corrected. */
MPM_INLINE void StartRow(int dim, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r, int again)
{
  const PetscBool walled = RowWalled(par, grid, r);

  for (PetscInt i = r->first; i < r->last; i++) {
    MPMNode   *n = r->sum + i;
    PetscReal *v = r->state + i * MPM_MOTION_NC(dim) + dim;

    for (int d = 0; d < dim; d++) {
      if (!again) v[d] = 0, n->f[d] = n->p[d];
      if (n->m > 0) v[d] += (again ? n->f[d] - n->p[d] : n->p[d]) / n->m;
    }
    Hold(par, grid, r, walled, i, v);
    for (int d = 0; d < dim; d++) r->motion[i * MPM_MOTION_NC(dim) + d] = v[d];
  }
}

/* The kernels that scheme.h declares; the number of dimensions is a constant in each call. */
#define NODE_KERNEL(name, what, again)                                                                                 \
  void MPMNodes##name(const MPMParams *par, const MPMPatch *patch, const MPMNodes *r)                                  \
  {                                                                                                                    \
    if (patch->grid->dim == 1) what(1, par, patch->grid, r, again);                                                    \
    if (patch->grid->dim == 2) what(2, par, patch->grid, r, again);                                                    \
    if (patch->grid->dim == 3) what(3, par, patch->grid, r, again);                                                    \
  }
NODE_KERNEL(Accelerate, AccelerateRow, 0)
NODE_KERNEL(AccelerateAgain, AccelerateRow, 1)
NODE_KERNEL(Kick, KickRow, 0)
NODE_KERNEL(KickAgain, KickRow, 1)
NODE_KERNEL(Start, StartRow, 0)
NODE_KERNEL(StartAgain, StartRow, 1)

/* Sets the velocities of nodes that give the particles theirs, field v, in the mean by mass. */
static PetscErrorCode Project(MPMCore *core)
{
  const MPMExchangeType *ex = core->exchange.type;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 2; k++)
    PetscCall(k ? ex->nodes(core, MPMStepStartPhase(core, k)) : ex->sweep(core, MPMStepStartPhase(core, k)));
  for (PetscInt k = 0; k < START_ROUNDS; k++) {
    PetscCall(ex->sweep(core, MPMStepStartPhase(core, 2)));
    PetscCall(ex->nodes(core, MPMStepStartPhase(core, 3)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Exchanges the particles' velocities and their displacements, which are in memory that the caller has, `other` [n][dim].
   Returns whether any is not 0 there. */
static PetscErrorCode Swap(MPMCore *core, PetscBool first, PetscReal other[], PetscBool *any)
{
  const PetscInt dim = core->grid.dim, fields = MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(v);
  MPMView        view;

  PetscFunctionBeginUser;
  *any = PETSC_FALSE;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt k = 0; k < view.n * dim; k++) {
    const PetscReal v = view.v[k];

    if (first) other[k] = view.x[k] - view.X[k];
    if (other[k] != 0) *any = PETSC_TRUE;
    view.v[k] = other[k];
    other[k]  = v;
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, any, 1, MPM_MPI_BOOL, MPI_LOR, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTotalStart(MPMCore *core, PetscBool restarted)
{
  const PetscInt dim = core->grid.dim, nc = MPM_MOTION_NC(dim), n = MPMPatchNodes(&core->exchange.patch);
  PetscReal     *other;
  PetscBool      moved, any;

  PetscFunctionBeginUser;
  if (restarted) { /* the masses stay in the records of the nodes */
    PetscCall(core->exchange.type->sweep(core, MPMStepStartPhase(core, 0)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1(PetscMax(1, core->particles.n * dim), &other));
  PetscCall(Swap(core, PETSC_TRUE, other, &moved));
  if (moved) PetscCall(Project(core)); /* the displacements of a known solution */
  for (PetscInt i = 0; i < n * nc; i += nc)
    for (PetscInt d = 0; d < dim && moved; d++)
      core->exchange.patch.state[i + d] = core->exchange.patch.state[i + dim + d];
  PetscCall(Swap(core, PETSC_FALSE, other, &any));
  PetscCall(PetscFree(other));
  PetscCall(Project(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMTotalPass(MPMCore *core)
{
  for (PetscInt k = 0; k < 2 * core->grid.dim; k++) {
    const MPMFace *f = &core->params.walls->given[k / 2][k % 2];

    if (MPMWallHas(f->type, MPM_WALL_MOVES)) core->passed[k] += core->params.dt * f->velocity[k / 2];
  }
}

void MPMTotalScale(MPMCore *core, PetscReal keep)
{
  const PetscInt dim = core->grid.dim, nc = MPM_MOTION_NC(dim), n = MPMPatchNodes(&core->exchange.patch);

  for (PetscInt i = 0; i < n; i++)
    for (PetscInt d = dim; d < nc; d++) core->exchange.patch.state[i * nc + d] *= keep;
}

PetscBool MPMTotalKicks(const MPMPhase *phase)
{
  return phase->kind == MPM_NODES && (phase->nodes == MPMNodesKick || phase->nodes == MPMNodesKickAgain) ? PETSC_TRUE
                                                                                                          : PETSC_FALSE;
}

PetscErrorCode MPMTotalKeep(MPMCore *core)
{
  const PetscInt n = MPMPatchNodes(&core->exchange.patch) * MPM_MOTION_NC(core->grid.dim);

  PetscFunctionBeginUser;
  if (!core->before) PetscCall(PetscMalloc1(n, &core->before));
  PetscCall(PetscArraycpy(core->before, core->exchange.patch.state, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTotalHalf(MPMCore *core, PetscReal sign)
{
  const PetscInt   dim = core->grid.dim, fields = MPM_BIT(v) | MPM_BIT(kind);
  const PetscReal *g   = core->params.gravity;
  MPMSum           sum;
  MPMView          view;

  PetscFunctionBeginUser;
  if (core->step || (g[0] == 0 && g[1] == 0 && g[2] == 0)) PetscFunctionReturn(PETSC_SUCCESS);
  MPMSumZero(&sum);
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal along = 0;

    for (PetscInt d = 0; d < dim; d++) along += g[d] * view.v[p * dim + d];
    MPMSumAdd(&sum, MPMKindOf(core->params.kinds, &view, p)->m * along);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(MPMSumReduce(&sum, 1, core->exchange.data));
  core->half += sign * 0.25 * core->params.dt * MPMSumValue(&sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}
