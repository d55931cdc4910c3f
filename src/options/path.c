/* path.c - option values that are paths of files. */
#include <strings.h>
#include <unistd.h>
#include "options/reader.h"

/* The options that are paths, with the whole path of each, so that a run can be repeated from any folder. */
static struct {
  char name[MPM_FULL_LEN], path[MPM_TEXT_LEN];
} * whole;
static PetscInt nwhole;

static PetscErrorCode NoteWhole(const char name[], const char path[])
{
  char    *full = realpath(path, NULL);
  PetscInt k    = 0;

  PetscFunctionBeginUser;
  if (!full || strlen(full) >= MPM_TEXT_LEN) {
    free(full);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  while (k < nwhole && strcasecmp(whole[k].name, name)) k++;
  if (k == nwhole) {
    whole = realloc(whole, (size_t)++nwhole * sizeof *whole);
    PetscCheck(whole, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the paths of %" PetscInt_FMT " files", nwhole);
  }
  (void)snprintf(whole[k].name, sizeof whole[k].name, "%s", name);
  (void)snprintf(whole[k].path, sizeof whole[k].path, "%s", full);
  free(full);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the whole path that the option `name` was read as, or NULL if it is none of a file. Not collective. */
const char *MPMOptionsWholePath(const char name[])
{
  for (PetscInt k = 0; k < nwhole; k++)
    if (!strcasecmp(whole[k].name, name)) return whole[k].path;
  return NULL;
}

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
  PetscCall(NoteWhole(full, path));
  PetscFunctionReturn(PETSC_SUCCESS);
}
