/* checkpoints.c - when a run writes checkpoints, what they have beside the particles, and which of them are kept. */
#include <dirent.h>
#include <unistd.h>
#include "base/fault.h"
#include "base/signals.h"
#include "results/checkpoint.h"
#include "run/restart.h"

/* --- Names: <output_dir>/<name>-checkpoint-<number>.h5, numbered as they are written -------------------------------- */

void MPMCheckpointPath(MPM mpm, PetscInt number, char path[MPM_TEXT_LEN])
{
  (void)snprintf(path, MPM_TEXT_LEN, "%.1900s/%s-checkpoint-%" PetscInt_FMT ".h5", mpm->output.dir, mpm->scene.name,
                 number);
}

/* Lists the numbers of the checkpoints in the folder of the results, the last first; the caller frees them. */
static PetscErrorCode ListHere(MPM mpm, PetscInt *n, PetscInt **numbers)
{
  char           start[2 * MPM_NAME_LEN];
  DIR           *dir = opendir(mpm->output.dir);
  struct dirent *entry;

  PetscFunctionBeginUser;
  *n       = 0;
  *numbers = NULL;
  if (!dir) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(start, sizeof start, "%s-checkpoint-", mpm->scene.name);
  while ((entry = readdir(dir))) {
    const char *digits = entry->d_name + strlen(start);
    size_t      length;

    if (strncmp(entry->d_name, start, strlen(start))) continue;
    length = strspn(digits, "0123456789");
    if (!length || length > 9 || strcmp(digits + length, ".h5")) continue;
    PetscCall(PetscRealloc((size_t)(*n + 1) * sizeof **numbers, numbers));
    (*numbers)[(*n)++] = (PetscInt)atol(digits);
  }
  (void)closedir(dir);
  PetscCall(PetscSortInt(*n, *numbers));
  for (PetscInt k = 0; k < *n / 2; k++) {
    const PetscInt swap = (*numbers)[k];

    (*numbers)[k]          = (*numbers)[*n - 1 - k];
    (*numbers)[*n - 1 - k] = swap;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCheckpointList(MPM mpm, MPI_Comm comm, PetscInt *n, PetscInt **numbers)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  *numbers = NULL;
  if (!rank) PetscCall(ListHere(mpm, n, numbers));
  PetscCallMPI(MPI_Bcast(n, 1, MPIU_INT, 0, comm));
  if (rank) PetscCall(PetscMalloc1(*n, numbers));
  if (*n) PetscCallMPI(MPI_Bcast(*numbers, (PetscMPIInt)*n, MPIU_INT, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes all checkpoints but the last -checkpoint_keep, and what killed runs left unfinished. Only the first process
   calls it. */
static PetscErrorCode RemoveOld(MPM mpm)
{
  PetscInt n, *numbers;

  PetscFunctionBeginUser;
  PetscCall(ListHere(mpm, &n, &numbers));
  for (PetscInt k = 0; k < n; k++) {
    char path[MPM_TEXT_LEN];

    if (numbers[k] > mpm->checkpoint.number - mpm->checkpoint.keep) continue;
    MPMCheckpointPath(mpm, numbers[k], path);
    if (MPMCheckpointIs(path)) (void)unlink(path); /* no other file of that name */
  }
  for (PetscInt k = PetscMax(1, mpm->checkpoint.number - 3); k <= mpm->checkpoint.number; k++) {
    char path[MPM_TEXT_LEN + 16];

    MPMCheckpointPath(mpm, k, path);
    strcat(path, MPM_NEW_FILE);
    (void)unlink(path);
  }
  PetscCall(PetscFree(numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- What is kept --------------------------------------------------------------------------------------------------- */

void MPMCheckpointTotals(char text[MPM_TEXT_LEN])
{
  text[0] = 0;
  for (PetscInt q = 0; q < MPM_NUM_DIAGNOSTICS; q++)
    (void)snprintf(text + strlen(text), MPM_TEXT_LEN - strlen(text), "%s ", MPMDiagnostics[q].name);
}

PetscInt MPMCheckpointHeader(MPM mpm, MPMKept kept[])
{
  MPMCheckpoint *c       = &mpm->checkpoint;
  const MPMKept  table[] = {
       {"step", MPM_KEPT_INT, 1, &c->step},
       {"time", MPM_KEPT_REAL, 1, &c->t},
       {"particles", MPM_KEPT_INT64, 1, &c->total},
       {"shapes", MPM_KEPT_INT64, 1, &c->shapes},
       {"snapshots", MPM_KEPT_INT, 1, &c->snapshots},
       {"history_length", MPM_KEPT_INT64, 1, &c->history_length},
       {"history_sum", MPM_KEPT_INT64, 1, &c->history_sum},
  };

  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) kept[k] = table[k];
  return (PetscInt)(sizeof table / sizeof table[0]);
}

/* What is kept only in scenes whose history asks for it. */
static PetscInt KeptMeasures(MPM mpm, MPMKept kept[])
{
  MPMCheckpoint *c    = &mpm->checkpoint;
  MPMCore       *core = &mpm->core;
  PetscInt       n    = 0;

  if (core->reactions) {
    kept[n++] = (MPMKept){"walls", MPM_KEPT_INT64, 24 * MPM_SUM_WORDS, c->walls};
    kept[n++] = (MPMKept){"walls_since", MPM_KEPT_REAL, 1, &core->reactions->since};
  }
  if (core->energy.nheat)
    kept[n++] = (MPMKept){"dissipation", MPM_KEPT_INT64, core->energy.nheat * MPM_SUM_WORDS, c->heat};
  if (mpm->monitor.measures.nprobes)
    kept[n++] = (MPMKept){"probes", MPM_KEPT_INT64, mpm->monitor.measures.nprobes, mpm->monitor.measures.ids};
  return n;
}

PetscInt MPMCheckpointKept(MPM mpm, MPMKept kept[])
{
  MPMCheckpoint *c       = &mpm->checkpoint;
  MPMCore       *core    = &mpm->core;
  MPMMonitor    *mon     = &mpm->monitor;
  MPMOutput     *out     = &mpm->output;
  MPMWatch      *watch   = &mpm->watch;
  const MPMKept  table[] = {
       {"totals", MPM_KEPT_TEXT, sizeof c->totals, c->totals},
       {"dt", MPM_KEPT_REAL, 1, &core->params.dt},
       {"kicked", MPM_KEPT_REAL, 1, &core->kicked},
       {"speed2", MPM_KEPT_REAL, 1, &core->status.v2},
       {"wave_speed2", MPM_KEPT_REAL, 1, &core->status.c2},
       {"courant", MPM_KEPT_REAL, 1, &watch->courant},
       {"courant_wave", MPM_KEPT_REAL, 1, &watch->wave},
       {"energies", MPM_KEPT_INT64, MPM_NUM_ENERGIES * MPM_SUM_WORDS, c->energies},
       {"lost", MPM_KEPT_INT64, MPM_NUM_LOST * MPM_SUM_WORDS, c->lost},
       {"wall_velocity", MPM_KEPT_REAL, 18, mpm->scene.walls.velocity},
       {"wall_place", MPM_KEPT_REAL, 6, mpm->scene.walls.place},
       {"damping_last", MPM_KEPT_REAL, 1, &core->damping.last},
       {"damping_stops", MPM_KEPT_INT, 1, &core->damping.stops},
       {"volumes_since", MPM_KEPT_REAL, 1, &core->volumes.since},
       {"volumes_opened", MPM_KEPT_INT64, 1, &core->status.opened},
       {"retry_limit", MPM_KEPT_REAL, 1, &mpm->retry.limit},
       {"retry_undone", MPM_KEPT_INT, 1, &mpm->retry.undone},
       {"retry_steps", MPM_KEPT_INT, 1, &mpm->retry.steps},
       {"retry_least", MPM_KEPT_REAL, 1, &mpm->retry.least},
       {"checkpoint_every", MPM_KEPT_REAL, 1, &c->every_was},
       {"checkpoint_next", MPM_KEPT_REAL, 1, &c->next},
       {"history_every", MPM_KEPT_REAL, 1, &c->history_was},
       {"history_next", MPM_KEPT_REAL, 1, &mon->next},
       {"history_last", MPM_KEPT_INT, 1, &mon->last},
       {"history_energy_max", MPM_KEPT_REAL, 1, &mon->energy_max},
       {"history_speed_max", MPM_KEPT_REAL, 1, &mon->speed_max},
       {"history_start", MPM_KEPT_REAL, 3 * MPM_NUM_DIAGNOSTICS, mon->start.sum},
       {"history_start_energies", MPM_KEPT_REAL, MPM_NUM_ENERGIES, mon->start.energy},
       {"history_start_particles", MPM_KEPT_INT64, 1, &mon->start.n},
       {"output_every", MPM_KEPT_REAL, 1, &c->output_was},
       {"output_next", MPM_KEPT_REAL, 1, &out->next},
       {"output_last", MPM_KEPT_INT, 1, &out->last},
       {"output_steps", MPM_KEPT_INT, out->count, out->steps},
       {"output_times", MPM_KEPT_REAL, out->count, out->times},
       {"output_digests", MPM_KEPT_INT64, out->count, out->digests},
       {"watch_dt_first", MPM_KEPT_REAL, 1, &watch->first},
       {"watch_dt_least", MPM_KEPT_REAL, 1, &watch->least},
       {"watch_dt_told", MPM_KEPT_REAL, 1, &watch->told},
       {"watch_t", MPM_KEPT_REAL, 1, &watch->t},
       {"watch_cause", MPM_KEPT_TEXT, sizeof watch->cause, watch->cause},
       {"watch_near", MPM_KEPT_INT, 1, &watch->near},
       {"watch_torn", MPM_KEPT_BOOL, 1, &watch->torn},
       {"watch_torn_at", MPM_KEPT_REAL, 1, &watch->torn_at},
       {"watch_beyond", MPM_KEPT_INT, 1, &watch->beyond},
       {"watch_grows_at", MPM_KEPT_REAL, 1, &watch->grows_at},
  };

  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) kept[k] = table[k];
  return (PetscInt)(sizeof table / sizeof table[0]) +
         KeptMeasures(mpm, kept + (PetscInt)(sizeof table / sizeof table[0]));
}

/* --- Writing -------------------------------------------------------------------------------------------------------- */

/* Sets what is kept of the run that is no variable of it. Collective on exchange.data. */
static PetscErrorCode Prepare(MPM mpm)
{
  MPMCheckpoint *c    = &mpm->checkpoint;
  MPMCore       *core = &mpm->core;
  MPMSum         sum[MPM_NUM_ENERGIES], lost[MPM_NUM_LOST], one;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 24 && core->reactions; k++) {
    one = k < 18 ? core->reactions->impulse[k / 3][k % 3] : core->reactions->work[k - 18];
    PetscCall(MPMSumReduce(&one, 1, core->exchange.data));
    PetscCall(PetscArraycpy(c->walls[k], one.word, MPM_SUM_WORDS));
  }
  for (PetscInt k = 0; k < core->energy.nheat; k++) {
    one = core->energy.heat[k];
    PetscCall(MPMSumReduce(&one, 1, core->exchange.data));
    PetscCall(PetscArraycpy(c->heat + k * MPM_SUM_WORDS, one.word, MPM_SUM_WORDS));
  }
  MPMCheckpointTotals(c->totals);
  c->step           = core->step;
  c->t              = core->t;
  c->total          = core->particles.total;
  c->shapes         = mpm->scene.shapes;
  c->snapshots      = mpm->output.count;
  c->history_length = mpm->monitor.length; /* of the first process, which writes */
  c->history_sum    = (PetscInt64)MPMMonitorSum(&mpm->monitor, &mpm->scene, mpm->monitor.length);
  c->every_was      = c->every;
  c->history_was    = mpm->monitor.every;
  c->output_was     = mpm->output.every;
  PetscCall(PetscArraycpy(sum, core->energy.sum, MPM_NUM_ENERGIES));
  PetscCall(MPMSumReduce(sum, MPM_NUM_ENERGIES, core->exchange.data));
  for (PetscInt e = 0; e < MPM_NUM_ENERGIES; e++) PetscCall(PetscArraycpy(c->energies[e], sum[e].word, MPM_SUM_WORDS));
  PetscCall(PetscArraycpy(lost, core->lost, MPM_NUM_LOST));
  PetscCall(MPMSumReduce(lost, core->particles.total < core->particles.born ? MPM_NUM_LOST : 0, core->exchange.data));
  for (PetscInt e = 0; e < MPM_NUM_LOST; e++) PetscCall(PetscArraycpy(c->lost[e], lost[e].word, MPM_SUM_WORDS));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends a word of a command to it, in quotes where a shell needs them. */
static void Append(char text[], size_t len, const char word[])
{
  const size_t n = strlen(text);

  (void)snprintf(text + n, len - n, "%s", n ? " " : "");
  if (word[0] &&
      strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._/+-=,:%@") == strlen(word))
    (void)snprintf(text + strlen(text), len - strlen(text), "%s", word);
  else {
    (void)snprintf(text + strlen(text), len - strlen(text), "'");
    for (; *word; word++)
      (void)snprintf(text + strlen(text), len - strlen(text), *word == '\'' ? "'\\''" : "%c", *word);
    (void)snprintf(text + strlen(text), len - strlen(text), "'");
  }
}

/* Returns the command that goes on from a checkpoint: this run's, with -restart_file. */
static PetscErrorCode Command(const char path[], char text[], size_t len)
{
  int    argc;
  char **argv;

  PetscFunctionBeginUser;
  PetscCall(PetscGetArgs(&argc, &argv));
  text[0] = 0;
  for (int k = 0; k < argc; k++) {
    if (k + 1 < argc && !strcmp(argv[k], "-restart_file"))
      k++;
    else
      Append(text, len, argv[k]);
  }
  Append(text, len, "-restart_file");
  Append(text, len, path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCheckpointNow(MPM mpm)
{
  MPMCheckpoint *c    = &mpm->checkpoint;
  MPMCore       *core = &mpm->core;
  MPMKept        kept[MPM_MAX_KEPT];
  PetscInt       nkept, n, *numbers;
  PetscLogDouble t0, t1;
  PetscReal      bytes;
  PetscMPIInt    rank;
  char           path[MPM_TEXT_LEN], before[MPM_TEXT_LEN], fault[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMTimersClock(&core->timers, &t0));
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  PetscCall(MPMCheckpointList(mpm, core->exchange.data, &n, &numbers));
  if (n) MPMCheckpointPath(mpm, numbers[0], before);
  c->number = n ? numbers[0] + 1 : 1;
  c->last   = core->step;
  if (c->every > 0) c->next = MPMNextTime(core->t, c->every);
  PetscCall(PetscFree(numbers));
  PetscCall(Prepare(mpm));
  nkept = MPMCheckpointHeader(mpm, kept);
  nkept += MPMCheckpointKept(mpm, kept + nkept);
  MPMCheckpointPath(mpm, c->number, path);
  PetscCall(MPMCheckpointWrite(path, core, &mpm->scene, nkept, kept, &bytes, fault));
  PetscCall(PetscTime(&c->written));
  if (fault[0]) {
    (void)snprintf(core->stop, sizeof core->stop, "%.1500s; %s%.400s", fault,
                   n ? "the checkpoint before is complete: " : "there is no checkpoint before", n ? before : "");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!rank) PetscCall(RemoveOld(mpm));
  (void)snprintf(c->path, sizeof c->path, "%s", path);
  PetscCall(MPMTimersClock(&core->timers, &t1));
  PetscCall(MPMSay(&core->print, "checkpoint", "step %" PetscInt_FMT ", t=%g s: %s, %.3g MB in %.2g s", core->step,
                   (double)core->t, path, (double)(bytes / 1e6), t1 - t0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where history or snapshots could not be written, tries to write a checkpoint, once, and says what the run can go on
   from. Collective on exchange.data. */
static PetscErrorCode Rescue(MPM mpm)
{
  MPMCheckpoint *c    = &mpm->checkpoint;
  MPMCore       *core = &mpm->core;
  char           why[MPM_TEXT_LEN], command[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (c->rescued) PetscFunctionReturn(PETSC_SUCCESS);
  c->rescued = PETSC_TRUE;
  (void)snprintf(why, sizeof why, "%s", core->stop);
  core->stop[0] = 0;
  if (c->last != core->step || !c->path[0]) PetscCall(MPMCheckpointNow(mpm));
  PetscCall(Command(c->path, command, sizeof command));
  if (c->path[0])
    (void)snprintf(core->stop, sizeof core->stop, "%.900s; go on with: %.1000s", why, command);
  else
    (void)snprintf(core->stop, sizeof core->stop, "%.1500s; there is no checkpoint", why);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCheckpointStep(MPM mpm, PetscBool ends)
{
  MPMCheckpoint  *c     = &mpm->checkpoint;
  MPMCore        *core  = &mpm->core;
  const PetscInt  asked = ends ? MPM_ASKED_NOTHING : (PetscInt)core->status.asked;
  PetscLogDouble  now;
  PetscMPIInt     rank;
  const PetscBool due = c->every > 0 && core->t >= c->next ? PETSC_TRUE : PETSC_FALSE;

  PetscFunctionBeginUser;
  if (c->off) PetscFunctionReturn(PETSC_SUCCESS);
  if (c->wall > 0) { /* the first process asks, and all hear of it with the status of the next step */
    PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
    PetscCall(PetscTime(&now));
    if (!rank && now - c->written >= c->wall) {
      c->written = now;
      MPMSignalsAsk();
    }
  }
  if (core->stop[0] && (mpm->output.failed || mpm->monitor.failed)) {
    PetscCall(Rescue(mpm));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (c->last == core->step || (core->stop[0] && asked != MPM_ASKED_END)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!asked && !due && !(ends && (c->wanted || c->path[0]))) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMCheckpointNow(mpm));
  if (asked == MPM_ASKED_END && c->path[0] && c->last == core->step && strstr(core->stop, "signal")) {
    char command[MPM_TEXT_LEN];

    PetscCall(Command(c->path, command, sizeof command));
    (void)snprintf(core->stop, sizeof core->stop, "interrupted by a signal; go on with: %.1900s", command);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCheckpointOfStop(MPM mpm)
{
  MPMCore *core = &mpm->core;
  char     why[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (mpm->checkpoint.off || mpm->checkpoint.last == core->step) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(why, sizeof why, "%s", core->stop);
  core->stop[0] = 0;
  PetscCall(MPMCheckpointNow(mpm));
  if (core->stop[0]) { /* it could not be written */
    char fault[MPM_TEXT_LEN];

    (void)snprintf(fault, sizeof fault, "%s", core->stop);
    (void)snprintf(core->stop, sizeof core->stop, "%.1000s; %.900s", why, fault);
  } else
    (void)snprintf(core->stop, sizeof core->stop, "%s", why);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Options -------------------------------------------------------------------------------------------------------- */

PetscErrorCode MPMCheckpointSetFromOptions(MPM mpm, MPMOptions o)
{
  MPMCheckpoint *c = &mpm->checkpoint;
  PetscBool      every, wall;

  PetscFunctionBeginUser;
  c->last = -1;
  PetscCall(MPMOptionsReal(o, "checkpoint_every", NULL, &c->every, &every));
  PetscCall(MPMOptionsReal(o, "checkpoint_wall", NULL, &c->wall, &wall));
  PetscCall(MPMOptionsInt(o, "checkpoint_keep", NULL, &c->keep, NULL));
  c->wanted = (every && c->every > 0) || (wall && c->wall > 0) ? PETSC_TRUE : PETSC_FALSE;
  c->next   = MPMNextTime(0, c->every);
  PetscCall(PetscTime(&c->written));
#if !defined(PETSC_HAVE_HDF5)
  if (c->wanted)
    MPMOptionsFail(o, "-checkpoint_%s needs a PETSc with HDF5, and this one has none", every ? "every" : "wall");
  c->off = PETSC_TRUE;
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in restart.h. */
PetscErrorCode MPMCheckpointNote(MPM mpm)
{
  PetscInt n, *numbers;
  char     path[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (mpm->checkpoint.off || mpm->checkpoint.from[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMCheckpointList(mpm, mpm->core.exchange.data, &n, &numbers));
  if (n) {
    MPMCheckpointPath(mpm, numbers[0], path);
    PetscCall(MPMNote(
        &mpm->core.print,
        "%s is of an earlier run: -restart_file latest goes on from it; this run starts anew, and replaces it once it "
        "writes checkpoints",
        path));
  }
  PetscCall(PetscFree(numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}
