/* sweep.c - shapes that are swept along a line: where lines of one direction leave a shape. What flows in comes through the
   part of a shape's surface that they leave (scene/source.c), and fills the space behind it. */
#include "physics/region.h"

const char MPMRegionsSwept[] = "box, sphere, cylinder or polygon";

/* Narrows from .. to, m along a line, to the part of it between two planes. x, e: its first place and its direction across
   them. A line beside them has no part. */
static void Slab(PetscReal x, PetscReal e, PetscReal lower, PetscReal upper, PetscReal *from, PetscReal *to)
{
  if (e == 0) {
    if (!(lower <= x && x < upper)) *to = -PETSC_MAX_REAL;
    return;
  }
  *from = PetscMax(*from, ((e > 0 ? lower : upper) - x) / e);
  *to   = PetscMin(*to, ((e > 0 ? upper : lower) - x) / e);
}

/* The same for a ball, or for what is less than the radius from the axis of a cylinder. */
static void Ball(const MPMRegion *r, PetscInt dim, const PetscReal x[], const PetscReal e[], PetscReal *from,
                 PetscReal *to)
{
  const PetscBool ball   = r->type == MPM_REGION_sphere;
  PetscReal       x_axis = 0, e_axis = 0, ee = 0, xe = 0, xx = 0, root;

  for (PetscInt d = 0; d < dim && !ball; d++) {
    x_axis += (x[d] - r->center[d]) * r->axis[d];
    e_axis += e[d] * r->axis[d];
  }
  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal p = x[d] - r->center[d] - x_axis * r->axis[d] * !ball, q = e[d] - e_axis * r->axis[d] * !ball;

    ee += q * q;
    xe += p * q;
    xx += p * p;
  }
  if (!ball) Slab(x_axis, e_axis, -0.5 * r->length, 0.5 * r->length, from, to);
  root = xe * xe - ee * (xx - r->radius * r->radius);
  if (ee < 1e-24) { /* along the axis of a cylinder */
    if (!(xx < r->radius * r->radius)) *to = -PETSC_MAX_REAL;
  } else if (!(root > 0))
    *to = -PETSC_MAX_REAL;
  else {
    *from = PetscMax(*from, (-xe - PetscSqrtReal(root)) / ee);
    *to   = PetscMin(*to, (-xe + PetscSqrtReal(root)) / ee);
  }
}

/* The same for a polygon, to where a line across its edges leaves it for the last time. A prism, which has lines along z too,
   is asked for them as it is for rows. */
static void Edges(const MPMRegion *r, const PetscReal x[], const PetscReal e[], PetscReal *to)
{
  const MPMSurface *s    = r->surface;
  PetscReal         last = -PETSC_MAX_REAL;

  for (PetscInt k = 0; k < s->n; k++) {
    const PetscReal *a = s->corner + 4 * k, *b = a + 2;
    const PetscReal  a_side = (a[0] - x[0]) * e[1] - (a[1] - x[1]) * e[0],
                    b_side  = (b[0] - x[0]) * e[1] - (b[1] - x[1]) * e[0];

    if ((a_side < 0) == (b_side < 0)) continue;
    last = PetscMax(last, (a_side * ((b[0] - x[0]) * e[0] + (b[1] - x[1]) * e[1]) -
                           b_side * ((a[0] - x[0]) * e[0] + (a[1] - x[1]) * e[1])) /
                              (a_side - b_side));
  }
  *to = PetscMin(*to, last);
}

PetscBool MPMRegionSweeps(const MPMRegion *r, PetscInt dim, const PetscReal e[])
{
  if (r->type == MPM_REGION_polygon && dim == 3) return e[2] == 0 || (e[0] == 0 && e[1] == 0);
  return r->type == MPM_REGION_box || r->type == MPM_REGION_sphere || r->type == MPM_REGION_cylinder ||
         r->type == MPM_REGION_polygon;
}

PetscBool MPMRegionLeaves(const MPMRegion *r, PetscInt dim, const PetscReal x[], const PetscReal e[], PetscReal *at)
{
  PetscReal from = -PETSC_MAX_REAL;

  *at = PETSC_MAX_REAL;
  if (r->type == MPM_REGION_sphere || r->type == MPM_REGION_cylinder)
    Ball(r, dim, x, e, &from, at);
  else
    for (PetscInt d = 0; d < dim; d++) Slab(x[d], e[d], r->lower[d], r->upper[d], &from, at);
  if (r->type == MPM_REGION_polygon && (e[0] != 0 || e[1] != 0))
    Edges(r, x, e, at);
  else if (r->type == MPM_REGION_polygon && *at > from) {
    (void)MPMSurfaceLine(r->surface, x);
    if (MPMSurfaceBelow(r->surface, x[1]) % 2 == 0) *at = -PETSC_MAX_REAL;
  }
  return *at > from;
}
