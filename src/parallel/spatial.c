/* spatial.c - spatial decomposition: every process has one patch, its box of a DMDA.

   A step exchanges
     sums of tiles  whose particles touch nodes of the up to 2^dim - 1 processes above, in each transfer from
                    particles to nodes
     node motion    of the nodes above a patch, from their owners, by a PetscSF
     leavers        which go to the owner of their cell, by DMSwarmMigrate or by MPMMigrateDirect
   and has one reduction, of the status. The sums of a tile are the same on whichever process it is, so results do not
   depend on how the grid is cut. With -parallel_sums roundoff each process adds up its own tiles to nodes, and these
   partial sums are added instead (DMLocalToGlobal). */
#include "base/message.h"
#include "base/simulate.h"
#include "kernels/cell.h"
#include "parallel/spatial.h"

static void MergeStatus(void *in, void *inout, int *n, MPI_Datatype *type)
{
  (void)type;
  for (int k = 0; k < *n; k++) MPMStatusMerge((MPMStatus *)inout + k, (const MPMStatus *)in + k);
}

/* Without a histogram the grid is not cut: then it is the pool's master, alone, which is its own neighbour across
   periodic faces. */
static PetscErrorCode SetUp_Spatial(MPMCore *core, const MPMHistogram *h)
{
  MPMExchange *ex = &core->exchange;
  MPMSpatial  *s;
  PetscMPIInt  size, rank;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&s));
  ex->ctx = s;
  if (ex->data == MPI_COMM_NULL) ex->data = core->comm; /* the pool's master has set PETSC_COMM_SELF */
  PetscCallMPI(MPI_Comm_dup(ex->data, &s->comm));
  PetscCallMPI(MPI_Comm_size(ex->data, &size));
  PetscCallMPI(MPI_Comm_rank(ex->data, &rank));
  PetscCallMPI(MPI_Type_contiguous((int)sizeof(MPMStatus), MPI_BYTE, &s->status_type));
  PetscCallMPI(MPI_Type_commit(&s->status_type));
  for (int k = 0; k < 2; k++) {
    PetscCallMPI(MPI_Type_contiguous((int)core->grid.dim * (k + 1), MPIU_REAL, &s->motion_type[k]));
    PetscCallMPI(MPI_Type_commit(&s->motion_type[k]));
  }
  ex->motion_type = s->motion_type[1];
  PetscCallMPI(MPI_Type_contiguous(MPM_NODE_NC, MPIU_REAL, &ex->record_type));
  PetscCallMPI(MPI_Type_commit(&ex->record_type));
  PetscCallMPI(MPI_Op_create(MergeStatus, 1, &s->status_op));
  PetscCheck(h || size == 1, ex->data, PETSC_ERR_PLIB, "the grid is cut for %d processes by a histogram", size);
  if (!rank && h) PetscCall(MPMPartitionChoose(h, size, ex->balance, &ex->partition));
  if (!h) PetscCall(MPMPartitionWhole(&core->grid, &ex->partition));
  PetscCall(MPMPartitionShare(&ex->partition, s->comm));
  PetscCall(MPMSpatialLayout(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The functions of the table ----------------------------------------------------------------------------------- */

/* Adds the partial sums of all processes (-parallel_sums roundoff). The sequence of these additions, and so the
   roundoff, depends on the number of processes. Collective. */
static PetscErrorCode AddPartialSums(MPMCore *core)
{
  MPMExchange *ex    = &core->exchange;
  MPMPatch    *patch = &ex->patch;
  Vec          global;

  PetscFunctionBeginUser;
  for (PetscInt line = 0; line < patch->tiles.lines; line++) {
    PetscCall(DMGetGlobalVector(ex->sums[line], &global));
    PetscCall(VecZeroEntries(global));
    PetscCall(DMLocalToGlobal(ex->sums[line], ex->node_sums[line], ADD_VALUES, global));
    PetscCall(DMGlobalToLocal(ex->sums[line], global, INSERT_VALUES, ex->node_sums[line]));
    PetscCall(DMRestoreGlobalVector(ex->sums[line], &global));
  }
  PetscCall(MPMExchangeOpenNodes(core));
  for (PetscInt i = 0; i < MPMPatchNodes(patch); i++) /* ghosts start from 0 again, so that nothing is added twice */
    for (PetscInt line = 0; line < patch->tiles.lines && MPMPatchSide(patch, i); line++)
      PetscCall(PetscArrayzero(patch->node + line * MPMPatchNodes(patch) + i, 1));
  PetscCall(MPMExchangeCloseNodes(core));
  MPMPatchVisitAll(patch); /* particles of other processes touch nodes here too */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Zeroes the sums of these parts at all nodes, since partial sums are added at all nodes, also at those that no
   particle here touches. */
static PetscErrorCode ZeroSums(MPMCore *core, PetscInt parts)
{
  const MPMPatch *patch = &core->exchange.patch;
  PetscInt        which[MPM_NODE_NUMBERS];
  const PetscInt  n = MPMNodeSums(core->grid.dim, parts & ~MPM_P2G_WHOLE, which), nodes = MPMPatchNodes(patch);

  PetscFunctionBeginUser;
  PetscCall(MPMExchangeOpenNodes(core));
  for (PetscInt i = 0; i < nodes; i++)
    for (PetscInt w = 0; w < n; w++)
      ((PetscReal *)(patch->node + which[w] / MPM_NODE_NC * nodes + i))[which[w] % MPM_NODE_NC] = 0;
  PetscCall(MPMExchangeCloseNodes(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Calls MPI now and then while particles are summed, so that the messages of sums proceed: without that, some ways to
   send, mostly of large messages, make the receiver wait until the sender has summed its particles, or the sender until
   the receiver has. */
static void Progress(void *ctx)
{
  MPMCore    *core = (MPMCore *)ctx;
  MPMSpatial *s    = (MPMSpatial *)core->exchange.ctx;
  int         done;

  MPMWorkPause(&core->timers);
  if (s->fault == MPI_SUCCESS) s->fault = MPI_Testall(s->nfrom + s->nto, s->request, &done, MPI_STATUSES_IGNORE);
  MPMWorkResume(&core->timers);
}

/* Starts to send the sums of tiles at upper sides, sums the tiles of the late pass meanwhile, and receives the sums of
   the tiles below: one message for each neighbour. Collective on neighbours. */
static PetscErrorCode ExchangeTiles(MPMCore *core, MPMSpatial *s, const MPMPhase *phase)
{
  MPMPatch   *patch = &core->exchange.patch;
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
  MPMWorkBegin(&core->timers);
  for (int k = 0; k < s->nto; k++) {
    const size_t bytes = MPMTilesPack(patch, s->to[k].toward, phase->parts, s->out + at);

    PetscCall(MPMMessageLength(bytes, &len));
    MPMSimulateWork("PACK", (PetscReal)bytes); /* before the message leaves */
    PetscCallMPI(
        MPI_Isend(s->out + at, len, MPI_BYTE, s->to[k].rank, s->to[k].tag, s->comm, &s->request[s->nfrom + k]));
    at += bytes;
  }
  MPMWorkEnd(&core->timers, phase->timer, NULL, 0);
  patch->meanwhile = Progress;
  patch->ctx       = core;
  PetscCall(MPMExchangeRun(core, phase, MPM_PASS_LATE));
  PetscCallMPI(MPI_Waitall(s->nfrom, s->request, MPI_STATUSES_IGNORE));
  MPMWorkBegin(&core->timers);
  patch->tiles.nslots = patch->tiles.n_own;
  for (int k = 0; k < s->nfrom; k++) MPMTilesUnpack(patch, s->from[k].toward, phase->parts, s->in + in[k]);
  MPMWorkEnd(&core->timers, phase->timer, "PACK", (PetscReal)need);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Sweep_Spatial(MPMCore *core, const MPMPhase *phase)
{
  MPMSpatial *s = (MPMSpatial *)core->exchange.ctx;

  PetscFunctionBeginUser;
  if (phase->kind == MPM_PARTICLES_TO_NODES) {
    if (core->exchange.roundoff) PetscCall(ZeroSums(core, phase->parts));
    PetscCall(MPMExchangeRun(core, phase, MPM_PASS_EARLY));
    if (!core->exchange.roundoff) PetscCall(ExchangeTiles(core, s, phase));
    MPMTilesWrap(&core->exchange.patch);
  }
  PetscCall(MPMExchangeRun(core, phase, MPM_PASS_MAIN));
  if (phase->kind == MPM_PARTICLES_TO_NODES &&
      !core->exchange.roundoff) { /* not before: receivers may still sum late tiles */
    core->exchange.patch.meanwhile = NULL;
    PetscCallMPI(s->fault);
    PetscCallMPI(MPI_Waitall(s->nto, s->request + s->nfrom, MPI_STATUSES_IGNORE));
  }
  if (phase->kind == MPM_PARTICLES_TO_NODES && core->exchange.roundoff) PetscCall(AddPartialSums(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Nodes_Spatial(MPMCore *core, const MPMPhase *phase)
{
  MPMExchange *ex = &core->exchange;
  MPMSpatial  *s  = (MPMSpatial *)ex->ctx;
  const int    k  = (int)phase->motion - 1;

  PetscFunctionBeginUser;
  PetscCall(MPMExchangeOpenNodes(core));
  PetscCall(MPMExchangeNodes(core, phase));
  PetscCall(PetscSFBcastBegin(s->ghosts[k], s->motion_type[k], ex->patch.motion, ex->patch.motion, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(s->ghosts[k], s->motion_type[k], ex->patch.motion, ex->patch.motion, MPI_REPLACE));
  PetscCall(MPMExchangeCloseNodes(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the only reduction of a step, which also checks the fingerprint of the particles after the last migration. */
static PetscErrorCode Reduce_Spatial(MPMCore *core, MPMStatus *status)
{
  MPMSpatial *s = (MPMSpatial *)core->exchange.ctx;

  PetscFunctionBeginUser;
  PetscCall(MPMMigrateClear(s));
  if (status->left && !MPMStatusIsBad(status)) {
    PetscCall(MPMTimersBegin(&core->timers, MPM_TIMER_MIGRATE)); /* it counts as migration */
    PetscCall(MPMMigrateList(core, s, &status->hops));
    PetscCall(MPMTimersEnd(&core->timers, MPM_TIMER_MIGRATE));
  }
  status->n = status->most = core->particles.n;
  status->ids              = s->ids;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, status, 1, s->status_type, s->status_op, s->comm));
  PetscCall(MPMParticlesCheck(&core->particles, core->exchange.data, status->n, status->ids));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMHistogramAddView(MPMHistogram *h, const MPMCore *core, const MPMView *view)
{
  const PetscInt dim = core->grid.dim;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < view->n; p++) {
    PetscReal xi[3];
    PetscInt  base[3] = {0};

    (void)MPMLocate((int)dim, core->basis, &core->grid, MPMKindOf(core->params.kinds, view, p)->copy,
                    MPMPlaces(&core->grid, view) + p * dim, MPMHalfWidths((int)dim, core->params.kinds, view, p), xi,
                    base);
    for (PetscInt d = 0; d < dim; d++) base[d] += core->grid.layers[d];
    PetscCall(MPMHistogramAdd(h, base, 1));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the cells of all particles in this patch, or that they have none here. */
static void FindCells(const MPMCore *core, MPMView *view)
{
  const PetscInt dim = core->grid.dim;

  for (PetscInt p = 0; p < view->n; p++) {
    PetscInt base[3] = {0};

    view->cell[p] = MPMOwnCell((int)dim, core->basis, &core->exchange.patch,
                               MPMKindOf(core->params.kinds, view, p)->copy, MPMPlaces(&core->grid, view) + p * dim,
                               MPMHalfWidths((int)dim, core->params.kinds, view, p), base);
  }
}

/* Counts the particles of a view by the grid's cuts. Collective. */
static PetscErrorCode HistogramOf(MPMCore *core, const MPMView *view, MPMHistogram *h)
{
  PetscFunctionBeginUser;
  PetscCall(MPMHistogramCreate(&core->grid, core->basis, ((MPMSpatial *)core->exchange.ctx)->comm, h));
  PetscCall(MPMHistogramAddView(h, core, view));
  PetscCall(MPMHistogramFinish(h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes other cuts, and makes what follows from them. Collective. */
static PetscErrorCode UseCuts(MPMCore *core, const MPMPartition *part)
{
  PetscFunctionBeginUser;
  PetscCall(MPMSpatialTearDown(core));
  PetscCall(MPMPartitionDestroy(&core->exchange.partition));
  core->exchange.partition = *part;
  PetscCall(MPMSpatialLayout(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cuts the grid anew for the particles as they are now, if the model predicts a gain of more than 3 %. Collective. */
static PetscErrorCode Recut(MPMCore *core)
{
  MPMExchange   *ex     = &core->exchange;
  MPMSpatial    *s      = (MPMSpatial *)ex->ctx;
  const PetscInt fields = MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(cell) | MPM_BIT(kind) | MPM_BIT(l);
  MPMPartition   part   = {.costs = ex->partition.costs};
  PetscMPIInt    size, rank, gain = 0;
  MPMHistogram   h;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(s->comm, &size));
  PetscCallMPI(MPI_Comm_rank(s->comm, &rank));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  PetscCall(HistogramOf(core, &view, &h));
  if (!rank) {
    PetscCall(MPMPartitionChoose(&h, size, MPM_BALANCE_auto, &part));
    gain = part.predicted < 0.97 * MPMPartitionCost(&h, &ex->partition);
  }
  PetscCallMPI(MPI_Bcast(&gain, 1, MPI_INT, 0, s->comm));
  PetscCall(MPMPartitionShare(gain ? &part : &ex->partition, s->comm)); /* also the one in use has a new imbalance */
  if (gain) {
    PetscCall(UseCuts(core, &part));
    FindCells(core, &view);
    core->status.moved      = 1;  /* on every process, so that all sort */
    core->particles.nmovers = -1; /* all particles have other cells */
    ex->recuts++;
    PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
    PetscCall(MPMMigrateList(core, s, &core->status.hops));
    core->status.left = s->nleavers;
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &core->status.left, 1, MPIU_INT64, MPI_SUM, s->comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &core->status.hops, 1, MPIU_INT64, MPI_MAX, s->comm));
  } else {
    PetscCall(MPMPartitionDestroy(&part));
    PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  }
  PetscCall(MPMHistogramDestroy(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeDistribute(MPMCore *core)
{
  MPMSpatial    *s      = (MPMSpatial *)core->exchange.ctx;
  const PetscInt fields = MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(cell) | MPM_BIT(kind) | MPM_BIT(l);
  PetscInt64     left, hops;
  MPMView        view;

  PetscFunctionBeginUser;
  if (core->exchange.type != &MPMExchange_spatial) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  FindCells(core, &view);
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  core->particles.nmovers = -1;
  core->particles.nkept   = core->particles.n;
  if (core->exchange.direct) s->ranked = PETSC_FALSE; /* direct messages do not keep the ranks of the swarm */
  PetscCall(MPMMigrateList(core, s, &hops));
  left = s->nleavers;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &left, 1, MPIU_INT64, MPI_SUM, s->comm));
  PetscCall(left ? MPMMigrateSwarm(core, s) : MPMMigrateClear(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cuts the grid, which has other nodes now, for the particles as they are. Collective. */
static PetscErrorCode Renew_Spatial(MPMCore *core)
{
  MPMExchange   *ex     = &core->exchange;
  MPMSpatial    *s      = (MPMSpatial *)ex->ctx;
  const PetscInt fields = MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(kind) | MPM_BIT(l);
  MPMPartition   part   = {.costs = ex->partition.costs};
  PetscMPIInt    size, rank;
  MPMHistogram   h;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(s->comm, &size));
  PetscCallMPI(MPI_Comm_rank(s->comm, &rank));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  PetscCall(HistogramOf(core, &view, &h));
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  if (!rank && size > 1) PetscCall(MPMPartitionChoose(&h, size, ex->balance, &part));
  if (size == 1) PetscCall(MPMPartitionWhole(&core->grid, &part)); /* the pool's master */
  PetscCall(MPMHistogramDestroy(&h));
  PetscCall(MPMPartitionShare(&part, s->comm));
  PetscCall(UseCuts(core, &part));
  PetscCall(MPMExchangeDistribute(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is it time to look for better cuts (-parallel_balance auto)? It is when the time lost to imbalance since the last
   look exceeds what a new cut takes. Both are the model's, since measured times would differ between processes. */
static PetscBool TimeToRecut(MPMCore *core)
{
  MPMSpatial     *s    = (MPMSpatial *)core->exchange.ctx;
  const PetscReal mean = (PetscReal)core->particles.total / (s->p[0] * s->p[1] * s->p[2]);

  if (!core->particles.total) return PETSC_FALSE;
  s->lost += core->exchange.partition.costs.particle *
             ((PetscReal)core->status.most - mean * PetscMax(1, core->exchange.partition.imbalance));
  if (s->lost < 5e-3 + 500e-9 * mean) return PETSC_FALSE;
  s->lost = 0;
  return PETSC_TRUE;
}

static PetscErrorCode Share_Spatial(MPMCore *core, MPMShare *share)
{
  const MPMSpatial *s = (const MPMSpatial *)core->exchange.ctx;

  PetscFunctionBeginUser;
  for (int k = 0; k < s->nto; k++)
    share->ghosts += (PetscReal)MPMTilesSent(&core->exchange.patch, s->to[k].toward) /
                     MPMTilesPerGhost(core->grid.dim, core->basis);
  share->neighbours = 0.5 * (PetscReal)(s->nto + s->nfrom);
  for (PetscInt d = 0; d < 3; d++) {
    share->axes += s->p[d] > 1;
    share->cuts += (PetscReal)(s->p[d] - 1);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Settle_Spatial(MPMCore *core, PetscBool anew)
{
  MPMExchange *ex = &core->exchange;
  MPMSpatial  *s  = (MPMSpatial *)ex->ctx;
  PetscInt64   ids, hops;

  PetscFunctionBeginUser;
  if (!anew && core->status.bad == MPM_GONE) {
    PetscCall(MPMExchangeRemove(core, &ids));
    s->ids = (PetscInt64)((uint64_t)s->ids - (uint64_t)ids);
    if (s->nleavers) PetscCall(MPMMigrateList(core, s, &hops)); /* the same ones, some of them in other places */
  }
  if (!anew && ex->balance == MPM_BALANCE_auto && TimeToRecut(core)) PetscCall(Recut(core));
  if (!anew && core->status.left) { /* the sum over all processes, so all of them migrate or none does */
    PetscCall(MPMTimersBegin(&core->timers, MPM_TIMER_MIGRATE));
    ex->migrations++;
    ex->migrants += core->status.left;
    PetscCall(ex->direct ? MPMMigrateDirect(core, s) : MPMMigrateSwarm(core, s));
    PetscCall(MPMTimersEnd(&core->timers, MPM_TIMER_MIGRATE));
  }
  if (anew) {
    s->ranked = PETSC_FALSE; /* there may be particles that have flowed in */
    PetscCall(MPMParticlesLocate(&core->particles, &ex->patch, core->params.kinds));
    PetscCall(MPMParticlesFingerprint(&core->particles, &s->ids));
  } else if (core->status.moved) {
    PetscCall(MPMExchangeSort(core));
  }
  if (anew || core->status.moved) PetscCall(MPMTilesAssign(&ex->patch, ex->type->by_workers, core->particles.start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Finish_Spatial(MPMCore *core)
{
  MPMSpatial *s = (MPMSpatial *)core->exchange.ctx;

  PetscFunctionBeginUser;
  PetscCall(MPMSpatialTearDown(core));
  PetscCall(MPMPartitionDestroy(&core->exchange.partition));
  PetscCall(MPMMigrateClear(s));
  PetscCall(PetscFree(s->out));
  PetscCall(PetscFree(s->in));
  PetscCall(PetscFree(s->packed));
  PetscCallMPI(MPI_Op_free(&s->status_op));
  PetscCallMPI(MPI_Type_free(&s->status_type));
  for (int k = 0; k < 2; k++) PetscCallMPI(MPI_Type_free(&s->motion_type[k]));
  PetscCallMPI(MPI_Type_free(&core->exchange.record_type));
  PetscCallMPI(MPI_Comm_free(&s->comm));
  PetscCall(PetscFree(core->exchange.ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MPMExchangeType MPMExchange_spatial = {
    .name   = "spatial",
    .setup  = SetUp_Spatial,
    .sweep  = Sweep_Spatial,
    .nodes  = Nodes_Spatial,
    .reduce = Reduce_Spatial,
    .settle = Settle_Spatial,
    .renew  = Renew_Spatial,
    .finish = Finish_Spatial,
    .cuts   = PETSC_TRUE,
    .share  = Share_Spatial,
};
