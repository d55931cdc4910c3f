/* migration.c - what it takes when particles change process: by DMSwarmMigrate, and by direct messages. */
#include "calibrate.h"
#include "parallel/spatial.h"

#define SWAPPED 256
#define REPEATS 10        /* of each way in a round */
#define OTHER   (8 << 20) /* bytes that the caches have seen since: a migration comes after the sweeps of a step */

/* Pairs of processes next to each other exchange `n` particles, far from each other in memory and not those of the last
   time, which stay what they are: only the cost counts, but for that of finding their processes and cells. */
static PetscErrorCode Swap(MPM mpm, MPMSpatial *s, PetscInt n, PetscInt first)
{
  const PetscInt all = mpm->core.particles.n;
  PetscInt       d   = 0;

  PetscFunctionBeginUser;
  while (d < mpm->core.grid.dim - 1 && s->p[d] == 1) d++;
  if (s->beside[d][s->me[d] % 2 == 0] == MPI_PROC_NULL || n > all / 2) n = 0; /* the last of an odd number, alone */
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

/* Times migrations of about n particles a process; the least times go to the trial, particles stay 0 if there is no
 * such cut.
 */
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
  mpm->core.status.hops = 1; /* all messages, of no particles */
  PetscCall(PetscMalloc1(OTHER, &other));
  for (int way = 0; way < WAYS; way++) seconds[way] = PETSC_MAX_REAL;
  for (int repeat = 0; repeat < 3 * REPEATS; repeat++) {
    /* swaps after DMSwarm's: they leave particles where it would not have them */
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

void FitMigration(PetscMPIInt size, const MigrationTimes *a, const MigrationTimes *b, MPMModel *m)
{
  if (a->particles == 0 || b->particles == 0) return; /* no such cut: rough constants stay */
  for (int way = 0; way < 2; way++) {
    MPMMigration   *g      = &m->migration[way];
    const PetscReal stages = way ? a->axes : PetscCeilReal(PetscLog2Real((PetscReal)size));

    g->particle = PetscMax(0, (b->migration[way] - a->migration[way]) / (b->particles - a->particles));
    g->stage    = way ? m->message + m->post : 24 * m->reduction;
    g->process  = way ? 0 : 80 * m->wire;
    g->leaver   = PetscMax(0, b->migration[SWAP] - b->migration[DIRECT]) / SWAPPED; /* both ways copy them alike */
    g->call     = PetscMax(0, a->migration[way] - a->particles * g->particle - g->stage * stages - g->process * size);
  }
}
