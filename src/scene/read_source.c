/* read_source.c - reads which bodies flow in (-sources), before the first step. */
#include <strings.h>
#include "scene/source.h"

/* Reads one source, after its body. */
static PetscErrorCode Read(const MPMCore *core, MPMOptions o, MPMBody *b)
{
  const PetscInt dim = core->grid.dim;
  MPMSource     *s   = &b->source;
  PetscReal      v[3] = {0};
  PetscInt       axes = 0;
  char           text[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReal(o, "source_<b>_from", b->name, &s->from, NULL));
  PetscCall(MPMOptionsReal(o, "source_<b>_to", b->name, &s->to, NULL));
  PetscCall(MPMOptionsString(o, "body_<b>_velocity", b->name, text, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!(s->to > s->from))
    MPMOptionsFail(o, "-source_%s_to %g must be later than -source_%s_from %g", b->name, (double)s->to, b->name, (double)s->from);
  if (b->region.type != MPM_REGION_box || b->region.others)
    MPMOptionsFail(o, "-sources: the body %s must be a box that no other cuts", b->name);
  if (!b->velocity || strspn(text, "+-.,0123456789eE \t") != strlen(text)) {
    MPMOptionsFail(o, "-sources: -body_%s_velocity must be numbers, one of them not 0", b->name);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMExpressionEvaluate(b->velocity, dim, b->region.lower, NULL, 0, v));
  for (PetscInt d = 0; d < dim; d++) {
    if (v[d] == 0) continue;
    s->axis = d;
    axes++;
  }
  if (axes != 1) MPMOptionsFail(o, "-sources: -body_%s_velocity %s is not along one axis", b->name, text);
  s->on    = PETSC_TRUE;
  s->speed = v[s->axis];
  s->front = s->speed > 0 ? b->region.upper[s->axis] : b->region.lower[s->axis];
  if (!(s->front > core->grid.lower[s->axis] && s->front < core->grid.upper[s->axis]))
    MPMOptionsFail(o, "-sources: the front of %s, at %c = %g, does not lie in the grid", b->name, "xyz"[s->axis], (double)s->front);
  b->offset[s->axis] = s->front;
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
      PetscCall(Read(core, o, body));
  }
  if (n == scene->nfilled && n && scene->nbodies == scene->nfilled)
    MPMOptionsFail(o, "-sources: all bodies are sources; a scene needs particles at the start");
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMSourceExtend(MPMBody *b)
{
  MPMSource      *s = &b->source;
  const PetscReal layer = b->b[s->axis], length = (s->to - s->from) * PetscAbsReal(s->speed);

  s->layers = (PetscInt)PetscCeilReal(length / layer * (1 - 1e-12));
  b->region.lower[s->axis] = s->front - (s->speed > 0 ? (PetscReal)s->layers * layer : 0);
  b->region.upper[s->axis] = s->front + (s->speed > 0 ? 0 : (PetscReal)s->layers * layer);
  b->v2                    = s->speed * s->speed;
}
