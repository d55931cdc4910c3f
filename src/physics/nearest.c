/* nearest.c - a tree of boxes around faces, which are put in sequence along a curve that fills space (Morton's), so
   that faces that follow each other are near each other; a search goes into the nearer box first, and leaves out boxes
   that are further away than what it has found. */
#include <stdlib.h>
#include "base/algebra.h"
#include "physics/nearest.h"

#define DEPTH 64 /* of a tree, at most */

/* --- The tree ----------------------------------------------------------------------------------------------------- */

typedef struct {
  uint64_t code;
  PetscInt face;
} Key;

static int CompareKeys(const void *a, const void *b)
{
  const Key *p = a, *q = b;

  if (p->code != q->code) return p->code < q->code ? -1 : 1;
  return p->face < q->face ? -1 : p->face > q->face;
}

/* Returns the place of a face's middle on the curve: the bits of its coordinates in turn. lower, upper [dim]: a box. */
static uint64_t Code(PetscInt dim, const PetscReal corner[], const PetscReal lower[], const PetscReal upper[])
{
  uint64_t code = 0, at[3] = {0};

  for (PetscInt d = 0; d < dim; d++) {
    PetscReal middle = 0;

    for (PetscInt k = 0; k < dim; k++) middle += corner[k * dim + d] / (PetscReal)dim;
    if (upper[d] > lower[d])
      at[d] = (uint64_t)PetscClipInterval((middle - lower[d]) / (upper[d] - lower[d]) * 1048575, 0, 1048575);
  }
  for (int bit = 19; bit >= 0; bit--)
    for (PetscInt d = 0; d < dim; d++) code = 2 * code + (at[d] >> bit & 1);
  return code;
}

/* Enlarges the box [2][dim] by places x [more][dim]. */
static void Enlarge(PetscInt dim, PetscReal box[], PetscInt more, const PetscReal x[])
{
  for (PetscInt k = 0; k < more * dim; k++) {
    box[k % dim]       = PetscMin(box[k % dim], x[k]);
    box[dim + k % dim] = PetscMax(box[dim + k % dim], x[k]);
  }
}

static void Empty(PetscInt dim, PetscReal box[])
{
  for (PetscInt d = 0; d < dim; d++) {
    box[d]       = PETSC_MAX_REAL;
    box[dim + d] = PETSC_MIN_REAL;
  }
}

static void MakeBoxes(MPMNearest *t)
{
  const PetscInt dim = t->dim, size = dim * dim;

  for (PetscInt k = 2 * t->first; k >= 0; k--) {
    PetscReal *box = t->box + 2 * dim * k;

    Empty(dim, box);
    if (k < t->first) {
      for (PetscInt c = 0; c < 2; c++) { /* an empty one has corners that would enlarge it */
        const PetscReal *part = t->box + 2 * dim * (2 * k + 1 + c);

        if (part[0] <= part[dim]) Enlarge(dim, box, 2, part);
      }
    } else
      for (PetscInt f = MPM_LEAF * (k - t->first); f < PetscMin(t->n, MPM_LEAF * (k - t->first + 1)); f++)
        Enlarge(dim, box, dim, t->corner + f * size);
  }
}

MPMNearest *MPMNearestCreate(PetscInt dim, PetscInt n, const PetscReal corner[], PetscReal reach)
{
  const size_t size   = (size_t)(dim * dim);
  MPMNearest  *t      = calloc(1, sizeof *t);
  Key         *key    = malloc((size_t)PetscMax(1, n) * sizeof *key);
  PetscInt     leaves = 1;
  PetscReal    all[6];

  while (leaves * MPM_LEAF < n) leaves *= 2;
  if (t) {
    *t        = (MPMNearest){.dim = dim, .n = n, .first = leaves - 1, .reach = reach};
    t->corner = malloc((size_t)PetscMax(1, n) * size * sizeof *t->corner);
    t->box    = malloc((size_t)(2 * leaves - 1) * 2 * (size_t)dim * sizeof *t->box);
  }
  if (!t || !key || !t->corner || !t->box) {
    free(key);
    MPMNearestDestroy(&t);
    return NULL;
  }
  Empty(dim, all);
  Enlarge(dim, all, n * dim, corner);
  for (PetscInt f = 0; f < n; f++) key[f] = (Key){Code(dim, corner + (size_t)f * size, all, all + dim), f};
  qsort(key, (size_t)n, sizeof *key, CompareKeys);
  for (PetscInt f = 0; f < n; f++)
    memcpy(t->corner + (size_t)f * size, corner + (size_t)key[f].face * size, size * sizeof *corner);
  MakeBoxes(t);
  free(key);
  return t;
}

void MPMNearestDestroy(MPMNearest **t)
{
  if (!*t) return;
  free((*t)->corner);
  free((*t)->box);
  free(*t);
  *t = NULL;
}

/* --- Searches ----------------------------------------------------------------------------------------------------- */

static PetscReal Dot(PetscInt dim, const PetscReal a[], const PetscReal b[])
{
  PetscReal s = 0;

  for (PetscInt d = 0; d < dim; d++) s += a[d] * b[d];
  return s;
}

/* Sets at [dim] to the place between a and b [dim] that is nearest to x [dim]. */
static void OnEdge(PetscInt dim, const PetscReal a[], const PetscReal b[], const PetscReal x[], PetscReal at[])
{
  PetscReal ab[3] = {0}, ax[3] = {0}, s, length2;

  for (PetscInt d = 0; d < dim; d++) {
    ab[d] = b[d] - a[d];
    ax[d] = x[d] - a[d];
  }
  length2 = Dot(dim, ab, ab);
  s       = length2 > 0 ? PetscClipInterval(Dot(dim, ab, ax) / length2, 0, 1) : 0;
  for (PetscInt d = 0; d < dim; d++) at[d] = a[d] + s * ab[d];
}

/* Sets at [3] to the place of the triangle, corner [3][3], that is nearest to x [3]: a corner, or on an edge, or
   within. */
static void OnTriangle(const PetscReal corner[], const PetscReal x[], PetscReal at[])
{
  const PetscReal *a = corner, *b = corner + 3, *c = corner + 6;
  PetscReal        ab[3], ac[3], ax[3], bb, bc, cc, xb, xc, va, vb, vc, s, t;

  for (PetscInt d = 0; d < 3; d++) {
    ab[d] = b[d] - a[d];
    ac[d] = c[d] - a[d];
    ax[d] = x[d] - a[d];
  }
  bb = Dot(3, ab, ab), bc = Dot(3, ab, ac), cc = Dot(3, ac, ac);
  xb = Dot(3, ab, ax), xc = Dot(3, ac, ax);
  vb = cc * xb - bc * xc; /* the shares of b and c are vb and vc over the sum of all, if none is negative */
  vc = bb * xc - bc * xb;
  va = bb * cc - bc * bc - vb - vc;
  if (va > 0 && vb > 0 && vc > 0) {
    s = vb / (va + vb + vc);
    t = vc / (va + vb + vc);
  } else if (xb <= 0 && xc <= 0)
    s = t = 0;
  else if (xb >= bb && xc - bc <= xb - bb) {
    s = 1;
    t = 0;
  } else if (xc >= cc && xb - bc <= xc - cc) {
    s = 0;
    t = 1;
  } else if (vc <= 0 && xb > 0 && xb < bb) {
    s = xb / bb;
    t = 0;
  } else if (vb <= 0 && xc > 0 && xc < cc) {
    s = 0;
    t = xc / cc;
  } else {
    const PetscReal length2 = bb - 2 * bc + cc;

    t = length2 > 0 ? PetscClipInterval((bb - bc - xb + xc) / length2, 0, 1) : 0;
    s = 1 - t;
  }
  for (PetscInt d = 0; d < 3; d++) at[d] = a[d] + s * ab[d] + t * ac[d];
}

/* Returns the squared distance of x [dim] from a box [2][dim]. */
static PetscReal FromBox2(PetscInt dim, const PetscReal box[], const PetscReal x[])
{
  PetscReal s = 0;

  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal out = PetscMax(0, PetscMax(box[d] - x[d], x[d] - box[dim + d]));

    s += out * out;
  }
  return s;
}

/* Sets at [dim] to the place of one face that is nearest to x [dim], and returns its squared distance. */
static PetscReal OnFace2(const MPMNearest *t, PetscInt face, const PetscReal x[], PetscReal at[])
{
  const PetscInt   dim    = t->dim;
  const PetscReal *corner = t->corner + face * dim * dim;
  PetscReal        s      = 0;

  if (dim == 3)
    OnTriangle(corner, x, at);
  else
    OnEdge(dim, corner, corner + (dim - 1) * dim, x, at);
  for (PetscInt d = 0; d < dim; d++) s += (x[d] - at[d]) * (x[d] - at[d]);
  return s;
}

PetscReal MPMNearestPlace(const MPMNearest *t, const PetscReal x[], PetscReal at[], PetscInt *face)
{
  const PetscInt dim  = t->dim;
  PetscReal      best = t->reach * t->reach, y[3];
  PetscInt       stack[DEPTH], top = 0;
  PetscReal      from[DEPTH];

  if (*face >= 0) {
    const PetscReal distance2 = OnFace2(t, *face, x, at);

    if (distance2 < best)
      best = distance2;
    else
      *face = -1;
  }
  from[0]  = FromBox2(dim, t->box, x);
  stack[0] = 0;
  for (top = 1; top > 0;) {
    const PetscInt k = stack[--top], part = 2 * k + 1;

    if (!(from[top] < best)) continue;
    if (k < t->first) {
      const PetscReal one = FromBox2(dim, t->box + 2 * dim * part, x),
                      two = FromBox2(dim, t->box + 2 * dim * (part + 1), x);
      const PetscInt far  = one < two ? 1 : 0;

      stack[top]  = part + far;
      from[top++] = far ? two : one;
      stack[top]  = part + 1 - far;
      from[top++] = far ? one : two;
      continue;
    }
    for (PetscInt f = MPM_LEAF * (k - t->first); f < PetscMin(t->n, MPM_LEAF * (k - t->first + 1)); f++) {
      const PetscReal distance2 = OnFace2(t, f, x, y);

      if (!(distance2 < best)) continue;
      best  = distance2;
      *face = f;
      for (PetscInt d = 0; d < dim; d++) at[d] = y[d];
    }
  }
  return *face < 0 ? t->reach : PetscSqrtReal(best);
}

PetscBool MPMNearestNormal(const MPMNearest *t, PetscInt face, PetscReal n[])
{
  const PetscInt   dim = t->dim;
  const PetscReal *a = t->corner + face * dim * dim, *b = a + dim, *c = b + dim;
  PetscReal        size;

  if (dim == 1) n[0] = 1;
  if (dim == 2) {
    n[0] = b[1] - a[1];
    n[1] = a[0] - b[0];
  }
  if (dim == 3) {
    PetscReal ab[3], ac[3];

    for (PetscInt d = 0; d < 3; d++) {
      ab[d] = b[d] - a[d];
      ac[d] = c[d] - a[d];
    }
    MPMCross(ab, ac, n);
  }
  size = PetscSqrtReal(Dot(dim, n, n));
  if (!(size > 0)) return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) n[d] /= size;
  return PETSC_TRUE;
}
