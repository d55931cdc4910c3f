/* kinds.c - the table of kinds of particles, before the first step: bodies whose particles are alike have one kind. */
#include "scene/kinds.h"

PetscErrorCode MPMKindsRoom(MPMScene *scene, PetscInt more)
{
  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(scene->nkinds + more) * sizeof *scene->kinds, &scene->kinds));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MPMKindsFind(MPMScene *scene, PetscInt known, const MPMKind *kind)
{
  for (PetscInt k = 0; k < known; k++) {
    const MPMKind *q = &scene->kinds[k];

    if (q->material == kind->material && q->V0 == kind->V0 && q->m == kind->m && q->copy == kind->copy &&
        !memcmp(q->l, kind->l, sizeof q->l))
      return k;
  }
  scene->kinds[scene->nkinds] = *kind;
  return scene->nkinds++;
}
