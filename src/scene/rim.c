/* rim.c - where a body ends near a particle of its lattice at the start: for walls that act on arrival (step/gaps.c),
   and for loads, which act in the layers below the surface (physics/skin.h). The surface of a body may lie anywhere
   between the last place of the lattice in the body and the next one, and it may slant or be curved, while the last
   particles are steps. All that is asked of a shape is whether a place lies in it. */
#include "physics/skin.h"
#include "scene/cut.h"
#include "scene/rim.h"

#define HALVINGS 20     /* of an interval of a few spacings */
#define EDGE     0.3    /* difference of slopes on both sides, above which they are those of different faces */
#define NEARER   0.0625 /* by how much */

/* Returns whether the place that is `by` m from x [dim], m, along axis k / 2, towards its upper end if k is odd, lies
   in the body. */
static PetscBool Inside(const MPMBody *b, PetscInt dim, const PetscReal x[], PetscInt k, PetscReal by)
{
  PetscReal y[3] = {0};

  for (PetscInt d = 0; d < dim; d++) y[d] = x[d] + (d == k / 2 ? (k % 2 ? by : -by) : 0);
  if (b->round) y[0] = PetscAbsReal(y[0]); /* beyond the axis is the mirror image */
  return MPMRegionInside(&b->region, dim, y);
}

/* Returns how far the surface is from x [dim], m, along axis k / 2, towards its upper end if k is odd, between `in`, a
   distance at which the place is in the body, and `out`, one at which it is not. */
static PetscReal Exit(const MPMBody *b, PetscInt dim, const PetscReal x[], PetscInt k, PetscReal in, PetscReal out)
{
  for (int n = 0; n < HALVINGS; n++) {
    const PetscReal middle = 0.5 * (in + out);

    if (Inside(b, dim, x, k, middle))
      in = middle;
    else
      out = middle;
  }
  return 0.5 * (in + out);
}

/* Finds the distance along side k at x + by along axis e, in whose neighbourhood it is `near`. Returns whether there is
   one between a spacing inside and two outside. */
static PetscBool Beside(const MPMBody *b, PetscInt dim, const PetscReal x[], PetscInt k, PetscInt e, PetscReal by,
                        PetscReal *at)
{
  const PetscReal spacing = b->b[k / 2];
  PetscReal       y[3], in = 0;

  for (PetscInt d = 0; d < dim; d++) y[d] = x[d] + (d == e ? by : 0);
  if (!Inside(b, dim, y, k, in)) in = -spacing;
  if (!Inside(b, dim, y, k, in) || Inside(b, dim, y, k, 2 * spacing)) return PETSC_FALSE;
  *at = Exit(b, dim, y, k, in, 2 * spacing);
  return PETSC_TRUE;
}

void MPMRim(const MPMBody *b, PetscInt dim, PetscInt faces, PetscBool own, const PetscReal x[], const PetscReal X[],
            PetscReal rim[])
{
  PetscInt  side = -1;
  PetscReal far = PETSC_INFINITY, size = 1, moved = 0;

  for (PetscInt d = 0; d < dim; d++) rim[d] = 0;
  for (int only = 1; only >= 0 && side < 0;
       only--) /* the nearest side on which the neighbour is missing, at a wall first */
    for (PetscInt k = 0; k < 2 * dim; k++) {
      PetscReal at;

      if ((only && !(faces & (PetscInt)1 << k)) || Inside(b, dim, x, k, b->b[k / 2])) continue;
      at = Exit(b, dim, x, k, 0, b->b[k / 2]);
      if (at >= far) continue;
      far  = at;
      side = k;
    }
  if (side < 0) return;
  for (PetscInt e = 0; e < dim;
       e++) { /* the normal of the plane through the surface there and half a spacing beside it */
    PetscReal by    = 0.5 * b->b[e];
    PetscReal lower = far, upper = far;
    PetscBool below, above;

    if (e == side / 2) {
      rim[e] = side % 2 ? 1 : -1;
      continue;
    }
    below = Beside(b, dim, x, side, e, -by, &lower);
    above = Beside(b, dim, x, side, e, by, &upper);
    if (own && below && above &&
        PetscAbsReal(lower + upper - 2 * far) > EDGE * by) { /* the normal of the face that it has there */
      by *= NEARER;
      below = Beside(b, dim, x, side, e, -by, &lower);
      above = Beside(b, dim, x, side, e, by, &upper);
    }
    if (below || above) rim[e] = (lower - upper) / (below && above ? 2 * by : by);
    size += rim[e] * rim[e];
  }
  for (PetscInt d = 0; d < dim; d++) moved += (X[d] - x[d]) * rim[d];
  for (PetscInt d = 0; d < dim; d++) rim[d] *= (far - moved) / size;
}

void MPMRimUndoStart(const MPMScene *scene, const MPMBody *b, PetscInt dim, const MPMView *view, PetscInt p)
{
  PetscReal *rim = view->rim + p * dim, cofactor[9], back[3] = {0};

  if (MPMMaterialKeepsShape(&scene->materials[b->material])) {
    const PetscReal *F = view->F + p * dim * dim;

    MPMCofactor((int)dim, F, cofactor); /* J F^-T */
    for (PetscInt d = 0; d < dim; d++)
      for (PetscInt e = 0; e < dim; e++) back[d] += cofactor[e * dim + d] * rim[e] / MPMDet((int)dim, F);
    for (PetscInt d = 0; d < dim; d++) rim[d] = back[d];
  } else if (scene->materials[b->material].type->traits & MPM_FLUID)
    for (PetscInt d = 0; d < dim; d++) rim[d] /= PetscPowReal(view->J[p], 1 / (b->round ? 3 : (PetscReal)dim));
}

/* Returns how many lattice places in sequence from x [dim], m, along side k are in the body, that of x too; at most
   `most`. */
static PetscInt Run(const MPMBody *b, PetscInt dim, const PetscReal x[], PetscInt k, PetscInt most)
{
  PetscInt n = 1;

  while (n < most && Inside(b, dim, x, k, (PetscReal)n * b->b[k / 2])) n++;
  return n;
}

/* Returns the area of a column of particles, over that of the lattice, that begins with the surface's particle at top
   [dim], m, along side k, and has so many layers, at most `most`: that of the innermost layer that takes a part of the
   load and is not cut along the column. */
static PetscReal Area(const MPMBody *b, PetscInt dim, const PetscReal top[], PetscInt k, PetscInt layers, PetscInt most)
{
  const PetscInt in = PetscMin(layers - 2, most - 1);
  PetscReal      x[3], X[3];

  if (in < 1) return 1;
  for (PetscInt d = 0; d < dim; d++) x[d] = top[d] + (d == k / 2 ? (PetscReal)(k % 2 ? -in : in) * b->b[d] : 0);
  return (PetscReal)MPMCut(b, dim, x, X) / (PetscReal)MPMCutParts(dim);
}

void MPMRimDepth(const MPMScene *scene, const MPMBody *b, PetscInt dim, const PetscReal x[], PetscInt depth[])
{
  for (PetscInt k = 0; k < 2 * dim; k++) {
    const PetscInt most   = 2 * MPMSkinWhole(b->ppc[k / 2]);
    PetscBool      loaded = PETSC_FALSE;
    PetscInt       out, layers, sides = 0;
    PetscReal      top[3] = {0};

    depth[k] = 0;
    for (PetscInt l = 0; l < scene->nloads; l++)
      if (scene->bodies + scene->loads[l].body == b && scene->loads[l].sides >> k & 1) loaded = PETSC_TRUE;
    if (!loaded || (out = Run(b, dim, x, k, most + 1)) > most) continue;
    layers = out - 1 + Run(b, dim, x, k ^ 1, most);
    for (PetscInt d = 0; d < dim; d++)
      top[d] = x[d] + (d == k / 2 ? (PetscReal)(k % 2 ? out - 1 : 1 - out) * b->b[d] : 0);
    if (b->round && top[0] < 0) continue; /* the surface beyond the axis is that of the other side */
    for (PetscInt e = 0; e < 2 * dim; e++) sides |= (PetscInt)(Run(b, dim, top, e, 2) == 1) << e;
    depth[k] = MPMSkinPack(out - 1, layers, sides, Area(b, dim, top, k, layers, most));
  }
}
