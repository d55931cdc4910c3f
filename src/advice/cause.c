/* cause.c - why a run stopped: what was measured of the particle that ended it, the case that this is, and the remedy
   for this case, which a test has tried. Cases are tried one after the other; where none holds, no remedy is named. It
   is used once, where a run stops with a state that is not valid (advance.c), and changes nothing. */
#include "advice/advice.h"

/* What is known of the particle and of the run. */
typedef struct {
  MPMCore           *core;
  const MPMScene    *scene;
  const MPMMethod   *method;
  const MPMTime     *time;
  const MPMWatch    *watch;
  const MPMStatus   *status;
  const MPMBody     *body;
  const MPMMaterial *m;
  MPMFound           at;       /* its place, m; of: its velocity, m/s */
  PetscInt64         others;   /* particles that may share nodes with it */
  PetscReal          nearest;  /* distance of the nearest one, cells */
  PetscInt           face;     /* of the grid, with a wall, that is less than a cell away; -1: none */
  PetscReal          away;     /* its distance, cells */
  PetscReal          C;        /* c dt/h of the step */
  PetscReal          heaviest; /* the largest load on its body, in its modulus, and its name */
  const char        *load;
  MPMStable          stable;
  PetscInt           beyond, lost; /* of laws: as MPMRangesLook has them */
  MPMFound           range[MPM_MAX_RANGES], wide, parted;
} Facts;

/* --- What is known ------------------------------------------------------------------------------------------------ */

/* Returns whether a place [dim] is finite. */
static PetscBool IsFinite(PetscInt dim, const PetscReal x[])
{
  for (PetscInt d = 0; d < dim; d++)
    if (!(PetscAbsReal(x[d]) <= PETSC_MAX_REAL)) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Finds the particle, and those near it; if its place is not finite, the first of its body whose place is. Collective
   on exchange.data. */
static PetscErrorCode FindNear(Facts *f)
{
  MPMCore        *core = f->core;
  const PetscInt  dim = core->grid.dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v);
  const PetscReal reach = (PetscReal)MPMBasisNodes(core->basis);
  MPMView         view;

  PetscFunctionBeginUser;
  f->at      = (MPMFound){-1, -1, {0}, {0}};
  f->nearest = PETSC_MAX_REAL;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const PetscBool own   = view.id[p] == f->status->id;
    MPMFound        found = {own ? 2 : 1, 16 * view.id[p], {0}, {0}};

    if (view.id[p] < f->body->first || view.id[p] >= f->body->first + f->body->n || !IsFinite(dim, view.x + p * dim))
      continue;
    for (PetscInt d = 0; d < dim; d++) {
      found.x[d]  = view.x[p * dim + d];
      found.of[d] = view.v[p * dim + d];
    }
    MPMFoundTake(&f->at, &found);
  }
  PetscCall(MPMFoundAgree(&f->at, core->exchange.data));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal most = 0, far2 = 0;

    for (PetscInt d = 0; d < dim; d++) {
      const PetscReal far = PetscAbsReal(view.x[p * dim + d] - f->at.x[d]) / core->grid.h[d];

      most = far < reach ? PetscMax(most, far) : reach;
      far2 += far * far;
    }
    if (16 * view.id[p] == f->at.key || !(most < reach) || !(far2 < 3 * reach * reach)) continue;
    f->others++;
    f->nearest = PetscMin(f->nearest, PetscSqrtReal(far2));
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &f->others, 1, MPIU_INT64, MPI_SUM, core->exchange.data));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &f->nearest, 1, MPIU_REAL, MPI_MIN, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the wall next to it. Not collective. */
static void FindWall(Facts *f)
{
  const MPMGrid *grid = &f->core->grid;

  f->face = -1;
  f->away = 1;
  for (PetscInt k = 0; k < 2 * grid->dim; k++) {
    const PetscInt  d    = k / 2;
    const PetscReal away = (k % 2 ? grid->upper[d] - f->at.x[d] : f->at.x[d] - grid->lower[d]) / grid->h[d];
    const MPMWall   type = f->scene->walls.given[d][k % 2].type;

    if (!MPMWallHas(type, MPM_WALL_NORMAL) || !(away < f->away)) continue;
    f->face = k;
    f->away = away;
  }
}

/* Finds the load on its body that is largest beside its modulus. */
static PetscErrorCode FindLoad(Facts *f)
{
  const MPMScene *scene   = f->scene;
  const PetscInt  dim     = f->core->grid.dim;
  const PetscReal modulus = f->m->type->traits & MPM_FLUID ? f->m->K : f->m->E;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nloads && modulus > 0; k++) {
    PetscReal value[3] = {0}, size = 0;

    if (MPMLoadIsOnVolume(&scene->loads[k]) || &scene->bodies[scene->loads[k].body] != f->body) continue;
    PetscCall(MPMExpressionEvaluate(scene->loads[k].value, dim, f->at.x, f->at.x, f->core->t, value));
    for (PetscInt d = 0; d < scene->loads[k].nc; d++) size += value[d] * value[d];
    size = PetscSqrtReal(size) / modulus;
    if (!(size > f->heaviest)) continue;
    f->heaviest = size;
    f->load     = scene->loads[k].name;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Cases -------------------------------------------------------------------------------------------------------- */

/* A case: returns whether it holds, and if so writes what was measured, and the remedy ("": none is known). */
typedef PetscBool (*Case)(const Facts *, char what[MPM_TEXT_LEN], char remedy[MPM_TEXT_LEN]);

/* A body force or a load has no value, or is infinite. */
static PetscBool Case_force(const Facts *f, char what[MPM_TEXT_LEN], char remedy[MPM_TEXT_LEN])
{
  const MPMScene *scene = f->scene;
  const PetscInt  dim   = f->core->grid.dim;

  for (PetscInt k = -1; k < scene->nloads; k++)
    for (PetscInt back = 0; back < 2; back++) {
      const PetscReal     t        = f->core->t - (PetscReal)back * f->core->params.dt;
      const MPMExpression force    = k < 0 ? scene->acceleration : scene->loads[k].value;
      PetscReal           value[3] = {0};

      if (!force || MPMExpressionEvaluate(force, dim, f->at.x, f->at.x, t, value) || IsFinite(3, value)) continue;
      (void)snprintf(what, MPM_TEXT_LEN, k < 0 ? "%s is not finite at t=%g s" : "the load %s is not finite at t=%g s",
                     k < 0 ? "-acceleration" : scene->loads[k].name, (double)t);
      (void)snprintf(remedy, MPM_TEXT_LEN, "a formula that has a value until -time_end");
      return PETSC_TRUE;
    }
  return PETSC_FALSE;
}

/* A domain of gimp is wider than a cell. */
static PetscBool Case_wide(const Facts *f, char what[MPM_TEXT_LEN], char remedy[MPM_TEXT_LEN])
{
  if (f->status->bad != MPM_TOO_WIDE) return PETSC_FALSE;
  what[0] = 0;
  (void)snprintf(remedy, MPM_TEXT_LEN, "a spline (%s)", MPMMethodSpline());
  return PETSC_TRUE;
}

/* The step is longer than the method allows. What is unstable at any step may have a default above its bound at rest. */
static PetscBool Case_step(const Facts *f, char what[MPM_TEXT_LEN], char remedy[MPM_TEXT_LEN])
{
  if (!(f->C > PetscMax(f->stable.rest, f->stable.cfl * (1 + 1e-9)))) return PETSC_FALSE;
  (void)snprintf(what, MPM_TEXT_LEN, "steps were up to %.3g h/c long, and the method is stable up to %g", (double)f->C,
                 (double)f->stable.rest);
  (void)snprintf(remedy, MPM_TEXT_LEN, f->time->fixed > 0 ? "-dt_size auto" : "-dt_cfl %g", (double)f->stable.cfl);
  return PETSC_TRUE;
}

/* A law is far out of its range. */
static PetscBool Case_law(const Facts *f, char what[MPM_TEXT_LEN], char remedy[MPM_TEXT_LEN])
{
  for (PetscInt r = 0; r < MPM_MAX_RANGES; r++) {
    if (!(f->lost & 1 << r)) continue;
    MPMRangesTell(f->scene, f->core->grid.dim, r, &f->range[r], what);
    MPMRangesCure(f->scene, r, &f->range[r], remedy);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Matter has parted. */
static PetscBool Case_parted(const Facts *f, char what[MPM_TEXT_LEN], char remedy[MPM_TEXT_LEN])
{
  const MPMFound *found = f->parted.value > 1 ? &f->parted : &f->wide; /* one particle may be apart without a crack */

  if (!(found->value > 1 && found->of[0] > MPM_BOUND_gap_parted && found->of[0] > MPM_BOUND_gap_lags * found->of[2]))
    return PETSC_FALSE;
  MPMPartingTell(f->watch, f->core, f->scene, found, PETSC_TRUE, what);
  MPMPartingCure(f->scene, f->core->grid.dim, found, remedy);
  return PETSC_TRUE;
}

/* A fluid carries tension: what is thrown up is held together by it, and single particles have no neighbours. */
static PetscBool Case_tension(const Facts *f, char what[MPM_TEXT_LEN], char remedy[MPM_TEXT_LEN])
{
  if (!(f->m->type->traits & MPM_FLUID) || f->m->tension == 0) return PETSC_FALSE;
  (void)snprintf(what, MPM_TEXT_LEN,
                 "%s carries any tension, under which drops and thin sheets tear to single particles", f->m->name);
  (void)snprintf(remedy, MPM_TEXT_LEN, "-material_%s_tension_cutoff 0", f->m->name);
  return PETSC_TRUE;
}

/* The method amplifies noise, which has grown. */
static PetscBool Case_method(const Facts *f, char what[MPM_TEXT_LEN], char remedy[MPM_TEXT_LEN])
{
  if (f->status->bad != MPM_BAD_J && f->watch->grows_at < 0) return PETSC_FALSE;
  return MPMMethodAmplifies(f->core, f->method, f->time, f->watch, what, remedy);
}

/* A load is as large as the modulus. Where the end that it presses together passes a node, that has hardly any mass. */
static PetscBool Case_load(const Facts *f, char what[MPM_TEXT_LEN], char remedy[MPM_TEXT_LEN])
{
  const PetscBool ends = f->method->scheme->direct && f->core->basis == MPM_BASIS_gimp && f->core->params.light == 0;

  if (!(f->heaviest > MPM_BOUND_load)) return PETSC_FALSE;
  (void)snprintf(what, MPM_TEXT_LEN, "the load %s is %.3g of its modulus", f->load, (double)f->heaviest);
  (void)snprintf(remedy, MPM_TEXT_LEN, "%sa smaller -load_%s_value; check its unit, Pa, and that of the modulus",
                 ends ? "-method_light_nodes 0.03, or " : "", f->load);
  return PETSC_TRUE;
}

/* A particle leaves through a face without a wall, as particles of bodies do that move there. */
static PetscBool Case_leaves(const Facts *f, char what[MPM_TEXT_LEN], char remedy[MPM_TEXT_LEN])
{
  const MPMGrid *grid = &f->core->grid;
  PetscBool      free = PETSC_FALSE; /* has it passed a face without a wall? */

  for (PetscInt k = 0; k < 2 * grid->dim; k++) {
    const PetscReal x = f->status->x[k / 2];

    if (!MPMWallHas(f->scene->walls.given[k / 2][k % 2].type, MPM_WALL_NORMAL) && !grid->periodic[k / 2] &&
        (k % 2 ? x > grid->upper[k / 2] : x < grid->lower[k / 2]))
      free = PETSC_TRUE;
  }
  if (f->status->bad != MPM_LEFT_GRID || !free) return PETSC_FALSE;
  what[0] = 0;
  (void)snprintf(remedy, MPM_TEXT_LEN,
                 "a larger grid, walls (-bc_*_type), or -particles_leave delete, which lets such particles go");
  return PETSC_TRUE;
}

static const Case cases[] = {Case_force,  Case_step,    Case_law,  Case_method, Case_wide,
                             Case_parted, Case_tension, Case_load, Case_leaves};

/* --- Words -------------------------------------------------------------------------------------------------------- */

/* Writes what the particle saw. */
static void TellParticle(const Facts *f, char text[MPM_TEXT_LEN])
{
  PetscReal speed = 0;

  for (PetscInt d = 0; d < f->core->grid.dim; d++) speed += f->at.of[d] * f->at.of[d];
  if (!f->others)
    (void)snprintf(text, MPM_TEXT_LEN, "it is alone, no other particle shares its nodes");
  else
    (void)snprintf(text, MPM_TEXT_LEN, "the nearest particle is %.2g cells away", (double)f->nearest);
  if (f->face >= 0 && f->away >= 0)
    MPMAppend(text, MPM_TEXT_LEN, ", its wall %s (%s) %.2g", MPMFaceNames[f->face],
              MPMWallNames[f->scene->walls.given[f->face / 2][f->face % 2].type], (double)f->away);
  if (f->status->bad == MPM_LEFT_GRID && speed <= PETSC_MAX_REAL)
    MPMAppend(text, MPM_TEXT_LEN, ", its speed is %.3g m/s", (double)PetscSqrtReal(speed));
  if (f->watch->grows_at >= 0)
    MPMAppend(text, MPM_TEXT_LEN, ", energy grows without a cause since t=%.3g s", (double)f->watch->grows_at);
}

PetscErrorCode MPMCauseTell(const MPMWatch *w, MPMCore *core, const MPMScene *scene, const MPMMethod *method,
                            const MPMTime *time, const MPMStatus *status)
{
  Facts f = {.core = core, .scene = scene, .method = method, .time = time, .watch = w, .status = status, .C = w->wave};
  char  why[MPM_TEXT_LEN], saw[MPM_TEXT_LEN], what[MPM_TEXT_LEN] = "", remedy[MPM_TEXT_LEN] = "";
  PetscInt near;

  PetscFunctionBeginUser;
  (void)snprintf(why, sizeof why, "%s", core->stop);
  f.body   = &scene->bodies[MPMBodyOf(scene, status->id, 0)];
  f.m      = &scene->materials[f.body->material];
  f.stable = MPMStableOf(core, method);
  f.wide = f.parted = (MPMFound){-1, -1, {0}, {0}};
  PetscCall(FindNear(&f));
  FindWall(&f);
  PetscCall(FindLoad(&f));
  PetscCall(MPMRangesLook(core, w->ranges, &f.beyond, &f.lost, f.range));
  if (w->neighbours) PetscCall(MPMPartingLook(core, scene, w->neighbours, &near, &f.wide, &f.parted));
  TellParticle(&f, saw);
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    what[0] = remedy[0] = 0;
    if (cases[k](&f, what, remedy)) break;
  }
  (void)snprintf(core->stop, sizeof core->stop, "%.600s; %.200s%s%.600s; %s%.400s", why, saw, what[0] ? "; " : "", what,
                 remedy[0] ? "use " : "it is none of the known cases, so no remedy is known", remedy);
  PetscFunctionReturn(PETSC_SUCCESS);
}
