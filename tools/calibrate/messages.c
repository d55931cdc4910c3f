/* messages.c - measures the time of messages between processes, and of their packing. */
#include "base/message.h"
#include "calibrate.h"
#include "kernels/tile_index.h"

enum { BURST = 8 }; /* messages that are sent at once */
#define LONG_MESSAGE (1 << 16)

/* Measures the least seconds of a message of so many bytes, as half of the time there and back; processes 2k and 2k+1
   are pairs. Collective on comm. */
static PetscErrorCode PingPong(MPI_Comm comm, size_t bytes, PetscReal *least)
{
  PetscReal   seconds = PETSC_MAX_REAL;
  PetscMPIInt rank, size, peer, len;
  char       *buffer;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(MPMMessageLength(bytes, &len));
  PetscCall(PetscCalloc1(bytes, &buffer));
  peer = rank ^ 1;
  for (int batch = 0; batch < 20 && peer < size; batch++) {
    PetscLogDouble t0, t1;

    PetscCall(PetscTime(&t0));
    for (int k = 0; k < 50; k++)
      for (int way = 0; way < 2; way++)
        if ((rank & 1) == way)
          PetscCallMPI(MPI_Send(buffer, len, MPI_BYTE, peer, way, comm));
        else
          PetscCallMPI(MPI_Recv(buffer, len, MPI_BYTE, peer, way, comm, MPI_STATUS_IGNORE));
    PetscCall(PetscTime(&t1));
    seconds = PetscMin(seconds, (t1 - t0) / 100);
  }
  PetscCall(PetscFree(buffer));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPIU_REAL, MPIU_MIN, comm));
  Least(least, seconds);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the least seconds of an exchange of n short messages each way between the processes of a pair. Collective on
   comm. */
static PetscErrorCode Burst(MPI_Comm comm, int n, PetscReal *least)
{
  PetscReal   seconds = PETSC_MAX_REAL;
  double      in[BURST], out[BURST] = {0};
  MPI_Request request[2 * BURST];
  PetscMPIInt rank, size, peer;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  peer = rank ^ 1;
  for (int batch = 0; batch < 20 && peer < size; batch++) {
    PetscLogDouble t0, t1;

    PetscCall(PetscTime(&t0));
    for (int k = 0; k < 50; k++) {
      for (int q = 0; q < n; q++) {
        PetscCallMPI(MPI_Irecv(&in[q], 1, MPI_DOUBLE, peer, q, comm, &request[q]));
        PetscCallMPI(MPI_Isend(&out[q], 1, MPI_DOUBLE, peer, q, comm, &request[n + q]));
      }
      PetscCallMPI(MPI_Waitall(2 * n, request, MPI_STATUSES_IGNORE));
    }
    PetscCall(PetscTime(&t1));
    seconds = PetscMin(seconds, (t1 - t0) / 50);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPIU_REAL, MPIU_MIN, comm));
  Least(least, seconds);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the times of messages and of a reduction. Collective on comm. */
PetscErrorCode TimeMessages(MPI_Comm comm, MessageTimes *least)
{
  PetscReal status[24] = {0}, best = PETSC_MAX_REAL;

  PetscFunctionBeginUser;
  PetscCall(PingPong(comm, 8, &least->one));
  PetscCall(PingPong(comm, LONG_MESSAGE, &least->longer));
  PetscCall(Burst(comm, 1, &least->burst[0]));
  PetscCall(Burst(comm, BURST, &least->burst[1]));
  for (int batch = 0; batch < 20; batch++) {
    PetscLogDouble t0, t1;

    PetscCallMPI(MPI_Barrier(comm));
    PetscCall(PetscTime(&t0));
    for (int k = 0; k < 50; k++) PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, status, 24, MPIU_REAL, MPIU_MAX, comm));
    PetscCall(PetscTime(&t1));
    best = PetscMin(best, (t1 - t0) / 50);
  }
  PetscCall(Slowest(comm, &best));
  Least(&least->reduction, best);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the constants of messages by their times on `size` processes. */
void FitMessages(PetscMPIInt size, const MessageTimes *least, MPMModel *m)
{
  m->message   = least->one;
  m->wire      = Difference("wire", (least->longer - least->one) / LONG_MESSAGE);
  m->post      = Difference("post", (least->burst[1] - least->burst[0]) / (BURST - 1));
  m->reduction = least->reduction / PetscCeilReal(PetscLog2Real((PetscReal)size));
}

/* Measures the seconds per byte to pack and unpack a field of 2 numbers per particle. Not collective. */
PetscErrorCode TimeCopy(PetscReal *least)
{
  enum { ROWS = 20000 };
  PetscReal(*from)[2], (*to)[2];
  PetscInt *list;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(2 * ROWS, &from, ROWS, &to, ROWS, &list));
  for (PetscInt q = 0; q < ROWS; q++) list[q] = 2 * q;
  for (PetscInt q = 0; q < 2 * ROWS; q++) from[q][0] = from[q][1] = 1;
  for (int repeat = 0; repeat < 10; repeat++) {
    PetscLogDouble t0, t1;

    PetscCall(PetscTime(&t0));
    for (PetscInt q = 0; q < ROWS; q++) memcpy(to[q], from[list[q]], sizeof *to);
    memcpy(from, to, ROWS * sizeof *to);
    PetscCall(PetscTime(&t1));
    Least(least, (t1 - t0) / (ROWS * sizeof *to));
  }
  PetscCall(PetscFree3(from, to, list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures the seconds per byte to zero, pack and unpack sums of tiles, if there are more tiles than fit into a cache,
   as there are of those whose sums are sent. Not collective. */
PetscErrorCode TimeKept(MPM scene, PetscReal *least)
{
  const PetscReal coarser = PetscPowReal((PetscReal)scene->core.particles.total / 1e5,
                                         1 / (PetscReal)scene->core.grid.dim);
  const size_t    size    = MPMTileNodes(scene->core.grid.dim, scene->core.basis) * MPM_NODE_NC * sizeof(PetscReal);
  const MPMTiles *t;
  MPM             mpm;
  char           *message;

  PetscFunctionBeginUser;
  PetscCall(SetRun(scene, "spatial", coarser, 1));
  PetscCall(MakeRun(PETSC_COMM_SELF, &mpm));
  if (!mpm) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMTilesAssign(&mpm->core.exchange.patch, PETSC_TRUE, mpm->core.particles.start)); /* all are kept */
  t = &mpm->core.exchange.patch.tiles;
  PetscCall(PetscCalloc1((size_t)t->n_own * size, &message));
  for (int repeat = 0; repeat < 10; repeat++) {
    PetscLogDouble t0, t1;
    size_t         bytes = 0;

    PetscCall(PetscTime(&t0));
    memset(t->sum, 0, (size_t)t->n_own * size);
    for (PetscInt slot = 0; slot < t->n_own; slot++)
      bytes += MPMTilesCopy(&mpm->core.exchange.patch, slot, scene->core.program[0]->parts, PETSC_TRUE,
                            message + bytes);
    bytes = 0;
    for (PetscInt slot = 0; slot < t->n_own; slot++)
      bytes += MPMTilesCopy(&mpm->core.exchange.patch, slot, scene->core.program[0]->parts, PETSC_FALSE,
                            message + bytes);
    PetscCall(PetscTime(&t1));
    Least(least, (t1 - t0) / (PetscReal)bytes);
  }
  PetscCall(PetscFree(message));
  PetscCall(MPMDestroy(&mpm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
