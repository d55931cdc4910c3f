/* particles.h - the particles of a process: their storage, order and digest. The functions are described where they are
   defined. */
#ifndef MPM_PARTICLES_H
#define MPM_PARTICLES_H

#include <petscdmswarm.h>
#include "kernels/patch.h"

/* The fields of fields.def: a DMSWARM_BASIC swarm stores those of state and swarm, plain arrays the scratch fields. */
typedef struct {
  DM         swarm;
  PetscInt   dim, n, capacity;        /* n: particles of this process; capacity: length of scratch fields and order */
  PetscInt64 total;                   /* particles of the whole scene, on all processes */
  PetscInt64 born;                    /* particles at the start of the run: ids are below this number */
  PetscInt64 waiting;                 /* of these, those that have not flowed in yet */
  PetscBool  flows;                   /* there are bodies that flow in */
  PetscInt64 removed;                 /* of these, those that left with their bodies at restarts (-remove) */
  PetscInt64 ids;                     /* the fingerprint of all particles of the scene; 0 before the first check */
  PetscReal  scattered;               /* changes of cell since the storage was put in order */
  void      *scratch[MPM_NUM_FIELDS]; /* the arrays of the scratch fields */
  PetscBool  present[MPM_NUM_FIELDS]; /* the scene has the field */
  PetscBool  needed[MPM_NUM_FIELDS];  /* the scene needs it; the digest has no other fields */
  PetscInt   bytes[MPM_NUM_FIELDS];   /* bytes of a field's row */
  PetscInt  *order, *start;           /* [n] particles by (cell, id); [cells of the patch + 1] first entry of each */
  PetscInt  *spare;                   /* [n] memory for the next order */
  PetscInt  *incoming;                /* [cells] particles that come to a cell; all 0 between uses */
  PetscInt  *movers, nmovers;         /* the movers since the order was made, as in MPMPatch; nmovers -1: not known */
  PetscInt   saved;                   /* the fields (bits) that a step changes, if it is to be undone; else 0 */
  char      *copy;                    /* [n] rows of each of these, one field after the other */
  size_t     copy_room;               /* bytes */
  PetscInt   room, places;            /* the most particles that came in a migration; places of the swarm's fields */
  PetscInt   nkept;                   /* particles below this number are where the order has them, but for movers */
  PetscInt   nstart;
#if defined(MPM_POISON)
  uint64_t written[MPM_NUM_FIELDS]; /* what a field was before a phase (poison.c) */
#endif
} MPMParticles;

/* What fields.def says of a field. */
typedef struct {
  const char   *name, *unit, *meaning;
  PetscDataType type;
  MPMHome       home;
} MPMFieldInfo;
extern const MPMFieldInfo MPMFields[MPM_NUM_FIELDS];

#define MPM_ROW_BYTES (9 * sizeof(PetscReal)) /* largest number of bytes of a field's row: a tensor in 3-D */

/* --- Storage (storage.c) ------------------------------------------------------------------------------------------ */

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
PetscErrorCode MPMParticlesSave(MPMParticles *);
PetscErrorCode MPMParticlesPutBack(MPMParticles *);

/* --- Order (order.c) ---------------------------------------------------------------------------------------------- */

PetscErrorCode MPMParticlesSort(MPMParticles *, const MPMPatch *);
PetscErrorCode MPMParticlesLocate(MPMParticles *, const MPMPatch *, const MPMKind *);
PetscErrorCode MPMParticlesLeavers(MPMParticles *, PetscInt *n, PetscInt **which);

/* --- Digest (digest.c) -------------------------------------------------------------------------------------------- */

uint64_t       MPMParticleHash(PetscInt64 id);
PetscErrorCode MPMParticlesFingerprint(MPMParticles *, PetscInt64 *ids);
PetscErrorCode MPMParticlesCheck(MPMParticles *, MPI_Comm, PetscInt64 n, PetscInt64 ids);
PetscErrorCode MPMParticlesDigest(MPMParticles *, MPI_Comm, PetscInt64 *digest);

/* --- Particles that left the grid (remove.c) ---------------------------------------------------------------------- */

PetscErrorCode MPMParticlesRemove(MPMParticles *, PetscInt64 *n, PetscInt64 *ids);

/* Calls an inline function with the bytes of a field's row as its first argument. The usual numbers are constants, with
   which the compiler copies a row in registers. */
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
