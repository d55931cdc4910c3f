/* skin.h - the layers of particles below a side of a body, in which a load on that side acts. A traction T on a side of
   normal N is, for every function phi of the grid, the same as a stress w T (x) N inside and a body force T |grad w|,
   where w is 1 at the surface and falls to 0 inside: the divergence theorem. So load and stress reach all nodes in the
   same way, also those beyond the surface that few particles touch. docs/method.md derives it (Loads). */
#ifndef MPM_SKIN_H
#define MPM_SKIN_H

#include "base/base.h"

/* Where a particle is below a side of its body, as one number; 0: there is no surface near. layer: 0 at the surface;
   layers: those of the body there, or more than are asked for; sides: those of the particle at the surface that are
   surface (bits 2d + side of axis d); area: of the column of particles on which the side acts, over that of the
   lattice. */
#define MPM_SKIN_MOST  127 /* layers that can be told apart */
#define MPM_SKIN_SIDES 64
#define MPM_SKIN_AREA  256 /* parts of an area that can be told apart; it is below 4 */
MPM_INLINE PetscInt MPMSkinPack(PetscInt layer, PetscInt layers, PetscInt sides, PetscReal area)
{
  const PetscInt parts = (PetscInt)PetscMin(4 * MPM_SKIN_AREA - 1, area * MPM_SKIN_AREA + 0.5);

  return 1 + layer + (MPM_SKIN_MOST + 1) * (layers + (MPM_SKIN_MOST + 1) * (sides + MPM_SKIN_SIDES * parts));
}

MPM_INLINE PetscReal MPMSkinArea(PetscInt depth)
{
  return (PetscReal)(depth / (MPM_SKIN_MOST + 1) / (MPM_SKIN_MOST + 1) / MPM_SKIN_SIDES) / MPM_SKIN_AREA;
}

MPM_INLINE PetscInt MPMSkinLayer(PetscInt depth) /* -1: there is no surface near */
{
  return depth % (MPM_SKIN_MOST + 1) - 1;
}

MPM_INLINE PetscInt MPMSkinSides(PetscInt depth)
{
  return depth / (MPM_SKIN_MOST + 1) / (MPM_SKIN_MOST + 1) % MPM_SKIN_SIDES;
}

/* Returns in how many layers w is 1, and in how many after them it falls: those of a cell, n particles on the axis. */
MPM_INLINE PetscInt MPMSkinWhole(PetscInt n)
{
  return PetscMin(n, (MPM_SKIN_MOST - 1) / 2);
}

/* Returns w of a particle, and sets *fall to |grad w| times the thickness of a layer. A body of fewer layers than 2
   whole has w = 1 in the outer half of them. */
MPM_INLINE PetscReal MPMSkinShare(PetscInt depth, PetscInt whole, PetscReal *fall)
{
  const PetscInt layer = MPMSkinLayer(depth), layers = depth / (MPM_SKIN_MOST + 1) % (MPM_SKIN_MOST + 1);
  const PetscInt n = PetscMin(whole, layers / 2), falling = PetscMin(whole, layers - n);

  *fall = layer >= n && layer < n + falling ? 1 / (PetscReal)falling : 0;
  return layer < 0 || layer >= n + falling ? 0 : layer < n ? 1 : 1 - ((PetscReal)(layer - n) + 0.5) * *fall;
}

#endif
