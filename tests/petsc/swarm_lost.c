static char help[] =
    "DMSwarmMigrate() over a DMDA deletes a particle that moves farther than to an adjacent subdomain.\n"
    "Run it on 3 processes: mpiexec -n 3 ./swarm_lost\n";

/* Three subdomains in a row. The only particle is put into the first and moves into the third. It stays inside the
   domain, so one particle is expected before the move and one after it. */
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
  PetscCheck(size == 3, PETSC_COMM_WORLD, PETSC_ERR_WRONG_MPI_SIZE, "needs 3 processes");
  PetscCall(DMDACreate2d(PETSC_COMM_WORLD, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DMDA_STENCIL_BOX, 13, 5, 3, 1, 1, 1,
                         NULL, NULL, &da));
  PetscCall(DMSetUp(da));
  PetscCall(DMDASetUniformCoordinates(da, 0., 3., 0., 1., 0., 0.));
  PetscCall(DMCreate(PETSC_COMM_WORLD, &swarm));
  PetscCall(DMSetType(swarm, DMSWARM));
  PetscCall(DMSetDimension(swarm, 2));
  PetscCall(DMSwarmSetType(swarm, DMSWARM_PIC));
  PetscCall(DMSwarmSetCellDM(swarm, da));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm));
  PetscCall(DMSwarmSetLocalSizes(swarm, rank ? 0 : 1, 4));
  PetscCall(MoveTo(swarm, 0.5, 0.5, &before));
  PetscCall(MoveTo(swarm, 2.5, 0.5, &after));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "PETSc %d.%d.%d: %s: %d particle before the move, %d after it\n",
                        PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR,
                        before == 1 && after == 1 ? "as expected" : "FAULT", (int)before, (int)after));
  PetscCall(DMDestroy(&swarm));
  PetscCall(DMDestroy(&da));
  PetscCall(PetscFinalize());
  return before == 1 && after == 1 ? 0 : 1;
}
