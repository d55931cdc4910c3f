/* fill.h - what fill.c does with a particle, for those who make particles elsewhere than on a lattice. */
#ifndef MPM_FILL_H
#define MPM_FILL_H

#include "scene/scene.h"

/* Checks a particle of body b with lattice place X [dim], m: its position, its velocity and the forces on it; a fault
   is left in the options. The second function makes particle p of a view: undeformed at X, or as the scene's known
   solution starts. Not collective. */
PetscErrorCode MPMFillCheck(MPMScene *, MPMCore *, MPMOptions, const MPMBody *, const PetscReal X[]);
PetscErrorCode MPMFillSet(const MPMScene *, const MPMCore *, const MPMBody *, PetscInt64 id, const PetscReal X[],
                          PetscInt p, MPMView *);

#endif
