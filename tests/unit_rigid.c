/* unit_rigid.c - rigid bodies: mass, centre and inertia of shapes beside their formulas; a body that no force acts on
   keeps its momentum and energy, and turns as Euler's equations say; an impulse gives a place the velocity that Yields
   says. */
#include "base/tensor.h"
#include "physics/rigid.h"
#include "unit.h"

static PetscReal Error(PetscReal value, PetscReal exact)
{
  return fabs(value / exact - 1);
}

static void CheckMass(void)
{
  MPMRegion box = {.type = MPM_REGION_box, .lower = {1, 2, 3}, .upper = {2, 2.3, 5}}, all = box,
            ball    = {.type = MPM_REGION_sphere, .center = {1, 2, 3}, .radius = 0.7};
  MPMRegion    tube = {.type = MPM_REGION_cylinder, .center = {1, 2, 3}, .axis = {0, 0, 1}, .radius = 0.5, .length = 2};
  MPMRegion   *others[] = {&all};
  MPMRigidMass m;

  UnitContext("box");
  for (int dim = 1; dim < 4; dim++) {
    const PetscReal a = 1, b = dim > 1 ? 0.3 : 1, c = dim > 2 ? 2 : 1;

    MPMRigidMassOf(&box, dim, PETSC_FALSE, &m);
    CHECK_LE(Error(m.volume, a * b * c), 1e-11); /* 262144 terms */
    for (int d = 0; d < dim; d++) CHECK_NEAR(m.center[d], 0.5 * (box.lower[d] + box.upper[d]), 1e-12);
    if (dim > 1) CHECK_LE(Error(m.inertia[8], a * b * c * (a * a + b * b) / 12), 1e-10);
    if (dim > 2) CHECK_LE(Error(m.inertia[0], a * b * c * (c * c + b * b) / 12), 1e-10);
  }
  all = (MPMRegion){.type = MPM_REGION_box, .lower = {-9, -9, -9}, .upper = {9, 9, 9}};
  for (int dim = 2; dim < 4; dim++) /* by the formula, and by sums, which a limit that limits nothing asks for */
    for (int k = 0; k < 2; k++) {
      const PetscReal R = 0.7, V = dim == 2 ? PETSC_PI * R * R : 4 * PETSC_PI / 3 * R * R * R,
                      most = k ? dim == 2 ? 2e-5 : 2.5e-3 : 1e-14;

      UnitContext("ball in %d-D, %d", dim, k);
      ball.others  = others;
      ball.nwithin = k;
      MPMRigidMassOf(&ball, dim, PETSC_FALSE, &m);
      CHECK_LE(Error(m.volume, V), most);
      CHECK_LE(Error(m.inertia[8], V * R * R * (dim == 2 ? 0.5 : 0.4)), most);
      for (int d = 0; d < dim; d++) CHECK_NEAR(m.center[d], ball.center[d], 1e-10);
    }
  UnitContext("cylinder");
  MPMRigidMassOf(&tube, 3, PETSC_FALSE, &m);
  CHECK_LE(Error(m.volume, PETSC_PI * 0.25 * 2), 2.5e-3);
  CHECK_LE(Error(m.inertia[8], PETSC_PI * 0.5 * 0.125), 2.5e-3);
  CHECK_LE(Error(m.inertia[0], PETSC_PI * 0.5 * (3 * 0.25 + 4) / 12), 2.5e-3);
}

/* Makes a body of a box. */
static void Make(MPMRigid *r, MPMRegion *box, int dim, PetscReal numbers[])
{
  PetscReal    inertia[9];
  MPMRigidMass m;

  memset(numbers, 0, MPM_RIGID_NUMBERS * sizeof *numbers);
  *r = (MPMRigid){.shape = box};
  MPMRigidUse(r, numbers);
  for (int d = 0; d < 3; d++) r->turn[4 * d] = 1;
  MPMRigidMassOf(box, dim, PETSC_FALSE, &m);
  for (int d = 0; d < dim; d++) r->pivot[d] = m.center[d];
  for (int k = 0; k < 9; k++) inertia[k] = 3 * m.inertia[k];
  CHECK_EQ(MPMRigidSetFree(r, dim, 3 * m.volume, inertia), 0);
}

/* The error of the direction of the spin after a time falls by 4 where the step is half. */
static void CheckFlight(void)
{
  MPMRegion box = {.type = MPM_REGION_box, .lower = {-1, -0.6, -0.3}, .upper = {1, 0.6, 0.3}};
  PetscReal found[3][3], numbers[MPM_RIGID_NUMBERS];

  UnitContext("flight");
  for (int k = 0; k < 3; k++) {
    const int n = 200 << k;
    MPMRigid  r;
    PetscReal energy = 0, now = 0, off = 0;

    Make(&r, &box, 3, numbers);
    MPMRigidKick(&r, (PetscReal[3]){0.5, 0.4, 0.3}, (PetscReal[3]){-10, 4, 20});
    for (int d = 0; d < 3; d++) energy += 0.5 * r.spin[d] * r.momentum[d];
    for (int i = 0; i < n; i++) MPMRigidMove(&r, 2. / n);
    for (int d = 0; d < 3; d++) now += 0.5 * r.spin[d] * r.momentum[d];
    CHECK_LE(Error(now, energy), 1e-3 / (1 << 2 * k));
    for (int d = 0; d < 3; d++)
      for (int e = 0; e < 3; e++) {
        PetscReal by = 0;

        for (int f = 0; f < 3; f++) by += r.turn[3 * d + f] * r.turn[3 * e + f];
        off = PetscMax(off, fabs(by - (d == e)));
      }
    CHECK_LE(off, 1e-12);
    for (int d = 0; d < 3; d++) {
      found[k][d] = r.spin[d];
      CHECK_NEAR(r.place[d], 2 * r.velocity[d], 1e-12);
    }
    (void)PetscFree(r.point);
  }
  for (int d = 0; d < 3; d++) CHECK_NEAR((found[0][d] - found[1][d]) / (found[1][d] - found[2][d]), 4, 0.5);
}

static void CheckKicks(void)
{
  MPMRegion box = {.type = MPM_REGION_box, .lower = {1, 2, 3}, .upper = {2, 2.3, 5}};
  PetscReal numbers[MPM_RIGID_NUMBERS];

  for (int dim = 1; dim < 4; dim++)
    for (int k = 0; k < 100; k++) {
      PetscReal x[3] = {0}, n[3] = {0}, V[3], W[3], by = 0, yields;
      MPMRigid  r;

      UnitContext("kick in %d-D", dim);
      Make(&r, &box, dim, numbers);
      if (dim > 1) r.spin[2] = UnitReal(-1, 1);
      if (dim > 2) r.spin[0] = UnitReal(-1, 1);
      r.free = PETSC_FALSE; /* a turn by that spin */
      MPMRigidMove(&r, 1);
      r.free = PETSC_TRUE;
      for (int d = 0; d < dim; d++) {
        x[d] = UnitReal(-1, 1);
        n[d] = UnitReal(-1, 1);
      }
      r.spin[0] = r.spin[1] = r.spin[2] = 0;
      MPMRigidVelocity(&r, dim, x, V);
      yields = MPMRigidYields(&r, x, n);
      MPMRigidKick(&r, x, n);
      MPMRigidVelocity(&r, dim, x, W);
      for (int d = 0; d < dim; d++) by += n[d] * (W[d] - V[d]);
      CHECK_NEAR(by, yields, 1e-12 * yields);
      (void)PetscFree(r.point);
    }
}

int main(void)
{
  CheckMass();
  CheckFlight();
  CheckKicks();
  return UnitEnd();
}
