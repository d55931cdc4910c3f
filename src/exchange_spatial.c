/* exchange_spatial.c - spatial decomposition: every process has one patch, its box of a DMDA.

   A step exchanges
     halo points   the points of the cells below a patch touch its own nodes: copies of them come from the (up to
                   2^dim - 1) neighbours on the lower sides, positions once a step, other fields as phases declare
     node motion   of the nodes above a patch, by PETSc's ghost update (DMLocalToLocal)
     points        that left their patch go to the owner of their cell, by DMSwarmMigrate, or by MPMMigrateDirect
   and reduces once: the status. Own nodes get complete sums in the canonical order, so results do not depend on how
   the grid is cut. With -parallel_sums roundoff the partial sums of own points are added instead (DMLocalToGlobal).   */
#include "transfer.h"
#include "exchange_spatial.h"

/* Fields that are constant in a step: a halo point gets them once. */
#define MPM_STEADY (MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(kind))

/* --- Who is where ---------------------------------------------------------------------------------------------- */

/* The process that owns cell `base` (a node of the grid). */
PetscMPIInt MPMSpatialOwner(const MPMSpatial *s, PetscInt dim, const PetscInt base[])
{
  PetscInt rank = 0;

  for (PetscInt d = dim - 1; d >= 0; d--) {
    PetscInt lo = 0, hi = s->p[d];

    while (hi - lo > 1) {
      const PetscInt mid = (lo + hi) / 2;
      if (s->first[d][mid] <= base[d]) lo = mid;
      else hi = mid;
    }
    rank = rank * s->p[d] + lo;
  }
  return (PetscMPIInt)rank;
}

/* Neighbours: o in {0,1}^dim, not 0. Points of my cells at the upper side o go to the process at +o; the process at -o
   sends me its own. Boxes of cells are in nodes of the grid.                                                         */
static PetscErrorCode FindNeighbours(MPM mpm, MPMSpatial *s)
{
  const MPMPatch *patch = &mpm->exchange.patch;
  const PetscInt  dim = mpm->grid.dim, reach = MPMBasisNodes(mpm->basis) - 1;
  PetscInt        me[3] = {0}, rest;
  PetscMPIInt     rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(s->comm, &rank));
  rest = rank;
  for (PetscInt d = 0; d < dim; d++) {
    me[d] = rest % s->p[d];
    rest /= s->p[d];
  }
  for (int o = 1; o < 1 << dim; o++) {
    PetscBool up = PETSC_TRUE, down = PETSC_TRUE;
    PetscInt  step = 0, stride = 1;

    for (PetscInt d = 0; d < dim; stride *= s->p[d++]) {
      if (!(o & (1 << d))) continue;
      step += stride;
      if (me[d] == s->p[d] - 1) up = PETSC_FALSE;
      if (me[d] == 0) down = PETSC_FALSE;
    }
    if (up) {
      MPMNeighbour *to = &s->to[s->nto++];

      to->rank = (PetscMPIInt)(rank + step);
      for (PetscInt d = 0; d < 3; d++) {
        to->hi[d] = patch->own_lo[d] + patch->own_n[d];
        to->lo[d] = o & (1 << d) ? to->hi[d] - reach : patch->own_lo[d];
      }
    }
    if (down) s->from[s->nfrom++].rank = (PetscMPIInt)(rank - step);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void MergeStatus(void *in, void *inout, int *n, MPI_Datatype *type)
{
  (void)type;
  for (int k = 0; k < *n; k++) MPMStatusMerge((MPMStatus *)inout + k, (const MPMStatus *)in + k);
}

/* DMDA, patch and neighbours for a partition that is set. */
static PetscErrorCode SetUpPartition(MPM mpm)
{
  MPMExchange        *ex = &mpm->exchange;
  MPMSpatial         *s  = (MPMSpatial *)ex->ctx;
  const MPMPartition *part = &ex->partition;

  PetscFunctionBeginUser;
  PetscCall(MPMGridCreateDM(&mpm->grid, ex->data, MPMBasisNodes(mpm->basis) - 1, part, &ex->da));
  PetscCall(DMCreateLocalVector(ex->da, &ex->vel));
  PetscCall(MPMPatchSetBox(&ex->patch, &mpm->grid, mpm->basis, ex->da));
  for (PetscInt d = 0; d < 3; d++) {
    s->p[d] = part->p[d];
    PetscCall(PetscMalloc1(s->p[d], &s->first[d]));
    for (PetscInt r = 0, at = -mpm->grid.layers; r < s->p[d]; at += part->l[d][r++]) s->first[d][r] = at;
  }
  s->nto = s->nfrom = 0;
  PetscCall(FindNeighbours(mpm, s));
  if (ex->roundoff) PetscCall(DMDACreateCompatibleDMDA(ex->da, MPM_SUM_NC(mpm->grid.dim), &s->sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TearDownPartition(MPM mpm)
{
  MPMExchange *ex = &mpm->exchange;
  MPMSpatial  *s  = (MPMSpatial *)ex->ctx;

  PetscFunctionBeginUser;
  PetscCall(MPMPatchDestroy(&ex->patch));
  PetscCall(VecDestroy(&ex->vel));
  PetscCall(DMDestroy(&ex->da));
  PetscCall(DMDestroy(&s->sums));
  for (PetscInt d = 0; d < 3; d++) PetscCall(PetscFree(s->first[d]));
  PetscCall(PetscFree(s->start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp_Spatial(MPM mpm)
{
  MPMExchange *ex = &mpm->exchange;
  MPMSpatial  *s;
  MPMHistogram h;
  PetscMPIInt  size;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&s));
  ex->ctx  = s;
  ex->data = mpm->comm;
  PetscCallMPI(MPI_Comm_dup(ex->data, &s->comm));
  PetscCallMPI(MPI_Comm_size(ex->data, &size));
  PetscCallMPI(MPI_Type_contiguous((int)sizeof(MPMStatus), MPI_BYTE, &s->status_type));
  PetscCallMPI(MPI_Type_commit(&s->status_type));
  PetscCallMPI(MPI_Op_create(MergeStatus, 1, &s->status_op));
  PetscCall(MPMHistogramCreate(&mpm->grid, mpm->basis, &h));
  PetscCall(MPMSceneHistogram(mpm, &h));
  PetscCall(MPMHistogramFinish(&h, PETSC_COMM_SELF));
  PetscCall(MPMPartitionChoose(&h, size, ex->balance, &ex->partition));
  PetscCall(MPMHistogramDestroy(&h));
  PetscCall(SetUpPartition(mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Halo points ------------------------------------------------------------------------------------------------- */

/* Lists the points of the cells that neighbour `to` needs, in (cell, id) order, from the order of the points. */
static PetscErrorCode ListPoints(MPM mpm, MPMNeighbour *to)
{
  const MPMPatch  *patch = &mpm->exchange.patch;
  const MPMPoints *pts   = &mpm->points;

  PetscFunctionBeginUser;
  for (int pass = 0; pass < 2; pass++) {
    to->n = 0;
    for (PetscInt k = to->lo[2]; k < to->hi[2]; k++)
      for (PetscInt j = to->lo[1]; j < to->hi[1]; j++) {
        const PetscInt row = ((k - patch->lo[2]) * patch->n[1] + j - patch->lo[1]) * patch->n[0] - patch->lo[0];
        const PetscInt a = pts->start[row + to->lo[0]], b = pts->start[row + to->hi[0]];

        if (pass) PetscCall(PetscArraycpy(to->list + to->n, pts->order + a, b - a));
        to->n += b - a;
      }
    if (!pass && to->n > to->capacity) {
      to->capacity = to->n + to->n / 4 + 64;
      PetscCall(PetscFree(to->list));
      PetscCall(PetscMalloc1(to->capacity, &to->list));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bytes of these fields of a point. */
static PetscInt FieldBytes(const MPMPoints *points, PetscInt fields)
{
  PetscInt bytes = 0;

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (points->present[f] && (fields & (1 << f))) bytes += points->bytes[f];
  return bytes;
}

static PetscErrorCode Grow(char **buffer, size_t *capacity, size_t need)
{
  PetscFunctionBeginUser;
  if (need <= *capacity) PetscFunctionReturn(PETSC_SUCCESS);
  *capacity = need + need / 4 + 4096;
  PetscCall(PetscFree(*buffer));
  PetscCall(PetscMalloc(*capacity, buffer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends fields of my listed points and receives those of the halo points: one message a neighbour. */
static PetscErrorCode ExchangeFields(MPM mpm, MPMSpatial *s, PetscInt fields)
{
  const MPMPoints *pts   = &mpm->points;
  const size_t     bytes = (size_t)FieldBytes(pts, fields);
  void            *own[MPM_NUM_FIELDS] = {NULL};
  MPI_Request      request[2 * MPM_MAX_NEIGHBOURS];
  size_t           need = 0, at = 0;
  int              n = 0;

  PetscFunctionBeginUser;
  for (int k = 0; k < s->nto; k++) need += bytes * (size_t)s->to[k].n;
  PetscCall(Grow(&s->out, &s->out_capacity, need));
  PetscCall(Grow(&s->in, &s->in_capacity, bytes * (size_t)s->nhalo));
  for (int k = 0; k < s->nfrom; k++) {
    PetscMPIInt len;

    PetscCall(PetscMPIIntCast((PetscInt)(bytes * (size_t)s->from[k].n), &len));
    if (len) PetscCallMPI(MPI_Irecv(s->in + at, len, MPI_BYTE, s->from[k].rank, 1, s->comm, &request[n++]));
    at += (size_t)len;
  }
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (pts->present[f] && (fields & (1 << f))) PetscCall(DMSwarmGetField(pts->swarm, MPMFields[f].name, NULL, NULL, &own[f]));
  at = 0;
  for (int k = 0; k < s->nto; k++) {
    char *message = s->out + at;

    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      const PetscInt b = pts->bytes[f];

      if (!own[f]) continue;
      for (PetscInt q = 0; q < s->to[k].n; q++, at += (size_t)b) memcpy(s->out + at, (char *)own[f] + s->to[k].list[q] * b, (size_t)b);
    }
    if (s->to[k].n) PetscCallMPI(MPI_Isend(message, (PetscMPIInt)(s->out + at - message), MPI_BYTE, s->to[k].rank, 1, s->comm, &request[n++]));
  }
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (own[f]) PetscCall(DMSwarmRestoreField(pts->swarm, MPMFields[f].name, NULL, NULL, &own[f]));
  PetscCallMPI(MPI_Waitall(n, request, MPI_STATUSES_IGNORE));
  at = 0;
  for (int k = 0, first = 0; k < s->nfrom; first += (int)s->from[k++].n)
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      const size_t len = (size_t)(s->from[k].n * pts->bytes[f]);

      if (!pts->present[f] || !(fields & (1 << f))) continue;
      memcpy((char *)s->halo[f] + (size_t)first * (size_t)pts->bytes[f], s->in + at, len);
      at += len;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tells the neighbours how many points come, and makes room for theirs. */
static PetscErrorCode ExchangeCounts(MPM mpm, MPMSpatial *s)
{
  MPI_Request request[2 * MPM_MAX_NEIGHBOURS];
  int         n = 0;

  PetscFunctionBeginUser;
  for (int k = 0; k < s->nfrom; k++) PetscCallMPI(MPI_Irecv(&s->from[k].n, 1, MPIU_INT, s->from[k].rank, 2, s->comm, &request[n++]));
  for (int k = 0; k < s->nto; k++) PetscCallMPI(MPI_Isend(&s->to[k].n, 1, MPIU_INT, s->to[k].rank, 2, s->comm, &request[n++]));
  PetscCallMPI(MPI_Waitall(n, request, MPI_STATUSES_IGNORE));
  s->nhalo = 0;
  for (int k = 0; k < s->nfrom; k++) s->nhalo += s->from[k].n;
  if (s->nhalo > s->halo_capacity) {
    s->halo_capacity = s->nhalo + s->nhalo / 4 + 64;
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      if (!mpm->points.present[f]) continue;
      PetscCall(PetscFree(s->halo[f]));
      PetscCall(PetscMalloc(s->halo_capacity * mpm->points.bytes[f], &s->halo[f]));
    }
  }
  if (s->nhalo + mpm->points.n > s->order_capacity) {
    s->order_capacity = (s->nhalo + mpm->points.n) * 5 / 4 + 64;
    PetscCall(PetscFree(s->order));
    PetscCall(PetscMalloc1(s->order_capacity, &s->order));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* order = own and halo points by (cell, id). A cell's points all come from one process, each process sends its own in
   that order, so this is a counting sort without comparisons.                                                        */
static PetscErrorCode MergeOrder(MPM mpm, MPMSpatial *s)
{
  const MPMPoints *pts    = &mpm->points;
  MPMPatch        *patch  = &mpm->exchange.patch;
  const PetscInt   dim    = mpm->grid.dim, ncells = MPMPatchCells(patch);
  const PetscReal *x      = (const PetscReal *)s->halo[MPM_FIELD_INDEX_x];
  PetscInt        *cell   = (PetscInt *)s->halo[MPM_FIELD_INDEX_cell], at = 0;

  PetscFunctionBeginUser;
  if (!s->start) PetscCall(PetscMalloc1(ncells + 1, &s->start));
  PetscCall(PetscArrayzero(s->start, ncells + 1));
  for (PetscInt p = 0; p < s->nhalo; p++) {
    PetscReal xi[3];
    PetscInt  base[3] = {0};

    (void)MPMLocate((int)dim, mpm->basis, &mpm->grid, x + p * dim, xi, base);
    cell[p] = MPMNodeIndex((int)dim, patch, base);
    s->start[cell[p] + 1]++;
  }
  for (PetscInt c = 0; c < ncells; c++) s->start[c + 1] += s->start[c] + (pts->start[c + 1] - pts->start[c]);
  for (PetscInt c = 0; c < ncells; c++) {
    at = s->start[c];
    for (PetscInt q = pts->start[c]; q < pts->start[c + 1]; q++) s->order[at++] = pts->order[q];
  }
  for (PetscInt p = 0; p < s->nhalo; p++) s->order[s->start[cell[p]]++] = pts->n + p;
  for (PetscInt p = 0; p < s->nhalo; p++) s->start[cell[p]]--;
  MPMPatchMarkRows(patch, s->start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The functions of the table ------------------------------------------------------------------------------------ */

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
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Sweep_Spatial(MPM mpm, const MPMPhase *phase)
{
  MPMExchange   *ex     = &mpm->exchange;
  MPMSpatial    *s      = (MPMSpatial *)ex->ctx;
  MPMPatch      *patch  = &ex->patch;
  const PetscInt fields = phase->points_in | phase->points_out;

  PetscFunctionBeginUser;
  if (phase->kind == MPM_POINTS_TO_NODES && !ex->roundoff) PetscCall(ExchangeFields(mpm, s, phase->points_in & ~MPM_STEADY));
  PetscCall(MPMPointsGetView(&mpm->points, fields, &patch->points));
  PetscCall(PetscMemzero(&patch->halo, sizeof patch->halo));
  patch->halo.n = s->nhalo;
#define MPM_FIELD(name, ctype, ptype, nc, kept, present, unit, meaning) \
  if (fields & MPM_BIT(name)) patch->halo.name = (ctype *)s->halo[MPM_FIELD_INDEX_##name];
#include "fields.def"
#undef MPM_FIELD
  patch->own_order = mpm->points.order;
  patch->order     = ex->roundoff ? mpm->points.order : s->order;
  patch->norder    = mpm->points.n + (ex->roundoff ? 0 : s->nhalo);
  PetscCall(VecGetArray(ex->vel, &patch->vel));
  PetscCall(MPMPatchRun(mpm, patch, phase, &mpm->status));
  PetscCall(VecRestoreArray(ex->vel, &patch->vel));
  PetscCall(MPMPointsRestoreView(&mpm->points, fields, &patch->points));
  if (phase->kind == MPM_POINTS_TO_NODES && ex->roundoff) PetscCall(AddPartialSums(mpm, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Nodes_Spatial(MPM mpm, const MPMPhase *phase)
{
  MPMExchange *ex = &mpm->exchange;

  PetscFunctionBeginUser;
  PetscCall(VecGetArray(ex->vel, &ex->patch.vel));
  PetscCall(MPMPatchRun(mpm, &ex->patch, phase, &mpm->status));
  PetscCall(VecRestoreArray(ex->vel, &ex->patch.vel));
  PetscCall(DMLocalToLocalBegin(ex->da, ex->vel, INSERT_VALUES, ex->vel));
  PetscCall(DMLocalToLocalEnd(ex->da, ex->vel, INSERT_VALUES, ex->vel));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The one reduction of a step; it also carries the fingerprint of the points after the migration before. */
static PetscErrorCode Reduce_Spatial(MPM mpm, MPMStatus *status)
{
  MPMSpatial *s = (MPMSpatial *)mpm->exchange.ctx;

  PetscFunctionBeginUser;
  status->n   = mpm->points.n;
  status->ids = s->ids;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, status, 1, s->status_type, s->status_op, s->comm));
  if (!s->all_ids) s->all_ids = status->ids;
  if (status->n != mpm->points.total || status->ids != s->all_ids) {
    char what[MPM_TEXT_LEN];

    PetscCall(MPMPointsFindLost(&mpm->points, mpm->exchange.data, what, sizeof what));
    SETERRQ(mpm->comm, PETSC_ERR_PLIB, "points got lost or doubled on the way between processes: %" PetscInt64_FMT " of %" PetscInt64_FMT "; %s", status->n, mpm->points.total, what);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Settle_Spatial(MPM mpm, PetscBool anew)
{
  MPMExchange *ex = &mpm->exchange;
  MPMSpatial  *s  = (MPMSpatial *)ex->ctx;

  PetscFunctionBeginUser;
  if (!anew && mpm->status.left) { /* of any process: all migrate or none */
    PetscCall(ex->direct ? MPMMigrateDirect(mpm, s) : MPMMigrateSwarm(mpm, s));
    PetscCall(MPMPointsFingerprint(&mpm->points, &s->ids));
  }
  if (anew) {
    PetscCall(MPMPointsLocate(&mpm->points, &ex->patch));
    PetscCall(MPMPointsFingerprint(&mpm->points, &s->ids));
  } else if (mpm->status.moved) PetscCall(MPMPointsSort(&mpm->points, &ex->patch));
  for (int k = 0; k < s->nto; k++) PetscCall(ListPoints(mpm, &s->to[k]));
  PetscCall(ExchangeCounts(mpm, s));
  PetscCall(ExchangeFields(mpm, s, MPM_STEADY));
  PetscCall(MergeOrder(mpm, s));
  if (ex->roundoff) memset(ex->patch.row, 1, (size_t)(ex->patch.n[1] * ex->patch.n[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Finish_Spatial(MPM mpm)
{
  MPMSpatial *s = (MPMSpatial *)mpm->exchange.ctx;

  PetscFunctionBeginUser;
  PetscCall(TearDownPartition(mpm));
  PetscCall(MPMPartitionDestroy(&mpm->exchange.partition));
  for (int k = 0; k < MPM_MAX_NEIGHBOURS; k++) PetscCall(PetscFree(s->to[k].list));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) PetscCall(PetscFree(s->halo[f]));
  PetscCall(PetscFree(s->out));
  PetscCall(PetscFree(s->in));
  PetscCall(PetscFree(s->order));
  PetscCallMPI(MPI_Op_free(&s->status_op));
  PetscCallMPI(MPI_Type_free(&s->status_type));
  PetscCallMPI(MPI_Comm_free(&s->comm));
  PetscCall(PetscFree(mpm->exchange.ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MPMExchangeType MPMExchange_spatial = {
  "spatial", "spatial decomposition", SetUp_Spatial, Sweep_Spatial, Nodes_Spatial, Reduce_Spatial, Settle_Spatial, Finish_Spatial,
};
