/* remove.c - particles that left the grid are taken out of the storage (-particles_leave delete). */
#include "particles/particles.h"

/* Removes the particles here that are outside the grid: the last ones take their places. Returns how many they were,
   and their fingerprint (MPMParticlesFingerprint). The order has to be made anew. Not collective. */
PetscErrorCode MPMParticlesRemove(MPMParticles *particles, PetscInt64 *n, PetscInt64 *ids)
{
  PetscInt *place, left = 0, kept;
  uint64_t  sum = 0;
  MPMView   view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(id) | MPM_BIT(cell), &view));
  PetscCall(PetscMalloc1(view.n, &place));
  for (PetscInt p = 0; p < view.n; p++)
    if (view.cell[p] == MPM_NOWHERE) {
      sum += MPMParticleHash(view.id[p]);
      place[left++] = p;
    }
  kept = view.n - left;
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(id) | MPM_BIT(cell), &view));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS && left; f++) {
    const size_t bytes = (size_t)particles->bytes[f];
    char        *rows;

    if (!particles->present[f] || MPMFields[f].home == MPM_SCRATCH) continue;
    PetscCall(MPMParticlesGetField(particles, f, (void **)&rows));
    for (PetscInt q = left; q > 0; q--) { /* the last place that gets free is filled first, by what is then the last */
      const PetscInt last = kept + q - 1;

      if (place[q - 1] != last) memcpy(rows + (size_t)place[q - 1] * bytes, rows + (size_t)last * bytes, bytes);
    }
    PetscCall(MPMParticlesRestoreField(particles, f));
  }
  PetscCall(PetscFree(place));
  *n   = left;
  *ids = (PetscInt64)sum;
  if (!left) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMParticlesSetSize(particles, kept));
  particles->nmovers = -1;
  particles->nkept   = kept;
  PetscFunctionReturn(PETSC_SUCCESS);
}
