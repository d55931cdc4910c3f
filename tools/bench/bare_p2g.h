/* bare_p2g.h - the bare kernel from particles to nodes: mass, momentum and internal force. */
#ifndef BARE_P2G_H
#define BARE_P2G_H

#include "bare.h"

/* Computes what the particles of a block give to their nodes, -V0 tau/h and m v, and writes it to their records. */
MPM_INLINE void Records(int dim, const Body *body, Block *k)
{
  const Body    b = *body;
  const MPMReal m = MPMAll(b.m), none = MPMAll(0);

  for (long p = k->from, q = 0; p < k->last; p += W, q += W) {
    MPMReal F[9], C[6], t[6], v[3] = {none, none, none}, lnJ;
    double *row[W];

    for (int c = 0; c < dim * dim; c++) F[c] = MPMRead(b.F[c] + p);
    for (int d = 0; d < dim; d++) v[d] = m * MPMRead(b.v[d] + p);
    lnJ = MPMLog(MPMDet(dim, F));
    MPMLeftCauchyGreen(dim, F, C);
    for (int c = 0; c < 6; c++) {
      const int diagonal = c == 0 || c == 3 || c == 5;

      t[c] = -b.V0 / b.h * (diagonal ? b.lambda * lnJ + b.mu * (C[c] - 1.0) : b.mu * C[c]);
    }
    for (int r = 0; r < W; r++) row[r] = k->record[q + r];
    if (dim == 2) {
      const MPMReal all[8] = {m, v[0], v[1], t[1], t[3], t[0], t[1], none};

      MPMWriteRows(8, all, row);
    } else {
      const MPMReal all[16] = {m,    v[0], v[1], v[2], t[0], t[1], t[2], none,  /* times w w w; g w w; */
                               t[1], t[3], t[4], none, t[2], t[4], t[5], none}; /* w g w; w w g */

      MPMWriteRows(16, all, row);
    }
  }
}

/* Returns a vector of w, but of g in the lanes of part h of a node's sums that `lanes` has, a bit for each sum. (As
   shuffles gcc makes more instructions of these.) */
MPM_INLINE MPMReal Along(unsigned lanes, int h, double w, double g)
{
  const unsigned bits = lanes >> h * W & ((1u << W) - 1);

#if W == 8
  return _mm512_mask_blend_pd((__mmask8)bits, MPMAll(w), MPMAll(g));
#elif W == 4
  if (bits == 8) return _mm256_blend_pd(MPMAll(w), MPMAll(g), 8);
  if (bits == 6) return _mm256_blend_pd(MPMAll(w), MPMAll(g), 6);
  if (bits == 1) return _mm256_blend_pd(MPMAll(w), MPMAll(g), 1);
  return MPMAll(w);
#else
  return bits == 2 ? (MPMReal){w, g} : bits == 1 ? (MPMReal){g, w} : MPMAll(w);
#endif
}

/* Adds the sums of a cell for n of its nodes to part h of these. */
MPM_INLINE void Flush(int ns, int h, int n, const MPMReal *sum, long width, long plane, double *node)
{
  for (int a = 0; a < n; a++) {
    double *to = node + 8 * (a / (ns * ns) * plane + a / ns % ns * width + a % ns) + h * W;

    MPMWrite(to, MPMRead(to) + sum[a]);
  }
}

/* Adds part h of the records of a cell's particles, places first .. last-1 of the block, to the nodes of `rows` rows
   from row y on. */
MPM_INLINE void SumCell2(int ns, int h, int y, int rows, const Block *k, long first, long last, long width,
                         double *node)
{
  MPMReal sum[16];

  for (int a = 0; a < rows * ns; a++) sum[a] = MPMAll(0);
  for (long q = first; q < last; q++) {
    const MPMReal all = MPMRead(k->record[q] + h * W);
    MPMReal       x[4];

    for (int i = 0; i < ns; i++) x[i] = Along(ALONG_X, h, k->w[0][i][q], k->g[0][i][q]);
    for (int j = 0; j < rows; j++) {
      const MPMReal row = all * Along(ALONG_Y, h, k->w[1][y + j][q], k->g[1][y + j][q]);

      for (int i = 0; i < ns; i++) sum[j * ns + i] += x[i] * row;
    }
  }
  Flush(ns, h, rows * ns, sum, width, 0, node + 8 * y * width);
}

/* Returns part h of 8 numbers: those at `at` in the upper or lower half, and 0 in the other. */
MPM_INLINE MPMReal Half(int upper, int h, const double *at)
{
#if W == 8
  (void)h;
  return _mm512_maskz_broadcast_f64x4(upper ? 0xf0 : 0x0f, _mm256_loadu_pd(at));
#else
  (void)upper;
  return MPMRead(at + h * W % 4);
#endif
}

/* The same in 3-D, for the nodes of `planes` planes from plane z on; ns is 2 or 3. */
MPM_INLINE void SumCell3(int ns, int h, int z, int planes, const Block *k, long first, long last, long width,
                         long plane, double *node)
{
  const int force = (h + 1) * W > 4, motion = h * W < 4;
  MPMReal   sum[16];

  for (int a = 0; a < planes * ns * ns; a++) sum[a] = MPMAll(0);
  for (long q = first; q < last; q++) {
    const double *all = k->record[q];

    for (int a = 0; a < planes; a++) {
      const MPMReal wz = MPMAll(k->w[2][z + a][q]), gz = MPMAll(k->g[2][z + a][q]), none = MPMAll(0);
      const MPMReal x = force ? wz * Half(1, h, all + 4) : none, y = force ? wz * Half(1, h, all + 8) : none;
      MPMReal       rest = motion ? wz * Half(0, h, all) : none, row[3], rowx[3];

      if (force) rest += gz * Half(1, h, all + 12);
      for (int j = 0; j < ns; j++) {
        const MPMReal wy = MPMAll(k->w[1][j][q]), gy = MPMAll(k->g[1][j][q]);

        row[j]  = force ? wy * rest + gy * y : wy * rest;
        rowx[j] = wy * x;
      }
      for (int i = 0; i < ns; i++) {
        const MPMReal wx = MPMAll(k->w[0][i][q]), gx = MPMAll(k->g[0][i][q]);

        for (int j = 0; j < ns; j++) {
          MPMReal *to = sum + (a * ns + j) * ns + i;

          *to += wx * row[j];
          if (force) *to += gx * rowx[j];
        }
      }
    }
  }
  Flush(ns, h, planes * ns * ns, sum, width, plane, node + 8 * z * plane);
}

/* Adds part h of the records of a cell's particles to all its nodes, the first of which is `node`. */
MPM_INLINE void SumCell(int dim, int ns, int h, const Block *k, long first, long last, long width, long plane,
                        double *node)
{
  const int planes = ns == 2 ? 2 : 1, rows = ns == 4 && W < 8 ? 2 : ns; /* as many as registers have room for */

  if (dim == 2)
    for (int y = 0; y < ns; y += rows) SumCell2(ns, h, y, rows, k, first, last, width, node);
  else
    for (int z = 0; z < ns; z += planes) SumCell3(ns, h, z, planes, k, first, last, width, plane, node);
}

/* Adds mass, momentum and internal force of all particles to the sums of the nodes, which were 0. */
MPM_INLINE void P2G(int dim, MPMBasis basis, Body *b, Block *k)
{
  const int  ns    = MPMBasisNodes(basis);
  const long width = b->nodes[0], plane = width * b->nodes[1];

  k->next = 0;
  while (NextBlock(b, dim == 2 ? 64 : 32, k)) {
    Weights(dim, basis, b, k);
    Records(dim, b, k);
    for (long c = k->cell, first = k->first - k->from; c < k->next; c++) {
      const long last = b->end[c] - k->from;
      double    *node = b->sums + 8 * b->base[c];

      /* Not a loop: each part shall have code of its own. */
      SumCell(dim, ns, 0, k, first, last, width, plane, node);
      if (PARTS > 1) SumCell(dim, ns, 1, k, first, last, width, plane, node);
      if (PARTS > 2) SumCell(dim, ns, 2, k, first, last, width, plane, node);
      if (PARTS > 2) SumCell(dim, ns, 3, k, first, last, width, plane, node);
      first = last;
    }
  }
}

#endif
