/* storage.c - the storage of particles: fields of state and swarm are fields of a DMSWARM_BASIC swarm, so PETSc stores
   and moves them; scratch fields are plain arrays. Each field is [n][components]. */
#include "base/pages.h"
#include "particles/poison.h"

/* Spare places, besides those for arrivals. */
#define MPM_SWARM_BUFFER 64

const MPMFieldInfo MPMFields[MPM_NUM_FIELDS] = {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) {#name, unit, meaning, ptype, home},
#include "physics/fields.def"
};

#define dim 3 /* where rows are longest */
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  _Static_assert((nc) * sizeof(ctype) <= MPM_ROW_BYTES, #name " has longer rows than MPM_ROW_BYTES");
#include "physics/fields.def"
#undef dim

/* Returns the components of a field in dimension dim. */
static PetscInt Components(PetscInt field, PetscInt dim)
{
  const PetscInt components[] = {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) nc,
#include "physics/fields.def"
  };

  return components[field];
}

/* Returns the bytes of a particle in the fields that are stored up to `most`: those of the state, with those of the
   swarm, or with scratch fields too. */
PetscInt MPMParticlesBytes(const MPMParticles *particles, MPMHome most)
{
  PetscInt bytes = 0;

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && MPMFields[f].home <= most) bytes += particles->bytes[f];
  return bytes;
}

/* Returns the bytes of memory for a particle: its fields, the process number that every swarm stores, the orders of now
   and of before, and the copy of what a step changes. */
PetscInt MPMParticlesMemory(const MPMParticles *particles)
{
  return MPMParticlesBytes(particles, MPM_SCRATCH) + 3 * (PetscInt)sizeof(PetscInt) +
         (PetscInt)MPMParticlesRowBytes(particles, particles->saved);
}

/* Returns the bytes of a particle in these fields (bits). */
size_t MPMParticlesRowBytes(const MPMParticles *particles, PetscInt fields)
{
  size_t bytes = 0;

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && (fields & (1 << f))) bytes += (size_t)particles->bytes[f];
  return bytes;
}

/* Sets which fields the scene needs, and their bytes. Not collective. */
PetscErrorCode MPMParticlesLayout(MPMParticles *particles, PetscInt dim, const MPMNeeds *needs)
{
#define KEEPS(name) (needs->state & MPM_BIT(name))
  const PetscBool present[] = {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) (present) ? PETSC_TRUE : PETSC_FALSE,
#include "physics/fields.def"
  };
#undef KEEPS

  PetscFunctionBeginUser;
  particles->dim = dim;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    size_t size;

    PetscCall(PetscDataTypeGetSize(MPMFields[f].type, &size));
    particles->needed[f]  = present[f];
    particles->present[f] = present[f];
    if (needs->all && f != MPM_FIELD_INDEX_F33 && f != MPM_FIELD_INDEX_bar) particles->present[f] = PETSC_TRUE;
    particles->bytes[f] = Components(f, particles->dim) * (PetscInt)size;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the swarm's name of a field. */
static const char *SwarmName(PetscInt field)
{
  return field == MPM_FIELD_INDEX_id ? DMSwarmField_pid : MPMFields[field].name;
}

/* Creates the swarm with the fields of the layout, and no others; those with long rows first, since the swarm copies
   its fields to new memory one by one, and shorter ones then find place where the longest was. Collective on comm. */
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
  for (PetscInt bytes = MPM_ROW_BYTES; bytes > 0; bytes--)
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
      if (particles->bytes[f] == bytes && particles->present[f] && MPMFields[f].home != MPM_SCRATCH &&
          f != MPM_FIELD_INDEX_id)
        PetscCall(DMSwarmRegisterPetscDatatypeField(particles->swarm, MPMFields[f].name, Components(f, particles->dim),
                                                    MPMFields[f].type));
  PetscCall(DMSwarmFinalizeFieldRegister(particles->swarm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the array [n][components] of a field that the scene has. The id is the number that every swarm stores for a
   particle. Restore it before the number of particles changes. Not collective. */
PetscErrorCode MPMParticlesGetField(MPMParticles *particles, PetscInt field, void **at)
{
  PetscFunctionBeginUser;
  if (MPMFields[field].home == MPM_SCRATCH)
    *at = particles->scratch[field];
  else
    PetscCall(DMSwarmGetField(particles->swarm, SwarmName(field), NULL, NULL, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Asks for large pages for the fields and the orders of the particles. empty_spare: also gives the memory of the
   swarm's spare places, which hold zeroes, back to the system until they are written to. Not collective. */
static PetscErrorCode SetPages(MPMParticles *particles, PetscBool empty_spare)
{
  const size_t n = (size_t)particles->n, spare = (size_t)(particles->places - particles->n);

  PetscFunctionBeginUser;
  MPMLargePages(particles->order, n * sizeof *particles->order);
  MPMLargePages(particles->spare, n * sizeof *particles->spare);
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const size_t bytes = (size_t)particles->bytes[f];
    void        *rows;

    if (!particles->present[f]) continue;
    PetscCall(MPMParticlesGetField(particles, f, &rows));
    MPMLargePages(rows, n * bytes);
    if (MPMFields[f].home == MPM_SCRATCH) continue;
    if (empty_spare) MPMGivePagesBack((char *)rows + n * bytes, spare * bytes);
    PetscCall(DMSwarmRestoreField(particles->swarm, SwarmName(f), NULL, NULL, &rows));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets n to the swarm's size, after particles came or left, and makes scratch fields and order long enough. Keeps order
   and movers, but not the content of scratch fields that grow. Not collective. */
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
    MPMPoison(particles->scratch[f], (size_t)particles->capacity * (size_t)particles->bytes[f]);
  }
  PetscCall(PetscRealloc((size_t)(particles->capacity + 1) * sizeof *particles->order, &particles->order));
  PetscCall(PetscRealloc((size_t)particles->capacity * sizeof *particles->movers, &particles->movers));
  PetscCall(PetscFree(particles->spare));
  PetscCall(PetscMalloc1(particles->capacity + 1, &particles->spare));
  PetscCall(SetPages(particles, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds for how many arrivals at a time there is to be room: as many as ever came at once, or, before the first ones,
   those of a body that moves along the cells. (Half a layer of cells with 8 particles each, where two processes have a
   cube.) They are at most 1/32 of the particles; none on one process. Not collective. */
static PetscErrorCode Arrivals(const MPMParticles *particles, PetscInt n, PetscInt *arrivals)
{
  const PetscReal layer = 1.8 * PetscPowReal((PetscReal)n, 1 - 1 / (PetscReal)particles->dim);
  PetscMPIInt     processes;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)particles->swarm), &processes));
  *arrivals = PetscMin(n / 32, particles->room ? particles->room : processes > 1 ? (PetscInt)layer : 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the number of particles of this process; the fields of new ones are unset. There are spare places for two to
   four migrations, since the swarm copies all fields to new memory when it has fewer than its buffer. The buffer is
   half of them: if it were less, the swarm would give some back; it gives all back first where there are too many. It
   zeroes the spare places whenever its size changes. Not collective. */
PetscErrorCode MPMParticlesSetSize(MPMParticles *particles, PetscInt n)
{
  const PetscInt before = particles->n;
  PetscInt       spare, unused = particles->places - n;
  PetscBool      moves, first  = !particles->places;

  PetscFunctionBeginUser;
  PetscCall(Arrivals(particles, n, &spare));
  spare += MPM_SWARM_BUFFER;
  moves = unused < 2 * spare || unused > 4 * spare + n / 4; /* to new memory */
  if (moves) {
    if (unused > 4 * spare) PetscCall(DMSwarmSetLocalSizes(particles->swarm, n, 0)); /* else it might keep too few */
    unused            = 4 * spare;
    particles->places = n + unused;
    PetscCall(DMSwarmSetLocalSizes(particles->swarm, n, unused));
  }
  PetscCall(DMSwarmSetLocalSizes(particles->swarm, n, (unused + 1) / 2));
  PetscCall(MPMParticlesResize(particles));
  if (moves) PetscCall(SetPages(particles, first));
  PetscCall(MPMPoisonFields(particles, ~0, before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the use of an array of MPMParticlesGetField. Not collective. */
PetscErrorCode MPMParticlesRestoreField(MPMParticles *particles, PetscInt field)
{
  void *at;

  PetscFunctionBeginUser;
  if (MPMFields[field].home != MPM_SCRATCH)
    PetscCall(DMSwarmRestoreField(particles->swarm, SwarmName(field), NULL, NULL, &at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the pointers of a view to these fields (bits) of the particles of this process; those of other fields, and of
   fields that this scene lacks, are NULL. Restore it before the number of particles changes. Not collective. */
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ends the use of a view with these fields. Not collective. */
PetscErrorCode MPMParticlesRestoreView(MPMParticles *particles, PetscInt fields, MPMView *view)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (particles->present[f] && (fields & (1 << f))) PetscCall(MPMParticlesRestoreField(particles, f));
  PetscCall(PetscMemzero(view, sizeof *view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the fields `saved` of the particles here, or copies them back. Not collective. */
static PetscErrorCode Copy(MPMParticles *particles, PetscBool back)
{
  char *at = particles->copy;

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const size_t bytes = (size_t)particles->n * (size_t)particles->bytes[f];
    void        *rows;

    if (!particles->present[f] || !(particles->saved & (1 << f))) continue;
    PetscCall(MPMParticlesGetField(particles, f, &rows));
    if (bytes) memcpy(back ? rows : (void *)at, back ? (void *)at : rows, bytes);
    PetscCall(MPMParticlesRestoreField(particles, f));
    at += bytes;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies what a step changes, before the step. Not collective. */
PetscErrorCode MPMParticlesSave(MPMParticles *particles)
{
  const size_t row = MPMParticlesRowBytes(particles, particles->saved);

  PetscFunctionBeginUser;
  if ((size_t)particles->n * row > particles->copy_room) {
    particles->copy_room = (size_t)particles->capacity * row;
    PetscCall(PetscFree(particles->copy));
    PetscCall(PetscMalloc1(particles->copy_room, &particles->copy));
  }
  PetscCall(Copy(particles, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Undoes a step that has not been settled: particles and order are where they were when MPMParticlesSave was called.
   Not collective. */
PetscErrorCode MPMParticlesPutBack(MPMParticles *particles)
{
  PetscFunctionBeginUser;
  PetscCall(Copy(particles, PETSC_TRUE));
  particles->nmovers = -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Frees the storage. Collective on the swarm's comm. */
PetscErrorCode MPMParticlesDestroy(MPMParticles *particles)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) PetscCall(PetscFree(particles->scratch[f]));
  PetscCall(PetscFree(particles->order));
  PetscCall(PetscFree(particles->spare));
  PetscCall(PetscFree(particles->movers));
  PetscCall(PetscFree(particles->copy));
  PetscCall(PetscFree(particles->start));
  PetscCall(PetscFree(particles->incoming));
  PetscCall(DMDestroy(&particles->swarm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
