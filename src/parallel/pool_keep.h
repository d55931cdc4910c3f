/* pool_keep.h - what the master (pool_keep.c) and the workers (pool_resident.c) share where workers keep the particles
   (-pool_particles workers): the messages of a transfer.

   master -> worker   MPMKeepJob; the owners of all tiles, if they are new; the rows of the particles that come; from nodes
                      to particles the motion of the nodes that the worker's particles read
   worker -> master   MPMKeepAnswer; then the tiles that have particles, the sums of those at borders, and the sums of the
                      nodes that tiles of no other worker touch; or the rows of the particles that leave; or rows of what
                      was asked for */
#ifndef MPM_POOL_KEEP_H
#define MPM_POOL_KEEP_H

#include "parallel/exchange.h"

enum { MPM_TAG_JOB = 1, MPM_TAG_ANSWER };
enum { MPM_KEEP_OVER = -1, MPM_KEEP_BRING = -2 }; /* jobs that are no phases */

/* The head of a job. */
typedef struct {
  PetscInt  phase;          /* row of the table of phases, or one of the jobs above */
  PetscInt  fields;         /* bits: those of the rows that come, or that are asked for */
  PetscInt  settle, n;      /* the last step is settled first: leavers go, and these n particles come */
  PetscInt  owners;         /* the owners of tiles follow */
  PetscInt  ends;           /* MPM_KEEP_BRING: the worker's particles are no longer its own */
  PetscInt  ranges;         /* ranges of nodes */
  PetscInt  nodes;          /* nodes in them */
  PetscReal dt, kick, flip, push; /* s, s; share of FLIP; of the relaxation of volumes */
} MPMKeepJob;

/* A range of nodes in a row of the patch's arrays: the first, and how many. */
typedef struct {
  PetscInt first, n;
} MPMKeepRange;

/* A tile with particles: its number, and how many. */
typedef struct {
  PetscInt tile, n;
} MPMKeepTile;

/* The head of an answer. */
typedef struct {
  MPMStatus status;
  PetscInt  n, tiles, ranges; /* particles, tiles, ranges of nodes that follow */
} MPMKeepAnswer;

/* What both have in exchange.pool; the master has more (pool_keep.c). */
typedef struct {
  const MPMExchangeType
             *inner; /* serial, or spatial if a face is periodic: makes the grid, on each process all of it */
  MPI_Comm    comm;
  PetscMPIInt size, rank;
  PetscInt    ntiles, *owner; /* [ntiles] process that keeps the particles of a tile */
  char       *border;         /* [ntiles] does a tile of another owner touch some of its nodes? */
  PetscInt   *whose;          /* [nodes of the arrays] the owner of all tiles that touch a node; 0: they have several */
} MPMKeepBase;

/* The master's memory for a worker. */
typedef struct {
  PetscInt           *list, n, capacity; /* [n] rows of the particles that it is to get */
  PetscInt            particles;         /* that it has in its tiles */
  PetscInt           *span;              /* [rows of nodes][2] first and last+1 of the nodes that its particles read */
  char               *out, *in;          /* the job, and the answer */
  size_t              out_capacity;      /* bytes */
  size_t              in_capacity;
  MPI_Request         sent;
  PetscInt            nranges; /* of its answer: the nodes whose sums are complete, and these */
  const MPMKeepRange *range;
  const PetscReal    *sums;
} MPMKeepWorker;

typedef struct {
  MPMKeepBase    base;
  PetscInt       nsequence, *sequence; /* [nsequence] the patch's own tiles in the sequence that is cut */
  PetscInt      *count;                /* [ntiles] particles in a tile */
  PetscInt      *row;                  /* [born] the row of a particle here, by its id */
  PetscInt64     ids;                  /* fingerprint of the particles */
  MPMKeepWorker *worker;               /* [size]; that of process 0 is not used */
  PetscBool      settle;               /* the last step has to be settled by the workers */
  PetscInt       most;                 /* particles of the worker that has most of them */
  PetscReal      lost, imbalance;      /* particle steps that imbalance has cost; largest share over mean after a cut */
} MPMKeep;

/* Chooses the owners, and gives them their particles (pool_owners.c). Of the master alone. */
PetscErrorCode MPMKeepSequence(MPMCore *, MPMKeep *);                 /* of tiles; once */
PetscErrorCode MPMKeepHandOut(MPMCore *, MPMKeep *, PetscBool *anew); /* all particles, with the next jobs */
PetscErrorCode MPMKeepRecut(MPMCore *, MPMKeep *, PetscBool *anew);   /* if the numbers are unequal */
PetscErrorCode MPMKeepFindSpans(MPMCore *, MPMKeep *);                /* after `count` or owners changed */
PetscErrorCode MPMKeepGives(MPMKeepWorker *, PetscInt row);           /* a particle, with the next job */

/* Finds which tiles and nodes lie between owners, when these are new. */
void MPMKeepFindBorders(MPMCore *, MPMKeepBase *);

/* Messages of sums (pool_sums.c): Ranges, Tiles and PackSums of a worker, TakeSums and TakeNodes of the master. */
void           MPMKeepRanges(const MPMCore *, PetscInt *ranges, PetscInt *nodes, MPMKeepRange *list);
PetscInt       MPMKeepTiles(const MPMCore *, MPMKeepTile *list);
PetscErrorCode MPMKeepPackSums(MPMCore *, const MPMPhase *, MPMKeepAnswer *, char *begin, char **m);
PetscErrorCode MPMKeepTakeSums(MPMCore *, MPMKeep *, const MPMPhase *, PetscMPIInt from, const MPMKeepAnswer *,
                               PetscInt64 *n);
PetscErrorCode MPMKeepTakeNodes(MPMCore *, MPMKeep *, const MPMPhase *);

/* Returns the fields (bits) of particles that change their worker. */
PetscInt MPMKeepFields(const MPMParticles *, PetscBool scratch);

/* Packs these fields (bits) of n particles, the listed ones or the first (list NULL), field by field, and moves *message
   on to the end; or unpacks them. Rows are those of this process, lent or not. Not collective. */
PetscErrorCode MPMKeepRows(MPMParticles *, PetscInt fields, PetscInt n, const PetscInt *list, PetscBool pack,
                           char **message);

/* Returns the message's next place that is a multiple of 8 bytes from its begin. */
MPM_INLINE char *MPMKeepAlign(char *begin, char *message)
{
  return begin + (size_t)(message - begin + 7) / 8 * 8;
}

/* What a worker does until the run ends. */
PetscErrorCode MPMKeepServe(MPMCore *);

extern const MPMExchangeType MPMExchange_keep; /* -pool_particles workers */

#endif
