/* calibrate.c - the constants of the model (model.c), measured: -model_calibrate makes short runs of the scene coarser
   and finer than it is, of about 150, 1500, 20,000 and 400,000 particles, on every process at once and each for itself,
   since processes share memory; times messages, a reduction, migrations and the pool's master, where there are
   processes for it; and all that a few times over, since what else a machine does slows it for seconds on end: the
   least of each counts. Last come the limits of a core. The constants go to a file, which later runs of the same method
   read. */
#include <errno.h>
#include "exchange_spatial.h"
#include "options.h"
#include "tiles.h"

#define LEVELS (MPM_RATE_SIZES + 1)
#define PASSES 5   /* through all measurements */
#define VARIES 1.2 /* times as long that a run takes is worth a word */
/* Runs of more particles are timed by the processor's clock, which other programs do not lengthen; for fewer particles,
   reading it would be a part of what it measures, and there the least of short runs does. */
#define MPM_CLOCKED 5e3
static const PetscReal goal[LEVELS]  = {150, 1500, 2e4, 4e5};
static const PetscInt  steps[LEVELS] = {600, 200, 60, 20}, repeats[LEVELS] = {10, 10, 5, 2};

/* What a short run left. */
typedef struct {
  PetscReal seconds[MPM_MAX_TIMERS]; /* s a step of each timer, at the least */
  PetscReal fastest, slowest;        /* s a step of the runs */
  PetscReal particles, nodes;
  PetscInt  steps;
} Sample;

/* Can a calibration write this file? It takes the place of an older one, and of nothing else. Sets errno. */
static PetscBool CanWrite(const char path[])
{
  char folder[PETSC_MAX_PATH_LEN];

  (void)snprintf(folder, sizeof folder, "%s", path);
  if (!access(path, F_OK)) return access(path, W_OK) ? PETSC_FALSE : PETSC_TRUE;
  return access(dirname(folder), W_OK) ? PETSC_FALSE : PETSC_TRUE;
}

/* --- Short runs ------------------------------------------------------------------------------------------------ */

static PetscErrorCode Set(const char name[], const char format[], double value)
{
  char text[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  (void)snprintf(text, sizeof text, format, value);
  PetscCall(PetscOptionsSetValue(NULL, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the options for the scene with this strategy and cells `coarser` times as large. */
static PetscErrorCode SetRun(MPM scene, const char strategy[], PetscReal coarser, PetscInt nsteps)
{
  char cells[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < scene->grid.dim; d++) {
    const PetscReal n = PetscMax(4, PetscFloorReal((PetscReal)scene->grid.cells[d] / coarser + 0.5));

    (void)snprintf(cells + strlen(cells), sizeof cells - strlen(cells), "%s%.0f", d ? "," : "", (double)n);
  }
  PetscCall(PetscOptionsSetValue(NULL, "-parallel_strategy", strategy));
  PetscCall(PetscOptionsSetValue(NULL, "-parallel_migrate", "direct"));
  PetscCall(PetscOptionsClearValue(NULL, "-grid_h"));
  PetscCall(PetscOptionsSetValue(NULL, "-grid_cells", cells));
  if (scene->dt_fixed > 0) PetscCall(Set("-dt_size", "%.17g", (double)(scene->dt_fixed * coarser)));
  PetscCall(PetscOptionsSetValue(NULL, "-output_format", "none"));
  PetscCall(PetscOptionsClearValue(NULL, "-output_every"));
  PetscCall(PetscOptionsClearValue(NULL, "-output_fields"));
  PetscCall(PetscOptionsClearValue(NULL, "-model_calibrate"));
  PetscCall(PetscOptionsClearValue(NULL, "-model_file")); /* it need not exist yet */
  PetscCall(Set("-time_max_steps", "%.0f", (double)nsteps));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes and sets up a run of the options as they are now; *mpm is NULL if they are not valid at this size. Collective
   on comm. */
static PetscErrorCode Make(MPI_Comm comm, MPM *mpm)
{
  MPMOptions o;

  PetscFunctionBeginUser;
  PetscCall(MPMCreate(comm, mpm));
  (*mpm)->quiet = PETSC_TRUE;
  PetscCall(MPMOptionsCreate(&o));
  PetscCall(MPMSetFromOptions(*mpm, o));
  (*mpm)->monitor.every = PETSC_INFINITY;
  (*mpm)->monitor.off   = PETSC_TRUE;
  if (!MPMOptionsError(o))
    PetscCall(MPMSetUp(*mpm));
  else
    PetscCall(MPMDestroy(mpm));
  PetscCall(MPMOptionsDestroy(&o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the lesser one of what was measured now and before; 0: never yet. */
static void Least(PetscReal *least, PetscReal now)
{
  *least = *least > 0 ? PetscMin(*least, now) : now;
}

static PetscErrorCode Slowest(MPI_Comm comm, PetscReal *seconds)
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, seconds, 1, MPIU_REAL, MPIU_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs the scene of about `n` particles for a number of steps, alone; the least times go to the sample. */
static PetscErrorCode RunAlone(MPM scene, PetscReal n, PetscInt nsteps, PetscInt nrepeats, Sample *sample)
{
  PetscReal coarser = PetscPowReal((PetscReal)scene->particles.total / n, 1 / (PetscReal)scene->grid.dim);

  PetscFunctionBeginUser;
  for (PetscInt k = 0, tries = 0; k < nrepeats && tries < nrepeats + 8; tries++) {
    PetscReal all = 0;
    MPMShare  share;
    MPM       mpm;

    PetscCall(SetRun(scene, "spatial", coarser, nsteps));
    PetscCall(Make(PETSC_COMM_SELF, &mpm));
    if (!mpm) { /* too coarse for its shapes */
      coarser /= 1.5;
      continue;
    }
    PetscCall(MPMModelShare(mpm, &share));
    mpm->path.clock = n > MPM_CLOCKED ? PETSC_TRUE : PETSC_FALSE;
    PetscCall(MPMRun(mpm));
    for (PetscInt e = 0; e < MPM_MAX_TIMERS && mpm->step; e++) {
      const PetscReal s = MPMTimerSeconds(mpm, e) / (PetscReal)mpm->step;

      Least(&sample->seconds[e], s);
      all += s;
    }
    Least(&sample->fastest, all);
    sample->slowest   = PetscMax(sample->slowest, all);
    sample->particles = share.particles;
    sample->nodes     = share.nodes;
    sample->steps     = mpm->step;
    PetscCall(MPMDestroy(&mpm));
    k++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* call + n each through the samples, small to large: `call` and the first `each` through the smallest two, or through
   another where shapes need more particles than the second should have; the other `each` through one sample each. */
static void Fit(MPM mpm, PetscInt e, const Sample sample[LEVELS], MPMRate *r)
{
  const PetscBool nodes  = e < MPM_TIMER_FORCES && mpm->phases[e].kind == MPM_NODES ? PETSC_TRUE : PETSC_FALSE;
  const int       second = sample[1].particles > 2 * sample[0].particles ? 1 : 2;
  PetscReal       n[LEVELS];

  for (int k = 0; k < LEVELS; k++) n[k] = nodes ? sample[k].nodes : sample[k].particles;
  r->each[0] = PetscMax(0, (sample[second].seconds[e] - sample[0].seconds[e]) / (n[second] - n[0]));
  r->call    = PetscMax(0, sample[0].seconds[e] - n[0] * r->each[0]);
  for (int k = 0; k < MPM_RATE_SIZES; k++) {
    r->size[k] = n[k + 1];
    if (k) r->each[k] = PetscMax(0, (sample[k + 1].seconds[e] - r->call) / n[k + 1]);
  }
}

enum { BURST = 8 }; /* messages at once */
#define LONG_MESSAGE (1 << 16)

/* --- Messages -------------------------------------------------------------------------------------------------- */

/* Seconds, each the least of many. */
typedef struct {
  PetscReal one, longer; /* a message of 8 B, and of LONG_MESSAGE */
  PetscReal burst[2];    /* exchanges of one message each way, and of BURST */
  PetscReal reduction;
} Messages;

/* Least seconds of one of many messages of so many bytes, there and back halved; processes 2k and 2k+1 are pairs. */
static PetscErrorCode PingPong(MPI_Comm comm, size_t bytes, PetscReal *least)
{
  PetscReal   seconds = PETSC_MAX_REAL;
  PetscMPIInt rank, size, peer, len;
  char       *buffer;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(MPMMessageLength(bytes, &len));
  PetscCall(PetscCalloc1(bytes, &buffer));
  peer = rank ^ 1;
  for (int batch = 0; batch < 20 && peer < size; batch++) {
    PetscLogDouble t0, t1;

    PetscCall(PetscTime(&t0));
    for (int k = 0; k < 50; k++)
      for (int turn = 0; turn < 2; turn++)
        if ((rank & 1) == turn)
          PetscCallMPI(MPI_Send(buffer, len, MPI_BYTE, peer, turn, comm));
        else
          PetscCallMPI(MPI_Recv(buffer, len, MPI_BYTE, peer, turn, comm, MPI_STATUS_IGNORE));
    PetscCall(PetscTime(&t1));
    seconds = PetscMin(seconds, (t1 - t0) / 100);
  }
  PetscCall(PetscFree(buffer));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPIU_REAL, MPIU_MIN, comm));
  Least(least, seconds);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Least seconds of an exchange of n short messages each way between the processes of a pair. */
static PetscErrorCode Burst(MPI_Comm comm, int n, PetscReal *least)
{
  PetscReal   seconds = PETSC_MAX_REAL;
  double      in[BURST], out[BURST] = {0};
  MPI_Request request[2 * BURST];
  PetscMPIInt rank, size, peer;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  peer = rank ^ 1;
  for (int batch = 0; batch < 20 && peer < size; batch++) {
    PetscLogDouble t0, t1;

    PetscCall(PetscTime(&t0));
    for (int k = 0; k < 50; k++) {
      for (int q = 0; q < n; q++) {
        PetscCallMPI(MPI_Irecv(&in[q], 1, MPI_DOUBLE, peer, q, comm, &request[q]));
        PetscCallMPI(MPI_Isend(&out[q], 1, MPI_DOUBLE, peer, q, comm, &request[n + q]));
      }
      PetscCallMPI(MPI_Waitall(2 * n, request, MPI_STATUSES_IGNORE));
    }
    PetscCall(PetscTime(&t1));
    seconds = PetscMin(seconds, (t1 - t0) / 50);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPIU_REAL, MPIU_MIN, comm));
  Least(least, seconds);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TimeMessages(MPI_Comm comm, Messages *least)
{
  PetscReal status[24] = {0}, best = PETSC_MAX_REAL;

  PetscFunctionBeginUser;
  PetscCall(PingPong(comm, 8, &least->one));
  PetscCall(PingPong(comm, LONG_MESSAGE, &least->longer));
  PetscCall(Burst(comm, 1, &least->burst[0]));
  PetscCall(Burst(comm, BURST, &least->burst[1]));
  for (int batch = 0; batch < 20; batch++) {
    PetscLogDouble t0, t1;

    PetscCallMPI(MPI_Barrier(comm));
    PetscCall(PetscTime(&t0));
    for (int k = 0; k < 50; k++) PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, status, 24, MPIU_REAL, MPIU_MAX, comm));
    PetscCall(PetscTime(&t1));
    best = PetscMin(best, (t1 - t0) / 50);
  }
  PetscCall(Slowest(comm, &best));
  Least(&least->reduction, best);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void FitMessages(PetscMPIInt size, const Messages *least, MPMModel *m)
{
  m->message   = least->one;
  m->wire      = PetscMax(0, (least->longer - least->one) / LONG_MESSAGE);
  m->post      = PetscMax(0, (least->burst[1] - least->burst[0]) / (BURST - 1));
  m->reduction = least->reduction / PetscCeilReal(PetscLog2Real((PetscReal)size));
}

/* Seconds of packing and unpacking a byte, in rows of a particle's velocity. */
static PetscErrorCode TimeCopy(PetscReal *least)
{
  enum { ROWS = 20000 };
  PetscReal(*from)[2], (*to)[2];
  PetscInt *list;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(2 * ROWS, &from, ROWS, &to, ROWS, &list));
  for (PetscInt q = 0; q < ROWS; q++) list[q] = 2 * q;
  for (PetscInt q = 0; q < 2 * ROWS; q++) from[q][0] = from[q][1] = 1;
  for (int repeat = 0; repeat < 10; repeat++) {
    PetscLogDouble t0, t1;

    PetscCall(PetscTime(&t0));
    for (PetscInt q = 0; q < ROWS; q++) memcpy(to[q], from[list[q]], sizeof *to);
    memcpy(from, to, ROWS * sizeof *to);
    PetscCall(PetscTime(&t1));
    Least(least, (t1 - t0) / (ROWS * sizeof *to));
  }
  PetscCall(PetscFree3(from, to, list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Seconds a byte of sums of tiles takes to be zeroed, packed and unpacked, where there are more tiles than a cache has
   room for: those whose sums are sent. */
static PetscErrorCode TimeKept(MPM scene, PetscReal *least)
{
  const PetscReal coarser = PetscPowReal((PetscReal)scene->particles.total / 1e5, 1 / (PetscReal)scene->grid.dim);
  const size_t    size = MPMTileNodes(scene->grid.dim, scene->basis) * MPM_NODE_NC * sizeof(PetscReal);
  const MPMTiles *t;
  MPM             mpm;
  char           *message;

  PetscFunctionBeginUser;
  PetscCall(SetRun(scene, "spatial", coarser, 1));
  PetscCall(Make(PETSC_COMM_SELF, &mpm));
  if (!mpm) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMTilesAssign(&mpm->exchange.patch, PETSC_TRUE, mpm->particles.start)); /* all are kept */
  t = &mpm->exchange.patch.tiles;
  PetscCall(PetscCalloc1((size_t)t->n_own * size, &message));
  for (int repeat = 0; repeat < 10; repeat++) {
    PetscLogDouble t0, t1;
    size_t         bytes = 0;

    PetscCall(PetscTime(&t0));
    memset(t->sum, 0, (size_t)t->n_own * size);
    for (PetscInt slot = 0; slot < t->n_own; slot++)
      bytes += MPMTilesCopy(&mpm->exchange.patch, slot, scene->program[0]->parts, PETSC_TRUE, message + bytes);
    bytes = 0;
    for (PetscInt slot = 0; slot < t->n_own; slot++)
      bytes += MPMTilesCopy(&mpm->exchange.patch, slot, scene->program[0]->parts, PETSC_FALSE, message + bytes);
    PetscCall(PetscTime(&t1));
    Least(least, (t1 - t0) / (PetscReal)bytes);
  }
  PetscCall(PetscFree(message));
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Migration ---------------------------------------------------------------------------------------- */

enum { SWARM, DIRECT, SWAP, WAYS }; /* without particles, and directly with SWAPPED of them */
#define SWAPPED 256
#define TURNS   10        /* of each way in a pass */
#define OTHER   (8 << 20) /* bytes that the caches have seen since: a migration comes after the sweeps of a step */
typedef struct {
  PetscReal particles, axes, migration[WAYS]; /* s */
} Trial;

/* Pairs of processes next to each other exchange `n` particles, far from each other in memory and not those of the last
   time, which stay what they are: only the cost counts, but for that of finding their processes and cells. */
static PetscErrorCode Swap(MPM mpm, MPMSpatial *s, PetscInt n, PetscInt first)
{
  const PetscInt all = mpm->particles.n;
  PetscInt       d   = 0;

  PetscFunctionBeginUser;
  while (d < mpm->grid.dim - 1 && s->p[d] == 1) d++;
  if (s->beside[d][s->me[d] % 2 == 0] == MPI_PROC_NULL || n > all / 2) n = 0; /* the last of an odd number, alone */
  s->nleavers = n;
  PetscCall(PetscMalloc1(n, &s->leaver));
  PetscCall(PetscMalloc1(n, &s->owner));
  PetscCall(PetscCalloc1(n, &s->hops));
  for (PetscInt q = 0; q < n; q++) {
    s->leaver[q]  = first + q * ((all - first) / n);
    s->hops[q][d] = s->me[d] % 2 ? -1 : 1;
  }
  mpm->particles.nkept = all;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Times migrations of about n particles a process; the least times go to the trial, particles stay 0 if there is no
 * such cut.
 */
static PetscErrorCode TimeMigration(MPM scene, PetscReal n, Trial *trial)
{
  PetscReal   seconds[WAYS];
  PetscMPIInt size;
  MPM         mpm;
  MPMShare    share;
  MPMSpatial *s;
  char       *other;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(scene->comm, &size));
  PetscCall(SetRun(scene, "spatial",
                   PetscPowReal((PetscReal)scene->particles.total / (n * size), 1 / (PetscReal)scene->grid.dim), 10));
  PetscCall(Make(scene->comm, &mpm));
  if (!mpm) PetscFunctionReturn(PETSC_SUCCESS);
  s = (MPMSpatial *)mpm->exchange.ctx;
  PetscCall(MPMModelShare(mpm, &share));
  trial->particles = share.particles;
  trial->axes      = share.axes;
  mpm->status.hops = 1; /* all messages, of no particles */
  PetscCall(PetscMalloc1(OTHER, &other));
  for (int way = 0; way < WAYS; way++) seconds[way] = PETSC_MAX_REAL;
  for (int turn = 0; turn < 3 * TURNS; turn++) {
    /* swaps after DMSwarm's turns: they leave particles where it would not have them */
    const int      way = turn < TURNS ? SWARM : turn % 2 ? DIRECT : SWAP;
    PetscLogDouble t0, t1;

    if (way == SWAP) PetscCall(Swap(mpm, s, SWAPPED, 7 * turn));
    memset(other, turn, OTHER);
    PetscCallMPI(MPI_Barrier(scene->comm));
    PetscCall(PetscTime(&t0));
    PetscCall(way == SWARM ? MPMMigrateSwarm(mpm, s) : MPMMigrateDirect(mpm, s));
    PetscCall(PetscTime(&t1));
    seconds[way] = PetscMin(seconds[way], t1 - t0);
  }
  PetscCall(Slowest(scene->comm, &trial->particles));
  PetscCall(PetscFree(other));
  for (int way = 0; way < WAYS; way++) {
    PetscCall(Slowest(scene->comm, &seconds[way]));
    Least(&trial->migration[way], seconds[way]);
  }
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void FitMigration(PetscMPIInt size, const Trial *a, const Trial *b, MPMModel *m)
{
  if (a->particles == 0 || b->particles == 0) return; /* no such cut: rough constants stay */
  for (int way = 0; way < 2; way++) {
    MPMMigration   *g      = &m->migration[way];
    const PetscReal stages = way ? a->axes : PetscCeilReal(PetscLog2Real((PetscReal)size));

    g->particle = PetscMax(0, (b->migration[way] - a->migration[way]) / (b->particles - a->particles));
    g->stage    = way ? m->message + m->post : 24 * m->reduction;
    g->process  = way ? 0 : 80 * m->wire;
    g->leaver   = PetscMax(0, b->migration[SWAP] - b->migration[DIRECT]) / SWAPPED; /* both ways copy them alike */
    g->call     = PetscMax(0, a->migration[way] - a->particles * g->particle - g->stage * stages - g->process * size);
  }
}

/* Steps of about 600 particles on each process, or of as many more as have a cut, together, without their migrations.
   The model is asked between spans of the run. */
#define SPANS 5
#define SPAN  60
typedef struct {
  PetscReal step;      /* s, the least */
  PetscReal predicted; /* s, without what an exchange costs besides its messages */
  PetscReal exchanges; /* of the process that has most of them; 0: there is no such cut */
} Together;

/* What the model says of a step with this cost of an exchange. Collective on scene->comm. */
static PetscErrorCode PredictWith(MPM scene, MPM mpm, PetscReal exchange, PetscReal *seconds)
{
  PetscFunctionBeginUser;
  mpm->model          = scene->model;
  mpm->model.exchange = exchange;
  *seconds            = 0;
  PetscCall(MPMModelPredict(mpm));
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) *seconds += e == MPM_TIMER_MIGRATE ? 0 : mpm->predicted[e];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a part of what the model says of the state as it is: bodies move from process to process, so the mean over the
   run counts. Collective on scene->comm. */
static PetscErrorCode PredictPart(MPM scene, MPM mpm, PetscReal part, Together *t)
{
  PetscReal none, all;

  PetscFunctionBeginUser;
  PetscCall(PredictWith(scene, mpm, 0, &none));
  PetscCall(PredictWith(scene, mpm, 1, &all)); /* 1 s: beside it nothing else counts */
  t->predicted += part * none;
  t->exchanges += part * (all - none);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TimeTogether(MPM scene, Together *t)
{
  PetscReal   coarser;
  PetscMPIInt size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(scene->comm, &size));
  coarser = PetscPowReal((PetscReal)scene->particles.total / (600. * size), 1 / (PetscReal)scene->grid.dim);
  for (int repeat = 0, tries = 0; repeat < 8 && tries < 16; tries++) {
    PetscReal step = PETSC_MAX_REAL;
    MPM       mpm;

    PetscCall(SetRun(scene, "spatial", coarser, SPANS * SPAN));
    PetscCall(Make(scene->comm, &mpm));
    if (!mpm) { /* too coarse for so many processes */
      coarser /= 1.5;
      continue;
    }
    t->predicted = t->exchanges = 0;
    PetscCall(PredictPart(scene, mpm, 0.5 / SPANS, t));
    for (int k = 1; k <= SPANS; k++) { /* by trapezoids */
      mpm->max_steps = k * SPAN;
      PetscCall(MPMRun(mpm));
      PetscCall(PredictPart(scene, mpm, (k < SPANS ? 1. : 0.5) / SPANS, t));
    }
    if (mpm->step) step = (mpm->wall_steps - MPMTimerSeconds(mpm, MPM_TIMER_MIGRATE)) / (PetscReal)mpm->step;
    PetscCall(Slowest(scene->comm, &step));
    PetscCall(MPMDestroy(&mpm));
    Least(&t->step, step);
    repeat++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The scene itself ------------------------------------------------------------------------------------------ */

#define CHECK_POINTS 1e6 /* more a process would take long */
#define CHECK_WORK   2e5 /* particles times steps of a run, but 20 to 500 steps */

/* Times first steps of the scene as it is: the least second a step goes to *least, unless it is too large. Collective
   on comm. */
static PetscErrorCode TimeItself(MPM scene, MPI_Comm comm, PetscReal *least)
{
  const PetscReal n = (PetscReal)scene->particles.total;
  PetscMPIInt     size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (n > CHECK_POINTS * size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SetRun(scene, "spatial", 1, (PetscInt)PetscMax(20, PetscMin(500, CHECK_WORK / n))));
  for (int repeat = 0; repeat < (n < 3e4 ? 8 : n < 3e5 ? 2 : 1); repeat++) {
    PetscReal step;
    MPM       mpm;

    PetscCall(Make(comm, &mpm));
    if (!mpm) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(MPMRun(mpm));
    step = mpm->step ? mpm->wall_steps / (PetscReal)mpm->step : PETSC_MAX_REAL;
    PetscCall(Slowest(comm, &step));
    PetscCall(MPMDestroy(&mpm));
    Least(least, step);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints what these took beside what the model says of them. Collective on comm, whose first process is the scene's. */
static PetscErrorCode CheckItself(MPM scene, MPI_Comm comm, PetscReal least)
{
  PetscReal   predicted = 0;
  PetscMPIInt size;
  MPM         mpm;

  PetscFunctionBeginUser;
  if (least == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(SetRun(scene, "spatial", 1, 1));
  PetscCall(Make(comm, &mpm));
  mpm->model = scene->model;
  PetscCall(MPMModelPredict(mpm));
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) predicted += mpm->predicted[e];
  PetscCall(MPMPrint(
      scene, "check      first steps of the scene itself on %d process%s: %.3g s a step, predicted %.3g, ratio %.2f\n",
      size, size > 1 ? "es" : "", (double)least, (double)predicted, (double)(predicted / least)));
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The pool -------------------------------------------------------------------------------------------------- */

/* A step of the pool: how long its master is busy at least, with how many chunks and bytes. */
typedef struct {
  PetscReal busy, chunks, bytes;
} Farm;

static PetscErrorCode TimePool(MPM scene, PetscInt cells, Farm *farm)
{
  MPM mpm;

  PetscFunctionBeginUser;
  PetscCall(
      SetRun(scene, "pool", PetscPowReal((PetscReal)scene->particles.total / 2e4, 1 / (PetscReal)scene->grid.dim), 20));
  PetscCall(Set("-pool_cells", "%.0f", (double)cells));
  PetscCall(Make(scene->comm, &mpm));
  if (!mpm) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMRun(mpm));
  if (mpm->step) {
    Least(&farm->busy, mpm->exchange.busy / (PetscReal)mpm->step);
    farm->chunks = mpm->exchange.chunks / (PetscReal)mpm->step;
    farm->bytes  = mpm->exchange.bytes / (PetscReal)mpm->step;
  }
  PetscCall(MPMDestroy(&mpm));
  PetscCallMPI(MPI_Bcast(farm, sizeof *farm / sizeof(PetscReal), MPIU_REAL, 0, scene->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void FitPool(const Farm *a, const Farm *b, MPMModel *m)
{
  const PetscReal det = a->chunks * b->bytes - b->chunks * a->bytes;

  if (det == 0) return;
  m->chunk = PetscMax(0, (a->busy * b->bytes - b->busy * a->bytes) / det);
  m->farm  = PetscMax(0, (a->chunks * b->busy - b->chunks * a->busy) / det);
}

/* --- The calibration ------------------------------------------------------------------------------------------- */

/* All that is measured. */
typedef struct {
  Sample    alone[LEVELS];
  Messages  messages;
  Trial     migration[2];
  PetscReal copy, kept; /* s a byte */
  Together  together;
  Farm      farm[2];
  PetscReal itself[2]; /* s a step on one process, and on all */
} Measured;

/* Measures everything once; the least of it and of what was measured before stays. */
static PetscErrorCode Measure(MPM scene, PetscMPIInt size, PetscMPIInt rank, Measured *all)
{
  const PetscInt edge = scene->grid.dim == 3 ? 3 : scene->grid.dim == 2 ? 4 : 8;

  PetscFunctionBeginUser;
  for (int k = 0; k < LEVELS; k++) PetscCall(RunAlone(scene, goal[k], steps[k], repeats[k], &all->alone[k]));
  PetscCall(TimeCopy(&all->copy));
  PetscCall(TimeKept(scene, &all->kept));
  if (!rank) PetscCall(TimeItself(scene, PETSC_COMM_SELF, &all->itself[0]));
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TimeMessages(scene->comm, &all->messages));
  PetscCall(TimeMigration(scene, 2e3, &all->migration[0]));
  PetscCall(TimeMigration(scene, 5e4, &all->migration[1]));
  PetscCall(TimeTogether(scene, &all->together));
  PetscCall(TimePool(scene, edge, &all->farm[0]));
  PetscCall(TimePool(scene, 4 * edge, &all->farm[1]));
  PetscCall(TimeItself(scene, scene->comm, &all->itself[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The constants of what was measured. */
static PetscErrorCode FitModel(MPM scene, PetscMPIInt size, const Measured *all)
{
  MPMModel *m = &scene->model;

  PetscFunctionBeginUser;
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) {
    Fit(scene, e, all->alone, &m->rate[e]);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &m->rate[e], (PetscMPIInt)(sizeof(MPMRate) / sizeof(PetscReal)), MPIU_REAL,
                               MPI_SUM, scene->comm));
    m->rate[e].call /= size;
    for (int k = 0; k < MPM_RATE_SIZES; k++) {
      m->rate[e].size[k] /= size;
      m->rate[e].each[k] /= size;
    }
  }
  m->copy = all->copy;
  if (all->kept > 0) m->kept = all->kept; /* else the scene has no cells of that size */
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  FitMessages(size, &all->messages, m);
  FitMigration(size, &all->migration[0], &all->migration[1], m);
  FitPool(&all->farm[0], &all->farm[1], m);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the constants for the scene, whose options are read and whose phases are known, and writes the file. The
   option database is changed: nothing can run after this. Collective on scene->comm. */
PetscErrorCode MPMCalibrate(MPM scene)
{
  MPMModel   *m = &scene->model;
  Measured    all;
  PetscReal   varied = 1;
  PetscMPIInt size, rank;
  char        date[MPM_NAME_LEN] = "?";

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(scene->comm, &size));
  PetscCallMPI(MPI_Comm_rank(scene->comm, &rank));
  PetscCall(MPMPrint(
      scene, "calibrate  %s: short runs of about 150 to 400,000 particles on each of %d process%s, 10 s to a minute\n",
      scene->scene.title, size, size > 1 ? "es" : ""));
  PetscCall(MPMStepSetUp(scene));
  PetscCall(MPMParticlesLayout(scene, &scene->particles));
  PetscCall(MPMModelSetUp(scene));
  PetscCall(PetscMemzero(&all, sizeof all));
  for (int pass = 0; pass < PASSES; pass++) {
    PetscCall(Measure(scene, size, rank, &all));
    for (int k = 0; k < LEVELS; k++)
      PetscCheck(all.alone[k].steps > 0 && (k < 2 || (all.alone[k].particles > 2 * all.alone[k - 1].particles &&
                                                      all.alone[k].particles > 2 * all.alone[0].particles)),
                 scene->comm, PETSC_ERR_SUP,
                 "the scene cannot be run with about %g particles, so it cannot be calibrated", (double)goal[k]);
  }
  PetscCall(FitModel(scene, size, &all));
  /* What an exchange costs besides its messages, calls and the waiting of processes for each other: what a step takes
     that the rest of the model does not explain, over the number of exchanges. */
  if (size > 1) PetscCall(TimeTogether(scene, &all.together));
  if (all.together.exchanges > 0)
    m->exchange = PetscMax(0, all.together.step - all.together.predicted) / all.together.exchanges;
  PetscCall(MPMLimits(scene->comm, &m->flop, &m->byte));
  PetscCall(PetscGetDate(date, sizeof date));
  (void)snprintf(m->from, sizeof m->from, "calibrated on %d process%s, %s", size, size > 1 ? "es" : " (messages rough)",
                 date);
  if (!rank) PetscCall(Save(scene));
  PetscCall(MPMPrint(scene, "results    %s\n", scene->model_file));
  if (!rank) PetscCall(CheckItself(scene, PETSC_COMM_SELF, all.itself[0]));
  if (size > 1) PetscCall(CheckItself(scene, scene->comm, all.itself[1]));
  for (int k = 1; k < LEVELS; k++) varied = PetscMax(varied, all.alone[k].slowest / all.alone[k].fastest);
  PetscCall(Slowest(scene->comm, &varied));
  if (varied > VARIES)
    PetscCall(MPMPrint(scene,
                       "note       the same run took up to %.1f times as long as at its fastest, which counts: other "
                       "work was running here, and runs beside it take longer than predicted\n",
                       (double)varied));
  if (size == 1)
    PetscCall(
        MPMPrint(scene, "note       messages and the pool were not measured: start on 2 processes or more for that\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
