/* grid.h - the geometry of the background grid. It stays the same during a run. */
#ifndef MPM_GRID_H
#define MPM_GRID_H

#include "physics/basis.h"

extern const char *const MPMBasisNames[]; /* [MPMBasis] */

#define MPM_MAX_COPIES 32 /* largest number of copies of the nodes */

/* Node ijk is at lower + ijk*h, 0 <= ijk <= cells. On an axis with walls, `layers` more nodes lie beyond each face; on
   a periodic axis node `cells` is node 0 again.

   Bodies that may part from each other have nodes of their own: `copies` of the grid's nodes, which have `places` one
   after the other along axis `stack`, where node i of copy c has the number MPMGridFirst + i. Copies that are far from
   each other share a place (step/contact_places.c), so there are as many places as are near each other. The first place
   has all nodes, another one only low .. high-1 on axis `stack`, among which its copies have their matter. Numbers of
   nodes and of cells are such ones, and MPMGridFold finds where one lies; the DMDA, its cuts, tiles and messages know
   nothing of copies. */
typedef struct {
  PetscInt  dim, cells[3], layers[3], nodes[3]; /* nodes that are stored per axis, layers and places included */
  PetscInt  copies, stack, stride; /* copies: 0 or 1 where all bodies share the nodes; stride: nodes of a whole place */
  PetscInt  places, place[MPM_MAX_COPIES];             /* places is 0 or 1 where all copies are at the same one */
  PetscInt  low[MPM_MAX_COPIES], high[MPM_MAX_COPIES]; /* of each place; high 0: it has all nodes */
  PetscInt  first[MPM_MAX_COPIES];                     /* the number that node 0 of a place has or would have */
  PetscReal lower[3], upper[3], h[3];                  /* m */
  PetscBool periodic[3];
  PetscBool by_h;  /* -grid_h gave the cells, not -grid_cells */
  PetscBool round; /* x and y are r and z of bodies of revolution (-geometry axisymmetric) */
  PetscBool total; /* weights and cells are those of reference positions, field X (docs/method.md, The total frame) */
  MPMWallBasis wall_basis[3]; /* form of the splines at the walls of each axis */
} MPMGrid;

#define MPM_GRID_APART 4 /* nodes below node 0 that count to the same place, for what looks beyond faces */

/* Returns the place of the copies that number i of a node on the stacked axis belongs to. */
MPM_INLINE PetscInt MPMGridPlace(const MPMGrid *grid, PetscInt i)
{
  PetscInt place = PetscMax(1, grid->places) - 1;

  while (place > 0 && i < grid->first[place] + grid->low[place] - MPM_GRID_APART) place--;
  return place;
}

/* Returns the number on axis d of the node 0 of a place; of a copy. */
MPM_INLINE PetscInt MPMGridFirstOf(const MPMGrid *grid, PetscInt d, PetscInt place)
{
  return place && d == grid->stack ? grid->first[place] : 0;
}

MPM_INLINE PetscInt MPMGridFirst(const MPMGrid *grid, PetscInt d, PetscInt copy)
{
  return MPMGridFirstOf(grid, d, grid->place[copy]);
}

/* Sets x [3] to where node ijk [3] of a copy is, m. */
MPM_INLINE void MPMGridNodeAt(const MPMGrid *grid, const PetscInt ijk[], PetscReal x[])
{
  for (PetscInt d = 0; d < 3; d++) x[d] = d < grid->dim ? grid->lower[d] + (PetscReal)ijk[d] * grid->h[d] : 0;
}

/* Returns where on axis d of the grid a node with the number i there is. */
MPM_INLINE PetscInt MPMGridFold(const MPMGrid *grid, PetscInt d, PetscInt i)
{
  return d == grid->stack && grid->places > 1 ? i - MPMGridFirstOf(grid, d, MPMGridPlace(grid, i)) : i;
}

void      MPMGridSetNodes(MPMGrid *, MPMBasis);    /* sets layers and nodes from the other members */
PetscReal MPMGridNodes(const MPMGrid *, MPMBasis); /* nodes in the arrays of one process that has the whole grid */
PetscReal MPMGridSmallestH(const MPMGrid *);       /* m */

#endif
