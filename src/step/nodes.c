/* nodes.c - the kernels of node updates. In a step they follow a transfer to the nodes: they turn the sums of nodes
   into their motion, velocity v [dim], m/s, and acceleration a [dim], m/s^2. Equation numbers are those of
   docs/method.md. */
#include "kernels/round.h"
#include "step/scheme.h"

/* Returns whether a wall reaches node i of the row, and sets ijk [3] to the node's number in the grid. walled: one
   reaches the whole row; lo, hi: the first node on x that no wall reaches, and the one after the last. */
MPM_INLINE PetscBool Walled(const MPMNodes *r, PetscBool walled, PetscInt lo, PetscInt hi, PetscInt i, PetscInt ijk[])
{
  ijk[0] = r->ijk[0] + i;
  ijk[1] = r->ijk[1];
  ijk[2] = r->ijk[2];
  return walled || ijk[0] < lo || ijk[0] >= hi; /* those of other copies too */
}

/* Sets v = p/m, eq. (2), and applies walls. A node without mass is at rest; there is no threshold of mass. Only a
   particle exactly on a grid line reads a node without mass: its weight there is 0, but its gradient is not. */
MPM_INLINE void Divide(int dim, int round, const MPMFace (*faces)[2], const MPMGrid *grid, const MPMNodes *r,
                       PetscBool walled)
{
  const PetscInt lo = faces[0][0].reach + 1, hi = grid->cells[0] - faces[0][1].reach;
  PetscInt       ijk[3];

  for (PetscInt i = r->first; i < r->last; i++) {
    const MPMNode *n = r->sum + i;
    PetscReal     *v = r->motion + i * MPM_MOTION_NC(dim);

    for (int d = 0; d < dim; d++) v[d] = n->m > 0 ? n->p[d] / MPMNodeMassIf(round, grid, n, r->ijk[0] + i, d) : 0;
    if (Walled(r, walled, lo, hi, i, ijk)) (void)MPMWallsApply(faces, grid, ijk, 0, v);
  }
}

/* Sets the velocity that output and velocity gradients use. */
MPM_INLINE void Velocity(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                         PetscBool walled)
{
  Divide(dim, round, par->walls->gradient, grid, r, walled);
}

/* Does the same for the residual velocity of xpic. */
MPM_INLINE void Residual(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                         PetscBool walled)
{
  Divide(dim, round, par->walls->residual, grid, r, walled);
}

/* Sets the mean of what the particles have in field r, on which no wall acts, and which is no vector. */
MPM_INLINE void Mean(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r, PetscBool walled)
{
  static const MPMFace none[3][2];

  (void)par;
  (void)round;
  Divide(dim, 0, none, grid, r, walled);
}

/* Sets a = f/m + g, eqs. (5) and (13), and v <- v + kick a, eq. (6), and applies walls, which also set a. */
MPM_INLINE void Advance(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                        PetscBool walled)
{
  const MPMFace(*faces)[2] = par->walls->given;
  const PetscInt lo = faces[0][0].reach + 1, hi = grid->cells[0] - faces[0][1].reach;
  PetscInt       ijk[3];

  Divide(dim, round, par->walls->before, grid, r, walled);
  for (PetscInt i = r->first; i < r->last; i++) {
    const MPMNode *n = r->sum + i;
    PetscReal     *v = r->motion + i * MPM_MOTION_NC(dim), *a = v + dim, before[3];

    for (int d = 0; d < dim; d++) {
      a[d]      = n->m > 0 ? n->f[d] / MPMNodeMassIf(round, grid, n, r->ijk[0] + i, d) + par->gravity[d] : 0;
      before[d] = v[d];
      v[d]      = v[d] + par->kick * a[d];
    }
    r->value.met[i] = 0;
    if (Walled(r, walled, lo, hi, i, ijk))
      r->value.met[i] = (PetscReal)MPMWallsAdvance(faces, grid, ijk, par->kick, before, v, a);
  }
}

/* Corrects v after the advance by S+ r + kick a, where the sums of p are those of r: each correction brings v nearer to
   the solution of M v = p + kick f with the full mass matrix M. Walls hold the new v too, and those that only push hold
   the nodes that met them in the advance. */
MPM_INLINE void Correct(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                        PetscBool walled)
{
  const MPMFace(*faces)[2] = par->walls->gradient;
  const PetscInt lo = faces[0][0].reach + 1, hi = grid->cells[0] - faces[0][1].reach;
  PetscInt       ijk[3];

  for (PetscInt i = r->first; i < r->last; i++) {
    const MPMNode *n = r->sum + i;
    PetscReal     *v = r->motion + i * MPM_MOTION_NC(dim), *a = v + dim;

    for (int d = 0; d < dim; d++)
      if (n->m > 0 && !MPMNodeMet(r->value.met[i], d))
        v[d] += n->p[d] / MPMNodeMassIf(round, grid, n, r->ijk[0] + i, d) + par->kick * a[d];
    if (Walled(r, walled, lo, hi, i, ijk)) (void)MPMWallsApply(faces, grid, ijk, 0, v);
  }
}

/* Sets the velocity that particles give the nodes after the advance. Nodes that met a wall that only pushes keep that
   of the advance, and such a wall holds no others. If this were decided anew, then of a body that oscillates at the
   wall only the velocities into it would be removed, and that would drive the oscillation. */
MPM_INLINE void VelocityAgain(int dim, int round, const MPMParams *par, const MPMGrid *grid, const MPMNodes *r,
                              PetscBool walled)
{
  const MPMFace(*faces)[2] = par->walls->again;
  const PetscInt lo = faces[0][0].reach + 1, hi = grid->cells[0] - faces[0][1].reach;
  PetscInt       ijk[3];

  for (PetscInt i = r->first; i < r->last; i++) {
    const MPMNode *n = r->sum + i;
    PetscReal     *v = r->motion + i * MPM_MOTION_NC(dim), kept[3];

    for (int d = 0; d < dim; d++) {
      kept[d] = v[d];
      if (!MPMNodeMet(r->value.met[i], d))
        v[d] = n->m > 0 ? n->p[d] / MPMNodeMassIf(round, grid, n, r->ijk[0] + i, d) : 0;
    }
    if (!Walled(r, walled, lo, hi, i, ijk)) continue;
    (void)MPMWallsApply(faces, grid, ijk, 0, v);
    for (int d = 0; d < dim; d++) /* a wall that moves may drive it into the one that it met */
      if (MPMNodeMet(r->value.met[i], d)) v[d] = kept[d];
  }
}

/* The kernels that scheme.h declares. */
MPM_NODE_KERNEL(Velocity, Velocity, walled)
MPM_NODE_KERNEL(VelocityAgain, VelocityAgain, walled)
MPM_NODE_KERNEL(Residual, Residual, walled)
MPM_NODE_KERNEL(Mean, Mean, walled)
MPM_NODE_KERNEL(Advance, Advance, walled)
MPM_NODE_KERNEL(Correct, Correct, walled)
