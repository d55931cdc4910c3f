/* cell.h - the place of one particle in the grid: its base node and the number of its cell, for initialisation and for
   particles that changed process. The transfers compute the same for many particles at a time (stencils.h) by the same
   functions of basis.h, with the same bits. */
#ifndef MPM_CELL_H
#define MPM_CELL_H

#include "kernels/tile_index.h"

/* Returns the base node on axis d, and xi, the coordinate in cells, of a position x in m in the grid, for a particle
   with half-width l in cells (which matters to gimp only). */
MPM_INLINE PetscInt MPMCoordinate(MPMBasis basis, const MPMGrid *grid, int d, PetscReal x, PetscReal l, PetscReal *xi)
{
  *xi = PetscMin((x - grid->lower[d]) / grid->h[d], (PetscReal)grid->cells[d]); /* the quotient may round up */
  return MPMBasisBase(basis, xi, basis == MPM_BASIS_gimp ? l : 0, grid->cells[d], grid->periodic[d],
                      grid->wall_basis[d]);
}

/* Computes base node and coordinates on all axes, [dim] each. */
MPM_INLINE void MPMCoordinates(int dim, MPMBasis basis, const MPMGrid *grid, const PetscReal x[], const PetscReal l[],
                               PetscReal xi[], PetscInt base[])
{
  for (int d = 0; d < dim; d++)
    base[d] = MPMCoordinate(basis, grid, d, x[d], basis == MPM_BASIS_gimp ? l[d] : 0, &xi[d]);
}

/* Does the same for any x, with the number of the base node in a copy; returns false if x is outside of the grid or not
   finite. */
MPM_INLINE PetscBool MPMLocate(int dim, MPMBasis basis, const MPMGrid *grid, PetscInt copy, const PetscReal x[],
                               const PetscReal l[], PetscReal xi[], PetscInt base[])
{
  for (int d = 0; d < dim; d++)
    if (!(x[d] >= grid->lower[d] && x[d] <= grid->upper[d])) return PETSC_FALSE;
  MPMCoordinates(dim, basis, grid, x, l, xi, base);
  base[grid->stack] += MPMGridFirst(grid, grid->stack, copy);
  return PETSC_TRUE;
}

/* Returns the positions [n][dim], m, whose cells and weights count: those of the start in the total frame. */
MPM_INLINE const PetscReal *MPMPlaces(const MPMGrid *grid, const MPMView *view)
{
  return grid->total ? view->X : view->x;
}

/* Returns the half-widths [dim] in cells of particle p of a view: its own, or those of its kind. */
MPM_INLINE const PetscReal *MPMHalfWidths(int dim, const MPMKind *kinds, const MPMView *view, PetscInt p)
{
  return view->l ? view->l + p * dim : MPMKindOf(kinds, view, p)->l;
}

/* Returns the number of the cell of position x if the patch owns it, else MPM_ELSEWHERE or MPM_NOWHERE. base [dim] is
   its base node. */
MPM_INLINE PetscInt MPMOwnCell(int dim, MPMBasis basis, const MPMPatch *patch, PetscInt copy, const PetscReal x[],
                               const PetscReal l[], PetscInt base[])
{
  PetscReal xi[3];
  PetscInt  at[3] = {0};

  if (!MPMLocate(dim, basis, patch->grid, copy, x, l, xi, base)) return MPM_NOWHERE;
  for (int d = 0; d < dim; d++) {
    at[d] = base[d] - patch->own_lo[d];
    if (at[d] < 0 || at[d] >= patch->own_n[d]) return MPM_ELSEWHERE;
  }
  return MPMTileCell(dim, &patch->tiles, at);
}

#endif
