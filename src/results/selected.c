/* selected.c - the loop over particles of sums, extremes and lists of values; selected.h describes them. */
#include "results/selected.h"

PetscErrorCode MPMSelectedCreate(MPMSelected *s, const MPMView *view)
{
  PetscFunctionBeginUser;
  s->n = 0;
  PetscCall(PetscMalloc2(view->n, &s->p, view->n, &s->weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSelectedDestroy(MPMSelected *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(s->p, s->weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSelectedSum(const MPMSelected *s, const MPMShown *shown, const MPMView *view, PetscInt row,
                              MPMSum sum[], MPMSum *weight, PetscInt64 *wrong)
{
  const MPMDiagnostic *of = &MPMDiagnostics[row];
  PetscReal            value[MPM_MAX_COMPONENTS];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < s->n; k++) {
    of->fill(shown, view, s->p ? s->p[k] : k, value);
    if (weight && value[0] != value[0]) continue;
    if (weight) MPMSumAdd(weight, s->weight[k]);
    for (PetscInt c = 0; c < of->nc; c++) {
      const PetscReal term = s->p ? s->weight[k] * value[c] : value[c];

      if (wrong && !(PetscAbsReal(term) <= PETSC_MAX_REAL))
        ++*wrong;
      else
        MPMSumAdd(&sum[c], term);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSelectedLeast(const MPMSelected *s, const MPMShown *shown, const MPMView *view, PetscInt row,
                                PetscReal sign, MPI_Comm comm, PetscReal least[])
{
  const MPMDiagnostic *of = &MPMDiagnostics[row];
  PetscReal            value[MPM_MAX_COMPONENTS];

  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < of->nc; c++) least[c] = PETSC_MAX_REAL;
  for (PetscInt k = 0; k < s->n; k++) {
    of->fill(shown, view, s->p ? s->p[k] : k, value);
    for (PetscInt c = 0; c < of->nc; c++) least[c] = PetscMin(least[c], sign * value[c]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, least, (PetscMPIInt)of->nc, MPIU_REAL, MPIU_MIN, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds a quantile of n pairs of value and weight of this process and those of the others, by halving the interval from
   low to high in which it lies; value and weight change. Collective on comm. */
static PetscErrorCode Quantile(PetscInt n, PetscReal value[], PetscReal weight[], PetscReal share, MPI_Comm comm,
                               PetscReal *quantile)
{
  PetscReal ends[2] = {-PETSC_MAX_REAL, -PETSC_MAX_REAL}, low, high, all;
  MPMSum    below, sum; /* the weight of values below low */

  PetscFunctionBeginUser;
  MPMSumZero(&below);
  sum = below;
  for (PetscInt k = 0; k < n; k++) {
    ends[0] = PetscMax(ends[0], -value[k]);
    ends[1] = PetscMax(ends[1], value[k]);
    MPMSumAdd(&sum, weight[k]);
  }
  PetscCall(MPMSumReduce(&sum, 1, comm));
  all = MPMSumValue(&sum);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPIU_REAL, MPIU_MAX, comm));
  low  = -ends[0];
  high = ends[1];
  while (low < high) {
    PetscReal middle = low + 0.5 * (high - low);
    PetscInt  kept   = 0;
    PetscBool lower;
    MPMSum    half = below;

    if (!(middle < high)) middle = low;
    ends[0] = ends[1] = -PETSC_MAX_REAL; /* the first value above the middle, and the last one up to it */
    for (PetscInt k = 0; k < n; k++)
      if (value[k] > middle)
        ends[0] = PetscMax(ends[0], -value[k]);
      else {
        ends[1] = PetscMax(ends[1], value[k]);
        MPMSumAdd(&half, weight[k]);
      }
    sum = half;
    PetscCall(MPMSumReduce(&sum, 1, comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPIU_REAL, MPIU_MAX, comm));
    lower = MPMSumValue(&sum) >= share * all;
    for (PetscInt k = 0; k < n; k++)
      if ((value[k] > middle) != lower) {
        value[kept]    = value[k];
        weight[kept++] = weight[k];
      }
    n = kept;
    if (lower)
      high = ends[1];
    else {
      low   = -ends[0];
      below = half;
    }
  }
  *quantile = low;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSelectedQuantile(const MPMSelected *s, const MPMShown *shown, const MPMView *view, PetscInt row,
                                   PetscReal sign, PetscReal share, MPI_Comm comm, PetscReal out[])
{
  PetscReal all[MPM_MAX_COMPONENTS], *value, *weight;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(s->n, &value, s->n, &weight));
  for (PetscInt c = 0; c < MPMDiagnostics[row].nc; c++) {
    for (PetscInt k = 0; k < s->n; k++) {
      MPMDiagnostics[row].fill(shown, view, s->p[k], all);
      value[k]  = sign * all[c];
      weight[k] = s->weight[k];
    }
    PetscCall(Quantile(s->n, value, weight, share, comm, &out[c]));
  }
  PetscCall(PetscFree2(value, weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}
