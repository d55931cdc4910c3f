/* study_convergence.c - the convergence study: runs of one scene, each finer than the one before by a factor of two, and
   for each its error, its observed order of convergence and its time. The reference is the scene's known solution, or
   its finest run. */
#include <unistd.h>
#include "run/study.h"

/* The result of one run of the study. order: the order of convergence from the run before to this one. */
typedef struct {
  PetscReal  h, error, order, seconds; /* what was refined (m, s, or 1), m, 1, s */
  PetscInt   steps;
  PetscInt64 particles;
} Result;

/* Sets the options of run `level` of the study whose first run, 0, is the scene `base`. */
static PetscErrorCode SetRun(MPM base, PetscInt level, MPMChanges *c)
{
  const MPMStudy *study  = &base->study;
  const PetscInt  factor = (PetscInt)1 << level;
  char            name[2 * MPM_NAME_LEN];

  PetscFunctionBeginUser;
  (void)snprintf(name, sizeof name, "%s-%" PetscInt_FMT, base->scene.name, level + 1);
  PetscCall(MPMChangesOfStudy(c, base, name));
  if (!strcmp(study->vary, "grid")) PetscCall(MPMChangesRefine(c, base, level));
  if (!strcmp(study->vary, "ppc")) PetscCall(MPMChangesPpc(c, base, factor));
  if (!strcmp(study->vary, "dt")) PetscCall(MPMChangesStep(c, base, factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes run `level`. Its size and error go to result; if the finest run is the reference, its particles go to samples.
   If it stopped early, *status says so. Collective on core.comm. */
static PetscErrorCode MakeRun(MPM base, PetscInt level, Result *result, MPMSamples *samples, int *status)
{
  const PetscInt keeps = MPM_STUDY_FILES | MPM_STUDY_TELL | (base->scene.finest ? MPM_STUDY_SAMPLES : 0);
  MPMChanges     c     = {0};
  MPMStudyResult r;

  PetscFunctionBeginUser;
  PetscCall(SetRun(base, level, &c));
  PetscCall(MPMStudyMake(base, keeps, &r, samples));
  PetscCall(MPMChangesUndo(&c));
  PetscCheck(!r.refused[0], base->core.comm, PETSC_ERR_PLIB, "run %" PetscInt_FMT " was valid: %s", level + 1,
             r.refused);
  if (r.stop[0]) *status = MPM_EXIT_STOPPED;
  result->h         = !strcmp(base->study.vary, "grid")  ? r.h
                      : !strcmp(base->study.vary, "ppc") ? 1 / r.ppc
                      : r.fixed > 0                      ? r.fixed
                                                         : r.cfl;
  result->seconds   = r.wall;
  result->steps     = r.steps;
  result->particles = r.particles;
  result->error     = r.error;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintRun(MPM mpm, FILE *csv, PetscInt level, const Result *r)
{
  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&mpm->core.print,
                     "%4" PetscInt_FMT "  %10.4g  %10" PetscInt64_FMT "  %8" PetscInt_FMT "  %12.5g  ", level + 1,
                     (double)r->h, r->particles, r->steps, (double)r->error));
  PetscCall(r->order > PETSC_MIN_REAL ? MPMPrint(&mpm->core.print, "%7.3f", (double)r->order)
                                      : MPMPrint(&mpm->core.print, "%7s", "-"));
  PetscCall(MPMPrint(&mpm->core.print, "  %8.3g\n", (double)r->seconds));
  if (csv) {
    fprintf(csv, "%d,%.17g,%lld,%d,%.17g,", (int)level + 1, (double)r->h, (long long)r->particles, (int)r->steps,
            (double)r->error);
    if (r->order > PETSC_MIN_REAL) fprintf(csv, "%.6g", (double)r->order);
    fprintf(csv, ",%.4g\n", (double)r->seconds);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads and checks the options of every run before the first is made; with -dry_run it prints what they are. Collective
   on core.comm. */
static PetscErrorCode CheckRuns(MPM base, int *status)
{
  PetscFunctionBeginUser;
  for (PetscInt level = 0; level < base->study.levels && *status == MPM_EXIT_OK; level++) {
    MPMChanges     c = {0};
    MPMStudyResult r;

    PetscCall(SetRun(base, level, &c));
    PetscCall(MPMStudyMake(base, MPM_STUDY_DRY, &r, NULL));
    PetscCall(MPMChangesUndo(&c));
    if (r.refused[0]) {
      PetscCall(
          PetscFPrintf(base->core.comm, stderr, "run %" PetscInt_FMT " of the study: %s\n", level + 1, r.refused));
      *status = MPM_EXIT_INPUT;
    } else if (base->scene.dry_run) {
      PetscCall(MPMPrint(&base->core.print, "run %2" PetscInt_FMT "     ", level + 1));
      for (PetscInt d = 0; d < base->core.grid.dim; d++)
        PetscCall(MPMPrint(&base->core.print, "%s%" PetscInt_FMT, d ? "x" : "", r.cells[d]));
      PetscCall(MPMPrint(&base->core.print, " cells, %" PetscInt64_FMT " particles\n", r.particles));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the table of the n runs, and writes it to <name>_study.csv on the first process. */
static PetscErrorCode Report(MPM mpm, PetscInt n, Result *results)
{
  const char *what = !strcmp(mpm->study.vary, "grid")  ? "h"
                     : !strcmp(mpm->study.vary, "ppc") ? "1/ppc"
                     : mpm->time.fixed > 0             ? "dt"
                                                       : "cfl";
  char        path[2 * MPM_TEXT_LEN];
  PetscReal   x[MPM_MAX_LEVELS], y[MPM_MAX_LEVELS];
  PetscMPIInt rank;
  FILE       *csv  = NULL;
  PetscBool   plot = PETSC_TRUE, replaced;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(mpm->core.comm, &rank));
  (void)snprintf(path, sizeof path, "%s/%s_study.csv", mpm->output.dir, mpm->scene.name);
  replaced = !access(path, F_OK) ? PETSC_TRUE : PETSC_FALSE;
  if (!rank) {
    csv = fopen(path, "w");
    PetscCheck(csv, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot write %s", path);
    fprintf(csv, "run,%s,particles,steps,error,order,seconds\n", what);
  }
  PetscCall(MPMPrint(&mpm->core.print, " run  %10s   particles     steps     error (m)    order   seconds\n", what));
  for (PetscInt k = 0; k < n; k++) {
    x[k]             = results[k].h;
    y[k]             = results[k].error;
    results[k].order = k && y[k] > 0 && y[k - 1] > 0 ? PetscLogReal(y[k - 1] / y[k]) / PetscLogReal(x[k - 1] / x[k])
                                                     : PETSC_MIN_REAL; /* an error that is 0 has no order */
    plot             = plot && y[k] > 0 && y[k] < PETSC_MAX_REAL ? PETSC_TRUE : PETSC_FALSE;
    PetscCall(PrintRun(mpm, csv, k, &results[k]));
  }
  if (csv) PetscCheck(!fclose(csv), PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write the CSV of the study");
  if (n > 1 && y[n - 1] > y[n - 2])
    PetscCall(MPMPrint(&mpm->core.print,
                       "note       the error grew from run %" PetscInt_FMT " to run %" PetscInt_FMT
                       ": most of it does not come from %s, or the method does not converge here\n",
                       n - 1, n, what));
  PetscCall(MPMPrint(&mpm->core.print, "results    %s%s\n", path, replaced ? " (replaced)" : ""));
  PetscCall(plot ? MPMPrint(&mpm->core.print, "           drawn by: .venv/bin/python tools/plot.py %s\n", path)
                 : MPMPrint(&mpm->core.print, "           no plot of it: an error is 0 or not finite\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStudyConvergence(MPM mpm, int *status)
{
  const MPMStudy *study = &mpm->study;
  Result          results[MPM_MAX_LEVELS];
  MPMSamples      samples[MPM_MAX_LEVELS];
  PetscInt        runs = 0, compared;
  PetscMPIInt     rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(mpm->core.comm, &rank));
  PetscCall(MPMPrint(&mpm->core.print, "study      %s of %s: %" PetscInt_FMT " runs, refining %s, against %s\n",
                     study->type, mpm->scene.title, study->levels, study->vary,
                     mpm->scene.finest ? "the finest run" : "the known solution"));
  PetscCall(PetscMemzero(results, sizeof results));
  PetscCall(PetscMemzero(samples, sizeof samples));
  PetscCall(CheckRuns(mpm, status));
  if (mpm->scene.dry_run && *status == MPM_EXIT_OK)
    PetscCall(MPMPrint(&mpm->core.print, "dry run    the study is valid; no step was made\n"));
  if (mpm->scene.dry_run || *status != MPM_EXIT_OK) PetscFunctionReturn(PETSC_SUCCESS);
  for (; runs < study->levels && *status == MPM_EXIT_OK; runs++)
    PetscCall(MakeRun(mpm, runs, &results[runs], &samples[runs], status));
  if (*status != MPM_EXIT_OK) runs--;
  compared = mpm->scene.finest ? runs - 1 : runs; /* the finest run has no error of its own */
  for (PetscInt k = 0; mpm->scene.finest && *status == MPM_EXIT_OK && k < compared && !rank; k++) {
    PetscReal size;

    PetscCall(MPMSamplesCompare(&mpm->core.grid, &samples[k], &samples[runs - 1], &results[k].error, &size));
  }
  for (PetscInt k = 0; k < MPM_MAX_LEVELS; k++) PetscCall(MPMSamplesDestroy(&samples[k]));
  if (compared > 0 && (*status == MPM_EXIT_OK || !mpm->scene.finest)) PetscCall(Report(mpm, compared, results));
  if (*status == MPM_EXIT_OK && study->order_min > PETSC_MIN_REAL && compared > 1 &&
      !(results[compared - 1].order >= study->order_min)) {
    if (!rank) /* PetscFPrintf would write 3 as 3. */
      fprintf(stderr, "the order between the last two runs, %.3f, is below -study_order_min %g\n",
              (double)results[compared - 1].order, (double)study->order_min);
    *status = MPM_EXIT_STOPPED;
  }
  PetscCallMPI(MPI_Bcast(status, 1, MPI_INT, 0, mpm->core.comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
