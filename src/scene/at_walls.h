/* at_walls.h - what is special about particles of a lattice that start beside walls; at_walls.c says why. None is
   collective. */
#ifndef MPM_AT_WALLS_H
#define MPM_AT_WALLS_H

#include "scene/scene.h"

/* Moves the place x [dim], m, of a particle of body b inside the grid if no particle can start there. */
void MPMAtWallsMove(const MPMScene *, const MPMCore *, const MPMBody *, PetscReal x[]);

/* Returns whether particles of body b, which flows, would start exactly on a wall of axis d, so that they are moved. */
PetscBool MPMAtWallsLie(const MPMScene *, const MPMCore *, const MPMBody *, PetscInt d);

#endif
