/* static_matrix.c - the tangent stiffness of a static step, summed particle by particle. */
#include "step/static_tangent.h"

/* Adds the stiffness of a particle to that of the nodes of its stencil, [nodes dim][nodes dim]. */
static void AddParticle(PetscInt dim, const MPMStaticNodes *t, const MPMStaticParticle *q, PetscScalar stiffness[])
{
  const PetscInt n = t->n * dim, nc = q->nc;

  for (PetscInt i = 0; i < t->n; i++)
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal half[MPM_STATIC_NC]; /* V0 A_aBcD d_B phi_i, [c][D] */

      for (PetscInt k = 0; k < nc; k++) {
        half[k] = -q->B[a * nc + k] * t->w[i];
        for (PetscInt e = 0; e < dim; e++) half[k] += q->A[(a * dim + e) * nc + k] * t->g[i][e];
        if (nc > dim * dim && a == 0) half[k] += q->A[dim * dim * nc + k] * t->w[i] / t->r;
      }
      for (PetscInt j = 0; j < t->n; j++)
        for (PetscInt c = 0; c < dim; c++)
          stiffness[(i * dim + a) * n + j * dim + c] += MPMStaticAlong(dim, nc, t, j, c, half);
    }
}

/* Takes from b what displacements x of held components do to the others. Products are multiples of a grain, so that their sum is
   exact: b has the same bits however the grid is cut. */
static PetscErrorCode TakeKnown(struct MPMStatic *s, Mat K, Vec x, Vec b)
{
  const PetscScalar *known;
  PetscScalar       *force;
  PetscReal          most, grain;
  PetscInt           begin;
  VecScatter         gather;
  Vec                all;

  PetscFunctionBeginUser;
  PetscCall(VecNorm(x, NORM_INFINITY, &most));
  grain = s->grain * PetscPowReal(2, PetscCeilReal(PetscLog2Real(PetscMax(most, PETSC_SMALL * PETSC_SMALL))));
  PetscCall(VecGetOwnershipRange(x, &begin, NULL));
  PetscCall(VecScatterCreateToAll(x, &gather, &all));
  PetscCall(VecScatterBegin(gather, x, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(gather, x, all, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterDestroy(&gather));
  PetscCall(VecGetArrayRead(all, &known));
  PetscCall(VecGetArray(b, &force));
  for (PetscInt k = 0; k < s->n * s->core->grid.dim; k++) {
    const PetscInt     row = begin + k;
    const PetscInt    *columns;
    const PetscScalar *values;
    PetscInt           n;
    PetscReal          sum = 0;

    PetscCall(MatGetRow(K, row, &n, &columns, &values));
    for (PetscInt j = 0; j < n; j++)
      if (known[columns[j]] != 0) sum += MPMStaticGrain(values[j] * known[columns[j]], grain);
    PetscCall(MatRestoreRow(K, row, &n, &columns, &values));
    force[k] = s->held[k] ? s->nominal * known[row] : force[k] - sum;
  }
  PetscCall(VecRestoreArray(b, &force));
  PetscCall(VecRestoreArrayRead(all, &known));
  PetscCall(VecDestroy(&all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces the rows and columns of what walls hold. */
static PetscErrorCode ReplaceHeld(struct MPMStatic *s, Mat K, Vec x, Vec b)
{
  const PetscInt dim = s->core->grid.dim;
  PetscInt      *rows, n = 0, begin;

  PetscFunctionBeginUser;
  if (x) PetscCall(TakeKnown(s, K, x, b));
  PetscCall(VecGetOwnershipRange(s->u, &begin, NULL));
  PetscCall(PetscMalloc1(PetscMax(1, s->n * dim), &rows));
  for (PetscInt k = 0; k < s->n * dim; k++)
    if (s->held[k]) rows[n++] = begin + k;
  PetscCall(MatZeroRowsColumns(K, n, rows, s->nominal, NULL, NULL));
  PetscCall(PetscFree(rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to the stiffness of a cell what particles `from` to `to` - 1 of the order, all that it has of one material or more, do to
   each other by F-bar: outer products of what forces do by the two means, and what these do by displacements. */
static PetscErrorCode AddMeans(struct MPMStatic *s, MPMStaticLaw *law, PetscInt from, PetscInt to,
                               PetscScalar stiffness[])
{
  const MPMCore  *core = s->core;
  const PetscInt  dim = core->grid.dim, nc = law->law.round ? dim * dim + 1 : dim * dim;
  const PetscInt *order = core->particles.order;
  MPMStaticNodes  t;
  MPMStaticMeans  means;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < core->params.nmaterials; m++) {
    PetscReal sides[3][MPM_STATIC_NODES * 3] = {{0}}; /* forces by theta; theta; eta */
    PetscBool any                            = PETSC_FALSE;
    PetscInt  n                              = 0;

    MPMStaticFindMeans(s, law, m, from, to, &means);
    for (PetscInt k = from; k < to; k++) {
      MPMStaticParticle q;

      if (MPMKindOf(core->params.kinds, &law->view, order[k])->material != m) continue;
      PetscCall(MPMStaticParticleTangent(s, law, &means, order[k], &q));
      MPMStaticStencil(s, &law->view, order[k], &t);
      AddParticle(dim, &t, &q, stiffness);
      any = PETSC_TRUE;
      n   = t.n * dim;
      for (PetscInt i = 0; i < n && core->params.box; i++) {
        const PetscInt node = i / dim, d = i % dim;

        sides[0][i] += MPMStaticAlong(dim, nc, &t, node, d, q.forces) - q.body[d] * t.w[node];
        sides[1][i] += MPMStaticAlong(dim, nc, &t, node, d, q.theta);
        sides[2][i] += MPMStaticAlong(dim, nc, &t, node, d, q.eta);
      }
    }
    for (PetscInt i = 0; i < n && any && core->params.box; i++)
      for (PetscInt j = 0; j < n; j++)
        stiffness[i * n + j] += sides[0][i] * sides[1][j] + means.weight * sides[1][i] * sides[2][j];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the stiffness of all particles here, those of a cell together. */
static PetscErrorCode AddParticles(struct MPMStatic *s, Mat K)
{
  MPMCore        *core  = s->core;
  const PetscInt *order = core->particles.order, n = core->particles.n;
  PetscInt        nodes = 1, size;
  PetscScalar    *stiffness;
  MPMStaticNodes  cell;
  MPMStaticLaw    law;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < core->grid.dim; d++) nodes *= MPMBasisNodes(core->basis);
  size = PetscSqr(nodes * core->grid.dim);
  PetscCall(PetscMalloc1(size, &stiffness));
  PetscCall(MPMStaticLawBegin(s, &law));
  for (PetscInt from = 0, to; from < n; from = to) {
    for (to = from + 1; to < n && law.view.cell[order[to]] == law.view.cell[order[from]];) to++;
    PetscCall(PetscArrayzero(stiffness, size));
    PetscCall(AddMeans(s, &law, from, to, stiffness));
    for (PetscInt k = 0; k < size && s->grain > 0; k++) stiffness[k] = MPMStaticGrain(stiffness[k], s->grain);
    MPMStaticStencil(s, &law.view, order[from], &cell);
    PetscCall(MatSetValuesBlocked(K, cell.n, cell.number, cell.n, cell.number, stiffness, ADD_VALUES));
  }
  PetscCall(MPMStaticLawEnd(s, &law));
  PetscCall(PetscFree(stiffness));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a constant matrix to K, so many times, row by row. */
static PetscErrorCode AddMatrix(Mat K, Mat A, PetscReal times)
{
  PetscInt     begin, end, n, most = 0;
  PetscScalar *row = NULL;

  PetscFunctionBeginUser;
  PetscCall(MatGetOwnershipRange(A, &begin, &end));
  for (PetscInt i = begin; i < end; i++) {
    const PetscInt    *columns;
    const PetscScalar *values;

    PetscCall(MatGetRow(A, i, &n, &columns, &values));
    if (n > most) PetscCall(PetscRealloc((size_t)(most = n) * sizeof *row, &row));
    for (PetscInt k = 0; k < n; k++) row[k] = times * values[k];
    PetscCall(MatSetValues(K, 1, &i, n, columns, row, ADD_VALUES));
    PetscCall(MatRestoreRow(A, i, &n, &columns, &values));
  }
  PetscCall(PetscFree(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticTangent(struct MPMStatic *s, Mat K, Vec x, Vec b)
{
  MPMCore *core = s->core;

  PetscFunctionBeginUser;
  PetscCall(MPMTimersBegin(&core->timers, s->tangent));
  PetscCall(MatZeroEntries(K));
  PetscCall(AddParticles(s, K));
  if (s->ghosts) PetscCall(AddMatrix(K, s->ghosts, 1));
  if (s->M) PetscCall(AddMatrix(K, s->M, s->per));
  PetscCall(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
  PetscCall(ReplaceHeld(s, K, x, b));
  PetscCall(MPMTimersEnd(&core->timers, s->tangent));
  PetscFunctionReturn(PETSC_SUCCESS);
}
