/* region.h - shapes in space. A scene fills them with the particles of its bodies. */
#ifndef MPM_REGION_H
#define MPM_REGION_H

#include "base/base.h"

typedef enum {
#define MPM_REGION(name, solid, parameters, what) MPM_REGION_##name,
#include "physics/region.def"
#undef MPM_REGION
  MPM_NUM_REGIONS
} MPMRegionType;

/* A shape; the first dim coordinates of each member are used, in m. */
typedef struct {
  MPMRegionType type;
  PetscReal     center[3], lower[3], upper[3], radius, inner_radius;
} MPMRegion;

/* The rows of region.def, by MPMRegionType: names, and the options that a shape takes. MPMRegionSolid returns whether
   any line along an axis meets the shape in one piece around the middle of its bounds, or not at all. */
extern const char *const MPMRegionNames[], *const MPMRegionParameters[];
PetscBool MPMRegionSolid(const MPMRegion *);

PetscBool MPMRegionInside(const MPMRegion *, PetscInt dim, const PetscReal x[]);
void      MPMRegionBounds(const MPMRegion *, PetscInt dim, PetscReal lower[], PetscReal upper[]);

#endif
