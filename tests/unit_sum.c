/* unit_sum.c - MPMSum is exact and without order: the total has the same bits however the addends are shuffled, split
   and reduced. Also runs on several processes, which then share the addends. */
#include "base/exact_sum.h"
#include "unit.h"

#define N 10000

static PetscReal Sum(int n, const PetscReal *x)
{
  MPMSum s;

  MPMSumZero(&s);
  for (int k = 0; k < n; k++) MPMSumAdd(&s, x[k]);
  return MPMSumValue(&s);
}

/* Adds the words of two sums, as the reduction over processes does. Each is carried by a reduction on its own first. */
static PetscErrorCode Join(MPMSum *s, MPMSum *other)
{
  PetscFunctionBeginUser;
  PetscCall(MPMSumReduce(s, 1, PETSC_COMM_SELF));
  PetscCall(MPMSumReduce(other, 1, PETSC_COMM_SELF));
  for (int w = 0; w < MPM_SUM_WORDS; w++) s->word[w] += other->word[w];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Shuffle(int n, PetscReal *x)
{
  for (int k = n - 1; k > 0; k--) {
    const int       j = UnitInt(k + 1);
    const PetscReal t = x[k];
    x[k]              = x[j];
    x[j]              = t;
  }
}

static PetscReal Wide(int range)
{
  return ldexp(UnitReal(-1, 1), UnitInt(2 * range + 1) - range);
}

/* The total `expected` in every order, in parts, on the processes of the world, and negated. */
static PetscErrorCode AnyOrder(int n, PetscReal *x, PetscReal expected)
{
  PetscMPIInt rank, size;
  MPMSum      sum;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  for (int round = 0; round < 5; round++) {
    const PetscReal value = Sum(n, x);
    MPMSum          part[7], s[2];

    CHECK_SAME(&value, &expected, sizeof value);
    for (int j = 0; j < 7; j++) MPMSumZero(&part[j]);
    for (int k = 0; k < n; k++) MPMSumAdd(&part[UnitInt(7)], x[k]);
    for (int j = 1; j < 7; j++) PetscCall(Join(&part[0], &part[j]));
    {
      const PetscReal joined = MPMSumValue(&part[0]), again = MPMSumValue(&part[0]);

      CHECK_SAME(&joined, &expected, sizeof joined);
      CHECK_SAME(&again, &expected, sizeof again); /* reading changes nothing */
      MPMSumAdd(&part[0], -expected);
      MPMSumAdd(&part[0], expected); /* nor does adding after reading, through a change of sign perhaps */
      CHECK_EQ(MPMSumValue(&part[0]), expected);
    }
    MPMSumZero(&s[0]);
    MPMSumZero(&s[1]);
    for (int k = rank; k < n; k += size) {
      MPMSumAdd(&s[0], x[k]);
      MPMSumAdd(&s[1], -x[k]);
    }
    PetscCall(MPMSumReduce(s, 2, PETSC_COMM_WORLD));
    {
      const PetscReal reduced = MPMSumValue(&s[0]), negative = -MPMSumValue(&s[1]);

      CHECK_SAME(&reduced, &expected, sizeof reduced);
      CHECK_EQ(negative, expected);
    }
    Shuffle(n, x);
  }
  for (int k = 0; k < n; k++) x[n + k] = -x[k]; /* all addends and their negatives, mixed: exactly 0 */
  Shuffle(2 * n, x);
  CHECK_EQ(Sum(2 * n, x), 0);
  MPMSumZero(&sum);
  for (int k = 0; k < 2 * n; k++) {
    MPMSumAdd(&sum, x[k]);
    if (k % 1000 == 0) (void)MPMSumValue(&sum); /* partial totals of either sign, read on the way */
  }
  CHECK_EQ(MPMSumValue(&sum), 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Cancellation(void)
{
  const PetscReal a[] = {1e300, 1, -1e300}, b[] = {1e300, -1e-300, -1e300},
                  c[] = {DBL_MAX, DBL_MAX, -DBL_MAX, 3, -DBL_MAX};
  const PetscReal d[] = {DBL_TRUE_MIN, DBL_MAX, -DBL_TRUE_MIN, DBL_TRUE_MIN, -DBL_MAX}, e[] = {-1, 0x1p-60, 1, 0x1p-60};
  const PetscReal f[] = {1, 0x1p-53, 0x1p-80}, zeros[] = {0.0, -0.0, -0.0};

  UnitContext("cancellation");
  CHECK_EQ(Sum(3, a), 1);
  CHECK_EQ(Sum(3, b), -1e-300);
  CHECK_EQ(Sum(5, c), 3);
  CHECK_EQ(Sum(5, d), DBL_TRUE_MIN);
  CHECK_EQ(Sum(4, e), 0x1p-59);
  CHECK_NEAR(Sum(3, f), 1, DBL_EPSILON); /* below 1 ulp */
  CHECK_EQ(Sum(3, zeros), 0);
  CHECK_EQ(Sum(0, zeros), 0);
}

/* A single number comes back as it is. */
static void Identity(void)
{
  UnitContext("one addend");
  for (int k = 0; k < 20000; k++) {
    const uint64_t bits = UnitBits();
    PetscReal      x;

    memcpy(&x, &bits, sizeof x); /* any exponent, denormals too */
    if (k % 4 == 0) x = DBL_TRUE_MIN * (PetscReal)(bits >> 12);
    if (!isfinite(x)) continue;
    CHECK_EQ(Sum(1, &x), x);
  }
}

/* Denormals and small integers have exact sums in 64-bit integers; so have totals near zero of huge numbers. */
static void Integers(void)
{
  static PetscReal x[N];

  for (int round = 0; round < 20; round++) {
    const int  scale = round % 4 == 0 ? -1074 : round % 4 == 1 ? 1023 - 43 : UnitInt(1900) - 1000;
    PetscInt64 total = 0;

    UnitContext("integers times 2^%d", scale);
    for (int k = 0; k < N; k++) {
      const PetscInt64 i = (PetscInt64)(UnitBits() >> 24) - ((PetscInt64)1 << 39); /* sums stay below 2^53 */
      total += i;
      x[k] = ldexp((PetscReal)i, scale);
    }
    CHECK_EQ(Sum(N, x), ldexp((PetscReal)total, scale));
    for (int k = 0; k < N; k++) x[k] = -x[k];
    CHECK_EQ(Sum(N, x), ldexp((PetscReal)-total, scale));
  }
}

#if defined(__SIZEOF_FLOAT128__)
/* Against 113 bits: exponents within +-25 and 100 addends leave no rounding in them. */
static void Quad(void)
{
  PetscReal x[100];

  for (int round = 0; round < 2000; round++) {
    __float128 exact = 0;
    PetscReal  value;
    int        e;

    UnitContext("quad, round %d", round);
    for (int k = 0; k < 100; k++) {
      x[k] = Wide(25);
      if (k % 2 && round % 2) x[k] = -x[k - 1] * (1 + (UnitInt(9) - 4) * DBL_EPSILON); /* totals of few digits */
      exact += x[k];
    }
    value = Sum(100, x);
    frexp((PetscReal)exact, &e);
    CHECK_LE((PetscReal)(exact > value ? exact - value : value - exact),
             ldexp(1, e - 53) * (1 - 0x1p-30)); /* below 1 ulp */
  }
}
#endif

int main(int argc, char **argv)
{
  static PetscReal x[2 * N];

  PetscFunctionBeginUser;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  Cancellation();
  Identity();
  Integers();
#if defined(__SIZEOF_FLOAT128__)
  Quad();
#endif
  for (int round = 0; round < 6; round++) {
    UnitContext("order, round %d", round);
    for (int k = 0; k < N; k++)
      x[k] = round == 5 ? DBL_TRUE_MIN * (PetscReal)(UnitBits() >> 13) : Wide(round % 2 ? 1000 : 996);
    if (round == 2) x[0] = -1e301; /* a negative total */
    if (round == 3)
      for (int k = 0; k < N; k++) x[k] = -PetscAbsReal(x[k]);
    PetscCall(AnyOrder(N, x, Sum(N, x)));
  }
  PetscCall(PetscFinalize());
  return UnitEnd();
}
