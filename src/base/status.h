/* status.h - what a step finds on its way: bad states, the largest speeds, particles that moved. */
#ifndef MPM_STATUS_H
#define MPM_STATUS_H

#include "base/base.h"

/* Merged over patches and processes by MPMStatusMerge: maxima and sums of integers, so exact and without order. `bad`
   is the gravest condition that was met, which is the first of the list, with the smallest id that met it: a particle
   that is turned inside out soon throws others off the grid. */
typedef enum { MPM_OK, MPM_BAD_J, MPM_LEFT_GRID, MPM_TOO_WIDE, MPM_NUM_BAD } MPMBad;
typedef struct {
  MPMBad     bad;
  PetscInt64 id;
  PetscReal  x[3], J;     /* where it was in m, and its det F for MPM_BAD_J, or its width in cells for MPM_TOO_WIDE */
  PetscReal  v2, c2;      /* largest squared speed of a particle and of a wave, m^2/s^2 */
  PetscInt64 moved;       /* particles that changed their cell */
  PetscInt64 interrupted; /* has a signal asked the run to end? */
  PetscInt64 left;        /* particles that left their patch */
  PetscInt64 hops;        /* patches that the farthest of these has to go along an axis */
  PetscInt64 most;        /* particles of the process that has most */
  PetscInt64 n, ids;      /* particles that there are, and their fingerprint: none may get lost or doubled on the way */
} MPMStatus;

void MPMStatusReset(MPMStatus *);
void MPMStatusMerge(MPMStatus *, const MPMStatus *);

/* Notes a bad condition of particle id at x [dim] in m: the gravest kind stays, of its smallest id. */
void MPMStatusNote(MPMStatus *, MPMBad, PetscInt64 id, PetscInt dim, const PetscReal x[], PetscReal J);

#endif
