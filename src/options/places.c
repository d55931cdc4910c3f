/* places.c - the lines of options files that gave options their values, so that messages can name them. They are noted
   before PETSc starts (files.c), so nothing here may call PETSc. */
#include <strings.h>
#include "options/reader.h"

/* A name that a line of a file gives, with its value. */
typedef struct {
  char *name, *value, *path;
  int   line;
} Given;

static Given *given;
static size_t ngiven;

/* Notes that a line of a file gives an option a value. `name` has no dash. Not collective. */
void MPMOptionsNotePlace(const char name[], const char value[], const char path[], int line)
{
  Given *more = ngiven % 64 ? given : realloc(given, (ngiven + 64) * sizeof *more);

  if (!more) return;
  given           = more;
  given[ngiven++] = (Given){strdup(name), strdup(value), strdup(path), line};
}

/* Returns the line of a file that gives an option of this name another value, among those noted from number `first` on,
   or 0. *text is its value, *old its name in the letters of that line. Not collective. */
int MPMOptionsContradicts(size_t first, const char name[], const char value[], const char **old, const char **text)
{
  for (size_t k = first; k < ngiven; k++) {
    if (strcasecmp(given[k].name, name) || !strcmp(given[k].value, value)) continue;
    *old  = given[k].name;
    *text = given[k].value;
    return given[k].line;
  }
  return 0;
}

/* Returns how many names were noted so far. Not collective. */
size_t MPMOptionsPlaces(void)
{
  return ngiven;
}

/* Writes "file:line: " of the last line that gives an option this value to place [len], or "" if there is none. Not
   collective. */
void MPMOptionsPlace(const char name[], const char value[], char place[], size_t len)
{
  place[0] = 0;
  for (size_t k = ngiven; k-- > 0;)
    if (!strcasecmp(given[k].name, name) && !strcmp(given[k].value, value)) {
      (void)snprintf(place, len, "%.400s:%d: ", given[k].path, given[k].line);
      return;
    }
}

/* Forgets all places. Not collective. */
void MPMOptionsForgetPlaces(void)
{
  for (size_t k = 0; k < ngiven; k++) {
    free(given[k].name);
    free(given[k].value);
    free(given[k].path);
  }
  free(given);
  given  = NULL;
  ngiven = 0;
}
