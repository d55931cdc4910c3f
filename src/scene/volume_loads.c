/* volume_loads.c - loads on the volume of a body: a force of so many N in all, or a torque of so many N m in all. Each
   acts on those particles of its body for which a formula of the place at the start is positive; they are marked by bits
   of the field `chosen`. With V the volume of a particle at the start and c a point, the force on it is

     V even,           even = force / sum V
     V turn x (x - c), turn = I^-1 torque,   I = sum V (|x - c|^2 1 - (x - c) (x - c)^T)

   so that the forces add up to the force, or their moments about c to the torque. c is a given point, or the centre
   sum V x / sum V: then the forces of a torque have no sum. The sums are exact and of every step, since particles move
   and may leave; they are the same on any number of processes. In 2-D forces are per metre of thickness, and a torque is
   about z; turn x (x - c) then stays in the plane. */
#include "base/exact_sum.h"
#include "scene/scene.h"

#define FLAT 1e-9 /* times the mean squared distance from c: less than that along an axis is none, judged by rounding */

/* Sets r [3] to x - x0, m, where x0 is the middle of the grid: sums over all particles then lose no digits. */
static void FromMiddle(const MPMGrid *grid, const PetscReal x[], PetscReal r[3])
{
  for (PetscInt d = 0; d < 3; d++) r[d] = d < grid->dim ? x[d] - 0.5 * (grid->lower[d] + grid->upper[d]) : 0;
}

/* Sets m [10] to the volume of a particle and its moments: V, V r, V times xx xy xz yy yz zz of r r^T. */
static void Moments(PetscReal V, const PetscReal r[3], PetscReal m[10])
{
  m[0] = V;
  for (PetscInt d = 0, k = 4; d < 3; d++) {
    m[1 + d] = V * r[d];
    for (PetscInt e = d; e < 3; e++) m[k++] = V * r[d] * r[e];
  }
}

/* Sets I [9] to the moments of inertia about c, from the moments m [10] of the particles, and returns whether every
   torque that the dimension allows can turn them. */
static PetscBool Inertia(PetscInt dim, const PetscReal m[10], const PetscReal c[3], PetscReal A[9])
{
  PetscReal trace = 0, det;

  for (PetscInt d = 0, k = 4; d < 3; d++)
    for (PetscInt e = d; e < 3; e++, k++)
      A[3 * d + e] = A[3 * e + d] = -(m[k] - m[1 + d] * c[e] - m[1 + e] * c[d] + m[0] * c[d] * c[e]);
  for (PetscInt d = 0; d < 3; d++) trace -= A[4 * d];
  for (PetscInt d = 0; d < 3; d++) A[4 * d] += trace;
  det = dim == 3 ? MPMDet(3, A) : A[8];
  return trace > 0 && det > FLAT * (dim == 3 ? trace * trace * trace : trace);
}

/* Sets c to the point of a load, from the middle of the grid, by the moments of its particles. */
static void Centre(const MPMGrid *grid, const MPMLoad *load, const PetscReal m[10], PetscReal c[3])
{
  if (load->fixed) FromMiddle(grid, load->point, c);
  for (PetscInt d = 0; d < 3 && !load->fixed; d++) c[d] = m[0] > 0 ? m[1 + d] / m[0] : 0;
}

PetscErrorCode MPMVolumeLoadsOn(const MPMScene *scene, const MPMCore *core, const MPMBody *b, const PetscReal X[],
                                MPMOptions o, PetscInt *bits)
{
  const PetscReal nowhere[3] = {0};

  PetscFunctionBeginUser;
  *bits = 0;
  for (PetscInt k = 0; k < scene->nloads; k++) {
    const MPMLoad *load     = &scene->loads[k];
    PetscReal      value[1] = {1};

    if (!MPMLoadIsOnVolume(load) || scene->bodies + load->body != b) continue;
    if (load->where) PetscCall(MPMExpressionEvaluate(load->where, core->grid.dim, nowhere, X, 0, value));
    if (o && !(PetscAbsReal(value[0]) <= PETSC_MAX_REAL))
      MPMOptionsFail(o, "-load_%s_where is not finite at X = %g%s", load->name, (double)X[0],
                     core->grid.dim > 1 ? ", ..." : "");
    if (value[0] > 0) *bits |= 1 << k;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMVolumeLoadsCount(MPMScene *scene, const MPMCore *core, const MPMBody *b, const PetscReal X[],
                                   MPMOptions o)
{
  PetscInt  bits;
  PetscReal r[3], m[10];

  PetscFunctionBeginUser;
  PetscCall(MPMVolumeLoadsOn(scene, core, b, X, o, &bits));
  FromMiddle(&core->grid, X, r);
  Moments(1, r, m);
  for (PetscInt k = 0; k < scene->nloads; k++) {
    if (!(bits >> k & 1)) continue;
    scene->loads[k].n++;
    for (PetscInt q = 0; q < 9; q++) scene->loads[k].moments[q] += m[1 + q];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMVolumeLoadsCheck(MPMScene *scene, const MPMCore *core, MPMOptions o)
{
  const PetscInt dim = core->grid.dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nloads; k++) {
    MPMLoad  *load = &scene->loads[k];
    PetscReal m[10], c[3], A[9];

    if (!MPMLoadIsOnVolume(load)) continue;
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &load->n, 1, MPIU_INT64, MPI_SUM, core->comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, load->moments, 9, MPIU_REAL, MPI_SUM, core->comm));
    m[0] = (PetscReal)load->n;
    PetscCall(PetscArraycpy(m + 1, load->moments, 9));
    Centre(&core->grid, load, m, c);
    if (!load->n)
      MPMOptionsFail(o, "-load_%s_where is positive for no particle of body %s", load->name,
                     scene->bodies[load->body].name);
    else if (load->type == MPM_LOAD_TORQUE && !Inertia(dim, m, c, A))
      MPMOptionsFail(o,
                     "-load_%s_type torque: the %" PetscInt64_FMT
                     " particle%s that it acts on cannot take it, since %s; "
                     "widen -load_%s_where",
                     load->name, load->n, load->n == 1 ? "" : "s",
                     dim == 3 ? "they lie on one line through its point" : "they lie at its point", load->name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets what a load on a volume is, by its value and by the moments m [10] of its particles. */
static void Spread(const MPMGrid *grid, const MPMLoad *load, const PetscReal value[3], const PetscReal m[10],
                   MPMVolumeLoad *v)
{
  const PetscReal torque[3] = {grid->dim == 3 ? value[0] : 0, grid->dim == 3 ? value[1] : 0,
                               value[grid->dim == 3 ? 2 : 0]};
  PetscReal c[3], A[9], cofactor[9];

  for (PetscInt d = 0; d < grid->dim && load->type == MPM_LOAD_FORCE && m[0] > 0; d++) v->even[d] = value[d] / m[0];
  if (load->type == MPM_LOAD_FORCE) return;
  Centre(grid, load, m, c);
  for (PetscInt d = 0; d < grid->dim; d++) v->centre[d] = c[d] + 0.5 * (grid->lower[d] + grid->upper[d]);
  if (!Inertia(grid->dim, m, c, A)) return; /* what is left of these particles does not turn */
  MPMCofactor(3, A, cofactor);
  for (PetscInt d = 0; d < 3 && grid->dim == 3; d++)
    for (PetscInt e = 0; e < 3; e++) v->turn[d] += cofactor[3 * d + e] * torque[e] / MPMDet(3, A);
  if (grid->dim == 2) v->turn[2] = torque[2] / A[8];
}

PetscErrorCode MPMVolumeLoadsSum(const MPMScene *scene, MPMCore *core, PetscReal t, MPMVolumeLoad loads[])
{
  const PetscInt dim = core->grid.dim, fields = MPM_BIT(x) | MPM_BIT(kind) | MPM_BIT(chosen);
  MPMSum        *sum; /* [nloads][10] */
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(10 * scene->nloads, &sum));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal r[3], m[10];

    if (!view.chosen[p]) continue;
    FromMiddle(&core->grid, view.x + p * dim, r);
    Moments(MPMKindOf(scene->kinds, &view, p)->V0, r, m);
    for (PetscInt k = 0; k < scene->nloads; k++)
      for (PetscInt q = 0; q < (scene->loads[k].type == MPM_LOAD_TORQUE ? 10 : 1); q++)
        if (view.chosen[p] >> k & 1) MPMSumAdd(&sum[10 * k + q], m[q]);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(MPMSumReduce(sum, 10 * scene->nloads, core->exchange.data));
  for (PetscInt k = 0; k < scene->nloads; k++) {
    const PetscReal nowhere[3] = {0};
    PetscReal       value[3], m[10];

    PetscCall(PetscMemzero(loads + k, sizeof *loads));
    if (!MPMLoadIsOnVolume(&scene->loads[k])) continue;
    for (PetscInt q = 0; q < 10; q++) m[q] = MPMSumValue(&sum[10 * k + q]);
    PetscCall(MPMExpressionEvaluate(scene->loads[k].value, dim, nowhere, NULL, t, value));
    Spread(&core->grid, &scene->loads[k], value, m, loads + k);
  }
  PetscCall(PetscFree(sum));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to f [dim] the force per volume, N/m^3, of the loads of these bits at x [dim], m, times `volume`. */
void MPMVolumeLoadsAdd(const MPMScene *scene, const MPMVolumeLoad loads[], PetscInt dim, PetscInt bits,
                       const PetscReal x[], PetscReal volume, PetscReal f[])
{
  for (PetscInt k = 0; k < scene->nloads; k++) {
    const PetscReal *turn = loads[k].turn;
    PetscReal        r[3] = {0};

    if (!(bits >> k & 1)) continue;
    for (PetscInt d = 0; d < dim; d++) r[d] = x[d] - loads[k].centre[d];
    for (PetscInt d = 0; d < dim; d++) {
      const PetscInt e = (d + 1) % 3, g = (d + 2) % 3;

      f[d] += volume * (loads[k].even[d] + turn[e] * r[g] - turn[g] * r[e]);
    }
  }
}
