/* pool_keep.c - the worker pool in which particles stay with the workers (-pool_particles workers), and the master
   (process 0) has the grid. What travels is the sums of tiles and the motion of nodes, which are less than the particles.

   Each tile of the grid has an owner, a worker that keeps all fields of its particles, in their order. The owners are
   chosen so that all workers have nearly as many particles: the tiles, patch by patch (-pool_cells), are a sequence that
   is cut into equal parts. From particles to nodes a worker runs the kernel on all its particles. It adds its tiles
   up to nodes, and returns the sums of the nodes that no tile of another worker touches; for the others it returns the sums
   of its tiles there, which the master adds up in their sequence as a serial run does. So results have the same bits.
   From nodes to particles the master sends each worker the motion of the nodes that its particles read. Particles whose
   new cell is in a tile of another worker come with the answer, and go to that one with the next job. When the numbers
   of particles have become unequal, the sequence is cut anew, and those that have another owner move in the same way.

   To the rest of the program the master's particles look as always: `lent` of MPMParticles. A view that is only read
   gets the fields that have changed from the workers, by the ids of the particles. A view that may be written gets all
   of them back for good; the next transfer hands them out anew. */
#include "base/message.h"
#include "base/simulate.h"
#include "kernels/tile_index.h"
#include "parallel/pool_keep.h"

/* --- Messages ----------------------------------------------------------------------------------------------------- */

/* Adds the ranges of nodes of a worker to its job at *m, and their motion. */
static void PackMotion(const MPMCore *core, const MPMKeepWorker *w, char *begin, MPMKeepJob *job, char **m)
{
  const MPMPatch *patch = &core->exchange.patch;
  const size_t    nv    = (size_t)MPM_MOTION_NC(core->grid.dim);
  MPMKeepRange   *range = (MPMKeepRange *)*m;

  for (PetscInt r = 0; r < patch->n[1] * patch->n[2]; r++) {
    const PetscInt n = w->span[2 * r + 1] - w->span[2 * r];

    if (n <= 0) continue;
    range[job->ranges++] = (MPMKeepRange){r * patch->n[0] + w->span[2 * r], n};
    job->nodes += n;
  }
  *m = MPMKeepAlign(begin, (char *)(range + job->ranges));
  for (PetscInt k = 0; k < job->ranges; k++) {
    const size_t bytes = (size_t)range[k].n * nv * sizeof(PetscReal);

    memcpy(*m, patch->motion + (size_t)range[k].first * nv, bytes);
    *m += bytes;
  }
}

/* Returns the most bytes that a job can have. */
static size_t JobBytes(const MPMCore *core, const MPMKeep *keep, const MPMKeepWorker *w, const MPMKeepJob *job)
{
  const MPMPatch *patch = &core->exchange.patch;
  size_t          bytes = sizeof *job + 16;

  if (job->owners) bytes += (size_t)keep->base.ntiles * sizeof *keep->base.owner;
  if (job->settle) bytes += (size_t)w->n * MPMParticlesRowBytes(&core->particles, job->fields);
  if (job->phase < 0 || core->phases[job->phase].kind != MPM_NODES_TO_PARTICLES) return bytes;
  for (PetscInt r = 0; r < patch->n[1] * patch->n[2]; r++)
    bytes += sizeof(MPMKeepRange) + (size_t)PetscMax(0, w->span[2 * r + 1] - w->span[2 * r]) *
                                        MPM_MOTION_NC(core->grid.dim) * sizeof(PetscReal);
  return bytes;
}

/* Sends a job, whose head says what follows, to a worker. */
static PetscErrorCode Send(MPMCore *core, MPMKeep *keep, PetscMPIInt to, MPMKeepJob job)
{
  MPMKeepWorker *w = &keep->worker[to];
  PetscMPIInt    len;
  char          *m;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Wait(&w->sent, MPI_STATUS_IGNORE)); /* this does not wait: the answer is here */
  PetscCall(MPMMessageRoom(&w->out, &w->out_capacity, JobBytes(core, keep, w, &job)));
  m     = w->out + sizeof job;
  job.n = job.settle ? w->n : 0;
  if (job.owners) {
    memcpy(m, keep->base.owner, (size_t)keep->base.ntiles * sizeof *keep->base.owner);
    m += (size_t)keep->base.ntiles * sizeof *keep->base.owner;
  }
  PetscCall(MPMKeepRows(&core->particles, job.fields, job.n, w->list, PETSC_TRUE, &m));
  if (job.settle) w->n = 0;
  m = MPMKeepAlign(w->out, m);
  if (job.phase >= 0 && core->phases[job.phase].kind == MPM_NODES_TO_PARTICLES) PackMotion(core, w, w->out, &job, &m);
  memcpy(w->out, &job, sizeof job);
  PetscCall(MPMMessageLength((size_t)(m - w->out), &len));
  MPMSimulateWork("JOB", 1);
  MPMSimulateWork("PACK", (PetscReal)len);
  PetscCallMPI(MPI_Isend(w->out, len, MPI_BYTE, to, MPM_TAG_JOB, keep->base.comm, &w->sent));
  core->exchange.jobs++;
  core->exchange.bytes += (PetscReal)len;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Receives the next answer of any worker, and how long it waited for it is added to *waited, s. */
static PetscErrorCode Receive(MPMCore *core, MPMKeep *keep, PetscMPIInt *from, MPMKeepAnswer *answer,
                              PetscLogDouble *waited)
{
  MPI_Status     probed;
  PetscMPIInt    len;
  PetscLogDouble t0, t1;
  MPMKeepWorker *w;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&t0));
  PetscCallMPI(MPI_Probe(MPI_ANY_SOURCE, MPM_TAG_ANSWER, keep->base.comm, &probed));
  PetscCall(PetscTime(&t1));
  *waited += t1 - t0;
  *from = probed.MPI_SOURCE;
  PetscCallMPI(MPI_Get_count(&probed, MPI_BYTE, &len));
  w = &keep->worker[*from];
  PetscCall(MPMMessageRoom(&w->in, &w->in_capacity, (size_t)len));
  PetscCallMPI(MPI_Recv(w->in, len, MPI_BYTE, *from, MPM_TAG_ANSWER, keep->base.comm, MPI_STATUS_IGNORE));
  memcpy(answer, w->in, sizeof *answer);
  MPMSimulateWork("ASSEMBLE", (PetscReal)len);
  core->exchange.bytes += (PetscReal)len;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the n rows of particles with these fields at m, by their ids; their rows here become `list` [n], allocated
   here. */
static PetscErrorCode TakeRows(MPMCore *core, MPMKeep *keep, PetscInt fields, PetscInt n, char *m, PetscInt64 *ids,
                               PetscInt **list)
{
  uint64_t sum = (uint64_t)*ids;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(n, list));
  for (PetscInt q = 0; q < n; q++) { /* the ids come first: they are the first field */
    PetscInt64 id;

    memcpy(&id, m + (size_t)q * sizeof id, sizeof id);
    PetscCheck(id >= 0 && id < core->particles.born && keep->row[id] >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "a worker has particle %" PetscInt64_FMT ", which it was not given", id);
    (*list)[q] = keep->row[id];
    sum += MPMParticleHash(id);
  }
  *ids = (PetscInt64)sum;
  PetscCall(MPMKeepRows(&core->particles, fields, n, *list, PETSC_FALSE, &m));
  PetscFunctionReturn(PETSC_SUCCESS);
}
_Static_assert(MPM_FIELD_INDEX_id == 0, "rows of particles begin with their ids");

/* Takes the particles that leave a worker: the next job brings them to the owners of their new tiles. */
static PetscErrorCode TakeLeavers(MPMCore *core, MPMKeep *keep, PetscMPIInt from, const MPMKeepAnswer *answer)
{
  const MPMTiles *t         = &core->exchange.patch.tiles;
  MPMParticles   *particles = &core->particles;
  PetscInt64      ids       = 0;
  PetscInt       *list, cell, at[3];

  PetscFunctionBeginUser;
  PetscCall(TakeRows(core, keep, MPMKeepFields(particles, PETSC_FALSE), answer->n,
                     keep->worker[from].in + sizeof *answer, &ids, &list));
  for (PetscInt q = 0; q < answer->n; q++) {
    char *m = (char *)&cell;

    PetscCall(MPMKeepRows(particles, MPM_BIT(cell), 1, &list[q], PETSC_TRUE, &m));
    PetscCall(MPMKeepGives(&keep->worker[keep->base.owner[MPMTileOf((int)core->grid.dim, t, cell, at)]], list[q]));
  }
  core->exchange.migrants += answer->n;
  PetscCall(PetscFree(list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Brings fields (bits) of all particles here, as far as those here are old; home: all that are, and the workers have
   none any more. This is `bring` of MPMParticles. */
static PetscErrorCode Bring(void *owner, PetscInt fields, PetscBool home)
{
  MPMCore       *core      = (MPMCore *)owner;
  MPMKeep       *keep      = (MPMKeep *)core->exchange.pool;
  MPMParticles  *particles = &core->particles;
  const PetscInt all = MPMKeepFields(particles, PETSC_TRUE), old = all & ~particles->current & (home ? ~0 : fields);
  MPMKeepJob     job = {.phase = MPM_KEEP_BRING, .fields = old | MPM_BIT(id), .ends = home};
  PetscInt64     n = 0, ids = 0;
  PetscLogDouble waited = 0;

  PetscFunctionBeginUser;
  if (!old && !home) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscMPIInt w = 1; w < keep->base.size; w++) {
    if (home) keep->worker[w].n = 0;
    PetscCall(Send(core, keep, w, job));
  }
  for (PetscMPIInt w = 1; w < keep->base.size; w++) {
    MPMKeepAnswer answer;
    PetscMPIInt   from;
    PetscInt     *list;

    PetscCall(Receive(core, keep, &from, &answer, &waited));
    PetscCall(TakeRows(core, keep, job.fields, answer.n, keep->worker[from].in + sizeof answer, &ids, &list));
    PetscCall(PetscFree(list));
    n += answer.n;
  }
  PetscCheck(n == particles->n && ids == keep->ids, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "workers have %" PetscInt64_FMT " of %" PetscInt_FMT " particles, or others than they were given", n,
             particles->n);
  particles->current |= old;
  if (!home) PetscFunctionReturn(PETSC_SUCCESS);
  particles->lent    = PETSC_FALSE;
  particles->nmovers = -1;
  particles->nkept   = particles->n;
  keep->settle       = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The functions of the table ----------------------------------------------------------------------------------- */

static PetscErrorCode Sweep_Keep(MPMCore *core, const MPMPhase *phase)
{
  MPMExchange    *ex       = &core->exchange;
  MPMKeep        *keep     = (MPMKeep *)ex->pool;
  const PetscBool to_nodes = phase->kind == MPM_PARTICLES_TO_NODES ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool fresh    = core->particles.lent ? PETSC_FALSE : PETSC_TRUE;
  MPMKeepJob      job      = {.phase = (PetscInt)(phase - core->phases),
                              .dt    = core->params.dt,
                              .kick  = core->params.kick,
                              .flip  = core->params.flip,
                              .push  = core->params.push};
  PetscBool       anew     = PETSC_FALSE;
  PetscInt64      n = 0, migrants = ex->migrants;
  PetscLogDouble  waited = 0, t0, t1;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&t0));
  MPMWorkBegin(&core->timers);
  if (fresh)
    PetscCall(MPMKeepHandOut(core, keep, &anew));
  else if (phase->parts & MPM_G2P_COMMIT && !to_nodes)
    PetscCall(MPMKeepRecut(core, keep, &anew));
  MPMWorkEnd(&core->timers, phase->timer, NULL, 0);
  job.owners = anew;
  job.settle = keep->settle;
  job.fields = MPMKeepFields(&core->particles, fresh);
  PetscCall(MPMExchangeOpenNodes(core));
  for (PetscMPIInt w = 1; w < keep->base.size; w++) {
    MPMWorkBegin(&core->timers);
    PetscCall(Send(core, keep, w, job));
    MPMWorkEnd(&core->timers, phase->timer, NULL, 0);
  }
  keep->settle         = PETSC_FALSE;
  core->particles.lent = PETSC_TRUE;
  if (to_nodes) {
    MPMTilesClear(&ex->patch);
    PetscCall(PetscArrayzero(keep->count, keep->base.ntiles));
  }
  for (PetscMPIInt w = 1; w < keep->base.size; w++) {
    MPMKeepAnswer answer;
    PetscMPIInt   from;

    PetscCall(Receive(core, keep, &from, &answer, &waited));
    MPMStatusMerge(&core->status, &answer.status);
    MPMWorkBegin(&core->timers);
    PetscCall(to_nodes ? MPMKeepTakeSums(core, keep, phase, from, &answer, &n)
                       : TakeLeavers(core, keep, from, &answer));
    MPMWorkEnd(&core->timers, phase->timer, NULL, 0);
  }
  core->particles.current &= ~phase->particles_out;
  ex->migrations += ex->migrants > migrants;
  if (to_nodes) {
    PetscCheck(n == core->particles.n, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "workers have %" PetscInt64_FMT " of %" PetscInt_FMT " particles", n, core->particles.n);
    PetscCall(MPMKeepFindSpans(core, keep));
    MPMTilesWrap(&ex->patch);
    PetscCall(PetscMemzero(&ex->patch.particles, sizeof ex->patch.particles));
    PetscCall(MPMPatchRun(core, &ex->patch, phase, MPM_PASS_MAIN, &core->status));
    MPMWorkBegin(&core->timers);
    PetscCall(MPMKeepTakeNodes(core, keep, phase));
    MPMWorkEnd(&core->timers, phase->timer, NULL, 0);
  }
  PetscCall(MPMExchangeCloseNodes(core));
  PetscCall(PetscTime(&t1));
  ex->busy += t1 - t0 - waited;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every process makes the whole grid; on a worker that does not mean that it holds data of the run. */
static PetscErrorCode SetUp_Keep(MPMCore *core, const MPMHistogram *h)
{
  MPMExchange *ex = &core->exchange;
  MPMKeep     *keep;

  PetscFunctionBeginUser;
  (void)h;
  PetscCall(PetscNew(&keep));
  ex->pool = keep;
  PetscCallMPI(MPI_Comm_dup(core->comm, &keep->base.comm));
  PetscCallMPI(MPI_Comm_size(keep->base.comm, &keep->base.size));
  PetscCallMPI(MPI_Comm_rank(keep->base.comm, &keep->base.rank));
  ex->data         = PETSC_COMM_SELF;
  keep->base.inner = core->grid.periodic[0] || core->grid.periodic[1] || core->grid.periodic[2] ? &MPMExchange_spatial
                                                                                                : &MPMExchange_serial;
  PetscCall(keep->base.inner->setup(core, NULL));
  keep->base.ntiles = ex->patch.tiles.n[0] * ex->patch.tiles.n[1] * ex->patch.tiles.n[2];
  PetscCall(PetscCalloc2(keep->base.ntiles, &keep->base.owner, keep->base.ntiles, &keep->base.border));
  PetscCall(PetscMalloc1(MPMPatchNodes(&ex->patch), &keep->base.whose));
  if (keep->base.rank) { /* field r: the master's particles have it for a time (MPMStepRecover) */
    ex->data                                   = MPI_COMM_NULL;
    core->particles.present[MPM_FIELD_INDEX_r] = PETSC_TRUE;
    PetscCall(MPMParticlesCreate(&core->particles, PETSC_COMM_SELF));
    PetscCall(MPMParticlesSetSize(&core->particles, 0));
    for (int k = 0; k < MPM_NUM_PASSES; k++) { /* ranges of any tiles */
      PetscCall(PetscFree(ex->patch.tiles.runs[k]));
      PetscCall(
          PetscMalloc1(keep->base.ntiles << ex->patch.tiles.bits * (core->grid.dim - 1), &ex->patch.tiles.runs[k]));
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  core->particles.bring = Bring;
  core->particles.owner = core;
  PetscCall(PetscCalloc1(keep->base.ntiles, &keep->count));
  PetscCall(MPMKeepSequence(core, keep));
  PetscCall(PetscCalloc1(keep->base.size, &keep->worker));
  for (PetscMPIInt w = 1; w < keep->base.size; w++) {
    keep->worker[w].sent = MPI_REQUEST_NULL;
    PetscCall(PetscMalloc1(2 * ex->patch.n[1] * ex->patch.n[2], &keep->worker[w].span));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Nodes_Keep(MPMCore *core, const MPMPhase *phase)
{
  PetscFunctionBeginUser;
  PetscCall(((MPMKeepBase *)core->exchange.pool)->inner->nodes(core, phase));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reduce_Keep(MPMCore *core, MPMStatus *status)
{
  PetscFunctionBeginUser;
  PetscCall(((MPMKeepBase *)core->exchange.pool)->inner->reduce(core, status));
  status->most = ((MPMKeep *)core->exchange.pool)->most;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lent particles are settled by the workers, with their next job; particles that are here are put in order when they are
   handed out. */
static PetscErrorCode Settle_Keep(MPMCore *core, PetscBool anew)
{
  MPMKeep *keep = (MPMKeep *)core->exchange.pool;

  PetscFunctionBeginUser;
  if (!anew && core->status.bad == MPM_GONE && core->particles.lent) PetscCall(Bring(core, 0, PETSC_TRUE));
  if (anew || core->status.bad == MPM_GONE) PetscCall(keep->base.inner->settle(core, anew));
  if (core->particles.lent) keep->settle = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Finish_Keep(MPMCore *core)
{
  MPMKeep         *keep = (MPMKeep *)core->exchange.pool;
  const MPMKeepJob over = {.phase = MPM_KEEP_OVER};

  PetscFunctionBeginUser;
  core->particles.lent = PETSC_FALSE; /* nobody needs them any more */
  for (PetscMPIInt w = 1; w < keep->base.size && !keep->base.rank; w++) {
    PetscCallMPI(MPI_Wait(&keep->worker[w].sent, MPI_STATUS_IGNORE));
    PetscCallMPI(MPI_Send(&over, (PetscMPIInt)sizeof over, MPI_BYTE, w, MPM_TAG_JOB, keep->base.comm));
    PetscCall(PetscFree(keep->worker[w].list));
    PetscCall(PetscFree(keep->worker[w].span));
    PetscCall(PetscFree(keep->worker[w].out));
    PetscCall(PetscFree(keep->worker[w].in));
  }
  PetscCall(PetscFree(keep->worker));
  PetscCall(PetscFree(keep->sequence));
  PetscCall(PetscFree(keep->count));
  PetscCall(PetscFree(keep->row));
  PetscCall(PetscFree2(keep->base.owner, keep->base.border));
  PetscCall(PetscFree(keep->base.whose));
  PetscCall(keep->base.inner->finish(core));
  PetscCallMPI(MPI_Comm_free(&keep->base.comm));
  PetscCall(PetscFree(core->exchange.pool));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MPMExchangeType MPMExchange_keep = {
    .name       = "pool",
    .what       = "workers keep the particles of patches",
    .setup      = SetUp_Keep,
    .sweep      = Sweep_Keep,
    .nodes      = Nodes_Keep,
    .reduce     = Reduce_Keep,
    .settle     = Settle_Keep,
    .finish     = Finish_Keep,
    .by_workers = PETSC_TRUE,
    .keeps      = PETSC_TRUE,
    .serve      = MPMKeepServe,
};
