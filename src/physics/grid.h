/* grid.h - the geometry of the background grid. It stays the same during a run. */
#ifndef MPM_GRID_H
#define MPM_GRID_H

#include "physics/basis.h"

extern const char *const MPMBasisNames[]; /* [MPMBasis] */

/* Node ijk is at lower + ijk*h, 0 <= ijk <= cells. On an axis with walls, `layers` more nodes lie beyond each face; on
   a periodic axis node `cells` is node 0 again. */
typedef struct {
  PetscInt     dim, cells[3], layers[3], nodes[3]; /* nodes that are stored per axis, layers included */
  PetscReal    lower[3], upper[3], h[3];           /* m */
  PetscBool    periodic[3];
  MPMWallBasis wall_basis[3]; /* form of the splines at the walls of each axis */
} MPMGrid;

void      MPMGridSetNodes(MPMGrid *, MPMBasis);    /* sets layers and nodes from the other members */
PetscReal MPMGridNodes(const MPMGrid *, MPMBasis); /* nodes in the arrays of one process that has the whole grid */
PetscReal MPMGridSmallestH(const MPMGrid *);       /* m */

#endif
