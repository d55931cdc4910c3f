/* found.c - the most of something among the particles of all processes, as the watch of a run finds it (watch.h). */
#include "advice/watch.h"

void MPMFoundTake(MPMFound *f, const MPMFound *other)
{
  if (other->value > f->value || (other->value == f->value && other->key < f->key)) *f = *other;
}

PetscErrorCode MPMFoundAgree(MPMFound *f, MPI_Comm comm)
{
  const PetscReal mine  = f->value;
  PetscInt64      least = INT64_MAX, key = f->key;
  PetscReal       more[7];

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &f->value, 1, MPIU_REAL, MPI_MAX, comm));
  if (mine == f->value && key >= 0) least = key;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPIU_INT64, MPI_MIN, comm));
  f->key = least == INT64_MAX ? -1 : least;
  PetscCall(PetscArraycpy(more, f->x, 3));
  PetscCall(PetscArraycpy(more + 3, f->of, 4));
  for (PetscInt k = 0; k < 7 && key != least; k++) more[k] = 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, more, 7, MPIU_REAL, MPI_SUM, comm)); /* of one process, the others have 0 */
  PetscCall(PetscArraycpy(f->x, more, 3));
  PetscCall(PetscArraycpy(f->of, more + 3, 4));
  PetscFunctionReturn(PETSC_SUCCESS);
}
