/* unlikely_bends.c - the rows of plausible.def of solids that one wall clamps, and that bend out of the grid. */
#include "advice/unlikely.h"

/* Returns the face whose wall alone clamps body k, or -1. */
static PetscInt Clamp(const MPMLook *look, PetscInt k)
{
  const MPMGrid *grid  = &look->core->grid;
  PetscInt       clamp = -1;

  if (grid->dim == 1 || grid->round || look->scene->known || look->core->step || look->core->params.deletes ||
      look->core->rigids.n || grid->total ||
      !MPMMaterialKeepsShape(&look->scene->materials[look->scene->bodies[k].material]))
    return -1;
  for (PetscInt face = 0; face < 2 * grid->dim; face++) {
    const MPMWall t = MPMUnlikelyWall(look, face);

    if (t == MPM_WALL_free || MPMUnlikelyBeside(look, k, face) > 0.5) continue;
    if (clamp >= 0 || !MPMWallHas(t, MPM_WALL_TANGENT)) return -1;
    clamp = face;
  }
  return clamp;
}

/* How far a solid that one wall clamps bends under its weight, over the room that the grid has below it: the deflection
   of the end of a cantilever, twice as far where nothing damps it, and at most its length, and the way of a fall. */
PetscBool MPMUnlikely_bends_out(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid     *grid = &look->core->grid;
  const MPMBody     *b    = &look->scene->bodies[k];
  const MPMMaterial *m    = &look->scene->materials[b->material];
  const PetscInt     down = look->down, up = look->core->params.gravity[down] > 0;
  PetscReal          length, high, bend, room;
  const PetscInt     clamp = Clamp(look, k);

  if (!(look->g > 0) || look->scene->walls.given[down][up].type != MPM_WALL_free || clamp < 0 || clamp / 2 == down)
    return PETSC_FALSE;
  length = look->upper[k][clamp / 2] - look->lower[k][clamp / 2];
  high   = look->upper[k][down] - look->lower[k][down];
  bend   = 1.5 * m->rho * PetscAbsReal(look->core->params.gravity[down]) * PetscPowReal(length, 4) /
         (MPMUnlikelyModulus(m, PETSC_TRUE) * high * high);
  if (!MPMDampingIsOn(look->core) && !look->core->implicit) bend *= 2;
  bend = PetscMin(bend, 0.8 * length);
  if (!look->core->implicit) bend = PetscMin(bend, 0.5 * look->g * look->time->end * look->time->end);
  room = PetscMax(up ? grid->upper[down] - look->upper[k][down] : look->lower[k][down] - grid->lower[down],
                  1e-3 * high);
  odd->ratio = bend / room;
  (void)snprintf(odd->other, MPM_WORDS, "-bc_%.8s_type", MPMFaceNames[clamp]);
  (void)snprintf(odd->meant, MPM_WORDS, "%s bends by about %.2g m, and the grid ends %.2g m below it", b->name,
                 (double)bend, (double)room);
  return MPMUnlikelyGiven("gravity", NULL, "", odd);
}

PetscBool MPMUnlikely_load_bends(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid     *grid = &look->core->grid;
  const MPMLoad     *load = &look->scene->loads[k];
  const MPMFormula   f    = MPMUnlikelyFormula(look, k);
  const PetscInt     b = load->body, clamp = Clamp(look, b), end = clamp < 0 ? -1 : clamp ^ 1;
  const MPMMaterial *m = &look->scene->materials[look->scene->bodies[b].material];
  PetscReal force = MPMUnlikelySize(look, &f), length, size, bend, room, wide = 1, high = PETSC_MAX_REAL, toward,
            value[9] = {0}, x[3] = {0};
  PetscInt across = -1;

  if (clamp < 0 || load->type == MPM_LOAD_TORQUE) return PETSC_FALSE;
  length = look->upper[b][clamp / 2] - look->lower[b][clamp / 2];
  for (PetscInt d = 0; d < grid->dim; d++) { /* it bends along the axis on which it is thinnest */
    size = look->upper[b][d] - look->lower[b][d];
    if (d == clamp / 2) continue;
    if (size < high) high = size, across = d;
    wide *= size;
  }
  wide /= high;
  if (load->type == MPM_LOAD_FORCE)
    force /= wide;
  else if (load->sides == (PetscInt)1 << end && load->type == MPM_LOAD_TRACTION)
    force *= high;
  else if (load->type == MPM_LOAD_TRACTION || load->sides == (PetscInt)1 << 2 * across ||
           load->sides == (PetscInt)1 << (2 * across + 1))
    force *= 3. / 8 * length;
  else
    return PETSC_FALSE;
  for (PetscInt d = 0; d < grid->dim; d++)
    x[d] = end == 2 * d       ? look->lower[b][d]
           : end == 2 * d + 1 ? look->upper[b][d]
                              : 0.5 * (look->lower[b][d] + look->upper[b][d]);
  if (MPMExpressionEvaluate(load->value, grid->dim, x, x, look->time->end, value)) return PETSC_FALSE;
  toward = load->type != MPM_LOAD_PRESSURE            ? value[across]
           : load->sides == (PetscInt)1 << 2 * across ? value[0]
                                                      : -value[0];
  if (toward == 0) return PETSC_FALSE;
  bend       = PetscMin(4 * force * PetscPowReal(length / high, 3) / MPMUnlikelyModulus(m, PETSC_TRUE), 0.8 * length);
  room       = toward > 0 ? grid->upper[across] - look->upper[b][across] : look->lower[b][across] - grid->lower[across];
  odd->ratio = bend / PetscMax(room, grid->h[across]);
  MPMUnlikelyWrite(odd->meant, bend);
  return MPMUnlikelyGiven("load", load->name, "_value", odd);
}
