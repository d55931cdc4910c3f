/* start.c - what happens before MPI and PETSc start: -help, -version, and faults that PETSc would not report, or not in
   a helpful way: arguments that are not options, and faults of options files (files.c). Each process checks for itself,
   and the first one prints. Nothing here may call PETSc. */
#include <strings.h>
#include <unistd.h>
#include "options/reader.h"

static PetscBool started;
static int       number; /* of different options that were given */

/* Returns the rank, as the launcher gives it in the environment, since MPI has not started. */
static int RankFromEnvironment(void)
{
  static const char *const names[] = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"};

  for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
    if (getenv(names[k])) return atoi(getenv(names[k]));
  return 0;
}

/* Prints the first line of a text on the first process, to standard error. */
static void Say(const char line[])
{
  if (RankFromEnvironment() == 0) fprintf(stderr, "%.*s\n", (int)strcspn(line, "\n"), line);
}

/* --- Arguments ---------------------------------------------------------------------------------------------------- */

/* Moves options files to the front of the arguments, in their sequence: the rest of the command line then overrides
   them wherever they stand. */
static void MoveFilesFirst(int argc, char **argv)
{
  int to = 1;

  for (int k = 1; k < argc; k++)
    if (!strcasecmp(argv[k], "-prefix_push")) return; /* the sequence matters */
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

/* Returns whether a word that looks like an option is the value of the option before it, an expression with a minus
   first: it has signs that no option has, or is a variable. */
static PetscBool IsExpression(const char word[])
{
  static const char *const variables[] = {"x", "y", "z", "X", "Y", "Z", "t", "pi"};

  if (strpbrk(word, ",*+/^()")) return PETSC_TRUE;
  for (size_t k = 0; k < sizeof variables / sizeof variables[0]; k++)
    if (!strcmp(word + 1, variables[k])) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Says what is wrong with a word of the arguments that is no option, after `option` and its value, or NULLs. */
static void CheckStray(const char option[], const char value[], const char word[], char error[], size_t len)
{
  if (access(word, R_OK) == 0)
    (void)snprintf(error, len, "%.200s is not an option; did you mean -options_file %.200s ?", word, word);
  else if (value && MPMOptionsIsNumbers(value) && MPMOptionsIsNumbers(word))
    (void)snprintf(error, len, "%.100s %.100s %.100s: join values with commas, without blanks", option, value, word);
  else if (MPMOptionsDash(word) == word || word[0] == '=')
    MPMOptionsCheckWords(word, "", error, len);
  else
    (void)snprintf(error, len,
                   "%.200s is not an option; an option starts with -, its value has no blanks outside of quotes", word);
}

/* Keeps a prefix that was pushed, if value is not NULL, or drops the last one. `pushed` has place for `most`. */
static void CheckPrefix(const char value[], const char *pushed[], int most, int *depth, char error[], size_t len)
{
  if (!value && !*depth)
    (void)snprintf(error, len, "-prefix_pop without -prefix_push");
  else if (!value)
    --*depth;
  else if (*depth == most)
    (void)snprintf(error, len, "prefixes too deep or too long");
  else
    pushed[(*depth)++] = value;
}

/* Returns how many different options the arguments and the files that they name give. */
static int CountOptions(int argc, char **argv)
{
  int n = MPMOptionsPlaced();

  for (int k = 1; k < argc; k++) {
    int j = 1;

    if (!MPMOptionsIsOption(argv[k]) || !strncasecmp(argv[k], "-options_file", 13)) continue;
    while (j < k && strcasecmp(argv[j], argv[k])) j++;
    n += j == k && !MPMOptionsIsPlaced(argv[k] + 1);
  }
  return n;
}

/* Reports words that are neither options nor their values, and prefixes that are not popped: PETSc ignores both. */
static void CheckArguments(int argc, char **argv, char error[], size_t len)
{
  const char *pushed[20], *option = NULL, *value = NULL;
  int         depth = 0;

  for (int k = 1; k < argc && !error[0]; k++) {
    const char     *word   = argv[k];
    const PetscBool valued = k + 1 < argc && !MPMOptionsIsOption(argv[k + 1]);

    if (!MPMOptionsIsOption(word))
      CheckStray(option, value, word, error, len);
    else if (!valued && k + 1 < argc && IsExpression(argv[k + 1]))
      (void)snprintf(error, len,
                     "%.100s %.200s: a value that starts with - and a letter looks like an option; write "
                     "0%.200s",
                     word, argv[k + 1], argv[k + 1]);
    else if (!strncasecmp(word, "-options_file", 13) && !(valued && argv[k + 1][0]))
      (void)snprintf(error, len, "%.100s has no value", word);
    else if (!strncasecmp(word, "-options_file", 13))
      MPMOptionsCheckFile(argv[k + 1], 0, error, len);
    else
      MPMOptionsCheckWords(word, valued ? argv[k + 1] : "", error, len);
    if (error[0]) return;
    if (!strcasecmp(word, "-prefix_pop")) CheckPrefix(NULL, pushed, 20, &depth, error, len);
    if (valued && !strcasecmp(word, "-prefix_push")) CheckPrefix(argv[k + 1], pushed, 20, &depth, error, len);
    option = word;
    value  = valued ? argv[k + 1] : NULL;
    k += valued;
  }
  if (!error[0] && depth > 0) (void)snprintf(error, len, "-prefix_push %.100s without -prefix_pop", pushed[depth - 1]);
}

/* --- Answers ------------------------------------------------------------------------------------------------------ */

/* Answers -help, and the words after it. PETSc, which would take them for the value of its own -help, has not started;
   `-help petsc` becomes that -help. Returns true if the program shall end with *status. */
static PetscBool AnswerHelp(const MPMVocabulary *table, int argc, char **argv, int k, int *status)
{
  static char yes[] = "true";
  char        fault[MPM_TEXT_LEN];
  int         n = 0;

  if (k + 1 < argc && !strcasecmp(argv[k + 1], "petsc")) {
    (void)MPMOptionsHelp(table, 0, NULL, RankFromEnvironment() == 0, fault, sizeof fault);
    argv[k + 1] = yes;
    return PETSC_FALSE;
  }
  while (k + 1 + n < argc && argv[k + 1 + n][0] && !MPMOptionsIsOption(argv[k + 1 + n])) n++;
  if (!MPMOptionsHelp(table, n, argv + k + 1, RankFromEnvironment() == 0, fault, sizeof fault)) {
    Say(fault);
    *status = MPM_EXIT_INPUT;
  }
  return PETSC_TRUE;
}

/* Answers -help and -version. Returns true if the program shall end with *status. */
static PetscBool Answer(const MPMVocabulary *table, int argc, char **argv, int *status)
{
  for (int k = 1; k < argc; k++) {
    const char *word = argv[k] + strspn(argv[k], "-");

    if (word == argv[k]) continue;
    if (!strcasecmp(word, "help") || !strcasecmp(word, "h")) return AnswerHelp(table, argc, argv, k, status);
    if (!strcasecmp(word, "version") || !strcasecmp(word, "v")) {
      if (RankFromEnvironment() == 0)
        printf("pebble %s (%s), PETSc %d.%d.%d, %s\n", MPM_VERSION, MPMVersionGit, PETSC_VERSION_MAJOR,
               PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, MPMVersionCompiler);
      return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

/* Answers -help, -version and faults, and moves options files to the front of argv; returns true if the program shall
   end with *status. */
PetscBool MPMOptionsStart(const MPMVocabulary *table, int argc, char **argv, int *status)
{
  const char *name                = argc && strrchr(argv[0], '/') ? strrchr(argv[0], '/') + 1 : "pebble";
  char        error[MPM_TEXT_LEN] = "";

  *status = MPM_EXIT_OK;
  if (Answer(table, argc, argv, status)) return PETSC_TRUE;
  if (argc < 2 && !getenv("PETSC_OPTIONS") && !getenv("PETSC_OPTIONS_YAML"))
    (void)snprintf(
        error, sizeof error,
        "usage: %.100s -options_file options/disks.opts [-option value ...]   (pebble -help lists the options)", name);
  else
    CheckArguments(argc, argv, error, sizeof error);
  number = CountOptions(argc, argv);
  MoveFilesFirst(argc, argv);
  if (!error[0]) return PETSC_FALSE;
  Say(error);
  *status = MPM_EXIT_INPUT;
  return PETSC_TRUE;
}

/* Tells the error handler that PETSc has started. */
void MPMOptionsStarted(void)
{
  started = PETSC_TRUE;
}

/* Handles an error of PETSc: until it has started, prints one line and exits; afterwards prints the stack of calls. */
PetscErrorCode MPMOptionsStartFault(MPI_Comm comm, int line, const char *function, const char *file,
                                    PetscErrorCode code, PetscErrorType type, const char *text, void *context)
{
  char error[MPM_TEXT_LEN];

  if (started) return PetscTraceBackErrorHandler(comm, line, function, file, code, type, text, context);
  if (text && strstr(text, "YAML"))
    (void)snprintf(error, sizeof error, "%.200s: not valid YAML, or not names with values",
                   MPMOptionsYaml ? MPMOptionsYaml : "-options_string_yaml");
  else if (text && strstr(text, "max number of options"))
    (void)snprintf(error, sizeof error,
                   "%d options are given, and this PETSc takes %d: a polygon of several loops, an expression or a file "
                   "(-body_<b>_shape) makes one body of many; newer PETSc has no such limit",
                   number, atoi(strstr(text, "max number of options") + strlen("max number of options")));
  else
    (void)snprintf(error, sizeof error, "%s", text ? text : "PETSc does not start");
  Say(error);
  exit(MPM_EXIT_INPUT);
}
