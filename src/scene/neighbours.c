/* neighbours.c - the numbers of a body's particles as places of its lattice, and back: a table of the runs of places in
   its rows, of which there are far fewer than particles. Every process has all of it. */
#include "scene/neighbours.h"

/* Returns whether matter of a law that parts has come apart by the grid alone: solids that carry tension. Fluids have
   no neighbours, and soils open by themselves (field vc). */
PetscBool MPMNeighboursMay(const MPMMaterial *m)
{
  return MPMMaterialKeepsShape(m);
}

/* Appends the runs of this process's share of the rows: mine [n][3], row, place and number of places of each. */
static PetscErrorCode FindRuns(const MPMScene *scene, const MPMBody *b, PetscInt dim, PetscMPIInt rank,
                               PetscMPIInt size, PetscInt *n, PetscInt64 **mine)
{
  MPMLattice w    = MPMLatticeShare(scene, b, dim, rank, size);
  PetscInt   room = 0;

  PetscFunctionBeginUser;
  *n    = 0;
  *mine = NULL;
  while (MPMLatticeNext(&w)) {
    if (*n == room) {
      room = 2 * room + 64;
      PetscCall(PetscRealloc(3 * (size_t)room * sizeof **mine, mine));
    }
    (*mine)[3 * *n]     = w.row;
    (*mine)[3 * *n + 1] = w.ijk[dim - 1];
    (*mine)[3 * *n + 2] = w.n;
    ++*n;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes the table of a body. Collective on core->comm. */
PetscErrorCode MPMNeighboursCreate(const MPMScene *scene, const MPMCore *core, const MPMBody *b, MPMNeighbours *nb)
{
  PetscInt    n;
  PetscInt64 *mine, *all, id = b->first;
  PetscMPIInt rank, size, here, *counts, *starts;

  PetscFunctionBeginUser;
  nb->body    = b;
  nb->lattice = MPMLatticeBegin(b, core->grid.dim);
  nb->rows    = (PetscInt)nb->lattice.end;
  PetscCallMPI(MPI_Comm_rank(core->comm, &rank));
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCall(FindRuns(scene, b, core->grid.dim, rank, size, &n, &mine));
  here = (PetscMPIInt)(3 * n);
  PetscCall(PetscMalloc2(size, &counts, size + 1, &starts));
  PetscCallMPI(MPI_Allgather(&here, 1, MPI_INT, counts, 1, MPI_INT, core->comm));
  starts[0] = 0;
  for (PetscMPIInt k = 0; k < size; k++) starts[k + 1] = starts[k] + counts[k];
  nb->nruns = starts[size] / 3;
  PetscCall(PetscMalloc1(PetscMax(1, starts[size]), &all));
  PetscCallMPI(MPI_Allgatherv(mine, here, MPIU_INT64, all, counts, starts, MPIU_INT64, core->comm));
  PetscCall(PetscMalloc1(PetscMax(1, nb->nruns), &nb->run));
  PetscCall(PetscCalloc1(nb->rows + 1, &nb->start));
  for (PetscInt k = 0; k < nb->nruns; k++) {
    nb->run[k] = (MPMLatticeRun){all[3 * k + 1], all[3 * k + 2], id, all[3 * k]};
    id += nb->run[k].n;
    nb->start[all[3 * k] + 1]++;
  }
  for (PetscInt row = 0; row < nb->rows; row++) nb->start[row + 1] += nb->start[row];
  PetscCheck(id == b->first + b->n, PETSC_COMM_SELF, PETSC_ERR_PLIB, "%s has %" PetscInt64_FMT " places", b->name, id);
  PetscCall(PetscFree(all));
  PetscCall(PetscFree(mine));
  PetscCall(PetscFree2(counts, starts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Not collective. */
PetscErrorCode MPMNeighboursDestroy(MPMNeighbours *nb)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(nb->run));
  PetscCall(PetscFree(nb->start));
  nb->body = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets ijk [dim] to the place of a particle of the body. Its run is where it would be if all were equally long, as they
   are in a box, or is found by bisection. Not collective. */
void MPMNeighboursPlace(const MPMNeighbours *nb, PetscInt64 id, PetscInt64 ijk[3])
{
  const MPMLattice *w    = &nb->lattice;
  const PetscInt    last = w->dim - 1;
  PetscInt          k    = (PetscInt)((id - nb->body->first) * nb->nruns / nb->body->n);
  PetscInt64        row;

  if (id < nb->run[k].id || id >= nb->run[k].id + nb->run[k].n) {
    PetscInt end = nb->nruns;

    for (k = 0; end - k > 1;) {
      const PetscInt middle = k + (end - k) / 2;

      if (nb->run[middle].id <= id)
        k = middle;
      else
        end = middle;
    }
  }
  ijk[last] = nb->run[k].place + id - nb->run[k].id;
  row       = nb->run[k].row;
  for (PetscInt d = last - 1; d >= 0; d--) {
    const PetscInt64 places = w->last[d] - w->first[d] + 1;

    ijk[d] = w->first[d] + row % places;
    row /= places;
  }
}

/* Returns the id of the particle at place ijk [dim] of the body's lattice, or -1 if there is none. Not collective. */
PetscInt64 MPMNeighboursId(const MPMNeighbours *nb, const PetscInt64 ijk[3])
{
  const MPMLattice *w    = &nb->lattice;
  const PetscInt    last = w->dim - 1;
  PetscInt64        row;

  for (PetscInt d = 0; d < last; d++)
    if (ijk[d] < w->first[d] || ijk[d] > w->last[d]) return -1;
  row = MPMLatticeRow(w, ijk);
  for (PetscInt k = nb->start[row]; k < nb->start[row + 1]; k++)
    if (ijk[last] >= nb->run[k].place && ijk[last] < nb->run[k].place + nb->run[k].n)
      return nb->run[k].id + ijk[last] - nb->run[k].place;
  return -1;
}
