/* path.c - option values that are paths of files. */
#include <unistd.h>
#include "options/reader.h"

/* Reads the path of a file that there must be. A path that is not absolute starts at the folder of the options file
   that gives it, if the file is there, or else at the working folder. Results never take the place of such a file. Not
   collective. */
PetscErrorCode MPMOptionsPath(MPMOptions o, const char row[], const char name[], char path[MPM_TEXT_LEN],
                              PetscBool *set)
{
  char  text[MPM_TEXT_LEN] = "", full[MPM_FULL_LEN], place[MPM_TEXT_LEN], *end;
  char *colon;

  PetscFunctionBeginUser;
  path[0] = 0;
  PetscCall(MPMOptionsString(o, row, name, text, set));
  if (!*set || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  MPMOptionsFullName(row, name, full);
  MPMOptionsPlace(full, text, place, sizeof place);
  colon = strrchr(place, ':'); /* of "file:line: " */
  for (end = colon; end && end > place && *end != '/';) end--;
  if (end && *end == '/' && text[0] != '/')
    (void)snprintf(path, MPM_TEXT_LEN, "%.*s%.1000s", (int)(end - place) + 1, place, text);
  if (!path[0] || access(path, R_OK)) (void)snprintf(path, MPM_TEXT_LEN, "%s", text);
  MPMOptionsNoteFile(path);
  PetscFunctionReturn(PETSC_SUCCESS);
}
