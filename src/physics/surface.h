/* surface.h - closed surfaces: the edges of a polygon in 2-D, or triangles in 3-D. What is enclosed by an odd number of
   surfaces is inside. Places are asked for along lines parallel to the last axis. */
#ifndef MPM_SURFACE_H
#define MPM_SURFACE_H

#include "base/base.h"

/* n faces of dim corners each: edges or triangles. Bins of the other axes list the faces that can meet a line. */
typedef struct {
  PetscInt   dim, n;
  PetscReal *corner;                   /* [n][dim][dim] coordinates of the corners, m */
  PetscReal  lower[3], upper[3];       /* the box around the surface, m */
  PetscInt   bins[2], *first, *member; /* bins on the axes before the last; [bins + 1] where each begins in member */
  PetscReal  line[2], *crossing;       /* the last line that was asked for; its crossings, m, in ascending order */
  PetscInt   ncrossings;               /* -1: none was asked for */
} MPMSurface;

/* surface.c describes these functions; none is collective. */
MPMSurface *MPMSurfaceCreate(PetscInt dim, PetscInt n, const PetscReal corner[]);
void        MPMSurfaceDestroy(MPMSurface **);
PetscInt    MPMSurfaceLine(MPMSurface *, const PetscReal x[]);

/* Returns how many crossings of the last line are at x, m, or below it; an odd number is inside. */
MPM_INLINE PetscInt MPMSurfaceBelow(const MPMSurface *s, PetscReal x)
{
  PetscInt k = 0;

  while (k < s->ncrossings && s->crossing[k] <= x) k++;
  return k;
}

#endif
