/* serial.c - one process, one patch that is the whole grid: nothing is exchanged. */
#include "parallel/exchange.h"

static PetscErrorCode SetUp_Serial(MPMCore *core, const MPMHistogram *h)
{
  MPMExchange *ex = &core->exchange;

  PetscFunctionBeginUser;
  (void)h;
  ex->data = PETSC_COMM_SELF;
  PetscCall(MPMExchangeCreateGrid(core, NULL, NULL));
  PetscCall(MPMTilesSetUp(&ex->patch, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Sweep_Serial(MPMCore *core, const MPMPhase *phase)
{
  PetscFunctionBeginUser;
  PetscCall(MPMExchangeRun(core, phase, MPM_PASS_MAIN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Nodes_Serial(MPMCore *core, const MPMPhase *phase)
{
  PetscFunctionBeginUser;
  PetscCall(MPMExchangeOpenNodes(core));
  PetscCall(MPMExchangeNodes(core, phase));
  PetscCall(MPMExchangeCloseNodes(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reduce_Serial(MPMCore *core, MPMStatus *status)
{
  PetscFunctionBeginUser;
  (void)core;
  (void)status;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Settle_Serial(MPMCore *core, PetscBool anew)
{
  MPMPatch  *patch = &core->exchange.patch;
  PetscInt64 ids;

  PetscFunctionBeginUser;
  if (!anew && core->status.bad == MPM_GONE) PetscCall(MPMExchangeRemove(core, &ids));
  if (!anew && !core->status.moved) PetscFunctionReturn(PETSC_SUCCESS);
  if (anew)
    PetscCall(MPMParticlesLocate(&core->particles, patch, core->params.kinds));
  else {
    PetscCall(MPMExchangeSort(core));
  }
  PetscCall(MPMTilesAssign(patch, core->exchange.type->by_workers, core->particles.start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Renew_Serial(MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(MPMExchangeDestroyGrid(core));
  PetscCall(MPMExchangeCreateGrid(core, NULL, NULL));
  PetscCall(MPMTilesSetUp(&core->exchange.patch, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Finish_Serial(MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(MPMExchangeDestroyGrid(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MPMExchangeType MPMExchange_serial = {
    .name   = "serial",
    .setup  = SetUp_Serial,
    .sweep  = Sweep_Serial,
    .nodes  = Nodes_Serial,
    .reduce = Reduce_Serial,
    .settle = Settle_Serial,
    .renew  = Renew_Serial,
    .finish = Finish_Serial,
};
