/* algebra.h - products of vectors and small systems of equations. */
#ifndef MPM_ALGEBRA_H
#define MPM_ALGEBRA_H

#include "base/base.h"

/* Computes c = a x b [3]. */
MPM_INLINE void MPMCross(const PetscReal a[], const PetscReal b[], PetscReal c[])
{
  for (int d = 0; d < 3; d++) c[d] = a[(d + 1) % 3] * b[(d + 2) % 3] - a[(d + 2) % 3] * b[(d + 1) % 3];
}

/* Replaces r [n] by the solution y of A y = r, A [n][n] in rows of `row` numbers, by elimination with pivots; A is
   lost. Returns false if A is singular. */
MPM_INLINE PetscBool MPMSolve(int n, int row, PetscReal *A, PetscReal *r)
{
  for (int k = 0; k < n; k++) {
    int       pivot = k;
    PetscReal swap  = r[k];

    for (int i = k; i < n; i++)
      if (PetscAbsReal(A[i * row + k]) > PetscAbsReal(A[pivot * row + k])) pivot = i;
    if (!(PetscAbsReal(A[pivot * row + k]) > 0)) return PETSC_FALSE;
    r[k]     = r[pivot];
    r[pivot] = swap;
    for (int j = 0; j < n; j++) {
      swap               = A[k * row + j];
      A[k * row + j]     = A[pivot * row + j];
      A[pivot * row + j] = swap;
    }
    for (int i = k + 1; i < n; i++) {
      const PetscReal f = A[i * row + k] / A[k * row + k];

      for (int j = k; j < n; j++) A[i * row + j] -= f * A[k * row + j];
      r[i] -= f * r[k];
    }
  }
  for (int k = n - 1; k >= 0; k--) {
    for (int j = k + 1; j < n; j++) r[k] -= A[k * row + j] * r[j];
    r[k] /= A[k * row + k];
  }
  return PETSC_TRUE;
}

#endif
