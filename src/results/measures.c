/* measures.c - the columns of the history that one asks for, which are read before the first step and computed for each
   line; those of walls are made here, those of bodies and probes in bodies.c and probes.c. */
#include "results/measures.h"
#include "step/step.h"

/* --- Walls -------------------------------------------------------------------------------------------------------- */

/* The mean force of the wall of a face on the matter since the last line, N; 0 in the first line, before any step. */
static PetscReal Wall_reaction(const MPMCore *core, MPMSum sum[4], PetscInt c)
{
  const PetscReal time = core->kicked - core->reactions->since;

  return time > 0 ? MPMSumValue(&sum[c]) / time : 0;
}

/* The work of the wall on the matter since the start, J. */
static PetscReal Wall_work(const MPMCore *core, MPMSum sum[4], PetscInt c)
{
  (void)core;
  (void)c;
  return MPMSumValue(&sum[3]);
}

static const struct {
  const char *name, *unit;
  PetscInt    nc;
  PetscReal (*value)(const MPMCore *, MPMSum sum[4], PetscInt c);
} quantities[] = {
#define MPM_WALL_QUANTITY(name, unit, nc) {#name, unit, nc, Wall_##name},
#include "results/measures.def"
};
#define NQUANTITIES (sizeof quantities / sizeof quantities[0])

/* Returns whether a face of the grid has a wall. */
static PetscBool IsWall(const MPMScene *scene, PetscInt face)
{
  return !MPMWallHas(scene->walls.given[face / 2][face % 2].type, MPM_WALL_OPEN);
}

/* Reads -history_walls and adds the columns. */
static PetscErrorCode ReadWalls(MPMMeasures *m, const MPMScene *scene, MPMCore *core, MPMOptions o)
{
  const PetscInt dim                = core->grid.dim;
  char           text[MPM_TEXT_LEN] = "", given[MPM_TEXT_LEN], list[MPM_TEXT_LEN] = "", *save = NULL;
  PetscBool      set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "history_walls", NULL, text, &set));
  if (!set || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(given, sizeof given, "%s", text);
  for (PetscInt k = 0; k < 2 * dim; k++)
    if (IsWall(scene, k)) MPMAppend(list, sizeof list, "%s%s", list[0] ? "," : "", MPMFaceNames[k]);
  if (!list[0]) MPMOptionsFail(o, "-history_walls does not apply: no face of the grid has a wall (-bc_<face>_type)");
  for (char *w = strtok_r(text, ", ", &save); w && !MPMOptionsError(o); w = strtok_r(NULL, ", ", &save)) {
    const PetscInt before = m->faces;

    for (PetscInt k = 0; k < 2 * dim; k++)
      if (IsWall(scene, k) && (!strcmp(w, "all") || !strcmp(w, MPMFaceNames[k]))) m->faces |= (PetscInt)1 << k;
    if (m->faces == before)
      MPMOptionsFail(o, "-history_walls %.*s: choose all, or a list of the faces that have a wall, each once: %s",
                     MPM_NAME_LEN, given, list);
  }
  if (!m->faces && !MPMOptionsError(o))
    MPMOptionsFail(o, "-history_walls names no face: choose all, or a list of %s", list);
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2 * dim; k++)
    for (size_t q = 0; q < NQUANTITIES && m->faces & (PetscInt)1 << k; q++)
      for (PetscInt c = 0; c < PetscMin(quantities[q].nc, dim); c++) {
        const char axis[2] = {"xyz"[c], 0};

        PetscCall(MPMMeasuresAdd(m, quantities[q].name, MPMFaceNames[k], quantities[q].nc > 1 ? axis : "",
                                 quantities[q].unit, PETSC_FALSE));
      }
  PetscCall(MPMReactionsCreate(core, m->faces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the columns of walls, the first of all. Collective on exchange.data. */
static PetscErrorCode Walls(MPMMeasures *m, const MPMCore *core)
{
  PetscInt at = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 6; k++) {
    MPMSum sum[4];

    if (!(m->faces & (PetscInt)1 << k)) continue;
    PetscCall(PetscArraycpy(sum, core->reactions->impulse[k], 3));
    sum[3] = core->reactions->work[k];
    PetscCall(MPMSumReduce(sum, 4, core->exchange.data));
    for (size_t q = 0; q < NQUANTITIES; q++)
      for (PetscInt c = 0; c < PetscMin(quantities[q].nc, core->grid.dim); c++)
        m->value[at++] = quantities[q].value(core, sum, c);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- All ---------------------------------------------------------------------------------------------------------- */

PetscErrorCode MPMMeasuresSetFromOptions(MPMMeasures *m, const MPMScene *scene, MPMCore *core, MPMOptions o)
{
  PetscFunctionBeginUser;
  PetscCall(ReadWalls(m, scene, core, o));
  PetscCall(MPMBodiesSetFromOptions(m, scene, core, o));
  PetscCall(MPMProbesSetFromOptions(m, scene, core, o));
  for (PetscInt k = 0; k < m->n && !MPMOptionsError(o); k++)
    if (MPMMeasuresFind(m, m->column[k].name) != k)
      MPMOptionsFail(o, "two columns of the history would have the name %s; rename a body or a probe",
                     m->column[k].name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMMeasuresNumber(const MPMMeasures *m, const MPMScene *scene, MPMCore *core, MPMOptions o)
{
  for (PetscInt b = 0; b < core->energy.nheat; b++) {
    core->energy.ids[2 * b]     = scene->bodies[m->body[b]].first;
    core->energy.ids[2 * b + 1] = scene->bodies[m->body[b]].first + scene->bodies[m->body[b]].n;
  }
  for (PetscInt k = 0; k < m->nprobes; k++)
    if (m->probe[k].id >= core->particles.total)
      MPMOptionsFail(o, "-probe_%s_particle %" PetscInt64_FMT ": the particles of this scene are 0 to %" PetscInt64_FMT,
                     m->probe[k].name, m->probe[k].id, core->particles.total - 1);
  for (PetscInt k = 0; k < m->nprobes; k++) {
    const MPMProbe *p = &m->probe[k];

    for (PetscInt d = 0; d < core->grid.dim && (p->stays || p->follows); d++)
      if (!(p->x[d] >= core->grid.lower[d] && p->x[d] <= core->grid.upper[d]))
        MPMOptionsFail(o, "-probe_%s_%s: %g lies outside of the grid, which is from %g to %g on axis %c", p->name,
                       p->stays ? "at" : "follow", (double)p->x[d], (double)core->grid.lower[d],
                       (double)core->grid.upper[d], "xyz"[d]);
  }
}

PetscErrorCode MPMMeasuresCompute(MPMMeasures *m, MPMCore *core, const MPMScene *scene)
{
  PetscFunctionBeginUser;
  if (m->faces) PetscCall(Walls(m, core));
  if (m->nbodies) PetscCall(MPMBodiesCompute(m, core, scene));
  MPMRigidsCompute(m, core);
  if (m->nprobes) PetscCall(MPMProbesCompute(m, core, scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMMeasuresLine(MPMMeasures *m, MPMCore *core)
{
  core->rigids.since = core->kicked;
  for (PetscInt k = 0; k < core->rigids.n; k++)
    for (PetscInt d = 0; d < 3; d++) {
      if (core->rigids.body[k].impulse[d] != 0) core->rigids.body[k].met = PETSC_TRUE;
      core->rigids.body[k].impulse[d] = core->rigids.body[k].torque[d] = 0;
    }
  if (!m->faces) return;
  core->reactions->since = core->kicked;
  for (PetscInt k = 0; k < 18; k++) MPMSumZero(&core->reactions->impulse[k / 3][k % 3]);
}

PetscErrorCode MPMMeasuresDestroy(MPMMeasures *m)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(m->column));
  PetscCall(PetscFree(m->value));
  PetscCall(PetscFree(m->body));
  PetscCall(PetscFree(m->rigid));
  PetscCall(PetscFree(m->probe));
  PetscCall(PetscFree(m->ids));
  PetscFunctionReturn(PETSC_SUCCESS);
}
