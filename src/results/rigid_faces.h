/* rigid_faces.h - the surfaces of rigid bodies in snapshots (rigid_faces.c). */
#ifndef MPM_RIGIDS_H
#define MPM_RIGIDS_H

#include "results/hdf5.h"
#include "results/output.h"

/* Samples the surfaces, if there are rigid bodies and it has not been done; frees them. Not collective. */
PetscErrorCode MPMRigidFacesMake(MPMOutput *, const MPMCore *);
PetscErrorCode MPMRigidFacesDestroy(MPMOutput *);

#if defined(PETSC_HAVE_HDF5)
/* Make the datasets of the rigid bodies in the group of a snapshot, and write them from *set on; the first process
   writes. Not collective. */
PetscErrorCode MPMRigidDatasets(const MPMOutput *, const MPMCore *, MPMFile *, hid_t step);
PetscErrorCode MPMRigidWrite(const MPMOutput *, const MPMCore *, MPMFile *, PetscInt *set);
#endif

#endif
