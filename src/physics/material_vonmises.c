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

MPM_MATERIAL_DEFINE_HISTORY(vonmises, NULL, MPM_BIT(J) | MPM_BIT(be) | MPM_BIT(ep) | MPM_BIT(tau))
