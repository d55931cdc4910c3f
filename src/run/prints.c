/* prints.c - what a run prints before its first step and at its end, in sequence. The lines are made in the room
   advice, and by what has its own. */
#include "run/mpm.h"
#include "step/static.h"

/* Described in mpm.h. With -dry_run also what the model predicts of the run. */
PetscErrorCode MPMPrintStart(MPM mpm)
{
  MPMCore             *core    = &mpm->core;
  const MPMScene      *scene   = &mpm->scene;
  const MPMForecast    f       = MPMForecastOf(core, &mpm->time, &mpm->monitor, &mpm->output, &mpm->cost);
  const PetscReal      seconds = f.steps * f.step;
  const MPMCheckpoint *c       = &mpm->checkpoint;
  const PetscReal kept = !c->off && (c->every > 0 || (c->wall > 0 && seconds > c->wall)) ? 1 + (PetscReal)c->keep : 0;
  char            initial[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (core->stages.n)
    PetscCall(MPMPrint(&core->print, "stage      %s, %" PetscInt_FMT " of %" PetscInt_FMT ": t from %g to %g s%s\n",
                       scene->stages[core->stages.now - 1], core->stages.now, core->stages.n,
                       (double)core->stages.began, (double)mpm->time.end, core->rest.limit > 0 ? ", or to rest" : ""));
  PetscCall(MPMReportScene(core, scene));
  PetscCall(MPMReportBodies(core, scene));
  MPMInitialTell(scene, initial);
  if (initial[0]) PetscCall(MPMPrint(&core->print, "initial    %s\n", initial));
  PetscCall(MPMReportFields(core));
  PetscCall(MPMPresetPrint(mpm));
  PetscCall(MPMReportMethod(core, scene, &mpm->method));
  if (mpm->aside[0])
    PetscCall(MPMNote(&core->print,
                      "the %s frame has a method of its own and does not use these options of the file: %s",
                      core->grid.total ? "total" : "updated", mpm->aside));
  if (core->rest.aside)
    PetscCall(MPMNote(&core->print, "-history_rest adds no columns with -method_time static: each step ends at rest"));
  PetscCall(MPMReportParallel(core));
  if (core->implicit) {
    PetscCall(MPMStaticPrint(core));
    PetscCall(MPMPrint(
        &core->print,
        "predict    %.6g steps, in each a solve; how long they take is told by the first iterations, and by the first steps\n",
        (double)f.steps));
  } else {
    PetscCall(MPMPrint(&core->print, "stability  c=%.3g m/s |v|=%.3g m/s   dt=%.3g s = %.3g %s\n",
                       (double)PetscSqrtReal(core->status.c2), (double)PetscSqrtReal(core->status.v2), (double)f.dt,
                       (double)MPMCourant(core, f.dt), core->grid.total ? "h/c" : "h/(c+|v|)"));
    PetscCall(MPMReportPrediction(core, &mpm->cost, &f));
  }
  if (scene->dry_run) PetscCall(MPMMemoryPrint(core, &mpm->report, &mpm->cost, mpm->output.enabled, seconds));
  if (scene->dry_run && !core->implicit) /* how long a solve takes is not predicted */
    PetscCall(MPMModelView(&mpm->cost, core, scene, f.dt, f.steps, mpm->report.processes));
  PetscCall(MPMReportLoads(core, scene, mpm->time.end));
  PetscCall(MPMDiskPrint(core, &mpm->monitor, &mpm->output, &f, kept, scene->dry_run));
  PetscCall(MPMDoubtsStart(core, scene, &mpm->time, c->from[0] ? PETSC_TRUE : PETSC_FALSE));
  PetscCall(MPMMethodWarnings(core, scene, &mpm->method, &mpm->time, f.dt));
  PetscCall(MPMDoubtsWarn(core, scene, &mpm->method, &mpm->time, &f));
  PetscCall(MPMUnlikelyNote(core, scene, &mpm->time, &mpm->monitor, &f));
  if (scene->dry_run) PetscCall(MPMPrint(&core->print, "dry run    the scene is valid; no step was made\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in mpm.h. */
PetscErrorCode MPMPrintEnd(MPM mpm)
{
  MPMCore        *core  = &mpm->core;
  const MPMScene *scene = &mpm->scene;
  char            line[2 * MPM_TEXT_LEN];
  PetscInt64      digest;
  PetscLogDouble  now;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  if (core->print.progress) PetscCall(MPMPrint(&core->print, "\r\033[K"));
  (void)snprintf(line, sizeof line, "stopped at step %" PetscInt_FMT ", t=%g s: %s", core->step, (double)core->t,
                 core->stop); /* PETSc would write 3 as "3." */
  MPMPrintEndOf(&core->print, line, sizeof line);
  if (core->stop[0])
    PetscCall(PetscFPrintf(core->comm, stderr, "%s\n", line));
  else
    PetscCall(MPMPrint(&core->print, "done       %" PetscInt_FMT " steps, t=%g s, in %.3g s%s\n", core->step,
                       (double)core->t, now - mpm->report.start,
                       core->rest.reached ? " (-time_rest)"
                       : !MPMEnds(mpm)    ? " (-time_max_steps)"
                                          : ""));
  PetscCall(MPMReportEnergy(core, scene, &mpm->method, &mpm->monitor, &mpm->watch));
  PetscCall(MPMRestTell(core, scene, &mpm->monitor.now, &mpm->time));
  PetscCall(MPMAdvanceReport(mpm));
  PetscCall(MPMStaticReport(core));
  if (mpm->report.indicator && !MPMStatusIsBad(&core->status) && core->particles.total)
    PetscCall(MPMReportIndicator(core, scene));
  PetscCall(MPMWatchEnd(&mpm->watch, &core->print));
  if (MPMEnds(mpm) && !core->stop[0] && !mpm->checkpoint.from[0] && !mpm->monitor.off && core->stages.n < 2)
    PetscCall(MPMReportMet(core, &mpm->monitor.measures));
  PetscCall(MPMReportKnown(core, scene));
  PetscCall(MPMReportResults(core, scene, &mpm->output));
  PetscCall(MPMReportExchange(core));
  PetscCall(MPMReportPhases(core, &mpm->cost, &mpm->report));
#if defined(MPM_SIMULATE)
  PetscCall(MPMPrint(&core->print, "simulated  %.9g s a step\n",
                     (double)(core->timers.steps / PetscMax(1, core->step - core->timers.first))));
#endif
  PetscCall(MPMRoofline(&mpm->cost, core, mpm->report.limits, mpm->report.no_limits));
  if (MPMStatusIsBad(&core->status)) PetscFunctionReturn(PETSC_SUCCESS); /* the failed state is in no file */
  PetscCall(MPMParticlesDigest(&core->particles, core->exchange.data, &digest));
  PetscCall(MPMPrint(&core->print, "digest %016llx\n", (unsigned long long)digest));
  PetscFunctionReturn(PETSC_SUCCESS);
}
