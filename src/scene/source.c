/* source.c - bodies that flow in (-sources): the matter of such a body comes through the front of its shape, where lines
   along its velocity leave it, layer by layer, from a time to another. Its particles are numbered before the run as those of
   a body that reaches so far behind the front as it moves in that time (MPMRegion.sweep); a layer enters when it has come to
   the front. Layers have the thickness of a row of the lattice across an axis along which they move, and the mean of these
   thicknesses where they move askew. */
#include "kernels/cell.h"
#include "scene/cut.h"
#include "scene/fill.h"
#include "scene/lattice.h"
#include "scene/source.h"

/* Returns how many layers have entered by time t. */
static PetscInt Entered(const MPMBody *b, PetscReal t)
{
  PetscInt n = b->source.entered;

  while (n < b->source.layers && MPMSourceTime(b, n) <= t) n++;
  return n;
}

PetscErrorCode MPMSourcesBegin(MPMScene *scene, MPMCore *core, PetscBool restarted)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nfilled; k++) {
    MPMBody *b = &scene->bodies[k];

    if (!b->source.on) continue;
    core->particles.flows = PETSC_TRUE;
    if (restarted)
      b->source.entered = Entered(b, core->t);
    else {
      core->particles.total -= b->n;
      core->particles.waiting += b->n;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes the number of the first particle of each row. */
static PetscErrorCode NumberRows(const MPMBody *b, PetscInt dim, PetscInt64 **ids)
{
  MPMLattice w   = MPMLatticeBegin(b, dim);
  PetscInt64 row = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(w.end + 1, ids));
  while (MPMLatticeNext(&w))
    for (; row <= w.row; row++) (*ids)[row] = w.id;
  for (; row <= w.end; row++) (*ids)[row] = w.id;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets lo .. hi on each axis to the lattice places among which layers first .. last-1 are. */
static void Places(const MPMBody *b, const MPMLattice *w, PetscInt first, PetscInt last, PetscInt64 lo[3],
                   PetscInt64 hi[3])
{
  const MPMSource *s     = &b->source;
  MPMRegion        shape = b->region;
  PetscReal        lower[3], upper[3];

  shape.sweep = 0;
  MPMRegionBounds(&shape, w->dim, lower, upper);
  for (PetscInt d = 0; d < w->dim; d++) {
    const PetscReal near = -s->along[d] * s->layer * (PetscReal)first, far = -s->along[d] * s->layer * (PetscReal)last;

    lo[d] = (PetscInt64)PetscFloorReal((lower[d] + PetscMin(near, far) - b->offset[d]) / b->b[d]) - 1;
    hi[d] = (PetscInt64)PetscCeilReal((upper[d] + PetscMax(near, far) - b->offset[d]) / b->b[d]) + 1;
    lo[d] = PetscMin(PetscMax(lo[d], w->first[d]), w->last[d]);
    hi[d] = PetscMin(PetscMax(hi[d], w->first[d]), w->last[d]);
  }
}

/* Makes, in the second of two rounds, the particles of layers first .. last-1 of a source that lie on this process, from *p
   on; in the first it counts them. */
static PetscErrorCode Make(const MPMScene *scene, const MPMCore *core, const MPMBody *b, PetscInt first, PetscInt last,
                           PetscInt *p, MPMView *view)
{
  const PetscInt   dim   = core->grid.dim;
  const MPMSource *s     = &b->source;
  MPMLattice       w     = MPMLatticeBegin(b, dim);
  PetscInt64       lo[3] = {0}, hi[3] = {0};

  PetscFunctionBeginUser;
  if (first == last) PetscFunctionReturn(PETSC_SUCCESS);
  Places(b, &w, first, last, lo, hi);
  for (PetscInt64 plane = lo[0]; plane <= (dim == 3 ? hi[0] : lo[0]); plane++) { /* its rows follow each other */
    const PetscInt64 from[3] = {plane, lo[1]}, to[3] = {dim == 3 ? plane : hi[0], hi[1]}, row = MPMLatticeRow(&w, from);

    MPMLatticeRows(&w, row, MPMLatticeRow(&w, to) + 1, s->ids[row]);
    while (MPMLatticeNext(&w))
      for (PetscInt64 q = 0; q < w.n; q++) {
        PetscReal place[3], X[3];
        PetscInt  base[3], parts, layer;

        MPMLatticePlace(&w, w.ijk[dim - 1] + q, place);
        layer = MPMSourceLayer(b, dim, place);
        if (layer < first || layer >= last) continue;
        parts = MPMCut(b, dim, place, X);
        for (PetscInt d = 0; d < dim; d++) X[d] += s->v[d] * (core->t - s->from);
        if (MPMOwnCell((int)dim, core->basis, &core->exchange.patch, b->copy, X, scene->kinds[b->kind].l, base) < 0)
          continue;
        if (view) PetscCall(MPMFillSet(scene, core, b, w.id + q, place, parts, X, *p, view));
        ++*p;
      }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSourcesEnter(MPMScene *scene, MPMCore *core, PetscInt *first, PetscBool *any)
{
  MPMParticles *particles = &core->particles;
  PetscInt64    all;
  MPMView       view;
  PetscInt      n = particles->n, p;

  PetscFunctionBeginUser;
  *any   = PETSC_FALSE;
  *first = n;
  for (PetscInt k = 0; k < scene->nfilled; k++)
    if (scene->bodies[k].source.on && Entered(&scene->bodies[k], core->t) > scene->bodies[k].source.entered)
      *any = PETSC_TRUE;
  if (!*any) PetscFunctionReturn(PETSC_SUCCESS);
  for (int round = 0; round < 2; round++) {
    p = *first;
    if (round) PetscCall(MPMParticlesGetView(particles, -1, &view));
    for (PetscInt k = 0; k < scene->nfilled; k++) {
      MPMBody       *b    = &scene->bodies[k];
      const PetscInt last = b->source.on ? Entered(b, core->t) : 0;

      if (b->source.on && !b->source.ids) PetscCall(NumberRows(b, core->grid.dim, &b->source.ids));
      if (b->source.on) PetscCall(Make(scene, core, b, b->source.entered, last, &p, round ? &view : NULL));
      if (round && b->source.on) b->source.entered = last;
    }
    n = p;
    if (!round) PetscCall(MPMParticlesSetSize(particles, n));
  }
  PetscCall(MPMParticlesRestoreView(particles, -1, &view));
  all = n - *first;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPIU_INT64, MPI_SUM, core->exchange.data));
  particles->total += all;
  particles->waiting -= all;
  particles->ids = 0; /* the next check finds it anew */
  PetscFunctionReturn(PETSC_SUCCESS);
}
