/* unit_study.c - what a study says of a series of numbers: orders only where three runs agree, a limit with its
   uncertainty, and that differences which do not fall do not converge. */
#include "run/study.h"
#include "unit.h"

#define MAX 8

/* Sets d [n - 1], the differences of q [n]. */
static void Differences(int n, const PetscReal q[], PetscReal d[])
{
  for (int k = 1; k < n; k++) d[k - 1] = q[k] - q[k - 1];
}

/* q = limit + c 2^(-p k): the order is found, and the limit, at once. */
static void Power(PetscReal limit, PetscReal c, PetscReal p)
{
  PetscReal q[MAX], d[MAX], pair[MAX], rest, uncertainty;

  UnitContext("limit %g, amplitude %g, order %g", (double)limit, (double)c, (double)p);
  for (int k = 0; k < MAX; k++) q[k] = limit + c * PetscPowReal(2, -p * k);
  Differences(MAX, q, d);
  MPMSeriesOrders(MAX - 1, d, pair);
  CHECK(pair[0] == MPM_NO_ORDER);
  for (int k = 1; k < MAX - 1; k++) CHECK_NEAR(pair[k], p, 1e-6);
  for (int n = 1; n < MAX; n++) {
    CHECK_EQ(MPMSeriesAgree(n, pair), n > 2);
    CHECK_EQ(MPMSeriesRest(n, d, &rest, &uncertainty), n > 1);
    if (n < 2) continue;
    CHECK_NEAR(q[n] + rest, limit, 1e-6 * fabs(c));
    CHECK_NEAR(uncertainty, n > 2 ? 0 : fabs(rest), 1e-6 * fabs(c));
  }
}

int main(void)
{
  /* errors of sand against its finest run, where dt was halved: the differences of the runs do not fall */
  static const PetscReal sand[] = {0.165, 0.135, 0.103, 0.070, 0.037, 0};
  PetscReal              d[MAX], pair[MAX], rest, uncertainty;

  Differences(6, sand, d);
  MPMSeriesOrders(5, d, pair);
  for (int n = 2; n <= 5; n++) {
    UnitContext("sand, %d differences", n);
    CHECK(!MPMSeriesFalls(n, d));
    CHECK(!MPMSeriesRest(n, d, &rest, &uncertainty));
    CHECK_LE(pair[n - 1], 0.1); /* nothing like 0.9 */
    CHECK(!MPMSeriesAgree(n, pair));
  }
  Power(0, 1, 2);
  Power(1.217, -0.3, 1);
  Power(-5, 1e-3, 3.5);
  {
    static const PetscReal alternating[] = {1, -0.5, 0.25}, noisy[] = {1, 0.5, 0.05}, still[] = {1, 0},
                           two[] = {4, 2, 1.5};

    UnitContext("signs that alternate: 1/3 short of the limit of 1 - 0.5 + 0.25 - ...");
    CHECK(MPMSeriesRest(3, alternating, &rest, &uncertainty));
    CHECK_NEAR(rest, 2. / 3 - 0.75, 1e-12);
    CHECK_NEAR(uncertainty, 0, 1e-12);
    UnitContext("pairs of order 1 and 3.3");
    MPMSeriesOrders(3, noisy, pair);
    CHECK(!MPMSeriesAgree(3, pair));
    CHECK(MPMSeriesRest(3, noisy, &rest, &uncertainty));
    CHECK_NEAR(rest, 0.05 / 9, 1e-12);
    CHECK_NEAR(uncertainty, 0.05 - 0.05 / 9, 1e-12);
    UnitContext("a difference of 0 has no order, and leaves nothing");
    MPMSeriesOrders(2, still, pair);
    CHECK(pair[1] == MPM_NO_ORDER);
    CHECK(MPMSeriesRest(2, still, &rest, &uncertainty));
    CHECK_EQ(rest, 0);
    UnitContext("orders 1 and 0.4");
    MPMSeriesOrders(3, two, pair);
    CHECK(!MPMSeriesAgree(3, pair));
  }
  return UnitEnd();
}
