/* folder.c - the folder of the results: which of its files a run may replace, and what an earlier run left there.

   A run writes <name>.csv, and with snapshots <name>.h5, <name>.xdmf, .grid.xdmf and .rigid.xdmf, and the folder
   <name>.snapshots.
   Pebble knows its own files by what they begin with, or by an attribute. A file that is not complete has
   another name, which ends with MPM_NEW_FILE and which nothing else has. */
#include <dirent.h>
#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>
#include "results/hdf5.h"
#include "results/output.h"

/* The files of a run by the ends of their names. begin: what stands in the first lines of each; or: what stood there in
   files of the first version. */
typedef struct {
  const char *end, *begin, * or ;
} Known;
static const Known known[] = {
    {".csv", "step,time,dt,kinetic_energy,", NULL},
    {".h5", NULL, NULL}, /* IsResult looks */
    {".xdmf", "<!-- pebble ", "<Grid Name=\"particles\" GridType=\"Collection\" CollectionType=\"Temporal\">"},
    {".grid.xdmf", "<!-- pebble ", NULL},
    {".rigid.xdmf", "<!-- pebble ", NULL},
};
#define FILES    ((int)(sizeof known / sizeof known[0]))
#define SEPARATE ".snapshots"

/* Makes the folder and those that contain it; returns 0 or errno. */
static int MakeFolder(const char dir[])
{
  char        path[MPM_TEXT_LEN];
  struct stat s;

  (void)snprintf(path, sizeof path, "%s", dir);
  for (char *c = path + 1; *c; c++)
    if (*c == '/') {
      *c = 0;
      if (mkdir(path, 0777) && errno != EEXIST) return errno;
      *c = '/';
    }
  if (mkdir(path, 0777) && errno != EEXIST) return errno;
  return !stat(path, &s) && S_ISDIR(s.st_mode) ? 0 : ENOTDIR;
}

/* Returns what MakeFolder would, or 0, and makes nothing that stays: it looks whether the part of the path that is
   there is a folder in which one can be made. */
static int TryFolder(const char dir[])
{
  char        path[MPM_TEXT_LEN], fresh[2 * MPM_TEXT_LEN];
  struct stat s;

  (void)snprintf(path, sizeof path, "%s", dir);
  while (stat(path, &s)) {
    char *slash = strrchr(path, '/');

    if (errno != ENOENT) return errno;
    if (!slash)
      (void)snprintf(path, sizeof path, ".");
    else
      slash[slash == path] = 0;
  }
  if (!S_ISDIR(s.st_mode)) return ENOTDIR;
  (void)snprintf(fresh, sizeof fresh, "%s/.pebble-dry-%ld", path, (long)getpid());
  if (mkdir(fresh, 0777)) return errno;
  return rmdir(fresh) ? errno : 0;
}

/* Returns whether an HDF5 file says that Pebble wrote it. */
static PetscBool IsResult(const char path[])
{
  PetscBool own = PETSC_FALSE;
#if defined(PETSC_HAVE_HDF5)
  const hid_t file     = MPMHDF5Open(path);
  char        text[64] = "";

  if (file < 0) return PETSC_FALSE;
  H5E_BEGIN_TRY
  {
    const hid_t attribute = H5Aopen(file, "version", H5P_DEFAULT), type = H5Aget_type(attribute);

    if (H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 && H5Tget_size(type) <= sizeof text &&
        H5Aread(attribute, type, text) >= 0)
      own = !strncmp(text, "pebble ", 7);
    (void)H5Tclose(type);
    (void)H5Aclose(attribute);
    (void)H5Fclose(file);
  }
  H5E_END_TRY
#else
  (void)path;
#endif
  return own;
}

/* Returns whether Pebble wrote a file of this kind. Nothing is lost with an empty one. */
static PetscBool IsOwn(const char path[], const Known *kind)
{
  char   begin[1024];
  size_t n;
  FILE  *f = fopen(path, "r");

  if (!f) return PETSC_FALSE;
  n        = fread(begin, 1, sizeof begin - 1, f);
  begin[n] = 0;
  (void)fclose(f);
  if (!n || (kind->begin && strstr(begin, kind->begin)) || (kind->or &&strstr(begin, kind->or))) return PETSC_TRUE;
  return kind->begin ? PETSC_FALSE : IsResult(path);
}

/* Returns the step of a snapshot by the name of its file, complete or not, or -1 if it is no such name. */
static PetscInt StepOf(const char name[], PetscBool *complete)
{
  char      same[MPM_NAME_LEN];
  long long step;

  if (strncmp(name, "step_", 5) || strspn(name + 5, "0123456789") < 6) return -1;
  step = strtoll(name + 5, NULL, 10);
  for (int fresh = 0; fresh < 2; fresh++) {
    (void)snprintf(same, sizeof same, "step_%06lld.h5%s", step, fresh ? MPM_NEW_FILE : "");
    *complete = !fresh;
    if (!strcmp(name, same)) return (PetscInt)step;
  }
  return -1;
}

void MPMSnapshotPath(const MPMOutput *out, const MPMScene *scene, PetscInt step, PetscBool beside,
                     char path[2 * MPM_TEXT_LEN])
{
  (void)snprintf(path, 2 * MPM_TEXT_LEN, "%s%s%s" SEPARATE "/step_%06" PetscInt_FMT ".h5", beside ? "" : out->dir,
                 beside ? "" : "/", scene->name, step);
}

/* --- Before a run ------------------------------------------------------------------------------------------------- */

/* Writes to fault why the file of this kind must not be replaced, if so. */
static void CheckFile(MPMOutput *out, const MPMScene *scene, const Known *kind, char fault[MPM_TEXT_LEN])
{
  char        path[2 * MPM_TEXT_LEN], fresh[2 * MPM_TEXT_LEN];
  struct stat s;

  (void)snprintf(path, sizeof path, "%s/%s%s", out->dir, scene->name, kind->end);
  (void)snprintf(fresh, sizeof fresh, "%s/%s%s" MPM_NEW_FILE, out->dir, scene->name, kind->end);
  if (MPMOptionsAreIn(path) || MPMOptionsAreIn(fresh))
    (void)snprintf(fault, MPM_TEXT_LEN,
                   "-output_name: the results would overwrite the options file %.1500s; give another name or folder "
                   "(-output_dir)",
                   path);
  if (fault[0] || scene->dry_run || lstat(path, &s)) return;
  if (stat(path, &s) || !S_ISREG(s.st_mode))
    (void)snprintf(fault, MPM_TEXT_LEN, "-output_name: %.1500s is there and is not a file", path);
  else if (!IsOwn(path, kind))
    (void)snprintf(fault, MPM_TEXT_LEN,
                   "-output_name: %.1500s is there and was not written by Pebble; give another name or folder "
                   "(-output_dir), or move it away",
                   path);
  else if (out->keep && !out->resumed)
    (void)snprintf(fault, MPM_TEXT_LEN,
                   "-output_replace false: %.1500s is there; give another -output_name or -output_dir", path);
  else if (kind - known < FILES)
    out->replaced = PETSC_TRUE;
}

/* The same for the folder of the snapshots. */
static void CheckSnapshots(MPMOutput *out, const MPMScene *scene, char fault[MPM_TEXT_LEN])
{
  char           folder[2 * MPM_TEXT_LEN], path[3 * MPM_TEXT_LEN];
  const Known    kind = {"", NULL, NULL};
  struct dirent *entry;
  struct stat    s;
  DIR           *files;

  (void)snprintf(folder, sizeof folder, "%s/%s" SEPARATE, out->dir, scene->name);
  if (scene->dry_run || lstat(folder, &s)) return;
  if (stat(folder, &s) || !S_ISDIR(s.st_mode)) {
    (void)snprintf(fault, MPM_TEXT_LEN, "-output_name: %.1500s is there and is not a folder", folder);
    return;
  }
  files = opendir(folder);
  if (!files) (void)snprintf(fault, MPM_TEXT_LEN, "-output_name: cannot read %.1500s: %s", folder, strerror(errno));
  while (files && !fault[0] && (entry = readdir(files))) {
    PetscBool complete;

    if (StepOf(entry->d_name, &complete) < 0) continue;
    (void)snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
    if (MPMOptionsAreIn(path) || (complete && !IsOwn(path, &kind)))
      (void)snprintf(fault, MPM_TEXT_LEN,
                     "-output_name: %.1500s is there and was not written by Pebble; give another name or folder "
                     "(-output_dir), or move it away",
                     path);
    else if (out->keep && complete && !out->resumed)
      (void)snprintf(fault, MPM_TEXT_LEN,
                     "-output_replace false: %.1500s is there; give another -output_name or -output_dir", path);
  }
  if (files) (void)closedir(files);
}

PetscErrorCode MPMOutputMakeFolder(MPMOutput *out, const MPMCore *core, const MPMScene *scene, MPMOptions o)
{
  char        fault[MPM_TEXT_LEN] = "";
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  if (!rank) {
    const int number = scene->dry_run ? TryFolder(out->dir) : MakeFolder(out->dir);

    if (number) (void)snprintf(fault, sizeof fault, "-output_dir %.1500s: %s", out->dir, strerror(number));
    for (int k = 0; k < FILES && !fault[0]; k++)
      if (out->enabled || !k) CheckFile(out, scene, &known[k], fault);
    if (out->enabled && !fault[0]) CheckSnapshots(out, scene, fault);
  }
  PetscCallMPI(MPI_Bcast(fault, MPM_TEXT_LEN, MPI_CHAR, 0, core->comm));
  PetscCallMPI(MPI_Bcast(&out->replaced, 1, MPM_MPI_BOOL, 0, core->comm));
  if (fault[0]) MPMOptionsFail(o, "%s", fault);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- During a run ------------------------------------------------------------------------------------------------- */

void MPMOutputClear(const MPMOutput *out, const MPMScene *scene, PetscBool beyond)
{
  char           folder[2 * MPM_TEXT_LEN], path[3 * MPM_TEXT_LEN];
  struct dirent *entry;
  DIR           *files;

  for (int k = 1; k < FILES && !beyond; k++) { /* first what names the snapshots */
    (void)snprintf(path, sizeof path, "%s/%s%s", out->dir, scene->name, known[k].end);
    (void)unlink(path);
  }
  (void)snprintf(folder, sizeof folder, "%s/%s" SEPARATE, out->dir, scene->name);
  (void)mkdir(folder, 0777);
  files = opendir(folder);
  while (files && (entry = readdir(files))) {
    PetscBool      complete, listed = PETSC_FALSE;
    const PetscInt step = StepOf(entry->d_name, &complete);

    if (step < 0) continue;
    for (PetscInt k = 0; beyond && complete && k < out->count && !listed; k++) listed = out->steps[k] == step;
    (void)snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
    if (!listed) (void)unlink(path);
  }
  if (files) (void)closedir(files);
}

PetscErrorCode MPMOutputFail(MPMCore *core, const char fault[], PetscBool *failed)
{
  PetscMPIInt rank, size, first;
  char        text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(core->exchange.data, &rank));
  PetscCallMPI(MPI_Comm_size(core->exchange.data, &size));
  first = fault[0] ? rank : size;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, core->exchange.data));
  if (first == size) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(text, sizeof text, "%s", fault);
  PetscCallMPI(MPI_Bcast(text, MPM_TEXT_LEN, MPI_CHAR, first, core->exchange.data));
  *failed = PETSC_TRUE;
  if (strstr(core->stop, "cannot write")) PetscFunctionReturn(PETSC_SUCCESS); /* one fault is enough to tell */
  MPMAppend(core->stop, sizeof core->stop, "%s%s", core->stop[0] ? "; " : "", text);
  PetscFunctionReturn(PETSC_SUCCESS);
}
