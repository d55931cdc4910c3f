/* digest.c - numbers that show that no particle is lost or doubled (the fingerprint, checked in each step) and that
   states have the same bits (the digest, at the end of a run and in each snapshot). */
#include "base/checksum.h"
#include "particles/particles.h"

/* Returns the term of a particle in the fingerprint: id (id + 1), modulo 2^64. */
uint64_t MPMParticleHash(PetscInt64 id)
{
  return (uint64_t)id * (uint64_t)(id + 1);
}

/* Computes the fingerprint of the particles of this process: the sum of their MPMParticleHash, modulo 2^64. Added over
   all processes and compared together with the number of particles, it shows a lost or doubled particle by the number,
   and one that stands in for another by the sum. It misses combinations that keep both, such as 0 and 6 doubled, 3 and
   5 lost, and says nothing about the state. Not collective. */
PetscErrorCode MPMParticlesFingerprint(MPMParticles *particles, PetscInt64 *ids)
{
  uint64_t sum = 0;
  MPMView  view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(id), &view));
  for (PetscInt p = 0; p < view.n; p++) sum += MPMParticleHash(view.id[p]);
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(id), &view));
  *ids = (PetscInt64)sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the smallest id that is there more than once (doubled) or not at all, or -1. Where particles have been removed,
   none is called missing. Collective on comm. */
static PetscErrorCode FirstWrong(MPMParticles *particles, MPI_Comm comm, PetscBool doubled, PetscInt64 *wrong)
{
  PetscInt   *count;
  PetscMPIInt len;
  MPMView     view;

  PetscFunctionBeginUser;
  *wrong = -1;
  if (!doubled && particles->total < particles->born) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMPIIntCast((PetscInt)particles->born, &len));
  PetscCall(PetscCalloc1(particles->born, &count));
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(id), &view));
  for (PetscInt p = 0; p < view.n; p++)
    if (view.id[p] >= 0 && view.id[p] < particles->born) count[view.id[p]]++;
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(id), &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, len, MPIU_INT, MPI_SUM, comm));
  for (PetscInt64 id = particles->born - 1; id >= 0; id--)
    if (doubled ? count[id] > 1 : count[id] == 0) *wrong = id;
  PetscCall(PetscFree(count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Describes one missing and one doubled particle, after the fingerprints have shown that there are such: their ids and,
   for the doubled one, a process that has it and its position. Collective on comm. */
static PetscErrorCode DescribeLoss(MPMParticles *particles, MPI_Comm comm, char what[], size_t len)
{
  PetscInt64  missing, doubled;
  PetscMPIInt rank, holder = -1;
  PetscReal   x[3] = {0};
  MPMView     view;
  size_t      at = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(FirstWrong(particles, comm, PETSC_FALSE, &missing));
  PetscCall(FirstWrong(particles, comm, PETSC_TRUE, &doubled));
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(id) | MPM_BIT(x), &view));
  for (PetscInt p = 0; p < view.n; p++)
    if (doubled >= 0 && view.id[p] == doubled) {
      holder = rank;
      for (PetscInt d = 0; d < particles->dim; d++) x[d] = view.x[p * particles->dim + d];
    }
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(id) | MPM_BIT(x), &view));
  what[0] = 0;
  if (missing >= 0) at = (size_t)snprintf(what, len, "particle %" PetscInt64_FMT " is missing", missing);
  if (doubled >= 0) {
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &holder, 1, MPI_INT, MPI_MAX, comm));
    PetscCallMPI(MPI_Bcast(x, 3, MPIU_REAL, holder, comm));
    (void)snprintf(what + at, len - at,
                   "%sparticle %" PetscInt64_FMT " is there more than once, on process %d at (%g, %g, %g)",
                   at ? "; " : "", doubled, holder, (double)x[0], (double)x[1], (double)x[2]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error if n particles with the fingerprint `ids`, both added over comm, cannot be those of the scene, each
   once. The first call stores the right fingerprint. Collective on comm. */
PetscErrorCode MPMParticlesCheck(MPMParticles *particles, MPI_Comm comm, PetscInt64 n, PetscInt64 ids)
{
  char what[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (!particles->ids) particles->ids = ids;
  if (n == particles->total && ids == particles->ids) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DescribeLoss(particles, comm, what, sizeof what));
  SETERRQ(comm, PETSC_ERR_PLIB,
          "particles got lost or doubled on the way between processes: %" PetscInt64_FMT " of %" PetscInt64_FMT "; %s",
          n, particles->total, what);
}

/* Computes the digest: the sum of a hash of each particle, of its id and all bits of the state fields that
   the scene needs (but kind). Equal
   digests mean equal bits of id, x, v, F and material state. A sum does not depend on the sequence of particles.
   Collective on comm. */
PetscErrorCode MPMParticlesDigest(MPMParticles *particles, MPI_Comm comm, PetscInt64 *digest)
{
  uint64_t sum = 0;
  MPMView  view;

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    PetscCheck(MPMFields[f].home != MPM_STATE || f == MPM_FIELD_INDEX_kind || particles->bytes[f] % 8 == 0, comm,
               PETSC_ERR_PLIB, "field %s of the state is not made of words of 8 bytes", MPMFields[f].name);
  PetscCall(MPMParticlesGetView(particles, -1, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    uint64_t h = MPMMix((uint64_t)view.id[p] + 0x9e3779b97f4a7c15ULL);

#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  if (home == MPM_STATE && MPM_FIELD_INDEX_##name != MPM_FIELD_INDEX_kind &&                                           \
      particles->needed[MPM_FIELD_INDEX_##name])                                                                       \
    for (PetscInt k = 0; k < particles->bytes[MPM_FIELD_INDEX_##name] / 8; k++) {                                      \
      uint64_t word;                                                                                                   \
      memcpy(&word, (char *)view.name + (size_t)p * (size_t)particles->bytes[MPM_FIELD_INDEX_##name] + 8 * k,          \
             sizeof word);                                                                                             \
      h = MPMMix(h ^ word) + 0x9e3779b97f4a7c15ULL;                                                                    \
    }
#include "physics/fields.def"
    sum += h;
  }
  PetscCall(MPMParticlesRestoreView(particles, -1, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm));
  memcpy(digest, &sum, sizeof sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}
