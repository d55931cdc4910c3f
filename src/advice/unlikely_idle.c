/* unlikely_idle.c - the rows of plausible.def of options that change nothing, and of what is there twice. */
#include <strings.h>
#include "advice/unlikely.h"

/* Finds the value that an option had before this stage, in a text of options; "true" for none; "": it was not given. */
static void Before(const MPMLook *look, const char text[], const char option[], char before[MPM_TEXT_LEN])
{
  before[0] = 0;
  for (PetscInt s = look->core->stages.now - 2; s >= -1 && !before[0]; s--) {
    char other[4 * MPM_NAME_LEN];

    (void)snprintf(other, sizeof other, "-%s%s%s%.120s", s < 0 ? "" : "stage_", s < 0 ? "" : look->scene->stages[s],
                   s < 0 ? "" : "_", option);
    if (MPMOptionsFindIn(text, other, before) && !before[0]) (void)snprintf(before, MPM_TEXT_LEN, "true");
  }
}

/* Finds an option of this stage whose value is that of before; those of time_* hold for their stage alone. */
PetscBool MPMUnlikely_stage_same(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  char           *text  = NULL, name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN], own[MPM_TEXT_LEN];
  const char     *option;

  if (look->core->stages.now < 1 || MPMOptionsText(&text)) return PETSC_FALSE;
  for (const char *at = text; at && !(odd->ratio > 0) && MPMOptionsNext(&at, name, value);) {
    char before[MPM_TEXT_LEN];

    (void)snprintf(own, sizeof own, "%s", value);
    if (MPMStageOf(scene->nstages, scene->stages, name + 1, &option) != look->core->stages.now - 1 ||
        !strncasecmp(option, "time", 4) || !strcasecmp(option, "remove"))
      continue;
    Before(look, text, option, before);
    if (!own[0]) (void)snprintf(own, sizeof own, "true");
    if (strcasecmp(before[0] ? before : "false", own)) continue;
    odd->ratio = 1;
    (void)snprintf(odd->option, MPM_WORDS, "%.150s", name);
    (void)snprintf(odd->value, MPM_WORDS, "%.150s", own);
  }
  (void)PetscFree(text);
  return odd->ratio > 0;
}

/* A stage that ends the gravity of the one before. */
PetscBool MPMUnlikely_stage_weightless(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscInt now  = look->core->stages.now - 1;
  char          *text = NULL, before[MPM_TEXT_LEN];

  if (now < 1 || look->g > 0 || look->scene->acceleration ||
      !MPMUnlikelyGiven("stage", look->scene->stages[now], "_gravity", odd) || MPMOptionsText(&text))
    return PETSC_FALSE;
  Before(look, text, "gravity", before);
  (void)PetscFree(text);
  (void)snprintf(odd->other, MPM_WORDS, "by -gravity %.60s", before);
  return strpbrk(before, "123456789") != NULL;
}

/* A later stage that gives nothing but its time, where nothing follows a formula of t, flows in or is driven. */
PetscBool MPMUnlikely_stage_idle(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  char           *text  = NULL, name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN];
  const char     *option;
  PetscBool       idle = PETSC_TRUE;

  if (look->core->stages.now < 2 || MPMWallsHave(&scene->walls, MPM_WALL_MOVES) || look->core->rigids.driven ||
      MPMUnlikelyGiven("gravity_ramp", NULL, "", odd))
    return PETSC_FALSE;
  for (PetscInt j = 0; j < MPMUnlikelyFormulas(look); j++)
    if (MPMUnlikelyChanges(look, j)) return PETSC_FALSE;
  for (PetscInt b = 0; b < scene->nbodies; b++)
    if (scene->bodies[b].source.on) return PETSC_FALSE;
  if (MPMOptionsText(&text)) return PETSC_FALSE;
  for (const char *at = text; at && MPMOptionsNext(&at, name, value);)
    if (MPMStageOf(scene->nstages, scene->stages, name + 1, &option) == look->core->stages.now - 1 &&
        strncasecmp(option, "time", 4))
      idle = PETSC_FALSE;
  (void)PetscFree(text);
  return idle && MPMUnlikelyGiven("stages", NULL, "", odd);
}

/* How far a body may come until the end, m, from where it starts. */
static PetscReal Reach(const MPMLook *look, PetscInt b)
{
  const MPMBody  *body = &look->scene->bodies[b];
  const PetscReal t = look->time->end, size = MPMUnlikelyExtent(look, body->material, -1);

  return PetscSqrtReal(body->v2) * t + 0.5 * look->g * t * t +
         (look->scene->materials[body->material].type->traits & MPM_LOOSE ? 5 : 0.3) * size;
}

/* Is anything but gravity there that moves bodies which are at rest at the start? */
static PetscBool IsDriven(const MPMLook *look)
{
  return MPMWallsHave(&look->scene->walls, MPM_WALL_MOVES) || look->scene->forced || look->scene->known ||
         look->scene->initial || look->core->rigids.n || look->core->step || look->core->stages.n;
}

PetscBool MPMUnlikely_contact_idle(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;
  const PetscInt nb   = look->scene->nbodies;

  if (nb < 2 || IsDriven(look) ||
      !(MPMUnlikelyGiven("contact_mu", NULL, "", odd) || MPMUnlikelyGiven("contacts", NULL, "", odd)))
    return PETSC_FALSE;
  odd->ratio = PETSC_MAX_REAL;
  for (PetscInt b = 0; b < nb; b++)
    if (look->way[b].alone || look->scene->bodies[b].source.on) return PETSC_FALSE; /* that it is alone is told */
  for (PetscInt a = 0; a < nb; a++)
    for (PetscInt b = 0; b < a; b++) {
      PetscReal gap = 0;

      for (PetscInt d = 0; d < grid->dim; d++)
        if (!grid->periodic[d])
          gap = PetscMax(gap, PetscMax(look->lower[b][d] - look->upper[a][d], look->lower[a][d] - look->upper[b][d]));
      odd->ratio = PetscMin(odd->ratio, (gap - Reach(look, a) - Reach(look, b)) / MPMGridSmallestH(grid));
    }
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_face_far(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid  *grid = &look->core->grid;
  const PetscInt  d    = k / 2;
  const PetscReal gap  = k % 2 ? grid->upper[d] - look->highest[d] : look->lowest[d] - grid->lower[d];

  if (MPMUnlikelyWall(look, k) != MPM_WALL_moving || look->scene->forced || look->core->rigids.n ||
      look->core->stages.n)
    return PETSC_FALSE;
  for (PetscInt b = 0; b < look->scene->nbodies; b++)
    if (look->scene->bodies[b].source.on || gap < Reach(look, b)) return PETSC_FALSE;
  odd->ratio = gap / grid->h[d];
  return MPMUnlikelyGiven("bc", MPMFaceNames[k], "_velocity", odd);
}

/* Does a rigid body that stays lie within two cells of the side of body k at a face? */
static PetscBool IsBehind(const MPMLook *look, PetscInt k, PetscInt face, const char removed[])
{
  const MPMScene *scene = look->scene;
  const MPMGrid  *grid  = &look->core->grid;

  for (PetscInt b = scene->nbodies; b < scene->nbodies + scene->nshapes; b++) {
    const PetscReal *lower = look->lower[b], *upper = look->upper[b];
    PetscBool        near = PETSC_TRUE;

    if (scene->bodies[b].rigid == MPM_RIGID_NONE || scene->bodies[b].removed ||
        MPMListHas(removed, scene->bodies[b].name))
      continue;
    for (PetscInt d = 0; d < grid->dim; d++) {
      const PetscReal side = face % 2 ? look->upper[k][d] : look->lower[k][d];

      near = near && (d == face / 2 ? side < upper[d] + 2 * grid->h[d] && side > lower[d] - 2 * grid->h[d]
                                    : look->lower[k][d] < upper[d] && look->upper[k][d] > lower[d]);
    }
    if (near) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Writes how damping is left out, of a stage in it alone. */
static void Remedy(const MPMLook *look, const char option[], char words[MPM_WORDS])
{
  if (look->core->stages.n)
    (void)snprintf(words, MPM_WORDS, "write -stage_%.60s_%s default", look->scene->stages[look->core->stages.now - 1],
                   option);
  else
    (void)snprintf(words, MPM_WORDS, "leave it out");
}

/* Damping of what has room to flow beside it: of a fluid, or of sand in a stage in which a rigid body, which held sand or a fluid, is taken away. */
PetscBool MPMUnlikely_damping_flow(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene  = look->scene;
  const MPMGrid  *grid   = &look->core->grid;
  const char     *option = look->core->damping.kinetic ? "damping_kinetic" : "damping_time";
  PetscBool       opens  = PETSC_FALSE;
  char            removed[MPM_WORDS];

  (void)MPMUnlikelyGiven("remove", NULL, "", odd);
  for (char *at = odd->value; *at; at++)
    if (*at == ',') *at = ' ';
  (void)snprintf(removed, sizeof removed, "%s", odd->value);
  for (PetscInt b = scene->nbodies; b < scene->nbodies + scene->nshapes; b++) {
    if (scene->bodies[b].rigid == MPM_RIGID_NONE) continue;
    if (look->core->stages.n && (scene->bodies[b].removed || MPMListHas(odd->value, scene->bodies[b].name)))
      opens = PETSC_TRUE;
  }
  if (!MPMDampingIsOn(look->core) || !(look->g > 0) || (look->core->stages.n && !opens)) return PETSC_FALSE;
  for (PetscInt b = 0; b < scene->nbodies; b++) {
    const MPMMaterial *m     = &scene->materials[scene->bodies[b].material];
    const PetscBool    flows = m->type->traits & MPM_FLUID ||
                            (opens && m->type->traits & MPM_LOOSE && MPMUnlikelyCohesion(m) == 0);

    for (PetscInt face = 0; face < 2 * grid->dim; face++) {
      const PetscInt d = face / 2;

      if (d == look->down || grid->periodic[d] || (grid->round && !face) || MPMUnlikelyBeside(look, b, face) < 1 ||
          !flows || IsBehind(look, b, face, removed))
        continue;
      (void)snprintf(odd->other, MPM_WORDS, "%s", scene->bodies[b].name);
    }
  }
  Remedy(look, option, odd->meant);
  return odd->other[0] && MPMUnlikelyGiven(option, NULL, "", odd);
}

PetscBool MPMUnlikely_hold_long(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  return MPMUnlikelyOver("time_rest_hold", look->time->end - look->core->t, odd);
}

PetscBool MPMUnlikely_ramp_long(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  if (!MPMUnlikelyOver("gravity_ramp", MPMUnlikelyEnd(look), odd)) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, 1 / odd->ratio);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_solves_many(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  odd->ratio = look->core->implicit ? look->steps : 0;
  return MPMUnlikelyGiven("dt_size", NULL, "", odd);
}

PetscBool MPMUnlikely_leave_idle(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++)
    if (MPMUnlikelyWall(look, face) == MPM_WALL_free) return PETSC_FALSE;
  return look->core->params.deletes && MPMUnlikelyGiven("particles_leave", NULL, "", odd);
}

/* A ball or disk that turns about its own centre, and does not grip. */
PetscBool MPMUnlikely_spin_idle(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = &look->scene->bodies[look->scene->nbodies + k];

  for (PetscInt r = 0; r < look->core->rigids.n; r++) {
    const MPMRigid *rigid = &look->core->rigids.body[r];

    if (rigid->shape != &b->region || rigid->tied || rigid->mu > 0 || !MPMRigidIsRound(rigid)) continue;
    for (PetscInt d = 0; d < look->core->grid.dim; d++)
      if (PetscAbsReal(rigid->pivot[d] - b->region.center[d]) > 1e-9 * b->region.radius) return PETSC_FALSE;
    return MPMUnlikelyGiven("body", b->name, "_spin", odd);
  }
  return PETSC_FALSE;
}

/* Damping beside a body force that swings: one that stops all at each peak of the energy, or one that takes v/T, with T less than
   half of the period. */
PetscBool MPMUnlikely_damping_shaken(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  enum { TIMES = 1000 };
  const PetscInt   dim = look->core->grid.dim, shakes = look->scene->nloads + 6;
  const MPMFormula f     = MPMUnlikelyFormula(look, shakes);
  const PetscReal  began = look->core->stages.began, length = look->time->end - began, T = look->core->damping.time;
  PetscReal        least[3] = {0, 0, 0}, most[3] = {0, 0, 0}, was[3] = {0, 0, 0}, x[3] = {0};
  PetscInt         all[3] = {0, 0, 0}, turns = 0;
  const char      *option = look->core->damping.kinetic ? "damping_kinetic" : "damping_time";

  if (!MPMDampingIsOn(look->core) || !f.value || !MPMUnlikelyChanges(look, shakes)) return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) x[d] = 0.5 * (look->lowest[d] + look->highest[d]);
  for (PetscInt j = 0; j < TIMES; j++) {
    PetscReal a[9] = {0};

    if (MPMExpressionEvaluate(f.value, dim, x, x, began + length * (j + 0.5) / TIMES, a)) return PETSC_FALSE;
    for (PetscInt d = 0; d < dim; d++) {
      least[d] = PetscMin(least[d], a[d]);
      most[d]  = PetscMax(most[d], a[d]);
      all[d] += a[d] * was[d] < 0;
      was[d] = a[d] != 0 ? a[d] : was[d];
    }
  }
  for (PetscInt d = 0; d < dim; d++) {
    if (!(PetscMin(most[d], -least[d]) > odd->ratio)) continue;
    odd->ratio = PetscMin(most[d], -least[d]);
    turns      = all[d];
  }
  (void)snprintf(odd->other, MPM_WORDS, "-acceleration");
  (void)snprintf(odd->meant, MPM_WORDS, "stops all motion whenever its energy peaks");
  if (!look->core->damping.kinetic) {
    if (turns < 2 || T > length / turns) return PETSC_FALSE;
    (void)snprintf(odd->meant, MPM_WORDS, "%.3g s takes most of the motion within half a period, %.2g s", (double)T,
                   (double)(length / turns));
  }
  if (!MPMUnlikelyGiven(option, NULL, "", odd)) return PETSC_FALSE;
  Remedy(look, option, odd->value);
  return PETSC_TRUE;
}
