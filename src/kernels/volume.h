/* volume.h - the relaxation of volumes (-material_<m>_relaxation), of fluids, and of sand where some is open. The grid
   sees of J only means over a cell or two: what differs between neighbours gets no force and is never removed, and
   nothing else ties J to the distances of particles. So from time to time, before a step, particles take the mean
   volume that the grid sees, and a part of its difference from what the density of the grid tells. docs/method.md has
   the formulas, step/volume.c the times.

   A node sums, in the place of mass and momentum: the volume of matter, of what relaxes V0, since its J is what is
   sought; V0/K of what relaxes; V0/K times J p, of sand -K times its volume strain, which is carried from particle to
   node by the slope that weight gives it; V0 of open sand. Its motion is then, number 0, how full the space of its
   function is, number 1, the mean of J p, and, number 2, if there is sand, the share of open sand. */
#ifndef MPM_VOLUME_H
#define MPM_VOLUME_H

#include "kernels/records.h"
#include "kernels/stencils.h"

#define MPM_OPENED      1e-3                         /* vc of open sand */
#define MPM_VOLUME_SUMS (MPM_NODE_LAST_momentum + 1) /* filled and pressed of node.def */

/* Sets the records of a block of particles for these sums. */
void MPM_LANES_NAME(MPMStageVolumes)(int dim, const MPMParams *, const MPMPatch *, const MPMBlockOrder *,
                                     const MPMStencils *, MPMRecords *);

/* Relaxes the volumes of a block of particles from what its nodes have: values [2 dim] and gradients [dim*dim] of their
   motion. */
void MPM_LANES_NAME(MPMRelaxVolumes)(int dim, const MPMParams *, const MPMPatch *, const MPMBlockOrder *,
                                     const MPMStencils *, const MPMComponent *value, const MPMComponent *gradient);

#endif
