/* time_tables.c - tables over time in formulas: table(file.csv) is the value at the time t of a CSV file with two
   columns, t and value. Between two lines it is linear, before the first and after the last it is the value there.
   Every process reads the file. */
#include <errno.h>
#include "options/time_tables.h"

#define WORD "table("

/* Reads a line "t,value" of a table; returns what is wrong, or NULL. */
static const char *ReadLine(const char line[], PetscReal *t, PetscReal *value)
{
  char *end;

  *t = strtod(line, &end);
  if (end == line) return "is not t,value, two numbers";
  end += strspn(end, " \t");
  if (*end != ',') return strchr(line, ';') ? "has a ; where a comma should be" : "is not t,value, two numbers";
  line   = end + 1;
  *value = strtod(line, &end);
  if (end == line) return "has no value after its comma";
  if (end[strspn(end, " \t\r\n")]) return "has more than two numbers";
  if (!(PetscAbsReal(*t) + PetscAbsReal(*value) <= PETSC_MAX_REAL)) return "is not finite";
  return NULL;
}

/* Reads a file; error [len] gets what is wrong, or "". */
static PetscErrorCode Read(const char path[], MPMTable *table, char error[], size_t len)
{
  FILE       *file = fopen(path, "r");
  char       *line = NULL;
  const char *wrong;
  size_t      size   = 0;
  PetscInt    number = 0;
  PetscReal   t, value;

  PetscFunctionBeginUser;
  if (!file) {
    (void)snprintf(error, len, "cannot read %.500s: %s", path, strerror(errno));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  while (!error[0] && getline(&line, &size, file) >= 0) {
    const char *from = line + strspn(line, " \t\r\n\"");

    number++;
    if (!*from || *from == '#') continue;
    wrong = ReadLine(from, &t, &value);
    if (wrong && !table->n && number == 1 && strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ", *from))
      continue; /* a heading */
    if (!wrong && table->n && !(t > table->t[table->n - 1])) wrong = "is not later than the one before";
    if (wrong) {
      (void)snprintf(error, len, "%.500s:%" PetscInt_FMT ": the line %s", path, number, wrong);
      break;
    }
    if (table->n % 64 == 0) {
      PetscCall(PetscRealloc((size_t)(table->n + 64) * sizeof *table->t, &table->t));
      PetscCall(PetscRealloc((size_t)(table->n + 64) * sizeof *table->value, &table->value));
    }
    table->t[table->n]       = t;
    table->value[table->n++] = value;
  }
  if (!error[0] && ferror(file)) (void)snprintf(error, len, "cannot read %.500s: %s", path, strerror(errno));
  if (!error[0] && !table->n) (void)snprintf(error, len, "%.500s has no line t,value", path);
  free(line);
  (void)fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTablesRead(const char full[], const char text[], char plain[MPM_TEXT_LEN], PetscInt *n,
                             MPMTable **tables, char error[], size_t len)
{
  char        whole[MPM_TEXT_LEN] = "";
  const char *at                  = text, *word;

  PetscFunctionBeginUser;
  plain[0] = 0;
  error[0] = 0;
  *n       = 0;
  *tables  = NULL;
  while (!error[0] && (word = strstr(at, WORD))) {
    const char  *name = word + strlen(WORD), *end = name + strcspn(name, ")");
    const size_t used = strlen(plain), have = strlen(whole);
    char         path[MPM_TEXT_LEN], file[MPM_TEXT_LEN];

    while (name < end && *name == ' ') name++;
    (void)snprintf(file, sizeof file, "%.*s", (int)(end - name), name);
    while (file[0] && file[strlen(file) - 1] == ' ') file[strlen(file) - 1] = 0;
    if (!*end || !file[0]) {
      (void)snprintf(error, len, "write table(file.csv), with the name of a file");
      break;
    }
    MPMOptionsPathOf(full, text, file, path);
    MPMOptionsNoteFile(path);
    PetscCall(PetscRealloc((size_t)(*n + 1) * sizeof **tables, tables));
    (*tables)[*n] = (MPMTable){0};
    PetscCall(Read(path, &(*tables)[*n], error, len));
    (void)snprintf(plain + used, MPM_TEXT_LEN - used, "%.*s_table%" PetscInt_FMT, (int)(word - at), at, *n);
    MPMOptionsWholeOf(path);
    (void)snprintf(whole + have, MPM_TEXT_LEN - have, "%.*s" WORD "%.1500s)", (int)(word - at), at, path);
    ++*n;
    at = end + 1;
  }
  MPMAppend(plain, MPM_TEXT_LEN, "%s", at);
  MPMAppend(whole, MPM_TEXT_LEN, "%s", at);
  if (*n && !error[0]) PetscCall(MPMOptionsNoteWhole(full, text, whole));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MPMTableValue(const MPMTable *table, PetscReal t)
{
  PetscInt low = 0, high = table->n - 1;

  if (t <= table->t[0]) return table->value[0];
  if (t >= table->t[high]) return table->value[high];
  while (high - low > 1) {
    const PetscInt middle = (low + high) / 2;

    if (t < table->t[middle])
      high = middle;
    else
      low = middle;
  }
  return table->value[low] +
         (table->value[high] - table->value[low]) * ((t - table->t[low]) / (table->t[high] - table->t[low]));
}

PetscErrorCode MPMTablesDestroy(PetscInt n, MPMTable **tables)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < n; k++) {
    PetscCall(PetscFree((*tables)[k].t));
    PetscCall(PetscFree((*tables)[k].value));
  }
  PetscCall(PetscFree(*tables));
  PetscFunctionReturn(PETSC_SUCCESS);
}
