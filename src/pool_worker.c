/* pool_worker.c - the worker's half of the pool, and the making of its messages, which the master uses too. */
#include "cell.h"
#include "exchange_pool.h"

/* The box of nodes that a patch with these own nodes needs: what its points' stencils reach. */
void MPMPoolBox(MPM mpm, const PetscInt own_lo[3], const PetscInt own_n[3], PetscBool to_nodes, MPMPatch *patch)
{
  const PetscInt reach = MPMBasisNodes(mpm->basis) - 1;

  patch->grid  = &mpm->grid;
  patch->basis = mpm->basis;
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt below = d < mpm->grid.dim && to_nodes ? reach : 0, above = d < mpm->grid.dim ? reach : 0;

    patch->own_lo[d] = own_lo[d];
    patch->own_n[d]  = own_n[d];
    patch->lo[d]     = own_lo[d] - below;
    patch->n[d]      = own_n[d] + below + above;
  }
}

/* Size of the answer to a chunk: its status, then node sums or points. */
size_t MPMPoolAnswerBytes(MPM mpm, const MPMPhase *phase, const PetscInt own_n[3], PetscInt n)
{
  const PetscInt c0 = MPM_SUM_FIRST(mpm->grid.dim, phase->parts), c1 = MPM_SUM_LAST(mpm->grid.dim, phase->parts);

  if (phase->kind == MPM_NODES_TO_POINTS)
    return sizeof(MPMStatus) + (size_t)n * MPMMessagePointBytes(&mpm->points, phase->points_out);
  return sizeof(MPMStatus) + (size_t)(own_n[0] * own_n[1] * own_n[2] * (c1 - c0)) * sizeof(PetscReal);
}

/* Packs fields of the listed points, field by field: p < n of `at`, else p - n of `halo`. */
char *MPMPoolPack(const MPMPoints *pts, PetscInt fields, void *const at[], void *const halo[], PetscInt n,
                  PetscInt count, const PetscInt *list, char *message)
{
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const size_t b = (size_t)pts->bytes[f];

    if (!pts->present[f] || !(fields & (1 << f))) continue;
    for (PetscInt q = 0; q < count; q++, message += b) {
      const PetscInt p = list[q];
      memcpy(message, p < n ? (char *)at[f] + (size_t)p * b : (char *)halo[f] + (size_t)(p - n) * b, b);
    }
  }
  return message;
}

typedef struct {
  MPMPatch  patch;
  void     *field[MPM_NUM_FIELDS];
  PetscInt *identity, capacity;
  char     *in, *out, *nodes;
  size_t    in_capacity, out_capacity, nodes_capacity;
} Desk;

/* Makes a patch of what came: points in (cell, id) order, so their order is the identity. */
static PetscErrorCode Unpack(MPM mpm, const MPMPhase *phase, const MPMOrder *order, const char *m, Desk *desk)
{
  MPMPatch        *patch    = &desk->patch;
  const MPMPoints *pts      = &mpm->points;
  const PetscBool  to_nodes = phase->kind == MPM_POINTS_TO_NODES ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt   fields = phase->points_in | phase->points_out, n = order->n, dim = mpm->grid.dim;
  size_t           sums, vels;

  PetscFunctionBeginUser;
  MPMPoolBox(mpm, order->own_lo, order->own_n, to_nodes, patch);
  if (n > desk->capacity) {
    desk->capacity = n * 5 / 4 + 64;
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      if (!pts->present[f]) continue;
      PetscCall(PetscFree(desk->field[f]));
      PetscCall(PetscMalloc(desk->capacity * pts->bytes[f], &desk->field[f]));
    }
    PetscCall(PetscFree(desk->identity));
    PetscCall(PetscMalloc1(desk->capacity, &desk->identity));
    for (PetscInt p = 0; p < desk->capacity; p++) desk->identity[p] = p;
  }
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    if (!pts->present[f] || !(phase->points_in & (1 << f))) continue;
    memcpy(desk->field[f], m, (size_t)n * (size_t)pts->bytes[f]);
    m += (size_t)n * (size_t)pts->bytes[f];
  }
  PetscCall(PetscMemzero(&patch->points, sizeof patch->points));
  PetscCall(PetscMemzero(&patch->halo, sizeof patch->halo));
  patch->points.n = patch->norder = n;
  patch->order = patch->own_order = desk->identity;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  if (fields & MPM_BIT(name)) patch->points.name = (ctype *)desk->field[MPM_FIELD_INDEX_##name];
#include "fields.def"
#undef MPM_FIELD
  sums = (size_t)MPMPatchCells(patch) * MPM_SUM_NC(dim) * sizeof(PetscReal);
  vels = (size_t)MPMPatchCells(patch) * MPM_VEL_NC(dim) * sizeof(PetscReal);
  PetscCall(MPMMessageRoom(&desk->nodes, &desk->nodes_capacity,
                           sums + vels + MPM_LINE + (size_t)(patch->n[1] * patch->n[2]) * sizeof *patch->span));
  patch->sum  = (PetscReal *)MPMAlign(desk->nodes);
  patch->vel  = (PetscReal *)((char *)patch->sum + sums);
  patch->span = (PetscInt(*)[2])((char *)patch->vel + vels);
  MPMPatchMarkAll(patch);
  if (!to_nodes) memcpy(patch->vel, m, vels);
  for (PetscInt p = 0; p < n; p++) { /* came numbered over the master's arrays */
    const PetscInt c      = patch->points.cell[p];
    const PetscInt ijk[3] = {c % order->all_n[0] + order->all_lo[0],
                             c / order->all_n[0] % order->all_n[1] + order->all_lo[1],
                             c / (order->all_n[0] * order->all_n[1]) + order->all_lo[2]};

    patch->points.cell[p] = MPMNodeIndex((int)dim, patch, ijk);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The cells that the kernel found are those of the patch; the master numbers them over its own arrays. */
static void RenumberCells(MPM mpm, const MPMOrder *order, MPMPatch *patch)
{
  const PetscInt dim = mpm->grid.dim;
  MPMPatch       all;

  for (PetscInt d = 0; d < 3; d++) {
    all.lo[d] = order->all_lo[d];
    all.n[d]  = order->all_n[d];
  }
  for (PetscInt p = 0; p < patch->points.n; p++) {
    PetscReal xi[3];
    PetscInt  base[3] = {0};

    patch->points.cell[p] = MPMLocate((int)dim, mpm->basis, &mpm->grid, patch->points.x + p * dim,
                                      MPMHalfWidths((int)dim, mpm->scene.kinds, &patch->points, p), xi, base)
                                ? MPMNodeIndex((int)dim, &all, base)
                                : -1;
  }
}

/* Packs the answer; returns its end. */
static char *PackAnswer(MPM mpm, const MPMPhase *phase, const MPMStatus *status, const Desk *desk, char *m)
{
  const MPMPatch *patch = &desk->patch;
  const PetscInt  nc    = MPM_SUM_NC(mpm->grid.dim);
  const PetscInt  c0 = MPM_SUM_FIRST(mpm->grid.dim, phase->parts), c1 = MPM_SUM_LAST(mpm->grid.dim, phase->parts);

  memcpy(m, status, sizeof *status);
  m += sizeof *status;
  if (phase->kind == MPM_NODES_TO_POINTS)
    return MPMPoolPack(&mpm->points, phase->points_out, desk->field, NULL, patch->points.n, patch->points.n,
                       desk->identity, m);
  for (PetscInt k = patch->own_lo[2]; k < patch->own_lo[2] + patch->own_n[2]; k++)
    for (PetscInt j = patch->own_lo[1]; j < patch->own_lo[1] + patch->own_n[1]; j++)
      for (PetscInt i = patch->own_lo[0]; i < patch->own_lo[0] + patch->own_n[0];
           i++, m += (size_t)(c1 - c0) * sizeof(PetscReal))
        memcpy(m,
               patch->sum +
                   (((k - patch->lo[2]) * patch->n[1] + j - patch->lo[1]) * patch->n[0] + i - patch->lo[0]) * nc + c0,
               (size_t)(c1 - c0) * sizeof(PetscReal));
  return m;
}

/* A worker's life: receive a patch, run the phase, answer; until the master says that the run is over. */
PetscErrorCode MPMPoolServe(MPM mpm, MPI_Comm comm)
{
  Desk        desk   = {0};
  MPI_Request answer = MPI_REQUEST_NULL;

  PetscFunctionBeginUser;
  for (;;) {
    MPI_Status      probed;
    PetscMPIInt     len;
    MPMOrder        order;
    const MPMPhase *phase;
    MPMStatus       status;

    PetscCallMPI(MPI_Probe(0, MPM_TAG_WORK, comm, &probed));
    PetscCallMPI(MPI_Get_count(&probed, MPI_BYTE, &len));
    PetscCall(MPMMessageRoom(&desk.in, &desk.in_capacity, (size_t)len));
    PetscCallMPI(MPI_Recv(desk.in, len, MPI_BYTE, 0, MPM_TAG_WORK, comm, MPI_STATUS_IGNORE));
    memcpy(&order, desk.in, sizeof order);
    if (order.phase < 0) break;
    phase          = &mpm->phases[order.phase];
    mpm->params.dt = order.dt;
    PetscCall(MPMPhaseBegin(mpm, phase));
    MPMWorkBegin(mpm);
    PetscCall(Unpack(mpm, phase, &order, desk.in + sizeof order, &desk));
    MPMWorkEnd(mpm, order.phase);
    MPMSimulateWork("UNPACK", (PetscReal)len);
    MPMStatusReset(&status);
    PetscCall(MPMPatchRun(mpm, &desk.patch, phase, &status));
    if (phase->points_out & MPM_BIT(cell)) {
      RenumberCells(mpm, &order, &desk.patch);
      MPMSimulateWork("RENUMBER", order.n);
    }
    PetscCallMPI(MPI_Wait(&answer, MPI_STATUS_IGNORE));
    PetscCall(MPMMessageRoom(&desk.out, &desk.out_capacity, MPMPoolAnswerBytes(mpm, phase, order.own_n, order.n)));
    MPMWorkBegin(mpm);
    len = (PetscMPIInt)(PackAnswer(mpm, phase, &status, &desk, desk.out) - desk.out);
    MPMWorkEnd(mpm, order.phase);
    MPMSimulateWork("CHUNK", 1);
    MPMSimulateWork("ANSWER", (PetscReal)len);
    PetscCallMPI(MPI_Isend(desk.out, len, MPI_BYTE, 0, MPM_TAG_DONE, comm, &answer));
    PetscCall(MPMPhaseEnd(mpm, phase, order.n));
  }
  PetscCallMPI(MPI_Wait(&answer, MPI_STATUS_IGNORE));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) PetscCall(PetscFree(desk.field[f]));
  PetscCall(PetscFree(desk.identity));
  PetscCall(PetscFree(desk.in));
  PetscCall(PetscFree(desk.out));
  PetscCall(PetscFree(desk.nodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}
