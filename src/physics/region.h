/* region.h - shapes in space, which bodies fill. */
#ifndef MPM_REGION_H
#define MPM_REGION_H

#include "base/base.h"

typedef enum {
#define MPM_REGION(name, solid, parameters, what) MPM_REGION_##name,
#include "physics/region.def"
#undef MPM_REGION
  MPM_NUM_REGIONS
} MPMRegionType;

/* dim coordinates of each member count, m. */
typedef struct {
  MPMRegionType type;
  PetscReal     center[3], lower[3], upper[3], radius, inner_radius;
} MPMRegion;

/* The rows of region.def: names, the options that a shape takes, and whether any line along an axis meets it in one
   piece around the middle of its bounds, or not at all. */
extern const char *const MPMRegionNames[], *const MPMRegionParameters[];
PetscBool MPMRegionSolid(const MPMRegion *);

PetscBool MPMRegionInside(const MPMRegion *, PetscInt dim, const PetscReal x[]);
void      MPMRegionBounds(const MPMRegion *, PetscInt dim, PetscReal lower[], PetscReal upper[]);

#endif
