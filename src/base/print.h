/* print.h - what the program prints. */
#ifndef MPM_PRINT_H
#define MPM_PRINT_H

#include "base/base.h"

typedef struct {
  MPI_Comm  comm;  /* its first process prints */
  PetscBool quiet; /* prints nothing: a run of a study */
} MPMPrinter;

/* Prints as printf does, on the first process; PetscPrintf would write 3 as "3.". Not collective. */
PetscErrorCode MPMPrint(const MPMPrinter *, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);

#endif
