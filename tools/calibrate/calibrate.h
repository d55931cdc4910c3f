/* calibrate.h - what the files of the calibration share (calibrate.c says what it is).

   `scene` is the run that the options describe, with its phases but without particles. The functions that run it make
   runs of their own, of the option database with a few values replaced. Each keeps the least of what it measures now
   and has measured before, where 0 means never. */
#ifndef CALIBRATE_H
#define CALIBRATE_H

#include "run/mpm.h"

/* --- Short runs of about so many particles, on each process alone (runs.c) --------------------------------------- */

#define LEVELS (MPM_RATE_SIZES + 1)
typedef struct {
  PetscReal seconds[MPM_MAX_TIMERS]; /* s a step of each timer, at the least */
  PetscReal fastest, slowest;        /* s a step of the runs */
  PetscReal particles, nodes;
  PetscInt  steps;
} ShortRuns;

/* Keeps the lesser one of what was measured now and before; the largest of all processes. */
void           Least(PetscReal *least, PetscReal now);
PetscErrorCode Slowest(MPI_Comm, PetscReal *seconds);

PetscErrorCode SetNumber(const char name[], const char format[], double value);
PetscErrorCode SetRun(MPM scene, const char strategy[], PetscReal coarser, PetscInt nsteps);
PetscErrorCode MakeRun(MPI_Comm, MPM *);
PetscErrorCode RunAlone(MPM scene, PetscReal n, PetscInt nsteps, PetscInt nrepeats, ShortRuns *);
void           FitRate(const MPMCore *, PetscInt timer, const ShortRuns[LEVELS], MPMRate *);

/* --- Messages (messages.c) --------------------------------------------------------------------------------------- */

typedef struct {
  PetscReal one, longer; /* s a message of 8 B, and of 64 KiB */
  PetscReal burst[2];    /* s an exchange of one message each way, and of several */
  PetscReal reduction;   /* s */
} MessageTimes;

PetscErrorCode TimeMessages(MPI_Comm, MessageTimes *);
void           FitMessages(PetscMPIInt size, const MessageTimes *, MPMModel *);
PetscErrorCode TimeCopy(PetscReal *least);
PetscErrorCode TimeKept(MPM scene, PetscReal *least);

/* --- Migrations of about n particles a process (migration.c) ----------------------------------------------------- */

enum { SWARM, DIRECT, SWAP, WAYS }; /* the first two move no particle, the last moves some directly */
typedef struct {
  PetscReal particles, axes, migration[WAYS]; /* s; particles 0: the scene cannot be cut like that */
} MigrationTimes;

PetscErrorCode TimeMigration(MPM scene, PetscReal n, MigrationTimes *);
void           FitMigration(PetscMPIInt size, const MigrationTimes *few, const MigrationTimes *many, MPMModel *);

/* --- Whole steps (steps.c) --------------------------------------------------------------------------------------- */

/* Steps of about 600 particles on each process, or of as many more as have a cut, together, without their migrations.
   The model is asked between spans of the run. */
typedef struct {
  PetscReal step;      /* s, the least */
  PetscReal predicted; /* s, without what an exchange costs besides its messages */
  PetscReal exchanges; /* of the process that has most of them; 0: there is no such cut */
} TogetherTimes;

PetscErrorCode TimeTogether(MPM scene, TogetherTimes *);
PetscErrorCode TimeItself(MPM scene, MPI_Comm, PetscReal *least);
PetscErrorCode CheckItself(MPM scene, MPI_Comm, PetscReal least);

/* --- The pool (pool.c) ------------------------------------------------------------------------------------------- */

/* A step of the pool: how long its master is busy at least, with how many jobs and bytes. */
typedef struct {
  PetscReal busy, jobs, bytes;
} MasterTimes;

PetscErrorCode TimePool(MPM scene, PetscInt cells, MasterTimes *);
void           FitPool(const MasterTimes *, const MasterTimes *, MPMModel *);

#endif
