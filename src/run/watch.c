/* watch.c - what is watched while a run runs: a time step that collapses, before each step; whether bodies rest that start
   with the stress by their weight, after the first step; and after some steps matter that parts (parting.c) and laws
   that leave their range (ranges.c). Each is told once, the time step again at the end. It changes no state. */
#include "run/mpm.h"

/* Takes particle p of a view, if its value is larger, or as large and its id smaller. */
static void Take(const MPMView *view, PetscInt dim, PetscInt p, PetscReal value, MPMFound *f)
{
  MPMFound found = {value, 16 * view->id[p], {0}, {0}};

  if (!(value >= f->value)) return;
  for (PetscInt d = 0; d < dim; d++) found.x[d] = view->x[p * dim + d];
  MPMFoundTake(f, &found);
}

static const char *NameOf(MPM mpm, const MPMFound *f)
{
  return mpm->scene.bodies[MPMBodyOf(&mpm->scene, f->key / 16, 0)].name;
}

/* --- Options ------------------------------------------------------------------------------------------------------ */

PetscErrorCode MPMWatchSetFromOptions(MPM mpm, MPMOptions o)
{
  char part[MPM_NAME_LEN], law[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "check_parting", NULL, part, NULL));
  PetscCall(MPMOptionsEnum(o, "check_law", NULL, law, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  mpm->watch.may_part  = !strcmp(part, "warn") ? PETSC_TRUE : PETSC_FALSE;
  mpm->watch.may_leave = !strcmp(law, "warn") ? PETSC_TRUE : PETSC_FALSE;
  mpm->watch.torn_at = mpm->watch.grows_at = -1;
  mpm->watch.near                          = 1; /* until the first look */
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMWatchSetUp(MPM mpm)
{
  const MPMScene *scene = &mpm->scene;
  PetscBool       may   = PETSC_FALSE;

  PetscFunctionBeginUser;
  mpm->watch.ranges = MPMRangesOf(scene);
  for (PetscInt m = 0; m < scene->nmaterials; m++) may = may || MPMNeighboursMay(&scene->materials[m]);
  if (!may) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(scene->nbodies, &mpm->watch.neighbours));
  for (PetscInt b = 0; b < scene->nfilled; b++)
    if (MPMNeighboursMay(&scene->materials[scene->bodies[b].material]))
      PetscCall(MPMNeighboursCreate(scene, &mpm->core, &scene->bodies[b], &mpm->watch.neighbours[b]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMWatchDestroy(MPM mpm)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < mpm->scene.nbodies && mpm->watch.neighbours; b++)
    PetscCall(MPMNeighboursDestroy(&mpm->watch.neighbours[b]));
  PetscCall(PetscFree(mpm->watch.neighbours));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The time step and the rest ----------------------------------------------------------------------------------- */

/* Finds what limits the time step: the fastest particle, or the body with the fastest wave. Collective on
   exchange.data. */
static PetscErrorCode FindCause(MPM mpm)
{
  MPMCore        *core  = &mpm->core;
  const PetscBool wave  = core->status.c2 >= core->status.v2 ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt  dim   = core->grid.dim,
                 fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v) | MPM_MATERIAL_BITS | MPM_BIT(kind);
  MPMFound most         = {-1, -1, {0}, {0}};
  MPMView  view;
  MPMBlock b;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMMaterial *m     = core->params.materials + MPMKindOf(core->params.kinds, &view, p)->material;
    PetscReal          value = 0;

    MPMMaterialState(dim, &view, p, &b);
    if (wave)
      m->type->law->speed2[dim - 1](m, 0, 1, &b, &value);
    else
      for (PetscInt d = 0; d < dim; d++) value += view.v[p * dim + d] * view.v[p * dim + d];
    Take(&view, dim, p, value, &most);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(MPMFoundAgree(&most, core->exchange.data));
  mpm->watch.limits = most.key / 16;
  if (wave)
    (void)snprintf(mpm->watch.cause, sizeof mpm->watch.cause, "the wave speed %.3g m/s in %s",
                   (double)PetscSqrtReal(most.value), NameOf(mpm, &most));
  else
    (void)snprintf(mpm->watch.cause, sizeof mpm->watch.cause,
                   "the speed %.3g m/s of particle %" PetscInt64_FMT " of %s", (double)PetscSqrtReal(most.value),
                   most.key / 16, NameOf(mpm, &most));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Clears the line of progress, over which a warning is printed. */
static PetscErrorCode Clear(MPM mpm)
{
  PetscFunctionBeginUser;
  if (mpm->report.progress) PetscCall(MPMPrint(&mpm->core.print, "\r\033[K"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in watch.h. The cause is found where dt has fallen below a hundredth of the first, and anew at each further
   tenth of that. */
PetscErrorCode MPMWatchStep(MPM mpm, PetscReal dt)
{
  MPMWatch       *w    = &mpm->watch;
  const PetscBool told = w->cause[0] ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBeginUser;
  if (mpm->core.step == 0) w->first = w->least = dt;
  if (!(dt < w->least)) PetscFunctionReturn(PETSC_SUCCESS);
  w->least = dt;
  w->t     = mpm->core.t;
  if (dt >= (told ? 0.1 * w->told : MPM_COLLAPSE * w->first)) PetscFunctionReturn(PETSC_SUCCESS);
  w->told = dt;
  PetscCall(FindCause(mpm));
  if (told) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Clear(mpm));
  PetscCall(MPMWarn(&mpm->core.print,
                    "dt has fallen to %.3g s at t=%g s, from %.3g s: %s limits it; about %.3g steps are left",
                    (double)dt, (double)w->t, (double)w->first, w->cause, (double)((mpm->time.end - w->t) / dt)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in watch.h. */
PetscErrorCode MPMWatchShort(MPM mpm, PetscReal dt)
{
  MPMCore  *core = &mpm->core;
  MPMStatus at   = core->status;

  PetscFunctionBeginUser;
  if (mpm->time.fixed > 0) {
    (void)snprintf(core->stop, sizeof core->stop,
                   "the time step, %g s, is too short to change the time; use a larger -dt_size, or -dt_size auto",
                   (double)dt);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(FindCause(mpm));
  (void)snprintf(core->stop, sizeof core->stop, "the time step, %g s, is too short to change the time: %s limits it",
                 (double)dt, mpm->watch.cause);
  at.id  = mpm->watch.limits;
  at.bad = MPM_NOT_FINITE;
  PetscCall(MPMCauseTell(mpm, &at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in watch.h. Damping means that the body shall settle. */
PetscErrorCode MPMWatchRest(MPM mpm)
{
  MPMCore        *core = &mpm->core;
  const PetscInt  dim = core->grid.dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v);
  const PetscReal g    = MPMInitialGravity(&mpm->scene);
  MPMFound        most = {-1, -1, {0}, {0}};
  char            place[MPM_NAME_LEN];
  MPMView         view;

  PetscFunctionBeginUser;
  if (core->step != 1 || !(g > 0) || MPMDampingIsOn(core)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < mpm->scene.nbodies; k++)
    if (mpm->scene.bodies[k].v2 > 0) PetscFunctionReturn(PETSC_SUCCESS); /* nor shall it rest */
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal v2 = 0;

    for (PetscInt d = 0; d < dim; d++) v2 += view.v[p * dim + d] * view.v[p * dim + d];
    Take(&view, dim, p, PetscSqrtReal(v2) / (g * core->t), &most);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(MPMFoundAgree(&most, core->exchange.data));
  if (!(most.value > MPM_RESTLESS)) PetscFunctionReturn(PETSC_SUCCESS);
  MPMPlaceWords(dim, most.x, place);
  PetscCall(MPMWarn(
      &core->print,
      "%s does not rest in its stress of -initial_stress k0: near %s it starts with an acceleration of %.2g g. It "
      "needs a level surface, a wall below and walls at all sides; else let it settle with -damping_kinetic",
      NameOf(mpm, &most), place, (double)most.value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The state ---------------------------------------------------------------------------------------------------- */

/* Warns of matter that will part, or stops the run where it has parted. Collective on exchange.data. */
static PetscErrorCode WatchParting(MPM mpm)
{
  MPMCore  *core = &mpm->core;
  MPMWatch *w    = &mpm->watch;
  MPMFound  wide, parted;
  PetscBool noisy;
  char      what[MPM_TEXT_LEN], noise[MPM_TEXT_LEN] = "", cure[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMPartingLook(mpm, &w->near, &wide, &parted));
  if (wide.value > 1 && w->torn_at < 0) w->torn_at = core->t;
  noisy = w->grows_at >= 0 ? MPMMethodAmplifies(mpm, noise, cure) : PETSC_FALSE;
  if (parted.value > 1 && !w->may_part && !core->stop[0]) {
    MPMPartingTell(mpm, &parted, PETSC_TRUE, what);
    if (!noisy) MPMPartingCure(mpm, &parted, cure);
    (void)snprintf(core->stop, sizeof core->stop, "%.600s%s%.300s; use %.600s, or let it part (-check_parting warn)",
                   what, noisy ? "; " : "", noise, cure);
    w->stopped = PETSC_TRUE;
  } else if (wide.value > 1 && !w->torn) {
    w->torn = PETSC_TRUE;
    MPMPartingTell(mpm, parted.value > 1 ? &parted : &wide, parted.value > 1 ? PETSC_TRUE : PETSC_FALSE, what);
    if (!noisy) MPMPartingCure(mpm, &wide, cure);
    PetscCall(Clear(mpm));
    PetscCall(MPMWarn(&core->print, "seen at t=%g s: %.600s%s%.300s; use %.600s", (double)core->t, what,
                      noisy ? "; " : "", noise, cure));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of laws that leave their range, or stops the run where its result means nothing. Collective on exchange.data.
   */
static PetscErrorCode WatchRanges(MPM mpm)
{
  MPMCore  *core = &mpm->core;
  MPMWatch *w    = &mpm->watch;
  PetscInt  beyond, lost;
  MPMFound  most[MPM_MAX_RANGES];
  char      what[MPM_TEXT_LEN], cure[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMRangesLook(mpm, &beyond, &lost, most));
  for (PetscInt r = 0; r < MPM_MAX_RANGES; r++) {
    if (!(beyond & 1 << r)) continue;
    MPMRangesTell(mpm, r, &most[r], what);
    MPMRangesCure(mpm, r, &most[r], cure);
    if ((lost & 1 << r) && !w->may_leave && !core->stop[0]) {
      (void)snprintf(core->stop, sizeof core->stop, "%.900s; use %.700s, or go on all the same (-check_law warn)", what,
                     cure);
      w->stopped = PETSC_TRUE;
    } else if (!(w->beyond & 1 << r)) {
      PetscCall(Clear(mpm));
      PetscCall(MPMWarn(&core->print, "seen at t=%g s: %.900s; use %.700s", (double)core->t, what, cure));
    }
    w->beyond |= 1 << r;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in watch.h. */
PetscErrorCode MPMWatchState(MPM mpm, PetscBool last)
{
  const MPMShown        shown   = MPMMonitorShown(&mpm->monitor, &mpm->core, &mpm->scene);
  static const PetscInt every[] = {MPM_WATCH_FAR, MPM_WATCH_NEAR, MPM_WATCH_PARTS};
  MPMWatch             *w       = &mpm->watch;

  PetscFunctionBeginUser;
  if (mpm->core.stop[0]) PetscFunctionReturn(PETSC_SUCCESS);
  if (mpm->monitor.last == mpm->core.step && MPMEnergyIsFollowed(mpm)) {
    const PetscReal most = mpm->monitor.energy_max + PetscAbsReal(MPMShownWork(&shown));

    if (!(MPMShownResidual(&shown) > MPM_ENERGY_GROWN * most))
      w->grows_at = -1;
    else if (w->grows_at < 0)
      w->grows_at = mpm->core.t;
  }
  if (w->ranges && (last || mpm->core.step % MPM_WATCH_LAWS == 0)) PetscCall(WatchRanges(mpm));
  if (w->neighbours && mpm->core.step % every[w->near] == 0)
    PetscCall(WatchParting(mpm));
  else if (w->neighbours && last) {
    const PetscInt near = w->near; /* a run that goes on from here looks when one would that had not ended */

    PetscCall(WatchParting(mpm));
    w->near = near;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in watch.h. */
PetscErrorCode MPMWatchEnd(MPM mpm)
{
  const MPMWatch *w = &mpm->watch;

  PetscFunctionBeginUser;
  if (w->cause[0])
    PetscCall(MPMWarn(
        &mpm->core.print,
        "dt fell to %.3g s at t=%g s, %.2g of the first: %s limits it; if this is not intended, make the body stiffer "
        "or reduce its loads and velocities",
        (double)w->least, (double)w->t, (double)(w->least / w->first), w->cause));
  PetscFunctionReturn(PETSC_SUCCESS);
}
