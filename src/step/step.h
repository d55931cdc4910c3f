/* step.h - a step of the method, and its length. */
#ifndef MPM_STEP_H
#define MPM_STEP_H

#include "scene/scene.h"
#include "step/scheme.h"

/* A step from core->t over params.dt: afterwards status holds what it found; if status.bad is set, the state is that of
   the failed step and has not settled. Collective on the exchange. */
PetscErrorCode MPMStep(MPMCore *, const MPMScene *);

/* Mass and velocity of the nodes for the state as it is, as output shows them; changes no particle, and is no work of a
   step. Collective on the exchange. */
PetscErrorCode MPMStepNodes(MPMCore *);

/* Largest squared speed of a particle and of a wave in the state as it is, into status: what a step leaves there, for a
   state that no step has made. Collective on the exchange. */
PetscErrorCode MPMStepBound(MPMCore *);

/* The length of steps. */
typedef struct {
  PetscReal end, fixed, cfl; /* s, s, 1; fixed 0: dt = cfl h/(c + |v|) */
  PetscInt  max_steps;
} MPMTime;

PetscReal MPMTimeStep(const MPMCore *, const MPMTime *); /* dt of the next step, s */
PetscReal MPMCourant(const MPMCore *, PetscReal dt);     /* dt (c + |v|)/h of the state */
PetscReal MPMViscousStep(const MPMCore *);               /* bound of dt by viscosity, s; infinite without */

#endif
