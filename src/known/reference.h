/* reference.h - known solutions: exact ones, and manufactured ones, which become exact by a body force. A scene takes
   its initial state and its body force from them, and its results are compared with them.

   A new one is one row of reference.def and two functions, <name>_check and <name>_at, in reference.c. All are
   functions of the position X at rest and the time t: the displacement is u(X, t), the position x = X + u. Nothing here
   is collective. */
#ifndef MPM_REFERENCE_H
#define MPM_REFERENCE_H

#include "physics/material.h"
#include "physics/region.h"
#include "physics/wall.h"

/* The data that the solutions need: the grid, the one body of the scene and its material. */
typedef struct {
  PetscInt      dim;
  PetscReal     grid_lower[3], grid_upper[3]; /* box of the grid, m */
  MPMWall       walls[3][2];                  /* [axis][side] */
  MPMRegionType shape;                        /* of the body */
  PetscReal     lower[3], upper[3];           /* box around the body at rest, m */
  PetscReal     center[3];                    /* centre of an annulus, m */
  PetscReal     inner_radius, radius;         /* radii of an annulus, m */
  const char   *model;                        /* name of the material law */
  PetscReal     rho, E, nu, lambda, mu;       /* kg/m^3, Pa, 1, Pa, Pa */
  PetscReal     c, cp;                        /* sqrt(E/rho), sqrt((lambda + 2 mu)/rho), m/s */
  PetscReal     gravity[3];                   /* m/s^2 */
  PetscReal     amplitude;                    /* A: amplitude of the displacement, m; for vortex, of the angle, rad */
  PetscInt      mode;                         /* n >= 1: half waves of shear and standing; number of the mode */
  PetscReal     period;                       /* T of vortex, s; it is 1 in the source */
} MPMReferenceData;

/* One solution. All functions read X [dim] in m, inside the body at rest, and t in s. */
typedef struct _MPMReference MPMReference;
struct _MPMReference {
  const char *name, *what;
  PetscBool   manufactured; /* it needs a body force */
  const char *parameters;   /* the members of the data that it reads: amplitude mode period, with blanks between */
  /* returns what keeps the scene from being this solution, as "needs ..." in one line; or NULL */
  const char *(*check)(const MPMReferenceData *);
  void (*displacement)(const MPMReferenceData *, const PetscReal X[], PetscReal t, PetscReal u[]); /* [dim] m */
  void (*velocity)(const MPMReferenceData *, const PetscReal X[], PetscReal t, PetscReal v[]);     /* du/dt [dim] m/s */
  /* body force per mass besides gravity, u_tt - Div P/rho [dim] m/s^2; NULL: there is none */
  void (*acceleration)(const MPMReferenceData *, const PetscReal X[], PetscReal t, PetscReal b[]);
  /* F = I + du/dX, row-major [dim*dim]; with u, it is the initial state where that is strained (bar; axis in 3-D) */
  void (*deformation)(const MPMReferenceData *, const PetscReal X[], PetscReal t, PetscReal F[]);
};

extern const MPMReference MPMReferences[]; /* the rows of reference.def; the last entry has no name */

const MPMReference *MPMReferenceFind(const char name[]); /* NULL: there is no such row */

#endif
