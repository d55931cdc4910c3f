/* statics.c - reads the options of implicit steps, without inertia (-method_time static) and with it (euler, newmark), and refuses
   by name what they cannot do. It is used before the first step. */
#include "run/mpm.h"
#include "step/static.h"

#define STEPS 10 /* of a load, if -dt_size does not say how long they are */

/* Options that do not apply, the value that does no harm, and why; of some without inertia, `rest`, another reason, or "" where they apply. */
static const struct {
  const char *name, *neutral, *rest, *why;
} refused[] = {
    {"method_mass_order", NULL, "nothing is accelerated", "implicit steps have the full mass matrix"},
    {"method_damping_rate", "0", "nothing moves that could be damped",
     "it is of explicit steps; euler damps by itself"},
    {"damping_time", NULL, "nothing moves that could be damped",
     "it is of explicit steps; static finds the state at rest"},
    {"damping_kinetic", "false", "nothing moves that could be damped",
     "it is of explicit steps; static finds the state at rest"},
    {"dt_cfl", NULL, "no wave is followed; -dt_size is the length of a step of the load",
     "no wave limits the step; give -dt_size"},
    {"method_lock_cells", "1", NULL, "the means of a box of cells are not in its tangent; leave it out, for one cell"},
    {"history_energy", "false", "", "its terms are those of explicit steps"},
    {"check_energy", "0", NULL, "the work of loads is that of steps, and not exact"},
    {"check_momentum", "0", "there is no momentum", "the impulse of loads is that of steps, and not exact"},
    {"mms_type", "none", "known solutions are of motions in time", NULL},
    {"reference_type", "none", "known solutions are of motions in time", NULL}};

/* Options of explicit steps in the updated frame, and the value that does no harm in static ones. */
static const char *const moving[][2] = {
    {"method_update", NULL},        {"method_transfer", NULL},   {"method_flip", NULL},
    {"method_affine_strain", NULL}, {"method_order", NULL},      {"method_damping_viscosity", NULL},
    {"method_wall_inertia", NULL},  {"method_light_nodes", "0"}, {"method_carry", "needed"},
    {"initial_stress", "none"},     {"particles_leave", "stop"}, {"sources", "none"},
    {"parallel_balance", "start"}};

/* Refuses what a scene has that steps without inertia, or implicit ones with it, cannot do. */
static PetscErrorCode Refuse(MPM mpm, const char time[], MPMOptions o)
{
  const MPMScene *scene                  = &mpm->scene;
  const PetscBool rest                   = (PetscBool)!strcmp(time, "static");
  PetscBool       held                   = PETSC_FALSE;
  char            strategy[MPM_NAME_LEN] = "", by[2 * MPM_NAME_LEN], size[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  (void)snprintf(by, sizeof by, "-method_time %s", time);
  for (size_t k = 0; k < sizeof refused / sizeof refused[0]; k++) {
    const char *why = rest && refused[k].rest ? refused[k].rest : refused[k].why;

    if (why && why[0]) PetscCall(MPMOptionsRefuse(o, refused[k].name, refused[k].neutral, by, why));
  }
  for (size_t k = 0; k < sizeof moving / sizeof moving[0] && !mpm->core.grid.total; k++)
    PetscCall(MPMOptionsRefuse(o, moving[k][0], moving[k][1], by, "nothing moves in time"));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-parallel_strategy", strategy, sizeof strategy, NULL));
  if (!strcmp(strategy, "pool"))
    MPMOptionsFail(
        o, "-parallel_strategy pool does not apply with %s: each iteration would send all particles; use spatial", by);
  PetscCall(MPMOptionsString(o, "dt_size", NULL, size, NULL));
  if (!rest && !strcmp(size, "auto")) MPMOptionsFail(o, "%s needs -dt_size, a number: no wave limits the step", by);
  if (!rest) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < scene->nbodies; b++) {
    char      name[2 * MPM_NAME_LEN];
    PetscBool given;

    (void)snprintf(name, sizeof name, "-body_%s_velocity", scene->bodies[b].name);
    PetscCall(PetscOptionsHasName(NULL, NULL, name, &given));
    if (given) MPMOptionsFail(o, "%s does not apply with -method_time static: nothing moves", name);
  }
  for (PetscInt k = mpm->core.grid.round ? 2 : 0; k < 2 * mpm->core.grid.dim; k++) /* the axis is no support */
    if (MPMWallHas(scene->walls.given[k / 2][k % 2].type, MPM_WALL_NORMAL))
      held = PETSC_TRUE; /* separate: while it presses */
  if (!held)
    MPMOptionsFail(o,
                   "-method_time static needs a wall that holds the body, or it is in equilibrium wherever it is: "
                   "choose -bc_<f>_type fixed, slip or moving%s",
                   mpm->core.grid.round ? " of ymin or ymax" : "");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticsRead(MPM mpm, MPMOptions o)
{
  char      time[MPM_NAME_LEN];
  PetscBool set;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsEnum(o, "method_time", NULL, time, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (!strcmp(time, "explicit")) {
    static const char *const only[] = {"gravity_ramp", "dt_strain", "method_stabilize_factor", "method_stabilize_fill",
                                       "method_gamma"};

    for (size_t k = 0; k < sizeof only / sizeof only[0]; k++) {
      char name[MPM_NAME_LEN];

      (void)snprintf(name, sizeof name, "-%s", only[k]);
      PetscCall(PetscOptionsHasName(NULL, NULL, name, &set));
      if (set && !MPMOptionsOverridden(only[k], "method_time"))
        MPMOptionsFail(o, "%s does not apply: it is of implicit steps, -method_time %s", name,
                       !strcmp(only[k], "method_gamma") ? "newmark" : "static, euler or newmark");
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Refuse(mpm, time, o));
  PetscCall(MPMStaticSetFromOptions(&mpm->core, &mpm->scene, &mpm->time, o));
  mpm->method.rate = 0;
  if (!(mpm->time.fixed > 0)) mpm->time.fixed = mpm->time.end / STEPS;
  PetscFunctionReturn(PETSC_SUCCESS);
}
