/* static_inertia.c - what inertia adds to implicit steps, -method_time euler and newmark: the mass matrix, the inertial forces, and
   the velocities after a step. docs/method.md has the equations (Implicit steps). */
#include "parallel/exchange.h"
#include "step/static.h"

PetscReal MPMStaticShare(const struct MPMStatic *s, PetscReal t)
{
  return s->ramp > 0 ? PetscMin(1, t / s->ramp) : 1;
}

PetscErrorCode MPMStaticMass(struct MPMStatic *s)
{
  const MPMCore *core = s->core;
  const PetscInt dim = core->grid.dim, fields = MPM_BIT(X) | MPM_BIT(x) | MPM_BIT(kind) | MPM_BIT(l);
  PetscScalar    part[9];
  MPMStaticNodes t;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(s->u, &s->v));
  PetscCall(VecDuplicate(s->u, &s->past));
  PetscCall(MPMStaticCreateMatrix(s, MPMBasisNodes(core->basis) - 1, &s->M));
  PetscCall(MPMParticlesGetView(&s->core->particles, fields, &view));
  for (PetscInt k = 0; k < view.n; k++) {
    const PetscInt  p = core->particles.order[k];
    const PetscReal m = MPMKindOf(core->params.kinds, &view, p)->m;

    MPMStaticStencil(s, &view, p, &t);
    for (PetscInt i = 0; i < t.n; i++)
      for (PetscInt j = 0; j < t.n; j++) {
        for (PetscInt d = 0; d < dim * dim; d++) part[d] = d % (dim + 1) ? 0 : m * t.w[i] * t.w[j];
        PetscCall(MatSetValuesBlocked(s->M, 1, &t.number[i], 1, &t.number[j], part, ADD_VALUES));
      }
  }
  PetscCall(MPMParticlesRestoreView(&s->core->particles, fields, &view));
  PetscCall(MatAssemblyBegin(s->M, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->M, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticInertiaBegin(struct MPMStatic *s)
{
  MPMCore        *core = s->core;
  const PetscInt  dim  = core->grid.dim;
  const PetscReal dt = core->params.dt, share = MPMStaticShare(s, core->t);
  PetscScalar    *v, *u, *f;

  PetscFunctionBeginUser;
  if (!s->M) PetscFunctionReturn(PETSC_SUCCESS);
  s->per       = 1 / (s->beta * dt * dt);
  s->held_over = s->gamma > 0 ? (1 - s->gamma) / s->gamma : 0;
  PetscCall(VecGetArray(s->v, &v));
  PetscCall(VecGetArray(s->u, &u));
  for (PetscInt k = 0; k < s->n * dim; k++) {
    v[k] = core->exchange.patch.state[s->node[k / dim] * MPM_MOTION_NC(dim) + dim + k % dim];
    u[k] = s->held[k] ? s->known[k] : u[k] + dt * v[k];
  }
  PetscCall(VecRestoreArray(s->u, &u));
  PetscCall(VecRestoreArray(s->v, &v));
  if (!(s->held_over > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  if (core->needs.forced) PetscCall(MPMForcesUpdate(s->scene, core, core->t));
  PetscCall(MPMPhaseRun(core, core->program[2]));
  PetscCall(MPMExchangeOpenNodes(core));
  PetscCall(VecGetArray(s->past, &f));
  for (PetscInt k = 0; k < s->n * dim; k++) {
    const MPMNode *n = core->exchange.patch.node + s->node[k / dim];

    f[k] = n->f[k % dim] + share * n->m * core->params.gravity[k % dim];
  }
  PetscCall(VecRestoreArray(s->past, &f));
  PetscCall(MPMExchangeCloseNodes(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticInertia(struct MPMStatic *s, Vec u, Vec r)
{
  PetscFunctionBeginUser;
  if (!s->M) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecWAXPY(s->work, -1, s->was, u));
  PetscCall(VecAXPY(s->work, -s->core->params.dt, s->v));
  PetscCall(VecScale(s->work, s->per));
  PetscCall(MatMultAdd(s->M, s->work, r, r));
  if (s->held_over > 0) PetscCall(VecAXPY(r, -s->held_over, s->past));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MPMStaticVelocity(const struct MPMStatic *s, PetscInt k, PetscReal moved, PetscReal v)
{
  const PetscReal mean = moved / s->core->params.dt;

  if (!s->M) return 0;
  return s->held[k] || !(s->gamma > 0) ? mean : 2 * mean - v;
}
