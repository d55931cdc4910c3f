/* neighbours.h - which particles were neighbours on the lattice at the start: the numbers (ids) of bodies as places,
   and back. A run uses it while it looks for matter that parts (advice/parting.c). */
#ifndef MPM_NEIGHBOURS_H
#define MPM_NEIGHBOURS_H

#include "scene/lattice.h"

/* A run of places of a row, along the last axis: its first place, how many there are, the id of the first; its row. */
typedef struct {
  PetscInt64 place, n, id, row;
} MPMLatticeRun;

/* The runs of a body, in the sequence of their ids: run[start[row]] .. run[start[row + 1] - 1] are those of a row. */
typedef struct {
  const MPMBody *body; /* NULL: its particles have no neighbours that count */
  MPMLattice     lattice;
  PetscInt       nruns, rows, *start;
  MPMLatticeRun *run;
} MPMNeighbours;

/* neighbours.c describes these functions. */
PetscErrorCode MPMNeighboursCreate(const MPMScene *, const MPMCore *, const MPMBody *, MPMNeighbours *);
PetscErrorCode MPMNeighboursDestroy(MPMNeighbours *);
void           MPMNeighboursPlace(const MPMNeighbours *, PetscInt64 id, PetscInt64 ijk[3]);
PetscInt64     MPMNeighboursId(const MPMNeighbours *, const PetscInt64 ijk[3]);
PetscBool      MPMNeighboursMay(const MPMMaterial *);

#endif
