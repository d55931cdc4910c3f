/* rigid.c - how rigid bodies move, and what a free one weighs. */
#include "base/algebra.h"
#include "base/tensor.h"
#include "physics/rigid.h"

#define STANDS   0.02 /* a cylinder whose axis is as near to the vertical, rad, stands */
#define ROUNDING 1e-9 /* of a radius: what is as near to a surface lies on it */

/* Sets T [9] to the rotation by the angle |w| dt about w [3]: that of the quaternion (1, a w) with a = tan(dt
   |w|/2)/|w|, by its series to the third power of the angle: the error of an angle of 0.1 is 3e-9. */
static void Rotation(const PetscReal w[], PetscReal dt, PetscReal T[])
{
  const PetscReal half = 0.25 * dt * dt * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]); /* (angle/2)^2 */
  const PetscReal a    = 0.5 * dt * (1 + half * (1 / 3. + half * (2 / 15. + half * 17 / 315.)));
  PetscReal       q[3], size = 1;

  for (PetscInt d = 0; d < 3; d++) {
    q[d] = a * w[d];
    size += q[d] * q[d];
  }
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++) {
      const PetscInt f = 3 - d - e;

      T[3 * d + e] = d == e ? (2 + 2 * q[d] * q[d]) / size - 1
                            : 2 * (q[d] * q[e] + ((e + 1) % 3 == d ? q[f] : -q[f])) / size;
    }
}

/* C [9] = A B, or A B^T. */
static void Product(const PetscReal A[], const PetscReal B[], PetscBool transposed, PetscReal C[])
{
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++) {
      C[3 * d + e] = 0;
      for (PetscInt f = 0; f < 3; f++) C[3 * d + e] += A[3 * d + f] * (transposed ? B[3 * e + f] : B[3 * f + e]);
    }
}

/* Sets out [3] to the inverse of the inertia of a body with this turn [9], times v [3]. */
static void Inverse(const MPMRigid *r, const PetscReal turn[], const PetscReal v[], PetscReal out[])
{
  PetscReal A[9], B[9];

  Product(turn, r->inverse, PETSC_FALSE, A);
  Product(A, turn, PETSC_TRUE, B);
  for (PetscInt d = 0; d < 3; d++) out[d] = B[3 * d] * v[0] + B[3 * d + 1] * v[1] + B[3 * d + 2] * v[2];
}

/* Moves the body on by a step dt, s: by dt velocity, and by a turn of dt |spin| about spin. The spin of a free body is
   that of the middle of the step, which its angular momentum has there; afterwards that of the end. */
void MPMRigidMove(MPMRigid *r, PetscReal dt)
{
  PetscReal by[9], was[9], spin[3];

  for (PetscInt d = 0; d < 3; d++) {
    r->place[d] += dt * r->velocity[d];
    spin[d] = r->spin[d];
  }
  if (spin[0] == 0 && spin[1] == 0 && spin[2] == 0) return;
  for (PetscInt k = 0; k < 9; k++) was[k] = r->turn[k];
  if (r->free) {
    PetscReal middle[9];

    Rotation(spin, 0.5 * dt, by);
    Product(by, was, PETSC_FALSE, middle);
    Inverse(r, middle, r->momentum, spin);
  }
  for (PetscInt d = 0; d < 3; d++) r->angle[d] += dt * spin[d];
  Rotation(spin, dt, by);
  Product(by, was, PETSC_FALSE, r->turn);
  if (r->free) Inverse(r, r->turn, r->momentum, r->spin);
}

/* Returns how fast the place x [3] of a free body moves along n [3] for an impulse of 1 N s along n there, 1/kg. */
PetscReal MPMRigidYields(const MPMRigid *r, const PetscReal x[], const PetscReal n[])
{
  PetscReal y[3], arm[3], turns[3], by = 0, size = 0;

  for (PetscInt d = 0; d < 3; d++) {
    y[d] = x[d] - r->pivot[d] - r->place[d];
    if (!MPMRigidIsHeld(r, d)) size += n[d] * n[d];
  }
  MPMCross(y, n, arm);
  Inverse(r, r->turn, arm, turns);
  for (PetscInt d = 0; d < 3; d++) by += arm[d] * turns[d];
  return size / r->mass + by;
}

/* Gives a free body the impulse J [3], N s, at x [3]. */
void MPMRigidKick(MPMRigid *r, const PetscReal x[], const PetscReal J[])
{
  PetscReal y[3], moment[3];

  for (PetscInt d = 0; d < 3; d++) y[d] = x[d] - r->pivot[d] - r->place[d];
  MPMCross(y, J, moment);
  for (PetscInt d = 0; d < 3; d++) {
    if (!MPMRigidIsHeld(r, d)) r->velocity[d] += J[d] / r->mass;
    r->momentum[d] += moment[d];
  }
  Inverse(r, r->turn, r->momentum, r->spin);
}

/* Sets x [3] to where point k of the surface is, m. */
void MPMRigidPoint(const MPMRigid *r, PetscInt k, PetscReal x[])
{
  const PetscReal *X = r->point + 3 * k;

  for (PetscInt d = 0; d < 3; d++)
    x[d] = r->pivot[d] + r->place[d] + r->turn[3 * d] * X[0] + r->turn[3 * d + 1] * X[1] + r->turn[3 * d + 2] * X[2];
}

/* Sets x to the places of a ball, a ring or a cylinder that are farthest along the unit vector down [3], m: one, of a
   cylinder one at each end. Returns their number: 0 of other shapes, of a cylinder that stands on its end, and where a cut
   took them away; points of the surface know these well enough. */
PetscInt MPMRigidLowest(const MPMRigid *r, PetscInt dim, const PetscReal down[], PetscReal x[2][3])
{
  const MPMRegion *shape = r->shape;
  const PetscBool  rod   = shape->type == MPM_REGION_cylinder;
  PetscReal        center[3], end[3] = {0}, out[3], n[3], along = 0, size = 0;

  if (!rod && shape->type != MPM_REGION_sphere && shape->type != MPM_REGION_annulus) return 0;
  for (PetscInt d = 0; d < 3; d++) {
    center[d] = r->pivot[d] + r->place[d];
    for (PetscInt e = 0; e < dim; e++) center[d] += r->turn[3 * d + e] * (shape->center[e] - r->pivot[e]);
    for (PetscInt e = 0; e < dim && rod; e++) end[d] += r->turn[3 * d + e] * shape->axis[e];
    along += down[d] * end[d];
  }
  for (PetscInt d = 0; d < 3; d++) out[d] = down[d] - along * end[d];
  for (PetscInt d = 0; d < 3; d++) size += out[d] * out[d];
  size = PetscSqrtReal(size);
  if (size < STANDS) return 0;
  for (PetscInt k = 0; k < (rod ? 2 : 1); k++) {
    for (PetscInt d = 0; d < 3; d++)
      x[k][d] = center[d] + shape->radius * out[d] / size + (k ? -0.5 : 0.5) * (rod ? shape->length : 0) * end[d];
    if (MPMRigidDistance(r, dim, x[k], n) > ROUNDING * shape->radius) return 0;
  }
  return rod ? 2 : 1;
}

/* Returns a bound of the speed of all places of the body, m/s. */
PetscReal MPMRigidSpeed(const MPMRigid *r)
{
  PetscReal v = 0, w = 0;

  for (PetscInt d = 0; d < 3; d++) {
    v += r->velocity[d] * r->velocity[d];
    w += r->spin[d] * r->spin[d];
  }
  return PetscSqrtReal(v) + r->reach * PetscSqrtReal(w);
}

/* Returns the kinetic energy of a free body, J. */
PetscReal MPMRigidEnergy(const MPMRigid *r)
{
  PetscReal energy = 0;

  for (PetscInt d = 0; d < 3; d++)
    energy += 0.5 * (r->mass * r->velocity[d] * r->velocity[d] + r->spin[d] * r->momentum[d]);
  return energy;
}

/* Returns whether a body touches another one: a point of its surface, or of a ball and a disk the nearest one. */
PetscBool MPMRigidTouches(const MPMRigid *a, const MPMRigid *b, PetscInt dim, PetscReal most)
{
  PetscReal x[3], n[3], distance;

  for (PetscInt d = 0; d < 3; d++) x[d] = a->pivot[d] + a->place[d];
  distance = MPMRigidDistance(b, dim, x, n);
  if (MPMRigidIsRound(a)) {
    if (distance > a->shape->radius + most) return PETSC_FALSE;
    for (PetscInt d = 0; d < dim; d++) x[d] -= distance * n[d]; /* far from some shapes the distance is too small */
    return MPMRigidDistance(b, dim, x, n) <= 0.5 * distance;
  }
  for (PetscInt k = 0; k < a->npoints && distance <= a->reach + most; k++) {
    MPMRigidPoint(a, k, x);
    if (MPMRigidDistance(b, dim, x, n) <= most) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Finds two of n bodies, one of which is free, that are nearer to each other than `most`, m; a is -1 if there are none.
   */
void MPMRigidsMeet(PetscInt n, const MPMRigid body[], PetscInt dim, PetscReal most, PetscInt *a, PetscInt *b)
{
  *a = *b = -1;
  for (PetscInt i = 0; i < n && *a < 0; i++)
    for (PetscInt j = 0; j < n && body[i].free && *a < 0; j++) {
      if (i == j || body[j].gone || !MPMRigidTouches(&body[i], &body[j], dim, most)) continue;
      *a = i;
      *b = j;
    }
}

/* --- Mass --------------------------------------------------------------------------------------------------------- */

/* Samples along an axis: of volumes, and of points of the surface, by dimension. */
static const PetscInt samples[] = {1000, 400, 64}, rough[] = {4, 64, 24};

/* A grid of n places in the middle of boxes of size s [dim] in the bounds of a shape. */
typedef struct {
  PetscInt  dim, n, all;
  PetscReal lower[3], s[3], size;
} Samples;

static Samples SamplesOf(const MPMRegion *shape, PetscInt dim, PetscInt n)
{
  Samples   g        = {.dim = dim, .n = n, .all = 1, .size = 1};
  PetscReal upper[3] = {0};

  MPMRegionBounds(shape, dim, g.lower, upper);
  for (PetscInt d = 0; d < dim; d++) {
    g.s[d] = (upper[d] - g.lower[d]) / (PetscReal)n;
    g.size *= g.s[d];
    g.all *= n;
  }
  return g;
}

/* Sets x [3] to place k. */
static void SamplePlace(const Samples *g, PetscInt k, PetscReal x[])
{
  x[0] = x[1] = x[2] = 0;
  for (PetscInt d = 0; d < g->dim; d++, k /= g->n) x[d] = g->lower[d] + ((PetscReal)(k % g->n) + 0.5) * g->s[d];
}

/* Of balls and disks by formulas, else sums over 1000 places in 1-D, 400 x 400 in 2-D, 64 x 64 x 64 in 3-D: those near
   the surface count by how far their box lies inside by their distance. The errors of volume and inertia are 2e-5 for a
   disk, 2.2e-3 for a ball, and rounding for boxes (tests/unit_rigid.c). */
void MPMRigidMassOf(const MPMRegion *shape, PetscInt dim, PetscBool round, MPMRigidMass *m)
{
  const Samples g         = SamplesOf(shape, dim, samples[dim - 1]);
  PetscReal     second[9] = {0}, middle[3] = {0}, trace;

  *m = (MPMRigidMass){0};
  if (!round && shape->type == MPM_REGION_sphere && !(shape->ncut + shape->nwithin)) {
    const PetscReal R = shape->radius;

    m->volume = dim == 3 ? 4 * PETSC_PI / 3 * R * R * R : dim == 2 ? PETSC_PI * R * R : 2 * R;
    for (PetscInt d = 0; d < dim; d++) m->center[d] = shape->center[d];
    for (PetscInt d = 0; d < 3; d++) m->inertia[4 * d] = m->volume * R * R * (dim == 3 ? 0.4 : d == 2 ? 0.5 : 0.25);
    return;
  }
  for (PetscInt d = 0; d < dim; d++) middle[d] = g.lower[d] + 0.5 * (PetscReal)g.n * g.s[d];
  for (PetscInt k = 0; k < g.all; k++) {
    PetscReal x[3], n[3] = {0}, wide = 0, share, distance;

    SamplePlace(&g, k, x);
    distance = MPMRegionDistance(shape, dim, x, n);
    for (PetscInt d = 0; d < dim; d++) wide += PetscAbsReal(n[d]) * g.s[d];
    share = g.size * PetscClipInterval(0.5 - distance / wide, 0, 1) * (round ? 2 * PETSC_PI * PetscMax(0, x[0]) : 1);
    m->volume += share;
    for (PetscInt d = 0; d < dim; d++) x[d] -= middle[d]; /* far from the origin little would be left of the sums */
    for (PetscInt d = 0; d < dim; d++) {
      m->center[d] += share * x[d];
      for (PetscInt e = 0; e < dim; e++)
        second[3 * d + e] += share * (x[d] * x[e] + (d == e ? g.s[d] * g.s[d] / 12 : 0));
    }
  }
  if (!(m->volume > 0)) return;
  for (PetscInt d = 0; d < dim; d++) m->center[d] /= m->volume;
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++) second[3 * d + e] -= m->volume * m->center[d] * m->center[e];
  for (PetscInt d = 0; d < dim; d++) m->center[d] += middle[d];
  trace = second[0] + second[4] + second[8];
  for (PetscInt k = 0; k < 9; k++) m->inertia[k] = (k % 4 ? 0 : trace) - second[k];
}

/* Sets the points of the surface: a corner of a box, polygon or triangles each, and places of the rest of it, which are
   found from a grid of 64 x 64 places in 2-D, 24 x 24 x 24 in 3-D. */
PetscErrorCode MPMRigidSetPoints(MPMRigid *r, PetscInt dim)
{
  const MPMRegion *shape    = r->shape;
  const Samples    g        = SamplesOf(shape, dim, rough[dim - 1]);
  const PetscInt   ncorners = shape->surface && shape->surface->dim == dim ? shape->surface->n * dim : 0;
  PetscReal        near     = 0;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) near += 0.25 * g.s[d] * g.s[d];
  near = PetscSqrtReal(near);
  PetscCall(PetscMalloc1(3 * (g.all + 8 + ncorners), &r->point));
  for (PetscInt k = 0; k < g.all + 8 + ncorners; k++) {
    PetscReal x[3] = {0}, n[3] = {0}, distance;

    if (k < g.all) {
      SamplePlace(&g, k, x);
      if (PetscAbsReal(MPMRegionDistance(shape, dim, x, n)) > near) continue;
      for (int twice = 0; twice < 2; twice++) {
        distance = MPMRegionDistance(shape, dim, x, n);
        for (PetscInt d = 0; d < dim; d++) x[d] -= distance * n[d];
      }
    } else if (k < g.all + 8) { /* corners of a box */
      const PetscInt c = k - g.all;

      if (shape->type != MPM_REGION_box || c >> dim) continue;
      for (PetscInt d = 0; d < dim; d++) x[d] = c >> d & 1 ? shape->upper[d] : shape->lower[d];
    } else
      for (PetscInt d = 0; d < dim; d++) x[d] = shape->surface->corner[(k - g.all - 8) * dim + d];
    if (MPMRegionDistance(shape, dim, x, n) > 1e-3 * near) continue; /* a cut took it away */
    for (PetscInt d = 0; d < 3; d++) r->point[3 * r->npoints + d] = x[d] - r->pivot[d];
    r->npoints++;
  }
  PetscCall(PetscRealloc((size_t)(3 * r->npoints + 1) * sizeof *r->point, &r->point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets the plane of a face through the middle of a free body hold it: it may move along the plane, and turn about the normal
   of that. The part in the grid has this share of the mass. */
void MPMRigidHold(MPMRigid *r, PetscInt face, PetscReal share)
{
  const PetscInt axis = face / 2;

  r->held |= (PetscInt)1 << face;
  r->mass *= share;
  for (PetscInt d = 0; d < 3; d++) r->momentum[d] *= share;
  for (PetscInt k = 0; k < 9; k++) r->inertia[k] *= share;
  for (PetscInt k = 0; k < 9; k++) r->inverse[k] *= k == 4 * axis ? 1 / share : 0;
}

/* Makes the body free, with this mass, kg, and inertia [9], kg m^2, of which in 2-D only that about z counts and in 1-D
   none; its pivot has to be its centre of mass, its shape has to have a distance. */
PetscErrorCode MPMRigidSetFree(MPMRigid *r, PetscInt dim, PetscReal mass, const PetscReal inertia[])
{
  PetscFunctionBeginUser;
  r->free = PETSC_TRUE;
  r->mass = mass;
  for (PetscInt k = 0; k < 9; k++) r->inertia[k] = inertia[k];
  if (dim == 2) r->inverse[8] = 1 / inertia[8];
  if (dim == 3) {
    MPMCofactor(3, inertia, r->inverse); /* it is symmetric */
    for (PetscInt k = 0; k < 9; k++) r->inverse[k] /= MPMDet(3, inertia);
  }
  PetscCall(MPMRigidSetPoints(r, dim));
  PetscFunctionReturn(PETSC_SUCCESS);
}
