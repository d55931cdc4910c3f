/* unlikely_matter.c - the rows of plausible.def of materials. */
#include "advice/unlikely.h"

/* --- Materials ---------------------------------------------------------------------------------------------------- */

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

static PetscBool HasOption(const MPMMaterial *m, const char word[])
{
  return MPMListHas(m->type->parameters, word) ? PETSC_TRUE : PETSC_FALSE;
}

/* Is it sand, soil or another solid that may come apart? */
static PetscBool IsSoil(const MPMMaterial *m)
{
  return m->type->traits & MPM_LOOSE && !(m->type->traits & MPM_FLUID) ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_millimetres(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];
  PetscReal          rho;

  if (!OfMaterial(look, k, "_rho", odd, &rho) || !MPMUnlikelyTonnes(m)) return PETSC_FALSE;
  odd->ratio = MPMUnlikelyExtent(look, k, -1);
  NameOther(m, HasOption(m, "E") ? "E" : HasOption(m, "K") ? "K" : "c0", odd);
  MPMUnlikelyWrite(odd->meant, 1e12 * rho);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_rho_kilonewtons(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  if (!look->earth || !OfMaterial(look, k, "_rho", odd, &odd->ratio) || odd->ratio < 10) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, 1000 * odd->ratio / look->g);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_rho_newtons(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  if (!look->earth || !IsSoil(&look->scene->materials[k]) || !OfMaterial(look, k, "_rho", odd, &odd->ratio) ||
      odd->ratio > 40000)
    return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, odd->ratio / look->g);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_rho_heavy(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  if (!look->earth || !OfMaterial(look, k, "_rho", odd, &odd->ratio)) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, odd->ratio / 1000);
  return PETSC_TRUE;
}

/* A strength beside the stress by weight. */
static PetscBool BesideWeight(const MPMLook *look, PetscInt k, const char word[], MPMOdd *odd)
{
  const PetscReal weight = MPMUnlikelyWeight(look, k);
  PetscReal       value, times = 1000;

  if (!OfMaterial(look, k, word, odd, &value) || !(value > 0) || !(weight > 0)) return PETSC_FALSE;
  odd->ratio = value / weight;
  while (times < 1e9 && times * odd->ratio < 1e-2) times *= 1000;
  (void)snprintf(odd->other, MPM_WORDS, "the stress by its weight, %.3g Pa", (double)weight);
  MPMUnlikelyWrite(odd->meant, times * value);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_cohesion_weight(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return BesideWeight(look, k, "_cohesion", odd);
}

PetscBool MPMUnlikely_yield_weight(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return BesideWeight(look, k, "_yield", odd);
}

/* A stress beside the modulus. */
static PetscBool BesideModulus(const MPMLook *look, PetscInt k, const char word[], MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];
  PetscReal          value;

  if (!OfMaterial(look, k, word, odd, &value)) return PETSC_FALSE;
  odd->ratio = value / (HasOption(m, "E") ? m->E : m->mu);
  NameOther(m, HasOption(m, "E") ? "E" : "G", odd);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_cohesion_modulus(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return BesideModulus(look, k, "_cohesion", odd) && odd->ratio < MPM_BOUND_yield_none ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_yield_modulus(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return BesideModulus(look, k, "_yield", odd) && odd->ratio < MPM_BOUND_yield_none ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_yield_small(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return BesideModulus(look, k, "_yield", odd) && odd->ratio > MPM_BOUND_yield_least ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_hardening_modulus(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return BesideModulus(look, k, "_hardening", odd);
}

PetscBool MPMUnlikely_hardening_small(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return BesideModulus(look, k, "_hardening", odd) && odd->ratio > 0 ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_nu_negative(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return OfMaterial(look, k, "_nu", odd, &odd->ratio);
}

PetscBool MPMUnlikely_nu_high(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];

  if (!(m->mu > 0)) return PETSC_FALSE; /* a fluid */
  MPMUnlikelyWrite(odd->other, PetscSqrtReal(2 + m->lambda / m->mu));
  return OfMaterial(look, k, "_nu", odd, &odd->ratio);
}

PetscBool MPMUnlikely_friction_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  if (!OfMaterial(look, k, "_friction_angle", odd, &odd->ratio)) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, PetscAtanReal(odd->ratio / 100) * 180 / PETSC_PI);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_friction_small(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return OfMaterial(look, k, "_friction_angle", odd, &odd->ratio) && odd->ratio > MPM_BOUND_angle ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_dilation_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal friction = 0;

  if (!OfMaterial(look, k, "_friction_angle", odd, &friction)) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, PetscMax(0, friction - 30));
  return OfMaterial(look, k, "_dilation_angle", odd, &odd->ratio);
}

PetscBool MPMUnlikely_no_strength(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal cohesion = 0;

  (void)OfMaterial(look, k, "_cohesion", odd, &cohesion);
  NameOther(&look->scene->materials[k], "cohesion", odd);
  if (cohesion > 0 || !OfMaterial(look, k, "_friction_angle", odd, &odd->ratio)) return PETSC_FALSE;
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_k0_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return OfMaterial(look, k, "_k0", odd, &odd->ratio);
}

/* The speed of waves in a solid, m/s; the option that gives its modulus. */
static PetscBool Waves(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];
  PetscReal          value;

  odd->ratio = PetscSqrtReal(MPMUnlikelyModulus(m, PETSC_FALSE) / m->rho);
  NameOther(m, "rho", odd);
  return OfMaterial(look, k, HasOption(m, "E") ? "_E" : "_c0", odd, &value);
}

PetscBool MPMUnlikely_soil_fast(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return look->earth && IsSoil(&look->scene->materials[k]) ? Waves(look, k, odd) : PETSC_FALSE;
}

PetscBool MPMUnlikely_soil_stiff(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];

  PetscReal          cohesion = 0;

  (void)OfMaterial(look, k, "_cohesion", odd, &cohesion);
  (void)snprintf(odd->other, MPM_WORDS, "-material_%s_cohesion %.3g", m->name, (double)cohesion);
  if (!look->earth || !IsSoil(m) || !OfMaterial(look, k, "_E", odd, &odd->ratio) || cohesion > 1e5) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, odd->ratio / 1000);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_solid_fast(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];

  if (m->type->traits & MPM_FLUID || !(look->earth || m->rho >= MPM_BOUND_si_density) || MPMUnlikelyTonnes(m)) return PETSC_FALSE;
  return Waves(look, k, odd);
}

PetscBool MPMUnlikely_fluid_soft(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscReal weight = MPMUnlikelyWeight(look, k);
  PetscReal       value;

  if (!(weight > 0) || !OfMaterial(look, k, "_K", odd, &value)) return PETSC_FALSE;
  odd->ratio = value / weight;
  (void)snprintf(odd->other, MPM_WORDS, "the stress by its weight, %.3g Pa", (double)weight);
  MPMUnlikelyWrite(odd->meant, 100 * weight);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_c0_slow(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];
  PetscReal          value;

  if (!OfMaterial(look, k, "_c0", odd, &value)) return PETSC_FALSE;
  odd->ratio = value / PetscSqrtReal(m->mu / m->rho);
  MPMUnlikelyWrite(odd->meant, 1000 * value);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_heat_small(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];
  PetscReal          value;

  if (!OfMaterial(look, k, "_specific_heat", odd, &value)) return PETSC_FALSE;
  odd->ratio = value * 293 / PetscSqr(m->c0);
  (void)snprintf(odd->other, MPM_WORDS, "c0^2/(293 K)");
  MPMUnlikelyWrite(odd->meant, 1000 * value);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_cutoff_small(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];

  return !(m->type->traits & MPM_FLUID) && BesideModulus(look, k, "_tension_cutoff", odd) && odd->ratio > 0 ? PETSC_TRUE
                                                                                                          : PETSC_FALSE;
}

PetscBool MPMUnlikely_rate_idle(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal reference;

  NameOther(&look->scene->materials[k], "rate_factor", odd);
  return OfMaterial(look, k, "_rate_factor", odd, &odd->ratio) && OfMaterial(look, k, "_rate_reference", odd, &reference) &&
                 reference != 1
             ? PETSC_TRUE
             : PETSC_FALSE;
}

PetscBool MPMUnlikely_water_thick(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscReal rho = look->scene->materials[k].rho;

  if (!look->earth || rho < 950 || rho > 1050 || !OfMaterial(look, k, "_viscosity", odd, &odd->ratio))
    return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, odd->ratio / 1000);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_liquid_thin(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscReal rho = look->scene->materials[k].rho;

  if (!look->earth || rho < MPM_BOUND_si_density || !OfMaterial(look, k, "_viscosity", odd, &odd->ratio)) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, odd->ratio * rho);
  return odd->ratio > 0 ? PETSC_TRUE : PETSC_FALSE;
}
