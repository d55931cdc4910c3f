/* transfer_sums.c - the innermost loops of both transfers: sums over the particles of a cell for its nodes, and over
   the nodes of a cell for its particles, block by block. They need only the nodes per axis of a basis. The file is
   compiled once for each number of lanes. */
#include "kernels/p2g.h"

/* --- Particles to nodes ------------------------------------------------------------------------------------------- */
/* Lanes are the sums of a node, which are MPM_PARTS vectors. The macros tell whether vector h has numbers lo .. hi-1 of
   the record; mass or momentum; forces. */
#define MPM_PARTS               (8 / MPM_WIDTH)
#define MPM_PART_HAS(h, lo, hi) ((h)*MPM_WIDTH < (hi) && ((h) + 1) * MPM_WIDTH > (lo))
#define MPM_PART_MOTION(h)      MPM_PART_HAS(h, 0, MPM_NODE_force)
#define MPM_PART_FORCE(dim, h)  MPM_PART_HAS(h, MPM_NODE_force, MPM_NODE_force + (dim))

/* Returns i c for i = 0 .. 3. */
MPM_INLINE MPMReal MPMMultiple(int i, MPMReal c)
{
  return i == 0 ? MPMAll(0) : i == 1 ? c : i == 2 ? c + c : c + c + c;
}

/* As many nodes of a stencil at a time as have their sums in registers: those of MPM_ROWS rows in each of MPM_PLANES
   planes. */
#define MPM_ROWS(dim, ns)   ((dim) == 1 ? 1 : (ns) == 4 && MPM_WIDTH < 8 ? 2 : (ns))
#define MPM_PLANES(dim, ns) ((dim) == 3 && (ns) == 2 ? 2 : 1)

/* Returns vector h of a record in which the numbers `some` (bits) are g and the others w. */
MPM_INLINE MPMReal MPMEither(unsigned some, int h, PetscReal w, PetscReal g)
{
  const unsigned lanes = some >> h * MPM_WIDTH & ((1u << MPM_WIDTH) - 1);

  return !lanes ? MPMAll(w) : lanes == (1u << MPM_WIDTH) - 1 ? MPMAll(g) : MPMBlend(lanes, MPMAll(w), MPMAll(g));
}

/* In 2-D, the numbers of a record that have the derivative along x, and those along y (bits, see p2g.h). */
#define MPM_ALONG_X 0xc0
#define MPM_ALONG_Y 0x30

/* Adds particles first .. last-1 of a block to vector h of the sums of nodes of their cell, in rows j0 .. of planes
   k0 .. of the stencil: phi = wx wy wz and its gradients are multiplied out axis by axis, the last axis while adding.
   force, load, motion: there are records of stress, of loads, of affine velocities. */
MPM_INLINE void MPMAccumulate(int dim, int ns, int force, int load, int motion, int h, int k0, int j0,
                              const MPMStencils *s, const MPMRecords *r, PetscInt first, PetscInt last, MPMReal *sum)
{
  const int      rows = MPM_ROWS(dim, ns), planes = MPM_PLANES(dim, ns), whole = dim == 2;
  const unsigned along_x = whole && force ? MPM_ALONG_X : 0, along_y = whole && force ? MPM_ALONG_Y : 0;

  for (PetscInt l = first; l < last; l++) {
    MPMReal Q[4] = {MPMAll(0)}, A[3] = {MPMAll(0)};

    for (int e = 0; e < 1 + (whole ? load : force ? dim : 0); e++) Q[e] = MPMRead(r->Q[l][e] + h * MPM_WIDTH);
    for (int e = 0; e < (motion ? dim : 0); e++) A[e] = MPMRead(r->A[l][e] + h * MPM_WIDTH);
    MPM_UNROLL
    for (int k = 0; k < planes; k++) {
      MPMReal P = Q[0], Px = Q[1], Py = Q[2], a = A[0], b = A[1]; /* of a plane of nodes */

      if (dim > 2) {
        const MPMReal wz = MPMAll(s->w[2][k0 + k][l]), gz = MPMAll(s->g[2][k0 + k][l]);

        if (motion) P += MPMMultiple(k0 + k, A[2]);
        P = wz * P;
        if (motion) a = wz * a, b = wz * b;
        if (force) P = MPMFma(gz, Q[3], P), Px = wz * Px, Py = wz * Py;
      }
      MPM_UNROLL
      for (int j = 0; j < rows; j++) {
        MPMReal R = P, Rx = Px, c = a; /* of a row of nodes */

        if (dim > 1) {
          const MPMReal wy = MPMAll(s->w[1][j0 + j][l]), gy = MPMAll(s->g[1][j0 + j][l]);

          if (motion) R += MPMMultiple(j0 + j, b);
          R = MPMEither(along_y, h, s->w[1][j0 + j][l], s->g[1][j0 + j][l]) * R;
          if (motion) c = wy * c;
          if (force) Rx = wy * Rx;
          if (force && !whole) R = MPMFma(gy, Py, R);
        }
        MPM_UNROLL
        for (int i = 0; i < ns; i++) {
          const MPMReal wx = MPMEither(along_x, h, s->w[0][i][l], s->g[0][i][l]);
          MPMReal      *to = &sum[(k * rows + j) * ns + i];

          *to = MPMFma(wx, motion ? R + MPMMultiple(i, c) : R, *to);
          if (whole && load) *to = MPMFma(MPMAll(s->w[0][i][l]), Rx, *to);
          if (force && !whole) *to = MPMFma(MPMAll(s->g[0][i][l]), Rx, *to);
        }
      }
    }
  }
}

/* Adds the two parts of the forces of a node's sums in 2-D, numbers 6 and 7 to 4 and 5; `lower` are these where they
   are another vector. */
MPM_INLINE MPMReal MPMFold(MPMReal sum, MPMReal lower)
{
#if MPM_WIDTH == 8
  (void)lower;
  return MPMBlend(0xc0, sum + __builtin_shufflevector(sum, MPMAll(0), 8, 8, 8, 8, 6, 7, 8, 8), MPMAll(0));
#elif MPM_WIDTH == 4
  (void)lower;
  return _mm256_zextpd128_pd256(_mm256_castpd256_pd128(sum) + _mm256_extractf128_pd(sum, 1));
#else
  return lower + sum;
#endif
}

/* Adds particles first .. last-1 of a block to the sums of their cell, which begin at 0 or, where the cell began in an
   earlier block, at `from`. They are added to those of the nodes in the tile, at `place`, or written to `to` if the
   cell may go on in the next block. all: all numbers are summed, by phi, as those of mass and momentum. */
MPM_INLINE void MPMSumCell(int dim, int ns, int forces, int affine, int all, const MPMStencils *s, const MPMRecords *r,
                           PetscInt first, PetscInt last, const MPMRecord *from, PetscReal *place, MPMRecord *to)
{
  const int ny = dim > 1 ? ns : 1, nz = dim > 2 ? ns : 1, rows = MPM_ROWS(dim, ns), planes = MPM_PLANES(dim, ns);
  const int n = planes * rows * ns, side = (1 << MPM_TILE_BITS(ns)) + ns - 1;
  MPMReal   lower[16] = {MPMAll(0)}; /* with 2 lanes in 2-D, the first part of the forces */

  /* With 4 and 8 lanes the loop is unrolled, so that each vector's content is known. */
  MPM_UNROLL
  for (int h = 0; h < MPM_PARTS; h++) {
    const int upper = dim == 2 && forces && h * MPM_WIDTH >= MPM_NODE_force; /* only forces */
    const int force = forces && (upper || MPM_PART_FORCE(dim, h)), motion = affine && MPM_PART_MOTION(h);
    const int two = dim == 2 && force, held = two && MPM_WIDTH == 2 && h == 2;

    if (!force && !MPM_PART_MOTION(h) && !all) continue;
    for (int k0 = 0; k0 < nz; k0 += planes)
      for (int j0 = 0; j0 < ny; j0 += rows) {
        const int at0 = (k0 * ny + j0) * ns; /* the first of these nodes */
        MPMReal   sum[16];

        if (from)
          for (int a = 0; a < n; a++) sum[a] = MPMRead(from[at0 + a] + h * MPM_WIDTH);
        else
          for (int a = 0; a < n; a++) sum[a] = MPMAll(0);
        MPMAccumulate(dim, ns, force, forces > 1, motion, h, k0, j0, s, r, first, last, sum);
        if (to)
          for (int a = 0; a < n; a++) MPMWrite(to[at0 + a] + h * MPM_WIDTH, sum[a]);
        else
          for (int a = 0; a < n; a++) {
            const int  k = k0 + a / (rows * ns), j = j0 + a / ns % rows;
            PetscReal *node = place + MPM_NODE_NC * (a % ns + side * (j + side * k)) +
                              (two && MPM_WIDTH == 2 ? MPM_NODE_force : h * MPM_WIDTH);

            if (held)
              lower[at0 + a] = sum[a];
            else
              MPMWrite(node, MPMRead(node) + (two ? MPMFold(sum[a], lower[at0 + a]) : sum[a]));
          }
      }
  }
}

/* Adds a block of particles to the sums of their tiles; p2g.h declares from and to. */
MPM_INLINE void MPMSumBlock(int dim, int ns, int forces, int affine, int all, const MPMBlockOrder *o,
                            const MPMStencils *s, const MPMRecords *r, PetscReal *const place[], const MPMRecord *from,
                            MPMRecord *to)
{
  for (PetscInt c = 0, first = 0; c < o->ncells; first = o->end[c++], from = NULL)
    MPMSumCell(dim, ns, forces, affine, all, s, r, first, o->end[c], from, place[c], c < o->ncells - 1 ? NULL : to);
}

/* --- Nodes to particles ------------------------------------------------------------------------------------------- */
/* Sums over the nodes of a cell for MPM_WIDTH of its particles, the lanes, from l on: nv values with phi, and the
   gradients of the first dim of them with grad phi. They are made one after the other, so that each has its sums in
   registers. node: the motion of the cell's base node; row, plane: from a row of nodes, or a plane, to the next one. */
MPM_INLINE void MPMInterpolate(int dim, int ns, int nv, int gradients, const PetscReal *node, size_t row, size_t plane,
                               const MPMStencils *s, PetscInt l, MPMComponent *value, MPMComponent *gradient)
{
  const int ny = dim > 1 ? ns : 1, nz = dim > 2 ? ns : 1, n = gradients && nv < dim ? dim : nv;
  MPMReal   wx[4], gx[4];

  for (int i = 0; i < ns; i++) wx[i] = MPMRead(&s->w[0][i][l]), gx[i] = MPMRead(&s->g[0][i][l]);
  MPM_UNROLL
  for (int f = 0; f < n; f++) {
    const int grad = gradients && f < dim;
    MPMReal   V = MPMAll(0), G[3] = {MPMAll(0), MPMAll(0), MPMAll(0)};

    for (int k = 0; k < nz; k++) {
      MPMReal P = MPMAll(0), Px = MPMAll(0), Py = MPMAll(0); /* of a plane of nodes: with phi, d phi/dx, d phi/dy */

      MPM_UNROLL
      for (int j = 0; j < ny; j++) {
        const PetscReal *u = node + (size_t)k * plane + (size_t)j * row + f;
        MPMReal          R = MPMAll(0), Rx = MPMAll(0); /* of a row of nodes */

        MPM_UNROLL
        for (int i = 0; i < ns; i++) {
          const MPMReal now = MPMAll(u[i * MPM_MOTION_NC(dim)]);

          R = MPMFma(wx[i], now, R);
          if (grad) Rx = MPMFma(gx[i], now, Rx);
        }
        if (dim > 1) {
          const MPMReal wy = MPMRead(&s->w[1][j][l]), gy = MPMRead(&s->g[1][j][l]);

          P = MPMFma(wy, R, P);
          if (grad) Px = MPMFma(wy, Rx, Px), Py = MPMFma(gy, R, Py);
        } else
          P = R, Px = Rx;
      }
      if (dim > 2) {
        const MPMReal wz = MPMRead(&s->w[2][k][l]), gz = MPMRead(&s->g[2][k][l]);

        V = MPMFma(wz, P, V);
        if (grad) G[0] = MPMFma(wz, Px, G[0]), G[1] = MPMFma(wz, Py, G[1]), G[2] = MPMFma(gz, P, G[2]);
      } else
        V = P, G[0] = Px, G[1] = Py;
    }
    if (f < nv) MPMWrite(&value[f][l], V);
    for (int e = 0; e < dim && grad; e++) MPMWrite(&gradient[f * dim + e][l], G[e]);
  }
}

/* Does the same for all lanes of a block. Those past the end of a cell get numbers that the next cell overwrites. */
MPM_INLINE void MPMInterpolateBlock(int dim, int ns, int nv, int gradients, const MPMBlockOrder *o,
                                    const MPMStencils *s, const PetscInt n[], const PetscReal *nodes,
                                    MPMComponent *value, MPMComponent *gradient)
{
  size_t row = (size_t)n[0] * MPM_MOTION_NC(dim), plane = (size_t)n[1] * row;

  for (PetscInt c = 0, first = 0; c < o->ncells; first = o->end[c++]) {
    const PetscReal *node = nodes + (size_t)(PetscInt)s->base[first] * MPM_MOTION_NC(dim);
    const PetscInt   last = c < o->ncells - 1 ? o->end[c] : o->lanes;

    for (PetscInt l = first; l < last; l += MPM_WIDTH) {
      __asm__("" : "+r"(node), "+r"(row), "+r"(plane)); /* else gcc keeps the address of each number, in memory */
      MPMInterpolate(dim, ns, nv, gradients, node, row, plane, s, l, value, gradient);
    }
  }
}

/* --- Instances ---------------------------------------------------------------------------------------------------- */
#define MPM_FOR_ALL(X) X(1, 2) X(1, 3) X(1, 4) X(2, 2) X(2, 3) X(2, 4) X(3, 2) X(3, 3) X(3, 4)
#define MPM_SUM_BLOCK(dim, ns, forces, affine)                                                                         \
  static void SumBlock_##dim##ns##_##forces##affine(const MPMBlockOrder *o, const MPMStencils *s, const MPMRecords *r, \
                                                    PetscReal *const place[], const MPMRecord *from, MPMRecord *to)    \
  {                                                                                                                    \
    MPMSumBlock(dim, ns, forces, affine, 0, o, s, r, place, from, to);                                                 \
  }
#define MPM_SUM_LINE(dim, ns)                                                                                          \
  static void SumLine_##dim##ns(const MPMBlockOrder *o, const MPMStencils *s, const MPMRecords *r,                     \
                                PetscReal *const place[], const MPMRecord *from, MPMRecord *to)                        \
  {                                                                                                                    \
    if (MPM_NODE_LINES > 1) MPMSumBlock(dim, ns, 0, 0, 1, o, s, r, place, from, to);                                   \
  }
#define MPM_INTERPOLATE_BLOCK(dim, ns, motion, stress)                                                                 \
  static void InterpolateBlock_##dim##ns##_##motion##stress(const MPMBlockOrder *o, const MPMStencils *s,              \
                                                            const PetscInt n[], const PetscReal *nodes,                \
                                                            MPMComponent *value, MPMComponent *gradient)               \
  {                                                                                                                    \
    const int values = (motion) == 1 ? 2 * dim : (motion) == 2 ? dim : (motion) == 3 ? 1 : 0;                          \
                                                                                                                       \
    MPMInterpolateBlock(dim, ns, values, stress, o, s, n, nodes, value, gradient);                                     \
  }
#define MPM_DEFINE(dim, ns)                                                                                            \
  MPM_SUM_BLOCK(dim, ns, 0, 0)                                                                                         \
  MPM_SUM_BLOCK(dim, ns, 0, 1)                                                                                         \
  MPM_SUM_BLOCK(dim, ns, 1, 0)                                                                                         \
  MPM_SUM_BLOCK(dim, ns, 1, 1)                                                                                         \
  MPM_SUM_BLOCK(dim, ns, 2, 0)                                                                                         \
  MPM_SUM_BLOCK(dim, ns, 2, 1)                                                                                         \
  MPM_INTERPOLATE_BLOCK(dim, ns, 0, 1)                                                                                 \
  MPM_INTERPOLATE_BLOCK(dim, ns, 1, 0)                                                                                 \
  MPM_INTERPOLATE_BLOCK(dim, ns, 1, 1)                                                                                 \
  MPM_INTERPOLATE_BLOCK(dim, ns, 2, 0)
#define MPM_DEFINE_ROUND(dim, ns) MPM_INTERPOLATE_BLOCK(dim, ns, 3, 1)
MPM_FOR_ALL(MPM_DEFINE)
MPM_DEFINE_ROUND(2, 2)
MPM_DEFINE_ROUND(2, 3)
MPM_DEFINE_ROUND(2, 4)
MPM_FOR_ALL(MPM_SUM_LINE)

#define MPM_SUM_ENTRY(dim, ns)                                                                                         \
  [dim - 1][ns - 2] = {{SumBlock_##dim##ns##_00, SumBlock_##dim##ns##_01},                                             \
                       {SumBlock_##dim##ns##_10, SumBlock_##dim##ns##_11},                                             \
                       {SumBlock_##dim##ns##_20, SumBlock_##dim##ns##_21}},
#define MPM_INTERPOLATE_ENTRY(dim, ns)                                                                                 \
  [dim - 1][ns - 2] = {{NULL, InterpolateBlock_##dim##ns##_01},                                                        \
                       {InterpolateBlock_##dim##ns##_10, InterpolateBlock_##dim##ns##_11},                             \
                       {InterpolateBlock_##dim##ns##_20, NULL}},
#define MPM_LINE_ENTRY(dim, ns) [dim - 1][ns - 2] = SumLine_##dim##ns,
const MPMSumBlocks         MPM_LANES_NAME(MPMSumBlock)[3][3][3][2]         = {MPM_FOR_ALL(MPM_SUM_ENTRY)};
const MPMSumBlocks         MPM_LANES_NAME(MPMSumLine)[3][3]                = {MPM_FOR_ALL(MPM_LINE_ENTRY)};
const MPMInterpolateBlocks MPM_LANES_NAME(MPMInterpolateBlock)[3][3][4][2] = {
    MPM_FOR_ALL(MPM_INTERPOLATE_ENTRY)[1][0][3][1] = InterpolateBlock_22_31, [1][1][3][1] = InterpolateBlock_23_31,
    [1][2][3][1] = InterpolateBlock_24_31};
