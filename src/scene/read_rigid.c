/* read_rigid.c - rigid bodies of the scene: read at the start, and moved in each step by the formulas of their velocity
   and spin. All processes compute the same numbers. */
#include "scene/scene.h"

PetscErrorCode MPMSceneReadRigid(const MPMCore *core, MPMOptions o, MPMBody *b)
{
  const PetscInt dim = core->grid.dim;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReal(o, "body_<b>_mu", b->name, &b->mu, NULL));
  if (b->rigid != MPM_RIGID_MOVING) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsExpression(o, "body_<b>_velocity", b->name, "t", dim, &b->velocity));
  if (dim > 1) {
    PetscCall(MPMOptionsExpression(o, "body_<b>_spin", b->name, "t", dim == 3 ? 3 : 1, &b->spin));
    PetscCall(MPMOptionsReals(o, "body_<b>_pivot", b->name, b->pivot, NULL));
  }
  if (!MPMOptionsError(o) && !b->velocity && !b->spin)
    MPMOptionsFail(o, "-body_%s_rigid moving needs -body_%s_velocity or -body_%s_spin; a body at rest is fixed", b->name,
                   b->name, b->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneDestroyRigids(MPMCore *core)
{
  PetscFunctionBeginUser;
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
    for (PetscInt d = 0; d < 3; d++) {
      to->pivot[d]    = b->pivot[d];
      to->turn[4 * d] = 1;
    }
    r->n++;
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
