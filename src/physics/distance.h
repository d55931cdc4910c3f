/* distance.h - how far a place is from the surface of a shape, and in which direction. */
#ifndef MPM_DISTANCE_H
#define MPM_DISTANCE_H

#include "physics/region.h"

/* Returns whether the distance of a shape, and of those that cut it or limit it, is built. */
PetscBool MPMRegionHasDistance(const MPMRegion *);

/* Returns the distance of x [dim], m, from the surface of the shape, m, negative inside, and sets n [dim] to the unit
   vector along which it grows fastest: the outward normal of the surface at its nearest place. Of a shape that others
   cut or limit, and of a halfspace with bounds, it is the largest of the distances of all that have to hold: exact
   inside, and near faces; beyond an edge where two of them meet it is at most 1/sqrt(2) too small. Where several places
   are nearest, as in the middle of a sphere, n is one of the directions to them. Not collective. */
PetscReal MPMRegionDistance(const MPMRegion *, PetscInt dim, const PetscReal x[], PetscReal n[]);

#endif
