/* shapes.h - how the shapes of bodies are read: from options (read_region.c), vertices (read_polygon.c) and files of
   triangles (read_stl.c). */
#ifndef MPM_SHAPES_H
#define MPM_SHAPES_H

#include "scene/scene.h"

/* Reads the shape of a body. The first fault is left in o. Collective on core->comm. */
PetscErrorCode MPMSceneReadRegion(MPMCore *, MPMOptions, const char name[], MPMRegion *);

/* Sets the surface and the bounds of a polygon or an STL. Collective on core->comm. */
PetscErrorCode MPMSceneReadPolygon(MPMCore *, MPMOptions, const char name[], MPMRegion *);
PetscErrorCode MPMSceneReadSTL(MPMCore *, MPMOptions, const char name[], MPMRegion *);

/* Reads which bodies cut which others; all shapes have been read. Not collective. */
PetscErrorCode MPMSceneReadOthers(MPMScene *, MPMOptions);
PetscErrorCode MPMSceneDestroyRegion(MPMRegion *);

/* Reads a whole file on the first process: *text has *n bytes and a 0 behind them, and is NULL on the others and after
   a fault. The caller frees it. fault: why it cannot be read. Not collective. */
PetscErrorCode MPMSceneReadFile(MPI_Comm, const char path[], char **text, size_t *n, char fault[MPM_TEXT_LEN]);

/* Looks at the first n bytes of a text file: sets *mark to the length of the byte-order mark that text in UTF-8 may
   begin with, which its reader skips, and returns what keeps it from being read, or NULL. Not collective. */
const char *MPMSceneTextFault(const char text[], size_t n, size_t *mark);

#endif
