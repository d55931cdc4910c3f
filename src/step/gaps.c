/* gaps.c - how far the matter is from the walls that only push, so that they act when it arrives and not before. As a
   step begins, each particle near such a wall tells the node of the face that it lies over where its matter ends: its
   centre less half of the extent of its deformed domain. The gap of a node is the least of these, over all processes,
   since a minimum has the same bits in every sequence. A node without a particle over it has the least gap of the nodes
   beside it from which it may have mass. docs/method.md has the condition that nodes get (Walls). */
#include "physics/wall.h"
#include "step/matter.h"
#include "step/step.h"

#define SPREAD 0.1  /* of what is beyond the nearest nodes */
#define SUNK   0.02 /* cells: what an end may have sunk into a wall before other nodes than the nearest are looked at */
#define TIE    1e-9 /* cells: a particle in the middle between two nodes lies over both */

PetscErrorCode MPMGapsCreate(MPMCore *core, MPMWalls *w)
{
  MPMGaps *g;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&g));
  for (PetscInt k = 0; k < 2 * core->grid.dim; k++) {
    g->first[k] = g->n;
    if (MPMWallWaits(w->given[k / 2][k % 2].type)) g->n += MPMFaceNodes(&core->grid, k / 2, PETSC_TRUE);
  }
  if (!g->n) {
    PetscCall(PetscFree(g));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc2(2 * g->n, &g->gap, 2 * g->n, &g->least));
  core->gaps = g;
  for (PetscInt k = 0; k < 2 * core->grid.dim; k++) {
    const PetscInt d = k / 2, s = k % 2;
    MPMFace *const faces[] = {&w->given[d][s], &w->before[d][s], &w->again[d][s], &w->gradient[d][s],
                              &w->residual[d][s]};

    if (!MPMWallWaits(w->given[d][s].type)) continue;
    g->faces |= (PetscInt)1 << k;
    for (size_t f = 0; f < sizeof faces / sizeof faces[0]; f++) faces[f]->least = g->least + g->first[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMGapsDestroy(MPMCore *core)
{
  PetscFunctionBeginUser;
  if (core->gaps) PetscCall(PetscFree2(core->gaps->gap, core->gaps->least));
  PetscCall(PetscFree(core->gaps));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const MPMMaterial *MaterialOf(const MPMCore *core, const MPMView *view, PetscInt p)
{
  return &core->params.materials[MPMKindOf(core->params.kinds, view, p)->material];
}

/* Returns how near, m, the end of particle p, at the distance `at`, m, from the wall of face k, is to that, or may come
   in this step. How far the matter of what is too far away to arrive reaches is not computed. */
static PetscReal End(const MPMCore *core, const MPMView *view, PetscInt p, PetscInt k, PetscReal at)
{
  static const PetscReal rest[3];
  const PetscInt         d = k / 2;
  const PetscReal        h = core->grid.h[d], most = 2 * MPMKindOf(core->params.kinds, view, p)->l[d] * h;
  PetscReal              n[3] = {0}, F[9], end;
  MPMMatterEnd           matter;

  n[d] = k % 2 ? -1 : 1;
  if (at > 2 * most)
    end = at - most;
  else {
    (void)MPMMatterDeformation(core, view, p, F);
    MPMMatterSetEnd(core, view, p, F, &matter);
    end = at - MPMMatterReaches(core->grid.dim, &matter, n, h);
  }
  if (core->params.walls->given[d][k % 2].type == MPM_WALL_piston) return end;
  return PetscMin(end, MPMMatterArrives(core, view, p, n, rest));
}

/* Lets particle p, at the distance `at`, m, from the wall of face k, tell the nodes that it lies over how far its end
   is, those nearest to it. To those of a piston a body that keeps its shape tells it once more, since it can be pulled.

   Other nodes in its reach move it too, and their matter may be further from the wall. Where a particle's end has sunk
   into it, the node that is so many cells beyond the nearest ones is stopped too, if the end has sunk by SPREAD times
   as many: so sharp ends are held, and curved ones hardly notice. */
static void Tell(const MPMCore *core, const MPMView *view, PetscInt p, PetscInt k, PetscReal at, PetscReal *gap,
                 PetscReal *rest)
{
  const MPMGrid  *grid   = &core->grid;
  const PetscInt  dim    = grid->dim;
  const PetscBool moves  = core->params.walls->given[k / 2][k % 2].type == MPM_WALL_piston;
  const PetscBool pulled = moves && MPMMaterialKeepsShape(MaterialOf(core, view, p));
  const PetscReal h = grid->h[k / 2], end = End(core, view, p, k, at);
  const PetscBool sinks = !moves && end < -SUNK * h;
  const PetscInt  place = grid->place[MPMKindOf(core->params.kinds, view, p)->copy];
  const PetscReal reach = sinks ? 0.5 * MPM_MAX_STENCIL : 0.5;
  PetscInt        lo[3] = {0}, hi[3] = {0}, ijk[3];
  PetscReal       xi[3] = {0};

  for (PetscInt d = 0; d < dim; d++) {
    if (d == k / 2) continue;
    xi[d] = (view->x[p * dim + d] - grid->lower[d]) / grid->h[d];
    lo[d] = (PetscInt)PetscCeilReal(xi[d] - reach - TIE);
    hi[d] = (PetscInt)PetscFloorReal(xi[d] + reach + TIE);
  }
  for (ijk[2] = lo[2]; ijk[2] <= hi[2]; ijk[2]++)
    for (ijk[1] = lo[1]; ijk[1] <= hi[1]; ijk[1]++)
      for (ijk[0] = lo[0]; ijk[0] <= hi[0]; ijk[0]++) {
        PetscInt  i;
        PetscReal most = 0; /* cells: the largest distance along an axis */

        for (PetscInt d = 0; d < dim; d++)
          most = PetscMax(most, d == k / 2 ? 0 : PetscAbsReal((PetscReal)ijk[d] - xi[d]));
        i = MPMFaceNodeOf(grid, k / 2, place, ijk);
        if (most < 0.5 + 2 * TIE) gap[i] = PetscMin(gap[i], end);
        if (most < 0.5 + 2 * TIE && pulled) rest[i] = PetscMin(rest[i], end);
        if (sinks) rest[i] = PetscMin(rest[i], end + SPREAD * (most - 0.5) * h);
      }
}

/* Returns the gap of node ijk [3] of a place on face k, or if no particle lies over it the least one of the nodes beside it
   from whose particles it may have mass. */
static PetscReal Nearby(const MPMCore *core, PetscInt k, PetscInt place, const PetscInt ijk[], const PetscReal gap[])
{
  const PetscInt reach = MPMBasisNodes(core->basis) / 2;
  PetscReal      own   = gap[MPMFaceNodeOf(&core->grid, k / 2, place, ijk)];
  PetscInt       by[3], at[3];

  if (own < PETSC_INFINITY) return own;
  for (PetscInt d = 0; d < 3; d++) by[d] = d < core->grid.dim && d != k / 2 ? reach : 0;
  for (at[2] = ijk[2] - by[2]; at[2] <= ijk[2] + by[2]; at[2]++)
    for (at[1] = ijk[1] - by[1]; at[1] <= ijk[1] + by[1]; at[1]++)
      for (at[0] = ijk[0] - by[0]; at[0] <= ijk[0] + by[0]; at[0]++)
        own = PetscMin(own, gap[MPMFaceNodeOf(&core->grid, k / 2, place, at)]);
  return own;
}

/* Sets the least velocities at the nodes of face k from the gaps, and of a piston how far what it can pull is. */
static void SetLeast(const MPMCore *core, PetscInt k)
{
  const MPMGrid  *grid  = &core->grid;
  const PetscBool moves = core->params.walls->given[k / 2][k % 2].type == MPM_WALL_piston;
  PetscReal      *gap = core->gaps->gap + core->gaps->first[k], *rest = gap + core->gaps->n;
  PetscReal      *least = core->gaps->least + core->gaps->first[k];
  const PetscReal dt    = core->params.dt;

  for (PetscInt i = 0; i < MPMFaceNodes(grid, k / 2, PETSC_FALSE); i++) {
    PetscInt  ijk[3] = {0}, rest_of = i;
    PetscReal own, room;

    for (PetscInt d = 0; d < grid->dim; d++) {
      const PetscInt n = d == k / 2 ? 1 : grid->cells[d] + !grid->periodic[d];

      ijk[d] = rest_of % n;
      rest_of /= n;
    }
    own      = Nearby(core, k, rest_of, ijk, gap);
    room     = PetscMax(0, moves ? own : PetscMin(own, rest[i]));
    least[i] = dt > 0 && room < PETSC_INFINITY ? -room / dt : room > 0 ? -PETSC_INFINITY : 0; /* dt 0: no step yet */
    if (moves) least[i + core->gaps->n] = Nearby(core, k, rest_of, ijk, rest);
  }
}

PetscErrorCode MPMGapsUpdate(MPMCore *core)
{
  const MPMGrid *grid   = &core->grid;
  const PetscInt dim    = grid->dim,
                 fields = MPM_BIT(x) | MPM_BIT(v) | MPM_BIT(F) | MPM_BIT(J) | MPM_BIT(kind) | MPM_BIT(rim);
  const PetscReal reach = 0.5 * MPMBasisNodes(core->basis);
  MPMGaps        *g     = core->gaps;
  MPMView         view;

  PetscFunctionBeginUser;
  if (!g) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < 2 * g->n; i++) g->gap[i] = PETSC_INFINITY;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt k = 0; k < 2 * dim; k++) {
    const PetscInt  d     = k / 2;
    const PetscBool moves = core->params.walls->given[d][k % 2].type == MPM_WALL_piston;
    const PetscReal near = reach * grid->h[d], behind = moves ? -grid->h[d] : PETSC_MIN_REAL;
    PetscReal       plane, sign;

    if (!(g->faces & (PetscInt)1 << k)) continue;
    MPMWallPlane(core->params.walls, grid, k, &plane, &sign);
    for (PetscInt p = 0; p < view.n; p++) {
      const PetscReal at = sign * (view.x[p * dim + d] - plane);

      if (at < near && at > behind) Tell(core, &view, p, k, at, g->gap + g->first[k], g->gap + g->n + g->first[k]);
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, g->gap, (PetscMPIInt)(2 * g->n), MPIU_REAL, MPI_MIN, core->exchange.data));
  for (PetscInt k = 0; k < 2 * dim; k++)
    if (g->faces & (PetscInt)1 << k) SetLeast(core, k);
  if (core->pistons) PetscCall(MPMPistonsUpdate(core));
  PetscFunctionReturn(PETSC_SUCCESS);
}
