/* static_nodes.c - the unknowns of a static step: which nodes have some, their numbers, also of those beside this process, and
   matrices of them. In the total frame weights and unknowns do not change. */
#include "kernels/cell.h"
#include "kernels/round.h"
#include "parallel/exchange.h"
#include "step/static.h"

/* Returns the place among `at` of node ijk [3] of the grid, which is one of this process or beside it. */
PetscInt MPMStaticPlace(const struct MPMStatic *s, const PetscInt ijk[])
{
  return ((ijk[2] - s->lo[2]) * s->wide[1] + ijk[1] - s->lo[1]) * s->wide[0] + ijk[0] - s->lo[0];
}

void MPMStaticStencil(const struct MPMStatic *s, const MPMView *view, PetscInt p, MPMStaticNodes *t)
{
  const MPMCore   *core  = s->core;
  const MPMGrid   *grid  = &core->grid;
  const int        dim   = (int)grid->dim;
  const PetscInt   nodes = MPMBasisNodes(core->basis);
  const PetscReal *place = MPMPlaces(grid, view) + p * dim;
  const PetscReal *l     = MPMHalfWidths(dim, core->params.kinds, view, p);
  PetscReal        xi[3], w[3][MPM_MAX_STENCIL], g[3][MPM_MAX_STENCIL];
  PetscInt         n[3] = {1, 1, 1};

  t->base[0] = t->base[1] = t->base[2] = 0;
  MPMCoordinates(dim, core->basis, grid, place, l, xi, t->base);
  for (int d = 0; d < 3; d++) w[d][0] = 1, g[d][0] = 0;
  for (int d = 0; d < dim; d++) {
    n[d] = nodes;
    MPMBasisWeights(core->basis, xi[d], l[d], t->base[d], grid->cells[d], grid->wall_basis[d], w[d], g[d]);
  }
  t->n = 0;
  t->r = PetscMax(place[0], MPM_ROUND_LEAST * grid->h[0]);
  for (PetscInt k = 0; k < n[2]; k++)
    for (PetscInt j = 0; j < n[1]; j++)
      for (PetscInt i = 0; i < n[0]; i++, t->n++) {
        const PetscInt ijk[3] = {t->base[0] + i, t->base[1] + j, t->base[2] + k};

        t->number[t->n] = s->at[MPMStaticPlace(s, ijk)];
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
void MPMStaticWhere(const struct MPMStatic *s, PetscInt q, PetscInt ijk[])
{
  const MPMPatch *patch = &s->core->exchange.patch;
  const PetscInt  row   = s->node[q] / patch->n[0];

  ijk[0] = patch->lo[0] + s->node[q] % patch->n[0];
  ijk[1] = patch->lo[1] + row % patch->n[1];
  ijk[2] = patch->lo[2] + row / patch->n[1];
}

/* Makes a vector that has 1 or more at own nodes, in the order of the DM, on whose displacements the strain of a particle
   depends. With the linear basis they need not have mass: a particle on a line of the grid has no weight there, but a
   gradient. */
static PetscErrorCode FindStrained(struct MPMStatic *s, Vec *strained)
{
  MPMCore       *core   = s->core;
  const PetscInt fields = MPM_BIT(X) | MPM_BIT(x) | MPM_BIT(kind) | MPM_BIT(l), n = MPMBasisNodes(core->basis);
  PetscScalar   *mark;
  MPMStaticNodes t;
  MPMView        view;
  Vec            here;

  PetscFunctionBeginUser;
  PetscCall(DMCreateLocalVector(s->numbers, &here));
  PetscCall(VecSet(here, 0));
  PetscCall(VecGetArray(here, &mark));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    MPMStaticStencil(s, &view, p, &t);
    for (PetscInt i = 0; i < t.n; i++) {
      const PetscInt ijk[3] = {t.base[0] + i % n, t.base[1] + i / n % n, t.base[2] + i / (n * n)};

      for (PetscInt d = 0; d < core->grid.dim; d++)
        if (t.g[i][d] != 0) mark[MPMStaticPlace(s, ijk)] = 1;
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(VecRestoreArray(here, &mark));
  PetscCall(DMCreateGlobalVector(s->numbers, strained));
  PetscCall(VecSet(*strained, 0));
  PetscCall(DMLocalToGlobal(s->numbers, here, ADD_VALUES, *strained));
  PetscCall(VecDestroy(&here));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets value[...], as long as `at`, to own [n], one number of each own unknown, also where other processes have them;
   `none` where there is no unknown. */
PetscErrorCode MPMStaticSpread(struct MPMStatic *s, const PetscReal own[], PetscReal none, PetscReal value[])
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

    MPMStaticWhere(s, q, ijk);
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
PetscInt MPMStaticOrder(const struct MPMStatic *s)
{
  return s->core->basis == MPM_BASIS_bspline3 ? 4 : s->core->basis == MPM_BASIS_bspline2 ? 3 : 2;
}

/* Makes a matrix of the unknowns with room for all that they may couple with: those within `reach` on all axes, and
   along one axis those within the order of the stabilisation. */
PetscErrorCode MPMStaticCreateMatrix(struct MPMStatic *s, PetscInt reach, Mat *A)
{
  const PetscInt dim = s->core->grid.dim, far = PetscMax(reach, MPMStaticOrder(s));
  PetscInt      *own, *other, begin, end;

  PetscFunctionBeginUser;
  PetscCall(VecGetOwnershipRange(s->u, &begin, &end));
  PetscCall(PetscCalloc2(s->n * dim, &own, s->n * dim, &other));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt ijk[3], from[3] = {0}, to[3] = {0}, n[2] = {0};

    MPMStaticWhere(s, q, ijk);
    for (PetscInt d = 0; d < dim; d++) {
      from[d] = PetscMax(ijk[d] - far, s->lo[d]) - ijk[d];
      to[d]   = PetscMin(ijk[d] + far, s->lo[d] + s->wide[d] - 1) - ijk[d];
    }
    for (PetscInt k = from[2]; k <= to[2]; k++)
      for (PetscInt j = from[1]; j <= to[1]; j++)
        for (PetscInt i = from[0]; i <= to[0]; i++) {
          const PetscInt  there[3] = {ijk[0] + i, ijk[1] + j, ijk[2] + k};
          const PetscBool line     = (PetscBool)((i != 0) + (j != 0) + (k != 0) <= 1);
          const PetscBool box      = (PetscBool)(PetscAbsInt(i) <= reach && PetscAbsInt(j) <= reach &&
                                            PetscAbsInt(k) <= reach);
          const PetscInt  number   = s->at[MPMStaticPlace(s, there)];

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
  if (grid->dim == 1 || grid->round) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(s->u, &where));
  PetscCall(VecSetBlockSize(where, grid->dim));
  PetscCall(VecGetArray(where, &x));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt  ijk[3];
    PetscReal at[3];

    MPMStaticWhere(s, q, ijk);
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
  PetscInt        most  = 0, begin, size, x[3], m[3];
  PetscReal      *own, *value;
  PetscScalar    *mark;
  Vec             strained;

  PetscFunctionBeginUser;
  PetscCall(CreateNumbers(s, PetscMax(Reach(s), MPMStaticOrder(s))));
  size = s->wide[0] * s->wide[1] * s->wide[2];
  PetscCall(PetscMalloc1(size, &s->at));
  for (PetscInt k = 0; k < size; k++) s->at[k] = -1;
  PetscCall(FindStrained(s, &strained));
  PetscCall(DMDAGetCorners(s->numbers, &x[0], &x[1], &x[2], &m[0], &m[1], &m[2]));
  for (PetscInt d = 0; d < dim; d++) x[d] -= core->grid.layers[d];
  PetscCall(VecGetArray(strained, &mark));
  PetscCall(MPMExchangeOpenNodes(core));
  for (int pass = 0; pass < 2; pass++) {
    s->n = 0;
    MPM_FOR_OWN_ROWS(patch, r)
    for (PetscInt i = r.first; i < r.last; i++) {
      const PetscInt k = ((r.ijk[2] - x[2]) * m[1] + r.ijk[1] - x[1]) * m[0] + r.ijk[0] + i - x[0];

      if (!(r.sum[i].m > 0) && !(mark[k] > 0)) continue;
      if (pass) s->node[s->n] = r.row * patch->n[0] + i;
      s->n++;
    }
    if (!pass) PetscCall(PetscMalloc1(PetscMax(1, s->n), &s->node));
  }
  PetscCall(MPMExchangeCloseNodes(core));
  PetscCall(VecRestoreArray(strained, &mark));
  PetscCall(VecDestroy(&strained));
  most = s->n;
  PetscCallMPI(MPI_Scan(&most, &begin, 1, MPIU_INT, MPI_SUM, core->exchange.data));
  begin -= s->n;
  PetscCall(PetscMalloc2(PetscMax(1, s->n), &own, size, &value));
  for (PetscInt q = 0; q < s->n; q++) own[q] = (PetscReal)(begin + q);
  PetscCall(MPMStaticSpread(s, own, -1, value));
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
  PetscCall(MPMStaticCreateMatrix(s, Reach(s), &s->K));
  PetscCall(SetRigidMotions(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}
