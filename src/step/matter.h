/* matter.h - where the matter of a particle ends (matter.c). View has the fields x, v, F, J, kind and rim as far as
   they are there. Not collective. */
#ifndef MPM_MATTER_H
#define MPM_MATTER_H

#include "parallel/core.h"

/* Sets F [dim*dim] to the deformation of particle p's domain, and returns the volume of the particle over that at the
   start, as far as its law keeps it. A fluid, and what flows, keeps no shape: its domain is the one of the start, with
   the particle's volume as far as its law keeps it, unless it is alone and has any volume. */
PetscReal MPMMatterDeformation(const MPMCore *, const MPMView *, PetscInt p, PetscReal F[]);

/* The end of a particle's matter: half of its domain at the start, m, and F; where the surface of its body was beside
   it at the start, a normal of this surface now, its squared size, and that times the distance, m; else size is 0. */
typedef struct {
  PetscReal half[3], F[9], normal[3], size, far;
} MPMMatterEnd;

/* Sets the end of particle p with that F [dim*dim]. */
void MPMMatterSetEnd(const MPMCore *, const MPMView *, PetscInt p, const PetscReal F[], MPMMatterEnd *);

/* Returns how far matter with that end reaches along -n [dim], m. Where the surface of its body was beside it at the
   start and now is turned towards -n, it reaches to that surface, straight ahead, or to the lowest place of its domain
   if that is lower by more than a tenth of a cell, h in m; else to the end of its domain. */
PetscReal MPMMatterReaches(PetscInt dim, const MPMMatterEnd *, const PetscReal n[], PetscReal h);

/* Returns how far, m, the end of particle p may come nearer, along -n, to what moves with V [dim], m/s, in this step at
   most: of what keeps its shape any distance. The end of what flows is where its centre is, less a constant; so nodes
   may approach only as its centre does, twice as fast, or else it would be stretched towards what it never reaches. */
PetscReal MPMMatterArrives(const MPMCore *, const MPMView *, PetscInt p, const PetscReal n[], const PetscReal V[]);

#endif
