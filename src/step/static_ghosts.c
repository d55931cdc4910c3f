/* static_ghosts.c - the stabilisation of nodes with little matter in static steps: springs along the lines of the grid, which
   vanish where displacements are polynomials of the order of the basis. docs/method.md has the equations (Statics). */
#include "parallel/exchange.h"
#include "step/static.h"

#define NEARLY  1e-6 /* of a share: a node at a flat surface has half of its matter, whatever rounding says */
#define SAMPLES 8 /* of a basis function in each cell, for how much of it lies in the grid */

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
  const PetscInt dim    = grid->dim, fields = MPM_BIT(X) | MPM_BIT(x) | MPM_BIT(F) | MPM_BIT(F33) | MPM_BIT(kind) | MPM_BIT(l);
  PetscReal     *own, *inside[3], h = 1;
  Vec            volume;
  PetscScalar   *v;
  MPMView        view;
  MPMStaticNodes        t;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(s->u, &volume));
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    const PetscReal J = grid->total ? 1 : MPMDet((int)dim, view.F + p * dim * dim) * (grid->round ? view.F33[p] : 1);

    MPMStaticStencil(s, &view, p, &t);
    for (PetscInt i = 0; i < t.n; i++) {
      const PetscScalar part = t.w[i] * J * MPMKindOf(core->params.kinds, &view, p)->V0 / (grid->round ? 2 * PETSC_PI * t.r : 1);

      if (t.number[i] >= 0) PetscCall(VecSetValue(volume, t.number[i] * dim, part, ADD_VALUES));
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCall(VecAssemblyBegin(volume));
  PetscCall(VecAssemblyEnd(volume));
  for (PetscInt d = 0; d < dim; d++) {
    PetscCall(Inside(core, d, &inside[d]));
    h *= grid->h[d];
  }
  PetscCall(PetscMalloc1(PetscMax(1, s->n), &own));
  PetscCall(VecGetArray(volume, &v));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt  ijk[3];
    PetscReal room = h;

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

/* Adds the stabilisation of the run of nodes from ijk [3] on along axis d, if all have mass and one is weak; h: volume of a
   cell, m^3. */
static PetscErrorCode AddRun(struct MPMStatic *s, const PetscInt ijk[], PetscInt d, PetscReal h, const PetscReal weak[],
                             const PetscReal modulus[])
{
  static const PetscReal rows[5][5] = {{0}, {0}, {1, -2, 1}, {1, -3, 3, -1}, {1, -4, 6, -4, 1}};
  const PetscInt         order = MPMStaticOrder(s), dim = s->core->grid.dim;
  PetscInt               number[5], at[3] = {ijk[0], ijk[1], ijk[2]};
  PetscReal              E = PETSC_MAX_REAL, stiffness;
  PetscBool              any = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k <= order; k++) {
    at[d] = ijk[d] + k;
    if (at[d] >= s->lo[d] + s->wide[d]) PetscFunctionReturn(PETSC_SUCCESS);
    number[k] = s->at[MPMStaticPlace(s, at)];
    if (number[k] < 0) PetscFunctionReturn(PETSC_SUCCESS);
    if (weak[MPMStaticPlace(s, at)] > 0) any = PETSC_TRUE;
    E = PetscMin(E, modulus[MPMStaticPlace(s, at)]);
  }
  stiffness = s->ghost * E * h / PetscSqr(s->core->grid.h[d]) * Around(s, ijk, d);
  for (PetscInt i = 0; i <= order && any; i++)
    for (PetscInt j = 0; j <= order; j++)
      for (PetscInt c = 0; c < dim; c++)
        PetscCall(MatSetValue(s->ghosts, number[i] * dim + c, number[j] * dim + c,
                              stiffness * rows[order][i] * rows[order][j], ADD_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMStaticStabilise(struct MPMStatic *s)
{
  const MPMCore *core = s->core;
  const MPMGrid *grid = &core->grid;
  PetscReal     *weak, *modulus, h = 1;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < grid->dim; d++) h *= grid->h[d];
  PetscCall(PetscMalloc2(s->wide[0] * s->wide[1] * s->wide[2], &weak, s->wide[0] * s->wide[1] * s->wide[2], &modulus));
  PetscCall(FindWeak(s, weak));
  PetscCall(FindModulus(s, modulus));
  PetscCall(MPMStaticCreateMatrix(s, 0, &s->ghosts));
  for (PetscInt q = 0; q < s->n; q++) {
    PetscInt ijk[3];

    MPMStaticWhere(s, q, ijk);
    for (PetscInt d = 0; d < grid->dim; d++)
      PetscCall(AddRun(s, ijk, d, h, weak, modulus));
  }
  PetscCall(PetscFree2(weak, modulus));
  PetscCall(MatAssemblyBegin(s->ghosts, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(s->ghosts, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}
