/* unlikely_ways.c - the rows of plausible.def of the ways of bodies. Before a body meets anything it moves with the
   velocity of its start and the acceleration of gravity; a rigid one may move by formulas. From these ways follows
   whether it meets another body or a wall until the end of the run, or leaves the grid. What happens after that is not
   looked at. */
#include "advice/unlikely.h"

#define PARTS  400 /* of the time of the run, in which the ways are looked at, the first ones the shortest */
#define NEAR   1   /* cells: bodies share nodes from there on, */
#define TOUCH  0.5 /* with contact they rest on each other; */
#define AT     0.1 /* contact, and walls that only push, act on what arrives at them */
#define ALL    7   /* axes */
#define PLACES 5   /* on each axis of a body, at which its velocity is looked at */

/* A body, its box at the start, how far it has come, m; is it held, or at rest on something? Then along which axes (bits). */
typedef struct {
  const MPMBody   *body;
  PetscInt         held;
  const PetscReal *lower, *upper;
  PetscReal        way[PARTS + 1][3];
} Thing;

/* Does nothing that it meets change how a body moves? */
static PetscBool IsGiven(const Thing *t)
{
  return t->body->rigid == MPM_RIGID_FIXED || t->body->rigid == MPM_RIGID_MOVING;
}

/* Returns the time after k parts, s: of a run that is far too long its beginning is looked at too. */
static PetscReal After(const MPMLook *look, PetscInt k)
{
  const PetscReal part = (PetscReal)k / PARTS;

  return look->time->end * part * part * part;
}

/* Returns the mean velocity of a body at the start, m/s; 0 where it only turns or vibrates. */
static void Mean(const MPMBody *b, PetscInt dim, const PetscReal lower[], const PetscReal upper[], PetscReal mean[3])
{
  const PetscReal n      = PetscPowRealInt(PLACES, dim);
  PetscReal       spread = 0, size = 0, x[3] = {0};

  mean[0] = mean[1] = mean[2] = 0;
  for (int round = 0; round < 2 && b->velocity; round++)
    for (PetscInt j = 0; MPMUnlikelyPlace(dim, lower, upper, PLACES, j, x); j++) {
      PetscReal v[9] = {0};

      if (MPMExpressionEvaluate(b->velocity, dim, x, x, 0, v)) return;
      for (PetscInt d = 0; d < dim && !round; d++) mean[d] += v[d] / n;
      for (PetscInt d = 0; d < dim && round; d++) spread = PetscMax(spread, PetscAbsReal(v[d] - mean[d]));
    }
  for (PetscInt d = 0; d < dim; d++) size = PetscMax(size, PetscAbsReal(mean[d]));
  if (spread > 3 * size) mean[0] = mean[1] = mean[2] = 0;
}

/* Returns how far what starts with v, m/s, comes in a time under an acceleration, m, where damping takes v/T of it. */
static PetscReal Comes(PetscReal v, PetscReal a, PetscReal T, PetscReal time)
{
  return T > 0 ? a * T * time + (a * T - v) * T * expm1(-time / T) : (v + 0.5 * a * time) * time;
}

/* Returns the time in which damping takes the velocity of a body, s; 0: never. */
static PetscReal Damped(const MPMLook *look, const MPMBody *b)
{
  return b->rigid ? 0 : look->core->damping.time;
}

/* Sets the ways of a body that nothing holds. */
static void Go(const MPMLook *look, Thing *t)
{
  const PetscInt dim  = look->core->grid.dim;
  PetscReal      v[9] = {0};

  if (t->body->rigid != MPM_RIGID_MOVING) Mean(t->body, dim, t->lower, t->upper, v);
  for (PetscInt k = 1; k <= PARTS; k++) {
    const PetscReal time = After(look, k), part = time - After(look, k - 1), x[3] = {0};

    if (t->body->rigid == MPM_RIGID_MOVING && t->body->velocity &&
        MPMExpressionEvaluate(t->body->velocity, dim, x, x, time - 0.5 * part, v))
      return;
    for (PetscInt d = 0; d < dim; d++)
      t->way[k][d] = t->held >> d & 1 ? 0
                     : IsGiven(t)     ? t->way[k - 1][d] + part * v[d]
                                      : Comes(v[d], look->core->params.gravity[d], Damped(look, t->body), time);
  }
}

/* Returns how many cells two bodies are apart after k parts of the time. */
static PetscReal Apart(const MPMGrid *grid, const Thing *a, const Thing *b, PetscInt k)
{
  PetscReal gap = 0;

  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal way = b->way[k][d] - a->way[k][d];

    if (!grid->periodic[d])
      gap = PetscMax(gap, PetscMax(b->lower[d] + way - a->upper[d], a->lower[d] - b->upper[d] - way) / grid->h[d]);
  }
  return gap;
}

/* Returns how many cells apart bodies act on each other, where that is another number with contact. */
static PetscReal Reach(PetscReal contact)
{
  MPMOdd odd;

  return MPMUnlikelyGiven("contact_mu", NULL, "", &odd) ? contact : NEAR;
}

/* Returns how many cells a body is from a face, or from the plane of its piston. */
static PetscReal Before(const MPMLook *look, const Thing *t, PetscInt face, PetscInt k)
{
  const MPMGrid  *grid = &look->core->grid;
  const PetscInt  d    = face / 2;
  const PetscReal way  = t->way[k][d];

  return ((face % 2 ? grid->upper[d] - t->upper[d] - way : t->lower[d] + way - grid->lower[d]) -
          look->scene->walls.place[face]) /
         grid->h[d];
}

/* Returns whether a wall acts on what moves from one place to another beside it. */
static PetscBool Holds(MPMWall type, PetscReal toward)
{
  return MPMWallHas(type, MPM_WALL_TANGENT | MPM_WALL_BRAKES | MPM_WALL_MOVES) ||
         (MPMWallHas(type, MPM_WALL_NORMAL) && (toward > 0 || !MPMWallHas(type, MPM_WALL_PUSHES)));
}

static PetscBool IsNear(MPMWall type, PetscReal gap)
{
  return gap < (MPMWallHas(type, MPM_WALL_PUSHES) ? AT : NEAR);
}

/* Finds what is held at the start: by a wall, a smooth one along its normal, by a rigid body that is not free, or by
   another body that is held. */
static void Hold(const MPMLook *look, PetscInt n, Thing thing[])
{
  const MPMGrid  *grid  = &look->core->grid;
  const PetscReal reach = Reach(TOUCH);
  PetscBool       more  = PETSC_TRUE;

  for (PetscInt k = 0; k < n; k++) {
    Thing *t = &thing[k];

    if (IsGiven(t)) continue;
    for (PetscInt face = 0; face < 2 * grid->dim; face++) {
      const PetscReal sign   = face % 2 ? 1 : -1,
                      toward = PetscMax(sign * t->way[1][face / 2], sign * look->core->params.gravity[face / 2]);
      const MPMWall type     = MPMUnlikelyWall(look, face);

      if (IsNear(type, Before(look, t, face, 0)) && Holds(type, toward))
        t->held |= MPMWallHas(type, MPM_WALL_TANGENT | MPM_WALL_BRAKES | MPM_WALL_MOVES) ? ALL : 1 << face / 2;
    }
  }
  while (more) {
    more = PETSC_FALSE;
    for (PetscInt k = 0; k < n * n; k++) {
      const Thing *by = &thing[k / n];
      Thing       *t  = &thing[k % n];

      if (by == t || t->held == ALL || IsGiven(t) || !(by->held || IsGiven(by)) || Apart(grid, by, t, 0) >= reach)
        continue;
      t->held = ALL;
      more    = PETSC_TRUE;
    }
  }
}

/* Follows body k until it meets something or leaves the grid. */
static void Follow(const MPMLook *look, PetscInt n, const Thing thing[], PetscInt k, MPMWay *w)
{
  const MPMGrid  *grid  = &look->core->grid;
  const Thing    *t     = &thing[k];
  const PetscReal reach = Reach(AT);
  PetscReal       moved = 0;

  w->face = -1;
  w->gap  = PETSC_MAX_REAL;
  for (PetscInt d = 0; d < grid->dim; d++) moved += PetscSqr(t->way[PARTS][d] / grid->h[d]);
  if (!(moved > 0) || t->body->source.on || t->body->removed) return;
  w->moved = PetscSqrtReal(moved);
  for (PetscInt p = 0; p <= PARTS; p++) {
    for (PetscInt j = 0; j < n; j++) {
      PetscReal relative = 0, gap;

      for (PetscInt d = 0; d < grid->dim; d++)
        relative += PetscSqr((thing[j].way[PARTS][d] - t->way[PARTS][d]) / grid->h[d]);
      gap = j == k ? PETSC_MAX_REAL : Apart(grid, t, &thing[j], p);
      if (gap < w->gap) (void)snprintf(w->nearest, MPM_WORDS, "%s", thing[j].body->name);
      w->gap = PetscMin(w->gap, gap);
      if (gap < reach && relative > 1e-12 * moved) return;
    }
    for (PetscInt face = 0; face < 2 * grid->dim; face++) {
      const PetscInt  d = face / 2, next = PetscMin(PARTS, p + 1);
      const MPMWall   type   = MPMUnlikelyWall(look, face);
      const PetscReal gap    = Before(look, t, face, p),
                      toward = (face % 2 ? 1 : -1) * (t->way[next][d] - t->way[next - 1][d]);

      if (grid->periodic[d] || (grid->round && !face)) continue;
      if (type == MPM_WALL_free && gap < -0.5 && !t->body->rigid) {
        w->face = face;
        w->t    = After(look, p);
        return;
      }
      if (type == MPM_WALL_free || !(toward > 0)) continue;
      if (gap < w->gap) (void)snprintf(w->nearest, MPM_WORDS, "the wall %s", MPMFaceNames[face]);
      w->gap = PetscMin(w->gap, gap);
      if (IsNear(type, gap)) return;
    }
  }
  w->alone = PETSC_TRUE;
}

PetscErrorCode MPMUnlikelyWays(const MPMLook *look, MPMWay way[])
{
  const MPMScene *scene = look->scene;
  PetscBool       flows = PETSC_FALSE, driven = PETSC_FALSE;
  Thing          *thing;
  PetscInt        n = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(scene->nbodies + scene->nshapes, &thing));
  PetscCall(PetscArrayzero(thing, scene->nbodies + scene->nshapes));
  for (PetscInt k = 0; k < scene->nbodies + scene->nshapes; k++) {
    Thing *t = &thing[n];

    way[k].face = -1;
    if (k < scene->nbodies && scene->bodies[k].source.on) flows = PETSC_TRUE;
    if (scene->bodies[k].removed || (k >= scene->nbodies && scene->bodies[k].rigid == MPM_RIGID_NONE)) continue;
    t->body      = &scene->bodies[k];
    t->lower     = look->lower[k];
    t->upper     = look->upper[k];
    way[k].thing = n++;
  }
  for (PetscInt l = 0; l < scene->nloads; l++) { /* what it does without gravity is not looked at */
    if (!(look->g > 0)) thing[way[scene->loads[l].body].thing].held = ALL;
    driven = PETSC_TRUE;
  }
  if (!flows && !scene->acceleration && !scene->known && (!scene->initial || MPMInitialGravity(scene) > 0) &&
      !look->core->implicit && !look->core->grid.total && !look->core->step && look->time->end > 0 &&
      look->time->max_steps == PETSC_MAX_INT) {
    for (PetscInt k = 0; k < n; k++) Go(look, &thing[k]);
    Hold(look, n, thing);
    for (PetscInt k = 0; k < n; k++) {
      PetscCall(PetscArrayzero(thing[k].way, PARTS + 1));
      Go(look, &thing[k]);
    }
    for (PetscInt k = 0; k < scene->nbodies + scene->nshapes; k++)
      if (thing[way[k].thing].body == &scene->bodies[k]) Follow(look, n, thing, way[k].thing, &way[k]);
    for (PetscInt k = 0; k < scene->nbodies + scene->nshapes && driven; k++) way[k].alone = PETSC_FALSE;
  }
  PetscCall(PetscFree(thing));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names the option that moves a body: its velocity, or gravity. */
static PetscBool Moves(const MPMLook *look, const MPMBody *b, MPMOdd *odd)
{
  return MPMUnlikelyGiven("body", b->name, "_velocity", odd) ||
         (look->g > 0 && MPMUnlikelyGiven("gravity", NULL, "", odd));
}

PetscBool MPMUnlikely_leaves(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMWay *w = &look->way[k];

  if (w->face < 0 || look->core->params.deletes) return PETSC_FALSE;
  (void)snprintf(odd->meant, MPM_WORDS, "the open face %s at t = %.3g s", MPMFaceNames[w->face], (double)w->t);
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++) /* a clamp that it does not reach */
    if (MPMUnlikelyWall(look, face) == MPM_WALL_fixed && face / 2 != w->face / 2)
      (void)snprintf(odd->meant, MPM_WORDS,
                     "the open face %.8s at t = %.3g s: it starts %.3g cells from the wall %.8s fixed",
                     MPMFaceNames[w->face], (double)w->t, (double)MPMUnlikelyBeside(look, k, face), MPMFaceNames[face]);
  return Moves(look, &look->scene->bodies[k], odd);
}

/* Does damping hold back a fall from rest, or a flight, to less than half of its way? */
static PetscBool IsSlowed(const MPMLook *look, const MPMBody *b)
{
  const PetscReal end = look->time->end, T = Damped(look, b);

  const PetscReal v = b->v2 > 0 ? 1 : 0, a = v > 0 ? 0 : 1;

  return T > 0 && (v > 0 || look->g > 0) && 2 * Comes(v, a, T, end) < Comes(v, a, 0, end);
}

/* What body k, among all, is alone on its way, though there is something that it may be meant to meet. */
static PetscBool Alone(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMWay *w = &look->way[k];
  char          own[MPM_WORDS];

  if (!w->alone) return PETSC_FALSE;
  odd->ratio = w->moved;
  (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[k].name);
  for (PetscInt face = 0; face < 2 * look->core->grid.dim && !w->nearest[0]; face++)
    if (!(MPMUnlikelyWall(look, face) == MPM_WALL_free || look->core->grid.periodic[face / 2]))
      (void)snprintf(odd->meant, MPM_WORDS, "no wall is on its way");
  if (w->nearest[0])
    (void)snprintf(odd->meant, MPM_WORDS, "%.60s is %.3g cells away where it is nearest", w->nearest, (double)w->gap);
  if (odd->meant[0] && IsSlowed(look, &look->scene->bodies[k])) {
    if (look->scene->bodies[k].v2 > 0)
      (void)snprintf(own, sizeof own, ", and damping takes its velocity on its way");
    else
      (void)snprintf(own, sizeof own, ", and it falls at %.3g m/s at most",
                     (double)(look->g * look->core->damping.time));
    MPMAppend(odd->meant, MPM_WORDS, "%s", own);
    return MPMUnlikelyGiven("damping_time", NULL, "", odd);
  }
  return odd->meant[0] ? Moves(look, &look->scene->bodies[k], odd) : PETSC_FALSE;
}

PetscBool MPMUnlikely_alone(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return look->core->stages.n > 1 ? PETSC_FALSE : Alone(look, k, odd);
}

PetscBool MPMUnlikely_rigid_alone(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return look->core->stages.n > 1 ? PETSC_FALSE : Alone(look, look->scene->nbodies + k, odd);
}

/* Finds an axis along which the only load acts and no wall that the only body touches holds it. */
PetscBool MPMUnlikely_unheld(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid     = &look->core->grid;
  const MPMLoad *load     = &look->scene->loads[k];
  PetscReal      value[9] = {0}, x[3] = {0}, force[3] = {0}, most = 0, size = 0;

  if (look->core->implicit || look->scene->nloads > 1 || look->scene->nbodies > 1 || look->core->rigids.n ||
      look->g > 0 || look->scene->acceleration || look->core->stages.n || load->type == MPM_LOAD_TORQUE ||
      (load->type != MPM_LOAD_FORCE && load->sides & (load->sides - 1)))
    return PETSC_FALSE;
  for (PetscInt j = 0; !(size > 0) && MPMUnlikelyPlace(grid->dim, look->lowest, look->highest, 2 * PLACES, j, x); j++) {
    if (MPMExpressionEvaluate(load->value, grid->dim, x, x, look->time->end, value)) return PETSC_FALSE;
    for (PetscInt d = 0; d < load->nc; d++) size = PetscMax(size, PetscAbsReal(value[d]));
  }
  if (!(size > 0)) return PETSC_FALSE; /* a blow, after which it flies free */
  for (PetscInt d = 0; d < grid->dim; d++) {
    if (grid->periodic[d]) return PETSC_FALSE;
    force[d] = load->type != MPM_LOAD_PRESSURE             ? value[d]
               : load->sides == (PetscInt)1 << 2 * d       ? 1
               : load->sides == (PetscInt)1 << (2 * d + 1) ? -1
                                                           : 0;
    most     = PetscMax(most, PetscAbsReal(force[d]));
  }
  for (PetscInt d = grid->round ? 1 : 0; d < grid->dim; d++) {
    PetscBool held = !(PetscAbsReal(force[d]) > 1e-6 * most);

    for (PetscInt face = 0; face < 2 * grid->dim; face++) {
      const PetscInt  e    = face / 2;
      const MPMWall   type = MPMUnlikelyWall(look, face);
      const PetscReal gap  = MPMUnlikelyBeside(look, -1, face) - look->scene->walls.place[face] / grid->h[e];

      if (gap < NEAR && (MPMWallHas(type, MPM_WALL_TANGENT | MPM_WALL_BRAKES) ||
                         (e == d && Holds(type, (face % 2 ? 1 : -1) * force[d]))))
        held = PETSC_TRUE;
    }
    if (held) continue;
    (void)snprintf(odd->meant, MPM_WORDS, "%c", "xyz"[d]);
  }
  return odd->meant[0] && MPMUnlikelyGiven("load", load->name, "_value", odd);
}

PetscBool MPMUnlikely_end_soon(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody  *b    = &look->scene->bodies[k];
  const PetscReal high = look->upper[k][look->down] - look->lower[k][look->down],
                  fall = look->g > 0 ? PetscSqrtReal(2 * high / look->g) : 0;

  if (!(fall > 0) || !(look->time->end > 0) || b->v2 > 0 || look->core->implicit || look->core->stages.n ||
      look->core->step || look->scene->known || look->scene->forced ||
      !(look->scene->materials[b->material].type->traits & MPM_LOOSE))
    return PETSC_FALSE;
  odd->ratio = look->time->end / fall;
  MPMUnlikelyWrite(odd->meant, fall);
  return MPMUnlikelyGiven("time_end", NULL, "", odd);
}
