/* material.h - material laws as the transfers and the scene use them: a table of laws, the constants of a material, and
   blocks of particles, on which a law works. law.h makes the functions of a row from those of one particle. */
#ifndef MPM_MATERIAL_H
#define MPM_MATERIAL_H

#include "physics/fields.h"

#define MPM_STAGED    64 /* the most particles of a block (kernels/blocks.h) */
#define MPM_BLOCK     72 /* length of a block's arrays: the widest vector may go on past the last particle */
#define MPM_STRESS_NC 6  /* components of a symmetric tensor: xx xy xz yy yz zz */

/* Traits: properties of a law that the tests check. */
enum {
  MPM_OBJECTIVE    = 1,  /* a rotation rotates the stress and changes no energy */
  MPM_HYPERELASTIC = 2,  /* J sig F^-T is the derivative of the energy by F */
  MPM_SMALL_STRAIN = 4,  /* sig is the derivative of the energy by sym(F); right for small strains and rotations only */
  MPM_PLASTIC      = 8,  /* tau stays within a yield surface, flow dissipates; else a function of be with an energy */
  MPM_FLUID        = 16, /* tau is a function of J, plus a viscous part, which dissipates */
  MPM_ISOCHORIC    = 32, /* plastic flow keeps the volume, so that particles lock in their cell without F-bar */
  MPM_LOOSE        = 64, /* a body comes apart and flows, so that its particles' domains keep no shape */
  MPM_SYMMETRIC    = 128 /* its tangent (tangent.h) is symmetric, unless its constants say otherwise (`skew`) */
};

/* The fields that laws read and write, as X(name, components in 3-D). */
#define MPM_MATERIAL_FIELDS(X) X(F, 9) X(F33, 1) X(J, 1) X(be, 6) X(ep, 1) X(vc, 1) X(theta, 1) X(tau, 6)

#define MPM_MATERIAL_BIT(name, rows) | MPM_BIT(name)
#define MPM_MATERIAL_BITS            (0 MPM_MATERIAL_FIELDS(MPM_MATERIAL_BIT))

/* A component of the particles of a block; lanes past the last particle are leftovers. Its vectors are whole lines of
   the cache: one that lay across two would take twice as long to read or write. */
typedef PetscReal MPMComponent[MPM_BLOCK] __attribute__((aligned(64)));

/* The material state of a block of particles. The arrays of fields that the law's row does not list have no defined
   content. */
typedef struct {
#define MPM_MATERIAL_ROWS(name, rows) MPMComponent name[rows];
  MPM_MATERIAL_FIELDS(MPM_MATERIAL_ROWS)
#undef MPM_MATERIAL_ROWS
} MPMBlock;

typedef struct _MPMMaterial MPMMaterial;

/* A material law: functions of particles first .. last-1 of a block, one for each form ([MPMLawForm]): a dimension, or
   bodies of revolution, which have 2-D tensors and the stretch F33 around the axis. All J must be positive. A law
   without history has stress and no update. */
typedef struct _MPMMaterialLaw MPMMaterialLaw;
#define MPM_LAW_FORMS  4
#define MPM_TANGENT_NC 9
struct _MPMMaterialLaw {
  /* sets constants from the options; returns what is wrong, beginning with the name of an option, or NULL */
  const char *(*setup)(MPMMaterial *);
  /* computes the Kirchhoff stress b->tau = J sig in Pa */
  void (*stress[MPM_LAW_FORMS])(const MPMMaterial *, PetscInt first, PetscInt last, MPMBlock *b);
  /* computes the state after a step dt in s with velocity gradient L [dim*dim] in 1/s, after which bodies of revolution
     have v_r/r; b->F and b->F33 are updated before the call */
  void (*update[MPM_LAW_FORMS])(const MPMMaterial *, PetscReal dt, MPMComponent *L, PetscInt first, PetscInt last,
                                MPMBlock *b);
  /* computes the stored energy per reference volume W [last] in J/m^3 */
  void (*energy[MPM_LAW_FORMS])(const MPMMaterial *, PetscInt first, PetscInt last, const MPMBlock *b, PetscReal W[]);
  /* computes an upper bound c2 [last] of the squared speed of waves in the deformed state in m^2/s^2 */
  void (*speed2[MPM_LAW_FORMS])(const MPMMaterial *, PetscInt first, PetscInt last, const MPMBlock *b, PetscReal c2[]);
  /* stress, update and speed2 for vectors of 8, 4, 2 particles, which the transfers call; NULL: they call those
     above */
  const MPMMaterialLaw *lanes[3];
  /* for implicit steps alone, or NULL. tangent: computes C [6][MPM_TANGENT_NC] of particle p, the derivative in Pa of
     tau after the step by l = dH f^-1 [dim*dim], after which bodies of revolution have that of v_r/r (tangent.h); b has
     the state before the step, but F and F33 after it. trial: takes the place of update */
  void (*tangent[MPM_LAW_FORMS])(const MPMMaterial *, PetscReal dt, MPMComponent *L, PetscInt p, const MPMBlock *b,
                                 PetscReal C[6][MPM_TANGENT_NC]);
  void (*trial[MPM_LAW_FORMS])(const MPMMaterial *, PetscReal dt, MPMComponent *L, PetscInt first, PetscInt last,
                               MPMBlock *b);
};

typedef struct {
  /* parameters: the options that it takes besides rho; state: the fields that its particles carry; both are words
     separated by blanks */
  const char           *name, *parameters, *state, *what;
  PetscInt              traits;
  const MPMMaterialLaw *law;
} MPMMaterialType;

struct _MPMMaterial {
  char                   name[MPM_NAME_LEN];
  const MPMMaterialType *type;
  const MPMMaterialLaw  *asked;        /* the law that also sets the fields <name>? of its row; the set-up sets it */
  MPMMaterialType        own;          /* its type, where output asks for such a field: with that law */
  PetscBool              round;        /* of bodies of revolution? */
  PetscBool              skew;         /* constants for which a law with MPM_SYMMETRIC has no symmetric tangent */
  PetscInt               state;        /* bits of the fields of its type, less those that its constants do not need */
  PetscReal              rho, E, nu;   /* density in kg/m^3, Young's modulus in Pa, Poisson's ratio */
  PetscReal              lambda, mu;   /* Lame's constants in Pa, set by MPMMaterialSetUp */
  PetscReal              K, viscosity; /* of a fluid: bulk modulus in Pa, viscosity in Pa s */
  PetscReal              diffusivity;  /* of velocities by stress that depends on their gradient, m^2/s: it bounds dt */
  PetscReal              gamma, tension; /* of a fluid: Tait's exponent (0: linear), largest tension in Pa (< 0: any) */
  PetscReal              relaxation;     /* of a fluid, of sand: rate of the relaxation of volumes (kernels/volume.h) */
  PetscReal              follows; /* share of the mean that it takes at a time, at most 1; 0: it does not relax */
  PetscReal              yield, hardening;   /* of vonmises: yield stress and its slope by plastic strain in Pa */
  PetscReal              friction, dilation; /* of druckerprager: slopes of cone and flow, from angles in degrees */
  PetscReal              cohesion;       /* of druckerprager, in Pa; after the set-up the trace of tau at the apex */
  PetscReal c0, slope, gruneisen, shear; /* of johnsoncook: us = c0 + slope up in m/s, Grueneisen's constant, G in Pa */
  PetscReal power, rate, rate0, softening; /* of johnsoncook: exponent n, factor C, its rate in 1/s, exponent m */
  PetscReal temperature, melting;          /* of johnsoncook: at the start, where it melts (< 0: never), in K */
  PetscReal heat, share;                   /* of johnsoncook: specific heat in J/(kg K), share of work that heats */
  PetscBool plane;   /* of druckerprager: the angles are those of plane strain, not triaxial compression */
  PetscReal acts[2]; /* of druckerprager: the friction angle that acts in triaxial compression, in plane strain */
};

extern const MPMMaterialType MPMMaterialTypes[]; /* the rows of material.def; the last entry has no name */

/* Returns which form of the laws the particles of a material have. Not collective. */
MPM_INLINE PetscInt MPMLawForm(const MPMMaterial *m, PetscInt dim)
{
  return m->round ? MPM_LAW_FORMS - 1 : dim - 1;
}

#if MPM_WIDTH == 1
/* Returns the volume over that of the start of particle p of a view, from J or F of its material. Not collective. */
MPM_INLINE PetscReal MPMVolumeRatio(const MPMMaterial *m, PetscInt dim, const MPMView *view, PetscInt p)
{
  if (!(m->state & MPM_BIT(F))) return view->J[p];
  return MPMDet((int)dim, view->F + p * dim * dim) * (m->round ? view->F33[p] : 1);
}
#endif

/* Returns whether a material is a gas: a fluid whose pressure is that of an exponent far below a liquid's 7; 1.67 is the
   largest of gases. Not collective. */
MPM_INLINE PetscBool MPMMaterialIsGas(const MPMMaterial *m)
{
  return m->type->traits & MPM_FLUID && m->gamma > 0 && m->gamma < 2;
}

/* Sets Lame's constants from E and nu, the diffusivity from the viscosity, the law's own constants, and `state`.
   Returns what is wrong with the options, or NULL. Not collective. */
const char *MPMMaterialSetUp(MPMMaterial *);

/* Replaces F by J in the state of a material whose law has no use for F (F|J in its row): for scenes in which nothing
   else reads F. Not collective. */
void MPMMaterialDropF(MPMMaterial *);

/* Return the fields (bits) that the particles of a material carry only if output asks for them, "<name>?" in its
   row; and add those of these to its state that are among `fields`, with the law that sets them; afterwards the
   material may not be copied. Not collective. */
PetscInt MPMMaterialAsked(const MPMMaterial *);
void     MPMMaterialKeep(MPMMaterial *, PetscInt fields);

/* Return whether a body of the material keeps its shape but for its deformation, unlike what is loose; and whether such
   a body has plastic flow, of which its particles have the size, ep, and need no F to tell it. Not collective. */
PetscBool MPMMaterialKeepsShape(const MPMMaterial *);
PetscBool MPMMaterialKnowsFlow(const MPMMaterial *);

/* Copies the material state of particle p of a view to particle 0 of a block, as far as the view has it. Not
   collective. */
void MPMMaterialState(PetscInt dim, const MPMView *, PetscInt p, MPMBlock *);

/* A kind of particle: what all particles of a body have in common, so that no particle carries it. Bodies with the same
   material, particles per cell and cell size have one kind. */
typedef struct {
  PetscInt  material; /* row of the scene's materials */
  PetscReal m, V0;    /* mass in kg, reference volume in m^3 (unit thickness where dim < 3) */
  PetscReal l[3];     /* half-width of the particle's domain at the start, in cells */
  PetscInt  copy;     /* of the grid's nodes that they use */
} MPMKind;

/* Returns the kind of particle p of a view, which has the field `kind` where there are several. Not collective. */
MPM_INLINE const MPMKind *MPMKindOf(const MPMKind kinds[], const MPMView *view, PetscInt p)
{
  return &kinds[view->kind ? view->kind[p] : 0];
}

#endif
