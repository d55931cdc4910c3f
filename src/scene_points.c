/* scene_points.c - the points that fill the bodies of a scene.

   Points lie on the lattice (i+1/2) b + offset, b = h/ppc, anchored at the origin of space, wherever the body's shape
   is; numbered body by body in the order of -bodies, with x in the outer loop: a rule that knows no processes. */
#include <unistd.h>
#include "cell.h"

/* A walk over the points of a body in the order of their numbers, a run of neighbours along the last axis at a time. */
typedef struct {
  const MPMBody *body;
  PetscInt       dim;
  PetscInt64     first[3], last[3]; /* the range of lattice places that covers the body */
  PetscInt64     ijk[3], n;         /* the run: its first place and its length */
  PetscInt64     id;                /* the number of its first point */
} Walk;

static Walk WalkStart(const MPMBody *b, PetscInt dim)
{
  Walk      w = {b, dim, {0}, {0}, {0}, 0, b->first};
  PetscReal lower[3], upper[3];

  MPMRegionBounds(&b->region, dim, lower, upper);
  for (PetscInt d = 0; d < dim; d++) {
    w.ijk[d] = w.first[d] = (PetscInt64)PetscFloorReal((lower[d] - b->offset[d]) / b->b[d] - 0.5);
    w.last[d]             = (PetscInt64)PetscCeilReal((upper[d] - b->offset[d]) / b->b[d] - 0.5);
  }
  return w;
}

/* The position X of the point at place k of the walk's row. */
static void PlaceOf(const Walk *w, PetscInt64 k, PetscReal X[3])
{
  const MPMBody *b = w->body;

  for (PetscInt d = 0; d < w->dim; d++)
    X[d] = ((PetscReal)(d == w->dim - 1 ? k : w->ijk[d]) + 0.5) * b->b[d] + b->offset[d];
}

static PetscBool Inside(const Walk *w, PetscInt64 k)
{
  PetscReal X[3];

  PlaceOf(w, k, X);
  return MPMRegionInside(&w->body->region, w->dim, X);
}

/* Of the places between one inside and one outside of the body, the last inside. */
static PetscInt64 LastInside(const Walk *w, PetscInt64 inside, PetscInt64 outside)
{
  while (PetscAbs(outside - inside) > 1) {
    const PetscInt64 middle = inside + (outside - inside) / 2;

    if (Inside(w, middle))
      inside = middle;
    else
      outside = middle;
  }
  return inside;
}

/* Finds the next run of the row, at or after where the walk is. In a solid body it is around the middle, so that not
   every point need be looked at: each process walks over all points, but these may be billions. */
static PetscBool FindRun(Walk *w)
{
  const PetscInt   d    = w->dim - 1;
  const MPMBody   *b    = w->body;
  const PetscInt64 last = w->last[d];
  PetscInt64       from = w->ijk[d], to;
  PetscReal        lower[3], upper[3];

  if (MPMRegionSolid(&b->region)) {
    PetscInt64 middle;

    if (from > w->first[d]) return PETSC_FALSE; /* there was one */
    MPMRegionBounds(&b->region, w->dim, lower, upper);
    middle = (PetscInt64)PetscFloorReal((0.5 * (lower[d] + upper[d]) - b->offset[d]) / b->b[d] - 0.5);
    middle = PetscMin(PetscMax(middle, from), last);
    if (!Inside(w, middle) && (middle == last || !Inside(w, ++middle))) return PETSC_FALSE;
    from = LastInside(w, middle, from - 1);
    to   = LastInside(w, middle, last + 1) + 1;
  } else {
    while (from <= last && !Inside(w, from)) from++;
    for (to = from; to <= last && Inside(w, to);) to++;
  }
  w->ijk[d] = from;
  w->n      = to - from;
  return w->n > 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* Goes to the next run. False when there are no more; id is then the number after the last point's. */
static PetscBool WalkNext(Walk *w)
{
  const PetscInt d = w->dim - 1;

  w->id += w->n;
  w->ijk[d] += w->n;
  w->n = 0;
  while (!FindRun(w)) {
    PetscInt e = d - 1;

    w->ijk[d] = w->first[d];
    for (; e >= 0 && w->ijk[e] == w->last[e]; e--) w->ijk[e] = w->first[e];
    if (e < 0) return PETSC_FALSE;
    w->ijk[e]++;
  }
  return PETSC_TRUE;
}

static PetscErrorCode CheckPoint(MPM mpm, MPMOptions o, const MPMBody *b, const PetscReal X[])
{
  const PetscInt dim     = mpm->grid.dim;
  PetscReal      v[3]    = {0}, xi[3], x[3];
  PetscBool      on_line = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(x, X, dim));
  (void)MPMKnownStart(&mpm->scene, dim, X, x, v, NULL);
  for (PetscInt d = 0; d < dim; d++)
    if (!(x[d] >= mpm->grid.lower[d] && x[d] <= mpm->grid.upper[d]))
      MPMOptionsFail(o, "body %s lies outside of the grid: its point at %c = %g, the grid from %g to %g", b->name,
                     "xyz"[d], (double)x[d], (double)(mpm->grid.lower[d]), (double)(mpm->grid.upper[d]));
  if (b->velocity) PetscCall(MPMExpressionEvaluate(b->velocity, dim, X, NULL, 0, v));
  for (PetscInt d = 0; d < dim; d++)
    if (!(PetscAbsReal(v[d]) <= PETSC_MAX_REAL))
      MPMOptionsFail(o, "-body_%s_velocity is not finite at x = %g%s", b->name, (double)x[0], dim > 1 ? ", ..." : "");
  PetscCall(MPMForcesCheck(mpm, o, x, X));
  for (PetscInt d = 0; d < dim; d++) xi[d] = (x[d] - mpm->grid.lower[d]) / mpm->grid.h[d];
  for (PetscInt d = 0; d < dim; d++)
    if (xi[d] == PetscFloorReal(xi[d])) on_line = PETSC_TRUE;
  mpm->scene.on_line += on_line;
  for (PetscInt k = 0; k < mpm->scene.nbodies; k++)
    if (mpm->scene.bodies + k < b && MPMRegionInside(&mpm->scene.bodies[k].region, dim, X)) mpm->scene.overlap++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses what does not fit into the memory of this machine, shared by `processes`. */
static void CheckMemory(MPMOptions o, const char what[], PetscReal number, PetscReal bytes, PetscMPIInt processes)
{
  const PetscReal have = (PetscReal)sysconf(_SC_PHYS_PAGES) * (PetscReal)sysconf(_SC_PAGESIZE), gb = 1e9;

  if (have > 0 && number * bytes / processes > have)
    MPMOptionsFail(o, "%s: %g of them need %.3g GB, this machine has %.3g", what, (double)number,
                   (double)(number * bytes / gb), (double)(have / gb));
}

/* The kind of a body, shared with earlier bodies of the same material and point size. */
static void FindKind(MPMScene *scene, MPMOptions o, PetscInt dim, MPMBody *b)
{
  MPMKind kind = {b->material, 0, 1, {0}};

  for (PetscInt d = 0; d < dim; d++) {
    kind.V0 *= b->b[d];
    kind.l[d] = 0.5 / (PetscReal)b->ppc[d];
  }
  kind.m = scene->materials[b->material].rho * kind.V0;
  if (!(kind.V0 > 0 && kind.m > 0 && kind.m < PETSC_MAX_REAL))
    MPMOptionsFail(o, "body %s: a point of volume %g and mass %g is beyond the range of numbers", b->name,
                   (double)kind.V0, (double)kind.m);
  for (b->kind = 0; b->kind < scene->nkinds; b->kind++)
    if (scene->kinds[b->kind].material == kind.material && scene->kinds[b->kind].V0 == kind.V0 &&
        !memcmp(scene->kinds[b->kind].l, kind.l, sizeof kind.l))
      return;
  scene->kinds[scene->nkinds++] = kind;
}

/* Sets the lattice of a body, adds about the number of its points to places, and checks that it lies in the grid. */
static void SetLattice(MPM mpm, MPMOptions o, MPMBody *b, PetscReal *places)
{
  const MPMGrid *grid = &mpm->grid;
  PetscReal      lower[3], upper[3], product = 1;

  MPMRegionBounds(&b->region, grid->dim, lower, upper);
  for (PetscInt d = 0; d < grid->dim; d++) {
    b->b[d] = grid->h[d] / b->ppc[d];
    product *= PetscMax(0, (PetscMin(upper[d], grid->upper[d]) - PetscMax(lower[d], grid->lower[d])) / b->b[d]) + 3;
    if (!(upper[d] <= grid->upper[d] + b->b[d] && lower[d] >= grid->lower[d] - b->b[d]))
      MPMOptionsFail(o, "body %s lies outside of the grid: it reaches from %c = %g to %g, the grid from %g to %g",
                     b->name, "xyz"[d], (double)lower[d], (double)upper[d], (double)(grid->lower[d]),
                     (double)(grid->upper[d]));
    if (PetscAbsReal(b->offset[d]) > 1e9 * b->b[d])
      MPMOptionsFail(o, "-body_%s_offset %g: choose a smaller one; every multiple of %g gives the same lattice",
                     b->name, (double)b->offset[d], (double)b->b[d]);
  }
  *places += product;
}

/* Checks that the points lie in the grid and start with finite velocities, each process a part of them. The first fault
   becomes that of all. Collective on comm. */
static PetscErrorCode CheckPoints(MPM mpm, MPMOptions o)
{
  MPMScene   *scene = &mpm->scene;
  PetscMPIInt size, rank;
  PetscInt64  lo, hi;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(mpm->comm, &size));
  PetscCallMPI(MPI_Comm_rank(mpm->comm, &rank));
  lo = mpm->points.total * rank / size;
  hi = mpm->points.total * (rank + 1) / size;
  for (PetscInt k = 0; k < scene->nbodies && !MPMOptionsError(o); k++) {
    Walk      w = WalkStart(&scene->bodies[k], mpm->grid.dim);
    PetscReal X[3];

    while (WalkNext(&w))
      for (PetscInt64 q = PetscMax(0, lo - w.id); q < PetscMin(w.n, hi - w.id) && !MPMOptionsError(o); q++) {
        PlaceOf(&w, w.ijk[w.dim - 1] + q, X);
        PetscCall(CheckPoint(mpm, o, w.body, X));
      }
  }
  PetscCall(MPMOptionsShare(o, mpm->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->on_line, 1, MPIU_INT64, MPI_SUM, mpm->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->overlap, 1, MPIU_INT64, MPI_SUM, mpm->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lays out the points without making them: numbers them, finds the kinds, and checks what can be wrong. Faults are left
   in o. Collective on comm.                                                                                          */
PetscErrorCode MPMSceneCountPoints(MPM mpm, MPMOptions o)
{
  MPMScene      *scene  = &mpm->scene;
  const PetscInt dim    = mpm->grid.dim;
  PetscInt64     total  = 0;
  PetscReal      places = 0;
  PetscMPIInt    size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(mpm->comm, &size));
  CheckMemory(o, "nodes of the grid", MPMGridNodes(&mpm->grid, mpm->basis),
              (PetscReal)(MPM_SUM_NC(dim) + MPM_VEL_NC(dim)) * sizeof(PetscReal), size);
  PetscCall(PetscCalloc1(scene->nbodies, &scene->kinds));
  for (PetscInt k = 0; k < scene->nbodies && !MPMOptionsError(o); k++) {
    MPMBody *b = &scene->bodies[k];
    Walk     w;

    SetLattice(mpm, o, b, &places);
    if (places * (1 + 2 * dim + dim * dim) > (PetscReal)PETSC_MAX_INT)
      MPMOptionsFail(o, "body %s: with it the scene has about %g points, more than this PETSc can number", b->name,
                     (double)places);
    if (MPMOptionsError(o)) break;
    b->first = total;
    for (w = WalkStart(b, dim); WalkNext(&w);) continue;
    total = w.id;
    b->n  = total - b->first;
    if (!b->n) MPMOptionsFail(o, "body %s has no points: no lattice point (i+1/2) h/ppc + offset lies in it", b->name);
    FindKind(scene, o, dim, b);
  }
  CheckMemory(o, "points", (PetscReal)total, (PetscReal)(1 + 2 * dim + dim * dim) * sizeof(PetscReal), size);
  mpm->points.total = total;
  PetscCall(CheckPoints(mpm, o)); /* with a fault too: machines may differ in what fits into their memory */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where a point of the body starts, x [dim] in m, and the half-widths l [dim] of its domain in cells. */
static void StartPlace(MPM mpm, const MPMBody *b, const PetscReal X[], PetscReal x[], PetscReal l[])
{
  const PetscInt dim = mpm->grid.dim;
  PetscReal      F[9], V[3] = {1, 1, 1};

  for (PetscInt d = 0; d < dim; d++) x[d] = X[d];
  if (MPMKnownStart(&mpm->scene, dim, X, x, NULL, F) && mpm->stretched) MPMStretch((int)dim, F, V);
  for (PetscInt d = 0; d < dim; d++) l[d] = PetscMin(0.5, mpm->scene.kinds[b->kind].l[d] * V[d]);
}

/* Base nodes (from 0, layers included) on the last axis of the places of a body's rows, undeformed: first .. last. */
static PetscErrorCode LastBases(MPM mpm, const Walk *w, PetscInt **bases)
{
  const PetscInt d = w->dim - 1;
  PetscReal      X[3], xi;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(w->last[d] - w->first[d] + 1, bases));
  for (PetscInt64 k = w->first[d]; k <= w->last[d]; k++) {
    PlaceOf(w, k, X);
    (*bases)[k - w->first[d]] = mpm->grid.layers[d] + MPMCoordinate(mpm->basis, &mpm->grid, (int)d, X[d],
                                                                    mpm->scene.kinds[w->body->kind].l[d], &xi);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the points of the scene, as they will start, by the base node of their stencils. Not collective: every process
   counts all, cell by cell where they start undeformed.                                                              */
PetscErrorCode MPMSceneHistogram(MPM mpm, MPMHistogram *h)
{
  const PetscInt  dim = mpm->grid.dim, axis = dim - 1;
  const PetscBool moved = MPMKnownStarts(&mpm->scene);

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < mpm->scene.nbodies; k++) {
    Walk      w = WalkStart(&mpm->scene.bodies[k], dim);
    PetscReal X[3], x[3], l[3], xi[3];
    PetscInt  base[3] = {0}, *bases;

    PetscCall(LastBases(mpm, &w, &bases));
    while (WalkNext(&w))
      for (PetscInt64 q = 0, same; q < w.n; q += same) {
        const PetscInt *last = bases + w.ijk[axis] - w.first[axis];

        same = 1;
        if (!q || moved) {
          PlaceOf(&w, w.ijk[axis] + q, X);
          StartPlace(mpm, w.body, X, x, l);
          (void)MPMLocate((int)dim, mpm->basis, &mpm->grid, x, l, xi, base);
          for (PetscInt d = 0; d < dim; d++) base[d] += mpm->grid.layers[d];
        }
        if (!moved)
          for (base[axis] = last[q]; q + same < w.n && last[q + same] == last[q];) same++;
        MPMHistogramAdd(h, base, same);
      }
    PetscCall(PetscFree(bases));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The sides of the point at x on which its neighbour on the lattice is not in the body: bit 2d + side. */
static PetscInt SurfaceSides(const MPMBody *b, PetscInt dim, const PetscReal x[])
{
  PetscInt sides = 0;

  for (PetscInt k = 0; k < 2 * dim; k++) {
    PetscReal y[3];

    for (PetscInt d = 0; d < dim; d++) y[d] = x[d] + (d == k / 2 ? (k % 2 ? 1 : -1) * b->b[d] : 0);
    if (!MPMRegionInside(&b->region, dim, y)) sides |= (PetscInt)1 << k;
  }
  return sides;
}

/* Makes point p of a view: undeformed at X, or as the scene's known solution starts. */
static PetscErrorCode SetPoint(MPM mpm, const MPMBody *b, PetscInt64 id, const PetscReal X[], PetscInt p, MPMView *view)
{
  const PetscInt dim  = mpm->grid.dim;
  PetscReal      v[3] = {0}, x[3], F[9], l[3];

  PetscFunctionBeginUser;
  StartPlace(mpm, b, X, x, l);
  if (b->velocity) PetscCall(MPMExpressionEvaluate(b->velocity, dim, X, NULL, 0, v));
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  if (view->name)                                                                                                      \
    for (PetscInt k = 0; k < MPMComponents_##name((int)dim); k++)                                                      \
      view->name[p * MPMComponents_##name((int)dim) + k] = start;
#include "fields.def"
#undef MPM_FIELD
  if (MPMKnownStart(&mpm->scene, dim, X, x, v, F))
    for (PetscInt k = 0; k < dim * dim && view->F; k++) view->F[p * dim * dim + k] = F[k];
  view->id[p] = id;
  if (view->kind) view->kind[p] = b->kind;
  if (view->surface) view->surface[p] = SurfaceSides(b, dim, X);
  for (PetscInt d = 0; d < dim; d++) {
    view->x[p * dim + d] = x[d];
    view->v[p * dim + d] = v[d];
    if (view->X) view->X[p * dim + d] = X[d];
    if (view->l) view->l[p * dim + d] = l[d];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The places of a body's lattice, lo .. hi on each axis, where points of this process's patch can be: exact tests
 * follow.
 */
static void OwnPlaces(MPM mpm, const Walk *w, PetscInt64 lo[3], PetscInt64 hi[3])
{
  const MPMGrid  *grid  = &mpm->grid;
  const MPMPatch *patch = &mpm->exchange.patch;
  const MPMBody  *b     = w->body;

  for (PetscInt d = 0; d < w->dim; d++) {
    const PetscReal below = patch->own_lo[d] - 1,
                    above = patch->own_lo[d] + patch->own_n[d] + MPMBasisNodes(mpm->basis);

    lo[d] = w->first[d];
    hi[d] = w->last[d];
    if (grid->periodic[d] || MPMKnownStarts(&mpm->scene)) continue;
    lo[d] = (PetscInt64)PetscFloorReal((grid->lower[d] + below * grid->h[d] - b->offset[d]) / b->b[d]) - 1;
    hi[d] = (PetscInt64)PetscCeilReal((grid->lower[d] + above * grid->h[d] - b->offset[d]) / b->b[d]) + 1;
  }
}

/* Makes the points of this process's patch, undeformed (F = I), with their start velocities. Not collective. */
PetscErrorCode MPMSceneAddPoints(MPM mpm)
{
  MPMScene       *scene = &mpm->scene;
  const MPMPatch *patch = &mpm->exchange.patch;
  const PetscInt  dim = mpm->grid.dim, axis = dim - 1;
  const PetscInt  fields = -1;
  MPMView         view;

  PetscFunctionBeginUser;
  for (int pass = 0; pass < 2; pass++) { /* count, then make */
    PetscInt p = 0;

    if (pass) PetscCall(MPMPointsGetView(&mpm->points, fields, &view));
    for (PetscInt k = 0; k < scene->nbodies; k++) {
      Walk       w = WalkStart(&scene->bodies[k], dim);
      PetscInt64 lo[3], hi[3];
      PetscReal  X[3], x[3], l[3];
      PetscInt   base[3] = {0};

      OwnPlaces(mpm, &w, lo, hi);
      while (WalkNext(&w)) {
        const PetscInt64 from = w.ijk[axis];
        PetscBool        near = PETSC_TRUE;

        for (PetscInt d = 0; d < axis; d++)
          if (w.ijk[d] < lo[d] || w.ijk[d] > hi[d]) near = PETSC_FALSE;
        for (PetscInt64 q = PetscMax(from, lo[axis]); near && q <= PetscMin(from + w.n - 1, hi[axis]); q++) {
          PlaceOf(&w, q, X);
          StartPlace(mpm, w.body, X, x, l);
          if (MPMOwnCell((int)dim, mpm->basis, patch, x, l, base) < 0) continue;
          if (pass) PetscCall(SetPoint(mpm, w.body, w.id + q - from, X, p, &view));
          p++;
        }
      }
    }
    if (!pass) PetscCall(MPMPointsSetSize(&mpm->points, p));
  }
  PetscCall(MPMPointsRestoreView(&mpm->points, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}
