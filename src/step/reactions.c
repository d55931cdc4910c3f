/* reactions.c - what walls give the matter: the impulse of the wall of each face on the nodes, N s, and its work, J,
   for the faces that the history asks for (-history_walls). It reads nodes between phases, as energy.c does, and
   every sum is exact (MPMSum), so a sum has the same bits on any number of processes. docs/method.md derives them
   (Reactions of walls).

   What particles take over of a wall depends on the transfer. FLIP takes the acceleration that the wall made, PIC
   and APIC the momentum that they find at the nodes; xpic takes FLIP's part and loses what its last filter phase
   does not give back; afmpm takes FLIP's part and that of its last correction. The sum over all walls is the change
   of the particles' momentum less the impulse of gravity and loads. */
#include "parallel/exchange.h"
#include "physics/wall.h"
#include "step/step.h"

PetscErrorCode MPMReactionsCreate(MPMCore *core, PetscInt faces)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(&core->reactions));
  core->reactions->faces = faces;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReactionsDestroy(MPMCore *core)
{
  PetscFunctionBeginUser;
  if (core->reactions) PetscCall(PetscFree(core->reactions->before));
  PetscCall(PetscFree(core->reactions));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the phases whose walls count, after the program of a step is known: the advance always does; of the phases
   before it that of the last filter of xpic, and after it that of the last correction of afmpm. */
void MPMReactionsSetUp(MPMCore *core)
{
  MPMReactions *r      = core->reactions;
  PetscInt      filter = -1, advance = -1;

  if (!r) return;
  r->filter = r->correct = -1;
  for (PetscInt k = 0; k < core->nprogram; k++) {
    const MPMPhase *phase = core->program[k];

    if (phase->kind == MPM_NODES && phase->nodes == MPMNodesAdvance) advance = k;
    if (phase->kind == MPM_NODES && phase->nodes == MPMNodesCorrect) r->correct = k;
    if (advance < 0 && k > 0 && phase->parts & MPM_G2P_FILTER && phase->kind == MPM_NODES_TO_PARTICLES) filter = k - 1;
  }
  r->filter = filter;
}

/* The walls of a node: the faces that reach it, as numbers 2 axis + side. */
typedef struct {
  PetscInt n, face[6];
} Touch;

/* Finds the walls of node ijk; those beside the plane of a piston have it as a wall where it holds them, or if `held`.
   */
static void SetTouch(const MPMCore *core, const PetscInt ijk[], PetscReal met, PetscBool held, Touch *t)
{
  const MPMGrid *grid = &core->grid;

  t->n = 0;
  for (PetscInt k = 0; k < 2 * grid->dim; k++) {
    const MPMFace *f      = &core->params.walls->given[k / 2][k % 2];
    const PetscInt inside = MPMWallInside(grid, k, ijk);

    if (!MPMWallActs(f, inside) || MPMWallHas(f->type, MPM_WALL_OPEN)) continue;
    if (inside <= f->reach || held || MPMNodeStopped(met, k / 2)) t->face[t->n++] = k;
  }
}

/* Sets the shares [6] of the walls of a node in component d of its impulse J [dim]. A component goes to the wall whose
   normal it is along, if this wall can have made it; else to the walls that hold all components, or to the walls with
   friction, each by what it presses. */
static void SetShares(const MPMCore *core, const Touch *t, PetscInt d, const PetscReal J[], PetscReal share[])
{
  const MPMFace(*faces)[2] = core->params.walls->given;
  PetscReal sum            = 0;
  PetscBool held           = PETSC_FALSE;

  for (PetscInt k = 0; k < 6; k++) share[k] = 0;
  for (PetscInt n = 0; n < t->n; n++) {
    const PetscInt k    = t->face[n];
    const MPMWall  type = faces[k / 2][k % 2].type;

    if (MPMWallHas(type, MPM_WALL_TANGENT)) held = PETSC_TRUE;
    if (k / 2 != d) continue;
    if (!MPMWallHas(type, MPM_WALL_PUSHES) || (k % 2 ? -J[d] : J[d]) > 0) {
      share[k] = 1;
      return;
    }
  }
  for (PetscInt n = 0; n < t->n; n++) {
    const PetscInt k = t->face[n];
    const MPMFace *f = &faces[k / 2][k % 2];

    if (k / 2 == d) continue;
    if (held)
      share[k] = MPMWallHas(f->type, MPM_WALL_TANGENT) ? 1 : 0;
    else if (MPMWallHas(f->type, MPM_WALL_BRAKES))
      share[k] = f->mu * PetscAbsReal(J[k / 2]);
    sum += share[k];
  }
  if (sum > 0)
    for (PetscInt k = 0; k < 6; k++) share[k] /= sum;
  else
    share[t->face[0]] = 1;
}

/* Adds the impulse J [dim], N s, and the work W [dim], J, of the walls of a node; again: the impulse has been added
   before, and J says whose the work is. */
static void Give(MPMCore *core, const Touch *t, PetscBool again, const PetscReal J[], const PetscReal W[])
{
  MPMReactions *r = core->reactions;

  for (PetscInt d = 0; d < core->grid.dim; d++) {
    PetscReal share[6];

    if (J[d] == 0 && W[d] == 0) continue;
    SetShares(core, t, d, J, share);
    for (PetscInt k = 0; k < 6; k++) {
      if (!(share[k] > 0) || !(r->faces & (PetscInt)1 << k)) continue;
      if (!again) MPMSumAdd(&r->impulse[k][d], share[k] * J[d]);
      MPMSumAdd(&r->work[k], share[k] * W[d]);
    }
  }
}

/* Sets V [dim] to the velocity at which walls hold the node; walls that do not move have the velocity 0. At a corner
   the last wall counts, but for the normals of others, as in physics/wall.c. */
static void WallVelocity(const MPMCore *core, const Touch *t, PetscReal V[])
{
  for (PetscInt d = 0; d < core->grid.dim; d++) V[d] = 0;
  for (PetscInt n = 0; n < 2 * t->n; n++) { /* the normals once more, after all */
    const PetscInt k = t->face[n % t->n];
    const MPMFace *f = &core->params.walls->given[k / 2][k % 2];

    for (PetscInt d = 0; d < core->grid.dim; d++)
      if ((n < t->n && MPMWallHas(f->type, MPM_WALL_TANGENT)) || d == k / 2) V[d] = f->velocity[d];
  }
}

/* Adds what the walls of node ijk [3] did in the advance, less what contact did; v, a: its motion after it. u is the mean velocity of energy.c,
   along which the impulse does its work. n->p still is the momentum that the particles gave. */
static void AddAdvance(MPMCore *core, const Touch *t, const MPMNode *n, PetscReal met, const PetscInt ijk[],
                       const PetscReal v[])
{
  const MPMParams    *par  = &core->params;
  const MPMReactions *r    = core->reactions;
  const PetscReal     flip = r->filter >= 0 || r->correct >= 0 ? 1 : par->flip, *a = v + core->grid.dim;
  PetscReal           J[3], W[3], contact[3] = {0};

  if (core->contacts) MPMContactsGave(core, ijk, contact);
  for (PetscInt d = 0; d < core->grid.dim; d++) {
    const PetscReal m = MPMNodeMass(&core->grid, n, ijk[0], d), other = n->f[d] / m + par->gravity[d],
                    wall   = par->kick * m * (a[d] - other);
    const PetscReal before = v[d] - par->kick * a[d],
                    u      = before + (core->energy.mean == MPM_MEAN_NODES ? 0.5 * par->kick * a[d] : 0),
                    work   = MPMEnergyWall(core, n, ijk[0], d, a[d], u, MPMNodeStopped(met, d) ? v[d] : u);

    J[d] = flip * wall + (1 - flip) * (m * v[d] - n->p[d] - par->kick * m * other) - m * contact[d];
    W[d] = (core->energy.mean == MPM_MEAN_AGAIN ? 0.5 : 1) * par->kick * m * work;
    W[d] += (1 - flip) * (m * before - n->p[d]) * before; /* what a wall gave before; 0 unless it moves */
  }
  Give(core, t, PETSC_FALSE, J, W);
}

/* Adds the other half of the work, along the velocity of the second mapping of musl. */
static void AddAgain(MPMCore *core, const Touch *t, const MPMNode *n, PetscReal met, const PetscInt ijk[],
                     const PetscReal v[])
{
  const MPMParams *par = &core->params;
  const PetscReal *a   = v + core->grid.dim;
  PetscReal        J[3], W[3];

  for (PetscInt d = 0; d < core->grid.dim; d++) {
    const PetscReal m = MPMNodeMass(&core->grid, n, ijk[0], d);

    J[d] = par->kick * m * (a[d] - (n->f[d] / m + par->gravity[d]));
    W[d] = 0.5 * par->kick * m *
           MPMEnergyWall(core, n, ijk[0], d, a[d], MPMNodeStopped(met, d) ? n->p[d] / m : v[d], v[d]);
  }
  Give(core, t, PETSC_TRUE, J, W);
}

/* Adds what the walls of a node did to the velocity v that a filter or, where `was` is v before it, a correction
   made. */
static void AddVelocity(MPMCore *core, const Touch *t, const MPMNode *n, const PetscInt ijk[], const PetscReal v[],
                        const PetscReal was[])
{
  const PetscInt dim = core->grid.dim;
  PetscReal      J[3], W[3], V[3];

  WallVelocity(core, t, V);
  for (PetscInt d = 0; d < dim; d++) {
    const PetscReal m = MPMNodeMass(&core->grid, n, ijk[0], d);

    J[d] = was ? m * (v[d] - was[d] - core->params.kick * v[dim + d]) - n->p[d] : m * v[d] - n->p[d];
    W[d] = J[d] * V[d];
  }
  Give(core, t, PETSC_FALSE, J, W);
}

/* Adds what the walls of a node gave it in a step of the total frame: their force is in p, and v, was are its velocities
   after and before. */
static void AddKick(MPMCore *core, const Touch *t, const MPMNode *n, const PetscReal v[], const PetscReal was[])
{
  PetscReal J[3], W[3];

  for (PetscInt d = 0; d < core->grid.dim; d++) {
    J[d] = core->params.kick * n->p[d];
    W[d] = J[d] * 0.5 * (v[d] + was[d]);
  }
  Give(core, t, PETSC_FALSE, J, W);
}

/* Adds what the walls of a node gave it in a step without inertia: their force at its end is in p, and u, was are its
   displacements after and before. */
static void AddHeld(MPMCore *core, const Touch *t, const MPMNode *n, const PetscReal u[], const PetscReal was[])
{
  const PetscBool total = core->grid.total; /* else u are velocities */
  PetscReal       J[3], W[3];

  for (PetscInt d = 0; d < core->grid.dim; d++) {
    J[d] = core->params.kick * n->p[d];
    W[d] = n->p[d] * (total ? u[d] - was[d] : core->params.dt * u[d]);
  }
  Give(core, t, PETSC_FALSE, J, W);
}

/* Copies the velocity of a node, the next of those at walls, before a correction. */
static PetscErrorCode Keep(MPMCore *core, PetscInt at, const PetscReal v[])
{
  MPMReactions  *r   = core->reactions;
  const PetscInt dim = core->grid.dim;

  PetscFunctionBeginUser;
  if ((at + 1) * dim > r->room) {
    r->room = 2 * (at + 64) * dim;
    PetscCall(PetscRealloc((size_t)r->room * sizeof *r->before, &r->before));
  }
  PetscCall(PetscArraycpy(r->before + at * dim, v, dim));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMReactionsPhase(MPMCore *core, PetscInt k, PetscBool begins)
{
  const MPMPatch     *patch     = &core->exchange.patch;
  const MPMReactions *reactions = core->reactions;
  const MPMPhase     *phase     = core->program[k];
  const PetscBool     kicks     = MPMTotalKicks(phase);
  const PetscBool     placed    = phase->nodes == MPMNodesPlace;
  const PetscBool     advance   = phase->nodes == MPMNodesAdvance;
  const PetscInt      dim       = core->grid.dim;
  const PetscBool     twice     = core->energy.mean == MPM_MEAN_AGAIN;
  const PetscBool     again     = twice && phase->nodes == MPMNodesVelocityAgain;
  PetscInt            at        = 0;

  PetscFunctionBeginUser;
  if (phase->kind != MPM_NODES || (begins && k != reactions->correct)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!advance && !kicks && !placed && !again && k != reactions->filter && k != reactions->correct)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMExchangeOpenNodes(core));
  MPM_FOR_OWN_ROWS(patch, r)
  for (PetscInt i = r.first; i < r.last; i++) {
    const MPMNode   *n = r.sum + i;
    const PetscReal *v = r.motion + i * MPM_MOTION_NC(dim), met = r.value.met[i];
    const PetscInt   ijk[3] = {r.ijk[0] + i, r.ijk[1], r.ijk[2]};
    Touch            touch;

    SetTouch(core, ijk, met, k == reactions->filter, &touch);
    if (!touch.n || !(n->m > 0)) continue;
    if (begins)
      PetscCall(Keep(core, at, v));
    else if (placed)
      AddHeld(core, &touch, n, v, core->before + (PetscInt)(r.state - patch->state) + i * MPM_MOTION_NC(dim));
    else if (kicks)
      AddKick(core, &touch, n, v + dim,
              core->before + ((PetscInt)(r.state - patch->state) + i * MPM_MOTION_NC(dim)) + dim);
    else if (advance)
      AddAdvance(core, &touch, n, met, ijk, v);
    else if (again)
      AddAgain(core, &touch, n, met, ijk, v);
    else
      AddVelocity(core, &touch, n, ijk, v, k == reactions->correct ? reactions->before + at * dim : NULL);
    at++;
  }
  PetscCall(MPMExchangeCloseNodes(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}
