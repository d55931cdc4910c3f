/* material_johnsoncook.c - metal under impact: Hencky elasticity of the deviator, the yield stress of Johnson and Cook
   (Proc. 7th Int. Symp. Ballistics (1983) 541), and the pressure of Mie and Grueneisen about the shock Hugoniot
   us = c0 + s up. See docs/materials.md (12f), also for what it leaves out.
     Y = (A + B ep^n) (1 + C ln max(1, rate/rate0)) (1 - T*^m),  T* = (T - T0)/(Tm - T0) within 0 .. 1
     p = pH(eta) (1 - g eta/2) + g E(eta, theta),  pH = K eta/(1 - s eta)^2,  eta = 1 - J,  K = rho c0^2
     T = (T0 + theta) exp(g eta)
   Its heat is in one number: theta in K is by how much it would be warmer than at the start, if it were let back to its
   reference volume without exchange of heat. Flow adds to theta; changes of volume alone leave it as it is. So energy
   and pressure are functions of J and theta, however the particle came there. */
#include "physics/material_hencky.h"

#define MOST_SHOCK 0.9 /* of the limit 1/s of eta, where the pressure of the Hugoniot is infinite */
#define MOST_TRIES 60  /* to solve for the flow of a step; half of these bisect its whole range */

#if MPM_WIDTH == 1
/* Sets the elastic constants from c0 and G; returns what is wrong or NULL. */
static const char *johnsoncook_setup(MPMMaterial *m)
{
  const PetscReal K = m->rho * m->c0 * m->c0;

  m->mu     = m->shear;
  m->lambda = K - 2 * m->mu / 3;
  m->E      = 9 * K * m->mu / (3 * K + m->mu);
  m->nu     = (3 * K - 2 * m->mu) / (2 * (3 * K + m->mu));
  if (!((K + m->mu) / m->rho < PETSC_MAX_REAL)) return "c0 and G are so large that the wave speed is not finite";
  if (m->melting >= 0 && !(m->melting > m->temperature))
    return "melting must be above the temperature at the start (-material_<m>_temperature)";
  return NULL;
}
#endif

/* The state of volume and heat. */
typedef struct {
  MPMReal eta, grows; /* 1 - J; exp(g eta) */
  MPMReal p, slope;   /* pressure, without regard to the largest tension, and dp/deta at constant theta in Pa */
  MPMReal E;          /* internal energy without that of the deviator in J/m^3 */
} MPMShock;

/* Returns the volume ratio, sqrt(det be), since flow changes no volume: particles with F and those with J get the same
   bits. */
MPM_INLINE MPMReal johnsoncook_J(const MPMReal be[6])
{
  return MPMSqrt(be[0] * (be[3] * be[5] - be[4] * be[4]) - be[1] * (be[1] * be[5] - be[4] * be[2]) +
                 be[2] * (be[1] * be[4] - be[3] * be[2]));
}

/* Computes pressure and energy. On the isentrope theta = 0 dE = p deta, which is linear in E: its solution is the
   integral of exp(g (eta - y)) r(y) from 0 to eta, r = pH(y) (1 - g y/2). Six points of Gauss are right to 1e-8 up to
   eta = 0.4; those of a pair are (1 -+ node)/2 of the way. */
MPM_INLINE void johnsoncook_shock(const MPMMaterial *m, MPMReal J, MPMReal theta, MPMShock *h)
{
  static const PetscReal node[3]   = {0.2386191860831969086, 0.6612093864662645137, 0.9324695142031520278};
  static const PetscReal weight[3] = {0.4679139345726910473, 0.3607615730481386076, 0.1713244923791703450};
  const PetscReal        K = m->rho * m->c0 * m->c0, g = m->gruneisen, s = m->slope;
  const MPMReal          eta = 1 - J, y = s > 0 ? MPMMin(eta, MPMAll(MOST_SHOCK / s)) : eta;
  const MPMReal          half = MPMExp(0.5 * g * y), left = 1 / (1 - s * y);
  MPMReal                sum = MPMAll(0), hot;

  for (int k = 0; k < 3; k++) {
    const MPMReal e = MPMExp(0.5 * node[k] * g * y), a = 0.5 * (1 - node[k]) * y, b = 0.5 * (1 + node[k]) * y;
    const MPMReal u = 1 / (1 - s * a), v = 1 / (1 - s * b);

    sum += 0.5 * weight[k] * (e * (a * (1 - 0.5 * g * a) * u * u) + (b * (1 - 0.5 * g * b) * v * v) / e);
  }
  h->eta   = eta;
  h->grows = MPMExp(g * eta);
  hot      = m->rho * m->heat * theta * h->grows;
  h->E     = K * y * half * sum;
  h->p     = K * y * (1 - 0.5 * g * y) * left * left + g * h->E;
  h->slope = K * (1 + (s - g) * y) * left * left * left + g * h->p + g * g * hot;
  h->p += g * hot;
  h->E += hot;
}

/* Returns p, but never less than -tension. */
MPM_INLINE MPMReal johnsoncook_pressure(const MPMMaterial *m, const MPMShock *h)
{
  return m->tension >= 0 ? MPMMax(h->p, MPMAll(-m->tension)) : h->p;
}

/* Returns x^power for x >= 0, power > 0. */
MPM_INLINE MPMReal johnsoncook_power(MPMReal x, PetscReal power)
{
  return MPMExp(power * MPMLog(MPMMax(x, MPMAll(1e-300))));
}

/* Returns the factor of the yield stress by heat. */
MPM_INLINE MPMReal johnsoncook_soft(const MPMMaterial *m, MPMReal T)
{
  const MPMReal hot = (T - m->temperature) / (m->melting - m->temperature);

  if (m->melting < 0) return MPMAll(1);
  return 1 - johnsoncook_power(MPMMin(MPMMax(hot, MPMAll(0)), MPMAll(1)), m->softening);
}

/* Returns the plastic strain x of a step dt in s that starts at ep, where q in Pa is the trial stress and `soft` the
   factor of heat: the root of q - 3 mu x = Y(ep + x, x/dt). It is between 0 and the flow with the yield stress of no
   flow; Newton's steps that leave what is known of this range are replaced by the geometric mean of its ends, since x
   may be smaller by many powers of ten. Lanes that are done stay as they are. */
MPM_INLINE MPMReal johnsoncook_flow(const MPMMaterial *m, PetscReal dt, MPMMask flows, MPMReal q, MPMReal ep,
                                    MPMReal soft)
{
  const PetscReal unit = dt > 0 ? dt * m->rate0 : 1, C = dt > 0 ? m->rate : 0, G3 = 3 * m->mu;
  const MPMReal   least = soft * (m->yield + m->hardening * johnsoncook_power(ep, m->power));
  MPMReal         hi = MPMSelect(flows, (q - least) / G3, MPMAll(1)), lo = hi * 1e-18, x = hi;
  MPMMask         done = MPMNot(flows);

  for (int k = 0; k < MOST_TRIES && MPMAny(MPMNot(done)); k++) {
    const MPMReal hard = m->hardening * johnsoncook_power(ep + x, m->power), fast = x / unit;
    const MPMReal rate  = 1 + C * MPMLog(MPMMax(fast, MPMAll(1)));
    const MPMReal g     = q - G3 * x - soft * (m->yield + hard) * rate;
    const MPMReal slope = G3 + soft * (m->power * hard / (ep + x) * rate +
                                       MPMSelect(fast > 1, (m->yield + hard) * C / x, MPMAll(0)));
    MPMReal       next  = x + g / slope;

    lo   = MPMSelect(g > 0, x, lo);
    hi   = MPMSelect(g > 0, hi, x);
    next = MPMSelect((next > lo) & (next < hi), next, MPMSqrt(lo * hi));
    done = done | (MPMAbs(g) <= 1e-15 * q);
    x    = MPMSelect(done, x, next);
    done = done | (hi - lo <= 1e-15 * hi);
  }
  return x;
}

MPM_INLINE void johnsoncook_update(int dim, const MPMMaterial *m, PetscReal dt, const MPMReal *L, MPMParticleState *s)
{
  MPMReal       n[3][3], e[3], mean, J, soft, tau[6];
  const MPMReal q = MPMHenckyTrialMises(dim, m, dt, L, s, n, e, &mean);
  MPMShock      h;
  MPMMask       flows;

  J = johnsoncook_J(s->be);
  johnsoncook_shock(m, J, s->theta, &h);
  soft  = johnsoncook_soft(m, (m->temperature + s->theta) * h.grows);
  flows = q > soft * (m->yield + m->hardening * johnsoncook_power(s->ep, m->power));
  if (MPMAny(flows)) {
    const MPMReal x    = johnsoncook_flow(m, dt, flows, q, s->ep, soft);
    const MPMReal keep = 1 - 3 * m->mu * x / MPMSelect(flows, q, MPMAll(1));
    const MPMReal warm = m->share * (q - 3 * m->mu * x) * x / (m->rho * m->heat); /* K */

    for (int k = 0; k < 3; k++) e[k] = MPMSelect(flows, mean + keep * (e[k] - mean), e[k]);
    s->ep    = MPMSelect(flows, s->ep + x, s->ep);
    s->theta = MPMSelect(flows, s->theta + warm / h.grows, s->theta);
    h.p += MPMSelect(flows, m->gruneisen * m->rho * m->heat * warm, MPMAll(0));
    MPMHenckySetStrain(dim, flows, e, n, s->be);
  }
  for (int k = 0; k < 3; k++) e[k] = 2 * m->mu * (e[k] - mean) - J * johnsoncook_pressure(m, &h);
  MPMSpectral(dim, e, n, tau);
  for (int k = 0; k < 6; k++) s->tau[k] = tau[k];
}

/* Returns the internal energy with that of the deviator; heat is a part of it. Beyond the volume at which the tension
   has its largest value, p is constant: that volume is between J = 1 and this one. */
MPM_INLINE MPMReal johnsoncook_energy(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  MPMReal  b[3], n[3][3], e[3], mean, W = MPMAll(0), J = johnsoncook_J(s->be), more = MPMAll(0);
  MPMShock h;

  MPMHenckyStrain(dim, s->be, b, n, e);
  mean = (e[0] + e[1] + e[2]) / 3;
  for (int k = 0; k < 3; k++) W += m->mu * (e[k] - mean) * (e[k] - mean);
  johnsoncook_shock(m, J, s->theta, &h);
#if MPM_WIDTH == 1
  if (m->tension >= 0 && h.p < -m->tension) {
    PetscReal lo = 1, hi = J;

    for (int k = 0; k < MOST_TRIES; k++) {
      johnsoncook_shock(m, 0.5 * (lo + hi), s->theta, &h);
      if (h.p < -m->tension)
        hi = 0.5 * (lo + hi);
      else
        lo = 0.5 * (lo + hi);
    }
    more = m->tension * (J - lo);
  }
#endif
  return W + h.E + more;
}

/* Along a principal axis rho0 c^2 = J^2 dp/deta + 4/3 mu - s_1 with the deviator s of tau, for shear it is below
   mu + s_1 - s_2 (material_hencky.h). In tension the pressure has a smaller slope, and a constant one where it has its
   largest tension; the value at rest is taken there, since dt has to be right when the metal is compressed again. */
MPM_INLINE MPMReal johnsoncook_speed2(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  const MPMReal J = johnsoncook_J(s->be), third = (s->tau[0] + s->tau[3] + s->tau[5]) / 3;
  MPMReal       most = MPMAll(0);
  MPMShock      h;

  (void)dim;
  johnsoncook_shock(m, J, s->theta, &h);
  for (int d = 0; d < 3; d++) {
    MPMReal row = MPMAll(0);
    for (int e = 0; e < 3; e++) row += MPMAbs(s->tau[MPMSymIndex(d, e)] - (d == e ? third : MPMAll(0)));
    most = MPMMax(most, row);
  }
  return (MPMMax(MPMMax(J * J * h.slope, MPMAll(m->rho * m->c0 * m->c0)) + m->mu / 3, most) + m->mu + most) / m->rho;
}

MPM_MATERIAL_DEFINE_HISTORY(johnsoncook, johnsoncook_setup,
                            MPM_BIT(J) | MPM_BIT(be) | MPM_BIT(ep) | MPM_BIT(theta) | MPM_BIT(tau))
