/* progress.c - what a run will take by the steps that it has made, and its line of progress on a terminal. */
#include <unistd.h>
#include "advice/advice.h"

/* Returns whether standard output is a terminal. Under Open MPI's mpiexec it always seems to be one; then the standard
   output of the parent process decides. */
static PetscBool OnTerminal(void)
{
  char    link[64], to[MPM_NAME_LEN];
  ssize_t n;

  if (!getenv("OMPI_COMM_WORLD_RANK")) return isatty(STDOUT_FILENO) ? PETSC_TRUE : PETSC_FALSE;
  (void)snprintf(link, sizeof link, "/proc/%ld/fd/1", (long)getppid());
  n = readlink(link, to, sizeof to - 1);
  return n > 5 && !strncmp(to, "/dev/", 5) && (n < 9 || strncmp(to, "/dev/null", 9));
}

#define FIRST   0.1  /* s of steps after which the time of a run is told by them */
#define CHANGED 1.25 /* factor by which it differs from what was told before, if it is told again */
#define LONG    1    /* s: a run that takes as long has a line after the first look in any case */

/* Returns how many seconds of output are to come: as many a snapshot, or a line of the history, as so far. */
static PetscReal OutputLeft(const MPMCore *core, const MPMMonitor *mon, const MPMOutput *out, PetscReal left)
{
  const PetscBool snapshots = out->enabled && out->every > 0;
  const PetscReal every     = snapshots ? out->every : mon->every;

  if (!(every > 0)) return core->timers.output / PetscMax(1, core->step - core->timers.first); /* a step */
  return core->timers.output * left / every / PetscMax(1, snapshots ? (PetscReal)out->count : 1 + core->t / every);
}

/* Says how long a run of implicit steps will take, if what is left of the load takes as long as the same part of it took since
   the last look. A first step counts, since there are few, and so do tries that failed. */
static PetscErrorCode ForecastImplicit(MPMReport *report, const MPMCore *core, const MPMTime *time,
                                       const MPMMonitor *mon, const MPMOutput *out)
{
  const PetscReal spent = core->timers.steps - report->steps, made = core->t - report->t;
  PetscReal       left = time->end - core->t, all;
  PetscLogDouble  now;
  char            words[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  if (core->timers.steps < FIRST || core->timers.steps < 2 * report->steps || !(made > 0))
    PetscFunctionReturn(PETSC_SUCCESS);
  if (time->max_steps != PETSC_MAX_INT)
    left = PetscMin(left, made * (PetscReal)(time->max_steps - core->step) /
                              (PetscReal)(core->step - PetscMax(report->step, core->timers.first)));
  PetscCall(PetscTime(&now));
  all           = now - report->start + left * spent / made + OutputLeft(core, mon, out, left);
  report->step  = core->step;
  report->steps = core->timers.steps;
  report->t     = core->t;
  if (all < LONG || (all < CHANGED * report->told && report->told < CHANGED * all)) PetscFunctionReturn(PETSC_SUCCESS);
  report->told = all;
  MPMTimeWords(all, words);
  PetscCall(MPMSay(&core->print, "predict",
                   "after %.2g s: %.3g of %.6g s of the load in %" PetscInt_FMT " steps, about %s in all with output",
                   now - report->start, (double)core->t, (double)time->end, core->step, words));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReportForecast(MPMReport *report, const MPMCore *core, const MPMTime *time, const MPMMonitor *mon,
                                 const MPMOutput *out, const MPMCost *cost)
{
  const PetscInt made  = core->step - core->timers.first;
  PetscBool      first = PETSC_FALSE;
  PetscLogDouble now;
  MPMForecast    f;
  PetscReal      all, each;
  char           words[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  if (core->t >= time->end || core->step >= time->max_steps) PetscFunctionReturn(PETSC_SUCCESS);
  if (core->implicit) {
    PetscCall(ForecastImplicit(report, core, time, mon, out));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!report->step) { /* the first step touches memory for the first time, and does not count */
    report->step  = core->step;
    report->steps = core->timers.steps;
    report->told  = 0;
  }
  if (core->step < report->step + 2 || core->timers.steps < FIRST || core->timers.steps < 2 * report->steps)
    PetscFunctionReturn(PETSC_SUCCESS);
  f    = MPMForecastOf(core, time, mon, out, cost);
  each = (core->timers.steps - report->steps) / (PetscReal)(core->step - report->step);
  PetscCall(PetscTime(&now));
  all = now - report->start + f.steps * each + OutputLeft(core, mon, out, f.left);
  if (report->told == 0) {
    report->told = ((PetscReal)made + f.steps) * f.step;
    first        = all >= LONG;
  }
  report->step  = core->step;
  report->steps = core->timers.steps;
  if (!first && all < CHANGED * report->told && report->told < CHANGED * all) PetscFunctionReturn(PETSC_SUCCESS);
  report->told = all;
  MPMTimeWords(all, words);
  PetscCall(MPMSay(&core->print, "predict", "after %.2g s: %.6g more steps of %.3g s, about %s in all with output",
                   now - report->start, (double)f.steps, (double)each, words));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints a line of progress over the one before, at most once a second, if standard output is a terminal. Not
   collective. */
PetscErrorCode MPMReportProgress(MPMReport *report, MPMCore *core, const MPMTime *time)
{
  PetscMPIInt    rank;
  PetscLogDouble now, spent;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  if (rank || core->print.quiet || now - report->line < 1 || !OnTerminal()) PetscFunctionReturn(PETSC_SUCCESS);
  if (report->line > 0) {
    const PetscReal part = PetscMax(core->t / time->end, (PetscReal)core->step / time->max_steps);
    char            left[MPM_NAME_LEN];

    spent                = now - report->start;
    core->print.progress = PETSC_TRUE;
    MPMTimeWords(spent * (1 - part) / part, left);
    printf("\rstep %" PetscInt_FMT "  t=%.4g of %.4g s  %.0f %%  %s left   ", core->step, (double)core->t,
           (double)time->end, (double)(100 * part), left);
    (void)fflush(stdout);
  }
  report->line = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}
