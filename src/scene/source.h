/* source.h - bodies that flow in (-sources). */
#ifndef MPM_SOURCE_H
#define MPM_SOURCE_H

#include "scene/scene.h"

/* Reads the sources, after bodies and initial states; a fault is left in the options. Extend lets the region of a source be
   that of all its particles, once their spacing is known. Layer returns the layer, from 0 on, in which a place [dim], m, of its
   lattice lies, Time when a layer enters, s. Check refuses a particle, with lattice place `place` [dim] and matter
   at X [dim], m, that would enter outside of the grid. Not collective. */
PetscErrorCode MPMSourcesSetFromOptions(MPMScene *, const MPMCore *, MPMOptions);
void           MPMSourceExtend(MPMBody *, PetscInt dim);
PetscInt       MPMSourceLayer(const MPMBody *, PetscInt dim, const PetscReal place[]);
PetscReal      MPMSourceTime(const MPMBody *, PetscInt layer);
void MPMSourceCheck(const MPMCore *, MPMOptions, const MPMBody *, const PetscReal place[], const PetscReal X[]);

/* Begin follows the particles of the start, or the state of a restart. Enter makes the particles that have come to the front
   of their source by now, on their processes, from number *first on; then all particles have to be settled anew. *any: there
   are some, on any process. The second is collective on exchange.data. */
PetscErrorCode MPMSourcesBegin(MPMScene *, MPMCore *, PetscBool restarted);
PetscErrorCode MPMSourcesEnter(MPMScene *, MPMCore *, PetscInt *first, PetscBool *any);

#endif
