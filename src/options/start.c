/* start.c - before MPI and PETSc start: -help, -version, and what PETSc would answer with a stack of calls or
   not at all: arguments that are not options, and options files that do not parse. Each process looks for itself, and
   the first one speaks. Nothing here may call PETSc. */
#include <ctype.h>
#include <errno.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>
#include "options/reader.h"

#define DEEPEST 20 /* files in files, and prefixes in prefixes: PETSc takes 25 */

static const char *yaml; /* the YAML file that PETSc will read last */
static PetscBool   started;

/* The rank before MPI is up, as the launcher tells it. */
static int RankFromEnvironment(void)
{
  static const char *const names[] = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"};

  for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
    if (getenv(names[k])) return atoi(getenv(names[k]));
  return 0;
}

static void Say(const char line[])
{
  if (RankFromEnvironment() == 0) fprintf(stderr, "%.*s\n", (int)strcspn(line, "\n"), line);
}

/* Is it an option, as PETSc sees it? -1 and -inf are values. */
static PetscBool IsOption(const char word[])
{
  char *end;

  if (word[0] != '-') return PETSC_FALSE;
  if (word[1] == '-') word++;
  if (!isalpha((unsigned char)word[1])) return PETSC_FALSE;
  (void)strtod(word, &end);
  return end == word || *end == '_' || isalnum((unsigned char)*end) ? PETSC_TRUE : PETSC_FALSE;
}

/* --- Options files -------------------------------------------------------------------------------------------- */

/* Cuts a line into at most 3 words, as PETSc does: blanks separate, "..." joins, # starts a comment even in quotes.
   Returns what is wrong, or NULL. */
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
    const PetscBool quoted = *c == '"' ? PETSC_TRUE : PETSC_FALSE;

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

/* What is wrong with a line of n words, or NULL. depth: prefixes that are pushed. */
static const char *CheckWords(char *word[3], int n, int *depth)
{
  const char *value = n > 1 ? word[1] : "";

  if (!IsOption(word[0])) return "a line starts with -name";
  if ((n > 1 && IsOption(word[1])) || (n > 2 && IsOption(word[2])))
    return "two options on one line (a value that starts with - and a letter goes in parentheses: \"(-y), x\")";
  if (value[0] == '\'') return "use double quotes";
  if (n > 2) return "more than one value on a line; put it in double quotes or join it with commas";
  if (!strcasecmp(word[0], "-prefix_push")) {
    if (!isalpha((unsigned char)value[0]) && !(*depth && isdigit((unsigned char)value[0])))
      return "-prefix_push needs a prefix";
    if (++*depth > DEEPEST || strlen(value) >= MPM_NAME_LEN) return "prefixes too deep or too long";
  }
  if (!strcasecmp(word[0], "-prefix_pop")) {
    if (n > 1) return "-prefix_pop has no value";
    if (--*depth < 0) return "-prefix_pop without -prefix_push";
  }
  if (!strncasecmp(word[0], "-options_file", 13) && !value[0]) return "-options_file has no value";
  return NULL;
}

static void CheckFile(const char file[], int nesting, char error[], size_t len);

static void CheckLines(FILE *f, const char file[], int nesting, char error[], size_t len)
{
  char   *line = NULL, *word[3];
  size_t  size = 0;
  ssize_t length;
  int     number = 0, depth = 0, n;

  while (!error[0] && (length = getline(&line, &size, f)) >= 0) {
    const char *fault = (size_t)length != strlen(line) ? "not a text file" : NULL;

    number++;
    if (!fault && number == 1 && !strncmp(line, "\xef\xbb\xbf", 3))
      fault = "starts with a byte-order mark; save it without";
    if (!fault) fault = Split(line, word, &n);
    if (!fault && n) fault = CheckWords(word, n, &depth);
    if (fault)
      (void)snprintf(error, len, "%s:%d: %s", file, number, fault);
    else if (n && !strncasecmp(word[0], "-options_file", 13))
      CheckFile(word[1], nesting + 1, error, len);
  }
  if (!error[0] && depth > 0) (void)snprintf(error, len, "%s:%d: -prefix_push without -prefix_pop", file, number);
  free(line);
}

/* YAML is PETSc's to parse, all but the fault that is met most. */
static void CheckYaml(FILE *f, const char file[], char error[], size_t len)
{
  char   *line = NULL;
  size_t  size = 0;
  ssize_t length;

  for (int number = 1; !error[0] && (length = getline(&line, &size, f)) >= 0; number++) {
    if ((size_t)length != strlen(line))
      (void)snprintf(error, len, "%s:%d: not a text file", file, number);
    else if (line[strspn(line, " ")] == '\t')
      (void)snprintf(error, len, "%s:%d: YAML is indented with blanks, not tabs", file, number);
  }
  free(line);
}

/* Is it YAML? By its name, as PETSc sees it, or by its start. A suffix ":yaml" is cut off. */
static PetscBool IsYaml(char path[])
{
  static const char *const ends[]   = {":yaml", ".yaml", ".yml", ".json"};
  char                     start[6] = "";
  FILE                    *f;

  for (size_t k = 0; k < sizeof ends / sizeof ends[0]; k++) {
    const size_t n = strlen(path), m = strlen(ends[k]);

    if (n < m || strcmp(path + n - m, ends[k])) continue;
    if (!k) path[n - m] = 0;
    return PETSC_TRUE;
  }
  f = fopen(path, "r");
  if (f && !fread(start, 1, sizeof start, f)) start[0] = 0;
  if (f) (void)fclose(f);
  return !strncmp(start, "%YAML ", 6) || !strncmp(start, "---", 3) ? PETSC_TRUE : PETSC_FALSE;
}

static void CheckFile(const char file[], int nesting, char error[], size_t len)
{
  struct stat status;
  char        path[PETSC_MAX_PATH_LEN];
  FILE       *f;
  PetscBool   is_yaml;

  if (strlen(file) >= sizeof path) (void)snprintf(error, len, "%.100s...: the name is too long", file);
  if (nesting > DEEPEST) (void)snprintf(error, len, "%s: options files nest too deeply", file);
  if (error[0]) return;
  (void)snprintf(path, sizeof path, "%s", file);
  if (stat(path, &status) == 0 && !S_ISREG(status.st_mode)) {
    (void)snprintf(error, len, "%.1000s: %s, not an options file", path,
                   S_ISDIR(status.st_mode) ? "a folder" : "a device");
    return;
  }
  is_yaml = IsYaml(path);
  f       = fopen(path, "r");
  if (!f) {
    (void)snprintf(error, len, "%s: %s", path, strerror(errno));
    return;
  }
  if (is_yaml) {
    yaml = file;
    CheckYaml(f, path, error, len);
  } else
    CheckLines(f, path, nesting, error, len);
  (void)fclose(f);
}

/* --- Arguments ------------------------------------------------------------------------------------------------ */

/* Options files come first, in their order, so that the rest of the command line overrides them wherever they stand. */
static void MoveFilesFirst(int argc, char **argv)
{
  int to = 1;

  for (int k = 1; k < argc; k++)
    if (!strcasecmp(argv[k], "-prefix_push")) return; /* order matters */
  for (int k = 1; k + 1 < argc; k++) {
    char *option = argv[k], *file = argv[k + 1];

    if (strcasecmp(option, "-options_file")) continue;
    memmove(argv + to + 2, argv + to, (size_t)(k - to) * sizeof *argv);
    argv[to]     = option;
    argv[to + 1] = file;
    to += 2;
    k++;
  }
}

/* PETSc passes over words that are neither options nor values of one, and stops at files that do not parse. */
static void CheckArguments(int argc, char **argv, char error[], size_t len)
{
  int depth = 0;

  for (int k = 1; k < argc && !error[0]; k++) {
    const char     *word   = argv[k];
    const PetscBool valued = k + 1 < argc && !IsOption(argv[k + 1]) ? PETSC_TRUE : PETSC_FALSE;

    if (!IsOption(word)) {
      if (access(word, R_OK) == 0)
        (void)snprintf(error, len, "%.200s is not an option; did you mean -options_file %.200s ?", word, word);
      else
        (void)snprintf(error, len,
                       "%.200s is not an option; an option starts with -, its value has no blanks outside of quotes",
                       word);
      continue;
    }
    if (!strcasecmp(word, "-prefix_push")) depth++;
    if (!strcasecmp(word, "-prefix_pop") && --depth < 0) (void)snprintf(error, len, "-prefix_pop without -prefix_push");
    if (!strncasecmp(word, "-options_file", 13) || !strcasecmp(word, "-prefix_push")) {
      if (!valued || !argv[k + 1][0] || argv[k + 1][0] == '-')
        (void)snprintf(error, len, "%.100s has no value", word);
      else if (word[1] == 'o' || word[1] == 'O')
        CheckFile(argv[k + 1], 0, error, len);
    }
    k += valued;
  }
  if (!error[0] && depth > 0) (void)snprintf(error, len, "-prefix_push without -prefix_pop");
}

/* --- Help ----------------------------------------------------------------------------------------------------- */

/* The vocabulary: names, defaults, units, ranges. */
static void PrintHelp(const MPMVocabulary *table)
{
  printf(
      "Pebble: the Material Point Method on PETSc\n"
      "  pebble -options_file options/disks.opts [-option value ...]\n"
      "  pebble -version; pebble -help petsc also lists PETSc's own options; -log_view times events and counts messages,\n"
      "  -dm_view prints the DMs of grid and particles\n"
      "Options: <default> unit: meaning (allowed). Lists have no blanks: -gravity 0,-9.81\n");
  for (size_t r = 0; r < table->n; r++) {
    const MPMOptionRow *row     = &table->row[r];
    const PetscBool     numbers = row->type == MPM_REALS || row->type == MPM_INTS ? PETSC_TRUE : PETSC_FALSE;
    const PetscBool     whole   = row->type == MPM_INT || row->type == MPM_INTS ? PETSC_TRUE : PETSC_FALSE;

    if (!row->name)
      printf("\n%s\n", row->help);
    else if (row->type == MPM_LATER)
      printf("  -%s: not built yet (%s)\n", row->name, row->help);
    else {
      printf("  -%s <%s>%s%s: %s", row->name, row->fallback, row->unit[0] ? " " : "", row->unit, row->help);
      if (row->type == MPM_ENUM) printf(" (%.*s)", (int)strcspn(row->allowed, " "), row->allowed);
      if (row->type == MPM_BOOL) printf(" (true|false)");
      if (row->allowed[0] && row->type != MPM_ENUM)
        printf(" (%s%s%s)", whole ? "whole, " : "", numbers ? "-dim values in " : "in ", row->allowed);
      printf("\n");
    }
  }
}

/* Answers -help and -version: true if one was given. `-help petsc` becomes PETSc's -help. */
static PetscBool Answer(const MPMVocabulary *table, int argc, char **argv)
{
  static char       yes[]       = "true";
  const char *const wanted[][2] = {{"help", "version"}, {"h", "v"}};

  for (int k = 1; k < argc; k++) {
    const char *word = argv[k] + strspn(argv[k], "-");

    if (word == argv[k]) continue;
    if (!strcasecmp(word, wanted[0][0]) || !strcasecmp(word, wanted[1][0])) {
      if (RankFromEnvironment() == 0) PrintHelp(table);
      if (k + 1 == argc || strcasecmp(argv[k + 1], "petsc")) return PETSC_TRUE;
      argv[k + 1] = yes;
      return PETSC_FALSE;
    }
    if (!strcasecmp(word, wanted[0][1]) || !strcasecmp(word, wanted[1][1])) {
      if (RankFromEnvironment() == 0)
        printf("pebble %s (%s), PETSc %d.%d.%d, %s\n", MPM_VERSION, MPMVersionGit, PETSC_VERSION_MAJOR,
               PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, MPMVersionCompiler);
      return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

PetscBool MPMOptionsStart(const MPMVocabulary *table, int argc, char **argv, int *status)
{
  char error[MPM_TEXT_LEN] = "";

  *status = MPM_EXIT_OK;
  if (Answer(table, argc, argv)) return PETSC_TRUE;
  if (argc < 2 && !getenv("PETSC_OPTIONS") && !getenv("PETSC_OPTIONS_YAML"))
    (void)snprintf(
        error, sizeof error,
        "usage: pebble -options_file options/disks.opts [-option value ...]   (pebble -help lists the options)");
  else
    CheckArguments(argc, argv, error, sizeof error);
  MoveFilesFirst(argc, argv);
  if (!error[0]) return PETSC_FALSE;
  Say(error);
  *status = MPM_EXIT_INPUT;
  return PETSC_TRUE;
}

void MPMOptionsStarted(void)
{
  started = PETSC_TRUE;
}

PetscErrorCode MPMOptionsStartFault(MPI_Comm comm, int line, const char *function, const char *file,
                                    PetscErrorCode code, PetscErrorType type, const char *text, void *context)
{
  char error[MPM_TEXT_LEN];

  if (started) return PetscTraceBackErrorHandler(comm, line, function, file, code, type, text, context);
  if (text && strstr(text, "YAML"))
    (void)snprintf(error, sizeof error, "%.200s: not valid YAML, or not names with values",
                   yaml ? yaml : "-options_string_yaml");
  else
    (void)snprintf(error, sizeof error, "%s", text ? text : "PETSc does not start");
  Say(error);
  exit(MPM_EXIT_INPUT);
}
