/* phases.c - the Material Point Method as data: the table of phases, the update schemes, which are lists of phases, and
   the transfers. Before the first step it makes the program of a step of them. Equation numbers are those of
   docs/method.md. */
#include "step/step.h"

#define B(field)   MPM_BIT(field)
#define WHERE      (B(x) | B(cell) | B(kind) | B(l))           /* what a stencil depends on */
#define MOMENTUM   (B(v) | B(C))                               /* apic alone has C */
#define STRESS     (B(F) | B(F33) | B(J) | B(tau))             /* what the internal force depends on */
#define STATE      (STRESS | B(be) | B(ep) | B(vc) | B(theta)) /* the state of a material */
#define SAND       (B(vc) | B(tau))        /* what the volume of sand depends on, with J of fluids */
#define COMMIT_IN  (B(id) | B(F))          /* F: only for gimp domains that stretch */
#define COMMIT_OUT (B(x) | B(cell) | B(l)) /* the new position, and what depends on it */

#define TO_NODES(name, parts, in)                                                                                      \
  {                                                                                                                    \
    name, MPM_PARTICLES_TO_NODES, parts, NULL, 0, NULL, 0, PETSC_FALSE, in, 0, 1, 0                                    \
  }
#define NODES(name, kernel, flops)                                                                                     \
  {                                                                                                                    \
    name, MPM_NODES, 0, kernel, flops, NULL, 2, PETSC_FALSE, 0, 0, 1, 0                                                \
  }
#define VELOCITIES(name, kernel, flops)                                                                                \
  {                                                                                                                    \
    name, MPM_NODES, 0, kernel, flops, NULL, 1, PETSC_FALSE, 0, 0, 1, 0                                                \
  }
#define ADVANCES(name, kernel, flops)                                                                                  \
  {                                                                                                                    \
    name, MPM_NODES, 0, kernel, flops, NULL, 2, PETSC_TRUE, 0, 0, 1, 0                                                 \
  }
#define TO_PARTICLES(name, parts, in, out) SHARE_TO_PARTICLES(name, 1, parts, in, out)
#define SHARE_TO_PARTICLES(name, share, parts, in, out)                                                                \
  {                                                                                                                    \
    name, MPM_NODES_TO_PARTICLES, parts, NULL, 0, NULL, 0, PETSC_FALSE, in, out, share, 0                              \
  }

/* A row has a name, which is that of its timer, so that rows may share one. A transfer has its parts, the fields that
   it reads and the fields that it writes; a node update has its kernel, and operations per node and axis; it sets
   velocities and accelerations, or VELOCITIES alone, and then sends no more than these. ADVANCES are those in which
   light nodes move with others. SHARE_TO_PARTICLES is for a transfer that works over a share of the step. */
/* clang-format off */
enum { P2G, P2G_MASS, P2G_MOMENTUM, P2G_RESIDUAL, P2G_FORCE, VELOCITY, VELOCITY_AGAIN, RESIDUAL, MEAN, ADVANCE, CORRECT, G2P, G2P_MOTION, G2P_MOTION_HOLD, G2P_STRESS, G2P_STRESS_COMMIT, G2P_FILTER, G2P_FILTER_AGAIN, P2G_VOLUME, VOLUME, G2P_VOLUME, P2G_TOTAL, P2G_NODES, ACCELERATE, ACCELERATE_AGAIN, KICK, KICK_AGAIN, START, START_AGAIN, SHOW, SMOOTH, PLACE, G2P_TOTAL, NUM_PHASES };
static const MPMPhase phases[NUM_PHASES] = {
  [P2G]               = TO_NODES("P2G", MPM_P2G_MASS | MPM_P2G_MOMENTUM | MPM_P2G_FORCE, WHERE | MOMENTUM | STRESS | B(b) | B(S)),
  [P2G_MASS]          = TO_NODES("P2G_MASS", MPM_P2G_MASS | MPM_P2G_MOMENTUM, WHERE | MOMENTUM),
  [P2G_MOMENTUM]      = TO_NODES("P2G_MOMENTUM", MPM_P2G_MOMENTUM, WHERE | MOMENTUM),
  [P2G_RESIDUAL]      = TO_NODES("P2G_RESIDUAL", MPM_P2G_MOMENTUM | MPM_RESIDUAL, WHERE | B(r)),
  [P2G_FORCE]         = TO_NODES("P2G_FORCE", MPM_P2G_FORCE, WHERE | STRESS | B(b) | B(S)),
  [VELOCITY]          = VELOCITIES("VELOCITY", MPMNodesVelocity, 1),
  [VELOCITY_AGAIN]    = VELOCITIES("VELOCITY", MPMNodesVelocityAgain, 1),
  [RESIDUAL]          = VELOCITIES("RESIDUAL", MPMNodesResidual, 1),
  [MEAN]              = VELOCITIES("VELOCITY", MPMNodesMean, 1),
  [ADVANCE]           = ADVANCES("ADVANCE", MPMNodesAdvance, 5),
  [CORRECT]           = NODES("CORRECT", MPMNodesCorrect, 4),
  [G2P]               = TO_PARTICLES("G2P", MPM_G2P_MOTION | MPM_G2P_STRESS | MPM_G2P_COMMIT, WHERE | B(v) | B(r) | STATE | COMMIT_IN, B(v) | B(C) | STATE | COMMIT_OUT),
  [G2P_MOTION]        = TO_PARTICLES("G2P_MOTION", MPM_G2P_MOTION | MPM_G2P_COMMIT, WHERE | B(v) | B(r) | COMMIT_IN, B(v) | B(C) | COMMIT_OUT),
  [G2P_MOTION_HOLD]   = TO_PARTICLES("G2P_MOTION", MPM_G2P_MOTION, WHERE | B(v) | B(r), B(v) | B(C) | B(dx)),
  [G2P_STRESS]        = TO_PARTICLES("G2P_STRESS", MPM_G2P_STRESS, WHERE | B(id) | STATE, STATE),
  [G2P_STRESS_COMMIT] = TO_PARTICLES("G2P_STRESS", MPM_G2P_STRESS | MPM_G2P_COMMIT, WHERE | STATE | COMMIT_IN | B(dx), STATE | COMMIT_OUT),
  [G2P_FILTER]        = TO_PARTICLES("G2P_FILTER", MPM_G2P_FILTER, WHERE | B(v), B(r)),
  [G2P_FILTER_AGAIN]  = TO_PARTICLES("G2P_FILTER", MPM_G2P_FILTER | MPM_RESIDUAL, WHERE | B(r), B(r)),
  [P2G_VOLUME]        = TO_NODES("P2G_VOLUME", MPM_P2G_VOLUME, WHERE | B(F) | B(J) | B(b) | SAND),
  [VOLUME]            = VELOCITIES("VOLUME", MPMNodesVolume, 1),
  [G2P_VOLUME]        = TO_PARTICLES("G2P_VOLUME", MPM_G2P_VOLUME, WHERE | B(F) | B(J) | B(C) | B(be) | SAND, B(F) | B(J) | B(C) | B(be) | SAND),
  [P2G_TOTAL]         = TO_NODES("P2G_TOTAL", MPM_P2G_FORCE | MPM_P2G_TOTAL, WHERE | STRESS | B(b) | B(S)),
  [P2G_NODES]         = TO_NODES("P2G_NODES", MPM_P2G_MOMENTUM | MPM_RESIDUAL | MPM_P2G_NODES, WHERE),
  [ACCELERATE]        = VELOCITIES("ACCELERATE", MPMNodesAccelerate, 4),
  [ACCELERATE_AGAIN]  = VELOCITIES("ACCELERATE", MPMNodesAccelerateAgain, 6),
  [KICK]              = NODES("KICK", MPMNodesKick, 8),
  [KICK_AGAIN]        = NODES("KICK", MPMNodesKickAgain, 10),
  [START]             = VELOCITIES("START", MPMNodesStart, 1),
  [START_AGAIN]       = VELOCITIES("START", MPMNodesStartAgain, 3),
  [SHOW]              = VELOCITIES("SHOW", MPMNodesShow, 0),
  [SMOOTH]            = VELOCITIES("SMOOTH", MPMNodesSmooth, 4),
  [PLACE]             = NODES("PLACE", MPMNodesPlace, 0),
  [G2P_TOTAL]         = TO_PARTICLES("G2P_TOTAL", MPM_G2P_TOTAL, WHERE | B(id) | STATE, B(x) | B(v) | STATE),
};
/* clang-format on */
_Static_assert(NUM_PHASES <= MPM_MAX_PHASES, "core->phases has room for the table");
_Static_assert(MPM_TIMER_PHASES + NUM_PHASES <= MPM_MAX_TIMERS, "every phase may have a timer");

/* The update schemes: the row of each phase in the table, then -1. */
#define MPM_SCHEME(name, keeps_increment, direct, what, ...)                                                           \
  static const int name##_phases[] = {__VA_ARGS__, -1};                                                                \
  _Static_assert(sizeof name##_phases / sizeof name##_phases[0] <= MPM_MAX_SCHEME, "a scheme's program has room");
#include "step/scheme.def"

const MPMScheme MPMSchemes[] = {
#define MPM_SCHEME(name, keeps_increment, direct, what, ...) {#name, what, keeps_increment, direct, name##_phases},
#include "step/scheme.def"
    {NULL, NULL, PETSC_FALSE, PETSC_FALSE, NULL}};

const MPMTransfer MPMTransfers[] = {
#define MPM_TRANSFER(name, flip, parts, rounds, bounds, what) {#name, what, flip, parts, rounds, bounds},
#include "step/transfer.def"
    {NULL, NULL, 0, 0, MPM_NO_ROUNDS, MPM_BOUNDS_UNKNOWN}};

const MPMScheme MPMSchemeTotal      = {"leapfrog", "leapfrog", PETSC_FALSE, PETSC_TRUE, NULL},
                MPMSchemeStatic     = {"static", "static", PETSC_FALSE, PETSC_TRUE, NULL};
const MPMTransfer MPMTransferTotal  = {"nodes", "nodes", 1, 0, MPM_NO_ROUNDS, MPM_BOUNDS_TOTAL},
                  MPMTransferStatic = {"displacements", "displacements", 0, 0, MPM_NO_ROUNDS, MPM_BOUNDS_UNKNOWN};

/* The filter of xpic, which runs -method_order times: the first time r = v - S S+ v, then r <- r - S S+ r. S+ maps from
   particles to nodes, and S from nodes to particles. */
static const int filter[2][3] = {{P2G_MASS, VELOCITY, G2P_FILTER}, {P2G_RESIDUAL, RESIDUAL, G2P_FILTER_AGAIN}};
_Static_assert(3 * MPM_MAX_XPIC + MPM_MAX_SCHEME + 3 <= MPM_MAX_PROGRAM, "a step's program has room for the filter");

/* A correction of afmpm, of which -method_order - 1 follow the advance: r = v - S v', and v' <- v' + S+ r + kick a. */
static const int correction[3] = {G2P_FILTER, P2G_RESIDUAL, CORRECT};

const MPMPhase *MPMStepOutputPhase(const MPMCore *core, PetscInt k)
{
  return &core->phases[k ? VELOCITY : P2G_MASS];
}

const MPMPhase *MPMStepRecoverPhase(const MPMCore *core, PetscInt k)
{
  static const int recover[4] = {P2G_MASS, P2G_RESIDUAL, MEAN, G2P_FILTER_AGAIN};

  return &core->phases[recover[k]];
}

/* Gives a phase what any scene could need, as far as that changes no result (-method_carry all): its particles have all
   fields, of which b, C and the states of other laws stay as they started; sums have an affine part, of C = 0; messages
   have whole records of nodes. Phases do not get r of xpic, and those that move particles not the l of domains that
   stretch, since with these fields a kernel would do something else. */
static void CarryAll(MPMPhase *phase, const MPMNeeds *needs)
{
  PetscInt fields = (B(cell) << 1) - 1; /* cell is the last one */

  if (!(phase->particles_in & B(r)) && !(phase->parts & (MPM_RESIDUAL | MPM_G2P_FILTER))) fields &= ~B(r);
  if (!needs->stretched && phase->kind == MPM_NODES_TO_PARTICLES) fields &= ~B(l);
  if (phase->kind == MPM_NODES) {
    phase->motion = 2;
    return;
  }
  phase->particles_in = fields;
  if (phase->kind == MPM_PARTICLES_TO_NODES) {
    phase->parts |= MPM_P2G_WHOLE;
    if ((phase->parts & MPM_P2G_MOMENTUM) && !(phase->parts & MPM_RESIDUAL)) phase->parts |= MPM_AFFINE;
  } else
    phase->particles_out = (phase->particles_out | MPM_MATERIAL_BITS | B(C)) & fields;
}

static PetscBool HasGravity(const MPMCore *core)
{
  const PetscReal *g = core->params.gravity;

  return g[0] != 0 || g[1] != 0 || g[2] != 0;
}

/* Leaves out of a phase of the relaxation of volumes what only sand needs, if no sand relaxes. The last numbers of a
   node's motion are accelerations. */
static void FitVolumes(const MPMCore *core, MPMPhase *phase)
{
  const PetscInt numbers = core->volumes.sand ? 3 : 2;

  if (phase->kind == MPM_NODES && numbers > core->grid.dim) phase->motion = 2;
  if ((phase->parts & MPM_P2G_VOLUME) && (core->needs.forced || HasGravity(core))) phase->parts |= MPM_AFFINE;
  if (core->volumes.sand) return;
  phase->particles_in &= ~(SAND | B(be));
  phase->particles_out &= ~(SAND | B(be) | B(F));
  if (phase->parts & MPM_G2P_VOLUME) phase->particles_in &= ~B(F);
}

/* Copies the table of phases as this scene needs it: with the parts that the transfer adds, and without fields that no
   phase would read. */
static void FitPhases(MPMCore *core, const MPMTransfer *transfer)
{
  PetscInt stress = 0; /* the fields that the forces of these materials depend on */

  for (PetscInt k = 0; k < core->params.nkinds; k++) {
    const PetscInt state = core->params.materials[core->params.kinds[k].material].state;

    stress |= state & B(tau) ? B(tau) : state & STRESS;
  }
  for (PetscInt k = 0; k < NUM_PHASES; k++) {
    MPMPhase *phase = &core->phases[k];

    *phase = phases[k];
    if (core->grid.total && phase->particles_in & B(x)) phase->particles_in ^= B(x) | B(X);
    if ((core->pistons || core->contacts) && phase->kind == MPM_NODES && phase->nodes != MPMNodesMean && k < P2G_VOLUME)
      phase->after = MPMSurfacesAfter;
    if (core->rigids.n && phase->nodes == MPMNodesVolume) phase->after = MPMVolumesAfter;
    if (phase->parts & MPM_P2G_FORCE) phase->particles_in &= ~STRESS | stress;
    if (phase->parts & MPM_P2G_TOTAL) phase->particles_in |= B(F) | B(F33) | (core->needs.barred ? B(bar) : 0);
    if (core->needs.stepped && k == P2G_FORCE) {
      phase->parts |= MPM_P2G_TOTAL;
      phase->particles_in |= B(H) | B(H33);
    }
    if (core->needs.stepped && k == G2P_STRESS) phase->particles_out |= B(H) | B(H33);
    if (core->needs.stepped && core->needs.barred && (k == G2P_STRESS || k == P2G_FORCE)) {
      phase->particles_in |= B(bar);
      if (k == G2P_STRESS) phase->particles_out |= B(bar);
    }
    if ((phase->parts & MPM_G2P_TOTAL) && core->needs.barred) {
      phase->particles_in |= B(bar);
      phase->particles_out |= B(bar);
    }
    if ((phase->particles_in & COMMIT_IN) == COMMIT_IN && !(phase->parts & (MPM_G2P_STRESS | MPM_G2P_TOTAL)) &&
        !core->needs.stretched)
      phase->particles_in &= ~B(F);
    if ((phase->parts & (MPM_P2G_MOMENTUM | MPM_G2P_MOTION)) && !(phase->parts & MPM_RESIDUAL))
      phase->parts |= transfer->parts;
    if ((phase->parts & MPM_G2P_MOTION) && transfer->rounds != MPM_FILTER) phase->particles_in &= ~B(r);
    if ((phase->parts & MPM_P2G_MASS) && core->grid.round) phase->parts |= MPM_P2G_ROUND;
    if ((phase->parts & (MPM_G2P_STRESS | MPM_G2P_TOTAL)) && core->params.box) phase->parts |= MPM_G2P_FBAR;
    for (const MPMNodeGroup *g = MPMNodeGroups; g->name; g++)
      if (g->home == MPM_IS_SUM && phase->kind == MPM_PARTICLES_TO_NODES && phase->parts & g->part)
        phase->particles_in |= g->reads;
    if ((phase->parts & MPM_P2G_FORCE) && core->params.box) {
      phase->parts |= MPM_P2G_FBAR;
      phase->particles_in |= B(F) | B(F33) | B(J);
    }
    if (k == P2G_VOLUME || k == VOLUME || k == G2P_VOLUME) FitVolumes(core, phase);
    if (core->needs.all) CarryAll(phase, &core->needs);
  }
}

/* Sets the phases that make the residual of a static step from the displacements of nodes (static.c); in the updated frame
   the last one moves the particles in the end. */
static void StaticProgram(MPMCore *core)
{
  const int total[3] = {PLACE, G2P_TOTAL, P2G_TOTAL}, updated[4] = {PLACE, G2P_STRESS, P2G_FORCE, G2P_MOTION};

  for (PetscInt k = 0; k < (core->grid.total ? 3 : 4); k++)
    core->program[core->nprogram++] = &core->phases[core->grid.total ? total[k] : updated[k]];
}

/* Sets the program of a step in the total frame, whose mass matrix has this order: order - 1 corrections of the
   acceleration, the last of which moves the nodes. damped: before, velocities are smoothed. */
static void TotalProgram(MPMCore *core, PetscInt order, PetscBool damped)
{
  const int first[2] = {P2G_TOTAL, order > 1 ? ACCELERATE : KICK}, smooth[3] = {SHOW, P2G_NODES, SMOOTH};

  for (PetscInt k = 0; k < 3 && damped; k++) core->program[core->nprogram++] = &core->phases[smooth[k]];
  for (PetscInt k = 0; k < 2; k++) core->program[core->nprogram++] = &core->phases[first[k]];
  for (PetscInt n = 1; n < order; n++) {
    core->program[core->nprogram++] = &core->phases[P2G_NODES];
    core->program[core->nprogram++] = &core->phases[n + 1 < order ? ACCELERATE_AGAIN : KICK_AGAIN];
  }
  core->program[core->nprogram++] = &core->phases[G2P_TOTAL];
}

const MPMPhase *MPMStepStartPhase(const MPMCore *core, PetscInt k)
{
  static const int start[4] = {P2G_MASS, START, P2G_NODES, START_AGAIN};

  return &core->phases[start[k]];
}

PetscErrorCode MPMStepSetUp(MPMCore *core, const MPMMethod *method)
{
  PetscFunctionBeginUser;
  PetscCall(MPMTimersCreate(&core->timers));
  FitPhases(core, method->transfer);
  core->nphases     = NUM_PHASES;
  core->energy.mean = method->scheme->keeps_increment                      ? MPM_MEAN_AGAIN
                      : method->scheme->direct || !(core->params.flip > 0) ? MPM_MEAN_NODES
                                                                           : MPM_MEAN_PARTICLES;
  core->energy.maps = core->energy.on && !core->grid.total && !core->implicit &&
                      (method->scheme->keeps_increment || method->scheme->direct);
  for (PetscInt k = 0; k < NUM_PHASES; k++)
    PetscCall(MPMTimersPhase(&core->timers, phases[k].name, &core->phases[k].timer));
  core->nprogram = 0;
  if (core->grid.total || core->implicit) {
    if (core->implicit)
      StaticProgram(core);
    else
      TotalProgram(core, method->mass, (PetscBool)(method->rate > 0));
    MPMReactionsSetUp(core);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 0; k < core->params.order && method->transfer->rounds == MPM_FILTER; k++)
    for (PetscInt i = 0; i < 3; i++) core->program[core->nprogram++] = &core->phases[filter[k > 0][i]];
  for (const int *k = method->scheme->phases; *k >= 0; k++) {
    core->program[core->nprogram++] = &core->phases[*k];
    for (PetscInt n = 1; n < core->params.order && *k == ADVANCE && method->transfer->rounds == MPM_CORRECT; n++)
      for (PetscInt i = 0; i < 3; i++) core->program[core->nprogram++] = &core->phases[correction[i]];
  }
  core->nrare = 0;
  for (PetscInt k = P2G_VOLUME; k <= G2P_VOLUME && MPMVolumesRelax(core); k++)
    core->program[core->nprogram + core->nrare++] = &core->phases[k];
  MPMReactionsSetUp(core);
  PetscFunctionReturn(PETSC_SUCCESS);
}
