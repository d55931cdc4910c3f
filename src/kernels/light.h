/* light.h - light nodes: nodes at the edge of matter that have nearly no mass. Such a node would have an equation of motion
   of its own, which one particle alone enters at a place where its stress and its load have little to do with each other;
   at rest it would set a wrong stress in that particle. So it moves with the next nodes inside: its motion is extrapolated
   from theirs, linearly on each axis on which it is light, and they get its mass, momentum and force by the same weights
   (-method_light_nodes; docs/theory.md). */
#ifndef MPM_LIGHT_H
#define MPM_LIGHT_H

#include "kernels/patch.h"

/* A light node, an index of the patch's arrays, and on each axis the side on which it is bound: -1, 1 or 0. Its carriers are
   the nodes 1 and 2 steps that way on each of these axes, with the products of the weights 2 and -1. */
typedef struct {
  PetscInt node;
  int      side[3];
} MPMLightNode;

/* The light nodes that have to do with a patch, in the sequence of its arrays: own ones, and others whose carriers are own
   nodes; those that are light by `mass` [nodes of the arrays], kg, which is 0 where no particle is. `fresh` are the parts
   of a transfer (transfer.h) whose sums have not been given to the carriers yet. */
typedef struct {
  PetscInt      n, room, fresh;
  MPMLightNode *node;
  PetscReal    *mass;
} MPMLight;

/* How far around its own nodes a patch has to know the mass, and the sums and the motion of others. */
#define MPM_LIGHT_LAYERS 3

/* MPMLightMass copies the masses of own nodes to light->mass; MPMLightFind lists light nodes by par->light;
   MPMLightGive adds the fresh sums of light nodes to those of their carriers here, and takes them from light nodes of its own;
   MPMLightMove sets the motion of light nodes of its own from that of their carriers, and applies walls. Not collective. */
PetscErrorCode MPMLightMass(MPMLight *, const MPMPatch *);
PetscErrorCode MPMLightFind(MPMLight *, const MPMParams *, const MPMPatch *);
void           MPMLightGive(MPMLight *, MPMPatch *);
void           MPMLightMove(const MPMLight *, const MPMParams *, MPMPatch *);
PetscErrorCode MPMLightDestroy(MPMLight *);

#endif
