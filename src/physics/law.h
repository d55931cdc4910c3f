/* law.h - turns a law for one particle into the block functions of its row.

   A material file defines inlined functions of one particle, s its state, and ends with MPM_MATERIAL_DEFINE:
     <name>_setup(material)           if it has one: constants from the options; what is wrong with them or NULL
     <name>_stress(dim, m, s, tau)    Kirchhoff stress [6] in Pa of a law without history
     <name>_update(dim, m, dt, L, s)  or, of a law with history, its new state and s->tau after a step dt with velocity
                                      gradient L [dim*dim] in 1/s; s->F is new already
     <name>_energy(dim, m, s)         stored energy per reference volume in J/m^3
     <name>_speed2(dim, m, s)         upper bound of the squared wave speed in m^2/s^2 */
#ifndef MPM_LAW_H
#define MPM_LAW_H

#include "physics/material.h"

/* One particle or, where the file is compiled for lanes, as many at a time. Tensors be and tau are whole in every
 * dimension: xx xy xz yy yz zz. */
typedef struct {
  MPMReal F[9], J, be[6], ep, vc, tau[6];
} MPMParticleState;

/* Reads particle p of a block; what its law does not use, the compiler leaves out. */
MPM_INLINE void MPMParticleLoad(int dim, const MPMBlock *b, PetscInt p, MPMParticleState *s)
{
  for (int k = 0; k < dim * dim; k++) s->F[k] = MPMRead(&b->F[k][p]);
  for (int k = 0; k < 6; k++) {
    s->be[k]  = MPMAll(MPMSymUnit(3, k));
    s->tau[k] = MPMAll(0);
  }
  for (int k = 0; k < MPM_SYM_NC(dim); k++) {
    s->be[MPMSymPlace(dim, k)]  = MPMRead(&b->be[k][p]);
    s->tau[MPMSymPlace(dim, k)] = MPMRead(&b->tau[k][p]);
  }
  s->J  = MPMRead(&b->J[0][p]);
  s->ep = MPMRead(&b->ep[0][p]);
  s->vc = MPMRead(&b->vc[0][p]);
}

/* Writes the fields of the law's state, which a step changes, of particles first .. last-1 of the block. */
MPM_INLINE void MPMParticleStore(int dim, PetscInt state, const MPMParticleState *s, MPMBlock *b, PetscInt p,
                                 PetscInt first, PetscInt last)
{
  for (int k = 0; k < MPM_SYM_NC(dim); k++) {
    if (state & MPM_BIT(be)) MPMWritePart(&b->be[k][p], s->be[MPMSymPlace(dim, k)], first - p, last - p);
    if (state & MPM_BIT(tau)) MPMWritePart(&b->tau[k][p], s->tau[MPMSymPlace(dim, k)], first - p, last - p);
  }
  if (state & MPM_BIT(J)) MPMWritePart(&b->J[0][p], s->J, first - p, last - p);
  if (state & MPM_BIT(ep)) MPMWritePart(&b->ep[0][p], s->ep, first - p, last - p);
  if (state & MPM_BIT(vc)) MPMWritePart(&b->vc[0][p], s->vc, first - p, last - p);
}

/* Block functions of particles first .. last-1. Vectors begin at multiples of their width; lanes of other particles are
   left as they are. */
#define MPM_FOR_LANES(p, first, last) for (PetscInt p = (first) - (first) % MPM_WIDTH; p < (last); p += MPM_WIDTH)

#define MPM_LAW_STRESS(law, dim)                                                                                       \
  static void law##_stress_##dim(const MPMMaterial *m, PetscInt first, PetscInt last, MPMBlock *b)                     \
  {                                                                                                                    \
    MPM_FOR_LANES(p, first, last)                                                                                      \
    {                                                                                                                  \
      MPMParticleState s;                                                                                              \
      MPMParticleLoad(dim, b, p, &s);                                                                                  \
      law##_stress(dim, m, &s, s.tau);                                                                                 \
      MPMParticleStore(dim, MPM_BIT(tau), &s, b, p, first, last);                                                      \
    }                                                                                                                  \
  }
#define MPM_LAW_UPDATE(law, dim, state)                                                                                \
  static void law##_update_##dim(const MPMMaterial *m, PetscReal dt, PetscReal(*L)[MPM_BLOCK], PetscInt first,         \
                                 PetscInt last, MPMBlock *b)                                                           \
  {                                                                                                                    \
    MPM_FOR_LANES(p, first, last)                                                                                      \
    {                                                                                                                  \
      MPMParticleState s;                                                                                              \
      MPMReal          Lp[9];                                                                                          \
      MPMParticleLoad(dim, b, p, &s);                                                                                  \
      for (int k = 0; k < dim * dim; k++) Lp[k] = MPMRead(&L[k][p]);                                                   \
      law##_update(dim, m, dt, Lp, &s);                                                                                \
      MPMParticleStore(dim, state, &s, b, p, first, last);                                                             \
    }                                                                                                                  \
  }
#define MPM_LAW_SCALAR(law, what, dim)                                                                                 \
  static void law##_##what##_##dim(const MPMMaterial *m, PetscInt first, PetscInt last, const MPMBlock *b,             \
                                   PetscReal out[])                                                                    \
  {                                                                                                                    \
    MPM_FOR_LANES(p, first, last)                                                                                      \
    {                                                                                                                  \
      MPMParticleState s;                                                                                              \
      MPMParticleLoad(dim, b, p, &s);                                                                                  \
      MPMWritePart(out + p, law##_##what(dim, m, &s), first - p, last - p);                                            \
    }                                                                                                                  \
  }
#define MPM_LAW_SCALARS(law, what)                                                                                     \
  MPM_LAW_SCALAR(law, what, 1) MPM_LAW_SCALAR(law, what, 2) MPM_LAW_SCALAR(law, what, 3)

#define MPM_LAW_1_2_3(law, what)                                                                                       \
  {                                                                                                                    \
    law##_##what##_1, law##_##what##_2, law##_##what##_3                                                               \
  }

/* The laws of a file that the makefile compiles for lanes too. */
#if defined(__x86_64__)
#define MPM_LAW_LANES(law)                                                                                             \
  {                                                                                                                    \
    &MPMMaterialLaw_##law##_8, &MPMMaterialLaw_##law##_4, &MPMMaterialLaw_##law##_2                                    \
  }
#else
#define MPM_LAW_LANES(law)                                                                                             \
  {                                                                                                                    \
    NULL, NULL, &MPMMaterialLaw_##law##_2                                                                              \
  }
#endif

/* A law whose stress is a function of F. */
#if MPM_WIDTH == 1
#define MPM_MATERIAL_DEFINE(law)                                                                                       \
  MPM_LAW_STRESS(law, 1)                                                                                               \
  MPM_LAW_STRESS(law, 2)                                                                                               \
  MPM_LAW_STRESS(law, 3)                                                                                               \
  MPM_LAW_SCALARS(law, energy)                                                                                         \
  MPM_LAW_SCALARS(law, speed2)                                                                                         \
  extern const MPMMaterialLaw MPMMaterialLaw_##law##_8, MPMMaterialLaw_##law##_4, MPMMaterialLaw_##law##_2;            \
  const MPMMaterialLaw        MPMMaterialLaw_##law = {.stress = MPM_LAW_1_2_3(law, stress),                            \
                                                      .energy = MPM_LAW_1_2_3(law, energy),                            \
                                                      .speed2 = MPM_LAW_1_2_3(law, speed2),                            \
                                                      .lanes  = MPM_LAW_LANES(law)};
#else
#define MPM_MATERIAL_DEFINE(law)                                                                                       \
  MPM_LAW_STRESS(law, 1)                                                                                               \
  MPM_LAW_STRESS(law, 2)                                                                                               \
  MPM_LAW_STRESS(law, 3)                                                                                               \
  MPM_LAW_SCALARS(law, speed2)                                                                                         \
  const MPMMaterialLaw MPM_LANES_NAME(MPMMaterialLaw_##law) = {.stress = MPM_LAW_1_2_3(law, stress),                   \
                                                               .speed2 = MPM_LAW_1_2_3(law, speed2)};
#endif

/* A law with history: a step changes these fields of its state, tau among them. setup may be NULL. */
#if MPM_WIDTH == 1
#define MPM_MATERIAL_DEFINE_HISTORY(law, prepare, state)                                                               \
  MPM_LAW_UPDATE(law, 1, state)                                                                                        \
  MPM_LAW_UPDATE(law, 2, state)                                                                                        \
  MPM_LAW_UPDATE(law, 3, state)                                                                                        \
  MPM_LAW_SCALARS(law, energy)                                                                                         \
  MPM_LAW_SCALARS(law, speed2)                                                                                         \
  extern const MPMMaterialLaw MPMMaterialLaw_##law##_8, MPMMaterialLaw_##law##_4, MPMMaterialLaw_##law##_2;            \
  const MPMMaterialLaw        MPMMaterialLaw_##law = {.setup  = (prepare),                                             \
                                                      .update = MPM_LAW_1_2_3(law, update),                            \
                                                      .energy = MPM_LAW_1_2_3(law, energy),                            \
                                                      .speed2 = MPM_LAW_1_2_3(law, speed2),                            \
                                                      .lanes  = MPM_LAW_LANES(law)};
#else
#define MPM_MATERIAL_DEFINE_HISTORY(law, prepare, state)                                                               \
  MPM_LAW_UPDATE(law, 1, state)                                                                                        \
  MPM_LAW_UPDATE(law, 2, state)                                                                                        \
  MPM_LAW_UPDATE(law, 3, state)                                                                                        \
  MPM_LAW_SCALARS(law, speed2)                                                                                         \
  const MPMMaterialLaw MPM_LANES_NAME(MPMMaterialLaw_##law) = {.update = MPM_LAW_1_2_3(law, update),                   \
                                                               .speed2 = MPM_LAW_1_2_3(law, speed2)};
#endif

#endif
