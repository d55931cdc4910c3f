/* unlikely.h - what the functions of the rows of plausible.def get, and what they find. */
#ifndef MPM_UNLIKELY_H
#define MPM_UNLIKELY_H

#include "advice/advice.h"

#define MPM_WORDS 160
/* The way of a body until it meets something (unlikely_ways.c): it leaves the grid through `face`, else -1, at time t, s; or it
   meets nothing until the end, though it has moved by so many cells, and the nearest thing was so many cells away. */
typedef struct {
  PetscInt  face, thing;
  PetscBool alone;
  PetscReal t, moved, gap;
  char      nearest[MPM_WORDS];
} MPMWay;

/* A scene, as the rows look at it. */
typedef struct {
  const MPMCore    *core;
  const MPMScene   *scene;
  const MPMTime    *time;
  const MPMMonitor *monitor;
  PetscReal         seconds, dt;      /* that the run is predicted to take; the first step, s */
  PetscReal         steps;            /* until the end */
  PetscReal         g;                /* size of gravity, m/s^2 */
  PetscBool         earth;            /* it is the earth's in m/s^2, so that units are SI */
  PetscInt          down;             /* the axis along which gravity is largest */
  PetscReal         c;                /* the fastest wave, m/s */
  PetscReal (*lower)[3], (*upper)[3]; /* [nbodies + nshapes] m: how far the boxes of their particles, and the shapes of
                                         rigid bodies, reach at the start */
  PetscReal lowest[3], highest[3];    /* m, of all of them */
  MPMWay   *way;                      /* [nbodies + nshapes] */
} MPMLook;

/* What is unlikely: the ratio, and the words of the note. */
typedef struct {
  PetscReal ratio;
  char      option[MPM_WORDS], value[MPM_WORDS], other[MPM_WORDS], meant[MPM_WORDS];
} MPMOdd;

/* A formula of the scene; NULL: there is none. Of body (-1: of none), nc components; the option, as for MPMUnlikelyGiven. */
typedef struct {
  MPMExpression value;
  PetscInt      nc, body;
  const char   *group, *name, *word;
} MPMFormula;

/* The functions of rows: each looks at material, body, load, face ... k, and returns false if the row is not of it. */
typedef PetscBool MPMUnlikely(const MPMLook *, PetscInt k, MPMOdd *);
#define MPM_UNLIKELY(name, of, side, bound, source, text) MPMUnlikely MPMUnlikely_##name;
#include "advice/plausible.def"
#undef MPM_UNLIKELY

/* Sets odd->option to -<group>_<name><word>, name NULL: -<group><word>, and odd->value to what was given. Returns whether
   it was. MPMUnlikelyNumber also reads it as one number; other texts are none. MPMUnlikelyOver sets the ratio to that number
   of an option over a measure, which has to be above 0, and odd->other to the measure. Is -method_time static given? */
PetscBool MPMUnlikelyGiven(const char group[], const char *name, const char word[], MPMOdd *);
PetscBool MPMUnlikelyNumber(const char group[], const char *name, const char word[], MPMOdd *, PetscReal *number);
PetscBool MPMUnlikelyOver(const char option[], PetscReal measure, MPMOdd *);
PetscBool MPMUnlikelyStatic(MPMOdd *);

/* Reads the velocity of body k at the start, if it is given by numbers. */
PetscBool MPMUnlikelyVelocity(const MPMLook *, PetscInt k, MPMOdd *, PetscReal v[9]);

/* Writes a number for a text, with three digits, or appends one, after a comma; that a thousand times the value is meant. */
void MPMUnlikelyWrite(char text[MPM_WORDS], PetscReal);
void MPMUnlikelyThousand(MPMOdd *);
void MPMUnlikelyAppend(char text[MPM_WORDS], int digits, PetscReal);

/* Return the type of the wall of a face; how many cells the particles of body k, or of all (k < 0), are from the face. Sets
   the place x of number j among n on each axis of a box; returns false beyond the last. */
MPMWall   MPMUnlikelyWall(const MPMLook *, PetscInt face);
PetscReal MPMUnlikelyBeside(const MPMLook *, PetscInt k, PetscInt face);
PetscBool MPMUnlikelyPlace(PetscInt dim, const PetscReal lower[], const PetscReal upper[], PetscInt n, PetscInt j,
                           PetscReal x[3]);

/* Return how many cells two boxes are apart along axis d, below 0 where they overlap, and along any; how far a wall or a
   rigid body has come at the end along component c of a velocity, which without a formula is constant, to the side of
   toward (1 or -1), m, and at most. Is this the start of a run of its own; does a source bring more of the matter of body
   k? */
PetscReal MPMUnlikelyApart(const MPMLook *, PetscInt d, const PetscReal lower_a[], const PetscReal upper_a[],
                           const PetscReal lower_b[], const PetscReal upper_b[]);
PetscReal MPMUnlikelyGap(const MPMLook *, const PetscReal lower_a[], const PetscReal upper_a[],
                         const PetscReal lower_b[], const PetscReal upper_b[]);
PetscReal MPMUnlikelyAdvance(const MPMLook *, MPMExpression velocity, PetscInt c, PetscReal constant, PetscReal toward,
                             PetscReal *most);
PetscBool MPMUnlikelyStarts(const MPMLook *);
PetscBool MPMUnlikelyFed(const MPMLook *, PetscInt k);

/* Return the largest extent of the bodies of material m, or of all (m < 0), along axis d or, below 0, along any, m; the stress by
   the weight of the highest body of a material, Pa, or 0 if gravity is told to be in another unit; the modulus of a material for
   its fastest waves, and Young's, Pa. */
PetscReal MPMUnlikelyExtent(const MPMLook *, PetscInt m, PetscInt d);
PetscReal MPMUnlikelyWeight(const MPMLook *, PetscInt m);
PetscReal MPMUnlikelyModulus(const MPMMaterial *, PetscBool young);
PetscReal MPMUnlikelyCohesion(const MPMMaterial *); /* as it was given, Pa; 0: none */
PetscBool MPMUnlikelyTonnes(const MPMMaterial *);   /* is it in t/mm^3 and N/mm^2, by its density and its waves? */
PetscReal MPMUnlikelyEnd(const MPMLook *);          /* of all stages, s */
PetscBool MPMUnlikelyGravity(const MPMCore *, const MPMScene *); /* is gravity told to be in another unit? */

/* Return how many formulas there may be, the k-th one, first those of the loads, how large it is at any place and time of
   the run, how large its largest component is at a time and some places, with its sign, whether its size is the same at
   all times after the first hundredth, and whether it is one of t (unlikely_formulas.c). Find the ways of bodies
   (unlikely_ways.c). Note numbers that are not usual (usual.c). Not collective. */
PetscInt       MPMUnlikelyFormulas(const MPMLook *);
MPMFormula     MPMUnlikelyFormula(const MPMLook *, PetscInt k);
PetscReal      MPMUnlikelySize(const MPMLook *, const MPMFormula *);
PetscReal      MPMUnlikelyAt(const MPMLook *, const MPMFormula *, PetscReal t);
PetscBool      MPMUnlikelySteady(const MPMLook *, const MPMFormula *);
PetscBool      MPMUnlikelyChanges(const MPMLook *, PetscInt k);
PetscErrorCode MPMUnlikelyWays(const MPMLook *, MPMWay way[]);
PetscErrorCode MPMUsualNote(const MPMLook *);

#endif
