/* grid.c - the numbers of layers and nodes of the background grid; grid.h describes them. */
#include "physics/grid.h"

const char *const MPMBasisNames[] = {
#define MPM_BASIS(name, nodes, layers, inertia, what) #name,
#include "physics/basis.def"
};

#define TILES 4 /* nodes: places begin with whole tiles and boxes of F-bar, so that each body has the same ones alone */

/* Sets layers and stored nodes of each axis from cells, periodic axes, places and basis. */
void MPMGridSetNodes(MPMGrid *grid, MPMBasis basis)
{
  for (PetscInt d = 0; d < 3; d++) {
    grid->layers[d] = d < grid->dim && !grid->periodic[d] ? MPMBasisLayers(basis) : 0;
    grid->nodes[d] = d >= grid->dim ? 1 : grid->periodic[d] ? grid->cells[d] : grid->cells[d] + 1 + 2 * grid->layers[d];
  }
  if (grid->copies < 2) return;
  grid->stride = (grid->nodes[grid->stack] + 2 * MPM_GRID_APART + TILES - 1) / TILES * TILES;
  if (grid->places < 2) return;
  grid->nodes[grid->stack] = grid->stride;
  for (PetscInt p = 1; p < grid->places; p++) {
    const PetscInt n = grid->high[p] - grid->low[p] + 2 * MPM_GRID_APART;

    grid->first[p] = grid->nodes[grid->stack] - grid->low[p];
    grid->nodes[grid->stack] += grid->high[p] ? (n + TILES - 1) / TILES * TILES : grid->stride;
  }
}

/* Returns the nodes in the arrays of a process that has the whole grid: with the layers beyond walls, and with ghost
   nodes across periodic faces. No process has more. The number is real, since an integer might overflow. */
PetscReal MPMGridNodes(const MPMGrid *grid, MPMBasis basis)
{
  PetscReal nodes = 1;

  for (PetscInt d = 0; d < grid->dim; d++)
    nodes *= (PetscReal)grid->nodes[d] + (grid->periodic[d] ? 2 * (MPMBasisNodes(basis) - 1) : 0);
  return nodes;
}

/* Returns the smallest cell size of the axes in m. */
PetscReal MPMGridSmallestH(const MPMGrid *grid)
{
  PetscReal h = grid->h[0];

  for (PetscInt d = 1; d < grid->dim; d++) h = PetscMin(h, grid->h[d]);
  return h;
}
