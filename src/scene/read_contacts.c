/* read_contacts.c - reads the contact between bodies. A body that a contact names has a copy of the grid's nodes of its own
   (physics/grid.h); all other bodies share one. */
#include "scene/scene.h"

static const char *const normals[] = {"regression", "x", "y", "z"};

/* Adds the pair of the bodies i < j of contact `name`, which may be the only one of -contact_mu. */
static void AddPair(const MPMScene *scene, MPMContacts *c, MPMOptions o, PetscInt i, PetscInt j, MPMPair pair,
                    const char name[])
{
  pair.a = i;
  pair.b = j;
  for (PetscInt k = 0; k < c->npairs; k++)
    if (c->pair[k].a == pair.a && c->pair[k].b == pair.b)
      MPMOptionsFail(o, "-contact_%s_bodies: another contact is between %s and %s too", name, scene->bodies[i].name,
                     scene->bodies[j].name);
  if (!MPMOptionsError(o)) c->pair[c->npairs++] = pair;
}

/* Returns whether a scene has rigid bodies. */
static PetscBool HasRigid(const MPMScene *scene)
{
  for (PetscInt b = scene->nbodies; b < scene->nbodies + scene->nshapes; b++)
    if (scene->bodies[b].rigid != MPM_RIGID_NONE) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Refuses a name that is not one of a body with particles, by what it is. */
static void RefuseBody(const MPMScene *scene, MPMOptions o, const char contact[], const char name[])
{
  char list[MPM_TEXT_LEN / 2] = "";

  for (PetscInt b = scene->nbodies; b < scene->nbodies + scene->nshapes; b++)
    if (!strcmp(scene->bodies[b].name, name) && scene->bodies[b].rigid != MPM_RIGID_NONE)
      MPMOptionsFail(o,
                     "-contact_%s_bodies %s: %s is rigid, and meets all bodies with particles without a contact; its "
                     "friction is -body_%s_mu",
                     contact, name, name, name);
  for (PetscInt b = 0; b < scene->nbodies; b++)
    MPMAppend(list, sizeof list, "%s%s", b ? "," : "", scene->bodies[b].name);
  MPMOptionsFail(o, "-contact_%s_bodies %.100s: choose all, or a list of bodies with particles, of %s", contact, name,
                 list);
}

/* Reads the bodies of a contact: sets in [nbodies] to which they are. */
static PetscErrorCode ReadBodies(const MPMScene *scene, MPMOptions o, const char name[], PetscBool in[])
{
  char     text[MPM_TEXT_LEN] = "all", *save = NULL;
  PetscInt n = 0;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsString(o, "contact_<c>_bodies", name, text, NULL));
  for (PetscInt b = 0; b < scene->nbodies; b++) in[b] = !strcmp(text, "all");
  for (char *w = strcmp(text, "all") ? strtok_r(text, ", ", &save) : NULL; w; w = strtok_r(NULL, ", ", &save)) {
    PetscInt b = 0;

    while (b < scene->nbodies && strcmp(scene->bodies[b].name, w)) b++;
    if (b == scene->nbodies)
      RefuseBody(scene, o, name, w);
    else if (in[b])
      MPMOptionsFail(o, "-contact_%s_bodies names %s twice: a contact is between different bodies", name, w);
    else
      in[b] = PETSC_TRUE;
  }
  for (PetscInt b = 0; b < scene->nbodies; b++) n += in[b];
  if (n < 2)
    MPMOptionsFail(o, "-contact_%s_bodies: a contact needs two bodies with particles or more, not %" PetscInt_FMT "%s",
                   name, n, HasRigid(scene) ? "; rigid bodies need none, and have -body_<b>_mu" : "");
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadContact(MPMScene *scene, const MPMCore *core, MPMContacts *c, MPMOptions o, const char name[],
                                  PetscBool in[])
{
  MPMPair   pair = {.axis = -1};
  char      normal[MPM_NAME_LEN];
  PetscInt  row;
  PetscBool set, stick = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(ReadBodies(scene, o, name, in));
  PetscCall(MPMOptionsReal(o, "contact_<c>_mu", name, &pair.mu, &set));
  PetscCall(MPMOptionsBool(o, "contact_<c>_stick", name, &stick));
  PetscCall(MPMOptionsEnum(o, "contact_<c>_normal", name, normal, NULL));
  if (MPMOptionsError(o)) PetscFunctionReturn(PETSC_SUCCESS);
  if (core->grid.dim == 1 && (stick || pair.mu > 0))
    MPMOptionsFail(o, "-contact_%s_%s does not apply: in 1-D nothing slides", name, stick ? "stick" : "mu");
  if (stick && set)
    MPMOptionsFail(o, "-contact_%s_mu does not apply: -contact_%s_stick lets nothing slide", name, name);
  PetscCall(MPMOptionsFind(normal, 4, normals, &row));
  if (row > core->grid.dim)
    MPMOptionsFail(o, "-contact_%s_normal %s: -dim is %" PetscInt_FMT, name, normal, core->grid.dim);
  pair.axis = row - 1;
  pair.name = name;
  if (stick) pair.mu = PETSC_INFINITY;
  for (PetscInt i = 0; i < scene->nbodies; i++)
    for (PetscInt j = i + 1; j < scene->nbodies; j++)
      if (in[i] && in[j]) AddPair(scene, c, o, i, j, pair, name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives the bodies copies, and adds pairs that are glued for all that no contact names: until now a and b of pairs are
   bodies. */
static PetscErrorCode SetCopies(MPMScene *scene, MPMCore *core, MPMContacts *c, MPMOptions o, PetscBool all)
{
  MPMGrid       *grid     = &core->grid;
  const PetscInt declared = c->npairs;
  PetscInt       shared   = -1;
  PetscBool     *named;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(scene->nbodies, &named));
  for (PetscInt k = 0; k < declared; k++) named[c->pair[k].a] = named[c->pair[k].b] = PETSC_TRUE;
  for (PetscInt b = 0; b < scene->nbodies; b++) {
    if (!named[b] && shared < 0) shared = grid->copies++;
    scene->bodies[b].copy = named[b] ? grid->copies++ : shared;
  }
  c->shared = shared;
  if (grid->copies > MPM_MAX_COPIES)
    MPMOptionsFail(
        o,
        "-contact%s: %" PetscInt_FMT
        " bodies have nodes of their own, %d are allowed; let bodies that do not part from each other be one "
        "body%s",
        all ? "_mu" : "s", grid->copies, MPM_MAX_COPIES, all ? "" : ", or out of contacts");
  for (grid->stack = grid->dim - 1; grid->stack >= 0 && grid->periodic[grid->stack];) grid->stack--;
  if (grid->stack < 0) MPMOptionsFail(o, "-contacts need an axis that is not periodic");
  for (PetscInt k = 0; k < declared; k++) {
    c->pair[k].a = scene->bodies[c->pair[k].a].copy;
    c->pair[k].b = scene->bodies[c->pair[k].b].copy;
  }
  for (PetscInt i = 0; i < grid->copies; i++)
    for (PetscInt j = i + 1; j < grid->copies; j++) {
      PetscInt k = 0;

      while (k < declared && !(c->pair[k].a == i && c->pair[k].b == j)) k++;
      if (k == declared) c->pair[c->npairs++] = (MPMPair){.a = i, .b = j, .axis = -1, .glued = PETSC_TRUE};
    }
  PetscCall(PetscFree(named));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMSceneReadContacts(MPMScene *scene, MPMCore *core, MPMOptions o)
{
  const PetscInt most = scene->nbodies * (scene->nbodies + 1);
  MPMContacts   *c;
  PetscReal      mu  = 0;
  PetscBool      all = PETSC_FALSE, *in;

  PetscFunctionBeginUser;
  PetscCall(MPMOptionsReal(o, "contact_mu", NULL, &mu, &all));
  if (MPMOptionsError(o) || (!all && !scene->ncontacts)) PetscFunctionReturn(PETSC_SUCCESS);
  if (all && core->grid.dim == 1 && mu > 0)
    MPMOptionsFail(o, "-contact_mu %g does not apply: in 1-D nothing slides; use -contact_mu 0", (double)mu);
  if (all && scene->ncontacts)
    MPMOptionsFail(o, "-contact_mu does not apply: -contacts says which bodies meet, and how");
  if (all && scene->nbodies < 2)
    MPMOptionsFail(o, "-contact_mu is between bodies with particles, and %s is the only one; remove it%s",
                   scene->bodies[0].name,
                   HasRigid(scene) ? ": bodies that are rigid have their own friction, -body_<b>_mu" : "");
  PetscCall(PetscNew(&c));
  core->contacts = c;
  PetscCall(PetscCalloc1(most, &c->pair));
  PetscCall(PetscMalloc1(scene->nbodies, &in));
  for (PetscInt i = 0; i < scene->nbodies && all; i++)
    for (PetscInt j = i + 1; j < scene->nbodies; j++) AddPair(scene, c, o, i, j, (MPMPair){.axis = -1, .mu = mu}, "");
  for (PetscInt k = 0; k < scene->ncontacts && !MPMOptionsError(o); k++)
    PetscCall(ReadContact(scene, core, c, o, scene->contacts[k], in));
  if (!MPMOptionsError(o)) PetscCall(SetCopies(scene, core, c, o, all));
  PetscCall(PetscFree(in));
  PetscFunctionReturn(PETSC_SUCCESS);
}
