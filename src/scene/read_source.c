/* read_source.c - reads which bodies flow in (-sources), before the first step; in which layers their particles are, and where
   these enter. */
#include <strings.h>
#include "scene/source.h"

#define AHEAD 2 /* cells: what enters does so as far before an end of the grid, to which it moves */

/* Reads one source, after its body. */
static PetscErrorCode Read(const MPMGrid *grid, MPMOptions o, MPMBody *b)
{
  const PetscInt dim  = grid->dim;
  MPMSource     *s    = &b->source;
  PetscReal      most = 0, lower[3], upper[3];
  PetscInt       axes = 0, axis = 0;
  char           text[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReal(o, "source_<b>_from", b->name, &s->from, NULL));
  PetscCall(MPMOptionsReal(o, "source_<b>_to", b->name, &s->to, NULL));
  PetscCall(MPMOptionsString(o, "body_<b>_velocity", b->name, text, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!(s->to > s->from))
    MPMOptionsFail(o, "-source_%s_to %g must be later than -source_%s_from %g", b->name, (double)s->to, b->name,
                   (double)s->from);
  if (b->region.others) MPMOptionsFail(o, "-sources: the body %s may not be cut or limited by others", b->name);
  if (b->velocity && strspn(text, "+-.,0123456789eE \t") == strlen(text))
    PetscCall(MPMExpressionEvaluate(b->velocity, dim, b->region.lower, NULL, 0, s->v));
  for (PetscInt d = 0; d < dim; d++) most = PetscMax(most, PetscAbsReal(s->v[d]));
  if (!(most > 0)) {
    MPMOptionsFail(o, "-sources: -body_%s_velocity must be numbers, one of them not 0", b->name);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (grid->round && s->v[0] != 0)
    MPMOptionsFail(
        o,
        "-sources: -body_%s_velocity has %g along x: with -geometry axisymmetric x is the radius, and matter flows in along y only",
        b->name, (double)s->v[0]);
  for (PetscInt d = 0; d < dim; d++) {
    s->speed += PetscSqr(s->v[d] / most);
    if (s->v[d] == 0) continue;
    axis = d;
    axes++;
  }
  s->on    = PETSC_TRUE;
  s->speed = axes > 1 ? most * PetscSqrtReal(s->speed) : most;
  for (PetscInt d = 0; d < dim; d++) s->along[d] = s->v[d] / s->speed;
  if (!MPMRegionSweeps(&b->region, dim, s->along))
    MPMOptionsFail(o, "-sources: the body %s must be a %s; and a polygon in 3-D moves along z, or across it", b->name,
                   MPMRegionsSwept);
  MPMRegionBounds(&b->region, dim, lower, upper);
  if (axes == 1)
    b->offset[axis] = s->v[axis] > 0 ? upper[axis] : lower[axis]; /* a row of the lattice ends at the front */
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSourcesSetFromOptions(MPMScene *scene, const MPMCore *core, MPMOptions o)
{
  PetscInt n;
  char(*names)[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsNames(o, "sources", &n, &names));
  if (n && core->grid.total)
    MPMOptionsFail(o, "-sources does not apply in the total frame: its nodes have the matter of the start");
  if (n && (scene->initial || scene->known))
    MPMOptionsFail(o, "-sources does not apply with %s: what flows in is undeformed",
                   scene->initial ? "-initial_stress" : "a known solution");
  for (PetscInt k = 0; k < n && !MPMOptionsError(o); k++) {
    MPMBody *body = NULL;

    for (PetscInt b = 0; b < scene->nfilled; b++)
      if (!strcasecmp(scene->bodies[b].name, names[k])) body = &scene->bodies[b];
    if (!body)
      MPMOptionsFail(o, "-sources %s: no body of that name has particles on a lattice", names[k]);
    else
      PetscCall(Read(&core->grid, o, body));
  }
  if (n == scene->nfilled && n && scene->nbodies == scene->nfilled)
    MPMOptionsFail(
        o,
        "-sources: all bodies are sources; a scene needs particles at the start: add a body of one cell, at rest in a corner");
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMSourceLayer(const MPMBody *b, PetscInt dim, const PetscReal place[])
{
  PetscReal at = 0;

  (void)MPMRegionLeaves(&b->region, dim, place, b->source.along, &at);
  return PetscMin(b->source.layers - 1, (PetscInt)PetscFloorReal(at / b->source.layer));
}

PetscReal MPMSourceTime(const MPMBody *b, PetscInt layer)
{
  return b->source.from + (PetscReal)layer * (b->source.layer / b->source.speed);
}

void MPMSourceExtend(MPMBody *b, PetscInt dim)
{
  MPMSource      *s      = &b->source;
  const PetscReal length = (s->to - s->from) * s->speed;

  for (PetscInt d = 0; d < dim; d++) s->layer += s->along[d] * s->along[d] * b->b[d];
  s->layers       = (PetscInt)PetscCeilReal(length / s->layer * (1 - 1e-12));
  b->region.sweep = (PetscReal)s->layers * s->layer;
  b->v2           = s->speed * s->speed;
  for (PetscInt d = 0; d < dim; d++) b->region.along[d] = s->along[d];
}

void MPMSourceCheck(const MPMCore *core, MPMOptions o, const MPMBody *b, const PetscReal place[], const PetscReal X[])
{
  const MPMGrid  *grid  = &core->grid;
  const PetscReal moved = b->source.speed * (MPMSourceTime(b, MPMSourceLayer(b, grid->dim, place)) - b->source.from);

  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal x = X[d] + moved * b->source.along[d], ahead = AHEAD * grid->h[d] * b->source.along[d];

    if (grid->periodic[d] || (PetscMin(x, x + ahead) >= grid->lower[d] && PetscMax(x, x + ahead) < grid->upper[d]))
      continue;
    MPMOptionsFail(
        o,
        "-sources: a particle of %s would enter at %c = %g, but the grid is from %g to %g, and has to reach two "
        "cells farther where it moves; see -body_%s_shape",
        b->name, "xyz"[d], (double)x, (double)(grid->lower[d]), (double)(grid->upper[d]), b -> name);
  }
}
