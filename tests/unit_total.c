/* unit_total.c - the tensors of the total frame (kernels/total.h): quotients, the first Piola-Kirchhoff stress, and the bound
   of wave speeds over reference lengths. */
#include "kernels/total.h"
#include "unit.h"

/* Sets C = A B. */
static void Product(int dim, const PetscReal *A, const PetscReal *B, PetscReal *C)
{
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      C[d * dim + e] = 0;
      for (int k = 0; k < dim; k++) C[d * dim + e] += A[d * dim + k] * B[k * dim + e];
    }
}

static void TestDim(int dim)
{
  static MPMBlock      b;
  static PetscInt      ahead[MPM_WIDTH];
  static MPMBlockOrder one = {.n = 1, .lanes = 1, .ahead = ahead};

  for (int n = 0; n < 200; n++) {
    PetscReal F[9], A[9], Q[9], back[9], S[9], P[9], transposed[9], lcg[6], squares[3], axes[3][3],
        least          = PETSC_MAX_REAL, bar;
    const int    round = dim == 2 && n % 3 == 0; /* of bodies of revolution */
    MPMComponent c2;

    for (int k = 0; k < dim * dim; k++) {
      F[k] = (k % (dim + 1) == 0) + UnitReal(-0.3, 0.3);
      A[k] = UnitReal(-1, 1);
      S[k] = P[k] = UnitReal(-1, 1);
      b.F[k][0]   = F[k];
    }
    if (!(MPMDet(dim, F) > 0.05)) continue;
    MPMQuotient(dim, A, F, Q);
    Product(dim, Q, F, back);
    bar = n % 2 ? UnitReal(0.5, 2) : 1; /* that of F-bar, in every other case */
    MPMPiola(dim, &(MPMView){.F = F, .bar = n % 2 ? &bar : NULL}, &one, &b, 0, P);
    for (int d = 0; d < dim; d++)
      for (int e = 0; e < dim; e++) transposed[d * dim + e] = bar * F[e * dim + d];
    Product(dim, P, transposed, Q);
    UnitContext("dim %d, case %d", dim, n);
    for (int k = 0; k < dim * dim; k++) {
      CHECK_LE(PetscAbsReal(back[k] - A[k]), 1e-12); /* (A F^-1) F */
      CHECK_LE(PetscAbsReal(Q[k] - S[k]), 1e-12);    /* P F^T, with the F of the motion */
    }
    c2[0]       = 3;
    b.F33[0][0] = UnitReal(0.3, 1.5);
    MPMReferenceSpeed2(dim, round, &b, 0, 1, c2);
    MPMLeftCauchyGreen(dim, F, lcg);
    MPMEigen(dim, lcg, squares, axes);
    for (int d = 0; d < dim; d++) least = PetscMin(least, squares[d]);
    if (round) least = PetscMin(least, b.F33[0][0] * b.F33[0][0]);
    CHECK_GE(c2[0] * least, 3 * (1 - 1e-12)); /* not below that over the least stretch, and at most dim times it */
    CHECK_LE(c2[0] * least, 3 * dim * (1 + 1e-12));
  }
}

int main(void)
{
  for (int dim = 1; dim <= 3; dim++) TestDim(dim);
  return UnitEnd();
}
