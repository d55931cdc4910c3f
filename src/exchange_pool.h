/* exchange_pool.h - what the master (exchange_pool.c) and the workers (pool_worker.c) share: the messages.

   master -> worker   MPMOrder, the points' fields that the phase declares, then for nodes-to-points the node motion
   worker -> master   MPMStatus, then the sums of the patch's own nodes, or the fields of its points */
#ifndef MPM_EXCHANGE_POOL_H
#define MPM_EXCHANGE_POOL_H

#include "mpm.h"

enum { MPM_TAG_WORK = 1, MPM_TAG_DONE };

/* What a patch is and what to do with it. */
typedef struct {
  PetscInt  phase;               /* of the table; < 0: the run is over */
  PetscInt  own_lo[3], own_n[3]; /* its nodes, and cells */
  PetscInt  all_lo[3], all_n[3]; /* the box of the master's arrays, for the numbers of cells */
  PetscInt  n;                   /* points that follow */
  PetscReal dt;
} MPMOrder;

void   MPMPoolBox(MPM, const PetscInt own_lo[3], const PetscInt own_n[3], PetscBool to_nodes, MPMPatch *);
size_t MPMPoolAnswerBytes(MPM, const MPMPhase *, const PetscInt own_n[3], PetscInt n);
char  *MPMPoolPack(const MPMPoints *, PetscInt fields, void *const at[], void *const halo[], PetscInt n, PetscInt count,
                   const PetscInt *list, char *message);
PetscErrorCode MPMPoolServe(MPM, MPI_Comm);

#endif
