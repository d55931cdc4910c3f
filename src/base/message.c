/* message.c - lengths of messages, and room for them. */
#include "base/message.h"

/* The length of a message as MPI takes it; an error if it does not fit into an int. */
PetscErrorCode MPMMessageLength(size_t bytes, PetscMPIInt *len)
{
  PetscFunctionBeginUser;
  PetscCheck(bytes <= PETSC_MPI_INT_MAX, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "a message of %.3g GB is more than MPI takes; use more processes, or a smaller -pool_cells",
             1e-9 * (double)bytes);
  *len = (PetscMPIInt)bytes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for a message; what was in the buffer is lost when it grows. */
PetscErrorCode MPMMessageRoom(char **buffer, size_t *capacity, size_t need)
{
  PetscFunctionBeginUser;
  if (need <= *capacity) PetscFunctionReturn(PETSC_SUCCESS);
  *capacity = need + need / 4 + 4096;
  PetscCall(PetscFree(*buffer));
  PetscCall(PetscMalloc(*capacity, buffer));
  PetscFunctionReturn(PETSC_SUCCESS);
}
