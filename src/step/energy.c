/* energy.c - where the energy of a run comes from and goes to, summed while steps are made: the work of body forces and
   loads in every scene that has them, and all terms of the balance with -history_energy. The kernels know nothing of
   it: it reads particles and nodes between phases. Every sum is exact (MPMSum), and what a node or a particle adds
   depends on its state alone, so the terms have the same bits on any number of processes. docs/method.md derives them
   (Energy and momentum). */
#include "parallel/exchange.h"
#include "physics/wall.h"
#include "step/step.h"

#define MPM_STRESS_ROW (9 + MPM_STRESS_NC) /* F and tau of a particle as a step begins */

PetscBool MPMEnergyLost(const MPMMaterial *m)
{
  return (m->state & MPM_BIT(F)) && !(m->type->traits & MPM_HYPERELASTIC) ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether motion by FLIP is followed particle by particle. */
static PetscBool KeepsAll(const MPMEnergy *e)
{
  return e->on && e->mean == MPM_MEAN_PARTICLES ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the numbers that are kept of a particle's motion: x, v and, where there are loads, F. */
static PetscInt MotionRow(const MPMCore *core)
{
  return 2 * core->grid.dim + (core->needs.loaded ? core->grid.dim * core->grid.dim : 0);
}

/* Makes the arrays long enough for the particles here. */
static PetscErrorCode MakeRoom(MPMCore *core)
{
  MPMEnergy *e = &core->energy;

  PetscFunctionBeginUser;
  if (core->particles.n <= e->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMEnergyDestroy(e));
  e->capacity = core->particles.capacity;
  if (e->loads || KeepsAll(e)) {
    PetscCall(PetscMalloc1(e->capacity * MotionRow(core), &e->before));
    PetscCall(PetscMalloc1(e->capacity, &e->which));
  }
  if (e->on || e->nheat) PetscCall(PetscMalloc1(e->capacity * MPM_STRESS_ROW, &e->stress));
  if (e->nheat) PetscCall(PetscMalloc1(2 * e->capacity, &e->stored));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMEnergyBytes(const MPMCore *core)
{
  const MPMEnergy *e     = &core->energy;
  PetscInt         bytes = e->on || e->nheat ? MPM_STRESS_ROW * (PetscInt)sizeof(PetscReal) : 0;

  if (e->nheat) bytes += 2 * (PetscInt)sizeof(PetscReal);
  if (e->loads || KeepsAll(e)) bytes += MotionRow(core) * (PetscInt)sizeof(PetscReal) + (PetscInt)sizeof(PetscInt);
  return bytes;
}

PetscErrorCode MPMEnergyDestroy(MPMEnergy *e)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(e->before));
  PetscCall(PetscFree(e->which));
  PetscCall(PetscFree(e->stress));
  PetscCall(PetscFree(e->stored));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMEnergyHeat(MPMEnergy *e, PetscInt n)
{
  PetscFunctionBeginUser;
  e->nheat = n;
  PetscCall(PetscCalloc2(2 * n, &e->ids, n, &e->heat));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMEnergyHeatDestroy(MPMEnergy *e)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(e->ids, e->heat));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Particles ---------------------------------------------------------------------------------------------------- */

/* Copies x and v of the particles on which a body force or load acts, or of all; of those with S also F. */
static void KeepMotion(const MPMCore *core, const MPMView *view, MPMEnergy *e)
{
  const PetscInt dim = core->grid.dim, row = MotionRow(core);

  e->n = 0;
  for (PetscInt p = 0; p < view->n; p++) {
    PetscReal *to  = e->before + row * e->n;
    PetscBool  any = KeepsAll(e);

    for (PetscInt d = 0; d < dim; d++) {
      if (e->loads && view->b[p * dim + d] != 0) any = PETSC_TRUE;
      to[d]       = view->x[p * dim + d];
      to[dim + d] = view->v[p * dim + d];
    }
    for (PetscInt k = 0; k < dim * dim && e->loads && view->S; k++) {
      if (view->S[p * dim * dim + k] != 0) any = PETSC_TRUE;
      if (view->F) to[2 * dim + k] = view->F[p * dim * dim + k];
    }
    if (any) e->which[e->n++] = p;
  }
}

/* Returns S : (f - I), Pa, the work of the stress S of loads per reference volume in a step that leads from `was` to F,
   f = F was^-1 [dim*dim]. */
static PetscReal WorkOfLoads(int dim, const PetscReal *was, const PetscReal *F, const PetscReal *S)
{
  PetscReal cofactor[9], J = MPMDet(dim, was), work = 0; /* J was^-T */

  MPMCofactor(dim, was, cofactor);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++)
      for (int k = 0; k < dim; k++)
        work += S[d * dim + e] * (F[d * dim + k] - was[d * dim + k]) * cofactor[e * dim + k] / J;
  return work;
}

/* Adds m b kick . (dx/dt - dv/2), the work of body forces and loads along the mean velocity of the step, and that of
   the stress of loads; gravity's work is taken so too. If all particles are kept, adds m/2 |w|^2 as well, where w =
   kick sum phi a is the part of dv by FLIP. */
static void AddWork(const MPMCore *core, const MPMView *view, MPMEnergy *e)
{
  const MPMGrid   *grid = &core->grid;
  const MPMParams *par  = &core->params;
  const PetscInt   dim  = grid->dim;
  const PetscReal  half = core->implicit ? 0 : 0.5; /* implicit steps have no kicks */

  for (PetscInt k = 0; k < e->n; k++) {
    const PetscInt   p    = e->which[k];
    const PetscReal *was  = e->before + MotionRow(core) * k;
    const PetscReal  m    = MPMKindOf(core->params.kinds, view, p)->m;
    PetscReal        work = 0, flip = 0;

    for (PetscInt d = 0; d < dim; d++) {
      const PetscReal length = grid->upper[d] - grid->lower[d], v = view->v[p * dim + d], dv = v - was[dim + d];
      PetscReal       dx = view->x[p * dim + d] - was[d];

      if (grid->periodic[d]) dx -= length * PetscFloorReal(dx / length + 0.5);
      if (e->loads) work += view->b[p * dim + d] * par->kick * (dx / par->dt - half * dv);
      if (KeepsAll(e)) flip += PetscSqr((v - (1 - par->flip) * dx / par->dt) / par->flip - was[dim + d]);
    }
    if (e->loads) MPMSumAdd(&e->sum[MPM_ENERGY_loads], m * work);
    if (e->loads && view->S && view->F)
      MPMSumAdd(&e->sum[MPM_ENERGY_loads],
                MPMKindOf(core->params.kinds, view, p)->V0 * par->kick / par->dt *
                    WorkOfLoads((int)dim, was + 2 * dim, view->F + p * dim * dim, view->S + p * dim * dim));
    if (KeepsAll(e)) MPMSumAdd(&e->sum[MPM_ENERGY_advance], 0.5 * m * flip);
  }
}

/* Sets tau [6], Pa, of particle p, in the sequence of MPMSymIndex. */
static void Stress(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p, PetscReal tau[])
{
  MPMBlock b;

  MPMMaterialState(dim, view, p, &b);
  if (!(m->state & MPM_BIT(tau))) m->type->law->stress[MPMLawForm(m, dim)](m, 0, 1, &b);
  for (int k = 0; k < 6; k++) tau[k] = 0;
  for (int k = 0; k < MPM_SYM_NC(dim); k++) tau[MPMSymPlace((int)dim, k)] = b.tau[k][0];
}

static const MPMMaterial *MaterialOf(const MPMCore *core, const MPMView *view, PetscInt p, PetscReal *V0)
{
  const MPMKind *kind = MPMKindOf(core->params.kinds, view, p);

  *V0 = kind->V0;
  return &core->params.materials[kind->material];
}

/* Returns the energy that the law of particle p stores, per reference volume, J/m^3. Of a law that gets hot, the rise
   of its temperature is `theta`, K, if that is not NULL. */
static PetscReal Stored(PetscInt dim, const MPMMaterial *m, const MPMView *view, PetscInt p, const PetscReal *theta)
{
  PetscReal W;
  MPMBlock  b;

  MPMMaterialState(dim, view, p, &b);
  if (theta) b.theta[0][0] = *theta;
  m->type->law->energy[MPMLawForm(m, dim)](m, 0, 1, &b, &W);
  return W;
}

/* Copies F and tau of the particles whose law does not store all work. */
static void KeepStress(const MPMCore *core, const MPMView *view, MPMEnergy *e)
{
  const PetscInt dim = core->grid.dim;

  for (PetscInt p = 0; p < view->n; p++) {
    PetscReal         *to = e->stress + p * MPM_STRESS_ROW, V0;
    const MPMMaterial *m  = MaterialOf(core, view, p, &V0);

    if (!MPMEnergyLost(m)) continue;
    for (PetscInt k = 0; k < dim * dim; k++) to[k] = view->F[p * dim * dim + k];
    if (m->round) to[8] = view->F33[p]; /* dim is 2 */
    Stress(dim, m, view, p, to + 9);
    if (e->nheat) {
      e->stored[2 * p]     = Stored(dim, m, view, p, NULL);
      e->stored[2 * p + 1] = view->theta ? view->theta[p] : 0;
    }
  }
}

/* Returns the work of the stress per reference volume in a step, J/m^3: the mean of tau : (f - I) before and of
   tau : (I - f^-1) after, where f = F F_before^-1 leads from the one state to the other. */
static PetscReal WorkOfStress(int dim, const PetscReal *was, const PetscReal *F, const PetscReal *F33,
                              const PetscReal tau[])
{
  PetscReal cofactor[9], f[9], back[9], J, work = 0;

  MPMCofactor(dim, was, cofactor); /* J F^-T */
  J = MPMDet(dim, was);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) {
      f[d * dim + e] = 0;
      for (int k = 0; k < dim; k++) f[d * dim + e] += F[d * dim + k] * cofactor[e * dim + k] / J;
    }
  MPMCofactor(dim, f, cofactor);
  J = MPMDet(dim, f);
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++) back[d * dim + e] = cofactor[e * dim + d] / J;
  for (int d = 0; d < dim; d++)
    for (int e = 0; e < dim; e++)
      work += 0.5 * (was[9 + MPMSymIndex(d, e)] * (f[d * dim + e] - (d == e)) +
                     tau[MPMSymIndex(d, e)] * ((d == e) - back[d * dim + e]));
  if (F33) work += 0.5 * (was[14] * (*F33 / was[8] - 1) + tau[5] * (1 - was[8] / *F33)); /* zz, around the axis */
  return work;
}

/* Returns what viscosity dissipates in a step per reference volume, J/m^3: |dev tau|^2 dt/(2 viscosity J). */
static PetscReal Viscous(const MPMMaterial *m, PetscReal J, PetscReal dt, const PetscReal tau[])
{
  const PetscReal mean = (tau[0] + tau[3] + tau[5]) / 3;
  PetscReal       size = 0;

  for (int k = 0; k < 6; k++)
    size += k == 0 || k == 3 || k == 5 ? (tau[k] - mean) * (tau[k] - mean) : 2 * tau[k] * tau[k];
  return size * dt / (2 * m->viscosity * J);
}

/* Adds the dissipation of a particle, J, to that of its body, if this is asked for. */
static void AddHeat(const MPMView *view, PetscInt p, PetscReal heat, MPMEnergy *e)
{
  for (PetscInt k = 0; k < e->nheat; k++)
    if (view->id[p] >= e->ids[2 * k] && view->id[p] < e->ids[2 * k + 1]) MPMSumAdd(&e->heat[k], heat);
}

static void AddStress(const MPMCore *core, const MPMView *view, MPMEnergy *e)
{
  const PetscInt dim = core->grid.dim;

  for (PetscInt p = 0; p < view->n; p++) {
    PetscReal          tau[6], V0, work;
    const MPMMaterial *m       = MaterialOf(core, view, p, &V0);
    const PetscBool    viscous = m->type->traits & MPM_FLUID && m->viscosity > 0 ? PETSC_TRUE : PETSC_FALSE;

    if (!viscous && !MPMEnergyLost(m)) continue;
    Stress(dim, m, view, p, tau);
    work = V0 * (viscous ? Viscous(m, view->J[p], core->params.dt, tau)
                         : WorkOfStress((int)dim, e->stress + p * MPM_STRESS_ROW, view->F + p * dim * dim,
                                        m->round ? view->F33 + p : NULL, tau));
    if (e->on) MPMSumAdd(&e->sum[MPM_ENERGY_stress], work);
    if (e->nheat && viscous) AddHeat(view, p, work, e);
    if (e->nheat && !viscous && m->type->law->update[dim - 1]) /* what became heat in the step is no stored energy */
      AddHeat(view, p, work - V0 * (Stored(dim, m, view, p, &e->stored[2 * p + 1]) - e->stored[2 * p]), e);
  }
}

/* What the laws that store only a part of their work gain is taken off the work of their stress, of which the term laws
   is the rest. */
PetscErrorCode MPMEnergyVolumes(MPMCore *core, PetscInt sign)
{
  const PetscInt fields = MPM_MATERIAL_BITS | MPM_BIT(kind);
  MPMSum        *sum    = core->energy.sum;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal          V0, stored;
    const MPMMaterial *m = MaterialOf(core, &view, p, &V0);

    if (!(m->follows > 0)) continue;
    stored = sign * V0 * Stored(core->grid.dim, m, &view, p, NULL);
    MPMSumAdd(&sum[MPM_ENERGY_volumes], stored);
    if (MPMEnergyLost(m)) MPMSumAdd(&sum[MPM_ENERGY_stress], stored);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Nodes -------------------------------------------------------------------------------------------------------- */

/* Returns whether a moving wall acts on node ijk; a piston acts on those beside its plane where it holds them. */
static PetscBool AtMovingWall(const MPMWalls *walls, const MPMGrid *grid, const PetscInt ijk[], PetscReal met)
{
  for (PetscInt d = 0; d < grid->dim; d++)
    for (PetscInt side = 0; side < 2; side++) {
      const MPMFace *f      = &walls->given[d][side];
      const PetscInt inside = MPMWallInside(grid, 2 * d + side, ijk);

      if (!MPMWallHas(f->type, MPM_WALL_MOVES) || !MPMWallActs(f, inside)) continue;
      if (inside <= f->reach || MPMNodeStopped(met, d)) return PETSC_TRUE;
    }
  return PETSC_FALSE;
}

/* Adds, times `share`, the work of the acceleration of node n, number i on x, along the velocity u [dim], which is that
   of the particles' momentum. Forces work along s [dim], with which the matter moves: it differs from u where a wall or
   contact held the node. Their part is the rest. `held`: what PIC takes over besides from a moving wall, J. */
static void AddNode(const MPMCore *core, const MPMNode *n, PetscInt i, const PetscReal a[], const PetscReal u[],
                    const PetscReal s[], PetscReal share, PetscBool moving, PetscReal held, MPMEnergy *e)
{
  const MPMParams *par = &core->params;
  PetscReal        all = 0, gravity = 0, wall = 0;

  for (PetscInt d = 0; d < core->grid.dim; d++) {
    const PetscReal impulse = share * par->kick * MPMNodeMass(&core->grid, n, i, d);

    all += impulse * a[d] * u[d];
    gravity += impulse * par->gravity[d] * s[d];
    wall += impulse * MPMEnergyWall(core, n, i, d, a[d], u[d], s[d]);
  }
  MPMSumAdd(&e->sum[MPM_ENERGY_advance], all + held);
  MPMSumAdd(&e->sum[MPM_ENERGY_gravity], gravity);
  MPMSumAdd(&e->sum[moving ? MPM_ENERGY_walls : MPM_ENERGY_friction], wall + held);
}

/* Adds what the advance of a node did. `before` is its velocity before the advance as walls leave it. Where a moving
   wall holds the node, PIC also takes over the momentum that the wall gave it before the advance: its share is 1 -
   flip. */
static void AddAdvance(const MPMCore *core, const MPMNode *n, PetscReal met, const PetscReal *motion,
                       const PetscInt ijk[], MPMEnergy *e)
{
  const MPMParams *par    = &core->params;
  const PetscInt   dim    = core->grid.dim;
  const PetscReal *a      = motion + dim;
  const PetscBool  moving = AtMovingWall(par->walls, &core->grid, ijk, met);
  PetscReal        u[3], s[3], push[3], along = 0, held = 0;

  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal before = motion[d] - par->kick * a[d];

    if (moving) held += (1 - par->flip) * (MPMNodeMass(&core->grid, n, ijk[0], d) * before - n->p[d]) * before;
    u[d] = before + (e->mean == MPM_MEAN_NODES ? 0.5 * par->kick * a[d] : 0);
    s[d] = MPMNodeStopped(met, d) ? motion[d] : u[d];
  }
  if (e->mean != MPM_MEAN_PARTICLES &&
      MPMContactsPush(core, ijk, push)) { /* there the strain is made before contact acts */
    for (PetscInt d = 0; d < dim; d++) along += push[d] * (motion[d] - s[d]);
    for (PetscInt d = 0; d < dim; d++) s[d] += along * push[d];
  }
  AddNode(core, n, ijk[0], a, u, s, e->mean == MPM_MEAN_AGAIN ? 0.5 : 1, moving, held, e);
}

/* Adds the other half of it, along the velocity of the second mapping of musl. */
static void AddAgain(const MPMCore *core, const MPMNode *n, PetscReal met, const PetscReal *motion,
                     const PetscInt ijk[], MPMEnergy *e)
{
  const PetscInt  dim = core->grid.dim;
  PetscReal       u[3], push[3];
  const PetscBool pushed = MPMContactsPush(core, ijk, push);

  for (PetscInt d = 0; d < dim; d++)
    u[d] = pushed || MPMNodeStopped(met, d) ? n->p[d] / MPMNodeMass(&core->grid, n, ijk[0], d) : motion[d];
  AddNode(core, n, ijk[0], motion + dim, u, motion, 0.5, AtMovingWall(core->params.walls, &core->grid, ijk, met), 0, e);
}

/* Adds what moved a node in the total frame along u [dim], the mean of its velocities before and after: its forces,
   gravity, and the force of walls, which is in p. v: its velocity now, was: before. */
static void AddKick(const MPMCore *core, const MPMNode *n, const PetscReal v[], const PetscReal was[],
                    const PetscInt ijk[], MPMEnergy *e)
{
  const MPMParams *par    = &core->params;
  const PetscBool  moving = AtMovingWall(par->walls, &core->grid, ijk, 0);

  for (PetscInt d = 0; d < core->grid.dim; d++) {
    const PetscReal way = 0.5 * par->kick * (v[d] + was[d]), gravity = n->m * par->gravity[d] * way,
                    wall = n->p[d] * way;

    MPMSumAdd(&e->sum[MPM_ENERGY_advance], n->f[d] * way + gravity + wall);
    MPMSumAdd(&e->sum[MPM_ENERGY_gravity], gravity);
    MPMSumAdd(&e->sum[moving ? MPM_ENERGY_walls : MPM_ENERGY_friction], wall);
  }
}

PetscErrorCode MPMEnergyNodes(MPMCore *core, const MPMPhase *phase)
{
  const MPMPatch *patch   = &core->exchange.patch;
  const PetscBool kicks   = MPMTotalKicks(phase);
  const PetscBool advance = phase->nodes == MPMNodesAdvance ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt  dim     = core->grid.dim;
  MPMEnergy      *e       = &core->energy;

  PetscFunctionBeginUser;
  if (!advance && !kicks && !(e->mean == MPM_MEAN_AGAIN && phase->nodes == MPMNodesVelocityAgain))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMExchangeOpenNodes(core));
  MPM_FOR_OWN_ROWS(patch, r)
  for (PetscInt i = r.first; i < r.last; i++) {
    const PetscReal *motion = r.motion + i * MPM_MOTION_NC(dim);
    const PetscInt   ijk[3] = {r.ijk[0] + i, r.ijk[1], r.ijk[2]};

    if (!(r.sum[i].m > 0)) continue;
    if (kicks)
      AddKick(core, r.sum + i, motion + dim,
              core->before + ((PetscInt)(r.state - patch->state) + i * MPM_MOTION_NC(dim)) + dim, ijk, e);
    else if (advance)
      AddAdvance(core, r.sum + i, r.value.met[i], motion, ijk, e);
    else
      AddAgain(core, r.sum + i, r.value.met[i], motion, ijk, e);
  }
  PetscCall(MPMExchangeCloseNodes(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- A step ------------------------------------------------------------------------------------------------------- */

PetscErrorCode MPMEnergyStep(MPMCore *core, PetscBool begins)
{
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v) | MPM_BIT(b) | MPM_BIT(S) | MPM_MATERIAL_BITS |
                          MPM_BIT(kind);
  MPMEnergy *e = &core->energy;
  MPMView    view;

  PetscFunctionBeginUser;
  PetscCall(MakeRoom(core));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  if (e->loads || KeepsAll(e)) {
    if (begins)
      KeepMotion(core, &view, e);
    else
      AddWork(core, &view, e);
  }
  if (e->on || e->nheat) {
    if (begins)
      KeepStress(core, &view, e);
    else
      AddStress(core, &view, e);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}
