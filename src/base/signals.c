/* signals.c - see signals.h. */
#include <signal.h>
#include "base/signals.h"

static volatile sig_atomic_t came;

static void Note(int number)
{
  (void)number;
  came = 1;
}

PetscInt MPMSignalsCame(void)
{
  return came;
}

void MPMSignalsCatch(void)
{
  struct sigaction action;

  memset(&action, 0, sizeof action);
  action.sa_handler = Note;
  action.sa_flags   = (int)SA_RESETHAND;
  (void)sigaction(SIGINT, &action, NULL);
  (void)sigaction(SIGTERM, &action, NULL);
}
