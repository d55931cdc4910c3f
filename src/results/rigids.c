/* rigids.c - rigid bodies as columns of the history (-history_bodies): the rows MPM_RIGID_QUANTITY of measures.def. All
   processes have the same numbers. */
#include "results/measures.h"

/* The mean force of the body on the matter since the last line, N; 0 in the first line, before any step. */
static PetscReal Rigid_reaction(const MPMRigid *r, PetscReal time, PetscInt c)
{
  return time > 0 ? r->impulse[c] / time : 0;
}

/* Its mean torque about the pivot, N m. */
static PetscReal Rigid_torque(const MPMRigid *r, PetscReal time, PetscInt c)
{
  return time > 0 ? r->torque[c] / time : 0;
}

/* The work of the body on the matter since the start, J. */
static PetscReal Rigid_work(const MPMRigid *r, PetscReal time, PetscInt c)
{
  (void)time;
  (void)c;
  return *r->work;
}

/* Where the pivot is, m. */
static PetscReal Rigid_pivot(const MPMRigid *r, PetscReal time, PetscInt c)
{
  (void)time;
  return r->pivot[c] + r->place[c];
}

/* The velocity of the pivot in the last step, m/s. */
static PetscReal Rigid_velocity(const MPMRigid *r, PetscReal time, PetscInt c)
{
  (void)time;
  return r->velocity[c];
}

/* By how much the body has turned about each axis: the integral of its spin, rad. */
static PetscReal Rigid_angle(const MPMRigid *r, PetscReal time, PetscInt c)
{
  (void)time;
  return r->angle[c];
}

static PetscReal Rigid_spin(const MPMRigid *r, PetscReal time, PetscInt c)
{
  (void)time;
  return r->spin[c];
}

static const struct {
  const char *name, *unit;
  PetscInt    nc, axial;
  PetscReal (*value)(const MPMRigid *, PetscReal time, PetscInt c);
} rows[] = {
#define MPM_RIGID_QUANTITY(name, unit, nc, axial) {#name, unit, nc, axial, Rigid_##name},
#include "results/measures.def"
};
#define NROWS ((PetscInt)(sizeof rows / sizeof rows[0]))

/* Returns how many columns a row has, of its components first .. first+n-1. */
static PetscInt Columns(PetscInt row, const MPMGrid *grid, PetscInt *first)
{
  const PetscInt dim = grid->dim;

  *first = rows[row].axial && dim == 2 ? 2 : 0;
  if (rows[row].axial) return dim == 3 ? 3 : grid->round ? 0 : dim - 1;
  return PetscMin(rows[row].nc, dim);
}

PetscErrorCode MPMRigidsAddColumns(MPMMeasures *m, const MPMCore *core)
{
  PetscFunctionBeginUser;
  m->first_rigid = m->n;
  for (PetscInt b = 0; b < m->nrigids; b++)
    for (PetscInt k = 0; k < NROWS; k++) {
      PetscInt       first;
      const PetscInt n = Columns(k, &core->grid, &first);

      for (PetscInt c = first; c < first + n; c++) {
        const char axis[2] = {"xyz"[c], 0};

        PetscCall(MPMMeasuresAdd(m, rows[k].name, core->rigids.body[m->rigid[b]].name, rows[k].nc > 1 ? axis : "",
                                 rows[k].unit, PETSC_FALSE));
      }
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMRigidsCompute(MPMMeasures *m, const MPMCore *core)
{
  const PetscReal time = core->kicked - core->rigids.since;
  PetscInt        at   = m->first_rigid;

  for (PetscInt b = 0; b < m->nrigids; b++)
    for (PetscInt k = 0; k < NROWS; k++) {
      PetscInt       first;
      const PetscInt n = Columns(k, &core->grid, &first);

      for (PetscInt c = first; c < first + n; c++)
        m->value[at++] = rows[k].value(&core->rigids.body[m->rigid[b]], time, c) + 0; /* no -0 */
    }
}
