/* refill.c - fields of particles that a checkpoint does not have and that a changed scene needs: each particle gets
   what the one of its id starts with, such as its place at the start or how deep it is in its body. */
#include "restart/restart.h"
#include "results/rows.h"

#if defined(PETSC_HAVE_HDF5)

/* Returns the numbers of a field of a particle, and reads or sets them, as real numbers, which hold them all. */
static PetscInt Numbers(const MPMParticles *p, PetscInt field)
{
  return p->bytes[field] / (PetscInt)(MPMFields[field].type == PETSC_INT ? sizeof(PetscInt) : sizeof(PetscReal));
}

static PetscReal Get(PetscInt field, const void *rows, PetscInt k)
{
  return MPMFields[field].type == PETSC_INT ? (PetscReal)((const PetscInt *)rows)[k] : ((const PetscReal *)rows)[k];
}

static void Set(PetscInt field, void *rows, PetscInt k, PetscReal value)
{
  if (MPMFields[field].type == PETSC_INT)
    ((PetscInt *)rows)[k] = (PetscInt)value;
  else
    ((PetscReal *)rows)[k] = value;
}

/* Makes the rows of all ids that the scene begins with, of which this process has those of its particles. Collective on
   exchange.data. */
static PetscErrorCode MakeRows(MPMCore *core, MPMRows *rows)
{
  PetscInt *row;
  MPMView   view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(id), &view));
  PetscCall(PetscMalloc1(PetscMax(1, view.n), &row));
  for (PetscInt p = 0; p < view.n; p++) row[p] = (PetscInt)view.id[p];
  PetscCall(MPMRowsCreate(core->exchange.data, (PetscInt)core->particles.born, view.n, row, rows));
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(id), &view));
  PetscCall(PetscFree(row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRefillBegin(MPMCheckpoint *c, PetscReal *kept[])
{
  MPMCore      *core = c->core;
  MPMParticles *p    = &core->particles;
  MPMRows       rows;

  PetscFunctionBeginUser;
  PetscCall(MPMSceneAddParticles(c->scene, core));
  PetscCall(MPMPointsAdd(c->scene, core));
  PetscCall(MakeRows(core, &rows));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const PetscInt nc = Numbers(p, f);
    PetscReal     *here;
    void          *field;

    if (!(c->missing >> f & 1)) continue;
    PetscCall(PetscMalloc1(PetscMax(1, p->n * nc), &here));
    PetscCall(PetscMalloc1(PetscMax(1, rows.n * nc), &kept[f]));
    PetscCall(MPMParticlesGetField(p, f, &field));
    for (PetscInt k = 0; k < p->n * nc; k++) here[k] = Get(f, field, k);
    PetscCall(MPMParticlesRestoreField(p, f));
    PetscCall(MPMRowsSend(&rows, nc, here, kept[f]));
    PetscCall(PetscFree(here));
  }
  PetscCall(PetscSFDestroy(&rows.sf));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRefillEnd(MPMCheckpoint *c, PetscReal *kept[])
{
  MPMCore      *core = c->core;
  MPMParticles *p    = &core->particles;
  MPMRows       rows;

  PetscFunctionBeginUser;
  PetscCall(MakeRows(core, &rows));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const PetscInt nc = Numbers(p, f);
    MPI_Datatype   unit;
    PetscReal     *here;
    void          *field;

    if (!(c->missing >> f & 1)) continue;
    PetscCall(PetscMalloc1(PetscMax(1, p->n * nc), &here));
    PetscCallMPI(MPI_Type_contiguous((PetscMPIInt)nc, MPIU_REAL, &unit));
    PetscCallMPI(MPI_Type_commit(&unit));
    PetscCall(PetscSFBcastBegin(rows.sf, unit, kept[f], here, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(rows.sf, unit, kept[f], here, MPI_REPLACE));
    PetscCallMPI(MPI_Type_free(&unit));
    PetscCall(MPMParticlesGetField(p, f, &field));
    for (PetscInt k = 0; k < p->n * nc; k++) Set(f, field, k, here[k]);
    PetscCall(MPMParticlesRestoreField(p, f));
    PetscCall(PetscFree(here));
    PetscCall(PetscFree(kept[f]));
  }
  PetscCall(PetscSFDestroy(&rows.sf));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else

PetscErrorCode MPMRefillBegin(MPMCheckpoint *c, PetscReal *kept[])
{
  PetscFunctionBeginUser;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRefillEnd(MPMCheckpoint *c, PetscReal *kept[])
{
  PetscFunctionBeginUser;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#endif
