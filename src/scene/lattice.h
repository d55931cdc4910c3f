/* lattice.h - the lattice on which the particles of a body start: places (i+1/2) b + offset, b = h/ppc, anchored at the
   origin of space, wherever the body's shape is. It is used before the first step. Particles are numbered body by body
   as -bodies lists them, with x in the outer loop, so numbers do not depend on the number of processes. */
#ifndef MPM_LATTICE_H
#define MPM_LATTICE_H

#include "scene/scene.h"

/* An iterator over the particles of a body by their numbers. A row lies along the last axis; its particles form runs of
   neighbours. A body has as many rows as its lattice has places on the other axes; some rows have no particles. */
typedef struct {
  const MPMBody *body;
  PetscInt       dim;
  PetscInt64     first[3], last[3]; /* the range of lattice places that covers the body */
  PetscInt64     row, end;          /* numbers of the body's rows: the present one, and the one after the last */
  PetscInt64     ijk[3], n;         /* the run: its first place and its length */
  PetscInt64     id;                /* the number of its first particle */
} MPMLattice;

/* lattice.c describes these functions; none is collective. */
MPMLattice MPMLatticeBegin(const MPMBody *, PetscInt dim);
PetscBool  MPMLatticeNext(MPMLattice *);
PetscInt64 MPMLatticeRow(const MPMLattice *, const PetscInt64 ijk[]);
void       MPMLatticePlace(const MPMLattice *, PetscInt64 k, PetscReal X[3]);
MPMLattice MPMLatticeShare(const MPMScene *, const MPMBody *, PetscInt dim, PetscMPIInt rank, PetscMPIInt size);
void       MPMLatticeGoTo(const MPMScene *, MPMLattice *, PetscInt64 from, PetscInt64 to);
void       MPMLatticeRows(MPMLattice *, PetscInt64 from, PetscInt64 to, PetscInt64 id);

#endif
