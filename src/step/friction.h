/* friction.h - friction as an impulse across a normal, of matter and of rigid bodies (contact.c, rigid.c). */
#ifndef MPM_FRICTION_H
#define MPM_FRICTION_H

#include "base/base.h"

/* Changes an impulse of friction, was [3] in N s, to the one that would stop the sliding, brake [3], or to as much of it
   as mu times the impulse `press` along the normal, N s, allows (Coulomb); adds the change to J [3]. brake is lost. */
MPM_INLINE void MPMFrictionSet(PetscReal mu, PetscReal press, PetscReal brake[], PetscReal was[], PetscReal J[])
{
  const PetscReal most = press > 0 ? mu * press : 0;
  PetscReal       size = 0;

  for (PetscInt d = 0; d < 3; d++) size += brake[d] * brake[d];
  size = PetscSqrtReal(size);
  for (PetscInt d = 0; d < 3; d++) {
    if (size > most) brake[d] *= most / size;
    J[d] += brake[d] - was[d];
    was[d] = brake[d];
  }
}

#endif
