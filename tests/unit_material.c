/* unit_material.c - what the rows of material.def promise by their traits, in 1, 2 and 3 dimensions, by random F and
   random paths. A new row of Young's modulus and Poisson's ratio is tested without a new line here; others need their
   constants in main.                                                                                                 */
#include "kernels/transfer.h"
#include "physics/law.h"
#include "unit.h"

#define ROUNDS 100

static const PetscReal poissons[] = {0.3, 0, 0.45, 0.499, -0.3, -0.9}, moduli[] = {3.7, 2.1e11};
static PetscReal       least = 0.2; /* the smallest det F of random F */

/* ---- One particle through the block functions. Fields that a law must not read are NaN. */
static void Put(const MPMMaterial *m, int dim, const MPMParticleState *s, MPMBlock *b, int p)
{
  MPMParticleState known = *s;
  PetscReal       *all   = (PetscReal *)b;

  for (size_t row = 0; row < sizeof *b / sizeof(PetscReal[MPM_BLOCK]); row++) all[row * MPM_BLOCK + p] = NAN;
  if (m->state & MPM_BIT(F))
    for (int k = 0; k < dim * dim; k++) b->F[k][p] = s->F[k];
  MPMParticleStore(dim, m->state, &known, b, p, p, p + 1);
}

/* A step dt with L: F, then the law's update. */
static void Step(const MPMMaterial *m, int dim, PetscReal dt, const PetscReal *L, MPMParticleState *s)
{
  const int    p = UnitInt(MPM_BLOCK);
  MPMBlock     b;
  MPMComponent Lb[9];

  MPMDeform(dim, dt, L, s->F);
  Put(m, dim, s, &b, p);
  for (int k = 0; k < dim * dim; k++) Lb[k][p] = L[k];
  m->type->law->update[dim - 1](m, dt, Lb, p, p + 1, &b);
  for (int k = 0; k < dim * dim; k++)
    if (m->state & MPM_BIT(F)) CHECK_EQ(b.F[k][p], s->F[k]);
  MPMParticleLoad(dim, &b, p, s);
  if (!(m->state & MPM_BIT(F))) memset(s->F, 0, sizeof s->F);
  if (!(m->state & MPM_BIT(be))) memset(s->be, 0, sizeof s->be);
  if (!(m->state & MPM_BIT(ep))) s->ep = 0;
  if (!(m->state & MPM_BIT(vc))) s->vc = 0;
  if (!(m->state & MPM_BIT(theta))) s->theta = 0;
  if (!(m->state & MPM_BIT(tau))) memset(s->tau, 0, sizeof s->tau);
}

/* The state at rest. */
static void Start(int dim, MPMParticleState *s)
{
  memset(s, 0, sizeof *s);
  for (int d = 0; d < dim; d++) s->F[d * (dim + 1)] = 1;
  s->be[0] = s->be[3] = s->be[5] = s->J = 1;
}

/* The state that F alone makes: of a plastic law the elastic one, be = F F^T; of a fluid without motion. */
static void State(const MPMMaterial *m, int dim, const PetscReal *F, MPMParticleState *s)
{
  static const PetscReal L[9] = {0};
  MPMBlock               b;

  Start(dim, s);
  memcpy(s->F, F, sizeof(PetscReal) * dim * dim);
  s->J = MPMDet(dim, F);
  MPMLeftCauchyGreen(dim, F, s->be);
  if (m->state & MPM_BIT(tau))
    Step(m, dim, 0, L, s);
  else {
    Put(m, dim, s, &b, 3);
    m->type->law->stress[dim - 1](m, 3, 4, &b);
    for (int k = 0; k < MPM_SYM_NC(dim); k++) s->tau[MPMSymPlace(dim, k)] = b.tau[k][3];
  }
}

static PetscReal StateEnergy(const MPMMaterial *m, int dim, const MPMParticleState *s)
{
  MPMBlock  b;
  PetscReal W[MPM_BLOCK];

  Put(m, dim, s, &b, 7);
  m->type->law->energy[dim - 1](m, 7, 8, &b, W);
  return W[7];
}

static void Stress(const MPMMaterial *m, int dim, const PetscReal *F, PetscReal tau[6])
{
  MPMParticleState s;

  State(m, dim, F, &s);
  for (int k = 0; k < 6; k++) tau[k] = s.tau[k];
}

static PetscReal Energy(const MPMMaterial *m, int dim, const PetscReal *F)
{
  MPMParticleState s;

  State(m, dim, F, &s);
  return StateEnergy(m, dim, &s);
}

static PetscReal Speed2(const MPMMaterial *m, int dim, const PetscReal *F)
{
  MPMParticleState s;
  MPMBlock         b;
  PetscReal        c2[MPM_BLOCK];

  State(m, dim, F, &s);
  Put(m, dim, &s, &b, 0);
  m->type->law->speed2[dim - 1](m, 0, 1, &b, c2);
  return c2[0];
}

/* ---- Matrices */
static void Identity(int dim, PetscReal *F)
{
  for (int k = 0; k < dim * dim; k++) F[k] = k % (dim + 1) == 0;
}

/* Random F of det > least: I + size (-1 .. 1). */
static void RandomF(int dim, PetscReal size, PetscReal *F)
{
  do {
    Identity(dim, F);
    for (int k = 0; k < dim * dim; k++) F[k] += UnitReal(-size, size);
  } while (!(MPMDet(dim, F) > least));
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
  PetscReal       P[9], PFt[9], T[9], tau[6];

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
  Multiply(dim, P, T, PFt);
  Stress(m, dim, F, tau);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) CHECK_NEAR(tau[MPMSymIndex(d, e)] / scale, PFt[d * dim + e] / scale, 1e-7);
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
      CHECK_NEAR(tau[MPMSymIndex(d, e)] / MPMDet(dim, F) / scale, (W[1] - W[0]) / (2 * h) / (d == e ? 1 : 2) / scale,
                 1e-11);
    }
}

/* Q a Q^T of a symmetric tensor [6], with Q in dim dimensions. */
static void Turn(int dim, const PetscReal *Q, const PetscReal a[6], PetscReal turned[6])
{
  for (int d = 0; d < 3; d++)
    for (int e = d; e < 3; e++) {
      PetscReal s = 0;

      for (int j = 0; j < 3; j++)
        for (int k = 0; k < 3; k++) {
          const PetscReal qj = d < dim && j < dim ? Q[d * dim + j] : d == j;
          const PetscReal qk = e < dim && k < dim ? Q[e * dim + k] : e == k;
          s += qj * a[MPMSymIndex(j, k)] * qk;
        }
      turned[MPMSymIndex(d, e)] = s;
    }
}

/* tau(QF) = Q tau(F) Q^T and W(QF) = W(F). */
static void Objective(const MPMMaterial *m, int dim, const PetscReal *F)
{
  PetscReal Q[9], QF[9], tau[6], turned[6], tau_turned[6], norm = 1;

  Rotation(dim, UnitReal(-4, 4), Q);
  Multiply(dim, Q, F, QF);
  Stress(m, dim, F, tau);
  Stress(m, dim, QF, turned);
  for (int k = 0; k < dim * dim; k++) norm += F[k] * F[k];
  norm *= m->E + m->mu + PetscAbsReal(m->lambda);
  Turn(dim, Q, tau, tau_turned);
  for (int k = 0; k < 6; k++) CHECK_NEAR(turned[k] / norm, tau_turned[k] / norm, 1e-12);
  CHECK_NEAR(Energy(m, dim, QF) / norm, Energy(m, dim, F) / norm, 1e-12);
}

/* A row that is not objective is known not to be: a quarter turn makes stress out of nothing. But a rotation of 1e-6
   makes none to first order. */
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
      const PetscReal hooke = 2 * m->mu * sym + (d == e ? m->lambda * tr : 0),
                      scale = m->E + m->mu + PetscAbsReal(m->lambda);
      const int k           = MPMSymIndex(d, e);
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

/* Every particle of a block gets the bits it gets alone, wherever it lies and however many there are, with every number
   of lanes that the machine has; nothing is written but the particles first .. last-1 of the fields of the state (and
   tau of a law that gives it on demand). */
static void Block(const MPMMaterial *m, int dim)
{
  const MPMMaterialLaw *law = m->type->law, *lanes;
  MPMBlock              block, alone, run;
  MPMComponent          L[9];
  PetscReal             out[3][2][MPM_BLOCK];

  for (int p = 0; p < MPM_BLOCK; p++) {
    MPMParticleState s;
    PetscReal        F[9];

    RandomF(dim, p % 3 ? 0.4 : 1e-3, F);
    State(m, dim, F, &s);
    Put(m, dim, &s, &block, p);
    for (int k = 0; k < dim * dim; k++) L[k][p] = UnitReal(-1, 1);
  }
  for (PetscInt n = 0, width = 0; n <= MPM_BLOCK; width = width < 3 && n ? width + 1 : 0, n += !width) {
    /* n = 0: one by one, to compare with */
    const PetscInt first = n ? UnitInt(MPM_BLOCK - (int)n + 1) : 0, last = n ? first + n : MPM_BLOCK;

    if (width && MPMKernelWidth() < 1 << width) continue; /* 1, 2, 4, 8 lanes */
    lanes = width && law->lanes[3 - width] ? law->lanes[3 - width] : law;
    run   = block;
    for (int k = 0; k < 2; k++)
      for (int p = 0; p < MPM_BLOCK; p++) out[2][k][p] = -12345;
    for (PetscInt p = first; p < last; p += n ? n : 1) {
      const PetscInt end = n ? last : p + 1;

      law->energy[dim - 1](m, p, end, &run, out[2][0]);
      CHECK(lanes->speed2[dim - 1] && !lanes->update[dim - 1] == !law->update[dim - 1] &&
            !lanes->stress[dim - 1] == !law->stress[dim - 1]);
      lanes->speed2[dim - 1](m, p, end, &run, out[2][1]);
      if (law->update[dim - 1]) lanes->update[dim - 1](m, 0.1, L, p, end, &run);
      if (!(m->state & MPM_BIT(tau))) lanes->stress[dim - 1](m, p, end, &run);
    }
    if (n == 0) {
      alone = run;
      memcpy(out[0], out[2], sizeof out[0]);
      for (int k = 0; k < dim * dim; k++) CHECK_SAME(run.F[k], block.F[k], sizeof run.F[k]);
    }
    for (size_t row = 0; row < sizeof run / sizeof(PetscReal[MPM_BLOCK]); row++)
      for (PetscInt p = 0; p < MPM_BLOCK; p++) {
        const PetscReal *expected = (PetscReal *)(p >= first && p < last ? &alone : &block) + row * MPM_BLOCK + p;
        CHECK_SAME((PetscReal *)&run + row * MPM_BLOCK + p, expected, sizeof(PetscReal));
      }
    for (int k = 0; k < 2; k++)
      for (PetscInt p = 0; p < MPM_BLOCK; p++) CHECK_EQ(out[2][k][p], p >= first && p < last ? out[0][k][p] : -12345);
  }
}

/* Largest real part of the eigenvalues of Q [dim*dim], which need not be symmetric: from its characteristic polynomial.
 */
static PetscReal LargestEigenvalue(int dim, const PetscReal *Q)
{
  if (dim == 1) return Q[0];
  if (dim == 2) {
    const PetscReal t = 0.5 * (Q[0] + Q[3]), D = 0.25 * (Q[0] - Q[3]) * (Q[0] - Q[3]) + Q[1] * Q[2];
    return t + (D > 0 ? sqrt(D) : 0);
  }
  { /* x^3 - a x^2 + b x - c, with x = y + a/3: y^3 + p y + q */
    const long double a = (long double)Q[0] + Q[4] + Q[8];
    const long double b = (long double)Q[0] * Q[4] - (long double)Q[1] * Q[3] + (long double)Q[0] * Q[8] -
                          (long double)Q[2] * Q[6] + (long double)Q[4] * Q[8] - (long double)Q[5] * Q[7];
    const long double c = MPMDet(3, Q), p = b - a * a / 3, q = -2 * a * a * a / 27 + a * b / 3 - c,
                      D = q * q / 4 + p * p * p / 27;
    long double y;

    if (D <= 0)
      y = p < 0 ? 2 * sqrtl(-p / 3) * cosl(acosl(fminl(1, fmaxl(-1, 3 * q / (2 * p) * sqrtl(-3 / p)))) / 3) : 0;
    else {
      y = cbrtl(-q / 2 + sqrtl(D)) + cbrtl(-q / 2 - sqrtl(D)); /* one real root; the pair has real part -y/2 */
      y = fmaxl(y, -y / 2);
    }
    return (PetscReal)(a / 3 + y);
  }
}

/* Speed of plane waves along n in the deformed state. A velocity field a e^{ik n.x} changes F by s a (x) n F, hence
   P = tau F^-T by dP; the wave sees Q a = (dP/ds) F^T n = (d tau/ds) n - tau n (a.n), and rho0 c^2 is an eigenvalue of
   Q. speed2 must not be below any. With a hyperelastic law a.Q a is d^2W/ds^2, which is checked on the way. */
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
      CHECK_NEAR((16 * (W[1] + W[2]) - (W[0] + W[3]) - 30 * W[4]) / (12 * h * h) / (scale * norm),
                 Q[a * dim + a] / (scale * norm), 1e-7);
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
    if (stretches[k] < least || (least > 0.2 && stretches[k] > 1 / least)) continue;
    UnitContext("%s, nu = %g, dim %d, waves, all axes stretched by %g", name, m->nu, dim, stretches[k]);
    Identity(dim, F);
    for (int d = 0; d < dim; d++) F[d * (dim + 1)] = stretches[k];
    if (MPMDet(dim, F) >= least) AllWaves(m, dim, F);
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

/* size: of F - I. */
/* The part of the stress that a velocity gradient a n (x) n makes at once is along n at most what the diffusivity says,
   by which the time step is bounded. The step is so short that the elastic part is small. */
static void Rates(const MPMMaterial *m, int dim, const PetscReal *F)
{
  const PetscReal  a = 1e6, dt = 1e-15, J = MPMDet(dim, F), modulus = m->K + m->lambda + 2 * m->mu + m->shear;
  MPMParticleState s[2];
  PetscReal        n[3] = {0}, L[9], size = 0, jump = 0;

  if (!m->type->law->update[dim - 1]) return;
  for (int d = 0; d < dim; d++) {
    n[d] = UnitReal(-1, 1);
    size += n[d] * n[d];
  }
  for (int k = 0; k < 2; k++) {
    State(m, dim, F, &s[k]);
    for (int d = 0; d < dim * dim; d++) L[d] = (k ? -a : a) * n[d / dim] * n[d % dim] / size;
    Step(m, dim, dt, L, &s[k]);
  }
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      const int at = MPMSymIndex(d, e);

      jump += 0.5 * (s[0].tau[at] - s[1].tau[at]) * n[d] * n[e] / size;
    }
  CHECK_LE(jump, (1 + 1e-9) * J * m->rho * m->diffusivity * a + 100 * modulus * (dt * a + DBL_EPSILON));
}

/* Bodies of revolution: the stretch around the axis is that along z of the same state in 3-D, for a step with rates in
   both, at each number of lanes. */
static void Revolution(const MPMMaterial *plane, const PetscReal *F)
{
  const PetscReal around = UnitReal(0.8, 1.25), dt = 0.05, rate = UnitReal(-1, 1);
  const PetscReal F3[9]         = {F[0], F[1], 0, F[2], F[3], 0, 0, 0, around},
                  L[4]          = {UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1), UnitReal(-1, 1)};
  const PetscReal       L3[9]   = {L[0], L[1], 0, L[2], L[3], 0, 0, 0, rate};
  const MPMMaterialLaw *laws[4] = {plane->type->law};
  MPMMaterial           m       = *plane;
  MPMParticleState      s, begin;
  PetscReal             W[2][MPM_BLOCK], c2[2][MPM_BLOCK];

  m.round = PETSC_TRUE;
  if (m.state & MPM_BIT(F)) m.state |= MPM_BIT(F33);
  CHECK_EQ(MPMLawForm(plane, 2), 1);
  CHECK_EQ(MPMLawForm(&m, 2), 3);
  for (int k = 0; k < 3; k++) laws[k + 1] = plane->type->law->lanes[k];
  State(plane, 3, F3, &begin);
  s = begin;
  if (plane->type->law->update[2]) Step(plane, 3, dt, L3, &s);
  for (int k = 0; k < 4; k++) {
    const int    form = (int)MPMLawForm(&m, 2);
    MPMBlock     b, three;
    MPMComponent Lb[9];
    PetscReal    scale = PetscAbsReal(m.lambda) + m.mu + m.K;

    if (!laws[k] || (k && MPMKernelWidth() < 16 >> k)) continue;
    for (int p = 0; p < MPM_BLOCK; p++) {
      MPMParticleState own = begin;

      memcpy(own.F, F, sizeof(PetscReal) * 4);
      Put(&m, 2, &own, &b, p);
      Put(plane, 3, &s, &three, p);
      if (laws[0]->update[form]) MPMDeform(2, dt, L, own.F);
      for (int c = 0; c < 4; c++) Lb[c][p] = L[c], b.F[c][p] = m.state & MPM_BIT(F) ? own.F[c] : NAN;
      Lb[4][p] = rate;
      if (m.state & MPM_BIT(F)) b.F33[0][p] = laws[0]->update[form] ? around * (1 + dt * rate) : around;
    }
    if (laws[k]->update[form]) laws[k]->update[form](&m, dt, Lb, 3, 4, &b);
    if (!(m.state & MPM_BIT(tau))) laws[k]->stress[form](&m, 3, 4, &b);
    if (!(m.state & MPM_BIT(tau))) laws[0]->stress[2](plane, 3, 4, &three);
    for (int c = 0; c < 4; c++) scale = PetscMax(scale, PetscAbsReal(three.tau[MPMSymPlace(2, c)][3]));
    for (int c = 0; c < 4; c++) CHECK_NEAR(b.tau[c][3] / scale, three.tau[MPMSymPlace(2, c)][3] / scale, 1e-12);
    if (m.state & MPM_BIT(J)) CHECK_NEAR(b.J[0][3] / three.J[0][3], 1, 1e-12);
    if (m.state & MPM_BIT(ep)) CHECK_NEAR(b.ep[0][3], three.ep[0][3], 1e-11);
    if (m.state & MPM_BIT(theta)) CHECK_NEAR(b.theta[0][3], three.theta[0][3], 1e-11 * (1 + three.theta[0][3]));
    laws[k]->speed2[form](&m, 3, 4, &b, c2[0]);
    laws[0]->speed2[2](plane, 3, 4, &three, c2[1]);
    CHECK_NEAR(c2[0][3] / c2[1][3], 1, 1e-11);
    if (k) continue;
    laws[0]->energy[form](&m, 3, 4, &b, W[0]);
    laws[0]->energy[2](plane, 3, 4, &three, W[1]);
    CHECK_NEAR(W[0][3] / scale, W[1][3] / scale, 1e-11);
  }
}

static void Law(const MPMMaterial *m, int dim, PetscReal size)
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
    RandomF(dim, round % 3 ? size : 0.01, F);
    if (traits & MPM_HYPERELASTIC) Hyperelastic(m, dim, F);
    if (traits & MPM_SMALL_STRAIN) SmallStrain(m, dim, F);
    if (traits & MPM_OBJECTIVE) Objective(m, dim, F);
    Rates(m, dim, F);
    if (traits & (MPM_HYPERELASTIC | MPM_SMALL_STRAIN)) Hooke(m, dim);
    Dimensions(m, dim, F);
    if (dim == 2) Revolution(m, F);
    /* With nu < 0 a finite compression may have W < 0 by the law itself: the term of lambda is negative. */
    if (m->nu >= 0 || round % 3 == 0) CHECK_GE(Energy(m, dim, F) / (PetscAbsReal(m->lambda) + m->mu), -8 * DBL_EPSILON);
  }
  Bound(m, dim, size);
}

/* ---- Plastic laws */

/* Once: it turns angles into slopes. */
static void SetUp(MPMMaterial *m)
{
  const char *wrong = MPMMaterialSetUp(m);

  CHECK(wrong == NULL);
}

static PetscReal Trace(const PetscReal a[6])
{
  return a[0] + a[3] + a[5];
}

/* a:b */
static PetscReal Dot(const PetscReal a[6], const PetscReal b[6])
{
  return a[0] * b[0] + a[3] * b[3] + a[5] * b[5] + 2 * (a[1] * b[1] + a[2] * b[2] + a[4] * b[4]);
}

/* |dev a| */
static PetscReal Deviator(const PetscReal a[6])
{
  PetscReal dev[6];

  for (int k = 0; k < 6; k++) dev[k] = a[k] - (MPMSymUnit(3, k) ? Trace(a) / 3 : 0);
  return sqrt(Dot(dev, dev));
}

/* e = ln(be)/2 as a tensor. */
static void LogStrain(const PetscReal be[6], PetscReal e[6])
{
  PetscReal b[3], n[3][3];

  MPMEigen(3, be, b, n);
  for (int k = 0; k < 3; k++) b[k] = 0.5 * log(b[k]);
  MPMSpectral(3, b, n, e);
}

/* How far beyond the yield surface, in Pa. */
static PetscReal Surface(const MPMMaterial *m, const MPMParticleState *s)
{
  if (!strcmp(m->name, "vonmises")) return sqrt(1.5) * Deviator(s->tau) - (m->yield + m->hardening * s->ep);
  return Deviator(s->tau) + m->friction * (Trace(s->tau) - m->cohesion);
}

/* Random L with some volume and some turning. */
static void RandomL(int dim, PetscReal size, PetscReal *L)
{
  for (int k = 0; k < dim * dim; k++) L[k] = UnitReal(-size, size);
}

/* After each step of a random path: within the surface; tau the Hencky stress of be; energy lost, not made; the same
   path turned by Q gives the turned state, and the same in more dimensions. Returns the number of steps that flowed. */
static PetscInt PlasticPath(const MPMMaterial *m, int dim)
{
  const PetscReal  E = m->E, K3 = 3 * m->lambda + 2 * m->mu, size = UnitBits() % 2 ? 0.05 : 0.005;
  MPMParticleState s, turned, higher[4];
  PetscReal        Q[9], QT[9];
  PetscInt         flowed = 0;

  Start(dim, &s);
  Rotation(dim, UnitReal(-4, 4), Q);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) QT[d * dim + e] = Q[e * dim + d];
  turned = s;
  for (int to = dim + 1; to <= 3; to++) Start(to, higher + to);
  for (int step = 0; step < 60; step++) {
    const MPMParticleState old = s;
    PetscReal              L[9], QL[9], G[9], f[9] = {0}, fb[9], fbf[9], fT[9], B[9], trial[6], e[6], dep[6], scale, D;

    RandomL(dim, size, L);
    if (step == 0) /* sand flows under pressure */
      for (int d = 0; d < dim; d++) L[d * (dim + 1)] -= 0.05;
    Step(m, dim, 1, L, &s);
    scale = E + m->lambda + Deviator(s.tau) + fabs(Trace(s.tau));
    CHECK_LE(Surface(m, &s) / scale, 1e-13);
    /* tau and be: the same axes, the energy of tau, the volume of its trace */
    CHECK_NEAR(StateEnergy(m, dim, &s) / scale,
               (pow(Deviator(s.tau), 2) / (4 * m->mu) + pow(Trace(s.tau), 2) / (6 * K3)) / scale, 1e-13);
    LogStrain(s.be, e);
    for (int k = 0; k < 6; k++)
      CHECK_NEAR(s.tau[k] / scale, (2 * m->mu * e[k] + (MPMSymUnit(3, k) ? m->lambda * Trace(e) : 0)) / scale, 1e-13);
    /* trial, by plain products in 3-D */
    Embed(dim, L, 3, f);
    for (int d = 0; d < 3; d++) f[4 * d] = 1 + (d < dim ? L[d * (dim + 1)] : 0);
    for (int d = 0; d < 3; d++)
      for (int c = 0; c < 3; c++) {
        fT[3 * d + c] = f[3 * c + d];
        B[3 * d + c]  = old.be[MPMSymIndex(d, c)];
      }
    Multiply(3, f, B, fb);
    Multiply(3, fb, fT, fbf);
    for (int d = 0; d < 3; d++)
      for (int c = d; c < 3; c++) trial[MPMSymIndex(d, c)] = fbf[3 * d + c];
    LogStrain(trial, dep);
    for (int k = 0; k < 6; k++) dep[k] -= e[k]; /* what has flowed */
    flowed += sqrt(Dot(dep, dep)) > 1e-10;
    /* Dissipation. A gap of cohesive soil opens and closes at the apex, so its work T0/3 is lent. */
    D = Dot(s.tau, dep) - (!strcmp(m->name, "druckerprager") ? m->cohesion / 3 * (s.vc - old.vc) : 0);
    CHECK_GE(D / scale, -1e-14);
    CHECK_GE(s.ep, old.ep);
    CHECK_GE(s.vc, 0);
    if (!strcmp(m->name, "vonmises")) { /* flow keeps the volume; ep is its length */
      CHECK_NEAR(Trace(dep), 0, 1e-14);
      CHECK_NEAR(s.ep - old.ep, sqrt(2. / 3) * Deviator(dep), 1e-14);
    } else { /* volume is opened or closed, or made by dilation */
      const PetscReal flow = Trace(dep) - (s.vc - old.vc);
      const int       apex = s.vc > 0;
      if (apex)
        CHECK_NEAR(flow, 0, 1e-13);
      else if (Deviator(dep) > 1e-8)
        CHECK_NEAR(flow / Deviator(dep), 3 * m->dilation, 1e-5);
      if (apex) CHECK_LE(Deviator(s.tau) / E, 1e-14);
      if (apex) CHECK_NEAR(Trace(s.tau) / E, m->cohesion / E, 1e-13);
    }
    Multiply(dim, Q, L, QL);
    Multiply(dim, QL, QT, G);
    Step(m, dim, 1, G, &turned);
    Turn(dim, Q, s.be, B);
    for (int k = 0; k < 6; k++) CHECK_NEAR(turned.be[k], B[k], 1e-12);
    Turn(dim, Q, s.tau, B);
    for (int k = 0; k < 6; k++) CHECK_NEAR(turned.tau[k] / scale, B[k] / scale, 1e-12);
    CHECK_NEAR(turned.ep, s.ep, 1e-12);
    CHECK_NEAR(turned.vc, s.vc, 1e-12);
    for (int to = dim + 1; to <= 3; to++) {
      Embed(dim, L, to, G);
      for (int d = 0; d < to; d++) G[d * (to + 1)] = d < dim ? L[d * (dim + 1)] : 0;
      Step(m, to, 1, G, higher + to);
      for (int k = 0; k < 6; k++) {
        CHECK_NEAR(higher[to].be[k], s.be[k], 1e-12);
        CHECK_NEAR(higher[to].tau[k] / scale, s.tau[k] / scale, 1e-12);
      }
      CHECK_NEAR(higher[to].ep, s.ep, 1e-12);
      CHECK_NEAR(higher[to].vc, s.vc, 1e-12);
    }
  }
  return flowed;
}

/* One axis stretched to exp(e) in steps: e is elastic up to yield/(2 mu), and then ep = (2 mu e - yield)/(3 mu + H),
   with any steps, since the deviator keeps its direction.                                                            */
static void Uniaxial(const MPMMaterial *m, int dim, PetscReal sign)
{
  const PetscReal  K = m->lambda + 2 * m->mu / 3, limit = m->yield / (2 * m->mu);
  MPMParticleState s;
  PetscReal        L[9] = {0};
  const int        axis = UnitInt(dim), zz = MPMSymIndex(axis, axis);

  Start(dim, &s);
  for (int step = 0; step < 40; step++) {
    PetscReal e, ep, q;

    L[axis * (dim + 1)] = sign * limit / 10;
    Step(m, dim, 1, L, &s);
    e  = log(s.F[axis * (dim + 1)]);
    ep = PetscMax(0, (2 * m->mu * fabs(e) - m->yield) / (3 * m->mu + m->hardening));
    q  = 2 * m->mu * fabs(e) - 3 * m->mu * ep;
    CHECK_NEAR(s.ep, ep, 1e-13);
    CHECK_NEAR(s.tau[zz] / K, e + sign * 2. / 3 * q / K, 1e-13);
    if (ep == 0)
      CHECK_NEAR(s.be[zz], s.F[axis * (dim + 1)] * s.F[axis * (dim + 1)], 1e-14);
    else
      CHECK_NEAR(q / m->E, (m->yield + m->hardening * s.ep) / m->E, 1e-13);
  }
  CHECK_GE(s.ep, limit);                 /* did flow */
  for (int step = 0; step < 5; step++) { /* unloads along the elastic slope, and keeps ep */
    const PetscReal tau = s.tau[zz], ep = s.ep, e = log(s.F[axis * (dim + 1)]);

    L[axis * (dim + 1)] = -sign * limit / 10;
    Step(m, dim, 1, L, &s);
    CHECK_EQ(s.ep, ep);
    CHECK_NEAR((s.tau[zz] - tau) / (log(s.F[axis * (dim + 1)]) - e) / (m->lambda + 2 * m->mu), 1, 1e-9);
  }
}

/* Simple shear: yields at sqrt(3) tau_xy = yield; then its slope is mu H/(3 mu + H) per shear strain. Small strains, so
   to their order.                                                                                                    */
static void Shear(const MPMMaterial *m, int dim)
{
  const PetscReal  limit = m->yield / (sqrt(3) * m->mu); /* in shear strain */
  MPMParticleState s;
  PetscReal        L[9] = {0}, at[2] = {0};

  L[1] = limit / 100;
  Start(dim, &s);
  for (int step = 1; step <= 300; step++) {
    Step(m, dim, 1, L, &s);
    if (step < 98) CHECK_EQ(s.ep, 0);
    if (step < 98) CHECK_NEAR(s.tau[1] / (m->mu * step * limit / 100), 1, 4 * limit);
    if (step == 103) CHECK_GE(s.ep, 0.01 * limit);
    if (step == 150) at[0] = s.tau[1];
    if (step == 300) at[1] = s.tau[1];
  }
  CHECK_NEAR((at[1] - at[0]) / (1.5 * limit) / m->mu, m->hardening / (3 * m->mu + m->hardening), 4 * limit);
}

static void VonMises(const MPMMaterialType *type)
{
  for (int i = 0; i < 24; i++) {
    MPMMaterial m;
    PetscInt    flowed;

    memset(&m, 0, sizeof m);
    strcpy(m.name, type->name);
    m.type      = type;
    m.rho       = 1100;
    m.E         = moduli[i % 2];
    m.nu        = poissons[i / 2 % 4];
    m.yield     = (i % 4 < 2 ? 0.002 : 0.02) * m.E;
    m.hardening = (i / 8 == 0 ? 0 : i / 8 == 1 ? 0.05 : 0.5) * m.E;
    SetUp(&m);
    for (int dim = 1; dim <= 3; dim++) {
      UnitContext("%s, E = %g, nu = %g, yield = %g, hardening = %g, dim %d", m.name, m.E, m.nu, m.yield, m.hardening,
                  dim);
      flowed = 0;
      for (int round = 0; round < ROUNDS / 6; round++) flowed += PlasticPath(&m, dim);
      CHECK_GE(flowed, ROUNDS / 6);
      for (int sign = -1; sign <= 1; sign += 2) Uniaxial(&m, dim, sign);
      if (dim > 1) Shear(&m, dim);
      Block(&m, dim);
    }
  }
}

/* L that changes e by de along all axes that there are (in 1-D and 2-D not the whole trace). */
static void Swell(const MPMMaterial *m, int dim, PetscReal de, MPMParticleState *s)
{
  PetscReal L[9] = {0};

  for (int d = 0; d < dim; d++) L[d * (dim + 1)] = exp(de) - 1;
  Step(m, dim, 1, L, s);
}

/* Pulled apart sand stands at the apex and keeps in mind by how much; pushed together again it closes first, and there
   is pressure only when the volume is what it was.                                                                   */
static void Opening(const MPMMaterial *m, int dim)
{
  const PetscReal  apex = m->cohesion / (3 * m->lambda + 2 * m->mu), pull = apex + 0.02;
  MPMParticleState s;

  Start(dim, &s);
  for (int step = 0; step < 20; step++) Swell(m, dim, pull / 10, &s);
  CHECK_NEAR(Trace(s.tau) / m->E, m->cohesion / m->E, 1e-13);
  CHECK_LE(Deviator(s.tau) / m->E, 1e-14);
  if (m->dilation == 0 || dim == 3) CHECK_NEAR(s.vc, 2 * dim * pull - apex, 1e-12); /* else flow makes volume too */
  if (m->cohesion == 0)
    for (int k = 0; k < 6; k++) {
      CHECK_EQ(s.tau[k], 0);
      CHECK_EQ(s.be[k], MPMSymUnit(3, k));
    }
  for (int step = 0; step < 19; step++) Swell(m, dim, -pull / 10, &s);
  if (m->dilation == 0 || dim == 3)
    CHECK_NEAR(s.vc, PetscMax(0, dim * pull / 10 - apex), 1e-12); /* still open, unless cohesion holds that volume */
  if (m->cohesion == 0) CHECK_EQ(Trace(s.tau), 0);
  for (int step = 0; step < 2; step++) Swell(m, dim, -pull / 10, &s);
  CHECK_EQ(s.vc, 0);
  { /* with no dilation, the whole volume is elastic again */
    PetscReal e[6];
    LogStrain(s.be, e);
    if (m->dilation == 0) CHECK_NEAR(Trace(e), log(MPMDet(dim, s.F)), 1e-13);
    CHECK_LE(Trace(s.tau), 0);
  }
}

/* Compressed and then sheared without change of volume: below the cone it is elastic, on it |dev tau| = alpha (T0 - tr
   tau). Without dilation the pressure stays; with it the pressure rises.                                             */
static void Cone(const MPMMaterial *m, int dim)
{
  MPMParticleState s;
  PetscReal        L[9] = {0}, tr;

  Start(dim, &s);
  for (int d = 0; d < dim; d++) L[d * (dim + 1)] = -0.01;
  Step(m, dim, 1, L, &s);
  if (dim == 1) return; /* uniaxial strain is the whole path there */
  tr = Trace(s.tau);
  CHECK_LE(tr, -0.01 * m->E);
  memset(L, 0, sizeof L);
  L[1] = 0.002;
  for (int step = 0; step < 100; step++) Step(m, dim, 1, L, &s);
  CHECK_NEAR(Deviator(s.tau) / m->E, m->friction * (m->cohesion - Trace(s.tau)) / m->E, 1e-13);
  if (m->dilation == 0)
    CHECK_NEAR(Trace(s.tau) / tr, 1, 1e-12);
  else
    CHECK_LE(Trace(s.tau) / tr * -1, -1.05);
}

/* In triaxial compression Mohr and Coulomb's law: (s1 - s3)/2 = c cos(phi) - (s1 + s3)/2 sin(phi), pressure negative.
 */
static void Triaxial(const MPMMaterial *m, PetscReal phi, PetscReal cohesion)
{
  MPMParticleState s;
  PetscReal        L[9]  = {0};
  const PetscReal  angle = phi * PETSC_PI / 180;

  Start(3, &s);
  L[0] = -0.003;
  L[4] = L[8] = -0.001;
  for (int step = 0; step < 10; step++) Step(m, 3, 1, L, &s);
  L[4] = L[8] = 0.0014; /* until it flows */
  for (int step = 0; step < 100 && Surface(m, &s) < -1e-12 * m->E; step++) Step(m, 3, 1, L, &s);
  CHECK_GE(Surface(m, &s) / m->E, -1e-12);
  CHECK_EQ(s.vc, 0);
  CHECK_NEAR((s.tau[3] - s.tau[0]) / 2 / m->E, (cohesion * cos(angle) - (s.tau[0] + s.tau[3]) / 2 * sin(angle)) / m->E,
             1e-12);
}

/* In plane strain, flow that has become steady is Mohr and Coulomb's with the angle acts[1], and the pressure stays where
   the path dilates by the angle of the flow. The strain across is elastic and stays. */
static void PlaneStrain(const MPMMaterial *m, int dim, PetscReal psi)
{
  MPMParticleState s;
  PetscReal        L[9] = {0}, apex = m->cohesion / 3, mean[2] = {0};
  const int        y = dim + 1;

  Start(dim, &s);
  for (int d = 0; d < dim; d++) L[d * (dim + 1)] = -0.001;
  for (int step = 0; step < 3; step++) Step(m, dim, 1, L, &s);
  if (dim == 3) L[8] = 0;
  L[0] = exp(-5e-4 * (1 - sin(psi))) - 1;
  L[y] = exp(5e-4 * (1 + sin(psi))) - 1;
  for (int step = 0; step < 500; step++) {
    Step(m, dim, 1, L, &s);
    if (step == 400) mean[0] = (s.tau[0] + s.tau[3]) / 2;
  }
  mean[1] = (s.tau[0] + s.tau[3]) / 2;
  CHECK_LE(mean[1] / m->E, -1e-4);
  CHECK_NEAR((s.tau[3] - s.tau[0]) / 2 / (apex - mean[1]), sin(m->acts[1] * PETSC_PI / 180), 1e-10);
  CHECK_NEAR(mean[1] / mean[0], 1, 1e-10);
}

static void DruckerPrager(const MPMMaterialType *type)
{
  static const PetscReal phis[] = {30, 20, 45, 0};

  for (int i = 0; i < 48; i++) {
    const PetscReal phi = phis[i / 2 % 4], psi = i / 8 % 2 && phi > 0 ? 10 : 0;
    MPMMaterial     m;
    PetscReal       cohesion, sine;
    PetscInt        flowed;

    memset(&m, 0, sizeof m);
    strcpy(m.name, type->name);
    m.type     = type;
    m.rho      = 1100;
    m.E        = moduli[i % 2];
    m.nu       = i % 3 ? 0.3 : 0.2;
    m.friction = phi;
    m.dilation = psi;
    m.cohesion = cohesion = phi > 0 && (i / 16 == 1 || i > 43) ? 1e-3 * m.E : 0;
    m.plane               = i / 32 ? PETSC_TRUE : PETSC_FALSE;
    SetUp(&m);
    if (!m.plane) {
      CHECK_NEAR(m.friction, sqrt(2. / 3) * 2 * sin(phi * PETSC_PI / 180) / (3 - sin(phi * PETSC_PI / 180)), 1e-15);
      CHECK_NEAR(m.dilation, sqrt(2. / 3) * 2 * sin(psi * PETSC_PI / 180) / (3 - sin(psi * PETSC_PI / 180)), 1e-15);
    }
    CHECK_NEAR(m.acts[m.plane ? 1 : 0], phi, 1e-12); /* what was asked for */
    CHECK_GE(m.acts[1] - m.acts[0], phi > 0 ? 1 : 0);
    sine = 3 * m.dilation / sqrt(2 - 3 * m.dilation * m.dilation); /* of the dilation angle in plane strain */
    if (m.plane) CHECK_NEAR(sine, sin(psi * PETSC_PI / 180), 1e-15);
    for (int dim = 1; dim <= 3; dim++) {
      UnitContext("%s, E = %g, phi = %g, psi = %g, cohesion = %g, fit %d, dim %d", m.name, m.E, phi, psi, cohesion,
                  m.plane, dim);
      flowed = 0;
      for (int round = 0; round < ROUNDS / (m.plane ? 12 : 6); round++) flowed += PlasticPath(&m, dim);
      CHECK_GE(flowed, ROUNDS / (m.plane ? 12 : 6));
      Opening(&m, dim);
      if (phi > 0) Cone(&m, dim);
      if (phi > 0 && dim == 3 && psi == 0)
        Triaxial(&m, m.acts[0], cohesion * tan(m.acts[0] * PETSC_PI / 180) / tan(phi * PETSC_PI / 180));
      if (phi > 0 && dim > 1 && m.acts[1] < 90) PlaneStrain(&m, dim, asin(sine));
      Block(&m, dim);
    }
  }
  { /* what makes no sense is refused */
    MPMMaterial m;
    const char *wrong;

    for (int i = 0; i < 3; i++) {
      memset(&m, 0, sizeof m);
      m.type     = type;
      m.E        = 1;
      m.friction = i == 1 ? 0 : 30;
      m.dilation = i == 0 ? 31 : 0;
      m.cohesion = i == 1 ? 1 : 0;
      wrong      = MPMMaterialSetUp(&m); /* once: it turns angles into slopes */
      CHECK((wrong == NULL) == (i == 2));
    }
  }
}

/* ---- Metal under impact */

/* The constants of johnsoncook besides A and B: elastic as E and nu say. */
static void Shock(MPMMaterial *m)
{
  const PetscReal K = m->E / (3 * (1 - 2 * m->nu));

  m->c0        = sqrt(K / m->rho);
  m->shear     = m->E / (2 * (1 + m->nu));
  m->slope     = 1.2;
  m->gruneisen = 1.9;
  m->heat      = 2e-5 * K / m->rho; /* of strength near 1e-3 K, so some hundred K by strains near 1 */
  m->share     = 0.9;
  m->power = m->softening = m->rate0 = 1;
  m->temperature                     = 300;
  m->melting = m->tension = -1;
}

/* p and energy at J and theta by Runge and Kutta's steps along the isentrope, with libm. */
static PetscReal ShockPressure(const MPMMaterial *m, PetscReal J, PetscReal theta, PetscReal *E)
{
  const PetscReal K = m->rho * m->c0 * m->c0, g = m->gruneisen, h = (1 - J) / 100;
  const PetscReal hot = m->rho * m->heat * theta * exp(g * (1 - J));
  PetscReal       e = 0, p = 0;

  for (int step = 0; step <= 100; step++) {
    PetscReal k[4];

    for (int i = 0; i < 4; i++) {
      const PetscReal y = h * (step + (i + 1) / 2 * 0.5), at = e + (i ? h * k[i - 1] * (i < 3 ? 0.5 : 1) : 0);

      k[i] = K * y / ((1 - m->slope * y) * (1 - m->slope * y)) * (1 - g * y / 2) + g * at;
    }
    p = k[0];
    if (step < 100) e += h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3]);
  }
  *E = e + hot;
  return p + g * hot;
}

/* The yield stress by libm. */
static PetscReal Yield(const MPMMaterial *m, PetscReal ep, PetscReal rate, PetscReal T)
{
  const PetscReal hot = m->melting < 0 ? 0
                                       : PetscMin(1, PetscMax(0, (T - m->temperature) / (m->melting - m->temperature)));

  return (m->yield + m->hardening * pow(ep, m->power)) * (1 + m->rate * log(PetscMax(1, rate / m->rate0))) *
         (1 - pow(hot, m->softening));
}

/* After each step of a random path: within the yield surface of its rate and heat, on it where it flowed; pressure and
   energy those of J and theta; flow turns `share` of its work into heat, and nothing else does; the same path turned, or
   in more dimensions, gives the same state. Returns the number of steps that flowed. */
static PetscInt HotPath(const MPMMaterial *m, int dim)
{
  const PetscReal  size = UnitBits() % 2 ? 0.05 : 0.005, dt = UnitBits() % 2 ? 1e-6 : 1e3;
  MPMParticleState s, turned, higher[4];
  PetscReal        Q[9], QT[9], J = 1, heat = m->rho * m->heat;
  PetscInt         flowed = 0;

  Start(dim, &s);
  Rotation(dim, UnitReal(-4, 4), Q);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) QT[d * dim + e] = Q[e * dim + d];
  turned = s;
  for (int to = dim + 1; to <= 3; to++) Start(to, higher + to);
  for (int step = 0; step < 40; step++) {
    const MPMParticleState old = s;
    MPMParticleState       trial;
    PetscReal              L[9], QL[9], G[9], f[9], B[6], p, q, x, Y, E, grows, scale, work;

    RandomL(dim, size / dt, L);
    for (int k = 0; k < dim * dim; k++) f[k] = (k % (dim + 1) == 0) + dt * L[k];
    if (J * MPMDet(dim, f) < 0.75 || J * MPMDet(dim, f) > 1.3) continue;
    J *= MPMDet(dim, f);
    Step(m, dim, dt, L, &s);
    grows = exp(m->gruneisen * (1 - J));
    x     = s.ep - old.ep;
    p     = ShockPressure(m, J, s.theta, &E);
    if (m->tension >= 0) p = PetscMax(p, -m->tension);
    q     = sqrt(1.5) * Deviator(s.tau);
    Y     = Yield(m, s.ep, x / dt, (m->temperature + old.theta) * grows);
    scale = m->E + m->lambda + fabs(Trace(s.tau));
    CHECK_GE(x, 0);
    CHECK_LE((q - Y) / scale, 1e-13);
    CHECK_NEAR(-Trace(s.tau) / 3 / J / scale, p / scale, 1e-7);
    CHECK_NEAR((s.theta - old.theta) * heat * grows / scale, m->share * q * x / scale, 1e-15);
    if (x > 0) CHECK_NEAR(q / scale, Y / scale, 1e-13);
    if (x > 0) flowed++;
    trial       = s; /* as the step would have left it without flow */
    trial.theta = old.theta;
    work        = q + 1.5 * m->mu * x; /* its mean stress */
    if (x > 0) {                       /* lengthen the deviator to what it was */
      PetscReal b[3], n[3][3], mean;

      MPMEigen(3, s.be, b, n);
      for (int k = 0; k < 3; k++) b[k] = 0.5 * log(b[k]);
      mean = (b[0] + b[1] + b[2]) / 3;
      if (q > 0)
        for (int k = 0; k < 3; k++) b[k] = exp(2 * (mean + (b[k] - mean) * (q + 3 * m->mu * x) / q));
      if (q > 0) MPMSpectral(3, b, n, trial.be);
    }
    if (q > 1e-3 * m->yield && m->tension < 0) {
      const PetscReal lost = StateEnergy(m, dim, &trial) - StateEnergy(m, dim, &s);

      CHECK_NEAR(lost / scale, (work - m->share * q) * x / scale, 1e-13);
      CHECK_NEAR(StateEnergy(m, dim, &s) / scale, (E + q * q / (6 * m->mu)) / scale, 1e-8);
    }
    Multiply(dim, Q, L, QL);
    Multiply(dim, QL, QT, G);
    Step(m, dim, dt, G, &turned);
    Turn(dim, Q, s.tau, B);
    for (int k = 0; k < 6; k++) CHECK_NEAR(turned.tau[k] / scale, B[k] / scale, 1e-11);
    CHECK_NEAR(turned.ep, s.ep, 1e-11);
    CHECK_NEAR(turned.theta, s.theta, 1e-9 * (1 + s.theta));
    for (int to = dim + 1; to <= 3; to++) {
      Embed(dim, L, to, G);
      for (int d = dim; d < to; d++) G[d * (to + 1)] = 0;
      Step(m, to, dt, G, higher + to);
      for (int k = 0; k < 6; k++) CHECK_NEAR(higher[to].tau[k] / scale, s.tau[k] / scale, 1e-11);
      CHECK_NEAR(higher[to].ep, s.ep, 1e-11);
      CHECK_NEAR(higher[to].theta, s.theta, 1e-9 * (1 + s.theta));
    }
  }
  return flowed;
}

static void JohnsonCook(const MPMMaterialType *type)
{
  MPMMaterial m;

  for (int i = 0; i < 16; i++) {
    memset(&m, 0, sizeof m);
    strcpy(m.name, type->name);
    m.type = type;
    m.rho  = 1100;
    m.E    = moduli[i % 2];
    m.nu   = i % 4 < 2 ? 0.3 : 0.45;
    Shock(&m);
    m.yield     = 2e-3 * m.E;
    m.hardening = i % 3 ? 3e-3 * m.E : 0;
    m.power     = i % 3 == 2 ? 0.31 : 1;
    m.rate      = i / 4 % 2 ? 0.03 : 0;
    if (i / 8) m.melting = 900;
    m.softening = 1.09;
    if (i % 8 == 7) m.tension = 0.03 * m.E;
    SetUp(&m);
    for (int dim = 1; dim <= 3; dim++) {
      PetscInt flowed = 0;

      UnitContext("%s %d, E = %g, nu = %g, dim %d", m.name, i, m.E, m.nu, dim);
      for (int round = 0; round < ROUNDS / 50; round++) flowed += HotPath(&m, dim);
      CHECK_GE(flowed, ROUNDS / 6);
      Block(&m, dim);
    }
  }
  m.type    = type;
  m.melting = m.temperature;
  CHECK(MPMMaterialSetUp(&m) != NULL);
}

/* ---- Fluids */

/* The stress of a moving viscous fluid less that of the fluid at rest, over J, is 2 viscosity dev(D). */
static void Viscous(const MPMMaterial *m, int dim)
{
  const PetscReal  dt = 1e-3, scale = m->viscosity + m->K * 1e-3;
  MPMMaterial      inviscid = *m;
  MPMParticleState s, still;
  PetscReal        L[9], tr = 0, sig[6], rate[6] = {0}, power;

  inviscid.viscosity = 0;
  inviscid.state     = MPM_BIT(J);
  RandomL(dim, 1, L);
  Start(dim, &s);
  s.J   = UnitReal(0.7, 1.3);
  still = s;
  for (int d = 0; d < dim; d++) tr += L[d * (dim + 1)];
  Step(m, dim, dt, L, &s);
  CHECK_NEAR(s.J / still.J, 1 + dt * tr, 4e-16);
  still.J = s.J;
  {
    MPMBlock b;
    Put(&inviscid, dim, &still, &b, 0);
    m->type->law->stress[dim - 1](&inviscid, 0, 1, &b);
    for (int k = 0; k < MPM_SYM_NC(dim); k++) still.tau[MPMSymPlace(dim, k)] = b.tau[k][0];
  }
  for (int k = 0; k < 6; k++) sig[k] = m->viscosity > 0 ? (s.tau[k] - still.tau[k]) / s.J : 0;
  for (int d = 0; d < dim; d++)
    for (int e = d; e < dim; e++) rate[MPMSymIndex(d, e)] = 0.5 * (L[d * dim + e] + L[e * dim + d]);
  for (int k = 0; k < 6; k++)
    CHECK_NEAR(sig[k] / scale, 2 * m->viscosity * (rate[k] - (MPMSymUnit(3, k) ? tr / 3 : 0)) / scale, 1e-12);
  power = Dot(sig, rate);
  CHECK_GE(power / scale, m->viscosity > 0 ? 1e-9 * Dot(rate, rate) : 0);
  { /* no tension but what is allowed */
    if (m->tension >= 0) CHECK_LE(Trace(still.tau) / 3 / s.J / m->K, m->tension / m->K + 1e-15);
  }
  for (int to = dim + 1; to <= 3; to++) {
    MPMParticleState higher;
    PetscReal        G[9];

    Embed(dim, L, to, G);
    for (int d = dim; d < to; d++) G[d * (to + 1)] = 0;
    Start(to, &higher);
    higher.J = s.J / (1 + dt * tr);
    Step(m, to, dt, G, &higher);
    CHECK_NEAR(higher.J, s.J, 1e-15);
    for (int k = 0; k < 6 && m->viscosity > 0; k++) CHECK_NEAR(higher.tau[k] / scale, s.tau[k] / scale, 1e-12);
  }
  if (dim > 1 && m->viscosity > 0) { /* Newton: simple shear */
    memset(L, 0, sizeof L);
    L[1] = 3;
    Start(dim, &s);
    Step(m, dim, dt, L, &s);
    CHECK_EQ(s.J, 1);
    CHECK_NEAR(s.tau[1] / m->viscosity, 3, 1e-15);
    for (int k = 0; k < 6; k++)
      if (k != 1) CHECK_EQ(s.tau[k], 0);
  }
}

/* p = -dW/dJ, cut-off included; p and c2 by their formulas with libm. */
static void Pressure(const MPMMaterial *m)
{
  for (int round = 0; round < ROUNDS; round++) {
    const PetscReal J = UnitReal(0.6, 1.6), h = 1e-4, g = m->gamma;
    PetscReal       F[9] = {0}, tau[6], p, exact, W[2], kink;

    F[0] = J;
    Stress(m, 1, F, tau);
    p     = -tau[0] / J;
    exact = g > 0 ? m->K / g * (pow(J, -g) - 1) : -m->K * (J - 1);
    kink  = fabs(exact + m->tension) / m->K;
    if (m->tension >= 0) exact = PetscMax(exact, -m->tension);
    CHECK_NEAR(p / m->K, exact / m->K, 1e-13);
    F[0] = J + h;
    W[1] = Energy(m, 1, F);
    F[0] = J - h;
    W[0] = Energy(m, 1, F);
    if (m->tension < 0 || kink > 20 * h) CHECK_NEAR(-(W[1] - W[0]) / (2 * h) / m->K, p / m->K, 1e-4);
    F[0] = J;
    CHECK_GE(Energy(m, 1, F) / m->K, -1e-15);
    if (m->tension < 0 || J <= 1) CHECK_NEAR(Speed2(m, 1, F) * m->rho / m->K, g > 0 ? pow(J, 1 - g) : J * J, 1e-12);
    CHECK_GE(Speed2(m, 1, F) * m->rho / m->K, (g > 0 ? pow(J, 1 - g) : J * J) * (1 - 1e-13));
  }
}

static void Fluid(const MPMMaterialType *type)
{
  static const PetscReal gammas[] = {7, 0, 1, 1.4}, tensions[] = {-1, 0, 0.05, 0.5}; /* of K */

  for (int i = 0; i < 32; i++) {
    MPMMaterial m;

    memset(&m, 0, sizeof m);
    strcpy(m.name, type->name);
    m.type      = type;
    m.rho       = 1000;
    m.K         = moduli[i % 2];
    m.viscosity = i / 16 ? 1e-3 * m.K : 0;
    m.gamma     = gammas[i / 2 % 4];
    m.tension   = i % 8 < 2 || m.viscosity > 0 ? tensions[i / 4 % 4] * m.K : tensions[i / 8 % 4] * m.K;
    SetUp(&m);
    CHECK_EQ(m.state, m.viscosity > 0 ? MPM_BIT(J) | MPM_BIT(tau) : MPM_BIT(J)); /* no viscosity: J alone */
    m.lambda = m.K; /* what it is as a solid, for the tests of solids */
    least    = 0.75;
    for (int dim = 1; dim <= 3; dim++) {
      UnitContext("%s, K = %g, gamma = %g, tension = %g, viscosity = %g, dim %d", m.name, m.K, m.gamma, m.tension,
                  m.viscosity, dim);
      for (int round = 0; round < ROUNDS; round++) Viscous(&m, dim);
      Block(&m, dim);
      if (dim == 1) Pressure(&m);
      if (m.tension < 0) Law(&m, dim, 0.2);
    }
    least = 0.2;
  }
}

/* ---- Solids of E and nu; plastic ones with a surface that is out of reach */
static void Solid(const MPMMaterialType *type)
{
  const PetscBool plastic = type->traits & MPM_PLASTIC ? PETSC_TRUE : PETSC_FALSE;

  for (size_t i = 0; i < sizeof poissons / sizeof poissons[0]; i++)
    for (size_t j = 0; j < sizeof moduli / sizeof moduli[0]; j++) {
      MPMMaterialType elastic = *type;
      MPMMaterial     m;

      memset(&m, 0, sizeof m);
      snprintf(m.name, sizeof m.name, "%s", type->name);
      if (plastic) elastic.traits |= MPM_HYPERELASTIC;
      m.type  = &elastic;
      m.rho   = 1100;
      m.E     = moduli[j];
      m.nu    = poissons[i];
      m.yield = m.cohesion = 1e6 * m.E;
      m.friction           = 30;
      Shock(&m);
      SetUp(&m);
      UnitContext("%s, E = %g, nu = %g", type->name, m.E, m.nu);
      CHECK_NEAR(m.mu * (3 * m.lambda + 2 * m.mu) / (m.lambda + m.mu) / m.E, 1, 1e-13); /* back to E and nu */
      CHECK_NEAR(m.lambda / (2 * (m.lambda + m.mu)), m.nu, 1e-13);
      if (plastic) least = 0.7;
      for (int dim = 1; dim <= 3; dim++) Law(&m, dim, plastic ? 0.2 : 0.5);
      least = 0.2;
    }
}

int main(void)
{
  for (const MPMMaterialType *type = MPMMaterialTypes; type->name; type++) {
    const MPMMaterialLaw *law = type->law;

    for (int d = 0; d < MPM_LAW_FORMS; d++) {
      UnitContext("%s, form %d", type->name, d + 1);
      CHECK((law->stress[d] || law->update[d]) && law->energy[d] && law->speed2[d]);
    }
    if (type->traits & MPM_FLUID)
      Fluid(type);
    else
      Solid(type);
    if (!strcmp(type->name, "vonmises")) VonMises(type);
    if (!strcmp(type->name, "druckerprager")) DruckerPrager(type);
    if (!strcmp(type->name, "johnsoncook")) JohnsonCook(type);
  }
  return UnitEnd();
}
