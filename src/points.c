/* particles.c - the material particles: storage, views, canonical order, digest.

   The fields of fields.def are fields of a DMSWARM_BASIC swarm, so PETSc stores and moves them; scratch fields are
   plain arrays beside it. `order` lists the particles by (cell, id): the order in which kernels visit them, the same
   whatever the storage looks like. The storage itself is put in that order now and then, for the cache. */
#include "cell.h"

/* The storage is put in order after so many changes of cell for each particle; in between, sweeps read it through
   `order`. A sort that does not know its movers counts as if 4 % had moved: every 50 of them. (More often: 3-D gains up
   to 4 % where particles move 5 % of a cell a step, 2-D loses as much.) */
#define MPM_SCATTERED   2
#define MPM_MOVES_GUESS 0.04
#define MPM_ROW_BYTES   (9 * sizeof(PetscReal)) /* of a field, at most: a tensor in 3-D */
#define MPM_RUN         16 /* runs of so many particles in the order, on average: they need no reordering */
/* Room for particles to come in the swarm, besides n/500. Small, since PETSc before 3.25 clears all of it at each
   removal; not smaller, since the swarm moves all fields to new memory when particles come that find no room. */
#define MPM_SWARM_BUFFER 64

const MPMFieldInfo MPMFields[MPM_NUM_FIELDS] = {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) {#name, unit, meaning, ptype, home},
#include "fields.def"
#undef MPM_FIELD
};

/* Components of a field in this dimension. */
PetscInt MPMFieldComponents(PetscInt field, PetscInt dim)
{
  const PetscInt components[] = {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) nc,
#include "fields.def"
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

/* Does a material of the scene list this field in its state? */
static PetscBool Keeps(const MPMScene *scene, PetscInt bit)
{
  for (PetscInt k = 0; k < scene->nmaterials; k++)
    if (scene->materials[k].state & bit) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Which fields the scene needs, and their bytes. Not collective. */
PetscErrorCode MPMParticlesLayout(MPM mpm, MPMParticles *particles)
{
#define KEEPS(name) Keeps(&mpm->scene, MPM_BIT(name))
  const PetscBool present[] = {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) (present) ? PETSC_TRUE : PETSC_FALSE,
#include "fields.def"
#undef MPM_FIELD
  };
#undef KEEPS

  PetscFunctionBeginUser;
  particles->dim = mpm->grid.dim;
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

/* Registers the fields that the scene needs, and no more. Collective on comm. */
PetscErrorCode MPMParticlesCreate(MPM mpm, MPMParticles *particles, MPI_Comm comm)
{
  PetscFunctionBeginUser;
  PetscCall(MPMParticlesLayout(mpm, particles));
  PetscCall(DMCreate(comm, &particles->swarm));
  PetscCall(DMSetType(particles->swarm, DMSWARM));
  PetscCall(DMSetDimension(particles->swarm, particles->dim));
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
#include "fields.def"
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

/* Moves rows of `bytes` along the cycles of a path (FindCycles). */
MPM_INLINE void FollowCycles(size_t bytes, PetscInt npath, const PetscInt path[], char *rows)
{
  char first[MPM_ROW_BYTES];

  for (PetscInt k = 0; k < npath; k++) {
    memcpy(first, rows + (size_t)path[k] * bytes, bytes);
    for (; path[k] >= 0; k++) {
      const PetscInt next = path[k + 1] < 0 ? MPM_FLAGGED(path[k + 1]) : path[k + 1];

      memcpy(rows + (size_t)path[k] * bytes, rows + (size_t)next * bytes, bytes);
    }
    memcpy(rows + (size_t)MPM_FLAGGED(path[k]) * bytes, first, bytes);
  }
}

/* The cycles of an order, which becomes the identity: path [returned] has the places of one after the other, each taken
   by what is at the next; the last place of a cycle, which takes what was at the first, is marked. */
static PetscInt FindCycles(PetscInt n, PetscInt order[], PetscInt path[])
{
  PetscInt npath = 0;

  for (PetscInt q = 0; q < n; q++) {
    if (order[q] == q) continue;
    for (PetscInt to = q, from; order[to] != to; to = from) {
      from          = order[to];
      order[to]     = to;
      path[npath++] = to;
    }
    path[npath - 1] = MPM_FLAGGED(path[npath - 1]);
  }
  return npath;
}

/* Puts the storage into the order of `order`, which becomes the identity. In place: a copy of the largest field would
   be up to half of the memory of the particles. The path along the cycles is in the room of the order before. */
static PetscErrorCode Reorder(MPMParticles *particles)
{
  const PetscInt *path  = particles->spare;
  const PetscInt  npath = FindCycles(particles->n, particles->order, particles->spare);

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    void *rows;

    if (!particles->present[f]) continue;
    PetscCall(MPMParticlesGetField(particles, f, &rows));
    MPM_FOR_WIDTH(particles->bytes[f], FollowCycles, npath, path, (char *)rows);
    PetscCall(MPMParticlesRestoreField(particles, f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is the order far from that of the storage? Particles that move together, and those that come from other processes and
   take the places of leavers, leave long runs, along which nothing is gained by putting the storage in order. */
static PetscBool Scattered(const MPMParticles *particles)
{
  PetscInt jumps = 0;

  for (PetscInt q = 1; q < particles->n; q++) jumps += particles->order[q] != particles->order[q - 1] + 1;
  return jumps > particles->n / MPM_RUN ? PETSC_TRUE : PETSC_FALSE;
}

/* order = particles by (cell, id): a counting sort by cell, then insertion by id, which finds little to do since the
   storage is n_early in order. */
static void SortByCell(const MPMView *view, PetscInt ncells, PetscInt *start, PetscInt *order)
{
  for (PetscInt c = 0; c < ncells + 2; c++) start[c] = 0;
  for (PetscInt p = 0; p < view->n; p++) start[view->cell[p] + 2]++;
  for (PetscInt c = 2; c < ncells + 2; c++) start[c] += start[c - 1];
  for (PetscInt p = 0; p < view->n; p++) order[start[view->cell[p] + 1]++] = p; /* start[c + 1] grows to its place */
  for (PetscInt c = 0; c < ncells; c++)
    for (PetscInt q = start[c] + 1; q < start[c + 1]; q++) {
      const PetscInt p = order[q];
      PetscInt       r = q;

      for (; r > start[c] && view->id[order[r - 1]] > view->id[p]; r--) order[r] = order[r - 1];
      order[r] = p;
    }
}

/* Does this part of the order have places of particles that changed cell or left? */
static PetscBool HasMovers(const PetscInt *order, PetscInt n, PetscInt nkept)
{
  PetscInt most = -1;

  for (PetscInt q = 0; q < n; q++) most = PetscMax(most, order[q]);
  return most >= nkept ? PETSC_TRUE : PETSC_FALSE;
}

/* The same from the order before and the places in it of the particles that changed cell or left: the others keep their
   turns, so cells are copied without them and leave room for arrivals, which then find their place by id. Rows of `row`
   cells without movers are copied as they are. After a migration other particles are where leavers were and from nkept
   on: they are arrivals too. */
static PetscErrorCode MergeMovers(const MPMView *view, PetscInt ncells, PetscInt row, MPMParticles *particles)
{
  PetscInt *order = particles->order, *start = particles->start, *to = particles->spare,
           *arrivals  = particles->arrivals;
  PetscInt      *come = particles->movers, narrived = 0, at = 0;
  const PetscInt nkept = particles->nkept;
  PetscBool     *comes; /* to a row */

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < particles->nmovers; m++) {
    const PetscInt q = particles->movers[m] < 0 ? MPM_FLAGGED(particles->movers[m]) : particles->movers[m],
                   p = order[q];

    order[q] = nkept;
    if (p < nkept) come[narrived++] = p;
  }
  for (PetscInt p = nkept; p < view->n; p++) come[narrived++] = p;
  PetscCall(PetscCalloc1(ncells / row, &comes));
  for (PetscInt m = 0; m < narrived; m++) {
    arrivals[view->cell[come[m]]]++;
    comes[view->cell[come[m]] / row] = PETSC_TRUE;
  }
  for (PetscInt first = 0; first < ncells; first += row) {
    PetscInt       q = start[first];
    const PetscInt n = start[first + row] - q, shift = at - q;

    if (!comes[first / row] && !HasMovers(order + q, n, nkept)) {
      if (n > 0) memcpy(to + at, order + q, (size_t)n * sizeof *to);
      for (PetscInt c = first; c < first + row && shift; c++) start[c] += shift;
      at += n;
      continue;
    }
    for (PetscInt c = first; c < first + row; c++) {
      const PetscInt end = start[c + 1];

      start[c] = at;
      for (; q < end; q++) {
        to[at] = order[q];
        at += order[q] < nkept;
      }
      at += arrivals[c];
    }
  }
  start[ncells] = at;
  for (PetscInt m = 0; m < narrived; m++) {
    const PetscInt p = come[m], c = view->cell[p];
    PetscInt       r = start[c + 1] - arrivals[c]--;

    for (; r > start[c] && view->id[to[r - 1]] > view->id[p]; r--) to[r] = to[r - 1];
    to[r] = p;
  }
  PetscCall(PetscFree(comes));
  particles->spare = order;
  particles->order = to;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the particles that left the patch, ascending: which [n], allocated here. Not collective. */
PetscErrorCode MPMParticlesLeavers(MPMParticles *particles, PetscInt *n, PetscInt **which)
{
  const PetscBool all        = particles->nmovers < 0 ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt  candidates = all ? particles->n : particles->nmovers, *movers = particles->movers;
  MPMView         view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(cell), &view));
  for (PetscInt pass = 0; pass < 2; pass++) {
    *n = 0;
    for (PetscInt m = 0; m < candidates; m++) {
      if (all ? view.cell[m] >= 0 : movers[m] >= 0) continue;
      if (pass) (*which)[*n] = all ? m : particles->order[MPM_FLAGGED(movers[m])];
      ++*n;
    }
    if (!pass) PetscCall(PetscMalloc1(*n, which));
  }
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(cell), &view));
  PetscCall(PetscSortInt(*n, *which));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Orders the particles, whose `cell` is known, for the patch: sets order and start. Not collective. */
PetscErrorCode MPMParticlesSort(MPMParticles *particles, const MPMPatch *patch)
{
  const PetscInt ncells = MPMTilesCells(patch), fields = MPM_BIT(id) | MPM_BIT(cell);
  MPMView        view;

  PetscFunctionBeginUser;
  if (particles->nstart < ncells + 2) {
    PetscCall(PetscFree2(particles->start, particles->arrivals));
    PetscCall(PetscMalloc2(ncells + 2, &particles->start, ncells + 2, &particles->arrivals));
    PetscCall(PetscArrayzero(particles->arrivals, ncells + 2));
    particles->nstart  = ncells + 2;
    particles->nmovers = -1;
  }
  PetscCall(MPMParticlesGetView(particles, fields, &view));
  particles->scattered += particles->nmovers < 0 ? MPM_MOVES_GUESS * (PetscReal)particles->n
                                                 : (PetscReal)particles->nmovers;
  if (particles->nmovers < 0)
    SortByCell(&view, ncells, particles->start, particles->order);
  else
    PetscCall(MergeMovers(&view, ncells, patch->tiles.n[0] << patch->tiles.bits, particles));
  MPMSimulateWork("SORT", view.n);
  particles->nmovers = -1;
  particles->nkept   = particles->n;
  PetscCall(MPMParticlesRestoreView(particles, fields, &view));
  if (particles->scattered >= MPM_SCATTERED * (PetscReal)particles->n) {
    if (Scattered(particles)) PetscCall(Reorder(particles));
    particles->scattered = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cells of all particles anew and orders them. All must lie in cells of the patch. Not collective. */
PetscErrorCode MPMParticlesLocate(MPMParticles *particles, const MPMPatch *patch, const MPMKind *kinds)
{
  const PetscInt d = particles->dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(cell) | MPM_BIT(kind) | MPM_BIT(l);
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscInt base[3] = {0};

    view.cell[p] = MPMOwnCell((int)d, patch->basis, patch, view.x + p * d, MPMHalfWidths((int)d, kinds, &view, p),
                              base);
    PetscCheck(view.cell[p] >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "particle %" PetscInt64_FMT " at (%g, %g, %g) is on the wrong process", view.id[p],
               (double)view.x[p * d], (double)(d > 1 ? view.x[p * d + 1] : 0), (double)(d > 2 ? view.x[p * d + 2] : 0));
  }
  PetscCall(MPMParticlesRestoreView(particles, fields, &view));
  particles->scattered = PETSC_MAX_REAL;
  particles->nmovers   = -1;
  PetscCall(MPMParticlesSort(particles, patch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
                   "%spoint %" PetscInt64_FMT " is there more than once, on process %d at (%g, %g, %g)", at ? "; " : "",
                   doubled, holder, (double)x[0], (double)x[1], (double)x[2]);
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
#include "fields.def"
#undef MPM_FIELD
    sum += h;
  }
  PetscCall(MPMParticlesRestoreView(particles, -1, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm));
  memcpy(digest, &sum, sizeof sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MPMParticlesState(PetscInt dim, const MPMView *view, PetscInt p, MPMBlock *b)
{
#define MPM_STATE_OF(name, rows)                                                                                       \
  if (view->name)                                                                                                      \
    for (int k = 0; k < MPMComponents_##name((int)dim); k++)                                                           \
      b->name[k][0] = view->name[p * MPMComponents_##name((int)dim) + k];
  MPM_MATERIAL_FIELDS(MPM_STATE_OF)
#undef MPM_STATE_OF
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
