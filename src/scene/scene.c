/* scene.c - reads the scene from the options: dimension, names, grid, materials and bodies; read_region.c,
   read_walls.c, forces.c and known.c read the rest, and fill.c makes the particles. It is used once, before the first
   step. */
#include <strings.h>
#include "base/checksum.h"
#include "physics/sizes.h"
#include "scene/source.h"
#include "scene/cut.h"
#include "scene/points.h"
#include "scene/shapes.h"

/* Refuses a cell size that does not divide axis d, with a size that divides all axes, and with a box that it divides. */
static void NotDividing(const MPMGrid *grid, MPMOptions o, PetscInt d, const PetscReal h[3])
{
  PetscReal most = h[0];
  char      sizes[MPM_NAME_LEN], upper[MPM_NAME_LEN] = "";

  for (PetscInt k = 1; k < grid->dim; k++) most = PetscMin(most, h[k]);
  MPMGridSizes(grid, most, sizes, sizeof sizes);
  for (PetscInt k = 0; k < grid->dim; k++)
    (void)snprintf(
        upper + strlen(upper), sizeof upper - strlen(upper), "%s%.10g", k ? "," : "",
        (double)(grid->lower[k] + h[k] * PetscCeilReal((grid->upper[k] - grid->lower[k]) / h[k] * (1 - 1e-9))));
  MPMOptionsFail(o, "-grid_h %g does not divide the box: axis %c is %g cells long; choose -grid_h %s or -grid_upper %s",
                 (double)h[d], "xyz"[d], (double)((grid->upper[d] - grid->lower[d]) / h[d]), sizes, upper);
}

/* Sets the cells and the cell size of one axis from -grid_cells or, if h > 0, from -grid_h. */
static void SetAxis(MPMGrid *grid, MPMOptions o, PetscInt d, const PetscReal size[3])
{
  const PetscReal h = size[d], lower = grid->lower[d], upper = grid->upper[d], length = upper - lower;
  const PetscReal most = 1e9, n = h > 0 ? PetscFloorReal(length / h + 0.5) : 0;

  if (h > 0 && n > most)
    MPMOptionsFail(o, "-grid_h %g makes %g cells on axis %c, more than %g", (double)h, (double)n, "xyz"[d],
                   (double)most);
  else if (h > 0 && (n < 1 || PetscAbsReal(n * h - length) > 1e-9 * length))
    NotDividing(grid, o, d, size);
  if (MPMOptionsError(o)) return;
  if (h > 0) grid->cells[d] = (PetscInt)n;
  grid->h[d] = length / grid->cells[d];
  if (!(lower + grid->h[d] > lower && upper - grid->h[d] < upper))
    MPMOptionsFail(o, "-grid_cells: cells of %g m are too small beside the coordinates, %g to %g", (double)grid->h[d],
                   (double)lower, (double)upper);
}

static PetscErrorCode ReadGrid(MPMCore *core, MPMOptions o)
{
  MPMGrid  *grid = &core->grid;
  PetscBool by_cells, by_h;
  PetscReal h[3] = {0};

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) grid->h[d] = 1;
  PetscCall(MPMOptionsReals(o, "grid_lower", NULL, grid->lower, NULL));
  PetscCall(MPMOptionsReals(o, "grid_upper", NULL, grid->upper, NULL));
  PetscCall(MPMOptionsInts(o, "grid_cells", NULL, grid->cells, &by_cells));
  PetscCall(MPMOptionsReals(o, "grid_h", NULL, h, &by_h));
  if (by_cells && by_h) MPMOptionsFail(o, "-grid_cells and -grid_h exclude each other");
  if (!by_cells && !by_h) MPMOptionsFail(o, "-grid_cells is required (number of cells), or -grid_h");
  grid->by_h = by_h;
  for (PetscInt d = 0; d < grid->dim; d++)
    if (!(grid->upper[d] - grid->lower[d] > 0 && grid->upper[d] - grid->lower[d] < PETSC_MAX_REAL))
      MPMOptionsFail(o, "-grid_upper must be above -grid_lower on every axis; axis %c has %g and %g", "xyz"[d],
                     (double)grid -> upper[d], (double)grid -> lower[d]);
  for (PetscInt d = 0; d < grid->dim && !MPMOptionsError(o); d++) SetAxis(grid, o, d, h);
  if (grid->round && grid->lower[0] < 0)
    MPMOptionsFail(
        o,
        "-grid_lower %g: with -geometry axisymmetric x is the radius; the grid begins at x = 0, the axis, or "
        "further out",
        (double)grid->lower[0]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies a list of words, which are separated by blanks, without one of them. */
static void DropWord(const char list[], const char word[], char rest[MPM_TEXT_LEN])
{
  rest[0] = 0;
  for (const char *w = list + strspn(list, " "); *w; w += strspn(w, " ")) {
    const size_t n = strcspn(w, " ");

    if (n != strlen(word) || strncmp(w, word, n))
      MPMAppend(rest, MPM_TEXT_LEN, "%s%.*s", rest[0] ? " " : "", (int)n, w);
    w += n;
  }
}

/* Refuses constants of johnsoncook that change nothing, since another one that they belong to is not given. */
static PetscErrorCode RefuseIdle(MPMOptions o, const MPMMaterial *m)
{
  static const struct {
    const char *word, *without, *what;
  } rows[] = {
      {"softening_power", "melting", "heat"},
      {"rate_reference", "rate_factor", "the rate"},
      {"hardening_power", "hardening", "plastic strain"},
  };

  PetscFunctionBeginUser;
  for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
    char      idle[3 * MPM_NAME_LEN], without[3 * MPM_NAME_LEN];
    PetscBool given, needed;

    (void)snprintf(idle, sizeof idle, "-material_%s_%s", m->name, rows[k].word);
    (void)snprintf(without, sizeof without, "-material_%s_%s", m->name, rows[k].without);
    PetscCall(PetscOptionsHasName(NULL, NULL, idle, &given));
    PetscCall(PetscOptionsHasName(NULL, NULL, without, &needed));
    if (given && !needed && MPMListHas(m->type->parameters, rows[k].without))
      MPMOptionsFail(o, "%s does not apply: without %s %s does not change the strength; give both, or none", idle,
                     without, rows[k].what);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadMaterial(const MPMCore *core, MPMOptions o, MPMMaterial *m)
{
  const struct {
    const char *word, *row;
    PetscReal  *value;
  } numbers[] = {
      {"E", "material_<m>_E", &m->E},
      {"nu", "material_<m>_nu", &m->nu},
      {"K", "material_<m>_K", &m->K},
      {"viscosity", "material_<m>_viscosity", &m->viscosity},
      {"tait_gamma", "material_<m>_tait_gamma", &m->gamma},
      {"tension_cutoff", "material_<m>_tension_cutoff", &m->tension},
      {"relaxation", "material_<m>_relaxation", &m->relaxation},
      {"yield", "material_<m>_yield", &m->yield},
      {"hardening", "material_<m>_hardening", &m->hardening},
      {"friction_angle", "material_<m>_friction_angle", &m->friction},
      {"dilation_angle", "material_<m>_dilation_angle", &m->dilation},
      {"cohesion", "material_<m>_cohesion", &m->cohesion},
      {"G", "material_<m>_G", &m->shear},
      {"c0", "material_<m>_c0", &m->c0},
      {"hugoniot_slope", "material_<m>_hugoniot_slope", &m->slope},
      {"gruneisen", "material_<m>_gruneisen", &m->gruneisen},
      {"hardening_power", "material_<m>_hardening_power", &m->power},
      {"rate_factor", "material_<m>_rate_factor", &m->rate},
      {"rate_reference", "material_<m>_rate_reference", &m->rate0},
      {"softening_power", "material_<m>_softening_power", &m->softening},
      {"melting", "material_<m>_melting", &m->melting},
      {"temperature", "material_<m>_temperature", &m->temperature},
      {"specific_heat", "material_<m>_specific_heat", &m->heat},
      {"heating_share", "material_<m>_heating_share", &m->share},
  };
  char        model[MPM_NAME_LEN] = "", eos[MPM_NAME_LEN] = "", all[MPM_TEXT_LEN] = "eos fit", linear[MPM_TEXT_LEN];
  char        fit[MPM_NAME_LEN] = "";
  const char *taken, *wrong;
  PetscBool   given;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsMethodGiven(&given, NULL));
  m->tension = m->melting = -1; /* none */
  for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++) MPMAppend(all, sizeof all, " %s", numbers[k].word);
  PetscCall(MPMOptionsEnum(o, "material_<m>_model", m->name, model, NULL));
  for (const MPMMaterialType *type = MPMMaterialTypes; type->name; type++)
    if (!strcmp(type->name, model)) m->type = type;
  PetscCall(MPMOptionsReal(o, "material_<m>_rho", m->name, &m->rho, NULL));
  if (!m->type) PetscFunctionReturn(PETSC_SUCCESS);
  if (m->type->traits & MPM_FLUID) m->tension = 0;
  taken = m->type->parameters;
  if (MPMListHas(taken, "relaxation") && !given && !core->grid.round)
    m->relaxation = m->type->traits & MPM_FLUID ? 1 : 0.25; /* more slows down sand on coarse grids */
  PetscCall(MPMOptionsRefuseOthers(o, "material", m->name, "model", model, all, taken));
  if (MPMListHas(taken, "eos")) {
    PetscCall(MPMOptionsEnum(o, "material_<m>_eos", m->name, eos, NULL));
    if (!strcmp(eos, "linear")) {
      DropWord(m->type->parameters, "tait_gamma", linear);
      taken = linear;
      PetscCall(MPMOptionsRefuseOthers(o, "material", m->name, "eos", eos, m->type->parameters, taken));
    }
  }
  if (MPMListHas(taken, "fit")) PetscCall(MPMOptionsEnum(o, "material_<m>_fit", m->name, fit, NULL));
  m->plane = !strcmp(fit, "plane_strain");
  for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
    if (MPMListHas(taken, numbers[k].word))
      PetscCall(MPMOptionsReal(o, numbers[k].row, m->name, numbers[k].value, NULL));
  if (m->tension > PETSC_MAX_REAL) m->tension = -1;
  PetscCall(RefuseIdle(o, m));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  wrong    = MPMMaterialSetUp(m);
  m->round = core->grid.round;
  if (m->round && m->state & MPM_BIT(F)) m->state |= MPM_BIT(F33);
  if (wrong) MPMOptionsFail(o, "-material_%s_%s", m->name, wrong);
  if (!((m->K / m->rho) < PETSC_MAX_REAL))
    MPMOptionsFail(o, "-material_%s_K %g over its density is not finite", m->name, (double)m->K);
  if (!((m->lambda + 2 * m->mu) / m->rho < PETSC_MAX_REAL))
    MPMOptionsFail(o, "-material_%s_nu %.17g is so close to its limit that the wave speed is not finite", m->name,
                   (double)m->nu);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads a body; b->alone says whether it is a shape for others, without particles. Collective on core->comm. */
static PetscErrorCode ReadBody(MPMScene *scene, MPMCore *core, MPMOptions o, MPMBody *b)
{
  char      material[MPM_TEXT_LEN] = "";
  PetscBool ppc;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) b->ppc[d] = scene->ppc;
  b->round = core->grid.round;
  PetscCall(MPMSceneReadRegion(core, o, b->name, &b->region));
  PetscCall(MPMSceneReadRigid(core, o, b));
  if (b->rigid != MPM_RIGID_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsString(o, "body_<b>_material", b->name, material, NULL));
  b->alone = !strcasecmp(material, "none");
  for (PetscInt k = 0; k < scene->nmaterials; k++) /* a material may have this name */
    if (!strcasecmp(scene->materials[k].name, "none")) b->alone = PETSC_FALSE;
  if (b->alone) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsDeclared(o, "body_<b>_material", b->name, scene->nmaterials, scene->materials->name,
                               sizeof *scene->materials, &b->material));
  if (!MPMOptionsError(o) && MPMMaterialIsGas(scene->materials + b->material))
    for (PetscInt d = 0; d < 3; d++) b->ppc[d] = scene->ppc_gas;
  PetscCall(MPMOptionsInts(o, "body_<b>_ppc", b->name, b->ppc, &ppc));
  if (b->region.type == MPM_REGION_file)
    PetscCall(MPMPointsOpen(core, o, b));
  else
    PetscCall(MPMOptionsReals(o, "body_<b>_offset", b->name, b->offset, NULL));
  PetscCall(MPMOptionsExpression(o, "body_<b>_velocity", b->name, "xyz", core->grid.dim, &b->velocity));
  if (b->points && b->points->velocity && b->velocity)
    MPMOptionsFail(o, "-body_%s_velocity does not apply: %s has velocities", b->name, b->points->path);
  if (b->points && !b->points->volume && !ppc)
    MPMOptionsFail(
        o,
        "%.600s has no column volume: add one, or give -body_%s_ppc, with which a particle has the volume of "
        "a cell over ppc on each axis",
        b->points->what, b->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns how late a body comes among all: those on a lattice first, then those from files, then shapes alone. */
static PetscInt Place(const MPMBody *b)
{
  return b->alone ? 2 : b->region.type == MPM_REGION_file ? 1 : 0;
}

/* Reads all bodies, and puts them into the order of Place and, within it, of -bodies. Collective on core->comm. */
static PetscErrorCode ReadBodies(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  const PetscInt all = scene->nbodies;
  MPMBody       *was = scene->bodies;
  PetscInt       n   = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < all; k++) PetscCall(ReadBody(scene, core, o, &was[k]));
  PetscCall(PetscCalloc1(all, &scene->bodies));
  for (PetscInt place = 0; place < 3; place++) {
    for (PetscInt k = 0; k < all; k++)
      if (Place(&was[k]) == place) scene->bodies[n++] = was[k];
    if (place == 0) scene->nfilled = n;
    if (place == 1) scene->nbodies = n;
  }
  PetscCall(PetscFree(was));
  scene->nshapes = all - scene->nbodies;
  if (!scene->nbodies) MPMOptionsFail(o, "-bodies: all are of material none; a scene needs particles");
  PetscCall(MPMSceneReadOthers(scene, o));
  for (PetscInt k = 0; k < all; k++) {
    const MPMSurface *s    = scene->bodies[k].region.surface;
    const size_t      size = s ? (size_t)(s->n * s->dim * s->dim) * sizeof *s->corner : 0;

    if (scene->bodies[k].points) scene->shapes += scene->bodies[k].points->sum;
    if (s) scene->shapes += (PetscInt64)MPMChecksum(s->corner, size, (size_t)k << 40);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the default name of the results, which is that of the last options file. */
static PetscErrorCode DefaultName(char name[MPM_NAME_LEN])
{
  int         argc;
  char      **argv;
  const char *file = "pebble", *slash, *dot;

  PetscFunctionBeginUser;
  PetscCall(PetscGetArgs(&argc, &argv));
  for (int k = 1; k + 1 < argc; k++)
    if (!strcasecmp(argv[k], "-options_file")) file = argv[k + 1];
  slash = strrchr(file, '/');
  if (slash) file = slash + 1;
  dot = strrchr(file, '.');
  (void)snprintf(name, MPM_NAME_LEN, "%.*s", (int)(dot && dot > file ? dot - file : (long)strlen(file)), file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses bodies that are all rigid, or shapes for others: before their materials are read, since such a scene has none. */
static PetscErrorCode RefuseRigids(MPMOptions o)
{
  char list[MPM_TEXT_LEN] = "", name[MPM_NAME_LEN] = "", *save = NULL;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-bodies", list, sizeof list, NULL));
  for (char *word = strtok_r(list, ", ", &save); word; word = strtok_r(NULL, ", ", &save)) {
    char      option[2 * MPM_NAME_LEN], rigid[MPM_NAME_LEN] = "", material[MPM_NAME_LEN] = "";
    PetscBool moves, fixed;

    (void)snprintf(option, sizeof option, "-body_%.100s_material", word);
    PetscCall(PetscOptionsGetString(NULL, NULL, option, material, sizeof material, NULL));
    (void)snprintf(option, sizeof option, "-body_%.100s_rigid", word);
    PetscCall(PetscOptionsGetString(NULL, NULL, option, rigid, sizeof rigid, NULL));
    moves = !strcasecmp(rigid, "moving") || !strcasecmp(rigid, "free") ? PETSC_TRUE : PETSC_FALSE;
    fixed = !strcasecmp(rigid, "fixed") ? PETSC_TRUE : PETSC_FALSE;
    if (!moves && !fixed && strcasecmp(material, "none")) PetscFunctionReturn(PETSC_SUCCESS);
    if (fixed || (moves && !name[0])) /* rather the floor than what falls on it */
      (void)snprintf(name, sizeof name, "%.*s", MPM_NAME_LEN - 1, word);
  }
  if (name[0])
    MPMOptionsFail(
        o,
        "-bodies: all are rigid or of material none, and rigid bodies alone are not computed: they meet matter "
        "and walls, not each other; let %s deform, of a stiff material if it is to be hard: -body_%s_material "
        "in place of -body_%s_rigid",
        name, name, name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the dimension and the declared names first, since the legal names of options depend on them. */
static PetscErrorCode ReadNames(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  char(*materials)[MPM_NAME_LEN], (*bodies)[MPM_NAME_LEN], (*loads)[MPM_NAME_LEN];

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsInt(o, "dim", NULL, &core->grid.dim, NULL));
  PetscCall(RefuseRigids(o));
  PetscCall(MPMOptionsNames(o, "materials", &scene->nmaterials, &materials));
  PetscCall(MPMOptionsNames(o, "bodies", &scene->nbodies, &bodies));
  PetscCall(MPMOptionsNames(o, "loads", &scene->nloads, &loads));
  PetscCall(MPMOptionsNames(o, "probes", &scene->nprobes, &scene->probes));
  PetscCall(MPMOptionsNames(o, "contacts", &scene->ncontacts, &scene->contacts));
  PetscCall(MPMOptionsNames(o, "stages", &scene->nstages, &scene->stages));
  PetscCall(PetscCalloc1(scene->nloads, &scene->loads));
  for (PetscInt k = 0; k < scene->nloads; k++) PetscCall(PetscStrncpy(scene->loads[k].name, loads[k], MPM_NAME_LEN));
  PetscCall(PetscCalloc1(scene->nmaterials, &scene->materials));
  PetscCall(PetscCalloc1(scene->nbodies, &scene->bodies));
  for (PetscInt k = 0; k < scene->nmaterials; k++)
    PetscCall(PetscStrncpy(scene->materials[k].name, materials[k], MPM_NAME_LEN));
  for (PetscInt k = 0; k < scene->nbodies; k++) PetscCall(PetscStrncpy(scene->bodies[k].name, bodies[k], MPM_NAME_LEN));
  if (!MPMOptionsError(o)) MPMOptionsDeclareOthers(o, scene->nprobes, scene->probes, scene->ncontacts, scene->contacts);
  if (!MPMOptionsError(o)) MPMOptionsDeclareStages(o, scene->nstages, scene->stages);
  if (MPMOptionsError(o))
    PetscCall(MPMOptionsDeclare(o, 3, 0, NULL, 0, NULL, 0, NULL)); /* so that a misspelt -dim is named, not missed */
  else
    PetscCall(MPMOptionsDeclare(o, core->grid.dim, scene->nmaterials, materials, scene->nbodies, bodies, scene->nloads,
                                loads));
  PetscCall(PetscFree(materials));
  PetscCall(PetscFree(bodies));
  PetscCall(PetscFree(loads));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads what is simulated. The first fault is left in o. Collective on core->comm, since all processes have to read the
   same options. */
PetscErrorCode MPMSceneSetFromOptions(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  char      geometry[MPM_NAME_LEN], name[MPM_TEXT_LEN];
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(ReadNames(scene, core, o));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DefaultName(scene->name));
  PetscCall(PetscStrncpy(name, scene->name, sizeof name));
  PetscCall(MPMOptionsString(o, "output_name", NULL, name, NULL));
  if (strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._+-") != strlen(name) ||
      strlen(name) >= MPM_NAME_LEN)
    MPMOptionsFail(o,
                   "-output_name %.100s: the name of the results has letters, digits and ._+-, at most %d of them "
                   "(-output_dir names the folder; without -output_name it is the options file's name)",
                   name, MPM_NAME_LEN - 1);
  if (strstr(name, "-checkpoint-"))
    MPMOptionsFail(o, "-output_name %.100s: -checkpoint- is in the names of checkpoints alone; give another name",
                   name);
  (void)snprintf(scene->name, sizeof scene->name, "%.*s", MPM_NAME_LEN - 1, name);
  PetscCall(PetscStrncpy(scene->title, scene->name, sizeof scene->title));
  PetscCall(MPMOptionsString(o, "scene_title", NULL, scene->title, NULL));
  PetscCall(MPMOptionsBool(o, "dry_run", NULL, &scene->dry_run));
  PetscCall(MPMOptionsEnum(o, "geometry", NULL, geometry, &set));
  if (set && strcmp(geometry, "cartesian") && core->grid.dim != 2)
    MPMOptionsFail(o, "-geometry %s needs -dim 2, not %" PetscInt_FMT, geometry, core->grid.dim);
  core->grid.round = set && !strcmp(geometry, "axisymmetric");
  PetscCall(MPMOptionsReals(o, "gravity", NULL, core->params.gravity, NULL));
  PetscCall(ReadGrid(core, o));
  for (PetscInt k = 0; k < scene->nmaterials; k++) PetscCall(ReadMaterial(core, o, &scene->materials[k]));
  PetscCall(ReadBodies(scene, core, o));
  PetscCall(MPMCutSetFromOptions(scene, o));
  for (PetscInt m = 0; m < scene->nmaterials; m++) {
    PetscBool used = PETSC_FALSE;

    for (PetscInt b = 0; b < scene->nbodies; b++)
      if (scene->bodies[b].material == m || (scene->bodies[b].points && scene->bodies[b].points->material))
        used = PETSC_TRUE;
    if (!used) MPMOptionsFail(o, "-materials: no body is of %s; remove it", scene->materials[m].name);
  }
  PetscCall(MPMSceneReadWalls(scene, core, o));
  if (!MPMOptionsError(o)) PetscCall(MPMSceneReadContacts(scene, core, o));
  scene->meets = core->contacts ? PETSC_TRUE : PETSC_FALSE;
  if (!MPMOptionsError(o)) PetscCall(MPMSceneMakeRigids(scene, core, o));
  PetscCall(MPMForcesSetFromOptions(scene, core, o));
  if (!MPMOptionsError(o)) PetscCall(MPMKnownSetFromOptions(scene, core, o));
  if (!MPMOptionsError(o)) PetscCall(MPMInitialSetFromOptions(scene, core, o));
  if (!MPMOptionsError(o)) PetscCall(MPMSourcesSetFromOptions(scene, core, o));
  if (!MPMOptionsError(o) && core->grid.round) PetscCall(MPMSceneCheckRound(scene, core, o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees what the scene has. Not collective. */
PetscErrorCode MPMSceneDestroy(MPMScene *scene)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < scene->nbodies + scene->nshapes; k++) {
    PetscCall(MPMExpressionDestroy(&scene->bodies[k].velocity));
    PetscCall(MPMExpressionDestroy(&scene->bodies[k].spin));
    PetscCall(PetscFree(scene->bodies[k].columns));
  }
  for (PetscInt k = 0; k < 6; k++) PetscCall(MPMExpressionDestroy(&scene->wall_velocity[k]));
  PetscCall(MPMInitialDestroy(scene));
  for (PetscInt k = 0; k < scene->nbodies + scene->nshapes; k++) {
    PetscCall(MPMSceneDestroyRegion(&scene->bodies[k].region));
    PetscCall(PetscFree(scene->bodies[k].source.ids));
    PetscCall(MPMPointsDestroy(&scene->bodies[k].points));
    PetscCall(PetscFree(scene->bodies[k].cut));
    PetscCall(PetscFree(scene->bodies[k].rings));
  }
  PetscCall(MPMForcesDestroy(scene));
  PetscCall(MPMKnownDestroy(scene));
  PetscCall(PetscFree(scene->materials));
  PetscCall(PetscFree(scene->bodies));
  PetscCall(PetscFree(scene->kinds));
  PetscCall(PetscFree(scene->memo));
  PetscCall(PetscFree(scene->probes));
  PetscCall(PetscFree(scene->contacts));
  PetscCall(PetscFree(scene->stages));
  PetscCall(PetscFree(scene->share_first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMBodyOf(const MPMScene *scene, PetscInt64 id, PetscInt guess)
{
  while (guess > 0 && id < scene->bodies[guess].first) guess--;
  while (guess + 1 < scene->nbodies && id >= scene->bodies[guess + 1].first) guess++;
  return guess;
}
