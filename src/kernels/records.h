/* records.h - what a particle adds to the nodes of its stencil: records of numbers in the sequence of a node's own. */
#ifndef MPM_RECORDS_H
#define MPM_RECORDS_H

#include "kernels/blocks.h"

/* A particle adds phi Q[0] + sum_e dphi_e Q[1+e] + sum_e i_e phi A[e] to node i of its stencil, where each Q and A is a
   record of numbers in the sequence of MPMNode. In 2-D the stress is one record with mass and momentum, since each
   number of it is multiplied by one function of x and one of y:

     number of Q[0]     0   1   2   3   4      5      6      7
     is                 m   p_x p_y 0   t_xy   t_yy   t_xx   t_xy     t = - V0 tau
     times, of x        w   w   w   w   w      w      g      g
     times, of y        w   w   w   w   g      g      w      w

   The sums of 6 and 7 are added to those of 4 and 5 before they go to the tile; phi Q[1] are the loads there. MPMP2G
   zeroes all records once; those that the parts of the phase do not need are never written and stay 0. */
enum { MPM_Q_RECORDS = 4, MPM_A_RECORDS = 3 }; /* records of a particle, in every dimension */
typedef PetscReal MPMRecord[MPM_NODE_NC];
typedef struct {
  MPMRecord Q[MPM_STAGED][MPM_Q_RECORDS], A[MPM_STAGED][MPM_A_RECORDS];
} __attribute__((aligned(64))) MPMRecords;

/* Writes nc numbers of MPM_WIDTH particles to a record of each: `to` is their place in that of the first particle, and
   a particle has `records` records. Pairs are written faster than single numbers, so an odd nc also writes from[nc],
   which is 0, as is that place of the record. */
MPM_INLINE void MPMWriteRecords(int nc, const MPMReal *from, PetscReal *to, int records)
{
  PetscReal *row[MPM_WIDTH];

  for (int k = 0; k < MPM_WIDTH; k++) row[k] = to + k * records * MPM_NODE_NC;
  MPMWriteRows(nc + nc % 2, from, row);
}

#endif
