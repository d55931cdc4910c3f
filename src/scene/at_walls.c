/* at_walls.c - particles of a lattice that start beside walls.

   With splines the node next to a wall has no weight at the wall but a slope: the pressure of a particle that lies on
   the wall pushes a node to which it gives no mass. Where matter flows, a particle may be left alone there, so it
   starts a part of its spacing inside. */
#include "scene/at_walls.h"

#define ON_WALL  1e-3 /* of the spacing: what is nearer to a wall starts on it, and is moved inside by OFF_WALL */
#define OFF_WALL 0.1

/* Returns whether a body flows, so that none of its particles may start on a wall. */
static PetscBool Flows(const MPMScene *scene, const MPMCore *core, const MPMBody *b)
{
  const PetscInt traits = scene->materials[b->material].type->traits;

  return MPMBasisIsSpline(core->basis) && traits & (MPM_PLASTIC | MPM_FLUID) ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns how far x, m, is inside a face of axis d, over the spacing of the body. */
static PetscReal Inside(const MPMGrid *grid, const MPMBody *b, PetscInt d, int side, PetscReal x)
{
  return (side ? grid->upper[d] - x : x - grid->lower[d]) / b->b[d];
}

/* Returns how far the first place of the body's lattice in the grid is inside a face of axis d, over the spacing. */
static PetscReal First(const MPMGrid *grid, const MPMBody *b, PetscInt d, int side)
{
  const PetscReal places = ((side ? grid->upper[d] : grid->lower[d]) - b->offset[d]) / b->b[d] - 0.5;

  return side ? places - PetscFloorReal(places) : PetscCeilReal(places) - places;
}

void MPMAtWallsMove(const MPMScene *scene, const MPMCore *core, const MPMBody *b, PetscReal x[])
{
  const MPMGrid *grid = &core->grid;

  if (!Flows(scene, core, b)) return;
  for (PetscInt d = 0; d < grid->dim; d++)
    for (int side = 0; side < 2; side++) {
      if (!MPMWallHas(scene->walls.given[d][side].type, MPM_WALL_NORMAL)) continue;
      if (PetscAbsReal(Inside(grid, b, d, side, x[d])) > ON_WALL) continue;
      x[d] = side ? grid->upper[d] - OFF_WALL * b->b[d] : grid->lower[d] + OFF_WALL * b->b[d];
    }
}

PetscBool MPMAtWallsLie(const MPMScene *scene, const MPMCore *core, const MPMBody *b, PetscInt d)
{
  PetscReal lower[3], upper[3];

  if (!Flows(scene, core, b)) return PETSC_FALSE;
  MPMRegionBounds(&b->region, core->grid.dim, lower, upper);
  for (int side = 0; side < 2; side++) {
    const PetscReal in = First(&core->grid, b, d, side), from = side ? upper[d] : lower[d];

    if (!MPMWallHas(scene->walls.given[d][side].type, MPM_WALL_NORMAL)) continue;
    if (Inside(&core->grid, b, d, side, from) > ON_WALL) continue;
    if (PetscMin(in, 1 - in) < ON_WALL) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}
