/* checkpoint.h - a file of the whole state of a run, from which a later run goes on with the same bits. The functions
   are described in checkpoint.c. With a PETSc that has no HDF5 they set a fault. */
#ifndef MPM_CHECKPOINT_H
#define MPM_CHECKPOINT_H

#include "restart/variables.h"
#include "scene/scene.h"

PetscErrorCode MPMCheckpointWrite(const char path[], MPMCore *, const MPMScene *, const MPMVariables *kept,
                                  PetscReal *bytes, char fault[MPM_TEXT_LEN]);
PetscErrorCode MPMCheckpointCheck(const char path[], MPI_Comm, char fault[MPM_TEXT_LEN]);
PetscErrorCode MPMCheckpointRead(const char path[], MPI_Comm, const MPMVariables *kept, char fault[MPM_TEXT_LEN]);
PetscErrorCode MPMCheckpointRows(const char path[], const MPMParticles *, PetscInt field, PetscInt64 first, PetscInt n,
                                 void *rows);
PetscErrorCode MPMCheckpointNodes(const char path[], const MPMGrid *, MPMPatch *);
PetscErrorCode MPMCheckpointOptions(const char path[], char **options, char git[MPM_NAME_LEN]);
PetscErrorCode MPMCheckpointFields(const char path[], MPI_Comm, char names[MPM_TEXT_LEN]);

/* Returns whether a file begins as a checkpoint does. Not collective. */
PetscBool MPMCheckpointIs(const char path[]);

/* Returns whether a checkpoint has the field of particles: it can not be found from others. */
PetscBool MPMCheckpointHasField(PetscInt field);

PetscInt MPMCheckpointNumbers(const MPMParticles *, PetscInt field);

#endif
