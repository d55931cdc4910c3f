/* kinds.h - the table of kinds of particles (physics/material.h). Not collective. */
#ifndef MPM_KINDS_H
#define MPM_KINDS_H

#include "scene/scene.h"

/* Makes room for so many more kinds in the table; returns the row of a kind, which is added if it is not among the
   first `known` rows. */
PetscErrorCode MPMKindsRoom(MPMScene *, PetscInt more);
PetscInt       MPMKindsFind(MPMScene *, PetscInt known, const MPMKind *);

#endif
