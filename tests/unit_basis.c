/* unit_basis.c - every row of basis.def, in every form at walls, against definitions of its own in long double (Cox and
   de Boor's recursion, elimination of the node beyond the wall, means of hats), and the properties that follow: unity,
   integrals, linear completeness, slopes, smoothness, mirror images, what a wall sees; on grids of up to 1e9 cells. */
#include "physics/grid.h"
#include "unit.h"

static const PetscInt  cells_of[] = {1, 2, 3, 4, 5, 6, 49, 1000, 1000003, 1000000000};
static const PetscReal widths[]   = {1. / 128, 1. / 32, 0.1, 1. / 6, 0.25, 0.49, 0.5};
static const char     *names[]    = {
#define MPM_BASIS(name, nodes, layers, inertia, what) #name,
#include "physics/basis.def"
};
static const char *const forms[] = {"periodic", "extrap", "steffen"};

/* A basis as a grid has it. */
typedef struct {
  MPMBasis     basis;
  MPMWallBasis wall; /* none: periodic */
  PetscReal    l;
  PetscInt     cells;
} Case;

typedef struct {
  PetscInt  base;
  PetscReal xi, w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];
} Stencil;

static Stencil At(const Case *c, PetscReal xi)
{
  Stencil s;

  memset(&s, 0, sizeof s);
  s.xi   = xi;
  s.base = MPMBasisBase(c->basis, &s.xi, c->l, c->cells, c->wall == MPM_WALL_BASIS_NONE, c->wall);
  MPMBasisWeights(c->basis, s.xi, c->l, s.base, c->cells, c->wall, s.w, s.g);
  return s;
}

static void Context(const Case *c, PetscReal xi, const char *what)
{
  UnitContext("%s %s, l = %g, %ld cells, xi = %.17g%s", names[c->basis], forms[c->wall], c->l, (long)c->cells, xi,
              what);
}

/* Weight and slope at a node, whatever the base: zero outside of the stencil. On a periodic axis the sum of the images.
 */
static PetscReal Weight(const Case *c, const Stencil *s, PetscInt node, PetscReal *slope)
{
  PetscReal w = 0;

  *slope = 0;
  for (int i = 0; i < MPMBasisNodes(c->basis); i++) {
    const PetscInt at = s->base + i;

    if (at != node && (c->wall != MPM_WALL_BASIS_NONE || (at - node) % c->cells)) continue;
    w += s->w[i];
    *slope += s->g[i];
  }
  return w;
}

/* ---- Definitions */

/* B-spline i of a degree over these knots (Cox, de Boor). Half-open; the last knot belongs to the last piece. */
static long double Spline(const long double *knots, int n, int i, int degree, long double x)
{
  const long double a = knots[i + degree] - knots[i], b = knots[i + degree + 1] - knots[i + 1];

  if (degree == 0)
    return knots[i] < knots[i + 1] && ((x >= knots[i] && x < knots[i + 1]) || (x == knots[n - 1] && knots[i + 1] == x));
  return (a > 0 ? (x - knots[i]) / a * Spline(knots, n, i, degree - 1, x) : 0) +
         (b > 0 ? (knots[i + degree + 1] - x) / b * Spline(knots, n, i + 1, degree - 1, x) : 0);
}

/* The uniform spline about 0, of width degree + 1. */
static long double Uniform(int degree, long double x)
{
  long double knots[5];

  for (int k = 0; k <= degree + 1; k++) knots[k] = k - 0.5L * (degree + 1);
  return x < knots[degree + 1] ? Spline(knots, degree + 2, 0, degree, x) : 0;
}

/* Integral of the hat from -infinity to x. */
static long double HatIntegral(long double x)
{
  return x < -1 ? 0 : x < 0 ? 0.5L * (1 + x) * (1 + x) : x < 1 ? 1 - 0.5L * (1 - x) * (1 - x) : 1;
}

/* The weight of a node at xi, as the basis is defined. For few cells with walls. */
static long double Defined(const Case *c, PetscInt node, long double xi)
{
  const int degree = c->basis == MPM_BASIS_bspline3 ? 3 : c->basis == MPM_BASIS_bspline2 ? 2 : 1;
  const int n      = (int)c->cells;

  if (c->wall == MPM_WALL_BASIS_NONE) { /* all images */
    long double sum = 0;
    for (int k = -2; k <= 2; k++) {
      const long double x = xi - (long double)(node + k * n);
      sum += c->basis == MPM_BASIS_gimp ? (HatIntegral(x + c->l) - HatIntegral(x - c->l)) / (2 * (long double)c->l)
                                        : Uniform(degree, x);
    }
    return sum;
  }
  if (c->basis == MPM_BASIS_gimp)
    return (HatIntegral(xi + c->l - node) - HatIntegral(xi - c->l - node)) / (2 * (long double)c->l);
  if (node < 0 || node > n) return 0;
  if (degree == 1) return Uniform(1, xi - node);
  if (c->wall == MPM_WALL_BASIS_EXTRAP)
    return Uniform(degree, xi - node) +
           (node == 0   ? 2
            : node == 1 ? -1
                        : 0) *
               Uniform(degree, xi + 1) +
           (node == n       ? 2
            : node == n - 1 ? -1
                            : 0) *
               Uniform(degree, xi - (n + 1));
  {
    long double knots[80], sum = 0;
    int         m = 0;

    for (int k = 0; k <= degree; k++) knots[m++] = 0;
    for (int k = 0; k < n; k++)
      if (degree == 2 || k) knots[m++] = k + (degree == 2 ? 0.5L : 0);
    for (int k = 0; k <= degree; k++) knots[m++] = n;
    CHECK_EQ(m - degree - 1, n + 3); /* functions: two more than nodes */
    for (int f = 0; f < n + 3; f++)
      if ((f < 2 ? 0 : f > n ? n : f - 1) == node) sum += Spline(knots, m, f, degree, xi);
    return sum;
  }
}

/* Weights are as defined, slopes are the derivatives of that. */
static void Definition(const Case *c, PetscReal xi)
{
  const long double step   = 1e-6L;
  const Stencil     s      = At(c, xi);
  const int         layers = MPMBasisLayers(c->basis);
  int               kink   = xi < 1e-5 || xi > (PetscReal)c->cells - 1e-5;

  for (int k = -1; k <= 1; k++) { /* borders of the pieces: halves, and edges of the domain on nodes */
    const PetscReal part = 2 * (xi + k * c->l) - PetscFloorReal(2 * (xi + k * c->l));
    kink |= part < 1e-5 || part > 1 - 1e-5;
  }
  Context(c, xi, ", definition");
  for (PetscInt node = c->wall == MPM_WALL_BASIS_NONE ? 0 : -layers;
       node <= c->cells + layers - (c->wall == MPM_WALL_BASIS_NONE); node++) {
    PetscReal       slope;
    const PetscReal w = Weight(c, &s, node, &slope);

    CHECK_NEAR(w, Defined(c, node, xi), 2e-15 * c->cells);
    if (!kink)
      CHECK_NEAR(slope, (Defined(c, node, xi + step) - Defined(c, node, xi - step)) / (2 * step), 1e-10 + 1e-13 / c->l);
  }
}

/* ---- Properties */

/* Does the basis reproduce linear fields here? */
static int Linear(const Case *c, PetscReal xi)
{
  const PetscReal reach = c->basis == MPM_BASIS_bspline2 ? 1.5 : 2;

  return c->wall != MPM_WALL_BASIS_STEFFEN || !MPMBasisIsSpline(c->basis) ||
         (xi >= reach && xi <= (PetscReal)c->cells - reach);
}

/* What holds at every position. */
static void Everywhere(const Case *c, PetscReal xi)
{
  const int       nodes = MPMBasisNodes(c->basis), layers = MPMBasisLayers(c->basis);
  const Stencil   s     = At(c, xi);
  const PetscReal far   = c->basis == MPM_BASIS_gimp ? DBL_EPSILON * (PetscReal)c->cells : 0; /* xi - l is rounded */
  const PetscReal steep = c->basis == MPM_BASIS_gimp ? (DBL_EPSILON + far) / c->l : 0;
  PetscReal       w = 0, g = 0, xw = 0, xg = 0;

  Context(c, xi, "");
  if (c->wall == MPM_WALL_BASIS_NONE) {
    CHECK(s.base >= 0 && s.base < c->cells);
    CHECK(s.xi == xi || s.xi == xi + (PetscReal)c->cells);
  } else {
    CHECK_EQ(s.xi, xi);
    CHECK_GE(s.base, -layers); /* the stencil stays on the grid and its layers */
    CHECK_LE(s.base + nodes - 1, c->cells + layers);
  }
  for (int i = 0; i < nodes; i++) {
    w += s.w[i];
    g += s.g[i];
    xw += s.w[i] * ((PetscReal)(s.base + i) - s.xi); /* moments about xi, so that no digits are lost */
    xg += s.g[i] * ((PetscReal)(s.base + i) - s.xi);
    CHECK_GE(s.w[i], 0); /* a mass is never negative */
    CHECK_LE(s.w[i], 1);
  }
  CHECK_NEAR(w, 1, 6 * DBL_EPSILON + far * steep);
  CHECK_NEAR(g, 0, 12 * DBL_EPSILON + 2 * steep);
  if (!Linear(c, xi)) return;
  CHECK_NEAR(xw, 0, 12 * DBL_EPSILON + far * steep);
  CHECK_NEAR(xg, 1, 16 * DBL_EPSILON + 4 * steep);
}

/* About a border of pieces the weight of every node changes by no more than its slope times the distance; the slopes of
   all bases but the hats by no more than the curvature times it. */
static void Continuity(const Case *c, PetscReal border)
{
  const PetscReal bend = c->basis == MPM_BASIS_gimp ? 1 / c->l : 3;
  const Stencil   at   = At(c, border);

  for (int k = -3; k <= 3; k++) {
    const PetscReal xi = UnitStep(border, k), distance = PetscAbsReal(xi - border);
    Stencil         s;

    if (xi < 0 || xi > (PetscReal)c->cells || (c->wall == MPM_WALL_BASIS_NONE && xi >= (PetscReal)c->cells)) continue;
    Everywhere(c, xi);
    s = At(c, xi);
    Context(c, xi, ", continuity");
    for (PetscInt i = (PetscInt)border - 5; i <= (PetscInt)border + 5; i++) {
      PetscReal       g, g0;
      const PetscReal w = Weight(c, &s, i, &g), w0 = Weight(c, &at, i, &g0);

      /* A wrap adds the number of cells to xi, which rounds it. */
      CHECK_NEAR(w, w0,
                 2 * distance + 4 * DBL_EPSILON +
                     (c->wall == MPM_WALL_BASIS_NONE || c->basis == MPM_BASIS_gimp
                          ? 2 * DBL_EPSILON * (PetscReal)c->cells
                          : 0));
      if (c->basis != MPM_BASIS_linear)
        CHECK_NEAR(g, g0,
                   bend * (2 * distance + 4 * DBL_EPSILON +
                           (c->wall == MPM_WALL_BASIS_NONE || c->basis == MPM_BASIS_gimp
                                ? 2 * DBL_EPSILON * (PetscReal)c->cells
                                : 0)));
    }
  }
}

/* The same seen from the other end: the same bits, but for cubic splines on a node, whose two pieces there differ by
   rounding. xi is a multiple of 2^-20, so that cells - xi is exact. */
static void Mirror(const Case *c, PetscReal xi)
{
  const Stencil a = At(c, xi), b = At(c, (PetscReal)c->cells - xi);
  const int     exact = c->basis != MPM_BASIS_bspline3 || xi != PetscFloorReal(xi);

  Context(c, xi, ", mirror");
  if (c->wall == MPM_WALL_BASIS_NONE && xi == 0) return; /* the other end is no place of its own */
  if (c->basis == MPM_BASIS_linear && xi == PetscFloorReal(xi))
    return; /* a node's slope is that of the cell above it */
  for (int i = 0; i < MPMBasisNodes(c->basis); i++) {
    PetscReal       slope;
    const PetscReal w = Weight(c, &b, c->cells - (a.base + i), &slope);

    CHECK_NEAR(w, a.w[i], exact ? 0 : DBL_EPSILON);
    CHECK_NEAR(slope, -a.g[i], exact ? 0 : 2 * DBL_EPSILON);
  }
}

/* Both walls: a particle on the wall has the base of the particles just inside, on the upper wall too. */
static void Walls(const Case *c)
{
  const PetscReal top = (PetscReal)c->cells;
  PetscReal       slope;

  Context(c, 0, ", walls");
  CHECK_EQ(At(c, -0.0).base, At(c, 0).base);
  Everywhere(c, -0.0);
  if (c->wall == MPM_WALL_BASIS_NONE) return;
  CHECK_EQ(At(c, top).base, At(c, UnitStep(top, -1)).base);
  CHECK_EQ(At(c, 0).base, At(c, UnitStep(0, 1)).base);
  for (int side = 0; side < 2 && c->basis != MPM_BASIS_gimp;
       side++) { /* only the node at the wall sees a particle there */
    const Stencil s = At(c, side ? top : 0);

    CHECK_EQ(Weight(c, &s, side ? c->cells : 0, &slope), 1);
    for (int i = 0; i < MPMBasisNodes(c->basis); i++) {
      CHECK_EQ(s.w[i], s.base + i == (side ? c->cells : 0) ? 1 : 0);
      if (MPMBasisIsSpline(c->basis) && c->wall == MPM_WALL_BASIS_STEFFEN) CHECK_EQ(s.g[i], 0);
    }
  }
}

/* A period further the same bits, on the nodes a period further; the same in any cell. */
static void Wrap(const Case *c, PetscReal xi)
{
  const PetscInt k = 1 + UnitInt((int)c->cells - 1);
  const Stencil  a = At(c, xi),
                b = At(c, xi + (PetscReal)k < (PetscReal)c->cells ? xi + (PetscReal)k : xi + (PetscReal)(k - c->cells));

  Context(c, xi, ", wrap");
  for (PetscInt i = 0; i < c->cells; i++) {
    PetscReal       ga, gb;
    const PetscReal wa = Weight(c, &a, i, &ga), wb = Weight(c, &b, (i + k) % c->cells, &gb);

    CHECK_EQ(wa, wb);
    CHECK_EQ(ga, gb);
  }
}

/* gimp whose domain is a cell is the quadratic spline away from walls. */
static void WideGimp(PetscInt cells, PetscReal xi)
{
  const Case g    = {MPM_BASIS_gimp, MPM_WALL_BASIS_NONE, 0.5, cells},
             q    = {MPM_BASIS_bspline2, MPM_WALL_BASIS_NONE, 0, cells};
  const Stencil a = At(&g, xi), b = At(&q, xi);

  Context(&g, xi, ", against bspline2");
  CHECK_EQ(a.base, b.base);
  for (int i = 0; i < 3; i++) {
    CHECK_NEAR(a.w[i], b.w[i], 4 * DBL_EPSILON);
    CHECK_NEAR(a.g[i], b.g[i], 8 * DBL_EPSILON);
  }
}

static void Test(const Case *c)
{
  Walls(c);
  for (PetscInt k = 0; k <= PetscMin(c->cells, 50); k++)
    for (int part = 0; part < 5; part++) { /* nodes, middles of cells, edges of domains on nodes */
      const PetscReal at = part == 0 ? 0 : part == 1 ? 0.5 : part == 2 ? c->l : part == 3 ? -c->l : 0.5 - c->l;
      const PetscReal lo = (PetscReal)k + at, hi = (PetscReal)(c->cells - k) + at;

      if (lo >= 0 && lo <= (PetscReal)c->cells) Continuity(c, lo);
      if (hi >= 0 && hi <= (PetscReal)c->cells) Continuity(c, hi);
    }
  for (int k = 0; k < 400; k++) {
    const PetscReal xi   = UnitReal(0, (PetscReal)c->cells);
    const PetscReal tidy = PetscFloorReal(xi * (k % 4 ? 1048576 : 8)) / (k % 4 ? 1048576 : 8);

    Everywhere(c, xi);
    Continuity(c, PetscFloorReal(xi));
    if (c->cells <= 1000003) Mirror(c, tidy);
    if (c->cells > 49) continue;
    Definition(c, xi);
    Definition(c, tidy);
    if (c->wall == MPM_WALL_BASIS_NONE) Wrap(c, tidy);
  }
}

/* The integral of each node's function over the grid: of pieces that are polynomials, each by Simpson's rule; of gimp,
   over domains that fill the grid. */
static void Integrals(const Case *c)
{
  const PetscInt per = c->basis == MPM_BASIS_gimp ? (PetscInt)(0.5 / c->l + 0.5) : 2, n = per * c->cells;
  PetscReal      all = 0, slope;

  if (c->wall == MPM_WALL_BASIS_NONE || c->cells > 6) return;
  if (c->basis == MPM_BASIS_gimp && fabs(per * 2 * c->l - 1) > 1e-12) return;
  for (PetscInt node = -1; node <= c->cells + 1; node++) {
    const PetscReal exact = MPMBasisIntegral(c->basis, node, c->cells, c->wall);
    PetscReal       sum   = 0;

    for (PetscInt k = 0; k < n; k++)
      for (int q = c->basis == MPM_BASIS_gimp ? 1 : 0; q < (c->basis == MPM_BASIS_gimp ? 2 : 3); q++) {
        const PetscReal inside = q == 0 ? 1e-9 : q == 2 ? 1 - 1e-9 : 0.5; /* on this side of the piece's end */
        const Stencil   s      = At(c, ((PetscReal)k + inside) / (PetscReal)per);

        sum += Weight(c, &s, node, &slope) *
               (c->basis == MPM_BASIS_gimp ? 1
                : q == 1                   ? 4. / 6
                                           : 1. / 6) /
               (PetscReal)per;
      }
    Context(c, (PetscReal)node, ": its integral");
    CHECK_NEAR(sum, exact, 1e-8);
    all += exact;
  }
  CHECK_NEAR(all, (PetscReal)c->cells, 1e-14);
}

int main(void)
{
  for (int b = 0; b < MPM_NUM_BASES; b++)
    for (int wall = 0; wall < 3; wall++)
      for (size_t k = 0; k < sizeof cells_of / sizeof cells_of[0]; k++)
        for (size_t l = 0; l < sizeof widths / sizeof widths[0]; l++) {
          const Case c  = {(MPMBasis)b, (MPMWallBasis)wall, b == MPM_BASIS_gimp ? widths[l] : 0, cells_of[k]};
          const int  ns = MPMBasisNodes(c.basis);

          CHECK_LE(ns, MPM_MAX_STENCIL);
          if ((b != MPM_BASIS_gimp && l) || (!MPMBasisIsSpline(c.basis) && wall == 2)) continue;
          if (c.cells < ns && (wall == 0 || MPMBasisIsSpline(c.basis))) continue; /* refused */
          Test(&c);
          Integrals(&c);
        }
  for (int k = 0; k < 20000; k++) WideGimp(1 + UnitInt(60) + 3, k % 3 ? UnitReal(0, 4) : UnitInt(32) / 8.);
  return UnitEnd();
}
