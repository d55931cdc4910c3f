/* distance.c - signed distances from shapes, for rigid bodies: what particles are away from them, and along which
   normal they push. */
#include <stdlib.h>
#include "physics/distance.h"
#include "physics/march.h"

#define FINE 0.5 /* cells: spacing of the sampling of a formula, at most */
#define SHARE                                                                                                          \
  0.25            /* of that: within it, which side of a sampled surface a place is on is asked a little away from it */
#define BLUR 1.5  /* cells: near the end of what is sampled it is not exact */
#define FEW  256  /* faces in 3-D */
#define TINY 1e-9 /* cells: what is that near to a wall of the grid is at it */

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
    const PetscReal below = r->open[0][d] ? PETSC_MIN_REAL : r->lower[d] - x[d];
    const PetscReal above = r->open[1][d] ? PETSC_MIN_REAL : x[d] - r->upper[d], away = PetscMax(below, above);

    out[d] = away > 0 ? (above > below ? away : -away) : 0;
    if (away > 0) beyond = PETSC_TRUE;
    if (!(away > most)) continue;
    most = away;
    axis = d;
  }
  if (beyond) return Unit(dim, out, n);
  for (PetscInt d = 0; d < dim; d++) n[d] = 0;
  n[axis] = !r->open[1][axis] && (r->open[0][axis] || x[axis] - r->upper[axis] > r->lower[axis] - x[axis]) ? 1 : -1;
  return most;
}

static PetscReal FromSphere(const MPMRegion *r, PetscInt dim, const PetscReal x[], PetscReal n[])
{
  PetscReal away[3] = {0};

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
  PetscReal along = 0, across[3] = {0}, side[3], beside, beyond, sign;

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

/* Is a place inside of a surface, or is a formula positive there, without regard to lower and upper? */
static PetscBool Encloses(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  if (!r->surface) return r->formula(r->context, dim, x) > 0;
  for (PetscInt d = 0; d < r->surface->dim; d++)
    if (x[d] < r->surface->lower[d] || x[d] > r->surface->upper[d]) return PETSC_FALSE;
  (void)MPMSurfaceLine(r->surface, x);
  return MPMSurfaceBelow(r->surface, x[r->surface->dim - 1]) % 2 ? PETSC_TRUE : PETSC_FALSE;
}

/* The way from the nearest place `at` of the faces to a place x is along the normal n, to one side or the other, and
   the shape encloses what it leads to or not: returns -1 if so, else 1. A place on the faces is on neither side, and
   one near those of a formula may be on the wrong side of them: there one that is `margin` away from them decides. */
static PetscReal Side(const MPMRegion *r, PetscInt dim, const PetscReal x[], PetscReal distance, const PetscReal at[],
                      const PetscReal n[])
{
  PetscReal y[3];

  for (PetscInt d = 0; d < dim; d++)
    y[d] = d < r->nearest->dim && at && distance < r->margin ? at[d] + r->margin * n[d] : x[d];
  return Encloses(r, dim, y) ? -1 : 1;
}

/* Sets n [dim] to the direction from the nearest place `at` of a face to x, or to the normal of the face if they are
   too near to each other. */
static void Direction(const MPMRegion *r, PetscInt face, const PetscReal x[], const PetscReal at[], PetscReal n[])
{
  const PetscInt dim = r->nearest->dim;
  PetscReal      away[3], along = 0;

  for (PetscInt d = 0; d < dim; d++) away[d] = x[d] - at[d];
  if (Unit(dim, away, n) > 0.1 * r->margin || !MPMNearestNormal(r->nearest, face, n)) return;
  for (PetscInt d = 0; d < dim; d++) along += away[d] * n[d];
  for (PetscInt d = 0; d < dim && along < 0; d++) n[d] = -n[d];
}

static PetscReal FromFaces(const MPMRegion *r, PetscInt dim, const PetscReal x[], PetscReal n[])
{
  const MPMNearest *t = r->nearest;
  PetscReal         at[3], distance, side;
  PetscInt          face = -1;

  if (r->sampled) return MPMSampledAt(r->sampled, x, n);
  for (PetscInt d = 0; d < dim; d++) n[d] = 0;
  distance = MPMNearestPlace(t, x, at, &face);
  for (PetscInt d = 0; d < t->dim && face < 0; d++) at[d] = x[d] - 0.5 * (t->box[d] + t->box[t->dim + d]);
  if (face < 0)
    (void)Unit(t->dim, at, n);
  else
    Direction(r, face, x, at, n);
  side = Side(r, dim, x, distance, face < 0 ? NULL : at, n);
  for (PetscInt d = 0; d < t->dim; d++) n[d] *= side;
  return side * distance;
}

static PetscReal FromLimitedFaces(const MPMRegion *r, PetscInt dim, const PetscReal x[], PetscReal n[])
{
  PetscReal most = FromFaces(r, dim, x, n), m[3];

  Largest(dim, FromBox(r, dim, x, m), m, &most, n);
  return most;
}

/* By MPMRegionType; NULL: a list of particles has no shape. */
typedef PetscReal (*Distance)(const MPMRegion *, PetscInt, const PetscReal[], PetscReal[]);
static const Distance from[MPM_NUM_REGIONS] = {[MPM_REGION_box]        = FromBox,
                                               [MPM_REGION_sphere]     = FromSphere,
                                               [MPM_REGION_annulus]    = FromAnnulus,
                                               [MPM_REGION_cylinder]   = FromCylinder,
                                               [MPM_REGION_halfspace]  = FromHalfspace,
                                               [MPM_REGION_polygon]    = FromLimitedFaces,
                                               [MPM_REGION_expression] = FromLimitedFaces,
                                               [MPM_REGION_stl]        = FromFaces};

/* --- Before the first distance ------------------------------------------------------------------------------------ */

static PetscBool HasFaces(const MPMRegion *r)
{
  return r->surface || r->type == MPM_REGION_expression;
}

/* Returns whether what lies at the lower end of the grid along an axis, or at its upper end, is no surface of any
   shape: all if walls are open, and the axis of bodies of revolution. */
static PetscBool IsOpen(const MPMGrid *grid, PetscBool open, PetscInt d, PetscInt end)
{
  return open || (grid->round && d + end == 0 && grid->lower[0] == 0);
}

/* Copies the faces of a surface that do not lie at a wall of the grid, or beyond it, if such ones are open. */
static PetscBool CopyFaces(const MPMSurface *s, const MPMGrid *grid, PetscBool open, MPMFaces *to)
{
  const PetscInt size = s->dim * s->dim;

  to->corner = malloc((size_t)(s->n * size) * sizeof *to->corner);
  if (!to->corner) return PETSC_FALSE;
  for (PetscInt f = 0; f < s->n; f++) {
    PetscBool at = PETSC_FALSE;

    for (PetscInt d = 0; d < s->dim && (open || grid->round); d++) {
      PetscReal lo = PETSC_MAX_REAL, hi = PETSC_MIN_REAL;

      for (PetscInt k = d; k < size; k += s->dim) {
        lo = PetscMin(lo, s->corner[f * size + k]);
        hi = PetscMax(hi, s->corner[f * size + k]);
      }
      if ((IsOpen(grid, open, d, 0) && hi <= grid->lower[d] + TINY * grid->h[d]) ||
          (IsOpen(grid, open, d, 1) && lo >= grid->upper[d] - TINY * grid->h[d]))
        at = PETSC_TRUE;
    }
    if (!at) memcpy(to->corner + to->n++ * size, s->corner + f * size, (size_t)size * sizeof *to->corner);
  }
  return PETSC_TRUE;
}

static PetscReal Formula(const void *context, PetscInt dim, const PetscReal x[])
{
  const MPMRegion *r = (const MPMRegion *)context;

  return r->formula(r->context, dim, x);
}

/* Samples the zeros of a formula in its box, and a little beyond. */
static PetscBool SampleFormula(const MPMRegion *r, const MPMGrid *grid, PetscReal reach, MPMFaces *to)
{
  MPMImplicit of = {.dim = grid->dim, .f = Formula, .context = r};

  for (PetscInt d = 0; d < grid->dim; d++) {
    of.spacing[d] = FINE * grid->h[d];
    of.lower[d]   = r->lower[d] - (r->open[0][d] ? reach : grid->h[d]);
    of.upper[d]   = r->upper[d] + (r->open[1][d] ? reach : grid->h[d]);
  }
  return MPMMarch(&of, to);
}

/* The sign of a place of the lattice on which distances are sampled. */
static PetscReal Sign(const void *context, const PetscReal x[], PetscReal distance, const PetscReal at[])
{
  const MPMRegion *r       = (const MPMRegion *)context;
  PetscReal        away[3] = {0}, n[3];

  for (PetscInt d = 0; d < 3 && at; d++) away[d] = x[d] - at[d];
  (void)Unit(3, away, n);
  return Side(r, 3, x, distance, at, n);
}

/* Samples the distance from many faces, which are not needed any more then. */
static PetscBool Sample(MPMRegion *r, const MPMGrid *grid)
{
  PetscReal spacing[3];

  for (PetscInt d = 0; d < 3; d++) spacing[d] = FINE * grid->h[d];
  r->sampled = MPMSampledCreate(r->nearest, spacing, Sign, r);
  MPMNearestDestroy(&r->nearest);
  return r->sampled ? PETSC_TRUE : PETSC_FALSE;
}

void MPMRegionDropDistance(MPMRegion *r)
{
  MPMNearestDestroy(&r->nearest);
  MPMSampledDestroy(&r->sampled);
}

PetscBool MPMRegionMakeDistance(MPMRegion *r, const MPMGrid *grid, PetscBool open)
{
  const PetscBool endless = r->type == MPM_REGION_halfspace || r->type == MPM_REGION_polygon ||
                            r->type == MPM_REGION_expression;
  MPMFaces  faces = {0};
  PetscReal h     = 0, reach;
  PetscBool made  = PETSC_TRUE;

  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscBool own = r->type == MPM_REGION_polygon && d < 2; /* bounds of its corners */

    h             = PetscMax(h, grid->h[d]);
    r->open[0][d] = (IsOpen(grid, open, d, 0) || (endless && !own)) &&
                    r->lower[d] <= grid->lower[d] + TINY * grid->h[d];
    r->open[1][d] = (IsOpen(grid, open, d, 1) || (endless && !own)) &&
                    r->upper[d] >= grid->upper[d] - TINY * grid->h[d];
  }
  reach     = (MPM_DISTANCE_REACH + BLUR) * h;
  r->margin = TINY * h;
  MPMRegionDropDistance(r);
  if (r->surface) made = CopyFaces(r->surface, grid, open, &faces);
  if (r->type == MPM_REGION_expression) {
    r->margin = SHARE * FINE * h;
    made      = SampleFormula(r, grid, reach, &faces);
  }
  if (made && HasFaces(r)) {
    r->nearest = MPMNearestCreate(r->surface ? r->surface->dim : grid->dim, faces.n, faces.corner, reach);
    made       = r->nearest ? PETSC_TRUE : PETSC_FALSE;
    if (made && r->nearest->dim == 3 && faces.n > FEW) made = Sample(r, grid);
  }
  free(faces.corner);
  for (PetscInt k = 0; k < r->ncut + r->nwithin && made; k++) made = MPMRegionMakeDistance(r->others[k], grid, open);
  return made;
}

PetscBool MPMRegionHasDistance(const MPMRegion *r)
{
  if (!from[r->type] || (HasFaces(r) && !r->nearest && !r->sampled)) return PETSC_FALSE;
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
