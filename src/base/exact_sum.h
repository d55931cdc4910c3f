/* exact_sum.h - a sum of doubles that does not depend on their order: a fixed-point number of 2176 bits. Totals that
   are made of such sums are the same on any number of processes. */
#ifndef MPM_EXACT_SUM_H
#define MPM_EXACT_SUM_H

#include "base/base.h"

#define MPM_SUM_WORDS 68
typedef struct {
  PetscInt64 word[MPM_SUM_WORDS];
  PetscInt   pending; /* additions since the words were last carried */
} MPMSum;

void           MPMSumZero(MPMSum *);
void           MPMSumAdd(MPMSum *, PetscReal);
PetscReal      MPMSumValue(MPMSum *);                        /* less than one unit in the last place from exact */
PetscErrorCode MPMSumReduce(MPMSum *, PetscInt n, MPI_Comm); /* n sums over all processes; collective on the comm */

#endif
