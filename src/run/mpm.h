/* mpm.h - a run: everything that belongs to it, and its life.

     MPMCreate  MPMSetFromOptions  MPMSetUp  MPMRun  MPMDestroy

   Nothing in src keeps state from one run to the next outside of an MPM: a study makes many. Units are SI in all names;
   any consistent set works. docs/developer.md shows the rooms of src and the way through them. */
#ifndef MPM_MPM_H
#define MPM_MPM_H

#include "cost/cost.h"
#include "output/output.h"

/* A ladder of runs; see study.c. */
typedef struct {
  char      type[MPM_NAME_LEN], vary[MPM_NAME_LEN]; /* type "": none */
  PetscInt  levels;
  PetscReal order_min; /* < 0: any */
} MPMStudy;

/* What the report keeps from line to line. */
typedef struct {
  PetscLogDouble start, line; /* when the run and the last line of progress began, s */
  PetscBool      limits;      /* -report_limits: measure those of the machine for the line `speed` */
  PetscBool      progress;    /* a line of progress stands on the terminal */
} MPMReport;

typedef struct _p_MPM *MPM;
struct _p_MPM {
  MPMCore    core;
  MPMScene   scene;
  MPMMethod  method;
  MPMTime    time;
  MPMMonitor monitor;
  MPMOutput  output;
  MPMCost    cost;
  MPMStudy   study;
  MPMReport  report;
  PetscReal  courant; /* the largest dt (c + |v|)/h of the run */
};

extern const MPMVocabulary MPMOptionTable; /* options.def, with the values that other tables have (vocabulary.c) */

/* Collective on comm, which is that of the run from then on. */
PetscErrorCode MPMCreate(MPI_Comm, MPM *);
PetscErrorCode MPMSetFromOptions(MPM, MPMOptions);
PetscErrorCode
    MPMSetPhases(MPM); /* the phases of a step and the constants of the cost model: the first half of SetUp */
PetscErrorCode MPMSetUp(MPM);
PetscErrorCode MPMRun(MPM);
PetscErrorCode MPMDestroy(MPM *);

/* -method_*, -time_* and -dt_* (method.c). */
PetscErrorCode MPMMethodSetFromOptions(MPM, MPMOptions);

/* What is printed (report.c, notes.c). Collective on comm. */
PetscErrorCode MPMNotes(MPM);
PetscErrorCode MPMReportStart(MPM);
PetscErrorCode MPMReportProgress(MPM);
PetscErrorCode MPMReportEnd(MPM);

/* Studies (study.c). Collective on comm. */
PetscErrorCode MPMStudySetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMStudyRun(MPM, int *status);

#endif
