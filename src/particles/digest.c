/* digest.c - what tells that all particles are there and that their state has the same bits: fingerprint and digest. */
#include "particles/particles.h"

/* A permutation of 64-bit words that mixes well (splitmix64's finaliser, Steele, Lea and Flood 2014). */
static uint64_t Mix(uint64_t z)
{
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/* What a particle counts for in the fingerprint: id (id + 1), modulo 2^64. */
uint64_t MPMParticleHash(PetscInt64 id)
{
  return (uint64_t)id * (uint64_t)(id + 1);
}

/* The sum of the marks of the particles here, modulo 2^64. Of all processes, with the number of particles: one that is
   lost or doubled changes the number, and one that stands in the place of another changes the sum. Of several at once
   it misses those that leave both as they are: 0 and 6 doubled, 3 and 5 lost. It says nothing of their state. Not
   collective. */
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

/* The first id that is not there once, and how often it is, or -1. Collective on comm. */
static PetscErrorCode FirstWrong(MPMParticles *particles, MPI_Comm comm, PetscBool doubled, PetscInt64 *wrong)
{
  PetscInt   *count;
  PetscMPIInt len;
  MPMView     view;

  PetscFunctionBeginUser;
  *wrong = -1;
  PetscCall(PetscMPIIntCast((PetscInt)particles->total, &len));
  PetscCall(PetscCalloc1(particles->total, &count));
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(id), &view));
  for (PetscInt p = 0; p < view.n; p++)
    if (view.id[p] >= 0 && view.id[p] < particles->total) count[view.id[p]]++;
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(id), &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, len, MPIU_INT, MPI_SUM, comm));
  for (PetscInt64 id = particles->total - 1; id >= 0; id--)
    if (doubled ? count[id] > 1 : count[id] == 0) *wrong = id;
  PetscCall(PetscFree(count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names the particles that are missing and there twice, after the fingerprints have told that there are some: ids, and
   of a doubled one a process that has it and where. Collective on comm. */
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

/* Raises an error if n particles with the fingerprint `ids`, counted over comm, cannot be those of the scene, each
   once. The first call remembers what is right. Collective on comm. */
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

/* A number of the state's bits: every state field of every particle, with its id; a sum of hashes, so without order.
   Equal digests mean the same bits in id, x, v, F and material state. Collective on comm. */
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
    uint64_t h = Mix((uint64_t)view.id[p] + 0x9e3779b97f4a7c15ULL);

#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  if (home == MPM_STATE && MPM_FIELD_INDEX_##name != MPM_FIELD_INDEX_kind && view.name)                                \
    for (PetscInt k = 0; k < particles->bytes[MPM_FIELD_INDEX_##name] / 8; k++) {                                      \
      uint64_t word;                                                                                                   \
      memcpy(&word, (char *)view.name + (size_t)p * (size_t)particles->bytes[MPM_FIELD_INDEX_##name] + 8 * k,          \
             sizeof word);                                                                                             \
      h = Mix(h ^ word) + 0x9e3779b97f4a7c15ULL;                                                                       \
    }
#include "physics/fields.def"
#undef MPM_FIELD
    sum += h;
  }
  PetscCall(MPMParticlesRestoreView(particles, -1, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm));
  memcpy(digest, &sum, sizeof sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}
