static char help[] =
    "DMSwarmMigrate() over a 3-D DMDA whose stencil is wider than 1 deletes particles inside the domain.\n"
    "Run it on 2 processes: mpiexec -n 2 ./swarm_stencil\n";

/* 8 x 8 x 8 cells, a particle in the middle of each. The first process makes them all; the migration has to send half
   of them to the second. 512 particles are expected after it. */
#include <petscdmda.h>
#include <petscdmswarm.h>

int main(int argc, char **argv)
{
  enum { CELLS = 8, ALL = CELLS * CELLS * CELLS };
  DM          da, swarm;
  PetscMPIInt rank, size;
  PetscInt    total;
  PetscReal  *coor;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCheck(size == 2, PETSC_COMM_WORLD, PETSC_ERR_WRONG_MPI_SIZE, "needs 2 processes");
  PetscCall(DMDACreate3d(PETSC_COMM_WORLD, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DM_BOUNDARY_NONE, DMDA_STENCIL_BOX,
                         CELLS + 1, CELLS + 1, CELLS + 1, 2, 1, 1, 1, 2, NULL, NULL, NULL, &da));
  PetscCall(DMSetUp(da));
  PetscCall(DMDASetUniformCoordinates(da, 0., 1., 0., 1., 0., 1.));
  PetscCall(DMCreate(PETSC_COMM_WORLD, &swarm));
  PetscCall(DMSetType(swarm, DMSWARM));
  PetscCall(DMSetDimension(swarm, 3));
  PetscCall(DMSwarmSetType(swarm, DMSWARM_PIC));
  PetscCall(DMSwarmSetCellDM(swarm, da));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm));
  PetscCall(DMSwarmSetLocalSizes(swarm, rank ? 0 : ALL, 4));
  PetscCall(DMSwarmGetField(swarm, DMSwarmPICField_coor, NULL, NULL, (void **)&coor));
  for (PetscInt p = 0; !rank && p < ALL; ++p) {
    coor[3 * p]     = (p % CELLS + 0.5) / CELLS;
    coor[3 * p + 1] = (p / CELLS % CELLS + 0.5) / CELLS;
    coor[3 * p + 2] = (p / CELLS / CELLS + 0.5) / CELLS;
  }
  PetscCall(DMSwarmRestoreField(swarm, DMSwarmPICField_coor, NULL, NULL, (void **)&coor));
  PetscCall(DMSwarmMigrate(swarm, PETSC_TRUE));
  PetscCall(DMSwarmGetSize(swarm, &total));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "PETSc %d.%d.%d: %s: %d particles before the migration, %d after it\n",
                        PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR,
                        total == ALL ? "as expected" : "FAULT", ALL, (int)total));
  PetscCall(DMDestroy(&swarm));
  PetscCall(DMDestroy(&da));
  PetscCall(PetscFinalize());
  return total == ALL ? 0 : 1;
}
