/* region.h - shapes in space. A scene fills them with the particles of its bodies. */
#ifndef MPM_REGION_H
#define MPM_REGION_H

#include "physics/sampled.h"
#include "physics/surface.h"

typedef enum {
#define MPM_REGION(name, solid, parameters, what) MPM_REGION_##name,
#include "physics/region.def"
  MPM_NUM_REGIONS
} MPMRegionType;

/* A shape; the first dim coordinates of each member are used, in m. What is in one of the `ncut` shapes, the first of
   `others`, is outside of it, and so is what is not in all of the `nwithin` shapes that follow there. */
typedef struct _MPMRegion MPMRegion;
struct _MPMRegion {
  MPMRegionType type;
  PetscReal     center[3], lower[3], upper[3], radius, inner_radius, length;
  PetscReal     axis[3]; /* unit vector: axis of a cylinder, or normal of a halfspace, which points out of it */
  MPMSurface   *surface; /* of polygon and stl */
  PetscReal (*formula)(void *context, PetscInt dim, const PetscReal x[]); /* of expression */
  void               *context;
  PetscInt            ncut, nwithin;
  MPMRegion         **others;
  MPMNearest         *nearest; /* of polygon, stl and expression, for distances (distance.h); or NULL */
  MPMSampledDistance *sampled; /* of those that have many faces, in 3-D; or NULL */
  PetscReal           margin;  /* m: how far from the faces of `nearest` a place is known to be inside or outside */
  PetscBool open[2][3]; /* has the box from lower to upper no surface at its lower and upper ends, for distances? */
  PetscReal sweep,
      along[3]; /* not 0: it is what lies up to `sweep` m behind the shape's front, which is where lines along the
                                unit vector `along` leave it (sweep.c) */
};

/* A row of places along the last axis: place k is at (k + 1/2) spacing + offset there, and at x on the other axes. */
typedef struct {
  PetscInt  dim;
  PetscReal x[3], spacing, offset; /* m */
} MPMRow;

/* The rows of region.def, by MPMRegionType: names, and the options that a shape takes. MPMRegionSolid returns whether
   any line along an axis meets the shape in one piece around the middle of its bounds, or not at all. */
extern const char *const MPMRegionNames[], *const MPMRegionParameters[];
PetscBool MPMRegionSolid(const MPMRegion *);

PetscBool MPMRegionInside(const MPMRegion *, PetscInt dim, const PetscReal x[]);
PetscBool MPMRegionSpan(const MPMRegion *, MPMRow *, PetscInt64 from, PetscInt64 end, PetscInt64 *to);
void      MPMRegionBounds(const MPMRegion *, PetscInt dim, PetscReal lower[], PetscReal upper[]);

/* Swept shapes: the names of those that there are; returns whether a shape can be swept along the unit vector e [dim]; whether
   the line through x [dim], m, along e [dim] meets the shape, and *at, m: how far from x on it leaves it. */
extern const char MPMRegionsSwept[];
PetscBool         MPMRegionSweeps(const MPMRegion *, PetscInt dim, const PetscReal e[]);
PetscBool MPMRegionLeaves(const MPMRegion *, PetscInt dim, const PetscReal x[], const PetscReal e[], PetscReal *at);

/* Returns the coordinate of place k of a row on the last axis, m. */
MPM_INLINE PetscReal MPMRowPlace(const MPMRow *row, PetscInt64 k)
{
  return ((PetscReal)k + 0.5) * row->spacing + row->offset;
}

#endif
