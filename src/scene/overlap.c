/* overlap.c - refuses bodies of shape `file` in contact with each other whose particles overlap at the start. (fill.c
   looks at those that overlap bodies with a shape.) */
#include <stdlib.h>
#include "scene/points.h"

#define INSIDE (1 - 1e-6) /* of half a domain: particles whose domains touch do not overlap */

/* A particle: its place and half of its domain, m, and which of two bodies it is of. */
typedef struct {
  PetscReal x[3], half[3];
  PetscInt  body;
} Place;

static int ComparePlaces(const void *a, const void *b)
{
  const PetscReal *x = ((const Place *)a)->x, *y = ((const Place *)b)->x;

  for (int d = 0; d < 3; d++)
    if (x[d] != y[d]) return x[d] < y[d] ? -1 : 1;
  return 0;
}

/* Returns the largest half of a domain of a body's particles along an axis, m. */
static PetscReal MostHalf(const MPMScene *scene, const MPMCore *core, const MPMBody *b, PetscInt d)
{
  PetscReal most = 0;

  for (PetscInt k = 0; k < b->points->nkinds; k++)
    most = PetscMax(most, scene->kinds[b->points->kind[k]].l[d] * core->grid.h[d]);
  return most;
}

/* Lists the particles of body b here that may overlap those of `other`, from place[*n] on. Collective on core->comm. */
static PetscErrorCode List(const MPMScene *scene, const MPMCore *core, const MPMBody *b, const MPMBody *other,
                           Place **place, PetscInt *n)
{
  const PetscInt dim = core->grid.dim;
  MPMPointRows   rows;

  PetscFunctionBeginUser;
  PetscCall(MPMPointsRead(scene, b, core->comm, NULL, &rows));
  PetscCall(PetscRealloc((size_t)(*n + rows.n + 1) * sizeof **place, place));
  for (PetscInt k = 0; k < rows.n; k++) {
    const PetscReal *x    = rows.number + k * rows.stride;
    const MPMKind   *kind = &scene->kinds[MPMPointsKind(b->points, &rows, k)];
    PetscBool        near = PETSC_TRUE;
    Place            to   = {.body = b > other};

    for (PetscInt d = 0; d < dim; d++) {
      to.x[d]    = x[d];
      to.half[d] = kind->l[d] * core->grid.h[d];
      if (x[d] < other->region.lower[d] - to.half[d] - MostHalf(scene, core, other, d) ||
          x[d] > other->region.upper[d] + to.half[d] + MostHalf(scene, core, other, d))
        near = PETSC_FALSE;
    }
    if (near) (*place)[(*n)++] = to;
  }
  PetscCall(MPMPointsDestroyRows(&rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether the centre of a lies in the domain of b. */
static PetscBool LiesIn(PetscInt dim, const Place *a, const Place *b)
{
  for (PetscInt d = 0; d < dim; d++)
    if (!(PetscAbsReal(a->x[d] - b->x[d]) < INSIDE * b->half[d])) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Refuses bodies a and b if a particle of one lies in one of the other. Collective on core->comm. */
static PetscErrorCode Compare(const MPMScene *scene, MPMCore *core, MPMOptions o, const MPMBody *a, const MPMBody *b)
{
  const PetscInt  dim  = core->grid.dim;
  const PetscReal far  = 2 * PetscMax(MostHalf(scene, core, a, 0), MostHalf(scene, core, b, 0));
  Place          *mine = NULL, *all;
  PetscMPIInt     size, count, *counts, *from, total = 0;
  PetscInt        n = 0;

  PetscFunctionBeginUser;
  PetscCall(List(scene, core, a, b, &mine, &n));
  PetscCall(List(scene, core, b, a, &mine, &n));
  PetscCallMPI(MPI_Comm_size(core->comm, &size));
  PetscCall(PetscMPIIntCast(n * (PetscInt)sizeof *mine, &count));
  PetscCall(PetscMalloc2(size, &counts, size, &from));
  PetscCallMPI(MPI_Allgather(&count, 1, MPI_INT, counts, 1, MPI_INT, core->comm));
  for (PetscMPIInt k = 0; k < size; k++) {
    from[k] = total;
    total += counts[k];
  }
  PetscCall(PetscMalloc1(total / (PetscInt)sizeof *all + 1, &all));
  PetscCallMPI(MPI_Allgatherv(mine, count, MPI_BYTE, all, counts, from, MPI_BYTE, core->comm));
  n = total / (PetscInt)sizeof *all;
  qsort(all, (size_t)n, sizeof *all, ComparePlaces);
  for (PetscInt k = 0; k < n && !MPMOptionsError(o); k++)
    for (PetscInt q = k + 1; q < n && all[q].x[0] - all[k].x[0] < far && !MPMOptionsError(o); q++) {
      char at[MPM_NAME_LEN];

      if (all[k].body == all[q].body || !(LiesIn(dim, &all[k], &all[q]) || LiesIn(dim, &all[q], &all[k]))) continue;
      MPMPlaceWords(dim, all[k].x, at);
      MPMOptionsFail(o,
                     "-bodies: particles of %s and %s overlap at %s; bodies in contact must not overlap at the start: "
                     "move one",
                     a->name, b->name, at);
    }
  PetscCall(PetscFree(mine));
  PetscCall(PetscFree(all));
  PetscCall(PetscFree2(counts, from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPointsOverlap(const MPMScene *scene, MPMCore *core, MPMOptions o)
{
  PetscFunctionBeginUser;
  for (const MPMBody *a = scene->bodies + scene->nfilled; a < scene->bodies + scene->nbodies; a++)
    for (const MPMBody *b = a + 1; b < scene->bodies + scene->nbodies && !MPMOptionsError(o); b++)
      if (a->copy != b->copy) PetscCall(Compare(scene, core, o, a, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}
