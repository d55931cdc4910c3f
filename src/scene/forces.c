/* forces.c - body forces and loads: the acceleration b [dim], m/s^2, of every particle besides gravity, eq. (13) of
   docs/theory.md. At the beginning of each step it is evaluated from expressions of position and time.

   A load acts on the particles at the surface of a body: those whose neighbour on the lattice was not in the body at
   the start. Such a side has the area A and the normal N of that side of the box around the particle. Under a
   pressure p the force is -p J F^-T N A (Nanson's formula for the deformed surface), under a traction T it is T A. */
#include "scene/scene.h"

static PetscErrorCode ReadLoad(const MPMScene *scene, const MPMCore *core, MPMOptions o, MPMLoad *load)
{
  const PetscInt dim                = core->grid.dim;
  char           face[MPM_NAME_LEN] = "", type[MPM_NAME_LEN] = "", sides[MPM_TEXT_LEN / 2] = "all";

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsDeclared(o, "load_<l>_body", load->name, scene->nbodies, scene->bodies->name,
                               sizeof *scene->bodies, &load->body));
  if (!MPMOptionsError(o) && scene->bodies[load->body].points)
    MPMOptionsFail(o, "-load_%s_body %s does not apply: particles from a file have no known surface; use -acceleration",
                   load->name, scene->bodies[load->body].name);
  PetscCall(MPMOptionsEnum(o, "load_<l>_face", load->name, face, NULL));
  PetscCall(MPMOptionsEnum(o, "load_<l>_type", load->name, type, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  load->pressure = !strcmp(type, "pressure") ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(MPMOptionsExpression(o, "load_<l>_value", load->name, "xyzXYZt", load->pressure ? 1 : dim, &load->value));
  for (PetscInt k = 0; k < 2 * dim; k++) {
    if (!strcmp(face, "all") || !strcmp(face, MPMFaceNames[k])) load->sides |= (PetscInt)1 << k;
    (void)snprintf(sides + strlen(sides), sizeof sides - strlen(sides), "|%s", MPMFaceNames[k]);
  }
  if (!load->sides)
    MPMOptionsFail(o, "-load_%s_face %s: -dim %" PetscInt_FMT " has the sides %s", load->name, face, dim, sides);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -acceleration and -loads. The first fault is left in o. */
PetscErrorCode MPMForcesSetFromOptions(MPMScene *scene, const MPMCore *core, MPMOptions o)
{

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsExpression(o, "acceleration", NULL, "xyzXYZt", core->grid.dim, &scene->acceleration));
  for (PetscInt k = 0; k < scene->nloads; k++) PetscCall(ReadLoad(scene, core, o, &scene->loads[k]));
  scene->body_force  = scene->acceleration ? PETSC_TRUE : PETSC_FALSE;
  scene->forced      = scene->acceleration || scene->nloads ? PETSC_TRUE : PETSC_FALSE;
  scene->keeps_start = scene->forced;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the loads and the expressions of forces. */
PetscErrorCode MPMForcesDestroy(MPMScene *scene)
{
  PetscFunctionBeginUser;
  PetscCall(MPMExpressionDestroy(&scene->acceleration));
  for (PetscInt k = 0; k < scene->nloads; k++) PetscCall(MPMExpressionDestroy(&scene->loads[k].value));
  PetscCall(PetscFree(scene->loads));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to b [dim], m/s^2, what a load gives particle p at time t, if it acts on it. */
static PetscErrorCode AddLoad(const MPMScene *scene, const MPMCore *core, const MPMLoad *load, const MPMView *view,
                              PetscInt p, PetscReal t, PetscReal b[])
{
  const PetscInt     dim = core->grid.dim, sides = view->surface[p] & load->sides;
  const MPMBody     *body = &scene->bodies[load->body];
  const MPMKind     *kind = &scene->kinds[body->kind];
  const MPMMaterial *m    = &scene->materials[body->material];
  PetscReal          value[3], A[3] = {0}, size = 0;

  PetscFunctionBeginUser;
  if (!sides || view->id[p] < body->first || view->id[p] >= body->first + body->n) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2 * dim; k++) {
    PetscReal area = 1;

    if (!(sides & (PetscInt)1 << k)) continue;
    for (PetscInt d = 0; d < dim; d++) area *= d == k / 2 ? 1 : body->b[d];
    A[k / 2] += k % 2 ? area : -area;
  }
  PetscCall(MPMExpressionEvaluate(load->value, dim, view->x + p * dim, view->X + p * dim, t, value));
  for (PetscInt d = 0; d < dim; d++) size += A[d] * A[d];
  size = PetscSqrtReal(size);
  if (load->pressure) {
    PetscReal cofactor[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}; /* J F^-T; a material without F has J^(1/dim) I */

    if (m->state & MPM_BIT(F))
      MPMCofactor((int)dim, view->F + p * dim * dim, cofactor);
    else
      for (PetscInt d = 0; d < dim; d++) cofactor[d * (dim + 1)] = PetscPowReal(view->J[p], 1 - 1 / (PetscReal)dim);
    for (PetscInt d = 0; d < dim; d++)
      for (PetscInt e = 0; e < dim; e++) b[d] -= value[0] * cofactor[d * dim + e] * A[e] / kind->m;
  } else
    for (PetscInt d = 0; d < dim; d++) b[d] += value[d] * size / kind->m;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds to *size, N, the sizes of the forces of a load on the particles of a view at time t, s. Not collective. */
PetscErrorCode MPMForcesSize(const MPMScene *scene, const MPMCore *core, const MPMLoad *load, const MPMView *view,
                             PetscReal t, PetscReal *size)
{
  const PetscReal m = scene->kinds[scene->bodies[load->body].kind].m;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < view->n; p++) {
    PetscReal b[3] = {0};

    PetscCall(AddLoad(scene, core, load, view, p, t, b));
    *size += m * PetscSqrtReal(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that the body force and the loads are finite at time 0 for a particle at x [dim] whose lattice place is X
   [dim], both in m; if one is not, its option is named in o. Not collective. */
PetscErrorCode MPMForcesCheck(const MPMScene *scene, const MPMCore *core, MPMOptions o, const PetscReal x[],
                              const PetscReal X[])
{

  PetscFunctionBeginUser;
  for (PetscInt k = -1; k < scene->nloads; k++) {
    const MPMExpression e        = k < 0 ? scene->acceleration : scene->loads[k].value;
    PetscReal           value[3] = {0};

    if (!e) continue;
    PetscCall(MPMExpressionEvaluate(e, core->grid.dim, x, X, 0, value));
    for (PetscInt d = 0; d < (k >= 0 && scene->loads[k].pressure ? 1 : core->grid.dim); d++)
      if (!(PetscAbsReal(value[d]) <= PETSC_MAX_REAL))
        MPMOptionsFail(o, "-%s%s%s is not finite at x = %g%s at the start", k < 0 ? "acceleration" : "load_",
                       k < 0 ? "" : scene->loads[k].name, k < 0 ? "" : "_value", (double)x[0],
                       core->grid.dim > 1 ? ", ..." : "");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets field b of the particles here, m/s^2, for the time t, s. Not collective. */
PetscErrorCode MPMForcesUpdate(const MPMScene *scene, MPMCore *core, PetscReal t)
{
  const PetscInt dim    = core->grid.dim;
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(F) | MPM_BIT(J) | MPM_BIT(surface) |
                          MPM_BIT(b);
  MPMView view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal b[3] = {0};

    if (scene->acceleration)
      PetscCall(MPMExpressionEvaluate(scene->acceleration, dim, view.x + p * dim, view.X + p * dim, t, b));
    MPMKnownForce(scene, dim, view.X + p * dim, t, b);
    for (PetscInt k = 0; k < scene->nloads; k++) PetscCall(AddLoad(scene, core, &scene->loads[k], &view, p, t, b));
    for (PetscInt d = 0; d < dim; d++) view.b[p * dim + d] = b[d];
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}
