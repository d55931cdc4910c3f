/* rows.h - datasets of snapshots whose rows are sorted on any number of processes. */
#ifndef MPM_ROWS_H
#define MPM_ROWS_H

#include <petscsf.h>
#include "parallel/core.h"
#include "results/hdf5.h"
#if defined(PETSC_HAVE_HDF5)

/* The rows of a dataset: each process writes an equal part of them, which begins with row `first`. */
typedef struct {
  PetscSF  sf; /* sends what the processes have to its row */
  PetscInt first, n;
} MPMRows;

/* Makes the rows of `total` items, of which this process has those of row [n]; the caller destroys rows->sf. Collective
   on comm. */
PetscErrorCode MPMRowsCreate(MPI_Comm comm, PetscInt total, PetscInt n, const PetscInt row[], MPMRows *rows);

/* Sends nc numbers of each item here [n][nc] to its row; the second writes the rows too. Collective on comm. */
PetscErrorCode MPMRowsSend(const MPMRows *, PetscInt nc, const PetscReal here[], PetscReal sorted[]);
PetscErrorCode MPMRowsWrite(MPMFile *, PetscInt set, const MPMRows *, PetscInt nc, const PetscReal here[],
                            PetscReal sorted[]);

/* The nodes (snapshot_nodes.c): writes to extent [3] how many lie between the walls, on axes z, y, x; writes those of
   their numbers that are shown, for the present state, to the datasets from *set on, which is collective on the
   exchange. */
void           MPMNodesBetween(const MPMGrid *, hsize_t extent[3]);
PetscErrorCode MPMNodesWrite(MPMCore *, MPMFile *, PetscInt *set);

#endif
#endif
