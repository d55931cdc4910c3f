/* measures.h - columns of the history that one asks for: what walls give, sums of bodies, probes. They stand after
   those of diagnostics.def, and are computed for each line of the history alone. */
#ifndef MPM_MEASURES_H
#define MPM_MEASURES_H

#include "results/diagnostics.h"

/* A column: its name, its unit, and whether it has whole numbers. */
typedef struct {
  char        name[2 * MPM_NAME_LEN];
  const char *unit;
  PetscBool   whole;
} MPMMeasure;

/* A probe: it stays at a place, or goes with a particle. */
typedef struct {
  char       name[MPM_NAME_LEN];
  PetscBool  stays, follows; /* at `x`; with the particle that is nearest to `x` as the run starts */
  PetscReal  x[3];
  PetscInt64 id;     /* of its particle; < 0: not known yet */
  PetscInt64 fields; /* bits of rows of MPMDiagnostics */
  PetscInt   first;  /* its first column */
  PetscBool  told;   /* that its particle has left the grid */
  PetscBool  seen;   /* has it ever shown a value? */
} MPMProbe;

typedef struct {
  PetscInt    n; /* columns */
  MPMMeasure *column;
  PetscReal  *value;       /* [n] in the last line */
  PetscInt    faces;       /* -history_walls, as bits 2 axis + side */
  PetscInt    nbodies;     /* -history_bodies: */
  PetscInt   *body;        /* [nbodies] rows of the scene's bodies */
  PetscInt    quantities;  /* -history_body_quantities, as bits */
  PetscInt    first_body;  /* its first column */
  PetscBool   heat;        /* the dissipation of bodies is one of them */
  PetscInt    nrigids;     /* the rigid ones of -history_bodies: */
  PetscInt   *rigid;       /* [nrigids] numbers in core->rigids */
  PetscInt    first_rigid; /* their first column */
  PetscInt    nprobes;     /* -probes */
  MPMProbe   *probe;       /* [nprobes] */
  PetscInt64 *ids;         /* [nprobes] of their particles, as a checkpoint keeps them */
  PetscInt64  shown;       /* bits of the rows of MPMDiagnostics that bodies and probes show */
} MPMMeasures;

/* Reads the options, makes the columns, and lets the step sum what they need; the second function does what needs the
   numbers of the particles, or comes after what is wrong with bodies. The first fault is left in o. Not collective. */
PetscErrorCode MPMMeasuresSetFromOptions(MPMMeasures *, const MPMScene *, MPMCore *, MPMOptions);
void           MPMMeasuresNumber(const MPMMeasures *, const MPMScene *, MPMCore *, MPMOptions);
PetscErrorCode MPMMeasuresDestroy(MPMMeasures *);

/* Adds a column, whose name is the words a, b and, if it is not empty, c, joined by "_"; and returns the number of the
   column of a name, or -1 (columns.c). Not collective. */
PetscErrorCode MPMMeasuresAdd(MPMMeasures *, const char a[], const char b[], const char c[], const char unit[],
                              PetscBool whole);
PetscInt       MPMMeasuresFind(const MPMMeasures *, const char name[]);

/* Computes the values of all columns. A line of the history has them, which then ends with the second function. Both
   are collective on exchange.data. */
PetscErrorCode MPMMeasuresCompute(MPMMeasures *, MPMCore *, const MPMScene *);
void           MPMMeasuresLine(MPMMeasures *, MPMCore *);

/* Rigid bodies (rigids.c): add the columns of those in m->rigid, and compute these. Not collective. */
PetscErrorCode MPMRigidsAddColumns(MPMMeasures *, const MPMCore *);
void           MPMRigidsCompute(MPMMeasures *, const MPMCore *);

/* Bodies (bodies.c) and probes (probes.c): read their options and add their columns, and compute these. The first is
   not collective, the others are on exchange.data. */
PetscErrorCode MPMBodiesSetFromOptions(MPMMeasures *, const MPMScene *, MPMCore *, MPMOptions);
PetscErrorCode MPMBodiesCompute(MPMMeasures *, MPMCore *, const MPMScene *);
PetscErrorCode MPMProbesSetFromOptions(MPMMeasures *, const MPMScene *, MPMCore *, MPMOptions);
PetscErrorCode MPMProbesCompute(MPMMeasures *, MPMCore *, const MPMScene *);

#endif
