/* contact_find.c - where bodies may meet in a step: the nodes that have matter of two copies of the grid's nodes, the
   normals there, how far the matter of both is apart, and the columns in which these nodes act (contact.c).

   Tiles that have particles of one copy next to a tile that has particles of the other one are looked at, and no others:
   so bodies that do not meet cost a loop over tiles. Everything that is added up over particles is a whole number, and all
   other things are minima, so they have the same bits in every sequence; every process knows all nodes of contact.

   The normal at a node is that of the plane that separates the particles of a and b best, by weighted least squares:
     sum_p phi_p (n . (x_p - x_i) + d - c_p)^2 + SMOOTH |n|^2 is least,  c_p = 1 for b and -1 for a. docs/method.md has the
   reasons. */
#include "kernels/cell.h"
#include "parallel/exchange.h"
#include "step/matter.h"
#include "step/step.h"

#define SMOOTH 1e-9 /* cells^2, times the sum of phi: it only matters where all particles lie on a line */
#define PUSH                                                                                                           \
  3e-4 /* of the depth to which single particles of what flows have crept into the other body, undone in a step: with 1e-4
                         water goes on to creep in, with 1e-3 blocks float a cell too high */
#define TIE     1e-9 /* cells: a particle in the middle between two columns lies in both */
#define AROUND  2    /* nodes around touching ones that are not light either */
#define TOUCHES 1.0  /* cells: matter that is nearer touches, or may do so in this step */
#define AHEAD                                                                                                          \
  0.75 /* cells: a block slides on a plane within 0.1 %; with 0.5 and 1 within 1 %, and ends sink in with more */
#define AGREE 8 /* power of how well the surface of one side agrees: 1 where it is flat, 0.7 at a corner */
#define INCLINES                                                                                                       \
  0.25           /* squared component of a normal, below which a node is in no column along that axis: 60 degrees */
#define BAND 0.6 /* cells: how much further than a stencil's reach the nodes of columns are from a rigid body */
#define UNIT ldexp(1, -50) /* of sums of phi, and of the weights in sides of cells */
#define MOST ldexp(1, 54)  /* of what a particle adds to a weight, in units */

/* The sums at a node of a pair from which its normal comes, in units: of phi times 1, xi, xi xi^T (xx xy xz yy yz zz), c, c
   xi; xi = (x_p - x_i)/h. */
#define NSUMS 14
typedef struct {
  PetscInt   pair, ijk[3];
  PetscInt64 sum[NSUMS];
} Fit;

/* What the particles at the surface of one side tell a node of the normal, in units: sums of phi times the unit normal of the
   surface, and of phi. */
typedef PetscInt64 Faces[2][4];

/* What a search has: tiles of the grid on each axis; bits of those with particles, copy after copy; the records of nodes so
   far, and for each node of the patch its record, from 1 on. */
typedef struct {
  MPMCore     *core;
  MPMContacts *c;
  MPMView      view;
  PetscReal    reach;                  /* m: what is nearer to a rigid body is looked at */
  PetscInt     n[3], words;            /* words: of 64 bits for a copy */
  uint64_t    *tiles;                  /* [copies][words] */
  PetscInt     box[MPM_MAX_COPIES][6]; /* of the tiles of each copy: minus the lowest on each axis, the highest */
  uint64_t    *cells;                  /* [copies][tiles] bits of their cells that have particles */
  PetscInt    *wanted, *first, nwanted, most; /* the particles of each side of each pair that are near the other side */
  Fit         *fit;
  PetscInt     nfits, room, *map, *key, *at; /* key, at: of nodes, sorted */
  PetscReal   *normal;                       /* [nfits][3] */
  Faces       *faces;                        /* [nfits] */
  PetscReal    full[MPM_MAX_COPIES];         /* particles of a cell that is full, of each copy */
} Search;

/* --- Tiles -------------------------------------------------------------------------------------------------------- */

/* Sets at [3] to the place of an own tile among those of a copy, and returns the copy. */
static PetscInt TilePlace(const Search *s, PetscInt tile, PetscInt at[])
{
  const MPMPatch *patch = &s->core->exchange.patch;
  const MPMGrid  *grid  = patch->grid;
  const MPMTiles *t     = &patch->tiles;
  const PetscInt  edge  = MPMTileEdge(patch->basis),
                 own[3] = {tile % t->n[0], tile / t->n[0] % t->n[1], tile / (t->n[0] * t->n[1])};
  PetscInt copy         = 0;

  for (PetscInt d = 0; d < 3; d++) {
    at[d] = (patch->own_lo[d] + grid->layers[d]) / edge + own[d] - t->below[d];
    if (d != grid->stack) continue;
    copy = at[d] / s->n[d];
    at[d] %= s->n[d];
  }
  return copy;
}

static PetscBool HasTile(const Search *s, PetscInt copy, const PetscInt at[])
{
  const PetscInt bit = (at[2] * s->n[1] + at[1]) * s->n[0] + at[0];

  return s->tiles[copy * s->words + bit / 64] >> bit % 64 & 1 ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns whether a copy has particles in a tile or in one beside it. */
static PetscBool IsNear(const Search *s, PetscInt copy, const PetscInt at[])
{
  const MPMGrid *grid = &s->core->grid;

  for (PetscInt q = 0; q < 27; q++) {
    const PetscInt by[3] = {q % 3 - 1, q / 3 % 3 - 1, q / 9 - 1};
    PetscInt       to[3];
    PetscBool      inside = PETSC_TRUE;

    for (PetscInt d = 0; d < 3; d++) {
      to[d] = at[d] + by[d];
      if (grid->periodic[d]) to[d] = (to[d] + s->n[d]) % s->n[d];
      if (to[d] < 0 || to[d] >= s->n[d]) inside = PETSC_FALSE;
    }
    if (inside && HasTile(s, copy, to)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns the next one of the patch's own tiles that has particles after `tile`, or the first one after -1; or -1. */
static PetscInt NextTile(const MPMTiles *t, PetscInt tile)
{
  PetscInt row = tile < 0 ? 0 : tile / t->n[0], i = tile < 0 ? t->below[0] : tile % t->n[0] + 1;

  for (; row < t->n[1] * t->n[2]; row++, i = t->below[0]) {
    if (row % t->n[1] < t->below[1] || row / t->n[1] < t->below[2]) continue;
    for (i = PetscMax(i, t->used[row][0]); i < t->used[row][1]; i++)
      if (t->slot[row * t->n[0] + i] != MPM_TILE_EMPTY) return row * t->n[0] + i;
  }
  return -1;
}

/* Returns whether the boxes around the tiles of two copies, or tiles beside them, have any in common. */
static PetscBool BoxesMeet(const Search *s, const MPMPair *pair)
{
  if (pair->a < 0) return PETSC_FALSE;
  for (PetscInt d = 0; d < 3; d++) {
    const PetscInt *a = s->box[pair->a], *b = s->box[pair->b];

    if (a[3 + d] < 0 || b[3 + d] < 0) return PETSC_FALSE; /* no particles */
    if (!s->core->grid.periodic[d] && (a[3 + d] + 1 < -b[d] || b[3 + d] + 1 < -a[d])) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Finds the tiles that have particles, of all processes, and sets *any to whether bodies of a pair are near each other
   somewhere. Collective on exchange.data. */
static PetscErrorCode FindTiles(Search *s, PetscBool *any)
{
  const MPMGrid  *grid = &s->core->grid;
  const MPMTiles *t    = &s->core->exchange.patch.tiles;
  const PetscInt  edge = MPMTileEdge(s->core->basis);
  PetscInt        all  = 1, at[3];
  PetscBool       near = PETSC_FALSE;
  PetscMPIInt     count;

  PetscFunctionBeginUser;
  for (PetscInt d = 0; d < 3; d++) {
    s->n[d] = ((d == grid->stack && grid->copies > 1 ? grid->stride : grid->nodes[d]) + edge - 1) / edge;
    all *= s->n[d];
  }
  s->words = (all + 63) / 64;
  *any     = PETSC_FALSE;
  if (grid->copies < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(grid->copies * s->words, &s->tiles));
  for (PetscInt c = 0; c < grid->copies; c++)
    for (PetscInt d = 0; d < 6; d++) s->box[c][d] = PETSC_MIN_INT;
  for (PetscInt tile = NextTile(t, -1); tile >= 0; tile = NextTile(t, tile)) {
    PetscInt copy, bit;

    copy = TilePlace(s, tile, at);
    bit  = (at[2] * s->n[1] + at[1]) * s->n[0] + at[0];
    s->tiles[copy * s->words + bit / 64] |= (uint64_t)1 << bit % 64;
    for (PetscInt d = 0; d < 3; d++) {
      s->box[copy][d]     = PetscMax(s->box[copy][d], -at[d]);
      s->box[copy][3 + d] = PetscMax(s->box[copy][3 + d], at[d]);
    }
  }
  PetscCall(PetscMPIIntCast(6 * grid->copies, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, s->box, count, MPIU_INT, MPI_MAX, s->core->exchange.data));
  for (PetscInt k = 0; k < s->c->npairs; k++) near = BoxesMeet(s, &s->c->pair[k]) ? PETSC_TRUE : near;
  if (!near) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMPIIntCast(grid->copies * s->words, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, s->tiles, count, MPI_UINT64_T, MPI_BOR, s->core->exchange.data));
  for (PetscInt k = 0; k < s->c->npairs && !*any; k++)
    for (PetscInt bit = 0; bit < all && !*any && BoxesMeet(s, &s->c->pair[k]); bit++) {
      if (!s->tiles[s->c->pair[k].a * s->words + bit / 64]) {
        bit |= 63;
        continue;
      }
      at[0] = bit % s->n[0];
      at[1] = bit / s->n[0] % s->n[1];
      at[2] = bit / (s->n[0] * s->n[1]);
      if (HasTile(s, s->c->pair[k].a, at) && IsNear(s, s->c->pair[k].b, at)) *any = PETSC_TRUE;
    }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the cells that have particles: a bit for each of a tile, which has 64 at most. Collective on exchange.data. */
static PetscErrorCode FindCells(Search *s)
{
  const MPMGrid  *grid = &s->core->grid;
  const MPMTiles *t    = &s->core->exchange.patch.tiles;
  const int       dim  = (int)grid->dim;
  const PetscInt  rows = 1 << t->bits * (dim - 1), edge = 1 << t->bits, all = s->n[0] * s->n[1] * s->n[2];
  PetscMPIInt     count;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(grid->copies * all, &s->cells));
  for (PetscInt tile = NextTile(t, -1); tile >= 0; tile = NextTile(t, tile)) {
    PetscInt  at[3], copy;
    uint64_t *cells;

    copy  = TilePlace(s, tile, at);
    cells = s->cells + copy * all + (at[2] * s->n[1] + at[1]) * s->n[0] + at[0];
    for (PetscInt in = 0; in < rows; in++) {
      const PetscInt *cell = t->start + MPMTileRowCell(dim, t, tile / t->n[0], in) + tile % t->n[0] * edge;

      for (PetscInt i = 0; i < edge; i++)
        if (cell[i] < cell[i + 1]) *cells |= (uint64_t)1 << (in * edge + i);
    }
  }
  PetscCall(PetscMPIIntCast(grid->copies * all, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, s->cells, count, MPI_UINT64_T, MPI_BOR, s->core->exchange.data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a copy has particles in a cell so near to one of a tile at place `at` [3], cell number `in` of it, that
   both touch the same nodes or the next ones. */
static PetscBool IsCellNear(const Search *s, PetscInt copy, const PetscInt at[], PetscInt in)
{
  const MPMGrid *grid = &s->core->grid;
  const PetscInt bits = s->core->exchange.patch.tiles.bits, edge = 1 << bits, reach = MPMBasisNodes(s->core->basis);
  PetscInt       lo[3] = {0}, hi[3] = {0}, to[3];

  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscInt cell = at[d] * edge + (in >> bits * d & (edge - 1));

    lo[d] = cell - reach;
    hi[d] = cell + reach;
  }
  for (to[2] = lo[2]; to[2] <= hi[2]; to[2]++)
    for (to[1] = lo[1]; to[1] <= hi[1]; to[1]++)
      for (to[0] = lo[0]; to[0] <= hi[0]; to[0]++) {
        PetscInt  tile = 0, bit = 0;
        PetscBool inside = PETSC_TRUE;

        for (PetscInt d = 2; d >= 0; d--) {
          PetscInt cell = to[d];

          if (grid->periodic[d]) cell = (cell + grid->cells[d]) % grid->cells[d];
          if (cell < 0 || cell >= s->n[d] * edge) inside = PETSC_FALSE;
          tile = tile * s->n[d] + (cell >> bits);
          if (d < grid->dim) bit = (bit << bits) + (cell & (edge - 1));
        }
        if (inside && s->cells[copy * s->n[0] * s->n[1] * s->n[2] + tile] >> bit & 1) return PETSC_TRUE;
      }
  return PETSC_FALSE;
}

/* Makes room for n more particles in the list. */
static PetscErrorCode MakeRoom(Search *s, PetscInt n)
{
  PetscFunctionBeginUser;
  if (s->nwanted + n <= s->most) PetscFunctionReturn(PETSC_SUCCESS);
  s->most = 2 * (s->nwanted + n);
  PetscCall(PetscRealloc((size_t)s->most * sizeof *s->wanted, &s->wanted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns whether a tile at place `at` [3] may have particles near a rigid body. */
static PetscBool IsRigidNear(const Search *s, PetscInt rigid, const PetscInt at[])
{
  const MPMGrid *grid = &s->core->grid;
  const PetscInt edge = MPMTileEdge(s->core->basis);
  PetscReal      x[3] = {0}, n[3], half = 0;

  for (PetscInt d = 0; d < grid->dim; d++) {
    const PetscReal wide = 0.5 * (PetscReal)(edge + MPMBasisNodes(s->core->basis)) * grid->h[d];

    x[d] = grid->lower[d] + (PetscReal)(at[d] * edge - grid->layers[d]) * grid->h[d] + wide;
    half += PetscSqr(wide);
  }
  half = PetscSqrtReal(half);
  return PetscAbsReal(MPMRigidDistance(&s->core->rigids.body[rigid], grid->dim, x, n)) < half + s->reach ? PETSC_TRUE
                                                                                                         : PETSC_FALSE;
}

/* Returns whether particle p is near a rigid body. */
static PetscBool IsParticleNear(const Search *s, PetscInt rigid, PetscInt p)
{
  const PetscInt  dim = s->core->grid.dim;
  PetscReal       n[3];
  const PetscReal distance = MPMRigidDistance(&s->core->rigids.body[rigid], dim, s->view.x + p * dim, n);

  return distance < s->reach && distance > -s->reach ? PETSC_TRUE : PETSC_FALSE;
}

/* Lists those near a rigid body, as ListParticles does. */
static PetscErrorCode ListNearRigid(Search *s, PetscInt pair)
{
  const MPMTiles *t    = &s->core->exchange.patch.tiles;
  const int       dim  = (int)s->core->grid.dim;
  const PetscInt  rows = 1 << t->bits * (dim - 1), edge = 1 << t->bits, rigid = -1 - s->c->pair[pair].a;

  PetscFunctionBeginUser;
  for (PetscInt tile = NextTile(t, -1); tile >= 0; tile = NextTile(t, tile)) {
    PetscInt at[3];

    if (TilePlace(s, tile, at) != s->c->pair[pair].b || !IsRigidNear(s, rigid, at)) continue;
    for (PetscInt in = 0; in < rows; in++) {
      const PetscInt *cell = t->start + MPMTileRowCell(dim, t, tile / t->n[0], in) + tile % t->n[0] * edge;

      PetscCall(MakeRoom(s, cell[edge] - cell[0]));
      for (PetscInt q = cell[0]; q < cell[edge]; q++)
        if (IsParticleNear(s, rigid, s->core->particles.order[q]))
          s->wanted[s->nwanted++] = s->core->particles.order[q];
    }
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

  PetscFunctionBeginUser;
  for (PetscInt tile = NextTile(t, -1); tile >= 0; tile = NextTile(t, tile)) {
    PetscInt at[3];

    if (TilePlace(s, tile, at) != own || !IsNear(s, other, at)) continue;
    for (PetscInt in = 0; in < rows; in++) {
      const PetscInt *cell = t->start + MPMTileRowCell(dim, t, tile / t->n[0], in) + tile % t->n[0] * edge;

      for (PetscInt i = 0; i < edge; i++) {
        const PetscInt n = cell[i + 1] - cell[i];

        if (!n || !IsCellNear(s, other, at, in * edge + i)) continue;
        PetscCall(MakeRoom(s, n));
        PetscCall(PetscArraycpy(s->wanted + s->nwanted, s->core->particles.order + cell[i], n));
        s->nwanted += n;
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists those of all pairs. */
static PetscErrorCode ListAll(Search *s, PetscBool any)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(2 * s->c->npairs + 1, &s->first));
  for (PetscInt k = 0; k < 2 * s->c->npairs; k++) {
    s->first[k] = s->nwanted;
    if (s->c->pair[k / 2].a < 0 && k % 2) PetscCall(ListNearRigid(s, k / 2));
    if (s->c->pair[k / 2].a >= 0 && any) PetscCall(ListParticles(s, k / 2, k % 2));
  }
  s->first[2 * s->c->npairs] = s->nwanted;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Calls act for each particle of one side of a pair that is near matter of the other one. */
static PetscErrorCode ForParticles(Search *s, PetscInt pair, int side,
                                   PetscErrorCode (*act)(Search *, PetscInt, int, PetscInt))
{
  PetscFunctionBeginUser;
  for (PetscInt k = s->first[2 * pair + side]; k < s->first[2 * pair + side + 1]; k++)
    PetscCall(act(s, pair, side, s->wanted[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Stencils of single particles --------------------------------------------------------------------------------- */

typedef struct {
  PetscInt  base[3], n[3];
  PetscReal xi[3], w[3][MPM_MAX_STENCIL], g[3][MPM_MAX_STENCIL]; /* g: 1/cells */
} Stencil;

/* Sets the stencil of a place x [dim], m, by the domain of particle p. */
static void SetStencilAt(const Search *s, PetscInt p, const PetscReal x[], Stencil *to)
{
  const MPMCore   *core = s->core;
  const MPMGrid   *grid = &core->grid;
  const int        dim  = (int)grid->dim;
  const PetscReal *l    = MPMHalfWidths(dim, core->params.kinds, &s->view, p);

  *to = (Stencil){.n = {1, 1, 1}};
  MPMCoordinates(dim, core->basis, grid, x, l, to->xi, to->base);
  for (int d = 0; d < dim; d++) {
    to->n[d] = MPMBasisNodes(core->basis);
    MPMBasisWeights(core->basis, to->xi[d], l[d], to->base[d], grid->cells[d], grid->wall_basis[d], to->w[d], to->g[d]);
  }
}

static void SetStencil(const Search *s, PetscInt p, Stencil *to)
{
  SetStencilAt(s, p, s->view.x + p * s->core->grid.dim, to);
}

/* Sets ijk [3] to node at [3] of a stencil, as the grid numbers it across periodic faces. */
static void SetIjk(const MPMGrid *grid, const Stencil *t, const PetscInt at[], PetscInt ijk[])
{
  for (PetscInt d = 0; d < 3; d++) {
    ijk[d] = d < grid->dim ? t->base[d] + at[d] : 0;
    if (grid->periodic[d]) ijk[d] = (ijk[d] + grid->cells[d]) % grid->cells[d];
  }
}

#define FOR_STENCIL(t, at)                                                                                             \
  for (at[2] = 0; at[2] < (t)->n[2]; at[2]++)                                                                          \
    for (at[1] = 0; at[1] < (t)->n[1]; at[1]++)                                                                        \
      for (at[0] = 0; at[0] < (t)->n[0]; at[0]++)

/* A number for each node of a pair, or of a copy. */
static PetscInt KeyOf(const MPMGrid *grid, PetscInt of, const PetscInt ijk[])
{
  PetscInt key = of;

  for (PetscInt d = grid->dim - 1; d >= 0; d--)
    key = key * (grid->cells[d] + 2 * MPM_GRID_APART) + ijk[d] + MPM_GRID_APART;
  return key;
}

/* --- Normals ------------------------------------------------------------------------------------------------------ */

/* Adds a particle to the sums of its nodes. */
static PetscErrorCode AddToFits(Search *s, PetscInt pair, int side, PetscInt p)
{
  const MPMPatch *patch = &s->core->exchange.patch;
  const MPMGrid  *grid  = patch->grid;
  const PetscInt  copy  = side ? s->c->pair[pair].b : s->c->pair[pair].a;
  PetscInt        at[3];
  Stencil         t;

  PetscFunctionBeginUser;
  SetStencil(s, p, &t);
  FOR_STENCIL(&t, at)
  {
    PetscReal units = 1 / UNIT, xi[3] = {0};
    PetscInt  i = 0, k = 4;
    Fit      *fit;

    for (PetscInt d = 2; d >= 0; d--)
      i = i * patch->n[d] + (d < grid->dim ? t.base[d] + at[d] + MPMGridFirst(grid, d, copy) - patch->lo[d] : 0);
    for (PetscInt d = 0; d < grid->dim; d++) {
      units *= t.w[d][at[d]];
      xi[d] = t.xi[d] - (PetscReal)(t.base[d] + at[d]);
    }
    if (!(units > 0)) continue;
    if (!s->map[i]) {
      if (s->nfits == s->room) {
        s->room = 2 * s->room + 256;
        PetscCall(PetscRealloc((size_t)s->room * sizeof *s->fit, &s->fit));
      }
      fit = &s->fit[s->nfits++];
      PetscCall(PetscMemzero(fit, sizeof *fit));
      fit->pair = pair;
      SetIjk(grid, &t, at, fit->ijk);
      s->map[i] = s->nfits;
    }
    fit = &s->fit[s->map[i] - 1];
    fit->sum[0] += (PetscInt64)units;
    fit->sum[10] += side ? (PetscInt64)units : -(PetscInt64)units;
    for (PetscInt d = 0; d < 3; d++) {
      const PetscInt64 one = (PetscInt64)(units * xi[d]);

      fit->sum[1 + d] += one;
      fit->sum[11 + d] += side ? one : -one;
      for (PetscInt e = d; e < 3; e++) fit->sum[k++] += (PetscInt64)(units * xi[d] * xi[e]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static int InOrderOfFits(const void *a, const void *b)
{
  const Fit *p = a, *q = b;

  if (p->pair != q->pair) return p->pair < q->pair ? -1 : 1;
  for (PetscInt d = 2; d >= 0; d--)
    if (p->ijk[d] != q->ijk[d]) return p->ijk[d] < q->ijk[d] ? -1 : 1;
  return 0;
}

/* Collects the sums of all processes, and merges those of a node. Collective on exchange.data. */
static PetscErrorCode CollectFits(Search *s)
{
  PetscMPIInt size, n, *counts, *from;
  PetscInt    all = 0, kept = 0;
  Fit        *mine;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(s->core->exchange.data, &size));
  if (size > 1) {
    PetscCall(PetscMPIIntCast(s->nfits * (PetscInt)sizeof *mine, &n));
    PetscCall(PetscMalloc2(size, &counts, size, &from));
    PetscCallMPI(MPI_Allgather(&n, 1, MPI_INT, counts, 1, MPI_INT, s->core->exchange.data));
    for (PetscMPIInt k = 0; k < size; k++) {
      PetscCall(PetscMPIIntCast(all, &from[k]));
      all += counts[k];
    }
    mine     = s->fit;
    s->nfits = s->room = all / (PetscInt)sizeof *mine;
    PetscCall(PetscMalloc1(s->room, &s->fit));
    PetscCallMPI(MPI_Allgatherv(mine, n, MPI_BYTE, s->fit, counts, from, MPI_BYTE, s->core->exchange.data));
    PetscCall(PetscFree(mine));
    PetscCall(PetscFree2(counts, from));
  }
  qsort(s->fit, (size_t)s->nfits, sizeof *s->fit, InOrderOfFits);
  for (PetscInt k = 0; k < s->nfits; k++) {
    Fit *to = kept ? &s->fit[kept - 1] : NULL;

    if (to && !InOrderOfFits(to, &s->fit[k]))
      for (PetscInt q = 0; q < NSUMS; q++) to->sum[q] += s->fit[k].sum[q];
    else
      s->fit[kept++] = s->fit[k];
  }
  s->nfits = kept;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves A y = b for n <= 4 unknowns by elimination with pivots; returns false if A has none. */
static PetscBool Solve(int n, PetscReal A[4][4], PetscReal b[4], PetscReal y[4])
{
  for (int k = 0; k < n; k++) {
    int best = k;

    for (int i = k + 1; i < n; i++)
      if (PetscAbsReal(A[i][k]) > PetscAbsReal(A[best][k])) best = i;
    if (!(PetscAbsReal(A[best][k]) > 0)) return PETSC_FALSE;
    for (int j = 0; j < n && best != k; j++) {
      const PetscReal was = A[k][j];

      A[k][j]    = A[best][j];
      A[best][j] = was;
    }
    if (best != k) {
      const PetscReal was = b[k];

      b[k]    = b[best];
      b[best] = was;
    }
    for (int i = k + 1; i < n; i++) {
      const PetscReal by = A[i][k] / A[k][k];

      for (int j = k; j < n; j++) A[i][j] -= by * A[k][j];
      b[i] -= by * b[k];
    }
  }
  for (int k = n - 1; k >= 0; k--) {
    y[k] = b[k];
    for (int j = k + 1; j < n; j++) y[k] -= A[k][j] * y[j];
    y[k] /= A[k][k];
  }
  return PETSC_TRUE;
}

/* Sets n [3] to the normal at a node by its sums; returns false if only one side has matter there, or it has no normal. */
static PetscBool SetFitted(const MPMGrid *grid, const MPMPair *pair, const Fit *fit, PetscReal n[])
{
  static const int row[3][3] = {{4, 5, 6}, {5, 7, 8}, {6, 8, 9}};
  const int        dim       = (int)grid->dim;
  const PetscReal  all       = (PetscReal)fit->sum[0];
  PetscReal        A[4][4], b[4], y[4] = {0}, size = 0;

  if (fit->sum[10] >= fit->sum[0] || fit->sum[10] <= -fit->sum[0]) return PETSC_FALSE;
  for (int d = 0; d < dim; d++) {
    for (int e = 0; e < dim; e++) A[d][e] = (PetscReal)fit->sum[row[d][e]] / all;
    A[d][d] += SMOOTH;
    A[d][dim] = A[dim][d] = (PetscReal)fit->sum[1 + d] / all;
    b[d]                  = (PetscReal)fit->sum[11 + d] / all;
  }
  A[dim][dim] = 1;
  b[dim]      = (PetscReal)fit->sum[10] / all;
  if (!Solve(dim + 1, A, b, y)) return PETSC_FALSE;
  for (int d = 0; d < 3; d++) n[d] = d < dim && (pair->axis < 0 || pair->axis == d) ? y[d] / grid->h[d] : 0;
  for (int d = 0; d < dim; d++) size += n[d] * n[d];
  if (!(size > 0)) return PETSC_FALSE;
  for (int d = 0; d < dim; d++) n[d] /= PetscSqrtReal(size);
  return PETSC_TRUE;
}

/* Sets n [3] of a node from the surfaces that face each other there, as far as there are any: the mean of both sides by how
   much they have, and by how well they agree: at a corner of one body the surface of the other one counts. */
static void UseFaces(PetscInt dim, Faces of, PetscReal n[])
{
  PetscReal sum[3] = {0}, length = 0;

  for (int side = 0; side < 2; side++) {
    const PetscReal all  = (PetscReal)of[side][3];
    PetscReal       size = 0, weight;

    for (PetscInt d = 0; d < dim; d++) size += PetscSqr((PetscReal)of[side][d]);
    size = PetscSqrtReal(size);
    if (!(size > 0)) continue;
    weight = all * PetscPowReal(size / all, AGREE);
    for (PetscInt d = 0; d < dim; d++) sum[d] += (side ? -1 : 1) * weight * (PetscReal)of[side][d] / size;
  }
  for (PetscInt d = 0; d < dim; d++) length += sum[d] * sum[d];
  if (!(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > 0)) return; /* only one side has matter there */
  for (PetscInt d = 0; d < dim && length > 0; d++) n[d] = sum[d] / PetscSqrtReal(length);
}

/* Returns how much matter of the other side is at a place `by` cells ahead of the surface of particle p, along the unit normal
   n [dim] of that: the sums of its particles' phi interpolated to there, by those of full cells. */
static PetscReal Filled(const Search *s, PetscInt pair, int side, PetscInt p, const PetscReal n[], PetscReal rim,
                        PetscReal by)
{
  const MPMGrid *grid = &s->core->grid;
  PetscReal      x[3] = {0}, h = 0, found = 0;
  PetscInt       at[3];
  Stencil        t;

  for (PetscInt d = 0; d < grid->dim; d++) h += PetscSqr(n[d] * grid->h[d]);
  for (PetscInt d = 0; d < grid->dim; d++) {
    x[d] = s->view.x[p * grid->dim + d] + (rim + by * PetscSqrtReal(h)) * n[d];
    if (grid->periodic[d])
      x[d] -= PetscFloorReal((x[d] - grid->lower[d]) / (grid->upper[d] - grid->lower[d])) *
              (grid->upper[d] - grid->lower[d]);
    if (!(x[d] >= grid->lower[d] && x[d] < grid->upper[d])) return 0;
  }
  SetStencilAt(s, p, x, &t);
  FOR_STENCIL(&t, at)
  {
    PetscReal phi = 1;
    PetscInt  ijk[3], k;

    SetIjk(grid, &t, at, ijk);
    (void)PetscFindInt(KeyOf(grid, pair, ijk), s->nfits, s->key, &k);
    for (PetscInt d = 0; d < grid->dim; d++) phi *= t.w[d][at[d]];
    if (k >= 0) found += phi * 0.5 * (PetscReal)(s->fit[s->at[k]].sum[0] + (side ? -1 : 1) * s->fit[s->at[k]].sum[10]);
  }
  return found * UNIT / s->full[side ? s->c->pair[pair].a : s->c->pair[pair].b];
}

/* Lets a particle at the surface of a body that keeps its shape tell the nodes of its stencil the normal of that, as far as
   there is matter of the other side ahead. */
static PetscErrorCode TellFaces(Search *s, PetscInt pair, int side, PetscInt p)
{
  const MPMCore   *core = s->core;
  const int        dim  = (int)core->grid.dim;
  const PetscReal *rim  = s->view.rim + p * dim;
  PetscReal        F[9], cofactor[9], turned[3] = {0}, size = 0, far = 0, ahead;
  PetscInt         at[3];
  Stencil          t;

  PetscFunctionBeginUser;
  if (!MPMMaterialKeepsShape(&core->params.materials[MPMKindOf(core->params.kinds, &s->view, p)->material]))
    PetscFunctionReturn(PETSC_SUCCESS);
  (void)MPMMatterDeformation(core, &s->view, p, F);
  MPMCofactor(dim, F, cofactor);
  for (int d = 0; d < dim; d++) {
    for (int e = 0; e < dim; e++) turned[d] += cofactor[d * dim + e] * rim[e];
    size += turned[d] * turned[d];
    far += rim[d] * rim[d];
  }
  if (!(size > 0)) PetscFunctionReturn(PETSC_SUCCESS);
  for (int d = 0; d < dim; d++) turned[d] /= PetscSqrtReal(size);
  far   = MPMDet(dim, F) * far / PetscSqrtReal(size);
  ahead = Filled(s, pair, side, p, turned, far, AHEAD);
  if (ahead > 0) ahead = PetscMax(0, ahead - Filled(s, pair, side, p, turned, far, -AHEAD));
  for (int k = 0; k < 3; k++) ahead *= ahead; /* so that of the surfaces at a corner the one that faces matter counts */
  SetStencil(s, p, &t);
  FOR_STENCIL(&t, at)
  {
    PetscReal   units = ahead / UNIT;
    PetscInt    ijk[3], k;
    PetscInt64 *to;

    SetIjk(&core->grid, &t, at, ijk);
    PetscCall(PetscFindInt(KeyOf(&core->grid, pair, ijk), s->nfits, s->key, &k));
    if (k < 0) continue;
    for (int d = 0; d < dim; d++) units *= t.w[d][at[d]];
    if (!(units > 0)) continue;
    to = s->faces[s->at[k]][side];
    for (int d = 0; d < dim; d++) to[d] += (PetscInt64)(units * turned[d]);
    to[3] += (PetscInt64)units;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does so, or sets the normal of a rigid body at a node that is near its surface. */
static PetscBool SetNormal(const MPMCore *core, const MPMPair *pair, const Fit *fit, PetscReal n[])
{
  const MPMGrid *grid = &core->grid;
  PetscReal      x[3] = {0}, distance;
  PetscInt       axis = 0;

  if (pair->a >= 0) return SetFitted(grid, pair, fit, n);
  for (PetscInt d = 0; d < grid->dim; d++) x[d] = grid->lower[d] + (PetscReal)fit->ijk[d] * grid->h[d];
  distance = MPMRigidDistance(&core->rigids.body[-1 - pair->a], grid->dim, x, n);
  for (PetscInt d = grid->dim; d < 3; d++) n[d] = 0;
  for (PetscInt d = 1; d < grid->dim; d++)
    if (PetscAbsReal(n[d]) > PetscAbsReal(n[axis])) axis = d;
  return PetscAbsReal(distance) < (0.5 * MPMBasisNodes(core->basis) + BAND) * grid->h[axis] ? PETSC_TRUE : PETSC_FALSE;
}

/* Sets key and at [n] to the numbers of n nodes and their places, sorted by number. */
static PetscErrorCode SetKeys(Search *s, PetscInt n, const void *first, size_t bytes, size_t pair, size_t ijk)
{
  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(n + 1) * sizeof *s->key, &s->key));
  PetscCall(PetscRealloc((size_t)(n + 1) * sizeof *s->at, &s->at));
  for (PetscInt k = 0; k < n; k++) {
    const char *row = (const char *)first + (size_t)k * bytes;

    s->key[k] = KeyOf(&s->core->grid, *(const PetscInt *)(row + pair), (const PetscInt *)(row + ijk));
    s->at[k]  = k;
  }
  PetscCall(PetscSortIntWithArray(n, s->key, s->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the normals at the nodes of the sums, [nfits][3]; they are 0 where there is none. Collective on exchange.data. */
static PetscErrorCode FindNormals(Search *s)
{
  PetscMPIInt count;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(3 * s->nfits + 1, &s->normal));
  PetscCall(PetscCalloc1(s->nfits + 1, &s->faces));
  for (PetscInt k = 0; k < s->nfits; k++)
    if (!SetNormal(s->core, &s->c->pair[s->fit[k].pair], &s->fit[k], s->normal + 3 * k))
      for (PetscInt d = 0; d < 3; d++) s->normal[3 * k + d] = 0;
  PetscCall(SetKeys(s, s->nfits, s->fit, sizeof *s->fit, offsetof(Fit, pair), offsetof(Fit, ijk)));
  for (PetscInt pair = 0; pair < s->c->npairs; pair++)
    for (int side = 0; side < 2 && s->c->pair[pair].axis < 0 && s->c->pair[pair].a >= 0; side++)
      PetscCall(ForParticles(s, pair, side, TellFaces));
  PetscCall(PetscMPIIntCast(8 * s->nfits, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, s->faces, count, MPIU_INT64, MPI_SUM, s->core->exchange.data));
  for (PetscInt k = 0; k < s->nfits; k++) UseFaces(s->core->grid.dim, s->faces[k], s->normal + 3 * k);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Nodes, weights and gaps -------------------------------------------------------------------------------------- */

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
    for (int side = s->c->pair[q->pair].a < 0; side < 2;
         side++) { /* distances from rigid bodies are from their surface */
      q->wide[side] = PETSC_INFINITY;
      for (PetscInt d = 0; d < 3; d++) q->near[side][d] = PETSC_INFINITY;
    }
    for (PetscInt d = 0; d < 4; d++) q->room[d] = PETSC_INFINITY;
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

/* Makes the sites: the nodes of contact of several pairs share those of a copy. */
static PetscErrorCode MakeSites(Search *s)
{
  MPMContacts *c = s->c;
  PetscInt    *key, *at, n = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(2 * c->nnodes, &key, 2 * c->nnodes, &at));
  for (PetscInt k = 0; k < c->nnodes; k++)
    for (int side = 0; side < 2; side++) {
      const MPMPair *pair = &c->pair[c->node[k].pair];

      c->node[k].site[side] = -1;
      if (!side && pair->a < 0) continue;
      key[n]  = KeyOf(&s->core->grid, side ? pair->b : pair->a, c->node[k].ijk);
      at[n++] = 2 * k + side;
    }
  PetscCall(PetscSortIntWithArray(n, key, at));
  for (PetscInt k = 0; k < n; k++) {
    MPMContactNode *q    = &c->node[at[k] / 2];
    const MPMPair  *pair = &c->pair[q->pair];

    if (!k || key[k] != key[k - 1])
      c->site[c->nsites++] = (MPMContactSite){.copy = at[k] % 2 ? pair->b : pair->a,
                                              .ijk  = {q->ijk[0], q->ijk[1], q->ijk[2]}};
    q->site[at[k] % 2] = c->nsites - 1;
  }
  PetscCall(PetscFree2(key, at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lets a particle tell the nodes of contact of its stencil its part of the weights, and where its matter ends. */
static PetscErrorCode Tell(Search *s, PetscInt pair, int side, PetscInt p)
{
  const MPMCore *core  = s->core;
  const MPMGrid *grid  = &core->grid;
  const PetscInt dim   = grid->dim;
  const PetscInt rigid = -1 - s->c->pair[pair].a;
  PetscReal      F[9], units, V[3], own[3] = {0}, from = 0;
  PetscInt       at[3];
  Stencil        t;

  PetscFunctionBeginUser;
  SetStencil(s, p, &t);
  if (rigid >= 0) {
    const PetscReal *x = s->view.x + p * dim;

    from = MPMRigidDistance(&core->rigids.body[rigid], dim, x, own);
    MPMRigidVelocity(&core->rigids.body[rigid], dim, x, V);
  }
  units = -MPMKindOf(core->params.kinds, &s->view, p)->V0 / UNIT * MPMMatterDeformation(core, &s->view, p, F);
  for (PetscInt d = 0; d < dim; d++) units /= grid->h[d];
  FOR_STENCIL(&t, at)
  {
    PetscReal       part = 0, aside[3] = {0}, n[3] = {0}, end = 0, h = 0;
    PetscInt        ijk[3], k;
    MPMContactNode *q;

    SetIjk(grid, &t, at, ijk);
    PetscCall(PetscFindInt(KeyOf(grid, pair, ijk), s->c->nnodes, s->key, &k));
    if (k < 0) continue;
    q = &s->c->node[s->at[k]];
    for (PetscInt d = 0; d < dim; d++) {
      PetscReal       phi = 1;
      const PetscReal by  = t.xi[d] - (PetscReal)(t.base[d] + at[d]);

      n[d] = side ? q->n[d] : -q->n[d];
      for (PetscInt e = 0; e < dim; e++) phi *= e == d ? t.g[e][at[e]] : t.w[e][at[e]];
      part += phi * n[d];
      end += by * grid->h[d] * n[d];
      h = PetscMax(h, grid->h[d]);
      for (PetscInt e = 0; e < dim; e++)
        if (e != d) aside[e] = PetscMax(aside[e], PetscAbsReal(by));
    }
    q->weight[side] += (PetscInt64)PetscMax(-MOST, PetscMin(MOST, units * part));
    if (rigid >= 0) /* by the distance and the normal where the particle is */
      end = PetscMin(from - MPMMatterReaches(core, &s->view, p, F, own, h),
                     MPMMatterArrives(core, &s->view, p, own, V));
    else
      end -= MPMMatterReaches(core, &s->view, p, F, n, h);
    for (PetscInt d = 0; d < dim; d++)
      if (aside[d] < 0.5 + TIE) q->near[side][d] = PetscMin(q->near[side][d], end);
    q->wide[side] = PetscMin(q->wide[side], end);
    if (rigid < 0) continue;
    end = PetscMax(0, end);
    for (PetscInt d = 0; d < dim; d++) end -= core->params.dt * V[d] * own[d];
    for (PetscInt d = 0; d < dim; d++)
      if (aside[d] < 0.5 + TIE) q->room[d] = PetscMin(q->room[d], end);
    q->room[3] = PetscMin(q->room[3], end);
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
  PetscCall(PetscMalloc2(2 * c->nnodes, &weight, 12 * c->nnodes, &end));
  for (PetscInt k = 0; k < c->nnodes; k++) {
    for (PetscInt d = 0; d < 4; d++) end[12 * k + 8 + d] = c->node[k].room[d];
    for (int side = 0; side < 2; side++) {
      weight[2 * k + side] = c->node[k].weight[side];
      for (PetscInt d = 0; d < 3; d++) end[12 * k + 4 * side + d] = c->node[k].near[side][d];
      end[12 * k + 4 * side + 3] = c->node[k].wide[side];
    }
  }
  PetscCall(PetscMPIIntCast(12 * c->nnodes, &count));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, weight, count / 6, MPIU_INT64, MPI_SUM, s->core->exchange.data));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, end, count, MPIU_REAL, MPI_MIN, s->core->exchange.data));
  for (PetscInt k = 0; k < c->nnodes; k++) {
    for (PetscInt d = 0; d < 4; d++) c->node[k].room[d] = end[12 * k + 8 + d];
    for (int side = 0; side < 2; side++) {
      c->node[k].weight[side] = weight[2 * k + side];
      for (PetscInt d = 0; d < 3; d++) c->node[k].near[side][d] = end[12 * k + 4 * side + d];
      c->node[k].wide[side] = end[12 * k + 4 * side + 3];
    }
  }
  PetscCall(PetscFree2(weight, end));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* --- Columns ------------------------------------------------------------------------------------------------------ */

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

/* Makes the parts of the nodes: a node is in the columns along all axes to which its normal inclines, by what the square of the
   normal's component is above INCLINES, so that the parts add up to its weight. A column that goes along a surface would
   have places of it that are far apart. */
static PetscErrorCode MakeParts(MPMContacts *c, PetscInt dim)
{
  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(dim * c->nnodes + 1) * sizeof *c->part, &c->part));
  PetscCall(PetscRealloc((size_t)(dim * c->nnodes + 1) * sizeof *c->column, &c->column));
  for (PetscInt k = 0; k < c->nnodes; k++) {
    const MPMContactNode *q   = &c->node[k];
    PetscReal             all = 0;

    if (c->pair[q->pair].glued) continue;
    if (c->pair[q->pair].flows) { /* a mean of the surface would let single particles through */
      PetscInt axis = 0;

      for (PetscInt d = 1; d < dim; d++)
        if (PetscSqr(q->n[d]) > PetscSqr(q->n[axis]) + TIE) axis = d;
      c->part[c->nparts++] = (MPMContactPart){
          .node = k, .pair = q->pair, .axis = axis, .side = q->n[axis] > 0, .share = {1, 1}};
      continue;
    }
    for (PetscInt d = 0; d < dim; d++) all += PetscMax(0, PetscSqr(q->n[d]) - INCLINES);
    for (PetscInt d = 0; d < dim; d++) {
      MPMContactPart *to = &c->part[c->nparts];

      if (!(PetscSqr(q->n[d]) > INCLINES)) continue;
      *to = (MPMContactPart){.node = k, .pair = q->pair, .axis = d, .side = q->n[d] > 0};
      for (int side = 0; side < 2; side++)
        to->share[side] = (PetscSqr(q->n[d]) - INCLINES) / all * (PetscReal)PetscMax(0, q->weight[side]);
      if (to->share[0] > 0 || to->share[1] > 0) c->nparts++;
    }
  }
  nodes_to_sort = c->node;
  qsort(c->part, (size_t)c->nparts, sizeof *c->part, InOrder);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets where a column acts on a rigid body: on the surface, at the mean of its nodes by their shares. */
static void SetPlace(const MPMCore *core, MPMContactColumn *to)
{
  const MPMContacts *c    = core->contacts;
  const MPMGrid     *grid = &core->grid;
  PetscReal          n[3] = {0}, distance;

  for (PetscInt k = to->first; k < to->last; k++)
    for (PetscInt d = 0; d < grid->dim; d++)
      to->at[d] += c->part[k].share[1] * (grid->lower[d] + (PetscReal)c->node[c->part[k].node].ijk[d] * grid->h[d]);
  distance = MPMRigidDistance(&core->rigids.body[-1 - c->pair[to->pair].a], grid->dim, to->at, n);
  for (PetscInt d = 0; d < grid->dim; d++) to->at[d] -= distance * n[d];
}

/* Sets normal and gap of a column, and the shares of its parts; returns false if it has no matter on one side. */
static PetscBool SetColumn(const MPMCore *core, MPMContactColumn *to)
{
  const PetscReal dt     = core->params.dt;
  MPMContacts    *c      = core->contacts;
  const PetscInt  axis   = c->part[to->first].axis;
  PetscReal       all[2] = {0}, size = 0, room = PETSC_INFINITY, V[3];

  for (PetscInt k = to->first; k < to->last; k++)
    for (int side = 0; side < 2; side++) all[side] += c->part[k].share[side];
  if (c->pair[to->pair].a < 0) all[0] = 1;
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
  for (PetscInt k = to->first; k < to->last && !(to->gap < PETSC_INFINITY); k++) {
    const MPMContactNode *q = &c->node[c->part[k].node];

    to->gap = PetscMin(to->gap, q->wide[0] + q->wide[1]);
    room    = PetscMin(room, q->room[3]);
  }
  for (PetscInt d = 0; d < 3; d++) size += PetscSqr(to->n[d]);
  if (!(size > 0)) return PETSC_FALSE;
  for (PetscInt d = 0; d < 3; d++) to->n[d] /= PetscSqrtReal(size);
  if (c->pair[to->pair].flows && to->gap < 0) to->gap *= PUSH;
  to->least = dt > 0        ? -(c->pair[to->pair].flows ? to->gap : PetscMax(0, to->gap)) / dt
              : to->gap > 0 ? -PETSC_INFINITY
                            : 0; /* dt 0: no step yet */
  if (c->pair[to->pair].a >= 0) return PETSC_TRUE;
  SetPlace(core, to);
  MPMRigidVelocity(&core->rigids.body[-1 - c->pair[to->pair].a], core->grid.dim, to->at, V);
  if (dt > 0) to->least = -room / dt;
  for (PetscInt d = 0; d < core->grid.dim && dt > 0; d++) to->least -= V[d] * to->n[d];
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

/* Marks the nodes around a node of contact, of both copies, in the patch's arrays, across periodic faces too. */
static void MarkNode(const MPMPatch *patch, const MPMPair *pair, const MPMContactNode *node, char held[])
{
  const MPMGrid *grid = patch->grid;

  for (PetscInt q = pair->a < 0 ? 27 : 0; q < 54; q++) {
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
  const PetscInt nodes  = MPMPatchNodes(&core->exchange.patch);
  Search         s      = {.core = core, .c = core->contacts};
  PetscBool      any    = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < core->params.nkinds; k++) {
    const MPMKind *kind = &core->params.kinds[k];
    PetscReal      full = 1;

    for (PetscInt d = 0; d < core->grid.dim; d++) full *= 0.5 / kind->l[d];
    for (PetscInt q = 0; q < s.c->npairs && !MPMMaterialKeepsShape(&core->params.materials[kind->material]); q++)
      if (s.c->pair[q].a >= 0 && (s.c->pair[q].a == kind->copy || s.c->pair[q].b == kind->copy))
        s.c->pair[q].flows = PETSC_TRUE;
    s.full[kind->copy] = PetscMax(s.full[kind->copy], full);
  }
  s.c->nnodes = s.c->nsites = s.c->nparts = s.c->ncolumns = 0;
  PetscCall(PetscFree(core->exchange.light.held));
  for (PetscInt d = 0; d < core->grid.dim; d++)
    s.reach = PetscMax(s.reach, (0.5 * MPMBasisNodes(core->basis) + 1) * core->grid.h[d]);
  PetscCall(FindTiles(&s, &any));
  if (any || core->rigids.n) {
    PetscCall(MPMParticlesGetView(&core->particles, fields, &s.view));
    if (any) PetscCall(FindCells(&s));
    PetscCall(ListAll(&s, any));
    PetscCall(PetscCalloc1(nodes, &s.map));
    for (PetscInt pair = 0; pair < s.c->npairs; pair++) {
      const PetscInt before = s.nfits;

      for (int side = 0; side < 2; side++) PetscCall(ForParticles(&s, pair, side, AddToFits));
      if (s.nfits > before) PetscCall(PetscArrayzero(s.map, nodes));
    }
    PetscCall(CollectFits(&s));
    PetscCall(FindNormals(&s));
    PetscCall(MakeNodes(&s));
    for (PetscInt pair = 0; pair < s.c->npairs; pair++)
      for (int side = 0; side < 2; side++) PetscCall(ForParticles(&s, pair, side, Tell));
    PetscCall(CollectEnds(&s));
    PetscCall(MakeSites(&s));
    PetscCall(MakeParts(s.c, core->grid.dim));
    SetColumns(core);
    if (core->params.light > 0) PetscCall(MarkTouching(&s));
    PetscCall(PetscFree(s.key));
    PetscCall(PetscFree(s.at));
    PetscCall(PetscFree(s.normal));
    PetscCall(PetscFree(s.wanted));
    PetscCall(PetscFree(s.first));
    PetscCall(PetscFree(s.faces));
    PetscCall(PetscFree(s.map));
    PetscCall(PetscFree(s.fit));
    PetscCall(MPMParticlesRestoreView(&core->particles, fields, &s.view));
  }
  PetscCall(PetscFree(s.cells));
  PetscCall(PetscFree(s.tiles));
  PetscFunctionReturn(PETSC_SUCCESS);
}
