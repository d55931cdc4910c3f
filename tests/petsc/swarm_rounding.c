static char help[] =
    "DMSwarmMigrate() over a DMDA deletes a particle that moves to a place just above the face between subdomains.\n"
    "Run it on 2 processes: mpiexec -n 2 ./swarm_rounding\n";

/* Two subdomains in a row, of 9 and 10 cells along an axis of length 1. The only particle is put into the first and
   moves to the number that follows 9/19, the place of the face. That is in the second subdomain, so one particle is
   expected before the move and one after it. */
#include <petscdmda.h>
#include <petscdmswarm.h>

/* Moves the particle to x, wherever it is, and returns how many particles all processes have after the migration. */
static PetscErrorCode MoveTo(DM swarm, PetscReal x, PetscReal y, PetscInt *total)
{
  PetscReal *coor;
  PetscInt   n;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(swarm, &n));
  PetscCall(DMSwarmGetField(swarm, DMSwarmPICField_coor, NULL, NULL, (void **)&coor));
  for (PetscInt p = 0; p < n; ++p) {
    coor[2 * p]     = x;
    coor[2 * p + 1] = y;
  }
  PetscCall(DMSwarmRestoreField(swarm, DMSwarmPICField_coor, NULL, NULL, (void **)&coor));
  PetscCall(DMSwarmMigrate(swarm, PETSC_TRUE));
  PetscCall(DMSwarmGetSize(swarm, total));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  DM          da, swarm;
  PetscMPIInt rank, size;
  PetscInt    before, after;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCheck(size == 2, PETSC_COMM_WORLD, PETSC_ERR_WRONG_MPI_SIZE, "needs 2 processes");
  PetscCall(DMDACreate2d(PETSC_COMM_WORLD, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DMDA_STENCIL_BOX, 20, 5, 2, 1, 1, 1,
                         NULL, NULL, &da));
  PetscCall(DMSetUp(da));
  PetscCall(DMDASetUniformCoordinates(da, 0., 1., 0., 1., 0., 0.));
  PetscCall(DMCreate(PETSC_COMM_WORLD, &swarm));
  PetscCall(DMSetType(swarm, DMSWARM));
  PetscCall(DMSetDimension(swarm, 2));
  PetscCall(DMSwarmSetType(swarm, DMSWARM_PIC));
  PetscCall(DMSwarmSetCellDM(swarm, da));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm));
  PetscCall(DMSwarmSetLocalSizes(swarm, rank ? 0 : 1, 4));
  PetscCall(MoveTo(swarm, 0.2, 0.4, &before));
  PetscCall(MoveTo(swarm, nextafter(9. / 19, 1.), 0.4, &after));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "PETSc %d.%d.%d: %s: %d particle before the move, %d after it\n",
                        PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR,
                        before == 1 && after == 1 ? "as expected" : "FAULT", (int)before, (int)after));
  PetscCall(DMDestroy(&swarm));
  PetscCall(DMDestroy(&da));
  PetscCall(PetscFinalize());
  return before == 1 && after == 1 ? 0 : 1;
}
