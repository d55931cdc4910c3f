/* migrate.c - points that left their patch go to the process that owns their cell. Both ways give the same points on
   the same processes, so the same bits; only messages and time differ.                                               */
#include "cell.h"
#include "exchange_spatial.h"

/* The process that owns the cell where point p of the view is now. */
static PetscErrorCode FindOwner(MPM mpm, const MPMSpatial *s, const MPMView *view, PetscInt p, PetscInt *owner)
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

/* Finds the cells of the points that came: their cell, which travels with them, is still that of a leaver. They are
   where leavers (which [nleavers]) were, or at the end, as may be points that were here already. */
static PetscErrorCode LocateComers(MPM mpm, PetscInt nleavers, const PetscInt which[])
{
  const PetscInt  dim = mpm->grid.dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(cell) | MPM_BIT(kind) | MPM_BIT(l);
  const MPMPatch *patch = &mpm->exchange.patch;
  MPMPoints      *pts   = &mpm->points;
  MPMView         view;

  PetscFunctionBeginUser;
  pts->nkept -= nleavers;
  PetscCall(MPMPointsGetView(pts, fields, &view));
  for (PetscInt q = 0; q < nleavers + view.n - pts->nkept; q++) {
    const PetscInt p       = q < nleavers ? which[q] : pts->nkept + q - nleavers;
    PetscInt       base[3] = {0};

    if (p >= view.n || view.cell[p] >= 0) continue;
    view.cell[p] = MPMOwnCell((int)dim, mpm->basis, patch, view.x + p * dim,
                              MPMHalfWidths((int)dim, mpm->scene.kinds, &view, p), base);
    PetscCheck(view.cell[p] >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "point %" PetscInt64_FMT " came to the wrong process", view.id[p]);
  }
  PetscCall(MPMPointsRestoreView(pts, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* By PETSc: DMSwarmMigrate on the BASIC swarm with the owners that we found. Exact, to any process, at the price of
   eleven collectives a call. Collective.                                                                             */
PetscErrorCode MPMMigrateSwarm(MPM mpm, MPMSpatial *s)
{
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(cell) | MPM_BIT(kind) | MPM_BIT(l);
  MPMPoints     *pts    = &mpm->points;
  PetscInt      *owner, nleavers, *which;
  MPMView        view;
  PetscMPIInt    me;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(s->comm, &me));
  PetscCall(MPMPointsLeavers(pts, &nleavers, &which));
  PetscCall(MPMPointsGetView(pts, fields, &view));
  PetscCall(DMSwarmGetField(pts->swarm, DMSwarmField_rank, NULL, NULL, (void **)&owner));
  if (!s->ranked) /* later, only leavers have another owner: the field travels with the points */
    for (PetscInt p = 0; p < view.n; p++) owner[p] = me;
  s->ranked = PETSC_TRUE;
  for (PetscInt q = 0; q < nleavers; q++) PetscCall(FindOwner(mpm, s, &view, which[q], &owner[which[q]]));
  PetscCall(DMSwarmRestoreField(pts->swarm, DMSwarmField_rank, NULL, NULL, (void **)&owner));
  PetscCall(MPMPointsRestoreView(pts, fields, &view));
  PetscCall(DMSwarmMigrate(pts->swarm, PETSC_TRUE));
  MPMSimulateWork("SWARM", 1);
  PetscCall(MPMPointsResize(pts));
  PetscCall(LocateComers(mpm, nleavers, which));
  PetscCall(PetscFree(which));
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

/* Sends the listed points, `bytes` each, to their owners, packed in that order in `out` (sorted by owner), and returns
   what came for this process in *in, which the caller frees. Destinations may be any processes: PetscCommBuildTwoSided
   finds who has something for whom. Collective on the communicator. */
static PetscErrorCode SendPoints(MPMSpatial *s, PetscInt bytes, PetscInt nsend, const PetscInt owner[],
                                 const char out[], PetscInt *nrecv, char **in)
{
  PetscMPIInt  nto = 0, nfrom, len, *to, *from;
  PetscInt    *count, *counts;
  MPI_Request *request;
  int          n = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(nsend, &to, nsend, &count));
  for (PetscInt q = 0; q < nsend; q++) {
    if (!q || owner[q] != owner[q - 1]) {
      to[nto]      = (PetscMPIInt)owner[q];
      count[nto++] = 0;
    }
    count[nto - 1]++;
  }
  PetscCall(PetscCommBuildTwoSided(s->comm, 1, MPIU_INT, nto, to, count, &nfrom, &from, &counts));
  *nrecv = 0;
  for (PetscMPIInt k = 0; k < nfrom; k++) *nrecv += counts[k];
  PetscCall(PetscMalloc1((size_t)*nrecv * (size_t)bytes, in));
  PetscCall(PetscMalloc1(nfrom + nto, &request));
  for (PetscInt k = 0, at = 0; k < nfrom; at += counts[k++]) {
    PetscCall(MPMMessageLength((size_t)counts[k] * (size_t)bytes, &len));
    PetscCallMPI(
        MPI_Irecv(*in + (size_t)at * (size_t)bytes, len, MPI_BYTE, from[k], MPM_TAG_MIGRATE, s->comm, &request[n++]));
  }
  for (PetscInt k = 0, at = 0; k < nto; at += count[k++]) {
    PetscCall(MPMMessageLength((size_t)count[k] * (size_t)bytes, &len));
    PetscCallMPI(
        MPI_Isend(out + (size_t)at * (size_t)bytes, len, MPI_BYTE, to[k], MPM_TAG_MIGRATE, s->comm, &request[n++]));
  }
  PetscCallMPI(MPI_Waitall(n, request, MPI_STATUSES_IGNORE));
  PetscCall(PetscFree(request));
  PetscCall(PetscFree(from));
  PetscCall(PetscFree(counts));
  PetscCall(PetscFree2(to, count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the points that left, ascending, and their owners: which [nsend], owner [nsend]; allocated here. */
static PetscErrorCode ListLeavers(MPM mpm, MPMSpatial *s, PetscInt *nsend, PetscInt **which, PetscInt **owner)
{
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(cell) | MPM_BIT(kind) | MPM_BIT(l);
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMPointsLeavers(&mpm->points, nsend, which));
  PetscCall(PetscMalloc1(*nsend, owner));
  PetscCall(MPMPointsGetView(&mpm->points, fields, &view));
  for (PetscInt q = 0; q < *nsend; q++) PetscCall(FindOwner(mpm, s, &view, (*which)[q], &(*owner)[q]));
  PetscCall(MPMPointsRestoreView(&mpm->points, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* By our own messages: leavers are packed, comers fill the holes and the end. Collective. */
PetscErrorCode MPMMigrateDirect(MPM mpm, MPMSpatial *s)
{
  MPMPoints     *pts   = &mpm->points;
  const PetscInt bytes = MPMPointsBytes(pts, MPM_SWARM);
  PetscInt       n = pts->n, nsend, nrecv = 0, *which, *owner, *sorted;
  void          *at[MPM_NUM_FIELDS] = {NULL};
  char          *out, *in;

  PetscFunctionBeginUser;
  PetscCall(ListLeavers(mpm, s, &nsend, &which, &owner));
  PetscCall(PetscMalloc2((size_t)nsend * (size_t)bytes, &out, nsend, &sorted));
  PetscCall(PetscArraycpy(sorted, which, nsend));
  PetscCall(PetscSortIntWithArray(nsend, owner, sorted));
  PetscCall(GetFields(pts, PETSC_FALSE, at));
  for (PetscInt q = 0; q < nsend; q++) PackPoint(pts, at, sorted[q], out + (size_t)q * (size_t)bytes, PETSC_FALSE);
  PetscCall(GetFields(pts, PETSC_TRUE, at));
  PetscCall(SendPoints(s, bytes, nsend, owner, out, &nrecv, &in));
  if (nrecv > nsend) PetscCall(MPMPointsSetSize(pts, n + nrecv - nsend));
  PetscCall(GetFields(pts, PETSC_FALSE, at));
  for (PetscInt q = 0; q < nrecv; q++)
    PackPoint(pts, at, q < nsend ? which[q] : n + q - nsend, in + (size_t)q * (size_t)bytes, PETSC_TRUE);
  for (PetscInt q = nsend; q > nrecv;
       q--) { /* the last points move into the holes that are left, the last hole first */
    const PetscInt hole = which[q - 1], last = n - 1 - (nsend - q);

    if (hole == last) continue;
    PackPoint(pts, at, last, out, PETSC_FALSE);
    PackPoint(pts, at, hole, out, PETSC_TRUE);
  }
  PetscCall(GetFields(pts, PETSC_TRUE, at));
  if (nrecv < nsend) PetscCall(MPMPointsSetSize(pts, n + nrecv - nsend));
  PetscCall(LocateComers(mpm, nsend, which));
  PetscCall(PetscFree(in));
  PetscCall(PetscFree2(out, sorted));
  PetscCall(PetscFree(which));
  PetscCall(PetscFree(owner));
  PetscFunctionReturn(PETSC_SUCCESS);
}
