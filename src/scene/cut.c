/* cut.c - the volumes of particles at the surface of a body.

   The particles of a body are those whose places of the lattice have their centre in it. If all of them had the volume
   of a whole place, they would represent a curved or slanting surface by steps, and one between two places by its
   nearest place; the error does not fall faster than h. So a particle has the volume, and starts at the centroid, of
   the part of its place that is in the body. What the body has of a place whose centre is outside belongs to the
   particle that is nearest to the centroid of it, among the neighbours of that place. A place is divided into parts,
   each of which is in or out by its centre; so volumes and masses are multiples of one part, and a row of the table of
   kinds for each number of parts is all that is needed: nothing for a particle, and nothing in a step. (Volumes and
   centroids of cut places are used by embedded-boundary methods; in MPM they keep the integration of the first cells
   consistent.)

   A cut place of a body of revolution has the volume of its area times the way of its centroid around the axis
   (Pappus), so there the table has a row for each such volume. What is left of the axis is the mirror image of the
   body, which has no particles. */
#include "scene/at_walls.h"
#include "scene/cut.h"
#include "scene/kinds.h"

#define PLACES 27   /* of a neighbourhood: 3^dim are used */
#define TIE    1e-9 /* spacings squared: places as near as this share alike, as symmetry wants it */
#define MEMO   8192
#define SPLIT  12 /* a part of a place is as many parts as can be shared by 2, 3, 4, 6 or 12 */

static const PetscInt along[] = {1024, 16, 8}; /* parts of a place on each axis, by the dimension less one */

/* A place whose centre is outside of the body, next to one inside: how many of its parts are in the body, and the sum
   of their places relative to its centre, in spacings; which of its neighbours share them (bits), and how many these
   are. */
typedef struct {
  const MPMBody *body; /* NULL: nothing is here yet */
  PetscInt64     ijk[3];
  PetscInt       parts, takers, sharing;
  PetscReal      sum[3];
} Outer;

/* The places outside that were examined last, each where its number is mapped to: up to 9 particles ask for the same
   one. */
struct _MPMCutMemo {
  Outer outer[MEMO];
};

PetscErrorCode MPMCutSetFromOptions(MPMScene *scene, MPMOptions o)
{
  PetscFunctionBeginUser;
  if (scene->nfilled) PetscCall(MPMOptionsEnum(o, "method_rim", NULL, scene->rim, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCutSetUp(MPMScene *scene)
{
  PetscFunctionBeginUser;
  if (!scene->nfilled || strcmp(scene->rim[0] ? scene->rim : scene->start.plain ? "whole" : "cut", "cut"))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(1, &scene->memo));
  for (PetscInt k = 0; k < scene->nfilled; k++) scene->bodies[k].memo = scene->memo;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMCutParts(PetscInt dim)
{
  PetscInt n = SPLIT;

  for (PetscInt d = 0; d < dim; d++) n *= along[dim - 1];
  return n;
}

/* Sets to [dim] to place q of the neighbourhood of the place ijk [dim], and y [dim], m, to its centre, with the bits
   that the lattice has (lattice.c). */
static void Neighbour(const MPMBody *b, PetscInt dim, const PetscInt64 ijk[], PetscInt q, PetscInt64 to[],
                      PetscReal y[])
{
  for (PetscInt d = 0; d < dim; d++, q /= 3) {
    to[d] = ijk[d] + q % 3 - 1;
    y[d]  = ((PetscReal)to[d] + 0.5) * b->b[d] + b->offset[d];
  }
}

/* Returns whether the place y [dim], m, is in the body. */
static PetscBool Inside(const MPMBody *b, PetscInt dim, const PetscReal y[])
{
  const PetscReal right[3] = {b->round ? PetscAbsReal(y[0]) : y[0], y[1], y[2]};

  return MPMRegionInside(&b->region, dim, right);
}

/* Returns whether the parts at all corners of the place x [dim], m, are in the body: then in a solid shape all are,
   since these are convex (region.def). */
static PetscBool Corners(const MPMBody *b, PetscInt dim, const PetscReal x[])
{
  const PetscReal far  = 0.5 - 0.5 / (PetscReal)along[dim - 1];
  PetscReal       y[3] = {0};

  for (PetscInt k = 0; k < 1 << dim; k++) {
    for (PetscInt d = 0; d < dim; d++) y[d] = x[d] + (k >> d & 1 ? far : -far) * b->b[d];
    if (!Inside(b, dim, y)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Returns how many parts of the place x [dim], m, are in the body, and sets sum [dim] to the sum of their places
   relative to x, in spacings. */
static PetscInt Parts(const MPMBody *b, PetscInt dim, const PetscReal x[], PetscReal sum[])
{
  const PetscInt last = dim - 1, n = along[last];
  PetscInt       count = 0, rows = 1;

  for (PetscInt d = 0; d < dim; d++) sum[d] = 0;
  if (MPMRegionSolid(&b->region) && !b->region.others && Corners(b, dim, x)) return MPMCutParts(dim) / SPLIT;
  for (PetscInt d = 0; d < last; d++) rows *= n;
  for (PetscInt k = 0; k < rows; k++) {
    MPMRow     row = {.dim = dim, .spacing = b->b[last] / (PetscReal)n, .offset = x[last] - 0.5 * b->b[last]};
    PetscReal  by[3];
    PetscInt64 to;

    for (PetscInt d = 0, at = k; d < last; d++, at /= n) {
      by[d]    = ((PetscReal)(at % n) + 0.5) / (PetscReal)n - 0.5;
      row.x[d] = x[d] + by[d] * b->b[d];
    }
    if (b->round) row.x[0] = PetscAbsReal(row.x[0]);
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

/* Returns what the body has of the place ijk [dim] with its centre at x [dim], m, outside. */
static const Outer *Find(const MPMBody *b, PetscInt dim, PetscInt places, const PetscInt64 ijk[], const PetscReal x[])
{
  const PetscInt64 number  = ijk[0] + 37 * (dim > 1 ? ijk[1] : 0) + 1009 * (dim > 2 ? ijk[2] : 0);
  Outer           *o       = &b->memo->outer[((number % MEMO) + MEMO) % MEMO];
  PetscReal        nearest = PETSC_INFINITY, y[3] = {0};
  PetscInt64       to[3];

  if (o->body == b && !memcmp(o->ijk, ijk, (size_t)dim * sizeof *ijk)) return o;
  *o = (Outer){.body = b};
  for (PetscInt d = 0; d < dim; d++) o->ijk[d] = ijk[d];
  o->parts = Parts(b, dim, x, o->sum);
  for (PetscInt q = 0; q < places && o->parts; q++) {
    PetscReal away = 0;

    for (PetscInt d = 0, w = q; d < dim; d++, w /= 3)
      away += PetscSqr((PetscReal)(w % 3 - 1) - o->sum[d] / (PetscReal)o->parts);
    if (!(away < nearest + TIE)) continue;
    Neighbour(b, dim, ijk, q, to, y);
    if (!Inside(b, dim, y) || (b->round && y[0] < 0)) continue;
    if (away < nearest - TIE) {
      nearest   = away;
      o->takers = o->sharing = 0;
    }
    o->takers |= (PetscInt)1 << q;
    o->sharing = PetscMin(SPLIT, o->sharing + 1);
  }
  return o;
}

PetscInt MPMCut(const MPMBody *b, PetscInt dim, const PetscReal place[], PetscReal X[])
{
  PetscInt   places = 1, out[PLACES], nout = 0, count;
  PetscInt64 ijk[3], to[3];
  PetscReal  sum[3], y[3] = {0};

  for (PetscInt d = 0; d < dim; d++) {
    X[d]   = place[d];
    ijk[d] = b->memo ? (PetscInt64)PetscFloorReal((place[d] - b->offset[d]) / b->b[d]) : 0;
    places *= 3;
  }
  if (!b->memo) return MPMCutParts(dim);
  if (b->round) X[0] = MPMAtWallsRadius(b, place[0]);
  for (PetscInt q = 0; q < places; q++) {
    Neighbour(b, dim, ijk, q, to, y);
    if (!Inside(b, dim, y) && !(b->round && y[0] < 0)) out[nout++] = q;
  }
  if (!nout) return MPMCutParts(dim);
  count = SPLIT * Parts(b, dim, place, sum);
  for (PetscInt d = 0; d < dim; d++) sum[d] *= SPLIT;
  for (PetscInt k = 0; k < nout; k++) {
    const Outer *o;

    Neighbour(b, dim, ijk, out[k], to, y);
    o = Find(b, dim, places, to, y);
    if (!o->parts || !(o->takers >> (places - 1 - out[k]) & 1)) continue; /* this place, seen from there */
    count += o->parts * (SPLIT / o->sharing);
    for (PetscInt d = 0; d < dim; d++)
      sum[d] += (o->sum[d] + (PetscReal)(o->parts * (PetscInt)(to[d] - ijk[d]))) * (PetscReal)(SPLIT / o->sharing);
  }
  count = PetscMax(1, count); /* a shape thinner than a part may lie between their centres */
  for (PetscInt d = 0; d < dim; d++) X[d] += sum[d] / (PetscReal)count * b->b[d];
  return count;
}

/* Returns the most parts that a particle can have. */
static PetscInt Most(PetscInt dim)
{
  PetscInt n = MPMCutParts(dim);

  for (PetscInt d = 0; d < dim; d++) n *= 3;
  return n;
}

/* --- Kinds -------------------------------------------------------------------------------------------------------- */

/* Returns the kind of a particle of a body of revolution, before it is in the table. row: that of a whole place. */
static MPMKind Ring(const MPMScene *scene, const MPMCore *core, const MPMBody *b, const PetscReal place[],
                    PetscInt parts, const PetscReal X[], PetscInt *row)
{
  const PetscReal share = (PetscReal)parts / (PetscReal)MPMCutParts(2) * (X[0] / MPMAtWallsRadius(b, place[0]));
  MPMKind         kind;

  *row = MPMAtWallsKind(scene, core, b, place);
  kind = scene->kinds[*row];
  kind.V0 *= share;
  kind.m *= share;
  return kind;
}

/* Compares kinds by their volumes and masses. */
static int Compare(const void *first, const void *second)
{
  const MPMKind *a = (const MPMKind *)first, *b = (const MPMKind *)second;

  return a->V0 != b->V0 ? (a->V0 < b->V0 ? -1 : 1) : a->m != b->m ? (a->m < b->m ? -1 : 1) : 0;
}

/* Sorts n kinds and leaves one of those that are equal. */
static void Unique(MPMKind rings[], PetscInt *n)
{
  PetscInt last = 0;

  qsort(rings, (size_t)*n, sizeof *rings, Compare);
  for (PetscInt k = 1; k < *n; k++)
    if (Compare(rings + last, rings + k)) rings[++last] = rings[k];
  *n = PetscMin(*n, last + 1);
}

PetscErrorCode MPMCutNote(const MPMScene *scene, const MPMCore *core, MPMBody *b, const PetscReal place[],
                          PetscInt parts, const PetscReal X[])
{
  PetscInt row;

  PetscFunctionBeginUser;
  b->parts += parts;
  if (b->cut) b->cut[parts] = 1;
  if (b->memo && b->round) {
    const MPMKind kind = Ring(scene, core, b, place, parts, X, &row);

    if (!Compare(&kind, scene->kinds + row)) PetscFunctionReturn(PETSC_SUCCESS);
    if ((b->nrings & (b->nrings + 1)) == 0)
      PetscCall(PetscRealloc((size_t)(2 * b->nrings + 1) * sizeof kind, &b->rings)); /* there is room for 2^k - 1 */
    b->rings[b->nrings++] = kind;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCutBegin(MPMBody *b, PetscInt dim)
{
  PetscFunctionBeginUser;
  if (b->memo && !b->round) PetscCall(PetscCalloc1(Most(dim) + 1, &b->cut));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the kinds of cut places that any process has found to the table, sorted. Collective on comm. */
static PetscErrorCode GatherRings(MPMScene *scene, MPI_Comm comm, MPMBody *b)
{
  PetscMPIInt size, bytes, *count, *from;
  PetscInt    all = 0;
  MPMKind    *rings;

  PetscFunctionBeginUser;
  Unique(b->rings, &b->nrings);
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMalloc2(size, &count, size, &from));
  bytes = (PetscMPIInt)((size_t)b->nrings * sizeof *rings);
  PetscCallMPI(MPI_Allgather(&bytes, 1, MPI_INT, count, 1, MPI_INT, comm));
  for (PetscMPIInt k = 0; k < size; all += count[k++]) from[k] = (PetscMPIInt)all;
  PetscCall(PetscMalloc1(all / (PetscInt)sizeof *rings, &rings));
  PetscCallMPI(MPI_Allgatherv(b->rings, bytes, MPI_BYTE, rings, count, from, MPI_BYTE, comm));
  all /= (PetscInt)sizeof *rings;
  Unique(rings, &all);
  scene->ncut += all > 0;
  PetscCall(MPMKindsRoom(scene, all + scene->nbodies));
  PetscCall(PetscArraycpy(scene->kinds + scene->nkinds, rings, all));
  b->nrings = all;
  b->ring   = scene->nkinds;
  scene->nkinds += all;
  PetscCall(PetscFree(rings));
  PetscCall(PetscFree(b->rings));
  PetscCall(PetscFree2(count, from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCutEnd(MPMScene *scene, const MPMCore *core, MPMBody *b)
{
  const PetscInt dim = core->grid.dim, whole = MPMCutParts(dim), most = Most(dim);
  const MPMKind  own = scene->kinds[b->kind];
  PetscInt       n   = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &b->parts, 1, MPIU_INT64, MPI_SUM, core->comm));
  if (!b->memo) PetscFunctionReturn(PETSC_SUCCESS);
  if (b->round) {
    PetscCall(GatherRings(scene, core->comm, b));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, b->cut, (PetscMPIInt)(most + 1), MPIU_INT, MPI_MAX, core->comm));
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

PetscInt MPMCutKind(const MPMScene *scene, const MPMCore *core, const MPMBody *b, const PetscReal place[],
                    PetscInt parts, const PetscReal X[])
{
  PetscInt row, from = b->ring, to = b->ring + b->nrings; /* it is in from .. to-1 */
  MPMKind  kind;

  if (!b->columns) return parts == MPMCutParts(core->grid.dim) ? b->kind : b->cut[parts];
  if (!b->memo) return MPMAtWallsKind(scene, core, b, place);
  kind = Ring(scene, core, b, place, parts, X, &row);
  if (!Compare(&kind, scene->kinds + row)) return row;
  while (to - from > 1) {
    const PetscInt middle = (from + to) / 2;

    if (Compare(&kind, scene->kinds + middle) < 0)
      to = middle;
    else
      from = middle;
  }
  return from;
}
