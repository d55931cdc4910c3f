/* light.h - light nodes: nodes at the edge of matter that have nearly no mass. The equation of motion of such a node
   has one particle alone, at a place where its stress and its load have little to do with each other; at rest it would
   set a wrong stress in that particle. So a light node is accelerated with the next nodes inside, linearly extrapolated
   on each axis on which it is light, and these get its mass and force by the same weights. Its velocity before stays
   its own. docs/method.md has more (Light nodes). */
#ifndef MPM_LIGHT_H
#define MPM_LIGHT_H

#include "kernels/patch.h"

/* A light node, an index of the patch's arrays, and on each axis the side on which it is light: -1, 1 or 0. Its
   carriers are the nodes 1 and 2 steps that way on each of these axes, with the products of the weights 2 and -1. */
typedef struct {
  PetscInt node;
  int      side[3];
} MPMLightNode;

/* The light nodes that have to do with a patch, in the sequence of its arrays: own ones, and others whose carriers are
   own nodes. mass [nodes of the arrays], kg, is 0 where no particle is; given [nodes of the arrays][MPM_LIGHT_GIVEN] is
   scratch, 0 between uses. */
typedef struct {
  PetscInt      n, room;
  MPMLightNode *node;
  PetscReal    *mass, *given;
  char    *held;   /* [nodes of the arrays] is not 0 at nodes where matter touches other matter, which are never light;
                           or NULL: there are none */
  MPMSpan *filled; /* [rows of the arrays] where own rows of mass are not 0 */
} MPMLight;
#define MPM_LIGHT_GIVEN 4

/* How far around its own nodes a patch has to know the mass and the sums of others. */
#define MPM_LIGHT_LAYERS 3

/* Before the advance, MPMLightMass copies the masses of own nodes to light->mass, MPMLightFind lists the light nodes by
   par->light, and MPMLightGive changes the forces of own carriers, so that light nodes have their share in these. After
   it MPMLightMove accelerates the light nodes, and corrects the carriers so that momentum and angular momentum are
   kept. None is collective. */
PetscErrorCode MPMLightMass(MPMLight *, const MPMPatch *);
PetscErrorCode MPMLightFind(MPMLight *, const MPMParams *, const MPMPatch *);
void           MPMLightGive(MPMLight *, const MPMParams *, MPMPatch *);
void           MPMLightMove(MPMLight *, const MPMParams *, MPMPatch *);
PetscErrorCode MPMLightDestroy(MPMLight *);

#endif
