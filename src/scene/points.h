/* points.h - bodies of shape file, whose particles are the lines of a CSV file (read_points.c) or the rows of an HDF5
   file (read_points_hdf5.c); points.c makes them. It is used before the first step. */
#ifndef MPM_POINTS_H
#define MPM_POINTS_H

#include "scene/scene.h"

#define MPM_POINT_NUMBERS (3 + 3 + 9 + 1) /* numbers of a particle: x, v, F, volume; in d dimensions d, d, d*d, 1 */

/* A file: what its columns are, and the kinds of its particles. */
struct _MPMPoints {
  char       what[MPM_TEXT_LEN], path[MPM_TEXT_LEN];       /* for messages: the option and the path; the path */
  PetscInt   dim, ncolumns, column[MPM_POINT_NUMBERS + 1]; /* the number that a column is; -1: the material's name */
  PetscBool  velocity, deformation, volume, material;      /* has it these columns? */
  PetscBool  hdf5;                                         /* is it an HDF5 file? */
  PetscInt64 all;                                          /* rows of an HDF5 file */
  PetscInt64 sum;                                          /* checksum of the file */
  PetscInt64 size, begin, lines;                           /* bytes of the file, of its heading, lines of its heading */
  PetscInt   nkinds, *kind;                                /* [nkinds] rows of the scene's kinds, sorted by */
  PetscReal *sort;                                         /* [nkinds][2] material and volume */
};

/* Particles of a file, those of a process: the number of the first in the file, and their numbers, [n][] of x v F
   volume, with the default where there is no column; material [n]. */
typedef struct {
  PetscInt64 first, all;
  PetscInt   n, room, stride, *material;
  PetscReal *number;
} MPMPointRows;

/* Reads the heading of the file of body b; a fault is left in the options. Collective on core->comm. */
PetscErrorCode MPMPointsOpen(MPMCore *, MPMOptions, MPMBody *);
PetscErrorCode MPMPointsDestroy(MPMPoints **);

/* Reads the rows that are this process's share on comm; the fault of the first wrong line is left in o, which may be
   NULL if the file was read before. The caller destroys the rows. Collective on comm. */
PetscErrorCode MPMPointsRead(const MPMScene *, const MPMBody *, MPI_Comm, MPMOptions, MPMPointRows *);
PetscErrorCode MPMPointsDestroyRows(MPMPointRows *);

/* Returns the kind of particle k of these rows. Not collective. */
PetscInt MPMPointsKind(const MPMPoints *, const MPMPointRows *, PetscInt k);

/* The same of an HDF5 file: the first process finds the datasets; a process reads rows first .. first+n-1 of the file
   into rows that have their defaults. why [len] gets what is wrong, or stays. Not collective. */
PetscErrorCode MPMPointsOpenHDF5(MPMOptions, MPMPoints *);
PetscErrorCode MPMPointsReadHDF5(const MPMPoints *, MPMPointRows *, char why[], size_t len);

#endif
