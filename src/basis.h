/* basis.h - the 1-D basis functions; transfer.h forms their tensor products, once, for all of them.

   xi = (x - lower)/h is the coordinate in cells, by a division, the same expression on every rank and in every phase.
   A basis gives the first node of a point's stencil (the base, which also names the point's "cell") and the values w
   and gradients g (per cell, so divide by h) of its nodes base, base+1, ...
   Splines near a wall are restricted to nodes of the grid in one of two forms, so that no node lies beyond it:
     extrap   the coefficient beyond the wall is extrapolated, c_-1 = 2 c_0 - c_1: keeps sum w = 1 and sum w x_i = x
     steffen  knots repeated at the wall (Steffen, Kirby and Berzins 2008): sum w = 1, all slopes 0 at the wall */
#ifndef MPM_BASIS_H
#define MPM_BASIS_H

#include "tensor.h"

typedef enum {
#define MPM_BASIS(name, nodes, layers, inertia, what) MPM_BASIS_##name,
#include "basis.def"
#undef MPM_BASIS
  MPM_NUM_BASES
} MPMBasis;

typedef enum { MPM_WALL_BASIS_NONE, MPM_WALL_BASIS_EXTRAP, MPM_WALL_BASIS_STEFFEN } MPMWallBasis; /* none: periodic */

#define MPM_MAX_STENCIL 4 /* nodes per axis of the widest basis */

/* Largest integer <= xi without a library call; xi is far inside the range of PetscInt. */
MPM_INLINE PetscInt MPMFloor(PetscReal xi)
{
  const PetscInt i = (PetscInt)xi;

  return i - (xi < (PetscReal)i);
}

/* --- Hats ----------------------------------------------------------------------------------------------------------
 */

/* A point on the upper wall belongs to the last cell (decided once, here). */
MPM_INLINE PetscInt MPMBasisBase_linear(PetscReal xi, PetscReal l, PetscInt cells)
{
  const PetscInt i = MPMFloor(xi);

  (void)l;
  return i < cells ? i : cells - 1;
}

MPM_INLINE void MPMBasisWeights_linear(PetscReal xi, PetscReal l, PetscInt base, PetscInt cells, MPMWallBasis wall,
                                       PetscReal w[], PetscReal g[])
{
  const PetscReal s = xi - (PetscReal)base;

  (void)l;
  (void)cells;
  (void)wall;
  w[0] = 1 - s;
  w[1] = s;
  g[0] = -1;
  g[1] = 1;
}

/* --- Hats averaged over [xi - l, xi + l], 0 < l <= 1/2 (Bardenhagen and Kober 2004) ------------------------------- */
MPM_INLINE PetscInt MPMBasisBase_gimp(PetscReal xi, PetscReal l, PetscInt cells)
{
  (void)cells;
  return MPMFloor(xi - l);
}

MPM_INLINE void MPMBasisWeights_gimp(PetscReal xi, PetscReal l, PetscInt base, PetscInt cells, MPMWallBasis wall,
                                     PetscReal w[], PetscReal g[])
{
  const PetscReal s = xi - (PetscReal)base, below = s, at = s - 1, above = 2 - s; /* distances; l <= below < 1 + l */
  const PetscReal under = PetscMax(1 + l - below, 0), over = PetscMax(1 + l - above, 0), a = PetscAbsReal(at);
  const PetscReal sign = at < 0 ? -1 : 1;

  (void)cells;
  (void)wall;
  w[0] = below <= 1 - l ? 1 - below : under * under / (4 * l);
  g[0] = below <= 1 - l ? -1 : -under / (2 * l);
  w[1] = a <= l ? 1 - (at * at + l * l) / (2 * l) : 1 - a;
  g[1] = a <= l ? -at / l : -sign;
  w[2] = above <= 1 - l ? 1 - above : over * over / (4 * l);
  g[2] = above <= 1 - l ? 1 : over / (2 * l);
}

/* --- B-splines centred on the nodes --------------------------------------------------------------------------------
 */

/* Base of a spline of ns nodes: between walls its stencil stays on the grid; on a periodic axis it may be -1. */
MPM_INLINE PetscInt MPMSplineBase(PetscInt base, PetscInt ns, PetscInt cells, MPMWallBasis wall)
{
  if (wall == MPM_WALL_BASIS_NONE) return base;
  return base < 0 ? 0 : base > cells + 1 - ns ? cells + 1 - ns : base;
}

/* Values and gradients within reach of the lower wall, t = xi >= 0; false beyond it, where the uniform spline holds. */
MPM_INLINE PetscBool MPMWallWeights_bspline2(PetscReal t, MPMWallBasis wall, PetscReal w[], PetscReal g[])
{
  const PetscReal s = t - 1;

  if (wall == MPM_WALL_BASIS_EXTRAP && t < 0.5) { /* N_0 + 2 N_-1 and N_1 - N_-1 are the hats */
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

MPM_INLINE PetscBool MPMWallWeights_bspline3(PetscReal t, MPMWallBasis wall, PetscReal w[], PetscReal g[])
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

/* The same at the upper wall is the mirror image. */
#define MPM_SPLINE_WALLS(name, ns)                                                                                     \
  do {                                                                                                                 \
    PetscReal mw[ns], mg[ns];                                                                                          \
    if (wall == MPM_WALL_BASIS_NONE) break;                                                                            \
    if (MPMWallWeights_##name(xi, wall, w, g)) return;                                                                 \
    if (!MPMWallWeights_##name((PetscReal)cells - xi, wall, mw, mg)) break;                                            \
    for (int i = 0; i < ns; i++) {                                                                                     \
      w[i] = mw[ns - 1 - i];                                                                                           \
      g[i] = -mg[ns - 1 - i];                                                                                          \
    }                                                                                                                  \
    return;                                                                                                            \
  } while (0)

MPM_INLINE PetscInt MPMBasisBase_bspline2(PetscReal xi, PetscReal l, PetscInt cells)
{
  (void)l;
  (void)cells;
  return MPMFloor(xi + 0.5) - 1;
}

MPM_INLINE void MPMBasisWeights_bspline2(PetscReal xi, PetscReal l, PetscInt base, PetscInt cells, MPMWallBasis wall,
                                         PetscReal w[], PetscReal g[])
{
  const PetscReal s = xi - (PetscReal)(base + 1); /* from the middle node, |s| <= 1/2 */

  (void)l;
  MPM_SPLINE_WALLS(bspline2, 3);
  w[0] = 0.5 * (0.5 - s) * (0.5 - s);
  w[1] = 0.75 - s * s;
  w[2] = 0.5 * (0.5 + s) * (0.5 + s);
  g[0] = s - 0.5;
  g[1] = -2 * s;
  g[2] = s + 0.5;
}

MPM_INLINE PetscInt MPMBasisBase_bspline3(PetscReal xi, PetscReal l, PetscInt cells)
{
  (void)l;
  (void)cells;
  return MPMFloor(xi) - 1;
}

MPM_INLINE void MPMBasisWeights_bspline3(PetscReal xi, PetscReal l, PetscInt base, PetscInt cells, MPMWallBasis wall,
                                         PetscReal w[], PetscReal g[])
{
  const PetscReal s = xi - (PetscReal)(base + 1), r = 1 - s; /* from the second and third node, 0 <= s <= 1 */

  (void)l;
  MPM_SPLINE_WALLS(bspline3, 4);
  w[0] = r * r * r / 6;
  w[1] = 2. / 3 - s * s + s * s * s / 2;
  w[2] = 2. / 3 - r * r + r * r * r / 2;
  w[3] = s * s * s / 6;
  g[0] = -r * r / 2;
  g[1] = (1.5 * s - 2) * s;
  g[2] = (2 - 1.5 * r) * r;
  g[3] = s * s / 2;
}
#undef MPM_SPLINE_WALLS

/* --- By number -----------------------------------------------------------------------------------------------------
 */

/* Nodes per axis. */
MPM_INLINE int MPMBasisNodes(MPMBasis basis)
{
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (basis == MPM_BASIS_##name) return nodes;
#include "basis.def"
#undef MPM_BASIS
  return 0;
}

/* Node layers needed beyond each wall. */
MPM_INLINE int MPMBasisLayers(MPMBasis basis)
{
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (basis == MPM_BASIS_##name) return layers;
#include "basis.def"
#undef MPM_BASIS
  return 0;
}

MPM_INLINE int MPMBasisInertia(MPMBasis basis)
{
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (basis == MPM_BASIS_##name) return inertia;
#include "basis.def"
#undef MPM_BASIS
  return 0;
}

/* Is it a spline, which needs a form at the walls? */
MPM_INLINE PetscBool MPMBasisIsSpline(MPMBasis basis)
{
  return MPMBasisInertia(basis) ? PETSC_TRUE : PETSC_FALSE;
}

/* Base node of a point at xi with half-width l (both in cells; l matters to gimp only). On a periodic axis node -1 is
   node cells-1 and xi goes with it, so that 0 <= base < cells. */
MPM_INLINE PetscInt MPMBasisBase(MPMBasis basis, PetscReal *xi, PetscReal l, PetscInt cells, PetscBool periodic,
                                 MPMWallBasis wall)
{
  PetscInt base = 0;

#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (basis == MPM_BASIS_##name) base = MPMBasisBase_##name(*xi, l, cells);
#include "basis.def"
#undef MPM_BASIS
  if (MPMBasisIsSpline(basis)) base = MPMSplineBase(base, MPMBasisNodes(basis), cells, wall);
  if (basis != MPM_BASIS_linear && periodic && base < 0) {
    base += cells;
    *xi += (PetscReal)cells;
  }
  return base;
}

MPM_INLINE void MPMBasisWeights(MPMBasis basis, PetscReal xi, PetscReal l, PetscInt base, PetscInt cells,
                                MPMWallBasis wall, PetscReal w[], PetscReal g[])
{
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (basis == MPM_BASIS_##name) MPMBasisWeights_##name(xi, l, base, cells, wall, w, g);
#include "basis.def"
#undef MPM_BASIS
}

#endif
