/* probes.c - what the history shows at a place or of a particle (-probes): fields of particles, as snapshots have
   them.

   A probe that stays at a place shows the mean over the particles near it, weighted by their mass and by
     W_p = product over the axes of max(0, 1 - |x_p - place|/h).
   Sums are exact. Where no particle that has the field is within a cell size on every axis the values are nan. A probe that goes with a
   particle shows what this has, and where it is; the values are nan once the particle has left the grid. */
#include "results/measures.h"
#include "results/output.h"
#include "results/selected.h"

/* Returns whether a probe shows component c of a field: those of the axes of the scene, of a symmetric tensor each
   once, and its normal components on all axes. */
static PetscBool Shows(PetscInt dim, PetscInt row, PetscInt c)
{
  const PetscInt d = c / 3, e = c % 3;
  PetscInt       first, n;

  if (MPMDiagnostics[row].nc < 9) {
    n = MPMDiagnosticAxes(row, dim, &first);
    return c >= first && c < first + n;
  }
  if (MPMDiagnostics[row].uses & MPM_SHOW_SYMMETRIC) return d == e || (d < e && e < dim);
  return d < dim && e < dim;
}

/* Sets the name of component c of a field, which its row lists. */
static void ComponentName(PetscInt row, PetscInt c, char name[8])
{
  const char *at = MPMDiagnostics[row].components;

  for (PetscInt k = 0; k < c; k++) at = strchr(at, ' ') + 1;
  (void)snprintf(name, 8, "%.*s", (int)strcspn(at, " "), at);
}

/* Reads which fields a probe shows. */
static PetscErrorCode ReadFields(MPMProbe *p, const MPMScene *scene, MPMOptions o)
{
  char     text[MPM_TEXT_LEN] = "", list[MPM_TEXT_LEN] = "", *save = NULL;
  PetscInt has = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nmaterials; k++)
    has |= scene->materials[k].state | MPMMaterialAsked(&scene->materials[k]);
  PetscCall(MPMOptionsString(o, "probe_<p>_fields", p->name, text, NULL));
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++)
    if (MPMDiagnostics[f].word[0] && (!p->stays || !MPMDiagnostics[f].whole))
      MPMAppend(list, sizeof list, "%s%s", list[0] ? "," : "", MPMDiagnostics[f].word);
  for (char *w = strtok_r(text, ", ", &save); w; w = strtok_r(NULL, ", ", &save)) {
    PetscInt f = 0;

    for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS && !strcmp(w, "all"); k++)
      if (MPMDiagnosticIsField(k, has) && MPMDiagnostics[k].word[0] && !(MPMDiagnostics[k].uses & MPM_SHOW_ASKED) &&
          (!p->stays || !MPMDiagnostics[k].whole))
        p->fields |= (PetscInt64)1 << k;
    if (!strcmp(w, "all")) continue;
    while (f < MPM_NUM_DIAGNOSTICS && strcmp(MPMDiagnostics[f].word, w)) f++;
    if (f == MPM_NUM_DIAGNOSTICS)
      MPMOptionsFail(o, "-probe_%s_fields %.*s: choose among %s", p->name, MPM_NAME_LEN, w, list);
    else if (!MPMDiagnosticIsField(f, has))
      MPMOptionsFail(o, "-probe_%s_fields %s: no material of this scene has it", p->name, w);
    else if (p->stays && MPMDiagnostics[f].whole)
      MPMOptionsFail(o,
                     "-probe_%s_fields %s does not apply: it is a number of a particle, and the probe stays at a place",
                     p->name, w);
    else
      p->fields |= (PetscInt64)1 << f;
  }
  if (!p->fields) MPMOptionsFail(o, "-probe_%s_fields names no field: choose among %s", p->name, list);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a probe and adds its columns: where it is, unless it stays at a place, and its fields. */
static PetscErrorCode ReadProbe(MPMMeasures *m, MPMProbe *p, const MPMScene *scene, const MPMCore *core, MPMOptions o)
{
  const PetscInt dim = core->grid.dim;
  char           name[2 * MPM_NAME_LEN];
  PetscInt       id = -1;
  PetscBool      given;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReals(o, "probe_<p>_at", p->name, p->x, &p->stays));
  PetscCall(MPMOptionsInt(o, "probe_<p>_particle", p->name, &id, &given));
  if (!p->stays) PetscCall(MPMOptionsReals(o, "probe_<p>_follow", p->name, p->x, &p->follows));
  if (p->stays + given + p->follows != 1)
    MPMOptionsFail(o, "-probes %s needs one of -probe_%s_at, -probe_%s_follow and -probe_%s_particle", p->name, p->name,
                   p->name, p->name);
  p->id = given ? (PetscInt64)id : -1;
  if (!MPMOptionsError(o)) PetscCall(ReadFields(p, scene, o));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(name, sizeof name, "probe_%s", p->name);
  p->first = m->n;
  for (PetscInt d = 0; d < dim && !p->stays; d++) {
    const char axis[2] = {"xyz"[d], 0};

    PetscCall(MPMMeasuresAdd(m, name, axis, "", "m", PETSC_FALSE));
  }
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++)
    for (PetscInt c = 0; c < MPMDiagnostics[f].nc && p->fields >> f & 1; c++) {
      char component[8] = "";

      if (!Shows(dim, f, c)) continue;
      if (MPMDiagnostics[f].nc > 1) ComponentName(f, c, component);
      PetscCall(MPMMeasuresAdd(m, name, MPMDiagnostics[f].word, component, MPMDiagnostics[f].unit, PETSC_FALSE));
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMProbesSetFromOptions(MPMMeasures *m, const MPMScene *scene, MPMCore *core, MPMOptions o)
{
  PetscFunctionBeginUser;
  m->nprobes = scene->nprobes;
  PetscCall(PetscCalloc1(m->nprobes, &m->probe));
  PetscCall(PetscMalloc1(m->nprobes, &m->ids));
  for (PetscInt k = 0; k < m->nprobes && !MPMOptionsError(o); k++) {
    PetscCall(PetscStrncpy(m->probe[k].name, scene->probes[k], MPM_NAME_LEN));
    PetscCall(ReadProbe(m, &m->probe[k], scene, core, o));
    m->ids[k] = m->probe[k].id;
    m->shown |= m->probe[k].fields;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the particle that is nearest to the place of a probe; of several it is that with the smallest id. Collective on
   exchange.data. */
static PetscErrorCode FindNearest(const MPMProbe *p, MPMCore *core, PetscInt64 *id)
{
  const PetscInt dim = core->grid.dim, fields = MPM_BIT(id) | MPM_BIT(x);
  PetscReal      least = PETSC_MAX_REAL, here = PETSC_MAX_REAL, x[3] = {0};
  PetscInt64     mine = INT64_MAX;
  char           at[128];
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt k = 0; k < view.n; k++) {
    PetscReal r2 = 0;

    for (PetscInt d = 0; d < dim; d++) r2 += PetscSqr(view.x[k * dim + d] - p->x[d]);
    if (r2 > here || (r2 == here && view.id[k] > mine)) continue;
    here = r2;
    mine = view.id[k];
    for (PetscInt d = 0; d < dim; d++) x[d] = view.x[k * dim + d];
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCallMPI(MPI_Allreduce(&here, &least, 1, MPIU_REAL, MPIU_MIN, core->exchange.data));
  if (here > least) mine = INT64_MAX;
  PetscCallMPI(MPI_Allreduce(&mine, id, 1, MPIU_INT64, MPI_MIN, core->exchange.data));
  for (PetscInt d = 0; d < 3; d++)
    if (mine != *id) x[d] = -PETSC_MAX_REAL;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, x, 3, MPIU_REAL, MPIU_MAX, core->exchange.data));
  MPMPlaceWords(dim, x, at);
  PetscCall(MPMPrint(&core->print, "probe      %s follows particle %" PetscInt64_FMT ", which starts at %s m\n",
                     p->name, *id, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the values of a probe that goes with a particle. Collective on exchange.data. */
static PetscErrorCode OfParticle(MPMMeasures *m, MPMProbe *p, MPMCore *core, const MPMShown *shown)
{
  const PetscInt dim = core->grid.dim;
  PetscInt       at  = p->first;
  PetscMPIInt    rank, owner = -1;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  PetscCall(MPMParticlesGetView(&core->particles, -1, &view));
  for (PetscInt d = 0; d < dim; d++) m->value[at++] = (PetscReal)NAN;
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++)
    for (PetscInt c = 0; c < MPMDiagnostics[f].nc && p->fields >> f & 1; c++)
      if (Shows(dim, f, c)) m->value[at++] = (PetscReal)NAN;
  for (PetscInt k = 0; k < view.n; k++) {
    if (view.id[k] != p->id) continue;
    owner = rank;
    at    = p->first;
    for (PetscInt d = 0; d < dim; d++) m->value[at++] = view.x[k * dim + d];
    for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++) {
      PetscReal value[MPM_MAX_COMPONENTS];

      if (!(p->fields >> f & 1)) continue;
      MPMDiagnostics[f].fill(shown, &view, k, value);
      for (PetscInt c = 0; c < MPMDiagnostics[f].nc; c++)
        if (Shows(dim, f, c)) m->value[at++] = value[c];
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, -1, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &owner, 1, MPI_INT, MPI_MAX, core->exchange.data));
  if (owner >= 0)
    PetscCallMPI(MPI_Bcast(m->value + p->first, (PetscMPIInt)(at - p->first), MPIU_REAL, owner, core->exchange.data));
  if (owner < 0 && !p->told) {
    p->told = PETSC_TRUE;
    PetscCall(MPMWarn(&core->print,
                      "probe %s: particle %" PetscInt64_FMT
                      " has left the grid before t=%g s; its columns are nan from here on",
                      p->name, p->id, (double)core->t));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns W_p, the weight of particle p of a view at a place x: hats of one cell on each side of it. */
static PetscReal Weight(const MPMGrid *grid, const MPMView *view, PetscInt p, const PetscReal x[])
{
  PetscReal W = 1;

  for (PetscInt d = 0; d < grid->dim; d++) {
    PetscReal far = PetscAbsReal(view->x[p * grid->dim + d] - x[d]);

    if (grid->periodic[d]) far = PetscMin(far, grid->upper[d] - grid->lower[d] - far);
    W *= PetscMax(0, 1 - far / grid->h[d]);
  }
  return W;
}

/* Sets the values of a probe that stays at a place. Collective on exchange.data. */
static PetscErrorCode OfPlace(MPMMeasures *m, const MPMProbe *p, MPMCore *core, const MPMShown *shown)
{
  const PetscInt dim = core->grid.dim;
  PetscInt       n = 0, at = p->first;
  MPMSum        *sum; /* of each field, and of the weights behind it */
  MPMSelected    near;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((1 + MPM_MAX_COMPONENTS) * MPM_NUM_DIAGNOSTICS, &sum));
  PetscCall(MPMParticlesGetView(&core->particles, -1, &view));
  PetscCall(MPMSelectedCreate(&near, &view));
  for (PetscInt k = 0; k < view.n; k++) {
    const PetscReal W = Weight(&core->grid, &view, k, p->x);

    if (W > 0) MPMSelectedAdd(&near, k, W * MPMKindOf(core->params.kinds, &view, k)->m);
  }
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++) {
    if (!(p->fields >> f & 1)) continue;
    PetscCall(MPMSelectedSum(&near, shown, &view, f, sum + n, sum + n + MPMDiagnostics[f].nc, NULL));
    n += MPMDiagnostics[f].nc + 1;
  }
  PetscCall(MPMSelectedDestroy(&near));
  PetscCall(MPMParticlesRestoreView(&core->particles, -1, &view));
  PetscCall(MPMSumReduce(sum, n, core->exchange.data));
  n = 0;
  for (PetscInt f = 0; f < MPM_NUM_DIAGNOSTICS; f++) {
    if (!(p->fields >> f & 1)) continue;
    for (PetscInt c = 0; c < MPMDiagnostics[f].nc; c++) {
      const PetscReal weight = MPMSumValue(&sum[n + MPMDiagnostics[f].nc]);

      if (Shows(dim, f, c)) m->value[at++] = weight > 0 ? MPMSumValue(&sum[n + c]) / weight : (PetscReal)NAN;
    }
    n += MPMDiagnostics[f].nc + 1;
  }
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMProbesCompute(MPMMeasures *m, MPMCore *core, const MPMScene *scene)
{
  MPMShown   shown;
  PetscInt64 fields = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < m->nprobes; k++) fields |= m->probe[k].fields;
  PetscCall(MPMShownBegin(scene, core, fields, &shown));
  for (PetscInt k = 0; k < m->nprobes; k++) {
    MPMProbe *p = &m->probe[k];

    if (p->follows && m->ids[k] < 0) PetscCall(FindNearest(p, core, &m->ids[k]));
    p->id = m->ids[k];
    PetscCall(p->stays ? OfPlace(m, p, core, &shown) : OfParticle(m, p, core, &shown));
    if (!PetscIsNanReal(m->value[p->first])) p->seen = PETSC_TRUE;
  }
  PetscCall(MPMShownEnd(&shown));
  PetscFunctionReturn(PETSC_SUCCESS);
}
