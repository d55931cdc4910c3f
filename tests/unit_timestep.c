/* unit_timestep.c - the length of a step: each of its bounds is the one of the process that it guards against, which is
   made here step by step, and the least of them holds. */
#include "step/step.h"
#include "unit.h"

static MPMMaterial materials[3];
static MPMKind     kinds[3];

/* A grid, speeds, gravity and viscosities, each of which may be missing. */
static void Random(MPMCore *core, MPMTime *time)
{
  memset(core, 0, sizeof *core);
  memset(time, 0, sizeof *time);
  core->grid.dim = 1 + UnitInt(3);
  for (int d = 0; d < core->grid.dim; d++) {
    core->grid.h[d]         = UnitReal(0.01, 2);
    core->params.gravity[d] = UnitInt(2) ? UnitReal(-10, 10) : 0;
  }
  core->status.c2        = PetscSqr(UnitReal(0.1, 1000));
  core->status.v2        = UnitInt(3) ? PetscSqr(UnitReal(0, 100)) : 0;
  core->params.kinds     = kinds;
  core->params.materials = materials;
  core->params.nkinds    = 1 + UnitInt(3);
  for (int k = 0; k < 3; k++) {
    kinds[k].material        = 2 - k;
    materials[k].rho         = UnitReal(1, 3000);
    materials[k].viscosity   = UnitInt(2) ? UnitReal(0, 1000) : 0;
    materials[k].diffusivity = 4. / 3 * materials[k].viscosity / materials[k].rho;
  }
  time->cfl = UnitReal(0.01, 1);
}

static PetscReal SmallestH(const MPMCore *core)
{
  PetscReal h = core->grid.h[0];

  for (int d = 1; d < core->grid.dim; d++) h = PetscMin(h, core->grid.h[d]);
  return h;
}

/* The factor by which an explicit step dt of diffusion with 4/3 viscosity/rho, on a grid of cells h, multiplies the mode
   that changes its sign from node to node on all axes: v_i + dt nu sum_d (v_i+1 - 2 v_i + v_i-1)/h^2. It is -1 at the bound. */
static PetscReal Multiplies(const MPMCore *core, PetscReal dt)
{
  const PetscReal h    = SmallestH(core);
  PetscReal       most = 1;

  for (int k = 0; k < core->params.nkinds; k++) {
    const MPMMaterial *m = &materials[kinds[k].material];
    PetscReal          v = 1;

    for (int d = 0; d < core->grid.dim; d++) v += dt * 4 / 3 * m->viscosity / m->rho * (-1 - 2 - 1) / (h * h);
    most = PetscMin(most, v);
  }
  return most;
}

/* The distance in cells that gravity moves a particle from rest in a time, in small steps. */
static PetscReal Falls(const MPMCore *core, PetscReal time)
{
  PetscReal far = 0;

  for (int d = 0; d < core->grid.dim; d++) {
    PetscReal x = 0, v = 0;

    for (int k = 0; k < 1000; k++) {
      v += 0.5 * time / 1000 * core->params.gravity[d];
      x += time / 1000 * v;
      v += 0.5 * time / 1000 * core->params.gravity[d];
    }
    far += x * x;
  }
  return PetscSqrtReal(far) / SmallestH(core);
}

int main(void)
{
  for (int n = 0; n < 20000; n++) {
    MPMCore   core;
    MPMTime   time;
    PetscReal dt, viscous, cells;
    int       reached = 0;

    Random(&core, &time);
    UnitContext("random number %d", n);
    dt      = MPMTimeStep(&core, &time);
    viscous = MPMViscousStep(&core);
    cells   = dt * (PetscSqrtReal(core.status.c2) + PetscSqrtReal(core.status.v2)) / SmallestH(&core);
    CHECK_NEAR(MPMCourant(&core, dt), cells, 1e-12);
    CHECK_NEAR(MPMWaveCourant(&core, dt), dt * PetscSqrtReal(core.status.c2) / SmallestH(&core), 1e-12);
    CHECK_LE(cells, time.cfl * (1 + 1e-12));
    reached |= cells > time.cfl * (1 - 1e-9);
    if (viscous < PETSC_INFINITY) {
      CHECK_NEAR(Multiplies(&core, viscous), -1, 1e-9);
      CHECK_LE(dt, time.cfl * viscous * (1 + 1e-12));
      reached |= dt > time.cfl * viscous * (1 - 1e-9);
    } else
      CHECK_EQ(Multiplies(&core, 1), 1);
    CHECK_LE(Falls(&core, dt), 0.1 * (1 + 1e-9));
    reached |= Falls(&core, dt) > 0.1 * (1 - 1e-9);
    CHECK(reached); /* one of the bounds is the step */
    time.fixed = UnitReal(0, 1);
    CHECK_EQ(MPMTimeStep(&core, &time), time.fixed);
  }
  for (int n = 0; n < 1000; n++) {
    const PetscReal was = UnitReal(1e-6, 1), dt = UnitReal(1e-6, 1);

    CHECK_NEAR(MPMKick(was, dt), 0.5 * was + 0.5 * dt, 1e-15);
    CHECK_EQ(MPMKick(dt * (1 + 1e-12), dt), dt);
  }
  return UnitEnd();
}
