/* step.c - the Material Particle Method as data: a table of phases, a table of integrators, and the node kernels.

   An integrator is the list of its phases, in order; MPMStep runs them through the exchange, which knows who holds
   which particles, and settles the particles in their new cells. Equation numbers: docs/theory.md. */
#include <petscsf.h>
#include "mpm.h"

/* A row of nodes along x: sum, vel: of its node 0; its own nodes that particles touch are first .. last-1. ijk: where
   in the grid node 0 is. at_face: is all of the row at or beyond a face along y or z? */
typedef struct {
  PetscReal *sum, *vel;
  PetscInt   first, last, ijk[3];
  PetscBool  at_face;
} NodeRow;

static NodeRow OwnRow(const MPMPatch *patch, PetscInt row)
{
  const PetscInt dim = patch->grid->dim, own = patch->own_lo[0] - patch->lo[0];
  NodeRow        r = {.sum = patch->sum + row * patch->n[0] * MPM_SUM_NC(dim),
                      .vel = patch->vel + row * patch->n[0] * MPM_VEL_NC(dim)};

  r.first  = PetscMax(own, patch->span[row].first);
  r.last   = PetscMin(own + patch->own_n[0], patch->span[row].last);
  r.ijk[0] = patch->lo[0];
  r.ijk[1] = row % patch->n[1] + patch->lo[1];
  r.ijk[2] = row / patch->n[1] + patch->lo[2];
  for (PetscInt d = 1; d < dim; d++)
    if (r.ijk[d] <= 0 || r.ijk[d] >= patch->grid->cells[d]) r.at_face = PETSC_TRUE;
  return r;
}

/* Is node i of the row at or beyond a face of the grid? Most are not. ijk [3]: its number in the grid. */
MPM_INLINE PetscBool AtFace(const NodeRow *r, const MPMGrid *grid, PetscInt i, PetscInt ijk[])
{
  ijk[0] = r->ijk[0] + i;
  ijk[1] = r->ijk[1];
  ijk[2] = r->ijk[2];
  return r->at_face || ijk[0] <= 0 || ijk[0] >= grid->cells[0] ? PETSC_TRUE : PETSC_FALSE;
}

/* v = p/m and walls, eq. (2). A node without mass is at rest; there is no threshold. Only particles exactly on a grid
   line, whose weight there is 0 but whose gradient is not, read such a node. */
MPM_INLINE void Divide(int dim, const MPMFace (*faces)[2], const MPMGrid *grid, const NodeRow *r)
{
  PetscInt ijk[3];

  for (PetscInt i = r->first; i < r->last; i++) {
    const PetscReal *m = r->sum + i * MPM_SUM_NC(dim), *p = m + 1;
    PetscReal       *v = r->vel + i * MPM_VEL_NC(dim);

    for (int d = 0; d < dim; d++) v[d] = *m > 0 ? p[d] / *m : 0;
    if (AtFace(r, grid, i, ijk)) (void)MPMWallsApply(faces, dim, ijk, grid->cells, v);
  }
}

/* For output and velocity gradients. */
MPM_INLINE void Velocity(int dim, const MPMParams *par, const MPMGrid *grid, const NodeRow *r)
{
  Divide(dim, par->gradient, grid, r);
}

/* The same of what xpic has left over. */
MPM_INLINE void Residual(int dim, const MPMParams *par, const MPMGrid *grid, const NodeRow *r)
{
  Divide(dim, par->residual, grid, r);
}

/* a = f/m + g, eqs. (5) and (13); v <- v + dt a, eq. (6), and walls, which also set a. */
MPM_INLINE void Advance(int dim, const MPMParams *par, const MPMGrid *grid, const NodeRow *r)
{
  PetscInt ijk[3];

  Divide(dim, par->before, grid, r);
  for (PetscInt i = r->first; i < r->last; i++) {
    PetscReal *sum = r->sum + i * MPM_SUM_NC(dim), *f = sum + MPM_SUM_FORCE;
    PetscReal *v = r->vel + i * MPM_VEL_NC(dim), *a = v + dim, before[3];

    for (int d = 0; d < dim; d++) {
      a[d]      = *sum > 0 ? f[d] / *sum + par->gravity[d] : 0;
      before[d] = v[d];
      v[d]      = v[d] + par->dt * a[d];
    }
    sum[MPM_SUM_MET] = 0;
    if (AtFace(r, grid, i, ijk))
      sum[MPM_SUM_MET] = (PetscReal)MPMWallsAdvance(par->faces, dim, ijk, grid->cells, par->dt, before, v, a);
  }
}

/* Velocities mapped again after an advance: a wall that only pushes holds the nodes that it met there, and no others.
   If each mapping asked anew, what trembles at the wall would be cut on one side, and that drives it. */
MPM_INLINE void VelocityAgain(int dim, const MPMParams *par, const MPMGrid *grid, const NodeRow *r)
{
  Divide(dim, par->before, grid, r);
  for (PetscInt i = r->first; i < r->last; i++) {
    const PetscInt met = (PetscInt)r->sum[i * MPM_SUM_NC(dim) + MPM_SUM_MET];

    for (int d = 0; met && d < dim; d++)
      if (met & (PetscInt)1 << d) r->vel[i * MPM_VEL_NC(dim) + d] = 0;
  }
}

/* The node kernels of phases: the number of dimensions is a constant in each. */
#define NODE_KERNEL(what)                                                                                              \
  static void Node##what(const MPMParams *par, MPMPatch *patch, PetscInt row)                                          \
  {                                                                                                                    \
    const NodeRow r = OwnRow(patch, row);                                                                              \
                                                                                                                       \
    if (patch->grid->dim == 1) what(1, par, patch->grid, &r);                                                          \
    if (patch->grid->dim == 2) what(2, par, patch->grid, &r);                                                          \
    if (patch->grid->dim == 3) what(3, par, patch->grid, &r);                                                          \
  }
NODE_KERNEL(Velocity)
NODE_KERNEL(VelocityAgain)
NODE_KERNEL(Residual)
NODE_KERNEL(Advance)

#define B(field)   MPM_BIT(field)
#define WHERE      (B(x) | B(cell) | B(kind) | B(l)) /* what a stencil is made of */
#define MOMENTUM   (B(v) | B(C))                     /* C of apic */
#define STRESS     (B(F) | B(J) | B(tau))            /* what a force is made of */
#define STATE      (STRESS | B(be) | B(ep) | B(vc))  /* what a material remembers */
#define COMMIT_IN  (B(id) | B(F))                    /* F of gimp domains that stretch */
#define COMMIT_OUT (B(x) | B(cell) | B(l))

/* clang-format off */
enum { P2G, P2G_MASS, P2G_MOMENTUM, P2G_RESIDUAL, P2G_FORCE, VELOCITY, VELOCITY_AGAIN, RESIDUAL, ADVANCE, G2P, G2P_MOTION, G2P_MOTION_HOLD, G2P_STRESS, G2P_STRESS_COMMIT, G2P_FILTER, G2P_FILTER_AGAIN, NUM_PHASES };
static const MPMPhase phases[NUM_PHASES] = {
  /*                     name            kind                 parts                                                    node kernel    particles in                                   particles out                           nodes in, out */
  [P2G]               = {"P2G",          MPM_PARTICLES_TO_NODES, MPM_P2G_MASS | MPM_P2G_MOMENTUM | MPM_P2G_FORCE,         NULL,          WHERE | MOMENTUM | STRESS | B(b),           0,                                   "",    "mpf"},
  [P2G_MASS]          = {"P2G_MASS",     MPM_PARTICLES_TO_NODES, MPM_P2G_MASS | MPM_P2G_MOMENTUM,                         NULL,          WHERE | MOMENTUM,                           0,                                   "",    "mp"},
  [P2G_MOMENTUM]      = {"P2G_MOMENTUM", MPM_PARTICLES_TO_NODES, MPM_P2G_MOMENTUM,                                        NULL,          WHERE | MOMENTUM,                           0,                                   "",    "p"},
  [P2G_RESIDUAL]      = {"P2G_RESIDUAL", MPM_PARTICLES_TO_NODES, MPM_P2G_MOMENTUM | MPM_RESIDUAL,                         NULL,          WHERE | B(r),                               0,                                   "",    "p"},
  [P2G_FORCE]         = {"P2G_FORCE",    MPM_PARTICLES_TO_NODES, MPM_P2G_FORCE,                                           NULL,          WHERE | STRESS | B(b),                      0,                                   "",    "f"},
  [VELOCITY]          = {"VELOCITY",     MPM_NODES,           0,                                                       NodeVelocity,  0,                                          0,                                   "mp",  "v"},
  [VELOCITY_AGAIN]    = {"VELOCITY",     MPM_NODES,           0,                                                       NodeVelocityAgain, 0,                                      0,                                   "mp",  "v"},
  [RESIDUAL]          = {"RESIDUAL",     MPM_NODES,           0,                                                       NodeResidual,  0,                                          0,                                   "mp",  "v"},
  [ADVANCE]           = {"ADVANCE",      MPM_NODES,           0,                                                       NodeAdvance,   0,                                          0,                                   "mpf", "va"},
  [G2P]               = {"G2P",          MPM_NODES_TO_PARTICLES, MPM_G2P_MOTION | MPM_G2P_STRESS | MPM_G2P_COMMIT,        NULL,          WHERE | B(v) | B(r) | STATE | COMMIT_IN,    B(v) | B(C) | STATE | COMMIT_OUT,    "va",  ""},
  [G2P_MOTION]        = {"G2P_MOTION",   MPM_NODES_TO_PARTICLES, MPM_G2P_MOTION | MPM_G2P_COMMIT,                         NULL,          WHERE | B(v) | B(r) | COMMIT_IN,            B(v) | B(C) | COMMIT_OUT,            "va",  ""},
  [G2P_MOTION_HOLD]   = {"G2P_MOTION",   MPM_NODES_TO_PARTICLES, MPM_G2P_MOTION,                                          NULL,          WHERE | B(v) | B(r),                        B(v) | B(C) | B(dx),                 "va",  ""},
  [G2P_STRESS]        = {"G2P_STRESS",   MPM_NODES_TO_PARTICLES, MPM_G2P_STRESS,                                          NULL,          WHERE | B(id) | STATE,                      STATE,                               "v",   ""},
  [G2P_STRESS_COMMIT] = {"G2P_STRESS",   MPM_NODES_TO_PARTICLES, MPM_G2P_STRESS | MPM_G2P_COMMIT,                         NULL,          WHERE | STATE | COMMIT_IN | B(dx),          STATE | COMMIT_OUT,                  "v",   ""},
  [G2P_FILTER]        = {"G2P_FILTER",   MPM_NODES_TO_PARTICLES, MPM_G2P_FILTER,                                          NULL,          WHERE | B(v),                               B(r),                                "v",   ""},
  [G2P_FILTER_AGAIN]  = {"G2P_FILTER",   MPM_NODES_TO_PARTICLES, MPM_G2P_FILTER | MPM_RESIDUAL,                           NULL,          WHERE | B(r),                               B(r),                                "v",   ""},
};

static const MPMIntegrator usf  = {"usf",  "update stress first, the classic order; first order in dt", PETSC_FALSE,
  {&phases[P2G_MASS], &phases[VELOCITY], &phases[G2P_STRESS], &phases[P2G_FORCE], &phases[ADVANCE], &phases[G2P_MOTION]}};
static const MPMIntegrator usl  = {"usl",  "update stress last, from the advanced node velocities; the cheapest", PETSC_FALSE,
  {&phases[P2G], &phases[ADVANCE], &phases[G2P]}};
static const MPMIntegrator musl = {"musl", "modified update stress last, from particle velocities mapped again", PETSC_TRUE,
  {&phases[P2G], &phases[ADVANCE], &phases[G2P_MOTION_HOLD], &phases[P2G_MOMENTUM], &phases[VELOCITY_AGAIN], &phases[G2P_STRESS_COMMIT]}};
/* What xpic does first, once an order: r = v - S S+ v, then r <- r - S S+ r, with S+ to the nodes and S to the particles. */
static const MPMPhase *const filter[2][3] = {
  {&phases[P2G_MASS], &phases[VELOCITY], &phases[G2P_FILTER]},
  {&phases[P2G_RESIDUAL], &phases[RESIDUAL], &phases[G2P_FILTER_AGAIN]}};
/* clang-format on */

const MPMIntegrator *const MPMIntegrators[] = {&usf, &usl, &musl, NULL};

/* The parts of a run that -log_view and the final table show: the phases, and these. */
enum { FORCES = MPM_TIMER_FORCES, REDUCE, MIGRATE, SORT, SETTLE, NUM_EVENTS };
static PetscLogEvent events[NUM_EVENTS];

const char *MPMTimerName(PetscInt e)
{
  static const char *const rest[] = {"FORCES", "REDUCE", "MIGRATE", "SORT", "SETTLE", "other"};

  return e >= FORCES ? rest[e - FORCES] : e < NUM_PHASES ? phases[e].name : "";
}

PetscReal MPMTimerSeconds(MPM mpm, PetscInt e)
{
  PetscReal other = mpm->wall_steps;

  if (e < NUM_EVENTS) return mpm->phase_seconds[e];
  for (PetscInt k = 0; k < NUM_EVENTS; k++) other -= mpm->phase_seconds[k];
  return other;
}

static PetscErrorCode RegisterEvents(void)
{
  static PetscBool done = PETSC_FALSE; /* a study makes many runs */
  PetscClassId     id;

  PetscFunctionBeginUser;
  if (done) PetscFunctionReturn(PETSC_SUCCESS);
  done = PETSC_TRUE;
  PetscCall(PetscClassIdRegister("MPM", &id));
  PetscCall(DMInitializePackage()); /* -log_view asks all processes for the same events: workers of a pool make no DM */
  PetscCall(PetscSFInitializePackage());
  for (PetscInt e = 0; e < NUM_EVENTS; e++) {
    if (e && e < NUM_PHASES && !strcmp(MPMTimerName(e), MPMTimerName(e - 1)))
      events[e] = events[e - 1]; /* twins share a name */
    else
      PetscCall(PetscLogEventRegister(MPMTimerName(e), id, &events[e]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The phases as this scene needs them: the affine parts with apic; no field that nothing would read. */
static void FitPhases(MPM mpm)
{
  PetscInt stress = 0; /* what the forces of these materials are made of */

  for (PetscInt k = 0; k < mpm->scene.nmaterials; k++) {
    const PetscInt state = mpm->scene.materials[k].state;
    stress |= state & B(tau) ? B(tau) : state & STRESS;
  }
  for (PetscInt k = 0; k < NUM_PHASES; k++) {
    MPMPhase *phase = &mpm->phases[k];

    *phase = phases[k];
    if (phase->parts & MPM_P2G_FORCE) phase->particles_in &= ~STRESS | stress;
    if ((phase->particles_in & COMMIT_IN) == COMMIT_IN && !(phase->parts & MPM_G2P_STRESS) && !mpm->stretched)
      phase->particles_in &= ~B(F);
    if (mpm->affine && (phase->parts & (MPM_P2G_MOMENTUM | MPM_G2P_MOTION)) && !(phase->parts & MPM_RESIDUAL))
      phase->parts |= MPM_AFFINE;
  }
}

/* Sets mpm->phases, and mpm->program: those of a step, in order. Once method and materials are known; not collective.
 */
PetscErrorCode MPMStepSetUp(MPM mpm)
{
  PetscFunctionBeginUser;
  PetscCall(RegisterEvents());
  FitPhases(mpm);
  mpm->nprogram = 0;
  for (PetscInt k = 0; k < mpm->params.order; k++)
    for (PetscInt i = 0; i < 3; i++) mpm->program[mpm->nprogram++] = &mpm->phases[filter[k > 0][i] - phases];
  for (PetscInt k = 0; k < MPM_MAX_PHASES && mpm->integrator->phases[k]; k++)
    mpm->program[mpm->nprogram++] = &mpm->phases[mpm->integrator->phases[k] - phases];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nodes of the patch here that particles touch. */
static PetscReal TouchedNodes(const MPMPatch *patch)
{
  PetscReal nodes = 0;

  for (PetscInt r = 0; patch->span && r < patch->n[1] * patch->n[2]; r++)
    nodes += (PetscReal)PetscMax(0, patch->span[r].last - patch->span[r].first);
  return nodes;
}

/* Flops of a phase on nparticles particles: particles do the work of the transfers, nodes that of the node phases. */
static PetscReal PhaseFlops(MPM mpm, const MPMPhase *phase, PetscInt nparticles, PetscReal nodes)
{
  const PetscInt dim = mpm->grid.dim;

  if (phase->kind != MPM_NODES) return (PetscReal)nparticles * MPMTransferFlops(dim, mpm->basis, phase->parts);
  return nodes * (PetscReal)(dim * (phase->nodes == NodeAdvance ? 5 : 1));
}

/* Bytes of a phase between memory and processor if nothing stays in caches from phase to phase: the declared fields of
   the particles, and the node records that particles touch, each read or written once. */
static PetscReal PhaseBytes(MPM mpm, const MPMPhase *phase, PetscInt nparticles, PetscReal nodes)
{
  const PetscInt dim = mpm->grid.dim;
  const PetscInt nc  = phase->kind == MPM_PARTICLES_TO_NODES   ? 2 * MPM_SUM_NC(dim)
                       : phase->kind == MPM_NODES_TO_PARTICLES ? MPM_VEL_NC(dim)
                                                               : MPM_SUM_NC(dim) + MPM_VEL_NC(dim);

  return (PetscReal)nparticles * (PetscReal)(MPMParticlesRowBytes(&mpm->particles, phase->particles_in) +
                                             MPMParticlesRowBytes(&mpm->particles, phase->particles_out)) +
         nodes * (PetscReal)nc * (PetscReal)sizeof(PetscReal);
}

/* Marks the beginning and the end of a phase for -log_view and the final table. Not collective. */
PetscErrorCode MPMPhaseBegin(MPM mpm, const MPMPhase *phase)
{
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(events[phase - mpm->phases], 0, 0, 0, 0));
  PetscCall(MPMClock(mpm, &mpm->phase_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPhaseEnd(MPM mpm, const MPMPhase *phase, PetscInt nparticles)
{
  const PetscReal nodes = TouchedNodes(&mpm->exchange.patch), flops = PhaseFlops(mpm, phase, nparticles, nodes);
  const PetscInt  all = mpm->exchange.type->farms ? mpm->particles.n
                                                  : nparticles; /* workers do those of a pool's master */
  PetscLogDouble  now;

  PetscFunctionBeginUser;
  PetscCall(MPMClock(mpm, &now));
  mpm->phase_seconds[phase - mpm->phases] += now - mpm->phase_start;
  PetscCall(PetscLogFlops(flops));
  mpm->flops += PhaseFlops(mpm, phase, all, nodes);
  mpm->bytes += PhaseBytes(mpm, phase, all, nodes);
  PetscCall(PetscLogEventEnd(events[phase - mpm->phases], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same for parts of settling, whose seconds are not those of SETTLE then (its event encloses theirs). */
PetscErrorCode MPMSettlingBegin(MPM mpm, PetscInt timer)
{
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(events[timer], 0, 0, 0, 0));
  PetscCall(MPMClock(mpm, &mpm->phase_start));
  if (timer == SORT) MPMWorkBegin(mpm);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSettlingEnd(MPM mpm, PetscInt timer)
{
  PetscLogDouble now;

  PetscFunctionBeginUser;
  if (timer == SORT) MPMWorkEnd(mpm, timer);
  PetscCall(MPMClock(mpm, &now));
  mpm->phase_seconds[timer] += now - mpm->phase_start;
  mpm->phase_seconds[SETTLE] -= now - mpm->phase_start;
  PetscCall(PetscLogEventEnd(events[timer], 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunPhase(MPM mpm, const MPMPhase *phase)
{
  const MPMExchangeType *ex = mpm->exchange.type;

  PetscFunctionBeginUser;
  PetscCall(MPMPhaseBegin(mpm, phase));
  PetscCall(phase->kind == MPM_NODES ? ex->nodes(mpm, phase) : ex->sweep(mpm, phase));
  PetscCall(MPMPhaseEnd(mpm, phase, ex->farms ? 0 : mpm->particles.n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One step of length params.dt: the phases of the integrator, then one reduction and the particles settle in their new
   cells. Afterwards status holds what the step found; if status.bad is set, the state is that of the failed step and
   has not settled. Collective on the exchange.                                                                       */
PetscErrorCode MPMStep(MPM mpm)
{
  PetscLogDouble t0, t1, t2;

  PetscFunctionBeginUser;
  MPMStatusReset(&mpm->status);
  PetscCall(MPMWorkStep(mpm));
  if (mpm->scene.forced) {
    PetscCall(MPMClock(mpm, &t0));
    PetscCall(PetscLogEventBegin(events[FORCES], 0, 0, 0, 0));
    MPMWorkBegin(mpm);
    PetscCall(MPMForcesUpdate(mpm, mpm->t));
    MPMWorkEnd(mpm, FORCES);
    PetscCall(PetscLogEventEnd(events[FORCES], 0, 0, 0, 0));
    PetscCall(MPMClock(mpm, &t1));
    mpm->phase_seconds[FORCES] += t1 - t0;
  }
  for (PetscInt k = 0; k < mpm->nprogram; k++) PetscCall(RunPhase(mpm, mpm->program[k]));
  PetscCall(MPMClock(mpm, &t0));
  PetscCall(PetscLogEventBegin(events[REDUCE], 0, 0, 0, 0));
  mpm->status.interrupted = MPMInterrupted();
  PetscCall(mpm->exchange.type->reduce(mpm, &mpm->status));
  PetscCall(PetscLogEventEnd(events[REDUCE], 0, 0, 0, 0));
  PetscCall(MPMClock(mpm, &t1));
  if (mpm->status.bad == MPM_OK) {
    PetscCall(PetscLogEventBegin(events[SETTLE], 0, 0, 0, 0));
    PetscCall(mpm->exchange.type->settle(mpm, PETSC_FALSE));
    PetscCall(PetscLogEventEnd(events[SETTLE], 0, 0, 0, 0));
  }
  PetscCall(MPMClock(mpm, &t2));
  mpm->phase_seconds[REDUCE] += t1 - t0;
  mpm->phase_seconds[SETTLE] += t2 - t1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Mass and velocity of the nodes for the state as it is, as output shows them; changes no particle, and is no work of a
   step. Collective. */
PetscErrorCode MPMStepNodes(MPM mpm)
{
  const PetscBool on = mpm->path.on;

  PetscFunctionBeginUser;
  mpm->path.on = PETSC_FALSE;
  PetscCall(mpm->exchange.type->sweep(mpm, &mpm->phases[P2G_MASS]));
  PetscCall(mpm->exchange.type->nodes(mpm, &mpm->phases[VELOCITY]));
  mpm->path.on = on;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Largest squared speed of a particle and of a wave in the state as it is, into status: what a step leaves there, for a
   state that no step has made. Collective.                                                                           */
PetscErrorCode MPMStepBound(MPM mpm)
{
  const PetscInt dim = mpm->grid.dim, fields = B(v) | STATE | B(kind);
  MPMView        view;
  MPMBlock       b;
  PetscReal      c2;

  PetscFunctionBeginUser;
  MPMStatusReset(&mpm->status);
  PetscCall(MPMParticlesGetView(&mpm->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMMaterial *m  = mpm->scene.materials + mpm->scene.kinds[view.kind ? view.kind[p] : 0].material;
    PetscReal          v2 = 0;

    for (PetscInt d = 0; d < dim; d++) v2 += view.v[p * dim + d] * view.v[p * dim + d];
    MPMParticlesState(dim, &view, p, &b);
    m->type->law->speed2[dim - 1](m, 0, 1, &b, &c2);
    mpm->status.v2 = PetscMax(mpm->status.v2, v2);
    mpm->status.c2 = PetscMax(mpm->status.c2, c2);
  }
  PetscCall(MPMParticlesRestoreView(&mpm->particles, fields, &view));
  PetscCall(mpm->exchange.type->reduce(mpm, &mpm->status));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintTimer(MPM mpm, const char name[], PetscReal seconds, PetscReal predicted)
{
  const PetscReal steps = (PetscReal)PetscMax(1, mpm->step), per = (PetscReal)mpm->particles.total * steps;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(mpm, "  %-12s %8.3f  %5.1f  %8.1f  %12.3g  ", name, (double)seconds,
                     (double)(100 * seconds / mpm->wall_steps), (double)(1e9 * seconds / per),
                     (double)(seconds / steps)));
  PetscCall(predicted > 0 ? MPMPrint(mpm, "%11.3g  %6.2f\n", (double)predicted, (double)(seconds / steps / predicted))
                          : MPMPrint(mpm, "%11s  %6s\n", "-", "-"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the table of phases of a run, beside it what the model predicts. Collective on comm. */
PetscErrorCode MPMStepView(MPM mpm)
{
  PetscReal all = 0;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(mpm, "phase                s      %%   ns/particle/step      s/step    predicted   ratio\n"));
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) {
    const PetscReal s = MPMTimerSeconds(mpm, e);

    all += mpm->predicted[e];
    if (s > 0) PetscCall(PrintTimer(mpm, MPMTimerName(e), s, mpm->predicted[e]));
  }
  PetscCall(PrintTimer(mpm, "all", mpm->wall_steps, all));
  if (mpm->wall_output > 0.01 * mpm->wall_steps)
    PetscCall(MPMPrint(mpm, "output     %.3g s for history and snapshots\n", mpm->wall_output));
  PetscCall(
      MPMPrint(mpm, "model      constants %s%s%s\n", mpm->model.from, mpm->model_note[0] ? "; " : "", mpm->model_note));
  PetscFunctionReturn(PETSC_SUCCESS);
}
