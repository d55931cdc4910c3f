/* p2g.h - the transfer from particles to nodes: what each particle of a block adds, and the loop over the tiles of a
   pass. transfer.h has the overview and the shapes. */
#ifndef MPM_P2G_H
#define MPM_P2G_H

#include "kernels/fbar.h"
#include "kernels/node_sums.h"
#include "kernels/tile_sums.h"
#include "kernels/total.h"
#include "kernels/transfer.h"
#include "kernels/volume.h"

#define MPM_MEANWHILE 32 /* blocks of particles between two calls of patch->meanwhile */

/* --- Particles to nodes ------------------------------------------------------------------------------------------- */

/* Computes the records of a block: Q[0] = (m, m v | m b), Q[1+e] = (0 | - V0 tau_e), where V sig = V0 tau, but as above
   in 2-D; A are those of the affine part of the velocity, v + C (x_i - x_p) with x_i - x_p = (i - at) h.
   In bodies of revolution Q[0] also has the momentum of v_r = r, of which `outward` is the affine part, and Q[1] the
   stress around the axis. */
MPM_INLINE void MPMStageRecords(int dim, PetscInt parts, const MPMPatch *patch, const MPMBlockOrder *o,
                                const MPMStencils *s, const MPMBlock *b, PetscReal outward, MPMRecords *r)
{
  MPMComponent    v[3], force[3], C[9];
  const int       round = dim == 2 && patch->grid->round;
  const PetscReal one   = parts & MPM_P2G_MASS ? 1 : 0;

  if (parts & MPM_P2G_MOMENTUM) {
    if (parts & MPM_P2G_NODES) MPM_LANES_NAME(MPMInterpolateBlock)
    [dim - 1][MPMBasisNodes(patch->basis) - 2][2][0](o, s, patch->n, patch->motion, v, NULL);
    else MPMGather(dim, parts & MPM_RESIDUAL ? patch->particles.r : patch->particles.v, o, v);
    if (parts & MPM_AFFINE) MPMGather(dim * dim, patch->particles.C, o, C);
    for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
      const MPMReal m = MPMRead(&s->m[l]);
      MPMReal       Q[4];

      Q[0] = one * m;
      for (int d = 0; d < 3; d++) Q[1 + d] = d < dim ? m * MPMRead(&v[d][l]) : MPMAll(0);
      if (round) Q[3] = one * m * MPMRead(&s->x[0][l]);
      for (int e = 0; e < dim && (parts & MPM_AFFINE); e++) {
        MPMReal A[4] = {MPMAll(0), MPMAll(0), MPMAll(0), MPMAll(0)};

        for (int d = 0; d < dim; d++) {
          A[1 + d] = m * MPMRead(&C[d * dim + e][l]) * patch->grid->h[e];
          Q[1 + d] -= A[1 + d] * MPMRead(&s->at[e][l]);
        }
        if (round && e == 0) {
          A[3] = one * outward * m * patch->grid->h[0];
          Q[3] -= A[3] * MPMRead(&s->at[0][l]);
        }
        MPMWriteRecords(1 + dim, A, r->A[l][e], MPM_A_RECORDS);
      }
      MPMWriteRecords(1 + dim, Q, r->Q[l][0], MPM_Q_RECORDS);
    }
  }
  if (parts & MPM_P2G_FORCE)
    for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
      const MPMReal V0 = -MPMRead(&s->V0[l]);
      MPMReal       S[9];

      for (int k = 0; k < dim * dim; k++) S[k] = MPMRead(&b->tau[MPMSymPart(dim, k / dim, k % dim)][l]);
      if (patch->particles.S) {
        MPMReal less[9];

        MPMLoad(dim * dim, patch->particles.S, o, l, less);
        for (int k = 0; k < dim * dim; k++) S[k] -= less[k];
      }
      if (parts & MPM_P2G_TOTAL) MPMPiola(dim, &patch->particles, o, b, l, S);
      for (int e = dim == 2 ? 1 : 0; e < dim; e++) { /* in 2-D once */
        MPMReal Q[4] = {MPMAll(0), MPMAll(0), MPMAll(0), MPMAll(0)};

        for (int d = 0; d < dim; d++) Q[d] = V0 * S[d * dim + e];
        if (dim == 2) Q[2] = V0 * S[0], Q[3] = V0 * S[2];
        MPMWriteRecords(dim == 2 ? 4 : dim, Q, r->Q[l][dim == 2 ? 0 : 1 + e] + MPM_NODE_force, MPM_Q_RECORDS);
      }
    }
  if ((parts & MPM_P2G_FORCE) && (patch->particles.b || round)) {
    if (patch->particles.b) MPMGather(dim, patch->particles.b, o, force);
    for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
      MPMReal Q[4] = {MPMAll(0), MPMAll(0), MPMAll(0), MPMAll(0)};

      for (int d = 0; d < dim && patch->particles.b; d++) Q[d] = MPMRead(&s->m[l]) * MPMRead(&force[d][l]);
      if (round) {
        MPMReal hoop = MPMRead(&b->tau[3][l]);

        if (parts & MPM_P2G_TOTAL) hoop = hoop / MPMMotionAround(&patch->particles, o, l);
        Q[0] -= MPMRead(&s->V0[l]) * hoop / MPMRadius(s, l);
      }
      MPMWriteRecords(dim, Q, r->Q[l][dim == 2 ? 1 : 0] + MPM_NODE_force, MPM_Q_RECORDS);
    }
  }
}

/* The innermost loops, transfer_sums.c, for a block: sums over the particles of a cell for its nodes. place[c] is where
   the sums of the tile have the base node of the block's cell c. The sums of the first cell begin at `from` if it began
   in the block before, else from is NULL; those of the last one go to `to` if it continues in the next block, else to
   is NULL. Both are [nodes of a stencil]. */
typedef void (*MPMSumBlocks)(const MPMBlockOrder *, const MPMStencils *, const MPMRecords *, PetscReal *const place[],
                             const MPMRecord *from, MPMRecord *to);
/* [dim-1][nodes per axis - 2][forces: 0 none, 1 stress, 2 stress and loads][affine] */
extern const MPMSumBlocks MPM_LANES_NAME(MPMSumBlock)[3][3][3][2];
/* [dim-1][nodes per axis - 2] for a line besides the first one, of which all numbers are summed by phi */
extern const MPMSumBlocks MPM_LANES_NAME(MPMSumLine)[3][3];

/* Finds where in the sums of their tiles the cells of a block have theirs (tile_sums.h has a drawing). Most cells
   follow the one before in a row of cells, so what needs divisions is computed once for each row of cells. */
MPM_INLINE void MPMStagePlaces(int dim, const MPMPatch *patch, PetscBool kept, const MPMBlockOrder *o,
                               PetscReal *place[])
{
  const MPMTiles *t     = &patch->tiles;
  const PetscInt  side  = MPMTileSide(patch->basis);
  const size_t    size  = MPMTileSize(dim, patch);
  PetscInt        begin = 0, end = 0, left = 0; /* cells of the row: begin .. end-1; its row's first tile */
  PetscReal      *sums = NULL;                  /* the row of cells in the first tile of all these sums */

  for (PetscInt l = 0; l < o->n; l += 8) __builtin_prefetch(patch->particles.cell + o->ahead[l]);
  for (PetscInt c = 0, first = 0; c < o->ncells; first = o->end[c++]) {
    const PetscInt cell = patch->particles.cell[o->particle[first]];
    PetscInt       tile, in; /* tile in the row of tiles; cell in the tile, on x */

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

/* Sums the lines besides the first one for a block whose stencils and places are staged; begun [lines] and cut are as
   in MPMP2G. A run that sums none of them does not come here. */
MPM_INLINE void MPMSumLines(int dim, const MPMParams *par, const MPMPatch *patch, PetscInt parts,
                            const MPMBlockOrder *o, const MPMStencils *s, PetscReal *place[], PetscBool continues,
                            PetscBool cut, MPMRecord (*begun)[MPM_MAX_NODES])
{
  const size_t       line = MPMTileLine(dim, patch->basis);
  const MPMSumBlocks sum  = MPM_LANES_NAME(MPMSumLine)[dim - 1][MPMBasisNodes(patch->basis) - 2];
  MPMRecords         r;

  memset(&r, 0, sizeof r);
  for (int q = 1; q < MPM_NODE_LINES; q++) {
    PetscReal *at[MPM_STAGED];

    if (!MPMHasLine(parts, q)) continue;
    for (PetscInt c = 0; c < o->ncells; c++) at[c] = place[c] + (size_t)q * line;
    MPMStageLine(dim, par, patch, parts, q, o, s, &r);
    sum(o, s, &r, at, continues ? begun[q] : NULL, cut ? begun[q] : NULL);
  }
}

/* Sums mass (1), momentum (2) and forces (4), (13) of particles for the nodes, for the tiles of one pass. The early
   pass makes the sums of early tiles, for which other processes wait. The late pass makes those of late tiles while
   messages are under way. Both leave these sums in t->sum. The main pass works on one row of tiles after the other: it
   zeroes the sums of the row's other tiles in scratch, adds their particles to them, and adds the sums of all tiles of
   the row, those of t->sum too, to the nodes. Sums that are not among the parts get 0 added. */
MPM_INLINE void MPMP2G(int dim, const MPMParams *par, MPMPatch *patch, PetscInt parts)
{
  const int          forces = !(parts & MPM_P2G_FORCE) ? 0 : patch->particles.b || patch->grid->round ? 2 : 1;
  const int          affine = parts & MPM_AFFINE ? 1 : 0;
  const MPMSumBlocks sum    = MPM_LANES_NAME(MPMSumBlock)[dim - 1][MPMBasisNodes(patch->basis) - 2][forces][affine];
  const MPMTiles    *t      = &patch->tiles;
  const MPMPass   pass = parts & MPM_P2G_EARLY ? MPM_PASS_EARLY : parts & MPM_P2G_LATE ? MPM_PASS_LATE : MPM_PASS_MAIN;
  const PetscBool kept = pass == MPM_PASS_MAIN ? PETSC_FALSE : PETSC_TRUE;
  const PetscBool more = MPM_NODE_LINES > 1 && MPMNodeLines(parts) > 1 ? PETSC_TRUE : PETSC_FALSE;
  const MPMRange *runs = t->runs[pass], *end = runs + t->nruns[pass];
  const PetscInt *cell   = patch->particles.cell;
  PetscInt        closed = 0, blocks = 0; /* rows of tiles whose sums the nodes have; blocks so far */
  PetscBool       cut = PETSC_FALSE;      /* the last cell of a block continues in the next one */
  PetscReal      *place[MPM_STAGED];
  MPMRecord       begun[MPM_NODE_LINES][MPM_MAX_NODES] __attribute__((aligned(64)));
  MPMBlockOrder   o;
  MPMStencils     s;
  MPMRecords      r;
  MPMBlock        b;

  MPMStencilsBegin(dim, par, patch, &s);
  memset(&r, 0, sizeof r);
  if (forces) memset(&b, 0, sizeof b);
  if (kept) MPMOpenKept(dim, patch, parts, pass);
  while (runs < end) {
    const PetscInt row = runs->row;
    PetscInt       n   = 1; /* ranges that are taken together: those of a row of tiles, or all if sums are kept */

    while (runs + n < end && (kept || runs[n].row == row)) n++;
    while (!kept && closed < row)
      MPMCloseRow(dim, patch, parts, closed++); /* the row before, and rows without particles in this pass */
    if (!kept) MPMOpenRow(dim, patch, parts, row);
    if (parts & MPM_P2G_FBAR) MPM_LANES_NAME(MPMSumPressures)(dim, par, patch, n, runs);
    MPMFirstBlock(n, runs, &o);
    while (MPMNextBlock(dim, patch, n, runs, &o)) {
      PetscBool continues;

      MPMStage(dim, par, patch, &o, &s);
      MPMStagePlaces(dim, patch, kept, &o, place);
      if (forces) {
        MPMGatherState(dim, par, patch, MPM_MATERIAL_BITS, &o, &s, &b);
        MPM_FOR_MATERIALS(m, first, next, par, o.lanes, s.kind)
        if (!(m->state & MPM_BIT(tau))) MPMLaw(m)->stress[MPMLawForm(m, dim)](m, first, next, &b);
        if (parts & MPM_P2G_FBAR) MPM_LANES_NAME(MPMSharePressure)(dim, par, patch, &o, &s, &b);
      }
      if (parts & MPM_P2G_VOLUME) MPM_LANES_NAME(MPMStageVolumes)(dim, par, patch, &o, &s, &r);
      MPMStageRecords(dim, parts, patch, &o, &s, &b, par->outward, &r);
      continues = cut;
      cut       = o.next >= 0 && cell[o.next] == cell[o.particle[o.n - 1]] ? PETSC_TRUE : PETSC_FALSE;
      if (parts & MPM_P2G_CORE) sum(&o, &s, &r, place, continues ? begun[0] : NULL, cut ? begun[0] : NULL);
      if (more) MPMSumLines(dim, par, patch, parts, &o, &s, place, continues, cut, begun);
      if (patch->meanwhile && ++blocks % MPM_MEANWHILE == 0) patch->meanwhile(patch->ctx);
    }
    runs += n;
  }
  while (!kept && closed < t->n[1] * t->n[2]) MPMCloseRow(dim, patch, parts, closed++);
}

#endif
