/* spatial.h - what the files of the spatial decomposition share: spatial.c, layout.c and migrate.c. */
#ifndef MPM_SPATIAL_H
#define MPM_SPATIAL_H

#include <petscsf.h>
#include "base/message.h"
#include "base/simulate.h"
#include "parallel/exchange.h"

enum {
  MPM_TAG_MIGRATE = 1,
  MPM_TAG_TILES   = 8
};                           /* migrate: 1 down, 2 up; tiles: + the direction, since a neighbour may be so in several */
#define MPM_MAX_NEIGHBOURS 7 /* lower, or upper, sides of a box in 3-D */

typedef struct {
  PetscMPIInt rank, tag;
  int         toward[3]; /* 1: it lies there on this axis, above or below */
} MPMNeighbour;

typedef struct {
  MPI_Comm     comm; /* our own tags */
  MPI_Datatype status_type;
  MPI_Op       status_op;
  PetscInt     p[3], *first[3]; /* process grid; [p] first own node of each part of an axis */
  PetscInt     me[3];
  PetscMPIInt  beside[3][2]; /* processes below and above on an axis, MPI_PROC_NULL: none */
  int          nto, nfrom;
  MPMNeighbour to[MPM_MAX_NEIGHBOURS], from[MPM_MAX_NEIGHBOURS];
  MPI_Request  request[2 * MPM_MAX_NEIGHBOURS]; /* sums that come, sums that go */
  int          fault;                           /* what MPI said while particles were summed */
  PetscSF      ghosts;                          /* of node values */
  MPI_Datatype motion_type;
  char        *out, *in; /* messages */
  size_t       out_capacity, in_capacity;
  PetscInt     nleavers, *leaver; /* particles that left, ascending */
  PetscMPIInt *owner;             /* of each, the process that it goes to */
  int (*hops)[3];                 /* and how many boxes that is away on each axis */
  PetscInt64 ids;                 /* fingerprint of the particles here */
  PetscBool  ranked;              /* DMSwarm's rank field holds the owners */
  PetscReal  lost;                /* s lost to imbalance since the cuts were last looked at, by the model */
} MPMSpatial;

PetscErrorCode MPMSpatialLayout(MPMCore *);
PetscErrorCode MPMSpatialTearDown(MPMCore *);
PetscMPIInt    MPMSpatialOwner(const MPMSpatial *, const MPMGrid *, const PetscInt base[], int hops[3]);
PetscErrorCode MPMMigrateList(MPMCore *, MPMSpatial *, PetscInt64 *hops);
PetscErrorCode MPMMigrateForget(MPMSpatial *);
PetscErrorCode MPMMigrateSwarm(MPMCore *, MPMSpatial *);
PetscErrorCode MPMMigrateDirect(MPMCore *, MPMSpatial *);

#endif
