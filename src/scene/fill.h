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

/* Returns whether the place that is `by` m from x [dim], m, along axis k / 2, towards its upper end if k is odd, lies in
   the body. The second function sets rim [dim], m, to the vector from the place x of the body's lattice at right angles
   to the surface of the body, if the neighbour on some side is not in
   the body, on one of `faces` (bits) if possible; else to 0. Not collective. */
PetscBool MPMFillInside(const MPMBody *, PetscInt dim, const PetscReal x[], PetscInt k, PetscReal by);
void      MPMFillRim(const MPMBody *, PetscInt dim, PetscInt faces, const PetscReal x[], PetscReal rim[]);

#endif
