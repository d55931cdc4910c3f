/* The assignment's serial program written literally: its three structs, its steps 1-12 in its order, and its nodal
   sums taken node by node over the points of the four cells around the node. 2-D plane strain, linear basis, stress
   before forces (USF), FLIP. It shares no line with Pebble and needs only libc and libm: the two check each other. The
   names are the assignment's: a point here is what Pebble calls a particle.

   seed_serial [name=value ...], the first value being the default:
     setup=disks|block  material=neohookean|elastic  walls=free|fixed  cells=20  ppc=4 (points a cell and direction)
     steps=500  dt=0.006 (block: 0.2 h/c)  gravity=0 (along y)  time=0|1 (print ns per particle-step)
     out=FILE: one line a point, id x y vx vy F00 F01 F10 F11 sxx sxy syx syy

   Equation numbers: Steffen, Kirby and Berzins, Int. J. Numer. Meth. Engng 76 (2008) 922-948. Where the assignment
   is silent or contradicts them, the step says what is chosen. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define MAX_POINTS 1000 /* of one cell: the assignment's fixed array */

struct material {
  double x, y;   // position
  double ux, uy; // displacement
  double vx, vy; // velocity
  double grad_velocity[2][2];
  double ax, ay; // acceleration
  double mass;
  double vol;                        // current volume, of unit thickness
  double basis_fn[4];                // basis functions of the 4 nodes of the point's cell
  double grad_x_basis_fn[4];         // their derivatives with respect to x
  double grad_y_basis_fn[4];         // their derivatives with respect to y
  double stress[2][2];               // Cauchy
  double change_Fp[2][2];            // change in deformation gradient
  double Fp[2][2];                   // deformation gradient, F33 = 1
  int    cell_i, cell_j;             // the containing cell
  double E;                          // Young's modulus
  double body_force_x, body_force_y; // per unit mass
};

struct IJ {
  int x, y; // place in the 2-D array of points: lattice column (of the bodies one after the other), point within it
};

struct mesh {                        // a cell and its node 0, the lower left one
  double    x, y;                    // position of node 0
  struct IJ points_list[MAX_POINTS]; // the points contained in the cell
  int       num_points;
  double    f_int_x, f_int_y; // internal force
  double    f_ext_x, f_ext_y; // external force
  double    a_x, a_y;         // acceleration
  double    v_x, v_y;         // velocity
  double    node_mass;
};

struct seed {
  int              cells, ppc, steps, elastic, block, fixed, timed;
  double           h, b, dt, gravity, rho, nu; // spacings of mesh and points, density, Poisson's ratio
  const char      *out;
  struct mesh     *mesh;   // (cells+1)^2 nodes; the last row and column are nodes only
  struct material *points; // the 2-D array, read straight through in id order; column c begins at points[column[c]]
  int             *column;
  int              num_nodes, num_columns, num_points;
};

/* Nodes 0..3 of a cell, counter-clockwise from the lower left. */
static const int node_x[4] = {0, 1, 1, 0}, node_y[4] = {0, 0, 1, 1};

#define FAIL(...) (fprintf(stderr, "seed_serial: " __VA_ARGS__), fputc('\n', stderr), exit(1))

static struct mesh *mesh_at(const struct seed *s, int i, int j)
{
  return &s->mesh[j * (s->cells + 1) + i];
}

/* Node a of the point's cell. */
static struct mesh *point_node(const struct seed *s, const struct material *p, int a)
{
  return mesh_at(s, p->cell_i + node_x[a], p->cell_j + node_y[a]);
}

/* The cell whose node a is node n, one of the assignment's A, B, C, D; NULL outside the mesh. */
static const struct mesh *cell_around(const struct seed *s, int n, int a)
{
  const int i = n % (s->cells + 1) - node_x[a], j = n / (s->cells + 1) - node_y[a];
  return i < 0 || j < 0 || i == s->cells || j == s->cells ? NULL : mesh_at(s, i, j);
}

static const struct material *listed_point(const struct seed *s, const struct mesh *cell, int k)
{
  return &s->points[s->column[cell->points_list[k].x] + cell->points_list[k].y];
}

static int is_fixed(const struct seed *s, int n)
{
  const int i = n % (s->cells + 1), j = n / (s->cells + 1);
  return s->fixed && (i == 0 || j == 0 || i == s->cells || j == s->cells);
}

/* A point on a cell line belongs to the cell above it, on the upper wall to the last cell. */
static int containing_cell(const struct seed *s, double x)
{
  const int i = (int)floor(x / s->h);
  return i < s->cells ? i : s->cells - 1;
}

/* Step 1: which point is in which cell. The comparison is so written that it refuses NaN too. */
static void find_cells(struct seed *s)
{
  const double length = s->cells * s->h;
  for (int n = 0; n < s->num_nodes; n++) s->mesh[n].num_points = 0;
  for (int c = 0; c < s->num_columns; c++) {
    for (int k = s->column[c]; k < s->column[c + 1]; k++) {
      struct material *p = &s->points[k];
      if (!(p->x >= 0 && p->x <= length && p->y >= 0 && p->y <= length))
        FAIL("point %d left the grid at (%g, %g)", k, p->x, p->y);
      p->cell_i         = containing_cell(s, p->x);
      p->cell_j         = containing_cell(s, p->y);
      struct mesh *cell = mesh_at(s, p->cell_i, p->cell_j);
      if (cell->num_points == MAX_POINTS)
        FAIL("cell (%d, %d) holds more than %d points", p->cell_i, p->cell_j, MAX_POINTS);
      cell->points_list[cell->num_points++] = (struct IJ){c, k - s->column[c]};
    }
  }
}

/* Step 2: basis functions, eq. (14) in each direction. */
static void basis_functions(struct seed *s)
{
  for (struct material *p = s->points; p < s->points + s->num_points; p++) {
    const double x = p->x / s->h - p->cell_i, y = p->y / s->h - p->cell_j;
    for (int a = 0; a < 4; a++) p->basis_fn[a] = (node_x[a] ? x : 1 - x) * (node_y[a] ? y : 1 - y);
  }
}

/* Step 3: mass of each node, eq. (1). */
static void node_masses(struct seed *s)
{
  for (int n = 0; n < s->num_nodes; n++) {
    struct mesh *node = &s->mesh[n];
    node->node_mass   = 0;
    for (int a = 0; a < 4; a++) {
      const struct mesh *cell = cell_around(s, n, a);
      for (int k = 0; cell && k < cell->num_points; k++) {
        const struct material *p = listed_point(s, cell, k);
        node->node_mass += p->basis_fn[a] * p->mass;
      }
    }
  }
}

/* Step 4: velocity of each node, eq. (2). Any mass counts, however small: a threshold would lose momentum. */
static void node_velocities(struct seed *s)
{
  for (int n = 0; n < s->num_nodes; n++) {
    struct mesh *node = &s->mesh[n];
    node->v_x = node->v_y = 0;
    for (int a = 0; a < 4; a++) {
      const struct mesh *cell = cell_around(s, n, a);
      for (int k = 0; cell && k < cell->num_points; k++) {
        const struct material *p = listed_point(s, cell, k);
        node->v_x += p->basis_fn[a] * p->mass * p->vx;
        node->v_y += p->basis_fn[a] * p->mass * p->vy;
      }
    }
    const int moves = node->node_mass > 0 && !is_fixed(s, n);
    node->v_x       = moves ? node->v_x / node->node_mass : 0;
    node->v_y       = moves ? node->v_y / node->node_mass : 0;
  }
}

/* Step 5: gradients of the basis functions, eq. (15) in each direction. */
static void basis_gradients(struct seed *s)
{
  for (struct material *p = s->points; p < s->points + s->num_points; p++) {
    const double x = p->x / s->h - p->cell_i, y = p->y / s->h - p->cell_j;
    for (int a = 0; a < 4; a++) {
      p->grad_x_basis_fn[a] = (node_x[a] ? 1 : -1) / s->h * (node_y[a] ? y : 1 - y);
      p->grad_y_basis_fn[a] = (node_y[a] ? 1 : -1) / s->h * (node_x[a] ? x : 1 - x);
    }
  }
}

/* Step 6: velocity gradient of each point, eq. (3). */
static void velocity_gradients(struct seed *s)
{
  for (struct material *p = s->points; p < s->points + s->num_points; p++) {
    memset(p->grad_velocity, 0, sizeof(p->grad_velocity));
    for (int a = 0; a < 4; a++) {
      const struct mesh *node = point_node(s, p, a);
      p->grad_velocity[0][0] += node->v_x * p->grad_x_basis_fn[a];
      p->grad_velocity[0][1] += node->v_x * p->grad_y_basis_fn[a];
      p->grad_velocity[1][0] += node->v_y * p->grad_x_basis_fn[a];
      p->grad_velocity[1][1] += node->v_y * p->grad_y_basis_fn[a];
    }
  }
}

/* Lame's constants: the assignment gives E only, so Poisson's ratio is one of the whole program. */
static double lame_lambda(const struct seed *s, const struct material *p)
{
  return p->E * s->nu / ((1 + s->nu) * (1 - 2 * s->nu));
}

static double lame_mu(const struct seed *s, const struct material *p)
{
  return p->E / (2 * (1 + s->nu));
}

static double determinant(const struct material *p)
{
  return p->Fp[0][0] * p->Fp[1][1] - p->Fp[0][1] * p->Fp[1][0];
}

/* neo-Hookean: lam ln(J)/J I + mu/J (F F^T - I); elastic: lam tr(e) I + 2 mu e with e = sym(F) - I */
static void update_stress(const struct seed *s, struct material *p)
{
  const double lam = lame_lambda(s, p), mu = lame_mu(s, p), J = determinant(p);
  const double mean = s->elastic ? lam * (p->Fp[0][0] - 1 + p->Fp[1][1] - 1) : lam * log(J) / J;
  for (int d = 0; d < 2; d++) {
    for (int e = 0; e < 2; e++) {
      const double B      = p->Fp[d][0] * p->Fp[e][0] + p->Fp[d][1] * p->Fp[e][1];
      const double strain = 0.5 * (p->Fp[d][e] + p->Fp[e][d]) - (d == e);
      p->stress[d][e]     = (s->elastic ? 2 * mu * strain : mu / J * (B - (d == e))) + (d == e) * mean;
    }
  }
}

/* Step 7: deformation gradient, eqs (10) and (11). The assignment names no place for the stress, eq. (12), nor for
   the current volume: both follow F here, so that step 8 has them. */
static void deformation_gradients(struct seed *s)
{
  for (struct material *p = s->points; p < s->points + s->num_points; p++) {
    double old[2][2];
    memcpy(old, p->Fp, sizeof(old));
    for (int d = 0; d < 2; d++) {
      for (int e = 0; e < 2; e++) p->change_Fp[d][e] = (d == e) + s->dt * p->grad_velocity[d][e];
      for (int e = 0; e < 2; e++) p->Fp[d][e] = p->change_Fp[d][0] * old[0][e] + p->change_Fp[d][1] * old[1][e];
    }
    if (!(determinant(p) > 0)) FAIL("point %d: det F = %g", (int)(p - s->points), determinant(p));
    p->vol = determinant(p) * s->b * s->b;
    update_stress(s, p);
  }
}

/* Step 8: internal and external force at each node, eqs (4) and (13). */
static void node_forces(struct seed *s)
{
  for (int n = 0; n < s->num_nodes; n++) {
    struct mesh *node = &s->mesh[n];
    node->f_int_x = node->f_int_y = node->f_ext_x = node->f_ext_y = 0;
    for (int a = 0; a < 4; a++) {
      const struct mesh *cell = cell_around(s, n, a);
      for (int k = 0; cell && k < cell->num_points; k++) {
        const struct material *p  = listed_point(s, cell, k);
        const double           gx = p->grad_x_basis_fn[a], gy = p->grad_y_basis_fn[a];
        node->f_int_x -= p->vol * (p->stress[0][0] * gx + p->stress[0][1] * gy);
        node->f_int_y -= p->vol * (p->stress[1][0] * gx + p->stress[1][1] * gy);
        node->f_ext_x += p->basis_fn[a] * p->mass * p->body_force_x;
        node->f_ext_y += p->basis_fn[a] * p->mass * p->body_force_y;
      }
    }
  }
}

/* Step 9: acceleration at each node, eq. (5); then eq. (6), v_i + dt a_i, which no step names but step 11 needs. */
static void node_accelerations(struct seed *s)
{
  for (int n = 0; n < s->num_nodes; n++) {
    struct mesh *node  = &s->mesh[n];
    const int    moves = node->node_mass > 0 && !is_fixed(s, n);
    node->a_x          = moves ? (node->f_int_x + node->f_ext_x) / node->node_mass : 0;
    node->a_y          = moves ? (node->f_int_y + node->f_ext_y) / node->node_mass : 0;
    node->v_x += s->dt * node->a_x;
    node->v_y += s->dt * node->a_y;
  }
}

/* Step 10: velocity of each point, eq. (8). The assignment's words ask for the basis functions' gradients here, which
   that equation does not have. */
static void point_velocities(struct seed *s)
{
  for (struct material *p = s->points; p < s->points + s->num_points; p++) {
    p->ax = p->ay = 0;
    for (int a = 0; a < 4; a++) {
      p->ax += p->basis_fn[a] * point_node(s, p, a)->a_x;
      p->ay += p->basis_fn[a] * point_node(s, p, a)->a_y;
    }
    p->vx += s->dt * p->ax;
    p->vy += s->dt * p->ay;
  }
}

/* Step 11: position of each point, eq. (9), by the nodes' new velocity. */
static void point_positions(struct seed *s)
{
  for (struct material *p = s->points; p < s->points + s->num_points; p++) {
    double vx = 0, vy = 0;
    for (int a = 0; a < 4; a++) {
      vx += p->basis_fn[a] * point_node(s, p, a)->v_x;
      vy += p->basis_fn[a] * point_node(s, p, a)->v_y;
    }
    p->x += s->dt * vx;
    p->y += s->dt * vy;
    p->ux += s->dt * vx;
    p->uy += s->dt * vy;
  }
}

/* Step 12: repeat. The assignment says steps 1-10, but without 11 nothing would move. */
static void run(struct seed *s)
{
  for (int step = 0; step < s->steps; step++) {
    find_cells(s);
    basis_functions(s);
    node_masses(s);
    node_velocities(s);
    basis_gradients(s);
    velocity_gradients(s);
    deformation_gradients(s);
    node_forces(s);
    node_accelerations(s);
    point_velocities(s);
    point_positions(s);
  }
}

/* Disks of radius 0.2, or a square of cells/2 cells a side whose lower left corner is a node. */
static int inside(const struct seed *s, int body, double x, double y)
{
  const double lo = s->cells / 4 * s->h, hi = lo + s->cells / 2 * s->h;
  const double dx = x - (body ? 0.8 : 0.2), dy = y - (body ? 0.8 : 0.2);
  return s->block ? lo < x && x < hi && lo < y && y < hi : dx * dx + dy * dy < 0.2 * 0.2;
}

static void add_point(struct seed *s, int body, double x, double y)
{
  const double     middle = (s->cells / 4 + 0.5 * (s->cells / 2)) * s->h;
  struct material *p      = &s->points[s->num_points++];
  p->x                    = x;
  p->y                    = y;
  p->vx                   = s->block ? (x < middle ? 2 : -2) : (body ? -0.1 : 0.1);
  p->vy                   = s->block ? 0 : p->vx;
  p->vol                  = s->b * s->b;
  p->mass                 = s->rho * p->vol;
  p->E                    = s->block ? 1e6 : 1e3;
  p->body_force_y         = s->gravity;
  p->Fp[0][0] = p->Fp[1][1] = 1;
}

static void set_up(struct seed *s)
{
  const int n = s->cells * s->ppc, bodies = s->block ? 1 : 2;
  s->rho       = 1000;
  s->nu        = 0.3;
  s->h         = 1.0 / s->cells;
  s->b         = s->h / s->ppc;
  s->num_nodes = (s->cells + 1) * (s->cells + 1);
  s->mesh      = calloc((size_t)s->num_nodes, sizeof(*s->mesh));
  s->points    = calloc((size_t)n * (size_t)n, sizeof(*s->points)); // the bodies are disjoint: they fit
  s->column    = calloc((size_t)(bodies * n + 1), sizeof(*s->column));
  if (!s->mesh || !s->points || !s->column) FAIL("out of memory");
  for (int k = 0; k < s->num_nodes; k++) {
    s->mesh[k].x = k % (s->cells + 1) * s->h;
    s->mesh[k].y = k / (s->cells + 1) * s->h;
  }
  for (int c = 0; c < bodies * n; c++) {
    const double x = (c % n + 0.5) * s->b;
    for (int j = 0; j < n; j++)
      if (inside(s, c / n, x, (j + 0.5) * s->b)) add_point(s, c / n, x, (j + 0.5) * s->b);
    s->column[++s->num_columns] = s->num_points;
  }
  if (s->num_points == 0) FAIL("the mesh is too coarse: no points");
  const double modulus = lame_lambda(s, s->points) + 2 * lame_mu(s, s->points);
  if (s->dt <= 0) s->dt = s->block ? 0.2 * s->h / sqrt(modulus / s->rho) : 0.006;
}

/* Per initial volume: the potential of the stress. */
static double strain_energy(const struct seed *s, const struct material *p)
{
  const double lam = lame_lambda(s, p), mu = lame_mu(s, p), lnJ = log(determinant(p));
  const double xx = p->Fp[0][0], xy = p->Fp[0][1], yx = p->Fp[1][0], yy = p->Fp[1][1];
  const double tr = xx - 1 + yy - 1, shear = 0.5 * (xy + yx);
  if (s->elastic) return 0.5 * lam * tr * tr + mu * ((xx - 1) * (xx - 1) + (yy - 1) * (yy - 1) + 2 * shear * shear);
  return 0.5 * mu * (xx * xx + xy * xy + yx * yx + yy * yy - 2 - 2 * lnJ) + 0.5 * lam * lnJ * lnJ;
}

static void print_totals(const struct seed *s)
{
  double mass = 0, momentum_x = 0, momentum_y = 0, kinetic = 0, strain = 0;
  for (const struct material *p = s->points; p < s->points + s->num_points; p++) {
    mass += p->mass;
    momentum_x += p->mass * p->vx;
    momentum_y += p->mass * p->vy;
    kinetic += 0.5 * p->mass * (p->vx * p->vx + p->vy * p->vy);
    strain += s->b * s->b * strain_energy(s, p);
  }
  printf("points %d steps %d dt %.17g\n", s->num_points, s->steps, s->dt);
  printf("mass %.17g\nmomentum %.17g %.17g\n", mass, momentum_x, momentum_y);
  printf("kinetic %.17g\nstrain %.17g\ntotal %.17g\n", kinetic, strain, kinetic + strain);
}

static void write_points(const struct seed *s)
{
  FILE *file = fopen(s->out, "w");
  if (!file) FAIL("cannot write %s", s->out);
  for (const struct material *p = s->points; p < s->points + s->num_points; p++) {
    fprintf(file, "%d %.17g %.17g %.17g %.17g", (int)(p - s->points), p->x, p->y, p->vx, p->vy);
    for (int k = 0; k < 4; k++) fprintf(file, " %.17g", p->Fp[k / 2][k % 2]);
    for (int k = 0; k < 4; k++) fprintf(file, " %.17g", p->stress[k / 2][k % 2]);
    fputc('\n', file);
  }
  const int failed = ferror(file);
  if (fclose(file) || failed) FAIL("cannot write %s", s->out);
}

/* True where the argument is name=number, refused outside [low, high]. */
static int number(const char *arg, const char *name, double low, double high, double *value)
{
  const size_t n = strlen(name);
  char        *end;
  if (strncmp(arg, name, n) || arg[n] != '=') return 0;
  *value = strtod(arg + n + 1, &end);
  if (end == arg + n + 1 || *end || !(*value >= low && *value <= high)) FAIL("%s: choose in [%g, %g]", arg, low, high);
  return 1;
}

static int count(const char *arg, const char *name, int low, int high, int *value)
{
  double real;
  if (!number(arg, name, low, high, &real)) return 0;
  if (real != floor(real)) FAIL("%s: must be whole", arg);
  *value = (int)real;
  return 1;
}

/* True where the argument is one of two; the value is 0 for the first, 1 for the second. */
static int choice(const char *arg, const char *first, const char *second, int *value)
{
  *value = strcmp(arg, second) ? *value : 1;
  *value = strcmp(arg, first) ? *value : 0;
  return !strcmp(arg, first) || !strcmp(arg, second);
}

static int known(struct seed *s, const char *arg)
{
  if (!strncmp(arg, "out=", 4)) s->out = arg + 4;
  return s->out == arg + 4 || count(arg, "cells", 2, 500, &s->cells) || count(arg, "ppc", 1, 100, &s->ppc) ||
         count(arg, "steps", 0, 1000000000, &s->steps) || number(arg, "dt", 1e-300, 1e300, &s->dt) ||
         number(arg, "gravity", -1e300, 1e300, &s->gravity) || choice(arg, "setup=disks", "setup=block", &s->block) ||
         choice(arg, "material=neohookean", "material=elastic", &s->elastic) ||
         choice(arg, "walls=free", "walls=fixed", &s->fixed) || choice(arg, "time=0", "time=1", &s->timed);
}

int main(int argc, char **argv)
{
  struct seed s = {.cells = 20, .ppc = 4, .steps = 500};
  for (int k = 1; k < argc; k++)
    if (!known(&s, argv[k])) FAIL("%s is not an argument", argv[k]);
  set_up(&s);
  const clock_t start = clock();
  run(&s);
  const double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
  print_totals(&s);
  if (s.timed && s.steps) printf("ns per particle-step %.4g\n", 1e9 * seconds / s.num_points / s.steps);
  if (s.out) write_points(&s);
  free(s.mesh);
  free(s.points);
  free(s.column);
  return 0;
}
