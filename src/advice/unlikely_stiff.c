/* unlikely_stiff.c - the rows of plausible.def of stiff solids without a yield stress that are strained as none can be; units are
   SI where one is as dense and as stiff as solids are in these. */
#include "advice/unlikely.h"

#define PLACES 9 /* on each axis of a body, at which its velocity is looked at */

static PetscBool IsStiff(const MPMMaterial *m)
{
  return !(m->type->traits & (MPM_FLUID | MPM_PLASTIC | MPM_LOOSE)) && m->rho > 100 && m->rho < 3e4 &&
         MPMUnlikelyModulus(m, PETSC_TRUE) > 1e9;
}

PetscBool MPMUnlikely_load_stiff(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscBool large = MPMUnlikely_load_large(look, k, odd);

  return IsStiff(&look->scene->materials[look->scene->bodies[look->scene->loads[k].body].material]) ? large
                                                                                                    : PETSC_FALSE;
}

/* How much the velocities of places of a body at the start differ from their mean, over the speed of its waves: so much it is
   strained when it stops. */
PetscBool MPMUnlikely_speed_stiff(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscInt     dim     = look->core->grid.dim;
  const MPMBody     *b       = &look->scene->bodies[k];
  const MPMMaterial *m       = &look->scene->materials[b->material];
  PetscReal          mean[3] = {0}, n = 0, x[3] = {0}, v[9] = {0};

  if (!IsStiff(m) || !(b->v2 > 0) || look->scene->known || !MPMUnlikelyGiven("body", b->name, "_velocity", odd))
    return PETSC_FALSE;
  for (PetscInt j = 0; MPMUnlikelyPlace(dim, look->lower[k], look->upper[k], PLACES, j, x); j++, n++) {
    if (MPMExpressionEvaluate(b->velocity, dim, x, x, 0, v)) return PETSC_FALSE;
    for (PetscInt d = 0; d < dim; d++) mean[d] += v[d];
  }
  for (PetscInt j = 0; MPMUnlikelyPlace(dim, look->lower[k], look->upper[k], PLACES, j, x); j++) {
    PetscReal far2 = 0;

    (void)MPMExpressionEvaluate(b->velocity, dim, x, x, 0, v);
    for (PetscInt d = 0; d < dim; d++) far2 += PetscSqr(v[d] - mean[d] / n);
    odd->ratio = PetscMax(odd->ratio, PetscSqrtReal(far2));
  }
  odd->ratio /= PetscSqrtReal(MPMUnlikelyModulus(m, PETSC_TRUE) / m->rho);
  return PETSC_TRUE;
}
