/* foresee_rigids.c - where rigid bodies that move by formulas come to, before the run: into others, or out of the grid.
   All processes compute the same numbers. */
#include "scene/scene.h"

#define FORESEEN 200 /* parts of the time of a run in which their motion is looked at */
#define DEEP     0.5 /* cells: bodies that lie deeper in each other than at the start by this pass through each other */

/* Returns how deep a point of the surface of a lies in b, m, or 0. */
static PetscReal Depth(const MPMRigid *a, const MPMRigid *b, PetscInt dim)
{
  PetscReal x[3], n[3], deep = 0;

  for (PetscInt d = 0; d < 3; d++) x[d] = a->pivot[d] + a->place[d];
  if (MPMRigidDistance(b, dim, x, n) > a->reach) return 0;
  for (PetscInt k = 0; k < a->npoints; k++) {
    MPMRigidPoint(a, k, x);
    deep = PetscMax(deep, -MPMRigidDistance(b, dim, x, n));
  }
  return deep;
}

/* Returns whether all of a body lies beyond a face of the grid. */
static PetscBool Left(const MPMRigid *r, const MPMGrid *grid)
{
  for (PetscInt d = 0; d < grid->dim; d++) {
    PetscReal lower = PETSC_MAX_REAL, upper = PETSC_MIN_REAL, x[3];

    for (PetscInt k = 0; k < r->npoints; k++) {
      MPMRigidPoint(r, k, x);
      lower = PetscMin(lower, x[d]);
      upper = PetscMax(upper, x[d]);
    }
    if (r->npoints && (lower > grid->upper[d] || upper < grid->lower[d])) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Looks at bodies [n] as they are at time t, s. deep [n][n]: how deep they lie in each other at the start, m; left [n]: when
   they have left the grid, s. */
static void Look(MPMRigids *rigids, const MPMGrid *grid, PetscReal t, const MPMRigid body[], PetscReal deep[],
                 PetscReal left[])
{
  const PetscReal h = MPMGridSmallestH(grid);

  for (PetscInt i = 0; i < rigids->n; i++) {
    if (body[i].free || !body[i].moves || body[i].gone || left[i] < PETSC_INFINITY) continue;
    if (Left(&body[i], grid)) left[i] = t;
    for (PetscInt j = 0; j < rigids->n && !(rigids->meet < PETSC_INFINITY); j++) {
      const PetscInt  at = i * rigids->n + j;
      const PetscReal by = i == j || body[j].free || body[j].gone
                               ? 0
                               : PetscMax(Depth(&body[i], &body[j], grid->dim), Depth(&body[j], &body[i], grid->dim));

      if (t == 0) deep[at] = by;
      if (!(by > deep[at] + DEEP * h)) continue;
      rigids->meet     = t;
      rigids->meets[0] = i;
      rigids->meets[1] = j;
    }
  }
}

PetscErrorCode MPMSceneForeseeRigids(const MPMScene *scene, MPMCore *core, PetscReal end)
{
  MPMRigids *rigids = &core->rigids;
  MPMRigid  *body;
  PetscReal *numbers, *deep, *left;

  PetscFunctionBeginUser;
  rigids->meet = PETSC_INFINITY;
  if (!rigids->driven) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc4(rigids->n, &body, rigids->n * MPM_RIGID_NUMBERS, &numbers, rigids->n * rigids->n, &deep,
                         rigids->n, &left));
  PetscCall(PetscArrayzero(numbers, rigids->n * MPM_RIGID_NUMBERS));
  for (PetscInt k = 0; k < rigids->n; k++) {
    body[k] = rigids->body[k];
    left[k] = PETSC_INFINITY;
    MPMRigidUse(&body[k], numbers + k * MPM_RIGID_NUMBERS);
    for (PetscInt d = 0; d < 3; d++) body[k].turn[4 * d] = 1;
    if (!body[k].free) PetscCall(MPMRigidSetPoints(&body[k], core->grid.dim));
  }
  for (PetscInt n = 0; n <= FORESEEN; n++) {
    Look(rigids, &core->grid, end * n / FORESEEN, body, deep, left);
    PetscCall(MPMSceneEvaluateRigids(scene, core->grid.dim, end * (n + 0.5) / FORESEEN, body));
    for (PetscInt k = 0; k < rigids->n; k++)
      if (!body[k].free) MPMRigidMove(&body[k], end / FORESEEN);
  }
  if (rigids->meet < PETSC_INFINITY && core->t < rigids->meet)
    PetscCall(
        MPMWarn(&core->print,
                "the rigid bodies %s and %s pass through each other from t=%.3g s on, which ends the run; choose an "
                "earlier -time_end, or another motion",
                body[rigids->meets[0]].name, body[rigids->meets[1]].name, (double)rigids->meet));
  for (PetscInt k = 0; k < rigids->n; k++) {
    if (left[k] < PETSC_INFINITY)
      PetscCall(MPMNote(
          &core->print,
          "the rigid body %s leaves the grid at t=%.3g s; from then on it meets nothing: check -body_%s_velocity and -time_end",
          body[k].name, (double)left[k], body[k].name));
    if (!body[k].free) PetscCall(PetscFree(body[k].point));
  }
  PetscCall(PetscFree4(body, numbers, deep, left));
  PetscFunctionReturn(PETSC_SUCCESS);
}
