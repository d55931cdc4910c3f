/* volume.h - the relaxation of the volumes of fluids (-material_<m>_relaxation). The grid sees of J only means over a
   cell or two: what differs between neighbours gets no force and is never removed, and nothing else ties J to the
   distances of particles. So from time to time, before a step, J takes the mean that the grid sees, and a part of the
   difference from the volume that the density of the grid tells. docs/theory.md has the formulas, step/volume.c the
   times.

   A node sums, in the place of mass and momentum: the volume of matter (of fluids V0, since their J is what is sought);
   V0/K of fluids; and V0/K times J p, which is carried from particle to node by the slope rho g that weight gives it.
   Its motion is then, number 0, how full the space of its function is, and, number 1, the mean of J p. */
#ifndef MPM_VOLUME_H
#define MPM_VOLUME_H

#include "kernels/records.h"

/* Sets the records of a block of particles for these sums. */
void MPM_LANES_NAME(MPMStageVolumes)(int dim, const MPMParams *, const MPMPatch *, const MPMBlockOrder *,
                                     const MPMStencils *, MPMRecords *);

/* Relaxes J of a block of particles from what its nodes have: values [2 dim] and gradients [dim*dim] of their motion. */
void MPM_LANES_NAME(MPMRelaxVolumes)(int dim, const MPMParams *, const MPMPatch *, const MPMBlockOrder *,
                                     const MPMStencils *, const MPMComponent *value, const MPMComponent *gradient);

#endif
