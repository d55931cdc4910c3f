/* material_neohookean.c - compressible neo-Hookean solid (Bonet and Wood, Nonlinear Continuum Mechanics, eq. 6.27):
     W = mu/2 (tr b - 3 - 2 ln J) + lambda/2 ln^2 J,  tau = lambda ln J I + mu (b - I),  b = F F^T.
   See docs/materials.md (12b). */
#include "physics/law.h"

MPM_INLINE void neohookean_stress(int dim, const MPMMaterial *m, const MPMParticleState *s, MPMReal *tau)
{
  MPMReal       b[6];
  const MPMReal p = m->lambda * MPMLog(MPMParticleJ(dim, s));

  MPMParticleB(dim, s, b);
  tau[0] = p + m->mu * (b[0] - 1.0);
  tau[1] = m->mu * b[1];
  tau[2] = m->mu * b[2];
  tau[3] = p + m->mu * (b[3] - 1.0);
  tau[4] = m->mu * b[4];
  tau[5] = p + m->mu * (b[5] - 1.0);
}

MPM_INLINE MPMReal neohookean_energy(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  MPMReal       b[6];
  const MPMReal lnJ = MPMLog(MPMParticleJ(dim, s));

  MPMParticleB(dim, s, b);
  return 0.5 * m->mu * ((b[0] - 1.0) + (b[3] - 1.0) + (b[5] - 1.0) - 2.0 * lnJ) + 0.5 * m->lambda * lnJ * lnJ;
}

/* A plane wave along n has rho0 c^2 = lambda (1 - ln J) + mu (1 + n.b n), a shear wave mu n.b n. The bound needs no
   logarithm, by 1 - 1/J <= ln J <= J - 1, and takes the largest row sum of b (Gershgorin); it is exact at F = I. */
MPM_INLINE MPMReal neohookean_speed2(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  const MPMReal J = MPMParticleJ(dim, s), volumetric = m->lambda * (m->lambda >= 0 ? 1.0 / J : 2.0 - J);
  MPMReal       b[6], bmax                           = MPMAll(0);

  MPMParticleB(dim, s, b);
  for (int d = 0; d < dim; d++) {
    MPMReal row = MPMAll(0);
    for (int e = 0; e < dim; e++) row += MPMAbs(b[MPMSymIndex(d, e)]);
    bmax = MPMMax(bmax, row);
  }
  if (s->round) bmax = MPMMax(bmax, b[5]);
  return MPMDivide(m->mu * bmax + MPMMax(MPMAll(0), m->mu + volumetric), m->rho, 1 / m->rho);
}

#if MPM_WIDTH == 1
/* dtau = lambda tr(l) I + mu (l b + b l^T) */
MPM_INLINE void neohookean_tangent(int dim, const MPMMaterial *m, PetscReal dt, const PetscReal *L, MPMParticleState *s,
                                   PetscReal C[6][MPM_TANGENT_NC])
{
  PetscReal b[6], l[3][3];

  (void)dt, (void)L;
  MPMParticleB(dim, s, b);
  for (int k = 0; k < MPMTangentColumns(dim, s); k++) {
    const PetscReal tr = MPMTangentUnit(dim, k, l);

    for (int d = 0; d < 3; d++)
      for (int e = d; e < 3; e++) {
        PetscReal lb = 0;

        for (int j = 0; j < 3; j++) lb += l[d][j] * b[MPMSymIndex(j, e)] + l[e][j] * b[MPMSymIndex(j, d)];
        C[MPMSymIndex(d, e)][k] = (d == e ? m->lambda * tr : 0) + m->mu * lb;
      }
  }
}
#endif

MPM_LAW_TANGENTS(neohookean)
MPM_MATERIAL_DEFINE(neohookean, .tangent = MPM_LAW_ALL(neohookean, tangent))
