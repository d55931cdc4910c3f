/* move_walls.c - walls that change with time: the velocity of a face by a formula, and where pistons are. A step calls
   it once, before its phases and after them; all processes compute the same numbers. */
#include "scene/scene.h"

/* Sets v [3], m/s, to the velocity of face k at time t, s, which is a formula. A piston has a component along its axis
   alone. */
static PetscErrorCode Evaluate(const MPMScene *scene, PetscInt dim, PetscInt k, PetscReal t, PetscReal v[])
{
  static const PetscReal nowhere[3] = {0};

  PetscFunctionBeginUser;
  v[0] = v[1] = v[2] = 0;
  PetscCall(MPMExpressionEvaluate(scene->wall_velocity[k], dim, nowhere, NULL, t, v));
  if (scene->walls.given[k / 2][k % 2].type == MPM_WALL_piston && k / 2) {
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
  *finite = PetscAbsReal(v[0]) + PetscAbsReal(v[1]) + PetscAbsReal(v[2]) <= PETSC_MAX_REAL ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
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
  PetscCall(MPMOptionsExpression(o, "bc_<f>_velocity", MPMFaceNames[k], "t", face->type == MPM_WALL_piston ? 1 : dim,
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
  MPMWallsReachTo(w, &core->grid);
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
  if (face->type != MPM_WALL_moving) PetscFunctionReturn(PETSC_SUCCESS);
  if (face->velocity[k / 2] != 0) *advances = PETSC_TRUE;
  for (PetscInt n = 1; n <= 100 && scene->walls.changes[k] && !*advances; n++) {
    PetscCall(Evaluate(scene, core->grid.dim, k, end * n / 100, v));
    if (v[k / 2] != 0) *advances = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
