/* unlikely_times.c - the rows of plausible.def of the run that are about times: its end, its steps, tables, sources, output. */
#include "advice/unlikely.h"
#include "options/reader.h"

#define FALLS 50   /* through the grid, or flights, which a run may last */
#define WAVES 1000 /* through the matter, likewise */

/* Returns the longest time that what moves needs: through the grid at its speed, in a fall, or, as waves do, through
   the matter. */
static PetscReal Longest(const MPMLook *look, PetscReal *whole, char text[MPM_WORDS])
{
  const MPMScene *scene = look->scene;
  const MPMGrid  *grid  = &look->core->grid;
  PetscReal       size = 0, slowest = PETSC_MAX_REAL, longest;

  for (PetscInt d = 0; d < grid->dim; d++) size = PetscMax(size, grid->upper[d] - grid->lower[d]);
  for (PetscInt b = 0; b < scene->nbodies; b++)
    if (scene->bodies[b].v2 > 0) slowest = PetscMin(slowest, PetscSqrtReal(scene->bodies[b].v2));
  for (PetscInt k = 0; k < MPMUnlikelyFormulas(look); k++) {
    const MPMFormula f = MPMUnlikelyFormula(look, k);

    if (f.value && f.body < 0 && f.name && strcmp(f.word, "_spin") && MPMUnlikelySize(look, &f) > 0)
      slowest = PetscMin(slowest, MPMUnlikelySize(look, &f));
  }
  for (PetscInt face = 0; face < 2 * grid->dim; face++) {
    const PetscReal *v    = scene->walls.given[face / 2][face % 2].velocity,
                    speed = PetscSqrtReal(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);

    if (MPMWallHas(scene->walls.given[face / 2][face % 2].type, MPM_WALL_MOVES) && speed > 0)
      slowest = PetscMin(slowest, speed);
  }
  longest = MPMUnlikelyExtent(look, -1, -1) / look->c;
  *whole  = WAVES * longest;
  (void)snprintf(text, MPM_WORDS, "as long as a wave needs through the matter, %.3g s", (double)longest);
  if (look->g > 0 && FALLS * PetscSqrtReal(2 * size / look->g) > *whole) {
    longest = PetscSqrtReal(2 * size / look->g);
    *whole  = FALLS * longest;
    (void)snprintf(text, MPM_WORDS, "as long as a fall through the grid, %.3g s", (double)longest);
  }
  if (FALLS * size / slowest > *whole) {
    longest = size / slowest;
    *whole  = FALLS * longest;
    (void)snprintf(text, MPM_WORDS, "as long as the slowest motion needs through the grid, %.3g s", (double)longest);
  }
  return longest;
}

PetscBool MPMUnlikely_end_far(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscReal left = look->time->end - PetscMax(look->core->t, look->core->stages.began);
  PetscReal       whole, longest;

  if (look->core->implicit || look->scene->known) return PETSC_FALSE;
  for (PetscInt j = 0; j < MPMUnlikelyFormulas(look); j++) {
    const MPMFormula f = MPMUnlikelyFormula(look, j);

    if (MPMUnlikelyChanges(look, j) && !MPMUnlikelySteady(look, &f)) return PETSC_FALSE;
  }
  longest    = Longest(look, &whole, odd->other);
  odd->ratio = left / whole;
  MPMUnlikelyWrite(odd->meant, left / longest);
  return MPMUnlikelyGiven("time_end", NULL, "", odd);
}

/* A number of steps that stands in a file, and is forgotten there; on the command line it is meant. */
PetscBool MPMUnlikely_end_cut(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const PetscReal dt = look->time->fixed > 0 ? look->time->fixed : look->dt, left = look->time->end - look->core->t;
  char            place[MPM_TEXT_LEN];

  if (!(left > 0) || look->time->max_steps == PETSC_MAX_INT) return PETSC_FALSE;
  odd->ratio = (PetscReal)look->time->max_steps * dt / look->time->end;
  MPMUnlikelyWrite(odd->other, look->time->end);
  if (!MPMUnlikelyGiven("time_max_steps", NULL, "", odd)) return PETSC_FALSE;
  MPMOptionsPlace("time_max_steps", odd->value, place, sizeof place);
  return place[0] ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_steps_many(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  MPMOdd far = {0};

  if (look->core->implicit || look->seconds > 86400 || look->time->max_steps != PETSC_MAX_INT)
    return PETSC_FALSE;                                                        /* a day is told, */
  if (MPMUnlikely_end_far(look, k, &far) && far.ratio > 1) return PETSC_FALSE; /* and this too */
  odd->ratio = look->steps;
  MPMTimeWords(look->seconds, odd->other);
  return look->core->stages.n ? MPMUnlikelyGiven("stages", NULL, "", odd) : MPMUnlikelyGiven("time_end", NULL, "", odd);
}

PetscBool MPMUnlikely_end_zero(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  odd->ratio = look->time->end;
  return MPMUnlikelyGiven("time_end", NULL, "", odd);
}

PetscBool MPMUnlikely_end_late(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  odd->ratio = look->seconds < MPM_BOUND_year ? look->seconds : 0;
  MPMTimeWords(look->seconds, odd->other);
  MPMUnlikelyWrite(odd->meant, look->time->end * look->c / MPMUnlikelyExtent(look, -1, -1));
  return MPMUnlikelyGiven("time_end", NULL, "", odd) && !look->core->implicit;
}

PetscBool MPMUnlikely_step_long(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  return MPMUnlikelyOver("dt_size", look->time->end, odd);
}

PetscBool MPMUnlikely_step_short(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  if (MPMUnlikelyStatic(odd) || look->core->status.v2 > look->c * look->c) return PETSC_FALSE; /* no waves */
  return MPMUnlikelyOver("dt_size", MPMGridSmallestH(&look->core->grid) / look->c, odd);
}

PetscBool MPMUnlikely_output_none(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  static const char *const options[] = {"output_every", "history_every", "checkpoint_every"};

  for (size_t j = 0; j < sizeof options / sizeof options[0] && !look->core->implicit; j++)
    if (MPMUnlikelyOver(options[j], MPMUnlikelyEnd(look), odd) && odd->ratio > 1) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_output_fine(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  PetscReal output = PETSC_MAX_REAL, history = PETSC_MAX_REAL, every;

  if (look->core->implicit || !(look->dt > 0)) return PETSC_FALSE;
  (void)MPMUnlikelyNumber("output_every", NULL, "", odd, &output);
  (void)MPMUnlikelyNumber("history_every", NULL, "", odd, &history);
  if (!(history > 0)) history = PETSC_MAX_REAL;
  if (!(output > 0)) output = PETSC_MAX_REAL;
  if (!MPMUnlikelyNumber(output <= history ? "output_every" : "history_every", NULL, "", odd, &every))
    return PETSC_FALSE;
  odd->ratio = PetscMin(output, history) / look->dt;
  MPMUnlikelyWrite(odd->other, look->dt);
  return PETSC_TRUE;
}

PetscReal MPMUnlikelyAt(const MPMLook *look, const MPMFormula *f, PetscReal t)
{
  enum { PLACES = 7 };
  const PetscReal *lower = f->body < 0 ? look->lowest : look->lower[f->body],
                  *upper = f->body < 0 ? look->highest : look->upper[f->body];
  PetscReal most = 0, x[3] = {0};

  for (PetscInt j = 0; j < PLACES; j++) {
    PetscReal value[9] = {0};

    for (PetscInt d = 0; d < look->core->grid.dim; d++) x[d] = lower[d] + (upper[d] - lower[d]) * j / (PLACES - 1);
    if (MPMExpressionEvaluate(f->value, look->core->grid.dim, x, x, t, value)) return 0;
    for (PetscInt c = 0; c < f->nc; c++)
      if (PetscAbsReal(value[c]) > PetscAbsReal(most)) most = value[c];
  }
  return most;
}

/* A table, as a record, of both signs, that ends before the run. */
PetscBool MPMUnlikely_table_short(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  enum { TIMES = 500 };
  const MPMFormula f    = MPMUnlikelyFormula(look, k);
  const PetscReal  last = f.value && MPMUnlikelyChanges(look, k) ? MPMExpressionTables(f.value) : 0,
                  end   = MPMUnlikelyEnd(look);
  PetscReal most = 0, least = 0, held;

  if (!(last > 0) || !(last < 0.99 * end)) return PETSC_FALSE;
  for (PetscInt j = 0; j <= TIMES; j++) {
    most  = PetscMax(most, MPMUnlikelyAt(look, &f, last * j / TIMES));
    least = PetscMin(least, MPMUnlikelyAt(look, &f, last * j / TIMES));
  }
  held = MPMUnlikelyAt(look, &f, end);
  if (PetscMin(most, -least) < 0.2 * PetscMax(most, -least) || held != MPMUnlikelyAt(look, &f, 0.5 * (last + end)))
    return PETSC_FALSE;
  odd->ratio = PetscAbsReal(held) / PetscMax(most, -least);
  if (!MPMUnlikelyGiven(f.group, f.name, f.word, odd)) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->value, last);
  MPMUnlikelyWrite(odd->other, end);
  return PETSC_TRUE;
}

/* The interval of the history over the time for which a formula of t stays above half of its size. What is shorter than a wave
   through the matter is a blow, after which vibrations may be what is looked at. */
PetscBool MPMUnlikely_pulse_missed(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  enum { TIMES = 8000, PARTS = 32 };
  const PetscReal began = look->core->stages.began, length = look->time->end - began,
                  crosses = MPMUnlikelyExtent(look, -1, -1) / look->c;
  PetscReal every, step;

  if (look->core->implicit || !MPMUnlikelyNumber("history_every", NULL, "", odd, &every) || !(every > 0) ||
      !(length > 3 * every))
    return PETSC_FALSE;
  step = PetscMax(every / PARTS, length / TIMES);
  for (PetscInt j = 0; j < MPMUnlikelyFormulas(look); j++) {
    const MPMFormula f    = MPMUnlikelyFormula(look, j);
    const PetscInt   n    = (PetscInt)(length / step);
    PetscReal        most = 0;
    PetscInt         now = 0, longest = 0;
    PetscReal        size[TIMES + 1];

    if (!f.value || !MPMUnlikelyChanges(look, j)) continue;
    for (PetscInt i = 0; i < n; i++) {
      size[i] = PetscAbsReal(MPMUnlikelyAt(look, &f, began + step * ((PetscReal)i + 0.5)));
      most    = PetscMax(most, size[i]);
    }
    for (PetscInt i = 0; i < n; i++) {
      now     = size[i] > 0.5 * most ? now + 1 : 0;
      longest = PetscMax(longest, now);
    }
    if (!longest || (longest * step < crosses && every > crosses) || every / (longest * step) < odd->ratio) continue;
    odd->ratio = every / (longest * step);
    (void)snprintf(odd->other, MPM_WORDS, "-%.20s%s%.60s%.20s is above half of its size for %.2g s at a time", f.group,
                   f.name ? "_" : "", f.name ? f.name : "", f.word, (double)(longest * step));
    (void)snprintf(odd->meant, MPM_WORDS, "%.1g", (double)(0.1 * longest * step));
  }
  return odd->other[0];
}

PetscBool MPMUnlikely_output_many(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  PetscReal every;

  if (look->core->implicit || !MPMUnlikelyNumber("output_every", NULL, "", odd, &every) || !(look->dt > 0))
    return PETSC_FALSE;
  odd->ratio = look->time->end / PetscMax(every, look->dt);
  MPMUnlikelyWrite(odd->meant, look->time->end / 100);
  return PETSC_TRUE;
}
