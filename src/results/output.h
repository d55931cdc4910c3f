/* output.h - what a run writes between steps: the history of totals, with its checks, and snapshots. */
#ifndef MPM_OUTPUT_H
#define MPM_OUTPUT_H

#include "physics/outline.h"
#include "results/measures.h"

#define MPM_NEW_FILE ".pebble-new" /* end of the name of a file that is not complete yet */

/* The history (monitor.c). */
typedef struct {
  const char *dir;                          /* the folder of the results */
  FILE       *file;                         /* on the first process of the data communicator */
  PetscReal   every, next;                  /* s of simulated time */
  PetscBool   exact;                        /* -history_exact: steps end at the times of lines */
  MPMMeasures measures;                     /* columns that one asks for */
  PetscReal   check_energy, check_momentum; /* relative; 0: off */
  PetscReal   energy_max;                   /* the largest kinetic + strain energy so far, J */
  PetscReal   speed_max;                    /* the largest sum m |v| so far, kg m/s */
  PetscInt    last, looked; /* step of the last line; step at which the totals `now` were last checked */
  PetscBool   exceeded;     /* -check_energy or -check_momentum stops the run */
  PetscBool   off;          /* a run of the calibration has no file and no totals */
  MPMTotals   start, now;   /* of step 0, and of the last check or line */
  long        length;       /* bytes of the complete lines in the file */
  PetscBool   failed;       /* it could not be written: no more lines are */
  char       *more;   /* on the first process: ",name" of each column of an earlier part that this one does not have; */
  PetscInt    nmore;  /* how many; */
  PetscBool   joined; /* the file was written anew to have the columns of both */
} MPMMonitor;

/* Gives a history the columns `head` and then those of its own that are not among these: `more`, as MPMMonitor has
   them, which the caller frees; if it has not got them, it is written anew, with *length bytes, and *other is set
   (join.c). Returns 0, or errno. Not collective. */
int MPMHistoryJoin(const char path[], const char head[], char **more, PetscInt *nmore, long *length, PetscBool *other);

/* Reads the options of the history and its checks; *follow is -history_energy, damped is whether there is damping of
   all motion. The first fault is left in the options. Not collective. */
PetscErrorCode MPMMonitorSetFromOptions(MPMMonitor *, const MPMScene *, PetscReal time_end, MPMOptions,
                                        PetscBool damped, PetscBool *follow);
/* Computes and checks the totals of a step before it is settled, so that it can be undone: if they are to be checked,
   or if a line is due, for which they are then known. May set core->stop. Collective on the exchange. */
PetscErrorCode MPMMonitorLook(MPMMonitor *, MPMCore *, const MPMScene *);
PetscErrorCode MPMMonitorStep(MPMMonitor *, MPMCore *, const MPMScene *, PetscBool force); /* may set core->stop */
/* Returns the checksum of the first `length` bytes of the history, or 0 if it has less or there is none. Not
   collective. */
uint64_t MPMMonitorSum(const MPMMonitor *, const MPMScene *, long length);
/* Goes on with the history of an earlier run, of which the first `length` bytes are known to be right (`own`), or
   begins a new one. Collective on the exchange. */
PetscErrorCode MPMMonitorResume(MPMMonitor *, MPMCore *, const MPMScene *, PetscBool own, long length);
PetscErrorCode MPMMonitorDestroy(MPMMonitor *);                                        /* closes the file */
MPMShown       MPMMonitorShown(const MPMMonitor *, const MPMCore *, const MPMScene *); /* what diagnostics read */
PetscReal      MPMNextTime(PetscReal t, PetscReal every);                              /* when output is due next, s */
PetscReal      MPMNextExact(PetscReal t, PetscReal every); /* and the time as it is told, s */

/* Snapshots (snapshot.c). */
typedef struct {
  char       dir[MPM_TEXT_LEN];
  PetscBool  enabled;
  PetscBool  replaced;         /* files of the same name were there */
  PetscBool  keep;             /* -output_replace false: earlier results are not replaced */
  PetscBool  resumed;          /* the run goes on with results that are there (set before MPMOutputMakeFolder) */
  PetscBool  begun;            /* what an earlier run left has been removed */
  PetscBool  failed;           /* a file could not be written: no more are */
  PetscReal  every, next;      /* s of simulated time */
  PetscBool  exact;            /* -output_exact: steps end at the times of snapshots */
  PetscInt64 fields;           /* bits of rows of MPMDiagnostics, and MPM_OUTPUT_GRID */
  PetscInt   count, last;      /* snapshots written; step of the last */
  PetscInt   joined;           /* how many of them the index and the text have */
  PetscInt  *steps, *n;        /* [count] and the number of particles in it */
  PetscReal *times;            /* [count] s */
  PetscInt64 digest, *digests; /* of the state in the last one, and [count] in each */
  MPMFaces   faces;            /* of the surfaces of rigid bodies, as they were at the start */
  PetscInt  *first;            /* [bodies + 1] the first one of each rigid body; NULL: not made yet, or there is none */
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

/* Makes what the functions of these rows (bits) of MPMDiagnostics read of the present state, and frees it. The first is
   collective on the exchange. */
PetscErrorCode MPMShownBegin(const MPMScene *, MPMCore *, PetscInt64 rows, MPMShown *);
PetscErrorCode MPMShownEnd(MPMShown *);

/* snapshot.c describes these functions. */
PetscErrorCode MPMOutputSetFromOptions(MPMOutput *, const MPMScene *, PetscReal time_end, MPMOptions);
PetscErrorCode MPMOutputStep(MPMOutput *, MPMCore *, const MPMScene *, PetscBool force);
PetscErrorCode MPMOutputFinish(MPMOutput *, MPMCore *, const MPMScene *);
PetscErrorCode MPMOutputDestroy(MPMOutput *);

/* Makes the folder of the results, and refuses names at which they would replace an options file, a file that Pebble
   did not write or, with -output_replace false, an earlier result (folder.c). Collective on core.comm. */
PetscErrorCode MPMOutputMakeFolder(MPMOutput *, const MPMCore *, const MPMScene *, MPMOptions);

/* Returns how many particles a scene begins with; their ids are below. */
MPM_INLINE PetscInt64 MPMSceneStarted(const MPMScene *scene)
{
  return scene->bodies[scene->nbodies - 1].first + scene->bodies[scene->nbodies - 1].n;
}

/* Writes the path of a snapshot; beside: as seen from the folder of the results. Removes what an earlier run of this
   name left, or with `beyond` just the snapshots that this run does not list (folder.c). Not collective. */
void MPMSnapshotPath(const MPMOutput *, const MPMScene *, PetscInt step, PetscBool beside, char path[2 * MPM_TEXT_LEN]);
void MPMOutputClear(const MPMOutput *, const MPMScene *, PetscBool beyond);

/* Lets all processes know of a fault in writing: `fault` is a text with the name of the file and the system's reason,
   or empty; that of the first process that has one is added to core->stop, and *failed is set. Collective on
   exchange.data. */
PetscErrorCode MPMOutputFail(MPMCore *, const char fault[], PetscBool *failed);

/* Write the index <name>.h5 and the texts <name>.xdmf ... for the snapshots so far: to new files, which are then
   renamed, so that all are complete at every moment. The first process writes; *fault, on this process, says what went
   wrong (index.c, xdmf.c). Collective on exchange.data. */
PetscErrorCode MPMIndexWrite(const MPMOutput *, const MPMCore *, const MPMScene *, char fault[MPM_TEXT_LEN]);
PetscErrorCode MPMXdmfWrite(MPMOutput *, const MPMCore *, const MPMScene *, char fault[MPM_TEXT_LEN]);

/* Goes on with the snapshots of an earlier run, whose count, steps, times, last and next are in MPMOutput: removes
   those that are not listed, warns of those that are missing, writes index and text anew (resume.c). Collective on
   exchange.data. */
PetscErrorCode MPMOutputResume(MPMOutput *, MPMCore *, const MPMScene *);

#endif
