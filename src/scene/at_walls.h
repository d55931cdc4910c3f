/* at_walls.h - what is special about particles of a lattice that start beside walls; at_walls.c says why. None is
   collective. */
#ifndef MPM_AT_WALLS_H
#define MPM_AT_WALLS_H

#include "scene/scene.h"

/* Returns the radius at which the particle of a body of revolution starts whose place of the lattice is at r, m: the
   middle of what is right of the axis. */
PetscReal MPMAtWallsRadius(const MPMBody *, PetscReal r);

/* Moves the place x [dim], m, of a particle of body b inside the grid if no particle can start there. */
void MPMAtWallsMove(const MPMScene *, const MPMCore *, const MPMBody *, PetscReal x[]);

/* Returns whether particles of body b, which flows, would start exactly on a wall of axis d, so that they are moved. */
PetscBool MPMAtWallsLie(const MPMScene *, const MPMCore *, const MPMBody *, PetscInt d);

/* Sets the kinds of a body of revolution, whose particles have more mass the further they are from the axis: for each
   column of its lattice, by what they are beside, for which the scene has room; any: also by walls. The second function
   returns the kind of the particle with lattice place X [dim], m. */
#define MPM_AT_WALLS_COLUMN 9 /* no wall or one of two on each axis */
PetscErrorCode MPMAtWallsColumns(MPMScene *, const MPMCore *, MPMBody *, PetscBool any);
PetscInt       MPMAtWallsKind(const MPMScene *, const MPMCore *, const MPMBody *, const PetscReal X[]);

#endif
