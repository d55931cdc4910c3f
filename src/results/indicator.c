/* indicator.c - an indicator of the error of the stress, for snapshots and the end of a run. The stress of the
   particles is averaged at the nodes, weighted by their masses, and the particles read it back (MPMStepRecover). Where
   their own stress is smooth on the grid both agree; what is left is the part that the grid cannot resolve, noise
   included. */
#include "results/output.h"
#include "step/step.h"

/* Some components of the stress, first .. first+n-1 of those that the dimension has. */
typedef struct {
  PetscInt dim, first, n;
} Part;

/* Returns the squared size of this part of a symmetric tensor. */
static PetscReal Size2(const Part *part, const PetscReal s[])
{
  PetscReal size = 0;

  for (PetscInt k = 0; k < part->n; k++)
    size += (MPMSymUnit((int)part->dim, (int)(part->first + k)) ? 1 : 2) * s[k] * s[k];
  return size;
}

/* Sets r [n][dim] to this part of the Cauchy stress of the particles here, Pa; adds its squared size times the volume
   to stress2, and the volume to `volume`, if that is not NULL. */
static PetscErrorCode ReadStress(const MPMScene *scene, MPMCore *core, const Part *part, PetscReal r[], MPMSum *stress2,
                                 MPMSum *volume)
{
  const MPMShown shown = {core, scene, NULL, NULL, NULL};
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, -1, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal all[MPM_MAX_COMPONENTS], V, *row = r + p * part->dim;

    MPMDiagnostics[MPM_SHOWS_stress].fill(&shown, &view, p, all);
    MPMDiagnostics[MPM_SHOWS_volume].fill(&shown, &view, p, &V);
    for (PetscInt k = 0; k < part->dim; k++) row[k] = k < part->n ? all[MPMShownStress(part->dim, part->first + k)] : 0;
    MPMSumAdd(stress2, V * Size2(part, row));
    if (volume) MPMSumAdd(volume, V);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, -1, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds this part of the difference, r, to its size `of`, Pa, and its squared size times the volume to jump2. */
static PetscErrorCode AddJump(const MPMScene *scene, MPMCore *core, const Part *part, const PetscReal r[], float of[],
                              MPMSum *jump2)
{
  const MPMShown shown = {core, scene, NULL, NULL, NULL};
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, -1, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const PetscReal size2 = Size2(part, r + p * part->dim);
    PetscReal       V;

    MPMDiagnostics[MPM_SHOWS_volume].fill(&shown, &view, p, &V);
    MPMSumAdd(jump2, V * size2);
    of[p] = (float)PetscSqrtReal((PetscReal)of[p] * (PetscReal)of[p] + size2);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, -1, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds where the indicator is largest; of several particles it is that with the smallest id. */
static PetscErrorCode FindLargest(MPMCore *core, const float of[], MPMIndicator *indicator)
{
  const PetscInt dim = core->grid.dim;
  PetscInt64     id  = INT64_MAX, first;
  PetscInt       at  = 0;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(indicator->x, 3));
  indicator->largest = 0;
  for (PetscInt p = 0; p < core->particles.n; p++) indicator->largest = PetscMax(indicator->largest, (PetscReal)of[p]);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &indicator->largest, 1, MPIU_REAL, MPIU_MAX, core->exchange.data));
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(id) | MPM_BIT(x), &view));
  for (PetscInt p = 0; p < view.n; p++)
    if ((PetscReal)of[p] == indicator->largest && view.id[p] < id) {
      id = view.id[p];
      at = p;
    }
  PetscCallMPI(MPI_Allreduce(&id, &first, 1, MPIU_INT64, MPI_MIN, core->exchange.data));
  for (PetscInt d = 0; d < dim && id == first && id < INT64_MAX; d++) indicator->x[d] = view.x[at * dim + d];
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(id) | MPM_BIT(x), &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, indicator->x, 3, MPIU_REAL, MPIU_SUM, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMIndicatorCompute(const MPMScene *scene, MPMCore *core, float of[], MPMIndicator *indicator)
{
  const PetscInt dim = core->grid.dim, n = core->particles.n;
  PetscReal     *r, stress;
  MPMSum         sum[3]; /* of volume, of volume times |stress|^2, and times |stress - recovered stress|^2 */

  PetscFunctionBeginUser;
  for (int k = 0; k < 3; k++) MPMSumZero(&sum[k]);
  PetscCall(PetscArrayzero(of, n));
  PetscCall(MPMStepRecoverBegin(core, &r));
  for (PetscInt first = 0; first < MPM_SYM_NC(dim); first += dim) {
    const Part part = {dim, first, PetscMin(dim, MPM_SYM_NC(dim) - first)};

    PetscCall(ReadStress(scene, core, &part, r, &sum[1], first ? NULL : &sum[0]));
    PetscCall(MPMStepRecover(core));
    PetscCall(AddJump(scene, core, &part, r, of, &sum[2]));
  }
  PetscCall(MPMStepRecoverEnd(core));
  PetscCall(MPMSumReduce(sum, 3, core->exchange.data));
  indicator->stress = stress = PetscSqrtReal(MPMSumValue(&sum[1]) / MPMSumValue(&sum[0]));
  indicator->jump            = stress > 0 ? PetscSqrtReal(MPMSumValue(&sum[2]) / MPMSumValue(&sum[1])) : 0;
  for (PetscInt p = 0; p < n; p++) of[p] = stress > 0 ? (float)((PetscReal)of[p] / stress) : 0;
  PetscCall(FindLargest(core, of, indicator));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMShownBegin(const MPMScene *scene, MPMCore *core, PetscInt64 rows, MPMShown *shown)
{
  MPMIndicator ignored;
  float       *of;

  PetscFunctionBeginUser;
  *shown = (MPMShown){.core = core, .scene = scene};
  if (!(rows >> MPM_SHOWS_error_indicator & 1)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(core->particles.n, &of));
  PetscCall(MPMIndicatorCompute(scene, core, of, &ignored));
  shown->indicator = of;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMShownEnd(MPMShown *shown)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(shown->indicator));
  PetscFunctionReturn(PETSC_SUCCESS);
}
