/* options.c - the strict reader of the option database, at the start of a run.

   PETSc ignores misspelt names, accepts nan, and reads 2147483648 as -2147483648 (docs/petsc.md), which can cost a
   user a day of wrong results. Here the vocabulary is a table (run/options.def). A name that is not in it (names.c),
   a value of the wrong type, length or range, and an option that has no effect are each answered with one line
   before any time is spent. The first error is kept and later reads do nothing, so callers check once, at the end
   (MPMOptionsError). */
#include <strings.h>
#include "options/reader.h"

/* Takes out options whose value is "none" and whose default is that: so the command line can switch off what a file
   gives. */
static PetscErrorCode TakeOutNone(const MPMVocabulary *table)
{
  PetscFunctionBeginUser;
  for (const MPMOptionRow *row = table->row; row < table->row + table->n; row++) {
    char      dashed[MPM_FULL_LEN + 1], text[MPM_NAME_LEN];
    PetscBool given;

    if (!row->name || strchr(row->name, '<') || strcmp(row->fallback, "none")) continue;
    (void)snprintf(dashed, sizeof dashed, "-%s", row->name);
    PetscCall(PetscOptionsGetString(NULL, NULL, dashed, text, sizeof text, &given));
    if (given && !strcmp(text, "none")) PetscCall(PetscOptionsClearValue(NULL, dashed));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a reader for the options of a vocabulary, which must stay valid. Not collective. */
PetscErrorCode MPMOptionsCreate(const MPMVocabulary *table, MPMOptions *o)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(o));
  (*o)->table = table;
  PetscCall(TakeOutNone(table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees a reader, or does nothing if it is NULL. Not collective. */
PetscErrorCode MPMOptionsDestroy(MPMOptions *o)
{
  PetscFunctionBeginUser;
  if (!*o) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*o)->asked));
  PetscCall(PetscFree(*o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Values ------------------------------------------------------------------------------------------------------- */

/* Notes that the program asked for an option of this name. */
static PetscErrorCode NoteAsked(MPMOptions o, const char full[])
{
  PetscFunctionBeginUser;
  if (o->nasked == o->masked) {
    char(*more)[MPM_FULL_LEN];

    PetscCall(PetscMalloc1(2 * o->masked + 64, &more));
    PetscCall(PetscArraycpy(more, o->asked, o->nasked));
    PetscCall(PetscFree(o->asked));
    o->asked  = more;
    o->masked = 2 * o->masked + 64;
  }
  (void)snprintf(o->asked[o->nasked++], sizeof o->asked[0], "%s", full);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An option: its row, its full name, its text; was it given without a fault? */
typedef struct {
  const MPMOptionRow *row;
  char                full[MPM_FULL_LEN], text[MPM_TEXT_LEN];
  PetscBool           found;
} Given;

/* Finds an option; a required one that was not given is an error. *set, if it is not NULL: was it found? */
static PetscErrorCode Lookup(MPMOptions o, const char rowname[], const char name[], PetscBool *set, Given *g)
{
  char dashed[MPM_FULL_LEN + 1];

  PetscFunctionBeginUser;
  *g = (Given){0};
  for (size_t r = 0; r < o->table->n; r++)
    if (o->table->row[r].name && !strcmp(o->table->row[r].name, rowname)) g->row = &o->table->row[r];
  PetscCheck(g->row, PETSC_COMM_SELF, PETSC_ERR_PLIB, "the vocabulary has no row %s", rowname);
  MPMOptionsFullName(rowname, name, g->full);
  PetscCall(NoteAsked(o, g->full));
  (void)snprintf(dashed, sizeof dashed, "-%s", g->full);
  PetscCall(PetscOptionsGetString(NULL, NULL, dashed, g->text, MPM_TEXT_LEN, &g->found));
  if (g->found && strlen(g->text) >= MPM_TEXT_LEN - 1) {
    const char *whole;
    char        why[MPM_TEXT_LEN];

    PetscCall(PetscOptionsFindPair(NULL, NULL, dashed, &whole, NULL));
    MPMOptionsTooLong(dashed, strlen(whole), why, sizeof why);
    MPMOptionsFail(o, "%s", why);
  }
  if (g->found && strspn(g->text, " ") == strlen(g->text) && g->row->type != MPM_BOOL)
    MPMOptionsFail(o, "-%s has no value", g->full);
  if (!g->found && !strcmp(g->row->fallback, "required"))
    MPMOptionsFail(o, "-%s is required (%s)", g->full, g->row->help);
  if (o->error[0]) g->found = PETSC_FALSE;
  if (set) *set = g->found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether option `by` was given on the command line and `name` was not, so that `name` may only come from a
   file. Then `name` may have no effect; otherwise it is refused. Not collective. */
PetscBool MPMOptionsOverridden(const char name[], const char by[])
{
  PetscBool has_name = PETSC_FALSE, has_by = PETSC_FALSE;
  int       argc;
  char    **argv;

  if (PetscGetArgs(&argc, &argv)) return PETSC_FALSE;
  for (int k = 1; k < argc; k++) {
    if (argv[k][0] != '-') continue;
    if (!strcasecmp(argv[k] + 1, name)) has_name = PETSC_TRUE;
    if (!strcasecmp(argv[k] + 1, by)) has_by = PETSC_TRUE;
  }
  return has_by && !has_name;
}

/* Described in options.h. */
PetscErrorCode MPMOptionsRefuse(MPMOptions o, const char name[], const char *neutral, const char by[], const char why[])
{
  char      full[MPM_FULL_LEN], value[MPM_TEXT_LEN] = "";
  PetscBool given;

  PetscFunctionBeginUser;
  (void)snprintf(full, sizeof full, "-%s", name);
  PetscCall(PetscOptionsGetString(NULL, NULL, full, value, sizeof value, &given));
  if (given && !(neutral && !strcmp(value, neutral))) MPMOptionsFail(o, "%s does not apply with %s: %s", full, by, why);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether basis, update and transfer are all given, and whether any of them is; any may be NULL. A method of
   which all are given is the plain one: remedies that presets have on by default are off. Not collective. */
PetscErrorCode MPMOptionsMethodGiven(PetscBool *all, PetscBool *any)
{
  const char *const method[] = {"-method_basis", "-method_update", "-method_transfer"};
  const PetscInt    most     = (PetscInt)(sizeof method / sizeof method[0]);
  PetscInt          n        = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < most; k++) {
    PetscBool given;

    PetscCall(PetscOptionsHasName(NULL, NULL, method[k], &given));
    if (given) n++;
  }
  *all = n == most;
  if (any) *any = n ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the default of the row is a number, and not a description. */
static PetscBool DefaultNumber(const MPMOptionRow *row, PetscReal *value)
{
  char *end;

  *value = strtod(row->fallback, &end);
  return end != row->fallback && !*end;
}

/* Reads one number, of the option or else the default; *known says whether there is one. */
static PetscErrorCode ReadNumber(MPMOptions o, const char rowname[], const char name[], PetscBool whole,
                                 PetscReal *number, PetscBool *known, PetscBool *set)
{
  Given g;

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, set, &g));
  *known = g.found || DefaultNumber(g.row, number);
  if (g.found) *number = MPMOptionsNumber(o, g.row, g.full, g.text, g.text, whole);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a real number in the unit of the row. This and the other readers are described in options.h. */
PetscErrorCode MPMOptionsReal(MPMOptions o, const char rowname[], const char name[], PetscReal *value, PetscBool *set)
{
  PetscReal number;
  PetscBool known;

  PetscFunctionBeginUser;
  PetscCall(ReadNumber(o, rowname, name, PETSC_FALSE, &number, &known, set));
  if (known) *value = number;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a whole number. */
PetscErrorCode MPMOptionsInt(MPMOptions o, const char rowname[], const char name[], PetscInt *value, PetscBool *set)
{
  PetscReal number;
  PetscBool known;

  PetscFunctionBeginUser;
  PetscCall(ReadNumber(o, rowname, name, PETSC_TRUE, &number, &known, set));
  if (known) *value = (PetscInt)number;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads true or false; an option without a value is true. */
PetscErrorCode MPMOptionsBool(MPMOptions o, const char rowname[], const char name[], PetscBool *value)
{
  static const char *const yes[] = {"", "1", "true", "yes", "on"}, *const no[] = {"0", "false", "no", "off"};
  PetscBool known = PETSC_FALSE;
  Given     g;

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, NULL, &g));
  *value = !strcmp(g.row->fallback, "true");
  if (!g.found) PetscFunctionReturn(PETSC_SUCCESS);
  *value = PETSC_FALSE;
  for (size_t k = 0; k < sizeof yes / sizeof yes[0]; k++)
    if (!strcasecmp(g.text, yes[k])) *value = known = PETSC_TRUE;
  for (size_t k = 0; k < sizeof no / sizeof no[0]; k++)
    if (!strcasecmp(g.text, no[k])) known = PETSC_TRUE;
  if (!known) MPMOptionsFail(o, "-%s %.100s: choose true or false", g.full, g.text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds `word`, whatever its case, among the values a|b|c; len becomes its length there. Returns NULL if it is none of
   them. */
static const char *FindValue(const char word[], const char values[], size_t *len)
{
  for (const char *v = values; *v; v += *len + (v[*len] == '|')) {
    *len = strcspn(v, "|");
    if (*len == strlen(word) && !strncasecmp(v, word, *len)) return v;
  }
  return NULL;
}

/* Reads one of the values a|b|c of the row, and spells it as the row does. */
PetscErrorCode MPMOptionsEnum(MPMOptions o, const char rowname[], const char name[], char value[MPM_NAME_LEN],
                              PetscBool *set)
{
  Given       g;
  const char *v, *choose, *other;
  size_t      len;

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, set, &g));
  choose = strchr(g.row->allowed, '|') ? "choose one of" : "choose";
  v      = FindValue(g.found ? g.text : g.row->fallback, g.row->allowed, &len);
  if (v)
    (void)snprintf(value, MPM_NAME_LEN, "%.*s", (int)len, v);
  else if (g.found) {
    other = MPMOptionsForeignValue(o->table, g.row->name, g.text);
    MPMOptionsFail(o, "-%s %.100s: %s %s%s%s", g.full, g.text, choose, g.row->allowed, other ? "; " : "",
                   other ? other : "");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a real number for each axis, value [dim]. */
PetscErrorCode MPMOptionsReals(MPMOptions o, const char rowname[], const char name[], PetscReal value[3],
                               PetscBool *set)
{
  PetscReal number;
  Given     g;

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, set, &g));
  if (g.found) MPMOptionsList(o, g.row, g.full, g.text, PETSC_FALSE, value);
  for (PetscInt d = 0; !g.found && DefaultNumber(g.row, &number) && d < o->dim; d++) value[d] = number;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a whole number for each axis, value [dim]. */
PetscErrorCode MPMOptionsInts(MPMOptions o, const char rowname[], const char name[], PetscInt value[3], PetscBool *set)
{
  PetscReal number[3] = {0};
  Given     g;

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, set, &g));
  if (g.found) MPMOptionsList(o, g.row, g.full, g.text, PETSC_TRUE, number);
  if (g.found && !o->error[0])
    for (PetscInt d = 0; d < o->dim; d++) value[d] = (PetscInt)number[d];
  for (PetscInt d = 0; !g.found && DefaultNumber(g.row, &number[0]) && d < o->dim; d++) value[d] = (PetscInt)number[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a text. */
PetscErrorCode MPMOptionsString(MPMOptions o, const char rowname[], const char name[], char value[MPM_TEXT_LEN],
                                PetscBool *set)
{
  Given g;

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, set, &g));
  if (g.found || (g.row->fallback[0] && !strpbrk(g.row->fallback, " <") && strcmp(g.row->fallback, "required")))
    (void)snprintf(value, MPM_TEXT_LEN, "%s", g.found ? g.text : g.row->fallback);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a list of n different names of letters, digits and _; the caller frees names. */
PetscErrorCode MPMOptionsNames(MPMOptions o, const char rowname[], PetscInt *n, char (**names)[MPM_NAME_LEN])
{
  static const char legal[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
  const int         longest = MPM_NAME_LEN - 25; /* leaves space for the rest of an option's name */
  Given             g;

  PetscFunctionBeginUser;
  *n     = 0;
  *names = NULL;
  PetscCall(Lookup(o, rowname, NULL, NULL, &g));
  if (!g.found) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(strlen(g.text) / 2 + 1, names));
  for (char *word = g.text, *next; word && !o->error[0]; word = next) {
    int len;

    next = strchr(word, ',');
    if (next) *next++ = 0;
    word += strspn(word, " ");
    len = (int)strlen(word);
    while (len && word[len - 1] == ' ') len--;
    word[len] = 0;
    if (!len || (int)strspn(word, legal) != len)
      MPMOptionsFail(o, "-%s: '%.100s' is not a name; use letters, digits and _, and commas between names", g.full,
                     word);
    if (len > longest)
      MPMOptionsFail(o, "-%s: the name %.100s is too long, at most %d characters", g.full, word, longest);
    for (PetscInt k = 0; k < *n; k++)
      if (!strcasecmp((*names)[k], word)) MPMOptionsFail(o, "-%s names %s twice", g.full, word);
    if (!o->error[0]) (void)snprintf((*names)[(*n)++], MPM_NAME_LEN, "%s", word);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMOptionsTooLong(const char name[], size_t length, char text[], size_t len)
{
  const size_t n = strlen(name), head = n > 8 && !strcasecmp(name + n - 8, "vertices") ? n - 8 : 0;

  (void)snprintf(text, len, "%.50s%s: its value has %zu characters, at most %d are taken%s%.*s%s", name,
                 n > 50 ? "..." : "", length, MPM_TEXT_LEN - 2, head ? "; give them in a file, " : "", (int)head, name,
                 head ? "file" : "");
}

/* Refuses those options -<group>_<name>_<word>, of the words `all`, that the chosen model or shape does not take; it
   takes the words `taken`. Not collective. */
PetscErrorCode MPMOptionsRefuseOthers(MPMOptions o, const char group[], const char name[], const char what[],
                                      const char choice[], const char all[], const char taken[])
{
  char words[MPM_TEXT_LEN], *save = NULL;

  PetscFunctionBeginUser;
  (void)snprintf(words, sizeof words, "%s", all);
  for (char *w = strtok_r(words, " ", &save); w; w = strtok_r(NULL, " ", &save)) {
    char      full[4 * MPM_NAME_LEN];
    PetscBool given;

    if (MPMListHas(taken, w)) continue;
    (void)snprintf(full, sizeof full, "-%s_%s_%s", group, name, w);
    PetscCall(PetscOptionsHasName(NULL, NULL, full, &given));
    if (given)
      MPMOptionsFail(o, "%s does not apply: %s %s takes %s%s", full, what, choice, taken[0] ? taken : "no such option",
                     strcmp(group, "material") ? "" : ", besides rho and k0");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets *k to the number of `word` in names [n]. The option has been checked by its row, so a word that is none of them
   is a fault of the program: the row and the list differ. Not collective. */
PetscErrorCode MPMOptionsFind(const char word[], PetscInt n, const char *const names[], PetscInt *k)
{
  PetscFunctionBeginUser;
  for (*k = 0; *k < n && strcmp(names[*k], word);) ++*k;
  PetscCheck(*k < n, PETSC_COMM_SELF, PETSC_ERR_PLIB, "%s is in the vocabulary, but is no row of its table", word);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the option, a name, and sets *k to the structure among n that has it. See options.h. */
PetscErrorCode MPMOptionsDeclared(MPMOptions o, const char rowname[], const char name[], PetscInt n, const char names[],
                                  size_t stride, PetscInt *k)
{
  char full[MPM_FULL_LEN], word[MPM_TEXT_LEN] = "", list[MPM_TEXT_LEN / 2] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, rowname, name, word, NULL));
  for (*k = 0; *k < n && strcasecmp(names + (size_t)*k * stride, word);) ++*k;
  if (*k < n) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt j = 0; j < n; j++) MPMAppend(list, sizeof list, "%s%s", j ? "|" : "", names + (size_t)j * stride);
  MPMOptionsFullName(rowname, name, full);
  MPMOptionsFail(o, "-%s %.100s is not declared: choose %s%s", full, word, n > 1 ? "one of " : "", list);
  PetscFunctionReturn(PETSC_SUCCESS);
}
