/* transfer_lanes.c - the instances of the kernels of transfer.h for each dim; it is compiled once for each number of
   lanes. What the instances do not distinguish costs one branch in each block. */
#include "kernels/g2p.h"

#define MPM_INSTANCES(dim)                                                                                             \
  static void P2G_##dim(const MPMParams *par, MPMPatch *patch, PetscInt parts, MPMStatus *status)                      \
  {                                                                                                                    \
    (void)status;                                                                                                      \
    MPMP2G(dim, par, patch, parts);                                                                                    \
  }                                                                                                                    \
  static void G2P_##dim(const MPMParams *par, MPMPatch *patch, PetscInt parts, MPMStatus *status)                      \
  {                                                                                                                    \
    MPMG2P(dim, par, patch, parts, status);                                                                            \
  }
MPM_INSTANCES(1)
MPM_INSTANCES(2)
MPM_INSTANCES(3)

const MPMKernel MPM_LANES_NAME(MPMKernels)[3][2] = {{P2G_1, G2P_1}, {P2G_2, G2P_2}, {P2G_3, G2P_3}};
