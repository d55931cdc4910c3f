/* distance.c - signed distances from shapes, for rigid bodies: what particles are away from them, and along which
   normal they push. */
#include "physics/distance.h"

/* Sets n [dim] to v/|v|, or to the first axis if v is 0, and returns |v|. */
static PetscReal Unit(PetscInt dim, const PetscReal v[], PetscReal n[])
{
  PetscReal size = 0;

  for (PetscInt d = 0; d < dim; d++) size += v[d] * v[d];
  size = PetscSqrtReal(size);
  for (PetscInt d = 0; d < dim; d++) n[d] = size > 0 ? v[d] / size : d == 0;
  return size;
}

static PetscReal FromBox(const MPMRegion *r, PetscInt dim, const PetscReal x[], PetscReal n[])
{
  PetscReal out[3], most = PETSC_MIN_REAL;
  PetscInt  axis   = 0;
  PetscBool beyond = PETSC_FALSE;

  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal below = r->lower[d] - x[d], above = x[d] - r->upper[d], away = PetscMax(below, above);

    out[d] = away > 0 ? (above > below ? away : -away) : 0;
    if (away > 0) beyond = PETSC_TRUE;
    if (!(away > most)) continue;
    most = away;
    axis = d;
  }
  if (beyond) return Unit(dim, out, n);
  for (PetscInt d = 0; d < dim; d++) n[d] = 0;
  n[axis] = x[axis] - r->upper[axis] > r->lower[axis] - x[axis] ? 1 : -1;
  return most;
}

static PetscReal FromSphere(const MPMRegion *r, PetscInt dim, const PetscReal x[], PetscReal n[])
{
  PetscReal away[3];

  for (PetscInt d = 0; d < dim; d++) away[d] = x[d] - r->center[d];
  return Unit(dim, away, n) - r->radius;
}

static PetscReal FromAnnulus(const MPMRegion *r, PetscInt dim, const PetscReal x[], PetscReal n[])
{
  const PetscReal outer = FromSphere(r, dim, x, n), inner = r->inner_radius - r->radius - outer;

  if (outer >= inner) return outer;
  for (PetscInt d = 0; d < dim; d++) n[d] = -n[d];
  return inner;
}

/* Of a place beyond both the side and an end the nearest is on the edge between them. */
static PetscReal FromCylinder(const MPMRegion *r, PetscInt dim, const PetscReal x[], PetscReal n[])
{
  PetscReal along = 0, across[3], side[3], beside, beyond, sign;

  for (PetscInt d = 0; d < dim; d++) along += (x[d] - r->center[d]) * r->axis[d];
  for (PetscInt d = 0; d < dim; d++) across[d] = x[d] - r->center[d] - along * r->axis[d];
  sign   = along < 0 ? -1 : 1;
  beside = Unit(dim, across, side) - r->radius;
  beyond = PetscAbsReal(along) - 0.5 * r->length;
  if (beside > 0 && beyond > 0) {
    for (PetscInt d = 0; d < dim; d++) across[d] = beside * side[d] + beyond * sign * r->axis[d];
    return Unit(dim, across, n);
  }
  for (PetscInt d = 0; d < dim; d++) n[d] = beside > beyond ? side[d] : sign * r->axis[d];
  return PetscMax(beside, beyond);
}

/* Takes over the distance `other`, along m [dim], if it is larger than *most, along n. */
static void Largest(PetscInt dim, PetscReal other, const PetscReal m[], PetscReal *most, PetscReal n[])
{
  if (!(other > *most)) return;
  *most = other;
  for (PetscInt d = 0; d < dim; d++) n[d] = m[d];
}

static PetscReal FromHalfspace(const MPMRegion *r, PetscInt dim, const PetscReal x[], PetscReal n[])
{
  PetscReal most = 0, m[3];

  for (PetscInt d = 0; d < dim; d++) {
    most += (x[d] - r->center[d]) * r->axis[d];
    n[d] = r->axis[d];
  }
  Largest(dim, FromBox(r, dim, x, m), m, &most, n);
  return most;
}

/* By MPMRegionType; NULL: it is not built. */
typedef PetscReal (*Distance)(const MPMRegion *, PetscInt, const PetscReal[], PetscReal[]);
static const Distance from[MPM_NUM_REGIONS] = {[MPM_REGION_box]       = FromBox,
                                               [MPM_REGION_sphere]    = FromSphere,
                                               [MPM_REGION_annulus]   = FromAnnulus,
                                               [MPM_REGION_cylinder]  = FromCylinder,
                                               [MPM_REGION_halfspace] = FromHalfspace};

PetscBool MPMRegionHasDistance(const MPMRegion *r)
{
  if (!from[r->type]) return PETSC_FALSE;
  for (PetscInt k = 0; k < r->ncut + r->nwithin; k++)
    if (!MPMRegionHasDistance(r->others[k])) return PETSC_FALSE;
  return PETSC_TRUE;
}

PetscReal MPMRegionDistance(const MPMRegion *r, PetscInt dim, const PetscReal x[], PetscReal n[])
{
  PetscReal most = from[r->type](r, dim, x, n), m[3];

  for (PetscInt k = 0; k < r->ncut + r->nwithin; k++) {
    PetscReal other = MPMRegionDistance(r->others[k], dim, x, m);

    if (k < r->ncut) other = -other;
    for (PetscInt d = 0; d < dim && k < r->ncut; d++) m[d] = -m[d];
    Largest(dim, other, m, &most, n);
  }
  return most;
}
