/* progress.c - the line of progress of a run on a terminal. */
#include <unistd.h>
#include "run/mpm.h"

/* Returns whether standard output is a terminal. Under Open MPI's mpiexec it always seems to be one; then the standard
   output of the parent process decides. */
static PetscBool OnTerminal(void)
{
  char    link[64], to[MPM_NAME_LEN];
  ssize_t n;

  if (!getenv("OMPI_COMM_WORLD_RANK")) return isatty(STDOUT_FILENO) ? PETSC_TRUE : PETSC_FALSE;
  (void)snprintf(link, sizeof link, "/proc/%ld/fd/1", (long)getppid());
  n = readlink(link, to, sizeof to - 1);
  return n > 5 && !strncmp(to, "/dev/", 5) && (n < 9 || strncmp(to, "/dev/null", 9)) ? PETSC_TRUE : PETSC_FALSE;
}

/* Prints a line of progress over the one before, at most once a second, if standard output is a terminal. Not
   collective. */
PetscErrorCode MPMReportProgress(MPM mpm)
{
  PetscMPIInt    rank;
  PetscLogDouble now, spent;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  PetscCallMPI(MPI_Comm_rank(mpm->core.comm, &rank));
  if (rank || mpm->core.print.quiet || now - mpm->report.line < 1 || !OnTerminal()) PetscFunctionReturn(PETSC_SUCCESS);
  if (mpm->report.line > 0) {
    const PetscReal part = PetscMax(mpm->core.t / mpm->time.end, (PetscReal)mpm->core.step / mpm->time.max_steps);
    char            left[MPM_NAME_LEN];

    spent                = now - mpm->report.start;
    mpm->report.progress = PETSC_TRUE;
    MPMTimeWords(spent * (1 - part) / part, left);
    printf("\rstep %" PetscInt_FMT "  t=%.4g of %.4g s  %.0f %%  %s left   ", mpm->core.step, (double)mpm->core.t,
           (double)mpm->time.end, (double)(100 * part), left);
    (void)fflush(stdout);
  }
  mpm->report.line = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}
