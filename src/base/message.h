/* message.h - lengths of messages, and memory for them. */
#ifndef MPM_MESSAGE_H
#define MPM_MESSAGE_H

#include "base/base.h"

PetscErrorCode MPMMessageLength(size_t bytes, PetscMPIInt *len); /* an error if it is no int */
PetscErrorCode MPMMessageRoom(char **buffer, size_t *capacity, size_t need);

#endif
