/* fields.h - what a particle carries: the rows of fields.def as bits, views and components. */
#ifndef MPM_FIELDS_H
#define MPM_FIELDS_H

#include "base/tensor.h"

/* Bits that name fields, for the rows of phases and of materials. */
enum {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) MPM_FIELD_INDEX_##name,
#include "physics/fields.def"
#undef MPM_FIELD
  MPM_NUM_FIELDS
};
#define MPM_BIT(name) (1 << MPM_FIELD_INDEX_##name)
_Static_assert(MPM_NUM_FIELDS < 31, "sets of fields are the bits of an int");

/* Where a field lives. */
typedef enum { MPM_STATE, MPM_SWARM, MPM_SCRATCH } MPMHome;

/* What of the scene decides which fields there are: `present` of fields.def. */
typedef struct {
  PetscInt  state;     /* bits of the fields that its materials list */
  PetscBool kinds;     /* is there more than one kind of particle? */
  PetscBool affine;    /* apic */
  PetscBool residual;  /* xpic */
  PetscBool stretched; /* domains of gimp follow the deformation */
  PetscBool increment; /* the displacement of a step waits for the commit */
  PetscBool forced;    /* body forces or loads */
  PetscBool surface;   /* loads */
  PetscBool start;     /* particles keep their place at the start */
} MPMNeeds;

/* Particles as kernels see them: a pointer for each field, rows of its components, one row a particle; NULL where the
   scene has no such field or the phase at work did not declare it. */
typedef struct {
  PetscInt n;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) ctype *name;
#include "physics/fields.def"
#undef MPM_FIELD
} MPMView;

/* Components of each field: MPMComponents_x(dim), ... */
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  MPM_INLINE int MPMComponents_##name(int dim)                                                                         \
  {                                                                                                                    \
    (void)dim;                                                                                                         \
    return nc;                                                                                                         \
  }
#include "physics/fields.def"
#undef MPM_FIELD

#endif
