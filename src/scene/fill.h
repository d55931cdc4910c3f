/* fill.h - what fill.c does with a particle, for those who make particles elsewhere than on a lattice. */
#ifndef MPM_FILL_H
#define MPM_FILL_H

#include "scene/scene.h"

/* Checks a particle of body b with lattice place `place` [dim] whose matter is at X [dim], m: its position, its
   velocity and the forces on it; a fault is left in the options. The second function makes particle p of a view, with
   so many parts of its place (cut.h): undeformed at X, or as the scene's known solution starts. A particle of a file
   has the same place and X. Not collective. */
PetscErrorCode MPMFillCheck(MPMScene *, MPMCore *, MPMOptions, const MPMBody *, const PetscReal place[],
                            const PetscReal X[]);
PetscErrorCode MPMFillSet(const MPMScene *, const MPMCore *, const MPMBody *, PetscInt64 id, const PetscReal place[],
                          PetscInt parts, const PetscReal X[], PetscInt p, MPMView *);

#endif
