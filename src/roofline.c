/* roofline.c - how much of the machine a run used: arithmetic and memory traffic, counted by hand per phase, over the
   time of the steps; beside them the limits of this core, measured here in about a second.                           */
#include "mpm.h"

/* transfer_sums.c, for each number of lanes: n rounds of fused products and sums; how many operations that is. */
typedef PetscReal Chains(PetscInt n, PetscReal start, volatile PetscReal *end);
extern Chains     MPMChains_8, MPMChains_4, MPMChains_2;
static Chains    *Widest(void)
{
#if defined(__x86_64__)
  if (MPMTransferWidth() == 8) return MPMChains_8;
  if (MPMTransferWidth() == 4) return MPMChains_4;
#endif
  return MPMChains_2;
}

/* Floating-point operations per second of one core with the vectors that the kernels use. */
static PetscErrorCode PeakFlops(PetscReal *best)
{
  volatile PetscReal start = 1, end;

  PetscFunctionBeginUser;
  *best = 0;
  for (int repeat = 0; repeat < 5; repeat++) {
    PetscLogDouble t0, t1;
    PetscReal      flops;

    PetscCall(PetscTime(&t0));
    flops = Widest()(3000000, start, &end);
    PetscCall(PetscTime(&t1));
    *best = PetscMax(*best, flops / (t1 - t0));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bytes per second of one core, a = b + s c on arrays far larger than caches. */
static PetscErrorCode PeakBytes(PetscReal *best)
{
  const PetscInt n = 4000000;
  PetscReal     *a, *b, *c;

  PetscFunctionBeginUser;
  *best = 0;
  PetscCall(PetscMalloc3(n, &a, n, &b, n, &c));
  for (PetscInt i = 0; i < n; i++) a[i] = b[i] = c[i] = 1;
  for (int repeat = 0; repeat < 5; repeat++) {
    PetscLogDouble t0, t1;

    PetscCall(PetscTime(&t0));
    for (PetscInt i = 0; i < n; i++) a[i] = b[i] + 0.5 * c[i];
    PetscCall(PetscTime(&t1));
    *best     = PetscMax(*best, 3 * sizeof(PetscReal) * (PetscReal)n / (t1 - t0));
    b[repeat] = a[n - 1];
  }
  PetscCall(PetscFree3(a, b, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the line, of the first process. With limits after a run whose steps took 20 s, or with -report_limits: all
   processes measure at once, since cores share memory. Collective on the exchange. */
PetscErrorCode MPMRoofline(MPM mpm)
{
  const PetscReal s = mpm->wall_steps, per = (PetscReal)mpm->points.total * mpm->step;
  PetscReal       flops, bytes;

  PetscFunctionBeginUser;
  if (mpm->step == 0 || s <= 0 || mpm->exchange.type->farms) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMPrint(mpm, "speed      %.3g ns/particle/step, %.3g GFlop/s, %.3g GB/s a process",
                     (double)(1e9 * s / per), (double)(1e-9 * mpm->flops / s), (double)(1e-9 * mpm->bytes / s)));
  PetscCallMPI(MPI_Bcast(&mpm->wall_steps, 1, MPI_DOUBLE, 0, mpm->exchange.data));
  if (mpm->report_limits || mpm->wall_steps > 20) {
    PetscCallMPI(MPI_Barrier(mpm->exchange.data));
    PetscCall(PeakFlops(&flops));
    PetscCall(PeakBytes(&bytes));
    PetscCall(MPMPrint(mpm, ": %.2g of %.3g and %.2g of %.3g that the core can", (double)(mpm->flops / s / flops),
                       (double)(1e-9 * flops), (double)(mpm->bytes / s / bytes), (double)(1e-9 * bytes)));
  }
  PetscCall(MPMPrint(mpm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
