/* exchange.c - what the ways to run a step share: they run a phase on the patch of this process. */
#include "base/message.h"
#include "base/pages.h"
#include "parallel/exchange.h"
#include "particles/poison.h"

PetscInt MPMExchangeLines(const MPMCore *core)
{
  PetscInt lines = 1;

  for (PetscInt k = 0; k < core->nprogram + core->nrare; k++)
    lines = PetscMax(lines, MPMNodeLines(core->program[k]->parts));
  return lines;
}

/* Creates a local vector of the motion of nodes, or of their state, which takes pages only where particles are. */
static PetscErrorCode CreateMotion(MPMExchange *ex, const char name[], Vec *v)
{
  PetscScalar *numbers;
  PetscInt     n;

  PetscFunctionBeginUser;
  PetscCall(DMCreateLocalVector(ex->da, v));
  PetscCall(PetscObjectSetName((PetscObject)*v, name));
  PetscCall(VecGetLocalSize(*v, &n));
  PetscCall(VecGetArray(*v, &numbers));
  MPMGivePagesBack(numbers, (size_t)n * sizeof *numbers);
  PetscCall(VecRestoreArray(*v, &numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeCreateGrid(MPMCore *core, const PetscInt parts[3], PetscInt *const widths[3])
{
  MPMExchange   *ex    = &core->exchange;
  const PetscInt reach = MPMBasisNodes(core->basis) - 1, lines = MPMExchangeLines(core);

  PetscFunctionBeginUser;
  PetscCall(MPMGridCreateDM(&core->grid, ex->data, core->params.light > 0 ? PetscMax(reach, MPM_LIGHT_LAYERS) : reach,
                            parts, widths, &ex->da));
  PetscCall(MPMPatchSetBox(&ex->patch, &core->grid, core->basis, ex->da, lines));
  PetscCall(CreateMotion(ex, "motion", &ex->motion));
  if (core->grid.total || core->implicit) {
    PetscCall(CreateMotion(ex, "state", &ex->state));
    PetscCall(VecGetArray(ex->state, &ex->patch.state)); /* as long as there is the vector */
  }
  for (PetscInt line = 0; line < lines; line++)
    PetscCall(MPMGridCreateSums(&ex->patch, ex->da, line, &ex->sums[line], &ex->node_sums[line]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeDestroyGrid(MPMCore *core)
{
  MPMExchange *ex = &core->exchange;

  PetscFunctionBeginUser;
  PetscCall(MPMLightDestroy(&ex->light));
  for (PetscInt line = 0; line < MPM_NODE_LINES; line++) PetscCall(VecDestroy(&ex->node_sums[line]));
  PetscCall(VecDestroy(&ex->motion));
  if (ex->state) PetscCall(VecRestoreArray(ex->state, &ex->patch.state));
  PetscCall(VecDestroy(&ex->state));
  PetscCall(MPMPatchDestroy(&ex->patch));
  for (PetscInt line = 0; line < MPM_NODE_LINES; line++) PetscCall(DMDestroy(&ex->sums[line]));
  PetscCall(DMDestroy(&ex->da));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeOpenNodes(MPMCore *core)
{
  MPMPatch    *patch = &core->exchange.patch;
  PetscScalar *sums;

  PetscFunctionBeginUser;
  PetscCall(VecGetArray(core->exchange.motion, &patch->motion));
  for (PetscInt line = patch->tiles.lines - 1; line >= 0; line--)
    PetscCall(VecGetArray(core->exchange.node_sums[line], &sums));
  patch->node = (MPMNode *)sums;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeCloseNodes(MPMCore *core)
{
  MPMPatch *patch = &core->exchange.patch;

  PetscFunctionBeginUser;
  for (PetscInt line = 0; line < patch->tiles.lines; line++) {
    PetscScalar *sums = (PetscScalar *)(patch->node + line * MPMPatchNodes(patch));

    PetscCall(VecRestoreArray(core->exchange.node_sums[line], &sums));
  }
  patch->node = NULL;
  PetscCall(VecRestoreArray(core->exchange.motion, &patch->motion));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Brings numbers of the nodes around this patch, `type` for each, from their owners. Collective on exchange.data. */
static PetscErrorCode Around(MPMExchange *ex, MPI_Datatype type, void *at)
{
  PetscFunctionBeginUser;
  if (!ex->around) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSFBcastBegin(ex->around, type, at, at, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(ex->around, type, at, at, MPI_REPLACE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeNodes(MPMCore *core, const MPMPhase *phase)
{
  MPMExchange    *ex    = &core->exchange;
  const PetscBool light = phase->light && core->params.light > 0;

  PetscFunctionBeginUser;
  if (light) {
    PetscCall(MPMLightMass(&ex->light, &ex->patch));
    PetscCall(Around(ex, MPIU_REAL, ex->light.mass));
    PetscCall(Around(ex, ex->record_type, ex->patch.node));
    PetscCall(MPMLightFind(&ex->light, &core->params, &ex->patch));
    MPMLightGive(&ex->light, &core->params, &ex->patch);
  }
  PetscCall(MPMPatchRun(core, &ex->patch, phase, MPM_PASS_MAIN, &core->status));
  if (light) {
    PetscCall(Around(ex, ex->motion_type, ex->patch.motion));
    MPMLightMove(&ex->light, &core->params, &ex->patch);
  }
  if (phase->after) PetscCall(phase->after(core, phase));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeOpen(MPMCore *core, const MPMPhase *phase)
{
  MPMPatch *patch = &core->exchange.patch;

  PetscFunctionBeginUser;
  if (phase->kind == MPM_NODES_TO_PARTICLES)
    PetscCall(MPMPoisonPhase(&core->particles, phase->particles_in, phase->particles_out));
  PetscCall(MPMParticlesGetView(&core->particles, phase->particles_in | phase->particles_out, &patch->particles));
  patch->order  = core->particles.order;
  patch->movers = core->particles.movers;
  PetscCall(MPMExchangeOpenNodes(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeClose(MPMCore *core, const MPMPhase *phase)
{
  MPMPatch *patch = &core->exchange.patch;

  PetscFunctionBeginUser;
  PetscCall(MPMExchangeCloseNodes(core));
  PetscCall(MPMParticlesRestoreView(&core->particles, phase->particles_in | phase->particles_out, &patch->particles));
  if (phase->kind == MPM_NODES_TO_PARTICLES)
    PetscCall(MPMPoisonCheck(&core->particles, phase->name, phase->particles_out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeRun(MPMCore *core, const MPMPhase *phase, MPMPass pass)
{
  MPMPatch *patch = &core->exchange.patch;

  PetscFunctionBeginUser;
  if (pass != MPM_PASS_MAIN && !patch->tiles.nruns[pass]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMExchangeOpen(core, phase));
  PetscCall(MPMPatchRun(core, patch, phase, pass, &core->status));
  if (phase->parts & MPM_G2P_COMMIT) core->particles.nmovers = patch->nmovers;
  PetscCall(MPMExchangeClose(core, phase));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeSort(MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, MPM_TIMER_SORT));
  MPMWorkBegin(&core->timers);
  PetscCall(MPMParticlesSort(&core->particles, &core->exchange.patch));
  MPMWorkEnd(&core->timers, MPM_TIMER_SORT, "SORT", (PetscReal)core->particles.n);
  PetscCall(MPMTimersEnd(&core->timers, MPM_TIMER_SORT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMExchangeRemove(MPMCore *core, PetscInt64 *ids)
{
  MPMParticles *particles = &core->particles;
  PetscInt64    gone[2]; /* how many, and their fingerprint */

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesRemove(particles, &gone[0], &gone[1]));
  *ids = gone[1];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, gone, 2, MPIU_INT64, MPI_SUM, core->exchange.data));
  particles->total -= gone[0];
  if (particles->ids) particles->ids = (PetscInt64)((uint64_t)particles->ids - (uint64_t)gone[1]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives a patch zeroed sums for all boxes of F-bar. Not collective. */
static PetscErrorCode OpenBoxes(MPMCore *core, MPMPatch *patch)
{
  const PetscInt box  = core->params.box;
  size_t         size = 2 * (size_t)core->params.nmaterials * sizeof *patch->boxes;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) size *= (size_t)((patch->own_n[d] + box - 1) / box);
  PetscCall(MPMMessageRoom(&core->exchange.boxes, &core->exchange.boxes_room, size));
  PetscCall(PetscMemzero(core->exchange.boxes, size));
  patch->boxes = (PetscReal *)core->exchange.boxes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs a phase on the patch, whose views hold the fields that the phase declares. pass: the tiles that a transfer from
   particles to nodes is for; other phases ignore it. Merges what it finds into status. Not collective. */
PetscErrorCode MPMPatchRun(MPMCore *core, MPMPatch *patch, const MPMPhase *phase, MPMPass pass, MPMStatus *status)
{
  static const PetscInt parts[] = {[MPM_PASS_EARLY] = MPM_P2G_EARLY, [MPM_PASS_LATE] = MPM_P2G_LATE};
  PetscInt              work    = phase->kind == MPM_NODES ? core->particles.n : patch->particles.n;

  PetscFunctionBeginUser;
  MPMWorkBegin(&core->timers);
  if (phase->kind == MPM_NODES) {
    MPM_FOR_OWN_ROWS(patch, r)
    if (r.first < r.last) phase->nodes(&core->params, patch, &r);
  } else {
    const MPMKernel kernel = MPMKernelFind(patch->grid->dim, patch->basis, phase->parts);
    MPMParams       params = core->params;

    PetscCheck(kernel, PETSC_COMM_SELF, PETSC_ERR_PLIB, "phase %s has no kernel for parts %" PetscInt_FMT, phase->name,
               phase->parts);
    if (phase->kind == MPM_PARTICLES_TO_NODES) {
      if (pass == MPM_PASS_MAIN) MPMTilesFindSpans(patch);
      for (PetscInt k = work = 0; k < patch->tiles.nruns[pass]; k++)
        work += patch->tiles.runs[pass][k].last - patch->tiles.runs[pass][k].first;
    }
    if (phase->parts & (MPM_G2P_FBAR | MPM_P2G_FBAR)) PetscCall(OpenBoxes(core, patch));
    params.dt *= phase->share;
    params.kick *= phase->share;
    kernel(&params, patch, phase->parts | parts[pass], status);
  }
  MPMWorkEnd(&core->timers, phase->timer, phase->name, (PetscReal)work);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the operations of a phase, on n particles for a transfer or on `nodes` nodes for a node update. */
static PetscReal PhaseFlops(const MPMCore *core, const MPMPhase *phase, PetscInt n, PetscReal nodes)
{
  const PetscInt dim = core->grid.dim;

  return phase->kind == MPM_NODES ? nodes * (PetscReal)(dim * phase->flops)
                                  : (PetscReal)n * MPMKernelFlops(dim, core->basis, phase->parts);
}

/* Returns the bytes that a phase moves between memory and processor if nothing stays in caches from phase to phase: the
   declared fields of n particles and the records of the nodes that they touch are read or written once. */
static PetscReal PhaseBytes(const MPMCore *core, const MPMPhase *phase, PetscInt n, PetscReal nodes)
{
  const PetscInt dim = core->grid.dim;
  const PetscInt nc  = phase->kind == MPM_PARTICLES_TO_NODES   ? 2 * MPM_NODE_NC * MPMNodeLines(phase->parts)
                       : phase->kind == MPM_NODES_TO_PARTICLES ? MPM_MOTION_NC(dim)
                                                               : MPM_NODE_NC + MPM_MOTION_NC(dim);

  return (PetscReal)n * (PetscReal)(MPMParticlesRowBytes(&core->particles, phase->particles_in) +
                                    MPMParticlesRowBytes(&core->particles, phase->particles_out)) +
         nodes * (PetscReal)nc * (PetscReal)sizeof(PetscReal);
}

PetscErrorCode MPMPhaseBegin(MPMCore *core, const MPMPhase *phase)
{
  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, phase->timer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPhaseEnd(MPMCore *core, const MPMPhase *phase, PetscInt n)
{
  const PetscReal nodes = MPMPatchTouchedNodes(&core->exchange.patch);
  const PetscInt  all   = core->exchange.type->by_workers ? core->particles.n : n; /* a pool's workers do this work */

  PetscFunctionBeginUser;
  PetscCall(PetscLogFlops(PhaseFlops(core, phase, n, nodes)));
  core->timers.flops += PhaseFlops(core, phase, all, nodes);
  core->timers.bytes += PhaseBytes(core, phase, all, nodes);
  PetscCall(MPMTimersEnd(&core->timers, phase->timer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPhaseRun(MPMCore *core, const MPMPhase *phase)
{
  const MPMExchangeType *type = core->exchange.type;

  PetscFunctionBeginUser;
  PetscCall(MPMPhaseBegin(core, phase));
  PetscCall(phase->kind == MPM_NODES ? type->nodes(core, phase) : type->sweep(core, phase));
  PetscCall(MPMPhaseEnd(core, phase, type->by_workers ? 0 : core->particles.n));
  PetscFunctionReturn(PETSC_SUCCESS);
}
