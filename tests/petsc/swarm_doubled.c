static char help[] = "DMSwarmMigrate() over a DMDA makes two of a particle on the face between two subdomains.\n"
                     "Run it on 4 processes: mpiexec -n 4 ./swarm_doubled\n";

/* Two by two subdomains. The only particle is put into the first and moves to the face between the second and the
   fourth, which both are adjacent to the first. One particle is expected before the move and one after it. */
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
  PetscCheck(size == 4, PETSC_COMM_WORLD, PETSC_ERR_WRONG_MPI_SIZE, "needs 4 processes");
  PetscCall(DMDACreate2d(PETSC_COMM_WORLD, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DMDA_STENCIL_BOX, 9, 9, 2, 2, 1, 1, NULL,
                         NULL, &da));
  PetscCall(DMSetUp(da));
  PetscCall(DMDASetUniformCoordinates(da, 0., 2., 0., 2., 0., 0.));
  PetscCall(DMCreate(PETSC_COMM_WORLD, &swarm));
  PetscCall(DMSetType(swarm, DMSWARM));
  PetscCall(DMSetDimension(swarm, 2));
  PetscCall(DMSwarmSetType(swarm, DMSWARM_PIC));
  PetscCall(DMSwarmSetCellDM(swarm, da));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm));
  PetscCall(DMSwarmSetLocalSizes(swarm, rank ? 0 : 1, 4));
  PetscCall(MoveTo(swarm, 0.5, 0.5, &before));
  PetscCall(MoveTo(swarm, 1.5, 1.0, &after));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "PETSc %d.%d.%d: %s: %d particle before the move, %d after it\n",
                        PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR,
                        before == 1 && after == 1 ? "as expected" : "FAULT", (int)before, (int)after));
  PetscCall(DMDestroy(&swarm));
  PetscCall(DMDestroy(&da));
  PetscCall(PetscFinalize());
  return before == 1 && after == 1 ? 0 : 1;
}
