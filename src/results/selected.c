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
                              MPMSum sum[], PetscInt64 *wrong)
{
  const MPMDiagnostic *of = &MPMDiagnostics[row];
  PetscReal            value[MPM_MAX_COMPONENTS];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < s->n; k++) {
    of->fill(shown, view, s->p ? s->p[k] : k, value);
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

PetscErrorCode MPMSelectedValues(const MPMSelected *s, const MPMShown *shown, const MPMView *view, PetscInt row,
                                 PetscInt c, MPI_Comm comm, PetscInt *n, PetscReal **value)
{
  PetscReal   all[MPM_MAX_COMPONENTS], *mine;
  PetscMPIInt size, count, *counts, *from;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMPIIntCast(s->n, &count));
  PetscCall(PetscMalloc3(s->n, &mine, size, &counts, size, &from));
  for (PetscInt k = 0; k < s->n; k++) {
    MPMDiagnostics[row].fill(shown, view, s->p ? s->p[k] : k, all);
    mine[k] = all[c];
  }
  PetscCallMPI(MPI_Allgather(&count, 1, MPI_INT, counts, 1, MPI_INT, comm));
  *n = 0;
  for (PetscMPIInt r = 0; r < size; r++) {
    PetscCall(PetscMPIIntCast(*n, &from[r]));
    *n += counts[r];
  }
  PetscCall(PetscMalloc1(*n, value));
  PetscCallMPI(MPI_Allgatherv(mine, count, MPIU_REAL, *value, counts, from, MPIU_REAL, comm));
  PetscCall(PetscSortReal(*n, *value));
  PetscCall(PetscFree3(mine, counts, from));
  PetscFunctionReturn(PETSC_SUCCESS);
}
