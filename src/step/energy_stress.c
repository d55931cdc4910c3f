/* energy_stress.c - what the stress of the particles does in a step, for the balance of energy (energy.c): its work on
   particles whose law stores only a part of it, what viscosity takes, the dissipation of bodies, and the work over the
   second half of the step, which energy.c compares with that on the nodes. */
#include "kernels/cell.h"
#include "step/energy.h"

PetscBool MPMEnergyLost(const MPMMaterial *m)
{
  return (m->state & MPM_BIT(F)) && !(m->type->traits & MPM_HYPERELASTIC);
}

/* Sets tau [6], Pa, of particle p, in the sequence of MPMSymIndex. */
static void Stress(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p, PetscReal tau[])
{
  MPMBlock b;

  MPMMaterialState(dim, view, p, &b);
  if (!(m->state & MPM_BIT(tau))) m->type->law->stress[MPMLawForm(m, dim)](m, 0, 1, &b);
  for (int k = 0; k < 6; k++) tau[k] = 0;
  for (int k = 0; k < MPM_SYM_NC(dim); k++) tau[MPMSymPlace((int)dim, k)] = b.tau[k][0];
}

static const MPMMaterial *MaterialOf(const MPMCore *core, const MPMView *view, PetscInt p, PetscReal *V0)
{
  const MPMKind *kind = MPMKindOf(core->params.kinds, view, p);

  *V0 = kind->V0;
  return &core->params.materials[kind->material];
}

/* Returns the energy that the law of particle p stores, per reference volume, J/m^3. Of a law that gets hot, the rise
   of its temperature is `theta`, K, if that is not NULL. */
static PetscReal Stored(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p, const PetscReal *theta)
{
  PetscReal W;
  MPMBlock  b;

  MPMMaterialState(dim, view, p, &b);
  if (theta) b.theta[0][0] = *theta;
  m->type->law->energy[MPMLawForm(m, dim)](m, 0, 1, &b, &W);
  return W;
}

/* Copies F, or x of fluids, which have none; and tau of the particles whose law does not store all work. */
void MPMEnergyKeepStress(const MPMCore *core, const MPMView *view, MPMEnergy *e)
{
  const PetscInt dim = core->grid.dim;

  for (PetscInt p = 0; p < view->n; p++) {
    PetscReal         *to = e->stress + p * MPM_STRESS_ROW, V0;
    const MPMMaterial *m  = MaterialOf(core, view, p, &V0);

    if (!e->maps && !MPMEnergyLost(m)) continue;
    if (m->state & MPM_BIT(F)) {
      for (PetscInt k = 0; k < dim * dim; k++) to[k] = view->F[p * dim * dim + k];
      if (m->round) to[8] = view->F33[p]; /* dim is 2 */
    } else
      for (PetscInt d = 0; d < dim; d++) to[d] = view->x[p * dim + d];
    if (!MPMEnergyLost(m)) continue;
    Stress(dim, m, view, p, to + 9);
    if (e->nheat) {
      e->stored[2 * p]     = Stored(dim, m, view, p, NULL);
      e->stored[2 * p + 1] = view->theta ? view->theta[p] : 0;
    }
  }
}

/* Returns the work of a stress tau less that of loads, S or NULL, along f - I, J/m^3, or `after` along I - f^-1, where f =
   F F_before^-1 leads from the state before a step to that after it. */
static PetscReal WorkAlong(int dim, PetscBool after, const PetscReal *was, const PetscReal *F, const PetscReal *F33,
                           const PetscReal tau[], const PetscReal *S)
{
  const PetscReal *from = after ? F : was, *to = after ? was : F;
  PetscReal        cofactor[9], J = MPMDet(dim, from), work = 0; /* J from^-T */

  MPMCofactor(dim, from, cofactor);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      PetscReal f = 0;

      for (int k = 0; k < dim; k++) f += to[d * dim + k] * cofactor[e * dim + k] / J;
      work += (tau[MPMSymIndex(d, e)] - (S ? S[d * dim + e] : 0)) * (f - (d == e));
    }
  if (F33) work += tau[5] * ((after ? was[8] / *F33 : *F33 / was[8]) - 1); /* zz, around the axis */
  return after ? -work : work;
}

/* Sets f [dim*dim] and *f33 to I + dt L of a particle that was at x, by the velocities that the nodes have now. */
static void Deformation(const MPMCore *core, const MPMView *view, PetscInt p, const PetscReal x[], PetscReal f[],
                        PetscReal *f33)
{
  const MPMPatch  *patch = &core->exchange.patch;
  const MPMGrid   *grid  = &core->grid;
  const MPMKind   *kind  = MPMKindOf(core->params.kinds, view, p);
  const int        dim   = (int)grid->dim;
  const PetscReal *l = MPMHalfWidths(dim, core->params.kinds, view, p), dt = core->params.dt;
  PetscReal        w[3][MPM_MAX_STENCIL], g[3][MPM_MAX_STENCIL], xi[3];
  PetscInt         base[3] = {0}, n[3] = {1, 1, 1}, at[3];

  (void)MPMLocate(dim, core->basis, grid, kind->copy, x, l, xi, base);
  for (int d = 0; d < dim; d++) {
    n[d] = MPMBasisNodes(core->basis);
    MPMBasisWeights(core->basis, xi[d], l[d], base[d], grid->cells[d], grid->wall_basis[d], w[d], g[d]);
  }
  for (int k = 0; k < dim * dim; k++) f[k] = k % (dim + 1) == 0;
  *f33 = 1;
  for (at[2] = 0; at[2] < n[2]; at[2]++)
    for (at[1] = 0; at[1] < n[1]; at[1]++)
      for (at[0] = 0; at[0] < n[0]; at[0]++) {
        PetscInt         node = 0;
        const PetscReal *v;

        for (int d = 2; d >= 0; d--) node = node * patch->n[d] + (d < dim ? base[d] + at[d] - patch->lo[d] : 0);
        v = patch->motion + node * MPM_MOTION_NC(dim);
        for (int e = 0; e < dim; e++) {
          PetscReal slope = dt / grid->h[e];

          for (int d = 0; d < dim; d++) slope *= d == e ? g[d][at[d]] : w[d][at[d]];
          for (int d = 0; d < dim; d++) f[d * dim + e] += slope * v[d];
        }
        if (grid->round) *f33 += dt * w[0][at[0]] * w[1][at[1]] * v[0] / x[0];
      }
}

/* Returns what viscosity dissipates in a step per reference volume, J/m^3: |dev tau|^2 dt/(2 viscosity J). */
static PetscReal Viscous(const MPMMaterial *m, PetscReal J, PetscReal dt, const PetscReal tau[])
{
  const PetscReal mean = (tau[0] + tau[3] + tau[5]) / 3;
  PetscReal       size = 0;

  for (int k = 0; k < 6; k++)
    size += k == 0 || k == 3 || k == 5 ? (tau[k] - mean) * (tau[k] - mean) : 2 * tau[k] * tau[k];
  return size * dt / (2 * m->viscosity * J);
}

/* Adds the dissipation of a particle, J, to that of its body, if this is asked for. */
static void AddHeat(const MPMView *view, PetscInt p, PetscReal heat, MPMEnergy *e)
{
  for (PetscInt k = 0; k < e->nheat; k++)
    if (view->id[p] >= e->ids[2 * k] && view->id[p] < e->ids[2 * k + 1]) MPMSumAdd(&e->heat[k], heat);
}

void MPMEnergyAddStress(const MPMCore *core, const MPMView *view, MPMEnergy *e)
{
  const PetscInt dim    = core->grid.dim;
  PetscReal      one[9] = {0}; /* of fluids F begins as I */

  for (PetscInt k = 0; k < dim * dim; k++) one[k] = k % (dim + 1) == 0;
  one[8] = 1;
  for (PetscInt p = 0; p < view->n; p++) {
    PetscReal          tau[6], f[9], f33, V0, half, work;
    const MPMMaterial *m       = MaterialOf(core, view, p, &V0);
    const PetscBool    has_F   = (m->state & MPM_BIT(F)) != 0;
    const PetscBool    viscous = m->type->traits & MPM_FLUID && m->viscosity > 0;
    const PetscReal   *was = e->stress + p * MPM_STRESS_ROW, *F = has_F ? view->F + p * dim * dim : f,
                    *F33 = !m->round ? NULL
                           : has_F   ? view->F33 + p
                                     : &f33;

    if (!viscous && !MPMEnergyLost(m) && !e->maps) continue;
    Stress(dim, m, view, p, tau);
    if (!has_F && e->maps) {
      Deformation(core, view, p, was, f, &f33);
      was = one;
    }
    half = has_F || e->maps ? WorkAlong((int)dim, PETSC_TRUE, was, F, F33, tau, NULL) : 0;
    if (e->maps) {
      const PetscReal *S   = view->S ? view->S + p * dim * dim : NULL;
      const PetscReal  all = 0.5 * V0 * (S ? WorkAlong((int)dim, PETSC_TRUE, was, F, F33, tau, S) : half);

      MPMSumAdd(&e->sum[MPM_ENERGY_mapped], all);
      MPMSumAdd(&e->sum[MPM_ENERGY_half], all);
    }
    if (!viscous && !MPMEnergyLost(m)) continue;
    work = V0 * (viscous ? Viscous(m, view->J[p], core->params.dt, tau)
                         : 0.5 * (WorkAlong((int)dim, PETSC_FALSE, was, F, F33, was + 9, NULL) + half));
    if (e->on) MPMSumAdd(&e->sum[MPM_ENERGY_stress], work);
    if (e->nheat && viscous) AddHeat(view, p, work, e);
    if (e->nheat && !viscous && m->type->law->update[dim - 1]) /* what became heat in the step is no stored energy */
      AddHeat(view, p, work - V0 * (Stored(dim, m, view, p, &e->stored[2 * p + 1]) - e->stored[2 * p]), e);
  }
}

/* What the laws that store only a part of their work gain is taken off the work of their stress, of which the term laws
   is the rest. */
PetscErrorCode MPMEnergyVolumes(MPMCore *core, PetscInt sign)
{
  const PetscInt fields = MPM_MATERIAL_BITS | MPM_BIT(kind);
  MPMSum        *sum    = core->energy.sum;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal          V0, stored;
    const MPMMaterial *m = MaterialOf(core, &view, p, &V0);

    if (!(m->follows > 0)) continue;
    stored = sign * V0 * Stored(core->grid.dim, m, &view, p, NULL);
    MPMSumAdd(&sum[MPM_ENERGY_volumes], stored);
    if (MPMEnergyLost(m)) MPMSumAdd(&sum[MPM_ENERGY_stress], stored);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}
