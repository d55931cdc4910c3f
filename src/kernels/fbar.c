/* fbar.c - F-bar: sums over boxes of cells, and what particles take from them. fbar.h has the overview. Like the
   transfers it is compiled once for each number of lanes. */
#include "kernels/fbar.h"
#include "kernels/total.h"

/* --- Boxes -------------------------------------------------------------------------------------------------------- */

/* Returns the sums of the box of a cell, whose base node has this index in the patch's arrays: for each material the
   volume of its particles, and what is averaged times that volume. */
MPM_INLINE PetscReal *BoxOf(int dim, const MPMParams *par, const MPMPatch *patch, PetscInt base)
{
  const int      bits  = __builtin_ctz((unsigned)par->box);
  const PetscInt row   = base / patch->n[0];
  const PetscInt at[3] = {base % patch->n[0], dim > 2 ? row % patch->n[1] : row, dim > 2 ? row / patch->n[1] : 0};
  PetscInt       box   = 0;

  for (int d = dim - 1; d >= 0; d--)
    box = box * ((patch->own_n[d] + par->box - 1) >> bits) + ((at[d] + patch->lo[d] - patch->own_lo[d]) >> bits);
  return patch->boxes + 2 * (size_t)(box * par->nmaterials);
}

/* Adds the volumes V and the amounts of a block's particles to the sums of their boxes. */
MPM_INLINE void AddToBoxes(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                           const MPMStencils *s, const MPMComponent V, const MPMComponent amount)
{
  for (PetscInt c = 0, l = 0; c < o->ncells; c++) {
    PetscReal *box = BoxOf(dim, par, patch, (PetscInt)s->base[l]);

    for (; l < o->end[c]; l++) {
      PetscReal *sum = box + 2 * par->kinds[s->kind[l]].material;

      sum[0] += V[l];
      sum[1] += amount[l];
    }
  }
}

/* Sets the means of a block's particles, each that of its material in its box. */
MPM_INLINE void Means(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                      const MPMStencils *s, MPMComponent mean)
{
  for (PetscInt c = 0, l = 0; c < o->ncells; c++) {
    const PetscReal *box = BoxOf(dim, par, patch, (PetscInt)s->base[l]);

    for (; l < o->end[c]; l++) {
      const PetscReal *sum = box + 2 * par->kinds[s->kind[l]].material;

      mean[l] = sum[1] / sum[0];
    }
  }
  for (PetscInt l = o->n; l < o->lanes; l++) mean[l] = mean[o->n - 1];
}

/* Computes the volume ratios J of a block's particles from the state b, in the total frame those of the motion. */
MPM_INLINE void VolumeRatios(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                             const MPMStencils *s, const MPMBlock *b, MPMComponent J)
{
  const PetscReal *bars = patch->particles.bar;

  MPM_FOR_MATERIALS(m, first, next, par, o->lanes, s->kind)
  for (PetscInt l = first - first % MPM_WIDTH; l < next; l += MPM_WIDTH) {
    MPMReal F[9], ratio = MPMAll(1);

    for (int k = 0; k < dim * dim && (m->state & MPM_BIT(F)); k++) F[k] = MPMRead(&b->F[k][l]);
    if (m->state & MPM_BIT(F))
      ratio = m->round ? MPMDet(dim, F) * MPMRead(&b->F33[0][l]) : MPMDet(dim, F);
    else if (m->state & MPM_BIT(J))
      ratio = MPMRead(&b->J[0][l]);
    MPMWritePart(J + l, ratio, first - l, next - l);
  }
  for (PetscInt l = 0; l < o->lanes && bars; l += MPM_WIDTH) {
    MPMReal bar;

    MPMLoad(1, bars, o, l, &bar);
    MPMWrite(J + l, MPMRead(J + l) * (dim == 2 && !patch->grid->round ? bar * bar : bar * bar * bar));
  }
}

/* --- Volumes ------------------------------------------------------------------------------------------------------ */

/* Returns det(I + dt L) - 1 without the rounding errors of a sum with 1. round: L [4] is the rate around the axis. */
MPM_INLINE MPMReal Growth(int dim, int round, PetscReal dt, const MPMReal *L)
{
  MPMReal trace = L[0], minors = MPMAll(0);

  for (int d = 1; d < dim; d++) trace += L[d * (dim + 1)];
  for (int d = 0; d < dim; d++)
    for (int e = d + 1; e < dim; e++) minors += L[d * (dim + 1)] * L[e * (dim + 1)] - L[d * dim + e] * L[e * dim + d];
  trace += dt * minors;
  if (dim == 3) trace += dt * dt * MPMDet(dim, L);
  return round ? dt * (trace + (1.0 + dt * trace) * L[4]) : dt * trace;
}

/* MPMSumGrowth for one dim. */
MPM_INLINE void SumGrowth(int dim, const MPMParams *par, MPMPatch *patch)
{
  const MPMInterpolateBlocks gradients = MPM_LANES_NAME(
      MPMInterpolateBlock)[dim - 1][MPMBasisNodes(patch->basis) - 2][patch->grid->round ? 3 : 0][1];
  const int      round = dim == 2 && patch->grid->round;
  const MPMRange all   = {0, patch->particles.n, 0};
  MPMBlockOrder  o;
  MPMStencils    s;
  MPMComponent   L[9], V, growth, vr[1];
  MPMBlock       b;

  MPMStencilsBegin(dim, par, patch, &s);
  MPMFirstBlock(1, &all, &o);
  while (MPMNextBlock(dim, patch, 1, &all, &o)) {
    MPMStage(dim, par, patch, &o, &s);
    gradients(&o, &s, patch->n, patch->motion, vr, L);
    if (round) MPMRoundGradient(&o, &s, vr[0], L);
    if (patch->grid->total) MPMRatesTotal(dim, par, patch, &o, L);
    if (patch->particles.F) MPMGather(dim * dim, patch->particles.F, &o, b.F);
    if (patch->particles.F33) MPMGather(1, patch->particles.F33, &o, b.F33);
    if (patch->particles.J) MPMGather(1, patch->particles.J, &o, b.J);
    VolumeRatios(dim, par, patch, &o, &s, &b, V);
    for (PetscInt l = 0; l < o.n; l += MPM_WIDTH) {
      const MPMReal now = MPMRead(&s.V0[l]) * MPMRead(V + l);
      MPMReal       G[9];

      for (int k = 0; k < dim * dim + round; k++) G[k] = MPMRead(&L[k][l]);
      MPMWrite(V + l, now);
      MPMWrite(growth + l, now * Growth(dim, round, par->dt, G));
    }
    AddToBoxes(dim, par, patch, &o, &s, V, growth);
  }
}

/* MPMShareGrowth for one dim. If the mean or the own determinant is not positive, I + dt L becomes 0, in the total
   frame F is infinite, which the check of J finds. */
MPM_INLINE void ShareGrowth(int dim, const MPMParams *par, MPMPatch *patch, const MPMBlockOrder *o,
                            const MPMStencils *s, MPMComponent *L)
{
  const int    round = dim == 2 && patch->grid->round;
  MPMComponent mean; /* determinant less 1 */

  Means(dim, par, patch, o, s, mean);
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
    MPMReal G[9], own, ratio, less; /* the ratio of determinants less 1, then its root less 1 */

    for (int k = 0; k < dim * dim + round; k++) G[k] = MPMRead(&L[k][l]);
    own   = Growth(dim, round, par->dt, G);
    less  = par->lock_share * (MPMRead(mean + l) - own) / (1.0 + own);
    ratio = 1.0 + less;
    if (dim == 2 && !round)
      less = less / (1.0 + MPMSqrt(ratio));
    else {
      const MPMReal root = MPMExp(MPMLog(ratio) / 3.0);

      less = less / (1.0 + root + root * root);
    }
    less = MPMSelect((ratio > 0.0) & (1.0 + own > 0.0), less, MPMAll(-1));
    if (patch->particles.bar) {
      MPMReal bar;

      MPMLoad(1, patch->particles.bar, o, l, &bar);
      bar = bar / (1.0 + less);
      MPMStore(1, &bar, o, l, l, l + MPM_WIDTH, patch->particles.bar);
    }
    if (round) MPMWrite(&L[4][l], (1.0 + less) * G[4] + less / par->dt);
    for (int k = 0; k < dim * dim; k++)
      MPMWrite(&L[k][l], (1.0 + less) * G[k] + (k % (dim + 1) ? MPMAll(0) : less / par->dt));
  }
}

/* --- Pressures ---------------------------------------------------------------------------------------------------- */

/* Returns the mean normal stress on the axes of the grid, and around the axis of a body of revolution. */
MPM_INLINE MPMReal MeanStress(int dim, int round, const MPMBlock *b, PetscInt l)
{
  MPMReal sum = MPMAll(0);

  for (int d = 0; d < dim; d++) sum += MPMRead(&b->tau[MPMSymPart(dim, d, d)][l]);
  return round ? (sum + MPMRead(&b->tau[3][l])) / 3.0 : sum / dim;
}

/* MPMSumPressures for one dim. */
MPM_INLINE void SumPressures(int dim, const MPMParams *par, MPMPatch *patch, PetscInt n, const MPMRange *runs)
{
  MPMBlockOrder o;
  MPMStencils   s;
  MPMComponent  V, p;
  MPMBlock      b;

  MPMStencilsBegin(dim, par, patch, &s);
  memset(&b, 0, sizeof b);
  MPMFirstBlock(n, runs, &o);
  while (MPMNextBlock(dim, patch, n, runs, &o)) {
    MPMStage(dim, par, patch, &o, &s);
    MPMGatherState(dim, par, patch, MPM_MATERIAL_BITS, &o, &s, &b);
    MPM_FOR_MATERIALS(m, first, next, par, o.lanes, s.kind)
    if (!(m->state & MPM_BIT(tau))) MPMLaw(m)->stress[MPMLawForm(m, dim)](m, first, next, &b);
    VolumeRatios(dim, par, patch, &o, &s, &b, V);
    for (PetscInt l = 0; l < o.n; l += MPM_WIDTH) {
      const MPMReal V0 = MPMRead(&s.V0[l]);

      MPMWrite(V + l, V0 * MPMRead(V + l));
      MPMWrite(p + l, V0 * MeanStress(dim, dim == 2 && patch->grid->round, &b, l));
    }
    AddToBoxes(dim, par, patch, &o, &s, V, p);
  }
}

/* MPMSharePressure for one dim. */
MPM_INLINE void SharePressure(int dim, const MPMParams *par, MPMPatch *patch, const MPMBlockOrder *o,
                              const MPMStencils *s, MPMBlock *b)
{
  const int    round = dim == 2 && patch->grid->round;
  MPMComponent mean, J;

  Means(dim, par, patch, o, s, mean);
  VolumeRatios(dim, par, patch, o, s, b, J);
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
    const MPMReal change = par->lock_share * (MPMRead(J + l) * MPMRead(mean + l) - MeanStress(dim, round, b, l));

    for (int d = 0; d < dim; d++) {
      PetscReal *tau = &b->tau[MPMSymPart(dim, d, d)][l];

      MPMWrite(tau, MPMRead(tau) + change);
    }
    if (round) MPMWrite(&b->tau[3][l], MPMRead(&b->tau[3][l]) + change);
  }
}

/* --- Instances ---------------------------------------------------------------------------------------------------- */

/* Defines a function that calls one with dim as a constant; with one dimension there is no F-bar. */
#define MPM_FOR_DIM(Function, parameters, ...)                                                                         \
  void MPM_LANES_NAME(MPM##Function) parameters                                                                        \
  {                                                                                                                    \
    dim == 3 ? Function(3, __VA_ARGS__) : Function(2, __VA_ARGS__);                                                    \
  }
MPM_FOR_DIM(SumGrowth, (int dim, const MPMParams *par, MPMPatch *patch), par, patch)
MPM_FOR_DIM(ShareGrowth,
            (int dim, const MPMParams *par, MPMPatch *patch, const MPMBlockOrder *o, const MPMStencils *s,
             MPMComponent *L),
            par, patch, o, s, L)
MPM_FOR_DIM(SumPressures, (int dim, const MPMParams *par, MPMPatch *patch, PetscInt n, const MPMRange *runs), par,
            patch, n, runs)
MPM_FOR_DIM(SharePressure,
            (int dim, const MPMParams *par, MPMPatch *patch, const MPMBlockOrder *o, const MPMStencils *s, MPMBlock *b),
            par, patch, o, s, b)
