/* rigid.h - rigid bodies: a shape that moves as a whole. Where it is, how fast each of its places moves, and how far it
   is from a place. */
#ifndef MPM_RIGID_H
#define MPM_RIGID_H

#include "physics/distance.h"

/* A place X of the shape at the start is at pivot + place + turn (X - pivot). All are vectors of 3 numbers in every
   dimension; in 2-D a body turns about z. Of a free body the pivot is the centre of mass; mass is in kg and inertia,
   about that and at the start, in kg m^2, in 1-D and 2-D of a thickness of 1 m. What changes is in an array of all
   bodies: place, m; turn, a rotation, row-major; velocity of the pivot in this step, m/s; spin, rad/s; angular
   momentum, kg m^2/s; and what the body has given the matter since the last line of the history: impulse, N s, torque
   about the pivot times time, N m s; and since the start work, J; and angle, the integral of spin over time, rad. */
#define MPM_RIGID_NUMBERS 31
typedef struct {
  const char      *name;
  const MPMRegion *shape;
  PetscReal        mu; /* of friction */
  PetscReal        pivot[3];
  PetscBool        met;               /* by the lines of the history of this run it has given matter an impulse */
  PetscBool        moves, free, gone; /* gone: it has left the scene, and meets nothing */
  PetscBool        tied;              /* matter that lies in it moves with it */
  PetscInt   held; /* bits of the faces that are planes of symmetry of a free body: what is in the grid is held there */
  PetscReal  mass, inertia[9], inverse[9]; /* of that part; inverse: of inertia, where it may turn */
  PetscReal  reach;                        /* of the shape from the pivot, m */
  PetscInt   npoints;                      /* of a free body: points of its surface at the start, from the pivot, m */
  PetscReal *point;                        /* [npoints][3] */
  PetscReal  slid;      /* of a free one: its way along matter since the start or restart, m; below 0: that was told */
  PetscReal  before[6]; /* velocity and spin as the step began */
  PetscReal  pushed[3]; /* of a free body: acceleration of the body force at its centre in this step, m/s^2 */
  PetscReal *place, *turn, *velocity, *spin, *momentum, *impulse, *torque, *work, *angle;
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
  PetscReal y[3] = {0}, X[3] = {0}, m[3] = {0}, distance;

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

/* What a shape is made of, per density: volume, m^3, in 2-D m^2, in 1-D m; its centre, m; the second moments about
   that, m^5, [3][3], as inertia has them. rigid.c describes these functions; none is collective. */
typedef struct {
  PetscReal volume, center[3], inertia[9];
} MPMRigidMass;
void           MPMRigidMassOf(const MPMRegion *, PetscInt dim, PetscBool round, MPMRigidMass *);
PetscErrorCode MPMRigidSetFree(MPMRigid *, PetscInt dim, PetscReal mass, const PetscReal inertia[]);
PetscErrorCode MPMRigidSetPoints(MPMRigid *, PetscInt dim);
void           MPMRigidHold(MPMRigid *, PetscInt face, PetscReal share);
void           MPMRigidMove(MPMRigid *, PetscReal dt);
PetscReal      MPMRigidYields(const MPMRigid *, const PetscReal x[], const PetscReal n[]);
void           MPMRigidKick(MPMRigid *, const PetscReal x[], const PetscReal J[]);
void           MPMRigidPoint(const MPMRigid *, PetscInt k, PetscReal x[]);
PetscInt       MPMRigidLowest(const MPMRigid *, PetscInt dim, const PetscReal down[], PetscReal x[2][3]);
PetscReal      MPMRigidSpeed(const MPMRigid *);
PetscReal      MPMRigidEnergy(const MPMRigid *);
PetscBool      MPMRigidTouches(const MPMRigid *, const MPMRigid *, PetscInt dim, PetscReal most);
void           MPMRigidsMeet(PetscInt n, const MPMRigid body[], PetscInt dim, PetscReal most, PetscInt *a, PetscInt *b);

/* Returns whether planes of symmetry hold a body along axis d. */
MPM_INLINE PetscBool MPMRigidIsHeld(const MPMRigid *r, PetscInt d)
{
  return r->held >> 2 * d & 3 ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether a body is a ball or a disk. */
MPM_INLINE PetscBool MPMRigidIsRound(const MPMRigid *r)
{
  return r->shape->type == MPM_REGION_sphere && !(r->shape->ncut + r->shape->nwithin);
}

#endif
