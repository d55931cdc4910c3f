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
  PetscInt64 volumes;                            /* checksum of the masses and volumes of kinds of particles */
  PetscInt64 shapes;                             /* checksum of the files that shapes and particles were read from */
  char       totals[MPM_TEXT_LEN];

  /* Of a restart: its intervals of history and snapshots, s; whether the history in the folder is that of the checkpoint;
     the commit of the program that wrote it, and its options; the file; a damaged one that was passed over, and why;
     options that differ. */
  PetscReal history_was, output_was;
  PetscBool own;
  PetscBool starts;                /* from the end of an implicit run: with another method, and other loads */
  PetscBool lacks[MPM_NUM_FIELDS]; /* fields that it does not have and that are 0 */
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

/* Returns the checksum of masses and volumes of the kinds of particles. Not collective. */
PetscInt64 MPMCheckpointVolumes(const MPMScene *);

/* Checkpoints (checkpoints.c). SetFromOptions is collective on core.comm; Note says what an earlier run left, and Step
   writes one if it is due, asked for, or if the run ends and checkpoints are wanted: collective on exchange.data. OfStop writes one of the last state of a run that a check stops, unless it has one. A checkpoint that
   cannot be written is a reason to stop (core.stop). */
PetscErrorCode MPMCheckpointSetFromOptions(MPMCheckpoint *, MPMOptions);
PetscErrorCode MPMCheckpointNote(MPMCheckpoint *);
PetscErrorCode MPMCheckpointStep(MPMCheckpoint *, PetscBool ends);
PetscErrorCode MPMCheckpointOfStop(MPMCheckpoint *);

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

/* Sets the options that the results of -rerun were made with, as far as they are not given. fault: what is wrong with
   the file, or "". Not collective: every process reads it. */
PetscErrorCode MPMRerun(char fault[MPM_TEXT_LEN]);

#endif
