/* source.c - bodies that flow in (-sources): the matter of such a body comes through the front of its box, layer by layer of
   its lattice, with its velocity, from a time to another. Its particles are numbered before the run as those of a body that
   reaches so far behind the front as it moves in that time; a layer enters when it has come to the front. */
#include "kernels/cell.h"
#include "scene/cut.h"
#include "scene/fill.h"
#include "scene/lattice.h"
#include "scene/source.h"

/* Returns the layer, from 0 on, in which a place of a source's lattice lies; and when a layer enters, s. */
static PetscInt LayerOf(const MPMBody *b, const PetscReal place[])
{
  const MPMSource *s = &b->source;

  return (PetscInt)PetscFloorReal(PetscAbsReal(s->front - place[s->axis]) / b->b[s->axis]);
}

static PetscReal TimeOf(const MPMBody *b, PetscInt layer)
{
  return b->source.from + (PetscReal)layer * (b->b[b->source.axis] / PetscAbsReal(b->source.speed));
}

/* Returns how many layers have entered by time t. */
static PetscInt Entered(const MPMBody *b, PetscReal t)
{
  PetscInt n = b->source.entered;

  while (n < b->source.layers && TimeOf(b, n) <= t) n++;
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

/* Makes, in the second of two rounds, the particles of layers first .. last-1 of a source that lie on this process, from *p
   on; in the first it counts them. */
static PetscErrorCode Make(const MPMScene *scene, const MPMCore *core, const MPMBody *b, PetscInt first, PetscInt last,
                           PetscInt *p, MPMView *view)
{
  const PetscInt   dim = core->grid.dim;
  const MPMSource *s   = &b->source;
  MPMLattice       w   = MPMLatticeBegin(b, dim);

  PetscFunctionBeginUser;
  while (MPMLatticeNext(&w))
    for (PetscInt64 q = 0; q < w.n; q++) {
      PetscReal place[3], X[3];
      PetscInt  base[3], parts, layer;

      MPMLatticePlace(&w, w.ijk[dim - 1] + q, place);
      layer = LayerOf(b, place);
      if (layer < first || layer >= last) continue;
      parts = MPMCut(b, dim, place, X);
      X[s->axis] += s->speed * (core->t - s->from);
      if (MPMOwnCell((int)dim, core->basis, &core->exchange.patch, b->copy, X, scene->kinds[b->kind].l, base) < 0) continue;
      if (view) PetscCall(MPMFillSet(scene, core, b, w.id + q, place, parts, X, *p, view));
      ++*p;
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
    if (scene->bodies[k].source.on && Entered(&scene->bodies[k], core->t) > scene->bodies[k].source.entered) *any = PETSC_TRUE;
  if (!*any) PetscFunctionReturn(PETSC_SUCCESS);
  for (int round = 0; round < 2; round++) {
    p = *first;
    if (round) PetscCall(MPMParticlesGetView(particles, -1, &view));
    for (PetscInt k = 0; k < scene->nfilled; k++) {
      MPMBody       *b    = &scene->bodies[k];
      const PetscInt last = b->source.on ? Entered(b, core->t) : 0;

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
