/* files.c - checks options files before PETSc reads them, for faults that PETSc would ignore or would report without
   the name of the file or a remedy. Faults that PETSc reports well, in one line with the file, are left to it. Nothing
   here may call PETSc, which has not been started. */
#include <ctype.h>
#include <errno.h>
#include <strings.h>
#include <sys/stat.h>
#include "options/reader.h"

#define DEEPEST 20 /* nesting of files and of prefixes; PETSc allows 25 */

/* A file that is read up to line `line`: the prefixes in force, where each was pushed, and its own number. */
typedef struct {
  const char *path;
  int         line, depth, number, pushed[DEEPEST];
  size_t      length[DEEPEST]; /* length of the prefix before each push */
  char        prefix[DEEPEST * MPM_NAME_LEN];
} File;

/* The files that were checked, and the last YAML file, which PETSc reads last. */
static struct {
  dev_t device;
  ino_t number;
} * seen;
static size_t nseen;
const char   *MPMOptionsYaml;

/* Returns whether PETSc takes a word for an option: - and a letter. -1 and -inf are values. */
PetscBool MPMOptionsIsOption(const char word[])
{
  char *end;

  if (word[0] != '-') return PETSC_FALSE;
  if (word[1] == '-') word++;
  if (!isalpha((unsigned char)word[1])) return PETSC_FALSE;
  (void)strtod(word, &end);
  return end == word || *end == '_' || isalnum((unsigned char)*end);
}

/* Splits a line into at most 3 words as PETSc does: blanks separate words, "..." joins them, # starts a comment even in
   quotes. Returns what is wrong, or NULL. */
static const char *Split(char *line, char *word[3], int *n)
{
  *n                       = 0;
  line[strcspn(line, "#")] = 0;
  for (char *c = line; *c; c++) {
    if (isspace((unsigned char)*c))
      *c = ' ';
    else if (iscntrl((unsigned char)*c))
      return "not a text file";
  }
  for (char *c = line + strspn(line, " "); *c && *n < 3; c += strspn(c, " ")) {
    const PetscBool quoted = *c == '"';

    c += quoted;
    word[(*n)++] = c;
    c += strcspn(c, quoted ? "\"" : " \"");
    if (quoted && !*c) return "the quote is not closed (# starts a comment even in quotes)";
    if (!quoted && *c == '"') return "a quote in the middle of a value";
    if (*c) *c++ = 0;
    if (quoted && *c && *c != ' ') return "a quote in the middle of a value";
  }
  return NULL;
}

/* Adds the prefix of -prefix_push, or removes the last one for -prefix_pop. Returns what is wrong, or NULL. */
static const char *Prefix(File *f, PetscBool push, const char value[])
{
  if (push) {
    if (!isalpha((unsigned char)value[0]) && !(f->depth && isdigit((unsigned char)value[0])))
      return "-prefix_push needs a prefix";
    if (f->depth == DEEPEST || strlen(value) >= MPM_NAME_LEN) return "prefixes too deep or too long";
    f->pushed[f->depth]   = f->line;
    f->length[f->depth++] = strlen(f->prefix);
    strcat(f->prefix, value);
    return NULL;
  }
  if (value[0]) return "-prefix_pop has no value";
  if (!f->depth) return "-prefix_pop without -prefix_push";
  f->prefix[f->length[--f->depth]] = 0;
  return NULL;
}

/* Notes a name with the prefix in force, and its value; error gets a contradiction to an earlier line. */
static void Note(File *f, const char name[], const char value[], char error[], size_t len)
{
  char full[DEEPEST * MPM_NAME_LEN + MPM_TEXT_LEN];

  (void)snprintf(full, sizeof full, "%s%s", f->prefix, name + 1);
  MPMOptionsNote(f->number, full, value, f->path, f->line, error, len);
}

/* Returns whether a word could be a number, or a list of numbers. */
PetscBool MPMOptionsIsNumbers(const char word[])
{
  return word[0] && word[strspn(word, "0123456789+-.,;eE")] == 0 && strpbrk(word, "0123456789");
}

/* Returns whether a word starts a comment in files of other programs. */
static PetscBool IsComment(const char word[])
{
  return !strncmp(word, "//", 2) || !strncmp(word, "/*", 2) || (word[0] && strchr("%;!", word[0]));
}

/* Checks a word that should be an option, and the next one (or ""), for what is written as other programs want it. */
void MPMOptionsCheckWords(const char word[], const char next[], char fault[], size_t len)
{
  const size_t    n = strlen(word), end = strcspn(word, "=:");
  const PetscBool option = MPMOptionsIsOption(word);

  fault[0] = 0;
  if (!option && IsComment(word))
    (void)snprintf(fault, len, "'%.50s' does not start a comment, # does", word);
  else if (!option && MPMOptionsDash(word) == word)
    (void)snprintf(fault, len, "'%.50s' starts with a Unicode dash; an option starts with a plain -", word);
  else if (word[end] == '=' || !strcmp(next, "="))
    (void)snprintf(fault, len, "'%.50s': an option and its value are separated by a blank, without =", word);
  else if (n && word[n - 1] == ':')
    (void)snprintf(fault, len, "'%.50s': an option has no colon%s", word,
                   option ? "" : " and starts with -; a YAML file is named *.yaml");
  else if (!option && word[0] == '-')
    (void)snprintf(fault, len, "'%.50s' is not an option; its name follows the - at once and starts with a letter",
                   word);
  else if (!option)
    (void)snprintf(fault, len, "'%.50s' is not an option; an option starts with -, a comment with #", word);
}

/* Says what is wrong with a line that has a third word. */
static void CheckThird(char *word[3], char fault[], size_t len)
{
  if (IsComment(word[2]))
    (void)snprintf(fault, len, "'%.50s' does not start a comment, # does", word[2]);
  else if (MPMOptionsIsNumbers(word[1]) && MPMOptionsIsNumbers(word[2]))
    (void)snprintf(fault, len, "%.50s %.50s %.50s: join values with commas, without blanks", word[0], word[1], word[2]);
  else if (MPMOptionsIsNumbers(word[1]) && isalpha((unsigned char)word[2][0]))
    (void)snprintf(fault, len, "%.50s %.50s %.50s: write the number without a unit", word[0], word[1], word[2]);
  else
    (void)snprintf(
        fault, len,
        "more than one value on a line; put it in double quotes, or join values with commas, without blanks");
}

/* Checks a file that a line names. If all of that file is at fault, error names the line too. */
static void CheckIncluded(const File *f, const char path[], int nesting, char error[], size_t len)
{
  const size_t n = strlen(path);
  char         text[MPM_TEXT_LEN];

  MPMOptionsCheckFile(path, nesting, error, len);
  if (strncmp(error, path, n) || strncmp(error + n, ": ", 2)) return;
  (void)snprintf(text, sizeof text, "%.1500s", error);
  (void)snprintf(error, len, "%.500s:%d: -options_file %s%s", f->path, f->line, text,
                 path[0] != '/' && strstr(text, strerror(ENOENT))
                     ? "; this path starts at the folder in which the program was started"
                     : "");
}

/* Checks one line of an options file, which is `length` characters long. */
static void CheckLine(File *f, char *line, size_t length, int nesting, char error[], size_t len)
{
  char       *word[3] = {NULL}, text[MPM_TEXT_LEN] = "";
  const char *fault = length != strlen(line) ? "not a text file" : NULL, *value;
  int         n     = 0;

  if (!fault && f->line == 1 && !strncmp(line, "\xef\xbb\xbf", 3))
    fault = "starts with a byte-order mark; save it without";
  if (!fault) fault = Split(line, word, &n);
  if (!fault && !n) return;
  value = n > 1 ? word[1] : "";
  if (!fault) MPMOptionsCheckWords(word[0], value, text, sizeof text);
  if (text[0]) fault = text;
  if (fault)
    ;
  else if ((n > 1 && MPMOptionsIsOption(word[1])) || (n > 2 && MPMOptionsIsOption(word[2])))
    fault = "two options on one line (a value that starts with - and a letter goes in parentheses: \"(-y), x\")";
  else if (strlen(value) >= MPM_TEXT_LEN - 1) {
    MPMOptionsTooLong(word[0], strlen(value), text, sizeof text);
    fault = text;
  } else if (strlen(word[0]) >= MPM_TEXT_LEN) {
    (void)snprintf(text, sizeof text, "%.50s...: this name is too long, at most %d characters", word[0], MPM_FULL_LEN);
    fault = text;
  } else if (value[0] == '\'')
    fault = "use double quotes";
  else if (n > 2) {
    CheckThird(word, text, sizeof text);
    fault = text;
  } else if (!strcasecmp(word[0], "-prefix_push") || !strcasecmp(word[0], "-prefix_pop"))
    fault = Prefix(f, !strcasecmp(word[0], "-prefix_push"), value);
  else if (strncasecmp(word[0], "-options_file", 13))
    Note(f, word[0], value, error, len);
  else if (value[0])
    CheckIncluded(f, value, nesting + 1, error, len);
  else
    fault = "-options_file has no value";
  if (fault) (void)snprintf(error, len, "%.1000s:%d: %s", f->path, f->line, fault);
}

/* Checks a YAML file, which PETSc parses; only frequent faults are found here. */
static void CheckYaml(FILE *file, const char path[], char error[], size_t len)
{
  char   *line = NULL, *text = NULL;
  size_t  size = 0, total = 0;
  ssize_t length;

  for (int k = 1; !error[0] && (length = getline(&line, &size, file)) >= 0; k++) {
    char *more = realloc(text, total + (size_t)length + 1);

    if (!more) break;
    text = more;
    memcpy(text + total, line, (size_t)length + 1);
    total += (size_t)length;
    if ((size_t)length != strlen(line) || line[strcspn(line, "\033\177")])
      (void)snprintf(error, len, "%.1000s:%d: not a text file", path, k);
    else if (line[strspn(line, " ")] == '\t')
      (void)snprintf(error, len, "%.1000s:%d: YAML is indented with blanks, not tabs", path, k);
  }
  if (!error[0] && text) MPMOptionsCheckYaml(path, text, error, len);
  free(line);
  free(text);
}

/* Checks all lines of an open file, up to the first fault. */
static void CheckLines(FILE *file, const char path[], int nesting, char error[], size_t len)
{
  File   *f    = calloc(1, sizeof *f);
  char   *line = NULL;
  size_t  size = 0;
  ssize_t length;

  if (!f) return;
  f->path   = path;
  f->number = MPMOptionsNewFile();
  while (!error[0] && (length = getline(&line, &size, file)) >= 0) {
    f->line++;
    CheckLine(f, line, (size_t)length, nesting, error, len);
  }
  if (!error[0] && f->depth > 0)
    (void)snprintf(error, len, "%.1000s:%d: -prefix_push %.*s without -prefix_pop", path, f->pushed[0],
                   (int)(f->depth > 1 ? f->length[1] : strlen(f->prefix)), f->prefix);
  free(f);
  free(line);
}

/* Returns whether PETSc takes a file for YAML by its name. A suffix ":yaml" is cut off. */
static PetscBool IsYamlByName(char path[])
{
  static const char *const ends[] = {":yaml", ".yaml", ".yml", ".json"};

  for (size_t k = 0; k < sizeof ends / sizeof ends[0]; k++) {
    const size_t n = strlen(path), m = strlen(ends[k]);

    if (n < m || strcmp(path + n - m, ends[k])) continue;
    if (!k) path[n - m] = 0;
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns whether a file is YAML by its first characters. */
static PetscBool IsYamlByStart(FILE *f)
{
  char start[8] = "";

  if (!fread(start, 1, 6, f)) start[0] = 0;
  rewind(f);
  return !strncmp(start, "%YAML ", 6) || !strncmp(start, "---", 3);
}

/* Notes that a file is one of those that are read. */
static void NoteFile(const struct stat *status)
{
  void *more;

  for (size_t k = 0; k < nseen; k++)
    if (seen[k].device == status->st_dev && seen[k].number == status->st_ino) return;
  more = realloc(seen, (nseen + 1) * sizeof *seen);

  if (!more) return;
  seen                 = more;
  seen[nseen].device   = status->st_dev;
  seen[nseen++].number = status->st_ino;
}

void MPMOptionsNoteFile(const char path[])
{
  struct stat status;

  if (!stat(path, &status)) NoteFile(&status);
}

/* Checks an options file, and the files that it names. error [len] gets the first fault. nesting is the number of files
   around it. */
void MPMOptionsCheckFile(const char name[], int nesting, char error[], size_t len)
{
  struct stat status;
  char        path[PETSC_MAX_PATH_LEN];
  FILE       *f;
  PetscBool   yaml;

  if (strlen(name) >= sizeof path) return; /* PETSc reports that it cannot open it */
  (void)snprintf(path, sizeof path, "%s", name);
  yaml = IsYamlByName(path);
  if (nesting > DEEPEST)
    (void)snprintf(error, len, "%s: options files nest too deeply", path);
  else if (!stat(path, &status) && !S_ISREG(status.st_mode)) /* checked before it is opened, since a pipe would block */
    (void)snprintf(error, len, "%s: a folder or a device, not an options file", path);
  else if (!(f = fopen(path, "r")))
    (void)snprintf(error, len, "%s: %s", path, strerror(errno));
  else {
    yaml = yaml || IsYamlByStart(f);
    if (yaml) MPMOptionsYaml = name;
    if (yaml)
      CheckYaml(f, path, error, len);
    else
      CheckLines(f, path, nesting, error, len);
    NoteFile(&status);
    (void)fclose(f);
  }
}

/* Returns whether a path is one of the options files that were checked, whatever its spelling. Not collective. */
PetscBool MPMOptionsAreIn(const char path[])
{
  struct stat status;

  for (size_t k = 0; !stat(path, &status) && k < nseen; k++)
    if (status.st_dev == seen[k].device && status.st_ino == seen[k].number) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Forgets the files that were checked, and their lines. Not collective. */
void MPMOptionsForget(void)
{
  free(seen);
  seen           = NULL;
  nseen          = 0;
  MPMOptionsYaml = NULL;
  MPMOptionsForgetPlaces();
}
