/* unit_distance.c - signed distances from shapes: the sign is that of being inside, going by the distance along the
   normal leads to the surface, the normal is the gradient, and no surface is nearer. */
#include "physics/distance.h"
#include "unit.h"

#define H 1e-6 /* m, of differences */

static void Random(MPMRegion *r, int dim)
{
  PetscReal size = 0;

  r->radius       = UnitReal(0.5, 1);
  r->inner_radius = UnitReal(0.1, 0.4);
  r->length       = UnitReal(0.5, 2);
  for (int d = 0; d < dim; d++) {
    r->center[d] = UnitReal(-1, 1);
    r->lower[d]  = UnitReal(-1, -0.2);
    r->upper[d]  = UnitReal(0.2, 1);
    r->axis[d]   = UnitReal(-1, 1);
    size += r->axis[d] * r->axis[d];
  }
  for (int d = 0; d < dim; d++) r->axis[d] /= sqrt(size);
  for (int d = 0; d < dim && r->type == MPM_REGION_halfspace; d++) {
    r->lower[d] = -PETSC_INFINITY;
    r->upper[d] = PETSC_INFINITY;
  }
}

/* A place is far from edges and middles, where the normal jumps, if the distances around it are linear. */
static int Smooth(const MPMRegion *r, int dim, const PetscReal x[], PetscReal distance)
{
  for (int d = 0; d < dim; d++) {
    PetscReal y[3] = {x[0], x[1], x[2]}, n[3], sum = -2 * distance;

    for (int s = -1; s < 2; s += 2) {
      y[d] = x[d] + s * 1e-3;
      sum += MPMRegionDistance(r, dim, y, n);
    }
    if (fabs(sum) > 1e-4) return 0;
  }
  return 1;
}

/* exact: the distance is that of the nearest place, not only a bound of it. */
static void Check(const MPMRegion *r, int dim, int exact)
{
  PetscReal x[3] = {0}, n[3], y[3], m[3], size = 0, distance;

  for (int d = 0; d < dim; d++) x[d] = UnitReal(-2, 2);
  distance = MPMRegionDistance(r, dim, x, n);
  CHECK_EQ(distance < 0, MPMRegionInside(r, dim, x));
  for (int d = 0; d < dim; d++) size += n[d] * n[d];
  CHECK_NEAR(size, 1, 1e-14);
  if (!Smooth(r, dim, x, distance)) return;
  for (int d = 0; d < dim; d++) {
    PetscReal twice = 0;

    for (int s = -1; s < 2; s += 2) {
      memcpy(y, x, sizeof y);
      y[d] += s * H;
      twice += s * MPMRegionDistance(r, dim, y, m);
    }
    CHECK_NEAR(twice / (2 * H), n[d], 1e-4);
  }
  for (int d = 0; d < dim; d++) y[d] = x[d] - distance * n[d];
  if (exact) CHECK_NEAR(MPMRegionDistance(r, dim, y, m), 0, 1e-12);
  for (int k = 0; k < 20; k++) { /* nothing within the distance is on the other side */
    PetscReal away = 0, by = 0.999 * UnitReal(0, 1) * fabs(distance);

    for (int d = 0; d < dim; d++) {
      y[d] = UnitReal(-1, 1);
      away += y[d] * y[d];
    }
    for (int d = 0; d < dim; d++) y[d] = x[d] + by * y[d] / sqrt(away);
    CHECK_EQ(MPMRegionInside(r, dim, y), distance < 0);
  }
}

int main(void)
{
  for (int t = 0; t < MPM_NUM_REGIONS; t++) {
    const MPMRegion none = {.type = (MPMRegionType)t};

    for (int dim = 1; dim < 4 && MPMRegionHasDistance(&none); dim++) {
      if (t == MPM_REGION_cylinder && dim < 3) continue;
      for (int k = 0; k < 300; k++) {
        MPMRegion        r = {.type = (MPMRegionType)t}, ball = {.type = MPM_REGION_sphere};
        const MPMRegion *others[] = {&ball};

        UnitContext("%s in %d-D, number %d", MPMRegionNames[t], dim, k);
        Random(&r, dim);
        Random(&ball, dim);
        for (int q = 0; q < 10; q++) Check(&r, dim, 1);
        r.others = others;
        r.ncut = k % 2, r.nwithin = !(k % 2);
        for (int q = 0; q < 10; q++) Check(&r, dim, 0);
      }
    }
  }
  return UnitEnd();
}
