/* watch.c - what is watched while a run runs: a time step that collapses, before each step; whether bodies rest that
   start with the stress by their weight, after the first step; and after some steps matter that parts (parting.c) and
   laws that leave their range (ranges.c). Each is told once, the time step again at the end. It changes no state. */
#include "advice/advice.h"

/* Takes particle p of a view, if its value is larger, or as large and its id smaller. */
static void Take(const MPMView *view, PetscInt dim, PetscInt p, PetscReal value, MPMFound *f)
{
  MPMFound found = {value, 16 * view->id[p], {0}, {0}};

  if (!(value >= f->value)) return;
  for (PetscInt d = 0; d < dim; d++) found.x[d] = view->x[p * dim + d];
  MPMFoundTake(f, &found);
}

static const char *NameOf(const MPMScene *scene, const MPMFound *f)
{
  return scene->bodies[MPMBodyOf(scene, f->key / 16, 0)].name;
}

/* --- Options ------------------------------------------------------------------------------------------------------ */

PetscErrorCode MPMWatchSetFromOptions(MPMWatch *w, MPMOptions o)
{
  char part[MPM_NAME_LEN], law[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "check_parting", NULL, part, NULL));
  PetscCall(MPMOptionsEnum(o, "check_law", NULL, law, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  w->may_part  = !strcmp(part, "warn");
  w->may_cut   = !strcmp(part, "auto");
  w->may_leave = !strcmp(law, "warn");
  w->torn_at = w->grows_at = -1;
  w->near                  = 1; /* until the first look */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a rigid body may cut matter: one that does not hold what lies in it, where something moves that is not free
   matter at rest. */
static PetscBool MayCut(const MPMScene *scene)
{
  PetscBool cuts = PETSC_FALSE, moves = MPMWallsHave(&scene->walls, MPM_WALL_MOVES);

  for (PetscInt k = 0; k < scene->nbodies + scene->nshapes; k++) {
    const MPMBody *b = &scene->bodies[k];

    if (b->removed) continue;
    if (b->rigid && !b->tied) cuts = PETSC_TRUE;
    if (b->velocity || b->rigid == MPM_RIGID_MOVING || b->rigid == MPM_RIGID_FREE) moves = PETSC_TRUE;
  }
  return cuts && moves;
}

PetscErrorCode MPMWatchSetUp(MPMWatch *w, const MPMCore *core, const MPMScene *scene)
{
  PetscBool may = PETSC_FALSE;

  PetscFunctionBeginUser;
  w->may_cut  = w->may_cut && MayCut(scene);
  w->may_part = w->may_part || w->may_cut;
  w->ranges   = MPMRangesOf(scene);
  for (PetscInt m = 0; m < scene->nmaterials; m++) may = may || MPMNeighboursMay(&scene->materials[m]);
  if (!may || core->grid.total) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(scene->nbodies, &w->neighbours));
  for (PetscInt b = 0; b < scene->nfilled; b++)
    if (MPMNeighboursMay(&scene->materials[scene->bodies[b].material]))
      PetscCall(MPMNeighboursCreate(scene, core, &scene->bodies[b], &w->neighbours[b]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMWatchDestroy(MPMWatch *w, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < scene->nbodies && w->neighbours; b++) PetscCall(MPMNeighboursDestroy(&w->neighbours[b]));
  PetscCall(PetscFree(w->neighbours));
  PetscCall(MPMMeetDestroy(w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The time step and the rest ----------------------------------------------------------------------------------- */

/* Returns the rigid body that limits the time step dt, and writes it, or NULL. */
static const char *FindRigid(MPMWatch *w, const MPMCore *core, PetscReal dt)
{
  PetscInt k;

  (void)MPMRigidStep(core, (1 + 1e-6) * dt, &k);
  if (k < 0) return NULL;
  (void)snprintf(w->cause, sizeof w->cause, "the speed %.3g m/s of the rigid body %s",
                 (double)MPMRigidSpeed(&core->rigids.body[k]), core->rigids.body[k].name);
  return core->rigids.body[k].name;
}

/* Finds what limits the time step dt: a rigid body, the fastest particle, or the body with the fastest wave. Collective
   on exchange.data. */
static PetscErrorCode FindCause(MPMWatch *w, MPMCore *core, const MPMScene *scene, PetscReal dt)
{
  const PetscBool wave  = core->status.c2 >= core->status.v2;
  const PetscInt  dim   = core->grid.dim,
                 fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v) | MPM_MATERIAL_BITS | MPM_BIT(kind);
  MPMFound most         = {-1, -1, {0}, {0}};
  MPMView  view;
  MPMBlock b;

  PetscFunctionBeginUser;
  if (FindRigid(w, core, dt)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMMaterial *m     = core->params.materials + MPMKindOf(core->params.kinds, &view, p)->material;
    PetscReal          value = 0;

    MPMMaterialState(dim, &view, p, &b);
    if (wave)
      m->type->law->speed2[MPMLawForm(m, dim)](m, 0, 1, &b, &value);
    else
      for (PetscInt d = 0; d < dim; d++) value += view.v[p * dim + d] * view.v[p * dim + d];
    Take(&view, dim, p, value, &most);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(MPMFoundAgree(&most, core->exchange.data));
  w->limits = most.key / 16;
  if (wave)
    (void)snprintf(w->cause, sizeof w->cause, "the wave speed %.3g m/s in %s", (double)PetscSqrtReal(most.value),
                   NameOf(scene, &most));
  else
    (void)snprintf(w->cause, sizeof w->cause, "the speed %.3g m/s of particle %" PetscInt64_FMT " of %s",
                   (double)PetscSqrtReal(most.value), most.key / 16, NameOf(scene, &most));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in watch.h. The cause is found where dt has fallen below a hundredth of the first, and anew at each further
   tenth of that. Implicit steps are those of the load: the first step counts that is explicit. */
PetscErrorCode MPMWatchStep(MPMWatch *w, MPMCore *core, const MPMScene *scene, const MPMTime *time, PetscReal dt)
{
  const PetscBool told = w->cause[0] ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBeginUser;
  if (core->implicit || core->step == 0 || !(w->first > 0)) w->first = w->least = core->implicit ? 0 : dt;
  if (!(dt < w->least)) PetscFunctionReturn(PETSC_SUCCESS);
  w->least = dt;
  w->t     = core->t;
  if (dt >= (told ? MPM_BOUND_collapse_again * w->told : MPM_BOUND_collapse * w->first))
    PetscFunctionReturn(PETSC_SUCCESS);
  w->told = dt;
  PetscCall(FindCause(w, core, scene, dt));
  if (told) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMWarn(&core->print,
                    "dt has fallen to %.3g s at t=%g s, from %.3g s: %s limits it; about %.3g steps are left",
                    (double)dt, (double)w->t, (double)w->first, w->cause, (double)((time->end - w->t) / dt)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMWatchShort(MPMWatch *w, MPMCore *core, const MPMScene *scene, const MPMMethod *method,
                             const MPMTime *time, PetscReal dt)
{
  MPMStatus   at = core->status;
  const char *rigid;

  PetscFunctionBeginUser;
  if (time->fixed > 0) {
    (void)snprintf(core->stop, sizeof core->stop,
                   "the time step, %g s, is too short to change the time; use a larger -dt_size, or -dt_size auto",
                   (double)dt);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  rigid = FindRigid(w, core, dt);
  if (rigid) {
    (void)snprintf(core->stop, sizeof core->stop,
                   "the time step, %g s, is too short to change the time: %s limits it; see -body_%s_velocity and "
                   "-body_%s_spin",
                   (double)dt, w->cause, rigid, rigid);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(FindCause(w, core, scene, dt));
  (void)snprintf(core->stop, sizeof core->stop, "the time step, %g s, is too short to change the time: %s limits it",
                 (double)dt, w->cause);
  at.id  = w->limits;
  at.bad = MPM_NOT_FINITE;
  PetscCall(MPMCauseTell(w, core, scene, method, time, &at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns a rigid body less than 3 cells from a place, or NULL; moves: only of those that push what is there from the
   first step on. */
static const MPMRigid *RigidBeside(const MPMCore *core, const PetscReal x[], PetscBool moves)
{
  for (PetscInt k = 0; k < core->rigids.n; k++) {
    const MPMRigid *r = &core->rigids.body[k];
    PetscReal       n[3];

    if ((!moves || (r->moves && !r->free)) && !r->gone &&
        MPMRigidDistance(r, core->grid.dim, x, n) < 3 * MPMGridSmallestH(&core->grid))
      return r;
  }
  return NULL;
}

/* Described in watch.h. Damping means that the body shall settle. */
PetscErrorCode MPMWatchRest(MPMCore *core, const MPMScene *scene)
{
  const PetscInt  dim = core->grid.dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v);
  const PetscReal g    = MPMInitialGravity(scene);
  MPMFound        most = {-1, -1, {0}, {0}};
  const MPMRigid *rigid;
  char            place[3 * MPM_NAME_LEN];
  MPMView         view;

  PetscFunctionBeginUser;
  if (core->step != 1 || !(g > 0) || MPMDampingIsOn(core)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < scene->nbodies; k++)
    if (scene->bodies[k].v2 > 0) PetscFunctionReturn(PETSC_SUCCESS); /* nor shall it rest */
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal v2 = 0;

    if (RigidBeside(core, view.x + p * dim, PETSC_TRUE)) continue;
    for (PetscInt d = 0; d < dim; d++) v2 += view.v[p * dim + d] * view.v[p * dim + d];
    Take(&view, dim, p, PetscSqrtReal(v2) / (g * core->t), &most);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(MPMFoundAgree(&most, core->exchange.data));
  if (!(most.value > MPM_BOUND_restless)) PetscFunctionReturn(PETSC_SUCCESS);
  MPMPlaceWords(dim, most.x, place);
  rigid = RigidBeside(core, most.x, PETSC_FALSE);
  if (rigid) MPMAppend(place, sizeof place, ", beside the rigid body %s,", rigid->name);
  PetscCall(MPMWarn(
      &core->print,
      "%s does not rest in its stress of -initial_stress k0: near %s it starts with an acceleration of %.2g g. It "
      "needs a level surface, a wall below and walls at all sides%s; else let it settle %s",
      NameOf(scene, &most), place, (double)most.value, rigid ? ", and no rigid body" : "",
      core->rigids.free ? "first, since rigid bodies that are free cannot be damped: start later what is to be seen"
                        : "with -damping_kinetic"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The state ---------------------------------------------------------------------------------------------------- */

/* Writes which rigid body is nearest to where matter parts, and how far from there. */
static void TellCutter(const MPMCore *core, const MPMFound *f, char text[MPM_NAME_LEN * 3])
{
  const char *name  = "";
  PetscReal   least = PETSC_MAX_REAL, n[3];

  for (PetscInt k = 0; k < core->rigids.n; k++) {
    const MPMRigid *r = &core->rigids.body[k];
    const PetscReal d = r->tied || r->gone ? PETSC_MAX_REAL : MPMRigidDistance(r, core->grid.dim, f->x, n);

    if (!(d < least)) continue;
    least = d;
    name  = r->name;
  }
  (void)snprintf(text, MPM_NAME_LEN * 3, "the rigid body %s, %.2g cells from there, may cut it", name,
                 (double)(PetscMax(0, least) / MPMGridSmallestH(&core->grid)));
}

/* Returns whether the body that parts has so many particles per cell that more are no remedy where a rigid body cuts it. */
static PetscBool IsDense(PetscInt dim, const MPMScene *scene, const MPMFound *f)
{
  const MPMBody *b = &scene->bodies[MPMBodyOf(scene, f->key / 16, 0)];

  for (PetscInt d = 0; d < dim; d++)
    if (b->ppc[d] < MPM_BOUND_gap_dense) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Warns of matter that will part, or stops the run where it has parted. Collective on exchange.data. */
static PetscErrorCode WatchParting(MPMWatch *w, MPMCore *core, const MPMScene *scene, const MPMMethod *method,
                                   const MPMTime *time)
{
  MPMFound  wide, parted;
  PetscBool noisy;
  char      what[MPM_TEXT_LEN], noise[MPM_TEXT_LEN] = "", cure[MPM_TEXT_LEN], cutter[MPM_NAME_LEN * 3] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMPartingLook(core, scene, w->neighbours, &w->near, &wide, &parted));
  if (wide.value > 1 && w->torn_at < 0) w->torn_at = core->t;
  noisy = w->grows_at >= 0 ? MPMMethodAmplifies(core, method, time, w, noise, cure) : PETSC_FALSE;
  if (parted.value > 1 && !w->may_part && !core->stop[0]) {
    MPMPartingTell(w, core, scene, &parted, PETSC_TRUE, what);
    if (!noisy) MPMPartingCure(scene, core->grid.dim, &parted, cure);
    (void)snprintf(core->stop, sizeof core->stop, "%.600s%s%.300s; use %.600s, or let it part (-check_parting warn)",
                   what, noisy ? "; " : "", noise, cure);
    w->stopped = PETSC_TRUE;
  } else if (wide.value > 1 && !w->torn) {
    w->torn = PETSC_TRUE;
    MPMPartingTell(w, core, scene, parted.value > 1 ? &parted : &wide, parted.value > 1, what);
    if (!noisy) MPMPartingCure(scene, core->grid.dim, &wide, cure);
    if (w->may_cut) TellCutter(core, parted.value > 1 ? &parted : &wide, cutter);
    if (cutter[0] && !noisy && IsDense(core->grid.dim, scene, &wide)) cure[0] = 0;
    PetscCall(MPMWarn(&core->print, "seen at t=%g s: %.600s%s%.300s; %s%s%s%.600s%s", (double)core->t, what,
                      noisy ? "; " : "", noise, cutter, cutter[0] && cure[0] ? "; if it does not, " : "",
                      cure[0] ? "use " : "", cure, w->may_part ? "" : ", or let it part (-check_parting warn)"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns of laws that leave their range, or stops the run where its result means nothing. Collective on exchange.data.
   */
static PetscErrorCode WatchRanges(MPMWatch *w, MPMCore *core, const MPMScene *scene)
{
  PetscInt beyond, lost;
  MPMFound most[MPM_MAX_RANGES];
  char     what[MPM_TEXT_LEN], cure[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMRangesLook(core, w->ranges, &beyond, &lost, most));
  for (PetscInt r = 0; r < MPM_MAX_RANGES; r++) {
    if (!(beyond & 1 << r)) continue;
    MPMRangesTell(scene, core->grid.dim, r, &most[r], what);
    MPMRangesCure(scene, r, &most[r], cure);
    if ((lost & 1 << r) && !w->may_leave && !core->stop[0]) {
      (void)snprintf(core->stop, sizeof core->stop, "%.900s; use %.700s, or go on all the same (-check_law warn)", what,
                     cure);
      w->stopped = PETSC_TRUE;
    } else if (!(w->beyond & 1 << r)) {
      PetscCall(MPMWarn(&core->print, "seen at t=%g s: %.900s; use %.700s", (double)core->t, what, cure));
    }
    w->beyond |= 1 << r;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMWatchState(MPMWatch *w, MPMCore *core, const MPMScene *scene, const MPMMethod *method,
                             const MPMTime *time, const MPMMonitor *mon)
{
  static const PetscInt every[] = {MPM_WATCH_FAR, MPM_WATCH_NEAR, MPM_WATCH_PARTS};
  const MPMShown        shown   = MPMMonitorShown(mon, core, scene);
  const PetscBool       last    = core->t >= time->end || core->rest.reached; /* looked at in any case */
  const PetscInt        near    = w->near;

  PetscFunctionBeginUser;
  if (core->stop[0]) PetscFunctionReturn(PETSC_SUCCESS);
  if (mon->last == core->step && MPMEnergyIsFollowed(core, scene)) {
    const PetscReal most = mon->energy_max + PetscAbsReal(MPMShownWork(&shown));

    if (!(MPMShownResidual(&shown) > MPM_BOUND_energy_grown * most))
      w->grows_at = -1;
    else if (w->grows_at < 0)
      w->grows_at = core->t;
  }
  if (core->grid.total) PetscCall(MPMMeetLook(w, core, scene, last));
  if (w->ranges && (last || core->step % MPM_WATCH_LAWS == 0)) PetscCall(WatchRanges(w, core, scene));
  if (!w->neighbours || !(last || core->step % every[near] == 0)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WatchParting(w, core, scene, method, time));
  if (core->step % every[near])
    w->near = near; /* a run that goes on from here looks when one would that had not ended */
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMWatchEnd(const MPMWatch *w, const MPMPrinter *print)
{
  PetscFunctionBeginUser;
  if (w->cause[0] && w->first > 0)
    PetscCall(MPMWarn(
        print,
        "dt fell to %.3g s at t=%g s, %.2g of the first: %s limits it; if this is not intended, make the body stiffer "
        "or reduce its loads and velocities",
        (double)w->least, (double)w->t, (double)(w->least / w->first), w->cause));
  PetscFunctionReturn(PETSC_SUCCESS);
}
