/* model.c - the predicted cost of a step: docs/model.md has the formulas, docs/performance.md how well they hold.

   The time of a step is the sum over its phases. The process that has most of a phase takes for it
     call + n each          its kernel, for n particles (or nodes); `each` depends on n, by the caches
     + message + byte       what it sends to neighbours; sums are transmitted while it works, motion is waited for
   A step also has one reduction and, when particles leave their patch, a migration. The constants are of this machine
   and this method, from a calibration (tools/calibrate), or else rough ones from counts of flops and bytes. The physics
   does not use them, but the partition of the grid is chosen by them. */
#include "cost/cost.h"
#include "kernels/tile_index.h"

/* The rough constants without a calibration, in s: per flop, per byte of particle fields, per node, per particle that
   is sorted, per phase. */
#define FLOP 0.028e-9
#define BYTE 0.05e-9
#define NODE 4e-9
#define SORT 2.5e-9
#define CALL 1e-6

/* Cells that the fastest particle is assumed to move in a step, for the choice of the cuts. It is a guess, since the
   grid is cut before the particles exist, and bodies at rest start to move. With dt = 0.4 h/(c + |v|) it means |v| =
   c/9. */
#define MOVED 0.04

/* Returns the seconds that n particles or nodes take. */
static PetscReal Seconds(const MPMRate *r, PetscReal n)
{
  PetscReal each = r->each[0];

  for (int k = 1; k < MPM_RATE_SIZES && n > r->size[k - 1] && r->size[k - 1] > 0; k++) {
    const PetscReal s = PetscLogReal(n / r->size[k - 1]) / PetscLogReal(r->size[k] / r->size[k - 1]);

    each = r->each[k - 1] + PetscMin(1, s) * (r->each[k] - r->each[k - 1]);
  }
  return r->call + n * each;
}

/* Returns the share of the steps that make phase k of the program. */
static PetscReal PhaseShare(const MPMCore *core, PetscInt k)
{
  return k < core->nprogram ? 1 : core->volumes.share;
}

/* Returns how often a step runs phases of timer e, on average; *first is the first of them, or NULL if it runs none. */
static PetscReal Times(const MPMCore *core, PetscInt e, const MPMPhase **first)
{
  PetscReal times = 0;

  *first = NULL;
  for (PetscInt k = core->nprogram + core->nrare - 1; k >= 0; k--)
    if (core->program[k]->timer == e) {
      *first = core->program[k];
      times += PhaseShare(core, k);
    }
  return times;
}

/* Returns the bytes that a phase sends per ghost node: its motion once, or its sums once for each tile that reaches
   it. */
static PetscReal PhaseMessage(const MPMCore *core, const MPMPhase *phase)
{
  const PetscInt dim = core->grid.dim;
  PetscInt       which[MPM_NODE_NUMBERS];

  if (phase->kind == MPM_NODES) return (PetscReal)(phase->motion * dim) * (PetscReal)sizeof(PetscReal);
  return MPMTilesPerGhost(dim, core->basis) * (PetscReal)sizeof(PetscReal) *
         (PetscReal)MPMNodeSums(dim, phase->parts, which);
}

/* Returns the number of doublings that lead from one process to so many. */
static PetscReal Log2(PetscReal processes)
{
  return processes > 1 ? PetscCeilReal(PetscLog2Real(processes)) : 0;
}

/* Returns the probability that in a step at least one particle changes process, if s->crossing do so on average. */
static PetscReal Migrates(const MPMShare *s)
{
  return 1 - PetscExpReal(-s->crossing);
}

/* Returns the seconds of the messages of a migration without those of the particles that move. direct: a message there
   and back along one cut axis after the other; else DMSwarmMigrate, each of whose collectives takes as long as a
   reduction, and the time that the numbers of all processes are on their way. Not collective. */
PetscReal MPMModelMigrationMessages(const MPMModel *m, PetscBool direct, PetscReal axes, PetscReal processes)
{
  const PetscReal numbers = MPM_SWARM_GATHERS + (processes > MPM_SWARM_FEW ? 0 : MPM_SWARM_FLAGS);

  if (direct) return axes * (m->message + m->post);
  return MPM_SWARM_COLLECTIVES * Log2(processes) * m->reduction + numbers * MPM_SWARM_NUMBER * processes * m->wire;
}

/* Returns the seconds in which contact is looked for, on the process that has most of a surface in a cut into cubes. */
static PetscReal Search(const MPMModel *m, const MPMCore *core, const MPMShare *s)
{
  const PetscReal dim = (PetscReal)core->grid.dim;

  return m->look * s->particles + m->search / PetscPowReal(PetscMax(1, s->processes), (dim - 1) / dim);
}

/* Returns the predicted seconds per step of timer e, on a process with this share, in spatial decomposition or in a run
   on one process. Not collective. */
PetscReal MPMModelTimer(const MPMModel *m, const MPMCore *core, PetscInt e, const MPMShare *s)
{
  const MPMMigration *way    = &m->migration[core->exchange.direct];
  const PetscReal     posts  = s->neighbours > 0 ? m->exchange + s->neighbours * m->post : 0;
  const PetscReal     way_of = s->neighbours > 0 ? PetscMax(0, m->message - m->post) : 0;
  const MPMPhase     *phase;
  PetscReal           sent, times;

  if (e == MPM_TIMER_REDUCE) return m->rate[e].call + Log2(s->processes) * m->reduction;
  if (e == MPM_TIMER_MIGRATE && s->processes == 1) return 0;
  if (e == MPM_TIMER_MIGRATE)
    return Migrates(s) * (way->call + way->particle * s->particles +
                          MPMModelMigrationMessages(m, core->exchange.direct, s->axes, s->processes)) +
           way->leaver * s->row * s->waits;
  if (e < MPM_TIMER_PHASES)
    return Seconds(&m->rate[e], s->particles) + (e == MPM_TIMER_FORCES ? Search(m, core, s) : 0);
  times = Times(core, e, &phase);
  if (!phase) return 0;
  if (phase->kind == MPM_NODES_TO_PARTICLES) return Seconds(&m->rate[e], s->particles);
  sent = s->ghosts * PhaseMessage(core, phase);
  if (phase->kind == MPM_NODES)
    return Seconds(&m->rate[e], s->nodes) + (phase->nodes == MPMNodesAdvance ? m->impulses : 0) +
           times * (posts + way_of + sent * (m->wire + m->copy));
  return Seconds(&m->rate[e], s->particles) + times * (posts + sent * m->kept);
}

/* What the pool's master hands out for the transfers of timer e in a step, and takes back: bytes, 0 where it does the
   part alone, and jobs. s is the share of a run on one process, edge that of a patch in cells. */
PetscReal MPMModelPoolBytes(const MPMCore *core, PetscInt e, const MPMShare *s, PetscInt edge, PetscReal *jobs)
{
  const PetscInt  dim = core->grid.dim;
  const MPMPhase *phase;
  const PetscReal times = Times(core, e, &phase);
  const PetscReal reach = (PetscReal)MPMBasisNodes(core->basis) - 1, c = MPMPoolEdge(core->basis, edge);
  const PetscReal copies = PetscPowReal((PetscReal)MPMTileSide(core->basis) / (PetscReal)MPMTileEdge(core->basis),
                                        (PetscReal)dim); /* of a node in tiles */
  PetscReal       patches, cells, wide, bytes;
  PetscInt        which[MPM_NODE_NUMBERS];

  *jobs = 0;
  if (!phase || phase->kind == MPM_NODES) return 0;
  cells   = PetscPowReal(c, (PetscReal)dim);
  wide    = PetscPowReal(c + reach, (PetscReal)dim);
  patches = PetscMax(1, s->nodes / cells);
  bytes   = s->particles * (PetscReal)(MPMParticlesRowBytes(&core->particles, phase->particles_in));
  if (phase->kind == MPM_PARTICLES_TO_NODES)
    bytes += s->nodes * copies * 8 * (PetscReal)MPMNodeSums(dim, phase->parts, which);
  else
    bytes += s->particles * (PetscReal)MPMParticlesRowBytes(&core->particles, phase->particles_out) +
             patches * wide * 8 * (PetscReal)MPM_MOTION_NC(dim);
  *jobs = patches * times;
  return bytes * times;
}

/* Predicted seconds a step of timer e for the pool's master with processes-1 workers; s and edge as above. Node phases
   and the settling are the master's alone. For the transfers it packs patches and puts answers in place (master) while
   workers do that and the kernel; the first patch and the last answer wait for each other. *master gets the seconds for
   which the master is busy. */
static PetscReal PoolTimer(const MPMModel *m, const MPMCore *core, PetscInt e, const MPMShare *s, PetscInt edge,
                           PetscReal *master)
{
  MPMShare        alone = *s;
  PetscReal       jobs, worker;
  const PetscReal bytes = MPMModelPoolBytes(core, e, s, edge, &jobs);

  alone.processes = 1;
  *master         = MPMModelTimer(m, core, e, &alone);
  if (jobs == 0) return *master;
  *master = jobs * (m->job + m->message) + bytes * (m->pool + m->wire);
  worker  = (Seconds(&m->rate[e], s->particles) + *master) / PetscMin(s->processes - 1, jobs);
  return PetscMax(*master, worker) + (Seconds(&m->rate[e], s->particles) + 2 * *master) / jobs;
}

/* Returns the predicted seconds of a step on a process with this share, in spatial decomposition or in a run on one
   process. Not collective. */
PetscReal MPMModelStep(const MPMModel *m, const MPMCore *core, const MPMShare *s)
{
  PetscReal t = 0;

  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) t += MPMModelTimer(m, core, e, s);
  return t;
}

/* Returns the predicted seconds of a step in the pool; s, edge: as above. *bound, if not NULL, gets the speed-up that
   no number of workers can exceed, because the master is busy all the time. Not collective. */
PetscReal MPMModelPoolStep(const MPMModel *m, const MPMCore *core, const MPMShare *s, PetscInt edge, PetscReal *bound)
{
  PetscReal t = 0, busy = 0, master, serial;
  MPMShare  alone = *s;

  alone.processes = 1;
  serial          = MPMModelStep(m, core, &alone);
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) {
    t += PoolTimer(m, core, e, s, edge, &master);
    busy += master;
  }
  if (bound) *bound = serial / busy;
  return t;
}

/* The edge in cells, of whole tiles, of the patches with which the pool's step is shortest. */
PetscInt MPMModelPoolEdge(const MPMModel *m, const MPMCore *core, const MPMShare *s)
{
  PetscReal best = PETSC_MAX_REAL;
  PetscInt  edge = 0;

  for (PetscInt c = MPMTileEdge(core->basis); c <= 256; c += MPMTileEdge(core->basis)) {
    const PetscReal t = MPMModelPoolStep(m, core, s, c, NULL);

    if (t < best) {
      best = t;
      edge = c;
    }
  }
  return edge;
}

/* Linear costs of a share near `n` particles on one process, for the choice of the partition. */
void MPMModelCosts(const MPMModel *m, const MPMCore *core, PetscReal n, MPMCosts *costs)
{
  const PetscReal nodes = n, step = 0.01 * n + 1;
  MPMShare        s    = {.particles = n, .nodes = nodes, .neighbours = 1, .processes = 1}, more;
  const PetscReal base = MPMModelStep(m, core, &s);

  more = s;
  more.particles += step;
  costs->particle = (MPMModelStep(m, core, &more) - base) / step;
  more            = s;
  more.ghosts += step;
  costs->ghost = (MPMModelStep(m, core, &more) - base) / step;
  more         = s;
  more.nodes += step;
  costs->node = (MPMModelStep(m, core, &more) - base) / step;
  more        = s;
  more.neighbours += 1;
  costs->neighbour = MPMModelStep(m, core, &more) - base;
  costs->leaver    = m->migration[core->exchange.direct].leaver;
  costs->moved     = MOVED;
  costs->fixed     = base - n * costs->particle - nodes * costs->node - costs->neighbour;
}

/* Sets rough constants from the counts of operations and bytes of the phases, which have to be known. Not
   collective. */
void MPMModelRough(MPMModel *m, const MPMCore *core, const MPMScene *scene)
{
  memset(m, 0, sizeof *m);
  for (PetscInt e = 0; e < MPM_TIMER_PHASES; e++)
    if (e != MPM_TIMER_MIGRATE && (e != MPM_TIMER_FORCES || scene->forced)) m->rate[e].call = CALL;
  m->rate[MPM_TIMER_SORT].each[0] = SORT;
  if (scene->forced) m->rate[MPM_TIMER_FORCES].each[0] = 100e-9; /* one expression per particle */
  for (PetscInt k = 0; k < core->nprogram + core->nrare; k++) {
    const MPMPhase *phase = core->program[k];
    const PetscReal share = PhaseShare(core, k);
    MPMRate        *r     = &m->rate[phase->timer];

    r->call += share * CALL;
    r->each[0] += share * (phase->kind == MPM_NODES
                               ? NODE
                               : FLOP * MPMKernelFlops(core->grid.dim, core->basis, phase->parts) +
                                     BYTE * (PetscReal)(MPMParticlesRowBytes(&core->particles, phase->particles_in) +
                                                        MPMParticlesRowBytes(&core->particles, phase->particles_out)));
  }
  for (PetscInt e = 0; e < core->timers.n; e++)
    for (int k = 1; k < MPM_RATE_SIZES; k++) m->rate[e].each[k] = m->rate[e].each[0];
  m->exchange              = 1e-6;
  m->message               = 1.6e-6; /* a cluster: latency 1 us, 0.3 us on each side */
  m->post                  = 0.6e-6;
  m->wire                  = 0.08e-9;
  m->copy                  = 0.3e-9;
  m->kept                  = 0.3e-9;
  m->reduction             = 1.6e-6;
  m->migration[0].call     = 60e-6;
  m->migration[0].particle = 1e-9;
  m->migration[0].leaver = m->migration[1].leaver = 200e-9;
  m->migration[1].call                            = 2e-6;
  m->job                                          = 2e-6;
  m->pool                                         = 0.3e-9;
  m->within                                       = MPM_WITHIN_ROUGH;
  (void)snprintf(m->from, sizeof m->from, "rough: make calibrate measures them");
}

/* Sets the share to what this process has now. Collective on the exchange. */
PetscErrorCode MPMModelShare(MPMCore *core, PetscReal dt, MPMShare *s)
{
  MPMPatch   *patch = &core->exchange.patch;
  PetscReal   h     = PETSC_MAX_REAL;
  PetscMPIInt size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCall(PetscMemzero(s, sizeof *s));
  s->particles = (PetscReal)core->particles.n;
  s->processes = (PetscReal)size;
  MPMTilesFindSpans(patch); /* no step may have done so yet */
  for (PetscInt k = patch->own_lo[2]; k < patch->own_lo[2] + patch->own_n[2]; k++)
    for (PetscInt j = patch->own_lo[1]; j < patch->own_lo[1] + patch->own_n[1]; j++) {
      const MPMSpan *span = &patch->span[(k - patch->lo[2]) * patch->n[1] + j - patch->lo[1]];

      s->nodes += (PetscReal)PetscMax(0, span->last - span->first);
    }
  if (core->exchange.type->share) PetscCall(core->exchange.type->share(core, s));
  for (PetscInt d = 0; d < core->grid.dim; d++) h = PetscMin(h, core->grid.h[d]);
  MPMShareCross(core->grid.dim, s->ghosts / ((PetscReal)MPMBasisNodes(core->basis) - 1),
                s->particles / PetscMax(1, s->nodes), PetscSqrtReal(core->status.v2) * dt / h, s);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &s->crossing, 1, MPIU_REAL, MPIU_SUM, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Predicts the next step: sets cost->predicted, s by timer, each of the process that takes longest for it. Collective
   on the exchange. */
PetscErrorCode MPMModelPredict(MPMCost *cost, MPMCore *core, PetscReal dt)
{
  MPMShare  s;
  PetscReal ignored;

  PetscFunctionBeginUser;
  PetscCall(MPMModelShare(core, dt, &s));
  PetscCall(MPMModelContact(&cost->model, core));
  if (core->contacts)
    cost->model.within = PetscMax(cost->model.within, MPM_WITHIN_ROUGH); /* nothing else was measured */
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++)
    cost->predicted[e] = core->exchange.type->by_workers
                             ? PoolTimer(&cost->model, core, e, &s, core->exchange.pool_cells, &ignored)
                             : MPMModelTimer(&cost->model, core, e, &s);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, cost->predicted, MPM_MAX_TIMERS, MPIU_REAL, MPIU_MAX, core->exchange.data));
  if (core->timers.work.on) { /* the time for messages is what is left if the work takes no time */
    const MPMModel model = cost->model;

    PetscCall(PetscMemzero(cost->model.rate, sizeof cost->model.rate));
    cost->model.kept = cost->model.look = cost->model.search = cost->model.impulses = 0; /* this is work too */
    for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++)
      cost->messages[e] = core->exchange.type->by_workers ? 0 : MPMModelTimer(&cost->model, core, e, &s);
    cost->model = model;
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, cost->messages, MPM_MAX_TIMERS, MPIU_REAL, MPIU_MAX, core->exchange.data));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
