/* region.c - the shapes of bodies: is a position inside, and a box around the shape. All bounds are half-open, so that
   bodies that share a face never share a place.                                                                      */
#include "physics/region.h"

static PetscReal Distance2(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  PetscReal s = 0;

  for (PetscInt d = 0; d < dim; d++) s += (x[d] - r->center[d]) * (x[d] - r->center[d]);
  return s;
}

static PetscBool Inside_box(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  for (PetscInt d = 0; d < dim; d++)
    if (!(r->lower[d] <= x[d] && x[d] < r->upper[d])) return PETSC_FALSE;
  return PETSC_TRUE;
}

static PetscBool Inside_sphere(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  return Distance2(r, dim, x) < r->radius * r->radius ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool Inside_annulus(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  const PetscReal s = Distance2(r, dim, x);

  return r->inner_radius * r->inner_radius <= s && s < r->radius * r->radius ? PETSC_TRUE : PETSC_FALSE;
}

const char *const MPMRegionNames[] = {
#define MPM_REGION(name, solid, parameters, what) #name,
#include "physics/region.def"
#undef MPM_REGION
};
const char *const MPMRegionParameters[] = {
#define MPM_REGION(name, solid, parameters, what) parameters,
#include "physics/region.def"
#undef MPM_REGION
};

PetscBool MPMRegionInside(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  static PetscBool (*const inside[])(const MPMRegion *, PetscInt, const PetscReal[]) = {
#define MPM_REGION(name, solid, parameters, what) Inside_##name,
#include "physics/region.def"
#undef MPM_REGION
  };

  return inside[r->type](r, dim, x);
}

PetscBool MPMRegionSolid(const MPMRegion *r)
{
  static const PetscBool solids[] = {
#define MPM_REGION(name, solid, parameters, what) solid,
#include "physics/region.def"
#undef MPM_REGION
  };

  return solids[r->type];
}

void MPMRegionBounds(const MPMRegion *r, PetscInt dim, PetscReal lower[], PetscReal upper[])
{
  for (PetscInt d = 0; d < dim; d++) {
    lower[d] = r->type == MPM_REGION_box ? r->lower[d] : r->center[d] - r->radius;
    upper[d] = r->type == MPM_REGION_box ? r->upper[d] : r->center[d] + r->radius;
  }
}
