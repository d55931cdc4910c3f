/* g2p.h - the transfer from nodes to particles: velocities and displacements, deformation and material state, and the
   new positions. transfer.h has the overview and the shapes. */
#ifndef MPM_G2P_H
#define MPM_G2P_H

#include "kernels/affine.h"
#include "kernels/p2g.h"
#include "kernels/rare.h"

/* --- Nodes to particles ------------------------------------------------------------------------------------------- */

/* Computes new velocities of a block from vn = sum phi v' and an = sum phi a (8), and displacements dx (9), which may
   have the array of vn; writes the velocities to their rows. With xpic r is the part of the old velocity that
   interpolation to nodes and back does not give, which is dropped; else NULL. */
MPM_INLINE void MPMMove(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                        const PetscReal *r, const MPMComponent *vn, const MPMComponent *an, MPMComponent *dx,
                        MPMReal *v2max)
{
  const PetscReal dt = par->dt, kick = par->kick, flip = par->flip, pic = 1 - par->flip;

  for (PetscInt l = 0; l < o->lanes; l += MPM_WIDTH) {
    MPMReal v[3], drop[3], v2;

    MPMLoad(dim, patch->particles.v, o, l, v);
    if (r) MPMLoad(dim, r, o, l, drop);
    for (int d = 0; d < dim; d++) {
      const MPMReal now = MPMRead(&vn[d][l]), step = kick * MPMRead(&an[d][l]);

      v[d] = r ? v[d] - drop[d] + step : flip * (v[d] + step) + pic * now;
      v2   = d ? v2 + v[d] * v[d] : v[d] * v[d];
      MPMWrite(&dx[d][l], dt * (r ? v[d] : now));
    }
    MPMStore(dim, v, o, l, l, l + MPM_WIDTH, patch->particles.v);
    *v2max = MPMMax(*v2max, v2);
  }
}

/* Updates F of the particles in lanes first .. next-1, eq. (10), in their rows and in b; returns the lanes whose J is not
   a positive number. */
MPM_INLINE MPMMask MPMUpdateF(int dim, const MPMParams *par, const MPMPatch *patch, const MPMBlockOrder *o,
                              PetscInt first, PetscInt next, MPMComponent *L, MPMBlock *b)
{
  MPMMask bad = MPMNone();

  for (PetscInt l = first - first % MPM_WIDTH; l < next; l += MPM_WIDTH) {
    MPMReal F[9], G[9], J;

    MPMLoad(dim * dim, patch->particles.F, o, l, F);
    for (int k = 0; k < dim * dim; k++) G[k] = MPMRead(&L[k][l]);
    MPMDeform(dim, par->dt, G, F);
    for (int k = 0; k < dim * dim; k++) MPMWrite(&b->F[k][l], F[k]);
    MPMStore(dim * dim, F, o, l, first, next, patch->particles.F);
    J = MPMDet(dim, F);
    bad |= MPMBetween(l, first, next) & MPMNot((J > 0.0) & (J < PETSC_MAX_REAL));
  }
  return bad;
}

/* Updates F and material state of a block from its velocity gradients L [dim*dim] in 1/s, eqs. (10) to (12); notes bad
   J and the largest squared wave speed c2max in m^2/s^2. */
MPM_INLINE void MPMUpdateState(int dim, const MPMParams *par, MPMPatch *patch, const MPMBlockOrder *o,
                               const MPMStencils *s, MPMComponent *L, MPMBlock *b, MPMReal *c2max, MPMStatus *status)
{
  const MPMView *particles = &patch->particles;

  MPMGatherState(dim, par, patch, MPM_MATERIAL_BITS & ~MPM_BIT(F), o, s, b);
  MPM_FOR_MATERIALS(m, first, next, par, o->lanes, s->kind)
  {
    const MPMMaterialLaw *law   = MPMLaw(m);
    const PetscBool       has_F = m->state & MPM_BIT(F) ? PETSC_TRUE : PETSC_FALSE;
    const PetscInt        from  = first - first % MPM_WIDTH;
    MPMMask               bad   = MPMNone();
    MPMComponent          c2;

    if (has_F) bad = MPMUpdateF(dim, par, patch, o, first, next, L, b);
    if (law->update[dim - 1]) law->update[dim - 1](m, par->dt, L, first, next, b);
    for (PetscInt l = from; l < next && !has_F; l += MPM_WIDTH) {
      const MPMReal J = MPMRead(&b->J[0][l]);

      bad |= MPMBetween(l, first, next) & MPMNot((J > 0.0) & (J < PETSC_MAX_REAL));
    }
    if (MPMAny(bad)) MPMRareBadJ(dim, patch, has_F, first, PetscMin(next, o->n), o->particle, b, status);
    law->speed2[dim - 1](m, first, next, b, c2);
    for (PetscInt l = from; l < next; l += MPM_WIDTH)
      *c2max = MPMMax(*c2max, MPMSelect(MPMBetween(l, first, next), MPMRead(c2 + l), MPMAll(0)));
#define MPM_SCATTER(name, rows)                                                                                        \
  if (MPM_BIT(name) != MPM_BIT(F) && ((m->state | par->carried) & MPM_BIT(name)))                                      \
    MPMScatter(MPMComponents_##name(dim), b->name, o, first, next, particles->name);
    MPM_MATERIAL_FIELDS(MPM_SCATTER)
#undef MPM_SCATTER
  }
}

/* Commits the displacements, x <- x + dx, and the new cells; counts movers and leavers. A particle surely stays in its
   cell if its distance from the cell's middle, in cells, is below 1/2 by more than rounding errors; others are located,
   and all of a block of which one has left the grid. */
MPM_INLINE void MPMCommit(int dim, const MPMParams *par, MPMPatch *patch, const MPMBlockOrder *o, MPMStencils *s,
                          const MPMComponent *dx, MPMStatus *status)
{
  const MPMGrid  *grid = patch->grid;
  const PetscBool gimp = patch->basis == MPM_BASIS_gimp ? PETSC_TRUE : PETSC_FALSE;
  MPMMask         in   = MPMNot(MPMNone());
  uint64_t        sure = 0; /* a bit for each particle that surely stays in its cell */
  PetscInt        n, which[MPM_STAGED];

  if (patch->particles.l) {
    MPMRareStretch(dim, par, patch, o->n, o->particle, s->x, status);
    MPMGather(dim, patch->particles.l, o, s->l);
  }
  for (PetscInt l = 0; l < o->lanes; l += MPM_WIDTH) {
    MPMMask stays = MPMNot(MPMNone());
    MPMReal x[3];

    for (int d = 0; d < dim; d++) {
      const MPMAxis *axis = &s->axis[d];
      const MPMReal  step = MPMRead(&dx[d][l]);
      MPMReal        off  = MPMFma(step, MPMAll(axis->inverse), MPMRead(&s->at[d][l])) - axis->middle;

      if (gimp) off -= MPMRead(&s->l[d][l]);
      x[d] = MPMRead(&s->x[d][l]) + step;
      MPMWrite(&s->x[d][l], x[d]);
      stays &= MPMAbs(off) < axis->near;
      in &= (x[d] >= axis->lower) & (x[d] < grid->upper[d]);
    }
    sure |= MPMSet(stays, l);
    MPMStore(dim, x, o, l, l, l + MPM_WIDTH, patch->particles.x);
  }
  if (MPMAny(MPMNot(in))) {
    sure = 0;
    MPMRareWrap(dim, grid, o->lanes, s->x);
    MPMScatter(dim, s->x, o, 0, o->lanes, patch->particles.x);
  }
  n = MPMList(~sure, o->n, which);
  if (n) MPMRareCells(dim, par, patch, o->entry - o->n, n, which, o->particle, s, status); /* of one range: its last n */
}

/* Runs the parts of a transfer from nodes to particles: velocities and displacements (8), (9); velocity gradient (3), F
   and material state; new positions; the filter of xpic. */
MPM_INLINE void MPMG2P(int dim, const MPMParams *par, MPMPatch *patch, PetscInt parts, MPMStatus *status)
{
  const int      motion = parts & (MPM_G2P_MOTION | MPM_G2P_FILTER) ? 1 : 0, stress = parts & MPM_G2P_STRESS ? 1 : 0;
  const MPMView *particles               = &patch->particles;
  const MPMRange all                     = {0, particles->n, 0};
  const MPMInterpolateBlocks interpolate = MPM_LANES_NAME(
      MPMInterpolateBlock)[dim - 1][MPMBasisNodes(patch->basis) - 2][motion][stress];
  MPMBlockOrder       o;
  MPMReal             v2 = MPMAll(0), c2 = MPMAll(0);
  MPMComponent        value[6], L[9], r[3];
  MPMComponent *const vn = value, *const an = value + dim,
                      *const dx = vn; /* sum phi v', sum phi a; dx uses the memory of vn */
  MPMStencils                s;
  MPMBlock                   b;

  MPMStencilsBegin(dim, par, patch, &s);
  memset(&b, 0, sizeof b);
  memset(value, 0, sizeof value);
  patch->nmovers = 0;
  MPMFirstBlock(1, &all, &o);
  if (parts & MPM_G2P_FBAR) MPM_LANES_NAME(MPMSumGrowth)(dim, par, patch);
  while (MPMNextBlock(dim, patch, 1, &all, &o)) {
    MPMStage(dim, par, patch, &o, &s);
    if (interpolate) interpolate(&o, &s, patch->n, patch->motion, value, L);
    if (parts & MPM_G2P_FILTER) {
      MPMGather(dim, parts & MPM_RESIDUAL ? particles->r : particles->v, &o, r);
      for (int d = 0; d < dim; d++)
        for (PetscInt l = 0; l < o.n; l += MPM_WIDTH) MPMWrite(&r[d][l], MPMRead(&r[d][l]) - MPMRead(&vn[d][l]));
      MPMScatter(dim, r, &o, 0, o.n, particles->r);
    }
    if (parts & MPM_G2P_MOTION) {
      MPMMove(dim, par, patch, &o, particles->r, vn, an, dx, &v2);
      if (!(parts & MPM_G2P_COMMIT)) MPMScatter(dim, dx, &o, 0, o.lanes, particles->dx);
    }
    if (parts & MPM_G2P_FBAR) MPM_LANES_NAME(MPMShareGrowth)(dim, par, patch, &o, &s, L);
    if (stress) MPMUpdateState(dim, par, patch, &o, &s, L, &b, &c2, status);
    if (parts & MPM_AFFINE) MPMAffine(dim, par, parts, patch, &o, &s, L); /* L is not needed any more */
    if (parts & MPM_G2P_COMMIT) { /* after the new state, which may change the domain */
      if (!motion) MPMGather(dim, particles->dx, &o, dx);
      MPMCommit(dim, par, patch, &o, &s, dx, status);
    }
  }
  status->v2 = PetscMax(status->v2, MPMLargest(v2));
  status->c2 = PetscMax(status->c2, MPMLargest(c2));
}

#endif
