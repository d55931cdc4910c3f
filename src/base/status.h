/* status.h - what a step finds about its particles: bad states, the largest speeds, how many particles moved. Phases
   note it for a patch, and it is merged over patches and processes at the end of a step. */
#ifndef MPM_STATUS_H
#define MPM_STATUS_H

#include "base/base.h"

/* Maxima and sums of integers, which MPMStatusMerge merges exactly and in any sequence. `bad` is the gravest condition
   that was met, and `id` the smallest id of a particle that met it. Conditions are listed with the gravest first, since
   a particle that is turned inside out soon pushes others off the grid. MPM_NOT_FINITE is found where totals are
   computed, not by a step. MPM_GONE is not bad: particles left the grid that are to be removed (-particles_leave
   delete). */
typedef enum { MPM_OK, MPM_BAD_J, MPM_LEFT_GRID, MPM_TOO_WIDE, MPM_NOT_FINITE, MPM_GONE, MPM_NUM_BAD } MPMBad;
typedef struct {
  MPMBad     bad;
  PetscInt64 id;
  PetscReal  x[3], J; /* its position in m; its det F for MPM_BAD_J, its width in cells for MPM_TOO_WIDE */
  PetscReal  v2, c2;  /* largest squared speeds of a particle and of a wave, m^2/s^2 */
  PetscInt64 opened;  /* 1: some sand is open (kernels/volume.h) */
  PetscInt64 moved;   /* movers: particles that changed their cell */
  PetscInt64 asked;   /* what a signal has asked for (signals.h), or 0 */
  PetscInt64 left;    /* leavers: particles that left their patch for another one */
  PetscInt64 hops;    /* largest distance that a leaver has to go along an axis, in patches */
  PetscInt64 most;    /* particles of the process that has most of them */
  PetscInt64 n, ids;  /* number of particles, and their fingerprint (digest.c): is any lost or doubled? */
} MPMStatus;

void      MPMStatusReset(MPMStatus *);
void      MPMStatusMerge(MPMStatus *, const MPMStatus *);
PetscBool MPMStatusIsBad(const MPMStatus *);

/* Notes that particle id at x [dim] in m met a bad condition; J is det F or the width (MPMStatus.J). Of several
   conditions the gravest is kept, and of several particles the one with the smallest id. */
void MPMStatusNote(MPMStatus *, MPMBad, PetscInt64 id, PetscInt dim, const PetscReal x[], PetscReal J);

#endif
