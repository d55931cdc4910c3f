/* exact_sum.h - a sum of doubles that does not depend on the sequence of its terms: a fixed-point number of 2176 bits.
   The totals of history and checks are such sums, so they are the same on any number of processes. */
#ifndef MPM_EXACT_SUM_H
#define MPM_EXACT_SUM_H

#include "base/base.h"

#define MPM_SUM_WORDS 68
typedef struct {
  PetscInt64 word[MPM_SUM_WORDS];
  PetscInt   pending; /* additions since words were last carried (Carry) */
} MPMSum;

void           MPMSumZero(MPMSum *);
void           MPMSumAdd(MPMSum *, PetscReal);
PetscReal      MPMSumValue(MPMSum *);                        /* its error is less than one unit in the last place */
PetscErrorCode MPMSumReduce(MPMSum *, PetscInt n, MPI_Comm); /* n sums over the processes; collective on the comm */

#endif
