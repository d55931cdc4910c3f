/* worker.c - what a worker of the pool does in a transfer, and the making of messages, which the master uses too. */
#include "base/message.h"
#include "base/signals.h"
#include "base/simulate.h"
#include "kernels/cell.h"
#include "parallel/pool.h"
#include "particles/poison.h"

/* Sets the boxes of a patch with these own nodes: the nodes that the stencils of its particles reach, up to the end of
   the grid, and its tiles. Not collective. */
void MPMPoolBox(MPMCore *core, const PetscInt own_lo[3], const PetscInt own_n[3], MPMPatch *patch)
{
  const PetscInt reach = MPMBasisNodes(core->basis) - 1, edge = MPMTileEdge(core->basis);

  patch->tiles.bits = MPM_TILE_BITS(reach + 1);
  patch->grid       = &core->grid;
  patch->basis      = core->basis;
  for (PetscInt d = 0; d < 3; d++) {
    patch->own_lo[d] = patch->lo[d] = own_lo[d];
    patch->own_n[d]                 = own_n[d];
    patch->n[d]                     = own_n[d] + reach;
    if (!core->grid.periodic[d])
      patch->n[d] = PetscMin(patch->n[d], core->grid.nodes[d] - core->grid.layers[d] - own_lo[d]);
    patch->tiles.n[d]     = (own_n[d] + edge - 1) / edge;
    patch->tiles.below[d] = 0;
  }
}

/* Returns the bytes of the answer to a job of n particles in so many tiles: the status, then sums or fields. */
size_t MPMPoolAnswerBytes(MPMCore *core, const MPMPhase *phase, PetscInt n, PetscInt tiles)
{
  PetscInt which[MPM_NODE_NUMBERS];

  if (phase->kind == MPM_NODES_TO_PARTICLES)
    return sizeof(MPMStatus) + (size_t)n * MPMParticlesRowBytes(&core->particles, phase->particles_out);
  return sizeof(MPMStatus) + (size_t)tiles * MPMTileNodes(core->grid.dim, core->basis) *
                                 (size_t)MPMNodeSums(core->grid.dim, phase->parts, which) * sizeof(PetscReal);
}

/* Packs fields (bits) of n listed particles, field by field; at: array of each field. Returns the end of the
   message. */
char *MPMPoolPack(const MPMParticles *particles, PetscInt fields, void *const at[], PetscInt n, const PetscInt *list,
                  char *message)
{
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const size_t b = (size_t)particles->bytes[f];

    if (!particles->present[f] || !(fields & (1 << f))) continue;
    for (PetscInt q = 0; q < n; q++, message += b) memcpy(message, (char *)at[f] + (size_t)list[q] * b, b);
  }
  return message;
}

/* A worker's memory, which is used again for each job. */
typedef struct {
  MPMPatch  patch;
  void     *field[MPM_NUM_FIELDS];     /* [capacity][components] of the particles */
  PetscInt *identity, capacity;        /* [capacity] 0, 1, 2, ... */
  MPMRange  all;                       /* the run of all particles */
  char     *in, *out, *nodes, *motion; /* job, answer, sums of tiles, motion of nodes */
  size_t    in_capacity, out_capacity, nodes_capacity, motion_capacity; /* bytes */
} Memory;

/* Gives the patch's tiles with particles memory for their sums, and renumbers the particles' cells over the patch's
   tiles: in the job they are numbered over the master's. */
static PetscErrorCode PlaceTiles(MPMCore *core, const MPMPhase *phase, const MPMJob *job, Memory *memory)
{
  MPMPatch      *patch = &memory->patch;
  MPMTiles      *t     = &patch->tiles;
  const int      dim   = (int)core->grid.dim;
  const PetscInt tiles = t->n[0] * t->n[1] * t->n[2];
  const MPMTiles all   = {.bits = t->bits, .n = {job->tiles[0], job->tiles[1], job->tiles[2]}};
  const size_t   slots = ((size_t)tiles * sizeof *t->slot + MPM_LINE - 1) / MPM_LINE * MPM_LINE;

  PetscFunctionBeginUser;
  t->lines = MPMNodeLines(phase->parts);
  PetscCall(MPMMessageRoom(&memory->nodes, &memory->nodes_capacity,
                           slots + MPM_LINE +
                               (size_t)PetscMin(tiles, job->n) * MPMTileNodes(core->grid.dim, core->basis) *
                                   (size_t)(t->lines * MPM_NODE_NC) * sizeof(PetscReal)));
  t->slot = (PetscInt *)MPMAlign(memory->nodes);
  t->sum  = (PetscReal *)((char *)t->slot + slots);
  for (PetscInt k = 0; k < tiles; k++) t->slot[k] = MPM_TILE_EMPTY;
  t->n_own = 0;
  for (PetscInt p = 0; p < job->n; p++) {
    PetscInt       at[3];
    const PetscInt tile   = MPMTileOf(dim, &all, patch->particles.cell[p], at);
    const PetscInt ijk[3] = {tile % all.n[0] - job->first[0], tile / all.n[0] % all.n[1] - job->first[1],
                             tile / (all.n[0] * all.n[1]) - job->first[2]};

    for (PetscInt d = 0; d < dim; d++) at[d] += ijk[d] << t->bits;
    patch->particles.cell[p]                                = MPMTileCell(dim, t, at);
    t->slot[(ijk[2] * t->n[1] + ijk[1]) * t->n[0] + ijk[0]] = MPM_TILE_SCRATCH;
  }
  for (PetscInt k = 0; k < tiles; k++)
    if (t->slot[k] == MPM_TILE_SCRATCH) t->slot[k] = t->n_own++;
  t->nslots = t->n_early   = t->n_own;
  t->nruns[MPM_PASS_EARLY] = 1;
  t->runs[MPM_PASS_EARLY]  = &memory->all;
  memory->all              = (MPMRange){0, job->n, 0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a patch of a job. Its particles are sorted by (cell, id), so their order is the identity. */
static PetscErrorCode Unpack(MPMCore *core, const MPMPhase *phase, const MPMJob *job, const char *m, Memory *memory)
{
  MPMPatch           *patch     = &memory->patch;
  const MPMParticles *particles = &core->particles;
  const PetscBool     to_nodes  = phase->kind == MPM_PARTICLES_TO_NODES;
  const PetscInt      fields = phase->particles_in | phase->particles_out, n = job->n, dim = core->grid.dim;

  PetscFunctionBeginUser;
  MPMPoolBox(core, job->own_lo, job->own_n, patch);
  if (n > memory->capacity) {
    memory->capacity = n * 5 / 4 + 64;
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      if (!particles->present[f]) continue;
      PetscCall(PetscFree(memory->field[f]));
      PetscCall(PetscMalloc((size_t)memory->capacity * (size_t)particles->bytes[f], &memory->field[f]));
    }
    PetscCall(PetscFree(memory->identity));
    PetscCall(PetscMalloc1(memory->capacity, &memory->identity));
    for (PetscInt p = 0; p < memory->capacity; p++) memory->identity[p] = p;
  }
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    if (particles->present[f]) MPMPoison(memory->field[f], (size_t)n * (size_t)particles->bytes[f]);
    if (!particles->present[f] || !(phase->particles_in & (1 << f))) continue;
    memcpy(memory->field[f], m, (size_t)n * (size_t)particles->bytes[f]);
    m += (size_t)n * (size_t)particles->bytes[f];
  }
  PetscCall(PetscMemzero(&patch->particles, sizeof patch->particles));
  patch->particles.n = n;
  patch->order       = memory->identity;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  if (fields & MPM_BIT(name)) patch->particles.name = (ctype *)memory->field[MPM_FIELD_INDEX_##name];
#include "physics/fields.def"
  if (MPMPoolReads(phase)) {
    const size_t motions = (size_t)MPMPatchNodes(patch) * MPM_MOTION_NC(dim) * sizeof(PetscReal);

    PetscCall(MPMMessageRoom(&memory->motion, &memory->motion_capacity, motions));
    patch->motion = (PetscReal *)memory->motion;
    memcpy(patch->motion, m, motions);
  }
  if (to_nodes) PetscCall(PlaceTiles(core, phase, job, memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers the new cells of the particles over the master's tiles. */
static void NumberCells(MPMCore *core, const MPMJob *job, MPMPatch *patch)
{
  const PetscInt dim = core->grid.dim;
  MPMPatch       all = *patch;

  for (PetscInt d = 0; d < 3; d++) { /* the box of all the master's tiles */
    all.tiles.n[d] = job->tiles[d];
    all.own_lo[d]  = job->own_lo[d] - job->first[d] * MPMTileEdge(core->basis);
    all.own_n[d]   = job->tiles[d] * MPMTileEdge(core->basis);
  }
  for (PetscInt p = 0; p < patch->particles.n; p++) {
    PetscInt base[3];

    patch->particles.cell[p] = MPMOwnCell(
        (int)dim, core->basis, &all, MPMKindOf(core->params.kinds, &patch->particles, p)->copy,
        patch->particles.x + p * dim, MPMHalfWidths((int)dim, core->params.kinds, &patch->particles, p), base);
  }
}

/* Packs the answer from m on, and returns its end. */
static char *PackAnswer(MPMCore *core, const MPMPhase *phase, const MPMStatus *status, const Memory *memory, char *m)
{
  const MPMPatch *patch = &memory->patch;

  memcpy(m, status, sizeof *status);
  m += sizeof *status;
  if (phase->kind == MPM_NODES_TO_PARTICLES)
    return MPMPoolPack(&core->particles, phase->particles_out, memory->field, patch->particles.n, memory->identity, m);
  for (PetscInt k = 0; k < patch->tiles.n_own; k++) m += MPMTilesCopy(patch, k, phase->parts, PETSC_TRUE, m);
  return m;
}

/* Receives jobs from the master, runs each job's phase and sends the answer, until the master says that the run is
   over. Every process of comm but the first calls it. */
PetscErrorCode MPMPoolServe(MPMCore *core, MPI_Comm comm)
{
  Memory      memory = {0};
  MPI_Request answer = MPI_REQUEST_NULL;

  PetscFunctionBeginUser;
  for (;;) {
    MPI_Status      probed;
    PetscMPIInt     len;
    MPMJob          job;
    const MPMPhase *phase;
    MPMStatus       status;

    PetscCallMPI(MPI_Probe(0, MPM_TAG_WORK, comm, &probed));
    PetscCallMPI(MPI_Get_count(&probed, MPI_BYTE, &len));
    PetscCall(MPMMessageRoom(&memory.in, &memory.in_capacity, (size_t)len));
    PetscCallMPI(MPI_Recv(memory.in, len, MPI_BYTE, 0, MPM_TAG_WORK, comm, MPI_STATUS_IGNORE));
    memcpy(&job, memory.in, sizeof job);
    if (job.phase < 0) break;
    phase             = &core->phases[job.phase];
    core->params.dt   = job.dt;
    core->params.kick = job.kick;
    core->params.flip = job.flip;
    core->params.push = job.push;
    PetscCall(PetscArraycpy(&core->params.plane[0][0], &job.plane[0][0], 12));
    core->grid.places = job.places;
    PetscCall(PetscArraycpy(core->grid.place, job.place, MPM_MAX_COPIES));
    PetscCall(PetscArraycpy(core->grid.low, job.low, MPM_MAX_COPIES));
    PetscCall(PetscArraycpy(core->grid.high, job.high, MPM_MAX_COPIES));
    MPMGridSetNodes(&core->grid, core->basis);
    PetscCall(MPMPhaseBegin(core, phase));
    MPMWorkBegin(&core->timers);
    PetscCall(Unpack(core, phase, &job, memory.in + sizeof job, &memory));
    MPMWorkEnd(&core->timers, phase->timer, "UNPACK", (PetscReal)len);
    MPMStatusReset(&status);
    status.asked = MPMSignalsAsked();
    PetscCall(MPMPatchRun(core, &memory.patch, phase,
                          phase->kind == MPM_PARTICLES_TO_NODES ? MPM_PASS_EARLY : MPM_PASS_MAIN, &status));
    if (phase->particles_out & MPM_BIT(cell)) {
      NumberCells(core, &job, &memory.patch);
      MPMSimulateWork("RENUMBER", job.n);
    }
    PetscCallMPI(MPI_Wait(&answer, MPI_STATUS_IGNORE));
    PetscCall(MPMMessageRoom(&memory.out, &memory.out_capacity,
                             MPMPoolAnswerBytes(core, phase, job.n, memory.patch.tiles.n_own)));
    MPMWorkBegin(&core->timers);
    len = (PetscMPIInt)(PackAnswer(core, phase, &status, &memory, memory.out) - memory.out);
    MPMWorkEnd(&core->timers, phase->timer, NULL, 0);
    MPMSimulateWork("JOB", 1);
    MPMSimulateWork("ANSWER", (PetscReal)len);
    PetscCallMPI(MPI_Isend(memory.out, len, MPI_BYTE, 0, MPM_TAG_DONE, comm, &answer));
    PetscCall(MPMPhaseEnd(core, phase, job.n));
  }
  PetscCallMPI(MPI_Wait(&answer, MPI_STATUS_IGNORE));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) PetscCall(PetscFree(memory.field[f]));
  PetscCall(PetscFree(memory.identity));
  PetscCall(PetscFree(memory.in));
  PetscCall(PetscFree(memory.out));
  PetscCall(PetscFree(memory.nodes));
  PetscCall(PetscFree(memory.motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}
