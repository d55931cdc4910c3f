/* rows.c - sends what the processes have to the rows of a dataset, of which each process writes an equal part. */
#include "results/rows.h"
#if defined(PETSC_HAVE_HDF5)

PetscErrorCode MPMRowsCreate(MPI_Comm comm, PetscInt total, PetscInt n, const PetscInt row[], MPMRows *rows)
{
  PetscLayout layout;

  PetscFunctionBeginUser;
  PetscCall(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, total, 1, &layout));
  PetscCall(PetscLayoutGetRange(layout, &rows->first, &rows->n));
  rows->n -= rows->first;
  PetscCall(PetscSFCreate(comm, &rows->sf));
  PetscCall(PetscSFSetGraphLayout(rows->sf, layout, n, NULL, PETSC_COPY_VALUES, row));
  PetscCall(PetscLayoutDestroy(&layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRowsSend(const MPMRows *rows, PetscInt nc, const PetscReal here[], PetscReal sorted[])
{
  MPI_Datatype unit;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Type_contiguous((PetscMPIInt)nc, MPIU_REAL, &unit));
  PetscCallMPI(MPI_Type_commit(&unit));
  PetscCall(PetscSFReduceBegin(rows->sf, unit, here, sorted, MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(rows->sf, unit, here, sorted, MPI_REPLACE));
  PetscCallMPI(MPI_Type_free(&unit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRowsWrite(MPMFile *file, PetscInt set, const MPMRows *rows, PetscInt nc, const PetscReal here[],
                            PetscReal sorted[])
{
  PetscFunctionBeginUser;
  PetscCall(MPMRowsSend(rows, nc, here, sorted));
  PetscCall(MPMFileWrite(file, set, (PetscInt64)rows->first * nc, (PetscInt64)rows->n * nc, sorted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else
typedef int MPMRowsNothing; /* a file must not be empty */
#endif
