/* unlikely_loads.c - the rows of plausible.def of loads: their size, their sign, and what bears them. */
#include <strings.h>
#include "advice/unlikely.h"

/* Is a load a ramp that is longer than the run? That is told, and its size is not. */
static PetscBool IsRamp(const MPMLook *look, PetscInt k)
{
  MPMOdd odd = {0};

  return MPMUnlikely_formula_slow(look, k, &odd) && odd.ratio < 0.1;
}

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
  return MPMUnlikelyGiven("load", load->name, "_value", odd) && *size > 0;
}

PetscBool MPMUnlikely_load_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal size;

  return Load(look, k, odd, &size);
}

/* A load that stays with the first row of particles is to a fluid like a layer that is heavier than what is below: the
   disturbance of a few cells grows by e in about the time h sqrt(rho/p). */
PetscBool MPMUnlikely_load_sinks(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad     *load = &look->scene->loads[k];
  const MPMMaterial *m    = &look->scene->materials[look->scene->bodies[load->body].material];
  PetscReal          size;

  if (MPMLoadIsOnVolume(load) || !(m->type->traits & MPM_FLUID) || !Load(look, k, odd, &size)) return PETSC_FALSE;
  odd->ratio = (look->time->end - look->core->stages.began) * PetscSqrtReal(size / m->rho) /
               MPMGridSmallestH(&look->core->grid);
  (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[load->body].name); /* Load() told the modulus */
  return PETSC_TRUE;
}

/* The strength of soil is that of a footing on it that fails, 50 (c + rho g H): more than of any angle below 40 degrees. */
PetscBool MPMUnlikely_load_strong(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad     *load = &look->scene->loads[k];
  const MPMMaterial *m    = &look->scene->materials[look->scene->bodies[load->body].material];
  const PetscBool    soil = (m->type->traits & MPM_LOOSE) != 0;
  PetscReal          size;

  if (MPMLoadIsOnVolume(load) || !(m->type->traits & MPM_PLASTIC) || !Load(look, k, odd, &size)) return PETSC_FALSE;
  odd->ratio = size /
               (soil ? 50 * (MPMUnlikelyCohesion(m) + MPMUnlikelyWeight(look, look->scene->bodies[load->body].material))
                     : 20 * m->yield);
  (void)snprintf(odd->other, MPM_WORDS, "%s", m->name);
  return odd->ratio < PETSC_MAX_REAL &&
         (!soil || MPMUnlikelyWeight(look, look->scene->bodies[load->body].material) > 0);
}

PetscBool MPMUnlikely_load_weight(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal       size;
  const PetscReal weight = MPMUnlikelyWeight(look, look->scene->bodies[look->scene->loads[k].body].material);

  if (MPMLoadIsOnVolume(&look->scene->loads[k]) || !Load(look, k, odd, &size) || !(weight > 0) || IsRamp(look, k))
    return PETSC_FALSE;
  odd->ratio = size / weight;
  (void)snprintf(odd->other, MPM_WORDS, "the stress by the weight, %.3g Pa", (double)weight);
  MPMUnlikelyThousand(odd);
  return PETSC_TRUE;
}

/* Does a pressure act within a body alone: on the inner side of a ring, or at places of which none is at the outer sides of the
   box around the body? What lies on a wall is no outer side. */
static PetscBool InBore(const MPMLook *look, const MPMLoad *load)
{
  const PetscInt b = load->body, dim = look->core->grid.dim;
  PetscBool      inside = load->sides & (load->sides - 1) || look->core->grid.round;

  if (load->type != MPM_LOAD_PRESSURE) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * dim; face++) {
    PetscReal lower[3], upper[3], x[3], value[9];

    if (!(load->sides & (PetscInt)1 << face) || (look->core->grid.round && !face && look->lower[b][0] > 0) ||
        (MPMUnlikelyWall(look, face) != MPM_WALL_free && MPMUnlikelyBeside(look, b, face) < 0.3))
      continue;
    for (PetscInt d = 0; d < dim; d++) {
      lower[d] = look->lower[b][d];
      upper[d] = look->upper[b][d];
    }
    lower[face / 2] = upper[face / 2] = (face % 2 ? upper : lower)[face / 2];
    for (PetscInt j = 0; MPMUnlikelyPlace(dim, lower, upper, 9, j, x); j++)
      if (MPMExpressionEvaluate(load->value, dim, x, x, 0.7 * look->time->end, value) || value[0] != 0)
        inside = PETSC_FALSE;
  }
  return inside;
}

PetscBool MPMUnlikely_load_pulls(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad *load = &look->scene->loads[k];
  const PetscInt b = load->body, dim = look->core->grid.dim, up = look->core->params.gravity[look->down] < 0 ? 1 : -1;
  const MPMMaterial *m      = &look->scene->materials[look->scene->bodies[b].material];
  const PetscReal    height = look->upper[b][look->down] - look->lower[b][look->down];
  const PetscBool    bore   = InBore(look, load);
  PetscReal          x[3]   = {0};
  PetscBool          wide   = load->type == MPM_LOAD_PRESSURE && look->g > 0 &&
                   load->sides == (PetscInt)1 << (2 * look->down + (up > 0));

  for (PetscInt d = 0; d < dim; d++) /* ground, and not a bar */
    wide = wide && (d == look->down || look->upper[b][d] - look->lower[b][d] > height);
  if ((!(look->g > 0) && load->type != MPM_LOAD_PRESSURE) || m->type->traits & MPM_FLUID ||
      (!bore && !(m->type->traits & MPM_PLASTIC) && !wide) || load->type == MPM_LOAD_TORQUE ||
      (!bore && !(m->type->traits & MPM_LOOSE) && m->rho > MPM_BOUND_dense))
    return PETSC_FALSE;
  /* At 11 times and places: where it presses at any of them, it is one that swings. */
  for (PetscInt j = 0; j <= 120; j++) {
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
  (void)snprintf(odd->meant, MPM_WORDS, "%s",
                 bore                            ? "into its bore, as suction does"
                 : m->type->traits & MPM_PLASTIC ? "outward, which bears hardly any tension"
                                                 : "outward, against its weight");
  return odd->ratio > 0 && MPMUnlikelyGiven("load", load->name, "_value", odd);
}

/* The strain by a load, in bending where the body is slender: 6 F L/(E H^2) at most, of a force over its longest side. */
PetscBool MPMUnlikely_load_small(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscInt b     = look->scene->loads[k].body;
  MPMOdd         still = {0};
  PetscReal      size, most = 0, least = PETSC_MAX_REAL;

  if (MPMUnlikely_formula_still(look, k, &still) && still.ratio > 0) return PETSC_FALSE; /* which is told */
  if (!Load(look, k, odd, &size)) return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) {
    most  = PetscMax(most, look->upper[b][d] - look->lower[b][d]);
    least = PetscMin(least, look->upper[b][d] - look->lower[b][d]);
  }
  odd->ratio *= 6 * PetscSqr(most / least);
  (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[b].name);
  return PETSC_TRUE;
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

/* Does a load on a face act along its normal alone, at all times? */
static PetscBool IsNormal(const MPMLook *look, const MPMLoad *load, PetscInt axis)
{
  const PetscInt b = load->body, dim = look->core->grid.dim;
  PetscReal      x[3] = {0};

  if (load->type == MPM_LOAD_PRESSURE) return PETSC_TRUE;
  for (PetscInt j = 0; j < 8 && MPMUnlikelyPlace(dim, look->lower[b], look->upper[b], 2, j, x); j++)
    for (PetscInt k = 1; k <= 8; k++) {
      PetscReal value[9] = {0};

      if (MPMExpressionEvaluate(load->value, dim, x, x, look->time->end * (PetscReal)k / 8, value)) return PETSC_FALSE;
      for (PetscInt d = 0; d < dim; d++)
        if (d != axis && value[d] != 0) return PETSC_FALSE;
    }
  return PETSC_TRUE;
}

/* The only load of an elastic body in statics, which has one sign and is gone at the end: its value then over its largest. */
PetscBool MPMUnlikely_load_gone(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  const PetscInt  dim = look->core->grid.dim, nc = scene->loads[k].nc, n = 64;
  const PetscReal began = look->core->stages.began, end = look->time->end;
  PetscReal       x[3] = {0}, last = 0, most[9] = {0}, least[9] = {0}, size = 0, swings = 0;

  if (!MPMUnlikelyStatic(odd) || scene->nloads > 1 || look->g > 0 || scene->acceleration || look->core->rigids.n ||
      look->core->stages.now < look->core->stages.n || !(end > began) || MPMWallsHave(&scene->walls, MPM_WALL_MOVES) ||
      scene->materials[scene->bodies[scene->loads[k].body].material].type->traits & MPM_PLASTIC)
    return PETSC_FALSE;
  for (PetscInt j = 0;
       MPMUnlikelyPlace(dim, look->lower[scene->loads[k].body], look->upper[scene->loads[k].body], 9, j, x); j++)
    for (PetscInt i = 0; i <= n; i++) {
      PetscReal value[9] = {0};

      if (MPMExpressionEvaluate(scene->loads[k].value, dim, x, x, began + (end - began) * (PetscReal)i / (PetscReal)n,
                                value))
        return PETSC_FALSE;
      for (PetscInt c = 0; c < nc; c++) {
        most[c]  = PetscMax(most[c], value[c]);
        least[c] = PetscMin(least[c], value[c]);
        if (i == n) last = PetscMax(last, PetscAbsReal(value[c]));
      }
    }
  for (PetscInt c = 0; c < nc; c++) {
    size   = PetscMax(size, PetscMax(most[c], -least[c]));
    swings = PetscMax(swings, PetscMin(most[c], -least[c]));
  }
  odd->ratio = last > 1e-12 * size ? last / size : 0;
  MPMUnlikelyWrite(odd->other, end);
  return size > 0 && swings < 0.1 * size && MPMUnlikelyGiven("load", scene->loads[k].name, "_value", odd);
}

/* Do all particles on which a load on the volume acts lie within two cells of a fixed wall, of a body that is longer? */
static PetscBool IsInClamp(const MPMLook *look, const MPMLoad *load, PetscInt face)
{
  const MPMGrid *grid = &look->core->grid;
  const PetscInt d = face / 2, b = load->body;
  PetscReal      x[3] = {0};
  PetscBool      some = PETSC_FALSE;

  if (MPMUnlikelyBeside(look, b, face) > 0.3 || look->upper[b][d] - look->lower[b][d] < 4 * grid->h[d])
    return PETSC_FALSE;
  for (PetscInt j = 0; MPMUnlikelyPlace(grid->dim, look->lower[b], look->upper[b], 32, j, x); j++) {
    PetscReal value[9] = {0};

    if (!MPMRegionInside(&look->scene->bodies[b].region, grid->dim, x)) continue;
    if (MPMExpressionEvaluate(load->where, grid->dim, x, x, 0, value)) return PETSC_FALSE;
    if (!(value[0] > 0)) continue;
    if ((face % 2 ? grid->upper[d] - x[d] : x[d] - grid->lower[d]) > 2 * grid->h[d]) return PETSC_FALSE;
    some = PETSC_TRUE;
  }
  return some;
}

PetscBool MPMUnlikely_load_held(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad *load = &look->scene->loads[k];

  (void)snprintf(odd->meant, MPM_WORDS, MPMLoadIsOnVolume(load) ? "place" : "side");
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++) {
    const MPMWall type = MPMUnlikelyWall(look, face);

    if (MPMLoadIsOnVolume(load)) {
      if (load->where && !look->scene->bodies[load->body].points && MPMWallHas(type, MPM_WALL_TANGENT) &&
          !MPMWallHas(type, MPM_WALL_MOVES) && IsInClamp(look, load, face))
        return MPMUnlikelyGiven("load", load->name, "_where", odd);
      continue;
    }
    if (load->sides == (PetscInt)1 << face && MPMUnlikelyBeside(look, load->body, face) < 0.3 &&
        (MPMWallHas(type, MPM_WALL_TANGENT) ||
         (MPMWallHas(type, MPM_WALL_NORMAL) && !MPMWallHas(type, MPM_WALL_PUSHES | MPM_WALL_MOVES) &&
          IsNormal(look, load, face / 2))))
      return MPMUnlikelyGiven("load", load->name, "_face", odd);
  }
  return PETSC_FALSE;
}

/* A load on a strip of one side that ends at a fixed wall beside it, of a body that another wall bears: half of a footing. */
PetscBool MPMUnlikely_load_beside(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  enum { STRIPS = 40 };
  const MPMLoad *load = &look->scene->loads[k];
  const MPMGrid *grid = &look->core->grid;
  const PetscInt b    = load->body;

  for (PetscInt face = 0; face < 2 * grid->dim; face++)
    for (PetscInt side = 0; side < 2 * grid->dim; side++) {
      const PetscInt d = side / 2, wall = face ^ 1;
      PetscReal      x[3] = {0}, acts[STRIPS];

      if (load->sides != (PetscInt)1 << face || d == face / 2 || MPMUnlikelyWall(look, side) != MPM_WALL_fixed ||
          MPMUnlikelyBeside(look, b, side) > 0.3 || MPMUnlikelyBeside(look, b, wall) > 0.3 ||
          !MPMWallHas(MPMUnlikelyWall(look, wall), MPM_WALL_NORMAL))
        continue;
      for (PetscInt e = 0; e < grid->dim; e++) x[e] = 0.5 * (look->lower[b][e] + look->upper[b][e]);
      x[face / 2] = (face % 2 ? look->upper : look->lower)[b][face / 2];
      for (PetscInt j = 0; j < STRIPS; j++) {
        const PetscReal part     = ((PetscReal)j + 0.5) / STRIPS;
        PetscReal       value[9] = {0};

        x[d] = look->lower[b][d] + (side % 2 ? 1 - part : part) * (look->upper[b][d] - look->lower[b][d]);
        if (MPMExpressionEvaluate(load->value, grid->dim, x, x, 0.7 * look->time->end, value)) return PETSC_FALSE;
        acts[j] = PetscAbsReal(load->type == MPM_LOAD_PRESSURE ? value[0] : value[face / 2]);
      }
      if (!(acts[0] > 0) || acts[STRIPS / 2] > 0 || acts[STRIPS - 1] > 0) continue;
      (void)snprintf(odd->other, MPM_WORDS, "%.60s beside -bc_%.8s_type fixed", look->scene->bodies[b].name,
                     MPMFaceNames[side]);
      (void)snprintf(odd->meant, MPM_WORDS, "for a plane of symmetry write -bc_%.8s_type slip", MPMFaceNames[side]);
      return MPMUnlikelyGiven("load", load->name, "_value", odd);
    }
  return PETSC_FALSE;
}

/* A pressure on one side that changes linearly with depth, as of water: Pa/m, at the largest of 10 times. */
PetscBool MPMUnlikely_load_head(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  enum { DEPTHS = 33 };
  const MPMLoad  *load = &look->scene->loads[k];
  const PetscInt  b = load->body, dim = look->core->grid.dim, down = look->down;
  const PetscReal up   = look->core->params.gravity[down] < 0 ? 1 : -1;
  const PetscReal step = (look->upper[b][down] - look->lower[b][down]) / DEPTHS;
  PetscReal       most = 0, slope = 0;

  if (!look->earth || load->type != MPM_LOAD_PRESSURE || !(step > 0)) return PETSC_FALSE;
  for (PetscInt j = 0; j <= 10; j++) {
    PetscReal p[DEPTHS], x[3] = {0};

    for (PetscInt d = 0; d < dim; d++) x[d] = 0.5 * (look->lower[b][d] + look->upper[b][d]);
    for (PetscInt face = 0; face < 2 * dim; face++)
      if (load->sides == (PetscInt)1 << face)
        x[face / 2] = face % 2 ? look->upper[b][face / 2] : look->lower[b][face / 2];
    for (PetscInt n = 0; n < DEPTHS; n++) {
      PetscReal value[9] = {0};

      x[down] = look->lower[b][down] + step * ((PetscReal)n + 0.5);
      if (MPMExpressionEvaluate(load->value, dim, x, x, look->time->end * (PetscReal)j / 10, value)) return PETSC_FALSE;
      p[n] = value[0];
    }
    for (PetscInt n = 2; n < DEPTHS; n++) /* it changes as much in two layers, in which it acts */
      if (p[n - 2] != 0 && p[n - 1] != 0 && p[n] != 0 && p[n - 2] != p[n] &&
          PetscAbsReal(p[n] - 2 * p[n - 1] + p[n - 2]) < 1e-6 * PetscAbsReal(p[n] - p[n - 2]) &&
          PetscAbsReal(p[n]) > PetscAbsReal(most)) {
        most  = p[n];
        slope = -up * (p[n] - p[n - 1]) / step;
      }
  }
  if (most < 0 && slope < -500 && slope > -3e4) {
    (void)snprintf(odd->other, MPM_WORDS, "it is negative, and pulls %s", look->scene->bodies[b].name);
    (void)snprintf(odd->meant, MPM_WORDS, "a pressure that presses is positive");
  } else if (most > 0 && slope < -500 && slope > -3e4) {
    (void)snprintf(odd->other, MPM_WORDS, "it grows upward, by %.3g Pa/m", (double)-slope);
    (void)snprintf(odd->meant, MPM_WORDS, "the pressure of water or ground grows with depth");
  } else if (most > 0 && slope > 800 && slope < 1300) {
    (void)snprintf(odd->other, MPM_WORDS, "it grows with depth by %.3g Pa/m, the density of water", (double)slope);
    (void)snprintf(odd->meant, MPM_WORDS, "its pressure grows by rho g, 9810 Pa/m");
  } else
    return PETSC_FALSE;
  return MPMUnlikelyGiven("load", load->name, "_value", odd);
}

PetscBool MPMUnlikely_load_all(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad *load = &look->scene->loads[k];

  if (load->type != MPM_LOAD_TRACTION || MPMUnlikelyGiven("load", load->name, "_face", odd)) return PETSC_FALSE;
  (void)snprintf(odd->meant, MPM_WORDS, "-load_%.100s_face", load->name);
  return MPMUnlikelyGiven("load", load->name, "_value", odd) && !strpbrk(odd->value, "xyXYZ");
}

PetscBool MPMUnlikely_load_twice(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  static const char *const options[] = {"_body", "_type", "_value", "_face", "_where", "_point"};

  for (PetscInt l = 0; l < k; l++) {
    size_t same = 0;

    for (size_t j = 0; j < sizeof options / sizeof options[0]; j++) {
      MPMOdd          a = {0}, b = {0};
      const PetscBool one = MPMUnlikelyGiven("load", look->scene->loads[k].name, options[j], &a),
                      two = MPMUnlikelyGiven("load", look->scene->loads[l].name, options[j], &b);

      same += one == two && (!one || !strcasecmp(a.value, b.value));
    }
    if (same < sizeof options / sizeof options[0]) continue;
    (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->loads[l].name);
    (void)snprintf(odd->meant, MPM_WORDS, "%s", look->scene->loads[k].name);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_where_all(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad *load = &look->scene->loads[k];
  const MPMBody *b    = &look->scene->bodies[load->body];

  return MPMLoadIsOnVolume(load) && load->where && load->n == b->n &&
         MPMUnlikelyGiven("load", load->name, "_where", odd);
}

PetscBool MPMUnlikely_load_yield(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad     *load = &look->scene->loads[k];
  const MPMMaterial *m    = &look->scene->materials[look->scene->bodies[load->body].material];
  const MPMFormula   f    = MPMUnlikelyFormula(look, k);
  PetscReal          size, value;

  if (look->g > 0 || look->scene->nloads > 1 || look->scene->acceleration || look->scene->bodies[load->body].v2 > 0 ||
      MPMLoadIsOnVolume(load) || !(m->type->traits & MPM_PLASTIC) || m->type->traits & (MPM_LOOSE | MPM_FLUID) ||
      look->core->stages.n)
    return PETSC_FALSE;
  if (!MPMUnlikelyNumber("material", m->name, "_yield", odd, &value) || value > 0.1 * MPMUnlikelyModulus(m, PETSC_TRUE))
    return PETSC_FALSE; /* it is not meant to flow */
  (void)snprintf(odd->other, MPM_WORDS, "-material_%s_yield %.3g Pa", m->name, (double)value);
  size       = MPMUnlikelySize(look, &f);
  odd->ratio = size / value;
  if (!(size > 0) || !MPMUnlikelyGiven("load", load->name, "_value", odd)) return PETSC_FALSE;
  MPMUnlikelyThousand(odd);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_load_at_once(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;

  if (k || look->g > 0 || scene->acceleration || look->core->stages.n || look->core->step || !(look->time->fixed > 0) ||
      !MPMUnlikelyStatic(odd))
    return PETSC_FALSE;
  for (PetscInt l = 0; l < scene->nloads; l++) {
    const MPMFormula f = MPMUnlikelyFormula(look, l);

    if (!MPMUnlikelySteady(look, &f)) return PETSC_FALSE;
  }
  if (MPMWallsHave(&scene->walls, MPM_WALL_MOVES)) return PETSC_FALSE;
  odd->ratio = PetscCeilReal(look->time->end / look->time->fixed - 1e-6);
  return MPMUnlikelyGiven("load", scene->loads[0].name, "_value", odd);
}
