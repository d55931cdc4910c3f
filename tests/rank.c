/* rank.c - what mpiexec starts for a test in place of the program: it asks a starter (starter.c) for a copy, which is the
   rank, and ends as the copy ends. Where this process is killed, the copy is too.

   usage: rank SOCKET PROGRAM WORDS... (SOCKET: the abstract name of the starter's socket) */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

int main(int argc, char **argv)
{
  struct sockaddr_un at   = {.sun_family = AF_UNIX};
  char              *text = NULL, folder[4096];
  size_t             size = 0;
  int                status;
  FILE              *request = open_memstream(&text, &size), *answer;
  const int          starter = socket(AF_UNIX, SOCK_STREAM, 0);

  if (argc < 3 || !request || starter < 0 || !getcwd(folder, sizeof(folder))) return 126;
  fprintf(request, "%s%c/proc/%d/fd/1%c/proc/%d/fd/2%c%d%c", folder, 0, (int)getpid(), 0, (int)getpid(), 0, argc - 2,
          0);
  for (int i = 2; i < argc; i++) fprintf(request, "%s%c", argv[i], 0);
  for (char **name = environ; *name; name++) fprintf(request, "%s%c", *name, 0);
  fclose(request);
  snprintf(at.sun_path + 1, sizeof(at.sun_path) - 1, "%s", argv[1]);
  if (connect(starter, (struct sockaddr *)&at, sizeof(at)) || dprintf(starter, "%zu\n", size) < 0) return 126;
  for (size_t sent = 0; sent < size;) {
    const ssize_t n = write(starter, text + sent, size - sent);
    if (n <= 0) return 126;
    sent += (size_t)n;
  }
  answer = fdopen(starter, "r");
  if (!answer || fscanf(answer, "%*d%d", &status) != 1) return 126;
  if (WIFSIGNALED(status)) (void)signal(WTERMSIG(status), SIG_DFL), (void)kill(getpid(), WTERMSIG(status));
  return WEXITSTATUS(status);
}
