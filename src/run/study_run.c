/* study_run.c - a run of a study: like any other, made from the option database with a few values replaced, and what it
   gave. */
#include <stdarg.h>
#include "base/signals.h"
#include "run/study.h"

/* --- Replaced options --------------------------------------------------------------------------------------------- */

/* Notes what an option is, before it is replaced for the first time. */
static PetscErrorCode Keep(MPMChanges *c, const char name[])
{
  const char *value = NULL;
  PetscBool   given;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < c->n; k++)
    if (!strcmp(c->name[k], name)) PetscFunctionReturn(PETSC_SUCCESS);
  if (c->n == c->capacity) {
    c->capacity = 2 * c->capacity + 16;
    PetscCall(PetscRealloc((size_t)c->capacity * sizeof *c->name, &c->name));
    PetscCall(PetscRealloc((size_t)c->capacity * sizeof *c->value, &c->value));
    PetscCall(PetscRealloc((size_t)c->capacity * sizeof *c->given, &c->given));
  }
  PetscCall(PetscOptionsFindPair(NULL, NULL, name, &value, &given));
  c->value[c->n] = NULL;
  c->given[c->n] = given ? 1 : 0;
  PetscCall(PetscStrallocpy(name, &c->name[c->n]));
  if (given) PetscCall(PetscStrallocpy(value, &c->value[c->n]));
  c->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMChangesSet(MPMChanges *c, const char name[], const char format[], ...)
{
  char    text[MPM_TEXT_LEN];
  va_list args;

  PetscFunctionBeginUser;
  va_start(args, format);
  (void)vsnprintf(text, sizeof text, format, args);
  va_end(args);
  PetscCall(Keep(c, name));
  PetscCall(PetscOptionsSetValue(NULL, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMChangesClear(MPMChanges *c, const char name[])
{
  PetscFunctionBeginUser;
  PetscCall(Keep(c, name));
  PetscCall(PetscOptionsClearValue(NULL, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMChangesUndo(MPMChanges *c)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < c->n; k++) {
    PetscCall(PetscOptionsClearValue(NULL, c->name[k]));
    if (c->given[k]) PetscCall(PetscOptionsSetValue(NULL, c->name[k], c->value[k]));
    PetscCall(PetscFree(c->name[k]));
    PetscCall(PetscFree(c->value[k]));
  }
  PetscCall(PetscFree(c->name));
  PetscCall(PetscFree(c->value));
  PetscCall(PetscFree(c->given));
  c->n = c->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMChangesOfStudy(MPMChanges *c, MPM base, const char name[])
{
  char option[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMChangesSet(c, "-output_name", "%s", name));
  for (size_t r = 0; r < MPMOptionTable.n; r++) {
    if (!MPMOptionTable.row[r].name || strncmp(MPMOptionTable.row[r].name, "study_", 6)) continue;
    (void)snprintf(option, sizeof option, "-%s", MPMOptionTable.row[r].name);
    PetscCall(MPMChangesClear(c, option));
  }
  if (base->scene.finest) PetscCall(MPMChangesClear(c, "-reference_type"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets an option to dim whole numbers, each times `factor`. */
static PetscErrorCode SetList(MPMChanges *c, const char name[], PetscInt dim, const PetscInt n[], PetscInt factor)
{
  char list[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  (void)snprintf(list, sizeof list, "%" PetscInt_FMT, n[0] * factor);
  for (PetscInt d = 1; d < dim; d++)
    (void)snprintf(list + strlen(list), sizeof list - strlen(list), ",%" PetscInt_FMT, n[d] * factor);
  PetscCall(MPMChangesSet(c, name, "%s", list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMChangesRefine(MPMChanges *c, MPM base, PetscInt level)
{
  PetscInt cells[3];

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) cells[d] = base->core.grid.cells[d] >> PetscMax(0, -level);
  PetscCall(MPMChangesClear(c, "-grid_h"));
  PetscCall(SetList(c, "-grid_cells", base->core.grid.dim, cells, (PetscInt)1 << PetscMax(0, level)));
  if (base->time.fixed > 0) PetscCall(MPMChangesStep(c, base, PetscPowReal(2, (PetscReal)level)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMChangesPpc(MPMChanges *c, MPM base, PetscInt factor)
{
  char name[2 * MPM_NAME_LEN];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < base->scene.nbodies; k++) {
    (void)snprintf(name, sizeof name, "-body_%s_ppc", base->scene.bodies[k].name);
    PetscCall(SetList(c, name, base->core.grid.dim, base->scene.bodies[k].ppc, factor));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMChangesStep(MPMChanges *c, MPM base, PetscReal factor)
{
  const PetscBool fixed = base->time.fixed > 0 ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(MPMChangesSet(c, fixed ? "-dt_size" : "-dt_cfl", "%.17g",
                          (double)((fixed ? base->time.fixed : base->time.cfl) / factor)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- A run -------------------------------------------------------------------------------------------------------- */

/* Notes the value of a column in the next line of the history; a measure may not be a number there. */
static void See(PetscBool first, PetscReal value, PetscReal seen[])
{
  seen[MPM_SEEN_END] = value;
  if (first || PetscIsNanReal(seen[MPM_SEEN_MIN]))
    seen[MPM_SEEN_START] = seen[MPM_SEEN_MIN] = seen[MPM_SEEN_MAX] = value;
  else if (!PetscIsNanReal(value)) {
    seen[MPM_SEEN_MIN] = PetscMin(seen[MPM_SEEN_MIN], value);
    seen[MPM_SEEN_MAX] = PetscMax(seen[MPM_SEEN_MAX], value);
  }
}

/* Notes a line of the history in the result of a run, `to`. */
static void Watch(const MPMShown *shown, const MPMMeasures *measures, void *to)
{
  MPMStudyResult *r     = (MPMStudyResult *)to;
  const PetscBool begin = r->lines ? PETSC_FALSE : PETSC_TRUE;

  for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS; k++) {
    PetscInt       first;
    const PetscInt columns = MPMDiagnosticColumns(k, shown->core, &first);

    for (PetscInt c = first; c < first + columns; c++) See(begin, MPMDiagnosticValue(shown, k, c), r->column[k][c]);
  }
  if (r->measure >= 0) See(begin, measures->value[r->measure], r->column[MPM_NUM_DIAGNOSTICS][0]);
  r->lines++;
}

/* Sets what the options alone say of a run. */
static void Describe(MPM mpm, MPMStudyResult *r)
{
  r->dim = mpm->core.grid.dim;
  for (PetscInt d = 0; d < 3; d++) r->cells[d] = d < mpm->core.grid.dim ? mpm->core.grid.cells[d] : 1;
  r->h         = mpm->core.grid.h[0];
  r->ppc       = (PetscReal)mpm->scene.bodies[0].ppc[0];
  r->fixed     = mpm->time.fixed;
  r->cfl       = mpm->time.cfl;
  r->stable    = MPMStableOf(&mpm->core, &mpm->method);
  r->particles = mpm->core.particles.total;
  r->basis     = (PetscInt)mpm->core.basis;
  r->stretched = mpm->core.needs.stretched;
  r->scheme    = (PetscInt)(mpm->method.scheme - MPMSchemes);
  r->transfer  = (PetscInt)(mpm->method.transfer - MPMTransfers);
  r->flip      = mpm->core.params.flip;
  r->strain    = mpm->core.params.strain;
  r->rate      = mpm->method.rate;
  r->viscosity = mpm->method.viscosity;
  r->order     = mpm->core.params.order;
  MPMMethodWrong(mpm, r->wrong);
}

/* Sets up a run whose options are read, runs it and takes its result. */
static PetscErrorCode Run(MPM mpm, PetscInt keeps, MPMStudyResult *r, MPMSamples *samples)
{
  PetscLogDouble t0, t1;
  PetscMPIInt    processes;

  PetscFunctionBeginUser;
  if (keeps & MPM_STUDY_SAMPLES) mpm->scene.keeps_start = PETSC_TRUE;
  if (!(keeps & MPM_STUDY_FILES)) {
    mpm->monitor.no_file = PETSC_TRUE;
    mpm->output.enabled  = PETSC_FALSE;
  }
  mpm->report.untold   = keeps & MPM_STUDY_TELL ? PETSC_FALSE : PETSC_TRUE;
  mpm->checkpoint.off  = PETSC_TRUE;
  mpm->monitor.watch   = Watch;
  mpm->monitor.watcher = r;
  PetscCall(MPMSetUp(mpm));
  if (keeps & MPM_STUDY_PREDICT) {
    r->steps = (PetscInt)PetscMin(PetscCeilReal(mpm->time.end / MPMTimeStep(&mpm->core, &mpm->time)), PETSC_MAX_INT);
    for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) r->predicted += (PetscReal)r->steps * mpm->cost.predicted[e];
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  /* What others do on the computer counts little in the processor's time. Several processes wait for each other. */
  PetscCallMPI(MPI_Comm_size(mpm->core.comm, &processes));
  mpm->core.timers.processor = processes == 1 ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(PetscTime(&t0));
  PetscCall(MPMRun(mpm));
  PetscCall(PetscTime(&t1));
  r->wall        = t1 - t0;
  r->seconds     = mpm->core.timers.steps;
  r->steps       = mpm->core.step;
  r->memory      = MPMMemory(mpm);
  r->interrupted = mpm->core.status.asked == MPM_ASKED_END ? PETSC_TRUE : PETSC_FALSE;
  (void)snprintf(r->stop, sizeof r->stop, "%s", mpm->core.stop);
  if (r->stop[0] || mpm->core.exchange.data == MPI_COMM_NULL) /* a worker of the pool has no particles */
    PetscFunctionReturn(PETSC_SUCCESS);
  if (keeps & MPM_STUDY_SAMPLES) PetscCall(MPMSamplesGather(mpm, samples));
  if (mpm->scene.known) PetscCall(MPMKnownError(&mpm->scene, &mpm->core, &r->error, &r->size));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStudyMake(MPM base, PetscInt keeps, MPMStudyResult *r, MPMSamples *samples)
{
  MPMOptions o;
  MPM        mpm;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(r, sizeof *r));
  r->measure = base->study.quantity.row == MPM_NUM_DIAGNOSTICS ? base->study.quantity.measure : -1;
  PetscCall(MPMCreate(base->core.comm, &mpm));
  mpm->core.print.quiet = PETSC_TRUE;
  mpm->output.unwritten = keeps & MPM_STUDY_FILES ? PETSC_FALSE : PETSC_TRUE;
  PetscCall(MPMOptionsCreate(&MPMOptionTable, &o));
  PetscCall(MPMSetFromOptions(mpm, o));
  if (MPMOptionsError(o))
    (void)snprintf(r->refused, sizeof r->refused, "%s", MPMOptionsError(o));
  else {
    Describe(mpm, r);
    if (!(keeps & MPM_STUDY_DRY)) PetscCall(Run(mpm, keeps, r, samples));
  }
  PetscCall(MPMOptionsDestroy(&o));
  PetscCall(MPMDestroy(&mpm));
  PetscCallMPI(MPI_Bcast(r, (PetscMPIInt)sizeof *r, MPI_BYTE, 0, base->core.comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStudyFault(MPM base, const char fault[], int *status)
{
  PetscMPIInt bad = fault[0] ? 1 : 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(&bad, 1, MPI_INT, 0, base->core.comm));
  if (!bad) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFPrintf(base->core.comm, stderr, "%s\n", fault));
  *status = MPM_EXIT_STOPPED;
  PetscFunctionReturn(PETSC_SUCCESS);
}
