/* read_walls.c - reads the walls of the scene from the options -bc_<face>_*, before the first step. */
#include <stddef.h>
#include "scene/scene.h"

/* The parameters of walls: the word of wall.def, the row of the vocabulary, the offset in MPMFace, and the type: a
   number, one number per axis, or a whole number, such as a wall's reach in layers of nodes. A new parameter needs a
   row here, a member of MPMFace and a row of the vocabulary. The velocity of a wall may be a formula (move_walls.c). */
static const struct {
  const char   *word, *row;
  size_t        place;
  MPMOptionType type;
} parameters[] = {
    {"mu", "bc_<f>_mu", offsetof(MPMFace, mu), MPM_REAL},
    {"velocity", "bc_<f>_velocity", offsetof(MPMFace, velocity), MPM_TEXT},
    {"distance", "bc_<f>_distance", offsetof(MPMFace, distance), MPM_REAL},
    {"pulls", "bc_<f>_pulls", offsetof(MPMFace, pulls), MPM_BOOL},
};
#define NPARAMETERS (sizeof parameters / sizeof parameters[0])

static PetscErrorCode ReadFace(MPMScene *scene, const MPMCore *core, PetscInt number, MPMOptions o)
{
  const char     *name               = MPMFaceNames[number];
  const PetscBool axis               = number == 0 && core->grid.round && core->grid.lower[0] == 0;
  MPMFace        *face               = &scene->walls.given[number / 2][number % 2];
  char            type[MPM_NAME_LEN] = "", all[MPM_TEXT_LEN] = "";
  const char     *taken;
  PetscInt        row;
  PetscBool       set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "bc_<f>_type", name, type, &set));
  if (axis && !set) (void)snprintf(type, sizeof type, "slip"); /* the axis of bodies of revolution holds v_r = 0 */
  if (axis && strcmp(type, "slip"))
    MPMOptionsFail(
        o,
        "-bc_xmin_type %s does not apply: with -geometry axisymmetric the face at x = 0 is the axis, which is "
        "of type slip",
        type);
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsFind(type, MPM_NUM_WALLS, MPMWallNames, &row));
  face->type = (MPMWall)row;
  taken      = MPMWallParameters[face->type];
  for (size_t k = 0; k < NPARAMETERS; k++) MPMAppend(all, sizeof all, "%s%s", k ? " " : "", parameters[k].word);
  PetscCall(MPMOptionsRefuseOthers(o, "bc", name, "type", type, all, taken));
  for (size_t k = 0; k < NPARAMETERS; k++) {
    void *value = (char *)face + parameters[k].place;

    if (!MPMListHas(taken, parameters[k].word)) continue;
    if (parameters[k].type == MPM_REAL) PetscCall(MPMOptionsReal(o, parameters[k].row, name, value, NULL));
    if (parameters[k].type == MPM_REALS) PetscCall(MPMOptionsReals(o, parameters[k].row, name, value, NULL));
    if (parameters[k].type == MPM_TEXT) PetscCall(MPMSceneReadWallVelocity(scene, core, number, o));
    if (parameters[k].type == MPM_INT) PetscCall(MPMOptionsInt(o, parameters[k].row, name, value, NULL));
    if (parameters[k].type == MPM_BOOL) PetscCall(MPMOptionsBool(o, parameters[k].row, name, value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the walls, and which axes are periodic. The first fault is left in o. Not collective. */
PetscErrorCode MPMSceneReadWalls(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < core->grid.dim; d++)
    for (PetscInt side = 0; side < 2; side++) PetscCall(ReadFace(scene, core, 2 * d + side, o));
  for (PetscInt d = 0; d < core->grid.dim; d++) {
    const PetscBool low  = scene->walls.given[d][0].type == MPM_WALL_periodic,
                    high = scene->walls.given[d][1].type == MPM_WALL_periodic;

    if (low != high)
      MPMOptionsFail(o, "-bc_%s_type periodic needs -bc_%s_type periodic too", MPMFaceNames[2 * d + high],
                     MPMFaceNames[2 * d + low]);
    if (low && core->params.gravity[d] != 0)
      MPMOptionsFail(o, "-gravity along %c is not built yet where -bc_%s_type is periodic", "xyz"[d],
                     MPMFaceNames[2 * d]);
    core->grid.periodic[d] = low;
    for (PetscInt side = 0; side < 2; side++) {
      const PetscReal length = core->grid.upper[d] - core->grid.lower[d], at = scene->walls.given[d][side].distance;

      if (at >= length)
        MPMOptionsFail(o, "-bc_%s_distance %g is beyond the opposite face, which is at %g m",
                       MPMFaceNames[2 * d + side], (double)at, (double)length);
      scene->walls.place[2 * d + side] = at;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
