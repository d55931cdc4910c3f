/* contact_cost.c - what contact adds to the predicted cost of a step (docs/model.md). How much matter will touch, and how
   long, is not known before the run. It is taken to be a part of what could: of the faces of the smaller one of the two
   boxes that enclose what may meet; or what is near each other at the start, if that is more. The constants were measured
   in seven scenes in 2-D and one in 3-D, on one core. */
#include "cost/cost.h"

#define TOUCHING 0.25    /* of the faces; 0.15 to 0.4 on average over a run */
#define DEEP     0.7     /* layers of cells that are searched on each side, for each node of a stencil along an axis */
#define LOOK     8e-9    /* s to look whether a particle is near a rigid body, */
#define SEARCH   0.25e-6 /* to find the surface and the normal by one that is, */
#define STENCIL  0.07e-6 /* and for each node of its stencil; */
#define BETWEEN  0.6     /* of these two between bodies, where few nodes have matter of both */
#define ROUNDS   3       /* to find the impulses; where every node acts by itself: */
#define ALONE    2
#define PART     22e-9   /* s for a part of a column in a round, */
#define SITE     0.12e-6 /* and for a node in a step */

/* For each cell of touching surface, with stencils of 3 nodes along an axis in 2-D: nodes of contact, and parts of
   columns. Of two bodies, with a rigid one, where matter flows. */
static const PetscReal nodes_of[] = {1.4, 3.5, 1.2}, parts_of[] = {2, 4, 1.2};

/* Boxes of what may meet, first copies of the nodes, then rigid bodies: minus the lowest on each axis, the highest, m; with
   how many others it may meet; particles of a cell. */
typedef struct {
  PetscReal end[6], others, full;
} Box;

/* Returns the faces of a box inside the grid, in cells. */
static PetscReal Faces(const MPMGrid *grid, const Box *box)
{
  PetscReal all = 0;

  for (PetscInt d = 0; d < grid->dim; d++) {
    PetscReal face = 1;

    for (PetscInt e = 0; e < grid->dim; e++)
      if (e != d)
        face *= PetscMax(0, PetscMin(box->end[3 + e], grid->upper[e]) - PetscMax(-box->end[e], grid->lower[e])) /
                grid->h[e];
    all += face * ((-box->end[d] > grid->lower[d] + 0.5 * grid->h[d] ? 1 : 0) +
                   (box->end[3 + d] < grid->upper[d] - 0.5 * grid->h[d] ? 1 : 0));
  }
  return all;
}

/* Sets the boxes [copies + rigid bodies]. Collective on exchange.data. */
static PetscErrorCode SetBoxes(MPMCore *core, PetscInt copies, Box box[])
{
  const PetscInt     fields = MPM_BIT(x) | MPM_BIT(kind), dim = core->grid.dim;
  const MPMContacts *c = core->contacts;
  MPMView            view;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < copies + core->rigids.n; b++)
    for (PetscInt k = 0; k < 6; k++) box[b].end[k] = -PETSC_MAX_REAL;
  for (PetscInt k = 0; k < core->params.nkinds; k++) {
    const MPMKind *kind = &core->params.kinds[k];
    PetscReal      full = 1;

    for (PetscInt d = 0; d < dim; d++) full *= 0.5 / kind->l[d];
    box[kind->copy].full = PetscMax(box[kind->copy].full, full);
  }
  PetscCall(MPMParticlesGetView(&core->particles, fields, &view));
  for (PetscInt p = 0; p < view.n; p++) {
    Box *to = &box[core->params.kinds[view.kind ? view.kind[p] : 0].copy];

    for (PetscInt d = 0; d < dim; d++) {
      to->end[d]     = PetscMax(to->end[d], -view.x[p * dim + d]);
      to->end[3 + d] = PetscMax(to->end[3 + d], view.x[p * dim + d]);
    }
  }
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &view));
  for (PetscInt b = 0; b < copies; b++)
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, box[b].end, 6, MPIU_REAL, MPIU_MAX, core->exchange.data));
  for (PetscInt r = 0; r < core->rigids.n; r++) {
    PetscReal lower[3], upper[3];

    MPMRegionBounds(core->rigids.body[r].shape, dim, lower, upper);
    for (PetscInt d = 0; d < dim; d++) {
      box[copies + r].end[d]     = -lower[d] - core->rigids.body[r].place[d];
      box[copies + r].end[3 + d] = upper[d] + core->rigids.body[r].place[d];
    }
  }
  for (PetscInt k = 0; k < c->npairs; k++) {
    box[c->pair[k].b].others += 1;
    box[c->pair[k].rigid ? copies + (c->pair[k].rigid - core->rigids.body) : c->pair[k].a].others += 1;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMModelContact(MPMModel *m, MPMCore *core)
{
  const MPMGrid  *grid   = &core->grid;
  const PetscInt  copies = PetscMax(1, grid->copies);
  const PetscReal reach = (PetscReal)MPMBasisNodes(core->basis), stencil = PetscPowReal(reach, (PetscReal)grid->dim);
  Box            *box;

  PetscFunctionBeginUser;
  m->look = m->search = m->impulses = 0;
  if (!core->contacts || m->measured) PetscFunctionReturn(PETSC_SUCCESS); /* a calibration has it in its rates */
  PetscCall(PetscCalloc1(copies + core->rigids.n, &box));
  PetscCall(SetBoxes(core, copies, box));
  PetscCall(MPMContactsFind(core));
  for (PetscInt q = 0; q < core->contacts->npairs; q++) {
    const MPMPair *pair = &core->contacts->pair[q];
    const Box     *b = &box[pair->b], *a = &box[pair->rigid ? copies + (pair->rigid - core->rigids.body) : pair->a];
    const int      how = pair->flows ? 2 : pair->rigid ? 1 : 0;
    PetscReal      surface, now = 0;

    for (PetscInt k = 0; k < core->contacts->nnodes; k++) now += core->contacts->node[k].pair == q;
    now /= nodes_of[how] * reach / 3;
    surface = TOUCHING * PetscMin(Faces(grid, a) / a->others, Faces(grid, b) / b->others);
    surface = PetscMax(surface, now);
    m->search += surface * DEEP * reach * ((pair->rigid ? 0 : a->full) + b->full) * (SEARCH + STENCIL * stencil) *
                 (pair->rigid ? 1 : BETWEEN);
    m->impulses += surface * reach / 3 * (SITE * nodes_of[how] + PART * (pair->flows ? ALONE : ROUNDS) * parts_of[how]);
  }
  m->look = core->rigids.n ? LOOK : 0;
  PetscCall(PetscFree(box));
  PetscFunctionReturn(PETSC_SUCCESS);
}
