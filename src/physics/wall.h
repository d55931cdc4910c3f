/* wall.h - conditions on the velocity of nodes at the faces of the grid: the rows of wall.def. The phases of nodes
   apply them. */
#ifndef MPM_WALL_H
#define MPM_WALL_H

#include "physics/grid.h"

typedef enum {
#define MPM_WALL(name, parameters, acts, before, gradient, residual, what) MPM_WALL_##name,
#include "physics/wall.def"
  MPM_NUM_WALLS
} MPMWall;

extern const char *const MPMWallNames[], *const MPMWallParameters[]; /* [MPMWall] name; options that it takes */

/* What a wall does: bits of the column `acts`. The function returns whether a wall has one of them. */
enum {
  MPM_WALL_OPEN    = 1,
  MPM_WALL_NORMAL  = 2,
  MPM_WALL_TANGENT = 4,
  MPM_WALL_PUSHES  = 8,
  MPM_WALL_BRAKES  = 16,
  MPM_WALL_MOVES   = 32
};
extern const int     MPMWallActions[]; /* [MPMWall] */
MPM_INLINE PetscBool MPMWallHas(MPMWall type, int acts)
{
  return (MPMWallActions[type] & acts) != 0;
}

extern const char MPMFaceNames[6][MPM_NAME_LEN]; /* [2 axis + side] rows of face.def */

typedef struct {
  MPMWall   type;
  PetscReal mu, velocity[3]; /* coefficient of friction; velocity of a wall that moves in m/s */
  PetscReal distance;        /* of a piston: where it is at the start, m inside the face */
  PetscBool pulls;           /* of a piston: it holds bodies that it has touched, so that it pulls them */
  PetscInt  reach; /* layers of nodes inside the grid on which it acts too; 0: only on the face and beyond; of a
                                piston: those behind the ones beside its plane; below 0: none */
  PetscInt  first,
      beside; /* of a piston: the nodes beside its plane along the normal, the first in the grid, how many */
  /* Of a wall that only pushes, for each node of the face (MPMFaceNode): the least inward velocity, m/s, with which the
     matter over it does not pass the wall in this step; not above 0. NULL: 0, as of matter that is at the wall. */
  const PetscReal *least;
} MPMFace;

/* The walls of a grid, [axis][side]: as the options give them, and those that take their places for other velocities
   (wall.def), which MPMWallsDerive sets; `again` are those of `before` after the advance. The other arrays are by
   face, 2 axis + side. */
typedef struct MPMWalls {
  MPMFace   given[3][2], before[3][2], again[3][2], gradient[3][2], residual[3][2];
  PetscReal velocity[6][3]; /* of walls that `changes` marks: that of this step, m/s */
  PetscReal place[6];       /* of pistons: how far inside the face they are, m */
  PetscBool changes[6];     /* the velocity is a formula of time */
} MPMWalls;

/* Returns whether any of the walls does one of `acts`. */
MPM_INLINE PetscBool MPMWallsHave(const MPMWalls *walls, int acts)
{
  for (PetscInt face = 0; face < 6; face++)
    if (MPMWallHas(walls->given[face / 2][face % 2].type, acts)) return PETSC_TRUE;
  return PETSC_FALSE;
}

void MPMWallsDerive(MPMWalls *);

/* What changes with time, by the functions of scene/move_walls.c. MPMWallsMove gives the walls that `changes` marks
   their velocity of this step; that of the step before becomes the one from which the advance starts, so that nodes
   have the acceleration of their wall. MPMWallsReachTo sets which nodes are beside the planes of pistons, and which are
   behind them. Neither is collective. */
void MPMWallsMove(MPMWalls *);
void MPMWallsReachTo(MPMWalls *, const MPMGrid *, MPMBasis);

/* Applies walls to the velocity v [dim] in m/s of node ijk [dim]; dt is the time over which the advance
   accelerates, s, or 0 for velocities that no advance makes. Returns whether a wall constrained v. Not collective. */
PetscBool MPMWallsApply(const MPMFace (*faces)[2], const MPMGrid *, const PetscInt ijk[], PetscReal dt, PetscReal v[]);

/* Applies walls in the advance of a node. v [dim] is its velocity before, already held by the walls `before`. On entry
   at [dim] is v + dt a in m/s, and a [dim] the acceleration in m/s^2; on return the walls have changed both. Returns
   the axes (bits) along which the node met a wall that only pushes. Not collective. */
PetscInt MPMWallsAdvance(const MPMFace (*faces)[2], const MPMGrid *, const PetscInt ijk[], PetscReal dt,
                         const PetscReal v[], PetscReal at[], PetscReal a[]);

/* Returns whether the wall acts on arrival alone, as walls that push and pistons do. */
PetscBool MPMWallWaits(MPMWall);

/* Returns whether the wall of a face acts on the layer of nodes `inside` the grid by so many: at or beyond its face, or
   behind or beside its plane. */
MPM_INLINE PetscBool MPMWallActs(const MPMFace *f, PetscInt inside)
{
  return inside <= f->reach + f->beside;
}

/* Returns the number of the nodes of a face with normal `axis`, those of all places of copies, or the largest there can
   be of these; and which of them a node of a place that is at [dim] of the grid, or node ijk [dim], lies over: those
   beyond the edges of the face count to the edges. Across a periodic axis the last is the first one again. */
MPM_INLINE PetscInt MPMFaceNodes(const MPMGrid *grid, PetscInt axis, PetscBool most)
{
  PetscInt n = PetscMax(1, most ? grid->copies : grid->places);

  for (PetscInt d = 0; d < grid->dim; d++) n *= d == axis ? 1 : grid->cells[d] + !grid->periodic[d];
  return n;
}

MPM_INLINE PetscInt MPMFaceNodeOf(const MPMGrid *grid, PetscInt axis, PetscInt place, const PetscInt at[])
{
  PetscInt node = place;

  for (PetscInt d = grid->dim - 1; d >= 0; d--) {
    const PetscInt cells = grid->cells[d];

    if (d == axis) continue;
    node = grid->periodic[d] ? node * cells + (at[d] % cells + cells) % cells
                             : node * (cells + 1) + PetscClipInterval(at[d], 0, cells);
  }
  return node;
}

MPM_INLINE PetscInt MPMFaceNode(const MPMGrid *grid, PetscInt axis, const PetscInt ijk[])
{
  PetscInt at[3] = {0};

  for (PetscInt d = 0; d < grid->dim; d++) at[d] = MPMGridFold(grid, d, ijk[d]);
  return MPMFaceNodeOf(grid, axis, MPMGridPlace(grid, ijk[grid->stack]), at);
}

/* Sets where the wall of face k is along its normal, m, and the sign of a distance from it into the grid. */
MPM_INLINE void MPMWallPlane(const MPMWalls *w, const MPMGrid *grid, PetscInt k, PetscReal *plane, PetscReal *sign)
{
  *sign  = k % 2 ? -1 : 1;
  *plane = (k % 2 ? grid->upper[k / 2] : grid->lower[k / 2]) + *sign * w->place[k];
}

/* Returns by how many layers node ijk [dim] lies inside of face k = 2 axis + side; below 0: beyond it. */
MPM_INLINE PetscInt MPMWallInside(const MPMGrid *grid, PetscInt k, const PetscInt ijk[])
{
  const PetscInt i = MPMGridFold(grid, k / 2, ijk[k / 2]);

  return k % 2 ? grid->cells[k / 2] - i : i;
}

/* Returns whether a wall acts on node i of axis d; MPMWallsApply need not be called for other nodes. */
MPM_INLINE PetscBool MPMWallsReach(const MPMFace (*faces)[2], const MPMGrid *grid, PetscInt d, PetscInt i)
{
  const PetscInt at = MPMGridFold(grid, d, i);

  return at <= faces[d][0].reach || at >= grid->cells[d] - faces[d][1].reach;
}

#endif
