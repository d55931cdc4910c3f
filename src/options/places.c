/* places.c - the lines of options files that gave options their values, so that messages can name them. They are noted
   before PETSc starts (files.c), so nothing here may call PETSc. */
#include <ctype.h>
#include <strings.h>
#include "options/reader.h"

#define BUCKETS 4096

/* A name that a line of a file gives, with its value, and the one before it in its bucket, counted from 1. */
typedef struct {
  char  *name, *value, *path;
  int    line, file; /* the file's number */
  size_t before;
} Given;

static Given *given;
static int    nfiles;
static size_t ngiven, last[BUCKETS]; /* of each bucket the last name, counted from 1; 0: none */

/* Returns the bucket of a name, which is the same for capital letters. */
static size_t Bucket(const char name[])
{
  size_t hash = 5381;

  for (const char *c = name; *c; c++) hash = 33 * hash + (size_t)tolower((unsigned char)*c);
  return hash % BUCKETS;
}

/* Notes that a line of a file gives an option a value. */
static void NotePlace(int file, const char name[], const char value[], const char path[], int line)
{
  Given       *more   = ngiven % 64 ? given : realloc(given, (ngiven + 64) * sizeof *more);
  const size_t bucket = Bucket(name);

  if (!more) return;
  given           = more;
  given[ngiven++] = (Given){strdup(name), strdup(value), strdup(path), line, file, last[bucket]};
  last[bucket]    = ngiven;
}

/* Notes that a line of a file gives an option a value; `name` has no dash. If an earlier line of the same file gives it
   another value, error [len] says so. Not collective. */
void MPMOptionsNote(int file, const char name[], const char value[], const char path[], int line, char error[],
                    size_t len)
{
  const Given *other = NULL;

  for (size_t k = last[Bucket(name)]; k > 0; k = given[k - 1].before)
    if (given[k - 1].file == file && !strcasecmp(given[k - 1].name, name) && strcmp(given[k - 1].value, value))
      other = &given[k - 1];
  if (other)
    (void)snprintf(error, len, "%.1000s:%d: -%.100s%s%.100s contradicts -%.100s%s%.100s of line %d; remove one of them",
                   path, line, name, value[0] ? " " : "", value, other->name, other->value[0] ? " " : "", other->value,
                   other->line);
  NotePlace(file, name, value, path, line);
}

/* Returns a number for a file that is going to be read. Not collective. */
int MPMOptionsNewFile(void)
{
  return ++nfiles;
}

PetscBool MPMOptionsIsFor(const char name[], const char option[])
{
  const size_t n = strlen(name), length = strlen(option);

  if (!strcasecmp(name, option)) return PETSC_TRUE;
  return !strncasecmp(name, "stage_", 6) && n > length && name[n - length - 1] == '_' &&
         !strcasecmp(name + n - length, option);
}

/* Writes "file:line: " of the last line that gives an option this value to place [len], or "" if there is none. Not
   collective. */
void MPMOptionsPlace(const char name[], const char value[], char place[], size_t len)
{
  place[0] = 0;
  for (size_t k = last[Bucket(name)]; k > 0; k = given[k - 1].before) {
    const Given *g = &given[k - 1];

    if (strcasecmp(g->name, name) || strcmp(g->value, value)) continue;
    (void)snprintf(place, len, "%.400s:%d: ", g->path, g->line);
    return;
  }
  for (size_t k = ngiven; k > 0; k--) { /* of a stage */
    const Given *g = &given[k - 1];

    if (strncasecmp(g->name, "stage_", 6) || !MPMOptionsIsFor(g->name, name) || strcmp(g->value, value)) continue;
    (void)snprintf(place, len, "%.400s:%d: ", g->path, g->line);
    return;
  }
}

/* Returns whether a line of a file gives the name; and how many different names all lines give. Not collective. */
PetscBool MPMOptionsIsPlaced(const char name[])
{
  size_t k = last[Bucket(name)];

  while (k && strcasecmp(given[k - 1].name, name)) k = given[k - 1].before;
  return k ? PETSC_TRUE : PETSC_FALSE;
}

int MPMOptionsPlaced(void)
{
  int n = 0;

  for (size_t k = 0; k < ngiven; k++) {
    size_t before = given[k].before;

    while (before && strcasecmp(given[before - 1].name, given[k].name)) before = given[before - 1].before;
    n += !before;
  }
  return n;
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
  memset(last, 0, sizeof last);
}
