/* hdf5.h - datasets and attributes of HDF5, as snapshots need them. With a PETSc that has no HDF5 there are none. */
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

/* n numbers, or one if n is 0; a text; a text of any length, as a dataset. */
PetscErrorCode MPMHDF5Attribute(hid_t object, const char name[], hid_t type, hsize_t n, const void *value);
PetscErrorCode MPMHDF5Text(hid_t object, const char name[], const char text[]);
PetscErrorCode MPMHDF5LongText(hid_t object, const char name[], const char text[]);
PetscErrorCode MPMHDF5Real(hid_t object, const char name[], PetscReal value);
PetscErrorCode MPMHDF5Int(hid_t object, const char name[], PetscInt value);
PetscErrorCode MPMHDF5Dataset(hid_t group, const char name[], const char unit[], const char components[],
                              PetscBool whole, int rank, const hsize_t size[], const hsize_t offset[],
                              const hsize_t count[], const PetscReal *data);

#endif
#endif
