/* mpm.c - a run from its options to its end: set-up, the loop over steps with their output, and the reasons to stop. */
#include "base/signals.h"
#include "parallel/exchange.h"
#include "run/mpm.h"
#include "scene/source.h"
#include "step/static.h"

#define MANY 2000000 /* particles: a set-up of so many says what it has done */

/* Makes an empty run on comm. Collective on comm. */
PetscErrorCode MPMCreate(MPI_Comm comm, MPM *mpm)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(mpm));
  (*mpm)->core.comm          = comm;
  (*mpm)->core.print.comm    = comm;
  (*mpm)->core.exchange.data = MPI_COMM_NULL;
  (*mpm)->checkpoint         = (MPMCheckpoint){.core    = &(*mpm)->core,
                                               .scene   = &(*mpm)->scene,
                                               .monitor = &(*mpm)->monitor,
                                               .output  = &(*mpm)->output,
                                               .list    = MPMStateList,
                                               .run     = *mpm};
  PetscCall(PetscTime(&(*mpm)->report.start));
  (*mpm)->report.base = MPMMemoryHere("VmRSS");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the options of a scene and of everything about its run; nothing is counted or checked by particles. The first
   fault is left in o. Collective on core.comm. */
PetscErrorCode MPMReadOptions(MPM mpm, MPMOptions o)
{
  MPMCore  *core  = &mpm->core;
  MPMScene *scene = &mpm->scene;

  PetscFunctionBeginUser;
  PetscCall(MPMPresetRead(mpm, o));
  PetscCall(MPMFrameSetFromOptions(mpm));
  PetscCall(MPMSceneSetFromOptions(scene, core, o));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  MPMPresetChoose(mpm);
  PetscCall(MPMMethodSetFromOptions(mpm, o));
  PetscCall(MPMAdvanceSetFromOptions(mpm, o));
  PetscCall(MPMWatchSetFromOptions(&mpm->watch, o));
  PetscCall(MPMExchangeSetFromOptions(core, o));
  PetscCall(MPMModelSetFromOptions(&mpm->cost, o));
  PetscCall(MPMDampingSetFromOptions(core, o));
  PetscCall(MPMRestSetFromOptions(core, o));
  if (MPMDampingIsOn(core) && core->rigids.free)
    MPMOptionsFail(o, "-damping_* does not apply: it would not brake the rigid bodies that are free");
  PetscCall(MPMMonitorSetFromOptions(&mpm->monitor, scene, mpm->time.end, o, MPMDampingIsOn(core), &core->energy.on));
  PetscCall(MPMOutputSetFromOptions(&mpm->output, scene, mpm->time.end, o));
  PetscCall(MPMMeasuresSetFromOptions(&mpm->monitor.measures, scene, core, o));
  PetscCall(MPMOptionsBool(o, "report_indicator", NULL, &mpm->report.indicator));
  PetscCall(MPMOptionsBool(o, "report_limits", NULL, &mpm->report.limits));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-report_limits", &mpm->report.no_limits));
  if (mpm->report.limits) mpm->report.no_limits = PETSC_FALSE;
  PetscCall(MPMOptionsBool(o, "report_phases", NULL, &mpm->report.phases));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-report_phases", &mpm->report.no_phases));
  if (mpm->report.phases) mpm->report.no_phases = PETSC_FALSE;
  PetscCall(MPMOptionsBool(o, "report_processes", NULL, &mpm->report.processes));
  PetscCall(MPMOptionsBool(o, "report_path", NULL, &core->timers.work.on));
  PetscCall(MPMStagesSetFromOptions(scene, o));
  PetscCall(MPMCheckpointSetFromOptions(&mpm->checkpoint, o));
  PetscCall(MPMStartNote(&scene->start, core, &scene->walls));
  PetscCall(MPMRestartSetFromOptions(&mpm->checkpoint, mpm->time.end, o));
  if (mpm->checkpoint.other) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsFinish(o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the scene and everything about its run, but makes neither grid nor particles. The first fault is left in o.
   Collective on core.comm. */
PetscErrorCode MPMSetFromOptions(MPM mpm, MPMOptions o)
{
  PetscFunctionBeginUser;
  PetscCall(MPMReadOptions(mpm, o));
  if (mpm->checkpoint.other) PetscFunctionReturn(PETSC_SUCCESS);
  if (!MPMOptionsError(o)) PetscCall(MPMSceneCountParticles(&mpm->scene, &mpm->core, o));
  if (!MPMOptionsError(o)) PetscCall(MPMPointsCount(&mpm->scene, &mpm->core, o));
  if (!MPMOptionsError(o) && mpm->scene.meets) PetscCall(MPMPointsOverlap(&mpm->scene, &mpm->core, o));
  if (!MPMOptionsError(o)) PetscCall(MPMVolumeLoadsCheck(&mpm->scene, &mpm->core, o));
  if (!MPMOptionsError(o)) MPMMeasuresNumber(&mpm->monitor.measures, &mpm->scene, &mpm->core, o);
  if (!MPMOptionsError(o)) PetscCall(MPMDoubtsRefuse(&mpm->core, &mpm->scene, &mpm->time, o));
  if (!MPMOptionsError(o)) PetscCall(MPMOutputMakeFolder(&mpm->output, &mpm->core, &mpm->scene, o));
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

/* Returns the fields of a material's state that a later stage needs (bits). */
static PetscInt KeptLater(MPM mpm, PetscInt material)
{
  return mpm->keeps ? mpm->keeps[material] : 0;
}

/* Returns whether anything but its law reads the deformation gradient of a material's particles: what is shown, domains
   that stretch, the volumes of F-bar, the energy by terms, the dissipation of bodies, walls that only push, gaps in
   bodies (advice/parting.c), a load on its surface. shown: bits of the fields that what is shown reads. */
static PetscBool ReadsF(MPM mpm, PetscInt shown, PetscInt material)
{
  const MPMScene *scene = &mpm->scene;

  if (shown & MPM_BIT(F) || KeptLater(mpm, material) & MPM_BIT(F) || mpm->core.grid.total || mpm->core.implicit ||
      mpm->core.needs.stretched || mpm->core.params.box || mpm->core.energy.on || mpm->core.energy.nheat)
    return PETSC_TRUE;
  if (MPMMaterialKeepsShape(&scene->materials[material]) &&
      (mpm->core.gaps || mpm->core.contacts || !MPMMaterialKnowsFlow(&scene->materials[material])))
    return PETSC_TRUE;
  for (PetscInt l = 0; l < scene->nloads; l++)
    if (!MPMLoadIsOnVolume(&scene->loads[l]) && scene->bodies[scene->loads[l].body].material == material)
      return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Finds what of its particles the scene needs, but for what the method adds (MPMStepSetUp). */
PetscErrorCode MPMSetNeeds(MPM mpm)
{
  MPMCore         *core  = &mpm->core;
  MPMScene        *scene = &mpm->scene;
  const PetscInt64 rows  = mpm->monitor.measures.shown | (mpm->output.enabled ? mpm->output.fields : 0);
  const PetscInt   shown = MPMDiagnosticReads(rows, core), flows = KeptLater(mpm, scene->nmaterials);

  PetscFunctionBeginUser;
  MPMWallsDerive(&scene->walls);
  MPMWallsReachTo(&scene->walls, &core->grid, core->basis);
  PetscCall(MPMGapsCreate(core, &scene->walls));
  for (PetscInt k = 0; k < scene->nmaterials; k++) {
    if (!ReadsF(mpm, shown, k)) MPMMaterialDropF(&scene->materials[k]);
    MPMMaterialKeep(&scene->materials[k], shown | KeptLater(mpm, k));
    core->needs.state |= scene->materials[k].state;
  }
  core->needs.kinds   = scene->nkinds > 1;
  core->needs.forced  = scene->forced || core->needs.all;
  core->needs.loaded  = scene->nloads > scene->nvolume;
  core->needs.chosen  = scene->nvolume > 0;
  core->needs.barred  = (core->grid.total || core->implicit) && core->params.box;
  core->needs.stepped = core->implicit && !core->grid.total;
  core->needs.start   = scene->keeps_start || core->grid.total || core->rest.on || core->implicit ||
                      (shown | flows) & MPM_BIT(X);
  core->needs.rim = core->gaps || core->contacts || flows & MPM_BIT(rim);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the phases of a step, the fields of particles and the constants of the cost model. Collective on core.comm. */
PetscErrorCode MPMSetPhases(MPM mpm)
{
  MPMCore  *core  = &mpm->core;
  MPMScene *scene = &mpm->scene;

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(core->changes.gravity, core->params.gravity, 3));
  PetscCall(MPMSetNeeds(mpm));
  core->params.kinds      = scene->kinds;
  core->params.nkinds     = scene->nkinds;
  core->params.materials  = scene->materials;
  core->params.nmaterials = scene->nmaterials;
  core->params.walls      = &scene->walls;
  for (PetscInt k = 0; k < 2 * core->grid.dim; k++) {
    const MPMWall type = scene->walls.given[k / 2][k % 2].type;

    if (type == MPM_WALL_piston) core->params.planes |= (PetscInt)1 << k;
    if (!MPMWallHas(type, MPM_WALL_NORMAL)) continue;
    if (core->basis == MPM_BASIS_gimp || MPMWallHas(type, MPM_WALL_PUSHES)) core->params.closed |= (PetscInt)1 << k;
  }
  PetscCall(MPMPistonsCreate(core));
  core->energy.loads   = scene->forced && (core->energy.on || !scene->body_force);
  core->params.carried = core->needs.all ? MPM_MATERIAL_BITS & ~MPM_BIT(F33) : 0;
  MPMVolumesSetUp(core, scene->materials, &mpm->time);
  PetscCall(MPMStepSetUp(core, &mpm->method));
  PetscCall(MPMParticlesLayout(&core->particles, core->grid.dim, &core->needs));
  MPMAdvanceSetUp(mpm);
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
    PetscCall(mpm->checkpoint.from[0] ? MPMRestartHistogram(&mpm->checkpoint, &h)
                                      : MPMSceneHistogram(&mpm->scene, core, &h));
    if (!mpm->checkpoint.from[0]) PetscCall(MPMPointsHistogram(&mpm->scene, core, &h));
    PetscCall(MPMHistogramFinish(&h));
    MPMModelCosts(&mpm->cost.model, core, (PetscReal)core->particles.total / size, &core->exchange.partition.costs);
  }
  PetscCall(core->exchange.type->setup(core, core->exchange.type->cuts ? &h : NULL));
  if (core->exchange.type->cuts) PetscCall(MPMHistogramDestroy(&h));
  core->exchange.ready = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says what the set-up of a large scene has done, since it takes a while. */
static PetscErrorCode TellSetUp(const MPMCore *core, const char done[])
{
  PetscFunctionBeginUser;
  if (core->particles.total >= MANY)
    PetscCall(MPMPrint(&core->print, "set-up     %" PetscInt64_FMT " particles are %s\n", core->particles.total, done));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes grid, patches and particles, and predicts the cost of a step. Collective on core.comm. */
PetscErrorCode MPMSetUp(MPM mpm)
{
  MPMCore      *core = &mpm->core;
  PetscLogStage stage;

  PetscFunctionBeginUser;
  PetscCall(MPMSetPhases(mpm));
  if (mpm->checkpoint.from[0]) PetscCall(MPMRestartCheckFields(&mpm->checkpoint));
  if (core->stop[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Stage("MPM set-up", &stage));
  PetscCall(PetscLogStagePush(stage));
  PetscCall(MPMWatchSetUp(&mpm->watch, core, &mpm->scene));
  PetscCall(TellSetUp(core, "counted and checked; they are being made"));
  PetscCall(SetUpExchange(mpm));
  if (core->exchange.data != MPI_COMM_NULL) { /* workers of the pool hold no particles */
    PetscCall(MPMParticlesCreate(&core->particles, core->exchange.data));
    PetscCall(mpm->checkpoint.from[0] ? MPMRestartParticles(&mpm->checkpoint)
                                      : MPMSceneAddParticles(&mpm->scene, core));
    if (!mpm->checkpoint.from[0]) PetscCall(MPMPointsAdd(&mpm->scene, core));
    PetscCall(TellSetUp(core, "made; they are being put in order"));
    PetscCall(core->exchange.type->settle(core, PETSC_TRUE));
    PetscCall(TellSetUp(core, "in order"));
    PetscCall(MPMContactsSettle(core));
    PetscCall(DMViewFromOptions(core->particles.swarm, NULL, "-dm_view"));
    if (core->grid.total) PetscCall(MPMTotalStart(core, (PetscBool)(mpm->checkpoint.from[0] != 0)));
    if (!mpm->checkpoint.from[0]) PetscCall(MPMSourcesBegin(&mpm->scene, core, PETSC_FALSE));
    PetscCall(MPMStepBound(core));
    if (mpm->checkpoint.from[0]) PetscCall(MPMRestartState(&mpm->checkpoint, &mpm->scene.walls));
    if (core->implicit && !core->stop[0]) { /* of the particles that are left (-remove) */
      PetscCall(MPMStaticCreate(core));
      if (core->stop[0]) mpm->watch.refused = PETSC_TRUE; /* for an option of PETSc's solvers */
    }
    if (mpm->checkpoint.from[0]) PetscCall(MPMSourcesBegin(&mpm->scene, core, PETSC_TRUE));
    if (core->grid.total) PetscCall(MPMMeetBegin(&mpm->watch, core, &mpm->scene));
    if (!mpm->retry.on) mpm->retry.limit = 0; /* after a restart nothing would raise it again */
    if (!core->implicit) PetscCall(MPMModelPredict(&mpm->cost, core, MPMTimeStep(core, &mpm->time)));
  }
  PetscCall(PetscLogStagePop());
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
  if (mpm->core.status.bad == MPM_NOT_FINITE)
    PetscCall(MPMCauseTell(&mpm->watch, &mpm->core, &mpm->scene, &mpm->method, &mpm->time, &mpm->core.status));
  if (!MPMStatusIsBad(&mpm->core.status)) PetscCall(MPMOutputStep(&mpm->output, &mpm->core, &mpm->scene, force));
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
  PetscCall(MPMPrintStart(mpm));
  if (mpm->checkpoint.from[0]) PetscCall(MPMRestartFiles(&mpm->checkpoint));
  if (mpm->scene.dry_run) PetscFunctionReturn(PETSC_SUCCESS);
  if (!mpm->checkpoint.from[0]) {
    PetscCall(MPMCheckpointNote(&mpm->checkpoint));
    PetscCall(Output(mpm, output, PETSC_TRUE));
  }
  mpm->report.t = core->t;
  while (!MPMEnds(mpm) && core->step < mpm->time.max_steps && !core->stop[0]) {
    PetscLogDouble t0, t1;

    PetscCall(MPMTimersClock(&core->timers, &t0));
    PetscCall(PetscLogStagePush(steps));
    PetscCall(MPMAdvance(mpm));
    PetscCall(PetscLogStagePop());
    PetscCall(MPMTimersClock(&core->timers, &t1));
    core->timers.steps += t1 - t0;
    if (MPMStatusIsBad(&core->status)) break; /* this state is neither measured nor written */
    PetscCall(MPMWatchRest(core, &mpm->scene));
    PetscCall(MPMRestLook(core, &mpm->scene));
    PetscCall(Output(mpm, output, PETSC_FALSE));
    PetscCall(MPMWatchState(&mpm->watch, core, &mpm->scene, &mpm->method, &mpm->time, &mpm->monitor));
    PetscCall(MPMCheckpointStep(&mpm->checkpoint, PETSC_FALSE));
    PetscCall(MPMReportForecast(&mpm->report, core, &mpm->time, &mpm->monitor, &mpm->output, &mpm->cost));
    PetscCall(MPMReportProgress(&mpm->report, core, &mpm->time));
  }
  /* A run that may go on gets its checkpoint before the output of its end, which a run without a stop does not have. */
  if (!MPMEnds(mpm) && !MPMStatusIsBad(&core->status)) PetscCall(MPMCheckpointStep(&mpm->checkpoint, PETSC_TRUE));
  if (mpm->retry.gave_up || mpm->monitor.exceeded || mpm->watch.stopped)
    PetscCall(MPMCheckpointOfStop(&mpm->checkpoint));
  if (!MPMStatusIsBad(&core->status))
    PetscCall(Output(mpm, output, PETSC_TRUE));
  else
    PetscCall(MPMMonitorStopped(&mpm->monitor, core, &mpm->scene));
  if (MPMEnds(mpm) && !MPMStatusIsBad(&core->status)) PetscCall(MPMCheckpointStep(&mpm->checkpoint, PETSC_TRUE));
  PetscCall(MPMOutputFinish(&mpm->output, core, &mpm->scene));
  PetscCall(MPMPrintEnd(mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees a run; the critical path is printed here. Collective on core.comm. */
PetscErrorCode MPMDestroy(MPM *mpm)
{
  MPMCore *core = &(*mpm)->core;

  PetscFunctionBeginUser;
  PetscCall(MPMWatchDestroy(&(*mpm)->watch, &(*mpm)->scene));
  PetscCall(MPMMonitorDestroy(&(*mpm)->monitor));
  PetscCall(MPMOutputDestroy(&(*mpm)->output));
  PetscCall(MPMStaticDestroy(core));
  if (core->exchange.ready) {
    PetscCall(core->exchange.type->finish(core));
    PetscCall(MPMWorkView(&(*mpm)->cost, core)); /* now that workers of the pool can take part */
  }
  PetscCall(PetscFree(core->exchange.boxes));
  PetscCall(MPMParticlesDestroy(&core->particles));
  PetscCall(MPMEnergyDestroy(&core->energy));
  PetscCall(MPMEnergyHeatDestroy(&core->energy));
  PetscCall(MPMReactionsDestroy(core));
  PetscCall(PetscFree(core->before));
  PetscCall(MPMContactsDestroy(core));
  PetscCall(MPMRigidsDestroy(core));
  PetscCall(MPMPistonsDestroy(core));
  PetscCall(MPMGapsDestroy(core));
  PetscCall(MPMTimersDestroy(&core->timers));
  PetscCall(PetscFree((*mpm)->checkpoint.options));
  PetscCall(MPMSceneDestroy(&(*mpm)->scene));
  PetscCall(PetscFree(*mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
