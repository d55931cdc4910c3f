/* monitor.c - the CSV history of the columns of diagnostics.def, and the checks of energy and momentum. It is called
   after each step. */
#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include "base/checksum.h"
#include "results/output.h"

PetscErrorCode MPMMonitorSetFromOptions(MPMMonitor *mon, const MPMScene *scene, PetscReal time_end, MPMOptions o,
                                        PetscBool damped, PetscBool *follow)
{
  PetscBool moving = PETSC_FALSE, pushes = scene->meets, rigid = PETSC_FALSE, flows = PETSC_FALSE;

  PetscFunctionBeginUser;
  mon->every = time_end / 100;
  mon->last = mon->looked = -1;
  PetscCall(MPMOptionsReal(o, "history_every", NULL, &mon->every, NULL));
  PetscCall(MPMOptionsBool(o, "history_exact", NULL, &mon->exact));
  if (mon->exact && !(mon->every > 0))
    MPMOptionsFail(o, "-history_exact does not apply: -history_every 0 writes a line for every step");
  PetscCall(MPMOptionsBool(o, "history_energy", NULL, follow));
  PetscCall(MPMOptionsReal(o, "check_energy", NULL, &mon->check_energy, NULL));
  PetscCall(MPMOptionsReal(o, "check_momentum", NULL, &mon->check_momentum, NULL));
  for (PetscInt k = 0; k < scene->nbodies; k++)
    if (scene->bodies[k].source.on) flows = PETSC_TRUE;
  for (PetscInt k = scene->nbodies; k < scene->nbodies + scene->nshapes; k++)
    if (scene->bodies[k].rigid != MPM_RIGID_NONE) rigid = PETSC_TRUE;
  for (PetscInt k = 0; k < 6; k++) {
    if (MPMWallHas(scene->walls.given[k / 2][k % 2].type, MPM_WALL_MOVES)) moving = PETSC_TRUE;
    if (MPMWallHas(scene->walls.given[k / 2][k % 2].type, MPM_WALL_PUSHES)) pushes = PETSC_TRUE;
  }
  if (mon->check_energy > 0 && (scene->body_force || moving) && !*follow)
    MPMOptionsFail(o, "-check_energy does not apply: the work of %s is followed with -history_energy only",
                   moving ? "moving walls" : "body forces");
  if (mon->check_energy > 0 && damped && !*follow)
    MPMOptionsFail(o, "-check_energy does not apply: what -damping_* takes is followed with -history_energy only");
  if (mon->check_energy > 0 && rigid && !*follow)
    MPMOptionsFail(
        o, "-check_energy does not apply: what rigid bodies give and take is followed with -history_energy only");
  if (mon->check_energy > 0 && flows)
    MPMOptionsFail(
        o, "-check_energy does not apply: the work of -sources that push matter into other matter is not followed");
  if (mon->check_momentum > 0 && rigid)
    MPMOptionsFail(o, "-check_momentum does not apply: the impulse of rigid bodies is not followed");
  if (mon->check_energy > 0 && pushes && !*follow)
    MPMOptionsFail(
        o,
        "-check_energy does not apply: what walls and contact take from matter that strikes is followed with -history_energy only");
  if (mon->check_momentum > 0 && damped) MPMOptionsFail(o, "-check_momentum does not apply: -damping_* takes momentum");
  if (mon->check_momentum > 0 && (scene->forced || moving))
    MPMOptionsFail(o, "-check_momentum does not apply: the impulse of %s is not followed",
                   moving ? "moving walls" : "body forces and loads");
  PetscFunctionReturn(PETSC_SUCCESS);
}

MPMShown MPMMonitorShown(const MPMMonitor *mon, const MPMCore *core, const MPMScene *scene)
{
  return (MPMShown){core, scene, &mon->start, &mon->now, NULL};
}

/* Returns the head of the history, the names of its columns; the caller frees it. */
static PetscErrorCode Head(const MPMMonitor *mon, const MPMCore *core, char **text)
{
  const char *comma = "";
  size_t      n     = 0;
  FILE       *f     = open_memstream(text, &n);

  PetscFunctionBeginUser;
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the head of the history");
  for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS; k++) {
    PetscInt       first;
    const PetscInt nc = MPMDiagnosticColumns(k, core, &first);

    for (PetscInt c = first; c < first + nc; c++, comma = ",") {
      fprintf(f, "%s%s", comma, MPMDiagnostics[k].name);
      if (MPMDiagnostics[k].nc > 1) fprintf(f, "_%c", "xyz"[c]);
    }
  }
  for (PetscInt k = 0; k < mon->measures.n; k++) fprintf(f, ",%s", mon->measures.column[k].name);
  fprintf(f, "%s\n", mon->more ? mon->more : "");
  (void)fclose(f);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begins the history with its head, in a new file: a link to another file is not followed. Only the first process calls
   it. */
static PetscErrorCode Begin(MPMMonitor *mon, const MPMCore *core, const char path[])
{
  char *head;

  PetscFunctionBeginUser;
  (void)unlink(path);
  mon->file = fopen(path, "wx");
  if (!mon->file) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Head(mon, core, &head));
  fprintf(mon->file, "%s", head);
  free(head);
  PetscFunctionReturn(PETSC_SUCCESS);
}

uint64_t MPMMonitorSum(const MPMMonitor *mon, const MPMScene *scene, long length)
{
  char     path[2 * MPM_TEXT_LEN];
  uint64_t sum = 0;
  int      file;

  (void)snprintf(path, sizeof path, "%s/%s.csv", mon->dir, scene->name);
  file = open(path, O_RDONLY);
  if (file < 0) return 0;
  if (lseek(file, 0, SEEK_END) < length || MPMChecksumFile(file, 0, (size_t)length, &sum)) sum = 0;
  (void)close(file);
  return sum;
}

PetscErrorCode MPMMonitorResume(MPMMonitor *mon, MPMCore *core, const MPMScene *scene, PetscBool own, long length)
{
  char        path[2 * MPM_TEXT_LEN], fault[MPM_TEXT_LEN] = "";
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  if (mon->off) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  (void)snprintf(path, sizeof path, "%s/%s.csv", mon->dir, scene->name);
  if (!own)
    PetscCall(MPMWarn(
        &core->print,
        "%s is not there, or is not that of the run up to the checkpoint: the history begins with this restart", path));
  else if (!rank) {
    char *head;
    int   number = truncate(path, length) ? errno : 0;

    mon->length = length;
    PetscCall(Head(mon, core, &head));
    if (!number) number = MPMHistoryJoin(path, head, &mon->more, &mon->nmore, &mon->length, &mon->joined);
    if (!number && !(mon->file = fopen(path, "a"))) number = errno;
    if (number) (void)snprintf(fault, sizeof fault, "cannot write %.1500s: %s", path, strerror(number));
    free(head);
  }
  PetscCallMPI(MPI_Bcast(&mon->joined, 1, MPM_MPI_BOOL, 0, core->exchange.data));
  PetscCall(MPMOutputFail(core, fault, &mon->failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns 0 if all that was written is in the file, and the file in its folder; else errno. */
static int Fault(FILE *file)
{
  struct stat s;

  errno = 0;
  if (fflush(file) || ferror(file)) return errno ? errno : EIO;
  if (fstat(fileno(file), &s)) return errno;
  return s.st_nlink ? 0 : ENOENT;
}

/* Writes a line of the history; it is in the file when this returns. A line that does not fit is cut off again, and the
   fault is left in core->stop. Collective on exchange.data. */
static PetscErrorCode WriteLine(MPMMonitor *mon, MPMCore *core, const MPMShown *shown)
{
  char        path[2 * MPM_TEXT_LEN], fault[MPM_TEXT_LEN] = "";
  PetscMPIInt rank;
  const char *comma = "";

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  if (!rank) {
    int number;

    (void)snprintf(path, sizeof path, "%s/%s.csv", mon->dir, shown->scene->name);
    if (!mon->file) PetscCall(Begin(mon, core, path));
    number = mon->file ? 0 : errno;
    for (PetscInt k = 0; !number && k < MPM_NUM_DIAGNOSTICS; k++) {
      const MPMDiagnostic *row = &MPMDiagnostics[k];
      PetscInt             first;
      const PetscInt       n = MPMDiagnosticColumns(k, core, &first);

      for (PetscInt c = first; c < first + n; c++, comma = ",")
        fprintf(mon->file, row->whole ? "%s%.0f" : "%s%.17g", comma, (double)MPMDiagnosticValue(shown, k, c));
    }
    for (PetscInt k = 0; !number && k < mon->measures.n; k++)
      fprintf(mon->file, mon->measures.column[k].whole ? ",%.0f" : ",%.17g", (double)mon->measures.value[k]);
    for (PetscInt k = 0; !number && k < mon->nmore; k++) fprintf(mon->file, ",nan");
    if (!number) {
      fprintf(mon->file, "\n");
      number = Fault(mon->file);
      if (!number)
        mon->length = ftell(mon->file);
      else if (ftruncate(fileno(mon->file), mon->length))
        number = errno;
    }
    if (number) (void)snprintf(fault, sizeof fault, "cannot write %.1500s: %s", path, strerror(number));
  }
  PetscCall(MPMOutputFail(core, fault, &mon->failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the totals `now`. If a quantity of a particle is not finite, core->stop says so, and the totals stay as they
   were. Collective on the exchange. */
static PetscErrorCode Totals(MPMMonitor *mon, MPMCore *core, const MPMScene *scene)
{
  MPMTotals now;

  PetscFunctionBeginUser;
  PetscCall(MPMTotalsCompute(scene, core, &now));
  if (now.wrong < 0) {
    mon->now = now;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  (void)snprintf(core->stop, sizeof core->stop, "%s of particle %" PetscInt64_FMT " of %s is not finite",
                 MPMDiagnostics[now.wrong_row].name, now.wrong, scene->bodies[MPMBodyOf(scene, now.wrong, 0)].name);
  core->status.bad = MPM_NOT_FINITE;
  core->status.id  = now.wrong;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the change of energy that nothing explains, J. With the terms of -history_energy it is that by the integration
   with the lag, which grows where steps are unstable; energy that the mapping between particles and nodes gives is an error too. */
static PetscReal Unexplained(const MPMCore *core, const MPMShown *shown)
{
  if (!core->energy.on) return MPMShownResidual(shown);
  return MPMDiagnosticValue(shown, MPM_SHOWS_energy_integration, 0) +
         MPMDiagnosticValue(shown, MPM_SHOWS_energy_lag, 0) +
         PetscMax(0, MPMDiagnosticValue(shown, MPM_SHOWS_energy_transfer, 0));
}

/* Checks energy and momentum (-check_energy, -check_momentum); if a bound is exceeded, core->stop says so. */
static void Check(MPMMonitor *mon, MPMCore *core, const MPMShown *shown)
{
  const MPMTotals *now = &mon->now, *start = &mon->start;
  const PetscReal  residual = Unexplained(core, shown);
  PetscReal        change2  = 0, base;

  mon->energy_max = PetscMax(mon->energy_max, MPMDiagnosticValue(shown, MPM_SHOWS_total_energy, 0));
  mon->speed_max  = PetscMax(mon->speed_max, now->sum[MPM_SHOWS_momentum_size][0]);
  base            = mon->energy_max + PetscAbsReal(MPMShownWork(shown));
  if (mon->check_energy > 0 && !(PetscAbsReal(residual) <= mon->check_energy * base))
    (void)snprintf(core->stop, sizeof core->stop,
                   "energy changed by %g J, %.3g of the largest %g J; -check_energy allows %g", (double)residual,
                   (double)(residual / base), (double)base, (double)mon->check_energy);
  for (PetscInt d = core->grid.round ? 1 : 0; d < core->grid.dim; d++) { /* along r momentum is not kept */
    const PetscReal mass_time = now->sum[MPM_SHOWS_mass][0] * core->kicked + now->sum[MPM_SHOWS_lost_mass_time][0];
    const PetscReal change    = MPMShownEver(now, MPM_SHOWS_momentum, d) - start->sum[MPM_SHOWS_momentum][d] -
                             mass_time * core->params.gravity[d] - core->changes.impulse[d];

    change2 += change * change;
  }
  if (mon->check_momentum > 0 && !(PetscSqrtReal(change2) <= mon->check_momentum * mon->speed_max))
    (void)snprintf(core->stop, sizeof core->stop,
                   "momentum changed by %g kg m/s, %.3g of sum m|v| = %g; -check_momentum allows %g",
                   (double)PetscSqrtReal(change2), (double)(PetscSqrtReal(change2) / mon->speed_max),
                   (double)mon->speed_max, (double)mon->check_momentum);
}

PetscErrorCode MPMMonitorLook(MPMMonitor *mon, MPMCore *core, const MPMScene *scene)
{
  const PetscBool check = mon->check_energy > 0 || mon->check_momentum > 0;
  const MPMShown  shown = MPMMonitorShown(mon, core, scene);

  PetscFunctionBeginUser;
  if (mon->off || !(check || core->t >= mon->next)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Totals(mon, core, scene));
  if (!MPMStatusIsBad(&core->status)) Check(mon, core, &shown);
  if (core->status.bad != MPM_GONE) mon->looked = core->step; /* else settling the step removes particles */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the totals, checks them and writes a line of the history, if one is due or `force` is set. Every 100 steps
   the checks are made even if no line is due. Collective on the exchange. */
PetscErrorCode MPMMonitorStep(MPMMonitor *mon, MPMCore *core, const MPMScene *scene, PetscBool force)
{
  const PetscBool due   = force || core->t >= mon->next;
  const PetscBool check = (mon->check_energy > 0 || mon->check_momentum > 0) && core->step % 100 == 0;
  const MPMShown  shown = MPMMonitorShown(mon, core, scene);

  PetscFunctionBeginUser;
  if (mon->off || (!due && !check) || mon->last == core->step) PetscFunctionReturn(PETSC_SUCCESS);
  if (mon->looked != core->step) {
    PetscCall(Totals(mon, core, scene));
    if (MPMStatusIsBad(&core->status)) PetscFunctionReturn(PETSC_SUCCESS);
    if (core->step == 0) mon->start = mon->now;
    Check(mon, core, &shown);
    mon->looked = core->step;
    if (core->stop[0]) mon->exceeded = PETSC_TRUE;
  }
  if (!due) PetscFunctionReturn(PETSC_SUCCESS); /* a line of the end comes after the checkpoint of it */
  PetscCall(MPMMeasuresCompute(&mon->measures, core, scene));
  if (!mon->failed) PetscCall(WriteLine(mon, core, &shown));
  MPMMeasuresLine(&mon->measures, core);
  mon->last = core->step;
  mon->next = MPMNextTime(core->t, mon->every);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMMonitorStopped(MPMMonitor *mon, MPMCore *core, const MPMScene *scene)
{
  const MPMShown shown = MPMMonitorShown(mon, core, scene);
  MPMTotals      now;

  PetscFunctionBeginUser;
  if (mon->off) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMTotalsCompute(scene, core, &now));
  if (now.wrong >= 0) PetscFunctionReturn(PETSC_SUCCESS);
  mon->now        = now;
  mon->energy_max = PetscMax(mon->energy_max, MPMDiagnosticValue(&shown, MPM_SHOWS_total_energy, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the first multiple of `every` after t (up to rounding), or t itself if `every` is 0. */
PetscReal MPMNextTime(PetscReal t, PetscReal every)
{
  return every > 0 ? (PetscFloorReal(t / every * (1 + 1e-12)) + 1) * every * (1 - 1e-12) : t;
}

PetscReal MPMNextExact(PetscReal t, PetscReal every)
{
  return (PetscFloorReal(t / every * (1 + 1e-12)) + 1) * every;
}

PetscErrorCode MPMMonitorDestroy(MPMMonitor *mon)
{
  PetscFunctionBeginUser;
  PetscCall(MPMMeasuresDestroy(&mon->measures));
  free(mon->more);
  if (mon->file) (void)fclose(mon->file);
  mon->file = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}
