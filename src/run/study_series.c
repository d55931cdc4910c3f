/* study_series.c - what a series of numbers says, each of a run twice as fine as the one before: an order of
   convergence, where the series goes, and how far it still is from there. Nothing here is collective. */
#include "run/study.h"

/* A series converges if its differences fall at least by this factor from run to run. */
#define FALLS 1.1

void MPMSeriesOrders(PetscInt n, const PetscReal y[], PetscReal pair[])
{
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal now = PetscAbsReal(y[k]), before = k ? PetscAbsReal(y[k - 1]) : 0;

    pair[k] = now > 0 && before > 0 && now + before <= PETSC_MAX_REAL ? PetscLog2Real(before / now) : MPM_NO_ORDER;
  }
}

PetscBool MPMSeriesAgree(PetscInt n, const PetscReal pair[])
{
  const PetscReal least = PetscLog2Real(FALLS);

  if (n < 3 || pair[n - 1] < least || pair[n - 2] < least) return PETSC_FALSE;
  return PetscAbsReal(pair[n - 1] - pair[n - 2]) <= MPM_ORDER_BAND ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMSeriesFalls(PetscInt n, const PetscReal y[])
{
  return n > 1 && FALLS * PetscAbsReal(y[n - 1]) <= PetscAbsReal(y[n - 2]) ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the sum of the differences that would follow d[n - 1], if they go on to fall as from d[n - 2] to d[n - 1]. */
static PetscReal Rest(PetscInt n, const PetscReal d[], PetscReal from)
{
  return d[n - 1] == 0 ? 0 : from / (d[n - 2] / d[n - 1] - 1);
}

PetscBool MPMSeriesRest(PetscInt n, const PetscReal d[], PetscReal *rest, PetscReal *uncertainty)
{
  *rest = *uncertainty = 0;
  if (!MPMSeriesFalls(n, d)) return PETSC_FALSE;
  *rest        = Rest(n, d, d[n - 1]);
  *uncertainty = PetscAbsReal(*rest);
  if (n > 2 && MPMSeriesFalls(n - 1, d)) *uncertainty = PetscAbsReal(*rest - Rest(n - 1, d, d[n - 1]));
  return PETSC_TRUE;
}
