/* pool.c - the worker pool: the master (process 0) holds all particles and the grid, sends jobs to the workers, puts
   their answers together, and finishes the step. Workers keep nothing from job to job.

   In a transfer the master packs for each patch its particles, with the fields that the phase declares, and from nodes
   to particles also the motion of its nodes. A job goes to a worker that has fewer than two, the largest patch first. A
   worker runs the same kernel on its patch and returns the sums of its tiles, or the new fields of its particles, and
   the status that it found, by which the master stops the run if there is an error. Patches are boxes of whole tiles,
   whose sums are the same on every process; the master adds them up to nodes as a serial run does, so results have the
   same bits. */
#include "base/message.h"
#include "base/simulate.h"
#include "kernels/tile_index.h"
#include "parallel/pool.h"
#include <petscbt.h>

#define MPM_JOBS_PER_WORKER 2 /* jobs that a worker has at a time */

/* A patch: a box of the master's tiles. */
typedef struct {
  PetscInt first[3], tiles[3];     /* its first tile and its number of tiles */
  PetscInt own_lo[3], own_n[3], n; /* its own nodes, first and number; n: its particles now */
} PoolPatch;

/* The master's memory for one of the jobs that a worker has. */
typedef struct {
  PetscInt    part;                      /* number of the patch */
  char       *out, *in;                  /* the job, and the answer */
  size_t      out_capacity, in_capacity; /* bytes */
  PetscInt   *list, capacity;            /* [capacity] the particles of the patch */
  MPI_Request sent;
} JobMemory;

typedef struct {
  const MPMExchangeType *inner; /* how the master would run alone: serial, or spatial if a face is periodic */
  MPI_Comm               comm;
  PetscMPIInt            size, rank;
  PetscInt               npatches, *queue; /* [npatches] patches with particles, the largest first */
  PoolPatch             *patches;          /* [npatches] */
  JobMemory             *jobs;             /* [size][MPM_JOBS_PER_WORKER]; those of process 0 are not used */
  MPI_Request           *received;         /* [size][MPM_JOBS_PER_WORKER]; those of process 0 are not used */
} Pool;

/* Loops over the rows of a patch's tiles along x; tile: number of the first of a row among the master's tiles. */
#define FOR_ROWS(all, c, tile)                                                                                         \
  for (PetscInt k = (c)->first[2]; k < (c)->first[2] + (c)->tiles[2]; k++)                                             \
    for (PetscInt j = (c)->first[1], tile = (k * (all)->tiles.n[1] + j) * (all)->tiles.n[0] + (c)->first[0];           \
         j < (c)->first[1] + (c)->tiles[1]; j++, tile += (all)->tiles.n[0])

/* Returns the number of particles of a patch, and lists them by (cell, id) if list is not NULL. */
static PetscInt ListParticles(MPMCore *core, const PoolPatch *c, PetscInt *list)
{
  const MPMPatch *all = &core->exchange.patch;
  const int       dim = (int)core->grid.dim;
  PetscInt        n   = 0;

  FOR_ROWS(all, c, tile)
  for (PetscInt in = 0; in < 1 << all->tiles.bits * (dim - 1); in++) {
    const PetscInt *cell = core->particles.start + MPMTileRowCell(dim, &all->tiles, tile / all->tiles.n[0], in);
    const PetscInt  a = cell[c->first[0] << all->tiles.bits], b = cell[(c->first[0] + c->tiles[0]) << all->tiles.bits];

    for (PetscInt q = a; list && q < b; q++) list[n + q - a] = all->order[q];
    n += b - a;
  }
  return n;
}

/* Returns the number of a patch's tiles that have particles. */
static PetscInt CountTiles(const MPMPatch *all, const PoolPatch *c)
{
  PetscInt n = 0;

  FOR_ROWS(all, c, tile)
  for (PetscInt i = tile; i < tile + c->tiles[0]; i++) n += all->tiles.slot[i] != MPM_TILE_EMPTY;
  return n;
}

static int BiggerFirst(const void *a, const void *b, void *patches)
{
  const PetscInt na = ((PoolPatch *)patches)[*(const PetscInt *)a].n,
                 nb = ((PoolPatch *)patches)[*(const PetscInt *)b].n;

  return na != nb ? (na < nb) - (na > nb) : *(const PetscInt *)a < *(const PetscInt *)b ? -1 : 1;
}

/* Writes the arrays of a view to at, by the number of the field. */
static void Arrays(const MPMView *view, void *at[])
{
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) at[MPM_FIELD_INDEX_##name] = view->name;
#include "physics/fields.def"
}

/* Sends the job for a patch to a worker, and posts the receive of its answer. place: of the slot, which says the
   worker. */
static PetscErrorCode Send(MPMCore *core, Pool *pool, const MPMPhase *phase, PetscInt part, PetscInt place)
{
  const PetscBool   to_nodes = phase->kind == MPM_PARTICLES_TO_NODES;
  const PetscInt    nv       = MPM_MOTION_NC(core->grid.dim);
  const PoolPatch  *c        = &pool->patches[part];
  const PetscMPIInt worker   = (PetscMPIInt)(place / MPM_JOBS_PER_WORKER);
  const MPMPatch   *all      = &core->exchange.patch;
  JobMemory        *slot     = &pool->jobs[place];
  MPMPatch          patch;
  const MPMParams  *par = &core->params;
  MPMJob            job = {.phase  = (PetscInt)(phase - core->phases),
                           .n      = c->n,
                           .dt     = par->dt,
                           .kick   = par->kick,
                           .flip   = par->flip,
                           .push   = par->push,
                           .places = core->grid.places};
  void             *at[MPM_NUM_FIELDS];
  size_t            answer, row;
  PetscMPIInt       len;
  char             *m;

  PetscFunctionBeginUser;
  MPMWorkBegin(&core->timers);
  MPMPoolBox(core, c->own_lo, c->own_n, &patch);
  row = (size_t)(patch.n[0] * nv) * sizeof(PetscReal);
  PetscCall(PetscArraycpy(job.own_lo, c->own_lo, 3));
  PetscCall(PetscArraycpy(job.own_n, c->own_n, 3));
  PetscCall(PetscArraycpy(job.tiles, all->tiles.n, 3));
  PetscCall(PetscArraycpy(job.first, c->first, 3));
  PetscCall(PetscArraycpy(&job.plane[0][0], &par->plane[0][0], 12));
  PetscCall(PetscArraycpy(job.place, core->grid.place, MPM_MAX_COPIES));
  PetscCall(PetscArraycpy(job.low, core->grid.low, MPM_MAX_COPIES));
  PetscCall(PetscArraycpy(job.high, core->grid.high, MPM_MAX_COPIES));
  Arrays(&all->particles, at);
  if (c->n > slot->capacity) {
    slot->capacity = c->n * 5 / 4 + 64;
    PetscCall(PetscFree(slot->list));
    PetscCall(PetscMalloc1(slot->capacity, &slot->list));
  }
  (void)ListParticles(core, c, slot->list);
  PetscCallMPI(MPI_Wait(&slot->sent, MPI_STATUS_IGNORE)); /* this does not wait: its answer is here */
  PetscCall(MPMMessageRoom(&slot->out, &slot->out_capacity,
                           sizeof job + (size_t)c->n * MPMParticlesRowBytes(&core->particles, phase->particles_in) +
                               (size_t)MPMPatchNodes(&patch) * nv * sizeof(PetscReal)));
  memcpy(slot->out, &job, sizeof job);
  m = MPMPoolPack(&core->particles, phase->particles_in, at, c->n, slot->list, slot->out + sizeof job);
  if (MPMPoolReads(phase)) /* the motion of nodes, row by row */
    for (PetscInt k = patch.lo[2]; k < patch.lo[2] + patch.n[2]; k++)
      for (PetscInt j = patch.lo[1]; j < patch.lo[1] + patch.n[1]; j++, m += row)
        memcpy(m,
               all->motion +
                   (((k - all->lo[2]) * all->n[1] + j - all->lo[1]) * all->n[0] + patch.lo[0] - all->lo[0]) * nv,
               row);
  slot->part = part;
  answer     = MPMPoolAnswerBytes(core, phase, c->n, to_nodes ? CountTiles(all, c) : 0);
  PetscCall(MPMMessageLength(answer, &len));
  PetscCall(MPMMessageRoom(&slot->in, &slot->in_capacity, (size_t)len));
  PetscCallMPI(MPI_Irecv(slot->in, len, MPI_BYTE, worker, MPM_TAG_DONE, pool->comm, &pool->received[place]));
  PetscCall(MPMMessageLength((size_t)(m - slot->out), &len));
  MPMSimulateWork("JOB", 1);
  MPMSimulateWork("PACK", (PetscReal)len);
  PetscCallMPI(MPI_Isend(slot->out, len, MPI_BYTE, worker, MPM_TAG_WORK, pool->comm, &slot->sent));
  MPMWorkEnd(&core->timers, phase->timer, NULL, 0);
  core->exchange.jobs++;
  core->exchange.bytes += (PetscReal)len + (PetscReal)answer;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies an answer to the master's data: sums to the tiles, or fields to the particles. */
static PetscErrorCode Assemble(MPMCore *core, Pool *pool, const MPMPhase *phase, PetscInt place)
{
  const JobMemory *slot = &pool->jobs[place];
  const PoolPatch *c    = &pool->patches[slot->part];
  const MPMPatch  *all  = &core->exchange.patch;
  const char      *m    = slot->in + sizeof(MPMStatus);
  void            *at[MPM_NUM_FIELDS];
  MPMStatus        status;

  PetscFunctionBeginUser;
  MPMWorkBegin(&core->timers);
  Arrays(&all->particles, at);
  memcpy(&status, slot->in, sizeof status);
  status.left = 0; /* these left the patch, but not the master */
  MPMStatusMerge(&core->status, &status);
  if (phase->kind == MPM_PARTICLES_TO_NODES) {
    FOR_ROWS(all, c, tile)
    for (PetscInt i = tile; i < tile + c->tiles[0]; i++)
      if (all->tiles.slot[i] >= 0) m += MPMTilesCopy(all, all->tiles.slot[i], phase->parts, PETSC_FALSE, (char *)m);
  } else
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      const size_t b = (size_t)core->particles.bytes[f];

      if (!core->particles.present[f] || !(phase->particles_out & (1 << f))) continue;
      for (PetscInt q = 0; q < c->n; q++, m += b) memcpy((char *)at[f] + (size_t)slot->list[q] * b, m, b);
    }
  MPMWorkEnd(&core->timers, phase->timer, NULL, 0);
  MPMSimulateWork("ASSEMBLE", (PetscReal)(m - slot->in));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the particles of each patch, and queues the patches that have any, the largest first. */
static PetscErrorCode FillQueue(MPMCore *core, Pool *pool, PetscInt *n)
{
  PetscFunctionBeginUser;
  *n = 0;
  for (PetscInt k = 0; k < pool->npatches; k++) {
    pool->patches[k].n = ListParticles(core, &pool->patches[k], NULL);
    if (pool->patches[k].n) pool->queue[(*n)++] = k;
  }
  if (*n > 1) PetscCall(PetscTimSort(*n, pool->queue, sizeof *pool->queue, BiggerFirst, pool->patches));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Sweep_Pool(MPMCore *core, const MPMPhase *phase)
{
  MPMExchange   *ex     = &core->exchange;
  Pool          *pool   = (Pool *)ex->pool;
  const PetscInt places = pool->size * MPM_JOBS_PER_WORKER;
  PetscInt       queued, next = 0, unanswered = 0;
  PetscLogDouble waited = 0, from, t0, t1;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&from));
  PetscCall(MPMExchangeOpen(core, phase));
  PetscCall(FillQueue(core, pool, &queued));
  for (PetscInt depth = 0; depth < MPM_JOBS_PER_WORKER; depth++)
    for (PetscInt w = 1; w < pool->size && next < queued; w++, unanswered++)
      PetscCall(Send(core, pool, phase, pool->queue[next++], w * MPM_JOBS_PER_WORKER + depth));
  for (; unanswered; unanswered--) {
    PetscMPIInt place;

    PetscCall(PetscTime(&t0));
    PetscCallMPI(MPI_Waitany((PetscMPIInt)places, pool->received, &place, MPI_STATUS_IGNORE));
    PetscCall(PetscTime(&t1));
    waited += t1 - t0;
    PetscCall(Assemble(core, pool, phase, place));
    if (next < queued) {
      PetscCall(Send(core, pool, phase, pool->queue[next++], place));
      unanswered++;
    }
  }
  PetscCall(MPMExchangeClose(core, phase));
  if (phase->kind == MPM_PARTICLES_TO_NODES) { /* the sums of all tiles are here: add them up to nodes */
    MPMTilesWrap(&ex->patch);
    PetscCall(MPMExchangeRun(core, phase, MPM_PASS_MAIN));
  }
  PetscCall(PetscTime(&t1));
  ex->busy += t1 - from - waited;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the patches of the master's tiles. */
static PetscErrorCode MakePatches(MPMCore *core, Pool *pool)
{
  const MPMPatch *all  = &core->exchange.patch;
  const PetscInt  tile = MPMTileEdge(core->basis), edge = core->exchange.pool_cells / tile;
  PetscInt        n[3], total                           = 1;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) {
    n[d] = (all->tiles.n[d] - all->tiles.below[d] + edge - 1) / edge;
    total *= n[d];
  }
  PetscCall(PetscMalloc2(total, &pool->patches, total, &pool->queue));
  for (PetscInt k = 0; k < total; k++) {
    const PetscInt ijk[3] = {k % n[0], k / n[0] % n[1], k / (n[0] * n[1])};
    PoolPatch     *c      = &pool->patches[k];

    for (PetscInt d = 0; d < 3; d++) {
      c->first[d]  = all->tiles.below[d] + ijk[d] * edge;
      c->tiles[d]  = PetscMin(edge, all->tiles.n[d] - c->first[d]);
      c->own_lo[d] = all->own_lo[d] + ijk[d] * edge * tile;
      c->own_n[d]  = PetscMin(c->tiles[d] * tile, all->own_lo[d] + all->own_n[d] - c->own_lo[d]);
    }
  }
  pool->npatches = total;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp_Pool(MPMCore *core, const MPMHistogram *h)
{
  MPMExchange *ex = &core->exchange;
  Pool        *pool;
  PetscInt     places;

  PetscFunctionBeginUser;
  (void)h;
  PetscCall(PetscNew(&pool));
  ex->pool = pool;
  PetscCallMPI(MPI_Comm_dup(core->comm, &pool->comm));
  PetscCallMPI(MPI_Comm_size(pool->comm, &pool->size));
  PetscCallMPI(MPI_Comm_rank(pool->comm, &pool->rank));
  if (pool->rank) { /* a worker has memory for field r: the master's particles have it for a time (MPMStepRecover) */
    core->particles.present[MPM_FIELD_INDEX_r] = PETSC_TRUE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ex->data    = PETSC_COMM_SELF;
  pool->inner = core->grid.periodic[0] || core->grid.periodic[1] || core->grid.periodic[2] ? &MPMExchange_spatial
                                                                                           : &MPMExchange_serial;
  PetscCall(pool->inner->setup(core, NULL));
  PetscCall(MakePatches(core, pool));
  places = pool->size * MPM_JOBS_PER_WORKER;
  PetscCall(PetscCalloc1(places, &pool->jobs));
  PetscCall(PetscMalloc1(places, &pool->received));
  for (PetscInt k = 0; k < places; k++) pool->received[k] = pool->jobs[k].sent = MPI_REQUEST_NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in exchange.h. The patches begin where those of SetUp_Pool do. */
PetscErrorCode MPMPoolPatches(const MPMCore *core, PetscInt cells, PetscInt *n)
{
  const MPMTiles *t    = &core->exchange.patch.tiles;
  const PetscInt  edge = cells / MPMTileEdge(core->basis);
  PetscInt        count[3], total = 1;
  PetscBT         filled;

  PetscFunctionBeginUser;
  *n = 0;
  for (PetscInt d = 0; d < 3; d++) {
    count[d] = (t->n[d] - t->below[d] + edge - 1) / edge;
    total *= count[d];
  }
  PetscCall(PetscBTCreate(total, &filled));
  for (PetscInt k = t->below[2]; k < t->n[2]; k++)
    for (PetscInt j = t->below[1]; j < t->n[1]; j++)
      for (PetscInt i = t->below[0]; i < t->n[0]; i++) {
        const PetscInt patch = ((k - t->below[2]) / edge * count[1] + (j - t->below[1]) / edge) * count[0] +
                               (i - t->below[0]) / edge;

        if (t->slot[(k * t->n[1] + j) * t->n[0] + i] != MPM_TILE_EMPTY && !PetscBTLookupSet(filled, patch)) ++*n;
      }
  PetscCall(PetscBTDestroy(&filled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Serve_Pool(MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(MPMPoolServe(core, ((Pool *)core->exchange.pool)->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Nodes_Pool(MPMCore *core, const MPMPhase *phase)
{
  PetscFunctionBeginUser;
  PetscCall(((Pool *)core->exchange.pool)->inner->nodes(core, phase));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reduce_Pool(MPMCore *core, MPMStatus *status)
{
  PetscFunctionBeginUser;
  PetscCall(((Pool *)core->exchange.pool)->inner->reduce(core, status));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Settle_Pool(MPMCore *core, PetscBool anew)
{
  PetscFunctionBeginUser;
  PetscCall(((Pool *)core->exchange.pool)->inner->settle(core, anew));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Renew_Pool(MPMCore *core)
{
  Pool *pool = (Pool *)core->exchange.pool;

  PetscFunctionBeginUser;
  PetscCall(pool->inner->renew(core));
  PetscCall(PetscFree2(pool->patches, pool->queue));
  PetscCall(MakePatches(core, pool));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Finish_Pool(MPMCore *core)
{
  Pool *pool = (Pool *)core->exchange.pool;

  PetscFunctionBeginUser;
  if (!pool->rank) {
    const MPMJob over = {.phase = -1};

    for (PetscMPIInt w = 1; w < pool->size; w++)
      PetscCallMPI(MPI_Send(&over, (PetscMPIInt)sizeof over, MPI_BYTE, w, MPM_TAG_WORK, pool->comm));
    for (PetscInt k = 0; k < pool->size * MPM_JOBS_PER_WORKER; k++) {
      PetscCallMPI(MPI_Wait(&pool->jobs[k].sent, MPI_STATUS_IGNORE));
      PetscCall(PetscFree(pool->jobs[k].out));
      PetscCall(PetscFree(pool->jobs[k].in));
      PetscCall(PetscFree(pool->jobs[k].list));
    }
    PetscCall(PetscFree2(pool->patches, pool->queue));
    PetscCall(PetscFree(pool->jobs));
    PetscCall(PetscFree(pool->received));
    PetscCall(pool->inner->finish(core));
  }
  PetscCallMPI(MPI_Comm_free(&pool->comm));
  PetscCall(PetscFree(core->exchange.pool));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MPMExchangeType MPMExchange_pool = {
    .name       = "pool",
    .setup      = SetUp_Pool,
    .sweep      = Sweep_Pool,
    .nodes      = Nodes_Pool,
    .reduce     = Reduce_Pool,
    .settle     = Settle_Pool,
    .renew      = Renew_Pool,
    .finish     = Finish_Pool,
    .by_workers = PETSC_TRUE,
    .serve      = Serve_Pool,
};
