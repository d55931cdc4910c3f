/* rare.h - what transfers do seldom, so one particle at a time, in rare.c. */
#ifndef MPM_RARE_H
#define MPM_RARE_H

#include "kernels/blocks.h"

void MPMRareBadJ(PetscInt dim, const MPMPatch *, PetscBool has_F, PetscInt first, PetscInt last, const PetscInt *order,
                 const MPMBlock *, MPMStatus *);
void MPMRareWrap(PetscInt dim, const MPMGrid *, PetscInt n, MPMComponent *x);
void MPMRareStretch(PetscInt dim, const MPMParams *, MPMPatch *, PetscInt n, const PetscInt *order,
                    const MPMComponent *x, MPMStatus *);

#endif
