/* fit.h - how well the particles of a body fill its shape. It is used before the first step. */
#ifndef MPM_FIT_H
#define MPM_FIT_H

#include "scene/scene.h"

#define MPM_FIT_MOST 0.15 /* of the volume of a shape, by which that of its particles may differ from it */

/* fit.c describes these functions; none is collective. */
PetscReal MPMFitVolume(const MPMBody *, PetscInt dim);
void      MPMFitTell(const MPMBody *, const MPMGrid *, PetscReal volume, char text[MPM_TEXT_LEN]);

/* Refuses a body that has no particles, and says why it has none. Not collective. */
void MPMFitRefuse(MPMOptions, const MPMGrid *, const MPMBody *);
/* Writes what places a body, and what to do if it is far too large for the grid. */
void MPMFitPlace(const MPMBody *, PetscBool huge, char text[], size_t len);

#endif
