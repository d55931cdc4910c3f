/* patch.c - the box of a patch on the DMDA, and the memory of its nodes. */
#include "base/pages.h"
#include "particles/box.h"

/* Sets the boxes of a patch from the DMDA: its own nodes are those of this process, and its arrays also have the ghost
   nodes. Allocates `lines` lines of the node sums, their values and the spans. Not collective. */
PetscErrorCode MPMPatchSetBox(MPMPatch *patch, const MPMGrid *grid, MPMBasis basis, DM da, PetscInt lines)
{
  PetscInt   nodes, numbers;
  size_t     sums;
  PetscReal *value;

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
  nodes   = patch->n[0] * patch->n[1] * patch->n[2];
  sums    = (size_t)lines * (size_t)nodes * sizeof(MPMNode);
  numbers = MPMNodeNumbers(grid->dim, lines) - MPM_MOTION_NC(grid->dim);
  PetscCall(MPMPagesCalloc((size_t)numbers * (size_t)nodes * sizeof(PetscReal) +
                               (size_t)(patch->n[1] * patch->n[2]) * sizeof *patch->span + MPM_LINE,
                           &patch->memory));
  patch->tiles.lines = lines;
  patch->node        = (MPMNode *)MPMAlign(patch->memory);
  value              = (PetscReal *)((char *)patch->node + sums);
#define MPM_NODE_VALUE(name, nc, unit, meaning)                                                                        \
  patch->value.name = value;                                                                                           \
  value += nodes * MPMNodeComponents_##name(grid->dim);
#include "kernels/node.def"
  patch->span = (MPMSpan *)value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the tiles and the node sums of a patch. Not collective. */
PetscErrorCode MPMPatchDestroy(MPMPatch *patch)
{
  PetscFunctionBeginUser;
  PetscCall(MPMTilesDestroy(patch));
  PetscCall(PetscFree(patch->memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the nodes of the patch's arrays. */
PetscInt MPMPatchNodes(const MPMPatch *patch)
{
  return patch->n[0] * patch->n[1] * patch->n[2];
}

/* Returns where a node of the patch's arrays lies: 0 if it is an own one, -1 if it is below these on some axis, else
   1. */
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

/* Makes phases visit all nodes of the patch's arrays. */
void MPMPatchVisitAll(MPMPatch *patch)
{
  for (PetscInt r = 0; r < patch->n[1] * patch->n[2]; r++) {
    patch->span[r].first = 0;
    patch->span[r].last  = patch->n[0];
  }
}

/* Returns the number of nodes that phases visit, which are those that particles touch. */
PetscReal MPMPatchTouchedNodes(const MPMPatch *patch)
{
  PetscReal nodes = 0;

  for (PetscInt r = 0; patch->span && r < patch->n[1] * patch->n[2]; r++)
    nodes += (PetscReal)PetscMax(0, patch->span[r].last - patch->span[r].first);
  return nodes;
}
