static char help[] =
    "DMSwarmMigrate() of a DMSWARM_BASIC swarm makes many collective operations, even if nothing moves.\n"
    "Run it on 2 processes: mpiexec -n 2 ./swarm_collectives\n";

/* Functions with the names of MPI's count their calls and call MPI's profiling names. A process has to learn who sends
   to it; PetscCommBuildTwoSided() finds that out with one non-blocking barrier. So one operation is expected; five are
   still taken as such. PMPI_Comm_dup() is counted, since all processes have to agree on the new communicator. */
#include <petscdmswarm.h>

static int reductions, others;

/* Has the communicator more than one process? Operations within one process cost nothing. */
static int Several(MPI_Comm c)
{
  int size;

  return !PMPI_Comm_size(c, &size) && size > 1;
}

#define COUNT(which, name, parameters, ...)                                                                            \
  int(MPI_##name) parameters                                                                                           \
  {                                                                                                                    \
    if (Several(c)) ++which;                                                                                           \
    return PMPI_##name(__VA_ARGS__);                                                                                   \
  }
COUNT(reductions, Allreduce, (const void *s, void *r, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), s, r, n, t, o, c)
COUNT(reductions, Reduce_scatter_block, (const void *s, void *r, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), s, r, n,
      t, o, c)
COUNT(reductions, Exscan, (const void *s, void *r, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), s, r, n, t, o, c)
COUNT(others, Allgather, (const void *s, int n, MPI_Datatype t, void *r, int m, MPI_Datatype u, MPI_Comm c), s, n, t, r,
      m, u, c)
COUNT(others, Alltoall, (const void *s, int n, MPI_Datatype t, void *r, int m, MPI_Datatype u, MPI_Comm c), s, n, t, r,
      m, u, c)
COUNT(others, Bcast, (void *b, int n, MPI_Datatype t, int k, MPI_Comm c), b, n, t, k, c)
COUNT(others, Barrier, (MPI_Comm c), c)
COUNT(others, Ibarrier, (MPI_Comm c, MPI_Request *q), c, q)
COUNT(others, Comm_dup, (MPI_Comm c, MPI_Comm *d), c, d)

/* Migrates; `leaves` says whether a particle of each process goes to the other. Prints and returns the calls. */
static PetscErrorCode Migrate(DM swarm, PetscBool leaves, int *calls)
{
  PetscMPIInt rank;
  PetscInt   *owner;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(DMSwarmGetField(swarm, DMSwarmField_rank, NULL, NULL, (void **)&owner));
  for (PetscInt p = 0; p < 10; ++p) owner[p] = leaves && !p ? 1 - rank : rank;
  PetscCall(DMSwarmRestoreField(swarm, DMSwarmField_rank, NULL, NULL, (void **)&owner));
  reductions = others = 0;
  PetscCall(DMSwarmMigrate(swarm, PETSC_TRUE));
  *calls = reductions + others;
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s: %d reductions, %d others\n",
                        leaves ? "a particle leaves each process" : "no particle leaves", reductions, others));
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  DM          swarm;
  PetscMPIInt size;
  int         calls[3], most;

  PetscCall(PetscInitialize(&argc, &argv, NULL, help));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  PetscCheck(size == 2, PETSC_COMM_WORLD, PETSC_ERR_WRONG_MPI_SIZE, "needs 2 processes");
  PetscCall(DMCreate(PETSC_COMM_WORLD, &swarm));
  PetscCall(DMSetType(swarm, DMSWARM));
  PetscCall(DMSetDimension(swarm, 2));
  PetscCall(DMSwarmInitializeFieldRegister(swarm));
  PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "x", 2, PETSC_REAL));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm));
  PetscCall(DMSwarmSetLocalSizes(swarm, 10, 10));
  for (int k = 0; k < 3; ++k) PetscCall(Migrate(swarm, k == 2 ? PETSC_TRUE : PETSC_FALSE, &calls[k]));
  most = PetscMax(calls[1], calls[2]); /* the first migration is not judged: it may set something up */
  PetscCheck(most, PETSC_COMM_WORLD, PETSC_ERR_LIB, "nothing was counted: this MPI needs other names here");
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "PETSc %d.%d.%d: %s: %d collective operations a migration\n",
                        PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR,
                        most > 5 ? "FAULT" : "as expected", most));
  PetscCall(DMDestroy(&swarm));
  PetscCall(PetscFinalize());
  return most > 5 ? 1 : 0;
}
