/* affine.h - the affine velocities of particles, which some transfers keep beside their velocities (C in transfer.h). */
#ifndef MPM_AFFINE_H
#define MPM_AFFINE_H

#include "kernels/p2g.h"
#include "kernels/rare.h"

/* Computes the affine velocities C of a block (APIC). With a basis without inertia they are the velocity gradient L,
   which C has if the phase computes it and F-bar does not change it; else sum phi v (x_i - x) over the inertia, which
   is computed as a gradient with g = w (i - at). That overwrites s->g, so it comes after all that needs g. Of the
   symmetric part of C, the strain rate, the share par->strain is kept; the rotation is kept whole. C is memory for
   them, before they are written to their rows. */
MPM_INLINE void MPMAffine(int dim, const MPMParams *par, PetscInt parts, const MPMPatch *patch, const MPMBlockOrder *o,
                          MPMStencils *s, MPMComponent *C)
{
  const int ns = MPMBasisNodes(patch->basis), inertia = MPMBasisInertia(patch->basis);

  for (int d = 0; d < dim && inertia; d++)
    for (int i = 0; i < ns; i++)
      for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
        const MPMReal away = MPMAll(i) - MPMRead(&s->at[d][l]);
        MPMWrite(&s->g[d][i][l], MPMRead(&s->w[d][i][l]) * away * ((PetscReal)inertia / patch->grid->h[d]));
      }
  if (par->own_inertia && s->walled) MPMRareInertia(dim, patch->basis, patch->grid, o->n, s);
  if (inertia || !(parts & MPM_G2P_STRESS) || (parts & MPM_G2P_FBAR))
    MPM_LANES_NAME(MPMInterpolateBlock)[dim - 1][ns - 2][0][1](o, s, patch->n, patch->motion, NULL, C);
  for (int d = 0; d < dim && par->strain != 1; d++)
    for (int e = 0; e <= d; e++)
      for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
        const MPMReal a = MPMRead(&C[d * dim + e][l]), b = MPMRead(&C[e * dim + d][l]);
        const MPMReal strain = par->strain * 0.5 * (a + b), spin = 0.5 * (a - b);

        MPMWrite(&C[d * dim + e][l], strain + spin);
        MPMWrite(&C[e * dim + d][l], strain - spin);
      }
  MPMScatter(dim * dim, C, o, 0, o->n, patch->particles.C);
}

#endif
