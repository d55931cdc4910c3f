static char help[] = "PetscOptionsGetReal() takes nan, and says nothing.\n"
                     "Run it on 1 process: mpiexec -n 1 ./options_nan\n";

/* A time step of nan, as a script may write it after a division of zero by zero. An error is expected of the two
   functions that read a real option. */
#include <petscsys.h>

int main(int argc, char **argv)
{
  PetscReal      a = 0.1, b = 0.1;
  PetscErrorCode get, read;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(PetscOptionsSetValue(NULL, "-dt", "nan"));
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
  get = PetscOptionsGetReal(NULL, NULL, "-dt", &a, NULL);
  PetscOptionsBegin(PETSC_COMM_WORLD, NULL, "Options", NULL);
  read = PetscOptionsReal("-dt", "time step", NULL, b, &b, NULL);
  PetscOptionsEnd();
  PetscCall(PetscPopErrorHandler());
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "PETSc %d.%d.%d: %s: nan %s PetscOptionsGetReal() and %s PetscOptionsReal()\n",
                        PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR,
                        get && read ? "as expected" : "FAULT", get ? "is an error in" : "is taken by",
                        read ? "is an error in" : "is taken by"));
  PetscCall(PetscFinalize());
  return get && read ? 0 : 1;
}
