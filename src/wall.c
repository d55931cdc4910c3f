/* wall.c - velocity conditions at the faces of the grid, step 2 and 5 of docs/theory.md. A condition acts on the nodes
   at or beyond its face: on v [dim] of such a node, of face `f`, whose normal is `axis`; inward is +1 or -1, the sign
   of a velocity away from the wall. It returns whether it held the velocity. */
#include "mpm.h"

#define MPM_WALL_ARGUMENTS const MPMFace *f, PetscInt dim, PetscInt axis, PetscReal inward, PetscReal v[]

static PetscBool MPMWallApply_free(MPM_WALL_ARGUMENTS)
{
  (void)f;
  (void)dim;
  (void)axis;
  (void)inward;
  (void)v;
  return PETSC_FALSE;
}

static PetscBool MPMWallApply_fixed(MPM_WALL_ARGUMENTS)
{
  (void)f;
  (void)axis;
  (void)inward;
  for (PetscInt d = 0; d < dim; d++) v[d] = 0;
  return PETSC_TRUE;
}

static PetscBool MPMWallApply_slip(MPM_WALL_ARGUMENTS)
{
  (void)f;
  (void)dim;
  (void)inward;
  v[axis] = 0;
  return PETSC_TRUE;
}

static PetscBool MPMWallApply_separate(MPM_WALL_ARGUMENTS)
{
  (void)f;
  (void)dim;
  if (inward * v[axis] >= 0) return PETSC_FALSE;
  v[axis] = 0;
  return PETSC_TRUE;
}

/* The impulse that stops the normal velocity, times mu, is the most that the sliding can lose (Coulomb). */
static PetscBool MPMWallApply_friction(MPM_WALL_ARGUMENTS)
{
  const PetscReal lost  = -inward * v[axis];
  PetscReal       slide = 0;

  if (!(lost > 0)) return PETSC_FALSE;
  v[axis] = 0;
  for (PetscInt d = 0; d < dim; d++) slide += v[d] * v[d];
  slide = PetscSqrtReal(slide);
  for (PetscInt d = 0; d < dim; d++) v[d] = slide > f->mu * lost ? v[d] * (1 - f->mu * lost / slide) : 0;
  return PETSC_TRUE;
}

/* A periodic face is no wall: its nodes are those of the opposite face. */
static PetscBool MPMWallApply_periodic(MPM_WALL_ARGUMENTS)
{
  return MPMWallApply_free(f, dim, axis, inward, v);
}

static PetscBool MPMWallApply_moving(MPM_WALL_ARGUMENTS)
{
  (void)axis;
  (void)inward;
  for (PetscInt d = 0; d < dim; d++) v[d] = f->velocity[d];
  return PETSC_TRUE;
}

PetscBool MPMWallsApply(const MPMFace (*faces)[2], PetscInt dim, const PetscInt ijk[], const PetscInt cells[],
                        PetscReal v[])
{
  static PetscBool (*const apply[])(MPM_WALL_ARGUMENTS) = {
#define MPM_WALL(name, parameters, what) MPMWallApply_##name,
#include "wall.def"
#undef MPM_WALL
  };
  PetscBool constrained = PETSC_FALSE;

  for (PetscInt d = 0; d < dim; d++) {
    if (ijk[d] <= 0 && apply[faces[d][0].type](&faces[d][0], dim, d, 1, v)) constrained = PETSC_TRUE;
    if (ijk[d] >= cells[d] && apply[faces[d][1].type](&faces[d][1], dim, d, -1, v)) constrained = PETSC_TRUE;
  }
  return constrained;
}

/* The walls for what xpic filters from velocities: it is 0 where they are held, whatever they are held at; where that
   depends on their sign there is no condition. */
void MPMWallsOfResidual(const MPMFace (*faces)[2], MPMFace (*residual)[2])
{
  for (PetscInt k = 0; k < 6; k++) {
    const MPMWall type = faces[k / 2][k % 2].type;

    residual[k / 2][k % 2]      = faces[k / 2][k % 2];
    residual[k / 2][k % 2].type = type == MPM_WALL_moving                                  ? MPM_WALL_fixed
                                  : type == MPM_WALL_separate || type == MPM_WALL_friction ? MPM_WALL_free
                                                                                           : type;
  }
}
