/* g2p.h - the transfer from nodes to particles: velocities and displacements, deformation and material state, and the
   new positions. transfer.h has the overview and the shapes. */
#ifndef MPM_G2P_H
#define MPM_G2P_H

#include "kernels/affine.h"
#include "kernels/p2g.h"
#include "kernels/rare.h"

/* --- Nodes to particles ------------------------------------------------------------------------------------------- */

/* Updates F and material state of a block from its velocity gradients L [dim*dim] in 1/s, eqs. (10) to (12); notes bad
   J and the largest squared wave speed c2max in m^2/s^2. */
MPM_INLINE void MPMUpdateState(int dim, const MPMParams *par, MPMPatch *patch, const MPMBlockOrder *o,
                               const MPMStencils *s, MPMComponent *L, MPMBlock *b, MPMReal *c2max, MPMStatus *status)
{
  const MPMView *particles = &patch->particles;

  MPMGatherState(dim, par, patch, o, s, b);
  MPM_FOR_MATERIALS(m, first, next, par, o->n, s->kind)
  {
    const MPMMaterialLaw *law   = MPMLaw(m);
    const PetscInt        from  = first - first % MPM_WIDTH;
    const PetscBool       has_F = m->state & MPM_BIT(F) ? PETSC_TRUE : PETSC_FALSE;
    MPMMask               bad   = MPMNone();
    MPMComponent          c2;

    for (PetscInt l = from; l < next && has_F; l += MPM_WIDTH) {
      MPMReal F[9], G[9];

      for (int k = 0; k < dim * dim; k++) {
        F[k] = MPMRead(&b->F[k][l]);
        G[k] = MPMRead(&L[k][l]);
      }
      MPMDeform(dim, par->dt, G, F);
      for (int k = 0; k < dim * dim; k++) MPMWritePart(&b->F[k][l], F[k], first - l, next - l);
    }
    if (law->update[dim - 1]) law->update[dim - 1](m, par->dt, L, first, next, b);
    for (PetscInt l = from; l < next; l += MPM_WIDTH) {
      MPMReal F[9], J = MPMRead(&b->J[0][l]);

      if (has_F) {
        for (int k = 0; k < dim * dim; k++) F[k] = MPMRead(&b->F[k][l]);
        J = MPMDet(dim, F);
      }
      bad |= MPMBetween(l, first, next) & MPMNot((J > 0.0) & (J < PETSC_MAX_REAL));
    }
    if (MPMAny(bad)) MPMRareBadJ(dim, patch, has_F, first, next, o->particle, b, status);
    law->speed2[dim - 1](m, first, next, b, c2);
    for (PetscInt l = from; l < next; l += MPM_WIDTH)
      *c2max = MPMMax(*c2max, MPMSelect(MPMBetween(l, first, next), MPMRead(c2 + l), MPMAll(0)));
#define MPM_SCATTER(name, rows)                                                                                        \
  if ((m->state | par->carried) & MPM_BIT(name))                                                                       \
    MPMScatter(MPMComponents_##name(dim), b->name, o, first, next, particles->name);
    MPM_MATERIAL_FIELDS(MPM_SCATTER)
#undef MPM_SCATTER
  }
}

/* Computes new velocities v of a block from vn = sum phi v' and an = sum phi a (8), and displacements dx (9), which may
   have the array of vn. r is, with xpic, the part of the old v that interpolation to nodes and back does not give,
   which is dropped; else NULL. */
MPM_INLINE void MPMMove(int dim, const MPMParams *par, PetscInt n, MPMComponent *v, const MPMComponent *r,
                        const MPMComponent *vn, const MPMComponent *an, MPMComponent *dx, MPMReal *v2max)
{
  const PetscReal dt = par->dt, kick = par->kick, flip = par->flip, pic = 1 - par->flip;

  for (PetscInt l = 0; l < n; l += MPM_WIDTH) {
    MPMReal v2 = MPMAll(0);

    for (int d = 0; d < dim; d++) {
      const MPMReal now = MPMRead(&vn[d][l]), step = kick * MPMRead(&an[d][l]), old = MPMRead(&v[d][l]);
      const MPMReal to = r ? old - MPMRead(&r[d][l]) + step : flip * (old + step) + pic * now;

      v2 += to * to;
      MPMWrite(&v[d][l], to);
      MPMWrite(&dx[d][l], dt * (r ? to : now));
    }
    *v2max = MPMMax(*v2max, MPMSelect(MPMBetween(l, 0, n), v2, MPMAll(0)));
  }
}

/* Computes the base nodes of n particles at their new positions: on each axis from the patch's first own node in `at`,
   and in `base` their index in the arrays as in s->base, or MPM_ELSEWHERE or MPM_NOWHERE. */
MPM_INLINE void MPMFindBases(int dim, MPMBasis basis, const MPMPatch *patch, PetscInt n, const MPMStencils *s,
                             MPMComponent *at, PetscReal *base)
{
  const MPMGrid grid = *patch->grid;

  for (PetscInt l = 0; l < n; l += MPM_WIDTH) {
    MPMReal index  = MPMAll(0);
    MPMMask inside = MPMNot(MPMNone()), own = inside;

    for (int d = dim - 1; d >= 0; d--) {
      const MPMAxis *axis = &s->axis[d];
      const MPMReal  x    = MPMRead(&s->x[d][l]);
      MPMReal        xi, node = MPMBasesOf(basis, &grid, d, axis, x, MPMRead(&s->l[d][l]), &xi);

      inside &= (x >= axis->lower) & (x <= grid.upper[d]);
      index = index * axis->n + (node - axis->first);
      node -= axis->own;
      own &= (node >= 0) & (node < axis->nown);
      MPMWrite(&at[d][l], node);
    }
    MPMWrite(base + l, MPMSelect(inside, MPMSelect(own, index, MPMAll(MPM_ELSEWHERE)), MPMAll(MPM_NOWHERE)));
  }
}

/* Notes a mover: particle l of a block, entry `entry` of the order, has a new base node, `index` in the arrays and `at`
   on the axes. Numbers its cell and adds it to the movers of the patch. Returns whether it left the patch for another
   one. */
MPM_INLINE PetscBool MPMNoteMover(int dim, const MPMParams *par, MPMPatch *patch, PetscInt entry,
                                  const MPMBlockOrder *o, const MPMStencils *s, PetscInt l, PetscInt index,
                                  const MPMComponent *at, MPMStatus *status)
{
  const PetscInt p       = o->particle[l];
  PetscInt       cell    = index; /* MPM_ELSEWHERE or MPM_NOWHERE */
  PetscInt       node[3] = {0};

  if (index >= 0) {
    for (int d = 0; d < dim; d++) node[d] = (PetscInt)at[d][l];
    cell = MPMTileCell(dim, &patch->tiles, node);
  }
  patch->particles.cell[p] = cell;
  if (patch->movers) patch->movers[patch->nmovers] = cell < 0 ? MPM_FLAGGED(entry) : entry;
  patch->nmovers++;
  status->moved++;
  if (cell == MPM_NOWHERE) {
    const PetscReal x[3] = {s->x[0][l], s->x[1][l], s->x[2][l]};

    MPMBad bad = par->deletes ? MPM_GONE : MPM_LEFT_GRID;

    for (int d = 0; d < dim; d++)
      if (!(PetscAbsReal(x[d]) <= PETSC_MAX_REAL)) bad = MPM_LEFT_GRID;
    MPMStatusNote(status, bad, patch->particles.id[p], dim, x, 0);
  }
  return cell == MPM_ELSEWHERE ? PETSC_TRUE : PETSC_FALSE;
}

/* Commits the displacements: x <- x + dx, and the new cells. Only the cells of movers, which are few, are numbered
   anew. Counts movers and leavers. q is the entry of the order at which the block begins. */
MPM_INLINE void MPMCommit(int dim, const MPMParams *par, MPMPatch *patch, PetscInt q, const MPMBlockOrder *o,
                          MPMStencils *s, const MPMComponent *dx, MPMStatus *status)
{
  const MPMGrid *grid  = patch->grid;
  MPMMask        wraps = MPMNone();
  MPMBits        moves = {0};
  MPMComponent   at[3], now; /* base nodes as places on each axis, and as indices, to be compared with s->base */
  PetscInt       moved, which[MPM_STAGED];

  for (int d = 0; d < dim; d++)
    for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
      const MPMReal x = MPMRead(&s->x[d][l]) + MPMRead(&dx[d][l]);

      MPMWrite(&s->x[d][l], x);
      if (grid->periodic[d]) wraps |= MPMBetween(l, 0, o->n) & MPMNot((x >= grid->lower[d]) & (x < grid->upper[d]));
    }
  if (MPMAny(wraps)) MPMRareWrap(dim, grid, o->n, s->x);
  MPMScatter(dim, s->x, o, 0, o->n, patch->particles.x);
  if (patch->particles.l) {
    MPMRareStretch(dim, par, patch, o->n, o->particle, s->x, status);
    MPMGather(dim, patch->particles.l, o, s->l);
  }
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  if (patch->basis == MPM_BASIS_##name) MPMFindBases(dim, MPM_BASIS_##name, patch, o->n, s, at, now);
#include "physics/basis.def"
#undef MPM_BASIS
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) moves = MPMCollect(MPMRead(&now[l]) != MPMRead(&s->base[l]), l, moves);
  moved = MPMList(moves, o->n, which);
  for (PetscInt k = 0; k < moved; k++)
    status->left += MPMNoteMover(dim, par, patch, q + which[k], o, s, which[k], (PetscInt)now[which[k]], at, status);
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
  MPMComponent        value[6], L[9], v[3], r[3];
  MPMComponent *const vn = value, *const an = value + dim,
                      *const dx = vn; /* sum phi v', sum phi a; dx uses the memory of vn */
  MPMStencils                s;
  MPMBlock                   b;

  MPMStencilsBegin(dim, par, patch, &s);
  memset(&b, 0, sizeof b);
  memset(value, 0, sizeof value);
  memset(v, 0, sizeof v);
  memset(r, 0, sizeof r);
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
      MPMGather(dim, particles->v, &o, v);
      if (particles->r) MPMGather(dim, particles->r, &o, r);
      MPMMove(dim, par, o.n, v, particles->r ? r : NULL, vn, an, dx, &v2);
      MPMScatter(dim, v, &o, 0, o.n, particles->v);
      if (!(parts & MPM_G2P_COMMIT)) MPMScatter(dim, dx, &o, 0, o.n, particles->dx);
    }
    if (parts & MPM_G2P_FBAR) MPM_LANES_NAME(MPMShareGrowth)(dim, par, patch, &o, &s, L);
    if (stress) MPMUpdateState(dim, par, patch, &o, &s, L, &b, &c2, status);
    if (parts & MPM_AFFINE) MPMAffine(dim, par, parts, patch, &o, &s, L); /* L is not needed any more */
    if (parts & MPM_G2P_COMMIT) {       /* after the new state, which may change the domain */
      const PetscInt q = o.entry - o.n; /* there is one range: the block is its last n entries */

      if (!motion) MPMGather(dim, particles->dx, &o, dx);
      MPMCommit(dim, par, patch, q, &o, &s, dx, status);
    }
  }
  status->v2 = PetscMax(status->v2, MPMLargest(v2));
  status->c2 = PetscMax(status->c2, MPMLargest(c2));
}

#endif
