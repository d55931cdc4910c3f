/* message.h - lengths of messages, and room for them. */
#ifndef MPM_MESSAGE_H
#define MPM_MESSAGE_H

#include "base/base.h"

PetscErrorCode MPMMessageLength(size_t bytes, PetscMPIInt *len); /* as MPI takes it, or an error */
PetscErrorCode MPMMessageRoom(char **buffer, size_t *capacity, size_t need);

#endif
