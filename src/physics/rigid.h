/* rigid.h - rigid bodies: a shape that moves as a whole. Where it is, how fast each of its places moves, and how far it is
   from a place. */
#ifndef MPM_RIGID_H
#define MPM_RIGID_H

#include "physics/distance.h"

/* A place X of the shape at the start is at pivot + place + turn (X - pivot). All are vectors of 3 numbers in every
   dimension; in 2-D a body turns about z. Of a free body the pivot is the centre of mass; mass is in kg and inertia, about
   that and at the start, in kg m^2, in 1-D and 2-D of a thickness of 1 m. What changes is in an array of all bodies:
   place, m; turn, a rotation, row-major; velocity of the pivot in this step, m/s; spin, rad/s; angular momentum, kg m^2/s;
   and what the body has given the matter since the last line of the history: impulse, N s, torque about the pivot times time, N m s; and since
   the start work, J. */
#define MPM_RIGID_NUMBERS 28
typedef struct {
  const char      *name;
  const MPMRegion *shape;
  PetscReal        mu; /* of friction; PETSC_INFINITY: nothing slides on it */
  PetscReal        pivot[3];
  PetscBool        moves, free;
  PetscReal        mass, inertia[9];
  PetscReal       *place, *turn, *velocity, *spin, *momentum, *impulse, *torque, *work;
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
}

#endif
