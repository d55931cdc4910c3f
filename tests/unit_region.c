/* unit_region.c - the shapes of region.def: their bounds hold them and are tight, they move with their numbers, their
   half-open borders share places out without a gap or an overlap, rows of places are what their places are, volumes
   are the exact ones, and no line slips through between the faces of a surface. */
#include "physics/region.h"
#include "unit.h"

static const char *names[] = {
#define MPM_REGION(name, solid, parameters, what) #name,
#include "physics/region.def"
};

static PetscReal Ball(void *context, PetscInt dim, const PetscReal x[])
{
  const MPMRegion *r = context;
  PetscReal        s = r->radius * r->radius;

  for (PetscInt d = 0; d < dim; d++) s -= (x[d] - r->center[d]) * (x[d] - r->center[d]);
  return s;
}

/* The faces of a box, whose corners are numbered by their bits. */
static MPMSurface *BoxSurface(int dim, const PetscReal lower[], const PetscReal upper[])
{
  static const int edges[4][2]      = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  static const int triangles[12][3] = {{0, 1, 3}, {0, 3, 2}, {4, 7, 5}, {4, 6, 7}, {0, 5, 1}, {0, 4, 5},
                                       {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  const int        n                = dim == 2 ? 4 : 12;
  PetscReal        corner[108];

  for (int f = 0; f < n; f++)
    for (int k = 0; k < dim; k++)
      for (int d = 0; d < dim; d++)
        corner[(f * dim + k) * dim + d] = (dim == 2 ? edges[f][k] : triangles[f][k]) >> d & 1 ? upper[d] : lower[d];
  return MPMSurfaceCreate(dim, n, corner);
}

/* Returns whether a shape is there in dim dimensions. */
static int Has(MPMRegionType type, int dim)
{
  if (type == MPM_REGION_file) return 0; /* no shape */
  return type == MPM_REGION_polygon ? dim > 1 : type == MPM_REGION_cylinder || type == MPM_REGION_stl ? dim > 2 : 1;
}

/* Makes what a region refers to for its present numbers; Drop frees it. A cylinder is along an axis, a halfspace bounds
   its box or cuts it, an expression is a ball in its box. */
static void Make(MPMRegion *r, int dim)
{
  if (r->type == MPM_REGION_polygon) r->surface = BoxSurface(2, r->lower, r->upper);
  if (r->type == MPM_REGION_stl) r->surface = BoxSurface(3, r->lower, r->upper);
  r->formula = Ball;
  r->context = r;
  for (int d = 0; d < dim && r->type == MPM_REGION_expression; d++) {
    r->lower[d] = r->center[d] - r->radius;
    r->upper[d] = r->center[d] + r->radius;
  }
}

static void Drop(MPMRegion *r)
{
  MPMSurfaceDestroy(&r->surface);
}

/* A random region; all numbers are multiples of 1/64, so that sums of them are exact. */
static MPMRegion Random(MPMRegionType type)
{
  MPMRegion r;

  memset(&r, 0, sizeof r);
  r.type = type;
  for (int d = 0; d < 3; d++) {
    r.center[d] = (UnitInt(257) - 128) / 64.0;
    r.lower[d]  = (UnitInt(257) - 128) / 64.0;
    r.upper[d]  = r.lower[d] + (1 + UnitInt(128)) / 64.0;
    if (type == MPM_REGION_halfspace) r.center[d] = r.lower[d] + (r.upper[d] - r.lower[d]) * (1 + UnitInt(8)) / 8;
  }
  r.radius                                              = (16 + UnitInt(128)) / 64.0;
  r.inner_radius                                        = UnitInt(13) / 16.0 * r.radius;
  r.length                                              = (16 + UnitInt(128)) / 64.0;
  r.axis[type == MPM_REGION_halfspace ? 0 : UnitInt(3)] = 1;
  return r;
}

/* For every row of the table. */
static void AnyShape(MPMRegionType type, int dim)
{
  MPMRegion r = Random(type), moved;
  PetscReal lower[3], upper[3], shift[3], least[3], most[3];
  long      inside = 0;

  UnitContext("%s in %d-D", names[type], dim);
  Make(&r, dim);
  MPMRegionBounds(&r, dim, lower, upper);
  moved = r;
  for (int d = 0; d < dim; d++) {
    shift[d] = (UnitInt(65) - 32) / 8.0;
    moved.center[d] += shift[d];
    moved.lower[d] += shift[d];
    moved.upper[d] += shift[d];
    CHECK(lower[d] < upper[d]);
    least[d] = INFINITY;
    most[d]  = -INFINITY;
  }
  Make(&moved, dim);
  for (int k = 0; k < 4000; k++) {
    PetscReal x[3], y[3];
    PetscBool in;

    for (int d = 0; d < dim; d++) {
      const PetscReal margin = 0.25 * (upper[d] - lower[d]);

      x[d] = PetscFloorReal(4096 * UnitReal(lower[d] - margin, upper[d] + margin)) / 4096;
      if (k % 4 == 0 && d == k / 4 % dim) x[d] = lower[d] + 0x1p-12 * UnitInt(64); /* near the faces of the box */
      if (k % 4 == 1 && d == k / 4 % dim) x[d] = upper[d] - 0x1p-12 * UnitInt(64);
      if (k % 4 < 2 && d != k / 4 % dim) x[d] = 0.5 * (lower[d] + upper[d]) + 0x1p-12 * UnitInt(16);
      y[d] = x[d] + shift[d];
    }
    in = MPMRegionInside(&r, dim, x);
    CHECK_EQ(MPMRegionInside(&moved, dim, y), in);
    if (!in) continue;
    inside++;
    for (int d = 0; d < dim; d++) {
      CHECK_GE(x[d], lower[d]);
      CHECK_LE(x[d], upper[d]);
      least[d] = PetscMin(least[d], x[d]);
      most[d]  = PetscMax(most[d], x[d]);
    }
  }
  CHECK_GE(inside, 20);
  Drop(&r);
  Drop(&moved);
  for (int d = 0; d < dim && type != MPM_REGION_halfspace; d++) { /* nothing to spare on any side */
    CHECK_LE(least[d], lower[d] + 0.05 * (upper[d] - lower[d]));
    CHECK_GE(most[d], upper[d] - 0.05 * (upper[d] - lower[d]));
  }
}

/* What a solid shape has of a row of places is one piece, with one of the two places beside the middle in it. */
static void Solid(MPMRegionType type, int dim)
{
  const MPMRegion r = Random(type);
  PetscReal       lower[3], upper[3];

  UnitContext("rows of %s in %d-D", names[type], dim);
  if (!MPMRegionSolid(&r)) return;
  MPMRegionBounds(&r, dim, lower, upper);
  for (int row = 0; row < 200; row++) {
    const int       d = row % dim;
    const PetscReal b = UnitReal(0.01, 0.7), offset = UnitReal(-1, 1);
    const int       first = (int)floor((lower[d] - offset) / b) - 2, last = (int)ceil((upper[d] - offset) / b) + 2;
    const int       middle = (int)floor((0.5 * (lower[d] + upper[d]) - offset) / b - 0.5);
    int             pieces = 0, inside = 0, at_middle = 0;
    PetscReal       x[3];

    for (int e = 0; e < dim; e++) x[e] = UnitReal(lower[e], upper[e]);
    for (int k = first; k <= last; k++) {
      int in;

      x[d] = (k + 0.5) * b + offset;
      in   = MPMRegionInside(&r, dim, x);
      if (in && !inside) pieces++;
      if (in && (k == middle || k == middle + 1)) at_middle = 1;
      inside = in;
    }
    CHECK_EQ(inside, 0);
    CHECK_LE(pieces, 1);
    CHECK_EQ(at_middle, pieces);
  }
}

static void Box(int dim)
{
  const MPMRegion r    = Random(MPM_REGION_box);
  const int       axis = UnitInt(dim);
  MPMRegion       a = r, b = r;

  UnitContext("box in %d-D", dim);
  a.upper[axis] = b.lower[axis] = r.lower[axis] + UnitReal(0, 1) * (r.upper[axis] - r.lower[axis]);
  for (int k = 0; k < 200; k++) {
    PetscReal x[3];

    for (int d = 0; d < dim; d++)
      x[d] = UnitInt(4) ? UnitReal(r.lower[d], r.upper[d]) : UnitInt(2) ? r.lower[d] : r.upper[d];
    if (UnitInt(2)) x[axis] = UnitStep(a.upper[axis], UnitInt(3) - 1); /* at the common face */
    CHECK_EQ((MPMRegionInside(&a, dim, x) ? 1 : 0) + (MPMRegionInside(&b, dim, x) ? 1 : 0),
             MPMRegionInside(&r, dim, x) ? 1 : 0);
    for (int d = 0; d < dim; d++) {
      const PetscReal keep = x[d];

      x[d] = r.upper[d];
      CHECK(!MPMRegionInside(&r, dim, x));
      x[d] = UnitStep(r.lower[d], -1);
      CHECK(!MPMRegionInside(&r, dim, x));
      x[d] = keep;
    }
  }
  CHECK(MPMRegionInside(&r, dim, r.lower));
}

/* Ball and shell: the distance decides, half-open, and in fewer dimensions only the first coordinates count. */
static void Round(int dim)
{
  MPMRegion shell = Random(MPM_REGION_annulus), ball = shell, core = shell;

  UnitContext("sphere and annulus in %d-D", dim);
  ball.type = core.type = MPM_REGION_sphere;
  core.radius           = shell.inner_radius;
  for (int k = 0; k < 200; k++) {
    const PetscReal r    = UnitInt(2) ? shell.radius : shell.inner_radius;
    PetscReal       x[3] = {0}, s = 0;

    for (int d = 0; d < dim; d++) x[d] = shell.center[d] + (UnitInt(513) - 256) / 64.0;
    if (k % 2) { /* exactly at distance r: along an axis, or by 3^2 + 4^2 = 5^2 when r = 5q, or by 1 + 4 + 4 = 9 */
      for (int d = 0; d < dim; d++) x[d] = shell.center[d];
      if (dim > 1 && k % 4 == 1) {
        shell.radius = ball.radius = 5.0 / 8;
        shell.inner_radius = core.radius = 5.0 / 16;
        x[0] += (k % 8 == 1 ? 3.0 : -3.0) / 8;
        x[1] += 4.0 / 8;
      } else
        x[UnitInt(dim)] += UnitInt(2) ? r : -r;
    }
    for (int d = 0; d < dim; d++)
      s += (x[d] - shell.center[d]) * (x[d] - shell.center[d]); /* exact: multiples of 2^-12 */
    CHECK_EQ(MPMRegionInside(&ball, dim, x) ? 1 : 0, s < ball.radius * ball.radius ? 1 : 0);
    CHECK_EQ(MPMRegionInside(&shell, dim, x) ? 1 : 0,
             s < ball.radius * ball.radius && s >= core.radius * core.radius ? 1 : 0);
    CHECK_EQ((MPMRegionInside(&core, dim, x) ? 1 : 0) + (MPMRegionInside(&shell, dim, x) ? 1 : 0),
             MPMRegionInside(&ball, dim, x) ? 1 : 0);
  }
}

/* --- Rows of places ------------------------------------------------------------------------------------------------- */

/* Checks that the spans of random rows tell of each place what MPMRegionInside does. */
static void Rows(const MPMRegion *r, int dim)
{
  PetscReal lower[3], upper[3];

  MPMRegionBounds(r, dim, lower, upper);
  for (int k = 0; k < 8; k++) {
    MPMRow    row = {.dim = dim, .spacing = UnitReal(0.01, 0.3), .offset = UnitReal(-1, 1)};
    const int d = dim - 1, first = (int)floor((lower[d] - row.offset) / row.spacing) - 2,
              end = (int)ceil((upper[d] - row.offset) / row.spacing) + 3;
    PetscInt64 to;

    for (int e = 0; e < d; e++)
      row.x[e] = UnitInt(3) ? UnitReal(lower[e], upper[e]) : UnitInt(2) ? lower[e] : 0.5 * (lower[e] + upper[e]);
    for (PetscInt64 from = first; from < end; from = to) {
      const PetscBool inside = MPMRegionSpan(r, &row, from, end, &to);

      CHECK_GE(to, from + 1);
      CHECK_LE(to, end);
      if (to <= from) return;
      for (PetscInt64 q = from; q < to; q++) {
        PetscReal x[3] = {row.x[0], row.x[1], row.x[2]};

        x[d] = MPMRowPlace(&row, q);
        CHECK_EQ(MPMRegionInside(r, dim, x), inside);
      }
    }
  }
}

/* Any shape cut by another and within a third, which is cut too. */
static void Composed(MPMRegionType type, int dim)
{
  MPMRegion  r[4];
  MPMRegion *of_first[2] = {&r[1], &r[2]}, *of_third[1] = {&r[3]};

  for (int k = 0; k < 4; k++) {
    do r[k] = Random(k ? (MPMRegionType)UnitInt(MPM_NUM_REGIONS) : type);
    while (!Has(r[k].type, dim));
    Make(&r[k], dim);
  }
  UnitContext("%s but %s and within %s but %s in %d-D", names[r[0].type], names[r[1].type], names[r[2].type],
              names[r[3].type], dim);
  Rows(&r[0], dim);
  r[0].ncut    = 1;
  r[0].nwithin = 1;
  r[0].others  = of_first;
  r[2].ncut    = 1;
  r[2].others  = of_third;
  Rows(&r[0], dim);
  for (int k = 0; k < 50; k++) {
    PetscReal x[3];
    int       in[4];

    for (int d = 0; d < dim; d++) x[d] = UnitReal(-2, 4);
    for (int q = 0; q < 4; q++) {
      MPMRegion alone = r[q];

      alone.ncut = alone.nwithin = 0;
      if (alone.type == MPM_REGION_expression) alone.context = &alone;
      in[q] = MPMRegionInside(&alone, dim, x);
    }
    CHECK_EQ(MPMRegionInside(&r[0], dim, x), in[0] && !in[1] && in[2] && !in[3]);
  }
  for (int k = 0; k < 4; k++) Drop(&r[k]);
}

/* --- Volumes and surfaces ------------------------------------------------------------------------------------------- */

/* Returns the volume of the places of a lattice with n of them on each axis of the bounds. */
static PetscReal Volume(const MPMRegion *r, int dim, int n)
{
  PetscReal lower[3], upper[3], each = 1;
  long      places = 1, inside = 0;

  MPMRegionBounds(r, dim, lower, upper);
  for (int d = 0; d < dim; d++) {
    each *= (upper[d] - lower[d]) / n;
    places *= n;
  }
  for (long k = 0; k < places; k++) {
    PetscReal x[3];

    for (long d = 0, q = k; d < dim; d++, q /= n)
      x[d] = lower[d] + ((PetscReal)(q % n) + 0.5) * (upper[d] - lower[d]) / n;
    inside += MPMRegionInside(r, dim, x) ? 1 : 0;
  }
  return (PetscReal)inside * each;
}

/* Volumes of lattices converge to the exact ones. */
static void Volumes(void)
{
  MPMRegion  r   = {.type = MPM_REGION_cylinder, .center = {1, 2, 3}, .radius = 0.5, .length = 1.25};
  MPMRegion  cut = {.type = MPM_REGION_sphere, .center = {1, 2, 3}, .radius = 0.25};
  MPMRegion *one = &cut;
  PetscReal  size;

  r.axis[0] = 2 / 7.0;
  r.axis[1] = 3 / 7.0;
  r.axis[2] = -6 / 7.0;
  UnitContext("volumes");
  CHECK_NEAR(Volume(&r, 3, 20), PETSC_PI * 0.25 * 1.25, 0.04);
  CHECK_NEAR(Volume(&r, 3, 100), PETSC_PI * 0.25 * 1.25, 0.004);
  r.ncut   = 1;
  r.others = &one;
  CHECK_NEAR(Volume(&r, 3, 100), PETSC_PI * (0.25 * 1.25 - 4.0 / 3 / 64), 0.004);
  r.ncut    = 0;
  r.nwithin = 1;
  CHECK_NEAR(Volume(&r, 3, 100), PETSC_PI * 4.0 / 3 / 64, 0.0004);
  r = (MPMRegion){.type = MPM_REGION_halfspace, .upper = {2, 1, 1}, .center = {1, 0, 0}, .axis = {0.6, 0.8, 0}};
  CHECK_NEAR(Volume(&r, 2, 400), 0.375, 0.002); /* x < 1 - 4/3 y */
  for (int round = 0; round < 2; round++) {     /* a five-pointed star, then with a square hole */
    PetscReal corner[2 * 14][2], area = 0;
    const int n = 10;

    for (int k = 0; k < n; k++)
      for (int side = 0; side < 2; side++) {
        const PetscReal a = PETSC_PI * (k + side) / 5, s = (k + side) % 2 ? 0.45 : 1;

        corner[2 * k + side][0] = (k + side) % n ? s * PetscCosReal(a) : 1;
        corner[2 * k + side][1] = (k + side) % n ? s * PetscSinReal(a) : 0;
      }
    for (int k = 0; k < 4; k++)
      for (int side = 0; side < 2; side++) {
        corner[2 * (n + k) + side][0] = (k + side) % 4 == 1 || (k + side) % 4 == 2 ? 0.1 : -0.1;
        corner[2 * (n + k) + side][1] = (k + side) % 4 > 1 ? 0.1 : -0.1;
      }
    for (int k = 0; k < n; k++)
      area += 0.5 * (corner[2 * k][0] * corner[2 * k + 1][1] - corner[2 * k][1] * corner[2 * k + 1][0]);
    memset(&r, 0, sizeof r);
    r.type    = MPM_REGION_polygon;
    r.surface = MPMSurfaceCreate(2, n + (round ? 4 : 0), corner[0]);
    for (int d = 0; d < 2; d++) {
      r.lower[d] = r.surface->lower[d];
      r.upper[d] = r.surface->upper[d];
    }
    r.upper[2] = 0.5;
    size       = area - (round ? 0.04 : 0);
    CHECK_NEAR(Volume(&r, 2, 400), size, 0.01);
    CHECK_NEAR(Volume(&r, 3, 80), 0.5 * size, 0.02);
    Drop(&r);
  }
}

/* A ball of triangles: the faces of an octahedron are divided `times` times into four, and their corners put on a
   sphere around c. Corners are sums of those before, so faces share theirs to the last bit. */
static int Divide(int times, const PetscReal a[], const PetscReal b[], const PetscReal c[], PetscReal *corner, int n)
{
  PetscReal m[3][3];

  if (!times) {
    memcpy(corner + 9 * n, a, 3 * sizeof *a);
    memcpy(corner + 9 * n + 3, b, 3 * sizeof *a);
    memcpy(corner + 9 * n + 6, c, 3 * sizeof *a);
    return n + 1;
  }
  for (int k = 0; k < 3; k++) {
    const PetscReal *p = k == 0 ? a : k == 1 ? b : c, *q = k == 0 ? b : k == 1 ? c : a;
    PetscReal        s = 0;

    for (int d = 0; d < 3; d++) {
      m[k][d] = p[d] + q[d];
      s += m[k][d] * m[k][d];
    }
    for (int d = 0; d < 3; d++) m[k][d] /= PetscSqrtReal(s);
  }
  n = Divide(times - 1, a, m[0], m[2], corner, n);
  n = Divide(times - 1, b, m[1], m[0], corner, n);
  n = Divide(times - 1, c, m[2], m[1], corner, n);
  return Divide(times - 1, m[0], m[1], m[2], corner, n);
}

/* No line slips through a closed surface, not even one through a corner or along an edge; and the places inside are
   those of the ball, but for what is cut off between it and its triangles. */
static void Sphere(int times)
{
  static PetscReal corner[9 * 8 * 256];
  MPMSurface      *s;
  int              n = 0;

  for (int k = 0; k < 8; k++) {
    PetscReal p[3][3] = {{0}};

    for (int d = 0; d < 3; d++) p[d][d] = k >> d & 1 ? 1 : -1;
    n = Divide(times, p[0], p[1], p[2], corner, n);
  }
  UnitContext("ball of %d triangles", n);
  s = MPMSurfaceCreate(3, n, corner);
  for (int k = 0; k < 20000; k++) {
    const PetscReal *a = corner + 3 * UnitInt(3 * n), *b = corner + 9 * UnitInt(n),
                    w = UnitInt(2) ? 0.5 : UnitReal(0, 1);
    PetscReal x[3], q = 0;
    PetscInt  below;

    for (int d = 0; d < 3; d++) {
      x[d] = UnitReal(-1.1, 1.1);
      if (k % 4 == 1) x[d] = a[d];                         /* a corner */
      if (k % 4 == 2) x[d] = b[d] + w * (b[3 + d] - b[d]); /* on an edge */
      if (k % 4 == 3) x[d] = UnitInt(2) ? a[d] : b[d];     /* the x of one, the y of another */
      q += x[d] * x[d];
    }
    CHECK_EQ(MPMSurfaceLine(s, x) % 2, 0);
    below = MPMSurfaceBelow(s, x[2]);
    if (q > 1 + 1e-12) CHECK_EQ(below % 2, 0);
    if (times == 4 && q < 0.98) CHECK_EQ(below % 2, 1);
    if (times == 0 && k % 4 == 0) /* the octahedron itself */
      CHECK_EQ(below % 2, PetscAbsReal(x[0]) + PetscAbsReal(x[1]) + PetscAbsReal(x[2]) < 1);
  }
  MPMSurfaceDestroy(&s);
}

int main(void)
{
  Volumes();
  for (int times = 0; times <= 4; times++) Sphere(times);
  for (int dim = 1; dim <= 3; dim++)
    for (int round = 0; round < 50; round++) {
      for (int type = 0; type < MPM_NUM_REGIONS; type++) {
        if (!Has((MPMRegionType)type, dim)) continue;
        AnyShape((MPMRegionType)type, dim);
        Solid((MPMRegionType)type, dim);
        Composed((MPMRegionType)type, dim);
      }
      Box(dim);
      Round(dim);
    }
  return UnitEnd();
}
