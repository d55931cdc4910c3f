/* unlikely_motion.c - the rows of plausible.def of what does not meet, stand, flow or come to rest. */
#include <strings.h>
#include "advice/unlikely.h"

#define TIMES  200 /* places in time at which the distance of two bodies is looked at */
#define PLACES 5   /* places on each axis of a body at which a load is looked at */

/* Returns how many cells the boxes of two bodies are apart, on straight ways, where they are nearest. */
static PetscReal Nearest(const MPMLook *look, PetscInt a, PetscInt b, const PetscReal v[])
{
  PetscReal nearest = PETSC_MAX_REAL;

  for (PetscInt k = 0; k <= TIMES; k++) {
    PetscReal gap = 0;

    for (PetscInt d = 0; d < look->core->grid.dim; d++) {
      const PetscReal way = v[d] * look->time->end * (PetscReal)k / TIMES; /* of b, as seen from a */

      gap = PetscMax(
          gap, PetscMax(look->lower[b][d] + way - look->upper[a][d], look->lower[a][d] - look->upper[b][d] - way) /
                   look->core->grid.h[d]);
    }
    nearest = PetscMin(nearest, gap);
  }
  return nearest;
}

PetscBool MPMUnlikely_meets_none(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  PetscReal       speed = 0;
  MPMOdd          moves = {0}, other = {0};

  (void)k;
  if (look->g > 0 || scene->forced || scene->known || scene->initial || look->core->rigids.n || look->core->step)
    return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++)
    if (scene->walls.given[face / 2][face % 2].type != MPM_WALL_free) return PETSC_FALSE;
  odd->ratio = PETSC_MAX_REAL;
  for (PetscInt a = 0; a < scene->nbodies; a++) {
    PetscReal va[9] = {0};

    if (scene->bodies[a].source.on || (scene->bodies[a].v2 > 0 && !MPMUnlikelyVelocity(look, a, &moves, va)))
      return PETSC_FALSE;
    for (PetscInt b = 0; b < a; b++) {
      PetscReal v[9] = {0};

      if (scene->bodies[b].v2 > 0 && !MPMUnlikelyVelocity(look, b, &other, v)) return PETSC_FALSE;
      for (PetscInt d = 0; d < look->core->grid.dim; d++) {
        v[d] -= va[d];
        speed = PetscMax(speed, PetscAbsReal(v[d]));
      }
      odd->ratio = PetscMin(odd->ratio, Nearest(look, a, b, v));
    }
  }
  if (!(speed * look->time->end > 3e-5 * MPMGridSmallestH(&look->core->grid)))
    return PETSC_FALSE; /* the rows together, speed_none */
  for (PetscInt b = 0; b < scene->nbodies; b++) {
    MPMOdd flies = {0};

    if (MPMUnlikely_flies_away(look, b, &flies)) return PETSC_FALSE; /* which is told */
  }
  (void)snprintf(odd->option, MPM_WORDS, "%s", moves.value[0] ? moves.option : other.option);
  (void)snprintf(odd->value, MPM_WORDS, "%s", moves.value[0] ? moves.value : other.value);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_hangs(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;
  const PetscInt down = look->down, up = look->core->params.gravity[look->down] > 0;
  const MPMBody *b     = &look->scene->bodies[k];
  PetscBool      walls = PETSC_FALSE;

  if (!(look->g > 0) || MPMInitialGravity(look->scene) > 0 || b->v2 > 0 || grid->total || look->core->rigids.n ||
      look->core->stages.now > 1 || look->core->step ||
      !(look->scene->materials[b->material].type->traits & MPM_LOOSE) ||
      look->scene->walls.given[down][up].type == MPM_WALL_free ||
      (up ? look->upper[k][down] < look->highest[down] : look->lower[k][down] > look->lowest[down]))
    return PETSC_FALSE;
  for (PetscInt d = 0; d < grid->dim; d++)
    for (PetscInt side = 0; side < 2 && d != down; side++)
      if (look->scene->walls.given[d][side].type != MPM_WALL_free && !grid->periodic[d] &&
          (side ? grid->upper[d] - look->upper[k][d] : look->lower[k][d] - grid->lower[d]) < 0.3 * grid->h[d])
        walls = PETSC_TRUE;
  odd->ratio = ((up ? grid->upper[down] - look->upper[k][down] : look->lower[k][down] - grid->lower[down]) -
                look->scene->walls.place[2 * down + up]) /
               grid->h[down];
  (void)snprintf(odd->option, MPM_WORDS, "-body_%s_shape", b->name);
  (void)snprintf(odd->other, MPM_WORDS, "%s", b->name);
  (void)snprintf(odd->meant, MPM_WORDS, "%c = %.6g", "xyz"[down], (double)(up ? grid->upper[down] : grid->lower[down]));
  return walls;
}

/* Returns the largest size of a load on places all over the box of its body, and whether it is the same all the time. */
static PetscReal Largest(const MPMLook *look, const MPMLoad *load, PetscBool *steady)
{
  const PetscInt dim = look->core->grid.dim, n = dim == 1   ? PLACES
                                                 : dim == 2 ? PLACES * PLACES
                                                            : PLACES * PLACES * PLACES;
  PetscReal      most = 0;

  *steady = PETSC_TRUE;
  for (PetscInt j = 0; j < n; j++) {
    PetscReal      x[3] = {0}, value[9] = {0}, late[9] = {0};
    const PetscInt at[] = {j % PLACES, j / PLACES % PLACES, j / (PLACES * PLACES)};

    for (PetscInt d = 0; d < dim; d++)
      x[d] = look->lower[load->body][d] +
             (look->upper[load->body][d] - look->lower[load->body][d]) * ((PetscReal)at[d] + 0.5) / PLACES;
    most = PetscMax(most, MPMUnlikelySize(look, load->value, load->nc, x));
    if (MPMExpressionEvaluate(load->value, dim, x, x, 0.01 * look->time->end, value)) return 0;
    for (PetscInt t = 1; t <= 4; t++) {
      if (MPMExpressionEvaluate(load->value, dim, x, x, look->time->end * (PetscReal)t / 4, late)) return 0;
      for (PetscInt c = 0; c < load->nc; c++)
        if (PetscAbsReal(value[c] - late[c]) > 1e-9 * PetscAbsReal(late[c])) *steady = PETSC_FALSE;
    }
  }
  return most;
}

PetscBool MPMUnlikely_load_yield(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMLoad     *load = &look->scene->loads[k];
  const MPMMaterial *m    = &look->scene->materials[look->scene->bodies[load->body].material];
  PetscBool          steady;
  PetscReal          size, value;

  if (look->g > 0 || look->scene->nloads > 1 || look->scene->acceleration || look->scene->bodies[load->body].v2 > 0 ||
      MPMLoadIsOnVolume(load) || !(m->type->traits & MPM_PLASTIC) || m->type->traits & (MPM_LOOSE | MPM_FLUID) ||
      look->core->stages.n)
    return PETSC_FALSE;
  if (!MPMUnlikelyNumber("material", m->name, "_yield", odd, &value) || value > 0.1 * MPMUnlikelyModulus(m, PETSC_TRUE))
    return PETSC_FALSE; /* it is not meant to flow */
  (void)snprintf(odd->other, MPM_WORDS, "-material_%s_yield %.3g Pa", m->name, (double)value);
  size       = Largest(look, load, &steady);
  odd->ratio = size / value;
  MPMUnlikelyWrite(odd->meant, 1000 * size);
  return size > 0 ? MPMUnlikelyGiven("load", load->name, "_value", odd) : PETSC_FALSE;
}

PetscBool MPMUnlikely_load_at_once(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  PetscBool       steady;

  if (k || look->g > 0 || scene->acceleration || look->core->stages.n || look->core->step || !(look->time->fixed > 0) ||
      !MPMUnlikelyGiven("method_time", NULL, "", odd) || strcasecmp(odd->value, "static"))
    return PETSC_FALSE;
  for (PetscInt l = 0; l < scene->nloads; l++)
    if (!(Largest(look, &scene->loads[l], &steady) > 0) || !steady) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++)
    if (MPMWallHas(scene->walls.given[face / 2][face % 2].type, MPM_WALL_MOVES)) return PETSC_FALSE;
  odd->ratio = PetscCeilReal(look->time->end / look->time->fixed - 1e-6);
  return MPMUnlikelyGiven("load", scene->loads[0].name, "_value", odd);
}

PetscBool MPMUnlikely_rest_undamped(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  odd->ratio = 1;
  return MPMUnlikelyGiven("time_rest", NULL, "", odd) && strtod(odd->value, NULL) > 0 && !MPMDampingIsOn(look->core) &&
                 !look->core->implicit
             ? PETSC_TRUE
             : PETSC_FALSE;
}

PetscBool MPMUnlikely_check_walls(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  if (!MPMUnlikelyNumber("check_momentum", NULL, "", odd, &odd->ratio) || odd->ratio > 0.1) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++) {
    const MPMWall type = look->scene->walls.given[face / 2][face % 2].type;

    if (type != MPM_WALL_free && type != MPM_WALL_periodic && !odd->other[0])
      (void)snprintf(odd->other, MPM_WORDS, "the wall -bc_%.8s_type %.40s", MPMFaceNames[face], MPMWallNames[type]);
  }
  return odd->other[0] ? PETSC_TRUE : PETSC_FALSE;
}
