/* total_start.c - the total frame beside its phases: the masses and the first state of the nodes, and what a step does
   to walls that move, to the velocities of nodes by damping, and to the work of gravity. total.c has the kernels of
   nodes. */
#include "physics/wall.h"
#include "step/step.h"

#define START_ROUNDS 40 /* corrections of the first velocities; they cost 40 steps at most, once */

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

/* Exchanges the particles' velocities and their displacements, which are in memory that the caller has, `other`
   [n][dim]. Returns whether any is not 0 there. */
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
  PetscCall(MPMGapsUpdate(core));
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

PetscErrorCode MPMTotalHalf(MPMCore *core, PetscReal sign)
{
  const PetscInt   dim = core->grid.dim, fields = MPM_BIT(v) | MPM_BIT(kind);
  const PetscReal *g = core->params.gravity;
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
