/* cut.h - what the shape of a body leaves of the places of its lattice, before the first step. A place is a box of one
   spacing; those at the surface of a body lie partly outside. cut.c says how the particles share what is inside. */
#ifndef MPM_CUT_H
#define MPM_CUT_H

#include "scene/scene.h"

/* Reads whether bodies are to be cut; the first fault is left in o. The second function lets them be cut, or not, once
   scene->start is known. Not collective. */
PetscErrorCode MPMCutSetFromOptions(MPMScene *, MPMOptions);
PetscErrorCode MPMCutSetUp(MPMScene *);

/* Returns how many parts of MPMCutParts(dim) to a place the particle with lattice place `place` [dim], m, has, and sets
   X [dim], m, to their centroid. With -method_rim whole that is all of its place. Not collective. */
PetscInt MPMCutParts(PetscInt dim);
PetscInt MPMCut(const MPMBody *, PetscInt dim, const PetscReal place[], PetscReal X[]);

/* Begin to note what parts of places a body's particles have, note one, and add the kinds of all that there are to
   those of the scene, where the body's own kind is known; the last is collective on core->comm. The fourth function
   returns the kind of a particle, for which MPMCut gave the parts and X. */
PetscErrorCode MPMCutBegin(MPMBody *, PetscInt dim);
PetscErrorCode MPMCutNote(const MPMScene *, const MPMCore *, MPMBody *, const PetscReal place[], PetscInt parts,
                          const PetscReal X[]);
PetscErrorCode MPMCutEnd(MPMScene *, const MPMCore *, MPMBody *);
PetscInt       MPMCutKind(const MPMScene *, const MPMCore *, const MPMBody *, const PetscReal place[], PetscInt parts,
                          const PetscReal X[]);

#endif
