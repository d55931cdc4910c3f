/* unlikely_motion.c - the rows of plausible.def of what does not meet, stand, flow or come to rest. */
#include "advice/unlikely.h"

PetscBool MPMUnlikely_hangs(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;
  const PetscInt down = look->down, up = look->core->params.gravity[look->down] > 0;
  const MPMBody *b     = &look->scene->bodies[k];
  PetscBool      walls = PETSC_FALSE;

  if (!(look->g > 0) || MPMInitialGravity(look->scene) > 0 || b->v2 > 0 || grid->total || look->core->rigids.n ||
      look->core->stages.now > 1 || look->core->step ||
      !(look->scene->materials[b->material].type->traits & MPM_LOOSE) ||
      look->scene->walls.given[down][up].type == MPM_WALL_free ||
      (up ? look->upper[k][down] < look->highest[down] : look->lower[k][down] > look->lowest[down]))
    return PETSC_FALSE;
  for (PetscInt d = 0; d < grid->dim; d++)
    for (PetscInt side = 0; side < 2 && d != down; side++)
      if (look->scene->walls.given[d][side].type != MPM_WALL_free && !grid->periodic[d] &&
          MPMUnlikelyBeside(look, k, 2 * d + side) < 0.3)
        walls = PETSC_TRUE;
  odd->ratio = MPMUnlikelyBeside(look, k, 2 * down + up) - look->scene->walls.place[2 * down + up] / grid->h[down];
  (void)snprintf(odd->option, MPM_WORDS, "-body_%s_shape", b->name);
  (void)snprintf(odd->meant, MPM_WORDS, "%c = %.6g", "xyz"[down], (double)(up ? grid->upper[down] : grid->lower[down]));
  return walls;
}

/* Does loose matter fill a box on the floor of the grid and from wall to wall, with room above it and nothing on it? */
static PetscBool IsPool(const MPMLook *look, PetscInt k)
{
  const MPMGrid     *grid = &look->core->grid;
  const MPMBody     *b    = &look->scene->bodies[k];
  const MPMMaterial *m    = &look->scene->materials[b->material];
  const PetscInt     up   = grid->dim - 1;
  PetscReal          x[3] = {0};
  MPMOdd             odd;

  if (!(m->type->traits & MPM_LOOSE) || MPMUnlikelyCohesion(m) > 0 || b->source.on || b->points || b->removed ||
      MPMUnlikelyGiven("material", m->name, "_tension_cutoff", &odd) || MPMUnlikelyBeside(look, k, 2 * up + 1) < 1 ||
      MPMWallHas(MPMUnlikelyWall(look, 2 * up + 1), MPM_WALL_MOVES))
    return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * grid->dim - 1; face++)
    if ((MPMUnlikelyWall(look, face) == MPM_WALL_free && !(grid->round && !face)) || grid->periodic[face / 2] ||
        MPMUnlikelyBeside(look, k, face) - look->scene->walls.place[face] / grid->h[face / 2] > 0.3)
      return PETSC_FALSE;
  for (PetscInt other = 0; other < look->scene->nbodies + look->scene->nshapes; other++) {
    PetscReal lower[3], upper[3];

    if (other == k || look->scene->bodies[other].source.on) continue;
    MPMRegionBounds(&look->scene->bodies[other].region, grid->dim, lower, upper);
    if (PetscAbsReal(lower[up] - look->upper[k][up]) < grid->h[up]) return PETSC_FALSE;
  }
  for (PetscInt j = 0; MPMUnlikelyPlace(grid->dim, look->lower[k], look->upper[k], 8, j, x); j++) {
    x[up] = look->upper[k][up] - 0.01 * grid->h[up];
    if (!MPMRegionInside(&b->region, grid->dim, x)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* What is slow beside a fall from the height of a pool moves it, and no weight holds it down. */
PetscBool MPMUnlikely_weightless(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMScene  *scene = look->scene;
  const PetscInt   dim = look->core->grid.dim, up = dim - 1;
  const MPMFormula shakes = MPMUnlikelyFormula(look, scene->nloads + 6);
  PetscReal        x[3] = {0}, speed = 0;
  PetscBool        moves = shakes.value != NULL;

  if (dim == 1 || look->g > 0 || scene->nloads || scene->initial || !MPMUnlikelyStarts(look) || look->core->stages.n)
    return PETSC_FALSE;
  if (moves) (void)snprintf(odd->meant, MPM_WORDS, "-acceleration");
  for (PetscInt j = 0; moves && j < 16; j++) {
    PetscReal a[9] = {0};

    if (MPMExpressionEvaluate(shakes.value, dim, x, x, look->time->end * ((PetscReal)j + 0.5) / 16, a) || a[up] != 0)
      return PETSC_FALSE;
  }
  for (PetscInt b = 0; b < scene->nbodies; b++) {
    const MPMBody  *body = &scene->bodies[b];
    const PetscReal v    = body->source.on ? body->source.speed : PetscSqrtReal(body->v2);

    if (v > speed) (void)snprintf(odd->meant, MPM_WORDS, "-body_%s_velocity", body->name);
    speed = PetscMax(speed, v);
  }
  for (PetscInt f = 0; f < MPMUnlikelyFormulas(look); f++) {
    const MPMFormula moving = MPMUnlikelyFormula(look, f);
    const PetscReal  v      = f == scene->nloads + 6 ? 0 : MPMUnlikelySize(look, &moving);

    if (v > speed) (void)snprintf(odd->meant, MPM_WORDS, "-%s_%s%s", moving.group, moving.name, moving.word);
    speed = PetscMax(speed, v);
  }
  for (PetscInt face = 0; face < 2 * dim; face++) { /* a constant velocity has no formula */
    const MPMFace *wall = &scene->walls.given[face / 2][face % 2];

    if (!MPMWallHas(wall->type, MPM_WALL_MOVES)) continue;
    for (PetscInt d = 0; d < dim; d++) {
      if (PetscAbsReal(wall->velocity[d]) > speed)
        (void)snprintf(odd->meant, MPM_WORDS, "-bc_%.8s_velocity", MPMFaceNames[face]);
      speed = PetscMax(speed, PetscAbsReal(wall->velocity[d]));
    }
  }
  for (PetscInt b = 0; b < scene->nbodies; b++)
    if (IsPool(look, b) && speed * speed < 200 * (look->upper[b][up] - look->lower[b][up]))
      (void)snprintf(odd->other, MPM_WORDS, "%s", scene->bodies[b].name);
  return odd->meant[0] && odd->other[0];
}

/* A body that lay on matter which its stage removes, and that touches nothing of what is left. */
PetscBool MPMUnlikely_undermined(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  const MPMGrid  *grid  = &look->core->grid;
  const PetscInt  down = look->down, up = look->core->params.gravity[look->down] > 0,
                 all = scene->nbodies + scene->nshapes;
  PetscBool lay      = PETSC_FALSE;

  if (look->core->stages.now < 2 || !(look->g > 0) || !MPMUnlikelyGiven("remove", NULL, "", odd)) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * grid->dim; face++)
    if (MPMWallHas(MPMUnlikelyWall(look, face), MPM_WALL_TANGENT | MPM_WALL_BRAKES | MPM_WALL_MOVES) &&
        MPMUnlikelyBeside(look, k, face) < 1)
      return PETSC_FALSE;
  for (PetscInt b = 0; b < all; b++) {
    const MPMBody *body = &scene->bodies[b];
    PetscReal      lower[3], upper[3];

    if (b == k || body->source.on || (b >= scene->nbodies && body->rigid == MPM_RIGID_NONE)) continue;
    MPMRegionBounds(&body->region, grid->dim, lower, upper);
    if (MPMUnlikelyGap(look, look->lower[k], look->upper[k], lower, upper) > 1) continue;
    if (!body->removed) return PETSC_FALSE;
    if (!body->rigid && (up ? upper[down] > look->upper[k][down] : lower[down] < look->lower[k][down]))
      lay = PETSC_TRUE;
  }
  odd->ratio = MPMUnlikelyBeside(look, k, 2 * down + up);
  (void)snprintf(odd->option, MPM_WORDS, "-stage_%.100s_remove", scene->stages[look->core->stages.now - 1]);
  (void)snprintf(odd->meant, MPM_WORDS,
                 MPMUnlikelyWall(look, 2 * down + up) == MPM_WALL_free ? "out of the grid" : "onto the wall %s",
                 MPMFaceNames[2 * down + up]);
  return lay;
}

PetscBool MPMUnlikely_rest_undamped(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  return MPMUnlikelyGiven("time_rest", NULL, "", odd) && strtod(odd->value, NULL) > 0 && !MPMDampingIsOn(look->core) &&
         !look->core->implicit;
}

PetscBool MPMUnlikely_check_walls(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  PetscReal most;

  if (!MPMUnlikelyNumber("check_momentum", NULL, "", odd, &most) || !(most > 0 && most <= 0.1)) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++) {
    const MPMWall type = MPMUnlikelyWall(look, face);

    if (type != MPM_WALL_free && type != MPM_WALL_periodic && !odd->other[0])
      (void)snprintf(odd->other, MPM_WORDS, "the wall -bc_%.8s_type %.40s", MPMFaceNames[face], MPMWallNames[type]);
  }
  return odd->other[0] != 0;
}

/* The steepest long edge at the top of a polygon of soil that starts at rest, or is to settle: its tangent, over that of
   the friction angle that acts. */
PetscBool MPMUnlikely_steep(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMCore     *core = look->core;
  const MPMBody     *b    = &look->scene->bodies[k];
  const MPMMaterial *m    = &look->scene->materials[b->material];
  MPMSurface        *s    = b->region.surface;
  const PetscReal    acts = PetscTanReal(m->acts[core->grid.dim == 2] * PETSC_PI / 180),
                  high    = look->upper[k][1] - look->lower[k][1];
  PetscReal angle         = 0;

  if (core->grid.dim != 2 || core->grid.round || !s || !(m->type->traits & MPM_LOOSE) || core->step || core->rigids.n ||
      core->stages.now > 1 || !(core->params.gravity[1] < 0) || b->v2 > 0 ||
      !(MPMInitialGravity(look->scene) > 0 || MPMDampingIsOn(core)) || !(acts > 0) ||
      MPMUnlikelyCohesion(m) > 1e-3 * MPMUnlikelyWeight(look, b->material))
    return PETSC_FALSE;
  for (PetscInt e = 0; e < s->n; e++) {
    const PetscReal *p = s->corner + 4 * e, dx = PetscAbsReal(p[2] - p[0]), dy = PetscAbsReal(p[3] - p[1]);
    const PetscReal  mid[3] = {0.5 * (p[0] + p[2]), 0.5 * (p[1] + p[3]), 0};

    if (!(dy > 0.25 * high && dx > 0.1 * dy)) continue; /* steeper ones are cuts */
    (void)MPMSurfaceLine(s, mid);
    if (MPMSurfaceBelow(s, mid[1] + 1e-6 * high) % 2 || dy / dx < PetscTanReal(angle)) continue;
    angle = PetscAtanReal(dy / dx);
  }
  odd->ratio = PetscTanReal(angle) / acts;
  MPMUnlikelyWrite(odd->meant, angle * 180 / PETSC_PI);
  return MPMUnlikelyGiven("material", m->name, "_friction_angle", odd);
}
