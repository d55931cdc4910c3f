/* unlikely_places.c - the rows of plausible.def of faces, rigid bodies and probes. */
#include "physics/sizes.h"
#include "advice/unlikely.h"

/* --- Faces and rigid bodies --------------------------------------------------------------------------------------- */

/* Writes the fastest wave of a scene. */
static void WriteWave(const MPMLook *look, MPMOdd *odd)
{
  (void)snprintf(odd->other, MPM_WORDS, "%.3g m/s", (double)look->c);
}

/* Sets the largest speed of the wall of a face, m/s. */
static PetscBool WallSpeed(const MPMLook *look, PetscInt k, MPMOdd *odd, PetscReal *speed)
{
  const MPMFace   *f       = &look->scene->walls.given[k / 2][k % 2];
  const MPMFormula formula = MPMUnlikelyFormula(look, look->scene->nloads + k);
  PetscReal        size2   = 0;

  if (!MPMWallHas(f->type, MPM_WALL_MOVES)) return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) size2 += f->velocity[d] * f->velocity[d];
  *speed = PetscMax(PetscSqrtReal(size2), MPMUnlikelySize(look, &formula));
  WriteWave(look, odd);
  return MPMUnlikelyGiven("bc", MPMFaceNames[k], "_velocity", odd);
}

PetscBool MPMUnlikely_face_fast(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal speed = 0;

  if (!WallSpeed(look, k, odd, &speed)) return PETSC_FALSE;
  odd->ratio = speed / look->c;
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_face_idle(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  PetscReal speed = 0;

  if (!WallSpeed(look, k, odd, &speed) || !(speed > 0) || !(look->time->end > 0)) return PETSC_FALSE;
  odd->ratio = speed * look->time->end / MPMGridSmallestH(&look->core->grid);
  return PETSC_TRUE;
}

/* Is matter at rest at the start, and is nothing but gravity there that moves it? */
static PetscBool IsAtRest(const MPMLook *look)
{
  for (PetscInt b = 0; b < look->scene->nbodies; b++)
    if (look->scene->bodies[b].v2 > 0 || look->scene->bodies[b].source.on) return PETSC_FALSE;
  return !(look->scene->forced || look->scene->known || look->core->stages.n > 1);
}

/* What touches matter at the start and goes away from it meets nothing either; at a side matter may follow it. */
PetscBool MPMUnlikely_piston_short(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid  *grid = &look->core->grid;
  const PetscInt  d = k / 2, side = k % 2;
  const PetscReal place = look->scene->walls.place[k], out = look->core->params.gravity[d] * (side ? 1 : -1),
                  gap = side ? grid->upper[d] - place - look->highest[d] : look->lowest[d] - grid->lower[d] - place;
  PetscReal most, last = 0;
  PetscBool solid = PETSC_FALSE;

  for (PetscInt b = 0; b < look->scene->nbodies; b++)
    if (MPMMaterialKeepsShape(&look->scene->materials[look->scene->bodies[b].material])) solid = PETSC_TRUE;
  if (look->scene->walls.given[d][side].type != MPM_WALL_piston || !IsAtRest(look) || look->core->rigids.n || out > 0 ||
      look->core->step || !MPMUnlikelyGiven("bc", MPMFaceNames[k], "_velocity", odd))
    return PETSC_FALSE;
  last = MPMUnlikelyAdvance(look, look->scene->wall_velocity[k], 0, look->scene->walls.given[d][side].velocity[d],
                            side ? -1 : 1, &most);
  if (!(gap > 0.1 * grid->h[d]) &&
      (most > 0 || !(last < -0.1 * grid->h[d]) || !(out < 0) || (look->scene->walls.given[d][side].pulls && solid)))
    return PETSC_FALSE;
  odd->ratio = most / PetscMax(gap, 0.01 * grid->h[d]);
  MPMUnlikelyWrite(odd->other, gap - last);
  (void)snprintf(odd->meant, MPM_WORDS, "-bc_%s_distance", MPMFaceNames[k]);
  return PETSC_TRUE;
}

static const MPMBody *RigidBody(const MPMLook *look, PetscInt k)
{
  return &look->scene->bodies[look->scene->nbodies + k];
}

/* Returns how far the box of a rigid body reaches from the point about which it turns, m. */
static PetscReal Arm(const MPMLook *look, const MPMBody *b)
{
  const PetscReal *lower = look->lower[b - look->scene->bodies], *upper = look->upper[b - look->scene->bodies];
  PetscReal        arm2 = 0;

  for (PetscInt d = 0; d < look->core->grid.dim; d++)
    arm2 += PetscSqr(PetscMax(upper[d] - b->pivot[d], b->pivot[d] - lower[d]));
  return PetscSqrtReal(arm2);
}

/* Damping that is on while a wall or a rigid body moves: the force m v/T on the matter that it moves along, over its
   weight. */
PetscBool MPMUnlikely_damping_pushes(const MPMLook *look, PETSC_UNUSED PetscInt k, MPMOdd *odd)
{
  PetscReal most = 0, speed = 0;

  if (!(look->core->damping.time > 0) || !(look->g > 0)) return PETSC_FALSE;
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++)
    if (WallSpeed(look, face, odd, &speed) && speed > most) {
      most = speed;
      (void)snprintf(odd->meant, MPM_WORDS, "%s", odd->option);
    }
  for (PetscInt r = 0; r < look->scene->nshapes; r++) {
    const MPMFormula f    = MPMUnlikelyFormula(look, look->scene->nloads + 7 + 2 * r);
    const MPMFormula spin = MPMUnlikelyFormula(look, look->scene->nloads + 8 + 2 * r);
    const MPMBody   *b    = &look->scene->bodies[look->scene->nbodies + r];
    const PetscReal  goes = MPMUnlikelySize(look, &f),
                    turns = spin.value ? MPMUnlikelySize(look, &spin) * Arm(look, b) : 0;

    speed = PetscMax(goes, turns);
    if (speed <= most) continue;
    most = speed;
    (void)snprintf(odd->meant, MPM_WORDS, "-body_%s_%s", b->name, turns > goes ? "spin" : "velocity");
  }
  odd->ratio = most / (look->core->damping.time * look->g);
  MPMUnlikelyWrite(odd->other, most);
  return MPMUnlikelyGiven("damping_time", NULL, "", odd);
}

/* Returns the lightest material, or the densest. */
static const MPMMaterial *Material(const MPMLook *look, PetscBool densest)
{
  const MPMMaterial *m = look->scene->materials;

  for (PetscInt j = 0; j < look->scene->nmaterials; j++)
    if (densest ? look->scene->materials[j].rho > m->rho : look->scene->materials[j].rho < m->rho)
      m = &look->scene->materials[j];
  return m;
}

/* Compares the density of a rigid body with that of the lightest material, or of the densest. */
static PetscBool Density(const MPMLook *look, PetscInt k, PetscBool densest, MPMOdd *odd)
{
  const MPMBody     *b = RigidBody(look, k);
  const MPMMaterial *m = Material(look, densest);

  if (!(b->rho > 0)) return PETSC_FALSE;
  odd->ratio = b->rho / m->rho;
  (void)snprintf(odd->other, MPM_WORDS, "%s", m->name);
  MPMUnlikelyWrite(odd->meant, densest ? b->rho / 1000 : 1000 * b->rho);
  return MPMUnlikelyGiven("body", b->name, "_rho", odd);
}

PetscBool MPMUnlikely_rigid_light(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return Density(look, k, PETSC_FALSE, odd);
}

PetscBool MPMUnlikely_rigid_heavy(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  return Density(look, k, PETSC_TRUE, odd);
}

PetscBool MPMUnlikely_rigid_mass(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody     *b = RigidBody(look, k);
  const MPMMaterial *m = Material(look, PETSC_FALSE);
  MPMRigidMass       mass;

  if (!(b->mass > 0)) return PETSC_FALSE;
  MPMRigidMassOf(&b->region, look->core->grid.dim, look->core->grid.round, &mass);
  odd->ratio = b->mass / (m->rho * mass.volume);
  (void)snprintf(odd->other, MPM_WORDS, "%s", m->name);
  return MPMUnlikelyGiven("body", b->name, "_mass", odd);
}

PetscBool MPMUnlikely_rigid_inertia(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b   = RigidBody(look, k);
  const PetscInt dim = look->core->grid.dim;
  MPMRigidMass   mass;

  if (!(b->inertia[0] > 0)) return PETSC_FALSE;
  MPMRigidMassOf(&b->region, dim, look->core->grid.round, &mass);
  odd->ratio = 0;
  for (PetscInt d = 0; d < (dim == 3 ? 3 : 1); d++) {
    const PetscReal own = mass.inertia[dim == 3 ? 4 * d : 8] * b->mass / mass.volume;

    if (b->inertia[d] <= odd->ratio * own) continue;
    odd->ratio = b->inertia[d] / own;
    MPMUnlikelyWrite(odd->other, own);
  }
  return MPMUnlikelyGiven("body", b->name, "_inertia", odd);
}

PetscBool MPMUnlikely_rigid_fast(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody   *b = RigidBody(look, k);
  const MPMFormula f = {b->velocity, look->core->grid.dim, -1, "body", NULL, "_velocity"};

  if (!MPMUnlikelyGiven("body", b->name, "_velocity", odd)) return PETSC_FALSE;
  odd->ratio = MPMUnlikelySize(look, &f) / look->c;
  WriteWave(look, odd);
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_rigid_spin(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody   *b     = RigidBody(look, k);
  const PetscReal *lower = look->lower[look->scene->nbodies + k], *upper = look->upper[look->scene->nbodies + k];
  const MPMFormula f    = {b->spin, look->core->grid.dim == 3 ? 3 : 1, -1, "body", NULL, "_spin"};
  PetscReal        size = 0, spin;

  if (!MPMUnlikelyGiven("body", b->name, "_spin", odd)) return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) size = PetscMax(size, 0.5 * (upper[d] - lower[d]));
  spin       = MPMUnlikelySize(look, &f);
  odd->ratio = spin * size / look->c;
  WriteWave(look, odd);
  MPMUnlikelyWrite(odd->meant, spin * PETSC_PI / 30);
  return odd->ratio < PETSC_MAX_REAL;
}

PetscBool MPMUnlikely_rigid_thin(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody   *b     = RigidBody(look, k);
  const PetscReal *lower = look->lower[look->scene->nbodies + k], *upper = look->upper[look->scene->nbodies + k];
  const MPMGrid   *grid = &look->core->grid;

  if (grid->dim == 1) return PETSC_FALSE;
  odd->ratio = PETSC_MAX_REAL;
  for (PetscInt d = 0; d < grid->dim; d++) {
    if (!((upper[d] - lower[d]) / grid->h[d] < odd->ratio)) continue;
    odd->ratio = (upper[d] - lower[d]) / grid->h[d];
    (void)snprintf(odd->other, MPM_WORDS, "%c", "xyz"[d]);
  }
  MPMGridFiner(grid, 2 / odd->ratio, odd->meant, MPM_WORDS);
  return MPMUnlikelyGiven("body", b->name, "_shape", odd);
}

PetscBool MPMUnlikely_rigid_short(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody   *b     = RigidBody(look, k);
  const PetscReal *lower = look->lower[look->scene->nbodies + k], *upper = look->upper[look->scene->nbodies + k];
  const PetscInt   d  = look->down;
  const PetscReal  up = look->core->params.gravity[d] < 0 ? 1 : -1;

  if (b->tied || !(look->g > 0) || !IsAtRest(look) || b->rigid != MPM_RIGID_FIXED) return PETSC_FALSE;
  odd->ratio = (up > 0 ? lower[d] - look->highest[d] : look->lowest[d] - upper[d]);
  odd->ratio /= look->core->grid.h[d];
  (void)snprintf(odd->other, MPM_WORDS, up > 0 ? "above" : "below");
  return !(MPMWallsHave(&look->scene->walls, MPM_WALL_MOVES)) && MPMUnlikelyGiven("body", b->name, "_rigid", odd);
}

PetscBool MPMUnlikely_rigid_wall_mu(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody *b = RigidBody(look, k);
  PetscReal      mu;

  if (b->rigid != MPM_RIGID_FREE || !MPMUnlikelyNumber("body", b->name, "_mu", odd, &mu)) return PETSC_FALSE;
  odd->ratio = 0;
  for (PetscInt face = 0; face < 2 * look->core->grid.dim; face++) {
    const MPMFace *wall = &look->scene->walls.given[face / 2][face % 2];

    if (wall->type != MPM_WALL_friction || !(PetscAbsReal(wall->mu - mu) > odd->ratio)) continue;
    odd->ratio = PetscAbsReal(wall->mu - mu);
    (void)snprintf(odd->other, sizeof odd->other, "-bc_%.8s_mu %g", MPMFaceNames[face], (double)wall->mu);
  }
  return PETSC_TRUE;
}

PetscBool MPMUnlikely_gap_rigid(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody   *r     = RigidBody(look, k);
  const PetscReal *lower = look->lower[look->scene->nbodies + k], *upper = look->upper[look->scene->nbodies + k];
  const MPMGrid   *grid = &look->core->grid;
  const PetscInt   down = look->down;

  if (r->rigid != MPM_RIGID_FIXED || !(look->g > 0) || look->scene->forced || look->core->stages.now > 1 ||
      look->core->step)
    return PETSC_FALSE;
  odd->ratio = PETSC_MAX_REAL;
  for (PetscInt b = 0; b < look->scene->nbodies; b++) {
    PetscInt  apart = 0;
    PetscReal gap   = 0;

    if (!(look->scene->materials[look->scene->bodies[b].material].type->traits & MPM_LOOSE) ||
        look->scene->bodies[b].v2 > 0)
      continue;
    for (PetscInt d = 0; d < grid->dim; d++) {
      const PetscReal far = MPMUnlikelyApart(look, d, lower, upper, look->lower[b], look->upper[b]);

      apart += far > 0;
      if (far > 0) gap = d == down ? PETSC_MAX_REAL : far;
    }
    if (apart != 1 || !(gap > 0.3 && gap < odd->ratio)) continue;
    odd->ratio = gap;
    (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[b].name);
  }
  return odd->other[0] && MPMUnlikelyGiven("body", r->name, "_shape", odd);
}

/* How many cells a rigid body that stays is above the floor, on which there is matter that flows. */
PetscBool MPMUnlikely_gap_under(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody   *r     = RigidBody(look, k);
  const PetscReal *lower = look->lower[look->scene->nbodies + k], *upper = look->upper[look->scene->nbodies + k];
  const MPMGrid   *grid = &look->core->grid;
  const PetscInt   d = look->down, up = look->core->params.gravity[d] > 0, face = 2 * d + up;

  if (r->rigid != MPM_RIGID_FIXED || r->tied || !(look->g > 0) || look->core->stages.now > 1 || look->core->step ||
      !MPMWallHas(MPMUnlikelyWall(look, face), MPM_WALL_NORMAL))
    return PETSC_FALSE;
  odd->ratio = ((up ? grid->upper[d] - upper[d] : lower[d] - grid->lower[d]) - look->scene->walls.place[face]) /
               grid->h[d];
  for (PetscInt b = 0; b < look->scene->nbodies; b++)
    if (look->scene->materials[look->scene->bodies[b].material].type->traits & (MPM_FLUID | MPM_LOOSE) &&
        MPMUnlikelyBeside(look, b, face) < 1)
      (void)snprintf(odd->other, MPM_WORDS, "%s", look->scene->bodies[b].name);
  if (!odd->other[0] || !(odd->ratio > 0.05)) return PETSC_FALSE;
  MPMGridFiner(grid, 3 / odd->ratio, odd->meant, MPM_WORDS);
  return MPMUnlikelyGiven("body", r->name, "_shape", odd);
}

PetscBool MPMUnlikely_pivot_far(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMBody   *b     = RigidBody(look, k);
  const PetscReal *lower = look->lower[look->scene->nbodies + k], *upper = look->upper[look->scene->nbodies + k];
  PetscReal        size = 0, far = 0;

  if (b->rigid != MPM_RIGID_MOVING || !b->spin || !MPMUnlikelyGiven("body", b->name, "_pivot", odd)) return PETSC_FALSE;
  for (PetscInt d = 0; d < look->core->grid.dim; d++) {
    size = PetscMax(size, upper[d] - lower[d]);
    far  = PetscMax(far, PetscMax(lower[d] - b->pivot[d], b->pivot[d] - upper[d]));
  }
  odd->ratio = far / size;
  return PETSC_TRUE;
}

/* --- Probes ------------------------------------------------------------------------------------------------------- */

PetscBool MPMUnlikely_probe_away(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const MPMGrid  *grid = &look->core->grid;
  const MPMProbe *p    = NULL;

  for (PetscInt j = 0; j < look->monitor->measures.nprobes; j++)
    if (!strcmp(look->monitor->measures.probe[j].name, look->scene->probes[k])) p = &look->monitor->measures.probe[j];
  if (!p || !p->stays) return PETSC_FALSE;
  odd->ratio = PETSC_MAX_REAL;
  for (PetscInt b = 0; b < look->scene->nbodies; b++) {
    const MPMMaterial *m   = &look->scene->materials[look->scene->bodies[b].material];
    PetscReal          far = 0;
    PetscBool          may = PetscSqrtReal(look->scene->bodies[b].v2) * look->time->end > grid->h[0];

    for (PetscInt d = 0; d < grid->dim; d++) {
      const PetscReal out = PetscMax(look->lower[b][d] - p->x[d], p->x[d] - look->upper[b][d]);

      far = PetscMax(far, out / grid->h[d]);
      /* matter comes to what is below it; loose matter runs as far as it is high, water anywhere */
      if (out > 0 && look->core->params.gravity[d] * (p->x[d] - look->lower[b][d]) > 0) may = PETSC_TRUE;
      if (m->type->traits & MPM_FLUID && p->x[look->down] < look->upper[b][look->down]) may = PETSC_TRUE;
      if (m->type->traits & MPM_LOOSE && d != look->down && look->core->params.gravity[look->down] != 0 &&
          p->x[look->down] < look->upper[b][look->down] &&
          out < 3 * (look->upper[b][look->down] - look->lower[b][look->down]))
        may = out > 0 ? PETSC_TRUE : may;
    }
    odd->ratio = PetscMin(odd->ratio, may ? 0 : far);
  }
  return MPMUnlikelyGiven("probe", p->name, "_at", odd);
}

PetscBool MPMUnlikely_probe_far(const MPMLook *look, PetscInt k, MPMOdd *odd)
{
  const char      *name = look->scene->probes[k];
  const PetscReal *x    = NULL;

  for (PetscInt j = 0; j < look->monitor->measures.nprobes; j++)
    if (look->monitor->measures.probe[j].follows && !strcmp(look->monitor->measures.probe[j].name, name))
      x = look->monitor->measures.probe[j].x;
  if (!x || look->core->step) return PETSC_FALSE;
  odd->ratio = PETSC_MAX_REAL;
  for (PetscInt b = 0; b < look->scene->nbodies; b++) {
    const PetscReal far = MPMUnlikelyGap(look, x, x, look->lower[b], look->upper[b]);

    odd->ratio = PetscMin(odd->ratio, PetscMax(0, far));
  }
  return MPMUnlikelyGiven("probe", name, "_follow", odd);
}
