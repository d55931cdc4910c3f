/* print.c - the function that prints; print.h describes it. */
#include <stdarg.h>
#include "base/print.h"

PetscErrorCode MPMPrint(const MPMPrinter *printer, const char format[], ...)
{
  PetscMPIInt rank;
  va_list     args;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(printer->comm, &rank));
  va_start(args, format);
  if (!rank && !printer->quiet) (void)vprintf(format, args);
  va_end(args);
  (void)fflush(stdout);
  PetscFunctionReturn(PETSC_SUCCESS);
}
