/* study_table.c - the table of a work-precision study: <name>_workprecision.csv, from which a study that was interrupted
   goes on. */
#include <unistd.h>
#include <errno.h>
#include <stddef.h>
#include "run/study_work.h"

/* The columns: a text, which has no commas, or a number with its format. */
#define TEXT(name)                                                                                                     \
  {                                                                                                                    \
#name, NULL, offsetof(MPMWorkRow, name), sizeof((MPMWorkRow *)0)->name                                             \
  }
#define NUMBER(name, format)                                                                                           \
  {                                                                                                                    \
#name, format, offsetof(MPMWorkRow, name), 0                                                                       \
  }
static const struct {
  const char *name, *format;
  size_t      offset, size;
} columns[] = {
    TEXT(study),
    TEXT(basis),
    TEXT(gimp_update),
    TEXT(update),
    TEXT(transfer),
    NUMBER(flip, "%.10g"),
    NUMBER(order, "%.0f"),
    NUMBER(strain, "%.10g"),
    NUMBER(rate, "%.10g"),
    NUMBER(ppc, "%.0f"),
    TEXT(cells),
    NUMBER(cfl, "%.10g"),
    NUMBER(h, "%.17g"),
    NUMBER(particles, "%.0f"),
    NUMBER(steps, "%.0f"),
    NUMBER(seconds, "%.6g"),
    {"seconds_min", "%.6g", offsetof(MPMWorkRow, least), 0},
    {"seconds_max", "%.6g", offsetof(MPMWorkRow, most), 0},
    NUMBER(ns, "%.5g"),
    NUMBER(memory, "%.6g"),
    NUMBER(error, "%.17g"),
    TEXT(status),
    NUMBER(front, "%.0f"),
    NUMBER(repeats, "%.0f"),
    TEXT(key),
    TEXT(note),
};
#define NCOLUMNS (sizeof columns / sizeof columns[0])

/* Makes a row at the end of the table; rows that were made before may move. */
PetscErrorCode MPMWorkAdd(MPMWorkTable *t, MPMWorkRow **row)
{
  PetscFunctionBeginUser;
  if (t->n == t->capacity) {
    t->capacity = 2 * t->capacity + 64;
    PetscCall(PetscRealloc((size_t)t->capacity * sizeof *t->row, &t->row));
  }
  *row = &t->row[t->n++];
  PetscCall(PetscMemzero(*row, sizeof **row));
  for (size_t k = 0; k < NCOLUMNS; k++)
    if (columns[k].format) *(double *)((char *)*row + columns[k].offset) = NAN;
  (*row)->front = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMWorkDestroy(MPMWorkTable *t)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(t->row));
  PetscCall(PetscFree(t->setting));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets what a result says of its run, but for error and times. */
void MPMWorkPut(MPMWorkRow *row, const MPMStudyResult *r)
{
  const MPMTransfer *transfer = &MPMTransfers[r->transfer];

  (void)snprintf(row->basis, sizeof row->basis, "%s", MPMBasisNames[r->basis]);
  row->gimp_update[0] = 0;
  if (r->basis == MPM_BASIS_gimp)
    (void)snprintf(row->gimp_update, sizeof row->gimp_update, "%s", r->stretched ? "stretch" : "none");
  (void)snprintf(row->update, sizeof row->update, "%s", MPMSchemes[r->scheme].name);
  (void)snprintf(row->transfer, sizeof row->transfer, "%s", transfer->name);
  (void)snprintf(row->cells, sizeof row->cells, "%" PetscInt_FMT, r->cells[0]);
  for (PetscInt d = 1; d < r->dim; d++)
    (void)snprintf(row->cells + strlen(row->cells), sizeof row->cells - strlen(row->cells), "x%" PetscInt_FMT,
                   r->cells[d]);
  row->flip      = transfer->flip < 0 ? (double)r->flip : NAN;
  row->strain    = transfer->flip < 0 && transfer->parts & MPM_AFFINE ? (double)r->strain : NAN;
  row->rate      = r->rate > 0 ? (double)r->rate : NAN;
  row->order     = transfer->rounds != MPM_NO_ROUNDS ? (double)r->order : NAN;
  row->ppc       = (double)r->ppc;
  row->cfl       = r->fixed > 0 ? NAN : (double)r->cfl;
  row->h         = (double)r->h;
  row->particles = (double)r->particles;
  row->steps     = (double)r->steps;
  row->memory    = (double)r->memory / 1048576;
  (void)snprintf(row->status, sizeof row->status, "%s", r->stop[0] ? "stopped" : "ok");
  (void)snprintf(row->note, sizeof row->note, "%.*s", (int)sizeof row->note - 1, r->stop);
  if (!r->stop[0] && r->fixed <= 0 && r->cfl > r->stable.crossing * (1 + 1e-9))
    (void)snprintf(row->note, sizeof row->note, "steps too long where particles cross cells: stable up to %g h/c",
                   (double)r->stable.crossing);
  for (char *c = row->note; *c; c++)
    if (*c == ',' || *c == '"' || *c == '\n') *c = ';';
}

/* Reads a line of the file into a row; returns whether it has all columns. */
static PetscBool ReadRow(MPMWorkRow *row, char *line)
{
  line[strcspn(line, "\r\n")] = 0;
  for (size_t k = 0; k < NCOLUMNS; k++) {
    char *comma = strchr(line, ','), *end;

    if (!comma != (k == NCOLUMNS - 1)) return PETSC_FALSE;
    if (comma) *comma = 0;
    if (columns[k].format) {
      *(double *)((char *)row + columns[k].offset) = line[0] ? strtod(line, &end) : NAN;
      if (line[0] && *end) return PETSC_FALSE;
    } else
      (void)snprintf((char *)row + columns[k].offset, columns[k].size, "%s", line);
    if (comma) line = comma + 1;
  }
  return PETSC_TRUE;
}

/* Takes the rows of the file, if there is one. If it is not such a table, fault says so. */
PetscErrorCode MPMWorkRead(MPMWorkTable *t, char fault[MPM_TEXT_LEN])
{
  FILE       *file = fopen(t->path, "r");
  char        line[2 * MPM_TEXT_LEN];
  MPMWorkRow *row;

  PetscFunctionBeginUser;
  fault[0] = 0;
  if (!file && errno != ENOENT)
    (void)snprintf(fault, MPM_TEXT_LEN, "cannot read %.1024s: %s", t->path, strerror(errno));
  if (!file) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt number = 1; fgets(line, sizeof line, file) && !fault[0]; number++) {
    PetscBool good;

    PetscCall(MPMWorkAdd(t, &row));
    good = ReadRow(row, line) || number == 1 ? PETSC_TRUE : PETSC_FALSE;
    if (number == 1) t->n--; /* the names of the columns */
    if (!good || (number == 1 && strncmp(line, columns[0].name, strlen(columns[0].name))))
      (void)snprintf(fault, MPM_TEXT_LEN,
                     "line %" PetscInt_FMT " of %.1024s is not of a work-precision study; move the file away", number,
                     t->path);
  }
  (void)fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the file, under another name first, so that it is whole whenever the program ends; fault says why it cannot, or
   is empty. */
PetscErrorCode MPMWorkWrite(const MPMWorkTable *t, char fault[MPM_TEXT_LEN])
{
  char      path[2 * MPM_TEXT_LEN + 16];
  PetscBool bad;
  FILE     *file;

  PetscFunctionBeginUser;
  (void)snprintf(path, sizeof path, "%s" MPM_NEW_FILE, t->path);
  (void)unlink(path); /* one that an earlier run left; a link is not followed */
  fault[0] = 0;
  file     = fopen(path, "wx");
  if (!file) {
    (void)snprintf(fault, MPM_TEXT_LEN, "cannot write %.1500s: %s", t->path, strerror(errno));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (size_t k = 0; k < NCOLUMNS; k++) fprintf(file, "%s%s", k ? "," : "", columns[k].name);
  fprintf(file, "\n");
  for (PetscInt n = 0; n < t->n; n++) {
    if (!t->row[n].status[0]) continue; /* not run yet */
    for (size_t k = 0; k < NCOLUMNS; k++) {
      const char  *at     = (const char *)&t->row[n] + columns[k].offset;
      const double number = columns[k].format ? *(const double *)at : 0;

      if (k) fprintf(file, ",");
      if (!columns[k].format)
        fprintf(file, "%s", at);
      else if (number == number)
        fprintf(file, columns[k].format, number);
    }
    fprintf(file, "\n");
  }
  bad = fflush(file) || ferror(file) ? PETSC_TRUE : PETSC_FALSE;
  if (fclose(file)) bad = PETSC_TRUE;
  if (bad || rename(path, t->path)) {
    (void)snprintf(fault, MPM_TEXT_LEN, "cannot write %.1500s: %s", t->path, strerror(errno));
    (void)unlink(path);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
