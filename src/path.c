/* path.c - -report_path: the processor time of the work itself, without messages, of each process in each phase of each
   step. On fewer cores than processes wall time says nothing about a machine with a core for each; the sum over steps
   and phases of the slowest process's work, with the messages as the model has them, does: the critical path. */
#include <time.h>
#include "mpm.h"

static PetscReal Processor(void)
{
  struct timespec now;

  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (PetscReal)now.tv_sec + 1e-9 * (PetscReal)now.tv_nsec;
}

/* The clock of the table of phases: wall time, or in a calibration the processor's, which other programs do not
   lengthen. Not collective. */
PetscErrorCode MPMClock(MPM mpm, PetscLogDouble *now)
{
  PetscFunctionBeginUser;
  if (mpm->path.clock)
    *now = Processor();
  else
    PetscCall(PetscTime(now));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Marks work that belongs to a timer; without -report_path they do nothing. Not collective. */
void MPMWorkBegin(MPM mpm)
{
  if (mpm->path.on) mpm->path.start = Processor();
}

void MPMWorkEnd(MPM mpm, PetscInt timer)
{
  MPMPath *path = &mpm->path;

  if (path->on && path->seconds) path->seconds[path->row * MPM_MAX_TIMERS + timer] += Processor() - path->start;
}

/* Leaves out what lies between the two. */
void MPMWorkPause(MPM mpm)
{
  if (mpm->path.on) mpm->path.paused = Processor();
}

void MPMWorkResume(MPM mpm)
{
  if (mpm->path.on) mpm->path.start += Processor() - mpm->path.paused;
}

/* Makes room for the work of a step. Processes of a pool do not take part in steps: they keep sums over the run, in one
   row. Not collective. */
PetscErrorCode MPMWorkStep(MPM mpm)
{
  MPMPath *path = &mpm->path;

  PetscFunctionBeginUser;
  if (!path->on || (path->seconds && mpm->exchange.type->farms)) PetscFunctionReturn(PETSC_SUCCESS);
  if (path->seconds) path->row++;
  if (path->row >= path->capacity) {
    PetscReal     *seconds;
    const PetscInt capacity = 2 * path->capacity + 64;

    PetscCall(PetscCalloc1(capacity * MPM_MAX_TIMERS, &seconds));
    PetscCall(PetscArraycpy(seconds, path->seconds, path->capacity * MPM_MAX_TIMERS));
    PetscCall(PetscFree(path->seconds));
    path->seconds  = seconds;
    path->capacity = capacity;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the work and the critical path. Collective on mpm->comm: the workers of a pool take part. */
PetscErrorCode MPMWorkView(MPM mpm)
{
  MPMPath    *path = &mpm->path;
  PetscInt    rows = path->seconds ? path->row + 1 : 0, steps = mpm->step;
  PetscReal  *slowest, sum[MPM_MAX_TIMERS] = {0}, most[MPM_MAX_TIMERS] = {0}, all[3] = {0};
  PetscMPIInt size, rank;

  PetscFunctionBeginUser;
  if (!path->on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(mpm->comm, &size));
  PetscCallMPI(MPI_Comm_rank(mpm->comm, &rank));
  PetscCallMPI(MPI_Bcast(&steps, 1, MPIU_INT, 0, mpm->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &rows, 1, MPIU_INT, MPI_MAX, mpm->comm));
  if (!rows || !steps) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(rows * MPM_MAX_TIMERS, &slowest));
  if (path->seconds) PetscCall(PetscArraycpy(slowest, path->seconds, rows * MPM_MAX_TIMERS));
  for (PetscInt k = 0; k < rows * MPM_MAX_TIMERS; k++) sum[k % MPM_MAX_TIMERS] += slowest[k];
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, slowest, (PetscMPIInt)(rows * MPM_MAX_TIMERS), MPIU_REAL, MPIU_MAX, mpm->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, MPM_MAX_TIMERS, MPIU_REAL, MPIU_SUM, mpm->comm));
  for (PetscInt k = 0; k < rows * MPM_MAX_TIMERS; k++) most[k % MPM_MAX_TIMERS] += slowest[k];
  PetscCall(PetscFree(slowest));
  PetscCall(MPMPrint(mpm, "path       processor time, s/step   mean      slowest   messages (model)\n"));
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) {
    const PetscReal row[3] = {sum[e] / (PetscReal)(steps * size), most[e] / (PetscReal)steps, path->messages[e]};

    for (int k = 0; k < 3; k++) all[k] += row[k];
    if (row[1] + row[2] > 0)
      PetscCall(MPMPrint(mpm, "  %-12s %28.3g %12.3g %12.3g\n", MPMTimerName(e), (double)row[0], (double)row[1],
                         (double)row[2]));
  }
  PetscCall(MPMPrint(mpm, "  %-12s %28.3g %12.3g %12.3g   critical path %.4g s/step\n", "all", (double)all[0],
                     (double)all[1], (double)all[2], (double)(all[1] + all[2])));
  PetscFunctionReturn(PETSC_SUCCESS);
}
