/* starter.c - starts the program for the tests. Of a start on one process more than half is the search for the
   libraries of PETSc, a hundred of them, and most of the rest is MPI_Init. This program has done both: it is
   pebble, but its main() waits for requests, and makes a copy of itself (fork) for each, which then is a run like
   any other, with a session, files and an environment of its own; only MPI_Finalize is left out, since MPI was not
   begun by PETSc. (Of other MPIs than Open MPI each copy calls MPI_Init, since they may not bear a copy.)

   A request on standard input is a number of bytes and a line end, then so many bytes: strings that end with 0,
   which are the folder, the files for standard output and standard error, the number of arguments, these, and the
   environment. The answers on standard output are the number of the process, and, when it has ended, its status as
   of waitpid(); each is a line. It ends with its input. See tests/mpi.py.

   usage: starter [SOCKET]

   With a name of a socket (an abstract one) each connection is such a request and gets its answers; they come from
   rank.c, which mpiexec has started. Then MPI is not begun, and a copy is killed when its connection closes. Once it
   listens it says so in a line, or ends where ranks find each other by an open file, which a copy has not (MPICH). */
int MPMMain(int argc, char **argv);
#define main MPMMain
#include "run/main.c"
#undef main
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

/* Reads so many bytes; false at the end of the input. */
static bool ReadBytes(char *bytes, size_t n)
{
  while (n) {
    const ssize_t got = read(STDIN_FILENO, bytes, n);
    if (got <= 0) return false;
    bytes += got;
    n -= (size_t)got;
  }
  return true;
}

/* Reads a request into memory of its own; NULL at the end of the input. */
static char *ReadRequest(size_t *n)
{
  char digits[24] = "";
  for (size_t k = 0; k + 1 < sizeof(digits) && ReadBytes(&digits[k], 1) && digits[k] != '\n';) k++;
  *n            = strtoul(digits, NULL, 10);
  char *request = *n ? malloc(*n) : NULL;
  return request && ReadBytes(request, *n) ? request : NULL;
}

static char *Next(char **at)
{
  char *string = *at;
  *at += strlen(string) + 1;
  return string;
}

static bool Opened(const char *path, int flags, int as)
{
  const int file = open(path, flags | O_NOCTTY);
  if (file < 0 || dup2(file, as) < 0) return false;
  return file == as || close(file) == 0;
}

/* The copy: is the run that the request tells of, and returns its exit status. Ranks share a session: Linux may give
   sessions equal shares of the processors, and then a rank that waits would not yield to the others. */
static int Start(char *request, size_t n, bool rank)
{
  char     *at = request, *folder = Next(&at), *out = Next(&at), *err = Next(&at);
  const int argc = atoi(Next(&at));
  char    **argv = calloc((size_t)argc + 1, sizeof(char *));
  if (!argv || (!rank && setsid() < 0) || !Opened(out, O_WRONLY | O_APPEND, STDOUT_FILENO) ||
      !Opened(err, O_WRONLY | O_APPEND, STDERR_FILENO) || !Opened("/dev/null", O_RDONLY, STDIN_FILENO) || chdir(folder))
    return 126;
  for (int i = 0; i < argc; i++) argv[i] = Next(&at);
  if (clearenv()) return 126;
  while (at < request + n) putenv(Next(&at));
  return MPMMain(argc, argv);
}

/* Answers the requests of the input; the exit status. */
static int Answer(bool rank)
{
  size_t n;
  for (char *request; (request = ReadRequest(&n)); free(request)) {
    int         status;
    const pid_t child = fork();
    if (!child) {
      (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
      exit(Start(request, n, rank));
    }
    if (child < 0) return 1;
    /* A connection that closes ends this process by SIGIO, and with it the copy. */
    if (rank && (fcntl(STDIN_FILENO, F_SETOWN, getpid()) || fcntl(STDIN_FILENO, F_SETFL, O_ASYNC))) return 1;
    if (dprintf(STDOUT_FILENO, "%d\n", (int)child) < 0 || waitpid(child, &status, 0) < 0 ||
        dprintf(STDOUT_FILENO, "%d\n", status) < 0)
      return 1;
    if (rank) return 0;
  }
  return 0;
}

#ifdef OMPI_MAJOR_VERSION
/* Answers the requests that come through a socket, each by a process, until the input ends. */
static int Listen(const char *name)
{
  struct sockaddr_un at     = {.sun_family = AF_UNIX};
  struct pollfd      wait[] = {{socket(AF_UNIX, SOCK_STREAM, 0), POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}};

  snprintf(at.sun_path + 1, sizeof(at.sun_path) - 1, "%s", name);
  if (bind(wait[0].fd, (struct sockaddr *)&at, sizeof(at)) || listen(wait[0].fd, 64)) return 1;
  if (dprintf(STDOUT_FILENO, "listens\n") < 0) return 1;
  while (poll(wait, 2, -1) > 0 && !wait[1].revents) {
    const int connection = accept(wait[0].fd, NULL, NULL);
    while (waitpid(-1, NULL, WNOHANG) > 0) continue;
    if (!fork()) {
      close(wait[0].fd);
      if (dup2(connection, STDIN_FILENO) < 0 || dup2(connection, STDOUT_FILENO) < 0) return 1;
      close(connection);
      return Answer(true);
    }
    close(connection);
  }
  while (waitpid(-1, NULL, WNOHANG) > 0) continue;
  return 0;
}
#endif

int main(int argc, char **argv)
{
#ifdef OMPI_MAJOR_VERSION
  int provided;
  if (argc > 1) return Listen(argv[1]);
  if (MPI_Init_thread(NULL, NULL, PETSC_MPI_THREAD_REQUIRED, &provided)) return 1;
#else
  if (argc > 1) return 1;
#endif
  return Answer(false);
}
