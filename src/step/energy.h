/* energy.h - what the files of the balance of energy share: energy.c, energy_stress.c. */
#ifndef MPM_ENERGY_H
#define MPM_ENERGY_H

#include "step/step.h"

#define MPM_STRESS_ROW (9 + MPM_STRESS_NC) /* F, or x of a fluid, and tau of a particle as a step begins */

/* KeepStress notes the particles of a view in e->stress and e->stored as a step begins; AddStress adds what the stress
   has done to them when it ends. Not collective. */
void MPMEnergyKeepStress(const MPMCore *, const MPMView *, MPMEnergy *);
void MPMEnergyAddStress(const MPMCore *, const MPMView *, MPMEnergy *);

#endif
