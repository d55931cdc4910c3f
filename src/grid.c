/* grid.c - the background grid as PETSc sees it: a DMDA of nodes, in 1, 2 or 3 dimensions. */
#include "mpm.h"

/* Layers and stored nodes of each axis, once cells, walls and basis are known. */
void MPMGridSetNodes(MPMGrid *grid, MPMBasis basis)
{
  for (PetscInt d = 0; d < 3; d++) {
    grid->layers[d] = d < grid->dim && !grid->periodic[d] ? MPMBasisLayers(basis) : 0;
    grid->nodes[d] = d >= grid->dim ? 1 : grid->periodic[d] ? grid->cells[d] : grid->cells[d] + 1 + 2 * grid->layers[d];
  }
}

/* Nodes in the arrays of a process that has the whole grid: with the layers beyond walls, and the ghost nodes across
   periodic faces. No process has more. A real number, which does not overflow. */
PetscReal MPMGridNodes(const MPMGrid *grid, MPMBasis basis)
{
  PetscReal nodes = 1;

  for (PetscInt d = 0; d < grid->dim; d++)
    nodes *= (PetscReal)grid->nodes[d] + (grid->periodic[d] ? 2 * (MPMBasisNodes(basis) - 1) : 0);
  return nodes;
}

/* The DMDA of the grid's nodes, layers beyond the walls included, with the velocity record as its unknowns. DMDA's
   node 0 is node -layers of the grid. Collective on comm.
     stencil   [in]  layers of ghost nodes around a process's box
     partition [in]  how to cut the grid; NULL: comm has one process                                                  */
PetscErrorCode MPMGridCreateDM(const MPMGrid *grid, MPI_Comm comm, PetscInt stencil, const MPMPartition *partition,
                               DM *da)
{
  const PetscInt  nc = MPM_VEL_NC(grid->dim), one[3] = {1, 1, 1}, *p = partition ? partition->p : one;
  const PetscInt *lx = partition ? partition->l[0] : NULL, *ly = partition ? partition->l[1] : NULL,
                 *lz = partition ? partition->l[2] : NULL;
  const PetscInt *n  = grid->nodes;
  DMBoundaryType  bc[3];

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) bc[d] = grid->periodic[d] ? DM_BOUNDARY_PERIODIC : DM_BOUNDARY_NONE;
  switch (grid->dim) {
  case 1:
    PetscCall(DMDACreate1d(comm, bc[0], n[0], nc, stencil, lx, da));
    break;
  case 2:
    PetscCall(DMDACreate2d(comm, bc[0], bc[1], DMDA_STENCIL_BOX, n[0], n[1], p[0], p[1], nc, stencil, lx, ly, da));
    break;
  default:
    PetscCall(DMDACreate3d(comm, bc[0], bc[1], bc[2], DMDA_STENCIL_BOX, n[0], n[1], n[2], p[0], p[1], p[2], nc, stencil,
                           lx, ly, lz, da));
  }
  PetscCall(DMSetUp(*da));
  PetscFunctionReturn(PETSC_SUCCESS);
}
