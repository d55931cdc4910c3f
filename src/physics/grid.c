/* grid.c - see grid.h. */
#include "physics/grid.h"

const char *const MPMBasisNames[] = {
#define MPM_BASIS(name, nodes, layers, inertia, what) #name,
#include "physics/basis.def"
#undef MPM_BASIS
};

/* Layers and stored nodes of each axis, once cells, walls and basis are known. */
void MPMGridSetNodes(MPMGrid *grid, MPMBasis basis)
{
  for (PetscInt d = 0; d < 3; d++) {
    grid->layers[d] = d < grid->dim && !grid->periodic[d] ? MPMBasisLayers(basis) : 0;
    grid->nodes[d] = d >= grid->dim ? 1 : grid->periodic[d] ? grid->cells[d] : grid->cells[d] + 1 + 2 * grid->layers[d];
  }
}

/* With the layers beyond walls, and the ghost nodes across periodic faces. No process has more. A real number, which
   does not overflow. */
PetscReal MPMGridNodes(const MPMGrid *grid, MPMBasis basis)
{
  PetscReal nodes = 1;

  for (PetscInt d = 0; d < grid->dim; d++)
    nodes *= (PetscReal)grid->nodes[d] + (grid->periodic[d] ? 2 * (MPMBasisNodes(basis) - 1) : 0);
  return nodes;
}

PetscReal MPMGridSmallestH(const MPMGrid *grid)
{
  PetscReal h = grid->h[0];

  for (PetscInt d = 1; d < grid->dim; d++) h = PetscMin(h, grid->h[d]);
  return h;
}
