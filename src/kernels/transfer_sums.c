/* transfer_sums.c - the innermost loops of both transfers: sums over the particles of a cell for its nodes, and over
   the nodes of a cell for its particles, block by block. They need only the nodes per axis of a basis. The file is
   compiled once for each number of lanes. */
#include "kernels/p2g.h"

#if MPM_WIDTH < 4
#define MPM_UNROLL_NODES
#elif defined(__clang__)
#define MPM_UNROLL_NODES _Pragma("unroll")
#else
#define MPM_UNROLL_NODES _Pragma("GCC unroll 4")
#endif

/* --- Particles to nodes ------------------------------------------------------------------------------------------- */
/* Lanes are the sums of a node, which are MPM_PARTS vectors. The macros tell whether vector h has numbers lo .. hi-1 of
   the record; mass or momentum; forces; any of these. */
#define MPM_PARTS               (8 / MPM_WIDTH)
#define MPM_PART_HAS(h, lo, hi) ((h)*MPM_WIDTH < (hi) && ((h) + 1) * MPM_WIDTH > (lo))
#define MPM_PART_MOTION(dim, h) MPM_PART_HAS(h, 0, 1 + (dim))
#define MPM_PART_FORCE(dim, h)  MPM_PART_HAS(h, MPM_NODE_FORCE, MPM_NODE_FORCE + (dim))
#define MPM_PART_USED(dim, h)   (MPM_PART_MOTION(dim, h) || MPM_PART_FORCE(dim, h))

typedef MPMReal MPMSums[MPM_MAX_NODES][MPM_PARTS];

/* Returns i c for i = 0 .. 3. */
MPM_INLINE MPMReal MPMMultiple(int i, MPMReal c)
{
  return i == 0 ? MPMAll(0) : i == 1 ? c : i == 2 ? c + c : c + c + c;
}

/* Adds particles first .. last-1 of a block to the sums of their cell: phi = wx wy wz and its gradients are multiplied
   out axis by axis, the last axis while adding. forces, affine: there are records of these. */
MPM_INLINE void MPMAccumulate(int dim, int ns, int forces, int affine, const MPMStencils *s, const MPMRecords *r,
                              PetscInt first, PetscInt last, MPMReal (*sum)[MPM_PARTS])
{
  const int ny = dim > 1 ? ns : 1, nz = dim > 2 ? ns : 1;

  for (PetscInt l = first; l < last; l++) {
    /* The loop is unrolled so that each vector's content is known: no product then serves two paths of which only one
       adds to it. */
    MPM_UNROLL_NODES
    for (int h = 0; h < MPM_PARTS; h++) {
      const int force = forces && MPM_PART_FORCE(dim, h), motion = affine && MPM_PART_MOTION(dim, h);
      MPMReal   Q[4] = {MPMAll(0)}, A[3] = {MPMAll(0)};

      if (!MPM_PART_USED(dim, h) || (!forces && !MPM_PART_MOTION(dim, h))) continue;
      for (int e = 0; e < 1 + (force ? dim : 0); e++) Q[e] = MPMRead(r->Q[l][e] + h * MPM_WIDTH);
      for (int e = 0; e < (motion ? dim : 0); e++) A[e] = MPMRead(r->A[l][e] + h * MPM_WIDTH);
      for (int k = 0; k < nz; k++) {
        MPMReal P = Q[0], Px = Q[1], Py = Q[2], a = A[0], b = A[1]; /* of a plane of nodes */

        if (dim > 2) {
          const MPMReal wz = MPMAll(s->w[2][k][l]), gz = MPMAll(s->g[2][k][l]);

          if (motion) P += MPMMultiple(k, A[2]);
          P = wz * P;
          if (motion) a = wz * a, b = wz * b;
          if (force) P = MPMFma(gz, Q[3], P), Px = wz * Px, Py = wz * Py;
        }
        MPM_UNROLL_NODES
        for (int j = 0; j < ny; j++) {
          MPMReal R = P, Rx = Px, c = a; /* of a row of nodes */

          if (dim > 1) {
            const MPMReal wy = MPMAll(s->w[1][j][l]), gy = MPMAll(s->g[1][j][l]);

            if (motion) R += MPMMultiple(j, b);
            R = wy * R;
            if (motion) c = wy * c;
            if (force) R = MPMFma(gy, Py, R), Rx = wy * Rx;
          }
          MPM_UNROLL_NODES
          for (int i = 0; i < ns; i++) {
            MPMReal *to = &sum[(k * ny + j) * ns + i][h];

            *to = MPMFma(MPMAll(s->w[0][i][l]), motion ? R + MPMMultiple(i, c) : R, *to);
            if (force) *to = MPMFma(MPMAll(s->g[0][i][l]), Rx, *to);
          }
        }
      }
    }
  }
}

/* Adds the sums of a cell to those of its nodes in its tile, at `place`, and zeroes them. */
MPM_INLINE void MPMFlush(int dim, int ns, PetscReal *place, MPMReal (*sum)[MPM_PARTS])
{
  const int ny = dim > 1 ? ns : 1, nz = dim > 2 ? ns : 1, side = (1 << MPM_TILE_BITS(ns)) + ns - 1;

  for (int a = 0; a < nz * ny * ns; a++)
    for (int h = 0; h < MPM_PARTS; h++)
      if (MPM_PART_USED(dim, h)) {
        PetscReal *node = place + MPM_NODE_NC * (a % ns + side * (a / ns % ny + side * (a / (ns * ny))));

        MPMWrite(node + h * MPM_WIDTH, MPMRead(node + h * MPM_WIDTH) + sum[a][h]);
        sum[a][h] = MPMAll(0);
      }
}

/* Adds a block of particles to the sums of their tiles. `begun` has the sums of the cell in which the last block ended;
   on return it has those of this block's last cell. */
MPM_INLINE void MPMSumBlock(int dim, int ns, int forces, int affine, const MPMBlockOrder *o, const MPMStencils *s,
                            const MPMRecords *r, PetscReal *const place[], MPMBegun *begun)
{
  const int nn = ns * (dim > 1 ? ns : 1) * (dim > 2 ? ns : 1);
  MPMSums   sum;

  memcpy(sum, begun->sum, (size_t)nn * sizeof *sum);
  for (PetscInt c = 0, first = 0; c < o->ncells; first = o->end[c++]) {
    if (begun->place && place[c] != begun->place) MPMFlush(dim, ns, begun->place, sum);
    begun->place = place[c];
    MPMAccumulate(dim, ns, forces, affine, s, r, first, o->end[c], sum);
  }
  memcpy(begun->sum, sum, (size_t)nn * sizeof *sum);
}

/* --- Nodes to particles ------------------------------------------------------------------------------------------- */
/* Sums over the nodes of a cell for MPM_WIDTH of its particles, the lanes, from l on: nv values with phi, and the
   gradients of the first dim of them with grad phi. node: the motion of the cell's base node; at: the offsets of the
   others. */
MPM_INLINE void MPMInterpolate(int dim, int ns, int nv, int gradients, const PetscReal *node, const PetscInt at[],
                               const MPMStencils *s, PetscInt l, MPMComponent *value, MPMComponent *gradient)
{
  const int ny = dim > 1 ? ns : 1, nz = dim > 2 ? ns : 1, n = gradients && nv < dim ? dim : nv,
            ng = gradients ? dim : 0;
  MPMReal V[6], G[9];

  for (int f = 0; f < n; f++) V[f] = MPMAll(0);
  for (int f = 0; f < ng * dim; f++) G[f] = MPMAll(0);
  for (int k = 0; k < nz; k++) {
    MPMReal P[6], Px[3], Py[3]; /* of a plane of nodes, with phi, d phi/dx and d phi/dy */

    for (int f = 0; f < n; f++) P[f] = MPMAll(0);
    for (int f = 0; f < ng; f++) Px[f] = Py[f] = MPMAll(0);
    MPM_UNROLL_NODES
    for (int j = 0; j < ny; j++) {
      MPMReal R[6], Rx[3]; /* of a row of nodes */

      for (int f = 0; f < n; f++) R[f] = MPMAll(0);
      for (int f = 0; f < ng; f++) Rx[f] = MPMAll(0);
      MPM_UNROLL_NODES
      for (int i = 0; i < ns; i++) {
        const PetscReal *u  = node + at[(k * ny + j) * ns + i];
        const MPMReal    wx = MPMRead(&s->w[0][i][l]), gx = MPMRead(&s->g[0][i][l]);

        for (int f = 0; f < n; f++) R[f] = MPMFma(wx, MPMAll(u[f]), R[f]);
        for (int f = 0; f < ng; f++) Rx[f] = MPMFma(gx, MPMAll(u[f]), Rx[f]);
      }
      if (dim > 1) {
        const MPMReal wy = MPMRead(&s->w[1][j][l]), gy = MPMRead(&s->g[1][j][l]);

        for (int f = 0; f < n; f++) P[f] = MPMFma(wy, R[f], P[f]);
        for (int f = 0; f < ng; f++) Px[f] = MPMFma(wy, Rx[f], Px[f]), Py[f] = MPMFma(gy, R[f], Py[f]);
      } else {
        for (int f = 0; f < n; f++) P[f] = R[f];
        for (int f = 0; f < ng; f++) Px[f] = Rx[f];
      }
    }
    if (dim > 2) {
      const MPMReal wz = MPMRead(&s->w[2][k][l]), gz = MPMRead(&s->g[2][k][l]);

      for (int f = 0; f < nv; f++) V[f] = MPMFma(wz, P[f], V[f]);
      for (int f = 0; f < ng; f++) {
        MPMReal *to = G + f * dim;

        to[0]       = MPMFma(wz, Px[f], to[0]);
        to[1]       = MPMFma(wz, Py[f], to[1]);
        to[dim - 1] = MPMFma(gz, P[f], to[dim - 1]);
      }
    } else {
      for (int f = 0; f < nv; f++) V[f] = P[f];
      for (int f = 0; f < ng; f++) G[f * dim] = Px[f];
      for (int f = 0; f < ng && dim > 1; f++) G[f * dim + 1] = Py[f];
    }
  }
  for (int f = 0; f < nv; f++) MPMWrite(&value[f][l], V[f]);
  for (int f = 0; f < ng * dim; f++) MPMWrite(&gradient[f][l], G[f]);
}

/* Does the same for all particles of a block. Lanes past the end of a cell get numbers that the next cell overwrites,
   or that lie past the end of the block. */
MPM_INLINE void MPMInterpolateBlock(int dim, int ns, int nv, int gradients, const MPMBlockOrder *o,
                                    const MPMStencils *s, const PetscInt at[], const PetscReal *nodes,
                                    MPMComponent *value, MPMComponent *gradient)
{
  for (PetscInt c = 0, first = 0; c < o->ncells; first = o->end[c++])
    for (PetscInt l = first; l < o->end[c]; l += MPM_WIDTH)
      MPMInterpolate(dim, ns, nv, gradients, nodes + (size_t)s->base[first] * MPM_MOTION_NC(dim), at, s, l, value,
                     gradient);
}

/* --- Instances ---------------------------------------------------------------------------------------------------- */
#define MPM_FOR_ALL(X) X(1, 2) X(1, 3) X(1, 4) X(2, 2) X(2, 3) X(2, 4) X(3, 2) X(3, 3) X(3, 4)
#define MPM_SUM_BLOCK(dim, ns, forces, affine)                                                                         \
  static void SumBlock_##dim##ns##_##forces##affine(const MPMBlockOrder *o, const MPMStencils *s, const MPMRecords *r, \
                                                    PetscReal *const place[], MPMBegun *begun)                         \
  {                                                                                                                    \
    MPMSumBlock(dim, ns, forces, affine, o, s, r, place, begun);                                                       \
  }
#define MPM_INTERPOLATE_BLOCK(dim, ns, motion, stress)                                                                 \
  static void InterpolateBlock_##dim##ns##_##motion##stress(const MPMBlockOrder *o, const MPMStencils *s,              \
                                                            const PetscInt at[], const PetscReal *nodes,               \
                                                            MPMComponent *value, MPMComponent *gradient)               \
  {                                                                                                                    \
    MPMInterpolateBlock(dim, ns, motion ? 2 * dim : 0, stress, o, s, at, nodes, value, gradient);                      \
  }
#define MPM_DEFINE(dim, ns)                                                                                            \
  MPM_SUM_BLOCK(dim, ns, 0, 0)                                                                                         \
  MPM_SUM_BLOCK(dim, ns, 0, 1)                                                                                         \
  MPM_SUM_BLOCK(dim, ns, 1, 0)                                                                                         \
  MPM_SUM_BLOCK(dim, ns, 1, 1)                                                                                         \
  MPM_INTERPOLATE_BLOCK(dim, ns, 0, 1)                                                                                 \
  MPM_INTERPOLATE_BLOCK(dim, ns, 1, 0)                                                                                 \
  MPM_INTERPOLATE_BLOCK(dim, ns, 1, 1)
MPM_FOR_ALL(MPM_DEFINE)

#define MPM_SUM_ENTRY(dim, ns)                                                                                         \
  [dim - 1][ns - 2] = {{SumBlock_##dim##ns##_00, SumBlock_##dim##ns##_01},                                             \
                       {SumBlock_##dim##ns##_10, SumBlock_##dim##ns##_11}},
#define MPM_INTERPOLATE_ENTRY(dim, ns)                                                                                 \
  [dim - 1][ns - 2] = {{NULL, InterpolateBlock_##dim##ns##_01},                                                        \
                       {InterpolateBlock_##dim##ns##_10, InterpolateBlock_##dim##ns##_11}},
const MPMSumBlocks         MPM_LANES_NAME(MPMSumBlock)[3][3][2][2]         = {MPM_FOR_ALL(MPM_SUM_ENTRY)};
const MPMInterpolateBlocks MPM_LANES_NAME(MPMInterpolateBlock)[3][3][2][2] = {MPM_FOR_ALL(MPM_INTERPOLATE_ENTRY)};

/* Runs n rounds of MPM_CHAINS independent sequences of fused multiply-adds. start and end keep the compiler from
   removing them. */
#define MPM_CHAINS 16
PetscReal MPM_LANES_NAME(MPMChains)(PetscInt n, PetscReal start, volatile PetscReal *end)
{
  MPMReal x[MPM_CHAINS];

  for (int k = 0; k < MPM_CHAINS; k++) x[k] = MPMAll(start + 1e-9 * k);
  for (PetscInt i = 0; i < n; i++) MPM_UNROLL
  for (int k = 0; k < MPM_CHAINS; k++) x[k] = MPMFma(x[k], MPMAll(0.999999999), MPMAll(1e-9));
  for (int k = 0; k < MPM_CHAINS; k++) {
    PetscReal lane[MPM_WIDTH];

    memcpy(lane, &x[k], sizeof lane);
    *end = lane[0];
  }
  return (PetscReal)n * MPM_CHAINS * MPM_WIDTH * 2;
}
