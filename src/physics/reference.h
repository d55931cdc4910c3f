/* reference.h - solutions that are known: exact ones, and manufactured ones, which a body force of their own makes
   exact. They give a scene its start and its force, and its results their error.

   A new one is one row of reference.def and one pair of functions, <name>_check and <name>_at, in reference.c. All are
   functions of the place X at rest and of the time t: u(X, t), the place is x = X + u. Nothing here is collective.   */
#ifndef MPM_REFERENCE_H
#define MPM_REFERENCE_H

#include "physics/material.h"
#include "physics/region.h"
#include "physics/wall.h"

/* What the solutions know of the scene: its grid, its one body and the body's material. */
typedef struct {
  PetscInt      dim;
  PetscReal     grid_lower[3], grid_upper[3]; /* box of the grid, m */
  MPMWall       walls[3][2];                  /* [axis][side] */
  MPMRegionType shape;                        /* of the body */
  PetscReal     lower[3], upper[3];           /* box around the body at rest, m */
  PetscReal     center[3];                    /* of an annulus, m */
  PetscReal     inner_radius, radius;         /* of an annulus, m */
  const char   *model;                        /* name of the material law */
  PetscReal     rho, E, nu, lambda, mu;       /* kg/m^3, Pa, 1, Pa, Pa */
  PetscReal     c, cp;                        /* sqrt(E/rho), sqrt((lambda + 2 mu)/rho), m/s */
  PetscReal     gravity[3];                   /* m/s^2 */
  PetscReal     amplitude;                    /* A: of the displacement, m; of vortex: of the angle, rad */
  PetscInt      mode;                         /* n >= 1: half waves of shear and standing, number of mode's mode */
  PetscReal     period;                       /* T of vortex, s; its sources have 1 */
} MPMReferenceData;

/* One solution. All functions read X [dim] in m, inside the body at rest, and t in s. */
typedef struct _MPMReference MPMReference;
struct _MPMReference {
  const char *name, *what;
  PetscBool   manufactured; /* has it a body force of its own? */
  const char *parameters;   /* of the data that it reads: amplitude mode period, with blanks between */
  /* What keeps the scene from being this solution, as "needs ..." in one line; or NULL. */
  const char *(*check)(const MPMReferenceData *);
  void (*displacement)(const MPMReferenceData *, const PetscReal X[], PetscReal t, PetscReal u[]); /* [dim] m */
  void (*velocity)(const MPMReferenceData *, const PetscReal X[], PetscReal t, PetscReal v[]);     /* du/dt [dim] m/s */
  /* body force per mass besides gravity, u_tt - Div P/rho [dim] m/s^2; NULL: there is none */
  void (*acceleration)(const MPMReferenceData *, const PetscReal X[], PetscReal t, PetscReal b[]);
  /* F = I + du/dX, row-major [dim*dim]: with u, the state of a start that is not at rest (bar; axis in 3-D) */
  void (*deformation)(const MPMReferenceData *, const PetscReal X[], PetscReal t, PetscReal F[]);
};

extern const MPMReference MPMReferences[]; /* rows of reference.def; the last has no name */

const MPMReference *MPMReferenceFind(const char name[]); /* NULL: there is no such row */

#endif
