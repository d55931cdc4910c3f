/* migrate.c - points that left their patch go to the process that owns their cell. Both ways give the same points on
   the same processes, so the same bits; only messages and time differ.                                               */
#include "cell.h"
#include "exchange_spatial.h"

#define FIELDS (MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(cell) | MPM_BIT(kind) | MPM_BIT(l)) /* that say where a point is */

/* The process that owns the cell where point p of the view is now. */
static PetscErrorCode FindOwner(MPM mpm, const MPMSpatial *s, const MPMView *view, PetscInt p, PetscMPIInt *owner)
{
  const PetscInt dim = mpm->grid.dim;
  PetscReal      xi[3];
  PetscInt       base[3] = {0};

  PetscFunctionBeginUser;
  PetscCheck(MPMLocate((int)dim, mpm->basis, &mpm->grid, view->x + p * dim,
                       MPMHalfWidths((int)dim, mpm->scene.kinds, view, p), xi, base),
             PETSC_COMM_SELF, PETSC_ERR_PLIB, "point %" PetscInt64_FMT " has no cell", view->id[p]);
  *owner = MPMSpatialOwner(s, dim, base);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the points that left the patch and the processes that they go to, and finds out how far that is. A migration
   follows if any process lists some. Not collective. */
PetscErrorCode MPMMigrateList(MPM mpm, MPMSpatial *s, PetscInt64 *hops)
{
  MPMView view;

  PetscFunctionBeginUser;
  PetscCall(MPMMigrateForget(s));
  *hops = 0;
  PetscCall(MPMPointsLeavers(&mpm->points, &s->nleavers, &s->leaver));
  PetscCall(PetscMalloc1(s->nleavers, &s->owner));
  PetscCall(MPMPointsGetView(&mpm->points, FIELDS, &view));
  for (PetscInt q = 0; q < s->nleavers; q++) {
    PetscCall(FindOwner(mpm, s, &view, s->leaver[q], &s->owner[q]));
    for (PetscInt d = 0; d < mpm->grid.dim; d++)
      *hops = PetscMax(*hops, PetscAbsInt(MPMSpatialHops(s, mpm->grid.periodic, d, s->owner[q])));
  }
  PetscCall(MPMPointsRestoreView(&mpm->points, FIELDS, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Empties the list. Not collective. */
PetscErrorCode MPMMigrateForget(MPMSpatial *s)
{
  PetscFunctionBeginUser;
  s->nleavers = 0;
  PetscCall(PetscFree(s->leaver));
  PetscCall(PetscFree(s->owner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the leavers out of the fingerprint, before they go. */
static PetscErrorCode CountOut(MPM mpm, MPMSpatial *s)
{
  uint64_t ids = (uint64_t)s->ids;
  MPMView  view;

  PetscFunctionBeginUser;
  PetscCall(MPMPointsGetView(&mpm->points, MPM_BIT(id), &view));
  for (PetscInt q = 0; q < s->nleavers; q++) ids -= MPMPointMark(view.id[s->leaver[q]]);
  s->ids = (PetscInt64)ids;
  PetscCall(MPMPointsRestoreView(&mpm->points, MPM_BIT(id), &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cells of the points that came, and adds them to the fingerprint: their cell, which travels with them, is
   still that of a leaver. They are where leavers were, or at the end, as may be points that were here already. */
static PetscErrorCode LocateComers(MPM mpm, MPMSpatial *s)
{
  const PetscInt  dim = mpm->grid.dim, nleavers = s->nleavers;
  const MPMPatch *patch = &mpm->exchange.patch;
  MPMPoints      *pts   = &mpm->points;
  MPMView         view;

  PetscFunctionBeginUser;
  pts->nkept -= nleavers;
  PetscCall(MPMPointsGetView(pts, FIELDS, &view));
  for (PetscInt q = 0; q < nleavers + view.n - pts->nkept; q++) {
    const PetscInt p       = q < nleavers ? s->leaver[q] : pts->nkept + q - nleavers;
    PetscInt       base[3] = {0};

    if (p >= view.n || view.cell[p] >= 0) continue;
    view.cell[p] = MPMOwnCell((int)dim, mpm->basis, patch, view.x + p * dim,
                              MPMHalfWidths((int)dim, mpm->scene.kinds, &view, p), base);
    PetscCheck(view.cell[p] >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "point %" PetscInt64_FMT " came to the wrong process", view.id[p]);
    s->ids = (PetscInt64)((uint64_t)s->ids + MPMPointMark(view.id[p]));
  }
  PetscCall(MPMPointsRestoreView(pts, FIELDS, &view));
  PetscCall(MPMMigrateForget(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* By PETSc: DMSwarmMigrate on the BASIC swarm with the owners that we found. Exact, to any process, at the price of
   eleven collectives a call. Collective.                                                                             */
PetscErrorCode MPMMigrateSwarm(MPM mpm, MPMSpatial *s)
{
  MPMPoints  *pts = &mpm->points;
  PetscInt   *owner;
  PetscMPIInt me;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(s->comm, &me));
  PetscCall(CountOut(mpm, s));
  PetscCall(DMSwarmGetField(pts->swarm, DMSwarmField_rank, NULL, NULL, (void **)&owner));
  if (!s->ranked) /* later, only leavers have another owner: the field travels with the points */
    for (PetscInt p = 0; p < pts->n; p++) owner[p] = me;
  s->ranked = PETSC_TRUE;
  for (PetscInt q = 0; q < s->nleavers; q++) owner[s->leaver[q]] = s->owner[q];
  PetscCall(DMSwarmRestoreField(pts->swarm, DMSwarmField_rank, NULL, NULL, (void **)&owner));
  PetscCall(DMSwarmMigrate(pts->swarm, PETSC_TRUE));
  MPMSimulateWork("SWARM", 1);
  PetscCall(MPMPointsResize(pts));
  PetscCall(LocateComers(mpm, s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Packs all fields of a point that travel, or unpacks them. */
static void PackPoint(const MPMPoints *pts, void *const at[], PetscInt p, char *message, PetscBool unpack)
{
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const size_t b = (size_t)pts->bytes[f];

    if (!at[f]) continue;
    if (unpack)
      memcpy((char *)at[f] + (size_t)p * b, message, b);
    else
      memcpy(message, (char *)at[f] + (size_t)p * b, b);
    message += b;
  }
}

static PetscErrorCode GetFields(MPMPoints *pts, PetscBool restore, void *at[])
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    if (!pts->present[f] || MPMFields[f].home == MPM_SCRATCH) continue;
    if (restore)
      PetscCall(DMSwarmRestoreField(pts->swarm, MPMFields[f].name, NULL, NULL, &at[f]));
    else
      PetscCall(DMSwarmGetField(pts->swarm, MPMFields[f].name, NULL, NULL, &at[f]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Packed points on their way, each behind the process that it goes to. */
typedef struct {
  char    *at;
  PetscInt n, capacity;
  size_t   bytes; /* of a point with its destination */
} Transit;

static PetscErrorCode MakeRoom(Transit *t, PetscInt n)
{
  PetscFunctionBeginUser;
  if (n <= t->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  t->capacity = 2 * n;
  PetscCall(PetscRealloc((size_t)t->capacity * t->bytes, &t->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hands the points that have to go along axis d to the next process there, and takes those from both sides: a message
   each way, of no bytes where nothing moves. Collective on the processes of a line along d.                          */
static PetscErrorCode PassOn(MPM mpm, const MPMSpatial *s, PetscInt d, Transit *t)
{
  Transit     out[2] = {{.bytes = t->bytes}, {.bytes = t->bytes}}; /* down, up */
  MPI_Request request[2];
  PetscInt    stay = 0;
  PetscMPIInt len, rank;

  PetscFunctionBeginUser;
  for (PetscInt q = 0; q < t->n; q++) {
    const char *from = t->at + (size_t)q * t->bytes;
    PetscInt    hops;

    memcpy(&rank, from, sizeof rank);
    hops = MPMSpatialHops(s, mpm->grid.periodic, d, rank);
    if (hops) {
      Transit *to = &out[hops > 0];

      PetscCall(MakeRoom(to, to->n + 1));
      memcpy(to->at + (size_t)to->n++ * t->bytes, from, t->bytes);
    } else
      memmove(t->at + (size_t)stay++ * t->bytes, from, t->bytes);
  }
  t->n = stay;
  for (int up = 0; up < 2; up++) {
    PetscCall(MPMMessageLength((size_t)out[up].n * t->bytes, &len));
    PetscCallMPI(MPI_Isend(out[up].at, len, MPI_BYTE, s->beside[d][up], MPM_TAG_MIGRATE + up, s->comm, &request[up]));
  }
  for (int up = 0; up < 2; up++) { /* what goes up comes from below */
    MPI_Status status;

    PetscCallMPI(MPI_Probe(s->beside[d][!up], MPM_TAG_MIGRATE + up, s->comm, &status));
    PetscCallMPI(MPI_Get_count(&status, MPI_BYTE, &len));
    PetscCall(MakeRoom(t, t->n + (PetscInt)((size_t)len / t->bytes)));
    PetscCallMPI(MPI_Recv(t->at ? t->at + (size_t)t->n * t->bytes : NULL, len, MPI_BYTE, s->beside[d][!up],
                          MPM_TAG_MIGRATE + up, s->comm, MPI_STATUS_IGNORE));
    t->n += (PetscInt)((size_t)len / t->bytes);
  }
  PetscCallMPI(MPI_Waitall(2, request, MPI_STATUSES_IGNORE));
  for (int up = 0; up < 2; up++) PetscCall(PetscFree(out[up].at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* By our own messages: leavers go from box to box, along one axis after the other, mostly one box on each (status.hops
   has the most of all processes); comers fill the holes and the end. Collective.                                     */
PetscErrorCode MPMMigrateDirect(MPM mpm, MPMSpatial *s)
{
  MPMPoints     *pts = &mpm->points;
  const PetscInt n = pts->n, nsend = s->nleavers;
  void          *at[MPM_NUM_FIELDS] = {NULL};
  Transit        t                  = {.bytes = sizeof *s->owner + (size_t)MPMPointsBytes(pts, MPM_SWARM)};

  PetscFunctionBeginUser;
  PetscCall(CountOut(mpm, s));
  PetscCall(MakeRoom(&t, nsend + 1));
  PetscCall(GetFields(pts, PETSC_FALSE, at));
  for (; t.n < nsend; t.n++) {
    memcpy(t.at + (size_t)t.n * t.bytes, &s->owner[t.n], sizeof *s->owner);
    PackPoint(pts, at, s->leaver[t.n], t.at + (size_t)t.n * t.bytes + sizeof *s->owner, PETSC_FALSE);
  }
  PetscCall(GetFields(pts, PETSC_TRUE, at));
  for (PetscInt d = 0; d < mpm->grid.dim; d++)
    for (PetscInt64 hop = 0; s->p[d] > 1 && hop < mpm->status.hops; hop++) PetscCall(PassOn(mpm, s, d, &t));
  if (t.n > nsend) PetscCall(MPMPointsSetSize(pts, n + t.n - nsend));
  PetscCall(GetFields(pts, PETSC_FALSE, at));
  for (PetscInt q = 0; q < t.n; q++)
    PackPoint(pts, at, q < nsend ? s->leaver[q] : n + q - nsend, t.at + (size_t)q * t.bytes + sizeof *s->owner,
              PETSC_TRUE);
  for (PetscInt q = nsend; q > t.n; q--) { /* the last points move into the holes that are left, the last hole first */
    const PetscInt hole = s->leaver[q - 1], last = n - 1 - (nsend - q);

    if (hole == last) continue;
    PackPoint(pts, at, last, t.at, PETSC_FALSE);
    PackPoint(pts, at, hole, t.at, PETSC_TRUE);
  }
  PetscCall(GetFields(pts, PETSC_TRUE, at));
  if (t.n < nsend) PetscCall(MPMPointsSetSize(pts, n + t.n - nsend));
  MPMSimulateWork("LEAVER", 0.5 * (PetscReal)(nsend + t.n));
  PetscCall(LocateComers(mpm, s));
  PetscCall(PetscFree(t.at));
  PetscFunctionReturn(PETSC_SUCCESS);
}
