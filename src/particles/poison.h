/* poison.h - with DEBUG=poison, memory whose content nobody may use is filled with a pattern: as a real it is a
   signalling NaN, as an index far outside of every array. A kernel that reads what its phase did not declare, or what
   was not written yet, then gives NaN or stops, instead of the right numbers of the step before. In other builds these
   calls are nothing. */
#ifndef MPM_POISON_H
#define MPM_POISON_H

#include "particles/particles.h"

#if defined(MPM_POISON)

void           MPMPoison(void *at, size_t bytes);
PetscErrorCode MPMPoisonFields(MPMParticles *, PetscInt fields, PetscInt first);
PetscErrorCode MPMPoisonPhase(MPMParticles *, PetscInt in, PetscInt out);
PetscErrorCode MPMPoisonCheck(MPMParticles *, const char phase[], PetscInt out);

#else

#define MPMPoison(at, bytes)              ((void)0)
#define MPMPoisonFields(p, fields, first) ((void)(first), PETSC_SUCCESS)
#define MPMPoisonPhase(p, in, out)        PETSC_SUCCESS
#define MPMPoisonCheck(p, phase, out)     PETSC_SUCCESS

#endif

#endif
