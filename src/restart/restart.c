/* restart.c - a run that goes on from a checkpoint (-restart_file): which file, whether its options are those of this run,
   its particles and everything else. */
#include <strings.h>
#include "parallel/exchange.h"
#include "restart/restart.h"
#include "step/step.h"

/* The options that may differ from those of the checkpoint, by their first letters: they say how long, how, where and
   with what output the run goes on, but not what is simulated; and damping, since a scene may settle before it starts. */
static const char *const may_differ[] = {
    "time_",   "dt_",         "check_",         "output_dir",    "output_name", "output_every", "history_every",
    "report_", "checkpoint_", "restart_",       "parallel_",     "pool_",       "model_",       "scene_title",
    "dry_run", "rerun",       "output_replace", "output_format", "damping_"};

/* Further ones of a run that starts from an implicit one, as far as the nodes of the total frame stay. */
static const char *const may_begin[] = {"method_", "gravity_ramp", "history_rest"};

static PetscBool IsOf(const char *const starts[], size_t n, const char name[])
{
  for (size_t k = 0; k < n; k++)
    if (!strncasecmp(name, starts[k], strlen(starts[k]))) return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscBool MayDiffer(const MPMCheckpoint *c, const char name[])
{
  const size_t n = strlen(name);

  if (IsOf(may_differ, sizeof may_differ / sizeof may_differ[0], name)) return PETSC_TRUE;
  if (!c->starts) return PETSC_FALSE;
  if (!strncasecmp(name, "load_", 5)) return (PetscBool)(n > 6 && !strcasecmp(name + n - 6, "_value"));
  if (c->core->grid.total && (!strcasecmp(name, "method_basis") || !strcasecmp(name, "method_wall_basis")))
    return PETSC_FALSE;
  return IsOf(may_begin, sizeof may_begin / sizeof may_begin[0], name);
}

/* Finds whether the run starts from the state that an implicit one ended in, explicitly or with inertia, and does not go on with
   it. */
static PetscErrorCode FindStart(MPMCheckpoint *c, MPMOptions o)
{
  const char *is = c->core->implicit ? "implicit" : "explicit";
  char       *here, was[MPM_TEXT_LEN], now[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsText(&here));
  (void)MPMOptionsFindIn(here, "-method_time", now);
  if (MPMOptionsFindIn(c->options, "-method_time", was) && strcasecmp(was, "explicit") && strcasecmp(was, now))
    c->starts = (PetscBool)(!strcmp(is, "explicit") || !strcasecmp(was, "static"));
  PetscCall(PetscFree(here));
  if (c->starts && c->own)
    MPMOptionsFail(o, "-restart_file %.500s: a run that starts from -method_time %.50s has another history; give it another "
                      "-output_name or -output_dir",
                   c->from, was);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether two values say the same: the same numbers, or the same words. */
static PetscBool SameValue(const char a[], const char b[])
{
  for (;;) {
    char        *after_a, *after_b;
    const double x = strtod(a, &after_a), y = strtod(b, &after_b);

    if (after_a == a || after_b == b || x != y) return !strcasecmp(a, b) ? PETSC_TRUE : PETSC_FALSE;
    if (!*after_a && !*after_b) return PETSC_TRUE;
    if (*after_a != ',' || *after_b != ',') return !strcasecmp(a, b) ? PETSC_TRUE : PETSC_FALSE;
    a = after_a + 1;
    b = after_b + 1;
  }
}

/* Compares one option of the checkpoint (was) and of this run (is), NULL if it was not given: then its default counts, if
   that is a value. */
static void Compare(MPMCheckpoint *c, MPMOptions o, const char name[], const char was[], const char is[])
{
  const MPMOptionRow *row  = MPMOptionsRow(o, name + 1);
  char               *text = c->differ;
  size_t              n    = strlen(text);

  if (!row || !strcasecmp(name, "-restart_file") || !strcasecmp(name, "-rerun")) return;
  if (SameValue(was ? was : row->fallback, is ? is : row->fallback)) return;
  if (!MayDiffer(c, name + 1))
    MPMOptionsFail(
        o,
        "-restart_file %.500s: %.100s %s%.200s in the checkpoint and %s%.200s in this run; it may not change "
        "(options of time, dt, damping, intervals of output, checkpoints and processes may)",
        c->from, name,
        !was     ? "is not given"
        : was[0] ? "is "
                 : "is given",
        was ? was : "",
        !is     ? "is not given"
        : is[0] ? "is "
                : "is given",
        is ? is : "");
  else
    (void)snprintf(text + n, MPM_TEXT_LEN - n, "%s%s %s, was %s", n ? "; " : "", name,
                   is ? is[0] ? is : "given" : "not given", was ? was[0] ? was : "given" : "not given");
}

/* Compares options. Damping is a column of the history by terms, which cannot come or go within a file. */
static PetscErrorCode CompareOptions(MPMCheckpoint *c, MPMOptions o)
{
  char       *here;
  const char *at;
  PetscBool   damped = PETSC_FALSE;
  char        name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN], other[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsText(&here));
  for (at = c->options; MPMOptionsNext(&at, name, value);)
    Compare(c, o, name, value, MPMOptionsFindIn(here, name, other) ? other : NULL);
  for (at = here; MPMOptionsNext(&at, name, value);)
    if (!MPMOptionsFindIn(c->options, name, other)) Compare(c, o, name, NULL, value);
  PetscCall(PetscFree(here));
  for (at = c->options; MPMOptionsNext(&at, name, value);)
    if (!strncasecmp(name, "-damping_", 9) && !SameValue(value, "false")) damped = PETSC_TRUE;
  if (c->core->energy.on && damped != MPMDampingIsOn(c->core))
    MPMOptionsFail(o, "-damping_*: with -history_energy damping cannot begin or end at a restart, since its term is a "
                      "column of the history");
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
                     MPMMonitorSum(c->monitor, c->scene, (long)c->history_length) == (uint64_t)c->history_sum
                 ? PETSC_TRUE
                 : PETSC_FALSE;
  PetscCallMPI(MPI_Bcast(&c->own, 1, MPM_MPI_BOOL, 0, c->core->comm));
  c->output->resumed = c->own;
  if (!c->own && c->output->keep) PetscCall(KeepOld(c, o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRestartSetFromOptions(MPMCheckpoint *c, PetscReal end, MPMOptions o)
{
  char         given[MPM_TEXT_LEN] = "", fault[MPM_TEXT_LEN];
  MPMVariables header;
  PetscBool    set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "restart_file", NULL, given, &set));
  PetscCall(MPMOptionsString(o, "rerun", NULL, fault, NULL)); /* it has been read (MPMRerun) */
  if (!set && c->output->keep && !c->off && !MPMOptionsError(o)) PetscCall(KeepOld(c, o));
  if (!set || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
#if !defined(PETSC_HAVE_HDF5)
  MPMOptionsFail(o, "-restart_file needs a PETSc with HDF5, and this one has none");
#endif
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Choose(c, o, given));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMCheckpointOptions(c->from, &c->options, c->git));
  MPMCheckpointHeader(c, &header);
  PetscCall(MPMCheckpointRead(c->from, c->core->comm, &header, fault));
  if (fault[0]) MPMOptionsFail(o, "-restart_file: %s", fault);
  PetscCall(FindHistory(c, o));
  if (!MPMOptionsError(o)) PetscCall(FindStart(c, o));
  if (!MPMOptionsError(o)) PetscCall(CompareOptions(c, o));
  if (c->shapes != c->scene->shapes)
    MPMOptionsFail(
        o,
        "-restart_file %.500s: what -body_<b>_file names has changed since the run that wrote it; put the old "
        "files back, or start anew",
        c->from);
  if (!MPMOptionsError(o) && c->t > end * (1 + 1e-9))
    MPMOptionsFail(o, "-time_end %g lies before the time of -restart_file %s, %g s", (double)end, c->from,
                   (double)c->t);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRestartCheckFields(MPMCheckpoint *c)
{
  MPMParticles *particles = &c->core->particles;
  char          has[MPM_TEXT_LEN], needs[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMCheckpointFields(c->from, c->core->comm, has));
  if (c->volumes != MPMCheckpointVolumes(c->scene))
    (void)snprintf(c->core->stop, sizeof c->core->stop,
                   "-restart_file %.1000s: particles had other volumes there, since this method cuts bodies otherwise; give "
                   "-method_rim cut, and -body_<b>_ppc as there",
                   c->from);
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && MPMCheckpointHasField(f))
      (void)snprintf(needs + strlen(needs), sizeof needs - strlen(needs), "%s%s", needs[0] ? " " : "",
                     MPMFields[f].name);
  for (PetscInt f = 0; f < MPM_NUM_FIELDS && c->starts; f++) { /* others may be there; there is no affine velocity at rest */
    c->lacks[f] = (PetscBool)(f == MPM_FIELD_INDEX_C);
    if (particles->present[f] && MPMCheckpointHasField(f) && !c->lacks[f] && !MPMListHas(has, MPMFields[f].name))
      (void)snprintf(c->core->stop, sizeof c->core->stop,
                     "-restart_file %.1000s has no field %s of particles, which this run needs", c->from, MPMFields[f].name);
  }
  if (!c->starts && strcmp(has, needs))
    (void)snprintf(
        c->core->stop, sizeof c->core->stop,
        "-restart_file %.1000s has the fields %.300s of particles, and this run needs %.300s; another version of "
        "pebble "
        "wrote it",
        c->from, has, needs);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Particles ------------------------------------------------------------------------------------------------------ */

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
    if (!p->present[fields[k]]) continue;
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
  MPMParticles *p = &c->core->particles;
  PetscMPIInt   rank, size;
  PetscInt64    first;
  PetscInt      n;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(c->core->exchange.data, &rank));
  PetscCallMPI(MPI_Comm_size(c->core->exchange.data, &size));
  Share(c, rank, size, &first, &n);
  p->total = c->total;
  PetscCall(MPMParticlesSetSize(p, n));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    void *rows;

    if (!p->present[f] || !MPMCheckpointHasField(f)) continue;
    PetscCall(MPMParticlesGetField(p, f, &rows));
    if (c->lacks[f])
      PetscCall(PetscMemzero(rows, (size_t)n * (size_t)p->bytes[f]));
    else
      PetscCall(MPMCheckpointRows(c->from, p, f, first, n, rows));
    PetscCall(MPMParticlesRestoreField(p, f));
  }
  PetscCall(MPMExchangeDistribute(c->core));
  if (c->core->grid.total) PetscCall(MPMCheckpointNodes(c->from, &c->core->grid, &c->core->exchange.patch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- All else ------------------------------------------------------------------------------------------------------- */

PetscErrorCode MPMRestartState(MPMCheckpoint *c, MPMWalls *walls)
{
  MPMCore        *core  = c->core;
  MPMOutput      *out   = c->output;
  MPMMonitor     *mon   = c->monitor;
  const PetscReal every = c->every, history = mon->every, output = out->every; /* of the options of this run */
  const PetscInt  room = (c->snapshots + 63) / 64 * 64; /* MPMOutputStep makes more in steps of 64 */
  MPMVariables    kept;
  char            fault[MPM_TEXT_LEN], totals[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(PetscMax(1, room), &out->steps));
  PetscCall(PetscMalloc1(PetscMax(1, room), &out->times));
  PetscCall(PetscMalloc1(PetscMax(1, room), &out->digests));
  out->count = c->snapshots;
  MPMCheckpointTotals(totals);
  c->list(c->run, &kept);
  for (PetscInt k = 0; k < kept.n && c->starts; k++) /* what only the other method has */
    if (!kept.row[k].n || !strncmp(kept.row[k].name, "watch_dt", 8)) kept.row[k].at = NULL;
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
  if (!out->enabled || c->starts) out->count = 0;
  PetscCall(MPMTotalsCompute(c->scene, core, &mon->now));
  if (!c->starts) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < MPM_NUM_ENERGIES; k++) MPMSumZero(&core->energy.sum[k]); /* energies are counted from here */
  PetscCall(MPMTotalsCompute(c->scene, core, &mon->now));
  mon->start   = mon->now;
  core->half   = 0;
  core->kicked = core->t;
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
  if (c->scene->dry_run) PetscFunctionReturn(PETSC_SUCCESS);
  if (!c->starts) PetscCall(MPMMonitorResume(c->monitor, c->core, c->scene, c->own, (long)c->history_length));
  PetscCall(MPMOutputResume(c->output, c->core, c->scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}
