/* unlikely_implicit.c - the rows of plausible.def of implicit steps: what their solves leave, and what their steps follow. */
#include "advice/unlikely.h"

PetscBool MPMUnlikely_solve_loose(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  return look->core->implicit && MPMUnlikelyNumber("snes_rtol", NULL, "", odd, &odd->ratio);
}

PetscBool MPMUnlikely_ramp_idle(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  return !(look->g > 0 || look->core->stages.n) && MPMUnlikelyGiven("gravity_ramp", NULL, "", odd);
}

/* A body that starts with a velocity between walls that hold it vibrates: steps over the longest period, of a bar of its length
   that one wall clamps, 4 L/c, or of its bending there, 6.2 L^2/(H c), or of one between two walls, 2 L/c. */
PetscBool MPMUnlikely_vibration_few(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid     *grid = &look->core->grid;
  const MPMBody     *b    = &look->scene->bodies[k];
  const MPMMaterial *m    = &look->scene->materials[b->material];
  const PetscReal    c    = PetscSqrtReal(MPMUnlikelyModulus(m, PETSC_TRUE) / m->rho);
  PetscInt           held = 0, clamps = 0;
  PetscReal          period = 0;

  if (!look->core->implicit || !(b->v2 > 0) || MPMUnlikelyStatic(odd)) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * grid->dim; face++) {
    const MPMWall type = MPMUnlikelyWall(look, face);

    if (!MPMWallHas(type, MPM_WALL_NORMAL) || MPMUnlikelyBeside(look, k, face) > 0.5) continue;
    held++;
    clamps += MPMWallHas(type, MPM_WALL_TANGENT);
  }
  for (PetscInt face = 0; face < 2 * grid->dim && held; face++) {
    const PetscInt  d      = face / 2;
    const PetscReal length = look->upper[k][d] - look->lower[k][d];
    const MPMWall   type   = MPMUnlikelyWall(look, face);

    if (!MPMWallHas(type, MPM_WALL_NORMAL) || MPMUnlikelyBeside(look, k, face) > 0.5) continue;
    period = PetscMax(period, (held == 1 ? 4 : 2) * length / c);
    for (PetscInt e = 0; e < grid->dim && held == 1 && clamps && !grid->round; e++)
      if (e != d) period = PetscMax(period, 6.2 * length * length / ((look->upper[k][e] - look->lower[k][e]) * c));
  }
  if (!(period > 0) || !MPMUnlikelyNumber("dt_size", NULL, "", odd, &odd->ratio)) return PETSC_FALSE;
  odd->ratio /= period;
  (void)snprintf(odd->other, MPM_WORDS, "%.60s, about %.2g s", b->name, (double)period);
  MPMUnlikelyWrite(odd->meant, period / 40);
  return PETSC_TRUE;
}
