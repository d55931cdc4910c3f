/* order.c - the order of the particles: `order` [n] lists them by (cell, id), and kernels visit them in this sequence,
   whatever the sequence of the storage is. Now and then the storage itself is put in order, since it is then read
   faster. The order is made after each step in which particles changed cell. */
#include "base/pages.h"
#include "kernels/cell.h"
#include "particles/box.h"
#include "particles/particles.h"

/* The storage is put in order after MPM_SCATTERED changes of cell per particle; until then kernels read it through
   `order`. A sort with unknown movers counts as if 4 % of the particles had moved, so the storage is put in order after
   10 of them. (Measured with 0.2 to 2: from 0.4 to 0.2 steps change by less than the noise, with 2 they take up to 8 %
   longer, since fewer blocks have rows that follow each other.) */
#define MPM_SCATTERED   0.4
#define MPM_MOVES_GUESS 0.04
#define MPM_RUN         16 /* mean length of common sequences from which on reordering gains nothing */

/* Moves rows of `bytes` along the cycles in path [npath], which FindCycles has found. */
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

/* Finds the cycles of an order, which becomes the identity; returns the length of path. It lists places cycle by cycle;
   the row at each place is replaced by that at the next one. The last place of a cycle takes the row that was at the
   first, and is marked by MPM_FLAGGED. */
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

/* Returns how many places after its entry in the order a particle has its row on average, modulo n: rows before the
   first are counted as those before the end of the storage. */
static PetscInt Turn(PetscInt n, const PetscInt order[])
{
  PetscInt64 sum = 0;

  for (PetscInt q = 0; q < n; q++) {
    const PetscInt places = order[q] - q;

    sum += places >= n / 2 ? places - n : places < -n / 2 ? places + n : places;
  }
  return (PetscInt)((sum / n + n) % n);
}

/* Puts the storage in the sequence of `order`, so that the row of entry q is q + turn, modulo n. With a turn of 0 all
   rows would move far where a process gets many particles, which come last in its storage, for the first of its cells.
   It needs no copy of a field, which could take half of the memory of the particles. The cycles are listed in the
   memory of `spare`. Not collective. */
static PetscErrorCode Reorder(MPMParticles *particles)
{
  const PetscInt n = particles->n, turn = Turn(n, particles->order);
  PetscInt      *path = particles->order, *order = particles->spare, npath;

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(order, path + n - turn, turn));
  PetscCall(PetscArraycpy(order + turn, path, n - turn));
  npath = FindCycles(n, order, path);
  for (PetscInt q = 0; q < n; q++) order[q] = q < n - turn ? q + turn : q + turn - n;
  particles->order = order;
  particles->spare = path;
  for (PetscInt f = 0; f < MPM_NUM_FIELDS; f++) {
    void *rows;

    if (!particles->present[f]) continue;
    PetscCall(MPMParticlesGetField(particles, f, &rows));
    MPM_FOR_WIDTH(particles->bytes[f], FollowCycles, npath, path, (char *)rows);
    PetscCall(MPMParticlesRestoreField(particles, f));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether order and storage differ much. Particles that move together, and arrivals that take the places of
   leavers, leave long sequences that both have in common; along these nothing is gained by putting the storage in
   order. */
static PetscBool Scattered(const MPMParticles *particles)
{
  PetscInt jumps = 0;

  for (PetscInt q = 1; q < particles->n; q++) jumps += particles->order[q] != particles->order[q - 1] + 1;
  return jumps > particles->n / MPM_RUN;
}

/* Makes the order by a counting sort by cell, then an insertion sort by id in each cell. The latter has little to do,
   since the storage is nearly in order. */
static void SortByCell(const MPMView *view, PetscInt ncells, PetscInt *start, PetscInt *order)
{
  for (PetscInt c = 0; c < ncells + 2; c++) start[c] = 0;
  for (PetscInt p = 0; p < view->n; p++) start[view->cell[p] + 2]++;
  for (PetscInt c = 2; c < ncells + 2; c++) start[c] += start[c - 1];
  for (PetscInt p = 0; p < view->n; p++) order[start[view->cell[p] + 1]++] = p; /* start[c + 1] becomes its value */
  for (PetscInt c = 0; c < ncells; c++)
    for (PetscInt q = start[c] + 1; q < start[c + 1]; q++) {
      const PetscInt p = order[q];
      PetscInt       r = q;

      for (; r > start[c] && view->id[order[r - 1]] > view->id[p]; r--) order[r] = order[r - 1];
      order[r] = p;
    }
}

/* Returns whether these n entries of the order include movers, which are marked by a number >= nkept. */
static PetscBool HasMovers(const PetscInt *order, PetscInt n, PetscInt nkept)
{
  PetscInt most = -1;

  for (PetscInt q = 0; q < n; q++) most = PetscMax(most, order[q]);
  return most >= nkept;
}

/* Makes the order from the one before and its movers. All other particles keep their sequence: cells are copied without
   the movers, with room for the particles that come to them, which are then inserted by id. Rows of `row` cells that no
   particle left or came to are copied as they are. After a migration, other particles have the places of leavers and
   those from nkept on: these are treated as particles that come. Not collective. */
static PetscErrorCode MergeMovers(const MPMView *view, PetscInt ncells, PetscInt row, MPMParticles *particles)
{
  PetscInt *order = particles->order, *start = particles->start, *to = particles->spare,
           *incoming  = particles->incoming;
  PetscInt      *come = particles->movers, nincoming = 0, at = 0;
  const PetscInt nkept = particles->nkept;
  PetscBool     *comes; /* particles come to the row of cells */

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < particles->nmovers; m++) {
    const PetscInt q = particles->movers[m] < 0 ? MPM_FLAGGED(particles->movers[m]) : particles->movers[m],
                   p = order[q];

    order[q] = nkept;
    if (p < nkept) come[nincoming++] = p;
  }
  for (PetscInt p = nkept; p < view->n; p++) come[nincoming++] = p;
  PetscCall(PetscCalloc1(ncells / row, &comes));
  for (PetscInt m = 0; m < nincoming; m++) {
    incoming[view->cell[come[m]]]++;
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
      at += incoming[c];
    }
  }
  start[ncells] = at;
  for (PetscInt m = 0; m < nincoming; m++) {
    const PetscInt p = come[m], c = view->cell[p];
    PetscInt       r = start[c + 1] - incoming[c]--;

    for (; r > start[c] && view->id[to[r - 1]] > view->id[p]; r--) to[r] = to[r - 1];
    to[r] = p;
  }
  PetscCall(PetscFree(comes));
  particles->spare = order;
  particles->order = to;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the leavers, ascending: which [n] is allocated here, and the caller frees it. Not collective. */
PetscErrorCode MPMParticlesLeavers(MPMParticles *particles, PetscInt *n, PetscInt **which)
{
  const PetscBool all        = particles->nmovers < 0;
  const PetscInt  candidates = all ? particles->n : particles->nmovers, *movers = particles->movers;
  MPMView         view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(particles, MPM_BIT(cell), &view));
  for (PetscInt round = 0; round < 2; round++) {
    *n = 0;
    for (PetscInt m = 0; m < candidates; m++) {
      const PetscInt p = all ? m : movers[m] < 0 ? particles->order[MPM_FLAGGED(movers[m])] : -1;

      if (p < 0 || view.cell[p] != MPM_ELSEWHERE) continue; /* those outside the grid are to be removed */
      if (round) (*which)[*n] = p;
      ++*n;
    }
    if (!round) PetscCall(PetscMalloc1(*n, which));
  }
  PetscCall(MPMParticlesRestoreView(particles, MPM_BIT(cell), &view));
  PetscCall(PetscSortInt(*n, *which));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the order of the particles, whose `cell` is known, for the patch: sets order and start. Not collective. */
PetscErrorCode MPMParticlesSort(MPMParticles *particles, const MPMPatch *patch)
{
  const PetscInt ncells = MPMTilesCells(patch), fields = MPM_BIT(id) | MPM_BIT(cell);
  MPMView        view;

  PetscFunctionBeginUser;
  if (particles->nstart < ncells + 2) {
    PetscCall(PetscFree(particles->start));
    PetscCall(PetscFree(particles->incoming));
    PetscCall(PetscMalloc1(ncells + 2, &particles->start));
    PetscCall(MPMPagesCalloc((size_t)(ncells + 2) * sizeof *particles->incoming, &particles->incoming));
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
  particles->nmovers = -1;
  particles->nkept   = particles->n;
  PetscCall(MPMParticlesRestoreView(particles, fields, &view));
  if (particles->scattered >= MPM_SCATTERED * (PetscReal)particles->n) {
    if (Scattered(particles)) PetscCall(Reorder(particles));
    particles->scattered = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the cells of all particles anew and makes the order. All must lie in cells of the patch. Not collective. */
PetscErrorCode MPMParticlesLocate(MPMParticles *particles, const MPMPatch *patch, const MPMKind *kinds)
{
  const PetscInt d      = particles->dim,
                 fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(X) | MPM_BIT(cell) | MPM_BIT(kind) | MPM_BIT(l);
  MPMView view;

  PetscFunctionBeginUser;
  PetscCall(MPMParticlesGetView(particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    PetscInt base[3] = {0};

    view.cell[p] = MPMOwnCell((int)d, patch->basis, patch, MPMKindOf(kinds, &view, p)->copy,
                              MPMPlaces(patch->grid, &view) + p * d, MPMHalfWidths((int)d, kinds, &view, p), base);
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
