/* material_fluid.c - compressible Newtonian fluid: sig = -p I + 2 viscosity dev(D), D = sym(L), tau = J sig, with
     p = K/gamma (J^-gamma - 1)   Tait's equation in Cole's form (Cole, Underwater Explosions, 1948, p. 44), or
     p = -K (J - 1)               linear, where gamma is 0; and never p < -tension, where tension >= 0.
   Its particles carry the volume ratio, J <- J (1 + dt tr L), and no F. See docs/materials.md (12e). No step turns a
   particle inside out: where dt tr L is below -0.2, which is so of particles alone, another function of it takes the
   place of 1 + dt tr L, with the same value and slope at -0.2, and positive everywhere; a step opens it by 1.5 at most.
   The viscous stress depends on the last velocity gradient, so tau is stored until forces are summed; without viscosity
   tau is a function of J. The wave speed bounds dt, and MPMTimeStep adds the bound that viscosity needs. */
#include "physics/law.h"

#if MPM_WIDTH == 1
/* Removes tau from the state of a fluid without viscosity. */
static const char *fluid_setup(MPMMaterial *m)
{
  m->skew = m->viscosity > 0;
  if (!m->skew) m->state &= ~MPM_BIT(tau);
  return NULL;
}
#endif

/* Returns the pressure in Pa. */
MPM_INLINE MPMReal fluid_pressure(const MPMMaterial *m, MPMReal J)
{
  const MPMReal p = m->gamma > 0 ? m->K / m->gamma * (MPMExp(-m->gamma * MPMLog(J)) - 1.0) : -m->K * (J - 1.0);

  return m->tension >= 0 ? MPMMax(p, MPMAll(-m->tension)) : p;
}

/* Computes tau = -J p I: the stress of an inviscid fluid, and a part of that of a viscous one. */
MPM_INLINE void fluid_stress(int dim, const MPMMaterial *m, const MPMParticleState *s, MPMReal *tau)
{
  const MPMReal p = fluid_pressure(m, s->J);

  (void)dim;
  for (int k = 0; k < 6; k++) tau[k] = MPMSymUnit(3, k) ? -s->J * p : MPMAll(0);
}

/* Updates J and, of a viscous fluid, tau. */
MPM_INLINE void fluid_update(int dim, const MPMMaterial *m, PetscReal dt, const MPMReal *L, MPMParticleState *s)
{
  const PetscReal least = -0.2;
  MPMReal         tr    = L[0], growth;

  for (int d = 1; d < dim; d++) tr += L[d * (dim + 1)];
  if (s->round) tr += s->L33;
  growth = 1.0 + MPMMin(dt * tr, MPMAll(0.5));
  if (MPMAny(dt * tr < least))
    growth = MPMSelect(dt * tr < least, (1 + least) * (1 + least) / (1 + 2 * least - MPMMin(dt * tr, MPMAll(least))),
                       growth);
  s->J *= growth;
  if (!(m->state & MPM_BIT(tau))) return;
  fluid_stress(dim, m, s, s->tau);
  for (int d = 0; d < dim; d++)
    for (int e = d; e < dim; e++) s->tau[MPMSymIndex(d, e)] += s->J * m->viscosity * (L[d * dim + e] + L[e * dim + d]);
  if (s->round) s->tau[5] += s->J * m->viscosity * (s->L33 + s->L33);
  for (int k = 0; k < 6; k++)
    if (MPMSymUnit(3, k)) s->tau[k] -= s->J * 2.0 * m->viscosity / 3.0 * tr;
}

#if MPM_WIDTH == 1
/* A finite displacement: f^-1, det f, and the rate in the deformed state, d = (I - f^-1)/dt in 1/s, with its trace. */
typedef struct {
  PetscReal inverse[3][3], J, d[3][3], tr;
} MPMFluidMotion;

MPM_INLINE void fluid_motion(int dim, PetscReal dt, const PetscReal *L, const MPMParticleState *s, MPMFluidMotion *f)
{
  const PetscReal f33 = 1 + dt * s->L33;
  PetscReal       F[9], c[9], J;

  memset(f, 0, sizeof *f);
  for (int k = 0; k < dim * dim; k++) F[k] = (k % (dim + 1) == 0) + dt * L[k];
  J    = MPMDet(dim, F);
  f->J = J * f33;
  MPMCofactor(dim, F, c);
  for (int a = 0; a < 3; a++)
    for (int e = 0; e < 3; e++) {
      f->inverse[a][e] = a < dim && e < dim ? c[e * dim + a] / J : a == e ? (a == 2 ? 1 / f33 : 1) : 0;
      f->d[a][e]       = ((a == e) - f->inverse[a][e]) / dt;
      f->tr += a == e ? f->d[a][e] : 0;
    }
}

/* Computes J and tau after a finite displacement: J is multiplied by det f, and the rate is that in the deformed state;
   1 + dt tr L and L = H/dt are the same for small displacements alone. */
MPM_INLINE void fluid_trial_update(int dim, const MPMMaterial *m, PetscReal dt, const PetscReal *L, MPMParticleState *s)
{
  MPMFluidMotion f;

  fluid_motion(dim, dt, L, s, &f);
  s->J *= f.J;
  if (!(m->state & MPM_BIT(tau))) return;
  fluid_stress(dim, m, s, s->tau);
  for (int a = 0; a < 3; a++)
    for (int e = a; e < 3; e++)
      s->tau[MPMSymIndex(a, e)] += s->J * m->viscosity * (f.d[a][e] + f.d[e][a] - (a == e ? 2. / 3 * f.tr : 0));
}

/* dtau = -J (p + J dp/dJ) tr(l) I, and of a viscous fluid 2 viscosity J (tr(l) dev sym d + dev sym(f^-1 l)/dt). */
MPM_INLINE void fluid_tangent(int dim, const MPMMaterial *m, PetscReal dt, const PetscReal *L, MPMParticleState *s,
                              PetscReal C[6][MPM_TANGENT_NC])
{
  PetscReal      p, slope, l[3][3];
  MPMFluidMotion f;

  fluid_motion(dim, dt, L, s, &f);
  s->J *= f.J;
  p     = fluid_pressure(m, s->J);
  slope = m->gamma > 0 ? -m->K * MPMExp(-m->gamma * MPMLog(s->J)) : -m->K * s->J; /* J dp/dJ */
  if (m->tension >= 0 && p <= -m->tension) slope = 0;
  for (int k = 0; k < MPMTangentColumns(dim, s); k++) {
    const PetscReal tr = MPMTangentUnit(dim, k, l);
    PetscReal       d[3][3], mean = 0;

    for (int a = 0; a < 3; a++)
      for (int e = 0; e < 3; e++) {
        d[a][e] = f.d[a][e] * tr;
        for (int j = 0; j < 3; j++) d[a][e] += f.inverse[a][j] * l[j][e] / dt;
        mean += a == e ? d[a][e] / 3 : 0;
      }
    for (int a = 0; a < 3; a++)
      for (int e = a; e < 3; e++) {
        PetscReal *c = &C[MPMSymIndex(a, e)][k];

        *c = a == e ? -s->J * (p + slope) * tr : 0;
        if (m->viscosity > 0) *c += s->J * m->viscosity * (d[a][e] + d[e][a] - (a == e ? 2 * mean : 0));
      }
  }
}

/* Returns -int p dJ from 1 to J, without regard to the largest tension, in J/m^3. */
MPM_INLINE PetscReal fluid_work(const MPMMaterial *m, PetscReal J)
{
  const PetscReal g = m->gamma;

  if (!(g > 0)) return 0.5 * m->K * (J - 1) * (J - 1);
  if (g == 1) return m->K * ((J - 1) - MPMLog(J));
  return m->K / g * ((MPMExp((1 - g) * MPMLog(J)) - 1) / (g - 1) + (J - 1));
}

/* Returns W with dW/dJ = -p, W(1) = 0. Beyond the volume ratio Jc, where the tension has its largest value, W grows
   linearly. */
MPM_INLINE PetscReal fluid_energy(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  const PetscReal g = m->gamma, left = 1 - g * m->tension / m->K; /* Jc^-g of Tait's law; its tension is below K/g */
  PetscReal       Jc = PETSC_MAX_REAL;

  (void)dim;
  if (m->tension >= 0 && !(g > 0)) Jc = 1 + m->tension / m->K;
  if (m->tension >= 0 && g > 0 && left > 0) Jc = MPMExp(-MPMLog(left) / g);
  return s->J <= Jc ? fluid_work(m, s->J) : fluid_work(m, Jc) + m->tension * (s->J - Jc);
}

#endif

/* c^2 = dp/drho with rho = rho0/J: K/rho0 J^(1 - gamma) or K J^2/rho0. Where the tension is constant there are no
   waves; the value at rest is taken there, since dt has to be right when the fluid is compressed again. */
MPM_INLINE MPMReal fluid_speed2(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  const MPMReal J = m->tension >= 0 ? MPMMin(s->J, MPMAll(1)) : s->J;

  (void)dim;
  return m->K / m->rho * (m->gamma > 0 ? MPMExp((1 - m->gamma) * MPMLog(J)) : s->J * s->J);
}

MPM_LAW_STRESSES(fluid)
MPM_LAW_UPDATES(fluid, m->state)
MPM_LAW_SCALARS(fluid, speed2)
#if MPM_WIDTH == 1
MPM_LAW_UPDATES(fluid_trial, m->state)
MPM_LAW_TANGENTS(fluid)
MPM_LAW_SCALARS(fluid, energy)
extern const MPMMaterialLaw MPMMaterialLaw_fluid_8, MPMMaterialLaw_fluid_4, MPMMaterialLaw_fluid_2;
const MPMMaterialLaw        MPMMaterialLaw_fluid = {.setup   = fluid_setup,
                                                    .stress  = MPM_LAW_ALL(fluid, stress),
                                                    .update  = MPM_LAW_ALL(fluid, update),
                                                    .energy  = MPM_LAW_ALL(fluid, energy),
                                                    .speed2  = MPM_LAW_ALL(fluid, speed2),
                                                    .lanes   = MPM_LAW_LANES(fluid),
                                                    .trial   = MPM_LAW_ALL(fluid_trial, update),
                                                    .tangent = MPM_LAW_ALL(fluid, tangent)};
#else
const MPMMaterialLaw MPM_LANES_NAME(MPMMaterialLaw_fluid) = {
    .stress = MPM_LAW_ALL(fluid, stress), .update = MPM_LAW_ALL(fluid, update), .speed2 = MPM_LAW_ALL(fluid, speed2)};
#endif
