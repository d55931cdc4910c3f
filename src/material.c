/* material.c - the table of materials, and Lame's constants.                                                         */
#include "mpm.h"

#define MPM_MATERIAL(name, traits, parameters, state, what) extern const MPMMaterialLaw MPMMaterialLaw_##name;
#include "material.def"
#undef MPM_MATERIAL

const MPMMaterialType MPMMaterialTypes[] = {
#define MPM_MATERIAL(name, traits, parameters, state, what)                                                            \
  {#name, parameters, state, what, traits, &MPMMaterialLaw_##name},
#include "material.def"
#undef MPM_MATERIAL
    {NULL, NULL, NULL, NULL, 0, NULL}};

/* Does a list of words, separated by blanks, hold this one? */
PetscBool MPMListHas(const char list[], const char word[])
{
  const size_t n = strlen(word);

  for (const char *at = strstr(list, word); at; at = strstr(at + 1, word))
    if ((at == list || at[-1] == ' ') && (at[n] == 0 || at[n] == ' ')) return PETSC_TRUE;
  return PETSC_FALSE;
}

const char *MPMMaterialSetUp(MPMMaterial *m)
{
  m->state = 0;
#define MPM_MATERIAL_STATE(name, rows)                                                                                 \
  if (MPMListHas(m->type->state, #name)) m->state |= MPM_BIT(name);
  MPM_MATERIAL_FIELDS(MPM_MATERIAL_STATE)
#undef MPM_MATERIAL_STATE
  m->lambda = m->E * m->nu / ((1 + m->nu) * (1 - 2 * m->nu));
  m->mu     = m->E / (2 * (1 + m->nu));
  return m->type->law->setup ? m->type->law->setup(m) : NULL;
}
