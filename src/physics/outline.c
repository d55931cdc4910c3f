/* outline.c - surfaces of shapes, to be drawn: their own faces, or sampled ones of their distance. */
#include <stdlib.h>
#include "physics/outline.h"

/* A shape, and the box from which it is cut. */
typedef struct {
  const MPMRegion *shape;
  MPMRegion        box;
} Drawn;

static PetscReal Within(const void *context, PetscInt dim, const PetscReal x[])
{
  const Drawn    *d = (const Drawn *)context;
  PetscReal       n[3];
  const PetscReal shape = MPMRegionDistance(d->shape, dim, x, n), box = MPMRegionDistance(&d->box, dim, x, n);

  return -PetscMax(shape, box);
}

/* Appends n faces of dim corners each. */
static PetscBool Append(PetscInt dim, PetscInt n, const PetscReal corner[], MPMFaces *to)
{
  const size_t size = (size_t)(dim * dim);
  PetscReal   *more = realloc(to->corner, (size_t)PetscMax(1, to->n + n) * size * sizeof *more);

  if (!more) return PETSC_FALSE;
  to->corner = more;
  memcpy(more + (size_t)to->n * size, corner, (size_t)n * size * sizeof *more);
  to->n += n;
  to->room = to->n;
  return PETSC_TRUE;
}

/* The faces of a box: 2 points, 4 edges, or 12 triangles. */
static PetscBool OfBox(const MPMRegion *r, PetscInt dim, MPMFaces *to)
{
  const PetscReal *at[2] = {r->lower, r->upper};

  for (PetscInt d = 0; d < dim; d++)
    for (PetscInt side = 0; side < 2; side++) {
      const PetscInt e = (d + 1) % dim, f = (d + 2) % dim, halves = dim == 3 ? 2 : 1;

      for (PetscInt half = 0; half < halves; half++) {
        PetscReal corner[9];

        for (PetscInt k = 0; k < dim; k++) { /* one end, the other, and a third corner beside one of them */
          corner[dim * k + d] = at[side][d];
          if (dim > 1) corner[dim * k + e] = at[k == 2 ? half : k][e];
          if (dim > 2) corner[dim * k + f] = at[k == 2 ? 1 - half : k][f];
        }
        if (!Append(dim, 1, corner, to)) return PETSC_FALSE;
      }
    }
  return PETSC_TRUE;
}

PetscBool MPMRegionOutline(const MPMRegion *r, const MPMGrid *grid, MPMFaces *to)
{
  const PetscInt dim   = grid->dim;
  PetscBool      whole = !r->others;
  Drawn          drawn = {.shape = r, .box = {.type = MPM_REGION_box}};
  MPMImplicit    of    = {.dim = dim, .f = Within, .context = &drawn};

  for (PetscInt d = 0; d < dim && r->surface; d++)
    if (r->surface->dim != dim || r->lower[d] > r->surface->lower[d] || r->upper[d] < r->surface->upper[d])
      whole = PETSC_FALSE;
  if (whole && r->type == MPM_REGION_box) return OfBox(r, dim, to);
  if (whole && r->surface) return Append(dim, r->surface->n, r->surface->corner, to);
  MPMRegionBounds(r, dim, drawn.box.lower, drawn.box.upper);
  for (PetscInt d = 0; d < dim; d++) {
    of.spacing[d] = (dim == 3 ? 0.5 : 0.25) * grid->h[d];
    of.lower[d]   = drawn.box.lower[d] - of.spacing[d];
    of.upper[d]   = drawn.box.upper[d] + of.spacing[d];
  }
  return MPMMarch(&of, to);
}
