/* scene_points.c - the points that fill the bodies of a scene.

   Points lie on the lattice (i+1/2) b + offset, b = h/ppc, anchored at the origin of space, wherever the body's shape
   is; numbered body by body in the order of -bodies, with x in the outer loop: a rule that knows no processes. */
#include <unistd.h>
#include "cell.h"

/* The range of lattice numbers that covers the body, on one axis. */
static void LatticeRange(const MPMBody *b, PetscInt dim, PetscInt64 first[3], PetscInt64 last[3])
{
  PetscReal lower[3], upper[3];

  MPMRegionBounds(&b->region, dim, lower, upper);
  for (PetscInt d = 0; d < 3; d++) {
    first[d] = d < dim ? (PetscInt64)PetscFloorReal((lower[d] - b->offset[d]) / b->b[d] - 0.5) : 0;
    last[d]  = d < dim ? (PetscInt64)PetscCeilReal((upper[d] - b->offset[d]) / b->b[d] - 0.5) : 0;
  }
}

/* Walks the points of a body in the order of their numbers: the next one at or after lattice place ijk, whose position
   goes to x; ijk is left there. False when there are no more.                                                        */
static PetscBool NextPoint(const MPMBody *b, PetscInt dim, const PetscInt64 first[3], const PetscInt64 last[3],
                           PetscInt64 ijk[3], PetscReal x[3])
{
  for (; ijk[0] <= last[0]; ijk[0]++, ijk[1] = first[1])
    for (; ijk[1] <= last[1]; ijk[1]++, ijk[2] = first[2])
      for (; ijk[2] <= last[2]; ijk[2]++) {
        for (PetscInt d = 0; d < dim; d++) x[d] = ((PetscReal)ijk[d] + 0.5) * b->b[d] + b->offset[d];
        if (MPMRegionInside(&b->region, dim, x)) return PETSC_TRUE;
      }
  return PETSC_FALSE;
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

/* Lays out the points without making them: numbers them, checks that they lie in the grid and start with finite
   velocities, and finds the kinds. Faults are left in o. Not collective.                                             */
PetscErrorCode MPMSceneCountPoints(MPM mpm, MPMOptions o)
{
  MPMScene      *scene  = &mpm->scene;
  const PetscInt dim    = mpm->grid.dim;
  PetscInt64     total  = 0;
  PetscReal      places = 0, nodes = 1;
  PetscMPIInt    size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(mpm->comm, &size));
  for (PetscInt d = 0; d < dim; d++) nodes *= mpm->grid.cells[d] + 1.0;
  CheckMemory(o, "nodes of the grid", nodes, (PetscReal)(MPM_SUM_NC(dim) + MPM_VEL_NC(dim)) * sizeof(PetscReal), size);
  PetscCall(PetscCalloc1(scene->nbodies, &scene->kinds));
  for (PetscInt k = 0; k < scene->nbodies && !MPMOptionsError(o); k++) {
    MPMBody   *b = &scene->bodies[k];
    PetscInt64 first[3], last[3], ijk[3];
    PetscReal  x[3];

    SetLattice(mpm, o, b, &places);
    if (places * (1 + 2 * dim + dim * dim) > (PetscReal)PETSC_MAX_INT)
      MPMOptionsFail(o, "body %s: with it the scene has about %g points, more than this PETSc can number", b->name,
                     (double)places);
    if (MPMOptionsError(o)) break;
    LatticeRange(b, dim, first, last);
    PetscCall(PetscArraycpy(ijk, first, 3));
    for (b->first = total; NextPoint(b, dim, first, last, ijk, x) && !MPMOptionsError(o); ijk[2]++, total++)
      PetscCall(CheckPoint(mpm, o, b, x));
    b->n = total - b->first;
    if (!b->n) MPMOptionsFail(o, "body %s has no points: no lattice point (i+1/2) h/ppc + offset lies in it", b->name);
    FindKind(scene, o, dim, b);
  }
  CheckMemory(o, "points", (PetscReal)total, (PetscReal)(1 + 2 * dim + dim * dim) * sizeof(PetscReal), size);
  mpm->points.total = total;
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

/* Counts the points of the scene, as they will start, by the base node of their stencils. Not collective: every process
   counts all.                                                                                                        */
PetscErrorCode MPMSceneHistogram(MPM mpm, MPMHistogram *h)
{
  const PetscInt dim = mpm->grid.dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < mpm->scene.nbodies; k++) {
    const MPMBody *b = &mpm->scene.bodies[k];
    PetscInt64     first[3], last[3], ijk[3];
    PetscReal      X[3], x[3], l[3], xi[3];
    PetscInt       base[3] = {0};

    LatticeRange(b, dim, first, last);
    PetscCall(PetscArraycpy(ijk, first, 3));
    for (; NextPoint(b, dim, first, last, ijk, X); ijk[2]++) {
      StartPlace(mpm, b, X, x, l);
      (void)MPMLocate((int)dim, mpm->basis, &mpm->grid, x, l, xi, base);
      for (PetscInt d = 0; d < dim; d++) base[d] += mpm->grid.layers[d];
      MPMHistogramAdd(h, base);
    }
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

/* Makes the points of this process's patch, undeformed (F = I), with their start velocities. Not collective. */
PetscErrorCode MPMSceneAddPoints(MPM mpm)
{
  MPMScene       *scene  = &mpm->scene;
  const MPMPatch *patch  = &mpm->exchange.patch;
  const PetscInt  dim    = mpm->grid.dim;
  const PetscInt  fields = -1;
  MPMView         view;

  PetscFunctionBeginUser;
  for (int pass = 0; pass < 2; pass++) { /* count, then make */
    PetscInt64 id = 0;
    PetscInt   p  = 0;

    if (pass) PetscCall(MPMPointsGetView(&mpm->points, fields, &view));
    for (PetscInt k = 0; k < scene->nbodies; k++) {
      const MPMBody *b = &scene->bodies[k];
      PetscInt64     first[3], last[3], ijk[3];
      PetscReal      X[3], x[3], l[3];
      PetscInt       base[3] = {0};

      LatticeRange(b, dim, first, last);
      PetscCall(PetscArraycpy(ijk, first, 3));
      for (; NextPoint(b, dim, first, last, ijk, X); ijk[2]++, id++) {
        StartPlace(mpm, b, X, x, l);
        if (MPMOwnCell((int)dim, mpm->basis, patch, x, l, base) < 0) continue;
        if (pass) PetscCall(SetPoint(mpm, b, id, X, p, &view));
        p++;
      }
    }
    if (!pass) PetscCall(MPMPointsSetSize(&mpm->points, p));
  }
  PetscCall(MPMPointsRestoreView(&mpm->points, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}
