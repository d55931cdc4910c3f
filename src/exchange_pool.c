/* exchange_pool.c - the worker pool: the master (process 0) holds all particles and the grid, hands out patches of
   cells, assembles what comes back, and finishes the step; workers hold no state.

   In a sweep the master packs for each patch its particles with the fields that the phase declares, and for
   nodes-to-particles the node motion too. It sends patches to workers as they become idle, the biggest first, two in
   flight for each. A worker runs the same kernel on its patch and returns the sums of its tiles, or the new fields of
   its particles, and the status it found: an error is data and stops the run at the master. Patches are boxes of whole
   tiles, whose sums do not depend on who makes them; the master adds them up to nodes as the serial run does: hence its
   bits. */
#include "tiles.h"
#include "exchange_pool.h"

#define MPM_IN_FLIGHT 2 /* patches that a worker has at a time */

/* A patch of the tiling. */
typedef struct {
  PetscInt first[3], tiles[3];     /* its tiles of the master's table */
  PetscInt own_lo[3], own_n[3], n; /* n: its particles now */
} Chunk;

/* A place for a patch in flight. */
typedef struct {
  PetscInt    chunk;
  char       *out, *in;
  size_t      out_capacity, in_capacity;
  PetscInt   *list, capacity; /* the particles of the chunk */
  MPI_Request sent;
} Slot;

typedef struct {
  const MPMExchangeType *inner; /* how the master would run alone: serial, or its own neighbour if a face is periodic */
  MPI_Comm               comm;
  PetscMPIInt            size, rank;
  PetscInt               nchunks, *queue;
  Chunk                 *chunks;
  Slot                  *slots;    /* [size][MPM_IN_FLIGHT]; those of process 0 are not used */
  MPI_Request           *received; /* likewise */
} Pool;

/* Goes through the rows of a chunk's tiles: the number of the first, in the table. */
#define FOR_ROWS(all, c, tile)                                                                                         \
  for (PetscInt k = (c)->first[2]; k < (c)->first[2] + (c)->tiles[2]; k++)                                             \
    for (PetscInt j = (c)->first[1], tile = (k * (all)->tiles.n[1] + j) * (all)->tiles.n[0] + (c)->first[0];           \
         j < (c)->first[1] + (c)->tiles[1]; j++, tile += (all)->tiles.n[0])

/* The particles of a chunk: counts them, and lists them in (cell, id) order if list is given. */
static PetscInt ListParticles(MPM mpm, const Chunk *c, PetscInt *list)
{
  const MPMPatch *all = &mpm->exchange.patch;
  const int       dim = (int)mpm->grid.dim;
  PetscInt        n   = 0;

  FOR_ROWS(all, c, tile)
  for (PetscInt in = 0; in < 1 << all->tiles.bits * (dim - 1); in++) {
    const PetscInt *cell = mpm->particles.start + MPMTileRowCell(dim, &all->tiles, tile / all->tiles.n[0], in);
    const PetscInt  a = cell[c->first[0] << all->tiles.bits], b = cell[(c->first[0] + c->tiles[0]) << all->tiles.bits];

    for (PetscInt q = a; list && q < b; q++) list[n + q - a] = all->order[q];
    n += b - a;
  }
  return n;
}

/* Those of its tiles that have particles. */
static PetscInt CountTiles(const MPMPatch *all, const Chunk *c)
{
  PetscInt n = 0;

  FOR_ROWS(all, c, tile)
  for (PetscInt i = tile; i < tile + c->tiles[0]; i++) n += all->tiles.slot[i] != MPM_TILE_EMPTY;
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
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) at[MPM_FIELD_INDEX_##name] = view->name;
#include "fields.def"
#undef MPM_FIELD
}

/* Sends a chunk to a worker and awaits its answer in the slot. */
static PetscErrorCode Send(MPM mpm, Pool *pool, const MPMPhase *phase, PetscInt chunk, PetscInt place)
{
  const PetscBool   to_nodes = phase->kind == MPM_PARTICLES_TO_NODES ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt    nv       = MPM_VEL_NC(mpm->grid.dim);
  const Chunk      *c        = &pool->chunks[chunk];
  const PetscMPIInt worker   = (PetscMPIInt)(place / MPM_IN_FLIGHT);
  const MPMPatch   *all      = &mpm->exchange.patch;
  Slot             *slot     = &pool->slots[place];
  MPMPatch          patch;
  MPMJob            order = {(PetscInt)(phase - mpm->phases), {0}, {0}, {0}, {0}, c->n, mpm->params.dt};
  void             *at[MPM_NUM_FIELDS];
  size_t            answer, row;
  PetscMPIInt       len;
  char             *m;

  PetscFunctionBeginUser;
  MPMWorkBegin(mpm);
  MPMPoolBox(mpm, c->own_lo, c->own_n, &patch);
  row = (size_t)(patch.n[0] * nv) * sizeof(PetscReal);
  PetscCall(PetscArraycpy(order.own_lo, c->own_lo, 3));
  PetscCall(PetscArraycpy(order.own_n, c->own_n, 3));
  PetscCall(PetscArraycpy(order.tiles, all->tiles.n, 3));
  PetscCall(PetscArraycpy(order.first, c->first, 3));
  Arrays(&all->particles, at);
  if (c->n > slot->capacity) {
    slot->capacity = c->n * 5 / 4 + 64;
    PetscCall(PetscFree(slot->list));
    PetscCall(PetscMalloc1(slot->capacity, &slot->list));
  }
  (void)ListParticles(mpm, c, slot->list);
  PetscCallMPI(MPI_Wait(&slot->sent, MPI_STATUS_IGNORE)); /* answered long ago, so this does not wait */
  PetscCall(MPMMessageRoom(&slot->out, &slot->out_capacity,
                           sizeof order + (size_t)c->n * MPMParticlesRowBytes(&mpm->particles, phase->particles_in) +
                               (size_t)MPMPatchNodes(&patch) * nv * sizeof(PetscReal)));
  memcpy(slot->out, &order, sizeof order);
  m = MPMPoolPack(&mpm->particles, phase->particles_in, at, c->n, slot->list, slot->out + sizeof order);
  if (!to_nodes) /* node motion, row by row */
    for (PetscInt k = patch.lo[2]; k < patch.lo[2] + patch.n[2]; k++)
      for (PetscInt j = patch.lo[1]; j < patch.lo[1] + patch.n[1]; j++, m += row)
        memcpy(m,
               all->vel + (((k - all->lo[2]) * all->n[1] + j - all->lo[1]) * all->n[0] + patch.lo[0] - all->lo[0]) * nv,
               row);
  slot->chunk = chunk;
  answer      = MPMPoolAnswerBytes(mpm, phase, c->n, to_nodes ? CountTiles(all, c) : 0);
  PetscCall(MPMMessageLength(answer, &len));
  PetscCall(MPMMessageRoom(&slot->in, &slot->in_capacity, (size_t)len));
  PetscCallMPI(MPI_Irecv(slot->in, len, MPI_BYTE, worker, MPM_TAG_DONE, pool->comm, &pool->received[place]));
  PetscCall(MPMMessageLength((size_t)(m - slot->out), &len));
  MPMSimulateWork("CHUNK", 1);
  MPMSimulateWork("PACK", (PetscReal)len);
  PetscCallMPI(MPI_Isend(slot->out, len, MPI_BYTE, worker, MPM_TAG_WORK, pool->comm, &slot->sent));
  MPMWorkEnd(mpm, (PetscInt)(phase - mpm->phases));
  mpm->exchange.chunks++;
  mpm->exchange.bytes += (PetscReal)len + (PetscReal)answer;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts an answer in its place: sums to tiles, fields to particles. */
static PetscErrorCode Assemble(MPM mpm, Pool *pool, const MPMPhase *phase, PetscInt place)
{
  const Slot     *slot = &pool->slots[place];
  const Chunk    *c    = &pool->chunks[slot->chunk];
  const MPMPatch *all  = &mpm->exchange.patch;
  const char     *m    = slot->in + sizeof(MPMStatus);
  void           *at[MPM_NUM_FIELDS];
  MPMStatus       status;

  PetscFunctionBeginUser;
  MPMWorkBegin(mpm);
  Arrays(&all->particles, at);
  memcpy(&status, slot->in, sizeof status);
  status.left = 0; /* of the patch: the master has them all */
  MPMStatusMerge(&mpm->status, &status);
  if (phase->kind == MPM_PARTICLES_TO_NODES) {
    FOR_ROWS(all, c, tile)
    for (PetscInt i = tile; i < tile + c->tiles[0]; i++)
      if (all->tiles.slot[i] >= 0) m += MPMTilesCopy(all, all->tiles.slot[i], phase->parts, PETSC_FALSE, (char *)m);
  } else
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      const size_t b = (size_t)mpm->particles.bytes[f];

      if (!mpm->particles.present[f] || !(phase->particles_out & (1 << f))) continue;
      for (PetscInt q = 0; q < c->n; q++, m += b) memcpy((char *)at[f] + (size_t)slot->list[q] * b, m, b);
    }
  MPMWorkEnd(mpm, (PetscInt)(phase - mpm->phases));
  MPMSimulateWork("ASSEMBLE", (PetscReal)(m - slot->in));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the particles of each chunk for this sweep and queues those that have any, the biggest first. */
static PetscErrorCode FillQueue(MPM mpm, Pool *pool, PetscInt *n)
{
  PetscFunctionBeginUser;
  *n = 0;
  for (PetscInt k = 0; k < pool->nchunks; k++) {
    pool->chunks[k].n = ListParticles(mpm, &pool->chunks[k], NULL);
    if (pool->chunks[k].n) pool->queue[(*n)++] = k;
  }
  PetscCall(PetscTimSort(*n, pool->queue, sizeof *pool->queue, BiggerFirst, pool->chunks));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Sweep_Pool(MPM mpm, const MPMPhase *phase)
{
  MPMExchange   *ex     = &mpm->exchange;
  Pool          *pool   = (Pool *)ex->farm;
  const PetscInt places = pool->size * MPM_IN_FLIGHT;
  PetscInt       queued, next = 0, flying = 0;
  PetscLogDouble waited = 0, from, t0, t1;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&from));
  PetscCall(MPMExchangeOpen(mpm, phase));
  PetscCall(FillQueue(mpm, pool, &queued));
  for (PetscInt depth = 0; depth < MPM_IN_FLIGHT; depth++)
    for (PetscInt w = 1; w < pool->size && next < queued; w++, flying++)
      PetscCall(Send(mpm, pool, phase, pool->queue[next++], w * MPM_IN_FLIGHT + depth));
  for (; flying; flying--) {
    PetscMPIInt place;

    PetscCall(PetscTime(&t0));
    PetscCallMPI(MPI_Waitany((PetscMPIInt)places, pool->received, &place, MPI_STATUS_IGNORE));
    PetscCall(PetscTime(&t1));
    waited += t1 - t0;
    PetscCall(Assemble(mpm, pool, phase, place));
    if (next < queued) {
      PetscCall(Send(mpm, pool, phase, pool->queue[next++], place));
      flying++;
    }
  }
  PetscCall(MPMExchangeClose(mpm, phase));
  if (phase->kind == MPM_PARTICLES_TO_NODES) { /* all tiles are kept */
    MPMTilesWrap(&ex->patch);
    PetscCall(MPMExchangeRun(mpm, phase, MPM_PASS_MAIN));
  }
  PetscCall(PetscTime(&t1));
  ex->busy += t1 - from - waited;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp_Pool(MPM mpm)
{
  MPMExchange *ex = &mpm->exchange;
  Pool        *pool;
  PetscInt     n[3], total = 1, places, tile = MPMTileEdge(mpm->basis), edge = ex->pool_cells / tile;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&pool));
  ex->farm = pool;
  PetscCallMPI(MPI_Comm_dup(mpm->comm, &pool->comm));
  PetscCallMPI(MPI_Comm_size(pool->comm, &pool->size));
  PetscCallMPI(MPI_Comm_rank(pool->comm, &pool->rank));
  if (pool->rank) {
    PetscCall(MPMParticlesLayout(mpm, &mpm->particles));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ex->data    = PETSC_COMM_SELF;
  pool->inner = mpm->grid.periodic[0] || mpm->grid.periodic[1] || mpm->grid.periodic[2] ? &MPMExchange_spatial
                                                                                        : &MPMExchange_serial;
  PetscCall(pool->inner->setup(mpm));
  for (PetscInt d = 0; d < 3; d++) {
    n[d] = (ex->patch.tiles.n[d] - ex->patch.tiles.below[d] + edge - 1) / edge;
    total *= n[d];
  }
  PetscCall(PetscMalloc2(total, &pool->chunks, total, &pool->queue));
  for (PetscInt k = 0; k < total; k++) {
    const PetscInt ijk[3] = {k % n[0], k / n[0] % n[1], k / (n[0] * n[1])};
    Chunk         *c      = &pool->chunks[k];

    for (PetscInt d = 0; d < 3; d++) {
      c->first[d]  = ex->patch.tiles.below[d] + ijk[d] * edge;
      c->tiles[d]  = PetscMin(edge, ex->patch.tiles.n[d] - c->first[d]);
      c->own_lo[d] = ex->patch.own_lo[d] + ijk[d] * edge * tile;
      c->own_n[d]  = PetscMin(c->tiles[d] * tile, ex->patch.own_lo[d] + ex->patch.own_n[d] - c->own_lo[d]);
    }
  }
  pool->nchunks = total;
  places        = pool->size * MPM_IN_FLIGHT;
  PetscCall(PetscCalloc1(places, &pool->slots));
  PetscCall(PetscMalloc1(places, &pool->received));
  for (PetscInt k = 0; k < places; k++) pool->received[k] = pool->slots[k].sent = MPI_REQUEST_NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Serve_Pool(MPM mpm)
{
  PetscFunctionBeginUser;
  PetscCall(MPMPoolServe(mpm, ((Pool *)mpm->exchange.farm)->comm));
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
    const MPMJob over = {-1, {0}, {0}, {0}, {0}, 0, 0};

    for (PetscMPIInt w = 1; w < pool->size; w++)
      PetscCallMPI(MPI_Send(&over, (PetscMPIInt)sizeof over, MPI_BYTE, w, MPM_TAG_WORK, pool->comm));
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
    "pool",      "a master hands out patches",
    SetUp_Pool,  Sweep_Pool,
    Nodes_Pool,  Reduce_Pool,
    Settle_Pool, Finish_Pool,
    PETSC_TRUE,  Serve_Pool,
    NULL,
};
