/* predict.c - answers questions about the cost model (src/cost) for the method of a scene, so that the report has the
   program's own numbers: for constants that it sends, and for shares of a run that no run has.

     build/mpicc/predict -options_file scene.opts -dry_run

   First come facts of the method, a line each, the last is `ready`. Then it reads a request a line and answers with a
   line; a number that a request lacks is 0:

     share = particles nodes ghosts neighbours processes axes crossing row waits (MPMShare)

     step <share>                                s of a step
     parts <share>                               s of each part of a step: name=s ...
     master <particles> <nodes> <processes> <e>  s of a step of the pool with patches of e cells an axis, and of these
                                                 the s for which its master is busy
     edge <particles> <nodes> <processes>        e for which that is shortest
     dealt <particles> <nodes> <e>               bytes of each phase of the pool, and jobs, in a step: name=number ...
     cube <n> <per cell> <processes> <moved>     s of a step on one of so many full cubes of n particles
     least <per cell> <processes> <moved> <q>    n for which such cubes have the efficiency q; 0: none

   Without an answer: `direct <0|1>` chooses the way of migration, `clear` makes all constants 0, and lines of a model
   file set them. */
#include "kernels/tile_index.h"
#include "run/mpm.h"

#define NUMBERS 9 /* of a request, at most */

static void PrintFacts(const MPM mpm)
{
  const MPMCore *core = &mpm->core;
  char           method[MPM_TEXT_LEN];

  MPMModelMethod(core, &mpm->scene, method, sizeof method);
  printf("method %s\n", method);
  printf("dim %" PetscInt_FMT "\n", core->grid.dim);
  printf("stencil %" PetscInt_FMT "\n", (PetscInt)MPMBasisNodes(core->basis)); /* nodes on an axis */
  printf("tile %" PetscInt_FMT "\n", MPMTileEdge(core->basis));
  printf("travels %" PetscInt_FMT "\n", MPMParticlesBytes(&core->particles, MPM_SWARM)); /* B of one that migrates */
  for (PetscInt k = 0; k < core->nprogram; k++)
    printf("phase %s %s\n", core->program[k]->name, core->program[k]->kind == MPM_NODES ? "nodes" : "particles");
  printf("ready\n");
}

static MPMShare Share(const double v[])
{
  return (MPMShare){.particles = v[0], .nodes = v[1], .ghosts = v[2], .neighbours = v[3], .processes = v[4],
                    .axes = v[5], .crossing = v[6], .row = v[7], .waits = v[8]};
}

static void AnswerMaster(const MPMModel *m, const MPMCore *core, const double v[])
{
  const MPMShare s     = {.particles = v[0], .nodes = v[1], .processes = v[2]},
                 alone = {.particles = v[0], .nodes = v[1], .processes = 1};
  PetscReal bound, t;

  t = MPMModelPoolStep(m, core, &s, (PetscInt)v[3], &bound);
  printf("%.17g %.17g\n", (double)t, (double)(MPMModelStep(m, core, &alone) / bound));
}

static void AnswerDealt(const MPMCore *core, const double v[])
{
  const MPMShare s = {.particles = v[0], .nodes = v[1], .processes = 1};
  PetscReal      jobs, all = 0;

  for (PetscInt e = 0; e < core->timers.n; e++) {
    const PetscReal bytes = MPMModelPoolBytes(core, e, &s, (PetscInt)v[2], &jobs);

    all += jobs;
    if (jobs > 0) printf("%s=%.17g ", core->timers.name[e], (double)bytes);
  }
  printf("jobs=%.17g\n", (double)all);
}

/* Answers one line; PETSC_FALSE: it is no request. */
static PetscBool Answer(MPM mpm, const char line[])
{
  MPMModel      *m    = &mpm->cost.model;
  const MPMCore *core = &mpm->core;
  char           word[MPM_NAME_LEN];
  double         v[NUMBERS] = {0};
  int            at, ignored = 0;

  if (sscanf(line, "%63s%n", word, &at) != 1) return PETSC_FALSE;
  for (int k = 0, len; k < NUMBERS && sscanf(line + at, "%lf%n", &v[k], &len) == 1; k++) at += len;
  if (!strcmp(word, "clear"))
    memset(m, 0, sizeof *m);
  else if (!strcmp(word, "direct"))
    mpm->core.exchange.direct = v[0] > 0 ? PETSC_TRUE : PETSC_FALSE;
  else if (!strcmp(word, "step")) {
    const MPMShare s = Share(v);

    printf("%.17g\n", (double)MPMModelStep(m, core, &s));
  } else if (!strcmp(word, "parts")) {
    const MPMShare s = Share(v);

    for (PetscInt e = 0; e < core->timers.n; e++)
      printf("%s=%.17g ", core->timers.name[e], (double)MPMModelTimer(m, core, e, &s));
    printf("\n");
  } else if (!strcmp(word, "master"))
    AnswerMaster(m, core, v);
  else if (!strcmp(word, "edge")) {
    const MPMShare s = {.particles = v[0], .nodes = v[1], .processes = v[2]};

    printf("%" PetscInt_FMT "\n", MPMModelPoolEdge(m, core, &s));
  } else if (!strcmp(word, "dealt"))
    AnswerDealt(core, v);
  else if (!strcmp(word, "cube")) {
    const MPMShare s = MPMModelCube(core, v[0], v[1], v[2], v[3]);

    printf("%.17g\n", (double)MPMModelStep(m, core, &s));
  } else if (!strcmp(word, "least"))
    printf("%.17g\n", (double)MPMModelLeast(m, core, v[0], v[1], v[2], v[3]));
  else
    return MPMModelReadLine(&core->timers, line, m, &ignored);
  return PETSC_TRUE;
}

/* Answers requests until the input ends. */
static PetscErrorCode Run(MPM mpm, int *status)
{
  char line[2 * MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMSetPhases(mpm));
  PrintFacts(mpm);
  fflush(stdout);
  while (*status == MPM_EXIT_OK && fgets(line, (int)sizeof line, stdin)) {
    line[strcspn(line, "\n")] = 0;
    if (!Answer(mpm, line)) {
      fprintf(stderr, "predict: no request: %s\n", line);
      *status = MPM_EXIT_INPUT;
    }
    fflush(stdout);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  return MPMProgram(argc, argv, MPMSetFromOptions, Run);
}
