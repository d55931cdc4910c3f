/* join.c - a history that goes on after a restart with other columns, since forces, damping or the method are others:
   the file gets the columns of both parts, and a line has nan where its part had none. */
#include <errno.h>
#include <unistd.h>
#include "results/output.h"

/* Returns the number of a column in a head, a list of names separated by commas, or -1. */
static PetscInt Find(const char head[], const char name[], size_t length)
{
  PetscInt k = 0;

  for (const char *at = head; *at && *at != '\n'; k++) {
    const size_t n = strcspn(at, ",\n");

    if (n == length && !strncmp(at, name, n)) return k;
    at += n + (at[n] == ',');
  }
  return -1;
}

/* Returns the number of columns in a head. */
static PetscInt Count(const char head[])
{
  PetscInt n = 1;

  for (; *head && *head != '\n'; head++) n += *head == ',';
  return n;
}

/* Writes a line of the old history in the sequence of the columns `now`. */
static void Rewrite(FILE *out, const char now[], const char was[], const char line[])
{
  for (const char *at = now; *at && *at != '\n';) {
    const size_t   n     = strcspn(at, ",\n");
    const PetscInt k     = Find(was, at, n);
    const char    *value = line;

    for (PetscInt skip = 0; skip < k; skip++) value += strcspn(value, ",\n") + 1;
    if (at != now) (void)fputc(',', out);
    (void)fprintf(out, "%.*s", k < 0 ? 3 : (int)strcspn(value, ",\n"), k < 0 ? "nan" : value);
    at += n + (at[n] == ',');
  }
  (void)fputc('\n', out);
}

/* Writes the whole history anew; returns 0, or errno. */
static int RewriteAll(const char path[], const char now[], FILE *in, long *length)
{
  char new[2 * MPM_TEXT_LEN + 16], *was = NULL, *line = NULL;
  size_t room = 0, more = 0;
  FILE  *out;
  int    fault;

  (void)snprintf(new, sizeof new, "%s%s", path, MPM_NEW_FILE);
  (void)unlink(new);
  out = fopen(new, "wx");
  if (!out) return errno;
  rewind(in);
  if (getline(&was, &room, in) > 0) (void)fprintf(out, "%s\n", now);
  while (was && getline(&line, &more, in) > 0) Rewrite(out, now, was, line);
  free(was);
  free(line);
  *length = ftell(out);
  fault   = ferror(out) || fflush(out) || fsync(fileno(out)) ? errno ? errno : EIO : 0;
  if (fclose(out) && !fault) fault = errno;
  if (!fault && rename(new, path)) fault = errno;
  if (fault) (void)unlink(new);
  return fault;
}

int MPMHistoryJoin(const char path[], const char head[], char **more, PetscInt *nmore, long *length, PetscBool *other)
{
  FILE  *in  = fopen(path, "r");
  char  *was = NULL, *now = NULL;
  size_t room = 0, size = 0, lengths;
  FILE  *text;
  int    fault;

  if (!in) return errno;
  if (getline(&was, &room, in) < 0) {
    fault = errno ? errno : EIO;
    (void)fclose(in);
    free(was);
    return fault;
  }
  was[strcspn(was, "\n")] = 0;
  text                    = open_memstream(more, &size);
  for (const char *at = was; text && *at;) {
    const size_t n = strcspn(at, ",");

    if (Find(head, at, n) < 0) (void)fprintf(text, ",%.*s", (int)n, at);
    at += n + (at[n] == ',');
  }
  if (text) (void)fclose(text);
  text = open_memstream(&now, &lengths);
  if (text) {
    (void)fprintf(text, "%.*s%s", (int)strcspn(head, "\n"), head, *more);
    (void)fclose(text);
  }
  *nmore = **more ? Count(*more) - 1 : 0;
  *other = strcmp(was, now) ? PETSC_TRUE : PETSC_FALSE;
  fault  = *other ? RewriteAll(path, now, in, length) : 0;
  (void)fclose(in);
  free(was);
  free(now);
  return fault;
}
