/* runs.c - short runs of the scene, coarser or finer than it is: their options, and their times. */
#include "calibrate.h"

/* Runs of more particles are timed by the processor's clock, which other programs do not lengthen; for fewer particles,
   reading it would be a part of what it measures, and there the least of short runs does. */
#define CLOCKED 5e3

PetscErrorCode SetNumber(const char name[], const char format[], double value)
{
  char text[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  (void)snprintf(text, sizeof text, format, value);
  PetscCall(PetscOptionsSetValue(NULL, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the options for the scene with this strategy and cells `coarser` times as large. */
PetscErrorCode SetRun(MPM scene, const char strategy[], PetscReal coarser, PetscInt nsteps)
{
  char cells[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < scene->core.grid.dim; d++) {
    const PetscReal n = PetscMax(4, PetscFloorReal((PetscReal)scene->core.grid.cells[d] / coarser + 0.5));

    (void)snprintf(cells + strlen(cells), sizeof cells - strlen(cells), "%s%.0f", d ? "," : "", (double)n);
  }
  PetscCall(PetscOptionsSetValue(NULL, "-parallel_strategy", strategy));
  PetscCall(PetscOptionsSetValue(NULL, "-parallel_migrate", "direct"));
  PetscCall(PetscOptionsClearValue(NULL, "-grid_h"));
  PetscCall(PetscOptionsSetValue(NULL, "-grid_cells", cells));
  if (scene->time.fixed > 0) PetscCall(SetNumber("-dt_size", "%.17g", (double)(scene->time.fixed * coarser)));
  PetscCall(PetscOptionsSetValue(NULL, "-output_format", "none"));
  PetscCall(PetscOptionsClearValue(NULL, "-output_every"));
  PetscCall(PetscOptionsClearValue(NULL, "-output_fields"));
  PetscCall(PetscOptionsClearValue(NULL, "-report_limits"));
  PetscCall(PetscOptionsClearValue(NULL, "-report_path"));
  PetscCall(SetNumber("-time_max_steps", "%.0f", (double)nsteps));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes and sets up a run of the options as they are now; *mpm is NULL if they are not valid at this size. Collective
   on comm. */
PetscErrorCode MakeRun(MPI_Comm comm, MPM *mpm)
{
  MPMOptions o;

  PetscFunctionBeginUser;
  PetscCall(MPMCreate(comm, mpm));
  (*mpm)->core.print.quiet = PETSC_TRUE;
  PetscCall(MPMOptionsCreate(&MPMOptionTable, &o));
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
void Least(PetscReal *least, PetscReal now)
{
  *least = *least > 0 ? PetscMin(*least, now) : now;
}

PetscErrorCode Slowest(MPI_Comm comm, PetscReal *seconds)
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, seconds, 1, MPIU_REAL, MPIU_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs the scene of about `n` particles for a number of steps, alone; the least times go to the sample. */
PetscErrorCode RunAlone(MPM scene, PetscReal n, PetscInt nsteps, PetscInt nrepeats, ShortRuns *sample)
{
  PetscReal coarser = PetscPowReal((PetscReal)scene->core.particles.total / n, 1 / (PetscReal)scene->core.grid.dim);

  PetscFunctionBeginUser;
  for (PetscInt k = 0, tries = 0; k < nrepeats && tries < nrepeats + 8; tries++) {
    PetscReal all = 0;
    MPMShare  share;
    MPM       mpm;

    PetscCall(SetRun(scene, "spatial", coarser, nsteps));
    PetscCall(MakeRun(PETSC_COMM_SELF, &mpm));
    if (!mpm) { /* too coarse for its shapes */
      coarser /= 1.5;
      continue;
    }
    PetscCall(MPMModelShare(&mpm->core, MPMTimeStep(&mpm->core, &mpm->time), &share));
    mpm->core.timers.processor = n > CLOCKED ? PETSC_TRUE : PETSC_FALSE;
    PetscCall(MPMRun(mpm));
    for (PetscInt e = 0; e < mpm->core.timers.n && mpm->core.step; e++) {
      const PetscReal s = MPMTimersSeconds(&mpm->core.timers, e) / (PetscReal)mpm->core.step;

      Least(&sample->seconds[e], s);
      all += s;
    }
    Least(&sample->fastest, all);
    sample->slowest   = PetscMax(sample->slowest, all);
    sample->particles = share.particles;
    sample->nodes     = share.nodes;
    sample->steps     = mpm->core.step;
    PetscCall(MPMDestroy(&mpm));
    k++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* call + n each through the samples, small to large: `call` and the first `each` through the smallest two, or through
   another where shapes need more particles than the second should have; the other `each` through one sample each. */
void FitRate(const MPMCore *core, PetscInt e, const ShortRuns sample[LEVELS], MPMRate *r)
{
  const int second = sample[1].particles > 2 * sample[0].particles ? 1 : 2;
  PetscBool nodes  = PETSC_FALSE;
  PetscReal n[LEVELS];

  for (PetscInt k = 0; k < core->nphases; k++)
    if (core->phases[k].timer == e && core->phases[k].kind == MPM_NODES) nodes = PETSC_TRUE;
  for (int k = 0; k < LEVELS; k++) n[k] = nodes ? sample[k].nodes : sample[k].particles;
  r->each[0] = PetscMax(0, (sample[second].seconds[e] - sample[0].seconds[e]) / (n[second] - n[0]));
  r->call    = PetscMax(0, sample[0].seconds[e] - n[0] * r->each[0]);
  for (int k = 0; k < MPM_RATE_SIZES; k++) {
    r->size[k] = n[k + 1];
    if (k) r->each[k] = PetscMax(0, (sample[k + 1].seconds[e] - r->call) / n[k + 1]);
  }
}
