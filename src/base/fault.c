/* fault.c - the functions of fault.h. */
#include "base/fault.h"

void MPMFault(char fault[MPM_TEXT_LEN], const char what[], const char path[], const char why[])
{
  if (!fault[0]) (void)snprintf(fault, MPM_TEXT_LEN, "%s %.1000s: %s", what, path, why);
}

PetscErrorCode MPMFaultAgree(MPI_Comm comm, char fault[MPM_TEXT_LEN])
{
  PetscMPIInt rank, size, from;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  from = fault[0] ? rank : size;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &from, 1, MPI_INT, MPI_MIN, comm));
  if (from < size) PetscCallMPI(MPI_Bcast(fault, MPM_TEXT_LEN, MPI_CHAR, from, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
