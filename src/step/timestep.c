/* timestep.c - the length of the next step, which is chosen before it from the status of the last one. docs/method.md
   derives the bounds. */
#include "step/step.h"

#define AROUND 4 /* cells: rigid bodies that are farther out of the grid do nothing to its nodes */

/* Returns the speed that bounds dt, m/s: no particle crosses a cell in the total frame. */
static PetscReal Speed(const MPMCore *core)
{
  return PetscSqrtReal(core->status.c2) + (core->grid.total ? 0 : PetscSqrtReal(core->status.v2));
}

PetscReal MPMCourant(const MPMCore *core, PetscReal dt)
{
  if (core->implicit) return 0; /* no wave is followed */
  return dt * Speed(core) / MPMGridSmallestH(&core->grid);
}

PetscReal MPMWaveCourant(const MPMCore *core, PetscReal dt)
{
  if (core->implicit) return 0;
  return dt * PetscSqrtReal(core->status.c2) / MPMGridSmallestH(&core->grid);
}

/* Returns the bound of an explicit step by diffusion, h^2/(2 dim nu) with nu = 4/3 viscosity/rho, in s. */
PetscReal MPMViscousStep(const MPMCore *core)
{
  PetscReal nu = 0;

  for (PetscInt k = 0; k < core->params.nkinds; k++)
    nu = PetscMax(nu, core->params.materials[core->params.kinds[k].material].diffusivity);
  return nu > 0 ? PetscSqr(MPMGridSmallestH(&core->grid)) / (2 * (PetscReal)core->grid.dim * nu) : PETSC_INFINITY;
}

/* Velocities belong to the middle between the times of positions. From one middle to the next it is half of the step
   before and half of this one. A difference by rounding, as of the last step to a time of output, is none. */
PetscReal MPMKick(PetscReal was, PetscReal dt)
{
  return PetscAbsReal(dt - was) <= 1e-9 * dt ? dt : 0.5 * (was + dt);
}

/* With damping, particles keep the share exp(-dt/tau) of FLIP, so that what is lost in a time does not depend on dt.
   Velocities of wave number k then decay by q/tau, where 1 - q is what mapping to the nodes and back leaves of them:
   q = (k h)^2/4 for bspline2, /3 for bspline3, 3/16 (k h)^2 for hats with 2 particles a cell. For a kinematic viscosity
   nu that decay is nu k^2, so tau = q/(nu k^2); for a rate r it is h/(r c). */
void MPMDamp(MPMCore *core, const MPMMethod *method)
{
  const PetscReal h = MPMGridSmallestH(&core->grid), dt = core->params.kick, c = PetscSqrtReal(core->status.c2);
  const PetscInt  inertia = MPMBasisInertia(core->basis);
  const PetscReal q       = inertia ? 1 / (PetscReal)inertia : 3. / 16;

  if (method->viscosity > 0) core->params.flip = PetscExpReal(-dt * method->viscosity / (q * h * h));
  if (method->rate > 0) core->params.flip = PetscExpReal(-method->rate * dt * c / h);
}

/* Returns how far a rigid body may come in a step, m: half a cell, or, if it does not turn, as far as it is from the
   nodes of the grid and those around it. */
static PetscReal MayMove(const MPMGrid *grid, const MPMRigid *r)
{
  const PetscReal h  = MPMGridSmallestH(grid);
  PetscReal       by = 0.5 * h;

  if (r->spin[0] != 0 || r->spin[1] != 0 || r->spin[2] != 0) return by;
  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal at = r->pivot[d] + r->place[d], far = r->reach + AROUND * grid->h[d];

    if (grid->periodic[d]) continue;
    by = PetscMax(by, PetscMax(grid->lower[d] - at, at - grid->upper[d]) - far);
  }
  return by;
}

/* Described in step.h. */
PetscReal MPMRigidStep(const MPMCore *core, PetscReal dt, PetscInt *which)
{
  *which = -1;
  for (PetscInt k = 0; k < core->rigids.n; k++) {
    const PetscReal speed = MPMRigidSpeed(&core->rigids.body[k]), far = MayMove(&core->grid, &core->rigids.body[k]);

    if (!(speed > 0) || speed * dt <= far) continue; /* infinite times 0 is not a number */
    dt     = far / speed;
    *which = k;
  }
  return dt;
}

/* Returns the fixed dt, if there is one, else cfl h/(c + |v|) of the present state, but at most cfl times the bound by
   viscosity, and at most the time in which gravity moves a particle from rest by a tenth of a cell, or a rigid body
   that moves comes as far as it may. */
PetscReal MPMTimeStep(const MPMCore *core, const MPMTime *time)
{
  const PetscReal h  = MPMGridSmallestH(&core->grid);
  PetscReal       g2 = 0, dt;
  PetscInt        which;

  if (time->fixed > 0) return time->fixed;
  for (PetscInt d = 0; d < core->grid.dim; d++) g2 += core->params.gravity[d] * core->params.gravity[d];
  dt = time->cfl * h / Speed(core);
  dt = PetscMin(dt, time->cfl * MPMViscousStep(core));
  dt = MPMRigidStep(core, dt, &which);
  return g2 > 0 ? PetscMin(dt, PetscSqrtReal(0.2 * h / PetscSqrtReal(g2))) : dt;
}
