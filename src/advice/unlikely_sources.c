/* unlikely_sources.c - the rows of plausible.def of what flows in. */
#include "advice/unlikely.h"

#define PLACES 5 /* on each axis of a source */

/* The largest time that sources are given, s, and its option. */
static PetscBool OfSources(const MPMLook *look, const char word[], MPMOdd *odd)
{
  MPMOdd other = {0};

  for (PetscInt b = 0; b < look->scene->nbodies; b++)
    if (look->scene->bodies[b].source.on &&
        MPMUnlikelyNumber("source", look->scene->bodies[b].name, word, &other, &other.ratio) &&
        other.ratio > odd->ratio)
      *odd = other;
  MPMUnlikelyWrite(odd->other, MPMUnlikelyEnd(look));
  odd->ratio /= MPMUnlikelyEnd(look);
  return MPMUnlikelyEnd(look) > 0;
}

PetscBool MPMUnlikely_source_late(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  return OfSources(look, "_from", odd);
}

PetscBool MPMUnlikely_source_long(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  return OfSources(look, "_to", odd);
}

PetscBool MPMUnlikely_source_full(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMGrid *grid = &look->core->grid;
  PetscReal      room = 1, all = 0, most = 0, to;

  if (look->core->params.deletes) return PETSC_FALSE;
  for (PetscInt d = 0; d < grid->dim; d++) room *= grid->upper[d] - grid->lower[d];
  for (PetscInt j = 0; j < look->scene->nfilled; j++) {
    const MPMBody   *b      = &look->scene->bodies[j];
    const MPMSource *s      = &b->source;
    const PetscReal  volume = (PetscReal)b->n * look->scene->kinds[b->kind].V0,
                    flows   = s->on ? PetscMax(0, (PetscMin(s->to, MPMUnlikelyEnd(look)) - s->from) / (s->to - s->from))
                                    : 0;

    if (!s->on) room -= volume;
    all += flows * volume;
    if (!(flows * volume > most)) continue;
    most = flows * volume;
    if (!MPMUnlikelyNumber("source", b->name, "_to", odd, &to)) return PETSC_FALSE;
  }
  (void)snprintf(odd->other, MPM_WORDS, "%.3g m^3", (double)all);
  odd->ratio = room > 0 ? all / room : 0;
  return most > 0;
}

/* Follows what flows in first, in free flight; returns the open face through which it leaves the grid before it meets a body or a
   wall, or -1; *things: whether there is anything to meet. */
static PetscInt LeavesThrough(const MPMLook *look, PetscInt source, PetscBool *things)
{
  enum { PARTS = 1000 };
  const MPMScene  *scene = look->scene;
  const MPMGrid   *grid  = &look->core->grid;
  const MPMSource *s     = &scene->bodies[source].source;
  MPMRegion        front = scene->bodies[source].region;
  PetscReal        lower[3], upper[3];

  front.sweep = 0;
  MPMRegionBounds(&front, grid->dim, lower, upper);
  for (PetscInt p = 0; p <= PARTS; p++) {
    const PetscReal t = PetscMax(0, look->time->end - s->from) * (PetscReal)p / PARTS;
    PetscReal       way[3];

    for (PetscInt d = 0; d < grid->dim; d++) way[d] = (s->v[d] + 0.5 * look->core->params.gravity[d] * t) * t;
    for (PetscInt b = 0; b < scene->nbodies + scene->nshapes; b++) {
      const PetscBool rigid = b >= scene->nbodies;
      PetscBool       meets = PETSC_TRUE;

      if (b == source || scene->bodies[b].removed || scene->bodies[b].source.on ||
          (rigid && scene->bodies[b].rigid == MPM_RIGID_NONE))
        continue;
      if (rigid && scene->bodies[b].rigid != MPM_RIGID_FIXED) return -1; /* it may come to any place */
      *things = PETSC_TRUE;
      for (PetscInt d = 0; d < grid->dim; d++)
        meets = meets && lower[d] + way[d] < look->upper[b][d] + grid->h[d] &&
                upper[d] + way[d] > look->lower[b][d] - grid->h[d];
      if (meets) return -1;
    }
    for (PetscInt face = 0; face < 2 * grid->dim; face++) {
      const PetscInt  d   = face / 2;
      const PetscReal gap = face % 2 ? grid->upper[d] - upper[d] - way[d] : lower[d] + way[d] - grid->lower[d],
                      to  = (face % 2 ? 1 : -1) * (s->v[d] + look->core->params.gravity[d] * t);

      if (grid->periodic[d] || (grid->round && !face)) continue;
      if (MPMUnlikelyWall(look, face) == MPM_WALL_free && gap < -0.5 * (upper[d] - lower[d]) && to > 0) return face;
      if (MPMUnlikelyWall(look, face) == MPM_WALL_free) continue;
      *things = PETSC_TRUE;
      if (gap < grid->h[d] && to > 0) return -1;
    }
  }
  return -1;
}

/* What flows in against gravity pushes what has flowed in before, so that it comes farther than a free flight. */
PetscBool MPMUnlikely_source_up(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMGrid  *grid = &look->core->grid;
  const PetscInt  d = look->down, up = 2 * d + (look->core->params.gravity[d] < 0);
  const PetscBool deletes = look->core->params.deletes;

  for (PetscInt b = 0; b < look->scene->nbodies; b++) {
    const MPMSource *s      = &look->scene->bodies[b].source;
    MPMRegion        front  = look->scene->bodies[b].region;
    PetscBool        things = PETSC_FALSE;
    PetscReal        lower[3], upper[3];
    PetscInt         face;

    if (!s->on) continue;
    front.sweep = 0;
    MPMRegionBounds(&front, grid->dim, lower, upper);
    face       = LeavesThrough(look, b, &things);
    odd->ratio = face >= 0 && (things || !deletes) ? 2 : 0;
    if (face < 0 && look->g > 0 && s->along[d] * look->core->params.gravity[d] < -0.9 * look->g && !deletes &&
        MPMUnlikelyWall(look, up) == MPM_WALL_free) {
      face       = up;
      odd->ratio = s->speed * (PetscMin(s->to, look->time->end) - s->from) /
                   PetscMax(1e-9 * grid->h[d], up % 2 ? grid->upper[d] - upper[d] : lower[d] - grid->lower[d]);
    }
    if (!(odd->ratio > 1)) continue;
    (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[b].name);
    (void)snprintf(odd->meant, MPM_WORDS, "its free face %s%s; check its sign%s", MPMFaceNames[face],
                   face == up && look->g > 0 ? ", against gravity" : "",
                   deletes ? "" : ", or use -particles_leave delete");
    return MPMUnlikelyGiven("body", look->scene->bodies[b].name, "_velocity", odd);
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_source_thin(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  for (PetscInt b = 0; b < look->scene->nbodies; b++) {
    const MPMSource *s = &look->scene->bodies[b].source;

    if (!s->on || s->layers > 2) continue;
    odd->ratio = (PetscReal)s->layers;
    (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[b].name);
    return MPMUnlikelyGiven("source", look->scene->bodies[b].name, "_to", odd);
  }
  return PETSC_FALSE;
}

PetscBool MPMUnlikely_source_in(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  const MPMScene *scene = look->scene;
  const PetscInt  dim   = look->core->grid.dim;

  if (!MPMUnlikelyStarts(look)) return PETSC_FALSE;
  for (PetscInt s = 0; s < scene->nbodies; s++) {
    MPMRegion front = scene->bodies[s].region;
    PetscReal lower[3], upper[3], x[3] = {0};

    if (!scene->bodies[s].source.on) continue;
    front.sweep = 0;
    MPMRegionBounds(&front, dim, lower, upper);
    for (PetscInt b = 0; b < scene->nbodies; b++) {
      PetscInt in = 0, all = 0;

      if (b == s || scene->bodies[b].source.on || scene->bodies[b].points || scene->bodies[b].removed) continue;
      for (; MPMUnlikelyPlace(dim, lower, upper, PLACES, all, x); all++)
        in += MPMRegionInside(&scene->bodies[b].region, dim, x);
      if (!((PetscReal)in / (PetscReal)all > odd->ratio)) continue;
      odd->ratio = (PetscReal)in / (PetscReal)all;
      (void)snprintf(odd->option, MPM_WORDS, "-body_%s_shape", scene->bodies[s].name);
      (void)snprintf(odd->other, MPM_WORDS, "%s", scene->bodies[b].name);
    }
  }
  return odd->option[0] != 0;
}
