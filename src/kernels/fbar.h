/* fbar.h - F-bar (-method_locking fbar): in each step all particles of a material in a box of cells change their volume
   by the same factor, and they have the same pressure. docs/method.md has the formulas.

   Before a particle's state is updated, its deformation of the step, I + dt L, is scaled so that its determinant is the
   mean of those of the box, weighted by volumes; shear and rotation stay. The pressure in the forces is the mean that
   does the same work. A box has 1, 2 or 4 cells on an axis, where a cell is named by its base node, and lies within one
   tile: so no box is cut between processes. Its particles are added in the sequence of the order, which is the same
   however the grid is cut. patch->boxes has the sums, which are 0 before a phase: for each box and material the volume
   of the particles, and that volume times what is averaged. In the total frame the volumes are those of the motion,
   whose gradient is F times the field bar; all else is the same. */
#ifndef MPM_FBAR_H
#define MPM_FBAR_H

#include "kernels/stencils.h"

/* Sums the volumes at the start of the step, and their growth, of all particles of the patch. */
void MPM_LANES_NAME(MPMSumGrowth)(int dim, const MPMParams *, MPMPatch *);

/* Changes the velocity gradients L of a block so that I + dt L has the means of the boxes. */
void MPM_LANES_NAME(MPMShareGrowth)(int dim, const MPMParams *, MPMPatch *, const MPMBlockOrder *, const MPMStencils *,
                                    MPMComponent *L);

/* Sums the volumes and the mean normal stresses of the particles of n ranges of the order, which are whole tiles. */
void MPM_LANES_NAME(MPMSumPressures)(int dim, const MPMParams *, MPMPatch *, PetscInt n, const MPMRange *runs);

/* Gives the stresses b->tau of a block the means of the boxes: J times a mean Cauchy stress in place of the own mean. */
void MPM_LANES_NAME(MPMSharePressure)(int dim, const MPMParams *, MPMPatch *, const MPMBlockOrder *,
                                      const MPMStencils *, MPMBlock *b);

#endif
