/* main.c - the program: read the options, set up, run.                                                                */
#include "mpm.h"

static const char help[] = "Pebble: the Material Point Method on PETSc.\n"
                           "  pebble -options_file options/disks.opts [-option value ...]\n"
                           "Options: <default> unit: meaning (allowed values)\n";

/* The rank before MPI is up, as the launcher tells it: so that one process speaks. */
static int RankFromEnvironment(void)
{
  static const char *const names[] = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"};

  for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
    if (getenv(names[k])) return atoi(getenv(names[k]));
  return 0;
}

/* Options files that PETSc would answer with a stack of calls are answered here, with one line. */
static int CheckFiles(int argc, char **argv)
{
  char error[MPM_TEXT_LEN];

  for (int k = 1; k < argc; k++) {
    if (strcmp(argv[k], "-options_file")) continue;
    if (k + 1 == argc) (void)snprintf(error, sizeof error, "-options_file has no value");
    else (void)MPMOptionsCheckFile(argv[k + 1], error, sizeof error);
    if (!error[0]) continue;
    if (RankFromEnvironment() == 0) fprintf(stderr, "%s\n", error);
    return MPM_EXIT_INPUT;
  }
  return MPM_EXIT_OK;
}

static PetscErrorCode Run(int *status)
{
  MPM        mpm;
  MPMOptions options;

  PetscFunctionBeginUser;
  PetscCall(MPMCreate(PETSC_COMM_WORLD, &mpm));
  PetscCall(MPMOptionsCreate(&options));
  PetscCall(MPMSetFromOptions(mpm, options));
  if (MPMOptionsError(options)) {
    PetscCall(PetscFPrintf(mpm->comm, stderr, "%s\n", MPMOptionsError(options)));
    *status = MPM_EXIT_INPUT;
  } else {
    PetscCall(MPMSetUp(mpm));
    PetscCall(MPMRun(mpm));
    *status = mpm->stop[0] ? MPM_EXIT_STOPPED : MPM_EXIT_OK;
  }
  PetscCall(MPMOptionsDestroy(&options));
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  int       status = CheckFiles(argc, argv);
  PetscBool wanted;

  if (status) return status;
  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(PetscOptionsHasHelp(NULL, &wanted));
  if (wanted) PetscCall(MPMOptionsHelp(PETSC_COMM_WORLD));
  else PetscCall(Run(&status));
  PetscCall(PetscFinalize());
  return status;
}
