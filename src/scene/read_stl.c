/* read_stl.c - reads the triangles of an STL file, ASCII or binary, and checks that they enclose a volume: every edge
   belongs to two triangles. This reader takes the place of a library: what admesh has beyond it is repair by guesses,
   which would change a body without being asked, and assimp is 30 times the size of Pebble.

   Inside is what an odd number of surfaces encloses (physics/surface.h), so neither the normals in the file nor the
   sense in which a triangle lists its corners matter. */
#include <stdlib.h>
#include <strings.h>
#include "scene/shapes.h"

#define MOST 50000000 /* triangles of a file */

/* --- The file ----------------------------------------------------------------------------------------------------- */

/* Reads the next word of an ASCII file, which ends at *at; counts lines. Returns its length, 0 at the end. */
static size_t Word(char **at, char **word, PetscInt *line)
{
  for (; **at && strchr(" \t\r\n", **at); ++*at) *line += **at == '\n' || (**at == '\r' && (*at)[1] != '\n');
  *word = *at;
  *at += strcspn(*at, " \t\r\n");
  return (size_t)(*at - *word);
}

/* Reads the facets of an ASCII file, which begins with its first word: solid name, then facet normal n n n, outer loop,
   vertex x y z three times, endloop, endfacet. line: the number of its first line. */
static PetscErrorCode ReadAscii(MPMOptions o, const char what[], char text[], PetscInt line, PetscInt *n,
                                PetscReal **corner)
{
  static const char *const form[] = {"facet",  "normal", "", "", "",       "outer",   "loop",
                                     "vertex", "",       "", "", "vertex", "",        "",
                                     "",       "vertex", "", "", "",       "endloop", "endfacet"};
  const PetscInt           words  = (PetscInt)(sizeof form / sizeof form[0]);
  char                    *at     = text + strcspn(text, "\r\n"), *word; /* behind the line "solid name" */
  PetscInt                 room = 0, k = 0, c = 0;
  size_t                   length;

  PetscFunctionBeginUser;
  *n = 0;
  while (!MPMOptionsError(o) && (length = Word(&at, &word, &line))) {
    if (!k && length == 8 && !strncasecmp(word, "endsolid", 8)) {
      at += strcspn(at, "\r\n");
      length = Word(&at, &word, &line); /* another solid, or the end */
      if (!length) break;
      if (length != 5 || strncasecmp(word, "solid", 5))
        MPMOptionsFail(o, "%.600s:%" PetscInt_FMT ": '%.*s' where solid or the end of the file should be", what, line,
                       (int)PetscMin(length, 40), word);
      at += strcspn(at, "\r\n");
      continue;
    }
    if (*n == room) {
      room = 2 * room + 256;
      PetscCall(PetscRealloc((size_t)room * 9 * sizeof **corner, corner));
    }
    if (form[k][0] ? length != strlen(form[k]) || strncasecmp(word, form[k], length) : 0)
      MPMOptionsFail(o, "%.600s:%" PetscInt_FMT ": '%.*s' where %s should be", what, line, (int)PetscMin(length, 40),
                     word, k ? form[k] : "facet or endsolid");
    if (!form[k][0] && k > 4) {
      char           *end;
      const PetscReal x = strtod(word, &end);

      if (end != at || !(PetscAbsReal(x) <= PETSC_MAX_REAL))
        MPMOptionsFail(o, "%.600s:%" PetscInt_FMT ": '%.*s' is not a number", what, line, (int)PetscMin(length, 40),
                       word);
      (*corner)[9 * *n + c++] = x;
    }
    if (++k < words) continue;
    k = c = 0;
    ++*n;
  }
  if (k && !MPMOptionsError(o)) MPMOptionsFail(o, "%.600s:%" PetscInt_FMT ": the file ends within a facet", what, line);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the facets of a binary file: 80 bytes, their number, and for each 12 floats and 2 bytes. */
static PetscErrorCode ReadBinary(MPMOptions o, const char what[], const char text[], PetscInt facets,
                                 PetscReal **corner)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(9 * (size_t)facets, corner));
  for (PetscInt k = 0; k < 9 * facets && !MPMOptionsError(o); k++) {
    float x;

    memcpy(&x, text + 84 + 50 * (size_t)(k / 9) + 12 + 4 * (size_t)(k % 9), sizeof x);
    if (!(PetscAbsReal((PetscReal)x) <= PETSC_MAX_REAL))
      MPMOptionsFail(o, "%.600s: a corner of facet %" PetscInt_FMT " is not finite", what, k / 9 + 1);
    (*corner)[k] = (PetscReal)x;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a file of n bytes, whose form is found by its size. An ASCII file may begin with a byte-order mark and blanks.
   */
static PetscErrorCode ReadFacets(MPMOptions o, const char what[], char text[], size_t n, PetscInt *facets,
                                 PetscReal **corner)
{
  uint32_t     count = 0;
  PetscInt     line  = 1;
  size_t       mark;
  const char  *fault  = MPMSceneTextFault(text, n, &mark);
  char        *at     = text + mark, *word;
  const size_t length = Word(&at, &word, &line);

  PetscFunctionBeginUser;
  *facets = 0;
  if (n >= 84) memcpy(&count, text + 80, sizeof count);
  if (n >= 84 && n == 84 + 50 * (size_t)count) {
    *facets = (PetscInt)PetscMin(count, (uint32_t)MOST + 1);
    if (*facets <= MOST) PetscCall(ReadBinary(o, what, text, *facets, corner));
  } else if (fault)
    MPMOptionsFail(o, "%.600s %s", what, fault);
  else if (length >= 5 && !strncasecmp(word, "solid", 5) && strlen(text) == n)
    PetscCall(ReadAscii(o, what, word, line, facets, corner));
  else
    MPMOptionsFail(
        o,
        "%.600s is no STL file: an ASCII one begins with solid, and a binary one that says it has %g facets has %g "
        "bytes, not %g",
        what, (double)count, 84 + 50 * (double)count, (double)n);
  if (!*facets) MPMOptionsFail(o, "%.600s has no facets", what);
  if (*facets > MOST) MPMOptionsFail(o, "%.600s has more than %d facets", what, MOST);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Is it closed? ------------------------------------------------------------------------------------------------ */

/* An edge, its lower end first. */
typedef struct {
  PetscReal a[3], b[3];
} Edge;

static int ComparePlaces(const PetscReal a[3], const PetscReal b[3])
{
  for (PetscInt d = 0; d < 3; d++)
    if (a[d] != b[d]) return a[d] < b[d] ? -1 : 1;
  return 0;
}

static int CompareEdges(const void *a, const void *b)
{
  const Edge *p = (const Edge *)a, *q = (const Edge *)b;
  const int   c = ComparePlaces(p->a, q->a);

  return c ? c : ComparePlaces(p->b, q->b);
}

/* Takes facets away that have two equal corners, since they are lines: their edges would count twice. */
static void DropLines(PetscInt *n, PetscReal *corner)
{
  PetscInt kept = 0;

  for (PetscInt f = 0; f < *n; f++) {
    const PetscReal *c = corner + 9 * f;

    if (!ComparePlaces(c, c + 3) || !ComparePlaces(c + 3, c + 6) || !ComparePlaces(c, c + 6)) continue;
    memmove(corner + 9 * kept++, c, 9 * sizeof *c);
  }
  *n = kept;
}

/* Checks that every edge belongs to two facets; the edges are sorted, so that equal ones are neighbours. */
static PetscErrorCode CheckClosed(MPMOptions o, const char what[], PetscInt n, const PetscReal corner[])
{
  PetscInt open = 0, many = 0, bad = -1, count = 0;
  Edge    *edge;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(3 * (size_t)n, &edge));
  for (PetscInt k = 0; k < 3 * n; k++) {
    const PetscReal *p = corner + 3 * k, *q = corner + 9 * (k / 3) + 3 * ((k + 1) % 3), *lo = p, *hi = q;

    if (ComparePlaces(p, q) > 0) {
      lo = q;
      hi = p;
    }
    PetscCall(PetscArraycpy(edge[k].a, lo, 3));
    PetscCall(PetscArraycpy(edge[k].b, hi, 3));
  }
  qsort(edge, 3 * (size_t)n, sizeof *edge, CompareEdges);
  for (PetscInt k = 0, next; k < 3 * n; k = next) {
    for (next = k + 1; next < 3 * n && !CompareEdges(&edge[k], &edge[next]);) next++;
    if (next - k == 2) continue;
    if (bad < 0 || (next - k == 1 && !open)) { /* a hole is named before anything else */
      bad   = k;
      count = next - k;
    }
    open += next - k == 1;
    many += next - k > 2;
  }
  if (bad >= 0) {
    const PetscReal *a = edge[bad].a, *b = edge[bad].b;

    if (open)
      MPMOptionsFail(o,
                     "%.600s is not closed: %" PetscInt_FMT
                     " edge%s belong%s to one facet only, such as that from %g,%g,%g to "
                     "%g,%g,%g; fill the hole, or merge corners that nearly agree, where the file was made",
                     what, open, open == 1 ? "" : "s", open == 1 ? "s" : "", (double)a[0], (double)a[1], (double)a[2],
                     (double)b[0], (double)b[1], (double)b[2]);
    else
      MPMOptionsFail(o,
                     "%.600s: %" PetscInt_FMT
                     " edge%s belong%s to more than two facets, such as that from %g,%g,%g to %g,%g,%g, "
                     "to %" PetscInt_FMT "; take away facets that are there twice, and walls inside of the body",
                     what, many, many == 1 ? "" : "s", many == 1 ? "s" : "", (double)a[0], (double)a[1], (double)a[2],
                     (double)b[0], (double)b[1], (double)b[2], count);
  }
  PetscCall(PetscFree(edge));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The shape ---------------------------------------------------------------------------------------------------- */

PetscErrorCode MPMSceneReadSTL(MPMCore *core, MPMOptions o, const char name[], MPMRegion *r)
{
  char      path[MPM_TEXT_LEN], what[MPM_TEXT_LEN], fault[MPM_TEXT_LEN], *text;
  PetscReal scale = 1, shift[3] = {0}, *corner = NULL;
  PetscInt  facets = 0;
  PetscBool set;
  size_t    n;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsPath(o, "body_<b>_file", name, path, &set));
  if (!set) MPMOptionsFail(o, "-body_%s_file is required (an STL file)", name);
  PetscCall(MPMOptionsReal(o, "body_<b>_scale", name, &scale, NULL));
  PetscCall(MPMOptionsReals(o, "body_<b>_shift", name, shift, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMSceneReadFile(core->comm, path, &text, &n, fault));
  if (fault[0]) MPMOptionsFail(o, "-body_%s_file: %s", name, fault);
  (void)snprintf(what, sizeof what, "-body_%s_file %.500s", name, path);
  if (text) {
    PetscCall(ReadFacets(o, what, text, n, &facets, &corner));
    if (!MPMOptionsError(o)) {
      for (PetscInt k = 0; k < 9 * facets; k++) corner[k] = scale * corner[k] + shift[k % 3] + 0.0; /* no -0 */
      DropLines(&facets, corner);
      if (!facets) MPMOptionsFail(o, "%s: all of its facets have two equal corners", what);
      PetscCall(CheckClosed(o, what, facets, corner));
    }
  }
  PetscCall(PetscFree(text));
  PetscCall(MPMOptionsShare(o, core->comm));
  if (!MPMOptionsError(o)) {
    PetscCallMPI(MPI_Bcast(&facets, 1, MPIU_INT, 0, core->comm));
    if (!corner) PetscCall(PetscMalloc1(9 * (size_t)facets, &corner));
    PetscCallMPI(MPI_Bcast(corner, (PetscMPIInt)(9 * facets), MPIU_REAL, 0, core->comm));
    r->surface = MPMSurfaceCreate(3, facets, corner);
    PetscCheck(r->surface, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for %" PetscInt_FMT " facets", facets);
    PetscCall(PetscArraycpy(r->lower, r->surface->lower, 3));
    PetscCall(PetscArraycpy(r->upper, r->surface->upper, 3));
  }
  PetscCall(PetscFree(corner));
  PetscFunctionReturn(PETSC_SUCCESS);
}
