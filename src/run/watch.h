/* watch.h - what is watched while a run runs, and the bounds beyond which it is told: watch.c (time step, rest),
   parting.c (matter that parts), ranges.c (laws out of their range), cause.c (why a run stopped). docs/faq.md
   has what is told, docs/stability.md where the bounds come from. */
#ifndef MPM_WATCH_H
#define MPM_WATCH_H

#include "scene/neighbours.h"

/* Matter that parts is looked for after every 64th step; where neighbours are far from each other, after every 16th,
   and where their deformation does not explain it, after every 8th. Laws are looked at after every 16th. These are
   numbers of steps, so that they are the same after a restart. */
#define MPM_WATCH_FAR   64
#define MPM_WATCH_NEAR  16
#define MPM_WATCH_PARTS 8
#define MPM_WATCH_LAWS  16

#define MPM_COLLAPSE 0.01 /* of the first time step; a shorter one is told */

/* The acceleration, in that of gravity, above which a body does not rest in the stress by its weight. In columns
   between walls the first step accelerates particles by up to 0.03, with splines near the surface; on slopes of 34 and
   45 degrees, which settle, by 0.5; without a wall on one side or below by 3 to 24, with 8 and 16 cells of height
   (docs/studies.md). */
#define MPM_RESTLESS 1

#define MPM_ENERGY_GROWN 0.05 /* of the largest energy and the work; what grows more without a cause is told */

/* Distances of particles that were neighbours at the start, in cells; and by how much a distance has grown beyond the
   one that their deformation explains. Under tension a body whose particles are farther than WIDE from each other
   begins to tear: measured on bars (docs/stability.md). */
#define MPM_GAP_NEAR 0.6  /* is looked at more often */
#define MPM_GAP_WIDE 0.82 /* is warned of, if it has grown by GROWN */
#define MPM_GAP_LEFT 0.75 /* is warned of, if the deformation explains less, by the factor LAGGING */
#define MPM_GAP_PARTED                                                                                                 \
  1 /* has parted, if the deformation explains less by the factor LAGS: more nodes than particles */
#define MPM_GAP_GROWN   1.1
#define MPM_GAP_LAGGING 1.1
#define MPM_GAP_LAGS    1.3

/* The most of something among all particles: `value`, and of several with the same the least key. The key of a particle
   is 16 id + a code of the finder's; -1: none was found. */
typedef struct {
  PetscReal  value;
  PetscInt64 key;
  PetscReal  x[3];  /* of the particle, m */
  PetscReal  of[4]; /* numbers of the finder's */
} MPMFound;

/* Takes another finding if it is larger; makes those of all processes one, collective on the comm; prints the place of
   one, "(1, 2)". */
void           MPMFoundTake(MPMFound *, const MPMFound *);
PetscErrorCode MPMFoundAgree(MPMFound *, MPI_Comm);

/* What the watch knows of a run. Those that later steps depend on are in checkpoints. */
typedef struct {
  PetscReal  first, least, told; /* s: dt of the first step, the smallest so far, and at the last look for its cause */
  PetscReal  t;                  /* s: when dt was smallest */
  char       cause[3 * MPM_NAME_LEN]; /* what limits dt, where it has collapsed; else empty */
  PetscInt64 limits;                  /* the particle that does */
  PetscBool  may_part, may_leave;     /* -check_parting and -check_law are warn: such a run goes on */
  PetscInt   near;                    /* 0: no matter parts; 1: some may soon; 2: some does */
  PetscBool  torn;                    /* has the warning of matter that parts been printed? */
  PetscReal  torn_at;                 /* s: when neighbours were too far apart for the first time; -1: never */
  PetscInt   ranges, beyond;          /* bits of the rows of physics/range.def: of this scene; that were warned of */
  PetscReal  grows_at;                /* s: since when the energy grows without a cause; -1: it does not */
  PetscBool  stopped;                 /* has a check of the watch ended the run? */

  MPMNeighbours *neighbours; /* [nbodies]; NULL: matter that parts is not looked for */
} MPMWatch;

/* --- Of a run ------------------------------------------------------------------------------------------------------
   */

typedef struct _p_MPM *MPM;

/* Read -check_parting and -check_law; make what the watch needs, before the grid is cut; free it. Collective on
   core.comm. */
PetscErrorCode MPMWatchSetFromOptions(MPM, MPMOptions);
PetscErrorCode MPMWatchSetUp(MPM);
PetscErrorCode MPMWatchDestroy(MPM);

/* Watch a run (watch.c): a time step dt in s that collapses, before the step; bodies that do not rest in the stress by
   their weight, after the first step; matter that parts and laws that leave their range, after some steps, of which a
   reason to stop is left in core.stop; and what is to be said at the end. Collective on exchange.data. */
PetscErrorCode MPMWatchStep(MPM, PetscReal dt);
PetscErrorCode MPMWatchShort(MPM, PetscReal dt); /* says in core.stop why dt is too short to go on */
PetscErrorCode MPMWatchRest(MPM);
PetscErrorCode MPMWatchState(MPM,
                             PetscBool last); /* last: the run ends with this step, so it is looked at in any case */
PetscErrorCode MPMWatchEnd(MPM);

/* Looks for matter that parts: *near as in MPMWatch, and the largest values, of which those above 1 count. Collective
   on exchange.data. Crack (cracks.c) finds the largest value of the distances link [nlinks] that belong to a crack;
   Tell and Cure describe one, of matter that has parted or may, and name the remedy. */
PetscErrorCode MPMPartingLook(MPM, PetscInt *near, MPMFound *wide, MPMFound *parted);
PetscErrorCode MPMPartingCrack(MPM, PetscInt nlinks, const MPMFound link[], MPMFound *parted);
void           MPMPartingTell(MPM, const MPMFound *, PetscBool parted, char text[MPM_TEXT_LEN]);
void           MPMPartingCure(MPM, const MPMFound *, char text[MPM_TEXT_LEN]);

/* The rows of physics/range.def: the bits of those whose laws a scene has; a look at those of the run, which sets
   *beyond to the bits of those whose bound is passed, *lost to those of which the result means nothing, and most [] to
   the particle that is farthest beyond, with their number; and the words for one. The look is collective on
   exchange.data. */
#define MPM_MAX_RANGES 8
PetscInt       MPMRangesOf(const MPMScene *);
PetscErrorCode MPMRangesLook(MPM, PetscInt *beyond, PetscInt *lost, MPMFound most[]);
void           MPMRangesTell(MPM, PetscInt row, const MPMFound *, char text[MPM_TEXT_LEN]);
void           MPMRangesCure(MPM, PetscInt row, const MPMFound *, char text[MPM_TEXT_LEN]);

/* Appends to core.stop what was measured of the particle of a status, which ended the run, and the remedy for its case
   (cause.c). Collective on exchange.data. */
PetscErrorCode MPMCauseTell(MPM, const MPMStatus *);

#endif
