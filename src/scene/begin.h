/* begin.h - what volumes of particles depend on at the start of a run, and what its later stages and restarts keep, whose
   own options may differ. */
#ifndef MPM_BEGIN_H
#define MPM_BEGIN_H

#include "parallel/core.h"
#include "physics/wall.h"

/* Were basis, update and transfer given, so that the remedies of presets are off; the total frame; the basis; the types of
   walls. */
typedef struct {
  PetscInt plain, total, basis, wall[6];
} MPMStart;
#define MPM_START_NUMBERS ((PetscInt)(sizeof(MPMStart) / sizeof(PetscInt)))

/* Notes it of the options of this run, once walls and method have been read. Not collective. */
PetscErrorCode MPMStartNote(MPMStart *, const MPMCore *, const MPMWalls *);

#endif
