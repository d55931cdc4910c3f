/* basis_type.h - which bases there are, and what is known of each without the values of its functions (basis.h). */
#ifndef MPM_BASIS_TYPE_H
#define MPM_BASIS_TYPE_H

#include "physics/spline_wall.h"

typedef enum {
#define MPM_BASIS(name, nodes, layers, inertia, what) MPM_BASIS_##name,
#include "physics/basis.def"
  MPM_NUM_BASES
} MPMBasis;

#define MPM_MAX_STENCIL 4 /* nodes per axis of the widest basis */
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  _Static_assert((nodes) <= MPM_MAX_STENCIL, #name " has more nodes than MPM_MAX_STENCIL");
#include "physics/basis.def"

/* Returns the nodes of a stencil per axis. */
MPM_INLINE int MPMBasisNodes(MPMBasis basis)
{
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (basis == MPM_BASIS_##name) return nodes;
#include "physics/basis.def"
  return 0;
}

/* Returns the layers of nodes that the basis needs beyond each wall. */
MPM_INLINE int MPMBasisLayers(MPMBasis basis)
{
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (basis == MPM_BASIS_##name) return layers;
#include "physics/basis.def"
  return 0;
}

/* Returns the inertia of basis.def. */
MPM_INLINE int MPMBasisInertia(MPMBasis basis)
{
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (basis == MPM_BASIS_##name) return inertia;
#include "physics/basis.def"
  return 0;
}

/* Returns the distance of the middle of a cell from the base node that names it, in cells; with gimp a particle's
   half-width is added. */
MPM_INLINE PetscReal MPMBasisMiddle(MPMBasis basis)
{
  return basis == MPM_BASIS_gimp ? 0.5 : 0.5 * (MPMBasisNodes(basis) - 1);
}

/* Returns whether the basis is a spline, which needs a form of its own at walls. */
MPM_INLINE PetscBool MPMBasisIsSpline(MPMBasis basis)
{
  return MPMBasisInertia(basis) ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the integral over the grid of the function of node i of an axis with walls, in cells: 1, less what a wall
   cuts off. Of gimp it is that of the hat functions, over which domains that end at the wall are averaged. */
MPM_INLINE PetscReal MPMBasisIntegral(MPMBasis basis, PetscInt i, PetscInt cells, MPMWallBasis wall)
{
  static const PetscReal hat[2] = {1. / 2, 0}, cut[2][2][2] = {{{11. / 24, 1. / 24}, {5. / 12, 1. / 12}},
                                                               {{1. / 3, 1. / 6}, {1. / 4, 1. / 4}}};
  const PetscReal *less = MPMBasisIsSpline(basis) ? cut[wall == MPM_WALL_BASIS_STEFFEN][MPMBasisNodes(basis) - 3] : hat;

  if (i < 0 || i > cells) return 0;
  return 1 - (i < 2 ? less[i] : 0) - (cells - i < 2 ? less[cells - i] : 0);
}

#endif
