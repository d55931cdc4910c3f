/* at_walls.c - particles of a lattice that start beside walls.

   With splines the node next to a wall has no weight at the wall but a slope: the pressure of a particle that lies on
   the wall pushes a node to which it gives no mass. Where matter flows, a particle may be left alone there, so it
   starts a part of its spacing inside.

   The particles of a body of revolution have the mass of the circle on which they are, so there is a kind for each
   column of its lattice. Where the lattice leaves a gap between a wall and their domains, their stress acts in all of
   the volume up to the wall. */
#include "base/algebra.h"
#include "kernels/cell.h"
#include "scene/at_walls.h"
#include "scene/lattice.h"

#define ON_WALL   1e-3 /* of the spacing: what is nearer to a wall starts on it, and is moved inside by OFF_WALL */
#define OFF_WALL  0.1
#define SAME      1e-9 /* of the volume */
#define COLUMN    MPM_AT_WALLS_COLUMN
#define NEAR_AXIS 3               /* cells from the axis within which volumes are chosen for it */
#define NODES     (NEAR_AXIS + 2) /* at the nodes that have particles there */

/* Returns whether a body flows, so that none of its particles may start on a wall. */
static PetscBool Flows(const MPMScene *scene, const MPMCore *core, const MPMBody *b)
{
  const PetscInt traits = scene->materials[b->material].type->traits;

  return MPMBasisIsSpline(core->basis) && traits & (MPM_PLASTIC | MPM_FLUID);
}

/* Returns how far x, m, is inside a face of axis d, over the spacing of the body. */
static PetscReal Inside(const MPMGrid *grid, const MPMBody *b, PetscInt d, int side, PetscReal x)
{
  return (side ? grid->upper[d] - x : x - grid->lower[d]) / b->b[d];
}

/* Returns how far the first place of the body's lattice in the grid is inside a face of axis d, over the spacing. */
static PetscReal First(const MPMGrid *grid, const MPMBody *b, PetscInt d, int side)
{
  const PetscReal places = ((side ? grid->upper[d] : grid->lower[d]) - b->offset[d]) / b->b[d] - 0.5;

  return side ? places - PetscFloorReal(places) : PetscCeilReal(places) - places;
}

/* Returns whether a particle at r, m, of a body of revolution is near the axis. */
static PetscBool AtAxis(const MPMCore *core, const MPMBody *b, PetscReal r)
{
  return b->round && core->grid.lower[0] == 0 && r < NEAR_AXIS * core->grid.h[0];
}

PetscReal MPMAtWallsRadius(const MPMBody *b, PetscReal r)
{
  return r < 0.5 * b->b[0] ? 0.5 * (r + 0.5 * b->b[0]) : r;
}

void MPMAtWallsMove(const MPMScene *scene, const MPMCore *core, const MPMBody *b, PetscReal x[])
{
  const MPMGrid *grid = &core->grid;

  if (b->round && !b->memo) x[0] = MPMAtWallsRadius(b, x[0]); /* a cut place has its centroid */
  if (core->grid.total || !Flows(scene, core, b)) return;
  for (PetscInt d = 0; d < grid->dim; d++)
    for (int side = 0; side < 2; side++) {
      if (!MPMWallHas(scene->walls.given[d][side].type, MPM_WALL_NORMAL)) continue;
      if (PetscAbsReal(Inside(grid, b, d, side, x[d])) > ON_WALL) continue;
      x[d] = side ? grid->upper[d] - OFF_WALL * b->b[d] : grid->lower[d] + OFF_WALL * b->b[d];
    }
}

PetscBool MPMAtWallsLie(const MPMScene *scene, const MPMCore *core, const MPMBody *b, PetscInt d)
{
  PetscReal lower[3], upper[3];

  if (!Flows(scene, core, b)) return PETSC_FALSE;
  MPMRegionBounds(&b->region, core->grid.dim, lower, upper);
  for (int side = 0; side < 2; side++) {
    const PetscReal in = First(&core->grid, b, d, side), from = side ? upper[d] : lower[d];

    if (!MPMWallHas(scene->walls.given[d][side].type, MPM_WALL_NORMAL)) continue;
    if (Inside(&core->grid, b, d, side, from) > ON_WALL) continue;
    if (PetscMin(in, 1 - in) < ON_WALL) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns the share of its own volume in which the stress of a particle acts that lies `in` spacings from a wall which
   holds it along the normal; 1 if it is not next to the wall, or lies on it. */
static PetscReal Share(MPMWall type, PetscReal in)
{
  if (!MPMWallHas(type, MPM_WALL_NORMAL) || MPMWallHas(type, MPM_WALL_PUSHES | MPM_WALL_MOVES)) return 1;
  return in > ON_WALL && in < 1 - ON_WALL && PetscAbsReal(in - 0.5) > SAME ? in + 0.5 : 1;
}

/* Returns the volume of revolution, m^3, of the box of a particle whose column of the lattice is at r. What would be
   left of the axis does not count; reaches: the box goes on to the axis. */
static PetscReal Ring(const MPMBody *b, PetscReal r, PetscBool reaches)
{
  const PetscReal upper = r + 0.5 * b->b[0], lower = reaches ? 0 : PetscMax(0, r - 0.5 * b->b[0]);

  return PETSC_PI * (upper - lower) * (upper + lower) * b->b[1];
}

/* Returns the radius at which the particles of a column start, m. */
static PetscReal ColumnRadius(const MPMBody *b, PetscInt k)
{
  return MPMAtWallsRadius(b, ((PetscReal)(b->column + k) + 0.5) * b->b[0] + b->offset[0]);
}

/* Sets share [n] to that of its volume that a particle has which starts in each of the first columns of a body that
   reaches the axis. In a uniform stress s the forces of the particles on node i, of the sum of V s (phi' + phi/r), have
   to cancel; but the particles are few, and near the axis this sum over them is not the integral, which is 0. Of all
   shares with which it is 0 at the first nodes these are the nearest to 1 (in the mean of squares). */
static void AxisShares(const MPMScene *scene, const MPMCore *core, const MPMBody *b, PetscInt n, PetscReal share[])
{
  const MPMBasis  basis           = (MPMBasis)scene->start.basis;
  const PetscReal h               = core->grid.h[0];
  const PetscInt  all             = (PetscInt)((NEAR_AXIS + 2 * NODES) * h / b->b[0]);
  MPMGrid         grid            = core->grid;
  PetscReal       A[NODES][NODES] = {{0}}, rest[NODES] = {0}, trace = 0;
  PetscReal       w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];

  grid.cells[0] = 1000; /* so that no other wall is near */
  grid.upper[0] = grid.lower[0] + 1000 * h;
  for (PetscInt pass = 0; pass < 2; pass++) {
    for (PetscInt k = 0; k < all; k++) {
      const PetscReal r = ColumnRadius(b, k), l = PetscMin(0.5 / (PetscReal)b->ppc[0], r / h);
      const PetscReal volume = Ring(b, ((PetscReal)(b->column + k) + 0.5) * b->b[0] + b->offset[0], !k);
      PetscReal       xi, push[NODES] = {0};
      const PetscInt  base = MPMCoordinate(basis, &grid, 0, r, l, &xi);

      MPMBasisWeights(basis, xi, l, base, grid.cells[0], grid.wall_basis[0], w, g);
      for (PetscInt i = 0; i < MPMBasisNodes(basis); i++)
        if (base + i >= 1 && base + i <= NODES)
          push[base + i - 1] = volume / (b->b[0] * b->b[1]) * (g[i] / h + w[i] / r);
      if (pass && k < n)
        for (PetscInt i = 0; i < NODES; i++) share[k] -= push[i] * rest[i];
      if (pass) continue;
      for (PetscInt i = 0; i < NODES; i++) rest[i] += push[i];
      for (PetscInt i = 0; i < NODES && k < n; i++)
        for (PetscInt j = 0; j < NODES; j++) A[i][j] += push[i] * push[j];
    }
    if (pass) break;
    for (PetscInt i = 0; i < NODES; i++) trace += A[i][i];
    for (PetscInt i = 0; i < NODES; i++) A[i][i] += 1e-12 * trace;
    (void)MPMSolve(NODES, NODES, &A[0][0], rest);
  }
}

PetscErrorCode MPMAtWallsColumns(MPMScene *scene, const MPMCore *core, MPMBody *b, PetscBool any)
{
  const MPMLattice w      = MPMLatticeBegin(b, 2);
  const PetscBool  shaped = MPMMaterialKeepsShape(&scene->materials[b->material]);
  PetscInt         near   = (PetscInt)(NEAR_AXIS * core->grid.h[0] / b->b[0] + 1);
  PetscReal       *shares;

  PetscFunctionBeginUser;
  b->column   = w.first[0];
  b->ncolumns = (PetscInt)(w.last[0] - w.first[0] + 1);
  PetscCall(PetscMalloc1(COLUMN * b->ncolumns, &b->columns));
  PetscCall(PetscMalloc1(near, &shares));
  for (PetscInt k = 0; k < near; k++) shares[k] = 1;
  /* in the updated frame one column too many counts, as it always has: the sums then vanish to 3e-4 */
  while (scene->start.total && near > 0 && !AtAxis(core, b, ColumnRadius(b, near - 1))) near--;
  if (AtAxis(core, b, ColumnRadius(b, 0)) && ColumnRadius(b, 0) < b->b[0]) AxisShares(scene, core, b, near, shares);
  for (PetscInt k = 0; k < b->ncolumns; k++) {
    const PetscReal r   = ((PetscReal)(b->column + k) + 0.5) * b->b[0] + b->offset[0];
    MPMKind         own = {b->material, 0, 0, {0}, b->copy};

    for (PetscInt d = 0; d < 2; d++) own.l[d] = 0.5 / (PetscReal)b->ppc[d];
    own.V0 = Ring(b, r, PETSC_FALSE);
    own.m  = scene->materials[b->material].rho * own.V0;
    for (PetscInt n = 0; n < COLUMN; n++) {
      MPMKind         kind = own;
      const int       x = (int)(n % 3), y = (int)(n / 3);
      const PetscBool axis  = x == 1 && k < near && AtAxis(core, b, r);
      const PetscReal in    = x ? Inside(&core->grid, b, 0, x - 1, r) : 0;
      const PetscReal along = y && any && shaped && !b->source.on
                                  ? Share((MPMWall)scene->start.wall[1 + y], First(&core->grid, b, 1, y - 1))
                                  : 1;
      PetscReal       share = x && !axis && any && shaped ? Share((MPMWall)scene->start.wall[x - 1], in) : 1;

      if (axis) {
        kind.V0 = shares[k] * Ring(b, r, !k);
        kind.m  = scene->materials[b->material].rho * kind.V0;
      }
      kind.V0 *= share * along;
      if (n && kind.V0 == own.V0)
        b->columns[COLUMN * k + n] = b->columns[COLUMN * k];
      else {
        b->columns[COLUMN * k + n]    = scene->nkinds;
        scene->kinds[scene->nkinds++] = kind;
      }
    }
  }
  PetscCall(PetscFree(shares));
  b->kind = b->columns[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMAtWallsKind(const MPMScene *scene, const MPMCore *core, const MPMBody *b, const PetscReal X[])
{
  const PetscInt dim    = core->grid.dim;
  PetscInt       number = 0; /* a digit of base 3 for each axis: 0 if no wall is near, else 1 + its side */

  for (PetscInt d = dim - 1; d >= 0; d--) {
    PetscInt digit = 0;

    for (int side = 0; side < 2 && !digit; side++) {
      const PetscReal in = Inside(&core->grid, b, d, side, X[d]);
      PetscReal       y[3];

      if (b->round && 2 * d + side == 0 && core->grid.lower[0] == 0) { /* no wall, but the axis */
        const PetscReal on[3] = {ON_WALL * b->b[0], X[1], 0};

        if (AtAxis(core, b, X[0]) && MPMRegionInside(&b->region, dim, on)) digit = 1;
        continue;
      }

      if (Share((MPMWall)scene->start.wall[2 * d + side], in) == 1) continue;
      for (PetscInt e = 0; e < dim; e++) y[e] = X[e];
      y[d] = X[d] + (side ? 1 : -1) * (1 - ON_WALL) * in * b->b[d];
      if (MPMRegionInside(&b->region, dim, y)) digit = 1 + side; /* the body reaches the wall */
    }
    number = 3 * number + digit;
  }
  return b
      ->columns[COLUMN * (PetscInt)(PetscFloorReal((X[0] - b->offset[0]) / b->b[0]) - (PetscReal)b->column) + number];
}
