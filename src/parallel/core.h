/* core.h - what a step works on: grid, particles, the phases of the step, and how processes share the work.

   MPMCore is all that the rooms of the step know of a run. Scene, output, costs and studies are added above it (MPM in
   run/mpm.h). */
#ifndef MPM_CORE_H
#define MPM_CORE_H

#include "base/print.h"
#include "base/timers.h"
#include "parallel/partition.h"
#include "particles/box.h"
#include "particles/particles.h"

/* A phase of the step: a row of constants that is documentation and contract at once. Kernels get NULL for fields of
   particles that the row does not declare; an exchange sends just the declared ones. */
typedef enum { MPM_PARTICLES_TO_NODES, MPM_NODES, MPM_NODES_TO_PARTICLES } MPMPhaseKind;
typedef struct {
  const char  *name;
  MPMPhaseKind kind;
  PetscInt     parts;                                         /* of the transfer; for MPM_NODES unused */
  void (*nodes)(const MPMParams *, MPMPatch *, PetscInt row); /* for MPM_NODES: one row of nodes */
  PetscInt flops;                                             /* of these, a node and axis */
  PetscInt particles_in, particles_out;                       /* bits of fields */
  PetscInt timer;                                             /* set by MPMStepSetUp */
} MPMPhase;

#define MPM_MAX_ORDER   16 /* of xpic */
#define MPM_MAX_PHASES  24 /* in the table */
#define MPM_MAX_PROGRAM (8 + 3 * MPM_MAX_ORDER)

typedef struct _MPMCore MPMCore;

/* A way to run the step. Physics, update schemes and output are the same for all; only these functions differ. All but
   the last four are collective on the processes of exchange.data. */
typedef struct {
  const char *name, *what;
  /* Cuts the grid and makes DMs and patch; then the scene adds particles. h: where these will be, finished; needed
     where `cuts` says so. */
  PetscErrorCode (*setup)(MPMCore *, const MPMHistogram *h);
  PetscErrorCode (*sweep)(MPMCore *, const MPMPhase *); /* run a transfer on all patches */
  PetscErrorCode (*nodes)(MPMCore *, const MPMPhase *); /* run a node phase; its values are known where they are read */
  PetscErrorCode (*reduce)(MPMCore *, MPMStatus *);     /* merge the status of all: the one reduction of a step */
  PetscErrorCode (*settle)(MPMCore *, PetscBool anew);  /* bring particles home and in order; anew: no cell is known */
  PetscErrorCode (*finish)(MPMCore *);
  PetscBool cuts;                                 /* does it cut the grid by a histogram? */
  PetscBool farms;                                /* the work on particles is done by others */
  PetscErrorCode (*serve)(MPMCore *);             /* what a process without data does, until the run ends */
  PetscErrorCode (*share)(MPMCore *, MPMShare *); /* ghosts, neighbours of this process; NULL: none */
} MPMExchangeType;

typedef struct {
  const MPMExchangeType *type;
  MPI_Comm               data; /* the processes that hold particles and grid; all DMs and files live on it */
  MPMPatch               patch;
  DM                     da;         /* the nodes of the grid, with their motion */
  DM                     sums;       /* the same nodes, with their sums */
  Vec                    motion;     /* local vector behind patch.motion */
  Vec                    node_sums;  /* and that behind patch.node */
  MPMBalance             balance;    /* -parallel_balance */
  PetscBool              direct;     /* -parallel_migrate direct */
  PetscBool              roundoff;   /* -parallel_sums roundoff */
  PetscBool              ready;      /* is set up */
  PetscInt               pool_cells; /* -pool_cells, as whole tiles */
  void                  *pool;       /* of the pool: its master uses the rest as a run on one process does */
  MPMPartition           partition;
  PetscInt               recuts;     /* how often the grid was cut anew */
  PetscInt               migrations; /* steps in which particles changed process */
  PetscInt64             migrants;   /* how many did, in all */
  PetscReal busy, jobs, bytes; /* of the pool's master: s not spent waiting, patches handed out, bytes both ways */
  void     *ctx;
} MPMExchange;

struct _MPMCore {
  MPI_Comm        comm;
  MPMPrinter      print;
  MPMGrid         grid;
  MPMBasis        basis;
  MPMNeeds        needs;
  MPMParams       params;
  MPMPhase        phases[MPM_MAX_PHASES]; /* [nphases] the table of phases as this scene needs it */
  PetscInt        nphases;
  const MPMPhase *program[MPM_MAX_PROGRAM]; /* [nprogram] the phases of a step, in order */
  PetscInt        nprogram;
  MPMExchange     exchange;
  MPMParticles    particles;
  MPMStatus       status; /* of the last step */
  MPMTimers       timers;
  PetscReal       t; /* s */
  PetscInt        step;
  char            stop[MPM_TEXT_LEN]; /* why the run has to stop early; empty: it need not */
};

#endif
