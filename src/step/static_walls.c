/* static_walls.c - what walls do in a static step: those that hold nodes give them their places, and those that only push are
   bounds of the displacements, which make of the equations a variational inequality: a node is at its bound and pressed on it,
   or free of force. docs/method.md has the equations (Statics). */
#include "parallel/exchange.h"
#include "physics/wall.h"
#include "step/static.h"
#include "step/step.h"

/* Returns the bound of the displacement of node ijk along axis d on this side, m, from where it was as the step began, was: as far
   as the matter over it is from the wall; if no wall pushes there, infinity. */
static PetscReal Bound(const MPMCore *core, const PetscInt ijk[], PetscInt d, PetscInt side, PetscReal was)
{
  const MPMFace  *f    = &core->params.walls->given[d][side];
  const PetscReal sign = side ? -1 : 1;

  if (!MPMWallHas(f->type, MPM_WALL_PUSHES) || !MPMWallActs(f, MPMWallInside(&core->grid, 2 * d + side, ijk)))
    return -sign * PETSC_INFINITY;
  return was + sign * core->params.dt * f->least[MPMFaceNode(&core->grid, d, ijk)];
}

PetscErrorCode MPMStaticHold(struct MPMStatic *s)
{
  MPMCore           *core = s->core;
  const MPMGrid     *grid = &core->grid;
  const PetscReal    dt   = core->params.dt;
  const PetscScalar *was;
  PetscScalar       *bound[2];
  MPMFace            holding[3][2];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 6; k++) {
    holding[k / 2][k % 2] = core->params.walls->given[k / 2][k % 2];
    if (MPMWallHas(holding[k / 2][k % 2].type, MPM_WALL_PUSHES)) holding[k / 2][k % 2].type = MPM_WALL_free;
  }
  if (s->bound[0]) PetscCall(MPMGapsUpdate(core));
  PetscCall(VecGetArrayRead(s->was, &was));
  for (PetscInt side = 0; side < 2 && s->bound[0]; side++) PetscCall(VecGetArray(s->bound[side], &bound[side]));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt  ijk[3];
    PetscReal v[2][3] = {{1, 1, 1}, {2, 2, 2}};

    MPMStaticWhere(s, q, ijk);
    for (int k = 0; k < 2; k++) (void)MPMWallsApply(holding, grid, ijk, dt, v[k]);
    for (PetscInt d = 0; d < grid->dim; d++) {
      const PetscInt k = q * grid->dim + d;

      s->held[k]  = v[0][d] == v[1][d];
      s->known[k] = was[k] + dt * v[0][d];
      for (PetscInt side = 0; side < 2 && s->bound[0]; side++)
        bound[side][k] = s->held[k] ? (side ? 1 : -1) * PETSC_INFINITY : Bound(core, ijk, d, side, was[k]);
    }
  }
  for (PetscInt side = 0; side < 2 && s->bound[0]; side++) PetscCall(VecRestoreArray(s->bound[side], &bound[side]));
  PetscCall(VecRestoreArrayRead(s->was, &was));
  if (s->bound[0]) PetscCall(SNESVISetVariableBounds(s->snes, s->bound[0], s->bound[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticPress(struct MPMStatic *s, Vec r)
{
  const PetscScalar *bound[2], *u;
  PetscScalar       *force;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < s->n * s->core->grid.dim && s->pressed; k++) {
    if (s->pressed[k]) s->held[k] = PETSC_FALSE;
    s->pressed[k] = PETSC_FALSE;
  }
  if (!s->pressed || !r) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt side = 0; side < 2; side++) PetscCall(VecGetArrayRead(s->bound[side], &bound[side]));
  PetscCall(VecGetArrayRead(s->u, &u));
  PetscCall(VecGetArray(r, &force));
  for (PetscInt k = 0; k < s->n * s->core->grid.dim; k++) {
    if (!(u[k] <= bound[0][k] && force[k] > 0) && !(u[k] >= bound[1][k] && force[k] < 0)) continue;
    s->held[k] = s->pressed[k] = PETSC_TRUE;
    s->known[k]                = u[k];
    force[k]                   = 0;
  }
  PetscCall(VecRestoreArray(r, &force));
  PetscCall(VecRestoreArrayRead(s->u, &u));
  for (PetscInt side = 0; side < 2; side++) PetscCall(VecRestoreArrayRead(s->bound[side], &bound[side]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticPush(struct MPMStatic *s, Vec r)
{
  MPMCore           *core = s->core;
  const PetscInt     dim  = core->grid.dim;
  const PetscScalar *force, *bound[2];

  PetscFunctionBeginUser;
  if (!s->bound[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArrayRead(r, &force));
  for (PetscInt side = 0; side < 2; side++) PetscCall(VecGetArrayRead(s->bound[side], &bound[side]));
  PetscCall(MPMExchangeOpenNodes(core));
  for (PetscInt k = 0; k < s->n * dim; k++)
    if (bound[0][k] > -PETSC_INFINITY || bound[1][k] < PETSC_INFINITY) /* other nodes are free of force, or held */
      core->exchange.patch.node[s->node[k / dim]].p[k % dim] = force[k];
  PetscCall(MPMExchangeCloseNodes(core));
  for (PetscInt side = 0; side < 2; side++) PetscCall(VecRestoreArrayRead(s->bound[side], &bound[side]));
  PetscCall(VecRestoreArrayRead(r, &force));
  PetscFunctionReturn(PETSC_SUCCESS);
}
