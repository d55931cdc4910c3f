/* parting.c - matter that parts: neighbours of the lattice that are too far from each other for the grid to hold them
   together, or too far from the wall that holds them. A body is continuous, and no law here lets it fail, so what parts
   does so by the grid's doing: nodes that only one of two neighbours reaches carry no tension between them. It is used
   after steps, and changes no state.

   The distance of two neighbours is measured in cells. As long as both know of it, it is the one that their deformation
   gives; where one is left behind, F stays, and the distance grows. A wall that holds what it meets is a mirror: the
   gap is twice the distance of the particle next to it. Single particles may be left behind at corners, where the
   stress has no bound; a body has parted where a crack is longer than a cell, or goes through it. */
#include <stdlib.h>
#include "advice/watch.h"

#define NEVER (-1) /* no neighbour */

/* What is known of a particle, as it is sent to another process too: its place, and by axis d the vector to where its
   deformation takes the next particle along axis d, in cells, how far that may be at most, and the stress that pulls at
   the two, Pa. A law with plastic flow has no such vector; neighbours are at most as far as its elastic strain and that
   of its flow move them. */
typedef struct {
  PetscReal id, x[3], column[3][3], known[3], pull[3];
} Half;

/* A message: a pair of neighbours is told to the process that has the number of its upper particle, by both of them. */
typedef struct {
  PetscReal upper, axis; /* number of the upper particle; axis of the pair, or -1: of the upper particle itself */
  Half      half;
} Message;

typedef struct {
  MPMCore             *core;
  const MPMScene      *scene;
  const MPMNeighbours *neighbours; /* [nbodies] */
  MPMView              view;
  PetscInt *row, nrow;     /* [nrow] the rows of ids, a table of hashes, or if `direct` by the id itself; -1: none */
  PetscBool direct, alone; /* alone: this process has all particles */
  PetscInt  near;          /* as in MPMWatch */
  MPMFound  wide;          /* the largest distance */
  MPMFound *link;          /* [nlinks] distances at which neighbours have parted */
  Message  *message;
  PetscInt  nlinks, links_room, nmessages, room;
} Look;

/* --- The particles here ------------------------------------------------------------------------------------------- */

static PetscInt Slot(const Look *l, PetscInt64 id)
{
  return l->direct ? (PetscInt)id : (PetscInt)((uint64_t)id * 0x9e3779b97f4a7c15ULL >> 20) & (l->nrow - 1);
}

/* Makes the table of ids. Where this process has most of the particles it is a plain one. */
static PetscErrorCode MakeRows(Look *l)
{
  PetscFunctionBeginUser;
  l->direct = l->core->particles.born <= 2 * (PetscInt64)l->view.n + 64;
  if (l->direct)
    l->nrow = (PetscInt)l->core->particles.born;
  else
    for (l->nrow = 64; l->nrow < 2 * l->view.n;) l->nrow *= 2;
  PetscCall(PetscMalloc1(l->nrow, &l->row));
  for (PetscInt k = 0; k < l->nrow; k++) l->row[k] = NEVER;
  for (PetscInt p = 0; p < l->view.n; p++) {
    PetscInt slot = Slot(l, l->view.id[p]);

    while (l->row[slot] != NEVER) slot = (slot + 1) & (l->nrow - 1); /* never if it is direct */
    l->row[slot] = p;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the row of a particle, or NEVER if it is on another process. */
static PetscInt RowOf(const Look *l, PetscInt64 id)
{
  PetscInt slot = Slot(l, id);

  if (l->direct) return l->row[slot];
  while (l->row[slot] != NEVER && l->view.id[l->row[slot]] != id) slot = (slot + 1) & (l->nrow - 1);
  return l->row[slot];
}

/* Fills in what is known of the particle of a row. */
static void GetHalf(const Look *l, const MPMNeighbours *nb, PetscInt p, Half *half)
{
  const MPMCore     *core     = l->core;
  const MPMMaterial *m        = &core->params.materials[nb->body->material];
  const PetscInt     dim      = core->grid.dim;
  const PetscBool    plastic  = MPMMaterialKnowsFlow(m);
  PetscReal          elastic2 = 1;
  MPMBlock           b;

  PetscCallVoid(PetscMemzero(half, sizeof *half));
  half->id = (PetscReal)l->view.id[p];
  MPMMaterialState(dim, &l->view, p, &b);
  if (!plastic && !(m->state & MPM_BIT(tau))) m->type->law->stress[MPMLawForm(m, dim)](m, 0, 1, &b);
  for (PetscInt d = 0; d < dim && plastic; d++) { /* the largest eigenvalue of be is at most its largest sum of a row */
    PetscReal row = 0;

    for (PetscInt e = 0; e < dim; e++) row += PetscAbsReal(b.be[MPMSymPart((int)dim, (int)d, (int)e)][0]);
    elastic2 = PetscMax(elastic2, row);
  }
  for (PetscInt d = 0; d < dim; d++) {
    PetscReal *c = half->column[d], known2 = 0;

    half->x[d] = l->view.x[p * dim + d];
    for (PetscInt e = 0; e < dim && !plastic; e++) {
      c[e] = l->view.F[(p * dim + e) * dim + d] * nb->body->b[d] / core->grid.h[e];
      known2 += PetscSqr(c[e]);
    }
    for (PetscInt e = 0; e < dim * dim && !plastic; e++)
      half->pull[d] += c[e / dim] * b.tau[MPMSymIndex((int)(e / dim), (int)(e % dim))][0] * c[e % dim] / known2;
    half->known[d] = plastic ? nb->body->b[d] / core->grid.h[d] * MPMExp(l->view.ep[p]) * PetscSqrtReal(elastic2)
                             : PetscSqrtReal(known2);
  }
}

/* --- Distances ---------------------------------------------------------------------------------------------------- */

/* Returns the distance of neighbours, in cells, at which a body is apart whatever its deformation is. Of an elastic
   body so few nodes then have both of them in reach that they hardly hold each other. A metal that flows gets thinner
   as it gets longer, and what comes from its sides fills the gaps; it is apart where its neighbours have no node in
   common, unless its flow takes them farther: shear does so and opens no gap. */
static PetscReal TearsAt(MPMBasis basis, const MPMMaterial *m)
{
  if (MPMMaterialKnowsFlow(m)) return (PetscReal)MPMBasisNodes(basis);
  return MPMBasisIsSpline(basis) ? MPM_BOUND_gap_splines : MPM_BOUND_gap_hats;
}

/* Judges a distance of a particle at x; of: its length, that at the start, and up to which the deformation explains it,
   in cells; pull: the stress that pulls at its ends, without which it does not open by itself. key: see MPMFound. */
static PetscErrorCode Judge(Look *l, const MPMBody *b, PetscInt64 key, const PetscReal x[], const PetscReal of[3],
                            PetscReal pull)
{
  const MPMMaterial *m       = &l->core->params.materials[b->material];
  const PetscBool    plastic = MPMMaterialKnowsFlow(m);
  const PetscReal    gap = of[0], start = of[1], lags = of[2] > 0 ? gap / of[2] : PETSC_MAX_REAL;
  const PetscReal    tears   = TearsAt(l->core->basis, m);
  const PetscBool    lagging = lags > MPM_BOUND_gap_lagging;
  const PetscReal    bound   = lagging ? MPM_BOUND_gap_left : MPM_BOUND_gap_wide;
  MPMFound           found   = {gap / bound, key, {0}, {gap, start, of[2]}};

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < l->core->grid.dim; d++) found.x[d] = x[d];
  if (gap < MPM_BOUND_gap_near || (!lagging && (plastic ? gap < tears || of[2] > gap : !(pull > 0))))
    PetscFunctionReturn(PETSC_SUCCESS);
  if (gap > start * MPM_BOUND_gap_opens) l->near = PetscMax(l->near, lagging && found.value > 1 ? 2 : 1);
  if (gap > start * MPM_BOUND_gap_grown) MPMFoundTake(&l->wide, &found);
  found.value = PetscMin(gap / MPM_BOUND_gap_parted, lags / MPM_BOUND_gap_lags);
  if (!plastic) found.value = PetscMax(found.value, gap / tears);
  if (!(found.value > 1)) PetscFunctionReturn(PETSC_SUCCESS);
  if (l->nlinks == l->links_room) {
    l->links_room = 2 * l->links_room + 64;
    PetscCall(PetscRealloc((size_t)l->links_room * sizeof *l->link, &l->link));
  }
  l->link[l->nlinks++] = found;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Looks at a pair of neighbours along `axis`, whose upper one lies at y and knows of the distance `known`. A shear
   moves neighbours along each other without opening a gap: what whole steps to other neighbours undo does not count. */
static PetscErrorCode LookAtPair(Look *l, const MPMNeighbours *nb, PetscInt axis, const Half *p, const PetscReal y[],
                                 PetscReal known)
{
  const MPMGrid *grid = &l->core->grid;
  PetscReal      g[3], of[3], gap2 = 0;

  PetscFunctionBeginUser;
  for (PetscInt e = 0; e < grid->dim; e++) {
    const PetscReal cells = (PetscReal)grid->cells[e];

    g[e] = (y[e] - p->x[e]) / grid->h[e];
    if (grid->periodic[e]) g[e] -= cells * PetscFloorReal(g[e] / cells + 0.5);
  }
  for (PetscInt a = 0; a < grid->dim; a++) {
    PetscReal along = 0, size2 = 0;

    for (PetscInt e = 0; e < grid->dim; e++) {
      along += g[e] * p->column[a][e];
      size2 += PetscSqr(p->column[a][e]);
    }
    for (PetscInt e = 0; e < grid->dim && a != axis && size2 > 0; e++)
      g[e] -= PetscFloorReal(along / size2 + 0.5) * p->column[a][e];
  }
  for (PetscInt e = 0; e < grid->dim; e++) gap2 += PetscSqr(g[e]);
  of[0] = PetscSqrtReal(gap2);
  of[1] = nb->body->b[axis] / grid->h[axis];
  of[2] = PetscMax(p->known[axis], known);
  PetscCall(Judge(l, nb->body, 16 * (PetscInt64)p->id + axis, p->x, of, p->pull[axis]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a wall holds what it meets along its normal, in both senses. */
static PetscBool Holds(const MPMWalls *walls, PetscInt axis, PetscInt side)
{
  const MPMWall type = walls->given[axis][side].type;

  return MPMWallHas(type, MPM_WALL_NORMAL) && !MPMWallHas(type, MPM_WALL_PUSHES);
}

/* Looks at the distance of a particle at the place ijk of the lattice from the walls that hold matter and that its body
   touched at the start. Of a wall of type moving matter may move away, since its face stays. */
static PetscErrorCode LookAtWalls(Look *l, const MPMNeighbours *nb, PetscInt p, const PetscInt64 ijk[], PetscInt axis)
{
  const MPMGrid  *grid  = &l->core->grid;
  const MPMWalls *walls = &l->scene->walls;
  const MPMBody  *b     = nb->body;
  const PetscInt  dim   = grid->dim;

  PetscFunctionBeginUser;
  for (PetscInt side = 0; side < 2; side++) {
    const PetscInt  face = 2 * axis + side;
    const MPMWall   type = walls->given[axis][side].type;
    const PetscReal sign = side ? -1 : 1, at = side ? grid->upper[axis] : grid->lower[axis];
    const PetscReal place = b->b[axis] * ((PetscReal)ijk[axis] + 0.5) + b->offset[axis];
    const PetscReal from  = sign * (place - at) - walls->given[axis][side].distance;
    const PetscReal now = sign * (l->view.x[p * dim + axis] - at) - walls->place[face], h = grid->h[axis];
    PetscReal       of[3];
    Half            half;

    if (!Holds(walls, axis, side) || (MPMWallHas(type, MPM_WALL_MOVES) && !walls->given[axis][side].pulls)) continue;
    if (!(from > 0 && from < b->b[axis]) || 2 * now < MPM_BOUND_gap_near * h) continue;
    GetHalf(l, nb, p, &half);
    of[0] = 2 * now / h;
    of[1] = 2 * from / h;
    of[2] = 2 * from / h * half.known[axis] * h / b->b[axis];
    PetscCall(Judge(l, b, 16 * l->view.id[p] + 3 + face, half.x, of, half.pull[axis]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Neighbours on other processes -------------------------------------------------------------------------------- */

/* Adds a message about the particle of a row. */
static PetscErrorCode Send(Look *l, const MPMNeighbours *nb, PetscInt64 upper, PetscInt axis, PetscInt p)
{
  PetscFunctionBeginUser;
  if (l->nmessages == l->room) {
    l->room = 2 * l->room + 64;
    PetscCall(PetscRealloc((size_t)l->room * sizeof *l->message, &l->message));
  }
  l->message[l->nmessages].upper = (PetscReal)upper;
  l->message[l->nmessages].axis  = (PetscReal)axis;
  GetHalf(l, nb, p, &l->message[l->nmessages++].half);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The messages of a pair follow each other, that of its upper particle first. */
static int CompareMessages(const void *a, const void *b)
{
  const Message *p = (const Message *)a, *q = (const Message *)b;

  return p->upper != q->upper ? (p->upper < q->upper ? -1 : 1) : p->axis < q->axis ? -1 : p->axis > q->axis;
}

/* Sends the messages, each to process `upper` modulo their number, and looks at the pairs that have both of their
   particles among those that came: others have lost one of them. Collective on exchange.data. */
static PetscErrorCode LookElsewhere(Look *l)
{
  const MPI_Comm comm = l->core->exchange.data;
  const size_t   each = sizeof(Message) / sizeof(PetscReal);
  PetscMPIInt    size, *count; /* [4][size]: numbers that are sent, and where they begin; that come, and where */
  PetscInt      *at, come = 0;
  Message       *sorted, *got;

  PetscFunctionBeginUser;
  if (l->alone) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscCalloc1(4 * size, &count));
  PetscCall(PetscCalloc1(size, &at));
  for (PetscInt k = 0; k < l->nmessages; k++) count[(PetscInt64)l->message[k].upper % size] += (PetscMPIInt)each;
  PetscCallMPI(MPI_Alltoall(count, 1, MPI_INT, count + 2 * size, 1, MPI_INT, comm));
  for (PetscMPIInt k = 1; k < size; k++) {
    count[size + k]     = count[size + k - 1] + count[k - 1];
    count[3 * size + k] = count[3 * size + k - 1] + count[2 * size + k - 1];
  }
  for (PetscMPIInt k = 0; k < size; k++) {
    at[k] = count[size + k] / (PetscInt)each;
    come += count[2 * size + k] / (PetscInt)each;
  }
  PetscCall(PetscMalloc1(PetscMax(1, l->nmessages), &sorted));
  PetscCall(PetscMalloc1(PetscMax(1, come), &got));
  for (PetscInt k = 0; k < l->nmessages; k++) sorted[at[(PetscInt64)l->message[k].upper % size]++] = l->message[k];
  PetscCallMPI(
      MPI_Alltoallv(sorted, count, count + size, MPIU_REAL, got, count + 2 * size, count + 3 * size, MPIU_REAL, comm));
  qsort(got, (size_t)come, sizeof *got, CompareMessages);
  for (PetscInt k = 0, upper = -1, b = 0; k < come; k++) {
    const PetscInt axis = (PetscInt)got[k].axis;

    if (axis < 0)
      upper = k;
    else if (upper >= 0 && got[upper].upper == got[k].upper) {
      b = MPMBodyOf(l->scene, (PetscInt64)got[k].half.id, b);
      PetscCall(LookAtPair(l, &l->neighbours[b], axis, &got[k].half, got[upper].half.x, got[upper].half.known[axis]));
    }
  }
  PetscCall(PetscFree(got));
  PetscCall(PetscFree(sorted));
  PetscCall(PetscFree(at));
  PetscCall(PetscFree(count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- A look at all ------------------------------------------------------------------------------------------------ */

/* Looks at a particle of a body on a lattice: at its upper neighbours, and at walls where it has none. */
static PetscErrorCode LookAt(Look *l, const MPMNeighbours *nb, PetscInt p)
{
  const PetscInt  dim   = l->core->grid.dim;
  const MPMWalls *walls = &l->scene->walls;
  PetscInt64      ijk[3];
  PetscBool       lower = PETSC_FALSE; /* is its lower neighbour on some axis elsewhere? */

  PetscFunctionBeginUser;
  MPMNeighboursPlace(nb, l->view.id[p], ijk);
  for (PetscInt d = 0; d < dim; d++) {
    PetscInt64 id, below;
    PetscInt   q;
    PetscReal  far2 = 0;
    Half       half, other;

    ijk[d]++;
    id = MPMNeighboursId(nb, ijk);
    ijk[d] -= 2;
    below = l->alone || lower ? -1 : MPMNeighboursId(nb, ijk);
    ijk[d]++;
    if (below >= 0 && RowOf(l, below) == NEVER) lower = PETSC_TRUE;
    if (Holds(walls, d, 0) || Holds(walls, d, 1)) PetscCall(LookAtWalls(l, nb, p, ijk, d));
    if (id < 0) continue;
    q = RowOf(l, id);
    if (q == NEVER) {
      if (!l->alone) PetscCall(Send(l, nb, id, d, p));
      continue;
    }
    for (PetscInt e = 0; e < dim; e++)
      far2 += PetscSqr((l->view.x[q * dim + e] - l->view.x[p * dim + e]) / l->core->grid.h[e]);
    if (far2 < MPM_BOUND_gap_near * MPM_BOUND_gap_near) continue;
    GetHalf(l, nb, p, &half);
    GetHalf(l, nb, q, &other);
    PetscCall(LookAtPair(l, nb, d, &half, other.x, other.known[d]));
  }
  if (lower) PetscCall(Send(l, nb, l->view.id[p], -1, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Looks at a particle of a table, which has no lattice: its neighbours are taken to be where its F takes them. */
static PetscErrorCode LookAtLone(Look *l, const MPMBody *b, PetscInt p, const MPMKind *kind)
{
  const MPMGrid *grid = &l->core->grid;
  const PetscInt dim  = grid->dim;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < dim && l->view.F; d++) {
    PetscReal far2 = 0, of[3];

    for (PetscInt e = 0; e < dim; e++)
      far2 += PetscSqr(l->view.F[(p * dim + e) * dim + d] * 2 * kind->l[d] * grid->h[d] / grid->h[e]);
    of[0] = of[2] = PetscSqrtReal(far2);
    of[1]         = 2 * kind->l[d];
    PetscCall(Judge(l, b, 16 * l->view.id[p] + d, l->view.x + p * dim, of, 1));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMPartingLook(MPMCore *core, const MPMScene *scene, const MPMNeighbours neighbours[], PetscInt *near,
                              MPMFound *wide, MPMFound *parted)
{
  const PetscInt fields = MPM_BIT(id) | MPM_BIT(x) | MPM_MATERIAL_BITS | MPM_BIT(kind);
  PetscMPIInt    size;
  PetscInt       b = 0;
  Look           l = {.core = core, .scene = scene, .neighbours = neighbours, .wide = {-1, -1, {0}, {0}}};

  PetscFunctionBeginUser;
  *parted = l.wide;
  PetscCall(MPMParticlesGetView(&core->particles, fields, &l.view));
  PetscCallMPI(MPI_Comm_size(core->exchange.data, &size));
  l.alone = size == 1;
  PetscCall(MakeRows(&l));
  for (PetscInt p = 0; p < l.view.n; p++) {
    const MPMKind *kind = MPMKindOf(core->params.kinds, &l.view, p);

    if (!MPMNeighboursMay(&core->params.materials[kind->material])) continue;
    b = MPMBodyOf(scene, l.view.id[p], b);
    if (neighbours[b].body)
      PetscCall(LookAt(&l, &neighbours[b], p));
    else
      PetscCall(LookAtLone(&l, &scene->bodies[b], p, kind));
  }
  PetscCall(LookElsewhere(&l));
  PetscCall(PetscFree(l.message));
  PetscCall(PetscFree(l.row));
  PetscCall(MPMParticlesRestoreView(&core->particles, fields, &l.view));
  PetscCallMPI(MPI_Allreduce(&l.near, near, 1, MPIU_INT, MPI_MAX, core->exchange.data));
  if (*near) PetscCall(MPMFoundAgree(&l.wide, core->exchange.data));
  if (*near) PetscCall(MPMPartingCrack(core, scene, neighbours, l.nlinks, l.link, parted));
  *wide = l.wide;
  PetscCall(PetscFree(l.link));
  PetscFunctionReturn(PETSC_SUCCESS);
}
