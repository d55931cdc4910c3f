static char help[] = "A misspelt option is ignored, and PetscFinalize() of a PETSc without debugging does not tell.\n"
                     "Run it on 1 process: mpiexec -n 1 ./options_misspelt\n";

/* The program asks for -max_steps, the user gave -max_stpes. A line at the end of the program is expected. */
#include <petscsys.h>

static PetscBool told = PETSC_FALSE;

/* Looks for the name among all that PETSc prints. */
static PetscErrorCode Listen(FILE *file, const char format[], va_list arguments)
{
  char line[1024];

  (void)file;
  (void)vsnprintf(line, sizeof line, format, arguments);
  if (strstr(line, "max_stpes")) told = PETSC_TRUE;
  return 0;
}

int main(int argc, char **argv)
{
  PetscInt  steps = 100;
  PetscBool set;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(PetscOptionsSetValue(NULL, "-max_stpes", "5"));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-max_steps", &steps, &set));
  PetscVFPrintf = Listen;
  PetscCall(PetscFinalize());
  printf("PETSc %d.%d.%d: %s\n", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR,
         told ? "as expected: -max_stpes is named at the end" : "FAULT: -max_stpes is ignored silently");
  return told ? 0 : 1;
}
