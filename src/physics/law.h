/* law.h - macros that make the functions for blocks, which a row of material.def needs, from a law for one particle.

   A material file defines inlined functions of one particle, whose state is s, and ends with MPM_MATERIAL_DEFINE:
     <name>_setup(material)           sets constants from the options; returns what is wrong or NULL (optional)
     <name>_stress(dim, m, s, tau)    computes the Kirchhoff stress [6] in Pa of a law without history
     <name>_update(dim, m, dt, L, s)  or, of a law with history, its new state and s->tau after a step dt in s with the
                                      velocity gradient L [dim*dim] in 1/s; s->F is updated before the call
     <name>_energy(dim, m, s)         returns the stored energy per reference volume in J/m^3
     <name>_speed2(dim, m, s)         returns an upper bound of the squared wave speed in m^2/s^2
     <name>_tangent(dim, m, dt, L, s, C)  computes the derivative C [6][MPM_TANGENT_NC] in Pa of the stress after a
                                      step, which is computed from the same s, by l = dH f^-1 [dim*dim], f = I + dt L,
                                      and by l33 of bodies of revolution (optional, for implicit steps: tangent.h)

   These functions are made for each form: dim 1, 2, 3, and bodies of revolution. The latter have dim 2, the stretch
   s->F33 around the axis and its rate s->L33 = v_r/r, of which J, be and the stress along zz depend: law functions take
   J and b = F F^T from MPMParticleJ and MPMParticleB, and use L33 where s->round. */
#ifndef MPM_LAW_H
#define MPM_LAW_H

#include <string.h>
#include "physics/material.h"

/* The state of one particle or, where the file is compiled for lanes, of several. The tensors be and tau have all six
   components in every dimension: xx xy xz yy yz zz. round: is it of a body of revolution? Else F33 is 1 and L33 is 0.
   */
typedef struct {
  int     round;
  MPMReal F[9], F33, L33, J, be[6], ep, vc, theta, tau[6];
} MPMParticleState;

/* Forms as the macros below name them: 1, 2, 3 dimensions, 4 for bodies of revolution. */
#define MPM_FORM_DIM(form)   ((form) == MPM_LAW_FORMS ? 2 : (form))
#define MPM_FORM_ROUND(form) ((form) == MPM_LAW_FORMS)

/* Returns the volume ratio of a particle with F. */
MPM_INLINE MPMReal MPMParticleJ(int dim, const MPMParticleState *s)
{
  const MPMReal J = MPMDet(dim, s->F);

  return s->round ? J * s->F33 : J;
}

/* Computes b = F F^T of a particle with F. */
MPM_INLINE void MPMParticleB(int dim, const MPMParticleState *s, MPMReal b[6])
{
  MPMLeftCauchyGreen(dim, s->F, b);
  if (s->round) b[5] = s->F33 * s->F33;
}

#if MPM_WIDTH == 1 /* for single particles */
/* Returns how many components l = dH f^-1 has: dim*dim, and of bodies of revolution l33. */
MPM_INLINE int MPMTangentColumns(int dim, const MPMParticleState *s)
{
  return dim * dim + (s->round ? 1 : 0);
}

/* Sets l to the unit of its component k, and returns the trace of it. */
MPM_INLINE PetscReal MPMTangentUnit(int dim, int k, PetscReal l[3][3])
{
  const int d = k < dim * dim ? k / dim : 2, e = k < dim * dim ? k % dim : 2;

  memset(l, 0, 9 * sizeof(PetscReal));
  l[d][e] = 1;
  return d == e;
}
#endif

/* Reads the particles of a block from p on, one for each lane; the compiler removes reads that the law does not use. */
MPM_INLINE void MPMParticleLoad(int form, const MPMBlock *b, PetscInt p, MPMParticleState *s)
{
  const int dim = MPM_FORM_DIM(form);

  s->round = MPM_FORM_ROUND(form);
  s->F33   = s->round ? MPMRead(&b->F33[0][p]) : MPMAll(1);
  s->L33   = MPMAll(0);
  for (int k = 0; k < dim * dim; k++) s->F[k] = MPMRead(&b->F[k][p]);
  for (int k = 0; k < 6; k++) {
    s->be[k]  = MPMAll(MPMSymUnit(3, k));
    s->tau[k] = MPMAll(0);
  }
  for (int k = 0; k < MPM_SYM_NC(dim); k++) {
    s->be[MPMSymPlace(dim, k)]  = MPMRead(&b->be[k][p]);
    s->tau[MPMSymPlace(dim, k)] = MPMRead(&b->tau[k][p]);
  }
  s->J     = MPMRead(&b->J[0][p]);
  s->ep    = MPMRead(&b->ep[0][p]);
  s->vc    = MPMRead(&b->vc[0][p]);
  s->theta = MPMRead(&b->theta[0][p]);
}

/* Writes the fields `state` (bits), which a step changes, of lanes first .. last-1 of those from p on. */
MPM_INLINE void MPMParticleStoreLanes(int dim, PetscInt state, const MPMParticleState *s, MPMBlock *b, PetscInt p,
                                      PetscInt first, PetscInt last)
{
  for (int k = 0; k < MPM_SYM_NC(dim); k++) {
    if (state & MPM_BIT(be)) MPMWritePart(&b->be[k][p], s->be[MPMSymPlace(dim, k)], first, last);
    if (state & MPM_BIT(tau)) MPMWritePart(&b->tau[k][p], s->tau[MPMSymPlace(dim, k)], first, last);
  }
  if (state & MPM_BIT(J)) MPMWritePart(&b->J[0][p], s->J, first, last);
  if (state & MPM_BIT(ep)) MPMWritePart(&b->ep[0][p], s->ep, first, last);
  if (state & MPM_BIT(vc)) MPMWritePart(&b->vc[0][p], s->vc, first, last);
  if (state & MPM_BIT(theta)) MPMWritePart(&b->theta[0][p], s->theta, first, last);
}

/* Does so for those lanes that are particles first .. last-1 of the block: mostly all, which then are constants. */
MPM_INLINE void MPMParticleStore(int dim, PetscInt state, const MPMParticleState *s, MPMBlock *b, PetscInt p,
                                 PetscInt first, PetscInt last)
{
  if (first <= p && p + MPM_WIDTH <= last)
    MPMParticleStoreLanes(dim, state, s, b, p, 0, MPM_WIDTH);
  else
    MPMParticleStoreLanes(dim, state, s, b, p, first - p, last - p);
}

/* The functions for blocks compute particles first .. last-1. Their vectors begin at multiples of the width; lanes of
   other particles are not written. */
#define MPM_FOR_LANES(p, first, last) for (PetscInt p = (first) - (first) % MPM_WIDTH; p < (last); p += MPM_WIDTH)

#define MPM_LAW_STRESS(law, form)                                                                                      \
  static void law##_stress_##form(const MPMMaterial *m, PetscInt first, PetscInt last, MPMBlock *b)                    \
  {                                                                                                                    \
    MPM_FOR_LANES(p, first, last)                                                                                      \
    {                                                                                                                  \
      MPMParticleState s;                                                                                              \
      MPMParticleLoad(form, b, p, &s);                                                                                 \
      law##_stress(MPM_FORM_DIM(form), m, &s, s.tau);                                                                  \
      MPMParticleStore(MPM_FORM_DIM(form), MPM_BIT(tau), &s, b, p, first, last);                                       \
    }                                                                                                                  \
  }
#define MPM_LAW_UPDATE(law, form, state)                                                                               \
  static void law##_update_##form(const MPMMaterial *m, PetscReal dt, MPMComponent *L, PetscInt first, PetscInt last,  \
                                  MPMBlock *b)                                                                         \
  {                                                                                                                    \
    const int dim = MPM_FORM_DIM(form);                                                                                \
    MPM_FOR_LANES(p, first, last)                                                                                      \
    {                                                                                                                  \
      MPMParticleState s;                                                                                              \
      MPMReal          Lp[9];                                                                                          \
      MPMParticleLoad(form, b, p, &s);                                                                                 \
      for (int k = 0; k < dim * dim; k++) Lp[k] = MPMRead(&L[k][p]);                                                   \
      if (MPM_FORM_ROUND(form)) s.L33 = MPMRead(&L[dim * dim][p]);                                                     \
      law##_update(dim, m, dt, Lp, &s);                                                                                \
      MPMParticleStore(dim, state, &s, b, p, first, last);                                                             \
    }                                                                                                                  \
  }
#define MPM_LAW_SCALAR(law, what, form)                                                                                \
  static void law##_##what##_##form(const MPMMaterial *m, PetscInt first, PetscInt last, const MPMBlock *b,            \
                                    PetscReal out[])                                                                   \
  {                                                                                                                    \
    MPM_FOR_LANES(p, first, last)                                                                                      \
    {                                                                                                                  \
      MPMParticleState s;                                                                                              \
      MPMParticleLoad(form, b, p, &s);                                                                                 \
      MPMWritePart(out + p, law##_##what(MPM_FORM_DIM(form), m, &s), first - p, last - p);                             \
    }                                                                                                                  \
  }
#define MPM_LAW_TANGENT(law, form)                                                                                     \
  static void law##_tangent_##form(const MPMMaterial *m, PetscReal dt, MPMComponent *L, PetscInt p, const MPMBlock *b, \
                                   PetscReal C[6][MPM_TANGENT_NC])                                                     \
  {                                                                                                                    \
    const int        dim = MPM_FORM_DIM(form);                                                                         \
    MPMParticleState s;                                                                                                \
    PetscReal        Lp[9];                                                                                            \
    MPMParticleLoad(form, b, p, &s);                                                                                   \
    for (int k = 0; k < dim * dim; k++) Lp[k] = L[k][p];                                                               \
    if (MPM_FORM_ROUND(form)) s.L33 = L[dim * dim][p];                                                                 \
    law##_tangent(dim, m, dt, Lp, &s, C);                                                                              \
  }
#define MPM_LAW_SCALARS(law, what)                                                                                     \
  MPM_LAW_SCALAR(law, what, 1) MPM_LAW_SCALAR(law, what, 2) MPM_LAW_SCALAR(law, what, 3) MPM_LAW_SCALAR(law, what, 4)
#define MPM_LAW_STRESSES(law)                                                                                          \
  MPM_LAW_STRESS(law, 1) MPM_LAW_STRESS(law, 2) MPM_LAW_STRESS(law, 3) MPM_LAW_STRESS(law, 4)
#define MPM_LAW_UPDATES(law, state)                                                                                    \
  MPM_LAW_UPDATE(law, 1, state)                                                                                        \
  MPM_LAW_UPDATE(law, 2, state) MPM_LAW_UPDATE(law, 3, state) MPM_LAW_UPDATE(law, 4, state)
#if MPM_WIDTH == 1
#define MPM_LAW_TANGENTS(law)                                                                                          \
  MPM_LAW_TANGENT(law, 1) MPM_LAW_TANGENT(law, 2) MPM_LAW_TANGENT(law, 3) MPM_LAW_TANGENT(law, 4)
#else
#define MPM_LAW_TANGENTS(law)
#endif

#define MPM_LAW_ALL(law, what)                                                                                         \
  {                                                                                                                    \
    law##_##what##_1, law##_##what##_2, law##_##what##_3, law##_##what##_4                                             \
  }

/* The variants of a law for 8, 4 and 2 lanes, which the makefile compiles from the same file. */
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

/* Defines a law by its functions; the members that follow are those for single particles alone. */
#if MPM_WIDTH == 1
#define MPM_LAW_DEFINE(law, function, ...)                                                                             \
  MPM_LAW_SCALARS(law, energy)                                                                                         \
  MPM_LAW_SCALARS(law, speed2)                                                                                         \
  extern const MPMMaterialLaw MPMMaterialLaw_##law##_8, MPMMaterialLaw_##law##_4, MPMMaterialLaw_##law##_2;            \
  const MPMMaterialLaw        MPMMaterialLaw_##law = {.function = MPM_LAW_ALL(law, function),                          \
                                                      .energy   = MPM_LAW_ALL(law, energy),                            \
                                                      .speed2   = MPM_LAW_ALL(law, speed2),                            \
                                                      .lanes    = MPM_LAW_LANES(law),                                  \
                                                      __VA_ARGS__};
#else
#define MPM_LAW_DEFINE(law, function, ...)                                                                             \
  MPM_LAW_SCALARS(law, speed2)                                                                                         \
  const MPMMaterialLaw MPM_LANES_NAME(MPMMaterialLaw_##law) = {.function = MPM_LAW_ALL(law, function),                 \
                                                               .speed2   = MPM_LAW_ALL(law, speed2)};
#endif

/* Defines a law whose stress is a function of F. Further members of its row for single particles may follow, as
   .tangent = MPM_LAW_ALL(<name>, tangent) after MPM_LAW_TANGENTS(<name>). */
#define MPM_MATERIAL_DEFINE(law, ...)                                                                                  \
  MPM_LAW_STRESSES(law)                                                                                                \
  MPM_LAW_DEFINE(law, stress, __VA_ARGS__)

/* Defines a law with history: `state` are the fields that a step changes, tau among them. `prepare` is its setup or
   NULL; further members may follow as above. */
#define MPM_MATERIAL_DEFINE_HISTORY(law, prepare, state, ...)                                                          \
  MPM_LAW_UPDATES(law, state)                                                                                          \
  MPM_LAW_DEFINE(law, update, .setup = (prepare), __VA_ARGS__)

#endif
