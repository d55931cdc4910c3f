/* choose.c - the table of ways to run a step (exchange.def), and the choice of one from the options. */
#include "kernels/tile_index.h"
#include "parallel/exchange.h"

#define MPM_EXCHANGE(name, chosen) extern const MPMExchangeType MPMExchange_##name;
#include "parallel/exchange.def"

const MPMExchangeType *const MPMExchangeTypes[] = {
#define MPM_EXCHANGE(name, chosen) &MPMExchange_##name,
#include "parallel/exchange.def"
    NULL};

static const char *const balances[] = {
#define MPM_BALANCE(name, what) #name,
#include "parallel/balance.def"
};

/* Chooses how the step is run. One process runs it serially whatever the strategy; only if a face is periodic does it
   run the spatial way, as its own neighbour across that face. Collective on core->comm. */
PetscErrorCode MPMExchangeSetFromOptions(MPMCore *core, MPMOptions o)
{
  MPMExchange    *ex = &core->exchange;
  char            strategy[MPM_NAME_LEN], sums[MPM_NAME_LEN], balance[MPM_NAME_LEN], migrate[MPM_NAME_LEN];
  const PetscBool periodic = core->grid.periodic[0] || core->grid.periodic[1] || core->grid.periodic[2];
  PetscMPIInt     size;
  PetscInt        row;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "parallel_strategy", NULL, strategy, NULL));
  PetscCall(MPMOptionsEnum(o, "parallel_sums", NULL, sums, NULL));
  PetscCall(MPMOptionsEnum(o, "parallel_balance", NULL, balance, NULL));
  PetscCall(MPMOptionsEnum(o, "parallel_migrate", NULL, migrate, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  ex->roundoff = !strcmp(sums, "roundoff");
  ex->direct   = !strcmp(migrate, "direct");
  PetscCall(MPMOptionsFind(balance, MPM_NUM_BALANCES, balances, &row));
  ex->balance = (MPMBalance)row;
  for (PetscInt k = 0; MPMExchangeTypes[k]; k++)
    if (!strcmp(MPMExchangeTypes[k]->name, size > 1 ? strategy : periodic ? "spatial" : "serial"))
      ex->type = MPMExchangeTypes[k];
  PetscCall(MPMOptionsInt(o, "pool_cells", NULL, &ex->pool_cells, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  ex->pool_cells = MPMPoolEdge(core->basis, ex->pool_cells);
  if (size > 1 && !strcmp(strategy, "pool") && ex->roundoff)
    MPMOptionsFail(o, "-parallel_sums roundoff does not apply: the pool always gives bitwise sums");
  if (size > 1 && !strcmp(strategy, "spatial")) {
    const PetscInt largest = MPMPartitionLargest(&core->grid, core->basis, size);

    if (largest < size)
      MPMOptionsFail(o,
                     "started on %d processes: this grid cannot be cut into so many boxes of at least %" PetscInt_FMT
                     " nodes an axis; the largest number below that can is %" PetscInt_FMT,
                     size, MPMTileEdge(core->basis), largest);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
