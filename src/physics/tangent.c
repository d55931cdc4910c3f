/* placeholder */
#include "physics/tangent.h"
void MPMTangentTotal(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p, const PetscReal F[], PetscReal A[])
{
  const PetscInt n = dim * dim;
  MPMBlock b, one;
  MPMComponent L[9];
  PetscReal was[9], P[2 * 9][9];
  const PetscReal eps = 1e-6;

  MPMMaterialState(dim, view, p, &one);
  for (PetscInt k = 0; k < n; k++) was[k] = view->F[p * n + k];
  b = one;
  for (PetscInt l = 0; l < 2 * n; l++) {
#define COPY(name, rows) for (int r = 0; r < rows; r++) b.name[r][l] = one.name[r][0];
    MPM_MATERIAL_FIELDS(COPY)
    PetscReal G[9], c[9], J = MPMDet((int)dim, was);
    for (PetscInt k = 0; k < n; k++) G[k] = F[k] + (k == l / 2 ? (l % 2 ? -eps : eps) : 0);
    MPMCofactor((int)dim, was, c);
    for (PetscInt k = 0; k < n; k++) b.F[k][l] = G[k];
    for (PetscInt d = 0; d < dim; d++)
      for (PetscInt e = 0; e < dim; e++) {
        PetscReal s = 0;
        for (PetscInt k = 0; k < dim; k++) s += G[d * dim + k] * c[e * dim + k] / J;
        L[d * dim + e][l] = s - (d == e);
      }
  }
  if (m->type->law->update[0])
    m->type->law->update[MPMLawForm(m, dim)](m, 1, L, 0, 2 * n, &b);
  else
    m->type->law->stress[MPMLawForm(m, dim)](m, 0, 2 * n, &b);
  for (PetscInt l = 0; l < 2 * n; l++) {
    PetscReal G[9], c[9], J;
    for (PetscInt k = 0; k < n; k++) G[k] = b.F[k][l];
    J = MPMDet((int)dim, G);
    MPMCofactor((int)dim, G, c);
    for (PetscInt d = 0; d < dim; d++)
      for (PetscInt e = 0; e < dim; e++) {
        PetscReal s = 0;
        for (PetscInt k = 0; k < dim; k++) s += b.tau[MPMSymPart((int)dim, (int)d, (int)k)][l] * c[k * dim + e] / J;
        P[l][d * dim + e] = s;
      }
  }
  for (PetscInt k = 0; k < n; k++)
    for (PetscInt l = 0; l < n; l++) A[k * n + l] = (P[2 * l][k] - P[2 * l + 1][k]) / (2 * eps);
}
