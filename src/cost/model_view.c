/* model_view.c - what the model predicts of a run, and with -report_processes of the same scene on other numbers of
   processes; -dry_run prints it before it ends. */
#include "cost/cost.h"
#include "kernels/tile_index.h"

/* Returns the share of one process if a full body is cut into `processes` cubes of n particles each, whose side is
   (n/per_cell)^(1/dim) cells. Ghosts are the layer above the cube that stencils reach. A node is sent by each tile that
   reaches it; on an axis on which it lies above the cube, only the last tile does. The fastest particle moves by
   `moved` cells per step. */
MPMShare MPMModelCube(const MPMCore *core, PetscReal n, PetscReal per_cell, PetscReal processes, PetscReal moved)
{
  const PetscReal dim = (PetscReal)core->grid.dim, reach = (PetscReal)MPMBasisNodes(core->basis) - 1;
  const PetscReal side = PetscPowReal(n / per_cell, 1 / dim), cells = n / per_cell;
  const PetscReal tiles = MPMTilesPerGhost(core->grid.dim, core->basis);
  const PetscReal one   = PetscPowReal(tiles, 1 / PetscMax(1, dim - 1)); /* the same for one axis */
  MPMShare        s     = {.particles = n, .processes = processes, .nodes = PetscPowReal(side + reach, dim)};

  if (processes > 1) {
    s.ghosts     = (PetscPowReal(one * side + reach, dim) - PetscPowReal(one * side, dim)) / tiles;
    s.neighbours = PetscPowReal(2, dim) - 1;
    s.axes       = dim;
    s.cuts       = dim * (PetscPowReal(processes, 1 / dim) - 1);
    MPMShareCross(core->grid.dim, dim * cells / side, per_cell, moved, &s);
    s.crossing *= processes;
  }
  return s;
}

/* Predicts the seconds of a step of this scene in spatial decomposition on `size` processes, and the imbalance, if the
   grid is cut as the program would cut it. */
static PetscErrorCode SpatialStep(const MPMModel *m, const MPMCore *core, const MPMHistogram *h, PetscMPIInt size,
                                  PetscReal moved, PetscReal *seconds, PetscReal *imbalance)
{
  MPMPartition part = {0};
  MPMShare     s    = {0};

  PetscFunctionBeginUser;
  MPMModelCosts(m, core, (PetscReal)core->particles.total / size, &part.costs);
  PetscCall(MPMPartitionChoose(h, size, MPM_BALANCE_start, &part));
  s           = part.worst;
  s.processes = size;
  MPMShareCross(core->grid.dim, s.ghosts / (PetscReal)(h->stencil - 1), s.particles / PetscMax(1, s.nodes), moved, &s);
  s.crossing *= size;
  *seconds   = MPMModelStep(m, core, &s);
  *imbalance = part.imbalance;
  PetscCall(MPMPartitionDestroy(&part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the smallest number of particles per process at which cubes on `processes` processes have this efficiency, or
   0 if no number up to 1e9 is enough. */
PetscReal MPMModelLeast(const MPMModel *m, const MPMCore *core, PetscReal per_cell, PetscReal processes,
                        PetscReal moved, PetscReal efficiency)
{
  for (PetscReal n = 64; n < 1e9; n *= 1.02) {
    const MPMShare alone = MPMModelCube(core, n, per_cell, 1, moved),
                   s     = MPMModelCube(core, n, per_cell, processes, moved);

    if (MPMModelStep(m, core, &alone) >= efficiency * MPMModelStep(m, core, &s)) return n;
  }
  return 0;
}

/* Sums the particles and nodes of all processes into the share of one process that has all, and sets the cells that the
   fastest particle moves in a step of dt s. Collective on core->exchange.data. */
static PetscErrorCode ShareOfOne(MPMCore *core, PetscReal dt, MPMShare *s, PetscReal *moved)
{
  PetscFunctionBeginUser;
  PetscCall(MPMModelShare(core, dt, s));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &s->particles, 1, MPIU_REAL, MPIU_SUM, core->exchange.data));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &s->nodes, 1, MPIU_REAL, MPIU_SUM, core->exchange.data));
  s->ghosts = s->neighbours = s->crossing = s->row = 0;
  s->processes                                     = 1;
  *moved = PetscSqrtReal(core->status.v2) * dt / MPMGridSmallestH(&core->grid);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints where the constants come from, and the seconds of each phase on as many processes as here, in a step and in
   all. */
static PetscErrorCode PrintPhases(const MPMCost *cost, MPMCore *core, PetscReal steps)
{
  PetscReal step = 0;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&core->print,
                     "model      constants %s\n  phase          s/step     s in all   on as many processes as here\n",
                     cost->model.from));
  for (PetscInt k = 0, e; k < core->timers.n; k++)
    if (cost->predicted[e = MPMTimersRow(&core->timers, k)] > 0) {
      step += cost->predicted[e];
      PetscCall(MPMPrint(&core->print, "  %-12s %8.3g  %11.3g\n", core->timers.name[e], (double)cost->predicted[e],
                         (double)(steps * cost->predicted[e])));
    }
  PetscCall(MPMPrint(&core->print, "  %-12s %8.3g  %11.3g\n", "all", (double)step, (double)(steps * step)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints a table with a line for each number of processes, with spatial decomposition and pool; *cross is the first
   number on which spatial decomposition is ahead of the pool, 0: none. s: the share of one process that has all. */
static PetscErrorCode PrintSizes(const MPMModel *m, MPMCore *core, const MPMHistogram *h, MPMShare s, PetscReal moved,
                                 PetscReal steps, PetscInt *cross)
{
  static const PetscMPIInt sizes[] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024};
  const PetscReal          serial  = MPMModelStep(m, core, &s);

  PetscFunctionBeginUser;
  *cross = 0;
  PetscCall(MPMPrint(&core->print, "  processes   spatial s/step          in all  speed-up  efficiency  imbalance"
                                   "      pool s/step          in all  speed-up\n"));
  for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
    const PetscMPIInt size = sizes[k];
    PetscReal         t = serial, imbalance = 1, pool;
    char              all[MPM_NAME_LEN];

    if (MPMPartitionLargest(&core->grid, core->basis, size) < size) break;
    if (size > 1) PetscCall(SpatialStep(m, core, h, size, moved, &t, &imbalance));
    s.processes = size;
    MPMTimeWords(steps * t, all);
    PetscCall(MPMPrint(&core->print, "  %9d  %15.3g  %14s  %8.2f  %10.2f  %9.3f", size, (double)t, all,
                       (double)(serial / t), (double)(serial / t / size), (double)imbalance));
    if (size > 1) {
      pool = MPMModelPoolStep(m, core, &s, core->exchange.pool_cells, NULL);
      if (!*cross && t < pool) *cross = size;
      MPMTimeWords(steps * pool, all);
      PetscCall(MPMPrint(&core->print, "  %15.3g  %14s  %8.2f", (double)pool, all, (double)(serial / pool)));
    }
    PetscCall(MPMPrint(&core->print, "\n"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the limits of the pool, and from how many processes on spatial decomposition is ahead of it (0: never). s: the
   share of one process that has all. */
static PetscErrorCode PrintPool(const MPMModel *m, MPMCore *core, MPMShare s, PetscInt cross)
{
  PetscReal bound;

  PetscFunctionBeginUser;
  s.processes = 8;
  (void)MPMModelPoolStep(m, core, &s, core->exchange.pool_cells, &bound);
  PetscCall(MPMPrint(
      &core->print,
      "  pool: with these patches no number of workers exceeds a speed-up of %.3g; best patches on 8 processes %" PetscInt_FMT
      " cells an axis; ",
      (double)bound, MPMModelPoolEdge(m, core, &s)));
  PetscCall(cross ? MPMPrint(&core->print, "spatial is ahead from %" PetscInt_FMT " processes on\n", cross)
                  : MPMPrint(&core->print, "spatial is never ahead\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints how many particles a process needs so that spatial decomposition keeps an efficiency of 0.9. */
static PetscErrorCode PrintLeast(const MPMModel *m, MPMCore *core, PetscReal per_cell, PetscReal moved)
{
  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&core->print, "  spatial keeps 0.9 of full boxes with this many particles a process:"));
  for (PetscInt p = 2; p <= 32768; p *= p < 32 ? 4 : 32) {
    const PetscReal n = MPMModelLeast(m, core, per_cell, (PetscReal)p, moved, 0.9);

    PetscCall(n > 0 ? MPMPrint(&core->print, "%s %.3g on %" PetscInt_FMT, p > 2 ? "," : "", (double)n, p)
                    : MPMPrint(&core->print, "%s no number on %" PetscInt_FMT, p > 2 ? "," : "", p));
  }
  PetscCall(MPMPrint(&core->print, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints what the model predicts of a run of so many steps of dt s, and if `sizes` of this scene on other numbers of
   processes. Collective on core->exchange.data. */
PetscErrorCode MPMModelView(const MPMCost *cost, MPMCore *core, const MPMScene *scene, PetscReal dt, PetscReal steps,
                            PetscBool sizes)
{
  const MPMModel *m = &cost->model;
  MPMHistogram    h;
  MPMShare        s;
  PetscReal       moved = 0;
  PetscInt        cross = 0;
  PetscMPIInt     rank;

  PetscFunctionBeginUser;
  PetscCall(PrintPhases(cost, core, steps));
  if (!sizes) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  PetscCall(ShareOfOne(core, dt, &s, &moved));
  PetscCall(MPMHistogramCreate(&core->grid, core->basis, core->exchange.data, &h));
  PetscCall(MPMSceneHistogram(scene, core, &h));
  PetscCall(MPMPointsHistogram(scene, core, &h));
  PetscCall(MPMHistogramFinish(&h));
  if (rank == 0) { /* only the first has the tables, and prints */
    PetscCall(PrintSizes(m, core, &h, s, moved, steps, &cross));
    PetscCall(PrintPool(m, core, s, cross));
    PetscCall(PrintLeast(m, core, s.particles / s.nodes, moved));
  }
  PetscCall(MPMHistogramDestroy(&h));
  PetscFunctionReturn(PETSC_SUCCESS);
}
