/* partition.h - how the grid is cut into boxes, one a process: from a histogram of the particles and the costs of a
   step. */
#ifndef MPM_PARTITION_H
#define MPM_PARTITION_H

#include "physics/grid.h"

/* What a process has in a step, as costs count it. */
typedef struct {
  PetscReal particles, nodes, ghosts; /* own particles, own nodes that particles touch, such nodes above its box */
  PetscReal neighbours, processes;    /* that it sends to, and awaits from, in an exchange; all processes */
  PetscReal axes, cuts;               /* that are cut; planes between boxes, on all axes together */
  PetscReal crossing;                 /* particles of all processes that change process in a step */
  PetscReal row, waits; /* particles of a row along its cuts; chance that a row crosses a cut of an axis */
} MPMShare;

/* The cost of a step near a share, linear: s, s a particle, a ghost node, a node, a neighbour, a particle that changes
   process; cells that the fastest particle is taken to move in a step. */
typedef struct {
  PetscReal fixed, particle, ghost, node, neighbour, leaver, moved;
} MPMCosts;

/* How the grid is cut into boxes of nodes, one a process: p[d] parts on axis d, of l[d][...] nodes each. */
typedef struct {
  PetscInt  p[3], *l[3];
  MPMCosts  costs;                /* by which cuts are chosen: set before MPMPartitionChoose */
  PetscReal imbalance, predicted; /* largest over mean number of particles of a process; s a step by the costs */
  MPMShare  worst;                /* of the process for which predicted is largest; no processes, no crossing */
} MPMPartition;

typedef enum { MPM_BALANCE_NONE, MPM_BALANCE_START, MPM_BALANCE_AUTO } MPMBalance;

/* Particles per bin of nodes: each bin covers `coarse` nodes an axis. Processes count some of the particles each; the
   first has the summed-area tables, the others only lists of what they counted. */
typedef struct {
  MPI_Comm    comm;
  PetscInt    dim, nodes[3], n[3], coarse, stencil; /* stencil: nodes of a particle's stencil per axis */
  PetscInt64 *table;                                /* [n2+1][n1+1][n0+1] particles below */
  PetscInt64 *occupied;                             /* likewise: bins with particles below */
  PetscInt64 *list;                                 /* [listed][2] entry of table, particles */
  PetscInt    listed, capacity;
} MPMHistogram;

PetscErrorCode MPMHistogramCreate(const MPMGrid *, MPMBasis, MPI_Comm, MPMHistogram *);
PetscErrorCode MPMHistogramAdd(MPMHistogram *, const PetscInt base[], PetscInt64 particles); /* before Finish */
PetscErrorCode MPMHistogramFinish(MPMHistogram *);
PetscErrorCode MPMHistogramDestroy(MPMHistogram *);

PetscErrorCode MPMPartitionChoose(const MPMHistogram *, PetscMPIInt size, MPMBalance, MPMPartition *);
PetscErrorCode MPMPartitionWhole(const MPMGrid *, MPMPartition *);            /* one box: the grid of one process */
PetscReal      MPMPartitionCost(const MPMHistogram *, MPMPartition *);        /* sets imbalance and worst */
PetscInt       MPMPartitionLargest(const MPMGrid *, MPMBasis, PetscInt size); /* the largest legal count <= size */
PetscErrorCode MPMPartitionShare(MPMPartition *, MPI_Comm); /* that of its first process becomes that of all */
PetscErrorCode MPMPartitionDestroy(MPMPartition *);

/* Sets what of a share crosses its cuts in a step. */
void MPMShareCross(PetscInt dim, PetscReal layer, PetscReal per_cell, PetscReal moved, MPMShare *);

#endif
