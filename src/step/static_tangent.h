/* static_tangent.h - what a particle adds to the tangent stiffness of a static step: the derivative of its stress and of its
   load by the displacement gradient G = sum_i u_i (x) grad_X phi_i of the total frame, with F-bar that by the means of its cell
   too. docs/method.md has the equations (Statics). */
#ifndef MPM_STATIC_TANGENT_H
#define MPM_STATIC_TANGENT_H

#include "physics/tangent.h"
#include "step/static.h"

/* The numbers of a gradient or stress: [dim*dim], of a body of revolution then that around the axis (physics/tangent.h). */
#define MPM_STATIC_NC 10

/* The particles, whose state is that as the step began, and what the laws say of the trial state: Kirchhoff stresses
   tau [n][nc], Pa, and their derivatives C [n][nc*nc] by dl = df f^-1, Pa. */
typedef struct {
  MPMTangent law;
  MPMView    view, loaded;  /* loaded: with F and F33 of the trial state */
  PetscReal *F, *F33, *bar; /* of the trial state; NULL: there are none */
  PetscReal *tau, *C;
} MPMStaticLaw;

/* Of F-bar, for the particles of one material in a cell: the mean of the pressures, Pa, its derivative by theta, Pa, and
   the volume, m^3, of the trial state. weight: -method_lock_share of that volume. Theta is the mean of tr dl by volume, and eta
   the change of the mean pressure without that by theta, Pa. */
typedef struct {
  PetscReal mean, slope, volume, weight;
} MPMStaticMeans;

/* What a particle does: dR by its own G, V0 A [nc][nc] in stress and B [dim][nc] in load, N; by theta, `forces` [nc] and
   `body` [dim], N; and how theta and eta depend on G, [nc]. */
typedef struct {
  PetscInt  nc;
  PetscReal A[MPM_STATIC_NC * MPM_STATIC_NC], B[3 * MPM_STATIC_NC];
  PetscReal forces[MPM_STATIC_NC], body[3], theta[MPM_STATIC_NC], eta[MPM_STATIC_NC];
} MPMStaticParticle;

/* Returns what values [nc] of a gradient have along axis d of node i of a stencil: values : dG/du_id. */
MPM_INLINE PetscReal MPMStaticAlong(PetscInt dim, PetscInt nc, const MPMStaticNodes *t, PetscInt i, PetscInt d,
                                    const PetscReal values[])
{
  PetscReal sum = 0;

  for (PetscInt e = 0; e < dim; e++) sum += values[d * dim + e] * t->g[i][e];
  if (nc > dim * dim && d == 0) sum += values[dim * dim] * t->w[i] / t->r;
  return sum;
}

/* Begin computes the stresses and derivatives of the state that the residual was last made of, and puts the particles back to
   that as the step began; End frees them. FindMeans sets those of particles `from` to `to` - 1 of the order, of material m.
   ParticleTangent computes what particle p does. Not collective. */
PetscErrorCode MPMStaticLawBegin(struct MPMStatic *, MPMStaticLaw *);
PetscErrorCode MPMStaticLawEnd(struct MPMStatic *, MPMStaticLaw *);
void MPMStaticFindMeans(const struct MPMStatic *, const MPMStaticLaw *, PetscInt m, PetscInt from, PetscInt to,
                        MPMStaticMeans *);
PetscErrorCode MPMStaticParticleTangent(struct MPMStatic *, MPMStaticLaw *, const MPMStaticMeans *, PetscInt p,
                                        MPMStaticParticle *);

#endif
