/* wall.c - velocity conditions at the faces of the grid, step 2 and 5 of docs/theory.md. A condition acts on the nodes
   at or beyond its face. */
#include "mpm.h"

static PetscBool MPMWallApply_free(PetscInt dim, PetscInt axis, PetscReal v[])
{
  (void)dim;
  (void)axis;
  (void)v;
  return PETSC_FALSE;
}

static PetscBool MPMWallApply_fixed(PetscInt dim, PetscInt axis, PetscReal v[])
{
  (void)axis;
  for (PetscInt d = 0; d < dim; d++) v[d] = 0;
  return PETSC_TRUE;
}

static PetscBool MPMWallApply_slip(PetscInt dim, PetscInt axis, PetscReal v[])
{
  (void)dim;
  v[axis] = 0;
  return PETSC_TRUE;
}

/* A periodic face is no wall: its nodes are those of the opposite face. */
static PetscBool MPMWallApply_periodic(PetscInt dim, PetscInt axis, PetscReal v[])
{
  return MPMWallApply_free(dim, axis, v);
}

PetscBool MPMWallsApply(MPMWall (*walls)[2], PetscInt dim, const PetscInt ijk[], const PetscInt cells[], PetscReal v[])
{
  static PetscBool (*const apply[])(PetscInt, PetscInt, PetscReal[]) = {
#define MPM_WALL(name, what) MPMWallApply_##name,
#include "wall.def"
#undef MPM_WALL
  };
  PetscBool constrained = PETSC_FALSE;

  for (PetscInt d = 0; d < dim; d++) {
    if (ijk[d] <= 0 && apply[walls[d][0]](dim, d, v)) constrained = PETSC_TRUE;
    if (ijk[d] >= cells[d] && apply[walls[d][1]](dim, d, v)) constrained = PETSC_TRUE;
  }
  return constrained;
}
