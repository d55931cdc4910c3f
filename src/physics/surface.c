/* surface.c - where lines along the last axis cross a closed surface. A place is inside if an odd number of crossings
   is at it or below it, and all comparisons are half-open, so the surface of a box has the places of the box.

   No line slips through between two faces: whether a line passes an edge on one side or on the other is computed from
   the two ends of the edge, in the sequence of their first coordinates, so that faces with a common edge find the same.
   A line then crosses a closed surface an even number of times, whatever rounding does. */
#include <stdlib.h>
#include "physics/surface.h"

/* Returns the value between a and b at the share s of the way. Rounding doesn't lead beyond a and b. */
static PetscReal Between(PetscReal a, PetscReal b, PetscReal s)
{
  const PetscReal x = a + s * (b - a);

  return PetscMin(PetscMax(x, PetscMin(a, b)), PetscMax(a, b));
}

/* Returns whether the edge from a to b [dim] meets the plane of first coordinate x, and sets at [dim - 1] to the other
   coordinates of the place where it does. */
static PetscBool EdgeAt(PetscInt dim, const PetscReal a[], const PetscReal b[], PetscReal x, PetscReal at[])
{
  const PetscReal *lo = a[0] < b[0] ? a : b, *hi = a[0] < b[0] ? b : a;

  if ((a[0] <= x) == (b[0] <= x)) return PETSC_FALSE;
  for (PetscInt d = 1; d < dim; d++) at[d - 1] = Between(lo[d], hi[d], (x - lo[0]) / (hi[0] - lo[0]));
  return PETSC_TRUE;
}

/* Returns whether the line at x [dim - 1] crosses a face, corner [dim][dim], and sets *at to the last coordinate of the
   crossing. */
static PetscBool Crosses(PetscInt dim, const PetscReal corner[], const PetscReal x[], PetscReal *at)
{
  PetscReal edge[3][2];
  int       n = 0, lo;

  if (dim == 2) return EdgeAt(2, corner, corner + 2, x[0], at);
  for (PetscInt k = 0; k < 3; k++)
    if (EdgeAt(3, corner + 3 * k, corner + 3 * ((k + 1) % 3), x[0], edge[n])) n++;
  if (n != 2 || (edge[0][0] <= x[1]) == (edge[1][0] <= x[1])) return PETSC_FALSE;
  lo  = edge[0][0] < edge[1][0] ? 0 : 1;
  *at = Between(edge[lo][1], edge[1 - lo][1], (x[1] - edge[lo][0]) / (edge[1 - lo][0] - edge[lo][0]));
  return PETSC_TRUE;
}

/* Returns the bin of a coordinate on an axis; a larger coordinate never has a lower bin. */
static PetscInt Bin(const MPMSurface *s, PetscInt d, PetscReal x)
{
  const PetscReal length = s->upper[d] - s->lower[d], k = length > 0 ? (x - s->lower[d]) / length * s->bins[d] : 0;

  return k > 0 ? (PetscInt)PetscMin(k, (PetscReal)(s->bins[d] - 1)) : 0;
}

/* Sets lo and hi [2] to the bins that a face reaches. */
static void BinsOf(const MPMSurface *s, PetscInt face, PetscInt lo[2], PetscInt hi[2])
{
  for (PetscInt d = 0; d < 2; d++) {
    lo[d] = hi[d] = 0;
    for (PetscInt k = 0; k < s->dim && d < s->dim - 1; k++) {
      const PetscInt bin = Bin(s, d, s->corner[(face * s->dim + k) * s->dim + d]);

      lo[d] = k ? PetscMin(lo[d], bin) : bin;
      hi[d] = k ? PetscMax(hi[d], bin) : bin;
    }
  }
}

/* Chooses the bins: about one for each face, but so many fewer that the lists stay short where faces are long. */
static void ChooseBins(MPMSurface *s)
{
  PetscInt   bins = 1, lo[2], hi[2];
  PetscInt64 listed;

  while (bins < 4096 && (s->dim == 2 ? bins : bins * bins) < s->n) bins *= 2;
  for (bins *= 2, listed = INT64_MAX; bins > 1 && listed > 16 * (PetscInt64)s->n;) {
    bins /= 2;
    s->bins[0] = bins;
    s->bins[1] = s->dim == 3 ? bins : 1;
    listed     = 0;
    for (PetscInt f = 0; f < s->n; f++) {
      BinsOf(s, f, lo, hi);
      listed += (PetscInt64)(hi[0] - lo[0] + 1) * (hi[1] - lo[1] + 1);
    }
  }
}

/* Lists the faces of each bin: counts them, then puts them into their places. Returns false without memory. */
static PetscBool FillBins(MPMSurface *s)
{
  const PetscInt nbins = s->bins[0] * s->bins[1];
  PetscInt       most  = 0, lo[2], hi[2];

  s->first = calloc((size_t)nbins + 1, sizeof *s->first);
  if (!s->first) return PETSC_FALSE;
  for (PetscInt round = 0; round < 2; round++) {
    for (PetscInt f = s->n - 1; f >= 0; f--) {
      BinsOf(s, f, lo, hi);
      for (PetscInt i = lo[0]; i <= hi[0]; i++)
        for (PetscInt j = lo[1]; j <= hi[1]; j++) {
          PetscInt *at = &s->first[i * s->bins[1] + j];

          if (round)
            s->member[--*at] = f;
          else
            ++*at;
        }
    }
    if (round) break;
    for (PetscInt k = 0; k < nbins; k++) most = PetscMax(most, s->first[k]);
    for (PetscInt k = 0; k < nbins; k++) s->first[k + 1] += s->first[k]; /* where bin k ends, until round 1 fills it */
    s->member   = malloc((size_t)PetscMax(1, s->first[nbins]) * sizeof *s->member);
    s->crossing = malloc((size_t)PetscMax(1, most) * sizeof *s->crossing);
    if (!s->member || !s->crossing) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Creates the surface of n faces of dim corners each, whose coordinates are copied: corner [n][dim][dim], m; dim is 2
   or 3. Returns NULL if there is no memory. */
MPMSurface *MPMSurfaceCreate(PetscInt dim, PetscInt n, const PetscReal corner[])
{
  const size_t numbers = (size_t)n * (size_t)dim * (size_t)dim;
  MPMSurface  *s       = calloc(1, sizeof *s);

  if (!s) return NULL;
  s->dim        = dim;
  s->n          = n;
  s->ncrossings = -1;
  s->corner     = malloc(PetscMax(1, numbers) * sizeof *s->corner);
  for (size_t k = 0; k < numbers && s->corner; k++) {
    const size_t d = k % (size_t)dim;

    s->corner[k] = corner[k];
    s->lower[d]  = k < (size_t)dim ? corner[k] : PetscMin(s->lower[d], corner[k]);
    s->upper[d]  = k < (size_t)dim ? corner[k] : PetscMax(s->upper[d], corner[k]);
  }
  if (s->corner) ChooseBins(s);
  if (!s->corner || !FillBins(s)) MPMSurfaceDestroy(&s);
  return s;
}

/* Frees a surface, or does nothing if it is NULL. */
void MPMSurfaceDestroy(MPMSurface **s)
{
  if (!*s) return;
  free((*s)->corner);
  free((*s)->first);
  free((*s)->member);
  free((*s)->crossing);
  free(*s);
  *s = NULL;
}

/* Finds the crossings of the line through x, of which the first dim - 1 coordinates count, in m; they stay until
   another line is asked for. Returns their number. */
PetscInt MPMSurfaceLine(MPMSurface *s, const PetscReal x[])
{
  const PetscReal y = s->dim == 3 ? x[1] : 0;
  PetscInt        bin;

  if (s->ncrossings >= 0 && s->line[0] == x[0] && s->line[1] == y) return s->ncrossings;
  s->line[0]    = x[0];
  s->line[1]    = y;
  s->ncrossings = 0;
  bin           = Bin(s, 0, x[0]) * s->bins[1] + (s->dim == 3 ? Bin(s, 1, y) : 0);
  for (PetscInt q = s->first[bin]; q < s->first[bin + 1]; q++) {
    PetscReal at;
    PetscInt  k = s->ncrossings;

    if (!Crosses(s->dim, s->corner + s->member[q] * s->dim * s->dim, s->line, &at)) continue;
    for (; k > 0 && s->crossing[k - 1] > at; k--) s->crossing[k] = s->crossing[k - 1];
    s->crossing[k] = at;
    s->ncrossings++;
  }
  return s->ncrossings;
}
