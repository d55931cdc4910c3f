/* unit_wall.c - what the rows of wall.def do, and where: at or beyond their face of the grid and nowhere else.        */
#include "mpm.h"
#include "unit.h"

static const char *names[] = {
#define MPM_WALL(name, what) #name,
#include "wall.def"
#undef MPM_WALL
};
static const PetscInt cells[3] = {4, 1, 6};

/* Does node ijk lie at or beyond this face? */
static int On(PetscInt axis, int side, const PetscInt ijk[])
{
  return side ? ijk[axis] >= cells[axis] : ijk[axis] <= 0;
}

/* One wall on one face, all others free. */
static void OneFace(int dim, int axis, int side, MPMWall wall, const PetscInt ijk[])
{
  MPMWall         walls[3][2] = {{MPM_WALL_free}};
  const PetscReal before[3]   = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)};
  PetscReal       v[3];
  PetscBool       constrained;

  walls[axis][side] = wall;
  memcpy(v, before, sizeof v);
  constrained = MPMWallsApply(walls, dim, ijk, cells, v);
  UnitContext("%s on axis %d side %d of %d-D, node %d %d %d", names[wall], axis, side, dim, (int)ijk[0], (int)ijk[1], (int)ijk[2]);
  if (!On(axis, side, ijk) || wall == MPM_WALL_free || wall == MPM_WALL_periodic) {
    CHECK(!constrained);
    CHECK_SAME(v, before, sizeof v);
    return;
  }
  CHECK(constrained); /* every wall that is one constrains */
  for (int d = dim; d < 3; d++) CHECK_EQ(v[d], before[d]); /* no component beyond dim is touched */
  if (wall == MPM_WALL_fixed)
    for (int d = 0; d < dim; d++) CHECK_EQ(v[d], 0);
  if (wall == MPM_WALL_slip)
    for (int d = 0; d < dim; d++) CHECK_EQ(v[d], d == axis ? 0 : before[d]);
}

/* Walls of all kinds on all faces: a corner gets the conditions of all its faces. */
static void Corners(int dim, const PetscInt ijk[])
{
  MPMWall         walls[3][2];
  const PetscReal before[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)};
  PetscReal       v[3], expected[3];
  int             any = 0;

  for (int d = 0; d < 3; d++)
    for (int side = 0; side < 2; side++) {
      const MPMWall choice[3] = {MPM_WALL_free, MPM_WALL_fixed, MPM_WALL_slip};
      walls[d][side]          = choice[UnitInt(3)];
    }
  memcpy(v, before, sizeof v);
  memcpy(expected, before, sizeof v);
  for (int axis = 0; axis < dim; axis++)
    for (int side = 0; side < 2; side++) {
      if (!On(axis, side, ijk) || walls[axis][side] == MPM_WALL_free) continue;
      any = 1;
      for (int d = 0; d < dim; d++)
        if (d == axis || walls[axis][side] == MPM_WALL_fixed) expected[d] = 0;
    }
  UnitContext("corner of %d-D, node %d %d %d", dim, (int)ijk[0], (int)ijk[1], (int)ijk[2]);
  CHECK_EQ(MPMWallsApply(walls, dim, ijk, cells, v) ? 1 : 0, any);
  for (int d = 0; d < 3; d++) CHECK_EQ(v[d], expected[d]);
  memcpy(expected, v, sizeof v);
  MPMWallsApply(walls, dim, ijk, cells, v); /* a second time changes nothing */
  CHECK_SAME(v, expected, sizeof v);
}

int main(void)
{
  for (int dim = 1; dim <= 3; dim++)
    for (PetscInt k = -2; k <= (dim > 2 ? cells[2] + 2 : -2); k++)
      for (PetscInt j = -2; j <= (dim > 1 ? cells[1] + 2 : -2); j++)
        for (PetscInt i = -2; i <= cells[0] + 2; i++) {
          const PetscInt ijk[3] = {i, j, k}; /* entries beyond dim lie beyond a face: they must not count */

          for (int axis = 0; axis < dim; axis++)
            for (int side = 0; side < 2; side++)
              for (int wall = 0; wall < MPM_NUM_WALLS; wall++) OneFace(dim, axis, side, (MPMWall)wall, ijk);
          for (int round = 0; round < 20; round++) Corners(dim, ijk);
        }
  return UnitEnd();
}
