/* rigid.c - rigid bodies that are free in a step: gravity, and the walls of the grid on which they stand. What matter
   does to them is in contact.c. All processes compute the same numbers.

   A body stands on a wall with a few points of its surface: the one that is nearest to the wall, and in some directions
   along the wall one that is nearly as near (SLOPES) and farther out; a ball and a disk with the lowest one. A point
   may come nearer by its gap at most. */
#include "physics/wall.h"
#include "step/friction.h"
#include "step/step.h"

#define SLOPES     0.02 /* m a point may be higher for each m that it lies farther out */
#define DIRECTIONS 8    /* along a wall in 3-D; in 2-D there are two */
#define TOUCHES    1e-6 /* cells: rigid bodies that are nearer meet */
#define CROSSES    0.5  /* cells: a free body that reaches farther beyond a periodic face stops the run */
#define CLOSES     50   /* steps in which a body that has sunk in comes out again, so that errors do not add up */

PetscErrorCode MPMRigidsDestroy(MPMCore *core)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < core->rigids.n; k++) PetscCall(PetscFree(core->rigids.body[k].point));
  PetscCall(PetscFree(core->rigids.body));
  PetscCall(PetscFree(core->rigids.numbers));
  PetscCall(PetscFree(core->rigids.support));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a support at x [dim], from which the wall is `gap` away; the same place is added once. */
static PetscErrorCode Add(MPMCore *core, PetscInt body, PetscInt face, const PetscReal x[], PetscReal gap)
{
  MPMRigids      *r  = &core->rigids;
  const PetscReal dt = core->params.dt;

  PetscFunctionBeginUser;
  if (r->nsupports == r->room) {
    r->room = 2 * r->room + 16;
    PetscCall(PetscRealloc((size_t)r->room * sizeof *r->support, &r->support));
  }
  for (PetscInt k = r->nsupports - 1; k >= 0 && r->support[k].body == body && r->support[k].face == face; k--) {
    const PetscReal *at = r->support[k].at;

    if (at[0] == x[0] && at[1] == x[1] && at[2] == x[2]) PetscFunctionReturn(PETSC_SUCCESS);
  }
  r->support[r->nsupports++] = (MPMRigidSupport){
      .body = body, .face = face, .at = {x[0], x[1], x[2]}, .least = gap > 0 ? -gap / dt : -gap / (CLOSES * dt)};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the supports of a body on the wall of a face. */
static PetscErrorCode FindSupports(MPMCore *core, PetscInt body, PetscInt face)
{
  const MPMGrid  *grid = &core->grid;
  const PetscInt  dim = grid->dim, axis = face / 2;
  const MPMRigid *r = &core->rigids.body[body];
  PetscReal       plane, sign, x[3], best[DIRECTIONS + 1], at[3];
  PetscInt        which[DIRECTIONS + 1] = {0}, n = dim == 1 ? 1 : dim == 2 ? 3 : DIRECTIONS + 1;

  PetscFunctionBeginUser;
  MPMWallPlane(core->params.walls, grid, face, &plane, &sign);
  for (PetscInt d = 0; d < 3; d++) at[d] = r->pivot[d] + r->place[d];
  if (sign * (at[axis] - plane) > r->reach + MPMGridSmallestH(grid)) PetscFunctionReturn(PETSC_SUCCESS);
  if (MPMRigidIsRound(r)) {
    at[axis] -= sign * r->shape->radius;
    PetscCall(Add(core, body, face, at, sign * (at[axis] - plane)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt q = 0; q < n; q++) best[q] = PETSC_MAX_REAL;
  for (PetscInt k = 0; k < r->npoints; k++) {
    PetscReal gap, along[3];

    MPMRigidPoint(r, k, x);
    gap = sign * (x[axis] - plane);
    for (PetscInt d = 0; d < 2; d++) along[d] = dim == 2 && d ? 0 : x[(axis + 1 + d) % dim] - at[(axis + 1 + d) % dim];
    for (PetscInt q = 0; q < n; q++) {
      const PetscReal by = q == 0 ? 0
                           : dim == 2
                               ? (q == 1 ? along[0] : -along[0])
                               : along[0] * PetscCosReal(q * PETSC_PI / 4) + along[1] * PetscSinReal(q * PETSC_PI / 4);

      if (!(gap - SLOPES * by < best[q])) continue;
      best[q]  = gap - SLOPES * by;
      which[q] = k;
    }
  }
  for (PetscInt q = 0; q < n && r->npoints; q++) {
    MPMRigidPoint(r, which[q], x);
    PetscCall(Add(core, body, face, x, sign * (x[axis] - plane)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMRigidsBegin(MPMCore *core)
{
  const PetscInt dim = core->grid.dim;

  PetscFunctionBeginUser;
  core->rigids.nsupports = 0;
  for (PetscInt k = 0; k < core->rigids.n; k++) {
    MPMRigid *r = &core->rigids.body[k];

    for (PetscInt d = 0; d < 3; d++) {
      r->before[d]     = r->velocity[d];
      r->before[3 + d] = r->spin[d];
      if (r->free && d < dim && !MPMRigidIsHeld(r, d))
        r->velocity[d] += core->params.kick * (core->params.gravity[d] + r->pushed[d]);
    }
    for (PetscInt face = 0; face < 2 * dim && r->free; face++)
      if (!(r->held >> face & 1) && !MPMWallHas(core->params.walls->given[face / 2][face % 2].type, MPM_WALL_OPEN))
        PetscCall(FindSupports(core, k, face));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Changes the impulses of a support by what is missing now; returns by how much the velocity of its place changes, m/s.
   */
static PetscReal Act(MPMCore *core, MPMRigidSupport *s)
{
  const MPMFace  *f    = &core->params.walls->given[s->face / 2][s->face % 2];
  const PetscInt  axis = s->face / 2;
  const PetscReal sign = s->face % 2 ? -1 : 1;
  const PetscReal mu   = MPMWallHas(f->type, MPM_WALL_TANGENT)  ? PETSC_MAX_REAL
                         : MPMWallHas(f->type, MPM_WALL_BRAKES) ? f->mu
                                                                : 0;
  MPMRigid       *r    = &core->rigids.body[s->body];
  PetscReal       v[3], n[3] = {0}, J[3] = {0}, yields, more, slide = 0;

  n[axis] = sign;
  MPMRigidVelocity(r, core->grid.dim, s->at, v);
  for (PetscInt d = 0; d < 3; d++) v[d] -= f->velocity[d];
  yields = MPMRigidYields(r, s->at, n);
  more   = PetscMax((s->least - sign * v[axis]) / yields, -s->press);
  s->press += more;
  J[axis] = sign * more;
  if (mu > 0) {
    PetscReal t[3] = {0}, brake[3] = {0};

    for (PetscInt d = 0; d < 3; d++) {
      t[d] = d == axis || d >= core->grid.dim ? 0 : v[d];
      slide += t[d] * t[d];
    }
    slide = PetscSqrtReal(slide);
    for (PetscInt d = 0; d < 3; d++) {
      if (slide > 0) t[d] /= slide;
      brake[d] = s->brake[d];
    }
    for (PetscInt d = 0; d < 3 && slide > 0; d++) brake[d] -= t[d] * slide / MPMRigidYields(r, s->at, t);
    MPMFrictionSet(mu, s->press, brake, s->brake, J);
  }
  MPMRigidKick(r, s->at, J);
  return yields * (PetscAbsReal(J[0]) + PetscAbsReal(J[1]) + PetscAbsReal(J[2]));
}

PetscReal MPMRigidsStand(MPMCore *core)
{
  PetscReal most = 0;

  for (PetscInt k = 0; k < core->rigids.nsupports; k++) { /* PetscMax is a macro: a function in it would act twice */
    const PetscReal change = Act(core, &core->rigids.support[k]);

    most = PetscMax(most, change);
  }
  return most;
}

/* Returns the mean of the velocities along J before and after the step of place x of a body, times J, J. */
static PetscReal Work(const MPMRigid *r, PetscInt dim, const PetscReal x[], const PetscReal J[])
{
  MPMRigid  was = *r;
  PetscReal before[6], V[3], U[3], work = 0;

  for (PetscInt k = 0; k < 6; k++) before[k] = r->before[k];
  was.velocity = before;
  was.spin     = before + 3;
  MPMRigidVelocity(r, dim, x, V);
  MPMRigidVelocity(&was, dim, x, U);
  for (PetscInt d = 0; d < dim; d++) work += 0.5 * J[d] * (U[d] + V[d]);
  return work;
}

/* Adds up what gravity, body forces and the walls have done to free bodies in a step, from before they move. */
static void Account(MPMCore *core)
{
  MPMRigids *r = &core->rigids;

  for (PetscInt k = 0; k < r->n; k++) {
    const MPMRigid *b = &r->body[k];
    PetscReal       x[3], J[3] = {0}, pushed[3] = {0};

    for (PetscInt d = 0; d < 3; d++) x[d] = b->pivot[d] + b->place[d];
    for (PetscInt d = 0; d < core->grid.dim; d++) {
      J[d]      = b->mass * core->params.kick * core->params.gravity[d];
      pushed[d] = b->mass * core->params.kick * b->pushed[d];
    }
    if (b->free) r->energy[0] += Work(b, core->grid.dim, x, J);
    if (b->free && core->needs.forced) r->loads += Work(b, core->grid.dim, x, pushed);
  }
  for (const MPMRigidSupport *s = r->support; s < r->support + r->nsupports; s++) {
    const MPMWall type = core->params.walls->given[s->face / 2][s->face % 2].type;
    PetscReal     J[3];

    for (PetscInt d = 0; d < 3; d++) J[d] = s->brake[d];
    J[s->face / 2] += s->face % 2 ? -s->press : s->press;
    r->energy[MPMWallHas(type, MPM_WALL_MOVES) ? 2 : 1] += Work(&r->body[s->body], core->grid.dim, s->at, J);
  }
}

void MPMRigidsMove(MPMCore *core)
{
  if (core->rigids.free) Account(core);
  for (PetscInt k = 0; k < core->rigids.n; k++) MPMRigidMove(&core->rigids.body[k], core->params.dt);
}

/* Leaves a reason to stop if a free body has come across a periodic face, at whose other side it does nothing. */
static void CheckPeriodic(MPMCore *core, const MPMRigid *r)
{
  const MPMGrid *grid = &core->grid;

  for (PetscInt face = 0; face < 2 * grid->dim && r->free && !core->stop[0]; face++) {
    const PetscInt  axis  = face / 2;
    const PetscReal plane = face % 2 ? grid->upper[axis] : grid->lower[axis], sign = face % 2 ? -1 : 1;
    const PetscReal gap   = sign * (r->pivot[axis] + r->place[axis] - plane);
    PetscReal       least = MPMRigidIsRound(r) ? gap - r->shape->radius : gap, x[3];

    if (!grid->periodic[axis] || gap - r->reach > -CROSSES * grid->h[axis]) continue;
    for (PetscInt k = 0; k < r->npoints && !MPMRigidIsRound(r); k++) {
      MPMRigidPoint(r, k, x);
      least = PetscMin(least, sign * (x[axis] - plane));
    }
    if (least < -CROSSES * grid->h[axis])
      (void)snprintf(
          core->stop, sizeof core->stop,
          "the rigid body %s reaches %.3g m beyond the periodic face %s at t=%g s; rigid bodies do not cross "
          "periodic faces: enlarge the grid, or choose an earlier -time_end",
          r->name, (double)-least, MPMFaceNames[face], (double)core->t);
  }
}

void MPMRigidsCheck(MPMCore *core)
{
  PetscInt a, b;

  MPMRigidsMeet(core->rigids.n, core->rigids.body, core->grid.dim, TOUCHES * MPMGridSmallestH(&core->grid), &a, &b);
  if (a >= 0 && !core->stop[0])
    (void)snprintf(
        core->stop, sizeof core->stop,
        "the rigid bodies %s and %s meet at t=%g s; they would pass through each other, since contact between rigid "
        "bodies is not built",
        core->rigids.body[a].name, core->rigids.body[b].name, (double)core->t);
  if (core->rigids.driven && core->t >= core->rigids.meet && !core->stop[0])
    (void)snprintf(core->stop, sizeof core->stop,
                   "the rigid bodies %s and %s pass through each other at t=%g s; contact between rigid bodies is not "
                   "built",
                   core->rigids.body[core->rigids.meets[0]].name, core->rigids.body[core->rigids.meets[1]].name,
                   (double)core->t);
  for (PetscInt k = 0; k < core->rigids.n && !core->stop[0]; k++) {
    const MPMRigid *r = &core->rigids.body[k];

    CheckPeriodic(core, r);
    for (PetscInt d = 0; d < core->grid.dim && r->free && !core->stop[0]; d++) {
      const PetscReal at = r->pivot[d] + r->place[d];

      if (!MPMRigidIsHeld(r, d) && !(at >= core->grid.lower[d] && at <= core->grid.upper[d]))
        (void)snprintf(core->stop, sizeof core->stop,
                       "the rigid body %s left the grid, to %c = %g m; enlarge the grid (-grid_%s), close it by a wall "
                       "(-bc_%s_type), or choose an earlier -time_end",
                       r->name, "xyz"[d], (double)at, at > core -> grid.upper[d] ? "upper" : "lower",
                       MPMFaceNames[2 * d + (at > core->grid.upper[d])]);
    }
  }
}
