/* scheme.h - the method of a step as data: the tables of update schemes (scheme.def) and of transfers (transfer.def),
   and the phases that phases.c makes of them before the first step. */
#ifndef MPM_SCHEME_H
#define MPM_SCHEME_H

#include "parallel/core.h"
#include "physics/wall.h"

/* An update scheme: a list of phases. */
#define MPM_MAX_SCHEME 8
typedef struct {
  const char *name, *what;
  PetscBool   keeps_increment;
  PetscBool   direct;
  /* most of the strain comes from the velocities of the motion */ /* x is read again after the motion: a later phase adds dx to it */
  const int *phases;                                               /* their rows in the table of phases, then -1 */
} MPMScheme;
extern const MPMScheme MPMSchemes[]; /* rows of scheme.def; the last has no name */

/* What -method_order repeats: nothing; the filter of xpic; the corrections of the nodes' velocity of afmpm. */
typedef enum { MPM_NO_ROUNDS, MPM_FILTER, MPM_CORRECT } MPMRounds;

/* Which columns of stable.def have the bounds of a transfer. */
typedef enum {
  MPM_BOUNDS_UNKNOWN,
  MPM_BOUNDS_FLIP,
  MPM_BOUNDS_AFLIP,
  MPM_BOUNDS_APIC,
  MPM_BOUNDS_FILTERED,
  MPM_BOUNDS_AFMPM,
  MPM_BOUNDS_TOTAL
} MPMBounds;

/* A transfer: how particles get their velocity back from the grid. */
typedef struct {
  const char *name, *what;
  PetscReal   flip;  /* share of FLIP; < 0: it is -method_flip */
  PetscInt    parts; /* added to the phases of momentum and motion: MPM_AFFINE of apic */
  MPMRounds   rounds;
  MPMBounds   bounds;
} MPMTransfer;
extern const MPMTransfer MPMTransfers[]; /* rows of transfer.def; the last has no name */

#define MPM_MAX_MASS 3 /* largest -method_mass_order */

/* The method that a scene chose. */
typedef struct {
  const MPMScheme   *scheme;
  const MPMTransfer *transfer;
  PetscReal          rate, viscosity; /* damping that sets the share of FLIP anew in each step: 1, m^2/s; 0: none */
  PetscInt           mass;            /* of the total frame: order of the mass matrix; else 0 */
} MPMMethod;

/* How long the steps of a method may be, as c dt/h: the largest that is stable at rest and where particles cross cells
   (0: none), and the default of -dt_cfl, which is the second over a margin of 1.15, at most 0.8 (0.4 if that is below
   0.15). With steps of C, noise of particles that cross cells gets ten times its energy in grows/C^2 steps or, at the
   fastest, in above/(C - crossing); 0: not known. A method that stable.def does not have is not `known`: its bounds are infinite, and cfl is 0.4. Basis, method,
   params.strain and params.flip have to be set. With: of another basis and update. Not collective. */
#define MPM_STABLE_MARGIN  1.15
#define MPM_STABLE_LONGEST 0.8
typedef struct {
  PetscBool known;
  PetscReal rest, crossing, cfl, grows, above;
} MPMStable;
MPMStable MPMStableOf(const MPMCore *, const MPMMethod *);
MPMStable MPMStableWith(const MPMCore *, const MPMMethod *, MPMBasis, const char update[]);

/* Returns in how many steps of C noise gets ten times its energy; 0: not known. */
PetscReal MPMStableTenfold(const MPMStable *, PetscReal C);

/* The update that warnings advise. */
#define MPM_UPDATE_ADVISED "usl"

/* Returns by how much a method was wrong on a manufactured solution (stable.def) [2], %, or NULL. */
const PetscReal *MPMStableWrong(const MPMCore *, const MPMMethod *);

/* Sets core->phases as this scene needs them, core->program, which lists those of a step one after the other, and their
   timers. Method, needs and basis have to be known. Collective on the world, for the events of -log_view. */
PetscErrorCode MPMStepSetUp(MPMCore *, const MPMMethod *);

/* Returns phase k = 0, 1 of the two that give the mass and the velocity of the nodes for output. */
const MPMPhase *MPMStepOutputPhase(const MPMCore *, PetscInt k);

/* Returns phase k = 0 to 3 of those that average field r at the nodes, and take from it what the nodes give back: mass,
   sums, means, difference. */
const MPMPhase *MPMStepRecoverPhase(const MPMCore *, PetscInt k);

/* Returns phase k = 0 to 3 of those that start the total frame: sums of mass and momentum, first velocities, the momentum
   of these, correction. */
const MPMPhase *MPMStepStartPhase(const MPMCore *, PetscInt k);

/* The scheme and the transfer of the total frame, and those of static steps in the updated one, which are no rows of the
   tables: each has one. */
extern const MPMScheme   MPMSchemeTotal, MPMSchemeStatic;
extern const MPMTransfer MPMTransferTotal, MPMTransferStatic;

/* The kernels of node updates (nodes.c, total.c): each updates the motion of the own nodes in one row of a patch along x. Not
   collective. */
MPMNodesUpdate MPMNodesVelocity, MPMNodesVelocityAgain, MPMNodesMean, MPMNodesResidual, MPMNodesAdvance,
    MPMNodesCorrect, MPMNodesAccelerate, MPMNodesAccelerateAgain, MPMNodesKick, MPMNodesKickAgain, MPMNodesShow,
    MPMNodesSmooth, MPMNodesStart, MPMNodesStartAgain, MPMNodesPlace;
MPMNodesUpdate MPMNodesVolume; /* volume.c */

/* Returns whether a wall along y or z reaches a whole row. */
MPM_INLINE PetscBool MPMNodesWalled(const MPMParams *par, const MPMGrid *grid, const MPMNodes *r)
{
  for (PetscInt d = 1; d < grid->dim; d++)
    if (MPMWallsReach(par->walls->given, grid, d, r->ijk[d])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Defines the kernel MPMNodes<name> by a function `what`, in whose calls dim and round are constants. */
#define MPM_NODE_KERNEL(name, what, ...)                                                                               \
  void MPMNodes##name(const MPMParams *par, const MPMPatch *patch, const MPMNodes *r)                                  \
  {                                                                                                                    \
    const PetscBool walled = MPMNodesWalled(par, patch->grid, r);                                                      \
                                                                                                                       \
    if (patch->grid->round)                                                                                            \
      what(2, 1, par, patch->grid, r, __VA_ARGS__);                                                                    \
    else if (patch->grid->dim == 2)                                                                                    \
      what(2, 0, par, patch->grid, r, __VA_ARGS__);                                                                    \
    else if (patch->grid->dim == 1)                                                                                    \
      what(1, 0, par, patch->grid, r, __VA_ARGS__);                                                                    \
    else                                                                                                               \
      what(3, 0, par, patch->grid, r, __VA_ARGS__);                                                                    \
  }

#endif
