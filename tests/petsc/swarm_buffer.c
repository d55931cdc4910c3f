static char help[] =
    "DMSwarmRemovePointAtIndex() sets the whole buffer of each field to zero, for each particle removed.\n"
    "Run it on 1 process: mpiexec -n 1 ./swarm_buffer\n";

/* DMSwarmSetLocalSizes() gives fields room for `buffer` more particles. A mark in the last place of that room, which no
   particle uses, is expected to be there after a particle is removed; it tells whether all the room was written. The
   time of a removal, printed for two sizes of the room, is expected not to depend on it. */
#include <petscdmswarm.h>
#include <petsctime.h>

/* Removes particles; returns whether the mark is still there, and the time that one removal takes. */
static PetscErrorCode Remove(PetscInt buffer, PetscBool *marked, PetscLogDouble *time)
{
  const PetscInt n = 1000, removals = 100;
  DM             swarm;
  PetscReal     *field;
  PetscLogDouble start, end;

  PetscFunctionBeginUser;
  PetscCall(DMCreate(PETSC_COMM_SELF, &swarm));
  PetscCall(DMSetType(swarm, DMSWARM));
  PetscCall(DMSetDimension(swarm, 2));
  PetscCall(DMSwarmInitializeFieldRegister(swarm));
  PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "field", 10, PETSC_REAL));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm));
  PetscCall(DMSwarmSetLocalSizes(swarm, n, buffer));
  PetscCall(DMSwarmGetField(swarm, "field", NULL, NULL, (void **)&field));
  field[10 * (n + buffer) - 1] = 1;
  PetscCall(DMSwarmRestoreField(swarm, "field", NULL, NULL, (void **)&field));
  PetscCall(PetscTime(&start));
  for (PetscInt k = 0; k < removals; ++k) PetscCall(DMSwarmRemovePointAtIndex(swarm, 0));
  PetscCall(PetscTime(&end));
  *time = (end - start) / removals;
  PetscCall(DMSwarmGetField(swarm, "field", NULL, NULL, (void **)&field));
  *marked = field[10 * (n + buffer) - 1] == 1 ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(DMSwarmRestoreField(swarm, "field", NULL, NULL, (void **)&field));
  PetscCall(DMDestroy(&swarm));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  PetscBool      marked[2];
  PetscLogDouble time[2];

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCall(Remove(100, &marked[0], &time[0]));
  PetscCall(Remove(100000, &marked[1], &time[1]));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "a removal takes %.2g us with room for 100 particles, %.2g us for 100000\n",
                        1e6 * time[0], 1e6 * time[1]));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "PETSc %d.%d.%d: %s\n", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR,
                        PETSC_VERSION_SUBMINOR,
                        marked[0] && marked[1] ? "as expected: the unused room is as it was"
                                               : "FAULT: the unused room was set to zero by removals"));
  PetscCall(PetscFinalize());
  return marked[0] && marked[1] ? 0 : 1;
}
