/* halo.c - halo points of the spatial decomposition: copies of the points of the cells just below a patch, which touch
   its own nodes. Which ones, and their place in the canonical order, is settled once a step; phases then refresh the
   fields that they declare.                                                                                          */
#include "cell.h"
#include "exchange_spatial.h"

/* The fields of the halo points, as kernels see them. */
MPMView MPMHaloView(const MPMSpatial *s, PetscInt fields)
{
  MPMView view = {.n = s->nhalo};

#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  if (fields & MPM_BIT(name)) view.name = (ctype *)s->halo[MPM_FIELD_INDEX_##name];
#include "fields.def"
#undef MPM_FIELD
  return view;
}

/* Lists the points of the cells that neighbour `to` needs, in (cell, id) order, from the order of the points. */
static PetscErrorCode ListPoints(MPM mpm, MPMNeighbour *to)
{
  const MPMPatch  *patch = &mpm->exchange.patch;
  const MPMPoints *pts   = &mpm->points;

  PetscFunctionBeginUser;
  for (int pass = 0; pass < 2; pass++) {
    to->n = 0;
    for (PetscInt k = to->lo[2]; k < to->hi[2]; k++)
      for (PetscInt j = to->lo[1]; j < to->hi[1]; j++) {
        const PetscInt row = ((k - patch->lo[2]) * patch->n[1] + j - patch->lo[1]) * patch->n[0] - patch->lo[0];
        const PetscInt a = pts->start[row + to->lo[0]], b = pts->start[row + to->hi[0]];

        if (pass) PetscCall(PetscArraycpy(to->list + to->n, pts->order + a, b - a));
        to->n += b - a;
      }
    if (!pass && to->n > to->capacity) {
      to->capacity = to->n + to->n / 4 + 64;
      PetscCall(PetscFree(to->list));
      PetscCall(PetscMalloc1(to->capacity, &to->list));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sends fields (bits) of my listed points and receives those of the halo points: one message a neighbour. Collective on
   neighbours.                                                                                                        */
PetscErrorCode MPMHaloExchange(MPM mpm, MPMSpatial *s, PetscInt fields)
{
  const MPMPoints *pts                 = &mpm->points;
  const size_t     bytes               = MPMMessagePointBytes(pts, fields);
  void            *own[MPM_NUM_FIELDS] = {NULL};
  MPI_Request      request[2 * MPM_MAX_NEIGHBOURS];
  size_t           need = 0, at = 0;
  int              n = 0;

  PetscFunctionBeginUser;
  for (int k = 0; k < s->nto; k++) need += bytes * (size_t)s->to[k].n;
  PetscCall(MPMMessageRoom(&s->out, &s->out_capacity, need));
  PetscCall(MPMMessageRoom(&s->in, &s->in_capacity, bytes * (size_t)s->nhalo));
  for (int k = 0; k < s->nfrom; k++) {
    PetscMPIInt len;

    PetscCall(MPMMessageLength(bytes * (size_t)s->from[k].n, &len));
    if (len)
      PetscCallMPI(MPI_Irecv(s->in + at, len, MPI_BYTE, s->from[k].rank, s->from[k].tag, s->comm, &request[n++]));
    at += (size_t)len;
  }
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    if (!pts->present[f] || !(fields & (1 << f))) continue;
    own[f] = pts->scratch[f];
    if (MPMFields[f].home != MPM_SCRATCH)
      PetscCall(DMSwarmGetField(pts->swarm, MPMFields[f].name, NULL, NULL, &own[f]));
  }
  at = 0;
  for (int k = 0; k < s->nto; k++) {
    char       *message = s->out + at;
    PetscMPIInt len;

    PetscCall(MPMMessageLength(bytes * (size_t)s->to[k].n, &len));
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      const PetscInt b = pts->bytes[f];

      if (!own[f]) continue;
      for (PetscInt q = 0; q < s->to[k].n; q++, at += (size_t)b)
        memcpy(s->out + at, (char *)own[f] + s->to[k].list[q] * b, (size_t)b);
    }
    if (len) PetscCallMPI(MPI_Isend(message, len, MPI_BYTE, s->to[k].rank, s->to[k].tag, s->comm, &request[n++]));
  }
  MPMSimulateWork("PACK", (PetscReal)at);
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (own[f] && MPMFields[f].home != MPM_SCRATCH)
      PetscCall(DMSwarmRestoreField(pts->swarm, MPMFields[f].name, NULL, NULL, &own[f]));
  PetscCallMPI(MPI_Waitall(n, request, MPI_STATUSES_IGNORE));
  at = 0;
  for (int k = 0, first = 0; k < s->nfrom; first += (int)s->from[k++].n)
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      const size_t len = (size_t)(s->from[k].n * pts->bytes[f]);

      if (!pts->present[f] || !(fields & (1 << f)) || !len) continue;
      memcpy((char *)s->halo[f] + (size_t)first * (size_t)pts->bytes[f], s->in + at, len);
      at += len;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tells the neighbours how many points come, and makes room for theirs. */
static PetscErrorCode ExchangeCounts(MPM mpm, MPMSpatial *s)
{
  MPI_Request request[2 * MPM_MAX_NEIGHBOURS];
  int         n = 0;

  PetscFunctionBeginUser;
  for (int k = 0; k < s->nfrom; k++)
    PetscCallMPI(MPI_Irecv(&s->from[k].n, 1, MPIU_INT, s->from[k].rank, s->from[k].tag, s->comm, &request[n++]));
  for (int k = 0; k < s->nto; k++)
    PetscCallMPI(MPI_Isend(&s->to[k].n, 1, MPIU_INT, s->to[k].rank, s->to[k].tag, s->comm, &request[n++]));
  PetscCallMPI(MPI_Waitall(n, request, MPI_STATUSES_IGNORE));
  s->nhalo = 0;
  for (int k = 0; k < s->nfrom; k++) s->nhalo += s->from[k].n;
  if (s->nhalo > s->halo_capacity) {
    s->halo_capacity = s->nhalo + s->nhalo / 4 + 64;
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      if (!mpm->points.present[f]) continue;
      PetscCall(PetscFree(s->halo[f]));
      PetscCall(PetscMalloc(s->halo_capacity * mpm->points.bytes[f], &s->halo[f]));
    }
  }
  if (s->nhalo + mpm->points.n > s->order_capacity) {
    s->order_capacity = (s->nhalo + mpm->points.n) * 5 / 4 + 64;
    PetscCall(PetscFree(s->order));
    PetscCall(PetscMalloc1(s->order_capacity, &s->order));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* order = own and halo points by (cell, id). A cell's points all come from one process, each process sends its own in
   that order, so this is a counting sort without comparisons.                                                        */
static PetscErrorCode MergeOrder(MPM mpm, MPMSpatial *s)
{
  const MPMPoints *pts   = &mpm->points;
  MPMPatch        *patch = &mpm->exchange.patch;
  const PetscInt   dim = mpm->grid.dim, ncells = MPMPatchCells(patch);
  const MPMView    halo = MPMHaloView(s, MPM_STEADY);
  PetscInt        *cell = (PetscInt *)s->halo[MPM_FIELD_INDEX_cell], from = 0, room = 0;

  PetscFunctionBeginUser;
  if (!s->start) {
    PetscCall(PetscMalloc2(ncells + 1, &s->start, ncells, &s->count));
    PetscCall(PetscArrayzero(s->count, ncells));
  }
  for (PetscInt k = 0, p = 0; k < s->nfrom; k++)
    for (PetscInt q = 0; q < s->from[k].n; q++, p++) {
      PetscReal xi[3];
      PetscInt  base[3] = {0};

      MPMCoordinates((int)dim, mpm->basis, &mpm->grid, halo.x + p * dim,
                     MPMHalfWidths((int)dim, mpm->scene.kinds, &halo, p), xi, base);
      for (PetscInt d = 0; d < dim; d++) base[d] += s->from[k].shift[d];
      cell[p] = MPMNodeIndex((int)dim, patch, base);
      s->count[cell[p]]++;
    }
  for (PetscInt c = 0; c < ncells; c++) {
    s->start[c] = pts->start[c] + room;
    if (!s->count[c]) continue; /* own points are copied as far as a cell that halo points come to */
    PetscCall(PetscArraycpy(s->order + from + room, pts->order + from, pts->start[c + 1] - from));
    from = pts->start[c + 1];
    room += s->count[c];
  }
  PetscCall(PetscArraycpy(s->order + from + room, pts->order + from, pts->n - from));
  s->start[ncells] = pts->n + room;
  for (PetscInt p = 0; p < s->nhalo; p++) s->order[s->start[cell[p] + 1] - s->count[cell[p]]--] = pts->n + p;
  MPMPatchMarkRows(patch, s->start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives the halo points their steady fields; if a point of any process changed cell, after finding them anew, and then
   the order of all points too. Collective on neighbours.                                                             */
PetscErrorCode MPMHaloUpdate(MPM mpm, MPMSpatial *s, PetscBool changed)
{
  PetscFunctionBeginUser;
  if (changed) {
    for (int k = 0; k < s->nto; k++) PetscCall(ListPoints(mpm, &s->to[k]));
    PetscCall(ExchangeCounts(mpm, s));
  }
  PetscCall(MPMHaloExchange(mpm, s, MPM_STEADY & ~MPM_BIT(cell)));
  MPMWorkBegin(mpm);
  if (changed) PetscCall(MergeOrder(mpm, s));
  MPMWorkEnd(mpm, MPM_TIMER_SETTLE);
  PetscFunctionReturn(PETSC_SUCCESS);
}
