/* outline.h - the surface of a shape, to be drawn. */
#ifndef MPM_OUTLINE_H
#define MPM_OUTLINE_H

#include "physics/distance.h"
#include "physics/march.h"

/* Adds the faces of the surface of a shape that has a distance: in 1-D its ends, in 2-D edges, in 3-D triangles, corner
   [n][dim][dim], m. They are closed: faces with a common corner have the same bits there. A box, a polygon and an STL
   that no other shape cuts or limits have their own faces; the surface of others is sampled with a spacing of a quarter
   of a cell, in 3-D half a cell, which cuts edges off by as much. Returns whether there was memory. Not collective. */
PetscBool MPMRegionOutline(const MPMRegion *, const MPMGrid *, MPMFaces *);

#endif
