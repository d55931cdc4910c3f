/* patch.c - a patch of cells: its box, and running a phase on it. Shared by every way to run the step. */
#include "mpm.h"

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
  sums  = (size_t)nodes * MPM_SUM_NC(grid->dim) * sizeof(PetscReal);
  PetscCall(PetscCalloc1(sums + (size_t)(patch->n[1] * patch->n[2]) * sizeof *patch->span + MPM_LINE,
                         (char **)&patch->memory));
  patch->sum  = (PetscReal *)MPMAlign(patch->memory);
  patch->span = (MPMSpan *)((char *)patch->sum + sums);
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

/* The next address that begins a line of the cache, so that the record of a node lies in one. */
void *MPMAlign(void *memory)
{
  return (void *)(((uintptr_t)memory + MPM_LINE - 1) / MPM_LINE * MPM_LINE);
}

/* Lets all nodes be visited. */
void MPMPatchVisitAll(MPMPatch *patch)
{
  for (PetscInt r = 0; r < patch->n[1] * patch->n[2]; r++) {
    patch->span[r].first = 0;
    patch->span[r].last  = patch->n[0];
  }
}

/* Runs a phase on the patch, whose views hold the fields that the phase declares. pass: of particles to nodes the tiles
   that it is for. Merges what it finds into status. Not collective. */
PetscErrorCode MPMPatchRun(MPM mpm, MPMPatch *patch, const MPMPhase *phase, MPMPass pass, MPMStatus *status)
{
  static const PetscInt parts[] = {[MPM_PASS_EARLY] = MPM_P2G_EARLY, [MPM_PASS_LATE] = MPM_P2G_LATE};
  PetscInt              work    = phase->kind == MPM_NODES ? mpm->particles.n : patch->particles.n;

  PetscFunctionBeginUser;
  MPMWorkBegin(mpm);
  if (phase->kind == MPM_NODES) {
    for (PetscInt k = 0; k < patch->own_n[2]; k++)
      for (PetscInt j = 0; j < patch->own_n[1]; j++) {
        const PetscInt row = (k + patch->own_lo[2] - patch->lo[2]) * patch->n[1] + j + patch->own_lo[1] - patch->lo[1];
        if (patch->span[row].first < patch->span[row].last) phase->nodes(&mpm->params, patch, row);
      }
  } else {
    const MPMTransfer kernel = MPMTransferFind(patch->grid->dim, patch->basis, phase->parts);

    PetscCheck(kernel, PETSC_COMM_SELF, PETSC_ERR_PLIB, "phase %s has no kernel for parts %" PetscInt_FMT, phase->name,
               phase->parts);
    if (phase->kind == MPM_PARTICLES_TO_NODES) {
      if (pass == MPM_PASS_MAIN) MPMTilesFindSpans(patch);
      for (PetscInt k = work = 0; k < patch->tiles.nruns[pass]; k++)
        work += patch->tiles.runs[pass][k].last - patch->tiles.runs[pass][k].first;
    }
    kernel(&mpm->params, patch, phase->parts | parts[pass], status);
  }
  MPMWorkEnd(mpm, (PetscInt)(phase - mpm->phases));
  MPMSimulateWork(phase->name, (PetscReal)work);
  PetscFunctionReturn(PETSC_SUCCESS);
}
