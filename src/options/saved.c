/* saved.c - the options of a run as a text, which output files carry: an options file, a line each. From it a run can
   be repeated, and two runs can be compared. */
#include <petscviewer.h>
#include <strings.h>
#include "options/reader.h"

/* Cuts off what newer versions of PETSc print after a value: "# (source: file)", before that without the #. */
static void CutSource(char line[])
{
#if PETSC_VERSION_GE(3, 19, 0)
  char *source = NULL;

  for (char *s = strstr(line, " (source: "); s; s = strstr(s + 1, " (source: ")) source = s;
  if (!source || line[strlen(line) - 1] != ')') return;
  if (source >= line + 2 && !strncmp(source - 2, " #", 2)) source -= 2;
  *source = 0;
#else
  (void)line; /* these print nothing else */
#endif
}

/* Options that have another value for a while, as in a stage of a run, and what was given: NULL: nothing. */
static struct {
  char *name, *was;
} * over;
static size_t nover;

static PetscBool IsOver(const char name[])
{
  for (size_t k = 0; k < nover; k++)
    if (!strcasecmp(over[k].name, name)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Gives an option, a name with its dash, another value until MPMOptionsOverlayEnd; NULL: it is as if it were not given.
   MPMOptionsText still has what was given. Not collective. */
PetscErrorCode MPMOptionsOverlay(const char name[], const char *value)
{
  char      was[MPM_TEXT_LEN] = "";
  PetscBool given;

  PetscFunctionBeginUser;
  if (!IsOver(name)) {
    PetscCall(PetscOptionsGetString(NULL, NULL, name, was, sizeof was, &given));
    PetscCall(PetscRealloc((nover + 1) * sizeof *over, &over));
    over[nover].name = over[nover].was = NULL;
    PetscCall(PetscStrallocpy(name, &over[nover].name));
    if (given) PetscCall(PetscStrallocpy(was, &over[nover].was));
    nover++;
  }
  if (value)
    PetscCall(PetscOptionsSetValue(NULL, name, value[0] ? value : NULL));
  else
    PetscCall(PetscOptionsClearValue(NULL, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMOptionsOverlayEnd(void)
{
  PetscFunctionBeginUser;
  for (size_t k = 0; k < nover; k++) {
    if (over[k].was)
      PetscCall(PetscOptionsSetValue(NULL, over[k].name, over[k].was[0] ? over[k].was : NULL));
    else
      PetscCall(PetscOptionsClearValue(NULL, over[k].name));
    PetscCall(PetscFree(over[k].name));
    PetscCall(PetscFree(over[k].was));
  }
  PetscCall(PetscFree(over));
  nover = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns all options as given, as the text of an options file; the caller frees it. Paths of files that a scene is
   made from are whole, so that the run can be repeated from any folder. Not collective. */
PetscErrorCode MPMOptionsText(char **text)
{
  char       *view = NULL, *save = NULL, *told = NULL;
  size_t      size = 0, length = 0;
  FILE       *stream, *out;
  PetscViewer viewer;

  PetscFunctionBeginUser;
  stream = open_memstream(&view, &size);
  out    = open_memstream(&told, &length);
  PetscCheck(stream && out, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the text of the options");
  PetscCall(PetscViewerASCIIOpenWithFILE(PETSC_COMM_SELF, stream, &viewer));
  PetscCall(PetscOptionsView(NULL, viewer));
  PetscCall(PetscViewerDestroy(&viewer));
  (void)fclose(stream);
  for (char *line = strtok_r(view, "\n", &save); line; line = strtok_r(NULL, "\n", &save)) {
    char       *blank;
    const char *value, *whole;

    if (line[0] != '-') continue;
    CutSource(line);
    blank = strchr(line, ' ');
    if (blank) *blank = 0;
    value = blank ? blank + 1 : "";
    if (IsOver(line)) continue;
    whole = MPMOptionsWholePath(line + 1, value);
    if (whole) value = whole;
    (void)fprintf(out, strchr(value, ' ') ? "%s \"%s\"\n" : value[0] ? "%s %s\n" : "%s%s\n", line, value);
  }
  for (size_t k = 0; k < nover; k++)
    if (over[k].was)
      (void)fprintf(out,
                    strchr(over[k].was, ' ') ? "%s \"%s\"\n"
                    : over[k].was[0]         ? "%s %s\n"
                                             : "%s%s\n",
                    over[k].name, over[k].was);
  (void)fclose(out);
  free(view);
  PetscCall(PetscStrallocpy(told, text));
  free(told);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets name and value to those of the option at *at in such a text, and moves *at to the next one; returns false at its
   end. A value that is too long is cut off. Not collective. */
PetscBool MPMOptionsNext(const char **at, char name[MPM_NAME_LEN * 4], char value[MPM_TEXT_LEN])
{
  const char *line = *at, *end = line + strcspn(line, "\n"), *from = line + strcspn(line, " \n");

  if (!*line) return PETSC_FALSE;
  *at = *end ? end + 1 : end;
  (void)snprintf(name, MPM_NAME_LEN * 4, "%.*s", (int)(from - line), line);
  if (from < end) from++;
  if (from < end && *from == '"' && end[-1] == '"') {
    from++;
    end--;
  }
  (void)snprintf(value, MPM_TEXT_LEN, "%.*s", (int)PetscMax(0, end - from), from);
  return PETSC_TRUE;
}

/* Finds an option in such a text; returns false if it is not there. Not collective. */
PetscBool MPMOptionsFindIn(const char text[], const char name[], char value[MPM_TEXT_LEN])
{
  char found[MPM_NAME_LEN * 4];

  while (MPMOptionsNext(&text, found, value))
    if (!strcasecmp(found, name)) return PETSC_TRUE;
  value[0] = 0;
  return PETSC_FALSE;
}
