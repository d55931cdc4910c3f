/* unit_region.c - the shapes of region.def: their bounds hold them and are tight, they move with their numbers, and
   their half-open borders share places out without a gap or an overlap. */
#include "physics/region.h"
#include "unit.h"

static const char *names[] = {
#define MPM_REGION(name, solid, parameters, what) #name,
#include "physics/region.def"
#undef MPM_REGION
};

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
  }
  r.radius       = (16 + UnitInt(128)) / 64.0;
  r.inner_radius = UnitInt(13) / 16.0 * r.radius;
  return r;
}

/* For every row of the table. */
static void AnyShape(MPMRegionType type, int dim)
{
  const MPMRegion r = Random(type);
  MPMRegion       moved;
  PetscReal       lower[3], upper[3], shift[3], least[3], most[3];
  long            inside = 0;

  UnitContext("%s in %d-D", names[type], dim);
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
  for (int d = 0; d < dim; d++) { /* nothing to spare on any side */
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

int main(void)
{
  for (int dim = 1; dim <= 3; dim++)
    for (int round = 0; round < 50; round++) {
      for (int type = 0; type < MPM_NUM_REGIONS; type++) {
        AnyShape((MPMRegionType)type, dim);
        Solid((MPMRegionType)type, dim);
      }
      Box(dim);
      Round(dim);
    }
  return UnitEnd();
}
