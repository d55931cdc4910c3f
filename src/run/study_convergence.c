/* study_convergence.c - the convergence study: runs of one scene, each finer than the one before by a factor of two;
   their errors, the differences of successive runs, observed orders of convergence, and where the runs lead. What is
   compared is the displacement of the particles or a quantity of interest; with the scene's known solution, with a
   known value, or with the finest run. */
#include <errno.h>
#include <unistd.h>
#include "run/study.h"

/* A run of the study. */
typedef struct {
  PetscReal  h, quantity, wall; /* what was refined (m, s, or 1); -study_quantity; s */
  PetscInt   steps;
  PetscInt64 particles;
} Row;

/* The study: n runs, errors [nerrors], differences [n - 1] from run k to run k + 1, in the unit of what is compared. */
typedef struct {
  PetscInt    n, nerrors;
  PetscBool   by_errors; /* is the solution known, so that orders are those of the errors? Else of the differences */
  const char *what, *unit;
  Row         row[MPM_MAX_LEVELS];
  PetscReal   error[MPM_MAX_LEVELS], size[MPM_MAX_LEVELS], difference[MPM_MAX_LEVELS], pair[MPM_MAX_LEVELS];
} Study;

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
  if (!strcmp(study->vary, "dt")) PetscCall(MPMChangesStep(c, base, (PetscReal)factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes run `level`, with its error where the solution is known. If the displacement is compared, its particles go to
   samples. If it stopped early, *status says so. Collective on core.comm. */
static PetscErrorCode MakeRun(MPM base, PetscInt level, Study *s, MPMSamples *samples, int *status)
{
  const MPMQuantity *q     = &base->study.quantity;
  const PetscInt     keeps = MPM_STUDY_FILES | MPM_STUDY_TELL | (q->on ? 0 : MPM_STUDY_SAMPLES);
  MPMChanges         c     = {0};
  Row               *row   = &s->row[level];
  MPMStudyResult     r;

  PetscFunctionBeginUser;
  PetscCall(SetRun(base, level, &c));
  PetscCall(MPMStudyMake(base, keeps, &r, samples));
  PetscCall(MPMChangesUndo(&c));
  PetscCheck(!r.refused[0], base->core.comm, PETSC_ERR_PLIB, "run %" PetscInt_FMT " was valid: %s", level + 1,
             r.refused);
  if (r.stop[0]) *status = MPM_EXIT_STOPPED;
  row->h          = !strcmp(base->study.vary, "grid")  ? r.h
                    : !strcmp(base->study.vary, "ppc") ? 1 / r.ppc
                    : r.fixed > 0                      ? r.fixed
                                                       : r.cfl;
  row->wall       = r.wall;
  row->steps      = r.steps;
  row->particles  = r.particles;
  row->quantity   = q->on ? r.column[q->row][q->component][q->seen] : 0;
  s->error[level] = q->on ? PetscAbsReal(row->quantity - q->value) : r.error;
  s->size[level]  = q->on ? PetscAbsReal(q->value) : r.size;
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

/* Compares the runs with each other, and with the finest one if nothing else is known. Collective on core.comm: the
   first process has the particles. */
static PetscErrorCode Compare(MPM mpm, MPMSamples samples[], Study *s)
{
  const MPMQuantity *q    = &mpm->study.quantity;
  const PetscInt     last = s->n - 1;
  PetscMPIInt        rank;
  PetscReal          ignored;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(mpm->core.comm, &rank));
  s->nerrors = s->by_errors ? s->n : last; /* the finest run has no error of its own */
  for (PetscInt k = 0; k < last && q->on; k++) {
    s->difference[k] = s->row[k + 1].quantity - s->row[k].quantity;
    if (s->by_errors) continue;
    s->error[k] = PetscAbsReal(s->row[last].quantity - s->row[k].quantity);
    s->size[k]  = PetscAbsReal(s->row[last].quantity);
  }
  for (PetscInt k = 0; k < last && !q->on && !rank; k++) {
    if (!s->by_errors)
      PetscCall(MPMSamplesCompare(&mpm->core.grid, &samples[k], &samples[last], &s->error[k], &s->size[k]));
    PetscCall(MPMSamplesCompare(&mpm->core.grid, &samples[k], &samples[k + 1], &s->difference[k], &ignored));
  }
  PetscCallMPI(MPI_Bcast(s->error, MPM_MAX_LEVELS, MPIU_REAL, 0, mpm->core.comm));
  PetscCallMPI(MPI_Bcast(s->size, MPM_MAX_LEVELS, MPIU_REAL, 0, mpm->core.comm));
  PetscCallMPI(MPI_Bcast(s->difference, MPM_MAX_LEVELS, MPIU_REAL, 0, mpm->core.comm));
  MPMSeriesOrders(s->by_errors ? s->n : last, s->by_errors ? s->error : s->difference, s->pair);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- What it prints ----------------------------------------------------------------------------------------------- */

/* Prints a number, or a minus where there is none. */
static PetscErrorCode PrintNumber(const MPMPrinter *p, const char format[], const char none[], PetscBool there,
                                  PetscReal value)
{
  PetscFunctionBeginUser;
  if (there)
    PetscCall(MPMPrint(p, format, (double)value));
  else
    PetscCall(MPMPrint(p, none, "-"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the line of run k, and writes it to the file. */
static PetscErrorCode PrintRun(MPM mpm, FILE *csv, PetscInt k, const Study *s)
{
  const MPMPrinter *p      = &mpm->core.print;
  const Row        *r      = &s->row[k];
  const PetscBool relative = s->size[k] > 0 ? PETSC_TRUE : PETSC_FALSE, next = k < s->n - 1 ? PETSC_TRUE : PETSC_FALSE,
                  order = MPMSeriesAgree(k + 1, s->pair);

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(p, "%4" PetscInt_FMT "  %10.4g  %10" PetscInt64_FMT "  %8" PetscInt_FMT "  ", k + 1, (double)r->h,
                     r->particles, r->steps));
  if (mpm->study.quantity.on) PetscCall(MPMPrint(p, "%12.6g  ", (double)r->quantity));
  PetscCall(MPMPrint(p, "%12.5g  ", (double)s->error[k]));
  PetscCall(PrintNumber(p, "%10.3g  ", "%10s  ", relative, relative ? s->error[k] / s->size[k] : 0));
  PetscCall(PrintNumber(p, "%12.5g  ", "%12s  ", next, next ? s->difference[k] : 0));
  PetscCall(PrintNumber(p, "%7.3f  ", "%7s  ", order, s->pair[k]));
  PetscCall(MPMPrint(p, "%8.3g\n", (double)r->wall));
  if (!csv) PetscFunctionReturn(PETSC_SUCCESS);
  fprintf(csv, "%d,%.17g,%lld,%d,%.17g,", (int)k + 1, (double)r->h, (long long)r->particles, (int)r->steps,
          (double)s->error[k]);
  if (order) fprintf(csv, "%.6g", (double)s->pair[k]);
  fprintf(csv, ",%.4g,", (double)r->wall);
  if (relative) fprintf(csv, "%.17g", (double)(s->error[k] / s->size[k]));
  fprintf(csv, ",");
  if (next) fprintf(csv, "%.17g", (double)s->difference[k]);
  if (mpm->study.quantity.on) fprintf(csv, ",%.17g", (double)r->quantity);
  fprintf(csv, "\n");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the order on which the last runs agree, and where the runs lead. */
static PetscErrorCode PrintLimit(MPM mpm, const Study *s)
{
  const MPMPrinter *p = &mpm->core.print;
  const PetscInt    n = s->by_errors ? s->n : s->n - 1, last = s->n - 1;
  PetscReal         rest, uncertainty;

  PetscFunctionBeginUser;
  if (MPMSeriesAgree(n, s->pair))
    PetscCall(MPMPrint(p, "order      %.3f: the last %d runs agree on it within %g (the pair before: %.3f)\n",
                       (double)s->pair[n - 1], s->by_errors ? 3 : 4, MPM_ORDER_BAND, (double)s->pair[n - 2]));
  else if (n > 2 && s->pair[n - 1] > MPM_NO_ORDER && s->pair[n - 2] > MPM_NO_ORDER)
    PetscCall(MPMPrint(p,
                       s->pair[n - 1] > 0 && s->pair[n - 2] > 0
                           ? "order      -: the last two pairs of %s give %.3f and %.3f, which differ by more than %g\n"
                           : "order      -: the last two pairs of %s give %.3f and %.3f, of which one does not fall\n",
                       s->by_errors ? "errors" : "differences", (double)s->pair[n - 2], (double)s->pair[n - 1],
                       MPM_ORDER_BAND));
  else
    PetscCall(MPMPrint(p, "order      -: it takes two pairs of %s that are not 0\n",
                       s->by_errors ? "errors" : "differences"));
  if (!MPMSeriesRest(last, s->difference, &rest, &uncertainty))
    PetscCall(last > 1 ? MPMPrint(p, "limit      none: the differences of the runs do not fall\n")
                       : MPMPrint(p, "limit      unknown: it takes three runs\n"));
  else if (mpm->study.quantity.on)
    PetscCall(MPMPrint(p, "limit      %s goes to %.6g +- %.2g %s (Richardson)\n", mpm->study.quantity.name,
                       (double)(s->row[last].quantity + rest), (double)uncertainty, s->unit));
  else
    PetscCall(MPMPrint(p, "limit      the last run is %.3g +- %.2g m from where the runs lead (Richardson)\n",
                       (double)rest, (double)uncertainty));
  if (s->by_errors || last < 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMPrint(p, "bias       errors are against the finest run: they lack its own error, "));
  if (MPMSeriesFalls(last, s->difference))
    PetscCall(MPMPrint(p, "about %.3g %s,", (double)PetscAbsReal(rest), s->unit));
  else
    PetscCall(MPMPrint(p, "which is not known,"));
  PetscCall(MPMPrint(p, " so they fall too fast; orders are those of the differences\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says whether the runs converge. */
static PetscErrorCode PrintVerdict(MPM mpm, const Study *s)
{
  const MPMPrinter *p           = &mpm->core.print;
  const PetscInt    n           = s->n;
  const PetscBool   differences = MPMSeriesFalls(n - 1, s->difference);

  PetscFunctionBeginUser;
  if (s->by_errors && s->error[n - 1] > s->error[n - 2])
    PetscCall(MPMPrint(p,
                       "note       the error grew from run %" PetscInt_FMT " to run %" PetscInt_FMT
                       ": most of it does not come from %s, or the method does not converge here\n",
                       n - 1, n, s->what));
  if (s->by_errors && n > 2 && MPMSeriesFalls(n, s->error) && s->error[n - 2] > s->error[n - 3])
    PetscCall(MPMPrint(p, "verdict    -: the errors do not fall steadily, %.3g, %.3g, %.3g %s: make one run more\n",
                       (double)s->error[n - 3], (double)s->error[n - 2], (double)s->error[n - 1], s->unit));
  else if (s->by_errors && MPMSeriesFalls(n, s->error))
    PetscCall(MPMPrint(p, "verdict    converges to the known %s, as far as these runs tell\n",
                       mpm->study.quantity.on ? "value" : "solution"));
  else if (s->by_errors && differences)
    PetscCall(MPMPrint(p,
                       "verdict    does not converge to the known %s: the runs lead to another, and an error of about "
                       "%.3g %s does not come from %s\n",
                       mpm->study.quantity.on ? "value" : "solution", (double)s->error[n - 1], s->unit, s->what));
  else if (n < 3)
    PetscCall(MPMPrint(p, "verdict    -: it takes three runs\n"));
  else if (differences)
    PetscCall(MPMPrint(p, "verdict    converges, as far as these runs tell\n"));
  else
    PetscCall(MPMPrint(p, "verdict    does not converge: the last differences of runs, %.3g and %.3g %s, do not fall\n",
                       (double)PetscAbsReal(s->difference[n - 3]), (double)PetscAbsReal(s->difference[n - 2]),
                       s->unit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the table of the runs and what it says, and writes it to <name>_study.csv on the first process. */
static PetscErrorCode Report(MPM mpm, const Study *s, int *status)
{
  const MPMPrinter *p = &mpm->core.print;
  char              path[2 * MPM_TEXT_LEN], error[MPM_NAME_LEN], fault[MPM_TEXT_LEN] = "";
  PetscMPIInt       rank;
  FILE             *csv     = NULL;
  int               written = MPM_EXIT_OK;
  PetscBool         plot    = PETSC_TRUE, replaced;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(mpm->core.comm, &rank));
  (void)snprintf(path, sizeof path, "%s/%s_study.csv", mpm->output.dir, mpm->scene.name);
  replaced = !access(path, F_OK) ? PETSC_TRUE : PETSC_FALSE;
  if (!rank) {
    (void)unlink(path); /* a link to another file is not followed */
    csv = fopen(path, "wx");
    if (!csv) (void)snprintf(fault, sizeof fault, "cannot write %.1500s: %s", path, strerror(errno));
  }
  if (csv) {
    fprintf(csv, "run,%s,particles,steps,error,order,seconds,relative,difference%s\n", s->what,
            mpm->study.quantity.on ? ",quantity" : "");
  }
  (void)snprintf(error, sizeof error, "error (%s)", s->unit);
  PetscCall(MPMPrint(p, " run  %10s   particles     steps  ", s->what));
  if (mpm->study.quantity.on) PetscCall(MPMPrint(p, "%12s  ", "quantity"));
  PetscCall(MPMPrint(p, "%12s    relative  to next run    order   seconds\n", error));
  for (PetscInt k = 0; k < s->nerrors; k++) {
    PetscCall(PrintRun(mpm, csv, k, s));
    plot = plot && s->error[k] > 0 && s->error[k] < PETSC_MAX_REAL ? PETSC_TRUE : PETSC_FALSE;
  }
  if (csv && (fflush(csv) || ferror(csv)))
    (void)snprintf(fault, sizeof fault, "cannot write %.1500s: %s", path, strerror(errno));
  if (s->n > 1) {
    PetscCall(PrintLimit(mpm, s));
    PetscCall(PrintVerdict(mpm, s));
  }
  if (csv && fclose(csv) && !fault[0])
    (void)snprintf(fault, sizeof fault, "cannot write %.1500s: %s", path, strerror(errno));
  PetscCall(MPMStudyFault(mpm, fault, &written));
  if (written != MPM_EXIT_OK) {
    *status = written;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMPrint(p, "results    %s%s\n", path, replaced ? " (replaced)" : ""));
  PetscCall(plot ? MPMPrint(p, "           drawn by: .venv/bin/python tools/plot.py %s\n", path)
                 : MPMPrint(p, "           no plot of it: an error is 0 or not finite\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks the order of the last pair (-study_order_min). */
static PetscErrorCode CheckOrder(MPM mpm, const Study *s, int *status)
{
  const PetscReal order = s->pair[s->by_errors ? s->n - 1 : s->n - 2];
  PetscMPIInt     rank;

  PetscFunctionBeginUser;
  if (!mpm->study.order_wanted || order >= mpm->study.order_min) PetscFunctionReturn(PETSC_SUCCESS);
  *status = MPM_EXIT_STOPPED;
  PetscCallMPI(MPI_Comm_rank(mpm->core.comm, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  if (order > MPM_NO_ORDER) /* PetscFPrintf would write 3 as 3. */
    fprintf(stderr, "the order of the last pair of %s, %.3f, is below -study_order_min %g\n",
            s->by_errors ? "errors" : "differences", (double)order, (double)mpm->study.order_min);
  else
    fprintf(stderr, "no order for -study_order_min %g: %s is 0\n", (double)mpm->study.order_min,
            s->by_errors ? "an error" : "a difference");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStudyConvergence(MPM mpm, int *status)
{
  const MPMStudy    *study = &mpm->study;
  const MPMQuantity *q     = &study->quantity;
  MPMSamples         samples[MPM_MAX_LEVELS];
  Study              s;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(samples, sizeof samples));
  PetscCall(PetscMemzero(&s, sizeof s));
  s.by_errors = q->on ? q->known : mpm->scene.known ? PETSC_TRUE : PETSC_FALSE;
  s.unit      = !q->on                         ? "m"
                : q->row < MPM_NUM_DIAGNOSTICS ? MPMDiagnostics[q->row].unit
                                               : mpm->monitor.measures.column[q->measure].unit;
  s.what      = !strcmp(study->vary, "grid")  ? "h"
                : !strcmp(study->vary, "ppc") ? "1/ppc"
                : mpm->time.fixed > 0         ? "dt"
                                              : "cfl";
  PetscCall(MPMPrint(&mpm->core.print, "study      %s of %s: %" PetscInt_FMT " runs, refining %s, %s%s against %s\n",
                     study->type, mpm->scene.title, study->levels, study->vary, q->on ? q->name : "",
                     q->on ? "" : "displacements",
                     !s.by_errors ? "the finest run"
                     : q->on      ? "its known value"
                                  : "the known solution"));
  PetscCall(CheckRuns(mpm, status));
  if (mpm->scene.dry_run && *status == MPM_EXIT_OK)
    PetscCall(MPMPrint(&mpm->core.print, "dry run    the study is valid; no step was made\n"));
  if (mpm->scene.dry_run || *status != MPM_EXIT_OK) PetscFunctionReturn(PETSC_SUCCESS);
  for (; s.n < study->levels && *status == MPM_EXIT_OK; s.n++) PetscCall(MakeRun(mpm, s.n, &s, &samples[s.n], status));
  if (*status != MPM_EXIT_OK) s.n--;
  if (s.n > 0 && (*status == MPM_EXIT_OK || s.by_errors)) {
    PetscCall(Compare(mpm, samples, &s));
    PetscCall(Report(mpm, &s, status));
  }
  if (*status == MPM_EXIT_OK) PetscCall(CheckOrder(mpm, &s, status));
  for (PetscInt k = 0; k < MPM_MAX_LEVELS; k++) PetscCall(MPMSamplesDestroy(&samples[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
