/* march.h - the surface of a shape that a function describes, as faces. */
#ifndef MPM_MARCH_H
#define MPM_MARCH_H

#include "base/base.h"

/* What is in the box from lower to upper [dim], m, with f(context, x) > 0: its surface is sampled with a spacing of at
   most spacing [dim], m. */
typedef struct {
  PetscInt  dim;
  PetscReal lower[3], upper[3], spacing[3];
  PetscReal (*f)(const void *context, PetscInt dim, const PetscReal x[]);
  const void *context;
} MPMImplicit;

/* Faces, corner [n][dim][dim] in m, of which there is room for `room`. */
typedef struct {
  PetscInt   n, room;
  PetscReal *corner;
} MPMFaces;

/* Adds the faces where f changes its sign: each box of the sampling is cut into dim! simplices, and the surface goes
   through those of their edges at the ends of which f has different signs, where f is 0: a corner of a face is within
   1/128 of an edge from there for every f, and nearer than that where f is smooth. Places between corners are within
   about c s^2/8 of the surface, c its largest curvature and s the diagonal of a box. What is thinner than the spacing
   may be missed. The surface has gaps only at the box. The same bits on all processes, which all compute it. Returns
   whether there was memory for it. Not collective. */
PetscBool MPMMarch(const MPMImplicit *, MPMFaces *);

#endif
