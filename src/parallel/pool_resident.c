/* pool_resident.c - a worker of the pool that keeps its particles (-pool_particles workers): it has the whole grid, of
   which it uses the tiles that it owns, and the particles of these tiles, in the order by (cell, id). Cells and tiles are
   numbered as on the master. pool_keep.c has the overview.

   A step is settled when its next job comes: particles whose tile another worker owns are dropped (the master has had
   their rows since the last answer), those that come take their places, and the order is made anew. */
#include "base/message.h"
#include "base/signals.h"
#include "base/simulate.h"
#include "kernels/tile_index.h"
#include "parallel/pool_keep.h"

PetscInt MPMKeepFields(const MPMParticles *particles, PetscBool scratch)
{
  PetscInt fields = 0;

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && (scratch || MPMFields[f].home != MPM_SCRATCH)) fields |= 1 << f;
  return fields;
}

/* Copies rows of a field, those listed or the first n, to a message or from it. */
MPM_INLINE void CopyRows(size_t bytes, PetscInt n, const PetscInt *list, char *rows, PetscBool pack, char *message)
{
  for (PetscInt q = 0; q < n; q++) {
    char *row = rows + (size_t)list[q] * bytes, *packed = message + (size_t)q * bytes;

    if (pack)
      memcpy(packed, row, bytes);
    else
      memcpy(row, packed, bytes);
  }
}

PetscErrorCode MPMKeepRows(MPMParticles *particles, PetscInt fields, PetscInt n, const PetscInt *list, PetscBool pack,
                           char **message)
{
  const PetscBool lent = particles->lent;

  PetscFunctionBeginUser;
  particles->lent = PETSC_FALSE; /* nothing is brought for this */
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const size_t bytes = (size_t)particles->bytes[f], all = bytes * (size_t)n;
    char        *rows;

    if (!(fields & (1 << f)) || !n) continue;
    PetscCall(MPMParticlesGetField(particles, f, (void **)&rows));
    if (list)
      MPM_FOR_WIDTH(bytes, CopyRows, n, list, rows, pack, *message);
    else
      memcpy(pack ? *message : rows, pack ? rows : *message, all);
    PetscCall(MPMParticlesRestoreField(particles, f));
    *message += all;
  }
  particles->lent = lent;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A worker's memory. */
typedef struct {
  char     *in, *out;                  /* job and answer */
  size_t    in_capacity, out_capacity; /* bytes */
  PetscInt *leaver, nleavers;          /* [nleavers] particles whose tile another worker owns, ascending */
  PetscBool borders;                   /* the owners of tiles are new */
} Memory;

/* Returns whether a worker, not this one, owns the tile of a cell. */
static PetscBool Leaves(const MPMCore *core, PetscInt cell)
{
  const MPMKeepBase *base = (const MPMKeepBase *)core->exchange.pool;
  PetscInt           at[3];

  if (cell < 0) return PETSC_FALSE; /* it left the grid */
  return base->owner[MPMTileOf((int)core->grid.dim, &core->exchange.patch.tiles, cell, at)] != base->rank;
}

/* Lists the particles that leave after a step: of the movers, or of all if the owners are new. */
static PetscErrorCode FindLeavers(MPMCore *core, PetscBool all, Memory *memory)
{
  MPMParticles *particles = &core->particles;
  PetscInt      n         = 0, candidates;
  MPMView       view;

  PetscFunctionBeginUser;
  if (all) particles->nmovers = -1; /* not only movers leave their places */
  candidates = all ? particles->n : particles->nmovers;
  PetscCall(PetscFree(memory->leaver));
  PetscCall(PetscMalloc1(candidates, &memory->leaver));
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(cell), &view));
  for (PetscInt k = 0; k < candidates; k++) {
    const PetscInt m = all ? 0 : particles->movers[k], p = all ? k : particles->order[m < 0 ? MPM_FLAGGED(m) : m];

    if (Leaves(core, view.cell[p])) memory->leaver[n++] = p;
  }
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(cell), &view));
  PetscCall(PetscSortInt(n, memory->leaver));
  memory->nleavers = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Drops the leavers, and takes the `come` particles whose rows are at *m. These take the places of leavers, then those
   at the end; if they are fewer, the last particles move into the places that stay free. */
static PetscErrorCode TakeArrivals(MPMCore *core, PetscInt fields, PetscInt come, Memory *memory, char **m)
{
  MPMParticles  *particles = &core->particles;
  const PetscInt n = particles->n, left = memory->nleavers;
  PetscInt      *place;
  char           row[MPM_NUM_FIELDS * MPM_ROW_BYTES], *at;

  PetscFunctionBeginUser;
  if (n) particles->room = PetscMax(particles->room, come);
  if (come > left) PetscCall(MPMParticlesSetSize(particles, n + come - left));
  PetscCall(PetscMalloc1(come, &place));
  for (PetscInt q = 0; q < come; q++) place[q] = q < left ? memory->leaver[q] : n + q - left;
  PetscCall(MPMKeepRows(particles, fields, come, place, PETSC_FALSE, m));
  PetscCall(PetscFree(place));
  for (PetscInt q = left; q > come; q--) { /* the last such place first */
    const PetscInt hole = memory->leaver[q - 1], last = n - 1 - (left - q);

    if (hole == last) continue;
    at = row;
    PetscCall(MPMKeepRows(particles, MPMKeepFields(particles, PETSC_TRUE), 1, &last, PETSC_TRUE, &at));
    at = row;
    PetscCall(MPMKeepRows(particles, MPMKeepFields(particles, PETSC_TRUE), 1, &hole, PETSC_FALSE, &at));
  }
  if (come < left) PetscCall(MPMParticlesSetSize(particles, n + come - left));
  particles->nkept = n - left;
  if (4 * (come + left) > n) { /* then a new sort is as fast */
    particles->nmovers   = -1;
    particles->scattered = PETSC_MAX_REAL;
  }
  memory->nleavers = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Settles the last step. timer: that this work counts for, but the sort. */
static PetscErrorCode Settle(MPMCore *core, const MPMKeepJob *job, PetscInt timer, Memory *memory, char **m)
{
  MPMParticles *particles = &core->particles;

  PetscFunctionBeginUser;
  if (!memory->nleavers && !job->n && !particles->nmovers && !memory->borders) PetscFunctionReturn(PETSC_SUCCESS);
  MPMWorkBegin(&core->timers);
  if (memory->nleavers || job->n) PetscCall(TakeArrivals(core, job->fields, job->n, memory, m));
  MPMWorkEnd(&core->timers, timer, NULL, 0);
  PetscCall(MPMExchangeSort(core));
  PetscCall(MPMTilesAssignBy(&core->exchange.patch, ((MPMKeepBase *)core->exchange.pool)->border, particles->start));
  memory->borders = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the motion of nodes that is at m to the patch's arrays. */
static PetscErrorCode TakeMotion(MPMCore *core, const MPMKeepJob *job, const char *m)
{
  const MPMKeepRange *range  = (const MPMKeepRange *)m;
  const size_t        nv     = (size_t)MPM_MOTION_NC(core->grid.dim);
  const char         *motion = MPMKeepAlign((char *)m, (char *)(range + job->ranges));

  PetscFunctionBeginUser;
  PetscCall(MPMExchangeOpenNodes(core));
  for (PetscInt k = 0; k < job->ranges; k++) {
    const size_t bytes = (size_t)range[k].n * nv * sizeof(PetscReal);

    memcpy(core->exchange.patch.motion + (size_t)range[k].first * nv, motion, bytes);
    motion += bytes;
  }
  PetscCall(MPMExchangeCloseNodes(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the most bytes that the answer to a job can have. */
static size_t AnswerBytes(MPMCore *core, const MPMKeepJob *job, const Memory *memory)
{
  const MPMPhase *phase = job->phase < 0 ? NULL : &core->phases[job->phase];
  const size_t    head  = sizeof(MPMKeepAnswer) + 16;
  PetscInt        which[MPM_NODE_NC], ranges, nodes;

  if (!phase) return head + (size_t)core->particles.n * MPMParticlesRowBytes(&core->particles, job->fields);
  if (phase->kind == MPM_NODES_TO_PARTICLES)
    return head + (size_t)memory->nleavers * (size_t)MPMParticlesBytes(&core->particles, MPM_SCRATCH);
  MPMKeepRanges(core, &ranges, &nodes, NULL);
  return head + (size_t)MPMKeepTiles(core, NULL) * sizeof(MPMKeepTile) + (size_t)ranges * sizeof(MPMKeepRange) +
         ((size_t)core->exchange.patch.tiles.n_own * MPMTileNodes(core->grid.dim, core->basis) + (size_t)nodes) *
             (size_t)MPMNodeSums(core->grid.dim, phase->parts, which) * sizeof(PetscReal);
}

/* Runs the phase of a job on all particles here; *m: what follows its head. */
static PetscErrorCode Work(MPMCore *core, const MPMKeepJob *job, Memory *memory, char *m)
{
  const MPMPhase *phase = &core->phases[job->phase];
  MPMKeepBase    *base  = (MPMKeepBase *)core->exchange.pool;

  PetscFunctionBeginUser;
  core->params.dt   = job->dt;
  core->params.kick = job->kick;
  core->params.flip = job->flip;
  core->params.push = job->push;
  if (job->owners) {
    PetscCall(PetscArraycpy(base->owner, (PetscInt *)m, base->ntiles));
    m += (size_t)base->ntiles * sizeof *base->owner;
    MPMKeepFindBorders(core, base);
    memory->borders = PETSC_TRUE;
  }
  if (job->settle) PetscCall(Settle(core, job, phase->timer, memory, &m));
  m = MPMKeepAlign(memory->in, m);
  PetscCall(MPMPhaseBegin(core, phase));
  if (phase->kind == MPM_PARTICLES_TO_NODES) {
    PetscCall(MPMExchangeRun(core, phase, MPM_PASS_EARLY));
    PetscCall(MPMExchangeRun(core, phase, MPM_PASS_MAIN));
  } else {
    MPMWorkBegin(&core->timers);
    PetscCall(TakeMotion(core, job, m));
    MPMWorkEnd(&core->timers, phase->timer, NULL, 0);
    PetscCall(MPMExchangeRun(core, phase, MPM_PASS_MAIN));
    MPMWorkBegin(&core->timers);
    if (phase->parts & MPM_G2P_COMMIT) PetscCall(FindLeavers(core, job->owners ? PETSC_TRUE : PETSC_FALSE, memory));
    MPMWorkEnd(&core->timers, phase->timer, NULL, 0);
  }
  PetscCall(MPMPhaseEnd(core, phase, core->particles.n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Packs the answer to a job; sets its length in bytes. */
static PetscErrorCode Answer(MPMCore *core, const MPMKeepJob *job, Memory *memory, PetscMPIInt *len)
{
  MPMParticles   *particles = &core->particles;
  const MPMPhase *phase     = job->phase < 0 ? NULL : &core->phases[job->phase];
  MPMKeepAnswer   answer    = {.status = core->status, .n = particles->n};
  char           *m;

  PetscFunctionBeginUser;
  PetscCall(MPMMessageRoom(&memory->out, &memory->out_capacity, AnswerBytes(core, job, memory)));
  m = memory->out + sizeof answer;
  if (!phase)
    PetscCall(MPMKeepRows(particles, job->fields, particles->n, NULL, PETSC_TRUE, &m));
  else if (phase->kind == MPM_PARTICLES_TO_NODES)
    PetscCall(MPMKeepPackSums(core, phase, &answer, memory->out, &m));
  else {
    answer.n = phase->parts & MPM_G2P_COMMIT ? memory->nleavers : 0;
    PetscCall(MPMKeepRows(particles, MPMKeepFields(particles, PETSC_FALSE), answer.n, memory->leaver, PETSC_TRUE, &m));
  }
  memcpy(memory->out, &answer, sizeof answer);
  PetscCall(MPMMessageLength((size_t)(m - memory->out), len));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes jobs from the master and answers them, until the master says that the run is over. Every process but the first
   calls it. */
PetscErrorCode MPMKeepServe(MPMCore *core)
{
  const MPI_Comm comm      = ((MPMKeepBase *)core->exchange.pool)->comm;
  MPMParticles  *particles = &core->particles;
  MPI_Request    answer    = MPI_REQUEST_NULL;
  Memory         memory    = {0};

  PetscFunctionBeginUser;
  for (;;) {
    MPI_Status  probed;
    PetscMPIInt len;
    MPMKeepJob  job;

    PetscCallMPI(MPI_Probe(0, MPM_TAG_JOB, comm, &probed));
    PetscCallMPI(MPI_Get_count(&probed, MPI_BYTE, &len));
    PetscCall(MPMMessageRoom(&memory.in, &memory.in_capacity, (size_t)len));
    PetscCallMPI(MPI_Recv(memory.in, len, MPI_BYTE, 0, MPM_TAG_JOB, comm, MPI_STATUS_IGNORE));
    memcpy(&job, memory.in, sizeof job);
    if (job.phase == MPM_KEEP_OVER) break;
    MPMSimulateWork("JOB", 1);
    MPMSimulateWork("UNPACK", (PetscReal)len);
    MPMStatusReset(&core->status);
    core->status.asked = MPMSignalsAsked();
    if (job.phase >= 0) PetscCall(Work(core, &job, &memory, memory.in + sizeof job));
    PetscCallMPI(MPI_Wait(&answer, MPI_STATUS_IGNORE));
    MPMWorkBegin(&core->timers);
    PetscCall(Answer(core, &job, &memory, &len));
    MPMWorkEnd(&core->timers, job.phase < 0 ? MPM_TIMER_OTHER : core->phases[job.phase].timer, NULL, 0);
    MPMSimulateWork("ANSWER", (PetscReal)len);
    PetscCallMPI(MPI_Isend(memory.out, len, MPI_BYTE, 0, MPM_TAG_ANSWER, comm, &answer));
    if (!job.ends) continue;
    memory.nleavers = 0; /* the particles are the master's again */
    PetscCall(MPMParticlesSetSize(particles, 0));
    particles->nmovers = -1;
  }
  PetscCallMPI(MPI_Wait(&answer, MPI_STATUS_IGNORE));
  PetscCall(PetscFree(memory.leaver));
  PetscCall(PetscFree(memory.in));
  PetscCall(PetscFree(memory.out));
  PetscFunctionReturn(PETSC_SUCCESS);
}
