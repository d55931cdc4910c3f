/* unit_neighbours.c - numbers of particles as places of the lattice, and back: for random shapes with holes, in every
   dimension, all numbers have the places that the lattice gives them, and places outside of a body have none. */
#include "scene/neighbours.h"
#include "unit.h"

#define ROUNDS 40

/* Makes a random body with a hole in it. */
static void MakeBody(int dim, MPMBody *b, MPMRegion *hole, MPMRegion **others)
{
  const MPMRegionType types[] = {MPM_REGION_box, MPM_REGION_sphere, MPM_REGION_annulus};

  memset(b, 0, sizeof *b);
  memset(hole, 0, sizeof *hole);
  b->region.type         = dim == 1 ? MPM_REGION_box : types[UnitInt(3)];
  b->region.radius       = UnitReal(0.2, 0.5);
  b->region.inner_radius = 0.5 * b->region.radius;
  hole->type             = dim == 1 ? MPM_REGION_box : MPM_REGION_sphere;
  hole->radius           = UnitReal(0.05, 0.2);
  for (int d = 0; d < dim; d++) {
    b->region.center[d] = UnitReal(-0.5, 0.5);
    b->region.lower[d]  = b->region.center[d] - UnitReal(0.1, 0.4);
    b->region.upper[d]  = b->region.center[d] + UnitReal(0.1, 0.4);
    hole->center[d]     = b->region.center[d] + UnitReal(-0.3, 0.3);
    hole->lower[d]      = hole->center[d] - 0.1;
    hole->upper[d]      = hole->center[d] + 0.1;
    b->b[d]             = UnitReal(0.03, 0.08);
    b->offset[d]        = UnitReal(-0.1, 0.1);
  }
  b->first  = UnitInt(1000);
  others[0] = hole;
  if (UnitInt(2)) {
    b->region.others = others;
    b->region.ncut   = 1;
  }
}

static PetscErrorCode Round(int dim)
{
  MPMRegion     hole;
  MPMRegion    *others[1];
  MPMBody       b;
  MPMScene      scene;
  MPMCore      *core;
  MPMLattice    w;
  MPMNeighbours nb;
  PetscInt64    id;

  PetscFunctionBeginUser;
  MakeBody(dim, &b, &hole, others);
  memset(&scene, 0, sizeof scene);
  PetscCall(PetscCalloc1(1, &core));
  core->comm     = PETSC_COMM_WORLD;
  core->grid.dim = dim;
  w              = MPMLatticeBegin(&b, dim);
  scene.rows     = w.end;
  while (MPMLatticeNext(&w)) continue;
  b.n = w.id - b.first;
  UnitContext("%d-D, %s with %ld particles", dim, MPMRegionNames[b.region.type], (long)b.n);
  if (b.n) {
    PetscCall(MPMNeighboursCreate(&scene, core, &b, &nb));
    w  = MPMLatticeBegin(&b, dim);
    id = b.first;
    while (MPMLatticeNext(&w))
      for (PetscInt64 k = 0; k < w.n; k++, id++) {
        PetscInt64 at[3] = {w.ijk[0], w.ijk[1], w.ijk[2]}, ijk[3] = {0};

        at[dim - 1] = w.ijk[dim - 1] + k;
        MPMNeighboursPlace(&nb, id, ijk);
        for (int d = 0; d < dim; d++) CHECK_EQ(ijk[d], at[d]);
        CHECK_EQ(MPMNeighboursId(&nb, at), id);
        for (int d = 0; d < dim; d++) {
          PetscReal  x[3];
          PetscInt64 beside[3] = {at[0], at[1], at[2]};

          beside[d] += UnitInt(2) ? 1 : -1;
          for (int e = 0; e < dim; e++) x[e] = ((PetscReal)beside[e] + 0.5) * b.b[e] + b.offset[e];
          CHECK_EQ(MPMNeighboursId(&nb, beside) >= 0, MPMRegionInside(&b.region, dim, x) == PETSC_TRUE);
        }
      }
    CHECK_EQ(id, b.first + b.n);
    PetscCall(MPMNeighboursDestroy(&nb));
  }
  PetscCall(PetscFree(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  for (int dim = 1; dim <= 3; dim++)
    for (int round = 0; round < ROUNDS; round++) PetscCall(Round(dim));
  PetscCall(PetscFinalize());
  return UnitEnd();
}
