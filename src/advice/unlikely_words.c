/* unlikely_words.c - what the functions of the rows of plausible.def share: options that were given, sizes of what is looked
   at. */
#include <strings.h>
#include "advice/unlikely.h"

#define PARTS 200 /* of the run, in which the way of a wall or a rigid body is looked at */

PetscBool MPMUnlikelyGiven(const char group[], const char *name, const char word[], MPMOdd *odd)
{
  char      text[MPM_TEXT_LEN] = "";
  PetscBool given;

  (void)snprintf(odd->option, MPM_WORDS, "-%s%s%s%s", group, name ? "_" : "", name ? name : "", word);
  if (PetscOptionsGetString(NULL, NULL, odd->option, text, sizeof text, &given) || !given) return PETSC_FALSE;
  (void)snprintf(odd->value, MPM_WORDS, "%.*s", MPM_WORDS - 1, text);
  return PETSC_TRUE;
}

PetscBool MPMUnlikelyNumber(const char group[], const char *name, const char word[], MPMOdd *odd, PetscReal *number)
{
  char *end;

  if (!MPMUnlikelyGiven(group, name, word, odd)) return PETSC_FALSE;
  *number = strtod(odd->value, &end);
  return end != odd->value && !*end;
}

PetscBool MPMUnlikelyOver(const char option[], PetscReal measure, MPMOdd *odd)
{
  if (!(measure > 0) || !MPMUnlikelyNumber(option, NULL, "", odd, &odd->ratio)) return PETSC_FALSE;
  odd->ratio /= measure;
  MPMUnlikelyWrite(odd->other, measure);
  return PETSC_TRUE;
}

PetscBool MPMUnlikelyStatic(MPMOdd *odd)
{
  return MPMUnlikelyGiven("method_time", NULL, "", odd) && !strcasecmp(odd->value, "static");
}

PetscBool MPMUnlikelyVelocity(const MPMLook *look, PetscInt k, MPMOdd *odd, PetscReal v[9])
{
  const MPMBody *b = &look->scene->bodies[k];

  if (!MPMUnlikelyGiven("body", b->name, "_velocity", odd) ||
      strspn(odd->value, "+-.,0123456789eE \t") != strlen(odd->value))
    return PETSC_FALSE;
  return !MPMExpressionEvaluate(b->velocity, look->core->grid.dim, look->lower[k], look->lower[k], 0, v);
}

void MPMUnlikelyWrite(char text[MPM_WORDS], PetscReal number)
{
  (void)snprintf(text, MPM_WORDS, "%.3g", (double)number);
}

void MPMUnlikelyThousand(MPMOdd *odd)
{
  char           *after;
  const PetscReal value = strtod(odd->value, &after);

  if (*after)
    (void)snprintf(odd->meant, MPM_WORDS, "1e+03 times as much");
  else
    MPMUnlikelyWrite(odd->meant, 1000 * value);
}

void MPMUnlikelyAppend(char text[MPM_WORDS], int digits, PetscReal number)
{
  const size_t n = strlen(text);

  (void)snprintf(text + n, MPM_WORDS - n, "%s%.*g", n ? "," : "", digits, (double)number);
}

MPMWall MPMUnlikelyWall(const MPMLook *look, PetscInt face)
{
  return look->scene->walls.given[face / 2][face % 2].type;
}

PetscReal MPMUnlikelyBeside(const MPMLook *look, PetscInt k, PetscInt face)
{
  const MPMGrid  *grid  = &look->core->grid;
  const PetscInt  d     = face / 2;
  const PetscReal lower = k < 0 ? look->lowest[d] : look->lower[k][d],
                  upper = k < 0 ? look->highest[d] : look->upper[k][d];

  return (face % 2 ? grid->upper[d] - upper : lower - grid->lower[d]) / grid->h[d];
}

PetscBool MPMUnlikelyPlace(PetscInt dim, const PetscReal lower[], const PetscReal upper[], PetscInt n, PetscInt j,
                           PetscReal x[3])
{
  for (PetscInt d = 0; d < dim; d++, j /= n)
    x[d] = lower[d] + (upper[d] - lower[d]) * ((PetscReal)(j % n) + 0.5) / (PetscReal)n;
  return !j;
}

PetscReal MPMUnlikelyApart(const MPMLook *look, PetscInt d, const PetscReal lower_a[], const PetscReal upper_a[],
                           const PetscReal lower_b[], const PetscReal upper_b[])
{
  return PetscMax(lower_a[d] - upper_b[d], lower_b[d] - upper_a[d]) / look->core->grid.h[d];
}

PetscReal MPMUnlikelyGap(const MPMLook *look, const PetscReal lower_a[], const PetscReal upper_a[],
                         const PetscReal lower_b[], const PetscReal upper_b[])
{
  PetscReal gap = PETSC_MIN_REAL;

  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    gap = PetscMax(gap, MPMUnlikelyApart(look, d, lower_a, upper_a, lower_b, upper_b));
  return gap;
}

PetscReal MPMUnlikelyAdvance(const MPMLook *look, MPMExpression velocity, PetscInt c, PetscReal constant,
                             PetscReal toward, PetscReal *most)
{
  const PetscReal part = (look->time->end - look->core->t) / PARTS, x[3] = {0};
  PetscReal       way = 0;

  *most = 0;
  for (PetscInt j = 0; j < PARTS; j++) {
    PetscReal v[9] = {0};

    if (velocity && MPMExpressionEvaluate(velocity, look->core->grid.dim, x, x, look->core->t + part * (j + 0.5), v)) {
      *most = PETSC_MAX_REAL;
      return 0;
    }
    way += toward * part * (velocity ? v[c] : constant);
    *most = PetscMax(*most, way);
  }
  return way;
}

PetscBool MPMUnlikelyStarts(const MPMLook *look)
{
  return !(look->core->step || look->core->stages.now > 1 || look->scene->known);
}

PetscBool MPMUnlikelyFed(const MPMLook *look, PetscInt k)
{
  const MPMBody *body = look->scene->bodies;

  for (PetscInt s = 0; s < look->scene->nbodies && !body[k].source.on; s++)
    if (body[s].source.on && body[s].material == body[k].material) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscReal MPMUnlikelyExtent(const MPMLook *look, PetscInt m, PetscInt d)
{
  PetscReal most = 0;

  for (PetscInt e = 0; e < look->core->grid.dim; e++)
    for (PetscInt b = 0; b < look->scene->nbodies; b++)
      if ((m < 0 || look->scene->bodies[b].material == m) && (d < 0 || d == e))
        most = PetscMax(most, look->upper[b][e] - look->lower[b][e]);
  return most;
}

PetscReal MPMUnlikelyModulus(const MPMMaterial *m, PetscBool young)
{
  if (m->type->traits & MPM_FLUID) return m->K;
  return young ? m->mu * (3 * m->lambda + 2 * m->mu) / (m->lambda + m->mu) : m->lambda + 2 * m->mu;
}

PetscReal MPMUnlikelyCohesion(const MPMMaterial *m)
{
  PetscReal cohesion = 0;
  MPMOdd    odd;

  return MPMUnlikelyNumber("material", m->name, "_cohesion", &odd, &cohesion) ? cohesion : 0;
}

PetscBool MPMUnlikelyTonnes(const MPMMaterial *m)
{
  return m->rho > 1e-11 && m->rho < 1e-7 && MPMUnlikelyModulus(m, PETSC_FALSE) > 1e9 * m->rho;
}

PetscReal MPMUnlikelyWeight(const MPMLook *look, PetscInt k)
{
  PetscReal weight = 0;

  if (MPMUnlikelyGravity(look->core, look->scene)) return 0;
  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    weight += look->scene->materials[k].rho * PetscAbsReal(look->core->params.gravity[d]) *
              MPMUnlikelyExtent(look, k, d);
  return weight;
}

PetscReal MPMUnlikelyEnd(const MPMLook *look)
{
  return look->core->stages.n ? look->core->stages.end : look->time->end;
}

/* Of gravity in a wrong unit what is measured by rho g H says nothing. */
PetscBool MPMUnlikely_gravity_small_units(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscReal foot = 0.3048, inch = 0.0254,
                  part = look->g > 5000                     ? look->g / 1000
                         : look->g > 500                    ? look->g / 100
                         : look->g > 385 && look->g < 387   ? look->g * inch
                         : look->g > 32.1 && look->g < 32.3 ? look->g * foot
                         : look->g < 0.1                    ? look->g * 1000
                                                            : 0;

  if (part < MPM_BOUND_earth_least || part > MPM_BOUND_earth_exact) return PETSC_FALSE;
  for (PetscInt m = 0; m < look->scene->nmaterials; m++)
    if (look->scene->materials[m].rho < MPM_BOUND_si_density) return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    MPMUnlikelyAppend(odd->meant, 6, 0.01 * PetscFloorReal(100 * look->core->params.gravity[d] * part / look->g + 0.5));
  return MPMUnlikelyGiven("gravity", NULL, "", odd);
}

PetscBool MPMUnlikely_gravity_mm(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  if (!look->earth || !MPMUnlikelyTonnes(&look->scene->materials[0])) return PETSC_FALSE;
  (void)snprintf(odd->other, MPM_WORDS, "t/mm^3");
  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    MPMUnlikelyAppend(odd->meant, 6, 1000 * look->core->params.gravity[d]);
  return MPMUnlikelyGiven("gravity", NULL, "", odd);
}

PetscBool MPMUnlikelyGravity(const MPMCore *core, const MPMScene *scene)
{
  MPMLook look = {.core = core, .scene = scene};
  MPMOdd  odd = {0}, mm = {0};

  for (PetscInt d = 0; d < core->grid.dim; d++) look.g += PetscSqr(core->params.gravity[d]);
  look.g     = PetscSqrtReal(look.g);
  look.earth = look.g > MPM_BOUND_earth_least && look.g < MPM_BOUND_earth_exact;
  return MPMUnlikely_gravity_small_units(&look, 0, &odd) || MPMUnlikely_gravity_mm(&look, 0, &mm);
}
