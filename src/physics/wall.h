/* wall.h - conditions on the velocity of nodes at the faces of the grid: rows of wall.def. */
#ifndef MPM_WALL_H
#define MPM_WALL_H

#include "physics/grid.h"

typedef enum {
#define MPM_WALL(name, parameters, before, gradient, residual, what) MPM_WALL_##name,
#include "physics/wall.def"
#undef MPM_WALL
  MPM_NUM_WALLS
} MPMWall;

extern const char *const MPMWallNames[], *const MPMWallParameters[]; /* by MPMWall: name, options that it takes */

typedef struct {
  MPMWall   type;
  PetscReal mu, velocity[3]; /* of friction: coefficient; of moving: velocity of the wall in m/s */
  PetscInt  reach;           /* layers of nodes inside the grid on which it acts too; 0: on the face and beyond alone */
} MPMFace;

/* The walls of a grid as the option table gives them, and those for other velocities that MPMWallsDerive makes of them
   (wall.def says which). [axis][side] */
typedef struct MPMWalls {
  MPMFace given[3][2], before[3][2], gradient[3][2], residual[3][2];
} MPMWalls;

void MPMWallsDerive(MPMWalls *);

/* Applies walls to the velocity v [dim] in m/s of node ijk [dim], which they reach; dt in s is that of the step, or 0
   for velocities that no advance makes. Returns whether v was constrained. Not collective. */
PetscBool MPMWallsApply(const MPMFace (*faces)[2], const MPMGrid *, const PetscInt ijk[], PetscReal dt, PetscReal v[]);

/* Walls in the advance of a node: v [dim] is its velocity before, held by the walls `before`; at comes in as v + dt a,
   the velocity without walls that only push, and leaves with them, as does a in m/s^2. Returns the axes (bits) along
   which the node met a wall that only pushes. Not collective. */
PetscInt MPMWallsAdvance(const MPMFace (*faces)[2], const MPMGrid *, const PetscInt ijk[], PetscReal dt,
                         const PetscReal v[], PetscReal at[], PetscReal a[]);

/* Does a wall reach node i of axis d? The others need not be asked about. */
MPM_INLINE PetscBool MPMWallsReach(const MPMFace (*faces)[2], const MPMGrid *grid, PetscInt d, PetscInt i)
{
  return i <= faces[d][0].reach || i >= grid->cells[d] - faces[d][1].reach ? PETSC_TRUE : PETSC_FALSE;
}

#endif
