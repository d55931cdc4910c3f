/* spline_wall.h - the forms of B-splines near a wall, which use no node beyond it:
     extrap   the coefficient beyond the wall is extrapolated, c_-1 = 2 c_0 - c_1: sum w = 1 and sum w x_i = x hold
     steffen  knots are repeated there (Steffen, Kirby and Berzins 2008): sum w = 1, all slopes at the wall are 0 */
#ifndef MPM_SPLINE_WALL_H
#define MPM_SPLINE_WALL_H

#include "base/tensor.h"

typedef enum { MPM_WALL_BASIS_NONE, MPM_WALL_BASIS_EXTRAP, MPM_WALL_BASIS_STEFFEN } MPMWallBasis; /* NONE: periodic */

/* MPMLowerWall_<basis> computes values and gradients near the lower wall, for t = xi >= 0; it returns false further
   away, where the uniform spline holds. */
MPM_INLINE PetscBool MPMLowerWall_bspline2(PetscReal t, MPMWallBasis wall, PetscReal w[], PetscReal g[])
{
  const PetscReal s = t - 1;

  if (wall == MPM_WALL_BASIS_EXTRAP && t < 0.5) { /* N_0 + 2 N_-1 and N_1 - N_-1 are hat functions */
    w[0] = 1 - t;
    w[1] = t;
    g[0] = -1;
    g[1] = 1;
    w[2] = g[2] = 0;
    return PETSC_TRUE;
  }
  if (wall == MPM_WALL_BASIS_STEFFEN && t < 0.5) {
    w[0] = 1 - 4. / 3 * t * t;
    w[1] = 4. / 3 * t * t;
    g[0] = -8. / 3 * t;
    g[1] = 8. / 3 * t;
    w[2] = g[2] = 0;
    return PETSC_TRUE;
  }
  if (wall == MPM_WALL_BASIS_STEFFEN && t < 1.5) {
    w[0] = 2. / 3 * (1.5 - t) * (1.5 - t);
    w[1] = (-7. / 6 * s + 1. / 6) * s + 17. / 24;
    w[2] = 0.5 * (t - 0.5) * (t - 0.5);
    g[0] = -4. / 3 * (1.5 - t);
    g[1] = -7. / 3 * s + 1. / 6;
    g[2] = t - 0.5;
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

MPM_INLINE PetscBool MPMLowerWall_bspline3(PetscReal t, MPMWallBasis wall, PetscReal w[], PetscReal g[])
{
  const PetscReal s = t - 1, r = 2 - t;

  if (wall == MPM_WALL_BASIS_EXTRAP && t < 1) {
    w[0] = 1 - t + t * t * t / 6;
    w[1] = t - t * t * t / 3;
    w[2] = t * t * t / 6;
    g[0] = -1 + t * t / 2;
    g[1] = 1 - t * t;
    g[2] = t * t / 2;
    w[3] = g[3] = 0;
    return PETSC_TRUE;
  }
  if (wall == MPM_WALL_BASIS_STEFFEN && t < 1) {
    w[0] = (0.75 * t - 1.5) * t * t + 1;
    w[1] = (1.5 - 11. / 12 * t) * t * t;
    w[2] = t * t * t / 6;
    g[0] = (2.25 * t - 3) * t;
    g[1] = (3 - 2.75 * t) * t;
    g[2] = t * t / 2;
    w[3] = g[3] = 0;
    return PETSC_TRUE;
  }
  if (wall == MPM_WALL_BASIS_STEFFEN && t < 2) {
    w[0] = r * r * r / 4;
    w[1] = ((7. / 12 * s - 1.25) * s + 0.25) * s + 7. / 12;
    w[2] = 2. / 3 - r * r + r * r * r / 2;
    w[3] = s * s * s / 6;
    g[0] = -0.75 * r * r;
    g[1] = (1.75 * s - 2.5) * s + 0.25;
    g[2] = 2 * r - 1.5 * r * r;
    g[3] = s * s / 2;
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

#endif
