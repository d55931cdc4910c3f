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

/* Takes up to `most` off the length of v [dim]: never more than there is. */
static void Brake(PetscInt dim, PetscReal most, PetscReal v[])
{
  PetscReal slide = 0;

  for (PetscInt d = 0; d < dim; d++) slide += v[d] * v[d];
  slide = PetscSqrtReal(slide);
  for (PetscInt d = 0; d < dim; d++) v[d] = slide > most ? v[d] * (1 - most / slide) : 0;
}

/* The impulse that stops the normal velocity, times mu, is the most that the sliding can lose (Coulomb). */
static PetscBool MPMWallApply_friction(MPM_WALL_ARGUMENTS)
{
  const PetscReal lost = -inward * v[axis];

  if (!(lost > 0)) return PETSC_FALSE;
  v[axis] = 0;
  Brake(dim, f->mu * lost, v);
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

/* Does the wall only push, so that matter may leave it? Then it is met or not by what a node would do without it. */
static PetscBool OnlyPushes(MPMWall type)
{
  return type == MPM_WALL_separate || type == MPM_WALL_friction ? PETSC_TRUE : PETSC_FALSE;
}

/* Walls in the advance of a node (at or beyond a face): v [dim] is its velocity before, held by the walls that hold; at
   comes in as v + dt a, the velocity without walls that only push, and leaves with them. A node that meets such a wall
   moves as at a slip wall, with no velocity and no acceleration along the normal (the particles lose their momentum by
   their stress, so none is lost for good), and feels friction in a. Returns the axes (bits) along which it met one. */
PetscInt MPMWallsAdvance(const MPMFace (*faces)[2], PetscInt dim, const PetscInt ijk[], const PetscInt cells[],
                         PetscReal dt, const PetscReal v[], PetscReal at[], PetscReal a[])
{
  PetscReal trial[3];
  PetscInt  met = 0;

  for (PetscInt d = 0; d < dim; d++) {
    trial[d] = at[d];
    if ((ijk[d] <= 0 && OnlyPushes(faces[d][0].type) && at[d] < 0) ||
        (ijk[d] >= cells[d] && OnlyPushes(faces[d][1].type) && at[d] > 0))
      met |= (PetscInt)1 << d;
  }
  for (PetscInt d = 0; d < dim; d++)
    if (met & (PetscInt)1 << d) at[d] = 0;
  for (PetscInt d = 0; d < dim; d++) { /* friction follows the forces that press, not the velocity at a first touch */
    const MPMFace  *f     = &faces[d][ijk[d] >= cells[d]];
    const PetscReal press = ijk[d] <= 0 ? -a[d] : a[d];

    if ((met & (PetscInt)1 << d) && f->type == MPM_WALL_friction && press > 0) Brake(dim, f->mu * dt * press, at);
  }
  (void)MPMWallsApply(faces, dim, ijk, cells, at);
  for (PetscInt d = 0; d < dim; d++)
    if (met & (PetscInt)1 << d)
      at[d] = a[d] = 0;
    else if (at[d] != trial[d])
      a[d] = (at[d] - v[d]) / dt;
  return met;
}

/* The same walls for other velocities of nodes. Of those before an advance: walls that only push wait for its end. Of
   those that make velocity gradients: friction is an impulse of the advance alone. Of what xpic filters: it is 0 where
   velocities are held, whatever they are held at; where that depends on their sign there is no condition. */
void MPMWallsDerive(const MPMFace (*faces)[2], MPMFace (*before)[2], MPMFace (*gradient)[2], MPMFace (*residual)[2])
{
  for (PetscInt k = 0; k < 6; k++) {
    const PetscInt d = k / 2, side = k % 2;
    const MPMWall  type = faces[d][side].type;

    before[d][side] = gradient[d][side] = residual[d][side] = faces[d][side];
    if (OnlyPushes(type)) before[d][side].type = residual[d][side].type = MPM_WALL_free;
    if (type == MPM_WALL_friction) gradient[d][side].type = MPM_WALL_separate;
    if (type == MPM_WALL_moving) residual[d][side].type = MPM_WALL_fixed;
  }
}
