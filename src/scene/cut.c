/* cut.c - the volumes of particles at the surface of a body.

   The particles of a body are those whose places of the lattice have their centre in it. If all of them had the volume of
   a whole place, they would represent a curved or slanting surface by steps, and one between two places by its nearest
   place; the error does not fall faster than h. So a particle has the volume, and starts at the centroid, of the part of
   its place that is in the body. What the body has of a place whose centre is outside belongs to the particle that is
   nearest to the centroid of it, among the neighbours of that place. A place is divided into parts, each of which is in or
   out by its centre; so volumes and masses are multiples of one part, and a row of the table of kinds for each number of
   parts is all that is needed: nothing for a particle, and nothing in a step. (Volumes and centroids of cut places are
   used by embedded-boundary methods; in MPM they keep the integration of the first cells consistent.) */
#include "scene/cut.h"
#include "scene/kinds.h"
#include "scene/lattice.h"

#define PLACES 27   /* of a neighbourhood: 3^dim are used */
#define TIE    1e-9 /* spacings squared: places as near as this share alike, as symmetry wants it */
#define SPLIT  12   /* a part of a place is as many parts as can be shared by 2, 3, 4, 6 or 12 */

static const PetscInt along[] = {1024, 16, 8}; /* parts of a place on each axis, by the dimension less one */

PetscErrorCode MPMCutSetFromOptions(MPMScene *scene, MPMOptions o)
{
  char      rim[MPM_NAME_LEN];
  PetscBool given;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsMethodGiven(&given, NULL));
  (void)snprintf(rim, sizeof rim, "%s", given ? "whole" : "cut");
  PetscCall(MPMOptionsEnum(o, "method_rim", NULL, rim, NULL));
  for (PetscInt k = 0; k < scene->nbodies; k++) scene->bodies[k].whole = strcmp(rim, "cut") ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMCutParts(PetscInt dim)
{
  PetscInt n = SPLIT;

  for (PetscInt d = 0; d < dim; d++) n *= along[dim - 1];
  return n;
}

/* Sets by [dim] to the offset of place q of a neighbourhood from its middle, in spacings. */
static void Offset(PetscInt dim, PetscInt q, PetscInt by[])
{
  for (PetscInt d = 0; d < dim; d++, q /= 3) by[d] = q % 3 - 1;
}

static void Neighbour(const MPMBody *b, PetscInt dim, const PetscReal x[], const PetscInt by[], PetscReal y[])
{
  for (PetscInt d = 0; d < dim; d++) y[d] = x[d] + (PetscReal)by[d] * b->b[d];
}

/* Returns how many parts of the place x [dim], m, are in the body, and sets sum [dim] to the sum of their places relative to
   x, in spacings. */
static PetscInt Parts(const MPMBody *b, PetscInt dim, const PetscReal x[], PetscReal sum[])
{
  const PetscInt last = dim - 1, n = along[last];
  PetscInt       count = 0, rows = 1;

  for (PetscInt d = 0; d < dim; d++) sum[d] = 0;
  for (PetscInt d = 0; d < last; d++) rows *= n;
  for (PetscInt k = 0; k < rows; k++) {
    MPMRow     row = {.dim = dim, .spacing = b->b[last] / (PetscReal)n, .offset = x[last] - 0.5 * b->b[last]};
    PetscReal  by[3];
    PetscInt64 to;

    for (PetscInt d = 0, at = k; d < last; d++, at /= n) {
      by[d]    = ((PetscReal)(at % n) + 0.5) / (PetscReal)n - 0.5;
      row.x[d] = x[d] + by[d] * b->b[d];
    }
    row.x[last] = MPMRowPlace(&row, 0);
    for (PetscInt64 from = 0; from < n; from = to) {
      if (!MPMRegionSpan(&b->region, &row, from, n, &to)) continue;
      count += (PetscInt)(to - from);
      for (PetscInt d = 0; d < last; d++) sum[d] += (PetscReal)(to - from) * by[d];
      sum[last] += (PetscReal)(to - from) * (0.5 * (PetscReal)(from + to) / (PetscReal)n - 0.5);
    }
  }
  return count;
}

/* Returns by how many neighbours what is in the body of a place x [dim], m, outside it is shared, if that at `by` [dim] is
   one of them, else 0; centre [dim], in spacings, is its centroid. */
static PetscInt Sharing(const MPMBody *b, PetscInt dim, PetscInt places, const PetscReal x[], const PetscReal centre[],
                       const PetscInt by[])
{
  PetscReal nearest = PETSC_INFINITY, y[3];
  PetscInt  sharing = 0;
  PetscBool takes   = PETSC_FALSE;

  for (PetscInt q = 0; q < places; q++) {
    PetscReal away = 0;
    PetscInt  at[3];
    PetscBool own = PETSC_TRUE;

    Offset(dim, q, at);
    for (PetscInt d = 0; d < dim; d++) away += PetscSqr((PetscReal)at[d] - centre[d]);
    if (!(away < nearest + TIE)) continue;
    Neighbour(b, dim, x, at, y);
    if (!MPMRegionInside(&b->region, dim, y)) continue;
    for (PetscInt d = 0; d < dim; d++)
      if (at[d] != by[d]) own = PETSC_FALSE;
    if (away < nearest - TIE) {
      nearest = away;
      sharing = 0;
      takes   = PETSC_FALSE;
    }
    sharing++;
    if (own) takes = PETSC_TRUE;
  }
  return takes ? PetscMin(sharing, SPLIT) : 0;
}

PetscInt MPMCut(const MPMBody *b, PetscInt dim, const PetscReal place[], PetscReal X[])
{
  PetscInt  places = 1, out[PLACES], nout = 0, count, by[3];
  PetscReal sum[3], y[3];

  for (PetscInt d = 0; d < dim; d++) {
    X[d] = place[d];
    places *= 3;
  }
  if (b->whole || b->points) return MPMCutParts(dim);
  for (PetscInt q = 0; q < places; q++) {
    Offset(dim, q, by);
    Neighbour(b, dim, place, by, y);
    if (!MPMRegionInside(&b->region, dim, y)) out[nout++] = q;
  }
  if (!nout) return MPMCutParts(dim);
  count = SPLIT * Parts(b, dim, place, sum);
  for (PetscInt d = 0; d < dim; d++) sum[d] *= SPLIT;
  for (PetscInt k = 0; k < nout; k++) {
    PetscInt  more, sharing, back[3];
    PetscReal own[3], centre[3];

    Offset(dim, out[k], by);
    Neighbour(b, dim, place, by, y);
    more = Parts(b, dim, y, own);
    if (!more) continue;
    for (PetscInt d = 0; d < dim; d++) {
      centre[d] = own[d] / (PetscReal)more;
      back[d]   = -by[d];
    }
    sharing = Sharing(b, dim, places, y, centre, back);
    if (!sharing) continue;
    count += more * (SPLIT / sharing);
    for (PetscInt d = 0; d < dim; d++)
      sum[d] += (own[d] + (PetscReal)(more * by[d])) * (PetscReal)(SPLIT / sharing);
  }
  count = PetscMax(1, count); /* a shape thinner than a part may lie between their centres */
  for (PetscInt d = 0; d < dim; d++) X[d] = place[d] + sum[d] / (PetscReal)count * b->b[d];
  return count;
}

/* Returns the most parts that a particle can have. */
static PetscInt Most(PetscInt dim)
{
  PetscInt n = MPMCutParts(dim);

  for (PetscInt d = 0; d < dim; d++) n *= 3;
  return n;
}

PetscErrorCode MPMCutFind(MPMScene *scene, const MPMCore *core, MPMBody *b)
{
  const PetscInt  dim = core->grid.dim, whole = MPMCutParts(dim), most = Most(dim);
  const MPMKind   own = scene->kinds[b->kind];
  MPMLattice      w;
  PetscMPIInt     rank, size;
  PetscInt        n = 0, parts;
  PetscReal       place[3], X[3];

  PetscFunctionBeginUser;
  b->parts = b->n * whole;
  if (b->whole) PetscFunctionReturn(PETSC_SUCCESS);
  b->parts = 0;
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  PetscCall(PetscCalloc1(most + 1, &b->cut));
  w = MPMLatticeShare(scene, b, dim, rank, size);
  while (MPMLatticeNext(&w))
    for (PetscInt64 k = 0; k < w.n; k++) {
      MPMLatticePlace(&w, w.ijk[dim - 1] + k, place);
      parts         = MPMCut(b, dim, place, X);
      b->cut[parts] = 1;
      b->parts += parts;
    }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, b->cut, (PetscMPIInt)(most + 1), MPIU_INT, MPI_MAX, core->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &b->parts, 1, MPIU_INT64, MPI_SUM, core->comm));
  b->cut[whole] = 0;
  for (PetscInt k = 0; k <= most; k++) n += b->cut[k];
  scene->ncut += n > 0;
  PetscCall(MPMKindsRoom(scene, n + scene->nbodies));
  for (PetscInt k = 0; k <= most; k++) {
    MPMKind kind = own;

    if (!b->cut[k]) continue;
    kind.V0 *= (PetscReal)k / (PetscReal)whole;
    kind.m *= (PetscReal)k / (PetscReal)whole;
    b->cut[k] = MPMKindsFind(scene, scene->nkinds, &kind);
  }
  b->cut[whole] = b->kind;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMCutKind(const MPMBody *b, PetscInt dim, PetscInt parts)
{
  return parts == MPMCutParts(dim) ? b->kind : b->cut[parts];
}
