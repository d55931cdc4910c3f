/* hdf5.h - HDF5 files that are complete or not there. The first process makes all of a file but the numbers of its
   datasets, in memory; then every process writes its part of these numbers to where HDF5 will look for them; when all
   have written, the file gets its name. HDF5 itself never writes to a disk, since it does not survive a full one, and
   no process waits in HDF5 for another. A fault is kept as a text with the name of the file and the system's reason.

     MPMFileCreate  MPMFileDataset ...  MPMFileLay  MPMFileWrite ...  MPMFileClose

   With a PETSc that has no HDF5 there are no such functions. */
#ifndef MPM_HDF5_H
#define MPM_HDF5_H

#include "base/checksum.h"
#if defined(PETSC_HAVE_HDF5)
#include <hdf5.h>

#define H5(call)                                                                                                       \
  do {                                                                                                                 \
    PetscCheck((call) >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "HDF5 failed to make a file of results: %s", #call);       \
  } while (0)

/* Write attributes of an object: an array of n numbers, or one number if n is 0; a text below 64 KiB; one number. A
   text of any length becomes a dataset. They do nothing where the object is not open, so that all processes may call
   them. Not collective. */
PetscErrorCode MPMHDF5Attribute(hid_t object, const char name[], hid_t type, hsize_t n, const void *value);
PetscErrorCode MPMHDF5Text(hid_t object, const char name[], const char text[]);
PetscErrorCode MPMHDF5LongText(hid_t object, const char name[], const char text[]);
PetscErrorCode MPMHDF5Real(hid_t object, const char name[], PetscReal value);
PetscErrorCode MPMHDF5Int(hid_t object, const char name[], PetscInt value);

#define MPM_MAX_SETS 128 /* datasets of numbers in a file */
typedef struct {
  MPI_Comm    comm;
  PetscMPIInt rank;
  char        path[2 * MPM_TEXT_LEN], fresh[2 * MPM_TEXT_LEN + 16]; /* its name, and that while it is not complete */
  char        fault[MPM_TEXT_LEN];                                  /* the first fault of this process; empty: none */
  hid_t       file;  /* on the first process, from Create to Lay; else -1 */
  void       *image; /* on the first process: all but the numbers */
  size_t      size;  /* of the image, bytes */
  PetscInt    nsets;
  long long   length, offset[MPM_MAX_SETS]; /* bytes: of the file, and where the numbers of a dataset begin */
  size_t      bytes[MPM_MAX_SETS];          /* of the numbers of a dataset */
  uint64_t    sum;                          /* the checksum of the words that this process has written */
  PetscBool   whole[MPM_MAX_SETS];
  int         fd; /* of this process, from Lay to Close */
} MPMFile;

/* Begins a file; `head` bytes, 0 or a power of 2 from 512 on, are left free before what HDF5 sees, and `room` is about
   how many bytes its attributes take (a guess that is too small costs memory only). Collective. */
PetscErrorCode MPMFileCreate(MPMFile *, MPI_Comm, const char path[], size_t head, size_t room);

/* Makes the next dataset, of numbers with `rank` axes; the first one has the number 0. whole: the numbers are stored as
   integers of 64 bits. All processes call it, and group is used on the first. Not collective. */
PetscErrorCode MPMFileDataset(MPMFile *, hid_t group, const char name[], const char unit[], const char components[],
                              PetscBool whole, int rank, const hsize_t size[]);

/* Ends the making of datasets, and opens the file on all processes. Collective. */
PetscErrorCode MPMFileLay(MPMFile *);

/* Writes n numbers of a dataset, of which `first` come before, in the sequence of the file. Not collective. */
PetscErrorCode MPMFileWrite(MPMFile *, PetscInt set, PetscInt64 first, PetscInt64 n, const PetscReal[]);

/* The same with numbers of 8 bytes as the file has them. */
PetscErrorCode MPMFileWriteWords(MPMFile *, PetscInt set, PetscInt64 first, PetscInt64 n, const void *words);

/* Sets *sum to the checksum (checksum.h) of the file from byte `from` on, all numbers of which were written by
   MPMFileWriteWords, by one process each. Collective. */
PetscErrorCode MPMFileSum(MPMFile *, size_t from, uint64_t *sum);

/* Writes bytes at the beginning of the file. Only the first process calls it. */
PetscErrorCode MPMFileHead(MPMFile *, const void *head, size_t bytes);

/* Ends the file: gives it its name, or removes it if a process has a fault. sync: its numbers are on the disk when this
   returns. *fault gets the fault of this process. Collective. */
PetscErrorCode MPMFileClose(MPMFile *, PetscBool sync, char fault[MPM_TEXT_LEN]);

/* Reads a text that is an attribute or a dataset of a file; NULL if there is none. The caller frees it by PetscFree.
   Not collective. */
PetscErrorCode MPMHDF5ReadText(hid_t file, const char name[], char **text);

/* Opens a file for reading without locking it or printing faults; returns -1 if it cannot. Not collective. */
hid_t MPMHDF5Open(const char path[]);

#endif
#endif
