/* begin.c - what volumes of particles depend on at the start of a run (begin.h). */
#include "options/options.h"
#include "scene/begin.h"

PetscErrorCode MPMStartNote(MPMStart *start, const MPMCore *core, const MPMWalls *walls)
{
  PetscBool plain;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsMethodGiven(&plain, NULL));
  *start = (MPMStart){.plain = plain, .total = core->grid.total, .basis = core->basis};
  for (PetscInt k = 0; k < 6; k++) start->wall[k] = walls->given[k / 2][k % 2].type;
  PetscFunctionReturn(PETSC_SUCCESS);
}
