/* static.h - steps of a load without inertia (-method_time static): each finds the displacements of the nodes of the total
   frame at which internal forces, loads and gravity are in equilibrium, by PETSc's SNES. docs/method.md has the equations
   (Statics). */
#ifndef MPM_STATIC_H
#define MPM_STATIC_H

#include <petscsnes.h>
#include "scene/scene.h"

struct MPMStatic {
  PetscReal ramp;  /* -gravity_ramp: gravity grows linearly over this time, s; 0: it acts at once */
  PetscReal ghost; /* -method_stabilize_factor, 1; 0: none */
  PetscReal fill;  /* -method_stabilize_fill: nodes with a smaller share of matter are weak */
  PetscBool plastic, symmetric; /* of all laws of the scene */

  /* The unknowns: the displacements of own nodes that have mass, [n][dim], in the order of the patch's rows. */
  PetscInt   n;
  PetscInt  *node;  /* [n] the node, in the patch's arrays */
  PetscInt  *at;    /* [nodes of `numbers` here] number of the node's unknowns over dim, -1: it has none */
  DM         numbers; /* the nodes of the grid, one number each, with ghosts on both sides */
  PetscInt   lo[3], wide[3]; /* the box of nodes that `at` covers */
  PetscBool *held;  /* [n][dim] does a wall hold it? */
  PetscReal *known; /* [n][dim] where a wall holds it at the end of the step, m */
  SNES       snes;
  Mat        K, ghosts; /* the tangent; the stabilisation, N/m, which is constant */
  Vec        u, r, was, work; /* displacements; residual, N; displacements as the step begins */
  PetscReal  scale;     /* of the step: norm of the forces in equilibrium, N */
  PetscReal  least;     /* N: a norm of this size is rounding */
  PetscReal  residual;  /* of the last solve, N */

  const MPMScene *scene;
  MPMCore        *core;
  PetscReal       share; /* of gravity at the end of this step */
  PetscBool       bad;   /* the last trial state was turned inside out */
  PetscInt        solve, tangent; /* timers */
  PetscInt        newton, krylov, solves, failed; /* of all steps since the start of this program */
};

/* Reads -gravity_ramp and -method_stabilize*; faults are left in the options. Create follows the set-up of particles and
   nodes, and is collective on exchange.data, as is Destroy; Step makes a step from core->t over params.dt: if there is no
   equilibrium, core->stop says why, and the particles are those before it. Report prints what the steps cost. */
PetscErrorCode MPMStaticSetFromOptions(MPMCore *, const MPMScene *, PetscReal end, MPMOptions);
PetscErrorCode MPMStaticCreate(MPMCore *, const MPMScene *);
PetscErrorCode MPMStaticStep(MPMCore *);
PetscErrorCode MPMStaticPrint(const MPMCore *); /* the line of the solver, before the first step */
PetscErrorCode MPMStaticReport(const MPMCore *);
PetscErrorCode MPMStaticDestroy(MPMCore *);

/* The unknowns and the matrices (static_matrix.c): Tangent sets K to the tangent of the state that the residual was last made
   of, with the rows and columns of what walls hold replaced; if x has displacements of these, what they do to the others
   is taken from b. The particles are those as the step began afterwards. Collective on exchange.data. */
PetscErrorCode MPMStaticNumber(struct MPMStatic *);
PetscErrorCode MPMStaticStabilise(struct MPMStatic *);
PetscErrorCode MPMStaticTangent(struct MPMStatic *, Mat K, Vec x, Vec b);

#endif
