/* unit_tangent.c - stresses and tangents of finite displacements (physics/tangent.h), of every row of material.def, in 1,
   2 and 3 dimensions and for bodies of revolution: tangents beside differences of the trial stress, in random states, at
   rest, with equal eigenvalues, on both sides of yield, and at the apex; symmetry; the trial changes no state; the state
   after the step is the one that the law's update leaves; what no particle can follow. */
#include <stdlib.h>
#include "kernels/transfer.h"
#include "physics/law.h"
#include "physics/tangent.h"
#include "unit.h"

#define MOST     150 /* particles: more than two blocks */
#define MAX_KIND 2

/* Particles of one or two materials; fields that a material does not have are NaN. */
typedef struct {
  int         dim, nc;
  MPMMaterial materials[MAX_KIND];
  MPMKind     kinds[MAX_KIND];
  PetscInt    kind[MOST];
#define FIELD(name, rows) PetscReal name[MOST * (rows)];
  MPM_MATERIAL_FIELDS(FIELD)
#undef FIELD
  MPMView    view;
  MPMTangent t;
} Cloud;

static Cloud      *cloud;
static PetscReal   worst[64], smooth; /* largest difference found of a row; what is allowed away from yield surfaces */
static PetscInt    crossings;         /* places at yield */
static const char *form_name[] = {"1-D", "2-D", "3-D", "of revolution"};

/* All particles at rest, of material k % nmaterials. */
static void Rest(int nmaterials)
{
  Cloud *c = cloud;

  for (PetscInt p = 0; p < MOST; p++) {
    const PetscInt state = c->materials[p % nmaterials].state;

    c->kind[p] = p % nmaterials;
#define START(name, rows)                                                                                              \
  for (int k = 0, nk = MPMComponents_##name(c->dim); k < nk; k++) c->name[p * nk + k] = state & MPM_BIT(name) ? 0 : NAN;
    MPM_MATERIAL_FIELDS(START)
#undef START
    for (int k = 0; k < c->dim * c->dim; k++)
      if (state & MPM_BIT(F)) c->F[p * c->dim * c->dim + k] = k % (c->dim + 1) == 0;
    if (state & MPM_BIT(F33)) c->F33[p] = 1;
    if (state & MPM_BIT(J)) c->J[p] = 1;
    for (int k = 0; k < MPM_SYM_NC(c->dim); k++)
      if (state & MPM_BIT(be)) c->be[p * MPM_SYM_NC(c->dim) + k] = MPMSymUnit(c->dim, k);
  }
}

/* Makes the cloud of a form (0 .. 3) with its first material m. */
static void Open(const MPMMaterial *m, int form)
{
  Cloud *c = cloud;

  c->dim                = form == 3 ? 2 : form + 1;
  c->materials[0]       = *m;
  c->materials[0].round = form == 3 ? PETSC_TRUE : PETSC_FALSE;
  if (form == 3 && m->state & MPM_BIT(F)) c->materials[0].state |= MPM_BIT(F33);
  c->kinds[0] = (MPMKind){.material = 0};
  c->kinds[1] = (MPMKind){.material = 1};
  c->t        = (MPMTangent){.dim       = c->dim,
                             .round     = c->materials[0].round,
                             .width     = MPMKernelWidth(),
                             .dt        = 1,
                             .kinds     = c->kinds,
                             .materials = c->materials,
                             .particles = &c->view};
  c->view     = (MPMView){.n = MOST, .kind = c->kind};
#define VIEW(name, rows) c->view.name = c->name;
  MPM_MATERIAL_FIELDS(VIEW)
#undef VIEW
  c->nc = (int)MPMTangentNumbers(c->dim, c->t.round);
  CHECK_EQ(c->nc, c->dim * c->dim + (form == 3));
  Rest(1);
}

static PetscReal Modulus(void)
{
  const MPMMaterial *m = cloud->materials;

  return m->lambda + 2 * m->mu + m->K;
}

/* MPMTangentCommit, where no particle turns inside out. */
static void Commit(PetscInt first, PetscInt last, const PetscReal H[])
{
  const PetscInt bad = MPMTangentCommit(&cloud->t, first, last, H);

  CHECK_EQ(bad, 0);
}

/* Random H, size on each component; det f > 0.5. */
static void RandomH(PetscReal size, PetscReal H[])
{
  PetscReal f[9];

  do {
    for (int k = 0; k < cloud->nc; k++) H[k] = UnitReal(-size, size);
    for (int k = 0; k < cloud->dim * cloud->dim; k++) f[k] = H[k] + (k % (cloud->dim + 1) == 0);
  } while (!(MPMDet(cloud->dim, f) > 0.5));
}

static void Trial(const PetscReal H[], PetscReal T[], PetscReal A[])
{
  CHECK_EQ(MPMTangentTrial(&cloud->t, 0, 1, H, T, A), 0);
}

/* The largest difference of A [nc*nc] of particle 0 from differences of T of fourth order with step h. */
static PetscReal Differs(const PetscReal H[], const PetscReal A[], PetscReal h)
{
  const int nc   = cloud->nc;
  PetscReal most = 0;

  for (int l = 0; l < nc; l++) {
    PetscReal G[10], T[4][10];

    for (int j = 0; j < 4; j++) {
      memcpy(G, H, sizeof(PetscReal) * (size_t)nc);
      G[l] += (j < 2 ? j - 2 : j - 1) * h; /* -2h -h h 2h */
      Trial(G, T[j], NULL);
    }
    for (int k = 0; k < nc; k++)
      most = PetscMax(most, PetscAbsReal(A[k * nc + l] - (8 * (T[2][k] - T[1][k]) - (T[3][k] - T[0][k])) / (12 * h)));
  }
  return most;
}

/* Checks A of particle 0, in its state, with H, beside differences with the best of several steps, at most `longest`: long
   ones may cross a yield surface, short ones have errors of rounding. Returns by how much A is not symmetric, over its
   largest entry. */
static PetscReal Agrees(const PetscReal H[], PetscReal longest, PetscReal tolerance)
{
  static const PetscReal steps[] = {3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7};
  const int              nc      = cloud->nc;
  const MPMMaterial     *m       = cloud->materials;
  PetscReal              T[10], A[100], big = 1e-6 * Modulus(), best = PETSC_MAX_REAL, skew = 0;
  PetscInt               row = 0;

  Trial(H, T, A);
  for (int k = 0; k < nc * nc; k++) big = PetscMax(big, PetscAbsReal(A[k]));
  for (size_t j = 0; j < sizeof steps / sizeof steps[0] && best / big > 1e-10; j++)
    best = PetscMin(best, Differs(H, A, PetscMin(steps[j], longest)));
  CHECK_LE(best / big, tolerance);
  while (strcmp(MPMMaterialTypes[row].name, m->type->name)) row++;
  worst[row] = PetscMax(worst[row], best / big);
  for (int k = 0; k < nc; k++)
    for (int l = 0; l < k; l++) skew = PetscMax(skew, PetscAbsReal(A[k * nc + l] - A[l * nc + k]) / big);
  if (MPMTangentIsSymmetric(m, nc == 1 ? 1 : cloud->dim)) CHECK_LE(skew, 1e-13);
  return skew;
}

static int IsPlastic(void)
{
  return cloud->materials[0].type->traits & MPM_PLASTIC ? 1 : 0;
}

/* Some steps, to a state with history. */
static void Wander(int steps, PetscReal size)
{
  PetscReal H[10];

  for (int step = 0; step < steps; step++) {
    RandomH(size, H);
    Commit(0, 1, H);
  }
}

/* Random states and displacements. Returns the largest skewness. */
static PetscReal Random(void)
{
  PetscReal H[10], most = 0;

  for (int round = 0; round < 60; round++) {
    const PetscReal size = round % 2 ? 0.02 : IsPlastic() ? 0.1 : 0.25;

    UnitContext("%s %s, random state %d", cloud->materials[0].name, form_name[MPMLawForm(cloud->materials, cloud->dim)],
                round);
    Rest(1);
    Wander(round % 4, size);
    RandomH(size, H);
    if (round % 5 == 0) /* pressure */
      for (int d = 0; d < cloud->dim; d++) H[d * (cloud->dim + 1)] -= 0.05;
    most = PetscMax(most, Agrees(H, 1, smooth));
  }
  return most;
}

/* At rest, and stretches with eigenvalues that are equal or nearly so. `more` is a volume strain that keeps sand in
   its elastic range, if it has one. */
static void Equal(PetscReal more)
{
  static const PetscReal apart[] = {0, 1e-15, 1e-9, 1e-5, 1e-3, 0.049, 0.0501, 0.0502, 0.06};
  PetscReal              H[10];

  UnitContext("%s %s, at rest", cloud->materials[0].name, form_name[MPMLawForm(cloud->materials, cloud->dim)]);
  Rest(1);
  memset(H, 0, sizeof H);
  for (int d = 0; d < cloud->dim; d++) H[d * (cloud->dim + 1)] = more;
  Agrees(H, 1, smooth);
  for (size_t k = 0; k < sizeof apart / sizeof apart[0]; k++)
    for (int turned = 0; turned < 2; turned++) {
      UnitContext("%s %s, eigenvalues apart by %g", cloud->materials[0].name,
                  form_name[MPMLawForm(cloud->materials, cloud->dim)], apart[k]);
      memset(H, 0, sizeof H);
      for (int d = 0; d < cloud->dim; d++) H[d * (cloud->dim + 1)] = -0.02 - 0.5 * d * apart[k];
      if (cloud->t.round) H[4] = -0.02;
      if (turned && cloud->dim > 1) H[1] = H[cloud->dim] = 0.25 * apart[k];
      Agrees(H, 1, smooth);
    }
}

/* Whether the step H from rest flows: the tangent has another state than a step without flow would leave. */
static PetscBool Flows(const PetscReal H[])
{
  PetscReal f[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, most = 0;
  const int nk = MPM_SYM_NC(cloud->dim);

  Rest(1);
  for (int k = 0; k < cloud->dim * cloud->dim; k++) f[k / cloud->dim][k % cloud->dim] += H[k];
  if (cloud->t.round) f[2][2] += H[4];
  Commit(0, 1, H);
  for (int k = 0; k < nk; k++) {
    const int place = MPMSymPlace(cloud->dim, k);

    for (int d = 0; d < 3; d++)
      for (int e = d; e < 3; e++)
        if (MPMSymIndex(d, e) == place) {
          PetscReal b = 0;

          for (int j = 0; j < 3; j++) b += f[d][j] * f[e][j];
          most = PetscMax(most, PetscAbsReal(b - cloud->be[k]));
        }
  }
  Rest(1);
  return most > 1e-13 ? PETSC_TRUE : PETSC_FALSE;
}

/* Just within and just beyond the yield surface, along random paths from rest (sand: from pressure). Differences there
   are made with steps that are short beside the distance of the surface. */
static void AtYield(void)
{
  const PetscReal near[] = {1e-4, 1e-3};
  int             done   = 0;

  for (int round = 0; round < 200 && done < 12; round++) {
    PetscReal from[10] = {0}, along[10], H[10], lo = 0, hi = 1, size = 0;

    for (int d = 0; d < cloud->dim; d++) from[d * (cloud->dim + 1)] = -0.02;
    if (cloud->t.round) from[4] = -0.02;
    RandomH(0.1, along);
    for (int k = 0; k < cloud->nc; k++) H[k] = from[k] + along[k];
    if (Flows(from) || !Flows(H)) continue;
    for (int halve = 0; halve < 50; halve++) {
      const PetscReal middle = 0.5 * (lo + hi);

      for (int k = 0; k < cloud->nc; k++) H[k] = from[k] + middle * along[k];
      if (Flows(H))
        hi = middle;
      else
        lo = middle;
    }
    for (int k = 0; k < cloud->nc; k++) size = PetscMax(size, PetscAbsReal(along[k]));
    for (int j = 0; j < 4; j++) {
      const PetscReal distance = near[j / 2], at = lo + (j % 2 ? 1 : -1) * distance;

      UnitContext("%s %s, at yield %+g", cloud->materials[0].name, form_name[MPMLawForm(cloud->materials, cloud->dim)],
                  at - lo);
      for (int k = 0; k < cloud->nc; k++) H[k] = from[k] + at * along[k];
      CHECK((j % 2) == (Flows(H) ? 1 : 0));
      Agrees(H, 0.05 * distance * size, 1e-8);
    }
    done++;
  }
  crossings += done;
}

/* Sand and soil that is pulled to the apex, and pressed again before its grains touch. */
static void Apex(void)
{
  PetscReal H[10];

  for (int round = 0; round < 20; round++) {
    UnitContext("%s %s, apex %d", cloud->materials[0].name, form_name[MPMLawForm(cloud->materials, cloud->dim)], round);
    Rest(1);
    RandomH(0.05, H);
    for (int d = 0; d < cloud->dim; d++) H[d * (cloud->dim + 1)] += 0.2;
    Agrees(H, 1, smooth);
    Commit(0, 1, H);
    if (cloud->materials[0].dilation < 0.4) CHECK_GE(cloud->vc[0], 1e-3);
    for (int j = 0; j < 4; j++) {
      RandomH(0.05, H);
      for (int d = 0; d < cloud->dim; d++) H[d * (cloud->dim + 1)] -= 0.1 * j;
      Agrees(H, 1, smooth);
    }
  }
}

/* The bytes of all fields. */
static int Same(const Cloud *a, const Cloud *b)
{
#define EQUAL(name, rows)                                                                                              \
  if (memcmp(a->name, b->name, sizeof a->name)) return 0;
  MPM_MATERIAL_FIELDS(EQUAL)
#undef EQUAL
  return !memcmp(a->kind, b->kind, sizeof a->kind);
}

/* The stress and the state of particle p of the cloud after the law's own step with L = H, by its functions for blocks:
   F, then update or stress. */
static void Explicit(PetscInt p, const PetscReal H[], Cloud *to)
{
  const MPMMaterial *m   = &to->materials[to->kind[p]];
  const int          dim = to->dim, form = (int)MPMLawForm(m, dim), nf = dim * dim;
  MPMBlock           b;
  MPMComponent       L[9];

  memset(&b, 0, sizeof b);
  MPMMaterialState(dim, &to->view, p, &b);
  if (m->state & MPM_BIT(F)) {
    MPMDeform(dim, 1, H, to->F + p * nf);
    for (int k = 0; k < nf; k++) b.F[k][0] = to->F[p * nf + k];
  }
  if (m->state & MPM_BIT(F33)) b.F33[0][0] = to->F33[p] += H[nf] * to->F33[p];
  for (int k = 0; k < to->nc; k++) L[k][0] = H[k];
  if (m->type->law->update[form]) m->type->law->update[form](m, 1, L, 0, 1, &b);
#define TAKE(name, rows)                                                                                               \
  for (int k = 0, nk = MPMComponents_##name(dim); k < nk && m->state & MPM_BIT(name); k++)                             \
    to->name[p * nk + k] = b.name[k][0];
  MPM_MATERIAL_FIELDS(TAKE)
#undef TAKE
}

/* A step of all particles, of one material or of two in turns: the trial leaves the state untouched, has the same bits
   in parts and at any width, and the stress that the law has after the step; the commit leaves the state of an explicit
   step, but of fluids. */
static void Step(int nmaterials)
{
  const int  nc = cloud->nc, dim = cloud->dim, nf = dim * dim;
  Cloud     *before = malloc(sizeof *before), *after = malloc(sizeof *after);
  PetscReal *H = calloc(MOST * 10, sizeof *H), *T = calloc(2 * MOST * 10, sizeof *T),
            *A = calloc(2 * MOST * 100, sizeof *A);

  UnitContext("%s %s, a step, %d materials", cloud->materials[0].name, form_name[MPMLawForm(cloud->materials, dim)],
              nmaterials);
  Rest(nmaterials);
  for (int step = 0; step < 3; step++) {
    const PetscInt first = UnitInt(MOST / 2), last = first + UnitInt(MOST / 2);

    for (PetscInt p = 0; p < MOST; p++) RandomH(0.05, H + p * nc);
    *before = *cloud;
    CHECK_EQ(MPMTangentTrial(&cloud->t, 0, MOST, H, T, A), 0);
    CHECK_EQ(
        MPMTangentTrial(&cloud->t, first, last, H + first * nc, T + (MOST + first) * nc, A + (MOST + first) * nc * nc),
        0);
    CHECK_SAME(T + first * nc, T + (MOST + first) * nc, sizeof(PetscReal) * (size_t)((last - first) * nc));
    CHECK_SAME(A + first * nc * nc, A + (MOST + first) * nc * nc,
               sizeof(PetscReal) * (size_t)((last - first) * nc * nc));
    for (PetscInt width = 1; width <= MPMKernelWidth(); width *= 2) {
      cloud->t.width = width;
      CHECK_EQ(MPMTangentTrial(&cloud->t, 0, MOST, H, T + MOST * nc, A + MOST * nc * nc), 0);
      CHECK_SAME(T, T + MOST * nc, sizeof(PetscReal) * (size_t)(MOST * nc));
      CHECK_SAME(A, A + MOST * nc * nc, sizeof(PetscReal) * (size_t)(MOST * nc * nc));
    }
    CHECK(Same(before, cloud));
    CHECK_EQ(MPMTangentTrial(&cloud->t, 0, MOST, H, T + MOST * nc, NULL), 0);
    CHECK_SAME(T, T + MOST * nc, sizeof(PetscReal) * (size_t)(MOST * nc));
    Commit(first, last, H + first * nc);
    Commit(0, first, H);
    Commit(last, MOST, H + last * nc);
    *after      = *before;
    after->view = cloud->view;
#define VIEW(name, rows) after->view.name = after->name;
    MPM_MATERIAL_FIELDS(VIEW)
#undef VIEW
    for (PetscInt p = 0; p < MOST; p++) {
      const MPMMaterial *m = &cloud->materials[cloud->kind[p]];
      MPMBlock           b;
      PetscReal          f[9], det;

      for (int k = 0; k < nf; k++) f[k] = H[p * nc + k] + (k % (dim + 1) == 0);
      det = MPMDet(dim, f) * (cloud->t.round ? 1 + H[p * nc + nf] : 1);
      if (m->type->traits & MPM_FLUID) {
        CHECK_NEAR(cloud->J[p], before->J[p] * det, 1e-15);
        after->J[p] = cloud->J[p];
        for (int k = 0; k < MPM_SYM_NC(dim); k++)
          after->tau[p * MPM_SYM_NC(dim) + k] = cloud->tau[p * MPM_SYM_NC(dim) + k];
      } else
        Explicit(p, H + p * nc, after);
      /* T f^T = tau */
      memset(&b, 0, sizeof b);
      MPMMaterialState(dim, &cloud->view, p, &b);
      if (!(m->state & MPM_BIT(tau))) m->type->law->stress[MPMLawForm(m, dim)](m, 0, 1, &b);
      for (int a = 0; a < dim; a++)
        for (int e = 0; e < dim; e++) {
          PetscReal tau = 0;

          for (int B = 0; B < dim; B++) tau += T[p * nc + a * dim + B] * f[e * dim + B];
          CHECK_NEAR(tau / Modulus(), b.tau[MPMSymPart(dim, a, e)][0] / Modulus(), 1e-15);
        }
      if (cloud->t.round) CHECK_NEAR(T[p * nc + nf] * (1 + H[p * nc + nf]) / Modulus(), b.tau[3][0] / Modulus(), 1e-15);
    }
    CHECK(Same(after, cloud));
  }
  free(before), free(after), free(H), free(T), free(A);
}

/* Particles that a step would turn inside out, or whose H is not finite, are counted, have no stress, and keep their
   state; others have what they have without these. */
static void Impossible(void)
{
  const int  nc = cloud->nc, dim = cloud->dim;
  Cloud     *before = malloc(sizeof *before);
  PetscReal *H = calloc(MOST * 10, sizeof *H), *T = calloc(2 * MOST * 10, sizeof *T),
            *A = calloc(2 * MOST * 100, sizeof *A);
  PetscInt bad = 0, inverted[MOST] = {0};

  UnitContext("%s %s, impossible steps", cloud->materials[0].name, form_name[MPMLawForm(cloud->materials, dim)]);
  Rest(1);
  for (PetscInt p = 0; p < MOST; p++) RandomH(0.02, H + p * nc);
  CHECK_EQ(MPMTangentTrial(&cloud->t, 0, MOST, H, T, A), 0);
  for (PetscInt p = 0; p < MOST; p += 7) {
    static const PetscReal odd[] = {-1, -2.5, NAN, INFINITY, -INFINITY};

    inverted[p]                      = 1;
    H[p * nc + (p % 2 ? nc - 1 : 0)] = odd[bad++ % 5];
    for (int k = 0; k < nc; k++)
      if (k % (dim + 1) && k < dim * dim) H[p * nc + k] = 0;
  }
  *before = *cloud;
  CHECK_EQ(MPMTangentTrial(&cloud->t, 0, MOST, H, T + MOST * nc, A + MOST * nc * nc), bad);
  CHECK_EQ(MPMTangentCommit(&cloud->t, 0, MOST, H), bad);
  for (PetscInt p = 0; p < MOST; p++) {
    for (int k = 0; k < nc; k++) CHECK_EQ(T[(MOST + p) * nc + k], inverted[p] ? 0 : T[p * nc + k]);
    for (int k = 0; k < nc * nc; k++) CHECK_EQ(A[(MOST + p) * nc * nc + k], inverted[p] ? 0 : A[p * nc * nc + k]);
#define KEPT(name, rows)                                                                                               \
  if (inverted[p])                                                                                                     \
    CHECK_SAME(cloud->name + p * MPMComponents_##name(dim), before->name + p * MPMComponents_##name(dim),              \
               sizeof(PetscReal) * (size_t)MPMComponents_##name(dim));
    MPM_MATERIAL_FIELDS(KEPT)
#undef KEPT
  }
  free(before), free(H), free(T), free(A);
}

/* All of a material, in all forms. skewed: with these constants its tangent is not symmetric. */
static void Material(const MPMMaterial *m, PetscBool skewed)
{
  const int   sand    = m->state & MPM_BIT(vc) ? 1 : 0;
  MPMMaterial dropped = *m;

  for (int form = 0; form < MPM_LAW_FORMS; form++) {
    PetscReal skew;

    Open(m, form);
    skew = Random();
    UnitContext("%s %s, symmetry", m->name, form_name[form]);
    CHECK_EQ(MPMTangentIsSymmetric(m, cloud->dim), cloud->dim == 1 || !skewed ? PETSC_TRUE : PETSC_FALSE);
    if (m->skew && cloud->dim > 1) CHECK_GE(skew, 1e-6);
    if (!sand || m->friction > 0) Equal(sand ? -0.01 : 0); /* sand without friction is at yield there */
    if (IsPlastic() && MPMTangentIsOwn(m) && m->yield < 1e30 && (!sand || m->friction > 0)) AtYield();
    if (m->rate > 0 || m->viscosity > 0) {
      cloud->t.dt = 1e-2;
      (void)Random();
      cloud->t.dt = 1;
    }
    if (sand) Apex();
    Step(1);
    Impossible();
    MPMMaterialDropF(&dropped);
    if (dropped.state == m->state) continue;
    Open(&dropped, form);
    (void)Random();
    Step(1);
  }
}

static void SetUp(MPMMaterial *m)
{
  const char *wrong = MPMMaterialSetUp(m);

  CHECK(wrong == NULL);
}

/* The rows of material.def with constants of all kinds; a new row of E and nu needs nothing here. */
static void Row(const MPMMaterialType *type)
{
  static const PetscReal angles[][3] = {{30, 0, 0}, {30, 10, 20}, {30, 30, 20}, {0, 0, 0}, {40, 40, 0}};
  MPMMaterial            m           = {.type = type, .rho = 1000, .E = 1e4, .nu = 0.3, .melting = -1, .tension = -1};

  PetscStrncpy(m.name, type->name, sizeof m.name);
  if (type->traits & MPM_FLUID) {
    for (int k = 0; k < 6; k++) {
      MPMMaterial fluid = {.type      = type,
                           .rho       = 1000,
                           .K         = 2e4,
                           .gamma     = k % 2 ? 7 : 0,
                           .tension   = k > 3 ? 30 : -1,
                           .viscosity = k / 2 == 1 ? 500 : 0};

      PetscStrncpy(fluid.name, type->name, sizeof fluid.name);
      SetUp(&fluid);
      Material(&fluid, fluid.viscosity > 0 ? PETSC_TRUE : PETSC_FALSE);
    }
  } else if (!strcmp(type->name, "druckerprager")) {
    for (size_t k = 0; k < sizeof angles / sizeof angles[0]; k++)
      for (int plane = 0; plane < 2; plane++) {
        MPMMaterial sand = m;

        sand.friction = angles[k][0], sand.dilation = angles[k][1], sand.cohesion = angles[k][2];
        sand.plane = plane ? PETSC_TRUE : PETSC_FALSE;
        SetUp(&sand);
        Material(&sand, angles[k][0] > angles[k][1] ? PETSC_TRUE : PETSC_FALSE);
      }
  } else if (!strcmp(type->name, "johnsoncook")) {
    m.c0 = 3, m.slope = 1.5, m.gruneisen = 2, m.shear = 5e3, m.yield = 500, m.hardening = 300, m.power = 1;
    m.rate = 0.02, m.rate0 = 1e-6, m.softening = 1, m.temperature = 300, m.melting = 1500, m.heat = 0.5, m.share = 0.9;
    SetUp(&m);
    Material(&m, PETSC_TRUE);
  } else {
    static const PetscReal nu[] = {0.3, 0, 0.49, -0.3};

    for (int k = 0; k < 4; k++) {
      m.nu        = nu[k];
      m.yield     = k % 2 ? 1e30 : 300;
      m.hardening = k == 2 ? 0 : 1000;
      SetUp(&m);
      Material(&m, type->traits & MPM_SYMMETRIC ? PETSC_FALSE : PETSC_TRUE);
    }
  }
}

int main(void)
{
  cloud = malloc(sizeof *cloud);
  for (const MPMMaterialType *type = MPMMaterialTypes; type->name; type++) {
    smooth    = type->law->tangent[0] ? 1e-9 : 1e-8;
    crossings = 0;
    Row(type);
    if (type->traits & MPM_PLASTIC && type->law->tangent[0]) CHECK_GE(crossings, 60);
    printf("%-14s %s, differs by %.1e of the largest entry\n", type->name,
           type->law->tangent[0] ? "own" : "by differences", (double)worst[type - MPMMaterialTypes]);
  }
  free(cloud);
  return UnitEnd();
}
