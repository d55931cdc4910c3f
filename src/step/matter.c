/* matter.c - where the matter of a particle ends, for all that acts on arrival: walls (gaps.c) and contact (contact.c). */
#include "physics/extent.h"
#include "step/matter.h"

#define FACES                                                                                                          \
  0.25 /* squared cosine of the angle from -n within which a surface is turned to what it meets: 60 degrees */
#define STEEP 0.1 /* cells */

static const MPMMaterial *MaterialOf(const MPMCore *core, const MPMView *view, PetscInt p)
{
  return &core->params.materials[MPMKindOf(core->params.kinds, view, p)->material];
}

PetscReal MPMMatterDeformation(const MPMCore *core, const MPMView *view, PetscInt p, PetscReal F[])
{
  const PetscInt     dim = core->grid.dim;
  const MPMMaterial *m   = MaterialOf(core, view, p);
  PetscReal          J   = 1;

  if (MPMMaterialKeepsShape(m)) {
    for (PetscInt k = 0; k < dim * dim; k++) F[k] = view->F[p * dim * dim + k];
    return MPMDet((int)dim, F);
  }
  if (m->type->traits & MPM_FLUID) J = PetscClipInterval(view->J[p], 0.5, 2);
  for (PetscInt k = 0; k < dim * dim; k++) F[k] = 0;
  for (PetscInt d = 0; d < dim; d++) F[d * (dim + 1)] = dim == 1 ? J : dim == 2 ? PetscSqrtReal(J) : cbrt(J);
  return m->type->traits & MPM_FLUID ? view->J[p] : 1;
}

void MPMMatterSetEnd(const MPMCore *core, const MPMView *view, PetscInt p, const PetscReal F[], MPMMatterEnd *end)
{
  const int        dim  = (int)core->grid.dim;
  const MPMKind   *kind = MPMKindOf(core->params.kinds, view, p);
  const PetscReal *rim  = view->rim + p * dim;
  PetscReal        cofactor[9], far = 0;

  *end = (MPMMatterEnd){.size = 0};
  MPMCofactor(dim, F, cofactor); /* J F^-T turns normals of surfaces */
  for (int d = 0; d < dim; d++) {
    end->half[d] = kind->l[d] * core->grid.h[d];
    for (int e = 0; e < dim; e++) {
      end->F[d * dim + e] = F[d * dim + e];
      end->normal[d] += cofactor[d * dim + e] * rim[e];
    }
    far += rim[d] * rim[d];
    end->size += end->normal[d] * end->normal[d];
  }
  end->far = MPMDet(dim, F) * far;
}

PetscReal MPMMatterReaches(PetscInt dim, const MPMMatterEnd *end, const PetscReal n[], PetscReal h)
{
  const PetscReal *turned = end->normal;
  PetscReal        along  = 0, ahead, most;

  for (PetscInt d = 0; d < dim; d++) along -= turned[d] * n[d];
  if (!(along > 0 && along * along > FACES * end->size)) return MPMExtent((int)dim, end->half, end->F, n);
  ahead = most = end->far / along;
  for (PetscInt d = 0; d < dim; d++) most += PetscAbsReal(turned[d] + along * n[d]) / along * end->half[d];
  return PetscMax(ahead, most - STEEP * h);
}

PetscReal MPMMatterArrives(const MPMCore *core, const MPMView *view, PetscInt p, const PetscReal n[],
                           const PetscReal V[])
{
  const PetscInt  dim = core->grid.dim;
  const PetscReal dt  = core->params.dt;
  PetscReal       g2 = 0, speed = 0;

  if (MPMMaterialKeepsShape(MaterialOf(core, view, p))) return PETSC_INFINITY;
  for (PetscInt d = 0; d < dim; d++) {
    g2 += PetscSqr(core->params.gravity[d]);
    speed += (V[d] - view->v[p * dim + d]) * n[d];
  }
  return 2 * dt * (PetscMax(0, speed) + dt * PetscSqrtReal(g2));
}
