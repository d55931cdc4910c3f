/* leave.c - bodies that leave at a restart (-remove): an excavation, a gate. Their particles are removed, and what they
   take along counts in the balances, as for particles that leave the grid; rigid bodies meet nothing from then on. */
#include <strings.h>
#include "parallel/exchange.h"
#include "restart/restart.h"
#include "step/step.h"

/* Returns whether a list of names separated by commas has a name. */
static PetscBool Has(const char list[], const char name[])
{
  const size_t length = strlen(name);

  for (const char *at = list; *at; at += strspn(at, ", ")) {
    const size_t n = strcspn(at, ", ");

    if (n == length && !strncasecmp(at, name, n)) return PETSC_TRUE;
    at += n;
  }
  return PETSC_FALSE;
}

/* Lets the rigid body of a name meet nothing, and no longer move. */
static void Release(MPMCore *core, const char name[])
{
  MPMContacts *c    = core->contacts;
  PetscInt     kept = 0;

  for (PetscInt k = 0; k < core->rigids.n; k++) {
    MPMRigid *r = &core->rigids.body[k];

    if (strcmp(r->name, name)) continue;
    r->gone = PETSC_TRUE;
    r->free = r->moves = PETSC_FALSE;
  }
  for (PetscInt k = 0; k < c->npairs; k++)
    if (!c->pair[k].rigid || !c->pair[k].rigid->gone) c->pair[kept++] = c->pair[k];
  c->npairs = kept;
}

PetscErrorCode MPMLeaveSetFromOptions(MPMCheckpoint *c, PetscBool restarts, MPMOptions o)
{
  MPMScene *scene = c->scene;
  PetscInt  n, stay                             = 0;
  char(*names)[MPM_NAME_LEN], was[MPM_TEXT_LEN] = "", is[MPM_TEXT_LEN] = "", time[MPM_NAME_LEN] = "";

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsNames(o, "remove", &n, &names));
  if (n && !restarts)
    MPMOptionsFail(o,
                   "-remove does not apply: bodies leave at a restart (-restart_file); leave the body out of -bodies");
  if (n && c->core->grid.total) {
    PetscCall(PetscOptionsGetString(NULL, NULL, "-method_time", time, sizeof time, NULL));
    MPMOptionsFail(
        o,
        "-remove does not apply in the total frame, whose nodes have the matter of all particles; let the run "
        "go on in the updated one, %s",
        !strcmp(time, "static") ? "with -method_frame updated"
                                : "without -method_frame total and -method_preset solid");
  }
  for (PetscInt k = 0; k < n && !MPMOptionsError(o); k++) {
    MPMBody *body = NULL;

    for (PetscInt b = 0; b < scene->nbodies + scene->nshapes; b++)
      if (!strcasecmp(scene->bodies[b].name, names[k]) &&
          (b < scene->nbodies || scene->bodies[b].rigid != MPM_RIGID_NONE))
        body = &scene->bodies[b];
    if (!body) {
      MPMOptionsFail(o, "-remove %s: the scene has no body of that name with particles, and no rigid one", names[k]);
      break;
    }
    body->removed = PETSC_TRUE;
    MPMAppend(is, sizeof is, "%s,", body->name);
    if (body->rigid != MPM_RIGID_NONE) Release(c->core, body->name);
  }
  for (PetscInt b = 0; b < scene->nbodies; b++) stay += !scene->bodies[b].removed;
  if (n && !stay && !MPMOptionsError(o))
    MPMOptionsFail(o, "-remove %.*s: no particle would be left", (int)strlen(is) - 1, is);
  if (restarts && c->options) (void)MPMOptionsFindIn(c->options, "-remove", was);
  for (PetscInt b = 0; b < scene->nbodies + scene->nshapes; b++)
    if (Has(was, scene->bodies[b].name) && !scene->bodies[b].removed)
      MPMOptionsFail(o,
                     "-remove: %s had left before -restart_file %.500s was written, and cannot come back; name it too",
                     scene->bodies[b].name, c->from);
  PetscCall(PetscFree(names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stops rigid bodies that leave; the energy of free ones leaves with them. */
static void StopRigids(MPMCore *core)
{
  for (PetscInt k = 0; k < core->rigids.n; k++) {
    MPMRigid *r = &core->rigids.body[k];

    if (!r->gone) continue;
    core->changes.energy -= MPMRigidEnergy(r);
    for (PetscInt d = 0; d < 3; d++) r->velocity[d] = r->spin[d] = r->momentum[d] = 0;
  }
}

PetscErrorCode MPMLeave(MPMCheckpoint *c)
{
  MPMCore       *core  = c->core;
  MPMScene      *scene = c->scene;
  const PetscInt all = scene->nbodies + scene->nshapes, fields = MPM_BIT(id) | MPM_BIT(cell);
  PetscInt64     ids;
  PetscBool      any = PETSC_FALSE;
  MPMView        view;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < all; b++) any = any || scene->bodies[b].removed;
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  if (core->rigids.n) StopRigids(core);
  c->left[0] = (PetscReal)core->particles.total;
  c->left[1] = c->monitor->now.sum[MPM_SHOWS_mass][0];
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0, b = 0; p < view.n; p++) {
    b = MPMBodyOf(scene, view.id[p], b);
    if (scene->bodies[b].removed) view.cell[p] = MPM_NOWHERE;
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(MPMLostAdd(scene, core));
  PetscCall(MPMExchangeRemove(core, &ids));
  PetscCall(core->exchange.type->settle(core, PETSC_TRUE));
  PetscCall(MPMContactsSettle(core));
  c->left[0] -= (PetscReal)core->particles.total;
  core->particles.removed += (PetscInt64)c->left[0];
  if (!(c->left[0] > 0)) PetscFunctionReturn(PETSC_SUCCESS); /* they had left before */
  PetscCall(MPMStepBound(core));
  PetscCall(MPMTotalsCompute(scene, core, &c->monitor->now));
  c->left[1] -= c->monitor->now.sum[MPM_SHOWS_mass][0];
  PetscFunctionReturn(PETSC_SUCCESS);
}
