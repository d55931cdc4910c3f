/* changes.c - what may differ between a run and the checkpoint that it goes on from: options, by the table changes.def;
   fields of particles, of which some can be made anew; and what a change gives to energy and momentum. */
#include <strings.h>
#include "base/checksum.h"
#include "restart/restart.h"

typedef enum { MPM_ACTS_NOT, MPM_ACTS_RUN, MPM_ACTS, MPM_ACTS_NEVER } Acts;
static const struct {
  const char *option;
  Acts        acts;
} changes[] = {
#define MPM_CHANGE(option, acts) {option, acts},
#include "restart/changes.def"
};

static Acts ActsOf(const char row[])
{
  for (size_t k = 0; k < sizeof changes / sizeof changes[0]; k++)
    if (!strncmp(row, changes[k].option, strlen(changes[k].option))) return changes[k].acts;
  return MPM_ACTS_NEVER;
}

const char *MPMRestartNotInStage(const char row[])
{
  return ActsOf(row) == MPM_ACTS_NEVER ? "" : ActsOf(row) == MPM_ACTS_RUN ? ", since all stages share it" : NULL;
}

/* Returns whether two values say the same: the same numbers, or the same words. */
static PetscBool SameValue(const char a[], const char b[])
{
  for (;;) {
    char        *after_a, *after_b;
    const double x = strtod(a, &after_a), y = strtod(b, &after_b);

    if (after_a == a || after_b == b || x != y) return !strcasecmp(a, b);
    if (!*after_a && !*after_b) return PETSC_TRUE;
    if (*after_a != ',' || *after_b != ',') return !strcasecmp(a, b);
    a = after_a + 1;
    b = after_b + 1;
  }
}

/* Returns why an option whose name may change may not change from one value to the other, or NULL. */
static const char *Never(const MPMCheckpoint *c, const char row[], const char was[], const char is[])
{
  static const char *const lasting[] = {"periodic", "piston"};

  if (c->was_implicit && !c->core->implicit && (!strcmp(row, "method_frame") || !strcmp(row, "method_preset")))
    return NULL;
  if (c->core->grid.total && (!strcmp(row, "method_basis") || !strcmp(row, "method_wall_basis")))
    return "; in the total frame the state is on the nodes of the basis";
  if (!strcmp(row, "contact_mu") && !strcasecmp(was, "none") != !strcasecmp(is, "none"))
    return "; contact between bodies cannot begin or end";
  if (!strcmp(row, "method_time") && !strcasecmp(is, "static"))
    return "; a motion cannot become statics, only statics a motion";
  for (size_t k = 0; k < 2 && !strcmp(row, "bc_<f>_type"); k++)
    if (!strcasecmp(was, lasting[k]) != !strcasecmp(is, lasting[k]))
      return "; a wall cannot become or cease to be periodic or a piston";
  return ActsOf(row) == MPM_ACTS_NEVER ? "" : NULL;
}

/* Compares one option of the checkpoint (was) and of this run (is), NULL if it was not given: then its default counts,
   if that is a value. */
static void Compare(MPMCheckpoint *c, MPMOptions o, const char name[], const char was[], const char is[])
{
  const MPMOptionRow *row  = MPMOptionsRow(o, name + 1);
  char               *text = c->differ;
  const size_t        n    = strlen(text);
  const char         *why;

  if (!row || !strcasecmp(name, "-restart_file") || !strcasecmp(name, "-rerun")) return;
  if (!was && !strcmp(row->name, "method_frame") && c->was_implicit) was = "total"; /* they are in it */
  if (SameValue(was ? was : row->fallback, is ? is : row->fallback)) return;
  why = Never(c, row->name, was ? was : row->fallback, is ? is : row->fallback);
  if (why)
    MPMOptionsFail(o, "%s%.500s%s%.100s %s%.200s %s and %s%.200s in this %s; it may not change%s",
                   c->from[0] ? "-restart_file " : "", c->from, c->from[0] ? ": " : "", name,
                   !was     ? "is not given"
                   : was[0] ? "is "
                            : "is given",
                   was ? was : "", c->from[0] ? "in the checkpoint" : "before",
                   !is     ? "is not given"
                   : is[0] ? "is "
                           : "is given",
                   is ? is : "", c->from[0] ? "run" : "stage", why);
  else
    (void)snprintf(text + n, MPM_TEXT_LEN - n, "%s%s %s, was %s", n ? "; " : "", name,
                   is ? is[0] ? is : "given" : "not given", was ? was[0] ? was : "given" : "not given");
  if (ActsOf(row->name) == MPM_ACTS) c->changed = PETSC_TRUE;
  if (!strcmp(row->name, "method_time") && was && !strcasecmp(was, "static")) c->was_static = PETSC_TRUE;
}

PetscErrorCode MPMRestartCompare(MPMCheckpoint *c, MPMOptions o)
{
  char       *here, *given;
  const char *at;
  char        name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN], other[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (MPMOptionsFindIn(c->options, "-method_time", value) && strcasecmp(value, "explicit"))
    c->was_implicit = PETSC_TRUE;
  PetscCall(MPMOptionsText(&given));
  PetscCall(MPMStagesOptions(given, c->core->stages.now, &here));
  PetscCall(PetscFree(given));
  for (at = c->options; MPMOptionsNext(&at, name, value);)
    Compare(c, o, name, value, MPMOptionsFindIn(here, name, other) ? other : NULL);
  for (at = here; MPMOptionsNext(&at, name, value);)
    if (!MPMOptionsFindIn(c->options, name, other)) Compare(c, o, name, NULL, value);
  PetscCall(PetscFree(here));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Particles ---------------------------------------------------------------------------------------------------- */

PetscInt64 MPMRestartKinds(const MPMScene *scene)
{
  uint64_t sum = 0;
  size_t   at  = 0;

#define ADD(value) sum += MPMChecksum(&(value), sizeof(value), 8 * at++)
  for (PetscInt k = 0; k < scene->nkinds; k++) {
    ADD(scene->kinds[k].material);
    ADD(scene->kinds[k].m);
    ADD(scene->kinds[k].V0);
    ADD(scene->kinds[k].copy);
  }
  for (PetscInt b = 0; b < scene->nbodies; b++) ADD(scene->bodies[b].n);
#undef ADD
  return (PetscInt64)(sum >> 1);
}

/* Returns whether a field that a checkpoint does not have can be made: from the particle as it starts, or since its
   value at the start is the right one. flows: what flows in is at no place at the start. */
static PetscBool CanMake(PetscBool flows, PetscInt field)
{
  return (MPMFields[field].home == MPM_SWARM && field != MPM_FIELD_INDEX_l && !flows) || field == MPM_FIELD_INDEX_C ||
         field == MPM_FIELD_INDEX_bar;
}

PetscErrorCode MPMRestartCheckFields(MPMCheckpoint *c)
{
  MPMParticles *particles = &c->core->particles;
  PetscBool     flows     = PETSC_FALSE;
  char          has[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  c->missing = 0;
  for (PetscInt b = 0; b < c->scene->nfilled; b++) flows = flows || c->scene->bodies[b].source.on;
  if (c->kinds != MPMRestartKinds(c->scene)) {
    (void)snprintf(c->core->stop, sizeof c->core->stop,
                   "-restart_file %.1000s: its particles have other masses, volumes, numbers or contacts than those of "
                   "this scene; options that decide these may not change",
                   c->from);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMCheckpointFields(c->from, c->core->comm, has));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS && !c->core->stop[0]; f++) {
    if (!particles->present[f] || !MPMCheckpointHasField(f) || MPMListHas(has, MPMFields[f].name)) continue;
    c->missing |= (PetscInt)1 << f;
    if (!CanMake(flows, f))
      (void)snprintf(c->core->stop, sizeof c->core->stop,
                     "-restart_file %.1000s: its particles have no %s (%s), which this run needs; let the run before "
                     "have it too, by the options that differ or by -output_fields",
                     c->from, MPMFields[f].name, MPMFields[f].meaning);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- The balance -------------------------------------------------------------------------------------------------- */

void MPMRestartBalance(MPMCheckpoint *c, const MPMTotals *now)
{
  MPMCore        *core  = c->core;
  MPMChanges     *given = &core->changes;
  const MPMShown  shown = MPMMonitorShown(c->monitor, core, c->scene);
  const PetscReal time  = now->sum[MPM_SHOWS_mass][0] * core->kicked + now->sum[MPM_SHOWS_lost_mass_time][0];
  PetscReal       g[3], work, fallen;
  PetscMPIInt     rank;

  given->energy += now->sum[MPM_SHOWS_strain_energy][0] - given->strain;
  for (PetscInt d = 0; d < 3; d++) g[d] = core->params.gravity[d];
  for (PetscInt d = 0; d < core->grid.dim; d++) given->impulse[d] += time * (given->gravity[d] - g[d]);
  work = MPMShownWork(&shown);
  for (PetscInt d = 0; d < 3; d++) core->params.gravity[d] = given->gravity[d];
  given->energy += MPMShownWork(&shown) - work;
  for (PetscInt d = 0; d < 3; d++) core->params.gravity[d] = given->gravity[d] = g[d];
  if (!c->was_static || !core->energy.on) return;
  fallen = MPMShownGravity(&shown); /* a motion sums it over its steps */
  c->monitor->now.energy[MPM_ENERGY_gravity] += fallen;
  (void)MPI_Comm_rank(core->exchange.data, &rank);
  if (!rank) MPMSumAdd(&core->energy.sum[MPM_ENERGY_gravity], fallen);
}
