/* damping.c - damping of all motion, for settling: a body force -v/T (-damping_time), and velocities that are set to 0
   whenever the kinetic energy has passed a maximum (-damping_kinetic). Both act on the velocities of the particles
   between the phases of steps, so that every transfer and update has the same damping; a scene without them makes no
   such pass over its particles. docs/method.md has the formulas (Damping of all motion). */
#include "step/step.h"

PetscErrorCode MPMDampingSetFromOptions(MPMCore *core, MPMOptions o)
{
  MPMDamping *d = &core->damping;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReal(o, "damping_time", NULL, &d->time, NULL));
  PetscCall(MPMOptionsBool(o, "damping_kinetic", NULL, &d->kinetic));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MPMDampingIsOn(const MPMCore *core)
{
  return core->damping.time > 0 || core->damping.kinetic;
}

/* Adds the kinetic energy of the particles here to *kinetic, J, if that is not NULL, and multiplies their velocities,
   with the affine ones of APIC, by `keep` unless it is 1. */
static PetscErrorCode Scale(MPMCore *core, PetscReal keep, MPMSum *kinetic)
{
  const PetscInt dim = core->grid.dim, fields = MPM_BIT(v) | MPM_BIT(C) | MPM_BIT(kind);
  MPMEnergy     *e = &core->energy;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, MPM_TIMER_FORCES));
  MPMWorkBegin(&core->timers);
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const PetscReal m  = MPMKindOf(core->params.kinds, &view, p)->m;
    PetscReal       v2 = 0, now2 = 0;

    for (PetscInt d = 0; d < dim; d++) {
      PetscReal *v = &view.v[p * dim + d];

      v2 += *v * *v;
      if (keep != 1) *v *= keep;
      now2 += *v * *v;
    }
    if (kinetic) MPMSumAdd(kinetic, 0.5 * m * v2);
    if (keep == 1) continue;
    if (e->on) MPMSumAdd(&e->sum[MPM_ENERGY_damping], 0.5 * m * (now2 - v2));
    for (PetscInt k = 0; k < dim * dim && view.C; k++) view.C[p * dim * dim + k] *= keep;
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  if (core->grid.total && keep != 1) MPMTotalScale(core, keep);
  MPMWorkEnd(&core->timers, MPM_TIMER_FORCES, NULL, 0);
  PetscCall(MPMTimersEnd(&core->timers, MPM_TIMER_FORCES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMDampingBegin(MPMCore *core)
{
  const MPMDamping *d = &core->damping;

  PetscFunctionBeginUser;
  if (d->time > 0) PetscCall(Scale(core, PetscExpReal(-0.5 * core->params.dt / d->time), NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMDampingEnd(MPMCore *core)
{
  MPMDamping *d = &core->damping;
  MPMSum      kinetic;
  PetscReal   now;

  PetscFunctionBeginUser;
  if (d->time > 0) PetscCall(Scale(core, PetscExpReal(-0.5 * core->params.dt / d->time), NULL));
  if (!d->kinetic) PetscFunctionReturn(PETSC_SUCCESS);
  MPMSumZero(&kinetic);
  PetscCall(Scale(core, 1, &kinetic));
  PetscCall(MPMSumReduce(&kinetic, 1, core->exchange.data));
  now     = MPMSumValue(&kinetic);
  d->rest = now < d->last;
  if (d->rest) {
    PetscCall(Scale(core, 0, NULL));
    now = 0;
    d->stops++;
  }
  d->last = now;
  PetscFunctionReturn(PETSC_SUCCESS);
}
