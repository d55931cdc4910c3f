/* unlikely_bodies.c - the rows of plausible.def of bodies and loads. */
#include "advice/unlikely.h"

/* --- Bodies ------------------------------------------------------------------------------------------------------- */

PetscBool MPMUnlikely_ppc_one(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = &look->scene->bodies[k];

  if (look->core->grid.dim == 1 || look->core->grid.total || look->scene->known || b->points) return PETSC_FALSE;
  odd->ratio = PETSC_MAX_REAL;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) {
    odd->ratio = PetscMin(odd->ratio, (PetscReal)b->ppc[d]);
    MPMUnlikelyAppend(odd->meant, 3, PetscMax(2, (PetscReal)b->ppc[d]));
  }
  return MPMUnlikelyGiven("body", b->name, "_ppc", odd);
}

PetscBool MPMUnlikely_offset_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = &look->scene->bodies[k];

  if (b->points) return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    odd->ratio = PetscMax(odd->ratio, PetscAbsReal(b->offset[d]) / b->b[d]);
  MPMUnlikelyWrite(odd->other, b->b[0]);
  return MPMUnlikelyGiven("body", b->name, "_offset", odd);
}

/* Returns whether a wall holds the body at one of its ends along an axis, or the axis is periodic. */
static PetscBool IsAtFace(const MPMLook *look, PetscInt k, PetscInt d)
{
  return look->core->grid.periodic[d] || MPMUnlikelyBeside(look, k, 2 * d) < 0.1 ||
                 MPMUnlikelyBeside(look, k, 2 * d + 1) < 0.1
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
  const MPMBody     *b    = &look->scene->bodies[k];
  const MPMMaterial *m    = &look->scene->materials[b->material];
  PetscReal          size = 0;

  if (k || look->core->implicit || !(look->time->end > 0)) return PETSC_FALSE;
  if (MPMUnlikelyModulus(m, PETSC_TRUE) < MPM_BOUND_soft) return PETSC_FALSE; /* which is told */
  for (PetscInt d = 0; d < look->core->grid.dim; d++) size = PetscMax(size, look->upper[k][d] - look->lower[k][d]);
  odd->ratio = look->time->end * PetscSqrtReal(MPMUnlikelyModulus(m, PETSC_FALSE) / m->rho) / size;
  (void)snprintf(odd->other, MPM_WORDS, "%s", b->name);
  return MPMUnlikelyGiven("time_end", NULL, "", odd);
}

/* Returns how many cells two bodies are apart, by their boxes; 0: these overlap. */
static PetscReal Gap(const MPMLook *look, PetscInt k, PetscInt other)
{
  PetscReal gap = 0;

  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    gap = PetscMax(gap, PetscMax(look->lower[other][d] - look->upper[k][d], look->lower[k][d] - look->upper[other][d]) /
                            look->core->grid.h[d]);
  return gap;
}

PetscBool MPMUnlikely_contact_coarse(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid     *grid = &look->core->grid;
  const MPMContacts *c    = look->core->contacts;
  const MPMBody     *b    = &look->scene->bodies[k];
  PetscReal          size = 0, least = PETSC_MAX_REAL;
  PetscBool          meets = PETSC_FALSE, moves = PETSC_FALSE;

  if (!c || grid->dim == 1 || !MPMMaterialKeepsShape(&look->scene->materials[b->material])) return PETSC_FALSE;
  for (PetscInt q = 0; q < c->npairs; q++)
    if (!c->pair[q].rigid && !c->pair[q].glued && (c->pair[q].a == b->copy || c->pair[q].b == b->copy))
      meets = PETSC_TRUE;
  for (PetscInt other = 0; other < look->scene->nbodies; other++) {
    if (look->scene->bodies[other].v2 > 0) moves = PETSC_TRUE;
    if (other != k) least = PetscMin(least, Gap(look, k, other));
  }
  if (!meets || !(moves || (look->g > 0 && least > 1))) return PETSC_FALSE; /* what touches and rests loses nothing */
  for (PetscInt d = 0; d < grid->dim; d++) {
    size       = PetscMax(size, look->upper[k][d] - look->lower[k][d]);
    odd->ratio = PetscMax(odd->ratio, (look->upper[k][d] - look->lower[k][d]) / grid->h[d]);
  }
  (void)snprintf(odd->option, MPM_WORDS, "-body_%s_shape", b->name);
  MPMUnlikelyWrite(odd->meant, size / 16);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_gap_bodies(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  if (look->core->contacts || look->core->grid.total) return PETSC_FALSE;
  for (PetscInt other = 0; other < look->scene->nbodies; other++) {
    const MPMBody  *b   = &look->scene->bodies[other];
    const PetscReal gap = other == k ? 0 : Gap(look, k, other);

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
  PetscReal      lower[3], upper[3];

  if (!MPMMaterialKeepsShape(&look->scene->materials[b->material]) || b->v2 > 0 || look->scene->known)
    return PETSC_FALSE;
  MPMRegionBounds(&b->region, grid->dim, lower, upper);
  for (PetscInt face = 0; face < 2 * grid->dim; face++) {
    const PetscInt  d   = face / 2;
    const MPMFace  *f   = &look->scene->walls.given[d][face % 2];
    const PetscReal gap = MPMUnlikelyBeside(look, k, face);

    if (!MPMWallHas(f->type, MPM_WALL_NORMAL) || MPMWallHas(f->type, MPM_WALL_PUSHES | MPM_WALL_MOVES)) continue;
    if (!b->points && (face % 2 ? upper[d] >= grid->upper[d] : lower[d] <= grid->lower[d]))
      continue; /* it has a tip there */
    if (look->core->params.gravity[d] != 0 || !(gap > 0.05)) continue;
    if (IsAtFace(look, k, d)) continue;
    odd->ratio = gap;
    (void)snprintf(odd->other, MPM_WORDS, "-body_%s_shape", b->name);
    if (odd->ratio < 2 && MPMUnlikelyGiven("bc", MPMFaceNames[face], "_type", odd)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_gap_floor(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscInt face = 2 * look->down + (look->core->params.gravity[look->down] > 0);
  const MPMWall  type = MPMUnlikelyWall(look, face);

  if (!(look->g > 0) || !MPMWallHas(type, MPM_WALL_NORMAL) || MPMWallHas(type, MPM_WALL_PUSHES | MPM_WALL_MOVES) ||
      look->core->grid.total)
    return PETSC_FALSE;
  odd->ratio = MPMUnlikelyBeside(look, k, face);
  (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[k].name);
  return odd->ratio > 0.3 ? MPMUnlikelyGiven("bc", MPMFaceNames[face], "_type", odd) : PETSC_FALSE;
}

PetscBool MPMUnlikely_k0_floor(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscInt d = look->down, up = look->core->params.gravity[d] > 0, face = 2 * d + up;

  if (k || !(MPMInitialGravity(look->scene) > 0) || look->core->rigids.n || look->core->stages.now > 1)
    return PETSC_FALSE;
  odd->ratio = MPMUnlikelyBeside(look, -1, face) - look->scene->walls.place[face] / look->core->grid.h[d];
  (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[k].name);
  (void)snprintf(odd->meant, MPM_WORDS, up ? "top" : "underside");
  return MPMUnlikelyGiven("initial_stress", NULL, "", odd);
}

/* Finds an open side of the grid at which body k starts. */
static PetscBool OpenSide(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;

  for (PetscInt face = 0; face < 2 * grid->dim; face++) {
    if (face / 2 == look->down || grid->periodic[face / 2] || MPMUnlikelyBeside(look, k, face) > 0.3 ||
        MPMUnlikelyWall(look, face) != MPM_WALL_free)
      continue;
    odd->ratio = 1;
    (void)snprintf(odd->option, MPM_WORDS, "-bc_%s_type", MPMFaceNames[face]);
    (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[k].name);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_k0_side(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return MPMInitialGravity(look->scene) > 0 && look->core->stages.now <= 1 ? OpenSide(look, k, odd) : PETSC_FALSE;
}

PetscBool MPMUnlikely_flows_out(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = &look->scene->bodies[k];

  if (!(look->g > 0) || look->core->grid.total || look->core->rigids.n ||
      !(look->scene->materials[b->material].type->traits & MPM_LOOSE) ||
      MPMUnlikelyGiven("particles_leave", NULL, "", odd))
    return PETSC_FALSE;
  return OpenSide(look, k, odd);
}

/* --- Loads -------------------------------------------------------------------------------------------------------- */

/* Sets how large a load is, Pa, per area of the body if it is a force; and the ratio of that to its body's modulus. */
static PetscBool Load(const MPMLook *look, PetscInt k, MPMOdd *odd, PetscReal *size)
{
  const MPMLoad     *load = &look->scene->loads[k];
  const MPMFormula   f    = MPMUnlikelyFormula(look, k);
  const PetscInt     b = load->body, dim = look->core->grid.dim;
  const MPMMaterial *m       = &look->scene->materials[look->scene->bodies[b].material];
  const PetscReal    modulus = MPMUnlikelyModulus(m, PETSC_TRUE);
  PetscReal          extent  = 0;

  for (PetscInt d = 0; d < dim; d++) extent = PetscMax(extent, look->upper[b][d] - look->lower[b][d]);
  *size = MPMUnlikelySize(look, &f);
  if (MPMLoadIsOnVolume(load))
    *size /= PetscPowReal(extent,
                          (PetscReal)(look->core->grid.round ? 3 : dim) - (load->type == MPM_LOAD_FORCE ? 1 : 0));
  odd->ratio = *size / modulus;
  (void)snprintf(odd->other, MPM_WORDS, "the modulus of %s, %.3g Pa", m->name, (double)modulus);
  return MPMUnlikelyGiven("load", load->name, "_value", odd) && *size > 0 ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_load_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal size;

  return Load(look, k, odd, &size);
}

/* The strength of soil is that of a footing on it that fails, 50 (c + rho g H): more than of any angle below 40 degrees. */
PetscBool MPMUnlikely_load_strong(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad     *load = &look->scene->loads[k];
  const MPMMaterial *m    = &look->scene->materials[look->scene->bodies[load->body].material];
  const PetscBool    soil = m->type->traits & MPM_LOOSE ? PETSC_TRUE : PETSC_FALSE;
  PetscReal          size;

  if (MPMLoadIsOnVolume(load) || !(m->type->traits & MPM_PLASTIC) || !Load(look, k, odd, &size)) return PETSC_FALSE;
  odd->ratio = size /
               (soil ? 50 * (MPMUnlikelyCohesion(m) + MPMUnlikelyWeight(look, look->scene->bodies[load->body].material))
                     : 20 * m->yield);
  (void)snprintf(odd->other, MPM_WORDS, "%s", m->name);
  return odd->ratio < PETSC_MAX_REAL && (!soil || look->g > 0) ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_load_weight(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal       size, value;
  const PetscReal weight = MPMUnlikelyWeight(look, look->scene->bodies[look->scene->loads[k].body].material);

  if (MPMLoadIsOnVolume(&look->scene->loads[k]) || !Load(look, k, odd, &size) || !(weight > 0)) return PETSC_FALSE;
  odd->ratio = size / weight;
  value      = strtod(odd->value, NULL);
  (void)snprintf(odd->other, MPM_WORDS, "the stress by the weight, %.3g Pa", (double)weight);
  MPMUnlikelyWrite(odd->meant, 1000 * (value != 0 ? value : size));
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_load_pulls(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad *load = &look->scene->loads[k];
  const PetscInt b = load->body, dim = look->core->grid.dim, up = look->core->params.gravity[look->down] < 0 ? 1 : -1;
  const MPMMaterial *m    = &look->scene->materials[look->scene->bodies[b].material];
  PetscReal          x[3] = {0};

  if ((!(look->g > 0) && load->type != MPM_LOAD_PRESSURE) || m->type->traits & MPM_FLUID ||
      !(m->type->traits & MPM_PLASTIC) || load->type == MPM_LOAD_TORQUE ||
      (!(m->type->traits & MPM_LOOSE) && m->rho > MPM_BOUND_dense))
    return PETSC_FALSE;
  for (PetscInt j = 0; j <= 120;
       j++) { /* at 11 times and places; where it presses at any of them, it is one that swings */
    const PetscReal t = look->time->end * (PetscReal)(j / 11) / 10, part = (PetscReal)(j % 11) / 10;
    PetscReal       value[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0}, pull = 0;

    for (PetscInt d = 0; d < dim; d++) x[d] = look->lower[b][d] + part * (look->upper[b][d] - look->lower[b][d]);
    if (MPMExpressionEvaluate(load->value, dim, x, x, t, value)) return PETSC_FALSE;
    if (load->type == MPM_LOAD_PRESSURE)
      pull = -value[0];
    else if (load->type == MPM_LOAD_FORCE || load->sides == (PetscInt)1 << (2 * look->down + (up > 0)))
      pull = (PetscReal)up * value[look->down];
    if (pull < 0) return PETSC_FALSE;
    odd->ratio = PetscMax(odd->ratio, pull);
  }
  (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[b].name);
  return MPMUnlikelyGiven("load", load->name, "_value", odd);
}

PetscBool MPMUnlikely_load_small(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return MPMUnlikely_load_large(look, k, odd);
}

PetscBool MPMUnlikely_load_point(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad *load = &look->scene->loads[k];
  const MPMGrid *grid = &look->core->grid;

  if (!load->fixed) return PETSC_FALSE;
  odd->ratio = 0;
  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal off = PetscMax(load->point[d] - grid->upper[d], grid->lower[d] - load->point[d]);

    odd->ratio = PetscMax(odd->ratio, off / (grid->upper[d] - grid->lower[d]));
  }
  return MPMUnlikelyGiven("load", load->name, "_point", odd);
}

PetscBool MPMUnlikely_load_held(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad *load = &look->scene->loads[k];

  odd->ratio = 1;
  (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[load->body].name);
  for (PetscInt face = 0; face < 2 * look->core->grid.dim && !MPMLoadIsOnVolume(load); face++)
    if (load->sides == (PetscInt)1 << face && MPMWallHas(MPMUnlikelyWall(look, face), MPM_WALL_TANGENT) &&
        MPMUnlikelyBeside(look, load->body, face) < 0.3)
      return MPMUnlikelyGiven("load", load->name, "_face", odd);
  return PETSC_FALSE;
}
