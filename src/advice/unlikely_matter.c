/* unlikely_matter.c - the rows of plausible.def of materials. */
#include "advice/unlikely.h"

/* Returns the number of a material's option. */
static PetscBool OfMaterial(const MPMLook *look, PetscInt k, const char word[], MPMOdd *odd, PetscReal *number)
{
  return MPMUnlikelyNumber("material", look->scene->materials[k].name, word, odd, number);
}

/* Writes the name of another option of the material. */
static void NameOther(const MPMMaterial *m, const char word[], MPMOdd *odd)
{
  (void)snprintf(odd->other, MPM_WORDS, "-material_%s_%s", m->name, word);
}

PetscBool MPMUnlikely_millimetres(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];
  PetscReal          rho;

  if (!OfMaterial(look, k, "_rho", odd, &rho) || !MPMUnlikelyTonnes(m)) return PETSC_FALSE;
  odd->ratio = MPMUnlikelyExtent(look, k, -1);
  NameOther(m, MPMListHas(m->type->parameters, "E") ? "E" : MPMListHas(m->type->parameters, "K") ? "K" : "c0", odd);
  MPMUnlikelyWrite(odd->meant, 1e12 * rho);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_no_strength(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal cohesion = 0;

  (void)OfMaterial(look, k, "_cohesion", odd, &cohesion);
  NameOther(&look->scene->materials[k], "cohesion", odd);
  if (cohesion > 0 || !OfMaterial(look, k, "_friction_angle", odd, &odd->ratio)) return PETSC_FALSE;
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_rate_idle(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal reference;

  NameOther(&look->scene->materials[k], "rate_factor", odd);
  return OfMaterial(look, k, "_rate_factor", odd, &odd->ratio) &&
         OfMaterial(look, k, "_rate_reference", odd, &reference) && reference != 1;
}

/* A fluid with the density and the modulus of a gas at 1 atm, in SI units; water in t and kN has gravity. */
PetscBool MPMUnlikely_gas(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];
  PetscReal          rho;

  if (!(m->type->traits & MPM_FLUID) || look->g > 0 || !OfMaterial(look, k, "_rho", odd, &rho) ||
      !(rho > 0.05 && rho < 10) || !(m->K > 9e4 && m->K < 1.8e5))
    return PETSC_FALSE;
  odd->ratio = m->gamma;
  NameOther(m, "K", odd);
  (void)snprintf(odd->meant, MPM_WORDS, "-material_%.60s_tait_gamma 1.4", m->name);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_pulls_water(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene    *scene = look->scene;
  const MPMMaterial *m     = &scene->materials[k];
  PetscReal          cutoff;

  if (!(m->type->traits & MPM_FLUID) || !(MPMUnlikelyWeight(look, k) > 0) ||
      !OfMaterial(look, k, "_tension_cutoff", odd, &cutoff))
    return PETSC_FALSE;
  odd->ratio = cutoff / MPMUnlikelyWeight(look, k);
  for (PetscInt b = 0; b < scene->nbodies; b++)
    for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++)
      if (scene->bodies[b].material == k && face / 2 != look->down && !look->core->grid.periodic[face / 2] &&
          !(look->core->grid.round && !face) && MPMUnlikelyBeside(look, b, face) > 1)
        (void)snprintf(odd->other, MPM_WORDS, "%s", scene->bodies[b].name);
  return odd->other[0] != 0;
}
