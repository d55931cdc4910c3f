/* move_walls.c - walls that change with time: the velocity of a face by a formula, and where pistons are. A step calls
   it once, before its phases and after them; all processes compute the same numbers. */
#include "scene/scene.h"

#define FORESEEN 1000 /* parts of the time of a run in which the motion of pistons is looked at before it */

/* Sets v [3], m/s, to the velocity of face k at time t, s, which is a formula, or of a single one along its normal. */
static PetscErrorCode Evaluate(const MPMScene *scene, PetscInt dim, PetscInt k, PetscReal t, PetscReal v[])
{
  static const PetscReal nowhere[3] = {0};

  PetscFunctionBeginUser;
  v[0] = v[1] = v[2] = 0;
  PetscCall(MPMExpressionEvaluate(scene->wall_velocity[k], dim, nowhere, NULL, t, v));
  if (scene->wall_along[k] && k / 2) {
    v[k / 2] = v[0];
    v[0]     = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the velocity of face k at time t is finite. Not collective. */
static PetscErrorCode IsFinite(const MPMScene *scene, PetscInt dim, PetscInt k, PetscReal t, PetscBool *finite)
{
  PetscReal v[3];

  PetscFunctionBeginUser;
  PetscCall(Evaluate(scene, dim, k, t, v));
  *finite = PetscAbsReal(v[0]) + PetscAbsReal(v[1]) + PetscAbsReal(v[2]) <= PETSC_MAX_REAL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a text is a single number or formula: it has no comma outside of parentheses. */
static PetscBool IsSingle(const char text[])
{
  PetscInt depth = 0;

  for (const char *c = text; *c; c++) {
    depth += (*c == '(') - (*c == ')');
    if (*c == ',' && !depth) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Reads the velocity of face k: numbers, or a formula of t, which is kept for the steps. A fault is left in o. */
PetscErrorCode MPMSceneReadWallVelocity(MPMScene *scene, const MPMCore *core, PetscInt k, MPMOptions o)
{
  const PetscInt dim                = core->grid.dim;
  MPMFace       *face               = &scene->walls.given[k / 2][k % 2];
  char           text[MPM_TEXT_LEN] = "";
  PetscBool      finite             = PETSC_TRUE;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "bc_<f>_velocity", MPMFaceNames[k], text, NULL));
  scene->wall_along[k] = face->type == MPM_WALL_piston || IsSingle(text);
  PetscCall(MPMOptionsExpression(o, "bc_<f>_velocity", MPMFaceNames[k], "t", scene->wall_along[k] ? 1 : dim,
                                 &scene->wall_velocity[k]));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(IsFinite(scene, dim, k, 0, &finite));
  if (!finite) MPMOptionsFail(o, "-bc_%s_velocity is not finite at t = 0", MPMFaceNames[k]);
  PetscCall(Evaluate(scene, dim, k, 0, face->velocity));
  if (strspn(text, "+-.,0123456789eE \t") == strlen(text)) /* numbers, which no step evaluates again */
    PetscCall(MPMExpressionDestroy(&scene->wall_velocity[k]));
  else
    scene->walls.changes[k] = PETSC_TRUE;
  for (PetscInt d = 0; d < 3; d++) scene->walls.velocity[k][d] = face->velocity[d];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says in core->stop which face has no finite velocity at time t, if one has none. Not collective. */
PetscErrorCode MPMSceneCheckWalls(const MPMScene *scene, MPMCore *core, PetscReal t)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 6; k++) {
    PetscBool finite = PETSC_TRUE;

    if (scene->walls.changes[k]) PetscCall(IsFinite(scene, core->grid.dim, k, t, &finite));
    if (!finite)
      (void)snprintf(core->stop, sizeof core->stop, "-bc_%s_velocity is not finite at t = %g s", MPMFaceNames[k],
                     (double)t);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives the walls whose velocity is a formula that of time t, s. Not collective. */
PetscErrorCode MPMSceneMoveWalls(MPMScene *scene, const MPMCore *core, PetscReal t)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 6; k++)
    if (scene->walls.changes[k]) PetscCall(Evaluate(scene, core->grid.dim, k, t, scene->walls.velocity[k]));
  MPMWallsMove(&scene->walls);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves pistons on by a step dt, s, with the velocity that they had in it. Not collective. */
void MPMScenePassWalls(MPMScene *scene, const MPMCore *core, PetscReal dt)
{
  MPMWalls *w = &scene->walls;

  for (PetscInt k = 0; k < 6; k++)
    if (w->given[k / 2][k % 2].type == MPM_WALL_piston)
      w->place[k] += (k % 2 ? -dt : dt) * w->given[k / 2][k % 2].velocity[k / 2];
  MPMWallsReachTo(w, &core->grid, core->basis);
}

/* Writes to `text` which pistons at the places [6], m, have met, reached the opposite face or left through their own,
   if some have; else nothing. */
static void WhereTo(const MPMScene *scene, const MPMGrid *grid, const PetscReal place[], const char time[],
                    char text[MPM_TEXT_LEN])
{
  text[0] = 0;
  for (PetscInt k = 0; k < 2 * grid->dim && !text[0]; k++) {
    const PetscInt  other  = k % 2 ? k - 1 : k + 1;
    const PetscReal length = grid->upper[k / 2] - grid->lower[k / 2];
    const PetscBool two    = scene->walls.given[k / 2][other % 2].type == MPM_WALL_piston;

    if (scene->walls.given[k / 2][k % 2].type != MPM_WALL_piston) continue;
    if (place[k] < -1e-9 * length)
      (void)snprintf(text, MPM_TEXT_LEN, "the piston of -bc_%s_type leaves the grid through its face%s",
                     MPMFaceNames[k], time);
    else if (two && place[k] + place[other] > (1 - 1e-9) * length)
      (void)snprintf(text, MPM_TEXT_LEN, "the pistons of -bc_%s_type and -bc_%s_type meet%s", MPMFaceNames[k],
                     MPMFaceNames[other], time);
    else if (!two && place[k] > (1 - 1e-9) * length)
      (void)snprintf(text, MPM_TEXT_LEN, "the piston of -bc_%s_type reaches the face %s%s", MPMFaceNames[k],
                     MPMFaceNames[other], time);
  }
}

void MPMSceneCheckPistons(const MPMScene *scene, MPMCore *core)
{
  char text[MPM_TEXT_LEN];

  WhereTo(scene, &core->grid, scene->walls.place, "", text);
  if (text[0] && !core->stop[0]) (void)snprintf(core->stop, sizeof core->stop, "%s", text);
}

PetscErrorCode MPMSceneForesee(const MPMScene *scene, const MPMCore *core, PetscReal end, char text[MPM_TEXT_LEN])
{
  const PetscReal dt = (end - core->t) / FORESEEN;
  PetscReal       place[6], v[3];

  PetscFunctionBeginUser;
  text[0] = 0;
  PetscCall(PetscArraycpy(place, scene->walls.place, 6));
  for (PetscInt n = 0; n < FORESEEN && !text[0]; n++) {
    char time[64];

    for (PetscInt k = 0; k < 2 * core->grid.dim; k++) {
      const MPMFace *f = &scene->walls.given[k / 2][k % 2];

      if (f->type != MPM_WALL_piston) continue;
      PetscCall(PetscArraycpy(v, f->velocity, 3));
      if (scene->walls.changes[k]) PetscCall(Evaluate(scene, core->grid.dim, k, core->t + (n + 0.5) * dt, v));
      place[k] += (k % 2 ? -dt : dt) * v[k / 2];
    }
    (void)snprintf(time, sizeof time, " at t=%.3g s", (double)(core->t + (n + 1) * dt));
    WhereTo(scene, &core->grid, place, time, text);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets *advances to whether face k, which is no piston, ever moves along its normal until the time end, s: a formula is
   looked at in steps of a hundredth of it. Not collective. */
PetscErrorCode MPMSceneWallAdvances(const MPMScene *scene, const MPMCore *core, PetscInt k, PetscReal end,
                                    PetscBool *advances)
{
  const MPMFace *face = &scene->walls.given[k / 2][k % 2];
  PetscReal      v[3];

  PetscFunctionBeginUser;
  *advances = PETSC_FALSE;
  if (!MPMWallHas(face->type, MPM_WALL_MOVES) || face->type == MPM_WALL_piston) PetscFunctionReturn(PETSC_SUCCESS);
  if (face->velocity[k / 2] != 0) *advances = PETSC_TRUE;
  for (PetscInt n = 1; n <= 100 && scene->walls.changes[k] && !*advances; n++) {
    PetscCall(Evaluate(scene, core->grid.dim, k, end * n / 100, v));
    if (v[k / 2] != 0) *advances = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
