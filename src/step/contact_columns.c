/* contact_columns.c - the columns in which nodes of contact act (contact.c): their parts, normals and gaps. */
#include "step/contact_search.h"

#define INCLINES                                                                                                       \
  0.7 /* of the largest squared component of a normal, below which a node is in no column along that axis */
#define STEEP     0.1  /* squared component of a normal, below which a column goes along the surface */
#define MISSES    0.05 /* cells: what passes the surface by more does not cross it */
#define SMOOTH    0.9  /* cosine between the normals there and at the nodes: at an edge they differ by more */
#define CROSSINGS 3    /* steps in which the place where a column crosses a rigid surface is found */

static const MPMContactNode *nodes_to_sort; /* qsort has no context */

/* The sequence of parts: by pair, columns, and along these. */
static int InOrder(const void *a, const void *b)
{
  const MPMContactPart *p = a, *q = b;
  const PetscInt       *i = nodes_to_sort[p->node].ijk, *j = nodes_to_sort[q->node].ijk;

  if (p->pair != q->pair) return p->pair < q->pair ? -1 : 1;
  if (p->axis != q->axis) return p->axis < q->axis ? -1 : 1;
  if (p->side != q->side) return p->side < q->side ? -1 : 1;
  for (PetscInt d = 2; d >= 0; d--)
    if (d != p->axis && i[d] != j[d]) return i[d] < j[d] ? -1 : 1;
  return i[p->axis] == j[p->axis] ? 0 : i[p->axis] < j[p->axis] ? -1 : 1;
}

static PetscBool SameColumn(PetscBool flows, const MPMContactNode node[], const MPMContactPart *p,
                            const MPMContactPart *q)
{
  if (flows || p->pair != q->pair || p->axis != q->axis || p->side != q->side) return PETSC_FALSE;
  for (PetscInt d = 0; d < 3; d++)
    if (d != p->axis && node[p->node].ijk[d] != node[q->node].ijk[d]) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Makes the parts of the nodes: a node is in the columns along the axis to which its normal inclines most, and along others to
   which it inclines nearly as much, by what the square of the normal's component is above a limit, so that the parts add
   up to its weight. Columns are few where they cross a surface at a small angle: each would hold a long piece of it by its
   least gap, and a disk on a plane of 31 degrees would hop. */
static PetscErrorCode MakeParts(MPMContacts *c, PetscInt dim)
{
  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(dim * c->nnodes + 1) * sizeof *c->part, &c->part));
  PetscCall(PetscRealloc((size_t)(dim * c->nnodes + 1) * sizeof *c->column, &c->column));
  for (PetscInt k = 0; k < c->nnodes; k++) {
    const MPMContactNode *q   = &c->node[k];
    PetscReal             all = 0, least = 0;

    if (c->pair[q->pair].glued || IsTied(&c->pair[q->pair])) continue;
    if (c->pair[q->pair].flows) { /* a mean of the surface would let single particles through */
      PetscInt axis = 0;

      for (PetscInt d = 1; d < dim; d++)
        if (PetscSqr(q->n[d]) > PetscSqr(q->n[axis]) + 1e-9) axis = d;
      c->part[c->nparts++] = (MPMContactPart){
          .node = k, .pair = q->pair, .axis = axis, .side = q->n[axis] > 0, .share = {1, 1}};
      continue;
    }
    for (PetscInt d = 0; d < dim; d++) least = PetscMax(least, INCLINES * PetscSqr(q->n[d]));
    for (PetscInt d = 0; d < dim; d++) all += PetscMax(0, PetscSqr(q->n[d]) - least);
    for (PetscInt d = 0; d < dim; d++) {
      MPMContactPart *to = &c->part[c->nparts];

      if (!(PetscSqr(q->n[d]) > least)) continue;
      *to = (MPMContactPart){.node = k, .pair = q->pair, .axis = d, .side = q->n[d] > 0};
      for (int side = 0; side < 2; side++)
        to->share[side] = (PetscSqr(q->n[d]) - least) / all * (PetscReal)PetscMax(0, q->weight[side]);
      if (to->share[0] > 0 || to->share[1] > 0) c->nparts++;
    }
  }
  nodes_to_sort = c->node;
  qsort(c->part, (size_t)c->nparts, sizeof *c->part, InOrder);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets where a column acts on a rigid body: where the line along its axis through the mean of its nodes, by their shares,
   crosses the surface; and its normal there. (At the nodes, which lie in the matter, a curved surface has another
   one: on a slope a ball would be pushed downhill.) */
static void SetPlace(const MPMCore *core, MPMContactColumn *to)
{
  const MPMContacts *c    = core->contacts;
  const MPMGrid     *grid = &core->grid;
  const PetscInt     axis = c->part[to->first].axis;
  PetscReal          n[3] = {0}, x[3], distance, along = 0;

  for (PetscInt k = to->first; k < to->last; k++) {
    MPMGridNodeAt(grid, c->node[c->part[k].node].ijk, x);
    for (PetscInt d = 0; d < grid->dim; d++) to->at[d] += c->part[k].share[1] * x[d];
  }
  for (int k = 0; k < CROSSINGS; k++) {
    distance = MPMRigidDistance(c->pair[to->pair].rigid, grid->dim, to->at, n);
    if (!(PetscSqr(n[axis]) > STEEP)) break;
    to->at[axis] -= PetscClipInterval(distance / n[axis], -grid->h[axis], grid->h[axis]);
  }
  distance = MPMRigidDistance(c->pair[to->pair].rigid, grid->dim, to->at, n);
  for (PetscInt d = 0; d < grid->dim; d++) to->at[d] -= distance * n[d];
  for (PetscInt d = 0; d < grid->dim; d++) along += n[d] * to->n[d];
  if (c->pair[to->pair].axis >= 0 || along < SMOOTH || PetscAbsReal(distance) > MISSES * grid->h[axis]) return;
  for (PetscInt d = 0; d < grid->dim; d++) to->n[d] = n[d];
}

/* Sets normal and gap of a column, and the shares of its parts; returns false if no matter that counts is on one side. */
static PetscBool SetColumn(const MPMCore *core, MPMContactColumn *to)
{
  const PetscReal dt     = core->params.dt;
  MPMContacts    *c      = core->contacts;
  const MPMPair  *pair   = &c->pair[to->pair];
  const PetscInt  axis   = c->part[to->first].axis;
  PetscReal       all[2] = {0}, size = 0, room = PETSC_INFINITY, V[3];
  PetscBool       alone;

  for (PetscInt k = to->first; k < to->last; k++)
    for (int side = 0; side < 2; side++) all[side] += c->part[k].share[side];
  if (pair->rigid) all[0] = 1;
  if (!(all[0] > 0 && all[1] > 0)) return PETSC_FALSE;
  for (PetscInt k = to->first; k < to->last; k++) {
    const MPMContactNode *q = &c->node[c->part[k].node];

    for (int side = 0; side < 2; side++) {
      c->part[k].share[side] /= all[side];
      for (PetscInt d = 0; d < 3; d++) to->n[d] += c->part[k].share[side] * q->n[d];
    }
    to->gap = PetscMin(to->gap, q->near[0][axis] + q->near[1][axis]);
    room    = PetscMin(room, q->room[axis]);
  }
  alone = !(to->gap < PETSC_INFINITY);
  for (PetscInt k = to->first; k < to->last && alone; k++) {
    const MPMContactNode *q = &c->node[c->part[k].node];

    to->gap = PetscMin(to->gap, q->wide[0] + q->wide[1]);
    room    = PetscMin(room, q->room[3]);
  }
  for (PetscInt d = 0; d < 3; d++) size += PetscSqr(to->n[d]);
  if (!(size > 0 && (pair->rigid ? room : to->gap) < PETSC_INFINITY)) return PETSC_FALSE;
  for (PetscInt d = 0; d < 3; d++) to->n[d] /= PetscSqrtReal(size);
  if (pair->flows && to->gap < 0) to->gap *= MPM_CONTACT_PUSH;
  to->least = dt > 0        ? -(pair->flows ? to->gap : PetscMax(0, to->gap)) / dt
              : to->gap > 0 ? -PETSC_INFINITY
                            : 0; /* dt 0: no step yet */
  for (int side = 0; side < 2 && pair->mu == PETSC_INFINITY && pair->flows; side++)
    if (!pair->soft[side] &&
        c->node[c->part[to->first].node].near[side][axis] > HeldWithin(core->basis) * core->grid.h[axis])
      to->slips = PETSC_TRUE;
  if (!pair->rigid) return PETSC_TRUE;
  SetPlace(core, to);
  MPMRigidVelocity(pair->rigid, core->grid.dim, to->at, V);
  if (dt > 0) to->least = -room / dt;
  for (PetscInt d = 0; d < core->grid.dim && dt > 0; d++) to->least -= V[d] * to->n[d];
  if (!pair->flows) to->least = PetscMin(0, to->least); /* or a body that turns would give more than it loses */
  return PETSC_TRUE;
}

static void SetColumns(const MPMCore *core)
{
  MPMContacts *c = core->contacts;

  for (PetscInt first = 0, last; first < c->nparts; first = last) {
    MPMContactColumn *to = &c->column[c->ncolumns];

    for (last = first + 1;
         last < c->nparts && SameColumn(c->pair[c->part[first].pair].flows, c->node, &c->part[first], &c->part[last]);)
      last++;
    *to = (MPMContactColumn){.first = first, .last = last, .pair = c->part[first].pair, .gap = PETSC_INFINITY};
    if (SetColumn(core, to)) c->ncolumns++;
  }
}

PetscErrorCode MPMContactColumns(MPMCore *core)
{
  PetscFunctionBeginUser;
  PetscCall(MakeParts(core->contacts, core->grid.dim));
  SetColumns(core);
  PetscFunctionReturn(PETSC_SUCCESS);
}
