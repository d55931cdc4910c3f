/* cost.h - the predicted cost of a step (docs/model.md has the model), and how much of the machine a run used. Before
   the first step the prediction is printed, and the partition of the grid is chosen by it. */
#ifndef MPM_COST_H
#define MPM_COST_H

#include "kernels/transfer.h"
#include "step/step.h"

/* Runs n rounds of fused multiply-adds in registers with vectors of so many lanes; returns how many operations these
   were. */
typedef PetscReal MPMChains(PetscInt n, PetscReal start, volatile PetscReal *end);
extern MPMChains  MPMChains_8, MPMChains_4, MPMChains_2;

/* The time that n particles or nodes take: call + n each. `each` depends on n, by the caches: it is each[k] at size[k],
   and linear in the logarithm of n between two sizes. */
#define MPM_RATE_SIZES 3
typedef struct {
  PetscReal call, size[MPM_RATE_SIZES], each[MPM_RATE_SIZES]; /* s, 1, s */
} MPMRate;

/* A migration takes call + particle n + leaver q seconds, for n particles here, of which q leave and as many arrive,
   and the time of its messages (MPMModelMigrationMessages). */
typedef struct {
  PetscReal call, particle, leaver;
} MPMMigration;

/* The collectives of a call of DMSwarmMigrate: 8 reductions, 3 gathers of a number from every process, 2 duplications
   of a communicator, and a barrier (docs/petsc.md counts them; PETSc 3.26 has one reduction more). In the gathers, and
   in two of the reductions while PETSc has at most MPM_SWARM_FEW processes, each process has a number of
   MPM_SWARM_NUMBER bytes. */
#define MPM_SWARM_COLLECTIVES 14
#define MPM_SWARM_GATHERS     3
#define MPM_SWARM_FLAGS       2
#define MPM_SWARM_FEW         1024
#define MPM_SWARM_NUMBER      4

/* The factor within which the predicted time of a run was right for nine of ten scenes, on a core that did nothing
   else: with rough constants, and with those of a calibration (docs/performance.md). */
#define MPM_WITHIN_ROUGH      2
#define MPM_WITHIN_CALIBRATED 1.3

/* The constants of the model. Those of contact (contact_cost.c) follow from the scene; a calibration has them in its
   rates. look is in s a particle; search and impulses are s a step: of all processes together, and of each one. */
typedef struct {
  MPMRate      rate[MPM_MAX_TIMERS];   /* by timer; all phases of a step that share it together */
  PetscReal    exchange, message;      /* s per exchange with the neighbours, and per message until it arrives */
  PetscReal    post;                   /* s per message of processor time at its two ends */
  PetscReal    wire, copy;             /* s per byte of a message: to transmit it, to pack and unpack it */
  PetscReal    kept;                   /* s per byte of tiles' sums that are sent: to zero, pack and unpack it */
  PetscReal    reduction;              /* s of the step's reduction for each doubling of the processes */
  MPMMigration migration[2];           /* swarm, direct */
  PetscReal    job, pool;              /* s per job of the pool and per byte of it, for the master as for the worker */
  PetscReal    flop, byte;             /* s that a core takes at best for an operation, a byte of memory; 0: unknown */
  PetscReal    look, search, impulses; /* of contact */
  PetscBool    measured;               /* are the rates those of a calibration? */
  PetscReal    within;                 /* the factor within which the time of a run is predicted (MPM_WITHIN_..) */
  char         from[2 * MPM_NAME_LEN]; /* where the constants come from */
} MPMModel;

/* The model of a run, and what it predicts. */
typedef struct {
  MPMModel  model;
  char      file[2 * MPM_TEXT_LEN];                     /* -model_file, else that of the run's name */
  char      used[2 * MPM_TEXT_LEN], note[MPM_TEXT_LEN]; /* what the constants were read from; why not from `file` */
  PetscReal predicted[MPM_MAX_TIMERS];                  /* s per step, by timer */
  PetscReal messages[MPM_MAX_TIMERS];                   /* with -report_path: the part of it for messages */
} MPMCost;

/* --- Constants (model_file.c) ------------------------------------------------------------------------------------- */

/* model_file.c describes these functions. */
PetscErrorCode MPMModelSetFromOptions(MPMCost *, MPMOptions);
PetscErrorCode MPMModelSetUp(MPMCost *, const MPMCore *, const MPMScene *, const char dir[]);
PetscErrorCode MPMModelSave(const MPMCost *, const MPMCore *, const MPMScene *);
PetscBool      MPMModelIsFile(const char path[]);
void           MPMModelMissed(MPMModel *, PetscReal ratio); /* a calibration was wrong by it: promises no less */
PetscBool      MPMModelReadLine(const MPMTimers *, const char line[], MPMModel *, int *found);
void           MPMModelMethod(const MPMCore *, const MPMScene *, char text[], size_t len);

/* --- Predictions (model.c); dt: of the next step, s --------------------------------------------------------------- */

/* MPMModelContact (contact_cost.c) sets look, search and impulses by where matter and rigid bodies are now; it is
   collective on exchange.data. model.c describes the others. */

void           MPMModelRough(MPMModel *, const MPMCore *, const MPMScene *);
PetscReal      MPMModelMigrationMessages(const MPMModel *, PetscBool direct, PetscReal axes, PetscReal processes);
PetscReal      MPMModelTimer(const MPMModel *, const MPMCore *, PetscInt timer, const MPMShare *);
PetscReal      MPMModelStep(const MPMModel *, const MPMCore *, const MPMShare *);
PetscReal      MPMModelPoolBytes(const MPMCore *, PetscInt timer, const MPMShare *, PetscInt edge, PetscReal *jobs);
PetscReal      MPMModelPoolStep(const MPMModel *, const MPMCore *, const MPMShare *, PetscInt edge, PetscReal *bound);
PetscInt       MPMModelPoolEdge(const MPMModel *, const MPMCore *, const MPMShare *);
void           MPMModelCosts(const MPMModel *, const MPMCore *, PetscReal particles, MPMCosts *);
PetscErrorCode MPMModelContact(MPMModel *, MPMCore *);
PetscErrorCode MPMModelShare(MPMCore *, PetscReal dt, MPMShare *);
PetscErrorCode MPMModelPredict(MPMCost *, MPMCore *, PetscReal dt);

/* The share of a process in a cut of a full body into cubes; the smallest number of particles per process that keeps an
   efficiency, 0: none up to 1e9 (model_view.c). */
MPMShare  MPMModelCube(const MPMCore *, PetscReal n, PetscReal per_cell, PetscReal processes, PetscReal moved);
PetscReal MPMModelLeast(const MPMModel *, const MPMCore *, PetscReal per_cell, PetscReal processes, PetscReal moved,
                        PetscReal efficiency);

/* Print what the model predicts of a run of so many steps of dt s, and if `sizes` for other numbers of processes
   (model_view.c), the critical path of -report_path (path.c), and the line `speed` (roofline.c), for which `limits`
   says that the limits of a core are measured, and `no_limits` that they are not, however long the run took. */
PetscErrorCode MPMModelView(const MPMCost *, MPMCore *, const MPMScene *, PetscReal dt, PetscReal steps,
                            PetscBool sizes);
PetscErrorCode MPMWorkView(const MPMCost *, MPMCore *);
PetscErrorCode MPMRoofline(const MPMCost *, MPMCore *, PetscBool limits, PetscBool no_limits);
PetscErrorCode MPMLimits(MPI_Comm, PetscReal *flop, PetscReal *byte);

#endif
