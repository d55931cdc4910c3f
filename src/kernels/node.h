/* node.h - the numbers of a node, as node.def lists them: their places in the record of sums, their components, and the
   table of their names. */
#ifndef MPM_NODE_H
#define MPM_NODE_H

#include "base/base.h"

/* The first line of a node's sums: the same record in every dimension, as long as one vector of 8 numbers or a whole
   number of shorter ones, and in one line of the cache. */
typedef struct {
#define MPM_NODE_CORE(name, member, nc, part, dataset, unit, meaning) PetscReal member;
#include "kernels/node.def"
  PetscReal none;
} MPMNode;
#define MPM_NODE_NC 8 /* numbers of a line, for vectors and messages */
_Static_assert(sizeof(MPMNode) == MPM_NODE_NC * sizeof(PetscReal), "a line of sums is one line of the cache");

/* MPM_NODE_<name> is the first number of a group of sums in the record: number % MPM_NODE_NC of line number /
   MPM_NODE_NC. A group has room for its components in 3-D, and is in one line. */
#define dim 3
enum {
#define MPM_NODE_CORE(name, member, nc, part, dataset, unit, meaning)                                                  \
  MPM_NODE_##name, MPM_NODE_LAST_##name = MPM_NODE_##name + (nc)-1,
#include "kernels/node.def"
  MPM_NODE_BEFORE = MPM_NODE_NC - 1,
#define MPM_NODE_SUM(name, nc, part, reads, dataset, unit, meaning)                                                    \
  MPM_NODE_FREE_##name,                                                                                                \
      MPM_NODE_##name      = MPM_NODE_FREE_##name % MPM_NODE_NC + (nc) > MPM_NODE_NC                                   \
                                 ? (MPM_NODE_FREE_##name / MPM_NODE_NC + 1) * MPM_NODE_NC                              \
                                 : MPM_NODE_FREE_##name,                                                               \
      MPM_NODE_LAST_##name = MPM_NODE_##name + (nc)-1,
#include "kernels/node.def"
  MPM_NODE_NUMBERS
};
#define MPM_NODE_SUM(name, nc, part, reads, dataset, unit, meaning)                                                    \
  _Static_assert((nc) <= MPM_NODE_NC, #name " has more numbers than a line: divide it");
#include "kernels/node.def"
#undef dim
#define MPM_NODE_LINES ((MPM_NODE_NUMBERS + MPM_NODE_NC - 1) / MPM_NODE_NC)
_Static_assert(offsetof(MPMNode, p) == MPM_NODE_momentum * sizeof(PetscReal), "momentum follows the mass");
_Static_assert(offsetof(MPMNode, f) == MPM_NODE_force * sizeof(PetscReal), "forces begin at their place");
_Static_assert(MPM_NODE_force == 4, "forces are the upper half of the first line, as the innermost loops need it");

/* The components of each group. */
#define MPM_NODE_COMPONENTS(name, nc)                                                                                  \
  MPM_INLINE PetscInt MPMNodeComponents_##name(PetscInt dim)                                                           \
  {                                                                                                                    \
    (void)dim;                                                                                                         \
    return nc;                                                                                                         \
  }
#define MPM_NODE_CORE(name, member, nc, part, dataset, unit, meaning) MPM_NODE_COMPONENTS(name, nc)
#define MPM_NODE_SHARE(name, place, nc, part, unit, meaning)          MPM_NODE_COMPONENTS(name, nc)
#define MPM_NODE_SUM(name, nc, part, reads, dataset, unit, meaning)   MPM_NODE_COMPONENTS(name, nc)
#define MPM_NODE_MOTION(name, nc, dataset, unit, meaning)             MPM_NODE_COMPONENTS(name, nc)
#define MPM_NODE_VALUE(name, nc, unit, meaning)                       MPM_NODE_COMPONENTS(name, nc)
#include "kernels/node.def"

/* The motion of a node: velocity [dim] in m/s and acceleration [dim] in m/s^2. */
#define MPM_MOTION_NC(dim)                                (2 * (dim))
#define dim                                               3
#define MPM_NODE_MOTION(name, nc, dataset, unit, meaning) +(nc)
_Static_assert(MPM_MOTION_NC(dim) == 0
#include "kernels/node.def"
               ,
               "the motion of a node is what the transfer to particles interpolates");
#undef dim

/* The values of nodes that are not sent, each [nodes of the arrays][components]. */
typedef struct {
#define MPM_NODE_VALUE(name, nc, unit, meaning) PetscReal *name;
#include "kernels/node.def"
} MPMNodeValues;

/* Returns whether `met` of a node says that along axis d the advance met a wall that only pushes; MPMNodeStopped: that,
   or a piston that holds its column of nodes. */
MPM_INLINE PetscBool MPMNodeMet(PetscReal met, PetscInt d)
{
  return (PetscInt)met >> d & 1 ? PETSC_TRUE : PETSC_FALSE;
}

MPM_INLINE PetscBool MPMNodeStopped(PetscReal met, PetscInt d)
{
  return (PetscInt)met >> d & 9 ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the numbers of a node: in so many lines of sums, and in motion and values. */
MPM_INLINE PetscInt MPMNodeNumbers(PetscInt dim, PetscInt lines)
{
  PetscInt n = lines * MPM_NODE_NC + MPM_MOTION_NC(dim);

#define MPM_NODE_VALUE(name, nc, unit, meaning) n += MPMNodeComponents_##name(dim);
#include "kernels/node.def"
  return n;
}

/* The table of node.def. at: the first number in the record, of sums. */
typedef enum { MPM_IS_CORE, MPM_IS_SHARE, MPM_IS_SUM, MPM_IS_MOTION, MPM_IS_VALUE } MPMNodeHome;
typedef struct {
  const char *name, *dataset, *unit;
  MPMNodeHome home;
  PetscInt    at, part, reads;
  PetscInt (*components)(PetscInt dim);
} MPMNodeGroup;
extern const MPMNodeGroup MPMNodeGroups[]; /* ends with NULL */

#endif
