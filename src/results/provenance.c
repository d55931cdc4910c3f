/* provenance.c - what made a file of results: scene, program, libraries, machine, options, grid. */
#include "results/provenance.h"
#if defined(PETSC_HAVE_HDF5)

PetscErrorCode MPMProvenanceWrite(const MPMCore *core, const MPMScene *scene, hid_t file, size_t *room)
{
  char        text[MPM_TEXT_LEN], *options;
  unsigned    major, minor, release;
  int         length = 0;
  PetscMPIInt size;
  char        mpi[MPI_MAX_LIBRARY_VERSION_STRING];
  long long   cells[3];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsText(&options));
  if (room) *room = 8192 + strlen(options) + strlen(MPMVersionFlags) + strlen(MPMVersionCompiler);
  if (file < 0) {
    PetscCall(PetscFree(options));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMHDF5Text(file, "title", scene->title));
  PetscCall(MPMHDF5Text(file, "scene", scene->name));
  PetscCall(MPMHDF5Int(file, "dim", core->grid.dim));
  PetscCall(MPMHDF5Text(file, "version", "pebble " MPM_VERSION));
  PetscCall(MPMHDF5Text(file, "git", MPMVersionGit));
  PetscCall(MPMHDF5Text(file, "compiler", MPMVersionCompiler));
  PetscCall(MPMHDF5Text(file, "flags", MPMVersionFlags));
  PetscCall(PetscGetVersion(text, sizeof text));
  PetscCall(MPMHDF5Text(file, "petsc_version", text));
  H5(H5get_libversion(&major, &minor, &release));
  (void)snprintf(text, sizeof text, "%u.%u.%u", major, minor, release);
  PetscCall(MPMHDF5Text(file, "hdf5_version", text));
  PetscCallMPI(MPI_Get_library_version(mpi, &length));
  PetscCall(MPMHDF5Text(file, "mpi", mpi));
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCall(MPMHDF5Int(file, "ranks", size));
  PetscCall(PetscGetHostName(text, sizeof text));
  PetscCall(MPMHDF5Text(file, "host", text));
  PetscCall(PetscGetDate(text, sizeof text));
  PetscCall(MPMHDF5Text(file, "date", text));
  if (strlen(options) < 60000)
    PetscCall(MPMHDF5Text(file, "options", options)); /* an attribute of HDF5 has 64 KiB at most */
  else
    PetscCall(MPMHDF5LongText(file, "options", options));
  PetscCall(PetscFree(options));
  for (PetscInt d = 0; d < 3; d++) cells[d] = core->grid.cells[d];
  PetscCall(MPMHDF5Attribute(file, "grid_lower", H5T_NATIVE_DOUBLE, 3, core->grid.lower));
  PetscCall(MPMHDF5Attribute(file, "grid_upper", H5T_NATIVE_DOUBLE, 3, core->grid.upper));
  PetscCall(MPMHDF5Attribute(file, "grid_cells", H5T_NATIVE_LLONG, 3, cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else
typedef int MPMProvenanceNothing; /* a file must not be empty */
#endif
