/* lattice.c - the iterator over the lattice places that lie in a body; lattice.h says what the lattice is. */
#include "scene/lattice.h"

/* Returns the number of the row in which place ijk [dim] lies. */
PetscInt64 MPMLatticeRow(const MPMLattice *w, const PetscInt64 ijk[])
{
  PetscInt64 row = 0;

  for (PetscInt d = 0; d < w->dim - 1; d++) row = row * (w->last[d] - w->first[d] + 1) + ijk[d] - w->first[d];
  return row;
}

/* Sets the iterator to the beginning of a row. */
static void GoToRow(MPMLattice *w, PetscInt64 row)
{
  w->row             = row;
  w->n               = 0;
  w->ijk[w->dim - 1] = w->first[w->dim - 1];
  for (PetscInt d = w->dim - 2; d >= 0; d--) {
    const PetscInt64 places = w->last[d] - w->first[d] + 1;

    w->ijk[d] = w->first[d] + row % places;
    row /= places;
  }
}

/* Returns an iterator over all rows of a body, before its first run. */
MPMLattice MPMLatticeBegin(const MPMBody *b, PetscInt dim)
{
  MPMLattice w = {.body = b, .dim = dim, .id = b->first};
  PetscReal  lower[3], upper[3];

  MPMRegionBounds(&b->region, dim, lower, upper);
  for (PetscInt d = 0; d < dim; d++) {
    w.first[d] = (PetscInt64)PetscFloorReal((lower[d] - b->offset[d]) / b->b[d] - 0.5);
    w.last[d]  = (PetscInt64)PetscCeilReal((upper[d] - b->offset[d]) / b->b[d] - 0.5);
  }
  if (b->round) { /* what is left of the axis is the mirror image of the body */
    w.first[0] = PetscMax(w.first[0], (PetscInt64)PetscCeilReal(-b->offset[0] / b->b[0] - 0.5));
    w.last[0]  = PetscMax(w.first[0], w.last[0]);
  }
  w.end = MPMLatticeRow(&w, w.last) + 1;
  GoToRow(&w, 0);
  return w;
}

/* Returns the first row of share k, by its number among the rows of body b: the rows of all bodies are divided into
   equal shares, one for each process. */
static PetscInt64 ShareRow(const MPMScene *scene, const MPMBody *b, PetscInt64 k, PetscMPIInt shares)
{
  return scene->rows * k / shares - b->row;
}

/* Returns an iterator over the rows of a body that are in the share of process `rank` of `size`. Its id does not say
   the number of a particle. */
MPMLattice MPMLatticeShare(const MPMScene *scene, const MPMBody *b, PetscInt dim, PetscMPIInt rank, PetscMPIInt size)
{
  MPMLattice w = MPMLatticeBegin(b, dim);

  w.end = PetscMin(w.end, ShareRow(scene, b, rank + 1, size));
  GoToRow(&w, PetscMax(0, ShareRow(scene, b, rank, size)));
  return w;
}

/* Sets X [dim], m, to the position of the particle at place k of the iterator's row. */
void MPMLatticePlace(const MPMLattice *w, PetscInt64 k, PetscReal X[3])
{
  const MPMBody *b = w->body;

  for (PetscInt d = 0; d < w->dim; d++)
    X[d] = ((PetscReal)(d == w->dim - 1 ? k : w->ijk[d]) + 0.5) * b->b[d] + b->offset[d];
}

/* Finds the next run of the row, from the iterator's place on. A solid body that no other cuts has one run a row. */
static PetscBool FindRun(MPMLattice *w)
{
  const PetscInt   d     = w->dim - 1;
  const MPMBody   *b     = w->body;
  const PetscBool  whole = MPMRegionSolid(&b->region) && !b->region.others;
  const PetscInt64 end   = w->last[d] + 1;
  PetscInt64       from  = w->ijk[d], to, next;
  MPMRow           row   = {.dim = w->dim, .spacing = b->b[d], .offset = b->offset[d]};

  if (whole && from > w->first[d]) return PETSC_FALSE; /* its only run is over */
  MPMLatticePlace(w, from, row.x);
  for (; from < end && !MPMRegionSpan(&b->region, &row, from, end, &to); from = to) continue;
  if (from >= end) return PETSC_FALSE;
  while (!whole && to < end && MPMRegionSpan(&b->region, &row, to, end, &next)) to = next;
  w->ijk[d] = from;
  w->n      = to - from;
  return PETSC_TRUE;
}

/* Goes to the next run. Returns false if there are no more; then id is the number after that of the last particle. */
PetscBool MPMLatticeNext(MPMLattice *w)
{
  w->id += w->n;
  w->ijk[w->dim - 1] += w->n;
  for (w->n = 0; w->row < w->end; GoToRow(w, w->row + 1))
    if (FindRun(w)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Sets an iterator to rows from .. to-1, of which the first particle has the number id. */
void MPMLatticeRows(MPMLattice *w, PetscInt64 from, PetscInt64 to, PetscInt64 id)
{
  GoToRow(w, from);
  w->end = to;
  w->id  = id;
}

/* Sets an iterator to rows from .. to-1. To find the number of their first particle, it counts from the last row before
   them where a share begins, whose first number is known. */
void MPMLatticeGoTo(const MPMScene *scene, MPMLattice *w, PetscInt64 from, PetscInt64 to)
{
  const PetscInt64 share = ((w->body->row + from + 1) * scene->shares - 1) / scene->rows;
  const PetscInt64 row   = ShareRow(scene, w->body, share, scene->shares);

  if (row > w->row) {
    GoToRow(w, row);
    w->id = scene->share_first[share];
  }
  for (w->end = from; MPMLatticeNext(w);) continue;
  w->end = to;
}
