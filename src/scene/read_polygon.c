/* read_polygon.c - reads the vertices of a polygon, from an option or a CSV file, and checks its loops. */
#include <ctype.h>
#include <stdlib.h>
#include "scene/shapes.h"

/* The vertices of all loops; each is joined to the next of its loop, and the last to the first. */
typedef struct {
  PetscInt   n, room;
  PetscReal *x;    /* [n][2] m */
  PetscInt  *loop; /* [n] from 1 */
  char       what[MPM_TEXT_LEN];
} Loops;

static PetscErrorCode AddVertex(Loops *l, PetscInt loop, const PetscReal x[2])
{
  PetscFunctionBeginUser;
  if (l->n == l->room) {
    l->room = 2 * l->room + 64;
    PetscCall(PetscRealloc((size_t)(2 * l->room) * sizeof *l->x, &l->x));
    PetscCall(PetscRealloc((size_t)l->room * sizeof *l->loop, &l->loop));
  }
  l->x[2 * l->n]     = x[0] + 0.0; /* no -0 */
  l->x[2 * l->n + 1] = x[1] + 0.0;
  l->loop[l->n++]    = loop;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a number at *at and goes behind it and the blanks that follow. */
static PetscBool Number(char **at, PetscReal *value)
{
  char *end;

  *value = strtod(*at, &end);
  if (end == *at || !(PetscAbsReal(*value) <= PETSC_MAX_REAL)) return PETSC_FALSE;
  *at = end + strspn(end, " \t\r");
  return PETSC_TRUE;
}

/* Reads the vertices of the option: pairs of numbers, with commas in them, and ; between loops. */
static PetscErrorCode ParseOption(MPMOptions o, char text[], Loops *l)
{
  PetscInt loop = 1;

  PetscFunctionBeginUser;
  for (char *at = text + strspn(text, " \t"); *at && !MPMOptionsError(o);) {
    PetscReal x[2];

    if (*at == ';') {
      loop++;
      at += 1 + strspn(at + 1, " \t");
      continue;
    }
    if (!Number(&at, &x[0]) || *at != ',' || (at++, !Number(&at, &x[1])))
      MPMOptionsFail(o,
                     "%s: vertex %" PetscInt_FMT
                     " has no two numbers x,y before '%.20s'; write \"x,y x,y x,y\", and ; between loops",
                     l->what, l->n + 1, at);
    else
      PetscCall(AddVertex(l, loop, x));
    if (*at == ',') at += 1 + strspn(at + 1, " \t"); /* x,y,x,y too */
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the lines of a CSV file, which end as those of any system do. A first line of words is a heading; an empty line
   begins a new loop, and # a comment. */
static PetscErrorCode ParseFile(MPMOptions o, char text[], Loops *l)
{
  PetscInt  loop = 1, line = 0, before = 0;
  char     *next;
  PetscBool heading = PETSC_TRUE;

  PetscFunctionBeginUser;
  for (char *at = strchr(text, '\r'); at; at = strchr(at + 1, '\r'))
    if (at[1] != '\n') *at = '\n';
  for (char *at = text; at && !MPMOptionsError(o); at = next) {
    PetscReal x[2];

    next = strchr(at, '\n');
    if (next) *next++ = 0;
    line++;
    at += strspn(at, " \t\r");
    if (*at == '#') continue;
    if (!*at) {
      if (l->n > before) loop++;
      before = l->n;
      continue;
    }
    if (heading && isalpha((unsigned char)*at) && tolower((unsigned char)*at) == 'x') {
      heading = PETSC_FALSE;
      continue;
    }
    heading = PETSC_FALSE;
    if (!Number(&at, &x[0]) || (at += *at == ',' || *at == ';', !Number(&at, &x[1])) || *at)
      MPMOptionsFail(
          o, "%.600s:%" PetscInt_FMT ": a vertex is two numbers x,y, and this line has something else at '%.40s'",
          l->what, line, at);
    else
      PetscCall(AddVertex(l, loop, x));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Checks ------------------------------------------------------------------------------------------------------- */

/* An edge: its vertices, its number in its loop, and the range of x. */
typedef struct {
  PetscInt  a, b, number;
  PetscReal lo, hi;
} Edge;

static int CompareEdges(const void *a, const void *b)
{
  const Edge *p = (const Edge *)a, *q = (const Edge *)b;

  return p->lo != q->lo ? (p->lo < q->lo ? -1 : 1) : p->a < q->a ? -1 : p->a > q->a;
}

/* Returns twice the area of the triangle a b c, positive if they turn to the left. */
static PetscReal Area(const PetscReal a[], const PetscReal b[], const PetscReal c[])
{
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Returns whether two edges cross in their inner parts. */
static PetscBool Cross(const Loops *l, const Edge *e, const Edge *f)
{
  const PetscReal *a = l->x + 2 * e->a, *b = l->x + 2 * e->b, *c = l->x + 2 * f->a, *d = l->x + 2 * f->b;

  return Area(a, b, c) * Area(a, b, d) < 0 && Area(c, d, a) * Area(c, d, b) < 0;
}

/* Checks loop `loop`, the vertices first .. end-1: their number, repeated ones, edges that turn back. A last vertex
   that repeats the first is taken away. Returns whether the loop has no area. */
static PetscBool CheckLoop(MPMOptions o, Loops *l, PetscInt loop, PetscInt first, PetscInt *end)
{
  PetscReal area = 0;
  PetscInt  n;

  if (*end - first > 1 && l->x[2 * first] == l->x[2 * *end - 2] && l->x[2 * first + 1] == l->x[2 * *end - 1]) --*end;
  n = *end - first;
  if (n < 3)
    MPMOptionsFail(o, "%s: loop %" PetscInt_FMT " has %" PetscInt_FMT " vert%s, a loop needs 3", l->what, loop, n,
                   n == 1 ? "ex" : "ices");
  for (PetscInt k = 0; k < n && !MPMOptionsError(o); k++) {
    const PetscReal *a = l->x + 2 * (first + k), *b = l->x + 2 * (first + (k + 1) % n),
                    *c = l->x + 2 * (first + (k + 2) % n);

    area += Area(l->x + 2 * first, a, b);
    if (a[0] == b[0] && a[1] == b[1])
      MPMOptionsFail(o, "%s: vertices %" PetscInt_FMT " and %" PetscInt_FMT " of loop %" PetscInt_FMT " are both %g,%g",
                     l->what, k + 1, (k + 1) % n + 1, loop, (double)a[0], (double)a[1]);
    else if (Area(a, b, c) == 0 && (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) < 0)
      MPMOptionsFail(o, "%s: loop %" PetscInt_FMT " turns back on itself at vertex %" PetscInt_FMT ", %g,%g", l->what,
                     loop, (k + 1) % n + 1, (double)b[0], (double)b[1]);
  }
  return area == 0;
}

/* Checks that no two edges cross. They are sorted by x, so that only neighbours are compared. */
static void CheckCrossings(MPMOptions o, const Loops *l, PetscInt n, Edge *edge)
{
  qsort(edge, (size_t)n, sizeof *edge, CompareEdges);
  for (PetscInt p = 0; p < n && !MPMOptionsError(o); p++)
    for (PetscInt q = p + 1; q < n && edge[q].lo <= edge[p].hi; q++) {
      const Edge *e = &edge[p], *f = &edge[q];

      if (!Cross(l, e, f)) continue;
      MPMOptionsFail(
          o,
          "%s: edge %" PetscInt_FMT " of loop %" PetscInt_FMT ", from %g,%g to %g,%g, crosses edge %" PetscInt_FMT
          " of loop %" PetscInt_FMT ", from %g,%g to %g,%g",
          l->what, e->number, l->loop[e->a], (double)l->x[2 * e->a], (double)l->x[2 * e->a + 1], (double)l->x[2 * e->b],
          (double)l->x[2 * e->b + 1], f->number, l->loop[f->a], (double)l->x[2 * f->a], (double)l->x[2 * f->a + 1],
          (double)l->x[2 * f->b], (double)l->x[2 * f->b + 1]);
      break;
    }
}

/* Checks the loops and makes their edges the surface of the shape. */
static PetscErrorCode MakeSurface(MPMOptions o, const char name[], Loops *l, MPMRegion *r)
{
  PetscReal *corner;
  PetscInt   n = 0, flat = 0;
  Edge      *edge;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(l->n, &edge));
  for (PetscInt first = 0, next, loop = 1; first < l->n && !MPMOptionsError(o); first = next, loop++) {
    PetscInt end;

    for (next = first; next < l->n && l->loop[next] == l->loop[first];) next++;
    end = next;
    if (CheckLoop(o, l, loop, first, &end) && !flat) flat = loop;
    for (PetscInt k = first; k < end; k++) {
      const PetscInt  to = k + 1 < end ? k + 1 : first;
      const PetscReal a = l->x[2 * k], b = l->x[2 * to];

      edge[n++] = (Edge){k, to, k - first + 1, PetscMin(a, b), PetscMax(a, b)};
    }
  }
  if (!n) MPMOptionsFail(o, "%s: it has no vertices", l->what);
  CheckCrossings(o, l, n, edge);
  if (flat) MPMOptionsFail(o, "%s: loop %" PetscInt_FMT " has no area", l->what, flat);
  PetscCall(PetscMalloc1(4 * n, &corner));
  for (PetscInt k = 0; k < 2 * n; k++)
    for (PetscInt d = 0; d < 2; d++) corner[2 * k + d] = l->x[2 * (k % 2 ? edge[k / 2].b : edge[k / 2].a) + d];
  if (!MPMOptionsError(o)) {
    r->surface = MPMSurfaceCreate(2, n, corner);
    PetscCheck(r->surface, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for a polygon");
    for (PetscInt d = 0; d < 2; d++) { /* lower and upper limit it */
      r->lower[d] = PetscMax(r->lower[d], r->surface->lower[d]);
      r->upper[d] = PetscMin(r->upper[d], r->surface->upper[d]);
      if (!(r->lower[d] < r->upper[d]))
        MPMOptionsFail(o, "%s: nothing of it lies between -body_%s_lower and -body_%s_upper", l->what, name, name);
    }
  }
  PetscCall(PetscFree(corner));
  PetscCall(PetscFree(edge));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneReadPolygon(MPMCore *core, MPMOptions o, const char name[], MPMRegion *r)
{
  Loops       l                  = {0};
  char        text[MPM_TEXT_LEN] = "", path[MPM_TEXT_LEN], fault[MPM_TEXT_LEN], *file;
  PetscBool   by_text, by_file;
  size_t      n, mark;
  const char *encoding = NULL;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "body_<b>_vertices", name, text, &by_text));
  PetscCall(MPMOptionsPath(o, "body_<b>_file", name, path, &by_file));
  if (by_text && by_file) MPMOptionsFail(o, "-body_%s_vertices and -body_%s_file exclude each other", name, name);
  if (!by_text && !by_file)
    MPMOptionsFail(o, "-body_%s_vertices is required (corners of a polygon, \"x,y x,y x,y\"), or -body_%s_file", name,
                   name);
  (void)snprintf(l.what, sizeof l.what, by_text ? "-body_%s_vertices%.0s" : "-body_%s_file %.500s", name, path);
  if (by_text && !MPMOptionsError(o)) PetscCall(ParseOption(o, text, &l));
  if (by_file && !MPMOptionsError(o)) {
    PetscCall(MPMSceneReadFile(core->comm, path, &file, &n, fault));
    if (fault[0]) MPMOptionsFail(o, "-body_%s_file: %s", name, fault);
    if (file) encoding = MPMSceneTextFault(file, n, &mark);
    if (encoding) MPMOptionsFail(o, "-body_%s_file: %.500s %s", name, path, encoding);
    if (file && strlen(file) != n) MPMOptionsFail(o, "-body_%s_file: %.500s is no text", name, path);
    PetscCall(MPMOptionsShare(o, core->comm));
    PetscCallMPI(MPI_Bcast(&n, sizeof n, MPI_BYTE, 0, core->comm));
    if (!MPMOptionsError(o)) {
      if (!file) PetscCall(PetscMalloc1(n + 1, &file));
      PetscCallMPI(MPI_Bcast(file, (PetscMPIInt)n + 1, MPI_BYTE, 0, core->comm));
      (void)MPMSceneTextFault(file, n, &mark);
      PetscCall(ParseFile(o, file + mark, &l));
    }
    PetscCall(PetscFree(file));
  }
  if (!MPMOptionsError(o)) PetscCall(MakeSurface(o, name, &l, r));
  PetscCall(PetscFree(l.x));
  PetscCall(PetscFree(l.loop));
  PetscFunctionReturn(PETSC_SUCCESS);
}
