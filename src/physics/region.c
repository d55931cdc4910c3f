/* region.c - the shapes of bodies: whether a position is inside, and the box around the shape. All bounds are
   half-open, so bodies with a common face have no position in common. */
#include "physics/region.h"

/* Returns the squared distance of x from the centre in m^2. */
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

/* Returns whether the position x [dim] in m is inside the shape. Not collective. */
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

/* Computes the smallest box around the shape, lower and upper [dim] in m. Not collective. */
void MPMRegionBounds(const MPMRegion *r, PetscInt dim, PetscReal lower[], PetscReal upper[])
{
  for (PetscInt d = 0; d < dim; d++) {
    lower[d] = r->type == MPM_REGION_box ? r->lower[d] : r->center[d] - r->radius;
    upper[d] = r->type == MPM_REGION_box ? r->upper[d] : r->center[d] + r->radius;
  }
}
