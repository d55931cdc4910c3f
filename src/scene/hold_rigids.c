/* hold_rigids.c - free rigid bodies at the faces of the grid: a plane of symmetry through the middle of one holds it; those
   that start in a wall or beyond the grid are refused. All processes compute the same numbers. */
#include "scene/scene.h"

#define TOUCHES 1e-6 /* cells: a body that reaches less into a wall touches it */
#define BESIDE  0.01 /* cells: a surface that is nearer to a face of the grid lies on it */
#define ACROSS  50   /* places along an axis of a face */

/* Returns whether a shape that ends at a face goes on beyond it without its cuts; sign: along the axis into the grid. */
static PetscBool IsCutBy(const MPMRegion *r, const MPMGrid *grid, PetscInt axis, PetscReal plane, PetscReal sign)
{
  MPMRegion alone = *r;
  PetscReal lower[3], upper[3];
  PetscInt  places = 1;

  alone.ncut = alone.nwithin = 0;
  MPMRegionBounds(r, grid->dim, lower, upper);
  for (PetscInt d = 1; d < grid->dim; d++) places *= ACROSS;
  for (PetscInt k = 0; k < places; k++) {
    PetscReal x[3];

    for (PetscInt d = 0, q = k; d < grid->dim; d++) {
      if (d == axis) continue;
      x[d] = lower[d] + (upper[d] - lower[d]) * ((PetscReal)(q % ACROSS) + 0.5) / ACROSS;
      q /= ACROSS;
    }
    x[axis] = plane + sign * BESIDE * grid->h[axis];
    if (!MPMRegionInside(r, grid->dim, x)) continue;
    x[axis] = plane - sign * BESIDE * grid->h[axis];
    if (r->type == MPM_REGION_expression ? r->formula(r->context, grid->dim, x) > 0
                                         : MPMRegionInside(&alone, grid->dim, x))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns whether the plane through `plane` on an axis is one of symmetry of a body, to BESIDE cells. */
static PetscBool IsSymmetric(const MPMRigid *r, const MPMGrid *grid, PetscInt axis, PetscReal plane)
{
  PetscReal       x[3], n[3];
  const PetscReal most = BESIDE * MPMGridSmallestH(grid);
  PetscBool       same = PetscAbsReal(r->pivot[axis] - plane) <= most;

  for (PetscInt k = 0; k < r->npoints && same && !MPMRigidIsRound(r); k++) {
    MPMRigidPoint(r, k, x);
    x[axis] = 2 * plane - x[axis];
    same    = PetscAbsReal(MPMRigidDistance(r, grid->dim, x, n)) <= most;
  }
  return same;
}

/* Lets the plane of a wall hold a free body that it cuts in half; refuses what the body cannot do there. */
static void Hold(const MPMBody *b, MPMOptions o, PetscInt face, MPMRigid *r)
{
  const PetscInt axis = face / 2;

  if (r->velocity[axis] != 0)
    MPMOptionsFail(
        o,
        "-body_%s_velocity has %g along %c, and the plane of symmetry %s through %s (-bc_%s_type slip) lets it "
        "move along itself only",
        r->name, (double)r->velocity[axis], "xyz"[axis], MPMFaceNames[face], r -> name, MPMFaceNames[face]);
  for (PetscInt d = 0; d < 3; d++)
    if (d != axis && r->spin[d] != 0)
      MPMOptionsFail(o,
                     "-body_%s_spin %g does not apply: with the plane of symmetry %s through %s (-bc_%s_type slip) it "
                     "turns about the normal of that only, in 2-D not at all",
                     r->name, (double)r->spin[d], MPMFaceNames[face], r->name, MPMFaceNames[face]);
  MPMRigidHold(r, face, b->rho > 0 ? 0.5 : 1);
}

void MPMSceneHoldRigid(const MPMScene *scene, const MPMCore *core, MPMOptions o, const MPMBody *b, MPMRigid *r)
{
  const MPMGrid *grid = &core->grid;

  for (PetscInt k = 0; k < 2 * grid->dim && r->free; k++) {
    const MPMWall   type  = scene->walls.given[k / 2][k % 2].type;
    const PetscReal plane = k % 2 ? grid->upper[k / 2] : grid->lower[k / 2], sign = k % 2 ? -1 : 1;
    PetscReal       gap = sign * (r->pivot[k / 2] - plane), x[3], down[3] = {0}, lowest[2][3];

    if (grid->round && k < 2) { /* x is the radius */
      MPMRigidHold(r, k, 1);
      continue;
    }
    if (type == MPM_WALL_piston) continue;
    if (type == MPM_WALL_free && gap < 0)
      MPMOptionsFail(
          o,
          "the rigid body %s starts with its center of mass beyond the grid, %c = %g m: move it into the grid, "
          "or enlarge that (-grid_%s)",
          r->name, "xyz"[k / 2], (double)r -> pivot[k / 2], k % 2 ? "upper" : "lower");
    if (type == MPM_WALL_free) continue;
    down[k / 2] = -sign;
    for (PetscInt p = MPMRigidLowest(r, grid->dim, down, lowest) - 1; p >= 0; p--)
      gap = PetscMin(gap, sign * (lowest[p][k / 2] - plane));
    for (PetscInt p = 0; p < r->npoints; p++) {
      MPMRigidPoint(r, p, x);
      gap = PetscMin(gap, sign * (x[k / 2] - plane));
    }
    if (type == MPM_WALL_periodic && gap < -TOUCHES * MPMGridSmallestH(grid))
      MPMOptionsFail(
          o,
          "the rigid body %s starts %g m beyond the periodic face %s: rigid bodies do not cross periodic faces; "
          "move it into the grid",
          r->name, (double)-gap, MPMFaceNames[k]);
    if (type == MPM_WALL_periodic) continue;
    if (gap < -TOUCHES * MPMGridSmallestH(grid) && type == MPM_WALL_slip && grid->dim > 1 &&
        IsSymmetric(r, grid, k / 2, plane)) {
      Hold(b, o, k, r);
      continue;
    }
    if (gap < -TOUCHES * MPMGridSmallestH(grid))
      MPMOptionsFail(o, "the rigid body %s starts %g m inside the wall %s (-bc_%s_type %s): move it into the grid%s",
                     r->name, (double)-gap, MPMFaceNames[k], MPMFaceNames[k], MPMWallNames[type],
                     type == MPM_WALL_slip && grid->dim > 1
                         ? "; a wall of type slip holds it as a plane of symmetry if both halves are alike"
                         : "");
    if (type == MPM_WALL_slip && IsCutBy(r->shape, grid, k / 2, plane, sign))
      MPMOptionsFail(
          o,
          "-body_%s_%s cuts the free rigid body %s at the wall %s (-bc_%s_type slip), which holds "
          "the half of a whole shape only, as a plane of symmetry: give the shape without the cut; a body that is "
          "flat there stands on a wall of -bc_%s_type separate",
          r->name,
          r->shape->nwithin ? "within"
          : r->shape->ncut  ? "cut"
                            : "expression",
          r->name, MPMFaceNames[k], MPMFaceNames[k], MPMFaceNames[k]);
  }
}
