/* region.c - the shapes of bodies: whether a position is inside, what of a row of places, and the box around the shape.
   All bounds are half-open, so bodies with a common face have no position in common. */
#include "physics/region.h"

/* Returns the squared distance of x from the centre in m^2. */
static PetscReal Distance2(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  PetscReal s = 0;

  for (PetscInt d = 0; d < dim; d++) s += (x[d] - r->center[d]) * (x[d] - r->center[d]);
  return s;
}

/* Returns the component of x - center along the axis in m. */
static PetscReal Along(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  PetscReal s = 0;

  for (PetscInt d = 0; d < dim; d++) s += (x[d] - r->center[d]) * r->axis[d];
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
  return Distance2(r, dim, x) < r->radius * r->radius;
}

static PetscBool Inside_annulus(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  const PetscReal s = Distance2(r, dim, x);

  return r->inner_radius * r->inner_radius <= s && s < r->radius * r->radius;
}

/* The squared distance from the axis is a sum of squares, which keeps its digits far from the centre. */
static PetscBool Inside_cylinder(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  const PetscReal s = Along(r, dim, x);
  PetscReal       q = 0;

  if (!(-0.5 * r->length <= s && s < 0.5 * r->length)) return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal away = x[d] - r->center[d] - s * r->axis[d];

    q += away * away;
  }
  return q < r->radius * r->radius;
}

static PetscBool Inside_halfspace(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  return Inside_box(r, dim, x) && Along(r, dim, x) < 0;
}

static PetscBool Inside_polygon(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  if (!Inside_box(r, dim, x)) return PETSC_FALSE;
  (void)MPMSurfaceLine(r->surface, x);
  return MPMSurfaceBelow(r->surface, x[1]) % 2 ? PETSC_TRUE : PETSC_FALSE;
}

/* A value that is not a number is not positive. */
static PetscBool Inside_expression(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  return Inside_box(r, dim, x) && r->formula(r->context, dim, x) > 0;
}

static PetscBool Inside_stl(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  (void)dim;
  (void)MPMSurfaceLine(r->surface, x);
  return MPMSurfaceBelow(r->surface, x[2]) % 2 ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool Inside_file(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  (void)r;
  (void)dim;
  (void)x;
  return PETSC_FALSE;
}

const char *const MPMRegionNames[] = {
#define MPM_REGION(name, solid, parameters, what) #name,
#include "physics/region.def"
};
const char *const MPMRegionParameters[] = {
#define MPM_REGION(name, solid, parameters, what) parameters,
#include "physics/region.def"
};

/* Returns whether x [dim] in m is inside the shape, without regard to others. */
static PetscBool InsideAlone(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  PetscReal at;

  static PetscBool (*const inside[])(const MPMRegion *, PetscInt, const PetscReal[]) = {
#define MPM_REGION(name, solid, parameters, what) Inside_##name,
#include "physics/region.def"
  };

  if (r->sweep > 0) return MPMRegionLeaves(r, dim, x, r->along, &at) && 0 < at && at <= r->sweep;
  return inside[r->type](r, dim, x);
}

/* Returns whether the position x [dim] in m is inside the shape. Not collective. */
PetscBool MPMRegionInside(const MPMRegion *r, PetscInt dim, const PetscReal x[])
{
  if (!InsideAlone(r, dim, x)) return PETSC_FALSE;
  for (PetscInt k = 0; k < r->ncut + r->nwithin; k++)
    if (MPMRegionInside(r->others[k], dim, x) == (k < r->ncut)) return PETSC_FALSE;
  return PETSC_TRUE;
}

PetscBool MPMRegionSolid(const MPMRegion *r)
{
  static const PetscBool solids[] = {
#define MPM_REGION(name, solid, parameters, what) solid,
#include "physics/region.def"
  };

  return solids[r->type] && !(r->sweep > 0);
}

/* Computes the box around the shape without regard to others; of a swept one it may be larger. */
static void BoundsAlone(const MPMRegion *r, PetscInt dim, PetscReal lower[], PetscReal upper[])
{
  const PetscBool cylinder = r->type == MPM_REGION_cylinder;
  const PetscBool centered = cylinder || r->type == MPM_REGION_sphere || r->type == MPM_REGION_annulus;

  for (PetscInt d = 0; d < dim; d++) {
    PetscReal half = r->radius;

    if (cylinder)
      half = 0.5 * r->length * PetscAbsReal(r->axis[d]) +
             r->radius * PetscSqrtReal(PetscMax(0, 1 - r->axis[d] * r->axis[d]));
    lower[d] = centered ? r->center[d] - half : r->lower[d];
    upper[d] = centered ? r->center[d] + half : r->upper[d];
    lower[d] -= PetscMax(0, r->sweep * r->along[d]);
    upper[d] += PetscMax(0, -r->sweep * r->along[d]);
  }
}

/* Computes the smallest box around the shape, lower and upper [dim] in m; it may be larger where other shapes cut it.
   Not collective. */
void MPMRegionBounds(const MPMRegion *r, PetscInt dim, PetscReal lower[], PetscReal upper[])
{
  BoundsAlone(r, dim, lower, upper);
  for (PetscInt k = r->ncut; k < r->ncut + r->nwithin; k++) {
    PetscReal lo[3], hi[3];

    MPMRegionBounds(r->others[k], dim, lo, hi);
    for (PetscInt d = 0; d < dim; d++) {
      lower[d] = PetscMax(lower[d], lo[d]);
      upper[d] = PetscMax(lower[d], PetscMin(upper[d], hi[d]));
    }
  }
}

/* --- Rows of places ----------------------------------------------------------------------------------------------- */

static PetscBool InsideRow(const MPMRegion *r, MPMRow *row, PetscInt64 k)
{
  row->x[row->dim - 1] = MPMRowPlace(row, k);
  return InsideAlone(r, row->dim, row->x);
}

/* Returns the last place inside, between a place inside and one outside. */
static PetscInt64 LastInside(const MPMRegion *r, MPMRow *row, PetscInt64 inside, PetscInt64 outside)
{
  while (PetscAbs(outside - inside) > 1) {
    const PetscInt64 middle = inside + (outside - inside) / 2;

    if (InsideRow(r, row, middle))
      inside = middle;
    else
      outside = middle;
  }
  return inside;
}

/* MPMRegionSpan of a solid shape: its piece of the row is around the middle of its bounds, and bisection finds the
   ends, so that not every place is examined: there may be billions. */
static PetscBool SpanSolid(const MPMRegion *r, MPMRow *row, PetscInt64 from, PetscInt64 end, PetscInt64 *to)
{
  const PetscInt d = row->dim - 1;
  PetscReal      lower[3], upper[3], middle;
  PetscInt64     k, first;

  *to = end;
  BoundsAlone(r, row->dim, lower, upper);
  middle = PetscFloorReal((0.5 * (lower[d] + upper[d]) - row->offset) / row->spacing - 0.5);
  if (!(middle > (PetscReal)from)) { /* its piece has begun, or begins with the next place, or is over */
    if (InsideRow(r, row, from)) {
      *to = LastInside(r, row, from, end) + 1;
      return PETSC_TRUE;
    }
    if (middle + 1 > (PetscReal)from) *to = from + 1;
    return PETSC_FALSE;
  }
  k = (PetscInt64)PetscMin(middle, 1e18);
  if (!InsideRow(r, row, k) && !InsideRow(r, row, ++k)) return PETSC_FALSE;
  first = LastInside(r, row, k, from - 1); /* it may reach to places before `end` from behind it */
  if (first > from) {
    *to = PetscMin(end, first);
    return PETSC_FALSE;
  }
  *to = k < end ? LastInside(r, row, k, end) + 1 : end;
  return PETSC_TRUE;
}

/* MPMRegionSpan of a surface whose lines are the rows. */
static PetscBool SpanSurface(const MPMSurface *s, const MPMRow *row, PetscInt64 from, PetscInt64 end, PetscInt64 *to)
{
  const PetscInt below = MPMSurfaceBelow(s, MPMRowPlace(row, from));

  *to = end;
  if (below < s->ncrossings) { /* the first place that is not before the next crossing */
    const PetscReal next = s->crossing[below], k = PetscCeilReal((next - row->offset) / row->spacing - 0.5);

    if (k < (PetscReal)end) {
      *to = PetscMax(from + 1, (PetscInt64)k);
      while (*to > from + 1 && MPMRowPlace(row, *to - 1) >= next) --*to;
      while (*to < end && MPMRowPlace(row, *to) < next) ++*to;
    }
  }
  return below % 2 ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether place `from` of a row is inside the shape, and sets *to to a place behind it, at most `end`, so that
   the places up to *to - 1 are inside or outside as it is. Not collective. */
PetscBool MPMRegionSpan(const MPMRegion *r, MPMRow *row, PetscInt64 from, PetscInt64 end, PetscInt64 *to)
{
  PetscBool inside;

  if (MPMRegionSolid(r))
    inside = SpanSolid(r, row, from, end, to);
  else if (r->type == MPM_REGION_stl) {
    (void)MPMSurfaceLine(r->surface, row->x);
    inside = SpanSurface(r->surface, row, from, end, to);
  } else {
    inside = InsideRow(r, row, from);
    *to    = from + 1;
  }
  for (PetscInt k = 0; k < r->ncut + r->nwithin && inside; k++) {
    PetscInt64 until;

    if (MPMRegionSpan(r->others[k], row, from, *to, &until) == (k < r->ncut)) inside = PETSC_FALSE;
    *to = until;
  }
  return inside;
}
