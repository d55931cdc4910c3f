/* fields.h - what a particle carries: the rows of fields.def as bits, as pointers to arrays (views) and as numbers of
   components. */
#ifndef MPM_FIELDS_H
#define MPM_FIELDS_H

#include "base/tensor.h"

/* Sets of fields are bits, MPM_BIT(name); rows of phases and of materials use them. */
enum {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) MPM_FIELD_INDEX_##name,
#include "physics/fields.def"
  MPM_NUM_FIELDS
};
#define MPM_BIT(name) (1 << MPM_FIELD_INDEX_##name)
_Static_assert(MPM_NUM_FIELDS < 31, "sets of fields are the bits of an int");

/* Where a field is stored: the column `home` of fields.def. */
typedef enum { MPM_STATE, MPM_SWARM, MPM_SCRATCH } MPMHome;

/* The properties of a scene that decide which fields it has: the column `present` of fields.def. */
typedef struct {
  PetscInt  state;     /* bits of the fields that the materials list */
  PetscBool kinds;     /* there is more than one kind of particle */
  PetscBool affine;    /* the transfer is apic */
  PetscBool residual;  /* the transfer is xpic or afmpm */
  PetscBool stretched; /* domains of gimp particles follow the deformation */
  PetscBool increment; /* a later phase than that of motion adds the displacement to x */
  PetscBool forced;    /* there are body forces or loads */
  PetscBool loaded;    /* there are loads on surfaces */
  PetscBool chosen;    /* there are loads on volumes */
  PetscBool rim;       /* there are walls that only push */
  PetscBool barred;    /* F-bar in the total frame, or in static steps */
  PetscBool stepped;   /* static steps of the updated frame */
  PetscBool start;     /* the position at the start is needed */
  PetscBool all;       /* every field is present, needed or not (-method_carry all) */
} MPMNeeds;

/* Particles as kernels see them: for each field a pointer to its array [n][components], or NULL where the scene has no
   such field or the current phase did not declare it. */
typedef struct {
  PetscInt n;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) ctype *name;
#include "physics/fields.def"
} MPMView;

/* MPMComponents_x(dim), ...: the components of each field. */
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  MPM_INLINE int MPMComponents_##name(int dim)                                                                         \
  {                                                                                                                    \
    (void)dim;                                                                                                         \
    return nc;                                                                                                         \
  }
#include "physics/fields.def"

#endif
