/* memory.c - the largest memory that a run will take: what its processes have once the particles are there, which is
   measured, and what the steps, the output and the end of the run add to it, which is counted. */
#include "kernels/tile_index.h"
#include "advice/advice.h"
#include "parallel/exchange.h"
#include "step/static.h"
#include "step/step.h"

/* Returns a number of /proc/self/status in bytes: "VmRSS", the memory of this process, or "VmHWM", the most that it had
   so far; 0 where there is no such file. Not collective. */
PetscReal MPMMemoryHere(const char what[])
{
  char   line[MPM_NAME_LEN];
  double kB   = 0;
  FILE  *file = fopen("/proc/self/status", "r");

  if (!file) return 0;
  while (fgets(line, sizeof line, file))
    if (!strncmp(line, what, strlen(what)) && line[strlen(what)] == ':') kB = strtod(line + strlen(what) + 1, NULL);
  (void)fclose(file);
  return 1024 * (PetscReal)kB;
}

/* Bytes that are counted by what was measured with Debian's libraries: code that is loaded when it runs for the first
   time, MPI's buffers, HDF5's lists. */
#define STEPS_BYTES  1.5e6 /* the kernels, and the messages of steps */
#define OUTPUT_BYTES 3.0e6 /* the first snapshot */
#define WORKER_BYTES 4.0e6 /* a worker of the pool, beside what it had before the scene */
/* Of a particle in a snapshot: the numbers of the longest field here and in the sequence of ids, and the graph between
   both; if particles have changed process, also the numbers as PETSc packs them, of which it was seen to need some. */
#define SNAPSHOT_BYTES (2 * 9 * 8 + 16)
#define PACKED_BYTES   40
#define ROOM           1.1  /* of messages and jobs: most of their room for a quarter more is not written to */
#define SENT           0.6  /* part of the sums of a tile that a phase makes, and messages have */
#define NODE_BYTES     72   /* of a node in a snapshot: mass and velocity here and sorted, and the graph */
#define LIMITS_BYTES   96e6 /* the arrays of MPMLimits */
#define LIMITS_SECONDS 20   /* after which it measures */

/* Returns the bytes of the sums of a tile. */
static PetscReal TileBytes(const MPMCore *core)
{
  return (PetscReal)MPMTileNodes(core->grid.dim, core->basis) * (PetscReal)(MPM_NODE_NC * MPMExchangeLines(core)) *
         (PetscReal)sizeof(PetscReal);
}

/* Returns the bytes of a job of the pool: the sums of its tiles, and the fields of its particles, of which about a
   third come back. *jobs: how many there are at a time. Its particles are as dense as all others. Not collective. */
static PetscReal Job(const MPMCore *core, PetscMPIInt workers, PetscReal *jobs)
{
  const MPMTiles *t    = &core->exchange.patch.tiles;
  const PetscInt  edge = core->exchange.pool_cells / MPMTileEdge(core->basis);
  const PetscReal mine = PetscMax(1, (PetscReal)t->n_own), n = (PetscReal)core->particles.n;
  PetscReal       tiles = 1;

  for (PetscInt d = 0; d < core->grid.dim; d++) tiles *= (PetscReal)PetscMin(edge, t->n[d]);
  tiles = PetscMin(tiles, mine);
  *jobs = PetscMin(2 * (PetscReal)workers, PetscCeilReal(mine / tiles));
  return SENT * tiles * TileBytes(core) +
         1.3 * n * tiles / mine * (PetscReal)MPMParticlesBytes(&core->particles, MPM_SCRATCH);
}

/* Returns the bytes that this process will need besides those that it has; in the steps, and until the end of an
   output or the end of the run. snapshots: there are any; measures: the limits of a core are measured; processes: that
   have particles; workers: of the pool. Not collective. */
static PetscReal Later(const MPMCore *core, PetscBool snapshots, PetscBool indicator, PetscBool measures,
                       PetscMPIInt processes, PetscMPIInt workers)
{
  const MPMPatch *patch = &core->exchange.patch;
  const MPMTiles *t     = &patch->tiles;
  const PetscReal n     = (PetscReal)core->particles.n;
  PetscReal       steps = STEPS_BYTES, later = 0, nodes = 1, jobs;

  for (PetscInt d = 0; d < 3; d++) nodes *= (PetscReal)patch->own_n[d];
  steps += 2 * (PetscReal)t->room * TileBytes(core); /* sums of tiles that are kept, and their messages */
  steps += (PetscReal)MPMEnergyBytes(core) * n;
  steps += (PetscReal)MPMParticlesRowBytes(&core->particles, core->particles.saved) * n;
  if (workers) {
    const PetscReal job = Job(core, workers, &jobs);

    steps += ROOM * job * jobs;
  }
  if (snapshots)
    later = PetscMax((SNAPSHOT_BYTES + (processes > 1 ? PACKED_BYTES : 0)) * n, NODE_BYTES * nodes) + OUTPUT_BYTES;
  if (indicator && !core->particles.scratch[MPM_FIELD_INDEX_dx] && !core->particles.scratch[MPM_FIELD_INDEX_b] &&
      !core->particles.scratch[MPM_FIELD_INDEX_r])
    later = PetscMax(later, n * (PetscReal)(core->grid.dim * (PetscInt)sizeof(PetscReal)));
  if (measures) later = PetscMax(later, LIMITS_BYTES);
  return steps + later;
}

/* Prints the largest memory of the run, from its start to its end, if it makes its steps in so many seconds. Collective
   on the exchange. */
PetscErrorCode MPMMemoryPrint(const MPMCore *core, const MPMReport *report, const MPMCost *cost, PetscBool snapshots,
                              PetscReal seconds)
{
  const PetscBool measures = (PetscBool)(report->limits ||
                                         (!report->no_limits && cost->model.flop == 0 && seconds > LIMITS_SECONDS));
  const PetscReal now = MPMMemoryHere("VmRSS"), most = MPMMemoryHere("VmHWM");
  PetscReal       largest, all, jobs, solver = 0;
  PetscMPIInt     size, data;

  PetscFunctionBeginUser;
  if (!(now > 0)) PetscFunctionReturn(PETSC_SUCCESS); /* this system does not tell */
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCallMPI(MPI_Comm_size(core->exchange.data, &data));
  if (core->implicit) PetscCall(MPMStaticLaterBytes(core->implicit, &solver));
  largest = all = PetscMax(most, now + solver + Later(core, snapshots, report->indicator, measures, data, size - data));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPIU_REAL, MPIU_MAX, core->exchange.data));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPIU_REAL, MPIU_SUM, core->exchange.data));
  if (size > data) /* a worker has a job's fields, sums, message and answer */
    all += (PetscReal)(size - data) * (report->base + WORKER_BYTES + 2 * ROOM * Job(core, size - data, &jobs));
  PetscCall(MPMPrint(&core->print,
                     "memory     at the most %.4g MB in a process, %.4g MB in all; %.4g MB of a process are MPI's, "
                     "PETSc's and the program's before the scene\n",
                     (double)(1e-6 * largest), (double)(1e-6 * all), (double)(1e-6 * report->base)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
