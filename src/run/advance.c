/* advance.c - a step of the loop: how long it is, whether the state after it is valid, and what is done if it is not.
   With -check_state retry the step is a transaction: what it changes is copied before, and a step that fails is undone
   and made again with half the time step. Every decision follows from the reduced status and from exact sums, so all
   processes, of any number, decide the same. */
#include "base/signals.h"
#include "run/mpm.h"
#include "scene/source.h"
#include "step/static.h"

/* Reads -check_state, -dt_retry, -dt_max_growth and -particles_leave; faults are left in o. Not collective. */
PetscErrorCode MPMAdvanceSetFromOptions(MPM mpm, MPMOptions o)
{
  MPMRetry *r = &mpm->retry;
  char      state[MPM_NAME_LEN], leave[MPM_NAME_LEN];
  PetscBool most_set, growth_set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "check_state", NULL, state, NULL));
  PetscCall(MPMOptionsEnum(o, "particles_leave", NULL, leave, NULL));
  PetscCall(MPMOptionsInt(o, "dt_retry", NULL, &r->most, &most_set));
  PetscCall(MPMOptionsReal(o, "dt_max_growth", NULL, &r->growth, &growth_set));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  r->on                    = !strcmp(state, "retry") || mpm->core.implicit;
  mpm->core.params.deletes = !strcmp(leave, "delete");
  if (r->on) PetscFunctionReturn(PETSC_SUCCESS);
  if (most_set && !MPMOptionsOverridden("dt_retry", "check_state"))
    MPMOptionsFail(o, "-dt_retry does not apply: -check_state is stop, it needs -check_state retry");
  if (growth_set && !MPMOptionsOverridden("dt_max_growth", "check_state"))
    MPMOptionsFail(o, "-dt_max_growth does not apply: -check_state is stop, it needs -check_state retry");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the fields that a step changes, after the phases of a step are known: those that its phases write and that live
   on. */
void MPMAdvanceSetUp(MPM mpm)
{
  MPMCore *core = &mpm->core;
  PetscInt out  = 0;

  for (PetscInt k = 0; k < core->nprogram + core->nrare && mpm->retry.on; k++) out |= core->program[k]->particles_out;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (MPMFields[f].home == MPM_SCRATCH) out &= ~(1 << f);
  core->particles.saved = out;
}

/* Returns the face of the grid with a wall beyond which the bad particle of the status lies, or -1. */
static PetscInt WallPassed(MPM mpm)
{
  const MPMGrid *grid = &mpm->core.grid;

  for (PetscInt k = 0; k < 2 * grid->dim; k++) {
    const PetscReal x = mpm->core.status.x[k / 2];

    if ((k % 2 ? x > grid->upper[k / 2] : x < grid->lower[k / 2]) &&
        MPMWallHas(mpm->scene.walls.given[k / 2][k % 2].type, MPM_WALL_NORMAL))
      return k;
  }
  return -1;
}

/* Names the particle of the status and its place. */
static void NameParticle(MPM mpm, char who[2 * MPM_NAME_LEN], char at[MPM_NAME_LEN])
{
  const MPMStatus *s   = &mpm->core.status;
  const PetscInt   dim = mpm->core.grid.dim;

  (void)snprintf(who, 2 * MPM_NAME_LEN, "particle %" PetscInt64_FMT " of %s", s->id,
                 mpm->scene.bodies[MPMBodyOf(&mpm->scene, s->id, 0)].name);
  MPMPlaceWords(dim, s->x, at);
}

/* Writes to core.stop what is wrong with the state after a step, if anything is; MPMCauseTell knows why. */
static void CheckState(MPM mpm)
{
  const MPMStatus *s = &mpm->core.status;
  char             at[MPM_NAME_LEN], who[2 * MPM_NAME_LEN];

  if (!MPMStatusIsBad(s)) return;
  NameParticle(mpm, who, at);
  if (s->bad == MPM_LEFT_GRID && !(PetscAbsReal(s->x[0] + s->x[1] + s->x[2]) <= PETSC_MAX_REAL))
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop, "%s has a position that is not finite, %s", who, at);
  else if (s->bad == MPM_LEFT_GRID && WallPassed(mpm) >= 0)
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop, "%s left the grid, to %s, through its wall %s (%s)", who, at,
                   MPMFaceNames[WallPassed(mpm)],
                   MPMWallNames[mpm->scene.walls.given[WallPassed(mpm) / 2][WallPassed(mpm) % 2].type]);
  else if (s->bad == MPM_LEFT_GRID)
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop, "%s left the grid, to %s", who, at);
  else if (s->bad == MPM_TOO_WIDE)
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop,
                   "the domain of %s at %s is stretched to %g cells, gimp allows 1 at most", who, at, (double)s->J);
  else
    (void)snprintf(mpm->core.stop, sizeof mpm->core.stop, "%s at %s is turned inside out or not finite (det F = %g)",
                   who, at, (double)s->J);
}

/* Appends to core.stop why a state is not valid, if `bad` says that it is not. Collective on exchange.data. */
static PetscErrorCode TellCause(MPM mpm, const MPMStatus *bad)
{
  PetscFunctionBeginUser;
  if (MPMStatusIsBad(bad)) PetscCall(MPMCauseTell(&mpm->watch, &mpm->core, &mpm->scene, &mpm->method, &mpm->time, bad));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Undoes a step: all that it changed, of which there is a copy. Not collective. */
static PetscErrorCode Undo(MPM mpm, const MPMVariables *variables, const char copy[])
{
  PetscFunctionBeginUser;
  if (mpm->core.status.asked == MPM_ASKED_CHECKPOINT)
    MPMSignalsAsk(); /* the step that is made in its place hears of it */
  PetscCall(MPMVariablesPutBack(variables, copy));
  PetscCall(MPMParticlesPutBack(&mpm->core.particles));
  mpm->core.stop[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the time at which a step must not be passed: the end, or that of the next output with -output_exact or
   -history_exact. */
static PetscReal NextTime(MPM mpm)
{
  PetscReal t = mpm->time.end;

  if (mpm->output.exact) t = PetscMin(t, MPMNextExact(mpm->core.t, mpm->output.every));
  if (mpm->monitor.exact) t = PetscMin(t, MPMNextExact(mpm->core.t, mpm->monitor.every));
  return t;
}

/* Makes a step of dt at most, but does not settle it. If the state after it is not valid, core.stop says so. Collective
   on the exchange. */
static PetscErrorCode Try(MPM mpm, PetscReal dt)
{
  MPMCore *core = &mpm->core;
  /* The last step ends at time_end, or at an exact time of output. It may be slightly longer than dt, so that no step
     is made for a rounding error. The steps up to there are equally long if dt does not change: a last one that is much
     shorter would be a sudden change of dt. Of a fixed dt only the last one is shorter. */
  const PetscReal next = NextTime(mpm), left = next - core->t;
  const PetscBool last = left <= dt * (1 + 1e-9);
  const PetscReal now  = last ? left : mpm->time.fixed > 0 ? dt : left / PetscCeilReal(left / dt * (1 - 1e-9));

  PetscFunctionBeginUser;
  core->params.kick = MPMKick(core->step && core->params.dt > 0 ? core->params.dt : now,
                              now); /* dt 0: implicit steps end here */
  if (core->grid.total && !core->implicit && (!core->step || core->damping.rest)) core->params.kick = 0.5 * now;
  core->params.dt = now;
  MPMDamp(core, &mpm->method);
  PetscCall(MPMSceneMoveWalls(&mpm->scene, core, core->t + 0.5 * core->params.dt));
  PetscCall(MPMSceneMoveRigids(&mpm->scene, core, core->t + 0.5 * core->params.dt));
  mpm->watch.courant = PetscMax(mpm->watch.courant, MPMCourant(core, core->params.dt));
  mpm->watch.wave    = PetscMax(mpm->watch.wave, MPMWaveCourant(core, core->params.dt));
  if (core->grid.total) MPMTotalPass(core);
  PetscCall(MPMStepMake(core, &mpm->scene));
  MPMScenePassWalls(&mpm->scene, core, core->params.dt);
  MPMRigidsMove(core);
  CheckState(mpm);
  core->t = last ? next : core->t + core->params.dt;
  core->kicked += core->params.kick;
  core->step++;
  if (mpm->retry.on && !core->stop[0]) PetscCall(MPMMonitorLook(&mpm->monitor, core, &mpm->scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tells the first retry of the run. */
static PetscErrorCode TellRetry(MPM mpm, const char why[], PetscReal dt)
{
  PetscFunctionBeginUser;
  if (mpm->retry.undone > 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMSay(&mpm->core.print, "retry",
                   "step %" PetscInt_FMT " from t=%g s is undone and made again with dt=%.3g s: %s", mpm->core.step + 1,
                   (double)mpm->core.t, (double)dt, why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a step; while it fails, it is undone and made with half the time step. No step is shorter than normal / 2^most,
   where normal is what the state allows, or what is left of the time: so a run in which steps fail again and again
   ends. Afterwards the time step grows again, until it is the normal one. Collective on the exchange. */
static PetscErrorCode TryAgain(MPM mpm, PetscReal normal, PetscReal dt)
{
  MPMCore        *core   = &mpm->core;
  MPMRetry       *r      = &mpm->retry;
  const PetscReal least  = ldexp(PetscMin(normal, NextTime(mpm) - core->t), (int)-r->most) * (1 - 1e-9);
  PetscBool       undone = PETSC_FALSE;
  MPMStatus       bad;
  MPMVariables    variables;
  char           *copy;

  PetscFunctionBeginUser;
  MPMStateList(mpm, &variables);
  PetscCall(MPMVariablesSave(&variables, &copy));
  PetscCall(MPMParticlesSave(&core->particles));
  for (;;) {
    char      why[MPM_TEXT_LEN];
    PetscReal tried;

    PetscCall(Try(mpm, dt));
    if (!core->stop[0]) break;
    (void)snprintf(why, sizeof why, "%s", core->stop);
    tried = core->params.dt;
    bad   = core->status;
    PetscCall(Undo(mpm, &variables, copy));
    if (0.5 * tried < least || !(core->t + 0.5 * tried > core->t)) {
      r->gave_up = PETSC_TRUE;
      if (!undone) r->steps++;
      PetscCall(PetscFree(copy));
      (void)snprintf(
          core->stop, sizeof core->stop,
          "%.600s; with dt=%g s it still fails, -dt_retry allows no shorter step; the state is that before it", why,
          (double)tried);
      PetscCall(TellCause(mpm, &bad));
      PetscFunctionReturn(PETSC_SUCCESS);
    }
    dt = 0.5 * tried;
    if (!undone) r->steps++;
    if (r->undone == 0 || dt < r->least) r->least = dt;
    undone = PETSC_TRUE;
    r->undone++;
    PetscCall(TellRetry(mpm, why, dt));
  }
  PetscCall(PetscFree(copy));
  if (!undone && !(r->limit > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  r->limit = dt * r->growth < normal ? dt * r->growth : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets matter flow in that has come to the front of its source. The next step is as short as it needs. Collective on
   the exchange. */
static PetscErrorCode Enter(MPM mpm)
{
  MPMCore  *core = &mpm->core;
  MPMStatus was;
  PetscInt  first;
  PetscBool any;

  PetscFunctionBeginUser;
  PetscCall(MPMSourcesEnter(&mpm->scene, core, &first, &any));
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMLostEnter(&mpm->scene, core, first));
  PetscCall(core->exchange.type->settle(core, PETSC_TRUE));
  PetscCall(MPMContactsSettle(core));
  was = core->status;
  PetscCall(MPMStepBound(core));
  was.v2       = PetscMax(was.v2, core->status.v2);
  was.c2       = PetscMax(was.c2, core->status.c2);
  core->status = was;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends a step whose state is valid: particles outside the grid are counted, the first one is named, and they are
   removed when the step is settled. Collective on the exchange. */
static PetscErrorCode End(MPM mpm)
{
  MPMCore *core = &mpm->core;
  char     who[2 * MPM_NAME_LEN], at[128];

  PetscFunctionBeginUser;
  if (core->status.bad == MPM_GONE) {
    NameParticle(mpm, who, at);
    if (core->particles.total + core->particles.waiting == core->particles.born) {
      PetscCall(MPMWarn(&core->print, "%s left the grid at t=%g s, to %s, and is removed (-particles_leave delete)",
                        who, (double)core->t, at));
    }
    PetscCall(MPMLostAdd(&mpm->scene, core));
  }
  PetscCall(MPMStepSettle(core));
  if (core->particles.waiting) PetscCall(Enter(mpm));
  if (!core->particles.total)
    (void)snprintf(core->stop, sizeof core->stop,
                   "no particle is left in the grid, the last one was %s, which left to %s", who, at);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes one step of the loop: chooses dt, makes the step, and checks the state. Collective on the exchange. */
PetscErrorCode MPMAdvance(MPM mpm)
{
  MPMCore        *core   = &mpm->core;
  const PetscReal normal = MPMTimeStep(core, &mpm->time), limit = mpm->retry.limit,
                  dt = limit > 0 ? PetscMin(normal, limit) : normal;

  PetscFunctionBeginUser;
  if (!(dt > 0 && core->t + dt > core->t)) {
    PetscCall(MPMWatchShort(&mpm->watch, core, &mpm->scene, &mpm->method, &mpm->time, dt));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMSceneCheckWalls(&mpm->scene, core, core->t + 0.5 * dt));
  if (!core->stop[0]) PetscCall(MPMSceneCheckRigids(&mpm->scene, core, core->t + 0.5 * dt));
  if (core->stop[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMWatchStep(&mpm->watch, core, &mpm->scene, &mpm->time, normal));
  PetscCall(mpm->retry.on ? TryAgain(mpm, normal, dt) : Try(mpm, dt));
  if (!mpm->retry.gave_up) PetscCall(TellCause(mpm, &core->status));
  if (!MPMStatusIsBad(&core->status) && !mpm->retry.gave_up) PetscCall(End(mpm));
  if (!core->stop[0]) PetscCall(MPMStaticCheckOptions(core));
  MPMSceneCheckPistons(&mpm->scene, core);
  MPMRigidsCheck(core);
  if (core->status.asked == MPM_ASKED_END && !core->stop[0])
    (void)snprintf(core->stop, sizeof core->stop, "interrupted by a signal; the results are complete up to here");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints what the particles took along that left the grid and were removed, as the history has it. */
static PetscErrorCode PrintLost(MPM mpm)
{
  const MPMParticles *particles = &mpm->core.particles;
  const MPMTotals    *now       = &mpm->monitor.now;
  const PetscInt64    left      = particles->born - particles->waiting - particles->total;

  PetscFunctionBeginUser;
  if (particles->flows)
    PetscCall(MPMPrint(&mpm->core.print,
                       "sources    %" PetscInt64_FMT
                       " particles have not flowed in yet; what flowed in, less what left, is %.3g kg\n",
                       particles->waiting, 0 - (double)now->sum[MPM_SHOWS_lost_mass][0]));
  if (!left || particles->flows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMPrint(&mpm->core.print,
                     "lost       %" PetscInt64_FMT " of %" PetscInt64_FMT
                     " particles %s, with %.3g of %.3g kg, momentum (",
                     particles->born - particles->total, particles->born,
                     particles->removed ? "left with their bodies or left the grid" : "left the grid and were removed",
                     (double)now->sum[MPM_SHOWS_lost_mass][0], (double)mpm->monitor.start.sum[MPM_SHOWS_mass][0]));
  for (PetscInt d = 0; d < mpm->core.grid.dim; d++)
    PetscCall(MPMPrint(&mpm->core.print, "%s%.3g", d ? ", " : "", (double)now->sum[MPM_SHOWS_lost_momentum][d]));
  PetscCall(MPMPrint(&mpm->core.print, ") kg m/s and energy %.3g J\n",
                     (double)(now->sum[MPM_SHOWS_lost_kinetic_energy][0] + now->sum[MPM_SHOWS_lost_strain_energy][0])));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in mpm.h. */
PetscErrorCode MPMAdvanceReport(MPM mpm)
{
  PetscFunctionBeginUser;
  PetscCall(PrintLost(mpm));
  if (mpm->retry.undone)
    PetscCall(MPMPrint(&mpm->core.print,
                       "retries    %" PetscInt_FMT " tries were undone, in %" PetscInt_FMT " of %" PetscInt_FMT
                       " steps, with time steps down to %.3g s\n",
                       mpm->retry.undone, mpm->retry.steps, mpm->core.step, (double)mpm->retry.least));
  PetscFunctionReturn(PETSC_SUCCESS);
}
