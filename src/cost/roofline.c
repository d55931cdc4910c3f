/* roofline.c - prints, after a run, how much of the machine it used: the arithmetic and the memory traffic of the
   steps, by formulas for each phase, over their time; and beside them the limits of a core, measured here in about half
   a second. */
#include "cost/cost.h"

/* s, for each of the two limits. The best of many tries counts, since other programs may use the core for some
   hundredths of a second. */
#define BUDGET 0.25

/* Measures the floating-point operations per second of one core, with the vectors that the kernels use. As in the
   kernels, with 2 lanes a fused product and sum is a call of the C library if the program is built for any
   processor. */
static PetscErrorCode PeakFlops(PetscReal *best)
{
  volatile PetscReal start = 1, end;
  PetscLogDouble     begin, t0, t1;
#if defined(__x86_64__)
  MPMChains *const chains = MPMKernelWidth() == 8 ? MPMChains_8 : MPMKernelWidth() == 4 ? MPMChains_4 : MPMChains_2;
#else
  MPMChains *const chains = MPMChains_2;
#endif

  PetscFunctionBeginUser;
  *best = 0;
  PetscCall(PetscTime(&begin));
  for (t1 = begin; t1 < begin + BUDGET;) {
    PetscReal flops;

    PetscCall(PetscTime(&t0));
    flops = chains(200000, start, &end);
    PetscCall(PetscTime(&t1));
    *best = PetscMax(*best, flops / (t1 - t0));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the bytes per second of one core, for a = b + s c on arrays far larger than caches. An element counts as 24
   B, without the reading of a's cache lines, which most processors do before they overwrite them. */
static PetscErrorCode PeakBytes(PetscReal *best)
{
  const PetscInt n = 4000000;
  PetscReal     *a, *b, *c;
  PetscLogDouble begin, t0, t1;

  PetscFunctionBeginUser;
  *best = 0;
  PetscCall(PetscMalloc3(n, &a, n, &b, n, &c));
  for (PetscInt i = 0; i < n; i++) a[i] = b[i] = c[i] = 1;
  PetscCall(PetscTime(&begin));
  for (t1 = begin; t1 < begin + BUDGET;) {
    PetscCall(PetscTime(&t0));
    for (PetscInt i = 0; i < n; i++) a[i] = b[i] + 0.5 * c[i];
    PetscCall(PetscTime(&t1));
    *best = PetscMax(*best, 3 * sizeof(PetscReal) * (PetscReal)n / (t1 - t0));
    b[0]  = a[n - 1];
  }
  PetscCall(PetscFree3(a, b, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the least seconds of a core for an operation and for a byte of memory, as the mean over processes that
   measure at the same time, since cores share memory and cooling. It takes about half a second. Collective on comm. */
PetscErrorCode MPMLimits(MPI_Comm comm, PetscReal *flop, PetscReal *byte)
{
  PetscReal   flops, bytes, seconds[2];
  PetscMPIInt size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCallMPI(MPI_Barrier(comm));
  PetscCall(PeakFlops(&flops));
  PetscCallMPI(MPI_Barrier(comm));
  PetscCall(PeakBytes(&bytes));
  seconds[0] = 1 / flops;
  seconds[1] = 1 / bytes;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, seconds, 2, MPIU_REAL, MPIU_SUM, comm));
  *flop = seconds[0] / size;
  *byte = seconds[1] / size;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the line `speed`: operations and bytes are the mean over the processes, in the pool over master and workers.
   Beside them are the limits of a core, if the model's file has them or they are measured now: with -report_limits or,
   if no file has them, after a run whose steps took more than 20 s, unless no_limits. In the pool the master measures
   alone. Collective on the exchange. */
PetscErrorCode MPMRoofline(const MPMCost *cost, MPMCore *core, PetscBool limits, PetscBool no_limits)
{
  const PetscReal per     = (PetscReal)PetscMax(1, core->particles.total) * (core->step - core->timers.first);
  PetscReal       work[2] = {core->timers.flops, core->timers.bytes}, s = core->timers.steps, flop = cost->model.flop,
            byte = cost->model.byte;
  PetscMPIInt size;

  PetscFunctionBeginUser;
  if (core->print.quiet) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCallMPI(MPI_Bcast(&s, 1, MPIU_REAL, 0, core->exchange.data));
  if (core->step == core->timers.first || s <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, work, 2, MPIU_REAL, MPIU_SUM, core->exchange.data));
  for (int k = 0; k < 2; k++) work[k] /= s * size;
  PetscCall(MPMPrint(&core->print, "speed      %.3g ns/particle/step, %.3g GFlop/s, %.3g GB/s a process",
                     (double)(1e9 * s / per), (double)(1e-9 * work[0]), (double)(1e-9 * work[1])));
  if (limits || (!no_limits && flop == 0 && s > 20)) PetscCall(MPMLimits(core->exchange.data, &flop, &byte));
  if (flop > 0)
    PetscCall(MPMPrint(&core->print, ": %.2g of %.3g GFlop/s and %.2g of %.3g GB/s that a core can",
                       (double)(work[0] * flop), (double)(1e-9 / flop), (double)(work[1] * byte),
                       (double)(1e-9 / byte)));
  PetscCall(MPMPrint(&core->print, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
