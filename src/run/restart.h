/* restart.h - checkpoints of a run and what goes on from them. */
#ifndef MPM_RESTART_H
#define MPM_RESTART_H

#include "results/checkpoint.h"
#include "run/mpm.h"

#define MPM_MAX_KEPT 64

/* Returns the path of the checkpoint of this number. Not collective. */
void MPMCheckpointPath(MPM, PetscInt number, char path[MPM_TEXT_LEN]);

/* Lists the numbers of the checkpoints of this scene in the folder of the results, the last first; the caller frees
   them. Collective on comm. */
PetscErrorCode MPMCheckpointList(MPM, MPI_Comm comm, PetscInt *n, PetscInt **numbers);

/* Set kept to what a checkpoint has beside the particles, and return how much that is: what is read before the scene is
   set up, and all the rest. Not collective. */
PetscInt MPMCheckpointHeader(MPM, MPMKept kept[]);
PetscInt MPMCheckpointKept(MPM, MPMKept kept[]);

/* Lists the names of the rows of totals: programs with other rows do not understand each other's. Not collective. */
void MPMCheckpointTotals(char text[MPM_TEXT_LEN]);

#endif
