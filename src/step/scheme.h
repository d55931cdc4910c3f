/* scheme.h - the method of a step as data: the table of update schemes (phases.c) and of transfers (transfer.def). */
#ifndef MPM_SCHEME_H
#define MPM_SCHEME_H

#include "parallel/core.h"

/* An update scheme: a list of phases. */
#define MPM_MAX_SCHEME 8
typedef struct {
  const char *name, *what;
  PetscBool   keeps_increment; /* x is read again after the motion: dx waits for the commit */
  const int  *phases;          /* their places in the table of phases, then -1 */
} MPMScheme;
extern const MPMScheme MPMSchemes[]; /* rows of scheme.def; the last has no name */

/* A transfer: how particles get their velocity back from the grid. */
typedef struct {
  const char *name, *what;
  PetscReal   flip;     /* share of FLIP; < 0: it is -method_flip */
  PetscInt    parts;    /* added to the phases of momentum and motion: MPM_AFFINE of apic */
  PetscBool   filtered; /* xpic: a filter of -method_order goes before the scheme */
} MPMTransfer;
extern const MPMTransfer MPMTransfers[]; /* rows of transfer.def; the last has no name */

/* The method that a scene chose. */
typedef struct {
  const MPMScheme   *scheme;
  const MPMTransfer *transfer;
} MPMMethod;

/* Sets core->phases as this scene needs them, core->program, those of a step in order, and their timers. Once method,
   needs and basis are known. Collective on the world, for the events of -log_view. */
PetscErrorCode MPMStepSetUp(MPMCore *, const MPMMethod *);

/* The two phases that give mass and velocity of the nodes for output: k = 0, 1. */
const MPMPhase *MPMStepOutputPhase(const MPMCore *, PetscInt k);

/* The node kernels of phases (nodes.c): a row of nodes of a patch. */
void MPMNodesVelocity(const MPMParams *, MPMPatch *, PetscInt row);
void MPMNodesVelocityAgain(const MPMParams *, MPMPatch *, PetscInt row);
void MPMNodesResidual(const MPMParams *, MPMPatch *, PetscInt row);
void MPMNodesAdvance(const MPMParams *, MPMPatch *, PetscInt row);

#endif
