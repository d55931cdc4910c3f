/* study_workprecision.c - the work-precision study: error, time and memory of settings of methods on a series of grids.
   Errors are parts of the solution's size. Where the solution is not known, one run with the finest grid halved once
   more is the reference for all, and a second one with another basis says how far it can be trusted. */
#include <stdarg.h>
#include "run/study_work.h"

/* What errors are taken against. */
typedef struct {
  PetscBool         needed; /* by references: the solution is not known */
  PetscInt          level, n;
  const MPMSetting *candidate[MPM_MAX_WORDS + 1]; /* [n] settings that can make a reference, the first first */
  MPMSamples        samples;                      /* of the reference, on the first process */
  PetscReal         value;                        /* -study_quantity */
} Reference;

/* Returns the setting of the lists with this basis that is the first in all other lists, or NULL. */
static const MPMSetting *FirstOf(const MPMStudy *st, const MPMWorkTable *t, const char basis[])
{
  for (PetscInt k = 0; k < t->nsettings; k++) {
    const MPMSetting *s = &t->setting[k];
    const size_t      n = strlen(s->transfer);

    if (!s->basis[0] || strcmp(s->basis, basis) || strcmp(s->update, st->updates.word[0])) continue;
    if (!strncmp(s->transfer, st->transfers.word[0], n) && strchr(":", st->transfers.word[0][n])) return s;
  }
  return NULL;
}

/* Lists who may make the references: the bases of the list, the last first. */
static void ChooseReferences(MPM base, const MPMWorkTable *t, Reference *ref)
{
  const MPMStudy *st = &base->study;

  ref->needed = st->quantity.on ? !st->quantity.known : !base->scene.known;
  ref->level  = st->levels;
  for (PetscInt k = st->bases.n - 1; k >= 0; k--) {
    const MPMSetting *s = FirstOf(st, t, st->bases.word[k]);

    if (s) ref->candidate[ref->n++] = s;
  }
}

/* Writes what errors depend on besides the options of a run. */
static void Against(MPM base, const Reference *ref, char with[MPM_TEXT_LEN])
{
  const MPMQuantity *q = &base->study.quantity;

  (void)snprintf(with, MPM_TEXT_LEN, "%s %.17g %d", q->on ? q->name : "u", q->known ? (double)q->value : 0.,
                 ref->needed ? (int)ref->level : -1);
  for (PetscInt k = 0; ref->needed && k < PetscMin(2, ref->n); k++)
    (void)snprintf(with + strlen(with), MPM_TEXT_LEN - strlen(with), " %s", ref->candidate[k]->name);
}

/* Makes the rows of the study, and takes what the file has of them. *known: how many were there. *fault: the file is not
   such a table. Collective on core.comm. */
static PetscErrorCode MakeRows(MPM base, const Reference *ref, MPMWorkTable *t, PetscInt *known,
                               char fault[MPM_TEXT_LEN])
{
  const MPMStudy *st   = &base->study;
  MPMWorkTable    file = {0};
  char            with[MPM_TEXT_LEN];
  PetscMPIInt     rank;
  MPMWorkRow     *row;

  PetscFunctionBeginUser;
  *known = 0;
  Against(base, ref, with);
  for (PetscInt k = 0; k < t->nsettings; k++)
    for (PetscInt level = 0; level < st->levels; level++) {
      PetscCall(MPMWorkAdd(t, &row));
      row->setting = &t->setting[k];
      row->level   = level;
      (void)snprintf(row->study, sizeof row->study, "run");
      PetscCall(MPMSettingKey(base, row->setting, level, with, row->key));
    }
  for (PetscInt k = 0; ref->needed && k < 2; k++) {
    PetscCall(MPMWorkAdd(t, &row));
    row->level = ref->level;
    (void)snprintf(row->study, sizeof row->study, k ? "confirm" : "reference");
    PetscCall(MPMSettingKey(base, ref->candidate[k], ref->level, k ? "confirm" : "reference", row->key));
  }
  PetscCallMPI(MPI_Comm_rank(base->core.comm, &rank));
  (void)snprintf(file.path, sizeof file.path, "%s", t->path);
  if (!rank) PetscCall(MPMWorkRead(&file, fault));
  PetscCallMPI(MPI_Bcast(fault, MPM_TEXT_LEN, MPI_CHAR, 0, base->core.comm));
  PetscCallMPI(MPI_Bcast(&file.n, 1, MPIU_INT, 0, base->core.comm));
  if (rank) PetscCall(PetscMalloc1(file.n, &file.row));
  for (PetscInt k = 0; k < file.n; k++)
    PetscCallMPI(MPI_Bcast(&file.row[k], (PetscMPIInt)sizeof *file.row, MPI_BYTE, 0, base->core.comm));
  for (PetscInt k = 0; k < file.n; k++) {
    PetscBool mine = PETSC_FALSE;

    for (PetscInt j = 0; j < t->n; j++) {
      const MPMWorkRow keep = t->row[j];

      if (strcmp(keep.key, file.row[k].key)) continue;
      mine      = PETSC_TRUE;
      t->row[j] = file.row[k];
      (void)snprintf(t->row[j].study, sizeof t->row[j].study, "%s", keep.study);
      t->row[j].setting = keep.setting;
      t->row[j].level   = keep.level;
      t->row[j].done    = strcmp(t->row[j].status, "ok") || !keep.setting || t->row[j].repeats >= st->repeats;
      *known += t->row[j].done ? 1 : 0;
    }
    if (mine) continue;
    PetscCall(MPMWorkAdd(t, &row));
    *row = file.row[k];
    (void)snprintf(row->study, sizeof row->study, "other");
    row->front = 0;
    row->done  = PETSC_TRUE;
  }
  PetscCall(MPMWorkDestroy(&file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Runs --------------------------------------------------------------------------------------------------------- */

/* Returns -study_quantity of a run. */
static PetscReal Quantity(MPM base, const MPMStudyResult *r)
{
  const MPMQuantity *q = &base->study.quantity;

  return r->column[q->row][q->component][q->seen];
}

/* Sets the error of a run as a part of the solution's size. Collective on core.comm: the first process has samples. */
static PetscErrorCode TakeError(MPM base, Reference *ref, const MPMStudyResult *r, MPMSamples *samples, double *error)
{
  const MPMQuantity *q = &base->study.quantity;
  PetscReal          e = r->error, size = r->size;
  PetscMPIInt        rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(base->core.comm, &rank));
  *error = NAN;
  if (r->stop[0]) PetscFunctionReturn(PETSC_SUCCESS);
  if (q->on) {
    size = PetscAbsReal(ref->needed ? ref->value : q->value);
    e    = PetscAbsReal(Quantity(base, r) - (ref->needed ? ref->value : q->value));
  } else if (ref->needed && !rank)
    PetscCall(MPMSamplesCompare(&base->core.grid, samples, &ref->samples, &e, &size));
  if (size > 0) *error = (double)(e / size);
  PetscCallMPI(MPI_Bcast(error, 1, MPI_DOUBLE, 0, base->core.comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the time of a run to its row. */
static void AddTime(MPMWorkRow *row, const MPMStudyResult *r)
{
  const double s = (double)r->seconds, n = row->repeats > 0 ? row->repeats : 0;

  row->seconds = n > 0 ? (n * row->seconds + s) / (n + 1) : s;
  row->least   = n > 0 ? PetscMin(row->least, s) : s;
  row->most    = n > 0 ? PetscMax(row->most, s) : s;
  row->repeats = n + 1;
  row->ns      = 1e9 * row->least / ((double)r->particles * PetscMax(1, r->steps));
}

/* Prints the line of a run that was made, in its row. */
static PetscErrorCode PrintRow(MPM base, const char number[], const char name[], const MPMWorkRow *row)
{
  const MPMPrinter *p = &base->core.print;

  PetscFunctionBeginUser;
  PetscCall(
      MPMPrint(p, "%-10s %-34s %-13s %8.0f steps  %9.4g s  ", number, name, row->cells, row->steps, row->seconds));
  if (strcmp(row->status, "ok"))
    PetscCall(MPMPrint(p, "%s: %s\n", row->status, row->note));
  else if (row->error == row->error)
    PetscCall(MPMPrint(p, "error %.3g %%\n", 100 * row->error));
  else
    PetscCall(MPMPrint(p, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes one run of a setting. */
static PetscErrorCode MakeRun(MPM base, const MPMSetting *s, PetscInt level, PetscBool compare, MPMStudyResult *r,
                              MPMSamples *samples)
{
  MPMChanges c = {0};

  PetscFunctionBeginUser;
  PetscCall(MPMSettingApply(&c, base, s, level));
  PetscCall(MPMStudyMake(base, compare ? MPM_STUDY_SAMPLES : 0, r, samples));
  PetscCall(MPMChangesUndo(&c));
  if (r->refused[0]) (void)snprintf(r->stop, sizeof r->stop, "%s", r->refused);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the table on the first process; *status tells of a fault. Collective on base->core.comm. */
static PetscErrorCode Save(MPM base, const MPMWorkTable *t, int *status)
{
  char        fault[MPM_TEXT_LEN] = "";
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(base->core.comm, &rank));
  if (!rank) PetscCall(MPMWorkWrite(t, fault));
  PetscCall(MPMStudyFault(base, fault, status));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the reference and the second one that confirms it, and prints their difference; *good: there are both. A
   candidate whose run stops leaves its place to the next. Collective on core.comm. */
static PetscErrorCode MakeReferences(MPM base, MPMWorkTable *t, Reference *ref, PetscBool *good, PetscBool *interrupted)
{
  const PetscBool compare = base->study.quantity.on ? PETSC_FALSE : PETSC_TRUE;
  const char     *first   = NULL;
  PetscInt        have    = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < ref->n && have < 2; k++) {
    MPMSamples     samples = {0};
    MPMStudyResult r;
    MPMWorkRow    *row = NULL;

    for (PetscInt j = 0; j < t->n; j++)
      if (!strcmp(t->row[j].study, have ? "confirm" : "reference")) row = &t->row[j];
    PetscCall(MakeRun(base, ref->candidate[k], ref->level, compare, &r, &samples));
    *interrupted = r.interrupted;
    if (r.interrupted) PetscFunctionReturn(PETSC_SUCCESS);
    MPMWorkPut(row, &r);
    AddTime(row, &r);
    if (r.stop[0]) {
      PetscCall(PrintRow(base, "reference", ref->candidate[k]->name, row));
      row->status[0] = 0;
      row->repeats   = NAN;
      continue;
    }
    if (have) {
      PetscCall(TakeError(base, ref, &r, &samples, &row->error));
      t->floor = row->error;
      PetscCall(MPMSamplesDestroy(&samples));
    } else {
      ref->samples = samples;
      ref->value   = compare ? 0 : Quantity(base, &r);
    }
    PetscCall(PrintRow(base, have ? "second" : "reference", ref->candidate[k]->name, row));
    if (have)
      PetscCall(MPMPrint(&base->core.print, "           %s and %s differ by %.2g %%: nothing is said of errors below\n",
                         first, ref->candidate[k]->name, (double)(100 * t->floor)));
    first = ref->candidate[k]->name;
    have++;
  }
  *good = have == 2 && t->floor == t->floor ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the runs that are left, in turns: all of them once, then all of them again. Collective on core.comm. */
static PetscErrorCode MakeRuns(MPM base, MPMWorkTable *t, Reference *ref, PetscBool *interrupted, int *status)
{
  PetscInt left = 0, made = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < t->n; k++) left += t->row[k].setting && !t->row[k].done ? 1 : 0;
  for (PetscInt turn = 0; turn < base->study.repeats; turn++)
    for (PetscInt k = 0; k < t->n; k++) {
      MPMWorkRow     *row     = &t->row[k];
      const PetscBool anew    = row->status[0] ? PETSC_FALSE : PETSC_TRUE;
      MPMSamples      samples = {0};
      char            number[MPM_NAME_LEN];
      MPMStudyResult  r;

      if (!row->setting || row->done || row->repeats > turn) continue;
      PetscCall(MakeRun(base, row->setting, row->level, anew && ref->needed && !base->study.quantity.on, &r, &samples));
      *interrupted = r.interrupted;
      if (r.interrupted) PetscFunctionReturn(PETSC_SUCCESS);
      if (anew) {
        MPMWorkPut(row, &r);
        PetscCall(TakeError(base, ref, &r, &samples, &row->error));
        made++;
      }
      PetscCall(MPMSamplesDestroy(&samples));
      AddTime(row, &r);
      if (r.stop[0] || row->repeats >= base->study.repeats) row->done = PETSC_TRUE;
      (void)snprintf(number, sizeof number, "%" PetscInt_FMT "/%" PetscInt_FMT, made, left);
      if (anew) PetscCall(PrintRow(base, number, row->setting->name, row));
      PetscCall(Save(base, t, status));
      if (*status != MPM_EXIT_OK) PetscFunctionReturn(PETSC_SUCCESS);
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The study ---------------------------------------------------------------------------------------------------- */

/* Prints the runs that would be made, with the time that the model gives them: predicted on the first grid, and 2^(dim +
   1) times as long on the next. Collective on core.comm. */
static PetscErrorCode DryRun(MPM base, const MPMWorkTable *t, const Reference *ref)
{
  const PetscReal more = PetscPowReal(2, base->core.grid.dim + 1);
  PetscReal       all  = 0;
  char            words[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < t->nsettings; k++) {
    MPMChanges     c = {0};
    MPMStudyResult r;
    PetscInt       left = 0;
    PetscReal      here = 0, one;

    PetscCall(MPMSettingApply(&c, base, &t->setting[k], 0));
    PetscCall(MPMStudyMake(base, MPM_STUDY_PREDICT, &r, NULL));
    PetscCall(MPMChangesUndo(&c));
    one = r.predicted;
    for (PetscInt j = 0; j < t->n; j++) {
      const MPMWorkRow *row = &t->row[j];

      if (row->setting != &t->setting[k] || row->done) continue;
      left++;
      here += one * PetscPowReal(more, row->level) *
              (PetscReal)(base->study.repeats - (row->repeats > 0 ? (PetscInt)row->repeats : 0));
    }
    for (PetscInt j = 0; ref->needed && j < PetscMin(2, ref->n); j++)
      if (ref->candidate[j] == &t->setting[k]) all += one * PetscPowReal(more, ref->level);
    all += here;
    MPMTimeWords(here, words);
    PetscCall(MPMPrint(&base->core.print, "runs       %-34s %" PetscInt_FMT " of %" PetscInt_FMT " grids, about %s\n",
                       t->setting[k].name, left, base->study.levels, words));
  }
  MPMTimeWords(all, words);
  PetscCall(MPMPrint(&base->core.print,
                     "dry run    the study is valid; by the model about %s of steps%s; no step was made\n", words,
                     ref->needed ? ", with its references" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes what is left of the runs, and reports. */
static PetscErrorCode Work(MPM base, MPMWorkTable *t, Reference *ref, int *status)
{
  PetscBool good = PETSC_TRUE, interrupted = PETSC_FALSE, anew = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < t->n; k++) {
    if (t->row[k].setting && !t->row[k].status[0]) anew = PETSC_TRUE;
    if (!strcmp(t->row[k].study, "confirm")) t->floor = t->row[k].error;
  }
  if (ref->needed && (anew || t->floor != t->floor)) PetscCall(MakeReferences(base, t, ref, &good, &interrupted));
  if (good && !interrupted) PetscCall(MakeRuns(base, t, ref, &interrupted, status));
  if (*status != MPM_EXIT_OK) PetscFunctionReturn(PETSC_SUCCESS);
  if (interrupted || !good) {
    *status = MPM_EXIT_STOPPED;
    PetscCall(PetscFPrintf(base->core.comm, stderr, "%s\n",
                           interrupted
                               ? "interrupted by a signal; the same command goes on with the runs that are left"
                               : "no reference: fewer than two of the methods in -study_basis came to the end"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMFrontReport(base, t));
  PetscCall(Save(base, t, status));
  if (*status != MPM_EXIT_OK) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMPrint(&base->core.print, "results    %s\n           drawn by: .venv/bin/python tools/plot.py %s\n",
                     t->path, t->path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStudyWorkPrecision(MPM base, int *status)
{
  MPMWorkTable t   = {0};
  Reference    ref = {0};
  PetscInt     known;
  char         fault[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  (void)snprintf(t.path, sizeof t.path, "%s/%s_workprecision.csv", base->output.dir, base->scene.name);
  PetscCall(MPMSettingsCreate(base, &t.nsettings, &t.setting));
  if (!t.nsettings) { /* why has been told */
    PetscCall(PetscFree(t.setting));
    *status = MPM_EXIT_INPUT;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ChooseReferences(base, &t, &ref);
  if (ref.needed && ref.n < 2)
    (void)snprintf(fault, sizeof fault,
                   "-study_basis: without a known solution two bases are needed that this scene takes, one for the "
                   "reference and one to confirm it");
  if (!fault[0]) PetscCall(MakeRows(base, &ref, &t, &known, fault));
  if (fault[0]) {
    PetscCall(PetscFPrintf(base->core.comm, stderr, "%s\n", fault));
    *status = MPM_EXIT_INPUT;
  } else {
    PetscCall(MPMPrint(&base->core.print,
                       "study      workprecision of %s: %" PetscInt_FMT " settings on %" PetscInt_FMT
                       " grids, %s against %s\n",
                       base->scene.title, t.nsettings, base->study.levels,
                       base->study.quantity.on ? base->study.quantity.name : "displacements",
                       ref.needed ? "a finer run" : "what is known"));
    if (known)
      PetscCall(MPMPrint(&base->core.print,
                         "note       %" PetscInt_FMT " runs are in %s with the same options and version: they are not "
                         "made again\n",
                         known, t.path));
    if (base->scene.dry_run)
      PetscCall(DryRun(base, &t, &ref));
    else
      PetscCall(Work(base, &t, &ref, status));
  }
  PetscCall(MPMSamplesDestroy(&ref.samples));
  PetscCall(MPMWorkDestroy(&t));
  PetscFunctionReturn(PETSC_SUCCESS);
}
