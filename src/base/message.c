/* message.c - texts that grow; lengths of messages, and memory for them. */
#include <stdarg.h>
#include <stdio.h>
#include "base/message.h"

void MPMAppend(char text[], size_t size, const char format[], ...)
{
  const size_t n = strlen(text);
  va_list      words;

  va_start(words, format);
  (void)vsnprintf(text + n, size - n, format, words);
  va_end(words);
}

/* Converts the length of a message in bytes to the int that MPI takes; raises an error if it does not fit. Not
   collective. */
PetscErrorCode MPMMessageLength(size_t bytes, PetscMPIInt *len)
{
  PetscFunctionBeginUser;
  PetscCheck(bytes <= PETSC_MPI_INT_MAX, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "a message of %.3g GB is more than MPI takes; use more processes, or a smaller -pool_cells",
             1e-9 * (double)bytes);
  *len = (PetscMPIInt)bytes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes *buffer, of *capacity bytes, at least `need` bytes long; its content is lost when it grows. Not collective. */
PetscErrorCode MPMMessageRoom(char **buffer, size_t *capacity, size_t need)
{
  PetscFunctionBeginUser;
  if (need <= *capacity) PetscFunctionReturn(PETSC_SUCCESS);
  *capacity = need + need / 4 + 4096;
  PetscCall(PetscFree(*buffer));
  PetscCall(PetscMalloc(*capacity, buffer));
  PetscFunctionReturn(PETSC_SUCCESS);
}
