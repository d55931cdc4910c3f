/* unlikely_motion.c - the rows of plausible.def of what does not meet, stand, flow or come to rest. */
#include <strings.h>
#include "advice/unlikely.h"

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
          MPMUnlikelyBeside(look, k, 2 * d + side) < 0.3)
        walls = PETSC_TRUE;
  odd->ratio = MPMUnlikelyBeside(look, k, 2 * down + up) - look->scene->walls.place[2 * down + up] / grid->h[down];
  (void)snprintf(odd->option, MPM_WORDS, "-body_%s_shape", b->name);
  (void)snprintf(odd->other, MPM_WORDS, "%s", b->name);
  (void)snprintf(odd->meant, MPM_WORDS, "%c = %.6g", "xyz"[down], (double)(up ? grid->upper[down] : grid->lower[down]));
  return walls;
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
  MPMUnlikelyWrite(odd->meant, 1000 * size);
  return size > 0 ? MPMUnlikelyGiven("load", load->name, "_value", odd) : PETSC_FALSE;
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
    const MPMWall type = MPMUnlikelyWall(look, face);

    if (type != MPM_WALL_free && type != MPM_WALL_periodic && !odd->other[0])
      (void)snprintf(odd->other, MPM_WORDS, "the wall -bc_%.8s_type %.40s", MPMFaceNames[face], MPMWallNames[type]);
  }
  return odd->other[0] ? PETSC_TRUE : PETSC_FALSE;
}
