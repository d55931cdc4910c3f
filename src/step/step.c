/* step.c - the step: it runs the phases of core->program one after the other. How a phase runs on several processes is
   up to core->exchange. Then come one reduction of the status and, if no error was found, settling: the sorting and the
   migration of the particles that changed their cell. */
#include "base/signals.h"
#include "parallel/exchange.h"
#include "particles/poison.h"
#include "step/static.h"
#include "step/step.h"

#if defined(MPM_POISON)
/* Nothing of the step before may be used but the particles' state: not scratch fields, sums and motion of nodes. */
static PetscErrorCode PoisonStep(MPMCore *core)
{
  const MPMPatch *patch   = &core->exchange.patch;
  const size_t    nodes   = (size_t)MPMPatchNodes(patch);
  PetscInt        scratch = 0;

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS && !core->needs.all; f++) /* with -method_carry all, b stays 0 */
    if (MPMFields[f].home == MPM_SCRATCH) scratch |= 1 << f;
  PetscCall(MPMPoisonFields(&core->particles, scratch, 0));
  PetscCall(MPMExchangeOpenNodes(core));
  for (size_t i = 0; i < nodes && core->grid.total; i++) { /* the masses of the total frame stay (round.h) */
    MPMPoison(patch->node[i].p, (core->grid.round ? 2 : 3) * sizeof *patch->node[i].p);
    MPMPoison(patch->node[i].f, sizeof patch->node[i].f);
  }
  if (!core->grid.total) MPMPoison(patch->node, nodes * (size_t)patch->tiles.lines * sizeof *patch->node);
#define MPM_NODE_VALUE(name, nc, unit, meaning)                                                                        \
  MPMPoison(patch->value.name, nodes *(size_t)MPMNodeComponents_##name(core->grid.dim) * sizeof(PetscReal));
#include "kernels/node.def"
  MPMPoison(patch->motion, nodes * (size_t)MPM_MOTION_NC(core->grid.dim) * sizeof *patch->motion);
  PetscCall(MPMExchangeCloseNodes(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}
#else
#define PoisonStep(core) PETSC_SUCCESS
#endif

static PetscErrorCode Begin(MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(PoisonStep(core));
  MPMStatusReset(&core->status);
  PetscCall(MPMWorkStep(&core->timers, core->exchange.type->by_workers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetForces(MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, MPM_TIMER_FORCES));
  MPMWorkBegin(&core->timers);
  PetscCall(MPMForcesUpdate(scene, core, core->t));
  MPMWorkEnd(&core->timers, MPM_TIMER_FORCES, NULL, 0);
  PetscCall(MPMTimersEnd(&core->timers, MPM_TIMER_FORCES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FindGaps(MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, MPM_TIMER_FORCES));
  MPMWorkBegin(&core->timers);
  PetscCall(MPMGapsUpdate(core));
  if (core->contacts) PetscCall(MPMContactsFind(core));
  MPMWorkEnd(&core->timers, MPM_TIMER_FORCES, NULL, 0);
  PetscCall(MPMTimersEnd(&core->timers, MPM_TIMER_FORCES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FollowEnergy(MPMCore *core, PetscBool begins)
{
  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, MPM_TIMER_FORCES));
  MPMWorkBegin(&core->timers);
  PetscCall(MPMEnergyStep(core, begins));
  MPMWorkEnd(&core->timers, MPM_TIMER_FORCES, NULL, 0);
  PetscCall(MPMTimersEnd(&core->timers, MPM_TIMER_FORCES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs phase k of the program of a step. */
static PetscErrorCode RunPhase(MPMCore *core, PetscInt k)
{
  const MPMPhase *phase = core->program[k];

  PetscFunctionBeginUser;
  if (core->reactions) PetscCall(MPMReactionsPhase(core, k, PETSC_TRUE));
  if (core->grid.total && (core->reactions || core->energy.on) && MPMTotalKicks(phase)) PetscCall(MPMTotalKeep(core));
  PetscCall(MPMPhaseRun(core, phase));
  if (core->energy.on && !core->implicit && phase->kind == MPM_NODES) PetscCall(MPMEnergyNodes(core, k));
  if (core->reactions) PetscCall(MPMReactionsPhase(core, k, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Reduce(MPMCore *core)
{
  const PetscInt64 asked = MPMSignalsAsked();

  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, MPM_TIMER_REDUCE));
  core->status.asked = PetscMax(core->status.asked, asked); /* workers of the pool have told theirs */
  PetscCall(core->exchange.type->reduce(core, &core->status));
  PetscCall(MPMTimersEnd(&core->timers, MPM_TIMER_REDUCE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStepSettle(MPMCore *core)
{
  PetscBool settled = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, MPM_TIMER_SETTLE));
  if (core->contacts) PetscCall(MPMContactsFollow(core, &settled));
  if (!settled) PetscCall(core->exchange.type->settle(core, PETSC_FALSE));
  if (core->status.moved) PetscCall(MPMContactsSettle(core));
  PetscCall(MPMTimersEnd(&core->timers, MPM_TIMER_SETTLE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a step without inertia. The work of loads is that of their value in its middle. */
static PetscErrorCode MakeStatic(MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  if (MPMEnergyFollows(core)) {
    if (core->needs.forced) PetscCall(MPMForcesUpdate(scene, core, core->t + 0.5 * core->params.dt));
    PetscCall(FollowEnergy(core, PETSC_TRUE));
  }
  if (core->needs.stepped) PetscCall(MPMStaticRenew(core->implicit));
  PetscCall(MPMStaticStep(core));
  PetscCall(Reduce(core));
  if (MPMEnergyFollows(core) && !core->stop[0]) {
    if (core->needs.forced) PetscCall(MPMForcesUpdate(scene, core, core->t + 0.5 * core->params.dt));
    PetscCall(FollowEnergy(core, PETSC_FALSE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStepMake(MPMCore *core, const MPMScene *scene)
{
  const MPMStatus last = core->status;

  PetscFunctionBeginUser;
  PetscCall(Begin(core));
  if (core->implicit) {
    PetscCall(MakeStatic(core, scene));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (MPMDampingIsOn(core)) PetscCall(MPMDampingBegin(core));
  if (core->needs.forced) PetscCall(SetForces(core, scene));
  if (MPMVolumesRelax(core)) PetscCall(MPMVolumesStep(core, &last));
  if (MPMEnergyFollows(core)) PetscCall(FollowEnergy(core, PETSC_TRUE));
  if (core->gaps || core->contacts) PetscCall(FindGaps(core));
  if (core->grid.total) PetscCall(MPMTotalHalf(core, 1));
  for (PetscInt k = 0; k < core->nprogram; k++) PetscCall(RunPhase(core, k));
  if (core->grid.total) PetscCall(MPMTotalHalf(core, -1));
  PetscCall(Reduce(core));
  if (MPMEnergyFollows(core) && !MPMStatusIsBad(&core->status)) PetscCall(FollowEnergy(core, PETSC_FALSE));
  if (MPMDampingIsOn(core) && !MPMStatusIsBad(&core->status)) PetscCall(MPMDampingEnd(core));
  if (core->rest.on && !MPMStatusIsBad(&core->status)) PetscCall(MPMRestStep(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Runs a phase outside of steps: no timer, and no part of the critical path. */
static PetscErrorCode RunUntimed(MPMCore *core, const MPMPhase *phase)
{
  const MPMExchangeType *ex = core->exchange.type;
  const PetscBool        on = core->timers.work.on;

  PetscFunctionBeginUser;
  core->timers.work.on = PETSC_FALSE;
  PetscCall(phase->kind == MPM_NODES ? ex->nodes(core, phase) : ex->sweep(core, phase));
  core->timers.work.on = on;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStepNodes(MPMCore *core)
{
  PetscFunctionBeginUser;
  if (core->gaps) PetscCall(MPMGapsUpdate(core));
  if (core->contacts) PetscCall(MPMContactsFind(core));
  for (PetscInt k = 0; k < 2; k++) PetscCall(RunUntimed(core, MPMStepOutputPhase(core, k)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Scenes without xpic have no field r: it gets the memory of another scratch field, which holds nothing between steps,
   or memory for this time. */
PetscErrorCode MPMStepRecoverBegin(MPMCore *core, PetscReal **r)
{
  const PetscInt others[] = {MPM_FIELD_INDEX_dx, MPM_FIELD_INDEX_b};
  MPMParticles  *p        = &core->particles;

  PetscFunctionBeginUser;
  for (int k = 0; k < 2 && !p->scratch[MPM_FIELD_INDEX_r]; k++) p->scratch[MPM_FIELD_INDEX_r] = p->scratch[others[k]];
  if (!p->scratch[MPM_FIELD_INDEX_r])
    PetscCall(PetscMalloc1(p->capacity * p->dim, (PetscReal **)&p->scratch[MPM_FIELD_INDEX_r]));
  p->present[MPM_FIELD_INDEX_r] = PETSC_TRUE;
  PetscCall(RunUntimed(core, MPMStepRecoverPhase(core, 0)));
  *r = (PetscReal *)p->scratch[MPM_FIELD_INDEX_r];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStepRecover(MPMCore *core)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 1; k < 4; k++) PetscCall(RunUntimed(core, MPMStepRecoverPhase(core, k)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStepRecoverEnd(MPMCore *core)
{
  MPMParticles *p = &core->particles;
  void        **r = &p->scratch[MPM_FIELD_INDEX_r];

  PetscFunctionBeginUser;
  p->present[MPM_FIELD_INDEX_r] = core->needs.residual;
  if (core->needs.residual) PetscFunctionReturn(PETSC_SUCCESS);
  if (*r != p->scratch[MPM_FIELD_INDEX_dx] && *r != p->scratch[MPM_FIELD_INDEX_b]) PetscCall(PetscFree(*r));
  *r = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStepBound(MPMCore *core)
{
  const PetscInt dim = core->grid.dim, fields = MPM_BIT(v) | MPM_MATERIAL_BITS | MPM_BIT(kind);
  MPMView        view;
  MPMBlock       b;
  PetscReal      c2;

  PetscFunctionBeginUser;
  MPMStatusReset(&core->status);
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMMaterial *m  = core->params.materials + MPMKindOf(core->params.kinds, &view, p)->material;
    PetscReal          v2 = 0;

    for (PetscInt d = 0; d < dim; d++) v2 += view.v[p * dim + d] * view.v[p * dim + d];
    MPMMaterialState(dim, &view, p, &b);
    m->type->law->speed2[MPMLawForm(m, dim)](m, 0, 1, &b, &c2);
    core->status.v2 = PetscMax(core->status.v2, v2);
    core->status.c2 = PetscMax(core->status.c2, c2);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(core->exchange.type->reduce(core, &core->status));
  PetscFunctionReturn(PETSC_SUCCESS);
}
