/* points.c - the material points: storage, views, canonical order, digest.

   The kept fields of fields.def are fields of a DMSWARM_BASIC swarm, so PETSc stores and moves them; scratch fields
   are plain arrays beside it. `order` lists the points by (cell, id): the order in which kernels visit them, the same
   whatever the storage looks like. The storage itself is put in that order now and then, for the cache.               */
#include "transfer.h"

/* Sorts between two reorders of the storage: in between, sweeps read it through `order`, which drifts slowly. */
#define MPM_REORDER_EVERY 50
/* Room for points to come: PETSc < 3.25 clears the whole buffer at each removal, so it is small. */
#define MPM_SWARM_BUFFER 64

const MPMFieldInfo MPMFields[MPM_NUM_FIELDS] = {
#define MPM_FIELD(name, ctype, ptype, nc, kept, present, unit, meaning) {#name, unit, meaning, ptype, kept ? PETSC_TRUE : PETSC_FALSE},
#include "fields.def"
#undef MPM_FIELD
};

/* Components of a field in this dimension. */
PetscInt MPMFieldComponents(PetscInt field, PetscInt dim)
{
  const PetscInt components[] = {
#define MPM_FIELD(name, ctype, ptype, nc, kept, present, unit, meaning) nc,
#include "fields.def"
#undef MPM_FIELD
  };

  return components[field];
}

/* Bytes that a point takes: of the kept fields, or of all. */
PetscInt MPMPointsBytes(const MPMPoints *points, PetscBool kept)
{
  PetscInt bytes = 0;

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (points->present[f] && (MPMFields[f].kept || !kept)) bytes += points->bytes[f];
  return bytes;
}

/* Registers the fields that the scene needs, and no more. Collective on comm. */
PetscErrorCode MPMPointsCreate(MPM mpm, MPMPoints *points, MPI_Comm comm)
{
  const PetscBool present[] = {
#define MPM_FIELD(name, ctype, ptype, nc, kept, present, unit, meaning) (present) ? PETSC_TRUE : PETSC_FALSE,
#include "fields.def"
#undef MPM_FIELD
  };

  PetscFunctionBeginUser;
  points->dim = mpm->grid.dim;
  PetscCall(DMCreate(comm, &points->swarm));
  PetscCall(DMSetType(points->swarm, DMSWARM));
  PetscCall(DMSetDimension(points->swarm, points->dim));
  PetscCall(DMSwarmSetType(points->swarm, DMSWARM_BASIC));
  PetscCall(DMSwarmInitializeFieldRegister(points->swarm));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const PetscInt nc = MPMFieldComponents(f, points->dim);
    size_t         size;

    PetscCall(PetscDataTypeGetSize(MPMFields[f].type, &size));
    points->present[f] = present[f];
    points->bytes[f]   = nc * (PetscInt)size;
    if (present[f] && MPMFields[f].kept) PetscCall(DMSwarmRegisterPetscDatatypeField(points->swarm, MPMFields[f].name, nc, MPMFields[f].type));
  }
  PetscCall(DMSwarmFinalizeFieldRegister(points->swarm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the number of points here; new ones have unset fields. Not collective. */
PetscErrorCode MPMPointsSetSize(MPMPoints *points, PetscInt n)
{
  PetscFunctionBeginUser;
  PetscCall(DMSwarmSetLocalSizes(points->swarm, n, MPM_SWARM_BUFFER));
  points->n = n;
  if (n > points->capacity) {
    points->capacity = n + n / 8 + MPM_SWARM_BUFFER;
    for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
      if (!points->present[f] || MPMFields[f].kept) continue;
      PetscCall(PetscFree(points->scratch[f]));
      PetscCall(PetscMalloc(points->capacity * points->bytes[f], &points->scratch[f]));
    }
    PetscCall(PetscFree(points->order));
    PetscCall(PetscMalloc1(points->capacity, &points->order));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fields (bits) of the points here; those not asked for, or not in this scene, are NULL. Restore before the number
   of points changes. Not collective.                                                                                 */
PetscErrorCode MPMPointsGetView(MPMPoints *points, PetscInt fields, MPMView *view)
{
  void *at[MPM_NUM_FIELDS] = {NULL};

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    if (!points->present[f] || !(fields & (1 << f))) continue;
    if (MPMFields[f].kept) PetscCall(DMSwarmGetField(points->swarm, MPMFields[f].name, NULL, NULL, &at[f]));
    else at[f] = points->scratch[f];
  }
  PetscCall(PetscMemzero(view, sizeof *view));
  view->n = points->n;
#define MPM_FIELD(name, ctype, ptype, nc, kept, present, unit, meaning) view->name = (ctype *)at[MPM_FIELD_INDEX_##name];
#include "fields.def"
#undef MPM_FIELD
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsRestoreView(MPMPoints *points, PetscInt fields, MPMView *view)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    void *at = NULL;

    if (points->present[f] && (fields & (1 << f)) && MPMFields[f].kept) PetscCall(DMSwarmRestoreField(points->swarm, MPMFields[f].name, NULL, NULL, &at));
  }
  PetscCall(PetscMemzero(view, sizeof *view));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts the storage into the order of `order`, which becomes the identity. */
static PetscErrorCode Reorder(MPMPoints *points)
{
  char *copy;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc(points->n * 9 * sizeof(PetscReal), &copy));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    const PetscInt b  = points->bytes[f];
    void          *at = points->scratch[f];

    if (!points->present[f]) continue;
    if (MPMFields[f].kept) PetscCall(DMSwarmGetField(points->swarm, MPMFields[f].name, NULL, NULL, &at));
    for (PetscInt q = 0; q < points->n; q++) memcpy(copy + q * b, (char *)at + points->order[q] * b, b);
    memcpy(at, copy, points->n * b);
    if (MPMFields[f].kept) PetscCall(DMSwarmRestoreField(points->swarm, MPMFields[f].name, NULL, NULL, &at));
  }
  for (PetscInt q = 0; q < points->n; q++) points->order[q] = q;
  points->since_reorder = 0;
  PetscCall(PetscFree(copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* order = points by (cell, id): a counting sort by cell, then insertion by id, which finds little to do since the
   storage is nearly in order.                                                                                        */
static void SortByCell(const MPMView *view, PetscInt ncells, PetscInt *start, PetscInt *order)
{
  for (PetscInt c = 0; c <= ncells; c++) start[c] = 0;
  for (PetscInt p = 0; p < view->n; p++) start[view->cell[p] + 1]++;
  for (PetscInt c = 0; c < ncells; c++) start[c + 1] += start[c];
  for (PetscInt p = 0; p < view->n; p++) order[start[view->cell[p]]++] = p;
  for (PetscInt c = ncells; c > 0; c--) start[c] = start[c - 1];
  start[0] = 0;
  for (PetscInt c = 0; c < ncells; c++)
    for (PetscInt q = start[c] + 1; q < start[c + 1]; q++) {
      const PetscInt p = order[q];
      PetscInt       r = q;

      for (; r > start[c] && view->id[order[r - 1]] > view->id[p]; r--) order[r] = order[r - 1];
      order[r] = p;
    }
}

/* Marks the rows of nodes that the points of each row of cells touch. */
static void MarkRows(const PetscInt *start, MPMPatch *patch)
{
  const PetscInt ns = MPMBasisNodes(patch->basis);

  for (PetscInt r = 0; r < patch->n[1] * patch->n[2]; r++) patch->row[r] = 0;
  for (PetscInt k = 0; k < patch->n[2]; k++)
    for (PetscInt j = 0; j < patch->n[1]; j++) {
      const PetscInt r = k * patch->n[1] + j;

      if (start[(r + 1) * patch->n[0]] == start[r * patch->n[0]]) continue;
      for (PetscInt kk = k; kk < PetscMin(k + ns, patch->n[2]); kk++)
        for (PetscInt jj = j; jj < PetscMin(j + ns, patch->n[1]); jj++) patch->row[kk * patch->n[1] + jj] = 1;
    }
}

/* Orders the points, whose `cell` is known, for the patch. Not collective. */
PetscErrorCode MPMPointsSort(MPMPoints *points, MPMPatch *patch)
{
  const PetscInt ncells = patch->n[0] * patch->n[1] * patch->n[2], fields = MPM_BIT(id) | MPM_BIT(cell);
  MPMView        view;

  PetscFunctionBeginUser;
  if (points->nstart < ncells + 1) {
    PetscCall(PetscFree(points->start));
    PetscCall(PetscMalloc1(ncells + 1, &points->start));
    points->nstart = ncells + 1;
  }
  PetscCall(MPMPointsGetView(points, fields, &view));
  SortByCell(&view, ncells, points->start, points->order);
  PetscCall(MPMPointsRestoreView(points, fields, &view));
  MarkRows(points->start, patch);
  if (++points->since_reorder >= MPM_REORDER_EVERY) PetscCall(Reorder(points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cells of all points anew and orders them: at the start. Notes points outside of the grid. Not collective. */
PetscErrorCode MPMPointsLocate(MPMPoints *points, MPMPatch *patch, MPMStatus *status)
{
  const PetscInt d = points->dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(cell);
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMPointsGetView(points, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscReal xi[3];
    PetscInt  base[3];

    view.cell[p] = 0;
    if (MPMLocate(d, patch->basis, patch->grid, view.x + p * d, xi, base)) view.cell[p] = MPMNodeIndex(d, patch, base);
    else MPMNoteBad(status, MPM_LEFT_GRID, view.id[p], d, view.x + p * d, 0);
  }
  PetscCall(MPMPointsRestoreView(points, fields, &view));
  points->since_reorder = MPM_REORDER_EVERY;
  PetscCall(MPMPointsSort(points, patch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A permutation of 64-bit words that mixes well (splitmix64's finaliser, Steele, Lea and Flood 2014). */
static uint64_t Mix(uint64_t z)
{
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/* A number of the state's bits: every kept field of every point, with its id; a sum of hashes, so without order. Equal
   digests mean the same bits in id, x, v, F and material state. Collective on comm.                                  */
PetscErrorCode MPMPointsDigest(MPMPoints *points, MPI_Comm comm, PetscInt64 *digest)
{
  uint64_t sum = 0;
  MPMView  view;

  PetscFunctionBeginUser;
  PetscCall(MPMPointsGetView(points, -1, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    uint64_t h = Mix((uint64_t)view.id[p] + 0x9e3779b97f4a7c15ULL);

#define MPM_FIELD(name, ctype, ptype, nc, kept, present, unit, meaning)                                   \
  if (kept && MPM_FIELD_INDEX_##name != MPM_FIELD_INDEX_kind && view.name)                                \
    for (PetscInt k = 0; k < points->bytes[MPM_FIELD_INDEX_##name] / 8; k++) {                            \
      uint64_t word;                                                                                      \
      memcpy(&word, (char *)view.name + p * points->bytes[MPM_FIELD_INDEX_##name] + 8 * k, sizeof word);  \
      h = Mix(h ^ word) + 0x9e3779b97f4a7c15ULL;                                                          \
    }
#include "fields.def"
#undef MPM_FIELD
    sum += h;
  }
  PetscCall(MPMPointsRestoreView(points, -1, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm));
  memcpy(digest, &sum, sizeof sum);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsDestroy(MPMPoints *points)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) PetscCall(PetscFree(points->scratch[f]));
  PetscCall(PetscFree(points->order));
  PetscCall(PetscFree(points->start));
  PetscCall(DMDestroy(&points->swarm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
