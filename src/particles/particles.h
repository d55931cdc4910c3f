/* particles.h - the particles of a process: storage, order, digest. */
#ifndef MPM_PARTICLES_H
#define MPM_PARTICLES_H

#include <petscdmswarm.h>
#include "kernels/patch.h"

/* The fields of fields.def: a DMSWARM_BASIC swarm stores those that stay, plain arrays the scratch. */
typedef struct {
  DM         swarm;
  PetscInt   dim, n, capacity;        /* n: particles here; capacity: of the scratch and of order */
  PetscInt64 total;                   /* particles of the whole scene */
  PetscInt64 ids;                     /* the fingerprint of all particles of the scene */
  PetscReal  scattered;               /* particles that came to another cell since the storage was put in order */
  void      *scratch[MPM_NUM_FIELDS]; /* arrays of the scratch fields */
  PetscBool  present[MPM_NUM_FIELDS]; /* does the scene have the field? */
  PetscInt   bytes[MPM_NUM_FIELDS];   /* of a particle */
  PetscInt  *order, *start;           /* [n] particles by (cell, id); [cells of the patch + 1] first entry of each */
  PetscInt  *spare;                   /* [n] the next order is made here */
  PetscInt  *arrivals;                /* [cells] particles that come to a cell; all 0 between uses */
  PetscInt  *movers, nmovers;         /* the particles that changed their cell since, as in MPMPatch; -1: not known */
  PetscInt   nkept; /* particles below this one are where order has them, but those that changed cell or left */
  PetscInt   nstart;
} MPMParticles;

/* Rows of fields.def. */
typedef struct {
  const char   *name, *unit, *meaning;
  PetscDataType type;
  MPMHome       home;
} MPMFieldInfo;
extern const MPMFieldInfo MPMFields[MPM_NUM_FIELDS];
PetscInt                  MPMFieldComponents(PetscInt field, PetscInt dim);

#define MPM_ROW_BYTES (9 * sizeof(PetscReal)) /* of a field's row, at most: a tensor in 3-D */

/* --- Storage (storage.c) ----------------------------------------------------------------------------------------- */

PetscErrorCode MPMParticlesLayout(MPMParticles *, PetscInt dim, const MPMNeeds *);
PetscErrorCode MPMParticlesCreate(MPMParticles *, MPI_Comm);
PetscErrorCode MPMParticlesDestroy(MPMParticles *);
PetscErrorCode MPMParticlesSetSize(MPMParticles *, PetscInt n);
PetscErrorCode MPMParticlesResize(MPMParticles *);
PetscErrorCode MPMParticlesGetView(MPMParticles *, PetscInt fields, MPMView *);
PetscErrorCode MPMParticlesRestoreView(MPMParticles *, PetscInt fields, MPMView *);
PetscErrorCode MPMParticlesGetField(MPMParticles *, PetscInt field, void **at);
PetscErrorCode MPMParticlesRestoreField(MPMParticles *, PetscInt field);
PetscInt       MPMParticlesBytes(const MPMParticles *, MPMHome most);
PetscInt       MPMParticlesMemory(const MPMParticles *);
size_t         MPMParticlesRowBytes(const MPMParticles *, PetscInt fields);

/* --- Order (order.c) --------------------------------------------------------------------------------------------- */

PetscErrorCode MPMParticlesSort(MPMParticles *, const MPMPatch *);
PetscErrorCode MPMParticlesLocate(MPMParticles *, const MPMPatch *, const MPMKind *);
PetscErrorCode MPMParticlesLeavers(MPMParticles *, PetscInt *n, PetscInt **which);

/* --- Digest (digest.c) ------------------------------------------------------------------------------------------- */

uint64_t       MPMParticleHash(PetscInt64 id);
PetscErrorCode MPMParticlesFingerprint(MPMParticles *, PetscInt64 *ids);
PetscErrorCode MPMParticlesCheck(MPMParticles *, MPI_Comm, PetscInt64 n, PetscInt64 ids);
PetscErrorCode MPMParticlesDigest(MPMParticles *, MPI_Comm, PetscInt64 *digest);

/* Calls an inline function with the bytes of a field's row first: of known widths, they are copied in registers. */
/* clang-format off */
#define MPM_FOR_WIDTH(bytes, FUNCTION, ...)                                                                            \
  do switch (bytes) {                                                                                                  \
    case 4:  FUNCTION(4, __VA_ARGS__);  break;                                                                         \
    case 8:  FUNCTION(8, __VA_ARGS__);  break;                                                                         \
    case 16: FUNCTION(16, __VA_ARGS__); break;                                                                         \
    case 24: FUNCTION(24, __VA_ARGS__); break;                                                                         \
    case 32: FUNCTION(32, __VA_ARGS__); break;                                                                         \
    case 48: FUNCTION(48, __VA_ARGS__); break;                                                                         \
    case 72: FUNCTION(72, __VA_ARGS__); break;                                                                         \
    default: FUNCTION((size_t)(bytes), __VA_ARGS__);                                                                   \
    }                                                                                                                  \
  while (0)
/* clang-format on */

#endif
