/* rigid.h - rigid bodies: a shape that moves as a whole. Where it is, how fast each of its places moves, and how far it is
   from a place. */
#ifndef MPM_RIGID_H
#define MPM_RIGID_H

#include "physics/distance.h"

/* A place X of the shape at the start is at pivot + place + turn (X - pivot). All are vectors of 3 numbers in every
   dimension; in 2-D a body turns about z. Of a free body the pivot is the centre of mass; mass is in kg and inertia, about
   that and at the start, in kg m^2, in 2-D of a thickness of 1 m. What changes is in an array of all bodies:
   place, m; turn, a rotation, row-major; velocity of the pivot in this step, m/s; spin, rad/s; angular momentum, kg m^2/s;
   and what the body has given the matter since the last line of the history: impulse, N s, torque about the pivot times time, N m s; and since
   the start work, J; and angle, the integral of spin over time, rad. */
#define MPM_RIGID_NUMBERS 31
typedef struct {
  const char      *name;
  const MPMRegion *shape;
  PetscReal        mu; /* of friction; PETSC_INFINITY: nothing slides on it */
  PetscReal        pivot[3];
  PetscBool        moves, free;
  PetscReal        mass, inverse[9]; /* inverse: of the inertia */
  PetscInt         npoints;
  PetscReal       *points; /* [npoints][3] of a free body: places on its surface at the start, m; of a sphere none */
  PetscReal       *place, *turn, *velocity, *spin, *momentum, *impulse, *torque, *work, *angle;
} MPMRigid;

/* Sets the pointers of a body to its numbers. */
MPM_INLINE void MPMRigidUse(MPMRigid *r, PetscReal numbers[])
{
  r->place    = numbers;
  r->turn     = numbers + 3;
  r->velocity = numbers + 12;
  r->spin     = numbers + 15;
  r->momentum = numbers + 18;
  r->impulse  = numbers + 21;
  r->torque   = numbers + 24;
  r->work     = numbers + 27;
  r->angle    = numbers + 28;
}

/* Returns the distance of x [dim], m, from the surface of the body, m, negative inside; n [dim]: its unit gradient. */
MPM_INLINE PetscReal MPMRigidDistance(const MPMRigid *r, PetscInt dim, const PetscReal x[], PetscReal n[])
{
  PetscReal y[3] = {0}, X[3], m[3] = {0}, distance;

  for (PetscInt d = 0; d < dim; d++) y[d] = x[d] - r->pivot[d] - r->place[d];
  for (PetscInt d = 0; d < dim; d++) {
    X[d] = r->pivot[d];
    for (PetscInt e = 0; e < dim; e++) X[d] += r->turn[3 * e + d] * y[e];
  }
  distance = MPMRegionDistance(r->shape, dim, X, m);
  for (PetscInt d = 0; d < dim; d++) {
    n[d] = 0;
    for (PetscInt e = 0; e < dim; e++) n[d] += r->turn[3 * d + e] * m[e];
  }
  return distance;
}

/* Sets V [3] to the velocity of the body at x [dim], m/s. */
MPM_INLINE void MPMRigidVelocity(const MPMRigid *r, PetscInt dim, const PetscReal x[], PetscReal V[])
{
  PetscReal y[3] = {0};

  for (PetscInt d = 0; d < dim; d++) y[d] = x[d] - r->pivot[d] - r->place[d];
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt e = (d + 1) % 3, f = (d + 2) % 3;

    V[d] = r->velocity[d] + r->spin[e] * y[f] - r->spin[f] * y[e];
  }
}

/* Sets x [3] to where the place X [3] of the start is now, m. */
MPM_INLINE void MPMRigidPlace(const MPMRigid *r, const PetscReal X[], PetscReal x[])
{
  for (PetscInt d = 0; d < 3; d++) {
    x[d] = r->pivot[d] + r->place[d];
    for (PetscInt e = 0; e < 3; e++) x[d] += r->turn[3 * d + e] * (X[e] - r->pivot[e]);
  }
}

/* Sets w [3] to the spin that angular momentum L [3] has as the body is turned now. */
MPM_INLINE void MPMRigidSpin(const MPMRigid *r, const PetscReal L[], PetscReal w[])
{
  PetscReal own[3] = {0}, by[3] = {0};

  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++) own[d] += r->turn[3 * e + d] * L[e];
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++) by[d] += r->inverse[3 * d + e] * own[e];
  for (PetscInt d = 0; d < 3; d++) {
    w[d] = 0;
    for (PetscInt e = 0; e < 3; e++) w[d] += r->turn[3 * d + e] * by[e];
  }
}

/* Sets m [3] to (at - centre) x J. */
MPM_INLINE void MPMRigidMoment(const MPMRigid *r, const PetscReal at[], const PetscReal J[], PetscReal m[])
{
  PetscReal y[3];

  for (PetscInt d = 0; d < 3; d++) y[d] = at[d] - r->pivot[d] - r->place[d];
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt e = (d + 1) % 3, f = (d + 2) % 3;

    m[d] = y[e] * J[f] - y[f] * J[e];
  }
}

/* Gives a free body the impulse J [3], N s, at a place `at` [3], m. */
MPM_INLINE void MPMRigidPush(MPMRigid *r, const PetscReal at[], const PetscReal J[])
{
  PetscReal m[3];

  if (!r->free) return;
  MPMRigidMoment(r, at, J, m);
  for (PetscInt d = 0; d < 3; d++) {
    r->velocity[d] += J[d] / r->mass;
    r->momentum[d] += m[d];
  }
  MPMRigidSpin(r, r->momentum, r->spin);
}

/* Returns by how much an impulse along n [3] at a place changes the velocity of the body there along n, 1/kg; and an upper
   bound of that across n, which is exact in 2-D and of spheres. */
MPM_INLINE PetscReal MPMRigidYields(const MPMRigid *r, const PetscReal at[], const PetscReal n[], PetscReal *across)
{
  PetscReal m[3], w[3], own = 0, square = 0, along = 0, most = 0;

  *across = 0;
  if (!r->free) return 0;
  MPMRigidMoment(r, at, n, m);
  MPMRigidSpin(r, m, w);
  for (PetscInt d = 0; d < 3; d++) {
    const PetscReal y = at[d] - r->pivot[d] - r->place[d];
    PetscReal       row = 0;

    own += m[d] * w[d];
    square += y * y;
    along += y * n[d];
    for (PetscInt e = 0; e < 3; e++) row += PetscAbsReal(r->inverse[3 * d + e]);
    most = PetscMax(most, row);
  }
  *across = 1 / r->mass + (r->inverse[0] > 0 ? square : along * along) * most; /* in 2-D it turns about z alone */
  return 1 / r->mass + own;
}

/* Moves the body on by a step dt, s: by dt velocity, and by a turn of dt |spin| about spin. The turn is that of the
   quaternion (1, a spin) with a = tan(dt |spin|/2)/|spin|, by its series to the third power of the angle: the error of an
   angle of 0.1 is 3e-9. */
MPM_INLINE void MPMRigidMove(MPMRigid *r, PetscReal dt)
{
  const PetscReal *w = r->spin, half = 0.25 * dt * dt * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]); /* (angle/2)^2 */
  const PetscReal  a = 0.5 * dt * (1 + half * (1 / 3. + half * (2 / 15. + half * 17 / 315.)));
  PetscReal        q[3], size = 1, by[9], was[9];

  for (PetscInt d = 0; d < 3; d++) {
    r->place[d] += dt * r->velocity[d];
    r->angle[d] += dt * w[d];
    q[d] = a * w[d];
    size += q[d] * q[d];
  }
  if (size == 1) return;
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++) {
      const PetscInt f = 3 - d - e;

      by[3 * d + e] = d == e ? (2 + 2 * q[d] * q[d]) / size - 1
                             : 2 * (q[d] * q[e] + ((e + 1) % 3 == d ? q[f] : -q[f])) / size;
    }
  for (PetscInt k = 0; k < 9; k++) was[k] = r->turn[k];
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++)
      r->turn[3 * d + e] = by[3 * d] * was[e] + by[3 * d + 1] * was[3 + e] + by[3 * d + 2] * was[6 + e];
  if (r->free) MPMRigidSpin(r, r->momentum, r->spin); /* the angular momentum stays, and the inertia turns */
}

#endif
