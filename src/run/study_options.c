/* study_options.c - reads the options of a study, with those of its scene. */
#include "run/mpm.h"

/* Writes the name of a column of the history. */
static void ColumnName(PetscInt row, PetscInt component, char name[MPM_NAME_LEN])
{
  (void)snprintf(name, MPM_NAME_LEN, MPMDiagnostics[row].nc > 1 ? "%s_%c" : "%s", MPMDiagnostics[row].name,
                 "xyz"[component]);
}

/* Reads -study_quantity <column>[:max|min|end] and -study_value. */
static PetscErrorCode ReadQuantity(MPM mpm, MPMOptions o)
{
  static const char *const ends[MPM_NUM_SEEN - 1] = {"end", "max", "min"};
  MPMQuantity             *q                      = &mpm->study.quantity;
  char                     text[MPM_TEXT_LEN], name[MPM_NAME_LEN], list[MPM_TEXT_LEN] = "", *colon;
  PetscBool                found = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "study_quantity", NULL, text, &q->on));
  if (!q->on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsReal(o, "study_value", NULL, &q->value, &q->known));
  (void)snprintf(q->name, sizeof q->name, "%.*s", MPM_NAME_LEN - 1, text);
  colon = strchr(text, ':');
  if (colon) {
    *colon++ = 0;
    for (q->seen = 0; q->seen < MPM_NUM_SEEN - 1 && strcmp(ends[q->seen], colon);) q->seen++;
    if (q->seen == MPM_NUM_SEEN - 1) MPMOptionsFail(o, "-study_quantity %s: choose :max, :min or :end", q->name);
  }
  for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS; k++)
    for (PetscInt c = 0; c < MPMDiagnosticColumns(k, mpm->core.grid.dim); c++) {
      ColumnName(k, c, name);
      (void)snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", list[0] ? "|" : "", name);
      if (strcmp(name, text)) continue;
      q->row       = k;
      q->component = c;
      found        = PETSC_TRUE;
    }
  if (!found)
    MPMOptionsFail(o, "-study_quantity %s is no column of the history: choose one of %.*s", q->name, MPM_TEXT_LEN / 2,
                   list);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses what a convergence study cannot do. */
static void CheckConvergence(MPM mpm, MPMOptions o)
{
  const MPMStudy *study     = &mpm->study;
  const PetscBool by_errors = study->quantity.on ? study->quantity.known : mpm->scene.known ? PETSC_TRUE : PETSC_FALSE;

  if (study->order_wanted && !by_errors && study->levels < 3)
    MPMOptionsFail(o,
                   "-study_levels %" PetscInt_FMT " leaves no order for -study_order_min where the solution is not "
                   "known: a pair of differences needs 3 runs",
                   study->levels);
  if (mpm->scene.finest && !strcmp(study->vary, "ppc"))
    MPMOptionsFail(o, "-study_vary ppc does not apply: -reference_type finest compares grids and time steps");
}

/* Reads a list of words; each has to be in `legal`, whose words are separated by blanks. own: the word of the scene,
   which is the list if none is given. */
static PetscErrorCode ReadWords(MPMOptions o, const char name[], const char legal[], const char own[], MPMWords *words)
{
  char     *save = NULL;
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, name, NULL, words->text, &set));
  if (!set) (void)snprintf(words->text, sizeof words->text, "%s", own);
  words->n = 0;
  for (char *w = strtok_r(words->text, ", ", &save); w; w = strtok_r(NULL, ", ", &save)) {
    if (!MPMListHas(legal, w)) MPMOptionsFail(o, "-%s %s: choose a list of %s", name, w, legal);
    if (words->n == MPM_MAX_WORDS) MPMOptionsFail(o, "-%s: at most %d words", name, MPM_MAX_WORDS);
    if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
    words->word[words->n++] = w;
  }
  if (!words->n) MPMOptionsFail(o, "-%s is empty: choose a list of %s", name, legal);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends a word to a list of words. */
static void Append(char list[MPM_TEXT_LEN], const char word[])
{
  const size_t n = strlen(list);

  (void)snprintf(list + n, MPM_TEXT_LEN - n, "%s%s", n ? " " : "", word);
}

/* Reads the methods and the steps of a study of stability. */
static PetscErrorCode ReadStability(MPM mpm, MPMOptions o)
{
  MPMStudy  *study               = &mpm->study;
  char       bases[MPM_TEXT_LEN] = "", updates[MPM_TEXT_LEN] = "", transfers[MPM_TEXT_LEN] = "";
  const char own_basis[] = "gimp_stretch";

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < MPM_NUM_BASES; k++) Append(bases, MPMBasisNames[k]);
  Append(bases, own_basis);
  for (const MPMScheme *s = MPMSchemes; s->name; s++) Append(updates, s->name);
  for (const MPMTransfer *t = MPMTransfers; t->name; t++) Append(transfers, t->name);
  PetscCall(ReadWords(o, "study_basis", bases, mpm->core.needs.stretched ? own_basis : MPMBasisNames[mpm->core.basis],
                      &study->bases));
  PetscCall(ReadWords(o, "study_update", updates, mpm->method.scheme->name, &study->updates));
  PetscCall(ReadWords(o, "study_transfer", transfers, mpm->method.transfer->name, &study->transfers));
  PetscCall(MPMOptionsInt(o, "study_steps", NULL, &study->steps, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -study_*; the first fault is left in o. */
PetscErrorCode MPMStudySetFromOptions(MPM mpm, MPMOptions o)
{
  MPMStudy *study = &mpm->study;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "study_type", NULL, study->type, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!strcmp(study->type, "none")) {
    study->type[0] = 0;
    if (mpm->scene.finest)
      MPMOptionsFail(o, "-reference_type finest does not apply: it is the last run of a -study_type");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!strcmp(study->type, "stability")) {
    PetscCall(ReadStability(mpm, o));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMOptionsInt(o, "study_levels", NULL, &study->levels, NULL));
  PetscCall(MPMOptionsEnum(o, "study_vary", NULL, study->vary, NULL));
  PetscCall(MPMOptionsReal(o, "study_order_min", NULL, &study->order_min, &study->order_wanted));
  PetscCall(ReadQuantity(mpm, o));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (mpm->scene.finest && study->quantity.on)
    MPMOptionsFail(o, "-reference_type finest does not apply: the study compares -study_quantity %s",
                   study->quantity.name);
  if (!mpm->scene.known && !mpm->scene.finest && !study->quantity.on)
    MPMOptionsFail(o,
                   "-study_type %s needs a solution to compare with: -mms_type, or -reference_type (finest: the last "
                   "run), or -study_quantity",
                   study->type);
  if (mpm->time.max_steps != PETSC_MAX_INT)
    MPMOptionsFail(o, "-time_max_steps does not apply: the runs of a study end at the same time, -time_end");
  CheckConvergence(mpm, o);
  PetscFunctionReturn(PETSC_SUCCESS);
}
