/* help.c - what -help prints: the vocabulary and what formulas may contain, whole or those lines that have a word.
   Nothing here may call PETSc, which has not started. */
#include <ctype.h>
#include <strings.h>
#include "options/reader.h"

#define MOST_CLOSE 3 /* words that are close to one that nothing has */

/* --- Lines -------------------------------------------------------------------------------------------------------- */

/* Writes the words of a list, which are separated by blanks. */
static void WriteWords(FILE *to, const char words[])
{
  const char *comma = " (all, or a list of ";

  for (const char *w = words + strspn(words, " "); *w; w += strspn(w, " ")) {
    const int n = (int)strcspn(w, " ");

    fprintf(to, "%s%.*s", comma, n, w);
    comma = ",";
    w += n;
  }
  fprintf(to, ")");
}

/* Writes the line of an option: name, default, unit, meaning, allowed values. */
static void WriteOption(FILE *to, const MPMOptionRow *row)
{
  const PetscBool numbers = row->type == MPM_REALS || row->type == MPM_INTS;
  const PetscBool whole   = row->type == MPM_INT || row->type == MPM_INTS;

  if (row->type == MPM_LATER) {
    fprintf(to, "  -%s: not built yet (%s)", row->name, row->help);
    return;
  }
  fprintf(to, "  -%s <%s>%s%s: %s", row->name, row->fallback, row->unit[0] ? " " : "", row->unit, row->help);
  if (row->type == MPM_ENUM) fprintf(to, " (%s)", row->allowed);
  if (row->type == MPM_BOOL) fprintf(to, " (true|false)");
  if (row->type == MPM_TEXT && row->allowed[0]) WriteWords(to, row->allowed);
  if (row->allowed[0] && row->type != MPM_ENUM && row->type != MPM_TEXT)
    fprintf(to, " (%s%s%s)", whole ? "whole, " : "", numbers ? "-dim values in " : "in ", row->allowed);
}

/* A line of the help. */
typedef struct {
  const char         *title; /* of its group */
  const MPMOptionRow *row;   /* NULL: of a formula */
  char               *text;  /* the caller frees it */
} Line;

/* Sets line k, counted from 0; returns false if there are not so many. A line without text is a title or an option that
   is no longer there. */
static PetscBool GetLine(const MPMVocabulary *table, size_t k, Line *line)
{
  const char *what = "", *meaning = "";
  size_t      n;
  FILE       *to;

  if (k >= table->n && !MPMFormulaWord(k - table->n, &what, &meaning)) return PETSC_FALSE;
  line->row  = k < table->n ? &table->row[k] : NULL;
  line->text = NULL;
  if (k == table->n) line->title = MPMFormulaTitle;
  if (line->row && !line->row->name) line->title = line->row->help;
  if (line->row && (!line->row->name || line->row->type == MPM_MOVED)) return PETSC_TRUE;
  to = open_memstream(&line->text, &n);
  if (!to) return PETSC_FALSE;
  if (line->row)
    WriteOption(to, line->row);
  else
    fprintf(to, "  %s: %s", what, meaning);
  (void)fclose(to);
  return PETSC_TRUE;
}

/* --- Words -------------------------------------------------------------------------------------------------------- */

/* Returns whether the first n characters of a text have a word that begins so; if it has one or two letters, the whole
   word. */
static PetscBool TextHas(const char text[], size_t n, const char word[])
{
  const size_t len = strlen(word);

  for (size_t k = 0; k + len <= n; k++)
    if (!strncasecmp(text + k, word, len) && !(k && isalnum((unsigned char)text[k - 1])) &&
        (len > 2 || !isalnum((unsigned char)text[k + len])))
      return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Returns whether a word is the name of an option with a name of a scene in it, body_disk1_radius. */
static PetscBool IsNameOf(const char row[], const char word[])
{
  const char  *open = strchr(row, '<'), *tail = open ? open + 3 : "";
  const size_t n = strlen(word), head = open ? (size_t)(open - row) : 0;

  return open && n > head + strlen(tail) && !strncasecmp(row, word, head) && !strcasecmp(word + n - strlen(tail), tail);
}

/* Returns whether a word is that of another program for an option, or for the end of its name. */
static PetscBool IsAliasOf(const MPMVocabulary *table, const char row[], const char word[])
{
  for (size_t k = 0; k < table->naliases; k++) {
    const char  *end = table->aliases[k][1];
    const size_t n = strlen(row), len = strlen(end);

    if (!MPMOptionsHasWord(table->aliases[k][0], word, strlen(word)) || n < len || strcmp(row + n - len, end)) continue;
    if (n == len || row[n - len - 1] == '_') return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns whether a line has a word. */
static PetscBool Has(const MPMVocabulary *table, const Line *line, const char word[])
{
  if (!line->text) return PETSC_FALSE;
  if (TextHas(line->text, strlen(line->text), word) || TextHas(line->title, strcspn(line->title, ":"), word))
    return PETSC_TRUE;
  return line->row && (IsNameOf(line->row->name, word) || IsAliasOf(table, line->row->name, word));
}

/* Prints the lines that have all n words; returns how many there are. With print false it only counts. */
static size_t PrintLines(const MPMVocabulary *table, int n, char **words, PetscBool print)
{
  const char *title = NULL;
  Line        line  = {0};
  size_t      found = 0;

  for (size_t k = 0; GetLine(table, k, &line); k++) {
    PetscBool all = line.text ? PETSC_TRUE : PETSC_FALSE;

    for (int w = 0; w < n && all; w++) all = Has(table, &line, words[w]);
    if (all && print && line.title != title) printf("%s%s\n", title || !n ? "\n" : "", line.title);
    if (all && print) printf("%s\n", line.text);
    if (all) title = line.title;
    found += all;
    free(line.text);
  }
  return found;
}

/* Lists the words of the help that are closest to one that it does not have, or "". */
static void Close(const MPMVocabulary *table, const char word[], char list[], size_t len)
{
  static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
  Line              line      = {0};
  int               best = 1 + PetscMin(3, (int)strlen(word) / 3), n = 0;

  list[0] = 0;
  for (size_t k = 0; GetLine(table, k, &line); k++) {
    for (char *w = line.text ? line.text : NULL, *end; w && *(w += strcspn(w, letters)); w = end) {
      char other[MPM_NAME_LEN];
      int  d;

      end = w + strspn(w, letters);
      (void)snprintf(other, sizeof other, "%.*s", (int)PetscMin(end - w, MPM_NAME_LEN - 1), w);
      d = MPMOptionsDistance(word, other);
      if (strlen(other) < 3 || d > best) continue;
      if (d == best && (n == 0 || n == MOST_CLOSE || TextHas(list, strlen(list), other))) continue;
      if (d < best) n = 0;
      best = d;
      (void)snprintf(list + (n ? strlen(list) : 0), len - (n ? strlen(list) : 0), "%s%s", n ? ", " : "", other);
      n++;
    }
    free(line.text);
  }
}

/* Described in reader.h. */
PetscBool MPMOptionsHelp(const MPMVocabulary *table, int n, char **words, PetscBool print, char fault[], size_t len)
{
  char        list[MPM_TEXT_LEN / 4] = "", close[MPM_TEXT_LEN / 4] = "";
  char        joined[MPM_TEXT_LEN / 4] = "";
  const char *instead                  = NULL;
  size_t      each                     = n > 1, found;

  fault[0] = 0;
  if (n == 0 && print)
    printf(
        "Pebble: the Material Point Method on PETSc\n"
        "  pebble -options_file options/disks.opts [-option value ...]\n"
        "  pebble -help wall prints the options that have this word, or what a word of another program is here;\n"
        "  pebble -help words lists all such words, pebble -help petsc also PETSc's own options\n"
        "  pebble -version; -log_view times events and counts messages, -dm_view prints the DMs of grid and particles\n"
        "Options: <default> unit: meaning (allowed). Lists have no blanks: -gravity 0,-9.81\n");
  for (int w = 0; w < n; w++) MPMAppend(joined, sizeof joined, "%s%.100s", w ? "_" : "", words[w]);
  if (!strcasecmp(joined, "words"))
    return MPMOptionsPrintWords(table, NULL, PETSC_FALSE, print) ? PETSC_TRUE : PETSC_FALSE;
  found = PrintLines(table, n, words, print);
  if (n) found += MPMOptionsPrintWords(table, joined, found ? PETSC_TRUE : PETSC_FALSE, print);
  if (found) return PETSC_TRUE;
  for (int w = 0; w < n; w++) {
    MPMAppend(list, sizeof list, " %.100s", words[w]);
    if (PrintLines(table, 1, words + w, PETSC_FALSE)) continue;
    each = 0;
    if (!instead) instead = MPMOptionsForeign(table, words[w]);
    if (!close[0]) Close(table, words[w], close, sizeof close);
  }
  (void)snprintf(fault, len, "-help%s: no option has %s; %s%s%s", list,
                 each     ? "all of these words"
                 : n == 1 ? "this word"
                          : "one of these words",
                 instead    ? instead
                 : close[0] ? "did you mean "
                            : "pebble -help lists all options, pebble -help petsc also PETSc's",
                 instead ? "" : close, !instead && close[0] ? " ?" : "");
  return PETSC_FALSE;
}
