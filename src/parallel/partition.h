/* partition.h - how the grid is cut into boxes, one for each process, by a histogram of the particles and the costs of
   a step. It is used before the first step, and again where -parallel_balance auto cuts the grid anew. */
#ifndef MPM_PARTITION_H
#define MPM_PARTITION_H

#include "physics/grid.h"

/* What a process has in a step, as costs count it. */
typedef struct {
  PetscReal particles, nodes, ghosts; /* own particles, own nodes that particles touch, such nodes above its box */
  PetscReal neighbours, processes;    /* that it sends to, and receives from, in an exchange; all processes */
  PetscReal axes, cuts;               /* axes that are cut; planes between boxes, on all axes together */
  PetscReal crossing;                 /* particles of all processes that change process in a step */
  PetscReal row, waits; /* particles of a row along its cuts; chance that a row crosses a cut of an axis */
} MPMShare;

/* The cost of a step as a linear function of a share: s, then s per particle, ghost node, node, neighbour and leaver.
   moved: cells that the fastest particle is assumed to move in a step. */
typedef struct {
  PetscReal fixed, particle, ghost, node, neighbour, leaver, moved;
} MPMCosts;

/* How the grid is cut into boxes of nodes, one for each process: axis d has p[d] parts, of l[d][part] nodes. */
typedef struct {
  PetscInt  p[3], *l[3];
  MPMCosts  costs;                /* by which cuts are chosen: set before MPMPartitionChoose */
  PetscReal imbalance, predicted; /* largest over mean number of particles of a process; s per step by the costs */
  MPMShare  worst;                /* of the process for which predicted is largest; crossing is its own alone */
} MPMPartition;

typedef enum {
#define MPM_BALANCE(name, what) MPM_BALANCE_##name,
#include "parallel/balance.def"
  MPM_NUM_BALANCES
} MPMBalance;

/* Numbers of particles in bins of nodes; a bin covers `coarse` nodes along each axis. Every process counts some of the
   particles; the first process has the summed-area tables, the others only lists of what they counted. */
typedef struct {
  MPI_Comm    comm;
  PetscInt    dim, nodes[3], n[3], coarse, stencil; /* stencil: nodes of a particle's stencil per axis */
  PetscInt64 *table;                                /* [n2+1][n1+1][n0+1] particles in all bins below */
  PetscInt64 *occupied;                             /* [n2+1][n1+1][n0+1] bins below that have particles */
  PetscInt64 *list;                                 /* [listed][2] entry of table, particles */
  PetscInt    listed, capacity;
} MPMHistogram;

/* partition.c describes these functions at their definitions. */
PetscErrorCode MPMHistogramCreate(const MPMGrid *, MPMBasis, MPI_Comm, MPMHistogram *);
PetscErrorCode MPMHistogramAdd(MPMHistogram *, const PetscInt base[], PetscInt64 particles); /* before Finish */
PetscErrorCode MPMHistogramFinish(MPMHistogram *);
PetscErrorCode MPMHistogramDestroy(MPMHistogram *);

PetscErrorCode MPMPartitionChoose(const MPMHistogram *, PetscMPIInt size, MPMBalance, MPMPartition *);
PetscErrorCode MPMPartitionWhole(const MPMGrid *, MPMPartition *);            /* one box, for one process */
PetscReal      MPMPartitionCost(const MPMHistogram *, MPMPartition *);        /* sets imbalance and worst */
PetscInt       MPMPartitionLargest(const MPMGrid *, MPMBasis, PetscInt size); /* most processes, <= size */
PetscErrorCode MPMPartitionShare(MPMPartition *, MPI_Comm);                   /* broadcasts that of the first process */
PetscErrorCode MPMPartitionDestroy(MPMPartition *);

/* Sets crossing, row and waits of a share: the particles that cross its cuts in a step. Not collective. */
void MPMShareCross(PetscInt dim, PetscReal layer, PetscReal per_cell, PetscReal moved, MPMShare *);

#endif
