/* unlikely_formulas.c - the rows of plausible.def of formulas of time: loads, walls, -acceleration, rigid bodies. They
   are looked at all over the body that they act on, at times within the run and far beyond it. */
#include <ctype.h>
#include <strings.h>
#include "advice/unlikely.h"

#define STEPS 64 /* time steps for which a formula is looked at */
#define TIMES 64 /* times in a part of the run */

/* Places on each axis of a body: a strip of a thirtieth of the ground has one of them. */
static const PetscInt places_of[] = {0, 33, 33, 9};

PetscInt MPMUnlikelyFormulas(const MPMLook *look)
{
  return look->scene->nloads + 7 + 2 * look->scene->nshapes;
}

MPMFormula MPMUnlikelyFormula(const MPMLook *look, PetscInt k)
{
  const MPMScene *scene = look->scene;
  const PetscInt  dim = look->core->grid.dim, face = k - scene->nloads, rigid = face - 7;

  if (face < 0)
    return (MPMFormula){
        scene->loads[k].value, scene->loads[k].nc, scene->loads[k].body, "load", scene->loads[k].name, "_value"};
  if (face < 6)
    return (MPMFormula){
        scene->wall_velocity[face], scene->wall_along[face] ? 1 : dim, -1, "bc", MPMFaceNames[face], "_velocity"};
  if (face == 6) return (MPMFormula){scene->acceleration, dim, -1, "acceleration", NULL, ""};
  if (scene->bodies[scene->nbodies + rigid / 2].rigid != MPM_RIGID_MOVING)
    return (MPMFormula){NULL, 0, -1, "", NULL, ""};
  if (rigid % 2)
    return (MPMFormula){scene->bodies[scene->nbodies + rigid / 2].spin, dim == 3 ? 3 : 1, -1, "body",
                        scene->bodies[scene->nbodies + rigid / 2].name, "_spin"};
  return (MPMFormula){scene->bodies[scene->nbodies + rigid / 2].velocity, dim,        -1, "body",
                      scene->bodies[scene->nbodies + rigid / 2].name,     "_velocity"};
}

/* Returns the largest size of a formula at n times after t, every so many s, anywhere; or below 0 where it is not
   finite. *least: the smallest of those at a time. */
static PetscReal Most(const MPMLook *look, const MPMFormula *f, PetscReal t, PetscReal every, PetscInt n,
                      PetscReal *least)
{
  const PetscInt   dim = look->core->grid.dim, places = places_of[dim];
  const PetscReal *lower = f->body < 0 ? look->lowest : look->lower[f->body],
                  *upper = f->body < 0 ? look->highest : look->upper[f->body];
  PetscReal most = 0, x[3] = {0};

  *least = PETSC_MAX_REAL;
  for (PetscInt k = 0; k < n; k++) {
    PetscReal now = 0;

    for (PetscInt j = 0; MPMUnlikelyPlace(dim, lower, upper, places, j, x); j++) {
      PetscReal value[9] = {0}, size2 = 0;

      if (MPMExpressionEvaluate(f->value, dim, x, x, t + every * (PetscReal)k, value)) return -1;
      for (PetscInt c = 0; c < f->nc; c++) size2 += value[c] * value[c];
      if (!(size2 < PETSC_MAX_REAL)) return -1;
      now = PetscMax(now, PetscSqrtReal(size2));
    }
    most   = PetscMax(most, now);
    *least = PetscMin(*least, now);
  }
  return most;
}

PetscReal MPMUnlikelySize(const MPMLook *look, const MPMFormula *f)
{
  PetscReal least;

  return f->value ? PetscMax(0, Most(look, f, look->core->stages.began,
                                     (look->time->end - look->core->stages.began) / 16, 17, &least))
                  : 0;
}

PetscBool MPMUnlikely_rest_early(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscReal every = look->time->end / TIMES;

  if (!MPMUnlikelyGiven("time_rest", NULL, "", odd) || !(strtod(odd->value, NULL) > 0) || look->core->stages.n)
    return PETSC_FALSE;
  for (PetscInt l = 0; l < look->scene->nloads; l++) {
    const MPMFormula f = MPMUnlikelyFormula(look, l);
    PetscReal        least;
    PetscInt         j = 0;

    while (j < TIMES && Most(look, &f, every * (PetscReal)j, 0, 1, &least) == 0) j++;
    if (j < TIMES / 16 || j == TIMES) continue; /* it acts soon, or never, which another note says */
    odd->ratio = every * (PetscReal)j;
    (void)snprintf(odd->other, MPM_WORDS, "-load_%s_value", f.name);
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikelySteady(const MPMLook *look, const MPMFormula *f)
{
  PetscReal       least;
  const PetscReal most = Most(look, f, 0.01 * look->time->end, 0.99 * look->time->end / TIMES, TIMES + 1, &least);

  return most > 0 && least > (1 - 1e-9) * most;
}

PetscBool MPMUnlikelyChanges(const MPMLook *look, PetscInt k)
{
  const MPMFormula f = MPMUnlikelyFormula(look, k);
  MPMOdd           odd;
  const char      *at;

  if (!f.value || !MPMUnlikelyGiven(f.group, f.name, f.word, &odd)) return PETSC_FALSE;
  at = strchr(odd.value, 't');
  while (at && (isalpha((unsigned char)at[1]) || (at > odd.value && isalpha((unsigned char)at[-1]))))
    at = strchr(at + 1, 't');
  return at || MPMExpressionTables(f.value) > 0;
}

/* Returns formula k, where it is one of t that was given and the run lasts; writes what was given. */
static MPMFormula Given(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  MPMFormula f = MPMUnlikelyFormula(look, k);

  if (!(look->time->end > look->core->t) || !MPMUnlikelyChanges(look, k) ||
      !MPMUnlikelyGiven(f.group, f.name, f.word, odd))
    f.value = NULL;
  return f;
}

/* Reads a product of numbers and pi up to its parenthesis; returns 0 for other texts. */
static PetscReal Product(const char *at)
{
  PetscReal product = 1;
  PetscBool pi      = PETSC_FALSE;

  for (char op = '*'; op != ')'; op = *at++) {
    char     *end    = (char *)at + strspn(at, " ");
    PetscReal factor = PETSC_PI;

    if (!strncasecmp(end, "pi", 2))
      pi = PETSC_TRUE, end += 2;
    else if (isdigit((unsigned char)*end) || *end == '.')
      factor = strtod(end, &end);
    else
      return 0;
    product = op == '/' ? product / factor : product * factor;
    at      = end + strspn(end, " ");
    if (!*at || !strchr("*/)", *at)) return 0;
  }
  return pi ? product : 0;
}

/* A wave without t: the sine or cosine of turns, 2*pi*<frequency>. */
PetscBool MPMUnlikely_formula_still(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMFormula f = MPMUnlikelyFormula(look, k);

  if (!f.value || MPMUnlikelyChanges(look, k) || !MPMUnlikelyGiven(f.group, f.name, f.word, odd)) return PETSC_FALSE;
  for (const char *at = odd->value; (at = strpbrk(at, "scSC")); at++) {
    if (strncasecmp(at, "sin(", 4) && strncasecmp(at, "cos(", 4)) continue;
    if (!(Product(at + 4) > odd->ratio)) continue;
    odd->ratio = Product(at + 4);
    (void)snprintf(odd->other, MPM_WORDS, "%.*s", (int)(strchr(at, ')') + 1 - at), at);
  }
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_formula_zero(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMFormula f    = MPMUnlikelyFormula(look, k);
  const PetscInt   face = k - look->scene->nloads;
  const PetscBool  wall = face >= 0 && face < 2 * look->core->grid.dim &&
                         MPMWallHas(MPMUnlikelyWall(look, face), MPM_WALL_MOVES) &&
                         look->scene->walls.place[face] == 0; /* that of a constant velocity has no formula */
  PetscReal least;
  MPMOdd    spin;

  if ((!f.value && !wall) || face < 0 || look->core->stages.n || !(look->time->end > 0)) return PETSC_FALSE;
  if (f.name && MPMUnlikelyGiven("body", f.name, !strcmp(f.word, "_spin") ? "_velocity" : "_spin", &spin))
    return PETSC_FALSE;
  odd->ratio = f.value ? Most(look, &f, 0, look->time->end / TIMES, TIMES, &least) : 0;
  for (PetscInt d = 0; d < 3 && !f.value; d++)
    odd->ratio += PetscAbsReal(look->scene->walls.given[face / 2][face % 2].velocity[d]);
  (void)snprintf(odd->other, MPM_WORDS, "%s",
                 !strcmp(f.group, "bc")
                     ? (MPMUnlikelyWall(look, face) == MPM_WALL_piston ? "the wall does not move: write slip"
                                                                       : "the wall does not move: write fixed")
                 : f.name ? "the body does not move: write -body_<b>_rigid fixed"
                          : "leave it out");
  return odd->ratio == 0 && MPMUnlikelyGiven(f.group, f.name, f.word, odd);
}

PetscBool MPMUnlikely_table_long(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMFormula f    = Given(look, k, odd);
  const PetscReal  last = MPMExpressionTables(f.value), end = MPMUnlikelyEnd(look);

  MPMUnlikelyWrite(odd->value, last);
  MPMUnlikelyWrite(odd->other, end);
  odd->ratio = last / end;
  return end > 0;
}

PetscBool MPMUnlikely_formula_fast(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMFormula f    = Given(look, k, odd);
  const PetscReal  dt   = look->core->implicit ? look->time->fixed : look->dt;
  PetscReal        x[3] = {0}, was[3] = {0}, most = 0, change[STEPS];
  PetscInt         n = 0;

  if (!f.value || !(dt > 0)) return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    x[d] = 0.5 * (f.body < 0 ? look->lowest[d] + look->highest[d] : look->lower[f.body][d] + look->upper[f.body][d]);
  for (PetscInt j = 0; j <= STEPS; j++) { /* at places in the steps that no period fits */
    const PetscReal part = 0.618 * (PetscReal)j,
                    t    = 0.3 * look->time->end + dt * ((PetscReal)j + 0.5 * (part - PetscFloorReal(part)));
    PetscReal value[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0}, size2 = 0, moved2 = 0;

    if (MPMExpressionEvaluate(f.value, look->core->grid.dim, x, x, t, value)) return PETSC_FALSE;
    for (PetscInt c = 0; c < f.nc; c++) {
      size2 += value[c] * value[c];
      moved2 += PetscSqr(value[c] - was[c]);
      was[c] = value[c];
    }
    most = PetscMax(most, PetscSqrtReal(size2));
    if (j) change[j - 1] = PetscSqrtReal(moved2);
  }
  for (PetscInt j = 0; j < STEPS; j++) n += change[j] > 0.5 * most;
  odd->ratio = (PetscReal)n / STEPS;
  MPMUnlikelyWrite(odd->other, dt);
  return PETSC_TRUE;
}

/* A formula with a bound, as of a ramp or a wave, that is far from it until the end of the run. */
PetscBool MPMUnlikely_formula_slow(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMFormula f   = Given(look, k, odd);
  const PetscReal  end = MPMUnlikelyEnd(look);
  PetscReal        now, later, last, least;

  if (!f.value) return PETSC_FALSE;
  now   = Most(look, &f, 0, end / TIMES, TIMES + 1, &least);
  later = Most(look, &f, end, 27182.8 * end, TIMES, &least); /* until a million times as late */
  last  = Most(look, &f, end, 26180340 * end, TIMES, &least);
  if (!(now >= 0 && later > 0 && last > 0 && last < 1.1 * later)) return PETSC_FALSE;
  odd->ratio = now / last;
  MPMUnlikelyWrite(odd->other, end);
  return PETSC_TRUE;
}

/* A formula of t that changes until the end of the run, but at no place by as much as one sees: over its size. */
PetscBool MPMUnlikely_formula_flat(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMFormula f   = Given(look, k, odd);
  const PetscInt   dim = look->core->grid.dim;
  const PetscReal  end = MPMUnlikelyEnd(look), *lower = f.body < 0 ? look->lowest : look->lower[f.body],
                  *upper = f.body < 0 ? look->highest : look->upper[f.body];
  PetscReal x[3] = {0}, most = 0, change = 0;

  if (!f.value || look->core->t > 0 || look->core->stages.now > 1) return PETSC_FALSE;
  for (PetscInt j = 0; MPMUnlikelyPlace(dim, lower, upper, places_of[dim], j, x); j++) {
    PetscReal first[9] = {0};

    for (PetscInt i = 0; i <= TIMES; i++) { /* at times that no period fits */
      const PetscReal part     = (PetscReal)i / TIMES;
      PetscReal       value[9] = {0};

      if (MPMExpressionEvaluate(f.value, dim, x, x, end * part * PetscSqrtReal(part), value)) return PETSC_FALSE;
      for (PetscInt c = 0; c < f.nc; c++) {
        if (!i) first[c] = value[c];
        most   = PetscMax(most, PetscAbsReal(value[c]));
        change = PetscMax(change, PetscAbsReal(value[c] - first[c]));
      }
    }
  }
  odd->ratio = change / most;
  MPMUnlikelyWrite(odd->other, end);
  return most > 0 && change > 1e-12 * most;
}

/* A formula that grows within the first step alone. */
PetscBool MPMUnlikely_formula_step(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMFormula f  = Given(look, k, odd);
  const PetscReal  dt = look->core->implicit ? look->time->fixed : look->dt, end = look->time->end;
  PetscReal        start, least, most;

  if (!f.value || strpbrk(odd->value, "<>?") || look->core->t > 0 || look->core->stages.now > 1 || !(dt > 0) ||
      end < 10 * dt)
    return PETSC_FALSE;
  start = Most(look, &f, 0, 0, 1, &least);
  most  = Most(look, &f, dt, (end - dt) / TIMES, TIMES + 1, &least);
  MPMUnlikelyWrite(odd->other, dt);
  return most > 0 && least > (1 - 1e-9) * most && start >= 0 && start < 0.5 * most;
}

/* A formula of a later stage that does not change in it, but did before it, or would in as long a time from t = 0. */
PetscBool MPMUnlikely_formula_past(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMFormula f     = Given(look, k, odd);
  const PetscReal  began = look->core->stages.began, end = look->time->end;
  PetscReal        least, most, before, was, early, first;
  char             stage[MPM_WORDS];
  MPMOdd           own;

  if (!f.value || look->core->stages.now < 2 || !(began > 0)) return PETSC_FALSE;
  (void)snprintf(stage, sizeof stage, "%.40s_%.40s%s%.40s%s", look->scene->stages[look->core->stages.now - 1], f.group,
                 f.name ? "_" : "", f.name ? f.name : "", f.word);
  if (!MPMUnlikelyGiven("stage", stage, "", &own)) return PETSC_FALSE;
  most   = Most(look, &f, began, (end - began) / TIMES, TIMES + 1, &least);
  before = Most(look, &f, 0, began / TIMES, TIMES, &was);
  early  = Most(look, &f, 0, (end - began) / TIMES, TIMES + 1, &first);
  MPMUnlikelyWrite(odd->other, began);
  (void)snprintf(odd->option, MPM_WORDS, "%s", own.option);
  return most >= 0 && least >= (1 - 1e-9) * most &&
         ((most > 0 && before >= 0 && was < 0.9 * most) || (early > 0 && (first < 0.9 * early || most == 0)));
}

/* --- Comparisons of places and times ------------------------------------------------------------------------------- */

/* Finds the next comparison of a place or the time with a number in a text, as in (X<2); returns what follows it. */
static const char *Comparison(const char *at, char *name, PetscBool *less, PetscReal *bound, char words[MPM_WORDS])
{
  for (; *at; at++) {
    const char *first = at + 1;
    char       *end;

    if (!strchr("xyzXYZt", *at) || !*at || isalnum((unsigned char)at[-1])) continue;
    while (*first == ' ') first++;
    if (*first != '<' && *first != '>') continue;
    *name  = *at;
    *less  = *first == '<';
    *bound = strtod(first + 1 + (first[1] == '='), &end);
    if (end == first + 1 + (first[1] == '=') || !strchr(") ?&|,;", *end)) continue;
    (void)snprintf(words, MPM_WORDS, "%.*s", (int)(end - at), at);
    return end;
  }
  return NULL;
}

/* Sets *body to that of the load of an option, else to -1. */
static void BodyOf(const MPMScene *scene, const char name[], PetscInt *body)
{
  *body = -1;
  for (PetscInt l = 0; l < scene->nloads; l++) {
    char own[2 * MPM_NAME_LEN];

    (void)snprintf(own, sizeof own, "load_%s_", scene->loads[l].name);
    if (strstr(name, own)) *body = scene->loads[l].body;
  }
}

/* A comparison that holds everywhere, and at all times, and is not just the first one that bounds a strip; or one with a
   number that is far from all places and times. */
PetscBool MPMUnlikely_selects_all(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  static const char *const places[2][2] = {{"at no time", "at all times"}, {"nowhere", "everywhere"}};
  const MPMGrid           *grid         = &look->core->grid;
  char                    *text         = NULL, name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN], words[MPM_WORDS], of;
  PetscReal                bound;
  PetscBool                less;

  if (MPMOptionsText(&text)) return PETSC_FALSE;
  for (const char *at = text; at && !(odd->ratio > 0) && MPMOptionsNext(&at, name, value);) {
    PetscInt body, n = 0, all = 0;
    char     padded[MPM_TEXT_LEN + 1];

    BodyOf(look->scene, name, &body);
    if (strstr(name, "title") || strstr(name, "expression") || !strpbrk(value, "<>")) continue;
    (void)snprintf(padded, sizeof padded, "(%.*s", (int)(MPM_TEXT_LEN - 1), value);
    for (const char *c = padded + 1; (c = Comparison(c, &of, &less, &bound, words)); n++) {
      const PetscInt  d     = of == 't' ? -1 : tolower((unsigned char)of) - 'x';
      const PetscReal end   = MPMUnlikelyEnd(look);
      const PetscReal lower = d < 0      ? 0
                              : body < 0 ? look->lowest[d]
                                         : look->lower[body][d],
                      upper = d < 0      ? end
                              : body < 0 ? look->highest[d]
                                         : look->upper[body][d];
      const PetscReal size  = d < 0 ? 100 * end : grid->upper[d] - grid->lower[d];
      const PetscReal far   = d < 0 ? bound / size : PetscMax(bound - grid->upper[d], grid->lower[d] - bound) / size;
      const PetscBool holds = less ? upper <= bound : lower >= bound;

      if (d >= grid->dim || !(size > 0)) continue;
      all += holds && d >= 0;
      if (!(far > 1) && !(holds && d >= 0 && body >= 0)) continue;
      odd->ratio = far > 1 ? 1 : odd->ratio;
      (void)snprintf(odd->option, MPM_WORDS, "%.150s", name);
      (void)snprintf(odd->value, MPM_WORDS, "%.150s", value);
      (void)snprintf(odd->other, MPM_WORDS, "%.40s holds %s%s%.40s", words, places[d >= 0][holds],
                     d >= 0 && body >= 0 ? " in " : "", d >= 0 && body >= 0 ? look->scene->bodies[body].name : "");
      (void)snprintf(odd->meant, MPM_WORDS, "%c is from %.3g to %.3g", of, (double)lower, (double)upper);
      if (far > 1) break;
    }
    if (n && all == n) odd->ratio = 1;
  }
  (void)PetscFree(text);
  return odd->ratio > 0;
}
