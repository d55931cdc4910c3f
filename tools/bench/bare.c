/* bare.c - an instrument for those who change kernels: the arithmetic of usl with FLIP and a neo-Hookean material, and
   nothing else, with which `make bench` compares a step. A step is P2G of mass, momentum and internal force, with the
   stress from F; the nodes' velocity and acceleration; G2P of both and of the velocity gradient, with the new velocity,
   position and F. In 2-D it is plane strain.

   It leaves out: the order of particles (they are sorted off the clock), ids, tiles, walls, wave speeds, checks,
   messages, any choice while it runs; fields are arrays of one component each. Positions are in cells. Products and
   sums are fused as the compiler likes. What it shares with Pebble are vectors, basis functions and logarithm (src/base,
   src/physics/basis.h), and the sequence: blocks of whole cells, weights once for each block, the sums of a cell in
   registers.

   bare_W name=value ...: it is compiled for vectors of W = 8, 4 or 2 numbers; tools/bench/scene.py gives the values.
   It prints the totals at the end, which bench.py compares with Pebble's, and the wall time in ns a particle and step. */
#include "base/rows.h"
#include "base/tensor.h"
#include "physics/basis.h"

#if MPM_WIDTH == 8
#include <immintrin.h>
#endif
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define W         MPM_WIDTH
#define ROOM      (80 + 2 * W) /* particles that a block has room for */
#define FAIL(...) (fprintf(stderr, "bare: " __VA_ARGS__), fputc('\n', stderr), exit(1))

/* The sums of a node are 8 numbers. In 3-D these are m, p [3], f [3]. In 2-D they are m, p [2] and the parts of the
   force: tau_xy phi_y, tau_yy phi_y, tau_xx phi_x, tau_xy phi_x. The motion of a node is v [dim], a [dim]. */
typedef struct {
  long    n, ncells, all;              /* particles, cells that have any, nodes */
  double *x[3], *v[3], *F[9], *spare;  /* fields of the particles; x in cells; spare: room for one more */
  long   *base;                        /* of each cell that has particles, the first node of its stencil */
  int    *end, *cell, *place, *count;  /* of each such cell the end of its particles; the others are for sorting */
  int     nodes[3], first[3], last[3]; /* nodes on each axis; a box of nodes around those that particles touch */
  double *sums, *motion;               /* of the nodes */
  double  h, l, m, V0, mu, lambda, dt; /* l: half-width of a particle's domain, cells */
} Body;

/* A block of whole cells, in arrays of one number for each of its particles. Place 0 is particle `from`, a multiple of
   W, so vectors of the block are vectors of the fields. */
typedef struct {
  double w[3][4][ROOM], g[3][4][ROOM]; /* weights and gradients, the latter per cell */
  double record[ROOM][32];             /* of P2G: what is multiplied by weights and gradients */
  double value[6][ROOM], L[9][ROOM];   /* of G2P: sum phi v, sum phi a, h times the velocity gradient */
  long   from, first, last;            /* particles of the block: first .. last-1 */
  long   cell, next;                   /* cells: cell .. next-1 */
} Block __attribute__((aligned(64)));

/* Advances to the next block, and computes the weights of its particles. Returns whether there was one. */
MPM_INLINE int NextBlock(int dim, MPMBasis basis, const Body *body, Block *k)
{
  const Body b = *body; /* a copy, which no write changes, so its members stay in registers */

  k->cell = k->next;
  if (k->cell == b.ncells) return 0;
  k->first = k->cell ? b.end[k->cell - 1] : 0;
  k->from  = k->first - k->first % W;
  do k->last = b.end[k->next++];
  while (k->next < b.ncells && b.end[k->next] - k->first <= (dim == 2 ? 64 : 32));
  if (k->last - k->from > ROOM - W) FAIL("a cell has %ld particles", k->last - k->first);
  for (int d = 0; d < dim; d++) {
    const MPMBases bases = MPMBasisBasesOf(basis, b.nodes[d], PETSC_FALSE, MPM_WALL_BASIS_NONE);

    for (long p = k->from, q = 0; p < k->last; p += W, q += W) {
      MPMReal       xi   = MPMRead(b.x[d] + p), w[4], g[4];
      const MPMReal base = MPMBasisBases(basis, &bases, MPMAll(b.l), &xi);

      MPMBasisInside(basis, xi, MPMAll(b.l), base, w, g);
      for (int i = 0; i < MPMBasisNodes(basis); i++) MPMWrite(k->w[d][i] + q, w[i]), MPMWrite(k->g[d][i] + q, g[i]);
    }
  }
  return 1;
}

/* --- Particles to nodes ------------------------------------------------------------------------------------------- */

/* Computes what the particles of a block give to their nodes, -V0 tau/h and m v. */
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
    } else { /* times w w w, g w w, w g w, w w g */
      const MPMReal all[32] = {m,    v[0], v[1], v[2], none, none, none, none, none, none, none, none, t[0], t[1], t[2], none,
                               none, none, none, none, t[1], t[3], t[4], none, none, none, none, none, t[2], t[4], t[5], none};

      MPMWriteRows(32, all, row);
    }
  }
}

/* Returns a vector of w, but of g in the lanes of part h that `lanes` has, a bit for each of 8 sums. */
MPM_INLINE MPMReal Along(unsigned lanes, int h, MPMReal w, MPMReal g)
{
#if W == 8
  (void)h;
  return _mm512_mask_blend_pd((__mmask8)lanes, w, g);
#else
  for (int l = 0; l < W; l++) w[l] = lanes >> (h * W + l) & 1 ? g[l] : w[l];
  return w;
#endif
}

/* Adds part h (W numbers) of the sums of a cell's particles, places first .. last-1 of the block, to the nodes of
   `layers` rows (2-D) or planes from layer z on; the first node of the cell is `node`. */
MPM_INLINE void SumCell(int dim, int ns, int h, int z, int layers, const Block *k, long first, long last, long width,
                        long plane, double *node)
{
  const int force = (h + 1) * W > 4; /* in 3-D: has this part a force? */
  const int each  = dim == 2 ? ns : ns * ns;
  MPMReal   sum[16];

  for (int a = 0; a < layers * each; a++) sum[a] = MPMAll(0);
  for (long q = first; q < last; q++) {
    const double *all = k->record[q] + h * W;
    MPMReal       wx[4], gx[4];

    for (int i = 0; i < ns; i++) {
      wx[i] = MPMAll(k->w[0][i][q]), gx[i] = MPMAll(k->g[0][i][q]);
      if (dim == 2) wx[i] = Along(0x60, h, wx[i], gx[i]);
    }
    for (int a = 0; a < layers; a++) {
      const MPMReal w = MPMAll(k->w[dim - 1][z + a][q]), g = MPMAll(k->g[dim - 1][z + a][q]);

      if (dim == 2) {
        const MPMReal row = MPMRead(all) * Along(0x18, h, w, g);

        for (int i = 0; i < ns; i++) sum[a * ns + i] += wx[i] * row;
      } else {
        const MPMReal rest = w * MPMRead(all) + (force ? g * MPMRead(all + 24) : MPMAll(0));
        const MPMReal x = w * MPMRead(all + 8), y = w * MPMRead(all + 16);

        for (int j = 0; j < ns; j++) {
          const MPMReal wy = MPMAll(k->w[1][j][q]), row = wy * rest + (force ? MPMAll(k->g[1][j][q]) * y : MPMAll(0));

          for (int i = 0; i < ns; i++) {
            MPMReal *to = sum + (a * ns + j) * ns + i;

            *to += wx[i] * row;
            if (force) *to += gx[i] * (wy * x);
          }
        }
      }
    }
  }
  for (int a = 0; a < layers * each; a++) {
    double *to = node + 8 * ((z + a / each) * (dim == 2 ? width : plane) + a % each / ns * width + a % ns) + h * W;

    MPMWrite(to, MPMRead(to) + sum[a]);
  }
}

/* Adds mass, momentum and internal force of all particles to the sums of the nodes, which were 0. */
MPM_INLINE void P2G(int dim, MPMBasis basis, Body *b, Block *k)
{
  const int  ns = MPMBasisNodes(basis), layers = dim == 2 ? (ns == 4 && W < 8 ? 2 : ns) : ns == 2 ? 2 : 1; /* registers */
  const long width = b->nodes[0], plane = width * b->nodes[1];

  k->next = 0;
  while (NextBlock(dim, basis, b, k)) {
    Records(dim, b, k);
    for (long c = k->cell, first = k->first - k->from; c < k->next; first = b->end[c++] - k->from)
      for (int z = 0; z < ns; z += layers) {
#define PART(h)                                                                                                        \
  if ((h) < 8 / W) SumCell(dim, ns, h, z, layers, k, first, b->end[c] - k->from, width, plane, b->sums + 8 * b->base[c]);
        /* Not a loop: each part shall have code of its own. */
        PART(0) PART(1) PART(2) PART(3)
      }
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
        const double f[3] = {dim == 2 ? sum[3] + sum[5] : sum[4], dim == 2 ? sum[4] + sum[6] : sum[5], sum[6]};

        for (int d = 0; d < dim; d++) {
          motion[dim + d] = f[d] * over;
          motion[d]       = (sum[1 + d] + b->dt * f[d]) * over;
        }
        for (int s = 0; s < 8; s++) sum[s] = 0;
      }
}

/* --- Nodes to particles ------------------------------------------------------------------------------------------- */

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
        const MPMReal wz = dim > 2 ? MPMRead(k->w[2][z] + q) : MPMAll(1), gz = dim > 2 ? MPMRead(k->g[2][z] + q) : none;
        MPMReal       pv = none, pa = none, px = none, py = none;

        for (int j = 0; j < ns; j++) {
          const double *at = node + 2 * dim * (z * plane + j * width) + c;
          const MPMReal wy = MPMRead(k->w[1][j] + q), gy = MPMRead(k->g[1][j] + q);
          MPMReal       rv = none, ra = none, rx = none;

          for (int i = 0; i < ns; i++, at += 2 * dim) {
            const MPMReal wx = MPMRead(k->w[0][i] + q);

            rv += wx * MPMAll(at[0]);
            rx += MPMRead(k->g[0][i] + q) * MPMAll(at[0]);
            ra += wx * MPMAll(at[dim]);
          }
          pv += wy * rv, pa += wy * ra, px += wy * rx, py += gy * rv;
        }
        v += wz * pv, a += wz * pa, vx += wz * px, vy += wz * py, vz += gz * pv;
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
    for (int c = 0; c < dim * dim; c++) F[c] = MPMRead(b.F[c] + p), L[c] = MPMRead(k->L[c] + q);
    MPMDeform(dim, b.dt / b.h, L, F);
    for (int c = 0; c < dim * dim; c++) MPMWrite(b.F[c] + p, F[c]);
  }
}

/* Brings the motion of the nodes to all particles, which get new velocities, positions and F. */
MPM_INLINE void G2P(int dim, MPMBasis basis, Body *b, Block *k)
{
  const long width = b->nodes[0], plane = width * b->nodes[1];

  k->next = 0;
  while (NextBlock(dim, basis, b, k)) {
    /* The vector that this block shares with the next one waits until that has its lanes too. */
    const long whole = k->last - (k->last < b->n ? k->last % W : 0), q = whole - k->from;

    for (long c = k->cell, first = k->first - k->from; c < k->next; first = b->end[c++] - k->from)
      Interpolate(dim, MPMBasisNodes(basis), b->motion + 2 * dim * b->base[c], width, plane, k, first, b->end[c] - k->from);
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
  double  **field[15];
  int       nf = 0;

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
  for (long p = 0; p < b->n; p++) b->place[p] = b->count[b->cell[p]]++;
  for (int d = 0; d < dim; d++) field[nf++] = &b->x[d], field[nf++] = &b->v[d];
  for (int c = 0; c < dim * dim; c++) field[nf++] = &b->F[c];
  for (int f = 0; f < nf; f++) {
    double *const from = *field[f];

    for (long p = 0; p < b->n; p++) b->spare[b->place[p]] = from[p];
    *field[f] = b->spare;
    b->spare  = from;
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

/* Returns the value of name=value among the arguments. */
static const char *Text(int argc, char **argv, const char *name)
{
  for (int k = 1; k < argc; k++)
    if (!strncmp(argv[k], name, strlen(name)) && argv[k][strlen(name)] == '=') return strchr(argv[k], '=') + 1;
  FAIL("%s=value is missing", name);
}

#define NUMBER(name) strtod(Text(argc, argv, name), NULL)
#define COUNT(name)  ((int)NUMBER(name))

/* Makes the particles and the nodes of the scene that the arguments describe. */
static void Fill(int argc, char **argv, int dim, Body *b)
{
  static const char *const shift[] = {"offset_0", "offset_1", "offset_2"};
  const int    ppa = COUNT("per_axis"), cells = COUNT("body"), start = COUNT("start"), side = cells * ppa;
  const double E = NUMBER("E"), nu = NUMBER("nu"), drift = NUMBER("drift"), half = NUMBER("half");
  double       lower[3] = {0};
  long         room;

  b->n = b->all = b->nodes[2] = 1;
  for (int d = 0; d < dim; d++) {
    lower[d] = start + NUMBER(shift[d]);
    b->n *= side;
    b->all *= b->nodes[d] = COUNT("grid") + 1;
  }
  room      = b->n + 2 * W;
  b->h      = 1.0 / COUNT("grid");
  b->l      = 0.5 / ppa;
  b->V0     = pow(b->h / ppa, dim);
  b->m      = NUMBER("rho") * b->V0;
  b->mu     = E / (2 * (1 + nu));
  b->lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  b->dt     = NUMBER("dt");
  for (int d = 0; d < dim; d++) b->x[d] = Numbers(room), b->v[d] = Numbers(room);
  for (int c = 0; c < dim * dim; c++) b->F[c] = Numbers(room);
  b->spare  = Numbers(room);
  b->sums   = Numbers(8 * b->all);
  b->motion = Numbers(2 * dim * b->all);
  b->base   = Numbers(b->n);
  b->end    = Numbers(b->n);
  b->cell   = Numbers(room);
  b->place  = Numbers(b->n);
  b->count  = Numbers(b->all + 1);
  for (long p = 0; p < room; p++) {
    long rest = p < b->n ? p : b->n - 1; /* the places after the last particle have copies of it */

    for (int d = 0; d < dim; d++, rest /= side) {
      b->x[d][p]             = lower[d] + (double)(rest % side + 0.5) / ppa;
      b->v[d][p]             = drift;
      b->F[d * (dim + 1)][p] = 1;
    }
    b->v[0][p] += b->x[0][p] < lower[0] + 0.5 * cells ? half : -half;
  }
}

/* Prints mass, momentum and energies of the particles. */
static void PrintTotals(int dim, const Body *b)
{
  double momentum[3] = {0}, kinetic = 0, strain = 0;

  for (long p = 0; p < b->n; p++) {
    double  trace = 3 - dim, lnJ;
    MPMReal F[9];

    for (int c = 0; c < dim * dim; c++) F[c] = MPMAll(b->F[c][p]), trace += b->F[c][p] * b->F[c][p];
    lnJ = log(MPMDet(dim, F)[0]);
    strain += b->V0 * (0.5 * b->mu * (trace - 3 - 2 * lnJ) + 0.5 * b->lambda * lnJ * lnJ);
    for (int d = 0; d < dim; d++) {
      momentum[d] += b->m * b->v[d][p];
      kinetic += 0.5 * b->m * b->v[d][p] * b->v[d][p];
    }
  }
  printf("mass %.17g\nmomentum %.17g %.17g %.17g\nkinetic %.17g\nstrain %.17g\n", (double)b->n * b->m, momentum[0],
         momentum[1], momentum[2], kinetic, strain);
}

int main(int argc, char **argv)
{
  static Body       b;
  const int         dim = COUNT("dim"), steps = COUNT("steps");
  const char *const basis    = Text(argc, argv, "basis");
  double (*run)(Body *, int) = NULL;

#define CHOOSE(d, name)                                                                                                \
  if (dim == d && !strcmp(basis, #name)) run = Run_##d##_##name;
  METHODS(CHOOSE)
  if (!run) FAIL("no method has dim=%d basis=%s", dim, basis);
  Fill(argc, argv, dim, &b);
  printf("ns per particle-step %.5g\n", 1e9 * run(&b, steps) / (double)b.n / steps);
  PrintTotals(dim, &b);
  return 0;
}
