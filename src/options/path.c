/* path.c - option values that are paths of files. */
#include <strings.h>
#include <unistd.h>
#include "options/reader.h"

/* The options that are paths, or formulas with paths, and what they are with the whole path, so that a run can be
   repeated from any folder. */
static struct {
  char name[MPM_FULL_LEN], text[MPM_TEXT_LEN], whole[MPM_TEXT_LEN];
} * whole;
static PetscInt nwhole;

PetscErrorCode MPMOptionsNoteWhole(const char name[], const char text[], const char with[])
{
  PetscInt k = 0;

  PetscFunctionBeginUser;
  while (k < nwhole && (strcasecmp(whole[k].name, name) || strcmp(whole[k].text, text))) k++;
  if (k == nwhole) {
    whole = realloc(whole, (size_t)++nwhole * sizeof *whole);
    PetscCheck(whole, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the paths of %" PetscInt_FMT " files", nwhole);
  }
  (void)snprintf(whole[k].name, sizeof whole[k].name, "%s", name);
  (void)snprintf(whole[k].text, sizeof whole[k].text, "%s", text);
  (void)snprintf(whole[k].whole, sizeof whole[k].whole, "%s", with);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMOptionsWholeOf(char path[MPM_TEXT_LEN])
{
  char *full = realpath(path, NULL);

  if (full && strlen(full) < MPM_TEXT_LEN) (void)snprintf(path, MPM_TEXT_LEN, "%s", full);
  free(full);
}

/* Returns the value `text` of the option `name` with whole paths, or NULL if it has none of a file. Not collective. */
const char *MPMOptionsWholePath(const char name[], const char text[])
{
  for (PetscInt k = 0; k < nwhole; k++)
    if (!strcmp(whole[k].text, text) && MPMOptionsIsFor(name, whole[k].name)) return whole[k].whole;
  return NULL;
}

void MPMOptionsPathOf(const char full[], const char value[], const char file[], char path[MPM_TEXT_LEN])
{
  char place[MPM_TEXT_LEN], *end, *colon;

  path[0] = 0;
  MPMOptionsPlace(full, value, place, sizeof place);
  colon = strrchr(place, ':'); /* of "file:line: " */
  for (end = colon; end && end > place && *end != '/';) end--;
  if (end && *end == '/' && file[0] != '/')
    (void)snprintf(path, MPM_TEXT_LEN, "%.*s%.1000s", (int)(end - place) + 1, place, file);
  if (!path[0] || access(path, R_OK)) (void)snprintf(path, MPM_TEXT_LEN, "%s", file);
}

/* Reads the path of a file that there must be. A path that is not absolute starts at the folder of the options file
   that gives it, if the file is there, or else at the working folder. Results never take the place of such a file. Not
   collective. */
PetscErrorCode MPMOptionsPath(MPMOptions o, const char row[], const char name[], char path[MPM_TEXT_LEN],
                              PetscBool *set)
{
  char text[MPM_TEXT_LEN] = "", full[MPM_FULL_LEN], with[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  path[0] = 0;
  PetscCall(MPMOptionsString(o, row, name, text, set));
  if (!*set || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  MPMOptionsFullName(row, name, full);
  MPMOptionsPathOf(full, text, text, path);
  MPMOptionsNoteFile(path);
  (void)snprintf(with, sizeof with, "%s", path);
  MPMOptionsWholeOf(with);
  PetscCall(MPMOptionsNoteWhole(full, text, with));
  PetscFunctionReturn(PETSC_SUCCESS);
}
