/* lost.c - what particles take along that leave the grid and are removed (-particles_leave delete): the rows LOST of
   diagnostics.def, as exact sums over the particles that this process has removed. Balances count these particles as if
   they were still there, in the state in which they left. */
#include "results/selected.h"

#define MPM_LOST_QUANTITY(name, of, uses, unit, components, nc) +nc
_Static_assert(0
#include "results/diagnostics.def"
                   == MPM_NUM_LOST,
               "core->lost has a sum for each component");

/* Adds to core->lost, times `sign`, the quantities of particles here: of those that are outside the grid or, with first
   not below 0, of all from that number on. */
static PetscErrorCode Add(const MPMScene *scene, MPMCore *core, PetscInt first, PetscReal sign)
{
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v) | MPM_MATERIAL_BITS | MPM_BIT(kind) | MPM_BIT(cell) |
                          MPMDiagnosticReads(0, core);
  const MPMShown shown = {core, scene, NULL, NULL, NULL};
  MPMSum        *sum   = core->lost;
  MPMView        view;
  MPMSelected    some;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  PetscCall(MPMSelectedCreate(&some, &view));
  for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS; k++) {
    if (!(MPMDiagnostics[k].uses & MPM_SHOW_LOST)) continue;
    some.n = 0;
    for (PetscInt p = PetscMax(0, first); p < view.n; p++)
      if (first >= 0 || view.cell[p] == MPM_NOWHERE)
        MPMSelectedAdd(&some, p, sign * (k == MPM_SHOWS_lost_mass_time ? core->kicked : 1));
    PetscCall(MPMSelectedSum(&some, &shown, &view, MPMDiagnostics[k].of, sum, NULL, NULL));
    sum += MPMDiagnostics[k].nc;
  }
  PetscCall(MPMSelectedDestroy(&some));
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMLostAdd(const MPMScene *scene, MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(Add(scene, core, -1, 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMLostEnter(const MPMScene *scene, MPMCore *core, PetscInt first)
{
  PetscFunctionBeginUser;
  PetscCall(Add(scene, core, first, -1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMLostTotals(const MPMCore *core, MPMTotals *totals)
{
  MPMSum   sum[MPM_NUM_LOST];
  PetscInt n = 0;

  PetscFunctionBeginUser;
  if (core->particles.total == core->particles.born && !core->particles.flows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArraycpy(sum, core->lost, MPM_NUM_LOST));
  PetscCall(MPMSumReduce(sum, MPM_NUM_LOST, core->exchange.data));
  for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS; k++)
    for (PetscInt c = 0; MPMDiagnostics[k].uses & MPM_SHOW_LOST && c < MPMDiagnostics[k].nc; c++)
      totals->sum[k][c] = MPMSumValue(&sum[n++]);
  PetscFunctionReturn(PETSC_SUCCESS);
}
