/* unit_particles.h - particles whose fields are known functions of their number, so that a test can tell whether a row
   of a field still belongs to the particle that it is stored with. */
#ifndef UNIT_PARTICLES_H
#define UNIT_PARTICLES_H

#include "particles/particles.h"

#define UNIT_KINDS 3

/* A number that depends on all of its arguments. */
static uint64_t UnitMix(uint64_t a, uint64_t b, uint64_t c)
{
  uint64_t z = a * 0x9e3779b97f4a7c15ULL + b * 0xbf58476d1ce4e5b9ULL + c * 0x94d049bb133111ebULL + 1;

  for (int k = 0; k < 3; k++) z = (z ^ (z >> 29)) * 0xd6e8feb86659fd93ULL;
  return z ^ (z >> 32);
}

/* Does the test below write and check this field? Number, position and cell are the caller's. */
static int UnitFilled(const MPMParticles *particles, PetscInt f)
{
  return particles->present[f] && f != MPM_FIELD_INDEX_id && f != MPM_FIELD_INDEX_x && f != MPM_FIELD_INDEX_cell;
}

/* The bytes of field f of particle id: any bits, but a kind that there is. round: another state of the same particle.
   */
static void UnitRow(PetscInt f, PetscInt64 id, int round, PetscInt bytes, char row[MPM_ROW_BYTES])
{
  for (PetscInt k = 0; k < bytes; k++) row[k] = (char)UnitMix((uint64_t)id, (uint64_t)(1000 * round + f), (uint64_t)k);
  if (f == MPM_FIELD_INDEX_kind) {
    const PetscInt kind = (PetscInt)(UnitMix((uint64_t)id, 0, 0) % UNIT_KINDS);

    memcpy(row, &kind, sizeof kind);
  }
}

/* Writes those fields of the particle that is stored at place p, or checks them. most: the last home of fields that
   are. */
static PetscErrorCode UnitRows(MPMParticles *particles, const PetscInt64 id[], int round, MPMHome most, PetscBool check)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const PetscInt bytes = particles->bytes[f];
    void          *at;

    if (!UnitFilled(particles, f) || MPMFields[f].home > most) continue;
    PetscCall(MPMParticlesGetField(particles, f, &at));
    for (PetscInt p = 0; p < particles->n; p++) {
      char row[MPM_ROW_BYTES], *stored = (char *)at + p * bytes;

      UnitRow(f, id[p], round, bytes, row);
      if (check)
        UNIT_CHECK(!memcmp(stored, row, (size_t)bytes), "field of another particle, its number", f, "of none", -1);
      else
        memcpy(stored, row, (size_t)bytes);
    }
    PetscCall(MPMParticlesRestoreField(particles, f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A scene that needs a random choice of fields. */
static MPMNeeds UnitNeeds(void)
{
  MPMNeeds needs = {.state = 0};

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (UnitInt(2)) needs.state |= MPM_MATERIAL_BITS & 1 << f;
  needs.kinds     = UnitInt(2) ? PETSC_TRUE : PETSC_FALSE;
  needs.affine    = UnitInt(2) ? PETSC_TRUE : PETSC_FALSE;
  needs.residual  = UnitInt(2) ? PETSC_TRUE : PETSC_FALSE;
  needs.stretched = UnitInt(2) ? PETSC_TRUE : PETSC_FALSE;
  needs.increment = UnitInt(2) ? PETSC_TRUE : PETSC_FALSE;
  needs.forced    = UnitInt(2) ? PETSC_TRUE : PETSC_FALSE;
  needs.loaded    = UnitInt(2) ? PETSC_TRUE : PETSC_FALSE;
  needs.start     = UnitInt(2) ? PETSC_TRUE : PETSC_FALSE;
  return needs;
}

#endif
