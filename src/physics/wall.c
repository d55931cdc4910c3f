/* wall.c - conditions on the velocity at the faces of the grid (docs/method.md, Walls), before the advance and in it. A
   condition is applied to v [dim] of a node at or beyond its face `f`, or within the face's reach, and returns whether
   it constrained v. */
#include "physics/wall.h"

/* The place of a node: along the normal `axis` of the face, `distance` m inside the grid (negative: beyond the face); h
   is the distance of nodes along it, m, so that distance/h is the number of its layer. inward is +1 or -1, the sign of
   a velocity away from the wall. least: the least inward velocity that a wall that pushes allows, m/s. dt is the time
   over which the advance accelerates, s, and 0 for velocities that no advance makes, so that what acts over time acts
   once a step. */
typedef struct {
  PetscInt  dim, axis;
  PetscReal inward, distance, h, least, dt;
} WallNode;

#define MPM_WALL_ARGUMENTS const MPMFace *f, const WallNode *at, PetscReal v[]

static PetscBool MPMWallApply_free(MPM_WALL_ARGUMENTS)
{
  (void)f;
  (void)at;
  (void)v;
  return PETSC_FALSE;
}

static PetscBool MPMWallApply_fixed(MPM_WALL_ARGUMENTS)
{
  (void)f;
  for (PetscInt d = 0; d < at->dim; d++) v[d] = 0;
  return PETSC_TRUE;
}

static PetscBool MPMWallApply_slip(MPM_WALL_ARGUMENTS)
{
  (void)f;
  v[at->axis] = 0;
  return PETSC_TRUE;
}

static PetscBool MPMWallApply_separate(MPM_WALL_ARGUMENTS)
{
  (void)f;
  if (at->inward * v[at->axis] >= at->least) return PETSC_FALSE;
  v[at->axis] = at->inward * at->least;
  return PETSC_TRUE;
}

/* Reduces the length of the components of v [dim] beside `axis` by `most`, but not below 0. */
static void Brake(PetscInt dim, PetscInt axis, PetscReal most, PetscReal v[])
{
  PetscReal slide = 0;

  for (PetscInt d = 0; d < dim; d++) slide += d == axis ? 0 : v[d] * v[d];
  slide = PetscSqrtReal(slide);
  for (PetscInt d = 0; d < dim; d++)
    if (d != axis) v[d] = slide > most ? v[d] * (1 - most / slide) : 0;
}

/* Coulomb friction: the velocity along the wall loses at most mu times what the wall takes of the normal one. */
static PetscBool MPMWallApply_friction(MPM_WALL_ARGUMENTS)
{
  const PetscReal press = at->least - at->inward * v[at->axis];

  if (!MPMWallApply_separate(f, at, v)) return PETSC_FALSE;
  Brake(at->dim, at->axis, f->mu * press, v);
  return PETSC_TRUE;
}

/* A periodic face is no wall: its nodes are those of the opposite face. */
static PetscBool MPMWallApply_periodic(MPM_WALL_ARGUMENTS)
{
  return MPMWallApply_free(f, at, v);
}

static PetscBool MPMWallApply_moving(MPM_WALL_ARGUMENTS)
{
  for (PetscInt d = 0; d < at->dim; d++) v[d] = f->velocity[d];
  return PETSC_TRUE;
}

/* A smooth plane, whose face reaches the nodes behind it. Those beside it are left to step/pistons.c. */
static PetscBool MPMWallApply_piston(MPM_WALL_ARGUMENTS)
{
  v[at->axis] = f->velocity[at->axis];
  return PETSC_TRUE;
}

const char MPMFaceNames[6][MPM_NAME_LEN] = {
#define MPM_FACE(name) #name,
#include "physics/face.def"
};
const char *const MPMWallNames[] = {
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) #name,
#include "physics/wall.def"
};
const char *const MPMWallParameters[] = {
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) parameters,
#include "physics/wall.def"
};

const int MPMWallActions[] = {
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) acts,
#include "physics/wall.def"
};
#define NEEDS(acts, word, other) (!((acts)&MPM_WALL_##word) || ((acts)&MPM_WALL_##other))
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what)                                             \
  _Static_assert(!((acts)&MPM_WALL_OPEN) || (acts) == MPM_WALL_OPEN, #name ": where there is no wall nothing acts");   \
  _Static_assert(NEEDS(acts, TANGENT, NORMAL) && NEEDS(acts, PUSHES, NORMAL) && NEEDS(acts, BRAKES, PUSHES) &&         \
                     NEEDS(acts, MOVES, NORMAL),                                                                       \
                 #name ": it acts along its normal too, and brakes what it pushes");                                   \
  _Static_assert(!((acts)&MPM_WALL_NORMAL) || (((acts)&MPM_WALL_PUSHES) != 0) == (MPM_WALL_##before == MPM_WALL_free), \
                 #name ": free before a step where it pushes, and not where it holds");                                \
  _Static_assert(!((acts)&MPM_WALL_PUSHES) || MPM_WALL_##residual == MPM_WALL_free, #name ": xpic filters freely");    \
  _Static_assert(!((acts)&MPM_WALL_MOVES) || MPM_WALL_##residual != MPM_WALL_##name, #name ": residuals do not move");
#include "physics/wall.def"
#undef NEEDS

static PetscReal Least(const MPMFace *f, const MPMGrid *grid, PetscInt axis, const PetscInt ijk[])
{
  return f->least ? f->least[MPMFaceNode(grid, axis, ijk)] : 0;
}

/* Holds the velocity along the normal as a wall does that holds it, or pushes; others leave it. */
static PetscBool HoldNormal(MPM_WALL_ARGUMENTS)
{
  if (!MPMWallHas(f->type, MPM_WALL_NORMAL)) return PETSC_FALSE;
  if (MPMWallHas(f->type, MPM_WALL_PUSHES)) return MPMWallApply_separate(f, at, v);
  v[at->axis] = MPMWallHas(f->type, MPM_WALL_MOVES) ? f->velocity[at->axis] : 0;
  return PETSC_TRUE;
}

/* At an edge the walls of later axes may move a node along the normal of an earlier one, as a lid does that slides
   between two side walls: so after all of them the normals are held once more. */
PetscBool MPMWallsApply(const MPMFace (*faces)[2], const MPMGrid *grid, const PetscInt ijk[], PetscReal dt,
                        PetscReal v[])
{
  static PetscBool (*const apply[])(MPM_WALL_ARGUMENTS) = {
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) MPMWallApply_##name,
#include "physics/wall.def"
  };
  PetscBool constrained = PETSC_FALSE;

  for (int again = 0; again < (constrained ? 2 : 1); again++)
    for (PetscInt k = 0; k < 2 * grid->dim; k++) {
      const PetscInt d = k / 2, inside = MPMWallInside(grid, k, ijk);
      const MPMFace *f = &faces[d][k % 2];
      WallNode       at;

      if (inside > f->reach || f->type == MPM_WALL_free) continue;
      at = (WallNode){grid->dim, d, k % 2 ? -1 : 1, (PetscReal)inside * grid->h[d], grid->h[d], Least(f, grid, d, ijk),
                      dt};
      if (again ? HoldNormal(f, &at, v) : apply[f->type](f, &at, v)) constrained = PETSC_TRUE;
    }
  return constrained;
}

/* The walls that take the place of each wall for other velocities: columns of wall.def. */
static const MPMWall before[] = {
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) MPM_WALL_##before,
#include "physics/wall.def"
};
static const MPMWall gradient[] = {
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) MPM_WALL_##gradient,
#include "physics/wall.def"
};
static const MPMWall residual[] = {
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) MPM_WALL_##residual,
#include "physics/wall.def"
};

/* Returns whether another wall drives node ijk along axis d into the one that pushes there, which leaves it the inward
   velocity `least`. */
static PetscBool Driven(const MPMFace (*faces)[2], const MPMGrid *grid, const PetscInt ijk[], PetscInt d,
                        PetscReal inward, PetscReal least)
{
  for (PetscInt k = 0; k < 2 * grid->dim; k++) {
    const MPMFace *f = &faces[k / 2][k % 2];

    if (k / 2 == d || MPMWallInside(grid, k, ijk) > f->reach) continue;
    if (MPMWallHas(f->type, MPM_WALL_TANGENT) && MPMWallHas(f->type, MPM_WALL_MOVES) && inward * f->velocity[d] < least)
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* A node meets a wall that only pushes if it would come nearer to it than its matter is. The velocity with which the
   matter just arrives is left to it. The acceleration has all that is taken, and the friction, so that FLIP hands the
   stop on to the particles. */
PetscInt MPMWallsAdvance(const MPMFace (*faces)[2], const MPMGrid *grid, const PetscInt ijk[], PetscReal dt,
                         const PetscReal v[], PetscReal at[], PetscReal a[])
{
  const PetscInt dim = grid->dim;
  PetscReal      trial[3], press[3] = {0};
  PetscInt       met = 0;

  for (PetscInt d = 0; d < dim; d++) {
    const PetscInt side = MPMWallInside(grid, 2 * d, ijk) <= 0 ? 0 : 1;
    const MPMFace *f    = &faces[d][side];
    WallNode       node = {.dim = dim, .axis = d, .inward = side ? -1 : 1};

    trial[d] = at[d];
    if ((MPMWallInside(grid, 2 * d, ijk) > 0 && MPMWallInside(grid, 2 * d + 1, ijk) > 0) ||
        !MPMWallHas(f->type, MPM_WALL_PUSHES))
      continue;
    node.least = Least(f, grid, d, ijk);
    if (Driven(faces, grid, ijk, d, node.inward, node.least)) met |= (PetscInt)1 << d;
    if (!MPMWallApply_separate(f, &node, at)) continue;
    press[d] = PetscAbsReal(at[d] - trial[d]);
    met |= (PetscInt)1 << d;
  }
  /* After all of them, so that friction at an edge takes nothing that another stops. */
  for (PetscInt d = 0; d < dim; d++) {
    const MPMFace *f = &faces[d][MPMWallInside(grid, 2 * d, ijk) <= 0 ? 0 : 1];

    if ((met & (PetscInt)1 << d) && MPMWallHas(f->type, MPM_WALL_BRAKES)) Brake(dim, d, f->mu * press[d], at);
  }
  (void)MPMWallsApply(faces, grid, ijk, dt, at);
  for (PetscInt d = 0; d < dim; d++)
    if (at[d] != trial[d]) a[d] = (at[d] - v[d]) / dt;
  return met;
}

PetscBool MPMWallWaits(MPMWall type)
{
  return MPMWallHas(type, MPM_WALL_PUSHES) || type == MPM_WALL_piston;
}

/* The nodes beside a plane are those of a stencil there; of gimp, those of a domain that begins at it. */
void MPMWallsReachTo(MPMWalls *w, const MPMGrid *grid, MPMBasis basis)
{
  const MPMBasis hats = basis == MPM_BASIS_gimp ? MPM_BASIS_linear : basis;
  const PetscInt n    = MPMBasisNodes(hats);

  for (PetscInt k = 0; k < 6; k++) {
    const PetscInt  d = k / 2, s = k % 2;
    const PetscReal cells = (PetscReal)grid->cells[d], at = w->place[k] / grid->h[d];
    MPMFace *const  faces[] = {&w->given[d][s], &w->before[d][s], &w->again[d][s], &w->gradient[d][s],
                               &w->residual[d][s]};
    PetscReal       xi      = PetscClipInterval(s ? cells - at : at, 0, cells);
    PetscInt        first;

    if (w->given[d][s].type != MPM_WALL_piston) continue;
    first = MPMBasisBase(hats, &xi, 0, grid->cells[d], PETSC_FALSE, grid->wall_basis[d]);
    for (size_t f = 0; f < sizeof faces / sizeof faces[0]; f++) {
      faces[f]->first  = first;
      faces[f]->beside = n;
      faces[f]->reach  = (s ? grid->cells[d] - (first + n - 1) : first) - 1;
    }
  }
}

void MPMWallsMove(MPMWalls *w)
{
  for (PetscInt k = 0; k < 6; k++) {
    const PetscInt d = k / 2, s = k % 2;

    for (PetscInt e = 0; e < 3 && w->changes[k]; e++) {
      w->before[d][s].velocity[e] = w->given[d][s].velocity[e];
      w->given[d][s].velocity[e] = w->again[d][s].velocity[e] = w->gradient[d][s].velocity[e] = w->velocity[k][e];
    }
  }
}

/* Sets before, again, gradient and residual from `given` by the columns of wall.def. Not collective. */
void MPMWallsDerive(MPMWalls *w)
{
  for (PetscInt k = 0; k < 6; k++) {
    const MPMFace *f = &w->given[k / 2][k % 2];

    w->before[k / 2][k % 2] = w->again[k / 2][k % 2] = w->gradient[k / 2][k % 2] = w->residual[k / 2][k % 2] = *f;
    w->before[k / 2][k % 2].type = w->again[k / 2][k % 2].type = before[f->type];
    w->gradient[k / 2][k % 2].type                             = gradient[f->type];
    w->residual[k / 2][k % 2].type                             = residual[f->type];
  }
}
