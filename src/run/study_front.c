/* study_front.c - what a work-precision study makes of its runs: which of them no other beats, how long a setting takes
   to reach an error, and the cheapest settings. */
#include "run/study_work.h"

/* Returns whether a row is a finished run of this study that has an error. */
static PetscBool Counts(const MPMWorkRow *r)
{
  return r->setting && !strcmp(r->study, "run") && !strcmp(r->status, "ok") && r->error >= 0 && r->least > 0
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/* Returns whether a row may be recommended: the steps of its method are not too long for particles that cross cells. */
static PetscBool Stable(const MPMWorkRow *r)
{
  return Counts(r) && !r->note[0] ? PETSC_TRUE : PETSC_FALSE;
}

void MPMFrontMark(MPMWorkTable *t)
{
  for (PetscInt i = 0; i < t->n; i++) {
    MPMWorkRow  *a = &t->row[i];
    const double e = PetscMax(a->error, t->floor);

    a->front = Stable(a) ? 1 : 0;
    for (PetscInt j = 0; j < t->n && a->front > 0; j++) {
      const MPMWorkRow *b = &t->row[j];
      const double      f = PetscMax(b->error, t->floor);

      if (Stable(b) && b->least <= a->least && f <= e && (b->least < a->least || f < e)) a->front = 0;
    }
  }
}

PetscReal MPMFrontTime(const MPMWorkTable *t, const MPMSetting *s, PetscReal error, PetscReal *spread)
{
  const MPMWorkRow *before = NULL;

  *spread = 1;
  for (PetscInt k = 0; k < t->n; k++) { /* the rows of a setting stand in the sequence of their grids */
    const MPMWorkRow *r = &t->row[k];
    PetscReal         part;

    if (r->setting != s || !Counts(r)) continue;
    if (r->error > error) {
      before = r;
      continue;
    }
    *spread = r->most / r->least;
    if (!before || r->error <= 0) return r->least;
    *spread = PetscMax(*spread, before->most / before->least);
    part    = PetscLogReal(before->error / error) / PetscLogReal(before->error / r->error);
    return before->least * PetscPowReal(r->least / before->least, part);
  }
  return -1;
}

/* Returns the setting that reaches an error in the shortest time, or NULL. */
static const MPMSetting *Fastest(const MPMWorkTable *t, PetscReal error, PetscReal *seconds, PetscReal *spread)
{
  const MPMSetting *best = NULL;

  for (PetscInt k = 0; k < t->nsettings; k++) {
    PetscReal       here;
    const PetscReal s      = MPMFrontTime(t, &t->setting[k], error, &here);
    PetscBool       stable = PETSC_TRUE;

    for (PetscInt r = 0; r < t->n; r++)
      if (t->row[r].setting == &t->setting[k] && Counts(&t->row[r]) && !Stable(&t->row[r])) stable = PETSC_FALSE;
    if (!stable || s < 0 || (best && s >= *seconds)) continue;
    best     = &t->setting[k];
    *seconds = s;
    *spread  = here;
  }
  return best;
}

/* Prints what the scene's own setting loses against the fastest one at an error. */
static PetscErrorCode PrintLoss(MPM base, const MPMWorkTable *t, PetscReal error, PetscReal seconds, PetscReal spread)
{
  const MPMPrinter *p    = &base->core.print;
  const MPMSetting *own  = NULL;
  const MPMWorkRow *best = NULL;
  PetscReal         mine, range;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < t->nsettings; k++)
    if (t->setting[k].own) own = &t->setting[k];
  mine = MPMFrontTime(t, own, error, &range);
  for (PetscInt k = 0; k < t->n; k++)
    if (t->row[k].setting == own && Counts(&t->row[k]) && (!best || t->row[k].error < best->error)) best = &t->row[k];
  if (mine >= 0 && mine <= seconds)
    PetscCall(MPMPrint(p, "           the scene's own method is no slower for this error\n"));
  else if (mine >= 0)
    PetscCall(MPMPrint(p, "           the scene's own method takes %.2f (%.2f to %.2f) times as long for this error\n",
                       (double)(mine / seconds), (double)(mine / seconds / spread), (double)(mine / seconds * range)));
  else if (best)
    PetscCall(MPMPrint(p, "           the scene's own method does not reach it: at best %.2g %%, with %s cells\n",
                       100 * best->error, best->cells));
  else
    PetscCall(MPMPrint(p, "           the scene's own method has no error: it stopped\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the cheapest run for an error, as options, and what the scene's own setting loses. */
static PetscErrorCode PrintCheapest(MPM base, const MPMWorkTable *t, PetscReal error)
{
  const MPMPrinter *p       = &base->core.print;
  const MPMWorkRow *cheap   = NULL;
  PetscReal         seconds = 0, spread = 1;
  MPMChanges        c = {0};
  MPMStudyResult    r;
  char              text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(p, "%-10s ", error >= 0.099 ? "for 10 %" : error >= 0.0099 ? "for 1 %" : "for 0.1 %"));
  for (PetscInt k = 0; k < t->n; k++)
    if (Stable(&t->row[k]) && t->row[k].error <= error && (!cheap || t->row[k].least < cheap->least))
      cheap = &t->row[k];
  if (error < t->floor) {
    PetscCall(MPMPrint(p, "nothing is said: the two references differ by %.2g %%\n", (double)(100 * t->floor)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!cheap) {
    PetscCall(MPMPrint(p, "no run reached it; more -study_levels may\n"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMSettingApply(&c, base, cheap->setting, cheap->level));
  PetscCall(MPMStudyMake(base, MPM_STUDY_DRY, &r, NULL));
  PetscCall(MPMChangesUndo(&c));
  PetscCall(MPMSettingOptions(base, cheap->setting, &r, text));
  PetscCall(MPMPrint(p, "%s\n           error %.2g %%, %.0f steps, %.3g s, %.3g MiB\n", text, 100 * cheap->error,
                     cheap->steps, cheap->least, cheap->memory));
  if (!Fastest(t, error, &seconds, &spread)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PrintLoss(base, t, error, seconds, spread));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMFrontReport(MPM base, MPMWorkTable *t)
{
  const MPMPrinter *p     = &base->core.print;
  double            last  = -1;
  PetscBool         rough = PETSC_FALSE;

  PetscFunctionBeginUser;
  MPMFrontMark(t);
  PetscCall(MPMPrint(p, "front      runs that no other beats in both time and error\n"
                        "           method                             ppc   cfl  cells            seconds   error (%%)"
                        "       MiB  ns/particle/step\n"));
  for (;;) { /* by their times */
    const MPMWorkRow *next = NULL;
    char              method[5 * MPM_NAME_LEN];

    for (PetscInt k = 0; k < t->n; k++)
      if (t->row[k].front > 0 && t->row[k].least > last && (!next || t->row[k].least < next->least)) next = &t->row[k];
    if (!next) break;
    last = next->least;
    if (last < 0.01) rough = PETSC_TRUE;
    (void)snprintf(method, sizeof method, "%s%s %s %s", next->basis,
                   strcmp(next->gimp_update, "stretch") ? "" : " stretch", next->update, next->transfer);
    if (next->order == next->order) (void)snprintf(method + strlen(method), 16, " %.0f", next->order);
    if (next->strain == next->strain) (void)snprintf(method + strlen(method), 24, " strain %g", next->strain);
    if (next->rate == next->rate) (void)snprintf(method + strlen(method), 24, " rate %g", next->rate);
    if (next->rate != next->rate && next->flip < 1) (void)snprintf(method + strlen(method), 16, " %g", next->flip);
    PetscCall(MPMPrint(p, "           %-34s %3.0f  %4.2g  %-13s %10.4g  %s%9.3g  %8.3g  %8.1f\n", method, next->ppc,
                       next->cfl, next->cells, next->least, next->error < t->floor ? "< " : "  ",
                       100 * PetscMax(next->error, t->floor), next->memory, next->ns));
  }
  if (last < 0) PetscCall(MPMPrint(p, "           none: no run has an error\n"));
  if (rough) PetscCall(MPMPrint(p, "note       some of these runs took less than 0.01 s: their times say little\n"));
  for (PetscReal error = 0.1; error > 0.0009; error /= 10) PetscCall(PrintCheapest(base, t, error));
  PetscFunctionReturn(PETSC_SUCCESS);
}
