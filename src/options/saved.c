/* saved.c - the options of a run as a text, which output files carry: an options file, a line each. From it a run can be
   repeated, and two runs can be compared. */
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

/* Returns all options as given, as the text of an options file; the caller frees it. Not collective. */
PetscErrorCode MPMOptionsText(char **text)
{
  char       *view = NULL, *save = NULL;
  size_t      size = 0, n = 1;
  FILE       *stream;
  PetscViewer viewer;

  PetscFunctionBeginUser;
  stream = open_memstream(&view, &size);
  PetscCheck(stream, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the text of the options");
  PetscCall(PetscViewerASCIIOpenWithFILE(PETSC_COMM_SELF, stream, &viewer));
  PetscCall(PetscOptionsView(NULL, viewer));
  PetscCall(PetscViewerDestroy(&viewer));
  (void)fclose(stream);
  PetscCall(PetscMalloc1(2 * size + 1, text)); /* quotes take two characters a line */
  (*text)[0] = 0;
  for (char *line = strtok_r(view, "\n", &save); line; line = strtok_r(NULL, "\n", &save)) {
    char *value;

    if (line[0] != '-') continue;
    CutSource(line);
    value = strchr(line, ' ');
    n += (size_t)snprintf(
        *text + n - 1, 2 * size + 2 - n, value && strchr(value + 1, ' ') ? "%.*s \"%s\"\n" : "%.*s%s%s\n",
        (int)(value ? value - line : (long)strlen(line)), line,
        value && strchr(value + 1, ' ') ? value + 1 : (value && value[1] ? " " : ""), value ? value + 1 : "");
  }
  free(view);
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
