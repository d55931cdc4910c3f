/* report_times.c - what a run prints of its time: the prediction before the first step, and at the end the phases of its
   steps. */
#include "run/mpm.h"

#define LONG 1 /* s: steps that take as long are printed by phases unless -report_phases is false, and so is output */

PetscErrorCode MPMReportPrediction(MPM mpm, PetscReal steps, PetscReal step)
{
  const MPMCost *cost = &mpm->cost;
  char           all[MPM_NAME_LEN], within[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  if (cost->note[0]) PetscCall(MPMNote(&mpm->core.print, "%s", cost->note));
  MPMTimeWords(steps * step, all);
  (void)snprintf(within, sizeof within, "%g", (double)cost->model.within);
  PetscCall(MPMPrint(&mpm->core.print,
                     "predict    %.6g steps of %.3g s: about %s without output, give or take a factor of %s (%s%s)\n",
                     (double)steps, (double)step, all, cost->model.within == 2 ? "two" : within,
                     cost->used[0] ? "constants of " : "rough constants", cost->used));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintTimer(MPM mpm, const char name[], PetscReal seconds, PetscReal predicted)
{
  const PetscReal steps = (PetscReal)PetscMax(1, mpm->core.step - mpm->core.timers.first),
                  per   = (PetscReal)PetscMax(1, mpm->core.particles.total) * steps;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&mpm->core.print, "  %-12s %8.3f  %5.1f  %8.1f  %12.3g  ", name, (double)seconds,
                     (double)(100 * seconds / mpm->core.timers.steps), (double)(1e9 * seconds / per),
                     (double)(seconds / steps)));
  PetscCall(predicted > 0 ? MPMPrint(&mpm->core.print, "%11.3g  %6.2f\n", (double)predicted,
                                     (double)(seconds / steps / predicted))
                          : MPMPrint(&mpm->core.print, "%11s  %6s\n", "-", "-"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReportPhases(MPM mpm)
{
  const MPMTimers *timers = &mpm->core.timers;
  const PetscBool  shown  = mpm->report.phases || (!mpm->report.no_phases && timers->steps >= LONG) ? PETSC_TRUE
                                                                                                    : PETSC_FALSE;
  PetscReal        all    = 0;

  PetscFunctionBeginUser;
  if (mpm->core.step == timers->first) PetscFunctionReturn(PETSC_SUCCESS);
  if (shown) {
    PetscCall(MPMPrint(&mpm->core.print,
                       "phase                s      %%   ns/particle/step      s/step    predicted   ratio\n"));
    for (PetscInt k = 0; k < timers->n; k++) {
      const PetscInt  e = MPMTimersRow(timers, k);
      const PetscReal s = MPMTimersSeconds(timers, e);

      all += mpm->cost.predicted[e];
      if (s > 0) PetscCall(PrintTimer(mpm, timers->name[e], s, mpm->cost.predicted[e]));
    }
    PetscCall(PrintTimer(mpm, "all", timers->steps, all));
    PetscCall(MPMPrint(&mpm->core.print, "model      constants %s\n", mpm->cost.model.from));
  }
  if (timers->output > 0.01 * timers->steps && (shown || timers->output >= LONG))
    PetscCall(MPMPrint(&mpm->core.print, "output     %.3g s for history and snapshots\n", timers->output));
  PetscFunctionReturn(PETSC_SUCCESS);
}
