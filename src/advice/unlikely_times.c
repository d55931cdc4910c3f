/* unlikely_times.c - the rows of plausible.def of the run that are about times: its end, its steps, tables, sources, output. */
#include <strings.h>
#include "advice/unlikely.h"

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

PetscBool MPMUnlikely_step_long(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  if (!MPMUnlikelyNumber("dt_size", NULL, "", odd, &odd->ratio) || !(look->time->end > 0)) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->other, look->time->end);
  odd->ratio /= look->time->end;
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_step_short(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const PetscReal crosses = MPMGridSmallestH(&look->core->grid) / look->c;

  (void)k;
  if (MPMUnlikelyGiven("method_time", NULL, "", odd) && !strcasecmp(odd->value, "static")) return PETSC_FALSE; /* no waves */
  if (!MPMUnlikelyNumber("dt_size", NULL, "", odd, &odd->ratio) || look->core->status.v2 > look->c * look->c) return PETSC_FALSE;
  MPMUnlikelyWrite(odd->other, crosses);
  odd->ratio /= crosses;
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_cfl_small(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)look;
  (void)k;
  return MPMUnlikelyNumber("dt_cfl", NULL, "", odd, &odd->ratio);
}

PetscBool MPMUnlikely_rest_never(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)look;
  (void)k;
  return MPMUnlikelyNumber("time_rest", NULL, "", odd, &odd->ratio) && odd->ratio > 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns when the whole run ends, s. */
static PetscReal EndOf(const MPMLook *look)
{
  return look->core->stages.n ? look->core->stages.end : look->time->end;
}

PetscBool MPMUnlikely_table_long(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;

  (void)k;
  for (PetscInt j = 0; j < scene->nloads + 7; j++) {
    const MPMExpression formula = j < scene->nloads ? scene->loads[j].value
                                  : j - scene->nloads < 6 ? scene->wall_velocity[j - scene->nloads] : scene->acceleration;
    const PetscReal     last = MPMExpressionTables(formula);

    if (!(last > odd->ratio)) continue;
    odd->ratio = last;
    (void)MPMUnlikelyGiven(j < scene->nloads ? "load" : j - scene->nloads < 6 ? "bc" : "acceleration",
                           j < scene->nloads ? scene->loads[j].name : j - scene->nloads < 6 ? MPMFaceNames[j - scene->nloads] : NULL,
                           j < scene->nloads ? "_value" : j - scene->nloads < 6 ? "_velocity" : "", odd);
  }
  MPMUnlikelyWrite(odd->value, odd->ratio);
  MPMUnlikelyWrite(odd->other, EndOf(look));
  odd->ratio /= EndOf(look);
  return EndOf(look) > 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* The largest time that sources are given, s, and its option. */
static PetscBool OfSources(const MPMLook *look, const char word[], MPMOdd *odd)
{
  MPMOdd other = {0};

  for (PetscInt b = 0; b < look->scene->nbodies; b++)
    if (look->scene->bodies[b].source.on && MPMUnlikelyNumber("source", look->scene->bodies[b].name, word, &other, &other.ratio) &&
        other.ratio > odd->ratio)
      *odd = other;
  MPMUnlikelyWrite(odd->other, EndOf(look));
  odd->ratio /= EndOf(look);
  return EndOf(look) > 0 ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_source_late(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  return OfSources(look, "_from", odd);
}

PetscBool MPMUnlikely_source_long(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  (void)k;
  return OfSources(look, "_to", odd);
}

PetscBool MPMUnlikely_source_full(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;
  PetscReal      room = 1, all = 0, most = 0, to;

  (void)k;
  if (look->core->params.deletes) return PETSC_FALSE;
  for (PetscInt d = 0; d < grid->dim; d++) room *= grid->upper[d] - grid->lower[d];
  for (PetscInt j = 0; j < look->scene->nfilled; j++) {
    const MPMBody   *b      = &look->scene->bodies[j];
    const MPMSource *s      = &b->source;
    const PetscReal  volume = (PetscReal)b->n * look->scene->kinds[b->kind].V0,
                    flows  = s->on ? PetscMax(0, (PetscMin(s->to, EndOf(look)) - s->from) / (s->to - s->from)) : 0;

    if (!s->on) room -= volume;
    all += flows * volume;
    if (!(flows * volume > most)) continue;
    most = flows * volume;
    if (!MPMUnlikelyNumber("source", b->name, "_to", odd, &to)) return PETSC_FALSE;
  }
  (void)snprintf(odd->other, MPM_WORDS, "%.3g m^3", (double)all);
  odd->ratio = room > 0 ? all / room : 0;
  return most > 0 ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMUnlikely_output_none(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  static const char *const options[] = {"output_every", "history_every", "checkpoint_every"};

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
  PetscReal output = PETSC_MAX_REAL, history = PETSC_MAX_REAL, every;

  (void)k;
  if (look->core->implicit || !(look->dt > 0)) return PETSC_FALSE;
  (void)MPMUnlikelyNumber("output_every", NULL, "", odd, &output);
  (void)MPMUnlikelyNumber("history_every", NULL, "", odd, &history);
  if (!(history > 0)) history = PETSC_MAX_REAL;
  if (!(output > 0)) output = PETSC_MAX_REAL;
  if (!MPMUnlikelyNumber(output <= history ? "output_every" : "history_every", NULL, "", odd, &every)) return PETSC_FALSE;
  odd->ratio = PetscMin(output, history) / look->dt;
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
