/* migration.c - measures the time of a migration, by DMSwarmMigrate and by direct messages. */
#include "calibrate.h"
#include "parallel/spatial.h"

#define SWAPPED 256       /* particles that a process sends */
#define REPEATS 10        /* migrations of each way in a round */
#define OTHER   (8 << 20) /* bytes that are written before, since the phases of a step leave other data in the caches */

/* Marks n particles as leavers, so that a direct migration exchanges them between the two processes of a pair. They lie
   far from each other in memory, and are not those of the last time. Their positions stay what they are, since only the
   time counts; that of finding processes and cells is not measured. */
static PetscErrorCode Swap(MPM mpm, MPMSpatial *s, PetscInt n, PetscInt first)
{
  const PetscInt all = mpm->core.particles.n;
  PetscInt       d   = 0;

  PetscFunctionBeginUser;
  while (d < mpm->core.grid.dim - 1 && s->p[d] == 1) d++;
  if (s->beside[d][s->me[d] % 2 == 0] == MPI_PROC_NULL || n > all / 2) n = 0; /* it has no partner for this */
  s->nleavers = n;
  PetscCall(PetscMalloc1(n, &s->leaver));
  PetscCall(PetscMalloc1(n, &s->owner));
  PetscCall(PetscCalloc1(n, &s->hops));
  for (PetscInt q = 0; q < n; q++) {
    s->leaver[q]  = first + q * ((all - first) / n);
    s->hops[q][d] = s->me[d] % 2 ? -1 : 1;
  }
  mpm->core.particles.nkept = all;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Times migrations with about n particles per process; the least times go to trial. trial->particles stays 0 if the
   grid cannot be cut for these processes. Collective on scene->core.comm. */
PetscErrorCode TimeMigration(MPM scene, PetscReal n, MigrationTimes *trial)
{
  PetscReal   seconds[WAYS];
  PetscMPIInt size;
  MPM         mpm;
  MPMShare    share;
  MPMSpatial *s;
  char       *other;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(scene->core.comm, &size));
  PetscCall(SetRun(
      scene, "spatial",
      PetscPowReal((PetscReal)scene->core.particles.total / (n * size), 1 / (PetscReal)scene->core.grid.dim), 10));
  PetscCall(MakeRun(scene->core.comm, &mpm));
  if (!mpm) PetscFunctionReturn(PETSC_SUCCESS);
  s = (MPMSpatial *)mpm->core.exchange.ctx;
  PetscCall(MPMModelShare(&mpm->core, MPMTimeStep(&mpm->core, &mpm->time), &share));
  trial->particles      = share.particles;
  trial->axes           = share.axes;
  mpm->core.status.hops = 1; /* all messages are sent, without particles */
  PetscCall(PetscMalloc1(OTHER, &other));
  for (int way = 0; way < WAYS; way++) seconds[way] = PETSC_MAX_REAL;
  for (int repeat = 0; repeat < 3 * REPEATS; repeat++) {
    /* swaps come after DMSwarm's migrations, since they bring particles to processes that do not own their cells */
    const int      way = repeat < REPEATS ? SWARM : repeat % 2 ? DIRECT : SWAP;
    PetscLogDouble t0, t1;

    if (way == SWAP) PetscCall(Swap(mpm, s, SWAPPED, 7 * repeat));
    memset(other, repeat, OTHER);
    PetscCallMPI(MPI_Barrier(scene->core.comm));
    PetscCall(PetscTime(&t0));
    PetscCall(way == SWARM ? MPMMigrateSwarm(&mpm->core, s) : MPMMigrateDirect(&mpm->core, s));
    PetscCall(PetscTime(&t1));
    seconds[way] = PetscMin(seconds[way], t1 - t0);
  }
  PetscCall(Slowest(scene->core.comm, &trial->particles));
  PetscCall(PetscFree(other));
  for (int way = 0; way < WAYS; way++) {
    PetscCall(Slowest(scene->core.comm, &seconds[way]));
    Least(&trial->migration[way], seconds[way]);
  }
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the constants of migrations by their times on `size` processes, with few and with many particles. */
void FitMigration(PetscMPIInt size, const MigrationTimes *a, const MigrationTimes *b, MPMModel *m)
{
  if (a->particles == 0 || b->particles == 0) return; /* not measured: rough constants stay */
  for (int way = 0; way < 2; way++) {
    MPMMigration   *g        = &m->migration[way];
    const PetscReal messages = MPMModelMigrationMessages(m, way == DIRECT, a->axes, (PetscReal)size);

    g->particle = Difference("migration.particle",
                             (b->migration[way] - a->migration[way]) / (b->particles - a->particles));
    g->leaver   = Difference("migration.leaver", b->migration[SWAP] - b->migration[DIRECT]) /
                SWAPPED; /* both ways copy them alike */
    g->call = Difference("migration.call", a->migration[way] - a->particles * g->particle - messages);
  }
}
