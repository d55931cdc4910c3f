/* blocks.h - blocks of particles: which entries of the order they take, and how the rows of their fields come into
   lanes and go back. */
#ifndef MPM_BLOCKS_H
#define MPM_BLOCKS_H

#include "base/rows.h"
#include "kernels/patch.h"

#if defined(__clang__)
#define MPM_UNROLL _Pragma("unroll")
#else
#define MPM_UNROLL _Pragma("GCC unroll 64")
#endif

/* --- Blocks ------------------------------------------------------------------------------------------------------- */

typedef PetscReal
    MPMComponent[MPM_BLOCK]; /* a component of the particles of a block; lanes past the last hold leftovers */

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
  PetscInt     kind[MPM_BLOCK];
  MPMComponent base;                     /* index of the base node in the patch's arrays, a whole number */
  MPMComponent x[3], l[3], m, V0, at[3]; /* at: from the base node, in cells */
  MPMComponent w[3][MPM_MAX_STENCIL], g[3][MPM_MAX_STENCIL]; /* weights and gradients per axis, 1 and 1/m */
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
MPM_INLINE void MPMGather(int nc, const PetscReal *own, const MPMBlockOrder *o, MPMComponent *to)
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
MPM_INLINE void MPMScatter(int nc, const MPMComponent *from, const MPMBlockOrder *o, PetscInt first, PetscInt last,
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

#endif
