/* read_region.c - reads the shapes of bodies, and which bodies cut others, before the first step. */
#include <strings.h>
#include "physics/distance.h"
#include "scene/lattice.h"
#include "scene/shapes.h"

/* Reads a vector and divides it by its length. */
static PetscErrorCode ReadDirection(MPMOptions o, PetscInt dim, const char row[], const char name[], const char word[],
                                    PetscReal value[3])
{
  PetscReal most = 0, length = 0;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReals(o, row, name, value, NULL));
  for (PetscInt d = 0; d < dim; d++) most = PetscMax(most, PetscAbsReal(value[d]));
  if (!(most > 0)) MPMOptionsFail(o, "-body_%s_%s is 0, which is no direction", name, word);
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt d = 0; d < dim; d++) length += (value[d] / most) * (value[d] / most);
  for (PetscInt d = 0; d < dim; d++) value[d] = value[d] / most / PetscSqrtReal(length);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads lower and upper: of a box, which needs them, or limits of another shape, which keeps the numbers that are there
   where they are missing. */
static PetscErrorCode ReadBox(MPMOptions o, PetscInt dim, const char name[], MPMRegion *r)
{
  const PetscBool box = r->type == MPM_REGION_box;
  PetscBool       lower, upper;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReals(o, "body_<b>_lower", name, r->lower, &lower));
  PetscCall(MPMOptionsReals(o, "body_<b>_upper", name, r->upper, &upper));
  if (box && !lower) MPMOptionsFail(o, "-body_%s_lower is required (lower corner of a box)", name);
  if (box && !upper) MPMOptionsFail(o, "-body_%s_upper is required (upper corner of a box)", name);
  for (PetscInt d = 0; d < dim && !MPMOptionsError(o); d++)
    if (!(r->upper[d] > r->lower[d]))
      MPMOptionsFail(o, "-body_%s_upper must be above -body_%s_lower on every axis; axis %c has %g and %g", name, name,
                     "xyz"[d], (double)r -> upper[d], (double)r -> lower[d]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The value of a formula at x [dim], m; errors were found when it was read. */
static PetscReal Formula(void *context, PetscInt dim, const PetscReal x[])
{
  PetscReal value[3] = {0};

  return MPMExpressionEvaluate((MPMExpression)context, dim, x, NULL, 0, value) ? 0 : value[0];
}

static PetscErrorCode ReadExpression(MPMOptions o, const char name[], MPMRegion *r)
{
  MPMExpression e = NULL;
  char          text[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "body_<b>_expression", name, text, NULL)); /* it is required */
  PetscCall(MPMOptionsExpression(o, "body_<b>_expression", name, "xyz", 1, &e));
  r->formula = Formula;
  r->context = e;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneReadRegion(MPMCore *core, MPMOptions o, const char name[], MPMRegion *r)
{
  const PetscInt dim                 = core->grid.dim;
  char           shape[MPM_NAME_LEN] = "", all[MPM_TEXT_LEN] = "";
  const char    *taken;
  PetscInt       row;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "body_<b>_shape", name, shape, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsFind(shape, MPM_NUM_REGIONS, MPMRegionNames, &row));
  r->type = (MPMRegionType)row;
  taken   = MPMRegionParameters[row];
  for (PetscInt k = 0; k < MPM_NUM_REGIONS; k++) MPMAppend(all, sizeof all, "%s ", MPMRegionParameters[k]);
  PetscCall(MPMOptionsRefuseOthers(o, "body", name, "shape", shape, all, taken));
  if (r->type == MPM_REGION_cylinder && dim < 3)
    MPMOptionsFail(o, "-body_%s_shape cylinder needs -dim 3: %s", name,
                   dim == 2 ? "in 2-D a disk is a sphere, and its side view a box" : "in 1-D a body is a box");
  if (r->type == MPM_REGION_polygon && dim < 2)
    MPMOptionsFail(o, "-body_%s_shape polygon needs -dim 2 or 3: in 1-D a body is a box", name);
  if (r->type == MPM_REGION_stl && dim < 3)
    MPMOptionsFail(o, "-body_%s_shape stl needs -dim 3: choose polygon in 2-D, box in 1-D", name);
  for (PetscInt d = 0; d < dim; d++) { /* a polygon has bounds of its own on the first axes */
    const PetscBool own = r->type == MPM_REGION_polygon && d < 2;

    r->lower[d] = own ? PETSC_MIN_REAL : core->grid.lower[d];
    r->upper[d] = own ? PETSC_MAX_REAL : core->grid.upper[d];
  }
  if (MPMListHas(taken, "lower")) PetscCall(ReadBox(o, dim, name, r));
  if (MPMListHas(taken, "center")) PetscCall(MPMOptionsReals(o, "body_<b>_center", name, r->center, NULL));
  if (MPMListHas(taken, "point")) PetscCall(MPMOptionsReals(o, "body_<b>_point", name, r->center, NULL));
  if (MPMListHas(taken, "radius")) PetscCall(MPMOptionsReal(o, "body_<b>_radius", name, &r->radius, NULL));
  if (MPMListHas(taken, "inner_radius"))
    PetscCall(MPMOptionsReal(o, "body_<b>_inner_radius", name, &r->inner_radius, NULL));
  if (MPMListHas(taken, "length")) PetscCall(MPMOptionsReal(o, "body_<b>_length", name, &r->length, NULL));
  if (r->type == MPM_REGION_annulus && !MPMOptionsError(o) && r->inner_radius >= r->radius)
    MPMOptionsFail(o, "-body_%s_inner_radius %g must be below -body_%s_radius %g", name, (double)r->inner_radius, name,
                   (double)r->radius);
  r->axis[2] = 1;
  if (MPMListHas(taken, "axis")) PetscCall(ReadDirection(o, dim, "body_<b>_axis", name, "axis", r->axis));
  if (MPMListHas(taken, "normal")) PetscCall(ReadDirection(o, dim, "body_<b>_normal", name, "normal", r->axis));
  if (r->type == MPM_REGION_expression) PetscCall(ReadExpression(o, name, r));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (r->type == MPM_REGION_polygon) PetscCall(MPMSceneReadPolygon(core, o, name, r));
  if (r->type == MPM_REGION_stl) PetscCall(MPMSceneReadSTL(core, o, name, r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneDestroyRegion(MPMRegion *r)
{
  MPMExpression e = (MPMExpression)r->context;

  PetscFunctionBeginUser;
  PetscCall(MPMExpressionDestroy(&e));
  r->context = NULL;
  MPMSurfaceDestroy(&r->surface);
  MPMRegionDropDistance(r);
  PetscCall(PetscFree(r->others));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Bodies that cut others --------------------------------------------------------------------------------------- */

/* Reads a list of bodies that shape body b, and appends their shapes. */
static PetscErrorCode ReadList(MPMScene *scene, MPMOptions o, PetscInt b, const char word[], PetscInt *n,
                               PetscBool used[])
{
  const PetscInt all = scene->nbodies + scene->nshapes;
  MPMRegion     *r   = &scene->bodies[b].region;
  char           row[MPM_NAME_LEN], text[MPM_TEXT_LEN], *save = NULL;
  PetscBool      set;

  PetscFunctionBeginUser;
  (void)snprintf(row, sizeof row, "body_<b>_%s", word);
  PetscCall(MPMOptionsString(o, row, scene->bodies[b].name, text, &set));
  if (!set) PetscFunctionReturn(PETSC_SUCCESS);
  for (char *w = strtok_r(text, ", ", &save); w && !MPMOptionsError(o); w = strtok_r(NULL, ", ", &save)) {
    PetscInt k = 0;

    while (k < all && strcasecmp(scene->bodies[k].name, w)) k++;
    if (k == all) MPMOptionsFail(o, "-body_%s_%s %.100s: there is no such body", scene->bodies[b].name, word, w);
    for (PetscInt q = 0; q < 2 && k < all; q++)
      if (scene->bodies[q ? k : b].region.type == MPM_REGION_file)
        MPMOptionsFail(o, "-body_%s_%s %s does not apply: %s has particles from a file, but no shape",
                       scene->bodies[b].name, word, w, scene->bodies[q ? k : b].name);
    if (k == b)
      MPMOptionsFail(o, "-body_%s_%s %s: a body cannot %s", scene->bodies[b].name, word, w,
                     strcmp(word, "cut") ? "lie within itself" : "cut itself");
    if (MPMOptionsError(o)) break;
    for (PetscInt j = 0; j < r->ncut + r->nwithin; j++)
      if (r->others[j] == &scene->bodies[k].region)
        MPMOptionsFail(o, "-body_%s_%s names %s, which -body_%s_cut or -body_%s_within has named before",
                       scene->bodies[b].name, word, w, scene->bodies[b].name, scene->bodies[b].name);
    if (!r->others) PetscCall(PetscCalloc1(all, &r->others)); /* each body once at most */
    r->others[r->ncut + r->nwithin] = &scene->bodies[k].region;
    ++*n;
    used[k] = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the shape of `of` depends on that of r, through at most `depth` bodies. */
static PetscBool DependsOn(const MPMRegion *of, const MPMRegion *r, PetscInt depth)
{
  for (PetscInt k = 0; k < of->ncut + of->nwithin && depth > 0; k++)
    if (of->others[k] == r || DependsOn(of->others[k], r, depth - 1)) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MPMSceneReadOthers(MPMScene *scene, MPMOptions o)
{
  const PetscInt all = scene->nbodies + scene->nshapes;
  PetscBool     *used;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(all, &used));
  for (PetscInt b = 0; b < all && !MPMOptionsError(o); b++) {
    MPMRegion *r = &scene->bodies[b].region;

    PetscCall(ReadList(scene, o, b, "cut", &r->ncut, used));
    PetscCall(ReadList(scene, o, b, "within", &r->nwithin, used));
  }
  for (PetscInt b = 0; b < all && !MPMOptionsError(o); b++)
    if (DependsOn(&scene->bodies[b].region, &scene->bodies[b].region, all))
      MPMOptionsFail(o, "-body_%s_%s: the shape of %s would depend on itself, through the bodies that it names",
                     scene->bodies[b].name, scene->bodies[b].region.ncut ? "cut" : "within", scene->bodies[b].name);
  for (PetscInt b = scene->nbodies; b < all && !MPMOptionsError(o); b++)
    if (!used[b] && scene->bodies[b].rigid == MPM_RIGID_NONE)
      MPMOptionsFail(o, "-body_%s_material none: no -body_<b>_cut and no -body_<b>_within names %s; remove it",
                     scene->bodies[b].name, scene->bodies[b].name);
  PetscCall(PetscFree(used));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Described in scene.h. What a cut removes lies within it too, so a body whose shape is that of the body within the cut
   has no particles if the cut removes none. */
PetscErrorCode MPMSceneCutsNothing(const MPMBody *b, PetscInt dim, PetscInt cut, PetscBool *nothing)
{
  const MPMRegion *r    = &b->region;
  MPMBody          both = *b;
  MPMLattice       w;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(r->nwithin + 1, &both.region.others));
  for (PetscInt k = 0; k < r->nwithin; k++) both.region.others[k] = r->others[r->ncut + k];
  both.region.others[r->nwithin] = r->others[cut];
  both.region.ncut               = 0;
  both.region.nwithin            = r->nwithin + 1;
  w                              = MPMLatticeBegin(&both, dim);
  *nothing                       = !MPMLatticeNext(&w);
  PetscCall(PetscFree(both.region.others));
  PetscFunctionReturn(PETSC_SUCCESS);
}
