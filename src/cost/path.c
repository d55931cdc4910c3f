/* path.c - prints what -report_path asks for, after a run: the processor time that each process worked, without
   messages, in each phase of each step. On fewer cores than processes, wall time does not tell how long a machine with
   a core for each process would take. The critical path does: the sum over steps and phases of the work of the slowest
   process, and of the messages as the model predicts them. */
#include "cost/cost.h"

/* Prints the work and the critical path. Collective on core->comm, so the workers of a pool call it too. */
PetscErrorCode MPMWorkView(const MPMCost *cost, MPMCore *core)
{
  const MPMWork *path = &core->timers.work;
  PetscInt       rows = path->seconds ? path->row + 1 : 0, steps = core->step - core->timers.first;
  PetscReal     *slowest, sum[MPM_MAX_TIMERS] = {0}, most[MPM_MAX_TIMERS] = {0}, all[3] = {0};
  PetscMPIInt    size, rank;

  PetscFunctionBeginUser;
  if (!path->on) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  PetscCallMPI(MPI_Bcast(&steps, 1, MPIU_INT, 0, core->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &rows, 1, MPIU_INT, MPI_MAX, core->comm));
  if (!rows || !steps) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(rows * MPM_MAX_TIMERS, &slowest));
  if (path->seconds) PetscCall(PetscArraycpy(slowest, path->seconds, rows * MPM_MAX_TIMERS));
  for (PetscInt k = 0; k < rows * MPM_MAX_TIMERS; k++) sum[k % MPM_MAX_TIMERS] += slowest[k];
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, slowest, (PetscMPIInt)(rows * MPM_MAX_TIMERS), MPIU_REAL, MPIU_MAX, core->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, MPM_MAX_TIMERS, MPIU_REAL, MPIU_SUM, core->comm));
  for (PetscInt k = 0; k < rows * MPM_MAX_TIMERS; k++) most[k % MPM_MAX_TIMERS] += slowest[k];
  PetscCall(PetscFree(slowest));
  PetscCall(MPMPrint(&core->print, "path       processor time, s/step   mean      slowest   messages (model)\n"));
  for (PetscInt q = 0; q < core->timers.n; q++) {
    const PetscInt  e      = MPMTimersRow(&core->timers, q);
    const PetscReal row[3] = {sum[e] / (PetscReal)(steps * size), most[e] / (PetscReal)steps, cost->messages[e]};

    for (int k = 0; k < 3; k++) all[k] += row[k];
    if (row[1] + row[2] > 0)
      PetscCall(MPMPrint(&core->print, "  %-12s %28.3g %12.3g %12.3g\n", core->timers.name[e], (double)row[0],
                         (double)row[1], (double)row[2]));
  }
  PetscCall(MPMPrint(&core->print, "  %-12s %28.3g %12.3g %12.3g   critical path %.4g s/step\n", "all", (double)all[0],
                     (double)all[1], (double)all[2], (double)(all[1] + all[2])));
  PetscFunctionReturn(PETSC_SUCCESS);
}
