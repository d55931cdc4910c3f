/* volume.c - the relaxation of volumes: what particles give the nodes, and what they take from them. volume.h has the
   overview. Like the transfers it is compiled once for each number of lanes. */
#include "kernels/volume.h"

#define OPEN      0.01 /* volume strain of a fluid that has come apart, if it carries no tension; LOOSE: of sand */
#define LOOSE     0.05
#define CLOSED    0.005 /* largest volume strain of the particles that are in the mean */
#define APART     0.8   /* density below which a particle has come apart */
#define STEEP     0.05  /* slope of the density, a cell, that is not taken for a surface */
#define SHALLOW   1.5 /* depth by the pressure, cells, up to which a slope is taken for a surface; not at twice that */
#define UNSURE    0.004 /* error of the density without a slope */
#define LEAST     -0.1  /* the largest differences from what the density tells that count */
#define MOST      0.02
#define MOST_SAND 0.25     /* of sand */
#define STILL     0.05     /* noise of the pressure that is left, of rho g h, so that what rests stays at rest */
#define ON_FACE   0.05     /* cells: what is nearer to a face of the grid is taken to lie on it */
#define SLOWEST   0.5      /* least factor on J of a fluid */
#define THINNEST  1e-3     /* least 1 + gamma p/K of a fluid */
#define FAINTEST  0.1      /* least density of a surface */
#define WEIGHT    (2. / 3) /* change of the mean stress of sand with depth, of rho g */
#define SEEN      0.2      /* share of open sand near by above which sand relaxes; fully from twice that on */
#define PRESSED   5.       /* weights of a cell's height: sand with more mean pressure is confined */
#define SAND      20.      /* sand follows the density so many times as fast as a fluid */

/* What a flat surface does to the density, by the basis: how it falls with its slope; and for a slope of 1 the most
   that particles then seem too thin, and too dense. Fitted to half spaces of 2 to 4 particles an axis and cell, at any
   place in the cell and at angles up to 45 degrees. */
static const struct {
  PetscReal fall, thin, dense;
} surface[] = {[MPM_BASIS_linear]   = {0.364, 0.6, 0.22},
               [MPM_BASIS_gimp]     = {0.384, 0.6, 0.22},
               [MPM_BASIS_bspline2] = {0.459, 0.2, 0.1},
               [MPM_BASIS_bspline3] = {0.542, 0.1, 0.05}};

/* --- Particles to nodes ------------------------------------------------------------------------------------------- */

/* Returns whether a material is sand, whose opened volume closes again before it has pressure. */
MPM_INLINE PetscBool IsSand(const MPMMaterial *m)
{
  return m->state & MPM_BIT(vc) ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the bulk modulus in Pa. */
MPM_INLINE PetscReal Modulus(const MPMMaterial *m)
{
  return IsSand(m) ? m->lambda + 2 * m->mu / 3 : m->K;
}

/* Returns the logarithmic volume strain of sand, elastic and opened, from its Kirchhoff stress [MPM_SYM_NC]. */
MPM_INLINE MPMReal Strain(int dim, const MPMMaterial *m, const MPMReal *tau, MPMReal vc)
{
  MPMReal trace = MPMAll(0);

  for (int k = 0; k < MPM_SYM_NC(dim); k++)
    if (MPMSymUnit(dim, k)) trace += tau[k];
  return trace / (3 * Modulus(m)) + MPMMax(MPMAll(0), vc);
}

/* Returns the volume ratio of lanes from l on of a material that does not relax. */
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

/* What a particle gives the nodes: numbers of their record, and the change of number 2 along each axis, a cell. */
typedef struct {
  MPMReal number[MPM_VOLUME_SUMS], slope[3];
} Given;

/* Sets what a fluid gives at lanes from l on; gravity [dim] in m/s^2. */
MPM_INLINE void GiveFluid(int dim, const MPMMaterial *m, const MPMGrid *grid, const MPMReal gravity[], MPMReal J,
                          Given *to)
{
  const MPMReal k = MPMSelect(J <= 1 + CLOSED, to->number[0] / m->K, MPMAll(0));

  to->number[1] = k;
  to->number[2] = k * m->K * J * Pressure(m, J);
  for (int d = 0; d < dim; d++) to->slope[d] = k * (m->rho * grid->h[d]) * gravity[d];
}

/* Sets what sand gives. */
MPM_INLINE void GiveSand(int dim, const MPMMaterial *m, const MPMGrid *grid, const MPMReal gravity[],
                         const MPMReal *tau, MPMReal vc, Given *to)
{
  const MPMReal strain = Strain(dim, m, tau, vc), V0 = to->number[0];
  const MPMReal k = MPMSelect(strain <= CLOSED, V0 / Modulus(m), MPMAll(0));

  to->number[1] = k;
  to->number[2] = -k * Modulus(m) * strain;
  to->number[3] = MPMSelect(vc > MPM_OPENED, V0, MPMAll(0));
  for (int d = 0; d < dim; d++) to->slope[d] = k * (WEIGHT * m->rho * grid->h[d]) * gravity[d];
}

/* Returns which share of the matter of lanes from l on is inside the grid: half of that of a particle on a face. */
MPM_INLINE MPMReal Inside(int dim, const MPMGrid *grid, const MPMStencils *s, PetscInt l)
{
  MPMReal share = MPMAll(1);

  for (int d = 0; d < dim; d++) {
    const MPMReal x = MPMRead(&s->x[d][l]);

    if (grid->periodic[d]) continue;
    share *= 0.5 + 0.5 / (ON_FACE * grid->h[d]) *
                       MPMMin(MPMAll(ON_FACE * grid->h[d]),
                              MPMMax(MPMAll(0), MPMMin(x - grid->lower[d], grid->upper[d] - x)));
  }
  return share;
}

/* MPMStageVolumes for one dim. */
MPM_INLINE void StageVolumes(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                             const MPMStencils *s, MPMRecords *r)
{
  const MPMView *particles = &patch->particles;
  MPMComponent   J, F[9], b[3], tau[6], vc, number[MPM_VOLUME_SUMS], slope[3];

  if (particles->J) MPMGather(1, particles->J, o, &J);
  if (particles->F) MPMGather(dim * dim, particles->F, o, F);
  if (particles->b) MPMGather(dim, particles->b, o, b);
  if (particles->tau) MPMGather(MPM_SYM_NC(dim), particles->tau, o, tau);
  if (particles->vc) MPMGather(1, particles->vc, o, &vc);
  MPM_FOR_MATERIALS(m, first, next, par, o->lanes, s->kind)
  for (PetscInt l = first - first % MPM_WIDTH; l < next; l += MPM_WIDTH) {
    MPMReal gravity[3], stress[6];
    Given   to = {.number = {MPMRead(&s->V0[l]) * Inside(dim, patch->grid, s, l), MPMAll(0), MPMAll(0), MPMAll(0)},
                  .slope  = {MPMAll(0), MPMAll(0), MPMAll(0)}};

    for (int d = 0; d < dim; d++)
      gravity[d] = particles->b ? par->gravity[d] + MPMRead(&b[d][l]) : MPMAll(par->gravity[d]);
    for (int k = 0; k < MPM_SYM_NC(dim) && m->follows > 0 && IsSand(m); k++) stress[k] = MPMRead(&tau[k][l]);
    if (!(m->follows > 0))
      to.number[0] *= Ratio(dim, m, F, J, l);
    else if (IsSand(m))
      GiveSand(dim, m, patch->grid, gravity, stress, MPMRead(vc + l), &to);
    else
      GiveFluid(dim, m, patch->grid, gravity, MPMRead(J + l), &to);
    for (int d = 0; d < dim; d++) to.number[2] -= to.slope[d] * MPMRead(&s->at[d][l]);
    for (int c = 0; c < MPM_VOLUME_SUMS; c++) MPMWritePart(&number[c][l], to.number[c], first - l, next - l);
    for (int d = 0; d < dim; d++) MPMWritePart(&slope[d][l], to.slope[d], first - l, next - l);
  }
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
    MPMReal all[MPM_VOLUME_SUMS];

    for (int c = 0; c < MPM_VOLUME_SUMS; c++) all[c] = MPMRead(&number[c][l]);
    MPMWriteRecords(MPM_VOLUME_SUMS, all, r->Q[l][0], MPM_Q_RECORDS);
    for (int d = 0; d < dim; d++) {
      const MPMReal affine[MPM_VOLUME_SUMS] = {MPMAll(0), MPMAll(0), MPMRead(&slope[d][l]), MPMAll(0)};

      MPMWriteRecords(MPM_VOLUME_SUMS, affine, r->A[l][d], MPM_A_RECORDS);
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

/* Returns the uniform spline of a basis at a distance from its node, cells. */
MPM_INLINE MPMReal Uniform(MPMBasis basis, MPMReal t)
{
  const MPMReal outer = MPMMax(MPMAll(0), (basis == MPM_BASIS_bspline2 ? 1.5 : 2.) - MPMAbs(t));
  const MPMReal inner = MPMMax(MPMAll(0), outer - 1.0);

  return basis == MPM_BASIS_bspline2 ? (outer * outer - 3.0 * inner * inner) / 2
                                     : (outer * outer * outer - 4.0 * inner * inner * inner) / 6;
}

/* Returns by how much a full lattice seems too dense at lanes from l on near walls: there the sum of an extrapolated
   spline over particles of width s differs from its integral by s^2/24 times its slope at the wall, -1 and 1 of its two
   nodes. */
MPM_INLINE MPMReal Lattice(int dim, const MPMPatch *patch, const MPMStencils *s, PetscInt l)
{
  const MPMGrid *grid  = patch->grid;
  const MPMBasis basis = patch->basis;
  MPMReal        sum = MPMAll(0), width2 = MPMRead(&s->V0[l]);

  for (int d = 0; d < dim; d++) width2 = width2 / grid->h[d];
  width2 = dim == 1 ? width2 * width2 : dim == 2 ? width2 : MPMExp(2. / 3 * MPMLog(width2));
  for (int d = 0; d < dim; d++) {
    const MPMReal x = MPMRead(&s->x[d][l]);

    if (grid->periodic[d] || !MPMBasisIsSpline(basis) || grid->wall_basis[d] != MPM_WALL_BASIS_EXTRAP) continue;
    for (int side = 0; side < 2; side++) {
      const MPMReal t      = (side ? grid->upper[d] - x : x - grid->lower[d]) / grid->h[d];
      const MPMReal beyond = Uniform(basis, t + 1.0);

      sum += (Uniform(basis, t - 1.0) - beyond) / MPMBasisIntegral(basis, 1, grid->cells[d], grid->wall_basis[d]) -
             (Uniform(basis, t) + 2.0 * beyond) / MPMBasisIntegral(basis, 0, grid->cells[d], grid->wall_basis[d]);
    }
  }
  return sum * width2 / 24;
}

/* Returns the weight of a cell's height of a material, Pa. */
MPM_INLINE PetscReal CellWeight(int dim, const MPMParams *par, const MPMPatch *patch, const MPMMaterial *m)
{
  PetscReal g2 = 0;

  for (int d = 0; d < dim; d++) g2 += PetscSqr(patch->grid->h[d] * par->gravity[d]);
  return m->rho * PetscSqrtReal(g2);
}

/* Returns how dense a fluid is at lanes from l on, 1 at rest, from how full the nodes are: less than full towards a
   surface, which the slope of the density tells from a void. At depth there is no surface. *slope is the change of the
   density a cell, *faint what a slope that is not taken for a surface may be of one. */
MPM_INLINE MPMReal Density(int dim, const MPMParams *par, const MPMPatch *patch, const MPMStencils *s,
                           const MPMMaterial *m, const MPMComponent *value, const MPMComponent *gradient, PetscInt l,
                           MPMReal *slope, MPMReal *faint)
{
  const PetscReal *h    = patch->grid->h;
  const MPMReal    full = MPMRead(&value[0][l]) / (1.0 + Lattice(dim, patch, s, l)), p = MPMRead(&value[1][l]);
  MPMReal          cell, depth; /* change of the pressure over a cell */

  cell   = MPMMax(MPMAll(CellWeight(dim, par, patch, m)), dim > 1 ? Length(dim, h, gradient + dim, l) : MPMAbs(p));
  cell   = MPMMax(cell, 1e-3 * MPMAbs(p) + PETSC_MIN_REAL);
  depth  = p / (SHALLOW * cell);
  *slope = Length(dim, h, gradient, l) / full;
  depth  = MPMMin(MPMAll(1), MPMMax(MPMAll(0), 2.0 - depth)); /* 1 at a surface, 0 at depth */
  *faint = surface[patch->basis].fall * MPMMax(MPMAll(0), MPMMin(*slope, 2 * STEEP - *slope));
  return full / MPMMax(MPMAll(FAINTEST), 1.0 - surface[patch->basis].fall * depth * MPMMax(MPMAll(0), *slope - STEEP));
}

/* Returns the difference of the volume ratio that the density tells from that of the mean, as far as it is sure: 0 as
   well where the density is that of the reference volume, at which bodies begin with pressure. Sets in *apart the lanes
   that have come apart from the others. */
MPM_INLINE MPMReal Mismatch(int dim, const MPMParams *par, const MPMPatch *patch, const MPMStencils *s,
                            const MPMMaterial *m, const MPMComponent *value, const MPMComponent *gradient, PetscInt l,
                            MPMReal mean, MPMMask *apart)
{
  MPMReal         slope, faint;
  const PetscReal most   = IsSand(m) ? MOST_SAND : MOST;
  const MPMReal   r      = Density(dim, par, patch, s, m, value, gradient, l, &slope, &faint);
  const MPMReal   unsure = UNSURE + surface[patch->basis].thin * slope + (IsSand(m) ? MPMAll(0) : faint);
  const MPMReal   thin   = 1.0 / r - MPMMax(mean, MPMAll(1)) - unsure;
  const MPMReal   dense  = 1.0 / r - MPMMin(mean, MPMAll(1)) + (UNSURE + surface[patch->basis].dense * slope);

  *apart = r < APART;
  return MPMMax(MPMAll(0), MPMMin(thin, MPMAll(most))) + MPMMin(MPMAll(0), MPMMax(dense, MPMAll(LEAST)));
}

/* Relaxes particles first .. next-1 of a block, of a fluid; returns those that have come apart, a bit for each. */
MPM_INLINE uint64_t RelaxFluid(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                               const MPMStencils *s, const MPMMaterial *m, PetscInt first, PetscInt next,
                               const MPMComponent *value, const MPMComponent *gradient)
{
  const PetscReal still = STILL / m->K * CellWeight(dim, par, patch, m);
  uint64_t        set   = 0;

  for (PetscInt l = first - first % MPM_WIDTH; l < PetscMin(next, o->n); l += MPM_WIDTH) {
    MPMReal was, mean, now;
    MPMMask apart;

    MPMLoad(1, patch->particles.J, o, l, &was);
    mean = RatioOf(m, MPMRead(&value[1][l]) / (m->K * was));
    now  = mean + par->push * Mismatch(dim, par, patch, s, m, value, gradient, l, mean, &apart);
    now  = MPMSelect(MPMAbs(mean - was) > still, now, now - (mean - was));
    now  = MPMMax(SLOWEST * was, was + m->follows * (now - was));
    now  = MPMSelect(apart, MPMAll(m->tension == 0 ? 1 + OPEN : 1), now);
    set |= MPMSet(apart & MPMBetween(l, first, next), l);
    MPMStore(1, &now, o, l, first, PetscMin(next, o->n), patch->particles.J);
  }
  return set;
}

/* Gives lanes from l on of sand the volume strain `to` where `acts`: above that of the apex what is open, without
   deviator. F and J take the same change. */
MPM_INLINE void SetStrain(int dim, const MPMMaterial *m, const MPMView *particles, const MPMBlockOrder *o, PetscInt l,
                          PetscInt first, PetscInt last, MPMMask acts, MPMReal to)
{
  const PetscReal apex = m->cohesion / (3 * Modulus(m));
  const int       nc   = MPM_SYM_NC(dim);
  MPMReal         tau[6], be[6], all[9], vc, change, growth;
  MPMMask         open;

  MPMLoad(nc, particles->tau, o, l, tau);
  MPMLoad(nc, particles->be, o, l, be);
  MPMLoad(1, particles->vc, o, l, &vc);
  growth = MPMSelect(acts, to - Strain(dim, m, tau, vc), MPMAll(0));
  change = MPMSelect(acts, growth + MPMMax(MPMAll(0), vc), MPMAll(0)); /* of the elastic strain, if it closes */
  open   = acts & (to >= apex);
  vc     = MPMSelect(open, to - apex, MPMSelect(acts, MPMAll(0), vc));
  for (int k = 0; k < nc; k++) {
    const PetscReal unit = MPMSymUnit(dim, k);

    be[k]  = MPMSelect(open, MPMAll(unit * PetscExpReal(2 * apex / 3)), be[k] * MPMExp(2.0 / 3 * change));
    tau[k] = MPMSelect(open, MPMAll(unit * Modulus(m) * apex), tau[k] + unit * Modulus(m) * change);
  }
  MPMStore(nc, tau, o, l, first, last, particles->tau);
  MPMStore(nc, be, o, l, first, last, particles->be);
  MPMStore(1, &vc, o, l, first, last, particles->vc);
  if (m->state & MPM_BIT(J)) {
    MPMLoad(1, particles->J, o, l, all);
    all[0] *= MPMExp(growth);
    MPMStore(1, all, o, l, first, last, particles->J);
  } else {
    MPMLoad(dim * dim, particles->F, o, l, all);
    for (int k = 0; k < dim * dim; k++) all[k] *= MPMExp(growth / dim);
    MPMStore(dim * dim, all, o, l, first, last, particles->F);
  }
}

/* Relaxes particles first .. next-1 of a block, of sand, near open sand; returns those that have come apart. What is
   pressed, as under a footing whose edge opens the sand beside it, is left alone: the mean of both would take its
   pressure away, and beside a rigid body, which the density leaves out, it seems too thin. */
MPM_INLINE uint64_t RelaxSand(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                              const MPMStencils *s, const MPMMaterial *m, PetscInt first, PetscInt next,
                              const MPMComponent *value, const MPMComponent *gradient)
{
  const PetscReal limit = PRESSED * CellWeight(dim, par, patch, m);
  uint64_t        set   = 0;

  for (PetscInt l = first - first % MPM_WIDTH; l < PetscMin(next, o->n); l += MPM_WIDTH) {
    const MPMReal share = m->follows * MPMMin(MPMAll(1), MPMRead(&value[2][l]) / SEEN - 1.0);
    const MPMMask acts = (MPMRead(&value[2][l]) > SEEN) & (MPMRead(&value[1][l]) <= limit) & MPMBetween(l, first, next);
    MPMReal       tau[6], vc, was, mean, now;
    MPMMask       apart;

    if (!MPMAny(acts)) continue;
    MPMLoad(MPM_SYM_NC(dim), patch->particles.tau, o, l, tau);
    MPMLoad(1, patch->particles.vc, o, l, &vc);
    was  = Strain(dim, m, tau, vc);
    mean = -1.0 * MPMRead(&value[1][l]) / Modulus(m);
    now  = mean + SAND * par->push * Mismatch(dim, par, patch, s, m, value, gradient, l, 1.0 + mean, &apart);
    now  = MPMSelect(apart, MPMAll(LOOSE), was + share * (now - was));
    set |= MPMSet(acts & apart, l);
    SetStrain(dim, m, &patch->particles, o, l, first, PetscMin(next, o->n), acts, now);
  }
  return set;
}

/* MPMRelaxVolumes for one dim. */
MPM_INLINE void RelaxVolumes(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                             const MPMStencils *s, const MPMComponent *value, const MPMComponent *gradient)
{
  PetscReal *C     = patch->particles.C;
  uint64_t   apart = 0;
  PetscInt   n, which[MPM_STAGED];

  MPM_FOR_MATERIALS(m, first, next, par, o->lanes, s->kind)
  {
    if (m->follows > 0 && IsSand(m)) apart |= RelaxSand(dim, par, patch, o, s, m, first, next, value, gradient);
    if (m->follows > 0 && !IsSand(m)) apart |= RelaxFluid(dim, par, patch, o, s, m, first, next, value, gradient);
  }
  n = C ? MPMList(apart, o->n, which) : 0; /* alone, a particle would keep an affine velocity for ever */
  for (PetscInt k = 0; k < n; k++)
    for (int c = 0; c < dim * dim; c++) C[(size_t)o->particle[which[k]] * (size_t)(dim * dim) + (size_t)c] = 0;
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
