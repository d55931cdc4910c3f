/* p2g.h - particles to nodes: the records of a block of particles and the sweep over the tiles of a pass. transfer.h
   has the map. */
#ifndef MPM_P2G_H
#define MPM_P2G_H

#include "kernels/stencils.h"
#include "kernels/tile_sums.h"
#include "kernels/transfer.h"

#define MPM_MEANWHILE 32 /* blocks of particles between calls of what else must get on (patch->meanwhile) */

/* --- Particles to nodes -------------------------------------------------------------------------------------------- */

/* What a particle adds to node i of its stencil: phi Q[0] + sum_e dphi_e Q[1+e] + sum_e i_e phi A[e], where each is a
   record of numbers that are laid out as the sums of a node (MPMNode). MPMP2G zeroes all of them once; what its parts
   do not ask for is never written and stays 0. */
enum { MPM_Q_RECORDS = 4, MPM_A_RECORDS = 3 }; /* of a particle, in every dimension */
typedef PetscReal MPMRecord[MPM_NODE_NC];
typedef struct {
  MPMRecord Q[MPM_STAGED][MPM_Q_RECORDS], A[MPM_STAGED][MPM_A_RECORDS];
} __attribute__((aligned(64))) MPMRecords;

/* nc numbers of MPM_WIDTH particles into a record of each, from the place `to` in that of the first; a particle has
   `records` of them. Pairs are written faster than single numbers: an odd nc takes from[nc] along, which is 0, as is
   what the record has in that place. */
MPM_INLINE void MPMWriteRecords(int nc, const MPMReal *from, PetscReal *to, int records)
{
  PetscReal *row[MPM_WIDTH];

  for (int k = 0; k < MPM_WIDTH; k++) row[k] = to + k * records * MPM_NODE_NC;
  MPMWriteRows(nc + nc % 2, from, row);
}

/* The records of a block: Q[0] = (m, m v | m b), Q[1+e] = (0 | - V0 tau_e), with V sig = V0 tau; with the affine part
   v + C (x_i - x_p) of velocity, x_i - x_p = (i - at) h. */
MPM_INLINE void MPMStageRecords(int dim, PetscInt parts, const MPMPatch *patch, const MPMBlockOrder *o,
                                const MPMStencils *s, const MPMBlock *b, MPMRecords *r)
{
  MPMComponent    v[3], force[3], C[9];
  const PetscReal one = parts & MPM_P2G_MASS ? 1 : 0;

  if (parts & MPM_P2G_MOMENTUM) {
    MPMGather(dim, parts & MPM_RESIDUAL ? patch->particles.r : patch->particles.v, o, v);
    if (parts & MPM_AFFINE) MPMGather(dim * dim, patch->particles.C, o, C);
    for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
      const MPMReal m = MPMRead(&s->m[l]);
      MPMReal       Q[4];

      Q[0] = one * m;
      for (int d = 0; d < 3; d++) Q[1 + d] = d < dim ? m * MPMRead(&v[d][l]) : MPMAll(0);
      for (int e = 0; e < dim && (parts & MPM_AFFINE); e++) {
        MPMReal A[4] = {MPMAll(0), MPMAll(0), MPMAll(0), MPMAll(0)};

        for (int d = 0; d < dim; d++) {
          A[1 + d] = m * MPMRead(&C[d * dim + e][l]) * patch->grid->h[e];
          Q[1 + d] -= A[1 + d] * MPMRead(&s->at[e][l]);
        }
        MPMWriteRecords(1 + dim, A, r->A[l][e], MPM_A_RECORDS);
      }
      MPMWriteRecords(1 + dim, Q, r->Q[l][0], MPM_Q_RECORDS);
    }
  }
  if (parts & MPM_P2G_FORCE)
    for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
      const MPMReal V0 = -MPMRead(&s->V0[l]);

      for (int e = 0; e < dim; e++) {
        MPMReal Q[4] = {MPMAll(0), MPMAll(0), MPMAll(0), MPMAll(0)};

        for (int d = 0; d < dim; d++) Q[d] = V0 * MPMRead(&b->tau[MPMSymPart(dim, d, e)][l]);
        MPMWriteRecords(dim, Q, r->Q[l][1 + e] + MPM_NODE_FORCE, MPM_Q_RECORDS);
      }
    }
  if ((parts & MPM_P2G_FORCE) && patch->particles.b) {
    MPMGather(dim, patch->particles.b, o, force);
    for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
      MPMReal Q[4] = {MPMAll(0), MPMAll(0), MPMAll(0), MPMAll(0)};

      for (int d = 0; d < dim; d++) Q[d] = MPMRead(&s->m[l]) * MPMRead(&force[d][l]);
      MPMWriteRecords(dim, Q, r->Q[l][0] + MPM_NODE_FORCE, MPM_Q_RECORDS);
    }
  }
}

/* The hot loops, transfer_sums.c, for a block: sums over the particles of a cell to its nodes, and over its nodes to
   the particles. place: where in its tile the base node of each of the block's cells is. The last cell may go on in the
   next block, so its sums are not yet added to its nodes but are left begun. */
typedef struct {
  MPMRecord  sum[MPM_MAX_NODES];
  PetscReal *place; /* of that cell; NULL: none yet */
} __attribute__((aligned(64))) MPMBegun;
typedef void (*MPMSumBlocks)(const MPMBlockOrder *, const MPMStencils *, const MPMRecords *, PetscReal *const place[],
                             MPMBegun *);
typedef void (*MPMInterpolateBlocks)(const MPMBlockOrder *, const MPMStencils *, const PetscInt at[],
                                     const PetscReal *nodes, MPMComponent *value, MPMComponent *gradient);
/* [dim-1][nodes per axis - 2][forces][affine], [..][..][motion][stress] */
extern const MPMSumBlocks         MPM_LANES_NAME(MPMSumBlock)[3][3][2][2];
extern const MPMInterpolateBlocks MPM_LANES_NAME(MPMInterpolateBlock)[3][3][2][2];

/* Adds the sums that the last block left begun to their nodes, as any new cell does: here one of no particles,
   nowhere. */
MPM_INLINE void MPMSumEnd(MPMSumBlocks sum, MPMBlockOrder *o, const MPMStencils *s, const MPMRecords *r,
                          PetscReal *place[], MPMBegun *begun)
{
  o->ncells = 1;
  o->end[0] = 0;
  place[0]  = NULL;
  sum(o, s, r, place, begun);
}

/* Where in their tiles the cells of a block have their sums (tile_sums.h has a drawing). Most cells follow the one
   before in its row of cells: what is found by divisions is found once a row. */
MPM_INLINE void MPMStagePlaces(int dim, const MPMPatch *patch, PetscBool kept, const MPMBlockOrder *o,
                               PetscReal *place[])
{
  const MPMTiles *t     = &patch->tiles;
  const PetscInt  side  = MPMTileSide(patch->basis);
  const size_t    size  = MPMTileSize(dim, patch->basis);
  PetscInt        begin = 0, end = 0, left = 0; /* cells of the row of cells: begin .. end-1; its first tile */
  PetscReal      *sums = NULL;                  /* where that row of cells begins in the first tile of all these sums */

  for (PetscInt l = 0; l < o->n; l += 8) __builtin_prefetch(patch->particles.cell + o->ahead[l]);
  for (PetscInt c = 0, first = 0; c < o->ncells; first = o->end[c++]) {
    const PetscInt cell = patch->particles.cell[o->particle[first]];
    PetscInt       tile, in; /* of the row; the cell in the tile, on x */

    if (cell >= end || cell < begin) {
      PetscInt at[3];

      tile  = MPMTileOf(dim, t, cell, at);
      left  = tile - tile % t->n[0];
      begin = cell - at[0] - ((tile - left) << t->bits);
      end   = begin + (t->n[0] << t->bits);
      sums  = (kept ? t->sum : t->scratch) + MPM_NODE_NC * (at[2] * side + at[1]) * side;
    }
    tile     = (cell - begin) >> t->bits;
    in       = (cell - begin) & ((1 << t->bits) - 1);
    place[c] = sums + (size_t)(kept ? t->slot[left + tile] : tile) * size + MPM_NODE_NC * in;
  }
}

/* Sums over particles to nodes: mass (1), momentum (2) and force (4), (13). A sweep is for the tiles of one pass. Those
   of early tiles, for which other processes wait, and of late ones, which fill the time until sums of others have come,
   make their kept sums and no more. The last sweep goes from row to row of tiles: opens it, sums the particles of its
   open tiles, and closes it, which adds all its tiles, kept ones too, to the nodes. Sums that are not among the parts
   get 0 added. */
MPM_INLINE void MPMP2G(int dim, const MPMParams *par, MPMPatch *patch, PetscInt parts)
{
  const int          forces = parts & MPM_P2G_FORCE ? 1 : 0, affine = parts & MPM_AFFINE ? 1 : 0;
  const MPMSumBlocks sum = MPM_LANES_NAME(MPMSumBlock)[dim - 1][MPMBasisNodes(patch->basis) - 2][forces][affine];
  const MPMTiles    *t   = &patch->tiles;
  const MPMPass   pass = parts & MPM_P2G_EARLY ? MPM_PASS_EARLY : parts & MPM_P2G_LATE ? MPM_PASS_LATE : MPM_PASS_MAIN;
  const PetscBool kept = pass == MPM_PASS_MAIN ? PETSC_FALSE : PETSC_TRUE;
  const MPMRange *runs = t->runs[pass], *end = runs + t->nruns[pass];
  MPMBegun        begun  = {{{0}}, NULL};
  PetscInt        closed = 0, blocks = 0; /* rows of tiles; blocks of particles */
  PetscReal      *place[MPM_STAGED];
  MPMBlockOrder   o;
  MPMStencils     s;
  MPMRecords      r;
  MPMBlock        b;

  MPMStencilsBegin(dim, par, &s);
  memset(&r, 0, sizeof r);
  memset(&b, 0, sizeof b);
  if (kept) MPMOpenKept(dim, patch, pass);
  while (runs < end) {
    const PetscInt row = runs->row;
    PetscInt       n   = 1; /* runs at a time: those of a row of tiles, all where sums are kept */

    while (runs + n < end && (kept || runs[n].row == row)) n++;
    while (!kept && closed < row)
      MPMCloseRow(dim, patch, parts, closed++); /* the last one, and such without open tiles */
    if (!kept) MPMOpenRow(dim, patch, row);
    MPMFirstBlock(n, runs, &o);
    while (MPMNextBlock(patch, n, runs, &o)) {
      MPMStage(dim, par, patch, &o, &s);
      MPMStagePlaces(dim, patch, kept, &o, place);
      if (forces) {
        MPMGatherState(dim, patch, &o, &b);
        MPM_FOR_MATERIALS(m, first, next, par, o.n, s.kind)
        if (!(m->state & MPM_BIT(tau))) MPMLaw(m)->stress[dim - 1](m, first, next, &b);
      }
      MPMStageRecords(dim, parts, patch, &o, &s, &b, &r);
      sum(&o, &s, &r, place, &begun);
      if (patch->meanwhile && ++blocks % MPM_MEANWHILE == 0) patch->meanwhile(patch->ctx);
    }
    MPMSumEnd(sum, &o, &s, &r, place, &begun);
    runs += n;
  }
  while (!kept && closed < t->n[1] * t->n[2]) MPMCloseRow(dim, patch, parts, closed++);
}

#endif
