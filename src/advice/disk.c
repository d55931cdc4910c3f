/* disk.c - the files that a run will write: how large they are, and whether the disk of their folder has room. */
#include <sys/statvfs.h>
#include "advice/advice.h"

#define NODE_BYTES 32   /* of a node in a snapshot: mass and three components of the velocity */
#define FILE_BYTES 20e3 /* of HDF5 in a snapshot */
#define KEPT_BYTES 80e3 /* of a checkpoint, beside the particles */
#define DIGITS     17   /* of a number in the history */

/* Returns the free bytes of the disk of a folder, or of the nearest one above it that is there; 0 if nothing tells. */
static PetscReal FreeBytes(const char dir[])
{
  char           path[MPM_TEXT_LEN];
  struct statvfs s;

  (void)snprintf(path, sizeof path, "%s", dir);
  while (statvfs(path, &s)) {
    char *slash = strrchr(path, '/');

    if (!strcmp(path, ".")) return 0;
    if (slash && slash != path)
      *slash = 0;
    else
      (void)snprintf(path, sizeof path, "%s", ".");
  }
  return (PetscReal)s.f_bavail * (PetscReal)s.f_frsize;
}

/* Returns how often something is written that is due every `every` s, in the steps that are left: also at the end. */
static PetscReal Times(const MPMForecast *f, PetscReal every)
{
  return PetscMin(f->steps, every > 0 ? PetscCeilReal(f->left / every * (1 - 1e-12)) : f->steps) + 1;
}

/* Described in advice.h. */
PetscErrorCode MPMDiskPrint(const MPMCore *core, const MPMMonitor *mon, const MPMOutput *out, const MPMForecast *f,
                            PetscReal kept, PetscBool dry)
{
  const PetscReal n = (PetscReal)core->particles.total, lines = Times(f, mon->every);
  PetscReal       history = 0, snapshot = FILE_BYTES, checkpoint = KEPT_BYTES, all, room;
  const PetscReal snapshots = out->enabled ? Times(f, out->every) : 0;

  PetscFunctionBeginUser;
  if (!out->dir[0] || mon->off) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS; k++) {
    PetscInt first;

    history += DIGITS * lines * (PetscReal)MPMDiagnosticColumns(k, core, &first);
    if (out->fields >> k & 1) snapshot += 8 * n * (PetscReal)MPMDiagnostics[k].nc;
  }
  history += DIGITS * lines * (PetscReal)mon->measures.n;
  if (out->fields & MPM_OUTPUT_GRID) snapshot += NODE_BYTES * MPMGridNodes(&core->grid, core->basis);
  for (PetscInt k = 0; k < MPM_NUM_FIELDS; k++)
    if (core->particles.present[k] && MPMFields[k].home != MPM_SCRATCH && k != MPM_FIELD_INDEX_cell)
      checkpoint += n * (PetscReal)core->particles.bytes[k];
  all  = history + snapshots * snapshot + kept * checkpoint;
  room = FreeBytes(out->dir);
  if (dry)
    PetscCall(MPMPrint(&core->print,
                       "files      %.6g snapshots of %.3g MB, %g checkpoints of %.3g MB at a time, history of %.3g MB: "
                       "about %.3g MB; the disk of %s has %.3g MB free\n",
                       (double)snapshots, (double)(1e-6 * snapshot), (double)kept, (double)(1e-6 * checkpoint),
                       (double)(1e-6 * history), (double)(1e-6 * all), out->dir, (double)(1e-6 * room)));
  if (room > 0 && all > room)
    PetscCall(MPMWarn(
        &core->print,
        "the files of this run need about %.3g MB, and the disk of %s has %.3g MB free; choose a larger -output_every "
        "or -history_every, or another -output_dir",
        (double)(1e-6 * all), out->dir, (double)(1e-6 * room)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
