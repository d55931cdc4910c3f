/* watch.h - the bounds beyond which something is told, and what is watched while a run runs: watch.c (time step, rest),
   parting.c (matter that parts), ranges.c (laws out of their range), cause.c (why a run stopped). */
#ifndef MPM_WATCH_H
#define MPM_WATCH_H

#include "results/output.h"
#include "scene/neighbours.h"
#include "step/step.h"

/* Matter that parts is looked for after every 64th step; where neighbours are far from each other, after every 16th,
   and where their deformation does not explain it, after every 8th. Laws are looked at after every 16th. These are
   numbers of steps, so that they are the same after a restart. */
#define MPM_WATCH_FAR   64
#define MPM_WATCH_NEAR  16
#define MPM_WATCH_PARTS 8
#define MPM_WATCH_LAWS  16

/* The bounds beyond which something is told, as constants MPM_BOUND_<name>. Each has a source. */
#define MPM_BOUND(name, value, unit, what, source)                                                                     \
  static const PetscReal MPM_BOUND_##name = value;                                                                     \
  _Static_assert(sizeof unit > 1 && sizeof what > 1 && sizeof source > 1, "a bound without unit or source");
#include "advice/bounds.def"

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
  PetscReal  courant, wave;      /* the largest dt (c + |v|)/h and dt c/h of the run */
  char       cause[3 * MPM_NAME_LEN]; /* what limits dt, where it has collapsed; else empty */
  PetscInt64 limits;                  /* the particle that does */
  PetscBool  may_part, may_leave;     /* a run goes on whose matter parts, or whose laws leave their range */
  PetscBool  may_cut;                 /* -check_parting is auto, and then, MPMWatchSetUp: a rigid body may cut matter */
  PetscInt   near;                    /* 0: no matter parts; 1: some may soon; 2: some does */
  PetscBool  torn;                    /* has the warning of matter that parts been printed? */
  PetscReal  torn_at;                 /* s: when neighbours were too far apart for the first time; -1: never */
  PetscInt   ranges, beyond;          /* bits of the rows of physics/range.def: of this scene; that were warned of */
  PetscReal  grows_at;                /* s: since when the energy grows without a cause; -1: it does not */
  PetscBool  stopped;                 /* has a check of the watch ended the run? */

  /* Of the total frame (meet.c): how far the fastest particle may have come since the last look, m; which walls hold
     which bodies, and which bodies are joined; what has been told. */
  PetscReal  moved;
  PetscBool *held, *joined; /* [nbodies][6]; [nbodies][nbodies] */
  PetscBool  joins, passed, squeezed;
  PetscBool  refused;           /* is core.stop a fault of the scene? */
  char       use[MPM_NAME_LEN]; /* the options by which the scene would run in the updated frame */

  MPMNeighbours *neighbours; /* [nbodies]; NULL: matter that parts is not looked for */
} MPMWatch;

/* Read -check_parting and -check_law; make what the watch needs, before the grid is cut; free it. The second function
   is collective on core.comm. */
PetscErrorCode MPMWatchSetFromOptions(MPMWatch *, MPMOptions);
PetscErrorCode MPMWatchSetUp(MPMWatch *, const MPMCore *, const MPMScene *);
PetscErrorCode MPMWatchDestroy(MPMWatch *, const MPMScene *);

/* Watch a run (watch.c): a time step dt in s that collapses, before the step; bodies that do not rest in the stress by
   their weight, after the first step; matter that parts and laws that leave their range, after some steps and at the
   end, of which a reason to stop is left in core.stop; and what is to be said at the end. MPMWatchShort says in
   core.stop why dt is too short to go on. Collective on exchange.data. */
PetscErrorCode MPMWatchStep(MPMWatch *, MPMCore *, const MPMScene *, const MPMTime *, PetscReal dt);
PetscErrorCode MPMWatchShort(MPMWatch *, MPMCore *, const MPMScene *, const MPMMethod *, const MPMTime *, PetscReal dt);
PetscErrorCode MPMWatchRest(MPMCore *, const MPMScene *);
PetscErrorCode MPMWatchState(MPMWatch *, MPMCore *, const MPMScene *, const MPMMethod *, const MPMTime *,
                             const MPMMonitor *);
PetscErrorCode MPMWatchEnd(const MPMWatch *, const MPMPrinter *);

/* Looks for matter that parts: *near as in MPMWatch, and the largest values, of which those above 1 count. Collective
   on exchange.data. Crack (cracks.c) finds the largest value of the distances link [nlinks] that belong to a crack;
   Tell and Cure describe one, of matter that has parted or may, and name the remedy. */
PetscErrorCode MPMPartingLook(MPMCore *, const MPMScene *, const MPMNeighbours[], PetscInt *near, MPMFound *wide,
                              MPMFound *parted);
PetscErrorCode MPMPartingCrack(const MPMCore *, const MPMScene *, const MPMNeighbours[], PetscInt nlinks,
                               const MPMFound link[], MPMFound *parted);
void           MPMPartingTell(const MPMWatch *, const MPMCore *, const MPMScene *, const MPMFound *, PetscBool parted,
                              char text[MPM_TEXT_LEN]);
void           MPMPartingCure(const MPMScene *, PetscInt dim, const MPMFound *, char text[MPM_TEXT_LEN]);

/* Of the total frame (meet.c): finds, when particles are made and a restart is read, which bodies are joined or held, and
   leaves in core.stop which of them do not touch; looks after a step whether bodies have met each other or a wall, which it
   leaves in core.stop. Collective on exchange.data. MPMMeetDestroy frees what is kept. */
PetscErrorCode MPMMeetBegin(MPMWatch *, MPMCore *, const MPMScene *);
PetscErrorCode MPMMeetLook(MPMWatch *, MPMCore *, const MPMScene *, PetscBool last);
PetscErrorCode MPMMeetDestroy(MPMWatch *);

/* The rows of physics/range.def: the bits of those whose laws a scene has; a look at those of a set of bits, `asked`,
   which sets *beyond to the bits of those whose bound is passed, *lost to those of which the result means nothing, and
   most [] to the particle that is farthest beyond, with their number; and the words for one. The look is collective on
   exchange.data. */
#define MPM_MAX_RANGES 8
PetscInt       MPMRangesOf(const MPMScene *);
PetscErrorCode MPMRangesLook(MPMCore *, PetscInt asked, PetscInt *beyond, PetscInt *lost, MPMFound most[]);
void           MPMRangesTell(const MPMScene *, PetscInt dim, PetscInt row, const MPMFound *, char text[MPM_TEXT_LEN]);
void           MPMRangesCure(const MPMScene *, PetscInt row, const MPMFound *, char text[MPM_TEXT_LEN]);

/* Appends to core.stop what was measured of the particle of a status, which ended the run, and the remedy for its case
   (cause.c). Collective on exchange.data. */
PetscErrorCode MPMCauseTell(const MPMWatch *, MPMCore *, const MPMScene *, const MPMMethod *, const MPMTime *,
                            const MPMStatus *);

/* Returns whether by now noise has grown by the method, as far as the table of stable methods tells; writes that, and
   the options of a stable one (method_warnings.c). Not collective. */
PetscBool MPMMethodAmplifies(const MPMCore *, const MPMMethod *, const MPMTime *, const MPMWatch *,
                             char what[MPM_TEXT_LEN], char options[MPM_TEXT_LEN]);

/* Returns whether all that changes the energy is summed, in any run (report_energy.c). Not collective. */
PetscBool MPMEnergyIsFollowed(const MPMCore *, const MPMScene *);

#endif
