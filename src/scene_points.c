/* scene_points.c - the particles that fill the bodies of a scene.

   Particles lie on the lattice (i+1/2) b + offset, b = h/ppc, anchored at the origin of space, wherever the body's
   shape is; numbered body by body in the order of -bodies, with x in the outer loop: a rule that knows no processes. */
#include <unistd.h>
#include "cell.h"

/* A walk over rows of a body's particles, in the order of their numbers: a row is along the last axis, and has runs of
   neighbours. A body has as many rows as its lattice has places on the other axes, some without particles. */
typedef struct {
  const MPMBody *body;
  PetscInt       dim;
  PetscInt64     first[3], last[3]; /* the range of lattice places that covers the body */
  PetscInt64     row, end;          /* of the body's rows: where the walk is, and before which it ends */
  PetscInt64     ijk[3], n;         /* the run: its first place and its length */
  PetscInt64     id;                /* the number of its first particle */
} Walk;

/* The row of the places ijk. */
static PetscInt64 RowOf(const Walk *w, const PetscInt64 ijk[])
{
  PetscInt64 row = 0;

  for (PetscInt d = 0; d < w->dim - 1; d++) row = row * (w->last[d] - w->first[d] + 1) + ijk[d] - w->first[d];
  return row;
}

static void GoToRow(Walk *w, PetscInt64 row)
{
  w->row             = row;
  w->n               = 0;
  w->ijk[w->dim - 1] = w->first[w->dim - 1];
  for (PetscInt d = w->dim - 2; d >= 0; d--) {
    const PetscInt64 places = w->last[d] - w->first[d] + 1;

    w->ijk[d] = w->first[d] + row % places;
    row /= places;
  }
}

static Walk WalkStart(const MPMBody *b, PetscInt dim)
{
  Walk      w = {.body = b, .dim = dim, .id = b->first};
  PetscReal lower[3], upper[3];

  MPMRegionBounds(&b->region, dim, lower, upper);
  for (PetscInt d = 0; d < dim; d++) {
    w.first[d] = (PetscInt64)PetscFloorReal((lower[d] - b->offset[d]) / b->b[d] - 0.5);
    w.last[d]  = (PetscInt64)PetscCeilReal((upper[d] - b->offset[d]) / b->b[d] - 0.5);
  }
  w.end = RowOf(&w, w.last) + 1;
  GoToRow(&w, 0);
  return w;
}

/* The rows of all bodies in equal shares, one a process: the first of share k among the rows of a body. */
static PetscInt64 ShareRow(const MPMScene *scene, const MPMBody *b, PetscInt64 k, PetscMPIInt shares)
{
  return scene->rows * k / shares - b->row;
}

/* A walk over the rows of a body that are in this process's share. Its id means nothing. */
static Walk WalkShare(const MPMScene *scene, const MPMBody *b, PetscInt dim, PetscMPIInt rank, PetscMPIInt size)
{
  Walk w = WalkStart(b, dim);

  w.end = PetscMin(w.end, ShareRow(scene, b, rank + 1, size));
  GoToRow(&w, PetscMax(0, ShareRow(scene, b, rank, size)));
  return w;
}

/* The position X of the particle at place k of the walk's row. */
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
   every particle need be looked at: there may be billions. */
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

/* Goes to the next run. False when there are no more; id is then the number after the last particle's. */
static PetscBool WalkNext(Walk *w)
{
  w->id += w->n;
  w->ijk[w->dim - 1] += w->n;
  for (w->n = 0; w->row < w->end; GoToRow(w, w->row + 1))
    if (FindRun(w)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Takes a walk on to rows from .. to-1, from the last row before them where a share, whose first number is known,
   begins. */
static void WalkTo(const MPMScene *scene, Walk *w, PetscInt64 from, PetscInt64 to)
{
  const PetscInt64 share = ((w->body->row + from + 1) * scene->shares - 1) / scene->rows;
  const PetscInt64 row   = ShareRow(scene, w->body, share, scene->shares);

  if (row > w->row) {
    GoToRow(w, row);
    w->id = scene->share_first[share];
  }
  for (w->end = from; WalkNext(w);) continue;
  w->end = to;
}

static PetscErrorCode CheckParticle(MPM mpm, MPMOptions o, const MPMBody *b, const PetscReal X[])
{
  const PetscInt dim     = mpm->grid.dim;
  PetscReal      v[3]    = {0}, xi[3], x[3];
  PetscBool      on_line = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(x, X, dim));
  (void)MPMKnownStart(&mpm->scene, dim, X, x, v, NULL);
  for (PetscInt d = 0; d < dim; d++)
    if (!(x[d] >= mpm->grid.lower[d] && x[d] <= mpm->grid.upper[d]))
      MPMOptionsFail(o, "body %s lies outside of the grid: its particle at %c = %g, the grid from %g to %g", b->name,
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

/* The kind of a body, shared with earlier bodies of the same material and particle size. */
static void FindKind(MPMScene *scene, MPMOptions o, PetscInt dim, MPMBody *b)
{
  MPMKind kind = {b->material, 0, 1, {0}};

  for (PetscInt d = 0; d < dim; d++) {
    kind.V0 *= b->b[d];
    kind.l[d] = 0.5 / (PetscReal)b->ppc[d];
  }
  kind.m = scene->materials[b->material].rho * kind.V0;
  if (!(kind.V0 > 0 && kind.m > 0 && kind.m < PETSC_MAX_REAL))
    MPMOptionsFail(o, "body %s: a particle of volume %g and mass %g is beyond the range of numbers", b->name,
                   (double)kind.V0, (double)kind.m);
  for (b->kind = 0; b->kind < scene->nkinds; b->kind++)
    if (scene->kinds[b->kind].material == kind.material && scene->kinds[b->kind].V0 == kind.V0 &&
        !memcmp(scene->kinds[b->kind].l, kind.l, sizeof kind.l))
      return;
  scene->kinds[scene->nkinds++] = kind;
}

/* Sets the lattice of a body, adds about the number of its particles to places, and checks that it lies in the grid. */
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

/* Counts the particles of the bodies and before each share, and numbers them. Collective on comm. */
static PetscErrorCode Count(MPM mpm)
{
  MPMScene   *scene = &mpm->scene;
  PetscInt64  mine = 0, before = 0;
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(mpm->comm, &scene->shares));
  PetscCallMPI(MPI_Comm_rank(mpm->comm, &rank));
  PetscCall(PetscMalloc1(scene->shares, &scene->share_first));
  for (PetscInt k = 0; k < scene->nbodies; k++) {
    MPMBody *b = &scene->bodies[k];
    Walk     w = WalkShare(scene, b, mpm->grid.dim, rank, scene->shares);

    for (w.id = 0; WalkNext(&w);) continue;
    b->n = w.id;
    mine += b->n;
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &b->n, 1, MPIU_INT64, MPI_SUM, mpm->comm));
    b->first = mpm->particles.total;
    mpm->particles.total += b->n;
  }
  PetscCallMPI(MPI_Allgather(&mine, 1, MPIU_INT64, scene->share_first, 1, MPIU_INT64, mpm->comm));
  for (PetscInt k = 0; k < scene->shares; k++) {
    const PetscInt64 n = scene->share_first[k];

    scene->share_first[k] = before;
    before += n;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that the particles lie in the grid and start with finite velocities, each process those of its rows. The first
   fault becomes that of all. Collective on comm. */
static PetscErrorCode CheckParticles(MPM mpm, MPMOptions o)
{
  MPMScene   *scene = &mpm->scene;
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(mpm->comm, &rank));
  for (PetscInt k = 0; k < scene->nbodies && !MPMOptionsError(o); k++) {
    Walk      w = WalkShare(scene, &scene->bodies[k], mpm->grid.dim, rank, scene->shares);
    PetscReal X[3];

    while (WalkNext(&w))
      for (PetscInt64 q = 0; q < w.n && !MPMOptionsError(o); q++) {
        PlaceOf(&w, w.ijk[w.dim - 1] + q, X);
        PetscCall(CheckParticle(mpm, o, w.body, X));
      }
  }
  PetscCall(MPMOptionsShare(o, mpm->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->on_line, 1, MPIU_INT64, MPI_SUM, mpm->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->overlap, 1, MPIU_INT64, MPI_SUM, mpm->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lays out the particles without making them: numbers them, finds the kinds, and checks what can be wrong. Faults are
   left in o. Collective on comm. */
PetscErrorCode MPMSceneCountParticles(MPM mpm, MPMOptions o)
{
  MPMScene      *scene  = &mpm->scene;
  const PetscInt dim    = mpm->grid.dim;
  PetscReal      places = 0;
  PetscMPIInt    size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(mpm->comm, &size));
  CheckMemory(o, "nodes of the grid", MPMGridNodes(&mpm->grid, mpm->basis),
              (PetscReal)(MPM_SUM_NC(dim) + MPM_VEL_NC(dim)) * sizeof(PetscReal), size);
  for (PetscInt k = 0; k < scene->nbodies && !MPMOptionsError(o); k++) {
    MPMBody *b = &scene->bodies[k];

    SetLattice(mpm, o, b, &places);
    if (places * (1 + 2 * dim + dim * dim) > (PetscReal)PETSC_MAX_INT)
      MPMOptionsFail(o, "body %s: with it the scene has about %g particles, more than this PETSc can number", b->name,
                     (double)places);
    if (MPMOptionsError(o)) break;
    b->row = scene->rows;
    scene->rows += WalkStart(b, dim).end;
  }
  PetscCall(MPMOptionsShare(o, mpm->comm)); /* machines may differ in what fits into their memory */
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Count(mpm));
  PetscCall(PetscCalloc1(scene->nbodies, &scene->kinds));
  for (PetscInt k = 0; k < scene->nbodies; k++) {
    MPMBody *b = &scene->bodies[k];

    if (!b->n)
      MPMOptionsFail(o, "body %s has no particles: no lattice particle (i+1/2) h/ppc + offset lies in it", b->name);
    FindKind(scene, o, dim, b);
  }
  CheckMemory(o, "particles", (PetscReal)mpm->particles.total, (PetscReal)(1 + 2 * dim + dim * dim) * sizeof(PetscReal),
              size);
  PetscCall(CheckParticles(mpm, o)); /* with a fault too: others may have none */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where a particle of the body starts, x [dim] in m, and the half-widths l [dim] of its domain in cells. */
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

/* Counts the particles of the scene, as they will start, by the base node of their stencils, each process of the
   histogram those of its rows: cell by cell where they start undeformed. Not collective. */
PetscErrorCode MPMSceneHistogram(MPM mpm, MPMHistogram *h)
{
  const PetscInt  dim = mpm->grid.dim, axis = dim - 1;
  const PetscBool moved = MPMKnownStarts(&mpm->scene);
  PetscMPIInt     rank, size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(h->comm, &size));
  PetscCallMPI(MPI_Comm_rank(h->comm, &rank));
  for (PetscInt k = 0; k < mpm->scene.nbodies; k++) {
    Walk      w = WalkShare(&mpm->scene, &mpm->scene.bodies[k], dim, rank, size);
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
        PetscCall(MPMHistogramAdd(h, base, same));
      }
    PetscCall(PetscFree(bases));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The sides of the particle at x on which its neighbour on the lattice is not in the body: bit 2d + side. */
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

/* Makes particle p of a view: undeformed at X, or as the scene's known solution starts. */
static PetscErrorCode SetParticle(MPM mpm, const MPMBody *b, PetscInt64 id, const PetscReal X[], PetscInt p,
                                  MPMView *view)
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

/* The places of a body's lattice, lo .. hi on each axis, where particles of this process's patch can be: exact tests
   follow. False if there are none. */
static PetscBool OwnPlaces(MPM mpm, const Walk *w, PetscInt64 lo[3], PetscInt64 hi[3])
{
  const MPMGrid  *grid  = &mpm->grid;
  const MPMPatch *patch = &mpm->exchange.patch;
  const MPMBody  *b     = w->body;

  for (PetscInt d = 0; d < w->dim; d++) {
    const PetscInt below = patch->own_lo[d] - 1, above = patch->own_lo[d] + patch->own_n[d] + MPMBasisNodes(mpm->basis);
    PetscInt64     from, to;

    lo[d] = w->first[d];
    hi[d] = w->last[d];
    if (MPMKnownStarts(&mpm->scene)) continue;
    if (grid->periodic[d] && (below < 0 || above > grid->cells[d])) continue; /* from the other end too */
    from  = (PetscInt64)PetscFloorReal((grid->lower[d] + (PetscReal)below * grid->h[d] - b->offset[d]) / b->b[d]) - 1;
    to    = (PetscInt64)PetscCeilReal((grid->lower[d] + (PetscReal)above * grid->h[d] - b->offset[d]) / b->b[d]) + 1;
    lo[d] = PetscMax(lo[d], from);
    hi[d] = PetscMin(hi[d], to);
    if (lo[d] > hi[d]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Makes the particles of this process's patch, undeformed (F = I), with their start velocities. Not collective. */
PetscErrorCode MPMSceneAddParticles(MPM mpm)
{
  MPMScene       *scene = &mpm->scene;
  const MPMPatch *patch = &mpm->exchange.patch;
  const PetscInt  dim = mpm->grid.dim, axis = dim - 1;
  const PetscInt  fields = -1;
  MPMView         view;

  PetscFunctionBeginUser;
  for (int pass = 0; pass < 2; pass++) { /* count, then make */
    PetscInt p = 0;

    if (pass) PetscCall(MPMParticlesGetView(&mpm->particles, fields, &view));
    for (PetscInt k = 0; k < scene->nbodies; k++) {
      Walk       w     = WalkStart(&scene->bodies[k], dim);
      PetscInt64 lo[3] = {0}, hi[3] = {0};
      PetscReal  X[3], x[3], l[3];
      PetscInt   base[3] = {0};

      if (!OwnPlaces(mpm, &w, lo, hi)) continue;
      for (PetscInt64 plane = lo[0]; plane <= (dim == 3 ? hi[0] : lo[0]); plane++) { /* whose rows follow one another */
        const PetscInt64 from[3] = {plane, lo[1]}, to[3] = {dim == 3 ? plane : hi[0], hi[1]};

        WalkTo(scene, &w, RowOf(&w, from), RowOf(&w, to) + 1);
        while (WalkNext(&w))
          for (PetscInt64 q = PetscMax(w.ijk[axis], lo[axis]); q <= PetscMin(w.ijk[axis] + w.n - 1, hi[axis]); q++) {
            PlaceOf(&w, q, X);
            StartPlace(mpm, w.body, X, x, l);
            if (MPMOwnCell((int)dim, mpm->basis, patch, x, l, base) < 0) continue;
            if (pass) PetscCall(SetParticle(mpm, w.body, w.id + q - w.ijk[axis], X, p, &view));
            p++;
          }
      }
    }
    if (!pass) PetscCall(MPMParticlesSetSize(&mpm->particles, p));
  }
  PetscCall(MPMParticlesRestoreView(&mpm->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}
