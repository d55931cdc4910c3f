/* wall.h - conditions on the velocity of nodes at the faces of the grid: the rows of wall.def. The phases of nodes
   apply them. */
#ifndef MPM_WALL_H
#define MPM_WALL_H

#include "physics/grid.h"

typedef enum {
#define MPM_WALL(name, parameters, before, gradient, residual, what) MPM_WALL_##name,
#include "physics/wall.def"
#undef MPM_WALL
  MPM_NUM_WALLS
} MPMWall;

extern const char *const MPMWallNames[], *const MPMWallParameters[]; /* [MPMWall] name; options that it takes */

extern const char MPMFaceNames[6][MPM_NAME_LEN]; /* [2 axis + side] rows of face.def */

typedef struct {
  MPMWall   type;
  PetscReal mu, velocity[3]; /* coefficient of friction; velocity of a moving wall in m/s */
  PetscInt  reach;           /* layers of nodes inside the grid on which it acts too; 0: only on the face and beyond */
} MPMFace;

/* The walls of a grid, [axis][side]: as the options give them, and those that take their places for other velocities
   (wall.def), which MPMWallsDerive sets. */
typedef struct MPMWalls {
  MPMFace given[3][2], before[3][2], gradient[3][2], residual[3][2];
} MPMWalls;

void MPMWallsDerive(MPMWalls *);

/* Applies walls to the velocity v [dim] in m/s of node ijk [dim]; dt is that of the step in s, or 0 for velocities that
   no advance makes. Returns whether a wall constrained v. Not collective. */
PetscBool MPMWallsApply(const MPMFace (*faces)[2], const MPMGrid *, const PetscInt ijk[], PetscReal dt, PetscReal v[]);

/* Applies walls in the advance of a node. v [dim] is its velocity before, already held by the walls `before`. On entry
   at [dim] is v + dt a in m/s, and a [dim] the acceleration in m/s^2; on return the walls have changed both. Returns
   the axes (bits) along which the node met a wall that only pushes. Not collective. */
PetscInt MPMWallsAdvance(const MPMFace (*faces)[2], const MPMGrid *, const PetscInt ijk[], PetscReal dt,
                         const PetscReal v[], PetscReal at[], PetscReal a[]);

/* Returns whether a wall acts on node i of axis d; MPMWallsApply need not be called for other nodes. */
MPM_INLINE PetscBool MPMWallsReach(const MPMFace (*faces)[2], const MPMGrid *grid, PetscInt d, PetscInt i)
{
  return i <= faces[d][0].reach || i >= grid->cells[d] - faces[d][1].reach ? PETSC_TRUE : PETSC_FALSE;
}

#endif
