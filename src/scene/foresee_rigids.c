/* foresee_rigids.c - where rigid bodies that move by formulas come to, before the run: into others, near a wall that matter
   lies on, or out of the grid.
   All processes compute the same numbers. */
#include "scene/scene.h"

#define FORESEEN 200  /* parts of the time of a run in which their motion is looked at */
#define FLAT     0.4  /* of its thickness: no solid that keeps its volume is meant to be pressed to less */
#define FLOWS    0.05 /* likewise of matter that flows away to the sides, or of foam */
#define FOAM     0.2  /* Poisson's ratio below which a solid may be crushed */
#define DEEP     0.5 /* cells: bodies that lie deeper in each other than at the start by this pass through each other */

/* Returns how deep a point of the surface of a lies in b, m, or 0. */
static PetscReal Depth(const MPMRigid *a, const MPMRigid *b, PetscInt dim)
{
  PetscReal x[3], n[3], deep = 0;

  for (PetscInt d = 0; d < 3; d++) x[d] = a->pivot[d] + a->place[d];
  if (MPMRigidDistance(b, dim, x, n) > a->reach) return 0;
  for (PetscInt k = 0; k < a->npoints; k++) {
    MPMRigidPoint(a, k, x);
    deep = PetscMax(deep, -MPMRigidDistance(b, dim, x, n));
  }
  return deep;
}

/* Returns whether all of a body lies beyond a face of the grid. */
static PetscBool Left(const MPMRigid *r, const MPMGrid *grid)
{
  for (PetscInt d = 0; d < grid->dim; d++) {
    PetscReal lower = PETSC_MAX_REAL, upper = PETSC_MIN_REAL, x[3];

    for (PetscInt k = 0; k < r->npoints; k++) {
      MPMRigidPoint(r, k, x);
      lower = PetscMin(lower, x[d]);
      upper = PetscMax(upper, x[d]);
    }
    if (r->npoints && (lower > grid->upper[d] || upper < grid->lower[d])) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Looks at bodies [n] as they are at time t, s. deep [n][n]: how deep they lie in each other at the start, m; left [n]: when
   they have left the grid, s. */
static void Look(MPMRigids *rigids, const MPMGrid *grid, PetscReal t, const MPMRigid body[], PetscReal deep[],
                 PetscReal left[])
{
  const PetscReal h = MPMGridSmallestH(grid);

  for (PetscInt i = 0; i < rigids->n; i++) {
    if (body[i].free || !body[i].moves || body[i].gone || left[i] < PETSC_INFINITY) continue;
    if (Left(&body[i], grid)) left[i] = t;
    for (PetscInt j = 0; j < rigids->n && !(rigids->meet < PETSC_INFINITY); j++) {
      const PetscInt  at = i * rigids->n + j;
      const PetscReal by = i == j || body[j].free || body[j].gone
                               ? 0
                               : PetscMax(Depth(&body[i], &body[j], grid->dim), Depth(&body[j], &body[i], grid->dim));

      if (t == 0) deep[at] = by;
      if (!(by > deep[at] + DEEP * h)) continue;
      rigids->meet     = t;
      rigids->meets[0] = i;
      rigids->meets[1] = j;
    }
  }
}

/* How much a rigid body leaves of the thickness of a body of matter between it and a wall. */
typedef struct {
  PetscInt  body, face; /* body < 0: there is none */
  PetscReal bears, left,
      t; /* parts of the thickness: what such matter bears, what is left; s: when it comes below that */
} Press;

/* Returns whether matter of body b lies between the boxes of a rigid one and the wall of a face, beside it on all other axes. */
static PetscBool Between(const MPMScene *scene, const MPMGrid *grid, const MPMBody *b, const PetscReal lower[],
                         const PetscReal upper[], const PetscReal rigid[2][3], PetscInt face)
{
  const PetscReal far = 1.5;

  if (!MPMWallHas(scene->walls.given[face / 2][face % 2].type, MPM_WALL_NORMAL) || b->removed || b->source.on)
    return PETSC_FALSE;
  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal h = far * grid->h[d];

    if (d != face / 2) {
      if (rigid[0][d] > lower[d] + h || rigid[1][d] < upper[d] - h) return PETSC_FALSE; /* matter gives way */
    } else if (face % 2 ? upper[d] < grid->upper[d] - h || lower[d] < rigid[1][d] - h
                        : lower[d] > grid->lower[d] + h || upper[d] > rigid[0][d] + h)
      return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Returns how far the nearest point of the surface of a rigid body, above those places of a body on the other axes, is from the
   wall of a face, m. */
static PetscReal Room(const MPMRigid *r, const MPMGrid *grid, const PetscReal lower[], const PetscReal upper[],
                      PetscInt face)
{
  PetscReal room = PETSC_MAX_REAL, x[3];

  for (PetscInt k = 0; k < r->npoints; k++) {
    PetscBool over = PETSC_TRUE;

    MPMRigidPoint(r, k, x);
    for (PetscInt d = 0; d < grid->dim; d++)
      if (d != face / 2 && (x[d] < lower[d] || x[d] > upper[d])) over = PETSC_FALSE;
    if (over)
      room = PetscMin(room, face % 2 ? grid->upper[face / 2] - x[face / 2] : x[face / 2] - grid->lower[face / 2]);
  }
  return room;
}

/* Looks at what body r, which had such a box at the start, presses against walls at time t. */
static void LookAtWalls(const MPMScene *scene, const MPMGrid *grid, const MPMRigid *r, PetscReal t, Press *press)
{
  PetscReal rigid[2][3], lower[3], upper[3];

  MPMRegionBounds(r->shape, grid->dim, rigid[0], rigid[1]);
  for (PetscInt k = 0; k < scene->nbodies; k++) {
    const MPMBody     *b  = &scene->bodies[k];
    const MPMMaterial *m  = &scene->materials[b->material];
    const PetscReal least = MPMMaterialKeepsShape(m) && !(m->type->traits & MPM_PLASTIC) && m->nu > FOAM ? FLAT : FLOWS;

    if (b->points) continue;
    MPMRegionBounds(&b->region, grid->dim, lower, upper);
    for (PetscInt face = 0; face < 2 * grid->dim; face++) {
      PetscReal left;

      if (!Between(scene, grid, b, lower, upper, rigid, face)) continue;
      left = Room(r, grid, lower, upper, face) / (upper[face / 2] - lower[face / 2]);
      if (!(left < least)) continue;
      if (press->body < 0) *press = (Press){k, face, least, left, t};
      press->left = PetscMin(press->left, left);
    }
  }
}

static PetscBool Turns(const MPMRigid *r)
{
  return r->angle[0] != 0 || r->angle[1] != 0 || r->angle[2] != 0;
}

/* Returns the option that moves a body most likely out of the grid: its pivot, if that lies beside it. */
static const char *Option(const MPMRigid *r, PetscInt dim)
{
  PetscReal lower[3], upper[3];

  if (!Turns(r)) return "velocity";
  MPMRegionBounds(r->shape, dim, lower, upper);
  for (PetscInt d = 0; d < dim; d++)
    if (r->pivot[d] < lower[d] || r->pivot[d] > upper[d]) return "pivot";
  return "spin";
}

PetscErrorCode MPMSceneForeseeRigids(const MPMScene *scene, MPMCore *core, PetscReal end)
{
  MPMRigids *rigids = &core->rigids;
  MPMRigid  *body;
  PetscReal *numbers, *deep, *left;
  Press     *press;

  PetscFunctionBeginUser;
  rigids->meet = PETSC_INFINITY;
  if (!rigids->driven) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc5(rigids->n, &body, rigids->n * MPM_RIGID_NUMBERS, &numbers, rigids->n * rigids->n, &deep,
                         rigids->n, &left, rigids->n, &press));
  PetscCall(PetscArrayzero(numbers, rigids->n * MPM_RIGID_NUMBERS));
  for (PetscInt k = 0; k < rigids->n; k++) {
    body[k]  = rigids->body[k];
    left[k]  = PETSC_INFINITY;
    press[k] = (Press){-1, 0, 0, 0, 0};
    MPMRigidUse(&body[k], numbers + k * MPM_RIGID_NUMBERS);
    for (PetscInt d = 0; d < 3; d++) body[k].turn[4 * d] = 1;
    if (!body[k].free) PetscCall(MPMRigidSetPoints(&body[k], core->grid.dim));
  }
  for (PetscInt n = 0; n <= FORESEEN; n++) {
    Look(rigids, &core->grid, end * n / FORESEEN, body, deep, left);
    PetscCall(MPMSceneEvaluateRigids(scene, core->grid.dim, end * (n + 0.5) / FORESEEN, body));
    for (PetscInt k = 0; k < rigids->n; k++) {
      if (body[k].free) continue;
      if (body[k].moves && !body[k].gone && n) LookAtWalls(scene, &core->grid, &body[k], end * n / FORESEEN, &press[k]);
      MPMRigidMove(&body[k], end / FORESEEN);
    }
  }
  if (rigids->meet < PETSC_INFINITY && core->t < rigids->meet)
    PetscCall(
        MPMWarn(&core->print,
                "the rigid bodies %s and %s pass through each other from t=%.3g s on, which ends the run; choose an "
                "earlier -time_end, or another motion",
                body[rigids->meets[0]].name, body[rigids->meets[1]].name, (double)rigids->meet));
  for (PetscInt k = 0; k < rigids->n; k++) {
    if (left[k] < PETSC_INFINITY)
      PetscCall(MPMNote(
          &core->print,
          "the rigid body %s leaves the grid at t=%.3g s; from then on it meets nothing: check -body_%s_%s and -time_end",
          body[k].name, (double)left[k], body[k].name, Option(&body[k], core->grid.dim)));
    if (press[k].body >= 0)
      PetscCall(MPMNote(
          &core->print,
          "the rigid body %s presses %s against its wall %s to %.2g of its thickness until -time_end (to %g at t=%.3g s): check -body_%s_%s",
          body[k].name, scene->bodies[press[k].body].name, MPMFaceNames[press[k].face],
          (double)PetscMax(0, press[k].left), (double)press[k].bears, (double)press[k].t, body[k].name,
          Turns(&body[k]) ? "spin" : "velocity"));
    if (!body[k].free) PetscCall(PetscFree(body[k].point));
  }
  PetscCall(PetscFree5(body, numbers, deep, left, press));
  PetscFunctionReturn(PETSC_SUCCESS);
}
