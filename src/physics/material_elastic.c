/* material_elastic.c - linear elasticity, sig = lambda tr(e) I + 2 mu e with e = sym(F) - I, tau = J sig. It is right
   for small strains and rotations, where it is the law of textbooks; it is not objective. docs/materials.md, (12a). */
#include "physics/law.h"

/* Computes the strain e = sym(F) - I. */
MPM_INLINE void elastic_strain(int dim, const MPMParticleState *s, MPMReal e[6])
{
  for (int k = 0; k < 6; k++) e[k] = MPMAll(0);
  for (int d = 0; d < dim; d++)
    for (int f = d; f < dim; f++)
      e[MPMSymIndex(d, f)] = 0.5 * (s->F[d * dim + f] + s->F[f * dim + d]) - (d == f ? 1.0 : 0.0);
  if (s->round) e[5] = s->F33 - 1.0;
}

MPM_INLINE void elastic_stress(int dim, const MPMMaterial *m, const MPMParticleState *s, MPMReal *tau)
{
  MPMReal       e[6];
  const MPMReal J = MPMParticleJ(dim, s);

  elastic_strain(dim, s, e);
  {
    const MPMReal p = m->lambda * (e[0] + e[3] + e[5]);

    for (int k = 0; k < 6; k++) tau[k] = J * (2 * m->mu * e[k] + (k == 0 || k == 3 || k == 5 ? p : MPMAll(0)));
  }
}

MPM_INLINE MPMReal elastic_energy(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  MPMReal e[6], tr;

  elastic_strain(dim, s, e);
  tr = e[0] + e[3] + e[5];
  return 0.5 * m->lambda * tr * tr +
         m->mu * (e[0] * e[0] + e[3] * e[3] + e[5] * e[5] + 2.0 * (e[1] * e[1] + e[2] * e[2] + e[4] * e[4]));
}

/* sig is linear in F, so waves become faster with the stretch: rho0 c^2 = J s (lambda + 2 mu) for F = s I and for a
   uniaxial stretch s. s = |F|_2 is bounded by the larger of the largest row and column sums, since |F|_2^2 <= |F|_1
   |F|_inf. */
MPM_INLINE MPMReal elastic_speed2(int dim, const MPMMaterial *m, const MPMParticleState *s)
{
  MPMReal smax = MPMAll(0);

  for (int d = 0; d < dim; d++) {
    MPMReal row = MPMAll(0), column = MPMAll(0);
    for (int e = 0; e < dim; e++) {
      row += MPMAbs(s->F[d * dim + e]);
      column += MPMAbs(s->F[e * dim + d]);
    }
    smax = MPMMax(smax, MPMMax(row, column));
  }
  if (s->round) smax = MPMMax(smax, s->F33);
  return MPMParticleJ(dim, s) * smax * (m->lambda + 2 * m->mu) / m->rho;
}

#if MPM_WIDTH == 1
/* dtau = tr(l) tau + J (lambda tr(e') I + 2 mu e') with e' = sym(l F) */
MPM_INLINE void elastic_tangent(int dim, const MPMMaterial *m, PetscReal dt, const PetscReal *L, MPMParticleState *s,
                                PetscReal C[6][MPM_TANGENT_NC])
{
  const PetscReal J       = MPMParticleJ(dim, s);
  PetscReal       F[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, s->F33}}, l[3][3], tau[6];

  (void)dt, (void)L;
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) F[d][e] = s->F[d * dim + e];
  elastic_stress(dim, m, s, tau);
  for (int k = 0; k < MPMTangentColumns(dim, s); k++) {
    const PetscReal tr = MPMTangentUnit(dim, k, l);
    PetscReal       lF[6], p = 0;

    for (int d = 0; d < 3; d++)
      for (int e = d; e < 3; e++) {
        lF[MPMSymIndex(d, e)] = 0;
        for (int j = 0; j < 3; j++) lF[MPMSymIndex(d, e)] += l[d][j] * F[j][e] + l[e][j] * F[j][d]; /* 2 e' */
        p += d == e ? 0.5 * m->lambda * lF[MPMSymIndex(d, e)] : 0;
      }
    for (int i = 0; i < 6; i++) C[i][k] = tr * tau[i] + J * (m->mu * lF[i] + (MPMSymUnit(3, i) ? p : 0));
  }
}
#endif

MPM_LAW_TANGENTS(elastic)
MPM_MATERIAL_DEFINE(elastic, .tangent = MPM_LAW_ALL(elastic, tangent))
