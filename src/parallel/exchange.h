/* exchange.h - the ways to run a step (serial, spatial, pool), and the functions that they share. */
#ifndef MPM_EXCHANGE_H
#define MPM_EXCHANGE_H

#include "options/options.h"
#include "parallel/core.h"

extern const MPMExchangeType *const MPMExchangeTypes[];                      /* rows of exchange.def, ends with NULL */
extern const MPMExchangeType        MPMExchange_serial, MPMExchange_spatial; /* the pool's master is one of them */

/* Chooses how the step is run. Collective on core->comm. */
PetscErrorCode MPMExchangeSetFromOptions(MPMCore *, MPMOptions);

/* Returns how many lines of the sums of a node (kernels/node.def) the program of a step makes. Not collective. */
PetscInt MPMExchangeLines(const MPMCore *);

/* Makes the DMs of the grid, which is cut into parts[axis] boxes of widths[axis][part] nodes (NULL: one process has all
   of it), and for the box of this process the patch and the vectors of its nodes. The second function destroys them.
   Collective on exchange.data. */
PetscErrorCode MPMExchangeCreateGrid(MPMCore *, const PetscInt parts[3], PetscInt *const widths[3]);
PetscErrorCode MPMExchangeDestroyGrid(MPMCore *);

/* Lets patch.node and patch.motion point into the vectors, and ends that access. Not collective. */
PetscErrorCode MPMExchangeOpenNodes(MPMCore *);
PetscErrorCode MPMExchangeCloseNodes(MPMCore *);

/* Runs an update of the nodes here, whose access is open, with what light nodes need of other processes. Collective on
   exchange.data. */
PetscErrorCode MPMExchangeNodes(MPMCore *, const MPMPhase *);

/* Do the same, and give the patch the fields of particles that the phase declares. Not collective. */
PetscErrorCode MPMExchangeOpen(MPMCore *, const MPMPhase *);
PetscErrorCode MPMExchangeClose(MPMCore *, const MPMPhase *);

/* Sends particles, whose cells are not known, to the processes that own them, before they are settled for the first
   time; where all are on one process, there is nothing to do. Collective on exchange.data. */
PetscErrorCode MPMExchangeDistribute(MPMCore *);

/* Adds the particles of a view, which has x, kind and l as far as there are such fields, to a histogram. Not
   collective. */
PetscErrorCode MPMHistogramAddView(MPMHistogram *, const MPMCore *, const MPMView *);

/* Runs a transfer on the particles here; from particles to nodes, only on the tiles of the pass. Not collective. */
PetscErrorCode MPMExchangeRun(MPMCore *, const MPMPhase *, MPMPass);

/* Sorts the particles here, whose cells are known, by (cell, id). Not collective. */
PetscErrorCode MPMExchangeSort(MPMCore *);

/* Removes the particles that left the grid (-particles_leave delete), after the reduction of the step that found them;
   *ids: the fingerprint of those here. The order has to be made anew. Collective on exchange.data. */
PetscErrorCode MPMExchangeRemove(MPMCore *, PetscInt64 *ids);

/* Runs a phase on a patch whose views hold the fields that the phase declares; from particles to nodes, only on the
   tiles of the pass. Merges what it finds into the status. Not collective. */
PetscErrorCode MPMPatchRun(MPMCore *, MPMPatch *, const MPMPhase *, MPMPass, MPMStatus *);

/* Counts the patches of so many cells an edge, whole tiles, that have particles here: what the master of a pool can
   hand out (pool.c). The particles have to be settled. Not collective. */
PetscErrorCode MPMPoolPatches(const MPMCore *, PetscInt cells, PetscInt *n);

/* Start and stop the timer of a phase, and count its operations and bytes. n: particles that it worked on here. Not
   collective. */
PetscErrorCode MPMPhaseBegin(MPMCore *, const MPMPhase *);
PetscErrorCode MPMPhaseEnd(MPMCore *, const MPMPhase *, PetscInt n);

/* Runs a phase of a step in the way of the exchange, with its timer. Collective on exchange.data. */
PetscErrorCode MPMPhaseRun(MPMCore *, const MPMPhase *);

#endif
