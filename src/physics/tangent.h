/* placeholder */
#ifndef MPM_TANGENT_H
#define MPM_TANGENT_H
#include "physics/material.h"
void MPMTangentTotal(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p, const PetscReal F[], PetscReal A[]);
#endif
