/* hdf5.c - the functions of hdf5.h: HDF5 files that are complete or not there. */
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <unistd.h>
#include "results/hdf5.h"
#include "results/output.h"
#if defined(PETSC_HAVE_HDF5)

PetscErrorCode MPMHDF5Attribute(hid_t object, const char name[], hid_t type, hsize_t n, const void *value)
{
  hid_t space, attribute;

  PetscFunctionBeginUser;
  if (object < 0) PetscFunctionReturn(PETSC_SUCCESS);
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
  if (object < 0) PetscFunctionReturn(PETSC_SUCCESS);
  H5(type = H5Tcopy(H5T_C_S1));
  H5(H5Tset_size(type, strlen(text) + 1));
  PetscCall(MPMHDF5Attribute(object, name, type, 0, text));
  H5(H5Tclose(type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMHDF5LongText(hid_t object, const char name[], const char text[])
{
  hid_t type, space, set;

  PetscFunctionBeginUser;
  if (object < 0) PetscFunctionReturn(PETSC_SUCCESS);
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

PetscErrorCode MPMHDF5ReadText(hid_t file, const char name[], char **text)
{
  const PetscBool attribute = H5Aexists(file, name) > 0;
  const PetscBool dataset   = !attribute && H5Lexists(file, name, H5P_DEFAULT) > 0;
  hid_t           object, type;

  PetscFunctionBeginUser;
  *text = NULL;
  if (!attribute && !dataset) PetscFunctionReturn(PETSC_SUCCESS);
  object = attribute ? H5Aopen(file, name, H5P_DEFAULT) : H5Dopen2(file, name, H5P_DEFAULT);
  type   = object < 0 ? -1 : attribute ? H5Aget_type(object) : H5Dget_type(object);
  if (type >= 0 && H5Tget_class(type) == H5T_STRING && !H5Tis_variable_str(type)) {
    PetscCall(PetscCalloc1(H5Tget_size(type) + 1, text));
    if ((attribute ? H5Aread(object, type, *text) : H5Dread(object, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text)) < 0)
      PetscCall(PetscFree(*text));
  }
  if (type >= 0) (void)H5Tclose(type);
  if (object >= 0) (void)(attribute ? H5Aclose(object) : H5Dclose(object));
  PetscFunctionReturn(PETSC_SUCCESS);
}

hid_t MPMHDF5Open(const char path[])
{
  hid_t access = H5Pcreate(H5P_FILE_ACCESS), file;

  H5E_BEGIN_TRY
  {
#if H5_VERSION_GE(1, 12, 1) || (H5_VERSION_GE(1, 10, 7) && !H5_VERSION_GE(1, 12, 0))
    (void)H5Pset_file_locking(access, 0, 1);
#endif
    file = H5Fopen(path, H5F_ACC_RDONLY, access);
  }
  H5E_END_TRY(void) H5Pclose(access);
  return file;
}

/* --- The image of a file in memory -------------------------------------------------------------------------------- */

/* HDF5's driver for files in memory gets its memory by these functions. They keep it in the MPMFile, also when HDF5
   closes the file. */
static void *ImageMalloc(size_t size, H5FD_file_image_op_t op, void *file)
{
  (void)op;
  ((MPMFile *)file)->size         = size;
  return ((MPMFile *)file)->image = malloc(size);
}

static void *ImageCopy(void *to, const void *from, size_t size, H5FD_file_image_op_t op, void *file)
{
  (void)op;
  (void)file;
  return memcpy(to, from, size);
}

static void *ImageRealloc(void *memory, size_t size, H5FD_file_image_op_t op, void *file)
{
  void *more = realloc(memory, size);

  (void)op;
  if (!more) return NULL;
  ((MPMFile *)file)->size         = size;
  return ((MPMFile *)file)->image = more;
}

static herr_t ImageKeep(void *memory, H5FD_file_image_op_t op, void *file)
{
  (void)memory;
  (void)op;
  (void)file;
  return 0;
}

static void *SameFile(void *file)
{
  return file;
}

static herr_t FreeNothing(void *file)
{
  (void)file;
  return 0;
}

/* --- Writing ------------------------------------------------------------------------------------------------------ */

/* Notes a fault, if it is the first one of this process. */
static void Fault(MPMFile *f, int number)
{
  if (!f->fault[0]) (void)snprintf(f->fault, sizeof f->fault, "cannot write %.1500s: %s", f->path, strerror(number));
}

/* Writes bytes at a place of the file, unless there has been a fault. */
static void Put(MPMFile *f, const void *data, size_t n, long long at)
{
  const char *from = (const char *)data;

  while (n && !f->fault[0]) {
    const ssize_t done = pwrite(f->fd, from, n, (off_t)at);

    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) {
      Fault(f, done ? errno : ENOSPC);
      return;
    }
    from += done;
    at += done;
    n -= (size_t)done;
  }
}

PetscErrorCode MPMFileCreate(MPMFile *f, MPI_Comm comm, const char path[], size_t head, size_t room)
{
  H5FD_file_image_callbacks_t memory = {ImageMalloc, ImageCopy, ImageRealloc, ImageKeep, SameFile, FreeNothing, f};
  hid_t                       access, create;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(f, sizeof *f));
  f->comm = comm;
  f->file = -1;
  f->fd   = -1;
  (void)snprintf(f->path, sizeof f->path, "%s", path);
  (void)snprintf(f->fresh, sizeof f->fresh, "%s" MPM_NEW_FILE, path);
  PetscCallMPI(MPI_Comm_rank(comm, &f->rank));
  if (f->rank) PetscFunctionReturn(PETSC_SUCCESS);
  H5(access = H5Pcreate(H5P_FILE_ACCESS));
  H5(H5Pset_fapl_core(access, 4096, 0));
  H5(H5Pset_meta_block_size(access, (room + 4095) / 4096 * 4096)); /* all but the numbers lies in one piece, first */
  H5(H5Pset_file_image_callbacks(access, &memory));
  H5(H5Pset_alignment(access, 1, 8)); /* numbers are whole words of the checksum */
  H5(create = H5Pcreate(H5P_FILE_CREATE));
  H5(H5Pset_userblock(create, head));
  H5(f->file = H5Fcreate("/dev/null/image", H5F_ACC_TRUNC, create, access)); /* no such file is looked for */
  H5(H5Pclose(create));
  H5(H5Pclose(access));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMFileDataset(MPMFile *f, hid_t group, const char name[], const char unit[], const char components[],
                              PetscBool whole, int rank, const hsize_t size[])
{
  hid_t   space, create, set;
  haddr_t at;

  PetscFunctionBeginUser;
  PetscCheck(f->nsets < MPM_MAX_SETS, PETSC_COMM_SELF, PETSC_ERR_PLIB, "%s: more than %d datasets", f->path,
             MPM_MAX_SETS);
  f->bytes[f->nsets] = 8;
  for (int k = 0; k < rank; k++) f->bytes[f->nsets] *= (size_t)size[k];
  f->whole[f->nsets++] = whole;
  if (f->file < 0) PetscFunctionReturn(PETSC_SUCCESS);
  H5(space = H5Screate_simple(rank, size, NULL));
  H5(create = H5Pcreate(H5P_DATASET_CREATE));
  H5(H5Pset_obj_track_times(create, 0));               /* so that equal results give equal files */
  H5(H5Pset_alloc_time(create, H5D_ALLOC_TIME_EARLY)); /* so that the place of the numbers is known */
  H5(H5Pset_fill_time(create, H5D_FILL_TIME_NEVER));
  H5(set = H5Dcreate2(group, name, whole ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, create,
                      H5P_DEFAULT));
  H5E_BEGIN_TRY
  {
    at = H5Dget_offset(set);
  }
  H5E_END_TRY
  f->offset[f->nsets - 1] = at == HADDR_UNDEF ? -1 : (long long)at; /* a dataset without numbers has no place */
  if (unit) PetscCall(MPMHDF5Text(set, "units", unit));
  if (components && components[0]) PetscCall(MPMHDF5Text(set, "components", components));
  H5(H5Dclose(set));
  H5(H5Pclose(create));
  H5(H5Sclose(space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMFileLay(MPMFile *f)
{
  PetscFunctionBeginUser;
  if (!f->rank) {
    hsize_t length;

    H5(H5Fget_filesize(f->file, &length));
    H5(H5Fclose(f->file));
    f->file   = -1;
    f->length = PetscMax((long long)length, (long long)f->size); /* some places are given out as the file is closed */
    (void)unlink(f->fresh); /* one that an earlier run left; a link is not followed */
    f->fd = open(f->fresh, O_RDWR | O_CREAT | O_EXCL, 0666);
    if (f->fd < 0) Fault(f, errno);
    if (!f->fault[0] && ftruncate(f->fd, (off_t)f->length)) Fault(f, errno);
    Put(f, f->image, f->size, 0);
  }
  PetscCallMPI(MPI_Bcast(f->offset, (PetscMPIInt)f->nsets, MPI_LONG_LONG, 0, f->comm)); /* the file is there now */
  if (f->rank) f->fd = open(f->fresh, O_RDWR);
  if (f->fd < 0) Fault(f, errno);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMFileWrite(MPMFile *f, PetscInt set, PetscInt64 first, PetscInt64 n, const PetscReal values[])
{
  const long long at = f->offset[set] + 8 * (long long)first;
  int64_t         piece[1024];

  PetscFunctionBeginUser;
  if (f->offset[set] < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (!f->whole[set]) Put(f, values, 8 * (size_t)n, at);
  for (PetscInt64 k = 0; f->whole[set] && k < n; k += 1024) {
    const PetscInt64 m = PetscMin(1024, n - k);

    for (PetscInt64 i = 0; i < m; i++) piece[i] = (int64_t)values[k + i];
    Put(f, piece, 8 * (size_t)m, at + 8 * (long long)k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMFileWriteWords(MPMFile *f, PetscInt set, PetscInt64 first, PetscInt64 n, const void *words)
{
  PetscFunctionBeginUser;
  if (f->offset[set] < 0) PetscFunctionReturn(PETSC_SUCCESS);
  Put(f, words, 8 * (size_t)n, f->offset[set] + 8 * (long long)first);
  f->sum += MPMChecksum(words, 8 * (size_t)n, (size_t)f->offset[set] + 8 * (size_t)first);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMFileSum(MPMFile *f, size_t from, uint64_t *sum)
{
  PetscFunctionBeginUser;
  *sum = f->sum;
  while (!f->rank && !f->fault[0] && from < (size_t)f->length) { /* what lies between the numbers, which are counted */
    PetscInt next = -1;
    size_t   to   = (size_t)f->length;
    int      code;

    for (PetscInt k = 0; k < f->nsets; k++)
      if (f->offset[k] >= (long long)from && (next < 0 || f->offset[k] < f->offset[next])) next = k;
    if (next >= 0) to = (size_t)f->offset[next];
    code = MPMChecksumFile(f->fd, from, to, sum);
    if (code) Fault(f, code);
    from = next < 0 ? to : to + f->bytes[next];
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 1, MPI_UINT64_T, MPI_SUM, f->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMFileHead(MPMFile *f, const void *head, size_t bytes)
{
  PetscFunctionBeginUser;
  Put(f, head, bytes, 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sees to it that the new name of a file is on the disk. File systems that cannot do this need not. */
static void SyncFolder(const MPMFile *f)
{
  char path[sizeof f->path];
  int  fd;

  (void)snprintf(path, sizeof path, "%s", f->path);
  fd = open(dirname(path), O_RDONLY);
  if (fd < 0) return;
  (void)fsync(fd);
  (void)close(fd);
}

PetscErrorCode MPMFileClose(MPMFile *f, PetscBool sync, char fault[MPM_TEXT_LEN])
{
  PetscMPIInt bad;

  PetscFunctionBeginUser;
  if (f->fd >= 0 && sync && !f->fault[0] && fsync(f->fd)) Fault(f, errno);
  if (f->fd >= 0 && close(f->fd)) Fault(f, errno);
  f->fd = -1;
  bad   = f->fault[0] ? 1 : 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &bad, 1, MPI_INT, MPI_MAX, f->comm));
  if (!f->rank) {
    if (!bad && rename(f->fresh, f->path)) {
      Fault(f, errno);
      bad = 1;
    }
    if (bad) (void)unlink(f->fresh);
    if (!bad && sync) SyncFolder(f);
    free(f->image);
    f->image = NULL;
  }
  (void)snprintf(fault, MPM_TEXT_LEN, "%s", f->fault);
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else
typedef int MPMHDF5Nothing; /* a file must not be empty */
#endif
