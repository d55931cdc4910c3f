/* unit_wall.c - what the rows of wall.def do, and where: at or beyond their face of the grid and nowhere else; the
   same in the advance of a node, and the walls that are derived for other velocities. */
#include "physics/wall.h"
#include "unit.h"

static const char *names[] = {
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) #name,
#include "physics/wall.def"
};
static const PetscInt cells[3] = {4, 1, 6};

/* The grid of so many dimensions. */
static const MPMGrid *Grid(int dim)
{
  static MPMGrid grid = {.h = {0.5, 0.25, 2}};

  memcpy(grid.cells, cells, sizeof cells);
  grid.dim = dim;
  return &grid;
}

/* Does node ijk lie at or beyond this face? */
static int On(PetscInt axis, int side, const PetscInt ijk[])
{
  return side ? ijk[axis] >= cells[axis] : ijk[axis] <= 0;
}

/* A face with random constants. The matter over all of its nodes is at the wall, or by as much before it as may pass in a
   step with some velocity below 1 m/s. */
static MPMFace Face(MPMWall type)
{
  static PetscReal least[6][128];
  static int       next;
  MPMFace          f = {.type     = type,
                        .mu       = UnitInt(3) ? UnitReal(0, 2) : 0,
                        .velocity = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}};
  const PetscReal  v = UnitInt(2) ? UnitReal(-1, 0) : 0;

  next = (next + 1) % 6;
  for (int i = 0; i < 128; i++) least[next][i] = v;
  f.least = UnitInt(3) ? least[next] : NULL;
  return f;
}

/* The least inward velocity of matter at a face, m/s. */
static PetscReal Least(const MPMFace *f)
{
  return f->least ? f->least[0] : 0;
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
  MPMFace       faces[3][2];
  const MPMFace face      = Face(wall);
  PetscReal     before[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}, v[3], again[3], into;
  PetscBool     constrained;

  memset(faces, 0, sizeof faces); /* free */
  faces[axis][side] = face;
  if (!UnitInt(4)) before[UnitInt(dim)] = 0;
  into = (side ? before[axis] : -before[axis]) + Least(&face); /* what is too fast into the wall */
  memcpy(v, before, sizeof v);
  constrained = MPMWallsApply((const MPMFace(*)[2])faces, Grid(dim), ijk, 0.5, v);
  UnitContext("%s on axis %d side %d of %d-D, node %d %d %d", names[wall], axis, side, dim, (int)ijk[0], (int)ijk[1],
              (int)ijk[2]);
  for (int d = dim; d < 3; d++) CHECK_EQ(v[d], before[d]); /* no component beyond dim is touched */
  if (!On(axis, side, ijk) || wall == MPM_WALL_free || wall == MPM_WALL_periodic ||
      ((wall == MPM_WALL_separate || wall == MPM_WALL_friction) && into <= 0)) {
    CHECK(!constrained);
    CHECK_SAME(v, before, sizeof v);
    return;
  }
  CHECK(constrained);
  for (int d = 0; d < dim; d++) {
    if (wall == MPM_WALL_fixed) CHECK_EQ(v[d], 0);
    if (wall == MPM_WALL_moving) CHECK_EQ(v[d], face.velocity[d]);
    if (wall == MPM_WALL_piston) CHECK_EQ(v[d], d == axis ? face.velocity[d] : before[d]);
    if (wall == MPM_WALL_slip) CHECK_EQ(v[d], d == axis ? 0 : before[d]);
    if (wall == MPM_WALL_separate) CHECK_EQ(v[d], d == axis ? (side ? -1 : 1) * Least(&face) : before[d]);
  }
  if (wall == MPM_WALL_friction) {
    const PetscReal was = Sliding(dim, axis, before), is = Sliding(dim, axis, v);

    CHECK_EQ(v[axis], (side ? -1 : 1) * Least(&face));
    CHECK_NEAR(is, PetscMax(0, was - face.mu * into), 4 * DBL_EPSILON); /* Coulomb */
    for (int d = 0; d < dim; d++)
      if (d != axis) {
        CHECK(v[d] * before[d] >= 0 &&
              PetscAbsReal(v[d]) <= PetscAbsReal(before[d]));    /* never reverses, never speeds up */
        CHECK_NEAR(v[d] * was, before[d] * is, 4 * DBL_EPSILON); /* along the sliding */
        if (face.mu == 0) CHECK_EQ(v[d], before[d]);
      }
  }
  memcpy(again, v, sizeof v);
  if (wall != MPM_WALL_moving) MPMWallsApply((const MPMFace(*)[2])faces, Grid(dim), ijk, 0.5, again);
  CHECK_SAME(again, v, sizeof v); /* a second time changes nothing */
}

/* The mirror image of the wall, and of the velocity, has the mirrored result, with the same bits. */
static void Mirror(int dim, int axis, MPMWall wall)
{
  MPMFace   lower[3][2], upper[3][2];
  PetscReal v[3]  = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}, w[3];
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
  one = MPMWallsApply((const MPMFace(*)[2])lower, Grid(dim), at, 0.5, v);
  two = MPMWallsApply((const MPMFace(*)[2])upper, Grid(dim), opposite, 0.5, w);
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
    for (int side = 0; side < 2; side++) {
      faces[d][side]       = Face(choice[UnitInt(4)]);
      faces[d][side].least = NULL;
    }
  memcpy(v, before, sizeof v);
  memcpy(expected, before, sizeof v);
  for (int axis = 0; axis < dim; axis++)
    for (int side = 0; side < 2; side++) {
      const MPMWall wall = faces[axis][side].type;

      if (!On(axis, side, ijk) || wall == MPM_WALL_free ||
          (wall == MPM_WALL_separate && expected[axis] * (side ? -1 : 1) >= 0))
        continue;
      any = 1;
      for (int d = 0; d < dim; d++)
        if (d == axis || wall == MPM_WALL_fixed) expected[d] = 0;
    }
  UnitContext("corner of %d-D, node %d %d %d", dim, (int)ijk[0], (int)ijk[1], (int)ijk[2]);
  constrained = MPMWallsApply((const MPMFace(*)[2])faces, Grid(dim), ijk, 0.5, v);
  CHECK_EQ(constrained ? 1 : 0, any);
  for (int d = 0; d < 3; d++) CHECK_EQ(v[d], expected[d]);
  memcpy(expected, v, sizeof v);
  MPMWallsApply((const MPMFace(*)[2])faces, Grid(dim), ijk, 0.5, v); /* a second time changes nothing */
  CHECK_SAME(v, expected, sizeof v);
}

/* A wall that reaches some layers of nodes inside the grid acts on these as on its face, and on none further in; a node
   is asked about its walls if any of them reaches it. */
static void Reach(int dim, int axis, int side)
{
  const PetscInt reach = UnitInt(4);
  MPMFace        faces[3][2];

  memset(faces, 0, sizeof faces); /* free, of no reach */
  faces[axis][side]       = Face(MPM_WALL_moving);
  faces[axis][side].reach = reach;
  UnitContext("reach of %d layers on axis %d side %d of %d-D", (int)reach, axis, side, dim);
  for (PetscInt i = -2; i <= cells[axis] + 2; i++) {
    const PetscInt inside = side ? cells[axis] - i : i;
    PetscInt       ijk[3] = {2, 0, 3};
    PetscReal      v[3]   = {2, 3, 4};
    PetscBool      held;

    ijk[axis] = i;
    held      = MPMWallsApply((const MPMFace(*)[2])faces, Grid(dim), ijk, 0.5, v);
    CHECK_EQ(held ? 1 : 0, inside <= reach ? 1 : 0);
    for (int d = 0; d < 3; d++) CHECK_EQ(v[d], held && d < dim ? faces[axis][side].velocity[d] : 2 + d);
    CHECK_EQ(MPMWallsReach((const MPMFace(*)[2])faces, Grid(dim), axis, i) ? 1 : 0,
             i <= 0 || i >= cells[axis] || inside <= reach ? 1 : 0);
  }
}

/* Is it a wall that matter may leave? */
static int Pushes(MPMWall wall)
{
  return wall == MPM_WALL_separate || wall == MPM_WALL_friction;
}

/* v and at as the step makes them: v is held by the walls that hold, at = v + dt a. */
static void Trial(const MPMFace (*faces)[2], int dim, const PetscInt ijk[], PetscReal dt, PetscReal v[],
                  const PetscReal a[], PetscReal at[])
{
  MPMWalls w;

  memcpy(w.given, faces, sizeof w.given);
  MPMWallsDerive(&w);
  MPMWallsApply((const MPMFace(*)[2])w.before, Grid(dim), ijk, dt, v);
  for (int d = 0; d < dim; d++) at[d] = v[d] + dt * a[d];
}

/* The advance of a node with one wall on one face, all others free. */
static void AdvanceOneFace(int dim, int axis, int side, MPMWall wall, const PetscInt ijk[])
{
  const MPMFace   face = Face(wall);
  const PetscReal dt = UnitInt(2) ? 0.125 : UnitReal(1e-3, 1), lo = side ? 1 : -1;
  MPMFace         faces[3][2];
  PetscReal v[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}, force[3], a[3], at[3], trial[3] = {0}, old[3],
            into, was, is, lost;
  PetscInt met;

  memset(faces, 0, sizeof faces); /* free */
  faces[axis][side] = face;
  for (int d = 0; d < 3; d++) at[d] = force[d] = a[d] = UnitInt(5) ? UnitReal(-2, 2) / dt : 0;
  switch (UnitInt(6)) { /* a node that comes to rest, that is at rest, that the force alone moves */
  case 0:
    v[axis] = 0;
    break;
  case 1:
    v[axis] = force[axis] = a[axis] = 0;
    break;
  case 2:
    for (int d = 0; d < 3; d++) v[d] = 0;
    break;
  default:
    break;
  }
  Trial((const MPMFace(*)[2])faces, dim, ijk, dt, v, a, at);
  memcpy(old, v, sizeof v);
  memcpy(trial, at, sizeof at);
  met = MPMWallsAdvance((const MPMFace(*)[2])faces, Grid(dim), ijk, dt, v, at, a);
  UnitContext("advance at %s on axis %d side %d of %d-D, node %d %d %d", names[wall], axis, side, dim, (int)ijk[0],
              (int)ijk[1], (int)ijk[2]);
  CHECK_SAME(v, old, sizeof v);
  for (int d = dim; d < 3; d++) CHECK(at[d] == trial[d] && a[d] == force[d]); /* no component beyond dim is touched */
  into = lo * trial[axis] + Least(&face); /* what the force gives counts, not v alone */
  if (!On(axis, side, ijk) || wall == MPM_WALL_free || wall == MPM_WALL_periodic || (Pushes(wall) && into <= 0)) {
    CHECK_EQ(met, 0);
    CHECK_SAME(at, trial, sizeof at); /* leaving, or no wall: free */
    CHECK_SAME(a, force, sizeof a);
    return;
  }
  CHECK_EQ(met, Pushes(wall) ? 1 << axis : 0);
  for (int d = 0; d < dim; d++) { /* a wall that holds: no acceleration, whatever pulls */
    if (wall == MPM_WALL_fixed) CHECK(at[d] == 0 && v[d] == 0 && a[d] == 0);
    if (wall == MPM_WALL_moving)
      CHECK(at[d] == face.velocity[d] && v[d] == face.velocity[d] && (a[d] == 0 || force[d] == 0));
    if (wall == MPM_WALL_moving) CHECK_NEAR(a[d], 0, 0);
    if (wall == MPM_WALL_piston && d == axis) CHECK(at[d] == face.velocity[d] && a[d] == 0);
    if (wall == MPM_WALL_piston && d != axis) CHECK(at[d] == trial[d] && a[d] == force[d]);
    if (wall == MPM_WALL_slip && d == axis) CHECK(at[d] == 0 && v[d] == 0 && a[d] == 0);
    if ((wall == MPM_WALL_slip || wall == MPM_WALL_separate) && d != axis) CHECK(at[d] == trial[d] && a[d] == force[d]);
  }
  if (!Pushes(wall)) return;
  CHECK_EQ(at[axis], -lo * Least(&face)); /* the matter just arrives, and the stop is in a */
  CHECK_NEAR(dt * a[axis], at[axis] - v[axis], 8 * DBL_EPSILON);
  if (wall != MPM_WALL_friction) return;
  lost = into; /* all that the wall takes along its normal presses */
  was  = Sliding(dim, axis, trial);
  is   = Sliding(dim, axis, at);
  CHECK_NEAR(is, PetscMax(0, was - face.mu * lost), 16 * DBL_EPSILON * (1 + was)); /* Coulomb */
  for (int d = 0; d < dim; d++)
    if (d != axis) {
      CHECK(at[d] * trial[d] >= 0 &&
            PetscAbsReal(at[d]) <= PetscAbsReal(trial[d]));                       /* never reverses, never speeds up */
      CHECK_NEAR(at[d] * was, trial[d] * is, 16 * DBL_EPSILON * (1 + was * was)); /* along the sliding */
      CHECK_NEAR(dt * a[d], at[d] - v[d], 8 * DBL_EPSILON * (1 + was));           /* the impulse is in a */
      if (face.mu == 0) CHECK(at[d] == trial[d] && a[d] == force[d]);
    }
}

/* Walls of all kinds but moving on all faces, at edges and corners: a wall that pushes and is met holds its axis, one
   that is left does not; where two faces of the grid are the same axis (one cell) only one is touched at a time. */
static void AdvanceCorners(int dim, const PetscInt ijk[])
{
  const PetscReal dt = 0.25;
  MPMFace         faces[3][2];
  PetscReal       v[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}, a[3], at[3], trial[3] = {0}, force[3];
  PetscInt        met, expected = 0;
  PetscReal       friction = 0;
  int             fixed = 0, held[3] = {0};

  for (int k = 0; k < 6; k++) {
    MPMWall wall;

    do wall = (MPMWall)UnitInt(MPM_NUM_WALLS);
    while (MPMWallHas(wall, MPM_WALL_MOVES));
    faces[k / 2][k % 2]       = Face(wall);
    faces[k / 2][k % 2].least = NULL;
  }
  for (int d = 0; d < 3; d++) at[d] = a[d] = force[d] = UnitReal(-4, 4);
  Trial((const MPMFace(*)[2])faces, dim, ijk, dt, v, a, at);
  memcpy(trial, at, sizeof at);
  for (int d = 0; d < dim; d++)
    for (int side = 0; side < 2; side++) {
      const MPMWall wall = faces[d][side].type;

      if (!On(d, side, ijk)) continue;
      fixed |= wall == MPM_WALL_fixed;
      if (wall == MPM_WALL_slip) held[d] = 1;
      if (Pushes(wall) && (side ? 1 : -1) * trial[d] > 0) {
        expected |= (PetscInt)1 << d;
        held[d] = 1;
        if (wall == MPM_WALL_friction) friction += faces[d][side].mu * (side ? 1 : -1) * trial[d];
      }
    }
  met = MPMWallsAdvance((const MPMFace(*)[2])faces, Grid(dim), ijk, dt, v, at, a);
  UnitContext("advance at a corner of %d-D, node %d %d %d", dim, (int)ijk[0], (int)ijk[1], (int)ijk[2]);
  CHECK_EQ(met, expected);
  for (int d = 0; d < dim; d++) {
    if (fixed || held[d]) CHECK_EQ(at[d], 0);
    CHECK(at[d] * trial[d] >= 0 && PetscAbsReal(at[d]) <= PetscAbsReal(trial[d]));
    CHECK_LE(PetscAbsReal(at[d] - trial[d]), fixed || held[d] ? PetscAbsReal(trial[d]) : friction + 16 * DBL_EPSILON);
    if (!held[d] && !fixed && !(friction > 0)) CHECK(at[d] == trial[d] && a[d] == force[d]);
    CHECK_NEAR(dt * a[d], at[d] - v[d], 8 * DBL_EPSILON);
  }
  for (int d = dim; d < 3; d++) CHECK(at[d] == trial[d] && a[d] == force[d]);
}

/* A node on a corner of a moving wall and one that pushes: it has the velocity of the moving wall, unless that leads into
   the other one, which then stops it. */
static void AdvanceMoving(int dim, int mover, int pusher, MPMWall wall)
{
  const PetscReal dt = 0.25;
  MPMFace         faces[3][2];
  PetscInt        at_lower[3] = {0, 0, 0}, met;
  PetscReal       v[3]        = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}, a[3], at[3];

  memset(faces, 0, sizeof faces);
  for (int d = 0; d < 3; d++) at_lower[d] = d == mover || d == pusher ? 0 : 3;
  if (dim > 1 && mover != 1 && pusher != 1) at_lower[1] = 1; /* one cell: its upper face is free */
  faces[mover][0]  = Face(MPM_WALL_moving);
  faces[pusher][0] = Face(wall);
  for (int d = 0; d < 3; d++) at[d] = a[d] = UnitReal(-4, 4);
  Trial((const MPMFace(*)[2])faces, dim, at_lower, dt, v, a, at);
  met = MPMWallsAdvance((const MPMFace(*)[2])faces, Grid(dim), at_lower, dt, v, at, a);
  UnitContext("advance at a moving wall on axis %d and %s on axis %d of %d-D, velocity %g", mover, names[wall], pusher,
              dim, faces[mover][0].velocity[pusher]);
  for (int d = 0; d < dim; d++) {
    const PetscReal V = faces[mover][0].velocity[d], least = Least(&faces[pusher][0]);

    if (d == pusher) {
      CHECK_EQ(at[d], PetscMax(V, least));
      if (V < least) CHECK(met >> d & 1); /* so that a second mapping keeps it */
    } else if (wall == MPM_WALL_friction)
      CHECK(at[d] * V >= 0 && PetscAbsReal(at[d]) <= PetscAbsReal(V));
    else
      CHECK_EQ(at[d], V);
    if (at[d] == v[d]) CHECK_EQ(a[d], 0);
  }
}

/* The mirror image of an advance is the advance of the mirror image, with the same bits. */
static void AdvanceMirror(int dim, int axis, MPMWall wall)
{
  const PetscReal dt = UnitReal(0.1, 1);
  MPMFace         lower[3][2], upper[3][2];
  PetscInt        low[3] = {2, 0, 3}, high[3] = {2, 0, 3}, one, two;
  PetscReal       v[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}, a[3], at[3], w[3], b[3], bt[3];

  memset(lower, 0, sizeof lower);
  memset(upper, 0, sizeof upper);
  lower[axis][0] = upper[axis][1] = Face(wall);
  upper[axis][1].velocity[axis] *= -1;
  for (int d = 0; d < 3; d++) {
    at[d] = a[d] = UnitReal(-4, 4);
    w[d]         = d == axis ? -v[d] : v[d];
    bt[d] = b[d] = d == axis ? -a[d] : a[d];
  }
  low[axis]  = 0;
  high[axis] = cells[axis];
  Trial((const MPMFace(*)[2])lower, dim, low, dt, v, a, at);
  Trial((const MPMFace(*)[2])upper, dim, high, dt, w, b, bt);
  one = MPMWallsAdvance((const MPMFace(*)[2])lower, Grid(dim), low, dt, v, at, a);
  two = MPMWallsAdvance((const MPMFace(*)[2])upper, Grid(dim), high, dt, w, bt, b);
  UnitContext("advance at %s on axis %d of %d-D, mirrored", names[wall], axis, dim);
  CHECK_EQ(one, two);
  for (int d = 0; d < 3; d++) {
    CHECK_EQ(bt[d], d == axis ? -at[d] : at[d]);
    CHECK_EQ(b[d], d == axis ? -a[d] : a[d]);
  }
}

/* The walls of other velocities of nodes, by type; each keeps its constants. And what they do: of what xpic filters the
   walls hold 0, and leave free what depends on a sign; gradients feel no friction; before an advance a wall that only
   pushes does nothing. */
static void Derived(void)
{
  for (int wall = 0; wall < MPM_NUM_WALLS; wall++) {
    MPMWalls w;
    MPMFace  kept[3][2];

    memset(&w, 0, sizeof w);
    for (int k = 0; k < 6; k++) {
      w.given[k / 2][k % 2]       = Face((MPMWall)((wall + k) % MPM_NUM_WALLS));
      w.given[k / 2][k % 2].least = NULL;
      w.given[k / 2][k % 2].reach = k % 3;
    }
    memcpy(kept, w.given, sizeof kept);
    MPMWallsDerive(&w);
    CHECK_SAME(kept, w.given, sizeof kept);
    for (int k = 0; k < 6; k++) {
      const MPMFace *of[4] = {&w.before[k / 2][k % 2], &w.gradient[k / 2][k % 2], &w.residual[k / 2][k % 2],
                              &w.again[k / 2][k % 2]},
                    *f     = &w.given[k / 2][k % 2];
      const MPMWall type   = f->type;

      UnitContext("walls derived from %s", names[type]);
      for (int i = 0; i < 4; i++)
        CHECK(of[i]->mu == f->mu && of[i]->velocity[0] == f->velocity[0] && of[i]->velocity[1] == f->velocity[1] &&
              of[i]->velocity[2] == f->velocity[2] && of[i]->reach == f->reach);
      CHECK_EQ(of[0]->type, Pushes(type) ? MPM_WALL_free : type);
      CHECK_EQ(of[1]->type, type == MPM_WALL_friction ? MPM_WALL_separate : type);
      CHECK_EQ(of[2]->type, Pushes(type)                         ? MPM_WALL_free
                            : !MPMWallHas(type, MPM_WALL_MOVES)  ? type
                            : MPMWallHas(type, MPM_WALL_TANGENT) ? MPM_WALL_fixed
                                                                 : MPM_WALL_slip);
      CHECK_EQ(of[3]->type, of[0]->type);
      for (int round = 0; round < 10; round++) {
        const MPMGrid   far  = {.dim = 3, .cells = {200, 200, 200}, .h = {1, 1, 1}};
        const PetscReal r[3] = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)}, into = (k % 2 ? 1 : -1) * r[k / 2];
        PetscInt        at[3] = {100, 100, 100};
        PetscReal       v[3][3];

        for (int i = 0; i < 3; i++) memcpy(v[i], r, sizeof r);
        at[k / 2] = k % 2 ? 200 : 0;
        MPMWallsApply((const MPMFace(*)[2])w.before, &far, at, 0.5, v[0]);
        MPMWallsApply((const MPMFace(*)[2])w.gradient, &far, at, 0.5, v[1]);
        MPMWallsApply((const MPMFace(*)[2])w.residual, &far, at, 0.5, v[2]);
        for (int d = 0; d < 3; d++) {
          const int       gives = type == MPM_WALL_moving || (type == MPM_WALL_piston && d == k / 2);
          const PetscReal held  = type == MPM_WALL_fixed || (type == MPM_WALL_slip && d == k / 2) ? 0
                                  : gives                                                         ? f->velocity[d]
                                                                                                  : r[d];

          CHECK_EQ(v[0][d], held);
          CHECK_EQ(v[1][d], Pushes(type) && d == k / 2 && into > 0 ? 0 : held);
          CHECK_EQ(v[2][d], gives ? 0 : held);
        }
      }
    }
  }
}

/* What changes with time: velocities that formulas give, and the layers of nodes behind a piston. */
static void Changes(void)
{
  const MPMGrid *grid = Grid(3);
  MPMWalls       w;

  for (int k = 0; k < 6; k++) {
    const int axis = k / 2, side = k % 2, changes = UnitInt(2);
    PetscReal was[3];
    MPMFace  *f = &w.given[axis][side];

    UnitContext("a piston at face %d", k);
    memset(&w, 0, sizeof w);
    *f = Face(MPM_WALL_piston);
    memcpy(was, f->velocity, sizeof was);
    MPMWallsDerive(&w);
    w.changes[k] = changes ? PETSC_TRUE : PETSC_FALSE;
    for (int d = 0; d < 3; d++) w.velocity[k][d] = UnitReal(-1, 1);
    MPMWallsMove(&w);
    for (int d = 0; d < 3; d++) {
      const PetscReal now = changes ? w.velocity[k][d] : was[d];

      CHECK_EQ(w.before[axis][side].velocity[d], was[d]);
      CHECK(f->velocity[d] == now && w.again[axis][side].velocity[d] == now &&
            w.gradient[axis][side].velocity[d] == now);
    }
    for (int layers = -2; layers < cells[axis] + 3; layers++) {
      const PetscInt reach = PetscClipInterval(layers, 0, cells[axis] - 1) -
                             1; /* behind the two nodes beside the plane */

      w.place[k] = (layers + UnitReal(0.01, 0.99)) * grid->h[axis];
      MPMWallsReachTo(&w, grid, MPM_BASIS_linear);
      CHECK(f->reach == reach && w.before[axis][side].reach == reach && w.again[axis][side].reach == reach &&
            w.gradient[axis][side].reach == reach && w.residual[axis][side].reach == reach);
      CHECK_EQ(f->beside, 2);
      CHECK_EQ(f->first, side ? cells[axis] - reach - 2 : reach + 1);
    }
  }
}

/* The column `acts` of a row says what its function does: it leaves, holds at a value of its own, or only pushes the
   component along the normal, and it leaves or holds the others. */
static void Acts(int dim, int axis, int side, MPMWall wall)
{
  const int       normal = MPMWallHas(wall, MPM_WALL_NORMAL), pushes = MPMWallHas(wall, MPM_WALL_PUSHES);
  const PetscReal inward = side ? -1 : 1;
  PetscInt        ijk[3] = {1, 1, 1};
  MPMFace         faces[3][2];
  PetscReal       v[2][3], was[2][3];

  UnitContext("what %s does, in %d-D at face %d", names[wall], dim, 2 * axis + side);
  memset(faces, 0, sizeof faces);
  faces[axis][side] = Face(wall);
  for (int d = 0; d < dim; d++) ijk[d] = d == axis ? (side ? cells[d] : 0) : 0;
  for (int d = 0; d < dim; d++) faces[d][0].least = faces[d][1].least = NULL;
  for (int i = 0; i < 2; i++) {
    for (int d = 0; d < 3; d++) was[i][d] = v[i][d] = UnitReal(-1, 1);
    was[i][axis] = v[i][axis] = (i ? -1 : 1) * inward * UnitReal(0.1, 1); /* away from the wall, and into it */
    if (wall != MPM_WALL_piston) MPMWallsApply((const MPMFace(*)[2])faces, Grid(dim), ijk, 0, v[i]);
  }
  if (wall == MPM_WALL_piston) return; /* it acts behind its plane */
  for (int d = 0; d < dim; d++) {
    const int held = d == axis ? normal && !pushes : MPMWallHas(wall, MPM_WALL_TANGENT);

    if (held) CHECK_EQ(v[0][d], v[1][d]);
    if (held && !MPMWallHas(wall, MPM_WALL_MOVES)) CHECK_EQ(v[0][d], 0);
    if (MPMWallHas(wall, MPM_WALL_OPEN) || pushes) CHECK_EQ(v[0][d], was[0][d]);
    if (MPMWallHas(wall, MPM_WALL_OPEN)) CHECK_EQ(v[1][d], was[1][d]);
    if (pushes && d == axis) CHECK_EQ(v[1][d], 0);
    if (d != axis && normal && !MPMWallHas(wall, MPM_WALL_TANGENT | MPM_WALL_BRAKES)) CHECK_EQ(v[1][d], was[1][d]);
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
                for (int round = 0; round < 5; round++) {
                  OneFace(dim, axis, side, (MPMWall)wall, ijk);
                  AdvanceOneFace(dim, axis, side, (MPMWall)wall, ijk);
                }
          for (int round = 0; round < 20; round++) Corners(dim, ijk);
          for (int round = 0; round < 50; round++) Changes();
          for (int round = 0; round < 20; round++) AdvanceCorners(dim, ijk);
        }
  for (int round = 0; round < 50; round++)
    for (int dim = 1; dim <= 3; dim++)
      for (int k = 0; k < 2 * dim; k++) Reach(dim, k / 2, k % 2);
  for (int round = 0; round < 500; round++)
    for (int dim = 1; dim <= 3; dim++)
      for (int wall = 0; wall < MPM_NUM_WALLS; wall++) {
        Mirror(dim, UnitInt(dim), (MPMWall)wall);
        AdvanceMirror(dim, UnitInt(dim), (MPMWall)wall);
        for (int axis = 1; axis < dim; axis++) {
          if (!Pushes((MPMWall)wall)) continue;
          AdvanceMoving(dim, axis, axis - 1, (MPMWall)wall);
          AdvanceMoving(dim, axis - 1, axis, (MPMWall)wall);
        }
      }
  for (int round = 0; round < 20; round++)
    for (int dim = 1; dim <= 3; dim++)
      for (int k = 0; k < 2 * dim; k++)
        for (int wall = 0; wall < MPM_NUM_WALLS; wall++) Acts(dim, k / 2, k % 2, (MPMWall)wall);
  Derived();
  return UnitEnd();
}
