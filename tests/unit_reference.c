/* unit_reference.c - every row of reference.def is a solution: rho (u_tt - b - g) = Div P(F), with F, Div and u_tt by
   differences of eighth order of its displacement and P from laws that are written here again; its velocity and F are
   the derivatives of its displacement; walls and free surfaces are met; scenes that do not fit are refused.

   A new row needs its scene in Scene(). */
#include "known/reference.h"
#include "unit.h"

typedef void (*Values)(const MPMReferenceData *, const PetscReal X[], PetscReal t, PetscReal value[]);

/* The scene of a row, with random numbers; false if the row has none in this dimension. */
static int Scene(const MPMReference *row, int dim, MPMReferenceData *d)
{
  const char *name = row->name;
  double      L    = 3;

  memset(d, 0, sizeof *d);
  d->dim    = dim;
  d->model  = "neohookean";
  d->shape  = MPM_REGION_box;
  d->nu     = UnitReal(-0.2, 0.45);
  d->period = UnitReal(0.5, 2);
  d->mode   = 1 + UnitInt(3);
  for (int e = 0; e < 3; e++) {
    d->grid_lower[e] = d->lower[e] = UnitReal(-2, 2);
    d->grid_upper[e] = d->upper[e] = d->lower[e] + UnitReal(1, 3);
    d->walls[e][0] = d->walls[e][1] = UnitInt(2) ? MPM_WALL_slip : MPM_WALL_periodic;
    if (e < dim) L = fmin(L, d->upper[e] - d->lower[e]);
  }
  d->amplitude = L * UnitReal(0.02, 0.1);
  if (!strcmp(name, "axis")) {
    if (dim == 1) d->walls[0][0] = d->walls[0][1] = MPM_WALL_fixed;
  } else if (!strcmp(name, "bar")) {
    if (UnitInt(2)) d->model = "elastic";
    if (UnitInt(2)) d->walls[0][0] = d->walls[0][1] = MPM_WALL_fixed;
  } else if (!strcmp(name, "vortex") || !strcmp(name, "ring")) {
    const int ring = name[0] == 'r';

    if (dim == 1 || (dim == 3 && !ring)) return 0;
    d->shape        = MPM_REGION_annulus;
    d->inner_radius = UnitReal(0.4, 0.8);
    d->radius       = d->inner_radius + UnitReal(0.3, 0.6);
    d->amplitude    = ring ? 0.05 : UnitReal(0.3, 0.8);
    if (ring) d->nu = 0;
    for (int e = 0; e < 3; e++) {
      d->center[e]     = UnitReal(-1, 1);
      d->grid_lower[e] = d->center[e] - 1.5;
      d->grid_upper[e] = d->center[e] + 1.5;
      d->lower[e]      = d->center[e] - d->radius;
      d->upper[e]      = d->center[e] + d->radius;
      d->walls[e][0] = d->walls[e][1] = MPM_WALL_free;
    }
  } else if (!strcmp(name, "shear")) {
    if (dim == 1) return 0;
    if (UnitInt(2)) d->model = "elastic";
    d->walls[0][0] = d->walls[0][1] = MPM_WALL_periodic;
    d->walls[1][0] = d->walls[1][1] = MPM_WALL_fixed;
  } else if (!strcmp(name, "standing")) {
    d->model       = "elastic";
    d->walls[0][0] = UnitInt(2) ? MPM_WALL_fixed : MPM_WALL_slip;
    d->walls[0][1] = UnitInt(2) ? MPM_WALL_fixed : MPM_WALL_slip;
  } else if (!strcmp(name, "mode") || !strcmp(name, "column")) {
    const int axis = name[0] == 'm' ? 0 : UnitInt(dim);

    d->model            = "elastic";
    d->walls[axis][0]   = UnitInt(2) ? MPM_WALL_fixed : MPM_WALL_slip;
    d->walls[axis][1]   = MPM_WALL_free;
    d->grid_upper[axis] = d->upper[axis] + UnitReal(0, 1);
    if (name[0] == 'c') d->gravity[axis] = -1;
    if (UnitInt(2)) { /* sides that nothing holds */
      d->nu = 0;
      for (int e = 0; e < dim; e++)
        if (e != axis) {
          d->walls[e][0] = d->walls[e][1] = MPM_WALL_free;
          d->grid_upper[e] += 1;
          d->grid_lower[e] -= 1;
        }
    }
  } else
    return 0;
  d->rho    = UnitReal(0.5, 2);
  d->E      = UnitReal(5, 20);
  d->lambda = d->E * d->nu / ((1 + d->nu) * (1 - 2 * d->nu));
  d->mu     = d->E / (2 * (1 + d->nu));
  d->c      = sqrt(d->E / d->rho);
  d->cp     = sqrt((d->lambda + 2 * d->mu) / d->rho);
  for (int e = 0; e < dim; e++) d->gravity[e] *= UnitReal(0.01, 0.3) * d->cp * d->cp / (d->upper[e] - d->lower[e]);
  return 1;
}

/* The smallest length of the body. */
static double Length(const MPMReferenceData *d)
{
  double L = d->upper[0] - d->lower[0];

  if (d->shape == MPM_REGION_annulus) return d->radius - d->inner_radius;
  for (int e = 1; e < d->dim; e++) L = fmin(L, d->upper[e] - d->lower[e]);
  return L;
}

static double LengthStep(const MPMReferenceData *d)
{
  return 0.004 * Length(d);
}

static double TimeStep(const MPMReferenceData *d)
{
  return 0.004 * fmin(Length(d) / d->cp, d->period);
}

/* A particle inside the body, a tenth off its faces, and a time of the first periods; off the fronts of column's wave.
 */
static void Inside(const MPMReferenceData *d, const MPMReference *row, PetscReal X[3], PetscReal *t)
{
  double R = 0;
  int    again;

  *t = UnitReal(0.1, 5) * fmin(Length(d) / d->cp, d->period);
  do {
    again = 0;
    for (int e = 0; e < 3; e++) X[e] = d->lower[e] + UnitReal(0.1, 0.9) * (d->upper[e] - d->lower[e]);
    if (d->shape == MPM_REGION_annulus) {
      for (int e = 0; e < d->dim; e++) X[e] = UnitReal(-1, 1);
      R = 0;
      for (int e = 0; e < d->dim; e++) R += X[e] * X[e];
      R     = sqrt(R);
      again = R < 0.1;
      if (!again) {
        const double r = d->inner_radius + UnitReal(0.05, 0.95) * (d->radius - d->inner_radius);
        for (int e = 0; e < d->dim; e++) X[e] = d->center[e] + r * X[e] / R;
      }
    }
    if (!strcmp(row->name, "column"))
      for (int e = 0; e < d->dim; e++) {
        const double L = d->upper[e] - d->lower[e], s = X[e] - d->lower[e];
        if (d->gravity[e] == 0) continue;
        again = fabs(remainder(s - d->cp * *t, 2 * L)) < 0.05 * L || fabs(remainder(s + d->cp * *t, 2 * L)) < 0.05 * L;
        if (again) *t = UnitReal(0.1, 5) * L / d->cp;
      }
  } while (again);
}

/* Central difference of eighth order of n values: by X[axis] if axis >= 0, else by t. */
static void Difference(const MPMReferenceData *d, Values f, int n, const PetscReal X[3], PetscReal t, int axis,
                       double out[])
{
  static const double weight[4] = {4. / 5, -1. / 5, 4. / 105, -1. / 280};
  const double        h         = axis < 0 ? TimeStep(d) : LengthStep(d);

  for (int k = 0; k < n; k++) out[k] = 0;
  for (int j = 1; j <= 4; j++)
    for (int side = -1; side <= 1; side += 2) {
      PetscReal Y[3] = {X[0], X[1], X[2]}, value[9];
      if (axis >= 0) Y[axis] += side * j * h;
      f(d, Y, axis < 0 ? t + side * j * h : t, value);
      for (int k = 0; k < n; k++) out[k] += side * weight[j - 1] * value[k] / h;
    }
}

/* First Piola stress P [dim*dim] for F [dim*dim], through the Cauchy stress, in 3-D. */
static void Piola(const MPMReferenceData *d, const double F[], double P[])
{
  double f[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, inverse[3][3], sig[3][3], J = 0, trace = 0;

  for (int i = 0; i < d->dim; i++)
    for (int j = 0; j < d->dim; j++) f[i][j] = F[i * d->dim + j];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const int a = (i + 1) % 3, b = (i + 2) % 3, k = (j + 1) % 3, l = (j + 2) % 3;
      inverse[j][i] = f[a][k] * f[b][l] - f[a][l] * f[b][k]; /* the cofactor of ij */
    }
  for (int j = 0; j < 3; j++) J += f[0][j] * inverse[j][0];
  for (int i = 0; i < 3; i++) trace += f[i][i] - 1;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double b = 0;
      for (int k = 0; k < 3; k++) b += f[i][k] * f[j][k];
      sig[i][j] = !strcmp(d->model, "elastic")
                      ? d->mu * (f[i][j] + f[j][i] - 2 * (i == j)) + d->lambda * trace * (i == j)
                      : (d->mu * (b - (i == j)) + d->lambda * log(J) * (i == j)) / J;
    }
  for (int i = 0; i < d->dim; i++)
    for (int j = 0; j < d->dim; j++) {
      P[i * d->dim + j] = 0; /* J sig F^-T, and J F^-1 is the transposed cofactors */
      for (int k = 0; k < 3; k++) P[i * d->dim + j] += sig[i][k] * inverse[j][k];
    }
}

/* The row whose displacement Stress differentiates. */
static const MPMReference *current;

static void Stress(const MPMReferenceData *d, const PetscReal X[], PetscReal t, PetscReal P[])
{
  double F[9];

  for (int j = 0; j < d->dim; j++) {
    double column[3];
    Difference(d, current->displacement, d->dim, X, t, j, column);
    for (int i = 0; i < d->dim; i++) F[i * d->dim + j] = column[i] + (i == j);
  }
  Piola(d, F, P);
}

static void Zero(const MPMReferenceData *d, const PetscReal X[], PetscReal t, PetscReal b[])
{
  (void)X;
  (void)t;
  for (int e = 0; e < d->dim; e++) b[e] = 0;
}

/* |u_tt - b - g - Div P/rho| with this body force, over its largest term: the worst of some particles. */
static double Unbalance(const MPMReferenceData *d, const MPMReference *row, Values force)
{
  double worst = 0, scale = 0;

  current = row;
  for (int round = 0; round < 40; round++) {
    PetscReal X[3], t, b[3] = {0};
    double    a[3], rest[3], dP[9];

    Inside(d, row, X, &t);
    force(d, X, t, b);
    Difference(d, row->velocity, d->dim, X, t, -1, a);
    for (int i = 0; i < d->dim; i++) rest[i] = a[i] - b[i] - d->gravity[i];
    for (int j = 0; j < d->dim; j++) {
      Difference(d, Stress, d->dim * d->dim, X, t, j, dP);
      for (int i = 0; i < d->dim; i++) rest[i] -= dP[i * d->dim + j] / d->rho;
    }
    for (int i = 0; i < d->dim; i++) {
      worst = fmax(worst, fabs(rest[i]));
      if (isnan(rest[i])) return NAN;
      scale = fmax(scale, fmax(fabs(a[i]), fabs(b[i])));
    }
  }
  return worst / scale;
}

/* velocity and deformation are derivatives of displacement. */
static void Derivatives(const MPMReferenceData *d, const MPMReference *row)
{
  double wrong_v = 0, wrong_F = 0, largest = 0;

  for (int round = 0; round < 40; round++) {
    PetscReal X[3], t, v[3], F[9];
    double    out[3];

    Inside(d, row, X, &t);
    row->velocity(d, X, t, v);
    row->deformation(d, X, t, F);
    Difference(d, row->displacement, d->dim, X, t, -1, out);
    for (int i = 0; i < d->dim; i++) {
      wrong_v = fmax(wrong_v, isnan(v[i]) ? INFINITY : fabs(v[i] - out[i]));
      largest = fmax(largest, fabs(v[i]));
    }
    for (int j = 0; j < d->dim; j++) {
      Difference(d, row->displacement, d->dim, X, t, j, out);
      for (int i = 0; i < d->dim; i++) {
        const double wrong = fabs(F[i * d->dim + j] - (i == j) - out[i]);
        wrong_F            = fmax(wrong_F, isnan(wrong) ? INFINITY : wrong);
      }
    }
  }
  CHECK(largest > 0);
  CHECK_LE(wrong_v, 1e-9 * largest);
  CHECK_LE(wrong_F, 1e-9);
}

/* Walls that the body touches: nothing moves through them; nothing moves at fixed ones, and slip ones bear no shear;
   periodic ones are alike. A free face bears no stress, nor do the rims of an annulus. */
static void Walls(const MPMReferenceData *d, const MPMReference *row)
{
  const double small = 1e-13 * (d->shape == MPM_REGION_annulus ? 1 : d->amplitude + 1);

  for (int round = 0; round < 20; round++)
    for (int axis = 0; axis < d->dim; axis++)
      for (int side = 0; side < 2; side++) {
        const MPMWall wall = d->walls[axis][side];
        PetscReal     X[3], Y[3], t, u[3], v[3], F[9], P[9], other[9];

        Inside(d, row, X, &t);
        if (d->shape == MPM_REGION_annulus) {
          double R = 0, n[3];
          for (int e = 0; e < d->dim; e++) R += (X[e] - d->center[e]) * (X[e] - d->center[e]);
          for (int e = 0; e < d->dim; e++) {
            n[e] = (X[e] - d->center[e]) / sqrt(R);
            X[e] = d->center[e] + (side ? d->radius : d->inner_radius) * n[e];
          }
          row->deformation(d, X, t, F);
          Piola(d, F, P);
          for (int i = 0; i < d->dim; i++) {
            double traction = 0;
            for (int j = 0; j < d->dim; j++) traction += P[i * d->dim + j] * n[j];
            CHECK_LE(fabs(traction), 1e-12 * d->E);
          }
          row->displacement(d, X, t, u);
          if (!strcmp(row->name, "vortex"))
            for (int i = 0; i < d->dim; i++) CHECK_LE(fabs(u[i]), small);
          continue;
        }
        X[axis] = side ? d->upper[axis] : d->lower[axis];
        row->displacement(d, X, t, u);
        row->velocity(d, X, t, v);
        row->deformation(d, X, t, F);
        Piola(d, F, P);
        for (int i = 0; i < d->dim; i++) {
          if (wall == MPM_WALL_fixed || (wall == MPM_WALL_slip && i == axis)) {
            CHECK_LE(fabs(u[i]), small);
            CHECK_LE(fabs(v[i]), small * d->cp / Length(d));
          }
          if (wall == MPM_WALL_free || (wall == MPM_WALL_slip && i != axis))
            CHECK_LE(fabs(P[i * d->dim + axis]), 1e-12 * d->E);
        }
        if (wall != MPM_WALL_periodic) continue;
        memcpy(Y, X, sizeof Y);
        Y[axis] = side ? d->lower[axis] : d->upper[axis];
        row->displacement(d, Y, t, other);
        for (int i = 0; i < d->dim; i++) CHECK_LE(fabs(u[i] - other[i]), small);
        row->deformation(d, Y, t, other);
        for (int i = 0; i < d->dim * d->dim; i++) CHECK_LE(fabs(F[i] - other[i]), 1e-12);
      }
}

/* At t = 0 all are at their place, but for those that their comment says start stretched. */
static void Start(const MPMReferenceData *d, const MPMReference *row)
{
  const int stretched = !strcmp(row->name, "bar") || (!strcmp(row->name, "axis") && d->dim == 3);
  double    most      = 0;

  for (int round = 0; round < 10; round++) {
    PetscReal X[3], t, u[3], F[9];

    Inside(d, row, X, &t);
    row->displacement(d, X, 0, u);
    row->deformation(d, X, 0, F);
    for (int i = 0; i < d->dim; i++) most = fmax(most, fabs(u[i]));
    if (!stretched)
      for (int i = 0; i < d->dim * d->dim; i++) CHECK_LE(fabs(F[i] - (i % (d->dim + 1) == 0)), 1e-15);
  }
  if (stretched)
    CHECK_GE(most, 1e-3 * d->amplitude);
  else
    CHECK_LE(most, 1e-15 * (1 + d->amplitude));
}

/* What is refused: each a scene that fits, but for one thing. */
static void Refused(const MPMReference *row, const MPMReferenceData *d)
{
  const char *why = row->check(d);

  CHECK(why && !strncmp(why, "needs ", 6) && strlen(why) < 120 && !strchr(why, '\n'));
}

static void Refusals(const MPMReferenceData *fits, const MPMReference *row)
{
  const int        annulus = fits->shape == MPM_REGION_annulus;
  MPMReferenceData d;

  d       = *fits;
  d.model = "fluid";
  Refused(row, &d);
  d       = *fits;
  d.shape = MPM_REGION_sphere;
  Refused(row, &d);
  d            = *fits;
  d.gravity[0] = 1;
  Refused(row, &d);
  d           = *fits;
  d.amplitude = 100;
  if (strstr(row->parameters, "amplitude") && strcmp(row->name, "vortex") && strcmp(row->name, "shear"))
    Refused(row, &d);
  d      = *fits;
  d.mode = 0;
  if (strstr(row->parameters, "mode")) Refused(row, &d);
  d        = *fits;
  d.period = 0;
  if (strstr(row->parameters, "period")) Refused(row, &d);
  for (int e = 0; e < fits->dim; e++) {
    const int held = !annulus && (fits->walls[e][0] != MPM_WALL_free);

    d             = *fits;
    d.walls[e][0] = d.walls[e][1] = MPM_WALL_separate;
    if (!annulus) Refused(row, &d);
    d = *fits;
    d.grid_lower[e] -= 0.1; /* no longer fills the grid */
    if (held && fits->nu != 0) Refused(row, &d);
    d               = *fits;
    d.grid_upper[e] = d.center[e] + 0.99 * d.radius;
    if (annulus) Refused(row, &d);
  }
}

/* The body force with its sign turned: every manufactured row must fail with it. */
static void Turned(const MPMReferenceData *d, const PetscReal X[], PetscReal t, PetscReal b[])
{
  current->acceleration(d, X, t, b);
  for (int e = 0; e < d->dim; e++) b[e] = -b[e];
}

/* The vortex' body force as public codes print it, components at the angle of the particle at rest; sign of R (g' h)^2
   in the one across: +1 as they have it, which is wrong, -1 as it must be. */
static void Printed(const MPMReferenceData *d, const PetscReal X[], PetscReal t, int sign, PetscReal b[])
{
  const double D = d->radius - d->inner_radius, m = d->mu / d->rho, w = M_PI / d->period;
  const double x = X[0] - d->center[0], y = X[1] - d->center[1], R = hypot(x, y);
  const double s = (R - (d->radius + d->inner_radius) / 2) / D;
  const double h = 1 - 8 * s * s + 16 * s * s * s * s, h1 = (-16 * s + 64 * s * s * s) / D;
  const double h2 = (-16 + 192 * s * s) / (D * D), g = d->amplitude * sin(w * t), g1 = d->amplitude * w * cos(w * t);
  const double alpha = g * h, force = m * (3 * g * h1 + R * g * h2) + R * w * w * g * h;
  const double br = force * sin(alpha) + (m * R * g * g * h1 * h1 - R * g1 * g1 * h * h) * cos(alpha);
  const double bt = -force * cos(alpha) + (m * R * g * g * h1 * h1 + sign * R * g1 * g1 * h * h) * sin(alpha);

  b[0] = (br * x - bt * y) / R;
  b[1] = (br * y + bt * x) / R;
}

static void PrintedWrong(const MPMReferenceData *d, const PetscReal X[], PetscReal t, PetscReal b[])
{
  Printed(d, X, t, 1, b);
}

static void PrintedRight(const MPMReferenceData *d, const PetscReal X[], PetscReal t, PetscReal b[])
{
  Printed(d, X, t, -1, b);
}

/* The force across turned, at the angle as it is now. */
static void AcrossTurned(const MPMReferenceData *d, const PetscReal X[], PetscReal t, PetscReal b[])
{
  PetscReal u[2], x, y, bt;

  current->acceleration(d, X, t, b);
  current->displacement(d, X, t, u);
  x  = X[0] + u[0] - d->center[0];
  y  = X[1] + u[1] - d->center[1];
  bt = (b[1] * x - b[0] * y) / (x * x + y * y);
  b[0] += 2 * bt * y;
  b[1] -= 2 * bt * x;
}

/* Values of the formulas of an independent set-up (bar1d, mms2d, vortex), evaluated by Python. */
static void Setups(void)
{
  MPMReferenceData    d = {.dim = 1, .upper = {25}, .rho = 1, .E = 100, .mu = 50, .c = 10, .cp = 10, .mode = 1};
  const MPMReference *row;
  PetscReal           X[2], got[2];

  UnitContext("fixedfree of setups.json");
  d.model     = "elastic";
  d.amplitude = 0.1 / (M_PI / 50 * 10);
  row         = MPMReferenceFind("mode");
  X[0]        = 7.3;
  row->displacement(&d, X, 1.9, got);
  CHECK_NEAR(got[0], 0.06551870938503931, 1e-15);
  row->velocity(&d, X, 0, got);
  CHECK_NEAR(got[0], 0.044275823103890145, 1e-15);

  UnitContext("mms2d of setups.json");
  d = (MPMReferenceData){.dim = 2, .upper = {1, 1}, .rho = 1000, .E = 1e7, .nu = 0.3, .c = 100, .amplitude = 0.05};
  d.lambda = 5769230.769230769;
  d.mu     = 3846153.846153846;
  d.model  = "neohookean";
  row      = MPMReferenceFind("axis");
  X[0]     = 0.13;
  X[1]     = 0.71;
  row->displacement(&d, X, 0.0037, got);
  CHECK_NEAR(got[0], 0.033450716489725155, 1e-15);
  CHECK_NEAR(got[1], 0.044446083824270705, 1e-15);
  row->acceleration(&d, X, 0.0037, got);
  CHECK_NEAR(got[0] / 9309.281353029928, 1, 1e-12);
  CHECK_NEAR(got[1] / 14853.748083677332, 1, 1e-12);
  row->velocity(&d, X, 0, got);
  CHECK_NEAR(got[0] / 11.450612423022708, 1, 1e-13);
  CHECK_NEAR(got[1] / 15.214468716962429, 1, 1e-13);

  UnitContext("vortex of setups.json");
  d              = (MPMReferenceData){.dim = 2, .rho = 1000, .E = 1000, .nu = 0.3, .amplitude = 0.1, .period = 1};
  d.inner_radius = 0.75;
  d.radius       = 1.25;
  d.mu           = 384.6153846153846;
  d.model        = "neohookean";
  row            = MPMReferenceFind("vortex");
  X[0]           = 0.6;
  X[1]           = -0.7;
  row->displacement(&d, X, 0.21, got);
  CHECK_NEAR(got[0], 0.03418628317179839, 1e-15);
  CHECK_NEAR(got[1], 0.030815602216594296, 1e-15);
  row->acceleration(&d, X, 0.21, got);
  CHECK_NEAR(got[0] / 0.14595888705685553, 1, 1e-12);
  CHECK_NEAR(got[1] / 0.15296362889152884, 1, 1e-12);
  row->velocity(&d, X, 0, got);
  CHECK_NEAR(got[0] / 0.17913605600289118, 1, 1e-12);
  CHECK_NEAR(got[1] / 0.153545190859621, 1, 1e-12);
}

int main(void)
{
  for (const MPMReference *row = MPMReferences; row->name; row++) {
    int scenes = 0;

    CHECK(MPMReferenceFind(row->name) == row && strlen(row->what) > 0);
    CHECK_EQ(!row->manufactured, !row->acceleration);
    for (int dim = 1; dim <= 3; dim++)
      for (int round = 0; round < 25; round++) {
        MPMReferenceData d;
        const char      *why;

        if (!Scene(row, dim, &d)) continue;
        scenes++;
        why = row->check(&d);
        UnitContext("%s in %d-D, %s, nu %g: %s", row->name, dim, d.model, d.nu, why ? why : "fits");
        CHECK(!why);
        Derivatives(&d, row);
        CHECK_LE(Unbalance(&d, row, row->acceleration ? row->acceleration : Zero), 1e-8);
        Walls(&d, row);
        Start(&d, row);
        Refusals(&d, row);
        if (row->acceleration) CHECK_GE(Unbalance(&d, row, Turned), 0.1);
        if (!strcmp(row->name, "vortex")) {
          CHECK_LE(Unbalance(&d, row, PrintedRight), 1e-8);
          CHECK_GE(Unbalance(&d, row, PrintedWrong), 1e-4);
          CHECK_GE(Unbalance(&d, row, AcrossTurned), 0.1);
        }
      }
    UnitContext("%s", row->name);
    CHECK(scenes > 0); /* a new row needs its scene in Scene() */
  }
  CHECK(!MPMReferenceFind("nosuch"));
  Setups();
  return UnitEnd();
}
