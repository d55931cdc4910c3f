/* static_whole.c - LU of the whole tangent on each process, with the unknowns in the order of the grid's nodes: its factors and
   what it solves have the same bits on any number of processes, as the tangent has (static.h, grain). On several processes it
   takes the place of PETSc's `redundant`, whose order follows the cuts. */
#include "step/static.h"

typedef struct {
  IS         order; /* the unknowns of all processes, in the order of the grid's nodes */
  PetscInt   n;
  PetscInt  *place; /* [n] where own unknowns are in it */
  Mat       *whole; /* one, the tangent in this order */
  VecScatter all;
  Vec        b, x;
  KSP        solver;
} Whole;

/* Finds the order. Collective on exchange.data. */
static PetscErrorCode FindOrder(struct MPMStatic *s, Whole *w)
{
  const MPMGrid  *grid = &s->core->grid;
  const PetscInt  dim  = grid->dim;
  const PetscInt *node;
  PetscInt       *own, *at, *index, begin, total;
  IS              here, all;

  PetscFunctionBeginUser;
  PetscCall(VecGetSize(s->u, &total));
  PetscCall(VecGetOwnershipRange(s->u, &begin, NULL));
  total /= dim;
  PetscCall(PetscMalloc2(PetscMax(1, s->n), &own, total, &at));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt ijk[3];

    MPMStaticWhere(s, q, ijk);
    own[q] = 0;
    for (PetscInt d = dim - 1; d >= 0; d--) own[q] = own[q] * grid->nodes[d] + ijk[d] + grid->layers[d];
  }
  PetscCall(ISCreateGeneral(s->core->exchange.data, s->n, own, PETSC_USE_POINTER, &here));
  PetscCall(ISAllGather(here, &all));
  PetscCall(ISGetIndices(all, &node));
  for (PetscInt k = 0; k < total; k++) at[k] = k;
  PetscCall(PetscSortIntWithPermutation(total, node, at));
  PetscCall(ISRestoreIndices(all, &node));
  PetscCall(ISDestroy(&all));
  PetscCall(ISDestroy(&here));
  w->n = s->n * dim;
  PetscCall(PetscMalloc1(PetscMax(1, w->n), &w->place));
  PetscCall(PetscMalloc1(total * dim, &index));
  for (PetscInt k = 0; k < total * dim; k++) {
    const PetscInt own_k = at[k / dim] * dim + k % dim - begin;

    index[k] = own_k + begin;
    if (own_k >= 0 && own_k < w->n) w->place[own_k] = k;
  }
  PetscCall(PetscFree2(own, at));
  PetscCall(ISCreateGeneral(PETSC_COMM_SELF, total * dim, index, PETSC_OWN_POINTER, &w->order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetUp(PC pc)
{
  Whole         *w;
  Mat            K;
  PC             inner;
  PCFailedReason reason;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &w));
  PetscCall(PCGetOperators(pc, NULL, &K));
  PetscCall(
      MatCreateSubMatrices(K, 1, &w->order, &w->order, w->whole ? MAT_REUSE_MATRIX : MAT_INITIAL_MATRIX, &w->whole));
  /* Without this PETSc 3.18 does not know that the matrix is another, and keeps the factors. */
  PetscCall(MatAssemblyBegin(w->whole[0], MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(w->whole[0], MAT_FINAL_ASSEMBLY));
  PetscCall(KSPSetOperators(w->solver, w->whole[0], w->whole[0]));
  PetscCall(KSPSetUp(w->solver));
  PetscCall(KSPGetPC(w->solver, &inner));
  PetscCall(PCGetFailedReason(inner, &reason));
  PetscCall(PCSetFailedReason(pc, reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(PC pc, Vec b, Vec x)
{
  Whole             *w;
  const PetscScalar *from;
  PetscScalar       *to;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &w));
  PetscCall(VecScatterBegin(w->all, b, w->b, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(VecScatterEnd(w->all, b, w->b, INSERT_VALUES, SCATTER_FORWARD));
  PetscCall(KSPSolve(w->solver, w->b, w->x));
  PetscCall(VecGetArrayRead(w->x, &from));
  PetscCall(VecGetArray(x, &to));
  for (PetscInt k = 0; k < w->n; k++) to[k] = from[w->place[k]];
  PetscCall(VecRestoreArray(x, &to));
  PetscCall(VecRestoreArrayRead(w->x, &from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Destroy(PC pc)
{
  Whole *w;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &w));
  if (w->whole) PetscCall(MatDestroySubMatrices(1, &w->whole));
  PetscCall(KSPDestroy(&w->solver));
  PetscCall(VecScatterDestroy(&w->all));
  PetscCall(VecDestroy(&w->b));
  PetscCall(VecDestroy(&w->x));
  PetscCall(ISDestroy(&w->order));
  PetscCall(PetscFree(w->place));
  PetscCall(PetscFree(w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticWholeCreate(struct MPMStatic *s, PC pc)
{
  Whole   *w;
  PC       inner;
  PetscInt total;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&w));
  PetscCall(FindOrder(s, w));
  PetscCall(VecGetSize(s->u, &total));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, total, &w->b));
  PetscCall(VecDuplicate(w->b, &w->x));
  PetscCall(VecScatterCreate(s->u, w->order, w->b, NULL, &w->all));
  PetscCall(KSPCreate(PETSC_COMM_SELF, &w->solver));
  PetscCall(KSPSetType(w->solver, KSPPREONLY));
  PetscCall(KSPGetPC(w->solver, &inner));
  PetscCall(PCSetType(inner, PCLU));
  PetscCall(PCSetType(pc, PCSHELL));
  PetscCall(PCShellSetName(pc, "lu of the whole on each process"));
  PetscCall(PCShellSetContext(pc, w));
  PetscCall(PCShellSetSetUp(pc, SetUp));
  PetscCall(PCShellSetApply(pc, Apply));
  PetscCall(PCShellSetDestroy(pc, Destroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticWholeSolver(PC pc, KSP *solver)
{
  PetscBool shell;
  Whole    *w;

  PetscFunctionBeginUser;
  *solver = NULL;
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCSHELL, &shell));
  if (!shell) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCShellGetContext(pc, &w));
  if (w) *solver = w->solver; /* that of -pc_type shell has no context */
  PetscFunctionReturn(PETSC_SUCCESS);
}
