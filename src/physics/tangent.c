/* tangent.c - stresses and tangents of finite displacements (tangent.h), in blocks of particles of one material: the
   state of a block is copied, the copy deformed and given to the law, and T = tau f^-T taken from it. The tangent is
   made of the derivative C of tau by l = dH f^-1 that the law gives,
     dT = (dtau - tau l^T) f^-T,  A_aBcD = (sum_e C_ab,ce f^-1_De) f^-1_Bb - T_aD f^-1_Bc,
   or of differences of T. */
#include <string.h>
#include "physics/tangent.h"

#define STEP                                                                                                           \
  0x1p-20       /* of differences: rounding is 1e-16/STEP of the modulus; their truncation, STEP^2 times a curvature */
#define ROWS 10 /* of H, T */

/* Particles `first` .. first + n - 1 of a view, with one material: their state at t_n, and what changes it. `lanes` is
   n rounded up to whole vectors of any width; the lanes past the last particle repeat it. */
typedef struct {
  const MPMMaterial *m;
  PetscInt           first, n, lanes, nc;
  MPMBlock           begin, end;
  MPMComponent       H[ROWS], L[ROWS], T[ROWS], grown; /* grown: det f */
} Block;

/* Sets b->first to `first` and takes as many particles of one material as there are and a block has; copies their
   states. */
static void Begin(const MPMTangent *t, PetscInt first, PetscInt last, Block *b)
{
  const MPMView *v = t->particles;
  const PetscInt a = MPMKindOf(t->kinds, v, first)->material;

  b->m     = &t->materials[a];
  b->first = first;
  b->n     = 1;
  b->nc    = MPMTangentNumbers(t->dim, t->round);
  while (b->n < MPM_STAGED && first + b->n < last && MPMKindOf(t->kinds, v, first + b->n)->material == a) b->n++;
  b->lanes = (b->n + 7) / 8 * 8;
#define MPM_TAKE(name, rows)                                                                                           \
  for (int k = 0, nk = MPMComponents_##name((int)t->dim); k < (rows); k++) {                                           \
    const PetscBool has = b->m->state & MPM_BIT(name) && k < nk;                                                       \
    for (PetscInt p = 0; p < b->lanes; p++)                                                                            \
      b->begin.name[k][p] = has ? v->name[(first + PetscMin(p, b->n - 1)) * nk + k] : 0;                               \
  }
  MPM_MATERIAL_FIELDS(MPM_TAKE)
#undef MPM_TAKE
}

/* Returns whether x is a positive number. */
static PetscBool IsPositive(PetscReal x)
{
  return x > 0 && x <= PETSC_MAX_REAL;
}

/* Returns det f. */
static PetscReal Growth(const MPMTangent *t, const PetscReal H[])
{
  const PetscInt nf = t->dim * t->dim;
  PetscReal      f[9];

  for (PetscInt k = 0; k < nf; k++) f[k] = (k % (t->dim + 1) == 0) + H[k];
  return MPMDet((int)t->dim, f) * (t->round ? 1 + H[nf] : 1);
}

/* Sets column p of H from a row; returns whether the particle can follow it, and lets it rest otherwise. */
static PetscBool Deform(const MPMTangent *t, const PetscReal H[], PetscInt p, Block *b)
{
  const PetscReal J = Growth(t, H), F33 = b->m->state & MPM_BIT(F33) ? b->begin.F33[0][p] : 1;
  PetscReal       F[9], was             = 1;

  if (b->m->state & MPM_BIT(J)) was = b->begin.J[0][p];
  if (b->m->state & MPM_BIT(F)) {
    for (PetscInt k = 0; k < t->dim * t->dim; k++) F[k] = b->begin.F[k][p];
    was = MPMDet((int)t->dim, F) * F33;
  }
  b->grown[p] = IsPositive(J) && IsPositive(J * was) && (!t->round || 1 + H[b->nc - 1] > 0) ? J : 0;
  for (PetscInt k = 0; k < b->nc; k++) b->H[k][p] = b->grown[p] > 0 ? H[k] : 0;
  return b->grown[p] > 0;
}

/* Sets the columns of H from rows [n][nc], those of lanes without a particle to the last one; returns how many
   particles cannot follow. */
static PetscInt DeformAll(const MPMTangent *t, const PetscReal H[], Block *b)
{
  PetscInt bad = 0;

  for (PetscInt p = 0; p < b->n; p++) bad += Deform(t, H + p * b->nc, p, b) ? 0 : 1;
  for (PetscInt k = 0; k < b->nc; k++)
    for (PetscInt p = b->n; p < b->lanes; p++) b->H[k][p] = b->H[k][b->n - 1];
  return bad;
}

/* Sets F and L, and with `whole` the state and the stress at the end of the step; without, F alone is that of the end.
   */
static void Follow(const MPMTangent *t, PetscBool whole, Block *b)
{
  const int             dim = (int)t->dim, form = (int)MPMLawForm(b->m, t->dim);
  const PetscInt        nf  = t->dim * t->dim;
  const MPMMaterialLaw *law = b->m->type->law, *lanes = law->lanes[t->width == 8 ? 0 : t->width == 4 ? 1 : 2];

  if (t->width < 2 || !lanes) lanes = law;
#define MPM_COPY(name, rows)                                                                                           \
  for (int k = 0; k < (rows); k++) memcpy(b->end.name[k], b->begin.name[k], sizeof(PetscReal) * (size_t)b->lanes);
  MPM_MATERIAL_FIELDS(MPM_COPY)
#undef MPM_COPY
  for (PetscInt p = 0; p < b->lanes; p++) {
    PetscReal F[9], H[9];

    for (PetscInt k = 0; k < b->nc; k++) b->L[k][p] = b->H[k][p] / t->dt;
    if (!(b->m->state & MPM_BIT(F))) continue;
    for (PetscInt k = 0; k < nf; k++) F[k] = b->begin.F[k][p], H[k] = b->H[k][p];
    MPMDeform(dim, 1, H, F);
    for (PetscInt k = 0; k < nf; k++) b->end.F[k][p] = F[k];
    if (t->round) b->end.F33[0][p] += b->H[nf][p] * b->begin.F33[0][p];
  }
  if (!whole) return;
  if (law->trial[form])
    law->trial[form](b->m, t->dt, b->L, 0, b->n, &b->end);
  else if (law->update[form])
    lanes->update[form](b->m, t->dt, b->L, 0, b->n, &b->end);
  if (!(b->m->state & MPM_BIT(tau))) lanes->stress[form](b->m, 0, b->n, &b->end);
}

/* Computes g = f^-T of particle p; of a body of revolution then 1/f33. */
static void Inverse(const MPMTangent *t, const Block *b, PetscInt p, PetscReal g[ROWS])
{
  const PetscInt nf = t->dim * t->dim;
  PetscReal      f[9], J;

  for (PetscInt k = 0; k < nf; k++) f[k] = (k % (t->dim + 1) == 0) + b->H[k][p];
  J = MPMDet((int)t->dim, f);
  MPMCofactor((int)t->dim, f, g);
  for (PetscInt k = 0; k < nf; k++) g[k] /= J;
  if (t->round) g[nf] = 1 / (1 + b->H[nf][p]);
}

/* Computes T of particle p from the stress at the end of the step and g = f^-T. */
static void Nominal(const MPMTangent *t, const Block *b, PetscInt p, const PetscReal g[], PetscReal T[])
{
  const int dim = (int)t->dim;

  for (int a = 0; a < dim; a++)
    for (int B = 0; B < dim; B++) {
      T[a * dim + B] = 0;
      for (int c = 0; c < dim; c++) T[a * dim + B] += b->end.tau[MPMSymPart(dim, a, c)][p] * g[c * dim + B];
    }
  if (t->round) T[dim * dim] = b->end.tau[3][p] * g[dim * dim];
}

/* Computes A [nc*nc] of particle p from C, g = f^-T and T. */
static void FromLaw(const MPMTangent *t, const Block *b, PetscReal C[6][MPM_TANGENT_NC], const PetscReal g[],
                    const PetscReal T[], PetscReal A[])
{
  const int dim = (int)t->dim, nf = dim * dim, nc = (int)b->nc;

  for (int c = 0; c < dim; c++)
    for (int D = 0; D < dim; D++) {
      PetscReal dtau[6];

      for (int k = 0; k < 6; k++) {
        dtau[k] = 0;
        for (int e = 0; e < dim; e++) dtau[k] += C[k][c * dim + e] * g[e * dim + D];
      }
      for (int a = 0; a < dim; a++)
        for (int B = 0; B < dim; B++) {
          PetscReal s = -T[a * dim + D] * g[c * dim + B];

          for (int d = 0; d < dim; d++) s += dtau[MPMSymIndex(a, d)] * g[d * dim + B];
          A[(a * dim + B) * nc + c * dim + D] = s;
        }
      if (t->round) A[nf * nc + c * dim + D] = dtau[5] * g[nf];
    }
  if (!t->round) return;
  for (int a = 0; a < dim; a++)
    for (int B = 0; B < dim; B++) {
      A[(a * dim + B) * nc + nf] = 0;
      for (int d = 0; d < dim; d++) A[(a * dim + B) * nc + nf] += C[MPMSymIndex(a, d)][nf] * g[nf] * g[d * dim + B];
    }
  A[nf * nc + nf] = (C[5][nf] * g[nf] - T[nf]) * g[nf];
}

/* Computes T of all particles of the block, where one component of each H is moved by `by`, if it can be; H is put
   back. moved [n]: by how much. */
static void Beside(const MPMTangent *t, PetscInt component, PetscReal by, Block *b, PetscReal moved[])
{
  MPMComponent keep;

  memcpy(keep, b->H[component], sizeof keep);
  for (PetscInt p = 0; p < b->n; p++) {
    PetscReal H[ROWS];

    for (PetscInt k = 0; k < b->nc; k++) H[k] = b->H[k][p];
    H[component] += by;
    moved[p] = Growth(t, H) > 0 ? H[component] - keep[p] : 0;
    b->H[component][p] += moved[p];
  }
  Follow(t, PETSC_TRUE, b);
  for (PetscInt p = 0; p < b->n; p++) {
    PetscReal g[ROWS], T[ROWS];

    Inverse(t, b, p, g);
    Nominal(t, b, p, g, T);
    for (PetscInt k = 0; k < b->nc; k++) b->T[k][p] = T[k];
  }
  memcpy(b->H[component], keep, sizeof keep);
}

/* Computes A [n][nc*nc] of a block by central differences. */
static void FromDifferences(const MPMTangent *t, Block *b, PetscReal A[])
{
  const PetscInt nc = b->nc;

  for (PetscInt l = 0; l < nc; l++) {
    MPMComponent above[ROWS], up, down;

    Beside(t, l, STEP, b, up);
    memcpy(above, b->T, sizeof above);
    Beside(t, l, -STEP, b, down);
    for (PetscInt p = 0; p < b->n; p++)
      for (PetscInt k = 0; k < nc; k++)
        A[p * nc * nc + k * nc + l] = up[p] > down[p] ? (above[k][p] - b->T[k][p]) / (up[p] - down[p]) : 0;
  }
}

/* Computes T and A of the particles of a block; `bad` of them could not follow. */
static void Derive(const MPMTangent *t, PetscInt bad, Block *b, PetscReal T[], PetscReal A[])
{
  const PetscInt nc                        = b->nc;
  void (*law)(const MPMMaterial *, PetscReal, MPMComponent *, PetscInt, const MPMBlock *,
              PetscReal[][MPM_TANGENT_NC]) = b->m->type->law->tangent[MPMLawForm(b->m, t->dim)];

  Follow(t, PETSC_TRUE, b);
  for (PetscInt p = 0; p < b->n; p++) {
    PetscReal g[ROWS];

    Inverse(t, b, p, g);
    Nominal(t, b, p, g, T + p * nc);
  }
  if (A && law) {
    Follow(t, PETSC_FALSE, b);
    for (PetscInt p = 0; p < b->n; p++) {
      PetscReal g[ROWS], C[6][MPM_TANGENT_NC];

      Inverse(t, b, p, g);
      law(b->m, t->dt, b->L, p, &b->end, C);
      FromLaw(t, b, C, g, T + p * nc, A + p * nc * nc);
    }
  } else if (A)
    FromDifferences(t, b, A);
  for (PetscInt p = 0; p < b->n && bad; p++) {
    if (b->grown[p] > 0) continue;
    for (PetscInt k = 0; k < nc; k++) T[p * nc + k] = 0;
    for (PetscInt k = 0; k < nc * nc && A; k++) A[p * nc * nc + k] = 0;
  }
}

PetscInt MPMTangentTrial(const MPMTangent *t, PetscInt first, PetscInt last, const PetscReal H[], PetscReal T[],
                         PetscReal A[])
{
  const PetscInt nc  = MPMTangentNumbers(t->dim, t->round);
  PetscInt       bad = 0;
  Block          b;

  for (PetscInt from = first; from < last; from = b.first + b.n) {
    const PetscInt at = from - first;
    PetscInt       now;

    Begin(t, from, last, &b);
    now = DeformAll(t, H + at * nc, &b);
    Derive(t, now, &b, T + at * nc, A ? A + at * nc * nc : NULL);
    bad += now;
  }
  return bad;
}

PetscInt MPMTangentCommit(const MPMTangent *t, PetscInt first, PetscInt last, const PetscReal H[])
{
  const int      dim = (int)t->dim;
  const MPMView *v   = t->particles;
  const PetscInt nc  = MPMTangentNumbers(t->dim, t->round);
  PetscInt       bad = 0;
  Block          b;

  for (PetscInt from = first; from < last; from = b.first + b.n) {
    Begin(t, from, last, &b);
    bad += DeformAll(t, H + (from - first) * nc, &b);
    Follow(t, PETSC_TRUE, &b);
#define MPM_GIVE(name, rows)                                                                                           \
  for (PetscInt p = 0; p < b.n && b.m->state & MPM_BIT(name); p++)                                                     \
    for (int k = 0; k < MPMComponents_##name(dim) && b.grown[p] > 0; k++)                                              \
      v->name[(from + p) * MPMComponents_##name(dim) + k] = b.end.name[k][p];
    MPM_MATERIAL_FIELDS(MPM_GIVE)
#undef MPM_GIVE
  }
  return bad;
}

PetscBool MPMTangentIsOwn(const MPMMaterial *m)
{
  return m->type->law->tangent[0] ? PETSC_TRUE : PETSC_FALSE;
}

PetscBool MPMTangentIsSymmetric(const MPMMaterial *m, PetscInt dim)
{
  if (dim == 1) return PETSC_TRUE;
  return m->type->traits & MPM_SYMMETRIC && !m->skew;
}
