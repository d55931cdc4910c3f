/* static_ghosts.c - the stabilisation of nodes with little matter in static steps: springs along the lines of the grid, which
   vanish where displacements are polynomials of the order of the basis. docs/method.md has the equations (Statics). */
#include "step/static.h"

#define NEARLY  1e-6    /* of a share: a node at a flat surface has half of its matter, whatever rounding says */
#define GRAIN   0x1p-40 /* of the volume of a cell: volumes of nodes are multiples of it, and their sums exact */
#define SAMPLES 8       /* of a basis function in each cell, for how much of it lies in the grid */

/* Sets inside [nodes of axis d] to the integral over the grid, in cells, of the basis functions along axis d. */
static PetscErrorCode Inside(const MPMCore *core, PetscInt d, PetscReal **inside)
{
  const MPMGrid  *grid  = &core->grid;
  const PetscReal l     = 0.25; /* of gimp, about */
  const PetscInt  nodes = grid->cells[d] + 2 * grid->layers[d] + 1;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(nodes, inside));
  for (PetscInt k = 0; k < grid->cells[d] * SAMPLES; k++) {
    PetscReal xi = ((PetscReal)k + 0.5) / SAMPLES, w[MPM_MAX_STENCIL], g[MPM_MAX_STENCIL];
    PetscInt  base;

    base = MPMBasisBase(core->basis, &xi, l, grid->cells[d], grid->periodic[d], grid->wall_basis[d]);
    MPMBasisWeights(core->basis, xi, l, base, grid->cells[d], grid->wall_basis[d], w, g);
    for (PetscInt i = 0; i < MPMBasisNodes(core->basis); i++) {
      const PetscInt node = base + i + grid->layers[d], n = grid->cells[d];

      (*inside)[grid->periodic[d] ? (node % n + n) % n : node] += w[i] / SAMPLES;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets weak[...], as long as `at`, to 1 where a node has less matter than the share `fill` of what it has room for. */
static PetscErrorCode FindWeak(struct MPMStatic *s, PetscReal weak[])
{
  MPMCore       *core   = s->core;
  const MPMGrid *grid   = &core->grid;
  const PetscInt dim    = grid->dim,
                 fields = MPM_BIT(X) | MPM_BIT(x) | MPM_BIT(F) | MPM_BIT(F33) | MPM_BIT(kind) | MPM_BIT(l);
  PetscReal     *own, *inside[3], h = 1;
  Vec            volume;
  PetscScalar   *v;
  MPMView        view;
  MPMStaticNodes t;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim; d++) h *= grid->h[d];
  PetscCall(VecDuplicate(s->u, &volume));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const PetscReal J = grid->total ? 1 : MPMDet((int)dim, view.F + p * dim * dim) * (grid->round ? view.F33[p] : 1);

    MPMStaticStencil(s, &view, p, &t);
    for (PetscInt i = 0; i < t.n; i++) {
      const PetscScalar part = MPMStaticGrain(
          t.w[i] * J * MPMKindOf(core->params.kinds, &view, p)->V0 / (grid->round ? 2 * PETSC_PI * t.r : 1) / h, GRAIN);

      if (t.number[i] >= 0) PetscCall(VecSetValue(volume, t.number[i] * dim, part, ADD_VALUES));
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(VecAssemblyBegin(volume));
  PetscCall(VecAssemblyEnd(volume));
  for (PetscInt d = 0; d < dim; d++) PetscCall(Inside(core, d, &inside[d]));
  PetscCall(PetscMalloc1(PetscMax(1, s->n), &own));
  PetscCall(VecGetArray(volume, &v));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt  ijk[3];
    PetscReal room = 1;

    MPMStaticWhere(s, q, ijk);
    for (PetscInt d = 0; d < dim; d++) room *= inside[d][ijk[d] + (grid->periodic[d] ? 0 : grid->layers[d])];
    own[q] = v[q * dim] < s->fill * room * (1 - NEARLY) ? 1 : 0;
  }
  PetscCall(VecRestoreArray(volume, &v));
  PetscCall(MPMStaticSpread(s, own, 0, weak));
  PetscCall(PetscFree(own));
  for (PetscInt d = 0; d < dim; d++) PetscCall(PetscFree(inside[d]));
  PetscCall(VecDestroy(&volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the length around the axis of a run of nodes from ijk [3] on along axis d, at its middle, m; 1 in planes and 3-D. */
static PetscReal Around(const struct MPMStatic *s, const PetscInt ijk[], PetscInt d)
{
  const MPMGrid *grid = &s->core->grid;
  PetscReal      at[3];

  MPMGridNodeAt(grid, ijk, at);
  if (d == 0) at[0] += 0.5 * (PetscReal)MPMStaticOrder(s) * grid->h[0];
  return grid->round ? 2 * PETSC_PI * PetscMax(at[0], 0.5 * grid->h[0]) : 1;
}

/* Sets modulus[...], as long as `at`, to the least Young's modulus of the matter that reaches a node, Pa: a stiff body must not
   make the weak nodes of a soft one stiff. Counts of particles are exact in any sequence. */
static PetscErrorCode FindModulus(struct MPMStatic *s, PetscReal modulus[])
{
  MPMCore       *core = s->core;
  const PetscInt dim = core->grid.dim, fields = MPM_BIT(X) | MPM_BIT(x) | MPM_BIT(kind) | MPM_BIT(l);
  PetscReal     *own;
  Vec            count;
  PetscScalar   *v;
  MPMView        view;
  MPMStaticNodes t;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(s->u, &count));
  PetscCall(PetscMalloc1(PetscMax(1, s->n), &own));
  for (PetscInt q = 0; q < s->n; q++) own[q] = PETSC_MAX_REAL;
  for (PetscInt m = 0; m < core->params.nmaterials; m++) {
    PetscCall(VecSet(count, 0));
    PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
    for (PetscInt p = 0; p < view.n; p++) {
      if (MPMKindOf(core->params.kinds, &view, p)->material != m) continue;
      MPMStaticStencil(s, &view, p, &t);
      for (PetscInt i = 0; i < t.n; i++)
        if (t.number[i] >= 0) PetscCall(VecSetValue(count, t.number[i] * dim, 1, ADD_VALUES));
    }
    PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
    PetscCall(VecAssemblyBegin(count));
    PetscCall(VecAssemblyEnd(count));
    PetscCall(VecGetArray(count, &v));
    for (PetscInt q = 0; q < s->n; q++)
      if (v[q * dim] > 0) own[q] = PetscMin(own[q], core->params.materials[m].E);
    PetscCall(VecRestoreArray(count, &v));
  }
  PetscCall(MPMStaticSpread(s, own, PETSC_MAX_REAL, modulus));
  PetscCall(PetscFree(own));
  PetscCall(VecDestroy(&count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const PetscReal rows[5][5] = {{0}, {0}, {1, -2, 1}, {1, -3, 3, -1}, {1, -4, 6, -4, 1}};

/* Returns whether place ijk [3] is one of this process, and no image of one. */
static PetscBool IsOwn(const struct MPMStatic *s, const PetscInt ijk[])
{
  const MPMPatch *patch = &s->core->exchange.patch;

  for (PetscInt d = 0; d < s->core->grid.dim; d++)
    if (ijk[d] < patch->own_lo[d] || ijk[d] >= patch->own_lo[d] + patch->own_n[d]) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Looks at the run of nodes from ijk [3] on along axis d, and sets *run and number [5], those of its unknowns. Returns whether
   it has springs here: all nodes have unknowns, one is weak and one is own. */
static PetscBool FindRun(const struct MPMStatic *s, const PetscInt ijk[], PetscInt d, const PetscReal weak[],
                         const PetscReal modulus[], PetscInt number[], MPMStaticRun *run)
{
  const MPMGrid *grid  = &s->core->grid;
  const PetscInt order = MPMStaticOrder(s);
  PetscInt       at[3] = {ijk[0], ijk[1], ijk[2]};
  PetscReal      E = PETSC_MAX_REAL, h = 1;
  PetscBool      any = PETSC_FALSE;

  *run = (MPMStaticRun){.first = MPMStaticPlace(s, ijk)};
  for (PetscInt k = 0; k <= order; k++) {
    PetscInt place;

    at[d] = ijk[d] + k;
    if (at[d] >= s->lo[d] + s->wide[d]) return PETSC_FALSE;
    place     = MPMStaticPlace(s, at);
    number[k] = s->at[place];
    if (number[k] < 0) return PETSC_FALSE;
    if (k == 1) run->next = place - run->first;
    if (weak[place] > 0) any = PETSC_TRUE;
    if (IsOwn(s, at)) run->own |= (PetscInt)1 << k;
    E = PetscMin(E, modulus[place]);
  }
  for (PetscInt e = 0; e < grid->dim; e++) h *= grid->h[e];
  run->stiffness = s->ghost * E * h / PetscSqr(grid->h[d]) * Around(s, ijk, d);
  return any && run->own;
}

/* Adds a run to the matrix of the springs. */
static PetscErrorCode AddRun(struct MPMStatic *s, const MPMStaticRun *run, const PetscInt number[])
{
  const PetscInt order = MPMStaticOrder(s), dim = s->core->grid.dim;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i <= order; i++)
    for (PetscInt j = 0; j <= order; j++)
      for (PetscInt c = 0; c < dim; c++)
        PetscCall(MatSetValue(s->ghosts, number[i] * dim + c, number[j] * dim + c,
                              MPMStaticGrain(run->stiffness * rows[order][i] * rows[order][j], s->grain), ADD_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticStabilise(struct MPMStatic *s)
{
  const PetscInt dim = s->core->grid.dim, size = s->wide[0] * s->wide[1] * s->wide[2];
  PetscInt       room = 0, any;
  PetscReal     *weak, *modulus;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(size, &weak, size, &modulus));
  PetscCall(FindWeak(s, weak));
  PetscCall(FindModulus(s, modulus));
  PetscCall(MPMStaticCreateMatrix(s, 0, &s->ghosts));
  s->nruns = 0;
  for (PetscInt d = 0; d < dim; d++)
    for (PetscInt k = 0; k < size; k++) {
      const PetscInt ijk[3] = {s->lo[0] + k % s->wide[0], s->lo[1] + k / s->wide[0] % s->wide[1],
                               s->lo[2] + k / s->wide[0] / s->wide[1]};
      PetscInt       number[5];
      MPMStaticRun   run;

      if (s->at[k] < 0 || !FindRun(s, ijk, d, weak, modulus, number, &run)) continue;
      if (run.own & 1) PetscCall(AddRun(s, &run, number));
      if (s->nruns == room) PetscCall(PetscRealloc((size_t)(room = 2 * room + 64) * sizeof *s->run, &s->run));
      s->run[s->nruns++] = run;
    }
  PetscCall(PetscFree2(weak, modulus));
  PetscCall(MatAssemblyBegin(s->ghosts, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->ghosts, MAT_FINAL_ASSEMBLY));
  any = s->nruns;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPIU_INT, MPI_MAX, s->core->exchange.data));
  if (!any) PetscCall(MatDestroy(&s->ghosts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticSprings(struct MPMStatic *s, Vec u, Vec r)
{
  const PetscInt     order = MPMStaticOrder(s), dim = s->core->grid.dim, size = s->wide[0] * s->wide[1] * s->wide[2];
  const PetscScalar *step;
  PetscScalar       *force;
  PetscReal         *own, *moved;
  PetscInt           begin;

  PetscFunctionBeginUser;
  PetscCall(VecSet(r, 0));
  PetscCall(VecWAXPY(s->work, -1, s->was, u));
  PetscCall(VecGetOwnershipRange(u, &begin, NULL));
  PetscCall(PetscMalloc2(PetscMax(1, s->n), &own, size, &moved));
  for (PetscInt c = 0; c < dim; c++) {
    PetscCall(VecGetArrayRead(s->work, &step));
    for (PetscInt q = 0; q < s->n; q++) own[q] = step[q * dim + c];
    PetscCall(VecRestoreArrayRead(s->work, &step));
    PetscCall(MPMStaticSpread(s, own, 0, moved));
    PetscCall(VecGetArray(r, &force));
    for (PetscInt i = 0; i < s->nruns; i++) {
      const MPMStaticRun *run  = s->run + i;
      PetscReal           bent = 0;

      for (PetscInt k = 0; k <= order; k++) bent += rows[order][k] * moved[run->first + k * run->next];
      for (PetscInt k = 0; k <= order; k++)
        if (run->own >> k & 1)
          force[s->at[run->first + k * run->next] * dim + c - begin] += run->stiffness * rows[order][k] * bent;
    }
    PetscCall(VecRestoreArray(r, &force));
  }
  PetscCall(PetscFree2(own, moved));
  PetscFunctionReturn(PETSC_SUCCESS);
}
