/* mpm.h - a run: everything that belongs to it, and the functions that make it, in the sequence of their calls:

     MPMCreate  MPMSetFromOptions  MPMSetUp  MPMRun  MPMDestroy

   All data of a run are in its MPM, so that a program can make many runs. Comments give units in SI; any consistent set
   of units works. docs/developer.md describes the folders of src. */
#ifndef MPM_MPM_H
#define MPM_MPM_H

#include "cost/cost.h"
#include "restart/restart.h"
#include "run/watch.h"

/* What the printing functions keep between calls. */
typedef struct {
  PetscLogDouble start, line; /* when the run and the last line of progress began, s */
  PetscReal      base;        /* memory of this process before the scene, bytes; 0 where the system does not tell */
  PetscBool      indicator;   /* -report_indicator */
  PetscBool      limits;      /* -report_limits: are the limits of a core measured for the line `speed`? */
  PetscBool      no_limits;   /* -report_limits false: they are not, however long the run takes */
  PetscBool      phases;      /* -report_phases: is the table of phases printed, however short the run is? */
  PetscBool      no_phases;   /* -report_phases false: it is not, however long it is */
  PetscBool      processes;   /* -report_processes: does a dry run predict other numbers of processes? */
  PetscBool      progress;    /* is a line of progress on the terminal? */
} MPMReport;

/* What is done about a step that fails (advance.c). */
typedef struct {
  PetscBool on;     /* -check_state retry */
  PetscInt  most;   /* -dt_retry */
  PetscReal growth; /* -dt_max_growth */
  PetscReal limit;  /* s: the next step may be no longer, since one was undone not long ago; 0: there is no limit */
  PetscInt  undone; /* tries that were undone, and the steps that needed any */
  PetscInt  steps;
  PetscReal least;   /* s: the shortest of these steps */
  PetscBool gave_up; /* did a step fail for good? Then the state is that before it */
} MPMRetry;

/* Scenes for which a preset has a row: all materials are elastic, all are fluids, or any others. */
typedef enum { MPM_SCENES_elastic, MPM_SCENES_fluids, MPM_SCENES_others } MPMScenes;

/* A named method for such scenes; a row of preset.def. */
typedef struct {
  const char *name;
  MPMScenes   scenes;
  const char *basis;
  PetscBool   stretch;
  const char *update, *transfer;
  PetscReal   strain, rate, cfl;
  PetscInt    ppc;
} MPMPreset;

struct _p_MPM {
  MPMCore          core;
  MPMScene         scene;
  MPMMethod        method;
  const MPMPreset *preset;       /* what options of the method are that were not given */
  PetscBool        preset_given; /* -method_preset was */
  MPMTime          time;
  MPMMonitor       monitor;
  MPMOutput        output;
  MPMCost          cost;
  MPMReport        report;
  MPMWatch         watch;
  MPMRetry         retry;
  MPMCheckpoint    checkpoint;
  PetscReal        courant, wave; /* the largest dt (c + |v|)/h and dt c/h of the run */
};

extern const MPMVocabulary MPMOptionTable; /* options.def, with the values that other tables have (vocabulary.c) */

/* These functions are collective on the comm that MPMCreate gets; mpm.c describes them. */
PetscErrorCode MPMCreate(MPI_Comm, MPM *);
PetscErrorCode MPMReadOptions(MPM, MPMOptions);
PetscErrorCode MPMSetFromOptions(MPM, MPMOptions);
PetscErrorCode
    MPMSetPhases(MPM); /* sets the phases of a step and the constants of the cost model; MPMSetUp calls it first */
PetscErrorCode MPMSetUp(MPM);
PetscErrorCode MPMRun(MPM);
PetscErrorCode MPMDestroy(MPM *);

/* The main program (program.c): starts MPI and PETSc, lets `read` read the options, prints the first fault if there is
   one, else lets `run` do the work and set the exit status, and ends MPI and PETSc. Returns the exit status. */
int MPMProgram(int argc, char **argv, PetscErrorCode (*read)(MPM, MPMOptions), PetscErrorCode (*run)(MPM, int *status));

/* The preset (preset.c): read its name before the scene, choose its row after it, print what it stands for. Not
   collective, but for the print: on core.comm. */
PetscErrorCode MPMPresetRead(MPM, MPMOptions);
void           MPMPresetChoose(MPM);
PetscErrorCode MPMPresetPrint(MPM);

/* Prints what makes a method doubtful in this scene, with steps of dt, s, and what to use instead (method_warnings.c). Collective
   on exchange.data. */
PetscErrorCode MPMMethodWarnings(MPM, PetscReal dt);

/* Reads -method_*, -time_* and -dt_* (method.c); faults are left in the options. Not collective. */
PetscErrorCode MPMMethodSetFromOptions(MPM, MPMOptions);

/* Print notes on the options, the start of a run, its progress and its end (report.c, notes.c), of which
   MPMReportEnergy prints the lines about energy (report_energy.c), MPMReportBodies those of the bodies
   (report_bodies.c), MPMReportPrediction the predicted time of so many steps of `step` s, and MPMReportPhases the times
   of the phases, if the steps took long or an option asks for them (report_times.c). MPMNotes is collective on
   core.comm, the start, the bodies, the end and the energy on exchange.data, and the others are not collective. */
PetscErrorCode MPMNotes(MPM);
PetscErrorCode MPMReportStart(MPM);
PetscErrorCode MPMReportProgress(MPM);
PetscErrorCode MPMReportBodies(MPM);
PetscErrorCode MPMReportEnergy(MPM);
PetscBool      MPMEnergyIsFollowed(MPM); /* is all that changes the energy summed, in any run? */
PetscErrorCode MPMReportPrediction(MPM, PetscReal steps, PetscReal step);
PetscErrorCode MPMReportPhases(MPM);
PetscErrorCode MPMReportEnd(MPM);

/* Write why this basis, update and transfer give wrong results together, with what to use instead, or ""; and the options
      of a method like this one that is stable where particles cross cells with steps of C = c dt/h; return the option of
   quadratic splines (method_warnings.c). */
const char *MPMMethodSpline(void);
void MPMMethodWrong(MPM, char why[MPM_TEXT_LEN]);
void        MPMMethodStable(MPM, PetscReal C, char options[MPM_TEXT_LEN]);

/* Returns whether by now noise has grown by the method, as far as the table of stable methods tells; writes that, and
   the options of a stable one. */
PetscBool MPMMethodAmplifies(MPM, char what[MPM_TEXT_LEN], char options[MPM_TEXT_LEN]);

/* Returns the bytes of particles, with order and scratch, and of nodes, on all processes together (report.c). */
PetscReal MPMMemory(MPM);

/* Return the memory of this process in bytes, and print the largest that a run will need (memory.c). MPMMemoryPrint is
   collective on exchange.data. */
PetscReal      MPMMemoryHere(const char what[]);
PetscErrorCode MPMMemoryPrint(MPM, PetscReal seconds);

/* Prints with -dry_run how large the files of the run will be, if it makes so many steps in so many seconds, and warns
   if their disk has less room (disk.c). Not collective. */
PetscErrorCode MPMDiskPrint(MPM, PetscReal steps, PetscReal seconds);

/* Tell what is doubtful in a valid scene (doubts.c): refuse it, before the first step, or note odd values, or warn;
   steps and seconds are what is predicted for the whole run. Not collective, but for MPMDoubtsBodies, which warns of
   how the particles of bodies lie (doubts_bodies.c): on exchange.data. */
PetscErrorCode MPMDoubtsBodies(MPM);
PetscErrorCode MPMDoubtsRefuse(MPM, MPMOptions);
PetscErrorCode MPMDoubtsNote(MPM);
PetscErrorCode MPMDoubtsWarn(MPM, PetscReal steps, PetscReal seconds);

/* The step of the loop (advance.c): read its options, list the fields that it changes, make it, print at the end what was
   undone and what left the grid. A reason to stop is left in core.stop. The last two are collective on exchange.data. */
PetscErrorCode MPMAdvanceSetFromOptions(MPM, MPMOptions);
void           MPMAdvanceSetUp(MPM);
PetscErrorCode MPMAdvance(MPM);
PetscErrorCode MPMAdvanceReport(MPM);

/* Lists the variables of a run, an MPM, at this moment (state.c). Not collective. */
void MPMStateList(void *run, MPMVariables *);

#endif
