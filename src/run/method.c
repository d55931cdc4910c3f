/* method.c - reads the options of how a run is made: basis, update, transfer, time steps; and those of the study that
   it is a part of. It is used before the first step. */
#include "run/mpm.h"

/* Reads the update and the transfer, with the options that only some transfers have. */
static PetscErrorCode ReadTransfer(MPM mpm, MPMOptions o)
{
  MPMCore           *core = &mpm->core;
  const MPMTransfer *transfer;
  char               update[MPM_NAME_LEN], name[MPM_NAME_LEN];
  PetscBool          flip_set, order_set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "method_update", NULL, update, NULL));
  PetscCall(MPMOptionsEnum(o, "method_transfer", NULL, name, NULL));
  PetscCall(MPMOptionsReal(o, "method_flip", NULL, &core->params.flip, &flip_set));
  PetscCall(MPMOptionsInt(o, "method_order", NULL, &core->params.order, &order_set));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  for (mpm->method.scheme = MPMSchemes; strcmp(mpm->method.scheme->name, update);) mpm->method.scheme++;
  for (transfer = MPMTransfers; strcmp(transfer->name, name);) transfer++;
  mpm->method.transfer = transfer;
  if (transfer->flip >= 0) {
    if (flip_set && !MPMOptionsOverridden("method_flip", "method_transfer"))
      MPMOptionsFail(o, "-method_flip does not apply: -method_transfer %s has no share of FLIP", name);
    core->params.flip = transfer->flip;
  }
  if (transfer->rounds == MPM_NO_ROUNDS) {
    if (order_set && !MPMOptionsOverridden("method_order", "method_transfer"))
      MPMOptionsFail(o, "-method_order does not apply: it is the order of -method_transfer xpic or afmpm");
    core->params.order = 0;
  }
  core->needs.increment = mpm->method.scheme->keeps_increment;
  core->needs.affine    = transfer->parts & MPM_AFFINE ? PETSC_TRUE : PETSC_FALSE;
  core->needs.residual  = transfer->rounds != MPM_NO_ROUNDS ? PETSC_TRUE : PETSC_FALSE;
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
  char      basis[MPM_NAME_LEN], wall[MPM_NAME_LEN], gimp[MPM_NAME_LEN], inertia[MPM_NAME_LEN];
  PetscBool wall_set, gimp_set, inertia_set, affine;
  PetscInt  row;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "method_basis", NULL, basis, NULL));
  PetscCall(MPMOptionsEnum(o, "method_wall_basis", NULL, wall, &wall_set));
  PetscCall(MPMOptionsEnum(o, "method_gimp_update", NULL, gimp, &gimp_set));
  PetscCall(MPMOptionsEnum(o, "method_wall_inertia", NULL, inertia, &inertia_set));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMOptionsFind(basis, MPM_NUM_BASES, MPMBasisNames, &row));
  core->basis = (MPMBasis)row;
  affine = MPMBasisIsSpline(core->basis) && core->needs.affine && !strcmp(wall, "extrap") ? PETSC_TRUE : PETSC_FALSE;
  core->needs.stretched = core->basis == MPM_BASIS_gimp && !strcmp(gimp, "stretch") ? PETSC_TRUE : PETSC_FALSE;
  if (wall_set && !MPMBasisIsSpline(core->basis) && !MPMOptionsOverridden("method_wall_basis", "method_basis"))
    MPMOptionsFail(o, "-method_wall_basis does not apply: it is for the splines, -method_basis is %s", basis);
  if (gimp_set && core->basis != MPM_BASIS_gimp && !MPMOptionsOverridden("method_gimp_update", "method_basis"))
    MPMOptionsFail(o, "-method_gimp_update does not apply: -method_basis is %s", basis);
  core->params.own_inertia = affine && !strcmp(inertia, "own") ? PETSC_TRUE : PETSC_FALSE;
  if (inertia_set && !affine && !MPMOptionsOverridden("method_wall_inertia", "method_basis") &&
      !MPMOptionsOverridden("method_wall_inertia", "method_transfer"))
    MPMOptionsFail(o, "-method_wall_inertia does not apply: it is for affine velocities with splines of form extrap");
  for (PetscInt k = 0; k < mpm->scene.nmaterials; k++)
    if (core->needs.stretched && !(mpm->scene.materials[k].state & MPM_BIT(F)))
      MPMOptionsFail(o, "-method_gimp_update stretch does not apply: material %s (%s) has no deformation gradient",
                     mpm->scene.materials[k].name, mpm->scene.materials[k].type->name);
  for (PetscInt d = 0; d < core->grid.dim; d++)
    core->grid.wall_basis[d] = core->grid.periodic[d]     ? MPM_WALL_BASIS_NONE
                               : !strcmp(wall, "steffen") ? MPM_WALL_BASIS_STEFFEN
                                                          : MPM_WALL_BASIS_EXTRAP;
  MPMGridSetNodes(&core->grid, core->basis);
  CheckNodes(core, o);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadTime(MPM mpm, MPMOptions o)
{
  char      size[MPM_TEXT_LEN];
  PetscBool set;

  PetscFunctionBeginUser;
  mpm->time.max_steps = PETSC_MAX_INT;
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
  PetscCall(ReadTransfer(mpm, o));
  PetscCall(ReadBasis(mpm, o));
  PetscCall(ReadTime(mpm, o));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reads -study_*; the first fault is left in o. */
PetscErrorCode MPMStudySetFromOptions(MPM mpm, MPMOptions o)
{
  MPMStudy *study = &mpm->study;
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "study_type", NULL, study->type, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!strcmp(study->type, "none")) {
    study->type[0] = 0;
    if (mpm->scene.finest)
      MPMOptionsFail(o, "-reference_type finest does not apply: it is the last run of a -study_type");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  study->order_min = PETSC_MIN_REAL;
  PetscCall(MPMOptionsInt(o, "study_levels", NULL, &study->levels, NULL));
  PetscCall(MPMOptionsEnum(o, "study_vary", NULL, study->vary, NULL));
  PetscCall(MPMOptionsReal(o, "study_order_min", NULL, &study->order_min, &set));
  if (!mpm->scene.known && !mpm->scene.finest)
    MPMOptionsFail(
        o, "-study_type %s needs a solution to compare with: -mms_type, or -reference_type (finest: the last run)",
        study->type);
  if (mpm->time.max_steps != PETSC_MAX_INT)
    MPMOptionsFail(o, "-time_max_steps does not apply: the runs of a study end at the same time, -time_end");
  if (mpm->scene.finest && set && study->levels < 3)
    MPMOptionsFail(o,
                   "-study_levels %" PetscInt_FMT " leaves no order for -study_order_min where the finest run is the "
                   "reference; it needs 3",
                   study->levels);
  if (mpm->scene.finest && !strcmp(study->vary, "ppc"))
    MPMOptionsFail(o, "-study_vary ppc does not apply: -reference_type finest compares grids and time steps");
  PetscFunctionReturn(PETSC_SUCCESS);
}
