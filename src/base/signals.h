/* signals.h - SIGINT and SIGTERM: the first ends a run after its current step, with its results written; a second one
   ends it at once. */
#ifndef MPM_SIGNALS_H
#define MPM_SIGNALS_H

#include "base/base.h"

void     MPMSignalsCatch(void);
PetscInt MPMSignalsCaught(void); /* 1 if one came to this process, else 0 */

#endif
