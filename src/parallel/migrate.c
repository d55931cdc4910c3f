/* migrate.c - at the end of a step, leavers go to the process that owns their cell: by DMSwarmMigrate, or by direct
   messages. Both bring the same particles to the same processes, so results have the same bits; only messages and time
   differ. */
#include "base/message.h"
#include "base/simulate.h"
#include "kernels/cell.h"
#include "parallel/spatial.h"

#define FIELDS                                                                                                         \
  (MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(cell) | MPM_BIT(kind) |                                             \
   MPM_BIT(l)) /* that say where a particle is */

/* Finds the process that owns the cell where particle p of the view is now, and how many boxes away it is (hops). */
static PetscErrorCode FindOwner(MPMCore *core, const MPMSpatial *s, const MPMView *view, PetscInt p, PetscMPIInt *owner,
                                int hops[3])
{
  const PetscInt dim = core->grid.dim;
  PetscReal      xi[3];
  PetscInt       base[3] = {0};

  PetscFunctionBeginUser;
  PetscCheck(MPMLocate((int)dim, core->basis, &core->grid, MPMKindOf(core->params.kinds, view, p)->copy,
                       MPMPlaces(&core->grid, view) + p * dim, MPMHalfWidths((int)dim, core->params.kinds, view, p), xi,
                       base),
             PETSC_COMM_SELF, PETSC_ERR_PLIB, "particle %" PetscInt64_FMT " has no cell", view->id[p]);
  *owner = MPMSpatialOwner(s, &core->grid, base, hops);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the leavers and the processes that they go to; *hops gets the largest number of boxes that one has to go on an
   axis. A migration follows if any process has leavers. Not collective. */
PetscErrorCode MPMMigrateList(MPMCore *core, MPMSpatial *s, PetscInt64 *hops)
{
  MPMView view;

  PetscFunctionBeginUser;
  PetscCall(MPMMigrateClear(s));
  *hops = 0;
  PetscCall(MPMParticlesLeavers(&core->particles, &s->nleavers, &s->leaver));
  PetscCall(PetscMalloc1(s->nleavers, &s->owner));
  PetscCall(PetscCalloc1(s->nleavers, &s->hops));
  PetscCall(MPMParticlesGetView(&core->particles, FIELDS, &view));
  for (PetscInt q = 0; q < s->nleavers; q++) {
    PetscCall(FindOwner(core, s, &view, s->leaver[q], &s->owner[q], s->hops[q]));
    for (PetscInt d = 0; d < core->grid.dim; d++) *hops = PetscMax(*hops, PetscAbsInt(s->hops[q][d]));
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, FIELDS, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Empties the list. Not collective. */
PetscErrorCode MPMMigrateClear(MPMSpatial *s)
{
  PetscFunctionBeginUser;
  s->nleavers = 0;
  PetscCall(PetscFree(s->leaver));
  PetscCall(PetscFree(s->owner));
  PetscCall(PetscFree(s->hops));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the leavers out of the fingerprint, before they go. */
static PetscErrorCode CountOut(MPMCore *core, MPMSpatial *s)
{
  uint64_t ids = (uint64_t)s->ids;
  MPMView  view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(id), &view));
  for (PetscInt q = 0; q < s->nleavers; q++) ids -= MPMParticleHash(view.id[s->leaver[q]]);
  s->ids = (PetscInt64)ids;
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(id), &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cells of the arrivals, and adds them to the fingerprint. Arrivals lie where leavers were, or at the end,
   where there may also be particles that were here already; those have a cell, while the cell of an arrival, which was
   sent with it, still says that it left. */
static PetscErrorCode LocateArrivals(MPMCore *core, MPMSpatial *s)
{
  const PetscInt  dim = core->grid.dim, nleavers = s->nleavers;
  const MPMPatch *patch     = &core->exchange.patch;
  MPMParticles   *particles = &core->particles;
  MPMView         view;

  PetscFunctionBeginUser;
  particles->nkept -= nleavers;
  PetscCall(MPMParticlesGetView(particles, FIELDS, &view));
  for (PetscInt q = 0; q < nleavers + view.n - particles->nkept; q++) {
    const PetscInt p       = q < nleavers ? s->leaver[q] : particles->nkept + q - nleavers;
    PetscInt       base[3] = {0};

    if (p >= view.n || view.cell[p] >= 0) continue;
    view.cell[p] = MPMOwnCell((int)dim, core->basis, patch, MPMKindOf(core->params.kinds, &view, p)->copy,
                              MPMPlaces(&core->grid, &view) + p * dim,
                              MPMHalfWidths((int)dim, core->params.kinds, &view, p), base);
    PetscCheck(view.cell[p] >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "particle %" PetscInt64_FMT " came to the wrong process", view.id[p]);
    s->ids = (PetscInt64)((uint64_t)s->ids + MPMParticleHash(view.id[p]));
  }
  PetscCall(MPMParticlesRestoreView(particles, FIELDS, &view));
  PetscCall(MPMMigrateClear(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The rows of particles that go to other places of the storage; no place is in both lists. */
typedef struct {
  PetscInt n, *from, *to;
} Moves;

/* Adds the moves that close the places of the last leavers in a storage of n particles, those from number `open` on: the
   last particles take them. */
static void CloseGaps(const MPMSpatial *s, PetscInt open, PetscInt n, Moves *moves)
{
  for (PetscInt q = s->nleavers, last = n - 1; q > open; q--, last--) { /* the last place first */
    if (s->leaver[q - 1] == last) continue;
    moves->from[moves->n] = last;
    moves->to[moves->n++] = s->leaver[q - 1];
  }
}

MPM_INLINE void MoveRows(size_t bytes, const Moves *moves, char *rows)
{
  for (PetscInt q = 0; q < moves->n; q++)
    memcpy(rows + (size_t)moves->to[q] * bytes, rows + (size_t)moves->from[q] * bytes, bytes);
}

/* Makes the moves, field by field, and sets the size of the storage to what it is then. came: how many particles came.
   Not collective. */
static PetscErrorCode MakeMoves(MPMParticles *particles, const Moves *moves, PetscInt n, PetscInt came)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS && moves->n; f++) {
    void *rows;

    if (!particles->present[f] || MPMFields[f].home == MPM_SCRATCH) continue;
    PetscCall(MPMParticlesGetField(particles, f, &rows));
    MPM_FOR_WIDTH(particles->bytes[f], MoveRows, moves, (char *)rows);
    PetscCall(MPMParticlesRestoreField(particles, f));
  }
  particles->room = PetscMax(particles->room, came);
  if (n != particles->n) PetscCall(MPMParticlesSetSize(particles, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets where DMSwarmMigrate sends the particles: leavers to their owners, or nowhere. All others stay, and the numbers
   of the processes are sent with the particles, so all are set the first time only, and once others have flowed in. Not collective. */
static PetscErrorCode SetOwners(MPMParticles *particles, MPMSpatial *s, PetscBool leave)
{
  PetscInt   *owner;
  PetscMPIInt me;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(s->comm, &me));
  PetscCall(DMSwarmGetField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&owner));
  for (PetscInt p = 0; p < particles->n && !s->ranked; p++) owner[p] = me;
  s->ranked = PETSC_TRUE;
  for (PetscInt q = 0; q < s->nleavers; q++) owner[s->leaver[q]] = leave ? s->owner[q] : me;
  PetscCall(DMSwarmRestoreField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&owner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Migrates by DMSwarmMigrate, on the BASIC swarm, with the owners that MPMMigrateList found. Particles may go to any
   process; a call needs 14 collectives, 8 of them reductions. It leaves those that it has sent where they were, since it
   would remove them one by one and PETSc before 3.25 zeroes all spare places at each removal (46,656 of 5,000,000
   particles took 2 s). Collective. */
PetscErrorCode MPMMigrateSwarm(MPMCore *core, MPMSpatial *s)
{
  MPMParticles  *particles = &core->particles;
  const PetscInt n = particles->n, gaps = s->nleavers;
  PetscInt       came;
  Moves          moves = {0};

  PetscFunctionBeginUser;
  PetscCall(CountOut(core, s));
  PetscCall(SetOwners(particles, s, PETSC_TRUE));
  PetscCall(DMSwarmMigrate(particles->swarm, PETSC_FALSE));
  MPMSimulateWork("SWARM", 1);
  MPMSimulateWork("SWARM_PARTICLE", (PetscReal)n);
  PetscCall(SetOwners(particles, s, PETSC_FALSE));
  PetscCall(MPMParticlesResize(particles));
  came = particles->n - n;
  PetscCall(PetscMalloc2(gaps, &moves.from, gaps, &moves.to));
  for (; moves.n < PetscMin(came, gaps); moves.n++) { /* the last arrivals take the places of leavers */
    moves.from[moves.n] = n + PetscMax(0, came - gaps) + moves.n;
    moves.to[moves.n]   = s->leaver[moves.n];
  }
  CloseGaps(s, moves.n, n, &moves);
  PetscCall(MakeMoves(particles, &moves, n + came - gaps, came));
  PetscCall(PetscFree2(moves.from, moves.to));
  PetscCall(LocateArrivals(core, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies a field of the n listed particles into messages that lie `stride` bytes apart, or back. */
MPM_INLINE void PackField(size_t bytes, PetscInt n, const PetscInt which[], char *field, char *message, size_t stride,
                          PetscBool unpack)
{
  for (PetscInt q = 0; q < n; q++) {
    char *row = field + (size_t)which[q] * bytes, *packed = message + (size_t)q * stride;

    if (unpack)
      memcpy(row, packed, bytes);
    else
      memcpy(packed, row, bytes);
  }
}

/* Packs all fields of the n listed particles that are sent, or unpacks them. It goes field by field, with the width of
   each as a constant, so that the processor can wait for many memory accesses, far from each other, at a time. */
static void PackParticles(const MPMParticles *particles, void *const at[], PetscInt n, const PetscInt which[],
                          char *message, size_t stride, PetscBool unpack)
{
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const size_t bytes = (size_t)particles->bytes[f];
    char        *field = (char *)at[f];

    if (!field) continue;
    MPM_FOR_WIDTH(bytes, PackField, n, which, field, message, stride, unpack);
    message += bytes;
  }
}

static PetscErrorCode GetFields(MPMParticles *particles, PetscBool restore, void *at[])
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    if (!particles->present[f] || MPMFields[f].home == MPM_SCRATCH) continue;
    if (restore)
      PetscCall(MPMParticlesRestoreField(particles, f));
    else
      PetscCall(MPMParticlesGetField(particles, f, &at[f]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for n packed particles of so many bytes, and keeps those that are there. Packed particles are between their
   old process and their new one; each comes after the numbers of boxes that it still has to go on each axis (Boxes). Not
   collective. */
typedef int           Boxes[3];
static PetscErrorCode MakeRoom(MPMSpatial *s, PetscInt n, size_t bytes)
{
  const size_t need = (size_t)n * bytes;

  PetscFunctionBeginUser;
  if (need <= s->packed_capacity) PetscFunctionReturn(PETSC_SUCCESS);
  s->packed_capacity = need + need / 4;
  PetscCall(PetscRealloc(s->packed_capacity, &s->packed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends those of the *n packed particles that have to go along axis d to the next process there, and receives those from
   both sides. Each way there is one message, of no bytes if no particle goes. Collective on the processes of a line
   along d. */
static PetscErrorCode SendAlong(MPMSpatial *s, PetscInt d, size_t bytes, PetscInt *n)
{
  PetscInt    stay = 0, go[2] = {0}; /* down, up */
  char       *out[2];
  MPI_Request request[2];
  PetscMPIInt len;

  PetscFunctionBeginUser;
  for (PetscInt q = 0; q < *n; q++) {
    Boxes way;

    memcpy(way, s->packed + (size_t)q * bytes, sizeof way);
    if (way[d]) go[way[d] > 0]++;
  }
  PetscCall(MPMMessageRoom(&s->out, &s->out_capacity, (size_t)(go[0] + go[1]) * bytes));
  out[0] = s->out;
  out[1] = s->out + (size_t)go[0] * bytes;
  for (PetscInt q = 0; q < *n; q++) {
    char *from = s->packed + (size_t)q * bytes;
    Boxes way;

    memcpy(way, from, sizeof way);
    if (way[d]) {
      const int up = way[d] > 0;

      way[d] += up ? -1 : 1;
      memcpy(from, way, sizeof way);
      memcpy(out[up], from, bytes);
      out[up] += bytes;
    } else if (stay++ < q)
      memcpy(s->packed + (size_t)(stay - 1) * bytes, from, bytes);
  }
  *n = stay;
  for (int up = 0; up < 2; up++) {
    PetscCall(MPMMessageLength((size_t)go[up] * bytes, &len));
    PetscCallMPI(
        MPI_Isend(out[up] - len, len, MPI_BYTE, s->beside[d][up], MPM_TAG_MIGRATE + up, s->comm, &request[up]));
  }
  for (int up = 0; up < 2; up++) { /* what goes up comes from below */
    MPI_Status status;

    PetscCallMPI(MPI_Probe(s->beside[d][!up], MPM_TAG_MIGRATE + up, s->comm, &status));
    PetscCallMPI(MPI_Get_count(&status, MPI_BYTE, &len));
    PetscCall(MakeRoom(s, *n + (PetscInt)((size_t)len / bytes), bytes));
    PetscCallMPI(MPI_Recv(s->packed + (size_t)*n * bytes, len, MPI_BYTE, s->beside[d][!up], MPM_TAG_MIGRATE + up,
                          s->comm, MPI_STATUS_IGNORE));
    *n += (PetscInt)((size_t)len / bytes);
  }
  PetscCallMPI(MPI_Waitall(2, request, MPI_STATUSES_IGNORE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Migrates by direct messages: leavers go from box to box, along one axis after the other, mostly by one box on each
   (status.hops is the largest number for any process). Arrivals take the places of leavers, then those at the end.
   Collective. */
PetscErrorCode MPMMigrateDirect(MPMCore *core, MPMSpatial *s)
{
  MPMParticles  *particles = &core->particles;
  const PetscInt n = particles->n, gaps = s->nleavers;
  const size_t   bytes              = sizeof(Boxes) + (size_t)MPMParticlesBytes(particles, MPM_SWARM);
  void          *at[MPM_NUM_FIELDS] = {NULL};
  PetscInt       come               = gaps; /* packed particles: at first those that leave, then those that come */
  Moves          moves              = {0};

  PetscFunctionBeginUser;
  PetscCall(CountOut(core, s));
  PetscCall(MakeRoom(s, gaps + 1, bytes));
  PetscCall(GetFields(particles, PETSC_FALSE, at));
  for (PetscInt q = 0; q < gaps; q++) memcpy(s->packed + (size_t)q * bytes, s->hops[q], sizeof(Boxes));
  PackParticles(particles, at, gaps, s->leaver, s->packed + sizeof(Boxes), bytes, PETSC_FALSE);
  PetscCall(GetFields(particles, PETSC_TRUE, at));
  for (PetscInt d = 0; d < core->grid.dim; d++)
    for (PetscInt64 hop = 0; s->p[d] > 1 && hop < core->status.hops; hop++) PetscCall(SendAlong(s, d, bytes, &come));
  particles->room = PetscMax(particles->room, come);
  if (come > gaps) PetscCall(MPMParticlesSetSize(particles, n + come - gaps));
  PetscCall(GetFields(particles, PETSC_FALSE, at));
  PetscCall(PetscMalloc2(PetscMax(come, gaps), &moves.to, gaps, &moves.from));
  for (PetscInt q = 0; q < come; q++) moves.to[q] = q < gaps ? s->leaver[q] : n + q - gaps;
  PackParticles(particles, at, come, moves.to, s->packed + sizeof(Boxes), bytes, PETSC_TRUE);
  PetscCall(GetFields(particles, PETSC_TRUE, at));
  CloseGaps(s, come, n, &moves);
  if (come < gaps) PetscCall(MakeMoves(particles, &moves, n + come - gaps, come));
  PetscCall(PetscFree2(moves.to, moves.from));
  MPMSimulateWork("LEAVER", 0.5 * (PetscReal)(gaps + come));
  PetscCall(LocateArrivals(core, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}
