static char help[] = "PetscOptionsGetInt() takes a number that no PetscInt can hold, and returns another one.\n"
                     "Run it on 1 process: mpiexec -n 1 ./options_integer\n";

/* One more than the largest PetscInt. An error is expected. */
#include <petscsys.h>

int main(int argc, char **argv)
{
  const char    *text = sizeof(PetscInt) == 8 ? "9223372036854775808" : "2147483648";
  PetscInt       n    = 0;
  PetscErrorCode status;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(PetscOptionsSetValue(NULL, "-n", text));
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  status = PetscOptionsGetInt(NULL, NULL, "-n", &n, NULL);
  PetscCall(PetscPopErrorHandler());
  if (status)
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "PETSc %d.%d.%d: as expected: -n %s is an error\n", PETSC_VERSION_MAJOR,
                          PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, text));
  else
    PetscCall(PetscPrintf(PETSC_COMM_SELF, "PETSc %d.%d.%d: FAULT: -n %s is taken: n is %" PetscInt_FMT "\n",
                          PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, text, n));
  PetscCall(PetscFinalize());
  return status ? 0 : 1;
}
