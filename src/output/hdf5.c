/* hdf5.c - the functions of hdf5.h, which write datasets and attributes of snapshots. */
#include "output/hdf5.h"
#if defined(PETSC_HAVE_HDF5)

PetscErrorCode MPMHDF5Attribute(hid_t object, const char name[], hid_t type, hsize_t n, const void *value)
{
  hid_t space, attribute;

  PetscFunctionBeginUser;
  H5(space = n ? H5Screate_simple(1, &n, NULL) : H5Screate(H5S_SCALAR));
  H5(attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT));
  H5(H5Awrite(attribute, type, value));
  H5(H5Aclose(attribute));
  H5(H5Sclose(space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMHDF5Text(hid_t object, const char name[], const char text[])
{
  hid_t type;

  PetscFunctionBeginUser;
  H5(type = H5Tcopy(H5T_C_S1));
  H5(H5Tset_size(type, strlen(text) + 1));
  PetscCall(MPMHDF5Attribute(object, name, type, 0, text));
  H5(H5Tclose(type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a text of any length as a dataset. Collective on the file. */
PetscErrorCode MPMHDF5LongText(hid_t object, const char name[], const char text[])
{
  hid_t type, space, set;

  PetscFunctionBeginUser;
  H5(type = H5Tcopy(H5T_C_S1));
  H5(H5Tset_size(type, strlen(text) + 1));
  H5(space = H5Screate(H5S_SCALAR));
  H5(set = H5Dcreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text));
  H5(H5Dclose(set));
  H5(H5Sclose(space));
  H5(H5Tclose(type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMHDF5Real(hid_t object, const char name[], PetscReal value)
{
  const double v = (double)value;

  PetscFunctionBeginUser;
  PetscCall(MPMHDF5Attribute(object, name, H5T_NATIVE_DOUBLE, 0, &v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMHDF5Int(hid_t object, const char name[], PetscInt value)
{
  const long long v = value;

  PetscFunctionBeginUser;
  PetscCall(MPMHDF5Attribute(object, name, H5T_NATIVE_LLONG, 0, &v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a dataset, of which this process has the box at `offset` of extent `count`. Collective on the file. */
PetscErrorCode MPMHDF5Dataset(hid_t group, const char name[], const char unit[], const char components[],
                              PetscBool whole, int rank, const hsize_t size[], const hsize_t offset[],
                              const hsize_t count[], const PetscReal *data)
{
  hid_t file, memory, create, transfer, set;

  PetscFunctionBeginUser;
  H5(file = H5Screate_simple(rank, size, NULL));
  H5(memory = H5Screate_simple(rank, count, NULL));
  H5(create = H5Pcreate(H5P_DATASET_CREATE));
  H5(H5Pset_obj_track_times(create, 0)); /* so that equal results give equal files */
  H5(set = H5Dcreate2(group, name, whole ? H5T_STD_I64LE : H5T_IEEE_F64LE, file, H5P_DEFAULT, create, H5P_DEFAULT));
  H5(H5Sselect_hyperslab(file, H5S_SELECT_SET, offset, NULL, count, NULL));
  for (int r = 0; r < rank; r++)
    if (!count[r]) {
      H5(H5Sselect_none(file));
      H5(H5Sselect_none(memory));
    }
  H5(transfer = H5Pcreate(H5P_DATASET_XFER));
#if defined(H5_HAVE_PARALLEL)
  H5(H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE));
#endif
  if (size[0]) H5(H5Dwrite(set, H5T_NATIVE_DOUBLE, memory, file, transfer, data)); /* HDF5 refuses to write nothing */
  PetscCall(MPMHDF5Text(set, "units", unit));
  if (components[0]) PetscCall(MPMHDF5Text(set, "components", components));
  H5(H5Pclose(transfer));
  H5(H5Dclose(set));
  H5(H5Pclose(create));
  H5(H5Sclose(memory));
  H5(H5Sclose(file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else
typedef int MPMHDF5Nothing; /* a file must not be empty */
#endif
