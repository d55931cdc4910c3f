/* totals.c - the sums over all particles of the rows of diagnostics.def. */
#include "results/selected.h"

/* Adds up the sums of core->energy over all processes, if the run has any. Collective on the exchange. */
static PetscErrorCode ReduceEnergy(const MPMCore *core, PetscReal energy[])
{
  const PetscInt n = core->energy.on ? MPM_NUM_ENERGIES : core->energy.loads ? 1 : 0; /* the first is that of loads */
  MPMSum         sum[MPM_NUM_ENERGIES];

  PetscFunctionBeginUser;
  PetscCall(PetscMemcpy(sum, core->energy.sum, sizeof sum));
  PetscCall(MPMSumReduce(sum, n, core->exchange.data));
  for (PetscInt k = 0; k < n; k++) energy[k] = MPMSumValue(&sum[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the particle with a quantity that is not finite, after the totals have shown that there is one. Collective on
   the exchange. */
static PetscErrorCode FindWrong(const MPMScene *scene, MPMCore *core, MPMTotals *totals)
{
  const MPMShown shown = {core, scene, NULL, NULL, NULL};
  PetscInt64     least = INT64_MAX;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, -1, &view));
  for (PetscInt k = MPM_NUM_DIAGNOSTICS - 1; k >= 0; k--) { /* the first row last, so that it is the one to be named */
    PetscInt64 id = INT64_MAX;

    for (PetscInt p = 0; p < view.n && (MPMDiagnostics[k].uses & MPM_SHOW_SUM) && MPMDiagnosticIsOn(k, core); p++) {
      PetscReal value[3];

      MPMDiagnostics[k].fill(&shown, &view, p, value);
      for (PetscInt c = 0; c < MPMDiagnostics[k].nc; c++)
        if (!(PetscAbsReal(value[c]) <= PETSC_MAX_REAL)) id = PetscMin(id, view.id[p]);
    }
    PetscCallMPI(MPI_Allreduce(&id, &least, 1, MPIU_INT64, MPI_MIN, core->exchange.data));
    if (least == INT64_MAX) continue;
    totals->wrong     = least;
    totals->wrong_row = k;
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, -1, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMTotalsCompute(const MPMScene *scene, MPMCore *core, MPMTotals *totals)
{
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v) | MPM_BIT(C) | MPM_BIT(l) | MPM_MATERIAL_BITS |
                          MPM_BIT(kind) | MPM_BIT(cell) | MPMDiagnosticReads(0, core);
  const MPMShown shown = {core, scene, NULL, NULL, NULL};
  MPMView        view;
  MPMSelected    all;
  MPMSum         sum[3 * MPM_NUM_DIAGNOSTICS];
  PetscInt64     count[3] = {0}; /* particles, their fingerprint, and how many quantities are not finite */
  PetscInt       n        = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(totals, sizeof *totals));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  all = (MPMSelected){.n = view.n};
  for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS; k++) {
    const MPMDiagnostic *row = &MPMDiagnostics[k];

    if (!(row->uses & MPM_SHOW_SUM) || !MPMDiagnosticIsOn(k, core)) continue;
    for (PetscInt c = 0; c < row->nc; c++) MPMSumZero(&sum[n + c]);
    PetscCall(MPMSelectedSum(&all, &shown, &view, k, sum + n, NULL, &count[2]));
    n += row->nc;
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(MPMSumReduce(sum, n, core->exchange.data));
  for (PetscInt k = 0, at = 0; k < MPM_NUM_DIAGNOSTICS; k++) {
    const PetscBool has = (MPMDiagnostics[k].uses & MPM_SHOW_SUM) && MPMDiagnosticIsOn(k, core);

    for (PetscInt c = 0; has && c < MPMDiagnostics[k].nc; c++) totals->sum[k][c] = MPMSumValue(&sum[at++]);
  }
  PetscCall(ReduceEnergy(core, totals->energy));
  for (PetscInt k = 0; k < core->rigids.n; k++)
    if (core->rigids.body[k].free) totals->rigid += MPMRigidEnergy(&core->rigids.body[k]);
  PetscCall(MPMLostTotals(core, totals));
  count[0] = core->particles.n;
  PetscCall(MPMParticlesFingerprint(&core->particles, &count[1]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 3, MPIU_INT64, MPI_SUM, core->exchange.data));
  PetscCall(MPMParticlesCheck(&core->particles, core->exchange.data, count[0], count[1]));
  totals->n     = count[0];
  totals->wrong = -1;
  if (count[2]) PetscCall(FindWrong(scene, core, totals));
  PetscFunctionReturn(PETSC_SUCCESS);
}
