/* study_compare.c - the particles of a finished run beside those of a finer one, which may have another number of
   particles a cell. The cells of the lattice of a body are boxes in its state at rest; a coarse particle is compared
   with the mean over its box. */
#include "base/message.h"
#include "run/study.h"

static int ByPlace(const void *a, const void *b, void *ctx)
{
  const MPMSample *p = (const MPMSample *)a, *q = (const MPMSample *)b;

  (void)ctx;
  if (p->body != q->body) return p->body < q->body ? -1 : 1;
  for (int d = 0; d < 3; d++)
    if (p->key[d] != q->key[d]) return p->key[d] < q->key[d] ? -1 : 1;
  return 0;
}

PetscErrorCode MPMSamplesDestroy(MPMSamples *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(s->at));
  PetscCall(PetscFree(s->b));
  s->n = s->nbodies = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills samples, which are empty, with all particles of a run, on every process of exchange.data. */
PetscErrorCode MPMSamplesGather(MPM mpm, MPMSamples *samples)
{
  const PetscInt dim = mpm->core.grid.dim, fields = MPM_BIT(id) | MPM_BIT(x) | MPM_BIT(X);
  MPMSample     *mine;
  MPMView        view;
  PetscMPIInt    size, bytes, *counts, *starts;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(mpm->core.exchange.data, &size));
  PetscCall(PetscMalloc1(mpm->core.particles.n, &mine));
  PetscCall(PetscMalloc2(size, &counts, size, &starts));
  PetscCall(MPMParticlesGetView(&mpm->core.particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const MPMBody *body = mpm->scene.bodies;
    MPMSample     *s    = &mine[p];

    while (view.id[p] >= body->first + body->n) body++;
    PetscCall(PetscMemzero(s, sizeof *s));
    s->body = (PetscInt)(body - mpm->scene.bodies);
    s->m    = mpm->scene.kinds[body->kind].m;
    for (PetscInt d = 0; d < dim; d++) {
      /* X is in the middle of its cell of the lattice, so rounding does not matter */
      s->key[d] = (PetscInt64)PetscFloorReal((view.X[p * dim + d] - body->offset[d]) / body->b[d]);
      s->u[d]   = view.x[p * dim + d] - view.X[p * dim + d];
    }
  }
  PetscCall(MPMParticlesRestoreView(&mpm->core.particles, fields, &view));
  PetscCall(MPMMessageLength((size_t)mpm->core.particles.n * sizeof(MPMSample), &bytes));
  PetscCallMPI(MPI_Allgather(&bytes, 1, MPI_INT, counts, 1, MPI_INT, mpm->core.exchange.data));
  starts[0] = 0;
  for (PetscMPIInt r = 1; r < size; r++) starts[r] = starts[r - 1] + counts[r - 1];
  samples->n       = (PetscInt)mpm->core.particles.total;
  samples->nbodies = mpm->scene.nbodies;
  PetscCall(PetscMalloc1(samples->n, &samples->at));
  PetscCall(PetscMalloc1(samples->nbodies, &samples->b));
  for (PetscInt k = 0; k < samples->nbodies; k++)
    for (PetscInt d = 0; d < 3; d++) samples->b[k][d] = d < dim ? mpm->scene.bodies[k].b[d] : 1;
  PetscCallMPI(MPI_Allgatherv(mine, bytes, MPI_BYTE, samples->at, counts, starts, MPI_BYTE, mpm->core.exchange.data));
  PetscCall(PetscFree2(counts, starts));
  PetscCall(PetscFree(mine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number of the sample of this body and place among those sorted, or -1. */
static PetscInt Find(const MPMSamples *s, const MPMSample *wanted)
{
  PetscInt from = 0, to = s->n;

  while (from < to) {
    const PetscInt middle = from + (to - from) / 2;
    const int      order  = ByPlace(&s->at[middle], wanted, NULL);

    if (!order) return middle;
    if (order < 0)
      from = middle + 1;
    else
      to = middle;
  }
  return -1;
}

/* The mean over the box of a coarse particle is taken of u_fine - u. */
typedef struct {
  PetscReal m, mu[3]; /* sums of the mass of fine particles in the box, and of mass times difference */
} Mean;

/* Adds a fine particle to the means of the coarse ones whose boxes its own box overlaps, each with its part. */
static void AddFine(const MPMGrid *grid, const MPMSamples *coarse, const MPMSample *fine, const PetscReal b[3],
                    Mean mean[])
{
  PetscInt64 first[3] = {0}, last[3] = {0};
  PetscReal  low[3] = {0}, high[3] = {1, 1, 1};
  MPMSample  at;

  for (PetscInt d = 0; d < grid->dim; d++) { /* in boxes of the coarse lattice, less rounding */
    low[d]   = (PetscReal)fine->key[d] * b[d] / coarse->b[fine->body][d];
    high[d]  = (PetscReal)(fine->key[d] + 1) * b[d] / coarse->b[fine->body][d];
    first[d] = (PetscInt64)PetscFloorReal(low[d] + 1e-6);
    last[d]  = (PetscInt64)PetscCeilReal(high[d] - 1e-6) - 1;
  }
  at.body = fine->body;
  for (at.key[2] = first[2]; at.key[2] <= last[2]; at.key[2]++)
    for (at.key[1] = first[1]; at.key[1] <= last[1]; at.key[1]++)
      for (at.key[0] = first[0]; at.key[0] <= last[0]; at.key[0]++) {
        const PetscInt p    = Find(coarse, &at);
        PetscReal      part = fine->m;

        if (p < 0) continue; /* at a curved edge the coarse lattice may have no particle here */
        for (PetscInt d = 0; d < grid->dim; d++)
          if (first[d] < last[d])
            part *= (PetscMin(high[d], (PetscReal)(at.key[d] + 1)) - PetscMax(low[d], (PetscReal)at.key[d])) /
                    (high[d] - low[d]);
        mean[p].m += part;
        for (PetscInt d = 0; d < grid->dim; d++) { /* across a periodic face if that is shorter */
          const PetscReal length = grid->upper[d] - grid->lower[d], e = fine->u[d] - coarse->at[p].u[d];

          mean[p].mu[d] += part * (grid->periodic[d] ? e - length * PetscFloorReal(e / length + 0.5) : e);
        }
      }
}

PetscErrorCode MPMSamplesCompare(const MPMGrid *grid, MPMSamples *coarse, MPMSamples *fine, PetscReal *difference,
                                 PetscReal *size)
{
  PetscReal d2 = 0, u2 = 0, mass = 0;
  Mean     *mean;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(coarse->n, &mean));
  /* sorted, so that the sums do not depend on the number of processes */
  PetscCall(PetscTimSort(coarse->n, coarse->at, sizeof *coarse->at, ByPlace, NULL));
  PetscCall(PetscTimSort(fine->n, fine->at, sizeof *fine->at, ByPlace, NULL));
  for (PetscInt q = 0; q < fine->n; q++) AddFine(grid, coarse, &fine->at[q], fine->b[fine->at[q].body], mean);
  for (PetscInt p = 0; p < coarse->n; p++) {
    const MPMSample *c = &coarse->at[p];

    if (mean[p].m == 0) continue; /* at a curved edge the finer lattice may leave the box empty */
    for (PetscInt d = 0; d < grid->dim; d++) {
      const PetscReal e = mean[p].mu[d] / mean[p].m;

      d2 += c->m * e * e;
      u2 += c->m * PetscSqr(c->u[d] + e);
    }
    mass += c->m;
  }
  PetscCall(PetscFree(mean));
  *difference = PetscSqrtReal(d2 / mass);
  *size       = PetscSqrtReal(u2 / mass);
  PetscFunctionReturn(PETSC_SUCCESS);
}
