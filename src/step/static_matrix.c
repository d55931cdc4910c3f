/* static_matrix.c - the tangent stiffness of a static step, summed particle by particle. */
#include "kernels/transfer.h"
#include "parallel/exchange.h"
#include "physics/tangent.h"
#include "step/static.h"

/* Adds the stiffness of a particle of volume V0, with A [dim^4] = dP/dF, and B [dim][dim*dim], N, the derivative by F of the
   force on it, unless it is NULL, to that of the nodes of its stencil, [nodes dim][nodes dim]. */
static void AddParticle(PetscInt dim, const MPMStaticNodes *t, PetscReal V0, const PetscReal A[], const PetscReal *B,
                        PetscScalar stiffness[])
{
  const PetscInt n = t->n * dim;

  for (PetscInt i = 0; i < t->n; i++)
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal half[9]; /* V0 A_aBcD d_B phi_i, [c][D] */

      for (PetscInt k = 0; k < dim * dim; k++) {
        half[k] = B ? -B[a * dim * dim + k] * t->w[i] : 0;
        for (PetscInt e = 0; e < dim; e++) half[k] += V0 * A[(a * dim + e) * dim * dim + k] * t->g[i][e];
      }
      for (PetscInt j = 0; j < t->n; j++)
        for (PetscInt c = 0; c < dim; c++) {
          PetscReal sum = 0;

          for (PetscInt e = 0; e < dim; e++) sum += half[c * dim + e] * t->g[j][e];
          stiffness[(i * dim + a) * n + j * dim + c] += sum;
        }
    }
}

/* Replaces the rows and columns of what walls hold. */
static PetscErrorCode ReplaceHeld(struct MPMStatic *s, Mat K, Vec x, Vec b)
{
  const PetscInt dim = s->core->grid.dim;
  PetscInt      *rows, n = 0, begin, all;
  PetscScalar    mean;
  Vec            diagonal;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(s->u, &diagonal));
  PetscCall(MatGetDiagonal(K, diagonal));
  PetscCall(VecSum(diagonal, &mean));
  PetscCall(VecGetSize(diagonal, &all));
  PetscCall(VecGetOwnershipRange(diagonal, &begin, NULL));
  PetscCall(VecDestroy(&diagonal));
  PetscCall(PetscMalloc1(PetscMax(1, s->n * dim), &rows));
  for (PetscInt k = 0; k < s->n * dim; k++)
    if (s->held[k]) rows[n++] = begin + k;
  PetscCall(MatZeroRowsColumns(K, n, rows, mean / (PetscReal)all, x, b));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Turns the displacement gradients of a step, and the tangents by them, between the frames: H [dim*dim] becomes that of the
   state as the step began, was [dim*dim], in which the motion then has F; A [dim^4] = dT/dH becomes dP/dF. */
static void StepGradient(PetscInt dim, const PetscReal F[], const PetscReal was[], PetscReal H[])
{
  PetscReal cofactor[9], J = MPMDet((int)dim, was); /* J was^-T */

  MPMCofactor((int)dim, was, cofactor);
  for (PetscInt d = 0; d < dim; d++)
    for (PetscInt e = 0; e < dim; e++) {
      H[d * dim + e] = 0;
      for (PetscInt k = 0; k < dim; k++)
        H[d * dim + e] += (F[d * dim + k] - was[d * dim + k]) * cofactor[e * dim + k] / J;
    }
}

static void TotalTangent(PetscInt dim, const PetscReal was[], PetscReal A[])
{
  const PetscInt n = dim * dim;
  PetscReal      cofactor[9], J = MPMDet((int)dim, was), half[81];

  MPMCofactor((int)dim, was, cofactor);
  for (PetscInt a = 0; a < dim; a++)
    for (PetscInt b = 0; b < dim; b++)
      for (PetscInt q = 0; q < n; q++) {
        PetscReal sum = 0;

        for (PetscInt k = 0; k < dim; k++) sum += A[(a * dim + k) * n + q] * cofactor[k * dim + b] / J;
        half[(a * dim + b) * n + q] = sum;
      }
  for (PetscInt q = 0; q < n; q++)
    for (PetscInt c = 0; c < dim; c++)
      for (PetscInt d = 0; d < dim; d++) {
        PetscReal sum = 0;

        for (PetscInt k = 0; k < dim; k++) sum += half[q * n + c * dim + k] * cofactor[k * dim + d] / J;
        A[q * n + c * dim + d] = sum;
      }
}

/* Adds the stiffness of all particles here, those of a cell together. */
static PetscErrorCode AddParticles(struct MPMStatic *s, Mat K, PetscReal F[])
{
  MPMCore       *core = s->core;
  const PetscInt dim = core->grid.dim, fields = MPM_BIT(X) | MPM_BIT(l) | MPM_MATERIAL_BITS | MPM_BIT(kind) | MPM_BIT(id) |
                       MPM_BIT(x) | MPM_BIT(depth);
  const PetscInt *order = core->particles.order, n = dim * dim;
  PetscScalar    *stiffness;
  PetscInt        nodes = 1, size;
  PetscReal      *H, *T, *A, B[27], loads[81];
  PetscBool       any = PETSC_FALSE;
  MPMStaticNodes  now, cell;
  MPMView         view, loaded; /* loaded: with F of the trial state */
  MPMTangent      law = {.dim       = dim,
                         .width     = MPMKernelWidth(),
                         .dt        = core->params.dt,
                         .kinds     = core->params.kinds,
                         .materials = core->params.materials,
                         .particles = &view};

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) nodes *= MPMBasisNodes(core->basis);
  size = PetscSqr(nodes * dim);
  PetscCall(PetscCalloc1(size, &stiffness));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  loaded   = view;
  loaded.F = F;
  PetscCall(PetscMalloc3(PetscMax(1, view.n * n), &H, PetscMax(1, view.n * n), &T, PetscMax(1, view.n * n * n), &A));
  for (PetscInt p = 0; p < view.n; p++) StepGradient(dim, F + p * n, view.F + p * n, H + p * n);
  (void)MPMTangentTrial(&law, 0, view.n, H, T, A); /* the residual has found all of them in order */
  for (PetscInt k = 0; k < view.n; k++) {
    const PetscInt p = order[k];

    TotalTangent(dim, view.F + p * n, A + p * n * n);
    if (core->needs.loaded) {
      PetscCall(MPMForcesTangent(s->scene, core, &loaded, p, core->t + core->params.dt, B, loads, &any));
      for (PetscInt q = 0; q < n * n && any; q++) A[p * n * n + q] -= loads[q];
      for (PetscInt q = 0; q < n * dim && any; q++) B[q] *= MPMKindOf(core->params.kinds, &view, p)->m;
    }
    MPMStaticStencil(s, &view, p, &now);
    if (k && (now.base[0] != cell.base[0] || now.base[1] != cell.base[1] || now.base[2] != cell.base[2])) {
      PetscCall(MatSetValuesBlocked(K, cell.n, cell.number, cell.n, cell.number, stiffness, ADD_VALUES));
      PetscCall(PetscArrayzero(stiffness, size));
    }
    AddParticle(dim, &now, MPMKindOf(core->params.kinds, &view, p)->V0, A + p * n * n, any ? B : NULL, stiffness);
    cell = now;
  }
  if (view.n) PetscCall(MatSetValuesBlocked(K, cell.n, cell.number, cell.n, cell.number, stiffness, ADD_VALUES));
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(PetscFree3(H, T, A));
  PetscCall(PetscFree(stiffness));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the springs of weak nodes, row by row. */
static PetscErrorCode AddStabilisation(struct MPMStatic *s, Mat K)
{
  PetscInt begin, end, n;

  PetscFunctionBeginUser;
  PetscCall(MatGetOwnershipRange(s->ghosts, &begin, &end));
  for (PetscInt row = begin; row < end; row++) {
    const PetscInt    *columns;
    const PetscScalar *values;

    PetscCall(MatGetRow(s->ghosts, row, &n, &columns, &values));
    PetscCall(MatSetValues(K, 1, &row, n, columns, values, ADD_VALUES));
    PetscCall(MatRestoreRow(s->ghosts, row, &n, &columns, &values));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives a copy of F [n][dim*dim] of the particles' trial state, and puts them back to that as the step began. */
static PetscErrorCode TakeTrial(struct MPMStatic *s, PetscReal **F)
{
  MPMCore       *core = s->core;
  const PetscInt n    = core->particles.n * core->grid.dim * core->grid.dim;
  void          *now;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(PetscMax(1, n), F));
  PetscCall(MPMParticlesGetField(&core->particles, MPM_FIELD_INDEX_F, &now));
  PetscCall(PetscArraycpy(*F, (PetscReal *)now, n));
  PetscCall(MPMParticlesRestoreField(&core->particles, MPM_FIELD_INDEX_F));
  PetscCall(MPMParticlesPutBack(&core->particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticLeap(struct MPMStatic *s, PetscReal *most)
{
  MPMCore       *core = s->core;
  const PetscInt dim = core->grid.dim, n = dim * dim;
  PetscReal     *F;
  MPMView        view;

  PetscFunctionBeginUser;
  *most = 0;
  PetscCall(TakeTrial(s, &F));
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(F), &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal H[9];

    StepGradient(dim, F + p * n, view.F + p * n, H);
    for (PetscInt k = 0; k < n; k++) *most = PetscMax(*most, PetscAbsReal(H[k]));
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(F), &view));
  PetscCall(PetscFree(F));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 1, MPIU_REAL, MPI_MAX, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticTangent(struct MPMStatic *s, Mat K, Vec x, Vec b)
{
  MPMCore   *core = s->core;
  PetscReal *F;

  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, s->tangent));
  PetscCall(TakeTrial(s, &F));
  PetscCall(MatZeroEntries(K));
  PetscCall(AddParticles(s, K, F));
  if (s->ghosts) PetscCall(AddStabilisation(s, K));
  PetscCall(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
  PetscCall(ReplaceHeld(s, K, x, b));
  PetscCall(PetscFree(F));
  PetscCall(MPMTimersEnd(&core->timers, s->tangent));
  PetscFunctionReturn(PETSC_SUCCESS);
}
