/* mpm.c - a run from its options to its end: set-up, the loop over steps with their output, and the reasons to stop. */
#include "base/signals.h"
#include "parallel/exchange.h"
#include "run/mpm.h"

/* Makes an empty run on comm. Collective on comm. */
PetscErrorCode MPMCreate(MPI_Comm comm, MPM *mpm)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(mpm));
  (*mpm)->core.comm          = comm;
  (*mpm)->core.print.comm    = comm;
  (*mpm)->core.exchange.data = MPI_COMM_NULL;
  PetscCall(PetscTime(&(*mpm)->report.start));
  (*mpm)->report.base = MPMMemoryHere("VmRSS");
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

/* Makes the folder of the results, unless a file in it must not be replaced. Collective on core.comm. */
static PetscErrorCode MakeFolder(MPM mpm, MPMOptions o)
{
  const char *type = mpm->study.type;
  char        table[2 * MPM_NAME_LEN];

  PetscFunctionBeginUser;
  (void)snprintf(table, sizeof table, type[0] ? "_%s.csv" : "", strcmp(type, "convergence") ? type : "study");
  PetscCall(MPMOutputMakeFolder(&mpm->output, &mpm->core, &mpm->scene, table, o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the scene and everything about its run, but makes neither grid nor particles. The first fault is left in o.
   Collective on core.comm. */
PetscErrorCode MPMSetFromOptions(MPM mpm, MPMOptions o)
{
  MPMCore  *core  = &mpm->core;
  MPMScene *scene = &mpm->scene;

  PetscFunctionBeginUser;
  PetscCall(MPMPresetRead(mpm, o));
  PetscCall(MPMSceneSetFromOptions(scene, core, o));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  MPMPresetChoose(mpm);
  PetscCall(MPMMethodSetFromOptions(mpm, o));
  PetscCall(ReadSafety(o));
  PetscCall(MPMExchangeSetFromOptions(core, o));
  PetscCall(MPMModelSetFromOptions(&mpm->cost, o));
  PetscCall(MPMMonitorSetFromOptions(&mpm->monitor, scene, mpm->time.end, o, &core->energy.on));
  PetscCall(MPMOutputSetFromOptions(&mpm->output, scene, mpm->time.end, o));
  PetscCall(MPMStudySetFromOptions(mpm, o));
  PetscCall(MPMOptionsBool(o, "report_indicator", NULL, &mpm->report.indicator));
  PetscCall(MPMOptionsBool(o, "report_limits", NULL, &mpm->report.limits));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-report_limits", &mpm->report.no_limits));
  if (mpm->report.limits) mpm->report.no_limits = PETSC_FALSE;
  PetscCall(MPMOptionsBool(o, "report_path", NULL, &core->timers.work.on));
  PetscCall(MPMCheckpointSetFromOptions(mpm, o));
  PetscCall(MPMRestartSetFromOptions(mpm, o));
  PetscCall(MPMOptionsFinish(o));
  if (!MPMOptionsError(o)) PetscCall(MPMSceneCountParticles(scene, core, o));
  if (!MPMOptionsError(o)) PetscCall(MPMDoubtsRefuse(mpm, o));
  if (!MPMOptionsError(o)) PetscCall(MakeFolder(mpm, o));
  mpm->monitor.dir = mpm->output.dir;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns a stage of -log_view, which a process registers once. */
static PetscErrorCode Stage(const char name[], PetscLogStage *stage)
{
  PetscFunctionBeginUser;
  PetscCall(PetscLogStageGetId(name, stage));
  if (*stage < 0) PetscCall(PetscLogStageRegister(name, stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether anything but its law reads the deformation gradient of a material's particles: domains that stretch, the
   volumes of F-bar, the energy by terms, a pressure on its surface, or snapshots. */
static PetscBool ReadsF(MPM mpm, PetscInt material)
{
  const MPMScene *scene = &mpm->scene;

  if (mpm->core.needs.stretched || mpm->core.params.box || mpm->core.energy.on ||
      (mpm->output.enabled && mpm->output.fields >> MPM_SHOWS_F & 1))
    return PETSC_TRUE;
  for (PetscInt l = 0; l < scene->nloads; l++)
    if (scene->loads[l].pressure && scene->bodies[scene->loads[l].body].material == material) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Sets the phases of a step, the fields of particles and the constants of the cost model. Collective on core.comm. */
PetscErrorCode MPMSetPhases(MPM mpm)
{
  MPMCore  *core  = &mpm->core;
  MPMScene *scene = &mpm->scene;

  PetscFunctionBeginUser;
  MPMWallsDerive(&scene->walls);
  core->params.kinds      = scene->kinds;
  core->params.nkinds     = scene->nkinds;
  core->params.materials  = scene->materials;
  core->params.nmaterials = scene->nmaterials;
  core->params.walls      = &scene->walls;
  for (PetscInt k = 0; k < scene->nmaterials; k++) {
    if (!ReadsF(mpm, k)) MPMMaterialDropF(&scene->materials[k]);
    core->needs.state |= scene->materials[k].state;
  }
  core->needs.kinds    = scene->nkinds > 1 ? PETSC_TRUE : PETSC_FALSE;
  core->needs.forced   = scene->forced || core->needs.all ? PETSC_TRUE : PETSC_FALSE;
  core->energy.loads   = scene->forced && (core->energy.on || !scene->body_force) ? PETSC_TRUE : PETSC_FALSE;
  core->needs.surface  = scene->nloads > 0 ? PETSC_TRUE : PETSC_FALSE;
  core->needs.start    = scene->keeps_start;
  core->params.carried = core->needs.all ? MPM_MATERIAL_BITS : 0;
  PetscCall(MPMStepSetUp(core, &mpm->method));
  PetscCall(MPMParticlesLayout(&core->particles, core->grid.dim, &core->needs));
  PetscCall(MPMModelSetUp(&mpm->cost, core, scene, mpm->output.dir));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes grid and patches. If the grid is cut, then by the particles as they will start. Collective on core.comm. */
static PetscErrorCode SetUpExchange(MPM mpm)
{
  MPMCore     *core = &mpm->core;
  MPMHistogram h;
  PetscMPIInt  size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  if (core->exchange.type->cuts) {
    PetscCall(MPMHistogramCreate(&core->grid, core->basis, core->comm, &h));
    PetscCall(mpm->checkpoint.from[0] ? MPMRestartHistogram(mpm, &h) : MPMSceneHistogram(&mpm->scene, core, &h));
    PetscCall(MPMHistogramFinish(&h));
    MPMModelCosts(&mpm->cost.model, core, (PetscReal)core->particles.total / size, &core->exchange.partition.costs);
  }
  PetscCall(core->exchange.type->setup(core, core->exchange.type->cuts ? &h : NULL));
  if (core->exchange.type->cuts) PetscCall(MPMHistogramDestroy(&h));
  core->exchange.ready = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes grid, patches and particles, and predicts the cost of a step. Collective on core.comm. */
PetscErrorCode MPMSetUp(MPM mpm)
{
  MPMCore      *core = &mpm->core;
  PetscLogStage stage;

  PetscFunctionBeginUser;
  PetscCall(MPMSetPhases(mpm));
  if (mpm->checkpoint.from[0]) PetscCall(MPMRestartCheckFields(mpm));
  if (core->stop[0]) {
    PetscCall(PetscFPrintf(core->comm, stderr, "%s\n", core->stop));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Stage("MPM set-up", &stage));
  PetscCall(PetscLogStagePush(stage));
  PetscCall(SetUpExchange(mpm));
  if (core->exchange.data != MPI_COMM_NULL) { /* workers of the pool hold no particles */
    PetscCall(MPMParticlesCreate(&core->particles, core->exchange.data));
    PetscCall(mpm->checkpoint.from[0] ? MPMRestartParticles(mpm) : MPMSceneAddParticles(&mpm->scene, core));
    PetscCall(core->exchange.type->settle(core, PETSC_TRUE));
    PetscCall(DMViewFromOptions(core->particles.swarm, NULL, "-dm_view"));
    PetscCall(MPMStepBound(core));
    if (mpm->checkpoint.from[0]) PetscCall(MPMRestartState(mpm));
    PetscCall(MPMModelPredict(&mpm->cost, core, MPMTimeStep(core, &mpm->time)));
  }
  PetscCall(PetscLogStagePop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the face of the grid with a wall beyond which the bad particle of the status lies, or -1. */
static PetscInt WallPassed(MPM mpm)
{
  const MPMGrid *grid = &mpm->core.grid;

  for (PetscInt k = 0; k < 2 * grid->dim; k++) {
    const PetscReal x = mpm->core.status.x[k / 2];

    if ((k % 2 ? x > grid->upper[k / 2] : x < grid->lower[k / 2]) &&
        mpm->scene.walls.given[k / 2][k % 2].type != MPM_WALL_free)
      return k;
  }
  return -1;
}

/* Writes to core.stop why the state after a step is not valid, if it is not. */
static void CheckState(MPM mpm)
{
  const MPMStatus *s   = &mpm->core.status;
  const PetscInt   dim = mpm->core.grid.dim;
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
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop,
                   "%s has a position that is not finite, %s; reduce -dt_size or -dt_cfl, or look at -acceleration and "
                   "-loads",
                   who, at);
  else if (s->bad == MPM_LEFT_GRID && WallPassed(mpm) >= 0)
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop, "%s left the grid, to %s, through its wall %s (%s); %s", who,
                   at, MPMFaceNames[WallPassed(mpm)],
                   MPMWallNames[mpm->scene.walls.given[WallPassed(mpm) / 2][WallPassed(mpm) % 2].type],
                   mpm->core.basis == MPM_BASIS_gimp
                       ? "with gimp the domains of particles reach beyond a wall: use bspline2"
                       : "reduce -dt_size or -dt_cfl");
  else if (s->bad == MPM_LEFT_GRID)
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop,
                   "%s left the grid, to %s; enlarge the grid or close its walls (-bc_*_type)", who, at);
  else if (s->bad == MPM_TOO_WIDE)
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop,
                   "the domain of %s at %s is stretched to %g cells, gimp takes 1 at most; use more particles per cell "
                   "(-body_*_ppc) or a spline",
                   who, at, (double)s->J);
  else
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop,
                   "%s at %s is turned inside out or not finite (det F = %g); reduce -dt_size or -dt_cfl%s", who, at,
                   (double)s->J,
                   mpm->scene.forced && PetscIsInfOrNanReal(s->J) ? ", or look at -acceleration and -loads" : "");
}

/* Makes one step of the loop: chooses dt, makes the step, and checks the state. Collective on the exchange. */
static PetscErrorCode Advance(MPM mpm)
{
  const PetscReal dt = MPMTimeStep(&mpm->core, &mpm->time);
  /* The last step ends at time_end. It may be slightly longer than dt, so that no step is made for a rounding error. */
  const PetscBool last = mpm->time.end - mpm->core.t <= dt * (1 + 1e-9) ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBeginUser;
  if (!(dt > 0 && mpm->core.t + dt > mpm->core.t)) {
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop, "the time step, %g s, vanishes beside the time", (double)dt);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMWatchStep(mpm, dt));
  mpm->core.params.dt = last ? mpm->time.end - mpm->core.t : dt;
  MPMDamp(&mpm->core, &mpm->method);
  mpm->courant = PetscMax(mpm->courant, MPMCourant(&mpm->core, mpm->core.params.dt));
  mpm->wave    = PetscMax(mpm->wave, MPMWaveCourant(&mpm->core, mpm->core.params.dt));
  PetscCall(MPMStep(&mpm->core, &mpm->scene));
  CheckState(mpm);
  if (mpm->core.status.asked == MPM_ASKED_END && !mpm->core.stop[0])
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop,
                   "interrupted by a signal; the results are complete up to here");
  mpm->core.t = last ? mpm->time.end : mpm->core.t + mpm->core.params.dt;
  mpm->core.step++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes history and snapshots, if they are due or `force` is set. Collective on the exchange. */
static PetscErrorCode Output(MPM mpm, PetscLogStage stage, PetscBool force)
{
  PetscLogDouble t0, t1;

  PetscFunctionBeginUser;
  PetscCall(PetscLogStagePush(stage));
  PetscCall(MPMTimersClock(&mpm->core.timers, &t0));
  PetscCall(MPMMonitorStep(&mpm->monitor, &mpm->core, &mpm->scene, force));
  PetscCall(MPMOutputStep(&mpm->output, &mpm->core, &mpm->scene, force));
  PetscCall(MPMTimersClock(&mpm->core.timers, &t1));
  mpm->core.timers.output += t1 - t0;
  PetscCall(PetscLogStagePop());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs the scene to its end, with history, snapshots and prints. A reason to stop early is left in core.stop.
   Collective on core.comm: workers of a pool take part. */
PetscErrorCode MPMRun(MPM mpm)
{
  MPMCore      *core = &mpm->core;
  PetscLogStage steps, output;

  PetscFunctionBeginUser;
  PetscCall(Stage("MPM steps", &steps));
  PetscCall(Stage("MPM output", &output));
  MPMSignalsCatch();
  if (core->exchange.data == MPI_COMM_NULL) {
    PetscCall(PetscLogStagePush(steps));
    PetscCall(MPMWorkStep(&core->timers, PETSC_TRUE));
    PetscCall(core->exchange.type->serve(core));
    PetscCall(PetscLogStagePop());
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMReportStart(mpm));
  if (mpm->checkpoint.from[0]) PetscCall(MPMRestartFiles(mpm));
  if (mpm->scene.dry_run) PetscFunctionReturn(PETSC_SUCCESS);
  if (!mpm->checkpoint.from[0]) {
    PetscCall(MPMCheckpointNote(mpm));
    PetscCall(Output(mpm, output, PETSC_TRUE));
  }
  while (core->t < mpm->time.end && core->step < mpm->time.max_steps && !core->stop[0]) {
    PetscLogDouble t0, t1;

    PetscCall(MPMTimersClock(&core->timers, &t0));
    PetscCall(PetscLogStagePush(steps));
    PetscCall(Advance(mpm));
    PetscCall(PetscLogStagePop());
    PetscCall(MPMTimersClock(&core->timers, &t1));
    core->timers.steps += t1 - t0;
    if (core->status.bad != MPM_OK) break; /* this state is neither measured nor written */
    PetscCall(Output(mpm, output, PETSC_FALSE));
    PetscCall(MPMWatchBodies(mpm));
    PetscCall(MPMCheckpointStep(mpm, PETSC_FALSE));
    PetscCall(MPMReportProgress(mpm));
  }
  /* A run that may go on gets its checkpoint before the output of its end, which a run without a stop does not have. */
  if (core->t < mpm->time.end && core->status.bad == MPM_OK) PetscCall(MPMCheckpointStep(mpm, PETSC_TRUE));
  if (core->status.bad == MPM_OK) PetscCall(Output(mpm, output, PETSC_TRUE));
  if (core->t >= mpm->time.end && core->status.bad == MPM_OK) PetscCall(MPMCheckpointStep(mpm, PETSC_TRUE));
  PetscCall(MPMOutputFinish(&mpm->output, core, &mpm->scene));
  PetscCall(MPMReportEnd(mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees a run; the critical path is printed here. Collective on core.comm. */
PetscErrorCode MPMDestroy(MPM *mpm)
{
  MPMCore *core = &(*mpm)->core;

  PetscFunctionBeginUser;
  PetscCall(MPMMonitorDestroy(&(*mpm)->monitor));
  PetscCall(MPMOutputDestroy(&(*mpm)->output));
  if (core->exchange.ready) {
    PetscCall(core->exchange.type->finish(core));
    PetscCall(MPMWorkView(&(*mpm)->cost, core)); /* now that workers of the pool can take part */
  }
  PetscCall(PetscFree(core->exchange.boxes));
  PetscCall(MPMParticlesDestroy(&core->particles));
  PetscCall(MPMEnergyDestroy(&core->energy));
  PetscCall(MPMTimersDestroy(&core->timers));
  PetscCall(PetscFree((*mpm)->checkpoint.options));
  PetscCall(MPMSceneDestroy(&(*mpm)->scene));
  PetscCall(PetscFree(*mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
