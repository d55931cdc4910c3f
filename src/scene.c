/* scene.c - the scene: grid, materials, bodies and walls from the options, and the points that fill the bodies.

   Points lie on the lattice (i+1/2) b + offset, b = h/ppc, anchored at the origin of space, wherever the body's shape
   is; numbered body by body in the order of -bodies, with x in the outer loop: a rule that knows no processes.        */
#include "transfer.h"

static PetscErrorCode ReadGrid(MPM mpm, MPMOptions o)
{
  MPMGrid  *grid = &mpm->grid;
  PetscBool by_cells, by_h;
  PetscReal h[3] = {1, 1, 1}, nodes = 1;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) grid->h[d] = 1;
  PetscCall(MPMOptionsReals(o, "grid_lower", NULL, grid->lower, NULL));
  PetscCall(MPMOptionsReals(o, "grid_upper", NULL, grid->upper, NULL));
  PetscCall(MPMOptionsInts(o, "grid_cells", NULL, grid->cells, &by_cells));
  PetscCall(MPMOptionsReals(o, "grid_h", NULL, h, &by_h));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (by_cells == by_h) MPMOptionsFail(o, by_h ? "-grid_cells and -grid_h exclude each other" : "-grid_cells is required (number of cells), or -grid_h");
  for (PetscInt d = 0; d < grid->dim && !MPMOptionsError(o); d++) {
    const PetscReal length = grid->upper[d] - grid->lower[d];

    if (!(length > 0 && length < PETSC_MAX_REAL)) MPMOptionsFail(o, "-grid_upper must be above -grid_lower on every axis; axis %c has %g and %g", "xyz"[d], (double)grid->upper[d], (double)grid->lower[d]);
    if (by_h && !MPMOptionsError(o)) {
      const PetscReal n = PetscFloorReal(length / h[d] + 0.5);

      if (!(n >= 1 && n < 1e9) || PetscAbsReal(n * h[d] - length) > 1e-9 * length) MPMOptionsFail(o, "-grid_h %g does not divide the box: %c is %g cells long", (double)h[d], "xyz"[d], (double)(length / h[d]));
      else grid->cells[d] = (PetscInt)n;
    }
    if (MPMOptionsError(o)) break;
    grid->h[d] = length / grid->cells[d];
    nodes *= grid->cells[d] + 1.0;
    if (!(grid->lower[d] + grid->h[d] > grid->lower[d])) MPMOptionsFail(o, "-grid_cells: cells of %g m vanish beside the coordinate %g", (double)grid->h[d], (double)grid->lower[d]);
  }
  if (!MPMOptionsError(o) && nodes * MPM_SUM_NC(3) > (PetscReal)PETSC_MAX_INT) MPMOptionsFail(o, "-grid_cells asks for %g nodes, more than this PETSc can number", (double)nodes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses the options among `all` that the chosen model or shape, which takes `taken`, has no use for. */
static PetscErrorCode RefuseOthers(MPMOptions o, const char group[], const char name[], const char what[], const char choice[], const char all[], const char taken[])
{
  char words[MPM_TEXT_LEN], *save = NULL;

  PetscFunctionBeginUser;
  (void)snprintf(words, sizeof words, "%s", all);
  for (char *w = strtok_r(words, " ", &save); w; w = strtok_r(NULL, " ", &save)) {
    char      full[4 * MPM_NAME_LEN], padded[MPM_TEXT_LEN], word[MPM_NAME_LEN];
    PetscBool given;

    (void)snprintf(padded, sizeof padded, " %s ", taken);
    (void)snprintf(word, sizeof word, " %s ", w);
    if (strstr(padded, word)) continue;
    (void)snprintf(full, sizeof full, "-%s_%s_%s", group, name, w);
    PetscCall(PetscOptionsHasName(NULL, NULL, full, &given));
    if (given) MPMOptionsFail(o, "%s does not apply: %s %s takes %s", full, what, choice, taken);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadMaterial(MPMOptions o, MPMMaterial *m)
{
  char model[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "material_<m>_model", m->name, model, NULL));
  for (const MPMMaterialType *type = MPMMaterialTypes; type->name; type++)
    if (!strcmp(type->name, model)) m->type = type;
  PetscCall(MPMOptionsReal(o, "material_<m>_rho", m->name, &m->rho, NULL));
  if (!m->type) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(RefuseOthers(o, "material", m->name, "model", model, "E nu", m->type->parameters));
  if (strstr(m->type->parameters, "E")) PetscCall(MPMOptionsReal(o, "material_<m>_E", m->name, &m->E, NULL));
  if (strstr(m->type->parameters, "nu")) PetscCall(MPMOptionsReal(o, "material_<m>_nu", m->name, &m->nu, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  MPMMaterialSetUp(m);
  if (!((m->lambda + 2 * m->mu) / m->rho < PETSC_MAX_REAL)) MPMOptionsFail(o, "-material_%s_nu %.17g is so close to its limit that the wave speed is not finite", m->name, (double)m->nu);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The shape of a body. */
static PetscErrorCode ReadRegion(MPMOptions o, const char name[], MPMRegion *r)
{
  static const char *const takes[] = {
#define MPM_REGION(name, parameters, what) parameters,
#include "region.def"
#undef MPM_REGION
  };
  static const char *const names[] = {
#define MPM_REGION(name, parameters, what) #name,
#include "region.def"
#undef MPM_REGION
  };
  char shape[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "body_<b>_shape", name, shape, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < MPM_NUM_REGIONS; k++)
    if (!strcmp(names[k], shape)) r->type = (MPMRegionType)k;
  PetscCall(RefuseOthers(o, "body", name, "shape", shape, "center radius inner_radius lower upper", takes[r->type]));
  if (r->type == MPM_REGION_box) {
    PetscCall(MPMOptionsReals(o, "body_<b>_lower", name, r->lower, NULL));
    PetscCall(MPMOptionsReals(o, "body_<b>_upper", name, r->upper, NULL));
  } else {
    PetscCall(MPMOptionsReals(o, "body_<b>_center", name, r->center, NULL));
    PetscCall(MPMOptionsReal(o, "body_<b>_radius", name, &r->radius, NULL));
    if (r->type == MPM_REGION_annulus) PetscCall(MPMOptionsReal(o, "body_<b>_inner_radius", name, &r->inner_radius, NULL));
    if (!MPMOptionsError(o) && r->inner_radius >= r->radius) MPMOptionsFail(o, "-body_%s_inner_radius %g must be below -body_%s_radius %g", name, (double)r->inner_radius, name, (double)r->radius);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadVelocity(MPMOptions o, PetscInt dim, MPMBody *b)
{
  char      text[MPM_TEXT_LEN], error[MPM_TEXT_LEN];
  PetscInt  n;
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "body_<b>_velocity", b->name, text, &set));
  if (!set || MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMExpressionCreate(text, "xyz", &b->velocity, &n, error, sizeof error));
  if (error[0]) MPMOptionsFail(o, "-body_%s_velocity %s: %s", b->name, text, error);
  else if (n != dim) MPMOptionsFail(o, "-body_%s_velocity has %" PetscInt_FMT " component%s, -dim %" PetscInt_FMT " needs %" PetscInt_FMT, b->name, n, n == 1 ? "" : "s", dim, dim);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadBody(MPM mpm, MPMOptions o, MPMBody *b)
{
  MPMScene *scene = &mpm->scene;
  char      material[MPM_TEXT_LEN] = "";

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < mpm->grid.dim; d++) b->ppc[d] = 2;
  PetscCall(ReadRegion(o, b->name, &b->region));
  PetscCall(MPMOptionsString(o, "body_<b>_material", b->name, material, NULL));
  PetscCall(MPMOptionsInts(o, "body_<b>_ppc", b->name, b->ppc, NULL));
  PetscCall(MPMOptionsReals(o, "body_<b>_offset", b->name, b->offset, NULL));
  PetscCall(ReadVelocity(o, mpm->grid.dim, b));
  for (b->material = 0; b->material < scene->nmaterials && strcmp(scene->materials[b->material].name, material);) b->material++;
  if (b->material == scene->nmaterials) MPMOptionsFail(o, "-body_%s_material %s is not one of -materials", b->name, material);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadWalls(MPM mpm, MPMOptions o)
{
  static const char *const faces[3][2] = {{"xmin", "xmax"}, {"ymin", "ymax"}, {"zmin", "zmax"}};
  static const char *const names[]     = {
#define MPM_WALL(name, what) #name,
#include "wall.def"
#undef MPM_WALL
  };

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < mpm->grid.dim; d++)
    for (PetscInt side = 0; side < 2; side++) {
      char type[MPM_NAME_LEN] = "free";

      PetscCall(MPMOptionsEnum(o, "bc_<f>_type", faces[d][side], type, NULL));
      for (PetscInt k = 0; k < MPM_NUM_WALLS; k++)
        if (!strcmp(names[k], type)) mpm->scene.walls[d][side] = (MPMWall)k;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The name of the results: that of the last options file. */
static PetscErrorCode DefaultName(char name[MPM_NAME_LEN])
{
  int         argc;
  char      **argv;
  const char *file = "pebble", *slash, *dot;

  PetscFunctionBeginUser;
  PetscCall(PetscGetArgs(&argc, &argv));
  for (int k = 1; k + 1 < argc; k++)
    if (!strcmp(argv[k], "-options_file")) file = argv[k + 1];
  slash = strrchr(file, '/');
  if (slash) file = slash + 1;
  dot = strrchr(file, '.');
  (void)snprintf(name, MPM_NAME_LEN, "%.*s", (int)(dot && dot > file ? dot - file : (long)strlen(file)), file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Dimension and declared names first: with them every legal name is known. */
static PetscErrorCode ReadNames(MPM mpm, MPMOptions o)
{
  MPMScene *scene = &mpm->scene;
  char(*materials)[MPM_NAME_LEN], (*bodies)[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsDeclare(o, 3, 0, NULL, 0, NULL)); /* a misspelt -dim is better named than missed */
  PetscCall(MPMOptionsInt(o, "dim", NULL, &mpm->grid.dim, NULL));
  PetscCall(MPMOptionsNames(o, "materials", &scene->nmaterials, &materials));
  PetscCall(MPMOptionsNames(o, "bodies", &scene->nbodies, &bodies));
  PetscCall(PetscCalloc1(scene->nmaterials, &scene->materials));
  PetscCall(PetscCalloc1(scene->nbodies, &scene->bodies));
  for (PetscInt k = 0; k < scene->nmaterials; k++) PetscCall(PetscStrncpy(scene->materials[k].name, materials[k], MPM_NAME_LEN));
  for (PetscInt k = 0; k < scene->nbodies; k++) PetscCall(PetscStrncpy(scene->bodies[k].name, bodies[k], MPM_NAME_LEN));
  if (!MPMOptionsError(o)) PetscCall(MPMOptionsDeclare(o, mpm->grid.dim, scene->nmaterials, materials, scene->nbodies, bodies));
  PetscCall(PetscFree(materials));
  PetscCall(PetscFree(bodies));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads what is simulated. Faults are left in o. Collective on mpm->comm in that all processes read the same. */
PetscErrorCode MPMSceneSetFromOptions(MPM mpm, MPMOptions o)
{
  MPMScene *scene = &mpm->scene;
  char      geometry[MPM_NAME_LEN], name[MPM_TEXT_LEN];
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(ReadNames(mpm, o));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DefaultName(scene->name));
  PetscCall(PetscStrncpy(name, scene->name, sizeof name));
  PetscCall(MPMOptionsString(o, "output_name", NULL, name, NULL));
  if (strchr(name, '/') || strlen(name) >= MPM_NAME_LEN) MPMOptionsFail(o, "-output_name %s: a file name without a folder, at most %d characters (-output_dir names the folder)", name, MPM_NAME_LEN - 1);
  (void)snprintf(scene->name, sizeof scene->name, "%.*s", MPM_NAME_LEN - 1, name);
  PetscCall(PetscStrncpy(scene->title, scene->name, sizeof scene->title));
  PetscCall(MPMOptionsString(o, "scene_title", NULL, scene->title, NULL));
  PetscCall(MPMOptionsBool(o, "dry_run", NULL, &scene->dry_run));
  PetscCall(MPMOptionsEnum(o, "geometry", NULL, geometry, &set));
  if (set && !strcmp(geometry, "plane_strain") && mpm->grid.dim != 2) MPMOptionsFail(o, "-geometry plane_strain needs -dim 2, not %" PetscInt_FMT, mpm->grid.dim);
  PetscCall(MPMOptionsReals(o, "gravity", NULL, mpm->params.gravity, NULL));
  PetscCall(ReadGrid(mpm, o));
  for (PetscInt k = 0; k < scene->nmaterials; k++) PetscCall(ReadMaterial(o, &scene->materials[k]));
  for (PetscInt k = 0; k < scene->nbodies; k++) PetscCall(ReadBody(mpm, o, &scene->bodies[k]));
  for (PetscInt m = 0; m < scene->nmaterials; m++) {
    PetscBool used = PETSC_FALSE;

    for (PetscInt b = 0; b < scene->nbodies; b++)
      if (scene->bodies[b].material == m) used = PETSC_TRUE;
    if (!used) MPMOptionsFail(o, "-materials %s is of no body; remove it", scene->materials[m].name);
  }
  PetscCall(ReadWalls(mpm, o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Points --------------------------------------------------------------------------------------------------- */

/* The range of lattice numbers that covers the body, on one axis. */
static void LatticeRange(const MPMBody *b, PetscInt dim, PetscInt64 first[3], PetscInt64 last[3])
{
  PetscReal lower[3], upper[3];

  MPMRegionBounds(&b->region, dim, lower, upper);
  for (PetscInt d = 0; d < 3; d++) {
    first[d] = d < dim ? (PetscInt64)PetscFloorReal((lower[d] - b->offset[d]) / b->b[d] - 0.5) : 0;
    last[d]  = d < dim ? (PetscInt64)PetscCeilReal((upper[d] - b->offset[d]) / b->b[d] - 0.5) : 0;
  }
}

/* Walks the points of a body in the order of their numbers: the next one at or after lattice place ijk, whose position
   goes to x; ijk is left there. False when there are no more.                                                        */
static PetscBool NextPoint(const MPMBody *b, PetscInt dim, const PetscInt64 first[3], const PetscInt64 last[3], PetscInt64 ijk[3], PetscReal x[3])
{
  for (; ijk[0] <= last[0]; ijk[0]++, ijk[1] = first[1])
    for (; ijk[1] <= last[1]; ijk[1]++, ijk[2] = first[2])
      for (; ijk[2] <= last[2]; ijk[2]++) {
        for (PetscInt d = 0; d < dim; d++) x[d] = ((PetscReal)ijk[d] + 0.5) * b->b[d] + b->offset[d];
        if (MPMRegionInside(&b->region, dim, x)) return PETSC_TRUE;
      }
  return PETSC_FALSE;
}

static PetscErrorCode CheckPoint(MPM mpm, MPMOptions o, const MPMBody *b, const PetscReal x[])
{
  const PetscInt dim = mpm->grid.dim;
  PetscReal      v[3] = {0};

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++)
    if (!(x[d] >= mpm->grid.lower[d] && x[d] <= mpm->grid.upper[d]))
      MPMOptionsFail(o, "body %s lies outside of the grid: its point at %c = %g, the grid from %g to %g", b->name, "xyz"[d], (double)x[d], (double)mpm->grid.lower[d], (double)mpm->grid.upper[d]);
  if (b->velocity) PetscCall(MPMExpressionEvaluate(b->velocity, dim, x, 0, v));
  for (PetscInt d = 0; d < dim; d++)
    if (!(PetscAbsReal(v[d]) <= PETSC_MAX_REAL)) MPMOptionsFail(o, "-body_%s_velocity is not finite at x = %g%s", b->name, (double)x[0], dim > 1 ? ", ..." : "");
  for (PetscInt k = 0; k < mpm->scene.nbodies; k++)
    if (mpm->scene.bodies + k < b && MPMRegionInside(&mpm->scene.bodies[k].region, dim, x)) mpm->scene.overlap++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The kind of a body, shared with earlier bodies of the same material and point size. */
static void FindKind(MPMScene *scene, PetscInt dim, MPMBody *b)
{
  MPMKind kind = {b->material, 0, 1};

  for (PetscInt d = 0; d < dim; d++) kind.V0 *= b->b[d];
  kind.m = scene->materials[b->material].rho * kind.V0;
  for (b->kind = 0; b->kind < scene->nkinds; b->kind++)
    if (scene->kinds[b->kind].material == kind.material && scene->kinds[b->kind].V0 == kind.V0) return;
  scene->kinds[scene->nkinds++] = kind;
}

/* Lays out the points without making them: numbers them, checks that they lie in the grid and start with finite
   velocities, and finds the kinds. Faults are left in o. Not collective.                                             */
PetscErrorCode MPMSceneCountPoints(MPM mpm, MPMOptions o)
{
  MPMScene      *scene = &mpm->scene;
  const PetscInt dim   = mpm->grid.dim;
  PetscInt64     total = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(scene->nbodies, &scene->kinds));
  for (PetscInt k = 0; k < scene->nbodies && !MPMOptionsError(o); k++) {
    MPMBody   *b = &scene->bodies[k];
    PetscInt64 first[3], last[3], ijk[3];
    PetscReal  x[3], places = 1, lower[3], upper[3];

    MPMRegionBounds(&b->region, dim, lower, upper);
    for (PetscInt d = 0; d < dim; d++) {
      b->b[d] = mpm->grid.h[d] / b->ppc[d];
      places *= PetscMax(0, (PetscMin(upper[d], mpm->grid.upper[d]) - PetscMax(lower[d], mpm->grid.lower[d])) / b->b[d]) + 3;
      if (!(upper[d] <= mpm->grid.upper[d] + b->b[d] && lower[d] >= mpm->grid.lower[d] - b->b[d]))
        MPMOptionsFail(o, "body %s lies outside of the grid: it reaches from %c = %g to %g, the grid from %g to %g", b->name, "xyz"[d], (double)lower[d], (double)upper[d], (double)mpm->grid.lower[d], (double)mpm->grid.upper[d]);
    }
    if (places * (1 + 2 * dim + dim * dim) > (PetscReal)PETSC_MAX_INT) MPMOptionsFail(o, "body %s would have about %g points, more than this PETSc can number", b->name, (double)places);
    if (MPMOptionsError(o)) break;
    LatticeRange(b, dim, first, last);
    PetscCall(PetscArraycpy(ijk, first, 3));
    for (b->first = total; NextPoint(b, dim, first, last, ijk, x) && !MPMOptionsError(o); ijk[2]++, total++) PetscCall(CheckPoint(mpm, o, b, x));
    b->n = total - b->first;
    if (!b->n) MPMOptionsFail(o, "body %s has no points: no lattice point (i+1/2) h/ppc + offset lies in it", b->name);
    FindKind(scene, dim, b);
  }
  mpm->points.total = total;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Counts the points of the scene, as they will start, by the base node of their stencils. Not collective: every process
   counts all.                                                                                                        */
PetscErrorCode MPMSceneHistogram(MPM mpm, MPMHistogram *h)
{
  const PetscInt dim = mpm->grid.dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < mpm->scene.nbodies; k++) {
    const MPMBody *b = &mpm->scene.bodies[k];
    PetscInt64     first[3], last[3], ijk[3];
    PetscReal      x[3], xi[3];
    PetscInt       base[3] = {0};

    LatticeRange(b, dim, first, last);
    PetscCall(PetscArraycpy(ijk, first, 3));
    for (; NextPoint(b, dim, first, last, ijk, x); ijk[2]++) {
      (void)MPMLocate((int)dim, mpm->basis, &mpm->grid, x, xi, base);
      for (PetscInt d = 0; d < dim; d++) base[d] += mpm->grid.layers;
      MPMHistogramAdd(h, base);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetPoint(MPM mpm, const MPMBody *b, PetscInt64 id, const PetscReal x[], PetscInt p, MPMView *view)
{
  const PetscInt dim  = mpm->grid.dim;
  PetscReal      v[3] = {0};

  PetscFunctionBeginUser;
  if (b->velocity) PetscCall(MPMExpressionEvaluate(b->velocity, dim, x, 0, v));
  view->id[p] = id;
  if (view->kind) view->kind[p] = b->kind;
  for (PetscInt d = 0; d < dim; d++) {
    view->x[p * dim + d] = x[d];
    view->v[p * dim + d] = v[d];
    for (PetscInt e = 0; e < dim; e++) view->F[(p * dim + d) * dim + e] = d == e;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the points of this process's patch, undeformed (F = I), with their start velocities. Not collective. */
PetscErrorCode MPMSceneAddPoints(MPM mpm)
{
  MPMScene       *scene  = &mpm->scene;
  const MPMPatch *patch  = &mpm->exchange.patch;
  const PetscInt  dim    = mpm->grid.dim;
  const PetscInt  fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(v) | MPM_BIT(F) | MPM_BIT(kind);
  MPMView         view;

  PetscFunctionBeginUser;
  for (int pass = 0; pass < 2; pass++) { /* count, then make */
    PetscInt64 id = 0;
    PetscInt   p  = 0;

    if (pass) PetscCall(MPMPointsGetView(&mpm->points, fields, &view));
    for (PetscInt k = 0; k < scene->nbodies; k++) {
      const MPMBody *b = &scene->bodies[k];
      PetscInt64     first[3], last[3], ijk[3];
      PetscReal      x[3];
      PetscInt       base[3] = {0};

      LatticeRange(b, dim, first, last);
      PetscCall(PetscArraycpy(ijk, first, 3));
      for (; NextPoint(b, dim, first, last, ijk, x); ijk[2]++, id++) {
        if (MPMOwnCell((int)dim, mpm->basis, patch, x, base) < 0) continue;
        if (pass) PetscCall(SetPoint(mpm, b, id, x, p, &view));
        p++;
      }
    }
    if (!pass) PetscCall(MPMPointsSetSize(&mpm->points, p));
  }
  PetscCall(MPMPointsRestoreView(&mpm->points, fields, &view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneDestroy(MPMScene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nbodies; k++) PetscCall(MPMExpressionDestroy(&scene->bodies[k].velocity));
  PetscCall(PetscFree(scene->materials));
  PetscCall(PetscFree(scene->bodies));
  PetscCall(PetscFree(scene->kinds));
  PetscFunctionReturn(PETSC_SUCCESS);
}
