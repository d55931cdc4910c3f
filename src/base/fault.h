/* fault.h - a line that says why something outside of the program failed, such as a file that cannot be written. The
   caller decides what follows; an error of PETSc would end the program with a stack of calls. */
#ifndef MPM_FAULT_H
#define MPM_FAULT_H

#include "base/base.h"

/* Sets fault to "<what> <path>: <why>", unless it says something already. Not collective. */
void MPMFault(char fault[MPM_TEXT_LEN], const char what[], const char path[], const char why[]);

/* Makes the fault of any process one of all: that of the lowest rank. Collective on comm. */
PetscErrorCode MPMFaultAgree(MPI_Comm comm, char fault[MPM_TEXT_LEN]);

#endif
