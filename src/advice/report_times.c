/* report_times.c - what a run prints of its time: the prediction before the first step, and at the end the phases of
   its steps. */
#include "advice/advice.h"

#define LONG 1 /* s: steps that take as long are printed by phases unless -report_phases is false, and so is output */

MPMForecast MPMForecastOf(const MPMCore *core, const MPMTime *time, const MPMMonitor *mon, const MPMOutput *out,
                          const MPMCost *cost)
{
  const PetscReal left = time->end - PetscMax(core->t, core->stages.began); /* a dry run looks at later stages too */
  MPMForecast     f    = {.left = left, .dt = MPMTimeStep(core, time)};

  f.steps = PetscCeilReal(left / f.dt);
  for (PetscInt k = 0; k < 2; k++) { /* a step is cut at each exact time of output */
    const PetscReal every = k ? mon->every : out->every;

    if ((k ? mon->exact : out->exact) && every > 0)
      f.steps = PetscMax(f.steps, left / every * PetscCeilReal(every / f.dt * (1 - 1e-9)));
  }
  if (time->max_steps != PETSC_MAX_INT) f.steps = PetscMin(f.steps, (PetscReal)(time->max_steps - core->step));
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) f.step += cost->predicted[e];
  return f;
}

PetscErrorCode MPMReportPrediction(const MPMCore *core, const MPMCost *cost, const MPMForecast *f)
{
  const MPMStages *s = &core->stages;
  char             all[MPM_NAME_LEN], within[MPM_NAME_LEN], stages[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  if (cost->note[0]) PetscCall(MPMNote(&core->print, "%s", cost->note));
  MPMTimeWords(f->steps * f->step, all);
  (void)snprintf(within, sizeof within, "%g", (double)cost->model.within);
  PetscCall(MPMPrint(&core->print, "predict    %.6g steps of %.3g s: %s %s without output", (double)f->steps,
                     (double)f->step, cost->used[0] ? "about" : "roughly", all));
  PetscCall(cost->used[0]
                ? MPMPrint(&core->print, ", give or take a factor of %s (constants of %s)\n",
                           cost->model.within == 2 ? "two" : within, cost->used)
                : MPMPrint(&core->print, " (rough constants; a run of more than a second measures it first)\n"));
  if (s->n > 1 && f->left > 0) {
    const PetscReal times = (s->end - core->t) / f->left;

    MPMTimeWords(times * f->steps * f->step, stages);
    PetscCall(
        MPMPrint(&core->print,
                 "predict    that is this stage; with steps as here, all stages to t=%g s take %.6g steps, %s %s\n",
                 (double)s->end, (double)PetscCeilReal(times * f->steps), cost->used[0] ? "about" : "roughly", stages));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintTimer(const MPMCore *core, const char name[], PetscReal seconds, PetscReal predicted)
{
  const PetscReal steps = (PetscReal)PetscMax(1, core->step - core->timers.first),
                  per   = (PetscReal)PetscMax(1, core->particles.total) * steps;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&core->print, "  %-12s %8.3f  %5.1f  %8.1f  %12.3g  ", name, (double)seconds,
                     (double)(100 * seconds / core->timers.steps), (double)(1e9 * seconds / per),
                     (double)(seconds / steps)));
  PetscCall(predicted > 0
                ? MPMPrint(&core->print, "%11.3g  %6.2f\n", (double)predicted, (double)(seconds / steps / predicted))
                : MPMPrint(&core->print, "%11s  %6s\n", "-", "-"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReportPhases(const MPMCore *core, const MPMCost *cost, const MPMReport *report)
{
  const MPMTimers *timers = &core->timers;
  const PetscBool  shown  = report->phases || (!report->no_phases && timers->steps >= LONG);
  PetscReal        all    = 0;

  PetscFunctionBeginUser;
  if (core->step == timers->first) PetscFunctionReturn(PETSC_SUCCESS);
  if (shown) {
    PetscCall(
        MPMPrint(&core->print, "phase                s      %%   ns/particle/step      s/step    predicted   ratio\n"));
    for (PetscInt k = 0; k < timers->n; k++) {
      const PetscInt  e = MPMTimersRow(timers, k);
      const PetscReal s = MPMTimersSeconds(timers, e);

      all += cost->predicted[e];
      if (s > 0) PetscCall(PrintTimer(core, timers->name[e], s, cost->predicted[e]));
    }
    PetscCall(PrintTimer(core, "all", timers->steps, all));
    PetscCall(MPMPrint(&core->print, "model      constants %s\n", cost->model.from));
  }
  if (timers->output > 0.01 * timers->steps && (shown || timers->output >= LONG))
    PetscCall(MPMPrint(&core->print, "output     %.3g s for history and snapshots\n", timers->output));
  PetscFunctionReturn(PETSC_SUCCESS);
}
