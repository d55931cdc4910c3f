/* bare.c - the floor that `make bench` compares a step of Pebble with: the arithmetic of usl with FLIP and a neo-Hookean
   material, and nothing else. A step is P2G of mass, momentum and internal force, with the stress from F; the nodes'
   velocity and acceleration; G2P of both and of the velocity gradient, with the new velocity, position and F. In 2-D it
   is plane strain.

   What it leaves out, and what a whole step over this one therefore costs: particles are sorted by cell between steps
   and not on the clock, so there is no order to keep, no list of it to read rows through, and no movers; fields are
   arrays of one component each (Pebble's are rows of a DMSwarm), so nothing is turned but the records of P2G; there are
   no ids, no tiles (the sums of a cell go straight to the nodes), no walls, no wave speeds for dt, no checks of states or
   positions, no messages, no choice of method or material while it runs. Positions are in cells, so that no product with
   1/h is needed. Products and sums are fused as the compiler likes. What it shares with Pebble are vectors of particles,
   basis functions and logarithm (src/base, src/physics/basis.h), and the sequence: blocks of whole cells, weights once
   for each block, the sums of a cell in registers.

   bare_W name=value ...: it is compiled for vectors of W = 8, 4 or 2 numbers; tools/bench/scene.py gives the values.
     dim=2|3  basis=linear|gimp|bspline2|bspline3  grid, body: cells on each axis of the box and of the body
     per_axis: particles a cell on each axis  start: first cell of the body  offset_0 ...: its shift, cells
     drift, half: all particles move at drift on each axis, along x half faster in the left half, else half slower, m/s
     E nu rho dt: Pa, 1, kg/m^3, s  steps
   It prints the totals at the end, and the wall time of the steps and of their parts, in ns a particle and step. */
#include "bare_g2p.h"
#include "bare_p2g.h"

#include <math.h>
#include <time.h>

/* --- A step ------------------------------------------------------------------------------------------------------- */

/* Puts the particles in the order of their cells, and lists the cells that have any. */
MPM_INLINE void Sort(int dim, MPMBasis basis, Body *b)
{
  const int  ns  = MPMBasisNodes(basis);
  const long all = (long)b->nodes[0] * b->nodes[1] * b->nodes[2];
  double   **field[15];
  int        nf = 0, sorted = 1;

  for (int d = 0; d < 3; d++) b->first[d] = dim > d ? b->nodes[d] : 0, b->last[d] = 0;
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
    for (int l = 0; l < W; l++) b->cell[p + l] = (int)cell[l];
  }
  memset(b->count, 0, (size_t)(all + 1) * sizeof *b->count);
  for (long p = 0; p < b->n; p++) {
    b->count[b->cell[p] + 1]++;
    sorted = sorted && (p == 0 || b->cell[p - 1] <= b->cell[p]);
  }
  b->ncells = 0;
  for (long c = 0; c < all; c++) {
    if (b->count[c + 1]) {
      b->base[b->ncells]  = c;
      b->end[b->ncells++] = b->count[c] + b->count[c + 1];
    }
    b->count[c + 1] += b->count[c];
  }
  if (sorted) return;
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

/* Returns the time of the clock, s. */
static double Now(void)
{
  struct timespec t;

  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Makes steps and measures their times. */
MPM_INLINE void Run(int dim, MPMBasis basis, Body *b, int steps)
{
  static Block block;

  for (int s = 0; s < steps; s++) {
    double at[4];

    Sort(dim, basis, b);
    at[0] = Now();
    P2G(dim, basis, b, &block);
    at[1] = Now();
    Nodes(dim, b);
    at[2] = Now();
    G2P(dim, basis, b, &block);
    at[3] = Now();
    b->seconds += at[3] - at[0];
    for (int part = 0; part < 3; part++)
      b->least[part] = s ? PetscMin(b->least[part], at[part + 1] - at[part]) : at[part + 1] - at[part];
  }
}

/* The methods that are timed, each with loops of its own. */
#define METHODS(METHOD)                                                                                                \
  METHOD(2, linear) METHOD(2, bspline2) METHOD(2, bspline3) METHOD(2, gimp) METHOD(3, linear) METHOD(3, bspline2)
#define DEFINE(dim, basis)                                                                                             \
  static __attribute__((noinline)) void Run_##dim##_##basis(Body *b, int steps)                                        \
  {                                                                                                                    \
    Run(dim, MPM_BASIS_##basis, b, steps);                                                                             \
  }
METHODS(DEFINE)

/* --- The scene ---------------------------------------------------------------------------------------------------- */

/* Returns n zeroed numbers. Each array begins at another place of a page, since those at the same one would compete for
   the same lines of the cache. */
static double *Numbers(long n)
{
  static int    arrays;
  double *const from = aligned_alloc(4096, ((size_t)n * 8 + 3 * 4096) / 4096 * 4096);

  if (!from) FAIL("out of memory");
  memset(from, 0, ((size_t)n * 8 + 3 * 4096) / 4096 * 4096);
  return from + 40 * (arrays++ % 13); /* lines of 8 numbers */
}

/* Returns n integers, all 0. */
static int *Counts(long n)
{
  int *const from = calloc((size_t)n, sizeof *from);

  if (!from) FAIL("out of memory");
  return from;
}

/* Returns the value of name=value among the arguments. */
static const char *Text(int argc, char **argv, const char *name)
{
  for (int k = 1; k < argc; k++)
    if (!strncmp(argv[k], name, strlen(name)) && argv[k][strlen(name)] == '=') return strchr(argv[k], '=') + 1;
  FAIL("%s=value is missing", name);
  return NULL;
}

#define NUMBER(name) strtod(Text(argc, argv, name), NULL)
#define COUNT(name)  ((int)strtol(Text(argc, argv, name), NULL, 10))

/* Makes the particles and the nodes of the scene that the arguments describe. */
static void Fill(int argc, char **argv, int dim, Body *b)
{
  const int    ppa = COUNT("per_axis"), cells = COUNT("body"), start = COUNT("start"), side = cells * ppa;
  const double E = NUMBER("E"), nu = NUMBER("nu"), drift = NUMBER("drift"), half = NUMBER("half");
  double       offset[3] = {0};
  long         all       = 1, room;

  b->n = 1;
  for (int d = 0; d < dim; d++) {
    char name[16];

    snprintf(name, sizeof name, "offset_%d", d);
    offset[d]   = NUMBER(name);
    b->nodes[d] = COUNT("grid") + 1;
    b->n *= side;
    all *= b->nodes[d];
  }
  if (dim == 2) b->nodes[2] = 1;
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
  b->sums   = Numbers(8 * all);
  b->motion = Numbers(2 * dim * all);
  b->base   = (long *)Numbers(b->n);
  b->end    = Counts(b->n);
  b->cell   = Counts(room);
  b->place  = Counts(b->n);
  b->count  = Counts(all + 1);
  for (long p = 0; p < room; p++) {
    long rest = p < b->n ? p : b->n - 1; /* the places after the last particle have copies of it */

    for (int d = 0; d < dim; d++, rest /= side) {
      b->x[d][p] = start + offset[d] + (double)(rest % side + 0.5) / ppa;
      b->v[d][p] = drift;
    }
    b->v[0][p] += b->x[0][p] < start + offset[0] + 0.5 * cells ? half : -half;
    for (int d = 0; d < dim; d++) b->F[d * (dim + 1)][p] = 1;
  }
}

/* Prints mass, momentum and energies of the particles, which bench.py compares with Pebble's. */
static void PrintTotals(int dim, const Body *b)
{
  double momentum[3] = {0}, kinetic = 0, strain = 0;

  for (long p = 0; p < b->n; p++) {
    double trace = 3 - dim, lnJ;
    double F[9];

    for (int c = 0; c < dim * dim; c++) F[c] = b->F[c][p], trace += F[c] * F[c];
    lnJ = dim == 2 ? log(F[0] * F[3] - F[1] * F[2])
                   : log(F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) +
                         F[2] * (F[3] * F[7] - F[4] * F[6]));
    strain += b->V0 * (0.5 * b->mu * (trace - 3 - 2 * lnJ) + 0.5 * b->lambda * lnJ * lnJ);
    for (int d = 0; d < dim; d++) {
      momentum[d] += b->m * b->v[d][p];
      kinetic += 0.5 * b->m * b->v[d][p] * b->v[d][p];
    }
  }
  printf("particles %ld\nmass %.17g\nmomentum %.17g %.17g %.17g\nkinetic %.17g\nstrain %.17g\n", b->n,
         (double)b->n * b->m, momentum[0], momentum[1], momentum[2], kinetic, strain);
}

int main(int argc, char **argv)
{
  static Body       b;
  const int         dim = COUNT("dim"), steps = COUNT("steps");
  const char *const basis  = Text(argc, argv, "basis");
  void (*run)(Body *, int) = NULL;

#define CHOOSE(d, name)                                                                                                \
  if (dim == d && !strcmp(basis, #name)) run = Run_##d##_##name;
  METHODS(CHOOSE)
  if (!run) FAIL("no method has dim=%d basis=%s", dim, basis);
  Fill(argc, argv, dim, &b);
  run(&b, steps);
  PrintTotals(dim, &b);
  {
    const double ns = 1e9 / (double)b.n, *s = b.least;

    printf("ns per particle-step %.5g (least of P2G %.4g, nodes %.4g, G2P %.4g)\n", ns * b.seconds / steps, ns * s[0],
           ns * s[1], ns * s[2]);
  }
  return 0;
}
