/* unit_basis.c - properties that every row of basis.def must have, on grids of 1 to 1e9 cells.                        */
#include "mpm.h"
#include "unit.h"

static const PetscInt cells_of[] = {1, 2, 3, 5, 49, 1000, 1000003, 1000000000};
static const char    *names[]    = {
#define MPM_BASIS(name, nodes, layers, inertia, what) #name,
#include "basis.def"
#undef MPM_BASIS
};

typedef struct {
  PetscInt  base;
  PetscReal w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];
} Stencil;

static Stencil At(MPMBasis basis, PetscReal xi, PetscInt cells)
{
  Stencil s;

  memset(&s, 0, sizeof s);
  s.base = MPMBasisBase(basis, xi, cells);
  MPMBasisWeights(basis, xi, s.base, cells, s.w, s.g);
  return s;
}

/* Weight of a node, whatever the base: zero outside of the stencil. */
static PetscReal Weight(const Stencil *s, PetscInt node)
{
  return node >= s->base && node < s->base + MPM_MAX_STENCIL ? s->w[node - s->base] : 0;
}

/* What holds at every position. */
static void Everywhere(MPMBasis basis, PetscReal xi, PetscInt cells)
{
  const int     nodes = MPMBasisNodes(basis);
  const Stencil s     = At(basis, xi, cells);
  PetscReal     w = 0, g = 0, xw = 0, xg = 0;

  UnitContext("%s, %ld cells, xi = %.17g", names[basis], (long)cells, xi);
  CHECK_GE(s.base, -MPMBasisLayers(basis)); /* the stencil stays on the grid and its layers */
  CHECK_LE(s.base + nodes - 1, cells + MPMBasisLayers(basis));
  for (int i = 0; i < nodes; i++) {
    w += s.w[i];
    g += s.g[i];
    xw += s.w[i] * ((PetscReal)(s.base + i) - xi); /* moments about xi, so that no digits are lost */
    xg += s.g[i] * ((PetscReal)(s.base + i) - xi);
    CHECK_GE(s.w[i], 0); /* a mass is never negative: a basis that breaks this needs a column in basis.def that says so */
    CHECK_LE(s.w[i], 1);
  }
  CHECK_NEAR(w, 1, 4 * DBL_EPSILON);
  CHECK_NEAR(g, 0, 8 * DBL_EPSILON);
  CHECK_NEAR(xw, 0, 8 * DBL_EPSILON);
  CHECK_NEAR(xg, 1, 8 * DBL_EPSILON);
}

/* Near a node the weights of any node change by no more than the slope times the distance, cell border or not. */
static void Continuity(MPMBasis basis, PetscInt node, PetscInt cells)
{
  const Stencil at = At(basis, node, cells);

  for (int k = -3; k <= 3; k++) {
    const PetscReal xi = UnitStep(node, k), distance = PetscAbsReal(xi - node);
    Stencil         s;

    if (xi < 0 || xi > cells) continue;
    Everywhere(basis, xi, cells);
    s = At(basis, xi, cells);
    for (PetscInt i = node - MPM_MAX_STENCIL; i <= node + MPM_MAX_STENCIL; i++)
      CHECK_NEAR(Weight(&s, i), Weight(&at, i), 2 * distance + 2 * DBL_EPSILON);
  }
}

/* Both walls: a point on the wall has the base of the points just inside, on the upper wall too. */
static void Walls(MPMBasis basis, PetscInt cells)
{
  UnitContext("%s, %ld cells, walls", names[basis], (long)cells);
  CHECK_EQ(MPMBasisBase(basis, cells, cells), MPMBasisBase(basis, UnitStep(cells, -1), cells));
  CHECK_EQ(MPMBasisBase(basis, 0, cells), MPMBasisBase(basis, UnitStep(0, 1), cells));
  CHECK_EQ(MPMBasisBase(basis, -0.0, cells), MPMBasisBase(basis, 0, cells));
  Everywhere(basis, -0.0, cells);
}

/* g is the derivative of w, away from the borders of the pieces (multiples of 1/8 cover all splines' and gimp's). */
static void Derivative(MPMBasis basis, PetscReal xi, PetscInt cells)
{
  const PetscReal h = 1e-4, part = 8 * xi - PetscFloorReal(8 * xi);
  Stencil         lo, mid, hi;

  if (part < 0.01 || part > 0.99 || cells > 100000) return;
  lo  = At(basis, xi - h, cells);
  mid = At(basis, xi, cells);
  hi  = At(basis, xi + h, cells);
  UnitContext("%s, %ld cells, xi = %.17g, derivative", names[basis], (long)cells, xi);
  for (int i = 0; i < MPMBasisNodes(basis); i++)
    CHECK_NEAR((Weight(&hi, mid.base + i) - Weight(&lo, mid.base + i)) / (2 * h), mid.g[i], 1e-7);
}

int main(void)
{
  for (int b = 0; b < MPM_NUM_BASES; b++) {
    const MPMBasis basis = (MPMBasis)b;

    UnitContext("%s", names[b]);
    CHECK_LE(MPMBasisNodes(basis), MPM_MAX_STENCIL);
    for (size_t c = 0; c < sizeof cells_of / sizeof cells_of[0]; c++) {
      const PetscInt cells = cells_of[c];

      Walls(basis, cells);
      for (PetscInt k = 0; k <= PetscMin(cells, 50); k++) {
        Continuity(basis, k, cells);
        Continuity(basis, cells - k, cells);
      }
      for (int k = 0; k < 2000; k++) {
        const PetscReal xi = UnitReal(0, cells);

        Everywhere(basis, xi, cells);
        Derivative(basis, xi, cells);
        Continuity(basis, (PetscInt)xi, cells);
      }
    }
  }
  return UnitEnd();
}
