/* transfer.h - the two kernels of the Material Particle Method: particles to nodes (P2G) and nodes to particles (G2P).

   Each is written once, for vectors of MPM_WIDTH lanes (lanes.h); dim is a compile-time constant of always-inlined
   functions, and so is the basis where weights are made. transfer_lanes.c instantiates them and is compiled once a
   width, as are the innermost loops, in transfer_sums.c. P2G goes down this map; G2P goes over the same blocks:

     order    particles by (cell, id), in runs (MPMRange): G2P takes all as one, P2G those of a row of tiles at a time.
     blocks   of MPM_STAGED particles of these runs, whatever their cells. Their rows are gathered into scratch in L1
   (3-D: |      or near); weights, stress, new v, F and x are made there: lanes are particles (MPMBlockOrder,
   MPMStencils). cells    particles of a block with the same base node, added up in local accumulators: lanes are the
   sums of a node. |      A cell may go on in the next block. G2P: the motion of the cell's nodes to its particles,
   which are lanes. tiles    of 2 or 4 cells an axis, with sums of their own for all nodes that their particles touch:
   of open tiles in |      scratch, of early and late ones kept (MPMPass) until the main pass closes their row (tile_sums.h).
     nodes    patch->sum, which gets the sums of a row of tiles, tile by tile, when the row is closed.

   A cell is its base node, s->base, an index of the patch's arrays; its number in the table of tiles, particles.cell,
   is what the order goes by. The tree of additions - particles of a cell by id, cells of a tile, tiles of a node -
   depends on cells and ids alone, never on blocks, lanes or processes. Equation numbers: docs/theory.md. In: particles
   x v F kind id cell state, and l b C r dx where a scene has them; nodes vel. Out: nodes sum; particles v F x dx cell,
   and state tau C r likewise; status. For a first reading leave out what has to do with walls and with MPMBegun.     */
#ifndef MPM_TRANSFER_H
#define MPM_TRANSFER_H

#include "tile_sums.h"
#include "rows.h"

#if defined(__clang__)
#define MPM_UNROLL _Pragma("unroll")
#else
#define MPM_UNROLL _Pragma("GCC unroll 64")
#endif

/* --- Blocks ------------------------------------------------------------------------------------------------------- */

typedef PetscReal MPMRow[MPM_BLOCK]; /* a component of the particles of a block; lanes past the last hold leftovers */

/* The particles of a block: n entries of the order. */
typedef struct {
  PetscInt        n, run, entry;        /* run, entry of the order: where the next block begins */
  PetscBool       adjacent;             /* does each particle's row follow that of the one before? */
  PetscInt        particle[MPM_BLOCK];  /* the last one again in the lanes past it */
  const PetscInt *ahead;                /* entries a block further on, whose rows are fetched in advance */
  PetscInt ncells, end[MPM_STAGED + 1]; /* cells; the particles of cell c are those from end[c-1] to end[c] - 1 */
} MPMBlockOrder;

/* Stencils of a block. */
typedef struct {
  PetscInt kind[MPM_BLOCK];
  MPMRow   base;                     /* index of the base node in the patch's arrays, a whole number */
  MPMRow   x[3], l[3], m, V0, at[3]; /* at: from the base node, in cells */
  MPMRow   w[3][MPM_MAX_STENCIL], g[3][MPM_MAX_STENCIL]; /* weights and gradients per axis, 1 and 1/m */
} __attribute__((aligned(64))) MPMStencils;

/* The next block of the particles of `nruns` runs, from where the one before ended. All blocks but the last are full,
   so that loops over them are as long every time; a cell that is cut costs little, and no bits. PETSC_FALSE: there are
   no more particles. */
MPM_INLINE PetscBool MPMNextBlock(const MPMPatch *patch, PetscInt nruns, const MPMRange *runs, MPMBlockOrder *o)
{
  PetscInt n = 0, jumps = 0;

  while (n < MPM_STAGED && o->run < nruns) {
    const PetscInt *from = patch->order + o->entry, len = PetscMin(MPM_STAGED - n, runs[o->run].last - o->entry);

    for (PetscInt l = 0; l < len; l++) o->particle[n + l] = from[l];
    n += len;
    o->entry += len;
    if (o->entry == runs[o->run].last && ++o->run < nruns) o->entry = runs[o->run].first;
  }
  if (n == MPM_STAGED) /* of a full block alone, and to its end whatever is found: this becomes vectors */
    for (PetscInt l = 0; l < MPM_STAGED; l++) jumps |= o->particle[l] - l - o->particle[0];
  for (PetscInt l = n; n && l % MPM_WIDTH; l++) o->particle[l] = o->particle[n - 1];
  o->n        = n;
  o->adjacent = !jumps && n == MPM_STAGED ? PETSC_TRUE : PETSC_FALSE;
  o->ahead    = patch->order + PetscMin(o->entry, patch->particles.n - n);
  return n ? PETSC_TRUE : PETSC_FALSE;
}

MPM_INLINE void MPMFirstBlock(PetscInt nruns, const MPMRange *runs, MPMBlockOrder *o)
{
  o->run   = 0;
  o->entry = nruns ? runs[0].first : 0;
}

/* Fetches rows of a block further on, those that stand where particles l to l + MPM_WIDTH - 1 do in this one. A line of
   the cache holds 8 numbers. As neighbours in the order mostly are in memory, every other row brings the one after it
   along if a line holds two; a row of 9 needs its second line too. */
MPM_INLINE void MPMFetch(int nc, const PetscReal *own, const MPMBlockOrder *o, PetscInt l)
{
  const int step = 2 * nc > 8 ? 1 : 2;

  if (l + MPM_WIDTH > o->n) return; /* ahead may end with the order */
  for (int k = 0; k < MPM_WIDTH; k += step) {
    __builtin_prefetch(own + (size_t)o->ahead[l + k] * nc);
    if (nc > 8) __builtin_prefetch(own + (size_t)o->ahead[l + k] * nc + 8);
  }
}

/* Rows of nc components of the block's particles -> lanes; the lanes past the last particle repeat it. */
MPM_INLINE void MPMGather(int nc, const PetscReal *own, const MPMBlockOrder *o, MPMRow *to)
{
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
    const PetscReal *row[MPM_WIDTH];
    MPMReal          lanes[9];

    MPMFetch(nc, own, o, l);
    if (o->adjacent)
      MPMTranspose(nc, own + (size_t)(o->particle[0] + l) * nc, lanes);
    else {
      for (int k = 0; k < MPM_WIDTH; k++) row[k] = own + (size_t)o->particle[l + k] * nc;
      MPMReadRows(nc, row, lanes);
    }
    for (int c = 0; c < nc; c++) MPMWrite(&to[c][l], lanes[c]);
  }
}

/* Lanes of particles first .. last-1 -> rows of own particles. */
MPM_INLINE void MPMScatter(int nc, const MPMRow *from, const MPMBlockOrder *o, PetscInt first, PetscInt last,
                           PetscReal *own)
{
  PetscReal others[9]; /* where the lanes of other particles go */

  for (PetscInt l = first - first % MPM_WIDTH; l < last; l += MPM_WIDTH) {
    PetscReal *row[MPM_WIDTH];
    MPMReal    lanes[9];

    if (first <= l && l + MPM_WIDTH <= last)
      for (int k = 0; k < MPM_WIDTH; k++) row[k] = own + (size_t)o->particle[l + k] * nc;
    else
      for (int k = 0; k < MPM_WIDTH; k++)
        row[k] = first <= l + k && l + k < last ? own + (size_t)o->particle[l + k] * nc : others;
    for (int c = 0; c < nc; c++) lanes[c] = MPMRead(&from[c][l]);
    MPMWriteRows(nc, lanes, row);
  }
}

/* Mass, volume and half-widths of kind k for particles first .. last-1. */
MPM_INLINE void MPMStageKind(int dim, const MPMKind *k, PetscInt first, PetscInt last, MPMStencils *s)
{
  for (PetscInt l = first; l < last; l++) {
    s->m[l]  = k->m;
    s->V0[l] = k->V0;
    for (int d = 0; d < dim; d++) s->l[d][l] = k->l[d];
  }
}

/* What stays the same from block to block. */
MPM_INLINE void MPMStencilsBegin(int dim, const MPMParams *par, MPMStencils *s)
{
  memset(s, 0, sizeof *s);
  MPMStageKind(dim, par->kinds, 0, MPM_BLOCK, s);
}

/* The weights of a spline near walls, particle by particle. */
static __attribute__((noinline)) void MPMStageWalls(int dim, MPMBasis basis, const MPMGrid *grid, PetscInt n,
                                                    MPMStencils *s)
{
  for (PetscInt l = 0; l < n; l++)
    for (int d = 0; d < dim; d++) {
      const PetscReal cells = (PetscReal)grid->cells[d], xi = (s->x[d][l] - grid->lower[d]) / grid->h[d];
      PetscReal       w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];

      if (!MPMWallWeights(basis, PetscMin(xi, cells), grid->cells[d], grid->wall_basis[d], w, g)) continue;
      for (int i = 0; i < MPMBasisNodes(basis); i++) {
        s->w[d][i][l] = w[i];
        s->g[d][i][l] = g[i] * (1 / grid->h[d]);
      }
    }
}

/* Coordinate in cells and base node along axis d of particles at x with half-widths l, as MPMCoordinates finds them. */
MPM_INLINE MPMReal MPMBasesOf(MPMBasis basis, const MPMGrid *grid, int d, MPMReal x, MPMReal l, MPMReal *xi)
{
  *xi = MPMMin((x - grid->lower[d]) / grid->h[d], MPMAll((PetscReal)grid->cells[d])); /* the quotient may round up */
  return MPMBasisBases(basis, xi, l, grid->cells[d], grid->periodic[d], grid->wall_basis[d]);
}

/* Base nodes and weights of a block of particles; x was checked when it was committed. */
MPM_INLINE void MPMStageWeights(int dim, MPMBasis basis, const MPMPatch *patch, PetscInt n, MPMStencils *s)
{
  const MPMGrid grid = *patch->grid; /* a copy, which no write can change: its numbers stay in registers */
  MPMMask       wall = MPMNone();    /* particles whose stencil a wall changes */

  for (int d = dim - 1; d >= 0; d--) {
    const PetscReal reach = MPMBasisIsSpline(basis) ? MPMWallReach(basis, grid.wall_basis[d]) : 0;
    const PetscReal rh = 1 / grid.h[d], cells = (PetscReal)grid.cells[d];
    const PetscReal lo = (PetscReal)patch->lo[d], nodes = (PetscReal)patch->n[d];

    for (PetscInt q = 0; q < n; q += MPM_WIDTH) {
      const MPMReal l = MPMRead(&s->l[d][q]);
      MPMReal       xi, base, w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];

      base = MPMBasesOf(basis, &grid, d, MPMRead(&s->x[d][q]), l, &xi);
      MPMBasisInside(basis, xi, l, base, w, g);
      MPMWrite(&s->base[q], d == dim - 1 ? base - lo : MPMRead(&s->base[q]) * nodes + (base - lo));
      MPMWrite(&s->at[d][q], xi - base);
      for (int i = 0; i < MPMBasisNodes(basis); i++) {
        MPMWrite(&s->w[d][i][q], w[i]);
        MPMWrite(&s->g[d][i][q], g[i] * rh);
      }
      if (MPMBasisIsSpline(basis)) wall |= (xi < reach) | (cells - xi < reach);
    }
  }
  if (MPMBasisIsSpline(basis) && MPMAny(wall)) MPMStageWalls(dim, basis, patch->grid, n, s);
}

/* Stencils of a block of particles, and where its cells end. */
MPM_INLINE void MPMStage(int dim, const MPMParams *par, const MPMPatch *patch, MPMBlockOrder *o, MPMStencils *s)
{
  MPMBits ends = {0};

  MPMGather(dim, patch->particles.x, o, s->x);
  for (PetscInt l = 0; l < o->n && par->nkinds > 1; l++) {
    s->kind[l] = patch->particles.kind[o->particle[l]];
    MPMStageKind(dim, par->kinds + s->kind[l], l, l + 1, s);
  }
  if (patch->particles.l) MPMGather(dim, patch->particles.l, o, s->l);
  switch (patch->basis) {
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  case MPM_BASIS_##name:                                                                                               \
    MPMStageWeights(dim, MPM_BASIS_##name, patch, o->n, s);                                                            \
    break;
#include "basis.def"
#undef MPM_BASIS
  default:
    break;
  }
  /* A cell ends where the next particle has another base node. The last particle is compared with leftovers past it:
     its mark is n, and MPMList takes only those below. */
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH)
    ends = MPMCollect(MPMRead(&s->base[l]) != MPMRead(&s->base[l] + 1), l + 1, ends);
  o->ncells             = MPMList(ends, o->n, o->end) + 1;
  o->end[o->ncells - 1] = o->n;
}

#define MPM_MAX_NODES (MPM_MAX_STENCIL * MPM_MAX_STENCIL * MPM_MAX_STENCIL)

MPM_INLINE int MPMStencilNodes(int dim, MPMBasis basis)
{
  const int ns = MPMBasisNodes(basis);

  return ns * (dim > 1 ? ns : 1) * (dim > 2 ? ns : 1);
}

/* Offsets of the nodes of a stencil from its base node in the patch's arrays, x fastest, times nc. */
MPM_INLINE void MPMStencilOffsets(int dim, const MPMPatch *patch, PetscInt nc, PetscInt at[])
{
  const PetscInt ns = MPMBasisNodes(patch->basis), ny = dim > 1 ? ns : 1;

  for (PetscInt a = 0; a < MPMStencilNodes(dim, patch->basis); a++)
    at[a] = nc * (a % ns + (a / ns % ny + a / (ns * ny) * patch->n[1]) * patch->n[0]);
}

/* --- Materials ---------------------------------------------------------------------------------------------------- */

/* For each stretch of particles of the same material among the n of a block: declares m, the material, and its
   particles, first to next-1. (The inner loop, of one round, is there for the declaration of m.) */
#define MPM_FOR_MATERIALS(m, first, next, par, n, kind)                                                                \
  for (PetscInt first = 0, next = 0; first < (n); first = next)                                                        \
    for (const MPMMaterial *m = MPMSameMaterial(par, n, kind, first, &next); m; m = NULL)

MPM_INLINE const MPMMaterial *MPMSameMaterial(const MPMParams *par, PetscInt n, const PetscInt *kind, PetscInt first,
                                              PetscInt *next)
{
  const PetscInt row = par->kinds[kind[first]].material;

  *next = n;
  if (par->nkinds > 1)
    for (*next = first + 1; *next < n && par->kinds[kind[*next]].material == row;) (*next)++;
  return par->materials + row;
}

/* The functions of a material, those for this width if it has some. */
MPM_INLINE const MPMMaterialLaw *MPMLaw(const MPMMaterial *m)
{
  const MPMMaterialLaw *law = m->type->law->lanes[MPM_WIDTH == 8 ? 0 : MPM_WIDTH == 4 ? 1 : 2];

  return law ? law : m->type->law;
}

/* Reads the state of a block's particles as far as the phase declared it and the scene has it. */
MPM_INLINE void MPMGatherState(int dim, const MPMPatch *patch, const MPMBlockOrder *o, MPMBlock *b)
{
#define MPM_GATHER(name, rows)                                                                                         \
  if (patch->particles.name) MPMGather(MPMComponents_##name(dim), patch->particles.name, o, b->name);
  MPM_MATERIAL_FIELDS(MPM_GATHER)
#undef MPM_GATHER
}

/* --- What is rare, so one particle at a time in transfer.c -----------------------------------------------------------
 */

void MPMNoteBad(MPMStatus *, MPMBad, PetscInt64 id, PetscInt dim, const PetscReal x[], PetscReal J);
void MPMNoteBadJ(PetscInt dim, const MPMPatch *, PetscBool has_F, PetscInt first, PetscInt last, const PetscInt *order,
                 const MPMBlock *, MPMStatus *);
void MPMWrap(PetscInt dim, const MPMGrid *, PetscInt n, MPMRow *x);
void MPMStretchDomains(PetscInt dim, const MPMParams *, MPMPatch *, PetscInt n, const PetscInt *order, const MPMRow *x,
                       MPMStatus *);

/* --- Particles to nodes ----------------------------------------------------------------------------------------------
 */

/* What a particle adds to node i of its stencil: phi Q[0] + sum_e dphi_e Q[1+e] + sum_e i_e phi A[e], where each is a
   record of numbers that are laid out as the sums of a node (mpm.h). MPMP2G zeroes all of them once; what its parts do
   not ask for is never written and stays 0. */
enum { MPM_Q_RECORDS = 4, MPM_A_RECORDS = 3 }; /* of a particle, in every dimension */
typedef PetscReal MPMRecord[MPM_SUM_NC(3)];
typedef struct {
  MPMRecord Q[MPM_STAGED][MPM_Q_RECORDS], A[MPM_STAGED][MPM_A_RECORDS];
} __attribute__((aligned(64))) MPMRecords;

/* nc numbers of MPM_WIDTH particles into a record of each, from the place `to` in that of the first; a particle has
   `records` of them. Pairs are written faster than single numbers: an odd nc takes from[nc] along, which is 0, as is
   what the record has in that place. */
MPM_INLINE void MPMWriteRecords(int nc, const MPMReal *from, PetscReal *to, int records)
{
  PetscReal *row[MPM_WIDTH];

  for (int k = 0; k < MPM_WIDTH; k++) row[k] = to + k * records * MPM_SUM_NC(3);
  MPMWriteRows(nc + nc % 2, from, row);
}

/* The records of a block: Q[0] = (m, m v | m b), Q[1+e] = (0 | - V0 tau_e), with V sig = V0 tau; with the affine part
   v + C (x_i - x_p) of velocity, x_i - x_p = (i - at) h. */
MPM_INLINE void MPMStageRecords(int dim, PetscInt parts, const MPMPatch *patch, const MPMBlockOrder *o,
                                const MPMStencils *s, const MPMBlock *b, MPMRecords *r)
{
  MPMRow          v[3], force[3], C[9];
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
        MPMWriteRecords(dim, Q, r->Q[l][1 + e] + MPM_SUM_FORCE, MPM_Q_RECORDS);
      }
    }
  if ((parts & MPM_P2G_FORCE) && patch->particles.b) {
    MPMGather(dim, patch->particles.b, o, force);
    for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
      MPMReal Q[4] = {MPMAll(0), MPMAll(0), MPMAll(0), MPMAll(0)};

      for (int d = 0; d < dim; d++) Q[d] = MPMRead(&s->m[l]) * MPMRead(&force[d][l]);
      MPMWriteRecords(dim, Q, r->Q[l][0] + MPM_SUM_FORCE, MPM_Q_RECORDS);
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
                                     const PetscReal *nodes, MPMRow *value, MPMRow *gradient);
/* [dim-1][nodes per axis - 2][forces][affine], [..][..][motion][stress] */
extern const MPMSumBlocks         MPM_LANES_NAME(MPMSumBlock)[3][3][2][2];
extern const MPMInterpolateBlocks MPM_LANES_NAME(MPMInterpolateBlock)[3][3][2][2];

/* Adds the sums that the last block left begun to their nodes, as any new cell does: here one of no particles, nowhere.
 */
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
      sums  = (kept ? t->sum : t->scratch) + MPM_SUM_NC(dim) * (at[2] * side + at[1]) * side;
    }
    tile     = (cell - begin) >> t->bits;
    in       = (cell - begin) & ((1 << t->bits) - 1);
    place[c] = sums + (size_t)(kept ? t->slot[left + tile] : tile) * size + MPM_SUM_NC(dim) * in;
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

/* --- Nodes to particles ----------------------------------------------------------------------------------------------
 */

/* New F and material state of a block from its velocity gradients L [dim*dim] in 1/s: eqs. (10) to (12); checks J;
   speeds of waves. */
MPM_INLINE void MPMUpdateState(int dim, const MPMParams *par, MPMPatch *patch, const MPMBlockOrder *o,
                               const MPMStencils *s, MPMRow *L, MPMBlock *b, MPMReal *c2max, MPMStatus *status)
{
  const MPMView *particles = &patch->particles;

  MPMGatherState(dim, patch, o, b);
  MPM_FOR_MATERIALS(m, first, next, par, o->n, s->kind)
  {
    const MPMMaterialLaw *law   = MPMLaw(m);
    const PetscInt        from  = first - first % MPM_WIDTH;
    const PetscBool       has_F = m->state & MPM_BIT(F) ? PETSC_TRUE : PETSC_FALSE;
    MPMMask               bad   = MPMNone();
    MPMRow                c2;

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
    if (MPMAny(bad)) MPMNoteBadJ(dim, patch, has_F, first, next, o->particle, b, status);
    law->speed2[dim - 1](m, first, next, b, c2);
    for (PetscInt l = from; l < next; l += MPM_WIDTH)
      *c2max = MPMMax(*c2max, MPMSelect(MPMBetween(l, first, next), MPMRead(c2 + l), MPMAll(0)));
#define MPM_SCATTER(name, rows)                                                                                        \
  if (m->state & MPM_BIT(name)) MPMScatter(MPMComponents_##name(dim), b->name, o, first, next, particles->name);
    MPM_MATERIAL_FIELDS(MPM_SCATTER)
#undef MPM_SCATTER
  }
}

/* New velocities v of a block from vn = sum phi v', an = sum phi a (8), and displacements dx (9), which may take the
   place of vn. r: of xpic, the part of the old v that the grid did not take up, which is dropped; else NULL. */
MPM_INLINE void MPMMove(int dim, const MPMParams *par, PetscInt n, MPMRow *v, const MPMRow *r, const MPMRow *vn,
                        const MPMRow *an, MPMRow *dx, MPMReal *v2max)
{
  const PetscReal dt = par->dt, flip = par->flip, pic = 1 - par->flip;

  for (PetscInt l = 0; l < n; l += MPM_WIDTH) {
    MPMReal v2 = MPMAll(0);

    for (int d = 0; d < dim; d++) {
      const MPMReal now = MPMRead(&vn[d][l]), step = dt * MPMRead(&an[d][l]), old = MPMRead(&v[d][l]);
      const MPMReal to = r ? old - MPMRead(&r[d][l]) + step : flip * (old + step) + pic * now;

      v2 += to * to;
      MPMWrite(&v[d][l], to);
      MPMWrite(&dx[d][l], dt * (r ? to : now));
    }
    *v2max = MPMMax(*v2max, MPMSelect(MPMBetween(l, 0, n), v2, MPMAll(0)));
  }
}

/* The base nodes of n particles where they are now: on each axis from the patch's first own one, and their index in the
   arrays as in s->base, or MPM_ELSEWHERE or MPM_NOWHERE. */
MPM_INLINE void MPMFindBases(int dim, MPMBasis basis, const MPMPatch *patch, PetscInt n, const MPMStencils *s,
                             MPMRow *at, PetscReal *base)
{
  const MPMGrid grid = *patch->grid;

  for (PetscInt l = 0; l < n; l += MPM_WIDTH) {
    MPMReal index  = MPMAll(0);
    MPMMask inside = MPMNot(MPMNone()), own = inside;

    for (int d = dim - 1; d >= 0; d--) {
      const PetscReal lo = (PetscReal)patch->own_lo[d], below = (PetscReal)(patch->own_lo[d] - patch->lo[d]);
      const MPMReal   x = MPMRead(&s->x[d][l]);
      MPMReal         xi, node = MPMBasesOf(basis, &grid, d, x, MPMRead(&s->l[d][l]), &xi) - lo;

      inside &= (x >= grid.lower[d]) & (x <= grid.upper[d]);
      own &= (node >= 0) & (node < (PetscReal)patch->own_n[d]);
      index = index * (PetscReal)patch->n[d] + (node + below);
      MPMWrite(&at[d][l], node);
    }
    MPMWrite(base + l, MPMSelect(inside, MPMSelect(own, index, MPMAll(MPM_ELSEWHERE)), MPMAll(MPM_NOWHERE)));
  }
}

/* Particle l of a block has another base node than before, with that index and at that place: numbers its cell, and
   notes it (MPMPatch); entry: its place in the order. Did it leave the patch? */
MPM_INLINE PetscBool MPMNoteMover(int dim, MPMPatch *patch, PetscInt entry, const MPMBlockOrder *o,
                                  const MPMStencils *s, PetscInt l, PetscInt index, const MPMRow *at, MPMStatus *status)
{
  const PetscInt p       = o->particle[l];
  PetscInt       cell    = index; /* where it has none */
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

    MPMNoteBad(status, MPM_LEFT_GRID, patch->particles.id[p], dim, x, 0);
  }
  return cell < 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* x <- x + dx and the cell it is in now. Only particles that changed cell are numbered anew: they are few. Counts them
   and those that left the patch. q: where in the order the block begins. */
MPM_INLINE void MPMCommit(int dim, const MPMParams *par, MPMPatch *patch, PetscInt q, const MPMBlockOrder *o,
                          MPMStencils *s, const MPMRow *dx, MPMStatus *status)
{
  const MPMGrid *grid  = patch->grid;
  MPMMask        wraps = MPMNone();
  MPMBits        moves = {0};
  MPMRow         at[3], now; /* base nodes: from the first own one; their index, to be compared with s->base */
  PetscInt       moved, which[MPM_STAGED];

  for (int d = 0; d < dim; d++)
    for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
      const MPMReal x = MPMRead(&s->x[d][l]) + MPMRead(&dx[d][l]);

      MPMWrite(&s->x[d][l], x);
      if (grid->periodic[d]) wraps |= MPMBetween(l, 0, o->n) & MPMNot((x >= grid->lower[d]) & (x < grid->upper[d]));
    }
  if (MPMAny(wraps)) MPMWrap(dim, grid, o->n, s->x);
  MPMScatter(dim, s->x, o, 0, o->n, patch->particles.x);
  if (patch->particles.l) {
    MPMStretchDomains(dim, par, patch, o->n, o->particle, s->x, status);
    MPMGather(dim, patch->particles.l, o, s->l);
  }
  switch (patch->basis) {
#define MPM_BASIS(name, nodes, layers, inertia, what)                                                                  \
  case MPM_BASIS_##name:                                                                                               \
    MPMFindBases(dim, MPM_BASIS_##name, patch, o->n, s, at, now);                                                      \
    break;
#include "basis.def"
#undef MPM_BASIS
  default:
    break;
  }
  for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) moves = MPMCollect(MPMRead(&now[l]) != MPMRead(&s->base[l]), l, moves);
  moved = MPMList(moves, o->n, which);
  for (PetscInt k = 0; k < moved; k++)
    status->left += MPMNoteMover(dim, patch, q + which[k], o, s, which[k], (PetscInt)now[which[k]], at, status);
}

/* Affine velocities C of a block (APIC): of a basis without inertia they are the velocity gradient L; else
   sum phi v (x_i - x) over the inertia, found as a gradient whose g is w (i - at): s->g is overwritten, so this comes
   after all that needs it. C: room for them, before they go to their rows. */
MPM_INLINE void MPMAffine(int dim, const MPMPatch *patch, const PetscInt at[], const MPMBlockOrder *o, MPMStencils *s,
                          MPMRow *C)
{
  const int ns = MPMBasisNodes(patch->basis), inertia = MPMBasisInertia(patch->basis);

  for (int d = 0; d < dim && inertia; d++)
    for (int i = 0; i < ns; i++)
      for (PetscInt l = 0; l < o->n; l += MPM_WIDTH) {
        const MPMReal away = MPMAll(i) - MPMRead(&s->at[d][l]);
        MPMWrite(&s->g[d][i][l], MPMRead(&s->w[d][i][l]) * away * ((PetscReal)inertia / patch->grid->h[d]));
      }
  MPM_LANES_NAME(MPMInterpolateBlock)[dim - 1][ns - 2][0][1](o, s, at, patch->vel, NULL, C);
  MPMScatter(dim * dim, C, o, 0, o->n, patch->particles.C);
}

/* From nodes to particles: motion (8), (9); velocity gradient (3), F and state; commit of the new position; filter of
   xpic. */
MPM_INLINE void MPMG2P(int dim, const MPMParams *par, MPMPatch *patch, PetscInt parts, MPMStatus *status)
{
  const int      motion = parts & (MPM_G2P_MOTION | MPM_G2P_FILTER) ? 1 : 0, stress = parts & MPM_G2P_STRESS ? 1 : 0;
  const MPMView *particles               = &patch->particles;
  const MPMRange all                     = {0, particles->n, 0};
  const MPMInterpolateBlocks interpolate = MPM_LANES_NAME(
      MPMInterpolateBlock)[dim - 1][MPMBasisNodes(patch->basis) - 2][motion][stress];
  PetscInt      at[MPM_MAX_NODES];
  MPMBlockOrder o;
  MPMReal       v2 = MPMAll(0), c2 = MPMAll(0);
  MPMRow        value[6], L[9], v[3], r[3];
  MPMRow *const vn = value, *const an = value + dim, *const dx = vn; /* sum phi v', sum phi a; dx in place of vn */
  MPMStencils s;
  MPMBlock    b;

  MPMStencilsBegin(dim, par, &s);
  memset(&b, 0, sizeof b);
  memset(value, 0, sizeof value);
  memset(v, 0, sizeof v);
  memset(r, 0, sizeof r);
  MPMStencilOffsets(dim, patch, MPM_VEL_NC(dim), at);
  patch->nmovers = 0;
  MPMFirstBlock(1, &all, &o);
  while (MPMNextBlock(patch, 1, &all, &o)) {
    MPMStage(dim, par, patch, &o, &s);
    if (interpolate) interpolate(&o, &s, at, patch->vel, value, L);
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
    if (stress) MPMUpdateState(dim, par, patch, &o, &s, L, &b, &c2, status);
    if (parts & MPM_AFFINE) MPMAffine(dim, patch, at, &o, &s, L); /* L is of no more use */
    if (parts & MPM_G2P_COMMIT) {                                 /* after the new state, which may change the domain */
      const PetscInt q = o.entry - o.n; /* of the one run that there is, the last n entries that were taken */

      if (!motion) MPMGather(dim, particles->dx, &o, dx);
      MPMCommit(dim, par, patch, q, &o, &s, dx, status);
    }
  }
  status->v2 = PetscMax(status->v2, MPMLargest(v2));
  status->c2 = PetscMax(status->c2, MPMLargest(c2));
}

#endif
