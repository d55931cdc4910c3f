/* method.c - reads the options of how a run is made: basis, update, transfer, time steps. It is used before the first
   step. */
#include "kernels/tile_index.h"
#include "run/mpm.h"

#define MPM_HATS_RATE                                                                                                  \
  0.025 /* -method_damping_rate of linear hats: musl is stable there with a share of FLIP below 0.995 */

#define MPM_LOCK_SHARE                                                                                                 \
  0.8 /* -method_lock_share of metals; docs/studies.md (Locking) has what was measured with others */
#define MPM_LIGHT_SHARE 0.1  /* -method_light_nodes; docs/method.md (Light nodes) has what was measured with others */
#define MPM_LIGHT_FLIP  0.03 /* the same of elastic scenes with transfers that keep no affine strain */

/* Reads what decides the share of FLIP: that share itself or a damping, of which transfers without such a share take
   none. chosen: the transfer was given, and not taken from the preset. */
static PetscErrorCode ReadDamping(MPM mpm, MPMOptions o, PetscBool chosen)
{
  MPMCore           *core     = &mpm->core;
  MPMMethod         *method   = &mpm->method;
  const MPMTransfer *transfer = method->transfer;
  const PetscBool    affine   = (transfer->parts & MPM_AFFINE) != 0;
  const PetscBool    hats     = core->basis == MPM_BASIS_linear;
  PetscBool          flip_set, strain_set, rate_set, viscosity_set;

  PetscFunctionBeginUser;
  core->params.flip   = 1;
  core->params.strain = chosen || !MPMBasisIsSpline(core->basis) ? 0 : mpm->preset->strain;
  method->rate        = chosen ? 0 : hats ? MPM_HATS_RATE : mpm->preset->rate;
  PetscCall(MPMOptionsReal(o, "method_flip", NULL, &core->params.flip, &flip_set));
  PetscCall(MPMOptionsReal(o, "method_affine_strain", NULL, &core->params.strain, &strain_set));
  PetscCall(MPMOptionsReal(o, "method_damping_rate", NULL, &method->rate, &rate_set));
  PetscCall(MPMOptionsReal(o, "method_damping_viscosity", NULL, &method->viscosity, &viscosity_set));
  rate_set      = rate_set && method->rate > 0; /* 0 switches a damping off */
  viscosity_set = viscosity_set && method->viscosity > 0;
  if (flip_set + rate_set + viscosity_set > 1)
    MPMOptionsFail(o, "-method_flip, -method_damping_rate and -method_damping_viscosity exclude each other: each sets "
                      "the share of FLIP");
  if (flip_set || viscosity_set) method->rate = 0;
  if (strain_set && !(affine && transfer->flip < 0) && !MPMOptionsOverridden("method_affine_strain", "method_transfer"))
    MPMOptionsFail(o, "-method_affine_strain does not apply: -method_transfer is %s, and the option is for aflip",
                   transfer->name);
  if (viscosity_set && affine && transfer->flip < 0)
    MPMOptionsFail(o, "-method_damping_viscosity is for -method_transfer flip: what aflip loses is no viscosity; use "
                      "-method_damping_rate");
  if (!affine || transfer->flip >= 0) core->params.strain = 1;
  core->params.outward = affine ? core->params.strain : 0;
  if (transfer->flip >= 0) {
    const struct {
      const char *name;
      PetscBool   set;
    } shares[] = {
        {"method_flip", flip_set}, {"method_damping_rate", rate_set}, {"method_damping_viscosity", viscosity_set}};

    for (size_t k = 0; k < sizeof shares / sizeof shares[0]; k++)
      if (shares[k].set && !MPMOptionsOverridden(shares[k].name, "method_transfer"))
        MPMOptionsFail(o, "-%s does not apply: -method_transfer %s has no share of FLIP", shares[k].name,
                       transfer->name);
    core->params.flip = transfer->flip;
    method->rate = method->viscosity = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the update and the transfer, with the options that only some transfers have; the basis is known. */
static PetscErrorCode ReadTransfer(MPM mpm, MPMOptions o)
{
  MPMCore           *core = &mpm->core;
  const PetscBool    hats = core->basis == MPM_BASIS_linear;
  const MPMTransfer *transfer;
  char               update[MPM_NAME_LEN], name[MPM_NAME_LEN], carry[MPM_NAME_LEN];
  PetscBool          chosen, order_set;

  PetscFunctionBeginUser;
  (void)snprintf(update, sizeof update, "%s", hats ? "musl" : mpm->preset->update);
  (void)snprintf(name, sizeof name, "%s", hats ? "flip" : mpm->preset->transfer);
  PetscCall(MPMOptionsEnum(o, "method_update", NULL, update, NULL));
  PetscCall(MPMOptionsEnum(o, "method_transfer", NULL, name, &chosen));
  PetscCall(MPMOptionsInt(o, "method_order", NULL, &core->params.order, &order_set));
  PetscCall(MPMOptionsEnum(o, "method_carry", NULL, carry, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  for (mpm->method.scheme = MPMSchemes; strcmp(mpm->method.scheme->name, update);) mpm->method.scheme++;
  for (transfer = MPMTransfers; strcmp(transfer->name, name);) transfer++;
  mpm->method.transfer = transfer;
  PetscCall(ReadDamping(mpm, o, chosen));
  if (transfer->rounds == MPM_NO_ROUNDS) {
    if (order_set && !MPMOptionsOverridden("method_order", "method_transfer"))
      MPMOptionsFail(o, "-method_order does not apply: it is the order of -method_transfer xpic or afmpm");
    core->params.order = 0;
  }
  core->needs.increment = mpm->method.scheme->keeps_increment;
  core->needs.affine    = (transfer->parts & MPM_AFFINE) != 0;
  core->needs.residual  = transfer->rounds != MPM_NO_ROUNDS;
  core->needs.all       = !strcmp(carry, "all");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the inertia of affine velocities near walls, after the basis and the transfer. */
static PetscErrorCode ReadInertia(MPM mpm, MPMOptions o)
{
  MPMCore  *core = &mpm->core;
  char      wall[MPM_NAME_LEN], inertia[MPM_NAME_LEN];
  PetscBool affine, inertia_set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "method_wall_basis", NULL, wall, NULL));
  PetscCall(MPMOptionsEnum(o, "method_wall_inertia", NULL, inertia, &inertia_set));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  affine                   = MPMBasisIsSpline(core->basis) && core->needs.affine && !strcmp(wall, "extrap");
  core->params.own_inertia = affine && !strcmp(inertia, "own");
  if (inertia_set && !affine && !MPMOptionsOverridden("method_wall_inertia", "method_basis") &&
      !MPMOptionsOverridden("method_wall_inertia", "method_transfer"))
    MPMOptionsFail(o, "-method_wall_inertia does not apply: it is for affine velocities with splines of form extrap");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether plastic flow would lock: there is metal, and besides it only elastic laws, which F-bar does not harm.
   metal: there is metal. */
static PetscBool Locks(const MPM mpm, PetscBool *metal)
{
  PetscInt all = 0, others = 0;

  for (PetscInt k = 0; k < mpm->scene.nmaterials; k++) {
    const PetscInt own = mpm->scene.materials[k].type->traits;

    if (!(own & (MPM_SMALL_STRAIN | MPM_HYPERELASTIC | MPM_ISOCHORIC))) others++;
    all |= own;
  }
  *metal = (all & MPM_ISOCHORIC) != 0;
  return *metal && !others && mpm->core.grid.dim > 1 && MPMBasisIsSpline(mpm->core.basis);
}

/* Reads what is done against locking, after the basis. A box of F-bar has to lie within a tile. */
static PetscErrorCode ReadLocking(MPM mpm, MPMOptions o)
{
  MPMCore       *core = &mpm->core;
  const PetscInt most = MPMTileEdge(core->basis);
  char           locking[MPM_NAME_LEN];
  PetscInt       cells;
  PetscBool      given, locks, metal, set, share_set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsMethodGiven(&given, NULL));
  locks = Locks(mpm, &metal);
  (void)snprintf(locking, sizeof locking, "%s", !given && locks ? "fbar" : "none");
  core->params.lock_share = !given && metal ? MPM_LOCK_SHARE : 1;
  PetscCall(MPMOptionsEnum(o, "method_locking", NULL, locking, NULL));
  PetscCall(MPMOptionsInt(o, "method_lock_cells", NULL, &cells, &set));
  PetscCall(MPMOptionsReal(o, "method_lock_share", NULL, &core->params.lock_share, &share_set));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!strcmp(locking, "none")) {
    if (set && !MPMOptionsOverridden("method_lock_cells", "method_locking"))
      MPMOptionsFail(o, "-method_lock_cells does not apply: -method_locking is none");
    if (share_set && !MPMOptionsOverridden("method_lock_share", "method_locking"))
      MPMOptionsFail(o, "-method_lock_share does not apply: -method_locking is none");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (core->grid.dim == 1)
    MPMOptionsFail(o, "-method_locking fbar does not apply: with -dim 1 all strain is change of volume");
  if (cells == 3 || cells > most)
    MPMOptionsFail(o, "-method_lock_cells %" PetscInt_FMT ": with -method_basis %s choose 1%s", cells,
                   MPMBasisNames[core->basis], most == 2 ? " or 2" : ", 2 or 4");
  core->params.box = cells;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads the share of mass below which nodes are light. */
static PetscErrorCode ReadLight(MPM mpm, MPMOptions o)
{
  const PetscBool affine = mpm->method.transfer->parts & MPM_AFFINE && mpm->core.params.strain > 0;
  const PetscBool direct = mpm->method.scheme->direct;
  PetscReal      *share  = &mpm->core.params.light;
  PetscBool       given, set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsMethodGiven(&given, NULL));
  *share = MPM_LIGHT_SHARE;
  /* FLIP and musl keep what light nodes do to the energy, and elastic laws dissipate nothing */
  if (mpm->preset->scenes == MPM_SCENES_elastic) *share = !direct ? 0 : affine ? MPM_LIGHT_SHARE : MPM_LIGHT_FLIP;
  if (given || mpm->core.basis == MPM_BASIS_linear) *share = 0;
  PetscCall(MPMOptionsReal(o, "method_light_nodes", NULL, share, &set));
  if (*share > 0 && mpm->core.basis == MPM_BASIS_linear && !MPMOptionsOverridden("method_light_nodes", "method_basis"))
    MPMOptionsFail(o, "-method_light_nodes does not apply: it is for gimp and the splines, -method_basis is linear");
  if (mpm->core.basis == MPM_BASIS_linear) *share = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses grids that have too few cells for the basis, or more nodes than can be numbered. */
static void CheckNodes(const MPMCore *core, MPMOptions o)
{
  const MPMGrid  *grid  = &core->grid;
  const PetscInt  least = core->basis == MPM_BASIS_linear ? 1 : MPMBasisNodes(core->basis);
  const PetscReal nodes = MPMGridNodes(grid, core->basis);

  for (PetscInt d = 0; d < grid->dim; d++)
    if (grid->cells[d] < least && (MPMBasisIsSpline(core->basis) || grid->periodic[d]))
      MPMOptionsFail(
          o, "-grid_cells: %" PetscInt_FMT " on axis %c are too few for -method_basis %s, which needs %" PetscInt_FMT,
          grid->cells[d], "xyz"[d], MPMBasisNames[core->basis], least);
  if (nodes * MPM_NODE_NC > (PetscReal)PETSC_MAX_INT) /* there are fewer cells of tiles, below 6 per node */
    MPMOptionsFail(o, "-grid_cells: %g nodes are more than this PETSc can number", (double)nodes);
}

/* Reads the basis, with the options that only some bases have, and sets the nodes of the grid by it. */
static PetscErrorCode ReadBasis(MPM mpm, MPMOptions o)
{
  MPMCore  *core = &mpm->core;
  char      basis[MPM_NAME_LEN], wall[MPM_NAME_LEN], gimp[MPM_NAME_LEN];
  PetscBool wall_set, gimp_set;
  PetscInt  row;

  PetscFunctionBeginUser;
  (void)snprintf(basis, sizeof basis, "%s", MPMFrameRests(mpm) ? "bspline2" : mpm->preset->basis);
  (void)snprintf(gimp, sizeof gimp, "%s", mpm->preset->scenes == MPM_SCENES_elastic ? "stretch" : "none");
  PetscCall(MPMOptionsEnum(o, "method_basis", NULL, basis, NULL));
  PetscCall(MPMOptionsEnum(o, "method_wall_basis", NULL, wall, &wall_set));
  PetscCall(MPMOptionsEnum(o, "method_gimp_update", NULL, gimp, &gimp_set));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsFind(basis, MPM_NUM_BASES, MPMBasisNames, &row));
  core->basis           = (MPMBasis)row;
  core->needs.stretched = core->basis == MPM_BASIS_gimp && !strcmp(gimp, "stretch") && !core->grid.total;
  if (wall_set && !MPMBasisIsSpline(core->basis) && !MPMOptionsOverridden("method_wall_basis", "method_basis"))
    MPMOptionsFail(o, "-method_wall_basis does not apply: it is for the splines, -method_basis is %s", basis);
  if (gimp_set && core->basis != MPM_BASIS_gimp && !MPMOptionsOverridden("method_gimp_update", "method_basis"))
    MPMOptionsFail(o, "-method_gimp_update does not apply: -method_basis is %s", basis);
  for (PetscInt k = 0; k < mpm->scene.nmaterials; k++)
    if (core->needs.stretched && !(mpm->scene.materials[k].state & MPM_BIT(F)))
      MPMOptionsFail(o, "-method_gimp_update stretch does not apply: material %s (%s) has no deformation gradient",
                     mpm->scene.materials[k].name, mpm->scene.materials[k].type->name);
  if (core->grid.round && !strcmp(wall, "steffen"))
    MPMOptionsFail(o,
                   "-method_wall_basis steffen does not apply: at the axis of -geometry axisymmetric its strain is 0");
  for (PetscInt d = 0; d < core->grid.dim; d++)
    core->grid.wall_basis[d] = core->grid.periodic[d]     ? MPM_WALL_BASIS_NONE
                               : !strcmp(wall, "steffen") ? MPM_WALL_BASIS_STEFFEN
                                                          : MPM_WALL_BASIS_EXTRAP;
  core->grid.places = core->grid.copies; /* as many as there may be; they begin at one place (MPMContactsSettle) */
  MPMGridSetNodes(&core->grid, core->basis);
  CheckNodes(core, o);
  core->grid.places = 1;
  MPMGridSetNodes(&core->grid, core->basis);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadTime(MPM mpm, MPMOptions o)
{
  char      size[MPM_TEXT_LEN];
  PetscBool set;

  PetscFunctionBeginUser;
  mpm->time.max_steps = PETSC_MAX_INT;
  mpm->time.cfl       = MPMStableOf(&mpm->core, &mpm->method).cfl;
  mpm->time.cfl       = PetscMin(mpm->preset->cfl, mpm->time.cfl);
  PetscCall(MPMOptionsReal(o, "time_end", NULL, &mpm->time.end, NULL));
  PetscCall(MPMOptionsInt(o, "time_max_steps", NULL, &mpm->time.max_steps, NULL));
  PetscCall(MPMOptionsString(o, "dt_size", NULL, size, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (strcmp(size, "auto")) {
    char *end;

    mpm->time.fixed = strtod(size, &end);
    if (end == size || *end)
      MPMOptionsFail(o, "-dt_size %s: choose auto or a number > 0", size);
    else if (!(PetscAbsReal(mpm->time.fixed) <= PETSC_MAX_REAL))
      MPMOptionsFail(o, "-dt_size is not finite");
    else if (mpm->time.fixed <= 0)
      MPMOptionsFail(o, "-dt_size %s is outside the allowed range dt_size > 0", size);
    PetscCall(MPMOptionsReal(o, "dt_cfl", NULL, &mpm->time.cfl, &set));
    if (set && !MPMOptionsOverridden("dt_cfl", "dt_size"))
      MPMOptionsFail(o, "-dt_cfl does not apply: -dt_size is fixed");
  } else
    PetscCall(MPMOptionsReal(o, "dt_cfl", NULL, &mpm->time.cfl, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMMethodSetFromOptions(MPM mpm, MPMOptions o)
{
  PetscFunctionBeginUser;
  if (mpm->core.grid.total || MPMFrameRests(mpm)) PetscCall(MPMFrameCheck(mpm, o));
  if (!MPMOptionsError(o)) PetscCall(ReadBasis(mpm, o));
  if (!MPMOptionsError(o)) PetscCall(ReadTransfer(mpm, o));
  if (!MPMOptionsError(o)) PetscCall(ReadInertia(mpm, o));
  if (!MPMOptionsError(o)) PetscCall(ReadLocking(mpm, o));
  if (!MPMOptionsError(o)) PetscCall(ReadLight(mpm, o));
  if (!MPMOptionsError(o)) PetscCall(MPMFrameRead(mpm, o));
  if (!MPMOptionsError(o)) PetscCall(ReadTime(mpm, o));
  if (!MPMOptionsError(o)) PetscCall(MPMStaticsRead(mpm, o));
  PetscFunctionReturn(PETSC_SUCCESS);
}
