/* signals.c - the handler of SIGINT and SIGTERM; signals.h describes its effect. */
#include <signal.h>
#include "base/signals.h"

static volatile sig_atomic_t came;

static void Note(int number)
{
  (void)number;
  came = 1;
}

/* Returns 1 if this process has caught a signal, else 0. Not collective. */
PetscInt MPMSignalsCaught(void)
{
  return came;
}

/* Installs the handler, which notes the first signal; a second one has its default effect. Not collective. */
void MPMSignalsCatch(void)
{
  struct sigaction action;

  memset(&action, 0, sizeof action);
  action.sa_handler = Note;
  action.sa_flags   = (int)SA_RESETHAND;
  (void)sigaction(SIGINT, &action, NULL);
  (void)sigaction(SIGTERM, &action, NULL);
}
