/* patch.c - a patch of cells: its box, and running a phase on it. Shared by every way to run the step. */
#include "cell.h"

/* Sets the box from the DMDA: own = what this process owns, box = with the halo. Allocates the node sums. Not
 * collective. */
PetscErrorCode MPMPatchSetBox(MPMPatch *patch, const MPMGrid *grid, MPMBasis basis, DM da)
{
  PetscInt nodes;

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
  PetscCall(PetscCalloc2(nodes * MPM_SUM_NC(grid->dim), &patch->sum, patch->n[1] * patch->n[2], &patch->row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPatchDestroy(MPMPatch *patch)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(patch->sum, patch->row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMPatchCells(const MPMPatch *patch)
{
  return patch->n[0] * patch->n[1] * patch->n[2];
}

/* Takes the places of the cells in the patch's order and marks the rows of nodes that points touch. */
void MPMPatchMarkRows(MPMPatch *patch, const PetscInt *start)
{
  const PetscInt ns = MPMBasisNodes(patch->basis);

  patch->start = start;
  for (PetscInt r = 0; r < patch->n[1] * patch->n[2]; r++) patch->row[r] = 0;
  for (PetscInt k = 0; k < patch->n[2]; k++)
    for (PetscInt j = 0; j < patch->n[1]; j++) {
      const PetscInt r = k * patch->n[1] + j;

      if (start[(r + 1) * patch->n[0]] == start[r * patch->n[0]]) continue;
      for (PetscInt kk = k; kk < PetscMin(k + ns, patch->n[2]); kk++)
        for (PetscInt jj = j; jj < PetscMin(j + ns, patch->n[1]); jj++) patch->row[kk * patch->n[1] + jj] = 1;
    }
}

/* Zeroes the sums that the parts will add to, in the rows that points touch. */
void MPMPatchZeroSums(MPMPatch *patch, PetscInt parts)
{
  const PetscInt dim = patch->grid->dim, nc = MPM_SUM_NC(dim);
  const PetscInt c0 = MPM_SUM_FIRST(dim, parts), c1 = MPM_SUM_LAST(dim, parts);

  for (PetscInt r = 0; r < patch->n[1] * patch->n[2]; r++) {
    PetscReal *sum = patch->sum + r * patch->n[0] * nc;

    if (patch->row[r])
      for (PetscInt i = 0; i < patch->n[0]; i++)
        for (PetscInt c = c0; c < c1; c++) sum[i * nc + c] = 0;
  }
}

/* Runs a phase on the patch, whose views hold the fields that the phase declares. Merges what it finds into status.
   Not collective.                                                                                                    */
PetscErrorCode MPMPatchRun(MPM mpm, MPMPatch *patch, const MPMPhase *phase, MPMStatus *status)
{
  PetscFunctionBeginUser;
  if (phase->kind == MPM_NODES) {
    for (PetscInt k = 0; k < patch->own_n[2]; k++)
      for (PetscInt j = 0; j < patch->own_n[1]; j++) {
        const PetscInt row = (k + patch->own_lo[2] - patch->lo[2]) * patch->n[1] + j + patch->own_lo[1] - patch->lo[1];
        if (patch->row[row]) phase->nodes(&mpm->params, patch, row);
      }
  } else {
    const MPMTransfer run = MPMTransferFind(patch->grid->dim, patch->basis, phase->parts);

    PetscCheck(run, PETSC_COMM_SELF, PETSC_ERR_PLIB, "phase %s has no kernel for parts %" PetscInt_FMT, phase->name,
               phase->parts);
    if (phase->kind == MPM_POINTS_TO_NODES) MPMPatchZeroSums(patch, phase->parts);
    run(&mpm->params, patch, phase->parts, status);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
