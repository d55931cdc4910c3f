/* unlikely_run.c - the rows of plausible.def of faces, rigid bodies, probes and the run. */
#include <ctype.h>
#include <strings.h>
#include "advice/unlikely.h"

/* --- Faces and rigid bodies --------------------------------------------------------------------------------------- */

/* Writes the fastest wave of a scene. */
static void WriteWave(const MPMLook *look, MPMOdd *odd)
{
  (void)snprintf(odd->other, MPM_WORDS, "%.3g m/s", (double)look->c);
}

/* Sets the largest speed of the wall of a face, m/s. */
static PetscBool WallSpeed(const MPMLook *look, PetscInt k, MPMOdd *odd, PetscReal *speed)
{
  const MPMFace *f      = &look->scene->walls.given[k / 2][k % 2];
  const PetscReal x[3]  = {0};
  PetscReal       size2 = 0;

  if (!MPMWallHas(f->type, MPM_WALL_MOVES)) return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) size2 += f->velocity[d] * f->velocity[d];
  *speed = PetscMax(PetscSqrtReal(size2),
                    MPMUnlikelySize(look, look->scene->wall_velocity[k], look->scene->wall_along[k] ? 1 : look->core->grid.dim, x));
  WriteWave(look, odd);
  return MPMUnlikelyGiven("bc", MPMFaceNames[k], "_velocity", odd);
}

PetscBool MPMUnlikely_face_fast(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal speed = 0;

  if (!WallSpeed(look, k, odd, &speed)) return PETSC_FALSE;
  odd->ratio = speed / look->c;
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_face_idle(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal speed = 0;

  if (!WallSpeed(look, k, odd, &speed) || !(speed > 0) || !(look->time->end > 0)) return PETSC_FALSE;
  odd->ratio = speed * look->time->end / MPMGridSmallestH(&look->core->grid);
  return PETSC_TRUE;
}

/* Returns the rigid body k among the shapes, or NULL if that is none. */
static const MPMBody *RigidBody(const MPMLook *look, PetscInt k)
{
  const MPMBody *b = &look->scene->bodies[look->scene->nbodies + k];

  return b->rigid == MPM_RIGID_NONE ? NULL : b;
}

PetscBool MPMUnlikely_rigid_light(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody     *b = RigidBody(look, k);
  const MPMMaterial *m = look->scene->materials;

  if (!b || !(b->rho > 0)) return PETSC_FALSE;
  for (PetscInt j = 0; j < look->scene->nmaterials; j++)
    if (look->scene->materials[j].rho < m->rho) m = &look->scene->materials[j];
  odd->ratio = b->rho / m->rho;
  (void)snprintf(odd->other, MPM_WORDS, "%s", m->name);
  MPMUnlikelyWrite(odd->meant, 1000 * b->rho);
  return MPMUnlikelyGiven("body", b->name, "_rho", odd);
}

PetscBool MPMUnlikely_rigid_fast(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody  *b    = RigidBody(look, k);
  const PetscReal x[3] = {0};

  if (!b || !MPMUnlikelyGiven("body", b->name, "_velocity", odd)) return PETSC_FALSE;
  odd->ratio = MPMUnlikelySize(look, b->velocity, look->core->grid.dim, x) / look->c;
  WriteWave(look, odd);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_rigid_spin(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody  *b    = RigidBody(look, k);
  const PetscReal x[3] = {0};
  PetscReal       lower[3], upper[3], size = 0, spin;

  if (!b || !MPMUnlikelyGiven("body", b->name, "_spin", odd)) return PETSC_FALSE;
  MPMRegionBounds(&b->region, look->core->grid.dim, lower, upper);
  for (PetscInt d = 0; d < look->core->grid.dim; d++) size = PetscMax(size, 0.5 * (upper[d] - lower[d]));
  spin       = MPMUnlikelySize(look, b->spin, look->core->grid.dim == 3 ? 3 : 1, x);
  odd->ratio = spin * size / look->c;
  WriteWave(look, odd);
  MPMUnlikelyWrite(odd->meant, spin * PETSC_PI / 30);
  return odd->ratio < PETSC_MAX_REAL ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_rigid_away(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody  *b    = RigidBody(look, k);
  const PetscReal x[3] = {0};
  const PetscInt  dim  = look->core->grid.dim;
  PetscReal       v[9] = {0}, lower[3], upper[3];

  if (!b || b->rigid != MPM_RIGID_MOVING || b->spin || b->tied || !MPMUnlikelyGiven("body", b->name, "_velocity", odd) ||
      strspn(odd->value, "+-.,0123456789eE \t") != strlen(odd->value) || MPMExpressionEvaluate(b->velocity, dim, x, x, 0, v))
    return PETSC_FALSE;
  MPMRegionBounds(&b->region, dim, lower, upper);
  odd->ratio = 1;
  for (PetscInt d = 0; d < dim; d++) { /* matter that lies beside it, not behind it, may be what it drags */
    const PetscReal gap = v[d] > 0 ? lower[d] - look->highest[d] : v[d] < 0 ? look->lowest[d] - upper[d] : PETSC_MAX_REAL;

    if (v[d] != 0 && !(gap > 0.1 * look->core->grid.h[d])) return PETSC_FALSE;
  }
  return v[0] != 0 || v[1] != 0 || v[2] != 0 ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_rigid_wall_mu(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = RigidBody(look, k);
  PetscReal      mu;

  if (!b || b->rigid != MPM_RIGID_FREE || !MPMUnlikelyNumber("body", b->name, "_mu", odd, &mu)) return PETSC_FALSE;
  odd->ratio = 0;
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++) {
    const MPMFace *wall = &look->scene->walls.given[face / 2][face % 2];

    if (wall->type != MPM_WALL_friction || !(PetscAbsReal(wall->mu - mu) > odd->ratio)) continue;
    odd->ratio = PetscAbsReal(wall->mu - mu);
    (void)snprintf(odd->other, sizeof odd->other, "-bc_%.8s_mu %g", MPMFaceNames[face], (double)wall->mu);
  }
  return PETSC_TRUE;
}

/* --- Probes ------------------------------------------------------------------------------------------------------- */

PetscBool MPMUnlikely_probe_away(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid  *grid = &look->core->grid;
  const MPMProbe *p    = NULL;

  for (PetscInt j = 0; j < look->monitor->measures.nprobes; j++)
    if (!strcmp(look->monitor->measures.probe[j].name, look->scene->probes[k])) p = &look->monitor->measures.probe[j];
  if (!p || !p->stays) return PETSC_FALSE;
  odd->ratio = PETSC_MAX_REAL;
  for (PetscInt b = 0; b < look->scene->nbodies; b++) {
    const MPMMaterial *m   = &look->scene->materials[look->scene->bodies[b].material];
    PetscReal          far = 0;
    PetscBool          may = PetscSqrtReal(look->scene->bodies[b].v2) * look->time->end > grid->h[0] ? PETSC_TRUE : PETSC_FALSE;

    for (PetscInt d = 0; d < grid->dim; d++) {
      const PetscReal out = PetscMax(look->lower[b][d] - p->x[d], p->x[d] - look->upper[b][d]);

      far = PetscMax(far, out / grid->h[d]);
      /* matter comes to what is below it; loose matter runs as far as it is high, water anywhere */
      if (out > 0 && look->core->params.gravity[d] * (p->x[d] - look->lower[b][d]) > 0) may = PETSC_TRUE;
      if (m->type->traits & MPM_FLUID && p->x[look->down] < look->upper[b][look->down]) may = PETSC_TRUE;
      if (m->type->traits & MPM_LOOSE && d != look->down && look->core->params.gravity[look->down] != 0 &&
          p->x[look->down] < look->upper[b][look->down] &&
          out < 3 * (look->upper[b][look->down] - look->lower[b][look->down]))
        may = out > 0 ? PETSC_TRUE : may;
    }
    odd->ratio = PetscMin(odd->ratio, may ? 0 : far);
  }
  return MPMUnlikelyGiven("probe", p->name, "_at", odd);
}

/* --- The run ------------------------------------------------------------------------------------------------------ */

PetscBool MPMUnlikely_nothing_moves(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;

  (void)k;
  odd->ratio = 1;
  if (look->g > 0 || scene->forced || scene->known || scene->initial || look->core->step) return PETSC_FALSE;
  for (PetscInt b = 0; b < scene->nbodies; b++)
    if (scene->bodies[b].v2 > 0 || scene->bodies[b].points) return PETSC_FALSE;
  for (PetscInt b = scene->nbodies; b < scene->nbodies + scene->nshapes; b++)
    if (scene->bodies[b].rigid == MPM_RIGID_MOVING || scene->bodies[b].rigid == MPM_RIGID_FREE) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++)
    if (MPMWallHas(scene->walls.given[face / 2][face % 2].type, MPM_WALL_MOVES)) return PETSC_FALSE;
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_gravity_axis(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscReal *g   = look->core->params.gravity;
  const PetscInt   dim = look->core->grid.dim;

  odd->ratio = 1;
  if (!look->earth || dim == 1 || look->core->grid.round || PetscAbsReal(g[0]) < look->g * (1 - 1e-9))
    return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) (void)snprintf(odd->meant + strlen(odd->meant), MPM_WORDS - strlen(odd->meant), "%s%g", d ? "," : "", d == dim - 1 ? -(double)look->g : 0.);
  return MPMUnlikelyGiven("gravity", NULL, "", odd) && !k ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_gravity_small_units(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscReal part = look->g > 5000 ? look->g / 1000 : look->g > 1 ? look->g / 100 : look->g * 1000;

  if (part < MPM_BOUND_earth_least || part > MPM_BOUND_earth_most) return PETSC_FALSE;
  for (PetscInt m = 0; m < look->scene->nmaterials; m++)
    if (look->scene->materials[m].rho < MPM_BOUND_si_density) return PETSC_FALSE;
  odd->ratio = 1;
  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    (void)snprintf(odd->meant + strlen(odd->meant), MPM_WORDS - strlen(odd->meant), "%s%g", d ? "," : "",
                   (double)(look->core->params.gravity[d] * part / look->g));
  return MPMUnlikelyGiven("gravity", NULL, "", odd) && !k ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_falls(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid  *grid = &look->core->grid;
  const PetscReal g    = look->core->params.gravity[look->down];
  const PetscInt  face = 2 * look->down + (g > 0);
  PetscReal       gap;

  if (k || !(look->g > 0) || look->core->rigids.n || look->scene->forced || look->scene->known) return PETSC_FALSE;
  if (MPMUnlikelyGiven("particles_leave", NULL, "", odd) && !strcasecmp(odd->value, "delete")) return PETSC_FALSE;
  for (PetscInt j = 0; j < 2 * grid->dim; j++)
    if (look->scene->walls.given[j / 2][j % 2].type != MPM_WALL_free) return PETSC_FALSE; /* others are told of */
  gap        = g > 0 ? grid->upper[look->down] - look->highest[look->down] : look->lowest[look->down] - grid->lower[look->down];
  odd->ratio = 0.5 * PetscAbsReal(g) * look->time->end * look->time->end / PetscMax(gap, 1e-3 * grid->h[look->down]);
  for (PetscInt b = 0; b < look->scene->nbodies; b++)
    if (look->scene->bodies[b].v2 > 0) odd->ratio = 0;
  (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[0].name);
  (void)snprintf(odd->meant, MPM_WORDS, "-bc_%s_type", MPMFaceNames[face]);
  return MPMUnlikelyGiven("gravity", NULL, "", odd);
}

PetscBool MPMUnlikely_waves_many(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  if (look->core->implicit || look->seconds > 86400) return PETSC_FALSE; /* which is told */
  odd->ratio = look->time->end * look->c / MPMUnlikelyExtent(look, -1, -1);
  for (PetscInt m = 0; m < look->scene->nmaterials && !odd->other[0]; m++)
    if (MPMUnlikelyModulus(&look->scene->materials[m], PETSC_FALSE) >= 0.99 * look->c * look->c * look->scene->materials[m].rho)
      (void)snprintf(odd->other, MPM_WORDS, "of %s", look->scene->materials[m].name);
  return MPMUnlikelyGiven("time_end", NULL, "", odd);
}

PetscBool MPMUnlikely_gravity_twice(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscInt dim = look->core->grid.dim;
  PetscReal      a[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0}, dot = 0, size2 = 0, x[3];
  MPMOdd         gravity;

  if (!look->scene->acceleration || !(look->g > 0) || !MPMUnlikelyGiven("gravity", NULL, "", &gravity)) return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) x[d] = 0.5 * (look->lowest[d] + look->highest[d]);
  if (MPMExpressionEvaluate(look->scene->acceleration, dim, x, x, 0.3 * look->time->end, a)) return PETSC_FALSE;
  for (PetscInt d = 0; d < dim; d++) {
    dot += a[d] * look->core->params.gravity[d];
    size2 += a[d] * a[d];
  }
  odd->ratio = size2 < 1.02 * look->g * look->g ? dot / (look->g * look->g) : 0;
  (void)snprintf(odd->other, MPM_WORDS, "%.150s", gravity.value);
  return MPMUnlikelyGiven("acceleration", NULL, "", odd) && !k ? PETSC_TRUE : PETSC_FALSE;
}

/* Finds a function of an angle of a plain number in the options, as in tan(20). */
PetscBool MPMUnlikely_angle_in_formula(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  static const char *const functions[] = {"sin(", "cos(", "tan("};
  char                    *text        = NULL, name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN];

  (void)look;
  if (k || MPMOptionsText(&text)) return PETSC_FALSE;
  for (const char *at = text; at && MPMOptionsNext(&at, name, value);)
    for (size_t f = 0; f < sizeof functions / sizeof functions[0]; f++)
      for (const char *v = value; (v = strstr(v, functions[f])); v++) {
        char           *end;
        const char     *number = v + strlen(functions[f]);
        const PetscReal angle  = strtod(number, &end);

        if (end == number || *end != ')' || (v > value && isalpha((unsigned char)v[-1])) || !(PetscAbsReal(angle) > 6.2831853)) continue;
        odd->ratio = PetscAbsReal(angle);
        (void)snprintf(odd->option, MPM_WORDS, "%.*s", MPM_WORDS - 1, name);
        (void)snprintf(odd->value, MPM_WORDS, "%.*s", (int)(end + 1 - v), v);
        (void)snprintf(odd->meant, MPM_WORDS, "%.*s*pi/180)", (int)(end - v), v);
      }
  (void)PetscFree(text);
  return odd->ratio > 0 ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_grid_large(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;

  (void)k;
  for (PetscInt d = 0; d < grid->dim; d++)
    odd->ratio = PetscMax(odd->ratio, (look->highest[d] - look->lowest[d]) / (grid->upper[d] - grid->lower[d]));
  return MPMUnlikelyGiven("grid_upper", NULL, "", odd);
}

PetscBool MPMUnlikely_cells_long(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;

  (void)k;
  for (PetscInt d = 0; d < grid->dim; d++) odd->ratio = PetscMax(odd->ratio, grid->h[d] / MPMGridSmallestH(grid));
  return MPMUnlikelyGiven("grid_cells", NULL, "", odd) || MPMUnlikelyGiven("grid_h", NULL, "", odd) ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_dampings(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  odd->ratio = 1;
  (void)snprintf(odd->other, MPM_WORDS, "-damping_kinetic");
  return MPMUnlikelyGiven("damping_time", NULL, "", odd) && look->core->damping.kinetic ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_damping_short(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscReal crosses = MPMUnlikelyExtent(look, -1, -1) / look->c;

  (void)k;
  odd->ratio = look->core->damping.time / crosses;
  MPMUnlikelyWrite(odd->meant, 0.3 * crosses);
  return MPMUnlikelyGiven("damping_time", NULL, "", odd);
}

PetscBool MPMUnlikely_damping_impact(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  odd->ratio = 1;
  if (!MPMDampingIsOn(look->core) || look->g > 0) return PETSC_FALSE;
  for (PetscInt b = 0; b < look->scene->nbodies; b++)
    if (look->scene->bodies[b].v2 > 0) {
      (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[b].name);
      return MPMUnlikelyGiven(look->core->damping.kinetic ? "damping_kinetic" : "damping_time", NULL, "", odd);
    }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_end_zero(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  odd->ratio = look->time->end;
  return MPMUnlikelyGiven("time_end", NULL, "", odd) && !look->core->implicit ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_end_late(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  odd->ratio = look->seconds < MPM_BOUND_year ? look->seconds : 0;
  MPMTimeWords(look->seconds, odd->other);
  MPMUnlikelyWrite(odd->meant, look->time->end * look->c / MPMUnlikelyExtent(look, -1, -1));
  return MPMUnlikelyGiven("time_end", NULL, "", odd) && !look->core->implicit ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_output_none(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  static const char *const options[] = {"output_every", "history_every"};

  (void)k;
  if (look->core->implicit || !(look->time->end > 0)) return PETSC_FALSE;
  for (size_t j = 0; j < sizeof options / sizeof options[0]; j++) {
    PetscReal every;

    if (!MPMUnlikelyNumber(options[j], NULL, "", odd, &every) || every <= look->time->end) continue;
    odd->ratio = every / look->time->end;
    MPMUnlikelyWrite(odd->other, look->time->end);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_output_fine(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal every;

  (void)k;
  if (look->core->implicit || !MPMUnlikelyNumber("output_every", NULL, "", odd, &every) || !(every > 0) || !(look->dt > 0)) return PETSC_FALSE;
  odd->ratio = every / look->dt;
  MPMUnlikelyWrite(odd->other, look->dt);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_output_many(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal every;

  (void)k;
  if (look->core->implicit || !MPMUnlikelyNumber("output_every", NULL, "", odd, &every) || !(look->dt > 0)) return PETSC_FALSE;
  odd->ratio = look->time->end / PetscMax(every, look->dt);
  MPMUnlikelyWrite(odd->meant, look->time->end / 100);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_energy_plastic(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  odd->ratio = look->monitor->check_energy;
  if (look->core->energy.on) return PETSC_FALSE;
  for (PetscInt m = 0; m < look->scene->nmaterials; m++)
    if (look->scene->materials[m].type->traits & MPM_PLASTIC)
      (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->materials[m].name);
  return MPMUnlikelyGiven("check_energy", NULL, "", odd) && odd->other[0] ? PETSC_TRUE : PETSC_FALSE;
}
