/* diagnostics.c - what a run shows of its state: the functions of the rows of diagnostics.def, which are called between
   steps. A new quantity needs a row there and a function here. Fill_<name> sets row [nc], the quantity of particle p of
   a view; vectors have 3 components, and 0 on missing axes. Value_<name> returns a number of the run. */
#include "kernels/cell.h"
#include "results/diagnostics.h"
#include "step/static.h"
#include "step/step.h"

/* --- Quantities of a particle ------------------------------------------------------------------------------------- */

static const MPMKind *KindOf(const MPMShown *s, const MPMView *v, PetscInt p)
{
  return MPMKindOf(s->scene->kinds, v, p);
}

static const MPMMaterial *MaterialOf(const MPMShown *s, const MPMView *v, PetscInt p)
{
  return &s->scene->materials[KindOf(s, v, p)->material];
}

/* Returns the volume of a particle over that at the start. */
static PetscReal Jacobian(const MPMShown *s, const MPMView *v, PetscInt p)
{
  const PetscInt dim = s->core->grid.dim;

  return MPMVolumeRatio(MaterialOf(s, v, p), dim, v, p);
}

static void Fill_id(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  (void)s;
  row[0] = (PetscReal)v->id[p]; /* exact below 2^53 */
}

static void Fill_x(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  for (PetscInt d = 0; d < 3; d++) row[d] = d < s->core->grid.dim ? v->x[p * s->core->grid.dim + d] : 0;
}

static void Fill_v(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  for (PetscInt d = 0; d < 3; d++) row[d] = d < s->core->grid.dim ? v->v[p * s->core->grid.dim + d] : 0;
}

/* Materials without F have J; then F is shown as J^(1/dim) I, which has the same volume. Bodies of revolution deform
   along all axes. */
static void Fill_F(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscInt dim = s->core->grid.dim, axes = s->core->grid.round ? 3 : dim;

  if (!(MaterialOf(s, v, p)->state & MPM_BIT(F))) {
    for (PetscInt k = 0; k < 9; k++) row[k] = k % 4 ? 0 : k / 4 < axes ? PetscPowReal(v->J[p], 1 / (PetscReal)axes) : 1;
    return;
  }
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++) row[3 * d + e] = d < dim && e < dim ? v->F[(p * dim + d) * dim + e] : d == e;
  if (s->core->grid.round) row[8] = v->F33[p];
}

/* The stress that is shown is the Cauchy stress, sig = tau/J, Pa. */
static void Fill_stress(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscInt     dim = s->core->grid.dim;
  const MPMMaterial *m   = MaterialOf(s, v, p);
  MPMBlock           b;

  MPMMaterialState(dim, v, p, &b);
  if (!(m->state & MPM_BIT(tau))) m->type->law->stress[MPMLawForm(m, dim)](m, 0, 1, &b);
  for (PetscInt k = 0; k < 9; k++) row[k] = 0;
  for (PetscInt k = 0; k < MPM_SYM_NC(dim); k++) {
    const PetscInt to = MPMShownStress(dim, k);

    row[to] = row[to % 3 * 3 + to / 3] = b.tau[k][0] / Jacobian(s, v, p);
  }
}

static void Fill_volume(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  row[0] = KindOf(s, v, p)->V0 * Jacobian(s, v, p);
}

/* Numbers of the stress of a particle, in Pa. */
#define OF_STRESS(name)                                                                                                \
  static void Fill_##name(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])                            \
  {                                                                                                                    \
    PetscReal stress[9];                                                                                               \
                                                                                                                       \
    Fill_stress(s, v, p, stress);                                                                                      \
    row[0] = MPMShown_##name(stress);                                                                                  \
  }
OF_STRESS(von_mises)
OF_STRESS(pressure)
OF_STRESS(stress_min)
OF_STRESS(stress_max)

static void Fill_lower_edge(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  MPMShownEdge(s, v, p, -1, row);
}

static void Fill_upper_edge(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  MPMShownEdge(s, v, p, 1, row);
}

/* The equivalent plastic strain of a material without plasticity is 0. */
static void Fill_plastic_strain(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  row[0] = MaterialOf(s, v, p)->state & MPM_BIT(ep) ? v->ep[p] : 0;
}

/* The temperature of johnsoncook, (12f); a material without heat has none. */
static void Fill_temperature(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  const MPMMaterial *m = MaterialOf(s, v, p);

  row[0] = (PetscReal)NAN;
  if (m->state & MPM_BIT(theta))
    row[0] = (m->temperature + v->theta[p]) * MPMExp(m->gruneisen * (1 - Jacobian(s, v, p)));
}

static void Fill_body(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  row[0] = MPMBodyOf(s->scene, v->id[p], 0);
}

/* It needs all particles, so it is computed before (indicator.c). */
static void Fill_error_indicator(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  (void)v;
  row[0] = (PetscReal)s->indicator[p];
}

static void Fill_mass(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  row[0] = KindOf(s, v, p)->m;
}

/* Returns |v|^2 of particle p, m^2/s^2. */
static PetscReal Speed2(const MPMShown *s, const MPMView *v, PetscInt p)
{
  const PetscInt dim = s->core->grid.dim;
  PetscReal      v2  = 0;

  for (PetscInt d = 0; d < dim; d++) v2 += v->v[p * dim + d] * v->v[p * dim + d];
  return v2;
}

static void Fill_kinetic_energy(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  row[0] = 0.5 * KindOf(s, v, p)->m * Speed2(s, v, p);
}

/* Sets inertia [dim] to sum phi (x_i - x)^2, m^2, of particle p on each axis; of splines, that away from walls, as APIC
   has it. */
static void SetInertia(const MPMCore *core, const MPMView *v, PetscInt p, PetscReal inertia[])
{
  const MPMGrid  *grid = &core->grid;
  const PetscInt  dim  = grid->dim;
  const PetscReal k = MPMBasisInertia(core->basis), *l = MPMHalfWidths((int)dim, core->params.kinds, v, p);

  if (v->cell && v->cell[p] == MPM_NOWHERE) return; /* it is to be removed, and has no stencil */
  for (int d = 0; d < dim; d++) {
    PetscReal      xi, w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];
    const PetscInt base = MPMCoordinate(core->basis, grid, d, v->x[p * dim + d], l[d], &xi);

    inertia[d] = k > 0 ? 1 / k : 0;
    MPMBasisWeights(core->basis, xi, l[d], base, grid->cells[d], grid->wall_basis[d], w, g);
    for (int i = 0; i < MPMBasisNodes(core->basis) && !(k > 0); i++)
      inertia[d] += w[i] * PetscSqr((PetscReal)(base + i) - xi);
    inertia[d] *= grid->h[d] * grid->h[d];
  }
}

/* Bodies of revolution do not turn. Else it is m x x v about the origin, and with APIC that of the affine velocity: C
   moves the mass around the particle, whose moment of inertia on axis e is m inertia_e. */
static void Fill_angular_momentum(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscInt  dim  = s->core->grid.dim;
  const PetscReal m    = KindOf(s, v, p)->m;
  PetscReal       x[3] = {0}, u[3] = {0}, inertia[3] = {0}, C[3][3] = {{0}};

  for (PetscInt d = 0; d < dim; d++) {
    x[d] = v->x[p * dim + d];
    u[d] = v->v[p * dim + d];
    for (PetscInt e = 0; e < dim && v->C; e++) C[d][e] = v->C[(p * dim + d) * dim + e];
  }
  if (v->C) SetInertia(s->core, v, p, inertia);
  for (PetscInt k = 0; k < 3; k++) {
    const PetscInt d = (k + 1) % 3, e = (k + 2) % 3;

    row[k] = m * (x[d] * u[e] - x[e] * u[d] + inertia[d] * C[e][d] - inertia[e] * C[d][e]);
    if (s->core->grid.round) row[k] = 0;
  }
}

static void Fill_strain_energy(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscInt     dim = s->core->grid.dim;
  const MPMMaterial *m   = MaterialOf(s, v, p);
  PetscReal          W;
  MPMBlock           b;

  MPMMaterialState(dim, v, p, &b);
  m->type->law->energy[MPMLawForm(m, dim)](m, 0, 1, &b, &W);
  row[0] = KindOf(s, v, p)->V0 * W;
}

/* The strain energy of particles whose law stores only a part of the work of the stress. */
static void Fill_partly_stored(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  row[0] = 0;
  if (MPMEnergyLost(MaterialOf(s, v, p))) Fill_strain_energy(s, v, p, row);
}

static void Fill_momentum(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscInt dim = s->core->grid.dim;

  for (PetscInt d = 0; d < 3; d++) row[d] = d < dim ? KindOf(s, v, p)->m * v->v[p * dim + d] : 0;
}

/* m x, whose sum gives the work of gravity. */
static void Fill_mass_moment(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  const PetscInt dim = s->core->grid.dim;

  for (PetscInt d = 0; d < 3; d++) row[d] = d < dim ? KindOf(s, v, p)->m * v->x[p * dim + d] : 0;
}

/* m |v|, with which a change of momentum is compared. */
static void Fill_momentum_size(const MPMShown *s, const MPMView *v, PetscInt p, PetscReal row[])
{
  row[0] = KindOf(s, v, p)->m * PetscSqrtReal(Speed2(s, v, p));
}

/* --- Quantities of the run ---------------------------------------------------------------------------------------- */

#define VALUE(name, what)                                                                                              \
  static PetscReal Value_##name(const MPMShown *s)                                                                     \
  {                                                                                                                    \
    return what;                                                                                                       \
  }
VALUE(step, (PetscReal)s->core->step)
VALUE(time, s->core->t)
VALUE(dt, s->core->step ? s->core->params.dt : 0)
VALUE(rigid_kinetic_energy, s->now->rigid)
static PetscReal Value_total_energy(const MPMShown *s)
{
  return s->now->sum[MPM_SHOWS_kinetic_energy][0] + s->now->sum[MPM_SHOWS_strain_energy][0] + s->now->rigid;
}

/* Returns the work of loads and body forces, of those on free rigid bodies too. */
static PetscReal Loads(const MPMShown *s)
{
  return s->now->energy[MPM_ENERGY_loads] + s->core->rigids.loads;
}

/* The work of gravity is the sum over steps and particles of m g . (v_old + v_new)/2 kick, which is exact in free fall.
   Particles move by v_new dt, so their displacement since the start exceeds the sum of (v_old + v_new)/2 kick by
   (v dt - v_start dt_1)/2, with the first step dt_1, but for the squares of changes of dt. All kicks together are t +
   (dt_1 - dt)/2. Implicit steps have no kicks: their work is that along the displacement. */
static PetscReal AddGravity(const MPMShown *s, PetscReal work)
{
  const MPMTotals *now = s->now, *start = s->start;
  const PetscReal  dt = s->core->params.dt, first = dt + 2 * (s->core->kicked - s->core->t);
  const PetscReal  part = s->core->implicit ? 0 : 0.5;

  for (PetscInt d = 0; d < s->core->grid.dim; d++)
    work += s->core->params.gravity[d] *
            (MPMShownEver(now, MPM_SHOWS_mass_moment, d) - start->sum[MPM_SHOWS_mass_moment][d] -
             part * (dt * MPMShownEver(now, MPM_SHOWS_momentum, d) - first * start->sum[MPM_SHOWS_momentum][d]));
  return work;
}

PetscReal MPMShownGravity(const MPMShown *s)
{
  return AddGravity(s, s->core->half + s->core->rigids.energy[0]);
}

PetscReal MPMShownWork(const MPMShown *s)
{
  return AddGravity(s, Loads(s) + s->core->half + s->core->rigids.energy[0] + s->core->changes.energy);
}

VALUE(external_work, MPMShownWork(s))
PetscReal MPMShownResidual(const MPMShown *s)
{
  return MPMShownEver(s->now, MPM_SHOWS_kinetic_energy, 0) + MPMShownEver(s->now, MPM_SHOWS_strain_energy, 0) -
         s->start->sum[MPM_SHOWS_kinetic_energy][0] - s->start->sum[MPM_SHOWS_strain_energy][0] + s->now->rigid -
         s->start->rigid - MPMShownWork(s);
}
VALUE(energy_residual, MPMShownResidual(s))
VALUE(load_work, Loads(s))
VALUE(energy_gravity,
      s->core->implicit ? MPMShownGravity(s) : s->now->energy[MPM_ENERGY_gravity] + s->core->rigids.energy[0])
VALUE(energy_walls, s->now->energy[MPM_ENERGY_walls] + s->core->rigids.energy[2])
VALUE(energy_rigid, s->now->energy[MPM_ENERGY_rigid])
VALUE(energy_friction, s->now->energy[MPM_ENERGY_friction] + s->core->rigids.energy[1])
/* Returns how much a sum over the particles, those that were removed included, has changed since the start. */
static PetscReal Change(const MPMShown *s, PetscInt row)
{
  return MPMShownEver(s->now, row, 0) - s->start->sum[row][0];
}

VALUE(energy_damping, s->now->energy[MPM_ENERGY_damping])
VALUE(energy_volumes, s->now->energy[MPM_ENERGY_volumes])
VALUE(energy_lag, s->now->energy[MPM_ENERGY_half]) /* of the stress, in the half step by which velocities are behind */
VALUE(energy_transfer, Change(s, MPM_SHOWS_kinetic_energy) - s->now->energy[MPM_ENERGY_advance] -
                           Value_energy_damping(s) + s->now->energy[MPM_ENERGY_mapped] - Value_energy_lag(s))
VALUE(energy_laws, Change(s, MPM_SHOWS_partly_stored) - s->now->energy[MPM_ENERGY_stress])
static PetscReal Value_energy_integration(const MPMShown *s)
{
  return Change(s, MPM_SHOWS_kinetic_energy) + Change(s, MPM_SHOWS_strain_energy) + s->now->rigid - s->start->rigid -
         Value_load_work(s) - Value_energy_gravity(s) - Value_energy_walls(s) - Value_energy_friction(s) -
         Value_energy_transfer(s) - Value_energy_laws(s) - Value_energy_damping(s) - Value_energy_volumes(s) -
         Value_energy_lag(s) - Value_energy_rigid(s) - s->core->changes.energy;
}

VALUE(newton_iterations, s->core->implicit->newton)
VALUE(linear_iterations, s->core->implicit->krylov)
VALUE(steps_cut, s->core->implicit->failed)
VALUE(force_unbalanced, s->core->implicit->residual)
VALUE(stage, (PetscReal)s->core->stages.now)
VALUE(unbalanced, s->core->rest.unbalanced)
VALUE(kinetic_share, MPMShownKineticShare(s->now))

static PetscReal Value_particles(const MPMShown *s)
{
  return (PetscReal)s->now->n; /* exact below 2^53 */
}

/* --- The table ---------------------------------------------------------------------------------------------------- */

#define FIELD     MPM_SHOW_FIELD
#define COLUMN    (MPM_SHOW_COLUMN | MPM_SHOW_SUM)
#define SUM       MPM_SHOW_SUM
#define TERM      MPM_SHOW_TERM
#define LOADS     MPM_SHOW_LOADS
#define DAMPED    MPM_SHOW_DAMPED
#define RELAXED   MPM_SHOW_RELAXED
#define RIGID     MPM_SHOW_RIGID
#define FREE      MPM_SHOW_FREE
#define AXIAL     MPM_SHOW_AXIAL
#define ASKED     MPM_SHOW_ASKED
#define SYMMETRIC MPM_SHOW_SYMMETRIC
#define REST      MPM_SHOW_REST
#define STAGED    MPM_SHOW_STAGED
#define STATIC    MPM_SHOW_STATIC
#define SHOWN     MPM_SHOW_COLUMN
const MPMDiagnostic MPMDiagnostics[MPM_NUM_DIAGNOSTICS] = {
#define MPM_PARTICLE_QUANTITY(name, uses, word, unit, components, nc, whole, needs, reads)                             \
  {#name, word, unit, components, uses, nc, whole, needs, reads, Fill_##name, NULL, 0},
#define MPM_RUN_QUANTITY(name, uses, unit, whole)                                                                      \
  {#name, "", unit, "", MPM_SHOW_COLUMN | (uses), 1, whole, 0, 0, NULL, Value_##name, 0},
#define MPM_LOST_QUANTITY(name, of, uses, unit, components, nc)                                                        \
  {#name, "", unit, components, MPM_SHOW_LOST | (uses), nc, PETSC_FALSE, 0, 0, NULL, NULL, MPM_SHOWS_##of},
#include "results/diagnostics.def"
};
#define MPM_PARTICLE_QUANTITY(name, uses, word, unit, components, nc, whole, needs, reads)                             \
  _Static_assert((nc) == 1 || (nc) == 3 || ((nc) == 9 && !((uses)&SUM)),                                               \
                 #name ": a number, a vector, or a tensor without sum");                                               \
  _Static_assert(!((uses)&AXIAL) || (nc) == 3, #name ": a vector of rotation has 3 components");                       \
  _Static_assert(!((needs) & ~(reads)), #name " reads what it needs");                                                 \
  _Static_assert(!((reads) & ~(MPM_MATERIAL_BITS | MPM_BIT(X))), #name ": other fields than X and the state of laws");
#include "results/diagnostics.def"

PetscInt MPMDiagnosticAxes(PetscInt row, PetscInt dim, PetscInt *first)
{
  const MPMDiagnostic *d = &MPMDiagnostics[row];

  *first = 0;
  if (!(d->uses & MPM_SHOW_AXIAL)) return d->nc == 1 ? 1 : dim;
  *first = dim == 2 ? 2 : 0;
  return dim == 2 ? 1 : dim == 3 ? 3 : 0;
}

PetscInt MPMDiagnosticColumns(PetscInt row, const MPMCore *core, PetscInt *first)
{
  *first = 0;
  if (!(MPMDiagnostics[row].uses & MPM_SHOW_COLUMN) || !MPMDiagnosticIsOn(row, core)) return 0;
  return MPMDiagnosticAxes(row, core->grid.dim, first);
}

PetscInt MPMDiagnosticReads(PetscInt64 rows, const MPMCore *core)
{
  PetscInt fields = 0;

  for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS; k++)
    if (rows >> k & 1 || (MPMDiagnostics[k].uses & MPM_SHOW_SUM && MPMDiagnosticIsOn(k, core)))
      fields |= MPMDiagnostics[k].reads;
  return fields;
}

PetscReal MPMShownEver(const MPMTotals *totals, PetscInt row, PetscInt component)
{
  PetscReal sum = totals->sum[row][component];

  for (PetscInt k = 0; k < MPM_NUM_DIAGNOSTICS; k++)
    if ((MPMDiagnostics[k].uses & MPM_SHOW_LOST) && MPMDiagnostics[k].of == row && k != MPM_SHOWS_lost_mass_time)
      sum += totals->sum[k][component];
  return sum;
}

PetscReal MPMDiagnosticValue(const MPMShown *s, PetscInt row, PetscInt component)
{
  return MPMDiagnostics[row].value ? MPMDiagnostics[row].value(s) : s->now->sum[row][component];
}

PetscBool MPMDiagnosticIsField(PetscInt row, PetscInt fields)
{
  const MPMDiagnostic *d = &MPMDiagnostics[row];

  return (d->uses & MPM_SHOW_FIELD) && !(d->needs & ~fields);
}

PetscBool MPMDiagnosticIsOn(PetscInt row, const MPMCore *core)
{
  const PetscInt uses = MPMDiagnostics[row].uses;

  return !((uses & TERM && !core->energy.on) || (uses & LOADS && !core->energy.loads) ||
           (uses & DAMPED && !MPMDampingIsOn(core)) || (uses & RELAXED && !MPMVolumesRelax(core)) ||
           (uses & RIGID && !core->rigids.driven) || (uses & FREE && !core->rigids.free) ||
           (uses & MPM_SHOW_LOST && !core->params.deletes) || (uses & STATIC && !core->implicit) ||
           (uses & REST && !core->rest.shown) || (uses & STAGED && !core->stages.n));
}
