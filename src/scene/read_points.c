/* read_points.c - reads particles from CSV files. The first line names the columns: x y z, and if one likes vx vy vz,
   Fxx Fxy ... Fzz, volume, material, in any sequence. Each process reads the lines that begin in its part of the bytes,
   or its part of the rows of an HDF5 file. */
#include <errno.h>
#include <stdlib.h>
#include <strings.h>
#include <sys/stat.h>
#include "base/checksum.h"
#include "base/fault.h"
#include "scene/points.h"
#include "scene/shapes.h"

#define SEPARATORS ", ;\t\r\n\"" /* some programs put words, or all values, in quotes */

/* Returns whether a line has values: it is neither empty nor a comment. */
static PetscBool HasValues(const char line[])
{
  const char first = line[strspn(line, SEPARATORS)];

  return first && first != '#';
}

/* Says in why [len] what keeps a line of n bytes from being read as text, if anything does. */
static void CheckText(const char line[], size_t n, char why[], size_t len)
{
  const char *lone = strchr(line, '\r');

  if (strlen(line) != n)
    (void)snprintf(why, len, "it is no text");
  else if (lone && lone[1] && lone[1] != '\n')
    (void)snprintf(why, len, "lines end with CR alone; save it with lines that end with LF");
}

/* --- The heading -------------------------------------------------------------------------------------------------- */

/* Sets a column by its name; *at is its number among those of a particle. Returns false if there is no such column. */
static PetscBool FindColumn(PetscInt dim, const char word[], PetscInt *at)
{
  static const char axes[] = "xyz";
  const char *const one = strchr(axes, word[0]), *const last = strchr(axes, word[strlen(word) - 1]),
                    *const mid = strlen(word) == 3 ? strchr(axes, word[1]) : NULL;

  if (!strcasecmp(word, "material"))
    *at = -1;
  else if (!strcasecmp(word, "volume"))
    *at = 2 * dim + dim * dim;
  else if (strlen(word) == 1 && one && one - axes < dim)
    *at = (PetscInt)(one - axes);
  else if (strlen(word) == 2 && word[0] == 'v' && last && last - axes < dim)
    *at = dim + (PetscInt)(last - axes);
  else if (word[0] == 'F' && mid && last && mid - axes < dim && last - axes < dim)
    *at = 2 * dim + (PetscInt)(mid - axes) * dim + (PetscInt)(last - axes);
  else
    return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Returns how many of the n numbers from `first` on have a column. */
static PetscInt Have(const MPMPoints *p, PetscInt first, PetscInt n)
{
  PetscInt have = 0;

  for (PetscInt c = 0; c < p->ncolumns; c++) have += p->column[c] >= first && p->column[c] < first + n;
  return have;
}

/* Reads the names of the columns. */
static void ReadHeading(MPMOptions o, MPMPoints *p, char line[])
{
  const PetscInt dim = p->dim, most = 2 * dim + dim * dim + 2;
  char          *save = NULL;

  for (char *w = strtok_r(line, SEPARATORS, &save); w && !MPMOptionsError(o); w = strtok_r(NULL, SEPARATORS, &save)) {
    PetscInt at = 0;

    if (!FindColumn(dim, w, &at))
      MPMOptionsFail(o,
                     "%.600s:%" PetscInt64_FMT
                     ": '%.40s' is no column: there are x, vx, Fxx and so on for %" PetscInt_FMT "-D, volume, material",
                     p->what, p->lines, w, dim);
    for (PetscInt c = 0; c < p->ncolumns; c++)
      if (p->column[c] == at)
        MPMOptionsFail(o, "%.600s:%" PetscInt64_FMT ": column %.40s is there twice", p->what, p->lines, w);
    if (p->ncolumns < most && !MPMOptionsError(o)) p->column[p->ncolumns++] = at;
  }
  p->velocity    = Have(p, dim, dim) ? PETSC_TRUE : PETSC_FALSE;
  p->deformation = Have(p, 2 * dim, dim * dim) ? PETSC_TRUE : PETSC_FALSE;
  p->volume      = Have(p, 2 * dim + dim * dim, 1) ? PETSC_TRUE : PETSC_FALSE;
  p->material    = Have(p, -1, 1) ? PETSC_TRUE : PETSC_FALSE;
  if (Have(p, 0, dim) != dim || (p->velocity && Have(p, dim, dim) != dim) ||
      (p->deformation && Have(p, 2 * dim, dim * dim) != dim * dim))
    MPMOptionsFail(o,
                   "%.600s:%" PetscInt64_FMT
                   ": the first line names the columns; x is needed, and of x, v and F all components "
                   "that -dim %" PetscInt_FMT " has",
                   p->what, p->lines, dim);
}

/* Computes the checksum of the file, of which each process reads a part; a restart compares it. */
static PetscErrorCode Checksum(const MPMCore *core, MPMPoints *p)
{
  const PetscInt64 words = p->size / 8;
  PetscMPIInt      rank, size;
  uint64_t         sum  = 0;
  FILE            *file = fopen(p->path, "r");

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  if (file)
    (void)MPMChecksumFile(fileno(file), (size_t)(8 * (words * rank / size)),
                          (size_t)(rank == size - 1 ? p->size : 8 * (words * (rank + 1) / size)), &sum);
  if (file) (void)fclose(file);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, core->comm));
  p->sum = (PetscInt64)sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsOpen(MPMCore *core, MPMOptions o, MPMBody *b)
{
  MPMPoints  *p;
  char       *line = NULL, fault[MPM_TEXT_LEN] = "";
  size_t      room = 0;
  PetscBool   set;
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&p));
  b->points = p;
  p->dim    = core->grid.dim;
  PetscCall(MPMOptionsPath(o, "body_<b>_file", b->name, p->path, &set));
  if (!set) MPMOptionsFail(o, "-body_%s_file is required (a CSV file of particles)", b->name);
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(p->what, sizeof p->what, "-body_%s_file %.500s", b->name, p->path);
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  if (!rank) {
    FILE       *file = fopen(p->path, "r");
    struct stat status;

    if (!file || fstat(fileno(file), &status))
      MPMFault(fault, "cannot read", p->path, strerror(errno));
    else if (!S_ISREG(status.st_mode))
      MPMFault(fault, "cannot read", p->path, "it is not a file");
    if (fault[0]) MPMOptionsFail(o, "-body_%s_file: %s", b->name, fault);
    if (!fault[0]) {
      char        first[8] = "", why[MPM_TEXT_LEN / 4] = "";
      const char *encoding;
      size_t      mark, bytes;
      ssize_t     n;

      p->size = (PetscInt64)status.st_size;
      bytes   = fread(first, 1, sizeof first, file);
      if (bytes == sizeof first && !memcmp(first, "\211HDF\r\n\032\n", sizeof first))
        PetscCall(MPMPointsOpenHDF5(o, p));
      encoding = p->hdf5 ? NULL : MPMSceneTextFault(first, bytes, &mark);
      if (encoding) MPMOptionsFail(o, "%.600s %s", p->what, encoding);
      p->begin = p->hdf5 ? 0 : (PetscInt64)mark;
      (void)fseek(file, (long)p->begin, SEEK_SET);
      while (!p->hdf5 && !encoding && !why[0] && (n = getline(&line, &room, file)) > 0) {
        p->begin += n;
        p->lines++;
        CheckText(line, (size_t)n, why, sizeof why);
        if (HasValues(line)) break;
      }
      if (why[0])
        MPMOptionsFail(o, "%.600s:%" PetscInt64_FMT ": %s", p->what, p->lines, why);
      else if (p->lines > 0)
        ReadHeading(o, p, line);
      else if (!p->hdf5 && !encoding)
        MPMOptionsFail(o, "%.600s: it has no particles", p->what);
    }
    if (file) (void)fclose(file);
    free(line);
  }
  PetscCall(MPMOptionsShare(o, core->comm));
  PetscCallMPI(MPI_Bcast(p, sizeof *p, MPI_BYTE, 0, core->comm));
  if (!MPMOptionsError(o)) PetscCall(Checksum(core, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsDestroy(MPMPoints **p)
{
  PetscFunctionBeginUser;
  if (!*p) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*p)->kind));
  PetscCall(PetscFree((*p)->sort));
  PetscCall(PetscFree(*p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Particles ---------------------------------------------------------------------------------------------------- */

/* Adds a row with its defaults: at rest, undeformed, of the body's material, a particle of the lattice. */
static PetscErrorCode AddRow(const MPMBody *b, MPMPointRows *rows)
{
  const PetscInt dim = b->points->dim;
  PetscReal     *number;

  PetscFunctionBeginUser;
  if (rows->n == rows->room) {
    rows->room = 2 * rows->room + 1024;
    PetscCall(PetscRealloc((size_t)(rows->room * rows->stride) * sizeof *rows->number, &rows->number));
    PetscCall(PetscRealloc((size_t)rows->room * sizeof *rows->material, &rows->material));
  }
  number = rows->number + rows->n * rows->stride;
  for (PetscInt k = 0; k < rows->stride; k++) number[k] = 0;
  for (PetscInt d = 0; d < dim; d++) number[2 * dim + d * (dim + 1)] = 1;
  number[rows->stride - 1] = 1;
  for (PetscInt d = 0; d < dim; d++) number[rows->stride - 1] *= b->b[d];
  rows->material[rows->n++] = b->material;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says in why [len] what is wrong with row k, if anything is. */
static void CheckRow(const MPMScene *scene, PetscInt dim, const MPMPointRows *rows, PetscInt k, char why[], size_t len)
{
  const PetscReal *number = rows->number + k * rows->stride, volume = number[rows->stride - 1],
                  J = MPMDet((int)dim, number + 2 * dim);
  PetscReal V[3]    = {1, 1, 1};

  for (PetscInt q = 0; q < rows->stride && !why[0]; q++)
    if (!(PetscAbsReal(number[q]) <= PETSC_MAX_REAL)) (void)snprintf(why, len, "a value is not finite");
  if (!why[0] && (rows->material[k] < 0 || rows->material[k] >= scene->nmaterials))
    (void)snprintf(why, len, "its material is none of the %" PetscInt_FMT " of -materials", scene->nmaterials);
  if (!why[0] && !(volume > 0)) (void)snprintf(why, len, "volume %g is not above 0", (double)volume);
  if (!why[0] && !(J > 0)) (void)snprintf(why, len, "det F = %g is not above 0", (double)J);
  if (!why[0]) MPMStretch((int)dim, number + 2 * dim, V);
  for (PetscInt d = 0; d < dim && !why[0]; d++)
    if (!(V[d] > 0 && V[d] < PETSC_MAX_REAL)) (void)snprintf(why, len, "F is too far from 1");
}

/* Reads a line into a new row. why [len] gets what is wrong with it, or stays. */
static PetscErrorCode ReadLine(const MPMScene *scene, const MPMBody *b, char line[], MPMPointRows *rows, char why[],
                               size_t len)
{
  const MPMPoints *p = b->points;
  PetscReal       *number;
  PetscInt         c    = 0, *material;
  char            *save = NULL;

  PetscFunctionBeginUser;
  PetscCall(AddRow(b, rows));
  number   = rows->number + (rows->n - 1) * rows->stride;
  material = rows->material + rows->n - 1;
  for (char *w = strtok_r(line, SEPARATORS, &save); w && !why[0]; w = strtok_r(NULL, SEPARATORS, &save), c++) {
    char *end;

    if (c >= p->ncolumns) continue;
    if (p->column[c] < 0) {
      for (*material = 0; *material < scene->nmaterials && strcasecmp(scene->materials[*material].name, w);)
        ++*material;
      if (*material == scene->nmaterials) (void)snprintf(why, len, "material %.40s is not declared", w);
      continue;
    }
    number[p->column[c]] = strtod(w, &end);
    if (*end) (void)snprintf(why, len, "'%.40s' is not a number", w);
  }
  if (!why[0] && c != p->ncolumns)
    (void)snprintf(why, len, "it has %" PetscInt_FMT " values, the heading %" PetscInt_FMT " columns", c, p->ncolumns);
  if (!why[0]) CheckRow(scene, p->dim, rows, rows->n - 1, why, len);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the lines that begin in this process's part of the file. *lines: how many there are, up to the first that is
   wrong, of which why [len] says what is. */
static PetscErrorCode ReadLines(const MPMScene *scene, const MPMBody *b, PetscMPIInt rank, PetscMPIInt size,
                                MPMPointRows *rows, PetscInt64 *lines, char why[], size_t len)
{
  const MPMPoints *p    = b->points;
  const PetscInt64 from = p->begin + (p->size - p->begin) * rank / size;
  const PetscInt64 to   = p->begin + (p->size - p->begin) * (rank + 1) / size;
  PetscInt64       at   = from;
  FILE            *file = fopen(p->path, "r");
  char            *line = NULL;
  size_t           room = 0;

  PetscFunctionBeginUser;
  if (!file || fseeko(file, (off_t)(rank ? from - 1 : from), SEEK_SET)) (void)snprintf(why, len, "%s", strerror(errno));
  if (!why[0] && rank) at += getline(&line, &room, file) - 1; /* the end of a line of the process before */
  while (!why[0] && at < to) {
    const ssize_t n = getline(&line, &room, file);

    if (n <= 0) break;
    at += n;
    ++*lines;
    CheckText(line, (size_t)n, why, len);
    if (!why[0] && HasValues(line)) PetscCall(ReadLine(scene, b, line, rows, why, len));
  }
  if (file) (void)fclose(file);
  free(line);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsRead(const MPMScene *scene, const MPMBody *b, MPI_Comm comm, MPMOptions o, MPMPointRows *rows)
{
  const MPMPoints *p                     = b->points;
  char             why[MPM_TEXT_LEN / 4] = "";
  PetscMPIInt      rank, size;
  PetscInt64       lines = 0, before = 0, mine;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(rows, sizeof *rows));
  rows->stride = 2 * p->dim + p->dim * p->dim + 1;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (p->hdf5) {
    rows->first = p->all * rank / size;
    for (PetscInt64 k = rows->first; k < p->all * (rank + 1) / size; k++) PetscCall(AddRow(b, rows));
    PetscCall(MPMPointsReadHDF5(p, rows, why, sizeof why));
    if (why[0] && o)
      MPMOptionsFail(o, "%.600s: %s", p->what, why); /* no particle is to blame; the first fault counts */
    for (PetscInt k = 0; k < rows->n && !why[0]; k++, lines++) CheckRow(scene, p->dim, rows, k, why, sizeof why);
  } else
    PetscCall(ReadLines(scene, b, rank, size, rows, &lines, why, sizeof why));
  PetscCallMPI(MPI_Exscan(&lines, &before, 1, MPIU_INT64, MPI_SUM, comm));
  if (!rank) before = 0;
  if (why[0] && o)
    MPMOptionsFail(o, "%.600s%s%" PetscInt64_FMT ": %s", p->what, p->hdf5 ? ", particle " : ":",
                   p->lines + before + lines, why);
  PetscCheck(!why[0] || o, PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "%s has changed since it was read first: %s", p->path,
             why);
  mine = rows->n;
  PetscCallMPI(MPI_Exscan(&mine, &rows->first, 1, MPIU_INT64, MPI_SUM, comm));
  if (!rank) rows->first = 0;
  PetscCallMPI(MPI_Allreduce(&mine, &rows->all, 1, MPIU_INT64, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsDestroyRows(MPMPointRows *rows)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(rows->number));
  PetscCall(PetscFree(rows->material));
  PetscFunctionReturn(PETSC_SUCCESS);
}
