/* lattice.c - see lattice.h. */
#include "scene/lattice.h"

/* The row of the places ijk. */
PetscInt64 MPMLatticeRow(const MPMLattice *w, const PetscInt64 ijk[])
{
  PetscInt64 row = 0;

  for (PetscInt d = 0; d < w->dim - 1; d++) row = row * (w->last[d] - w->first[d] + 1) + ijk[d] - w->first[d];
  return row;
}

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

MPMLattice MPMLatticeBegin(const MPMBody *b, PetscInt dim)
{
  MPMLattice w = {.body = b, .dim = dim, .id = b->first};
  PetscReal  lower[3], upper[3];

  MPMRegionBounds(&b->region, dim, lower, upper);
  for (PetscInt d = 0; d < dim; d++) {
    w.first[d] = (PetscInt64)PetscFloorReal((lower[d] - b->offset[d]) / b->b[d] - 0.5);
    w.last[d]  = (PetscInt64)PetscCeilReal((upper[d] - b->offset[d]) / b->b[d] - 0.5);
  }
  w.end = MPMLatticeRow(&w, w.last) + 1;
  GoToRow(&w, 0);
  return w;
}

/* The rows of all bodies in equal shares, one a process: the first of share k among the rows of a body. */
static PetscInt64 ShareRow(const MPMScene *scene, const MPMBody *b, PetscInt64 k, PetscMPIInt shares)
{
  return scene->rows * k / shares - b->row;
}

/* A walk over the rows of a body that are in this process's share. Its id means nothing. */
MPMLattice MPMLatticeShare(const MPMScene *scene, const MPMBody *b, PetscInt dim, PetscMPIInt rank, PetscMPIInt size)
{
  MPMLattice w = MPMLatticeBegin(b, dim);

  w.end = PetscMin(w.end, ShareRow(scene, b, rank + 1, size));
  GoToRow(&w, PetscMax(0, ShareRow(scene, b, rank, size)));
  return w;
}

/* The position X of the particle at place k of the walk's row. */
void MPMLatticePlace(const MPMLattice *w, PetscInt64 k, PetscReal X[3])
{
  const MPMBody *b = w->body;

  for (PetscInt d = 0; d < w->dim; d++)
    X[d] = ((PetscReal)(d == w->dim - 1 ? k : w->ijk[d]) + 0.5) * b->b[d] + b->offset[d];
}

static PetscBool Inside(const MPMLattice *w, PetscInt64 k)
{
  PetscReal X[3];

  MPMLatticePlace(w, k, X);
  return MPMRegionInside(&w->body->region, w->dim, X);
}

/* Of the places between one inside and one outside of the body, the last inside. */
static PetscInt64 LastInside(const MPMLattice *w, PetscInt64 inside, PetscInt64 outside)
{
  while (PetscAbs(outside - inside) > 1) {
    const PetscInt64 middle = inside + (outside - inside) / 2;

    if (Inside(w, middle))
      inside = middle;
    else
      outside = middle;
  }
  return inside;
}

/* Finds the next run of the row, at or after where the walk is. In a solid body it is around the middle, so that not
   every particle need be looked at: there may be billions. */
static PetscBool FindRun(MPMLattice *w)
{
  const PetscInt   d    = w->dim - 1;
  const MPMBody   *b    = w->body;
  const PetscInt64 last = w->last[d];
  PetscInt64       from = w->ijk[d], to;
  PetscReal        lower[3], upper[3];

  if (MPMRegionSolid(&b->region)) {
    PetscInt64 middle;

    if (from > w->first[d]) return PETSC_FALSE; /* there was one */
    MPMRegionBounds(&b->region, w->dim, lower, upper);
    middle = (PetscInt64)PetscFloorReal((0.5 * (lower[d] + upper[d]) - b->offset[d]) / b->b[d] - 0.5);
    middle = PetscMin(PetscMax(middle, from), last);
    if (!Inside(w, middle) && (middle == last || !Inside(w, ++middle))) return PETSC_FALSE;
    from = LastInside(w, middle, from - 1);
    to   = LastInside(w, middle, last + 1) + 1;
  } else {
    while (from <= last && !Inside(w, from)) from++;
    for (to = from; to <= last && Inside(w, to);) to++;
  }
  w->ijk[d] = from;
  w->n      = to - from;
  return w->n > 0 ? PETSC_TRUE : PETSC_FALSE;
}

/* Goes to the next run. False when there are no more; id is then the number after the last particle's. */
PetscBool MPMLatticeNext(MPMLattice *w)
{
  w->id += w->n;
  w->ijk[w->dim - 1] += w->n;
  for (w->n = 0; w->row < w->end; GoToRow(w, w->row + 1))
    if (FindRun(w)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Takes a walk on to rows from .. to-1, from the last row before them where a share, whose first number is known,
   begins. */
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
