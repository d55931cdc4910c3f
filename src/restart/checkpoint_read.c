/* checkpoint_read.c - reads what checkpoint.c wrote, by functions of HDF5. They see whole checkpoints only
   (MPMCheckpointCheck). Each process opens the file by itself. */
#include "base/fault.h"
#include "restart/checkpoint.h"
#include "results/hdf5.h"

#if defined(PETSC_HAVE_HDF5)

/* Sets a word of an exact sum that nothing has been added to since. */
static void SetWord(MPMSum *sum, PetscInt k, int64_t word)
{
  if (!k) MPMSumZero(sum);
  sum->word[k] = word;
}

/* Reads a variable; returns whether it is there with this extent. The first process gets the exact sums. */
static PetscBool ReadOne(hid_t group, const MPMVariable *kept, PetscMPIInt rank)
{
  const hid_t    set   = H5Lexists(group, kept->name, H5P_DEFAULT) > 0 ? H5Dopen2(group, kept->name, H5P_DEFAULT) : -1;
  const hid_t    type  = set >= 0 ? H5Dget_type(set) : -1;
  const hid_t    space = set >= 0 ? H5Dget_space(set) : -1;
  const size_t   width = type >= 0 ? H5Tget_size(type) : 0;
  const PetscInt n     = kept->n * (kept->type == MPM_VARIABLE_SUM ? MPM_SUM_WORDS : 1);
  int64_t       *whole = NULL;
  PetscBool      good  = PETSC_FALSE;

  if (set < 0) return !kept->n;
  if (kept->type == MPM_VARIABLE_TEXT)
    good = H5Tget_class(type) == H5T_STRING && width <= (size_t)kept->n &&
           H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, kept->at) >= 0;
  else if (H5Sget_simple_extent_npoints(space) == n && width == 8) {
    const PetscBool direct = kept->type == MPM_VARIABLE_REAL || kept->type == MPM_VARIABLE_INT64;

    if (!direct) whole = malloc((size_t)n * sizeof *whole);
    good = H5Dread(set, kept->type == MPM_VARIABLE_REAL ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64, H5S_ALL, H5S_ALL,
                   H5P_DEFAULT, direct ? kept->at : whole) >= 0;
    for (PetscInt k = 0; whole && good && k < n; k++) {
      if (kept->type == MPM_VARIABLE_INT) ((PetscInt *)kept->at)[k] = (PetscInt)whole[k];
      if (kept->type == MPM_VARIABLE_SUM)
        SetWord((MPMSum *)kept->at + k / MPM_SUM_WORDS, k % MPM_SUM_WORDS, rank ? 0 : whole[k]);
      if (kept->type == MPM_VARIABLE_BOOL) ((PetscBool *)kept->at)[k] = whole[k] ? PETSC_TRUE : PETSC_FALSE;
    }
    free(whole);
  }
  (void)H5Sclose(space);
  (void)H5Tclose(type);
  (void)H5Dclose(set);
  return good;
}

/* Reads what a whole checkpoint keeps beside the particles, on every process. fault gets the first thing that is not
   there, as with a file of another version of the program. Collective on comm. */
PetscErrorCode MPMCheckpointRead(const char path[], MPI_Comm comm, const MPMVariables *kept, char fault[MPM_TEXT_LEN])
{
  hid_t       file, group;
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  fault[0] = 0;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  H5(file = MPMHDF5Open(path));
  H5(group = H5Gopen2(file, "run", H5P_DEFAULT));
  for (PetscInt k = 0; k < kept->n; k++) {
    char why[MPM_NAME_LEN + 64];

    if (!(kept->row[k].uses & MPM_KEPT) || !kept->row[k].at) continue;
    (void)snprintf(why, sizeof why, "it has no %s, or another one: another version of pebble wrote it",
                   kept->row[k].name);
    if (!ReadOne(group, &kept->row[k], rank)) MPMFault(fault, "cannot go on from", path, why);
  }
  H5(H5Gclose(group));
  H5(H5Fclose(file));
  PetscCall(MPMFaultAgree(comm, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the options of a whole checkpoint, which the caller frees, and the commit of the program that wrote it. Not
   collective. */
PetscErrorCode MPMCheckpointOptions(const char path[], char **options, char git[MPM_NAME_LEN])
{
  hid_t file;
  char *text;

  PetscFunctionBeginUser;
  H5(file = MPMHDF5Open(path));
  PetscCall(MPMHDF5ReadText(file, "options", options));
  PetscCall(MPMHDF5ReadText(file, "git", &text));
  (void)snprintf(git, MPM_NAME_LEN, "%s", text ? text : "?");
  PetscCall(PetscFree(text));
  H5(H5Fclose(file));
  if (!*options) PetscCall(PetscCalloc1(1, options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the fields of particles in a whole checkpoint, separated by blanks, in the sequence of fields.def. Not
   collective. */
PetscErrorCode MPMCheckpointFields(const char path[], MPI_Comm comm, char names[MPM_TEXT_LEN])
{
  hid_t file, group;

  PetscFunctionBeginUser;
  (void)comm;
  names[0] = 0;
  H5(file = MPMHDF5Open(path));
  H5(group = H5Gopen2(file, "particles", H5P_DEFAULT));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (H5Lexists(group, MPMFields[f].name, H5P_DEFAULT) > 0)
      MPMAppend(names, MPM_TEXT_LEN, "%s%s", names[0] ? " " : "", MPMFields[f].name);
  H5(H5Gclose(group));
  H5(H5Fclose(file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads rows first .. first+n-1 of a field that the checkpoint has. Not collective. */
PetscErrorCode MPMCheckpointRows(const char path[], const MPMParticles *particles, PetscInt field, PetscInt64 first,
                                 PetscInt n, void *rows)
{
  const PetscInt  nc       = MPMCheckpointNumbers(particles, field);
  const hsize_t   start[2] = {(hsize_t)first, 0}, count[2] = {(hsize_t)n, (hsize_t)nc};
  const PetscBool whole = MPMFields[field].type == PETSC_INT;
  int64_t        *read  = NULL;
  hid_t           file, set, space, memory;

  PetscFunctionBeginUser;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  if (whole) PetscCall(PetscMalloc1(n * nc, &read));
  H5(file = MPMHDF5Open(path));
  {
    char name[MPM_NAME_LEN];

    (void)snprintf(name, sizeof name, "particles/%s", MPMFields[field].name);
    H5(set = H5Dopen2(file, name, H5P_DEFAULT));
  }
  H5(space = H5Dget_space(set));
  H5(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL));
  H5(memory = H5Screate_simple(nc > 1 ? 2 : 1, count, NULL));
  H5(H5Dread(set, MPMFields[field].type == PETSC_REAL ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64, memory, space,
             H5P_DEFAULT, whole ? (void *)read : rows));
  H5(H5Sclose(memory));
  H5(H5Sclose(space));
  H5(H5Dclose(set));
  H5(H5Fclose(file));
  for (PetscInt k = 0; whole && k < n * nc; k++) ((PetscInt *)rows)[k] = (PetscInt)read[k];
  PetscCall(PetscFree(read));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the state of the nodes of this process, of a checkpoint of the total frame, into the arrays of its patch. Not
   collective. */
PetscErrorCode MPMCheckpointNodes(const char path[], const MPMGrid *grid, MPMPatch *patch)
{
  const PetscInt nc       = MPM_MOTION_NC(grid->dim);
  hsize_t        start[4] = {0}, count[4] = {0}, size[4] = {0};
  PetscReal     *read;
  hid_t          file, set, space, memory;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) {
    start[2 - d] = (hsize_t)(patch->own_lo[d] + grid->layers[d]);
    count[2 - d] = (hsize_t)patch->own_n[d];
  }
  count[3] = (hsize_t)nc;
  PetscCall(PetscMalloc1(patch->own_n[0] * patch->own_n[1] * patch->own_n[2] * nc, &read));
  H5(file = MPMHDF5Open(path));
  H5(set = H5Dopen2(file, "nodes/state", H5P_DEFAULT));
  H5(space = H5Dget_space(set));
  H5(H5Sget_simple_extent_dims(space, size, NULL));
  for (int k = 0; k < 4; k++)
    PetscCheck(start[k] + count[k] <= size[k], PETSC_COMM_SELF, PETSC_ERR_FILE_UNEXPECTED,
               "%s has nodes of another grid", path);
  H5(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL));
  H5(memory = H5Screate_simple(4, count, NULL));
  H5(H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, read));
  H5(H5Sclose(memory));
  H5(H5Sclose(space));
  H5(H5Dclose(set));
  H5(H5Fclose(file));
  for (PetscInt at = 0, k = 0; k < patch->own_n[2]; k++)
    for (PetscInt j = 0; j < patch->own_n[1]; j++)
      for (PetscInt i = 0; i < patch->own_n[0]; i++, at++) {
        const PetscInt x = i + patch->own_lo[0] - patch->lo[0], y = j + patch->own_lo[1] - patch->lo[1],
                       z = k + patch->own_lo[2] - patch->lo[2];

        PetscCall(PetscArraycpy(patch->state + ((z * patch->n[1] + y) * patch->n[0] + x) * nc, read + at * nc, nc));
      }
  PetscCall(PetscFree(read));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else

PetscErrorCode MPMCheckpointNodes(const char path[], const MPMGrid *grid, MPMPatch *patch)
{
  PetscFunctionBeginUser;
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_SUP, "checkpoints need a PETSc with HDF5");
}

PetscErrorCode MPMCheckpointOptions(const char path[], char **options, char git[MPM_NAME_LEN])
{
  PetscFunctionBeginUser;
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_SUP, "checkpoints need a PETSc with HDF5");
}

PetscErrorCode MPMCheckpointRead(const char path[], MPI_Comm comm, const MPMVariables *kept, char fault[MPM_TEXT_LEN])
{
  PetscFunctionBeginUser;
  MPMFault(fault, "cannot read", path, "checkpoints need a PETSc with HDF5");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMCheckpointFields(const char path[], MPI_Comm comm, char names[MPM_TEXT_LEN])
{
  PetscFunctionBeginUser;
  SETERRQ(comm, PETSC_ERR_SUP, "checkpoints need a PETSc with HDF5");
}

PetscErrorCode MPMCheckpointRows(const char path[], const MPMParticles *particles, PetscInt field, PetscInt64 first,
                                 PetscInt n, void *rows)
{
  PetscFunctionBeginUser;
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_SUP, "checkpoints need a PETSc with HDF5");
}

#endif
