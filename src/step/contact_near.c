/* contact_near.c - which particles may be near matter of another copy of the grid's nodes, or near rigid bodies. Tiles that
   have particles of one copy next to a tile that has particles of the other one are looked at, and no others, of these
   cells near a cell with particles of the other: contact_tiles.c has found these tiles. */
#include "step/contact_search.h"

/* Finds the cells that have particles, of tiles beside those of other copies: a bit for each of a tile, which has 64 at most.
   Collective on exchange.data. */
static PetscErrorCode FindCells(Search *s)
{
  const MPMGrid  *grid = &s->core->grid;
  const MPMTiles *t    = &s->core->exchange.patch.tiles;
  const int       dim  = (int)grid->dim;
  const PetscInt  rows = 1 << t->bits * (dim - 1), edge = 1 << t->bits, *n = s->c->tiles.n, all = n[0] * n[1] * n[2];
  PetscMPIInt     count;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(grid->copies * all, &s->cells));
  for (const MPMContactTile *q = s->c->tiles.beside; q < s->c->tiles.beside + s->c->tiles.nbeside; q++) {
    uint64_t *cells = s->cells + q->copy * all + (q->at[2] * n[1] + q->at[1]) * n[0] + q->at[0];

    for (PetscInt in = 0; in < rows; in++) {
      const PetscInt *cell = TileRow(dim, t, q->tile, in);

      for (PetscInt i = 0; i < edge; i++)
        if (cell[i] < cell[i + 1]) *cells |= (uint64_t)1 << (in * edge + i);
    }
  }
  PetscCall(PetscMPIIntCast(grid->copies * all, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, s->cells, count, MPI_UINT64_T, MPI_BOR, s->core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Cells of a tile and of those around it that matter to them, on an axis. */
#define MOST_AROUND (4 + 2 * MPM_MAX_STENCIL)

/* What there is of another copy around a tile, in rows along x, whose cells are bits: cells so near to one with particles of
   it that both touch the same nodes or the next ones; and nodes that its particles touch. First come `reach` cells below
   the tile, on each axis of the grid. */
typedef struct {
  PetscInt reach[3];
  uint32_t near[MOST_AROUND][MOST_AROUND], touched[MOST_AROUND][MOST_AROUND];
} Around;

/* Adds to each of n rows, which are `step` apart, those up to `before` rows before it and `after` behind it. */
static void Spread(PetscInt n, PetscInt step, PetscInt before, PetscInt after, uint32_t rows[])
{
  uint32_t one[MOST_AROUND];

  for (PetscInt i = 0; i < n; i++) one[i] = rows[i * step];
  for (PetscInt q = 0; q < n; q++)
    for (PetscInt i = PetscMax(0, q - after); i <= PetscMin(n - 1, q + before) && one[q]; i++) rows[i * step] |= one[q];
}

/* Does so along all axes. */
static void SpreadAll(const PetscInt n[], const PetscInt before[], const PetscInt after[],
                      uint32_t rows[MOST_AROUND][MOST_AROUND])
{
  for (PetscInt k = 0; k < n[2]; k++)
    for (PetscInt j = 0; j < n[1]; j++) {
      const uint32_t one = rows[k][j];

      if (!one) continue;
      for (PetscInt q = 1; q <= before[0]; q++) rows[k][j] |= one << q;
      for (PetscInt q = 1; q <= after[0]; q++) rows[k][j] |= one >> q;
    }
  for (PetscInt k = 0; k < n[2]; k++) Spread(n[1], 1, before[1], after[1], rows[k]);
  for (PetscInt j = 0; j < n[1]; j++) Spread(n[2], MOST_AROUND, before[2], after[2], rows[0] + j);
}

/* Finds that for the tile at place `at` [3]; returns whether there is any. */
static PetscBool LookAround(const Search *s, PetscInt copy, const PetscInt at[], Around *r)
{
  const MPMGrid  *grid  = &s->core->grid;
  const PetscInt *tiles = s->c->tiles.n, bits = s->core->exchange.patch.tiles.bits, edge = 1 << bits;
  const uint64_t *cells   = s->cells + copy * tiles[0] * tiles[1] * tiles[2];
  const PetscInt  zero[3] = {0, 0, 0};
  PetscInt        n[3], tile[3][MOST_AROUND], bit[3][MOST_AROUND], reach[3], i[3];
  PetscBool       any = PETSC_FALSE;

  for (PetscInt d = 0, stride = 1; d < 3; stride *= tiles[d++]) {
    r->reach[d] = d < grid->dim ? MPMBasisNodes(s->core->basis) : 0;
    reach[d]    = d < grid->dim ? r->reach[d] - 1 : 0; /* of a stencil, beyond its first node */
    n[d]        = d < grid->dim ? edge + 2 * r->reach[d] : 1;
    for (PetscInt k = 0; k < n[d]; k++) {
      PetscInt cell = d < grid->dim ? at[d] * edge + k - r->reach[d] : 0;

      if (grid->periodic[d]) cell = (cell + grid->cells[d]) % grid->cells[d];
      tile[d][k] = cell < 0 || cell >= tiles[d] * edge ? -1 : (cell >> bits) * stride;
      bit[d][k]  = (cell & (edge - 1)) << bits * d;
    }
  }
  memset(r->near, 0, (size_t)n[2] * sizeof *r->near);
  for (i[2] = 0; i[2] < n[2]; i[2]++)
    for (i[1] = 0; i[1] < n[1]; i[1]++)
      for (i[0] = 0; i[0] < n[0] && tile[1][i[1]] >= 0 && tile[2][i[2]] >= 0; i[0]++) {
        const PetscInt one = tile[0][i[0]];
        const uint64_t row = one < 0 ? 0 : cells[one + tile[1][i[1]] + tile[2][i[2]]] >> (bit[1][i[1]] + bit[2][i[2]]);

        if (row >> bit[0][i[0]] & 1) r->near[i[2]][i[1]] |= (uint32_t)1 << i[0], any = PETSC_TRUE;
        while (!(row & (((uint64_t)1 << edge) - 1)) && i[0] + 1 < n[0] && tile[0][i[0] + 1] == one) i[0]++;
      }
  if (!any) return PETSC_FALSE;
  memcpy(r->touched, r->near, (size_t)n[2] * sizeof *r->near);
  SpreadAll(n, r->reach, r->reach, r->near);
  SpreadAll(n, reach, zero, r->touched);
  return PETSC_TRUE;
}

/* Returns whether cell `in` of the tile is near matter of the other copy, and sets the nodes of its stencil (bits) that this
   touches too. */
static PetscBool IsCellNear(const Search *s, const Around *r, PetscInt in, uint64_t *mixed)
{
  const PetscInt bits = s->core->exchange.patch.tiles.bits, nodes = MPMBasisNodes(s->core->basis);
  const int      dim   = (int)s->core->grid.dim;
  PetscInt       at[3] = {0};

  for (int d = 0; d < dim; d++) at[d] = r->reach[d] + (in >> bits * d & ((1 << bits) - 1));
  if (!(r->near[at[2]][at[1]] >> at[0] & 1)) return PETSC_FALSE;
  *mixed = 0;
  for (PetscInt k = 0; k < (dim > 2 ? nodes : 1); k++)
    for (PetscInt j = 0; j < (dim > 1 ? nodes : 1); j++)
      *mixed |= (uint64_t)(r->touched[at[2] + k][at[1] + j] >> at[0] & ((1u << nodes) - 1)) << (k * nodes + j) * nodes;
  return PETSC_TRUE;
}

/* Makes room for n more particles in the list. */
static PetscErrorCode MakeRoom(Search *s, PetscInt n)
{
  PetscFunctionBeginUser;
  if (s->nwanted + n <= s->most) PetscFunctionReturn(PETSC_SUCCESS);
  s->most = 2 * (s->nwanted + n);
  PetscCall(PetscRealloc((size_t)s->most * sizeof *s->wanted, &s->wanted));
  PetscCall(PetscRealloc((size_t)s->most * sizeof *s->mixed, &s->mixed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the nodes of the particles of a tile to a box. */
static void Extend(const MPMTiles *t, PetscInt tile, Box *box)
{
  const PetscInt at[3] = {tile % t->n[0], tile / t->n[0] % t->n[1], tile / (t->n[0] * t->n[1])};

  for (PetscInt d = 0; d < 3; d++) {
    const MPMTileBox *nodes = &t->box[d][at[d]];

    box->lo[d] = PetscMin(box->lo[d], nodes->at);
    box->hi[d] = PetscMax(box->hi[d], nodes->at + nodes->end);
  }
}

/* Returns whether a tile at place `at` [3] may have particles near a rigid body. */
static PetscBool IsRigidNear(const Search *s, const MPMRigid *rigid, const PetscInt at[])
{
  const MPMGrid *grid = &s->core->grid;
  const PetscInt edge = MPMTileEdge(s->core->basis);
  PetscReal      x[3] = {0}, n[3], half = 0, distance;

  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal wide = 0.5 * (PetscReal)(edge + MPMBasisNodes(s->core->basis)) * grid->h[d];

    x[d] = grid->lower[d] + (PetscReal)(at[d] * edge - grid->layers[d]) * grid->h[d] + wide;
    half += PetscSqr(wide);
  }
  half     = PetscSqrtReal(half);
  distance = MPMRigidDistance(rigid, grid->dim, x, n);
  return (rigid->tied ? distance : PetscAbsReal(distance)) < half + s->reach;
}

/* Returns whether particle p is near a rigid body: near its surface, of one that is tied also inside. */
static PetscBool IsParticleNear(const Search *s, const MPMRigid *rigid, PetscInt p)
{
  const PetscInt  dim = s->core->grid.dim;
  PetscReal       n[3];
  const PetscReal distance = MPMRigidDistance(rigid, dim, s->view.x + p * dim, n);

  return distance < s->reach && (rigid->tied || distance > -s->reach);
}

/* Lists those near a rigid body, as ListParticles does. */
static PetscErrorCode ListNearRigid(Search *s, PetscInt pair)
{
  const MPMTiles *t    = &s->core->exchange.patch.tiles;
  const int       dim  = (int)s->core->grid.dim;
  const PetscInt  rows = 1 << t->bits * (dim - 1), edge = 1 << t->bits;
  const MPMRigid *rigid = s->c->pair[pair].rigid;

  PetscFunctionBeginUser;
  for (PetscInt tile = MPMContactNextTile(t, -1); tile >= 0; tile = MPMContactNextTile(t, tile)) {
    const PetscInt before = s->nwanted;
    PetscInt       at[3];

    if (MPMContactTileCopy(s->core, &s->view, tile, at) != s->c->pair[pair].b || !IsRigidNear(s, rigid, at)) continue;
    for (PetscInt in = 0; in < rows; in++) {
      const PetscInt *cell = TileRow(dim, t, tile, in);

      PetscCall(MakeRoom(s, cell[edge] - cell[0]));
      for (PetscInt q = cell[0]; q < cell[edge]; q++)
        if (IsParticleNear(s, rigid, s->core->particles.order[q])) {
          s->mixed[s->nwanted]    = ~(uint64_t)0;
          s->wanted[s->nwanted++] = s->core->particles.order[q];
        }
    }
    if (s->nwanted > before) Extend(t, tile, &s->box[2 * pair + 1]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the particles here of one side (0: a, 1: b) of a pair that are near matter of the other one: from s->nwanted on. */
static PetscErrorCode ListParticles(Search *s, PetscInt pair, int side)
{
  const MPMTiles *t    = &s->core->exchange.patch.tiles;
  const int       dim  = (int)s->core->grid.dim;
  const PetscInt  rows = 1 << t->bits * (dim - 1), edge = 1 << t->bits;
  const PetscInt  own  = side ? s->c->pair[pair].b : s->c->pair[pair].a,
                 other = side ? s->c->pair[pair].a : s->c->pair[pair].b;
  Around around;

  PetscFunctionBeginUser;
  for (const MPMContactTile *here = s->c->tiles.beside; here < s->c->tiles.beside + s->c->tiles.nbeside; here++) {
    const PetscInt before = s->nwanted;

    if (here->copy != own || !LookAround(s, other, here->at, &around)) continue;
    for (PetscInt in = 0; in < rows; in++) {
      const PetscInt *cell = TileRow(dim, t, here->tile, in);

      for (PetscInt i = 0; i < edge; i++) {
        const PetscInt n = cell[i + 1] - cell[i];
        uint64_t       mixed;

        if (!n || !IsCellNear(s, &around, in * edge + i, &mixed)) continue;
        PetscCall(MakeRoom(s, n));
        PetscCall(PetscArraycpy(s->wanted + s->nwanted, s->core->particles.order + cell[i], n));
        for (PetscInt q = 0; q < n; q++) s->mixed[s->nwanted + q] = mixed;
        s->nwanted += n;
      }
    }
    if (s->nwanted > before) Extend(t, here->tile, &s->box[2 * pair + side]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists those of all pairs. */
static PetscErrorCode ListAll(Search *s)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * s->c->npairs + 1, &s->first));
  PetscCall(PetscMalloc1(2 * s->c->npairs, &s->box));
  for (PetscInt k = 0; k < 2 * s->c->npairs; k++) {
    s->first[k] = s->nwanted;
    s->box[k]   = (Box){{PETSC_MAX_INT, PETSC_MAX_INT, PETSC_MAX_INT}, {0}};
    if (s->c->pair[k / 2].rigid && k % 2) PetscCall(ListNearRigid(s, k / 2));
    if (!s->c->pair[k / 2].rigid && s->c->near) PetscCall(ListParticles(s, k / 2, k % 2));
  }
  s->first[2 * s->c->npairs] = s->nwanted;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Calls act for each particle of one side of a pair that is near matter of the other one; mixed: the nodes of its stencil, as
   bits in their sequence, that may have matter of the other side too. */
PetscErrorCode MPMContactForParticles(Search *s, PetscInt pair, int side, MPMContactAct act)
{
  PetscFunctionBeginUser;
  for (PetscInt k = s->first[2 * pair + side]; k < s->first[2 * pair + side + 1]; k++)
    PetscCall(act(s, pair, side, s->wanted[k], s->mixed[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MPMContactNear(Search *s)
{
  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < s->core->grid.dim; d++)
    s->reach = PetscMax(s->reach, (0.5 * MPMBasisNodes(s->core->basis) + 1) * s->core->grid.h[d]);
  if (s->c->near) PetscCall(FindCells(s));
  PetscCall(ListAll(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}
