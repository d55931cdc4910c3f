/* model.c - what a step costs, predicted: docs/performance.md derives the formulas and says how well they hold.

   A step is the sum of its phases. A phase costs the process that has most of it
     call + n each          its kernel, for n particles (or nodes); `each` depends on n, by the caches
     + message + byte       what it sends to neighbours; the way of sums is hidden by work, that of motion is not
   and a step one reduction and, when particles leave, a migration. The constants are of this machine and this method,
   from -model_calibrate (calibrate.c), or else rough ones from counts of flops and bytes. Physics never sees any of
   this, but the partition of the grid is chosen by it. */
#include <errno.h>
#include <libgen.h>
#include <unistd.h>
#include "exchange_spatial.h"
#include "options.h"
#include "tiles.h"

/* Without a calibration: s per flop, per byte of particle fields, per node, per particle sorted, per phase. */
#define FLOP 0.028e-9
#define BYTE 0.05e-9
#define NODE 4e-9
#define SORT 2.5e-9
#define CALL 1e-6

/* Cells that the fastest particle moves in a step, for the choice of the cuts: a guess, since these are made before the
   particles, and bodies that rest at the start will not stay so. With dt = 0.4 h/(c + |v|) it is |v| = c/9. */
#define MOVED 0.04

/* Seconds for n things. */
static PetscReal Seconds(const MPMRate *r, PetscReal n)
{
  PetscReal each = r->each[0];

  for (int k = 1; k < MPM_RATE_SIZES && n > r->size[k - 1] && r->size[k - 1] > 0; k++) {
    const PetscReal s = PetscLogReal(n / r->size[k - 1]) / PetscLogReal(r->size[k] / r->size[k - 1]);

    each = r->each[k - 1] + PetscMin(1, s) * (r->each[k] - r->each[k - 1]);
  }
  return r->call + n * each;
}

/* How often a step runs the phase of timer e. */
static PetscInt Times(MPM mpm, PetscInt e)
{
  PetscInt times = 0;

  for (PetscInt k = 0; k < mpm->nprogram; k++) times += mpm->program[k] == &mpm->phases[e];
  return times;
}

/* Bytes a ghost node that a phase sends: its motion once, its sums once for each tile that reaches it. */
static PetscReal PhaseMessage(MPM mpm, const MPMPhase *phase)
{
  const PetscInt dim = mpm->grid.dim;

  if (phase->kind == MPM_NODES) return (PetscReal)MPM_VEL_NC(dim) * (PetscReal)sizeof(PetscReal);
  return MPMTilesPerGhost(dim, mpm->basis) * (PetscReal)sizeof(PetscReal) *
         (PetscReal)(MPM_SUM_LAST(dim, phase->parts) - MPM_SUM_FIRST(dim, phase->parts));
}

static PetscReal Log2(PetscReal processes)
{
  return processes > 1 ? PetscCeilReal(PetscLog2Real(processes)) : 0;
}

/* The probability that a step moves a particle from one process to another, if so many do so on average. */
static PetscReal Migrates(const MPMShare *s)
{
  return 1 - PetscExpReal(-s->crossing);
}

/* What of a share crosses its cuts in a step, where the fastest particle moves by `moved` cells: `layer` cells lie at
   the cuts, one deep, with so many particles in each. Particles lie in rows, a = per_cell^(1/dim) of them in a layer,
   and a row crosses a cut as a whole, in one step out of 1/(a moved). All processes wait for the one that hands on a
   row just then, so a step is as dear with one row on its way as with one at every cut of the axis. crossing is of this
   process.
 */
void MPMModelCross(PetscInt dim, PetscReal layer, PetscReal per_cell, PetscReal moved, MPMShare *s)
{
  const PetscReal rows = PetscPowReal(per_cell, 1 / (PetscReal)dim);

  s->crossing = layer * per_cell * moved;
  s->row      = rows > 0 ? layer * per_cell / rows : 0;
  s->waits    = 1 - PetscPowReal(1 - PetscMin(1, rows * moved), s->cuts / PetscMax(1, s->axes));
}

/* Predicted seconds a step of timer e on a process with this share of a run in spatial decomposition, or of one
   process. Not collective. */
PetscReal MPMModelTimer(MPM mpm, PetscInt e, const MPMShare *s)
{
  const MPMModel     *m      = &mpm->model;
  const MPMMigration *way    = &m->migration[mpm->exchange.direct];
  const PetscReal     posts  = s->neighbours > 0 ? m->exchange + s->neighbours * m->post : 0;
  const PetscReal     way_of = s->neighbours > 0 ? PetscMax(0, m->message - m->post) : 0;
  PetscReal           sent;

  if (e == MPM_TIMER_REDUCE) return m->rate[e].call + Log2(s->processes) * m->reduction;
  if (e == MPM_TIMER_MIGRATE && s->processes == 1) return 0;
  if (e == MPM_TIMER_MIGRATE)
    return Migrates(s) * (way->call + way->stage * (mpm->exchange.direct ? s->axes : Log2(s->processes)) +
                          way->particle * s->particles + way->process * s->processes) +
           way->leaver * s->row * s->waits;
  if (e >= MPM_TIMER_FORCES) return Seconds(&m->rate[e], s->particles);
  if (!Times(mpm, e)) return 0;
  if (mpm->phases[e].kind == MPM_NODES_TO_PARTICLES) return Seconds(&m->rate[e], s->particles);
  sent = s->ghosts * PhaseMessage(mpm, &mpm->phases[e]);
  if (mpm->phases[e].kind == MPM_NODES)
    return Seconds(&m->rate[e], s->nodes) + (PetscReal)Times(mpm, e) * (posts + way_of + sent * (m->wire + m->copy));
  return Seconds(&m->rate[e], s->particles) + (PetscReal)Times(mpm, e) * (posts + sent * m->kept);
}

/* The same for the pool's master with processes-1 workers; s is the share of a run on one process, edge that of a patch
   in cells. Node phases and the settling are the master's alone. For the transfers it packs chunks and puts answers in
   place (master) while workers do that and the kernel; the first chunk and the last answer wait for each other.
   *master gets the seconds for which the master is busy. */
static PetscReal PoolTimer(MPM mpm, PetscInt e, const MPMShare *s, PetscInt edge, PetscReal *master)
{
  const MPMModel *m     = &mpm->model;
  const PetscInt  dim   = mpm->grid.dim;
  const MPMPhase *phase = &mpm->phases[e];
  const PetscReal reach = (PetscReal)MPMBasisNodes(mpm->basis) - 1, c = MPMPoolEdge(mpm->basis, edge);
  MPMShare        alone = *s;
  PetscReal       chunks, cells, wide, bytes, worker, pool;

  alone.processes = 1;
  *master         = MPMModelTimer(mpm, e, &alone);
  if (e >= MPM_TIMER_FORCES || !Times(mpm, e) || phase->kind == MPM_NODES) return *master;
  cells  = PetscPowReal(c, (PetscReal)dim);
  wide   = PetscPowReal(c + reach, (PetscReal)dim);
  chunks = PetscMax(1, s->nodes / cells);
  bytes  = s->particles * (PetscReal)(MPMParticlesRowBytes(&mpm->particles, phase->particles_in));
  if (phase->kind == MPM_PARTICLES_TO_NODES)
    bytes += s->nodes *
             PetscPowReal((PetscReal)MPMTileSide(mpm->basis) / (PetscReal)MPMTileEdge(mpm->basis), (PetscReal)dim) * 8 *
             (PetscReal)(MPM_SUM_LAST(dim, phase->parts) - MPM_SUM_FIRST(dim, phase->parts));
  else
    bytes += s->particles * (PetscReal)MPMParticlesRowBytes(&mpm->particles, phase->particles_out) +
             chunks * wide * 8 * (PetscReal)MPM_VEL_NC(dim);
  bytes *= (PetscReal)Times(mpm, e);
  chunks *= (PetscReal)Times(mpm, e);
  pool    = chunks * (m->chunk + m->message) + bytes * (m->farm + m->wire);
  *master = pool;
  worker  = (Seconds(&m->rate[e], s->particles) + pool) / PetscMin(s->processes - 1, chunks);
  return PetscMax(pool, worker) + (Seconds(&m->rate[e], s->particles) + 2 * pool) / chunks;
}

static PetscReal Step(MPM mpm, const MPMShare *s)
{
  PetscReal t = 0;

  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) t += MPMModelTimer(mpm, e, s);
  return t;
}

/* Seconds of a step in the pool; bound: what no number of workers can exceed, the speed-up where the master is all. */
static PetscReal PoolStep(MPM mpm, const MPMShare *s, PetscInt edge, PetscReal *bound)
{
  PetscReal t = 0, busy = 0, master, serial;
  MPMShare  alone = *s;

  alone.processes = 1;
  serial          = Step(mpm, &alone);
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) {
    t += PoolTimer(mpm, e, s, edge, &master);
    busy += master;
  }
  if (bound) *bound = serial / busy;
  return t;
}

/* The share of one process in a cut of a full block into `processes` cubes, n particles each: cells of side
   (n/per_cell)^(1/d), ghosts a shell of the stencil's reach above, as tiles send them: on an axis where it is above the
   cube, a node is in the last tile alone. The fastest particle moves by `moved` cells a step. */
static MPMShare Cube(MPM mpm, PetscReal n, PetscReal per_cell, PetscReal processes, PetscReal moved)
{
  const PetscReal dim = (PetscReal)mpm->grid.dim, reach = (PetscReal)MPMBasisNodes(mpm->basis) - 1;
  const PetscReal side = PetscPowReal(n / per_cell, 1 / dim), cells = n / per_cell;
  const PetscReal tiles = MPMTilesPerGhost(mpm->grid.dim, mpm->basis);
  const PetscReal one   = PetscPowReal(tiles, 1 / PetscMax(1, dim - 1)); /* the same of one axis */
  MPMShare        s     = {.particles = n, .processes = processes, .nodes = PetscPowReal(side + reach, dim)};

  if (processes > 1) {
    s.ghosts     = (PetscPowReal(one * side + reach, dim) - PetscPowReal(one * side, dim)) / tiles;
    s.neighbours = PetscPowReal(2, dim) - 1;
    s.axes       = dim;
    s.cuts       = dim * (PetscPowReal(processes, 1 / dim) - 1);
    MPMModelCross(mpm->grid.dim, dim * cells / side, per_cell, moved, &s);
    s.crossing *= processes;
  }
  return s;
}

/* Linear costs of a share near `n` particles on one process, for the choice of the partition. */
void MPMModelCosts(MPM mpm, PetscReal n, MPMCosts *costs)
{
  const PetscReal nodes = n, step = 0.01 * n + 1;
  MPMShare        s    = {.particles = n, .nodes = nodes, .neighbours = 1, .processes = 1}, more;
  const PetscReal base = Step(mpm, &s);

  more = s;
  more.particles += step;
  costs->particle = (Step(mpm, &more) - base) / step;
  more            = s;
  more.ghosts += step;
  costs->ghost = (Step(mpm, &more) - base) / step;
  more         = s;
  more.nodes += step;
  costs->node = (Step(mpm, &more) - base) / step;
  more        = s;
  more.neighbours += 1;
  costs->neighbour = Step(mpm, &more) - base;
  costs->leaver    = mpm->model.migration[mpm->exchange.direct].leaver;
  costs->moved     = MOVED;
  costs->fixed     = base - n * costs->particle - nodes * costs->node - costs->neighbour;
}

/* Rough constants from the hand counts, once the phases are known. Not collective. */
static void SetRough(MPM mpm)
{
  MPMModel *m = &mpm->model;

  memset(m, 0, sizeof *m);
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) {
    const MPMPhase *phase = &mpm->phases[e];
    MPMRate        *r     = &m->rate[e];
    const PetscReal times = e < MPM_TIMER_FORCES ? (PetscReal)Times(mpm, e) : 1;

    if (e == MPM_TIMER_FORCES && !mpm->scene.forced) continue;
    if ((e < MPM_TIMER_FORCES && !times) || e == MPM_TIMER_MIGRATE) continue;
    r->call = times * CALL;
    if (e == MPM_TIMER_SORT || e == MPM_TIMER_FORCES)
      r->each[0] = e == MPM_TIMER_SORT ? SORT : 100e-9; /* an expression a particle */
    else if (e < MPM_TIMER_FORCES)
      r->each[0] = times * (phase->kind == MPM_NODES
                                ? NODE
                                : FLOP * MPMTransferFlops(mpm->grid.dim, mpm->basis, phase->parts) +
                                      BYTE * (PetscReal)(MPMParticlesRowBytes(&mpm->particles, phase->particles_in) +
                                                         MPMParticlesRowBytes(&mpm->particles, phase->particles_out)));
    for (int k = 1; k < MPM_RATE_SIZES; k++) r->each[k] = r->each[0];
  }
  m->exchange              = 1e-6;
  m->message               = 1.6e-6; /* a cluster: latency 1 us, 0.3 us on each side */
  m->post                  = 0.6e-6;
  m->wire                  = 0.08e-9;
  m->copy                  = 0.3e-9;
  m->kept                  = 0.3e-9;
  m->reduction             = 1.6e-6;
  m->migration[0].call     = 60e-6; /* DMSwarmMigrate: 22 collectives, one of them of a number from every process */
  m->migration[0].stage    = 24 * 1.6e-6;
  m->migration[0].process  = 80 * m->wire;
  m->migration[0].particle = 1e-9;
  m->migration[0].leaver = m->migration[1].leaver = 200e-9;
  m->migration[1].call                            = 2e-6;
  m->migration[1].stage                           = 1.6e-6 + 0.6e-6;
  m->chunk                                        = 2e-6;
  m->farm                                         = 0.3e-9;
  (void)snprintf(m->from, sizeof m->from, "rough: -model_calibrate measures them");
}

/* What the constants are good for: the same method, of particles that cost the same. */
void MPMModelMethod(MPM mpm, char text[], size_t len)
{
  size_t at = (size_t)snprintf(text, len, "%" PetscInt_FMT "-D:%d:%" PetscInt_FMT ":%" PetscInt_FMT, mpm->grid.dim,
                               (int)mpm->basis, MPMParticlesBytes(&mpm->particles, MPM_SCRATCH), MPMTransferWidth());

  for (PetscInt k = 0; k < mpm->nprogram && at < len; k++)
    at += (size_t)snprintf(text + at, len - at, ":%s.%" PetscInt_FMT, mpm->program[k]->name, mpm->program[k]->parts);
  for (PetscInt k = 0; k < mpm->scene.nmaterials && at < len; k++)
    at += (size_t)snprintf(text + at, len - at, ":%s", mpm->scene.materials[k].type->name);
  for (PetscInt b = 0; b < mpm->scene.nbodies && at < len; b++) {
    const MPMBody *body = &mpm->scene.bodies[b];

    at += (size_t)snprintf(text + at, len - at, ":%" PetscInt_FMT,
                           body->ppc[0] * PetscMax(1, body->ppc[1]) * PetscMax(1, body->ppc[2]));
  }
}

/* Does one of the first lines name a method? In every file of -model_calibrate the second does. */
static PetscBool IsModelFile(const char path[])
{
  FILE     *file = fopen(path, "r");
  char      line[2 * MPM_TEXT_LEN];
  PetscBool is = PETSC_FALSE;

  for (int k = 0; file && k < 20 && fgets(line, (int)sizeof line, file); k++)
    if (!strncmp(line, "method ", 7)) is = PETSC_TRUE;
  if (file) (void)fclose(file);
  return is;
}

/* Can a calibration write this file? It takes the place of an older one, and of nothing else. Sets errno. */
static PetscBool CanWrite(const char path[])
{
  char folder[PETSC_MAX_PATH_LEN];

  (void)snprintf(folder, sizeof folder, "%s", path);
  if (!access(path, F_OK)) return access(path, W_OK) ? PETSC_FALSE : PETSC_TRUE;
  return access(dirname(folder), W_OK) ? PETSC_FALSE : PETSC_TRUE;
}

PetscErrorCode MPMModelSetFromOptions(MPM mpm, MPMOptions o)
{
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsBool(o, "model_calibrate", NULL, &mpm->calibrate));
  if (mpm->calibrate && mpm->scene.dry_run && !MPMOptionsError(o))
    MPMOptionsFail(o, "-model_calibrate does not go with -dry_run: it times short runs");
  PetscCall(PetscStrncpy(mpm->model_file, "", sizeof mpm->model_file));
  PetscCall(MPMOptionsString(o, "model_file", NULL, mpm->model_file, &set));
  if (set && !mpm->calibrate && !MPMOptionsError(o) && access(mpm->model_file, R_OK))
    MPMOptionsFail(o, "-model_file: cannot read %s: %s; -model_calibrate writes it", mpm->model_file, strerror(errno));
  if (set && mpm->calibrate && !MPMOptionsError(o) && !CanWrite(mpm->model_file))
    MPMOptionsFail(o, "-model_file: cannot write %s: %s", mpm->model_file, strerror(errno));
  if (set && !MPMOptionsError(o) && !access(mpm->model_file, F_OK) && !IsModelFile(mpm->model_file))
    MPMOptionsFail(o, "-model_file: %s has no constants of the model; -model_calibrate %s", mpm->model_file,
                   mpm->calibrate ? "does not overwrite it" : "writes such a file");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the constants: from the file of a calibration if there is one for this method, else rough ones. Once the phases
   and the fields of the particles are known. Collective on mpm->comm. */
PetscErrorCode MPMModelSetUp(MPM mpm)
{
  char        wrong[MPM_TEXT_LEN] = "";
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  SetRough(mpm);
  if (!mpm->model_file[0])
    (void)snprintf(mpm->model_file, sizeof mpm->model_file, "%s/%s.model", mpm->output.dir, mpm->scene.name);
  PetscCallMPI(MPI_Comm_rank(mpm->comm, &rank));
  if (!rank) PetscCall(MPMModelLoad(mpm, wrong, sizeof wrong));
  PetscCallMPI(MPI_Bcast(&mpm->model, (PetscMPIInt)sizeof mpm->model, MPI_BYTE, 0, mpm->comm));
  PetscCall(PetscStrncpy(mpm->model_note, wrong, sizeof mpm->model_note));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What this process has now. Collective on the exchange. */
PetscErrorCode MPMModelShare(MPM mpm, MPMShare *s)
{
  MPMPatch   *patch = &mpm->exchange.patch;
  PetscReal   h     = PETSC_MAX_REAL;
  PetscMPIInt size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(mpm->comm, &size));
  PetscCall(PetscMemzero(s, sizeof *s));
  s->particles = (PetscReal)mpm->particles.n;
  s->processes = (PetscReal)size;
  MPMTilesFindSpans(patch); /* no step may have done so yet */
  for (PetscInt k = patch->own_lo[2]; k < patch->own_lo[2] + patch->own_n[2]; k++)
    for (PetscInt j = patch->own_lo[1]; j < patch->own_lo[1] + patch->own_n[1]; j++) {
      const MPMSpan *span = &patch->span[(k - patch->lo[2]) * patch->n[1] + j - patch->lo[1]];

      s->nodes += (PetscReal)PetscMax(0, span->last - span->first);
    }
  if (mpm->exchange.type->share) PetscCall(mpm->exchange.type->share(mpm, s));
  for (PetscInt d = 0; d < mpm->grid.dim; d++) h = PetscMin(h, mpm->grid.h[d]);
  MPMModelCross(mpm->grid.dim, s->ghosts / ((PetscReal)MPMBasisNodes(mpm->basis) - 1),
                s->particles / PetscMax(1, s->nodes), PetscSqrtReal(mpm->status.v2) * MPMTimeStep(mpm) / h, s);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &s->crossing, 1, MPIU_REAL, MPIU_SUM, mpm->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Predicts the step of the state as it is: mpm->predicted, of the process that takes longest in each part. Collective
   on the exchange. */
PetscErrorCode MPMModelPredict(MPM mpm)
{
  MPMShare  s;
  PetscReal ignored;

  PetscFunctionBeginUser;
  PetscCall(MPMModelShare(mpm, &s));
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++)
    mpm->predicted[e] = mpm->exchange.type->farms ? PoolTimer(mpm, e, &s, mpm->exchange.pool_cells, &ignored)
                                                  : MPMModelTimer(mpm, e, &s);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, mpm->predicted, MPM_MAX_TIMERS, MPIU_REAL, MPIU_MAX, mpm->exchange.data));
  if (mpm->path.on) { /* messages: what is left when the work costs nothing */
    const MPMModel model = mpm->model;

    PetscCall(PetscMemzero(mpm->model.rate, sizeof mpm->model.rate));
    mpm->model.kept = 0; /* that is work, of the processor time */
    for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++)
      mpm->path.messages[e] = mpm->exchange.type->farms ? 0 : MPMModelTimer(mpm, e, &s);
    mpm->model = model;
    PetscCallMPI(
        MPI_Allreduce(MPI_IN_PLACE, mpm->path.messages, MPM_MAX_TIMERS, MPIU_REAL, MPIU_MAX, mpm->exchange.data));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The predicted step of this scene in spatial decomposition on `size` processes, cut as the program would cut it. */
static PetscErrorCode SpatialStep(MPM mpm, const MPMHistogram *h, PetscMPIInt size, PetscReal moved, PetscReal *seconds,
                                  PetscReal *imbalance)
{
  MPMPartition part = {0};
  MPMShare     s    = {0};

  PetscFunctionBeginUser;
  MPMModelCosts(mpm, (PetscReal)mpm->particles.total / size, &part.costs);
  PetscCall(MPMPartitionChoose(h, size, MPM_BALANCE_START, &part));
  s           = part.worst;
  s.processes = size;
  MPMModelCross(mpm->grid.dim, s.ghosts / (PetscReal)(h->stencil - 1), s.particles / PetscMax(1, s.nodes), moved, &s);
  s.crossing *= size;
  *seconds   = Step(mpm, &s);
  *imbalance = part.imbalance;
  PetscCall(MPMPartitionDestroy(&part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The smallest number of particles a process at which cubes on `processes` keep this efficiency; 0: none up to 1e9. */
static PetscReal Isoefficiency(MPM mpm, PetscReal per_cell, PetscReal processes, PetscReal moved, PetscReal efficiency)
{
  for (PetscReal n = 64; n < 1e9; n *= 1.02) {
    const MPMShare alone = Cube(mpm, n, per_cell, 1, moved), s = Cube(mpm, n, per_cell, processes, moved);

    if (Step(mpm, &alone) >= efficiency * Step(mpm, &s)) return n;
  }
  return 0;
}

/* Prints what the model says of this scene on other numbers of processes. Collective on mpm->exchange.data. */
PetscErrorCode MPMModelView(MPM mpm)
{
  static const PetscMPIInt sizes[] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024};
  MPMHistogram             h;
  MPMShare                 s;
  PetscReal                serial, moved, bound, best = PETSC_MAX_REAL, volume = 1;
  PetscInt                 edge = 0, cross = 0;
  PetscMPIInt              rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(mpm->exchange.data, &rank));
  PetscCall(MPMModelShare(mpm, &s));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &s.particles, 1, MPIU_REAL, MPIU_SUM, mpm->exchange.data));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &s.nodes, 1, MPIU_REAL, MPIU_SUM, mpm->exchange.data));
  for (PetscInt d = 0; d < mpm->grid.dim; d++) volume = PetscMin(volume, mpm->grid.h[d] / mpm->grid.h[0]);
  moved    = PetscSqrtReal(mpm->status.v2) * MPMTimeStep(mpm) / (mpm->grid.h[0] * volume);
  s.ghosts = s.neighbours = s.crossing = s.row = 0;
  s.processes                                  = 1;
  serial                                       = Step(mpm, &s);
  PetscCall(MPMPrint(mpm, "model      constants %s%s%s\n  phase         s/step, on as many processes as here\n",
                     mpm->model.from, mpm->model_note[0] ? "; " : "", mpm->model_note));
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++)
    if (mpm->predicted[e] > 0) PetscCall(MPMPrint(mpm, "  %-12s %8.3g\n", MPMTimerName(e), (double)mpm->predicted[e]));
  PetscCall(
      MPMPrint(mpm, "  processes   spatial s/step  speed-up  efficiency  imbalance      pool s/step  speed-up\n"));
  PetscCall(MPMHistogramCreate(&mpm->grid, mpm->basis, mpm->exchange.data, &h));
  PetscCall(MPMSceneHistogram(mpm, &h));
  PetscCall(MPMHistogramFinish(&h));
  if (rank) { /* the first prints, and no other has the histogram */
    PetscCall(MPMHistogramDestroy(&h));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
    const PetscMPIInt size = sizes[k];
    PetscReal         t = serial, imbalance = 1, pool;

    if (MPMPartitionLargest(&mpm->grid, mpm->basis, size) < size) break;
    if (size > 1) PetscCall(SpatialStep(mpm, &h, size, moved, &t, &imbalance));
    s.processes = size;
    PetscCall(MPMPrint(mpm, "  %9d  %15.3g  %8.2f  %10.2f  %9.3f", size, (double)t, (double)(serial / t),
                       (double)(serial / t / size), (double)imbalance));
    if (size > 1) {
      pool = PoolStep(mpm, &s, mpm->exchange.pool_cells, NULL);
      if (!cross && t < pool) cross = size;
      PetscCall(MPMPrint(mpm, "  %15.3g  %8.2f", (double)pool, (double)(serial / pool)));
    }
    PetscCall(MPMPrint(mpm, "\n"));
  }
  PetscCall(MPMHistogramDestroy(&h));
  s.processes = 8;
  (void)PoolStep(mpm, &s, mpm->exchange.pool_cells, &bound);
  for (PetscInt c = MPMTileEdge(mpm->basis); c <= 256; c += MPMTileEdge(mpm->basis)) {
    const PetscReal t = PoolStep(mpm, &s, c, NULL);

    if (t < best) {
      best = t;
      edge = c;
    }
  }
  PetscCall(MPMPrint(
      mpm,
      "  pool: with these patches no number of workers exceeds a speed-up of %.2f; best patches on 8 processes %" PetscInt_FMT
      " cells an axis; ",
      (double)bound, edge));
  PetscCall(cross ? MPMPrint(mpm, "spatial is ahead from %" PetscInt_FMT " processes on\n", cross)
                  : MPMPrint(mpm, "spatial is never ahead\n"));
  PetscCall(MPMPrint(mpm, "  spatial keeps 0.9 of full blocks with this many particles a process:"));
  for (PetscInt p = 2; p <= 32768; p *= p < 32 ? 4 : 32) {
    const PetscReal n = Isoefficiency(mpm, s.particles / s.nodes, (PetscReal)p, moved, 0.9);

    PetscCall(n > 0 ? MPMPrint(mpm, "%s %.3g on %" PetscInt_FMT, p > 2 ? "," : "", (double)n, p)
                    : MPMPrint(mpm, "%s no number on %" PetscInt_FMT, p > 2 ? "," : "", p));
  }
  PetscCall(MPMPrint(mpm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
