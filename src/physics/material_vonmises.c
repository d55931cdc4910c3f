/* material_vonmises.c - elastic-plastic metal: Hencky elasticity, the yield stress of von Mises on the Kirchhoff
   stress, linear isotropic hardening (Simo, Comput. Methods Appl. Mech. Eng. 99 (1992) 61). docs/materials.md, (12c).
     q = sqrt(3/2) |dev tau| <= yield + hardening ep
   A stress beyond is returned to this surface along dev tau, which changes no volume; ep grows by dgamma. */
#include "physics/material_hencky.h"

MPM_INLINE void vonmises_update(int dim, const MPMMaterial *m, PetscReal dt, const MPMReal *L, MPMParticleState *s)
{
  MPMReal       n[3][3], e[3], mean;
  const MPMReal q = MPMHenckyTrialMises(dim, m, dt, L, s, n, e, &mean), f = q - (m->yield + m->hardening * s->ep);
  const MPMMask flows = f > 0; /* then q > 0 */

  if (MPMAny(flows)) {
    const MPMReal dgamma = f / (3 * m->mu + m->hardening);
    const MPMReal keep   = 1 - 3 * m->mu * dgamma / MPMSelect(flows, q, MPMAll(1));

    for (int k = 0; k < 3; k++) e[k] = MPMSelect(flows, mean + keep * (e[k] - mean), e[k]);
    s->ep = MPMSelect(flows, s->ep + dgamma, s->ep);
    MPMHenckySetStrain(dim, flows, e, n, s->be);
  }
  MPMHenckyStress(dim, m, e, n, s->tau);
}

MPM_INLINE MPMReal vonmises_energy(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  return MPMHenckyEnergy(dim, m, s);
}

MPM_INLINE MPMReal vonmises_speed2(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  return MPMHenckySpeed2(dim, m, s);
}

#if MPM_WIDTH == 1
/* a = K 1(x)1 + 2 mu keep D - 6 mu^2 (1/(3 mu + hardening) - dgamma/q) n(x)n where it flows, with D = I - 1(x)1/3 and
   the direction n of the trial deviator (de Souza Neto, Peric and Owen, Computational Methods for Plasticity, 2008,
   section 7.4). */
MPM_INLINE void vonmises_tangent(int dim, const MPMMaterial *m, PetscReal dt, const PetscReal *L, MPMParticleState *s,
                                 PetscReal C[6][MPM_TANGENT_NC])
{
  PetscReal       n[3][3], e[3], a[3][3], mean, keep = 1, less = 0;
  const PetscReal q = MPMHenckyTrialMises(dim, m, dt, L, s, n, e, &mean), f = q - (m->yield + m->hardening * s->ep);

  if (f > 0) {
    const PetscReal dgamma = f / (3 * m->mu + m->hardening), length = q / (2 * m->mu * PetscSqrtReal(1.5));

    keep = 1 - 3 * m->mu * dgamma / q;
    less = 6 * m->mu * m->mu * (1 / (3 * m->mu + m->hardening) - dgamma / q) / (length * length);
  }
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 3; j++)
      a[k][j] = m->lambda + 2 * m->mu / 3 + 2 * m->mu * keep * ((k == j) - 1. / 3) -
                less * (e[k] - mean) * (e[j] - mean);
  MPMHenckyTangent(dim, m, e, n, a, keep, MPMTangentColumns(dim, s), C);
}
#endif

MPM_LAW_TANGENTS(vonmises)
MPM_MATERIAL_DEFINE_HISTORY(vonmises, NULL, MPM_BIT(J) | MPM_BIT(be) | MPM_BIT(ep) | MPM_BIT(tau),
                            .tangent = MPM_LAW_ALL(vonmises, tangent))
