/* lattice.h - the lattice of places (i+1/2) b + offset, b = h/ppc, anchored at the origin of space, wherever a body's
   shape is; particles are numbered body by body in the order of -bodies, with x in the outer loop: a rule that knows no
   processes. */
#ifndef MPM_LATTICE_H
#define MPM_LATTICE_H

#include "scene/scene.h"

/* The iterator over rows of a body's particles, in the order of their numbers: a row is along the last axis, and has
   runs of neighbours. A body has as many rows as its lattice has places on the other axes, some without particles. */
typedef struct {
  const MPMBody *body;
  PetscInt       dim;
  PetscInt64     first[3], last[3]; /* the range of lattice places that covers the body */
  PetscInt64     row, end;          /* of the body's rows: the row at work, and the one before which it ends */
  PetscInt64     ijk[3], n;         /* the run: its first place and its length */
  PetscInt64     id;                /* the number of its first particle */
} MPMLattice;

MPMLattice MPMLatticeBegin(const MPMBody *, PetscInt dim);
PetscBool  MPMLatticeNext(MPMLattice *); /* the next run; false: there are no more, id is the number after the last */
PetscInt64 MPMLatticeRow(const MPMLattice *, const PetscInt64 ijk[]);
void       MPMLatticePlace(const MPMLattice *, PetscInt64 k, PetscReal X[3]);

/* Of the rows that are in this process's share; its id means nothing. And on to rows from .. to-1, from the last row
   before them whose first number is known. */
MPMLattice MPMLatticeShare(const MPMScene *, const MPMBody *, PetscInt dim, PetscMPIInt rank, PetscMPIInt size);
void       MPMLatticeGoTo(const MPMScene *, MPMLattice *, PetscInt64 from, PetscInt64 to);

#endif
