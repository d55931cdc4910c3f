/* static_tangent.c - what a particle adds to the tangent stiffness of a static step (static_tangent.h): stress and tangent of its law
   in the current axes, the means of F-bar, and the way back to the total frame. */
#include "kernels/transfer.h"
#include "step/static_tangent.h"

#define HOLDS 1e-3 /* of the elastic tangent: a particle that resists less is held by this */

/* Turns both pairs of indices of X [nc][nc]: X_amcn = sum_kl X_akcl q_mk q_nl, with q [nc]. */
static void Turn(PetscInt dim, PetscInt nc, const PetscReal q[], PetscReal X[])
{
  const PetscInt n = dim * dim;
  PetscReal      half[MPM_STATIC_NC * MPM_STATIC_NC];

  for (PetscInt k = 0; k < nc; k++) {
    for (PetscInt a = 0; a < n; a++) {
      half[a * nc + k] = 0;
      for (PetscInt e = 0; e < dim; e++) half[a * nc + k] += X[(a - a % dim + e) * nc + k] * q[a % dim * dim + e];
    }
    if (nc > n) half[n * nc + k] = X[n * nc + k] * q[n];
  }
  for (PetscInt k = 0; k < nc; k++) {
    for (PetscInt a = 0; a < n; a++) {
      X[k * nc + a] = 0;
      for (PetscInt e = 0; e < dim; e++) X[k * nc + a] += half[k * nc + a - a % dim + e] * q[a % dim * dim + e];
    }
    if (nc > n) X[k * nc + n] = half[k * nc + n] * q[n];
  }
}

/* Turns the second index of x [nc] likewise. */
static void TurnOne(PetscInt dim, PetscInt nc, const PetscReal q[], PetscReal x[])
{
  const PetscInt n = dim * dim;
  PetscReal      was[MPM_STATIC_NC];

  for (PetscInt k = 0; k < nc; k++) was[k] = x[k];
  for (PetscInt a = 0; a < n; a++) {
    x[a] = 0;
    for (PetscInt e = 0; e < dim; e++) x[a] += was[a - a % dim + e] * q[a % dim * dim + e];
  }
  if (nc > n) x[n] = was[n] * q[n];
}

/* Sets back [nc] to F^-1, and of a body of revolution 1/F33. */
static void Inverse(PetscInt dim, PetscInt nc, const PetscReal F[], PetscReal back[])
{
  const PetscReal J = MPMDet((int)dim, F);
  PetscReal       cofactor[9];

  MPMCofactor((int)dim, F, cofactor);
  for (PetscInt d = 0; d < dim; d++)
    for (PetscInt e = 0; e < dim; e++) back[d * dim + e] = cofactor[e * dim + d] / J;
  if (nc > dim * dim) back[dim * dim] = 1 / F[dim * dim];
}

/* Sets one [nc] to the unit tensor; returns the number of its axes. */
static PetscReal Unit(PetscInt dim, PetscInt nc, PetscReal one[])
{
  for (PetscInt k = 0; k < nc; k++) one[k] = k % (dim + 1) == 0 || k == dim * dim ? 1 : 0;
  return nc > dim * dim ? 3 : (PetscReal)dim;
}

/* Sets to [nc] to F of particle p, and of a body of revolution then F33. */
static void Deformation(PetscInt dim, const PetscReal *F, const PetscReal *F33, PetscInt p, PetscReal to[])
{
  for (PetscInt k = 0; k < dim * dim; k++) to[k] = F[p * dim * dim + k];
  if (F33) to[dim * dim] = F33[p];
}

/* Sets H [nc] to the displacement gradient of the step, in the state as it began, of particle p with the trial state F. */
static void StepGradient(PetscInt dim, PetscInt nc, const MPMView *view, const PetscReal *F, const PetscReal *F33,
                         PetscInt p, PetscReal H[])
{
  PetscReal was[MPM_STATIC_NC], now[MPM_STATIC_NC], back[MPM_STATIC_NC];

  Deformation(dim, view->F, nc > dim * dim ? view->F33 : NULL, p, was);
  Deformation(dim, F, F33, p, now);
  Inverse(dim, nc, was, back);
  for (PetscInt d = 0; d < dim; d++)
    for (PetscInt e = 0; e < dim; e++) {
      H[d * dim + e] = 0;
      for (PetscInt k = 0; k < dim; k++) H[d * dim + e] += (now[d * dim + k] - was[d * dim + k]) * back[k * dim + e];
    }
  if (nc > dim * dim) H[dim * dim] = (now[dim * dim] - was[dim * dim]) * back[dim * dim];
}

/* Gives a copy of a field of the particles' trial state, [n][nc]; NULL: there is none. */
static PetscErrorCode Take(MPMCore *core, PetscBool has, PetscInt field, PetscInt nc, PetscReal **to)
{
  const PetscInt n = core->particles.n * nc;
  void          *now;

  PetscFunctionBeginUser;
  *to = NULL;
  if (!has) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(PetscMax(1, n), to));
  PetscCall(MPMParticlesGetField(&core->particles, field, &now));
  PetscCall(PetscArraycpy(*to, (PetscReal *)now, n));
  PetscCall(MPMParticlesRestoreField(&core->particles, field));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define FIELDS                                                                                                         \
  (MPM_BIT(X) | MPM_BIT(l) | MPM_MATERIAL_BITS | MPM_BIT(kind) | MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(depth) |           \
   MPM_BIT(bar) | MPM_BIT(cell))

PetscErrorCode MPMStaticLeap(struct MPMStatic *s, PetscReal *most)
{
  MPMCore       *core = s->core;
  const PetscInt dim = core->grid.dim, nc = MPMTangentNumbers(dim, core->grid.round);
  PetscReal     *F, *F33;
  MPMView        view;

  PetscFunctionBeginUser;
  *most = 0;
  PetscCall(Take(core, PETSC_TRUE, MPM_FIELD_INDEX_F, dim * dim, &F));
  PetscCall(Take(core, core->grid.round, MPM_FIELD_INDEX_F33, 1, &F33));
  PetscCall(MPMParticlesPutBack(&core->particles));
  PetscCall(MPMParticlesGetView(&core->particles, MPM_BIT(F) | MPM_BIT(F33), &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal H[MPM_STATIC_NC];

    StepGradient(dim, nc, &view, F, F33, p, H);
    for (PetscInt k = 0; k < nc; k++) *most = PetscMax(*most, PetscAbsReal(H[k]));
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, MPM_BIT(F) | MPM_BIT(F33), &view));
  PetscCall(PetscFree(F));
  PetscCall(PetscFree(F33));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 1, MPIU_REAL, MPI_MAX, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to C [nc][nc], the tangent of a particle that resists hardly anything, as sand that is pulled apart, a small part of the
   elastic one: else nodes that have only such particles are held by nothing. The residual stays as it is. */
static void Hold(PetscInt dim, PetscInt nc, const MPMMaterial *m, PetscReal C[])
{
  const PetscReal stiff = m->lambda + 2 * m->mu;
  PetscReal       one[MPM_STATIC_NC], most = 0;

  for (PetscInt k = 0; k < nc * nc; k++) most = PetscMax(most, PetscAbsReal(C[k]));
  if (most > HOLDS * stiff) return;
  (void)Unit(dim, nc, one);
  for (PetscInt k = 0; k < nc; k++) {
    const PetscInt turned = k < dim * dim ? k % dim * dim + k / dim : k;

    C[k * nc + k] += HOLDS * m->mu;
    C[k * nc + turned] += HOLDS * m->mu;
    for (PetscInt j = 0; j < nc; j++) C[k * nc + j] += HOLDS * m->lambda * one[k] * one[j];
  }
}

PetscErrorCode MPMStaticLawBegin(struct MPMStatic *s, MPMStaticLaw *q)
{
  MPMCore       *core = s->core;
  const PetscInt dim = core->grid.dim, nc = MPMTangentNumbers(dim, core->grid.round), n = core->particles.n;
  PetscReal     *H;

  PetscFunctionBeginUser;
  PetscCall(Take(core, PETSC_TRUE, MPM_FIELD_INDEX_F, dim * dim, &q->F));
  PetscCall(Take(core, core->grid.round, MPM_FIELD_INDEX_F33, 1, &q->F33));
  PetscCall(Take(core, core->needs.barred, MPM_FIELD_INDEX_bar, 1, &q->bar));
  PetscCall(MPMParticlesPutBack(&core->particles));
  PetscCall(MPMParticlesGetView(&core->particles, FIELDS, &q->view));
  q->loaded   = q->view;
  q->loaded.F = q->F;
  if (q->F33) q->loaded.F33 = q->F33;
  q->law = (MPMTangent){.dim       = dim,
                        .round     = core->grid.round,
                        .width     = MPMKernelWidth(),
                        .dt        = core->params.dt,
                        .kinds     = core->params.kinds,
                        .materials = core->params.materials,
                        .particles = &q->view};
  PetscCall(PetscMalloc1(PetscMax(1, n * nc), &H));
  PetscCall(PetscMalloc2(PetscMax(1, n * nc), &q->tau, PetscMax(1, n * nc * nc), &q->C));
  for (PetscInt p = 0; p < n; p++) StepGradient(dim, nc, &q->view, q->F, q->F33, p, H + p * nc);
  (void)MPMTangentTrial(&q->law, 0, n, H, q->tau, q->C); /* the residual has found all of them in order */
  for (PetscInt p = 0; p < n; p++) {                     /* tau = T f^T, and dtau - tau dl^T = (A : dl f) f^T */
    PetscReal *f = H + p * nc, *tau = q->tau + p * nc, *C = q->C + p * nc * nc, one[MPM_STATIC_NC];

    (void)Unit(dim, nc, one);
    for (PetscInt k = 0; k < nc; k++) f[k] += one[k];
    TurnOne(dim, nc, f, tau);
    Turn(dim, nc, f, C);
    for (PetscInt a = 0; a < dim; a++)
      for (PetscInt b = 0; b < dim; b++)
        for (PetscInt e = 0; e < dim; e++) C[(a * dim + b) * nc + b * dim + e] += tau[a * dim + e];
    if (nc > dim * dim) C[nc * nc - 1] += tau[nc - 1];
    Hold(dim, nc, &core->params.materials[MPMKindOf(core->params.kinds, &q->view, p)->material], C);
  }
  PetscCall(PetscFree(H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticLawEnd(struct MPMStatic *s, MPMStaticLaw *q)
{
  PetscFunctionBeginUser;
  PetscCall(MPMParticlesRestoreView(&s->core->particles, FIELDS, &q->view));
  PetscCall(PetscFree(q->F));
  PetscCall(PetscFree(q->F33));
  PetscCall(PetscFree(q->bar));
  PetscCall(PetscFree2(q->tau, q->C));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns how much of theta - tr dl the law's dl of particle p has on each axis: that by which F-bar scales f. */
static PetscReal Follows(const struct MPMStatic *s, const MPMStaticLaw *q, PetscInt p, PetscReal axes)
{
  const PetscReal alpha = s->core->params.lock_share;

  if (!q->bar) return 0;
  return (1 - (1 - alpha) * PetscPowReal(q->bar[p] / q->view.bar[p], axes)) / axes;
}

/* Returns the volume ratio of the motion of particle p. */
static PetscReal Ratio(PetscInt dim, const MPMStaticLaw *q, PetscInt p, PetscReal axes)
{
  const PetscReal J = MPMDet((int)dim, q->F + p * dim * dim) * (q->F33 ? q->F33[p] : 1);

  return q->bar ? J * PetscPowReal(q->bar[p], axes) : J;
}

void MPMStaticFindMeans(const struct MPMStatic *s, const MPMStaticLaw *q, PetscInt m, PetscInt from, PetscInt to,
                        MPMStaticMeans *means)
{
  const MPMCore *core = s->core;
  const PetscInt dim = core->grid.dim, nc = MPMTangentNumbers(dim, q->law.round);
  PetscReal      one[MPM_STATIC_NC], axes = Unit(dim, nc, one);

  *means = (MPMStaticMeans){0, 0, 0, 0};
  for (PetscInt k = from; k < to && q->bar; k++) {
    const PetscInt   p    = core->particles.order[k];
    const MPMKind   *kind = MPMKindOf(core->params.kinds, &q->view, p);
    const PetscReal *C = q->C + p * nc * nc, c = Follows(s, q, p, axes);

    if (kind->material != m) continue;
    means->volume += kind->V0 * Ratio(dim, q, p, axes);
    for (PetscInt a = 0; a < nc; a++) {
      means->mean += kind->V0 * one[a] * q->tau[p * nc + a] / axes;
      for (PetscInt b = 0; b < nc; b++) means->slope += kind->V0 * c * one[a] * one[b] * C[a * nc + b] / axes;
    }
  }
  if (!(means->volume > 0)) return;
  means->mean /= means->volume;
  means->slope  = means->slope / means->volume - means->mean;
  means->weight = core->params.lock_share * means->volume;
}

/* Takes from the derivatives of the stress and the force those of pressures on particle p. D [nc][nc] are by dl, and by theta
   X [nc], Pa. c: how the law's dl follows theta - tr dl, on each of the axes `one`. */
static PetscErrorCode AddLoads(struct MPMStatic *s, MPMStaticLaw *q, PetscInt p, PetscReal c, const PetscReal one[],
                               const PetscReal F[], PetscReal D[], PetscReal X[], MPMStaticParticle *to)
{
  MPMCore       *core = s->core;
  const PetscInt dim = core->grid.dim, nc = to->nc;
  PetscReal      S[9], E[MPM_STATIC_NC * MPM_STATIC_NC];
  PetscBool      any;

  PetscFunctionBeginUser;
  PetscCall(MPMForcesTangent(s->scene, core, &q->loaded, p, core->t + core->params.dt, S, to->B, E, &any));
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  Turn(dim, nc, F, E); /* dS - S dl^T by the law's dl */
  for (PetscInt a = 0; a < nc; a++) {
    PetscReal row = a < dim * dim ? S[a] : 0;

    for (PetscInt b = 0; b < nc; b++) row += E[a * nc + b] * one[b];
    for (PetscInt b = 0; b < nc; b++) D[a * nc + b] -= E[a * nc + b] - c * row * one[b];
    X[a] -= c * row;
  }
  for (PetscInt d = 0; d < dim; d++) {
    PetscReal      *B = to->B + d * nc, sum = 0;
    const PetscReal m = MPMKindOf(core->params.kinds, &q->view, p)->m;

    TurnOne(dim, nc, F, B);
    for (PetscInt b = 0; b < nc; b++) sum += B[b] * one[b];
    for (PetscInt b = 0; b < nc; b++) B[b] = m * (B[b] - c * sum * one[b]);
    to->body[d] = m * c * sum;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticParticleTangent(struct MPMStatic *s, MPMStaticLaw *q, const MPMStaticMeans *means, PetscInt p,
                                        MPMStaticParticle *to)
{
  MPMCore        *core = s->core;
  const PetscInt  dim = core->grid.dim, nc = MPMTangentNumbers(dim, q->law.round);
  const PetscReal V0 = MPMKindOf(core->params.kinds, &q->view, p)->V0, *C = q->C + p * nc * nc;
  PetscReal tau[MPM_STATIC_NC], F[MPM_STATIC_NC], back[MPM_STATIC_NC], one[MPM_STATIC_NC], *D = to->A, *X = to->forces;
  PetscReal axes = Unit(dim, nc, one), c = Follows(s, q, p, axes), J = Ratio(dim, q, p, axes);
  PetscReal alpha = q->bar ? core->params.lock_share : 0, column[MPM_STATIC_NC] = {0}, row[MPM_STATIC_NC] = {0};
  PetscReal both = 0, own = 0; /* I : C : I; the mean normal stress */

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(to, sizeof *to));
  to->nc = nc;
  Deformation(dim, q->F, q->F33, p, F);
  for (PetscInt a = 0; a < nc; a++) {
    tau[a] = q->tau[p * nc + a];
    own += one[a] * tau[a] / axes;
    for (PetscInt b = 0; b < nc; b++) {
      column[a] += C[a * nc + b] * one[b];
      row[b] += one[a] * C[a * nc + b];
      both += one[a] * one[b] * C[a * nc + b];
    }
  }
  for (PetscInt a = 0; a < nc; a++) {
    for (PetscInt b = 0; b < nc; b++)
      D[a * nc + b] = C[a * nc + b] - c * column[a] * one[b] - one[a] * alpha / axes * (row[b] - c * both * one[b]) +
                      one[a] * one[b] * alpha * J * means->mean;
    X[a] = c * column[a] + one[a] * alpha * (J * means->slope - c * both / axes);
    tau[a] += one[a] * alpha * (J * means->mean - own);
    to->theta[a] = q->bar ? V0 * J / means->volume * one[a] : 0;
    to->eta[a]   = q->bar ? V0 / (axes * means->volume) * (row[a] - c * both * one[a]) : 0;
  }
  if (core->needs.loaded) PetscCall(AddLoads(s, q, p, c, one, F, D, X, to));
  for (PetscInt a = 0; a < dim; a++)
    for (PetscInt b = 0; b < dim; b++)
      for (PetscInt e = 0; e < dim; e++) D[(a * dim + b) * nc + b * dim + e] -= tau[a * dim + e];
  if (nc > dim * dim) D[nc * nc - 1] -= tau[nc - 1];
  if (!core->grid.total) { /* the weights are those of the state as the step began */
    StepGradient(dim, nc, &q->view, q->F, q->F33, p, F);
    for (PetscInt k = 0; k < nc; k++) F[k] += one[k];
  }
  for (PetscInt k = 0; k < nc && q->bar; k++) F[k] *= q->bar[p]; /* of the motion */
  Inverse(dim, nc, F, back);
  Turn(dim, nc, back, D);
  TurnOne(dim, nc, back, X);
  TurnOne(dim, nc, back, to->theta);
  TurnOne(dim, nc, back, to->eta);
  for (PetscInt d = 0; d < dim; d++) TurnOne(dim, nc, back, to->B + d * nc);
  for (PetscInt k = 0; k < nc * nc; k++) D[k] *= V0;
  for (PetscInt k = 0; k < nc; k++) X[k] *= V0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
