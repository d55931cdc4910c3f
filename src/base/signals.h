/* signals.h - what signals ask of a run. SIGINT and SIGTERM: the first ends it after its current step, with its results
   and a checkpoint written; a second one ends it at once. SIGUSR1: it writes a checkpoint and goes on. */
#ifndef MPM_SIGNALS_H
#define MPM_SIGNALS_H

#include "base/base.h"

/* What is asked for; the largest of all processes counts. */
enum { MPM_ASKED_NOTHING, MPM_ASKED_CHECKPOINT, MPM_ASKED_END };

void     MPMSignalsCatchCheckpoint(void); /* SIGUSR1, which would end a program that does not catch it */
void     MPMSignalsCatch(void);           /* SIGINT and SIGTERM */
void     MPMSignalsAsk(void);             /* asks for a checkpoint as SIGUSR1 does */
PetscInt MPMSignalsAsked(void);

#endif
