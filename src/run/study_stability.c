/* study_stability.c - the largest stable steps of methods: -study_type stability.

   A probe is an elastic body in an empty periodic grid, in units in which cell size, density and wave speed are 1, with
   velocities disturbed by 1e-6, so that the speed of waves is constant. A run has a fixed C = c dt/h. The strain energy
   of a stable run stays below the energy of the disturbance, or nearly so; a run in which it exceeds LIMIT times that,
   or which stops, is unstable. Growth need not be monotone in C: C rises from the smallest step, and the first that is
   unstable ends the search. */
#include <errno.h>
#include <stdarg.h>
#include <unistd.h>
#include "run/study.h"

#define LIMIT       10.  /* largest strain energy of a stable run, in energies of the disturbance */
#define DISTURBANCE 1e-6 /* of the velocity, in wave speeds */
#define LARGEST     2.6  /* the largest C that is tried */
#define MARGIN      4    /* empty cells on each side of a body */

/* Drift of a body that crosses cells, in wave speeds. Where the time from one crossing to the next, h/v, is half the
   period of a mode of the body, the crossings can feed the mode. A body of 32 cells has modes next to all of these. */
static const PetscReal speeds[] = {0.08, 0.13, 0.1875, 0.5};

/* A probe: a box of `cells` on each axis, which drifts with the speeds first .. last-1 or, at rest, is at the places
   first .. last-1 in its cells. A run makes -study_steps / share steps. */
typedef struct {
  const char *name;
  PetscInt    dim, cells, share, first, last;
  PetscBool   crossing;
} Probe;
enum { REST, CROSSING, BLOCK, PROBES };

/* What a probe found: the largest C up to which all are stable, the first that is not, and the drift of that run in wave
   speeds. unstable: 0 if LARGEST is stable. */
typedef struct {
  PetscReal stable, unstable, speed;
} Found;

/* A method: words of options, and numbers, which are as in the scene if its transfer is the same, else as the options
   give them; < 0: not of this transfer. */
enum { FLIP, RATE, STRAIN, ORDER, NUMBERS };
static const char *const numbers[NUMBERS] = {"flip", "damping_rate", "affine_strain", "order"};
static const PetscReal   usual[NUMBERS]   = {1, 0, 0, 2};
typedef struct {
  const char *basis, *update;
  char        transfer[MPM_NAME_LEN];
  PetscReal   number[NUMBERS];
} Method;

/* --- A run -------------------------------------------------------------------------------------------------------- */

static void GetProbes(PetscInt dim, Probe probe[PROBES])
{
  const PetscBool flat = dim < 3 ? PETSC_TRUE : PETSC_FALSE;

  probe[REST]     = (Probe){"at rest", 1, 16, 4, 0, 2, PETSC_FALSE};
  probe[CROSSING] = (Probe){"crossing", 1, 32, 1, 0, (PetscInt)(sizeof speeds / sizeof speeds[0]), PETSC_TRUE};
  probe[BLOCK]    = (Probe){"block", flat ? 2 : 3, flat ? 12 : 6, flat ? 8 : 40, 1, 3, PETSC_TRUE};
}

static PetscErrorCode Set(const char name[], const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
static PetscErrorCode Set(const char name[], const char format[], ...)
{
  char    text[MPM_TEXT_LEN];
  va_list args;

  PetscFunctionBeginUser;
  va_start(args, format);
  (void)vsnprintf(text, sizeof text, format, args);
  va_end(args);
  PetscCall(PetscOptionsSetValue(NULL, name, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets an option to the same number for each axis. */
static PetscErrorCode SetAxes(const char name[], PetscInt dim, PetscReal x)
{
  PetscFunctionBeginUser;
  PetscCall(dim == 1   ? Set(name, "%.17g", (double)x)
            : dim == 2 ? Set(name, "%.17g,%.17g", (double)x, (double)x)
                       : Set(name, "%.17g,%.17g,%.17g", (double)x, (double)x, (double)x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetMethod(const Method *m)
{
  const PetscBool stretch = !strcmp(m->basis, "gimp_stretch") ? PETSC_TRUE : PETSC_FALSE;
  char            option[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(Set("-method_basis", "%s", stretch ? "gimp" : m->basis));
  if (stretch) PetscCall(Set("-method_gimp_update", "stretch"));
  PetscCall(Set("-method_update", "%s", m->update));
  PetscCall(Set("-method_transfer", "%s", m->transfer));
  for (PetscInt k = 0; k < NUMBERS; k++) {
    (void)snprintf(option, sizeof option, "-method_%s", numbers[k]);
    if (m->number[k] >= 0) PetscCall(Set(option, "%.17g", (double)m->number[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the scene of a probe. variant: a speed, or at rest a place in a cell. */
static PetscErrorCode SetProbe(MPM base, const Probe *probe, PetscInt variant)
{
  static const char *const grid[]      = {"-grid_lower", "-grid_upper", "-grid_cells"};
  static const PetscReal   direction[] = {1, 0.7, 0.45};
  const PetscInt           dim         = probe->dim;
  const PetscReal          nu = dim > 1 ? 0.3 : 0, E = (1 + nu) * (1 - 2 * nu) / (1 - nu); /* the speed of waves is 1 */
  const PetscReal          v = probe->crossing ? speeds[variant] : 0, shift = probe->crossing ? 0 : 0.3 * variant;
  char                     velocity[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(Set("-dim", "%" PetscInt_FMT, dim));
  PetscCall(SetAxes(grid[0], dim, 0));
  PetscCall(SetAxes(grid[1], dim, (PetscReal)(probe->cells + 2 * MARGIN)));
  PetscCall(SetAxes(grid[2], dim, (PetscReal)(probe->cells + 2 * MARGIN)));
  for (PetscInt face = 0; face < 2 * dim; face++) {
    char name[2 * MPM_NAME_LEN];

    (void)snprintf(name, sizeof name, "-bc_%.63s_type", MPMFaceNames[face]);
    PetscCall(Set(name, "periodic"));
  }
  PetscCall(Set("-materials", "m"));
  PetscCall(Set("-material_m_model", "elastic"));
  PetscCall(Set("-material_m_rho", "1"));
  PetscCall(Set("-material_m_E", "%.17g", (double)E));
  PetscCall(Set("-material_m_nu", "%.17g", (double)nu));
  PetscCall(Set("-bodies", "b"));
  PetscCall(Set("-body_b_shape", "box"));
  PetscCall(Set("-body_b_material", "m"));
  PetscCall(SetAxes("-body_b_lower", dim, MARGIN + shift));
  PetscCall(SetAxes("-body_b_upper", dim, MARGIN + shift + (PetscReal)probe->cells));
  PetscCall(SetAxes("-body_b_offset", dim, shift));
  PetscCall(SetAxes("-body_b_ppc", dim, (PetscReal)base->scene.bodies[0].ppc[0]));
  for (PetscInt d = 0; d < dim; d++) /* the longest wave of the body, and waves of about two particles */
    (void)snprintf(velocity + strlen(velocity), sizeof velocity - strlen(velocity),
                   "%s%.17g+%g*(sin(pi*(%c-%g)/%g)+cos(6.62*x%s%s+%g))", d ? "," : "", (double)(v * direction[d]),
                   DISTURBANCE, "xyz"[d], (double)(MARGIN + shift + (PetscReal)probe->cells / 2),
                   (double)probe -> cells, dim > 1 ? "+4.34*y" : "", dim > 2 ? "+3.1*z" : "", (double)d);
  PetscCall(Set("-body_b_velocity", "%s", velocity));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a run of a probe in the present options, which have the method. *grown: the largest strain energy in energies of
   the disturbance, infinite if the run stopped. C 0: its options are only read. Collective on base->core.comm. */
static PetscErrorCode MakeRun(MPM base, const Probe *probe, PetscInt variant, PetscReal C, MPMStudyResult *r,
                              PetscReal *grown)
{
  const PetscInt steps = PetscMax(1, base->study.steps / probe->share);

  PetscFunctionBeginUser;
  *grown = PETSC_INFINITY;
  PetscCall(SetProbe(base, probe, variant));
  PetscCall(PetscOptionsClearValue(NULL, "-dt_size"));
  if (C > 0) PetscCall(Set("-dt_size", "%.17g", (double)C));
  PetscCall(Set("-time_end", "%.17g", (double)(C * steps)));
  PetscCall(Set("-history_every", "%.17g", (double)(C * steps / 100)));
  PetscCall(MPMStudyMake(base, C > 0 ? 0 : MPM_STUDY_DRY, r, NULL));
  if (C > 0 && !r->stop[0] && !r->refused[0]) {
    const PetscReal *strain = r->column[MPM_SHOWS_strain_energy][0], m = r->column[MPM_SHOWS_mass][0][MPM_SEEN_START];

    if (PetscAbsReal(strain[MPM_SEEN_END]) <= PETSC_MAX_REAL)
      *grown = strain[MPM_SEEN_MAX] / (0.5 * m * (PetscReal)probe->dim * PetscSqr(DISTURBANCE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- A method ----------------------------------------------------------------------------------------------------- */

/* Tries one C with all variants of a probe, and first with that which was unstable last. Collective. */
static PetscErrorCode IsStable(MPM base, const Probe *probe, PetscReal C, PetscInt *variant, PetscBool *stable,
                               PetscBool *interrupted)
{
  const PetscInt n = probe->last - probe->first, begin = *variant;

  PetscFunctionBeginUser;
  *stable = PETSC_TRUE;
  for (PetscInt k = 0; k < n && *stable && !*interrupted; k++) {
    MPMStudyResult r;
    PetscReal      grown = 0;
    const PetscInt v     = probe->first + (begin - probe->first + k) % n;

    PetscCall(MakeRun(base, probe, v, C, &r, &grown));
    *interrupted = r.interrupted;
    *stable      = grown <= LIMIT ? PETSC_TRUE : PETSC_FALSE;
    if (!*stable) *variant = v;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the largest C: by steps of 0.1, from 1 on of 0.2, then by half such a step. Collective. */
static PetscErrorCode Find(MPM base, const Probe *probe, Found *found, PetscBool *interrupted)
{
  PetscInt variant = probe->first;

  PetscFunctionBeginUser;
  *found = (Found){0, 0, 0};
  for (PetscInt k = 1; k <= 18 && found->unstable == 0 && !*interrupted; k++) {
    const PetscReal C = k <= 10 ? 0.1 * (PetscReal)k : 1 + 0.2 * (PetscReal)(k - 10);
    PetscBool       stable;

    PetscCall(IsStable(base, probe, C, &variant, &stable, interrupted));
    if (stable) {
      found->stable = C;
      continue;
    }
    found->unstable        = C;
    const PetscReal middle = (found->stable + C) / 2;
    PetscCall(IsStable(base, probe, middle, &variant, &stable, interrupted));
    if (stable)
      found->stable = middle;
    else
      found->unstable = middle;
    found->speed = probe->crossing ? speeds[variant] : 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The study ---------------------------------------------------------------------------------------------------- */

/* Sets transfer and numbers of a method by a word of -study_transfer, which may have the share of FLIP or the order after
   a colon. */
static PetscErrorCode SetTransfer(MPM base, const char word[], Method *m)
{
  const char        *colon        = strchr(word, ':');
  const MPMTransfer *transfer     = MPMTransfers;
  const PetscReal    own[NUMBERS] = {base->core.params.flip, base->method.rate, base->core.params.strain,
                                     (PetscReal)base->core.params.order};

  PetscFunctionBeginUser;
  (void)snprintf(m->transfer, sizeof m->transfer, "%.*s", (int)strcspn(word, ":"), word);
  while (strcmp(transfer->name, m->transfer)) transfer++;
  for (PetscInt k = 0; k < NUMBERS; k++) {
    char option[MPM_NAME_LEN];

    (void)snprintf(option, sizeof option, "-method_%s", numbers[k]);
    m->number[k] = transfer == base->method.transfer ? own[k] : usual[k];
    if (transfer != base->method.transfer) PetscCall(PetscOptionsGetReal(NULL, NULL, option, &m->number[k], NULL));
  }
  if (colon) m->number[transfer->rounds != MPM_NO_ROUNDS ? ORDER : FLIP] = strtod(colon + 1, NULL);
  if (colon) m->number[RATE] = 0;
  if (transfer->flip >= 0) m->number[FLIP] = m->number[RATE] = -1;
  if (transfer->flip >= 0 || !(transfer->parts & MPM_AFFINE)) m->number[STRAIN] = -1;
  if (transfer->rounds == MPM_NO_ROUNDS) m->number[ORDER] = -1;
  if (m->number[RATE] > 0)
    m->number[FLIP] = -1;
  else
    m->number[RATE] = -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes an option database for the probes the current one. It has those options of the scene that say where it runs and
   where its results go. */
static PetscErrorCode PushOptions(PetscOptions *options)
{
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsCreate(options));
  for (size_t r = 0; r < MPMOptionTable.n; r++) {
    const char *name = MPMOptionTable.row[r].name, *value;
    char        option[2 * MPM_NAME_LEN];
    PetscBool   given;

    if (!name || (strncmp(name, "parallel_", 9) && strncmp(name, "pool_", 5) && strcmp(name, "output_dir"))) continue;
    (void)snprintf(option, sizeof option, "-%s", name);
    PetscCall(PetscOptionsFindPair(NULL, NULL, option, &value, &given));
    if (given) PetscCall(PetscOptionsSetValue(*options, option, value));
  }
  PetscCall(PetscOptionsPush(*options));
  PetscCall(Set("-output_name", "probe"));
  PetscCall(Set("-output_format", "none"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the name of a method, with those numbers of it that are not the default. */
static void Name(const Method *m, char name[MPM_TEXT_LEN])
{
  (void)snprintf(name, MPM_TEXT_LEN, "%s %s %s", m->basis, m->update, m->transfer);
  for (PetscInt k = 0; k < NUMBERS; k++)
    if (m->number[k] >= 0 && m->number[k] != usual[k])
      (void)snprintf(name + strlen(name), MPM_TEXT_LEN - strlen(name), " %s %g", numbers[k], (double)m->number[k]);
}

/* Prints the line of a method, and writes it to the CSV file, which the first process has. r: of a run of its options.
   The margin is that of the smallest of the largest steps over the default of -dt_cfl. */
static PetscErrorCode Report(MPM base, FILE *csv, const Method *m, const Found found[], const MPMStudyResult *r,
                             PetscReal seconds)
{
  const MPMStable *table = &r->stable;
  PetscReal        least = PETSC_INFINITY;
  char             name[MPM_TEXT_LEN], text[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  Name(m, name);
  PetscCall(MPMPrint(&base->core.print, "%-34s", name));
  for (PetscInt k = 0; k < PROBES; k++) {
    least = PetscMin(least, found[k].stable);
    (void)snprintf(text, sizeof text, found[k].unstable > 0 ? "%.3g" : ">=%.3g", (double)found[k].stable);
    PetscCall(MPMPrint(&base->core.print, " %8s", text));
  }
  (void)snprintf(text, sizeof text, "%.3g, %.3g", (double)table->rest, (double)table->crossing);
  PetscCall(MPMPrint(&base->core.print, " %10s %7.3g %7.2g %8.3g\n", text, (double)r->cfl, (double)(least / r->cfl),
                     (double)seconds));
  if (!csv) PetscFunctionReturn(PETSC_SUCCESS);
  fprintf(csv, "%s,%s,%s", m->basis, m->update, m->transfer);
  for (PetscInt k = 0; k < NUMBERS; k++) fprintf(csv, m->number[k] >= 0 ? ",%.6g" : ",", (double)m->number[k]);
  fprintf(csv, ",%d", (int)base->scene.bodies[0].ppc[0]);
  for (PetscInt k = 0; k < PROBES; k++) {
    fprintf(csv, ",%.4g,", (double)found[k].stable);
    if (found[k].unstable > 0) fprintf(csv, "%.4g", (double)found[k].unstable);
    if (k != REST) fprintf(csv, found[k].unstable > 0 ? ",%.4g" : ",", (double)found[k].speed);
  }
  fprintf(csv, ",%.4g,%.4g,%.4g,%.3g,%d,%d,%.3g\n", (double)table->rest, (double)table->crossing, (double)r->cfl,
          (double)(least / r->cfl), (int)PetscMax(2, base->core.grid.dim), (int)base->study.steps, (double)seconds);
  (void)fflush(csv); /* MPMStudyStability looks for faults */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Studies one method; a combination that the program refuses gets a line that says so. *taken counts
   the others. Collective. */
static PetscErrorCode StudyMethod(MPM base, FILE *csv, const Method *m, PetscInt *taken, PetscBool *interrupted)
{
  PetscOptions   options;
  Probe          probe[PROBES];
  Found          found[PROBES];
  MPMStudyResult r;
  PetscReal      grown;
  PetscLogDouble t0, t1;
  char           name[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  Name(m, name);
  GetProbes(base->core.grid.dim, probe);
  PetscCall(PushOptions(&options));
  PetscCall(SetMethod(m));
  PetscCall(MakeRun(base, &probe[REST], 0, 0, &r, &grown));
  *taken += r.refused[0] ? 0 : 1;
  if (r.refused[0] || base->scene.dry_run)
    PetscCall(MPMPrint(&base->core.print, "%-34s %s\n", name, r.refused[0] ? r.refused : "valid"));
  else {
    PetscCall(PetscTime(&t0));
    for (PetscInt k = 0; k < PROBES; k++) PetscCall(Find(base, &probe[k], &found[k], interrupted));
    PetscCall(PetscTime(&t1));
    if (!*interrupted) PetscCall(Report(base, csv, m, found, &r, t1 - t0));
  }
  PetscCall(PetscOptionsPop());
  PetscCall(PetscOptionsDestroy(&options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintHead(MPM base)
{
  Probe probe[PROBES];

  PetscFunctionBeginUser;
  GetProbes(base->core.grid.dim, probe);
  PetscCall(MPMPrint(&base->core.print,
                     "study      stability: the largest c dt/h at which a disturbance of %g c does not grow %g-fold in "
                     "energy\n",
                     DISTURBANCE, LIMIT));
  for (PetscInt k = 0; k < PROBES; k++) {
    PetscCall(MPMPrint(&base->core.print,
                       "           %-9s %" PetscInt_FMT "-D, %" PetscInt_FMT " cells an axis, %" PetscInt_FMT " steps",
                       probe[k].name, probe[k].dim, probe[k].cells, PetscMax(1, base->study.steps / probe[k].share)));
    for (PetscInt v = probe[k].first; v < probe[k].last && probe[k].crossing; v++)
      PetscCall(MPMPrint(&base->core.print, "%s%g", v == probe[k].first ? ", drifts at " : " ", (double)speeds[v]));
    PetscCall(MPMPrint(&base->core.print, "%s\n", probe[k].crossing ? " c" : ""));
  }
  if (!base->scene.dry_run)
    PetscCall(MPMPrint(&base->core.print, "%-34s %8s %8s %8s %10s %7s %7s %8s\n", "method", probe[REST].name,
                       probe[CROSSING].name, probe[BLOCK].name, "by table", "dt_cfl", "margin", "seconds"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStudyStability(MPM base, int *status)
{
  const MPMStudy *study       = &base->study;
  PetscBool       interrupted = PETSC_FALSE, replaced;
  char            path[2 * MPM_TEXT_LEN], fault[MPM_TEXT_LEN] = "";
  PetscMPIInt     rank;
  FILE           *csv   = NULL;
  PetscInt        taken = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(base->core.comm, &rank));
  (void)snprintf(path, sizeof path, "%s/%s_stability.csv", base->output.dir, base->scene.name);
  replaced = !access(path, F_OK) ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(PrintHead(base));
  if (!rank && !base->scene.dry_run) {
    (void)unlink(path); /* a link to another file is not followed */
    csv = fopen(path, "wx");
    if (!csv) (void)snprintf(fault, sizeof fault, "cannot write %.1500s: %s", path, strerror(errno));
  }
  PetscCall(MPMStudyFault(base, fault, status));
  if (*status != MPM_EXIT_OK) PetscFunctionReturn(PETSC_SUCCESS);
  if (csv) {
    fprintf(csv, "basis,update,transfer,flip,damping_rate,affine_strain,order,ppc,rest,rest_unstable,crossing,"
                 "crossing_unstable,crossing_speed,block,block_unstable,block_speed,table_rest,table_crossing,dt_cfl,"
                 "margin,dim,steps,seconds\n");
  }
  for (PetscInt i = 0; i < study->bases.n; i++)
    for (PetscInt j = 0; j < study->updates.n; j++)
      for (PetscInt k = 0; k < study->transfers.n && !interrupted; k++) {
        Method m = {study->bases.word[i], study->updates.word[j], "", {0}};

        PetscCall(SetTransfer(base, study->transfers.word[k], &m));
        PetscCall(StudyMethod(base, csv, &m, &taken, &interrupted));
        if (csv && ferror(csv)) (void)snprintf(fault, sizeof fault, "cannot write %.1500s: %s", path, strerror(errno));
        PetscCall(MPMStudyFault(base, fault, status));
        if (*status != MPM_EXIT_OK) interrupted = PETSC_TRUE;
      }
  if (csv) (void)fclose(csv);
  if (base->scene.dry_run)
    PetscCall(MPMPrint(&base->core.print, "dry run    the study is valid; no step was made\n"));
  else
    PetscCall(MPMPrint(&base->core.print, "results    %s%s\n", path, replaced ? " (replaced)" : ""));
  if (base->method.viscosity > 0)
    PetscCall(MPMPrint(&base->core.print, "note       -method_damping_viscosity is left out: what it does depends on "
                                          "the cells of the scene\n"));
  if (!taken) {
    if (!rank)
      fprintf(stderr, "-study_type stability: the program takes none of these methods; the lines above say why\n");
    *status = MPM_EXIT_INPUT;
  }
  if (interrupted) *status = MPM_EXIT_STOPPED;
  PetscFunctionReturn(PETSC_SUCCESS);
}
