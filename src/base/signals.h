/* signals.h - what signals ask of a run. SIGINT, SIGTERM and SIGHUP: the first ends it after its current step, with its
   results and a checkpoint written; a second one ends it at once. SIGUSR1: it writes a checkpoint and goes on. */
#ifndef MPM_SIGNALS_H
#define MPM_SIGNALS_H

#include "base/base.h"

/* What is asked for; the largest of all processes counts. */
enum { MPM_ASKED_NOTHING, MPM_ASKED_CHECKPOINT, MPM_ASKED_END };

void     MPMSignalsStart(void); /* before MPI and PETSc start: catches SIGUSR1, which would end the program */
void     MPMSignalsCatch(void); /* catches SIGINT, SIGTERM and, unless the program was started with nohup, SIGHUP */
void     MPMSignalsAsk(void);   /* asks for a checkpoint as SIGUSR1 does */
PetscInt MPMSignalsAsked(void);

#endif
