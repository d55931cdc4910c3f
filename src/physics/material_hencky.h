/* material_hencky.h - what the plastic laws have in common: Hencky elasticity, tau = lambda tr(e) I + 2 mu e in Pa, on
   the elastic logarithmic strain e = ln(be)/2. In principal axes the return mapping of large strains is that of small
   strains (Simo, Comput. Methods Appl. Mech. Eng. 99 (1992) 61). See docs/materials.md (12c), (12d). be is updated by
   f = I + dt L as F is, so a step without flow rotates and stretches both alike. */
#ifndef MPM_MATERIAL_HENCKY_H
#define MPM_MATERIAL_HENCKY_H

#include "physics/law.h"

/* Computes the principal values b [3] and axes n [k][axis] of be, and the strains e [3] = ln(b)/2. */
MPM_INLINE void MPMHenckyStrain(int dim, const MPMReal be[6], MPMReal b[3], MPMReal n[3][3], MPMReal e[3])
{
  MPMEigen(dim, be, b, n);
  for (int k = 0; k < 3; k++) e[k] = 0.5 * MPMLog(b[k]);
}

/* Updates be <- f be f^T with f = I + dt L, L [dim*dim] in 1/s: the trial state, in which nothing flows; and, of
   particles without F, the volume ratio J <- det(f) J. */
MPM_INLINE void MPMHenckyTrial(int dim, const MPMMaterial *m, PetscReal dt, const MPMReal *L, MPMParticleState *now)
{
  MPMReal *be = now->be;
  MPMReal  f[9], fb[9];

  for (int k = 0; k < dim * dim; k++) f[k] = (PetscReal)(k % (dim + 1) == 0) + dt * L[k];
  if (m->state & MPM_BIT(J)) now->J *= now->round ? MPMDet(dim, f) * (1.0 + dt * now->L33) : MPMDet(dim, f);
  if (now->round) be[5] *= (1.0 + dt * now->L33) * (1.0 + dt * now->L33);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      fb[d * dim + e] = f[d * dim] * be[MPMSymIndex(0, e)];
      for (int k = 1; k < dim; k++) fb[d * dim + e] += f[d * dim + k] * be[MPMSymIndex(k, e)];
    }
  for (int d = 0; d < dim; d++)
    for (int e = d; e < dim; e++) {
      MPMReal s = fb[d * dim] * f[e * dim];
      for (int k = 1; k < dim; k++) s += fb[d * dim + k] * f[e * dim + k];
      be[MPMSymIndex(d, e)] = s;
    }
}

/* Makes the trial state, and computes its strains e [3] along axes n, their mean, and returns von Mises' equivalent
   stress q = sqrt(3/2) |dev tau| in Pa. */
MPM_INLINE MPMReal MPMHenckyTrialMises(int dim, const MPMMaterial *m, PetscReal dt, const MPMReal *L,
                                       MPMParticleState *now, MPMReal n[3][3], MPMReal e[3], MPMReal *mean)
{
  MPMReal b[3], q = MPMAll(0);

  MPMHenckyTrial(dim, m, dt, L, now);
  MPMHenckyStrain(dim, now->be, b, n, e);
  *mean = (e[0] + e[1] + e[2]) / 3;
  for (int k = 0; k < 3; k++) q += (e[k] - *mean) * (e[k] - *mean);
  return 2 * m->mu * MPMSqrt(1.5 * q);
}

/* Sets be to that of the strains e [3] along axes n where `new` is true; elsewhere be stays. */
MPM_INLINE void MPMHenckySetStrain(int dim, MPMMask new, const MPMReal e[3], MPMReal n[3][3], MPMReal be[6])
{
  MPMReal b[3], now[6];

  for (int k = 0; k < 3; k++) b[k] = MPMExp(2 * e[k]);
  MPMSpectral(dim, b, n, now);
  for (int k = 0; k < 6; k++) be[k] = MPMSelect(new, now[k], be[k]);
}

/* Computes the Kirchhoff stress tau in Pa of strains e [3] along axes n. */
MPM_INLINE void MPMHenckyStress(int dim, const MPMMaterial *m, const MPMReal e[3], MPMReal n[3][3], MPMReal tau[6])
{
  const MPMReal p = m->lambda * (e[0] + e[1] + e[2]);
  MPMReal       t[3];

  for (int k = 0; k < 3; k++) t[k] = p + 2 * m->mu * e[k];
  MPMSpectral(dim, t, n, tau);
}

#if MPM_WIDTH == 1
/* Computes the tangent C [6][MPM_TANGENT_NC] of laws that return principal stresses, from the trial strains e [3] along
   axes n, the modulus a [3][3] of the principal stresses by them, and `keep`, by which the deviator is scaled. With
   l^ = n^T l n and eigenvalues b of be of the trial
     dtau^_kk = sum_j a_kj l^_jj,  dtau^_kj = theta_kj (b_j l^_kj + b_k l^_jk) for k != j,
     theta_kj = (tau_k - tau_j)/(b_k - b_j) = 2 mu keep atanh(x)/x/(b_k + b_j),  x = (b_k - b_j)/(b_k + b_j).
   atanh(x) = e_k - e_j; where they are close, its series needs no quotient, so equal ones are no special case. */
MPM_INLINE void MPMHenckyTangent(int dim, const MPMMaterial *m, const PetscReal e[3], PetscReal n[3][3],
                                 PetscReal a[3][3], PetscReal keep, int columns, PetscReal C[6][MPM_TANGENT_NC])
{
  PetscReal b[3], theta[3][3], l[3][3];

  for (int k = 0; k < 3; k++) b[k] = MPMExp(2 * e[k]);
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 3; j++) {
      const PetscReal x = (b[k] - b[j]) / (b[k] + b[j]), z = x * x;
      const PetscReal ratio = PetscAbsReal(x) < 0.05 ? 1 + z * (1. / 3 + z * (1. / 5 + z * (1. / 7 + z / 9)))
                                                     : (e[k] - e[j]) / x;

      theta[k][j] = 2 * m->mu * keep * ratio / (b[k] + b[j]);
    }
  for (int column = 0; column < columns; column++) {
    PetscReal turned[3][3], t[3][3];

    (void)MPMTangentUnit(dim, column, l);
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < 3; j++) {
        turned[k][j] = 0;
        for (int c = 0; c < 3; c++)
          for (int d = 0; d < 3; d++) turned[k][j] += n[k][c] * l[c][d] * n[j][d];
      }
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < 3; j++)
        t[k][j] = k == j ? a[k][0] * turned[0][0] + a[k][1] * turned[1][1] + a[k][2] * turned[2][2]
                         : theta[k][j] * (b[j] * turned[k][j] + b[k] * turned[j][k]);
    for (int c = 0; c < 3; c++)
      for (int d = c; d < 3; d++) {
        PetscReal sum = 0;

        for (int k = 0; k < 3; k++)
          for (int j = 0; j < 3; j++) sum += n[k][c] * t[k][j] * n[j][d];
        C[MPMSymIndex(c, d)][column] = sum;
      }
  }
}
#endif

/* Returns the stored energy lambda/2 tr(e)^2 + mu e:e in J/m^3, which unloading gives back. Work that flow has
   dissipated, or that the hardening of a metal may have stored, is not part of it. */
MPM_INLINE MPMReal MPMHenckyEnergy(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  MPMReal b[3], n[3][3], e[3], tr;

  MPMHenckyStrain(dim, s->be, b, n, e);
  tr = e[0] + e[1] + e[2];
  return 0.5 * m->lambda * tr * tr + m->mu * (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
}

/* Returns the bound of elastic waves, since flow only makes waves slower. Along principal axis 1 of be, rho0 c^2 is
   lambda + 2 mu - tau_1, and for shear mu x/(1 - exp(-x)) <= mu + max(0, mu x) with mu x = tau_1 - tau_2. Both are
   below lambda + 2 mu plus the largest row sum of |tau| (Gershgorin), unless elastic shear strains come near 1/2, far
   beyond the range of these laws. */
MPM_INLINE MPMReal MPMHenckySpeed2(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  MPMReal most = MPMAll(0);

  (void)dim;
  for (int d = 0; d < 3; d++) {
    MPMReal row = MPMAll(0);
    for (int e = 0; e < 3; e++) row += MPMAbs(s->tau[MPMSymIndex(d, e)]);
    most = MPMMax(most, row);
  }
  return (m->lambda + 2 * m->mu + most) / m->rho;
}

#endif
