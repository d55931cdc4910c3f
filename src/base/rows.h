/* rows.h - conversions between rows and lanes: in memory, a field has a row of nc components for each particle, while
   the transfers compute with vectors of one component of several particles (lanes.h). The functions only move lanes
   between vectors, by __builtin_shufflevector of gcc (12 or newer) and clang; no number is computed. */
#ifndef MPM_ROWS_H
#define MPM_ROWS_H

#include "base/lanes.h"

/* A vector made of lanes of a and b: its lane i is number f(i, s) of the 2 MPM_WIDTH lanes of a followed by b. */
#if MPM_WIDTH == 8
#define MPM_SHUFFLE(a, b, f, s)                                                                                        \
  __builtin_shufflevector(a, b, f(0, s), f(1, s), f(2, s), f(3, s), f(4, s), f(5, s), f(6, s), f(7, s))
#elif MPM_WIDTH == 4
#define MPM_SHUFFLE(a, b, f, s) __builtin_shufflevector(a, b, f(0, s), f(1, s), f(2, s), f(3, s))
#else
#define MPM_SHUFFLE(a, b, f, s) __builtin_shufflevector(a, b, f(0, s), f(1, s))
#endif

/* --- Rows at any address ------------------------------------------------------------------------------------------ */

/* Conversion between rows of nc numbers, one row a lane, and the vectors of their components. It takes `group`
   components at a time: two, or as many as there are lanes (four of eight lanes were slower). Vector j of a group is
   first filled with the components from rows j, j + group, j + 2 group, ...; vectors that are 1, 2, ... apart then
   exchange sets of 1, 2, ... lanes, which turns them into vectors of one component each. The same exchanges turn them
   back. */
#if MPM_WIDTH > 1
typedef PetscReal MPMPairAt __attribute__((vector_size(16), aligned(8)));

#define MPM_LOWER(i, s) ((i) & (s) ? MPM_WIDTH + (i) - (s) : (i)) /* lanes of two vectors */
#define MPM_UPPER(i, s) ((i) & (s) ? MPM_WIDTH + (i) : (i) + (s))

/* s is a number in the text, since the arguments of a shuffle have to be constant expressions. */
#define MPM_SWAP_LANES(group, v, s)                                                                                    \
  for (int j = 0; j < (group) && (s) < (group); j++)                                                                   \
    if (!(j & (s))) {                                                                                                  \
      const MPMReal a = v[j], b = v[j + (s)];                                                                          \
                                                                                                                       \
      v[j]       = MPM_SHUFFLE(a, b, MPM_LOWER, s);                                                                    \
      v[j + (s)] = MPM_SHUFFLE(a, b, MPM_UPPER, s);                                                                    \
    }

/* Exchanges lanes between the vectors v [group], for each power of two below `group`. */
MPM_INLINE void MPMSwapLanes(int group, MPMReal *v)
{
  MPM_SWAP_LANES(group, v, 1)
#if MPM_WIDTH > 2
  MPM_SWAP_LANES(group, v, 2)
#endif
#if MPM_WIDTH > 4
  MPM_SWAP_LANES(group, v, 4)
#endif
}

/* Reads `group` components from component c on, of the rows row[0], row[group], row[2 group], ..., into one vector.
   Pairs are read as 128-bit integers, since gcc then loads them straight into their lanes. */
MPM_INLINE MPMReal MPMReadPieces(int group, const PetscReal *const row[], int c)
{
  (void)group;
#if MPM_WIDTH > 2
  typedef __int128 MPMPairs __attribute__((vector_size(8 * MPM_WIDTH)));
#define MPM_PAIR(k) ((__int128)*(const MPMPairAt *)(row[k] + c))
#if MPM_WIDTH == 8
  if (group == 2) return (MPMReal)(MPMPairs){MPM_PAIR(0), MPM_PAIR(2), MPM_PAIR(4), MPM_PAIR(6)};
#else
  if (group == 2) return (MPMReal)(MPMPairs){MPM_PAIR(0), MPM_PAIR(2)};
#endif
#endif
  return MPMRead(row[0] + c);
}

/* Writes a vector to the rows from which MPMReadPieces would read it. A pair is written by an intrinsic, of which gcc
   makes one instruction; of a shuffle it makes two. */
MPM_INLINE void MPMWritePieces(int group, MPMReal a, PetscReal *const row[], int c)
{
  (void)group;
#if MPM_WIDTH > 2
#if MPM_WIDTH == 8
#define MPM_PAIR_WRITE(k) *(MPMPairAt *)(row[k] + c) = _mm512_extractf64x2_pd(a, (k) / 2)
#else
#define MPM_PAIR_WRITE(k) *(MPMPairAt *)(row[k] + c) = _mm256_extractf128_pd(a, (k) / 2)
#endif
  if (group == 2) {
    MPM_PAIR_WRITE(0);
    MPM_PAIR_WRITE(2);
#if MPM_WIDTH == 8
    MPM_PAIR_WRITE(4);
    MPM_PAIR_WRITE(6);
#endif
  } else
#endif
    MPMWrite(row[0] + c, a);
}

/* MPMReadGroup and MPMWriteGroup convert the components c .. c + group - 1 of MPM_WIDTH rows; MPMLanes reads component
   c alone. */
MPM_INLINE void MPMReadGroup(int group, const PetscReal *const row[], int c, MPMReal *to)
{
  for (int j = 0; j < group; j++) to[c + j] = MPMReadPieces(group, row + j, c);
  MPMSwapLanes(group, to + c);
}

MPM_INLINE void MPMWriteGroup(int group, const MPMReal *from, PetscReal *const row[], int c)
{
  MPMReal v[MPM_WIDTH];

  for (int j = 0; j < group; j++) v[j] = from[c + j];
  MPMSwapLanes(group, v);
  for (int j = 0; j < group; j++) MPMWritePieces(group, v[j], row + j, c);
}

MPM_INLINE MPMReal MPMLanes(const PetscReal *const row[], int c)
{
#if MPM_WIDTH == 8
  return (MPMReal){row[0][c], row[1][c], row[2][c], row[3][c], row[4][c], row[5][c], row[6][c], row[7][c]};
#elif MPM_WIDTH == 4
  return (MPMReal){row[0][c], row[1][c], row[2][c], row[3][c]};
#else
  return (MPMReal){row[0][c], row[1][c]};
#endif
}
#endif

/* Converts MPM_WIDTH rows of nc numbers, at any addresses row[], to the nc vectors of their components. */
MPM_INLINE void MPMReadRows(int nc, const PetscReal *const row[], MPMReal *to)
{
  int c = 0;

#if MPM_WIDTH > 1
  for (; c + MPM_WIDTH <= nc; c += MPM_WIDTH) MPMReadGroup(MPM_WIDTH, row, c, to);
  for (; c + 2 <= nc; c += 2) MPMReadGroup(2, row, c, to);
  if (c < nc) to[c] = MPMLanes(row, c);
#else
  for (; c < nc; c++) to[c] = row[0][c];
#endif
}

/* Converts nc vectors back to MPM_WIDTH rows of nc numbers. */
MPM_INLINE void MPMWriteRows(int nc, const MPMReal *from, PetscReal *const row[])
{
  int c = 0;

#if MPM_WIDTH > 1
  for (; c + MPM_WIDTH <= nc; c += MPM_WIDTH) MPMWriteGroup(MPM_WIDTH, from, row, c);
  for (; c + 2 <= nc; c += 2) MPMWriteGroup(2, from, row, c);
  for (int k = 0; k < MPM_WIDTH && c < nc; k++) row[k][c] = from[c][k];
#else
  for (; c < nc; c++) row[0][c] = from[c];
#endif
}

/* --- Rows that follow each other in memory ------------------------------------------------------------------------ */

#if MPM_WIDTH == 8
/* Takes n = 1, 2 or 3 vectors as one sequence of n MPM_WIDTH numbers, and collects every n-th number in the same
   vector: to[k] has numbers k, k + n, k + 2 n, ... */
MPM_INLINE void MPMDeinterleave(int n, const MPMReal *from, MPMReal *to)
{
#define MPM_SECOND(i, k) (2 * (i) + (k))
#define MPM_THIRD(i, k)                                                                                                \
  (3 * (i) + (k) < 2 * MPM_WIDTH ? 3 * (i) + (k) : 0) /* lanes of from[0], from[1]; MPM_LATER adds those of from[2] */
#define MPM_LATER(i, k)       (3 * (i) + (k) < 2 * MPM_WIDTH ? (i) : 3 * (i) + (k)-MPM_WIDTH)
#define MPM_DEINTERLEAVE_3(k) MPM_SHUFFLE(MPM_SHUFFLE(from[0], from[1], MPM_THIRD, k), from[2], MPM_LATER, k)
  if (n == 1) to[0] = from[0];
  if (n == 2)
    to[0] = MPM_SHUFFLE(from[0], from[1], MPM_SECOND, 0), to[1] = MPM_SHUFFLE(from[0], from[1], MPM_SECOND, 1);
  if (n == 3) to[0] = MPM_DEINTERLEAVE_3(0), to[1] = MPM_DEINTERLEAVE_3(1), to[2] = MPM_DEINTERLEAVE_3(2);
}

/* Undoes MPMDeinterleave: takes the numbers of n vectors in turn. */
MPM_INLINE void MPMInterleave(int n, const MPMReal *from, MPMReal *to)
{
#define MPM_PLACE(i, k)     ((k)*MPM_WIDTH + (i)) /* of lane i of to[k] in the sequence */
#define MPM_OF_TWO(i, k)    (MPM_PLACE(i, k) % 2 * MPM_WIDTH + MPM_PLACE(i, k) / 2)
#define MPM_OF_THREE(i, k)  (MPM_PLACE(i, k) % 3 % 2 * MPM_WIDTH + MPM_PLACE(i, k) / 3) /* those of from[0], from[1] */
#define MPM_WITH_LAST(i, k) (MPM_PLACE(i, k) % 3 == 2 ? MPM_WIDTH + MPM_PLACE(i, k) / 3 : (i))
#define MPM_INTERLEAVE_3(k) MPM_SHUFFLE(MPM_SHUFFLE(from[0], from[1], MPM_OF_THREE, k), from[2], MPM_WITH_LAST, k)
  if (n == 1) to[0] = from[0];
  if (n == 2)
    to[0] = MPM_SHUFFLE(from[0], from[1], MPM_OF_TWO, 0), to[1] = MPM_SHUFFLE(from[0], from[1], MPM_OF_TWO, 1);
  if (n == 3) to[0] = MPM_INTERLEAVE_3(0), to[1] = MPM_INTERLEAVE_3(1), to[2] = MPM_INTERLEAVE_3(2);
}
#endif

/* Converts MPM_WIDTH rows of nc = 1, 2, 3, 4, 6 or 9 numbers, which follow each other, to nc vectors, one for each
   component. Instructions that take any lanes of two vectors are for 8 lanes alone, and pay there. */
MPM_INLINE void MPMTranspose(int nc, const PetscReal *rows, MPMReal *to)
{
#if MPM_WIDTH == 8
  const int r = nc % 3 == 0 ? 3 : nc % 2 == 0 ? 2 : 1, m = nc / r; /* separated by r, and each part by m */
  MPMReal   in[3], dealt[3], part[3][3];

  for (int g = 0; g < m; g++) {
    for (int k = 0; k < r; k++) in[k] = MPMRead(rows + (g * r + k) * MPM_WIDTH);
    MPMDeinterleave(r, in, dealt);
    for (int k = 0; k < r; k++) part[k][g] = dealt[k];
  }
  for (int k = 0; k < r; k++) {
    MPMDeinterleave(m, part[k], dealt);
    for (int g = 0; g < m; g++) to[g * r + k] = dealt[g];
  }
#else
  const PetscReal *row[MPM_WIDTH];

  for (int k = 0; k < MPM_WIDTH; k++) row[k] = rows + k * nc;
  MPMReadRows(nc, row, to);
#endif
}

/* Converts nc vectors, one for each component, to MPM_WIDTH rows that follow each other: undoes MPMTranspose. */
MPM_INLINE void MPMTransposeBack(int nc, const MPMReal *from, PetscReal *rows)
{
#if MPM_WIDTH == 8
  const int r = nc % 3 == 0 ? 3 : nc % 2 == 0 ? 2 : 1, m = nc / r;
  MPMReal   in[3], dealt[3], part[3][3];

  for (int k = 0; k < r; k++) {
    for (int g = 0; g < m; g++) in[g] = from[g * r + k];
    MPMInterleave(m, in, part[k]);
  }
  for (int g = 0; g < m; g++) {
    for (int k = 0; k < r; k++) in[k] = part[k][g];
    MPMInterleave(r, in, dealt);
    for (int k = 0; k < r; k++) MPMWrite(rows + (g * r + k) * MPM_WIDTH, dealt[k]);
  }
#else
  PetscReal *row[MPM_WIDTH];

  for (int k = 0; k < MPM_WIDTH; k++) row[k] = rows + k * nc;
  MPMWriteRows(nc, from, row);
#endif
}

#endif
