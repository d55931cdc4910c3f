/* total.c - the total frame: the state of a run is on the nodes. Each has a displacement u [dim], m, and a velocity v
   [dim], m/s, in patch->state; weights are those of the reference positions, which never change. A step is one of
   leapfrog: forces make accelerations, with the mass matrix to the order that is asked for, these make v, and v makes
   u. Particles get x, v and F from the nodes. The kernels below follow a transfer to the nodes; docs/method.md has the
   equations (The total frame), and total_start.c what comes before the first step. */
#include "kernels/round.h"
#include "physics/wall.h"
#include "step/step.h"

/* Lets the walls hold velocity v [dim] of node i of a row. walled: one reaches the whole row. */
MPM_INLINE void Hold(const MPMParams *par, const MPMGrid *grid, const MPMNodes *r, PetscBool walled, PetscInt i,
                     PetscReal v[])
{
  const PetscInt ijk[3] = {r->ijk[0] + i, r->ijk[1], r->ijk[2]};

  if (walled || MPMWallsReach(par->walls->given, grid, 0, ijk[0]))
    (void)MPMWallsApply(par->walls->given, grid, ijk, par->kick, v);
}

/* Sets the acceleration a [dim] of node i, m/s^2: f/m + g, or `again` corrects it by (f - p)/m + g, where p are the
   sums of what the particles read of a, so that each correction brings it nearer to the solution of M a = f + M g with
   the full mass matrix M. Walls hold it: with what force, N, `wall` [dim] gets if it is not NULL. The sum of these over
   the nodes of all walls is the force on the body, since sum p = sum m a before the correction; of bodies of revolution
   (`round`) along the axis only, since m is that of MPMNodeMass. */
MPM_INLINE void Acceleration(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                             PetscBool walled, int again, PetscInt i, PetscReal a[], PetscReal wall[])
{
  const MPMNode   *n = r->sum + i;
  const PetscReal *v = r->state + i * MPM_MOTION_NC(dim) + dim;
  PetscReal        now[3], trial[3], m[3];

  for (int d = 0; d < dim; d++) {
    PetscReal more;

    m[d]   = MPMNodeMassIf(round, grid, n, r->ijk[0] + i, d);
    more   = n->m > 0 ? (again ? n->f[d] - n->p[d] : n->f[d]) / m[d] + par->gravity[d] : 0;
    a[d]   = again ? a[d] + more : more;
    now[d] = trial[d] = v[d] + par->kick * a[d];
  }
  Hold(par, grid, r, walled, i, now);
  for (int d = 0; d < dim; d++) {
    if (wall) wall[d] = now[d] != trial[d] ? m[d] * (now[d] - trial[d]) / par->kick : 0;
    if (now[d] != trial[d]) a[d] = (now[d] - v[d]) / par->kick;
  }
}

/* Sets the acceleration of all nodes of a row, in the first numbers of the motion. */
MPM_INLINE void AccelerateRow(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                              PetscBool walled, int again)
{
  for (PetscInt i = r->first; i < r->last; i++)
    if (r->sum[i].m > 0) /* the others move nothing */
      Acceleration(dim, round, par, grid, r, walled, again, i, r->motion + i * MPM_MOTION_NC(dim), NULL);
}

/* Does so, and moves the nodes: v <- v + kick a and u <- u + dt v. The motion becomes u and v, which particles read,
   and p the forces of walls, for the history. */
MPM_INLINE void KickRow(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                        PetscBool walled, int again)
{
  for (PetscInt i = r->first; i < r->last; i++) {
    PetscReal *motion = r->motion + i * MPM_MOTION_NC(dim), *u = r->state + i * MPM_MOTION_NC(dim), *v = u + dim, a[3];

    if (!(r->sum[i].m > 0)) continue;
    for (int d = 0; d < dim; d++) a[d] = again ? motion[d] : 0;
    Acceleration(dim, round, par, grid, r, walled, again, i, a, r->sum[i].p);
    for (int d = 0; d < dim; d++) v[d] += par->kick * a[d];
    Hold(par, grid, r, walled, i, v); /* once more, without rounding */
    for (int d = 0; d < dim; d++) {
      u[d] += par->dt * v[d];
      motion[d]       = u[d];
      motion[dim + d] = v[d];
    }
  }
}

/* Sets the first velocity p/m, where p are the sums of the particles' momentum, which are kept as f; `again` corrects
   it by (f - p)/m, as accelerations are corrected. */
MPM_INLINE void StartRow(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                         PetscBool walled, int again)
{
  for (PetscInt i = r->first; i < r->last; i++) {
    MPMNode   *n = r->sum + i;
    PetscReal *v = r->state + i * MPM_MOTION_NC(dim) + dim;

    for (int d = 0; d < dim; d++) {
      if (!again) v[d] = 0, n->f[d] = n->p[d];
      if (n->m > 0) v[d] += (again ? n->f[d] - n->p[d] : n->p[d]) / MPMNodeMassIf(round, grid, n, r->ijk[0] + i, d);
    }
    Hold(par, grid, r, walled, i, v);
    for (int d = 0; d < dim; d++) r->motion[i * MPM_MOTION_NC(dim) + d] = v[d];
  }
}

/* Shows the particles the velocities of nodes, in the motion; `again` takes the share 1 - flip of them from p/m, where
   p are the sums of m times what the particles read: the mean of what the nodes around have, which leaves waves of many
   cells and damps those of two. */
MPM_INLINE void SmoothRow(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                          PetscBool walled, int again)
{
  for (PetscInt i = r->first; i < r->last; i++) {
    const MPMNode *n = r->sum + i;
    PetscReal     *v = r->state + i * MPM_MOTION_NC(dim) + dim;

    for (int d = 0; d < dim && again && n->m > 0; d++)
      v[d] += (1 - par->flip) * (n->p[d] / MPMNodeMassIf(round, grid, n, r->ijk[0] + i, d) - v[d]);
    if (again) Hold(par, grid, r, walled, i, v);
    for (int d = 0; d < dim; d++) r->motion[i * MPM_MOTION_NC(dim) + d] = v[d];
  }
}

/* Shows the particles the displacements and velocities of nodes as they are. */
MPM_INLINE void PlaceRow(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                         PetscBool walled, int again)
{
  const PetscInt nc = MPM_MOTION_NC(dim);

  (void)round;
  (void)par;
  (void)grid;
  (void)walled;
  (void)again;
  for (PetscInt i = r->first; i < r->last; i++)
    for (PetscInt k = 0; k < nc; k++) r->motion[i * nc + k] = r->state[i * nc + k];
}

/* The kernels that scheme.h declares. */
MPM_NODE_KERNEL(Accelerate, AccelerateRow, walled, 0)
MPM_NODE_KERNEL(AccelerateAgain, AccelerateRow, walled, 1)
MPM_NODE_KERNEL(Kick, KickRow, walled, 0)
MPM_NODE_KERNEL(KickAgain, KickRow, walled, 1)
MPM_NODE_KERNEL(Show, SmoothRow, walled, 0)
MPM_NODE_KERNEL(Smooth, SmoothRow, walled, 1)
MPM_NODE_KERNEL(Place, PlaceRow, walled, 0)
MPM_NODE_KERNEL(Start, StartRow, walled, 0)
MPM_NODE_KERNEL(StartAgain, StartRow, walled, 1)

PetscBool MPMTotalKicks(const MPMPhase *phase)
{
  return phase->kind == MPM_NODES && (phase->nodes == MPMNodesKick || phase->nodes == MPMNodesKickAgain);
}

PetscErrorCode MPMTotalKeep(MPMCore *core)
{
  const PetscInt n = MPMPatchNodes(&core->exchange.patch) * MPM_MOTION_NC(core->grid.dim);

  PetscFunctionBeginUser;
  if (!core->before) PetscCall(PetscMalloc1(n, &core->before));
  PetscCall(PetscArraycpy(core->before, core->exchange.patch.state, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}
