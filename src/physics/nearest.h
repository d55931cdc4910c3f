/* nearest.h - which place of many faces is nearest to another: faces are points in 1-D, edges in 2-D, triangles in 3-D.
   */
#ifndef MPM_NEAREST_H
#define MPM_NEAREST_H

#include "base/base.h"

/* n faces of dim corners each, in the sequence of a tree: leaf k has the MPM_LEAF faces from MPM_LEAF k on, and node k
   of the tree is the box around nodes 2 k + 1 and 2 k + 2. */
typedef struct {
  PetscInt   dim, n, first; /* first: number of the first leaf among the nodes, a power of 2 less 1 */
  PetscReal *corner;        /* [n][dim][dim] m */
  PetscReal *box;           /* [2 first + 1][2][dim] m, lower corner and upper one */
  PetscReal  reach;         /* m */
} MPMNearest;

#define MPM_LEAF 4

/* Makes the tree of faces, corner [n][dim][dim] in m, which are copied; places further than `reach`, m, from all of
   them are not told apart. Returns NULL if there is no memory. MPMNearestDestroy frees it, or does nothing if it is
   NULL. */
MPMNearest *MPMNearestCreate(PetscInt dim, PetscInt n, const PetscReal corner[], PetscReal reach);
void        MPMNearestDestroy(MPMNearest **);

/* Sets at [dim] to the place of the faces that is nearest to x [dim], m, and returns its distance, m, and the number of
   its face in *face; if none is within reach, it returns reach and sets *face to -1. *face is a guess, or -1 if there
   is none: with a good one it takes less time. It takes O(log n) for places near the faces, and less far away; the more
   faces are about as near as the nearest, the longer. After Ericson, Real-Time Collision Detection (2005), 5.1. Not
   collective. */
PetscReal MPMNearestPlace(const MPMNearest *, const PetscReal x[], PetscReal at[], PetscInt *face);

/* Sets n [dim] to the unit normal of a face, to one side or the other, and returns whether it has one. */
PetscBool MPMNearestNormal(const MPMNearest *, PetscInt face, PetscReal n[]);

#endif
