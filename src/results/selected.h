/* selected.h - sums, extremes and lists of what some of the particles show: the one loop over particles of totals,
   bodies, probes and particles that left. Sums are exact and extremes have no sequence, so all are the same on any
   number of processes. */
#ifndef MPM_SELECTED_H
#define MPM_SELECTED_H

#include "results/diagnostics.h"

/* The particles of this process that count: `n` numbers p of a view, with weights; p NULL: the first n of the view,
   each with weight 1. */
typedef struct {
  PetscInt   n, *p;
  PetscReal *weight;
} MPMSelected;

/* Begin and end a selection of particles of a view, of none at first; add one. Not collective. */
PetscErrorCode  MPMSelectedCreate(MPMSelected *, const MPMView *);
PetscErrorCode  MPMSelectedDestroy(MPMSelected *);
MPM_INLINE void MPMSelectedAdd(MPMSelected *s, PetscInt p, PetscReal weight)
{
  s->p[s->n]        = p;
  s->weight[s->n++] = weight;
}

/* Adds, to sums [components] of this process, what the selected particles show of a row of MPMDiagnostics, times their
   weights; a value that is not finite is counted in *wrong, and left out. wrong NULL: all are added. weight not NULL:
   particles for which the row is nan do not count, and the weights of the others are added to it. Not collective. */
PetscErrorCode MPMSelectedSum(const MPMSelected *, const MPMShown *, const MPMView *, PetscInt row, MPMSum sum[],
                              MPMSum *weight, PetscInt64 *wrong);

/* Sets least [components] to the smallest value of each component times `sign` (1 or -1) among the selected particles
   of all processes, or PETSC_MAX_REAL if there are none. Collective on comm. */
PetscErrorCode MPMSelectedLeast(const MPMSelected *, const MPMShown *, const MPMView *, PetscInt row, PetscReal sign,
                                MPI_Comm comm, PetscReal least[]);

/* Sets out [components] to the smallest value of each component times `sign` (1 or -1) up to which selected particles
   have `share` of the weight of all, or PETSC_MAX_REAL if there are none; up to some fifty reductions for each
   component. Collective on comm. */
PetscErrorCode MPMSelectedQuantile(const MPMSelected *, const MPMShown *, const MPMView *, PetscInt row, PetscReal sign,
                                   PetscReal share, MPI_Comm comm, PetscReal out[]);

#endif
