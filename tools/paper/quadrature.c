/* quadrature.c - a program of its own that measures the error of the internal force of a node, a sum over particles,
   with the program's basis functions (basis.h), in 1-D, for a stress of 1 in a bar that fills its grid: the exact force
   inside is 0. Steffen, Kirby and Berzins (2008) study this sum; docs/paper.md reports the results.

   usage: quadrature force | jumps | worst      CSV on standard output; lengths in cells, so that r = 1/b

   The sum is the midpoint rule on voxels of width b that fill the bar: f_i = sum V_p phi_i'(x_p). A basis of degree k
   has breaks, where phi^(k) jumps by J. The error of the rule comes from the breaks alone:
     one voxel, its centre d voxels from a break:   J b^k (1/2 - |d|)^k/k!     (but for a sign and a term that cancels)
     equal voxels, all breaks:                      f_i = -b^k sum_j J_j B_k(t_j)/k!
   with the Bernoulli polynomials B_k, and t_j the distance from break j to the next centre, in voxels. */
#include "physics/basis.h"

#include <math.h>
#include <stdio.h>

#define CELLS  64
#define EDGE   4  /* nodes nearer to a wall are not inside: their functions are cut there */
#define PHASES 23 /* shifts of the voxels, in 23rds of a voxel */

static const double per_cell[] = {1.37, 2.37, 4.37, 8.37, 16.37, 32.37};

/* A basis that is examined. */
typedef struct {
  const char *name;
  MPMBasis    basis;
  int         degree;  /* 0: the theory does not apply */
  double      first;   /* position of the first break, from the node */
  PetscBool   stretch; /* are GIMP's domains as wide as the mapped voxels, or as at the start? */
} Method;

static const Method methods[] = {
    {"linear", MPM_BASIS_linear, 1, -1, PETSC_FALSE},     {"bspline2", MPM_BASIS_bspline2, 2, -1.5, PETSC_FALSE},
    {"bspline3", MPM_BASIS_bspline3, 3, -2, PETSC_FALSE}, {"ugimp", MPM_BASIS_gimp, 0, 0, PETSC_FALSE},
    {"cpgimp", MPM_BASIS_gimp, 0, 0, PETSC_TRUE},
};

#define METHODS ((int)(sizeof methods / sizeof methods[0]))
#define RATIOS  ((int)(sizeof per_cell / sizeof per_cell[0]))

/* Sets phi_i and its slope at x cells from a node i that lies far inside. */
static void Function(MPMBasis basis, double x, double *value, double *slope)
{
  PetscReal      xi   = CELLS / 2 + x, w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];
  const PetscInt base = MPMBasisBase(basis, &xi, 0.25, CELLS, PETSC_FALSE, MPM_WALL_BASIS_EXTRAP);
  const PetscInt k    = CELLS / 2 - base;

  *value = *slope = 0;
  if (k < 0 || k >= MPMBasisNodes(basis)) return;
  MPMBasisWeights(basis, xi, 0.25, base, CELLS, MPM_WALL_BASIS_EXTRAP, w, g);
  *value = w[k];
  *slope = g[k];
}

static double Slope(MPMBasis basis, double x)
{
  double value, slope;

  Function(basis, x, &value, &slope);
  return slope;
}

/* Returns phi^(degree) between x and x + 1, where it is constant, by a difference of slopes. */
static double Top(const Method *m, double x)
{
  if (m->degree == 1) return Slope(m->basis, x + 0.5);
  if (m->degree == 2) return (Slope(m->basis, x + 0.75) - Slope(m->basis, x + 0.25)) / 0.5;
  return (Slope(m->basis, x + 0.75) - 2 * Slope(m->basis, x + 0.5) + Slope(m->basis, x + 0.25)) / 0.0625;
}

/* Returns the jump of phi^(degree) at break j = 0 .. degree + 1. */
static double Jump(const Method *m, int j)
{
  return Top(m, m->first + j) - Top(m, m->first + j - 1);
}

/* B_k(t)/k! */
static double Bernoulli(int k, double t)
{
  if (k == 1) return t - 0.5;
  if (k == 2) return ((t - 1) * t + 1. / 6) / 2;
  return ((t - 1.5) * t + 0.5) * t / 6;
}

/* Returns the force that the theory gives for a node and equal voxels with centres at (n + centre) b from it. */
static double Theory(const Method *m, double r, double centre)
{
  double f = 0;

  for (int j = 0; j <= m->degree + 1; j++) {
    const double t = centre - (m->first + j) * r;

    f -= Jump(m, j) * Bernoulli(m->degree, t - floor(t)) / pow(r, m->degree);
  }
  return f;
}

/* Returns whether the centre of a voxel lies on a break of the linear basis: which of the two slopes it gets there is a
   matter of rounding, so theory and sum are not compared. */
static PetscBool Tied(const Method *m, double r, double centre)
{
  PetscBool tied = PETSC_FALSE;

  for (int j = 0; m->degree == 1 && j < 3; j++) {
    const double t = centre - (m->first + j) * r;

    if (fabs(t - rint(t)) < 1e-9) tied = PETSC_TRUE;
  }
  return tied;
}

/* Maps a position so that voxels get very different widths: F is between 0.69 and 1.31. */
static double Map(double x, PetscBool mapped)
{
  return mapped ? x + CELLS * 0.05 * sin(2 * PETSC_PI * x / CELLS) : x;
}

/* Sets *largest to the largest force on a node inside over all shifts of the voxels, and *differs to the largest
   difference from the theory, for equal voxels. */
static void Force(const Method *m, double r, PetscBool mapped, double *largest, double *differs)
{
  *largest = *differs = 0;
  for (int phase = 0; phase < PHASES; phase++) {
    const double shift        = (double)phase / PHASES;
    double       f[CELLS + 3] = {0}; /* nodes -1 .. CELLS + 1 */

    for (long n = 0;; n++) {
      const double start = ((double)n + shift) / r, end = ((double)n + 1 + shift) / r;
      const double from = Map(start, mapped), to = Map(end, mapped);
      const double l  = 0.5 * (m->stretch ? to - from : 1 / r);
      PetscReal    xi = 0.5 * (from + to), w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];
      PetscInt     base;

      if (end > CELLS) break;
      base = MPMBasisBase(m->basis, &xi, l, CELLS, PETSC_FALSE, MPM_WALL_BASIS_EXTRAP);
      MPMBasisWeights(m->basis, xi, l, base, CELLS, MPM_WALL_BASIS_EXTRAP, w, g);
      for (int k = 0; k < MPMBasisNodes(m->basis); k++) f[base + k + 1] += (to - from) * g[k];
    }
    for (int i = EDGE; i <= CELLS - EDGE; i++) {
      const double centre = shift + 0.5 - i * r;

      *largest = fmax(*largest, fabs(f[i + 1]));
      if (!m->degree || mapped || Tied(m, r, centre)) continue;
      *differs = fmax(*differs, fabs(f[i + 1] - Theory(m, r, centre)));
    }
  }
}

static void Forces(void)
{
  puts("voxels,basis,r,force,theory_differs");
  for (int mapped = 0; mapped < 2; mapped++) {
    for (int k = 0; k < METHODS; k++) {
      for (int i = 0; i < RATIOS; i++) {
        double largest, differs;

        Force(&methods[k], per_cell[i], mapped ? PETSC_TRUE : PETSC_FALSE, &largest, &differs);
        printf("%s,%s,%g,%.6e,", mapped ? "mapped" : "equal", methods[k].name, per_cell[i], largest);
        if (methods[k].degree && !mapped) printf("%.1e", differs);
        puts("");
      }
    }
  }
}

/* Returns the largest error of a voxel that break j cuts, over all positions of its centre, without b^3/24 phi''',
   which is the error of an uncut voxel on the side of the centre. */
static double Cut(const Method *m, int j, double b)
{
  double largest = 0;

  for (int n = -500; n <= 500; n++) {
    const double d = n == 0 ? 1e-7 : n / 1000., x = m->first + j + d * b;
    double       slope, value, low, high, error;

    Function(m->basis, x, &value, &slope);
    Function(m->basis, x - b / 2, &low, &value);
    Function(m->basis, x + b / 2, &high, &value);
    error = b * slope - (high - low);
    if (m->degree == 3) error += b * b * b / 24 * Top(m, m->first + j - (d < 0));
    largest = fmax(largest, fabs(error));
  }
  return largest;
}

static void Jumps(void)
{
  const double factorial[] = {1, 1, 2, 6};

  puts("basis,degree,break,jump,r,error,coefficient,theory");
  for (int k = 0; k < METHODS; k++) {
    const Method *m = &methods[k];

    for (int j = 0; m->degree && j <= m->degree + 1; j++) {
      const double jump = Jump(m, j);

      for (int i = 1; i < RATIOS; i++) { /* from i = 1 on a voxel has at most one break */
        const double r = per_cell[i], error = Cut(m, j, 1 / r);

        printf("%s,%d,%g,%.6f,%g,%.6e,%.6f,%.6f\n", m->name, m->degree, m->first + j, jump, r, error,
               error * pow(r, m->degree) / fabs(jump), pow(0.5, m->degree) / factorial[m->degree]);
      }
    }
  }
}

/* Prints the largest f r^k over all shifts of equal voxels, by the theory: for a whole r, for an r with the fraction
   0.37 of the table, and for the worst fraction of r. */
static void Worst(void)
{
  puts("basis,degree,fraction,coefficient");
  for (int k = 0; k < METHODS; k++) {
    const Method *m     = &methods[k];
    double        worst = 0, at = 0;

    if (!m->degree) continue;
    for (int i = 0; i <= 102; i++) { /* fractions 0, 0.01, ... 1; then 0.37 and the worst one */
      const double fraction = i <= 100 ? i / 100. : i == 101 ? 0.37 : at;
      double       largest  = 0;

      for (int phase = 0; phase < 2000; phase++) {
        const double r = 1 + fraction;

        largest = fmax(largest, fabs(Theory(m, r, phase / 2000. + 1e-9)) * pow(r, m->degree));
      }
      if (largest > worst) worst = largest, at = fraction;
      if (i == 0 || i > 100) printf("%s,%d,%g,%.6f\n", m->name, m->degree, fraction, largest);
    }
  }
}

int main(int argc, char *argv[])
{
  if (argc == 2 && strcmp(argv[1], "force") == 0)
    Forces();
  else if (argc == 2 && strcmp(argv[1], "jumps") == 0)
    Jumps();
  else if (argc == 2 && strcmp(argv[1], "worst") == 0)
    Worst();
  else {
    fprintf(stderr, "usage: %s force | jumps | worst\n", argv[0]);
    return 2;
  }
  return 0;
}
