/* unit_distance.c - signed distances from shapes: the sign is that of being inside, going by the distance along the
   normal leads to the surface, the normal is the gradient, and no surface is nearer. Of a ball as triangles and as a
   formula they are those of the ball, with an error that is stated; faces at walls of the grid are none if they are open. */
#include <stdlib.h>
#include "physics/distance.h"
#include "unit.h"

#define H 1e-6 /* m, of differences */

static void Random(MPMRegion *r, int dim)
{
  PetscReal size = 0;

  r->radius       = UnitReal(0.5, 1);
  r->inner_radius = UnitReal(0.1, 0.4);
  r->length       = UnitReal(0.5, 2);
  for (int d = 0; d < dim; d++) {
    r->center[d] = UnitReal(-1, 1);
    r->lower[d]  = UnitReal(-1, -0.2);
    r->upper[d]  = UnitReal(0.2, 1);
    r->axis[d]   = UnitReal(-1, 1);
    size += r->axis[d] * r->axis[d];
  }
  for (int d = 0; d < dim; d++) r->axis[d] /= sqrt(size);
  for (int d = 0; d < dim && r->type == MPM_REGION_halfspace; d++) {
    r->lower[d] = -PETSC_INFINITY;
    r->upper[d] = PETSC_INFINITY;
  }
}

/* A place is far from edges and middles, where the normal jumps, if the distances around it are linear. */
static int Smooth(const MPMRegion *r, int dim, const PetscReal x[], PetscReal distance)
{
  for (int d = 0; d < dim; d++) {
    PetscReal y[3] = {x[0], x[1], x[2]}, n[3], sum = -2 * distance;

    for (int s = -1; s < 2; s += 2) {
      y[d] = x[d] + s * 1e-3;
      sum += MPMRegionDistance(r, dim, y, n);
    }
    if (fabs(sum) > 1e-4) return 0;
  }
  return 1;
}

/* exact: the distance is that of the nearest place, not only a bound of it. */
static void Check(const MPMRegion *r, int dim, int exact)
{
  PetscReal x[3] = {0}, n[3], y[3], m[3], size = 0, distance;

  for (int d = 0; d < dim; d++) x[d] = UnitReal(-2, 2);
  distance = MPMRegionDistance(r, dim, x, n);
  CHECK_EQ(distance < 0, MPMRegionInside(r, dim, x));
  for (int d = 0; d < dim; d++) size += n[d] * n[d];
  CHECK_NEAR(size, 1, 1e-14);
  if (!Smooth(r, dim, x, distance)) return;
  for (int d = 0; d < dim; d++) {
    PetscReal twice = 0;

    for (int s = -1; s < 2; s += 2) {
      memcpy(y, x, sizeof y);
      y[d] += s * H;
      twice += s * MPMRegionDistance(r, dim, y, m);
    }
    CHECK_NEAR(twice / (2 * H), n[d], 1e-4);
  }
  for (int d = 0; d < dim; d++) y[d] = x[d] - distance * n[d];
  if (exact) CHECK_NEAR(MPMRegionDistance(r, dim, y, m), 0, 1e-12);
  for (int k = 0; k < 20; k++) { /* nothing within the distance is on the other side */
    PetscReal away = 0, by = 0.999 * UnitReal(0, 1) * fabs(distance);

    for (int d = 0; d < dim; d++) {
      y[d] = UnitReal(-1, 1);
      away += y[d] * y[d];
    }
    for (int d = 0; d < dim; d++) y[d] = x[d] + by * y[d] / sqrt(away);
    CHECK_EQ(MPMRegionInside(r, dim, y), distance < 0);
  }
}

/* A random polygon around the origin, in the order of its angles. */
static void Star(MPMRegion *r)
{
  enum { N = 9 };
  PetscReal x[N + 1][2], edge[N][2][2];

  for (int k = 0; k < N; k++) {
    const PetscReal angle = (k + UnitReal(0.1, 0.9)) * 2 * PETSC_PI / N, radius = UnitReal(0.3, 1);

    x[k][0] = radius * cos(angle);
    x[k][1] = radius * sin(angle);
  }
  memcpy(x[N], x[0], sizeof x[0]);
  for (int k = 0; k < N; k++) memcpy(edge[k], x[k], sizeof edge[k]);
  r->surface = MPMSurfaceCreate(2, N, edge[0][0]);
  for (int d = 0; d < 2; d++) {
    r->lower[d] = r->surface->lower[d];
    r->upper[d] = r->surface->upper[d];
  }
}

/* The triangles of a ball: those of an octahedron, each cut into 4 `times` times, with corners on the sphere; if lumps is
   not 0, each corner is moved by up to this part of the radius. */
static void Ball(MPMRegion *r, int times, PetscReal lumps)
{
  const int n = 8 << 2 * times, sides = 1 << times;
  PetscReal(*corner)[3][3] = malloc((size_t)n * sizeof *corner);
  int at                   = 0;

  for (int octant = 0; octant < 8; octant++)
    for (int i = 0; i < sides; i++)
      for (int j = 0; j < sides - i; j++)
        for (int up = 0; up < (j < sides - i - 1 ? 2 : 1); up++, at++)
          for (int k = 0; k < 3; k++) {
            const int a = i + (up ? k != 0 : k == 1), b = j + (up ? k != 1 : k == 2), c = sides - a - b;
            PetscReal x[3] = {a, b, c}, size;
            uint64_t  bits = (uint64_t)a * 73856093 ^ (uint64_t)b * 19349663 ^ (uint64_t)c * 83492791;

            for (int d = 0; d < 3; d++) {
              if (octant >> d & 1) x[d] = -x[d];
              bits = (bits + (uint64_t)(x[d] < 0)) * 0x9e3779b97f4a7c15ULL;
            }
            size = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) / (1 - lumps * (PetscReal)(bits >> 40) / (1 << 24));
            for (int d = 0; d < 3; d++) corner[at][k][d] = r->center[d] + r->radius * x[d] / size;
          }
  CHECK_EQ(at, n);
  r->surface = MPMSurfaceCreate(3, n, corner[0][0]);
  memcpy(r->lower, r->surface->lower, sizeof r->lower);
  memcpy(r->upper, r->surface->upper, sizeof r->upper);
  free(corner);
}

static PetscReal BallFormula(void *context, PetscInt dim, const PetscReal x[])
{
  const MPMRegion *r = (const MPMRegion *)context;
  PetscReal        s = r->radius * r->radius;

  for (int d = 0; d < dim; d++) s -= (x[d] - r->center[d]) * (x[d] - r->center[d]);
  return s * (3 + x[0]); /* not the distance, nor in proportion to it */
}

static PetscReal Slab(void *context, PetscInt dim, const PetscReal x[])
{
  (void)context;
  (void)dim;
  return 1 - x[1];
}

static void Drop(MPMRegion *r)
{
  MPMSurfaceDestroy(&r->surface);
  MPMRegionDropDistance(r);
}

/* The grid of the tests reaches further than the shapes. */
static MPMGrid Grid(int dim, PetscReal h)
{
  MPMGrid grid = {.dim = dim};

  for (int d = 0; d < 3; d++) {
    grid.lower[d] = -10;
    grid.upper[d] = 10;
    grid.h[d]     = h;
  }
  return grid;
}

/* Distances from a ball, in cells h, of places within MPM_DISTANCE_REACH of it: the largest error and the largest angle,
   degrees, between normals. */
static void BallErrors(const MPMRegion *r, int dim, PetscReal h, PetscReal *error, PetscReal *angle)
{
  MPMRegion ball = *r;

  ball.type = MPM_REGION_sphere;
  *error = *angle = 0;
  for (int k = 0; k < 20000; k++) {
    PetscReal x[3], n[3], m[3], along = 0, exact;

    do {
      for (int d = 0; d < dim; d++) x[d] = r->center[d] + UnitReal(-1, 1) * (r->radius + MPM_DISTANCE_REACH * h);
      exact = MPMRegionDistance(&ball, dim, x, m);
    } while (fabs(exact) > PetscMin(MPM_DISTANCE_REACH * h, 0.7 * r->radius));
    *error = PetscMax(*error, fabs(MPMRegionDistance(r, dim, x, n) - exact) / h);
    for (int d = 0; d < dim; d++) along += n[d] * m[d];
    *angle = PetscMax(*angle, acos(PetscMin(1, along)) * 180 / PETSC_PI);
  }
}

static void Sampled(int dim, int stl)
{
  PetscReal last = 0;

  for (int cells = 4; cells <= (dim < 3 ? 16 : 8); cells *= 2) {
    const PetscReal h    = 1. / cells;
    MPMRegion       ball = {.type = MPM_REGION_expression, .radius = 1, .formula = BallFormula};
    MPMGrid         grid = Grid(dim, h);
    PetscReal       error, angle;

    UnitContext("a ball of %d cells in %d-D %s", cells, dim, stl ? "of triangles" : "by a formula");
    ball.context = &ball;
    for (int d = 0; d < 3; d++) {
      ball.center[d] = 0.1 * h * d;
      ball.lower[d]  = -1.5;
      ball.upper[d]  = 1.5;
    }
    if (stl) {
      ball.type = MPM_REGION_stl;
      Ball(&ball, cells == 4 ? 4 : 5, 0); /* about 2 of their edges are a cell */
    }
    CHECK(MPMRegionMakeDistance(&ball, &grid, PETSC_FALSE));
    BallErrors(&ball, dim, h, &error, &angle);
    CHECK_LE(error, 0.04 * 4 / cells);
    CHECK_LE(angle, (dim == 2 ? 6.5 : 5) * 4 / cells);
    if (last > 0) CHECK_LE(error, 0.7 * last);
    last = error;
    Drop(&ball);
  }
}

/* A box of 12 triangles has the distance of a box; one of many has it but near edges, since it is sampled. */
static void Edges(int sides)
{
  const PetscReal h    = 0.25;
  MPMGrid         grid = Grid(3, h);
  MPMRegion       r = {.type = MPM_REGION_stl, .lower = {0, 0.1, -0.3}, .upper = {2, 1.7, 1.2}}, box = r;
  PetscReal(*corner)[3] = malloc((size_t)(36 * sides * sides) * sizeof *corner), error = 0, beside = 0;
  int n = 0;

  UnitContext("a box of %d triangles", 12 * sides * sides);
  box.type = MPM_REGION_box;
  for (int side = 0; side < 6; side++)
    for (int q = 0; q < sides * sides * 6; q++, n++) {
      static const int at[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
      const int        d = side / 2, e = (d + 1) % 3, f = (d + 2) % 3;

      corner[n][d] = side % 2 ? r.upper[d] : r.lower[d];
      corner[n][e] = r.lower[e] + (r.upper[e] - r.lower[e]) * (q / 6 % sides + at[q % 6][0]) / sides;
      corner[n][f] = r.lower[f] + (r.upper[f] - r.lower[f]) * (q / 6 / sides + at[q % 6][1]) / sides;
    }
  r.surface = MPMSurfaceCreate(3, n / 3, corner[0]);
  CHECK(MPMRegionMakeDistance(&r, &grid, PETSC_FALSE));
  CHECK_EQ(r.sampled != NULL, sides > 4);
  for (int k = 0; k < 20000; k++) {
    PetscReal x[3], m[3], exact, off, at = 0;

    do {
      for (int d = 0; d < 3; d++) x[d] = UnitReal(-1, 3);
      exact = MPMRegionDistance(&box, 3, x, m);
    } while (fabs(exact) > h);
    off   = fabs(MPMRegionDistance(&r, 3, x, m) - exact) / h;
    error = PetscMax(error, off);
    for (int d = 0; d < 3; d++)
      at += fabs(x[d] - 0.5 * (box.lower[d] + box.upper[d])) < 0.5 * (box.upper[d] - box.lower[d]) - h;
    if (exact > 0 && at == 2) beside = PetscMax(beside, off); /* a cell from all edges */
  }
  CHECK_LE(error, sides > 4 ? 0.1 : 1e-12);
  CHECK_LE(beside, sides > 4 ? 1e-3 : 1e-12);
  free(corner);
  Drop(&r);
}

/* Faces at the walls of the grid, or beyond them, are no surface if they are open: of a box on the floor whose right side
   is at the wall, of a polygon and of triangles that are the same, and of a formula. */
static void Open(MPMRegionType type, int dim)
{
  const PetscReal corners[4][2] = {{1, 0}, {3, -0.5}, {3, 1}, {1, 1}};
  PetscReal       edge[4][2][2], x[3] = {2.4, 0.3, 0.5}, n[3];
  MPMRegion       r = {.type = type};
  MPMGrid         grid;

  UnitContext("%s at walls in %d-D", MPMRegionNames[type], dim);
  grid = (MPMGrid){.dim = dim, .upper = {3, 2, 2}, .h = {0.25, 0.25, 0.25}};
  for (int k = 0; k < 8; k++) edge[k / 2][k % 2][0] = corners[(k / 2 + k % 2) % 4][0];
  for (int k = 0; k < 8; k++) edge[k / 2][k % 2][1] = corners[(k / 2 + k % 2) % 4][1];
  if (type == MPM_REGION_polygon) r.surface = MPMSurfaceCreate(2, 4, edge[0][0]);
  r.formula  = Slab;
  r.lower[0] = 1;
  r.lower[1] = type == MPM_REGION_polygon ? -0.5 : 0;
  r.upper[0] = 3;
  r.upper[1] = type == MPM_REGION_expression ? 2 : 1;
  r.upper[2] = 2;
  CHECK(MPMRegionMakeDistance(&r, &grid, PETSC_TRUE));
  CHECK_NEAR(MPMRegionDistance(&r, dim, x, n), -0.7, 1e-12); /* not -0.3 of the floor, nor -0.6 of the wall */
  CHECK_NEAR(n[1], 1, 1e-12);
  x[2] = 0.1;
  CHECK_NEAR(MPMRegionDistance(&r, dim, x, n), -0.7, 1e-12);
  x[0] = 1.2;
  CHECK_NEAR(MPMRegionDistance(&r, dim, x, n), -0.2, 1e-12);
  CHECK_NEAR(n[0], -1, 1e-12);
  x[1] = -0.1; /* beyond the grid */
  if (type == MPM_REGION_box) CHECK_NEAR(MPMRegionDistance(&r, dim, x, n), -0.2, 1e-12);
  CHECK(MPMRegionMakeDistance(&r, &grid, PETSC_FALSE));
  x[2] = 0.5;
  x[0] = 2.8;
  x[1] = 0.5;
  if (type != MPM_REGION_expression) CHECK_NEAR(MPMRegionDistance(&r, dim, x, n), -0.2, 1e-12);
  if (type == MPM_REGION_expression) CHECK_NEAR(MPMRegionDistance(&r, dim, x, n), -0.5, 1e-12); /* it goes on there */
  Drop(&r);
}

/* Beyond the reach it is the reach, and which side it is on is right; the same bits each time. */
static void Far(MPMRegionType type, int dim)
{
  const PetscReal h    = 0.1;
  MPMGrid         grid = Grid(dim, h);
  MPMRegion       twice[2];
  int             cut = 0;

  UnitContext("far from %s in %d-D", MPMRegionNames[type], dim);
  for (int k = 0; k < 2; k++) {
    MPMRegion *r = &twice[k];

    *r = (MPMRegion){.type = type, .radius = 1, .lower = {-2, -2, -2}, .upper = {2, 2, 2}, .formula = BallFormula};
    r->context = r;
    if (type == MPM_REGION_stl) Ball(r, 5, 0);
    CHECK(MPMRegionMakeDistance(r, &grid, PETSC_FALSE));
  }
  CHECK_EQ(dim == 3, twice[0].sampled != NULL);
  if (dim == 2)
    CHECK_SAME(twice[0].nearest->corner, twice[1].nearest->corner,
               (size_t)(twice[0].nearest->n * 4) * sizeof(PetscReal));
  if (dim == 3) {
    const size_t n = (size_t)(twice[0].sampled->n[0] * twice[0].sampled->n[1] * twice[0].sampled->n[2]);

    CHECK_SAME(twice[0].sampled->distance, twice[1].sampled->distance, n * sizeof(float));
  }
  for (int k = 0; k < 2000; k++) {
    PetscReal x[3], n[3], size2 = 0, one = 0, exact, distance;

    for (int d = 0; d < dim; d++) {
      x[d] = UnitReal(-1.4, 1.4);
      size2 += x[d] * x[d];
    }
    exact    = sqrt(size2) - 1;
    distance = MPMRegionDistance(&twice[0], dim, x, n);
    CHECK_EQ(distance < 0, MPMRegionInside(&twice[0], dim, x) || (exact < 0 && exact > -0.002));
    for (int d = 0; d < dim; d++) one += n[d] * n[d];
    CHECK_NEAR(one, 1, 1e-12);
    if (fabs(exact) > MPM_DISTANCE_REACH * h)
      CHECK_GE(exact < 0 ? -distance : distance, (MPM_DISTANCE_REACH - 0.01) * h);
    else
      CHECK_NEAR(distance, exact, 0.03 * h);
    cut += fabs(exact) > MPM_DISTANCE_REACH * h;
  }
  CHECK_GE(cut, 100);
  for (int k = 0; k < 2; k++) Drop(&twice[k]);
}

static void Prepare(MPMRegion *r, int dim, int k)
{
  const MPMGrid grid = Grid(dim, 1);

  if (r->type == MPM_REGION_polygon) Star(r);
  if (r->type == MPM_REGION_stl) Ball(r, k % 3, 0.5);
  CHECK_EQ(MPMRegionHasDistance(r), !r->surface);
  CHECK(MPMRegionMakeDistance(r, &grid, PETSC_FALSE));
  CHECK(MPMRegionHasDistance(r));
}

int main(void)
{
  for (int t = 0; t < MPM_NUM_REGIONS; t++)
    for (int dim = 1; dim < 4; dim++) {
      if (t == MPM_REGION_file || t == MPM_REGION_expression || (t == MPM_REGION_polygon && dim < 2)) continue;
      if ((t == MPM_REGION_cylinder || t == MPM_REGION_stl) && dim < 3) continue;
      for (int k = 0; k < 300; k++) {
        MPMRegion  r = {.type = (MPMRegionType)t}, ball = {.type = MPM_REGION_sphere};
        MPMRegion *others[] = {&ball};

        UnitContext("%s in %d-D, number %d", MPMRegionNames[t], dim, k);
        Random(&r, dim);
        Random(&ball, dim);
        Prepare(&r, dim, k);
        for (int q = 0; q < 10; q++) Check(&r, dim, t != MPM_REGION_polygon || dim == 2);
        r.others = others;
        r.ncut = k % 2, r.nwithin = !(k % 2);
        for (int q = 0; q < 10; q++) Check(&r, dim, 0);
        Drop(&r);
      }
    }
  for (int stl = 0; stl < 2; stl++)
    for (int dim = stl ? 3 : 1; dim < 4; dim++) Sampled(dim, stl);
  for (int dim = 2; dim < 4; dim++) {
    Open(MPM_REGION_box, dim);
    Open(MPM_REGION_polygon, dim);
    Open(MPM_REGION_expression, dim);
    Far(MPM_REGION_expression, dim);
  }
  Far(MPM_REGION_stl, 3);
  Edges(1);
  Edges(6);
  return UnitEnd();
}
