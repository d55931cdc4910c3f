/* exchange.h - the ways to run a step, and what they share. */
#ifndef MPM_EXCHANGE_H
#define MPM_EXCHANGE_H

#include "options/options.h"
#include "parallel/core.h"

extern const MPMExchangeType *const MPMExchangeTypes[];                      /* rows of exchange.def, ends with NULL */
extern const MPMExchangeType        MPMExchange_serial, MPMExchange_spatial; /* the pool's master is one of them */

/* Chooses how the step is run. Collective on core->comm. */
PetscErrorCode MPMExchangeSetFromOptions(MPMCore *, MPMOptions);

/* The DMs of the grid, cut into parts[axis] boxes of widths[axis][part] nodes (NULL: one process has it all), and on
   this process's box the patch and the vectors behind its nodes; and their end. Collective on exchange.data. */
PetscErrorCode MPMExchangeCreateGrid(MPMCore *, const PetscInt parts[3], PetscInt *const widths[3]);
PetscErrorCode MPMExchangeDestroyGrid(MPMCore *);

/* Shows the patch the sums and the motion of its nodes, which are those of the vectors; and takes them back. Not
   collective. */
PetscErrorCode MPMExchangeOpenNodes(MPMCore *);
PetscErrorCode MPMExchangeCloseNodes(MPMCore *);

/* The same, and the fields of particles that the phase declares. Not collective. */
PetscErrorCode MPMExchangeOpen(MPMCore *, const MPMPhase *);
PetscErrorCode MPMExchangeClose(MPMCore *, const MPMPhase *);

/* Runs a transfer on the particles here: of particles to nodes, on the tiles of a pass. Not collective. */
PetscErrorCode MPMExchangeRun(MPMCore *, const MPMPhase *, MPMPass);

/* Puts the particles here, whose cells are known, in order. Not collective. */
PetscErrorCode MPMExchangeSort(MPMCore *);

/* Runs a phase on a patch whose views hold the fields that the phase declares; merges what it finds into the status.
   Not collective. */
PetscErrorCode MPMPatchRun(MPMCore *, MPMPatch *, const MPMPhase *, MPMPass, MPMStatus *);

/* The beginning and the end of a phase for its timer; n: particles that it worked on here. Not collective. */
PetscErrorCode MPMPhaseBegin(MPMCore *, const MPMPhase *);
PetscErrorCode MPMPhaseEnd(MPMCore *, const MPMPhase *, PetscInt n);

#endif
