/* read_file.c - reads a whole file, on the first process; and what text files of other programs begin with. */
#include <errno.h>
#include <sys/stat.h>
#include "base/fault.h"
#include "scene/shapes.h"

PetscErrorCode MPMSceneReadFile(MPI_Comm comm, const char path[], char **text, size_t *n, char fault[MPM_TEXT_LEN])
{
  PetscMPIInt rank;
  struct stat status;
  FILE       *file;

  PetscFunctionBeginUser;
  *text    = NULL;
  *n       = 0;
  fault[0] = 0;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  file = fopen(path, "rb");
  if (!file || fstat(fileno(file), &status))
    MPMFault(fault, "cannot read", path, strerror(errno));
  else if (!S_ISREG(status.st_mode))
    MPMFault(fault, "cannot read", path, "it is not a file");
  else {
    PetscCall(PetscMalloc1((size_t)status.st_size + 1, text));
    *n = fread(*text, 1, (size_t)status.st_size, file);
    if (*n != (size_t)status.st_size) MPMFault(fault, "cannot read", path, strerror(errno));
    (*text)[*n] = 0;
  }
  if (file) (void)fclose(file);
  if (fault[0]) PetscCall(PetscFree(*text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const char *MPMSceneTextFault(const char text[], size_t n, size_t *mark)
{
  const PetscBool utf8   = n >= 3 && !memcmp(text, "\xef\xbb\xbf", 3);
  const PetscBool marked = n >= 2 && (!memcmp(text, "\xff\xfe", 2) || !memcmp(text, "\xfe\xff", 2));
  const PetscBool wide   = n >= 4 &&
                         ((!text[0] && text[1] && !text[2] && text[3]) || (text[0] && !text[1] && text[2] && !text[3]));

  *mark = utf8 ? 3 : 0;
  return marked || wide ? "is text in UTF-16; save it as UTF-8" : NULL;
}
