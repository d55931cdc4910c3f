/* storage.c - where particles are stored: the fields of fields.def are fields of a DMSWARM_BASIC swarm, so PETSc stores
   and moves them; scratch fields are plain arrays beside it. */
#include "particles/particles.h"

/* Room for particles to come in the swarm, besides n/500. Small, since PETSc before 3.25 clears all of it at each
   removal; not smaller, since the swarm moves all fields to new memory when particles come that find no room. */
#define MPM_SWARM_BUFFER 64

const MPMFieldInfo MPMFields[MPM_NUM_FIELDS] = {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) {#name, unit, meaning, ptype, home},
#include "physics/fields.def"
#undef MPM_FIELD
};

/* Components of a field in this dimension. */
PetscInt MPMFieldComponents(PetscInt field, PetscInt dim)
{
  const PetscInt components[] = {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) nc,
#include "physics/fields.def"
#undef MPM_FIELD
  };

  return components[field];
}

/* Bytes that a particle takes: of its state, of all that the swarm moves, or with the scratch. */
PetscInt MPMParticlesBytes(const MPMParticles *particles, MPMHome most)
{
  PetscInt bytes = 0;

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && MPMFields[f].home <= most) bytes += particles->bytes[f];
  return bytes;
}

/* Bytes of memory that a particle takes here: its fields, with the process that every swarm keeps, and the orders of
   now and of before. */
PetscInt MPMParticlesMemory(const MPMParticles *particles)
{
  return MPMParticlesBytes(particles, MPM_SCRATCH) + 3 * (PetscInt)sizeof(PetscInt);
}

/* Bytes of these fields (bits) of a particle. */
size_t MPMParticlesRowBytes(const MPMParticles *particles, PetscInt fields)
{
  size_t bytes = 0;

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && (fields & (1 << f))) bytes += (size_t)particles->bytes[f];
  return bytes;
}

/* Which fields the scene needs, and their bytes. Not collective. */
PetscErrorCode MPMParticlesLayout(MPMParticles *particles, PetscInt dim, const MPMNeeds *needs)
{
#define KEEPS(name) (needs->state & MPM_BIT(name))
  const PetscBool present[] = {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) (present) ? PETSC_TRUE : PETSC_FALSE,
#include "physics/fields.def"
#undef MPM_FIELD
  };
#undef KEEPS

  PetscFunctionBeginUser;
  particles->dim = dim;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    size_t size;

    PetscCall(PetscDataTypeGetSize(MPMFields[f].type, &size));
    particles->present[f] = present[f];
    particles->bytes[f]   = MPMFieldComponents(f, particles->dim) * (PetscInt)size;
    PetscCheck((size_t)particles->bytes[f] <= MPM_ROW_BYTES, PETSC_COMM_SELF, PETSC_ERR_SUP,
               "field %s has rows of %" PetscInt_FMT " bytes, more than MPM_ROW_BYTES", MPMFields[f].name,
               particles->bytes[f]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the swarm calls a field. */
static const char *SwarmName(PetscInt field)
{
  return field == MPM_FIELD_INDEX_id ? DMSwarmField_pid : MPMFields[field].name;
}

/* Registers the fields that the layout has, and no more. Collective on comm. */
PetscErrorCode MPMParticlesCreate(MPMParticles *particles, MPI_Comm comm)
{
  PetscFunctionBeginUser;
  PetscCall(DMCreate(comm, &particles->swarm));
  PetscCall(DMSetType(particles->swarm, DMSWARM));
  PetscCall(PetscObjectSetName((PetscObject)particles->swarm, "particles"));
  PetscCall(DMSetDimension(particles->swarm, particles->dim));
  PetscCall(DMSetFromOptions(particles->swarm));
  PetscCall(DMSwarmSetType(particles->swarm, DMSWARM_BASIC));
  PetscCall(DMSwarmInitializeFieldRegister(particles->swarm));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && MPMFields[f].home != MPM_SCRATCH && f != MPM_FIELD_INDEX_id)
      PetscCall(DMSwarmRegisterPetscDatatypeField(particles->swarm, MPMFields[f].name,
                                                  MPMFieldComponents(f, particles->dim), MPMFields[f].type));
  PetscCall(DMSwarmFinalizeFieldRegister(particles->swarm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the swarm's size, after particles came and went, and makes room for the scratch of so many. Keeps order and
   movers. Not collective. */
PetscErrorCode MPMParticlesResize(MPMParticles *particles)
{
  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &particles->n));
  if (particles->n <= particles->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  particles->capacity = particles->n + particles->n / 8 + MPM_SWARM_BUFFER;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    if (!particles->present[f] || MPMFields[f].home != MPM_SCRATCH) continue;
    PetscCall(PetscFree(particles->scratch[f]));
    PetscCall(PetscCalloc1((size_t)particles->capacity * (size_t)particles->bytes[f], (char **)&particles->scratch[f]));
  }
  PetscCall(PetscRealloc((size_t)(particles->capacity + 1) * sizeof *particles->order, &particles->order));
  PetscCall(PetscRealloc((size_t)particles->capacity * sizeof *particles->movers, &particles->movers));
  PetscCall(PetscFree(particles->spare));
  PetscCall(PetscMalloc1(particles->capacity + 1, &particles->spare));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the number of particles here; new ones have unset fields. Not collective. */
PetscErrorCode MPMParticlesSetSize(MPMParticles *particles, PetscInt n)
{
  PetscFunctionBeginUser;
  PetscCall(DMSwarmSetLocalSizes(particles->swarm, n, MPM_SWARM_BUFFER + n / 500));
  PetscCall(MPMParticlesResize(particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The array of a field that the scene has: [n][components]. The id is the number that every swarm keeps of its
   particles. Restore before the number of particles changes. Not collective. */
PetscErrorCode MPMParticlesGetField(MPMParticles *particles, PetscInt field, void **at)
{
  PetscFunctionBeginUser;
  if (MPMFields[field].home == MPM_SCRATCH)
    *at = particles->scratch[field];
  else
    PetscCall(DMSwarmGetField(particles->swarm, SwarmName(field), NULL, NULL, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMParticlesRestoreField(MPMParticles *particles, PetscInt field)
{
  void *at;

  PetscFunctionBeginUser;
  if (MPMFields[field].home != MPM_SCRATCH)
    PetscCall(DMSwarmRestoreField(particles->swarm, SwarmName(field), NULL, NULL, &at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fields (bits) of the particles here; those not asked for, or not in this scene, are NULL. Restore before the
   number of particles changes. Not collective. */
PetscErrorCode MPMParticlesGetView(MPMParticles *particles, PetscInt fields, MPMView *view)
{
  void *at[MPM_NUM_FIELDS] = {NULL};

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && (fields & (1 << f))) PetscCall(MPMParticlesGetField(particles, f, &at[f]));
  PetscCall(PetscMemzero(view, sizeof *view));
  view->n = particles->n;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  view->name = (ctype *)at[MPM_FIELD_INDEX_##name];
#include "physics/fields.def"
#undef MPM_FIELD
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMParticlesRestoreView(MPMParticles *particles, PetscInt fields, MPMView *view)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && (fields & (1 << f))) PetscCall(MPMParticlesRestoreField(particles, f));
  PetscCall(PetscMemzero(view, sizeof *view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMParticlesDestroy(MPMParticles *particles)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) PetscCall(PetscFree(particles->scratch[f]));
  PetscCall(PetscFree(particles->order));
  PetscCall(PetscFree(particles->spare));
  PetscCall(PetscFree(particles->movers));
  PetscCall(PetscFree2(particles->start, particles->arrivals));
  PetscCall(DMDestroy(&particles->swarm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
