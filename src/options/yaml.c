/* yaml.c - goes through a YAML file before PETSc reads it, for names that are given twice with different values, of
   which PETSc would take the last. It knows what scenes are made of: nested names, in lines or in {}, with numbers,
   words and lists. What it does not know it passes over. Nothing here may call PETSc. */
#include <ctype.h>
#include "options/reader.h"

#define DEEPEST 20

/* A file that is read: its text up to `at`, the line there, and the names around what comes next: the indentation of
   their lines, and the length of the prefix before each. */
typedef struct {
  const char *path, *at;
  int         line, depth, number;
  size_t      indent[DEEPEST], length[DEEPEST], len;
  char        prefix[DEEPEST * MPM_NAME_LEN], *error;
} Yaml;

/* Notes the value of a name, without blanks, quotes and brackets, as PETSc will have it. */
static void Note(Yaml *y, const char name[], const char value[], size_t n)
{
  char   full[sizeof y->prefix + MPM_TEXT_LEN], text[MPM_TEXT_LEN];
  size_t m = 0;

  if (n >= sizeof text) return;
  while (n && isspace((unsigned char)value[n - 1])) n--;
  for (size_t k = 0; k < n; k++)
    if (!strchr("'\"[]", value[k]) && !(value[0] == '[' && isspace((unsigned char)value[k]))) text[m++] = value[k];
  text[m] = 0;
  (void)snprintf(full, sizeof full, "%s%s", y->prefix, name);
  MPMOptionsNote(y->number, full, text, y->path, y->line, y->error, y->len);
}

/* Adds a name to the prefix; returns false if that is too long or too deep. */
static PetscBool Enter(Yaml *y, const char name[], size_t indent)
{
  const size_t n = strlen(y->prefix);

  if (y->depth == DEEPEST || n + strlen(name) + 2 > sizeof y->prefix) return PETSC_FALSE;
  y->indent[y->depth]   = indent;
  y->length[y->depth++] = n;
  (void)snprintf(y->prefix + n, sizeof y->prefix - n, "%s_", name);
  return PETSC_TRUE;
}

static void Leave(Yaml *y)
{
  y->prefix[y->length[--y->depth]] = 0;
}

/* Passes over the rest of the line, its end too. */
static void NextLine(Yaml *y)
{
  y->at += strcspn(y->at, "\n");
  if (!*y->at) return;
  y->at++;
  y->line++;
}

/* Passes over blanks, ends of lines and comments. */
static void Skip(Yaml *y)
{
  for (;; y->at++)
    if (*y->at == '\n')
      y->line++;
    else if (*y->at == '#')
      y->at += strcspn(y->at, "\n") - 1;
    else if (!isspace((unsigned char)*y->at))
      return;
}

/* Returns the length of a plain or quoted word at `at`, up to one of `ends`, or to the end of the line. */
static size_t WordLength(const char at[], const char ends[])
{
  size_t n = 0;

  if (*at == '"' || *at == '\'') {
    for (n = 1; at[n] && at[n] != '\n' && at[n] != *at; n++) n += at[n] == '\\' && *at == '"' && at[n + 1];
    return at[n] == *at ? n + 1 : n;
  }
  while (at[n] && at[n] != '\n' && !strchr(ends, at[n]) && !(at[n] == '#' && n && isspace((unsigned char)at[n - 1])))
    n++;
  return n;
}

/* Reads a name and the colon after it; returns false if there is none. */
static PetscBool Name(Yaml *y, const char ends[], char name[MPM_TEXT_LEN])
{
  const PetscBool quoted = *y->at == '"' || *y->at == '\'';
  size_t          n      = WordLength(y->at, ends), m;

  for (m = n; m && y->at[m - 1] == ' ';) m--;
  if (quoted && m < 2) return PETSC_FALSE;
  if (quoted)
    (void)snprintf(name, MPM_TEXT_LEN, "%.*s", (int)PetscMin(m - 2, MPM_TEXT_LEN - 1), y->at + 1);
  else
    (void)snprintf(name, MPM_TEXT_LEN, "%.*s", (int)PetscMin(m, MPM_TEXT_LEN - 1), y->at);
  n += strspn(y->at + n, " ");
  if (!name[0] || y->at[n] != ':') return PETSC_FALSE;
  y->at += n + 1;
  return PETSC_TRUE;
}

/* Reads names and values in {}, or passes over a list in []; `at` is at the bracket, and comes to be behind its
   partner, or at the end of the text. */
static void Flow(Yaml *y)
{
  const PetscBool map   = *y->at == '{' ? PETSC_TRUE : PETSC_FALSE;
  const int       limit = y->depth;

  for (y->at++, Skip(y); *y->at && *y->at != '}' && *y->at != ']' && !y->error[0]; Skip(y)) {
    char            name[MPM_TEXT_LEN];
    const char     *start = y->at;
    const PetscBool named = map ? Name(y, ":,{}[]", name) : PETSC_FALSE;

    Skip(y);
    if (*y->at == '{' && named && Enter(y, name, 0)) {
      Flow(y);
      Leave(y);
    } else if (*y->at == '[' || *y->at == '{') {
      const char *value = y->at;

      if (limit >= DEEPEST - 1) return;
      y->depth++; /* counts the brackets only */
      y->length[limit] = strlen(y->prefix);
      Flow(y);
      y->depth--;
      if (named && *value == '[') Note(y, name, value, (size_t)(y->at - value));
    } else {
      const size_t n = WordLength(y->at, ",{}[]");

      if (named) Note(y, name, y->at, n);
      y->at += n;
    }
    Skip(y);
    if (*y->at == ',' || *y->at == ':' || y->at == start) y->at += *y->at != 0;
  }
  if (*y->at) y->at++;
}

/* Reads a line of names that are nested by indentation. Lines that are indented by more than *over belong to what is
   passed over; SIZE_MAX: none are. */
static void Line(Yaml *y, size_t *over)
{
  const size_t indent = strspn(y->at, " ");
  char         name[MPM_TEXT_LEN];
  size_t       n;

  y->at += indent;
  if (!*y->at || strchr("\r\n#%", *y->at) || !strncmp(y->at, "---", 3) || indent > *over) return;
  *over = SIZE_MAX;
  while (y->depth && y->indent[y->depth - 1] >= indent) Leave(y);
  if (*y->at == '{' || *y->at == '[') {
    Flow(y);
    return;
  }
  if ((*y->at == '-' && isspace((unsigned char)y->at[1])) || !Name(y, ":\n", name)) {
    *over = indent;
    return;
  }
  y->at += strspn(y->at, " \t\r");
  n = WordLength(y->at, "");
  if (*y->at == '{') {
    if (Enter(y, name, indent)) Flow(y);
  } else if (*y->at == '[') {
    const char *value = y->at;

    Flow(y);
    Note(y, name, value, (size_t)(y->at - value));
  } else if (!n || *y->at == '#') {
    if (!Enter(y, name, indent)) *over = indent;
  } else if (strchr("|>&*!", *y->at))
    *over = indent;
  else
    Note(y, name, y->at, n);
}

/* Checks the text of a YAML file. error [len] gets a contradiction, or stays as it is. */
void MPMOptionsCheckYaml(const char path[], const char text[], char error[], size_t len)
{
  Yaml  *y    = calloc(1, sizeof *y);
  size_t over = SIZE_MAX;

  if (!y) return;
  y->path   = path;
  y->at     = text;
  y->line   = 1;
  y->number = MPMOptionsNewFile();
  y->error  = error;
  y->len    = len;
  while (*y->at && !error[0]) {
    Line(y, &over);
    NextLine(y);
  }
  free(y);
}
