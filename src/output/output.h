/* output.h - what a run writes: the history of totals, with its checks, and snapshots. */
#ifndef MPM_OUTPUT_H
#define MPM_OUTPUT_H

#include <petscviewer.h>
#include "output/diagnostics.h"

/* The history (monitor.c). */
typedef struct {
  const char *dir;                          /* the folder of the results */
  FILE       *file;                         /* on the first process of the data communicator */
  PetscReal   every, next;                  /* s of simulated time */
  PetscReal   check_energy, check_momentum; /* relative; 0: off */
  PetscReal   energy_max;                   /* the largest kinetic + strain energy so far, J */
  PetscReal   speed_max;                    /* the largest sum m |v| so far, kg m/s */
  PetscInt    last;                         /* step of the last line */
  PetscBool   off;                          /* no file, no totals: a run of the calibration */
  MPMTotals   start, now;
} MPMMonitor;

PetscErrorCode MPMMonitorSetFromOptions(MPMMonitor *, const MPMScene *, PetscReal time_end, MPMOptions);
PetscErrorCode MPMMonitorStep(MPMMonitor *, MPMCore *, const MPMScene *, PetscBool force); /* may set core->stop */
PetscErrorCode MPMMonitorDestroy(MPMMonitor *);
MPMShown       MPMMonitorShown(const MPMMonitor *, const MPMCore *, const MPMScene *);
PetscReal      MPMNextTime(PetscReal t, PetscReal every); /* when a cadence is due again */

/* Snapshots (snapshot.c). */
typedef struct {
  char        dir[MPM_TEXT_LEN];
  PetscBool   enabled;
  PetscBool   replaced;    /* files of the same name were there */
  PetscReal   every, next; /* s of simulated time */
  PetscInt64  fields;      /* bits of rows of MPMDiagnostics, and MPM_OUTPUT_GRID */
  PetscInt    count, last; /* snapshots written; step of the last */
  PetscInt   *steps;       /* [count] */
  PetscReal  *times;       /* [count] s */
  PetscViewer viewer;      /* of the HDF5 file */
} MPMOutput;
#define MPM_OUTPUT_GRID ((PetscInt64)1 << 62) /* bit of the nodes in MPMOutput.fields */

PetscErrorCode MPMOutputSetFromOptions(MPMOutput *, const MPMScene *, PetscReal time_end, MPMOptions);
PetscErrorCode MPMOutputMakeFolder(MPMOutput *, const MPMScene *, MPMOptions);
PetscErrorCode MPMOutputStep(MPMOutput *, MPMCore *, const MPMScene *, PetscBool force);
PetscErrorCode MPMOutputDestroy(MPMOutput *);
PetscErrorCode MPMXdmfWrite(const MPMOutput *, const MPMCore *, const MPMScene *);

#endif
