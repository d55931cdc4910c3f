/* calibrate.h - what the files of the calibration share (calibrate.c says what it is).

   `scene` is the run that the options describe, with its phases but without particles. The functions that run it make
   runs of their own, of the option database with a few values replaced. Each keeps the least of what it measures now
   and has measured before, where 0 means never. */
#ifndef CALIBRATE_H
#define CALIBRATE_H

#include "run/mpm.h"

/* --- Short runs, which each process makes for itself (runs.c) ----------------------------------------------------- */

#define LEVELS (MPM_RATE_SIZES + 1)
typedef struct {
  PetscReal seconds[MPM_MAX_TIMERS]; /* s per step by timer, the least of all runs */
  PetscReal fastest, slowest;        /* s per step of the fastest and the slowest run */
  PetscReal particles, nodes;
  PetscInt  steps;
} ShortRuns;

/* Least keeps the lesser value of now and before. Slowest sets the largest value of all processes; collective. */
void           Least(PetscReal *least, PetscReal now);
PetscErrorCode Slowest(MPI_Comm, PetscReal *seconds);

/* runs.c describes these functions. */
PetscErrorCode SetNumber(const char name[], const char format[], double value);
PetscErrorCode SetRun(MPM scene, const char strategy[], PetscReal coarser, PetscInt nsteps);
PetscErrorCode MakeRun(MPI_Comm, MPM *);
PetscErrorCode RunAlone(MPM scene, PetscReal n, PetscInt nsteps, PetscInt nrepeats, ShortRuns *);
void           FitRate(const MPMCore *, PetscInt timer, const ShortRuns[LEVELS], MPMRate *);

/* --- Messages (messages.c) ---------------------------------------------------------------------------------------- */

typedef struct {
  PetscReal one, longer; /* s per message of 8 B, and of 64 KiB */
  PetscReal burst[2];    /* s per exchange of one short message each way, and of several */
  PetscReal reduction;   /* s per reduction of a status */
} MessageTimes;

/* messages.c describes these functions; TimeMessages is collective. */
PetscErrorCode TimeMessages(MPI_Comm, MessageTimes *);
void           FitMessages(PetscMPIInt size, const MessageTimes *, MPMModel *);
PetscErrorCode TimeCopy(PetscReal *least);
PetscErrorCode TimeKept(MPM scene, PetscReal *least);

/* --- Migrations of about n particles per process (migration.c) --------------------------------------------------- */

enum { SWARM, DIRECT, SWAP, WAYS }; /* SWARM and DIRECT move no particle; SWAP moves some by direct messages */
typedef struct {
  PetscReal particles, axes, migration[WAYS]; /* s; particles 0: the scene cannot be cut like that */
} MigrationTimes;

/* migration.c describes these functions; TimeMigration is collective on scene->core.comm. */
PetscErrorCode TimeMigration(MPM scene, PetscReal n, MigrationTimes *);
void           FitMigration(PetscMPIInt size, const MigrationTimes *few, const MigrationTimes *many, MPMModel *);

/* --- Whole steps (steps.c) ---------------------------------------------------------------------------------------- */

/* Steps of about 600 particles per process, or of more if the grid cannot be cut otherwise, on all processes together
   and without migrations. The model predicts them several times during the run. */
typedef struct {
  PetscReal step;      /* s, the least of all runs */
  PetscReal predicted; /* s, without what an exchange costs besides its messages */
  PetscReal exchanges; /* per step, of the process that has most of them; 0: the grid cannot be cut */
} TogetherTimes;

/* steps.c describes these functions. */
PetscErrorCode TimeTogether(MPM scene, TogetherTimes *);
PetscErrorCode TimeItself(MPM scene, MPI_Comm, PetscReal *least);
PetscErrorCode CheckItself(MPM scene, MPI_Comm, PetscReal least);

/* --- The pool (pool.c) -------------------------------------------------------------------------------------------- */

/* A step of the pool: the least time, s, that its master is busy, and its numbers of jobs and bytes. */
typedef struct {
  PetscReal busy, jobs, bytes;
} MasterTimes;

/* pool.c describes these functions; TimePool is collective on scene->core.comm. */
PetscErrorCode TimePool(MPM scene, PetscInt cells, MasterTimes *);
void           FitPool(const MasterTimes *, const MasterTimes *, MPMModel *);

/* Returns a constant that is a difference of times, or 0 if other work made it negative, which is then said at the end. */
PetscReal Difference(const char name[], PetscReal);

#endif
