/* volume.c - the relaxation of the volumes of fluids: what particles give the nodes, and what they take from them.
   volume.h has the overview. Like the transfers it is compiled once for each number of lanes. */
#include "kernels/volume.h"
#include "kernels/stencils.h"

#define OPEN     1.01  /* J of a particle that has come apart from the others, where it carries no tension */
#define CLOSED   1.005 /* largest J of the particles that are in the mean */
#define APART    0.8   /* density below which a particle has come apart */
#define STEEP    0.05  /* slope of the density, a cell, that is not taken for a surface */
#define SHALLOW  1.5 /* depth in cells, by the pressure, up to which a slope is taken for a surface; from twice that */
#define UNSURE   0.004 /* error of the density without a slope */
#define LEAST    -0.1  /* the largest differences from what the density tells that count */
#define MOST     0.25
#define SLOWEST  0.5  /* least factor on J */
#define STIFFEST 0.1  /* least density of a surface */
#define THINNEST 1e-3 /* least 1 + gamma p/K */

/* What a flat surface does to the density, by the basis: how it falls with its slope; and for a slope of 1 the most that
   particles then seem too thin, and too dense. Fitted to half spaces of 2 to 4 particles an axis and cell, at any place
   in the cell and at angles up to 45 degrees. */
static const struct {
  PetscReal fall, thin, dense;
} surface[] = {[MPM_BASIS_linear]   = {0.364, 0.3, 0.22},
               [MPM_BASIS_gimp]     = {0.384, 0.3, 0.22},
               [MPM_BASIS_bspline2] = {0.459, 0.15, 0.1},
               [MPM_BASIS_bspline3] = {0.542, 0.1, 0.05}};

/* --- Particles to nodes ------------------------------------------------------------------------------------------- */

/* Returns the volume ratio of lanes from l on of a material that is no relaxing fluid. */
MPM_INLINE MPMReal Ratio(int dim, const MPMMaterial *m, MPMComponent *F, const MPMComponent J, PetscInt l)
{
  MPMReal lanes[9];

  if (m->state & MPM_BIT(J)) return MPMRead(J + l);
  if (!(m->state & MPM_BIT(F))) return MPMAll(1);
  for (int k = 0; k < dim * dim; k++) lanes[k] = MPMRead(&F[k][l]);
  return MPMDet(dim, lanes);
}

/* Returns the pressure of a fluid over its bulk modulus, with tension without limit; and the J of such a pressure. */
MPM_INLINE MPMReal Pressure(const MPMMaterial *m, MPMReal J)
{
  return m->gamma > 0 ? (MPMExp(-m->gamma * MPMLog(J)) - 1.0) / m->gamma : 1.0 - J;
}

MPM_INLINE MPMReal RatioOf(const MPMMaterial *m, MPMReal p)
{
  return m->gamma > 0 ? MPMExp(MPMLog(MPMMax(MPMAll(THINNEST), 1.0 + m->gamma * p)) / -m->gamma) : 1.0 - p;
}

/* MPMStageVolumes for one dim. */
MPM_INLINE void StageVolumes(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                             const MPMStencils *s, MPMRecords *r)
{
  const MPMView *particles = &patch->particles;
  MPMComponent   J, F[9], b[3], Q[3], A[3];

  if (particles->J) MPMGather(1, particles->J, o, &J);
  if (particles->F) MPMGather(dim * dim, particles->F, o, F);
  if (particles->b) MPMGather(dim, particles->b, o, b);
  MPM_FOR_MATERIALS(m, first, next, par, o->lanes, s->kind)
  for (PetscInt l = first - first % MPM_WIDTH; l < next; l += MPM_WIDTH) {
    MPMReal V = MPMRead(&s->V0[l]), k = MPMAll(0), pressure = MPMAll(0), slope[3];

    for (int d = 0; d < dim; d++) slope[d] = MPMAll(0);
    if (m->follows > 0) {
      const MPMReal ratio = MPMRead(J + l);

      k        = MPMSelect(ratio <= CLOSED, V / m->K, MPMAll(0));
      pressure = k * m->K * ratio * Pressure(m, ratio);
      for (int d = 0; d < dim; d++) {
        const MPMReal g = particles->b ? par->gravity[d] + MPMRead(&b[d][l]) : MPMAll(par->gravity[d]);

        slope[d] = k * (m->rho * patch->grid->h[d]) * g;
        pressure -= slope[d] * MPMRead(&s->at[d][l]);
      }
    } else
      V *= Ratio(dim, m, F, J, l);
    MPMWritePart(&Q[0][l], V, first - l, next - l);
    MPMWritePart(&Q[1][l], k, first - l, next - l);
    MPMWritePart(&Q[2][l], pressure, first - l, next - l);
    for (int d = 0; d < dim; d++) MPMWritePart(&A[d][l], slope[d], first - l, next - l);
  }
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
    const MPMReal all[4] = {MPMRead(&Q[0][l]), MPMRead(&Q[1][l]), MPMRead(&Q[2][l]), MPMAll(0)};

    MPMWriteRecords(4, all, r->Q[l][0], MPM_Q_RECORDS);
    for (int d = 0; d < dim; d++) {
      const MPMReal affine[4] = {MPMAll(0), MPMAll(0), MPMRead(&A[d][l]), MPMAll(0)};

      MPMWriteRecords(4, affine, r->A[l][d], MPM_A_RECORDS);
    }
  }
}

/* --- Nodes to particles ------------------------------------------------------------------------------------------- */

/* Returns the length of a gradient times the cell sizes. */
MPM_INLINE MPMReal Length(int dim, const PetscReal h[], const MPMComponent *gradient, PetscInt l)
{
  MPMReal sum = MPMAll(0);

  for (int d = 0; d < dim; d++) sum += h[d] * h[d] * MPMRead(&gradient[d][l]) * MPMRead(&gradient[d][l]);
  return MPMSqrt(sum);
}

/* Returns how dense a fluid is at lanes from l on, 1 at rest, from how full the nodes are: less than full towards a
   surface, which the slope of the density tells from a void. At depth there is no surface. *slope is the change of the
   density a cell. */
MPM_INLINE MPMReal Density(int dim, const MPMParams *par, const MPMPatch *patch, const MPMMaterial *m,
                           const MPMComponent *value, const MPMComponent *gradient, PetscInt l, MPMReal *slope)
{
  const PetscReal *h    = patch->grid->h;
  const MPMReal    full = MPMRead(&value[0][l]), p = MPMRead(&value[1][l]);
  PetscReal        g2 = 0;
  MPMReal          cell, depth; /* change of the pressure over a cell */

  for (int d = 0; d < dim; d++) g2 += PetscSqr(h[d] * par->gravity[d]);
  cell   = MPMMax(MPMAll(m->rho * PetscSqrtReal(g2)), dim > 1 ? Length(dim, h, gradient + dim, l) : MPMAbs(p));
  cell   = MPMMax(cell, 1e-3 * MPMAbs(p) + PETSC_MIN_REAL);
  depth  = p / (SHALLOW * cell);
  *slope = Length(dim, h, gradient, l) / full;
  depth  = MPMMin(MPMAll(1), MPMMax(MPMAll(0), 2.0 - depth)); /* 1 at a surface, 0 at depth */
  return full / MPMMax(MPMAll(STIFFEST), 1.0 - surface[patch->basis].fall * depth * MPMMax(MPMAll(0), *slope - STEEP));
}

/* MPMRelaxVolumes for one dim. */
MPM_INLINE void RelaxVolumes(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                             const MPMStencils *s, const MPMComponent *value, const MPMComponent *gradient)
{
  const MPMView *particles = &patch->particles;
  uint64_t       apart     = 0;
  PetscInt       n, which[MPM_STAGED];
  MPMComponent   J;

  if (!particles->J) return;
  MPMGather(1, particles->J, o, &J);
  MPM_FOR_MATERIALS(m, first, next, par, o->lanes, s->kind)
  {
    for (PetscInt l = first - first % MPM_WIDTH; l < next && m->follows > 0; l += MPM_WIDTH) {
      const MPMMask mine = MPMBetween(l, first, next);
      const MPMReal was = MPMRead(J + l), mean = RatioOf(m, MPMRead(&value[1][l]) / (m->K * was));
      MPMReal       slope, thin, dense, now, r = Density(dim, par, patch, m, value, gradient, l, &slope);

      thin  = 1.0 / r - MPMMax(mean, MPMAll(1)) - (UNSURE + surface[patch->basis].thin * slope);
      dense = 1.0 / r - MPMMin(mean, MPMAll(1)) + (UNSURE + surface[patch->basis].dense * slope);
      thin  = MPMMax(MPMAll(0), MPMMin(thin, MPMAll(MOST)));
      dense = MPMMin(MPMAll(0), MPMMax(dense, MPMAll(LEAST)));
      now   = MPMMax(SLOWEST * was, was + m->follows * (mean - was + par->push * (thin + dense)));
      now   = MPMSelect(r < APART, MPMAll(m->tension == 0 ? OPEN : 1), now);
      apart |= MPMSet(mine & (r < APART), l);
      MPMWritePart(J + l, now, first - l, next - l);
    }
    if (m->follows > 0) MPMScatter(1, &J, o, first, PetscMin(next, o->n), particles->J);
  }
  n = particles->C ? MPMList(apart, o->n, which) : 0; /* alone, a particle would keep an affine velocity for ever */
  for (PetscInt k = 0; k < n; k++)
    for (int c = 0; c < dim * dim; c++) particles->C[(size_t)o->particle[which[k]] * (size_t)(dim * dim) + c] = 0;
}

/* --- Instances ---------------------------------------------------------------------------------------------------- */

/* Defines a function that calls one with dim as a constant. */
#define MPM_FOR_DIM(Function, parameters, ...)                                                                         \
  void MPM_LANES_NAME(MPM##Function) parameters                                                                        \
  {                                                                                                                    \
    dim == 3 ? Function(3, __VA_ARGS__) : dim == 2 ? Function(2, __VA_ARGS__) : Function(1, __VA_ARGS__);              \
  }
MPM_FOR_DIM(StageVolumes,
            (int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o, const MPMStencils *s,
             MPMRecords *r),
            par, patch, o, s, r)
MPM_FOR_DIM(RelaxVolumes,
            (int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o, const MPMStencils *s,
             const MPMComponent *value, const MPMComponent *gradient),
            par, patch, o, s, value, gradient)
