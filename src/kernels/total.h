/* total.h - what the transfers do otherwise in the total frame, whose weights are those of the reference positions X:
   the forces are those of the first Piola-Kirchhoff stress, and waves have their speed in the reference state.
   docs/method.md has the equations (The total frame). */
#ifndef MPM_TOTAL_H
#define MPM_TOTAL_H

#include "kernels/rare.h"

/* Sets back = F^-1 [dim*dim]. F has a determinant other than 0, or back is not finite. */
MPM_INLINE void MPMInverse(int dim, const MPMReal *F, MPMReal *back)
{
  const MPMReal inverse = 1.0 / MPMDet(dim, F);

  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      const int p = (e + 1) % 3, q = (e + 2) % 3, r = (d + 1) % 3, s = (d + 2) % 3;

      if (dim == 1) back[0] = inverse;
      if (dim == 2) back[d * 2 + e] = (d == e ? 1.0 : -1.0) * F[(1 - e) * 2 + 1 - d] * inverse;
      if (dim == 3) back[d * 3 + e] = (F[p * 3 + r] * F[q * 3 + s] - F[p * 3 + s] * F[q * 3 + r]) * inverse;
    }
}

/* Sets Q = A B^-1 [dim*dim]. */
MPM_INLINE void MPMQuotient(int dim, const MPMReal *A, const MPMReal *B, MPMReal *Q)
{
  MPMReal back[9];

  MPMInverse(dim, B, back);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      MPMReal s = A[d * dim] * back[e];
      for (int k = 1; k < dim; k++) s = MPMFma(A[d * dim + k], back[k * dim + e], s);
      Q[d * dim + e] = s;
    }
}

/* Reads F [dim*dim] of a vector of particles from lane l on; times the factor of F-bar, if there is one. */
MPM_INLINE void MPMMotionGradient(int dim, const MPMView *particles, const MPMBlockOrder *o, PetscInt l, MPMReal *F)
{
  MPMReal bar;

  MPMLoad(dim * dim, particles->F, o, l, F);
  if (!particles->bar) return;
  MPMLoad(1, particles->bar, o, l, &bar);
  for (int k = 0; k < dim * dim; k++) F[k] = bar * F[k];
}

/* Returns F33 of a vector of particles of bodies of revolution from lane l on; times the factor of F-bar, if there is
   one; in a static step of the updated frame that of the step. */
MPM_INLINE MPMReal MPMMotionAround(const MPMView *particles, const MPMBlockOrder *o, PetscInt l)
{
  MPMReal F33, bar;

  if (particles->H33) {
    MPMLoad(1, particles->H33, o, l, &F33);
    return F33 + 1.0;
  }
  MPMLoad(1, particles->F33, o, l, &F33);
  if (!particles->bar) return F33;
  MPMLoad(1, particles->bar, o, l, &bar);
  return bar * F33;
}

/* Turns S [dim*dim], Pa, of a vector of particles from lane l on, from a Kirchhoff stress into the first
   Piola-Kirchhoff stress S F^-T, with the gradient of the motion; in a static step of the updated frame with that of the
   step, I + H. */
MPM_INLINE void MPMPiola(int dim, const MPMView *particles, const MPMBlockOrder *o, const MPMBlock *b, PetscInt l,
                         MPMReal *S)
{
  MPMReal F[9], back[9], P[9];

  if (particles->H) {
    MPMLoad(dim * dim, particles->H, o, l, F);
    for (int k = 0; k < dim * dim; k += dim + 1) F[k] = F[k] + 1.0;
  } else if (particles->bar)
    MPMMotionGradient(dim, particles, o, l, F);
  else
    for (int k = 0; k < dim * dim; k++) F[k] = MPMRead(&b->F[k][l]);
  MPMInverse(dim, F, back);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      P[d * dim + e] = S[d * dim] * back[e * dim];
      for (int k = 1; k < dim; k++) P[d * dim + e] = MPMFma(S[d * dim + k], back[e * dim + k], P[d * dim + e]);
    }
  for (int k = 0; k < dim * dim; k++) S[k] = P[k];
}

/* Keeps the displacement gradients dt L [dim*dim] of a block in a static step of the updated frame, in bodies of
   revolution also that around the axis. */
MPM_INLINE void MPMKeepGradients(int dim, const MPMParams *par, const MPMView *particles, const MPMBlockOrder *o,
                                 const MPMComponent *L)
{
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
    MPMReal H[9];

    for (int k = 0; k < dim * dim; k++) H[k] = par->dt * MPMRead(&L[k][l]);
    MPMStore(dim * dim, H, o, l, l, l + MPM_WIDTH, particles->H);
    if (!particles->H33) continue;
    H[0] = par->dt * MPMRead(&L[4][l]);
    MPMStore(1, H, o, l, l, l + MPM_WIDTH, particles->H33);
  }
}

/* Multiplies the squared wave speeds c2, m^2/s^2, of lanes from `from` to next-1 by a bound of 1/(least stretch)^2: the
   largest row sum of |(F^T F)^-1| (Gershgorin). A wave that runs at c in the deformed state passes reference lengths at
   c over the stretch along its way. round: the stretch around the axis counts too. */
MPM_INLINE void MPMReferenceSpeed2(int dim, int round, const MPMBlock *b, PetscInt from, PetscInt next, MPMComponent c2)
{
  for (PetscInt l = from; l < next; l += MPM_WIDTH) {
    MPMReal F[9], back[9], most = MPMAll(0);

    for (int k = 0; k < dim * dim; k++) F[k] = MPMRead(&b->F[k][l]);
    MPMInverse(dim, F, back);
    for (int d = 0; d < dim; d++) {
      MPMReal row = MPMAll(0);

      for (int e = 0; e < dim; e++) {
        MPMReal s = back[d * dim] * back[e * dim];
        for (int k = 1; k < dim; k++) s = MPMFma(back[d * dim + k], back[e * dim + k], s);
        row += MPMAbs(s);
      }
      most = MPMMax(most, row);
    }
    if (round) most = MPMMax(most, 1.0 / (MPMRead(&b->F33[0][l]) * MPMRead(&b->F33[0][l])));
    MPMWrite(&c2[l], MPMRead(&c2[l]) * most);
  }
}

/* Turns the gradients of the displacements of a block, grad u [dim*dim], 1, into the velocity gradients L, 1/s, that
   lead from the old gradient of the motion to I + grad u; in bodies of revolution also row 4, u_R/R, into that around the
   axis. */
MPM_INLINE void MPMRatesTotal(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                              MPMComponent *L)
{
  const int       round = dim == 2 && patch->grid->round;
  const PetscReal rate  = 1 / par->dt;

  for (PetscInt l = 0; l < o->lanes; l += MPM_WIDTH) {
    MPMReal F[9], was[9], G[9];

    for (int k = 0; k < dim * dim; k++) F[k] = MPMRead(&L[k][l]) + (PetscReal)(k % (dim + 1) == 0);
    MPMMotionGradient(dim, &patch->particles, o, l, was);
    MPMQuotient(dim, F, was, G);
    for (int k = 0; k < dim * dim; k++) MPMWrite(&L[k][l], rate * (G[k] - (PetscReal)(k % (dim + 1) == 0)));
    if (round) MPMWrite(&L[4][l], rate * ((1.0 + MPMRead(&L[4][l])) / MPMMotionAround(&patch->particles, o, l) - 1.0));
  }
}

/* Sets a block's F = I + grad u, over the factor of F-bar if there is one, positions X + u and velocities from value
   (u, then v, [2 dim]) and grad u [dim*dim], 1, of the total frame; in bodies of revolution F33 = 1 + u_R/R, of which
   row 4 of grad is u_R/R. v2 becomes the largest squared velocity so far, bad the lanes whose J is not a positive number. */
MPM_INLINE void MPMDeformTotal(int dim, const MPMPatch *patch, const MPMBlockOrder *o, const MPMStencils *s,
                               const MPMComponent *value, const MPMComponent *grad, MPMBlock *b, MPMReal *v2,
                               MPMMask *bad)
{
  const MPMView *particles = &patch->particles;
  MPMMask        in        = MPMNot(MPMNone());

  *bad = MPMNone();
  for (PetscInt l = 0; l < o->lanes; l += MPM_WIDTH) {
    MPMReal x[3], v[3], F[9], J, bar = MPMAll(1), own = MPMAll(0);

    for (int d = 0; d < dim; d++) {
      x[d] = MPMRead(&s->x[d][l]) + MPMRead(&value[d][l]);
      v[d] = MPMRead(&value[dim + d][l]);
      own  = own + v[d] * v[d];
      if (patch->grid->periodic[d]) in &= (x[d] >= patch->grid->lower[d]) & (x[d] < patch->grid->upper[d]);
    }
    if (particles->bar) MPMLoad(1, particles->bar, o, l, &bar);
    for (int k = 0; k < dim * dim; k++) {
      F[k] = MPMRead(&grad[k][l]) + (PetscReal)(k % (dim + 1) == 0);
      if (particles->bar) F[k] = F[k] / bar;
      MPMWrite(&b->F[k][l], F[k]);
    }
    J = MPMDet(dim, F);
    if (dim == 2 && patch->grid->round) {
      MPMReal F33 = MPMRead(&grad[4][l]) + 1.0;

      if (particles->bar) F33 = F33 / bar;
      MPMWrite(&b->F33[0][l], F33);
      MPMStore(1, &F33, o, l, l, l + MPM_WIDTH, particles->F33);
      *bad |= MPMNot(F33 > 0.0);
      J *= F33;
    }
    *bad |= MPMNot((J > 0.0) & (J < PETSC_MAX_REAL));
    MPMStore(dim, x, o, l, l, l + MPM_WIDTH, particles->x);
    MPMStore(dim, v, o, l, l, l + MPM_WIDTH, particles->v);
    MPMStore(dim * dim, F, o, l, l, l + MPM_WIDTH, particles->F);
    *v2 = MPMMax(*v2, own);
  }
  if (MPMAny(MPMNot(in))) MPMRareWrap(dim, patch, o->n, o->particle);
}

#endif
