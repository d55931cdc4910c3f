/* pistons.c - planes that move through the grid: what they do to the nodes beside them. A piston acts on the columns of
   nodes along its normal, one for each node of its face. If the matter of a column would come nearer to the plane than
   its gap allows, or leave a piston that holds it, the piston gives it an impulse at its surface.

   The surface of the matter has for node k the weight N_k = - sum_p V_p d phi_kp/dn, n away from the piston: by it the
   column's matter ends with the velocity w = sum_k N_k v_k, where sum N_k = 1, and an impulse p there is the part N_k p
   of node k. A uniform stress along n needs just these parts to be at rest, at every node, however little mass it has;
   with other parts the last particles come off. w changes by p sum_k N_k^2/m_k.

   This is done after each update of nodes from which particles take something: ADVANCE decides which columns are held,
   and the others of the step follow. Nodes that another wall holds take what they get. The weights are sums of whole
   numbers, and the nodes of a column, which may be on several processes, are collected in sums of which all other terms
   are 0: both have the same bits in every sequence. docs/method.md has the formulas (Walls). */
#include "kernels/cell.h"
#include "physics/wall.h"
#include "step/step.h"

#define TOUCHES 0.05          /* cells: what is nearer than this to a piston that pulls is held */
#define CLOSES  50            /* steps in which what is held comes nearer by its gap, so that errors do not add up */
#define UNIT    ldexp(1, -50) /* of the weights, in sides of cells */
#define MOST    ldexp(1, 54)  /* of what a particle adds to a weight, in units */

PetscErrorCode MPMPistonsCreate(MPMCore *core)
{
  PetscInt any = 0, most = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 2 * core->grid.dim; k++)
    if (core->params.walls->given[k / 2][k % 2].type == MPM_WALL_piston) {
      any  = 1;
      most = PetscMax(most, MPMFaceNodes(&core->grid, k / 2, PETSC_TRUE));
    }
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&core->pistons));
  PetscCall(PetscCalloc4(MPM_MAX_STENCIL * core->gaps->n, &core->pistons->weight, 2 * MPM_MAX_STENCIL * most,
                         &core->pistons->sum, core->gaps->n, &core->pistons->held, core->gaps->n,
                         &core->pistons->relative));
  PetscCall(PetscCalloc2(MPM_MAX_STENCIL * most, &core->pistons->share, most, &core->pistons->impulse));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPistonsDestroy(MPMCore *core)
{
  MPMPistons *p = core->pistons;

  PetscFunctionBeginUser;
  if (p) PetscCall(PetscFree4(p->weight, p->sum, p->held, p->relative));
  if (p) PetscCall(PetscFree2(p->share, p->impulse));
  PetscCall(PetscFree(core->pistons));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Weights ------------------------------------------------------------------------------------------------------ */

/* Returns the volume of particle p over that of the start, as far as its law keeps it. */
static PetscReal VolumeRatio(const MPMCore *core, const MPMView *view, PetscInt p, const MPMMaterial *m)
{
  const int dim = (int)core->grid.dim;

  if (MPMMaterialKeepsShape(m)) return MPMVolumeRatio(m, dim, view, p);
  return m->type->traits & MPM_FLUID ? view->J[p] : 1;
}

/* Adds to the weights of the nodes beside the piston of face k what particle p has for them. */
static void Weigh(MPMCore *core, const MPMView *view, PetscInt p, PetscInt k)
{
  const MPMGrid   *grid = &core->grid;
  const int        dim = (int)grid->dim, axis = (int)k / 2;
  const MPMFace   *f       = &core->params.walls->given[axis][k % 2];
  const MPMKind   *kind    = MPMKindOf(core->params.kinds, view, p);
  const PetscReal *l       = MPMHalfWidths(dim, core->params.kinds, view, p);
  PetscReal        units   = (k % 2 ? 1 : -1) * kind->V0 / UNIT, w[3][MPM_MAX_STENCIL], g[3][MPM_MAX_STENCIL], xi[3];
  PetscInt         base[3] = {0}, n[3] = {1, 1, 1}, ijk[3], at[3];

  units *= VolumeRatio(core, view, p, core->params.materials + kind->material);
  MPMCoordinates(dim, core->basis, grid, view->x + p * dim, l, xi, base);
  for (int d = 0; d < dim; d++) {
    n[d] = MPMBasisNodes(core->basis);
    MPMBasisWeights(core->basis, xi[d], l[d], base[d], grid->cells[d], grid->wall_basis[d], w[d], g[d]);
    units /= grid->h[d]; /* of the gradient, or of a side of a cell */
  }
  for (at[2] = 0; at[2] < n[2]; at[2]++)
    for (at[1] = 0; at[1] < n[1]; at[1]++)
      for (at[0] = 0; at[0] < n[0]; at[0]++) {
        PetscReal part = units;
        PetscInt  j;

        for (int d = 0; d < dim; d++) {
          ijk[d] = base[d] + at[d] + MPMGridFirst(grid, d, kind->copy);
          part *= d == axis ? g[d][at[d]] : w[d][at[d]];
        }
        j = base[axis] + at[axis] - f->first;
        if (j < 0 || j >= f->beside) continue;
        part = PetscMax(-MOST, PetscMin(MOST, part));
        core->pistons->weight[(core->gaps->first[k] + MPMFaceNode(grid, axis, ijk)) * MPM_MAX_STENCIL + j] +=
            (PetscInt64)part;
      }
}

PetscErrorCode MPMPistonsUpdate(MPMCore *core)
{
  const MPMGrid *grid   = &core->grid;
  const PetscInt fields = MPM_BIT(x) | MPM_BIT(F) | MPM_BIT(F33) | MPM_BIT(J) | MPM_BIT(kind) | MPM_BIT(l),
                 dim    = grid->dim;
  const PetscInt n      = MPM_MAX_STENCIL * core->gaps->n;
  PetscMPIInt    count;
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(core->pistons->weight, n));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt k = 0; k < 2 * dim; k++) {
    const PetscReal h = grid->h[k / 2];
    PetscReal       plane, sign;

    if (core->params.walls->given[k / 2][k % 2].type != MPM_WALL_piston) continue;
    MPMWallPlane(core->params.walls, grid, k, &plane, &sign);
    core->params.plane[k][0] = plane;
    core->params.plane[k][1] = plane + core->params.dt * core->params.walls->given[k / 2][k % 2].velocity[k / 2];
    for (PetscInt p = 0; p < view.n; p++) {
      const PetscReal at = sign * (view.x[p * dim + k / 2] - plane);

      if (at > -h && at < MPM_MAX_STENCIL * h) Weigh(core, &view, p, k);
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(PetscMPIIntCast(n, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, core->pistons->weight, count, MPIU_INT64, MPI_SUM, core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Nodes -------------------------------------------------------------------------------------------------------- */

/* A node beside a piston: its column, and which of the nodes beside the plane it is; is it held by another wall; is it
   beyond another face, where gimp has nodes for domains that reach across it? It belongs to the column of the edge
   then. */
typedef struct {
  PetscInt  column, j;
  PetscBool held, beyond;
  PetscReal m, *motion, *met; /* its mass, kg, motion and walls met */
} Beside;

/* Returns whether a wall besides the piston of face k holds node ijk along the normal of that. */
static PetscBool HeldByOther(const MPMCore *core, PetscInt k, const PetscInt ijk[])
{
  const MPMGrid *grid = &core->grid;

  for (PetscInt q = 0; q < 2 * grid->dim; q++) {
    const MPMFace *f      = &core->params.walls->given[q / 2][q % 2];
    const PetscInt inside = MPMWallInside(grid, q, ijk);

    if (q == k || inside > 0 || !MPMWallHas(f->type, MPM_WALL_NORMAL) || f->type == MPM_WALL_piston) continue;
    if (q / 2 == k / 2 || MPMWallHas(f->type, MPM_WALL_TANGENT)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Calls act for each own node beside the piston of face k that has mass. */
static void ForNodes(MPMCore *core, PetscInt k, PetscBool advance,
                     void (*act)(MPMCore *, PetscInt k, PetscBool advance, const Beside *))
{
  const MPMPatch *patch = &core->exchange.patch;
  const MPMFace  *f     = &core->params.walls->given[k / 2][k % 2];
  const PetscInt  d = k / 2, end = f->first + f->beside;

  MPM_FOR_OWN_ROWS(patch, r)
  {
    const MPMGrid *grid   = patch->grid;
    const PetscInt at     = d ? MPMGridFold(grid, d, r.ijk[d]) : f->first;
    PetscInt       ijk[3] = {0, r.ijk[1], r.ijk[2]};

    for (PetscInt i = r.first; i < r.last && at >= f->first && at < end; i++) {
      Beside b = {.m      = MPMNodeMass(grid, r.sum + i, r.ijk[0] + i, d),
                  .motion = r.motion + i * MPM_MOTION_NC(core->grid.dim),
                  .met    = r.value.met + i};

      ijk[0] = r.ijk[0] + i;
      b.j    = MPMGridFold(grid, d, ijk[d]) - f->first;
      if (b.j < 0 || b.j >= f->beside) continue;
      b.column = MPMFaceNode(&core->grid, d, ijk);
      b.held   = HeldByOther(core, k, ijk);
      b.beyond = PETSC_FALSE;
      for (PetscInt q = 0; q < core->grid.dim; q++)
        if (q != d && !grid->periodic[q] &&
            (MPMWallInside(grid, 2 * q, ijk) < 0 || MPMWallInside(grid, 2 * q + 1, ijk) < 0))
          b.beyond = PETSC_TRUE;
      if (b.m > 0) act(core, k, advance, &b);
    }
  }
}

/* Tells the column of a node what the node has; one that is held has an infinite mass. */
static void Tell(MPMCore *core, PetscInt k, PetscBool advance, const Beside *b)
{
  PetscReal *to = core->pistons->sum + 2 * (b->column * MPM_MAX_STENCIL + b->j);

  (void)advance;
  if (b->beyond) return; /* its mass is a small part of that of the edge, whose velocity it gets */
  to[0] = b->motion[k / 2];
  to[1] = b->held ? PETSC_INFINITY : b->m;
}

/* Gives a node its part of the impulse of its column. */
static void Give(MPMCore *core, PetscInt k, PetscBool advance, const Beside *b)
{
  const MPMPistons *p  = core->pistons;
  const PetscInt    d  = k / 2;
  const PetscInt    at = b->column * MPM_MAX_STENCIL + b->j;
  const PetscReal   by = b->held || !(p->share[at] > 0) ? 0 : p->impulse[b->column] * p->share[at] / p->sum[2 * at + 1];

  b->motion[d] += by;
  if (!advance) return;
  b->motion[core->grid.dim + d] += by / core->params.kick;
  if (p->held[core->gaps->first[k] + b->column]) *b->met = (PetscReal)((PetscInt)*b->met | (PetscInt)8 << d);
}

/* --- Columns ------------------------------------------------------------------------------------------------------ */

/* Decides what the velocity w of the end of column i of all faces, relative to the piston and away from it, m/s, is to
   be. Returns whether the piston changes it. */
static PetscBool Decide(const MPMCore *core, const MPMFace *f, PetscReal h, PetscInt i, PetscReal w, PetscReal *to)
{
  const PetscReal least = core->gaps->least[i], pulled = core->gaps->least[core->gaps->n + i];

  *to = least;
  if (w < least) return PETSC_TRUE;
  if (!f->pulls || !(pulled < TOUCHES * h)) return PETSC_FALSE;
  *to = core->params.dt > 0 ? -PetscMax(0, pulled) / (CLOSES * core->params.dt) : 0; /* dt 0: no step yet */
  return w > *to;
}

/* Returns whether the piston of face k changes the velocity w of the end of column i of all faces in this phase, and to
   what. */
static PetscBool Changes(MPMCore *core, PetscInt k, const MPMPhase *phase, PetscInt i, PetscReal w, PetscReal *to)
{
  const MPMFace *f = &core->params.walls->given[k / 2][k % 2];
  MPMPistons    *p = core->pistons;

  if (phase->nodes == MPMNodesVelocity) return Decide(core, f, core->grid.h[k / 2], i, w, to);
  if (phase->nodes == MPMNodesAdvance) p->held[i] = Decide(core, f, core->grid.h[k / 2], i, w, &p->relative[i]);
  *to = p->relative[i];
  if (phase->nodes != MPMNodesResidual) return p->held[i];
  *to = 0;
  return core->gaps->least[i] >= 0;
}

/* Finds the impulses of the columns of face k, and the shares of their nodes in them. */
static void FindImpulses(MPMCore *core, PetscInt k, const MPMPhase *phase, PetscInt columns)
{
  MPMPistons     *p    = core->pistons;
  const MPMFace  *f    = &core->params.walls->given[k / 2][k % 2];
  const PetscReal sign = k % 2 ? -1 : 1, V = phase->nodes == MPMNodesResidual ? 0 : f->velocity[k / 2];

  for (PetscInt c = 0; c < columns; c++) {
    const PetscReal  *sum    = p->sum + 2 * MPM_MAX_STENCIL * c;
    const PetscInt64 *weight = p->weight + MPM_MAX_STENCIL * (core->gaps->first[k] + c);
    PetscReal        *share = p->share + MPM_MAX_STENCIL * c, all = 0, w = 0, inverse = 0, to;

    p->impulse[c] = 0;
    for (PetscInt j = 0; j < f->beside; j++) {
      share[j] = sum[2 * j + 1] > 0 ? (PetscReal)PetscMax(0, weight[j]) : 0;
      all += share[j];
    }
    for (PetscInt j = 0; j < f->beside && all > 0; j++) {
      share[j] /= all;
      if (!(share[j] > 0)) continue;
      w += share[j] * sum[2 * j];
      inverse += share[j] * share[j] / sum[2 * j + 1];
    }
    w = sign * (w - V);
    if (!(inverse > 0)) w = PETSC_INFINITY; /* there is nothing, or another wall holds all of it */
    if (Changes(core, k, phase, core->gaps->first[k] + c, w, &to) && inverse > 0)
      p->impulse[c] = sign * (to - w) / inverse;
  }
}

PetscErrorCode MPMPistonsAfter(MPMCore *core, const MPMPhase *phase)
{
  const PetscBool advance = phase->nodes == MPMNodesAdvance;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 2 * core->grid.dim; k++) {
    const PetscInt columns = MPMFaceNodes(&core->grid, k / 2, PETSC_FALSE), numbers = 2 * MPM_MAX_STENCIL * columns;
    PetscMPIInt    count;

    if (core->params.walls->given[k / 2][k % 2].type != MPM_WALL_piston) continue;
    PetscCall(PetscArrayzero(core->pistons->sum, numbers));
    ForNodes(core, k, advance, Tell);
    PetscCall(PetscMPIIntCast(numbers, &count));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, core->pistons->sum, count, MPIU_REAL, MPI_SUM, core->exchange.data));
    FindImpulses(core, k, phase, columns);
    ForNodes(core, k, advance, Give);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
