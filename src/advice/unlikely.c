/* unlikely.c - notes values of a valid scene that are hardly meant, before the first step: the rows of plausible.def. Of each
   material, body, load ... the first row that finds something is told. It changes no state. */
#include "advice/unlikely.h"

/* --- The table ---------------------------------------------------------------------------------------------------- */

/* In the sequence in which they are told: a formula in the wrong unit of time before what follows from it. */
enum { OF_material, OF_formula, OF_body, OF_load, OF_face, OF_rigid, OF_probe, OF_run, NUM_OF };
enum { SIDE_below, SIDE_above };

static const struct {
  MPMUnlikely *look;
  int          of, side;
  PetscReal    bound;
  const char  *text;
} rows[] = {
#define MPM_UNLIKELY(name, of, side, bound, source, text) {MPMUnlikely_##name, OF_##of, SIDE_##side, bound, text},
#include "advice/plausible.def"
#undef MPM_UNLIKELY
};
#define NROWS (sizeof rows / sizeof rows[0])

/* Units of a number that is too small, one after the other, by the first of which a text names them, and what the number has to be
   multiplied by. */
static const struct {
  const char *first, *name;
  PetscReal   factor;
} units[] = {{"{pressure}", "kPa", 1e3},
             {"{pressure}", "MPa", 1e6},
             {"{pressure}", "GPa", 1e9},
             {"{density}", "t/m^3 or g/cm^3", 1e3},
             {"{density}", "t/mm^3", 1e12}};

/* Returns the first unit in which what is meant is no longer below the bound, or the first of all, and writes it in that unit,
   where it was in the first one. */
static const char *Unit(const char text[], PetscReal bound, MPMOdd *odd)
{
  const char     *first = "";
  char           *after, words[MPM_WORDS];
  const PetscReal meant = strtod(odd->meant, &after);

  (void)snprintf(words, sizeof words, "%s", after);
  for (size_t j = 0; j < sizeof units / sizeof units[0]; j++) {
    if (!strstr(text, units[j].first)) continue;
    if (!first[0]) first = units[j].name;
    if (!(odd->ratio * units[j].factor >= bound)) continue;
    MPMUnlikelyWrite(odd->meant, meant * units[j].factor / 1e3);
    MPMAppend(odd->meant, MPM_WORDS, "%.60s", words);
    return units[j].name;
  }
  return first;
}

/* Writes a text with the words of what was found in the place of {option} ... */
static void Fill(const char text[], const MPMOdd *odd, const char unit[], char line[MPM_TEXT_LEN])
{
  char ratio[MPM_WORDS];
  const struct {
    const char *name, *words;
  } all[] = {{"{pressure}", unit}, {"{density}", unit},     {"{option}", odd->option}, {"{value}", odd->value},
             {"{ratio}", ratio},   {"{other}", odd->other}, {"{meant}", odd->meant}};
  const size_t nall = sizeof all / sizeof all[0];
  size_t       n    = 0;

  MPMUnlikelyWrite(ratio, odd->ratio);
  line[0] = 0;
  while (*text && n < MPM_TEXT_LEN - 1) {
    size_t k = 0;

    while (k < nall && strncmp(text, all[k].name, strlen(all[k].name))) k++;
    if (k < nall) {
      (void)snprintf(line + n, MPM_TEXT_LEN - n, "%s", all[k].words);
      text += strlen(all[k].name);
    } else
      (void)snprintf(line + n, MPM_TEXT_LEN - n, "%c", *text++);
    n += strlen(line + n);
  }
}

/* Returns the body of one body or load, or -1. */
static PetscInt BodyOf(const MPMLook *look, int of, PetscInt k)
{
  return of == OF_body ? k : of == OF_load ? look->scene->loads[k].body : -1;
}

/* Tells what is found of one material, body, load ... */
static PetscErrorCode Tell(const MPMLook *look, int of, PetscInt k)
{
  PetscFunctionBeginUser;
  for (size_t r = 0; r < NROWS; r++) {
    MPMOdd      odd = {0};
    char        line[MPM_TEXT_LEN];
    const char *unit;

    if (rows[r].of != of) continue;
    if (BodyOf(look, of, k) >= 0)
      (void)snprintf(odd.other, MPM_WORDS, "%s", look->scene->bodies[BodyOf(look, of, k)].name);
    if (!rows[r].look(look, k, &odd)) continue;
    if (rows[r].bound != 0 &&
        (rows[r].side == SIDE_above ? !(odd.ratio > rows[r].bound) : !(odd.ratio < rows[r].bound)))
      continue;
    if (look->core->stages.n && !strcmp(odd.option, "-time_end"))
      (void)MPMUnlikelyGiven("stage", look->scene->stages[look->core->stages.now - 1], "_time", &odd);
    unit = Unit(rows[r].text, rows[r].bound, &odd);
    Fill(rows[r].text, &odd, unit, line);
    PetscCall(MPMNote(&look->core->print, "%s", line));
    if (of != OF_run) break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds how far the particles of bodies reach with their boxes, and shapes of rigid bodies. Collective on exchange.data. */
static PetscErrorCode Reach(MPMCore *core, const MPMScene *scene, PetscReal (*lower)[3], PetscReal (*upper)[3])
{
  const PetscInt dim = core->grid.dim, nb = scene->nbodies;
  PetscMPIInt    count;
  MPMView        view;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 3 * nb; k++) {
    lower[k / 3][k % 3] = PETSC_MAX_REAL;
    upper[k / 3][k % 3] = -PETSC_MAX_REAL;
  }
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(x) | MPM_BIT(id), &view));
  for (PetscInt p = 0, b = 0; p < view.n; p++) {
    b = MPMBodyOf(scene, view.id[p], b);
    for (PetscInt d = 0; d < dim; d++) {
      const PetscReal half = scene->bodies[b].points ? 0 : 0.5 * scene->bodies[b].b[d];

      lower[b][d] = PetscMin(lower[b][d], view.x[p * dim + d] - half);
      upper[b][d] = PetscMax(upper[b][d], view.x[p * dim + d] + half);
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(x) | MPM_BIT(id), &view));
  PetscCall(PetscMPIIntCast(3 * nb, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, lower, count, MPIU_REAL, MPIU_MIN, core->exchange.data));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, upper, count, MPIU_REAL, MPIU_MAX, core->exchange.data));
  for (PetscInt k = nb; k < nb + scene->nshapes; k++)
    if (scene->bodies[k].rigid) MPMRegionBounds(&scene->bodies[k].region, dim, lower[k], upper[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is there something to look at: of bodies those of particles at the start, loads on what has particles left, shapes of
   rigid bodies? */
static PetscBool IsThere(const MPMLook *look, int of, PetscInt k)
{
  const PetscInt b = BodyOf(look, of, k);

  if (of == OF_rigid && look->scene->bodies[look->scene->nbodies + k].rigid == MPM_RIGID_NONE) return PETSC_FALSE;
  if (b < 0) return PETSC_TRUE;
  if (of == OF_body && (look->scene->bodies[b].removed || look->scene->bodies[b].source.on)) return PETSC_FALSE;
  return look->lower[b][0] <= look->upper[b][0];
}

/* Described in advice.h. */
PetscErrorCode MPMUnlikelyNote(MPMCore *core, const MPMScene *scene, const MPMTime *time, const MPMMonitor *monitor,
                               const MPMForecast *f)
{
  const PetscReal *g    = core->params.gravity;
  MPMLook          look = {.core    = core,
                           .scene   = scene,
                           .time    = time,
                           .monitor = monitor,
                           .seconds = f->steps * f->step,
                           .dt      = f->dt,
                           .steps   = f->steps};
  const PetscInt   all  = scene->nbodies + scene->nshapes;
  PetscInt         n[NUM_OF];

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc3(all, &look.lower, all, &look.upper, all, &look.way));
  PetscCall(Reach(core, scene, look.lower, look.upper));
  for (PetscInt d = 0; d < core->grid.dim; d++) {
    look.g += g[d] * g[d];
    if (PetscAbsReal(g[d]) > PetscAbsReal(g[look.down])) look.down = d;
    look.lowest[d]  = PETSC_MAX_REAL;
    look.highest[d] = -PETSC_MAX_REAL;
    for (PetscInt b = 0; b < scene->nbodies; b++) {
      look.lowest[d]  = PetscMin(look.lowest[d], look.lower[b][d]);
      look.highest[d] = PetscMax(look.highest[d], look.upper[b][d]);
    }
  }
  look.g     = PetscSqrtReal(look.g);
  look.earth = look.g > MPM_BOUND_earth_least && look.g < MPM_BOUND_earth_exact;
  for (PetscInt b = 0; b < scene->nbodies; b++) {
    const MPMMaterial *m = &scene->materials[scene->bodies[b].material];

    look.c = PetscMax(look.c, PetscSqrtReal(MPMUnlikelyModulus(m, PETSC_FALSE) / m->rho));
  }
  n[OF_material] = scene->nmaterials;
  n[OF_body]     = scene->nbodies;
  n[OF_load]     = scene->nloads;
  n[OF_face]     = 2 * core->grid.dim;
  n[OF_rigid]    = scene->nshapes;
  n[OF_formula]  = MPMUnlikelyFormulas(&look);
  n[OF_probe]    = scene->nprobes;
  n[OF_run]      = 1;
  PetscCall(MPMUnlikelyWays(&look, look.way));
  PetscCall(MPMUsualNote(&look));
  for (int of = 0; of < NUM_OF; of++)
    for (PetscInt k = 0; k < n[of]; k++)
      if (IsThere(&look, of, k)) PetscCall(Tell(&look, of, k));
  PetscCall(PetscFree3(look.lower, look.upper, look.way));
  PetscFunctionReturn(PETSC_SUCCESS);
}
