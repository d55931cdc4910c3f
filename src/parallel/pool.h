/* pool.h - what the master (pool.c) and the workers (worker.c) of the pool share: the messages of a transfer.

   master -> worker   MPMJob, the particles' fields that the phase declares, then the node motion if the phase reads it
   worker -> master   MPMStatus, then the sums of the tiles that have particles, or the fields of the particles */
#ifndef MPM_POOL_H
#define MPM_POOL_H

#include "parallel/exchange.h"

enum { MPM_TAG_WORK = 1, MPM_TAG_DONE };

/* The head of a job: which patch it is for and which phase to run on it. */
typedef struct {
  PetscInt  phase;               /* row of the table of phases; < 0: the run is over */
  PetscInt  own_lo[3], own_n[3]; /* first and number of the patch's own nodes, or cells: whole tiles */
  PetscInt  tiles[3], first[3]; /* number of the master's tiles, over which cells are numbered; the patch's first one */
  PetscInt  n;                  /* particles that follow */
  PetscReal dt, kick, flip, push; /* s, s; share of FLIP; of the relaxation of volumes */
  PetscReal plane[6][2];          /* of pistons */
  PetscInt  places, place[MPM_MAX_COPIES], low[MPM_MAX_COPIES],
      high[MPM_MAX_COPIES]; /* of copies, as MPMGrid has them */
} MPMJob;

/* Returns whether a transfer reads the motion of nodes. */
MPM_INLINE PetscBool MPMPoolReads(const MPMPhase *phase)
{
  return phase->kind == MPM_NODES_TO_PARTICLES || phase->parts & MPM_P2G_NODES;
}

/* worker.c describes these functions. */
void           MPMPoolBox(MPMCore *, const PetscInt own_lo[3], const PetscInt own_n[3], MPMPatch *);
size_t         MPMPoolAnswerBytes(MPMCore *, const MPMPhase *, PetscInt n, PetscInt tiles);
char          *MPMPoolPack(const MPMParticles *, PetscInt fields, void *const at[], PetscInt n, const PetscInt *list,
                           char *message);
PetscErrorCode MPMPoolServe(MPMCore *, MPI_Comm);

#endif
