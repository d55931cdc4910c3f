/* basis.h - the 1-D basis functions; kernels/stencils.h forms their tensor products for the transfers.

   xi = (x - lower)/h is the coordinate in cells; it is computed by this division in every phase and on every process,
   so it has the same bits. A basis is two functions. The first gives the base, which is the first node of a particle's
   stencil and names the particle's cell. The second gives the values w and gradients g (per cell; those per metre are
   g/h) of its nodes base, base+1, ... Both have no branches and take one particle or several (MPMReal, lanes.h); the
   base is a real number. Near a wall splines have other forms, which use nodes of the grid alone (spline_wall.h); few
   particles are near a wall, so those functions take one particle at a time. */
#ifndef MPM_BASIS_H
#define MPM_BASIS_H

#include "physics/basis_type.h"

/* --- Hats --------------------------------------------------------------------------------------------------------- */

MPM_INLINE MPMReal MPMBasisBase_linear(MPMReal xi, MPMReal l)
{
  (void)l;
  return MPMFloor(xi);
}

MPM_INLINE void MPMBasisWeights_linear(MPMReal xi, MPMReal l, MPMReal base, MPMReal w[], MPMReal g[])
{
  const MPMReal s = xi - base;

  (void)l;
  w[0] = 1.0 - s;
  w[1] = s;
  g[0] = MPMAll(-1);
  g[1] = MPMAll(1);
}

/* --- Hats averaged over [xi - l, xi + l], 0 < l <= 1/2 (Bardenhagen and Kober 2004) ------------------------------- */
MPM_INLINE MPMReal MPMBasisBase_gimp(MPMReal xi, MPMReal l)
{
  return MPMFloor(xi - l);
}

MPM_INLINE void MPMBasisWeights_gimp(MPMReal xi, MPMReal l, MPMReal base, MPMReal w[], MPMReal g[])
{
  const MPMReal below = xi - base, at = below - 1.0, above = 2.0 - below, a = MPMAbs(at); /* distances from the nodes */
  const MPMReal under = MPMMax(1.0 + l - below, MPMAll(0)), over = MPMMax(1.0 + l - above, MPMAll(0)), half = 0.5 / l;
  const MPMReal one = MPMAll(1);

  w[0] = MPMSelect(below <= 1.0 - l, 1.0 - below, 0.5 * under * under * half);
  g[0] = MPMSelect(below <= 1.0 - l, -one, -under * half);
  w[1] = MPMSelect(a <= l, 1.0 - (at * at + l * l) * half, 1.0 - a);
  g[1] = MPMSelect(a <= l, -2.0 * at * half, MPMSelect(at < 0.0, one, -one));
  w[2] = MPMSelect(above <= 1.0 - l, 1.0 - above, 0.5 * over * over * half);
  g[2] = MPMSelect(above <= 1.0 - l, one, over * half);
}

/* --- B-splines centred on the nodes ------------------------------------------------------------------------------- */

/* Returns the distance from a wall, in cells, within which a basis has a form of its own. */
MPM_INLINE PetscReal MPMWallReach(MPMBasis basis, MPMWallBasis wall)
{
  if (wall == MPM_WALL_BASIS_NONE) return 0;
  return (basis == MPM_BASIS_bspline2 ? 0.5 : basis == MPM_BASIS_bspline3 ? 1 : 0) + (wall == MPM_WALL_BASIS_STEFFEN);
}

/* Computes values and gradients of one particle near a wall; returns false if it is near none. Those at the upper wall
   mirror those at the lower one. */
MPM_INLINE PetscBool MPMWallWeights(MPMBasis basis, PetscReal xi, PetscInt cells, MPMWallBasis wall, PetscReal w[],
                                    PetscReal g[])
{
  const int ns = basis == MPM_BASIS_bspline3 ? 4 : 3;
  PetscReal mw[4], mg[4];

  if (wall == MPM_WALL_BASIS_NONE || (basis != MPM_BASIS_bspline2 && basis != MPM_BASIS_bspline3)) return PETSC_FALSE;
  if (ns == 3 ? MPMLowerWall_bspline2(xi, wall, w, g) : MPMLowerWall_bspline3(xi, wall, w, g)) return PETSC_TRUE;
  xi = (PetscReal)cells - xi;
  if (!(ns == 3 ? MPMLowerWall_bspline2(xi, wall, mw, mg) : MPMLowerWall_bspline3(xi, wall, mw, mg)))
    return PETSC_FALSE;
  for (int i = 0; i < ns; i++) {
    w[i] = mw[ns - 1 - i];
    g[i] = -mg[ns - 1 - i];
  }
  return PETSC_TRUE;
}

MPM_INLINE MPMReal MPMBasisBase_bspline2(MPMReal xi, MPMReal l)
{
  (void)l;
  return MPMFloor(xi + 0.5) - 1.0;
}

MPM_INLINE void MPMBasisWeights_bspline2(MPMReal xi, MPMReal l, MPMReal base, MPMReal w[], MPMReal g[])
{
  const MPMReal s = xi - (base + 1.0); /* distance from the middle node, |s| <= 1/2 */

  (void)l;
  w[0] = 0.5 * (0.5 - s) * (0.5 - s);
  w[1] = 0.75 - s * s;
  w[2] = 0.5 * (0.5 + s) * (0.5 + s);
  g[0] = s - 0.5;
  g[1] = -2.0 * s;
  g[2] = s + 0.5;
}

MPM_INLINE MPMReal MPMBasisBase_bspline3(MPMReal xi, MPMReal l)
{
  (void)l;
  return MPMFloor(xi) - 1.0;
}

MPM_INLINE void MPMBasisWeights_bspline3(MPMReal xi, MPMReal l, MPMReal base, MPMReal w[], MPMReal g[])
{
  const MPMReal s = xi - (base + 1.0), r = 1.0 - s; /* distances from the second and third node, 0 <= s <= 1 */
  const MPMReal s2 = s * s, r2 = r * r, s3 = s2 * s, r3 = r2 * r;

  (void)l;
  w[0] = r3 * (1. / 6);
  w[1] = 2. / 3 - s2 + s3 * 0.5;
  w[2] = 2. / 3 - r2 + r3 * 0.5;
  w[3] = s3 * (1. / 6);
  g[0] = -0.5 * r2;
  g[1] = (1.5 * s - 2.0) * s;
  g[2] = (2.0 - 1.5 * r) * r;
  g[3] = 0.5 * s2;
}

/* --- Functions for any basis -------------------------------------------------------------------------------------- */

/* The base nodes of an axis: least and largest one, as far as functions of a basis do not keep to them; on a periodic
   axis that `wraps`, `round` is added to those below 0. The three numbers are whole. */
typedef struct {
  PetscReal least, most, round;
  PetscBool wraps;
} MPMBases;

/* Returns those of an axis with these cells. With hats, a particle on the upper wall belongs to the last cell. Between
   walls the stencil of a spline stays on the grid. On a periodic axis node -1 is node cells-1. */
MPM_INLINE MPMBases MPMBasisBasesOf(MPMBasis basis, PetscInt cells, PetscBool periodic, MPMWallBasis wall)
{
  const PetscBool hats   = basis == MPM_BASIS_linear;
  const PetscBool walled = MPMBasisIsSpline(basis) && wall != MPM_WALL_BASIS_NONE;

  return (MPMBases){.least = walled ? 0 : PETSC_MIN_REAL,
                    .most  = hats || walled ? cells + 1 - MPMBasisNodes(basis) : PETSC_MAX_REAL,
                    .round = cells,
                    .wraps = periodic && !hats};
}

/* Returns the base nodes of particles at xi with half-widths l (both in cells; l matters to gimp only). Where a base is
   rounded up on a periodic axis, so is xi. */
MPM_INLINE MPMReal MPMBasisBases(MPMBasis basis, const MPMBases *all, MPMReal l, MPMReal *xi)
{
  MPMReal base = MPMAll(0);

#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (basis == MPM_BASIS_##name) base = MPMBasisBase_##name(*xi, l);
#include "physics/basis.def"
  if (MPMBasisIsSpline(basis)) base = MPMMax(MPMAll(all->least), base); /* an operand in memory can only be the first */
  if (basis != MPM_BASIS_gimp) base = MPMMin(MPMAll(all->most), base);
  if (all->wraps) {
    const MPMReal round = MPMSelect(base < 0.0, MPMAll(all->round), MPMAll(0));

    base += round;
    *xi += round;
  }
  return base;
}

/* Computes values and gradients as they are away from walls. */
MPM_INLINE void MPMBasisInside(MPMBasis basis, MPMReal xi, MPMReal l, MPMReal base, MPMReal w[], MPMReal g[])
{
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (basis == MPM_BASIS_##name) MPMBasisWeights_##name(xi, l, base, w, g);
#include "physics/basis.def"
}

#if MPM_WIDTH == 1 /* for one particle, with the base as an integer */
MPM_INLINE PetscInt MPMBasisBase(MPMBasis basis, PetscReal *xi, PetscReal l, PetscInt cells, PetscBool periodic,
                                 MPMWallBasis wall)
{
  const MPMBases all = MPMBasisBasesOf(basis, cells, periodic, wall);

  return (PetscInt)MPMBasisBases(basis, &all, l, xi);
}

MPM_INLINE void MPMBasisWeights(MPMBasis basis, PetscReal xi, PetscReal l, PetscInt base, PetscInt cells,
                                MPMWallBasis wall, PetscReal w[], PetscReal g[])
{
  if (!MPMWallWeights(basis, xi, cells, wall, w, g)) MPMBasisInside(basis, xi, l, (PetscReal)base, w, g);
}
#endif

#endif
