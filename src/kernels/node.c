/* node.c - the table of the numbers of a node, for code that treats them all alike. */
#include "kernels/transfer.h"

/* What a snapshot shows, the phases before it make; and it knows how to show these numbers of components. */
#define dim                    3
#define MPM_SHOWN(dataset, nc) (sizeof(dataset) == 1 || (nc) == 1 || (nc) == 3 || (nc) == 6)
#define MPM_NODE_CORE(name, member, nc, part, dataset, unit, meaning)                                                  \
  _Static_assert(sizeof(dataset) == 1 || (part) & (MPM_P2G_MASS | MPM_P2G_MOMENTUM), #name " is not made");
#define MPM_NODE_SUM(name, nc, part, reads, dataset, unit, meaning)                                                    \
  _Static_assert(sizeof(dataset) == 1 || (part) & (MPM_P2G_MASS | MPM_P2G_MOMENTUM), #name " is not made");            \
  _Static_assert(MPM_SHOWN(dataset, nc), #name " has other components than 1, 3 or 6");
#include "kernels/node.def"
#undef dim

const MPMNodeGroup MPMNodeGroups[] = {
#define MPM_NODE_CORE(name, member, nc, part, dataset, unit, meaning)                                                  \
  {#name, dataset, unit, MPM_IS_CORE, MPM_NODE_##name, part, 0, MPMNodeComponents_##name},
#define MPM_NODE_SHARE(name, place, nc, part, unit, meaning)                                                           \
  {#name, "", unit, MPM_IS_SHARE, place, part, 0, MPMNodeComponents_##name},
#define MPM_NODE_MOTION(name, nc, dataset, unit, meaning)                                                              \
  {#name, dataset, unit, MPM_IS_MOTION, 0, 0, 0, MPMNodeComponents_##name},
#define MPM_NODE_VALUE(name, nc, unit, meaning) {#name, "", unit, MPM_IS_VALUE, 0, 0, 0, MPMNodeComponents_##name},
#define MPM_NODE_SUM(name, nc, part, reads, dataset, unit, meaning)                                                    \
  {#name, dataset, unit, MPM_IS_SUM, MPM_NODE_##name, part, reads, MPMNodeComponents_##name},
#include "kernels/node.def"
    {NULL, NULL, NULL, MPM_IS_CORE, 0, 0, 0, NULL}};
