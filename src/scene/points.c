/* points.c - the particles of bodies of shape file. Each process reads a part of the lines, which says nothing about
   where these particles are; MPMExchangeDistribute sends them to the processes that own their cells. They are numbered
   in the sequence of the lines, behind those of the other bodies. */
#include <stdlib.h>
#include "parallel/exchange.h"
#include "scene/cut.h"
#include "scene/fill.h"
#include "scene/kinds.h"
#include "scene/points.h"

#define MOST 65536 /* pairs of material and volume in a file, each of which is a kind */

static int ComparePairs(const void *a, const void *b)
{
  const PetscReal *p = (const PetscReal *)a, *q = (const PetscReal *)b;

  return p[0] != q[0] ? (p[0] < q[0] ? -1 : 1) : p[1] != q[1] ? (p[1] < q[1] ? -1 : 1) : 0;
}

/* Sorts pairs [n][2] and takes doubles away; returns how many are left. */
static PetscInt SortPairs(PetscInt n, PetscReal *pair)
{
  PetscInt kept = 0;

  qsort(pair, (size_t)n, 2 * sizeof *pair, ComparePairs);
  for (PetscInt k = 0; k < n; k++)
    if (!kept || ComparePairs(pair + 2 * k, pair + 2 * kept - 2))
      memmove(pair + 2 * kept++, pair + 2 * k, 2 * sizeof *pair);
  return kept;
}

/* Finds all pairs of material and volume in the file, the same list on each process. */
static PetscErrorCode FindPairs(MPMCore *core, MPMOptions o, MPMPoints *p, const MPMPointRows *rows)
{
  PetscReal  *pair;
  PetscMPIInt size, n, *counts, *starts, all = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCall(PetscMalloc1(2 * rows->n, &pair));
  for (PetscInt k = 0; k < rows->n; k++) {
    pair[2 * k]     = (PetscReal)rows->material[k];
    pair[2 * k + 1] = rows->number[(k + 1) * rows->stride - 1];
  }
  n = (PetscMPIInt)SortPairs(rows->n, pair);
  if (n > MOST) MPMOptionsFail(o, "%.600s: its particles have more than %d volumes; round them", p->what, MOST);
  PetscCall(MPMOptionsShare(o, core->comm));
  if (!MPMOptionsError(o)) {
    PetscCall(PetscMalloc2(size, &counts, size, &starts));
    n *= 2;
    PetscCallMPI(MPI_Allgather(&n, 1, MPI_INT, counts, 1, MPI_INT, core->comm));
    for (PetscMPIInt k = 0; k < size; k++) {
      starts[k] = all;
      all += counts[k];
    }
    PetscCall(PetscMalloc1(PetscMax(2, all), &p->sort));
    PetscCallMPI(MPI_Allgatherv(pair, n, MPIU_REAL, p->sort, counts, starts, MPIU_REAL, core->comm));
    p->nkinds = SortPairs(all / 2, p->sort);
    PetscCall(PetscFree2(counts, starts));
  }
  PetscCall(PetscFree(pair));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the kinds of the file's particles. The domain of a particle is that of the lattice, as much larger along each
   axis as its volume is. */
static PetscErrorCode MakeKinds(MPMScene *scene, MPMCore *core, MPMOptions o, MPMBody *b)
{
  MPMPoints     *p      = b->points;
  const PetscInt dim    = core->grid.dim;
  const PetscInt before = scene->nkinds; /* pairs differ, so only these may be the same kind */
  PetscReal      box    = 1;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) box *= b->b[d];
  PetscCall(PetscMalloc1(PetscMax(1, p->nkinds), &p->kind));
  PetscCall(MPMKindsRoom(scene, p->nkinds + scene->nbodies));
  for (PetscInt q = 0; q < p->nkinds; q++) {
    const PetscReal grow = PetscPowReal(p->sort[2 * q + 1] / box, 1 / (PetscReal)dim);
    MPMKind         kind;

    PetscCall(PetscMemzero(&kind, sizeof kind));
    kind.material = (PetscInt)p->sort[2 * q];
    kind.copy     = b->copy;
    kind.V0       = p->sort[2 * q + 1];
    kind.m        = scene->materials[kind.material].rho * kind.V0;
    for (PetscInt d = 0; d < dim; d++)
      kind.l[d] = p->volume ? PetscMin(0.5, 0.5 / (PetscReal)b->ppc[d] * grow) : 0.5 / (PetscReal)b->ppc[d];
    if (!(kind.m > 0 && kind.m < PETSC_MAX_REAL))
      MPMOptionsFail(o, "%.600s: a particle of volume %g and mass %g is beyond the range of numbers", p->what,
                     (double)kind.V0, (double)kind.m);
    if (p->deformation && scene->materials[kind.material].state & MPM_BIT(tau))
      MPMOptionsFail(o, "%.600s: F of %s does not apply: the stress of this material depends on its history", p->what,
                     scene->materials[kind.material].name);
    p->kind[q] = MPMKindsFind(scene, before, &kind);
  }
  b->kind = p->nkinds ? p->kind[0] : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the kind of particle k of these rows. */
PetscInt MPMPointsKind(const MPMPoints *p, const MPMPointRows *rows, PetscInt k)
{
  const PetscReal  pair[2] = {(PetscReal)rows->material[k], rows->number[(k + 1) * rows->stride - 1]};
  const PetscReal *found   = bsearch(pair, p->sort, (size_t)p->nkinds, 2 * sizeof *pair, ComparePairs);

  return found ? p->kind[(found - p->sort) / 2] : 0;
}

/* Counts and checks the particles of a body, and finds its bounds. */
static PetscErrorCode CountBody(MPMScene *scene, MPMCore *core, MPMOptions o, MPMBody *b)
{
  const PetscInt dim = core->grid.dim;
  MPMPointRows   rows;
  PetscInt64     counts[3] = {scene->on_line, scene->overlap, scene->behind};
  PetscReal      bounds[7];

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) b->b[d] = core->grid.h[d] / b->ppc[d];
  PetscCall(MPMPointsRead(scene, b, core->comm, o, &rows));
  PetscCall(MPMOptionsShare(o, core->comm));
  if (!MPMOptionsError(o) && !rows.all) MPMOptionsFail(o, "%.600s: it has no particles", b->points->what);
  if (!MPMOptionsError(o)) PetscCall(FindPairs(core, o, b->points, &rows));
  if (!MPMOptionsError(o)) PetscCall(MakeKinds(scene, core, o, b));
  b->n     = rows.all;
  b->first = core->particles.total;
  core->particles.total += b->n;
  core->particles.born = core->particles.total;
  scene->on_line = scene->overlap = scene->behind = 0;
  for (PetscInt k = 0; k < 7; k++) bounds[k] = PETSC_MIN_REAL;
  for (PetscInt k = 0; k < rows.n && !MPMOptionsError(o); k++) {
    const PetscReal *x = rows.number + k * rows.stride;
    PetscReal        v = 0;

    PetscCall(MPMFillCheck(scene, core, o, b, x, x));
    for (PetscInt d = 0; d < dim; d++) {
      bounds[d]     = PetscMax(bounds[d], -x[d]);
      bounds[3 + d] = PetscMax(bounds[3 + d], x[d]);
      v += x[dim + d] * x[dim + d];
    }
    b->v2 = PetscMax(b->v2, v);
  }
  bounds[6] = b->v2;
  PetscCall(MPMOptionsShare(o, core->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bounds, 7, MPIU_REAL, MPI_MAX, core->comm));
  b->v2 = bounds[6];
  for (PetscInt d = 0; d < dim; d++) {
    b->region.lower[d] = -bounds[d];
    b->region.upper[d] = bounds[3 + d];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->on_line, 1, MPIU_INT64, MPI_SUM, core->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->overlap, 1, MPIU_INT64, MPI_SUM, core->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &scene->behind, 1, MPIU_INT64, MPI_SUM, core->comm));
  scene->on_line += counts[0];
  scene->overlap += counts[1];
  scene->behind += counts[2];
  PetscCall(MPMPointsDestroyRows(&rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the particles of files, after those of shapes. The first fault is left in o. Collective on core->comm. */
PetscErrorCode MPMPointsCount(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  PetscFunctionBeginUser;
  for (PetscInt k = scene->nfilled; k < scene->nbodies && !MPMOptionsError(o); k++)
    PetscCall(CountBody(scene, core, o, &scene->bodies[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets particle p of a view to row k of those of a body. */
static PetscErrorCode SetPoint(const MPMScene *scene, const MPMCore *core, const MPMBody *b, const MPMPointRows *rows,
                               PetscInt k, PetscInt p, MPMView *view)
{
  const PetscInt   dim = core->grid.dim, kind = MPMPointsKind(b->points, rows, k);
  const PetscReal *x = rows->number + k * rows->stride, *v = x + dim, *F = v + dim;
  PetscReal        V[3] = {1, 1, 1};

  PetscFunctionBeginUser;
  PetscCall(MPMFillSet(scene, core, b, b->first + rows->first + k, x, MPMCutParts(core->grid.dim), x, p, view));
  if (view->kind) view->kind[p] = kind;
  for (PetscInt d = 0; d < 2 * dim && view->depth; d++)
    view->depth[2 * dim * p + d] = 0; /* loads act on bodies of a lattice */
  for (PetscInt d = 0; d < dim && b->points->velocity; d++) view->v[p * dim + d] = v[d];
  if (b->points->deformation) {
    for (PetscInt q = 0; q < dim * dim && view->F; q++) view->F[p * dim * dim + q] = F[q];
    if (view->J) view->J[p] = MPMDet((int)dim, F);
    MPMStretch((int)dim, F, V);
  }
  for (PetscInt d = 0; d < dim && view->l; d++) view->l[p * dim + d] = PetscMin(0.5, scene->kinds[kind].l[d] * V[d]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the particles of files to a histogram, as MPMSceneHistogram does with the others. Collective on h->comm. */
PetscErrorCode MPMPointsHistogram(const MPMScene *scene, const MPMCore *core, MPMHistogram *h)
{
  PetscFunctionBeginUser;
  for (PetscInt b = scene->nfilled; b < scene->nbodies; b++) {
    const PetscInt dim = core->grid.dim;
    MPMPointRows   rows;
    MPMView        view;

    PetscCall(MPMPointsRead(scene, &scene->bodies[b], h->comm, NULL, &rows));
    PetscCall(PetscMemzero(&view, sizeof view));
    view.n = rows.n;
    PetscCall(PetscMalloc3(rows.n * dim, &view.x, rows.n, &view.kind, rows.n * dim, &view.l));
    for (PetscInt k = 0; k < rows.n; k++) {
      const PetscReal *x    = rows.number + k * rows.stride;
      PetscReal        V[3] = {1, 1, 1};

      view.kind[k] = MPMPointsKind(scene->bodies[b].points, &rows, k);
      if (scene->bodies[b].points->deformation && core->needs.stretched) MPMStretch((int)dim, x + 2 * dim, V);
      for (PetscInt d = 0; d < dim; d++) {
        view.x[k * dim + d] = x[d];
        view.l[k * dim + d] = PetscMin(0.5, scene->kinds[view.kind[k]].l[d] * V[d]);
      }
    }
    view.X = view.x;
    PetscCall(MPMHistogramAddView(h, core, &view));
    PetscCall(PetscFree3(view.x, view.kind, view.l));
    PetscCall(MPMPointsDestroyRows(&rows));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the particles of files, after those of shapes. Collective on exchange.data. */
PetscErrorCode MPMPointsAdd(const MPMScene *scene, MPMCore *core)
{
  const PetscInt fields = -1;
  MPMView        view;

  PetscFunctionBeginUser;
  for (PetscInt b = scene->nfilled; b < scene->nbodies; b++) {
    const PetscInt before = core->particles.n;
    MPMPointRows   rows;

    PetscCall(MPMPointsRead(scene, &scene->bodies[b], core->exchange.data, NULL, &rows));
    PetscCheck(rows.all == scene->bodies[b].n, PETSC_COMM_SELF, PETSC_ERR_FILE_READ,
               "%s has changed since it was read first", scene->bodies[b].points->path);
    PetscCall(MPMParticlesSetSize(&core->particles, before + rows.n));
    PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
    for (PetscInt k = 0; k < rows.n; k++)
      PetscCall(SetPoint(scene, core, &scene->bodies[b], &rows, k, before + k, &view));
    PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
    PetscCall(MPMPointsDestroyRows(&rows));
  }
  if (scene->nbodies > scene->nfilled) PetscCall(MPMExchangeDistribute(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}
