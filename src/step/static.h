/* static.h - steps of a load without inertia (-method_time static): each finds the displacements of the nodes of the total
   frame at which internal forces, loads and gravity are in equilibrium, by PETSc's SNES. docs/method.md has the equations
   (Statics). */
#ifndef MPM_STATIC_H
#define MPM_STATIC_H

#include <petscsnes.h>
#include "scene/scene.h"
#include "step/step.h"

/* A run of neighbouring nodes with springs: the place of the first among `at`, from one to the next, bits of those that are
   own, N/m. */
typedef struct {
  PetscInt  first, next, own;
  PetscReal stiffness;
} MPMStaticRun;

struct MPMStatic {
  PetscReal ramp;      /* -gravity_ramp: gravity grows linearly over this time, s; 0: it acts at once */
  PetscReal ghost;     /* -method_stabilize_factor, 1; 0: none */
  PetscReal most;      /* -dt_strain: the most that leap may be, 1 */
  PetscReal fill;      /* -method_stabilize_fill: nodes with a smaller share of matter are weak */
  PetscBool searches;  /* a law is plastic: a solve that fails is made again with shortened steps of Newton */
  PetscBool inertia;   /* -method_time euler or newmark */
  PetscBool stale;     /* particles of the updated frame have moved since the unknowns were found */
  PetscBool checked;   /* the options of PETSc's solvers have been looked at */
  PetscBool symmetric; /* the tangents of all laws */

  /* The unknowns: the displacements of own nodes that have mass, or on which a strain depends, [n][dim], in the order of the
     patch's rows. */
  PetscInt      n;
  PetscInt     *node;           /* [n] the node, in the patch's arrays */
  PetscInt     *at;             /* [nodes of `numbers` here] number of the node's unknowns over dim, -1: it has none */
  DM            numbers;        /* the nodes of the grid, one number each, with ghosts on both sides */
  PetscInt      lo[3], wide[3]; /* the box of nodes that `at` covers */
  PetscInt      nruns;
  MPMStaticRun *run;      /* [nruns] in a sequence that for each node is the same however the grid is cut */
  PetscBool    *pressed;  /* [n][dim] is it held for now (MPMStaticPress)? NULL: no wall pushes */
  PetscBool    *held;     /* [n][dim] does a wall hold it? */
  PetscReal    *known;    /* [n][dim] where a wall holds it at the end of the step, m */
  Vec           bound[2]; /* of displacements, by walls that only push, m; NULL: there are none */
  SNES          snes;
  Mat           K, ghosts;       /* the tangent; the stabilisation, N/m, which is constant, NULL: there is none */
  Mat           M;               /* the masses, kg, of steps with inertia; NULL: they have none */
  Vec           u, r, was, work; /* displacements; residual, N; displacements as the step begins */
  Vec           v, past;         /* velocities and forces as the step begins, m/s, N, of steps with inertia */
  PetscReal     beta, gamma;     /* of Newmark's steps: -method_gamma/2 and that; of Euler's 1 and 0 */
  PetscReal     per, held_over;  /* of this step: 1/(beta dt^2), and the share of past in the inertial forces */
  PetscReal     nominal;         /* a large entry of K, N/m */
  PetscReal grain; /* N/m: all entries are multiples, so that their sums are exact in any sequence; 0: they are not */
  PetscReal scale; /* norm of all forces on nodes in the last state that was tried, those of walls among them, N */
  PetscReal norm;  /* of the residual of that state, N, the same bits on any number of processes */
  PetscReal stiff, least; /* Pa, the largest modulus; N: a norm of this size is rounding */
  PetscReal residual;     /* of the last solve, N */

  const MPMScene *scene;
  const MPMTime  *time;
  MPMCore        *core;
  PetscReal       leap;                           /* the largest component of the displacement gradient of the step */
  PetscReal       share;                          /* of gravity at the end of this step */
  PetscBool       bad;                            /* the last trial state was turned inside out */
  PetscInt        solve, tangent;                 /* timers */
  PetscInt        newton, krylov, solves, failed; /* of all steps since the start of this program */
  PetscLogDouble  began;                          /* when the first solve did, s */
};

/* Reads -gravity_ramp and -method_stabilize*; faults are left in the options. Create follows the set-up of particles and
   nodes, and is collective on exchange.data, as are Renew and Destroy. Renew finds the masses as a step of the updated frame
   begins and, if particles have moved, unknowns, springs and solver. Step makes a step from core->t over params.dt: if there is no
   equilibrium, core->stop says why, and the particles are those before it. CheckOptions says there which option of PETSc's
   solvers nothing has read, once the first solve has read what it takes. Report prints what the steps cost. */
PetscErrorCode MPMStaticSetFromOptions(MPMCore *, const MPMScene *, const MPMTime *, MPMOptions);
PetscErrorCode MPMStaticCreate(MPMCore *);
PetscErrorCode MPMStaticRenew(struct MPMStatic *);
PetscErrorCode MPMStaticStep(MPMCore *);
PetscErrorCode MPMStaticCheckOptions(MPMCore *);
PetscErrorCode MPMStaticPrint(const MPMCore *); /* the line of the solver, before the first step */
PetscErrorCode MPMStaticReport(const MPMCore *);
PetscErrorCode MPMStaticDestroy(MPMCore *);

/* Memory (static_memory.c), bytes: of the matrices, of all processes or of this one; about what PETSc's preconditioner will take
   on all processes; what it has taken, if that is known; and about what this process will need beside what it has before the
   first step. Collective on exchange.data. */
PetscErrorCode MPMStaticMatrixBytes(const struct MPMStatic *, PetscBool all, PetscReal *);
PetscErrorCode MPMStaticForetellBytes(const struct MPMStatic *, PetscReal *);
PetscErrorCode MPMStaticSolverBytes(const struct MPMStatic *, PetscReal *, PetscBool *known);
PetscErrorCode MPMStaticLaterBytes(const struct MPMStatic *, PetscReal *);

/* The nodes of a particle's stencil: their weights and gradients, 1 and 1/m, and the numbers of their unknowns. */
#define MPM_STATIC_NODES (MPM_MAX_STENCIL * MPM_MAX_STENCIL * MPM_MAX_STENCIL)
typedef struct {
  PetscInt  n, base[3], number[MPM_STATIC_NODES];
  PetscReal w[MPM_STATIC_NODES], g[MPM_STATIC_NODES][3], r; /* r: the particle's radius in bodies of revolution, m */
} MPMStaticNodes;

/* The unknowns (static_nodes.c). Number finds them and makes vectors and the tangent's matrix. Stencil sets the nodes of
   particle p of a view, which has X, kind and l. Where gives the place ijk [3] in the grid of own unknown q, and Place where a
   node is among s->at. Spread sets value, as long as that, to own [n], a number of each own unknown, also where
   other processes have them, and to `none` elsewhere. CreateMatrix has room for nodes within `reach` on all axes and for those
   within Order along one: the order of the difference of the stabilisation, one above that of the basis. Number, Spread
   and CreateMatrix are collective on exchange.data. */
PetscErrorCode MPMStaticNumber(struct MPMStatic *);
void           MPMStaticStencil(const struct MPMStatic *, const MPMView *, PetscInt p, MPMStaticNodes *);
void           MPMStaticWhere(const struct MPMStatic *, PetscInt q, PetscInt ijk[]);
PetscInt       MPMStaticPlace(const struct MPMStatic *, const PetscInt ijk[]);
PetscErrorCode MPMStaticSpread(struct MPMStatic *, const PetscReal own[], PetscReal none, PetscReal value[]);
PetscInt       MPMStaticOrder(const struct MPMStatic *);
PetscErrorCode MPMStaticCreateMatrix(struct MPMStatic *, PetscInt reach, Mat *);

/* The matrices: Stabilise (static_ghosts.c) makes the springs of weak nodes; Springs sets r to their forces, N, by displacements
   u, and uses work. Tangent (static_matrix.c) sets K to the tangent of the state that the residual was last made of, with the
   rows and columns of what walls hold replaced; if x has displacements of these, what they do to the others is taken from b.
   Leap finds the largest component of the displacement gradient in the step, 1. Afterwards the particles are those as the step
   began. Collective on exchange.data. */
PetscErrorCode MPMStaticStabilise(struct MPMStatic *);
PetscErrorCode MPMStaticSprings(struct MPMStatic *, Vec u, Vec r);
PetscErrorCode MPMStaticTangent(struct MPMStatic *, Mat K, Vec x, Vec b);
PetscErrorCode MPMStaticLeap(struct MPMStatic *, PetscReal *most);

/* Returns x as a multiple of a grain, a power of 2; without one as it is. */
MPM_INLINE PetscReal MPMStaticGrain(PetscReal x, PetscReal grain)
{
  const PetscReal round = 6755399441055744.; /* 1.5 * 2^52: what is added to it has no digits after the point */

  return grain > 0 ? (x / grain + round - round) * grain : x;
}

/* LU of the whole tangent on each process (static_whole.c). Create makes a PC solve by it, and is collective on exchange.data.
   Solver gives its solver, NULL for other PCs. */
PetscErrorCode MPMStaticWholeCreate(struct MPMStatic *, PC);
PetscErrorCode MPMStaticWholeSolver(PC, KSP *);

/* Walls (static_walls.c). Hold sets what walls hold as a step begins, and the bounds by those that only push. Push sets the
   forces of these on nodes, p, from the residual r. Press holds nodes that are at their bounds and pressed on them by r, which
   becomes 0 there; with r NULL it lets them go. Collective on exchange.data. */
PetscErrorCode MPMStaticHold(struct MPMStatic *);
PetscErrorCode MPMStaticPress(struct MPMStatic *, Vec r);
PetscErrorCode MPMStaticPush(struct MPMStatic *, Vec r);

/* Inertia (static_inertia.c). Mass makes the matrix and vectors. InertiaBegin finds the velocities and forces as the step
   begins, and a first guess of the displacements. Inertia adds the inertial forces of displacements u to r, N. Velocity returns
   that of own component k after a step in which it moved by so much, m, and had velocity v before. Share returns that of
   gravity at time t. All but the last two are collective on exchange.data. */
PetscErrorCode MPMStaticMass(struct MPMStatic *);
PetscErrorCode MPMStaticInertiaBegin(struct MPMStatic *);
PetscErrorCode MPMStaticInertia(struct MPMStatic *, Vec u, Vec r);
PetscReal      MPMStaticVelocity(const struct MPMStatic *, PetscInt k, PetscReal moved, PetscReal v);
PetscReal      MPMStaticShare(const struct MPMStatic *, PetscReal t);

/* The parts of a solve (static.c), for SNES: the state of displacements u, in which s->bad says that some particle is turned
   inside out; the residual; the tangent; whether Newton's method has converged. Collective on exchange.data. */
PetscErrorCode MPMStaticResidual(SNES, Vec u, Vec r, void *);
PetscErrorCode MPMStaticJacobian(SNES, Vec u, Mat, Mat, void *);
PetscErrorCode MPMStaticConverged(SNES, PetscInt it, PetscReal x, PetscReal step, PetscReal f, SNESConvergedReason *,
                                  void *);

#endif
