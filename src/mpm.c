/* mpm.c - the life of a run: options, set-up, the loop over steps and the reasons to stop. */
#include <signal.h>
#include "mpm.h"

static volatile sig_atomic_t interrupted;

static void Interrupt(int number)
{
  (void)number;
  interrupted = 1;
}

PetscInt MPMInterrupted(void)
{
  return interrupted;
}

/* SIGINT and SIGTERM end the run after the step, with its results; a second one ends it at once. */
static void CatchSignals(void)
{
  struct sigaction action;

  memset(&action, 0, sizeof action);
  action.sa_handler = Interrupt;
  action.sa_flags   = (int)SA_RESETHAND;
  (void)sigaction(SIGINT, &action, NULL);
  (void)sigaction(SIGTERM, &action, NULL);
}

PetscErrorCode MPMCreate(MPI_Comm comm, MPM *mpm)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(mpm));
  (*mpm)->comm          = comm;
  (*mpm)->exchange.data = MPI_COMM_NULL;
  PetscCall(PetscTime(&(*mpm)->wall_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadMethod(MPM mpm, MPMOptions o)
{
  static const char *const bases[] = {
#define MPM_BASIS(name, nodes, layers, inertia, what) #name,
#include "basis.def"
#undef MPM_BASIS
  };
  char      basis[MPM_NAME_LEN], update[MPM_NAME_LEN], transfer[MPM_NAME_LEN], wall[MPM_NAME_LEN], gimp[MPM_NAME_LEN];
  PetscBool set, wall_set, gimp_set, order_set;
  PetscReal nodes;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "method_basis", NULL, basis, NULL));
  PetscCall(MPMOptionsEnum(o, "method_update", NULL, update, NULL));
  PetscCall(MPMOptionsEnum(o, "method_transfer", NULL, transfer, NULL));
  PetscCall(MPMOptionsReal(o, "method_flip", NULL, &mpm->params.flip, &set));
  PetscCall(MPMOptionsEnum(o, "method_wall_basis", NULL, wall, &wall_set));
  PetscCall(MPMOptionsEnum(o, "method_gimp_update", NULL, gimp, &gimp_set));
  mpm->params.order = 2;
  PetscCall(MPMOptionsInt(o, "method_order", NULL, &mpm->params.order, &order_set));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < MPM_NUM_BASES; k++)
    if (!strcmp(bases[k], basis)) mpm->basis = (MPMBasis)k;
  for (PetscInt k = 0; MPMIntegrators[k]; k++)
    if (!strcmp(MPMIntegrators[k]->name, update)) mpm->integrator = MPMIntegrators[k];
  if (strcmp(transfer, "flip")) {
    if (set && !MPMOptionsOverridden("method_flip", "method_transfer"))
      MPMOptionsFail(o, "-method_flip does not apply: -method_transfer %s has no share of FLIP", transfer);
    mpm->params.flip = 0;
  }
  if (strcmp(transfer, "xpic")) {
    if (order_set && !MPMOptionsOverridden("method_order", "method_transfer"))
      MPMOptionsFail(o, "-method_order does not apply: it is the order of -method_transfer xpic");
    mpm->params.order = 0;
  }
  mpm->affine    = !strcmp(transfer, "apic") ? PETSC_TRUE : PETSC_FALSE;
  mpm->stretched = mpm->basis == MPM_BASIS_gimp && !strcmp(gimp, "stretch") ? PETSC_TRUE : PETSC_FALSE;
  if (wall_set && !MPMBasisIsSpline(mpm->basis) && !MPMOptionsOverridden("method_wall_basis", "method_basis"))
    MPMOptionsFail(o, "-method_wall_basis does not apply: it is for the splines, -method_basis is %s", basis);
  if (gimp_set && mpm->basis != MPM_BASIS_gimp && !MPMOptionsOverridden("method_gimp_update", "method_basis"))
    MPMOptionsFail(o, "-method_gimp_update does not apply: -method_basis is %s", basis);
  for (PetscInt k = 0; k < mpm->scene.nmaterials; k++)
    if (mpm->stretched && !(mpm->scene.materials[k].state & MPM_BIT(F)))
      MPMOptionsFail(o, "-method_gimp_update stretch does not apply: material %s (%s) has no deformation gradient",
                     mpm->scene.materials[k].name, mpm->scene.materials[k].type->name);
  for (PetscInt d = 0; d < mpm->grid.dim; d++) {
    const PetscInt least = mpm->basis == MPM_BASIS_linear ? 1 : MPMBasisNodes(mpm->basis);

    mpm->grid.wall_basis[d] = mpm->grid.periodic[d]      ? MPM_WALL_BASIS_NONE
                              : !strcmp(wall, "steffen") ? MPM_WALL_BASIS_STEFFEN
                                                         : MPM_WALL_BASIS_EXTRAP;
    if (mpm->grid.cells[d] < least && (MPMBasisIsSpline(mpm->basis) || mpm->grid.periodic[d]))
      MPMOptionsFail(
          o, "-grid_cells: %" PetscInt_FMT " on axis %c are too few for -method_basis %s, which needs %" PetscInt_FMT,
          mpm->grid.cells[d], "xyz"[d], basis, least);
  }
  MPMGridSetNodes(&mpm->grid, mpm->basis);
  nodes = MPMGridNodes(&mpm->grid, mpm->basis);
  if (nodes * MPM_SUM_NC(mpm->grid.dim) > (PetscReal)PETSC_MAX_INT) /* cells of tiles are fewer: below 6 a node */
    MPMOptionsFail(o, "-grid_cells: %g nodes are more than this PETSc can number", (double)nodes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadTime(MPM mpm, MPMOptions o)
{
  char      size[MPM_TEXT_LEN] = "auto";
  PetscBool set;

  PetscFunctionBeginUser;
  mpm->max_steps = PETSC_MAX_INT;
  PetscCall(MPMOptionsReal(o, "time_end", NULL, &mpm->time_end, NULL));
  PetscCall(MPMOptionsInt(o, "time_max_steps", NULL, &mpm->max_steps, NULL));
  PetscCall(MPMOptionsString(o, "dt_size", NULL, size, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (strcmp(size, "auto")) {
    char *end;

    mpm->dt_fixed = strtod(size, &end);
    if (end == size || *end)
      MPMOptionsFail(o, "-dt_size %s: choose auto or a number > 0", size);
    else if (!(PetscAbsReal(mpm->dt_fixed) <= PETSC_MAX_REAL))
      MPMOptionsFail(o, "-dt_size is not finite");
    else if (mpm->dt_fixed <= 0)
      MPMOptionsFail(o, "-dt_size %s is outside the allowed range dt_size > 0", size);
    PetscCall(MPMOptionsReal(o, "dt_cfl", NULL, &mpm->dt_cfl, &set));
    if (set && !MPMOptionsOverridden("dt_cfl", "dt_size"))
      MPMOptionsFail(o, "-dt_cfl does not apply: -dt_size is fixed");
  } else
    PetscCall(MPMOptionsReal(o, "dt_cfl", NULL, &mpm->dt_cfl, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadSafety(MPMOptions o)
{
  char ignored[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "check_state", NULL, ignored, NULL));     /* one value so far */
  PetscCall(MPMOptionsEnum(o, "particles_leave", NULL, ignored, NULL)); /* one value so far */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the scene and everything about its run; allocates nothing of its size. The first fault is left in o. All
   processes read the same. Collective on mpm->comm.                                                                  */
PetscErrorCode MPMSetFromOptions(MPM mpm, MPMOptions o)
{
  PetscFunctionBeginUser;
  PetscCall(MPMSceneSetFromOptions(mpm, o));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ReadMethod(mpm, o));
  PetscCall(ReadTime(mpm, o));
  PetscCall(ReadSafety(o));
  PetscCall(MPMExchangeSetFromOptions(mpm, o));
  PetscCall(MPMModelSetFromOptions(mpm, o));
  PetscCall(MPMMonitorSetFromOptions(mpm, o));
  PetscCall(MPMOutputSetFromOptions(mpm, o));
  PetscCall(MPMStudySetFromOptions(mpm, o));
  PetscCall(MPMOptionsBool(o, "report_limits", NULL, &mpm->report_limits));
  PetscCall(MPMOptionsBool(o, "report_path", NULL, &mpm->path.on));
  PetscCall(MPMOptionsFinish(o));
  if (!MPMOptionsError(o)) PetscCall(MPMSceneCountParticles(mpm, o));
  if (!MPMOptionsError(o)) PetscCall(MPMOutputMakeFolder(mpm, o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A stage of -log_view: registered once in a process. */
static PetscErrorCode Stage(const char name[], PetscLogStage *stage)
{
  PetscFunctionBeginUser;
  PetscCall(PetscLogStageGetId(name, stage));
  if (*stage < 0) PetscCall(PetscLogStageRegister(name, stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes grid, particles and patches. Collective. */
PetscErrorCode MPMSetUp(MPM mpm)
{
  PetscLogStage stage;

  PetscFunctionBeginUser;
  PetscCall(MPMStepSetUp(mpm));
  PetscCall(Stage("MPM set-up", &stage));
  PetscCall(PetscLogStagePush(stage));
  mpm->params.kinds     = mpm->scene.kinds;
  mpm->params.nkinds    = mpm->scene.nkinds;
  mpm->params.materials = mpm->scene.materials;
  mpm->params.faces     = mpm->scene.faces;
  mpm->params.before    = mpm->scene.before;
  mpm->params.gradient  = mpm->scene.gradient;
  mpm->params.residual  = mpm->scene.residual;
  MPMWallsDerive(mpm->scene.faces, mpm->scene.before, mpm->scene.gradient, mpm->scene.residual);
  PetscCall(MPMParticlesLayout(mpm, &mpm->particles));
  PetscCall(MPMModelSetUp(mpm));
  PetscCall(mpm->exchange.type->setup(mpm));
  mpm->exchange.ready = PETSC_TRUE;
  if (mpm->exchange.data == MPI_COMM_NULL) { /* a worker of the pool: it holds no particles */
    PetscCall(PetscLogStagePop());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMParticlesCreate(mpm, &mpm->particles, mpm->exchange.data));
  PetscCall(MPMSceneAddParticles(mpm));
  PetscCall(mpm->exchange.type->settle(mpm, PETSC_TRUE));
  PetscCall(MPMStepBound(mpm));
  PetscCall(MPMModelPredict(mpm));
  PetscCall(PetscLogStagePop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal SmallestH(const MPMGrid *grid)
{
  PetscReal h = grid->h[0];

  for (PetscInt d = 1; d < grid->dim; d++) h = PetscMin(h, grid->h[d]);
  return h;
}

/* dt (c + |v|)/h of the state as it is: the part of the bound that this dt is. */
PetscReal MPMCourant(MPM mpm, PetscReal dt)
{
  return dt * (PetscSqrtReal(mpm->status.c2) + PetscSqrtReal(mpm->status.v2)) / SmallestH(&mpm->grid);
}

/* The explicit limit of diffusion, h^2/(2 dim nu) with nu = 4/3 viscosity/rho. */
PetscReal MPMViscousStep(MPM mpm)
{
  PetscReal nu = 0;

  for (PetscInt k = 0; k < mpm->scene.nmaterials; k++)
    nu = PetscMax(nu, 4. / 3 * mpm->scene.materials[k].viscosity / mpm->scene.materials[k].rho);
  return nu > 0 ? PetscSqr(SmallestH(&mpm->grid)) / (2 * (PetscReal)mpm->grid.dim * nu) : PETSC_INFINITY;
}

/* dt of the next step, s: fixed, or cfl h/(c + |v|) of the state as it is, and no more than lets gravity move a
   particle from rest by a tenth of a cell, or is cfl of what viscosity allows. */
PetscReal MPMTimeStep(MPM mpm)
{
  const PetscReal h  = SmallestH(&mpm->grid);
  PetscReal       g2 = 0, dt;

  if (mpm->dt_fixed > 0) return mpm->dt_fixed;
  for (PetscInt d = 0; d < mpm->grid.dim; d++) g2 += mpm->params.gravity[d] * mpm->params.gravity[d];
  dt = mpm->dt_cfl * h / (PetscSqrtReal(mpm->status.c2) + PetscSqrtReal(mpm->status.v2));
  dt = PetscMin(dt, mpm->dt_cfl * MPMViscousStep(mpm));
  return g2 > 0 ? PetscMin(dt, PetscSqrtReal(0.2 * h / PetscSqrtReal(g2))) : dt;
}

/* Says why the step cannot stand, if so. */
static void CheckState(MPM mpm)
{
  const MPMStatus *s   = &mpm->status;
  const PetscInt   dim = mpm->grid.dim;
  PetscInt         b   = 0;
  char             at[128], who[2 * MPM_NAME_LEN];

  if (s->bad == MPM_OK) return;
  while (b + 1 < mpm->scene.nbodies && s->id >= mpm->scene.bodies[b + 1].first) b++;
  (void)snprintf(who, sizeof who, "particle %" PetscInt64_FMT " of %s", s->id, mpm->scene.bodies[b].name);
  (void)snprintf(at, sizeof at,
                 dim == 1   ? "(%g)"
                 : dim == 2 ? "(%g, %g)"
                            : "(%g, %g, %g)",
                 (double)s->x[0], (double)s->x[1], (double)s->x[2]);
  if (s->bad == MPM_LEFT_GRID && !(PetscAbsReal(s->x[0] + s->x[1] + s->x[2]) <= PETSC_MAX_REAL))
    (void)snprintf(mpm->stop, sizeof mpm->stop,
                   "%s has a position that is not finite, %s; reduce -dt_size or -dt_cfl, or look at -acceleration and "
                   "-loads",
                   who, at);
  else if (s->bad == MPM_LEFT_GRID)
    (void)snprintf(mpm->stop, sizeof mpm->stop,
                   "%s left the grid, to %s; enlarge the grid or close its walls (-bc_*_type)", who, at);
  else if (s->bad == MPM_TOO_WIDE)
    (void)snprintf(mpm->stop, sizeof mpm->stop,
                   "the domain of %s at %s is stretched to %g cells, gimp takes 1 at most; use more particles per cell "
                   "(-body_*_ppc) or a spline",
                   who, at, (double)s->J);
  else
    (void)snprintf(mpm->stop, sizeof mpm->stop,
                   "%s at %s is turned inside out or not finite (det F = %g); reduce -dt_size or -dt_cfl", who, at,
                   (double)s->J);
}

/* One step of the loop: choose dt, step, check. */
static PetscErrorCode Advance(MPM mpm)
{
  const PetscReal dt = MPMTimeStep(mpm);
  /* The last step ends at time_end; a remainder of rounding is not left for a step of its own. */
  const PetscBool last = mpm->time_end - mpm->t <= dt * (1 + 1e-9) ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBeginUser;
  if (!(dt > 0 && mpm->t + dt > mpm->t)) {
    (void)snprintf(mpm->stop, sizeof mpm->stop, "the time step, %g s, vanishes beside the time", (double)dt);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  mpm->params.dt = last ? mpm->time_end - mpm->t : dt;
  mpm->courant   = PetscMax(mpm->courant, MPMCourant(mpm, mpm->params.dt));
  PetscCall(MPMStep(mpm));
  CheckState(mpm);
  if (mpm->status.interrupted && !mpm->stop[0])
    (void)snprintf(mpm->stop, sizeof mpm->stop, "interrupted by a signal; the results are complete up to here");
  mpm->t = last ? mpm->time_end : mpm->t + mpm->params.dt;
  mpm->step++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* History and snapshots that are due, or all if forced. Collective on the exchange. */
static PetscErrorCode Output(MPM mpm, PetscLogStage stage, PetscBool force)
{
  PetscLogDouble t0, t1;

  PetscFunctionBeginUser;
  PetscCall(PetscLogStagePush(stage));
  PetscCall(MPMClock(mpm, &t0));
  PetscCall(MPMMonitorStep(mpm, force));
  PetscCall(MPMOutputStep(mpm, force));
  PetscCall(MPMClock(mpm, &t1));
  mpm->wall_output += t1 - t0;
  PetscCall(PetscLogStagePop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs the scene to its end, with output and history on the way. A reason to stop early is left in mpm->stop.
   Collective.                                                                                                        */
PetscErrorCode MPMRun(MPM mpm)
{
  PetscLogStage steps, output;

  PetscFunctionBeginUser;
  PetscCall(Stage("MPM steps", &steps));
  PetscCall(Stage("MPM output", &output));
  CatchSignals();
  if (mpm->exchange.data == MPI_COMM_NULL) {
    PetscCall(PetscLogStagePush(steps));
    PetscCall(MPMWorkStep(mpm));
    PetscCall(mpm->exchange.type->serve(mpm));
    PetscCall(PetscLogStagePop());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMReportStart(mpm));
  if (mpm->scene.dry_run) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Output(mpm, output, PETSC_TRUE));
  while (mpm->t < mpm->time_end && mpm->step < mpm->max_steps && !mpm->stop[0]) {
    PetscLogDouble t0, t1;

    PetscCall(MPMClock(mpm, &t0));
    PetscCall(PetscLogStagePush(steps));
    PetscCall(Advance(mpm));
    PetscCall(PetscLogStagePop());
    PetscCall(MPMClock(mpm, &t1));
    mpm->wall_steps += t1 - t0;
    if (mpm->status.bad != MPM_OK) break; /* not a state to measure or to show */
    PetscCall(Output(mpm, output, PETSC_FALSE));
    PetscCall(MPMReportProgress(mpm));
  }
  if (mpm->status.bad == MPM_OK) PetscCall(Output(mpm, output, PETSC_TRUE));
  PetscCall(MPMReportEnd(mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMDestroy(MPM *mpm)
{
  PetscFunctionBeginUser;
  PetscCall(MPMMonitorDestroy(&(*mpm)->monitor));
  PetscCall(MPMOutputDestroy(*mpm));
  if ((*mpm)->exchange.ready) {
    PetscCall((*mpm)->exchange.type->finish(*mpm));
    PetscCall(MPMWorkView(*mpm)); /* now that workers of the pool are free to take part */
  }
  PetscCall(MPMParticlesDestroy(&(*mpm)->particles));
  PetscCall(MPMSceneDestroy(&(*mpm)->scene));
  PetscCall(PetscFree((*mpm)->path.seconds));
  PetscCall(PetscFree(*mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
