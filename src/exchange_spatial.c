/* exchange_spatial.c - spatial decomposition: every process has one patch, its box of a DMDA.

   A step exchanges
     sums of tiles  whose particles touch nodes of the up to 2^dim - 1 processes above, in each phase that sums
   particles node motion    of the nodes above a patch, from their owners by a PetscSF particles         that left their
   patch go to the owner of their cell, by DMSwarmMigrate, or by MPMMigrateDirect and reduces once: the status. Tiles
   are added up the same on whichever process they are, so results do not depend on how the grid is cut. With
   -parallel_sums roundoff each process adds up its own tiles to nodes and these partial sums are added instead
   (DMLocalToGlobal). */
#include "cell.h"
#include "exchange_spatial.h"

static void MergeStatus(void *in, void *inout, int *n, MPI_Datatype *type)
{
  (void)type;
  for (int k = 0; k < *n; k++) MPMStatusMerge((MPMStatus *)inout + k, (const MPMStatus *)in + k);
}

static PetscErrorCode SetUp_Spatial(MPM mpm)
{
  MPMExchange *ex = &mpm->exchange;
  MPMSpatial  *s;
  MPMHistogram h;
  PetscMPIInt  size, rank;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&s));
  ex->ctx = s;
  if (ex->data == MPI_COMM_NULL) ex->data = mpm->comm; /* the pool's master uses itself alone */
  PetscCallMPI(MPI_Comm_dup(ex->data, &s->comm));
  PetscCallMPI(MPI_Comm_size(ex->data, &size));
  PetscCallMPI(MPI_Comm_rank(ex->data, &rank));
  PetscCallMPI(MPI_Type_contiguous((int)sizeof(MPMStatus), MPI_BYTE, &s->status_type));
  PetscCallMPI(MPI_Type_commit(&s->status_type));
  PetscCallMPI(MPI_Type_contiguous((int)MPM_VEL_NC(mpm->grid.dim), MPIU_REAL, &s->vel_type));
  PetscCallMPI(MPI_Type_commit(&s->vel_type));
  PetscCallMPI(MPI_Op_create(MergeStatus, 1, &s->status_op));
  PetscCall(MPMHistogramCreate(&mpm->grid, mpm->basis, s->comm, &h));
  PetscCall(MPMSceneHistogram(mpm, &h));
  PetscCall(MPMHistogramFinish(&h));
  MPMModelCosts(mpm, (PetscReal)mpm->particles.total / size, &ex->partition.costs);
  if (!rank) PetscCall(MPMPartitionChoose(&h, size, ex->balance, &ex->partition));
  PetscCall(MPMPartitionShare(&ex->partition, s->comm));
  PetscCall(MPMHistogramDestroy(&h));
  PetscCall(MPMSpatialLayout(mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The functions of the table ------------------------------------------------------------------------------------
 */

/* -parallel_sums roundoff: adds the partial sums of all processes. Their order depends on the number of processes. */
static PetscErrorCode AddPartialSums(MPM mpm, MPMSpatial *s)
{
  MPMPatch *patch = &mpm->exchange.patch;
  Vec       local, global;

  PetscFunctionBeginUser;
  PetscCall(DMGetLocalVector(s->sums, &local));
  PetscCall(DMGetGlobalVector(s->sums, &global));
  PetscCall(VecPlaceArray(local, patch->sum));
  PetscCall(VecZeroEntries(global));
  PetscCall(DMLocalToGlobal(s->sums, local, ADD_VALUES, global));
  PetscCall(DMGlobalToLocal(s->sums, global, INSERT_VALUES, local));
  PetscCall(VecResetArray(local));
  PetscCall(DMRestoreGlobalVector(s->sums, &global));
  PetscCall(DMRestoreLocalVector(s->sums, &local));
  for (PetscInt i = 0; i < MPMPatchNodes(patch);
       i++) { /* ghost nodes start from 0 again, so that the next phase adds nothing twice */
    const PetscInt ijk[3] = {i % patch->n[0] + patch->lo[0], i / patch->n[0] % patch->n[1] + patch->lo[1],
                             i / (patch->n[0] * patch->n[1]) + patch->lo[2]};
    PetscBool      own    = PETSC_TRUE;

    for (PetscInt d = 0; d < 3; d++)
      if (ijk[d] < patch->own_lo[d] || ijk[d] >= patch->own_lo[d] + patch->own_n[d]) own = PETSC_FALSE;
    if (!own) PetscCall(PetscArrayzero(patch->sum + i * MPM_SUM_NC(mpm->grid.dim), MPM_SUM_NC(mpm->grid.dim)));
  }
  MPMPatchVisitAll(patch); /* others' particles touch nodes here too */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Zeroes the parts' sums of all nodes: partial sums are those of own particles alone, at nodes that they do not touch
 * too.
 */
static void ZeroSums(MPMPatch *patch, PetscInt parts)
{
  const PetscInt dim = patch->grid->dim;

  for (PetscInt i = 0; i < MPMPatchNodes(patch); i++)
    for (PetscInt c = MPM_SUM_FIRST(dim, parts); c < MPM_SUM_LAST(dim, parts); c++)
      patch->sum[i * MPM_SUM_NC(dim) + c] = 0;
}

/* Lets the messages of sums get on while particles are summed: without a call of MPI now and then some ways to send, of
   large messages above all, make the receiver wait until the sender has summed its particles, or the other way round.
 */
static void Progress(void *ctx)
{
  MPM         mpm = (MPM)ctx;
  MPMSpatial *s   = (MPMSpatial *)mpm->exchange.ctx;
  int         done;

  MPMWorkPause(mpm);
  if (s->fault == MPI_SUCCESS) s->fault = MPI_Testall(s->nfrom + s->nto, s->request, &done, MPI_STATUSES_IGNORE);
  MPMWorkResume(mpm);
}

/* Begins to send the sums of tiles at upper sides, makes those of late tiles meanwhile, and receives those of the tiles
   below: one message a neighbour. Collective on neighbours. */
static PetscErrorCode ExchangeTiles(MPM mpm, MPMSpatial *s, const MPMPhase *phase)
{
  MPMPatch   *patch = &mpm->exchange.patch;
  size_t      need = 0, at = 0, in[MPM_MAX_NEIGHBOURS];
  PetscMPIInt len;

  PetscFunctionBeginUser;
  for (int k = 0; k < s->nto; k++) need += MPMTilesBytes(patch, s->to[k].toward, phase->parts, PETSC_TRUE);
  PetscCall(MPMMessageRoom(&s->out, &s->out_capacity, need));
  need = 0;
  for (int k = 0; k < s->nfrom; k++) {
    in[k] = need;
    need += MPMTilesBytes(patch, s->from[k].toward, phase->parts, PETSC_FALSE);
  }
  PetscCall(MPMMessageRoom(&s->in, &s->in_capacity, need));
  for (int k = 0; k < s->nfrom; k++) {
    PetscCall(MPMMessageLength((k + 1 < s->nfrom ? in[k + 1] : need) - in[k], &len));
    PetscCallMPI(MPI_Irecv(s->in + in[k], len, MPI_BYTE, s->from[k].rank, s->from[k].tag, s->comm, &s->request[k]));
  }
  MPMWorkBegin(mpm);
  for (int k = 0; k < s->nto; k++) {
    const size_t bytes = MPMTilesPack(patch, s->to[k].toward, phase->parts, s->out + at);

    PetscCall(MPMMessageLength(bytes, &len));
    MPMSimulateWork("PACK", (PetscReal)bytes);
    PetscCallMPI(
        MPI_Isend(s->out + at, len, MPI_BYTE, s->to[k].rank, s->to[k].tag, s->comm, &s->request[s->nfrom + k]));
    at += bytes;
  }
  MPMWorkEnd(mpm, (PetscInt)(phase - mpm->phases));
  patch->meanwhile = Progress;
  patch->ctx       = mpm;
  PetscCall(MPMExchangeRun(mpm, phase, MPM_PASS_LATE));
  PetscCallMPI(MPI_Waitall(s->nfrom, s->request, MPI_STATUSES_IGNORE));
  MPMWorkBegin(mpm);
  patch->tiles.nslots = patch->tiles.n_own;
  for (int k = 0; k < s->nfrom; k++) MPMTilesUnpack(patch, s->from[k].toward, phase->parts, s->in + in[k]);
  MPMWorkEnd(mpm, (PetscInt)(phase - mpm->phases));
  MPMSimulateWork("PACK", (PetscReal)need);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Sweep_Spatial(MPM mpm, const MPMPhase *phase)
{
  MPMSpatial *s = (MPMSpatial *)mpm->exchange.ctx;

  PetscFunctionBeginUser;
  if (phase->kind == MPM_PARTICLES_TO_NODES) {
    if (mpm->exchange.roundoff) ZeroSums(&mpm->exchange.patch, phase->parts);
    PetscCall(MPMExchangeRun(mpm, phase, MPM_PASS_EARLY));
    if (!mpm->exchange.roundoff) PetscCall(ExchangeTiles(mpm, s, phase));
    MPMTilesWrap(&mpm->exchange.patch);
  }
  PetscCall(MPMExchangeRun(mpm, phase, MPM_PASS_MAIN));
  if (phase->kind == MPM_PARTICLES_TO_NODES &&
      !mpm->exchange.roundoff) { /* not before: receivers may be at late tiles */
    mpm->exchange.patch.meanwhile = NULL;
    PetscCallMPI(s->fault);
    PetscCallMPI(MPI_Waitall(s->nto, s->request + s->nfrom, MPI_STATUSES_IGNORE));
  }
  if (phase->kind == MPM_PARTICLES_TO_NODES && mpm->exchange.roundoff) PetscCall(AddPartialSums(mpm, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Nodes_Spatial(MPM mpm, const MPMPhase *phase)
{
  MPMExchange *ex = &mpm->exchange;
  MPMSpatial  *s  = (MPMSpatial *)ex->ctx;

  PetscFunctionBeginUser;
  PetscCall(VecGetArray(ex->vel, &ex->patch.vel));
  PetscCall(MPMPatchRun(mpm, &ex->patch, phase, MPM_PASS_MAIN, &mpm->status));
  PetscCall(PetscSFBcastBegin(s->ghosts, s->vel_type, ex->patch.vel, ex->patch.vel, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(s->ghosts, s->vel_type, ex->patch.vel, ex->patch.vel, MPI_REPLACE));
  PetscCall(VecRestoreArray(ex->vel, &ex->patch.vel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The one reduction of a step; it also carries the fingerprint of the particles after the migration before. */
static PetscErrorCode Reduce_Spatial(MPM mpm, MPMStatus *status)
{
  MPMSpatial *s = (MPMSpatial *)mpm->exchange.ctx;

  PetscFunctionBeginUser;
  PetscCall(MPMMigrateForget(s));
  if (status->left && status->bad == MPM_OK) {
    PetscLogDouble t0, t1;

    PetscCall(MPMClock(mpm, &t0));
    PetscCall(MPMMigrateList(mpm, s, &status->hops));
    PetscCall(MPMClock(mpm, &t1)); /* it is a part of the migration */
    mpm->phase_seconds[MPM_TIMER_MIGRATE] += t1 - t0;
    mpm->phase_seconds[MPM_TIMER_REDUCE] -= t1 - t0;
  }
  status->n = status->most = mpm->particles.n;
  status->ids              = s->ids;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, status, 1, s->status_type, s->status_op, s->comm));
  PetscCall(MPMParticlesCheck(&mpm->particles, mpm->exchange.data, status->n, status->ids));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cuts the grid anew for the particles as they are, if the model sees a gain of a few per cent. Collective. */
static PetscErrorCode Recut(MPM mpm)
{
  MPMExchange   *ex  = &mpm->exchange;
  MPMSpatial    *s   = (MPMSpatial *)ex->ctx;
  const PetscInt dim = mpm->grid.dim, fields = MPM_BIT(x) | MPM_BIT(cell) | MPM_BIT(kind) | MPM_BIT(l);
  MPMPartition   part = {.costs = ex->partition.costs};
  PetscMPIInt    size, rank, gain = 0;
  MPMHistogram   h;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(s->comm, &size));
  PetscCallMPI(MPI_Comm_rank(s->comm, &rank));
  PetscCall(MPMHistogramCreate(&mpm->grid, mpm->basis, s->comm, &h));
  PetscCall(MPMParticlesGetView(&mpm->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal xi[3];
    PetscInt  base[3] = {0};

    (void)MPMLocate((int)dim, mpm->basis, &mpm->grid, view.x + p * dim,
                    MPMHalfWidths((int)dim, mpm->scene.kinds, &view, p), xi, base);
    for (PetscInt d = 0; d < dim; d++) base[d] += mpm->grid.layers[d];
    PetscCall(MPMHistogramAdd(&h, base, 1));
  }
  PetscCall(MPMHistogramFinish(&h));
  if (!rank) {
    PetscCall(MPMPartitionChoose(&h, size, MPM_BALANCE_AUTO, &part));
    gain = part.predicted < 0.97 * MPMPartitionCost(&h, &ex->partition);
  }
  PetscCallMPI(MPI_Bcast(&gain, 1, MPI_INT, 0, s->comm));
  PetscCall(MPMPartitionShare(gain ? &part : &ex->partition, s->comm)); /* that in use has another imbalance now */
  if (gain) {
    PetscCall(MPMSpatialTearDown(mpm));
    PetscCall(MPMPartitionDestroy(&ex->partition));
    ex->partition = part;
    PetscCall(MPMSpatialLayout(mpm));
    for (PetscInt p = 0; p < view.n; p++) {
      PetscInt base[3] = {0};

      view.cell[p] = MPMOwnCell((int)dim, mpm->basis, &ex->patch, view.x + p * dim,
                                MPMHalfWidths((int)dim, mpm->scene.kinds, &view, p), base);
    }
    mpm->status.moved      = 1;  /* on every process: all sort */
    mpm->particles.nmovers = -1; /* all have other cells */
    ex->recuts++;
    PetscCall(MPMParticlesRestoreView(&mpm->particles, fields, &view));
    PetscCall(MPMMigrateList(mpm, s, &mpm->status.hops));
    mpm->status.left = s->nleavers;
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &mpm->status.left, 1, MPIU_INT64, MPI_SUM, s->comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &mpm->status.hops, 1, MPIU_INT64, MPI_MAX, s->comm));
  } else {
    PetscCall(MPMPartitionDestroy(&part));
    PetscCall(MPMParticlesRestoreView(&mpm->particles, fields, &view));
  }
  PetscCall(MPMHistogramDestroy(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* -parallel_balance auto: is it time to look for better cuts? When what was lost to the most loaded process since the
   last look exceeds what a cut costs, both by the model: wall times would differ between processes. */
static PetscBool TimeToRecut(MPM mpm)
{
  MPMSpatial     *s    = (MPMSpatial *)mpm->exchange.ctx;
  const PetscReal mean = (PetscReal)mpm->particles.total / (s->p[0] * s->p[1] * s->p[2]);

  s->lost += mpm->exchange.partition.costs.particle *
             ((PetscReal)mpm->status.most - mean * PetscMax(1, mpm->exchange.partition.imbalance));
  if (s->lost < 5e-3 + 500e-9 * mean) return PETSC_FALSE;
  s->lost = 0;
  return PETSC_TRUE;
}

static PetscErrorCode Share_Spatial(MPM mpm, MPMShare *share)
{
  const MPMSpatial *s = (const MPMSpatial *)mpm->exchange.ctx;

  PetscFunctionBeginUser;
  for (int k = 0; k < s->nto; k++)
    share->ghosts += (PetscReal)MPMTilesSent(&mpm->exchange.patch, s->to[k].toward) /
                     MPMTilesPerGhost(mpm->grid.dim, mpm->basis);
  share->neighbours = 0.5 * (PetscReal)(s->nto + s->nfrom);
  for (PetscInt d = 0; d < 3; d++) {
    share->axes += s->p[d] > 1;
    share->cuts += (PetscReal)(s->p[d] - 1);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Settle_Spatial(MPM mpm, PetscBool anew)
{
  MPMExchange *ex = &mpm->exchange;
  MPMSpatial  *s  = (MPMSpatial *)ex->ctx;

  PetscFunctionBeginUser;
  if (!anew && ex->balance == MPM_BALANCE_AUTO && TimeToRecut(mpm)) PetscCall(Recut(mpm));
  if (!anew && mpm->status.left) { /* of any process: all migrate or none */
    PetscCall(MPMSettlingBegin(mpm, MPM_TIMER_MIGRATE));
    ex->migrations++;
    ex->migrants += mpm->status.left;
    PetscCall(ex->direct ? MPMMigrateDirect(mpm, s) : MPMMigrateSwarm(mpm, s));
    PetscCall(MPMSettlingEnd(mpm, MPM_TIMER_MIGRATE));
  }
  if (anew) {
    PetscCall(MPMParticlesLocate(&mpm->particles, &ex->patch, mpm->scene.kinds));
    PetscCall(MPMParticlesFingerprint(&mpm->particles, &s->ids));
  } else if (mpm->status.moved) {
    PetscCall(MPMSettlingBegin(mpm, MPM_TIMER_SORT));
    PetscCall(MPMParticlesSort(&mpm->particles, &ex->patch));
    PetscCall(MPMSettlingEnd(mpm, MPM_TIMER_SORT));
  }
  if (anew || mpm->status.moved) PetscCall(MPMTilesAssign(&ex->patch, ex->type->farms, mpm->particles.start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Finish_Spatial(MPM mpm)
{
  MPMSpatial *s = (MPMSpatial *)mpm->exchange.ctx;

  PetscFunctionBeginUser;
  PetscCall(MPMSpatialTearDown(mpm));
  PetscCall(MPMPartitionDestroy(&mpm->exchange.partition));
  PetscCall(MPMMigrateForget(s));
  PetscCall(PetscFree(s->out));
  PetscCall(PetscFree(s->in));
  PetscCallMPI(MPI_Op_free(&s->status_op));
  PetscCallMPI(MPI_Type_free(&s->status_type));
  PetscCallMPI(MPI_Type_free(&s->vel_type));
  PetscCallMPI(MPI_Comm_free(&s->comm));
  PetscCall(PetscFree(mpm->exchange.ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MPMExchangeType MPMExchange_spatial = {
    "spatial",      "a box of the grid and its particles for each process",
    SetUp_Spatial,  Sweep_Spatial,
    Nodes_Spatial,  Reduce_Spatial,
    Settle_Spatial, Finish_Spatial,
    PETSC_FALSE,    NULL,
    Share_Spatial,
};
