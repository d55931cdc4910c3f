/* rare.h - what transfers do for one particle at a time, since few particles or few scenes need it: bad J, periodic
   faces, affine velocities near walls, new cells (rare.c). G2P calls these for a block. */
#ifndef MPM_RARE_H
#define MPM_RARE_H

#include "kernels/stencils.h"

void MPMRareBadJ(PetscInt dim, const MPMPatch *, PetscBool has_F, PetscInt first, PetscInt last, const PetscInt *order,
                 const MPMStencils *, const MPMBlock *, MPMStatus *);
void MPMRareWrap(PetscInt dim, const MPMPatch *, PetscInt n, const PetscInt *order);
void MPMRareInertia(PetscInt dim, MPMBasis, const MPMGrid *, PetscInt n, MPMStencils *);
uint64_t MPMRarePlanes(PetscInt dim, const MPMParams *, const MPMPatch *, PetscInt n, const PetscInt *order,
                       const MPMStencils *);
void     MPMRareCells(PetscInt dim, const MPMParams *, MPMPatch *, PetscInt q, PetscInt n, const PetscInt *which,
                      const PetscInt *order, const MPMStencils *, MPMStatus *);

#endif
