/* read_rigid.c - rigid bodies of the scene: read at the start, and moved in each step by the formulas of their velocity
   and spin. All processes compute the same numbers. */
#include "scene/scene.h"

/* Reads what only a free body has. */
static PetscErrorCode ReadFree(PetscInt dim, MPMOptions o, MPMBody *b)
{
  PetscBool rho, mass;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReal(o, "body_<b>_rho", b->name, &b->rho, &rho));
  PetscCall(MPMOptionsReal(o, "body_<b>_mass", b->name, &b->mass, &mass));
  if (rho == mass && !MPMOptionsError(o))
    MPMOptionsFail(o, "-body_%s_rigid free needs %s -body_%s_rho %s -body_%s_mass", b->name, rho ? "one of" : "a mass:",
                   b->name, rho ? "and" : "or", b->name);
  if (dim > 1) PetscCall(MPMOptionsExpression(o, "body_<b>_inertia", b->name, "", dim == 3 ? 3 : 1, &b->inertia));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneReadRigid(const MPMCore *core, MPMOptions o, MPMBody *b)
{
  const PetscInt dim = core->grid.dim;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReal(o, "body_<b>_mu", b->name, &b->mu, NULL));
  if (b->rigid == MPM_RIGID_FIXED) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsExpression(o, "body_<b>_velocity", b->name, b->rigid == MPM_RIGID_FREE ? "" : "t", dim, &b->velocity));
  if (dim > 1)
    PetscCall(MPMOptionsExpression(o, "body_<b>_spin", b->name, b->rigid == MPM_RIGID_FREE ? "" : "t", dim == 3 ? 3 : 1,
                                   &b->spin));
  if (b->rigid == MPM_RIGID_FREE) {
    PetscCall(ReadFree(dim, o, b));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (dim > 1) PetscCall(MPMOptionsReals(o, "body_<b>_pivot", b->name, b->pivot, NULL));
  if (!MPMOptionsError(o) && !b->velocity && !b->spin)
    MPMOptionsFail(o, "-body_%s_rigid moving needs -body_%s_velocity or -body_%s_spin; a body at rest is fixed", b->name,
                   b->name, b->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets volume, centre [3] and moments of inertia [9] about that, for a density of 1, of a shape: sums over SAMPLES places on
   each axis of the box around it. Of a disk of 1 m their errors are 1e-4 of the values, of a ball 1e-3; boxes and spheres
   are exact. */
static PetscReal Moments(const MPMRegion *r, PetscInt dim, PetscReal centre[], PetscReal inertia[])
{
  const PetscInt samples = dim == 3 ? 96 : 1024, n[3] = {samples, dim > 1 ? samples : 1, dim > 2 ? samples : 1};
  PetscReal      lower[3] = {0}, upper[3] = {0}, sum[10] = {0}, cell = 1, middle[3] = {0};

  MPMRegionBounds(r, dim, lower, upper);
  for (PetscInt d = 0; d < dim; d++) {
    cell *= (upper[d] - lower[d]) / (PetscReal)n[d];
    middle[d] = 0.5 * (lower[d] + upper[d]);
  }
  for (PetscInt k = 0; k < n[2]; k++)
    for (PetscInt j = 0; j < n[1]; j++)
      for (PetscInt i = 0; i < n[0]; i++) {
        const PetscInt at[3] = {i, j, k};
        PetscReal      x[3] = {0}, y[3] = {0};

        for (PetscInt d = 0; d < dim; d++) x[d] = lower[d] + ((PetscReal)at[d] + 0.5) * (upper[d] - lower[d]) / (PetscReal)n[d];
        if (!MPMRegionInside(r, dim, x)) continue;
        for (PetscInt d = 0; d < dim; d++) y[d] = x[d] - middle[d];
        sum[0] += cell;
        for (PetscInt d = 0, q = 4; d < 3; d++) {
          sum[1 + d] += cell * y[d];
          for (PetscInt e = d; e < 3; e++) sum[q++] += cell * y[d] * y[e];
        }
      }
  for (PetscInt d = 0; d < 3 && sum[0] > 0; d++) centre[d] = sum[1 + d] / sum[0];
  for (PetscInt d = 0, q = 4; d < 3; d++)
    for (PetscInt e = d; e < 3; e++, q++) inertia[3 * d + e] = inertia[3 * e + d] = -(sum[q] - sum[0] * centre[d] * centre[e]);
  cell = inertia[0] + inertia[4] + inertia[8];
  for (PetscInt d = 0; d < 3; d++) {
    inertia[4 * d] -= cell;
    centre[d] += middle[d];
  }
  if (r->ncut + r->nwithin) return sum[0];
  if (r->type == MPM_REGION_sphere) {
    const PetscReal R = r->radius, V = dim == 3 ? 4. / 3 * PETSC_PI * R * R * R : dim == 2 ? PETSC_PI * R * R : 2 * R;

    for (PetscInt d = 0; d < 9; d++) inertia[d] = d % 4 ? 0 : (dim == 3 ? 0.4 : 0.5) * V * R * R;
    return V;
  }
  return sum[0];
}

/* Puts places on the surface of a shape: the nearest ones of a lattice around it. */
static PetscErrorCode SetPoints(PetscInt dim, MPMRigid *r)
{
  const PetscInt samples = dim == 3 ? 24 : 96, n[3] = {samples, dim > 1 ? samples : 1, dim > 2 ? samples : 1};
  PetscReal      lower[3] = {0}, upper[3] = {0}, wide = 0;
  PetscInt       room = 0;

  PetscFunctionBeginUser;
  MPMRegionBounds(r->shape, dim, lower, upper);
  for (PetscInt d = 0; d < dim; d++) wide = PetscMax(wide, (upper[d] - lower[d]) / (PetscReal)(samples - 1));
  for (PetscInt k = 0; k < n[2]; k++)
    for (PetscInt j = 0; j < n[1]; j++)
      for (PetscInt i = 0; i < n[0]; i++) {
        const PetscInt at[3] = {i, j, k};
        PetscReal      x[3] = {0}, m[3] = {0}, away;

        for (PetscInt d = 0; d < dim; d++) x[d] = lower[d] + (PetscReal)at[d] * (upper[d] - lower[d]) / (PetscReal)(n[d] - 1);
        away = MPMRegionDistance(r->shape, dim, x, m);
        if (!(PetscAbsReal(away) < 0.75 * wide)) continue;
        if (r->npoints == room) {
          room = 2 * room + 256;
          PetscCall(PetscRealloc((size_t)(3 * room) * sizeof *r->points, &r->points));
        }
        for (PetscInt d = 0; d < 3; d++) r->points[3 * r->npoints + d] = x[d] - away * m[d];
        r->npoints++;
      }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets mass, inertia, and the motion at the start of a free body. */
static PetscErrorCode SetFree(const MPMBody *b, PetscInt dim, MPMOptions o, MPMRigid *r)
{
  static const PetscReal nowhere[3] = {0};
  PetscReal              inertia[9] = {0}, volume, given[3], det;

  PetscFunctionBeginUser;
  r->free = PETSC_TRUE;
  volume  = Moments(&b->region, dim, r->pivot, inertia);
  if (!(volume > 0)) MPMOptionsFail(o, "body %s: nothing is inside of its shape", b->name);
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  r->mass = b->mass > 0 ? b->mass : b->rho * volume;
  for (PetscInt k = 0; k < 9; k++) inertia[k] *= r->mass / volume;
  if (b->inertia) {
    PetscCall(MPMExpressionEvaluate(b->inertia, dim, nowhere, NULL, 0, given));
    for (PetscInt k = 0; k < 9; k++) inertia[k] = k % 4 ? 0 : given[dim == 3 ? k / 4 : 0];
    for (PetscInt d = 0; d < (dim == 3 ? 3 : 1); d++)
      if (!(given[d] > 0)) MPMOptionsFail(o, "-body_%s_inertia: %g is not larger than 0", b->name, (double)given[d]);
  }
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  det = MPMDet(3, inertia);
  if (dim == 3) {
    MPMCofactor(3, inertia, r->inverse);
    for (PetscInt k = 0; k < 9; k++) r->inverse[k] /= det;
  } else if (dim == 2)
    r->inverse[8] = 1 / inertia[8];
  if (b->velocity) PetscCall(MPMExpressionEvaluate(b->velocity, dim, nowhere, NULL, 0, r->velocity));
  if (b->spin) PetscCall(MPMExpressionEvaluate(b->spin, dim, nowhere, NULL, 0, dim == 3 ? r->spin : r->spin + 2));
  for (PetscInt d = 0; d < 3; d++)
    for (PetscInt e = 0; e < 3; e++) r->momentum[d] += inertia[3 * d + e] * r->spin[e];
  if (b->region.type != MPM_REGION_sphere || b->region.ncut + b->region.nwithin) PetscCall(SetPoints(dim, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneDestroyRigids(MPMCore *core)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < core->rigids.n; k++) PetscCall(PetscFree(core->rigids.body[k].points));
  PetscCall(PetscFree(core->rigids.body));
  PetscCall(PetscFree(core->rigids.numbers));
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
  for (PetscInt k = 0; k < core->rigids.n; k++)
    for (PetscInt copy = 0; copy < copies; copy++)
      c->pair[c->npairs++] = (MPMPair){.a = -1 - k, .b = copy, .axis = -1, .mu = core->rigids.body[k].mu};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prepares the distances from rigid bodies of one type: from shapes that others share too, last those of bodies that move,
   whose surfaces at the walls of the grid count. */
static PetscErrorCode MakeDistances(MPMScene *scene, const MPMCore *core, MPMOptions o, MPMRigidType type)
{
  PetscFunctionBeginUser;
  for (PetscInt k = scene->nbodies; k < scene->nbodies + scene->nshapes && !MPMOptionsError(o); k++) {
    MPMBody   *b = &scene->bodies[k];
    MPMRegion *r = &b->region;
    PetscReal  middle[3];

    if (b->rigid == MPM_RIGID_NONE || (b->rigid == MPM_RIGID_FIXED) != (type == MPM_RIGID_FIXED)) continue;
    if (r->type == MPM_REGION_file)
      MPMOptionsFail(o, "-body_%s_rigid does not apply: %s has particles from a file, but no shape", b->name, b->name);
    if (MPMOptionsError(o)) break;
    PetscCheck(MPMRegionMakeDistance(r, &core->grid, b->rigid == MPM_RIGID_FIXED), PETSC_COMM_SELF, PETSC_ERR_MEM,
               "no memory for the distance from %s", b->name);
    for (PetscInt d = 0; d < core->grid.dim; d++) middle[d] = 0.5 * (r->lower[d] + r->upper[d]);
    if (r->type == MPM_REGION_expression && r->nearest && !r->nearest->n &&
        !(r->formula(r->context, core->grid.dim, middle) > 0))
      MPMOptionsFail(o, "-body_%s_expression is not positive at any of the places half a cell apart at which it was "
                     "computed; a rigid body must be thicker", b->name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneMakeRigids(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  MPMRigids *r = &core->rigids;
  PetscInt   n = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = scene->nbodies; k < scene->nbodies + scene->nshapes; k++) n += scene->bodies[k].rigid != MPM_RIGID_NONE;
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MakeDistances(scene, core, o, MPM_RIGID_FIXED));
  PetscCall(MakeDistances(scene, core, o, MPM_RIGID_MOVING));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(n, &r->body));
  PetscCall(PetscCalloc1(n * MPM_RIGID_NUMBERS, &r->numbers));
  for (PetscInt k = scene->nbodies; k < scene->nbodies + scene->nshapes; k++) {
    const MPMBody *b = &scene->bodies[k];
    MPMRigid      *to = &r->body[r->n];

    if (b->rigid == MPM_RIGID_NONE) continue;
    MPMRigidUse(to, r->numbers + r->n * MPM_RIGID_NUMBERS);
    to->name  = b->name;
    to->shape = &b->region;
    to->mu    = b->mu;
    to->moves = b->rigid == MPM_RIGID_MOVING ? PETSC_TRUE : PETSC_FALSE;
    if (to->moves) r->move = PETSC_TRUE;
    for (PetscInt d = 0; d < 3; d++) {
      to->pivot[d]    = b->pivot[d];
      to->turn[4 * d] = 1;
    }
    r->n++;
    if (b->rigid == MPM_RIGID_FREE && !MPMOptionsError(o)) PetscCall(SetFree(b, core->grid.dim, o, to));
  }
  PetscCall(AddPairs(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneMoveRigids(const MPMScene *scene, MPMCore *core, PetscReal t)
{
  static const PetscReal nowhere[3] = {0};
  const PetscInt         dim = core->grid.dim;
  MPMRigid              *r = core->rigids.body;

  PetscFunctionBeginUser;
  for (PetscInt k = scene->nbodies; k < scene->nbodies + scene->nshapes && r; k++) {
    const MPMBody *b = &scene->bodies[k];

    if (b->rigid == MPM_RIGID_NONE) continue;
    if (b->rigid == MPM_RIGID_MOVING && b->velocity)
      PetscCall(MPMExpressionEvaluate(b->velocity, dim, nowhere, NULL, t, r->velocity));
    if (b->rigid == MPM_RIGID_MOVING && b->spin)
      PetscCall(MPMExpressionEvaluate(b->spin, dim, nowhere, NULL, t, dim == 3 ? r->spin : r->spin + 2));
    r++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
