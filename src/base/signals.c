/* signals.c - the handlers of SIGINT, SIGTERM, SIGHUP and SIGUSR1; signals.h describes their effect. */
#include <signal.h>
#include "base/signals.h"

static volatile sig_atomic_t end, checkpoint;
static PetscBool             ignored; /* SIGHUP, as nohup does it */

static void NoteEnd(int number)
{
  (void)number;
  end = 1;
}

static void NoteCheckpoint(int number)
{
  (void)number;
  checkpoint = 1;
}

void MPMSignalsAsk(void)
{
  checkpoint = 1;
}

/* Returns what signals have asked of this process. A checkpoint is asked for once, the end of the run in each call. Not
   collective. */
PetscInt MPMSignalsAsked(void)
{
  const PetscBool write = checkpoint ? PETSC_TRUE : PETSC_FALSE;

  if (write) checkpoint = 0;
  return end ? MPM_ASKED_END : write ? MPM_ASKED_CHECKPOINT : MPM_ASKED_NOTHING;
}

/* Installs the handlers of the signals that end a run, which note the first one; a second one has its default effect.
   Not collective. */
void MPMSignalsCatch(void)
{
  struct sigaction action;

  memset(&action, 0, sizeof action);
  action.sa_handler = NoteEnd;
  action.sa_flags   = (int)SA_RESETHAND;
  (void)sigaction(SIGINT, &action, NULL);
  (void)sigaction(SIGTERM, &action, NULL);
  if (ignored) {
    action.sa_handler = SIG_IGN; /* PETSc handles it by now */
    action.sa_flags   = 0;
  }
  (void)sigaction(SIGHUP, &action, NULL);
}

/* Installs the handler of SIGUSR1, and notes whether SIGHUP is ignored, before PETSc handles it. Not collective. */
void MPMSignalsStart(void)
{
  struct sigaction action;

  ignored = !sigaction(SIGHUP, NULL, &action) && action.sa_handler == SIG_IGN;
  memset(&action, 0, sizeof action);
  action.sa_handler = NoteCheckpoint;
  action.sa_flags   = SA_RESTART;
  (void)sigaction(SIGUSR1, &action, NULL);
}
