/* bare_g2p.h - the bare update of nodes, and the kernel from nodes to particles: velocity, position and F. */
#ifndef BARE_G2P_H
#define BARE_G2P_H

#include "bare.h"

/* Computes a = f/m and v = p/m + dt a of all nodes that have mass, and zeroes the sums for the next step. */
MPM_INLINE void Nodes(int dim, Body *b)
{
  for (int z = b->first[2]; z <= b->last[2]; z++)
    for (int y = b->first[1]; y <= b->last[1]; y++) {
      const long row = ((long)z * b->nodes[1] + y) * b->nodes[0];

      for (long i = row + b->first[0]; i <= row + b->last[0]; i++) {
        double      *sum = b->sums + 8 * i, *motion = b->motion + 2 * dim * i;
        const double over = sum[0] > 0 ? 1 / sum[0] : 0;
        const double f[3] = {dim == 2 ? sum[3] + sum[5] : sum[4], dim == 2 ? sum[4] + sum[6] : sum[5], sum[6]};

        for (int d = 0; d < dim; d++) {
          motion[dim + d] = f[d] * over;
          motion[d]       = (sum[1 + d] + b->dt * f[d]) * over;
        }
        for (int s = 0; s < 8; s++) sum[s] = 0;
      }
    }
}

/* Sums over the nodes of a cell for its particles, W at a time: a lane is a particle. The last vector has lanes of the
   next cell, which then writes them anew. One component of the motion is taken at a time, so that its sums stay in
   registers: v and a, of all nodes, of a plane and of a row of them, and the derivatives of v. */
MPM_INLINE void Interpolate(int dim, int ns, const double *node, long width, long plane, Block *k, long first,
                            long last)
{
  const MPMReal none = MPMAll(0);

  for (long q = first; q < last; q += W)
    for (int c = 0; c < dim; c++) {
      MPMReal v = none, a = none, vx = none, vy = none, vz = none;

      for (int z = 0; z < (dim > 2 ? ns : 1); z++) {
        MPMReal pv = none, pa = none, px = none, py = none;

        for (int j = 0; j < ns; j++) {
          const double *at = node + 2 * dim * (z * plane + j * width) + c;
          const MPMReal wy = MPMRead(k->w[1][j] + q), gy = MPMRead(k->g[1][j] + q);
          MPMReal       rv = none, ra = none, rx = none;

          for (int i = 0; i < ns; i++, at += 2 * dim) {
            const MPMReal wx = MPMRead(k->w[0][i] + q), gx = MPMRead(k->g[0][i] + q);

            rv += wx * MPMAll(at[0]);
            rx += gx * MPMAll(at[0]);
            ra += wx * MPMAll(at[dim]);
          }
          pv += wy * rv;
          pa += wy * ra;
          px += wy * rx;
          py += gy * rv;
        }
        if (dim == 2)
          v = pv, a = pa, vx = px, vy = py;
        else {
          const MPMReal wz = MPMRead(k->w[2][z] + q), gz = MPMRead(k->g[2][z] + q);

          v += wz * pv;
          a += wz * pa;
          vx += wz * px;
          vy += wz * py;
          vz += gz * pv;
        }
      }
      MPMWrite(k->value[c] + q, v);
      MPMWrite(k->value[dim + c] + q, a);
      MPMWrite(k->L[c * dim] + q, vx);
      MPMWrite(k->L[c * dim + 1] + q, vy);
      if (dim > 2) MPMWrite(k->L[c * dim + 2] + q, vz);
    }
}

/* Moves the particles from..last-1 of a block, whole vectors. */
MPM_INLINE void Move(int dim, const Body *body, const Block *k, long last)
{
  const Body b = *body;

  for (long p = k->from, q = 0; p < last; p += W, q += W) {
    MPMReal F[9], L[9];

    for (int d = 0; d < dim; d++) {
      MPMWrite(b.v[d] + p, MPMRead(b.v[d] + p) + b.dt * MPMRead(k->value[dim + d] + q));
      MPMWrite(b.x[d] + p, MPMRead(b.x[d] + p) + b.dt / b.h * MPMRead(k->value[d] + q));
    }
    for (int c = 0; c < dim * dim; c++) {
      F[c] = MPMRead(b.F[c] + p);
      L[c] = MPMRead(k->L[c] + q);
    }
    MPMDeform(dim, b.dt / b.h, L, F);
    for (int c = 0; c < dim * dim; c++) MPMWrite(b.F[c] + p, F[c]);
  }
}

/* Brings the motion of the nodes to all particles, which get new velocities, positions and F. */
MPM_INLINE void G2P(int dim, MPMBasis basis, Body *b, Block *k)
{
  const int  ns    = MPMBasisNodes(basis);
  const long width = b->nodes[0], plane = width * b->nodes[1];

  k->next = 0;
  while (NextBlock(b, dim == 2 ? 64 : 32, k)) {
    Weights(dim, basis, b, k);
    for (long c = k->cell, first = k->first - k->from; c < k->next; c++) {
      const long last = b->end[c] - k->from;

      Interpolate(dim, ns, b->motion + 2 * dim * b->base[c], width, plane, k, first, last);
      first = last;
    }
    {
      /* The vector that this block shares with the next one waits until that has its lanes too. */
      const long whole = k->last - (k->last < b->n ? k->last % W : 0), q = whole - k->from;

      Move(dim, b, k, whole);
      for (int c = 0; c < 2 * dim; c++) MPMWrite(k->value[c], MPMRead(k->value[c] + q));
      for (int c = 0; c < dim * dim; c++) MPMWrite(k->L[c], MPMRead(k->L[c] + q));
    }
  }
}

#endif
