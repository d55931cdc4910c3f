/* static_matrix.c - the unknowns of a static step and its matrices: the tangent stiffness, summed particle by particle, and
   the stabilisation of nodes with little matter. In the total frame weights, unknowns and stabilisation do not change. */
#include "kernels/cell.h"
#include "kernels/transfer.h"
#include "parallel/exchange.h"
#include "physics/tangent.h"
#include "step/static.h"

#define SAMPLES 8 /* of a basis function in each cell, for how much of it lies in the grid */

/* The stencil of a particle: weights and gradients, 1 and 1/m, of its nodes, and the numbers of these. */
typedef struct {
  PetscInt  n, base[3], number[MPM_MAX_STENCIL * MPM_MAX_STENCIL * MPM_MAX_STENCIL];
  PetscReal w[MPM_MAX_STENCIL * MPM_MAX_STENCIL * MPM_MAX_STENCIL], g[MPM_MAX_STENCIL * MPM_MAX_STENCIL * MPM_MAX_STENCIL][3];
} Stencil;

/* Returns the place among `at` of node ijk [3] of the grid, which is one of this process or beside it. */
static PetscInt Place(const struct MPMStatic *s, const PetscInt ijk[])
{
  return ((ijk[2] - s->lo[2]) * s->wide[1] + ijk[1] - s->lo[1]) * s->wide[0] + ijk[0] - s->lo[0];
}

static void SetStencil(const struct MPMStatic *s, const MPMView *view, PetscInt p, Stencil *t)
{
  const MPMCore   *core  = s->core;
  const MPMGrid   *grid  = &core->grid;
  const int        dim   = (int)grid->dim;
  const PetscInt   nodes = MPMBasisNodes(core->basis);
  const PetscReal *l     = MPMHalfWidths(dim, core->params.kinds, view, p);
  PetscReal        xi[3], w[3][MPM_MAX_STENCIL], g[3][MPM_MAX_STENCIL];
  PetscInt         n[3] = {1, 1, 1};

  t->base[0] = t->base[1] = t->base[2] = 0;
  MPMCoordinates(dim, core->basis, grid, view->X + p * dim, l, xi, t->base);
  for (int d = 0; d < 3; d++) w[d][0] = 1, g[d][0] = 0;
  for (int d = 0; d < dim; d++) {
    n[d] = nodes;
    MPMBasisWeights(core->basis, xi[d], l[d], t->base[d], grid->cells[d], grid->wall_basis[d], w[d], g[d]);
  }
  t->n = 0;
  for (PetscInt k = 0; k < n[2]; k++)
    for (PetscInt j = 0; j < n[1]; j++)
      for (PetscInt i = 0; i < n[0]; i++, t->n++) {
        const PetscInt ijk[3] = {t->base[0] + i, t->base[1] + j, t->base[2] + k};

        t->number[t->n] = s->at[Place(s, ijk)];
        t->w[t->n]      = w[0][i] * w[1][j] * w[2][k];
        t->g[t->n][0]   = g[0][i] / grid->h[0] * w[1][j] * w[2][k];
        t->g[t->n][1]   = w[0][i] * g[1][j] / (dim > 1 ? grid->h[1] : 1) * w[2][k];
        t->g[t->n][2]   = w[0][i] * w[1][j] * g[2][k] / (dim > 2 ? grid->h[2] : 1);
      }
}

/* Makes the DM of one number for each node, cut as the grid is, with so many ghosts on both sides. */
static PetscErrorCode CreateNumbers(struct MPMStatic *s, PetscInt width)
{
  const MPMCore  *core = s->core;
  DM              da   = core->exchange.da;
  PetscInt        dim, n[3], parts[3];
  const PetscInt *l[3];
  DMBoundaryType  bc[3];

  PetscFunctionBeginUser;
  PetscCall(DMDAGetInfo(da, &dim, &n[0], &n[1], &n[2], &parts[0], &parts[1], &parts[2], NULL, NULL, &bc[0], &bc[1],
                        &bc[2], NULL));
  PetscCall(DMDAGetOwnershipRanges(da, &l[0], &l[1], &l[2]));
  if (dim == 1) PetscCall(DMDACreate1d(core->exchange.data, bc[0], n[0], 1, width, l[0], &s->numbers));
  if (dim == 2)
    PetscCall(DMDACreate2d(core->exchange.data, bc[0], bc[1], DMDA_STENCIL_BOX, n[0], n[1], parts[0], parts[1], 1,
                           width, l[0], l[1], &s->numbers));
  if (dim == 3)
    PetscCall(DMDACreate3d(core->exchange.data, bc[0], bc[1], bc[2], DMDA_STENCIL_BOX, n[0], n[1], n[2], parts[0],
                           parts[1], parts[2], 1, width, l[0], l[1], l[2], &s->numbers));
  PetscCall(DMSetUp(s->numbers));
  PetscCall(DMDAGetGhostCorners(s->numbers, &s->lo[0], &s->lo[1], &s->lo[2], &s->wide[0], &s->wide[1], &s->wide[2]));
  for (PetscInt d = 0; d < dim; d++) s->lo[d] -= core->grid.layers[d];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets ijk [3] to where own unknown q is. */
static void Where(const struct MPMStatic *s, PetscInt q, PetscInt ijk[])
{
  const MPMPatch *patch = &s->core->exchange.patch;
  const PetscInt  row   = s->node[q] / patch->n[0];

  ijk[0] = patch->lo[0] + s->node[q] % patch->n[0];
  ijk[1] = patch->lo[1] + row % patch->n[1];
  ijk[2] = patch->lo[2] + row / patch->n[1];
}

/* Sets value[...], as long as `at`, to own [n], one number of each own unknown, also where other processes have them;
   `none` where there is no unknown. */
static PetscErrorCode Spread(struct MPMStatic *s, const PetscReal own[], PetscReal none, PetscReal value[])
{
  Vec          all, here;
  PetscScalar *a;
  PetscInt     n, x[3], m[3];

  PetscFunctionBeginUser;
  PetscCall(DMCreateGlobalVector(s->numbers, &all));
  PetscCall(VecSet(all, none));
  PetscCall(DMDAGetCorners(s->numbers, &x[0], &x[1], &x[2], &m[0], &m[1], &m[2]));
  for (PetscInt d = 0; d < s->core->grid.dim; d++) x[d] -= s->core->grid.layers[d];
  PetscCall(VecGetArray(all, &a));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt ijk[3];

    Where(s, q, ijk);
    a[((ijk[2] - x[2]) * m[1] + ijk[1] - x[1]) * m[0] + ijk[0] - x[0]] = own[q];
  }
  PetscCall(VecRestoreArray(all, &a));
  PetscCall(DMCreateLocalVector(s->numbers, &here));
  PetscCall(VecSet(here, none));
  PetscCall(DMGlobalToLocal(s->numbers, all, INSERT_VALUES, here));
  PetscCall(VecGetLocalSize(here, &n));
  PetscCall(VecGetArray(here, &a));
  PetscCall(PetscArraycpy(value, a, n));
  PetscCall(VecRestoreArray(here, &a));
  PetscCall(VecDestroy(&here));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the nodes that one couples with along an axis, on either side: through a particle, or by the stabilisation. */
static PetscInt Reach(const struct MPMStatic *s)
{
  return MPMBasisNodes(s->core->basis) - 1;
}

/* Returns the nodes of a run of the stabilisation less 1: the order of its difference, one above that of the basis. */
static PetscInt Order(const struct MPMStatic *s)
{
  return s->core->basis == MPM_BASIS_bspline3 ? 4 : s->core->basis == MPM_BASIS_bspline2 ? 3 : 2;
}

/* Makes a matrix of the unknowns with room for all that they may couple with: those within `reach` on all axes, and
   along one axis those within the order of the stabilisation. */
static PetscErrorCode CreateMatrix(struct MPMStatic *s, PetscInt reach, Mat *A)
{
  const PetscInt dim = s->core->grid.dim, far = PetscMax(reach, Order(s));
  PetscInt      *own, *other, begin, end;

  PetscFunctionBeginUser;
  PetscCall(VecGetOwnershipRange(s->u, &begin, &end));
  PetscCall(PetscCalloc2(s->n * dim, &own, s->n * dim, &other));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt ijk[3], from[3] = {0}, to[3] = {0}, n[2] = {0};

    Where(s, q, ijk);
    for (PetscInt d = 0; d < dim; d++) {
      from[d] = PetscMax(ijk[d] - far, s->lo[d]) - ijk[d];
      to[d]   = PetscMin(ijk[d] + far, s->lo[d] + s->wide[d] - 1) - ijk[d];
    }
    for (PetscInt k = from[2]; k <= to[2]; k++)
      for (PetscInt j = from[1]; j <= to[1]; j++)
        for (PetscInt i = from[0]; i <= to[0]; i++) {
          const PetscInt  there[3] = {ijk[0] + i, ijk[1] + j, ijk[2] + k};
          const PetscBool line     = (PetscBool)((i != 0) + (j != 0) + (k != 0) <= 1);
          const PetscBool box = (PetscBool)(PetscAbsInt(i) <= reach && PetscAbsInt(j) <= reach && PetscAbsInt(k) <= reach);
          const PetscInt  number = s->at[Place(s, there)];

          if (number >= 0 && (line || box)) n[number * dim >= begin && number * dim < end ? 0 : 1]++;
        }
    for (PetscInt d = 0; d < dim; d++) own[q * dim + d] = n[0] * dim, other[q * dim + d] = n[1] * dim;
  }
  PetscCall(MatCreate(s->core->exchange.data, A));
  PetscCall(MatSetSizes(*A, s->n * dim, s->n * dim, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(*A, MATAIJ));
  PetscCall(MatSetBlockSize(*A, dim));
  PetscCall(MatSeqAIJSetPreallocation(*A, 0, own));
  PetscCall(MatMPIAIJSetPreallocation(*A, 0, own, 0, other));
  PetscCall(MatSetOption(*A, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
  PetscCall(PetscFree2(own, other));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tells multigrid how a rigid body moves: by the places of the nodes. */
static PetscErrorCode SetRigidMotions(struct MPMStatic *s)
{
  const MPMGrid *grid = &s->core->grid;
  Vec            where;
  PetscScalar   *x;
  MatNullSpace   rigid;

  PetscFunctionBeginUser;
  if (grid->dim == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(s->u, &where));
  PetscCall(VecSetBlockSize(where, grid->dim));
  PetscCall(VecGetArray(where, &x));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt  ijk[3];
    PetscReal at[3];

    Where(s, q, ijk);
    MPMGridNodeAt(grid, ijk, at);
    for (PetscInt d = 0; d < grid->dim; d++) x[q * grid->dim + d] = at[d];
  }
  PetscCall(VecRestoreArray(where, &x));
  PetscCall(MatNullSpaceCreateRigidBody(where, &rigid));
  PetscCall(MatSetNearNullSpace(s->K, rigid));
  PetscCall(MatNullSpaceDestroy(&rigid));
  PetscCall(VecDestroy(&where));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticNumber(struct MPMStatic *s)
{
  MPMCore        *core  = s->core;
  const MPMPatch *patch = &core->exchange.patch;
  const PetscInt  dim   = core->grid.dim;
  PetscInt        most = 0, begin, size;
  PetscReal      *own, *value;

  PetscFunctionBeginUser;
  PetscCall(CreateNumbers(s, PetscMax(Reach(s), Order(s))));
  PetscCall(MPMExchangeOpenNodes(core));
  for (int pass = 0; pass < 2; pass++) {
    s->n = 0;
    MPM_FOR_OWN_ROWS(patch, r)
    for (PetscInt i = r.first; i < r.last; i++) {
      if (!(r.sum[i].m > 0)) continue;
      if (pass) s->node[s->n] = r.row * patch->n[0] + i;
      s->n++;
    }
    if (!pass) PetscCall(PetscMalloc1(PetscMax(1, s->n), &s->node));
  }
  PetscCall(MPMExchangeCloseNodes(core));
  most = s->n;
  PetscCallMPI(MPI_Scan(&most, &begin, 1, MPIU_INT, MPI_SUM, core->exchange.data));
  begin -= s->n;
  size = s->wide[0] * s->wide[1] * s->wide[2];
  PetscCall(PetscMalloc2(PetscMax(1, s->n), &own, size, &value));
  for (PetscInt q = 0; q < s->n; q++) own[q] = (PetscReal)(begin + q);
  PetscCall(Spread(s, own, -1, value));
  PetscCall(PetscMalloc1(size, &s->at));
  for (PetscInt k = 0; k < size; k++) s->at[k] = (PetscInt)value[k];
  PetscCall(PetscFree2(own, value));
  PetscCall(PetscMalloc1(PetscMax(1, s->n * dim), &s->held));
  PetscCall(PetscMalloc1(PetscMax(1, s->n * dim), &s->known));
  PetscCall(VecCreate(core->exchange.data, &s->u));
  PetscCall(VecSetSizes(s->u, s->n * dim, PETSC_DETERMINE));
  PetscCall(VecSetBlockSize(s->u, dim));
  PetscCall(VecSetType(s->u, VECSTANDARD));
  PetscCall(VecDuplicate(s->u, &s->r));
  PetscCall(VecDuplicate(s->u, &s->was));
  PetscCall(VecDuplicate(s->u, &s->work));
  PetscCall(CreateMatrix(s, Reach(s), &s->K));
  PetscCall(SetRigidMotions(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Stabilisation ------------------------------------------------------------------------------------------------ */

/* Sets inside [nodes of axis d] to the integral over the grid, in cells, of the basis functions along axis d. */
static PetscErrorCode Inside(const MPMCore *core, PetscInt d, PetscReal **inside)
{
  const MPMGrid  *grid  = &core->grid;
  const PetscReal l     = 0.25; /* of gimp, about */
  const PetscInt  nodes = grid->cells[d] + 2 * grid->layers[d] + 1;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(nodes, inside));
  for (PetscInt k = 0; k < grid->cells[d] * SAMPLES; k++) {
    PetscReal xi = ((PetscReal)k + 0.5) / SAMPLES, w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];
    PetscInt  base;

    base = MPMBasisBase(core->basis, &xi, l, grid->cells[d], grid->periodic[d], grid->wall_basis[d]);
    MPMBasisWeights(core->basis, xi, l, base, grid->cells[d], grid->wall_basis[d], w, g);
    for (PetscInt i = 0; i < MPMBasisNodes(core->basis); i++) {
      const PetscInt node = base + i + grid->layers[d], n = grid->cells[d];

      (*inside)[grid->periodic[d] ? (node % n + n) % n : node] += w[i] / SAMPLES;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets weak[...], as long as `at`, to 1 where a node has less matter than the share `fill` of what it has room for. */
static PetscErrorCode FindWeak(struct MPMStatic *s, PetscReal weak[])
{
  MPMCore       *core   = s->core;
  const MPMGrid *grid   = &core->grid;
  const PetscInt dim    = grid->dim, fields = MPM_BIT(X) | MPM_BIT(kind) | MPM_BIT(l);
  PetscReal     *own, *inside[3], h = 1;
  Vec            volume;
  PetscScalar   *v;
  MPMView        view;
  Stencil        t;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(s->u, &volume));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    SetStencil(s, &view, p, &t);
    for (PetscInt i = 0; i < t.n; i++) {
      const PetscScalar part = t.w[i] * MPMKindOf(core->params.kinds, &view, p)->V0;
      const PetscInt    at   = t.number[i] < 0 ? -1 : t.number[i] * dim;

      PetscCall(VecSetValues(volume, 1, &at, &part, ADD_VALUES));
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(VecAssemblyBegin(volume));
  PetscCall(VecAssemblyEnd(volume));
  for (PetscInt d = 0; d < dim; d++) {
    PetscCall(Inside(core, d, &inside[d]));
    h *= grid->h[d];
  }
  PetscCall(PetscMalloc1(PetscMax(1, s->n), &own));
  PetscCall(VecGetArray(volume, &v));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt  ijk[3];
    PetscReal room = h;

    Where(s, q, ijk);
    for (PetscInt d = 0; d < dim; d++) room *= inside[d][ijk[d] + (grid->periodic[d] ? 0 : grid->layers[d])];
    own[q] = v[q * dim] < s->fill * room ? 1 : 0;
  }
  PetscCall(VecRestoreArray(volume, &v));
  PetscCall(Spread(s, own, 0, weak));
  PetscCall(PetscFree(own));
  for (PetscInt d = 0; d < dim; d++) PetscCall(PetscFree(inside[d]));
  PetscCall(VecDestroy(&volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the stabilisation of the run of nodes from ijk [3] on along axis d, if all have mass and one is weak. */
static PetscErrorCode AddRun(struct MPMStatic *s, const PetscInt ijk[], PetscInt d, PetscReal stiffness,
                             const PetscReal weak[])
{
  static const PetscReal rows[5][5] = {{0}, {0}, {1, -2, 1}, {1, -3, 3, -1}, {1, -4, 6, -4, 1}};
  const PetscInt         order = Order(s), dim = s->core->grid.dim;
  PetscInt               number[5], at[3] = {ijk[0], ijk[1], ijk[2]};
  PetscBool              any = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k <= order; k++) {
    at[d] = ijk[d] + k;
    if (at[d] >= s->lo[d] + s->wide[d]) PetscFunctionReturn(PETSC_SUCCESS);
    number[k] = s->at[Place(s, at)];
    if (number[k] < 0) PetscFunctionReturn(PETSC_SUCCESS);
    if (weak[Place(s, at)] > 0) any = PETSC_TRUE;
  }
  for (PetscInt i = 0; i <= order && any; i++)
    for (PetscInt j = 0; j <= order; j++)
      for (PetscInt c = 0; c < dim; c++)
        PetscCall(MatSetValue(s->ghosts, number[i] * dim + c, number[j] * dim + c,
                              stiffness * rows[order][i] * rows[order][j], ADD_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticStabilise(struct MPMStatic *s)
{
  const MPMCore *core = s->core;
  const MPMGrid *grid = &core->grid;
  PetscReal     *weak, E = 0, h = 1;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < core->params.nmaterials; k++) E = PetscMax(E, core->params.materials[k].E);
  for (PetscInt d = 0; d < grid->dim; d++) h *= grid->h[d];
  PetscCall(PetscMalloc1(s->wide[0] * s->wide[1] * s->wide[2], &weak));
  PetscCall(FindWeak(s, weak));
  PetscCall(CreateMatrix(s, 0, &s->ghosts));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt ijk[3];

    Where(s, q, ijk);
    for (PetscInt d = 0; d < grid->dim; d++)
      PetscCall(AddRun(s, ijk, d, s->ghost * E * h / PetscSqr(grid->h[d]), weak));
  }
  PetscCall(PetscFree(weak));
  PetscCall(MatAssemblyBegin(s->ghosts, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->ghosts, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Tangent ------------------------------------------------------------------------------------------------------ */

/* Adds the stiffness of a particle of volume V0, with A [dim^4] = dP/dF, and B [dim][dim*dim], N, the derivative by F of the
   force on it, unless it is NULL, to that of the nodes of its stencil, [nodes dim][nodes dim]. */
static void AddParticle(PetscInt dim, const Stencil *t, PetscReal V0, const PetscReal A[], const PetscReal *B,
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
  Stencil         now, cell;
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
    SetStencil(s, &view, p, &now);
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
