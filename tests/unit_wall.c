/* unit_wall.c - what the rows of wall.def do, and where: at or beyond their face of the grid and nowhere else.        */
#include "mpm.h"
#include "unit.h"

static const char *names[] = {
#define MPM_WALL(name, parameters, what) #name,
#include "wall.def"
#undef MPM_WALL
};
static const PetscInt cells[3] = {4, 1, 6};

/* Does node ijk lie at or beyond this face? */
static int On(PetscInt axis, int side, const PetscInt ijk[])
{
  return side ? ijk[axis] >= cells[axis] : ijk[axis] <= 0;
}

/* A face with random constants. */
static MPMFace Face(MPMWall type)
{
  return (MPMFace){type, UnitInt(3) ? UnitReal(0, 2) : 0, {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}};
}

static PetscReal Sliding(int dim, int axis, const PetscReal v[])
{
  PetscReal s = 0;

  for (int d = 0; d < dim; d++)
    if (d != axis) s += v[d] * v[d];
  return PetscSqrtReal(s);
}

/* One wall on one face, all others free. */
static void OneFace(int dim, int axis, int side, MPMWall wall, const PetscInt ijk[])
{
  MPMFace         faces[3][2];
  const MPMFace   face      = Face(wall);
  PetscReal       before[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}, v[3], again[3], into;
  PetscBool       constrained;

  memset(faces, 0, sizeof faces); /* free */
  faces[axis][side] = face;
  if (!UnitInt(4)) before[UnitInt(dim)] = 0;
  into = side ? before[axis] : -before[axis]; /* speed into the wall */
  memcpy(v, before, sizeof v);
  constrained = MPMWallsApply((const MPMFace(*)[2])faces, dim, ijk, cells, v);
  UnitContext("%s on axis %d side %d of %d-D, node %d %d %d", names[wall], axis, side, dim, (int)ijk[0], (int)ijk[1], (int)ijk[2]);
  for (int d = dim; d < 3; d++) CHECK_EQ(v[d], before[d]); /* no component beyond dim is touched */
  if (!On(axis, side, ijk) || wall == MPM_WALL_free || wall == MPM_WALL_periodic || ((wall == MPM_WALL_separate || wall == MPM_WALL_friction) && into <= 0)) {
    CHECK(!constrained);
    CHECK_SAME(v, before, sizeof v);
    return;
  }
  CHECK(constrained);
  for (int d = 0; d < dim; d++) {
    if (wall == MPM_WALL_fixed) CHECK_EQ(v[d], 0);
    if (wall == MPM_WALL_moving) CHECK_EQ(v[d], face.velocity[d]);
    if (wall == MPM_WALL_slip || wall == MPM_WALL_separate) CHECK_EQ(v[d], d == axis ? 0 : before[d]);
  }
  if (wall == MPM_WALL_friction) {
    const PetscReal was = Sliding(dim, axis, before), is = Sliding(dim, axis, v);

    CHECK_EQ(v[axis], 0);
    CHECK_NEAR(is, PetscMax(0, was - face.mu * into), 4 * DBL_EPSILON);                      /* Coulomb */
    for (int d = 0; d < dim; d++)
      if (d != axis) {
        CHECK(v[d] * before[d] >= 0 && PetscAbsReal(v[d]) <= PetscAbsReal(before[d]));      /* never reverses, never speeds up */
        CHECK_NEAR(v[d] * was, before[d] * is, 4 * DBL_EPSILON);                             /* along the sliding */
        if (face.mu == 0) CHECK_EQ(v[d], before[d]);
      }
  }
  memcpy(again, v, sizeof v);
  if (wall != MPM_WALL_moving) MPMWallsApply((const MPMFace(*)[2])faces, dim, ijk, cells, again);
  CHECK_SAME(again, v, sizeof v); /* a second time changes nothing */
}

/* The mirror image of the wall, and of the velocity, has the mirrored result, with the same bits. */
static void Mirror(int dim, int axis, MPMWall wall)
{
  MPMFace   lower[3][2], upper[3][2];
  PetscReal v[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}, w[3];
  PetscInt  at[3] = {2, 0, 3}, opposite[3] = {2, 0, 3};
  PetscBool one, two;

  memset(lower, 0, sizeof lower); /* free */
  memset(upper, 0, sizeof upper);
  lower[axis][0] = upper[axis][1] = Face(wall);
  upper[axis][1].velocity[axis] *= -1;
  memcpy(w, v, sizeof w);
  w[axis]        = -v[axis];
  at[axis]       = 0;
  opposite[axis] = cells[axis];
  UnitContext("%s on axis %d of %d-D, mirrored", names[wall], axis, dim);
  one = MPMWallsApply((const MPMFace(*)[2])lower, dim, at, cells, v);
  two = MPMWallsApply((const MPMFace(*)[2])upper, dim, opposite, cells, w);
  CHECK_EQ(one, two);
  for (int d = 0; d < 3; d++) CHECK_EQ(w[d], d == axis ? -v[d] : v[d]);
}

/* Walls of all kinds on all faces: a corner gets the conditions of all its faces. */
static void Corners(int dim, const PetscInt ijk[])
{
  static const MPMWall choice[] = {MPM_WALL_free, MPM_WALL_fixed, MPM_WALL_slip, MPM_WALL_separate};
  MPMFace              faces[3][2];
  const PetscReal      before[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)};
  PetscReal            v[3], expected[3];
  PetscBool            constrained;
  int                  any = 0;

  for (int d = 0; d < 3; d++)
    for (int side = 0; side < 2; side++) faces[d][side] = Face(choice[UnitInt(4)]);
  memcpy(v, before, sizeof v);
  memcpy(expected, before, sizeof v);
  for (int axis = 0; axis < dim; axis++)
    for (int side = 0; side < 2; side++) {
      const MPMWall wall = faces[axis][side].type;

      if (!On(axis, side, ijk) || wall == MPM_WALL_free || (wall == MPM_WALL_separate && expected[axis] * (side ? -1 : 1) >= 0)) continue;
      any = 1;
      for (int d = 0; d < dim; d++)
        if (d == axis || wall == MPM_WALL_fixed) expected[d] = 0;
    }
  UnitContext("corner of %d-D, node %d %d %d", dim, (int)ijk[0], (int)ijk[1], (int)ijk[2]);
  constrained = MPMWallsApply((const MPMFace(*)[2])faces, dim, ijk, cells, v);
  CHECK_EQ(constrained ? 1 : 0, any);
  for (int d = 0; d < 3; d++) CHECK_EQ(v[d], expected[d]);
  memcpy(expected, v, sizeof v);
  MPMWallsApply((const MPMFace(*)[2])faces, dim, ijk, cells, v); /* a second time changes nothing */
  CHECK_SAME(v, expected, sizeof v);
}

/* Of what xpic filters from velocities the walls hold 0, and leave free what depends on a sign. */
static void Residuals(void)
{
  for (int wall = 0; wall < MPM_NUM_WALLS; wall++) {
    MPMFace faces[3][2], residual[3][2];

    for (int k = 0; k < 6; k++) faces[k / 2][k % 2] = Face((MPMWall)((wall + k) % MPM_NUM_WALLS));
    MPMWallsOfResidual((const MPMFace(*)[2])faces, residual);
    for (int k = 0; k < 6; k++)
      for (int round = 0; round < 10; round++) {
        const MPMWall   type = faces[k / 2][k % 2].type;
        const PetscInt  mid[3] = {100, 100, 100}, far[3] = {200, 200, 200};
        const PetscReal r[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)};
        PetscInt        at[3] = {mid[0], mid[1], mid[2]};
        PetscReal       v[3] = {r[0], r[1], r[2]};

        UnitContext("residual at %s", names[type]);
        at[k / 2] = k % 2 ? 200 : 0;
        MPMWallsApply((const MPMFace(*)[2])residual, 3, at, far, v);
        for (int d = 0; d < 3; d++) CHECK_EQ(v[d], type == MPM_WALL_fixed || type == MPM_WALL_moving || (type == MPM_WALL_slip && d == k / 2) ? 0 : r[d]);
      }
  }
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
              for (int wall = 0; wall < MPM_NUM_WALLS; wall++)
                for (int round = 0; round < 5; round++) OneFace(dim, axis, side, (MPMWall)wall, ijk);
          for (int round = 0; round < 20; round++) Corners(dim, ijk);
        }
  for (int round = 0; round < 500; round++)
    for (int dim = 1; dim <= 3; dim++)
      for (int wall = 0; wall < MPM_NUM_WALLS; wall++) Mirror(dim, UnitInt(dim), (MPMWall)wall);
  Residuals();
  return UnitEnd();
}
