/* signals.h - SIGINT and SIGTERM end a run after the step at work, with its results; a second one ends it at once. */
#ifndef MPM_SIGNALS_H
#define MPM_SIGNALS_H

#include "base/base.h"

void     MPMSignalsCatch(void);
PetscInt MPMSignalsCame(void); /* did one come to this process? */

#endif
