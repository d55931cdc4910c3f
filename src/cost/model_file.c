/* model_file.c - the constants of the model: they are read from the file of a calibration (tools/calibrate), or else
   rough ones are set. A calibration writes its file here. */
#include <errno.h>
#include <unistd.h>
#include "cost/cost.h"

/* Writes a text that is the same for two runs if the same constants fit both: the method, and what a particle costs. */
void MPMModelMethod(const MPMCore *core, const MPMScene *scene, char text[], size_t len)
{
  size_t at = (size_t)snprintf(text, len, "%" PetscInt_FMT "-D:%d:%" PetscInt_FMT ":%" PetscInt_FMT, core->grid.dim,
                               (int)core->basis, MPMParticlesBytes(&core->particles, MPM_SCRATCH), MPMKernelWidth());

  for (PetscInt k = 0; k < core->nprogram && at < len; k++)
    at += (size_t)snprintf(text + at, len - at, ":%s.%" PetscInt_FMT, core->program[k]->name, core->program[k]->parts);
  for (PetscInt k = 0; k < scene->nmaterials && at < len; k++)
    at += (size_t)snprintf(text + at, len - at, ":%s", scene->materials[k].type->name);
  for (PetscInt b = 0; b < scene->nbodies && at < len; b++) {
    const MPMBody *body = &scene->bodies[b];

    at += (size_t)snprintf(text + at, len - at, ":%" PetscInt_FMT,
                           body->ppc[0] * PetscMax(1, body->ppc[1]) * PetscMax(1, body->ppc[2]));
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
  X(migration[0].stage, 1) \
  X(migration[0].process, 1) \
  X(migration[0].particle, 1) \
  X(migration[0].leaver, 1) \
  X(migration[1].call, 1) \
  X(migration[1].stage, 1) \
  X(migration[1].process, 1) \
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

/* Reads the file of the constants, if there is one; `wrong` gets the reason if it cannot be used. Only one process
   calls it. */
static PetscErrorCode Load(MPMCost *cost, const MPMCore *core, const MPMScene *scene, char wrong[], size_t len)
{
  MPMModel  m    = cost->model;
  FILE     *file = fopen(cost->file, "r");
  char      line[2 * MPM_TEXT_LEN], method[MPM_TEXT_LEN];
  PetscBool fits = PETSC_FALSE, sound = PETSC_TRUE;
  int       found = 0, wanted = 0;

  PetscFunctionBeginUser;
  if (!file) PetscFunctionReturn(PETSC_SUCCESS);
  MPMModelMethod(core, scene, method, sizeof method);
  for (PetscInt e = 0; e < MPM_MAX_TIMERS; e++) PetscCall(PetscMemzero(&m.rate[e], sizeof m.rate[e]));
  while (fgets(line, (int)sizeof line, file)) {
    line[strcspn(line, "\n")] = 0;
    if (!strncmp(line, "method ", 7)) fits = strcmp(line + 7, method) ? PETSC_FALSE : PETSC_TRUE;
    if (!MPMModelReadLine(&core->timers, line, &m, &found)) sound = PETSC_FALSE;
  }
  (void)fclose(file);
#define MPM_COUNT(entry, needed) wanted += needed;
  MPM_MODEL_NUMBERS(MPM_COUNT)
#undef MPM_COUNT
  if (found != wanted) sound = PETSC_FALSE;
  for (PetscInt k = 0; k < core->nprogram && fits; k++) { /* was each phase timed? */
    const MPMRate *r = &m.rate[core->program[k]->timer];

    if (!(r->call > 0 || r->each[0] > 0)) sound = PETSC_FALSE;
  }
  if (!fits)
    (void)snprintf(wrong, len, "%.1000s is of another method, of other particles or of other vectors: not used",
                   cost->file);
  else if (!sound)
    (void)snprintf(wrong, len, "%.1000s is damaged, or of another version: not used", cost->file);
  else
    cost->model = m;
  PetscFunctionReturn(PETSC_SUCCESS);
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

/* Sets the constants from the file of a calibration, if there is one for this method, else to rough ones. dir: the
   folder of the results, where the file is unless -model_file names it. The phases and the fields of the particles have
   to be known. Collective on core->comm. */
PetscErrorCode MPMModelSetUp(MPMCost *cost, const MPMCore *core, const MPMScene *scene, const char dir[])
{
  char        wrong[MPM_TEXT_LEN] = "";
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  MPMModelRough(&cost->model, core, scene);
  if (!cost->file[0]) (void)snprintf(cost->file, sizeof cost->file, "%s/%s.model", dir, scene->name);
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  if (!rank) PetscCall(Load(cost, core, scene, wrong, sizeof wrong));
  PetscCallMPI(MPI_Bcast(&cost->model, (PetscMPIInt)sizeof cost->model, MPI_BYTE, 0, core->comm));
  PetscCall(PetscStrncpy(cost->note, wrong, sizeof cost->note));
  PetscFunctionReturn(PETSC_SUCCESS);
}
