/* bare.h - what the parts of the bare kernels share: particles and nodes, blocks of particles and their weights. bare.c
   says what they are for. */
#ifndef BARE_H
#define BARE_H

#include "base/rows.h"
#include "base/tensor.h"
#include "physics/basis.h"

#if MPM_WIDTH > 2
#include <immintrin.h>
#endif
#include <stdio.h>
#include <stdlib.h>

#if MPM_WIDTH < 2
#error "bare.c is compiled for 2 lanes or more"
#endif

#define W     MPM_WIDTH
#define PARTS (8 / W)      /* vectors of a node's sums */
#define ROOM  (80 + 2 * W) /* particles that a block has room for */
/* In 2-D, the sums of a node that have the derivative along an axis, a bit for each (see Body). */
#define ALONG_X   0x60
#define ALONG_Y   0x18
#define FAIL(...) (fprintf(stderr, "bare: " __VA_ARGS__), fputc('\n', stderr), exit(1))

/* The sums of a node are 8 numbers. In 3-D these are m, p [3], f [3]. In 2-D they are m, p [2] and the parts of the
   force: tau_xy phi_y, tau_yy phi_y, tau_xx phi_x, tau_xy phi_x. So each number is a product of one number of a
   particle's record with one function of x and one of y. The motion of a node is v [dim], a [dim]. */
typedef struct {
  long    n, ncells;
  double *x[3], *v[3], *F[9], *spare;  /* fields of the particles; x in cells; spare: room for one more */
  long   *base;                        /* of each cell that has particles, the first node of its stencil */
  int    *end, *cell, *place, *count;  /* of each such cell the end of its particles; the others are for sorting */
  int     nodes[3], first[3], last[3]; /* nodes on each axis; a box of nodes around those that particles touch */
  double *sums, *motion;               /* of the nodes */
  double  h, l, m, V0, mu, lambda, dt; /* l: half-width of a particle's domain, cells */
  double  seconds, least[3];           /* of all steps; the least of P2G, nodes, G2P */
} Body;

/* A block of whole cells, in arrays of one number for each of its particles. Place 0 is particle `from`, a multiple of
   W, so vectors of the block are vectors of the fields. */
typedef struct {
  double w[3][4][ROOM], g[3][4][ROOM]; /* weights and gradients, the latter per cell */
  double record[ROOM][16];             /* of P2G: what is multiplied by weights and gradients */
  double value[6][ROOM], L[9][ROOM];   /* of G2P: sum phi v, sum phi a, h times the velocity gradient */
  long   from, first, last;            /* particles of the block: first .. last-1 */
  long   cell, next;                   /* cells: cell .. next-1 */
} Block __attribute__((aligned(64)));

/* Advances to the next block, of at most `most` particles if its first cell has no more. Returns whether there was one. */
static int NextBlock(const Body *b, int most, Block *k)
{
  k->cell = k->next;
  if (k->cell == b->ncells) return 0;
  k->first = k->cell ? b->end[k->cell - 1] : 0;
  k->from  = k->first - k->first % W;
  do k->last = b->end[k->next++];
  while (k->next < b->ncells && b->end[k->next] - k->first <= most);
  if (k->last - k->from > ROOM - W) FAIL("a cell has %ld particles", k->last - k->first);
  return 1;
}

/* Computes weights and gradients of the particles of a block. */
MPM_INLINE void Weights(int dim, MPMBasis basis, const Body *body, Block *k)
{
  const Body b = *body; /* a copy, which no write changes, so its members stay in registers */

  for (int d = 0; d < dim; d++) {
    const MPMBases bases = MPMBasisBasesOf(basis, b.nodes[d], PETSC_FALSE, MPM_WALL_BASIS_NONE);

    for (long p = k->from, q = 0; p < k->last; p += W, q += W) {
      MPMReal       xi   = MPMRead(b.x[d] + p), w[4], g[4];
      const MPMReal base = MPMBasisBases(basis, &bases, MPMAll(b.l), &xi);

      MPMBasisInside(basis, xi, MPMAll(b.l), base, w, g);
      for (int i = 0; i < MPMBasisNodes(basis); i++) {
        MPMWrite(k->w[d][i] + q, w[i]);
        MPMWrite(k->g[d][i] + q, g[i]);
      }
    }
  }
}

#endif
