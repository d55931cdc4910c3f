/* rerun.c - a run that is repeated from the options in its results (-rerun). */
#include <errno.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>
#include "base/fault.h"
#include "results/hdf5.h"
#include "restart/restart.h"

#if defined(PETSC_HAVE_HDF5)

/* Sets the options of a run that its results have, as far as they are not given here. */
static PetscErrorCode SetOptions(hid_t file, char fault[MPM_TEXT_LEN], const char path[])
{
  const MPMPrinter print = {.comm = PETSC_COMM_WORLD};
  char            *text, *scene, name[4 * MPM_NAME_LEN], value[MPM_TEXT_LEN];
  PetscBool        given, elsewhere = PETSC_FALSE;
  const char      *at;

  PetscFunctionBeginUser;
  PetscCall(MPMHDF5ReadText(file, "options", &text));
  PetscCall(MPMHDF5ReadText(file, "scene", &scene));
  if (!text || text[0] != '-') MPMFault(fault, "-rerun: cannot repeat", path, "it has no options of a run of pebble");
  for (size_t k = 0; k < 2; k++) {
    PetscCall(PetscOptionsHasName(NULL, NULL, k ? "-output_name" : "-output_dir", &given));
    elsewhere = elsewhere || given;
  }
  if (!elsewhere)
    MPMFault(fault, "-rerun", path, "give a folder for the new results (-output_dir), or a name (-output_name)");
  for (at = text; !fault[0] && MPMOptionsNext(&at, name, value);) {
    if (!strcasecmp(name, "-restart_file")) { /* from its beginning */
      PetscCall(MPMNote(&print,
                        "%s is of a run that continued from a checkpoint: -rerun runs all of it with the "
                        "options of its last part",
                        path));
      continue;
    }
    if (!strcasecmp(name, "-pool_particles")) { /* of an older version; it changed no bit */
      PetscCall(MPMNote(&print,
                        "%s is of a run with -pool_particles %s, which is no option any more: -rerun "
                        "leaves it out, and the bits are the same",
                        path, value));
      continue;
    }
    PetscCall(PetscOptionsHasName(NULL, NULL, name, &given));
    if (!given) PetscCall(PetscOptionsSetValue(NULL, name, value[0] ? value : NULL));
  }
  PetscCall(PetscOptionsHasName(NULL, NULL, "-output_name", &given));
  if (scene && !given && !fault[0]) PetscCall(PetscOptionsSetValue(NULL, "-output_name", scene));
  PetscCall(PetscFree(text));
  PetscCall(PetscFree(scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRerun(char fault[MPM_TEXT_LEN])
{
  char        path[MPM_TEXT_LEN];
  struct stat status;
  PetscBool   set;
  hid_t       file;

  PetscFunctionBeginUser;
  fault[0] = 0;
  errno    = 0;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-rerun", path, sizeof path, &set));
  if (!set) PetscFunctionReturn(PETSC_SUCCESS);
  if (stat(path, &status) || !S_ISREG(status.st_mode) || access(path, R_OK)) {
    MPMFault(fault, "-rerun: cannot read", path, errno ? strerror(errno) : "it is not a file");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  file = MPMHDF5Open(path);
  if (file < 0) {
    MPMFault(fault, "-rerun: cannot read", path, "it is not an HDF5 file, or it is damaged");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  MPMOptionsNoteFile(path); /* so that it is not overwritten */
  PetscCall(SetOptions(file, fault, path));
  (void)H5Fclose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else

PetscErrorCode MPMRerun(char fault[MPM_TEXT_LEN])
{
  PetscBool set;

  PetscFunctionBeginUser;
  fault[0] = 0;
  PetscCall(PetscOptionsHasName(NULL, NULL, "-rerun", &set));
  if (set) (void)snprintf(fault, MPM_TEXT_LEN, "-rerun needs a PETSc with HDF5, and this one has none");
  PetscFunctionReturn(PETSC_SUCCESS);
}

#endif
