/* sizes.h - cell sizes that divide the box of the grid, for messages. */
#ifndef MPM_SIZES_H
#define MPM_SIZES_H

#include "physics/grid.h"

/* Writes the largest cell size up to `most`, in m, that divides the box, as -grid_h takes it: the same on all axes if there
   is such a one, with few digits if that costs few cells. Not collective. */
void MPMGridSizes(const MPMGrid *, PetscReal most, char text[], size_t len);

/* Writes the option that makes the cells of a scene at least so many times as small: -grid_h, or -grid_cells where the scene
   gives them. Not collective. */
void MPMGridFiner(const MPMGrid *, PetscReal times, char text[], size_t len);

#endif
