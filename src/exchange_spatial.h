/* exchange_spatial.h - what the files of the spatial decomposition share: exchange_spatial.c, spatial_layout.c, halo.c
 * and migrate.c. */
#ifndef MPM_EXCHANGE_SPATIAL_H
#define MPM_EXCHANGE_SPATIAL_H

#include <petscsf.h>
#include "mpm.h"

enum { MPM_TAG_MIGRATE = 1, MPM_TAG_HALO = 8 }; /* halo: + the direction, since a neighbour may be so in several */
#define MPM_MAX_NEIGHBOURS 7                    /* lower, or upper, sides of a box in 3-D */

/* Fields that are constant in a step: a halo point gets them once; its cell is found here. */
#define MPM_STEADY (MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(kind) | MPM_BIT(l) | MPM_BIT(cell))

typedef struct {
  PetscMPIInt rank, tag;
  PetscInt    lo[3], hi[3];       /* cells [lo, hi) whose points it needs, nodes of the grid */
  PetscInt    shift[3];           /* to be added to the cells of points that come: across periodic faces */
  PetscInt    n, capacity, *list; /* [n] those points */
} MPMNeighbour;

typedef struct {
  MPI_Comm     comm; /* our own tags */
  MPI_Datatype status_type;
  MPI_Op       status_op;
  PetscInt     p[3], *first[3]; /* process grid; [p] first own node of each part of an axis */
  int          nto, nfrom;
  MPMNeighbour to[MPM_MAX_NEIGHBOURS], from[MPM_MAX_NEIGHBOURS]; /* from: rank, tag, shift, n */
  PetscInt     nhalo, halo_capacity;
  void        *halo[MPM_NUM_FIELDS];          /* [nhalo] copies, by neighbour */
  PetscInt    *order, order_capacity, *start; /* own and halo points by (cell, id); [cells+1] */
  PetscInt    *count;                         /* [cells] halo points; all 0 between uses */
  PetscSF      ghosts;                        /* of node values */
  MPI_Datatype vel_type;
  char        *out, *in; /* messages */
  size_t       out_capacity, in_capacity;
  PetscInt64   ids;    /* fingerprint of the points here */
  PetscBool    ranked; /* DMSwarm's rank field holds the owners */
  DM           sums;   /* of -parallel_sums roundoff */
  PetscReal    lost;   /* s lost to imbalance since the cuts were last looked at, by the model */
} MPMSpatial;

MPMView        MPMHaloView(const MPMSpatial *, PetscInt fields);
PetscErrorCode MPMHaloUpdate(MPM, MPMSpatial *, PetscBool changed);
PetscErrorCode MPMHaloExchange(MPM, MPMSpatial *, PetscInt fields);
PetscErrorCode MPMSpatialLayout(MPM);
PetscErrorCode MPMSpatialTearDown(MPM);
PetscMPIInt    MPMSpatialOwner(const MPMSpatial *, PetscInt dim, const PetscInt base[]);
PetscErrorCode MPMMigrateSwarm(MPM, MPMSpatial *);
PetscErrorCode MPMMigrateDirect(MPM, MPMSpatial *);

#endif
