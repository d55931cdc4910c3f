/* bodies.c - sums over the particles of a body as columns of the history (-history_bodies): the rows
   MPM_BODY_QUANTITY of measures.def. Sums are exact, so they are the same on any number of processes. */
#include "results/measures.h"
#include "results/output.h"
#include "results/selected.h"
#include "step/step.h"

typedef enum { NUMBER, SUM, MEAN, LEAST, MOST, BACK, FRONT, LOST } How;
#define AHEAD 0.995 /* the part of a body's mass that lies behind its front */
static const struct {
  const char *name, *unit;
  How         how;
  PetscInt    of, nc, asked;
} rows[] = {
#define MPM_BODY_QUANTITY(name, how, of, unit, nc, asked) {#name, unit, how, MPM_SHOWS_##of, nc, asked},
#include "results/measures.def"
};
#define NROWS ((PetscInt)(sizeof rows / sizeof rows[0]))

enum { /* the components of the quantities of particles */
#define MPM_PARTICLE_QUANTITY(name, uses, word, unit, components, nc, whole, needs, reads) NC_##name = nc,
#include "results/diagnostics.def"
};
#define MPM_BODY_QUANTITY(name, how, of, unit, nc, asked)                                                              \
  _Static_assert((nc) == NC_##of && (nc) <= 3, #name " has the components of " #of ", at most 3");
#include "results/measures.def"

/* Returns how many columns a row has, of its components first .. first+n-1. */
static PetscInt Columns(PetscInt row, const MPMCore *core, PetscInt *first)
{
  return MPMDiagnosticAxes(rows[row].of, core->grid.dim, first);
}

/* Returns whether the law of a body turns work into heat, as laws with history do, of fluids those with viscosity. */
static PetscBool Heats(const MPMScene *scene, PetscInt body)
{
  const MPMMaterial *m = &scene->materials[scene->bodies[body].material];

  if (m->type->traits & MPM_FLUID) return m->viscosity > 0;
  return m->type->law->update[0] ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the name of body b of those with particles, then the rigid ones. */
static const char *NameOf(const MPMScene *scene, const MPMCore *core, PetscInt b)
{
  return b < scene->nbodies ? scene->bodies[b].name : core->rigids.body[b - scene->nbodies].name;
}

/* Reads -history_bodies. */
static PetscErrorCode ReadBodies(MPMMeasures *m, const MPMScene *scene, const MPMCore *core, MPMOptions o)
{
  const PetscInt all                = scene->nbodies + core->rigids.n;
  char           text[MPM_TEXT_LEN] = "", list[MPM_TEXT_LEN] = "", *save = NULL;
  PetscBool      set, *asked;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "history_bodies", NULL, text, &set));
  if (!set || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(all, &asked));
  for (PetscInt b = 0; b < all; b++) MPMAppend(list, sizeof list, "%s%s", b ? "," : "", NameOf(scene, core, b));
  for (char *w = strtok_r(text, ", ", &save); w; w = strtok_r(NULL, ", ", &save)) {
    PetscBool any = PETSC_FALSE;

    for (PetscInt b = 0; b < all; b++) {
      if (strcmp(w, "all") && strcmp(w, NameOf(scene, core, b))) continue;
      asked[b] = any = PETSC_TRUE;
    }
    if (!any)
      MPMOptionsFail(o, "-history_bodies %.*s: choose all, or a list of the bodies %.*s", MPM_NAME_LEN, w,
                     MPM_TEXT_LEN / 2, list);
  }
  PetscCall(PetscMalloc1(scene->nbodies, &m->body));
  PetscCall(PetscMalloc1(PetscMax(1, core->rigids.n), &m->rigid));
  for (PetscInt b = 0; b < all; b++) {
    if (asked[b] && b < scene->nbodies) m->body[m->nbodies++] = b;
    if (asked[b] && b >= scene->nbodies) m->rigid[m->nrigids++] = b - scene->nbodies;
  }
  if (!m->nbodies && !m->nrigids)
    MPMOptionsFail(o, "-history_bodies names no body: choose all, or a list of %.*s", MPM_TEXT_LEN / 2, list);
  PetscCall(PetscFree(asked));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -history_body_quantities; without it a body has all that need not be asked for. heats: a body that is asked for
   has some. */
static PetscErrorCode ReadQuantities(MPMMeasures *m, PetscBool heats, MPMOptions o)
{
  char      text[MPM_TEXT_LEN] = "", list[MPM_TEXT_LEN] = "", *save = NULL;
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "history_body_quantities", NULL, text, &set));
  for (PetscInt k = 0; k < NROWS; k++) {
    if (!rows[k].asked && !set) m->quantities |= (PetscInt)1 << k;
    MPMAppend(list, sizeof list, "%s%s", k ? "," : "", rows[k].name);
  }
  if (set && !m->nbodies)
    MPMOptionsFail(o, "-history_body_quantities does not apply: -history_bodies names no body with particles");
  for (char *w = strtok_r(text, ", ", &save); w && set; w = strtok_r(NULL, ", ", &save)) {
    PetscInt k = 0;

    if (!strcmp(w, "all")) {
      for (k = 0; k < NROWS; k++)
        if (rows[k].how != LOST || heats) m->quantities |= (PetscInt)1 << k;
      continue;
    }
    while (k < NROWS && strcmp(w, rows[k].name)) k++;
    if (k == NROWS)
      MPMOptionsFail(o, "-history_body_quantities %.*s: choose among %s", MPM_NAME_LEN, w, list);
    else
      m->quantities |= (PetscInt)1 << k;
  }
  if (!m->quantities) MPMOptionsFail(o, "-history_body_quantities names none: choose among %s", list);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMBodiesSetFromOptions(MPMMeasures *m, const MPMScene *scene, MPMCore *core, MPMOptions o)
{
  PetscBool heats = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(ReadBodies(m, scene, core, o));
  for (PetscInt b = 0; b < m->nbodies; b++)
    if (Heats(scene, m->body[b])) heats = PETSC_TRUE;
  if (!MPMOptionsError(o)) PetscCall(ReadQuantities(m, heats, o));
  if (m->nrigids && !MPMOptionsError(o)) PetscCall(MPMRigidsAddColumns(m, core));
  if (!m->nbodies || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  m->first_body = m->n;
  for (PetscInt b = 0; b < m->nbodies; b++) {
    const char *name = scene->bodies[m->body[b]].name;

    for (PetscInt k = 0; k < NROWS; k++) {
      PetscInt        first;
      const PetscInt  n       = Columns(k, core, &first);
      const PetscBool extreme = (PetscBool)(rows[k].how == LEAST || rows[k].how == MOST);

      for (PetscInt c = first; c < first + n && m->quantities & (PetscInt)1 << k; c++) {
        const char axis[2] = {"xyz"[c], 0};

        PetscCall(MPMMeasuresAdd(m, rows[k].name, name, rows[k].nc > 1 ? axis : "", rows[k].unit,
                                 rows[k].how == NUMBER || (extreme && MPMDiagnostics[rows[k].of].whole)));
      }
      if (m->quantities & (PetscInt)1 << k) m->shown |= (PetscInt64)1 << rows[k].of;
      if (rows[k].how == LOST && m->quantities & (PetscInt)1 << k) m->heat = PETSC_TRUE;
    }
  }
  if (m->heat && !heats)
    MPMOptionsFail(o, "-history_body_quantities dissipation does not apply: the laws of these bodies store all work");
  if (m->heat) PetscCall(MPMEnergyHeat(&core->energy, m->nbodies));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Selects the particles of a body; each counts once, or with `massive` as its mass. */
static PetscErrorCode Select(const MPMBody *body, const MPMCore *core, const MPMView *view, PetscBool massive,
                             MPMSelected *s)
{
  PetscFunctionBeginUser;
  PetscCall(MPMSelectedCreate(s, view));
  for (PetscInt p = 0; p < view->n; p++)
    if (view->id[p] >= body->first && view->id[p] < body->first + body->n)
      MPMSelectedAdd(s, p, massive ? MPMKindOf(core->params.kinds, view, p)->m : 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets out [3] to the sum of a quantity over the selected particles, and *all to that of their weights. */
static PetscErrorCode Sum(const MPMSelected *s, const MPMCore *core, const MPMShown *shown, const MPMView *view,
                          PetscInt of, PetscReal out[], PetscReal *all)
{
  MPMSum sum[4];

  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < 4; c++) MPMSumZero(&sum[c]);
  PetscCall(MPMSelectedSum(s, shown, view, of, sum, &sum[3], NULL));
  PetscCall(MPMSumReduce(sum, 4, core->exchange.data));
  for (PetscInt c = 0; c < 3; c++) out[c] = MPMSumValue(&sum[c]);
  *all = MPMSumValue(&sum[3]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets out [3] to the extremes of a quantity of the selected particles, or to its quantiles by their weights; nan if
   there are none. */
static PetscErrorCode Extreme(const MPMSelected *s, const MPMCore *core, const MPMShown *shown, const MPMView *view,
                              PetscInt of, PetscReal sign, PetscReal share, PetscReal out[])
{
  PetscFunctionBeginUser;
  if (share < 1)
    PetscCall(MPMSelectedQuantile(s, shown, view, of, sign, share, core->exchange.data, out));
  else
    PetscCall(MPMSelectedLeast(s, shown, view, of, sign, core->exchange.data, out));
  for (PetscInt c = 0; c < 3; c++) out[c] = out[c] < PETSC_MAX_REAL ? sign * out[c] + 0 : (PetscReal)NAN; /* no -0 */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets out [3] to a row of body b of those that are asked for; nan where a body without particles has no value.
   Collective on exchange.data. */
static PetscErrorCode Row(const MPMMeasures *m, MPMCore *core, const MPMShown *shown, PetscInt row, PetscInt b,
                          PetscReal out[])
{
  const PetscInt of  = rows[row].of;
  const How      how = rows[row].how;
  MPMSum         lost;
  MPMView        view;
  MPMSelected    s;
  PetscReal      all = 0;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, -1, &view));
  PetscCall(Select(&shown->scene->bodies[m->body[b]], core, &view,
                   (PetscBool)(how == MEAN || how == BACK || how == FRONT), &s));
  switch (how) {
  case LEAST:
  case MOST:
    PetscCall(Extreme(&s, core, shown, &view, of, how == MOST ? -1 : 1, 1, out));
    break;
  case BACK:
  case FRONT:
    PetscCall(Extreme(&s, core, shown, &view, of, how == BACK ? -1 : 1, AHEAD, out));
    break;
  case SUM:
  case NUMBER:
  case MEAN:
    PetscCall(Sum(&s, core, shown, &view, of, out, &all));
    if (how == NUMBER) out[0] = all;
    for (PetscInt c = 0; c < 3 && how == MEAN; c++) out[c] = all > 0 ? out[c] / all : (PetscReal)NAN;
    break;
  case LOST:
    lost = core->energy.heat[b];
    PetscCall(MPMSumReduce(&lost, 1, core->exchange.data));
    out[0] = MPMSumValue(&lost);
    break;
  }
  PetscCall(MPMSelectedDestroy(&s));
  PetscCall(MPMParticlesRestoreView(&core->particles, -1, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMBodiesCompute(MPMMeasures *m, MPMCore *core, const MPMScene *scene)
{
  const PetscInt n  = 3 * m->nbodies;
  PetscInt       at = m->first_body;
  PetscReal     *value; /* [NROWS][nbodies][3] */
  MPMShown       shown;

  PetscFunctionBeginUser;
  PetscCall(MPMShownBegin(scene, core, m->shown, &shown));
  PetscCall(PetscMalloc1(n * NROWS, &value));
  for (PetscInt k = 0; k < NROWS; k++)
    for (PetscInt b = 0; b < m->nbodies && m->quantities & (PetscInt)1 << k; b++)
      PetscCall(Row(m, core, &shown, k, b, value + n * k + 3 * b));
  for (PetscInt b = 0; b < m->nbodies; b++)
    for (PetscInt k = 0; k < NROWS; k++) {
      PetscInt       first;
      const PetscInt nc = Columns(k, core, &first);

      for (PetscInt c = first; c < first + nc && m->quantities & (PetscInt)1 << k; c++)
        m->value[at++] = value[n * k + 3 * b + c];
    }
  PetscCall(PetscFree(value));
  PetscCall(MPMShownEnd(&shown));
  PetscFunctionReturn(PETSC_SUCCESS);
}
