/* node_sums.h - what particles give the sums of nodes that node.def lists as MPM_NODE_SUM: for each row a function
   Give_<name>. All of them are summed by phi. */
#ifndef MPM_NODE_SUMS_H
#define MPM_NODE_SUMS_H

#include "kernels/records.h"
#include "kernels/stencils.h"
#include "kernels/transfer.h"

/* What they get: the constants of a step, the patch, the order and the stencils of a block, and the first of MPM_WIDTH
   of its lanes. They set the components q of these particles; fields are read by MPMLoad, and those that the row names
   are NULL where the scene has none. */
#define MPM_MAYBE __attribute__((unused)) /* some need it, some do not */
#define MPM_GIVE_ARGUMENTS                                                                                             \
  MPM_MAYBE int dim, MPM_MAYBE const MPMParams *par, MPM_MAYBE const MPMPatch *patch,                                  \
      MPM_MAYBE const MPMBlockOrder *o, MPM_MAYBE const MPMStencils *s, MPM_MAYBE PetscInt l, MPMReal *q

/* Sets the records of a block for line `line` of the sums, of which these parts are summed. */
MPM_INLINE void MPMStageLine(int dim, const MPMParams *par, const MPMPatch *patch, PetscInt parts, int line,
                             const MPMBlockOrder *o, const MPMStencils *s, MPMRecords *r)
{
  (void)dim, (void)par, (void)patch, (void)parts, (void)line, (void)s;
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
    MPMReal all[MPM_NODE_NC];

    for (int c = 0; c < MPM_NODE_NC; c++) all[c] = MPMAll(0);
#define MPM_NODE_SUM(name, nc, part, reads, dataset, unit, meaning)                                                    \
  if ((parts & (part)) && line == MPM_NODE_##name / MPM_NODE_NC)                                                       \
    Give_##name(dim, par, patch, o, s, l, all + MPM_NODE_##name % MPM_NODE_NC);
#include "kernels/node.def"
    MPMWriteRecords(MPM_NODE_NC, all, r->Q[l][0], MPM_Q_RECORDS);
  }
}

#endif
