/* spatial.h - what the files of the spatial decomposition share: spatial.c, layout.c and migrate.c. Each describes its
   functions. */
#ifndef MPM_SPATIAL_H
#define MPM_SPATIAL_H

#include <petscsf.h>
#include "parallel/exchange.h"

enum {
  MPM_TAG_MIGRATE = 1,
  MPM_TAG_TILES   = 8
}; /* + 1 for a migration upwards; + the direction for tiles, since a process may be one in several */
#define MPM_MAX_NEIGHBOURS 7 /* lower, or upper, sides of a box in 3-D */
_Static_assert(MPM_MAX_NEIGHBOURS == (1 << 3) - 1, "a neighbour lies one box away on any of 3 axes, at least on one");

typedef struct {
  PetscMPIInt rank, tag;
  int         toward[3]; /* 1 on each axis on which it lies above (or below, of those that send to us) */
} MPMNeighbour;

typedef struct {
  MPI_Comm     comm; /* a duplicate, so that its tags are used here alone */
  MPI_Datatype status_type;
  MPI_Op       status_op;
  PetscInt     p[3], *first[3]; /* process grid; [p] first own node of each part of an axis */
  PetscInt     me[3];           /* place of this process in the process grid */
  PetscMPIInt  beside[3][2];    /* processes below and above on an axis, MPI_PROC_NULL: none */
  int          nto, nfrom;
  MPMNeighbour to[MPM_MAX_NEIGHBOURS], from[MPM_MAX_NEIGHBOURS];
  MPI_Request  request[2 * MPM_MAX_NEIGHBOURS]; /* [nfrom] of sums that are received, [nto] of sums that are sent */
  int          fault;                           /* MPI's return code while particles were summed */
  /* The update of ghosts: [0] of velocities, to which the motion of a node is two units of dim numbers; [1] of the
     whole motion, one unit. */
  PetscSF      ghosts[2];
  MPI_Datatype motion_type[2];
  char        *out, *in; /* messages */
  size_t       out_capacity, in_capacity;
  char        *packed; /* particles on their way from box to box (migrate.c) */
  size_t       packed_capacity;
  PetscInt     nleavers, *leaver; /* [nleavers] the leavers, ascending */
  PetscMPIInt *owner;             /* [nleavers] the process that each goes to */
  int (*hops)[3];                 /* [nleavers] and how many boxes away that is on each axis */
  PetscInt64 ids;                 /* fingerprint of the particles here */
  PetscBool  ranked;              /* DMSwarm's rank field holds the owners */
  PetscReal  lost;                /* s lost to imbalance since the cuts were last examined, by the model */
} MPMSpatial;

PetscErrorCode MPMSpatialLayout(MPMCore *);
PetscErrorCode MPMSpatialTearDown(MPMCore *);
PetscMPIInt    MPMSpatialOwner(const MPMSpatial *, const MPMGrid *, const PetscInt base[], int hops[3]);
PetscErrorCode MPMMigrateList(MPMCore *, MPMSpatial *, PetscInt64 *hops);
PetscErrorCode MPMMigrateClear(MPMSpatial *);
PetscErrorCode MPMMigrateSwarm(MPMCore *, MPMSpatial *);
PetscErrorCode MPMMigrateDirect(MPMCore *, MPMSpatial *);

#endif
