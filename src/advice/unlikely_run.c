/* unlikely_run.c - the rows of plausible.def of the run. */
#include <ctype.h>
#include "advice/unlikely.h"

PetscBool MPMUnlikely_nothing_moves(const MPMLook *look, PETSC_UNUSED PetscInt k, PETSC_UNUSED MPMOdd *odd)
{
  const MPMScene *scene = look->scene;

  if (look->g > 0 || scene->forced || scene->known || scene->initial || look->core->step) return PETSC_FALSE;
  for (PetscInt b = 0; b < scene->nbodies; b++)
    if (scene->bodies[b].v2 > 0 || scene->bodies[b].points) return PETSC_FALSE;
  for (PetscInt b = scene->nbodies; b < scene->nbodies + scene->nshapes; b++)
    if (scene->bodies[b].rigid == MPM_RIGID_MOVING ||
        (scene->bodies[b].rigid == MPM_RIGID_FREE && (scene->bodies[b].velocity || scene->bodies[b].spin)))
      return PETSC_FALSE;
  return !MPMWallsHave(&scene->walls, MPM_WALL_MOVES);
}

PetscBool MPMUnlikely_nothing_holds(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  PetscInt wall = -1;

  odd->ratio = PETSC_MAX_REAL;
  if (look->g > 0 || !look->scene->nloads || look->core->rigids.n) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++) {
    const MPMWall   t   = MPMUnlikelyWall(look, face);
    const PetscReal gap = MPMUnlikelyBeside(look, -1, face);

    if (t == MPM_WALL_free) continue;
    if (!MPMWallHas(t, MPM_WALL_NORMAL) || MPMWallHas(t, MPM_WALL_PUSHES | MPM_WALL_MOVES)) return PETSC_FALSE;
    if (gap < odd->ratio) wall = face;
    odd->ratio = PetscMin(odd->ratio, gap);
  }
  (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[look->scene->loads[0].body].name);
  return wall >= 0 ? MPMUnlikelyGiven("bc", MPMFaceNames[wall], "_type", odd) : PETSC_FALSE;
}

/* Of a ring the axis of revolution is looked at alone: its hoops hold it along the other one. */
PetscBool MPMUnlikely_nothing_bears(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;

  if (!MPMUnlikelyStatic(odd)) return PETSC_FALSE;
  (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[0].name);
  for (PetscInt a = grid->round ? 1 : 0; a < grid->dim; a++) {
    PetscReal least = PETSC_MAX_REAL;

    for (PetscInt face = 0; face < 2 * grid->dim; face++) {
      const PetscInt d    = face / 2;
      const MPMWall  type = MPMUnlikelyWall(look, face);

      if (d == a ? MPMWallHas(type, MPM_WALL_NORMAL) : MPMWallHas(type, MPM_WALL_TANGENT | MPM_WALL_BRAKES))
        least = PetscMin(least, MPMUnlikelyBeside(look, -1, face) - look->scene->walls.place[face] / grid->h[d]);
    }
    if (!(least > odd->ratio)) continue;
    odd->ratio = least;
    (void)snprintf(odd->meant, MPM_WORDS, "%c", "xyz"[a]);
  }
  return PETSC_TRUE;
}

/* In 3-D heights may be along any axis: gravity is then along another one than the last where that alone has a floor and
   no roof. */
PetscBool MPMUnlikely_gravity_axis(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscReal *g   = look->core->params.gravity;
  const PetscInt   dim = look->core->grid.dim, last = dim - 1, a = look->down;
  const PetscBool  roof = MPMUnlikelyWall(look, 2 * a) != MPM_WALL_free &&
                         MPMUnlikelyWall(look, 2 * a + 1) != MPM_WALL_free;

  if (!look->earth || dim == 1 || look->core->grid.round || a == last || PetscAbsReal(g[a]) < look->g * (1 - 1e-9) ||
      (dim == 3 && a != 0 &&
       !(roof && MPMUnlikelyWall(look, 2 * last) != MPM_WALL_free &&
         MPMUnlikelyWall(look, 2 * last + 1) == MPM_WALL_free)))
    return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) MPMUnlikelyAppend(odd->meant, 6, d == last ? -look->g : 0);
  (void)snprintf(odd->other, MPM_WORDS, "%c", "xyz"[a]);
  return MPMUnlikelyGiven("gravity", NULL, "", odd);
}

PetscBool MPMUnlikely_gravity_two(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscReal *g = look->core->params.gravity;
  PetscInt         n = 0;

  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    n += PetscAbsReal(g[d]) > MPM_BOUND_earth_least && PetscAbsReal(g[d]) < MPM_BOUND_earth_most;
  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    MPMUnlikelyAppend(odd->meant, 3, g[d] / PetscSqrtReal((PetscReal)PetscMax(1, n)));
  MPMUnlikelyWrite(odd->other, look->g);
  return n > 1 && MPMUnlikelyGiven("gravity", NULL, "", odd);
}

PetscBool MPMUnlikely_acceleration_large(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMMaterial *m    = &look->scene->materials[look->scene->bodies[0].material];
  const PetscReal    size = MPMUnlikelyExtent(look, look->scene->bodies[0].material, -1);
  const MPMFormula   f    = MPMUnlikelyFormula(look, look->scene->nloads + 6);

  if (!look->scene->acceleration || look->scene->known) return PETSC_FALSE;
  odd->ratio = MPMUnlikelySize(look, &f) * m->rho * size / MPMUnlikelyModulus(m, PETSC_TRUE);
  (void)snprintf(odd->other, MPM_WORDS, "the modulus of %s", m->name);
  return MPMUnlikelyGiven("acceleration", NULL, "", odd);
}

PetscBool MPMUnlikely_acceleration_g(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMFormula f = MPMUnlikelyFormula(look, look->scene->nloads + 6);

  if (!look->scene->acceleration || look->scene->known || !(look->g > 0)) return PETSC_FALSE;
  odd->ratio = MPMUnlikelySize(look, &f) / look->g;
  MPMUnlikelyWrite(odd->other, look->g);
  return MPMUnlikelyGiven("acceleration", NULL, "", odd);
}

/* Metals and clay that flow in statics, on a basis that lets their volume hardly be kept. */
PetscBool MPMUnlikely_locks(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  if (look->core->grid.dim == 1 || look->core->params.box || MPMBasisIsSpline(look->core->basis) ||
      !MPMUnlikelyStatic(odd))
    return PETSC_FALSE;
  for (PetscInt m = 0; m < look->scene->nmaterials; m++) {
    if (!(look->scene->materials[m].type->traits & MPM_ISOCHORIC)) continue;
    (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->materials[m].name);
  }
  return odd->other[0] && MPMUnlikelyGiven("method_basis", NULL, "", odd);
}

PetscBool MPMUnlikely_tension_start(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscInt dim = look->core->grid.dim;
  char          *at;

  if (look->core->step || look->core->stages.now > 1 || !MPMUnlikelyGiven("initial_stress", NULL, "", odd) ||
      strspn(odd->value, "+-.,0123456789eE \t") != strlen(odd->value))
    return PETSC_FALSE;
  for (PetscInt m = 0; m < look->scene->nmaterials; m++)
    if (!(look->scene->materials[m].type->traits & MPM_LOOSE)) return PETSC_FALSE;
  at = odd->value;
  for (PetscInt d = 0, n = 0; d < dim; d++) /* xx, xy, xz, yy, ...: its trace */
    for (PetscInt e = d; e < dim; e++, n++) {
      odd->ratio += d == e ? strtod(at, &at) : (strtod(at, &at), 0);
      at += strspn(at, ", ");
    }
  return odd->ratio > 0;
}

PetscBool MPMUnlikely_gravity_twice(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscInt dim  = look->core->grid.dim;
  PetscReal      a[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0}, dot = 0, size2 = 0, x[3];
  MPMOdd         gravity;

  if (!look->scene->acceleration || !(look->g > 0) || !MPMUnlikelyGiven("gravity", NULL, "", &gravity))
    return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) x[d] = 0.5 * (look->lowest[d] + look->highest[d]);
  if (MPMExpressionEvaluate(look->scene->acceleration, dim, x, x, 0.3 * look->time->end, a)) return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) {
    dot += a[d] * look->core->params.gravity[d];
    size2 += a[d] * a[d];
  }
  odd->ratio = size2 < 1.02 * look->g * look->g ? dot / (look->g * look->g) : 0;
  (void)snprintf(odd->other, MPM_WORDS, "%.150s", gravity.value);
  return MPMUnlikelyGiven("acceleration", NULL, "", odd);
}

PetscBool MPMUnlikely_gravity_cancelled(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return MPMUnlikely_gravity_twice(look, k, odd);
}

/* A steady -acceleration along a periodic axis, in the mean over all places, where nothing takes its force. */
PetscBool MPMUnlikely_unresisted(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMScene  *scene   = look->scene;
  const MPMGrid   *grid    = &look->core->grid;
  const PetscInt   dim     = grid->dim;
  const MPMFormula f       = {scene->acceleration, dim, -1, "acceleration", NULL, ""};
  PetscReal        mean[3] = {0}, x[3];
  PetscInt         n       = 0, along;

  if (!f.value || scene->nloads || scene->nbodies > 1 || look->core->rigids.n || look->core->stages.n ||
      MPMDampingIsOn(look->core) || !MPMUnlikelySteady(look, &f))
    return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * dim; face++)
    if (MPMWallHas(MPMUnlikelyWall(look, face), MPM_WALL_TANGENT | MPM_WALL_BRAKES | MPM_WALL_MOVES))
      return PETSC_FALSE;
  for (; MPMUnlikelyPlace(dim, look->lowest, look->highest, 8, n, x); n++) {
    PetscReal a[9] = {0};

    if (MPMExpressionEvaluate(scene->acceleration, dim, x, x, 0.5 * look->time->end, a)) return PETSC_FALSE;
    for (PetscInt d = 0; d < dim; d++) mean[d] += a[d];
  }
  for (along = 0; along < dim; along++)
    if (grid->periodic[along] && PetscAbsReal(mean[along]) > 0.1 * n * MPMUnlikelySize(look, &f)) break;
  if (along == dim) return PETSC_FALSE;
  odd->ratio = PetscAbsReal(mean[along]) / n * look->time->end;
  (void)snprintf(odd->other, MPM_WORDS, "%c", "xyz"[along]);
  return odd->ratio > 0 && MPMUnlikelyGiven("acceleration", NULL, "", odd);
}

/* Returns the angle of a wave of which so many degrees may be meant within a time, as in 90*t/0.06), or 0; *end: after it. */
static PetscReal InTime(const char number[], char **end)
{
  const PetscReal angle = strtod(number, end);

  if (*end == number || strncmp(*end, "*t/", 3) || PetscAbsReal(angle) < 45 || angle / 45 != PetscFloorReal(angle / 45))
    return 0;
  number = *end + 3;
  return strtod(number, end) > 0 && **end == ')' ? angle : 0;
}

/* Finds a function of an angle of a plain number in the options, as in tan(20), or of one of such a wave. */
PetscBool MPMUnlikely_angle_in_formula(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  static const char *const functions[] = {"sin(", "cos(", "tan("};
  char                    *text        = NULL, name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN];

  (void)look;
  if (MPMOptionsText(&text)) return PETSC_FALSE;
  for (const char *at = text; at && MPMOptionsNext(&at, name, value);)
    for (size_t f = 0; f < sizeof functions / sizeof functions[0]; f++)
      for (const char *v = value; (v = strstr(v, functions[f])); v++) {
        char       *end;
        const char *number = v + strlen(functions[f]);
        PetscReal   angle  = InTime(number, &end);

        if (angle == 0) angle = strtod(number, &end);
        if (end == number || *end != ')' || (v > value && isalpha((unsigned char)v[-1])) ||
            !(PetscAbsReal(angle) > 6.2831853 || (angle != 0 && angle == PetscFloorReal(angle))))
          continue;
        odd->ratio = PetscAbsReal(angle);
        (void)snprintf(odd->option, MPM_WORDS, "%.*s", MPM_WORDS - 1, name);
        (void)snprintf(odd->value, MPM_WORDS, "%.*s", (int)(end + 1 - v), v);
        (void)snprintf(odd->meant, MPM_WORDS, "%.*s*pi/180)", (int)(end - v), v);
      }
  (void)PetscFree(text);
  return odd->ratio > 0;
}

PetscBool MPMUnlikely_grid_large(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;

  for (PetscInt d = 0; d < grid->dim; d++)
    odd->ratio = PetscMax(odd->ratio, (look->highest[d] - look->lowest[d]) / (grid->upper[d] - grid->lower[d]));
  return MPMUnlikelyGiven("grid_upper", NULL, "", odd);
}

PetscBool MPMUnlikely_cells_long(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;

  for (PetscInt d = 0; d < grid->dim; d++) odd->ratio = PetscMax(odd->ratio, grid->h[d] / MPMGridSmallestH(grid));
  return MPMUnlikelyGiven("grid_cells", NULL, "", odd) || MPMUnlikelyGiven("grid_h", NULL, "", odd);
}

PetscBool MPMUnlikely_dampings(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  (void)snprintf(odd->other, MPM_WORDS, "-damping_kinetic");
  return MPMUnlikelyGiven("damping_time", NULL, "", odd) && look->core->damping.kinetic;
}

PetscBool MPMUnlikely_damping_short(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscReal crosses = MPMUnlikelyExtent(look, -1, -1) / look->c;

  odd->ratio = look->core->damping.time / crosses;
  MPMUnlikelyWrite(odd->meant, 0.3 * crosses);
  return MPMUnlikelyGiven("damping_time", NULL, "", odd);
}

PetscBool MPMUnlikely_damping_long(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscReal length = look->time->end - look->core->stages.began;

  if (!(length > 0)) return PETSC_FALSE;
  odd->ratio = look->core->damping.time / length;
  MPMUnlikelyWrite(odd->meant, 0.3 * MPMUnlikelyExtent(look, -1, -1) / look->c);
  return MPMUnlikelyGiven("damping_time", NULL, "", odd);
}

/* Does a body start with a velocity that damping takes and gravity does not give: any, or one across a gravity, in time? */
static PetscBool IsBraked(const MPMLook *look, PetscInt b)
{
  PetscReal v[9] = {0}, across = 0;
  MPMOdd    odd = {0};

  if (look->scene->bodies[b].source.on || !(look->scene->bodies[b].v2 > 0)) return PETSC_FALSE;
  if (!(look->g > 0) || look->core->damping.kinetic) return PETSC_TRUE;
  if (look->core->damping.time > look->time->end || look->core->stages.now > 1 ||
      !MPMUnlikelyVelocity(look, b, &odd, v))
    return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    if (d != look->down) across = PetscMax(across, PetscAbsReal(v[d]));
  return across > PetscAbsReal(v[look->down]);
}

/* Is a load a blow, which is over before half of the run, and do damping and nothing else act from then on? */
static PetscBool IsBlow(const MPMLook *look, PetscInt l)
{
  enum { TIMES = 1000 };
  const MPMFormula f    = MPMUnlikelyFormula(look, l);
  const PetscReal  end  = look->time->end;
  PetscInt         last = -1;

  if (look->g > 0 || look->scene->nloads > 1 || look->scene->acceleration || look->core->stages.n ||
      look->core->rigids.n || MPMWallsHave(&look->scene->walls, MPM_WALL_MOVES) || look->core->damping.time > 0.3 * end)
    return PETSC_FALSE;
  for (PetscInt j = 0; j <= TIMES; j++)
    if (MPMUnlikelyAt(look, &f, end * j / TIMES) != 0) last = j;
  return last >= 0 && 2 * last < TIMES;
}

PetscBool MPMUnlikely_damping_impact(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  if (!MPMDampingIsOn(look->core)) return PETSC_FALSE;
  for (PetscInt l = 0; l < look->scene->nloads; l++)
    if (IsBlow(look, l))
      (void)snprintf(odd->other, MPM_WORDS, "the motion that the blow -load_%.80s_value gives",
                     look->scene->loads[l].name);
  for (PetscInt b = 0; b < look->scene->nbodies; b++)
    if (IsBraked(look, b))
      (void)snprintf(odd->other, MPM_WORDS, "the velocity with which %.80s starts", look->scene->bodies[b].name);
  return odd->other[0]
             ? MPMUnlikelyGiven(look->core->damping.kinetic ? "damping_kinetic" : "damping_time", NULL, "", odd)
             : PETSC_FALSE;
}

PetscBool MPMUnlikely_energy_plastic(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  if (look->core->energy.on || !(look->monitor->check_energy > 0)) return PETSC_FALSE;
  for (PetscInt m = 0; m < look->scene->nmaterials; m++)
    if (look->scene->materials[m].type->traits & MPM_PLASTIC)
      (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->materials[m].name);
  return MPMUnlikelyGiven("check_energy", NULL, "", odd) && odd->other[0];
}
