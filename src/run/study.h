/* study.h - what the files of the studies share: options that are replaced for a run and put back, runs made from the
   option database, and what they gave. A study that has a scene of its own fills an option database with it and makes
   it the current one (PetscOptionsPush, PetscOptionsPop). All runs of a study read MPM `base`, the scene as given,
   which is not set up. */
#ifndef MPM_STUDY_H
#define MPM_STUDY_H

#include "run/mpm.h"

/* Options that a study has replaced, with what they were before. */
typedef struct {
  PetscInt n, capacity;
  char   **name, **value; /* value NULL: it was not given */
  char    *given;         /* was the option given? */
} MPMChanges;

/* Sets an option ("-name") to a value, or to none with MPMChangesClear; MPMChangesUndo puts all back as they were. Not
   collective. */
PetscErrorCode MPMChangesSet(MPMChanges *, const char name[], const char format[], ...) PETSC_ATTRIBUTE_FORMAT(3, 4);
PetscErrorCode MPMChangesClear(MPMChanges *, const char name[]);
PetscErrorCode MPMChangesUndo(MPMChanges *);

/* Replaces what makes a run a run of this study: its name, and the options -study_*. */
PetscErrorCode MPMChangesOfStudy(MPMChanges *, MPM base, const char name[]);
/* Make cells and a given -dt_size 2^level times as fine as those of the scene (level < 0: as large; 2^-level divides the
   cells); particles per cell and axis `factor` times as many; -dt_size, or else -dt_cfl, smaller by `factor`. */
PetscErrorCode MPMChangesRefine(MPMChanges *, MPM base, PetscInt level);
PetscErrorCode MPMChangesPpc(MPMChanges *, MPM base, PetscInt factor);
PetscErrorCode MPMChangesStep(MPMChanges *, MPM base, PetscReal factor);

/* A particle of a finished run, as a comparison with another run needs it. */
typedef struct {
  PetscInt64 key[3];  /* place on the lattice of its body */
  PetscInt   body;    /* row of the scene's bodies */
  PetscReal  u[3], m; /* displacement, m; mass, kg */
} MPMSample;

/* All particles of a finished run; the lattice of a body has the spacing b. */
typedef struct {
  PetscInt   n, nbodies;
  MPMSample *at;     /* [n] */
  PetscReal (*b)[3]; /* [nbodies] m */
} MPMSamples;

/* What a run gave. error and size are those of MPMKnownError, 0 without a known solution and where the run stopped. */
typedef struct {
  PetscInt   dim, cells[3], steps, lines; /* lines: of the history that were seen */
  PetscInt64 particles;
  PetscReal  h, ppc, fixed, cfl; /* of axis x, m; of body 0 on axis x; -dt_size, or 0, s; -dt_cfl */
  MPMStable  stable;             /* what the table of stable.def says of the method */
  PetscReal  error, size;        /* m */
  PetscReal  seconds, wall,
      memory; /* s of the steps alone, on one process of its processor; s of the run; bytes of particles, nodes */
  PetscInt  basis, scheme, transfer, order; /* rows of their tables; -method_order where it applies, else 0 */
  PetscBool stretched;                      /* -method_gimp_update stretch */
  PetscReal flip, strain, rate, viscosity;  /* share of FLIP, of the strain rate in aflip; dampings that set flip */
  PetscReal predicted;                      /* s of the steps by the model (MPM_STUDY_PREDICT) */
  PetscInt  measure;                        /* the column of MPMMeasures that is -study_quantity; or -1 */
  PetscReal column[MPM_NUM_DIAGNOSTICS + 1][3][MPM_NUM_SEEN]; /* by row of MPMDiagnostics; the last is that measure */
  PetscBool interrupted;                                      /* by a signal: the study should end */
  char      refused[MPM_TEXT_LEN], stop[MPM_TEXT_LEN],
      wrong
          [MPM_TEXT_LEN]; /* why the options were refused, why it stopped, what the program warns of (MPMMethodWrong); or "" */
} MPMStudyResult;

/* What a run of a study keeps or says. */
enum {
  MPM_STUDY_FILES   = 1,  /* it writes its history and snapshots as any run does; else no file */
  MPM_STUDY_TELL    = 2,  /* if it stops, it says why on standard error; else only the result does */
  MPM_STUDY_SAMPLES = 4,  /* its particles go to samples, on the processes that hold particles */
  MPM_STUDY_PREDICT = 16, /* it is set up and its time is predicted, but no step is made */
  MPM_STUDY_DRY     = 8   /* only its options are read: cells, particles, h, fixed, cfl, refused are set */
};

/* Makes a run of the present options and sets *r on all processes; a run that is refused or stops is a result like
   others. samples: NULL, or empty; the caller frees them. Collective on base->core.comm. */
PetscErrorCode MPMStudyMake(MPM base, PetscInt keeps, MPMStudyResult *r, MPMSamples *samples);

/* study_compare.c. MPMSamplesGather is collective on the exchange, the others are not collective. */
PetscErrorCode MPMSamplesGather(MPM, MPMSamples *);
PetscErrorCode MPMSamplesDestroy(MPMSamples *);
/* Sets *difference to the root of the mass-weighted mean of |u - u_fine|^2 over the coarse particles, m, and *size to
   that of |u_fine|; the particles of both are sorted. */
PetscErrorCode MPMSamplesCompare(const MPMGrid *, MPMSamples *coarse, MPMSamples *fine, PetscReal *difference,
                                 PetscReal *size);

/* A series of numbers y [n], each of a run twice as fine as the one before (study_series.c). The order of a pair is that
   from run k - 1 to run k, pair[k]; MPM_NO_ORDER: there is none. Falls: the last number is smaller than the one before
   by a tenth at least. Agree: the last two pairs fall, and their orders differ by MPM_ORDER_BAND at most. Rest sets how
   far differences d [n] still lead if they go on as they do, and by how much that is uncertain: the change that the
   pair before makes to it, or all of it where there is no such pair. It returns false if they do not fall. */
#define MPM_NO_ORDER   PETSC_MIN_REAL
#define MPM_ORDER_BAND 0.3
void      MPMSeriesOrders(PetscInt n, const PetscReal y[], PetscReal pair[]);
PetscBool MPMSeriesAgree(PetscInt n, const PetscReal pair[]);
PetscBool MPMSeriesFalls(PetscInt n, const PetscReal y[]);
PetscBool MPMSeriesRest(PetscInt n, const PetscReal d[], PetscReal *rest, PetscReal *uncertainty);

/* Prints a fault in writing a table, a text of the first process, and sets *status to that of a run that stopped; does
   nothing if the text is empty (study_run.c). Collective on base->core.comm. */
PetscErrorCode MPMStudyFault(MPM base, const char fault[], int *status);

/* The studies; *status is that of the program. Collective on base->core.comm. */
PetscErrorCode MPMStudyConvergence(MPM base, int *status);
PetscErrorCode MPMStudyStability(MPM base, int *status);

#endif
