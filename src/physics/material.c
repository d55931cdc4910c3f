/* material.c - the table of material laws, and the set-up of a material's constants. */
#include "physics/material.h"

#define MPM_MATERIAL(name, traits, parameters, state, what) extern const MPMMaterialLaw MPMMaterialLaw_##name;
#include "physics/material.def"

const MPMMaterialType MPMMaterialTypes[] = {
#define MPM_MATERIAL(name, traits, parameters, state, what)                                                            \
  {#name, parameters, state, what, traits, &MPMMaterialLaw_##name},
#include "physics/material.def"
    {NULL, NULL, NULL, NULL, 0, NULL}};

const char *MPMMaterialSetUp(MPMMaterial *m)
{
  m->state = 0;
  m->skew  = PETSC_FALSE;
#define MPM_MATERIAL_STATE(name, rows)                                                                                 \
  if (MPMListHas(m->type->state, #name)) m->state |= MPM_BIT(name);
  MPM_MATERIAL_FIELDS(MPM_MATERIAL_STATE)
#undef MPM_MATERIAL_STATE
  if (MPMListHas(m->type->state, "F|J")) m->state |= MPM_BIT(F);
  m->lambda      = m->E * m->nu / ((1 + m->nu) * (1 - 2 * m->nu));
  m->mu          = m->E / (2 * (1 + m->nu));
  m->diffusivity = 4. / 3 * m->viscosity / m->rho; /* a law with other viscosities sets its own */
  return m->type->law->setup ? m->type->law->setup(m) : NULL;
}

void MPMMaterialDropF(MPMMaterial *m)
{
  if (MPMListHas(m->type->state, "F|J")) m->state = (m->state & ~(MPM_BIT(F) | MPM_BIT(F33))) | MPM_BIT(J);
}

PetscInt MPMMaterialAsked(const MPMMaterial *m)
{
  PetscInt fields = 0;

#define MPM_MATERIAL_ASKED(name, rows)                                                                                 \
  if (m->asked && MPMListHas(m->type->state, #name "?")) fields |= MPM_BIT(name);
  MPM_MATERIAL_FIELDS(MPM_MATERIAL_ASKED)
#undef MPM_MATERIAL_ASKED
  return fields;
}

void MPMMaterialKeep(MPMMaterial *m, PetscInt fields)
{
  if (fields & MPM_BIT(tau) && MPMListHas(m->type->state, "tau"))
    m->state |= MPM_BIT(tau); /* of a fluid without viscosity */
  if (!(MPMMaterialAsked(m) & fields & ~m->state)) return;
  m->state |= MPMMaterialAsked(m);
  m->own     = *m->type;
  m->own.law = m->asked;
  m->type    = &m->own;
}

void MPMMaterialState(PetscInt dim, const MPMView *view, PetscInt p, MPMBlock *b)
{
#define MPM_STATE_OF(name, rows)                                                                                       \
  if (view->name)                                                                                                      \
    for (int k = 0; k < MPMComponents_##name((int)dim); k++)                                                           \
      b->name[k][0] = view->name[p * MPMComponents_##name((int)dim) + k];
  MPM_MATERIAL_FIELDS(MPM_STATE_OF)
#undef MPM_STATE_OF
}

PetscBool MPMMaterialKeepsShape(const MPMMaterial *m)
{
  return !(m->type->traits & MPM_LOOSE);
}

PetscBool MPMMaterialKnowsFlow(const MPMMaterial *m)
{
  return m->type->traits & MPM_PLASTIC && m->state & MPM_BIT(ep);
}
