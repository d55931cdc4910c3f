/* start_state.h - the state of a material that starts with a stress or with a deformation: the inverse of the laws.
   A scene uses it before the first step. */
#ifndef MPM_START_STATE_H
#define MPM_START_STATE_H

#include "physics/material.h"

/* The state of a particle as it starts. F is [dim*dim], and F33 1 but in bodies of revolution; be and tau are whole
   tensors, xx xy xz yy yz zz, tau in Pa. Of these a particle gets the fields that its material has. */
typedef struct {
  PetscReal F[9], F33, J, be[6], tau[6];
} MPMMaterialStart;

/* Sets the state with the deformation gradient F [dim*dim], or with the Kirchhoff stress tau [6], Pa, without rotation.
   In dimensions below 3 no law strains along the missing axes; only `whole`, which laws with be alone can follow, says
   that the stress along these is given too. Of bodies of revolution the one around the axis, zz, always is, and these
   have no function for F. Return NULL, or why this material cannot have it, and set tau of the state
   to the stress that it can have, as far as the law knows. Not collective. */
const char *MPMMaterialDeformed(const MPMMaterial *, PetscInt dim, const PetscReal F[], MPMMaterialStart *);
const char *MPMMaterialStressed(const MPMMaterial *, PetscInt dim, PetscBool whole, const PetscReal tau[],
                                MPMMaterialStart *);

#endif
