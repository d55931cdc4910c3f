/* hdf5.h - writes datasets and attributes of HDF5, as snapshots need them. With a PETSc that has no HDF5 there are no
   such functions. All are collective on the file. */
#ifndef MPM_HDF5_H
#define MPM_HDF5_H

#include "base/base.h"
#if defined(PETSC_HAVE_HDF5)
#include <hdf5.h>
#include <petscviewerhdf5.h>

#define H5(call)                                                                                                       \
  do {                                                                                                                 \
    PetscCheck((call) >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "HDF5 failed to write the results: %s", #call);            \
  } while (0)

/* Write attributes of an object: an array of n numbers, or one number if n is 0; a text below 64 KiB; one number. A
   text of any length becomes a dataset. */
PetscErrorCode MPMHDF5Attribute(hid_t object, const char name[], hid_t type, hsize_t n, const void *value);
PetscErrorCode MPMHDF5Text(hid_t object, const char name[], const char text[]);
PetscErrorCode MPMHDF5LongText(hid_t object, const char name[], const char text[]);
PetscErrorCode MPMHDF5Real(hid_t object, const char name[], PetscReal value);
PetscErrorCode MPMHDF5Int(hid_t object, const char name[], PetscInt value);

/* Writes a dataset of numbers with `rank` axes: its extent is `size`, and this process writes the box that begins at
   `offset` and has extent `count`, which may be 0. whole: the numbers are stored as integers. */
PetscErrorCode MPMHDF5Dataset(hid_t group, const char name[], const char unit[], const char components[],
                              PetscBool whole, int rank, const hsize_t size[], const hsize_t offset[],
                              const hsize_t count[], const PetscReal *data);

#endif
#endif
