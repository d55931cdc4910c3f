/* study.c - a study: several runs of one scene, each finer than the one before by a factor of two, and for each its
   error, its observed order of convergence and its time. The reference is the scene's known solution, or its finest
   run. Each is a run like any other, made from the option database with a few values replaced. */
#include <unistd.h>
#include "base/message.h"
#include "run/mpm.h"

/* The result of one run of a study. order: the order of convergence from the run before to this one. */
typedef struct {
  PetscReal  h, error, order, seconds; /* what was refined (m, s, or 1), m, 1, s */
  PetscInt   steps;
  PetscInt64 particles;
} Result;

/* A particle of a finished run, as the comparison with a finer one needs it. */
typedef struct {
  PetscInt64 key[3];  /* place on the lattice of its body */
  PetscInt   body;    /* row of the scene's bodies */
  PetscReal  u[3], m; /* displacement, m; mass, kg */
} Sample;

/* --- Refinement of the option database ---------------------------------------------------------------------------- */

static PetscErrorCode SetList(const char name[], PetscInt dim, const PetscInt value[3])
{
  char text[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  (void)snprintf(text, sizeof text, "%" PetscInt_FMT, value[0]);
  for (PetscInt d = 1; d < dim; d++)
    (void)snprintf(text + strlen(text), sizeof text - strlen(text), ",%" PetscInt_FMT, value[d]);
  PetscCall(PetscOptionsSetValue(NULL, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the options of run `level` of the study whose first run, 0, is the scene `coarse`. */
static PetscErrorCode SetRun(MPM coarse, PetscInt level)
{
  const MPMStudy *study = &coarse->study;
  const PetscInt  dim = coarse->core.grid.dim, factor = (PetscInt)1 << level;
  char            text[2 * MPM_NAME_LEN];

  PetscFunctionBeginUser;
  (void)snprintf(text, sizeof text, "%s-%" PetscInt_FMT, coarse->scene.name, level + 1);
  PetscCall(PetscOptionsSetValue(NULL, "-output_name", text));
  PetscCall(PetscOptionsClearValue(NULL, "-study_type"));
  PetscCall(PetscOptionsClearValue(NULL, "-study_levels"));
  PetscCall(PetscOptionsClearValue(NULL, "-study_vary"));
  PetscCall(PetscOptionsClearValue(NULL, "-study_order_min"));
  if (coarse->scene.finest) PetscCall(PetscOptionsClearValue(NULL, "-reference_type"));
  if (!strcmp(study->vary, "grid")) {
    PetscInt cells[3];

    for (PetscInt d = 0; d < dim; d++) cells[d] = coarse->core.grid.cells[d] * factor;
    PetscCall(PetscOptionsClearValue(NULL, "-grid_h"));
    PetscCall(SetList("-grid_cells", dim, cells));
  }
  if (!strcmp(study->vary, "ppc"))
    for (PetscInt k = 0; k < coarse->scene.nbodies; k++) {
      PetscInt ppc[3];

      for (PetscInt d = 0; d < dim; d++) ppc[d] = coarse->scene.bodies[k].ppc[d] * factor;
      (void)snprintf(text, sizeof text, "-body_%s_ppc", coarse->scene.bodies[k].name);
      PetscCall(SetList(text, dim, ppc));
    }
  else if (coarse->time.fixed > 0) {
    (void)snprintf(text, sizeof text, "%.17g", (double)(coarse->time.fixed / factor));
    PetscCall(PetscOptionsSetValue(NULL, "-dt_size", text));
  } else if (!strcmp(study->vary, "dt")) {
    (void)snprintf(text, sizeof text, "%.17g", (double)(coarse->time.cfl / factor));
    PetscCall(PetscOptionsSetValue(NULL, "-dt_cfl", text));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The finest run as reference ---------------------------------------------------------------------------------- */

static int ByPlace(const void *a, const void *b, void *ctx)
{
  const Sample *p = (const Sample *)a, *q = (const Sample *)b;

  (void)ctx;
  if (p->body != q->body) return p->body < q->body ? -1 : 1;
  for (int d = 0; d < 3; d++)
    if (p->key[d] != q->key[d]) return p->key[d] < q->key[d] ? -1 : 1;
  return 0;
}

/* Makes a list [n] of all particles of a run, with their places on the lattice of their body, on every process of
   exchange.data; the caller frees it. Collective on the exchange. */
static PetscErrorCode Gather(MPM mpm, PetscInt *n, Sample **all)
{
  const PetscInt dim = mpm->core.grid.dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(X);
  Sample        *mine;
  MPMView        view;
  PetscMPIInt    size, bytes, *counts, *starts;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(mpm->core.exchange.data, &size));
  PetscCall(PetscMalloc1(mpm->core.particles.n, &mine));
  PetscCall(PetscMalloc2(size, &counts, size, &starts));
  PetscCall(MPMParticlesGetView(&mpm->core.particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMBody *body = mpm->scene.bodies;
    Sample        *s    = &mine[p];

    while (view.id[p] >= body->first + body->n) body++;
    PetscCall(PetscMemzero(s, sizeof *s));
    s->body = (PetscInt)(body - mpm->scene.bodies);
    s->m    = mpm->scene.kinds[body->kind].m;
    for (PetscInt d = 0; d < dim;
         d++) { /* X is in the middle of its cell of the lattice, so rounding does not matter */
      s->key[d] = (PetscInt64)PetscFloorReal((view.X[p * dim + d] - body->offset[d]) / body->b[d]);
      s->u[d]   = view.x[p * dim + d] - view.X[p * dim + d];
    }
  }
  PetscCall(MPMParticlesRestoreView(&mpm->core.particles, fields, &view));
  PetscCall(MPMMessageLength((size_t)mpm->core.particles.n * sizeof(Sample), &bytes));
  PetscCallMPI(MPI_Allgather(&bytes, 1, MPI_INT, counts, 1, MPI_INT, mpm->core.exchange.data));
  starts[0] = 0;
  for (PetscMPIInt r = 1; r < size; r++) starts[r] = starts[r - 1] + counts[r - 1];
  *n = (PetscInt)mpm->core.particles.total;
  PetscCall(PetscMalloc1(*n, all));
  PetscCallMPI(MPI_Allgatherv(mine, bytes, MPI_BYTE, *all, counts, starts, MPI_BYTE, mpm->core.exchange.data));
  PetscCall(PetscFree2(counts, starts));
  PetscCall(PetscFree(mine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the root of the mass-weighted mean of |u - u_fine|^2, m, over the particles of a run whose lattice cells are
   2^halvings as large as those of the finest run. u_fine is the mean over those particles of the finest run that lie in
   the particle's cell of the lattice. The coarse particles are sorted. */
static PetscErrorCode Difference(const MPMGrid *grid, PetscInt halvings, PetscInt n, Sample *coarse, PetscInt nfine,
                                 const Sample *finest, PetscReal *difference)
{
  const PetscInt dim = grid->dim;
  PetscReal      sum = 0, mass = 0;
  PetscInt       at = 0;
  Sample        *fine;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(nfine, &fine));
  for (PetscInt q = 0; q < nfine; q++) {
    fine[q] = finest[q];
    for (PetscInt d = 0; d < dim; d++) fine[q].key[d] >>= halvings;
  }
  PetscCall(PetscTimSort(nfine, fine, sizeof *fine, ByPlace, NULL));
  PetscCall(PetscTimSort(n, coarse, sizeof *coarse, ByPlace, NULL));
  for (PetscInt p = 0; p < n; p++) {
    PetscReal mean[3] = {0}, m = 0;

    while (at < nfine && ByPlace(&fine[at], &coarse[p], NULL) < 0) at++;
    for (PetscInt q = at; q < nfine && !ByPlace(&fine[q], &coarse[p], NULL); q++) {
      for (PetscInt d = 0; d < dim; d++) { /* less the coarse u, across a periodic face if that is shorter */
        const PetscReal length = grid->upper[d] - grid->lower[d], e = fine[q].u[d] - coarse[p].u[d];

        mean[d] += fine[q].m * (grid->periodic[d] ? e - length * PetscFloorReal(e / length + 0.5) : e);
      }
      m += fine[q].m;
    }
    if (m == 0) continue; /* at a curved edge the finer lattice may leave it empty */
    for (PetscInt d = 0; d < dim; d++) sum += coarse[p].m * PetscSqr(mean[d] / m);
    mass += coarse[p].m;
  }
  PetscCall(PetscFree(fine));
  *difference = PetscSqrtReal(sum / mass);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The runs ----------------------------------------------------------------------------------------------------- */

/* Makes run `level`. Its size and error go to result; if the finest run is the reference, its particles go to samples.
   If it stopped early, *status says so. Collective on core.comm. */
static PetscErrorCode MakeRun(MPM coarse, PetscInt level, Result *result, PetscInt *n, Sample **samples, int *status)
{
  const MPMStudy *study = &coarse->study;
  MPMOptions      o;
  MPM             mpm;
  PetscReal       size;
  PetscLogDouble  t0, t1;

  PetscFunctionBeginUser;
  PetscCall(SetRun(coarse, level));
  PetscCall(MPMCreate(coarse->core.comm, &mpm));
  mpm->core.print.quiet = PETSC_TRUE;
  PetscCall(MPMOptionsCreate(&MPMOptionTable, &o));
  PetscCall(MPMSetFromOptions(mpm, o));
  PetscCheck(!MPMOptionsError(o), mpm->core.comm, PETSC_ERR_PLIB, "run %" PetscInt_FMT " was valid: %s", level + 1,
             MPMOptionsError(o));
  if (coarse->scene.finest) mpm->scene.keeps_start = PETSC_TRUE;
  PetscCall(MPMSetUp(mpm));
  PetscCall(PetscTime(&t0));
  PetscCall(MPMRun(mpm));
  PetscCall(PetscTime(&t1));
  result->h         = !strcmp(study->vary, "grid")  ? mpm->core.grid.h[0]
                      : !strcmp(study->vary, "ppc") ? 1 / (PetscReal)mpm->scene.bodies[0].ppc[0]
                      : mpm->time.fixed > 0         ? mpm->time.fixed
                                                    : mpm->time.cfl;
  result->seconds   = t1 - t0;
  result->steps     = mpm->core.step;
  result->particles = mpm->core.particles.total;
  if (mpm->core.stop[0])
    *status = MPM_EXIT_STOPPED;
  else if (mpm->core.exchange.data != MPI_COMM_NULL) { /* a worker of the pool has no particles */
    if (coarse->scene.finest)
      PetscCall(Gather(mpm, n, samples));
    else
      PetscCall(MPMKnownError(&mpm->scene, &mpm->core, &result->error, &size));
  }
  PetscCall(MPMOptionsDestroy(&o));
  PetscCall(MPMDestroy(&mpm));
  PetscCallMPI(MPI_Bcast(status, 1, MPI_INT, 0, coarse->core.comm));
  PetscCallMPI(MPI_Bcast(result, (PetscMPIInt)sizeof *result, MPI_BYTE, 0, coarse->core.comm));
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
static PetscErrorCode CheckRuns(MPM coarse, int *status)
{
  PetscFunctionBeginUser;
  for (PetscInt level = 0; level < coarse->study.levels && *status == MPM_EXIT_OK; level++) {
    MPMOptions o;
    MPM        mpm;

    PetscCall(SetRun(coarse, level));
    PetscCall(MPMCreate(coarse->core.comm, &mpm));
    PetscCall(MPMOptionsCreate(&MPMOptionTable, &o));
    PetscCall(MPMSetFromOptions(mpm, o));
    if (MPMOptionsError(o)) {
      PetscCall(PetscFPrintf(mpm->core.comm, stderr, "run %" PetscInt_FMT " of the study: %s\n", level + 1,
                             MPMOptionsError(o)));
      *status = MPM_EXIT_INPUT;
    } else if (coarse->scene.dry_run) {
      PetscCall(MPMPrint(&coarse->core.print, "run %2" PetscInt_FMT "     ", level + 1));
      for (PetscInt d = 0; d < mpm->core.grid.dim; d++)
        PetscCall(MPMPrint(&coarse->core.print, "%s%" PetscInt_FMT, d ? "x" : "", mpm->core.grid.cells[d]));
      PetscCall(MPMPrint(&coarse->core.print, " cells, %" PetscInt64_FMT " particles\n", mpm->core.particles.total));
    }
    PetscCall(MPMOptionsDestroy(&o));
    PetscCall(MPMDestroy(&mpm));
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

/* Runs the study of a scene whose options are read; the scene itself is not set up. *status is that of the program.
   Collective on core.comm. */
PetscErrorCode MPMStudyRun(MPM mpm, int *status)
{
  const MPMStudy *study = &mpm->study;
  Result          results[MPM_MAX_LEVELS];
  PetscInt        n[MPM_MAX_LEVELS] = {0}, runs = 0, compared;
  Sample         *samples[MPM_MAX_LEVELS] = {NULL};
  PetscMPIInt     rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(mpm->core.comm, &rank));
  PetscCall(MPMPrint(&mpm->core.print, "study      %s of %s: %" PetscInt_FMT " runs, refining %s, against %s\n",
                     study->type, mpm->scene.title, study->levels, study->vary,
                     mpm->scene.finest ? "the finest run" : "the known solution"));
  *status = MPM_EXIT_OK;
  PetscCall(PetscMemzero(results, sizeof results));
  PetscCall(CheckRuns(mpm, status));
  if (mpm->scene.dry_run && *status == MPM_EXIT_OK)
    PetscCall(MPMPrint(&mpm->core.print, "dry run    the study is valid; no step was made\n"));
  if (mpm->scene.dry_run || *status != MPM_EXIT_OK) PetscFunctionReturn(PETSC_SUCCESS);
  for (; runs < study->levels && *status == MPM_EXIT_OK; runs++)
    PetscCall(MakeRun(mpm, runs, &results[runs], &n[runs], &samples[runs], status));
  if (*status != MPM_EXIT_OK) runs--;
  compared = mpm->scene.finest ? runs - 1 : runs; /* the finest run has no error of its own */
  for (PetscInt k = 0; mpm->scene.finest && *status == MPM_EXIT_OK && k < compared && !rank; k++)
    PetscCall(Difference(&mpm->core.grid, !strcmp(study->vary, "grid") ? runs - 1 - k : 0, n[k], samples[k],
                         n[runs - 1], samples[runs - 1], &results[k].error));
  for (PetscInt k = 0; k < MPM_MAX_LEVELS; k++) PetscCall(PetscFree(samples[k]));
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
