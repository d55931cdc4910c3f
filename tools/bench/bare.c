/* bare.c - an instrument for those who change kernels: the arithmetic of usl with FLIP and a neo-Hookean material, and
   nothing else, with which `make bench` compares a step. In 2-D it is plane strain.

   What it shares with Pebble are vectors, basis functions, the innermost loops (kernels/transfer_sums.c) and blocks, here
   of whole cells. It leaves out: the order of particles (they are sorted off the clock), ids, tiles, walls, wave speeds,
   checks, messages, any choice while it runs; fields are arrays of one component each. Positions are in cells. Products
   and sums are fused as the compiler likes.

   bare_W FILE dim basis steps number ...: it is compiled for vectors of W = 8, 4 or 2 numbers; tools/bench.py gives the
   numbers, and the file with x and v of all particles. It prints the wall time in ns a particle and step, and writes v
   and F to the file; bench.py compares their totals with Pebble's. */
#include "kernels/transfer_sums.c"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define W          MPM_WIDTH
#define FAIL(what) (fprintf(stderr, "bare: %s\n", what), exit(1))

/* The sums of a node are as in Pebble, but in 2-D the parts of the force (kernels/records.h) stay apart. */
typedef struct {
  long n, ncells, all; /* particles, cells that have any, nodes */
  union {              /* fields of the particles; x in cells */
    struct {
      double *x[3], *v[3], *F[9];
    };
    double *field[15];
  };
  long   *base;                        /* of each cell that has particles, the first node of its stencil */
  int    *end, *cell, *count;          /* of each such cell the end of its particles; the others are for sorting */
  int     nodes[3], first[3], last[3]; /* nodes on each axis; a box of nodes around those that particles touch */
  double *sums, *motion, *spare;       /* of the nodes; room for one more field */
  double  h, l, m, V0, mu, lambda, dt; /* l: half-width of a particle's domain, cells */
} Body;

/* A block of whole cells. Place 0 is particle `from`, a multiple of W, so vectors of the block are vectors of the
   fields. */
typedef struct {
  MPMStencils  s;                             /* of these the weights and the gradients, the latter per cell */
  MPMRecords   r;                             /* of P2G: what is multiplied by weights and gradients */
  MPMComponent value[6], L[9];                /* of G2P: sum phi v, sum phi a, h times the velocity gradient */
  long         from, first, last, cell, next; /* particles first .. last-1 of cells cell .. next-1 */
} Block;

/* Advances to the next block, and computes the weights of its particles. Returns whether there was one. */
MPM_INLINE int NextBlock(int dim, MPMBasis basis, const Body *body, Block *k)
{
  const Body b = *body; /* a copy, which no write changes, so its members stay in registers */

  k->cell = k->next;
  if (k->cell == b.ncells) return 0;
  k->first = k->cell ? b.end[k->cell - 1] : 0;
  k->from  = k->first - k->first % W;
  do k->last = b.end[k->next++];
  while (k->next < b.ncells && b.end[k->next] - k->first <= (dim == 2 ? MPM_STAGED - W : MPM_STAGED / 2));
  if (k->last - k->from > MPM_STAGED) FAIL("a cell has too many particles");
  for (int d = 0; d < dim; d++) {
    const MPMBases bases = MPMBasisBasesOf(basis, b.nodes[d], PETSC_FALSE, MPM_WALL_BASIS_NONE);

    for (long p = k->from, q = 0; p < k->last; p += W, q += W) {
      MPMReal       xi   = MPMRead(b.x[d] + p), w[4], g[4];
      const MPMReal base = MPMBasisBases(basis, &bases, MPMAll(b.l), &xi);

      MPMBasisInside(basis, xi, MPMAll(b.l), base, w, g);
      for (int i = 0; i < MPMBasisNodes(basis); i++) {
        MPMWrite(k->s.w[d][i] + q, w[i]);
        MPMWrite(k->s.g[d][i] + q, g[i]);
      }
    }
  }
  return 1;
}

/* --- Particles to nodes ------------------------------------------------------------------------------------------- */

/* Computes what the particles of a block give to their nodes, m v and -V0 tau/h. */
MPM_INLINE void Records(int dim, const Body *body, Block *k)
{
  const Body    b    = *body;
  const MPMReal none = MPMAll(0);

  for (long p = k->from, q = 0; p < k->last; p += W, q += W) {
    MPMReal F[9], C[6], t[6], v[3] = {none, none, none}, lnJ;

    for (int c = 0; c < dim * dim; c++) F[c] = MPMRead(b.F[c] + p);
    for (int d = 0; d < dim; d++) v[d] = b.m * MPMRead(b.v[d] + p);
    lnJ = MPMLog(MPMDet(dim, F));
    MPMLeftCauchyGreen(dim, F, C);
    for (int c = 0; c < 6; c++) {
      const int diagonal = c == 0 || c == 3 || c == 5;

      t[c] = -b.V0 / b.h * (diagonal ? b.lambda * lnJ + b.mu * (C[c] - 1.0) : b.mu * C[c]);
    }
    const MPMReal all[8] = {MPMAll(b.m), v[0], v[1], v[2], t[1], t[3], t[0], t[1]};

    MPMWriteRecords(dim == 2 ? 8 : 4, all, k->r.Q[q][0], MPM_Q_RECORDS);
    for (int e = 0; e < dim && dim > 2; e++) {
      const MPMReal of[4] = {t[e], t[e ? 2 + e : 1], t[e ? 3 + e : 2], none}; /* xx xy xz, xy yy yz, xz yz zz */

      MPMWriteRecords(3, of, k->r.Q[q][1 + e] + MPM_NODE_force, MPM_Q_RECORDS);
    }
  }
}

/* Adds the sums of a cell's particles, places first .. last-1 of the block, to its nodes; the first one is `node`. */
MPM_INLINE void SumCell(int dim, int ns, const Block *k, PetscInt first, PetscInt last, long row, long plane,
                        double *node)
{
  const int rows = MPM_ROWS(dim, ns), planes = MPM_PLANES(dim, ns);

  MPM_UNROLL
  for (int h = 0; h < MPM_PARTS; h++)
    for (int k0 = 0; k0 < (dim > 2 ? ns : 1); k0 += planes)
      for (int j0 = 0; j0 < ns; j0 += rows) {
        MPMReal sum[16];

        for (int a = 0; a < planes * rows * ns; a++) sum[a] = MPMAll(0);
        MPMAccumulate(dim, ns, (h + 1) * W > MPM_NODE_force, 0, 0, h, k0, j0, &k->s, &k->r, first, last, sum);
        for (int a = 0; a < planes * rows * ns; a++) {
          double *to = node + (k0 + a / (rows * ns)) * plane + (j0 + a / ns % rows) * row + 8 * (a % ns) + h * W;

          MPMWrite(to, MPMRead(to) + sum[a]);
        }
      }
}

/* Adds mass, momentum and internal force of all particles to the sums of the nodes, which were 0. */
MPM_INLINE void P2G(int dim, MPMBasis basis, Body *b, Block *k)
{
  const long row = MPM_NODE_NC * b->nodes[0], plane = row * b->nodes[1];

  k->next = 0;
  while (NextBlock(dim, basis, b, k)) {
    Records(dim, b, k);
    for (long c = k->cell, first = k->first - k->from; c < k->next; first = b->end[c++] - k->from)
      SumCell(dim, MPMBasisNodes(basis), k, first, b->end[c] - k->from, row, plane, b->sums + MPM_NODE_NC * b->base[c]);
  }
}

/* Computes a = f/m and v = p/m + dt a of all nodes that have mass, and zeroes the sums for the next step. */
MPM_INLINE void Nodes(int dim, Body *b)
{
  for (int z = b->first[2]; z <= b->last[2]; z++)
    for (int y = b->first[1]; y <= b->last[1]; y++)
      for (int x = b->first[0]; x <= b->last[0]; x++) {
        const long   i   = ((long)z * b->nodes[1] + y) * b->nodes[0] + x;
        double      *sum = b->sums + 8 * i, *motion = b->motion + 2 * dim * i;
        const double over = sum[0] > 0 ? 1 / sum[0] : 0;
        const double f[3] = {sum[4] + (dim == 2 ? sum[6] : 0), sum[5] + (dim == 2 ? sum[7] : 0), sum[6]};

        for (int d = 0; d < dim; d++) {
          motion[dim + d] = f[d] * over;
          motion[d]       = (sum[1 + d] + b->dt * f[d]) * over;
        }
        for (int s = 0; s < 8; s++) sum[s] = 0;
      }
}

/* --- Nodes to particles ------------------------------------------------------------------------------------------- */

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
    for (int c = 0; c < dim * dim; c++) F[c] = MPMRead(b.F[c] + p), L[c] = MPMRead(k->L[c] + q);
    MPMDeform(dim, b.dt / b.h, L, F);
    for (int c = 0; c < dim * dim; c++) MPMWrite(b.F[c] + p, F[c]);
  }
}

/* Brings the motion of the nodes to all particles, which get new velocities, positions and F. */
MPM_INLINE void G2P(int dim, MPMBasis basis, Body *b, Block *k)
{
  size_t row = 2 * (size_t)dim * (size_t)b->nodes[0], plane = row * (size_t)b->nodes[1];

  k->next = 0;
  while (NextBlock(dim, basis, b, k)) {
    /* The vector that this block shares with the next one waits until that has its lanes too. */
    const long whole = k->last - (k->last < b->n ? k->last % W : 0), q = whole - k->from;

    /* The last vector of a cell has lanes of the next one, which then writes them anew. */
    for (long c = k->cell, first = k->first - k->from; c < k->next; first = b->end[c++] - k->from) {
      const double *node = b->motion + 2 * dim * b->base[c];

      for (long l = first; l < b->end[c] - k->from; l += W) {
        __asm__("" : "+r"(node), "+r"(row), "+r"(plane)); /* as in MPMInterpolateBlock */
        MPMInterpolate(dim, MPMBasisNodes(basis), 2 * dim, 1, node, row, plane, &k->s, (PetscInt)l, k->value, k->L);
      }
    }
    Move(dim, b, k, whole);
    for (int c = 0; c < 2 * dim; c++) MPMWrite(k->value[c], MPMRead(k->value[c] + q));
    for (int c = 0; c < dim * dim; c++) MPMWrite(k->L[c], MPMRead(k->L[c] + q));
  }
}

/* --- Steps -------------------------------------------------------------------------------------------------------- */

/* Puts the particles in the order of their cells, and lists the cells that have any. */
MPM_INLINE void Sort(int dim, MPMBasis basis, Body *b)
{
  const int ns = MPMBasisNodes(basis);

  for (int d = 0; d < 3; d++) b->first[d] = dim > d ? b->nodes[d] : 0, b->last[d] = 0;
  memset(b->count, 0, (size_t)(b->all + 1) * sizeof *b->count);
  for (long p = 0; p < b->n; p += W) {
    MPMReal cell = MPMAll(0);

    for (int d = dim - 1; d >= 0; d--) {
      const MPMBases bases = MPMBasisBasesOf(basis, b->nodes[d], PETSC_FALSE, MPM_WALL_BASIS_NONE);
      MPMReal        xi    = MPMRead(b->x[d] + p);
      const MPMReal  at    = MPMBasisBases(basis, &bases, MPMAll(b->l), &xi);

      cell = cell * b->nodes[d] + at;
      for (int l = 0; l < W && p + l < b->n; l++) {
        if (at[l] < 0 || at[l] + ns > b->nodes[d]) FAIL("a particle is near a wall");
        b->first[d] = PetscMin(b->first[d], (int)at[l]);
        b->last[d]  = PetscMax(b->last[d], (int)at[l] + ns - 1);
      }
    }
    for (int l = 0; l < W && p + l < b->n; l++) b->count[(b->cell[p + l] = (int)cell[l]) + 1]++;
  }
  b->ncells = 0;
  for (long c = 0; c < b->all; c++) {
    if (b->count[c + 1]) b->base[b->ncells] = c, b->end[b->ncells++] = b->count[c] + b->count[c + 1];
    b->count[c + 1] += b->count[c];
  }
  for (long p = 0; p < b->n; p++) b->cell[p] = b->count[b->cell[p]]++;
  for (int f = 0; f < 15; f++) {
    double *const from = b->field[f];

    if (!from) continue;
    for (long p = 0; p < b->n; p++) b->spare[b->cell[p]] = from[p];
    b->field[f] = b->spare;
    b->spare    = from;
  }
}

static double Now(void)
{
  struct timespec t;

  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Returns the seconds of the steps, without sorting. */
MPM_INLINE double Run(int dim, MPMBasis basis, Body *b, int steps)
{
  static Block block;
  double       seconds = 0;

  for (int s = 0; s < steps; s++) {
    Sort(dim, basis, b);
    seconds -= Now();
    P2G(dim, basis, b, &block);
    Nodes(dim, b);
    G2P(dim, basis, b, &block);
    seconds += Now();
  }
  return seconds;
}

/* The methods that are timed, each with loops of its own. */
#define METHODS(METHOD)                                                                                                \
  METHOD(2, linear) METHOD(2, bspline2) METHOD(2, bspline3) METHOD(2, gimp) METHOD(3, linear) METHOD(3, bspline2)
#define DEFINE(dim, basis)                                                                                             \
  static __attribute__((noinline)) double Run_##dim##_##basis(Body *b, int steps)                                      \
  {                                                                                                                    \
    return Run(dim, MPM_BASIS_##basis, b, steps);                                                                      \
  }
METHODS(DEFINE)

/* --- The scene ---------------------------------------------------------------------------------------------------- */

/* Returns n zeroed numbers. Each array begins at another place of a page, since those at the same one would compete for
   the same lines of the cache. */
static void *Numbers(long n)
{
  static int    arrays;
  const size_t  bytes = ((size_t)n * 8 + 3 * 4096) / 4096 * 4096;
  double *const from  = aligned_alloc(4096, bytes);

  if (!from) FAIL("out of memory");
  memset(from, 0, bytes);
  return from + 40 * (arrays++ % 13); /* lines of 8 numbers */
}

/* Makes the particles, with x [dim][n] and v [dim][n] from a file, and the nodes. */
static void Fill(int dim, char **number, FILE *file, Body *b)
{
  const long room = (b->n = atol(number[0])) + 2 * W;

  b->all = 1;
  for (int d = 0; d < 3; d++) b->all *= b->nodes[d] = d < dim ? atoi(number[1]) + 1 : 1;
  b->h      = 1 / atof(number[1]);
  b->l      = atof(number[2]);
  b->m      = atof(number[3]);
  b->V0     = atof(number[4]);
  b->lambda = atof(number[5]);
  b->mu     = atof(number[6]);
  b->dt     = atof(number[7]);
  b->spare  = Numbers(room);
  b->sums   = Numbers(MPM_NODE_NC * b->all);
  b->motion = Numbers(2 * dim * b->all);
  b->base   = Numbers(b->n);
  b->end    = Numbers(b->n);
  b->cell   = Numbers(room);
  b->count  = Numbers(b->all + 1);
  for (int f = 0; f < 15; f++) {
    double *field;

    if (f < 6 ? f % 3 >= dim : f - 6 >= dim * dim) continue;
    field = b->field[f] = Numbers(room);
    if (f < 6 && fread(field, 8, (size_t)b->n, file) != (size_t)b->n) FAIL("the file is too short");
    for (long p = f < 6 ? b->n : 0; p < room; p++) /* places after the last particle have copies of it */
      field[p] = f < 6 ? field[b->n - 1] : (f - 6) % (dim + 1) == 0;
  }
}

int main(int argc, char **argv)
{
  static Body b;
  FILE *const file = argc == 13 ? fopen(argv[1], "r+b") : NULL;
  const int   dim = file ? atoi(argv[2]) : 0, steps = file ? atoi(argv[4]) : 0;
  double (*run)(Body *, int) = NULL;

#define CHOOSE(d, name)                                                                                                \
  if (dim == d && !strcmp(argv[3], #name)) run = Run_##d##_##name;
  METHODS(CHOOSE)
  if (!run) FAIL("not a file, a method and 9 numbers");
  Fill(dim, argv + 5, file, &b);
  printf("ns per particle-step %.5g\n", 1e9 * run(&b, steps) / (double)b.n / steps);
  rewind(file);
  for (int f = 3; f < 15; f++)
    if (b.field[f]) fwrite(b.field[f], 8, (size_t)b.n, file);
  return fclose(file);
}
