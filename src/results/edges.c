/* edges.c - where a particle ends along the axes: at the edge of its domain, which is the ellipsoid in the box that it
   has at the start, deformed with it. */
#include "results/diagnostics.h"

/* Sets half [dim], m, to how far the domain of a particle reaches along each axis. Of elastic laws it deforms with F;
   of plastic ones with the elastic part of the deformation, and of bodies that do not keep their shape alike along all
   axes with the volume, since not all runs have their F, which makes needles of them. A box that the surface of the
   body cuts is smaller, or larger, by its volume. */
static void HalfWidths(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal half[])
{
  const MPMGrid     *grid = &s->core->grid;
  const PetscInt     dim  = grid->dim;
  const MPMKind     *kind = MPMKindOf(s->scene->kinds, v, p);
  const MPMMaterial *m    = &s->scene->materials[kind->material];
  PetscReal          part = kind->V0, volume, box[3];

  for (PetscInt d = 0; d < dim; d++) {
    box[d] = kind->l[d] * grid->h[d];
    part /= 2 * box[d];
  }
  part   = grid->round ? 1 : PetscPowReal(part, 1 / (PetscReal)dim);
  volume = PetscPowReal(MPMVolumeRatio(m, dim, v, p), 1 / (PetscReal)(grid->round ? 3 : dim));
  for (PetscInt d = 0; d < dim; d++) {
    PetscReal sum = 0;

    if (m->type->traits & MPM_LOOSE)
      sum = PetscSqr(volume * box[d]);
    else if (m->state & MPM_BIT(be))
      sum = v->be[p * MPM_SYM_NC(dim) + MPMSymPart((int)dim, (int)d, (int)d)] * PetscSqr(box[d]);
    else
      for (PetscInt e = 0; e < dim; e++) sum += PetscSqr(v->F[(p * dim + d) * dim + e] * box[e]);
    half[d] = part * PetscSqrtReal(sum);
  }
}

void MPMShownEdge(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal sign, PetscReal row[])
{
  const PetscInt dim = s->core->grid.dim;
  PetscReal      half[3];

  HalfWidths(s, v, p, half);
  for (PetscInt d = 0; d < 3; d++) row[d] = d < dim ? v->x[p * dim + d] + sign * half[d] : 0;
}
