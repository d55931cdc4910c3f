/* read_source.c - reads which bodies flow in (-sources), before the first step. */
#include <strings.h>
#include "scene/source.h"

/* Reads one source, after its body. */
static PetscErrorCode Read(PetscInt dim, MPMOptions o, MPMBody *b)
{
  MPMSource *s    = &b->source;
  PetscReal  most = 0, lower[3], upper[3];
  PetscInt   axes = 0, axis = 0;
  char       text[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReal(o, "source_<b>_from", b->name, &s->from, NULL));
  PetscCall(MPMOptionsReal(o, "source_<b>_to", b->name, &s->to, NULL));
  PetscCall(MPMOptionsString(o, "body_<b>_velocity", b->name, text, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!(s->to > s->from))
    MPMOptionsFail(o, "-source_%s_to %g must be later than -source_%s_from %g", b->name, (double)s->to, b->name, (double)s->from);
  if (b->region.others) MPMOptionsFail(o, "-sources: the body %s may not be cut or limited by others", b->name);
  if (b->velocity && strspn(text, "+-.,0123456789eE \t") == strlen(text))
    PetscCall(MPMExpressionEvaluate(b->velocity, dim, b->region.lower, NULL, 0, s->v));
  for (PetscInt d = 0; d < dim; d++) most = PetscMax(most, PetscAbsReal(s->v[d]));
  if (!(most > 0)) {
    MPMOptionsFail(o, "-sources: -body_%s_velocity must be numbers, one of them not 0", b->name);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
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
    MPMOptionsFail(o, "-sources: the body %s must be a %s; and a polygon in 3-D moves along z, or across it", b->name, MPMRegionsSwept);
  MPMRegionBounds(&b->region, dim, lower, upper);
  if (axes == 1) b->offset[axis] = s->v[axis] > 0 ? upper[axis] : lower[axis]; /* a row of the lattice ends at the front */
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSourcesSetFromOptions(MPMScene *scene, const MPMCore *core, MPMOptions o)
{
  PetscInt n;
  char (*names)[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsNames(o, "sources", &n, &names));
  if (n && core->grid.total) MPMOptionsFail(o, "-sources does not apply in the total frame: its nodes have the matter of the start");
  if (n && core->grid.round) MPMOptionsFail(o, "-sources is not built yet with -geometry axisymmetric");
  if (n && (scene->initial || scene->known))
    MPMOptionsFail(o, "-sources does not apply with %s: what flows in is undeformed", scene->initial ? "-initial_stress" : "a known solution");
  for (PetscInt k = 0; k < n && !MPMOptionsError(o); k++) {
    MPMBody *body = NULL;

    for (PetscInt b = 0; b < scene->nfilled; b++)
      if (!strcasecmp(scene->bodies[b].name, names[k])) body = &scene->bodies[b];
    if (!body)
      MPMOptionsFail(o, "-sources %s: no body of that name has particles on a lattice", names[k]);
    else
      PetscCall(Read(core->grid.dim, o, body));
  }
  if (n == scene->nfilled && n && scene->nbodies == scene->nfilled)
    MPMOptionsFail(o, "-sources: all bodies are sources; a scene needs particles at the start");
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}
