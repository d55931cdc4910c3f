/* static_memory.c - the memory of implicit steps: that of their matrices, which have room before the first step, and that of
   what PETSc's solvers make of them, which is foretold by what was measured, and told by the objects themselves after the last
   solve. */
#include "physics/tangent.h"
#include "step/static.h"

#define ENTRY ((PetscReal)(sizeof(PetscScalar) + sizeof(PetscInt))) /* of a matrix: a number and its column */

/* What was measured: entries of LU factors by PETSc's nested dissection over those of the matrix, which grow with a power of
   the number of unknowns; entries of all coarser levels and prolongations of GAMG; and vectors of a step and of GMRES with its
   restart. */
#define FACTORS_1D    1.3
#define FACTORS_2D    0.55
#define FACTORS_HATS  0.33 /* of hats, whose nodes have fewer neighbours */
#define POWER_2D      0.27
#define FACTORS_3D    0.25
#define LEVELS        0.06
#define VECTORS       12
#define GMRES_VECTORS 104

/* Returns how many times the entries of the tangent its LU factors have, about. */
static PetscReal Fill(const struct MPMStatic *s, PetscReal unknowns)
{
  const PetscReal hats = s->core->basis == MPM_BASIS_linear ? FACTORS_HATS : FACTORS_2D;

  if (s->core->grid.dim == 1) return FACTORS_1D;
  if (s->core->grid.dim == 2) return PetscMax(1, hats * PetscPowReal(unknowns, POWER_2D));
  return PetscMax(1, FACTORS_3D * PetscPowReal(unknowns, 1. / 3));
}

/* Adds to *bytes what a matrix takes, here or, with MAT_GLOBAL_SUM, on all processes. */
static PetscErrorCode AddBytes(Mat A, MatInfoType where, PetscReal *bytes)
{
  MatInfo info;

  PetscFunctionBeginUser;
  if (!A) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatGetInfo(A, where, &info));
  *bytes += PetscMax(info.nz_allocated, info.nz_used) * ENTRY;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds what the factors of a solver by LU take on this process, once it has solved; *known: it has. */
static PetscErrorCode AddFactors(KSP ksp, PetscReal *bytes, PetscBool *known)
{
  PC  pc;
  Mat F;

  PetscFunctionBeginUser;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCLU, known));
  if (!*known) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCFactorGetMatrix(pc, &F));
  PetscCall(AddBytes(F, MAT_LOCAL, bytes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the matrices of the coarser levels of multigrid and the prolongations, on all processes. */
static PetscErrorCode AddLevels(PC pc, PetscReal *bytes)
{
  PetscInt levels;

  PetscFunctionBeginUser;
  PetscCall(PCMGGetLevels(pc, &levels));
  for (PetscInt k = 0; k < levels; k++) {
    KSP ksp;
    Mat A, P;

    if (k + 1 < levels) { /* the finest one is the tangent */
      PetscCall(PCMGGetSmoother(pc, k, &ksp));
      PetscCall(KSPGetOperators(ksp, NULL, &A));
      PetscCall(AddBytes(A, MAT_GLOBAL_SUM, bytes));
    }
    if (!k) continue;
    PetscCall(PCMGGetInterpolation(pc, k, &P));
    PetscCall(AddBytes(P, MAT_GLOBAL_SUM, bytes));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticMatrixBytes(const struct MPMStatic *s, PetscBool all, PetscReal *bytes)
{
  const MatInfoType where = all ? MAT_GLOBAL_SUM : MAT_LOCAL;

  PetscFunctionBeginUser;
  *bytes = 0;
  PetscCall(AddBytes(s->K, where, bytes));
  PetscCall(AddBytes(s->ghosts, where, bytes));
  PetscCall(AddBytes(s->M, where, bytes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticForetellBytes(const struct MPMStatic *s, PetscReal *bytes)
{
  KSP         ksp;
  PC          pc;
  PetscBool   lu, redundant, multigrid;
  PetscMPIInt size;
  PetscInt    unknowns;
  PetscReal   K = 0;

  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(s->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &lu, PCLU, PCCHOLESKY, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &redundant, PCREDUNDANT, PCSHELL, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &multigrid, PCGAMG, PCMG, ""));
  PetscCall(AddBytes(s->K, MAT_GLOBAL_SUM, &K));
  PetscCall(VecGetSize(s->u, &unknowns));
  PetscCallMPI(MPI_Comm_size(s->core->exchange.data, &size));
  *bytes = 0;
  if (lu) *bytes = K * Fill(s, (PetscReal)unknowns);
  if (redundant) *bytes = size * K * (1 + Fill(s, (PetscReal)unknowns)); /* each has the whole matrix too */
  if (multigrid) *bytes = K * LEVELS;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticSolverBytes(const struct MPMStatic *s, PetscReal *bytes, PetscBool *known)
{
  KSP         ksp, inner;
  PC          pc;
  PetscBool   redundant, multigrid, solved;
  PetscMPIInt size;

  PetscFunctionBeginUser;
  *bytes = 0;
  *known = PETSC_FALSE;
  PetscCall(SNESGetKSP(s->snes, &ksp));
  PetscCall(KSPGetOperatorsSet(ksp, &solved, NULL)); /* not if the last solve found a bad state at once */
  if (!solved) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &redundant, PCREDUNDANT, PCSHELL, ""));
  PetscCall(PetscObjectTypeCompareAny((PetscObject)pc, &multigrid, PCGAMG, PCMG, ""));
  if (multigrid) {
    *known = PETSC_TRUE;
    PetscCall(AddLevels(pc, bytes));
  } else if (redundant) {
    Mat A;

    PetscCallMPI(MPI_Comm_size(s->core->exchange.data, &size));
    PetscCall(MPMStaticWholeSolver(pc, &inner));
    if (!inner) PetscCall(PCRedundantGetKSP(pc, &inner));
    PetscCall(AddFactors(inner, bytes, known));
    PetscCall(KSPGetOperators(inner, NULL, &A));
    if (size > 1) PetscCall(AddBytes(A, MAT_LOCAL, bytes));
    *bytes *= size;
  } else
    PetscCall(AddFactors(ksp, bytes, known));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticLaterBytes(const struct MPMStatic *s, PetscReal *bytes)
{
  const MPMCore *core = s->core;
  const PetscInt dim = core->grid.dim, nc = MPMTangentNumbers(dim, core->grid.round);
  KSP            ksp;
  PetscBool      gmres;
  PetscMPIInt    size;
  PetscReal      solver;

  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(s->snes, &ksp));
  PetscCall(PetscObjectTypeCompare((PetscObject)ksp, KSPGMRES, &gmres));
  PetscCallMPI(MPI_Comm_size(core->exchange.data, &size));
  PetscCall(MPMStaticMatrixBytes(s, PETSC_FALSE, bytes));
  PetscCall(MPMStaticForetellBytes(s, &solver));
  *bytes += solver / size + (PetscReal)(core->particles.n * (dim * dim + nc * nc + 2 * nc + 2)) * sizeof(PetscReal);
  *bytes += (PetscReal)(s->n * dim * (gmres ? VECTORS + GMRES_VECTORS : VECTORS)) * sizeof(PetscReal);
  PetscFunctionReturn(PETSC_SUCCESS);
}
