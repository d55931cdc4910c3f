/* extent.h - how far the matter of a particle reaches from its centre, for what has to know where a body ends: walls
   that act on arrival (step/gaps.c). */
#ifndef MPM_EXTENT_H
#define MPM_EXTENT_H

#include "physics/material.h"

/* Returns half of the extent, m, of a particle's domain along the unit vector n [dim]: the box with half-widths
   half [dim], m, at the start, which the deformation gradient F [dim*dim] deforms: sum_d half_d |e_d . F^T n|. */
MPM_INLINE PetscReal MPMExtent(int dim, const PetscReal half[], const PetscReal F[], const PetscReal n[])
{
  PetscReal all = 0;

  for (int d = 0; d < dim; d++) {
    PetscReal along = 0;

    for (int e = 0; e < dim; e++) along += n[e] * F[e * dim + d];
    all += half[d] * PetscAbsReal(along);
  }
  return all;
}

#endif
