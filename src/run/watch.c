/* watch.c - what is watched while a run runs: a time step that collapses, before each step; whether bodies rest that start
   with the stress by their weight, after the first step; and bodies that come apart, where a line of the history is
   written. Each is told once, the time step again at the end. It changes no state. */
#include "run/mpm.h"

#define COLLAPSE 0.01 /* of the first time step */

/* The acceleration, in that of gravity, above which a body does not rest in the stress by its weight. In columns between
   walls the first step accelerates particles by up to 0.03, with splines near the surface; on slopes of 34 and 45 degrees,
   which settle, by 0.5; without a wall on one side or below by 3 to 24, with 8 and 16 cells of height (docs/theory.md).
   */
#define RESTLESS 1

/* The distance of neighbouring particles, in cells, at which a body comes apart. Of an elastic body so few nodes then have
   both of them in reach that they hardly hold each other: measured on bars pulled to 8 times their length with 2 and 4
   particles per cell, whose largest gap runs away at 1.2 to 1.3 with the hats, and at 1.5 to 1.7 with the splines. A
   metal that flows gets thinner as it gets longer, and what comes from its sides fills the gaps; it is apart for certain
   where its neighbours have no node in common. */
static PetscReal TearsAt(MPMBasis basis, const MPMMaterial *m)
{
  if (m->type->traits & MPM_PLASTIC) return (PetscReal)MPMBasisNodes(basis);
  return MPMBasisIsSpline(basis) ? 1.5 : 1.2;
}

/* The particle with the largest value of something, on all processes. */
typedef struct {
  PetscReal  value, x[3]; /* x in m */
  PetscInt64 id;          /* the smallest of those with this value */
} Found;

/* Makes the findings of all processes one. Collective on exchange.data. */
static PetscErrorCode Agree(const MPMCore *core, Found *f)
{
  const PetscReal mine  = f->value;
  PetscInt64      least = INT64_MAX, id = f->id;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &f->value, 1, MPIU_REAL, MPI_MAX, core->exchange.data));
  if (mine == f->value && id >= 0) least = id;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPIU_INT64, MPI_MIN, core->exchange.data));
  if (id != least)
    for (PetscInt d = 0; d < 3; d++) f->x[d] = 0;
  f->id = least;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, f->x, 3, MPIU_REAL, MPI_SUM, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes particle p of a view, if its value is larger, or as large and its id smaller. */
static void Take(const MPMView *view, PetscInt dim, PetscInt p, PetscReal value, Found *f)
{
  if (!(value > f->value || (value == f->value && view->id[p] < f->id))) return;
  f->value = value;
  f->id    = view->id[p];
  for (PetscInt d = 0; d < dim; d++) f->x[d] = view->x[p * dim + d];
}

static const MPMBody *BodyOf(const MPMScene *scene, PetscInt64 id)
{
  PetscInt b = 0;

  while (b + 1 < scene->nbodies && id >= scene->bodies[b + 1].first) b++;
  return &scene->bodies[b];
}

/* Finds what limits the time step: the fastest particle, or the body with the fastest wave. Collective on
   exchange.data. */
static PetscErrorCode FindCause(MPM mpm)
{
  MPMCore        *core  = &mpm->core;
  const PetscBool wave  = core->status.c2 >= core->status.v2 ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt  dim   = core->grid.dim,
                 fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v) | MPM_MATERIAL_BITS | MPM_BIT(kind);
  Found    most         = {-1, {0}, -1};
  MPMView  view;
  MPMBlock b;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesReadView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMMaterial *m     = core->params.materials + core->params.kinds[view.kind ? view.kind[p] : 0].material;
    PetscReal          value = 0;

    MPMMaterialState(dim, &view, p, &b);
    if (wave)
      m->type->law->speed2[dim - 1](m, 0, 1, &b, &value);
    else
      for (PetscInt d = 0; d < dim; d++) value += view.v[p * dim + d] * view.v[p * dim + d];
    Take(&view, dim, p, value, &most);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(Agree(core, &most));
  if (wave)
    (void)snprintf(mpm->watch.cause, sizeof mpm->watch.cause, "the wave speed %.3g m/s in %s",
                   (double)PetscSqrtReal(most.value), BodyOf(&mpm->scene, most.id)->name);
  else
    (void)snprintf(mpm->watch.cause, sizeof mpm->watch.cause,
                   "the speed %.3g m/s of particle %" PetscInt64_FMT " of %s", (double)PetscSqrtReal(most.value),
                   most.id, BodyOf(&mpm->scene, most.id)->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Clears the line of progress, over which a warning is printed. */
static PetscErrorCode Clear(MPM mpm)
{
  PetscFunctionBeginUser;
  if (mpm->report.progress) PetscCall(MPMPrint(&mpm->core.print, "\r\033[K"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in mpm.h. The cause is found where dt has fallen below a hundredth of the first, and anew at each further
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
  if (dt >= (told ? 0.1 * w->told : COLLAPSE * w->first)) PetscFunctionReturn(PETSC_SUCCESS);
  w->told = dt;
  PetscCall(FindCause(mpm));
  if (told) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Clear(mpm));
  PetscCall(MPMPrint(&mpm->core.print,
                     "warning    dt has fallen to %.3g s at t=%g s, from %.3g s: %s limits it; about %.3g steps are "
                     "left\n",
                     (double)dt, (double)w->t, (double)w->first, w->cause, (double)((mpm->time.end - w->t) / dt)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in mpm.h. Damping means that the body shall settle. */
PetscErrorCode MPMWatchRest(MPM mpm)
{
  MPMCore        *core = &mpm->core;
  const PetscInt  dim = core->grid.dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v);
  const PetscReal g    = MPMInitialGravity(&mpm->scene);
  Found           most = {-1, {0}, -1};
  MPMView         view;

  PetscFunctionBeginUser;
  if (core->step != 1 || !(g > 0) || MPMDampingIsOn(core)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < mpm->scene.nbodies; k++)
    if (mpm->scene.bodies[k].v2 > 0) PetscFunctionReturn(PETSC_SUCCESS); /* nor shall it rest */
  PetscCall(MPMParticlesReadView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal v2 = 0;

    for (PetscInt d = 0; d < dim; d++) v2 += view.v[p * dim + d] * view.v[p * dim + d];
    Take(&view, dim, p, PetscSqrtReal(v2) / (g * core->t), &most);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(Agree(core, &most));
  if (!(most.value > RESTLESS)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMPrint(&core->print, "warning    %s does not rest in its stress of -initial_stress k0: near (%g",
                     BodyOf(&mpm->scene, most.id)->name, (double)most.x[0]));
  for (PetscInt d = 1; d < dim; d++) PetscCall(MPMPrint(&core->print, ", %g", (double)most.x[d]));
  PetscCall(
      MPMPrint(&core->print,
               ") it starts with an acceleration of %.2g g. It needs a level surface, a wall below and walls at all "
               "sides; else let it settle with -damping_kinetic\n",
               (double)most.value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in mpm.h. The neighbours of a particle on the lattice of its body are where its F takes them: column d of F
   times the spacing on axis d. Soils open by themselves (field vc), and fluids have no F. */
PetscErrorCode MPMWatchBodies(MPM mpm)
{
  MPMCore       *core = &mpm->core;
  const PetscInt dim = core->grid.dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(F) | MPM_BIT(kind);
  MPMView        view;
  Found          most = {-1, {0}, -1};
  PetscReal      largest, limit;
  const MPMBody *body;

  PetscFunctionBeginUser;
  if (mpm->watch.torn || mpm->monitor.last != core->step || !core->particles.present[MPM_FIELD_INDEX_F])
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMParticlesReadView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMKind     *kind = &core->params.kinds[view.kind ? view.kind[p] : 0];
    const MPMMaterial *m    = &core->params.materials[kind->material];

    if (!(m->state & MPM_BIT(F)) || MPMListHas(m->type->state, "vc")) continue;
    for (PetscInt d = 0; d < dim; d++) {
      PetscReal far2 = 0;

      for (PetscInt e = 0; e < dim; e++)
        far2 += PetscSqr(view.F[(p * dim + e) * dim + d] * 2 * kind->l[d] * core->grid.h[d] / core->grid.h[e]);
      Take(&view, dim, p, PetscSqrtReal(far2) / TearsAt(core->basis, m), &most);
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCallMPI(MPI_Allreduce(&most.value, &largest, 1, MPIU_REAL, MPI_MAX, core->exchange.data));
  if (largest <= 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Agree(core, &most));
  body            = BodyOf(&mpm->scene, most.id);
  limit           = TearsAt(core->basis, &mpm->scene.materials[body->material]);
  mpm->watch.torn = PETSC_TRUE;
  PetscCall(Clear(mpm));
  PetscCall(MPMPrint(&mpm->core.print, "warning    %s comes apart at t=%g s, near (%g", body->name, (double)core->t,
                     (double)most.x[0]));
  for (PetscInt d = 1; d < dim; d++) PetscCall(MPMPrint(&mpm->core.print, ", %g", (double)most.x[d]));
  PetscCall(MPMPrint(&mpm->core.print,
                     "): its particles are %.2g cells apart, %s holds them together up to %g; use more particles per "
                     "cell (-body_%s_ppc)\n",
                     (double)(most.value * limit), MPMBasisNames[core->basis], (double)limit, body->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in mpm.h. */
PetscErrorCode MPMWatchEnd(MPM mpm)
{
  const MPMWatch *w = &mpm->watch;

  PetscFunctionBeginUser;
  if (w->cause[0])
    PetscCall(MPMPrint(&mpm->core.print,
                       "warning    dt fell to %.3g s at t=%g s, %.2g of the first: %s limits it; if this is not "
                       "intended, make the body stiffer or reduce its loads and velocities\n",
                       (double)w->least, (double)w->t, (double)(w->least / w->first), w->cause));
  PetscFunctionReturn(PETSC_SUCCESS);
}
