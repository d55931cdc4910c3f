/* round.h - what is different in bodies of revolution (-geometry axisymmetric), where x is r and y is z: the velocity
   gradient has v_r/r around the axis, the stress there pushes nodes outwards, and the mass of a node along r is that
   which a uniform expansion has. docs/method.md has the formulas. */
#ifndef MPM_ROUND_H
#define MPM_ROUND_H

#include "kernels/node.h"
#include "physics/grid.h"

#define MPM_ROUND_LEAST 1e-3 /* of a cell: the least radius by which anything is divided */

/* Returns the mass of node n along axis d, kg; i: its number on x. Along r it is the momentum of the velocity v_r = r
   over the node's r, so that the velocities of nodes are exact in a uniform expansion: with (1) they would be too large
   near the axis, because particles have more mass outside a node than inside. */
MPM_INLINE PetscReal MPMNodeMass(const MPMGrid *grid, const MPMNode *n, PetscInt i, PetscInt d)
{
  PetscReal r;

  if (!grid->round || d) return n->m;
  r = grid->lower[0] + (PetscReal)i * grid->h[0];
  return r > 0 ? n->p[2] / r : n->m;
}

/* Does so where `round` is a constant: without it that is the node's mass. */
MPM_INLINE PetscReal MPMNodeMassIf(int round, const MPMGrid *grid, const MPMNode *n, PetscInt i, PetscInt d)
{
  return round ? MPMNodeMass(grid, n, i, d) : n->m;
}

#endif
