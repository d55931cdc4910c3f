/* chains.c - fused multiply-adds in registers, whose rate roofline.c takes as the limit of a core. It is compiled once
   for each number of lanes. */
#include "cost/cost.h"

/* MPM_CHAINS independent sequences hide the latency of an instruction. start and end keep the compiler from removing
   them. */
#define MPM_CHAINS 16
PetscReal MPM_LANES_NAME(MPMChains)(PetscInt n, PetscReal start, volatile PetscReal *end)
{
  MPMReal x[MPM_CHAINS];

  for (int k = 0; k < MPM_CHAINS; k++) x[k] = MPMAll(start + 1e-9 * k);
  for (PetscInt i = 0; i < n; i++)
    for (int k = 0; k < MPM_CHAINS; k++) x[k] = MPMFma(x[k], MPMAll(0.999999999), MPMAll(1e-9));
  for (int k = 0; k < MPM_CHAINS; k++) {
    PetscReal lane[MPM_WIDTH];

    memcpy(lane, &x[k], sizeof lane);
    *end = lane[0];
  }
  return (PetscReal)n * MPM_CHAINS * MPM_WIDTH * 2;
}
