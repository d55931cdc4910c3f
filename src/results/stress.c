/* stress.c - numbers of a Cauchy stress, which is a tensor with all components in every dimension: in plane strain with
   the stress out of the plane, in bodies of revolution with that around the axis. */
#include "base/tensor.h"
#include "results/diagnostics.h"

PetscInt MPMShownStress(PetscInt dim, PetscInt k)
{
  static const PetscInt upper[MPM_STRESS_NC] = {0, 1, 2, 4, 5, 8}; /* xx xy xz yy yz zz, row by row */

  return upper[MPMSymPlace((int)dim, (int)k)];
}

PetscReal MPMShown_von_mises(const PetscReal s[])
{
  return PetscSqrtReal(0.5 * (PetscSqr(s[0] - s[4]) + PetscSqr(s[4] - s[8]) + PetscSqr(s[8] - s[0])) +
                       3 * (PetscSqr(s[1]) + PetscSqr(s[2]) + PetscSqr(s[5])));
}

PetscReal MPMShown_pressure(const PetscReal s[])
{
  return 0 - (s[0] + s[4] + s[8]) / 3; /* no -0 */
}

/* Sets value [3] to the principal stresses; tension is positive. */
static void Principal(const PetscReal s[], PetscReal value[3])
{
  const PetscReal a[6] = {s[0], s[1], s[2], s[4], s[5], s[8]};
  PetscReal       axis[3][3];

  MPMEigen(3, a, value, axis);
}

PetscReal MPMShown_stress_min(const PetscReal s[])
{
  PetscReal value[3];

  Principal(s, value);
  return PetscMin(PetscMin(value[0], value[1]), value[2]);
}

PetscReal MPMShown_stress_max(const PetscReal s[])
{
  PetscReal value[3];

  Principal(s, value);
  return PetscMax(PetscMax(value[0], value[1]), value[2]);
}
