/* start_state.c - finds the state in which a material has a given stress, for scenes that start with stress; and the
   state of a given deformation. A fluid has a volume ratio, a plastic law elastic strains within its yield surface, and
   another one a symmetric F. Only the functions of the law's row are called, so a new law needs nothing here unless it
   is of another kind. */
#include "base/algebra.h"
#include "physics/start_state.h"

#define ROUNDS     60
#define ON_SURFACE 1e-6  /* the part by which a stress may be beyond the yield surface, to be returned to it */
#define ROUNDING   1e-14 /* of the modulus of waves: stresses as small are lost where they are made of strains */

static const char beyond[] = "beyond its yield surface", none[] = "which no deformation of its law has";

/* Copies a state to particle 0 of a block; what else a law may have is 0. */
static void Fill(PetscInt dim, const MPMMaterialStart *s, MPMBlock *b)
{
#define MPM_EMPTY(name, rows)                                                                                          \
  for (int k = 0; k < (rows); k++) b->name[k][0] = 0;
  MPM_MATERIAL_FIELDS(MPM_EMPTY)
#undef MPM_EMPTY
  for (PetscInt k = 0; k < dim * dim; k++) b->F[k][0] = s->F[k];
  for (int k = 0; k < MPM_SYM_NC((int)dim); k++) {
    b->be[k][0]  = s->be[MPMSymPlace((int)dim, k)];
    b->tau[k][0] = s->tau[MPMSymPlace((int)dim, k)];
  }
  b->J[0][0] = s->J;
}

/* Copies tau, and be if the law has it, from particle 0 of a block. */
static void Take(PetscInt dim, const MPMMaterial *m, const MPMBlock *b, MPMMaterialStart *s)
{
  for (int k = 0; k < MPM_SYM_NC((int)dim); k++) {
    s->tau[MPMSymPlace((int)dim, k)] = b->tau[k][0];
    if (m->state & MPM_BIT(be)) s->be[MPMSymPlace((int)dim, k)] = b->be[k][0];
  }
}

/* Sets tau to the stress of a law that is a function of F or J. */
static void Stress(PetscInt dim, const MPMMaterial *m, MPMMaterialStart *s)
{
  MPMBlock b;

  Fill(dim, s, &b);
  m->type->law->stress[dim - 1](m, 0, 1, &b);
  for (int k = 0; k < 6; k++) s->tau[k] = 0;
  Take(dim, m, &b, s);
}

static PetscReal Largest(const PetscReal tau[])
{
  PetscReal most = 0;

  for (int k = 0; k < 6; k++) most = PetscMax(most, PetscAbsReal(tau[k]));
  return most;
}

/* Lets a law with elastic strains look at the state, by a step without motion: it sets tau, and returns a stress beyond
   the yield surface to it. Returns by how much be has changed then. */
static PetscReal Look(PetscInt dim, const MPMMaterial *m, MPMMaterialStart *s)
{
  MPMComponent L[9];
  PetscReal    was[6], change = 0;
  MPMBlock     b;

  for (int k = 0; k < 9; k++) L[k][0] = 0;
  for (int k = 0; k < 6; k++) was[k] = s->be[k];
  Fill(dim, s, &b);
  m->type->law->update[dim - 1](m, 1, L, 0, 1, &b);
  Take(dim, m, &b, s);
  for (int k = 0; k < 6; k++) change = PetscMax(change, PetscAbsReal(s->be[k] - was[k]));
  return change;
}

const char *MPMMaterialDeformed(const MPMMaterial *m, PetscInt dim, const PetscReal F[], MPMMaterialStart *s)
{
  for (PetscInt k = 0; k < dim * dim; k++) s->F[k] = F[k];
  s->F33 = 1;
  s->J   = MPMDet((int)dim, F);
  for (int k = 0; k < 6; k++) s->tau[k] = 0;
  if (!(s->J > 0 && s->J <= PETSC_MAX_REAL)) return "whose determinant is not positive";
  MPMLeftCauchyGreen((int)dim, F, s->be);
  if (m->state & MPM_BIT(be)) return Look(dim, m, s) > 1e-3 * ON_SURFACE ? beyond : NULL;
  if (!m->type->law->stress[dim - 1]) return none; /* history alone tells it */
  Stress(dim, m, s);
  return NULL;
}

/* Returns tau_xx - wanted of a fluid with the volume ratio J, and leaves its stress in the state. */
static PetscReal Excess(const MPMMaterial *m, PetscInt dim, PetscReal J, PetscReal wanted, MPMMaterialStart *s)
{
  s->J = J;
  Stress(dim, m, s);
  return s->tau[0] - wanted;
}

/* Sets J of a fluid, whose tau is the same on all sides: it is between two ratios that lie the nearest to 1, and
   halving their distance finds it. */
static const char *Fluid(const MPMMaterial *m, PetscInt dim, const PetscReal tau[], MPMMaterialStart *s)
{
  const PetscReal factor = tau[0] > 0 ? 1.02 : 0.98;
  PetscReal       from = 1, to = 1;

  for (int k = 0; k < 6; k++) {
    const PetscBool shear = k == 1 || k == 2 || k == 4;

    if ((k > 2 && dim == 1) || (k == 5 && dim == 2)) continue; /* along a missing axis */
    if (PetscAbsReal(tau[k] - (shear ? 0 : tau[0])) > 1e-9 * Largest(tau))
      return "with shear, of which a fluid at rest has none";
  }
  while (tau[0] != 0 && Excess(m, dim, to, tau[0], s) * tau[0] < 0) {
    from = to;
    to *= factor;
    if (to < 0.02 || to > 50) return none;
  }
  for (PetscInt n = 0; n < ROUNDS; n++) {
    const PetscReal middle = 0.5 * (from + to);

    if (Excess(m, dim, middle, tau[0], s) * tau[0] < 0)
      from = middle;
    else
      to = middle;
  }
  (void)Excess(m, dim, to, tau[0], s);
  for (PetscInt d = 0; d < dim; d++) s->F[d * (dim + 1)] = PetscPowReal(s->J, 1 / (PetscReal)dim);
  return NULL;
}

/* Sets the elastic strains that Hencky's law has for tau, and the F that has no other ones. */
static void Hencky(const MPMMaterial *m, PetscInt dim, PetscBool whole, const PetscReal tau[], MPMMaterialStart *s)
{
  PetscReal t[3], n[3][3], b[3], root[3], V[6], given[6], trace = 0;

  for (int k = 0; k < 6; k++) given[k] = tau[k];
  if (dim == 2 && !whole) given[5] = m->lambda / (2 * (m->lambda + m->mu)) * (tau[0] + tau[3]);
  if (dim == 1 && !whole) given[3] = given[5] = m->lambda / (m->lambda + 2 * m->mu) * tau[0];
  MPMEigen((int)dim, given, t, n);
  for (int k = 0; k < 3; k++) trace += t[k];
  s->J = 1;
  for (int k = 0; k < 3; k++) {
    const PetscReal e = (t[k] - m->lambda / (3 * m->lambda + 2 * m->mu) * trace) / (2 * m->mu);

    b[k]    = MPMExp(2 * e);
    root[k] = MPMExp(e);
    s->J *= root[k];
  }
  MPMSpectral((int)dim, b, n, s->be);
  MPMSpectral((int)dim, root, n, V);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) s->F[d * dim + e] = V[MPMSymIndex(d, e)];
  if (m->state & MPM_BIT(F)) s->J = MPMDet((int)dim, s->F);
}

/* Sets the elastic strains of a plastic law. If it has another pressure than Hencky's law, what is missing of the
   stress is added to that for which Hencky's law is solved, until nothing is. */
static const char *Elastic(const MPMMaterial *m, PetscInt dim, PetscBool whole, const PetscReal tau[],
                           MPMMaterialStart *s)
{
  const PetscReal most = Largest(tau), enough = ON_SURFACE * most + ROUNDING * (m->lambda + 2 * m->mu);
  PetscReal       trial[6], size              = PETSC_MAX_REAL;

  for (int k = 0; k < 6; k++) trial[k] = tau[k];
  for (PetscInt n = 0; n < ROUNDS; n++) {
    const PetscReal last       = size;
    PetscReal       missing[6] = {0}, change;

    Hencky(m, dim, whole, trial, s);
    change = Look(dim, m, s);
    size   = 0;
    for (int d = 0; d < 3; d++)
      for (int e = d; e < 3; e++) {
        const int k = MPMSymIndex(d, e);

        if ((d < dim && e < dim) || (whole && d == e)) missing[k] = tau[k] - s->tau[k];
        size = PetscMax(size, PetscAbsReal(missing[k]));
      }
    if (size <= 1e-13 * most) break;
    if (change > 0) return size <= enough ? NULL : beyond;
    if (!(size < last)) break; /* as near as rounding lets it */
    for (int k = 0; k < 6; k++) trial[k] += missing[k];
  }
  return size <= enough ? NULL : none;
}

/* Adds `more` to component k, of n = dim (dim + 1)/2, of a symmetric F. */
static void AddTo(PetscInt dim, PetscInt k, PetscReal more, PetscReal F[])
{
  for (PetscInt d = 0, at = 0; d < dim; d++)
    for (PetscInt e = d; e < dim; e++, at++)
      if (at == k) {
        F[d * dim + e] += more;
        if (d != e) F[e * dim + d] += more;
      }
}

/* Returns whether a symmetric F is a stretch, with positive eigenvalues. */
static PetscBool IsStretch(PetscInt dim, const PetscReal F[])
{
  if (!(F[0] > 0 && MPMDet((int)dim, F) > 0)) return PETSC_FALSE;
  return dim < 3 || F[0] * F[4] - F[1] * F[3] > 0;
}

/* Sets r [n] to tau - wanted, of the axes that there are; returns its largest component. */
static PetscReal Residual(PetscInt dim, const MPMMaterial *m, const PetscReal wanted[], MPMMaterialStart *s,
                          PetscReal r[])
{
  PetscReal most = 0;

  if (!IsStretch(dim, s->F)) return PETSC_INFINITY;
  s->J = MPMDet((int)dim, s->F);
  Stress(dim, m, s);
  for (int d = 0, at = 0; d < dim; d++)
    for (int e = d; e < dim; e++, at++) {
      r[at] = s->tau[MPMSymIndex(d, e)] - wanted[MPMSymIndex(d, e)];
      most  = PetscMax(most, PetscAbsReal(r[at]));
    }
  return most;
}

/* Sets F of a law whose stress is a function of it, by Newton's method with differences. A step that would make the
   residual larger is halved. */
static const char *Symmetric(const MPMMaterial *m, PetscInt dim, const PetscReal tau[], MPMMaterialStart *s)
{
  const PetscInt   n    = dim * (dim + 1) / 2;
  const PetscReal  step = 1e-7, enough = 1e-9 * Largest(tau) + ROUNDING * (m->lambda + 2 * m->mu);
  MPMMaterialStart best = *s;
  PetscReal        r[6], size = Residual(dim, m, tau, &best, r);

  for (PetscInt round = 0; round < ROUNDS && size > 0; round++) {
    PetscReal A[6][6], y[6], share = 1, now = PETSC_INFINITY;

    for (PetscInt k = 0; k < n; k++) {
      MPMMaterialStart up = best, down = best;
      PetscReal        ru[6] = {0}, rd[6] = {0};

      AddTo(dim, k, step, up.F);
      AddTo(dim, k, -step, down.F);
      if (Residual(dim, m, tau, &up, ru) > PETSC_MAX_REAL || Residual(dim, m, tau, &down, rd) > PETSC_MAX_REAL)
        return none;
      for (PetscInt i = 0; i < n; i++) A[i][k] = (ru[i] - rd[i]) / (2 * step);
    }
    for (PetscInt k = 0; k < n; k++) y[k] = r[k];
    if (!MPMSolve((int)n, 6, &A[0][0], y)) return none;
    for (PetscInt halved = 0; halved < 20 && !(now < size); halved++, share *= 0.5) {
      *s = best;
      for (PetscInt k = 0; k < n; k++) AddTo(dim, k, -share * y[k], s->F);
      now = Residual(dim, m, tau, s, r);
    }
    if (!(now < size)) break; /* as near as rounding lets it */
    best = *s;
    size = now;
  }
  *s = best;
  (void)Residual(dim, m, tau, s, r);
  return size <= enough ? NULL : none;
}

/* MPMMaterialStressed of bodies of revolution: around the axis is an axis as others are. */
static const char *Round(const MPMMaterial *m, const PetscReal tau[], MPMMaterialStart *s)
{
  MPMMaterial solid = *m;
  const char *why;

  solid.round = PETSC_FALSE;
  why         = MPMMaterialStressed(&solid, 3, PETSC_TRUE, tau, s);
  s->F33      = s->F[8];
  s->F[2]     = s->F[3];
  s->F[3]     = s->F[4];
  return why;
}

const char *MPMMaterialStressed(const MPMMaterial *m, PetscInt dim, PetscBool whole, const PetscReal tau[],
                                MPMMaterialStart *s)
{
  if (m->round) return Round(m, tau, s);
  s->F33 = 1;
  for (PetscInt k = 0; k < dim * dim; k++) s->F[k] = k % (dim + 1) == 0;
  for (int k = 0; k < 6; k++) {
    s->be[k]  = MPMSymUnit(3, k);
    s->tau[k] = 0;
  }
  s->J = 1;
  for (int k = 0; k < 6; k++)
    if (!(PetscAbsReal(tau[k]) <= PETSC_MAX_REAL)) return "which is not finite";
  if (m->type->traits & MPM_FLUID) return Fluid(m, dim, tau, s);
  if (m->state & MPM_BIT(be)) return Elastic(m, dim, whole, tau, s);
  if (!m->type->law->stress[dim - 1]) return none; /* history alone tells it */
  return Symmetric(m, dim, tau, s);
}
