/* unlikely_pairs.c - the rows of plausible.def of two bodies that touch at the start, and of a rigid body or a piston beside
   what it pushes. */
#include "advice/unlikely.h"

#define PLACES 24  /* on each axis, at which two bodies may touch */
#define TOUCH  0.1 /* cells: bodies whose boxes are nearer than that touch, */
#define NEAR   1   /* and what is nearer than that shares nodes */

/* Finds the place, among those where the boxes of bodies a and b are nearest, that is nearest to both shapes; returns whether
   they touch there. */
static PetscBool Touch(const MPMLook *look, PetscInt a, PetscInt b, PetscReal at[3])
{
  const MPMGrid   *grid = &look->core->grid;
  const MPMRegion *A = &look->scene->bodies[a].region, *B = &look->scene->bodies[b].region;
  const PetscBool  shapes = !look->scene->bodies[a].points && !look->scene->bodies[b].points &&
                           MPMRegionHasDistance(A) && MPMRegionHasDistance(B);
  PetscReal least = PETSC_MAX_REAL, lower[3], upper[3], x[3] = {0}, n[3];

  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal far = TOUCH * grid->h[d];

    lower[d] = PetscMax(look->lower[a][d], look->lower[b][d]) - far;
    upper[d] = PetscMin(look->upper[a][d], look->upper[b][d]) + far;
    if (lower[d] > upper[d]) return PETSC_FALSE;
    at[d] = 0.5 * (lower[d] + upper[d]);
  }
  if (!shapes) return PETSC_TRUE;
  for (PetscInt j = 0; MPMUnlikelyPlace(grid->dim, lower, upper, PLACES, j, x); j++) {
    const PetscReal far = PetscMax(PetscAbsReal(MPMRegionDistance(A, grid->dim, x, n)),
                                   PetscAbsReal(MPMRegionDistance(B, grid->dim, x, n)));

    if (far >= least) continue;
    least = far;
    for (PetscInt d = 0; d < grid->dim; d++) at[d] = x[d];
  }
  return least < 2 * TOUCH * MPMGridSmallestH(grid);
}

/* Body k and a later one that it touches, whose velocities differ there by a part of them, though both are of one piece. */
PetscBool MPMUnlikely_glued(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  const PetscInt  dim   = look->core->grid.dim;
  PetscInt        mover;

  if (look->core->contacts || look->core->grid.total || look->core->step || scene->known) return PETSC_FALSE;
  for (PetscInt other = k + 1; other < scene->nbodies; other++) {
    const MPMBody *body[2] = {&scene->bodies[k], &scene->bodies[other]};
    PetscReal      v[2][9] = {{0}, {0}}, at[3] = {0}, differ = 0, size[2] = {0, 0};
    PetscBool      fluid = PETSC_FALSE, good = PETSC_TRUE;

    for (int j = 0; j < 2; j++)
      if (scene->materials[body[j]->material].type->traits & MPM_FLUID || body[j]->removed || body[j]->source.on)
        fluid = PETSC_TRUE;
    if (fluid || !(body[0]->v2 + body[1]->v2 > 0) || !Touch(look, k, other, at)) continue;
    for (int j = 0; j < 2; j++)
      if (body[j]->velocity && MPMExpressionEvaluate(body[j]->velocity, dim, at, at, 0, v[j])) good = PETSC_FALSE;
    for (PetscInt d = 0; d < dim; d++) {
      differ += PetscSqr(v[0][d] - v[1][d]);
      for (int j = 0; j < 2; j++) size[j] += v[j][d] * v[j][d];
    }
    if (!good || !(PetscSqrtReal(differ) > 0.05 * PetscSqrtReal(PetscMax(body[0]->v2, body[1]->v2)))) continue;
    mover = size[1] > size[0];
    (void)snprintf(odd->other, MPM_WORDS, "%.60s", body[mover]->name);
    (void)snprintf(odd->meant, MPM_WORDS, "%.60s", body[!mover]->name);
    return MPMUnlikelyGiven("body", body[mover]->name, "_velocity", odd);
  }
  return PETSC_FALSE;
}

/* Returns whether something holds body k at the start against a push along axis d, to the side of sign: a wall, another body, or
   weight. */
static PetscBool Holds(const MPMLook *look, PetscInt k, PetscInt d, PetscReal sign)
{
  const MPMScene  *scene = look->scene;
  const MPMGrid   *grid  = &look->core->grid;
  const PetscReal *low = look->lower[k], *high = look->upper[k];

  if (look->g > 0 || scene->nloads || scene->acceleration || grid->periodic[d]) return PETSC_TRUE;
  for (PetscInt face = 0; face < 2 * grid->dim; face++) {
    const MPMWall   type  = MPMUnlikelyWall(look, face);
    const PetscBool ahead = face == 2 * d + (sign > 0);

    if (ahead && MPMWallHas(type, MPM_WALL_NORMAL)) return PETSC_TRUE; /* it may come there */
    if (MPMWallHas(type, MPM_WALL_TANGENT | MPM_WALL_BRAKES) && MPMUnlikelyBeside(look, k, face) < NEAR)
      return PETSC_TRUE;
    if (face / 2 == d && !ahead && MPMWallHas(type, MPM_WALL_NORMAL) &&
        !MPMWallHas(type, MPM_WALL_PUSHES | MPM_WALL_MOVES) && MPMUnlikelyBeside(look, k, face) < NEAR)
      return PETSC_TRUE; /* such a wall does not let go */
  }
  for (PetscInt b = 0; b < scene->nbodies + scene->nshapes; b++) {
    const PetscReal *lower = look->lower[b], *upper = look->upper[b];
    PetscReal        gap = -1;

    if (b == k || (b >= scene->nbodies && scene->bodies[b].rigid == MPM_RIGID_NONE)) continue;
    for (PetscInt e = 0; e < grid->dim; e++)
      if (e != d) gap = PetscMax(gap, MPMUnlikelyApart(look, e, low, high, lower, upper));
    if (gap < NEAR && (sign > 0 ? upper[d] > high[d] + 1e-9 * grid->h[d] : lower[d] < low[d] - 1e-9 * grid->h[d]))
      return PETSC_TRUE; /* it is ahead, or beside */
  }
  return PETSC_FALSE;
}

/* Finds a body that what has such a box touches and pushes along d by its way, with nothing that holds it. */
static PetscBool Pushes(const MPMLook *look, const PetscReal lower[], const PetscReal upper[], PetscInt d,
                        PetscReal way, MPMOdd *odd)
{
  const PetscReal sign = way > 0 ? 1 : -1;

  if (look->core->stages.n > 1 || look->core->step || look->scene->known || look->core->params.deletes)
    return PETSC_FALSE;
  for (PetscInt k = 0; k < look->scene->nbodies; k++) {
    const PetscReal *low = look->lower[k], *high = look->upper[k];

    if (look->scene->bodies[k].removed || look->scene->bodies[k].v2 > 0 ||
        !(MPMUnlikelyGap(look, low, high, lower, upper) < NEAR) ||
        sign * (0.5 * (low[d] + high[d]) - (sign > 0 ? upper[d] : lower[d])) < 0 || Holds(look, k, d, sign))
      continue;
    (void)snprintf(odd->other, MPM_WORDS, "%.60s", look->scene->bodies[k].name);
    (void)snprintf(odd->meant, MPM_WORDS, "-bc_%.8s_type", MPMFaceNames[2 * d + (sign > 0)]);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_pushes_away(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = &look->scene->bodies[look->scene->nbodies + k];
  PetscReal      most;

  if (b->rigid != MPM_RIGID_MOVING || !b->velocity || b->tied) return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) {
    const PetscReal way = MPMUnlikelyAdvance(look, b->velocity, d, 0, 1, &most);

    if (way != 0 &&
        Pushes(look, look->lower[look->scene->nbodies + k], look->upper[look->scene->nbodies + k], d, way, odd))
      return MPMUnlikelyGiven("body", b->name, "_velocity", odd);
  }
  return PETSC_FALSE;
}

/* Two bodies, of which one may be rigid and fixed, that touch at a side and move along it alone, with friction between them. */
PetscBool MPMUnlikely_unpressed(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  const MPMGrid  *grid  = &look->core->grid;
  PetscReal       v[9] = {0}, w[9] = {0}, lower[3], upper[3], mu = 0;
  PetscInt        other = -1, side = -1;

  if (!MPMUnlikelyStarts(look) || look->g > 0 || scene->forced || scene->initial || look->core->stages.n ||
      MPMWallsHave(&scene->walls, MPM_WALL_MOVES) || scene->nbodies + look->core->rigids.n != 2 ||
      !(scene->bodies[k].v2 > 0) || !MPMUnlikelyVelocity(look, k, odd, v))
    return PETSC_FALSE;
  for (PetscInt b = 0; b < scene->nbodies + scene->nshapes; b++)
    if (b != k && (b < scene->nbodies || scene->bodies[b].rigid != MPM_RIGID_NONE)) other = b;
  if (other < scene->nbodies ? scene->bodies[other].v2 > 0 && !MPMUnlikelyVelocity(look, other, odd, w)
                             : scene->bodies[other].rigid != MPM_RIGID_FIXED)
    return PETSC_FALSE;
  MPMRegionBounds(&scene->bodies[other].region, grid->dim, lower, upper);
  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal gap = MPMUnlikelyApart(look, d, look->lower[k], look->upper[k], lower, upper);

    if (gap > TOUCH || (gap > -TOUCH && side >= 0)) return PETSC_FALSE;
    if (gap > -TOUCH) side = d;
  }
  if (side < 0 || v[side] != w[side]) return PETSC_FALSE;
  (void)snprintf(odd->other, MPM_WORDS, "%.60s slides along %.60s", scene->bodies[k].name, scene->bodies[other].name);
  if (other >= scene->nbodies) return MPMUnlikelyNumber("body", scene->bodies[other].name, "_mu", odd, &mu) && mu > 0;
  for (PetscInt c = 0; c < scene->ncontacts; c++)
    if (MPMUnlikelyNumber("contact", scene->contacts[c], "_mu", odd, &mu) && mu > 0) return PETSC_TRUE;
  return MPMUnlikelyNumber("contact_mu", NULL, "", odd, &mu) && mu > 0;
}

/* The first of rigid bodies that all hold matter and move alike, by formulas that are the same at all times of the run. */
PetscBool MPMUnlikely_grips_alike(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  const MPMBody  *b     = &scene->bodies[scene->nbodies + k];
  const PetscInt  dim   = look->core->grid.dim;

  if (b->rigid != MPM_RIGID_MOVING || !b->tied || !b->velocity || look->g > 0 || scene->forced ||
      MPMWallsHave(&scene->walls, MPM_WALL_NORMAL))
    return PETSC_FALSE;
  for (PetscInt r = scene->nbodies; r < scene->nbodies + scene->nshapes; r++) {
    const MPMBody *other = &scene->bodies[r];

    if (other == b || other->rigid == MPM_RIGID_NONE) continue;
    if (other < b || other->rigid != MPM_RIGID_MOVING || !other->tied || !other->velocity || other->spin || b->spin)
      return PETSC_FALSE;
    for (PetscInt j = 0; j < PLACES; j++) {
      const PetscReal x[3] = {0}, t = look->time->end * ((PetscReal)j + 0.5) / PLACES;
      PetscReal       v[2][9] = {{0}, {0}};

      if (MPMExpressionEvaluate(b->velocity, dim, x, x, t, v[0]) ||
          MPMExpressionEvaluate(other->velocity, dim, x, x, t, v[1]))
        return PETSC_FALSE;
      for (PetscInt d = 0; d < dim; d++)
        if (v[0][d] != v[1][d]) return PETSC_FALSE;
    }
    (void)snprintf(odd->other, MPM_WORDS, "%s", other->name);
  }
  return odd->other[0] && MPMUnlikelyGiven("body", b->name, "_velocity", odd);
}

PetscBool MPMUnlikely_piston_pushes(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid  *grid = &look->core->grid;
  const PetscInt  d = k / 2, side = k % 2;
  const MPMFace  *f     = &look->scene->walls.given[d][side];
  const PetscReal plane = side ? grid->upper[d] - look->scene->walls.place[k]
                               : grid->lower[d] + look->scene->walls.place[k];
  PetscReal       box[2][3], way, most;

  if (f->type != MPM_WALL_piston) return PETSC_FALSE;
  for (PetscInt e = 0; e < grid->dim; e++) {
    box[0][e] = e == d ? (side ? plane : grid->lower[e] - 1e3 * grid->h[e]) : grid->lower[e];
    box[1][e] = e == d ? (side ? grid->upper[e] + 1e3 * grid->h[e] : plane) : grid->upper[e];
  }
  way = MPMUnlikelyAdvance(look, look->scene->wall_velocity[k], 0, f->velocity[d], 1, &most);
  if (!((side ? -way : way) > 0) || !Pushes(look, box[0], box[1], d, way, odd)) return PETSC_FALSE;
  return MPMUnlikelyGiven("bc", MPMFaceNames[k], "_velocity", odd);
}
