/* energy.c - where the energy of a run comes from and goes to, summed while steps are made: the work of body forces and
   loads in every scene that has them, and all terms of the balance with -history_energy. The kernels know nothing of
   it: it reads particles and nodes between phases. Every sum is exact (MPMSum), and what a node or a particle adds
   depends on its state alone, so the terms have the same bits on any number of processes. docs/method.md derives them
   (Energy and momentum). */
#include "parallel/exchange.h"
#include "physics/wall.h"
#include "step/energy.h"

/* Returns whether motion by FLIP is followed particle by particle. */
static PetscBool KeepsAll(const MPMEnergy *e)
{
  return e->on && e->mean == MPM_MEAN_PARTICLES;
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
   the stress of loads; gravity's work is taken so too. Takes off what AddAdvance adds of m b, along dx/dt - dv. If all
   particles are kept, adds m/2 |w|^2 as well, where w = kick sum phi a is the part of dv by FLIP. */
static void AddWork(const MPMCore *core, const MPMView *view, MPMEnergy *e)
{
  const MPMGrid   *grid = &core->grid;
  const MPMParams *par  = &core->params;
  const PetscInt   dim  = grid->dim;
  const PetscReal  half = core->implicit ? 0 : 0.5; /* implicit steps have no kicks */
  const PetscBool  maps = e->loads && e->maps && e->strained;

  for (PetscInt k = 0; k < e->n; k++) {
    const PetscInt   p    = e->which[k];
    const PetscReal *was  = e->before + MotionRow(core) * k;
    const PetscReal  m    = MPMKindOf(core->params.kinds, view, p)->m;
    PetscReal        work = 0, flip = 0, mapped = 0;

    for (PetscInt d = 0; d < dim; d++) {
      const PetscReal length = grid->upper[d] - grid->lower[d], v = view->v[p * dim + d], dv = v - was[dim + d];
      PetscReal       dx = view->x[p * dim + d] - was[d];

      if (grid->periodic[d]) dx -= length * PetscFloorReal(dx / length + 0.5);
      if (e->loads) work += view->b[p * dim + d] * par->kick * (dx / par->dt - half * dv);
      if (maps) mapped += view->b[p * dim + d] * (par->kick - 0.5 * par->dt) * (dx / par->dt - dv);
      if (KeepsAll(e)) flip += PetscSqr((v - (1 - par->flip) * dx / par->dt) / par->flip - was[dim + d]);
    }
    if (e->loads) MPMSumAdd(&e->sum[MPM_ENERGY_loads], m * work);
    if (maps) MPMSumAdd(&e->sum[MPM_ENERGY_mapped], -m * mapped);
    if (e->loads && view->S && view->F)
      MPMSumAdd(&e->sum[MPM_ENERGY_loads],
                MPMKindOf(core->params.kinds, view, p)->V0 * par->kick / par->dt *
                    WorkOfLoads((int)dim, was + 2 * dim, view->F + p * dim * dim, view->S + p * dim * dim));
    if (KeepsAll(e)) MPMSumAdd(&e->sum[MPM_ENERGY_advance], 0.5 * m * flip);
  }
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

/* Returns the work of the force of a node along v [dim] over a time, J. */
static PetscReal WorkOfForce(const MPMCore *core, const MPMNode *n, const PetscReal v[], PetscReal time)
{
  PetscReal work = 0;

  for (PetscInt d = 0; d < core->grid.dim; d++) work += n->f[d] * v[d] * time;
  return work;
}

/* Returns whether a later phase of the step than number k corrects the velocity of the advance, which then makes no strain. */
static PetscBool IsCorrected(const MPMCore *core, PetscInt k)
{
  while (++k < core->nprogram)
    if (core->program[k]->nodes == MPMNodesCorrect) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Adds what the advance of a node did. `before` is its velocity before the advance as walls leave it. Where a moving
   wall holds the node, PIC also takes over the momentum that the wall gave it before the advance: its share is 1 -
   flip. Of the work of the force, the part of the time before the advance is along the velocity as it was mapped, while
   the strain of the last step was made by those of that step: the difference is what the mapping gives. */
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
  if (!e->maps || !e->strained) return;
  for (PetscInt d = 0; d < dim && e->mean == MPM_MEAN_NODES; d++) s[d] = 2 * s[d] - motion[d];
  MPMSumAdd(&e->sum[MPM_ENERGY_mapped], WorkOfForce(core, n, s, par->kick - 0.5 * par->dt));
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

PetscErrorCode MPMEnergyNodes(MPMCore *core, PetscInt k)
{
  const MPMPhase *phase   = core->program[k];
  const MPMPatch *patch   = &core->exchange.patch;
  const PetscBool kicks   = MPMTotalKicks(phase);
  const PetscBool advance = phase->nodes == MPMNodesAdvance;
  const PetscInt  dim     = core->grid.dim;
  MPMEnergy      *e       = &core->energy;
  const PetscBool direct = e->maps && e->mean == MPM_MEAN_NODES, later = IsCorrected(core, k),
                  corrects = direct && phase->nodes == MPMNodesCorrect && !later;

  PetscFunctionBeginUser;
  if (!advance && !kicks && !corrects && !(e->mean == MPM_MEAN_AGAIN && phase->nodes == MPMNodesVelocityAgain))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMExchangeOpenNodes(core));
  MPM_FOR_OWN_ROWS(patch, r)
  for (PetscInt i = r.first; i < r.last; i++) {
    const PetscReal *motion = r.motion + i * MPM_MOTION_NC(dim);
    const PetscInt   ijk[3] = {r.ijk[0] + i, r.ijk[1], r.ijk[2]};

    if (!(r.sum[i].m > 0)) continue;
    if (corrects || (advance && direct && later)) /* the strain is made by the velocity of the last correction */
      MPMSumAdd(&e->sum[MPM_ENERGY_mapped],
                WorkOfForce(core, r.sum + i, motion, (corrects ? -0.5 : 0.5) * core->params.dt));
    if (corrects) continue;
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
    if (begins) {
      MPMSumZero(&e->sum[MPM_ENERGY_half]);
      MPMEnergyKeepStress(core, &view, e);
    } else {
      if (e->maps) PetscCall(MPMExchangeOpenNodes(core));
      MPMEnergyAddStress(core, &view, e);
      if (e->maps) PetscCall(MPMExchangeCloseNodes(core));
      e->strained = e->maps;
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}
