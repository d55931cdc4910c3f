/* program.c - the main program, without what it runs: pebble and the tools that read a scene start and end with it. */
#include <signal.h>
#include <unistd.h>
#include "base/signals.h"
#include "run/mpm.h"

static PetscErrorCode ReadAndRun(PetscErrorCode (*read)(MPM, MPMOptions), PetscErrorCode (*run)(MPM, int *),
                                 int *status)
{
  MPM        mpm;
  MPMOptions options;
  PetscBool  staged;
  char       fault[MPM_TEXT_LEN], stages[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMRerun(fault));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-stages", stages, sizeof stages, &staged));
  if (stages[strspn(stages, ", ")] && staged && !fault[0]) {
    PetscCall(MPMStagesRun(read, run, status));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMCreate(PETSC_COMM_WORLD, &mpm));
  PetscCall(MPMOptionsCreate(&MPMOptionTable, &options));
  if (fault[0])
    MPMOptionsFail(options, "%s", fault);
  else
    PetscCall(read(mpm, options));
  if (MPMOptionsError(options)) {
    PetscCall(PetscFPrintf(mpm->core.comm, stderr, "%s\n", MPMOptionsError(options)));
    *status = MPM_EXIT_INPUT;
  } else
    PetscCall(run(mpm, status));
  PetscCall(MPMOptionsDestroy(&options));
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps PetscFinalize from listing the options that a refused scene did not come to read; from 3.20 on PETSc would. Who
   gives -options_left still gets what it says. */
static PetscErrorCode NoOptionsLeft(void)
{
  PetscBool given;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-options_left", &given));
  if (!given) PetscCall(PetscOptionsSetValue(NULL, "-options_left", "false"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static volatile sig_atomic_t ends; /* the exit status */

static void End(int signal)
{
  (void)signal;
  _exit(ends);
}

/* Ends PETSc and MPI. Open MPI 4.1 does not come back from its own end about once in 30,000 runs; all is written then, so the process
   ends by itself after 100 s (test mpi_endless). */
static PetscErrorCode Finalize(int status)
{
  ends = status;
  (void)signal(SIGALRM, End);
  (void)alarm(100);
  PetscCall(PetscFinalize());
  (void)alarm(0);
  return PETSC_SUCCESS; /* PETSc's stack of functions is gone */
}

/* Described in mpm.h. */
int MPMProgram(int argc, char **argv, PetscErrorCode (*read)(MPM, MPMOptions), PetscErrorCode (*run)(MPM, int *status))
{
  int       status = MPM_EXIT_OK;
  PetscBool help;

  MPMSignalsStart();
  if (MPMOptionsStart(&MPMOptionTable, argc, argv, &status)) return status;
  PetscCall(PetscPushErrorHandler(MPMOptionsStartFault, NULL));
  /* For a program that mpiexec has not started Open MPI would start a daemon, which takes longer than a small scene. */
  (void)setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  /* All such programs would share a folder for temporary files, which one may remove while another makes its own in it. */
  if (!getenv("OMPI_COMM_WORLD_SIZE")) (void)setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  MPMOptionsStarted();
  (void)signal(SIGPIPE, SIG_DFL); /* so that `pebble ... | head` prints no error */
  (void)signal(SIGXFSZ, SIG_IGN); /* a file beyond the limit of `ulimit -f` is a fault in writing like others */
  PetscCall(PetscOptionsHasHelp(NULL, &help));
  if (!help) PetscCall(ReadAndRun(read, run, &status));
  if (status == MPM_EXIT_INPUT) PetscCall(NoOptionsLeft());
  PetscCall(Finalize(status));
  return status;
}
