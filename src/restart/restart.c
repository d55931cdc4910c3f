/* restart.c - a run that goes on from a checkpoint (-restart_file): which file, whether its options are those of this
   run, its particles and everything else. */
#include "parallel/exchange.h"
#include "restart/restart.h"
#include "step/step.h"

/* Sets the file to go on from: the one given, or the last whole one of this scene. Collective on core.comm. */
static PetscErrorCode Choose(MPMCheckpoint *c, MPMOptions o, const char given[])
{
  PetscInt n, *numbers;
  char     fault[MPM_TEXT_LEN], first[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  if (strcmp(given, "latest")) {
    PetscCall(MPMCheckpointCheck(given, c->core->comm, fault));
    if (fault[0]) MPMOptionsFail(o, "-restart_file: %s; -restart_file latest takes the last complete one", fault);
    (void)snprintf(c->from, sizeof c->from, "%s", given);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMCheckpointList(c, c->core->comm, &n, &numbers));
  for (PetscInt k = 0; k < n && !c->from[0]; k++) {
    char path[MPM_TEXT_LEN];

    MPMCheckpointPath(c, numbers[k], path);
    PetscCall(MPMCheckpointCheck(path, c->core->comm, fault));
    if (!fault[0]) (void)snprintf(c->from, sizeof c->from, "%s", path);
    if (fault[0] && !first[0]) (void)snprintf(first, sizeof first, "%s", fault);
  }
  PetscCall(PetscFree(numbers));
  (void)snprintf(c->fallback, sizeof c->fallback, "%s", first);
  if (!c->from[0] && first[0]) MPMOptionsFail(o, "-restart_file latest: no checkpoint is complete: %s", first);
  if (!c->from[0])
    MPMOptionsFail(o,
                   "-restart_file latest: there is no checkpoint %s/%s-checkpoint-*.h5 (-output_dir names the folder)",
                   c->output->dir, c->scene->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* With -output_replace false, refuses a run that would take the place of one that can go on. */
static PetscErrorCode KeepOld(MPMCheckpoint *c, MPMOptions o)
{
  PetscInt n, *numbers;
  char     path[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMCheckpointList(c, c->core->comm, &n, &numbers));
  if (n) MPMCheckpointPath(c, numbers[0], path);
  if (n)
    MPMOptionsFail(
        o,
        "-output_replace false: %s is there; go on from it (-restart_file latest), or give another -output_name or "
        "-output_dir",
        path);
  PetscCall(PetscFree(numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether the history in the folder of the results is that of the run up to the checkpoint. If it is not, the
   results there are those of another run, which -output_replace false keeps. Collective on core.comm. */
static PetscErrorCode FindHistory(MPMCheckpoint *c, MPMOptions o)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  c->monitor->dir = c->output->dir;
  PetscCallMPI(MPI_Comm_rank(c->core->comm, &rank));
  if (!rank)
    c->own = c->history_length > 0 &&
             MPMMonitorSum(c->monitor, c->scene, (long)c->history_length) == (uint64_t)c->history_sum;
  PetscCallMPI(MPI_Bcast(&c->own, 1, MPM_MPI_BOOL, 0, c->core->comm));
  c->output->resumed = c->own;
  if (!c->own && c->output->keep) PetscCall(KeepOld(c, o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds whether the checkpoint is of this stage, or of the one before if this one follows it. */
static void CheckStage(MPMCheckpoint *c, MPMOptions o)
{
  const MPMStages *s = &c->core->stages;

  if (c->stage < 1 || c->stage > s->n)
    MPMOptionsFail(o, "-restart_file %.500s is of no stage of this run; go on from it without -stages", c->from);
  else if (c->stage != s->now - (c->follows ? 1 : 0))
    c->other = PETSC_TRUE;
  else if (!c->follows)
    c->core->stages.began = c->began;
}

PetscErrorCode MPMRestartSetFromOptions(MPMCheckpoint *c, PetscReal end, MPMOptions o)
{
  char         given[MPM_TEXT_LEN] = "", fault[MPM_TEXT_LEN], *text;
  MPMVariables header;
  PetscBool    set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "restart_file", NULL, given, &set));
  PetscCall(MPMOptionsString(o, "rerun", NULL, fault, NULL));                /* it has been read (MPMRerun) */
  if (c->options && !MPMOptionsError(o)) PetscCall(MPMRestartCompare(c, o)); /* with those of the stage before */
  if (c->options) c->scene->start = c->start;
  if (!set) PetscCall(MPMLeaveSetFromOptions(c, c->options ? PETSC_TRUE : PETSC_FALSE, o));
  if (!set && c->output->keep && !c->off && !MPMOptionsError(o)) PetscCall(KeepOld(c, o));
  if (!set || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
#if !defined(PETSC_HAVE_HDF5)
  MPMOptionsFail(o, "-restart_file needs a PETSc with HDF5, and this one has none");
#endif
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Choose(c, o, given));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMCheckpointOptions(c->from, &text, c->git));
  MPMCheckpointHeader(c, &header);
  PetscCall(MPMCheckpointRead(c->from, c->core->comm, &header, fault));
  if (fault[0]) MPMOptionsFail(o, "-restart_file: %s", fault);
  if (c->core->stages.n) CheckStage(c, o);
  PetscCall(MPMStagesOptions(text, c->stage, &c->options));
  PetscCall(PetscFree(text));
  if (MPMOptionsError(o) || c->other) PetscFunctionReturn(PETSC_SUCCESS);
  if (!MPMOptionsError(o)) PetscCall(MPMRestartCompare(c, o));
  if (!MPMOptionsError(o)) PetscCall(MPMLeaveSetFromOptions(c, PETSC_TRUE, o));
  c->scene->start = c->start;
  if (c->shapes != c->scene->shapes)
    MPMOptionsFail(
        o,
        "-restart_file %.500s: what -body_<b>_file names has changed since the run that wrote it; put the old "
        "files back, or start anew",
        c->from);
  PetscCall(FindHistory(c, o));
  if (!MPMOptionsError(o) && c->t > end * (1 + 1e-9))
    MPMOptionsFail(o, "-time_end %g lies before the time of -restart_file %s, %g s", (double)end, c->from,
                   (double)c->t);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Particles ---------------------------------------------------------------------------------------------------- */

/* Returns the rows of the file that a process reads first, an equal part of them. */
static void Share(MPMCheckpoint *c, PetscMPIInt rank, PetscMPIInt size, PetscInt64 *first, PetscInt *n)
{
  const PetscInt64 total = c->total, part = total / size, more = total % size;

  *first = part * rank + PetscMin(rank, more);
  *n     = (PetscInt)(part + (rank < more ? 1 : 0));
}

PetscErrorCode MPMRestartHistogram(MPMCheckpoint *c, MPMHistogram *h)
{
  const PetscInt place    = c->core->grid.total ? MPM_FIELD_INDEX_X : MPM_FIELD_INDEX_x;
  const PetscInt fields[] = {place, MPM_FIELD_INDEX_kind, MPM_FIELD_INDEX_l};
  MPMParticles  *p        = &c->core->particles;
  void          *rows[3]  = {NULL};
  MPMView        view;
  PetscMPIInt    rank, size;
  PetscInt64     first;
  PetscInt       n;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(h->comm, &rank));
  PetscCallMPI(MPI_Comm_size(h->comm, &size));
  Share(c, rank, size, &first, &n);
  for (int k = 0; k < 3; k++) {
    if (!p->present[fields[k]] || c->missing >> fields[k] & 1) continue;
    PetscCall(PetscMalloc1(PetscMax(1, (size_t)n * (size_t)p->bytes[fields[k]]), (char **)&rows[k]));
    PetscCall(MPMCheckpointRows(c->from, p, fields[k], first, n, rows[k]));
  }
  PetscCall(PetscMemzero(&view, sizeof view));
  view.n = n;
  view.x = view.X = (PetscReal *)rows[0];
  view.kind       = (PetscInt *)rows[1];
  view.l          = (PetscReal *)rows[2];
  PetscCall(MPMHistogramAddView(h, c->core, &view));
  for (int k = 0; k < 3; k++) PetscCall(PetscFree(rows[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRestartParticles(MPMCheckpoint *c)
{
  MPMParticles *p                    = &c->core->particles;
  PetscReal    *kept[MPM_NUM_FIELDS] = {NULL};
  PetscMPIInt   rank, size;
  PetscInt64    first;
  PetscInt      n;

  PetscFunctionBeginUser;
  if (c->missing) PetscCall(MPMRefillBegin(c, kept));
  PetscCallMPI(MPI_Comm_rank(c->core->exchange.data, &rank));
  PetscCallMPI(MPI_Comm_size(c->core->exchange.data, &size));
  Share(c, rank, size, &first, &n);
  p->total = c->total;
  PetscCall(MPMParticlesSetSize(p, n));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    void *rows;

    if (!p->present[f] || !MPMCheckpointHasField(f) || c->missing >> f & 1) continue;
    PetscCall(MPMParticlesGetField(p, f, &rows));
    PetscCall(MPMCheckpointRows(c->from, p, f, first, n, rows));
    PetscCall(MPMParticlesRestoreField(p, f));
  }
  if (c->missing) PetscCall(MPMRefillEnd(c, kept));
  PetscCall(MPMExchangeDistribute(c->core));
  if (c->core->grid.total) PetscCall(MPMCheckpointNodes(c->from, &c->core->grid, &c->core->exchange.patch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- All else ----------------------------------------------------------------------------------------------------- */

/* Lets what the options changed act: the next step is as long as the present state allows; statics become a motion that
   begins at rest. Collective on exchange.data. */
static PetscErrorCode Change(MPMCheckpoint *c, const MPMStatus *bound)
{
  MPMCore *core = c->core;
  MPMView  view;

  PetscFunctionBeginUser;
  core->status.v2 = bound->v2;
  core->status.c2 = bound->c2;
  if (c->was_static) {
    PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(v), &view));
    PetscCall(PetscArrayzero(view.v, view.n * core->grid.dim));
    PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(v), &view));
    if (core->grid.total) MPMTotalScale(core, 0);
    core->status.v2 = 0;
    PetscCall(MPMTotalsCompute(c->scene, core, &c->monitor->now));
  }
  if (c->was_implicit) core->damping.rest = PETSC_TRUE; /* the next kick is half of a step */
  if (c->was_implicit && !core->implicit && !core->grid.total) core->params.dt = 0; /* or that of a first step */
  MPMRestartBalance(c, &c->monitor->now);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRestartState(MPMCheckpoint *c, MPMWalls *walls)
{
  MPMCore        *core  = c->core;
  MPMOutput      *out   = c->output;
  MPMMonitor     *mon   = c->monitor;
  const PetscReal every = c->every, history = mon->every, output = out->every; /* of the options of this run */
  const PetscInt  room  = (c->snapshots + 63) / 64 * 64; /* MPMOutputStep makes more in steps of 64 */
  const MPMStatus bound = core->status;
  MPMVariables    kept;
  char            fault[MPM_TEXT_LEN], totals[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(PetscMax(1, room), &out->steps));
  PetscCall(PetscMalloc1(PetscMax(1, room), &out->times));
  PetscCall(PetscMalloc1(PetscMax(1, room), &out->digests));
  out->count = c->snapshots;
  MPMCheckpointTotals(totals);
  c->list(c->run, &kept);
  for (PetscInt k = 0; k < kept.n && c->was_implicit && !core->implicit; k++) /* what only the other frame has */
    if (!kept.row[k].n) kept.row[k].at = NULL;
  PetscCall(MPMCheckpointRead(c->from, core->exchange.data, &kept, fault));
  if (!fault[0] && strcmp(totals, c->totals))
    (void)snprintf(fault, sizeof fault, "cannot go on from %.1000s: another version of pebble wrote it", c->from);
  if (fault[0]) {
    (void)snprintf(core->stop, sizeof core->stop, "%s", fault);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  core->step         = c->step;
  core->t            = c->t;
  core->timers.first = c->step;
  MPMWallsMove(walls);
  MPMWallsReachTo(walls, &core->grid, core->basis);
  c->history_was = mon->every;
  c->output_was  = out->every;
  if (every != c->every) c->next = MPMNextTime(core->t, every);
  if (history != c->history_was) mon->next = MPMNextTime(core->t, history);
  if (output != c->output_was) out->next = MPMNextTime(core->t, output);
  c->every   = every;
  mon->every = history;
  out->every = output;
  c->last    = core->step;
  if (!out->enabled) out->count = 0;
  PetscCall(MPMTotalsCompute(c->scene, core, &mon->now));
  if (!(core->rest.limit > 0) || c->changed || c->stage != core->stages.now) {
    core->rest.since   = -1;
    core->rest.reached = PETSC_FALSE;
  }
  if (c->changed) PetscCall(Change(c, &bound));
  PetscCall(MPMLeave(c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRestartFiles(MPMCheckpoint *c)
{
  PetscInt here = 0, n, *numbers;
  char     path[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (c->fallback[0]) PetscCall(MPMWarn(&c->core->print, "%s; going on from the one before", c->fallback));
  PetscCall(MPMPrint(&c->core->print, "restart    from step %" PetscInt_FMT ", t=%g s of %s\n", c->step, (double)c->t,
                     c->from));
  if (strcmp(c->git, MPMVersionGit))
    PetscCall(
        MPMNote(&c->core->print,
                "%s wrote the checkpoint, and this is %s: the bits may differ from those of a run without a restart",
                c->git, MPMVersionGit));
  PetscCall(MPMCheckpointList(c, c->core->exchange.data, &n, &numbers));
  for (PetscInt k = 0; k < n; k++) {
    MPMCheckpointPath(c, numbers[k], path);
    if (!strcmp(path, c->from)) here = numbers[k];
  }
  if (n && here > 0 && numbers[0] > here && !c->fallback[0]) {
    MPMCheckpointPath(c, numbers[0], path);
    PetscCall(MPMWarn(
        &c->core->print,
        "there are later checkpoints, to %s: -restart_file latest takes that one until this run has written its own",
        path));
  }
  PetscCall(PetscFree(numbers));
  if (c->monitor->every != c->history_was || c->output->every != c->output_was)
    PetscCall(MPMPrint(&c->core->print, "restart    history every %g s, was %g s; snapshots every %g s, were %g s\n",
                       (double)c->monitor->every, (double)c->history_was, (double)c->output->every,
                       (double)c->output_was));
  if (c->differ[0]) PetscCall(MPMPrint(&c->core->print, "restart    changed options: %s\n", c->differ));
  if (c->left[0] > 0)
    PetscCall(MPMPrint(&c->core->print, "restart    %.0f particles leave with their bodies, of %g kg\n",
                       (double)c->left[0], (double)c->left[1]));
  if (c->scene->dry_run) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMMonitorResume(c->monitor, c->core, c->scene, c->own, (long)c->history_length));
  PetscCall(MPMOutputResume(c->output, c->core, c->scene));
  if (c->monitor->joined) PetscCall(MPMCheckpointAgain(c)); /* earlier ones do not know this history */
  PetscFunctionReturn(PETSC_SUCCESS);
}
