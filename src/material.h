/* material.h - turns a law for one point into the block functions of its row.

   A material file defines three inlined functions of one point and ends with MPM_MATERIAL_DEFINE(name):
     <name>_stress(dim, material, F, tau)   Kirchhoff stress [6] in Pa
     <name>_energy(dim, material, F)        strain energy per reference volume in J/m^3
     <name>_speed2(dim, material, F)        upper bound of the squared wave speed in m^2/s^2 */
#ifndef MPM_MATERIAL_H
#define MPM_MATERIAL_H

#include "mpm.h"

MPM_INLINE void MPMLoadF(int dim, PetscInt p, const PetscReal *block, PetscReal F[])
{
  for (int k = 0; k < dim * dim; k++) F[k] = block[k * MPM_BLOCK + p];
}

#define MPM_MATERIAL_DIM(law, dim)                                                                                     \
  static void law##_stress_##dim(const MPMMaterial *m, PetscInt n, const PetscReal *F, PetscReal *tau)                 \
  {                                                                                                                    \
    for (PetscInt p = 0; p < n; p++) {                                                                                 \
      PetscReal Fp[9], tp[MPM_STRESS_NC];                                                                              \
      MPMLoadF(dim, p, F, Fp);                                                                                         \
      law##_stress(dim, m, Fp, tp);                                                                                    \
      for (int k = 0; k < MPM_STRESS_NC; k++) tau[k * MPM_BLOCK + p] = tp[k];                                          \
    }                                                                                                                  \
  }                                                                                                                    \
  static void law##_energy_##dim(const MPMMaterial *m, PetscInt n, const PetscReal *F, PetscReal *W)                   \
  {                                                                                                                    \
    for (PetscInt p = 0; p < n; p++) {                                                                                 \
      PetscReal Fp[9];                                                                                                 \
      MPMLoadF(dim, p, F, Fp);                                                                                         \
      W[p] = law##_energy(dim, m, Fp);                                                                                 \
    }                                                                                                                  \
  }                                                                                                                    \
  static void law##_speed2_##dim(const MPMMaterial *m, PetscInt n, const PetscReal *F, PetscReal *c2)                  \
  {                                                                                                                    \
    for (PetscInt p = 0; p < n; p++) {                                                                                 \
      PetscReal Fp[9];                                                                                                 \
      MPMLoadF(dim, p, F, Fp);                                                                                         \
      c2[p] = law##_speed2(dim, m, Fp);                                                                                \
    }                                                                                                                  \
  }

#define MPM_MATERIAL_DEFINE(law)                                                                                       \
  MPM_MATERIAL_DIM(law, 1)                                                                                             \
  MPM_MATERIAL_DIM(law, 2)                                                                                             \
  MPM_MATERIAL_DIM(law, 3)                                                                                             \
  const MPMMaterialLaw MPMMaterialLaw_##law = {{law##_stress_1, law##_stress_2, law##_stress_3},                       \
                                               {law##_energy_1, law##_energy_2, law##_energy_3},                       \
                                               {law##_speed2_1, law##_speed2_2, law##_speed2_3}};

#endif
