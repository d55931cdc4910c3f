/* unlikely_bodies.c - the rows of plausible.def of bodies. */
#include "physics/sizes.h"
#include "advice/unlikely.h"

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

/* Is there a rigid body that may come to other places? */
static PetscBool RigidMoves(const MPMScene *scene)
{
  for (PetscInt r = scene->nbodies; r < scene->nbodies + scene->nshapes; r++)
    if (scene->bodies[r].rigid != MPM_RIGID_NONE && scene->bodies[r].rigid != MPM_RIGID_FIXED) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* A gas that a wall or a rigid body may press, with a preset that has no row for gases (preset.def), or with fewer particles
   than that row says. */
PetscBool MPMUnlikely_gas_disorder(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  enum { LEAST = 3 }; /* particles per cell and axis */
  const MPMScene *scene = look->scene;
  const MPMBody  *b     = &scene->bodies[k];
  PetscBool       few   = PETSC_FALSE;

  if (look->core->grid.dim == 1 || !MPMMaterialIsGas(&scene->materials[b->material]) ||
      !(MPMWallsHave(&scene->walls, MPM_WALL_MOVES) || RigidMoves(scene)))
    return PETSC_FALSE;
  if (scene->ppc_gas < LEAST && MPMUnlikelyGiven("method_preset", NULL, "", odd)) return PETSC_TRUE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) few = few || b->ppc[d] < LEAST;
  return few && !b->points && MPMUnlikelyGiven("body", b->name, "_ppc", odd);
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
         MPMUnlikelyBeside(look, k, 2 * d + 1) < 0.1;
}

PetscBool MPMUnlikely_thin(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;
  const MPMBody *b    = &look->scene->bodies[k];
  PetscInt       thin = -1;

  if (grid->dim == 1 || b->points || look->scene->known || MPMUnlikelyFed(look, k)) return PETSC_FALSE;
  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal cells = (look->upper[k][d] - look->lower[k][d]) / grid->h[d];

    if (IsAtFace(look, k, d) || (thin >= 0 && cells >= odd->ratio)) continue;
    thin       = d;
    odd->ratio = cells;
  }
  if (thin < 0) return PETSC_FALSE;
  (void)snprintf(odd->option, MPM_WORDS, "-body_%s_shape", b->name);
  (void)snprintf(odd->other, MPM_WORDS, "%c", "xyz"[thin]);
  MPMGridFiner(grid, 3 / odd->ratio, odd->meant, MPM_WORDS);
  return PETSC_TRUE;
}

/* How many cells a body has along its longest axis, of a solid also beyond a plane of symmetry; of what a source brings more of,
   any little may start. */
PetscBool MPMUnlikely_small(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid  *grid = &look->core->grid;
  const MPMBody  *b    = &look->scene->bodies[k];
  const PetscBool keep = MPMMaterialKeepsShape(&look->scene->materials[b->material]);

  if (grid->dim == 1 || b->points || look->scene->known || MPMUnlikelyFed(look, k)) return PETSC_FALSE;
  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal cells = (look->upper[k][d] - look->lower[k][d]) / grid->h[d] *
                            (keep && IsAtFace(look, k, d) ? 2 : 1);

    if (grid->periodic[d]) return PETSC_FALSE;
    odd->ratio = PetscMax(odd->ratio, cells);
  }
  (void)snprintf(odd->option, MPM_WORDS, "-body_%s_shape", b->name);
  MPMGridFiner(grid, 4 / odd->ratio, odd->meant, MPM_WORDS);
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
  odd->ratio = (look->time->end - look->core->stages.began) *
               PetscSqrtReal(MPMUnlikelyModulus(m, PETSC_FALSE) / m->rho) / size;
  return MPMUnlikelyGiven("time_end", NULL, "", odd);
}

/* Returns how many cells two bodies are apart, by their boxes; 0: these overlap. */
static PetscReal Gap(const MPMLook *look, PetscInt k, PetscInt other)
{
  return PetscMax(0, MPMUnlikelyGap(look, look->lower[k], look->upper[k], look->lower[other], look->upper[other]));
}

PetscBool MPMUnlikely_contact_coarse(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid     *grid  = &look->core->grid;
  const MPMContacts *c     = look->core->contacts;
  const MPMBody     *b     = &look->scene->bodies[k];
  PetscReal          least = PETSC_MAX_REAL;
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
  for (PetscInt d = 0; d < grid->dim; d++)
    odd->ratio = PetscMax(odd->ratio, (look->upper[k][d] - look->lower[k][d]) / grid->h[d]);
  (void)snprintf(odd->option, MPM_WORDS, "-body_%s_shape", b->name);
  MPMGridFiner(grid, 16 / odd->ratio, odd->meant, MPM_WORDS);
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
  return odd->ratio > 0.3 && MPMUnlikelyGiven("bc", MPMFaceNames[face], "_type", odd);
}

/* Do bodies start here with the stress by their weight? */
static PetscBool StartsByWeight(const MPMLook *look)
{
  return MPMInitialGravity(look->scene) > 0 && look->core->stages.now <= 1 && !look->core->step;
}

PetscBool MPMUnlikely_k0_floor(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscInt d = look->down, up = look->core->params.gravity[d] > 0, face = 2 * d + up;

  if (k || !StartsByWeight(look) || look->core->rigids.n) return PETSC_FALSE;
  odd->ratio = MPMUnlikelyBeside(look, -1, face) - look->scene->walls.place[face] / look->core->grid.h[d];
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
    (void)snprintf(odd->option, MPM_WORDS, "-bc_%s_type", MPMFaceNames[face]);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_k0_side(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return StartsByWeight(look) ? OpenSide(look, k, odd) : PETSC_FALSE;
}

/* How many cells a body with the stress k0 ends before a wall that should hold its side: a gap that is small beside its
   height, and in which no other body is. */
PetscBool MPMUnlikely_k0_gap(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid  *grid   = &look->core->grid;
  const PetscReal height = look->upper[k][look->down] - look->lower[k][look->down];
  PetscReal       lower[3], upper[3];

  if (!StartsByWeight(look) || look->core->rigids.n) return PETSC_FALSE;
  MPMRegionBounds(&look->scene->bodies[k].region, grid->dim, lower, upper);
  for (PetscInt face = 0; face < 2 * grid->dim; face++) {
    const PetscInt d = face / 2, side = face % 2;
    PetscBool      filled = PETSC_FALSE;

    odd->ratio = ((side ? grid->upper[d] - upper[d] : lower[d] - grid->lower[d]) - look->scene->walls.place[face]) /
                 grid->h[d];
    for (PetscInt b = 0; b < look->scene->nbodies; b++)
      if (side ? look->upper[b][d] > look->upper[k][d] + 0.05 * grid->h[d]
               : look->lower[b][d] < look->lower[k][d] - 0.05 * grid->h[d])
        filled = PETSC_TRUE;
    if (d == look->down || grid->periodic[d] || filled || !(odd->ratio > 0.3) ||
        odd->ratio * grid->h[d] > 0.25 * height || !MPMWallHas(MPMUnlikelyWall(look, face), MPM_WALL_NORMAL))
      continue;
    return MPMUnlikelyGiven("bc", MPMFaceNames[face], "_type", odd);
  }
  return PETSC_FALSE;
}

/* Is there a place under body k, and nothing between it and the open face below, through which it falls in the time of the run? */
static PetscBool OpenBelow(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  enum { ACROSS = 24, DOWN = 96 };
  const MPMScene *scene = look->scene;
  const MPMGrid  *grid  = &look->core->grid;
  const PetscInt  down = look->down, up = look->core->params.gravity[down] > 0, face = 2 * down + up;
  const PetscReal edge = up ? grid->upper[down] : grid->lower[down],
                  top  = up ? look->lower[k][down] : look->upper[k][down];
  PetscReal x[3]       = {0};

  if (MPMUnlikelyWall(look, face) != MPM_WALL_free || grid->periodic[down] || scene->bodies[k].points)
    return PETSC_FALSE;
  for (PetscInt j = 0; MPMUnlikelyPlace(grid->dim, look->lower[k], look->upper[k], ACROSS, j, x); j++) {
    PetscReal low = edge;
    PetscBool in = PETSC_FALSE, free = PETSC_TRUE;

    if (x[down] != look->lower[k][down] + (look->upper[k][down] - look->lower[k][down]) * 0.5 / ACROSS) continue;
    for (PetscInt i = 0; i < DOWN && free; i++) { /* from above: what is under the lowest matter */
      x[down] = top + (edge - top) * ((PetscReal)i + 0.5) / DOWN;
      if (MPMRegionInside(&scene->bodies[k].region, grid->dim, x)) {
        in  = PETSC_TRUE;
        low = x[down];
        continue;
      }
      for (PetscInt b = 0; in && b < scene->nbodies + scene->nshapes; b++)
        if (b != k && !scene->bodies[b].removed && !scene->bodies[b].source.on &&
            (b < scene->nbodies || scene->bodies[b].rigid != MPM_RIGID_NONE) &&
            MPMRegionInside(&scene->bodies[b].region, grid->dim, x))
          free = PETSC_FALSE;
    }
    if (!in || !free ||
        !(PetscAbsReal(low - edge) < 0.5 * look->g * PetscSqr(look->time->end - look->core->stages.began)))
      continue;
    (void)snprintf(odd->option, MPM_WORDS, "-bc_%s_type", MPMFaceNames[face]);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_flows_out(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = &look->scene->bodies[k];

  if (!(look->g > 0) || look->core->grid.total || !(look->scene->materials[b->material].type->traits & MPM_LOOSE) ||
      MPMUnlikelyGiven("particles_leave", NULL, "", odd))
    return PETSC_FALSE;
  if (RigidMoves(look->scene)) return PETSC_FALSE;
  return look->core->rigids.n ? OpenBelow(look, k, odd) : OpenSide(look, k, odd);
}

PetscBool MPMUnlikely_ppc_many(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = &look->scene->bodies[k];

  if (look->core->grid.dim == 1 || b->points) return PETSC_FALSE;
  odd->ratio = 1;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) {
    odd->ratio *= (PetscReal)b->ppc[d];
    MPMUnlikelyAppend(odd->meant, 3, PetscMin(2, (PetscReal)b->ppc[d]));
  }
  return MPMUnlikelyGiven("body", b->name, "_ppc", odd);
}

PetscBool MPMUnlikely_fluid_fast(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody     *b = &look->scene->bodies[k];
  const MPMMaterial *m = &look->scene->materials[b->material];

  if (!(m->type->traits & MPM_FLUID) || b->v2 > m->K / m->rho) return PETSC_FALSE; /* which is told */
  odd->ratio = PetscSqrtReal(b->v2 * m->rho / m->K);
  MPMUnlikelyWrite(odd->meant, 100 * m->rho * b->v2);
  (void)snprintf(odd->other, MPM_WORDS, "-material_%s_K", m->name);
  return MPMUnlikelyGiven("body", b->name, "_velocity", odd);
}
