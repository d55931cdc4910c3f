/* notes.c - prints, before a run, what a user should know about a valid command line: options without effect in this
   run, and more processes than cores. The same options file may be used on one process and on many, so such options are
   not refused. */
#define _GNU_SOURCE /* sched_getaffinity and CPU_COUNT */
#include <sched.h>
#include "advice/advice.h"

/* Prints a note if the processes of one computer have to share cores. Collective on core.comm. */
static PetscErrorCode NoteCrowd(const MPMCore *core)
{
  PetscFunctionBeginUser;
#if defined(__linux__) && !defined(MPM_SIMULATE)
  cpu_set_t   cores;
  PetscMPIInt processes;
  MPI_Comm    node;

  PetscCallMPI(MPI_Comm_split_type(core->comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node));
  PetscCallMPI(MPI_Comm_size(node, &processes));
  CPU_ZERO(&cores);
  if (sched_getaffinity(0, sizeof cores, &cores)) memset(&cores, 0xff, sizeof cores); /* more than the set can hold */
  /* A launcher may bind each process to a core of its own, so the cores of all processes count. */
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &cores, (PetscMPIInt)sizeof cores, MPI_BYTE, MPI_BOR, node));
  PetscCallMPI(MPI_Comm_free(&node));
  if (processes > CPU_COUNT(&cores))
    PetscCall(MPMNote(&core->print,
                      "%d processes share %d core%s of this computer: they take turns, and more than %d are no faster",
                      processes, CPU_COUNT(&cores), CPU_COUNT(&cores) > 1 ? "s" : "", CPU_COUNT(&cores)));
#else
  (void)core; /* simulated processes always share a core */
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names the options that were given and have no effect. Not collective. */
static PetscErrorCode NoteOptions(const MPMCore *core, const MPMScene *scene, const MPMReport *report, PetscMPIInt size)
{
  /* A dry run that predicts other numbers of processes predicts them by every option of theirs. */
  const PetscBool   dry        = scene->dry_run && report->processes;
  const PetscBool   by_workers = core->exchange.type->by_workers;
  const char *const alone      = size == 1 && !dry ? "on one process" : NULL;
  const char *const serial  = strcmp(core->exchange.type->name, "serial") ? NULL : alone; /* periodic faces add sums */
  const char *const pool    = by_workers && !dry ? "with -parallel_strategy pool" : alone;
  const char *const cuts    = !by_workers && size > 1 && !dry ? "without -parallel_strategy pool" : alone;
  const char *const not_run = scene->dry_run ? "with -dry_run" : NULL;
  const struct {
    const char *option, *where; /* where: in which runs it has no effect; NULL: it has one */
  } rows[] = {
      {"-parallel_strategy", alone},
      {"-parallel_sums", serial},
      {"-parallel_balance", pool},
      {"-parallel_migrate", pool},
      {"-pool_cells", cuts},
      {"-report_limits", report->limits ? not_run : NULL},
      {"-report_phases", report->phases ? not_run : NULL},
      {"-report_processes", report->processes && !scene->dry_run ? "without -dry_run" : NULL},
      {"-report_path", core->timers.work.on ? not_run : NULL},
  };

  PetscFunctionBeginUser;
  for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
    PetscBool given;

    PetscCall(PetscOptionsHasName(NULL, NULL, rows[k].option, &given));
    if (given && rows[k].where) PetscCall(MPMNote(&core->print, "%s has no effect %s", rows[k].option, rows[k].where));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints a note if the environment variable PEBBLE_VECTOR, by which tests limit the number of lanes, has a value other
   than 8, 4 or 2. Not collective. */
static PetscErrorCode NoteVector(const MPMCore *core)
{
  const char *wish = getenv("PEBBLE_VECTOR");

  PetscFunctionBeginUser;
  if (wish && wish[0] && strcmp(wish, "8") && strcmp(wish, "4") && strcmp(wish, "2"))
    PetscCall(
        MPMNote(&core->print, "PEBBLE_VECTOR=%s is not 8, 4 or 2: %" PetscInt_FMT " lanes", wish, MPMKernelWidth()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says that time steps are cut to end at the times of output, if they are. */
static PetscErrorCode NoteExact(const MPMCore *core, const MPMMonitor *mon, const MPMOutput *out)
{
  char snapshots[MPM_NAME_LEN] = "", lines[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  if (!out->exact && !mon->exact) PetscFunctionReturn(PETSC_SUCCESS);
  if (out->exact) (void)snprintf(snapshots, sizeof snapshots, "snapshots (every %g s)", (double)out->every);
  if (mon->exact) (void)snprintf(lines, sizeof lines, "lines of the history (every %g s)", (double)mon->every);
  PetscCall(
      MPMPrint(&core->print,
               "exact      time steps are cut to end at the times of %s%s%s: the results have other bits than those "
               "of a run without -%s_exact\n",
               snapshots, out->exact && mon->exact ? " and " : "", lines, out->exact ? "output" : "history"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the notes, before anything else of a run or a calibration. Collective on core.comm. */
PetscErrorCode MPMNotes(const MPMCore *core, const MPMScene *scene, const MPMMonitor *mon, const MPMOutput *out,
                        const MPMReport *report)
{
  PetscMPIInt size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCall(NoteOptions(core, scene, report, size));
  PetscCall(NoteVector(core));
  PetscCall(MPMDoubtsNote(core, scene));
  PetscCall(NoteExact(core, mon, out));
  if (size > 1 && !scene->dry_run) PetscCall(NoteCrowd(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}
