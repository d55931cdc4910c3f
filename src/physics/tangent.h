/* tangent.h - the stress of a finite displacement of the grid, and its derivative: what implicit steps need of the
   material laws. Nothing here is called in explicit steps.

   H = sum_i u_i (x) grad phi_i, with gradients at x_n, is the displacement gradient of a step, f = I + H and F = f F_n.
   The forces of the step are - sum_p V0 T grad phi, with T = tau f^-T, where tau in Pa is the Kirchhoff stress that the
   law has after the step.

   H and T have nc = MPMTangentNumbers numbers for a particle: [dim*dim], row-major, T not symmetric; of a body of
   revolution then u_r/r and T around the axis, tau_33/(1 + u_r/r), whose force on a node is -V0 T phi_i/r along r. The
   tangent A [nc][nc] in Pa has dT_k/dH_l in row k, column l: in terms of axes A_aBcD = dT_aB/dH_cD is
   A[((a dim + B) nc) + c dim + D]. It is the tangent of the algorithm: the derivative of what the law's return leaves.

   In the total frame, where G = sum_i u_i (x) grad_X phi_i and P = tau F^-T, use H = G F_n^-1 and P = T F_n^-T.

   docs/materials.md, Tangents, has the formulas and their sources. */
#ifndef MPM_TANGENT_H
#define MPM_TANGENT_H

#include "physics/material.h"

/* What is the same for all particles of a step. */
typedef struct {
  PetscInt           dim;
  PetscBool          round; /* bodies of revolution, as `round` of the materials says too */
  PetscInt           width; /* particles that laws compute at a time: MPMKernelWidth() or 1, with the same bits */
  PetscReal          dt;    /* of the step in s, above 0; only laws that depend on rates see it, else any will do */
  const MPMKind     *kinds; /* as in MPMParams */
  const MPMMaterial *materials;
  const MPMView     *particles; /* with kind, where there is one, and all fields of materials: the state at t_n */
} MPMTangent;

/* Returns nc. Not collective. */
MPM_INLINE PetscInt MPMTangentNumbers(PetscInt dim, PetscBool round)
{
  return dim * dim + (round ? 1 : 0);
}

/* Computes T [last-first][nc] in Pa of particles first .. last-1 of the view from H [last-first][nc] (1) and, unless
   it is NULL, their A [last-first][nc*nc] in Pa. The state of the particles is only read. Returns how many of them
   have det f or a volume ratio that is no positive number, also where H is not finite; their T and A are 0. Not
   collective; no errors. */
PetscInt MPMTangentTrial(const MPMTangent *, PetscInt first, PetscInt last, const PetscReal H[], PetscReal T[],
                         PetscReal A[]);

/* Gives particles first .. last-1 of the view the state at the end of the step: F, F33, J, and the other fields that
   their materials have, as an explicit step with L = H/dt does; MPMTangentTrial had the stress of just this state. (A
   fluid gets J det f and rates in the deformed state, where an explicit step has J (1 + dt tr L), and L.) Returns as
   MPMTangentTrial does; such particles keep their state. Not collective; no errors. */
PetscInt MPMTangentCommit(const MPMTangent *, PetscInt first, PetscInt last, const PetscReal H[]);

/* Return whether a material's law has a function `tangent`; otherwise A is made of central differences of T, with
   errors of about 1e-9 of its largest entry, and at a yield surface between the moduli of both sides. And whether A is
   symmetric, whatever the state. Not collective. */
PetscBool MPMTangentIsOwn(const MPMMaterial *);
PetscBool MPMTangentIsSymmetric(const MPMMaterial *, PetscInt dim);

#endif
