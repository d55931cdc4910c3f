/* calibrate.c - a program of its own that measures the constants of the cost model (src/cost):

     make calibrate SCENE=options/disks.opts
     mpiexec -n 2 build/mpicc/calibrate -options_file options/disks.opts [-model_file FILE] [-option value ...]

   It makes short runs of the scene, coarser and finer than it is, of about 150, 1500, 20,000 and 400,000 particles.
   Every process makes them for itself, but all at the same time, since processes share memory. If there are processes
   for it, it times messages, a reduction, migrations and the pool's master. All this is repeated a few times, and the
   least time of each counts, since other programs may slow a machine for seconds. Last it measures the limits of a
   core. The constants go to a file, which later runs of the same method read. */
#include <errno.h>
#include <libgen.h>
#include <stdlib.h>
#include <unistd.h>
#include "calibrate.h"

#define ROUNDS 5   /* repetitions of all measurements, unless the environment variable PEBBLE_ROUNDS says (for tests) */
#define VARIES 1.2 /* slowest over fastest run from which a note is printed */
static const PetscReal goal[LEVELS]  = {150, 1500, 2e4, 4e5}; /* particles */
static const PetscInt  steps[LEVELS] = {600, 200, 60, 20}, repeats[LEVELS] = {10, 10, 5, 2};

/* Everything that is measured. */
typedef struct {
  ShortRuns      alone[LEVELS];
  MessageTimes   messages;
  MigrationTimes migration[2];
  PetscReal      copy, kept; /* s per byte */
  TogetherTimes  together;
  MasterTimes    master[2];
  PetscReal      itself[2]; /* s per step on one process, and on all */
} Measured;

/* Measures everything once, and keeps the lesser of each new value and the one before. Collective. */
static PetscErrorCode Measure(MPM scene, PetscMPIInt size, PetscMPIInt rank, Measured *all)
{
  const PetscInt edge = scene->core.grid.dim == 3 ? 3 : scene->core.grid.dim == 2 ? 4 : 8;

  PetscFunctionBeginUser;
  for (int k = 0; k < LEVELS; k++) PetscCall(RunAlone(scene, goal[k], steps[k], repeats[k], &all->alone[k]));
  PetscCall(TimeCopy(&all->copy));
  PetscCall(TimeKept(scene, &all->kept));
  if (!rank) PetscCall(TimeItself(scene, PETSC_COMM_SELF, &all->itself[0]));
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TimeMessages(scene->core.comm, &all->messages));
  PetscCall(TimeMigration(scene, 2e3, &all->migration[0]));
  PetscCall(TimeMigration(scene, 5e4, &all->migration[1]));
  PetscCall(TimeTogether(scene, &all->together));
  PetscCall(TimePool(scene, edge, &all->master[0]));
  PetscCall(TimePool(scene, 4 * edge, &all->master[1]));
  PetscCall(TimeItself(scene, scene->core.comm, &all->itself[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the constants by what was measured. Collective. */
static PetscErrorCode FitModel(MPM scene, PetscMPIInt size, const Measured *all)
{
  MPMModel *m = &scene->cost.model;

  PetscFunctionBeginUser;
  for (PetscInt e = 0; e < scene->core.timers.n; e++) {
    FitRate(&scene->core, e, all->alone, &m->rate[e]);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &m->rate[e], (PetscMPIInt)(sizeof(MPMRate) / sizeof(PetscReal)), MPIU_REAL,
                               MPI_SUM, scene->core.comm));
    m->rate[e].call /= size;
    for (int k = 0; k < MPM_RATE_SIZES; k++) {
      m->rate[e].size[k] /= size;
      m->rate[e].each[k] /= size;
    }
  }
  m->copy = all->copy;
  if (all->kept > 0) m->kept = all->kept; /* else the scene is not valid at that size */
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  FitMessages(size, &all->messages, m);
  FitMigration(size, &all->migration[0], &all->migration[1], m);
  FitPool(&all->master[0], &all->master[1], m);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets *ok to whether the scene can be run with as few and as many particles as the constants need, and prints why not.
   Collective. */
static PetscErrorCode CheckSizes(MPM scene, const ShortRuns alone[LEVELS], PetscBool *ok)
{
  PetscFunctionBeginUser;
  *ok = PETSC_TRUE;
  for (int k = 0; k < LEVELS && *ok; k++) {
    if (alone[k].steps > 0 &&
        (k < 2 || (alone[k].particles > 2 * alone[k - 1].particles && alone[k].particles > 2 * alone[0].particles)))
      continue;
    *ok = PETSC_FALSE;
    PetscCall(PetscFPrintf(scene->core.comm, stderr,
                           "the scene cannot be run with about %g particles, so it cannot be calibrated\n",
                           (double)goal[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static char negative[MPM_TEXT_LEN]; /* the constants whose differences are negative, of this process */

PetscReal Difference(const char name[], PetscReal x)
{
  const size_t at = strlen(negative);

  if (x < 0) (void)snprintf(negative + at, sizeof negative - at, "%s%s", at ? ", " : "", name);
  return PetscMax(0, x);
}

/* Prints what the constants predict for the scene itself, and how far they can be trusted. Collective. */
static PetscErrorCode View(MPM scene, PetscMPIInt size, PetscMPIInt rank, const Measured *all)
{
  PetscReal varied = 1;

  PetscFunctionBeginUser;
  PetscCall(MPMPrint(&scene->core.print, "results    %s\n", scene->cost.file));
  if (!rank) PetscCall(CheckItself(scene, PETSC_COMM_SELF, all->itself[0]));
  if (size > 1) PetscCall(CheckItself(scene, scene->core.comm, all->itself[1]));
  for (int k = 1; k < LEVELS; k++) varied = PetscMax(varied, all->alone[k].slowest / all->alone[k].fastest);
  PetscCall(Slowest(scene->core.comm, &varied));
  if (varied > VARIES)
    PetscCall(MPMPrint(&scene->core.print,
                       "note       the same run took up to %.1f times as long as at its fastest, which counts: other "
                       "work was running here, and runs beside it take longer than predicted\n",
                       (double)varied));
  if (negative[0])
    PetscCall(
        MPMPrint(&scene->core.print,
                 "note       %s: the difference of two times is negative, so 0 is taken; calibrate again on a quiet "
                 "machine\n",
                 negative));
  if (size == 1)
    PetscCall(MPMPrint(&scene->core.print,
                       "note       messages and the pool were not measured: start on 2 processes or "
                       "more for that\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the constants for the scene, whose options are read, and writes the file. The option database is changed:
   nothing can run after this. Collective on scene->core.comm. */
static PetscErrorCode Calibrate(MPM scene, int *status)
{
  MPMModel   *m = &scene->cost.model;
  Measured    all;
  PetscBool   ok;
  PetscMPIInt size, rank;
  const char *wish               = getenv("PEBBLE_ROUNDS");
  const int   rounds             = wish ? atoi(wish) : ROUNDS;
  char        date[MPM_NAME_LEN] = "?";

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(scene->core.comm, &size));
  PetscCallMPI(MPI_Comm_rank(scene->core.comm, &rank));
  PetscCall(MPMPrint(&scene->core.print,
                     "calibrate  %s: short runs of about 150 to 400,000 particles on each of %d process%s, 10 s to a "
                     "minute\n",
                     scene->scene.title, size, size > 1 ? "es" : ""));
  PetscCall(MPMSetPhases(scene));
  PetscCall(PetscMemzero(&all, sizeof all));
  for (int round = 0; round < rounds; round++) {
    PetscCall(Measure(scene, size, rank, &all));
    PetscCall(CheckSizes(scene, all.alone, &ok));
    if (ok) continue;
    *status = MPM_EXIT_INPUT;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(FitModel(scene, size, &all));
  m->measured = PETSC_TRUE;
  /* What an exchange costs besides its messages, such as calls and waiting, is the time of a step that the rest of the
     model does not explain, over the number of exchanges. */
  if (size > 1) PetscCall(TimeTogether(scene, &all.together));
  if (all.together.exchanges > 0)
    m->exchange = Difference("exchange", all.together.step - all.together.predicted) / all.together.exchanges;
  PetscCall(MPMLimits(scene->core.comm, &m->flop, &m->byte));
  PetscCall(PetscGetDate(date, sizeof date));
  (void)snprintf(m->from, sizeof m->from, "calibrated on %d process%s, %s", size, size > 1 ? "es" : " (messages rough)",
                 date);
  m->within = MPM_WITHIN_CALIBRATED;
  PetscCall(View(scene, size, rank, &all)); /* which may raise it */
  if (!rank) PetscCall(MPMModelSave(&scene->cost, &scene->core, &scene->scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The program ------------------------------------------------------------------------------------------------ */

/* Returns whether this file can be written or replaced; if not, errno says why. */
static PetscBool CanWrite(const char path[])
{
  char folder[PETSC_MAX_PATH_LEN];

  (void)snprintf(folder, sizeof folder, "%s", path);
  if (!access(path, F_OK)) return access(path, W_OK) ? PETSC_FALSE : PETSC_TRUE;
  return access(dirname(folder), W_OK) ? PETSC_FALSE : PETSC_TRUE;
}

/* Takes -model_file, which need not exist yet, out of the option database. */
static PetscErrorCode TakeModelFile(MPMOptions o, char file[], size_t len)
{
  PetscBool given;

  PetscFunctionBeginUser;
  file[0] = 0;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-model_file", file, len, &given));
  if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscOptionsClearValue(NULL, "-model_file"));
  if (!file[0])
    MPMOptionsFail(o, "-model_file has no value");
  else if (!CanWrite(file))
    MPMOptionsFail(o, "-model_file: cannot write %s: %s", file, strerror(errno));
  else if (!access(file, F_OK) && !MPMModelIsFile(file))
    MPMOptionsFail(o, "-model_file: %s has no constants of the model; make calibrate does not overwrite it", file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the options of the scene, and refuses those that belong to another kind of run. */
static PetscErrorCode Read(MPM scene, MPMOptions o)
{
  char file[sizeof scene->cost.file];

  PetscFunctionBeginUser;
  PetscCall(TakeModelFile(o, file, sizeof file));
  PetscCall(MPMSetFromOptions(scene, o));
  (void)snprintf(scene->cost.file, sizeof scene->cost.file, "%s", file);
  if (scene->scene.dry_run) MPMOptionsFail(o, "make calibrate does not go with -dry_run: it times short runs");
  if (scene->core.implicit)
    MPMOptionsFail(
        o,
        "make calibrate times explicit steps, not those of -method_time static, euler or newmark: their time is predicted "
        "from the first iterations of Newton's method");
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMNotes(&scene->core, &scene->scene, &scene->monitor, &scene->output, &scene->report));
  if (scene->report.limits)
    PetscCall(MPMPrint(&scene->core.print, "note       -report_limits has no effect with make calibrate\n"));
  if (scene->report.phases)
    PetscCall(MPMPrint(&scene->core.print, "note       -report_phases has no effect with make calibrate\n"));
  if (scene->core.timers.work.on)
    PetscCall(MPMPrint(&scene->core.print, "note       -report_path has no effect with make calibrate\n"));
  scene->core.timers.work.on = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  return MPMProgram(argc, argv, Read, Calibrate);
}
