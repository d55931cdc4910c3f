/* cost.h - what a step costs, predicted (docs/performance.md derives the model), and what a run used of the machine. */
#ifndef MPM_COST_H
#define MPM_COST_H

#include "step/step.h"

/* The time of n particles or nodes: call + n each, where each is each[k] at size[k] and goes from one to the next by
   the logarithm of n, as caches overflow. */
#define MPM_RATE_SIZES 3
typedef struct {
  PetscReal call, size[MPM_RATE_SIZES], each[MPM_RATE_SIZES]; /* s, 1, s */
} MPMRate;

/* A migration takes call + stage s + process P + particle n + leaver q seconds for n particles here, of which q leave
   and as many come, and P processes; s is log2(P) for DMSwarmMigrate, and the number of axes that are cut here for
   direct messages. */
typedef struct {
  PetscReal call, stage, process, particle, leaver;
} MPMMigration;

typedef struct {
  MPMRate      rate[MPM_MAX_TIMERS];   /* by timer; all passes of a step together */
  PetscReal    exchange, message;      /* s an exchange with the neighbours, and a message on its way */
  PetscReal    post;                   /* s that a message takes of the processors at its ends */
  PetscReal    wire, copy;             /* s a byte: on its way, packed and unpacked */
  PetscReal    kept;                   /* s a byte of tiles' sums that are sent: zeroed, packed, unpacked */
  PetscReal    reduction;              /* s of the step's reduction for each doubling of the processes */
  MPMMigration migration[2];           /* swarm, direct */
  PetscReal    job, pool;              /* s a patch of the pool, s a byte of it, on either side */
  PetscReal    flop, byte;             /* s that a core takes at best for an operation, a byte of memory; 0: unknown */
  char         from[2 * MPM_NAME_LEN]; /* where the constants come from */
} MPMModel;

typedef struct {
  MPMModel  model;
  char      file[2 * MPM_TEXT_LEN], note[MPM_TEXT_LEN]; /* -model_file; why it is not used */
  PetscReal predicted[MPM_MAX_TIMERS];                  /* s a step, by the model */
  PetscReal messages[MPM_MAX_TIMERS];                   /* with -report_path: of these the messages */
} MPMCost;

/* --- Constants (model_file.c) ------------------------------------------------------------------------------------- */

PetscErrorCode MPMModelSetFromOptions(MPMCost *, MPMOptions);
PetscErrorCode MPMModelSetUp(MPMCost *, const MPMCore *, const MPMScene *, const char dir[]);
PetscErrorCode MPMModelSave(const MPMCost *, const MPMCore *, const MPMScene *);
PetscBool      MPMModelIsFile(const char path[]);
PetscBool      MPMModelReadLine(const MPMTimers *, const char line[], MPMModel *, int *found);
void           MPMModelMethod(const MPMCore *, const MPMScene *, char text[], size_t len);

/* --- Predictions (model.c); dt: of the next step, s ----------------------------------------------------------------
   */

void           MPMModelRough(MPMModel *, const MPMCore *, const MPMScene *);
PetscReal      MPMModelTimer(const MPMModel *, const MPMCore *, PetscInt timer, const MPMShare *);
PetscReal      MPMModelStep(const MPMModel *, const MPMCore *, const MPMShare *);
PetscReal      MPMModelPoolBytes(const MPMCore *, PetscInt timer, const MPMShare *, PetscInt edge, PetscReal *jobs);
PetscReal      MPMModelPoolStep(const MPMModel *, const MPMCore *, const MPMShare *, PetscInt edge, PetscReal *bound);
PetscInt       MPMModelPoolEdge(const MPMModel *, const MPMCore *, const MPMShare *);
void           MPMModelCosts(const MPMModel *, const MPMCore *, PetscReal particles, MPMCosts *);
PetscErrorCode MPMModelShare(MPMCore *, PetscReal dt, MPMShare *); /* of this process as it is */
PetscErrorCode MPMModelPredict(MPMCost *, MPMCore *, PetscReal dt);

/* Prints what the model says of other numbers of processes (model_view.c), the critical path of -report_path (path.c),
   and the line `speed` (roofline.c); limits: measure those of the machine for it. */
MPMShare  MPMModelCube(const MPMCore *, PetscReal n, PetscReal per_cell, PetscReal processes, PetscReal moved);
PetscReal MPMModelLeast(const MPMModel *, const MPMCore *, PetscReal per_cell, PetscReal processes, PetscReal moved,
                        PetscReal efficiency);
PetscErrorCode MPMModelView(const MPMCost *, MPMCore *, const MPMScene *, PetscReal dt);
PetscErrorCode MPMWorkView(const MPMCost *, MPMCore *);
PetscErrorCode MPMRoofline(const MPMCost *, MPMCore *, PetscBool limits);
PetscErrorCode MPMLimits(MPI_Comm, PetscReal *flop, PetscReal *byte);

#endif
