/* g2p.h - the transfer from nodes to particles: velocities and displacements, deformation and material state, and the
   new positions. transfer.h has the overview and the shapes. */
#ifndef MPM_G2P_H
#define MPM_G2P_H

#include "kernels/affine.h"
#include "kernels/p2g.h"
#include "kernels/rare.h"

/* --- Nodes to particles ------------------------------------------------------------------------------------------- */

/* What G2P finds: in all blocks, and in one. */
typedef struct {
  MPMReal  v2, c2;  /* the largest squared velocities and wave speeds, in m^2/s^2 */
  MPMMask  bad, in; /* lanes whose J is not a positive number; lanes whose new positions are all in the grid */
  MPMMask  opened;  /* lanes of sand that relaxes and is open */
  uint64_t sure;    /* a bit for each particle that surely stays in its cell */
} MPMFound;

/* Computes the half-widths, in cells, of a vector of stretched domains (cpGIMP), for their rows and s: the kind's times
   the diagonal of V = sqrt(F F^T). Unlike that of F, it is unchanged by a rotation before the deformation, and rotates
   with the material. Notes too wide domains, whose stencils would have too few nodes, at their positions before the
   step, which the rows of x still have; their half-width becomes 1/2. */
static __attribute__((noinline)) void MPMStretchDomains(int dim, const MPMParams *par, const MPMView *particles,
                                                        const MPMBlockOrder *o, PetscInt first, MPMStencils *s,
                                                        MPMStatus *status)
{
  MPMReal F[9], l[3];

  MPMLoad(dim * dim, particles->F, o, first, F);
  MPMStretch(dim, F, l);
  for (int d = 0; d < dim; d++) {
    PetscReal own[MPM_WIDTH];

    for (int i = 0; i < MPM_WIDTH; i++) own[i] = par->kinds[s->kind[first + i]].l[d];
    l[d] *= MPMRead(own);
    MPMWrite(&s->l[d][first], l[d]);
    for (PetscInt q = first; MPMAny(MPMNot(l[d] <= 0.5)) && q < PetscMin(first + MPM_WIDTH, o->n); q++)
      if (!(s->l[d][q] <= 0.5))
        MPMStatusNote(status, MPM_TOO_WIDE, particles->id[o->particle[q]], dim,
                      particles->x + (size_t)o->particle[q] * (size_t)dim, 2 * s->l[d][q]);
    l[d] = MPMSelect(l[d] <= 0.5, l[d], MPMAll(0.5));
    MPMWrite(&s->l[d][first], l[d]);
  }
  MPMStore(dim, l, o, first, first, first + MPM_WIDTH, particles->l);
}

/* Moves and deforms the particles of a block, a vector at a time, from vn = sum phi v', an = sum phi a and the velocity
   gradients L [dim*dim] in 1/s: velocities (8), displacements dx (9), F (10), and new positions x + dx. They go to
   their rows, F also to b, dx only if positions come in a later phase, which reads it from there; s keeps the old
   positions and gets the new half-widths. state has the fields (bits) of the block's laws. With xpic, r of particles is
   the part of the old velocity that interpolation to nodes and back does not give, which is dropped. A particle surely
   stays in its cell if its distance from the cell's middle, in cells, is below 1/2 by more than rounding errors. */
MPM_INLINE void MPMMoveBlock(int dim, const MPMParams *par, MPMPatch *patch, PetscInt parts, PetscInt state,
                             const MPMBlockOrder *o, const MPMComponent *vn, const MPMComponent *an,
                             const MPMComponent *L, MPMStencils *s, MPMBlock *b, MPMFound *found, MPMStatus *status)
{
  const MPMView  *particles = &patch->particles;
  const PetscReal dt = par->dt, kick = par->kick, flip = par->flip, pic = 1 - par->flip;
  MPMMask         bad = MPMNone(), in = MPMNot(MPMNone());
  uint64_t        sure = 0;

  for (PetscInt l = 0; l < o->lanes; l += MPM_WIDTH) {
    MPMReal dx[3] = {MPMAll(0), MPMAll(0), MPMAll(0)};

    if (parts & MPM_G2P_MOTION) {
      MPMReal v[3], drop[3], v2 = MPMAll(0);

      MPMLoad(dim, particles->v, o, l, v);
      if (particles->r) MPMLoad(dim, particles->r, o, l, drop);
      for (int d = 0; d < dim; d++) {
        const MPMReal now = MPMRead(&vn[d][l]), gain = kick * MPMRead(&an[d][l]);

        v[d]  = particles->r ? v[d] - drop[d] + gain : flip * (v[d] + gain) + pic * now;
        dx[d] = dt * (particles->r ? v[d] : now);
        v2    = d ? v2 + v[d] * v[d] : v[d] * v[d];
      }
      MPMStore(dim, v, o, l, l, l + MPM_WIDTH, particles->v);
      if (!(parts & MPM_G2P_COMMIT)) MPMStore(dim, dx, o, l, l, l + MPM_WIDTH, particles->dx);
      found->v2 = MPMMax(found->v2, v2);
    } else if (parts & MPM_G2P_COMMIT)
      MPMLoad(dim, particles->dx, o, l, dx);
    if (state & MPM_BIT(F)) {
      MPMReal F[9], G[9], J;

      MPMLoad(dim * dim, particles->F, o, l, F);
      for (int k = 0; k < dim * dim; k++) {
        G[k] = MPMRead(&L[k][l]);
        if (par->nmaterials > 1) G[k] = MPMSelect(MPMRead(&s->has_F[l]) > 0.0, G[k], MPMAll(0)); /* else it stays I */
      }
      MPMDeform(dim, dt, G, F);
      for (int k = 0; k < dim * dim; k++) MPMWrite(&b->F[k][l], F[k]);
      MPMStore(dim * dim, F, o, l, l, l + MPM_WIDTH, particles->F);
      J = MPMDet(dim, F);
      if (particles->F33) {
        MPMReal F33, rate = MPMRead(&L[4][l]);

        if (par->nmaterials > 1) rate = MPMSelect(MPMRead(&s->has_F[l]) > 0.0, rate, MPMAll(0));
        MPMLoad(1, particles->F33, o, l, &F33);
        F33 += dt * rate * F33;
        MPMWrite(&b->F33[0][l], F33);
        MPMStore(1, &F33, o, l, l, l + MPM_WIDTH, particles->F33);
        bad |= MPMNot(F33 > 0.0);
        J *= F33;
      }
      bad |= MPMNot((J > 0.0) & (J < PETSC_MAX_REAL));
    }
    if (parts & MPM_G2P_COMMIT) {
      MPMMask stays = MPMNot(MPMNone());
      MPMReal x[3];

      if (particles->l) MPMStretchDomains(dim, par, particles, o, l, s, status);
      for (int d = 0; d < dim; d++) {
        const MPMAxis *axis = &s->axis[d];
        MPMReal        off  = MPMFma(dx[d], MPMAll(axis->inverse), MPMRead(&s->at[d][l])) - axis->middle;

        if (patch->basis == MPM_BASIS_gimp) off -= MPMRead(&s->l[d][l]);
        x[d] = MPMRead(&s->x[d][l]) + dx[d];
        stays &= MPMAbs(off) < axis->near;
        in &= (x[d] >= axis->lower) & (x[d] < patch->grid->upper[d]);
      }
      sure |= MPMSet(stays, l);
      MPMStore(dim, x, o, l, l, l + MPM_WIDTH, particles->x);
    }
  }
  found->bad  = bad;
  found->in   = in;
  found->sure = sure;
}

/* Updates the material state of a block apart from F, eqs. (11) and (12); notes bad J and finds wave speeds. */
MPM_INLINE void MPMUpdateState(int dim, const MPMParams *par, MPMPatch *patch, const MPMBlockOrder *o,
                               const MPMStencils *s, MPMComponent *L, MPMBlock *b, MPMFound *found, MPMStatus *status)
{
  MPM_FOR_MATERIALS(m, first, next, par, o->lanes, s->kind)
  {
    const MPMMaterialLaw *law   = MPMLaw(m);
    const PetscBool       has_F = m->state & MPM_BIT(F) ? PETSC_TRUE : PETSC_FALSE;
    const PetscInt        from  = first - first % MPM_WIDTH;
    MPMMask               bad   = has_F ? found->bad : MPMNone();
    MPMComponent          c2;

    if (law->update[dim - 1]) law->update[MPMLawForm(m, dim)](m, par->dt, L, first, next, b);
    for (PetscInt l = from; l < next && m->follows > 0 && (m->state & MPM_BIT(vc)); l += MPM_WIDTH)
      found->opened |= MPMBetween(l, first, next) & (MPMRead(&b->vc[0][l]) > MPM_OPENED);
    for (PetscInt l = from; l < next && !has_F; l += MPM_WIDTH) {
      const MPMReal J = MPMRead(&b->J[0][l]);

      bad |= MPMBetween(l, first, next) & MPMNot((J > 0.0) & (J < PETSC_MAX_REAL));
    }
    if (MPMAny(bad)) MPMRareBadJ(dim, patch, has_F, first, PetscMin(next, o->n), o->particle, s, b, status);
    law->speed2[MPMLawForm(m, dim)](m, first, next, b, c2);
    if (patch->grid->total) MPMReferenceSpeed2(dim, dim == 2 && patch->grid->round, b, from, next, c2);
    for (PetscInt l = from; l < next; l += MPM_WIDTH)
      found->c2 = MPMMax(found->c2, MPMSelect(MPMBetween(l, first, next), MPMRead(c2 + l), MPMAll(0)));
#define MPM_SCATTER(name, rows)                                                                                        \
  if (!(MPM_BIT(name) & (MPM_BIT(F) | MPM_BIT(F33))) && ((m->state | par->carried) & MPM_BIT(name)))                   \
    MPMScatter(MPMComponents_##name(dim), b->name, o, first, next, patch->particles.name);
    MPM_MATERIAL_FIELDS(MPM_SCATTER)
#undef MPM_SCATTER
  }
}

/* Finds the new cells of a block's particles, but of those that surely stay; of all if one is outside of the grid, as
   it may be across a periodic face, through which it is moved back. Notes movers and leavers. */
MPM_INLINE void MPMUpdateCells(int dim, const MPMParams *par, MPMPatch *patch, const MPMBlockOrder *o,
                               const MPMStencils *s, const MPMFound *found, MPMStatus *status)
{
  const PetscBool out  = MPMAny(MPMNot(found->in));
  const uint64_t  back = par->planes ? MPMRarePlanes(dim, par, patch, o->n, o->particle, s) : 0;
  PetscInt        n, which[MPM_STAGED];

  if (out) MPMRareWrap(dim, patch, o->n, o->particle);
  n = MPMList(out ? ~(uint64_t)0 : ~found->sure | back, o->n, which);
  if (n)
    MPMRareCells(dim, par, patch, o->entry - o->n, n, which, o->particle, s, status); /* of one range: its last n */
}

/* Runs the parts of a transfer from nodes to particles: velocities and displacements (8), (9); velocity gradient (3), F
   and material state; new positions; the filter of xpic; volumes of fluids. */
MPM_INLINE void MPMG2P(int dim, const MPMParams *par, MPMPatch *patch, PetscInt parts, MPMStatus *status)
{
  const int stress    = parts & MPM_G2P_STRESS ? 1 : 0,
            gradients = stress || parts & (MPM_G2P_VOLUME | MPM_G2P_TOTAL) ? 1 : 0;
  const int round     = dim == 2 && gradients && patch->grid->round; /* the strain needs v_r too, or u_r */
  const int motion    = parts & (MPM_G2P_MOTION | MPM_G2P_FILTER | MPM_G2P_VOLUME | MPM_G2P_TOTAL) ? 1 : round ? 3 : 0;
  const MPMView             *particles   = &patch->particles;
  const MPMRange             all         = {0, particles->n, 0};
  const MPMInterpolateBlocks interpolate = MPM_LANES_NAME(
      MPMInterpolateBlock)[dim - 1][MPMBasisNodes(patch->basis) - 2][motion][gradients];
  MPMBlockOrder       o;
  MPMFound            found = {MPMAll(0), MPMAll(0), MPMNone(), MPMNone(), MPMNone(), 0};
  MPMComponent        value[6], L[9], grad[9], r[3];
  MPMComponent *const vn = value, *const an = value + dim; /* sum phi v', sum phi a */
  MPMStencils s;
  MPMBlock    b;

  MPMStencilsBegin(dim, par, patch, &s);
  memset(&b, 0, sizeof b);
  memset(value, 0, sizeof value);
  patch->nmovers = 0;
  MPMFirstBlock(1, &all, &o);
  if (parts & MPM_G2P_FBAR) MPM_LANES_NAME(MPMSumGrowth)(dim, par, patch);
  while (MPMNextBlock(dim, patch, 1, &all, &o)) {
    PetscInt state = 0;

    MPMStage(dim, par, patch, &o, &s);
    if (interpolate) interpolate(&o, &s, patch->n, patch->motion, value, L);
    if (round) MPMRoundGradient(&o, &s, vn[0], L);
    if (parts & MPM_G2P_VOLUME) {
      MPM_LANES_NAME(MPMRelaxVolumes)(dim, par, patch, &o, &s, value, L);
      continue;
    }
    if (parts & MPM_G2P_TOTAL) {
      const MPMComponent *grad_u = L;

      state = MPMGatherState(dim, par, patch, MPM_MATERIAL_BITS & ~(MPM_BIT(F) | MPM_BIT(F33)), &o, &s, &b);
      if (parts & MPM_G2P_FBAR || state & MPM_BIT(tau)) { /* what needs rates */
        grad_u = memcpy(grad, L, sizeof grad);
        MPMRatesTotal(dim, par, patch, &o, L);
      }
      if (parts & MPM_G2P_FBAR) MPM_LANES_NAME(MPMShareGrowth)(dim, par, patch, &o, &s, L);
      MPMDeformTotal(dim, patch, &o, &s, value, grad_u, &b, &found.v2, &found.bad);
      MPMUpdateState(dim, par, patch, &o, &s, L, &b, &found, status);
      continue;
    }
    if (parts & MPM_G2P_FILTER) {
      MPMGather(dim, parts & MPM_RESIDUAL ? particles->r : particles->v, &o, r);
      for (int d = 0; d < dim; d++)
        for (PetscInt l = 0; l < o.n; l += MPM_WIDTH) MPMWrite(&r[d][l], MPMRead(&r[d][l]) - MPMRead(&vn[d][l]));
      MPMScatter(dim, r, &o, 0, o.n, particles->r);
    }
    if (particles->H) MPMKeepGradients(dim, par, particles, &o, L);
    if (parts & MPM_G2P_FBAR) MPM_LANES_NAME(MPMShareGrowth)(dim, par, patch, &o, &s, L);
    if (stress) state = MPMGatherState(dim, par, patch, MPM_MATERIAL_BITS & ~(MPM_BIT(F) | MPM_BIT(F33)), &o, &s, &b);
    MPMMoveBlock(dim, par, patch, parts, state, &o, vn, an, L, &s, &b, &found, status);
    if (stress) MPMUpdateState(dim, par, patch, &o, &s, L, &b, &found, status);
    if (parts & MPM_AFFINE) MPMAffine(dim, par, parts, patch, &o, &s, L); /* L is not needed any more */
    if (parts & MPM_G2P_COMMIT) MPMUpdateCells(dim, par, patch, &o, &s, &found, status);
  }
  status->v2 = PetscMax(status->v2, MPMLargest(found.v2));
  status->c2 = PetscMax(status->c2, MPMLargest(found.c2));
  if (MPMAny(found.opened)) status->opened = 1;
}

#endif
