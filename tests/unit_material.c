/* unit_material.c - what the rows of material.def promise by their traits, in 1, 2 and 3 dimensions, by random F.
   A new row is tested without a new line here, as long as it takes the options E and nu.                              */
#include "mpm.h"
#include "unit.h"

#define ROUNDS 300

static const PetscReal poissons[] = {0.3, 0, 0.45, 0.499, -0.3, -0.9}, moduli[] = {3.7, 2.1e11};

/* ---- One point through the block functions: F and results with stride 1. */
static void Stress(const MPMMaterial *m, int dim, const PetscReal *F, PetscReal tau[6])
{
  PetscReal block[9 * MPM_BLOCK], out[6 * MPM_BLOCK];

  for (int k = 0; k < dim * dim; k++) block[k * MPM_BLOCK] = F[k];
  m->type->law->stress[dim - 1](m, 1, block, out);
  for (int k = 0; k < 6; k++) tau[k] = out[k * MPM_BLOCK];
}

static PetscReal Energy(const MPMMaterial *m, int dim, const PetscReal *F)
{
  PetscReal block[9 * MPM_BLOCK], W[MPM_BLOCK];

  for (int k = 0; k < dim * dim; k++) block[k * MPM_BLOCK] = F[k];
  m->type->law->energy[dim - 1](m, 1, block, W);
  return W[0];
}

static PetscReal Speed2(const MPMMaterial *m, int dim, const PetscReal *F)
{
  PetscReal block[9 * MPM_BLOCK], c2[MPM_BLOCK];

  for (int k = 0; k < dim * dim; k++) block[k * MPM_BLOCK] = F[k];
  m->type->law->speed2[dim - 1](m, 1, block, c2);
  return c2[0];
}

/* ---- Matrices */
static void Identity(int dim, PetscReal *F)
{
  for (int k = 0; k < dim * dim; k++) F[k] = k % (dim + 1) == 0;
}

/* Random F of det > 0.2: I + size (-1 .. 1). */
static void RandomF(int dim, PetscReal size, PetscReal *F)
{
  do {
    Identity(dim, F);
    for (int k = 0; k < dim * dim; k++) F[k] += UnitReal(-size, size);
  } while (!(MPMDet(dim, F) > 0.2));
}

static void Multiply(int dim, const PetscReal *A, const PetscReal *B, PetscReal *C)
{
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      C[d * dim + e] = 0;
      for (int k = 0; k < dim; k++) C[d * dim + e] += A[d * dim + k] * B[k * dim + e];
    }
}

/* Rotation by `angle` about a random axis (2-D: in the plane). */
static void Rotation(int dim, PetscReal angle, PetscReal *R)
{
  const PetscReal c = cos(angle), s = sin(angle);

  Identity(dim, R);
  if (dim == 2) {
    R[0] = R[3] = c;
    R[1]        = -s;
    R[2]        = s;
  }
  if (dim == 3) {
    PetscReal n[3], norm = 0;

    for (int d = 0; d < 3; d++) {
      n[d] = UnitReal(-1, 1);
      norm += n[d] * n[d];
    }
    for (int d = 0; d < 3; d++) n[d] /= sqrt(norm);
    for (int d = 0; d < 3; d++)
      for (int e = 0; e < 3; e++) R[3 * d + e] = (d == e ? c : 0) + (1 - c) * n[d] * n[e];
    R[1] -= s * n[2];
    R[3] += s * n[2];
    R[2] += s * n[1];
    R[6] -= s * n[1];
    R[5] -= s * n[0];
    R[7] += s * n[0];
  }
}

/* F in dimension `to`, with ones on the new diagonal. */
static void Embed(int dim, const PetscReal *F, int to, PetscReal *G)
{
  Identity(to, G);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) G[d * to + e] = F[d * dim + e];
}

/* ---- Properties */

/* tau = (dW/dF) F^T, by differences of fourth order. */
static void Hyperelastic(const MPMMaterial *m, int dim, const PetscReal *F)
{
  const PetscReal h = 2e-3, scale = m->E + m->mu + PetscAbsReal(m->lambda);
  PetscReal       P[9], PF[9], T[9], tau[6];

  for (int k = 0; k < dim * dim; k++) {
    PetscReal G[9], W[4];

    for (int j = 0; j < 4; j++) {
      memcpy(G, F, sizeof(PetscReal) * dim * dim);
      G[k] += (j < 2 ? j - 2 : j - 1) * h; /* -2h -h h 2h */
      W[j] = Energy(m, dim, G);
    }
    P[k] = (8 * (W[2] - W[1]) - (W[3] - W[0])) / (12 * h);
  }
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) T[d * dim + e] = F[e * dim + d];
  Multiply(dim, P, T, PF);
  Stress(m, dim, F, tau);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) CHECK_NEAR(tau[MPMSymIndex(d, e)] / scale, PF[d * dim + e] / scale, 1e-7);
}

/* sig = dW/de, for symmetric F = I + e. A shear strain stands twice in F. */
static void SmallStrain(const MPMMaterial *m, int dim, const PetscReal *anyF)
{
  const PetscReal h = 1e-2, scale = m->E + m->mu + PetscAbsReal(m->lambda);
  PetscReal       F[9], tau[6];

  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) F[d * dim + e] = 0.5 * (anyF[d * dim + e] + anyF[e * dim + d]);
  if (!(MPMDet(dim, F) > 0)) return;
  Stress(m, dim, F, tau);
  for (int d = 0; d < dim; d++)
    for (int e = d; e < dim; e++) {
      PetscReal G[9], W[2];

      for (int j = 0; j < 2; j++) {
        memcpy(G, F, sizeof G);
        G[d * dim + e] += j ? h : -h;
        if (d != e) G[e * dim + d] += j ? h : -h;
        W[j] = Energy(m, dim, G);
      }
      CHECK_NEAR(tau[MPMSymIndex(d, e)] / MPMDet(dim, F) / scale, (W[1] - W[0]) / (2 * h) / (d == e ? 1 : 2) / scale, 1e-11);
    }
}

/* tau(QF) = Q tau(F) Q^T and W(QF) = W(F). */
static void Objective(const MPMMaterial *m, int dim, const PetscReal *F)
{
  PetscReal Q[9], QF[9], tau[6], turned[6], norm = 1;

  Rotation(dim, UnitReal(-4, 4), Q);
  Multiply(dim, Q, F, QF);
  Stress(m, dim, F, tau);
  Stress(m, dim, QF, turned);
  for (int k = 0; k < dim * dim; k++) norm += F[k] * F[k];
  norm *= m->E + m->mu + PetscAbsReal(m->lambda);
  for (int d = 0; d < 3; d++)
    for (int e = d; e < 3; e++) {
      PetscReal s = 0;

      for (int j = 0; j < 3; j++)
        for (int k = 0; k < 3; k++) {
          const PetscReal qj = d < dim && j < dim ? Q[d * dim + j] : d == j, qk = e < dim && k < dim ? Q[e * dim + k] : e == k;
          s += qj * tau[MPMSymIndex(j, k)] * qk;
        }
      CHECK_NEAR(turned[MPMSymIndex(d, e)] / norm, s / norm, 1e-12);
    }
  CHECK_NEAR(Energy(m, dim, QF) / norm, Energy(m, dim, F) / norm, 1e-12);
}

/* A row that is not objective is known not to be: a quarter turn makes stress out of nothing. But a rotation of 1e-6
   makes none to first order.                                                                                          */
static void NotObjective(const MPMMaterial *m, int dim)
{
  PetscReal R[9], tau[6], size = 0;

  if (dim == 1) return;
  Rotation(dim, PETSC_PI / 2, R);
  Stress(m, dim, R, tau);
  for (int k = 0; k < 6; k++) size = PetscMax(size, PetscAbsReal(tau[k]));
  CHECK_GE(size, 0.1 * m->E);
  Rotation(dim, 1e-6, R);
  Stress(m, dim, R, tau);
  for (int k = 0; k < 6; k++) CHECK_LE(PetscAbsReal(tau[k]), 4e-12 * (PetscAbsReal(m->lambda) + m->mu));
}

/* F = I is without stress and energy, exactly; its waves have (lambda + 2 mu)/rho. */
static void Reference(const MPMMaterial *m, int dim)
{
  PetscReal F[9], tau[6];

  Identity(dim, F);
  Stress(m, dim, F, tau);
  for (int k = 0; k < 6; k++) CHECK_EQ(tau[k], 0);
  CHECK_EQ(Energy(m, dim, F), 0);
  CHECK_NEAR(Speed2(m, dim, F) * m->rho / (m->lambda + 2 * m->mu), 1, 1e-12);
}

/* d tau/d e at F = I is Hooke's law: tau = lambda tr e I + 2 mu e with e = sym(H), for F = I + s H. */
static void Hooke(const MPMMaterial *m, int dim)
{
  const PetscReal s = 1e-5;
  PetscReal       H[9], F[9], lo[6], hi[6], tr = 0;

  for (int k = 0; k < dim * dim; k++) H[k] = UnitReal(-1, 1);
  for (int sign = -1; sign <= 1; sign += 2) {
    Identity(dim, F);
    for (int k = 0; k < dim * dim; k++) F[k] += sign * s * H[k];
    Stress(m, dim, F, sign < 0 ? lo : hi);
  }
  for (int d = 0; d < dim; d++) tr += H[d * dim + d];
  for (int d = 0; d < 3; d++)
    for (int e = d; e < 3; e++) {
      const PetscReal sym   = d < dim && e < dim ? 0.5 * (H[d * dim + e] + H[e * dim + d]) : 0;
      const PetscReal hooke = 2 * m->mu * sym + (d == e ? m->lambda * tr : 0), scale = m->E + m->mu + PetscAbsReal(m->lambda);
      const int       k     = MPMSymIndex(d, e);
      CHECK_NEAR((hi[k] - lo[k]) / (2 * s) / scale, hooke / scale, 2e-9);
    }
}

/* A deformation in fewer dimensions is one in more, with ones on the diagonal: same tau, all six components, same W. */
static void Dimensions(const MPMMaterial *m, int dim, const PetscReal *F)
{
  PetscReal tau[6], higher[6], G[9], norm = 1;

  for (int k = 0; k < dim * dim; k++) norm += F[k] * F[k];
  norm *= m->E + m->mu + PetscAbsReal(m->lambda);
  Stress(m, dim, F, tau);
  for (int to = dim + 1; to <= 3; to++) {
    Embed(dim, F, to, G);
    Stress(m, to, G, higher);
    for (int k = 0; k < 6; k++) CHECK_NEAR(tau[k] / norm, higher[k] / norm, 1e-14);
    CHECK_NEAR(Energy(m, dim, F) / norm, Energy(m, to, G) / norm, 1e-14);
  }
}

/* Every point of a block gets the bits it gets alone, wherever it lies and however many there are; nothing is written
   beyond the n points.                                                                                                */
static void Block(const MPMMaterial *m, int dim)
{
  const MPMMaterialLaw *law = m->type->law;
  PetscReal             F[9 * MPM_BLOCK], alone[8][MPM_BLOCK];

  for (int p = 0; p < MPM_BLOCK; p++) {
    PetscReal Fp[9], tau[6];

    RandomF(dim, p % 3 ? 0.4 : 1e-3, Fp);
    for (int k = 0; k < dim * dim; k++) F[k * MPM_BLOCK + p] = Fp[k];
    Stress(m, dim, Fp, tau);
    for (int k = 0; k < 6; k++) alone[k][p] = tau[k];
    alone[6][p] = Energy(m, dim, Fp);
    alone[7][p] = Speed2(m, dim, Fp);
  }
  for (PetscInt n = 1; n <= MPM_BLOCK; n++) {
    const PetscInt first = UnitInt(MPM_BLOCK - (int)n + 1); /* a run of points within a block, as the transfers call it */
    PetscReal      out[8][MPM_BLOCK];

    for (int k = 0; k < 8; k++)
      for (int p = 0; p < MPM_BLOCK; p++) out[k][p] = -12345;
    law->stress[dim - 1](m, n, F + first, out[0] + first);
    law->energy[dim - 1](m, n, F + first, out[6] + first);
    law->speed2[dim - 1](m, n, F + first, out[7] + first);
    for (int k = 0; k < 8; k++) {
      CHECK_SAME(out[k] + first, alone[k] + first, n * sizeof(PetscReal));
      for (int p = 0; p < MPM_BLOCK; p++)
        if (p < first || p >= first + n) CHECK_EQ(out[k][p], -12345);
    }
  }
}

/* Largest real part of the eigenvalues of Q [dim*dim], which need not be symmetric: from its characteristic polynomial. */
static PetscReal LargestEigenvalue(int dim, const PetscReal *Q)
{
  if (dim == 1) return Q[0];
  if (dim == 2) {
    const PetscReal t = 0.5 * (Q[0] + Q[3]), D = 0.25 * (Q[0] - Q[3]) * (Q[0] - Q[3]) + Q[1] * Q[2];
    return t + (D > 0 ? sqrt(D) : 0);
  }
  { /* x^3 - a x^2 + b x - c, with x = y + a/3: y^3 + p y + q */
    const long double a = (long double)Q[0] + Q[4] + Q[8];
    const long double b = (long double)Q[0] * Q[4] - (long double)Q[1] * Q[3] + (long double)Q[0] * Q[8] - (long double)Q[2] * Q[6] + (long double)Q[4] * Q[8] - (long double)Q[5] * Q[7];
    const long double c = MPMDet(3, Q), p = b - a * a / 3, q = -2 * a * a * a / 27 + a * b / 3 - c, D = q * q / 4 + p * p * p / 27;
    long double       y;

    if (D <= 0) y = p < 0 ? 2 * sqrtl(-p / 3) * cosl(acosl(fminl(1, fmaxl(-1, 3 * q / (2 * p) * sqrtl(-3 / p)))) / 3) : 0;
    else {
      y = cbrtl(-q / 2 + sqrtl(D)) + cbrtl(-q / 2 - sqrtl(D)); /* one real root; the pair has real part -y/2 */
      y = fmaxl(y, -y / 2);
    }
    return (PetscReal)(a / 3 + y);
  }
}

/* Speed of plane waves along n in the deformed state. A velocity field a e^{ik n.x} changes F by s a (x) n F, hence
   P = tau F^-T by dP; the wave sees Q a = (dP/ds) F^T n = (d tau/ds) n - tau n (a.n), and rho0 c^2 is an eigenvalue of
   Q. speed2 must not be below any. With a hyperelastic law a.Q a is d^2W/ds^2, which is checked on the way.           */
static void Waves(const MPMMaterial *m, int dim, const PetscReal *F, const PetscReal *n)
{
  const PetscReal h = 1e-3, scale = m->E + m->mu + PetscAbsReal(m->lambda);
  PetscReal       Q[9], tau[6], Fn[3], norm = 1;

  Stress(m, dim, F, tau);
  for (int k = 0; k < dim * dim; k++) norm += F[k] * F[k];
  for (int e = 0; e < dim; e++) {
    Fn[e] = 0;
    for (int d = 0; d < dim; d++) Fn[e] += n[d] * F[d * dim + e]; /* F^T n */
  }
  for (int a = 0; a < dim; a++) { /* column a of Q: polarised along axis a */
    PetscReal G[9], t[4][6], W[5];

    for (int j = 0; j < 4; j++) {
      memcpy(G, F, sizeof(PetscReal) * dim * dim);
      for (int e = 0; e < dim; e++) G[a * dim + e] += (j < 2 ? j - 2 : j - 1) * h * Fn[e];
      Stress(m, dim, G, t[j]);
      W[j] = Energy(m, dim, G);
    }
    W[4] = Energy(m, dim, F);
    for (int d = 0; d < dim; d++) {
      Q[d * dim + a] = 0;
      for (int e = 0; e < dim; e++) {
        const int k = MPMSymIndex(d, e);
        Q[d * dim + a] += ((8 * (t[2][k] - t[1][k]) - (t[3][k] - t[0][k])) / (12 * h) - tau[k] * n[a]) * n[e];
      }
    }
    if (m->type->traits & MPM_HYPERELASTIC)
      CHECK_NEAR((16 * (W[1] + W[2]) - (W[0] + W[3]) - 30 * W[4]) / (12 * h * h) / (scale * norm), Q[a * dim + a] / (scale * norm), 1e-7);
  }
  CHECK_GE((Speed2(m, dim, F) * m->rho - LargestEigenvalue(dim, Q)) / (scale * norm), -1e-8);
}

static void AllWaves(const MPMMaterial *m, int dim, const PetscReal *F)
{
  PetscReal n[3];

  for (int k = 0; k < dim + 20; k++) { /* along the axes, then anywhere */
    PetscReal norm = 0;

    for (int d = 0; d < dim; d++) {
      n[d] = k < dim ? d == k : UnitReal(-1, 1);
      norm += n[d] * n[d];
    }
    if (norm < 1e-3) continue;
    for (int d = 0; d < dim; d++) n[d] /= sqrt(norm);
    Waves(m, dim, F, n);
  }
}

static void Bound(const MPMMaterial *m, int dim, PetscReal size)
{
  static const PetscReal stretches[] = {0.4, 0.8, 0.99, 1.01, 1.25, 2, 3};
  PetscReal              F[9];
  const char            *name = m->name;

  for (size_t k = 0; k < sizeof stretches / sizeof stretches[0]; k++) {
    UnitContext("%s, nu = %g, dim %d, waves, all axes stretched by %g", name, m->nu, dim, stretches[k]);
    Identity(dim, F);
    for (int d = 0; d < dim; d++) F[d * (dim + 1)] = stretches[k];
    AllWaves(m, dim, F);
    UnitContext("%s, nu = %g, dim %d, waves, one axis stretched by %g", name, m->nu, dim, stretches[k]);
    Identity(dim, F);
    F[UnitInt(dim) * (dim + 1)] = stretches[k];
    AllWaves(m, dim, F);
  }
  for (int d = 0; d < dim; d++) { /* a column or a row of F is large */
    UnitContext("%s, nu = %g, dim %d, waves, column %d of F", name, m->nu, dim, d);
    Identity(dim, F);
    for (int e = 0; e < dim; e++) F[e * dim + d] += 0.1;
    AllWaves(m, dim, F);
    UnitContext("%s, nu = %g, dim %d, waves, row %d of F", name, m->nu, dim, d);
    Identity(dim, F);
    for (int e = 0; e < dim; e++) F[d * dim + e] += 0.1;
    AllWaves(m, dim, F);
  }
  for (int round = 0; round < ROUNDS / 3; round++) {
    UnitContext("%s, nu = %g, dim %d, waves, random F %d", name, m->nu, dim, round);
    RandomF(dim, round % 2 ? size : 0.05, F);
    AllWaves(m, dim, F);
  }
}

static void Law(const MPMMaterial *m, int dim)
{
  const PetscInt traits = m->type->traits;

  UnitContext("%s, E = %g, nu = %g, dim %d, at F = I", m->name, m->E, m->nu, dim);
  Reference(m, dim);
  if (!(traits & MPM_OBJECTIVE)) NotObjective(m, dim);
  UnitContext("%s, E = %g, nu = %g, dim %d, block", m->name, m->E, m->nu, dim);
  Block(m, dim);
  for (int round = 0; round < ROUNDS; round++) {
    PetscReal F[9] = {0};

    UnitContext("%s, E = %g, nu = %g, dim %d, F %d", m->name, m->E, m->nu, dim, round);
    RandomF(dim, round % 3 ? 0.5 : 0.01, F);
    if (traits & MPM_HYPERELASTIC) Hyperelastic(m, dim, F);
    if (traits & MPM_SMALL_STRAIN) SmallStrain(m, dim, F);
    if (traits & MPM_OBJECTIVE) Objective(m, dim, F);
    if (traits & (MPM_HYPERELASTIC | MPM_SMALL_STRAIN)) Hooke(m, dim);
    Dimensions(m, dim, F);
    /* With nu < 0 a finite compression may have W < 0 by the law itself: the term of lambda is negative. */
    if (m->nu >= 0 || round % 3 == 0) CHECK_GE(Energy(m, dim, F) / (PetscAbsReal(m->lambda) + m->mu), -8 * DBL_EPSILON);
  }
  Bound(m, dim, 0.5);
}

int main(void)
{
  for (const MPMMaterialType *type = MPMMaterialTypes; type->name; type++)
    for (size_t i = 0; i < sizeof poissons / sizeof poissons[0]; i++)
      for (size_t j = 0; j < sizeof moduli / sizeof moduli[0]; j++) {
        MPMMaterial m;

        memset(&m, 0, sizeof m);
        snprintf(m.name, sizeof m.name, "%s", type->name);
        m.type = type;
        m.rho  = 1100;
        m.E    = moduli[j];
        m.nu   = poissons[i];
        MPMMaterialSetUp(&m);
        UnitContext("%s, E = %g, nu = %g", type->name, m.E, m.nu);
        CHECK_NEAR(m.mu * (3 * m.lambda + 2 * m.mu) / (m.lambda + m.mu) / m.E, 1, 1e-13); /* back to E and nu */
        CHECK_NEAR(m.lambda / (2 * (m.lambda + m.mu)), m.nu, 1e-13);
        for (int dim = 1; dim <= 3; dim++) {
          CHECK(type->law->stress[dim - 1] && type->law->energy[dim - 1] && type->law->speed2[dim - 1]);
          Law(&m, dim);
        }
      }
  return UnitEnd();
}
