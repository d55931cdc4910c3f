/* model_file.c - the constants of the model: they are read from the file of a calibration (tools/calibrate), or else
   rough ones are set. A calibration writes its file here. */
#include <dirent.h>
#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>
#include "cost/cost.h"

/* Writes a text that is the same for two runs if the same constants fit both: the method, and what a particle costs. */
void MPMModelMethod(const MPMCore *core, const MPMScene *scene, char text[], size_t len)
{
  size_t at = (size_t)snprintf(text, len, "%" PetscInt_FMT "-D:%d:%" PetscInt_FMT ":%" PetscInt_FMT, core->grid.dim,
                               (int)core->basis, MPMParticlesBytes(&core->particles, MPM_SCRATCH), MPMKernelWidth());

  for (PetscInt k = 0; k < core->nprogram + core->nrare && at < len; k++)
    at += (size_t)snprintf(text + at, len - at, ":%s.%" PetscInt_FMT, core->program[k]->name, core->program[k]->parts);
  for (PetscInt k = 0; k < scene->nmaterials && at < len; k++)
    at += (size_t)snprintf(text + at, len - at, ":%s", scene->materials[k].type->name);
  for (PetscInt b = 0; b < scene->nbodies && at < len; b++) {
    PetscInt per_cell = 1;

    for (PetscInt d = 0; d < core->grid.dim; d++) per_cell *= PetscMax(1, scene->bodies[b].ppc[d]);
    at += (size_t)snprintf(text + at, len - at, ":%" PetscInt_FMT, per_cell);
  }
}

/* The single numbers of a model, by their names in its file. 0: the file need not have it, since no prediction uses
   it. */
/* clang-format off */
#define MPM_MODEL_NUMBERS(X) \
  X(exchange, 1) \
  X(message, 1) \
  X(post, 1) \
  X(wire, 1) \
  X(copy, 1) \
  X(kept, 1) \
  X(reduction, 1) \
  X(job, 1) \
  X(pool, 1) \
  X(migration[0].call, 1) \
  X(migration[0].particle, 1) \
  X(migration[0].leaver, 1) \
  X(migration[1].call, 1) \
  X(migration[1].particle, 1) \
  X(migration[1].leaver, 1) \
  X(flop, 0) \
  X(byte, 0)
/* clang-format on */

/* Writes the constants to cost->file. Only one process calls it. */
PetscErrorCode MPMModelSave(const MPMCost *cost, const MPMCore *core, const MPMScene *scene)
{
  const MPMModel *m = &cost->model;
  char            method[MPM_TEXT_LEN];
  FILE           *file = fopen(cost->file, "w");

  PetscFunctionBeginUser;
  PetscCheck(file, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot write %s: %s", cost->file, strerror(errno));
  MPMModelMethod(core, scene, method, sizeof method);
  fprintf(file, "# constants of pebble's model of a step, by make calibrate; s, and s a particle, node or byte\n");
  fprintf(file, "# rate <part of the step> <a call>, then three times <at so many> <so much each>\n");
  fprintf(file, "method %s\nfrom %s\n", method, m->from);
  if (m->within > MPM_WITHIN_CALIBRATED) fprintf(file, "within %.3g\n", (double)m->within);
  for (PetscInt q = 0; q < core->timers.n; q++) {
    const PetscInt e = MPMTimersRow(&core->timers, q);
    const MPMRate *r = &m->rate[e];

    if (r->call == 0 && r->each[MPM_RATE_SIZES - 1] == 0) continue;
    fprintf(file, "rate %s %.6g", core->timers.name[e], (double)r->call);
    for (int k = 0; k < MPM_RATE_SIZES; k++) fprintf(file, " %.6g %.6g", (double)r->size[k], (double)r->each[k]);
    fprintf(file, "\n");
  }
#define MPM_WRITE(name, needed) fprintf(file, #name " %.6g\n", (double)m->name);
  MPM_MODEL_NUMBERS(MPM_WRITE)
#undef MPM_WRITE
  PetscCheck(!fclose(file), PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s", cost->file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a line of the file into the model. Returns PETSC_FALSE if the line does not belong into such a file or has a
   number out of range. *found counts the single numbers that are needed. */
PetscBool MPMModelReadLine(const MPMTimers *timers, const char line[], MPMModel *m, int *found)
{
  char   name[MPM_NAME_LEN];
  double v[1 + 2 * MPM_RATE_SIZES];
  int    e, at = 0;

  if (!strncmp(line, "method ", 7) || line[0] == '#' || !line[0]) return PETSC_TRUE;
  if (!strncmp(line, "from ", 5)) {
    (void)snprintf(m->from, sizeof m->from, "%.*s", (int)sizeof m->from - 1, line + 5);
    return PETSC_TRUE;
  }
  if (!strncmp(line, "within ", 7)) {
    if (sscanf(line, "within %lf", v) != 1 || !(v[0] >= MPM_WITHIN_CALIBRATED && v[0] < 1e6)) return PETSC_FALSE;
    m->within = v[0];
    return PETSC_TRUE;
  }
  if (!strncmp(line, "rate ", 5)) {
    if (sscanf(line, "rate %63s%n", name, &at) != 1) return PETSC_FALSE;
    for (e = 0; e < timers->n && strcmp(timers->name[e], name);) e++;
    if (e == timers->n) return PETSC_FALSE;
    for (int k = 0, len; k < 1 + 2 * MPM_RATE_SIZES; k++, at += len)
      if (sscanf(line + at, "%lf%n", &v[k], &len) != 1 || !(v[k] >= 0 && v[k] < PETSC_MAX_REAL)) return PETSC_FALSE;
    m->rate[e].call = v[0];
    for (int k = 0; k < MPM_RATE_SIZES; k++) {
      m->rate[e].size[k] = v[1 + 2 * k];
      m->rate[e].each[k] = v[2 + 2 * k];
      if (k && v[1 + 2 * k] <= v[2 * k - 1]) return PETSC_FALSE;
    }
    return PETSC_TRUE;
  }
  if (sscanf(line, "%63s %lf", name, v) != 2 || !(v[0] >= 0 && v[0] < 1)) return PETSC_FALSE; /* each is a time in s */
#define MPM_READ(entry, needed)                                                                                        \
  if (!strcmp(name, #entry)) {                                                                                         \
    m->entry = v[0];                                                                                                   \
    *found += needed;                                                                                                  \
    return PETSC_TRUE;                                                                                                 \
  }
  MPM_MODEL_NUMBERS(MPM_READ)
#undef MPM_READ
  return PETSC_FALSE;
}

/* Returns how the scene of a file of constants differs from this one: the first part in which the texts of
   MPMModelMethod differ. */
static const char *Differs(const char theirs[], const char ours[])
{
  static const char *const parts[] = {"in another dimension", "with another basis", "with other fields of particles",
                                      "with another number of lanes"};
  size_t                   part    = 0;

  for (size_t k = 0; theirs[k] == ours[k] && ours[k]; k++) part += ours[k] == ':';
  return part < sizeof parts / sizeof parts[0]
             ? parts[part]
             : "with another update, transfer or material, or more or fewer particles a cell";
}

/* Reads a file of constants into *m; wrong [len] gets the reason if it cannot be used, or "". The method `any`, of a file
   that was written by hand, fits every scene whose phases have rates there. Only one process calls it. */
static PetscErrorCode Load(const char path[], const MPMCore *core, const MPMScene *scene, MPMModel *m, char wrong[],
                           size_t len)
{
  FILE     *file = fopen(path, "r");
  char      line[2 * MPM_TEXT_LEN], method[MPM_TEXT_LEN], theirs[2 * MPM_TEXT_LEN] = "";
  PetscBool sound = PETSC_TRUE, fits;
  int       found = 0, wanted = 0;

  PetscFunctionBeginUser;
  wrong[0] = 0;
  MPMModelMethod(core, scene, method, sizeof method);
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) PetscCall(PetscMemzero(&m->rate[e], sizeof m->rate[e]));
  m->within = MPM_WITHIN_CALIBRATED; /* unless the file has a line of its own */
  while (file && fgets(line, (int)sizeof line, file)) {
    line[strcspn(line, "\n")] = 0;
    if (!strncmp(line, "method ", 7)) (void)snprintf(theirs, sizeof theirs, "%s", line + 7);
    if (!MPMModelReadLine(&core->timers, line, m, &found)) sound = PETSC_FALSE;
  }
  if (file) (void)fclose(file);
#define MPM_COUNT(entry, needed) wanted += needed;
  MPM_MODEL_NUMBERS(MPM_COUNT)
#undef MPM_COUNT
  if (found != wanted) sound = PETSC_FALSE;
  fits = !strcmp(theirs, method) || !strcmp(theirs, "any");
  for (PetscInt k = 0; k < core->nprogram + core->nrare && fits; k++) { /* was each phase timed? */
    const MPMRate *r = &m->rate[core->program[k]->timer];

    if (!(r->call > 0 || r->each[0] > 0)) sound = PETSC_FALSE;
  }
  if (!fits && found == wanted)
    (void)snprintf(wrong, len, "%.1000s was measured %s", path, Differs(theirs, method));
  else if (!fits || !sound)
    (void)snprintf(wrong, len, "%.1000s is damaged, or of another version of pebble", path);
  m->measured = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Looks in the folder of the results for the newest file of constants that fits this scene, whatever its name is. A run
   whose name has changed finds those of its old name. Only one process calls it. */
static PetscErrorCode LoadNewest(MPMCost *cost, const MPMCore *core, const MPMScene *scene, const char dir[])
{
  const MPMModel rough  = cost->model;
  DIR           *folder = opendir(dir);
  time_t         newest = 0;

  PetscFunctionBeginUser;
  for (struct dirent *entry; folder && (entry = readdir(folder));) {
    const size_t n = strlen(entry->d_name);
    char         path[sizeof cost->used], wrong[MPM_TEXT_LEN];
    MPMModel     m = rough;
    struct stat  s;

    if (n < 7 || strcmp(entry->d_name + n - 6, ".model")) continue;
    (void)snprintf(path, sizeof path, "%s/%s", dir, entry->d_name);
    if (stat(path, &s) || !S_ISREG(s.st_mode)) continue;
    if (cost->used[0] && (s.st_mtime < newest || (s.st_mtime == newest && strcmp(path, cost->used) < 0))) continue;
    PetscCall(Load(path, core, scene, &m, wrong, sizeof wrong));
    if (wrong[0]) continue;
    newest      = s.st_mtime;
    cost->model = m;
    PetscCall(PetscStrncpy(cost->used, path, sizeof cost->used));
  }
  if (folder) (void)closedir(folder);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMModelMissed(MPMModel *m, PetscReal ratio)
{
  const PetscReal missed = PetscMax(ratio, 1 / ratio);

  if (missed > m->within) m->within = PetscCeilReal(10 * missed) / 10;
}

/* Returns whether a file is one of a calibration: one of the first lines names a method. Not collective. */
PetscBool MPMModelIsFile(const char path[])
{
  FILE     *file = fopen(path, "r");
  char      line[2 * MPM_TEXT_LEN];
  PetscBool is = PETSC_FALSE;

  for (int k = 0; file && k < 20 && fgets(line, (int)sizeof line, file); k++)
    if (!strncmp(line, "method ", 7)) is = PETSC_TRUE;
  if (file) (void)fclose(file);
  return is;
}

/* Reads -model_file; a fault is left in o. Not collective. */
PetscErrorCode MPMModelSetFromOptions(MPMCost *cost, MPMOptions o)
{
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(cost->file, "", sizeof cost->file));
  PetscCall(MPMOptionsString(o, "model_file", NULL, cost->file, &set));
  if (!set || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (access(cost->file, R_OK))
    MPMOptionsFail(o, "-model_file: cannot read %s: %s; make calibrate writes it", cost->file, strerror(errno));
  else if (!MPMModelIsFile(cost->file))
    MPMOptionsFail(o, "-model_file: %s has no constants of the model; make calibrate writes such a file", cost->file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the constants to those of -model_file, else of the file with the name of the run, else of another one in the same
   folder. Sets them to rough ones if none of these fits, and cost->note to the reason if the first does not. dir: the
   folder of the results. The phases and the fields of the particles have to be known. Collective on core->comm. */
PetscErrorCode MPMModelSetUp(MPMCost *cost, const MPMCore *core, const MPMScene *scene, const char dir[])
{
  const PetscBool named               = cost->file[0] ? PETSC_TRUE : PETSC_FALSE;
  char            wrong[MPM_TEXT_LEN] = "";
  PetscMPIInt     rank, size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  MPMModelRough(&cost->model, core, scene);
  cost->used[0] = cost->note[0] = 0;
  if (!named) (void)snprintf(cost->file, sizeof cost->file, "%s/%s.model", dir, scene->name);
  if (!rank && !access(cost->file, F_OK)) {
    MPMModel m = cost->model;

    PetscCall(Load(cost->file, core, scene, &m, wrong, sizeof wrong));
    if (!wrong[0]) {
      cost->model = m;
      PetscCall(PetscStrncpy(cost->used, cost->file, sizeof cost->used));
    }
  }
  if (!rank && !named && !cost->used[0]) PetscCall(LoadNewest(cost, core, scene, dir));
  /* A calibration on one process has measured no messages, and says so. */
  if (cost->used[0] && size > 1 && strstr(cost->model.from, "messages rough"))
    cost->model.within = PetscMax(cost->model.within, MPM_WITHIN_ROUGH);
  if (wrong[0] && !cost->used[0])
    (void)snprintf(cost->note, sizeof cost->note,
                   "%.1200s, so rough constants predict times; make calibrate SCENE=<options file> measures those of "
                   "this scene",
                   wrong);
  PetscCallMPI(MPI_Bcast(&cost->model, (PetscMPIInt)sizeof cost->model, MPI_BYTE, 0, core->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
