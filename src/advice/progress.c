/* progress.c - the line of progress of a run on a terminal. */
#include <unistd.h>
#include "advice/advice.h"

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
PetscErrorCode MPMReportProgress(MPMReport *report, MPMCore *core, const MPMTime *time)
{
  PetscMPIInt    rank;
  PetscLogDouble now, spent;

  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  if (rank || core->print.quiet || now - report->line < 1 || !OnTerminal()) PetscFunctionReturn(PETSC_SUCCESS);
  if (report->line > 0) {
    const PetscReal part = PetscMax(core->t / time->end, (PetscReal)core->step / time->max_steps);
    char            left[MPM_NAME_LEN];

    spent                = now - report->start;
    core->print.progress = PETSC_TRUE;
    MPMTimeWords(spent * (1 - part) / part, left);
    printf("\rstep %" PetscInt_FMT "  t=%.4g of %.4g s  %.0f %%  %s left   ", core->step, (double)core->t,
           (double)time->end, (double)(100 * part), left);
    (void)fflush(stdout);
  }
  report->line = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}
