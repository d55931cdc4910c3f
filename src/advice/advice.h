/* advice.h - what a run tells its user: notes and warnings on a valid scene and its method, what the run will take,
   what it found, and its progress. watch.h has what is watched while it runs. The functions get what they read of a
   run; none changes its state. */
#ifndef MPM_ADVICE_H
#define MPM_ADVICE_H

#include "advice/watch.h"
#include "cost/cost.h"

/* What the printing functions keep between calls. */
typedef struct {
  PetscLogDouble start, line; /* when the run and the last line of progress began, s */
  PetscLogDouble steps;       /* s of steps at the last look at what the run will take; */
  PetscInt       step;        /* the step then; 0: not looked yet */
  PetscReal      t;           /* the time then, s, of implicit steps; that at the start of the run */
  PetscReal      told;        /* s that the run will take, as it was told last */
  PetscReal      base;        /* memory of this process before the scene, bytes; 0 where the system does not tell */
  PetscBool      indicator;   /* -report_indicator */
  PetscBool      limits;      /* -report_limits: are the limits of a core measured for the line `speed`? */
  PetscBool      no_limits;   /* -report_limits false: they are not, however long the run takes */
  PetscBool      phases;      /* -report_phases: is the table of phases printed, however short the run is? */
  PetscBool      no_phases;   /* -report_phases false: it is not, however long it is */
  PetscBool      processes;   /* -report_processes: does a dry run predict other numbers of processes? */
} MPMReport;

/* What is predicted of a run before its first step. */
typedef struct {
  PetscReal left;      /* s of simulated time until the end */
  PetscReal dt, steps; /* s: of the first step; steps until the end, if all are as long and output is at exact times */
  PetscReal step;      /* s that a step takes by the model */
} MPMForecast;
MPMForecast MPMForecastOf(const MPMCore *, const MPMTime *, const MPMMonitor *, const MPMOutput *, const MPMCost *);

/* --- Notes and warnings ------------------------------------------------------------------------------------------- */

/* Prints notes on the options, before anything else of a run or a calibration (notes.c). Collective on core.comm. */
PetscErrorCode MPMNotes(const MPMCore *, const MPMScene *, const MPMMonitor *, const MPMOutput *, const MPMReport *);

/* Tell what is doubtful in a valid scene: refuse it in the options, before anything is made, or note odd values
   (doubts.c); warn of where matter is at the start, and what walls will do (doubts_start.c); warn of the rest
   (doubts.c). restarted: the run goes on, so particles are not where they started. Not collective, but for the third,
   on exchange.data. */
PetscErrorCode MPMDoubtsRefuse(const MPMCore *, const MPMScene *, const MPMTime *, MPMOptions);
PetscErrorCode MPMDoubtsNote(const MPMCore *, const MPMScene *);
PetscErrorCode MPMDoubtsStart(MPMCore *, const MPMScene *, const MPMTime *, PetscBool restarted);
PetscErrorCode MPMDoubtsWarn(const MPMCore *, const MPMScene *, const MPMMethod *, const MPMTime *,
                             const MPMForecast *);

/* Notes values that are hardly meant (unlikely.c). Collective on exchange.data. */
PetscErrorCode MPMUnlikelyNote(MPMCore *, const MPMScene *, const MPMTime *, const MPMMonitor *, const MPMForecast *);

/* Prints what makes a method doubtful in this scene, with steps of dt, s, and what to use instead (method_warnings.c).
   Collective on exchange.data. */
PetscErrorCode MPMMethodWarnings(MPMCore *, const MPMScene *, const MPMMethod *, const MPMTime *, PetscReal dt);

/* Returns the option of quadratic splines (method_warnings.c). Not collective. */
const char *MPMMethodSpline(void);

/* --- What a run will take ----------------------------------------------------------------------------------------- */

/* Return the memory of this process in bytes, "VmRSS", or the most that it had, "VmHWM"; print the largest that a run
   of so many seconds will need, with snapshots or without (memory.c). The second is collective on exchange.data. */
PetscReal      MPMMemoryHere(const char what[]);
PetscErrorCode MPMMemoryPrint(const MPMCore *, const MPMReport *, const MPMCost *, PetscBool snapshots,
                              PetscReal seconds);

/* Prints with -dry_run how large the files of the run will be, of which `kept` checkpoints are there at a time, and
   warns if their disk has less room (disk.c). Not collective. */
PetscErrorCode MPMDiskPrint(const MPMCore *, const MPMMonitor *, const MPMOutput *, const MPMForecast *, PetscReal kept,
                            PetscBool dry);

/* --- Lines of a run (report*.c); run/prints.c has their sequence -------------------------------------------------- */

/* Before the first step: grid and particles; bodies; fields and memory; the method; how the work is divided; the
   predicted time; what each load acts on at the start, and the sum of the sizes of its forces when it is largest until
   `end`, s, as it acts on the particles at their start. Not collective, but for bodies, parallel and loads: on
   exchange.data. */
PetscErrorCode MPMReportScene(const MPMCore *, const MPMScene *);
PetscErrorCode MPMReportBodies(MPMCore *, const MPMScene *);
PetscErrorCode MPMReportFields(const MPMCore *);
PetscErrorCode MPMReportMethod(const MPMCore *, const MPMScene *, const MPMMethod *);
PetscErrorCode MPMReportParallel(MPMCore *);
PetscErrorCode MPMReportPrediction(const MPMCore *, const MPMCost *, const MPMForecast *);
PetscErrorCode MPMReportLoads(MPMCore *, const MPMScene *, PetscReal end);

/* Prints how long the run will take by the steps that it has made: after a tenth of a second of steps, and where that has
   changed each time that the run has lasted twice as long (progress.c). Implicit steps say so from the first one on. Not collective. */
PetscErrorCode MPMReportForecast(MPMReport *, const MPMCore *, const MPMTime *, const MPMMonitor *, const MPMOutput *,
                                 const MPMCost *);

/* Prints a line of progress over the one before, at most once a second, if standard output is a terminal (progress.c).
   Not collective. */
PetscErrorCode MPMReportProgress(MPMReport *, MPMCore *, const MPMTime *);

/* Looks after some steps whether the bodies are at rest, and says so at the end of a run (rest.c). Collective on
   exchange.data. */
PetscErrorCode MPMRestLook(MPMCore *, const MPMScene *);
PetscErrorCode MPMRestTell(MPMCore *, const MPMScene *, const MPMTotals *, const MPMTime *);

/* At the end: energies, and whether they or the steps are doubtful; how far the stress is from what nodes and particles
   agree on, unless all of it is rounding; rigid bodies that met nothing and probes that showed nothing in a whole run; the error,
   if a solution is known; the files that are there; how the grid was cut anew and particles changed process; the times
   of the phases, if the steps took long or an option asks for them.
   Not collective, but for indicator and known: on exchange.data. */
PetscErrorCode MPMReportEnergy(const MPMCore *, const MPMScene *, const MPMMethod *, const MPMMonitor *,
                               const MPMWatch *);
PetscErrorCode MPMReportIndicator(MPMCore *, const MPMScene *);
PetscErrorCode MPMReportMet(const MPMCore *, const MPMMeasures *);
PetscErrorCode MPMReportKnown(MPMCore *, const MPMScene *);
PetscErrorCode MPMReportResults(const MPMCore *, const MPMScene *, const MPMOutput *);
PetscErrorCode MPMReportExchange(const MPMCore *);
PetscErrorCode MPMReportPhases(const MPMCore *, const MPMCost *, const MPMReport *);

#endif
