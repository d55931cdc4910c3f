/* poison.c - fills memory with a pattern, and finds fields that a phase wrote without declaring it (DEBUG=poison). */
#include "particles/poison.h"

#if defined(MPM_POISON)

/* Fills memory with the pattern: a signalling NaN, and the index 2147040237 or -1091581938. Not collective. */
void MPMPoison(void *at, size_t bytes)
{
  const uint64_t pattern = 0x7ff4deadbeefcafeULL;

  for (size_t k = 0; k + sizeof pattern <= bytes; k += sizeof pattern) memcpy((char *)at + k, &pattern, sizeof pattern);
  if (bytes % sizeof pattern)
    memcpy((char *)at + bytes / sizeof pattern * sizeof pattern, &pattern, bytes % sizeof pattern);
}

/* Fills these fields (bits) of the particles from `first` on. Not collective. */
PetscErrorCode MPMPoisonFields(MPMParticles *particles, PetscInt fields, PetscInt first)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const size_t row = (size_t)particles->bytes[f];
    void        *rows;

    if (!particles->present[f] || !(fields & (1 << f)) || first >= particles->n) continue;
    PetscCall(MPMParticlesGetField(particles, f, &rows));
    MPMPoison((char *)rows + (size_t)first * row, (size_t)(particles->n - first) * row);
    PetscCall(MPMParticlesRestoreField(particles, f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns a sum of the bytes of a field. */
static PetscErrorCode Sum(MPMParticles *particles, PetscInt field, uint64_t *sum)
{
  void *rows;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetField(particles, field, &rows));
  *sum = 0xcbf29ce484222325ULL;
  for (size_t k = 0; k < (size_t)particles->n * (size_t)particles->bytes[field]; k++)
    *sum = (*sum ^ ((unsigned char *)rows)[k]) * 0x100000001b3ULL;
  PetscCall(MPMParticlesRestoreField(particles, field));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a field must be as it was after a phase that writes the fields `out`. Outside of steps a field that a
   scene lacks can have the memory of another one (MPMStepRecoverBegin). */
static PetscBool Stays(const MPMParticles *particles, PetscInt field, PetscInt out)
{
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if ((out & (1 << f)) &&
        (f == field || (particles->scratch[f] && particles->scratch[f] == particles->scratch[field])))
      return PETSC_FALSE;
  return particles->present[field];
}

/* Before a transfer from nodes to particles, which reads the fields `in` and writes those of `out`: fills the fields
   that it only writes, and notes what is in all fields that it does not write. Not collective. */
PetscErrorCode MPMPoisonPhase(MPMParticles *particles, PetscInt in, PetscInt out)
{
  PetscFunctionBeginUser;
  PetscCall(MPMPoisonFields(particles, out & ~in, 0));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (Stays(particles, f, out)) PetscCall(Sum(particles, f, &particles->written[f]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* After it: a field that it does not write must be as it was. Not collective. */
PetscErrorCode MPMPoisonCheck(MPMParticles *particles, const char phase[], PetscInt out)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    uint64_t sum;

    if (!Stays(particles, f, out)) continue;
    PetscCall(Sum(particles, f, &sum));
    PetscCheck(sum == particles->written[f], PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "phase %s wrote the field %s, which it does not declare", phase, MPMFields[f].name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

#else
typedef int MPMPoisonIsOff; /* a file of C is not empty */
#endif
