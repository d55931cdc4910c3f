/* options.c - the strict reader of the option database.

   PETSc takes misspelt names in silence, accepts nan, and reads "20.5" as 20; a user loses a day that way. Here the
   vocabulary is a table (options.def): a name that is not in it, a value of the wrong type, length or range, and an
   option that cannot matter are answered with one line before any time is spent. The first error sticks and later
   reads do nothing, so callers check once, at the end (MPMOptionsError).                                             */
#include <ctype.h>
#include <stdarg.h>
#include <strings.h>
#include "mpm.h"

typedef enum { REAL, INT, BOOL, ENUM, TEXT, REALS, INTS, NAMES, LATER } OptionType;

typedef struct {
  const char *name;
  OptionType  type;
  const char *allowed, *unit, *fallback, *help; /* name NULL: a group, help is its title */
} Row;

static const Row table[] = {
#define MPM_GROUP(title)                                         {NULL, LATER, "", "", "", title},
#define MPM_OPTION(name, type, allowed, unit, fallback, help)    {name, type, allowed, unit, fallback, help},
#include "options.def"
#undef MPM_GROUP
#undef MPM_OPTION
};
#define NUM_ROWS (sizeof table / sizeof table[0])

static const char *const faces[] = {"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"};

/* Words that other programs use for ours. */
static const char *const aliases[][2] = {
  {"youngs", "E"},         {"young", "E"},       {"modulus", "E"},      {"poisson", "nu"},     {"density", "rho"},      {"type", "model"},
  {"law", "model"},        {"particles", "ppc"}, {"position", "center"}, {"centre", "center"}, {"v", "velocity"},       {"scheme", "update"},
  {"shape_function", "basis"}, {"dt", "size"},   {"steps", "max_steps"}, {"t_end", "end"},     {"cfl_number", "cfl"},   {"interval", "every"},
};

/* What PETSc itself takes; it checks its own. */
static const char *const foreign[] = {"log_", "options_", "malloc", "info", "fp_trap", "on_error_", "citations", "memory_view", "objects_", "mpi_", "skip_petscrc",
                                      "no_signal_handler", "debugger_", "start_in_debugger", "stop_for_debugger", "get_total_flops", "checkstack", "error_output", "viewer_", "version"};

struct _MPMOptions {
  char     error[MPM_TEXT_LEN];
  PetscInt dim, nm, nb, nasked, masked;
  char (*materials)[MPM_NAME_LEN], (*bodies)[MPM_NAME_LEN], (*asked)[2 * MPM_NAME_LEN];
};

/* Notes the first error, a line without its end. */
void MPMOptionsFail(MPMOptions o, const char format[], ...)
{
  va_list args;

  if (o->error[0]) return;
  va_start(args, format);
  (void)vsnprintf(o->error, sizeof o->error, format, args);
  va_end(args);
}

const char *MPMOptionsError(MPMOptions o)
{
  return o->error[0] ? o->error : NULL;
}

PetscErrorCode MPMOptionsCreate(MPMOptions *o)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMOptionsDestroy(MPMOptions *o)
{
  PetscFunctionBeginUser;
  if (!*o) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*o)->asked));
  PetscCall(PetscFree(*o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Names ---------------------------------------------------------------------------------------------------- */

/* Does `given` match a row's name with its placeholder replaced by one of n words? */
static PetscBool MatchesOneOf(const char row[], const char given[], PetscInt n, const char *words, size_t stride)
{
  const char  *open = strchr(row, '<'), *close = open + 3;
  const size_t before = (size_t)(open - row);

  if (strncasecmp(row, given, before)) return PETSC_FALSE;
  for (PetscInt k = 0; k < n; k++) {
    const char  *word = words + k * stride;
    const size_t len  = strlen(word);

    if (!strncasecmp(given + before, word, len) && !strcasecmp(given + before + len, close)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Is `given` an instance of this row in the scene as declared so far? */
static PetscBool Matches(MPMOptions o, const Row *row, const char given[])
{
  const char *open = strchr(row->name, '<');

  if (!open) return !strcasecmp(row->name, given) ? PETSC_TRUE : PETSC_FALSE;
  switch (open[1]) {
  case 'm':
    return MatchesOneOf(row->name, given, o->nm, (const char *)o->materials, MPM_NAME_LEN);
  case 'b':
    return MatchesOneOf(row->name, given, o->nb, (const char *)o->bodies, MPM_NAME_LEN);
  case 'f':
    for (PetscInt k = 0; k < 2 * o->dim; k++)
      if (MatchesOneOf(row->name, given, 1, faces[k], 1)) return PETSC_TRUE;
    return PETSC_FALSE;
  default: /* probes and loads: anything after the first word */
    return !strncasecmp(row->name, given, (size_t)(open - row->name)) ? PETSC_TRUE : PETSC_FALSE;
  }
}

static void FullName(const char row[], const char name[], char full[2 * MPM_NAME_LEN])
{
  const char *open = strchr(row, '<');

  if (!open || !name) (void)snprintf(full, 2 * MPM_NAME_LEN, "%s", row);
  else (void)snprintf(full, 2 * MPM_NAME_LEN, "%.*s%s%s", (int)(open - row), row, name, open + 3);
}

/* Edits (insert, delete, replace, swap neighbours) between two words, without regard to case. */
static int Distance(const char a[], const char b[])
{
  int       d[3][2 * MPM_NAME_LEN + 1];
  const int na = (int)strlen(a), nb = (int)strlen(b);

  if (na > 2 * MPM_NAME_LEN || nb > 2 * MPM_NAME_LEN) return 1000;
  for (int j = 0; j <= nb; j++) d[0][j] = j;
  for (int i = 1; i <= na; i++) {
    int *now = d[i % 3], *last = d[(i + 2) % 3], *before = d[(i + 1) % 3];

    now[0] = i;
    for (int j = 1; j <= nb; j++) {
      const int same = tolower(a[i - 1]) == tolower(b[j - 1]);

      now[j] = PetscMin(PetscMin(last[j] + 1, now[j - 1] + 1), last[j - 1] + !same);
      if (i > 1 && j > 1 && tolower(a[i - 1]) == tolower(b[j - 2]) && tolower(a[i - 2]) == tolower(b[j - 1])) now[j] = PetscMin(now[j], before[j - 2] + 1);
    }
  }
  return d[na % 3][nb];
}

static void Consider(const char given[], const char candidate[], int *best, char nearest[2 * MPM_NAME_LEN])
{
  const int d = Distance(given, candidate);

  if (d >= *best) return;
  *best = d;
  (void)snprintf(nearest, 2 * MPM_NAME_LEN, "%s", candidate);
}

/* The legal name nearest to `given`, or "" if none is near. */
static void Nearest(MPMOptions o, const char given[], char nearest[2 * MPM_NAME_LEN])
{
  int  best = 1 + PetscMax(2, (int)strlen(given) / 4);
  char word[2 * MPM_NAME_LEN];

  nearest[0] = 0;
  for (size_t k = 0; k < sizeof aliases / sizeof aliases[0]; k++) {
    const size_t n = strlen(given), na = strlen(aliases[k][0]);

    if (n <= na + 1 || given[n - na - 1] != '_' || strcasecmp(given + n - na, aliases[k][0])) continue;
    (void)snprintf(word, sizeof word, "%.*s%s", (int)(n - na), given, aliases[k][1]);
    for (size_t r = 0; r < NUM_ROWS; r++)
      if (table[r].name && table[r].type != LATER && Matches(o, &table[r], word)) {
        (void)snprintf(nearest, 2 * MPM_NAME_LEN, "%s", word);
        return;
      }
  }
  for (size_t r = 0; r < NUM_ROWS; r++) {
    const char *open = table[r].name ? strchr(table[r].name, '<') : NULL;

    if (!table[r].name || table[r].type == LATER) continue;
    if (!open) Consider(given, table[r].name, &best, nearest);
    else {
      const PetscInt n = open[1] == 'm' ? o->nm : open[1] == 'b' ? o->nb : 2 * o->dim;

      for (PetscInt k = 0; k < n; k++) {
        FullName(table[r].name, open[1] == 'm' ? o->materials[k] : open[1] == 'b' ? o->bodies[k] : faces[k], word);
        Consider(given, word, &best, nearest);
      }
    }
  }
}

/* Takes the names that the scene declares, then refuses every given option that is not in the vocabulary or not built.
   Before they are known (nm = nb = 0), options that contain such names pass.                                         */
PetscErrorCode MPMOptionsDeclare(MPMOptions o, PetscInt dim, PetscInt nm, char (*materials)[MPM_NAME_LEN], PetscInt nb, char (*bodies)[MPM_NAME_LEN])
{
  PetscInt n;
  char   **names, **values;

  PetscFunctionBeginUser;
  o->dim       = dim;
  o->nm        = nm;
  o->nb        = nb;
  o->materials = materials;
  o->bodies    = bodies;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt k = 0; k < n && !o->error[0]; k++) {
    const Row *row   = NULL;
    PetscBool  petsc = PETSC_FALSE;
    char       nearest[2 * MPM_NAME_LEN];

    for (size_t r = 0; r < NUM_ROWS; r++)
      if (table[r].name && Matches(o, &table[r], names[k])) row = &table[r];
    for (size_t f = 0; f < sizeof foreign / sizeof foreign[0]; f++)
      if (!strncasecmp(names[k], foreign[f], strlen(foreign[f]))) petsc = PETSC_TRUE;
    if (petsc || (!nm && (!strncasecmp(names[k], "material_", 9) || !strncasecmp(names[k], "body_", 5) || !strncasecmp(names[k], "bc_", 3)))) continue;
    if (row && row->type == LATER) MPMOptionsFail(o, "-%s is not built yet (%s)", names[k], row->help);
    if (row) continue;
    Nearest(o, names[k], nearest);
    if (nearest[0]) MPMOptionsFail(o, "-%s is not an option of this scene; did you mean -%s ?", names[k], nearest);
    else MPMOptionsFail(o, "-%s is not an option of this scene; pebble -help lists them", names[k]);
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses options that were given, are in the vocabulary, but that nothing in this scene asked for. */
PetscErrorCode MPMOptionsFinish(MPMOptions o)
{
  PetscInt n;
  char   **names, **values;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt k = 0; k < n; k++) {
    PetscBool asked = PETSC_FALSE;

    for (PetscInt a = 0; a < o->nasked; a++)
      if (!strcasecmp(o->asked[a], names[k])) asked = PETSC_TRUE;
    for (size_t f = 0; f < sizeof foreign / sizeof foreign[0]; f++)
      if (!strncasecmp(names[k], foreign[f], strlen(foreign[f]))) asked = PETSC_TRUE;
    if (!asked) MPMOptionsFail(o, "-%s has no effect in this scene; remove it", names[k]);
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Values --------------------------------------------------------------------------------------------------- */

/* Looks an option up: its row, full name and text. found: was it given? Required options that are not fail. */
static PetscErrorCode Lookup(MPMOptions o, const char rowname[], const char name[], const Row **row, char full[2 * MPM_NAME_LEN], char text[MPM_TEXT_LEN], PetscBool *found)
{
  char dashed[2 * MPM_NAME_LEN + 1];

  PetscFunctionBeginUser;
  *row   = NULL;
  *found = PETSC_FALSE;
  for (size_t r = 0; r < NUM_ROWS; r++)
    if (table[r].name && !strcmp(table[r].name, rowname)) *row = &table[r];
  PetscCheck(*row, PETSC_COMM_SELF, PETSC_ERR_PLIB, "options.def has no row %s", rowname);
  FullName(rowname, name, full);
  if (o->nasked == o->masked) {
    char(*more)[2 * MPM_NAME_LEN];

    PetscCall(PetscMalloc1(2 * o->masked + 64, &more));
    PetscCall(PetscArraycpy(more, o->asked, o->nasked));
    PetscCall(PetscFree(o->asked));
    o->asked  = more;
    o->masked = 2 * o->masked + 64;
  }
  (void)snprintf(o->asked[o->nasked++], sizeof o->asked[0], "%s", full);
  (void)snprintf(dashed, sizeof dashed, "-%s", full);
  PetscCall(PetscOptionsGetString(NULL, NULL, dashed, text, MPM_TEXT_LEN, found));
  if (*found && strlen(text) >= MPM_TEXT_LEN - 1) MPMOptionsFail(o, "-%s: its value is too long, at most %d characters", full, MPM_TEXT_LEN - 2);
  if (*found && !text[0] && (*row)->type != BOOL) MPMOptionsFail(o, "-%s has no value", full);
  if (!*found && !strcmp((*row)->fallback, "required")) MPMOptionsFail(o, "-%s is required (%s)", full, (*row)->help);
  if (o->error[0]) *found = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The last word of a row's name, for messages: nu of material_<m>_nu, the whole of time_end. */
static const char *ShortName(const Row *row)
{
  const char *close = strchr(row->name, '>');

  return close ? close + 2 : row->name;
}

/* Reads one number strictly and checks it against the interval of the row. */
static PetscReal ParseNumber(MPMOptions o, const Row *row, const char full[], const char text[], PetscBool whole)
{
  char           *end, low[64] = "", high[64] = "";
  const PetscReal value = strtod(text, &end);
  PetscReal       lo, hi;

  while (isspace((unsigned char)*end)) end++;
  if (end == text || *end) {
    MPMOptionsFail(o, "-%s %s is not a number", full, text);
    return 0;
  }
  if (!(PetscAbsReal(value) <= PETSC_MAX_REAL)) {
    MPMOptionsFail(o, "-%s is not finite", full);
    return 0;
  }
  if (whole && value != floor(value)) {
    MPMOptionsFail(o, "-%s %s must be whole", full, text);
    return 0;
  }
  lo = strtod(row->allowed + 1, &end);
  hi = strtod(end + 1, &end);
  if (lo > -PETSC_MAX_REAL) (void)snprintf(low, sizeof low, "%g %s ", (double)lo, row->allowed[0] == '(' ? "<" : "<=");
  if (hi < PETSC_MAX_REAL) (void)snprintf(high, sizeof high, " %s %.10g", *end == ')' ? "<" : "<=", (double)hi);
  if (value < lo || value > hi || (value == lo && row->allowed[0] == '(') || (value == hi && *end == ')'))
    MPMOptionsFail(o, "-%s %s is outside the allowed range %s%s%s", full, text, low, ShortName(row), high);
  return value;
}

/* A number for each axis. */
static void ParseList(MPMOptions o, const Row *row, const char full[], char text[], PetscBool whole, PetscReal value[3])
{
  PetscInt n = 1;

  for (const char *c = text; *c; c++) n += *c == ',';
  if (n != o->dim) {
    MPMOptionsFail(o, "-%s has %" PetscInt_FMT " number%s, -dim %" PetscInt_FMT " needs %" PetscInt_FMT, full, n, n == 1 ? "" : "s", o->dim, o->dim);
    return;
  }
  for (PetscInt d = 0; d < n; d++) {
    char *comma = strchr(text, ',');

    if (whole) { /* "-grid_cells 20.5,20 must be whole" names the whole list */
      char      *end;
      const double x = strtod(text, &end);
      if (end != text && (*end == ',' || !*end) && x == x && PetscAbsReal(x) < 1e300 && x != floor(x)) {
        MPMOptionsFail(o, "-%s %s must be whole", full, text - 0);
        return;
      }
    }
    if (comma) *comma = 0;
    value[d] = ParseNumber(o, row, full, text, whole);
    if (comma) text = comma + 1;
  }
}

PetscErrorCode MPMOptionsReal(MPMOptions o, const char rowname[], const char name[], PetscReal *value, PetscBool *set)
{
  const Row *row;
  PetscBool  found;
  char       full[2 * MPM_NAME_LEN], text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, &row, full, text, &found));
  if (found) *value = ParseNumber(o, row, full, text, PETSC_FALSE);
  else if (isdigit((unsigned char)row->fallback[0])) *value = strtod(row->fallback, NULL);
  if (set) *set = found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMOptionsInt(MPMOptions o, const char rowname[], const char name[], PetscInt *value, PetscBool *set)
{
  const Row *row;
  PetscBool  found;
  char       full[2 * MPM_NAME_LEN], text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, &row, full, text, &found));
  if (found) *value = (PetscInt)ParseNumber(o, row, full, text, PETSC_TRUE);
  if (set) *set = found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMOptionsBool(MPMOptions o, const char rowname[], const char name[], PetscBool *value)
{
  static const char *const yes[] = {"", "1", "true", "yes", "on"}, *const no[] = {"0", "false", "no", "off"};
  const Row *row;
  PetscBool  found, known = PETSC_FALSE;
  char       full[2 * MPM_NAME_LEN], text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, &row, full, text, &found));
  *value = PETSC_FALSE;
  if (!found) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t k = 0; k < sizeof yes / sizeof yes[0]; k++)
    if (!strcasecmp(text, yes[k])) *value = known = PETSC_TRUE;
  for (size_t k = 0; k < sizeof no / sizeof no[0]; k++)
    if (!strcasecmp(text, no[k])) known = PETSC_TRUE;
  if (!known) MPMOptionsFail(o, "-%s %s: choose true or false", full, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is `word` one of the values a|b|c of length len? */
static PetscBool InValues(const char word[], const char values[], size_t len)
{
  const size_t n = strlen(word);

  for (const char *v = values; v < values + len;) {
    const size_t m = PetscMin(strcspn(v, "| "), (size_t)(values + len - v));

    if (m == n && !strncmp(v, word, n)) return PETSC_TRUE;
    v += m + 1;
  }
  return PETSC_FALSE;
}

PetscErrorCode MPMOptionsEnum(MPMOptions o, const char rowname[], const char name[], char value[MPM_NAME_LEN], PetscBool *set)
{
  const Row *row;
  PetscBool  found;
  char       full[2 * MPM_NAME_LEN], text[MPM_TEXT_LEN];
  size_t     built;

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, &row, full, text, &found));
  built = strcspn(row->allowed, " ");
  if (set) *set = found;
  if (!found) {
    if (InValues(row->fallback, row->allowed, built)) (void)snprintf(value, MPM_NAME_LEN, "%s", row->fallback);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (InValues(text, row->allowed, built)) (void)snprintf(value, MPM_NAME_LEN, "%.*s", MPM_NAME_LEN - 1, text);
  else if (row->allowed[built] && InValues(text, row->allowed + built + 1, strlen(row->allowed + built + 1)))
    MPMOptionsFail(o, "-%s %s is not built yet: choose %s%.*s", full, text, strchr(row->allowed, '|') && strchr(row->allowed, '|') < row->allowed + built ? "one of " : "", (int)built, row->allowed);
  else MPMOptionsFail(o, "-%s %s: choose one of %.*s", full, text, (int)built, row->allowed);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMOptionsReals(MPMOptions o, const char rowname[], const char name[], PetscReal value[3], PetscBool *set)
{
  const Row *row;
  PetscBool  found;
  char       full[2 * MPM_NAME_LEN], text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, &row, full, text, &found));
  if (found) ParseList(o, row, full, text, PETSC_FALSE, value);
  if (set) *set = found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMOptionsInts(MPMOptions o, const char rowname[], const char name[], PetscInt value[3], PetscBool *set)
{
  const Row *row;
  PetscBool  found;
  PetscReal  number[3] = {0};
  char       full[2 * MPM_NAME_LEN], text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, &row, full, text, &found));
  if (found) ParseList(o, row, full, text, PETSC_TRUE, number);
  if (found && !o->error[0])
    for (PetscInt d = 0; d < o->dim; d++) value[d] = (PetscInt)number[d];
  if (set) *set = found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMOptionsString(MPMOptions o, const char rowname[], const char name[], char value[MPM_TEXT_LEN], PetscBool *set)
{
  const Row *row;
  PetscBool  found;
  char       full[2 * MPM_NAME_LEN], text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(Lookup(o, rowname, name, &row, full, text, &found));
  if (found) (void)snprintf(value, MPM_TEXT_LEN, "%s", text);
  if (set) *set = found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A list of distinct names of letters, digits and _, none a prefix of an option of another (a and a_b are ambiguous). */
PetscErrorCode MPMOptionsNames(MPMOptions o, const char rowname[], PetscInt *n, char (**names)[MPM_NAME_LEN])
{
  const Row *row;
  PetscBool  found;
  char       full[2 * MPM_NAME_LEN], text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  *n     = 0;
  *names = NULL;
  PetscCall(Lookup(o, rowname, NULL, &row, full, text, &found));
  if (!found) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(strlen(text) / 2 + 1, names));
  for (char *word = text, *next; word; word = next) {
    next = strchr(word, ',');
    if (next) *next++ = 0;
    if (!word[0] || strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") != strlen(word) || strlen(word) >= MPM_NAME_LEN - 24)
      MPMOptionsFail(o, "-%s: '%s' is not a name; use letters, digits and _, at most %d", full, word, MPM_NAME_LEN - 25);
    for (PetscInt k = 0; k < *n; k++)
      if (!strcasecmp((*names)[k], word)) MPMOptionsFail(o, "-%s names %s twice", full, word);
    if (o->error[0]) break;
    (void)snprintf((*names)[(*n)++], MPM_NAME_LEN, "%s", word);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Files and help ------------------------------------------------------------------------------------------- */

/* Does the file parse as options, one a line? Called before PETSc reads it, whose own answer is a stack of calls; so no
   PETSc function may be used. Fills error with one line, or with "". YAML files are left to PETSc.                    */
PetscErrorCode MPMOptionsCheckFile(const char file[], char error[], size_t len)
{
  FILE       *f   = fopen(file, "r");
  const char *dot = strrchr(file, '.');
  char        line[8192];
  int         number = 0, depth = 0;

  error[0] = 0;
  if (!f) {
    (void)snprintf(error, len, "%s: cannot be read", file);
    return PETSC_SUCCESS;
  }
  if (dot && (!strcmp(dot, ".yaml") || !strcmp(dot, ".yml"))) {
    (void)fclose(f);
    return PETSC_SUCCESS;
  }
  while (!error[0] && fgets(line, sizeof line, f)) {
    const char *word[3];
    int         n = 0;

    number++;
    for (char *c = line; *c && n < 3;) {
      while (isspace((unsigned char)*c)) c++;
      if (!*c || *c == '#' || *c == '!' || *c == '%') break;
      word[n++] = c;
      if (*c == '"' || *c == '\'') {
        char *end = strchr(c + 1, *c);
        if (!end) (void)snprintf(error, len, "%s:%d: the quote is not closed", file, number);
        c = end ? end + 1 : c + strlen(c);
      } else
        while (*c && !isspace((unsigned char)*c)) c++;
    }
    if (error[0] || !n) continue;
    if (word[0][0] != '-' || !isalpha((unsigned char)word[0][1])) (void)snprintf(error, len, "%s:%d: a line starts with -name", file, number);
    else if (n == 3 || (n == 2 && word[1][0] == '-' && isalpha((unsigned char)word[1][1])))
      (void)snprintf(error, len, "%s:%d: %s", file, number, word[n - 1][0] == '-' && isalpha((unsigned char)word[n - 1][1]) ? "two options on one line" : "more than one value on a line; put it in quotes or join it with commas");
    if (!strncmp(word[0], "-prefix_push", 12) && isspace((unsigned char)word[0][12])) {
      depth++;
      if (n < 2 && !error[0]) (void)snprintf(error, len, "%s:%d: -prefix_push needs a prefix", file, number);
    }
    if (!strncmp(word[0], "-prefix_pop", 11) && --depth < 0 && !error[0]) (void)snprintf(error, len, "%s:%d: -prefix_pop without -prefix_push", file, number);
  }
  if (!error[0] && depth > 0) (void)snprintf(error, len, "%s:%d: -prefix_push without -prefix_pop", file, number);
  (void)fclose(f);
  return PETSC_SUCCESS;
}

/* Prints the vocabulary: names, defaults, units, ranges. Collective on comm. */
PetscErrorCode MPMOptionsHelp(MPI_Comm comm)
{
  PetscFunctionBeginUser;
  for (size_t r = 0; r < NUM_ROWS; r++) {
    const Row *row = &table[r];

    if (!row->name) {
      PetscCall(PetscPrintf(comm, "\n%s\n", row->help));
      continue;
    }
    if (row->type == LATER) {
      PetscCall(PetscPrintf(comm, "  -%s: not built yet\n", row->name));
      continue;
    }
    PetscCall(PetscPrintf(comm, "  -%s <%s>%s%s: %s", row->name, row->fallback, row->unit[0] ? " " : "", row->unit, row->help));
    if (row->type == ENUM) PetscCall(PetscPrintf(comm, " (%.*s)", (int)strcspn(row->allowed, " "), row->allowed));
    else if (row->allowed[0]) PetscCall(PetscPrintf(comm, " (%s%s)", row->type == INTS || row->type == INT ? "whole, in " : "in ", row->allowed));
    if (row->type == REALS || row->type == INTS) PetscCall(PetscPrintf(comm, " [-dim values]"));
    PetscCall(PetscPrintf(comm, "\n"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The option set as given, for provenance. The caller frees it. */
PetscErrorCode MPMOptionsText(char **text)
{
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetAll(NULL, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}
