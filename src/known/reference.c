/* reference.c - known solutions, the rows of reference.def; reference.h says what they are for.

   The balance of momentum in the body at rest is rho u_tt = Div P + rho b with the first Piola stress P = J sig F^-T.
   Any motion becomes exact with the body force b = u_tt - Div P/rho. In uniaxial strain, F = 1 + u_X along one axis,
     neohookean  P = lambda ln F/F + mu (F - 1/F),  dP/dF = (lambda (1 - ln F) + mu)/F^2 + mu
     elastic     P = (lambda + 2 mu)(F - 1)
   Sources: Steffen, Wallstedt, Guilkey, Kirby and Berzins, CMES 31 (2008) 107-127, eqs. (47)-(51); Wallstedt and
   Guilkey, J. Comput. Phys. 227 (2008) 9628-9642; Kamojjala, Brannon, Sadeghirad and Guilkey, Eng. Comput. 31 (2015)
   193-213. tests/unit_reference.c checks that every row satisfies the balance. */
#include "known/reference.h"

/* A motion at one particle: displacement [dim] m, velocity [dim] m/s, body force per mass [dim] m/s^2, F [dim*dim]. */
typedef struct {
  PetscReal u[3], v[3], b[3], F[9];
} Motion;

static PetscReal Square(PetscReal x)
{
  return x * x;
}

/* --- Whether a scene fits a solution ------------------------------------------------------------------------------ */

static PetscReal Extent(const MPMReferenceData *d, PetscInt axis)
{
  return d->upper[axis] - d->lower[axis];
}

static PetscBool Is(const MPMReferenceData *d, const char model[])
{
  return !strcmp(d->model, model);
}

static PetscBool Weightless(const MPMReferenceData *d)
{
  for (PetscInt e = 0; e < d->dim; e++)
    if (d->gravity[e] != 0) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Returns whether the body is a box that ends at the grid's lower (0) or upper (1) face of this axis. */
static PetscBool Touches(const MPMReferenceData *d, PetscInt axis, PetscInt side)
{
  const PetscReal gap = side ? d->grid_upper[axis] - d->upper[axis] : d->lower[axis] - d->grid_lower[axis];

  return d->shape == MPM_REGION_box && PetscAbsReal(gap) <= 1e-9 * Extent(d, axis);
}

/* Returns whether the body ends at both walls of this axis, which must hold the normal velocity and not the tangential
   one. Periodic faces do so for a motion that is even or odd about them. */
static PetscBool Guides(const MPMReferenceData *d, PetscInt axis)
{
  for (PetscInt side = 0; side < 2; side++) {
    const MPMWall wall = d->walls[axis][side];

    if (!Touches(d, axis, side)) return PETSC_FALSE;
    if (wall != MPM_WALL_slip && wall != MPM_WALL_periodic && !(wall == MPM_WALL_fixed && d->dim == 1))
      return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Returns whether a body that is strained along one axis keeps its width on the others: it is held by walls, or nu is
   0, so that free sides have no stress. */
static PetscBool Uniaxial(const MPMReferenceData *d, PetscInt axis)
{
  for (PetscInt e = 0; e < d->dim; e++) {
    if (e == axis || Guides(d, e)) continue;
    if (d->nu != 0) return PETSC_FALSE;
    for (PetscInt side = 0; side < 2; side++)
      if (d->walls[e][side] != MPM_WALL_free && d->walls[e][side] != MPM_WALL_slip) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

#define SIDEWAYS "needs walls of type slip or periodic at both ends of the body across its axis, or nu 0 and free sides"

/* Returns whether the lower end of the body is held, and its upper end free. */
static PetscBool Stands(const MPMReferenceData *d, PetscInt axis)
{
  if (!Touches(d, axis, 0) || d->walls[axis][1] != MPM_WALL_free) return PETSC_FALSE;
  return d->walls[axis][0] == MPM_WALL_fixed || d->walls[axis][0] == MPM_WALL_slip;
}

/* Returns whether the body is an annulus that lies in the grid, with `room` m around it. */
static PetscBool Surrounded(const MPMReferenceData *d, PetscReal room)
{
  if (d->shape != MPM_REGION_annulus || !(d->inner_radius > 0)) return PETSC_FALSE;
  for (PetscInt e = 0; e < d->dim; e++)
    if (d->center[e] - d->radius - room < d->grid_lower[e] || d->center[e] + d->radius + room > d->grid_upper[e])
      return PETSC_FALSE;
  return PETSC_TRUE;
}

/* --- The motions -------------------------------------------------------------------------------------------------- */

/* axis - u_a = A sin(k_a (X_a - lower_a)) sin(w t + phi_a), k_a = 2 pi/L_a, w = pi c/L_0, phi_a = 2 pi a/dim. F is
   diagonal, F_a = 1 + du_a/dX_a, and with K = ln prod F_a
     b_a = u_a (-w^2 + k_a^2/rho (mu + (lambda (1 - K) + mu)/F_a^2)).
   After Steffen et al. 2008, eq. (51), with whole waves, so that u is 0 at all faces. */
static const char *axis_check(const MPMReferenceData *d)
{
  if (!Is(d, "neohookean")) return "needs material model neohookean";
  if (!Weightless(d)) return "needs gravity 0";
  for (PetscInt e = 0; e < d->dim; e++) {
    if (!Guides(d, e)) return "needs a body of shape box that fills the grid, and walls of type slip or periodic";
    if (!(2 * PETSC_PI * PetscAbsReal(d->amplitude) < Extent(d, e)))
      return "needs 2 pi |amplitude| below the length of the body on each axis, or J <= 0";
  }
  return NULL;
}

static void axis_at(const MPMReferenceData *d, const PetscReal X[], PetscReal t, Motion *m)
{
  const PetscReal w = PETSC_PI * d->c / Extent(d, 0);
  PetscReal       J = 1, K;

  for (PetscInt e = 0; e < d->dim; e++) {
    const PetscReal k = 2 * PETSC_PI / Extent(d, e), s = k * (X[e] - d->lower[e]),
                    q = w * t + 2 * PETSC_PI * e / d->dim;

    m->u[e]              = d->amplitude * PetscSinReal(s) * PetscSinReal(q);
    m->v[e]              = d->amplitude * PetscSinReal(s) * PetscCosReal(q) * w;
    m->F[e * d->dim + e] = 1 + k * d->amplitude * PetscCosReal(s) * PetscSinReal(q);
    J *= m->F[e * d->dim + e];
  }
  K = PetscLogReal(J);
  for (PetscInt e = 0; e < d->dim; e++) {
    const PetscReal k = 2 * PETSC_PI / Extent(d, e), F = m->F[e * d->dim + e];

    m->b[e] = m->u[e] * (k * k / d->rho * (d->mu + (d->lambda * (1 - K) + d->mu) / (F * F)) - w * w);
  }
}

/* bar - u = A sin(k (X - lower)) cos(w t) along x, k = 2 pi/L, w = pi c/L, b = u (k^2/rho dP/dF - w^2). With nu = 0
   that is w^2 u (1 + 2/F^2) for neohookean and 3 w^2 u for elastic. Steffen et al. 2008, eqs. (47)-(49). The bar starts
   stretched and at rest. */
static const char *bar_check(const MPMReferenceData *d)
{
  if (!Is(d, "neohookean") && !Is(d, "elastic")) return "needs material model neohookean or elastic";
  if (!Weightless(d)) return "needs gravity 0";
  for (PetscInt side = 0; side < 2; side++)
    if (!Touches(d, 0, side) || (d->walls[0][side] != MPM_WALL_fixed && d->walls[0][side] != MPM_WALL_slip &&
                                 d->walls[0][side] != MPM_WALL_periodic))
      return "needs a body of shape box between walls of type fixed, slip or periodic at both ends of x";
  if (!Uniaxial(d, 0)) return SIDEWAYS;
  if (!(2 * PETSC_PI * PetscAbsReal(d->amplitude) < Extent(d, 0)))
    return "needs 2 pi |amplitude| below the length of the body, or J <= 0";
  return NULL;
}

static void bar_at(const MPMReferenceData *d, const PetscReal X[], PetscReal t, Motion *m)
{
  const PetscReal L = Extent(d, 0), k = 2 * PETSC_PI / L, w = PETSC_PI * d->c / L, s = k * (X[0] - d->lower[0]);
  const PetscReal F       = 1 + k * d->amplitude * PetscCosReal(s) * PetscCosReal(w * t);
  const PetscReal tangent = Is(d, "elastic") ? d->lambda + 2 * d->mu
                                             : (d->lambda * (1 - PetscLogReal(F)) + d->mu) / (F * F) + d->mu;

  m->u[0] = d->amplitude * PetscSinReal(s) * PetscCosReal(w * t);
  m->v[0] = -d->amplitude * PetscSinReal(s) * PetscSinReal(w * t) * w;
  m->F[0] = F;
  m->b[0] = m->u[0] * (k * k / d->rho * tangent - w * w);
}

/* vortex - x = Q(alpha) X about the centre, alpha = g(t) h(R), g = A sin(pi t/T), h = (1 - 4 xi^2)^2 with
   xi = (R - (ri + ro)/2)/(ro - ri). J = 1; u and P vanish at both rims, so these may be free or held. Div P = mu Lapl
   x. Along the radius and across it, at the present angle Theta + alpha of the particle, this gives
     b_r = R (mu/rho alpha_R^2 - alpha_t^2),  b_t = R alpha_tt - mu/rho (3 alpha_R + R alpha_RR).
   Kamojjala et al. 2015. Some public codes give the components at the angle Theta with the wrong sign of R alpha_t^2
   across the radius; the unit test shows that those do not satisfy the balance. */
static const char *vortex_check(const MPMReferenceData *d)
{
  if (d->dim != 2) return "needs dim 2";
  if (!Is(d, "neohookean")) return "needs material model neohookean";
  if (!Weightless(d)) return "needs gravity 0";
  if (!Surrounded(d, 0)) return "needs a body of shape annulus with inner_radius > 0 that lies in the grid";
  if (!(d->period > 0)) return "needs a period > 0";
  return NULL;
}

static void vortex_at(const MPMReferenceData *d, const PetscReal X[], PetscReal t, Motion *m)
{
  const PetscReal D = d->radius - d->inner_radius, w = PETSC_PI / d->period, cs2 = d->mu / d->rho;
  const PetscReal Y[2] = {X[0] - d->center[0], X[1] - d->center[1]}, R = PetscSqrtReal(Y[0] * Y[0] + Y[1] * Y[1]);
  const PetscReal xi = (R - 0.5 * (d->radius + d->inner_radius)) / D, root = 1 - 4 * xi * xi;
  const PetscReal h = root * root, h_R = -16 * xi * root / D, h_RR = -16 * (1 - 12 * xi * xi) / (D * D);
  const PetscReal g = d->amplitude * PetscSinReal(w * t), g_t = d->amplitude * PetscCosReal(w * t) * w;
  const PetscReal alpha = g * h, alpha_t = g_t * h, alpha_tt = -w * w * g * h, alpha_R = g * h_R;
  const PetscReal br = R * (cs2 * Square(alpha_R) - Square(alpha_t));
  const PetscReal bt = R * alpha_tt - cs2 * (3 * alpha_R + R * g * h_RR);
  const PetscReal S = PetscSinReal(alpha), less = -2 * Square(PetscSinReal(0.5 * alpha)); /* cos alpha - 1 */
  const PetscReal u[2] = {less * Y[0] - S * Y[1], S * Y[0] + less * Y[1]};
  const PetscReal x = Y[0] + u[0], y = Y[1] + u[1];

  m->u[0] = u[0];
  m->u[1] = u[1];
  m->v[0] = -y * alpha_t;
  m->v[1] = x * alpha_t;
  m->b[0] = (br * x - bt * y) / R;
  m->b[1] = (br * y + bt * x) / R;
  m->F[0] = 1 + less - y * alpha_R * Y[0] / R;
  m->F[1] = -S - y * alpha_R * Y[1] / R;
  m->F[2] = S + x * alpha_R * Y[0] / R;
  m->F[3] = 1 + less + x * alpha_R * Y[1] / R;
}

/* ring - along the radius u_R = A U(R) sin(w t), w = pi c/(ri + ro), U = (-6 ri ro R + 3 (ri + ro) R^2 - 2 R^3)/N with
   N = ro^2 (ro - 3 ri). U(ro) = 1, and U' = 0 at both rims, which are free of stress, as lambda = 0. With
   F_R = 1 + u_R', F_T = 1 + u_R/R and P(F) = mu (F - 1/F)
     b_R = -w^2 u_R - (P'(F_R) u_R'' + (dim - 1) (P(F_R) - P(F_T))/R)/rho.
   Wallstedt and Guilkey 2008. RingScale returns N. */
static PetscReal RingScale(const MPMReferenceData *d)
{
  return Square(d->radius) * (d->radius - 3 * d->inner_radius);
}

static const char *ring_check(const MPMReferenceData *d)
{
  const PetscReal A = PetscAbsReal(d->amplitude), ri = d->inner_radius, ro = d->radius, N = PetscAbsReal(RingScale(d));

  if (d->dim < 2) return "needs dim 2 or 3";
  if (!Is(d, "neohookean") || d->nu != 0) return "needs material model neohookean with nu 0";
  if (!Weightless(d)) return "needs gravity 0";
  if (!Surrounded(d, A))
    return "needs a body of shape annulus with inner_radius > 0, and room for its amplitude in the grid";
  if (!(N > 1e-9 * ro * ro * ro)) return "needs a radius other than 3 inner_radius";
  /* the largest |u_R'| is that of the middle; |u_R/R| is largest at a rim, where U has its extrema */
  if (!(A * 1.5 * Square(ro - ri) < N) || !(A * PetscMax(1, Square(ri) * (3 * ro - ri) / N) < ri))
    return "needs a smaller amplitude, or J <= 0";
  return NULL;
}

static void ring_at(const MPMReferenceData *d, const PetscReal X[], PetscReal t, Motion *m)
{
  const PetscReal ri = d->inner_radius, ro = d->radius, w = PETSC_PI * d->c / (ri + ro),
                  g = d->amplitude / RingScale(d);
  PetscReal Y[3], R = 0, U, u, v, b, FR, FT;

  for (PetscInt e = 0; e < d->dim; e++) {
    Y[e] = X[e] - d->center[e];
    R += Y[e] * Y[e];
  }
  R  = PetscSqrtReal(R);
  U  = g * R * (-6 * ri * ro + R * (3 * (ri + ro) - 2 * R));
  u  = U * PetscSinReal(w * t);
  v  = U * PetscCosReal(w * t) * w;
  FR = 1 - 6 * g * (R - ri) * (R - ro) * PetscSinReal(w * t);
  FT = 1 + u / R;
  b  = (1 + 1 / (FR * FR)) * 6 * g * (ri + ro - 2 * R) * PetscSinReal(w * t); /* P'(F_R) u_R''/mu */
  b += (d->dim - 1) * ((FR - 1 / FR) - (FT - 1 / FT)) / R;
  b = -w * w * u - d->mu / d->rho * b;
  for (PetscInt e = 0; e < d->dim; e++) {
    m->u[e] = u * Y[e] / R;
    m->v[e] = v * Y[e] / R;
    m->b[e] = b * Y[e] / R;
    for (PetscInt f = 0; f < d->dim; f++)
      m->F[e * d->dim + f] = (e == f ? FT : 0) + (FR - FT) * (Y[e] / R) * (Y[f] / R);
  }
}

/* shear - u_x = A sin(k (Y - lower)) sin(w t), k = n pi/L_y, w = k sqrt(mu/rho). P_xy = mu u_x,Y for both laws at any
   shear, and the rest of P has no divergence, so this wave of the linear theory is exact. */
static const char *shear_check(const MPMReferenceData *d)
{
  if (d->dim < 2) return "needs dim 2 or 3";
  if (!Is(d, "neohookean") && !Is(d, "elastic")) return "needs material model neohookean or elastic";
  if (!Weightless(d)) return "needs gravity 0";
  for (PetscInt side = 0; side < 2; side++) {
    if (!Touches(d, 0, side) || d->walls[0][side] != MPM_WALL_periodic)
      return "needs a body of shape box that fills the grid, and walls of type periodic at both ends of x";
    if (!Touches(d, 1, side) || d->walls[1][side] != MPM_WALL_fixed)
      return "needs a body of shape box that fills the grid, and walls of type fixed at both ends of y";
  }
  if (d->dim > 2 && !Guides(d, 2)) return "needs walls of type slip or periodic at both ends of z";
  if (d->mode < 1) return "needs a mode >= 1";
  return NULL;
}

static void shear_at(const MPMReferenceData *d, const PetscReal X[], PetscReal t, Motion *m)
{
  const PetscReal k = d->mode * PETSC_PI / Extent(d, 1), w = k * PetscSqrtReal(d->mu / d->rho);
  const PetscReal s = k * (X[1] - d->lower[1]);

  m->u[0] = d->amplitude * PetscSinReal(s) * PetscSinReal(w * t);
  m->v[0] = d->amplitude * PetscSinReal(s) * PetscCosReal(w * t) * w;
  m->F[1] = d->amplitude * PetscCosReal(s) * PetscSinReal(w * t) * k;
}

/* mode - u = A sin(beta (X - lower)) sin(w t) along x, beta = (2 n - 1) pi/(2 L), w = beta cp. A is the amplitude of
   the displacement at the free end: v0/w where v0 sin(beta (X - lower)) is the velocity at the start. The elastic law
   is linear in F in uniaxial strain, so this is exact; cp = sqrt(E/rho) where nu = 0. */
static const char *mode_check(const MPMReferenceData *d)
{
  if (!Is(d, "elastic")) return "needs material model elastic";
  if (!Weightless(d)) return "needs gravity 0";
  if (!Stands(d, 0))
    return "needs a body of shape box that stands on a wall of type fixed or slip at xmin, and xmax of type free";
  if (!Uniaxial(d, 0)) return SIDEWAYS;
  if (d->mode < 1) return "needs a mode >= 1";
  if (!(PetscAbsReal(d->amplitude) * (2 * d->mode - 1) * PETSC_PI / 2 < Extent(d, 0)))
    return "needs a smaller amplitude, or J <= 0";
  return NULL;
}

/* standing - u = A sin(k (X - lower)) sin(w t) along x, k = n pi/L, w = k cp: a bar between walls, exact for the same
   reason as mode. The table of orders of convergence in docs/studies.md has n = 1, nu = 0, A = 0.05 L,
   c dt/h = 0.1 and ends at w t = pi/2. */
static const char *standing_check(const MPMReferenceData *d)
{
  if (!Is(d, "elastic")) return "needs material model elastic";
  if (!Weightless(d)) return "needs gravity 0";
  for (PetscInt side = 0; side < 2; side++)
    if (!Touches(d, 0, side) || (d->walls[0][side] != MPM_WALL_fixed && d->walls[0][side] != MPM_WALL_slip))
      return "needs a body of shape box between walls of type fixed or slip at both ends of x";
  if (!Uniaxial(d, 0)) return SIDEWAYS;
  if (d->mode < 1) return "needs a mode >= 1";
  if (!(PetscAbsReal(d->amplitude) * d->mode * PETSC_PI < Extent(d, 0))) return "needs a smaller amplitude, or J <= 0";
  return NULL;
}

/* The motion of mode and standing: u = A sin(k (X - lower)) sin(k cp t) along x. */
static void Standing(const MPMReferenceData *d, PetscReal k, const PetscReal X[], PetscReal t, Motion *m)
{
  const PetscReal w = k * d->cp, s = k * (X[0] - d->lower[0]);

  m->u[0] = d->amplitude * PetscSinReal(s) * PetscSinReal(w * t);
  m->v[0] = d->amplitude * PetscSinReal(s) * PetscCosReal(w * t) * w;
  m->F[0] = 1 + d->amplitude * PetscCosReal(s) * PetscSinReal(w * t) * k;
}

static void standing_at(const MPMReferenceData *d, const PetscReal X[], PetscReal t, Motion *m)
{
  Standing(d, d->mode * PETSC_PI / Extent(d, 0), X, t, m);
}

static void mode_at(const MPMReferenceData *d, const PetscReal X[], PetscReal t, Motion *m)
{
  Standing(d, (2 * d->mode - 1) * PETSC_PI / (2 * Extent(d, 0)), X, t, m);
}

/* column - under gravity g < 0 along one axis, with height s above the foot: the settled state (rho g/M) U(s), with
   U = L s - s^2/2 and M = lambda + 2 mu, less the d'Alembert wave that starts from it,
     u = (rho g/M) (U(s) - (U(s - cp t) + U(s + cp t))/2),
   where U is continued as odd about the foot and even about the top, with period 4 L. At t = 2 L/cp it is twice the
   settled state. Upright returns the axis of gravity, or -1 unless it points downwards along one axis. */
static PetscInt Upright(const MPMReferenceData *d)
{
  PetscInt axis = -1;

  for (PetscInt e = 0; e < d->dim; e++) {
    if (d->gravity[e] == 0) continue;
    if (d->gravity[e] > 0 || axis >= 0) return -1;
    axis = e;
  }
  return axis;
}

static const char *column_check(const MPMReferenceData *d)
{
  const PetscInt axis = Upright(d);

  if (axis < 0) return "needs gravity along one axis, downwards";
  if (!Is(d, "elastic")) return "needs material model elastic";
  if (!Stands(d, axis))
    return "needs a body of shape box that stands on a wall of type fixed or slip, and a face of type free above";
  if (!Uniaxial(d, axis)) return SIDEWAYS;
  if (!(-2 * d->gravity[axis] * Extent(d, axis) < Square(d->cp))) return "needs a weaker gravity, or J <= 0";
  return NULL;
}

static void column_at(const MPMReferenceData *d, const PetscReal X[], PetscReal t, Motion *m)
{
  const PetscInt  axis = Upright(d);
  const PetscReal L = Extent(d, axis), s = X[axis] - d->lower[axis], g = d->gravity[axis] / Square(d->cp);
  const PetscReal left = remainder(s - d->cp * t, 4 * L), right = remainder(s + d->cp * t, 4 * L); /* in -2L .. 2L */
  const PetscReal U = s * (L - 0.5 * s), Ul = left * (L - 0.5 * PetscAbsReal(left));
  const PetscReal Ur = right * (L - 0.5 * PetscAbsReal(right)), U_s = L - s;
  const PetscReal Ul_s = L - PetscAbsReal(left), Ur_s = L - PetscAbsReal(right);

  m->u[axis]                = g * (U - 0.5 * (Ul + Ur));
  m->v[axis]                = g * 0.5 * d->cp * (Ul_s - Ur_s);
  m->F[axis * (d->dim + 1)] = 1 + g * (U_s - 0.5 * (Ul_s + Ur_s));
}

/* --- The table ---------------------------------------------------------------------------------------------------- */

/* Returns a body at rest; the function of a row then sets what moves. */
static Motion Rest(PetscInt dim)
{
  Motion m = {{0}, {0}, {0}, {0}};

  for (PetscInt e = 0; e < dim; e++) m.F[e * dim + e] = 1;
  return m;
}

/* Defines <name>_<part>, which gives the n values of one part of the motion. */
#define MPM_REFERENCE_PART(name, part, member, n)                                                                      \
  static void name##_##part(const MPMReferenceData *d, const PetscReal X[], PetscReal t, PetscReal value[])            \
  {                                                                                                                    \
    Motion m = Rest(d->dim);                                                                                           \
                                                                                                                       \
    name##_at(d, X, t, &m);                                                                                            \
    for (PetscInt k = 0; k < (n); k++) value[k] = m.member[k];                                                         \
  }
#define MPM_REFERENCE(name, manufactured, parameters, what)                                                            \
  MPM_REFERENCE_PART(name, displacement, u, d->dim)                                                                    \
  MPM_REFERENCE_PART(name, velocity, v, d->dim)                                                                        \
  MPM_REFERENCE_PART(name, acceleration, b, d->dim)                                                                    \
  MPM_REFERENCE_PART(name, deformation, F, d->dim * d->dim)
#include "known/reference.def"

const MPMReference MPMReferences[] = {
#define MPM_REFERENCE(name, manufactured, parameters, what)                                                            \
  {#name,                                                                                                              \
   what,                                                                                                               \
   manufactured,                                                                                                       \
   parameters,                                                                                                         \
   name##_check,                                                                                                       \
   name##_displacement,                                                                                                \
   name##_velocity,                                                                                                    \
   manufactured ? name##_acceleration : NULL,                                                                          \
   name##_deformation},
#include "known/reference.def"
    {NULL, NULL, PETSC_FALSE, NULL, NULL, NULL, NULL, NULL, NULL}};

/* Returns the row of this name, or NULL if there is none. */
const MPMReference *MPMReferenceFind(const char name[])
{
  for (const MPMReference *row = MPMReferences; row->name; row++)
    if (!strcmp(row->name, name)) return row;
  return NULL;
}
