/* read_rigid.c - rigid bodies of the scene: read at the start, and moved in each step by the formulas of their velocity
   and spin. All processes compute the same numbers. */
#include "scene/scene.h"

#define TOUCHES 1e-6 /* cells: free rigid bodies that start nearer to another one touch it */
#define EMPTY   0.01 /* cells: rigid bodies of less volume are refused */
#define LIGHT   1e-6 /* times the inertia of a body that is the same everywhere: less is an error */

static const PetscReal nowhere[3]  = {0};
static const char      turns_not[] = "with -geometry axisymmetric";

/* The options of a body that its kind of motion decides on: all of them, and those that each kind takes. */
static const char        all[]   = "material ppc offset deformation velocity mu tied spin pivot rho mass inertia";
static const char *const taken[] = {[MPM_RIGID_NONE]   = "material ppc offset deformation velocity",
                                    [MPM_RIGID_FIXED]  = "mu tied",
                                    [MPM_RIGID_MOVING] = "mu tied velocity spin pivot",
                                    [MPM_RIGID_FREE]   = "mu velocity spin rho mass inertia"};

/* Reads what a free body weighs. */
static PetscErrorCode ReadMass(MPMOptions o, PetscInt dim, PetscBool round, MPMBody *b)
{
  MPMExpression e = NULL;
  PetscBool     rho, mass, inertia;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReal(o, "body_<b>_rho", b->name, &b->rho, &rho));
  PetscCall(MPMOptionsReal(o, "body_<b>_mass", b->name, &b->mass, &mass));
  PetscCall(MPMOptionsExpression(o, "body_<b>_inertia", b->name, "", dim == 3 ? 3 : 1, &e));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  inertia = e ? PETSC_TRUE : PETSC_FALSE;
  if (e) PetscCall(MPMExpressionEvaluate(e, dim, nowhere, NULL, 0, b->inertia));
  PetscCall(MPMExpressionDestroy(&e));
  for (PetscInt d = 0; d < (dim == 3 ? 3 : 1) && inertia; d++)
    if (!(b->inertia[d] > 0 && b->inertia[d] <= PETSC_MAX_REAL))
      MPMOptionsFail(o, "-body_%s_inertia has %g, moments of inertia are above 0", b->name, (double)b->inertia[d]);
  for (PetscInt d = 0; d < 3 && inertia && dim == 3; d++)
    if (b->inertia[d] > (1 + 1e-9) * (b->inertia[(d + 1) % 3] + b->inertia[(d + 2) % 3]))
      MPMOptionsFail(o,
                     "-body_%s_inertia %g,%g,%g: no body has these moments, each is at most the sum of the other two "
                     "(%c: %g is above %g)",
                     b->name, (double)b->inertia[0], (double)b->inertia[1], (double)b->inertia[2], "xyz"[d],
                     (double)b -> inertia[d], (double)(b->inertia[(d + 1) % 3] + b->inertia[(d + 2) % 3]));
  if (rho == mass)
    MPMOptionsFail(o, "-body_%s_rigid free needs %s-body_%s_rho or -body_%s_mass%s", b->name, rho ? "either " : "",
                   b->name, b->name, rho ? ", not both" : "");
  if (inertia && !mass)
    MPMOptionsFail(o,
                   "-body_%s_inertia does not apply without -body_%s_mass: with -body_%s_rho it follows from the shape",
                   b->name, b->name, b->name);
  if (inertia && (dim == 1 || round))
    MPMOptionsFail(o, "-body_%s_inertia does not apply: %s nothing turns", b->name, dim == 1 ? "in 1-D" : turns_not);
  if (b->region.type == MPM_REGION_halfspace)
    MPMOptionsFail(
        o, "-body_%s_rigid free does not apply: a halfspace has no end, and so no mass; choose another shape", b->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses options of rigid bodies for a body that is not rigid, with what it has in their place. */
static PetscErrorCode RefuseOfRigid(MPMOptions o, const char name[])
{
  static const char *const option[][2] = {
      {"mu", "fixed, moving or free; bodies with particles have -contact_mu, or -contacts"},
      {"tied", "fixed or moving; bodies with particles that no contact names are tied where they meet"},
      {"rho", "free; a body with particles has that of its material"},
      {"mass", "free; a body with particles has the density of its material"},
      {"inertia", "free; that of a body with particles follows from them"},
      {"spin", "moving or free; a body with particles spins by its -body_<b>_velocity, a formula of x, y, z"},
      {"pivot", "moving"}};

  PetscFunctionBeginUser;
  for (size_t k = 0; k < sizeof option / sizeof option[0]; k++) {
    char      full[4 * MPM_NAME_LEN];
    PetscBool given;

    (void)snprintf(full, sizeof full, "-body_%s_%s", name, option[k][0]);
    PetscCall(PetscOptionsHasName(NULL, NULL, full, &given));
    if (given)
      MPMOptionsFail(o, "%s does not apply: it is of rigid bodies, with -body_%s_rigid %s", full, name, option[k][1]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneReadRigid(const MPMCore *core, MPMOptions o, MPMBody *b)
{
  static const char *const names[]            = {"no", "fixed", "moving", "free"};
  const PetscInt           dim                = core->grid.dim;
  char                     word[MPM_NAME_LEN] = "no";
  PetscBool                rubs;
  PetscInt                 row;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "body_<b>_rigid", b->name, word, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsFind(word, 4, names, &row));
  b->rigid = (MPMRigidType)row;
  if (b->rigid == MPM_RIGID_NONE) PetscCall(RefuseOfRigid(o, b->name));
  PetscCall(MPMOptionsRefuseOthers(o, "body", b->name, "rigid", word, all, taken[row]));
  if (b->rigid == MPM_RIGID_NONE || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  b->alone = PETSC_TRUE;
  if (b->region.type == MPM_REGION_file)
    MPMOptionsFail(o, "-body_%s_rigid %s does not apply: the particles of a file have no shape", b->name, word);
  PetscCall(MPMOptionsReal(o, "body_<b>_mu", b->name, &b->mu, &rubs));
  PetscCall(MPMOptionsBool(o, "body_<b>_tied", b->name, &b->tied));
  if (rubs && b->tied)
    MPMOptionsFail(o, "-body_%s_mu does not apply: -body_%s_tied lets nothing slide", b->name, b->name);
  if (rubs && b->mu > 0 && dim == 1) MPMOptionsFail(o, "-body_%s_mu does not apply: in 1-D nothing slides", b->name);
  if (b->rigid == MPM_RIGID_FIXED) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      MPMOptionsExpression(o, "body_<b>_velocity", b->name, b->rigid == MPM_RIGID_FREE ? "" : "t", dim, &b->velocity));
  PetscCall(MPMOptionsExpression(o, "body_<b>_spin", b->name, b->rigid == MPM_RIGID_FREE ? "" : "t", dim == 3 ? 3 : 1,
                                 &b->spin));
  if (b->spin && (dim == 1 || core->grid.round))
    MPMOptionsFail(o, "-body_%s_spin does not apply: %s nothing turns", b->name, dim == 1 ? "in 1-D" : turns_not);
  if (b->rigid == MPM_RIGID_FREE) {
    PetscCall(ReadMass(o, dim, core->grid.round, b));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MPMOptionsReals(o, "body_<b>_pivot", b->name, b->pivot, &b->has_pivot));
  if (!MPMOptionsError(o) && !b->velocity && !b->spin)
    MPMOptionsFail(o, "-body_%s_rigid moving needs -body_%s_velocity or -body_%s_spin; a body at rest is fixed",
                   b->name, b->name, b->name);
  if (b->spin && !b->has_pivot)
    MPMOptionsFail(o, "-body_%s_spin needs -body_%s_pivot, the point about which the body turns", b->name, b->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets velocity and spin [3] of a body at time t, s. */
static PetscErrorCode Evaluate(const MPMBody *b, PetscInt dim, PetscReal t, PetscReal velocity[], PetscReal spin[])
{
  PetscFunctionBeginUser;
  if (b->velocity) PetscCall(MPMExpressionEvaluate(b->velocity, dim, nowhere, NULL, t, velocity));
  if (b->spin) PetscCall(MPMExpressionEvaluate(b->spin, dim, nowhere, NULL, t, dim == 3 ? spin : spin + 2));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether they are finite, and sets *what to the word of the option that is not. */
static PetscErrorCode IsFinite(const MPMBody *b, PetscInt dim, PetscReal t, const char **what)
{
  PetscReal v[3] = {0}, w[3] = {0};

  PetscFunctionBeginUser;
  PetscCall(Evaluate(b, dim, t, v, w));
  *what = !(PetscAbsReal(v[0]) + PetscAbsReal(v[1]) + PetscAbsReal(v[2]) <= PETSC_MAX_REAL)   ? "velocity"
          : !(PetscAbsReal(w[0]) + PetscAbsReal(w[1]) + PetscAbsReal(w[2]) <= PETSC_MAX_REAL) ? "spin"
                                                                                              : NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define ASIDE                                                                                                               \
  "-body_%s_velocity has %g along x at t = %g s: with -geometry axisymmetric x is the radius; free rigid bodies and those " \
  "on the axis move along y only"

/* Sets *aside to the velocity along the radius of a body of revolution that may have none. */
static PetscErrorCode Aside(const MPMCore *core, const MPMBody *b, PetscReal t, PetscReal *aside)
{
  PetscReal v[3] = {0}, w[3] = {0}, lower[3], upper[3];

  PetscFunctionBeginUser;
  *aside = 0;
  if (!core->grid.round) PetscFunctionReturn(PETSC_SUCCESS);
  MPMRegionBounds(&b->region, core->grid.dim, lower, upper);
  PetscCall(Evaluate(b, core->grid.dim, t, v, w));
  if (b->rigid == MPM_RIGID_FREE || lower[0] <= 0) *aside = v[0];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes a free body of one that has been read, with a shape of mass m: its mass, centre, inertia and angular momentum. */
static PetscErrorCode MakeFree(const MPMBody *b, PetscInt dim, const MPMRigidMass *m, MPMOptions o, MPMRigid *r)
{
  PetscReal mass = b->mass > 0 ? b->mass : b->rho * m->volume, inertia[9] = {0};
  PetscBool turns = PETSC_TRUE;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 9; k++) inertia[k] = m->inertia[k] * mass / m->volume;
  for (PetscInt d = 0; d < 3 && b->inertia[0] > 0; d++) {
    const PetscReal given = b->inertia[dim == 3 ? d : 0];

    if ((dim == 3 || d == 2) && given < LIGHT * inertia[4 * d])
      MPMOptionsFail(
          o,
          "-body_%s_inertia %g is less than %g times that of a body of this shape and mass, %.3g kg m^2 about "
          "%c; leave it out for this one",
          b->name, (double)given, LIGHT, (double)inertia[4 * d], "xyz"[d]);
    for (PetscInt e = 0; e < 3; e++) inertia[3 * d + e] = d == e ? given : 0;
  }
  for (PetscInt d = 0; d < dim; d++) r->pivot[d] = m->center[d];
  PetscCall(MPMRigidSetFree(r, dim, mass, inertia));
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++)
      if (dim == 3 || (dim == 2 && d == 2 && e == 2)) r->momentum[d] += inertia[3 * d + e] * r->spin[e];
  for (PetscInt d = 0; d < 3; d++) turns = turns && PetscAbsReal(r->momentum[d]) <= PETSC_MAX_REAL;
  if (!(mass <= PETSC_MAX_REAL && turns)) MPMOptionsFail(o, "the rigid body %s has a mass that is not finite", b->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes rigid body r of a body that has been read. */
static PetscErrorCode MakeRigid(const MPMCore *core, const MPMBody *b, MPMOptions o, MPMRigid *r)
{
  const PetscInt dim = core->grid.dim, others = b->region.ncut + b->region.nwithin;
  PetscReal      lower[3] = {0}, upper[3] = {0}, cell = 1, aside;
  MPMRigidMass   m;
  const char    *what;

  PetscFunctionBeginUser;
  MPMRegionBounds(&b->region, dim, lower, upper);
  for (PetscInt d = 0; d < dim; d++)
    if (!(upper[d] > core->grid.lower[d] && lower[d] < core->grid.upper[d]))
      MPMOptionsFail(
          o,
          "the rigid body %s lies outside of the grid: on axis %c from %g to %g, the grid from %g to %g; see "
          "-body_%s_shape",
          b->name, "xyz"[d], (double)lower[d], (double)upper[d], (double)core -> grid.lower[d],
          (double)core->grid.upper[d], b->name);
  if (b->rigid == MPM_RIGID_FREE || others > 0 || b->region.type == MPM_REGION_sphere) {
    MPMRigidMassOf(&b->region, dim, core->grid.round, &m);
    if (core->grid.round && lower[0] < 0) m.center[0] = 0;
    for (PetscInt d = 0; d < dim; d++) cell *= core->grid.h[d];
    if (core->grid.round) cell *= 2 * PETSC_PI * PetscMax(upper[0], core->grid.h[0]);
    if (!(m.volume > EMPTY * cell))
      MPMOptionsFail(
          o, "-body_%s_%s: the rigid body %s has only %.2g times the volume of a cell, it must have more than %g times",
          b->name, others > 0 ? others > b->region.ncut ? "within" : "cut" : "shape", b->name,
          (double)(m.volume / cell), EMPTY);
  }
  PetscCall(IsFinite(b, dim, 0, &what));
  if (what) MPMOptionsFail(o, "-body_%s_%s is not finite at t = 0", b->name, what);
  PetscCall(Aside(core, b, 0, &aside));
  if (aside != 0) MPMOptionsFail(o, ASIDE, b->name, (double)aside, 0.0);
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  r->name  = b->name;
  r->shape = &b->region;
  r->mu    = b->mu;
  r->tied  = b->tied;
  r->moves = b->rigid == MPM_RIGID_MOVING || b->rigid == MPM_RIGID_FREE;
  for (PetscInt d = 0; d < 3; d++) {
    r->pivot[d]    = d < dim && !b->has_pivot ? 0.5 * (lower[d] + upper[d]) : b->pivot[d];
    r->turn[4 * d] = 1;
  }
  PetscCall(Evaluate(b, dim, 0, r->velocity, r->spin));
  if (b->rigid == MPM_RIGID_FREE) PetscCall(MakeFree(b, dim, &m, o, r));
  for (PetscInt d = 0; d < dim; d++) r->reach += PetscSqr(PetscMax(r->pivot[d] - lower[d], upper[d] - r->pivot[d]));
  r->reach = PetscSqrtReal(r->reach);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds pairs of each rigid body with each copy of the nodes. */
static PetscErrorCode AddPairs(MPMCore *core)
{
  const PetscInt copies = PetscMax(1, core->grid.copies);
  MPMContacts   *c      = core->contacts;

  PetscFunctionBeginUser;
  if (!c) PetscCall(PetscNew(&c));
  core->contacts = c;
  PetscCall(PetscRealloc((size_t)(c->npairs + core->rigids.n * copies) * sizeof *c->pair, &c->pair));
  for (MPMRigid *r = core->rigids.body; r < core->rigids.body + core->rigids.n; r++)
    for (PetscInt copy = 0; copy < copies; copy++)
      c->pair[c->npairs++] = (MPMPair){.a = -1, .b = copy, .axis = -1, .rigid = r, .mu = r->mu};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prepares the distances from rigid bodies of one type: from shapes that others share too, last those of bodies that
   move, whose surfaces at the walls of the grid count. */
static PetscErrorCode MakeDistances(MPMScene *scene, const MPMCore *core, MPMOptions o, MPMRigidType type)
{
  PetscFunctionBeginUser;
  for (PetscInt k = scene->nbodies; k < scene->nbodies + scene->nshapes && !MPMOptionsError(o); k++) {
    MPMBody   *b = &scene->bodies[k];
    MPMRegion *r = &b->region;
    PetscReal  middle[3];

    if (b->rigid == MPM_RIGID_NONE || (b->rigid == MPM_RIGID_FIXED) != (type == MPM_RIGID_FIXED)) continue;
    PetscCheck(MPMRegionMakeDistance(r, &core->grid, b->rigid == MPM_RIGID_FIXED), PETSC_COMM_SELF, PETSC_ERR_MEM,
               "no memory for the distance from %s", b->name);
    for (PetscInt d = 0; d < core->grid.dim; d++) middle[d] = 0.5 * (r->lower[d] + r->upper[d]);
    if (r->type == MPM_REGION_expression && r->nearest && !r->nearest->n &&
        !(r->formula(r->context, core->grid.dim, middle) > 0))
      MPMOptionsFail(o,
                     "-body_%s_expression is not positive at any of the places half a cell apart at which it was "
                     "computed; a rigid body must be thicker",
                     b->name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses two tied bodies that overlap at the start if one moves: matter in both cannot move with both. */
static PetscErrorCode CheckTied(const MPMCore *core, MPMOptions o, const MPMRigid *a, const MPMRigid *b)
{
  const PetscInt  dim     = core->grid.dim;
  const PetscReal deep    = -TOUCHES * MPMGridSmallestH(&core->grid);
  MPMRigid        pair[2] = {*a, *b};

  PetscFunctionBeginUser;
  if (!(a->tied && b->tied && (a->moves || b->moves))) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2; k++) PetscCall(MPMRigidSetPoints(&pair[k], dim));
  if (MPMRigidTouches(&pair[0], &pair[1], dim, deep) || MPMRigidTouches(&pair[1], &pair[0], dim, deep))
    MPMOptionsFail(
        o,
        "-body_%s_tied: the rigid bodies %s and %s overlap at the start, and matter in both cannot move with "
        "both; move one",
        a->name, a->name, b->name);
  for (PetscInt k = 0; k < 2; k++) PetscCall(PetscFree(pair[k].point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneMakeRigids(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  const MPMBody *first = scene->bodies + scene->nbodies;
  MPMRigids     *r     = &core->rigids;
  PetscInt       n     = 0, a, b;

  PetscFunctionBeginUser;
  r->meet = PETSC_INFINITY;
  for (PetscInt k = 0; k < scene->nshapes; k++) n += first[k].rigid != MPM_RIGID_NONE;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MakeDistances(scene, core, o, MPM_RIGID_FIXED));
  PetscCall(MakeDistances(scene, core, o, MPM_RIGID_MOVING));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(n, &r->body));
  PetscCall(PetscCalloc1(n * MPM_RIGID_NUMBERS, &r->numbers));
  for (PetscInt k = 0; k < scene->nshapes && !MPMOptionsError(o); k++) {
    if (first[k].rigid == MPM_RIGID_NONE) continue;
    MPMRigidUse(&r->body[r->n], r->numbers + r->n * MPM_RIGID_NUMBERS);
    PetscCall(MakeRigid(core, &first[k], o, &r->body[r->n]));
    if (first[k].rigid == MPM_RIGID_MOVING) r->driven = PETSC_TRUE;
    if (r->body[r->n].free) r->free = PETSC_TRUE;
    if (!MPMOptionsError(o)) MPMSceneHoldRigid(scene, core, o, &first[k], &r->body[r->n]);
    r->n++;
  }
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  MPMRigidsMeet(r->n, r->body, core->grid.dim, TOUCHES * MPMGridSmallestH(&core->grid), &a, &b);
  if (a >= 0)
    MPMOptionsFail(
        o,
        "the rigid bodies %s and %s touch at the start; contact between rigid bodies is not built: move one, or "
        "make both fixed or moving",
        r->body[a].name, r->body[b].name);
  for (PetscInt k = 0; k < r->n; k++)
    for (PetscInt q = k + 1; q < r->n && !MPMOptionsError(o); q++)
      PetscCall(CheckTied(core, o, &r->body[k], &r->body[q]));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AddPairs(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneCheckInside(const MPMCore *core, MPMOptions o, const MPMBody *b, const PetscReal x[])
{
  const PetscInt dim = core->grid.dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < core->rigids.n; k++) {
    const char     *name = core->rigids.body[k].name;
    char            at[MPM_NAME_LEN], deep[MPM_NAME_LEN] = "", hold[3 * MPM_NAME_LEN] = "";
    PetscReal       n[3];
    const PetscReal distance = MPMRigidDistance(&core->rigids.body[k], dim, x, n);

    if (core->rigids.body[k].tied || !(distance < -TOUCHES * MPMGridSmallestH(&core->grid))) continue;
    MPMPlaceWords(dim, x, at);
    if (distance > -PETSC_MAX_REAL) (void)snprintf(deep, sizeof deep, " %g m", (double)-distance);
    if (!core->rigids.body[k].free)
      (void)snprintf(hold, sizeof hold, ", or let %s hold it (-body_%s_tied)", name, name);
    MPMOptionsFail(
        o, "a particle of %s at %s starts%s inside the rigid body %s: move one of them, or cut %s (-body_%s_cut %s)%s",
        b->name, at, deep, name, b->name, b->name, name, hold);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneEvaluateRigids(const MPMScene *scene, PetscInt dim, PetscReal t, MPMRigid body[])
{
  MPMRigid *r = body;

  PetscFunctionBeginUser;
  for (PetscInt k = scene->nbodies; k < scene->nbodies + scene->nshapes && r; k++) {
    const MPMBody *b = &scene->bodies[k];

    if (b->rigid == MPM_RIGID_MOVING && !r->gone) PetscCall(Evaluate(b, dim, t, r->velocity, r->spin));
    if (b->rigid != MPM_RIGID_NONE) r++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneMoveRigids(const MPMScene *scene, MPMCore *core, PetscReal t)
{
  PetscFunctionBeginUser;
  PetscCall(MPMSceneEvaluateRigids(scene, core->grid.dim, t, core->rigids.body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneCheckRigids(const MPMScene *scene, MPMCore *core, PetscReal t)
{
  PetscFunctionBeginUser;
  for (PetscInt k = scene->nbodies; k < scene->nbodies + scene->nshapes && !core->stop[0]; k++) {
    const char *what = NULL;
    PetscReal   aside;

    if (scene->bodies[k].removed) continue;
    if (scene->bodies[k].rigid == MPM_RIGID_MOVING) PetscCall(IsFinite(&scene->bodies[k], core->grid.dim, t, &what));
    if (what)
      (void)snprintf(core->stop, sizeof core->stop, "-body_%s_%s is not finite at t = %g s", scene->bodies[k].name,
                     what, (double)t);
    if (scene->bodies[k].rigid != MPM_RIGID_MOVING) continue;
    PetscCall(Aside(core, &scene->bodies[k], t, &aside));
    if (aside != 0 && !core->stop[0])
      (void)snprintf(core->stop, sizeof core->stop, ASIDE, scene->bodies[k].name, (double)aside, (double)t);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
