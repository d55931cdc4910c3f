/* frame.c - reads the options of the total frame and of static steps, and refuses by name what they cannot do. It is used
   before the first step. */
#include "run/mpm.h"
#include "scene/points.h"

/* Options of the updated frame, the value that does no harm in the total one, and why others do not apply there. */
static const struct {
  const char *name, *neutral, *why;
} updated[] = {
    {"method_update", NULL, "a step is one of leapfrog"},
    {"method_transfer", NULL, "no velocity is mapped between particles and nodes"},
    {"method_flip", NULL, "no velocity is mapped between particles and nodes"},
    {"method_affine_strain", NULL, "no velocity is mapped between particles and nodes"},
    {"method_order", NULL, "-method_mass_order is its order"},
    {"method_damping_viscosity", NULL, "no velocity is mapped between particles and nodes; use -method_damping_rate"},
    {"method_wall_inertia", NULL, "no velocity is mapped between particles and nodes"},
    {"method_gimp_update", "none", "the domains of particles are those of the start"},
    {"method_light_nodes", "0", "weights do not change, and light nodes do no harm"},
    {"method_carry", "needed", "it is for the updated frame"},
    {"initial_stress", "none", "particles are undeformed at the start"},
    {"check_parting", NULL, "its bodies cannot come apart"},
    {"particles_leave", "stop", "the nodes have the matter of all particles, which cannot be removed"},
    {"parallel_balance", "start", "no particle changes process, and the cuts of the start stay the best"}};

/* Returns whether steps are static and in the updated frame, once the frame is known. */
PetscBool MPMFrameRests(const MPM mpm)
{
  char time[MPM_NAME_LEN] = "";

  (void)PetscOptionsGetString(NULL, NULL, "-method_time", time, sizeof time, NULL);
  return !mpm->core.grid.total && !strcmp(time, "static");
}

/* Removes an option of a file if another one, `by`, that it does not go with was given on the command line, and adds it
   to mpm->aside. */
PetscErrorCode MPMMethodPutAside(MPM mpm, const char name[], const char by[])
{
  const size_t n = strlen(mpm->aside);
  char         full[MPM_NAME_LEN], value[MPM_TEXT_LEN] = "";
  PetscBool    given;

  PetscFunctionBeginUser;
  (void)snprintf(full, sizeof full, "-%s", name);
  PetscCall(PetscOptionsGetString(NULL, NULL, full, value, sizeof value, &given));
  if (!given || !MPMOptionsOverridden(name, by)) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(mpm->aside + n, sizeof mpm->aside - n, "%s%s %s", n ? " " : "", full, value);
  PetscCall(PetscOptionsClearValue(NULL, full));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* If only the total frame or a preset of it is given on the command line, the method that a file has for the updated
   frame stands aside, so that the file of any scene serves both. It is removed here, so that the results of the run do
   not have it either. */
PetscErrorCode MPMFrameSetFromOptions(MPM mpm)
{
  const char *const by[]   = {"method_frame", "method_preset", "method_time"};
  const char *const more[] = {"method_damping_rate", "method_basis", "dt_cfl"};

  PetscFunctionBeginUser;
  if (!mpm->core.grid.total) PetscFunctionReturn(PETSC_SUCCESS);
  for (size_t j = 0; j < sizeof by / sizeof by[0]; j++) {
    for (size_t k = 0; k < sizeof updated / sizeof updated[0]; k++)
      if (!strncmp(updated[k].name, "method_", 7)) PetscCall(MPMMethodPutAside(mpm, updated[k].name, by[j]));
    for (size_t k = 0; k < sizeof more / sizeof more[0] && mpm->aside[0]; k++)
      PetscCall(MPMMethodPutAside(mpm, more[k], by[j]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses what the total frame cannot do, or static steps of the updated one, by name and with the reason. */
PetscErrorCode MPMFrameCheck(MPM mpm, MPMOptions o)
{
  const MPMScene *scene = &mpm->scene;
  PetscBool       framed, implicit;
  char            by[2 * MPM_NAME_LEN], *use = mpm->watch.use, time[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-method_time", time, sizeof time, NULL));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-method_frame", &framed));
  implicit = time[0] && strcmp(time, "explicit");
  (void)snprintf(by, sizeof by, "-method_%s %s",
                 implicit ? "time"
                 : framed ? "frame"
                          : "preset",
                 implicit ? time
                 : framed ? "total"
                          : mpm->preset->name);
  (void)snprintf(use, sizeof mpm->watch.use, "%s",
                 !strcmp(time, "static") ? "-method_time explicit with -damping_time"
                 : implicit              ? "-method_time explicit"
                 : !framed               ? "-method_preset balanced"
                 : mpm->preset_given     ? "-method_preset balanced -method_frame updated"
                                         : "-method_frame updated");
  for (size_t k = 0; k < sizeof updated / sizeof updated[0] && mpm->core.grid.total; k++)
    PetscCall(MPMOptionsRefuse(o, updated[k].name, updated[k].neutral, by, updated[k].why));
  for (PetscInt k = 0; k < scene->nmaterials; k++)
    if (scene->materials[k].type->traits & MPM_FLUID)
      MPMOptionsFail(o, "-material_%s_model %s does not apply with %s: %s; use %s", scene->materials[k].name,
                     scene->materials[k].type->name, by,
                     mpm->core.grid.total ? "what flows leaves the shape of the start, on which the weights are"
                                          : "it has no stiffness in shear",
                     use);
  for (PetscInt k = 0; k < 2 * mpm->core.grid.dim; k++) {
    const MPMWall type = scene->walls.given[k / 2][k % 2].type;

    if (type == MPM_WALL_separate && (!strcmp(time, "static") || !strcmp(time, "euler")))
      continue; /* a bound of nodes */
    if (MPMWallHas(type, MPM_WALL_PUSHES) || type == MPM_WALL_piston)
      MPMOptionsFail(
          o,
          "-bc_%s_type %s does not apply with %s, which has no contact: the wall acts on matter that arrives "
          "at it; choose fixed, slip, moving or free, or use %s",
          MPMFaceNames[k], MPMWallNames[type], by,
          type == MPM_WALL_separate && !strcmp(time, "newmark") ? "-method_time euler" : use);
  }
  if (mpm->core.rigids.n)
    MPMOptionsFail(o, "-body_%s_rigid does not apply with %s, whose bodies may meet nothing; use %s",
                   mpm->core.rigids.body[0].name, by, use);
  if (scene->ncontacts || mpm->core.contacts)
    MPMOptionsFail(o, "contact does not apply with %s, whose bodies may meet nothing; use %s", by, use);
  for (PetscInt b = 0; b < scene->nbodies; b++) {
    if (scene->bodies[b].points && scene->bodies[b].points->deformation)
      MPMOptionsFail(o, "-body_%s_file does not apply with %s: its particles are deformed at the start",
                     scene->bodies[b].name, by);
    for (PetscInt d = 0; d < mpm->core.grid.dim && !scene->bodies[b].points; d++)
      if (scene->bodies[b].ppc[d] < 2)
        MPMOptionsFail(o,
                       "-body_%s_ppc: with %s a body needs 2 particles a cell on each axis; with 1, nodes can move so "
                       "that no particle is strained",
                       scene->bodies[b].name, by);
  }
  /* What is advised where bodies meet, later: motion is not wanted. */
  if (!strcmp(time, "static")) (void)snprintf(use, sizeof mpm->watch.use, "-method_frame updated");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the method of the total frame, after the basis, and of static steps in the updated one; the options of explicit steps
   there, which are refused or stand aside, are read all the same, so that their values are checked. */
PetscErrorCode MPMFrameRead(MPM mpm, MPMOptions o)
{
  MPMCore  *core = &mpm->core;
  PetscBool set, rests;

  PetscFunctionBeginUser;
  mpm->method.mass = MPMBasisIsSpline(core->basis) ? mpm->preset->mass : 1;
  PetscCall(MPMOptionsInt(o, "method_mass_order", NULL, &mpm->method.mass, &set));
  rests = MPMFrameRests(mpm);
  if (!core->grid.total && !rests) {
    mpm->method.mass = 0;
    if (set && !MPMOptionsOverridden("method_mass_order", "method_frame"))
      MPMOptionsFail(o,
                     "-method_mass_order does not apply: -method_frame is updated; there, -method_transfer afmpm has "
                     "the full mass matrix to -method_order");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  mpm->method.scheme   = rests ? &MPMSchemeStatic : &MPMSchemeTotal;
  mpm->method.transfer = rests ? &MPMTransferStatic : &MPMTransferTotal;
  PetscCall(MPMOptionsReal(o, "method_damping_rate", NULL, &mpm->method.rate, &set));
  if (!set) mpm->method.rate = mpm->preset->rate;
  mpm->method.viscosity    = 0;
  core->params.flip        = mpm->method.transfer->flip;
  core->params.strain      = 1;
  core->params.light       = 0;
  core->params.order       = 0;
  core->params.own_inertia = PETSC_FALSE;
  core->needs.increment = core->needs.affine = core->needs.residual = core->needs.all = PETSC_FALSE;
  for (PetscInt k = 0; k < mpm->scene.nmaterials; k++) mpm->scene.materials[k].relaxation = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
