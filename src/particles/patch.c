/* patch.c - the box of a patch, and the sums of its nodes. */
#include "particles/box.h"

/* Sets the box from the DMDA: own = what this process owns, box = with the ghost nodes. Allocates the node sums. Not
 * collective. */
PetscErrorCode MPMPatchSetBox(MPMPatch *patch, const MPMGrid *grid, MPMBasis basis, DM da)
{
  PetscInt nodes;
  size_t   sums;

  PetscFunctionBeginUser;
  patch->grid  = grid;
  patch->basis = basis;
  PetscCall(DMDAGetCorners(da, &patch->own_lo[0], &patch->own_lo[1], &patch->own_lo[2], &patch->own_n[0],
                           &patch->own_n[1], &patch->own_n[2]));
  PetscCall(
      DMDAGetGhostCorners(da, &patch->lo[0], &patch->lo[1], &patch->lo[2], &patch->n[0], &patch->n[1], &patch->n[2]));
  for (PetscInt d = 0; d < grid->dim; d++) {
    patch->own_lo[d] -= grid->layers[d];
    patch->lo[d] -= grid->layers[d];
  }
  nodes = patch->n[0] * patch->n[1] * patch->n[2];
  sums  = (size_t)nodes * sizeof(MPMNode);
  PetscCall(PetscCalloc1(sums + (size_t)(patch->n[1] * patch->n[2]) * sizeof *patch->span + MPM_LINE,
                         (char **)&patch->memory));
  patch->node = (MPMNode *)MPMAlign(patch->memory);
  patch->span = (MPMSpan *)((char *)patch->node + sums);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPatchDestroy(MPMPatch *patch)
{
  PetscFunctionBeginUser;
  PetscCall(MPMTilesDestroy(patch));
  PetscCall(PetscFree(patch->memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nodes of its arrays. */
PetscInt MPMPatchNodes(const MPMPatch *patch)
{
  return patch->n[0] * patch->n[1] * patch->n[2];
}

/* Where a node of its arrays lies: 0 among its own nodes, -1 below them on some axis, else 1, above them. */
int MPMPatchSide(const MPMPatch *patch, PetscInt node)
{
  const PetscInt ijk[3] = {node % patch->n[0], node / patch->n[0] % patch->n[1], node / (patch->n[0] * patch->n[1])};
  int            side   = 0;

  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt at = ijk[d] + patch->lo[d] - patch->own_lo[d];

    if (at < 0) return -1;
    if (at >= patch->own_n[d]) side = 1;
  }
  return side;
}

/* Lets all nodes be visited. */
void MPMPatchVisitAll(MPMPatch *patch)
{
  for (PetscInt r = 0; r < patch->n[1] * patch->n[2]; r++) {
    patch->span[r].first = 0;
    patch->span[r].last  = patch->n[0];
  }
}

/* Nodes that particles touch: those that phases visit. */
PetscReal MPMPatchTouchedNodes(const MPMPatch *patch)
{
  PetscReal nodes = 0;

  for (PetscInt r = 0; patch->span && r < patch->n[1] * patch->n[2]; r++)
    nodes += (PetscReal)PetscMax(0, patch->span[r].last - patch->span[r].first);
  return nodes;
}
