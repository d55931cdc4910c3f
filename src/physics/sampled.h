/* sampled.h - the signed distance from many faces in 3-D, sampled on a lattice: it takes the same short time
   everywhere, whereas the search for the nearest of many small faces is slow (nearest.h). */
#ifndef MPM_SAMPLED_H
#define MPM_SAMPLED_H

#include "physics/nearest.h"

/* Returns -1 for a place x [3] that is inside, else 1; at: the nearest place of the faces, at the distance, m, or NULL
   if none is within reach. */
typedef PetscReal (*MPMSide)(const void *context, const PetscReal x[], PetscReal distance, const PetscReal at[]);

typedef struct {
  PetscInt    n[3];                        /* places of the lattice on each axis */
  PetscReal   lower[3], spacing[3], reach; /* the first place; m */
  float      *distance;                    /* [n[0]][n[1]][n[2]] m, between -reach and reach */
  MPMSide     sign;
  const void *context;
} MPMSampledDistance;

/* Samples the distance from the faces of a tree in the box around them, enlarged by the reach of the tree: 4 bytes for
   each place. Returns NULL if there is no memory. MPMSampledDestroy frees it, or does nothing if it is NULL. */
MPMSampledDistance *MPMSampledCreate(const MPMNearest *, const PetscReal spacing[3], MPMSide, const void *context);
void                MPMSampledDestroy(MPMSampledDistance **);

/* Returns the distance of x [3], m, by cubic interpolation (Catmull and Rom 1974), and sets n [3] to its gradient
   divided by its length. Beyond the lattice it is the reach. Not collective. */
PetscReal MPMSampledAt(const MPMSampledDistance *, const PetscReal x[], PetscReal n[]);

#endif
