/* unlikely_start.c - the rows of plausible.def of how bodies lie at faces, and of stresses and deformations at the start. */
#include <strings.h>
#include "advice/unlikely.h"

#define PLACES 5 /* on each axis of a body */

/* A wall is a plane of symmetry if it cuts the shape of the body; what moves away from a slip wall on which it lies,
   the wall holds back. */
PetscBool MPMUnlikely_across(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid  = &look->core->grid;
  MPMRegion      whole = look->scene->bodies[k].region;
  PetscReal      v[9] = {0}, lower[3], upper[3], size = 0;

  if (!MPMUnlikelyStarts(look) || look->scene->bodies[k].points || !MPMUnlikelyVelocity(look, k, odd, v))
    return PETSC_FALSE;
  whole.nwithin = 0;
  MPMRegionBounds(&whole, grid->dim, lower, upper);
  for (PetscInt d = 0; d < grid->dim; d++) size = PetscMax(size, PetscAbsReal(v[d]));
  for (PetscInt face = 0; face < 2 * grid->dim; face++) {
    const PetscInt  d      = face / 2;
    const PetscBool axis   = grid->round && !face && grid->lower[0] == 0;
    const PetscReal beyond = face % 2 ? upper[d] - grid->upper[d] : grid->lower[d] - lower[d];
    PetscBool       away;

    if (MPMUnlikelyWall(look, face) != MPM_WALL_slip || MPMUnlikelyBeside(look, k, face) > 0.1 ||
        !(PetscAbsReal(v[d]) > 1e-3 * size))
      continue;
    if (!axis &&
        ((face % 2 ? v[d] : -v[d]) > 0 ||
         !MPMMaterialKeepsShape(&look->scene->materials[look->scene->bodies[k].material])) &&
        !(beyond > 0.25 * (look->upper[k][d] - look->lower[k][d])))
      continue;
    away = !axis && (face % 2 ? v[d] : -v[d]) < 0 && PetscAbsReal(v[d]) == size;
    (void)snprintf(odd->other, MPM_WORDS,
                   axis ? "%.60s %s the axis of revolution" : "%.60s %s the wall -bc_%s_type slip",
                   look->scene->bodies[k].name, away ? "away from" : "across", MPMFaceNames[face]);
    (void)snprintf(odd->meant, MPM_WORDS,
                   away ? "check its sign, or choose separate" : "check the sequence of its components");
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* A solid that flies along a fixed wall on which its longer side lies. */
PetscBool MPMUnlikely_clamped(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal v[9] = {0};
  PetscInt  fast = 0;

  if (!MPMUnlikelyStarts(look) || !MPMUnlikelyVelocity(look, k, odd, v) ||
      !MPMMaterialKeepsShape(&look->scene->materials[look->scene->bodies[k].material]))
    return PETSC_FALSE;
  for (PetscInt d = 1; d < look->core->grid.dim; d++)
    if (PetscAbsReal(v[d]) > PetscAbsReal(v[fast])) fast = d;
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++) {
    const PetscInt d = face / 2;

    if (d == fast || MPMUnlikelyWall(look, face) != MPM_WALL_fixed || MPMUnlikelyBeside(look, k, face) > 0.1 ||
        look->upper[k][fast] - look->lower[k][fast] < look->upper[k][d] - look->lower[k][d])
      continue;
    odd->ratio = PetscAbsReal(v[fast]);
    (void)snprintf(odd->other, MPM_WORDS, "%.60s along the wall -bc_%.8s_type fixed", look->scene->bodies[k].name,
                   MPMFaceNames[face]);
    (void)snprintf(odd->meant, MPM_WORDS, "write -bc_%.8s_type slip for a plane of symmetry, or for a smooth wall",
                   MPMFaceNames[face]);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* A velocity whose slopes across the axes are the same all over a solid and equal by pairs, without any along them. */
PetscBool MPMUnlikely_strains(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b     = &look->scene->bodies[k];
  const PetscInt dim   = look->core->grid.dim;
  PetscReal      v0[9] = {0}, slope[3][3], x[3] = {0}, size = 0, off = 0;

  if (!MPMUnlikelyStarts(look) || !b->velocity || !MPMMaterialKeepsShape(&look->scene->materials[b->material]) ||
      MPMExpressionEvaluate(b->velocity, dim, look->lower[k], look->lower[k], 0, v0))
    return PETSC_FALSE;
  for (PetscInt e = 0; e < dim; e++) {
    const PetscReal length = look->upper[k][e] - look->lower[k][e];
    PetscReal       v[9]   = {0};

    for (PetscInt d = 0; d < dim; d++) x[d] = d == e ? look->upper[k][d] : look->lower[k][d];
    if (MPMExpressionEvaluate(b->velocity, dim, x, x, 0, v)) return PETSC_FALSE;
    for (PetscInt d = 0; d < dim; d++) {
      slope[d][e] = (v[d] - v0[d]) / length;
      size        = PetscMax(size, PetscAbsReal(slope[d][e]));
    }
  }
  for (PetscInt d = 0; d < dim; d++)
    for (PetscInt e = 0; e <= d; e++)
      off = PetscMax(off, PetscAbsReal(d == e ? slope[d][d] : slope[d][e] - slope[e][d]));
  for (PetscInt j = 0; MPMUnlikelyPlace(dim, look->lower[k], look->upper[k], PLACES, j, x); j++) {
    PetscReal v[9] = {0};

    if (MPMExpressionEvaluate(b->velocity, dim, x, x, 0, v)) return PETSC_FALSE;
    for (PetscInt d = 0; d < dim; d++) {
      PetscReal differs = v[d] - v0[d];

      for (PetscInt e = 0; e < dim; e++) differs -= slope[d][e] * (x[e] - look->lower[k][e]);
      off = PetscMax(off, PetscAbsReal(differs) / (look->upper[k][d] - look->lower[k][d]));
    }
  }
  if (!(off < 1e-6 * size)) return PETSC_FALSE;
  for (PetscInt d = 1; d < dim; d++)
    for (PetscInt e = 0; e < d; e++)
      if (PetscAbsReal(slope[d][e]) > 1e-6 * size)
        (void)snprintf(odd->meant, MPM_WORDS, "its v%c along %c and its v%c along %c have the same slope, %.3g/s",
                       "xyz"[e], "xyz"[d], "xyz"[d], "xyz"[e], (double)slope[d][e]);
  return MPMUnlikelyGiven("body", b->name, "_velocity", odd);
}

/* How many cells what is fastest moves until the end, where a body lies at a free face beside one of symmetry. */
PetscBool MPMUnlikely_side_open(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMCore *core  = look->core;
  PetscInt       walls = 0, open = -1;
  PetscReal      v[9] = {0};

  for (PetscInt b = 0; b < look->scene->nbodies; b++)
    odd->ratio = PetscMax(odd->ratio,
                          PetscSqrtReal(look->scene->bodies[b].v2) * look->time->end / MPMGridSmallestH(&core->grid));
  if (!MPMUnlikelyStarts(look) || core->params.deletes || core->implicit || core->grid.total || core->grid.dim == 1)
    return PETSC_FALSE;
  (void)MPMUnlikelyVelocity(look, k, odd, v);
  for (PetscInt face = 0; face < 2 * core->grid.dim; face++) {
    const MPMWall type = MPMUnlikelyWall(look, face);

    if (core->grid.periodic[face / 2] || MPMUnlikelyBeside(look, k, face) > 0.1) continue;
    if (type == MPM_WALL_slip) walls++;
    if (type == MPM_WALL_free && open < 0 && (face % 2 ? v[face / 2] : -v[face / 2]) >= 0) open = face;
  }
  if (open < 0 || !walls) return PETSC_FALSE;
  (void)snprintf(odd->option, MPM_WORDS, "-bc_%s_type", MPMFaceNames[open]);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_shape_full(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscBool open = PETSC_FALSE;

  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++) {
    if (look->core->grid.periodic[face / 2] || MPMUnlikelyBeside(look, k, face) > 0.5) return PETSC_FALSE;
    if (MPMUnlikelyWall(look, face) == MPM_WALL_free) open = PETSC_TRUE;
  }
  return open && MPMUnlikelyGiven("body", look->scene->bodies[k].name, "_expression", odd);
}

PetscBool MPMUnlikely_start_far(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b    = &look->scene->bodies[k];
  const PetscInt dim  = look->core->grid.dim;
  PetscReal      x[3] = {0}, most = 1;

  if (!MPMUnlikelyStarts(look) || !b->deformation) return PETSC_FALSE;
  for (PetscInt j = 0; MPMUnlikelyPlace(dim, look->lower[k], look->upper[k], PLACES, j, x); j++) {
    PetscReal F[9] = {0}, J;

    if (MPMExpressionEvaluate(b->deformation, dim, x, x, 0, F)) return PETSC_FALSE;
    J = MPMDet((int)dim, F);
    if (J > 0 && PetscMax(J, 1 / J) > PetscMax(most, 1 / most)) most = J;
  }
  odd->ratio = PetscMax(most, 1 / most);
  MPMUnlikelyWrite(odd->meant, most);
  return MPMUnlikelyGiven("body", b->name, "_deformation", odd);
}

/* The largest vertical stress by a formula, over the stress by the weight; stresses that are the same at all heights
   need not follow from it. */
PetscBool MPMUnlikely_stress_small(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  const PetscInt  dim = look->core->grid.dim, down = look->down;
  PetscReal       x[3] = {0}, most = 0, weight = 0;

  if (!MPMUnlikelyStarts(look) || !(look->g > 0) || MPMUnlikelyGravity(look->core, scene) ||
      MPMInitialGravity(scene) > 0 || !MPMUnlikelyGiven("initial_stress", NULL, "", odd) || !scene->initial ||
      !strchr(odd->value, "xyz"[down]))
    return PETSC_FALSE;
  for (PetscInt b = 0; b < scene->nbodies; b++) {
    if (scene->bodies[b].points || scene->bodies[b].source.on || scene->bodies[b].removed) return PETSC_FALSE;
    weight = PetscMax(weight, MPMUnlikelyWeight(look, scene->bodies[b].material));
    for (PetscInt j = 0; MPMUnlikelyPlace(dim, look->lower[b], look->upper[b], PLACES, j, x); j++) {
      MPMMaterialStart s = {0};
      char             wrong[MPM_TEXT_LEN];

      if (MPMInitialState(scene, look->core, &scene->bodies[b], x, &s, wrong)) return PETSC_FALSE;
      most = PetscMax(most, PetscAbsReal(s.tau[MPMSymIndex(down, down)]));
    }
  }
  odd->ratio = most / weight;
  (void)snprintf(odd->other, MPM_WORDS, "the stress by the weight, %.3g Pa, rho g H", (double)weight);
  return most > 0;
}

PetscBool MPMUnlikely_stress_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return MPMUnlikely_stress_small(look, k, odd);
}

/* Sets the vertical stress by a formula at a place of body b, Pa, and what its slopes along all axes bear, Pa/m, along
   that axis. Returns false where the body has no such stress. */
static PetscBool Bears(const MPMLook *look, PetscInt b, const PetscReal x[], PetscReal *stress, PetscReal *slope)
{
  const PetscInt dim = look->core->grid.dim, down = look->down;

  *slope = 0;
  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal step = 1e-3 * look->core->grid.h[d];
    PetscReal       y[3] = {x[0], x[1], x[2]}, tau[2];

    for (PetscInt side = 0; side < 2; side++) {
      MPMMaterialStart s = {0};
      char             wrong[MPM_TEXT_LEN];

      y[d] = x[d] + (side ? step : -step);
      if (MPMInitialState(look->scene, look->core, &look->scene->bodies[b], y, &s, wrong)) return PETSC_FALSE;
      tau[side] = s.tau[MPMSymIndex(PetscMin(d, down), PetscMax(d, down))];
      *stress   = s.tau[MPMSymIndex(down, down)];
    }
    *slope += (tau[1] - tau[0]) / (2 * step);
  }
  return PETSC_TRUE;
}

/* Is the stress at the start a formula of the height, of a size that the weight may have, and is nothing told of gravity? */
static PetscBool ByHeight(const MPMLook *look, MPMOdd *odd)
{
  const PetscInt dim  = look->core->grid.dim;
  MPMOdd         size = {0};

  if (!MPMUnlikelyStarts(look) || dim == 1 || !look->scene->initial || MPMInitialGravity(look->scene) > 0 ||
      MPMUnlikelyGravity(look->core, look->scene) ||
      (MPMUnlikely_stress_small(look, 0, &size) && (size.ratio < 5e-3 || size.ratio > 200)))
    return PETSC_FALSE;
  return MPMUnlikelyGiven("initial_stress", NULL, "", odd) &&
         strchr(odd->value, "xyz"[look->g > 0 ? look->down : dim - 1]);
}

/* The force out of balance by a formula, per volume and on average, over the weight or, if that is larger, what the formula
   bears. */
PetscBool MPMUnlikely_stress_balance(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscReal rho  = look->scene->materials[look->scene->bodies[k].material].rho;
  MPMLook         up   = *look;
  PetscReal       x[3] = {0}, bears = 0, trace = 0, weight, stress = 0, slope;
  PetscInt        n = 0;

  if (!ByHeight(look, odd)) return PETSC_FALSE;
  if (!(look->g > 0)) up.down = look->core->grid.dim - 1;
  weight = rho * look->core->params.gravity[up.down];
  for (PetscInt j = 0; MPMUnlikelyPlace(look->core->grid.dim, look->lower[k], look->upper[k], PLACES, j, x); j++) {
    if (!MPMRegionInside(&look->scene->bodies[k].region, look->core->grid.dim, x)) continue;
    if (!Bears(&up, k, x, &stress, &slope)) return PETSC_FALSE;
    bears += slope;
    trace += stress;
    n++;
  }
  if (!n) return PETSC_FALSE;
  bears /= n;
  odd->ratio = PetscAbsReal(bears + weight) / PetscMax(PetscAbsReal(bears), PetscAbsReal(weight));
  if (weight != 0)
    (void)snprintf(odd->other, MPM_WORDS, "it bears %.3g of the weight of %s, which is %.3g N/m^3",
                   (double)(-bears / weight), look->scene->bodies[k].name, (double)PetscAbsReal(weight));
  else
    (void)snprintf(odd->other, MPM_WORDS, "it changes along %c by %.3g Pa/m in %s, and -gravity there is 0",
                   "xyz"[up.down], (double)bears, look -> scene -> bodies[k].name);
  (void)snprintf(odd->meant, MPM_WORDS, "%s",
                 weight == 0          ? "give -gravity, or another stress"
                 : trace > 0          ? "this is a tension: compression is negative"
                 : bears * weight > 0 ? "it has to grow with depth"
                                      : "check its numbers, and -gravity");
  return PETSC_TRUE;
}

/* Is a rigid body within a cell above or below a place? */
static PetscBool IsCovered(const MPMLook *look, const PetscReal x[])
{
  const MPMGrid *grid = &look->core->grid;

  for (PetscInt b = look->scene->nbodies; b < look->scene->nbodies + look->scene->nshapes; b++) {
    PetscBool over = look->scene->bodies[b].rigid != MPM_RIGID_NONE;

    for (PetscInt d = 0; d < grid->dim; d++)
      over = over && x[d] > look->lower[b][d] - grid->h[d] && x[d] < look->upper[b][d] + grid->h[d];
    if (over) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* The vertical stress by a formula at a surface on which there is nothing, over the stress by the weight. */
PetscBool MPMUnlikely_stress_top(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  const PetscInt  dim = look->core->grid.dim, down = look->down, up = look->core->params.gravity[down] < 0;
  const PetscReal weight = MPMUnlikelyWeight(look, scene->bodies[k].material),
                  top    = up ? look->upper[k][down] : look->lower[k][down];
  PetscReal x[3] = {0}, most = 0, stress = 0, slope;

  if (!(look->g > 0) || !ByHeight(look, odd) || scene->nloads ||
      (MPMUnlikelyWall(look, 2 * down + up) != MPM_WALL_free && MPMUnlikelyBeside(look, k, 2 * down + up) < 1))
    return PETSC_FALSE;
  for (PetscInt b = 0; b < scene->nbodies; b++)
    if (up ? look->upper[b][down] > top + 1e-6 * look->core->grid.h[down]
           : look->lower[b][down] < top - 1e-6 * look->core->grid.h[down])
      return PETSC_FALSE;
  for (PetscInt j = 0; MPMUnlikelyPlace(dim, look->lower[k], look->upper[k], PLACES, j, x); j++) {
    x[down] = top + (up ? -1e-3 : 1e-3) * look->core->grid.h[down];
    if (MPMRegionInside(&scene->bodies[k].region, dim, x) && !IsCovered(look, x) &&
        Bears(look, k, x, &stress, &slope) && PetscAbsReal(stress) > PetscAbsReal(most))
      most = stress;
  }
  odd->ratio = PetscAbsReal(most) / weight;
  MPMUnlikelyWrite(odd->meant, most);
  return PETSC_TRUE;
}

/* A stress of numbers alone on the side of a body on which a load acts, over the load at the start, or its inverse. */
PetscBool MPMUnlikely_load_stress(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad *load = &look->scene->loads[k];
  const PetscInt b = load->body, dim = look->core->grid.dim;
  PetscReal      x[3] = {0}, has = 0, acts = 0;
  MPMOdd         stress;
  char           wrong[MPM_TEXT_LEN];

  if (!MPMUnlikelyStarts(look) || MPMLoadIsOnVolume(load) || !look->scene->initial ||
      !MPMUnlikelyGiven("initial_stress", NULL, "", &stress) || !strcasecmp(stress.value, "k0") ||
      strpbrk(stress.value, "xyz") || !MPMUnlikelyGiven("load", load->name, "_value", odd))
    return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * dim; face++) {
    MPMMaterialStart s = {0};

    if (load->sides != (PetscInt)1 << face) continue;
    for (PetscInt j = 0; MPMUnlikelyPlace(dim, look->lower[b], look->upper[b], PLACES, j, x); j++) {
      PetscReal value[9] = {0};

      x[face / 2] = face % 2 ? look->upper[b][face / 2] : look->lower[b][face / 2];
      if (MPMExpressionEvaluate(load->value, dim, x, x, 0, value) ||
          MPMInitialState(look->scene, look->core, &look->scene->bodies[b], x, &s, wrong))
        return PETSC_FALSE;
      acts = load->type == MPM_LOAD_PRESSURE ? value[0] : (face % 2 ? -1 : 1) * value[face / 2];
      has  = -s.tau[MPMSymIndex(face / 2, face / 2)];
      if (has == 0 || (acts / has > 0.2 && acts / has < 5)) return PETSC_FALSE;
    }
  }
  (void)snprintf(odd->other, MPM_WORDS,
                 "presses %s with %.3g Pa at the start, and its -initial_stress there with %.3g Pa",
                 look->scene->bodies[b].name, (double)acts, (double)has);
  return has != 0;
}

/* A friction wall, the only one, on which neither weight nor a velocity presses the bodies. */
PetscBool MPMUnlikely_friction_idle(const MPMLook *look, PetscInt face, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  const PetscReal out   = face % 2 ? 1 : -1;

  if (!MPMUnlikelyStarts(look) || MPMUnlikelyWall(look, face) != MPM_WALL_friction ||
      out * look->core->params.gravity[face / 2] > 0 || scene->forced || scene->initial || look->core->rigids.n ||
      look->core->stages.n || scene->nbodies > 1)
    return PETSC_FALSE;
  for (PetscInt other = 0; other < 2 * look->core->grid.dim; other++)
    if (other != face && MPMUnlikelyWall(look, other) != MPM_WALL_free) return PETSC_FALSE;
  for (PetscInt b = 0; b < scene->nbodies; b++) {
    PetscReal v[9] = {0};

    if (scene->bodies[b].source.on || scene->bodies[b].points ||
        (scene->bodies[b].v2 > 0 && !MPMUnlikelyVelocity(look, b, odd, v)) || out * v[face / 2] > 0)
      return PETSC_FALSE;
  }
  (void)snprintf(odd->other, MPM_WORDS, "%s", scene->bodies[0].name);
  return MPMUnlikelyGiven("bc", MPMFaceNames[face], "_type", odd);
}
