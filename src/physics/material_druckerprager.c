/* material_druckerprager.c - sand and soil: Hencky elasticity within the Drucker-Prager cone. A stress outside is
   returned to the cone in principal logarithmic strains (Klar et al., ACM Trans. Graph. 35 (2016) 103); opened volume
   is remembered as by Tampubolon et al., ACM Trans. Graph. 36 (2017) 105. See docs/materials.md (12d).
     |dev tau| + alpha (tr tau - T0) <= 0,  T0 = 3 cohesion cot(phi) at the apex,  beta is the slope of the flow
   The cone meets the hexagon of Mohr and Coulomb in triaxial compression, or in the stress of flow in plane strain.
   Sand that is pulled apart has the stress of the apex (none if T0 = 0) while its grains separate. vc [1] sums the
   logarithmic volume that opens, and it has to close before there is pressure again; otherwise each loosening would add
   volume. */
#include "physics/material_hencky.h"

#if MPM_WIDTH == 1
/* Returns the slope of the cone through the outer edges of the Mohr-Coulomb hexagon, for phi in degrees. sin is libm's:
   the slope is a constant of the scene, so it is the same on all processes of a run. */
static PetscReal druckerprager_slope(PetscReal phi)
{
  const PetscReal s = PetscSinReal(phi * PETSC_PI / 180);

  return PetscSqrtReal(2. / 3) * 2 * s / (3 - s);
}

/* Returns the slope of the flow that has the dilation angle psi, in degrees, in plane strain. */
static PetscReal druckerprager_plane_flow(PetscReal psi)
{
  const PetscReal s = PetscSinReal(psi * PETSC_PI / 180);

  return PetscSqrtReal(2) * s / PetscSqrtReal(9 + 3 * s * s);
}

/* Returns the slope of the cone that has the friction angle phi, in degrees, in plane strain with this flow. */
static PetscReal druckerprager_plane_slope(PetscReal phi, PetscReal flow)
{
  const PetscReal s = PetscSinReal(phi * PETSC_PI / 180);

  return 2 * s / (3 * (flow * s + PetscSqrtReal(2 - 3 * flow * flow)));
}

/* Returns the angle in degrees whose sine is s; 90 if there is none. */
static PetscReal druckerprager_angle(PetscReal s)
{
  return s < 1 ? PetscAsinReal(s) * 180 / PETSC_PI : 90;
}

/* Converts the angles to slopes, and the cohesion to the trace of tau at the apex in Pa; returns what is wrong or
   NULL. */
static const char *druckerprager_setup(MPMMaterial *m)
{
  extern const MPMMaterialLaw MPMMaterialLaw_druckerprager_strain; /* below: it sums ep too */
  const PetscReal             phi = m->friction;
  PetscReal                   a, b;

  if (m->dilation > phi) return "dilation_angle must be at most the friction angle: more would create energy";
  if (m->cohesion > 0 && !(phi > 0)) return "cohesion needs a friction_angle above 0: without friction use vonmises";
  if (m->cohesion > 0) m->cohesion *= 3 / PetscTanReal(phi * PETSC_PI / 180);
  m->dilation = b = m->plane ? druckerprager_plane_flow(m->dilation) : druckerprager_slope(m->dilation);
  m->friction = a = m->plane ? druckerprager_plane_slope(phi, b) : druckerprager_slope(phi);
  m->acts[0]      = druckerprager_angle(3 * a / (PetscSqrtReal(8. / 3) + a));
  m->acts[1]      = druckerprager_angle(3 * a * PetscSqrtReal(2 - 3 * b * b) / (2 - 3 * a * b));
  m->skew         = a > b * (1 + 1e-12); /* equal ones may differ by rounding */
  m->asked        = &MPMMaterialLaw_druckerprager_strain;
  return NULL;
}
#endif

/* Returns the trial state to the apex (`beyond`) or to the side of the cone (`flows`), or keeps it. strain: ep sums the
   equivalent plastic strain. */
MPM_INLINE void druckerprager_flow(int dim, PetscBool strain, const MPMMaterial *m, PetscReal dt, const MPMReal *L,
                                   MPMParticleState *s)
{
  const PetscReal K3 = 3 * m->lambda + 2 * m->mu, apex = m->cohesion / K3; /* tr tau = K3 tr e; tr e at the apex */
  const MPMReal   open = MPMMax(MPMAll(0), s->vc);
  MPMReal         b[3], n[3][3], e[3], tr, norm = MPMAll(0), f;
  MPMMask         beyond, flows, new;

  MPMHenckyTrial(dim, m, dt, L, s);
  MPMHenckyStrain(dim, s->be, b, n, e);
  for (int k = 0; k < 3; k++) e[k] += open / 3;
  tr = e[0] + e[1] + e[2];
  for (int k = 0; k < 3; k++) norm += (e[k] - tr / 3) * (e[k] - tr / 3);
  norm   = 2 * m->mu * MPMSqrt(norm); /* |dev tau| */
  f      = norm + m->friction * (K3 * tr - m->cohesion);
  beyond = 2 * m->mu * (K3 * tr - m->cohesion) >= 3 * K3 * m->dilation * norm; /* the flow would lead to the apex */
  flows  = MPMNot(beyond) & (f > 0);
  new    = beyond | flows | (open > 0);
  if (MPMAny(new)) {
    const MPMReal gamma  = f / (2 * m->mu + 3 * K3 * m->friction * m->dilation);
    const MPMReal length = MPMSelect(norm > 0, norm, MPMAll(1)); /* |dev tau| > 0 where it flows */

    for (int k = 0; k < 3; k++) {
      const MPMReal back = e[k] - gamma * ((e[k] - tr / 3) * (2 * m->mu / length) + m->dilation);

      e[k] = MPMSelect(beyond, MPMAll(apex / 3), MPMSelect(flows, back, e[k]));
    }
    MPMHenckySetStrain(dim, new, e, n, s->be);
    if (strain) /* |dev e| is norm/(2 mu), and the flow takes away gamma of it or, at the apex, all */
      s->ep += PetscSqrtReal(2. / 3) * MPMSelect(beyond, norm / (2 * m->mu), MPMSelect(flows, gamma, MPMAll(0)));
  }
  s->vc = MPMSelect(beyond, tr - apex, MPMAll(0));
  MPMHenckyStress(dim, m, e, n, s->tau);
}

MPM_INLINE void druckerprager_update(int dim, const MPMMaterial *m, PetscReal dt, const MPMReal *L, MPMParticleState *s)
{
  druckerprager_flow(dim, PETSC_FALSE, m, dt, L, s);
}

MPM_INLINE MPMReal druckerprager_energy(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  return MPMHenckyEnergy(dim, m, s);
}

MPM_INLINE MPMReal druckerprager_speed2(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  return MPMHenckySpeed2(dim, m, s);
}

#if MPM_WIDTH == 1
/* On the side of the cone, with D = I - 1(x)1/3 and the direction n of the trial deviator,
     a = K 1(x)1 + 2 mu keep (D - n(x)n) + 2 mu n(x)n
         - (2 mu n + K3 beta 1)(x)(2 mu n + K3 alpha 1)/(2 mu + 3 K3 alpha beta),  keep = 1 - 2 mu gamma/|dev tau|;
   beyond the apex a = 0. The trial is that of druckerprager_flow; opened volume is added to its strains, so it changes no
   modulus. */
MPM_INLINE void druckerprager_tangent(int dim, const MPMMaterial *m, PetscReal dt, const PetscReal *L,
                                      MPMParticleState *s, PetscReal C[6][MPM_TANGENT_NC])
{
  const PetscReal K3 = 3 * m->lambda + 2 * m->mu, two = 2 * m->mu, hard = two + 3 * K3 * m->friction * m->dilation;
  const PetscReal open = MPMMax(0, s->vc);
  PetscReal       axes[3][3], b[3], e[3], n[3] = {0}, a[3][3], tr, norm = 0, f, keep = 1;
  PetscBool       beyond, flows;

  MPMHenckyTrial(dim, m, dt, L, s);
  MPMHenckyStrain(dim, s->be, b, axes, e);
  tr = e[0] + e[1] + e[2];
  for (int k = 0; k < 3; k++) norm += (e[k] - tr / 3) * (e[k] - tr / 3);
  norm   = two * PetscSqrtReal(norm); /* |dev tau| */
  f      = norm + m->friction * (K3 * (tr + open) - m->cohesion);
  beyond = two * (K3 * (tr + open) - m->cohesion) >= 3 * K3 * m->dilation * norm;
  if (norm == 0 && K3 * (tr + open) == m->cohesion) beyond = PETSC_FALSE; /* on the apex: as under pressure */
  flows = !beyond && f > 0;
  if (beyond) keep = 0;
  if (flows) keep = 1 - two * f / hard / norm;
  for (int k = 0; k < 3 && flows; k++) n[k] = two * (e[k] - tr / 3) / norm;
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 3; j++) {
      a[k][j] = beyond ? 0 : K3 / 3 + two * keep * ((k == j) - 1. / 3 - n[k] * n[j]) + two * n[k] * n[j];
      if (flows) a[k][j] -= (two * n[k] + K3 * m->dilation) * (two * n[j] + K3 * m->friction) / hard;
    }
  MPMHenckyTangent(dim, m, e, axes, a, keep, MPMTangentColumns(dim, s), C);
}
#endif

MPM_LAW_TANGENTS(druckerprager)
MPM_MATERIAL_DEFINE_HISTORY(druckerprager, druckerprager_setup, MPM_BIT(J) | MPM_BIT(be) | MPM_BIT(vc) | MPM_BIT(tau),
                            .tangent = MPM_LAW_ALL(druckerprager, tangent))

/* The same law where output asks for ep (MPMMaterialKeep). */
MPM_INLINE void druckerprager_strain_update(int dim, const MPMMaterial *m, PetscReal dt, const MPMReal *L,
                                            MPMParticleState *s)
{
  druckerprager_flow(dim, PETSC_TRUE, m, dt, L, s);
}

#define druckerprager_strain_energy druckerprager_energy
#define druckerprager_strain_speed2 druckerprager_speed2
MPM_MATERIAL_DEFINE_HISTORY(druckerprager_strain, druckerprager_setup,
                            MPM_BIT(J) | MPM_BIT(be) | MPM_BIT(ep) | MPM_BIT(vc) | MPM_BIT(tau),
                            .tangent = MPM_LAW_ALL(druckerprager, tangent))
