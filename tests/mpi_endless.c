/* mpi_endless.c - pebble with an MPI that does not come back from its end, as Open MPI 4.1 does not about once in 30,000 runs:
   the process ends by itself, with its status. */
int MPMMain(int argc, char **argv);
#define main MPMMain
#include "run/main.c"
#undef main
#include <unistd.h>

int MPI_Finalize(void)
{
  for (;;) (void)pause();
}

int main(int argc, char **argv)
{
  return MPMMain(argc, argv);
}
