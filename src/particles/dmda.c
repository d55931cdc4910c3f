/* dmda.c - the background grid as PETSc sees it: a DMDA of nodes, in 1, 2 or 3 dimensions. */
#include "particles/box.h"

/* The DMDA of the grid's nodes, layers beyond the walls included, with the velocity record as its unknowns. DMDA's
   node 0 is node -layers of the grid. Collective on comm.
     stencil   [in]  layers of ghost nodes around a process's box
     parts     [in]  boxes on each axis, and widths[axis][part] in nodes; NULL: comm has one process */
PetscErrorCode MPMGridCreateDM(const MPMGrid *grid, MPI_Comm comm, PetscInt stencil, const PetscInt parts[3],
                               PetscInt *const widths[3], DM *da)
{
  const PetscInt  nc = MPM_MOTION_NC(grid->dim), one[3] = {1, 1, 1}, *p = parts ? parts : one;
  const PetscInt *lx = widths ? widths[0] : NULL, *ly = widths ? widths[1] : NULL, *lz = widths ? widths[2] : NULL;
  const PetscInt *n = grid->nodes;
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
