/* unit_options.c - the readers of options, one of each type, by rows made here and by every row of the program's table:
   what is not given has the default of the table; ranges, numbers that are not finite or not whole, lists of a wrong
   length and names that are none are refused in one line that names the option; the first error stays. And the values
   that options may have are the rows of the tables behind them: every law, shape, wall, basis, scheme, transfer, known
   solution and way to run, no more and no fewer. */
#include "parallel/exchange.h"
#include "run/mpm.h"
#include "unit.h"

/* A vocabulary of each type, with a default that is a value, one that is described, and none. */
static const MPMOptionRow rows[] = {
    {NULL, MPM_LATER, "", "", "", "a group"},
    {"real", MPM_REAL, "[-2,3)", "m", "0.125", "a number"},
    {"open", MPM_REAL, "(0,inf)", "m", "required", "a number above 0"},
    {"any", MPM_REAL, "(-inf,inf)", "m", "2 h", "any number"},
    {"int", MPM_INT, "[-5,1000]", "", "16", "a whole number"},
    {"int_<m>_needed", MPM_INT, "[1,12]", "", "required", "a whole number of a material"},
    {"int_described", MPM_INT, "[0,2147483647]", "", "no limit", "a whole number"},
    {"on", MPM_BOOL, "", "", "true", "yes or no"},
    {"off", MPM_BOOL, "", "", "false", "yes or no"},
    {"enum", MPM_ENUM, "one|Two|three", "", "Two", "a word"},
    {"enum_described", MPM_ENUM, "one|two", "", "one in 2-D, else two", "a word"},
    {"enum_single", MPM_ENUM, "error", "", "error", "a word"},
    {"reals", MPM_REALS, "[-1,1]", "m", "0.5", "a number an axis"},
    {"reals_<b>_needed", MPM_REALS, "(-inf,inf)", "m", "required", "a number an axis of a body"},
    {"ints", MPM_INTS, "[1,64]", "", "2", "a whole number an axis"},
    {"ints_described", MPM_INTS, "[1,1e9]", "", "by the grid", "a whole number an axis"},
    {"text", MPM_TEXT, "", "", "output", "a text"},
    {"text_described", MPM_TEXT, "", "", "the file's name", "a text"},
    {"text_path", MPM_TEXT, "", "", "<dir>/file", "a text"},
    {"names", MPM_NAMES, "", "", "required", "names"},
};
static const MPMVocabulary small = {.n = sizeof rows / sizeof rows[0], .row = rows};

static MPMOptions o; /* the reader at work */

/* A new reader of a table, for this dimension; options that were given are forgotten. */
static PetscErrorCode Begin(const MPMVocabulary *table, PetscInt dim)
{
  PetscFunctionBeginUser;
  PetscCall(MPMOptionsDestroy(&o));
  PetscCall(PetscOptionsClear(NULL));
  PetscCall(MPMOptionsCreate(table, &o));
  PetscCall(MPMOptionsDeclare(o, dim, 0, NULL, 0, NULL, 0, NULL));
  CHECK(MPMOptionsError(o) == NULL);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The full name of a row with `name` in the place of <.>. */
static void Full(const char row[], const char name[], char full[2 * MPM_NAME_LEN])
{
  const char *open = strchr(row, '<');

  if (open)
    (void)snprintf(full, 2 * MPM_NAME_LEN, "%.*s%s%s", (int)(open - row), row, name, strchr(row, '>') + 1);
  else
    (void)snprintf(full, 2 * MPM_NAME_LEN, "%s", row);
}

/* What a reader left: a number for each component, or a text. */
typedef struct {
  PetscReal x[3];
  PetscInt  i[3];
  PetscBool b, set;
  char      text[MPM_TEXT_LEN];
  PetscInt  n; /* of names */
  char (*names)[MPM_NAME_LEN];
} Value;

/* What stands there before: a reader that leaves a value alone shows it. */
static const Value untouched = {
    {-77.5, -78.5, -79.5}, {-77, -78, -79}, PETSC_FALSE, PETSC_TRUE, "left alone", -7, NULL};

/* Reads a row by the reader of its type, `text` being given for it, or NULL. */
static PetscErrorCode Read(const MPMVocabulary *table, PetscInt dim, const MPMOptionRow *row, const char text[],
                           Value *v)
{
  char full[2 * MPM_NAME_LEN], dashed[2 * MPM_NAME_LEN + 1];

  PetscFunctionBeginUser;
  PetscCall(PetscFree(v->names));
  *v = untouched;
  PetscCall(Begin(table, dim));
  Full(row->name, "q", full);
  (void)snprintf(dashed, sizeof dashed, "-%s", full);
  if (text) PetscCall(PetscOptionsSetValue(NULL, dashed, text));
  UnitContext("-%s %.100s, dim %d", full, text ? text : "not given", (int)dim);
  switch (row->type) {
  case MPM_REAL:
    PetscCall(MPMOptionsReal(o, row->name, "q", v->x, &v->set));
    break;
  case MPM_INT:
    PetscCall(MPMOptionsInt(o, row->name, "q", v->i, &v->set));
    break;
  case MPM_BOOL:
    PetscCall(MPMOptionsBool(o, row->name, "q", &v->b));
    break;
  case MPM_ENUM:
    PetscCall(MPMOptionsEnum(o, row->name, "q", v->text, &v->set));
    break;
  case MPM_REALS:
    PetscCall(MPMOptionsReals(o, row->name, "q", v->x, &v->set));
    break;
  case MPM_INTS:
    PetscCall(MPMOptionsInts(o, row->name, "q", v->i, &v->set));
    break;
  case MPM_TEXT:
    PetscCall(MPMOptionsString(o, row->name, "q", v->text, &v->set));
    break;
  case MPM_NAMES:
    PetscCall(MPMOptionsNames(o, row->name, &v->n, &v->names));
    break;
  default:
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const MPMOptionRow *Row(const MPMVocabulary *table, const char name[])
{
  for (size_t k = 0; k < table->n; k++)
    if (table->row[k].name && !strcmp(table->row[k].name, name)) return &table->row[k];
  return NULL;
}

/* The text is refused in one line that names the option and says this. */
static PetscErrorCode Refused(const char name[], PetscInt dim, const char text[], const char says[])
{
  const MPMOptionRow *row = Row(&small, name);
  const char         *error;
  char                full[2 * MPM_NAME_LEN + 1] = "-";
  Value               v                          = untouched;

  PetscFunctionBeginUser;
  PetscCall(Read(&small, dim, row, text, &v));
  Full(name, "q", full + 1);
  error = MPMOptionsError(o);
  CHECK(error != NULL);
  if (error) {
    CHECK(!strncmp(error, full, strlen(full)));
    CHECK(strstr(error, says) != NULL);
    if (!strstr(error, says)) fprintf(stderr, "  %s (wanted: %s)\n", error, says);
    CHECK(strchr(error, '\n') == NULL);
  }
  PetscCall(PetscFree(v.names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is this one word among a|b|c? */
static int Listed(const char word[], const char values[])
{
  const char *const end = values + strlen(values);

  for (const char *v = values; v < end; v += strcspn(v, "|") + 1) {
    const size_t len = strcspn(v, "|");

    if (len == strlen(word) && !strncmp(word, v, len)) return 1;
  }
  return 0;
}

/* Nothing is given: the default of the table, if it is a value, else what stood there; an error if it is required. */
static PetscErrorCode CheckDefault(const MPMVocabulary *table, const MPMOptionRow *row)
{
  const char     *fallback = row->fallback;
  char           *end;
  const PetscReal number    = strtod(fallback, &end);
  const int       is_number = end != fallback && !*end, required = !strcmp(fallback, "required");
  Value           v = untouched;

  PetscFunctionBeginUser;
  for (PetscInt dim = 1; dim <= 3; dim++) {
    char full[2 * MPM_NAME_LEN];

    PetscCall(Read(table, dim, row, NULL, &v));
    Full(row->name, "q", full);
    CHECK((MPMOptionsError(o) != NULL) == required);
    if (required && MPMOptionsError(o))
      CHECK(!strncmp(MPMOptionsError(o) + 1, full, strlen(full)) && strstr(MPMOptionsError(o), "is required"));
    if (row->type != MPM_BOOL && row->type != MPM_NAMES) CHECK(!v.set);
    for (int d = 0; d < 3; d++) {
      const int one = (row->type == MPM_REAL || row->type == MPM_INT) && d == 0,
                all = (row->type == MPM_REALS || row->type == MPM_INTS) && d < dim, read = is_number && (one || all);

      CHECK_EQ(v.x[d], read && (row->type == MPM_REAL || row->type == MPM_REALS) ? number : untouched.x[d]);
      CHECK_EQ(v.i[d], read && (row->type == MPM_INT || row->type == MPM_INTS) ? (PetscInt)number : untouched.i[d]);
    }
    if (row->type == MPM_BOOL) CHECK_EQ(v.b, !strcmp(fallback, "true") ? PETSC_TRUE : PETSC_FALSE);
    if (row->type == MPM_ENUM) CHECK(!strcmp(v.text, Listed(fallback, row->allowed) ? fallback : untouched.text));
    if (row->type == MPM_TEXT) {
      const int value = fallback[0] && !required && !strchr(fallback, ' ') && !strchr(fallback, '<');

      CHECK(!strcmp(v.text, value ? fallback : untouched.text));
    }
    if (row->type == MPM_NAMES) CHECK(v.n == 0 && v.names == NULL);
  }
  PetscCall(PetscFree(v.names));
  if (row->type == MPM_ENUM) /* a default of one word is a value */
    CHECK(required || strchr(fallback, ' ') || Listed(fallback, row->allowed));
  if (is_number && (row->type == MPM_REAL || row->type == MPM_INT)) { /* a default could be given as well */
    PetscCall(Read(table, 1, row, fallback, &v));
    CHECK(MPMOptionsError(o) == NULL && (row->type == MPM_REAL ? v.x[0] : (PetscReal)v.i[0]) == number);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers at the ends of a row's range and beside them, given as one or as a list. */
static PetscErrorCode CheckEnds(const MPMVocabulary *table, const MPMOptionRow *row)
{
  const PetscBool whole = row->type == MPM_INT || row->type == MPM_INTS ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt  n     = row->type == MPM_REALS || row->type == MPM_INTS ? 2 : 1;
  char           *end;
  const PetscReal ends[2]   = {strtod(row->allowed + 1, &end), strtod(end + 1, &end)};
  const int       closed[2] = {row->allowed[0] == '[', *end == ']'};
  Value           v         = untouched;

  PetscFunctionBeginUser;
  UnitContext("range of -%s", row->name);
  CHECK((row->allowed[0] == '[' || row->allowed[0] == '(') && (*end == ']' || *end == ')') && !end[1]);
  CHECK(ends[0] < ends[1]);
  if (whole) CHECK(closed[0] && closed[1] && ends[0] >= PETSC_MIN_INT && ends[1] <= (PetscReal)PETSC_MAX_INT);
  for (int side = 0; side < 2; side++) {
    if (!(PetscAbsReal(ends[side]) <= PETSC_MAX_REAL)) continue;
    for (int k = -1; k <= 1; k++) { /* outside of the range, on its end, inside */
      const PetscReal to = side ? ends[side] - k : ends[side] + k, x = whole    ? to
                                                                       : k == 0 ? ends[side]
                                                                                : nextafter(ends[side], to);
      const int       ok = k > 0 || (k == 0 && closed[side]);
      char            text[80];

      (void)snprintf(text, sizeof text, n == 2 ? "%.17g,%.17g" : "%.17g", x, x);
      PetscCall(Read(table, n, row, text, &v));
      CHECK_EQ(MPMOptionsError(o) == NULL ? 1 : 0, ok);
      if (!ok && MPMOptionsError(o)) CHECK(strstr(MPMOptionsError(o), "is outside the allowed range") != NULL);
      for (int d = 0; d < n && ok; d++) CHECK_EQ(whole ? (PetscReal)v.i[d] : v.x[d], x);
      CHECK(v.set || !ok);
    }
  }
  PetscCall(Read(table, n, row, n == 2 ? "nan,nan" : "nan", &v));
  CHECK(MPMOptionsError(o) && strstr(MPMOptionsError(o), "is not finite"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every value of a row is read, in any case of letters; others are not. */
static PetscErrorCode CheckWords(const MPMVocabulary *table, const MPMOptionRow *row)
{
  Value v = untouched;

  PetscFunctionBeginUser;
  for (const char *at = row->allowed; *at; at += strcspn(at, "|"), at += *at != 0) {
    const size_t len = strcspn(at, "|");
    char         word[MPM_NAME_LEN], upper[MPM_NAME_LEN];

    CHECK(len > 0 && len < MPM_NAME_LEN);
    (void)snprintf(word, sizeof word, "%.*s", (int)len, at);
    for (size_t k = 0; k <= len; k++) upper[k] = (char)(word[k] >= 'a' && word[k] <= 'z' ? word[k] - 32 : word[k]);
    for (int k = 0; k < 2; k++) {
      PetscCall(Read(table, 2, row, k ? upper : word, &v));
      CHECK(MPMOptionsError(o) == NULL && !strcmp(v.text, word) && v.set);
    }
    word[len - 1] = 0; /* a beginning is no value, unless it is another one */
    if (len > 1 && !Listed(word, row->allowed)) {
      PetscCall(Read(table, 2, row, word, &v));
      CHECK(MPMOptionsError(o) && strstr(MPMOptionsError(o), ": choose"));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckTable(const MPMVocabulary *table)
{
  PetscFunctionBeginUser;
  for (size_t k = 0; k < table->n; k++) {
    const MPMOptionRow *row = &table->row[k];

    UnitContext("row %d of the vocabulary, %s", (int)k, row->name ? row->name : row->help);
    CHECK(row->help && row->help[0]);
    if (!row->name || row->type == MPM_LATER || row->type == MPM_MOVED) continue;
    CHECK(Row(table, row->name) == row); /* names are distinct */
    PetscCall(CheckDefault(table, row));
    if (row->type == MPM_REAL || row->type == MPM_INT || row->type == MPM_REALS || row->type == MPM_INTS)
      PetscCall(CheckEnds(table, row));
    if (row->type == MPM_ENUM) PetscCall(CheckWords(table, row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is no number, or not whole, or not finite, or not as many as there are axes; with each reader's own words. */
static PetscErrorCode Refusals(void)
{
  static const char *const junk[] = {"x", "1x", "0.5.5", "--1", "1e", "0,5"};
  char                     text[64], says[64];

  PetscFunctionBeginUser;
  for (size_t k = 0; k < sizeof junk / sizeof junk[0]; k++) {
    PetscCall(Refused("real", 2, junk[k], "is not a number"));
    PetscCall(Refused("int", 2, junk[k], "is not a whole number"));
  }
  for (int k = 0; k < 4; k++) {
    static const char *const endless[] = {"inf", "-inf", "nan", "1e999"};

    PetscCall(Refused("any", 2, endless[k], "is not finite"));
    PetscCall(Refused("int_described", 2, endless[k], "is not finite"));
    (void)snprintf(text, sizeof text, "0,%s", endless[k]);
    PetscCall(Refused("reals", 2, text, "is not finite"));
    PetscCall(Refused("ints", 2, "1,inf", "is not finite"));
  }
  PetscCall(Refused("int", 2, "1.5", "must be whole"));
  PetscCall(Refused("int", 2, "20.0000001", "must be whole"));
  PetscCall(Refused("ints", 2, "2,2.5", "must be whole"));
  PetscCall(Refused("int_<m>_needed", 2, "13", "1 <= needed <= 12"));
  PetscCall(Refused("real", 2, "3", "-2 <= real < 3"));
  PetscCall(Refused("open", 2, "0", "open > 0"));
  for (PetscInt dim = 1; dim <= 3; dim++)
    for (int n = 1; n <= 5; n++) {
      static const char *const list[] = {"1", "1,1", "1,1,1", "1,1,1,1", "1,1,1,1,1"};

      if (n == dim) continue;
      (void)snprintf(says, sizeof says, "has %d number%s, -dim %d needs %d", n, n == 1 ? "" : "s", (int)dim, (int)dim);
      PetscCall(Refused("reals", dim, list[n - 1], says));
      PetscCall(Refused("ints", dim, list[n - 1], says));
    }
  PetscCall(Refused("reals", 2, "1,", "is not a number"));
  PetscCall(Refused("reals", 2, ",1", "is not a number"));
  PetscCall(Refused("reals", 2, "1,y", "'y' is not a number"));
  PetscCall(Refused("reals", 2, "0,1.5", "is outside the allowed range"));
  PetscCall(Refused("ints", 3, "1,65,1", "is outside the allowed range"));
  PetscCall(Refused("on", 2, "maybe", "choose true or false"));
  PetscCall(Refused("on", 2, "2", "choose true or false"));
  PetscCall(Refused("enum", 2, "six", "choose one of one|Two|three"));
  PetscCall(Refused("enum", 2, "one|Two", "choose one of one|Two|three"));
  PetscCall(Refused("enum_single", 2, "remove", "remove: choose error"));
  for (size_t k = 0; k < small.n; k++) { /* given without a value */
    if (!small.row[k].name || small.row[k].type == MPM_BOOL) continue;
    PetscCall(Refused(small.row[k].name, 2, "", "has no value"));
    PetscCall(Refused(small.row[k].name, 2, "   ", "has no value"));
  }
  for (int extra = -1; extra <= 1; extra++) { /* too long a text */
    char  longest[MPM_TEXT_LEN + 2];
    Value v = untouched;

    memset(longest, 'a', sizeof longest);
    longest[MPM_TEXT_LEN - 2 + extra] = 0;
    if (extra > 0) {
      PetscCall(Refused("text", 2, longest, "characters, at most"));
      continue;
    }
    PetscCall(Read(&small, 2, Row(&small, "text"), longest, &v));
    CHECK(!MPMOptionsError(o) && !strcmp(v.text, longest));
  }
  PetscCall(Refused("names", 2, "a,,b", "'' is not a name"));
  PetscCall(Refused("names", 2, "a,b c", "'b c' is not a name"));
  PetscCall(Refused("names", 2, "a,b-c", "'b-c' is not a name"));
  PetscCall(Refused("names", 2, "soft,hard,Soft", "names Soft twice"));
  for (int len = MPM_NAME_LEN - 26; len <= MPM_NAME_LEN; len++) {
    Value v = untouched;

    memset(text, 'n', sizeof text);
    text[PetscMin(len, 63)] = 0;
    if (len > MPM_NAME_LEN - 25) {
      PetscCall(Refused("names", 2, text, "is too long, at most 39 characters"));
      continue;
    }
    PetscCall(Read(&small, 2, Row(&small, "names"), text, &v));
    CHECK(!MPMOptionsError(o) && v.n == 1 && v.names && !strcmp(v.names[0], text));
    PetscCall(PetscFree(v.names));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What is taken: each type's forms of a value. */
static PetscErrorCode Values(void)
{
  static const char *const yes[] = {"", "1", "true", "TRUE", "yes", "on"}, *const no[] = {"0", "false", "no", "Off"};
  Value v = untouched;

  PetscFunctionBeginUser;
  PetscCall(Read(&small, 2, Row(&small, "real"), "1e-3", &v));
  CHECK(!MPMOptionsError(o) && v.set && v.x[0] == 1e-3 && v.x[1] == untouched.x[1]);
  PetscCall(Read(&small, 2, Row(&small, "int"), "1e3", &v)); /* whole, however it is written */
  CHECK(!MPMOptionsError(o) && v.set && v.i[0] == 1000 && v.i[1] == untouched.i[1]);
  PetscCall(Read(&small, 2, Row(&small, "int"), "-5.0", &v));
  CHECK(!MPMOptionsError(o) && v.i[0] == -5);
  PetscCall(Read(&small, 2, Row(&small, "int_described"), "2147483647", &v));
  CHECK(!MPMOptionsError(o) && v.i[0] == 2147483647);
  PetscCall(Read(&small, 3, Row(&small, "reals"), "0.5,-0.25, 1", &v));
  CHECK(!MPMOptionsError(o) && v.set && v.x[0] == 0.5 && v.x[1] == -0.25 && v.x[2] == 1);
  PetscCall(Read(&small, 2, Row(&small, "ints"), "3,64", &v));
  CHECK(!MPMOptionsError(o) && v.set && v.i[0] == 3 && v.i[1] == 64 && v.i[2] == untouched.i[2]);
  for (size_t k = 0; k < sizeof yes / sizeof yes[0]; k++)
    for (int row = 0; row < 2; row++) {
      PetscCall(Read(&small, 2, Row(&small, row ? "on" : "off"), yes[k], &v));
      CHECK(!MPMOptionsError(o) && v.b == PETSC_TRUE);
    }
  for (size_t k = 0; k < sizeof no / sizeof no[0]; k++)
    for (int row = 0; row < 2; row++) {
      PetscCall(Read(&small, 2, Row(&small, row ? "on" : "off"), no[k], &v));
      CHECK(!MPMOptionsError(o) && v.b == PETSC_FALSE);
    }
  PetscCall(Read(&small, 2, Row(&small, "text_path"), "a b,c", &v));
  CHECK(!MPMOptionsError(o) && v.set && !strcmp(v.text, "a b,c"));
  PetscCall(Read(&small, 2, Row(&small, "names"), "soft, hard_2 ,X", &v));
  CHECK(!MPMOptionsError(o) && v.n == 3 && v.names);
  if (v.n == 3) CHECK(!strcmp(v.names[0], "soft") && !strcmp(v.names[1], "hard_2") && !strcmp(v.names[2], "X"));
  PetscCall(PetscFree(v.names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first error stays, whatever comes after it; later readers take no value that is given. */
static PetscErrorCode FirstError(void)
{
  char      first[MPM_TEXT_LEN], text[MPM_TEXT_LEN] = "as before";
  PetscReal real  = -77.5;
  PetscInt  whole = -77, n;
  PetscBool set, flag;
  char(*names)[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(Begin(&small, 2));
  UnitContext("first error");
  PetscCall(PetscOptionsSetValue(NULL, "-open", "-1"));
  PetscCall(PetscOptionsSetValue(NULL, "-any", "7"));
  PetscCall(PetscOptionsSetValue(NULL, "-int", "x"));
  PetscCall(PetscOptionsSetValue(NULL, "-int_described", "7"));
  PetscCall(PetscOptionsSetValue(NULL, "-off", "true"));
  PetscCall(PetscOptionsSetValue(NULL, "-text_described", "other"));
  PetscCall(PetscOptionsSetValue(NULL, "-names", "a,b"));
  PetscCall(MPMOptionsReal(o, "open", NULL, &real, NULL));
  CHECK(MPMOptionsError(o) != NULL);
  (void)snprintf(first, sizeof first, "%s", MPMOptionsError(o) ? MPMOptionsError(o) : "");
  CHECK(strstr(first, "-open -1 is outside the allowed range open > 0") != NULL);
  real = -77.5;
  PetscCall(MPMOptionsReal(o, "any", NULL, &real, &set));
  CHECK(!set && real == -77.5);
  PetscCall(MPMOptionsInt(o, "int", NULL, &whole, &set)); /* a fault of its own, which is not heard of */
  PetscCall(MPMOptionsInt(o, "int_<m>_needed", "q", &whole, &set));
  whole = -77;
  PetscCall(MPMOptionsInt(o, "int_described", NULL, &whole, &set));
  CHECK(!set && whole == -77);
  PetscCall(MPMOptionsBool(o, "off", NULL, &flag));
  CHECK(!flag);
  PetscCall(MPMOptionsString(o, "text_described", NULL, text, &set));
  CHECK(!set && !strcmp(text, "as before"));
  PetscCall(MPMOptionsNames(o, "names", &n, &names));
  CHECK(n == 0 && names == NULL);
  MPMOptionsFail(o, "another %s", "fault");
  PetscCall(MPMOptionsShare(o, PETSC_COMM_SELF));
  PetscCall(MPMOptionsFinish(o));
  CHECK(MPMOptionsError(o) && !strcmp(MPMOptionsError(o), first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options that were given: a name that is none is refused with the nearest one, one that no reader asked for has no
   effect; a reader whose row the table lacks is an error of the program. */
static PetscErrorCode Names(void)
{
  static char    materials[2][MPM_NAME_LEN] = {"soft", "hard"}, bodies[1][MPM_NAME_LEN] = {"disk"};
  PetscInt       whole;
  PetscErrorCode code;

  PetscFunctionBeginUser;
  for (int k = 0; k < 6; k++) {
    static const char *const given[] = {"-reel", "-int_soft_needed",  "-int_stiff_needed",
                                        "-INT",  "-reals_disk_neded", "-int_q"};
    static const char *const says[]  = {
         "-reel is not an option of this scene; did you mean -real ?",
         NULL,
         "-int_stiff_needed is not an option of this scene (stiff is not among -materials)",
         NULL,
         "did you mean -reals_disk_needed ?",
         "-int_q is not an option of this scene"};

    PetscCall(Begin(&small, 2));
    UnitContext("name %s", given[k]);
    PetscCall(PetscOptionsSetValue(NULL, given[k], "7"));
    PetscCall(MPMOptionsDeclare(o, 2, 2, materials, 1, bodies, 0, NULL));
    CHECK((MPMOptionsError(o) != NULL) == (says[k] != NULL));
    if (says[k] && MPMOptionsError(o)) CHECK(strstr(MPMOptionsError(o), says[k]) != NULL);
    if (says[k]) continue;
    PetscCall(MPMOptionsFinish(o)); /* not asked for: k == 3 is read below */
    CHECK(MPMOptionsError(o) && strstr(MPMOptionsError(o), "has no effect in this scene"));
    PetscCall(Begin(&small, 2));
    PetscCall(PetscOptionsSetValue(NULL, given[k], "7"));
    PetscCall(MPMOptionsDeclare(o, 2, 2, materials, 1, bodies, 0, NULL));
    PetscCall(k == 1 ? MPMOptionsInt(o, "int_<m>_needed", "soft", &whole, NULL)
                     : MPMOptionsInt(o, "int", NULL, &whole, NULL));
    CHECK_EQ(whole, 7);
    PetscCall(MPMOptionsFinish(o));
    CHECK(MPMOptionsError(o) == NULL);
  }
  UnitContext("a row that the table lacks");
  PetscCall(Begin(&small, 2));
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  code = MPMOptionsInt(o, "no_such_row", NULL, &whole, NULL);
  PetscCall(PetscPopErrorHandler());
  CHECK_EQ(code, PETSC_ERR_PLIB);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- The values of options and the tables behind them */

static char list[MPM_TEXT_LEN]; /* names of a table as a|b|c */

static void Append(const char name[])
{
  (void)snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", list[0] ? "|" : "", name);
}

/* The row's values are the list; which is empty then. */
static PetscErrorCode CheckValues(const char name[])
{
  const MPMOptionRow *row = Row(&MPMOptionTable, name);

  PetscFunctionBeginUser;
  UnitContext("values of -%s", name);
  CHECK(row && row->type == MPM_ENUM);
  if (row) CHECK(!strcmp(row->allowed, list));
  if (row && strcmp(row->allowed, list)) fprintf(stderr, "  %s, the table has %s\n", row->allowed, list);
  list[0] = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every word that a table's row says it takes is an option. */
static void CheckParameters(const char format[], const char owner[], const char parameters[])
{
  char words[MPM_TEXT_LEN], name[2 * MPM_NAME_LEN];

  (void)snprintf(words, sizeof words, "%s", parameters);
  for (char *word = strtok(words, " "); word; word = strtok(NULL, " ")) {
    (void)snprintf(name, sizeof name, format, word);
    UnitContext("parameter %s of %s", word, owner);
    CHECK(Row(&MPMOptionTable, name) != NULL);
  }
}

static PetscErrorCode Tables(void)
{
  PetscInt n = 0;

  PetscFunctionBeginUser;
  for (const MPMMaterialType *type = MPMMaterialTypes; type->name; type++, n++) {
    Append(type->name);
    CheckParameters("material_<m>_%s", type->name, type->parameters);
  }
  PetscCall(CheckValues("material_<m>_model"));
  for (int k = 0; k < MPM_NUM_REGIONS; k++) {
    Append(MPMRegionNames[k]);
    CheckParameters("body_<b>_%s", MPMRegionNames[k], MPMRegionParameters[k]);
  }
  PetscCall(CheckValues("body_<b>_shape"));
  for (int k = 0; k < MPM_NUM_WALLS; k++) {
    Append(MPMWallNames[k]);
    CheckParameters("bc_<f>_%s", MPMWallNames[k], MPMWallParameters[k]);
  }
  PetscCall(CheckValues("bc_<f>_type"));
  for (int k = 0; k < MPM_NUM_BASES; k++) Append(MPMBasisNames[k]);
  PetscCall(CheckValues("method_basis"));
  for (const MPMScheme *scheme = MPMSchemes; scheme->name; scheme++, n++) Append(scheme->name);
  PetscCall(CheckValues("method_update"));
  for (const MPMTransfer *transfer = MPMTransfers; transfer->name; transfer++, n++) Append(transfer->name);
  PetscCall(CheckValues("method_transfer"));
  for (int manufactured = 0; manufactured < 2; manufactured++) {
    Append("none");
    for (const MPMReference *r = MPMReferences; r->name; r++, n++) {
      if (r->manufactured != (manufactured ? PETSC_TRUE : PETSC_FALSE)) continue;
      Append(r->name);
      CheckParameters(manufactured ? "mms_%s" : "reference_%s", r->name, r->parameters);
    }
    if (!manufactured) Append("expression"); /* made in the scene, by no row */
    PetscCall(CheckValues(manufactured ? "mms_type" : "reference_type"));
  }
  for (PetscInt k = 0; MPMExchangeTypes[k]; k++, n++) /* one process alone is serial without being asked */
    if (MPMExchangeTypes[k] != &MPMExchange_serial) Append(MPMExchangeTypes[k]->name);
  PetscCall(CheckValues("parallel_strategy"));
  UnitContext("tables");
  CHECK_GE(n, 5 + 3 + 4 + 2 * 8 + 3); /* none of these was empty */
  {
    const MPMOptionRow *row = Row(&MPMOptionTable, "method_order");

    CHECK(row != NULL);
    if (row) CHECK_EQ(strtod(strchr(row->allowed, ',') + 1, NULL), MPM_MAX_XPIC); /* a program has room for it */
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(CheckTable(&small));
  PetscCall(CheckTable(&MPMOptionTable));
  PetscCall(Values());
  PetscCall(Refusals());
  PetscCall(FirstError());
  PetscCall(Names());
  PetscCall(Tables());
  PetscCall(MPMOptionsDestroy(&o));
  PetscCall(PetscOptionsClear(NULL));
  PetscCall(PetscFinalize());
  return UnitEnd();
}
