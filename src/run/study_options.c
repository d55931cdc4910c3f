/* study_options.c - reads the options of a study, with those of its scene. */
#include "run/mpm.h"

/* Writes the name of a column of the history. */
static void ColumnName(PetscInt row, PetscInt component, char name[MPM_NAME_LEN])
{
  (void)snprintf(name, MPM_NAME_LEN, MPMDiagnostics[row].nc > 1 ? "%s_%c" : "%s", MPMDiagnostics[row].name,
                 "xyz"[component]);
}

/* Refuses a probe that goes with a particle of a given number, which is another one on another grid. */
static void CheckProbe(MPM mpm, MPMOptions o)
{
  const MPMMeasures *m = &mpm->monitor.measures;
  const MPMQuantity *q = &mpm->study.quantity;

  for (PetscInt p = 0; p < m->nprobes; p++)
    if (q->measure >= m->probe[p].first && (p + 1 == m->nprobes || q->measure < m->probe[p + 1].first) &&
        !m->probe[p].stays && !m->probe[p].follows && strcmp(mpm->study.vary, "dt"))
      MPMOptionsFail(o,
                     "-study_quantity %s does not apply: on each grid another particle has the number of "
                     "-probe_%s_particle; give the place, -probe_%s_follow",
                     q->name, m->probe[p].name, m->probe[p].name);
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
  for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS; k++) {
    PetscInt       first;
    const PetscInt columns = MPMDiagnosticColumns(k, &mpm->core, &first);

    for (PetscInt c = first; c < first + columns; c++) {
      ColumnName(k, c, name);
      (void)snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", list[0] ? "|" : "", name);
      if (strcmp(name, text)) continue;
      q->row       = k;
      q->component = c;
      found        = PETSC_TRUE;
    }
  }
  for (PetscInt k = 0; k < mpm->monitor.measures.n; k++)
    (void)snprintf(list + strlen(list), sizeof list - strlen(list), "|%s", mpm->monitor.measures.column[k].name);
  q->measure = MPMMeasuresFind(&mpm->monitor.measures, text);
  if (!found && q->measure >= 0) {
    q->row = MPM_NUM_DIAGNOSTICS;
    found  = PETSC_TRUE;
    CheckProbe(mpm, o);
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

/* Appends a word to a list. */
static void Append(char list[MPM_TEXT_LEN], const char word[])
{
  const size_t n = strlen(list);

  (void)snprintf(list + n, MPM_TEXT_LEN - n, "%s%s", n ? " " : "", word);
}

/* Reads a list of words, each of them one of `legal` up to a ":"; without `legal`, of numbers in (0,most]. */
static PetscErrorCode ReadWords(MPMOptions o, const char name[], const char legal[], PetscReal most, MPMWords *words)
{
  char     *save = NULL, head[MPM_NAME_LEN];
  PetscBool set;

  PetscFunctionBeginUser;
  words->text[0] = 0;
  PetscCall(MPMOptionsString(o, name, NULL, words->text, &set));
  words->n = 0;
  for (char *w = strtok_r(words->text, ", ", &save); w; w = strtok_r(NULL, ", ", &save)) {
    char           *end;
    const PetscReal number = strtod(w, &end);

    (void)snprintf(head, sizeof head, "%.*s", (int)PetscMin(strcspn(w, ":"), sizeof head - 1), w);
    if (legal && !MPMListHas(legal, head)) MPMOptionsFail(o, "-%s %.100s: choose a list of %s", name, w, legal);
    if (!legal && (end == w || *end || !(number > 0 && number <= most)))
      MPMOptionsFail(o, "-%s %.100s: choose a list of numbers > 0, at most %g", name, w, (double)most);
    if (words->n == MPM_MAX_WORDS) MPMOptionsFail(o, "-%s: at most %d words", name, MPM_MAX_WORDS);
    if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
    words->word[words->n++] = w;
  }
  if (set && !words->n) MPMOptionsFail(o, "-%s is empty", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define MPM_PRESET_NAME(name, what, expect) #name " "
#define MPM_PRESET(name, scenes, basis, stretch, update, transfer, strain, rate, cfl, ppc)
static const char presets[] =
#include "run/preset.def"
    "none";
#undef MPM_PRESET_NAME
#undef MPM_PRESET

/* Refuses a number behind a transfer that takes none, or that is none. */
static void CheckNumber(MPMOptions o, const char word[])
{
  const char        *colon = strchr(word, ':');
  const MPMTransfer *t     = MPMTransfers;
  char              *end;

  if (!colon) return;
  while (t->name && (strlen(t->name) != (size_t)(colon - word) || strncmp(t->name, word, (size_t)(colon - word)))) t++;
  if (!t->name || (t->flip >= 0 && t->rounds == MPM_NO_ROUNDS))
    MPMOptionsFail(o, "-study_transfer %.100s: this transfer takes neither -method_flip nor -method_order", word);
  (void)strtod(colon + 1, &end);
  if (end == colon + 1 || *end) MPMOptionsFail(o, "-study_transfer %.100s: no number stands after the colon", word);
}

/* Reads the lists of methods of a study. */
static PetscErrorCode ReadMethods(MPM mpm, MPMOptions o)
{
  MPMStudy *study               = &mpm->study;
  char      bases[MPM_TEXT_LEN] = "", updates[MPM_TEXT_LEN] = "", transfers[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < MPM_NUM_BASES; k++) Append(bases, MPMBasisNames[k]);
  Append(bases, "gimp_stretch");
  for (const MPMScheme *s = MPMSchemes; s->name; s++) Append(updates, s->name);
  for (const MPMTransfer *t = MPMTransfers; t->name; t++) Append(transfers, t->name);
  PetscCall(ReadWords(o, "study_preset", presets, 0, &study->presets));
  PetscCall(ReadWords(o, "study_basis", bases, 0, &study->bases));
  PetscCall(ReadWords(o, "study_update", updates, 0, &study->updates));
  PetscCall(ReadWords(o, "study_transfer", transfers, 0, &study->transfers));
  for (PetscInt k = 0; k < study->transfers.n; k++) CheckNumber(o, study->transfers.word[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the word of the scene the list of an option that is not given. */
static PetscErrorCode SetOwn(const char option[], const char own[], MPMWords *words)
{
  PetscBool given;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(NULL, NULL, option, &given));
  if (given) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(words->text, sizeof words->text, "%s", own);
  words->n       = 1;
  words->word[0] = words->text;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the methods and the steps of a study of stability. */
static PetscErrorCode ReadStability(MPM mpm, MPMOptions o)
{
  MPMStudy *study = &mpm->study;

  PetscFunctionBeginUser;
  PetscCall(ReadMethods(mpm, o));
  PetscCall(SetOwn("-study_basis", mpm->core.needs.stretched ? "gimp_stretch" : MPMBasisNames[mpm->core.basis],
                   &study->bases));
  PetscCall(SetOwn("-study_update", mpm->method.scheme->name, &study->updates));
  PetscCall(SetOwn("-study_transfer", mpm->method.transfer->name, &study->transfers));
  PetscCall(MPMOptionsInt(o, "study_steps", NULL, &study->steps, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the settings of a work-precision study. */
static PetscErrorCode ReadSettings(MPM mpm, MPMOptions o)
{
  MPMStudy *study = &mpm->study;

  PetscFunctionBeginUser;
  PetscCall(ReadMethods(mpm, o));
  PetscCall(ReadWords(o, "study_ppc", NULL, 64, &study->ppc));
  PetscCall(ReadWords(o, "study_cfl", NULL, 2, &study->cfl));
  PetscCall(MPMOptionsInt(o, "study_repeats", NULL, &study->repeats, NULL));
  PetscCall(MPMOptionsInt(o, "study_coarser", NULL, &study->coarser, NULL));
  for (PetscInt d = 0; d < mpm->core.grid.dim; d++)
    if (mpm->core.grid.cells[d] % ((PetscInt)1 << study->coarser))
      MPMOptionsFail(o,
                     "-study_coarser %" PetscInt_FMT ": the %" PetscInt_FMT
                     " cells on axis %c are no multiple of %" PetscInt_FMT,
                     study->coarser, mpm->core.grid.cells[d], "xyz"[d], (PetscInt)1 << study->coarser);
  for (PetscInt k = 0; k < study->ppc.n; k++)
    if (strspn(study->ppc.word[k], "0123456789") != strlen(study->ppc.word[k]))
      MPMOptionsFail(o, "-study_ppc %s must be whole", study->ppc.word[k]);
  if (study->cfl.n && mpm->time.fixed > 0) MPMOptionsFail(o, "-study_cfl does not apply: -dt_size is fixed");
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
  if (!strcmp(study->type, "convergence")) {
    PetscCall(MPMOptionsEnum(o, "study_vary", NULL, study->vary, NULL));
    PetscCall(MPMOptionsReal(o, "study_order_min", NULL, &study->order_min, &study->order_wanted));
  } else
    PetscCall(ReadSettings(mpm, o));
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
  if (!strcmp(study->type, "convergence")) CheckConvergence(mpm, o);
  PetscFunctionReturn(PETSC_SUCCESS);
}
