/* unit_tensor.c - logarithm, exponential, floor, quotients and small matrices, against long double and against plain loops. */
#include "base/tensor.h"
#include "unit.h"

/* Error of MPMLog in units of the last place of the result. */
static void Log(PetscReal x)
{
  const PetscReal   got   = MPMLog(x);
  const long double exact = logl((long double)x);
  const PetscReal   near  = PetscAbsReal((PetscReal)exact);
  int               e;

  UnitContext("x = %.17g = %a", x, x);
  if (exact == 0) {
    CHECK_EQ(got, 0);
    return;
  }
  frexp(near, &e);
  CHECK_LE(fabsl(got - exact) / ldexpl(1, e - 53), 1.0L);
}

static void TestLog(void)
{
  PetscReal last = -INFINITY;

  for (int k = 0; k < 300000; k++) Log(UnitReal(0.5, 1) * ldexp(1, UnitInt(1992) - 996)); /* 1e-300 .. 1e300 */
  for (int k = 0; k < 100000; k++) Log(UnitReal(0.5, 2));
  for (int k = 0; k < 100000; k++) Log(1 + UnitReal(-1, 1) * ldexp(1, -UnitInt(52)));
  for (int k = -2000; k <= 2000; k++) {
    Log(UnitStep(1, k));
    Log(UnitStep(PETSC_SQRT2, k)); /* where the reduced argument jumps */
    Log(UnitStep(PETSC_SQRT2 / 2, k));
  }
  for (int k = -1022; k <= 1023; k++)
    for (int j = -2; j <= 2; j++)
      if (k > -1022 || j >= 0) Log(UnitStep(ldexp(1, k), j));
  Log(DBL_MIN);
  Log(DBL_MAX);
  CHECK_EQ(MPMLog(1), 0);
  UnitContext("steps in x");
  for (int k = -2000; k <= 2000; k++) { /* monotonic where ln is steep enough */
    CHECK_GE(MPMLog(UnitStep(1, k)), last);
    last = MPMLog(UnitStep(1, k));
  }
}

static void Floor(PetscReal x)
{
  UnitContext("x = %.17g", x);
  CHECK_EQ((PetscReal)MPMFloor(x), floor(x));
}

static void TestFloor(void)
{
  for (int k = 0; k < 100000; k++) Floor(UnitReal(-1e6, 1e6));
  for (int k = 0; k < 100000; k++) Floor(UnitReal(-3, 3));
  for (PetscInt i = -100; i <= 100; i++)
    for (int k = -3; k <= 3; k++) {
      Floor(UnitStep(i, k));
      Floor(UnitStep(1e9 + i, k));
      Floor(UnitStep(-1e9 + i, k));
    }
  Floor(-0.0);
  Floor(DBL_TRUE_MIN);
  Floor(-DBL_TRUE_MIN);
}

/* Determinant by permutations, and the sum of the absolute terms. */
static void Divide(PetscReal a, PetscReal b)
{
  UnitContext("%a / %a", a, b);
  CHECK_EQ((PetscReal)MPMDivide(a, b, 1 / b), a / b);
}

/* MPMDivide has the bits of the quotient, in particular where that is next to a whole number. */
static void TestDivide(void)
{
  for (int k = 0; k < 300000; k++) {
    const PetscReal b = UnitReal(1, 2) * ldexp(1, UnitInt(60) - 30), cells = UnitInt(1000000);

    Divide(UnitReal(-10, 1e6) * b, b);
    Divide(UnitReal(0, 1) * ldexp(1, -UnitInt(200)), b);
    for (int step = -2; step <= 2; step++) {
      Divide(UnitStep(cells * b, step), b);
      Divide(UnitStep((cells + 0.5) * b, step), b);
      Divide(UnitStep(cells + 1, step), UnitStep(2, -1 - UnitInt(8)));
    }
  }
}

static long double Det(int dim, const PetscReal *F, long double *size)
{
  long double det = 0;

  *size = 0;
  for (int a = 0; a < dim; a++)
    for (int b = 0; b < (dim > 1 ? dim : 1); b++)
      for (int c = 0; c < (dim > 2 ? dim : 1); c++) {
        long double term = F[a];
        int         sign = 1;

        if (dim > 1 && (a == b || (dim > 2 && (c == a || c == b)))) continue;
        if (dim > 1) term *= F[dim + b];
        if (dim > 2) term *= F[2 * dim + c];
        if (dim == 2) sign = a < b ? 1 : -1;
        if (dim == 3) sign = (b - a + 3) % 3 == 1 ? 1 : -1;
        det += sign * term;
        *size += fabsl(term);
      }
  return det;
}

static void Matrices(int dim, const PetscReal *F, const PetscReal *L, PetscReal dt)
{
  PetscReal         b[6], G[9];
  long double       size;
  const long double det = Det(dim, F, &size);

  UnitContext("dim %d, F = %g %g %g ...", dim, F[0], F[1], F[2]);
  CHECK_LE(fabsl(MPMDet(dim, F) - det), 4 * DBL_EPSILON * size);
  MPMLeftCauchyGreen(dim, F, b);
  for (int d = 0; d < 3; d++)
    for (int e = 0; e < 3; e++) {
      long double s = 0, sum = 0;

      if (d < dim && e < dim)
        for (int k = 0; k < dim; k++) {
          s += (long double)F[d * dim + k] * F[e * dim + k];
          sum += fabsl((long double)F[d * dim + k] * F[e * dim + k]);
        }
      else
        s = d == e ? 1 : 0;
      CHECK_LE(fabsl(b[MPMSymIndex(d, e)] - s), 3 * DBL_EPSILON * sum);
    }
  memcpy(G, F, sizeof G);
  MPMDeform(dim, dt, L, G);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      long double s = F[d * dim + e], sum = fabsl(s);

      for (int k = 0; k < dim; k++) {
        s += (long double)dt * L[d * dim + k] * F[k * dim + e];
        sum += fabsl((long double)dt * L[d * dim + k] * F[k * dim + e]);
      }
      CHECK_LE(fabsl(G[d * dim + e] - s), 5 * DBL_EPSILON * sum);
    }
}

static void TestMatrices(void)
{
  static const int index[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}}; /* xx xy xz yy yz zz */

  for (int d = 0; d < 3; d++)
    for (int e = 0; e < 3; e++) CHECK_EQ(MPMSymIndex(d, e), index[d][e]);
  for (int dim = 1; dim <= 3; dim++)
    for (int k = 0; k < 20000; k++) {
      const PetscReal scale = ldexp(1, UnitInt(60) - 30);
      PetscReal       F[9], L[9];

      for (int i = 0; i < 9; i++) {
        F[i] = k % 2 ? UnitReal(-scale, scale) : (i % (dim + 1) == 0) + UnitReal(-0.1, 0.1);
        L[i] = UnitReal(-1, 1);
      }
      Matrices(dim, F, L, UnitReal(0, 1));
      { /* det(A F) = det A det F, with A = I + dt L */
        PetscReal A[9], G[9], bound = dim == 3 ? 6 : dim;

        for (int i = 0; i < 9; i++) A[i] = i % (dim + 1) == 0;
        memcpy(G, F, sizeof G);
        MPMDeform(dim, 0.5, L, A);
        MPMDeform(dim, 0.5, L, G);
        bound *= 64 * DBL_EPSILON * PetscPowReal(PetscMax(scale, 2.0) * 3, dim);
        CHECK_NEAR(MPMDet(dim, G), MPMDet(dim, A) * MPMDet(dim, F), bound);
      }
    }
}

/* Error of MPMExp in units of the last place of the result, of the smallest number where that is larger. */
static void Exp(PetscReal x)
{
  const PetscReal   got   = MPMExp(x);
  const long double exact = expl((long double)x);
  int               e;

  UnitContext("x = %.17g = %a", x, x);
  frexp((PetscReal)exact, &e);
  CHECK_LE(fabsl(got - exact) / ldexpl(1, PetscMax(e - 53, -1074)), 1.0L);
}

static void TestExp(void)
{
  const PetscReal top = 7.09782712893383973096e+02, bottom = -7.45133219101941108420e+02; /* fdlibm's limits */
  PetscReal       last = 0;

  for (int k = 0; k < 300000; k++) Exp(UnitReal(-708, 709.7));
  for (int k = 0; k < 300000; k++) Exp(UnitReal(-2, 2));
  for (int k = 0; k < 100000; k++) Exp(UnitReal(-1, 1) * ldexp(1, -UnitInt(60)));
  for (int k = 0; k < 100000; k++) Exp(UnitReal(-745.2, -708)); /* subnormal */
  for (int k = -2200; k <= 2020; k++)
    for (int j = -2; j <= 2; j++)
      if (k * 0.5 * 0.6931471805599453 < top) Exp(UnitStep(k * 0.5 * 0.6931471805599453, j)); /* where k jumps */
  for (int k = 0; k <= 100; k++) Exp(UnitStep(top, -k));
  UnitContext("limits");
  CHECK_EQ(MPMExp(0), 1);
  CHECK_EQ(MPMExp(-0.0), 1);
  CHECK_LE(MPMExp(top), DBL_MAX);
  CHECK_EQ(MPMExp(UnitStep(top, 1)), INFINITY);
  CHECK_EQ(MPMExp(711), INFINITY);
  CHECK_EQ(MPMExp(1e300), INFINITY);
  CHECK_EQ(MPMExp(INFINITY), INFINITY);
  CHECK_GE(MPMExp(bottom), DBL_TRUE_MIN);
  CHECK_EQ(MPMExp(-745.2), 0);
  CHECK_EQ(MPMExp(-747), 0);
  CHECK_EQ(MPMExp(-1e300), 0);
  CHECK_EQ(MPMExp(-INFINITY), 0);
  CHECK(MPMExp(NAN) != MPMExp(NAN));
  for (int k = -2000; k <= 2000; k++) {
    CHECK_GE(MPMExp(UnitStep(1, k)), last);
    last = MPMExp(UnitStep(1, k));
  }
  for (int k = 0; k < 100000; k++) { /* the other way */
    const PetscReal x = UnitReal(-600, 600);

    UnitContext("x = %.17g", x);
    CHECK_NEAR(MPMLog(MPMExp(x)), x, DBL_EPSILON * (1 + fabs(x)));
  }
}

/* a = V^T D V with V orthonormal, both to a few units in the last place of the norm. */
static void Eigen(int dim, const PetscReal a[6])
{
  PetscReal values[3], n[3][3], norm = 0, back[6];

  for (int k = 0; k < 6; k++) norm = PetscMax(norm, fabs(a[k]));
  if (norm > 0 && norm < 1e-140) return; /* squares vanish */
  UnitContext("dim %d, a = %a %a %a %a %a %a", dim, a[0], a[1], a[2], a[3], a[4], a[5]);
  MPMEigen(dim, a, values, n);
  for (int j = 0; j < 3; j++)
    for (int k = 0; k < 3; k++) {
      long double dot = 0, s = 0;

      for (int d = 0; d < 3; d++) {
        dot += (long double)n[j][d] * n[k][d];
        s += (long double)values[d] * n[d][j] * n[d][k];
      }
      CHECK_LE(fabsl(dot - (j == k)), 16 * DBL_EPSILON);
      CHECK_LE(fabsl(s - a[MPMSymIndex(j, k)]), 24 * DBL_EPSILON * norm);
    }
  for (int j = 0; j < 3; j++) /* a n = value n */
    for (int d = 0; d < 3; d++) {
      long double s = 0;

      for (int e = 0; e < 3; e++) s += (long double)a[MPMSymIndex(d, e)] * n[j][e];
      CHECK_LE(fabsl(s - (long double)values[j] * n[j][d]), 24 * DBL_EPSILON * norm);
    }
  MPMSpectral(dim, values, n, back);
  for (int k = 0; k < 6; k++) CHECK_NEAR(back[k], a[k], 32 * DBL_EPSILON * norm);
}

static void TestEigen(void)
{
  static const PetscReal gaps[] = {0, 1e-300, 1e-17, 1e-16, 1e-15, 1e-12, 1e-8, 1e-4, 0.1, 1, 10};

  for (int dim = 1; dim <= 3; dim++) {
    PetscReal a[6] = {0};

    for (int k = 0; k < 60000; k++) {
      const PetscReal scale = ldexp(1, k % 3 ? 0 : UnitInt(200) - 100), gap = gaps[UnitInt(11)],
                      shear = gaps[UnitInt(11)];

      for (int d = 0; d < 3; d++)
        for (int e = d; e < 3; e++)
          a[MPMSymIndex(d, e)] = scale * (d == e               ? (k % 2) + gap * UnitReal(-1, 1)
                                          : d < dim && e < dim ? shear * UnitReal(-1, 1)
                                                               : 0);
      Eigen(dim, a);
    }
    for (int k = 0; k < 6; k++) a[k] = MPMSymUnit(3, k); /* exact where there is nothing to turn */
    for (int k = 0; k < 2; k++) {
      PetscReal values[3], n[3][3];

      MPMEigen(dim, a, values, n);
      for (int d = 0; d < 3; d++) {
        CHECK_EQ(values[d], a[MPMSymIndex(d, d)]);
        for (int e = 0; e < 3; e++) CHECK_EQ(n[d][e], d == e);
      }
      a[0] = 3;
      a[5] = 0;
    }
    memset(a, 0, sizeof a);
    Eigen(dim, a);
  }
  for (int k = 0; k < 60000; k++) { /* one component and all zeros but it */
    PetscReal a[6] = {0};

    a[UnitInt(6)] = UnitReal(-1, 1);
    a[UnitInt(6)] = UnitReal(-1, 1);
    Eigen(3, a);
  }
  for (int k = 0; k < 20000; k++) { /* positive, graded: a = D C D, C near 1. The small ones to their own last places */
    PetscReal   D[3], a[6], values[3], n[3][3];
    long double det, product = 1, A[9];

    for (int d = 0; d < 3; d++) D[d] = pow(10, UnitReal(-6, 0));
    for (int d = 0; d < 3; d++)
      for (int e = d; e < 3; e++) a[MPMSymIndex(d, e)] = D[d] * D[e] * (d == e ? 1 : UnitReal(-0.3, 0.3));
    for (int d = 0; d < 3; d++)
      for (int e = 0; e < 3; e++) A[3 * d + e] = a[MPMSymIndex(d, e)];
    det = A[0] * (A[4] * A[8] - A[5] * A[7]) - A[1] * (A[3] * A[8] - A[5] * A[6]) + A[2] * (A[3] * A[7] - A[4] * A[6]);
    Eigen(3, a);
    MPMEigen(3, a, values, n);
    for (int d = 0; d < 3; d++) product *= values[d];
    CHECK_LE(fabsl(product / det - 1), 1e-14L);
  }
}

int main(void)
{
  TestLog();
  TestExp();
  TestFloor();
  TestDivide();
  TestMatrices();
  TestEigen();
  return UnitEnd();
}
