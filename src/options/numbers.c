/* numbers.c - numbers and lists of numbers in the values of options, by their rows of the vocabulary, and what is said
   of those that are none: frequent slips have a remedy of their own. */
#include <ctype.h>
#include "options/reader.h"

/* Returns the last word of a row's name, for messages: nu of material_<m>_nu, all of time_end. */
static const char *ShortName(const MPMOptionRow *row)
{
  const char *close = strchr(row->name, '>');

  return close ? close + 2 : row->name;
}

/* Refuses a value outside the interval of the row, e.g. (-1,0.5). */
static void CheckRange(MPMOptions o, const MPMOptionRow *row, const char full[], const char text[], PetscReal value)
{
  char           *end, low[64] = "", high[64] = "";
  const PetscReal lo = strtod(row->allowed + 1, &end), hi = strtod(end + 1, &end);
  const PetscBool open_lo = row->allowed[0] == '(' ? PETSC_TRUE : PETSC_FALSE,
                  open_hi = *end == ')' ? PETSC_TRUE : PETSC_FALSE;

  if ((open_lo ? value > lo : value >= lo) && (open_hi ? value < hi : value <= hi)) return;
  if (lo > -PETSC_MAX_REAL) (void)snprintf(low, sizeof low, "%g %s ", (double)lo, open_lo ? "<" : "<=");
  if (hi < PETSC_MAX_REAL) (void)snprintf(high, sizeof high, " %s %.10g", open_hi ? "<" : "<=", (double)hi);
  if (low[0] && !high[0])
    MPMOptionsFail(o, "-%s %.100s is outside the allowed range %s %s %g", full, text, ShortName(row),
                   open_lo ? ">" : ">=", (double)lo);
  else
    MPMOptionsFail(o, "-%s %.100s is outside the allowed range %s%s%s", full, text, low, ShortName(row), high);
}

/* Returns a minus or dash of Unicode in a text, or NULL. Word processors put these in the place of -. */
const char *MPMOptionsDash(const char text[])
{
  static const char *const dashes[] = {"\xe2\x88\x92", "\xe2\x80\x90", "\xe2\x80\x91", "\xe2\x80\x92", "\xe2\x80\x93",
                                       "\xe2\x80\x94", "\xe2\x80\x95", "\xef\xb9\xa3", "\xef\xbc\x8d"};

  for (size_t k = 0; k < sizeof dashes / sizeof dashes[0]; k++)
    if (strstr(text, dashes[k])) return strstr(text, dashes[k]);
  return NULL;
}

/* What to do about a formula in an option that has another one for formulas: the only one is gravity. */
static const char formulas[] = "; -acceleration takes formulas";

static PetscBool IsFormula(const MPMOptionRow *row, const char text[])
{
  return !strcmp(row->name, "gravity") && strpbrk(text, "()*/txyzXYZ");
}

/* Returns whether a word is a number in which commas separate groups of three digits, and writes it without them. */
static PetscBool IsGrouped(const char word[], char text[], size_t len)
{
  const char  *at   = word + strspn(word, "+-");
  const size_t lead = strspn(at, "0123456789");
  size_t       n    = (size_t)(at - word) + lead;

  if (n + 1 >= len || lead < 1 || lead > 3 || at[0] == '0' || at[lead] != ',') return PETSC_FALSE;
  memcpy(text, word, n);
  for (at += lead; *at; at += 4) {
    if (at[0] != ',' || strspn(at + 1, "0123456789") != 3 || n + 4 >= len) return PETSC_FALSE;
    memcpy(text + n, at + 1, 3);
    n += 3;
  }
  text[n] = 0;
  return PETSC_TRUE;
}

/* Writes to remedy [len] what to do about a word that is no number: `end` is where reading it stopped. */
static void Advise(const MPMOptionRow *row, const char word[], const char end[], PetscBool whole, char remedy[],
                   size_t len)
{
  const size_t digits = end[0] ? strspn(end + 1, "0123456789") : 0, before = (size_t)(end - word);

  char text[40];

  remedy[0] = 0;
  if (MPMOptionsDash(word))
    (void)snprintf(remedy, len, "; write a plain - in place of the Unicode minus");
  else if (IsFormula(row, word))
    (void)snprintf(remedy, len, "%s", formulas);
  else if (word[strspn(word, " \t")] == 0)
    ;
  else if (before && IsGrouped(word, text, sizeof text))
    (void)snprintf(remedy, len,
                   whole || strchr(end + 1, ',')
                       ? "; thousands are not separated, %s"
                       : "; thousands are not separated, %s, and decimals have a point, %.*s.%s",
                   text, (int)before, word, end + 1);
  else if (before && end[0] == ',' && digits && !end[1 + digits] && !whole && before + digits < 40)
    (void)snprintf(remedy, len, "; decimals have a point, %.*s.%s", (int)before, word, end + 1);
  else if (before && (end[0] == ',' || end[0] == ';'))
    (void)snprintf(remedy, len, "; %s", end[0] == ';' ? "separate values with commas" : "it takes one, not a list");
  else if (before && isblank((unsigned char)end[-1]) && isdigit((unsigned char)end[0]))
    (void)snprintf(remedy, len, "; it has a blank");
  else if (before && strchr("dD", end[0]) && isdigit((unsigned char)end[strspn(end, "dD+-")]))
    (void)snprintf(remedy, len, "; the exponent is written with e");
  else if (before && isalpha((unsigned char)end[0]) && row->unit[0])
    (void)snprintf(remedy, len, "; write it in %s, without the unit", row->unit);
  else if (before && end[0] == '%' && !row->unit[0])
    (void)snprintf(remedy, len, "; write it as a part of 1");
  else
    for (const char *c = word; *c && !remedy[0]; c++)
      if ((unsigned char)*c > 127) (void)snprintf(remedy, len, "; it has a character beside those of ASCII");
}

/* Returns one number, which is all of `word`: that is `text`, or an item of the list in it. Not collective. */
PetscReal MPMOptionsNumber(MPMOptions o, const MPMOptionRow *row, const char full[], const char text[],
                           const char word[], PetscBool whole)
{
  char           *end, remedy[MPM_TEXT_LEN];
  const PetscReal value = strtod(word, &end);

  if (end != word) end += strspn(end, " \t");
  if (end == word || *end) {
    Advise(row, word, end, whole, remedy, sizeof remedy);
    if (word == text)
      MPMOptionsFail(o, "-%s %.100s is not a%s number%s", full, text, whole ? " whole" : "", remedy);
    else
      MPMOptionsFail(o, "-%s %.100s: '%.100s' is not a%s number%s", full, text, word, whole ? " whole" : "", remedy);
  } else if (!(PetscAbsReal(value) <= PETSC_MAX_REAL) && !(value > 0 && strstr(row->allowed, "inf]")))
    MPMOptionsFail(o, "-%s %.100s is not finite", full, text);
  else if (whole && value != floor(value))
    MPMOptionsFail(o, "-%s %.100s must be whole", full, text);
  else
    CheckRange(o, row, full, text, value);
  return MPMOptionsError(o) ? 0 : value;
}

/* Reads a list of dim numbers, one for each axis. Not collective. */
void MPMOptionsList(MPMOptions o, const MPMOptionRow *row, const char full[], const char text[], PetscBool whole,
                    PetscReal value[3])
{
  const char *remedy = "";
  char        list[MPM_TEXT_LEN], *word = list;
  PetscInt    n = 1;

  (void)snprintf(list, sizeof list, "%s", text);
  for (const char *c = text; *c; c++) n += *c == ',';
  if (IsFormula(row, text))
    remedy = formulas;
  else if (n < o->dim && strpbrk(text, "; \t"))
    remedy = "; join values with commas, without blanks";
  else if (n > o->dim && strspn(text, "+-0123456789,") == strlen(text) && !strstr(text, ",,"))
    remedy = " (decimals have a point, not a comma)";
  if (n != o->dim)
    MPMOptionsFail(o, "-%s %.100s has %" PetscInt_FMT " number%s, -dim %" PetscInt_FMT " needs %" PetscInt_FMT "%s",
                   full, text, n, n == 1 ? "" : "s", o->dim, o->dim, remedy);
  for (PetscInt d = 0; d < o->dim && !MPMOptionsError(o); d++) {
    char *comma = strchr(word, ',');

    if (comma) *comma = 0;
    value[d] = MPMOptionsNumber(o, row, full, text, o->dim == 1 ? text : word, whole);
    if (comma) word = comma + 1;
  }
}
