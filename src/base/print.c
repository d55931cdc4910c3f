/* print.c - the functions that print; print.h describes them. */
#include <stdarg.h>
#include "base/print.h"

PetscErrorCode MPMPrint(const MPMPrinter *printer, const char format[], ...)
{
  PetscMPIInt rank;
  va_list     args;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(printer->comm, &rank));
  va_start(args, format);
  if (!rank && !printer->quiet && !(printer->said && printer->said->about)) (void)vprintf(format, args);
  va_end(args);
  (void)fflush(stdout);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a line to those that were said. Returns whether it is to be printed. */
static PetscErrorCode Keep(MPMSaid *said, const char label[], const char line[], PetscBool *print)
{
  const size_t length = strlen(line);

  PetscFunctionBeginUser;
  *print = !said->about ||
           ((!strcmp(label, "note") || !strcmp(label, "warning")) && !(said->lines && strstr(said->lines, line)));
  if (!*print) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscRealloc(said->n + length + 2, &said->lines));
  (void)snprintf(said->lines + said->n, length + 2, "%s\n", line);
  said->n += length + 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMPrintEndOf(const MPMPrinter *printer, char line[], size_t length)
{
  static const char option[] = "-time_end";
  const size_t      n = strlen(option), by = printer->end ? strlen(printer->end) : 0;

  for (char *at = strstr(line, option); at && by; at = strstr(at + by, option)) {
    if (strlen(line) + by - n >= length) return;
    memmove(at + by, at + n, strlen(at + n) + 1);
    memcpy(at, printer->end, by);
  }
}

PetscErrorCode MPMSay(const MPMPrinter *printer, const char label[], const char format[], ...)
{
  PetscMPIInt rank;
  PetscBool   print = PETSC_TRUE;
  char        line[2 * MPM_TEXT_LEN];
  va_list     args;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(printer->comm, &rank));
  if (rank || printer->quiet) PetscFunctionReturn(PETSC_SUCCESS);
  va_start(args, format);
  (void)vsnprintf(line, sizeof line, format, args);
  va_end(args);
  MPMPrintEndOf(printer, line, sizeof line);
  if (printer->said) PetscCall(Keep(printer->said, label, line, &print));
  if (!print) PetscFunctionReturn(PETSC_SUCCESS);
  (void)printf("%s%-10s ", printer->progress ? "\r\033[K" : "", label);
  (void)printf("%s%s%s\n", printer->said && printer->said->about ? printer->said->about : "",
               printer->said && printer->said->about ? ": " : "", line);
  (void)fflush(stdout);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMTimeWords(PetscReal seconds, char words[MPM_NAME_LEN])
{
  static const struct {
    PetscReal   s, most; /* the unit; up to which time it is taken */
    const char *name;
  } units[]         = {{1, 90, "second"},
                       {60, 90 * 60., "minute"},
                       {3600, 48 * 3600., "hour"},
                       {86400, 730 * 86400., "day"},
                       {3.156e7, PETSC_MAX_REAL, "year"}};
  const size_t last = sizeof units / sizeof units[0] - 1;
  char         digits[MPM_NAME_LEN];
  size_t       k = 0;

  while (k < last && seconds >= units[k].most) k++;
  (void)snprintf(digits, sizeof digits, "%.2g", (double)(seconds / units[k].s));
  (void)snprintf(words, MPM_NAME_LEN, "%g %s%s", strtod(digits, NULL), units[k].name,
                 strtod(digits, NULL) == 1 ? "" : "s");
}

void MPMPlaceWords(PetscInt dim, const PetscReal x[], char words[MPM_NAME_LEN])
{
  size_t n = 0;

  for (PetscInt d = 0; d < dim; d++)
    n += (size_t)snprintf(words + n, MPM_NAME_LEN - n, "%s%g", d ? ", " : "(", (double)x[d]);
  (void)snprintf(words + n, MPM_NAME_LEN - n, ")");
}
