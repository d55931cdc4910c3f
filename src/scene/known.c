/* known.c - a scene whose solution is known: its start, its body force, which each step reads, and the error of a run
   at its end. The solutions are rows of reference.def, or expressions of the user. */
#include "base/exact_sum.h"
#include "scene/scene.h"

struct _MPMKnown {
  const MPMReference *row; /* or NULL: expressions */
  MPMReferenceData    data;
  MPMExpression       displacement; /* u(X, t) in m, for an error; or NULL */
};

/* Sets what the rows of reference.def read of the scene. */
static void Describe(const MPMScene *scene, const MPMCore *core, MPMReferenceData *data)
{
  const MPMBody     *body = &scene->bodies[0];
  const MPMMaterial *m    = &scene->materials[body->material];
  const PetscInt     dim  = core->grid.dim;

  data->dim = dim;
  for (PetscInt d = 0; d < dim; d++) {
    data->grid_lower[d] = core->grid.lower[d];
    data->grid_upper[d] = core->grid.upper[d];
    data->gravity[d]    = core->params.gravity[d];
    data->center[d]     = body->region.center[d];
    for (PetscInt side = 0; side < 2; side++) data->walls[d][side] = scene->walls.given[d][side].type;
  }
  MPMRegionBounds(&body->region, dim, data->lower, data->upper);
  data->shape        = body->region.type;
  data->inner_radius = body->region.inner_radius;
  data->radius       = body->region.radius;
  data->model        = m->type->name;
  data->rho          = m->rho;
  data->E            = m->E;
  data->nu           = m->nu;
  data->lambda       = m->lambda;
  data->mu           = m->mu;
  data->c            = PetscSqrtReal(m->E / m->rho);
  data->cp           = PetscSqrtReal((m->lambda + 2 * m->mu) / m->rho);
}

/* Reads the parameters that the row has, of -mms_* or -reference_*. */
static PetscErrorCode ReadParameters(MPMOptions o, const MPMReference *row, PetscBool mms, MPMReferenceData *data)
{
  PetscFunctionBeginUser;
  data->mode   = 1;
  data->period = 1;
  if (MPMListHas(row->parameters, "amplitude"))
    PetscCall(MPMOptionsReal(o, mms ? "mms_amplitude" : "reference_amplitude", NULL, &data->amplitude, NULL));
  if (MPMListHas(row->parameters, "mode")) PetscCall(MPMOptionsInt(o, "reference_mode", NULL, &data->mode, NULL));
  if (MPMListHas(row->parameters, "period")) PetscCall(MPMOptionsReal(o, "mms_period", NULL, &data->period, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a row that does not fit the scene. */
static void CheckRow(const MPMScene *scene, MPMOptions o, const MPMKnown *known, const char option[])
{
  const char *wrong = known->row->check(&known->data);

  if (scene->nbodies != 1)
    MPMOptionsFail(o, "-%s %s needs one body, not %" PetscInt_FMT, option, known->row->name, scene->nbodies);
  if (wrong) MPMOptionsFail(o, "-%s %s %s", option, known->row->name, wrong);
  if (scene->bodies[0].region.others)
    MPMOptionsFail(o, "-body_%s_%s does not apply: -%s %s needs the whole shape", scene->bodies[0].name,
                   scene->bodies[0].region.ncut ? "cut" : "within", option, known->row->name);
  if (scene->bodies[0].velocity)
    MPMOptionsFail(o, "-body_%s_velocity does not apply: -%s %s sets the start", scene->bodies[0].name, option,
                   known->row->name);
  if (scene->acceleration || scene->nloads)
    MPMOptionsFail(o, "-%s does not apply: -%s %s has its own forces", scene->acceleration ? "acceleration" : "loads",
                   option, known->row->name);
}

/* Reads -mms_* and -reference_*. The first fault is left in o. Not collective. */
PetscErrorCode MPMKnownSetFromOptions(MPMScene *scene, const MPMCore *core, MPMOptions o)
{
  char      mms[MPM_NAME_LEN] = "", reference[MPM_NAME_LEN] = "";
  PetscBool by_mms;
  MPMKnown *known;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "mms_type", NULL, mms, NULL));
  PetscCall(MPMOptionsEnum(o, "reference_type", NULL, reference, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  by_mms = strcmp(mms, "none") ? PETSC_TRUE : PETSC_FALSE;
  if (by_mms && strcmp(reference, "none"))
    MPMOptionsFail(o, "-reference_type %s does not apply: -mms_type %s is the exact solution", reference, mms);
  if ((!by_mms && !strcmp(reference, "none")) || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&known));
  scene->known       = known;
  scene->keeps_start = PETSC_TRUE;
  Describe(scene, core, &known->data);
  known->row = MPMReferenceFind(by_mms ? mms : reference);
  if (!known->row) {
    PetscCall(MPMOptionsExpression(o, "reference_displacement", NULL, "XYZt", core->grid.dim, &known->displacement));
    if (!known->displacement)
      MPMOptionsFail(o, "-reference_displacement is required (u of X, Y, Z, t; -reference_type expression)");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(ReadParameters(o, known->row, by_mms, &known->data));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  CheckRow(scene, o, known, by_mms ? "mms_type" : "reference_type");
  if (known->row->acceleration && known->row->manufactured) scene->forced = scene->body_force = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the known solution, if there is one. */
PetscErrorCode MPMKnownDestroy(MPMScene *scene)
{
  PetscFunctionBeginUser;
  if (scene->known) PetscCall(MPMExpressionDestroy(&scene->known->displacement));
  PetscCall(PetscFree(scene->known));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the scene starts as a known solution does. */
PetscBool MPMKnownStarts(const MPMScene *scene)
{
  return scene->known && scene->known->row;
}

/* Sets the position x [dim], m, where a particle with lattice place X [dim], m, starts, and its velocity v [dim], m/s,
   and deformation gradient F [dim*dim], unless these are NULL. If the scene does not start as a known solution does,
   it sets nothing and returns false. */
PetscBool MPMKnownStart(const MPMScene *scene, PetscInt dim, const PetscReal X[], PetscReal x[], PetscReal v[],
                        PetscReal F[])
{
  const MPMKnown *known = scene->known;
  PetscReal       u[3];

  if (!MPMKnownStarts(scene)) return PETSC_FALSE;
  known->row->displacement(&known->data, X, 0, u);
  for (PetscInt d = 0; d < dim; d++) x[d] = X[d] + u[d];
  if (v) known->row->velocity(&known->data, X, 0, v);
  if (F) known->row->deformation(&known->data, X, 0, F);
  return PETSC_TRUE;
}

/* Adds the body force of a manufactured solution to b [dim], m/s^2; X [dim], m: lattice place of the particle. */
void MPMKnownForce(const MPMScene *scene, PetscInt dim, const PetscReal X[], PetscReal t, PetscReal b[])
{
  const MPMKnown *known = scene->known;
  PetscReal       more[3];

  if (!known || !known->row || !known->row->manufactured || !known->row->acceleration) return;
  known->row->acceleration(&known->data, X, t, more);
  for (PetscInt d = 0; d < dim; d++) b[d] += more[d];
}

/* Sets *error to the error of the present state, the root of the mass-weighted mean of |u - u_exact|^2 in m, and *size
   to the same of u_exact. The sums are exact, so they are the same on any number of processes. Collective on the
   exchange. */
PetscErrorCode MPMKnownError(const MPMScene *scene, MPMCore *core, PetscReal *error, PetscReal *size)
{
  const MPMKnown *known = scene->known;
  const PetscInt  dim = core->grid.dim, fields = MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(kind);
  MPMSum          sum[3]; /* m |u - u_exact|^2, m |u_exact|^2, m */
  MPMView         view;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 3; k++) MPMSumZero(&sum[k]);
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const PetscReal *X = view.X + p * dim, m = MPMKindOf(scene->kinds, &view, p)->m;
    PetscReal        u[3], e2 = 0, u2 = 0;

    if (known->row)
      known->row->displacement(&known->data, X, core->t, u);
    else
      PetscCall(MPMExpressionEvaluate(known->displacement, dim, X, X, core->t, u));
    for (PetscInt d = 0; d < dim; d++) {
      PetscReal       got    = view.x[p * dim + d] - X[d] - u[d];
      const PetscReal length = core->grid.upper[d] - core->grid.lower[d];

      if (core->grid.periodic[d]) got -= length * PetscFloorReal(got / length + 0.5);
      e2 += got * got;
      u2 += u[d] * u[d];
    }
    MPMSumAdd(&sum[0], m * e2);
    MPMSumAdd(&sum[1], m * u2);
    MPMSumAdd(&sum[2], m);
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(MPMSumReduce(sum, 3, core->exchange.data));
  *error = PetscSqrtReal(MPMSumValue(&sum[0]) / MPMSumValue(&sum[2]));
  *size  = PetscSqrtReal(MPMSumValue(&sum[1]) / MPMSumValue(&sum[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
