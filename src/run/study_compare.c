/* study_compare.c - the particles of a finished run beside those of a finer one, which may have another number of
   particles a cell. Both started on lattices, so the displacement of the finer one where a coarse particle started
   follows by interpolation. */
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

/* Sets *e to the mean of u_fine - u over the fine particles around a coarse one, with the weights of the polynomial
   through `points` (2, 4) of them on each axis; at a point of the fine lattice that is its particle. Returns the sum of
   the weights of those that are there: 1 if all are. */
static PetscReal Interpolate(const MPMGrid *grid, const MPMSample *c, const PetscReal b[3], const MPMSamples *fine,
                             PetscInt points, PetscReal e[3])
{
  PetscInt64 first[3] = {0};
  PetscInt   n[3]     = {1, 1, 1};
  PetscReal  w[3][4] = {{1}, {1}, {1}}, sum = 0;
  MPMSample  at = {.body = c->body};

  for (PetscInt d = 0; d < grid->dim; d++) {
    /* the place of the coarse particle on the fine lattice, whose particles are at whole numbers */
    const PetscReal s    = ((PetscReal)c->key[d] + 0.5) * b[d] / fine->b[c->body][d] - 0.5;
    const PetscReal left = PetscFloorReal(s + 1e-6), t = PetscMax(0, s - left);

    e[d]     = 0;
    n[d]     = t < 1e-6 ? 1 : points;
    first[d] = (PetscInt64)left - (n[d] == 4 ? 1 : 0);
    for (PetscInt i = 0; i < n[d]; i++) { /* Lagrange's */
      const PetscReal x = t + (n[d] == 4 ? 1 : 0);

      w[d][i] = 1;
      for (PetscInt j = 0; j < n[d]; j++)
        if (j != i) w[d][i] *= (x - (PetscReal)j) / (PetscReal)(i - j);
    }
  }
  for (PetscInt k = 0; k < n[2]; k++)
    for (PetscInt j = 0; j < n[1]; j++)
      for (PetscInt i = 0; i < n[0]; i++) {
        const PetscReal weight = w[0][i] * w[1][j] * w[2][k];
        PetscInt        q;

        at.key[0] = first[0] + i;
        at.key[1] = first[1] + j;
        at.key[2] = first[2] + k;
        q         = Find(fine, &at);
        if (q < 0) continue;
        sum += weight;
        for (PetscInt d = 0; d < grid->dim; d++) { /* across a periodic face if that is shorter */
          const PetscReal length = grid->upper[d] - grid->lower[d], step = fine->at[q].u[d] - c->u[d];

          e[d] += weight * (grid->periodic[d] ? step - length * PetscFloorReal(step / length + 0.5) : step);
        }
      }
  return sum;
}

PetscErrorCode MPMSamplesCompare(const MPMGrid *grid, MPMSamples *coarse, MPMSamples *fine, PetscReal *difference,
                                 PetscReal *size)
{
  PetscReal d2 = 0, u2 = 0, mass = 0;

  PetscFunctionBeginUser;
  /* sorted, so that the sums do not depend on the number of processes */
  PetscCall(PetscTimSort(coarse->n, coarse->at, sizeof *coarse->at, ByPlace, NULL));
  PetscCall(PetscTimSort(fine->n, fine->at, sizeof *fine->at, ByPlace, NULL));
  for (PetscInt p = 0; p < coarse->n; p++) {
    const MPMSample *c = &coarse->at[p];
    PetscReal        e[3], sum = Interpolate(grid, c, coarse->b[c->body], fine, 4, e);

    if (PetscAbsReal(sum - 1) > 1e-9) sum = Interpolate(grid, c, coarse->b[c->body], fine, 2, e); /* at an edge */
    if (sum < 1e-9) continue; /* at a curved edge the finer lattice may have no particle here */
    for (PetscInt d = 0; d < grid->dim; d++) {
      d2 += c->m * PetscSqr(e[d] / sum);
      u2 += c->m * PetscSqr(c->u[d] + e[d] / sum);
    }
    mass += c->m;
  }
  *difference = PetscSqrtReal(d2 / mass);
  *size       = PetscSqrtReal(u2 / mass);
  PetscFunctionReturn(PETSC_SUCCESS);
}
