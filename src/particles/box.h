/* box.h - a process's box of the grid: its DMDA, the patch on it, its tiles and their messages. The functions are
   described where they are defined. */
#ifndef MPM_BOX_H
#define MPM_BOX_H

#include <petscdmda.h>
#include "kernels/transfer.h"

/* The DMDAs of the grid's nodes, and the local vectors that hold the data of a patch's nodes (dmda.c). */
PetscErrorCode MPMGridCreateDM(const MPMGrid *, MPI_Comm, PetscInt stencil, const PetscInt parts[3],
                               PetscInt *const widths[3], DM *);
PetscErrorCode MPMGridCreateSums(const MPMPatch *, DM, PetscInt line, DM *sums, Vec *node_sums);

PetscErrorCode MPMPatchSetBox(MPMPatch *, const MPMGrid *, MPMBasis, DM da, PetscInt lines);
PetscErrorCode MPMPatchDestroy(MPMPatch *);
PetscInt       MPMPatchNodes(const MPMPatch *);
int            MPMPatchSide(const MPMPatch *, PetscInt node);
PetscReal      MPMPatchTouchedNodes(const MPMPatch *);
void           MPMPatchVisitAll(MPMPatch *);

/* --- The tiles of a patch (tiles.c) ------------------------------------------------------------------------------- */

PetscErrorCode MPMTilesSetUp(MPMPatch *, PetscBool alone);
PetscErrorCode MPMTilesDestroy(MPMPatch *);
PetscErrorCode MPMTilesAssign(MPMPatch *, PetscBool keep, const PetscInt start[]); /* start [cells+1] of the order */
void           MPMTilesWrap(MPMPatch *);
void           MPMTilesFindSpans(MPMPatch *);
PetscInt       MPMTilesCells(const MPMPatch *);

/* --- Messages of the sums of tiles (tile_messages.c) -------------------------------------------------------------- */

PetscInt MPMTilesSent(const MPMPatch *, const int toward[3]);
size_t   MPMTilesBytes(const MPMPatch *, const int toward[3], PetscInt parts, PetscBool above);
size_t   MPMTilesPack(const MPMPatch *, const int toward[3], PetscInt parts, char *message);
void     MPMTilesUnpack(MPMPatch *, const int toward[3], PetscInt parts, const char *message);
size_t   MPMTilesCopy(const MPMPatch *, PetscInt slot, PetscInt parts, PetscBool pack, char *message);

#endif
