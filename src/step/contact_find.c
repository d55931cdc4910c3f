/* contact_find.c - where bodies may meet in a step: the nodes of contact, how far the matter of both sides is apart, and which
   nodes are not to be light. Everything that is added up over particles is a whole number, and all other things are
   minima, so they have the same bits in every sequence; every process knows all nodes of contact. */
#include "physics/sizes.h"
#include "step/contact_search.h"

#define BESIDE  1.24 /* cells: matter that is farther beside a column does not count as that ahead of a rigid body */
#define TIE     1e-9 /* cells: a particle in the middle between two columns lies in both */
#define AROUND  2    /* nodes around touching ones that are not light either */
#define TOUCHES 1.0  /* cells: matter that is nearer touches, or may do so in this step */
#define NENDS   14   /* numbers of a node of which all processes have the least */
#define FACING  -0.8 /* cosine of the angle between normals on both sides of a thin body */
/* Cells: a body that is thinner between matter on both sides is warned of. Measured: at 1.5 a block that strikes a plate
   gives one behind it 0.14 of its momentum, at 2 0.01. */
#define THIN 1.75
/* Cells in the radius of a rigid ball, below which it is slow on matter; docs/choosing.md has what was measured. */
#define COARSE   8
#define SLIDES   4            /* cells: its way along matter from which on it is told */
#define OVERLAPS 0.5          /* cells: bodies that do so along the axis of their normal lie beside each other */
#define MOST     ldexp(1, 54) /* of what a particle adds to a weight, in units */

/* Makes the nodes of contact of the sums, and the sites of their copies. */
static PetscErrorCode MakeNodes(Search *s)
{
  MPMContacts *c = s->c;

  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(s->nfits + 1) * sizeof *c->node, &c->node));
  PetscCall(PetscRealloc((size_t)(2 * s->nfits + 1) * sizeof *c->site, &c->site));
  for (PetscInt k = 0; k < s->nfits; k++) {
    MPMContactNode *q = &c->node[c->nnodes];

    *q = (MPMContactNode){.pair = s->fit[k].pair};
    for (int side = s->c->pair[q->pair].rigid != NULL; side < 2;
         side++) { /* distances from rigid bodies are from their surface */
      q->wide[side] = PETSC_INFINITY;
      for (PetscInt d = 0; d < 3; d++) q->near[side][d] = PETSC_INFINITY;
    }
    for (PetscInt d = 0; d < 4; d++) q->room[d] = PETSC_INFINITY;
    q->thin[0] = q->thin[1] = PETSC_INFINITY;
    for (PetscInt d = 0; d < 3; d++) {
      q->n[d]   = s->normal[3 * k + d];
      q->ijk[d] = s->fit[k].ijk[d];
    }
    if (q->n[0] != 0 || q->n[1] != 0 || q->n[2] != 0) c->nnodes++;
  }
  PetscCall(
      SetKeys(s, c->nnodes, c->node, sizeof *c->node, offsetof(MPMContactNode, pair), offsetof(MPMContactNode, ijk)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int CompareKeys(const void *a, const void *b)
{
  const PetscInt64 p = ((const Key *)a)->number, q = ((const Key *)b)->number;

  return p < q ? -1 : p > q;
}

/* Makes the sites: the nodes of contact of several pairs share those of a copy. */
static PetscErrorCode MakeSites(Search *s)
{
  MPMContacts *c = s->c;
  Key         *key;
  PetscInt     n = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * c->nnodes, &key));
  for (PetscInt k = 0; k < c->nnodes; k++)
    for (int side = 0; side < 2; side++) {
      const MPMPair *pair = &c->pair[c->node[k].pair];

      c->node[k].site[side] = -1;
      if (!side && pair->rigid) continue;
      key[n++] = (Key){KeyOf(&s->core->grid, side ? pair->b : pair->a, c->node[k].ijk), 2 * k + side};
    }
  if (n) qsort(key, (size_t)n, sizeof *key, CompareKeys);
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt  side = key[k].at % 2;
    MPMContactNode *q    = &c->node[key[k].at / 2];
    const MPMPair  *pair = &c->pair[q->pair];

    if (!k || key[k].number != key[k - 1].number)
      c->site[c->nsites++] = (MPMContactSite){.copy = side ? pair->b : pair->a,
                                              .ijk  = {q->ijk[0], q->ijk[1], q->ijk[2]}};
    q->site[side] = c->nsites - 1;
    if (!IsTied(pair) || c->site[c->nsites - 1].tied) continue;
    q->tied = c->site[c->nsites - 1].tied = PETSC_TRUE; /* to the first one of several */
  }
  PetscCall(PetscFree(key));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tells a node of contact of a particle at x [dim], at the distance `from` from a rigid body, with the normal `own` there:
   that it is on the node's side, or how thick the body is between them. */
static void Beside(const MPMGrid *grid, const MPMRigid *rigid, MPMContactNode *q, const PetscReal own[],
                   const PetscReal x[], PetscReal from)
{
  PetscReal at[3], n[3], facing = 0, apart = 0;

  for (PetscInt d = 0; d < grid->dim; d++) facing += own[d] * q->n[d];
  if (facing > 0) q->thin[0] = PetscMin(q->thin[0], from);
  if (facing > FACING) return;
  MPMGridNodeAt(grid, q->ijk, at);
  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal by = x[d] - at[d], length = grid->upper[d] - grid->lower[d];

    apart += own[d] * (grid->periodic[d] ? by - length * PetscFloorReal(by / length + 0.5) : by);
  }
  q->thin[1] = PetscMin(q->thin[1], PetscMax(0, apart - from - MPMRigidDistance(rigid, grid->dim, at, n)));
}

/* Lets a particle tell the nodes of contact of its stencil its part of the weights, and where its matter ends. */
static PetscErrorCode Tell(Search *s, PetscInt pair, int side, PetscInt p, uint64_t mixed)
{
  const MPMCore  *core  = s->core;
  const MPMGrid  *grid  = &core->grid;
  const PetscInt  dim   = grid->dim;
  const MPMRigid *rigid = s->c->pair[pair].rigid;
  PetscReal       F[9], units, V[3], own[3] = {0}, surface = 0, from = 0, h = 0, hoop = 0;
  PetscInt        at[3];
  MPMMatterEnd    matter;
  Stencil         t;

  PetscFunctionBeginUser;
  if (!mixed) PetscFunctionReturn(PETSC_SUCCESS);
  SetStencil(s, p, &t);
  units = -MPMKindOf(core->params.kinds, &s->view, p)->V0 / UNIT * MPMMatterDeformation(core, &s->view, p, F);
  MPMMatterSetEnd(core, &s->view, p, F, &matter);
  for (PetscInt d = 0; d < dim; d++) {
    units /= grid->h[d];
    h = PetscMax(h, grid->h[d]);
  }
  if (grid->round) hoop = grid->h[0] / PetscMax(s->view.x[p * dim], MPM_ROUND_LEAST * grid->h[0]);
  if (rigid) { /* by the distance and the normal where the particle is */
    const PetscReal *x = s->view.x + p * dim;

    from = MPMRigidDistance(rigid, dim, x, own);
    MPMRigidVelocity(rigid, dim, x, V);
    surface = PetscMin(from - MPMMatterReaches(dim, &matter, own, h), MPMMatterArrives(core, &s->view, p, own, V));
  }
  FOR_STENCIL(&t, at)
  {
    PetscReal       part = 0, aside[3] = {0}, n[3] = {0}, end = 0;
    PetscInt        ijk[3], k, main = 0; /* the axis that the normal is nearest to */
    MPMContactNode *q;

    if (!IsAmong(&t, at, mixed)) continue;
    SetIjk(grid, &t, at, ijk);
    k = FindKey(s, KeyOf(grid, pair, ijk));
    if (k < 0) continue;
    q = &s->c->node[k];
    for (PetscInt d = 0; d < dim; d++) {
      PetscReal       phi = 1;
      const PetscReal by  = t.xi[d] - (PetscReal)(t.base[d] + at[d]);

      n[d] = side ? q->n[d] : -q->n[d];
      for (PetscInt e = 0; e < dim; e++) phi *= e == d ? t.g[e][at[e]] : t.w[e][at[e]];
      part += phi * n[d];
      end += by * grid->h[d] * n[d];
      for (PetscInt e = 0; e < dim; e++)
        if (e != d) aside[e] = PetscMax(aside[e], PetscAbsReal(by));
      if (grid->round && d == 0) part += n[0] * t.w[0][at[0]] * t.w[1][at[1]] * hoop;
    }
    for (PetscInt d = 1; d < dim; d++)
      if (PetscAbsReal(n[d]) > PetscAbsReal(n[main])) main = d;
    q->weight[side] += (PetscInt64)PetscMax(-MOST, PetscMin(MOST, units * part));
    end = rigid ? surface : end - MPMMatterReaches(dim, &matter, n, h);
    for (PetscInt d = 0; d < dim; d++)
      if (aside[d] < 0.5 + TIE) q->near[side][d] = PetscMin(q->near[side][d], end);
    if (!rigid || aside[main] < BESIDE) q->wide[side] = PetscMin(q->wide[side], end);
    if (!rigid) continue;
    Beside(grid, rigid, q, own, s->view.x + p * dim, from);
    if (end < 0) end *= s->c->pair[pair].flows ? MPM_CONTACT_PUSH : 0;
    for (PetscInt d = 0; d < dim; d++) end -= core->params.dt * V[d] * own[d];
    for (PetscInt d = 0; d < dim; d++)
      if (aside[d] < 0.5 + TIE) q->room[d] = PetscMin(q->room[d], end);
    if (aside[main] < BESIDE) q->room[3] = PetscMin(q->room[3], end);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Merges weights and ends of all processes. Collective on exchange.data. */
static PetscErrorCode CollectEnds(Search *s)
{
  MPMContacts *c = s->c;
  PetscInt64  *weight;
  PetscReal   *end;
  PetscMPIInt  size, count;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(s->core->exchange.data, &size));
  if (size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(2 * c->nnodes, &weight, NENDS * c->nnodes, &end));
  for (PetscInt k = 0; k < c->nnodes; k++) {
    for (PetscInt d = 0; d < 4; d++) end[NENDS * k + 8 + d] = c->node[k].room[d];
    for (int side = 0; side < 2; side++) end[NENDS * k + 12 + side] = c->node[k].thin[side];
    for (int side = 0; side < 2; side++) {
      weight[2 * k + side] = c->node[k].weight[side];
      for (PetscInt d = 0; d < 3; d++) end[NENDS * k + 4 * side + d] = c->node[k].near[side][d];
      end[NENDS * k + 4 * side + 3] = c->node[k].wide[side];
    }
  }
  PetscCall(PetscMPIIntCast(2 * c->nnodes, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, weight, count, MPIU_INT64, MPI_SUM, s->core->exchange.data));
  PetscCall(PetscMPIIntCast(NENDS * c->nnodes, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, end, count, MPIU_REAL, MPI_MIN, s->core->exchange.data));
  for (PetscInt k = 0; k < c->nnodes; k++) {
    for (PetscInt d = 0; d < 4; d++) c->node[k].room[d] = end[NENDS * k + 8 + d];
    for (int side = 0; side < 2; side++) c->node[k].thin[side] = end[NENDS * k + 12 + side];
    for (int side = 0; side < 2; side++) {
      c->node[k].weight[side] = weight[2 * k + side];
      for (PetscInt d = 0; d < 3; d++) c->node[k].near[side][d] = end[NENDS * k + 4 * side + d];
      c->node[k].wide[side] = end[NENDS * k + 4 * side + 3];
    }
  }
  PetscCall(PetscFree2(weight, end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns once of a rigid body that is too thin for the matter on both of its sides: this shares nodes. */
static PetscErrorCode WarnThin(Search *s)
{
  const MPMGrid  *grid = &s->core->grid;
  const PetscReal h    = MPMGridSmallestH(grid);

  PetscFunctionBeginUser;
  for (const MPMContactNode *q = s->c->node; q < s->c->node + s->c->nnodes && !s->core->rigids.thin; q++) {
    PetscReal x[3];
    char      at[MPM_NAME_LEN], thick[MPM_NAME_LEN];

    if (!(q->thin[0] < PETSC_INFINITY && q->thin[1] < THIN * h)) continue;
    MPMGridNodeAt(grid, q->ijk, x);
    MPMPlaceWords(grid->dim, x, at);
    s->core->rigids.thin = PETSC_TRUE;
    (void)snprintf(thick, sizeof thick, q->thin[1] < 0.1 * h ? "less than 0.1" : "only %.2g", (double)(q->thin[1] / h));
    PetscCall(MPMWarn(&s->core->print,
                      "the rigid body %s is %s cells thick near %s, between matter on both sides: up to a quarter of "
                      "a blow passes through it; make it 2 cells thick, or give -contacts to the bodies on its sides",
                      s->c->pair[q->pair].rigid->name, thick, at));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Warns once of bodies whose matter overlaps along the axis that is given as their normal: they lie beside each other, and
   pass through each other unseen. */
static PetscErrorCode WarnBeside(Search *s)
{
  const MPMGrid *grid = &s->core->grid;

  PetscFunctionBeginUser;
  for (const MPMContactNode *q = s->c->node; q < s->c->node + s->c->nnodes && !s->c->beside; q++) {
    const MPMPair  *pair = &s->c->pair[q->pair];
    const PetscInt  axis = pair->axis;
    const PetscReal by   = axis < 0 ? 0 : -(q->near[0][axis] + q->near[1][axis]) / grid->h[axis];
    PetscReal       x[3];
    char            at[MPM_NAME_LEN];

    if (!(by > OVERLAPS)) continue;
    MPMGridNodeAt(grid, q->ijk, x);
    MPMPlaceWords(grid->dim, x, at);
    s->c->beside = PETSC_TRUE;
    PetscCall(
        MPMWarn(&s->core->print,
                "seen at t=%g s: along %c (-contact_%s_normal) the bodies of contact %s overlap by %.2g cells near "
                "%s, and pass through each other there; leave out -contact_%s_normal",
                (double)s->core->t, "xyz"[axis], pair -> name, pair -> name, (double)by, at, pair -> name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes once of a free rigid ball or disk that slides or rolls on matter that its radius has few cells. */
static PetscErrorCode NoteCoarse(Search *s)
{
  const PetscInt  dim = s->core->grid.dim;
  const PetscReal h   = MPMGridSmallestH(&s->core->grid);

  PetscFunctionBeginUser;
  for (PetscInt pair = 0; pair < s->c->npairs; pair++) {
    MPMRigid *rigid = s->c->pair[pair].rigid;
    PetscReal most2 = 0;
    char      finer[80];

    if (!rigid || !rigid->free || rigid->slid < 0 || s->c->pair[pair].flows || !MPMRigidIsRound(rigid)) continue;
    if (rigid->shape->radius > (COARSE - 0.1) * h) continue;
    for (const MPMContactColumn *c = s->c->column; c < s->c->column + s->c->ncolumns; c++) {
      PetscReal along = 0, v2 = 0;

      if (c->pair != pair || c->gap > 0) continue;
      for (PetscInt d = 0; d < dim; d++) along += rigid->velocity[d] * c->n[d];
      for (PetscInt d = 0; d < dim; d++) v2 += PetscSqr(rigid->velocity[d] - along * c->n[d]);
      most2 = PetscMax(most2, v2);
    }
    rigid->slid += s->core->params.dt * PetscSqrtReal(most2);
    if (rigid->slid < SLIDES * h) continue;
    rigid->slid = -1;
    MPMGridFiner(&s->core->grid, 16 * h / rigid->shape->radius, finer, sizeof finer);
    PetscCall(
        MPMNote(&s->core->print,
                "seen at t=%g s: the rigid body %s, with %.2g cells in its radius, slides or rolls on matter; smooth "
                "disks with 4, 8 and 16 then have 0.86, 0.96 and 0.99 of their speed; choose %s",
                (double)s->core->t, rigid->name, (double)(rigid->shape->radius / h), finer));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Marks the nodes around a node of contact, of both copies, in the patch's arrays, across periodic faces too. */
static void MarkNode(const MPMPatch *patch, const MPMPair *pair, const MPMContactNode *node, char held[])
{
  const MPMGrid *grid = patch->grid;

  for (PetscInt q = pair->rigid ? 27 : 0; q < 54; q++) {
    const PetscInt by[3] = {q % 3 - 1, q / 3 % 3 - 1, q / 9 % 3 - 1};
    PetscInt       lo[3] = {0}, hi[3] = {0}, at[3];
    PetscBool      there = PETSC_TRUE;

    for (PetscInt d = 0; d < 3; d++) {
      const PetscInt i = node->ijk[d] + MPMGridFirst(grid, d, q < 27 ? pair->a : pair->b) +
                         by[d] * (grid->periodic[d] ? grid->cells[d] : 0) - patch->lo[d];

      if (by[d] && !grid->periodic[d]) there = PETSC_FALSE;
      lo[d] = PetscMax(0, i - (d < grid->dim ? AROUND : 0));
      hi[d] = PetscMin(patch->n[d] - 1, i + (d < grid->dim ? AROUND : 0));
    }
    for (at[2] = lo[2]; at[2] <= hi[2] && there; at[2]++)
      for (at[1] = lo[1]; at[1] <= hi[1]; at[1]++)
        for (at[0] = lo[0]; at[0] <= hi[0]; at[0]++) held[(at[2] * patch->n[1] + at[1]) * patch->n[0] + at[0]] = 1;
  }
}

/* Marks the nodes of the patch's arrays where matter touches, which are not to be light (kernels/light.h): these nodes of
   little mass take a part of the impulse. */
static PetscErrorCode MarkTouching(Search *s)
{
  const MPMPatch *patch = &s->core->exchange.patch;
  const MPMGrid  *grid  = patch->grid;
  char           *held;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(MPMPatchNodes(patch), &held));
  s->core->exchange.light.held = held;
  for (PetscInt k = 0; k < s->c->nnodes; k++)
    if (s->c->pair[s->c->node[k].pair].glued) MarkNode(patch, &s->c->pair[s->c->node[k].pair], &s->c->node[k], held);
  for (const MPMContactColumn *c = s->c->column; c < s->c->column + s->c->ncolumns; c++)
    for (PetscInt k = c->first; k < c->last && c->gap < TOUCHES * grid->h[s->c->part[c->first].axis]; k++)
      MarkNode(patch, &s->c->pair[c->pair], &s->c->node[s->c->part[k].node], held);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMContactsFind(MPMCore *core)
{
  const PetscInt fields = MPM_BIT(x) | MPM_BIT(v) | MPM_BIT(F) | MPM_BIT(J) | MPM_BIT(kind) | MPM_BIT(rim) | MPM_BIT(l);
  Search         s      = {.core = core, .c = core->contacts};

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < core->params.nkinds; k++) {
    const MPMKind *kind = &core->params.kinds[k];
    PetscReal      full = 1;

    for (PetscInt d = 0; d < core->grid.dim; d++) full *= 0.5 / kind->l[d];
    for (PetscInt q = 0; q < s.c->npairs; q++) {
      const MPMMaterial *m = &core->params.materials[kind->material];
      MPMPair           *p = &s.c->pair[q];

      if (p->a == kind->copy || p->b == kind->copy)
        p->flows = p->flows || (p->rigid ? m->type->traits & MPM_FLUID : !MPMMaterialKeepsShape(m));
      if ((p->a == kind->copy || p->b == kind->copy) && !MPMMaterialKeepsShape(m))
        p->soft[p->b == kind->copy] = PETSC_TRUE;
    }
    s.full[kind->copy] = PetscMax(s.full[kind->copy], full);
  }
  s.c->nnodes = s.c->nsites = s.c->nparts = s.c->ncolumns = 0;
  PetscCall(PetscFree(core->exchange.light.held));
  if (!s.c->near && !core->rigids.n) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MPMParticlesGetView(&core->particles, fields, &s.view));
  PetscCall(MPMContactNear(&s));
  PetscCall(MPMContactNormals(&s));
  PetscCall(MakeNodes(&s));
  for (PetscInt pair = 0; pair < s.c->npairs; pair++)
    for (int side = 0; side < 2 && !IsTied(&s.c->pair[pair]); side++)
      PetscCall(MPMContactForParticles(&s, pair, side, Tell));
  PetscCall(CollectEnds(&s));
  PetscCall(WarnThin(&s));
  PetscCall(WarnBeside(&s));
  PetscCall(MakeSites(&s));
  PetscCall(MPMContactColumns(core));
  PetscCall(NoteCoarse(&s));
  if (core->params.light > 0 && s.c->nnodes) PetscCall(MarkTouching(&s));
  PetscCall(PetscFree(s.key));
  PetscCall(PetscFree(s.normal));
  PetscCall(PetscFree(s.wanted));
  PetscCall(PetscFree(s.mixed));
  PetscCall(PetscFree(s.first));
  PetscCall(PetscFree(s.box));
  PetscCall(PetscFree(s.faces));
  PetscCall(PetscFree(s.fit));
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &s.view));
  PetscCall(PetscFree(s.cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}
