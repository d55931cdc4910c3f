/* scene.h - what is simulated: materials, bodies, walls, forces and known solutions. It is read from the options before
   the first step; during a step only the body forces and loads are evaluated. */
#ifndef MPM_SCENE_H
#define MPM_SCENE_H

#include "options/options.h"
#include "parallel/core.h"
#include "physics/start_state.h"
#include "known/reference.h"
#include "physics/region.h"
#include "physics/wall.h"
#include "scene/begin.h"

/* The file of a body's particles; see points.c. */
typedef struct _MPMPoints MPMPoints;

/* What was found of places that a surface cuts; see cut.c. */
typedef struct _MPMCutMemo MPMCutMemo;

/* Is a body matter, or does it move as a whole: not, by formulas of t, or as the matter and walls make it? */
typedef enum { MPM_RIGID_NONE, MPM_RIGID_FIXED, MPM_RIGID_MOVING, MPM_RIGID_FREE } MPMRigidType;

/* A body that flows in (source.c): its velocity, m/s, a unit vector along it, and its size; from when to when, s; the thickness
   of the layers in which it enters, m, how many there are in this time, and how many have entered; the numbers of the first
   particles of the rows of its lattice, and of the one after the last, once some have entered. */
typedef struct {
  PetscBool   on;
  PetscInt    layers, entered;
  PetscReal   v[3], along[3], speed, layer, from, to;
  PetscInt64 *ids;
} MPMSource;

/* A body: where its particles start, of what, how fast. */
typedef struct {
  char          name[MPM_NAME_LEN];
  MPMRegion     region;
  MPMPoints    *points;                 /* its particles are those of a file; or NULL */
  MPMSource     source;                 /* does it flow in? */
  PetscBool     removed;                /* it has left at a restart (-remove) */
  PetscBool     alone;                  /* a shape that cuts others, of material none, or rigid; it has no particles */
  PetscInt      copy;                   /* of the grid's nodes that its particles use */
  PetscInt      material, kind, ppc[3]; /* rows of the scene's materials and kinds; particles per cell on each axis */
  PetscReal     offset[3], b[3];        /* of the lattice of its particles: offset and spacing, m */
  MPMRigidType  rigid;
  PetscReal     mu, pivot[3]; /* of a rigid body: coefficient of friction; the point about which it turns, m */
  PetscBool     has_pivot, tied;
  PetscReal     rho, mass, inertia[3]; /* of a free one: kg/m^3, kg, kg m^2; 0: not given */
  MPMExpression spin;                  /* of a rigid body, rad/s, of t; NULL: it does not turn */
  MPMExpression velocity;              /* m/s, of x y z, of a rigid body of t; NULL: at rest */
  MPMExpression deformation;           /* F at the start, row-major, of x y z; NULL: undeformed */
  PetscReal     v2;                    /* largest squared speed of its particles at the start, m^2/s^2 */
  PetscInt64    first, n;              /* ids first .. first+n-1 */
  MPMCutMemo   *memo;                  /* of places that its surface cuts; NULL: its particles have whole places */
  PetscInt     *cut;                   /* kinds of its particles by the parts of a place that they have; see cut.c */
  PetscInt64    parts;                 /* of all of its particles */
  PetscBool     round;                 /* is it a body of revolution? */
  PetscInt64    column;                /* of these: the first column of its lattice, */
  PetscInt     *columns, ncolumns;     /* and kinds [ncolumns][9] by column and walls, or NULL; see at_walls.c */
  MPMKind      *rings;                 /* those of its cut places, until the scene's table has them; */
  PetscInt      ring, nrings;          /* there they are rows ring .. ring+nrings-1 (cut.c) */
  PetscInt64    row;                   /* the number of its first row of lattice places among those of all bodies */
} MPMBody;

/* A load on the surface of a body: a pressure against the deformed surface, or a traction per area of the surface at
   the start (forces.c); or one on its volume: a force, or a torque about a point (volume_loads.c). */
#define MPM_MOST_LOADS 30 /* of a scene with loads on volumes: bits of the field `chosen` */
typedef enum { MPM_LOAD_PRESSURE, MPM_LOAD_TRACTION, MPM_LOAD_FORCE, MPM_LOAD_TORQUE } MPMLoadType;
typedef struct {
  char          name[MPM_NAME_LEN];
  PetscInt      body; /* row of the scene's bodies */
  MPMLoadType   type;
  PetscInt      nc;    /* components of its value */
  MPMExpression value; /* Pa, of x y z X Y Z t; or N, N m, of t */
  PetscInt      sides; /* of a surface: bits 2d + side of the sides of axis d that it acts on */
  MPMExpression where; /* of a volume: it acts on the particles where this is positive, of X Y Z; NULL: on all */
  PetscBool     fixed; /* of a torque: it is about `point`, m, else about the centre of these particles */
  PetscReal     point[3];
  PetscInt64    n;          /* of a volume: the particles that it acts on at the start */
  PetscReal     moments[9]; /* of these: sums of x - x0 [3] and of its products [6], x0: the middle of the grid */
} MPMLoad;
MPM_INLINE PetscBool MPMLoadIsOnVolume(const MPMLoad *load)
{
  return load->type == MPM_LOAD_FORCE || load->type == MPM_LOAD_TORQUE;
}

/* The known solution of a scene; see known.c. */
typedef struct _MPMKnown MPMKnown;

/* Stresses or deformations at the start; see initial.c. */
typedef struct _MPMInitial MPMInitial;

typedef struct {
  char          title[MPM_TEXT_LEN], name[MPM_NAME_LEN];
  PetscBool     dry_run;
  PetscInt      ppc, ppc_gas; /* particles per cell and axis of bodies that do not say; set before the scene is read */
  MPMMaterial  *materials;
  PetscInt      nmaterials;
  MPMBody      *bodies;
  PetscInt      nbodies, nfilled, nshapes; /* bodies with particles, first those on a lattice; then shapes alone */
  MPMStart      start;                     /* begin.h */
  char          rim[MPM_NAME_LEN];         /* -method_rim, or "" */
  MPMCutMemo   *memo;                      /* of all bodies (cut.c) */
  PetscInt      ncut;                      /* bodies that cut places of their particles (cut.h) */
  MPMKind      *kinds;
  PetscInt      nkinds;
  MPMWalls      walls;
  MPMExpression wall_velocity[6]; /* of faces whose velocity is a formula: m/s, of t; else NULL */
  PetscBool     wall_along[6];    /* the velocity of a face is one number or formula, along its normal */
  MPMLoad      *loads;
  PetscInt      nloads, nvolume;     /* of these loads, those on volumes */
  MPMExpression acceleration;        /* body force per mass in m/s^2, of x y z X Y Z t; or NULL */
  MPMKnown     *known;               /* or NULL */
  MPMInitial   *initial;             /* or NULL: bodies start without stress */
  PetscBool     body_force;          /* a body force besides gravity acts on all particles */
  PetscBool     forced, keeps_start; /* are there body forces or loads; do particles have field X? */
  PetscInt64    shapes;              /* checksum of the surfaces that were read; 0: there are none */
  PetscBool     meets;               /* is there contact between bodies? */
  PetscInt64    overlap;             /* particles that lie in an earlier body too */
  PetscInt64    on_line;             /* particles that start exactly on a line of the grid */
  PetscInt64    behind;              /* particles that start behind a piston */
  PetscInt64    rows, *share_first;  /* rows of lattice places; [shares] particles before each of these shares */
  PetscMPIInt   shares;              /* of the rows, one for each process */

  PetscInt nprobes; /* names of the probes; what they show is left to the output */
  char (*probes)[MPM_NAME_LEN];
  PetscInt nstages; /* names of the stages */
  char (*stages)[MPM_NAME_LEN];
  PetscInt ncontacts; /* names of the contacts */
  char (*contacts)[MPM_NAME_LEN];
} MPMScene;

/* Reads grid, materials, bodies, walls, forces and known solution; the first fault is left in o. Collective on
   core->comm. The second function frees the scene; not collective. */
PetscErrorCode MPMSceneSetFromOptions(MPMScene *, MPMCore *, MPMOptions);
PetscErrorCode MPMSceneDestroy(MPMScene *);

/* Bodies of revolution (read_round.c): refuse what they do not have, after everything else of the scene is read; set the
   affine velocity C [dim*dim], 1/s, with which a particle at x [dim], m, of a body with a velocity starts. Not
   collective. */
PetscErrorCode MPMSceneCheckRound(MPMScene *, MPMCore *, MPMOptions);
PetscErrorCode MPMSceneStartAffine(const MPMCore *, const MPMBody *, const PetscReal x[], PetscReal C[]);

/* --- Walls (read_walls.c, move_walls.c), particles (fill.c) --------------------------------------------------------------------- */

PetscErrorCode MPMSceneReadWalls(MPMScene *, MPMCore *, MPMOptions);
PetscErrorCode MPMSceneReadWallVelocity(MPMScene *, const MPMCore *, PetscInt face, MPMOptions);
PetscErrorCode MPMSceneCheckWalls(const MPMScene *, MPMCore *, PetscReal t);
PetscErrorCode MPMSceneMoveWalls(MPMScene *, const MPMCore *, PetscReal t);
void           MPMScenePassWalls(MPMScene *, const MPMCore *, PetscReal dt);

/* Write where pistons have come to that they cannot pass: to core->stop; or before the run to `text`, with the time, by
   their velocities until the time end, s. They write nothing if there is no such place. Not collective. */
void           MPMSceneCheckPistons(const MPMScene *, MPMCore *);
PetscErrorCode MPMSceneForesee(const MPMScene *, const MPMCore *, PetscReal end, char text[MPM_TEXT_LEN]);
PetscErrorCode MPMSceneWallAdvances(const MPMScene *, const MPMCore *, PetscInt face, PetscReal end, PetscBool *);
PetscErrorCode MPMSceneCountParticles(MPMScene *, MPMCore *, MPMOptions);
PetscErrorCode MPMSceneAddParticles(const MPMScene *, MPMCore *);
PetscErrorCode MPMSceneHistogram(const MPMScene *, const MPMCore *, MPMHistogram *);

/* The same of particles that are read from files, after those of the functions before (points.c). */
PetscErrorCode MPMPointsCount(MPMScene *, MPMCore *, MPMOptions);
PetscErrorCode MPMPointsHistogram(const MPMScene *, const MPMCore *, MPMHistogram *);
PetscErrorCode MPMPointsAdd(const MPMScene *, MPMCore *);

/* Refuses bodies of files in contact whose particles overlap, once all are counted (overlap.c). Collective on core->comm. */
PetscErrorCode MPMPointsOverlap(const MPMScene *, MPMCore *, MPMOptions);

/* Contact (read_contacts.c): reads it, after the bodies, gives these copies of the grid's nodes, and makes core->contacts.
   A fault is left in the options. Not collective. */
PetscErrorCode MPMSceneReadContacts(MPMScene *, MPMCore *, MPMOptions);

/* Rigid bodies (read_rigid.c): read one; make those of core, after the contacts; let planes of symmetry hold a free one, or refuse
   it at a wall (hold_rigids.c); set their velocities of time t; refuse
   particles that start inside one. The last one is collective on core->comm. */
PetscErrorCode MPMSceneReadRigid(const MPMCore *, MPMOptions, MPMBody *);
PetscErrorCode MPMSceneMakeRigids(MPMScene *, MPMCore *, MPMOptions);
void           MPMSceneHoldRigid(const MPMScene *, const MPMCore *, MPMOptions, const MPMBody *, MPMRigid *);
PetscErrorCode MPMSceneMoveRigids(const MPMScene *, MPMCore *, PetscReal t);
PetscErrorCode MPMSceneEvaluateRigids(const MPMScene *, PetscInt dim, PetscReal t, MPMRigid body[]);
PetscErrorCode MPMSceneCheckInside(const MPMCore *, MPMOptions, const MPMBody *, const PetscReal x[]);
PetscErrorCode MPMSceneCheckRigids(const MPMScene *, MPMCore *, PetscReal t);

/* Finds when rigid bodies that move by formulas pass through others until the time end, s, or leave the grid, and says so;
   sets core->rigids.meet (foresee_rigids.c). Not collective. */
PetscErrorCode MPMSceneForeseeRigids(const MPMScene *, MPMCore *, PetscReal end);

/* Returns the number of the body that particle id belongs to; guess: of one, such as that of the particle before. Not
   collective. */
PetscInt MPMBodyOf(const MPMScene *, PetscInt64 id, PetscInt guess);

/* Sets *nothing to whether the `cut`-th shape that cuts a body removes none of its particles (read_region.c). Not
   collective. */
PetscErrorCode MPMSceneCutsNothing(const MPMBody *, PetscInt dim, PetscInt cut, PetscBool *nothing);

/* --- Initial states (initial.c) ----------------------------------------------------------------------------------- */

/* Read the options; a fault is left in them; tell what they say. Where scene->initial is set: compute the state in which the particle of a
   body with lattice place X [dim], m, starts, or say in `wrong` why it cannot be; set it as particle p of a view. Not
   collective. */
PetscErrorCode MPMInitialSetFromOptions(MPMScene *, const MPMCore *, MPMOptions);
void           MPMInitialTell(const MPMScene *, char text[MPM_TEXT_LEN]);
PetscReal      MPMInitialGravity(const MPMScene *);
PetscErrorCode MPMInitialDestroy(MPMScene *);
PetscErrorCode MPMInitialState(const MPMScene *, const MPMCore *, const MPMBody *, const PetscReal X[],
                               MPMMaterialStart *, char wrong[MPM_TEXT_LEN]);
PetscErrorCode MPMInitialSet(const MPMScene *, const MPMCore *, const MPMBody *, const PetscReal X[], PetscInt p,
                             MPMView *);

/* --- Known solutions (known.c) ------------------------------------------------------------------------------------ */

PetscErrorCode MPMKnownSetFromOptions(MPMScene *, const MPMCore *, MPMOptions);
PetscErrorCode MPMKnownDestroy(MPMScene *);
PetscBool      MPMKnownStarts(const MPMScene *);
PetscBool      MPMKnownStart(const MPMScene *, PetscInt dim, const PetscReal X[], PetscReal x[], PetscReal v[],
                             PetscReal F[]);
void           MPMKnownForce(const MPMScene *, PetscInt dim, const PetscReal X[], PetscReal t, PetscReal b[]);
PetscErrorCode MPMKnownError(const MPMScene *, MPMCore *, PetscReal *error, PetscReal *size);

/* --- Body forces and loads (forces.c); not collective, but for MPMForcesUpdate: on exchange.data ------------------- */

PetscErrorCode MPMForcesSetFromOptions(MPMScene *, const MPMCore *, MPMOptions);
PetscErrorCode MPMForcesTangent(const MPMScene *, const MPMCore *, MPMView *, PetscInt p, PetscReal t, PetscReal S[],
                                PetscReal B[], PetscReal P[], PetscBool *any);
PetscErrorCode MPMForcesUpdate(const MPMScene *, MPMCore *, PetscReal t);
PetscErrorCode MPMForcesCheck(const MPMScene *, const MPMCore *, MPMOptions, const PetscReal x[], const PetscReal X[]);
PetscErrorCode MPMForcesAdd(const MPMScene *, const MPMCore *, const MPMLoad *, const MPMView *, PetscReal t,
                            MPMSum sum[], PetscReal lower[], PetscReal upper[]);
PetscErrorCode MPMForcesDestroy(MPMScene *);

/* Loads on volumes (volume_loads.c): count a particle of body b at X [dim], m, for the loads that act on it; refuse loads
   that act on no particle, or that these particles cannot take (collective on core->comm); return the loads that act on
   a particle, as bits (with options, a formula that is not finite is a fault); and what all of them are at time t, s, as a force per volume. MPMVolumeLoadsSum is collective on
   exchange.data, the others are not. */
typedef struct {
  PetscReal even[3], turn[3], centre[3]; /* N/m^3, N/m^4, m: the force per volume is even + turn x (x - centre) */
} MPMVolumeLoad;
PetscErrorCode MPMVolumeLoadsCount(MPMScene *, const MPMCore *, const MPMBody *, const PetscReal X[], MPMOptions);
PetscErrorCode MPMVolumeLoadsCheck(MPMScene *, const MPMCore *, MPMOptions);
PetscErrorCode MPMVolumeLoadsOn(const MPMScene *, const MPMCore *, const MPMBody *, const PetscReal X[], MPMOptions,
                                PetscInt *bits);
PetscErrorCode MPMVolumeLoadsSum(const MPMScene *, MPMCore *, PetscReal t, MPMVolumeLoad loads[]);
void MPMVolumeLoadsAdd(const MPMScene *, const MPMVolumeLoad loads[], PetscInt dim, PetscInt bits, const PetscReal x[],
                       PetscReal volume, PetscReal f[]);

#endif
