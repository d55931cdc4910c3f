/* faults.c - the first fault of the options, which is one line. */
#include <ctype.h>
#include <stdarg.h>
#include "base/fault.h"
#include "options/reader.h"

/* Writes to place [len] the file and line that gave an option its value, "file:line: ", or nothing if no line of a file
   did. error: a message that begins with the option. */
static void FindPlace(const char error[], char place[], size_t len)
{
  char      name[MPM_FULL_LEN + 1], text[MPM_TEXT_LEN] = "";
  PetscBool found;

  (void)snprintf(name, sizeof name, "%.*s", (int)strcspn(error, " :,"), error);
  place[0] = 0;
  if (name[0] != '-' || PetscOptionsGetString(NULL, NULL, name, text, sizeof text, &found) || !found) return;
  MPMOptionsPlace(name + 1, text, place, len);
}

/* Notes an error unless there is one already, as one line, whatever the values in it contain. If it begins with an
   option that a line of a file gave, that line is named first. Not collective. */
void MPMOptionsFail(MPMOptions o, const char format[], ...)
{
  va_list args;
  char    error[MPM_TEXT_LEN], place[MPM_TEXT_LEN / 4];

  if (o->error[0]) return;
  va_start(args, format);
  (void)vsnprintf(error, sizeof error, format, args);
  va_end(args);
  FindPlace(error, place, sizeof place);
  (void)snprintf(o->error, sizeof o->error, "%s%.1500s", place, error);
  for (char *c = o->error; *c; c++)
    if (iscntrl((unsigned char)*c)) *c = '?';
}

/* Returns the first error, or NULL if there is none. Not collective. */
const char *MPMOptionsError(MPMOptions o)
{
  return o->error[0] ? o->error : NULL;
}

/* Gives an error that some processes have noted to all: that of the lowest rank. Collective on comm. */
PetscErrorCode MPMOptionsShare(MPMOptions o, MPI_Comm comm)
{
  PetscFunctionBeginUser;
  PetscCall(MPMFaultAgree(comm, o->error));
  PetscFunctionReturn(PETSC_SUCCESS);
}
