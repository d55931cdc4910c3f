/* checkpoints.c - when a run writes checkpoints, what they have beside the particles, and which of them are kept. */
#include <dirent.h>
#include <unistd.h>
#include "base/signals.h"
#include "restart/checkpoint.h"
#include "restart/restart.h"

/* --- Names: <output_dir>/<name>-checkpoint-<number>.h5, numbered as they are written ------------------------------ */

void MPMCheckpointPath(MPMCheckpoint *c, PetscInt number, char path[MPM_TEXT_LEN])
{
  (void)snprintf(path, MPM_TEXT_LEN, "%.1900s/%s-checkpoint-%" PetscInt_FMT ".h5", c->output->dir, c->scene->name,
                 number);
}

/* Lists the numbers of the checkpoints in the folder of the results, the last first; the caller frees them. */
static PetscErrorCode ListHere(MPMCheckpoint *c, PetscInt *n, PetscInt **numbers)
{
  char           start[2 * MPM_NAME_LEN];
  DIR           *dir = opendir(c->output->dir);
  struct dirent *entry;

  PetscFunctionBeginUser;
  *n       = 0;
  *numbers = NULL;
  if (!dir) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(start, sizeof start, "%s-checkpoint-", c->scene->name);
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

PetscErrorCode MPMCheckpointList(MPMCheckpoint *c, MPI_Comm comm, PetscInt *n, PetscInt **numbers)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  *numbers = NULL;
  if (!rank) PetscCall(ListHere(c, n, numbers));
  PetscCallMPI(MPI_Bcast(n, 1, MPIU_INT, 0, comm));
  if (rank) PetscCall(PetscMalloc1(*n, numbers));
  if (*n) PetscCallMPI(MPI_Bcast(*numbers, (PetscMPIInt)*n, MPIU_INT, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Removes all checkpoints but the last -checkpoint_keep, and what killed runs left unfinished. Only the first process
   calls it. */
static PetscErrorCode RemoveOld(MPMCheckpoint *c)
{
  PetscInt n, *numbers;

  PetscFunctionBeginUser;
  PetscCall(ListHere(c, &n, &numbers));
  for (PetscInt k = 0; k < n; k++) {
    char path[MPM_TEXT_LEN];

    if (numbers[k] > c->number - c->keep) continue;
    MPMCheckpointPath(c, numbers[k], path);
    if (MPMCheckpointIs(path)) (void)unlink(path); /* no other file of that name */
  }
  for (PetscInt k = PetscMax(1, c->number - 3); k <= c->number; k++) {
    char path[MPM_TEXT_LEN + 16];

    MPMCheckpointPath(c, k, path);
    strcat(path, MPM_NEW_FILE);
    (void)unlink(path);
  }
  PetscCall(PetscFree(numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- What is kept ------------------------------------------------------------------------------------------------- */

void MPMCheckpointTotals(char text[MPM_TEXT_LEN])
{
  text[0] = 0;
  for (PetscInt q = 0; q < MPM_NUM_DIAGNOSTICS; q++) MPMAppend(text, MPM_TEXT_LEN, "%s ", MPMDiagnostics[q].name);
}

void MPMCheckpointHeader(MPMCheckpoint *c, MPMVariables *v)
{
  const MPMVariable table[] = {
      {"step", MPM_VARIABLE_INT, 1, &c->step, MPM_KEPT},
      {"time", MPM_VARIABLE_REAL, 1, &c->t, MPM_KEPT},
      {"particles", MPM_VARIABLE_INT64, 1, &c->total, MPM_KEPT},
      {"stage", MPM_VARIABLE_INT, 1, &c->stage, MPM_KEPT},
      {"stage_began", MPM_VARIABLE_REAL, 1, &c->began, MPM_KEPT},
      {"shapes", MPM_VARIABLE_INT64, 1, &c->shapes, MPM_KEPT},
      {"kinds", MPM_VARIABLE_INT64, 1, &c->kinds, MPM_KEPT},
      {"start", MPM_VARIABLE_INT, MPM_START_NUMBERS, &c->start, MPM_KEPT},
      {"snapshots", MPM_VARIABLE_INT, 1, &c->snapshots, MPM_KEPT},
      {"history_length", MPM_VARIABLE_INT64, 1, &c->history_length, MPM_KEPT},
      {"history_sum", MPM_VARIABLE_INT64, 1, &c->history_sum, MPM_KEPT},
      {"totals", MPM_VARIABLE_TEXT, sizeof c->totals, c->totals, MPM_KEPT},
  };

  v->n = (PetscInt)(sizeof table / sizeof table[0]);
  for (PetscInt k = 0; k < v->n; k++) v->row[k] = table[k];
}

/* --- Writing ------------------------------------------------------------------------------------------------------ */

/* Sets what is read before a scene is set up. */
static void SetHeader(MPMCheckpoint *c)
{
  MPMCheckpointTotals(c->totals);
  c->step           = c->core->step;
  c->t              = c->core->t;
  c->total          = c->core->particles.total;
  c->stage          = c->core->stages.now;
  c->began          = c->core->stages.began;
  c->shapes         = c->scene->shapes;
  c->kinds          = MPMRestartKinds(c->scene);
  c->start          = c->scene->start;
  c->snapshots      = c->output->count;
  c->history_length = c->monitor->length; /* of the first process, which writes */
  c->history_sum    = (PetscInt64)MPMMonitorSum(c->monitor, c->scene, c->monitor->length);
}

/* Appends a word of a command to it, in quotes where a shell needs them. */
static void Append(char text[], size_t len, const char word[])
{
  const size_t n = strlen(text);

  (void)snprintf(text + n, len - n, "%s", n ? " " : "");
  if (word[0] &&
      strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._/+-=,:%@") == strlen(word))
    MPMAppend(text, len, "%s", word);
  else {
    MPMAppend(text, len, "'");
    for (; *word; word++) MPMAppend(text, len, *word == '\'' ? "'\\''" : "%c", *word);
    MPMAppend(text, len, "'");
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

/* Writes a checkpoint. Collective on exchange.data. */
static PetscErrorCode Now(MPMCheckpoint *c)
{
  MPMCore       *core = c->core;
  MPMVariables   kept, header;
  PetscInt       n, *numbers;
  PetscLogDouble t0, t1;
  PetscReal      bytes;
  MPMTotals      totals;
  PetscMPIInt    rank;
  char           path[MPM_TEXT_LEN], before[MPM_TEXT_LEN], fault[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMTimersClock(&core->timers, &t0));
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  PetscCall(MPMCheckpointList(c, core->exchange.data, &n, &numbers));
  if (n) MPMCheckpointPath(c, numbers[0], before);
  c->number = n ? numbers[0] + 1 : 1;
  c->last   = core->step;
  if (c->every > 0) c->next = MPMNextTime(core->t, c->every);
  PetscCall(PetscFree(numbers));
  PetscCall(MPMTotalsCompute(c->scene, core, &totals));
  core->changes.strain = totals.sum[MPM_SHOWS_strain_energy][0];
  SetHeader(c);
  MPMCheckpointHeader(c, &header);
  c->list(c->run, &kept);
  for (PetscInt k = 0; k < header.n; k++) kept.row[kept.n++] = header.row[k];
  MPMCheckpointPath(c, c->number, path);
  PetscCall(MPMCheckpointWrite(path, core, c->scene, &kept, &bytes, fault));
  PetscCall(PetscTime(&c->written));
  if (fault[0]) {
    (void)snprintf(core->stop, sizeof core->stop, "%.1500s; %s%.400s", fault,
                   n ? "the checkpoint before is complete: " : "there is no checkpoint before", n ? before : "");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!rank) PetscCall(RemoveOld(c));
  (void)snprintf(c->path, sizeof c->path, "%s", path);
  PetscCall(MPMTimersClock(&core->timers, &t1));
  PetscCall(MPMSay(&core->print, "checkpoint", "step %" PetscInt_FMT ", t=%g s: %s, %.3g MB in %.2g s", core->step,
                   (double)core->t, path, (double)(bytes / 1e6), t1 - t0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where history or snapshots could not be written, tries to write a checkpoint, once, and says what the run can go on
   from. Collective on exchange.data. */
static PetscErrorCode Rescue(MPMCheckpoint *c)
{
  MPMCore *core = c->core;
  char     why[MPM_TEXT_LEN], command[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (c->rescued) PetscFunctionReturn(PETSC_SUCCESS);
  c->rescued = PETSC_TRUE;
  (void)snprintf(why, sizeof why, "%s", core->stop);
  core->stop[0] = 0;
  if (c->last != core->step || !c->path[0]) PetscCall(Now(c));
  PetscCall(Command(c->path, command, sizeof command));
  if (c->path[0])
    (void)snprintf(core->stop, sizeof core->stop, "%.900s; go on with: %.1000s", why, command);
  else
    (void)snprintf(core->stop, sizeof core->stop, "%.1500s; there is no checkpoint", why);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCheckpointStep(MPMCheckpoint *c, PetscBool ends)
{
  MPMCore        *core  = c->core;
  const PetscInt  asked = ends ? MPM_ASKED_NOTHING : (PetscInt)core->status.asked;
  PetscLogDouble  now;
  PetscMPIInt     rank;
  const PetscBool due = c->every > 0 && core->t >= c->next;

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
  if (core->stop[0] && (c->output->failed || c->monitor->failed)) {
    PetscCall(Rescue(c));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (c->last == core->step || (core->stop[0] && asked != MPM_ASKED_END)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!asked && !due && !(ends && (c->wanted || c->path[0]))) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Now(c));
  if (asked == MPM_ASKED_END && c->path[0] && c->last == core->step && strstr(core->stop, "signal")) {
    char command[MPM_TEXT_LEN];

    PetscCall(Command(c->path, command, sizeof command));
    (void)snprintf(core->stop, sizeof core->stop, "interrupted by a signal; go on with: %.1900s", command);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCheckpointOfStop(MPMCheckpoint *c)
{
  MPMCore *core = c->core;
  char     why[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (c->off || c->last == core->step) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(why, sizeof why, "%s", core->stop);
  core->stop[0] = 0;
  PetscCall(Now(c));
  if (core->stop[0]) { /* it could not be written */
    char fault[MPM_TEXT_LEN];

    (void)snprintf(fault, sizeof fault, "%s", core->stop);
    (void)snprintf(core->stop, sizeof core->stop, "%.1000s; %.900s", why, fault);
  } else
    (void)snprintf(core->stop, sizeof core->stop, "%s", why);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCheckpointAgain(MPMCheckpoint *c)
{
  PetscFunctionBeginUser;
  if (!c->off) PetscCall(Now(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Options ------------------------------------------------------------------------------------------------------ */

PetscErrorCode MPMCheckpointSetFromOptions(MPMCheckpoint *c, MPMOptions o)
{
  PetscBool every, wall;

  PetscFunctionBeginUser;
  c->last = -1;
  PetscCall(MPMOptionsReal(o, "checkpoint_every", NULL, &c->every, &every));
  PetscCall(MPMOptionsReal(o, "checkpoint_wall", NULL, &c->wall, &wall));
  PetscCall(MPMOptionsInt(o, "checkpoint_keep", NULL, &c->keep, NULL));
  c->wanted = c->core->stages.n || (every && c->every > 0) || (wall && c->wall > 0);
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
PetscErrorCode MPMCheckpointNote(MPMCheckpoint *c)
{
  PetscInt n, *numbers;
  char     path[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (c->off || c->from[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMCheckpointList(c, c->core->exchange.data, &n, &numbers));
  if (n) {
    MPMCheckpointPath(c, numbers[0], path);
    PetscCall(MPMNote(
        &c->core->print,
        "%s is of an earlier run: -restart_file latest goes on from it; this run starts anew, and replaces it once it "
        "writes checkpoints",
        path));
  }
  PetscCall(PetscFree(numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}
