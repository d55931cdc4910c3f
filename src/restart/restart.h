/* restart.h - checkpoints of a run, and a run that goes on from one of them or repeats an earlier one. */
#ifndef MPM_RESTART_H
#define MPM_RESTART_H

#include "restart/checkpoint.h"
#include "results/output.h"

/* Checkpoints of a run, and the one that it goes on from. */
typedef struct {
  /* The run: its parts, and its variables, which `list` writes down at any time. */
  MPMCore    *core;
  MPMScene   *scene;
  MPMMonitor *monitor;
  MPMOutput  *output;
  void (*list)(void *run, MPMVariables *);
  void *run;

  PetscReal      every, wall, next;  /* s of simulated time; s of the clock; s: when the next one is due */
  PetscInt       keep, number;       /* -checkpoint_keep; number of the last one written */
  PetscInt       last;               /* the step of the last one */
  PetscLogDouble written;            /* when it was written, s of the clock */
  PetscBool      rescued;            /* one was tried after a fault in writing */
  PetscBool      off, wanted;        /* the run writes none; an option asks for some */
  char           path[MPM_TEXT_LEN]; /* the last one; "": none was written */

  /* What is read of a checkpoint before the scene is set up (MPMCheckpointHeader). */
  PetscInt   step, snapshots;
  PetscReal  t;                                  /* s */
  PetscInt64 history_length, history_sum, total; /* bytes of the history, and their checksum; particles */
  PetscInt64 shapes;                             /* checksum of the files that shapes and particles were read from */
  PetscInt64 kinds;                              /* and of the particles' kinds and numbers (MPMRestartKinds) */
  MPMStart   start;                              /* of the run that wrote it, or of the stages before */
  char       totals[MPM_TEXT_LEN];

  /* Of a restart: its intervals of history and snapshots, s; whether the history in the folder is that of the checkpoint;
     the commit of the program that wrote it, and its options; the file; a damaged one that was passed over, and why;
     options that differ, whether any of them acts on the state, and whether statics become a motion; the fields of
     particles that it does not have (bits). */
  PetscReal history_was, output_was;
  PetscBool own, changed, was_static, was_implicit;
  PetscInt  stage; /* of a run in stages: the one that the file is of, and when it began, s */
  PetscReal began;
  PetscBool follows,
      other; /* the file is to be of the stage before; it is of another one than this run, and not read */
  PetscInt  missing;
  PetscReal left[2]; /* of bodies that leave at the restart: particles; mass, kg */
  char      git[MPM_NAME_LEN], *options;
  char      from[MPM_TEXT_LEN], fallback[MPM_TEXT_LEN], differ[MPM_TEXT_LEN];
} MPMCheckpoint;

/* Names of checkpoints, which are numbered as they are written: the path of one; the numbers of all of this scene in the
   folder of the results, the last first, which the caller frees. The second is collective on comm. */
void           MPMCheckpointPath(MPMCheckpoint *, PetscInt number, char path[MPM_TEXT_LEN]);
PetscErrorCode MPMCheckpointList(MPMCheckpoint *, MPI_Comm comm, PetscInt *n, PetscInt **numbers);

/* Lists what is read before the scene is set up; and the names of the rows of totals: programs with other rows do not
   understand each other's checkpoints. Not collective. */
void MPMCheckpointHeader(MPMCheckpoint *, MPMVariables *);
void MPMCheckpointTotals(char text[MPM_TEXT_LEN]);

/* Checkpoints (checkpoints.c). SetFromOptions is collective on core.comm; Note says what an earlier run left, and Step
   writes one if it is due, asked for, or if the run ends and checkpoints are wanted: collective on exchange.data. OfStop writes one of the last state of a run that a check stops, unless it has one. A checkpoint that
   cannot be written is a reason to stop (core.stop). */
PetscErrorCode MPMCheckpointSetFromOptions(MPMCheckpoint *, MPMOptions);
PetscErrorCode MPMCheckpointNote(MPMCheckpoint *);
PetscErrorCode MPMCheckpointStep(MPMCheckpoint *, PetscBool ends);
PetscErrorCode MPMCheckpointOfStop(MPMCheckpoint *);
PetscErrorCode MPMCheckpointAgain(MPMCheckpoint *); /* writes one before the first step of a restart */

/* A restart (restart.c): choose the file and compare options, for a run to the time `end`, s; check that it has the
   fields of this run; where its particles are, for cutting the grid; make the particles; read all else; let the files of
   results go on. A fault is left in the options, or in core.stop. Collective: the first three on core.comm, the others on
   exchange.data. */
PetscErrorCode MPMRestartSetFromOptions(MPMCheckpoint *, PetscReal end, MPMOptions);
PetscErrorCode MPMRestartCheckFields(MPMCheckpoint *);
PetscErrorCode MPMRestartHistogram(MPMCheckpoint *, MPMHistogram *);
PetscErrorCode MPMRestartParticles(MPMCheckpoint *);
PetscErrorCode MPMRestartState(MPMCheckpoint *, MPMWalls *);
PetscErrorCode MPMRestartFiles(MPMCheckpoint *);

/* What may differ from the checkpoint (changes.c): why the options of a row of the vocabulary may not in a
   stage, or NULL; compare all options
   with those of this run; the checksum of the particles' kinds and numbers; let the balance of energy and momentum
   count what the change itself gives, for the present totals. Not collective. */
const char    *MPMRestartNotInStage(const char row[]);
PetscErrorCode MPMRestartCompare(MPMCheckpoint *, MPMOptions);
PetscInt64     MPMRestartKinds(const MPMScene *);
void           MPMRestartBalance(MPMCheckpoint *, const MPMTotals *now);

/* Stages of a run (stages.c): make of the text of all options that of a stage, 0: of none, which the caller frees; let the
   options be these; read what belongs to stages (stages_read.c); write which option of a stage may not change there, or "".
   Not collective. */
PetscErrorCode MPMStagesOptions(const char text[], PetscInt stage, char **options);
PetscErrorCode MPMStagesOverlay(const char text[], const char options[]);
PetscErrorCode MPMStagesSetFromOptions(const MPMScene *, MPMOptions);
PetscErrorCode MPMStagesForbidden(const char text[], const char list[], PetscInt stage, MPMOptions,
                                  char why[MPM_TEXT_LEN]);

/* Bodies that leave (leave.c): read -remove; after all else of a restart, remove them, which is collective on the exchange. */
PetscErrorCode MPMLeaveSetFromOptions(MPMCheckpoint *, PetscBool restarts, MPMOptions);
PetscErrorCode MPMLeave(MPMCheckpoint *);

/* Fields that a checkpoint does not have (refill.c): keep those of the particles as they start, which are made for this;
   give them to the particles of the same ids that are here then. kept: [fields]. Collective on exchange.data. */
PetscErrorCode MPMRefillBegin(MPMCheckpoint *, PetscReal *kept[]);
PetscErrorCode MPMRefillEnd(MPMCheckpoint *, PetscReal *kept[]);

/* Sets the options that the results of -rerun were made with, as far as they are not given. fault: what is wrong with
   the file, or "". Not collective: every process reads it. */
PetscErrorCode MPMRerun(char fault[MPM_TEXT_LEN]);

#endif
