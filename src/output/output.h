/* output.h - what a run writes between steps: the history of totals, with its checks, and snapshots. */
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
  PetscInt    last, looked;                /* step of the last line; step at which the totals `now` were last checked */
  PetscBool   off;                         /* a run of the calibration has no file and no totals */
  MPMTotals   start, now;                  /* of step 0, and of the last check or line */
  PetscBool   no_file;                     /* lines are watched and checked, but not written */
  void (*watch)(const MPMShown *, void *); /* called for each line with watcher; or NULL */
  void *watcher;
} MPMMonitor;

/* Reads the options of the history and its checks; *follow is -history_energy. The first fault is left in the options.
   Not collective. */
PetscErrorCode MPMMonitorSetFromOptions(MPMMonitor *, const MPMScene *, PetscReal time_end, MPMOptions,
                                        PetscBool *follow);
/* Computes and checks the totals of a step before it is settled, so that it can be undone: if they are to be checked, or
   if a line is due, for which they are then known. May set core->stop. Collective on the exchange. */
PetscErrorCode MPMMonitorLook(MPMMonitor *, MPMCore *, const MPMScene *);
PetscErrorCode MPMMonitorStep(MPMMonitor *, MPMCore *, const MPMScene *, PetscBool force); /* may set core->stop */
PetscErrorCode MPMMonitorDestroy(MPMMonitor *);                                            /* closes the file */
MPMShown       MPMMonitorShown(const MPMMonitor *, const MPMCore *, const MPMScene *);     /* what diagnostics read */
PetscReal      MPMNextTime(PetscReal t, PetscReal every); /* when output is due next, s */

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
  PetscInt64 *particles;   /* [count] particles in it */
  PetscViewer viewer;      /* of the HDF5 file */
} MPMOutput;
#define MPM_OUTPUT_GRID ((PetscInt64)1 << 62) /* bit of the nodes in MPMOutput.fields */

/* How far the stress is from what nodes and particles agree on (indicator.c): its rms by volume in Pa; the rms of
   own stress less recovered stress, as a part of that; the largest such difference, likewise, and where it is, m. */
typedef struct {
  PetscReal stress, jump, largest, x[3];
} MPMIndicator;

/* Computes it, and for each particle here its difference as a part of the rms of the stress, of [n]. It changes no
   particle. Collective on the exchange. */
PetscErrorCode MPMIndicatorCompute(const MPMScene *, MPMCore *, float of[], MPMIndicator *);

/* snapshot.c and xdmf.c describe these functions. */
PetscErrorCode MPMOutputSetFromOptions(MPMOutput *, const MPMScene *, PetscReal time_end, MPMOptions);
PetscErrorCode MPMOutputMakeFolder(MPMOutput *, const MPMScene *, MPMOptions);
PetscErrorCode MPMOutputStep(MPMOutput *, MPMCore *, const MPMScene *, PetscBool force);
PetscErrorCode MPMOutputDestroy(MPMOutput *);
PetscErrorCode MPMXdmfWrite(const MPMOutput *, const MPMCore *, const MPMScene *);

#endif
