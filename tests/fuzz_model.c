/* fuzz_model.c - libFuzzer's harness of the file of the performance model (make fuzz, tests/fuzz.py). An input is such a
   file without its line `method`, which the harness adds, since chance would not find it. Whatever is read, the constants
   are finite afterwards, and not negative. */
#include <sanitizer/lsan_interface.h>
#include "run/mpm.h"

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n);

static const char options[] = "-dim 2 -grid_lower 0,0 -grid_upper 1,1 -grid_cells 8,8 -materials m -material_m_model "
                              "neohookean -material_m_rho 1 -material_m_E 1 -material_m_nu 0.3 -bodies b -body_b_shape "
                              "box -body_b_lower 0,0 -body_b_upper 0.5,0.5 -body_b_material m -time_end 1 "
                              "-output_format none -output_dir .";
static MPM        mpm;

static PetscErrorCode Prepare(void)
{
  MPMOptions  o;
  int         n      = 2;
  static char name[] = "fuzz", handler[] = "-no_signal_handler",
              *words[] = {name, handler, NULL}; /* PETSc keeps them */
  char **given         = words;

  PetscFunctionBeginUser;
  __lsan_disable(); /* what MPI never frees */
  PetscCall(PetscInitialize(&n, &given, NULL, NULL));
  __lsan_enable();
  PetscCall(PetscOptionsInsertString(NULL, options));
  PetscCall(MPMCreate(PETSC_COMM_SELF, &mpm));
  PetscCall(MPMOptionsCreate(&MPMOptionTable, &o));
  PetscCall(MPMSetFromOptions(mpm, o));
  PetscCheck(!MPMOptionsError(o), PETSC_COMM_SELF, PETSC_ERR_PLIB, "%s", MPMOptionsError(o));
  PetscCall(MPMOptionsDestroy(&o));
  PetscCall(MPMSetPhases(mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stops if a number is negative or not finite. */
static void Check(PetscReal value)
{
  if (!(value >= 0 && value <= PETSC_MAX_REAL)) abort();
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  (void)argc, (void)argv;
  if (Prepare()) abort();
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
  FILE *file = fopen("fuzz.model", "w");
  char  method[MPM_TEXT_LEN];

  MPMModelMethod(&mpm->core, &mpm->scene, method, sizeof method);
  if (!file || fprintf(file, "method %s\n", method) < 0 || fwrite(data, 1, n, file) != n || fclose(file)) abort();
  (void)snprintf(mpm->cost.file, sizeof mpm->cost.file, "fuzz.model");
  if (!MPMModelIsFile("fuzz.model") || MPMModelSetUp(&mpm->cost, &mpm->core, &mpm->scene, ".")) abort();
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) {
    Check(mpm->cost.model.rate[e].call);
    for (int k = 0; k < MPM_RATE_SIZES; k++) Check(mpm->cost.model.rate[e].each[k]);
  }
  Check(mpm->cost.model.message);
  Check(mpm->cost.model.wire);
  Check(mpm->cost.model.kept);
  return 0;
}
