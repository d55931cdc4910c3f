/* monitor.c - totals of the state, the CSV history, and the checks of energy and momentum.

   All totals are exact sums (sum.c), so the history is the same text on any number of processes.                     */
#include <errno.h>
#include <sys/stat.h>
#include "mpm.h"

enum { KINETIC, STRAIN, MASS, SPEED, MOMENTUM, MOMENT = MOMENTUM + 3, NUM_SUMS = MOMENT + 3 };

/* Energies, momentum and mass of the particles as they are. Collective on the exchange. */
PetscErrorCode MPMTotalsCompute(MPM mpm, MPMTotals *totals)
{
  const PetscInt dim = mpm->grid.dim, fields = MPM_BIT(x) | MPM_BIT(v) | MPM_MATERIAL_BITS | MPM_BIT(kind);
  MPMView        view;
  MPMSum         sum[NUM_SUMS];
  MPMBlock       b;
  PetscReal      W;
  PetscInt64     count[2]; /* particles, and their fingerprint */

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < NUM_SUMS; k++) MPMSumZero(&sum[k]);
  PetscCall(MPMParticlesGetView(&mpm->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMKind     *kind = &mpm->scene.kinds[view.kind ? view.kind[p] : 0];
    const MPMMaterial *m    = &mpm->scene.materials[kind->material];
    PetscReal          v2   = 0;

    for (PetscInt d = 0; d < dim; d++) {
      const PetscReal v = view.v[p * dim + d];

      v2 += v * v;
      MPMSumAdd(&sum[MOMENTUM + d], kind->m * v);
      if (mpm->params.gravity[d] != 0) MPMSumAdd(&sum[MOMENT + d], kind->m * view.x[p * dim + d]);
    }
    MPMParticlesState(dim, &view, p, &b);
    m->type->law->energy[dim - 1](m, 0, 1, &b, &W);
    MPMSumAdd(&sum[KINETIC], 0.5 * kind->m * v2);
    MPMSumAdd(&sum[STRAIN], kind->V0 * W);
    MPMSumAdd(&sum[MASS], kind->m);
    MPMSumAdd(&sum[SPEED], kind->m * PetscSqrtReal(v2));
  }
  PetscCall(MPMParticlesRestoreView(&mpm->particles, fields, &view));
  PetscCall(MPMSumReduce(sum, NUM_SUMS, mpm->exchange.data));
  totals->kinetic = MPMSumValue(&sum[KINETIC]);
  totals->strain  = MPMSumValue(&sum[STRAIN]);
  totals->mass    = MPMSumValue(&sum[MASS]);
  totals->speed   = MPMSumValue(&sum[SPEED]);
  for (PetscInt d = 0; d < 3; d++) {
    totals->momentum[d] = MPMSumValue(&sum[MOMENTUM + d]);
    totals->moment[d]   = MPMSumValue(&sum[MOMENT + d]);
  }
  count[0] = mpm->particles.n;
  PetscCall(MPMParticlesFingerprint(&mpm->particles, &count[1]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT64, MPI_SUM, mpm->exchange.data));
  PetscCall(MPMParticlesCheck(&mpm->particles, mpm->exchange.data, count[0], count[1]));
  totals->n = count[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Work that gravity has done on the particles since the start, J: M g . (sum of (v_old + v_new)/2 dt), exact in free
   fall. Particles move with the new velocity, so their displacement is more than that by (v - v_start) dt/2. */
PetscReal MPMMonitorWork(MPM mpm)
{
  const MPMMonitor *mon  = &mpm->monitor;
  PetscReal         work = 0;

  for (PetscInt d = 0; d < mpm->grid.dim; d++)
    work += mpm->params.gravity[d] * (mon->now.moment[d] - mon->start.moment[d] -
                                      0.5 * mpm->params.dt * (mon->now.momentum[d] - mon->start.momentum[d]));
  return work;
}

PetscErrorCode MPMMonitorSetFromOptions(MPM mpm, MPMOptions o)
{
  MPMMonitor *mon    = &mpm->monitor;
  PetscBool   moving = PETSC_FALSE;

  PetscFunctionBeginUser;
  mon->every = mpm->time_end / 100;
  mon->last  = -1;
  PetscCall(MPMOptionsReal(o, "history_every", NULL, &mon->every, NULL));
  PetscCall(MPMOptionsReal(o, "check_energy", NULL, &mon->check_energy, NULL));
  PetscCall(MPMOptionsReal(o, "check_momentum", NULL, &mon->check_momentum, NULL));
  for (PetscInt k = 0; k < 6; k++)
    if (mpm->scene.faces[k / 2][k % 2].type == MPM_WALL_moving) moving = PETSC_TRUE;
  if ((mon->check_energy > 0 || mon->check_momentum > 0) && (mpm->scene.forced || moving))
    MPMOptionsFail(o, "-check_%s does not apply: the work of %s is not followed",
                   mon->check_energy > 0 ? "energy" : "momentum", moving ? "moving walls" : "body forces and loads");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Opens the history; on the first process only. */
static PetscErrorCode Open(MPM mpm)
{
  static const char axis[] = "xyz";
  char              path[2 * MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  (void)snprintf(path, sizeof path, "%s/%s.csv", mpm->output.dir, mpm->scene.name);
  mpm->monitor.file = fopen(path, "w");
  PetscCheck(mpm->monitor.file, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot write %s: %s", path, strerror(errno));
  fprintf(mpm->monitor.file, "step,time,dt,kinetic_energy,strain_energy,total_energy,external_work,energy_residual");
  for (PetscInt d = 0; d < mpm->grid.dim; d++) fprintf(mpm->monitor.file, ",momentum_%c", axis[d]);
  fprintf(mpm->monitor.file, ",mass,particles\n");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A line of the history; it is flushed when this returns. */
static PetscErrorCode WriteLine(MPM mpm, PetscReal residual)
{
  MPMMonitor      *mon = &mpm->monitor;
  const MPMTotals *t   = &mon->now;
  PetscMPIInt      rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(mpm->exchange.data, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  if (!mon->file) PetscCall(Open(mpm));
  fprintf(mon->file, "%" PetscInt_FMT ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", mpm->step, (double)mpm->t,
          (double)(mpm->step ? mpm->params.dt : 0), (double)t->kinetic, (double)t->strain,
          (double)(t->kinetic + t->strain), (double)MPMMonitorWork(mpm), (double)residual);
  for (PetscInt d = 0; d < mpm->grid.dim; d++) fprintf(mon->file, ",%.17g", (double)t->momentum[d]);
  fprintf(mon->file, ",%.17g,%" PetscInt64_FMT "\n", (double)t->mass, t->n);
  PetscCheck(!fflush(mon->file) && !ferror(mon->file), PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE,
             "cannot write the history: %s", strerror(errno));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* -check_energy and -check_momentum: leaves the reason in mpm->stop when exceeded. */
static void Check(MPM mpm, PetscReal residual)
{
  MPMMonitor *mon     = &mpm->monitor;
  PetscReal   change2 = 0, base;

  mon->energy_max = PetscMax(mon->energy_max, mon->now.kinetic + mon->now.strain);
  mon->speed_max  = PetscMax(mon->speed_max, mon->now.speed);
  base            = mon->energy_max + PetscAbsReal(MPMMonitorWork(mpm));
  if (mon->check_energy > 0 && !(PetscAbsReal(residual) <= mon->check_energy * base))
    (void)snprintf(mpm->stop, sizeof mpm->stop,
                   "energy changed by %g J, %.3g of the largest %g J; -check_energy allows %g", (double)residual,
                   (double)(residual / base), (double)base, (double)mon->check_energy);
  for (PetscInt d = 0; d < mpm->grid.dim; d++) {
    const PetscReal change = mon->now.momentum[d] - mon->start.momentum[d] -
                             mon->now.mass * mpm->params.gravity[d] * mpm->t;

    change2 += change * change;
  }
  if (mon->check_momentum > 0 && !(PetscSqrtReal(change2) <= mon->check_momentum * mon->speed_max))
    (void)snprintf(mpm->stop, sizeof mpm->stop,
                   "momentum changed by %g kg m/s, %.3g of sum m|v| = %g; -check_momentum allows %g",
                   (double)PetscSqrtReal(change2), (double)(PetscSqrtReal(change2) / mon->speed_max),
                   (double)mon->speed_max, (double)mon->check_momentum);
}

/* At its cadence, or forced: totals, a line of the history and the checks, which also act every 100 steps. Collective.
 */
PetscErrorCode MPMMonitorStep(MPM mpm, PetscBool force)
{
  MPMMonitor     *mon   = &mpm->monitor;
  const PetscBool due   = force || mpm->t >= mon->next ? PETSC_TRUE : PETSC_FALSE;
  const PetscBool check = (mon->check_energy > 0 || mon->check_momentum > 0) && mpm->step % 100 == 0 ? PETSC_TRUE
                                                                                                     : PETSC_FALSE;
  PetscReal       residual;

  PetscFunctionBeginUser;
  if (mon->off || (!due && !check) || mon->last == mpm->step) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMTotalsCompute(mpm, &mon->now));
  if (mpm->step == 0) mon->start = mon->now;
  residual = mon->now.kinetic + mon->now.strain - mon->start.kinetic - mon->start.strain - MPMMonitorWork(mpm);
  Check(mpm, residual);
  if (!due && !mpm->stop[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WriteLine(mpm, residual));
  mon->last = mpm->step;
  mon->next = MPMNextTime(mpm->t, mon->every);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first multiple of `every` after t (up to rounding); t itself if every is 0. */
PetscReal MPMNextTime(PetscReal t, PetscReal every)
{
  return every > 0 ? (PetscFloorReal(t / every * (1 + 1e-12)) + 1) * every * (1 - 1e-12) : t;
}

PetscErrorCode MPMMonitorDestroy(MPMMonitor *mon)
{
  PetscFunctionBeginUser;
  if (mon->file) (void)fclose(mon->file);
  mon->file = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}
