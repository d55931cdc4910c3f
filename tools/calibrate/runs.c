/* runs.c - short runs of the scene, coarser or finer than it is: it sets their options, and measures their times. */
#include "calibrate.h"

/* Runs with more particles than this are timed in processor time, which other programs do not lengthen. With fewer
   particles, reading it would be a notable part of what is measured, and the least wall time of short runs is taken. */
#define CLOCKED 5e3

/* Sets an option to a number, in this format. */
PetscErrorCode SetNumber(const char name[], const char format[], double value)
{
  char text[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  (void)snprintf(text, sizeof text, format, value);
  PetscCall(PetscOptionsSetValue(NULL, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the options for a run of the scene with this strategy, with cells `coarser` times as large, and with this number
   of steps. */
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

/* Makes and sets up a run with the present options; *mpm is NULL if they are not valid at this size. Collective on
   comm. */
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

/* Keeps the lesser value of what was measured now and before; 0: nothing was measured yet. */
void Least(PetscReal *least, PetscReal now)
{
  *least = *least > 0 ? PetscMin(*least, now) : now;
}

/* Sets *seconds to the largest value of all processes. Collective on comm. */
PetscErrorCode Slowest(MPI_Comm comm, PetscReal *seconds)
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, seconds, 1, MPIU_REAL, MPIU_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs the scene with about n particles for nsteps steps, nrepeats times, on this process alone; the least times go to
   sample. Not collective. */
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
    if (!mpm) { /* too coarse for the shapes */
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

/* Fits a rate, call + n each, to the samples, of which the smallest is the first. `call` and the first `each` fit the
   two smallest samples, or the first and the third if the second one could not be made larger than the first; every
   other `each` fits one sample. Not collective. */
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
