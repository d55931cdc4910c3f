/* exchange_serial.c - one process, one patch that is the whole grid: nothing is exchanged. */
#include "mpm.h"

static PetscErrorCode SetUp_Serial(MPM mpm)
{
  MPMExchange *ex = &mpm->exchange;

  PetscFunctionBeginUser;
  ex->data = PETSC_COMM_SELF;
  PetscCall(MPMGridCreateDM(&mpm->grid, ex->data, MPMBasisNodes(mpm->basis) - 1, NULL, &ex->da));
  PetscCall(DMCreateLocalVector(ex->da, &ex->vel));
  PetscCall(MPMPatchSetBox(&ex->patch, &mpm->grid, mpm->basis, ex->da));
  PetscCall(MPMTilesSetUp(&ex->patch, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Sweep_Serial(MPM mpm, const MPMPhase *phase)
{
  PetscFunctionBeginUser;
  PetscCall(MPMExchangeRun(mpm, phase, MPM_PASS_MAIN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Nodes_Serial(MPM mpm, const MPMPhase *phase)
{
  MPMExchange *ex = &mpm->exchange;

  PetscFunctionBeginUser;
  PetscCall(VecGetArray(ex->vel, &ex->patch.vel));
  PetscCall(MPMPatchRun(mpm, &ex->patch, phase, MPM_PASS_MAIN, &mpm->status));
  PetscCall(VecRestoreArray(ex->vel, &ex->patch.vel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reduce_Serial(MPM mpm, MPMStatus *status)
{
  PetscFunctionBeginUser;
  (void)mpm;
  (void)status;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Settle_Serial(MPM mpm, PetscBool anew)
{
  MPMPatch *patch = &mpm->exchange.patch;

  PetscFunctionBeginUser;
  if (!anew && !mpm->status.moved) PetscFunctionReturn(PETSC_SUCCESS);
  if (anew)
    PetscCall(MPMParticlesLocate(&mpm->particles, patch, mpm->scene.kinds));
  else {
    PetscCall(MPMSettlingBegin(mpm, MPM_TIMER_SORT));
    PetscCall(MPMParticlesSort(&mpm->particles, patch));
    PetscCall(MPMSettlingEnd(mpm, MPM_TIMER_SORT));
  }
  PetscCall(MPMTilesAssign(patch, mpm->exchange.type->farms, mpm->particles.start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Finish_Serial(MPM mpm)
{
  MPMExchange *ex = &mpm->exchange;

  PetscFunctionBeginUser;
  PetscCall(MPMPatchDestroy(&ex->patch));
  PetscCall(VecDestroy(&ex->vel));
  PetscCall(DMDestroy(&ex->da));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MPMExchangeType MPMExchange_serial = {
    "serial",      "one process, one patch: the whole grid",
    SetUp_Serial,  Sweep_Serial,
    Nodes_Serial,  Reduce_Serial,
    Settle_Serial, Finish_Serial,
    PETSC_FALSE,   NULL,
    NULL,
};
