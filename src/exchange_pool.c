/* exchange_pool.c - the worker pool: the master (process 0) holds all points and the grid, hands out patches of cells,
   assembles what comes back, and finishes the step; workers hold no state.

   In a sweep the master packs for each patch the points it needs with the fields that the phase declares, and for
   nodes-to-points the node motion too. It sends patches to workers as they become idle, the biggest first, two in
   flight for each. A worker runs the same kernel on its patch and returns the sums of the patch's own nodes, or the
   new fields of its points, and the status it found: an error is data and stops the run at the master.
   A patch gets complete sums of its own nodes from all points that touch them, in the canonical order, so the master
   only copies and the bits are those of the serial run.                                                               */
#include "transfer.h"

#define MPM_IN_FLIGHT 2 /* patches that a worker has at a time */
enum { TAG_WORK = 1, TAG_DONE };

/* What a patch is: the head of both messages. */
typedef struct {
  PetscInt  phase;             /* of the table; < 0: the run is over */
  PetscInt  own_lo[3], own_n[3]; /* its nodes, and cells */
  PetscInt  all_lo[3], all_n[3]; /* the box of the master's arrays, for the numbers of cells */
  PetscInt  n;                 /* points that follow */
  PetscReal dt;
} Order;

typedef struct {
  PetscInt own_lo[3], own_n[3], n; /* n: points to be sent in this sweep */
} Chunk;

/* A place for a patch in flight. */
typedef struct {
  PetscInt    chunk;
  char       *out, *in;
  size_t      out_capacity, in_capacity;
  PetscInt   *list, capacity; /* the points of the chunk */
  MPI_Request sent;
} Slot;

typedef struct {
  const MPMExchangeType *inner; /* how the master would run alone: serial, or its own neighbour if a face is periodic */
  MPI_Comm     comm;
  PetscMPIInt  size, rank;
  PetscInt     nchunks, *queue;
  Chunk       *chunks;
  Slot        *slots;    /* [size][MPM_IN_FLIGHT]; those of process 0 are not used */
  MPI_Request *received; /* likewise */
} Pool;

static PetscErrorCode Grow(char **buffer, size_t *capacity, size_t need)
{
  PetscFunctionBeginUser;
  if (need <= *capacity) PetscFunctionReturn(PETSC_SUCCESS);
  *capacity = need + need / 4 + 4096;
  PetscCall(PetscFree(*buffer));
  PetscCall(PetscMalloc(*capacity, buffer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The box of nodes that a patch with these own nodes needs: what its points' stencils reach. */
static void PatchBox(MPM mpm, const PetscInt own_lo[3], const PetscInt own_n[3], PetscBool to_nodes, MPMPatch *patch)
{
  const PetscInt reach = MPMBasisNodes(mpm->basis) - 1;

  patch->grid  = &mpm->grid;
  patch->basis = mpm->basis;
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt below = d < mpm->grid.dim && to_nodes ? reach : 0, above = d < mpm->grid.dim ? reach : 0;

    patch->own_lo[d] = own_lo[d];
    patch->own_n[d]  = own_n[d];
    patch->lo[d]     = own_lo[d] - below;
    patch->n[d]      = own_n[d] + below + above;
  }
}

/* First and last component of the node sums that these parts make. */
static void SumRange(PetscInt dim, PetscInt parts, PetscInt *c0, PetscInt *c1)
{
  *c0 = parts & MPM_P2G_MASS ? 0 : parts & MPM_P2G_MOMENTUM ? 1 : 1 + dim;
  *c1 = parts & MPM_P2G_FORCE ? MPM_SUM_NC(dim) : 1 + dim;
}

/* Bytes of a point's fields. */
static size_t Bytes(const MPMPoints *pts, PetscInt fields)
{
  size_t bytes = 0;

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (pts->present[f] && (fields & (1 << f))) bytes += (size_t)pts->bytes[f];
  return bytes;
}

/* Size of the answer to a chunk: its status, then node sums or points. */
static size_t AnswerBytes(MPM mpm, const MPMPhase *phase, const PetscInt own_n[3], PetscInt n)
{
  PetscInt c0, c1;

  if (phase->kind == MPM_NODES_TO_POINTS) return sizeof(MPMStatus) + (size_t)n * Bytes(&mpm->points, phase->points_out);
  SumRange(mpm->grid.dim, phase->parts, &c0, &c1);
  return sizeof(MPMStatus) + (size_t)(own_n[0] * own_n[1] * own_n[2] * (c1 - c0)) * sizeof(PetscReal);
}

/* --- The master ---------------------------------------------------------------------------------------------------- */

/* The points that a chunk needs in this sweep: of its own cells, and for sums of the cells below them too. Counts them,
   and lists them in (cell, id) order if list is given.                                                               */
static PetscInt ListPoints(MPM mpm, const Chunk *c, PetscBool to_nodes, PetscInt *list)
{
  const MPMPatch *all   = &mpm->exchange.patch;
  const PetscInt  reach = to_nodes ? MPMBasisNodes(mpm->basis) - 1 : 0;
  PetscInt        lo[3], hi[3], n = 0;

  for (PetscInt d = 0; d < 3; d++) {
    lo[d] = PetscMax(c->own_lo[d] - (d < mpm->grid.dim ? reach : 0), all->lo[d]) - all->lo[d];
    hi[d] = c->own_lo[d] + c->own_n[d] - all->lo[d];
  }
  for (PetscInt k = lo[2]; k < hi[2]; k++)
    for (PetscInt j = lo[1]; j < hi[1]; j++) {
      const PetscInt row = (k * all->n[1] + j) * all->n[0], a = all->start[row + lo[0]], b = all->start[row + hi[0]];

      for (PetscInt q = a; list && q < b; q++) list[n + q - a] = all->order[q];
      n += b - a;
    }
  return n;
}

static int BiggerFirst(const void *a, const void *b, void *chunks)
{
  const PetscInt na = ((Chunk *)chunks)[*(const PetscInt *)a].n, nb = ((Chunk *)chunks)[*(const PetscInt *)b].n;

  return na != nb ? (na < nb) - (na > nb) : *(const PetscInt *)a < *(const PetscInt *)b ? -1 : 1;
}

/* The arrays of a view, by field. */
static void Arrays(const MPMView *view, void *at[])
{
#define MPM_FIELD(name, ctype, ptype, nc, home, present, unit, meaning) at[MPM_FIELD_INDEX_##name] = view->name;
#include "fields.def"
#undef MPM_FIELD
}

/* Packs fields of the listed points, field by field: p < n of `at`, else p - n of `halo`. */
static char *PackFields(const MPMPoints *pts, PetscInt fields, void *const at[], void *const halo[], PetscInt n, PetscInt count, const PetscInt *list, char *message)
{
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const size_t b = (size_t)pts->bytes[f];

    if (!pts->present[f] || !(fields & (1 << f))) continue;
    for (PetscInt q = 0; q < count; q++, message += b) {
      const PetscInt p = list[q];
      memcpy(message, p < n ? (char *)at[f] + (size_t)p * b : (char *)halo[f] + (size_t)(p - n) * b, b);
    }
  }
  return message;
}

/* Sends a chunk to a worker and awaits its answer in the slot. */
static PetscErrorCode Send(MPM mpm, Pool *pool, const MPMPhase *phase, PetscInt chunk, PetscInt place)
{
  const PetscBool   to_nodes = phase->kind == MPM_POINTS_TO_NODES ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt    nv       = MPM_VEL_NC(mpm->grid.dim);
  const Chunk      *c        = &pool->chunks[chunk];
  const PetscMPIInt worker   = (PetscMPIInt)(place / MPM_IN_FLIGHT);
  const MPMPatch   *all      = &mpm->exchange.patch;
  Slot             *slot     = &pool->slots[place];
  MPMPatch          patch;
  Order             order = {MPMPhaseNumber(phase), {0}, {0}, {0}, {0}, c->n, mpm->params.dt};
  void             *at[MPM_NUM_FIELDS], *halo[MPM_NUM_FIELDS];
  PetscMPIInt       len;
  char             *m;

  PetscFunctionBeginUser;
  PatchBox(mpm, c->own_lo, c->own_n, to_nodes, &patch);
  PetscCall(PetscArraycpy(order.own_lo, c->own_lo, 3));
  PetscCall(PetscArraycpy(order.own_n, c->own_n, 3));
  PetscCall(PetscArraycpy(order.all_lo, all->lo, 3));
  PetscCall(PetscArraycpy(order.all_n, all->n, 3));
  Arrays(&all->points, at);
  Arrays(&all->halo, halo);
  if (c->n > slot->capacity) {
    slot->capacity = c->n * 5 / 4 + 64;
    PetscCall(PetscFree(slot->list));
    PetscCall(PetscMalloc1(slot->capacity, &slot->list));
  }
  (void)ListPoints(mpm, c, to_nodes, slot->list);
  PetscCallMPI(MPI_Wait(&slot->sent, MPI_STATUS_IGNORE)); /* answered long ago, so this does not wait */
  PetscCall(Grow(&slot->out, &slot->out_capacity, sizeof order + (size_t)c->n * Bytes(&mpm->points, phase->points_in) + (size_t)MPMPatchCells(&patch) * nv * sizeof(PetscReal)));
  memcpy(slot->out, &order, sizeof order);
  m = PackFields(&mpm->points, phase->points_in, at, halo, all->points.n, c->n, slot->list, slot->out + sizeof order);
  if (!to_nodes) /* node motion, row by row; nodes beyond the grid are never read */
    for (PetscInt k = patch.lo[2]; k < patch.lo[2] + patch.n[2]; k++)
      for (PetscInt j = patch.lo[1]; j < patch.lo[1] + patch.n[1]; j++, m += (size_t)(patch.n[0] * nv) * sizeof(PetscReal)) {
        const PetscInt n = PetscMin(patch.n[0], all->lo[0] + all->n[0] - patch.lo[0]);

        if (k >= all->lo[2] + all->n[2] || j >= all->lo[1] + all->n[1]) continue;
        memcpy(m, all->vel + (((k - all->lo[2]) * all->n[1] + j - all->lo[1]) * all->n[0] + patch.lo[0] - all->lo[0]) * nv, (size_t)(n * nv) * sizeof(PetscReal));
      }
  slot->chunk = chunk;
  PetscCall(PetscMPIIntCast((PetscInt)AnswerBytes(mpm, phase, c->own_n, c->n), &len));
  PetscCall(Grow(&slot->in, &slot->in_capacity, (size_t)len));
  PetscCallMPI(MPI_Irecv(slot->in, len, MPI_BYTE, worker, TAG_DONE, pool->comm, &pool->received[place]));
  PetscCall(PetscMPIIntCast((PetscInt)(m - slot->out), &len));
  PetscCallMPI(MPI_Isend(slot->out, len, MPI_BYTE, worker, TAG_WORK, pool->comm, &slot->sent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts an answer in its place: sums to nodes, fields to points. */
static PetscErrorCode Assemble(MPM mpm, Pool *pool, const MPMPhase *phase, PetscInt place)
{
  const Slot     *slot = &pool->slots[place];
  const Chunk    *c    = &pool->chunks[slot->chunk];
  const MPMPatch *all  = &mpm->exchange.patch;
  const char     *m    = slot->in + sizeof(MPMStatus);
  void           *at[MPM_NUM_FIELDS];
  MPMStatus       status;

  PetscFunctionBeginUser;
  Arrays(&all->points, at);
  memcpy(&status, slot->in, sizeof status);
  MPMStatusMerge(&mpm->status, &status);
  if (phase->kind == MPM_POINTS_TO_NODES) {
    const PetscInt nc = MPM_SUM_NC(mpm->grid.dim);
    PetscInt       c0, c1;

    SumRange(mpm->grid.dim, phase->parts, &c0, &c1);
    for (PetscInt k = c->own_lo[2]; k < c->own_lo[2] + c->own_n[2]; k++)
      for (PetscInt j = c->own_lo[1]; j < c->own_lo[1] + c->own_n[1]; j++)
        for (PetscInt i = c->own_lo[0]; i < c->own_lo[0] + c->own_n[0]; i++, m += (size_t)(c1 - c0) * sizeof(PetscReal))
          memcpy(all->sum + (((k - all->lo[2]) * all->n[1] + j - all->lo[1]) * all->n[0] + i - all->lo[0]) * nc + c0, m, (size_t)(c1 - c0) * sizeof(PetscReal));
  } else
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      const size_t b = (size_t)mpm->points.bytes[f];

      if (!mpm->points.present[f] || !(phase->points_out & (1 << f))) continue;
      for (PetscInt q = 0; q < c->n; q++, m += b) memcpy((char *)at[f] + (size_t)slot->list[q] * b, m, b);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the points of each chunk for this sweep and queues those that have any, the biggest first. */
static PetscErrorCode FillQueue(MPM mpm, Pool *pool, PetscBool to_nodes, PetscInt *n)
{
  PetscFunctionBeginUser;
  *n = 0;
  for (PetscInt k = 0; k < pool->nchunks; k++) {
    pool->chunks[k].n = ListPoints(mpm, &pool->chunks[k], to_nodes, NULL);
    if (pool->chunks[k].n) pool->queue[(*n)++] = k;
  }
  PetscCall(PetscTimSort(*n, pool->queue, sizeof *pool->queue, BiggerFirst, pool->chunks));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Sweep_Pool(MPM mpm, const MPMPhase *phase)
{
  MPMExchange    *ex       = &mpm->exchange;
  Pool           *pool     = (Pool *)ex->farm;
  const PetscInt  fields   = phase->points_in | phase->points_out, places = pool->size * MPM_IN_FLIGHT;
  const PetscBool to_nodes = phase->kind == MPM_POINTS_TO_NODES ? PETSC_TRUE : PETSC_FALSE;
  PetscInt        queued, next = 0, flying = 0;

  PetscFunctionBeginUser;
  PetscCall(pool->inner->prepare(mpm, phase));
  PetscCall(FillQueue(mpm, pool, to_nodes, &queued));
  if (to_nodes) MPMPatchZeroSums(&ex->patch, phase->parts);
  for (PetscInt depth = 0; depth < MPM_IN_FLIGHT; depth++)
    for (PetscInt w = 1; w < pool->size && next < queued; w++, flying++) PetscCall(Send(mpm, pool, phase, pool->queue[next++], w * MPM_IN_FLIGHT + depth));
  for (; flying; flying--) {
    PetscMPIInt place;

    PetscCallMPI(MPI_Waitany((PetscMPIInt)places, pool->received, &place, MPI_STATUS_IGNORE));
    PetscCall(Assemble(mpm, pool, phase, place));
    if (next < queued) {
      PetscCall(Send(mpm, pool, phase, pool->queue[next++], place));
      flying++;
    }
  }
  PetscCall(VecRestoreArray(ex->vel, &ex->patch.vel));
  PetscCall(MPMPointsRestoreView(&mpm->points, fields, &ex->patch.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp_Pool(MPM mpm)
{
  MPMExchange *ex = &mpm->exchange;
  Pool        *pool;
  PetscInt     n[3], total = 1, places;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&pool));
  ex->farm = pool;
  PetscCallMPI(MPI_Comm_dup(mpm->comm, &pool->comm));
  PetscCallMPI(MPI_Comm_size(pool->comm, &pool->size));
  PetscCallMPI(MPI_Comm_rank(pool->comm, &pool->rank));
  if (pool->rank) {
    PetscCall(MPMPointsLayout(mpm, &mpm->points));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ex->data    = PETSC_COMM_SELF;
  pool->inner = mpm->grid.periodic[0] || mpm->grid.periodic[1] || mpm->grid.periodic[2] ? &MPMExchange_spatial : &MPMExchange_serial;
  PetscCall(pool->inner->setup(mpm));
  for (PetscInt d = 0; d < 3; d++) {
    n[d] = (ex->patch.own_n[d] + ex->pool_cells - 1) / ex->pool_cells;
    total *= n[d];
  }
  PetscCall(PetscMalloc2(total, &pool->chunks, total, &pool->queue));
  for (PetscInt k = 0; k < total; k++) {
    const PetscInt ijk[3] = {k % n[0], k / n[0] % n[1], k / (n[0] * n[1])};

    for (PetscInt d = 0; d < 3; d++) {
      pool->chunks[k].own_lo[d] = ex->patch.own_lo[d] + ijk[d] * ex->pool_cells;
      pool->chunks[k].own_n[d]  = PetscMin(ex->pool_cells, ex->patch.own_lo[d] + ex->patch.own_n[d] - pool->chunks[k].own_lo[d]);
    }
  }
  pool->nchunks = total;
  places        = pool->size * MPM_IN_FLIGHT;
  PetscCall(PetscCalloc1(places, &pool->slots));
  PetscCall(PetscMalloc1(places, &pool->received));
  for (PetscInt k = 0; k < places; k++) pool->received[k] = pool->slots[k].sent = MPI_REQUEST_NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The worker ---------------------------------------------------------------------------------------------------- */

typedef struct {
  MPMPatch  patch;
  void     *field[MPM_NUM_FIELDS];
  PetscInt *identity, capacity;
  char     *in, *out, *nodes;
  size_t    in_capacity, out_capacity, nodes_capacity;
} Desk;

/* Makes a patch of what came: points in (cell, id) order, so their order is the identity. */
static PetscErrorCode Unpack(MPM mpm, const MPMPhase *phase, const Order *order, const char *m, Desk *desk)
{
  MPMPatch       *patch    = &desk->patch;
  const MPMPoints *pts     = &mpm->points;
  const PetscBool to_nodes = phase->kind == MPM_POINTS_TO_NODES ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt  fields = phase->points_in | phase->points_out, n = order->n, dim = mpm->grid.dim;
  size_t          sums, vels;

  PetscFunctionBeginUser;
  PatchBox(mpm, order->own_lo, order->own_n, to_nodes, patch);
  if (n > desk->capacity) {
    desk->capacity = n * 5 / 4 + 64;
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      if (!pts->present[f]) continue;
      PetscCall(PetscFree(desk->field[f]));
      PetscCall(PetscMalloc(desk->capacity * pts->bytes[f], &desk->field[f]));
    }
    PetscCall(PetscFree(desk->identity));
    PetscCall(PetscMalloc1(desk->capacity, &desk->identity));
    for (PetscInt p = 0; p < desk->capacity; p++) desk->identity[p] = p;
  }
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    if (!pts->present[f] || !(phase->points_in & (1 << f))) continue;
    memcpy(desk->field[f], m, (size_t)n * (size_t)pts->bytes[f]);
    m += (size_t)n * (size_t)pts->bytes[f];
  }
  PetscCall(PetscMemzero(&patch->points, sizeof patch->points));
  PetscCall(PetscMemzero(&patch->halo, sizeof patch->halo));
  patch->points.n = patch->norder = n;
  patch->order = patch->own_order = desk->identity;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, unit, meaning) \
  if (fields & MPM_BIT(name)) patch->points.name = (ctype *)desk->field[MPM_FIELD_INDEX_##name];
#include "fields.def"
#undef MPM_FIELD
  sums = (size_t)MPMPatchCells(patch) * MPM_SUM_NC(dim) * sizeof(PetscReal);
  vels = (size_t)MPMPatchCells(patch) * MPM_VEL_NC(dim) * sizeof(PetscReal);
  PetscCall(Grow(&desk->nodes, &desk->nodes_capacity, sums + vels + (size_t)(patch->n[1] * patch->n[2])));
  patch->sum = (PetscReal *)desk->nodes;
  patch->vel = (PetscReal *)(desk->nodes + sums);
  patch->row = desk->nodes + sums + vels;
  memset(patch->row, 1, (size_t)(patch->n[1] * patch->n[2]));
  if (!to_nodes) memcpy(patch->vel, m, vels);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The cells that the kernel found are those of the patch; the master numbers them over its own arrays. */
static void RenumberCells(MPM mpm, const Order *order, MPMPatch *patch)
{
  const PetscInt dim = mpm->grid.dim;
  MPMPatch       all;

  for (PetscInt d = 0; d < 3; d++) {
    all.lo[d] = order->all_lo[d];
    all.n[d]  = order->all_n[d];
  }
  for (PetscInt p = 0; p < patch->points.n; p++) {
    PetscReal xi[3];
    PetscInt  base[3] = {0};

    patch->points.cell[p] = MPMLocate((int)dim, mpm->basis, &mpm->grid, patch->points.x + p * dim, xi, base) ? MPMNodeIndex((int)dim, &all, base) : -1;
  }
}

/* Packs the answer; returns its end. */
static char *PackAnswer(MPM mpm, const MPMPhase *phase, const MPMStatus *status, const Desk *desk, char *m)
{
  const MPMPatch *patch = &desk->patch;
  const PetscInt  nc    = MPM_SUM_NC(mpm->grid.dim);
  PetscInt        c0, c1;

  memcpy(m, status, sizeof *status);
  m += sizeof *status;
  if (phase->kind == MPM_NODES_TO_POINTS) return PackFields(&mpm->points, phase->points_out, desk->field, NULL, patch->points.n, patch->points.n, desk->identity, m);
  SumRange(mpm->grid.dim, phase->parts, &c0, &c1);
  for (PetscInt k = patch->own_lo[2]; k < patch->own_lo[2] + patch->own_n[2]; k++)
    for (PetscInt j = patch->own_lo[1]; j < patch->own_lo[1] + patch->own_n[1]; j++)
      for (PetscInt i = patch->own_lo[0]; i < patch->own_lo[0] + patch->own_n[0]; i++, m += (size_t)(c1 - c0) * sizeof(PetscReal))
        memcpy(m, patch->sum + (((k - patch->lo[2]) * patch->n[1] + j - patch->lo[1]) * patch->n[0] + i - patch->lo[0]) * nc + c0, (size_t)(c1 - c0) * sizeof(PetscReal));
  return m;
}

/* A worker's life: receive a patch, run the phase, answer; until the master says that the run is over. */
static PetscErrorCode Serve_Pool(MPM mpm)
{
  Pool       *pool   = (Pool *)mpm->exchange.farm;
  Desk        desk   = {0};
  MPI_Request answer = MPI_REQUEST_NULL;

  PetscFunctionBeginUser;
  for (;;) {
    MPI_Status      probed;
    PetscMPIInt     len;
    Order           order;
    const MPMPhase *phase;
    MPMStatus       status;

    PetscCallMPI(MPI_Probe(0, TAG_WORK, pool->comm, &probed));
    PetscCallMPI(MPI_Get_count(&probed, MPI_BYTE, &len));
    PetscCall(Grow(&desk.in, &desk.in_capacity, (size_t)len));
    PetscCallMPI(MPI_Recv(desk.in, len, MPI_BYTE, 0, TAG_WORK, pool->comm, MPI_STATUS_IGNORE));
    memcpy(&order, desk.in, sizeof order);
    if (order.phase < 0) break;
    phase          = MPMPhaseGet(order.phase);
    mpm->params.dt = order.dt;
    PetscCall(MPMPhaseBegin(mpm, phase));
    PetscCall(Unpack(mpm, phase, &order, desk.in + sizeof order, &desk));
    MPMStatusReset(&status);
    PetscCall(MPMPatchRun(mpm, &desk.patch, phase, &status));
    if (phase->points_out & MPM_BIT(cell)) RenumberCells(mpm, &order, &desk.patch);
    PetscCallMPI(MPI_Wait(&answer, MPI_STATUS_IGNORE));
    PetscCall(Grow(&desk.out, &desk.out_capacity, AnswerBytes(mpm, phase, order.own_n, order.n)));
    len = (PetscMPIInt)(PackAnswer(mpm, phase, &status, &desk, desk.out) - desk.out);
    PetscCallMPI(MPI_Isend(desk.out, len, MPI_BYTE, 0, TAG_DONE, pool->comm, &answer));
    PetscCall(MPMPhaseEnd(mpm, phase, order.n));
  }
  PetscCallMPI(MPI_Wait(&answer, MPI_STATUS_IGNORE));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) PetscCall(PetscFree(desk.field[f]));
  PetscCall(PetscFree(desk.identity));
  PetscCall(PetscFree(desk.in));
  PetscCall(PetscFree(desk.out));
  PetscCall(PetscFree(desk.nodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Nodes_Pool(MPM mpm, const MPMPhase *phase)
{
  PetscFunctionBeginUser;
  PetscCall(((Pool *)mpm->exchange.farm)->inner->nodes(mpm, phase));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reduce_Pool(MPM mpm, MPMStatus *status)
{
  PetscFunctionBeginUser;
  PetscCall(((Pool *)mpm->exchange.farm)->inner->reduce(mpm, status));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Settle_Pool(MPM mpm, PetscBool anew)
{
  PetscFunctionBeginUser;
  PetscCall(((Pool *)mpm->exchange.farm)->inner->settle(mpm, anew));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Finish_Pool(MPM mpm)
{
  Pool *pool = (Pool *)mpm->exchange.farm;

  PetscFunctionBeginUser;
  if (!pool->rank) {
    const Order over = {-1, {0}, {0}, {0}, {0}, 0, 0};

    for (PetscMPIInt w = 1; w < pool->size; w++) PetscCallMPI(MPI_Send(&over, (PetscMPIInt)sizeof over, MPI_BYTE, w, TAG_WORK, pool->comm));
    for (PetscInt k = 0; k < pool->size * MPM_IN_FLIGHT; k++) {
      PetscCallMPI(MPI_Wait(&pool->slots[k].sent, MPI_STATUS_IGNORE));
      PetscCall(PetscFree(pool->slots[k].out));
      PetscCall(PetscFree(pool->slots[k].in));
      PetscCall(PetscFree(pool->slots[k].list));
    }
    PetscCall(PetscFree2(pool->chunks, pool->queue));
    PetscCall(PetscFree(pool->slots));
    PetscCall(PetscFree(pool->received));
    PetscCall(pool->inner->finish(mpm));
  }
  PetscCallMPI(MPI_Comm_free(&pool->comm));
  PetscCall(PetscFree(mpm->exchange.farm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MPMExchangeType MPMExchange_pool = {
  "pool", "a master hands patches to workers", SetUp_Pool, Sweep_Pool, Nodes_Pool, Reduce_Pool, Settle_Pool, Finish_Pool, NULL, PETSC_TRUE, Serve_Pool,
};
