/* points.c - the material points: storage, views, canonical order, digest.

   The fields of fields.def are fields of a DMSWARM_BASIC swarm, so PETSc stores and moves them; scratch fields are
   plain arrays beside it. `order` lists the points by (cell, id): the order in which kernels visit them, the same
   whatever the storage looks like. The storage itself is put in that order now and then, for the cache. */
#include "cell.h"

/* The storage is put in order after so many changes of cell for each point; in between, sweeps read it through `order`.
   A sort that does not know its movers counts as if 4 % had moved: every 50 of them. (More often: 3-D gains up to 4 %
   where points move 5 % of a cell a step, 2-D loses as much.) */
#define MPM_SCATTERED   2
#define MPM_MOVES_GUESS 0.04
#define MPM_ROW_BYTES   (9 * sizeof(PetscReal)) /* of a field, at most: a tensor in 3-D */
#define MPM_RUN         16 /* runs of so many points in the order, on average: they need no reordering */
/* Room for points to come in the swarm, besides n/500. Small, since PETSc before 3.25 clears all of it at each removal;
   not smaller, since the swarm moves all fields to new memory when points come that find no room.                    */
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

/* Bytes that a point takes: of its state, of all that the swarm moves, or with the scratch. */
PetscInt MPMPointsBytes(const MPMPoints *points, MPMHome most)
{
  PetscInt bytes = 0;

  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (points->present[f] && MPMFields[f].home <= most) bytes += points->bytes[f];
  return bytes;
}

/* Bytes of memory that a point takes here: its fields, with the process that every swarm keeps, and the orders of now
   and of before. */
PetscInt MPMPointsMemory(const MPMPoints *points)
{
  return MPMPointsBytes(points, MPM_SCRATCH) + 3 * (PetscInt)sizeof(PetscInt);
}

/* Does a material of the scene list this field in its state? */
static PetscBool Keeps(const MPMScene *scene, PetscInt bit)
{
  for (PetscInt k = 0; k < scene->nmaterials; k++)
    if (scene->materials[k].state & bit) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Which fields the scene needs, and their bytes. Not collective. */
PetscErrorCode MPMPointsLayout(MPM mpm, MPMPoints *points)
{
#define KEEPS(name) Keeps(&mpm->scene, MPM_BIT(name))
  const PetscBool present[] = {
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning) (present) ? PETSC_TRUE : PETSC_FALSE,
#include "fields.def"
#undef MPM_FIELD
  };
#undef KEEPS

  PetscFunctionBeginUser;
  points->dim = mpm->grid.dim;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    size_t size;

    PetscCall(PetscDataTypeGetSize(MPMFields[f].type, &size));
    points->present[f] = present[f];
    points->bytes[f]   = MPMFieldComponents(f, points->dim) * (PetscInt)size;
    PetscCheck((size_t)points->bytes[f] <= MPM_ROW_BYTES, PETSC_COMM_SELF, PETSC_ERR_SUP,
               "field %s has rows of %" PetscInt_FMT " bytes, more than MPM_ROW_BYTES", MPMFields[f].name,
               points->bytes[f]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* What the swarm calls a field. */
static const char *SwarmName(PetscInt field)
{
  return field == MPM_FIELD_INDEX_id ? DMSwarmField_pid : MPMFields[field].name;
}

/* Registers the fields that the scene needs, and no more. Collective on comm. */
PetscErrorCode MPMPointsCreate(MPM mpm, MPMPoints *points, MPI_Comm comm)
{
  PetscFunctionBeginUser;
  PetscCall(MPMPointsLayout(mpm, points));
  PetscCall(DMCreate(comm, &points->swarm));
  PetscCall(DMSetType(points->swarm, DMSWARM));
  PetscCall(DMSetDimension(points->swarm, points->dim));
  PetscCall(DMSwarmSetType(points->swarm, DMSWARM_BASIC));
  PetscCall(DMSwarmInitializeFieldRegister(points->swarm));
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (points->present[f] && MPMFields[f].home != MPM_SCRATCH && f != MPM_FIELD_INDEX_id)
      PetscCall(DMSwarmRegisterPetscDatatypeField(points->swarm, MPMFields[f].name, MPMFieldComponents(f, points->dim),
                                                  MPMFields[f].type));
  PetscCall(DMSwarmFinalizeFieldRegister(points->swarm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the swarm's size, after points came and went, and makes room for the scratch of so many. Keeps order and
   movers. Not collective. */
PetscErrorCode MPMPointsResize(MPMPoints *points)
{
  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(points->swarm, &points->n));
  if (points->n <= points->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  points->capacity = points->n + points->n / 8 + MPM_SWARM_BUFFER;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    if (!points->present[f] || MPMFields[f].home != MPM_SCRATCH) continue;
    PetscCall(PetscFree(points->scratch[f]));
    PetscCall(PetscCalloc1((size_t)points->capacity * (size_t)points->bytes[f], (char **)&points->scratch[f]));
  }
  PetscCall(PetscRealloc((size_t)(points->capacity + 1) * sizeof *points->order, &points->order));
  PetscCall(PetscRealloc((size_t)points->capacity * sizeof *points->movers, &points->movers));
  PetscCall(PetscFree(points->spare));
  PetscCall(PetscMalloc1(points->capacity + 1, &points->spare));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the number of points here; new ones have unset fields. Not collective. */
PetscErrorCode MPMPointsSetSize(MPMPoints *points, PetscInt n)
{
  PetscFunctionBeginUser;
  PetscCall(DMSwarmSetLocalSizes(points->swarm, n, MPM_SWARM_BUFFER + n / 500));
  PetscCall(MPMPointsResize(points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The array of a field that the scene has: [n][components]. The id is the number that every swarm keeps of its points.
   Restore before the number of points changes. Not collective. */
PetscErrorCode MPMPointsGetField(MPMPoints *points, PetscInt field, void **at)
{
  PetscFunctionBeginUser;
  if (MPMFields[field].home == MPM_SCRATCH)
    *at = points->scratch[field];
  else
    PetscCall(DMSwarmGetField(points->swarm, SwarmName(field), NULL, NULL, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsRestoreField(MPMPoints *points, PetscInt field)
{
  void *at;

  PetscFunctionBeginUser;
  if (MPMFields[field].home != MPM_SCRATCH)
    PetscCall(DMSwarmRestoreField(points->swarm, SwarmName(field), NULL, NULL, &at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fields (bits) of the points here; those not asked for, or not in this scene, are NULL. Restore before the number
   of points changes. Not collective.                                                                                 */
PetscErrorCode MPMPointsGetView(MPMPoints *points, PetscInt fields, MPMView *view)
{
  void *at[MPM_NUM_FIELDS] = {NULL};

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (points->present[f] && (fields & (1 << f))) PetscCall(MPMPointsGetField(points, f, &at[f]));
  PetscCall(PetscMemzero(view, sizeof *view));
  view->n = points->n;
#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  view->name = (ctype *)at[MPM_FIELD_INDEX_##name];
#include "fields.def"
#undef MPM_FIELD
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsRestoreView(MPMPoints *points, PetscInt fields, MPMView *view)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    if (points->present[f] && (fields & (1 << f))) PetscCall(MPMPointsRestoreField(points, f));
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
      const PetscInt next = path[k + 1] < 0 ? MPM_MARK(path[k + 1]) : path[k + 1];

      memcpy(rows + (size_t)path[k] * bytes, rows + (size_t)next * bytes, bytes);
    }
    memcpy(rows + (size_t)MPM_MARK(path[k]) * bytes, first, bytes);
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
    path[npath - 1] = MPM_MARK(path[npath - 1]);
  }
  return npath;
}

/* Puts the storage into the order of `order`, which becomes the identity. In place: a copy of the largest field would
   be up to half of the memory of the points. The path along the cycles is in the room of the order before. */
static PetscErrorCode Reorder(MPMPoints *points)
{
  const PetscInt *path  = points->spare;
  const PetscInt  npath = FindCycles(points->n, points->order, points->spare);

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    void *rows;

    if (!points->present[f]) continue;
    PetscCall(MPMPointsGetField(points, f, &rows));
    MPM_FOR_WIDTH(points->bytes[f], FollowCycles, npath, path, (char *)rows);
    PetscCall(MPMPointsRestoreField(points, f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is the order far from that of the storage? Points that move together, and those that come from other processes and
   take the places of leavers, leave long runs, along which nothing is gained by putting the storage in order. */
static PetscBool Scattered(const MPMPoints *points)
{
  PetscInt jumps = 0;

  for (PetscInt q = 1; q < points->n; q++) jumps += points->order[q] != points->order[q - 1] + 1;
  return jumps > points->n / MPM_RUN ? PETSC_TRUE : PETSC_FALSE;
}

/* order = points by (cell, id): a counting sort by cell, then insertion by id, which finds little to do since the
   storage is nearly in order.                                                                                        */
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

/* Does this part of the order have places of points that changed cell or left? */
static PetscBool HasMovers(const PetscInt *order, PetscInt n, PetscInt nkept)
{
  PetscInt most = -1;

  for (PetscInt q = 0; q < n; q++) most = PetscMax(most, order[q]);
  return most >= nkept ? PETSC_TRUE : PETSC_FALSE;
}

/* The same from the order before and the places in it of the points that changed cell or left: the others keep their
   turns, so cells are copied without them and leave room for comers, which then find their place by id. Rows of `row`
   cells without movers are copied as they are. After a migration other points are where leavers were and from nkept on:
   they are comers too. */
static PetscErrorCode MergeMovers(const MPMView *view, PetscInt ncells, PetscInt row, MPMPoints *points)
{
  PetscInt      *order = points->order, *start = points->start, *to = points->spare, *comers = points->comers;
  PetscInt      *come = points->movers, ncome = 0, at = 0;
  const PetscInt nkept = points->nkept;
  PetscBool     *comes; /* to a row */

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < points->nmovers; m++) {
    const PetscInt q = points->movers[m] < 0 ? MPM_MARK(points->movers[m]) : points->movers[m], p = order[q];

    order[q] = nkept;
    if (p < nkept) come[ncome++] = p;
  }
  for (PetscInt p = nkept; p < view->n; p++) come[ncome++] = p;
  PetscCall(PetscCalloc1(ncells / row, &comes));
  for (PetscInt m = 0; m < ncome; m++) {
    comers[view->cell[come[m]]]++;
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
      at += comers[c];
    }
  }
  start[ncells] = at;
  for (PetscInt m = 0; m < ncome; m++) {
    const PetscInt p = come[m], c = view->cell[p];
    PetscInt       r = start[c + 1] - comers[c]--;

    for (; r > start[c] && view->id[to[r - 1]] > view->id[p]; r--) to[r] = to[r - 1];
    to[r] = p;
  }
  PetscCall(PetscFree(comes));
  points->spare = order;
  points->order = to;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the points that left the patch, ascending: which [n], allocated here. Not collective. */
PetscErrorCode MPMPointsLeavers(MPMPoints *points, PetscInt *n, PetscInt **which)
{
  const PetscBool all        = points->nmovers < 0 ? PETSC_TRUE : PETSC_FALSE;
  const PetscInt  candidates = all ? points->n : points->nmovers, *movers = points->movers;
  MPMView         view;

  PetscFunctionBeginUser;
  PetscCall(MPMPointsGetView(points, MPM_BIT(cell), &view));
  for (PetscInt pass = 0; pass < 2; pass++) {
    *n = 0;
    for (PetscInt m = 0; m < candidates; m++) {
      if (all ? view.cell[m] >= 0 : movers[m] >= 0) continue;
      if (pass) (*which)[*n] = all ? m : points->order[MPM_MARK(movers[m])];
      ++*n;
    }
    if (!pass) PetscCall(PetscMalloc1(*n, which));
  }
  PetscCall(MPMPointsRestoreView(points, MPM_BIT(cell), &view));
  PetscCall(PetscSortInt(*n, *which));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Orders the points, whose `cell` is known, for the patch: sets order and start. Not collective. */
PetscErrorCode MPMPointsSort(MPMPoints *points, const MPMPatch *patch)
{
  const PetscInt ncells = MPMTilesCells(patch), fields = MPM_BIT(id) | MPM_BIT(cell);
  MPMView        view;

  PetscFunctionBeginUser;
  if (points->nstart < ncells + 2) {
    PetscCall(PetscFree2(points->start, points->comers));
    PetscCall(PetscMalloc2(ncells + 2, &points->start, ncells + 2, &points->comers));
    PetscCall(PetscArrayzero(points->comers, ncells + 2));
    points->nstart  = ncells + 2;
    points->nmovers = -1;
  }
  PetscCall(MPMPointsGetView(points, fields, &view));
  points->scattered += points->nmovers < 0 ? MPM_MOVES_GUESS * (PetscReal)points->n : (PetscReal)points->nmovers;
  if (points->nmovers < 0)
    SortByCell(&view, ncells, points->start, points->order);
  else
    PetscCall(MergeMovers(&view, ncells, patch->tiles.n[0] << patch->tiles.bits, points));
  MPMSimulateWork("SORT", view.n);
  points->nmovers = -1;
  points->nkept   = points->n;
  PetscCall(MPMPointsRestoreView(points, fields, &view));
  if (points->scattered >= MPM_SCATTERED * (PetscReal)points->n) {
    if (Scattered(points)) PetscCall(Reorder(points));
    points->scattered = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cells of all points anew and orders them. All must lie in cells of the patch. Not collective. */
PetscErrorCode MPMPointsLocate(MPMPoints *points, const MPMPatch *patch, const MPMKind *kinds)
{
  const PetscInt d = points->dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(cell) | MPM_BIT(kind) | MPM_BIT(l);
  MPMView        view;

  PetscFunctionBeginUser;
  PetscCall(MPMPointsGetView(points, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscInt base[3] = {0};

    view.cell[p] = MPMOwnCell((int)d, patch->basis, patch, view.x + p * d, MPMHalfWidths((int)d, kinds, &view, p),
                              base);
    PetscCheck(view.cell[p] >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB,
               "point %" PetscInt64_FMT " at (%g, %g, %g) is on the wrong process", view.id[p], (double)view.x[p * d],
               (double)(d > 1 ? view.x[p * d + 1] : 0), (double)(d > 2 ? view.x[p * d + 2] : 0));
  }
  PetscCall(MPMPointsRestoreView(points, fields, &view));
  points->scattered = PETSC_MAX_REAL;
  points->nmovers   = -1;
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

/* What a point counts for in the fingerprint: id (id + 1), modulo 2^64. */
uint64_t MPMPointMark(PetscInt64 id)
{
  return (uint64_t)id * (uint64_t)(id + 1);
}

/* The sum of the marks of the points here, modulo 2^64. Of all processes, with the number of points: one that is lost
   or doubled changes the number, and one that stands in the place of another changes the sum. Of several at once it
   misses those that leave both as they are: 0 and 6 doubled, 3 and 5 lost. It says nothing of their state. Not
   collective. */
PetscErrorCode MPMPointsFingerprint(MPMPoints *points, PetscInt64 *ids)
{
  uint64_t sum = 0;
  MPMView  view;

  PetscFunctionBeginUser;
  PetscCall(MPMPointsGetView(points, MPM_BIT(id), &view));
  for (PetscInt p = 0; p < view.n; p++) sum += MPMPointMark(view.id[p]);
  PetscCall(MPMPointsRestoreView(points, MPM_BIT(id), &view));
  *ids = (PetscInt64)sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first id that is not there once, and how often it is, or -1. Collective on comm. */
static PetscErrorCode FirstWrong(MPMPoints *points, MPI_Comm comm, PetscBool doubled, PetscInt64 *wrong)
{
  PetscInt   *count;
  PetscMPIInt len;
  MPMView     view;

  PetscFunctionBeginUser;
  *wrong = -1;
  PetscCall(PetscMPIIntCast((PetscInt)points->total, &len));
  PetscCall(PetscCalloc1(points->total, &count));
  PetscCall(MPMPointsGetView(points, MPM_BIT(id), &view));
  for (PetscInt p = 0; p < view.n; p++)
    if (view.id[p] >= 0 && view.id[p] < points->total) count[view.id[p]]++;
  PetscCall(MPMPointsRestoreView(points, MPM_BIT(id), &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, len, MPIU_INT, MPI_SUM, comm));
  for (PetscInt64 id = points->total - 1; id >= 0; id--)
    if (doubled ? count[id] > 1 : count[id] == 0) *wrong = id;
  PetscCall(PetscFree(count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names the points that are missing and there twice, after the fingerprints have told that there are some: ids, and of
   a doubled one a process that has it and where. Collective on comm.                                                 */
static PetscErrorCode DescribeLoss(MPMPoints *points, MPI_Comm comm, char what[], size_t len)
{
  PetscInt64  missing, doubled;
  PetscMPIInt rank, holder = -1;
  PetscReal   x[3] = {0};
  MPMView     view;
  size_t      at = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(FirstWrong(points, comm, PETSC_FALSE, &missing));
  PetscCall(FirstWrong(points, comm, PETSC_TRUE, &doubled));
  PetscCall(MPMPointsGetView(points, MPM_BIT(id) | MPM_BIT(x), &view));
  for (PetscInt p = 0; p < view.n; p++)
    if (doubled >= 0 && view.id[p] == doubled) {
      holder = rank;
      for (PetscInt d = 0; d < points->dim; d++) x[d] = view.x[p * points->dim + d];
    }
  PetscCall(MPMPointsRestoreView(points, MPM_BIT(id) | MPM_BIT(x), &view));
  what[0] = 0;
  if (missing >= 0) at = (size_t)snprintf(what, len, "point %" PetscInt64_FMT " is missing", missing);
  if (doubled >= 0) {
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &holder, 1, MPI_INT, MPI_MAX, comm));
    PetscCallMPI(MPI_Bcast(x, 3, MPIU_REAL, holder, comm));
    (void)snprintf(what + at, len - at,
                   "%spoint %" PetscInt64_FMT " is there more than once, on process %d at (%g, %g, %g)", at ? "; " : "",
                   doubled, holder, (double)x[0], (double)x[1], (double)x[2]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Raises an error if n points with the fingerprint `ids`, counted over comm, cannot be those of the scene, each once.
   The first call remembers what is right. Collective on comm. */
PetscErrorCode MPMPointsCheck(MPMPoints *points, MPI_Comm comm, PetscInt64 n, PetscInt64 ids)
{
  char what[MPM_TEXT_LEN];

  PetscFunctionBeginUser;
  if (!points->ids) points->ids = ids;
  if (n == points->total && ids == points->ids) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DescribeLoss(points, comm, what, sizeof what));
  SETERRQ(comm, PETSC_ERR_PLIB,
          "points got lost or doubled on the way between processes: %" PetscInt64_FMT " of %" PetscInt64_FMT "; %s", n,
          points->total, what);
}

/* A number of the state's bits: every state field of every point, with its id; a sum of hashes, so without order. Equal
   digests mean the same bits in id, x, v, F and material state. Collective on comm.                                  */
PetscErrorCode MPMPointsDigest(MPMPoints *points, MPI_Comm comm, PetscInt64 *digest)
{
  uint64_t sum = 0;
  MPMView  view;

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++)
    PetscCheck(MPMFields[f].home != MPM_STATE || f == MPM_FIELD_INDEX_kind || points->bytes[f] % 8 == 0, comm,
               PETSC_ERR_PLIB, "field %s of the state is not made of words of 8 bytes", MPMFields[f].name);
  PetscCall(MPMPointsGetView(points, -1, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    uint64_t h = Mix((uint64_t)view.id[p] + 0x9e3779b97f4a7c15ULL);

#define MPM_FIELD(name, ctype, ptype, nc, home, present, start, unit, meaning)                                         \
  if (home == MPM_STATE && MPM_FIELD_INDEX_##name != MPM_FIELD_INDEX_kind && view.name)                                \
    for (PetscInt k = 0; k < points->bytes[MPM_FIELD_INDEX_##name] / 8; k++) {                                         \
      uint64_t word;                                                                                                   \
      memcpy(&word, (char *)view.name + (size_t)p * (size_t)points->bytes[MPM_FIELD_INDEX_##name] + 8 * k,             \
             sizeof word);                                                                                             \
      h = Mix(h ^ word) + 0x9e3779b97f4a7c15ULL;                                                                       \
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

void MPMPointsState(PetscInt dim, const MPMView *view, PetscInt p, MPMBlock *b)
{
#define MPM_STATE_OF(name, rows)                                                                                       \
  if (view->name)                                                                                                      \
    for (int k = 0; k < MPMComponents_##name((int)dim); k++)                                                           \
      b->name[k][0] = view->name[p * MPMComponents_##name((int)dim) + k];
  MPM_MATERIAL_FIELDS(MPM_STATE_OF)
#undef MPM_STATE_OF
}

PetscErrorCode MPMPointsDestroy(MPMPoints *points)
{
  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) PetscCall(PetscFree(points->scratch[f]));
  PetscCall(PetscFree(points->order));
  PetscCall(PetscFree(points->spare));
  PetscCall(PetscFree(points->movers));
  PetscCall(PetscFree2(points->start, points->comers));
  PetscCall(DMDestroy(&points->swarm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
