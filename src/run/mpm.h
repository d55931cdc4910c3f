/* mpm.h - a run: everything that belongs to it, and the functions that make it, in the sequence of their calls:

     MPMCreate  MPMSetFromOptions  MPMSetUp  MPMRun  MPMDestroy

   All data of a run are in its MPM, so that a program can make many runs. Comments give units in SI; any consistent set
   of units works. docs/developer.md describes the folders of src. */
#ifndef MPM_MPM_H
#define MPM_MPM_H

#include "advice/advice.h"
#include "restart/restart.h"

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

/* Scenes for which a preset has a row: all materials are elastic, all are gases, all are fluids, or any others. */
typedef enum { MPM_SCENES_elastic, MPM_SCENES_gases, MPM_SCENES_fluids, MPM_SCENES_others } MPMScenes;

/* A named method for such scenes; a row of preset.def. */
typedef struct {
  const char *name;
  MPMScenes   scenes;
  PetscBool   total; /* it is of the total frame, where update and transfer are read, but not used */
  PetscInt    mass;  /* of the total frame: order of the mass matrix */
  const char *basis;
  PetscBool   stretch;
  const char *update, *transfer;
  PetscReal   strain, rate, cfl;
  PetscInt    ppc;
} MPMPreset;

typedef struct _p_MPM *MPM;

struct _p_MPM {
  MPMCore          core;
  MPMScene         scene;
  MPMMethod        method;
  char             aside[MPM_TEXT_LEN]; /* options of a file that stand aside in the total frame */
  const MPMPreset *preset;              /* what options of the method are that were not given */
  PetscBool        preset_given;        /* -method_preset was */
  MPMTime          time;
  MPMMonitor       monitor;
  MPMOutput        output;
  MPMCost          cost;
  MPMReport        report;
  MPMWatch         watch;
  MPMRetry         retry;
  MPMCheckpoint    checkpoint;
  /* Of a stage: the fields (bits) that later ones need of each material's state; the last number: those that what flows in can
     get only as it does. NULL: none is known. */
  const PetscInt *keeps;
};

extern const MPMVocabulary MPMOptionTable; /* options.def, with the values that other tables have (vocabulary.c) */

/* These functions are collective on the comm that MPMCreate gets; mpm.c describes them. */
PetscErrorCode MPMCreate(MPI_Comm, MPM *);
PetscErrorCode MPMReadOptions(MPM, MPMOptions);
PetscErrorCode MPMSetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMSetNeeds(MPM);  /* what of its particles the scene needs; MPMSetPhases calls it */
PetscErrorCode MPMSetPhases(MPM); /* sets the phases of a step and the cost model; MPMSetUp calls it first */
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

/* Reads -method_*, -time_* and -dt_* (method.c); faults are left in the options. Not collective. */
PetscErrorCode MPMFrameSetFromOptions(MPM); /* what of a file stands aside for the total frame, before all else */
PetscErrorCode MPMMethodPutAside(MPM, const char name[], const char by[]);
PetscErrorCode MPMMethodSetFromOptions(MPM, MPMOptions);
PetscBool      MPMFrameRests(MPM);              /* are steps static, in the updated frame? */
PetscErrorCode MPMFrameCheck(MPM, MPMOptions);  /* refuses what the total frame and static steps cannot do */
PetscErrorCode MPMFrameRead(MPM, MPMOptions);   /* sets their method, after the basis */
PetscErrorCode MPMStaticsRead(MPM, MPMOptions); /* -method_time and what belongs to it (statics.c) */

/* Print, in sequence, what a run says before its first step and at its end (prints.c). Collective on exchange.data. */
PetscErrorCode MPMPrintStart(MPM);
PetscErrorCode MPMPrintEnd(MPM);

/* The step of the loop (advance.c): read its options, list the fields that it changes, make it, print at the end what
   was undone and what left the grid. A reason to stop is left in core.stop. The last two are collective on
   exchange.data. */
PetscErrorCode MPMAdvanceSetFromOptions(MPM, MPMOptions);
void           MPMAdvanceSetUp(MPM);
PetscErrorCode MPMAdvance(MPM);
PetscErrorCode MPMAdvanceReport(MPM);

/* Returns whether a run has come to its end: the time of its end, or rest. Not collective. */
MPM_INLINE PetscBool MPMEnds(const MPM mpm)
{
  return mpm->core.t >= mpm->time.end || mpm->core.rest.reached;
}

/* Makes the runs of all stages, one after the other (stages.c). Collective on PETSC_COMM_WORLD. */
PetscErrorCode MPMStagesRun(PetscErrorCode (*read)(MPM, MPMOptions), PetscErrorCode (*run)(MPM, int *status),
                            int *status);

/* Lists the variables of a run, an MPM, at this moment (state.c). Not collective. */
void MPMStateList(void *run, MPMVariables *);

#endif
