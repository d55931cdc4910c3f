/* unlikely_matter.c - the rows of plausible.def of materials, bodies and loads. */
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

/* Returns the stress by the weight of the highest body of a material, Pa. */
static PetscReal Weight(const MPMLook *look, PetscInt k)
{
  PetscReal weight = 0;

  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    weight += look->scene->materials[k].rho * PetscAbsReal(look->core->params.gravity[d]) * MPMUnlikelyExtent(look, k, d);
  return weight;
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
  const PetscReal weight = Weight(look, k);
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

PetscBool MPMUnlikely_hardening_modulus(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return BesideModulus(look, k, "_hardening", odd);
}

PetscBool MPMUnlikely_friction_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  if (!OfMaterial(look, k, "_friction_angle", odd, &odd->ratio)) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, PetscAtanReal(odd->ratio / 100) * 180 / PETSC_PI);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_dilation_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal friction = 0;

  if (!OfMaterial(look, k, "_friction_angle", odd, &friction)) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, PetscMax(0, friction - 30));
  return OfMaterial(look, k, "_dilation_angle", odd, &odd->ratio);
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
  return OfMaterial(look, k, HasOption(m, "E") ? "_E" : "_G", odd, &value);
}

PetscBool MPMUnlikely_soil_fast(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return look->earth && IsSoil(&look->scene->materials[k]) ? Waves(look, k, odd) : PETSC_FALSE;
}

PetscBool MPMUnlikely_solid_fast(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m = &look->scene->materials[k];

  if (m->type->traits & MPM_FLUID || !(look->earth || m->rho >= MPM_BOUND_si_density)) return PETSC_FALSE;
  return Waves(look, k, odd);
}

PetscBool MPMUnlikely_fluid_soft(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscReal weight = Weight(look, k);
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

PetscBool MPMUnlikely_water_thick(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscReal rho = look->scene->materials[k].rho;

  if (!look->earth || rho < 950 || rho > 1050 || !OfMaterial(look, k, "_viscosity", odd, &odd->ratio) ||
      odd->ratio > 2)
    return PETSC_FALSE;
  MPMUnlikelyWrite(odd->meant, odd->ratio / 1000);
  return PETSC_TRUE;
}

/* --- Bodies ------------------------------------------------------------------------------------------------------- */

PetscBool MPMUnlikely_ppc_one(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = &look->scene->bodies[k];

  if (look->core->grid.dim == 1 || look->core->grid.total || look->scene->known || b->points) return PETSC_FALSE;
  odd->ratio = PETSC_MAX_REAL;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) odd->ratio = PetscMin(odd->ratio, (PetscReal)b->ppc[d]);
  return MPMUnlikelyGiven("body", b->name, "_ppc", odd);
}

PetscBool MPMUnlikely_offset_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = &look->scene->bodies[k];

  if (b->points) return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) odd->ratio = PetscMax(odd->ratio, PetscAbsReal(b->offset[d]) / b->b[d]);
  MPMUnlikelyWrite(odd->other, b->b[0]);
  return MPMUnlikelyGiven("body", b->name, "_offset", odd);
}

/* Returns whether a wall holds the body at one of its ends along an axis, or the axis is periodic. */
static PetscBool IsAtFace(const MPMLook *look, PetscInt k, PetscInt d)
{
  const MPMGrid *grid = &look->core->grid;

  return grid->periodic[d] || look->lower[k][d] < grid->lower[d] + 0.1 * grid->h[d] ||
                 look->upper[k][d] > grid->upper[d] - 0.1 * grid->h[d]
             ? PETSC_TRUE
             : PETSC_FALSE;
}

PetscBool MPMUnlikely_thin(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;
  const MPMBody *b    = &look->scene->bodies[k];
  PetscInt       thin = -1;

  if (grid->dim == 1 || b->points || look->scene->known) return PETSC_FALSE;
  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal cells = (look->upper[k][d] - look->lower[k][d]) / grid->h[d];

    if (IsAtFace(look, k, d) || (thin >= 0 && cells >= odd->ratio)) continue;
    thin       = d;
    odd->ratio = cells;
  }
  if (thin < 0) return PETSC_FALSE;
  (void)snprintf(odd->option, MPM_WORDS, "-body_%s_shape", b->name);
  (void)snprintf(odd->other, MPM_WORDS, "%c", "xyz"[thin]);
  MPMUnlikelyWrite(odd->meant, (look->upper[k][thin] - look->lower[k][thin]) / 3);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_wave_none(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody     *b = &look->scene->bodies[k];
  const MPMMaterial *m = &look->scene->materials[b->material];
  PetscReal          size = 0;

  if (k || look->core->implicit || !(look->time->end > 0)) return PETSC_FALSE;
  if (MPMUnlikelyModulus(m, PETSC_TRUE) < MPM_BOUND_soft) return PETSC_FALSE; /* which is told */
  for (PetscInt d = 0; d < look->core->grid.dim; d++) size = PetscMax(size, look->upper[k][d] - look->lower[k][d]);
  odd->ratio = look->time->end * PetscSqrtReal(MPMUnlikelyModulus(m, PETSC_FALSE) / m->rho) / size;
  (void)snprintf(odd->other, MPM_WORDS, "%s", b->name);
  return MPMUnlikelyGiven("time_end", NULL, "", odd);
}

PetscBool MPMUnlikely_gap_bodies(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;

  if (look->core->contacts || grid->total) return PETSC_FALSE;
  for (PetscInt other = 0; other < look->scene->nbodies; other++) {
    const MPMBody *b   = &look->scene->bodies[other];
    PetscReal      gap = 0;

    if (other == k) continue;
    for (PetscInt d = 0; d < grid->dim; d++)
      gap = PetscMax(gap, PetscMax(look->lower[other][d] - look->upper[k][d], look->lower[k][d] - look->upper[other][d]) /
                              grid->h[d]);
    if (!(gap > 0.05 && gap < 1 - 1e-6) || other < k) continue;
    odd->ratio = gap;
    (void)snprintf(odd->option, MPM_WORDS, "-body_%s_shape", look->scene->bodies[k].name);
    (void)snprintf(odd->other, MPM_WORDS, "%s", b->name);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_gap_wall(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;
  const MPMBody *b    = &look->scene->bodies[k];

  if (!MPMMaterialKeepsShape(&look->scene->materials[b->material]) || b->v2 > 0 || look->scene->known) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * grid->dim; face++) {
    const PetscInt  d    = face / 2;
    const MPMFace  *f    = &look->scene->walls.given[d][face % 2];
    const PetscReal gap  = (face % 2 ? grid->upper[d] - look->upper[k][d] : look->lower[k][d] - grid->lower[d]) / grid->h[d];

    if (!MPMWallHas(f->type, MPM_WALL_NORMAL) || MPMWallHas(f->type, MPM_WALL_PUSHES | MPM_WALL_MOVES)) continue;
    if (look->core->params.gravity[d] != 0 || !(gap > 0.05)) continue;
    if (IsAtFace(look, k, d)) continue;
    odd->ratio = gap;
    (void)snprintf(odd->other, MPM_WORDS, "-body_%s_shape", b->name);
    if (odd->ratio < 2 && MPMUnlikelyGiven("bc", MPMFaceNames[face], "_type", odd)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_k0_side(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;

  if (!(MPMInitialGravity(look->scene) > 0)) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * grid->dim; face++) {
    const PetscInt  d   = face / 2;
    const PetscReal gap = (face % 2 ? grid->upper[d] - look->upper[k][d] : look->lower[k][d] - grid->lower[d]) / grid->h[d];

    if (d == look->down || grid->periodic[d] || gap > 0.3 || look->scene->walls.given[d][face % 2].type != MPM_WALL_free)
      continue;
    odd->ratio = 1;
    (void)snprintf(odd->option, MPM_WORDS, "-bc_%s_type", MPMFaceNames[face]);
    (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[k].name);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* --- Loads -------------------------------------------------------------------------------------------------------- */

/* Sets how large a load is, Pa, per area of the body if it is a force; and its body's modulus. */
static PetscBool Load(const MPMLook *look, PetscInt k, MPMOdd *odd, PetscReal *size, PetscReal *modulus)
{
  const MPMLoad     *load = &look->scene->loads[k];
  const PetscInt     b = load->body, dim = look->core->grid.dim;
  const MPMMaterial *m = &look->scene->materials[look->scene->bodies[b].material];
  PetscReal          x[3] = {0}, extent = 0;

  for (PetscInt d = 0; d < dim; d++) {
    x[d]   = 0.5 * (look->lower[b][d] + look->upper[b][d]);
    extent = PetscMax(extent, look->upper[b][d] - look->lower[b][d]);
  }
  *size = MPMUnlikelySize(look, load->value, load->nc, x);
  if (MPMLoadIsOnVolume(load))
    *size /= PetscPowReal(extent, (PetscReal)(look->core->grid.round ? 3 : dim) - (load->type == MPM_LOAD_FORCE ? 1 : 0));
  *modulus = MPMUnlikelyModulus(m, PETSC_TRUE);
  (void)snprintf(odd->other, MPM_WORDS, "the modulus of %s, %.3g Pa", m->name, (double)*modulus);
  return MPMUnlikelyGiven("load", load->name, "_value", odd) && *size > 0 ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_load_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal size, modulus;

  if (!Load(look, k, odd, &size, &modulus)) return PETSC_FALSE;
  odd->ratio = size / modulus;
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_load_weight(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal       size, modulus, value;
  const PetscReal weight = Weight(look, look->scene->bodies[look->scene->loads[k].body].material);

  if (MPMLoadIsOnVolume(&look->scene->loads[k]) || !Load(look, k, odd, &size, &modulus) || !(weight > 0))
    return PETSC_FALSE;
  odd->ratio = size / weight;
  value      = strtod(odd->value, NULL);
  (void)snprintf(odd->other, MPM_WORDS, "the stress by the weight, %.3g Pa", (double)weight);
  MPMUnlikelyWrite(odd->meant, 1000 * (value != 0 ? value : size));
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_load_small(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal size, modulus;

  if (!Load(look, k, odd, &size, &modulus) || !MPMUnlikelyGiven("load", look->scene->loads[k].name, "_value", odd))
    return PETSC_FALSE;
  odd->ratio = size / modulus;
  return PETSC_TRUE;
}
