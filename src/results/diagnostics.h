/* diagnostics.h - the table of what a run shows of its state (diagnostics.def): columns of the history and fields of
   snapshots. It is used between steps, where output is due. */
#ifndef MPM_DIAGNOSTICS_H
#define MPM_DIAGNOSTICS_H

#include "scene/scene.h"

enum {
#define MPM_PARTICLE_QUANTITY(name, uses, word, unit, components, nc, whole, needs, reads) MPM_SHOWS_##name,
#define MPM_RUN_QUANTITY(name, uses, unit, whole)                                          MPM_SHOWS_##name,
#define MPM_LOST_QUANTITY(name, of, uses, unit, components, nc)                            MPM_SHOWS_##name,
#include "results/diagnostics.def"
  MPM_NUM_DIAGNOSTICS
};
#define MPM_MAX_COMPONENTS 9 /* of a field of snapshots: a tensor */
_Static_assert(MPM_NUM_DIAGNOSTICS <= 62, "sets of rows are the bits of a 64-bit integer, beside MPM_OUTPUT_GRID");

/* Sums over all particles of the quantities that the history shows or keeps. They are exact, so they are the same on
   any number of processes. Where a quantity is not finite they mean nothing. */
typedef struct {
  PetscReal  sum[MPM_NUM_DIAGNOSTICS][3]; /* [row][component] */
  PetscReal  energy[MPM_NUM_ENERGIES];    /* of core->energy, over all processes, J */
  PetscReal  rigid;                       /* the kinetic energy of free rigid bodies, J */
  PetscInt64 n;                           /* particles */
  PetscInt64 wrong;                       /* the smallest id of a particle with a quantity that is not finite, or -1 */
  PetscInt   wrong_row;                   /* the first row where that is so */
} MPMTotals;

/* What the functions of the table read. */
typedef struct {
  const MPMCore   *core;
  const MPMScene  *scene;
  const MPMTotals *start, *now; /* of the history, for quantities of the run */
  const float     *indicator;   /* [n] of the particles here, for the field error_indicator */
} MPMShown;

/* What a row is used for: a set of the words that diagnostics.def explains. */
enum {
  MPM_SHOW_FIELD     = 1,
  MPM_SHOW_COLUMN    = 2,
  MPM_SHOW_SUM       = 4,
  MPM_SHOW_TERM      = 8,
  MPM_SHOW_LOADS     = 16,
  MPM_SHOW_AXIAL     = 32,
  MPM_SHOW_ASKED     = 64,
  MPM_SHOW_LOST      = 128,
  MPM_SHOW_DAMPED    = 256,
  MPM_SHOW_RELAXED   = 512,
  MPM_SHOW_SYMMETRIC = 1024,
  MPM_SHOW_RIGID     = 2048,
  MPM_SHOW_FREE      = 4096,
  MPM_SHOW_STATIC    = 8192,
  MPM_SHOW_REST      = 16384,
  MPM_SHOW_STAGED    = 32768
};
typedef struct {
  const char *name, *word, *unit, *components;
  PetscInt    uses, nc;
  PetscBool   whole; /* does it have whole numbers? */
  PetscInt    needs; /* bits of the fields of particles without which a snapshot does not have it */
  PetscInt    reads; /* bits of those that particles have where something shows it */
  void (*fill)(const MPMShown *, const MPMView *, PetscInt p, PetscReal row[]); /* of particle p, row [nc]; or NULL */
  PetscReal (*value)(const MPMShown *);                                         /* of the run; or NULL */
  PetscInt of; /* LOST: the row of which it is the sum over the particles that were removed */
} MPMDiagnostic;
extern const MPMDiagnostic MPMDiagnostics[MPM_NUM_DIAGNOSTICS];

/* Return how many columns of the history a row has, of its components first .. first+n-1, and the value of one of them.
   A vector has one for each dimension of space, a vector of rotation one for each axis around which there is rotation.
   The totals are those in what is shown. */
PetscInt  MPMDiagnosticColumns(PetscInt row, const MPMCore *, PetscInt *first);
PetscReal MPMDiagnosticValue(const MPMShown *, PetscInt row, PetscInt component);

/* Returns how many components a quantity of particles with 1 or 3 components has in a scene, from *first on. */
PetscInt MPMDiagnosticAxes(PetscInt row, PetscInt dim, PetscInt *first);

/* Returns which fields of particles (bits) a run needs that shows these rows (bits), and the sums of its history. */
PetscInt MPMDiagnosticReads(PetscInt64 rows, const MPMCore *);

/* Returns whether snapshots of a scene with these fields of particles (bits) have the row. */
PetscBool MPMDiagnosticIsField(PetscInt row, PetscInt fields);

/* Returns whether the run has the row: some are kept only where an option or a load asks for them. */
PetscBool MPMDiagnosticIsOn(PetscInt row, const MPMCore *);

/* Returns where component k of a symmetric tensor (MPM_SYM_NC) is among the 9 of the stress that is shown. */
PetscInt MPMShownStress(PetscInt dim, PetscInt k);

/* Return numbers of a Cauchy stress [9], row by row, Pa: von Mises stress, mean pressure, least and greatest principal
   stress (stress.c). Not collective. */
PetscReal MPMShown_von_mises(const PetscReal stress[]);
PetscReal MPMShown_pressure(const PetscReal stress[]);
PetscReal MPMShown_stress_min(const PetscReal stress[]);
PetscReal MPMShown_stress_max(const PetscReal stress[]);

/* Sets row [3] to where particle p of a view ends along each axis, m: above its centre for sign 1, below for -1
   (edges.c). Not collective. */
void MPMShownEdge(const MPMShown *, const MPMView *, PetscInt p, PetscReal sign, PetscReal row[]);

/* Computes the totals of the present state. Collective on the exchange. */
PetscErrorCode MPMTotalsCompute(const MPMScene *, MPMCore *, MPMTotals *);

/* What leaves the grid with particles that are removed (lost.c): adds those outside the grid now to core->lost, before
   they are removed; sets the rows LOST of totals. The second is collective on the exchange. */
PetscErrorCode MPMLostAdd(const MPMScene *, MPMCore *);
PetscErrorCode MPMLostTotals(const MPMCore *, MPMTotals *);
/* Takes off what particles from `first` on bring, which flow in. */
PetscErrorCode MPMLostEnter(const MPMScene *, MPMCore *, PetscInt first);

/* Returns the sum of a row over all particles that there ever were, those that were removed as they left. */
PetscReal MPMShownEver(const MPMTotals *, PetscInt row, PetscInt component);

/* Returns the kinetic energy, that of free rigid bodies too, over the strain energy; infinite where there is no strain. */
static inline PetscReal MPMShownKineticShare(const MPMTotals *totals)
{
  const PetscReal kinetic = totals->sum[MPM_SHOWS_kinetic_energy][0] + totals->rigid,
                  strain  = totals->sum[MPM_SHOWS_strain_energy][0];

  return strain > 0 ? kinetic / strain : kinetic > 0 ? PETSC_INFINITY : 0;
}

/* Return the work since the start, J, of gravity alone, by where particles are now; that of gravity, body forces and
   loads, on free rigid bodies too; and the change of the energy less that work, J. */
PetscReal MPMShownGravity(const MPMShown *);
PetscReal MPMShownWork(const MPMShown *);
PetscReal MPMShownResidual(const MPMShown *);

#endif
