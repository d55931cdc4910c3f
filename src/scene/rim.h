/* rim.h - where a body ends near a particle that fills it. rim.c says how this is found. Not collective. */
#ifndef MPM_RIM_H
#define MPM_RIM_H

#include "scene/scene.h"

/* Sets rim [dim], m, to the vector from X [dim], m, where the particle with lattice place x [dim], m, starts, at right
   angles to the surface of the body, if the neighbour on some side is not in the body, on one of `faces` (bits) if
   possible; else to 0. At an edge of the body it is that of the face there (own), for contact, or the mean of both, for
   walls, which meet the tip. The second function turns rim [dim] of particle p of a view back to what the particle's
   start state deforms to it: with -initial_stress a body starts deformed where its undeformed shape is. */
void MPMRim(const MPMBody *, PetscInt dim, PetscInt faces, PetscBool own, const PetscReal x[], const PetscReal X[],
            PetscReal rim[]);
void MPMRimUndoStart(const MPMScene *, const MPMBody *, PetscInt dim, const MPMView *, PetscInt p);

/* Sets depth [2 dim] of the place x [dim], m, of the body's lattice: how deep it is below each side of the body on
   which a load acts (physics/skin.h). */
void MPMRimDepth(const MPMScene *, const MPMBody *, PetscInt dim, const PetscReal x[], PetscInt depth[]);

#endif
