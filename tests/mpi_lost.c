/* mpi_lost.c - a particle that gets lost, doubled, or replaced by another on its way between processes is found by the
   next step, which raises an error that names it. Runs on 2 or more processes, with the options of a scene: mpiexec -n
   2 mpi_lost lost|doubled|replaced -options_file options/disks.opts -output_dir .                        */
#include "run/mpm.h"
#include "unit.h"

enum { LOST, DOUBLED, REPLACED, NUM_CASES };
static const char *const names[NUM_CASES] = {"lost", "doubled", "replaced"};

static char raised[4096]; /* the text of the first error */

/* Keeps the text of an error instead of printing it. */
static PetscErrorCode Keep(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                           PetscErrorType type, const char *text, void *ctx)
{
  (void)comm;
  (void)line;
  (void)function;
  (void)file;
  (void)ctx;
  if (type == PETSC_ERROR_INITIAL && text && !raised[0]) (void)snprintf(raised, sizeof raised, "%s", text);
  return code;
}

/* Copies all fields that the swarm holds of particle `from` of this process to particle `to`. */
static PetscErrorCode CopyParticle(MPMParticles *particles, PetscInt from, PetscInt to)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const PetscInt b = particles->bytes[f];
    void          *at;

    if (!particles->present[f] || MPMFields[f].home == MPM_SCRATCH) continue;
    PetscCall(MPMParticlesGetField(particles, f, &at));
    memmove((char *)at + to * b, (char *)at + from * b, (size_t)b);
    PetscCall(MPMParticlesRestoreField(particles, f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does to the particles of this process what a wrong migration would do; returns the id that must be named, and in
   *other another one that is wrong too, or -1. */
static PetscErrorCode Damage(MPM mpm, int what, PetscInt64 *id, PetscInt64 *other)
{
  MPMParticles  *particles = &mpm->core.particles;
  const PetscInt n = particles->n, p = n / 3, q = n / 2;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(id), &view));
  *id    = view.id[p];
  *other = what == REPLACED ? view.id[q] : -1;
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(id), &view));
  if (what == LOST) {
    PetscCall(DMSwarmRemovePointAtIndex(particles->swarm, p));
    PetscCall(MPMParticlesSetSize(particles, n - 1));
  } else if (what == DOUBLED) {
    PetscCall(MPMParticlesSetSize(particles, n + 1));
    PetscCall(CopyParticle(particles, p, n));
  } else
    PetscCall(CopyParticle(particles, q, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Steps(MPM mpm, PetscInt n)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < n; k++) {
    mpm->core.params.kick = mpm->core.params.dt = MPMTimeStep(&mpm->core, &mpm->time);
    PetscCall(MPMStepMake(&mpm->core, &mpm->scene));
    PetscCheck(mpm->core.status.bad == MPM_OK, PETSC_COMM_SELF, PETSC_ERR_PLIB, "the scene failed by itself");
    PetscCall(MPMStepSettle(&mpm->core));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(int what, PetscMPIInt rank)
{
  MPM            mpm;
  MPMOptions     options;
  PetscInt64     id[2] = {-1, -1};
  PetscErrorCode code;
  char           missing[64], doubled[128];

  PetscFunctionBeginUser;
  UnitContext("%s, process %d", names[what], rank);
  PetscCall(MPMCreate(PETSC_COMM_WORLD, &mpm));
  PetscCall(MPMOptionsCreate(&MPMOptionTable, &options));
  PetscCall(MPMSetFromOptions(mpm, options));
  PetscCheck(!MPMOptionsError(options), PETSC_COMM_SELF, PETSC_ERR_USER, "%s", MPMOptionsError(options));
  PetscCall(MPMSetUp(mpm));
  PetscCall(Steps(mpm, 5));
  CHECK_EQ(mpm->core.status.n, mpm->core.particles.total);
  CHECK(rank == 0 || mpm->core.particles.n > 100);
  if (rank == 1) PetscCall(Damage(mpm, what, &id[0], &id[1]));
  PetscCallMPI(MPI_Bcast(id, 2, MPIU_INT64, 1, PETSC_COMM_WORLD));
  for (int way = 0; way < 2; way++) { /* a line of the history finds it at once, the next step at the latest */
    MPMTotals totals;

    if (way) PetscCall(mpm->core.exchange.type->settle(&mpm->core, PETSC_TRUE));
    raised[0] = 0;
    PetscCall(PetscPushErrorHandler(Keep, NULL));
    mpm->core.params.kick = mpm->core.params.dt = MPMTimeStep(&mpm->core, &mpm->time);
    code = way ? MPMStepMake(&mpm->core, &mpm->scene) : MPMTotalsCompute(&mpm->scene, &mpm->core, &totals);
    (void)PetscPopErrorHandler();
    CHECK(code != PETSC_SUCCESS);
    CHECK(strstr(raised, "lost or doubled") != NULL);
    (void)snprintf(missing, sizeof missing, "particle %lld is missing", (long long)id[0]);
    (void)snprintf(doubled, sizeof doubled, "particle %lld is there more than once, on process 1 at (",
                   (long long)(what == DOUBLED ? id[0] : id[1]));
    CHECK((strstr(raised, missing) != NULL) == (what != DOUBLED));
    CHECK((strstr(raised, doubled) != NULL) == (what != LOST));
  }
  if (rank == 0) printf("%s: %s\n", names[what], raised);
  PetscCall(MPMOptionsDestroy(&options));
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  PetscMPIInt rank, size;
  int         what = 0;

  while (what < NUM_CASES && (argc < 2 || strcmp(argv[1], names[what]))) what++;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCheck(size > 1 && what < NUM_CASES, PETSC_COMM_WORLD, PETSC_ERR_USER,
             "needs 2 processes, and one of lost, doubled, replaced");
  PetscCall(Run(what, rank));
  PetscCall(PetscFinalize());
  return UnitEnd();
}
