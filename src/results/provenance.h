/* provenance.h - what made a file of results: scene, version, libraries, machine, options, grid. */
#ifndef MPM_PROVENANCE_H
#define MPM_PROVENANCE_H

#include "results/hdf5.h"
#include "scene/scene.h"
#if defined(PETSC_HAVE_HDF5)

/* Writes it as attributes of a file, where that is open, and sets *room, if not NULL, to about the bytes that it takes.
   Not collective. */
PetscErrorCode MPMProvenanceWrite(const MPMCore *, const MPMScene *, hid_t file, size_t *room);

#endif
#endif
