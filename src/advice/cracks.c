/* cracks.c - which of the distances that parting.c finds belong to a crack of a body, and how one is told. Single
   particles are left behind at corners, where the stress has no bound, and do not count. */
#include <stdlib.h>
#include "advice/watch.h"

#define MOST_LINKS 100000 /* of a process, that are looked at */

static int CompareLinks(const void *a, const void *b)
{
  const MPMFound *p = (const MPMFound *)a, *q = (const MPMFound *)b;

  return p->key < q->key ? -1 : p->key > q->key;
}

/* Returns whether a link of n sorted ones belongs to a crack: along each axis beside its own, more neighbours than a
   cell has have parted in the same way, or all from one surface of the body to the other. Of particles of a table,
   whose neighbours are not known, more than those of a side of a cell have to. */
static PetscBool IsCrack(PetscInt dim, const MPMScene *scene, const MPMNeighbours neighbours[], PetscInt n,
                         const MPMFound link[], const MPMFound *of)
{
  const PetscInt       body = MPMBodyOf(scene, of->key / 16, 0), code = (PetscInt)(of->key % 16);
  const MPMNeighbours *nb = &neighbours[body];
  PetscInt64           ijk[3];

  if (!nb->body) return n > 1 << (dim - 1);
  MPMNeighboursPlace(nb, of->key / 16, ijk);
  for (PetscInt c = 0; c < dim; c++) {
    PetscInt run = 1, ends = 0;

    for (PetscInt step = -1; step <= 1 && c != (code < 3 ? code : (code - 3) / 2); step += 2) {
      PetscInt64 next[3] = {ijk[0], ijk[1], ijk[2]};

      for (PetscInt k = 0; k <= nb->body->ppc[c]; k++) {
        MPMFound key = {0, 0, {0}, {0}};

        next[c] += step;
        key.key = 16 * MPMNeighboursId(nb, next) + code;
        ends += key.key < 0;
        if (key.key < 0 || !bsearch(&key, link, (size_t)n, sizeof *link, CompareLinks)) break;
        run++;
      }
    }
    if (c != (code < 3 ? code : (code - 3) / 2) && run <= nb->body->ppc[c] && ends < 2) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Described in watch.h: gathers the links of all processes, which are few while a body begins to part. */
PetscErrorCode MPMPartingCrack(const MPMCore *core, const MPMScene *scene, const MPMNeighbours neighbours[],
                               PetscInt nlinks, const MPMFound link[], MPMFound *parted)
{
  const MPI_Comm    comm = core->exchange.data;
  const PetscMPIInt each = sizeof *link;
  PetscMPIInt       size, mine = (PetscMPIInt)PetscMin(nlinks, MOST_LINKS) * each, *count, *start;
  MPMFound         *all;
  PetscInt          n;

  PetscFunctionBeginUser;
  *parted = (MPMFound){-1, -1, {0}, {0}};
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMalloc2(size, &count, size + 1, &start));
  PetscCallMPI(MPI_Allgather(&mine, 1, MPI_INT, count, 1, MPI_INT, comm));
  start[0] = 0;
  for (PetscMPIInt k = 0; k < size; k++) start[k + 1] = start[k] + count[k];
  n = start[size] / each;
  PetscCall(PetscMalloc1(PetscMax(1, n), &all));
  PetscCallMPI(MPI_Allgatherv(link, mine, MPI_BYTE, all, count, start, MPI_BYTE, comm));
  qsort(all, (size_t)n, sizeof *all, CompareLinks);
  for (PetscInt k = 0; k < n; k++)
    if (all[k].value > parted->value && IsCrack(core->grid.dim, scene, neighbours, n, all, &all[k])) *parted = all[k];
  PetscCall(PetscFree(all));
  PetscCall(PetscFree2(count, start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Words -------------------------------------------------------------------------------------------------------- */

void MPMPartingTell(const MPMWatch *w, const MPMCore *core, const MPMScene *scene, const MPMFound *f, PetscBool parted,
                    char text[MPM_TEXT_LEN])
{
  const PetscInt body = MPMBodyOf(scene, f->key / 16, 0), code = (PetscInt)(f->key % 16), face = code - 3;
  const PetscInt dim = core->grid.dim;
  char           place[MPM_NAME_LEN], where[3 * MPM_NAME_LEN] = "", since[MPM_NAME_LEN] = "";

  MPMPlaceWords(dim, f->x, place);
  if (code >= 3)
    (void)snprintf(where, sizeof where, "off its wall %s (%s)", MPMFaceNames[face],
                   MPMWallNames[scene->walls.given[face / 2][face % 2].type]);
  else
    (void)snprintf(where, sizeof where, "apart");
  if (w->torn_at >= 0 && w->torn_at < core->t)
    (void)snprintf(since, sizeof since, ", above %g since t=%g s", MPM_BOUND_gap_left, (double)w->torn_at);
  (void)snprintf(text, MPM_TEXT_LEN,
                 "%s %s %s, near %s: %s %.3g cells, which was %.3g at the start%s; the deformation explains %.3g",
                 scene->bodies[body].name, parted ? "has come" : "is coming", where, place,
                 code >= 3 ? "twice the distance from the wall is" : "the distance of neighbouring particles is",
                 (double)f->of[0], (double)f->of[1], since, (double)f->of[2]);
}

void MPMPartingCure(const MPMScene *scene, PetscInt dim, const MPMFound *f, char text[MPM_TEXT_LEN])
{
  const MPMBody *b     = &scene->bodies[MPMBodyOf(scene, f->key / 16, 0)];
  const PetscInt face  = (PetscInt)(f->key % 16) - 3; /* of its wall; below 0: none */
  const PetscInt times = face < 0 ? 2 : 3;            /* at the edge of a clamp the strain has no bound */

  (void)snprintf(text, MPM_TEXT_LEN, "more particles per cell (-body_%s_ppc %" PetscInt_FMT, b->name,
                 times * b->ppc[0]);
  for (PetscInt d = 1; d < dim; d++) {
    MPMAppend(text, MPM_TEXT_LEN, ",%" PetscInt_FMT, times * b->ppc[d]);
  }
  if (face >= 0 && scene->walls.given[face / 2][face % 2].type != MPM_WALL_piston)
    MPMAppend(text, MPM_TEXT_LEN, "), or, where it may leave its wall, -bc_%s_type separate", MPMFaceNames[face]);
  else
    MPMAppend(text, MPM_TEXT_LEN, ")");
}
