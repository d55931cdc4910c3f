/* exchange.c - the table of ways to run the step, and the status that they merge. */
#include "tiles.h"

#define MPM_EXCHANGE(name) extern const MPMExchangeType MPMExchange_##name;
#include "exchange.def"
#undef MPM_EXCHANGE

const MPMExchangeType *const MPMExchangeTypes[] = {
#define MPM_EXCHANGE(name) &MPMExchange_##name,
#include "exchange.def"
#undef MPM_EXCHANGE
    NULL};

/* Chooses how the step is run: one process is serial, whatever the strategy, but for periodic faces, across which it is
   its own neighbour. Collective on mpm->comm.                                                                        */
PetscErrorCode MPMExchangeSetFromOptions(MPM mpm, MPMOptions o)
{
  static const char *const balances[] = {"none", "start", "auto"};
  MPMExchange             *ex         = &mpm->exchange;
  char                     strategy[MPM_NAME_LEN], sums[MPM_NAME_LEN], balance[MPM_NAME_LEN], migrate[MPM_NAME_LEN];
  const PetscBool periodic = mpm->grid.periodic[0] || mpm->grid.periodic[1] || mpm->grid.periodic[2] ? PETSC_TRUE
                                                                                                     : PETSC_FALSE;
  PetscMPIInt     size;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "parallel_strategy", NULL, strategy, NULL));
  PetscCall(MPMOptionsEnum(o, "parallel_sums", NULL, sums, NULL));
  PetscCall(MPMOptionsEnum(o, "parallel_balance", NULL, balance, NULL));
  PetscCall(MPMOptionsEnum(o, "parallel_migrate", NULL, migrate, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(mpm->comm, &size));
  ex->roundoff = !strcmp(sums, "roundoff") ? PETSC_TRUE : PETSC_FALSE;
  ex->direct   = !strcmp(migrate, "direct") ? PETSC_TRUE : PETSC_FALSE;
  for (PetscInt k = 0; k < 3; k++)
    if (!strcmp(balances[k], balance)) ex->balance = (MPMBalance)k;
  for (PetscInt k = 0; MPMExchangeTypes[k]; k++)
    if (!strcmp(MPMExchangeTypes[k]->name, size > 1 ? strategy : periodic ? "spatial" : "serial"))
      ex->type = MPMExchangeTypes[k];
  ex->pool_cells = 16;
  PetscCall(MPMOptionsInt(o, "pool_cells", NULL, &ex->pool_cells, NULL));
  ex->pool_cells = MPMPoolEdge(mpm->basis, ex->pool_cells);
  if (size > 1 && !strcmp(strategy, "pool") && ex->roundoff)
    MPMOptionsFail(o, "-parallel_sums roundoff does not apply: the pool always gives bitwise sums");
  if (size > 1 && !strcmp(strategy, "spatial")) {
    const PetscInt largest = MPMPartitionLargest(&mpm->grid, mpm->basis, size);

    if (largest < size)
      MPMOptionsFail(o,
                     "started on %d processes: this grid cannot be cut into so many boxes of at least %" PetscInt_FMT
                     " nodes an axis; the largest number below that can is %" PetscInt_FMT,
                     size, MPMTileEdge(mpm->basis), largest);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shows the patch the fields that the phase declares, and the node motion. Restore by MPMExchangeClose. Not collective.
 */
PetscErrorCode MPMExchangeOpen(MPM mpm, const MPMPhase *phase)
{
  MPMPatch *patch = &mpm->exchange.patch;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&mpm->particles, phase->particles_in | phase->particles_out, &patch->particles));
  patch->order  = mpm->particles.order;
  patch->movers = mpm->particles.movers;
  PetscCall(VecGetArray(mpm->exchange.vel, &patch->vel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeClose(MPM mpm, const MPMPhase *phase)
{
  MPMPatch *patch = &mpm->exchange.patch;

  PetscFunctionBeginUser;
  PetscCall(VecRestoreArray(mpm->exchange.vel, &patch->vel));
  PetscCall(MPMParticlesRestoreView(&mpm->particles, phase->particles_in | phase->particles_out, &patch->particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs a transfer on the particles here. Not collective. */
PetscErrorCode MPMExchangeRun(MPM mpm, const MPMPhase *phase, MPMPass pass)
{
  MPMPatch *patch = &mpm->exchange.patch;

  PetscFunctionBeginUser;
  if (pass != MPM_PASS_MAIN && !patch->tiles.nruns[pass]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMExchangeOpen(mpm, phase));
  PetscCall(MPMPatchRun(mpm, patch, phase, pass, &mpm->status));
  if (phase->parts & MPM_G2P_COMMIT) mpm->particles.nmovers = patch->nmovers;
  PetscCall(MPMExchangeClose(mpm, phase));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMStatusReset(MPMStatus *s)
{
  PetscMemzero(s, sizeof *s);
}

/* The length of a message as MPI takes it; an error if it does not fit into an int. */
PetscErrorCode MPMMessageLength(size_t bytes, PetscMPIInt *len)
{
  PetscFunctionBeginUser;
  PetscCheck(bytes <= PETSC_MPI_INT_MAX, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "a message of %.3g GB is more than MPI takes; use more processes, or a smaller -pool_cells",
             1e-9 * (double)bytes);
  *len = (PetscMPIInt)bytes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for a message; what was in the buffer is lost when it grows. */
PetscErrorCode MPMMessageRoom(char **buffer, size_t *capacity, size_t need)
{
  PetscFunctionBeginUser;
  if (need <= *capacity) PetscFunctionReturn(PETSC_SUCCESS);
  *capacity = need + need / 4 + 4096;
  PetscCall(PetscFree(*buffer));
  PetscCall(PetscMalloc(*capacity, buffer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bytes of these fields of a particle. */
size_t MPMParticlesRowBytes(const MPMParticles *particles, PetscInt fields)
{
  size_t bytes = 0;

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && (fields & (1 << f))) bytes += (size_t)particles->bytes[f];
  return bytes;
}

/* Maxima, sums of integers, and the gravest bad condition of its smallest id: any order of merging gives the same. */
void MPMStatusMerge(MPMStatus *s, const MPMStatus *other)
{
  s->v2 = PetscMax(s->v2, other->v2);
  s->c2 = PetscMax(s->c2, other->c2);
  s->moved += other->moved;
  s->left += other->left;
  s->hops        = PetscMax(s->hops, other->hops);
  s->interrupted = PetscMax(s->interrupted, other->interrupted);
  s->most        = PetscMax(s->most, other->most);
  s->n += other->n;
  s->ids = (PetscInt64)((uint64_t)s->ids + (uint64_t)other->ids); /* modulo 2^64 */
  if (other->bad != MPM_OK &&
      (s->bad == MPM_OK || other->bad < s->bad || (other->bad == s->bad && other->id < s->id))) {
    s->bad = other->bad;
    s->id  = other->id;
    s->J   = other->J;
    PetscMemcpy(s->x, other->x, sizeof s->x);
  }
}
