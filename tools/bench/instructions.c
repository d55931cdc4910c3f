/* instructions.c - a program of its own that counts the instructions of one call of a function in another program, by
   single steps. The count is exact, for every instruction that the processor has (valgrind --tool=callgrind counts too,
   but cannot run AVX-512). It runs on x86-64 Linux.

     cc -O2 -o build/instructions tools/bench/instructions.c
     build/instructions $(nm pebble | awk '$3 == "MPMStepMake" {print $1}') 5 ./pebble -options_file options/disks.opts

   counts those of the fifth step. A string instruction with a rep prefix counts once for each repetition. */
#define _GNU_SOURCE
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/personality.h>
#include <sys/ptrace.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#define BASE 0x555555554000L /* where Linux loads a position-independent program without randomisation */

static pid_t child;

/* Continues the child, by one instruction or freely, until a trap stops it. Returns whether it still runs. */
static int Go(int request)
{
  int status, signal = 0;

  do {
    ptrace(request, child, NULL, (void *)(long)signal);
    if (waitpid(child, &status, 0) != child || !WIFSTOPPED(status)) return 0;
    signal = WSTOPSIG(status);
  } while (signal != SIGTRAP);
  return 1;
}

int main(int argc, char **argv)
{
  struct user_regs_struct r;
  long                    at, code, wanted, count = 0;

  if (argc < 4) return fprintf(stderr, "usage: instructions OFFSET CALL PROGRAM [ARGUMENT...]\n"), 2;
  at     = BASE + strtol(argv[1], NULL, 16);
  wanted = atol(argv[2]);
  child  = fork();
  if (!child) {
    personality(ADDR_NO_RANDOMIZE);
    ptrace(PTRACE_TRACEME, 0, NULL, NULL);
    execv(argv[3], argv + 3);
    _exit(2);
  }
  waitpid(child, NULL, 0);
  code = ptrace(PTRACE_PEEKTEXT, child, (void *)at, NULL);
  for (long call = 0; call < wanted; call++) { /* set a breakpoint there, and remove it when it is reached */
    if (call && !Go(PTRACE_SINGLESTEP)) break;
    ptrace(PTRACE_POKETEXT, child, (void *)at, (void *)((code & ~0xffL) | 0xcc));
    if (!Go(PTRACE_CONT)) return fprintf(stderr, "the program ended before call %ld\n", call + 1), 1;
    ptrace(PTRACE_POKETEXT, child, (void *)at, (void *)code);
    ptrace(PTRACE_GETREGS, child, NULL, &r);
    r.rip = (unsigned long long)at;
    ptrace(PTRACE_SETREGS, child, NULL, &r);
  }
  while (Go(PTRACE_SINGLESTEP)) { /* step until the return has popped its address off the stack */
    const long stack = offsetof(struct user_regs_struct, rsp);

    count++;
    if ((unsigned long long)ptrace(PTRACE_PEEKUSER, child, (void *)stack, NULL) > r.rsp) break;
  }
  kill(child, SIGKILL);
  printf("%ld instructions\n", count);
  return 0;
}
