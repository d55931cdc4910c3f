/* blocks.h - blocks of particles, in which transfers work: which entries of the order a block takes, and how the rows
   of its fields are read into lanes and written back. */
#ifndef MPM_BLOCKS_H
#define MPM_BLOCKS_H

#include "base/rows.h"
#include "base/masks.h"
#include "kernels/patch.h"

/* --- Blocks ------------------------------------------------------------------------------------------------------- */

/* The particles of a full block: as many as keep its scratch, of about 20 KiB, in the L1 cache. */
#define MPM_BLOCK_PARTICLES(dim) ((dim) < 3 ? MPM_STAGED : MPM_STAGED / 2)

/* The particles of a block, as n entries of the order, which has its particles by (cell, id). */
typedef struct {
  PetscInt        n, lanes;             /* lanes: n rounded up to whole vectors */
  PetscInt        run, entry;           /* where in the ranges of the order the next block begins */
  PetscInt        next;                 /* the particle after the last one in these ranges, or -1 */
  PetscBool       adjacent;             /* each particle's row follows that of the one before */
  PetscInt        particle[MPM_BLOCK];  /* the lanes past the last particle repeat it */
  const PetscInt *ahead;                /* entries of the next block, whose rows are prefetched */
  PetscInt ncells, end[MPM_STAGED + 1]; /* cells; the particles of cell c are those from end[c-1] to end[c] - 1 */
} MPMBlockOrder;

/* What the stencils of a patch need of an axis, as reals: the grid's lower end in m, h, 1/h and cells; the first node
   of the patch's arrays and how many there are; and in cells the reach of walls, the middle of a particle's cell from
   its base node, and the distance from there within which a particle surely is in that cell. */
typedef struct {
  PetscReal lower, h, inverse, cells, first, n, reach, middle, near;
  MPMBases  bases;
} MPMAxis;

/* The stencils of a block, and what the particles have from their kinds. */
typedef struct {
  MPMComponent    copy;                     /* from a base node to that of the copy, in the patch's arrays */
  MPMComponent    base;                     /* index of the base node in the patch's arrays, a whole number */
  MPMComponent    x[3], l[3], m, V0, at[3]; /* at: distance from the base node in cells */
  MPMComponent    has_F;                    /* 1 if the material has F, else 0 */
  MPMComponent    w[3][MPM_MAX_STENCIL], g[3][MPM_MAX_STENCIL]; /* weights and gradients on each axis, 1 and 1/m */
  MPMAxis         axis[3];
  PetscInt        kind[MPM_BLOCK];
  PetscReal       stride; /* to the next node on the axis of the copies' places, in the patch's arrays; 0: one place */
  const PetscInt *place, *first; /* of each copy; of each place, as MPMGrid has them */
  PetscBool       walled;        /* some particle has weights that a wall changes */
} MPMStencils;

/* Takes the next block of the particles of `nruns` ranges of the order, from where the one before ended; returns
   PETSC_FALSE if there are no more particles. All blocks but the last are full, so loops over them have the same length
   each time. A block may end within a cell: that costs little and changes no bits. */
MPM_INLINE PetscBool MPMNextBlock(int dim, const MPMPatch *patch, PetscInt nruns, const MPMRange *runs,
                                  MPMBlockOrder *o)
{
  const PetscInt full = MPM_BLOCK_PARTICLES(dim);
  PetscInt       n = 0, jumps = 0;

  while (n < full && o->run < nruns) {
    const PetscInt *from = patch->order + o->entry, len = PetscMin(full - n, runs[o->run].last - o->entry);

    for (PetscInt l = 0; l < len; l++) o->particle[n + l] = from[l];
    n += len;
    o->entry += len;
    if (o->entry == runs[o->run].last && ++o->run < nruns) o->entry = runs[o->run].first;
  }
  if (n == full) /* only of a full block, and with no early exit, so that the compiler makes vectors of it */
    for (PetscInt l = 0; l < full; l++) jumps |= o->particle[l] - l - o->particle[0];
  for (PetscInt l = n; n && l % MPM_WIDTH; l++) o->particle[l] = o->particle[n - 1];
  o->n        = n;
  o->lanes    = (n + MPM_WIDTH - 1) / MPM_WIDTH * MPM_WIDTH;
  o->next     = o->run < nruns ? patch->order[o->entry] : -1;
  o->adjacent = !jumps && n == full ? PETSC_TRUE : PETSC_FALSE;
  o->ahead    = patch->order + PetscMin(o->entry, patch->particles.n - n);
  return n ? PETSC_TRUE : PETSC_FALSE;
}

/* Begins with the first range, before the first call of MPMNextBlock. */
MPM_INLINE void MPMFirstBlock(PetscInt nruns, const MPMRange *runs, MPMBlockOrder *o)
{
  o->run   = 0;
  o->entry = nruns ? runs[0].first : 0;
}

/* Prefetches rows of the next block, at the places of particles l to l + MPM_WIDTH - 1 of this one. A line of the cache
   holds 8 numbers. Neighbours in the order are mostly neighbours in memory: if a line holds two rows, every other row
   is enough. A row of 9 needs its second line too. */
MPM_INLINE void MPMFetch(int nc, const PetscReal *own, const MPMBlockOrder *o, PetscInt l)
{
  const int step = 2 * nc > 8 ? 1 : 2;

  if (l + MPM_WIDTH > o->n) return; /* `ahead` may end with the order */
  for (int k = 0; k < MPM_WIDTH; k += step) {
    __builtin_prefetch(own + (size_t)o->ahead[l + k] * nc);
    if (nc > 8) __builtin_prefetch(own + (size_t)o->ahead[l + k] * nc + 8);
  }
}

/* Reads the rows of nc components of a block's particles from l on, one a lane, to the vectors of their components; the
   lanes past the last particle repeat it. `own` are the rows of all particles. */
MPM_INLINE void MPMLoad(int nc, const PetscReal *own, const MPMBlockOrder *o, PetscInt l, MPMReal *to)
{
  const PetscReal *row[MPM_WIDTH];

  if (o->adjacent) { /* then the rows of the next blocks mostly follow; one block (3-D: two) ahead is prefetched */
    row[0] = own + (size_t)(o->particle[0] + l) * nc;
    for (int c = 0; c < nc * MPM_WIDTH; c += 8) __builtin_prefetch(row[0] + MPM_STAGED * nc + c);
    MPMTranspose(nc, row[0], to);
  } else {
    MPMFetch(nc, own, o, l);
    for (int k = 0; k < MPM_WIDTH; k++) row[k] = own + (size_t)o->particle[l + k] * nc;
    MPMReadRows(nc, row, to);
  }
}

/* Writes the vectors of nc components of a block's particles from l on to the rows of those among first .. last-1. The
   lanes past the last particle must repeat it. */
MPM_INLINE void MPMStore(int nc, const MPMReal *from, const MPMBlockOrder *o, PetscInt l, PetscInt first, PetscInt last,
                         PetscReal *own)
{
  const PetscBool whole = first <= l && l + MPM_WIDTH <= last ? PETSC_TRUE : PETSC_FALSE;
  PetscReal      *row[MPM_WIDTH], others[9]; /* the lanes of other particles are written here and not used */

  if (o->adjacent && whole)
    MPMTransposeBack(nc, from, own + (size_t)(o->particle[0] + l) * nc);
  else {
    for (int k = 0; k < MPM_WIDTH; k++)
      row[k] = whole || (first <= l + k && l + k < last) ? own + (size_t)o->particle[l + k] * nc : others;
    MPMWriteRows(nc, from, row);
  }
}

/* MPMGather and MPMScatter do so for all vectors of a block; MPMScatter for particles first .. last-1. */
MPM_INLINE void MPMGather(int nc, const PetscReal *own, const MPMBlockOrder *o, MPMComponent *to)
{
  for (PetscInt l = 0; l < o->lanes; l += MPM_WIDTH) {
    MPMReal lanes[9];

    MPMLoad(nc, own, o, l, lanes);
    for (int c = 0; c < nc; c++) MPMWrite(&to[c][l], lanes[c]);
  }
}

MPM_INLINE void MPMScatter(int nc, const MPMComponent *from, const MPMBlockOrder *o, PetscInt first, PetscInt last,
                           PetscReal *own)
{
  for (PetscInt l = first - first % MPM_WIDTH; l < last; l += MPM_WIDTH) {
    MPMReal lanes[9];

    for (int c = 0; c < nc; c++) lanes[c] = MPMRead(&from[c][l]);
    MPMStore(nc, lanes, o, l, first, last, own);
  }
}

#endif
