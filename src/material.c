/* material.c - the table of materials, and Lame's constants.                                                         */
#include "mpm.h"

#define MPM_MATERIAL(name, traits, parameters, what) extern const MPMMaterialLaw MPMMaterialLaw_##name;
#include "material.def"
#undef MPM_MATERIAL

const MPMMaterialType MPMMaterialTypes[] = {
#define MPM_MATERIAL(name, traits, parameters, what) {#name, parameters, what, traits, &MPMMaterialLaw_##name},
#include "material.def"
#undef MPM_MATERIAL
    {NULL, NULL, NULL, 0, NULL}};

void MPMMaterialSetUp(MPMMaterial *m)
{
  m->lambda = m->E * m->nu / ((1 + m->nu) * (1 - 2 * m->nu));
  m->mu     = m->E / (2 * (1 + m->nu));
}
