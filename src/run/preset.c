/* preset.c - the named methods of -method_preset: rows of preset.def. The name is read before the scene, since it says
   in which frame the state is and how many particles bodies have; the row is chosen after it, by the materials. */
#include "run/mpm.h"

static const MPMPreset rows[] = {
#define MPM_PRESET_NAME(name, what, expect, collision, contact)
#define MPM_PRESET(name, scenes, basis, stretch, update, transfer, strain, rate, cfl, ppc)                             \
  {#name, MPM_SCENES_##scenes, PETSC_FALSE, 0, #basis, stretch, #update, #transfer, strain, rate, cfl, ppc},
#define MPM_PRESET_TOTAL(name, scenes, basis, mass, rate, cfl, ppc)                                                    \
  {#name, MPM_SCENES_##scenes, PETSC_TRUE, mass, #basis, PETSC_FALSE, "musl", "flip", 0, rate, cfl, ppc},
#include "run/preset.def"
};

static const struct {
  const char *name, *expect, *collision, *contact;
} names[] = {
#define MPM_PRESET_NAME(name, what, expect, collision, contact) {#name, expect, collision, contact},
#define MPM_PRESET(...)
#define MPM_PRESET_TOTAL(...)
#include "run/preset.def"
};

/* Reads the name of the preset, or takes that of the frame that is asked for, and sets the frame and the default of the
   particles per cell. Where the two differ, that of a file stands aside. The first fault is left in o. */
PetscErrorCode MPMPresetRead(MPM mpm, MPMOptions o)
{
  char      name[MPM_NAME_LEN], frame[MPM_NAME_LEN], time[MPM_NAME_LEN];
  PetscBool framed, total;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "method_preset", NULL, name, &mpm->preset_given));
  PetscCall(MPMOptionsEnum(o, "method_frame", NULL, frame, &framed));
  PetscCall(MPMOptionsEnum(o, "method_time", NULL, time, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (strcmp(time, "explicit") != 0) { /* a method of a file for steps in time stands aside */
    PetscCall(MPMMethodPutAside(mpm, "method_frame", "method_time"));
    PetscCall(MPMMethodPutAside(mpm, "method_preset", "method_time"));
    PetscCall(MPMOptionsEnum(o, "method_frame", NULL, frame, &framed));
    PetscCall(MPMOptionsEnum(o, "method_preset", NULL, name, &mpm->preset_given));
    if (framed && strcmp(frame, "total") && strcmp(time, "static"))
      MPMOptionsFail(
          o,
          "-method_frame %s does not apply with -method_time %s, which is built for the total frame: leave it out, or take "
          "-method_time explicit, or static",
          frame, time);
    for (mpm->preset = rows; strcmp(mpm->preset->name, name);) mpm->preset++;
    if (mpm->preset_given && !mpm->preset->total)
      MPMOptionsFail(
          o,
          "-method_preset %s does not apply with -method_time %s, which is built for the total frame; leave it out, or take solid",
          name, time);
    if (!framed && !mpm->preset_given) framed = PETSC_TRUE, (void)snprintf(frame, sizeof frame, "total");
  }
  total = (PetscBool)(!strcmp(frame, "total"));
  for (mpm->preset = rows; strcmp(mpm->preset->name, name);) mpm->preset++;
  if (framed && total != mpm->preset->total) {
    if (mpm->preset_given && MPMOptionsOverridden("method_frame", "method_preset"))
      PetscCall(MPMMethodPutAside(mpm, "method_frame", "method_preset"));
    else if (mpm->preset_given && !MPMOptionsOverridden("method_preset", "method_frame"))
      MPMOptionsFail(o,
                     "-method_frame %s does not apply with -method_preset %s, a method of the other frame: leave one "
                     "of them out",
                     frame, name);
    else {
      PetscCall(MPMMethodPutAside(mpm, "method_preset", "method_frame"));
      PetscCall(MPMOptionsEnum(o, "method_preset", NULL, name, &mpm->preset_given));
      for (mpm->preset = rows; total ? !mpm->preset->total : strcmp(mpm->preset->name, name) != 0;) mpm->preset++;
    }
  }
  mpm->core.grid.total = mpm->preset->total;
  mpm->scene.ppc = mpm->scene.ppc_gas = mpm->preset->ppc;
  for (const MPMPreset *row = mpm->preset; row < rows + sizeof rows / sizeof *rows && !strcmp(row->name, name); row++)
    if (row->scenes == MPM_SCENES_gases) mpm->scene.ppc_gas = row->ppc;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the row of the preset by the materials, which have been read. */
void MPMPresetChoose(MPM mpm)
{
  PetscBool fits[] = {PETSC_TRUE, PETSC_TRUE, PETSC_TRUE, PETSC_TRUE}; /* by MPMScenes */

  for (PetscInt k = 0; k < mpm->scene.nmaterials; k++) {
    const MPMMaterial *m      = &mpm->scene.materials[k];
    const PetscInt     traits = m->type->traits;

    if (!(traits & (MPM_SMALL_STRAIN | MPM_HYPERELASTIC))) fits[MPM_SCENES_elastic] = PETSC_FALSE;
    if (!MPMMaterialIsGas(m)) fits[MPM_SCENES_gases] = PETSC_FALSE;
    if (!(traits & MPM_FLUID)) fits[MPM_SCENES_fluids] = PETSC_FALSE;
  }
  while (!fits[mpm->preset->scenes]) mpm->preset++;
}

/* Prints the remedies that are on, which a scene that gives basis, update and transfer has to ask for. */
static PetscErrorCode PrintRemedies(const MPM mpm)
{
  const MPMCore *core = &mpm->core;

  PetscFunctionBeginUser;
  if (mpm->scene.ncut) PetscCall(MPMPrint(&core->print, " -method_rim cut"));
  if (core->params.light > 0) PetscCall(MPMPrint(&core->print, " -method_light_nodes %g", (double)core->params.light));
  if (core->params.box)
    PetscCall(MPMPrint(&core->print, " -method_locking fbar -method_lock_share %g", (double)core->params.lock_share));
  for (PetscInt k = 0; k < mpm->scene.nmaterials; k++) {
    const MPMMaterial *m = &mpm->scene.materials[k];

    if (MPMListHas(m->type->parameters, "relaxation") && m->relaxation > 0)
      PetscCall(MPMPrint(&core->print, " -material_%s_relaxation %g", m->name, (double)m->relaxation));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Prints the preset and what it stands for in this scene, unless all of the method was given without one. */
PetscErrorCode MPMPresetPrint(MPM mpm)
{
  PetscBool given, own, any;
  size_t    of = 0;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsMethodGiven(&own, &any));
  if ((own && !mpm->preset_given) || mpm->core.needs.stepped) PetscFunctionReturn(PETSC_SUCCESS);
  while (strcmp(names[of].name, mpm->preset->name)) of++;
  PetscCall(MPMPrint(&mpm->core.print, "preset     %s:%s -method_basis %s", mpm->preset->name,
                     mpm->preset->total ? " -method_frame total" : "", MPMBasisNames[mpm->core.basis]));
  if (mpm->preset->total)
    PetscCall(MPMPrint(&mpm->core.print, " -method_mass_order %" PetscInt_FMT, mpm->method.mass));
  else
    PetscCall(MPMPrint(&mpm->core.print, "%s -method_update %s -method_transfer %s",
                       mpm->core.needs.stretched ? " -method_gimp_update stretch" : "", mpm->method.scheme->name,
                       mpm->method.transfer->name));
  if (mpm->method.transfer->flip < 0 && (mpm->method.transfer->parts & MPM_AFFINE))
    PetscCall(MPMPrint(&mpm->core.print, " -method_affine_strain %g", (double)mpm->core.params.strain));
  if (mpm->method.rate > 0) PetscCall(MPMPrint(&mpm->core.print, " -method_damping_rate %g", (double)mpm->method.rate));
  PetscCall(PrintRemedies(mpm));
  for (PetscInt b = 0; b < mpm->scene.nbodies; b++) {
    char name[2 * MPM_NAME_LEN];

    (void)snprintf(name, sizeof name, "-body_%s_ppc", mpm->scene.bodies[b].name);
    PetscCall(PetscOptionsHasName(NULL, NULL, name, &given));
    if (given || mpm->scene.bodies[b].ppc[0] == 2) continue;
    PetscCall(MPMPrint(&mpm->core.print, " %s", name));
    for (PetscInt d = 0; d < mpm->core.grid.dim; d++)
      PetscCall(MPMPrint(&mpm->core.print, "%s%" PetscInt_FMT, d ? "," : " ", mpm->scene.bodies[b].ppc[d]));
  }
  if (!(mpm->time.fixed > 0)) PetscCall(MPMPrint(&mpm->core.print, " -dt_cfl %g", (double)mpm->time.cfl));
  PetscCall(MPMPrint(&mpm->core.print, "\n"));
  if (!any && mpm->preset->scenes == MPM_SCENES_elastic)
    PetscCall(MPMPrint(&mpm->core.print, "           %s; %s%s\n", names[of].expect,
                       mpm->preset->total ? "" : "a collision loses ",
                       mpm->core.contacts ? names[of].contact : names[of].collision));
  PetscFunctionReturn(PETSC_SUCCESS);
}
