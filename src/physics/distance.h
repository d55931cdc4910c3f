/* distance.h - how far a place is from the surface of a shape, and in which direction. */
#ifndef MPM_DISTANCE_H
#define MPM_DISTANCE_H

#include "physics/grid.h"
#include "physics/region.h"

#define MPM_DISTANCE_REACH 3.0 /* cells: how far from polygons, STLs and formulas distances are known */

/* Prepares the distance of a shape, and of those that cut it or limit it, whose surface and formula are set; it may be
   called again. Returns whether there was memory. MPMRegionDropDistance frees it, of this shape alone. Not collective:
   all processes make the same bits.

   The surface of a formula is sampled (march.h) with a spacing of half a cell at most. c s^2/8, c the curvature and s
   the diagonal of a box of the sampling, is about the error of its distances. Its edges are cut off by up to half a
   cell, and what is thinner than that may be missed. In 2-D, and in 3-D for up to 256 faces, every distance is that
   from the nearest face. In 3-D those from more faces are sampled with a spacing of half a cell and interpolated
   (sampled.h), with an error of up to 0.1 cells near edges. Of a disk or ball with a radius of 4 cells, by a formula or
   as small triangles, distances are within 0.04 cells and normals within 6.5 degrees; with 8 cells, within 0.02 cells
   and 3.3 degrees (tests/unit_distance.c).

   Memory: 50 bytes for an edge, 100 for each of up to 256 triangles; 32 bytes for each cell of the box around more of
   them, enlarged by 5 cells, and as long as they are sampled 200 bytes for each triangle, of which a formula has some
   40 for each cell at the surface. This takes about 0.4 ms for each cell at the surface.

   open: what of its surface lies at the walls of the grid, or beyond them, is no surface: matter is never on its other
   side, and near its edges normals would be wrong. This suits a shape that stays where it is. The bounds of the grid,
   which halfspaces, formulas and prisms have by default, are a surface of none of them. */
PetscBool MPMRegionMakeDistance(MPMRegion *, const MPMGrid *, PetscBool open);
void      MPMRegionDropDistance(MPMRegion *);

/* Returns whether a shape, and those that cut it or limit it, have a distance: a list of particles has none, and
   polygons, STLs and formulas have it once it is prepared. */
PetscBool MPMRegionHasDistance(const MPMRegion *);

/* Returns the distance of x [dim], m, from the surface of the shape, m, negative inside, and sets n [dim] to the unit
   vector along which it grows fastest: the outward normal of the surface at its nearest place. Beyond
   MPM_DISTANCE_REACH of a polygon, an STL or a formula it is at least that reach, and n any direction. Of a shape that
   others cut or limit, and of one with lower and upper bounds besides, it is the largest of the distances of all that
   have to hold: exact inside, and near faces; beyond an edge where two of them meet it is at most 1/sqrt(2) too small.
   Where several places are nearest, as in the middle of a sphere, n is one of the directions to them. Not collective.
   */
PetscReal MPMRegionDistance(const MPMRegion *, PetscInt dim, const PetscReal x[], PetscReal n[]);

#endif
