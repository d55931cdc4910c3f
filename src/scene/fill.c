/* fill.c - the particles that fill the bodies of a scene. Before the first step they are counted, checked, and made on
   the process that owns their cell. */
#include <unistd.h>
#include "kernels/cell.h"
#include "scene/at_walls.h"
#include "scene/cut.h"
#include "scene/fill.h"
#include "scene/fit.h"
#include "scene/kinds.h"
#include "scene/lattice.h"
#include "scene/rim.h"
#include "scene/source.h"

#define MILLIMETRES 50 /* times the grid, a body that is larger is taken to have another unit of length */

/* Checks a particle of body b with lattice place `place` [dim] that starts at X [dim], m: its position, its velocity
   and the forces on it. */
PetscErrorCode MPMFillCheck(MPMScene *scene, MPMCore *core, MPMOptions o, const MPMBody *b, const PetscReal place[],
                            const PetscReal X[])
{
  const PetscInt dim     = core->grid.dim;
  PetscReal      v[3]    = {0}, xi[3], x[3];
  PetscBool      on_line = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(x, X, dim));
  (void)MPMKnownStart(scene, dim, X, x, v, NULL);
  for (PetscInt d = 0; d < dim; d++)
    if (!(x[d] >= core->grid.lower[d] && x[d] <= core->grid.upper[d]))
      MPMOptionsFail(o,
                     "body %s lies outside of the grid: its particle at %c = %g, the grid from %g to %g; see "
                     "-body_%s_shape, -grid_lower and -grid_upper",
                     b->name, "xyz"[d], (double)x[d], (double)(core->grid.lower[d]), (double)(core->grid.upper[d]),
                     b -> name);
  if (b->velocity) PetscCall(MPMExpressionEvaluate(b->velocity, dim, X, NULL, 0, v));
  scene->bodies[b - scene->bodies].v2 = PetscMax(b->v2, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  for (PetscInt d = 0; d < dim; d++)
    if (!(PetscAbsReal(v[d]) <= PETSC_MAX_REAL))
      MPMOptionsFail(o, "-body_%s_velocity is not finite at x = %g%s", b->name, (double)x[0], dim > 1 ? ", ..." : "");
  PetscCall(MPMForcesCheck(scene, core, o, x, X));
  if (scene->nvolume) PetscCall(MPMVolumeLoadsCount(scene, core, b, X, o));
  if (scene->initial) {
    MPMMaterialStart start;
    char             wrong[MPM_TEXT_LEN];

    PetscCall(MPMInitialState(scene, core, b, X, &start, wrong));
    if (wrong[0]) MPMOptionsFail(o, "%s", wrong);
  }
  for (PetscInt d = 0; d < dim; d++) xi[d] = (x[d] - core->grid.lower[d]) / core->grid.h[d];
  for (PetscInt d = 0; d < dim; d++)
    if (xi[d] == PetscFloorReal(xi[d])) on_line = PETSC_TRUE;
  scene->on_line += on_line;
  for (PetscInt k = 0; k < 2 * dim; k++)
    if (scene->walls.given[k / 2][k % 2].type == MPM_WALL_piston &&
        (k % 2 ? core->grid.upper[k / 2] - x[k / 2] : x[k / 2] - core->grid.lower[k / 2]) < scene->walls.place[k])
      scene->behind++;
  PetscCall(MPMSceneCheckInside(core, o, b, x));
  for (PetscInt k = 0; k < scene->nbodies; k++) {
    const MPMBody *other = &scene->bodies[k];
    char           at[MPM_NAME_LEN];

    if (other->source.on) continue;
    if ((other >= b && other->copy == b->copy) || other == b || !MPMRegionInside(&other->region, dim, place)) continue;
    scene->overlap++;
    if (other->copy == b->copy) continue;
    MPMPlaceWords(dim, X, at);
    MPMOptionsFail(o,
                   "-bodies: a particle of %s at %s lies in the shape of %s; bodies in contact must not overlap at the "
                   "start: move one, or cut it (-body_%s_cut %s)",
                   b->name, at, other->name, b->name, other->name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses what does not fit into the memory of this machine, if it has its part of `processes` processes: `number`
   items of `bytes` each, of all processes together. */
static void CheckMemory(MPMOptions o, const char what[], PetscReal number, PetscReal bytes, PetscMPIInt processes)
{
  const PetscReal have = (PetscReal)sysconf(_SC_PHYS_PAGES) * (PetscReal)sysconf(_SC_PAGESIZE), gb = 1e9;

  if (have > 0 && number * bytes / processes > have)
    MPMOptionsFail(o, "%s: %g of them need %.3g GB, this machine has %.3g", what, (double)number,
                   (double)(number * bytes / gb), (double)(have / gb));
}

/* Finds the kind of a body's particles, which it may share with earlier bodies of the same material and particle
   size. */
static void FindKind(MPMScene *scene, MPMOptions o, PetscInt dim, MPMBody *b)
{
  MPMKind kind = {b->material, 0, 1, {0}, b->copy};

  for (PetscInt d = 0; d < dim; d++) {
    kind.V0 *= b->b[d];
    kind.l[d] = 0.5 / (PetscReal)b->ppc[d];
  }
  kind.m = scene->materials[b->material].rho * kind.V0;
  if (!(kind.V0 > 0 && kind.m > 0 && kind.m < PETSC_MAX_REAL))
    MPMOptionsFail(o, "body %s: a particle of volume %g and mass %g is beyond the range of numbers", b->name,
                   (double)kind.V0, (double)kind.m);
  b->kind = MPMKindsFind(scene, scene->nkinds, &kind);
}

/* Sets the lattice of a body, adds roughly the number of its particles to places, and checks that it lies in the
   grid. */
static void SetLattice(const MPMScene *scene, const MPMCore *core, MPMOptions o, MPMBody *b, PetscReal *places)
{
  const MPMGrid *grid = &core->grid;
  PetscReal      lower[3], upper[3], product = 1;
  char           hint[3 * MPM_NAME_LEN] = "", cuts[3 * MPM_NAME_LEN] = "";

  for (PetscInt d = 0; d < grid->dim; d++) b->b[d] = grid->h[d] / b->ppc[d];
  if (b->source.on) MPMSourceExtend(b, grid->dim);
  MPMRegionBounds(&b->region, grid->dim, lower, upper);
  for (PetscInt d = 0; d < grid->dim; d++) {
    if (b->source.on) { /* all of its places count, and where it enters is checked for each particle */
      product *= (upper[d] - lower[d]) / b->b[d] + 3;
      continue;
    }
    product *= PetscMax(0, (PetscMin(upper[d], grid->upper[d]) - PetscMax(lower[d], grid->lower[d])) / b->b[d]) + 3;
    MPMFitPlace(b, upper[d] - lower[d] > MILLIMETRES * (grid->upper[d] - grid->lower[d]), hint, sizeof hint);
    for (const MPMBody *by = scene->bodies; by < scene->bodies + scene->nbodies; by++)
      for (PetscInt j = 0; j < by->region.ncut + by->region.nwithin; j++)
        if (by->region.others[j] == &b->region)
          (void)snprintf(cuts, sizeof cuts, "; if it only cuts %s, give -body_%s_material none", by->name, b->name);
    if (b->round && d == 0) lower[0] = PetscMax(lower[0], 0); /* the rest is its mirror image */
    if (!(upper[d] <= grid->upper[d] + b->b[d] && lower[d] >= grid->lower[d] - b->b[d] && upper[d] > grid->lower[d] &&
          lower[d] < grid->upper[d]))
      MPMOptionsFail(o, "body %s lies outside of the grid: it reaches from %c = %g to %g, the grid from %g to %g%s%s",
                     b->name, "xyz"[d], (double)lower[d], (double)upper[d], (double)(grid->lower[d]),
                     (double)(grid->upper[d]), hint, cuts);
    if (PetscAbsReal(b->offset[d]) > 1e9 * b->b[d])
      MPMOptionsFail(o, "-body_%s_offset %g: choose a smaller one; every multiple of %g gives the same lattice",
                     b->name, (double)b->offset[d], (double)b->b[d]);
  }
  *places += product;
}

/* Counts the particles of each body and before each share, and so numbers them. Collective on core->comm. */
static PetscErrorCode Count(MPMScene *scene, MPMCore *core)
{
  PetscInt64  mine = 0, before = 0;
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(core->comm, &scene->shares));
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  PetscCall(PetscMalloc1(scene->shares, &scene->share_first));
  for (PetscInt k = 0; k < scene->nfilled; k++) {
    MPMBody   *b = &scene->bodies[k];
    MPMLattice w = MPMLatticeShare(scene, b, core->grid.dim, rank, scene->shares);

    for (w.id = 0; MPMLatticeNext(&w);) continue;
    b->n = w.id;
    mine += b->n;
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &b->n, 1, MPIU_INT64, MPI_SUM, core->comm));
    b->first = core->particles.total;
    core->particles.total += b->n;
    core->particles.born = core->particles.total;
  }
  PetscCallMPI(MPI_Allgather(&mine, 1, MPIU_INT64, scene->share_first, 1, MPIU_INT64, core->comm));
  for (PetscInt k = 0; k < scene->shares; k++) {
    const PetscInt64 n = scene->share_first[k];

    scene->share_first[k] = before;
    before += n;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that the particles lie in the grid and start with finite velocities and forces; each process checks those of
   its rows. The first fault is left in o on all processes. Collective on core->comm. */
static PetscErrorCode CheckParticles(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  for (PetscInt k = 0; k < scene->nfilled && !MPMOptionsError(o); k++) {
    MPMBody   *b = &scene->bodies[k];
    MPMLattice w = MPMLatticeShare(scene, b, core->grid.dim, rank, scene->shares);
    PetscReal  place[3], X[3];
    PetscInt   parts;

    PetscCall(MPMCutBegin(b, w.dim));
    while (MPMLatticeNext(&w))
      for (PetscInt64 q = 0; q < w.n && !MPMOptionsError(o); q++) {
        MPMLatticePlace(&w, w.ijk[w.dim - 1] + q, place);
        parts = MPMCut(b, w.dim, place, X);
        PetscCall(MPMCutNote(scene, core, b, place, parts, X));
        if (b->source.on)
          MPMSourceCheck(core, o, b, place, X);
        else
          PetscCall(MPMFillCheck(scene, core, o, b, place, X));
      }
  }
  PetscCall(MPMOptionsShare(o, core->comm));
  for (PetscInt k = 0; k < scene->nfilled && !MPMOptionsError(o); k++)
    PetscCall(MPMCutEnd(scene, core, &scene->bodies[k]));
  for (PetscInt k = 0; k < scene->nfilled; k++)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->bodies[k].v2, 1, MPIU_REAL, MPI_MAX, core->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->on_line, 1, MPIU_INT64, MPI_SUM, core->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->behind, 1, MPIU_INT64, MPI_SUM, core->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->overlap, 1, MPIU_INT64, MPI_SUM, core->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts and numbers the particles without making them, finds their kinds, and checks what can be wrong. The first
   fault is left in o. Collective on core->comm. */
PetscErrorCode MPMSceneCountParticles(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  const PetscInt dim     = core->grid.dim;
  PetscReal      places  = 0;
  size_t         columns = 0; /* of bodies of revolution */
  PetscMPIInt    size;

  PetscFunctionBeginUser;
  PetscCall(MPMCutSetUp(scene));
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  CheckMemory(o, "nodes of the grid", MPMGridNodes(&core->grid, core->basis),
              (PetscReal)MPMNodeNumbers(dim, 1) * sizeof(PetscReal), size);
  for (PetscInt k = 0; k < scene->nfilled && !MPMOptionsError(o); k++) {
    MPMBody *b = &scene->bodies[k];

    SetLattice(scene, core, o, b, &places);
    if (places * (1 + 2 * dim + dim * dim) > (PetscReal)PETSC_MAX_INT)
      MPMOptionsFail(o, "body %s: with it the scene has about %g particles, more than this PETSc can number", b->name,
                     (double)places);
    if (MPMOptionsError(o)) break;
    b->row = scene->rows;
    scene->rows += MPMLatticeBegin(b, dim).end;
  }
  PetscCall(MPMOptionsShare(o, core->comm)); /* machines may differ in what fits into their memory */
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Count(scene, core));
  for (PetscInt k = 0; k < scene->nfilled && core->grid.round; k++) {
    const MPMLattice w = MPMLatticeBegin(&scene->bodies[k], dim);

    columns += (size_t)(w.last[0] - w.first[0] + 1);
  }
  PetscCall(MPMKindsRoom(scene, scene->nbodies + MPM_AT_WALLS_COLUMN * (PetscInt)columns));
  for (PetscInt k = 0; k < scene->nfilled; k++) {
    MPMBody *b = &scene->bodies[k];

    if (!b->n) MPMFitRefuse(o, &core->grid, b);
    if (core->grid.round && !MPMOptionsError(o))
      PetscCall(MPMAtWallsColumns(scene, core, b, !scene->start.plain && !b->memo));
    if (!core->grid.round) FindKind(scene, o, dim, b);
  }
  CheckMemory(o, "particles", (PetscReal)core->particles.total,
              (PetscReal)(1 + 2 * dim + dim * dim) * sizeof(PetscReal), size);
  PetscCall(CheckParticles(scene, core, o)); /* after a fault too, since others may have none */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets where the particle of body b whose matter is at X [dim], m, starts: its position x [dim], m, in the total frame X,
   which has its cell; and the half-widths l [dim] of its domain in cells. */
static PetscErrorCode StartPlace(const MPMScene *scene, const MPMCore *core, const MPMBody *b, const PetscReal X[],
                                 PetscReal x[], PetscReal l[])
{
  const PetscInt dim = core->grid.dim;
  PetscReal      F[9], V[3] = {1, 1, 1};

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) x[d] = X[d];
  MPMAtWallsMove(scene, core, b, x);
  if (!core->grid.total && MPMKnownStart(scene, dim, X, x, NULL, F) && core->needs.stretched)
    MPMStretch((int)dim, F, V);
  if (scene->initial && core->needs.stretched) {
    MPMMaterialStart start;
    char             wrong[MPM_TEXT_LEN];

    PetscCall(MPMInitialState(scene, core, b, X, &start, wrong));
    MPMStretch((int)dim, start.F, V);
  }
  for (PetscInt d = 0; d < dim; d++) l[d] = PetscMin(0.5, scene->kinds[b->kind].l[d] * V[d]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether particles start in other cells than undeformed ones at their lattice places. */
static PetscBool StartsMoved(const MPMScene *scene, const MPMCore *core)
{
  return (MPMKnownStarts(scene) && !core->grid.total) || (scene->initial && core->needs.stretched);
}

/* Makes a list of the base nodes (from 0, layers included) along the last axis of the undeformed places of a body's
   rows: bases [last - first + 1]. The caller frees it. */
static PetscErrorCode LastBases(const MPMScene *scene, const MPMCore *core, const MPMLattice *w, PetscInt **bases)
{
  const PetscInt d = w->dim - 1, from = core->grid.layers[d] + MPMGridFirst(&core->grid, d, w->body->copy);
  PetscReal      X[3], xi;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(w->last[d] - w->first[d] + 1, bases));
  for (PetscInt64 k = w->first[d]; k <= w->last[d]; k++) {
    MPMLatticePlace(w, k, X);
    (*bases)[k - w->first[d]] = from + MPMCoordinate(core->basis, &core->grid, (int)d, X[d],
                                                     scene->kinds[w->body->kind].l[d], &xi);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the particles of the scene, as they will start, to the histogram, by the base node of their stencils. Each
   process of the histogram adds those of its rows; where they start undeformed, it adds those of a cell together. Not
   collective. */
PetscErrorCode MPMSceneHistogram(const MPMScene *scene, const MPMCore *core, MPMHistogram *h)
{
  const PetscInt  dim = core->grid.dim, axis = dim - 1;
  const PetscBool moved = StartsMoved(scene, core);
  PetscMPIInt     rank, size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(h->comm, &size));
  PetscCallMPI(MPI_Comm_rank(h->comm, &rank));
  for (PetscInt k = 0; k < scene->nfilled; k++) {
    MPMLattice w = MPMLatticeShare(scene, &scene->bodies[k], dim, rank, size);
    PetscReal  X[3], x[3], l[3], xi[3];
    PetscInt   base[3] = {0}, *bases;

    if (w.body->source.on) continue;
    PetscCall(LastBases(scene, core, &w, &bases));
    while (MPMLatticeNext(&w))
      for (PetscInt64 q = 0, same; q < w.n; q += same) {
        const PetscInt *last = bases + w.ijk[axis] - w.first[axis];

        same = 1;
        if (!q || moved) {
          MPMLatticePlace(&w, w.ijk[axis] + q, X);
          PetscCall(StartPlace(scene, core, w.body, X, x, l));
          (void)MPMLocate((int)dim, core->basis, &core->grid, w.body->copy, x, l, xi, base);
          for (PetscInt d = 0; d < dim; d++) base[d] += core->grid.layers[d];
        }
        if (!moved)
          for (base[axis] = last[q]; q + same < w.n && last[q + same] == last[q];) same++;
        PetscCall(MPMHistogramAdd(h, base, same));
      }
    PetscCall(PetscFree(bases));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes particle p of a view, with lattice place `place` [dim] and so many parts of it: undeformed at X [dim], m, or as
   the scene's known solution starts. */
PetscErrorCode MPMFillSet(const MPMScene *scene, const MPMCore *core, const MPMBody *b, PetscInt64 id,
                          const PetscReal place[], PetscInt parts, const PetscReal X[], PetscInt p, MPMView *view)
{
  const PetscInt dim  = core->grid.dim;
  PetscReal      v[3] = {0}, x[3], F[9], l[3];

  PetscFunctionBeginUser;
  PetscCall(StartPlace(scene, core, b, X, x, l));
  if (b->velocity) PetscCall(MPMExpressionEvaluate(b->velocity, dim, b->round ? x : X, NULL, 0, v));
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  if (view->name)                                                                                                      \
    for (PetscInt k = 0; k < MPMComponents_##name((int)dim); k++)                                                      \
      view->name[p * MPMComponents_##name((int)dim) + k] = start;
#include "physics/fields.def"
  if (MPMKnownStart(scene, dim, X, x, v, F))
    for (PetscInt k = 0; k < dim * dim && view->F; k++) view->F[p * dim * dim + k] = F[k];
  if (scene->initial) PetscCall(MPMInitialSet(scene, core, b, X, p, view));
  if (b->round && b->velocity && core->needs.affine)
    PetscCall(MPMSceneStartAffine(core, b, x, view->C + p * dim * dim));
  view->id[p] = id;
  if (view->kind) view->kind[p] = MPMCutKind(scene, core, b, place, parts, X);
  if (view->depth) MPMRimDepth(scene, b, dim, place, view->depth + 2 * dim * p);
  if (view->chosen) PetscCall(MPMVolumeLoadsOn(scene, core, b, X, NULL, view->chosen + p));
  if (core->needs.rim && !b->points) {
    MPMRim(b, dim, core->gaps ? core->gaps->faces : 0, core->contacts ? PETSC_TRUE : PETSC_FALSE, place, X,
           view->rim + p * dim);
    if (scene->initial) MPMRimUndoStart(scene, b, dim, view, p);
  }
  for (PetscInt d = 0; d < dim; d++) {
    view->x[p * dim + d] = x[d];
    view->v[p * dim + d] = v[d];
    if (view->X) view->X[p * dim + d] = core->grid.total && b->round ? x[d] : X[d];
    if (view->l) view->l[p * dim + d] = l[d];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets lo .. hi on each axis to the places of a body's lattice where particles of this process's patch can be; the
   caller tests each of them exactly. Returns false if there are none. */
static PetscBool OwnPlaces(const MPMScene *scene, const MPMCore *core, const MPMLattice *w, PetscInt64 lo[3],
                           PetscInt64 hi[3])
{
  const MPMGrid  *grid  = &core->grid;
  const MPMPatch *patch = &core->exchange.patch;
  const MPMBody  *b     = w->body;

  for (PetscInt d = 0; d < w->dim; d++) {
    const PetscInt own = patch->own_lo[d] - MPMGridFirst(grid, d, b->copy), below = own - 1,
                   above = own + patch->own_n[d] + MPMBasisNodes(core->basis);
    PetscInt64 from, to;

    lo[d] = w->first[d];
    hi[d] = w->last[d];
    if (StartsMoved(scene, core)) continue;
    if (grid->periodic[d] && (below < 0 || above > grid->cells[d])) continue; /* from the other end too */
    from  = (PetscInt64)PetscFloorReal((grid->lower[d] + (PetscReal)below * grid->h[d] - b->offset[d]) / b->b[d]) - 2;
    to    = (PetscInt64)PetscCeilReal((grid->lower[d] + (PetscReal)above * grid->h[d] - b->offset[d]) / b->b[d]) + 2;
    lo[d] = PetscMax(lo[d], from);
    hi[d] = PetscMin(hi[d], to);
    if (lo[d] > hi[d]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Makes the particles of this process's patch with their start velocities, undeformed (F = I) or as the known solution
   starts. Not collective. */
PetscErrorCode MPMSceneAddParticles(const MPMScene *scene, MPMCore *core)
{
  const MPMPatch *patch = &core->exchange.patch;
  const PetscInt  dim = core->grid.dim, axis = dim - 1;
  const PetscInt  fields = -1;
  MPMView         view;

  PetscFunctionBeginUser;
  for (int round = 0; round < 2; round++) { /* 0 counts the particles, 1 makes them */
    PetscInt p = 0;

    if (round) PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
    for (PetscInt k = 0; k < scene->nfilled; k++) {
      MPMLattice w     = MPMLatticeBegin(&scene->bodies[k], dim);
      PetscInt64 lo[3] = {0}, hi[3] = {0};
      PetscReal  place[3], X[3], x[3], l[3];
      PetscInt   base[3] = {0}, parts;

      if (w.body->source.on || !OwnPlaces(scene, core, &w, lo, hi)) continue;
      for (PetscInt64 plane = lo[0]; plane <= (dim == 3 ? hi[0] : lo[0]); plane++) { /* its rows follow each other */
        const PetscInt64 from[3] = {plane, lo[1]}, to[3] = {dim == 3 ? plane : hi[0], hi[1]};

        MPMLatticeGoTo(scene, &w, MPMLatticeRow(&w, from), MPMLatticeRow(&w, to) + 1);
        while (MPMLatticeNext(&w))
          for (PetscInt64 q = PetscMax(w.ijk[axis], lo[axis]); q <= PetscMin(w.ijk[axis] + w.n - 1, hi[axis]); q++) {
            MPMLatticePlace(&w, q, place);
            parts = MPMCut(w.body, dim, place, X);
            PetscCall(StartPlace(scene, core, w.body, X, x, l));
            if (MPMOwnCell((int)dim, core->basis, patch, w.body->copy, x, l, base) < 0) continue;
            if (round) PetscCall(MPMFillSet(scene, core, w.body, w.id + q - w.ijk[axis], place, parts, X, p, &view));
            p++;
          }
      }
    }
    if (!round) PetscCall(MPMParticlesSetSize(&core->particles, p));
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}
